//! Motors, position drives, frictions, wheels, gears and racks.

use cellstep::joint::axis::{TURN_X, TURN_Z, X, Z};
use cellstep::math::{PI, Pose, Rotation, Vec3};
use cellstep::{Axis, BodyHandle, Drive, JointDef, JointHandle, Serial, Spring};
use cellstep_tests::jointed::{
    Bar, about_y, at, ball, coordinate, force, gap, jointed, massive, rod, torque, weightless,
};
use cellstep_tests::oracles::{GRAVITY, judge, norm, relative, spin, turned, velocity};
use cellstep_tests::worlds::{OwnedWorld, run};

/// A rod of 1 kg and 1 m on a hinge at its start, held out along x, with a drive about the world's y axis.
fn driven(drive: Drive, has_weight: bool) -> (OwnedWorld, BodyHandle, JointHandle) {
    let (mut world, base) = jointed(1, 1, 4);
    if !has_weight {
        weightless(&mut world);
    }
    let bar = Bar::new(&mut world, Vec3::ZERO, Vec3::X);
    let (body, frame) = bar.end(-1.0);
    let mut def = JointDef::hinge([base, body], [Pose::new(Vec3::ZERO, about_y()), frame]);
    def.axes[TURN_X].drive = Some(drive);
    let joint = world.create_joint(&def).expect("room");
    (world, body, joint)
}

#[test]
fn a_motor_reaches_its_velocity_with_its_torque() {
    // The moment about the hinge is 1/3 kg m2: 2 N m give 6 rad/s2.
    let (mut world, body, joint) = driven(Drive::motor(5.0, 2.0), false);
    for step in 1..=120 {
        world.step(&mut Serial);
        let expected = (6.0 * f64::from(step) / 60.0).min(5.0);
        judge("motor, speed", (spin(&world, body)[1] - expected).abs() / 5.0, [1.0e-4, 2.0e-3]);
        if step < 45 {
            judge("motor, torque", relative(torque(&world, joint)[1], 2.0), [1.0e-5, 1.0e-4]);
        }
    }
    // Backwards, without a bound: at once.
    let axis = Axis { drive: Some(Drive::motor(-3.0, f32::INFINITY)), ..Axis::FREE };
    world.set_joint_axis(joint, TURN_X, &axis).expect("in range");
    run(&mut world, 1);
    judge("motor without bound, speed", relative(spin(&world, body)[1], -3.0), [1.0e-4, 1.0e-3]);
}

#[test]
fn a_motor_stalls_at_its_torque() {
    for (load, moves) in [(2.99, false), (3.01, true)] {
        let (mut world, body, _) = driven(Drive::motor(0.0, 3.0), false);
        for _ in 0..120 {
            world.apply_torque(body, Vec3::new(0.0, load, 0.0)).expect("dynamic");
            world.step(&mut Serial);
        }
        // 0.01 N m on 1/3 kg m2 for 2 s.
        let expected = if moves { 0.06 } else { 0.0 };
        judge(
            &format!("stall at 3, load {load}"),
            (spin(&world, body)[1] - expected).abs(),
            [1.0e-4, 1.0e-3],
        );
    }
    // A motor that is strong enough bears a weight.
    let (mut world, body, joint) = driven(Drive::motor(0.0, 6.0), true);
    run(&mut world, 300);
    judge("motor bears a rod, torque", relative(torque(&world, joint)[1], -0.5 * GRAVITY), [1.0e-4, 1.0e-3]);
    assert!(norm(spin(&world, body)) < 1.0e-4);
    judge("motor bears a rod, creep in 5 s", coordinate(&world, joint, TURN_X).abs(), [1.0e-5, 1.0e-3]);
}

