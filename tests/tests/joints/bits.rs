//! The same bits with all kinds of joints in play: executors, caches, snapshots, and no allocation.

use cellstep::joint::axis::{TURN_X, X};
use cellstep::math::{Pose, Rotation, Vec3};
use cellstep::{
    Axis, BodyDef, BodyHandle, BodyKind, Capacities, Drive, Executor, Geometry, JointDef, JointHandle, Pool,
    Serial, Settings, ShapeDef, Spring,
};
use cellstep_tests::executors::{Random, Shuffled};
use cellstep_tests::jointed::at;
use cellstep_tests::simulator::snapshot;
use cellstep_tests::worlds::{self, OwnedWorld, add};

const STEPS: u32 = 240;
const BODIES: u32 = 400;

/// Some 400 bodies in chains and nets of all kinds of joints, which fall on the ground and on each other.
struct Play {
    random: Random,
    bodies: Vec<BodyHandle>,
    joints: Vec<JointHandle>,
}

impl Play {
    fn new() -> (Self, OwnedWorld) {
        let capacities = Capacities { joints: 2 * BODIES, ..Capacities::for_bodies(BODIES + 1) };
        let mut world = worlds::world_with(capacities);
        worlds::ground(&mut world, 0.5);
        let mut play = Self { random: Random::new(11), bodies: Vec::new(), joints: Vec::new() };
        for i in 0..BODIES {
            let (x, y, z) = (i % 10, i / 10 % 10, i / 100);
            let place = Vec3::new(x as f32, y as f32, z as f32 + 1.0) * 0.8;
            let kind = if i % 97 == 5 { BodyKind::Kinematic } else { BodyKind::Dynamic };
            let geometry = match i % 3 {
                0 => Geometry::Sphere { radius: 0.25 },
                1 => Geometry::Box { half_extents: Vec3::new(0.3, 0.15, 0.2) },
                _ => Geometry::Capsule { half_height: 0.2, radius: 0.12 },
            };
            let (body, _) = add(&mut world, &BodyDef::new(kind, place), &ShapeDef::new(geometry));
            play.bodies.push(body);
            if x > 0 {
                let other = play.bodies[i as usize - 1];
                play.join(&mut world, [other, body], Vec3::new(0.8, 0.0, 0.0));
            }
            if y > 0 && i % 2 == 0 {
                let other = play.bodies[i as usize - 10];
                play.join(&mut world, [other, body], Vec3::new(0.0, 0.8, 0.0));
            }
        }
        (play, world)
    }

    fn join(&mut self, world: &mut OwnedWorld, bodies: [BodyHandle; 2], apart: Vec3) {
        let def = self.def(bodies, apart);
        if let Ok(joint) = world.create_joint(&def) {
            self.joints.push(joint);
        }
    }

    fn def(&mut self, bodies: [BodyHandle; 2], apart: Vec3) -> JointDef {
        let turn = Rotation::between(Vec3::X, apart);
        let frames = [Pose::new(apart * 0.5, turn), Pose::new(apart * -0.5, turn)];
        let spring = Spring::Frequency { hertz: 4.0, damping_ratio: 0.5 };
        let mut def = match self.random.below(10) {
            0 => JointDef { cone: Some(0.5), ..JointDef::ball(bodies, frames) },
            1 => JointDef::hinge(bodies, frames),
            2 => JointDef::slider(bodies, frames),
            3 => JointDef { break_force: 400.0, break_torque: 60.0, ..JointDef::fixed(bodies, frames) },
            4 => JointDef::distance(bodies, [Vec3::ZERO; 2], 0.2, 0.9),
            5 => JointDef::wheel(bodies, frames, spring),
            6 => JointDef::gear(bodies, frames, 1.5),
            7 => JointDef { spring: Some(spring), ..JointDef::fixed(bodies, frames) },
            8 => JointDef::rack(bodies, frames, 0.5),
            _ => JointDef::ball(bodies, frames),
        };
        match self.random.below(5) {
            0 => def.axes[TURN_X] = Axis { friction: 1.0, ..Axis::limited(-0.5, 0.5) },
            1 => def.axes[TURN_X].drive = Some(Drive::motor(3.0, 5.0)),
            2 => def.axes[X].drive = Some(Drive::spring(0.1, spring)),
            _ => {}
        }
        def
    }

