//! The same events whoever steps, whatever was saved and restored, and however little room there is; and events
//! change no motion.

use crate::scene::{Busy, busy};
use cellstep::math::Vec3;
use cellstep::{Event, Executor, Pool, Serial, Settings};
use cellstep_tests::executors::{Random, Shuffled};
use cellstep_tests::fuzzing;
use cellstep_tests::simulator::{self, EVENTFUL, Simulator, snapshot};
use cellstep_tests::worlds::OwnedWorld;

const STEPS: usize = 90;

fn events(world: &OwnedWorld) -> Vec<Event> {
    world.events().collect()
}

/// State and events after each step.
fn play(executor: &mut impl Executor) -> Vec<(Vec<u8>, Vec<Event>)> {
    let mut world = busy(&Busy::default());
    let step = |_| {
        let report = world.step(executor);
        assert_eq!((report.dropped_events, report.dropped_visits), (0, 0));
        (world.state().to_vec(), events(&world))
    };
    (0..STEPS).map(step).collect()
}

#[test]
fn no_executor_changes_an_event() {
    let expected = play(&mut Serial);
    let count: usize = expected.iter().map(|(_, events)| events.len()).sum();
    assert!(count > 3000, "{count}");
    for workers in [1, 2, 3, 8] {
        let mut pool = Pool::new(workers).expect("threads can be started");
        assert!(play(&mut pool) == expected, "{workers} workers");
    }
    for seed in 0..4 {
        assert!(play(&mut Shuffled::new(seed)) == expected, "seed {seed}");
    }
}

#[test]
fn what_finds_no_room_are_the_last_events_and_counted() {
    let all: Vec<Vec<Event>> = play(&mut Serial).into_iter().map(|(_, events)| events).collect();
    for room in [1, 10, 60] {
        let mut world = busy(&Busy { events: room, ..Busy::default() });
        let mut cut = 0;
        for all in &all {
            let report = world.step(&mut Serial);
            let kept = all.len().min(room as usize);
            assert_eq!(events(&world), all[..kept]);
            let counts = (report.events as usize, report.dropped_events as usize);
            assert_eq!(counts, (kept, all.len() - kept));
            cut += u32::from(all.len() > kept);
        }
        assert!(cut > 10, "room for {room}: {cut}");
    }
}

#[test]
fn events_change_no_motion() {
    let bits = |world: &OwnedWorld| -> Vec<u64> {
        let names = ["motions", "pairs", "contacts", "asleep_pairs", "asleep_contacts", "ordering", "dirt"];
        world.checksum_by_section().filter(|(name, _)| names.contains(name)).map(|(_, sum)| sum).collect()
    };
    let mut loud = busy(&Busy::default());
    let mut quiet = busy(&Busy { events: 0, ..Busy::default() });
    let mut deaf = busy(&Busy { told: false, ..Busy::default() });
    for step in 0..STEPS {
        loud.step(&mut Serial);
        let none = [quiet.step(&mut Serial), deaf.step(&mut Serial)];
        assert!(none.iter().all(|report| report.events + report.dropped_events == 0));
        assert_eq!(bits(&loud), bits(&quiet), "step {step}");
        assert_eq!(bits(&loud), bits(&deaf), "step {step}");
    }
    assert_eq!(quiet.events().count() + deaf.events().count(), 0);
}

#[test]
fn a_world_that_is_restored_at_any_step_tells_the_same() {
    let mut told = 0;
    for seed in 300..350 {
        let (mut simulator, mut world) = Simulator::new(seed, EVENTFUL);
        let (_, mut other) = Simulator::new(seed + 1000, EVENTFUL);
        for step in 0..120 {
            // Between the commands and the step, and after the step.
            let commands = simulator.play(&mut world);
            other.restore(&snapshot(&world)).expect("of such a world");
            assert_eq!(other.events().collect::<Vec<_>>(), events(&world), "seed {seed} step {step}");
            world.step(&mut Serial);
            other.step(&mut Shuffled::new(step));
            assert!(other.state() == world.state(), "seed {seed} step {step}: {commands:?}");
            assert_eq!(events(&other), events(&world));
            if step % 7 == 0 {
                world.drop_caches();
            }
            told += world.events().count();
        }
    }
    assert!(told > 2000, "{told}");
}

