//! Partners: kinematic, static on either side, in other sectors, with locked axes, slender, and beyond number.

use cellstep::joint::axis::{TURN_X, X};
use cellstep::math::{PI, Pose, Rotation, Vec3};
use cellstep::{
    Axis, AxisLocks, BodyDef, BodyHandle, BodyKind, Drive, JointDef, MassProperties, Position, Serial,
};
use cellstep_tests::jointed::{
    Bar, about_y, at, ball, coordinate, energy, force, gap, jointed, massive, rod, torque, weightless,
};
use cellstep_tests::oracles::{GRAVITY, center, judge, minus, norm, plus, relative, spin, velocity};
use cellstep_tests::worlds::{OwnedWorld, run};

fn kinematic(world: &mut OwnedWorld, place: Vec3) -> BodyHandle {
    world.create_body(&BodyDef::new(BodyKind::Kinematic, place)).expect("room")
}

#[test]
fn a_moving_platform_carries_its_load() {
    for dynamic_first in [false, true] {
        let (mut world, _) = jointed(2, 1, 4);
        let platform = kinematic(&mut world, Vec3::ZERO);
        let body = massive(&mut world, at(Vec3::new(0.0, 0.0, -1.0)), ball(2.0, 0.2));
        let mut bodies = [platform, body];
        let mut frames = [Pose::IDENTITY, at(Vec3::new(0.0, 0.0, 1.0))];
        if dynamic_first {
            bodies.swap(0, 1);
            frames.swap(0, 1);
        }
        let joint = world.create_joint(&JointDef::fixed(bodies, frames)).expect("room");
        world.set_linear_velocity(platform, Vec3::new(1.5, 0.5, -0.25)).expect("kinematic");
        world.set_angular_velocity(platform, Vec3::new(0.0, 0.0, 1.0)).expect("kinematic");
        let mut widest = 0.0_f64;
        for _ in 0..300 {
            world.step(&mut Serial);
            widest = widest.max(gap(&world, joint));
        }
        judge("platform, gap, m", widest, [1.0e-4, 1.0e-3]);
        let expected = [7.5, 2.5, -2.25];
        judge("platform, place after 5 s, m", norm(minus(center(&world, body), expected)), [1.0e-3, 5.0e-3]);
        judge("platform, spin", (spin(&world, body)[2] - 1.0).abs(), [1.0e-4, 1.0e-3]);
        let sign = if dynamic_first { -1.0 } else { 1.0 };
        let f = force(&world, joint);
        judge("platform, force", relative(sign * f[2], 2.0 * GRAVITY), [1.0e-4, 1.0e-3]);
    }
}

#[test]
fn a_turning_motor_swings_its_arm() {
    // A kinematic axle at 3 rad/s holds an arm that is fixed to it 1 m off: centripetal force m w^2 r.
    let (mut world, _) = jointed(2, 1, 8);
    weightless(&mut world);
    let axle = kinematic(&mut world, Vec3::ZERO);
    world.set_angular_velocity(axle, Vec3::new(0.0, 0.0, 3.0)).expect("kinematic");
    let arm = massive(&mut world, at(Vec3::X), rod(2.0, 1.0));
    let joint =
        world.create_joint(&JointDef::fixed([axle, arm], [at(Vec3::X), Pose::IDENTITY])).expect("room");
    let mut widest = 0.0_f64;
    for _ in 0..600 {
        world.step(&mut Serial);
        widest = widest.max(gap(&world, joint));
    }
    judge("turning axle, gap, m", widest, [1.0e-4, 1.0e-3]);
    judge("turning axle, speed of the arm", relative(norm(velocity(&world, arm)), 3.0), [1.0e-3, 1.0e-2]);
    judge("turning axle, force", relative(norm(force(&world, joint)), 18.0), [1.0e-2, 5.0e-2]);
    judge("turning axle, radius, m", (norm(center(&world, arm)) - 1.0).abs(), [1.0e-4, 1.0e-3]);
}