#[test]
fn position_drives_reach_their_target() {
    let spring = Spring::Frequency { hertz: 3.0, damping_ratio: 1.0 };
    for target in [0.7_f32, -2.0, 3.1, 10.0] {
        let (mut world, body, joint) = driven(Drive::spring(target, spring), false);
        let mut way = 0.0;
        for _ in 0..300 {
            world.step(&mut Serial);
            way += spin(&world, body)[1] / 60.0;
        }
        let wrapped = (coordinate(&world, joint, TURN_X) - f64::from(target)) / (2.0 * f64::from(PI));
        judge(
            &format!("drive to {target}"),
            f64::from(2.0 * PI) * (wrapped - wrapped.round()).abs(),
            [1.0e-4, 1.0e-3],
        );
        assert!((way - f64::from(target)).abs() < 0.5, "it turns by {way}, not by the shortest way");
        assert!(norm(spin(&world, body)) < 1.0e-3 && gap(&world, joint) < 1.0e-4);
    }
    // With a bound it gets there too, later, and a weight holds it off by its stiffness.
    let weak = Drive { max_force: 0.5, ..Drive::spring(1.0, spring) };
    let (mut world, _, joint) = driven(weak, false);
    run(&mut world, 600);
    judge("weak drive to 1", (coordinate(&world, joint, TURN_X) - 1.0).abs(), [1.0e-3, 1.0e-2]);
    let stiff = Spring::Stiffness { stiffness: 200.0, damping: 20.0 };
    let (mut world, _, joint) = driven(Drive::spring(0.0, stiff), true);
    run(&mut world, 600);
    let angle = coordinate(&world, joint, TURN_X);
    judge(
        "200 N m/rad under a rod, angle",
        relative(200.0 * angle, 0.5 * GRAVITY * angle.cos()),
        [1.0e-3, 1.0e-2],
    );
}

#[test]
fn a_damper_follows_the_velocity_of_its_drive() {
    // Without stiffness the damper alone: w' = c (v - w) / I.
    let spring = Some(Spring::Stiffness { stiffness: 0.0, damping: 2.0 });
    let (mut world, body, _) =
        driven(Drive { velocity: 4.0, spring, ..Drive::motor(0.0, f32::INFINITY) }, false);
    run(&mut world, 30);
    let expected = 4.0 * (1.0 - (1.0_f64 + 6.0 / 240.0).powi(-120));
    judge("damper at 4 rad/s", relative(spin(&world, body)[1], expected), [1.0e-4, 1.0e-3]);
}

/// A ball of 2 kg on a slider along x, without gravity.
fn sliding(axis: Axis) -> (OwnedWorld, BodyHandle, JointHandle) {
    let (mut world, base) = jointed(1, 1, 4);
    weightless(&mut world);
    let body = massive(&mut world, Pose::IDENTITY, ball(2.0, 0.2));
    let mut def = JointDef::slider([base, body], [Pose::IDENTITY; 2]);
    def.axes[X] = axis;
    let joint = world.create_joint(&def).expect("room");
    (world, body, joint)
}

#[test]
fn a_slider_drives_with_its_force() {
    let (mut world, body, joint) = sliding(Axis { drive: Some(Drive::motor(1.0, 10.0)), ..Axis::FREE });
    for step in 1..=60 {
        world.step(&mut Serial);
        let expected = (5.0 * f64::from(step) / 60.0).min(1.0);
        judge("slider motor, speed", (velocity(&world, body)[0] - expected).abs(), [1.0e-5, 1.0e-4]);
    }
    let axis = Axis {
        drive: Some(Drive::spring(-2.0, Spring::Frequency { hertz: 2.0, damping_ratio: 1.0 })),
        ..Axis::FREE
    };
    world.set_joint_axis(joint, X, &axis).expect("in range");
    run(&mut world, 300);
    judge("slider drive to -2, m", (coordinate(&world, joint, X) + 2.0).abs(), [1.0e-4, 1.0e-3]);
}

#[test]
fn friction_sticks_below_and_slides_above() {
    for (load, speed) in [(4.99, 0.0), (5.01, 0.005), (8.0, 1.5)] {
        let (mut world, body, joint) = sliding(Axis { friction: 5.0, ..Axis::FREE });
        for _ in 0..60 {
            world.apply_force(body, Vec3::new(load, 0.0, 0.0)).expect("dynamic");
            world.step(&mut Serial);
        }
        judge(
            &format!("friction of 5 N under {load}"),
            (velocity(&world, body)[0] - speed).abs(),
            [1.0e-5, 1.0e-3],
        );
        let expected = -f64::from(load).min(5.0);
        judge("its force", relative(force(&world, joint)[0], expected), [1.0e-4, 1.0e-3]);
    }
    // About a hinge: 0.5 N m stop 3 rad/s on 1/3 kg m2 in 2 s.
    let (mut world, body, joint) = driven(Drive::motor(0.0, 0.0), false);
    world.set_joint_axis(joint, TURN_X, &Axis { friction: 0.5, ..Axis::FREE }).expect("in range");
    world.set_angular_velocity(body, Vec3::new(0.0, 3.0, 0.0)).expect("dynamic");
    world.set_linear_velocity(body, Vec3::new(0.0, 0.0, -1.5)).expect("dynamic");
    run(&mut world, 60);
    judge("hinge with friction, half way", relative(spin(&world, body)[1], 1.5), [1.0e-3, 1.0e-2]);
    run(&mut world, 90);
    assert!(norm(spin(&world, body)) < 1.0e-5, "{:?}", spin(&world, body));
}

