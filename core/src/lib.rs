//! Deterministic rigid bodies in three dimensions: the same bits on every machine, in memory that you own.
//!
//! A [`World`] lives in a block of [`Line`]s handed over when it is made; nothing is ever allocated. Its state is
//! plain bytes: a snapshot is a copy. [`World::step`] takes an [`Executor`] that runs the tasks of each stage; who
//! runs them, and on how many threads, never changes a bit.
#![no_std]
#![forbid(unsafe_code)]

pub mod cells;
pub mod clock;
pub mod collide;
pub mod command;
pub mod config;
pub mod debug;
pub mod executor;
#[doc(hidden)]
pub mod kernel;
pub mod math;
pub mod observe;

mod arena;
mod body;
mod constraint;
mod error;
mod event;
mod handle;
pub mod joint;
mod lanes;
mod material;
mod pipeline;
mod pool;
mod query;
mod report;
mod shape;
mod state;
mod validate;
mod world;

pub use arena::Line;
pub use body::{AxisLocks, BodyDef, BodyKind, MassProperties, Position};
pub use clock::Clock;
pub use command::{Applied, Command, CommandError};
pub use config::{BEHAVIOUR_VERSION, ContactModel, FrictionModel, Preset, Settings};
pub use debug::{DebugDraw, DebugLayers, DebugOptions};
pub use error::{Error, SnapshotError};
pub use event::{
    ContactHit, Event, EventKind, EventKinds, JointBreak, MovedBody, ShapeEvents, Touching, Visit,
};
pub use executor::{Executor, Serial, Stage};
pub use handle::{
    BodyHandle, CompoundHandle, HeightFieldHandle, HullHandle, JointHandle, MeshHandle, ShapeHandle,
};
pub use joint::{Axis, AxisMotion, Coupling, Drive, JointDef, Spring};
pub use material::{MaterialTraits, Mix, PairMaterial};
pub use observe::{Observer, StageView};
pub use query::{
    BodyKinds, ClosestPoint, Found, Hit, Overlap, Probe, Queries, QueryFilter, QueryShape, Ray, Region,
    ShapeCast,
};
pub use report::{Residual, Residuals, StepReport};
pub use shape::{Filter, Geometry, ShapeDef};
pub use state::{Field, FieldKind, Surface};
pub use world::{
    Capacities, CompoundChild, Contact, ContactPoint, HeightFieldDef, SnapshotHeader, SnapshotRing,
    SnapshotSection, World, WorldManifold, xxh64,
};
