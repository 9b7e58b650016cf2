//! Joints that nobody should make: they stay finite, and no energy comes from nothing.

use cellstep::joint::axis::{TURN_X, TURN_Y, X};
use cellstep::math::{Pose, Rotation, Vec3};
use cellstep::{Axis, BodyDef, BodyHandle, BodyKind, Drive, JointDef, Serial, Settings, Spring};
use cellstep_tests::executors::Random;
use cellstep_tests::jointed::{at, ball, coordinate, energy, gap, jointed, massive, rod, weightless};
use cellstep_tests::oracles::{GRAVITY, center, norm, spin, velocity};
use cellstep_tests::worlds::{OwnedWorld, run};

#[test]
fn joints_of_immovable_bodies_do_nothing() {
    let (mut world, base) = jointed(3, 3, 4);
    let other = world.create_body(&BodyDef::new(BodyKind::Static, Vec3::new(5.0, 0.0, 0.0))).expect("room");
    let moving =
        world.create_body(&BodyDef::new(BodyKind::Kinematic, Vec3::new(0.0, 5.0, 0.0))).expect("room");
    world.set_linear_velocity(moving, Vec3::X).expect("kinematic");
    let joints = [[base, other], [base, moving], [moving, other]]
        .map(|bodies| world.create_joint(&JointDef::fixed(bodies, [Pose::IDENTITY; 2])).expect("room"));
    run(&mut world, 60);
    assert_eq!(center(&world, base), [0.0; 3]);
    assert_eq!(center(&world, other), [5.0, 0.0, 0.0]);
    assert!((center(&world, moving)[0] - 1.0).abs() < 1.0e-5);
    for joint in joints {
        assert_eq!(world.joint_force(joint), Ok(Vec3::ZERO));
    }
    // One becomes dynamic, and is held from then on.
    world.set_kind(moving, BodyKind::Dynamic).expect("no shapes");
    world.set_mass(moving, Some(&ball(1.0, 0.2))).expect("in range");
    world.remove_joint(joints[2]).expect("it exists");
    run(&mut world, 600);
    assert!(gap(&world, joints[1]) < 1.0e-3 && norm(velocity(&world, moving)) < 1.0e-2);
    // And a kinematic one again.
    world.set_kind(moving, BodyKind::Kinematic).expect("allowed");
    run(&mut world, 10);
}

/// Two balls, weightless, with contradictory joints; the most energy that there ever is.
fn quarrel(defs: impl Fn([BodyHandle; 3]) -> Vec<JointDef>) -> f64 {
    let (mut world, base) = jointed(2, 16, 4);
    weightless(&mut world);
    let a = massive(&mut world, at(Vec3::X), ball(1.0, 0.2));
    let b = massive(&mut world, at(Vec3::new(2.0, 0.0, 0.0)), rod(1.0, 0.5));
    for def in defs([base, a, b]) {
        world.create_joint(&def).expect("room");
    }
    let mut most = 0.0_f64;
    for _ in 0..600 {
        assert_eq!(world.step(&mut Serial).quarantined, 0);
        most = most.max(energy(&world, a, 0.0) + energy(&world, b, 0.0));
        for body in [a, b] {
            assert!(norm(center(&world, body)) < 50.0, "{:?}", center(&world, body));
        }
    }
    most
}

