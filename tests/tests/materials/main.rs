//! Materials beyond friction and restitution, and rules for pairs: against closed forms, and the same bits always.

mod bits;
mod conveyor;
mod mixing;
mod one_way;
mod pairs;
mod pool;
mod resistance;
mod robust;

use cellstep::math::Vec3;
use cellstep::{
    BodyDef, BodyHandle, BodyKind, Capacities, Geometry, MaterialTraits, Settings, ShapeDef, ShapeHandle,
};
use cellstep_tests::worlds::{OwnedWorld, world_with};

/// Steps per second of the default settings.
const RATE: u32 = 60;

/// A world with room for materials and rules.
fn room(bodies: u32) -> OwnedWorld {
    world_with(Capacities { materials: 8, pair_rules: 8, ..Capacities::for_bodies(bodies) })
}

/// A static half-space below z = 0.
fn floor(world: &mut OwnedWorld, def: ShapeDef) -> (BodyHandle, ShapeHandle) {
    let body = world.create_body(&BodyDef::new(BodyKind::Static, Vec3::ZERO)).expect("room");
    let def = ShapeDef { geometry: Geometry::HalfSpace, ..def };
    (body, world.create_shape(body, &def).expect("room"))
}

fn cuboid(x: f32, y: f32, z: f32) -> ShapeDef {
    ShapeDef::new(Geometry::Box { half_extents: Vec3::new(x, y, z) })
}

fn ball(radius: f32) -> ShapeDef {
    ShapeDef::new(Geometry::Sphere { radius })
}

fn dynamic(x: f32, y: f32, z: f32) -> BodyDef {
    BodyDef::new(BodyKind::Dynamic, Vec3::new(x, y, z))
}

fn rolling(rolling: f32) -> MaterialTraits {
    MaterialTraits { rolling, ..MaterialTraits::default() }
}

fn place(world: &OwnedWorld, body: BodyHandle) -> [f64; 3] {
    world.position(body).expect("it exists").to_f64()
}

/// Gravity that makes the flat floor a slope down along +x, of this tangent.
fn incline(world: &mut OwnedWorld, tangent: f32) {
    let cosine = 1.0 / cellstep::math::sqrt(1.0 + tangent * tangent);
    let gravity = Vec3::new(9.81 * tangent * cosine, 0.0, -9.81 * cosine);
    world.set_settings(&Settings { gravity, ..Settings::default() }).expect("in range");
}
