//! Locked axes: free motion, velocities, impulses, and contacts.

use super::{ball, close, cuboid, dynamic, fallen, near, place, slope, spin, velocity, weightless};
use cellstep::math::{Rotation, Vec3};
use cellstep::{AxisLocks, BodyDef, BodyKind, ShapeDef};
use cellstep_tests::worlds::{self, add, run};

#[test]
fn locked_axes_take_no_velocity() {
    let mut world = weightless(1);
    let def = BodyDef {
        linear_velocity: Vec3::new(1.0, 2.0, 3.0),
        angular_velocity: Vec3::new(0.5, 0.25, 0.125),
        locks: AxisLocks::MOVE_X.and(AxisLocks::TURN_X).and(AxisLocks::TURN_Y),
        rotation: Rotation::from_rotation_vector(Vec3::new(0.3, 0.2, 0.1)),
        ..dynamic(0.0, 0.0, 0.0)
    };
    let (body, _) = add(&mut world, &def, &cuboid(0.1, 0.2, 0.3));
    world.apply_force(body, Vec3::new(1.0e3, 0.0, 0.0)).expect("in range");
    world.apply_torque(body, Vec3::new(1.0e3, 1.0e3, 0.0)).expect("in range");
    world.apply_impulse(body, Vec3::new(1.0e3, 0.0, 0.0)).expect("in range");
    world.apply_angular_impulse(body, Vec3::new(10.0, 10.0, 0.0)).expect("in range");
    run(&mut world, 60);
    near(velocity(&world, body), Vec3::new(0.0, 2.0, 3.0), 1.0e-6);
    near(spin(&world, body), Vec3::new(0.0, 0.0, 0.125), 1.0e-6);
    let [x, y, z] = place(&world, body);
    assert_eq!(x, 0.0);
    close(y, 2.0, 1.0e-5);
    close(z, 3.0, 1.0e-5);
    // It turned about z alone.
    let turn = world.rotation(body).expect("the body exists").after(def.rotation.inverse());
    near(turn.imaginary(), Vec3::new(0.0, 0.0, cellstep::math::sin(0.0625)), 1.0e-5);
}

#[test]
fn one_free_axis_turns_with_the_moment_about_it() {
    // About a world axis the moment of a turned brick is n.In, not a principal one.
    let mut world = weightless(1);
    let rotation = Rotation::from_rotation_vector(Vec3::new(0.9, 0.4, 0.0));
    let locks = AxisLocks::TURN_X.and(AxisLocks::TURN_Y);
    let (body, _) =
        add(&mut world, &BodyDef { rotation, locks, ..dynamic(0.0, 0.0, 0.0) }, &cuboid(0.1, 0.2, 0.4));
    let mass = world.mass_properties(body).expect("the body exists");
    let axis = rotation.after(mass.axes).unrotate(Vec3::Z);
    let moment = axis.dot(axis * mass.inertia);
    world.apply_angular_impulse(body, Vec3::new(5.0, -3.0, 2.0)).expect("in range");
    near(spin(&world, body), Vec3::new(0.0, 0.0, 2.0 / moment), 1.0e-5 * 2.0 / moment);
    run(&mut world, 60);
    near(spin(&world, body), Vec3::new(0.0, 0.0, 2.0 / moment), 1.0e-4 * 2.0 / moment);
}

#[test]
fn all_locked_stays_under_load() {
    let mut world = worlds::world(3);
    let locks = AxisLocks::ALL;
    let (table, _) = add(&mut world, &BodyDef { locks, ..dynamic(0.0, 0.0, 1.0) }, &cuboid(1.0, 1.0, 0.1));
    let (load, _) = add(&mut world, &dynamic(0.7, 0.0, 1.6), &cuboid(0.5, 0.5, 0.5));
    run(&mut world, 120);
    assert_eq!(place(&world, table), [0.0, 0.0, 1.0]);
    assert_eq!(world.rotation(table), Ok(Rotation::IDENTITY));
    near(velocity(&world, load), Vec3::ZERO, 1.0e-3);
    close(place(&world, load)[2], 1.6, 5.0e-3);
}

