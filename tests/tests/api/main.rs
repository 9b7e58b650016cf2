//! What the API promises about bodies, shapes and contacts, each against a closed form or a fact of the scene.

mod changes;
mod forces;
mod handles;
mod kinematic;
mod locks;
mod mass;
mod reading;

use cellstep::math::Vec3;
use cellstep::{BodyDef, BodyHandle, BodyKind, Geometry, Settings, ShapeDef};
use cellstep_tests::worlds::{self, OwnedWorld};

/// Standard gravity of the default settings, m/s2.
const GRAVITY: f64 = 9.81;
/// Steps per second of the default settings.
const RATE: u32 = 60;
/// Length of a substep of the default settings, seconds.
const SUBSTEP: f64 = 1.0 / 240.0;

/// A world without gravity and without ground.
fn weightless(bodies: u32) -> OwnedWorld {
    let mut world = worlds::world(bodies);
    let settings = Settings { gravity: Vec3::ZERO, ..Settings::default() };
    world.set_settings(&settings).expect("zero is in range");
    world
}

/// A world with gravity turned about the y axis, so that its flat ground is a slope down along +x.
fn slope(bodies: u32, (degrees, friction): (f32, f32)) -> OwnedWorld {
    let mut world = worlds::world(bodies);
    let angle = degrees.to_radians();
    let (sine, cosine) = (cellstep::math::sin(angle), cellstep::math::cos(angle));
    let gravity = Vec3::new(9.81 * sine, 0.0, -9.81 * cosine);
    world.set_settings(&Settings { gravity, ..Settings::default() }).expect("in range");
    worlds::ground(&mut world, friction);
    world
}

fn ball(radius: f32) -> ShapeDef {
    ShapeDef::new(Geometry::Sphere { radius })
}

fn cuboid(x: f32, y: f32, z: f32) -> ShapeDef {
    ShapeDef::new(Geometry::Box { half_extents: Vec3::new(x, y, z) })
}

fn dynamic(x: f32, y: f32, z: f32) -> BodyDef {
    BodyDef::new(BodyKind::Dynamic, Vec3::new(x, y, z))
}

fn place(world: &OwnedWorld, body: BodyHandle) -> [f64; 3] {
    world.position(body).expect("the body exists").to_f64()
}

fn velocity(world: &OwnedWorld, body: BodyHandle) -> Vec3 {
    world.linear_velocity(body).expect("the body exists")
}

fn spin(world: &OwnedWorld, body: BodyHandle) -> Vec3 {
    world.angular_velocity(body).expect("the body exists")
}

/// Asserts that vectors agree within a distance.
#[track_caller]
fn near(found: Vec3, expected: Vec3, distance: f32) {
    let error = (found - expected).length();
    assert!(error <= distance, "{found} is {error} from {expected}, which is more than {distance}");
}

/// Asserts that numbers agree within a difference.
#[track_caller]
fn close(found: f64, expected: f64, difference: f64) {
    let error = (found - expected).abs();
    assert!(error <= difference, "{found} is {error} from {expected}, which is more than {difference}");
}

/// Way and speed of a body after `steps` steps at a constant acceleration from rest, as symplectic Euler has them.
fn fallen(acceleration: f64, steps: u32) -> (f64, f64) {
    let n = f64::from(4 * steps);
    (acceleration * SUBSTEP * SUBSTEP * n * (n + 1.0) / 2.0, acceleration * SUBSTEP * n)
}
