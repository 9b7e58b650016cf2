//! The same bits over 2,000 steps in which bodies come, go and change, for any executor and whatever is forgotten.
//!
//! Some 250 boxes, balls, capsules and hulls lie in a pit. In most steps some are removed and others dropped in;
//! kinds, geometries, poses, masses, materials and settings change, and some steps are ordered by somebody else.
//! Adding or removing drops all caches, so every fifth stretch of steps leaves the set of bodies alone and only
//! pushes them.

use cellstep::math::{Pose, Rotation, Vec3};
use cellstep::{
    BodyDef, BodyHandle, BodyKind, Capacities, Executor, Geometry, HullHandle, MassProperties, Pool,
    Position, Serial, Settings, ShapeDef, ShapeHandle, StepReport,
};
use cellstep_tests::executors::{Random, Shuffled};
use cellstep_tests::schedules::{self, Given};
use cellstep_tests::simulator::snapshot;
use cellstep_tests::worlds::{self, OwnedWorld};
use std::sync::OnceLock;

const STEPS: u32 = 2_000;
/// Dynamic bodies that are aimed at.
const BODIES: usize = 250;
const CAPACITIES: Capacities =
    Capacities { pairs: 9_600, contacts: 4_800, hulls: 2, ..Capacities::for_bodies(BODIES as u32 + 20) };
/// Steps of a stretch.
const STRETCH: u32 = 20;
/// More phases than these are never needed here.
const PHASES_MAX: u32 = 5;

/// A world, and who changes it. Everything follows from the seed.
struct Churn {
    random: Random,
    bodies: Vec<(BodyHandle, ShapeHandle)>,
    step: u32,
}

/// An empty world with the hulls.
fn empty() -> OwnedWorld {
    let mut world = worlds::world_with(CAPACITIES);
    let wedge = [[-0.3, -0.3, -0.1], [0.3, -0.3, -0.1], [0.3, 0.3, -0.1], [-0.3, 0.3, -0.1], [0.0, 0.0, 0.3]];
    world.add_hull(&wedge.map(Vec3::from)).expect("a pyramid is a hull");
    let prism: [Vec3; 12] = core::array::from_fn(|i| {
        let turn = (i / 2) as f32 * cellstep::math::PI / 3.0;
        let z = if i % 2 == 0 { -0.15 } else { 0.15 };
        Vec3::new(0.3 * cellstep::math::cos(turn), 0.3 * cellstep::math::sin(turn), z)
    });
    world.add_hull(&prism).expect("a prism is a hull");
    world
}

impl Churn {
    /// The pit with its first bodies.
    fn new() -> (Self, OwnedWorld) {
        let mut world = empty();
        worlds::ground(&mut world, 0.5);
        for (x, y) in [(2.3, 0.0), (-2.3, 0.0), (0.0, 2.3), (0.0, -2.3)] {
            let wall = BodyDef::new(BodyKind::Static, Vec3::new(x, y, 2.0));
            let half_extents =
                Vec3::new(if x == 0.0 { 3.5 } else { 0.25 }, if y == 0.0 { 3.5 } else { 0.25 }, 2.0);
            worlds::add(&mut world, &wall, &ShapeDef::new(Geometry::Box { half_extents }));
        }
        let mut churn = Self { random: Random::new(2_000), bodies: Vec::new(), step: 0 };
        for i in 0..BODIES {
            let (column, row, layer) = (i % 6, i / 6 % 6, i / 36);
            let place = Vec3::new(column as f32, row as f32, layer as f32) * 0.65;
            churn.add(&mut world, place + Vec3::new(-1.6, -1.6, 0.4));
        }
        (churn, world)
    }

    fn add(&mut self, world: &mut OwnedWorld, place: Vec3) {
        let def = BodyDef { rotation: self.rotation(), ..BodyDef::new(BodyKind::Dynamic, place) };
        let shape = ShapeDef {
            friction: self.random.between(0.2, 0.9),
            restitution: if self.random.below(10) == 0 { 0.4 } else { 0.0 },
            ..ShapeDef::new(self.geometry())
        };
        self.bodies.push(worlds::add(world, &def, &shape));
    }

