//! Forces, torques, impulses, damping and gravity scale.

use super::{
    GRAVITY, SUBSTEP, ball, close, cuboid, dynamic, fallen, near, place, spin, velocity, weightless,
};
use cellstep::math::{Rotation, Vec3};
use cellstep::{BodyDef, BodyHandle, Position};
use cellstep_tests::worlds::{self, OwnedWorld, add, run};

/// Inverse inertia in the world times a vector, from the published mass properties.
fn turned_by(world: &OwnedWorld, body: BodyHandle, angular: Vec3) -> Vec3 {
    let mass = world.mass_properties(body).expect("the body exists");
    let frame = world.rotation(body).expect("the body exists").after(mass.axes);
    frame.rotate(frame.unrotate(angular) / mass.inertia)
}

/// A turned brick whose moments differ, without gravity.
fn brick() -> (OwnedWorld, BodyHandle) {
    let mut world = weightless(1);
    let def = BodyDef {
        rotation: Rotation::from_rotation_vector(Vec3::new(0.4, -1.1, 0.7)),
        ..dynamic(1.0, 2.0, 3.0)
    };
    let (body, _) = add(&mut world, &def, &cuboid(0.1, 0.2, 0.4));
    (world, body)
}

#[test]
fn gravity_scales() {
    let mut world = worlds::world(4);
    let scales = [1.0, 0.5, 0.0, -1.0];
    let bodies = scales.map(|gravity_scale| {
        let def = BodyDef { gravity_scale, ..dynamic(10.0 * gravity_scale, 0.0, 0.0) };
        add(&mut world, &def, &ball(0.5)).0
    });
    run(&mut world, 60);
    for (scale, body) in scales.into_iter().zip(bodies) {
        let (way, speed) = fallen(-GRAVITY * f64::from(scale), 60);
        close(place(&world, body)[2], way, 2.0e-5);
        close(velocity(&world, body).z.into(), speed, 2.0e-5);
    }
    world.set_gravity_scale(bodies[0], 0.0).expect("in range");
    let before = velocity(&world, bodies[0]);
    run(&mut world, 10);
    assert_eq!(velocity(&world, bodies[0]), before, "nothing pulls any more");
}

#[test]
fn damping_is_that_of_the_scheme() {
    let mut world = weightless(1);
    let def = BodyDef {
        linear_velocity: Vec3::new(10.0, 0.0, 0.0),
        angular_velocity: Vec3::new(0.0, 0.0, 4.0),
        linear_damping: 0.5,
        angular_damping: 2.0,
        ..dynamic(0.0, 0.0, 0.0)
    };
    let (body, _) = add(&mut world, &def, &ball(0.5));
    run(&mut world, 300);
    let left = |rate: f64| (1.0 + rate * SUBSTEP).powi(-1200);
    close(velocity(&world, body).x.into(), 10.0 * left(0.5), 1.0e-4 * 10.0 * left(0.5));
    close(spin(&world, body).z.into(), 4.0 * left(2.0), 1.0e-4 * 4.0 * left(2.0));
    // The way is the geometric sum of v0 q^i h with q = 1 / (1 + c h): v0 / c (1 - q^n).
    let way = 10.0 / 0.5 * (1.0 - left(0.5));
    close(place(&world, body)[0], way, 1.0e-4 * way);
    world.set_damping(body, 0.0, 0.0).expect("in range");
    let before = (velocity(&world, body), spin(&world, body));
    run(&mut world, 10);
    assert_eq!((velocity(&world, body), spin(&world, body)), before);
}

#[test]
fn a_force_lasts_one_step() {
    let (mut world, body) = brick();
    let mass = world.mass_properties(body).expect("the body exists").mass;
    world.apply_force(body, Vec3::new(600.0, 0.0, -60.0)).expect("in range");
    world.apply_force(body, Vec3::new(600.0, 0.0, 0.0)).expect("forces add up");
    run(&mut world, 1);
    near(velocity(&world, body), Vec3::new(20.0, 0.0, -1.0) / mass, 1.0e-5 / mass);
    near(spin(&world, body), Vec3::ZERO, 0.0);
    let before = velocity(&world, body);
    run(&mut world, 5);
    assert_eq!(velocity(&world, body), before, "the force is gone");
}