#[test]
fn going_back_tells_the_same_again() {
    for seed in 400..420 {
        let (mut simulator, mut world) = Simulator::new(seed, EVENTFUL);
        for _ in 0..40 {
            simulator.play(&mut world);
            world.step(&mut Serial);
        }
        let saved = snapshot(&world);
        let mut history = Vec::new();
        for _ in 0..40 {
            let commands = simulator.play(&mut world);
            world.step(&mut Serial);
            history.push((commands, world.state().to_vec(), events(&world)));
        }
        world.restore(&saved).expect("its own");
        for (commands, state, told) in &history {
            simulator::replay(&mut world, commands);
            world.step(&mut Serial);
            assert!(world.state() == state);
            assert_eq!(events(&world), *told);
        }
    }
}

#[test]
fn steps_with_events_and_sensors_allocate_nothing() {
    let mut world = busy(&Busy::default());
    let mut counts = [0; 3];
    let found = allocation_counter::measure(|| {
        for _ in 0..STEPS {
            let report = world.step(&mut Serial);
            counts[0] += report.events as usize;
            counts[1] += world.events().count();
            counts[2] += world.moved_bodies().count();
        }
    });
    assert!(counts[0] == counts[1] && counts[0] > 3000 && counts[2] > 3000, "{counts:?}");
    assert_eq!(found.count_total, 0);
}

#[test]
fn damaged_snapshots_are_refused_or_step() {
    let mut sources = Vec::new();
    for seed in 500..506 {
        let (mut simulator, mut world) = Simulator::new(seed, EVENTFUL);
        for step in 0..80 {
            simulator.play(&mut world);
            if step % 20 == 10 {
                sources.push(snapshot(&world));
            }
            world.step(&mut Serial);
            if step % 20 == 0 {
                sources.push(snapshot(&world));
            }
        }
    }
    let mut world = simulator::empty_world(EVENTFUL);
    for source in &sources {
        assert_eq!(world.load(source), Ok(()));
        assert_eq!(snapshot(&world), *source);
    }
    let mut random = Random::new(17);
    let (mut accepted, mut refused) = (0, 0);
    for _ in 0..6000 {
        let mut bytes = sources[random.below(sources.len() as u64) as usize].clone();
        // Events, tenants, visits and moved bodies are the last sections; the header is the first.
        let tail = bytes.len() as u64 / 4;
        let first = fuzzing::SNAPSHOT_HEADER as u64;
        let place = match random.below(4) {
            0 => first + random.below(240),
            _ => bytes.len() as u64 - 1 - random.below(tail),
        } as usize;
        let place = place.min(bytes.len() - 4);
        match random.below(3) {
            0 => bytes[place] ^= 1 << random.below(8),
            1 => bytes[place] = random.bits() as u8,
            _ => {
                let word = [0, 1, 2, u32::MAX, f32::NAN.to_bits(), 1 << 31][random.below(6) as usize];
                let at = place & !3;
                bytes[at..at + 4].copy_from_slice(&word.to_le_bytes());
            }
        }
        let before = world.state().to_vec();
        match world.load(&bytes) {
            Ok(()) => {
                accepted += 1;
                assert_eq!(snapshot(&world), bytes, "accepted exactly");
                assert_eq!(world.events().count(), world.events().filter(|event| event.step > 0).count());
                for _ in 0..3 {
                    world.step(&mut Serial);
                    let bodies: Vec<_> = world.bodies().collect();
                    for shape in bodies.iter().flat_map(|&body| world.shapes_of(body).expect("exists")) {
                        world.visits(shape).expect("exists").for_each(drop);
                    }
                    world.moved_bodies().for_each(drop);
                }
            }
            Err(_) => {
                refused += 1;
                assert!(world.state() == before);
            }
        }
    }
    assert!(accepted > 300 && refused > 1000, "{accepted} {refused}");
}

#[test]
fn settings_out_of_range_are_refused() {
    let mut world = busy(&Busy::default());
    let valid = world.settings();
    for hit_speed in [-0.1, f32::NAN, f32::INFINITY, 1.1e6] {
        assert!(world.set_settings(&Settings { hit_speed, ..valid }).is_err());
    }
    let events = cellstep::EventKinds(64);
    assert!(world.set_settings(&Settings { events, ..valid }).is_err());
    assert_eq!(world.settings(), valid);
    world.set_settings(&Settings { gravity: Vec3::ZERO, hit_speed: 0.0, ..valid }).expect("valid");
}
