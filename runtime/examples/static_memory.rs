//! A world in a static array: no allocator is needed, and the linker tells when memory is short.
//!
//! `cargo run -p cellstep --example static_memory`
//!
//! The array sits in a safe cell, here the standard library's mutex; a device would use its own.

use cellstep::math::Vec3;
use cellstep::{BodyDef, BodyKind, Capacities, Error, Geometry, Line, Serial, ShapeDef, World};
use std::sync::{Mutex, PoisonError};

const CAPACITIES: Capacities = Capacities::for_bodies(17);
/// Computed by the compiler.
const LINES: usize = CAPACITIES.lines();
/// It is zeros, so it takes no room in the executable.
static MEMORY: Mutex<[Line; LINES]> = Mutex::new([Line::ZERO; LINES]);

fn main() -> Result<(), Error> {
    let mut memory = MEMORY.lock().unwrap_or_else(PoisonError::into_inner);
    let mut world = World::new(memory.as_mut_slice(), CAPACITIES)?;

    let ground = world.create_body(&BodyDef::new(BodyKind::Static, Vec3::ZERO))?;
    world.create_shape(ground, &ShapeDef::new(Geometry::HalfSpace))?;
    let ball = ShapeDef::new(Geometry::Sphere { radius: 0.25 });
    for i in 0..16 {
        let place = Vec3::new((i % 4) as f32 * 0.3, (i / 4) as f32 * 0.3, 1.0 + i as f32 * 0.6);
        let body = world.create_body(&BodyDef::new(BodyKind::Dynamic, place))?;
        world.create_shape(body, &ball)?;
    }
    let full = world.create_body(&BodyDef::default());
    assert_eq!(full, Err(Error::Full { name: "bodies" }), "capacities are limits, not hints");

    let mut contacts = 0;
    for _ in 0..240 {
        contacts = world.step(&mut Serial).contacts;
    }
    assert!(contacts >= 16, "every ball lies on something");
    println!("{} bodies, {contacts} contacts in {} bytes", world.body_count(), 64 * LINES);
    println!("checksum {:016x}", world.checksum());
    Ok(())
}
