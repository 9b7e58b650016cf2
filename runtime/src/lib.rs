//! Deterministic rigid bodies in three dimensions: the same bits for any number of workers, on every machine.
//!
//! This crate is `cellstep-core`, re-exported whole, with what needs an operating system: worlds whose memory
//! comes from the heap ([`new_world`]), a pool of threads that runs a step's tasks ([`Pool`]), times of
//! stages ([`Timed`]), and, behind the feature `scene`, scene documents and the built-in scenes.
//!
//! ```
//! use cellstep::math::Vec3;
//! use cellstep::{BodyDef, BodyKind, Capacities, Geometry, Pool, Position, QueryFilter, Ray, ShapeDef, new_world};
//!
//! let mut world = new_world(Capacities::for_bodies(2))?;
//! let ground = world.create_body(&BodyDef::new(BodyKind::Static, Vec3::ZERO))?;
//! world.create_shape(ground, &ShapeDef::new(Geometry::HalfSpace))?;
//! let ball = world.create_body(&BodyDef::new(BodyKind::Dynamic, Vec3::new(0.0, 0.0, 5.0)))?;
//! world.create_shape(ball, &ShapeDef::new(Geometry::Sphere { radius: 0.5 }))?;
//!
//! let mut pool = Pool::new(2)?;
//! for _ in 0..300 {
//!     world.step(&mut pool);
//! }
//! let height = world.position(ball)?.to_f64()[2];
//! assert!((height - 0.5).abs() < 0.01, "the ball lies on the ground");
//!
//! let down = Ray { origin: Position::at(Vec3::new(0.0, 0.0, 9.0)), translation: Vec3::Z * -20.0 };
//! let hit = world.queries().cast_ray(&down, &QueryFilter::ALL)?.expect("the ball is below");
//! assert_eq!(hit.body, ball);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Features
//!
//! - `scene`: `scene` documents in JSON, meshes from OBJ files, built-in scenes; `mjcf`: models in MuJoCo's format.
//! - `delta`: `delta`, what turns one snapshot into another, compressed.
//! - `cli`: the command `cellstep`; implies `scene`.
//!
//! No feature changes any result.

#![deny(unsafe_code)]

#[cfg(feature = "delta")]
pub mod delta;
mod epoch;
pub mod float_mode;
#[allow(unsafe_code)]
mod job;
mod memory;
#[cfg(feature = "scene")]
pub mod mjcf;
pub mod pool;
pub mod replay;
#[cfg(feature = "scene")]
pub mod scene;
mod spin;
mod sync;
pub mod timed;

pub use cellstep_core::*;
pub use memory::Memory;
pub use pool::Pool;
pub use timed::Timed;

/// Makes a world on memory from the heap: stepping allocates nothing. Room that no scene fills costs nothing
/// either, see [`Memory`].
///
/// # Errors
/// Those of [`World::new`]; [`Error::MemoryTooSmall`] with nothing given when the system has not so much
/// memory.
pub fn new_world(capacities: Capacities) -> Result<World<Memory>, Error> {
    capacities.check()?;
    let needed = capacities.lines();
    World::new(Memory::zeroed(needed).ok_or(Error::MemoryTooSmall { needed, given: 0 })?, capacities)
}

/// Makes a ring of `depth` snapshots on memory from the heap. Saving allocates nothing, and room that no snapshot
/// fills costs nothing, see [`Memory`].
///
/// # Errors
/// Those of [`SnapshotRing::new`]; [`Error::MemoryTooSmall`] with nothing given when the system has not so much
/// memory.
pub fn new_ring(capacities: &Capacities, depth: usize) -> Result<SnapshotRing<Memory>, Error> {
    capacities.check()?;
    let needed = SnapshotRing::<Memory>::lines(capacities, depth);
    SnapshotRing::new(
        Memory::zeroed(needed).ok_or(Error::MemoryTooSmall { needed, given: 0 })?,
        capacities,
        depth,
    )
}
