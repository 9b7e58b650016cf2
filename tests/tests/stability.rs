//! Collisions make no energy: whatever bodies meet, however fast they are.

use cellstep::math::{Rotation, Vec3};
use cellstep::{BodyDef, BodyHandle, BodyKind, Geometry, Serial, Settings, ShapeDef};
use cellstep_tests::executors::Random;
use cellstep_tests::worlds::{self, OwnedWorld};

/// Kinetic energy of all bodies, J.
fn energy(world: &OwnedWorld, bodies: &[BodyHandle]) -> f64 {
    let of = |body: &BodyHandle| {
        let mass = world.mass_properties(*body).expect("it exists");
        let v = world.linear_velocity(*body).expect("it exists");
        let frame = world.rotation(*body).expect("it exists").after(mass.axes);
        let w = frame.unrotate(world.angular_velocity(*body).expect("it exists"));
        let square = |x: f32, y: f32| f64::from(x) * f64::from(y) * f64::from(y);
        let turning = square(mass.inertia.x, w.x) + square(mass.inertia.y, w.y) + square(mass.inertia.z, w.z);
        0.5 * (f64::from(mass.mass) * f64::from(v.dot(v)) + turning)
    };
    bodies.iter().map(of).sum()
}

fn vector(random: &mut Random, size: f32) -> Vec3 {
    Vec3::new(random.between(-size, size), random.between(-size, size), random.between(-size, size))
}

/// A body of some geometry near a place, that flies towards the origin.
fn thrown(world: &mut OwnedWorld, random: &mut Random, (distance, speed): (f32, f32)) -> BodyHandle {
    let size = random.between(0.05, 0.5);
    let geometry = match random.below(3) {
        0 => Geometry::Sphere { radius: size },
        1 => Geometry::Capsule { half_height: 2.0 * size, radius: 0.5 * size },
        _ => Geometry::Box { half_extents: Vec3::new(size, 0.2, 2.0 * size) },
    };
    let place = Vec3::X * distance + vector(random, 0.6);
    let def = BodyDef {
        rotation: Rotation::from_rotation_vector(vector(random, 3.0)),
        linear_velocity: Vec3::X * (-distance * speed) + vector(random, 0.2 * speed),
        angular_velocity: vector(random, 20.0),
        ..BodyDef::new(BodyKind::Dynamic, place)
    };
    let shape = ShapeDef { density: random.between(20.0, 2000.0), ..ShapeDef::new(geometry) };
    worlds::add(world, &def, &shape).0
}

/// Two bodies that hit each other off center slide along each other for metres within a step.
#[test]
fn fast_grazing_bodies_gain_no_energy() {
    let mut random = Random::new(5);
    let mut touched = 0;
    for case in 0..400 {
        let mut world = worlds::world(2);
        let settings = Settings { gravity: Vec3::ZERO, ..Settings::default() };
        world.set_settings(&settings).expect("valid");
        let speed = [3.0, 10.0, 30.0, 60.0][case % 4];
        let bodies =
            [thrown(&mut world, &mut random, (-1.0, speed)), thrown(&mut world, &mut random, (1.0, speed))];
        let start = energy(&world, &bodies);
        for step in 0..30 {
            touched += world.step(&mut Serial).contacts;
            let now = energy(&world, &bodies);
            // The push-out of overlaps may add a little.
            assert!(now < 1.05 * start + 50.0, "case {case}, step {step}: {start} J became {now} J");
        }
    }
    assert!(touched > 200, "{touched} contacts");
}
