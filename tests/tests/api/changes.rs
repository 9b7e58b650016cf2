//! Changes after creation, with contacts that follow.

use super::{GRAVITY, SUBSTEP, ball, close, cuboid, dynamic, fallen, near, place, slope, velocity};
use cellstep::math::{Pose, Rotation, Vec3};
use cellstep::{
    BodyDef, BodyHandle, BodyKind, Error, Filter, Geometry, MassProperties, Position, ShapeDef, ShapeHandle,
};
use cellstep_tests::worlds::{self, OwnedWorld, add, run};

/// A cube of one metre at rest on the ground.
fn resting() -> (OwnedWorld, BodyHandle, ShapeHandle) {
    let mut world = worlds::world(3);
    worlds::ground(&mut world, 0.6);
    let (body, shape) = add(&mut world, &dynamic(0.0, 0.0, 0.5), &cuboid(0.5, 0.5, 0.5));
    run(&mut world, 60);
    close(place(&world, body)[2], 0.5, 1.0e-3);
    assert_eq!(world.contacts().count(), 1);
    (world, body, shape)
}

/// Asserts that a body falls freely from now on.
#[track_caller]
fn falls(world: &mut OwnedWorld, body: BodyHandle) {
    let (before, speed) = (place(world, body)[2], f64::from(velocity(world, body).z));
    run(world, 20);
    close(place(world, body)[2], before + speed / 3.0 + fallen(-GRAVITY, 20).0, 2.0e-4);
}

/// Sum of the normal forces of all contacts, N.
fn load(world: &OwnedWorld) -> f64 {
    world.contacts().map(|contact| f64::from(contact.normal_impulse())).sum::<f64>() / SUBSTEP
}

#[test]
fn a_box_whose_filter_changes_falls_through() {
    let (mut world, body, shape) = resting();
    world.set_filter(shape, Filter { mask: 0, ..Filter::default() }).expect("it exists");
    falls(&mut world, body);
    assert_eq!(world.contacts().count(), 0);
    // Groups: the same positive one meets in spite of the masks, the same negative one never.
    for (group, count) in [(3, 1), (-3, 0), (0, 1)] {
        let (mut world, _, shape) = resting();
        let mask = if group > 0 { 0 } else { u32::MAX };
        let ground = world.bodies().next().expect("the ground");
        let floor = world.shapes_of(ground).expect("it exists").next().expect("a half-space");
        for shape in [shape, floor] {
            world.set_filter(shape, Filter { category: 1, mask, group }).expect("it exists");
        }
        run(&mut world, 5);
        assert_eq!(world.contacts().count(), count, "group {group}");
    }
}

#[test]
fn a_box_that_loses_its_friction_slides() {
    let mut world = slope(2, (20.0, 0.8));
    let (body, shape) =
        add(&mut world, &dynamic(0.0, 0.0, 0.5), &ShapeDef { friction: 0.8, ..cuboid(0.5, 0.5, 0.5) });
    run(&mut world, 60);
    close(place(&world, body)[0], 0.0, 2.0e-3);
    world.set_material(shape, 0.0, 0.0).expect("in range");
    let before = place(&world, body)[0];
    run(&mut world, 60);
    let way = fallen(GRAVITY * 20.0_f64.to_radians().sin(), 60).0;
    close(place(&world, body)[0] - before, way, 1.0e-3 * way);
    // And sticks again: v^2 / (2 (mu g cos - g sin)).
    world.set_material(shape, 0.8, 0.0).expect("in range");
    let (before, speed) = (place(&world, body)[0], f64::from(velocity(&world, body).x));
    run(&mut world, 180);
    let slowing = GRAVITY * (0.8 * 20.0_f64.to_radians().cos() - 20.0_f64.to_radians().sin());
    let way = speed * speed / (2.0 * slowing);
    close(place(&world, body)[0] - before, way, 1.0e-2 * way);
    near(velocity(&world, body), Vec3::ZERO, 1.0e-3);
}

#[test]
fn restitution_changes_between_bounces() {
    let mut world = worlds::world(2);
    worlds::ground(&mut world, 0.0);
    let (body, shape) = add(&mut world, &dynamic(0.0, 0.0, 1.5), &ShapeDef { restitution: 1.0, ..ball(0.5) });
    let apex = |world: &mut OwnedWorld| {
        let heights = (0..60).map(|_| {
            run(world, 1);
            place(world, body)[2]
        });
        // The first half of the second holds the way down.
        heights.skip(30).fold(0.0, f64::max)
    };
    close(apex(&mut world), 1.5, 0.02);
    world.set_material(shape, 0.0, 0.0).expect("in range");
    assert!(apex(&mut world) < 0.51, "it no longer bounces");
}

#[test]
fn a_ball_that_grows_is_pushed_out() {
    let mut world = worlds::world(2);
    worlds::ground(&mut world, 0.6);
    let (body, shape) = add(&mut world, &dynamic(0.0, 0.0, 0.5), &ball(0.5));
    run(&mut world, 30);
    world.set_geometry(shape, &Geometry::Sphere { radius: 0.6 }, &Pose::IDENTITY).expect("in range");
    assert_eq!(world.contacts().count(), 0, "contacts of a changed shape are gone until the next step");
    let mut fastest = 0.0_f32;
    for _ in 0..120 {
        run(&mut world, 1);
        fastest = cellstep::math::max(fastest, velocity(&world, body).z);
    }
    close(place(&world, body)[2], 0.6, 2.0e-3);
    assert!(fastest <= 3.0, "pushed out at {fastest} m/s");
    let mass = world.mass_properties(body).expect("the body exists").mass;
    close(load(&world), f64::from(mass) * GRAVITY, 0.01 * f64::from(mass) * GRAVITY);
    // Another kind of geometry, with a local pose.
    let pose = Pose::new(Vec3::new(0.0, 0.0, -0.1), Rotation::IDENTITY);
    world.set_geometry(shape, &Geometry::Box { half_extents: Vec3::splat(0.3) }, &pose).expect("in range");
    run(&mut world, 60);
    close(place(&world, body)[2], 0.4, 2.0e-3);
}

