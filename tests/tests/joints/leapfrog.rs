//! Bodies on joints that begin and end a step with half a push: what is left falls with the square of the substep.

use super::chain_of_rods;
use cellstep::joint::axis::TURN_X;
use cellstep::math::{Pose, Rotation, Vec3};
use cellstep::{
    Axis, BodyDef, BodyHandle, BodyKind, Executor, Geometry, JointDef, JointHandle, Pool, Serial, Settings,
    ShapeDef,
};
use cellstep_tests::jointed::{about_y, at, ball, energy, force, jointed, massive, weightless};
use cellstep_tests::oracles::{GRAVITY, center, mass, momenta, norm, velocity};
use cellstep_tests::simulator::snapshot;
use cellstep_tests::worlds::{OwnedWorld, add, run};

/// Two rods of 1 m, or one, that hang by a hinge or a ball and are let go at 45 degrees.
fn pendulum(substeps: u32, rods: usize, is_hinge: bool) -> (OwnedWorld, Vec<BodyHandle>, Vec<JointHandle>) {
    let along = Vec3::new(0.5_f32.sqrt(), 0.0, -(0.5_f32.sqrt()));
    chain_of_rods((rods, substeps), along, is_hinge)
}

/// Places of the last rod after each of so many steps.
fn ways(substeps: u32, rods: usize, is_hinge: bool) -> Vec<[f64; 3]> {
    let (mut world, bodies, _) = pendulum(substeps, rods, is_hinge);
    (0..60)
        .map(|_| {
            world.step(&mut Serial);
            center(&world, bodies[rods - 1])
        })
        .collect()
}

/// Places of the end of a rod of 1 m on a hinge that is let go at 45 degrees, after each step: `a'' = -3 g / 2 l
/// sin a`, by the classical method of Runge and Kutta in steps of a hundredth.
fn oracle(steps: u32, dt: f64) -> Vec<[f64; 3]> {
    let pull = |angle: f64| -1.5 * GRAVITY * angle.sin();
    let (mut angle, mut rate) = (std::f64::consts::FRAC_PI_4, 0.0);
    let h = dt / 100.0;
    let mut step = || {
        let (k1, l1) = (rate, pull(angle));
        let (k2, l2) = (rate + 0.5 * h * l1, pull(angle + 0.5 * h * k1));
        let (k3, l3) = (rate + 0.5 * h * l2, pull(angle + 0.5 * h * k2));
        let (k4, l4) = (rate + h * l3, pull(angle + h * k3));
        angle += h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
        rate += h / 6.0 * (l1 + 2.0 * l2 + 2.0 * l3 + l4);
        angle
    };
    let place = |angle: f64| [0.5 * angle.sin(), 0.0, -0.5 * angle.cos()];
    (0..steps).map(|_| place((0..100).map(|_| step()).last().expect("a hundred"))).collect()
}

/// The greatest distance between two ways.
fn apart(found: &[[f64; 3]], expected: &[[f64; 3]]) -> f64 {
    found.iter().zip(expected).map(|(a, b)| norm([0, 1, 2].map(|k| a[k] - b[k]))).fold(0.0, f64::max)
}

#[test]
fn errors_fall_with_the_square_of_the_substep() {
    for is_hinge in [false, true] {
        let expected = oracle(60, 1.0 / 60.0);
        let errors = [1, 2, 4].map(|substeps| apart(&ways(substeps, 1, is_hinge), &expected));
        println!("hinge: {is_hinge}: {errors:.6?} m at 1, 2 and 4 substeps");
        for two in errors.windows(2) {
            assert!((3.4..4.6).contains(&(two[0] / two[1])), "hinge: {is_hinge}: {errors:?}");
        }
    }
}

#[test]
fn errors_of_two_rods_fall_with_the_square() {
    for is_hinge in [false, true] {
        let reference = ways(32, 2, is_hinge);
        let [coarse, fine] = [1, 4].map(|substeps| apart(&ways(substeps, 2, is_hinge), &reference));
        println!("hinges: {is_hinge}: {coarse:.2e} m at 1 substep, {fine:.2e} m at 4");
        // A 16th; a quarter was all with the whole push first.
        assert!(fine < 0.125 * coarse && fine < 2.0e-4, "hinges: {is_hinge}: {coarse}, {fine}");
    }
}

