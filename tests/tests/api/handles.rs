//! Handles: stale ones are refused by every call, and are exact again after a restore.

use super::{ball, cuboid, dynamic};
use cellstep::math::{Pose, Rotation, Vec3};
use cellstep::{
    AxisLocks, BodyDef, BodyHandle, BodyKind, Command, Error, Filter, Geometry, HullHandle, MassProperties,
    MeshHandle, Position, ShapeDef, ShapeHandle,
};
use cellstep_tests::simulator;
use cellstep_tests::worlds::{self, OwnedWorld, add, run};

/// Every command of a body.
fn of_body(body: BodyHandle) -> Vec<Command> {
    let (place, v) = (Position::ORIGIN, Vec3::X);
    let mass = MassProperties { mass: 1.0, inertia: Vec3::ONE, ..MassProperties::default() };
    vec![
        Command::RemoveBody(body),
        Command::CreateShape(body, ball(0.5)),
        Command::SetPose(body, place, Rotation::IDENTITY),
        Command::SetLinearVelocity(body, v),
        Command::SetAngularVelocity(body, v),
        Command::SetKinematicTarget(body, place, Rotation::IDENTITY),
        Command::SetKind(body, BodyKind::Dynamic),
        Command::SetMass(body, Some(mass)),
        Command::SetMass(body, None),
        Command::SetDamping(body, 1.0, 1.0),
        Command::SetGravityScale(body, 1.0),
        Command::SetLocks(body, AxisLocks::ALL),
        Command::SetBodyUser(body, 1),
        Command::ApplyForce(body, v),
        Command::ApplyForceAt(body, v, place),
        Command::ApplyTorque(body, v),
        Command::ApplyImpulse(body, v),
        Command::ApplyImpulseAt(body, v, place),
        Command::ApplyAngularImpulse(body, v),
    ]
}

/// Every command of a shape.
fn of_shape(shape: ShapeHandle) -> Vec<Command> {
    vec![
        Command::RemoveShape(shape),
        Command::SetShapeUser(shape, 1),
        Command::SetGeometry(shape, Geometry::Sphere { radius: 1.0 }, Pose::IDENTITY),
        Command::SetDensity(shape, 1.0),
        Command::SetMaterial(shape, 0.5, 0.5),
        Command::SetFilter(shape, Filter::default()),
    ]
}

/// Asserts that all calls refuse the handles and leave the world unchanged.
#[track_caller]
fn refused(world: &mut OwnedWorld, body: BodyHandle, shape: ShapeHandle) {
    let before = world.state().to_vec();
    let (no_body, no_shape) = (Error::Stale { what: "body" }, Error::Stale { what: "shape" });
    for command in of_body(body) {
        assert_eq!(world.apply(&command), Err(no_body), "{command:?}");
    }
    for command in of_shape(shape) {
        assert_eq!(world.apply(&command), Err(no_shape), "{command:?}");
    }
    assert_eq!(world.kind(body), Err(no_body));
    assert_eq!(world.is_quarantined(body), Err(no_body));
    assert_eq!(world.position(body), Err(no_body));
    assert_eq!(world.center(body), Err(no_body));
    assert_eq!(world.rotation(body), Err(no_body));
    assert_eq!(world.linear_velocity(body), Err(no_body));
    assert_eq!(world.angular_velocity(body), Err(no_body));
    assert_eq!(world.mass_properties(body), Err(no_body));
    assert_eq!(world.body_user(body), Err(no_body));
    assert_eq!(world.shapes_of(body).map(Iterator::count), Err(no_body));
    assert_eq!(world.shape(shape), Err(no_shape));
    assert_eq!(world.body_of(shape), Err(no_shape));
    assert_eq!(world.shape_user(shape), Err(no_shape));
    world.manifolds(shape, shape, |_| panic!("a stale shape touches nothing"));
    assert!(!world.contains_body(body) && !world.contains_shape(shape));
    assert!(world.state() == before, "refused calls change nothing");
}

#[test]
fn handles_of_removed_bodies_are_stale() {
    let mut world = worlds::world(2);
    let (body, shape) = add(&mut world, &dynamic(0.0, 0.0, 0.0), &ball(0.5));
    world.remove_body(body).expect("it exists");
    refused(&mut world, body, shape);
    // Others in the same slots do not make them good again.
    let (next, next_shape) = add(&mut world, &dynamic(1.0, 0.0, 0.0), &cuboid(0.1, 0.1, 0.1));
    assert_eq!((next.index, next_shape.index), (body.index, shape.index));
    refused(&mut world, body, shape);
    assert!(world.contains_body(next) && world.contains_shape(next_shape));
}

#[test]
fn handles_of_nothing_are_stale() {
    let mut world = worlds::world(2);
    add(&mut world, &dynamic(0.0, 0.0, 0.0), &ball(0.5));
    refused(&mut world, BodyHandle::default(), ShapeHandle::default());
    for index in [1, 2, u32::MAX] {
        let (body, shape) = (BodyHandle { index, generation: 1 }, ShapeHandle { index, generation: 1 });
        refused(&mut world, body, shape);
    }
}

#[test]
fn assets_that_are_not_registered_are_stale() {
    let mut world = worlds::world(2);
    let body = world.create_body(&BodyDef::new(BodyKind::Static, Vec3::ZERO)).expect("room");
    let hull = ShapeDef::new(Geometry::Hull(HullHandle(0)));
    assert_eq!(world.create_shape(body, &hull), Err(Error::Stale { what: "hull" }));
    let mesh = ShapeDef::new(Geometry::Mesh(MeshHandle(3)));
    assert_eq!(world.create_shape(body, &mesh), Err(Error::Stale { what: "mesh" }));
    assert!(world.hull(HullHandle(0)).is_err() && world.mesh(MeshHandle(0)).is_err());
}

#[test]
fn handles_are_exact_again_after_a_restore() {
    let mut world = worlds::world(3);
    worlds::ground(&mut world, 0.6);
    let (body, shape) = add(&mut world, &dynamic(0.0, 0.0, 0.5), &ball(0.5));
    world.set_body_user(body, 11).expect("it exists");
    run(&mut world, 20);
    let before = simulator::snapshot(&world);
    let place = world.position(body);
    // The slots change hands twice.
    for _ in 0..2 {
        let next = world.bodies().nth(1).expect("the second body");
        world.remove_body(next).expect("it exists");
        add(&mut world, &dynamic(4.0, 0.0, 0.5), &cuboid(0.5, 0.5, 0.5));
        run(&mut world, 5);
    }
    refused(&mut world, body, shape);
    let late = world.bodies().nth(1).expect("the second body");
    let late_shape = world.shapes_of(late).expect("it exists").next().expect("a shape");
    assert_eq!(late.index, body.index);
    world.restore(&before).expect("its own snapshot");
    assert_eq!((world.position(body), world.body_user(body)), (place, Ok(11)));
    assert_eq!(world.shapes_of(body).expect("it exists").collect::<Vec<_>>(), [shape]);
    refused(&mut world, late, late_shape);
    // The same history gives the same handles.
    world.remove_body(body).expect("it exists");
    world.create_body(&dynamic(0.0, 0.0, 0.0)).expect("room");
    let again = world.bodies().nth(1).expect("the second body");
    assert_eq!((again.index, again.generation), (body.index, body.generation + 1));
}