#[test]
fn kinds_change() {
    let (mut world, body, _) = resting();
    let def = dynamic(0.0, 0.0, 1.5);
    let (upper, _) = add(&mut world, &def, &cuboid(0.5, 0.5, 0.5));
    run(&mut world, 60);
    world.set_kind(upper, BodyKind::Static).expect("boxes may be of any kind");
    world.remove_body(body).expect("it exists");
    let hanging = place(&world, upper);
    run(&mut world, 30);
    assert_eq!(place(&world, upper), hanging, "a static body hangs in the air");
    world.set_kind(upper, BodyKind::Dynamic).expect("boxes may be of any kind");
    falls(&mut world, upper);
    world.set_kind(upper, BodyKind::Kinematic).expect("boxes may be of any kind");
    world.set_linear_velocity(upper, Vec3::X).expect("it moves");
    let before = place(&world, upper);
    run(&mut world, 60);
    close(place(&world, upper)[0], before[0] + 1.0, 1.0e-5);
    assert_eq!(place(&world, upper)[2], before[2]);
    let ground = world.bodies().next().expect("the ground");
    assert!(matches!(world.set_kind(ground, BodyKind::Dynamic), Err(Error::WrongKind { .. })));
}

#[test]
fn what_a_removed_support_carried_falls() {
    let (mut world, body, _) = resting();
    let ground = world.bodies().next().expect("the ground");
    world.remove_body(ground).expect("it exists");
    assert_eq!(world.contacts().count(), 0);
    falls(&mut world, body);
    let (mut world, body, shape) = resting();
    world.remove_shape(shape).expect("it exists");
    falls(&mut world, body);
}

#[test]
fn forces_follow_a_changed_mass() {
    let (mut world, body, shape) = resting();
    close(load(&world), 1000.0 * GRAVITY, 0.01 * 1000.0 * GRAVITY);
    let mass = MassProperties { mass: 30.0, inertia: Vec3::splat(5.0), ..MassProperties::default() };
    world.set_mass(body, Some(&mass)).expect("in range");
    run(&mut world, 60);
    close(load(&world), 30.0 * GRAVITY, 0.01 * 30.0 * GRAVITY);
    world.set_mass(body, None).expect("in range");
    world.set_density(shape, 5000.0).expect("in range");
    run(&mut world, 60);
    close(load(&world), 5000.0 * GRAVITY, 0.01 * 5000.0 * GRAVITY);
    close(place(&world, body)[2], 0.5, 2.0e-3);
}

#[test]
fn a_center_beyond_the_edge_tips_the_box() {
    let mut world = worlds::world(2);
    let table = BodyDef::new(BodyKind::Static, Vec3::ZERO);
    add(&mut world, &table, &cuboid(0.5, 0.5, 0.5));
    let (body, _) = add(&mut world, &dynamic(0.3, 0.0, 0.6), &cuboid(0.5, 0.1, 0.1));
    run(&mut world, 60);
    close(place(&world, body)[2], 0.6, 2.0e-3);
    let mut mass = world.mass_properties(body).expect("the body exists");
    mass.center = Vec3::new(0.4, 0.0, 0.0);
    world.set_mass(body, Some(&mass)).expect("in range");
    run(&mut world, 60);
    assert!(world.center(body).expect("the body exists").to_f64()[2] < 0.0, "it fell off the table");
}

#[test]
fn a_teleported_body_keeps_its_velocity_and_loses_its_contacts() {
    let (mut world, body, _) = resting();
    world.set_linear_velocity(body, Vec3::new(1.0, 0.0, 0.0)).expect("it moves");
    let there = Position::at(Vec3::new(500.0, -70.0, 10.0));
    let turned = Rotation::from_rotation_vector(Vec3::new(0.0, 0.5, 0.0));
    world.set_pose(body, there, turned).expect("in range");
    assert_eq!(world.contacts().count(), 0);
    near(world.position(body).expect("the body exists").minus(there), Vec3::ZERO, 0.0);
    falls(&mut world, body);
    close(place(&world, body)[0], 500.0 + 1.0 / 3.0, 1.0e-3);
    near(
        world.rotation(body).expect("the body exists").after(turned.inverse()).imaginary(),
        Vec3::ZERO,
        1.0e-6,
    );
    // On the ground again at once, upright.
    world.set_linear_velocity(body, Vec3::ZERO).expect("it moves");
    world.set_pose(body, Position::at(Vec3::new(7.0, 0.0, 0.5)), Rotation::IDENTITY).expect("in range");
    run(&mut world, 10);
    assert_eq!(world.contacts().count(), 1);
    close(place(&world, body)[2], 0.5, 1.0e-3);
}

#[test]
fn the_ground_may_be_teleported_too() {
    let (mut world, body, _) = resting();
    let ground = world.bodies().next().expect("the ground");
    world.set_pose(ground, Position::at(Vec3::Z * -3.0), Rotation::IDENTITY).expect("in range");
    falls(&mut world, body);
    run(&mut world, 120);
    close(place(&world, body)[2], -2.5, 2.0e-3);
}
