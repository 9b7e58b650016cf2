//! Small worlds made by hand, for tests that need no scene.

use cellstep::math::Vec3;
use cellstep::{
    BodyDef, BodyHandle, BodyKind, Capacities, Geometry, Memory, Serial, ShapeDef, ShapeHandle, World,
};

/// A world that owns its memory.
pub type OwnedWorld = World<Memory>;

/// An empty world for `bodies` bodies.
pub fn world(bodies: u32) -> OwnedWorld {
    world_with(Capacities::for_bodies(bodies))
}

/// An empty world.
pub fn world_with(capacities: Capacities) -> OwnedWorld {
    cellstep::new_world(capacities).expect("capacities are in range")
}

/// Adds a static half-space below z = 0 with a friction.
pub fn ground(world: &mut OwnedWorld, friction: f32) -> BodyHandle {
    let body = world.create_body(&BodyDef::new(BodyKind::Static, Vec3::ZERO)).expect("room");
    let def = ShapeDef { friction, ..ShapeDef::new(Geometry::HalfSpace) };
    world.create_shape(body, &def).expect("room");
    body
}

/// Adds a dynamic body with one shape.
pub fn add(world: &mut OwnedWorld, def: &BodyDef, shape: &ShapeDef) -> (BodyHandle, ShapeHandle) {
    let body = world.create_body(def).expect("room");
    let shape = world.create_shape(body, shape).expect("room");
    (body, shape)
}

/// Takes `steps` steps on this thread.
pub fn run(world: &mut OwnedWorld, steps: u32) {
    for _ in 0..steps {
        world.step(&mut Serial);
    }
}
