//! A world that owns its memory: a `Vec` of lines, allocated once and never again.
//!
//! `cargo run -p cellstep --example owned`

use cellstep::math::Vec3;
use cellstep::{BodyDef, BodyKind, Capacities, Error, Geometry, Line, Serial, ShapeDef, World};

fn main() -> Result<(), Error> {
    // The capacities decide how much memory there is to hand over; `new_world` does these three lines in one.
    let capacities = Capacities::for_bodies(11);
    let memory: Vec<Line> = vec![Line::ZERO; capacities.lines()];
    let mut world = World::new(memory, capacities)?;

    let ground = world.create_body(&BodyDef::new(BodyKind::Static, Vec3::ZERO))?;
    world.create_shape(ground, &ShapeDef::new(Geometry::HalfSpace))?;
    let cube = ShapeDef::new(Geometry::Box { half_extents: Vec3::splat(0.5) });
    let mut top = ground;
    for level in 0..10 {
        let place = Vec3::new(0.0, 0.0, 0.5 + level as f32);
        top = world.create_body(&BodyDef::new(BodyKind::Dynamic, place))?;
        world.create_shape(top, &cube)?;
    }

    for _ in 0..300 {
        world.step(&mut Serial);
    }
    let height = world.position(top)?.to_f64()[2];
    assert!((9.4..9.6).contains(&height), "the tower stands");
    println!("after {} steps the top cube's center is at {height:.4} m", world.steps());
    println!("{} bytes of memory, checksum {:016x}", 64 * capacities.lines(), world.checksum());

    // The memory comes back, to make another world on it.
    let memory = world.into_memory();
    let again = World::new(memory, capacities)?;
    assert_eq!(again.body_count(), 0, "a new world is empty, whatever was in its memory");
    Ok(())
}