    /// What happens before the next step.
    fn change(&mut self, world: &mut OwnedWorld) {
        self.step += 1;
        if self.step / STRETCH % 5 != 4 {
            self.replace(world);
        }
        let of_bodies = self.random.below(3);
        for _ in 0..of_bodies {
            self.push(world);
        }
        // A world that stands still does so for one step.
        if world.settings().dt == 0.0 || self.random.below(50) == 0 {
            let dt = [1.0 / 60.0, 1.0 / 60.0, 1.0 / 120.0, 0.0][self.random.below(4) as usize];
            let substeps = 2 + self.random.below(4) as u32;
            let block_links = [16, 64][self.random.below(2) as usize];
            let settings = Settings { dt, substeps, block_links, ..Settings::default() };
            world.set_settings(&settings).expect("in range");
        }
    }

    /// Takes the next step; a few by another ordering than the kept one.
    fn step(&mut self, world: &mut OwnedWorld, executor: &mut impl Executor) -> StepReport {
        if self.random.below(40) == 0 {
            world.step_scheduled(executor, &mut Given::new(schedules::natural))
        } else {
            world.step(executor)
        }
    }

    /// Removes some bodies and adds others; changes some so much that their contacts begin anew.
    fn replace(&mut self, world: &mut OwnedWorld) {
        for _ in 0..=self.random.below(2) {
            let index = self.random.below(self.bodies.len() as u64) as usize;
            let (body, _) = self.bodies.swap_remove(index);
            world.remove_body(body).expect("the body exists");
        }
        while self.bodies.len() < BODIES {
            let place = self.above();
            self.add(world, place);
        }
        let (body, shape) = self.any();
        match self.random.below(16) {
            0 => {
                let kind = if self.random.below(2) == 0 { BodyKind::Kinematic } else { BodyKind::Static };
                world.set_kind(body, kind).expect("the body exists");
            }
            1..3 => world.set_kind(body, BodyKind::Dynamic).expect("convex bodies may be dynamic"),
            3..5 => {
                let pose = Pose::new(self.vector(0.05), Rotation::IDENTITY);
                world.set_geometry(shape, &self.geometry(), &pose).expect("convex");
            }
            5 => {
                let (place, rotation) = (Position::at(self.above()), self.rotation());
                world.set_pose(body, place, rotation).expect("near the origin");
            }
            _ => {}
        }
    }

    /// Changes that leave contacts and caches alone.
    fn push(&mut self, world: &mut OwnedWorld) {
        let (body, shape) = self.any();
        let dynamic = world.kind(body) == Ok(BodyKind::Dynamic);
        match self.random.below(8) {
            0 => {
                let (friction, bounce) = (self.random.between(0.0, 1.0), self.random.between(0.0, 0.3));
                world.set_material(shape, friction, bounce).expect("in range");
            }
            1 => {
                let mass = self.random.between(10.0, 200.0);
                let properties = MassProperties {
                    mass,
                    center: self.vector(0.05),
                    inertia: Vec3::new(0.02, 0.025, 0.03) * mass,
                    axes: self.rotation(),
                };
                let given = (self.random.below(2) == 0).then_some(properties);
                world.set_mass(body, given.as_ref()).expect("in range");
            }
            2 if dynamic => {
                let impulse = self.vector(150.0);
                world.apply_impulse(body, impulse).expect("dynamic");
            }
            3 => {
                let density = self.random.between(200.0, 2_000.0);
                world.set_density(shape, density).expect("in range");
            }
            4 if dynamic => {
                let velocity = self.vector(2.0);
                world.set_angular_velocity(body, velocity).expect("not static");
            }
            _ => {}
        }
    }

    fn any(&mut self) -> (BodyHandle, ShapeHandle) {
        self.bodies[self.random.below(self.bodies.len() as u64) as usize]
    }

    fn vector(&mut self, size: f32) -> Vec3 {
        let mut component = || self.random.between(-size, size);
        Vec3::new(component(), component(), component())
    }

    fn rotation(&mut self) -> Rotation {
        Rotation::from_rotation_vector(self.vector(3.0))
    }

