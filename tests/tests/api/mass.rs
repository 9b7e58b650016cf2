//! Mass, center and inertia of bodies of several shapes, from densities and given.

use super::{ball, cuboid, dynamic, near, place, spin, velocity, weightless};
use cellstep::math::{PI, Pose, Rotation, Vec3};
use cellstep::{BodyDef, Capacities, Geometry, MassProperties, ShapeDef};
use cellstep_tests::worlds::{self, OwnedWorld, run};

/// Room for one body of three shapes.
fn compound_world() -> OwnedWorld {
    worlds::world_with(Capacities { shapes: 3, ..Capacities::for_bodies(1) })
}

fn at(x: f32, y: f32, z: f32) -> Pose {
    Pose::new(Vec3::new(x, y, z), Rotation::IDENTITY)
}

#[test]
fn a_compound_by_hand() {
    let mut world = compound_world();
    let body = world.create_body(&dynamic(5.0, 0.0, 0.0)).expect("room");
    // A ball of 0.5 m at x = -1, and a beam of 1 x 0.5 x 0.5 m, turned so that its length runs along y, at x = 1.5.
    let turned = Pose::new(Vec3::new(1.5, 0.0, 0.0), Rotation::from_axis_angle(Vec3::Z, 0.5 * PI));
    world.create_shape(body, &ShapeDef { pose: at(-1.0, 0.0, 0.0), ..ball(0.5) }).expect("room");
    world
        .create_shape(body, &ShapeDef { pose: turned, density: 2000.0, ..cuboid(0.5, 0.25, 0.25) })
        .expect("room");
    let (m1, m2) = (1000.0 * 4.0 / 3.0 * PI * 0.125, 2000.0 * 0.25);
    let center = (1.5 * m2 - m1) / (m1 + m2);
    let (d1, d2) = (center + 1.0, 1.5 - center);
    let of_ball = 0.4 * m1 * 0.25;
    let across = m1 * d1 * d1 + m2 * d2 * d2;
    // m / 12 (b^2 + c^2), the beam's length of 1 m along y.
    let expected = Vec3::new(
        of_ball + m2 / 12.0 * (1.0 + 0.25),
        of_ball + m2 / 12.0 * (0.25 + 0.25) + across,
        of_ball + m2 / 12.0 * (1.0 + 0.25) + across,
    );
    let mass = world.mass_properties(body).expect("the body exists");
    assert!((mass.mass - m1 - m2).abs() < 1.0e-6 * mass.mass, "{mass:?}");
    near(mass.center, Vec3::new(center, 0.0, 0.0), 1.0e-6);
    // Principal moments may come in any order; the tensor has one form.
    for axis in [Vec3::X, Vec3::Y, Vec3::Z] {
        let turned = mass.axes.rotate(mass.axes.unrotate(axis) * mass.inertia);
        near(turned, axis * expected, 2.0e-6 * expected.z);
    }
    // The origin stays where it was, to a rounding.
    let origin = place(&world, body);
    assert!((origin[0] - 5.0).abs() < 1.0e-6 && origin[1..] == [0.0, 0.0], "{origin:?}");
    let found = world.center(body).expect("the body exists").to_f64();
    assert!((found[0] - 5.0 - f64::from(center)).abs() < 1.0e-6);
}

