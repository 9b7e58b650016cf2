//! Rollback: save, play on, go back, play on otherwise, go back, and play the same again.
//!
//! `cargo run -p cellstep --example rollback`

use cellstep::math::Vec3;
use cellstep::{
    BodyDef, BodyHandle, BodyKind, Capacities, Error, Geometry, Memory, Pool, Serial, ShapeDef, World,
    new_world,
};

/// Steps between the guess and the truth.
const LATENCY: u32 = 30;

/// A wall of 8 x 8 boxes, and a ball before it.
fn wall() -> Result<(World<Memory>, BodyHandle), Error> {
    let mut world = new_world(Capacities::for_bodies(66))?;
    let ground = world.create_body(&BodyDef::new(BodyKind::Static, Vec3::ZERO))?;
    world.create_shape(ground, &ShapeDef::new(Geometry::HalfSpace))?;
    let brick = ShapeDef::new(Geometry::Box { half_extents: Vec3::new(0.25, 0.5, 0.25) });
    for row in 0..8 {
        for column in 0..8 {
            let shift = if row % 2 == 0 { 0.0 } else { 0.5 };
            let place = Vec3::new(0.0, column as f32 + shift - 4.0, 0.25 + row as f32 * 0.5);
            let body = world.create_body(&BodyDef::new(BodyKind::Dynamic, place))?;
            world.create_shape(body, &brick)?;
        }
    }
    let ball = world.create_body(&BodyDef::new(BodyKind::Dynamic, Vec3::new(-3.0, 0.0, 1.5)))?;
    world.create_shape(ball, &ShapeDef::new(Geometry::Sphere { radius: 0.5 }))?;
    Ok((world, ball))
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let (mut world, ball) = wall()?;
    for _ in 0..20 {
        world.step(&mut Serial);
    }

    // The other player's input is not here yet: save, and guess that there is none.
    let mut snapshot = vec![0; world.snapshot_bytes()];
    world.save(&mut snapshot)?;
    for _ in 0..LATENCY {
        world.step(&mut Serial);
    }
    let guess = world.checksum();

    // It arrives late: the ball was kicked. Go back and play what really happened.
    let kick = Vec3::new(8000.0, 0.0, 500.0);
    world.restore(&snapshot)?;
    world.apply_impulse(ball, kick)?;
    for _ in 0..LATENCY {
        world.step(&mut Serial);
    }
    let truth = world.checksum();
    assert_ne!(truth, guess, "the kick made a difference");

    // The other player's machine has played the same, on other threads.
    world.restore(&snapshot)?;
    world.apply_impulse(ball, kick)?;
    let mut pool = Pool::new(2)?;
    for _ in 0..LATENCY {
        world.step(&mut pool);
    }
    assert_eq!(world.checksum(), truth, "the same state and the same calls give the same bits");
    println!("{} bytes saved, {} contacts now", snapshot.len(), world.contacts().count());
    println!("guess {guess:016x}, truth {truth:016x}, and again {:016x}", world.checksum());
    Ok(())
}