#[test]
fn a_force_at_a_place_turns_too() {
    let (mut world, body) = brick();
    let mass = world.mass_properties(body).expect("the body exists").mass;
    let (arm, force) = (Vec3::new(0.1, -0.2, 0.3), Vec3::new(30.0, 12.0, -6.0));
    let place = world.center(body).expect("the body exists").plus(arm);
    let expected = turned_by(&world, body, arm.cross(force) / 60.0);
    world.apply_force_at(body, force, place).expect("in range");
    run(&mut world, 1);
    near(velocity(&world, body), force / (60.0 * mass), 1.0e-6);
    // Within the step the brick turns under the torque: second order in 0.03 rad.
    near(spin(&world, body), expected, 1.0e-2 * expected.length());
    let same = brick().0;
    assert_eq!(same.angular_velocity(body), Ok(Vec3::ZERO));
}

#[test]
fn a_torque_turns_and_does_not_move() {
    let (mut world, body) = brick();
    let torque = Vec3::new(3.0, -5.0, 8.0);
    let expected = turned_by(&world, body, torque / 60.0);
    world.apply_torque(body, torque).expect("in range");
    run(&mut world, 1);
    near(velocity(&world, body), Vec3::ZERO, 0.0);
    near(spin(&world, body), expected, 1.0e-2 * expected.length());
    // What a torque gives exactly is angular momentum.
    let mass = world.mass_properties(body).expect("the body exists");
    let frame = world.rotation(body).expect("the body exists").after(mass.axes);
    let momentum = frame.rotate(frame.unrotate(spin(&world, body)) * mass.inertia);
    near(momentum, torque / 60.0, 1.0e-5 * torque.length());
}

#[test]
fn impulses_act_at_once() {
    let (mut world, body) = brick();
    let mass = world.mass_properties(body).expect("the body exists").mass;
    let (arm, impulse) = (Vec3::new(-0.3, 0.1, 0.2), Vec3::new(2.0, 40.0, -7.0));
    let place = world.center(body).expect("the body exists").plus(arm);
    let turn = turned_by(&world, body, arm.cross(impulse));
    world.apply_impulse_at(body, impulse, place).expect("in range");
    near(velocity(&world, body), impulse / mass, 1.0e-6);
    near(spin(&world, body), turn, 1.0e-5 * turn.length());
    world.apply_impulse(body, -impulse).expect("in range");
    near(velocity(&world, body), Vec3::ZERO, 1.0e-6);
    near(spin(&world, body), turn, 1.0e-5 * turn.length());
    world.apply_angular_impulse(body, impulse.cross(arm)).expect("in range");
    near(spin(&world, body), Vec3::ZERO, 1.0e-5 * turn.length());
}

#[test]
fn an_impulse_through_the_center_of_a_compound_does_not_turn_it() {
    let mut world = weightless(1);
    let (body, _) = add(&mut world, &dynamic(0.0, 0.0, 0.0), &ball(0.3));
    let off = cellstep::math::Pose::new(Vec3::new(0.0, 1.0, 0.0), Rotation::IDENTITY);
    let capacity = world.create_shape(body, &cellstep::ShapeDef { pose: off, ..ball(0.2) });
    assert_eq!(capacity, Err(cellstep::Error::Full { name: "shapes" }), "there is room for one shape only");
    let mut world =
        worlds::world_with(cellstep::Capacities { shapes: 2, ..cellstep::Capacities::for_bodies(1) });
    let (body, _) = add(&mut world, &dynamic(0.0, 0.0, 0.0), &ball(0.3));
    world.create_shape(body, &cellstep::ShapeDef { pose: off, ..ball(0.2) }).expect("room for two");
    let center = world.center(body).expect("the body exists");
    world.apply_impulse_at(body, Vec3::new(50.0, 0.0, 20.0), center).expect("in range");
    near(spin(&world, body), Vec3::ZERO, 0.0);
    world.apply_impulse_at(body, Vec3::new(0.0, 0.0, 20.0), Position::ORIGIN).expect("in range");
    assert!(spin(&world, body).x < -0.01, "beside the center it does: {}", spin(&world, body));
}
