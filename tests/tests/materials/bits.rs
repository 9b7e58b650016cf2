//! The same bits with all kinds of materials and rules in play: executors, caches, snapshots, hostile bytes.

use cellstep::math::{Rotation, Vec3};
use cellstep::{
    BodyDef, BodyHandle, BodyKind, Capacities, Executor, Geometry, MaterialTraits, Mix, PairMaterial, Pool,
    Position, Serial, Settings, ShapeDef, ShapeHandle,
};
use cellstep_tests::executors::{Random, Shuffled};
use cellstep_tests::fuzzing;
use cellstep_tests::simulator::snapshot;
use cellstep_tests::worlds::{self, OwnedWorld, add};

const STEPS: u32 = 240;
const BODIES: u32 = 360;

/// A few hundred bodies that fall on belts and one-way plates, and what a game does to them.
struct Play {
    random: Random,
    bodies: Vec<BodyHandle>,
    shapes: Vec<ShapeHandle>,
}

fn empty() -> OwnedWorld {
    worlds::world_with(Capacities { materials: 40, pair_rules: 30, ..Capacities::for_bodies(BODIES + 20) })
}

impl Play {
    fn new(seed: u64) -> (Self, OwnedWorld) {
        let mut world = empty();
        world.set_settings(&Settings { sleep_time: 0.4, ..Settings::default() }).expect("in range");
        let mut play = Self { random: Random::new(seed), bodies: Vec::new(), shapes: Vec::new() };
        worlds::ground(&mut world, 0.5);
        for i in 0..8 {
            let place = Vec3::new((i % 4) as f32 * 2.0, (i / 4) as f32 * 4.0, 0.6 + 0.3 * (i % 3) as f32);
            let kind = if i == 5 { BodyKind::Kinematic } else { BodyKind::Static };
            let def = BodyDef { rotation: play.tilt(), ..BodyDef::new(kind, place) };
            let traits = play.traits();
            let half_extents = Vec3::new(1.2, 1.8, 0.1);
            let shape = ShapeDef { traits, ..ShapeDef::new(Geometry::Box { half_extents }) };
            play.shapes.push(add(&mut world, &def, &shape).1);
        }
        for i in 0..BODIES {
            let (x, y, z) = (i % 10, i / 10 % 10, i / 100);
            let place = Vec3::new(x as f32, y as f32, z as f32 + 2.0) * 0.7;
            let geometry = match i % 4 {
                0 => Geometry::Sphere { radius: 0.25 },
                1 => Geometry::Box { half_extents: Vec3::new(0.3, 0.15, 0.2) },
                2 => Geometry::Cylinder { half_height: 0.2, radius: 0.2 },
                _ => Geometry::Capsule { half_height: 0.2, radius: 0.12 },
            };
            let traits = play.traits();
            let def = BodyDef { rotation: play.tilt(), ..BodyDef::new(BodyKind::Dynamic, place) };
            let (body, shape) = add(&mut world, &def, &ShapeDef { traits, ..ShapeDef::new(geometry) });
            play.bodies.push(body);
            play.shapes.push(shape);
        }
        (play, world)
    }

    fn tilt(&mut self) -> Rotation {
        let mut turn = || self.random.between(-0.2, 0.2);
        Rotation::from_rotation_vector(Vec3::new(turn(), turn(), turn()))
    }

    /// One of some twenty materials.
    fn traits(&mut self) -> MaterialTraits {
        let mut traits = MaterialTraits::default();
        match self.random.below(10) {
            0 | 1 => traits.rolling = [0.01, 0.1][self.random.below(2) as usize],
            2 => (traits.rolling, traits.spinning) = (0.02, 0.02),
            3 => traits.spinning = 0.05,
            4 => traits.surface_velocity = Vec3::new(1.0, 0.5, 0.0),
            5 => (traits.surface_velocity, traits.rolling) = (Vec3::new(-0.7, 0.0, 0.2), 0.01),
            6 => traits.one_way = Some(Vec3::Z),
            7 => traits.friction_mix = [Mix::Min, Mix::Max, Mix::Mean][self.random.below(3) as usize],
            8 => traits.restitution_mix = [Mix::Min, Mix::Multiply][self.random.below(2) as usize],
            _ => {}
        }
        traits
    }

    fn shape(&mut self) -> ShapeHandle {
        self.shapes[self.random.below(self.shapes.len() as u64) as usize]
    }

    fn body(&mut self) -> BodyHandle {
        self.bodies[self.random.below(self.bodies.len() as u64) as usize]
    }

