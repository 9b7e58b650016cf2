//! What is told is what changed: events of random worlds against the difference of what the world says before and
//! after each step.

use cellstep::{
    BodyHandle, Capacities, Command, Event, EventKind, JointHandle, Serial, ShapeEvents, ShapeHandle,
    Touching, Visit,
};
use cellstep_tests::simulator::{self, EVENTFUL, Simulator};
use cellstep_tests::worlds::OwnedWorld;
use std::collections::{BTreeMap, BTreeSet};

const SEEDS: u64 = 160;
const STEPS: u32 = 300;

type Pair = ([ShapeHandle; 2], [BodyHandle; 2]);

/// What a world says.
#[derive(Clone, Debug, Default)]
struct Facts {
    touching: BTreeSet<Pair>,
    visits: BTreeSet<[(u32, u32); 4]>,
    asleep: BTreeSet<BodyHandle>,
    quarantined: BTreeSet<BodyHandle>,
    broken: BTreeSet<JointHandle>,
}

fn visit_key(visit: &Visit) -> [(u32, u32); 4] {
    let Visit { sensor, visitor, sensor_body, visitor_body } = *visit;
    [
        (sensor.index, sensor.generation),
        (visitor.index, visitor.generation),
        (sensor_body.index, sensor_body.generation),
        (visitor_body.index, visitor_body.generation),
    ]
}

impl Facts {
    fn of(world: &OwnedWorld, shapes: &BTreeSet<ShapeHandle>) -> Self {
        let contacts = world.contacts().chain(world.sleeping_contacts());
        let visits = shapes.iter().filter_map(|&shape| world.visits(shape).ok()).flatten();
        let bodies = || world.bodies();
        Self {
            touching: contacts.map(|contact| (contact.shapes, contact.bodies)).collect(),
            visits: visits.map(|visit| visit_key(&visit)).collect(),
            asleep: bodies().filter(|&body| world.is_asleep(body) == Ok(true)).collect(),
            quarantined: bodies().filter(|&body| world.is_quarantined(body) == Ok(true)).collect(),
            broken: world.joints().filter(|&joint| world.is_broken(joint) == Ok(true)).collect(),
        }
    }
}

/// Events by kind, each a list in the order in which they were told.
#[derive(Debug, Default, PartialEq)]
struct Told {
    woke: Vec<BodyHandle>,
    ended: Vec<Pair>,
    began: Vec<Pair>,
    broken: Vec<JointHandle>,
    quarantined: Vec<BodyHandle>,
    left: Vec<[(u32, u32); 4]>,
    came: Vec<[(u32, u32); 4]>,
    slept: Vec<BodyHandle>,
    hits: usize,
}

fn pair(touching: &Touching) -> Pair {
    (touching.shapes, touching.bodies)
}

impl Told {
    fn of(events: impl Iterator<Item = Event>, step: u64) -> Self {
        let (mut told, mut last) = (Self::default(), 0);
        for event in events {
            assert_eq!(event.step, step);
            let rank = match event.kind {
                EventKind::Woke(body) => {
                    told.woke.push(body);
                    1
                }
                EventKind::ContactEnded(touching) => {
                    told.ended.push(pair(&touching));
                    2
                }
                EventKind::ContactBegan(touching) => {
                    told.began.push(pair(&touching));
                    3
                }
                EventKind::ContactHit(_) => {
                    told.hits += 1;
                    4
                }
                EventKind::JointBroken(broken) => {
                    told.broken.push(broken.joint);
                    5
                }
                EventKind::Quarantined(body) => {
                    told.quarantined.push(body);
                    6
                }
                EventKind::SensorEnded(visit) => {
                    told.left.push(visit_key(&visit));
                    7
                }
                EventKind::SensorBegan(visit) => {
                    told.came.push(visit_key(&visit));
                    8
                }
                EventKind::Slept(body) => {
                    told.slept.push(body);
                    9
                }
                other => panic!("{other:?} is a new kind"),
            };
            assert!(rank >= last, "the order of kinds");
            last = rank;
        }
        told
    }
}

fn without<T: Ord + Copy>(a: &BTreeSet<T>, b: &BTreeSet<T>) -> Vec<T> {
    a.difference(b).copied().collect()
}

/// What the player has told the world of its shapes.
#[derive(Default)]
struct Wishes {
    shapes: BTreeSet<ShapeHandle>,
    events: BTreeMap<ShapeHandle, ShapeEvents>,
}