#[test]
fn what_hangs_still_stays_still_and_carries_its_weight() {
    for substeps in [1, 4] {
        for rods in [1, 3] {
            let (mut world, base) = jointed(rods, rods, substeps);
            let (mut before, mut joints) = ((base, Pose::IDENTITY), Vec::new());
            let mut last = base;
            for rod in 0..rods {
                let body = massive(
                    &mut world,
                    Pose::new(Vec3::Z * -(rod as f32 + 0.5), Pose::IDENTITY.rotation),
                    ball(1.0, 0.3),
                );
                let top = Pose::new(Vec3::Z * 0.5, Pose::IDENTITY.rotation);
                let def = JointDef::ball([before.0, body], [before.1, top]);
                joints.push(world.create_joint(&def).expect("room"));
                before = (body, Pose::new(Vec3::Z * -0.5, Pose::IDENTITY.rotation));
                last = body;
            }
            run(&mut world, 60);
            let speed = norm(velocity(&world, last));
            assert!(speed < 1.0e-5, "{rods} bodies, {substeps} substeps: {speed} m/s");
            for (place, &joint) in joints.iter().enumerate() {
                let (found, expected) = (force(&world, joint)[2], f64::from(rods - place as u32) * GRAVITY);
                assert!(
                    (found - expected).abs() < 1.0e-4 * expected,
                    "joint {place}: {found} of {expected} N"
                );
            }
        }
    }
}

/// The energy of some bodies, J.
fn total(world: &OwnedWorld, bodies: &[BodyHandle]) -> f64 {
    bodies.iter().map(|&body| energy(world, body, GRAVITY)).sum()
}

/// Rods on hinges with a ball of 0.1 m at their centers of percussion, where a blow leaves the hinge alone, and
/// something immovable that bounces.
fn struck(substeps: u32, rods: usize, (place, restitution): (Vec3, f32)) -> (OwnedWorld, Vec<BodyHandle>) {
    let (mut world, bodies, _) = pendulum(substeps, rods, true);
    let pose = at(Vec3::X / 6.0);
    let shape = ShapeDef { restitution, pose, ..ShapeDef::new(Geometry::Sphere { radius: 0.1 }) };
    for &body in &bodies {
        world.create_shape(body, &ShapeDef { density: 0.0, ..shape }).expect("room");
    }
    let wall = Geometry::Box { half_extents: Vec3::new(0.5, 5.0, 0.5) };
    add(&mut world, &BodyDef::new(BodyKind::Static, place), &ShapeDef { restitution, ..ShapeDef::new(wall) });
    (world, bodies)
}

/// A wall at the lowest place, a floor before it, and a chain that whips the floor.
const STRUCK: [(usize, Vec3); 3] =
    [(1, Vec3::new(-0.6, 0.0, -0.5)), (1, Vec3::new(0.0, 0.0, -1.2)), (3, Vec3::new(0.0, 0.0, -2.6))];

#[test]
fn blows_between_give_no_energy() {
    for (rods, place) in STRUCK {
        for restitution in [0.0, 0.5, 1.0] {
            for substeps in [1, 4] {
                let (mut world, bodies) = struck(substeps, rods, (place, restitution));
                let start = total(&world, &bodies);
                let (mut most, mut turns, mut touched) = (f64::NEG_INFINITY, 0, false);
                for _ in 0..1_200 {
                    let touches = world.step(&mut Serial).contacts > 0;
                    turns += u32::from(touches != touched);
                    touched = touches;
                    most = most.max(total(&world, &bodies));
                }
                let end = total(&world, &bodies);
                println!(
                    "{rods} rods, {place}, e {restitution}, {substeps} substeps: {turns} turns, {start:.4} J, at \
                     most {most:.4} J, {end:.4} J at the end"
                );
                // What touches has the velocities of half a substep before: at most 1 m/s down, by half a push.
                let behind = rods as f64 * 0.5 * GRAVITY / f64::from(60 * substeps);
                assert!(turns > 0 && most < start + behind, "{turns} turns, {start} to {most} J");
                assert!(end < start + 1.0e-3 * start.abs(), "{start} to {end} J");
                if place.x != 0.0 && restitution == 1.0 {
                    assert!(
                        turns > 40 && start - end < 1.0e-2 * start.abs(),
                        "{turns} turns, {start} to {end} J"
                    );
                }
            }
        }
    }
}