/// What is static may be A or B: the bodies move alike, and force and torque have the other sign.
#[test]
fn sides_are_mirrored() {
    for kind in 0..4 {
        let worlds = [false, true].map(|dynamic_first| {
            let (mut world, base) = jointed(1, 1, 4);
            let bar = Bar::new(&mut world, Vec3::ZERO, Vec3::new(0.8, 0.0, -0.6));
            let (body, frame) = bar.end(-1.0);
            let mut bodies = [base, body];
            let mut frames = [Pose::new(Vec3::ZERO, about_y()), frame];
            if dynamic_first {
                bodies.swap(0, 1);
                frames.swap(0, 1);
            }
            let mut def = match kind {
                0 => JointDef::ball(bodies, frames),
                1 | 2 => JointDef::hinge(bodies, frames),
                _ => JointDef::distance(bodies, [frames[0].position; 2].map(|_| Vec3::ZERO), 0.5, 0.5),
            };
            if kind == 2 {
                let sign = if dynamic_first { -1.0 } else { 1.0 };
                def.axes[TURN_X] = Axis { friction: 0.1, ..Axis::limited(-0.4, 0.4) };
                def.axes[TURN_X].drive = Some(Drive::motor(-2.0 * sign, 1.0));
            }
            let joint = world.create_joint(&def).expect("room");
            run(&mut world, 60);
            (center(&world, body), force(&world, joint), torque(&world, joint))
        });
        let [(c0, f0, t0), (c1, f1, t1)] = worlds;
        judge(&format!("sides, kind {kind}, place, m"), norm(minus(c0, c1)), [1.0e-6, 1.0e-4]);
        judge(&format!("sides, kind {kind}, force"), norm(plus(f0, f1, 1.0)) / norm(f0), [1.0e-5, 1.0e-3]);
        judge(&format!("sides, kind {kind}, torque"), norm(plus(t0, t1, 1.0)) / GRAVITY, [1.0e-5, 1.0e-3]);
    }
}

#[test]
fn joints_cross_sectors() {
    // The same chain at the origin, and across the border of two sectors far out: the same but for rounding.
    let sway = |sector: [i32; 3], x: f32| {
        let (mut world, _) = jointed(5, 4, 4);
        let place = |p: Vec3| Position { sector, offset: Vec3::new(x, 0.0, 0.0) }.plus(p);
        let def = BodyDef { position: place(Vec3::ZERO), ..BodyDef::new(BodyKind::Static, Vec3::ZERO) };
        let mut last = world.create_body(&def).expect("room");
        let mut joints = Vec::new();
        for i in 0..4 {
            let body = massive(&mut world, Pose::IDENTITY, rod(1.0, 1.0));
            world
                .set_pose(body, place(Vec3::new(i as f32 + 0.5, 0.0, 0.0)), Rotation::IDENTITY)
                .expect("in range");
            let frames =
                [at(Vec3::new(if i == 0 { 0.0 } else { 0.5 }, 0.0, 0.0)), at(Vec3::new(-0.5, 0.0, 0.0))];
            joints.push(world.create_joint(&JointDef::ball([last, body], frames)).expect("room"));
            last = body;
        }
        let mut widest = 0.0_f64;
        for _ in 0..60 {
            world.step(&mut Serial);
            widest = joints.iter().map(|&joint| gap(&world, joint)).fold(widest, f64::max);
        }
        judge("chain, gap, m", widest, [1.0e-3, 5.0e-3]);
        let start = place(Vec3::ZERO).to_f64();
        minus(center(&world, last), start)
    };
    let near = sway([0; 3], 0.0);
    for (sector, x) in [([0; 3], 31.0), ([1_000_000, -4, 7], 31.5), ([-500_000, 0, 0], -31.0)] {
        let far = sway(sector, x);
        judge("chain over a border, end, m", norm(minus(near, far)), [1.0e-4, 1.0e-2]);
    }
}

