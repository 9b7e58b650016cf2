//! Bodies that are solved side by side know nothing of each other: what one is changes no bit of the others.

use cellstep::config::TURN_MAX;
use cellstep::math::{Rotation, Vec3};
use cellstep::{AxisLocks, BodyDef, BodyHandle, BodyKind, Capacities, Geometry, Serial, ShapeDef};
use cellstep_tests::worlds::{OwnedWorld, world_with};

/// What the bodies are after some steps, bit by bit.
fn bits(world: &OwnedWorld, bodies: &[BodyHandle]) -> Vec<u32> {
    let numbers = |&body: &BodyHandle| {
        let (linear, angular) =
            (world.linear_velocity(body).expect("there"), world.angular_velocity(body).expect("there"));
        let (place, turn) = (world.center(body).expect("there").offset, world.rotation(body).expect("there"));
        let parts = [turn.x, turn.y, turn.z, turn.w];
        [linear, angular, place].into_iter().flat_map(|v| v.to_array()).chain(parts)
    };
    bodies.iter().flat_map(numbers).map(f32::to_bits).collect()
}

/// Steps a world until its end; the bits of the bodies after each step.
fn run(mut world: OwnedWorld, bodies: &[BodyHandle], steps: u32) -> Vec<Vec<u32>> {
    let after = |_| {
        world.step(&mut Serial);
        bits(&world, bodies)
    };
    (0..steps).map(after).collect()
}

fn half_space(world: &mut OwnedWorld) {
    let ground = world.create_body(&BodyDef::new(BodyKind::Static, Vec3::ZERO)).expect("room");
    world.create_shape(ground, &ShapeDef::new(Geometry::HalfSpace)).expect("room");
}

fn add_box(world: &mut OwnedWorld, def: &BodyDef) -> BodyHandle {
    let body = world.create_body(def).expect("room");
    let half_extents = Vec3::new(0.5, 0.4, 0.3);
    world.create_shape(body, &ShapeDef::new(Geometry::Box { half_extents })).expect("room");
    body
}

#[test]
fn a_body_that_is_locked_changes_no_bit_of_the_boxes_beside_it() {
    let sliding = |locks: AxisLocks| {
        let mut world = world_with(Capacities::for_bodies(8));
        half_space(&mut world);
        let at = |x: f32| BodyDef {
            rotation: Rotation::from_axis_angle(Vec3::new(0.6, 0.8, 0.0), 0.1 * x),
            linear_velocity: Vec3::new(1.0, 2.0 - 0.1 * x, -1.0),
            angular_velocity: Vec3::new(0.3 * x, -1.0, 0.5),
            ..BodyDef::new(BodyKind::Dynamic, Vec3::new(3.0 * x, 0.0, 0.8))
        };
        let bodies: Vec<BodyHandle> = (1..5).map(|x| add_box(&mut world, &at(x as f32))).collect();
        add_box(&mut world, &BodyDef { locks, ..at(7.0) });
        run(world, &bodies, 200)
    };
    let free = sliding(AxisLocks::NONE);
    for locks in [AxisLocks::MOVE_Y, AxisLocks::MOVE_X] {
        let beside = sliding(locks);
        let off = free.iter().zip(&beside).position(|(a, b)| a != b);
        assert_eq!(off, None, "first step with other bits");
    }
}

#[test]
fn a_body_that_is_too_fast_changes_no_bit_of_those_beside_it() {
    let turning = |spin: f32| {
        let mut world = world_with(Capacities::for_bodies(8));
        let at = |x: f32| BodyDef {
            rotation: Rotation::new(0.0, 5.0e-17 * x, 0.0, 1.0),
            angular_velocity: Vec3::new(1.0e-15, 2.0e-15, 0.0),
            gravity_scale: 0.0,
            ..BodyDef::new(BodyKind::Dynamic, Vec3::new(10.0 * x, 0.0, 0.0))
        };
        let ball = |world: &mut OwnedWorld, def: &BodyDef| {
            let body = world.create_body(def).expect("room");
            world.create_shape(body, &ShapeDef::new(Geometry::Sphere { radius: 0.5 })).expect("room");
            body
        };
        let bodies: Vec<BodyHandle> = (1..4).map(|x| ball(&mut world, &at(x as f32))).collect();
        ball(&mut world, &BodyDef { angular_velocity: Vec3::Y * spin, ..at(5.0) });
        run(world, &bodies, 20)
    };
    // In radians per substep of 1/240 s.
    assert_eq!(turning(1.0), turning(100.0 * TURN_MAX), "below the cap");
    assert_eq!(turning(1.0), turning(1000.0 * TURN_MAX), "beyond the cap");
}