/// A joint with a limit that is never reached does not leap. Swung as one that leaps above and not below, a
/// pendulum would gain half a substep's gravity on each way down and each way up, if velocities meant different
/// times.
#[test]
fn leaping_by_turns_gives_no_energy() {
    for is_hinge in [true, false] {
        for substeps in [1, 4] {
            let (mut world, bodies, joints) = pendulum(substeps, 1, is_hinge);
            let start = total(&world, &bodies);
            let leaps = world.joint(joints[0]).expect("exists");
            let mut limited = leaps;
            limited.cone = (!is_hinge).then_some(3.0);
            if is_hinge {
                limited.axes[TURN_X] = Axis::limited(-3.0, 3.0);
            }
            let (mut changes, mut was_low) = (0, false);
            for _ in 0..1_200 {
                let is_low = center(&world, bodies[0])[2] < -0.43;
                if is_low != was_low {
                    world.set_joint(joints[0], if is_low { &limited } else { &leaps }).expect("valid");
                    changes += 1;
                }
                was_low = is_low;
                world.step(&mut Serial);
            }
            world.set_joint(joints[0], &leaps).expect("valid");
            run(&mut world, 1);
            let change = total(&world, &bodies) - start;
            println!(
                "hinge: {is_hinge}, {substeps} substeps: {changes} changes, {change:.4} of {start:.4} J"
            );
            assert!(changes > 40 && change.abs() < 0.02 * start.abs(), "{changes} changes: {change} J");
        }
    }
}

/// The state after each step of things that leap and touch by turns.
fn sums(executor: &mut impl Executor, mut between: impl FnMut(&mut OwnedWorld)) -> Vec<Vec<u8>> {
    STRUCK
        .into_iter()
        .map(|(rods, place)| {
            let (mut world, _) = struck(4, rods, (place, 0.5));
            for _ in 0..300 {
                between(&mut world);
                world.step(executor);
            }
            snapshot(&world)
        })
        .collect()
}

#[test]
fn leaping_by_turns_has_the_same_bits_everywhere() {
    let expected = sums(&mut Serial, |_| {});
    for workers in [1, 3] {
        let mut pool = Pool::new(workers).expect("threads can be started");
        assert!(sums(&mut pool, |_| {}) == expected, "{workers} workers");
    }
    assert!(sums(&mut Serial, OwnedWorld::drop_caches) == expected, "without caches");
    let restored = |world: &mut OwnedWorld| {
        let saved = snapshot(world);
        run(world, 2);
        world.restore(&saved).expect("its own snapshot");
    };
    assert!(sums(&mut Serial, restored) == expected, "restored");
    let loaded = |world: &mut OwnedWorld| {
        let mut saved = snapshot(world);
        OwnedWorld::seal(&mut saved).expect("a snapshot");
        world.load(&saved).expect("a state that steps made");
    };
    assert!(sums(&mut Serial, loaded) == expected, "loaded");
}