#[test]
fn duplicate_and_contradictory_joints_stay_bounded() {
    let ball_at = |bodies, x: f32, y: f32| {
        JointDef::ball(bodies, [at(Vec3::new(x, 0.0, 0.0)), at(Vec3::new(y, 0.0, 0.0))])
    };
    let most = quarrel(|[base, a, b]| {
        let mut defs = vec![ball_at([a, b], 0.5, -0.5); 4];
        defs.extend([JointDef::fixed([base, a], [at(Vec3::X), Pose::IDENTITY]); 4]);
        defs
    });
    assert!(most < 1.0e-4, "duplicates of what fits move nothing: {most} J");
    let most = quarrel(|[base, a, b]| {
        vec![ball_at([base, a], 1.0, 0.0), ball_at([base, a], 3.0, 0.0), ball_at([a, b], 0.5, -0.5)]
    });
    println!("two places for one ball: {most} J");
    assert!(most < 10.0, "two places for one ball: {most} J");
    let most = quarrel(|[base, a, b]| {
        let mut hinge = JointDef::hinge([base, a], [at(Vec3::X), Pose::IDENTITY]);
        hinge.axes[TURN_X].drive = Some(Drive::motor(5.0, f32::INFINITY));
        let mut against = hinge;
        against.axes[TURN_X].drive = Some(Drive::motor(-5.0, f32::INFINITY));
        vec![
            hinge,
            against,
            JointDef::distance([a, b], [Vec3::ZERO; 2], 0.2, 0.2),
            JointDef::distance([a, b], [Vec3::ZERO; 2], 3.0, 3.0),
        ]
    });
    println!("motors and rods against each other: {most} J");
    assert!(most < 100.0, "motors and rods against each other: {most} J");
    let most = quarrel(|[base, a, b]| {
        let mut def = JointDef::six_axis([a, b], [Pose::IDENTITY; 2]);
        def.axes = [Axis {
            limit_spring: Some(Spring::Frequency { hertz: 30.0, damping_ratio: 0.1 }),
            ..Axis::limited(0.1, 0.2)
        }; 6];
        def.cone = Some(0.05);
        vec![
            def,
            JointDef::gear([base, b], [Pose::IDENTITY; 2], 3.0),
            JointDef::rack([a, b], [Pose::IDENTITY; 2], 0.7),
        ]
    });
    println!("limits that cannot all hold: {most} J");
    assert!(most < 1.0e4, "limits that cannot all hold: {most} J");
}

#[test]
fn a_distance_of_nothing() {
    for (lower, upper, apart) in [(0.0, 0.0, 0.0), (0.0, 0.0, 1.0), (1.0, 1.0, 0.0), (0.0, 1.0, 0.0)] {
        let (mut world, base) = jointed(1, 1, 4);
        let body = massive(&mut world, at(Vec3::new(apart, 0.0, 0.0)), ball(1.0, 0.2));
        let joint = world
            .create_joint(&JointDef::distance([base, body], [Vec3::ZERO; 2], lower, upper))
            .expect("room");
        let start = energy(&world, body, GRAVITY);
        for _ in 0..300 {
            world.step(&mut Serial);
            // What pulls two points together in a few steps may throw them past each other, by a hand's breadth.
            let now = energy(&world, body, GRAVITY);
            assert!(now < start + 1.0, "{lower} to {upper} from {apart}: {now} J");
        }
        let distance = coordinate(&world, joint, X);
        println!("{lower} to {upper} from {apart}: {distance}");
        assert!(distance < f64::from(upper) + 0.02 && distance > f64::from(lower) - 0.02, "{distance}");
    }
}

#[test]
fn ten_thousand_joints_of_one_body() {
    const COUNT: u32 = 10_000;
    let (mut world, _) = jointed(COUNT + 1, COUNT, 2);
    let hub = massive(&mut world, Pose::IDENTITY, ball(1.0e4, 10.0));
    world.set_gravity_scale(hub, 0.0).expect("it exists");
    let mut random = Random::new(1);
    let mut joints = Vec::new();
    for _ in 0..COUNT {
        let mut coordinate = || random.between(-20.0, 20.0);
        let place = Vec3::new(coordinate(), coordinate(), coordinate());
        let body = massive(&mut world, at(place), ball(0.1, 0.1));
        let def = JointDef::distance([body, hub], [Vec3::ZERO, place * 0.5], 0.0, 30.0);
        joints.push(world.create_joint(&def).expect("room"));
    }
    for _ in 0..5 {
        let report = world.step(&mut Serial);
        assert_eq!((report.joints, report.quarantined), (COUNT, 0));
    }
    assert_eq!(world.joints_of(hub).expect("it exists").count(), COUNT as usize);
    for joint in joints.iter().step_by(3) {
        world.remove_joint(*joint).expect("it exists");
    }
    world.step(&mut Serial);
    world.remove_body(hub).expect("it exists");
    assert_eq!(world.joint_count(), 0);
    world.step(&mut Serial);
}

