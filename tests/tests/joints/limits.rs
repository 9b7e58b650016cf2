//! Limits hold under load and give no energy; ropes, rods and springs between points.

use cellstep::joint::axis::{TURN_X, TURN_Y, TURN_Z, X, Y, Z};
use cellstep::math::{PI, Pose, Rotation, Vec3};
use cellstep::{Axis, AxisMotion, BodyHandle, JointDef, JointHandle, Serial, Spring};
use cellstep_tests::jointed::{
    Bar, about_y, at, ball, coordinate, energy, force, gap, jointed, massive, torque,
};
use cellstep_tests::oracles::{GRAVITY, center, dot, judge, norm, relative, spin, turned, velocity, wide};
use cellstep_tests::worlds::{OwnedWorld, run};

/// Greatest sine of what a limit may be beyond, here and below: 2 mrad.
const BEYOND: f64 = 2.0e-3;

/// A rod on a ball joint whose x axes both point down, under a cone, pushed aside at a speed.
fn under_cone(cone: f32, push: Vec3) -> (OwnedWorld, BodyHandle, JointHandle) {
    let (mut world, base) = jointed(1, 1, 4);
    let bar = Bar::new(&mut world, Vec3::ZERO, Vec3::new(0.0, 0.0, -1.0));
    let down = Rotation::between(Vec3::X, Vec3::new(0.0, 0.0, -1.0));
    let frames = [Pose::new(Vec3::ZERO, down), at(Vec3::new(-0.5, 0.0, 0.0))];
    let def = JointDef { cone: Some(cone), ..JointDef::ball([base, bar.body], frames) };
    let joint = world.create_joint(&def).expect("room");
    world.set_angular_velocity(bar.body, push).expect("dynamic");
    (world, bar.body, joint)
}

/// Angle of a body's x axis from straight down.
fn lean(world: &OwnedWorld, body: BodyHandle) -> f64 {
    let x = turned(world.rotation(body).expect("it exists"), [1.0, 0.0, 0.0]);
    x[0].hypot(x[1]).atan2(-x[2])
}

#[test]
fn a_cone_holds_and_gives_no_energy() {
    for (cone, push) in [(0.5, 18.0), (1.0, 24.0), (0.05, 6.0), (2.0, 40.0)] {
        let (mut world, body, joint) = under_cone(cone, Vec3::new(0.0, push, 1.0));
        world.step(&mut Serial);
        let start = energy(&world, body, GRAVITY);
        let (mut most, mut leans, mut widest) = (f64::MIN, 0.0_f64, 0.0_f64);
        for _ in 0..600 {
            world.step(&mut Serial);
            most = most.max(energy(&world, body, GRAVITY));
            leans = leans.max(lean(&world, body));
            widest = widest.max(gap(&world, joint));
        }
        assert!(leans > f64::from(cone) - 0.1, "the cone {cone} is reached: {leans}");
        // A substep at speed may end beyond by what the axis turns in it.
        judge(&format!("cone of {cone}, beyond it"), leans - f64::from(cone), [BEYOND, 2.0e-2]);
        // Of what there is above hanging: the push back at a fast turn lifts the rod a little.
        let gain = (most - start) / (start + 0.5 * GRAVITY);
        judge(&format!("cone of {cone}, energy gained"), gain, [1.0e-4, 1.0e-2]);
        assert!(widest < 1.0e-3, "cone of {cone}: gap {widest}");
    }
}

#[test]
fn a_cone_bears_a_load() {
    // Sideways gravity presses the rod against the cone.
    let (mut world, body, joint) = under_cone(0.6, Vec3::ZERO);
    let mut settings = world.settings();
    settings.gravity = Vec3::new(20.0, 0.0, 0.0);
    world.set_settings(&settings).expect("in range");
    run(&mut world, 900);
    judge("cone under load, angle", (lean(&world, body) - 0.6).abs(), [BEYOND, 1.0e-2]);
    // Torque about the joint: m g l / 2 cos(0.6) with the rod of 1 kg.
    let expected = 10.0 * 0.6_f64.cos();
    judge("cone under load, torque", relative(norm(torque(&world, joint)), expected), [1.0e-3, 1.0e-2]);
    assert!(norm(velocity(&world, body)) < 1.0e-3, "it is at rest");
}