/// Mass and moments of a wheel about x.
fn disc(mass: f32, radius: f32) -> cellstep::MassProperties {
    let about = 0.5 * mass * radius * radius;
    cellstep::MassProperties {
        mass,
        inertia: Vec3::new(about, 0.5 * about, 0.5 * about),
        ..Default::default()
    }
}

#[test]
fn a_suspension_sinks_by_its_load() {
    let (mut world, base) = jointed(1, 1, 4);
    let chassis = massive(&mut world, Pose::IDENTITY, ball(100.0, 0.5));
    let spring = Spring::Stiffness { stiffness: 1.0e4, damping: 1.0e3 };
    let def = JointDef::wheel([chassis, base], [Pose::IDENTITY; 2], spring);
    let joint = world.create_joint(&def).expect("room");
    run(&mut world, 600);
    judge(
        "suspension, sag",
        relative(coordinate(&world, joint, Z), 100.0 * GRAVITY / 1.0e4),
        [1.0e-4, 1.0e-3],
    );
    judge("suspension, force", relative(force(&world, joint)[2], -100.0 * GRAVITY), [1.0e-5, 1.0e-4]);
}

#[test]
fn a_wheel_spins_and_steers() {
    let (mut world, base) = jointed(2, 2, 4);
    weightless(&mut world);
    let chassis = massive(&mut world, at(Vec3::new(1.0, 0.0, 0.0)), ball(100.0, 0.5));
    world.create_joint(&JointDef::fixed([base, chassis], [at(Vec3::X), Pose::IDENTITY])).expect("room");
    let wheel = massive(&mut world, Pose::IDENTITY, disc(10.0, 0.3));
    let spring = Spring::Frequency { hertz: 2.0, damping_ratio: 0.7 };
    let mut def = JointDef::wheel([chassis, wheel], [at(Vec3::new(-1.0, 0.0, 0.0)), Pose::IDENTITY], spring);
    let joint = world.create_joint(&def).expect("room");
    world.set_angular_velocity(wheel, Vec3::new(20.0, 0.0, 0.0)).expect("dynamic");
    run(&mut world, 120);
    judge("wheel spins free 2 s", relative(spin(&world, wheel)[0], 20.0), [1.0e-5, 1.0e-4]);
    // A motor brings it to 30 rad/s; then it is steered while it spins.
    def.axes[TURN_X].drive = Some(Drive::motor(30.0, 20.0));
    let steering = Spring::Frequency { hertz: 4.0, damping_ratio: 1.0 };
    def.axes[TURN_Z] = Axis { drive: Some(Drive::spring(0.4, steering)), ..Axis::limited(-0.6, 0.6) };
    world.set_joint(joint, &def).expect("in range");
    run(&mut world, 240);
    judge("steered wheel, angle", (coordinate(&world, joint, TURN_Z) - 0.4).abs(), [1.0e-3, 1.0e-2]);
    let axle = turned(world.rotation(wheel).expect("it exists"), [1.0, 0.0, 0.0]);
    let expected = [0.4_f64.cos(), 0.4_f64.sin(), 0.0];
    judge(
        "steered wheel, axle",
        norm([axle[0] - expected[0], axle[1] - expected[1], axle[2]]),
        [1.0e-3, 1.0e-2],
    );
    let w = spin(&world, wheel);
    judge(
        "steered wheel, spin",
        relative(w[0] * axle[0] + w[1] * axle[1] + w[2] * axle[2], 30.0),
        [1.0e-3, 1.0e-2],
    );
}