/// Anchors far off, joints far open, in all kinds of settings: bodies come together without harm.
#[test]
fn joints_that_start_open_close() {
    let mut random = Random::new(5);
    for substeps in [1, 4, 16] {
        for relax_sweeps in [0, 1, 3] {
            let (mut world, base) = jointed(2, 2, substeps);
            let settings = Settings { relax_sweeps, ..world.settings() };
            world.set_settings(&settings).expect("in range");
            weightless(&mut world);
            let a = massive(&mut world, at(Vec3::new(3.0, 1.0, 0.0)), rod(1.0, 1.0));
            let b = massive(&mut world, at(Vec3::new(-3.0, 2.0, 1.0)), ball(5.0, 0.5));
            let mut turn = || Rotation::from_rotation_vector(Vec3::splat(random.between(-1.0, 1.0)));
            let frames = [at(Vec3::new(0.5, 0.0, 0.0)), Pose::new(Vec3::new(0.0, 0.4, 0.0), turn())];
            let joints = [
                world.create_joint(&JointDef::ball([base, a], frames)).expect("room"),
                world.create_joint(&JointDef::fixed([a, b], frames)).expect("room"),
            ];
            let mut most = 0.0_f64;
            for _ in 0..600 {
                world.step(&mut Serial);
                most = most.max(energy(&world, a, 0.0) + energy(&world, b, 0.0));
            }
            println!("{substeps} substeps, {relax_sweeps} relax sweeps: at most {most:.3} J");
            assert!(most < 60.0, "{most} J from the pull of open joints");
            // The heavy one closes at once; the light one between them takes its time (one sweep a substep).
            let gaps = joints.map(|joint| gap(&world, joint));
            assert!(gaps[0] < 2.8 && gaps[1] < 1.0e-2, "{gaps:?}");
            assert!(norm(spin(&world, a)).is_finite());
        }
    }
}

/// At 90 degrees of the middle turn two axes are one: nothing breaks.
#[test]
fn a_gimbal_locks_without_harm() {
    let (mut world, base) = jointed(1, 2, 4);
    let body = massive(&mut world, at(Vec3::X), rod(1.0, 1.0));
    let mut def = JointDef::ball([base, body], [Pose::IDENTITY, at(-Vec3::X)]);
    for axis in 3..6 {
        def.axes[axis] = Axis { friction: 0.05, ..Axis::limited(-2.0, 2.0) };
    }
    def.axes[TURN_Y].drive = Some(Drive::spring(1.57, Spring::Frequency { hertz: 2.0, damping_ratio: 1.0 }));
    let joint = world.create_joint(&def).expect("room");
    let start = energy(&world, body, GRAVITY);
    for _ in 0..600 {
        world.apply_torque(body, Vec3::new(0.2, 0.0, 0.3)).expect("dynamic");
        world.step(&mut Serial);
        assert!(energy(&world, body, GRAVITY) < start + 200.0);
        assert!(gap(&world, joint) < 1.0e-2);
    }
}

/// Steps of no length change nothing.
#[test]
fn time_may_stand_still() {
    let (mut world, base) = jointed(1, 1, 4);
    let body = massive(&mut world, at(Vec3::X), ball(1.0, 0.2));
    let joint =
        world.create_joint(&JointDef::ball([base, body], [Pose::IDENTITY, at(-Vec3::X)])).expect("room");
    run(&mut world, 10);
    let stand = |world: &mut OwnedWorld, dt| {
        let settings = Settings { dt, ..world.settings() };
        world.set_settings(&settings).expect("in range");
    };
    let before = (center(&world, body), velocity(&world, body), world.joint_force(joint));
    stand(&mut world, 0.0);
    run(&mut world, 3);
    assert_eq!((center(&world, body), velocity(&world, body), world.joint_force(joint)), before);
    stand(&mut world, 1.0 / 60.0);
    run(&mut world, 10);
    assert!(gap(&world, joint) < 1.0e-4);
}