#[test]
fn locked_axes_stay_locked() {
    // A pendulum that may not leave the plane x z nor turn about x and z; and a weight that moves along x only.
    let (mut world, base) = jointed(2, 2, 4);
    let bar = Bar::new(&mut world, Vec3::ZERO, Vec3::new(0.8, 0.0, -0.6));
    let locks = AxisLocks(AxisLocks::MOVE_Y.0 | AxisLocks::TURN_X.0 | AxisLocks::TURN_Z.0);
    world.set_locks(bar.body, locks).expect("it exists");
    world
        .create_joint(&JointDef::ball([base, bar.body], [Pose::IDENTITY, at(Vec3::new(-0.5, 0.0, 0.0))]))
        .expect("room");
    let bead = massive(&mut world, at(Vec3::new(2.0, 0.0, 0.0)), ball(1.0, 0.2));
    world.set_locks(bead, AxisLocks(AxisLocks::MOVE_Y.0 | AxisLocks::MOVE_Z.0)).expect("it exists");
    let rope = JointDef::distance([base, bead], [Vec3::new(0.0, 0.0, 1.0), Vec3::ZERO], 0.0, 1.5);
    let rope = world.create_joint(&rope).expect("room");
    let start = energy(&world, bar.body, GRAVITY);
    for _ in 0..300 {
        world.apply_force(bar.body, Vec3::new(0.0, 50.0, 0.0)).expect("dynamic");
        world.apply_force(bead, Vec3::new(3.0, 0.0, 0.0)).expect("dynamic");
        world.step(&mut Serial);
        let (w, c) = (spin(&world, bar.body), center(&world, bar.body));
        assert!(w[0] == 0.0 && w[2] == 0.0 && c[1] == 0.0, "{w:?} {c:?}");
        let c = center(&world, bead);
        assert!(c[1] == 0.0 && c[2] == 0.0, "{c:?}");
    }
    judge(
        "locked pendulum, energy",
        (energy(&world, bar.body, GRAVITY) - start).abs() / GRAVITY,
        [1.0e-3, 1.0e-2],
    );
    // sqrt(1.5^2 - 1) along x; the rope pulls with 3 N over the cosine.
    judge("bead on a rope, place, m", (center(&world, bead)[0] - 1.25_f64.sqrt()).abs(), [1.0e-4, 1.0e-3]);
    let expected = 3.0 * 1.5 / 1.25_f64.sqrt();
    judge("bead on a rope, force", relative(norm(force(&world, rope)), expected), [1.0e-4, 1.0e-3]);
}

#[test]
fn slender_rods_stay_calm_for_a_minute() {
    // Needles of 1 : 1e-3 in moments on ball joints, swinging in all directions.
    let (mut world, base) = jointed(6, 6, 4);
    let needle =
        |i: f32| MassProperties { mass: 1.0, inertia: Vec3::new(1.0e-3 * i, i, i), ..Default::default() };
    let mut bodies = Vec::new();
    for chain in 0..2 {
        let mut last = (base, Vec3::new(0.0, 3.0 * chain as f32, 0.0));
        for i in 0..3 {
            let place = Vec3::new(i as f32 + 0.5, 3.0 * chain as f32, 0.0);
            let body = massive(&mut world, at(place), needle(1.0 / 12.0));
            let frames = [at(last.1), at(Vec3::new(-0.5, 0.0, 0.0))];
            world.create_joint(&JointDef::ball([last.0, body], frames)).expect("room");
            world.set_angular_velocity(body, Vec3::new(0.5, 0.3, 2.0)).expect("dynamic");
            last = (body, Vec3::new(0.5, 0.0, 0.0));
            bodies.push(body);
        }
    }
    run(&mut world, 1);
    let sum = |world: &OwnedWorld| bodies.iter().map(|&body| energy(world, body, GRAVITY)).sum::<f64>();
    let start = sum(&world);
    let (mut most, mut fastest) = (f64::MIN, 0.0_f64);
    for _ in 0..3600 {
        world.step(&mut Serial);
        most = most.max(sum(&world));
        for &body in &bodies {
            fastest = fastest.max(cellstep_tests::oracles::body_spin(&world, body)[0].abs());
        }
    }
    println!("slender chains: energy {start:.2} J, at most {most:.2}, at the end {:.2}", sum(&world));
    assert!(most <= start + 1.0, "energy from {start} to {most} J");
    println!("fastest spin about an axis: {fastest:.1} rad/s");
}

