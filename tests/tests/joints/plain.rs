//! Plain ball joints, which have rows of their own: they do what the rows of any joint do.

use cellstep::math::{Vec3, length, max};
use cellstep::{
    AxisLocks, BodyDef, BodyHandle, BodyKind, Capacities, Executor, JointDef, JointHandle, Pool, Serial,
    Settings,
};
use cellstep_tests::executors::{Random, Shuffled};
use cellstep_tests::jointed::{at, ball, gap, weightless};
use cellstep_tests::simulator::snapshot;
use cellstep_tests::worlds::{self, OwnedWorld};

fn vector(random: &mut Random, most: f32) -> Vec3 {
    Vec3::new(random.between(-most, most), random.between(-most, most), random.between(-most, most))
}

/// Pairs of spinning bodies with a joint each, some of them on a static body, by either end.
struct Pairs {
    world: OwnedWorld,
    bodies: Vec<BodyHandle>,
    joints: Vec<JointHandle>,
}

impl Pairs {
    /// Thrown in the same way each time. `odd` is what the third moment of inertia has more than the others, as a
    /// share: a body with unequal moments has rows of the general kind.
    fn new(odd: f32) -> Self {
        let mut world = worlds::world_with(Capacities { joints: 40, ..Capacities::for_bodies(80) });
        weightless(&mut world);
        let settings = Settings { substeps: 16, ..world.settings() };
        world.set_settings(&settings).expect("in range");
        let mut random = Random::new(5);
        let (mut bodies, mut joints) = (Vec::new(), Vec::new());
        for i in 0..40 {
            let place = Vec3::new(i as f32 * 8.0, 0.0, 0.0);
            let pair = [0, 1].map(|end| {
                let kind = if i % 5 == end { BodyKind::Static } else { BodyKind::Dynamic };
                let mut mass = ball(1.0 + i as f32, 0.5);
                mass.inertia.z *= 1.0 + odd;
                let def = BodyDef::new(kind, place + Vec3::X * end as f32);
                let body = world.create_body(&BodyDef { mass: Some(mass), ..def }).expect("room");
                let (linear, angular) = (vector(&mut random, 2.0), vector(&mut random, 3.0));
                if kind == BodyKind::Dynamic {
                    world.set_linear_velocity(body, linear).expect("lives");
                    world.set_angular_velocity(body, angular).expect("lives");
                }
                body
            });
            let middle = Vec3::new(0.5, 0.2, -0.1);
            let def = JointDef::ball(pair, [at(middle), at(middle - Vec3::X)]);
            joints.push(world.create_joint(&def).expect("room"));
            bodies.extend(pair);
        }
        Self { world, bodies, joints }
    }

    fn widest_gap(&self) -> f64 {
        self.joints.iter().map(|&joint| gap(&self.world, joint)).fold(0.0, f64::max)
    }

    /// Momentum and kinetic energy.
    fn sums(&self) -> (Vec3, f32) {
        let world = &self.world;
        let moving = self.bodies.iter().filter(|&&body| world.kind(body) == Ok(BodyKind::Dynamic));
        moving.fold((Vec3::ZERO, 0.0), |(momentum, energy), &body| {
            let mass = world.mass_properties(body).expect("lives");
            let v = world.linear_velocity(body).expect("lives");
            let w = world.angular_velocity(body).expect("lives");
            let motion = mass.mass * v.dot(v) + mass.inertia.x * w.dot(w);
            (momentum + v * mass.mass, energy + 0.5 * motion)
        })
    }
}

#[test]
fn plain_rows_do_as_the_others() {
    let (mut plain, mut general) = (Pairs::new(0.0), Pairs::new(1.0e-6));
    let mut furthest = 0.0_f32;
    for step in 0..120 {
        plain.world.step(&mut Serial);
        general.world.step(&mut Serial);
        for (&a, &b) in plain.bodies.iter().zip(&general.bodies) {
            let [a, b] = [(&plain, a), (&general, b)].map(|(pairs, body)| pairs.world.center(body).unwrap());
            let apart = length(a.minus(b));
            furthest = max(furthest, apart);
            // With 32 substeps both are 2.5 mm from what 64 give.
            assert!(apart < 5.0e-3, "step {step}: {apart}");
        }
        assert!(plain.widest_gap() < 1.0e-4, "step {step}: {}", plain.widest_gap());
    }
    println!("furthest {furthest:.2e} m, widest gap {:.2e} m", plain.widest_gap());
}