#[test]
fn a_twist_limit_holds_however_the_ball_swings() {
    let (mut world, base) = jointed(1, 1, 4);
    let bar = Bar::new(&mut world, Vec3::ZERO, Vec3::new(0.0, 0.0, -1.0));
    let down = Rotation::between(Vec3::X, Vec3::new(0.0, 0.0, -1.0));
    let frames = [Pose::new(Vec3::ZERO, down), at(Vec3::new(-0.5, 0.0, 0.0))];
    let mut def = JointDef::ball([base, bar.body], frames);
    def.axes[TURN_X] = Axis::limited(-0.4, 0.7);
    let joint = world.create_joint(&def).expect("room");
    for (spin, side) in [(-30.0_f32, 0.7), (30.0, -0.4)] {
        world.set_angular_velocity(bar.body, Vec3::new(2.0, 3.0, spin)).expect("dynamic");
        let (mut least, mut greatest) = (f64::MAX, f64::MIN);
        for _ in 0..300 {
            world.step(&mut Serial);
            let twist = coordinate(&world, joint, TURN_X);
            (least, greatest) = (least.min(twist), greatest.max(twist));
        }
        println!("twist from {least} to {greatest}");
        assert!(least > -0.4 - 0.05 && greatest < 0.7 + 0.05, "{least} to {greatest}");
        let reached = if side > 0.0 { greatest } else { least };
        assert!((reached - side).abs() < 0.05, "the limit {side} is reached: {reached}");
    }
}

/// A rod on a hinge with a range, held out along x at angle 0.
fn barrier(lower: f32, upper: f32) -> (OwnedWorld, BodyHandle, JointHandle) {
    let (mut world, base) = jointed(1, 1, 4);
    let bar = Bar::new(&mut world, Vec3::ZERO, Vec3::X);
    let (body, frame) = bar.end(-1.0);
    let mut def = JointDef::hinge([base, body], [Pose::new(Vec3::ZERO, about_y()), frame]);
    def.axes[TURN_X] = Axis::limited(lower, upper);
    let joint = world.create_joint(&def).expect("room");
    (world, body, joint)
}

#[test]
fn a_hinge_stops_at_its_limits() {
    // It falls, which is a positive turn about y, onto the upper limit.
    let (mut world, body, joint) = barrier(-0.3, 0.5);
    let start = energy(&world, body, GRAVITY);
    let mut most = 0.0_f64;
    for _ in 0..300 {
        world.step(&mut Serial);
        most = most.max(coordinate(&world, joint, TURN_X));
        assert!(energy(&world, body, GRAVITY) <= start + 1.0e-3);
    }
    judge("hinge falls on its limit, beyond", most - 0.5, [BEYOND, 1.0e-2]);
    judge("hinge on its limit, angle", (coordinate(&world, joint, TURN_X) - 0.5).abs(), [1.0e-4, BEYOND]);
    let expected = 0.5 * GRAVITY * 0.5_f64.cos();
    judge("hinge on its limit, torque", relative(norm(torque(&world, joint)), expected), [1.0e-4, 1.0e-3]);
    // Up against the lower one.
    world.apply_angular_impulse(body, Vec3::new(0.0, -3.0, 0.0)).expect("dynamic");
    let mut least = 0.0_f64;
    for _ in 0..60 {
        world.step(&mut Serial);
        least = least.min(coordinate(&world, joint, TURN_X));
    }
    judge("hinge flung to its limit, beyond", -0.3 - least, [BEYOND, 2.0e-2]);
    assert!(least < -0.29, "the limit is reached: {least}");
}

#[test]
fn one_sided_and_endless_limits() {
    for (lower, upper) in
        [(f32::NEG_INFINITY, 0.5), (f32::NEG_INFINITY, f32::INFINITY), (-10.0, f32::INFINITY)]
    {
        let (mut world, body, joint) = barrier(lower, upper);
        run(&mut world, 240);
        let stops = upper.is_finite();
        let turn = coordinate(&world, joint, TURN_X);
        assert_eq!(
            stops,
            (turn - 0.5).abs() < BEYOND && norm(spin(&world, body)) < 1.0e-2,
            "{upper}: {turn}"
        );
        assert!(gap(&world, joint) < 1.0e-3);
        // The hinge bears the rod: it did not forget its impulses.
        assert!(norm(force(&world, joint)) > 1.0, "{lower}, {upper}");
    }
}