#[test]
fn a_lost_partner_does_not_spread() {
    let (mut world, base) = jointed(6, 6, 4);
    let mut bodies = Vec::new();
    let mut last = base;
    for i in 0..5 {
        let body = massive(&mut world, at(Vec3::new(i as f32 + 1.0, 0.0, 0.0)), ball(1.0, 0.2));
        let frames = [at(Vec3::new(0.5, 0.0, 0.0)), at(Vec3::new(-0.5, 0.0, 0.0))];
        world.create_joint(&JointDef::ball([last, body], frames)).expect("room");
        bodies.push(body);
        last = body;
    }
    for speed in [1.0e6_f32, 3.0e7, 1.0e20, 3.0e38] {
        for _ in 0..30 {
            if world.set_linear_velocity(bodies[2], Vec3::new(speed, -speed, 0.5 * speed)).is_err() {
                continue;
            }
            let _ = world.set_angular_velocity(bodies[2], Vec3::new(speed, 0.0, speed));
            world.step(&mut Serial);
            for &body in &bodies {
                assert!(norm(velocity(&world, body)).is_finite() && norm(center(&world, body)).is_finite());
            }
        }
    }
    run(&mut world, 60);
    let report = world.step(&mut Serial);
    println!("after huge speeds: {report:?}");
    for (i, &body) in bodies.iter().enumerate() {
        let lost = world.is_quarantined(body).expect("it exists");
        println!("body {i}: quarantined {lost}, speed {}", norm(velocity(&world, body)));
        assert!(norm(velocity(&world, body)).is_finite());
    }
    // The snapshot of whatever came of it can be loaded.
    let saved = cellstep_tests::simulator::snapshot(&world);
    assert_eq!(world.load(&saved), Ok(()));
}

#[test]
fn a_motor_against_a_kinematic_body_turns_by_difference() {
    let (mut world, _) = jointed(5, 1, 4);
    weightless(&mut world);
    let axle = kinematic(&mut world, Vec3::ZERO);
    world.set_angular_velocity(axle, Vec3::new(2.0, 0.0, 0.0)).expect("kinematic");
    let wheel = massive(&mut world, Pose::IDENTITY, ball(1.0, 0.5));
    let mut def = JointDef::hinge([axle, wheel], [Pose::IDENTITY; 2]);
    def.axes[TURN_X].drive = Some(Drive::motor(3.0, 100.0));
    world.create_joint(&def).expect("room");
    run(&mut world, 60);
    judge("motor on a turning axle", relative(spin(&world, wheel)[0], 5.0), [1.0e-5, 1.0e-4]);
    // A slider on a platform that moves along it.
    let platform = kinematic(&mut world, Vec3::new(0.0, 5.0, 0.0));
    world.set_linear_velocity(platform, Vec3::new(1.0, 0.0, 0.0)).expect("kinematic");
    let cart = massive(&mut world, at(Vec3::new(0.0, 5.0, 0.0)), ball(1.0, 0.5));
    let room = world.create_joint(&JointDef::slider([platform, cart], [Pose::IDENTITY; 2]));
    assert!(room.is_err(), "one joint is all there is room for");
    let turn = Rotation::from_axis_angle(Vec3::Y, PI);
    assert!((turn.rotate(Vec3::X) + Vec3::X).length() < 1.0e-6);
    assert!(coordinate(&world, world.joints().next().expect("one"), X).abs() < 1.0e-4);
}