#[test]
fn mass_follows_the_shapes_unless_given() {
    let mut world = compound_world();
    let body = world.create_body(&dynamic(0.0, 0.0, 0.0)).expect("room");
    assert_eq!(
        world.mass_properties(body).expect("the body exists").mass,
        1.0,
        "a body without shapes is 1 kg"
    );
    let one = world.create_shape(body, &cuboid(0.5, 0.5, 0.5)).expect("room");
    let side = ShapeDef { pose: at(2.0, 0.0, 0.0), ..cuboid(0.5, 0.5, 0.5) };
    let two = world.create_shape(body, &side).expect("room");
    let mass = |world: &OwnedWorld| world.mass_properties(body).expect("the body exists");
    assert_eq!((mass(&world).mass, mass(&world).center), (2000.0, Vec3::X));
    world.set_density(two, 3000.0).expect("in range");
    assert_eq!((mass(&world).mass, mass(&world).center), (4000.0, Vec3::new(1.5, 0.0, 0.0)));
    world.set_geometry(one, &Geometry::Sphere { radius: 1.0 }, &at(-2.0, 0.0, 0.0)).expect("in range");
    let m1 = 1000.0 * 4.0 / 3.0 * PI;
    near(mass(&world).center, Vec3::new((6000.0 - 2.0 * m1) / (3000.0 + m1), 0.0, 0.0), 1.0e-6);
    let given = MassProperties { mass: 7.0, inertia: Vec3::new(1.0, 2.0, 2.5), ..MassProperties::default() };
    world.set_mass(body, Some(&given)).expect("in range");
    world.remove_shape(one).expect("it exists");
    world.set_density(two, 10.0).expect("in range");
    assert_eq!(mass(&world), given, "given mass is kept");
    world.set_mass(body, None).expect("in range");
    assert_eq!((mass(&world).mass, mass(&world).center), (10.0, Vec3::new(2.0, 0.0, 0.0)));
    world.set_density(two, 0.0).expect("in range");
    assert_eq!(mass(&world).mass, 1.0, "a body without mass is 1 kg");
}

#[test]
fn a_new_center_has_the_velocity_of_that_point() {
    let mut world = weightless(1);
    let def = BodyDef {
        linear_velocity: Vec3::new(1.0, 0.0, 0.0),
        angular_velocity: Vec3::new(0.0, 0.0, 2.0),
        rotation: Rotation::from_axis_angle(Vec3::Z, 0.5 * PI),
        ..dynamic(0.0, 0.0, 0.0)
    };
    let body = world.create_body(&def).expect("room");
    world.create_shape(body, &ShapeDef { pose: at(3.0, 0.0, 0.0), ..ball(0.5) }).expect("room");
    // The arm of 3 m along the body's x is along y in the world.
    near(velocity(&world, body), Vec3::new(1.0 - 6.0, 0.0, 0.0), 1.0e-5);
    near(spin(&world, body), Vec3::new(0.0, 0.0, 2.0), 0.0);
    let center = world.center(body).expect("the body exists").to_f64();
    assert!((center[1] - 3.0).abs() < 1.0e-6 && center[0].abs() < 1.0e-6, "{center:?}");
    // Freely it turns about that center.
    run(&mut world, 60);
    near(velocity(&world, body), Vec3::new(-5.0, 0.0, 0.0), 1.0e-5);
    let center = world.center(body).expect("the body exists").to_f64();
    assert!((center[0] + 5.0).abs() < 1.0e-4 && (center[1] - 3.0).abs() < 1.0e-4, "{center:?}");
}

#[test]
fn shapes_collide_at_their_local_poses() {
    // A table: a light top on two boxes as legs. It stands on the legs, its origin in the top.
    let mut world = worlds::world_with(Capacities { shapes: 4, ..Capacities::for_bodies(2) });
    worlds::ground(&mut world, 0.6);
    let body = world.create_body(&dynamic(0.0, 0.0, 1.01)).expect("room");
    let top = ShapeDef { density: 100.0, ..cuboid(1.0, 0.5, 0.05) };
    world.create_shape(body, &top).expect("room");
    for x in [-0.9, 0.9] {
        world
            .create_shape(body, &ShapeDef { pose: at(x, 0.0, -0.5), ..cuboid(0.1, 0.5, 0.5) })
            .expect("room");
    }
    run(&mut world, 120);
    let [x, y, z] = place(&world, body);
    near(Vec3::new(x as f32, y as f32, z as f32), Vec3::new(0.0, 0.0, 1.0), 2.0e-3);
    assert_eq!(world.contacts().count(), 2, "a contact for each leg");
}