    /// A place above the pile.
    fn above(&mut self) -> Vec3 {
        self.vector(1.6) + Vec3::new(0.0, 0.0, 5.5)
    }

    fn geometry(&mut self) -> Geometry {
        let size = self.random.between(0.15, 0.3);
        match self.random.below(10) {
            0..2 => Geometry::Sphere { radius: size },
            2..4 => Geometry::Capsule { half_height: size, radius: 0.6 * size },
            4..8 => Geometry::Box { half_extents: Vec3::new(size, 0.2, 0.8 * size) },
            index => Geometry::Hull(HullHandle(index as u32 - 8)),
        }
    }
}

/// Checksums of all sections of the state.
type Sums = Vec<(&'static str, u64)>;

/// Plays it all; `before` sees the world before each step. Gives the checksums after every step.
fn play(executor: &mut impl Executor, mut before: impl FnMut(&mut OwnedWorld)) -> Vec<Sums> {
    let (mut churn, mut world) = Churn::new();
    let (mut phases, mut contacts) = (0, 0_u64);
    let sums = (1..=STEPS)
        .map(|step| {
            churn.change(&mut world);
            before(&mut world);
            let report = churn.step(&mut world, executor);
            assert_eq!((report.dropped, report.quarantined), (0, 0), "step {step}");
            assert!(report.phases <= PHASES_MAX, "{} phases in step {step}", report.phases);
            phases = phases.max(report.phases);
            contacts += u64::from(report.contacts);
            world.checksum_by_section().collect()
        })
        .collect();
    println!("at most {phases} phases, {} contacts in a step", contacts / u64::from(STEPS));
    assert!(contacts > 300 * u64::from(STEPS), "the bodies lie in a pile");
    sums
}

/// That of one thread, made once.
fn serial() -> &'static [Sums] {
    static SUMS: OnceLock<Vec<Sums>> = OnceLock::new();
    SUMS.get_or_init(|| play(&mut Serial, |_| {}))
}

/// Names the first step and the sections in which a run went another way.
fn assert_same(run: &str, sums: &[Sums]) {
    for (step, (found, expected)) in sums.iter().zip(serial()).enumerate() {
        let differ = found.iter().zip(expected).filter(|(a, b)| a != b).map(|(a, _)| a.0);
        let differ: Vec<&str> = differ.collect();
        assert!(differ.is_empty(), "{run}: another state after step {}: {differ:?}", step + 1);
    }
    assert_eq!(sums.len(), STEPS as usize);
}

#[test]
fn order_of_tasks_changes_no_bit() {
    for seed in 0..2 {
        assert_same("shuffled", &play(&mut Shuffled::new(seed), |_| {}));
    }
}

#[test]
fn number_of_workers_changes_no_bit() {
    for workers in [1, 2, 3, 8, 16] {
        let mut pool = Pool::new(workers).expect("threads can be started");
        assert_same(&format!("{workers} workers"), &play(&mut pool, |_| {}));
    }
}

#[test]
fn dropped_caches_change_no_bit() {
    let mut random = Random::new(1);
    let sums = play(&mut Serial, |world| {
        if random.below(3) == 0 {
            world.drop_caches();
        }
    });
    assert_same("caches dropped", &sums);
}

/// Back after some steps that did not count; at times the snapshot goes to another world.
#[test]
fn snapshots_change_no_bit() {
    let mut random = Random::new(2);
    let (mut restored, mut loaded) = (0, 0);
    let sums = play(&mut Serial, |world| {
        if random.below(12) != 0 {
            return;
        }
        let mut saved = snapshot(world);
        for _ in 0..random.below(3) {
            world.step(&mut Serial);
        }
        if random.below(2) == 0 {
            world.restore(&saved).expect("its own snapshot");
            restored += 1;
        } else {
            OwnedWorld::seal(&mut saved).expect("a snapshot");
            *world = empty();
            world.load(&saved).expect("a state that steps made");
            loaded += 1;
        }
    });
    assert!(restored > 50 && loaded > 50, "{restored} {loaded}");
    assert_same("saved and restored", &sums);
}