impl Wishes {
    fn note(&mut self, world: &OwnedWorld, commands: &[simulator::Event]) {
        for (command, outcome) in commands {
            if let Command::SetShapeEvents(shape, events) = command
                && outcome.is_ok()
            {
                self.events.insert(*shape, *events);
            }
        }
        for body in world.bodies() {
            for shape in world.shapes_of(body).expect("exists") {
                self.shapes.insert(shape);
                self.events.insert(shape, world.shape(shape).expect("exists").events);
            }
        }
    }

    fn want(&self, pair: &Pair) -> bool {
        pair.0.iter().any(|shape| self.events[shape].0 & ShapeEvents::CONTACTS.0 != 0)
    }
}

/// Plays and compares; returns how many events of each kind there were.
fn compare(seed: u64, capacities: Capacities) -> [usize; 9] {
    let (mut simulator, mut world) = Simulator::new(seed, capacities);
    let (mut before, mut wishes) = (Facts::default(), Wishes::default());
    let mut counts = [0; 9];
    for step in 0..STEPS {
        wishes.note(&world, &[]);
        let commands = simulator.play(&mut world);
        wishes.note(&world, &commands);
        // Commands may have mended what was broken or quarantined.
        let mended = Facts::of(&world, &BTreeSet::new());
        let report = world.step(&mut Serial);
        let told = Told::of(world.events(), world.steps());
        if world.settings().dt == 0.0 {
            assert_eq!(told, Told::default(), "seed {seed} step {step}");
            continue;
        }
        let mut after = Facts::of(&world, &wishes.shapes);
        // In the step in which a body is quarantined its contacts are hidden, and those of others that were.
        let stops = !told.quarantined.is_empty();
        let stopped = |pair: &&Pair| stops && pair.1.iter().any(|body| after.quarantined.contains(body));
        let kept = before.touching.iter().filter(|pair| !told.ended.contains(pair));
        let hidden: Vec<Pair> = kept.chain(&told.began).filter(stopped).copied().collect();
        after.touching.extend(hidden);
        let wanted =
            |pairs: Vec<Pair>| -> Vec<Pair> { pairs.into_iter().filter(|pair| wishes.want(pair)).collect() };
        let lives = |bodies: Vec<BodyHandle>| -> Vec<BodyHandle> {
            bodies.into_iter().filter(|&body| world.contains_body(body)).collect()
        };
        let expected = Told {
            woke: lives(without(&before.asleep, &after.asleep)),
            ended: wanted(without(&before.touching, &after.touching)),
            began: wanted(without(&after.touching, &before.touching)),
            broken: without(&after.broken, &mended.broken),
            quarantined: without(&after.quarantined, &mended.quarantined),
            left: without(&before.visits, &after.visits),
            came: without(&after.visits, &before.visits),
            slept: without(&after.asleep, &before.asleep),
            hits: told.hits,
        };
        assert_eq!(told, expected, "seed {seed} step {step}");
        let sizes = [
            told.woke.len(),
            told.ended.len(),
            told.began.len(),
            told.hits,
            told.broken.len(),
            told.quarantined.len(),
            told.left.len(),
            told.came.len(),
            told.slept.len(),
        ];
        assert_eq!(sizes.iter().sum::<usize>(), report.events as usize);
        assert_eq!((report.dropped_events, report.dropped_visits), (0, 0));
        assert_eq!(report.visits as usize, after.visits.len());
        counts.iter_mut().zip(sizes).for_each(|(sum, size)| *sum += size);
        before = after;
    }
    counts
}

#[test]
fn events_are_what_changed() {
    let mut counts = [0; 9];
    for seed in 0..SEEDS {
        let capacities = match seed % 4 {
            // Pairs and contacts are dropped.
            3 => Capacities { pairs: 40, contacts: 20, ..EVENTFUL },
            _ => EVENTFUL,
        };
        counts.iter_mut().zip(compare(seed, capacities)).for_each(|(sum, count)| *sum += count);
    }
    let [woke, ended, began, hits, broken, quarantined, left, came, slept] = counts;
    assert!(woke > 100 && slept > 100, "{counts:?}");
    assert!(ended > 1000 && began > 1000 && hits > 200, "{counts:?}");
    assert!(left > 300 && came > 300 && broken > 10, "{counts:?}");
    assert!(quarantined > 0, "{counts:?}");
    println!("{counts:?}");
}