/// Adds an angle's change to a sum that counts turns.
fn count(sum: &mut f64, angle: f64) {
    let turn = 2.0 * core::f64::consts::PI;
    let change = angle - *sum;
    *sum += change - turn * (change / turn).round();
}

#[test]
fn gears_keep_their_ratio() {
    for ratio in [2.0_f32, -0.4] {
        let (mut world, base) = jointed(2, 3, 4);
        let wheels = [0.0_f32, 1.0].map(|y| massive(&mut world, at(Vec3::new(0.0, y, 0.0)), disc(2.0, 0.3)));
        let hinges = [0, 1].map(|i| {
            let mut def =
                JointDef::hinge([base, wheels[i]], [at(Vec3::new(0.0, i as f32, 0.0)), Pose::IDENTITY]);
            if i == 0 {
                def.axes[TURN_X].drive = Some(Drive::motor(6.0, 50.0));
            } else {
                def.axes[TURN_X].friction = 1.0;
            }
            world.create_joint(&def).expect("room")
        });
        let gear = world.create_joint(&JointDef::gear(wheels, [Pose::IDENTITY; 2], ratio)).expect("room");
        let (mut turns, mut worst) = ([0.0; 2], 0.0_f64);
        for step in 0..1000 {
            if step == 500 {
                let axis = Axis { drive: Some(Drive::motor(-9.0, 50.0)), ..Axis::FREE };
                world.set_joint_axis(hinges[0], TURN_X, &axis).expect("in range");
            }
            world.step(&mut Serial);
            for (sum, &hinge) in turns.iter_mut().zip(&hinges) {
                count(sum, coordinate(&world, hinge, TURN_X));
            }
            worst = worst.max((turns[0] + f64::from(ratio) * turns[1]).abs());
        }
        assert!((turns[0] - (50.0 - 75.0)).abs() < 2.0, "it turns by {}", turns[0]);
        judge(&format!("gear {ratio}, slip in 1,000 steps"), worst, [1.0e-4, 1.0e-2]);
        // The follower's friction comes through the gear.
        let expected = torque(&world, gear)[0];
        judge(&format!("gear {ratio}, torque"), relative(expected.abs(), 1.0), [1.0e-4, 1.0e-2]);
    }
}

#[test]
fn a_rack_goes_with_its_pinion() {
    for ratio in [0.25_f32, -0.1] {
        let (mut world, base) = jointed(2, 3, 4);
        let pinion = massive(&mut world, Pose::IDENTITY, disc(2.0, 0.25));
        let along = Rotation::from_axis_angle(Vec3::Z, 0.5 * PI);
        let rack = massive(&mut world, at(Vec3::new(0.0, 0.0, -0.25)), rod(3.0, 2.0));
        let mut hinge = JointDef::hinge([base, pinion], [Pose::IDENTITY; 2]);
        hinge.axes[TURN_X].drive = Some(Drive::motor(2.0, 100.0));
        let hinge = world.create_joint(&hinge).expect("room");
        let frames = [Pose::new(Vec3::new(0.0, 0.0, -0.25), along), Pose::new(Vec3::ZERO, along)];
        let mut slide = JointDef::slider([base, rack], frames);
        slide.axes[X].friction = 4.0;
        let slide = world.create_joint(&slide).expect("room");
        let frames = [Pose::IDENTITY, Pose::new(Vec3::ZERO, along)];
        let mesh = world.create_joint(&JointDef::rack([pinion, rack], frames, ratio)).expect("room");
        let (mut turn, mut worst) = (0.0, 0.0_f64);
        for _ in 0..1000 {
            world.step(&mut Serial);
            count(&mut turn, coordinate(&world, hinge, TURN_X));
            worst = worst.max((coordinate(&world, slide, X) - f64::from(ratio) * turn).abs());
        }
        assert!((turn - 2.0 * 1000.0 / 60.0).abs() < 0.5, "it turns by {turn}");
        judge(&format!("rack {ratio}, slip in 1,000 steps, m"), worst, [1.0e-4, 1.0e-2]);
        judge(&format!("rack {ratio}, force"), relative(norm(force(&world, mesh)), 4.0), [1.0e-4, 1.0e-2]);
    }
}