/// Two balls that hold each other, and turn.
#[test]
fn a_free_pair_has_the_momentum_that_it_was_given() {
    for (substeps, is_hinge) in [(1, false), (4, false), (4, true)] {
        let (mut world, _) = jointed(2, 1, substeps);
        weightless(&mut world);
        let bodies = [-0.5, 0.5].map(|x| massive(&mut world, at(Vec3::X * x), ball(1.0 + x, 0.3)));
        let ends = [Pose::new(Vec3::X * 0.5, about_y()), Pose::new(Vec3::X * -0.5, about_y())];
        let def = if is_hinge { JointDef::hinge(bodies, ends) } else { JointDef::ball(bodies, ends) };
        let joint = world.create_joint(&def).expect("room");
        let limited = JointDef { cone: Some(3.0), ..def };
        let mut given = [0.0; 3];
        for step in 0..240 {
            if step % 5 == 0 {
                let push = Vec3::new(0.3, -0.1, 0.2) * (step % 7) as f32;
                world.apply_force(bodies[step % 2], push).expect("finite");
                let dt = f64::from(world.settings().dt);
                given = [0, 1, 2].map(|k| given[k] + f64::from(push[k]) * dt);
            }
            if step % 3 == 0 && !is_hinge {
                world.set_joint(joint, if step % 2 == 0 { &limited } else { &def }).expect("valid");
            }
            world.step(&mut Serial);
        }
        let [a, b] = bodies.map(|body| momenta(&world, body).0);
        let off = norm([0, 1, 2].map(|k| a[k] + b[k] - given[k]));
        println!("{substeps} substeps, hinge: {is_hinge}: {off:.1e} of {:.3} N s", norm(given));
        assert!(off < 3.0e-6 * norm(given), "{off}");
    }
}

/// What falls as a pair, joined now so and now so, falls as gravity says.
#[test]
fn a_pair_falls_as_gravity_says() {
    let (mut world, _) = jointed(2, 1, 4);
    let bodies = [-0.5, 0.5].map(|x| massive(&mut world, at(Vec3::X * x), ball(1.0 + x, 0.3)));
    let def = JointDef::ball(bodies, [at(Vec3::X * 0.5), at(Vec3::X * -0.5)]);
    let joint = world.create_joint(&def).expect("room");
    let limited = JointDef { cone: Some(3.0), ..def };
    for step in 0..240 {
        if step % 3 == 0 {
            world.set_joint(joint, if step % 2 == 0 { &limited } else { &def }).expect("valid");
        }
        world.step(&mut Serial);
    }
    let whole = |of: fn(&OwnedWorld, BodyHandle) -> [f64; 3]| {
        bodies.iter().map(|&body| mass(&world, body) * of(&world, body)[2]).sum::<f64>()
    };
    let (speed, height, weight) = (whole(velocity), whole(center), 2.0 * GRAVITY);
    let push = weight / 240.0;
    assert!((speed + 4.0 * weight).abs() < 0.51 * push, "{speed}");
    assert!((height + 8.0 * weight).abs() < 4.0 * 0.51 * push, "{height}");
}

/// A force so great that its half alone is beyond the greatest speed: speeds stay capped after the last half.
#[test]
fn the_last_push_is_capped() {
    let (mut world, bodies, _) = pendulum(4, 1, false);
    world.apply_force(bodies[0], Vec3::new(1.0e14, 0.0, 1.0e14)).expect("in range");
    let report = world.step(&mut Serial);
    assert_eq!((report.capped, report.quarantined), (1, 0));
    assert!(norm(velocity(&world, bodies[0])) < 2.0e6);
    let mut saved = snapshot(&world);
    OwnedWorld::seal(&mut saved).expect("a snapshot");
    world.load(&saved).expect("a state that steps made");
    run(&mut world, 60);
}

#[test]
fn without_relax_sweeps_the_whole_push_comes_first() {
    // Free fall on a joint that slides along z: the closed form of the scheme.
    for (relax_sweeps, steps) in [(0, 60), (1, 60)] {
        let (mut world, base) = jointed(1, 1, 4);
        let settings = Settings { relax_sweeps, ..world.settings() };
        world.set_settings(&settings).expect("in range");
        let body = massive(&mut world, Pose::IDENTITY, ball(1.0, 0.3));
        let turned = Pose::new(Vec3::ZERO, Rotation::between(Vec3::X, Vec3::Z));
        world.create_joint(&JointDef::slider([base, body], [turned; 2])).expect("room");
        run(&mut world, steps);
        let (n, h) = (f64::from(4 * steps), 1.0 / 240.0);
        let whole = -0.5 * GRAVITY * h * h * n * (n + 1.0);
        let leapt = -0.5 * GRAVITY * h * h * n * n;
        let expected = if relax_sweeps == 0 { whole } else { leapt };
        let found = center(&world, body)[2];
        assert!((found - expected).abs() < 2.0e-4, "{relax_sweeps} relax sweeps: {found}, not {expected} m");
    }
}