#[test]
fn a_body_that_cannot_turn_does_not_tip() {
    for (locks, stays) in [(AxisLocks::TURN, true), (AxisLocks::NONE, false)] {
        let mut world = worlds::world(2);
        add(&mut world, &BodyDef::new(BodyKind::Static, Vec3::new(0.0, 0.0, 0.5)), &cuboid(0.5, 0.5, 0.5));
        // Its center stands 0.2 m beyond the edge.
        let def = BodyDef { locks, ..dynamic(0.7, 0.0, 1.1) };
        let (body, _) = add(&mut world, &def, &cuboid(0.5, 0.1, 0.1));
        run(&mut world, 60);
        let rotation = world.rotation(body).expect("the body exists");
        assert_eq!(rotation == Rotation::IDENTITY, stays, "{locks:?}");
        if stays {
            let [x, y, z] = place(&world, body);
            near(Vec3::new(x as f32, y as f32, z as f32), Vec3::new(0.7, 0.0, 1.1), 2.0e-3);
        } else {
            assert!(place(&world, body)[2] < 0.9, "it tips over the edge");
        }
    }
}

#[test]
fn a_body_on_a_slope_keeps_to_its_rail() {
    // Gravity pulls along x and into the ground; only y is free, and a force pushes along it.
    let mut world = slope(2, (30.0, 0.0));
    let def = BodyDef { locks: AxisLocks::MOVE_X, ..dynamic(0.0, 0.0, 0.25) };
    let (body, _) = add(&mut world, &def, &ShapeDef { friction: 0.0, ..cuboid(0.25, 0.25, 0.25) });
    let mass = world.mass_properties(body).expect("the body exists").mass;
    for _ in 0..60 {
        world.apply_force(body, Vec3::new(0.0, 2.0 * mass, 0.0)).expect("in range");
        run(&mut world, 1);
    }
    let [x, y, z] = place(&world, body);
    assert_eq!(x, 0.0);
    close(y, fallen(2.0, 60).0, 1.0e-3);
    close(z, 0.25, 2.0e-3);
}

#[test]
fn a_locked_body_is_a_wall() {
    let mut world = weightless(2);
    let elastic = |shape: ShapeDef| ShapeDef { restitution: 1.0, friction: 0.0, ..shape };
    let locks = AxisLocks::MOVE_X.and(AxisLocks::TURN);
    let (wall, _) =
        add(&mut world, &BodyDef { locks, ..dynamic(0.0, 0.0, 0.0) }, &elastic(cuboid(0.1, 1.0, 1.0)));
    let def = BodyDef { linear_velocity: Vec3::new(-4.0, 0.0, 0.0), ..dynamic(1.0, -0.2, 0.3) };
    let (stone, _) = add(&mut world, &def, &elastic(ball(0.2)));
    run(&mut world, 60);
    near(velocity(&world, stone), Vec3::new(4.0, 0.0, 0.0), 4.0e-4);
    assert_eq!(place(&world, wall)[0], 0.0);
    near(velocity(&world, wall), Vec3::ZERO, 1.0e-5);
    // Freed, it takes momentum.
    world.set_locks(wall, AxisLocks::NONE).expect("in range");
    world.set_linear_velocity(stone, Vec3::new(-8.0, 0.0, 0.0)).expect("in range");
    run(&mut world, 60);
    assert!(velocity(&world, wall).x < -0.01, "{}", velocity(&world, wall));
}

/// Whichever of the two has the lower slot.
#[test]
fn a_smooth_ball_takes_no_spin_from_a_smooth_wall() {
    for ball_first in [true, false] {
        let mut world = weightless(2);
        let smooth = |shape: ShapeDef| ShapeDef { restitution: 1.0, friction: 0.0, ..shape };
        let slab = BodyDef { locks: AxisLocks::ALL, ..dynamic(0.0, 0.0, 0.0) };
        let thrown = BodyDef { linear_velocity: Vec3::new(-4.0, 1.0, 0.0), ..dynamic(1.0, -0.2, 0.3) };
        let stone = if ball_first {
            let (stone, _) = add(&mut world, &thrown, &smooth(ball(0.2)));
            add(&mut world, &slab, &smooth(cuboid(0.1, 1.0, 1.0)));
            stone
        } else {
            add(&mut world, &slab, &smooth(cuboid(0.1, 1.0, 1.0)));
            add(&mut world, &thrown, &smooth(ball(0.2))).0
        };
        run(&mut world, 30);
        println!("ball first: {ball_first}, {} {}", velocity(&world, stone), spin(&world, stone));
        near(velocity(&world, stone), Vec3::new(4.0, 1.0, 0.0), 1.0e-3);
        near(spin(&world, stone), Vec3::ZERO, 1.0e-3);
    }
}