#[test]
fn plain_rows_keep_momentum_and_energy() {
    let mut pairs = Pairs::new(0.0);
    // Only pairs without a static body keep momentum: the others are held still.
    for (&body, i) in pairs.bodies.iter().zip(0..) {
        let moves = pairs.world.kind(body) == Ok(BodyKind::Dynamic);
        if moves && i / 2 % 5 < 2 {
            pairs.world.set_linear_velocity(body, Vec3::ZERO).expect("lives");
            pairs.world.set_angular_velocity(body, Vec3::ZERO).expect("lives");
        }
    }
    // What does not fit the joints goes in the first step.
    pairs.world.step(&mut Serial);
    let (momentum, energy) = pairs.sums();
    worlds::run(&mut pairs.world, 600);
    let (after, energy_after) = pairs.sums();
    let error = length(after - momentum) / length(momentum);
    println!("momentum {error:.2e}, energy {:.2e}", energy_after / energy - 1.0);
    // The rounding of 9,600 substeps.
    assert!(error < 1.0e-4, "momentum {error}");
    assert!((energy_after / energy - 1.0).abs() < 1.0e-3, "energy {}", energy_after / energy - 1.0);
}

const SIDE: usize = 14;

/// A net of balls that hangs on static, moving and locked bodies, has tops among its bodies, and loses joints.
fn net(executor: &mut impl Executor, mut before: impl FnMut(&mut OwnedWorld)) -> Vec<u64> {
    let count = (SIDE * SIDE) as u32;
    let mut world = worlds::world_with(Capacities { joints: 2 * count, ..Capacities::for_bodies(count) });
    let (mut bodies, mut joints) = (Vec::new(), Vec::new());
    for i in 0..SIDE * SIDE {
        let (x, y) = (i % SIDE, i / SIDE);
        let kind = match i {
            0 => BodyKind::Static,
            i if i + 1 == SIDE => BodyKind::Kinematic,
            _ => BodyKind::Dynamic,
        };
        let mut mass = ball(1.0 + (i % 3) as f32, 0.4);
        if i % 11 == 3 {
            mass.inertia.x *= 2.0;
        }
        let locks = if i % 13 == 5 { AxisLocks::MOVE_X } else { AxisLocks::NONE };
        let def = BodyDef::new(kind, Vec3::new(x as f32, y as f32, 0.0));
        bodies.push(world.create_body(&BodyDef { mass: Some(mass), locks, ..def }).expect("room"));
        let mut join = |other: usize, apart: Vec3| {
            let frames = [at(apart * 0.5), at(apart * -0.5)];
            let def = JointDef::ball([bodies[other], bodies[i]], frames);
            let def = JointDef { break_force: if i % 17 == 4 { 300.0 } else { f32::INFINITY }, ..def };
            joints.push(world.create_joint(&def).expect("room"));
        };
        if x > 0 {
            join(i - 1, Vec3::X);
        }
        if y > 0 {
            join(i - SIDE, Vec3::Y);
        }
    }
    let mut broken = 0;
    let sums = (0..90)
        .map(|step: u32| {
            // The moving anchor stops and goes on: its joints' rows change their kind in between.
            let speed = if (step / 20).is_multiple_of(2) { Vec3::new(0.1, 0.0, 0.2) } else { Vec3::ZERO };
            world.set_linear_velocity(bodies[SIDE - 1], speed).expect("lives");
            if step % 9 == 4 {
                world.remove_joint(joints.swap_remove(step as usize)).expect("it exists");
            }
            before(&mut world);
            broken += world.step(executor).broken;
            world.checksum()
        })
        .collect();
    let held = joints.iter().filter(|&&joint| !world.is_broken(joint).expect("it exists"));
    let mut gaps: Vec<f64> = held.map(|&joint| gap(&world, joint)).collect();
    gaps.sort_unstable_by(f64::total_cmp);
    let common = gaps[gaps.len() * 9 / 10];
    println!(
        "{broken} broke; nine of ten gaps below {common:.2e} m, all below {:.2e} m",
        gaps[gaps.len() - 1]
    );
    assert!(broken > 0 && common < 0.05);
    sums
}

#[test]
fn executors_and_caches_change_no_bit_of_a_net() {
    let expected = net(&mut Serial, |_| {});
    assert_eq!(net(&mut Shuffled::new(7), |_| {}), expected, "shuffled");
    for workers in [2, 3] {
        let mut pool = Pool::new(workers).expect("threads can be started");
        assert_eq!(net(&mut pool, |_| {}), expected, "{workers} workers");
    }
    let mut random = Random::new(3);
    let restored = net(&mut Serial, |world| match random.below(4) {
        0 => world.drop_caches(),
        1 => {
            let saved = snapshot(world);
            world.step(&mut Serial);
            world.restore(&saved).expect("its own snapshot");
        }
        _ => {}
    });
    assert_eq!(restored, expected, "restored, caches dropped");
}