#[test]
fn turns_count_beyond_half_a_turn() {
    // Three turns up, then on the limit; and back to the other.
    let (mut world, body, joint) = barrier(-15.0, 20.0);
    let mut settings = world.settings();
    settings.gravity = Vec3::ZERO;
    world.set_settings(&settings).expect("in range");
    let mut way = 0.0_f64;
    for (speed, end) in [(12.0_f64, 20.0), (-12.0, -15.0)] {
        world.set_angular_velocity(body, Vec3::new(0.0, speed as f32, 0.0)).expect("dynamic");
        world.set_linear_velocity(body, velocity_of(&world, body, speed)).expect("dynamic");
        let mut farthest = way;
        for _ in 0..240 {
            world.step(&mut Serial);
            way += spin(&world, body)[1] / 60.0;
            farthest = if speed > 0.0 { farthest.max(way) } else { farthest.min(way) };
        }
        assert!((farthest - end).abs() < 0.25, "it turns to {farthest}, the limit is {end}");
        // It stops there: a limit does not bounce.
        let back = spin(&world, body)[1] / -speed;
        assert!(back.abs() < 0.01, "it comes back with {back} of its speed");
        let wrapped = (coordinate(&world, joint, TURN_X) - way) / (2.0 * f64::from(PI));
        assert!((wrapped - wrapped.round()).abs() < 0.05, "the coordinate is the turn");
    }
}

/// Velocity of the center of a rod that turns about its end at the origin.
fn velocity_of(world: &OwnedWorld, body: BodyHandle, speed: f64) -> Vec3 {
    let c = center(world, body);
    Vec3::new((speed * c[2]) as f32, 0.0, (-speed * c[0]) as f32)
}

#[test]
fn a_slider_stops_at_its_limits() {
    let (mut world, base) = jointed(1, 1, 4);
    let body = massive(&mut world, Pose::IDENTITY, ball(2.0, 0.2));
    let up = Rotation::between(Vec3::X, Vec3::Z);
    let mut def = JointDef::slider([base, body], [Pose::new(Vec3::ZERO, up); 2]);
    def.axes[X] = Axis::limited(-1.5, 0.5);
    let joint = world.create_joint(&def).expect("room");
    let mut least = 0.0_f64;
    for _ in 0..300 {
        world.step(&mut Serial);
        least = least.min(coordinate(&world, joint, X));
    }
    judge("slider falls on its limit, beyond, m", -1.5 - least, [1.0e-3, 2.0e-2]);
    judge("slider on its limit, m", (coordinate(&world, joint, X) + 1.5).abs(), [1.0e-4, 1.0e-3]);
    judge("slider on its limit, force", relative(force(&world, joint)[2], 2.0 * GRAVITY), [1.0e-5, 1.0e-4]);
}

#[test]
fn a_soft_limit_gives_by_its_stiffness() {
    let (mut world, base) = jointed(1, 1, 4);
    let body = massive(&mut world, Pose::IDENTITY, ball(2.0, 0.2));
    let up = Rotation::between(Vec3::X, Vec3::Z);
    let mut def = JointDef::slider([base, body], [Pose::new(Vec3::ZERO, up); 2]);
    let spring = Spring::Stiffness { stiffness: 1000.0, damping: 60.0 };
    def.axes[X] = Axis { limit_spring: Some(spring), ..Axis::limited(-0.5, 0.5) };
    let joint = world.create_joint(&def).expect("room");
    let mut untouched = 0.0_f64;
    for step in 0..600 {
        world.step(&mut Serial);
        if coordinate(&world, joint, X) > -0.4 {
            // Not felt before it is reached.
            untouched =
                untouched.max((velocity(&world, body)[2] + GRAVITY * f64::from(step + 1) / 60.0).abs());
        }
    }
    assert!(untouched < 1.0e-4, "{untouched}");
    let sag = -0.5 - coordinate(&world, joint, X);
    judge("soft limit, sag", relative(sag, 2.0 * GRAVITY / 1000.0), [1.0e-3, 1.0e-2]);
}

#[test]
fn a_fixed_joint_keeps_its_frames() {
    let (mut world, base) = jointed(1, 1, 4);
    let skew = Rotation::new(0.3, -0.2, 0.5, 0.7).normalized();
    let pose = Pose::new(Vec3::new(0.4, 0.3, -0.2), skew);
    let body = massive(&mut world, pose, ball(2.0, 0.2));
    let joint = world.create_joint(&JointDef::fixed([base, body], [pose, Pose::IDENTITY])).expect("room");
    for _ in 0..300 {
        world.apply_torque(body, Vec3::new(30.0, -20.0, 10.0)).expect("dynamic");
        world.step(&mut Serial);
    }
    let c = world.joint_coordinates(joint).expect("it exists").map(f64::from);
    judge("fixed, gap, m", norm([c[0], c[1], c[2]]), [1.0e-5, 1.0e-4]);
    judge("fixed, angle", norm([c[3], c[4], c[5]]), [1.0e-5, 1.0e-4]);
}

