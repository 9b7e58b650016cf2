//! A small game for two: each player rolls a ball in a walled yard, kicks crates, and makes and removes things.
//!
//! Everything that a frame does follows from the world and the players' buttons, as commands. So the world is all
//! that has to be saved to go back in time.

use cellstep::math::{Rotation, Vec3};
use cellstep::{
    Applied, BodyDef, BodyHandle, BodyKind, Capacities, Command, Error, Geometry, Memory, Position, ShapeDef,
    World, new_world,
};

/// Room in the yard.
pub const CAPACITIES: Capacities = Capacities { bodies: 40, ..Capacities::for_bodies(40) };
/// Most commands of a frame.
pub const COMMANDS_MAX: usize = 12;

const EAST: u8 = 1;
const WEST: u8 = 2;
const NORTH: u8 = 4;
const SOUTH: u8 = 8;
const MAKE: u8 = 16;
const REMOVE: u8 = 32;
const KICK: u8 = 64;

/// What the yard is made of, in [`BodyDef::user`].
const BALL: u64 = 1;
const CRATE: u64 = 2;
const MADE: u64 = 3;

/// A command that was given to the world, and whether it was refused.
pub type Played = (Command, bool);

/// The yard before the first frame.
pub fn yard() -> Result<World<Memory>, Error> {
    let mut world = new_world(CAPACITIES)?;
    let ground = world.create_body(&BodyDef::new(BodyKind::Static, Vec3::ZERO))?;
    world.create_shape(ground, &ShapeDef::new(Geometry::HalfSpace))?;
    for (side, x, y) in [(8.0, 0.5, 9.0), (-8.0, 0.5, 9.0)] {
        for (place, half_extents) in [
            (Vec3::new(side, 0.0, 1.0), Vec3::new(x, y, 1.0)),
            (Vec3::new(0.0, side, 1.0), Vec3::new(y, x, 1.0)),
        ] {
            let wall = world.create_body(&BodyDef::new(BodyKind::Static, place))?;
            world.create_shape(wall, &ShapeDef::new(Geometry::Box { half_extents }))?;
        }
    }
    for x in [-5.0, 5.0] {
        let def = BodyDef { user: BALL, ..BodyDef::new(BodyKind::Dynamic, Vec3::new(x, 0.0, 0.6)) };
        let ball = world.create_body(&def)?;
        world.create_shape(ball, &ShapeDef::new(Geometry::Sphere { radius: 0.6 }))?;
    }
    for i in 0..12 {
        let place = Vec3::new((i % 3) as f32 - 1.0, (i / 3 % 2) as f32 - 0.5, 0.4 + 0.85 * (i / 6) as f32);
        let def = BodyDef { user: CRATE, ..BodyDef::new(BodyKind::Dynamic, place) };
        let crate_ = world.create_body(&def)?;
        world.create_shape(crate_, &ShapeDef::new(Geometry::Box { half_extents: Vec3::splat(0.4) }))?;
    }
    Ok(world)
}

/// What a player presses in a frame: something else every few frames.
pub fn buttons(player: usize, frame: u64) -> u8 {
    let turn = (frame / (3 + player as u64)) << 1 | player as u64;
    // SplitMix64's last step.
    let z = turn.wrapping_add(1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    let z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    ((z ^ (z >> 27)) >> 32) as u8
}

/// Does what the players' buttons say, and adds the commands to `played`.
pub fn play(world: &mut World<Memory>, buttons: [u8; 2], played: &mut Vec<Played>) {
    for (player, pressed) in buttons.into_iter().enumerate() {
        let Some(ball) = nth(world, BALL, player) else { continue };
        let (Ok(place), Ok(mass)) = (world.position(ball), world.mass_properties(ball)) else { continue };
        let along = |plus: u8, minus: u8| {
            f32::from(u8::from(pressed & plus != 0)) - f32::from(u8::from(pressed & minus != 0))
        };
        let way = Vec3::new(along(EAST, WEST), along(NORTH, SOUTH), 0.0);
        give(world, Command::ApplyForce(ball, way * (12.0 * mass.mass)), played);
        // Players act in turns, so that a button held does not act in every frame.
        let turn = (world.steps() + 3 * player as u64) % 6;
        match turn {
            0 if pressed & MAKE != 0 => make(world, place.plus(Vec3::Z * 1.5), played),
            2 if pressed & REMOVE != 0 => {
                if let Some(body) = nth(world, MADE, 0) {
                    give(world, Command::RemoveBody(body), played);
                }
            }
            4 if pressed & KICK != 0 => {
                if let Some(body) = nth(world, CRATE, world.steps() as usize % 12) {
                    give(world, Command::ApplyImpulse(body, Vec3::new(300.0, -200.0, 900.0)), played);
                }
            }
            _ => {}
        }
    }
}

fn make(world: &mut World<Memory>, position: Position, played: &mut Vec<Played>) {
    let rotation = Rotation::from_axis_angle(Vec3::X, 0.1 * (world.steps() % 30) as f32);
    let def = BodyDef { position, rotation, user: MADE, ..BodyDef::new(BodyKind::Dynamic, Vec3::ZERO) };
    // Where there is no room, both machines are told so.
    let Some(Applied::Body(body)) = give(world, Command::CreateBody(def), played) else { return };
    let geometry = if world.steps().is_multiple_of(4) {
        Geometry::Capsule { half_height: 0.3, radius: 0.25 }
    } else {
        Geometry::Box { half_extents: Vec3::new(0.3, 0.25, 0.4) }
    };
    give(world, Command::CreateShape(body, ShapeDef::new(geometry)), played);
}

fn give(world: &mut World<Memory>, command: Command, played: &mut Vec<Played>) -> Option<Applied> {
    let outcome = world.apply(&command);
    played.push((command, outcome.is_err()));
    outcome.ok()
}

/// The n-th body of a sort, by slots.
fn nth(world: &World<Memory>, sort: u64, n: usize) -> Option<BodyHandle> {
    world.bodies().filter(|&body| world.body_user(body) == Ok(sort)).nth(n)
}
