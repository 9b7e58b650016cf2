//! Replays: what a world was told, step by step, and proof of what came of it.
//!
//! A replay stands alone. It holds capacities, assets and the state at its start, so the world can be made from
//! nothing; the commands of every step; and checksums of the state, every few steps, by section. Whoever plays it
//! gets the same bits or learns at which step they parted.
//!
//! ```text
//! game --Recorder--> bytes --Replay::read--> Replay --verify--> Same, or the first difference
//!                                                   --bisect--> step, stage, body, field, both values
//! ```
//! [`Recorder`] writes while a game is played: [`Recorder::apply`] instead of [`World::apply`], [`Recorder::step`]
//! instead of [`World::step`]. A file that ends in the middle, as after a crash, is read up to its last whole step.
//! Bytes from anywhere are refused with a [`ReplayError`]; reading takes memory in proportion to the bytes, and
//! making the world as much as [`Limits`] allow.
//!
//! [`World::apply`]: cellstep_core::World::apply
//! [`World::step`]: cellstep_core::World::step

mod assets;
mod bisect;
mod error;
mod format;
mod play;
mod read;
mod record;
mod write;

pub use assets::AssetSet;
pub use bisect::{
    Bisection, FieldDifference, Moment, Parting, Run, bisect, bisect_self, bisect_self_with, bisect_with,
};
pub use error::{ErrorKind, ReplayError};
pub use format::FORMAT_VERSION;
pub use play::{Difference, Divergence, Player, Verdict, verify, verify_with};
pub use read::{Checksums, Keyframe, Replay, StepCommand};
pub use record::Recorder;
pub use write::{Options, Writer};

use cellstep_core::xxh64;

/// Why a keyframe is in a replay.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cause {
    /// The state at the start.
    Start,
    /// It was time for one: see [`Options::keyframes_every`].
    Periodic,
    /// The game asked for it.
    Asked,
    /// The world was changed by other calls than those of the recorder.
    Unrecorded,
}

impl Cause {
    const ALL: [Cause; 4] = [Cause::Start, Cause::Periodic, Cause::Asked, Cause::Unrecorded];

    /// In a word.
    pub const fn name(self) -> &'static str {
        match self {
            Cause::Start => "start",
            Cause::Periodic => "periodic",
            Cause::Asked => "asked",
            Cause::Unrecorded => "unrecorded",
        }
    }
}

/// How much the world of a replay may take.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Bytes of the world that is made.
    pub world_bytes: u64,
}

impl Default for Limits {
    fn default() -> Self {
        Self { world_bytes: 16 << 30 }
    }
}

/// [`World::checksum`](cellstep_core::World::checksum) from those of its sections.
fn total(sums: &[u64]) -> u64 {
    sums.iter().fold(0, |total, sum| xxh64(&sum.to_le_bytes(), total))
}
