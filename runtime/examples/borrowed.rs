//! Two worlds side by side on borrowed parts of one block: a game's own arena, say.
//!
//! `cargo run -p cellstep --example borrowed`

use cellstep::math::Vec3;
use cellstep::{BodyDef, BodyHandle, BodyKind, Capacities, Error, Geometry, Line, Serial, ShapeDef, World};

/// A ball above the ground of a world that borrows its memory.
fn fill(world: &mut World<&mut [Line]>) -> Result<BodyHandle, Error> {
    let ground = world.create_body(&BodyDef::new(BodyKind::Static, Vec3::ZERO))?;
    world.create_shape(ground, &ShapeDef::new(Geometry::HalfSpace))?;
    let ball = world.create_body(&BodyDef::new(BodyKind::Dynamic, Vec3::new(0.0, 0.0, 2.0)))?;
    world.create_shape(ball, &ShapeDef::new(Geometry::Sphere { radius: 0.5 }))?;
    Ok(ball)
}

fn main() -> Result<(), Error> {
    let capacities = Capacities::for_bodies(2);
    let mut arena = vec![Line([0xa5; 64]); 2 * capacities.lines() + 3];
    let (one, rest) = arena.split_at_mut(capacities.lines());

    // A slice that is too small is refused, and the error tells how many lines are needed.
    let refused = World::new(&mut rest[..10], capacities).expect_err("ten lines are not enough");
    assert_eq!(refused, Error::MemoryTooSmall { needed: capacities.lines(), given: 10 });
    println!("{refused}");

    let mut authority = World::new(one, capacities)?;
    let mut replica = World::new(rest, capacities)?;
    let ball = fill(&mut authority)?;
    fill(&mut replica)?;
    for _ in 0..120 {
        authority.step(&mut Serial);
        replica.step(&mut Serial);
        assert!(authority.state() == replica.state(), "equal worlds are equal bytes");
    }
    println!("the ball is at {:.4} m in both worlds", authority.position(ball)?.to_f64()[2]);
    Ok(())
}
