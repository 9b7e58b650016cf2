//! Bodies on joints that begin and end a step with half a push: what is left falls with the square of the substep.

use cellstep::math::{Pose, Vec3};
use cellstep::{BodyDef, BodyHandle, BodyKind, Geometry, JointDef, JointHandle, Serial, Settings, ShapeDef};
use cellstep_tests::jointed::{Bar, about_y, ball, energy, force, jointed, massive};
use cellstep_tests::oracles::{GRAVITY, center, norm, velocity};
use cellstep_tests::worlds::{OwnedWorld, add, run};

/// Two rods of 1 m, or one, that hang by a hinge or a ball and are let go at 45 degrees.
fn pendulum(substeps: u32, rods: usize, is_hinge: bool) -> (OwnedWorld, Vec<BodyHandle>, Vec<JointHandle>) {
    let (mut world, base) = jointed(rods as u32 + 1, rods as u32, substeps);
    let along = Vec3::new(0.5_f32.sqrt(), 0.0, -(0.5_f32.sqrt()));
    let (mut bodies, mut joints) = (Vec::new(), Vec::new());
    let mut before = (base, Pose::new(Vec3::ZERO, about_y()));
    for rod in 0..rods {
        let bar = Bar::new(&mut world, along * rod as f32, along * (rod + 1) as f32);
        let (ends, frames) = ([before.0, bar.body], [before.1, bar.end(-1.0).1]);
        let def = if is_hinge { JointDef::hinge(ends, frames) } else { JointDef::ball(ends, frames) };
        joints.push(world.create_joint(&def).expect("room"));
        bodies.push(bar.body);
        before = bar.end(1.0);
    }
    (world, bodies, joints)
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

#[test]
fn errors_fall_with_the_square() {
    for (rods, is_hinge) in [(1, false), (1, true), (2, false), (2, true)] {
        let reference = ways(32, rods, is_hinge);
        let error = |substeps| {
            let found = ways(substeps, rods, is_hinge);
            let off = found.iter().zip(&reference).map(|(a, b)| norm([0, 1, 2].map(|k| a[k] - b[k])));
            off.fold(0.0, f64::max)
        };
        let [coarse, fine] = [1, 4].map(error);
        println!("{rods} rods, hinges: {is_hinge}: {coarse:.2e} m at 1 substep, {fine:.2e} m at 4");
        // A 16th; a quarter was all with the whole push first.
        assert!(fine < 0.125 * coarse && fine < 2.0e-4, "{rods} rods, hinges: {is_hinge}: {coarse}, {fine}");
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

/// A pendulum beside a wall that it hits: half of its steps it leaps, the others it does not.
#[test]
fn blows_between_give_no_energy() {
    for rods in [1, 2] {
        let (mut world, bodies, _) = pendulum(4, rods, true);
        let shape = ShapeDef { restitution: 1.0, ..ShapeDef::new(Geometry::Sphere { radius: 0.1 }) };
        for &body in &bodies {
            world.create_shape(body, &ShapeDef { density: 0.0, ..shape }).expect("room");
        }
        let wall = Geometry::Box { half_extents: Vec3::new(0.5, 5.0, 5.0) };
        let def = BodyDef::new(BodyKind::Static, Vec3::new(-0.75, 0.0, 0.0));
        add(&mut world, &def, &ShapeDef { restitution: 1.0, ..ShapeDef::new(wall) });
        let total = |world: &OwnedWorld| bodies.iter().map(|&body| energy(world, body, GRAVITY)).sum::<f64>();
        let (start, mut most, mut touched) = (total(&world), f64::NEG_INFINITY, 0);
        for _ in 0..600 {
            touched += world.step(&mut Serial).contacts;
            most = most.max(total(&world));
        }
        println!("{rods} rods: {touched} contacts, energy {start:.3} J, at most {most:.3} J");
        assert!(touched > 10 && most < start + 0.05 * rods as f64 * GRAVITY, "{start} to {most} J");
    }
}

#[test]
fn without_relax_sweeps_the_whole_push_comes_first() {
    // Free fall on a joint that slides along z: the closed form of the scheme.
    for (relax_sweeps, steps) in [(0, 60), (1, 60)] {
        let (mut world, base) = jointed(1, 1, 4);
        let settings = Settings { relax_sweeps, ..world.settings() };
        world.set_settings(&settings).expect("in range");
        let body = massive(&mut world, Pose::IDENTITY, ball(1.0, 0.3));
        let turned = Pose::new(Vec3::ZERO, cellstep::math::Rotation::between(Vec3::X, Vec3::Z));
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