#[test]
fn a_rod_keeps_and_a_rope_limits_the_distance() {
    // Two weights swing: one on a rod, one on a rope that hangs slack first.
    let (mut world, base) = jointed(2, 2, 4);
    let on_rod = massive(&mut world, at(Vec3::new(1.0, 0.0, 0.0)), ball(1.0, 0.1));
    let on_rope = massive(&mut world, at(Vec3::new(0.6, 5.0, 0.0)), ball(1.0, 0.1));
    let rod = JointDef::distance([base, on_rod], [Vec3::ZERO; 2], 1.0, 1.0);
    let rod = world.create_joint(&rod).expect("room");
    let rope = JointDef::distance([base, on_rope], [Vec3::new(0.0, 5.0, 0.0), Vec3::ZERO], 0.0, 1.0);
    let rope = world.create_joint(&rope).expect("room");
    let start = [on_rod, on_rope].map(|body| energy(&world, body, GRAVITY));
    let (mut off, mut long, mut slack) = (0.0_f64, 0.0_f64, true);
    for step in 1..=600 {
        world.step(&mut Serial);
        off = off.max((coordinate(&world, rod, X) - 1.0).abs());
        long = long.max(coordinate(&world, rope, X));
        // It falls freely until the rope is taut, from 0.6 m aside after 0.8 m.
        let fall = 0.5 * GRAVITY * f64::from(step * step) / 3600.0;
        slack &= fall < 0.75;
        if slack {
            assert!(norm(force(&world, rope)) == 0.0, "slack at step {step}");
            assert!((velocity(&world, on_rope)[2] + GRAVITY * f64::from(step) / 60.0).abs() < 1.0e-4);
        }
        assert!(energy(&world, on_rope, GRAVITY) <= start[1] + 1.0e-3, "step {step}");
    }
    judge("rod, distance, m", off, [1.0e-4, 5.0e-4]);
    judge("rope, beyond its length, m", long - 1.0, [1.0e-3, 1.0e-2]);
    let kept = (energy(&world, on_rod, GRAVITY) - start[0]).abs() / GRAVITY;
    judge("rod, energy in 10 s", kept, [1.0e-3, 1.0e-2]);
}

#[test]
fn axes_of_a_six_axis_joint_are_their_own() {
    // x limited, y locked off zero, z a spring; the turns free, limited and locked.
    let (mut world, base) = jointed(1, 1, 4);
    let body = massive(&mut world, at(Vec3::new(0.0, 0.25, 0.0)), ball(1.0, 0.2));
    let mut def = JointDef::six_axis([base, body], [Pose::IDENTITY; 2]);
    def.axes[X] = Axis::limited(-0.5, 0.5);
    def.axes[Y].motion = AxisMotion::Limited { lower: 0.25, upper: 0.25 };
    let spring = Spring::Stiffness { stiffness: 300.0, damping: 20.0 };
    def.axes[Z].drive = Some(cellstep::Drive::spring(0.1, spring));
    def.axes[TURN_Y] = Axis::limited(-0.3, 0.3);
    def.axes[TURN_Z] = Axis::LOCKED;
    let joint = world.create_joint(&def).expect("room");
    for _ in 0..600 {
        world.apply_force(body, Vec3::new(8.0, 5.0, 0.0)).expect("dynamic");
        world.apply_torque(body, Vec3::new(0.0, 1.0, 1.0)).expect("dynamic");
        world.step(&mut Serial);
    }
    let c = world.joint_coordinates(joint).expect("it exists").map(f64::from);
    // The turn about x is free.
    let expected = [0.5, 0.25, 0.1 - GRAVITY / 300.0, c[3], 0.3, 0.0];
    for (axis, (found, expected)) in c.iter().zip(expected).enumerate() {
        judge(&format!("six-axis, coordinate {axis}"), (found - expected).abs(), [1.0e-4, 1.0e-3]);
    }
    let (f, t) = (force(&world, joint), torque(&world, joint));
    for (axis, (found, expected)) in f.iter().zip([-8.0, -5.0, GRAVITY]).enumerate() {
        judge(&format!("six-axis, force {axis}"), (found - expected).abs() / 10.0, [1.0e-4, 1.0e-3]);
    }
    // About z the torque is the load's and what the limit about the turned y axis gives; about y its load.
    judge("six-axis, torque about y", relative(t[1], -1.0), [1.0e-3, 1.0e-2]);
    // A free turn about x goes on.
    world.set_angular_velocity(body, Vec3::new(2.0, 0.0, 0.0)).expect("dynamic");
    run(&mut world, 1);
    let axis = wide(Vec3::X);
    assert!(dot(spin(&world, body), axis) > 1.5, "{:?}", spin(&world, body));
}