    /// What a game does between steps. Refused calls are part of it.
    fn change(&mut self, world: &mut OwnedWorld, step: u32) {
        if !(60..=200).contains(&step) {
            return;
        }
        match self.random.below(8) {
            0 => {
                let (shape, traits) = (self.shape(), self.traits());
                let _ = world.set_material_traits(shape, &traits);
            }
            1 | 2 => {
                let (a, b) = (self.shape(), self.shape());
                let friction = (self.random.below(2) == 0).then(|| self.random.between(0.0, 1.0));
                let restitution = (self.random.below(2) == 0).then(|| self.random.between(0.0, 1.0));
                let _ = world.set_pair_material(a, b, &PairMaterial { friction, restitution });
            }
            3 => {
                let (a, b) = (self.body(), self.body());
                let _ = world.ignore_until_separated(a, b);
                let touching = world.contacts().nth(self.random.below(100) as usize).map(|c| c.bodies);
                if let Some([a, b]) = touching {
                    let _ = world.ignore_until_separated(a, b);
                }
            }
            4 if step.is_multiple_of(5) => {
                let body = self.body();
                let place = Position::at(Vec3::new(self.random.between(0.0, 6.0), 3.0, 4.0));
                let _ = world.set_pose(body, place, Rotation::IDENTITY);
            }
            5 if step.is_multiple_of(10) => {
                let _ = world.remove_shape(self.shape());
            }
            6 => {
                let push = Vec3::new(self.random.between(-50.0, 50.0), 10.0, 60.0);
                let _ = world.apply_impulse(self.body(), push);
            }
            _ => {}
        }
    }
}

/// States after every step.
fn states(executor: &mut impl Executor, mut before: impl FnMut(&mut OwnedWorld, u32)) -> Vec<u64> {
    let (mut play, mut world) = Play::new(5);
    (0..STEPS)
        .map(|step| {
            before(&mut world, step);
            play.change(&mut world, step);
            let report = world.step(executor);
            assert_eq!((report.quarantined, report.dropped), (0, 0), "step {step}");
            world.checksum()
        })
        .collect()
}

/// Goes to sleep, passes platforms, resists: what the scene has to have for the tests below to mean something.
#[test]
fn the_scene_has_everything_in_play() {
    let (mut play, mut world) = Play::new(5);
    let (mut resists, mut asleep, mut ignored) = (0, 0, 0);
    for step in 0..STEPS {
        play.change(&mut world, step);
        let report = world.step(&mut Serial);
        resists += u32::from(world.contacts().any(|contact| contact.resistance != Vec3::ZERO));
        asleep = asleep.max(report.asleep);
        ignored += world
            .contacts()
            .take(300)
            .filter(|c| world.ignores(c.bodies[0], c.bodies[1]) == Ok(true))
            .count();
    }
    assert!(resists > 100, "{resists}");
    assert!(asleep > 10, "{asleep}");
    assert_eq!(ignored, 0, "bodies that ignore each other have a contact");
}

#[test]
fn executors_and_caches_change_no_bit() {
    let expected = states(&mut Serial, |_, _| {});
    for seed in 0..3 {
        assert!(states(&mut Shuffled::new(seed), |_, _| {}) == expected, "seed {seed}");
    }
    for workers in [1, 2, 3, 8] {
        let mut pool = Pool::new(workers).expect("threads can be started");
        assert!(states(&mut pool, |_, _| {}) == expected, "{workers} workers");
    }
    let dropped = states(&mut Serial, |world, step| {
        if step % 3 == 0 {
            world.drop_caches();
        }
    });
    assert!(dropped == expected, "dropped caches");
    let restored = states(&mut Serial, |world, _| {
        let bytes = snapshot(world);
        world.restore(&bytes).expect("its own snapshot");
    });
    assert!(restored == expected, "restored at every step");
}

#[test]
fn another_world_loads_each_state_and_goes_the_same_way() {
    let (mut play, mut world) = Play::new(6);
    let mut other = empty();
    for step in 0..STEPS {
        play.change(&mut world, step);
        let bytes = snapshot(&world);
        assert_eq!(other.load(&bytes), Ok(()), "step {step}");
        world.step(&mut Serial);
        other.step(&mut Serial);
        assert!(world.state() == other.state(), "step {step}");
    }
}

/// Damaged snapshots are refused, or step without a panic.
#[test]
fn damaged_states_are_refused_or_step() {
    let (mut play, mut world) = Play::new(7);
    let mut sources = Vec::new();
    for step in 0..160 {
        play.change(&mut world, step);
        world.step(&mut Serial);
        if step % 20 == 19 {
            sources.push(snapshot(&world));
        }
    }
    let mut random = Random::new(3);
    let mut other = empty();
    let (mut taken, mut refused) = (0, 0);
    for i in 0..1200 {
        let mut bytes = sources[i % sources.len()].clone();
        // Materials and rules stand at the end; half of the damage is there.
        let tail = 30 * 24 + 40 * 40;
        let from = if i % 2 == 0 { bytes.len() - tail } else { fuzzing::SNAPSHOT_HEADER };
        for _ in 0..=random.below(2) {
            let at = from + random.below((bytes.len() - from) as u64) as usize;
            bytes[at] ^= 1 << random.below(8);
        }
        match other.load(&bytes) {
            Ok(()) => {
                taken += 1;
                assert!(snapshot(&other)[fuzzing::SNAPSHOT_HEADER..] == bytes[fuzzing::SNAPSHOT_HEADER..]);
                for _ in 0..3 {
                    other.step(&mut Serial);
                }
            }
            Err(_) => refused += 1,
        }
    }
    println!("{taken} taken, {refused} refused");
    assert!(taken > 100 && refused > 300, "{taken} taken, {refused} refused");
}