    /// What a game does between steps.
    fn change(&mut self, world: &mut OwnedWorld, step: u32) {
        if step % 50 == 30 {
            let settings = world.settings();
            let direct_joints = !settings.direct_joints;
            world.set_settings(&Settings { direct_joints, ..settings }).expect("in range");
        }
        if step.is_multiple_of(3) {
            let body = self.bodies[self.random.below(u64::from(BODIES)) as usize];
            let push = Vec3::new(self.random.between(-50.0, 50.0), 20.0, self.random.between(0.0, 90.0));
            let _ = world.apply_impulse(body, push);
        }
        let index = self.random.below(self.joints.len() as u64) as usize;
        let joint = self.joints[index];
        match self.random.below(12) {
            0 => {
                world.remove_joint(joint).expect("it exists");
                self.joints.swap_remove(index);
            }
            1 => {
                let near = self.random.below(u64::from(BODIES) - 1) as usize;
                let bodies = [self.bodies[near], self.bodies[near + 1]];
                self.join(world, bodies, Vec3::new(0.5, 0.0, 0.2));
            }
            2 => {
                let bodies = world.joint(joint).expect("it exists").bodies;
                let def = self.def(bodies, Vec3::new(0.6, 0.0, 0.0));
                let _ = world.set_joint(joint, &def);
            }
            3 | 4 => {
                let axis = [
                    Axis::FREE,
                    Axis::LOCKED,
                    Axis::limited(-0.3, 0.3),
                    Axis { drive: Some(Drive::motor(-2.0, 8.0)), friction: 0.5, ..Axis::FREE },
                ][self.random.below(4) as usize];
                let _ = world.set_joint_axis(joint, TURN_X, &axis);
            }
            5 if step.is_multiple_of(20) => {
                let body = self.bodies[self.random.below(u64::from(BODIES)) as usize];
                let kind =
                    [BodyKind::Static, BodyKind::Dynamic, BodyKind::Kinematic][self.random.below(3) as usize];
                world.set_kind(body, kind).expect("convex");
            }
            _ => {}
        }
    }
}

/// Checksums after each step; `before` sees the world before each.
fn sums(executor: &mut impl Executor, mut before: impl FnMut(&mut OwnedWorld)) -> Vec<u64> {
    let (mut play, mut world) = Play::new();
    let (mut broken, mut contacts, mut phases) = (0, 0, 0);
    let sums = (0..STEPS)
        .map(|step| {
            play.change(&mut world, step);
            before(&mut world);
            let report = world.step(executor);
            assert_eq!((report.quarantined, report.dropped), (0, 0), "step {step}");
            broken += report.broken;
            contacts = report.contacts;
            phases = phases.max(report.phases);
            world.checksum()
        })
        .collect();
    println!("{} joints, {broken} broke, {contacts} contacts, {phases} phases", world.joint_count());
    assert!(world.joint_count() > 400 && broken > 0 && contacts > 100 && phases < 8);
    sums
}

#[test]
fn executors_and_caches_change_no_bit() {
    let expected = sums(&mut Serial, |_| {});
    for seed in 0..2 {
        assert_eq!(sums(&mut Shuffled::new(seed), |_| {}), expected, "shuffled {seed}");
    }
    for workers in [1, 2, 3, 8] {
        let mut pool = Pool::new(workers).expect("threads can be started");
        assert_eq!(sums(&mut pool, |_| {}), expected, "{workers} workers");
    }
    let mut random = Random::new(3);
    let dropped = sums(&mut Serial, |world| {
        if random.below(3) == 0 {
            world.drop_caches();
        }
    });
    assert_eq!(dropped, expected, "caches dropped");
    let empty = Capacities { joints: 2 * BODIES, ..Capacities::for_bodies(BODIES + 1) };
    let saved = sums(&mut Serial, |world| {
        if random.below(10) > 0 {
            return;
        }
        let mut saved = snapshot(world);
        world.step(&mut Serial);
        if random.below(2) == 0 {
            world.restore(&saved).expect("its own snapshot");
        } else {
            OwnedWorld::seal(&mut saved).expect("a snapshot");
            *world = worlds::world_with(empty);
            world.load(&saved).expect("a state that steps made");
        }
    });
    assert_eq!(saved, expected, "saved and restored");
}

#[test]
fn joints_allocate_nothing() {
    let (mut play, mut world) = Play::new();
    let mut buffer = Vec::new();
    for step in 0..60 {
        play.change(&mut world, step);
        world.step(&mut Serial);
        buffer.resize(buffer.len().max(2 * world.snapshot_bytes()), 0);
    }
    let (bodies, joint) = ([play.bodies[0], play.bodies[1]], play.joints[7]);
    let def = JointDef::ball(bodies, [at(Vec3::X), at(-Vec3::X)]);
    let kept = world.joint(joint).expect("it exists");
    let found = allocation_counter::measure(|| {
        for _ in 0..60 {
            let new = world.create_joint(&def).expect("room");
            world.set_joint(joint, &kept).expect("its own definition");
            world.set_joint_axis(new, TURN_X, &Axis::limited(-1.0, 1.0)).expect("in range");
            world.step(&mut Serial);
            assert!(world.joint_force(new).is_ok() && world.joint_coordinates(new).is_ok());
            assert!(world.joints().count() > 100);
            world.remove_joint(new).expect("it exists");
            let length = world.save(&mut buffer).expect("the buffer is large enough");
            world.restore(&buffer[..length]).expect("its own snapshot");
        }
    });
    assert_eq!(found.count_total, 0);
}
