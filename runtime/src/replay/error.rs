//! Why a replay cannot be written or read.

use cellstep_core::{BEHAVIOUR_VERSION, Error};
use std::{fmt, io};

/// Why a replay cannot be written or read.
#[non_exhaustive]
#[derive(Debug)]
pub enum ReplayError {
    /// The file system refused.
    Io(io::Error),
    /// The first eight bytes are not a replay's.
    NotAReplay,
    /// Written in another version of the format.
    Format {
        /// The version in the bytes.
        found: u32,
    },
    /// Recorded with another behaviour version: play it with that version.
    Behaviour {
        /// The version in the bytes.
        found: u32,
    },
    /// A record's bytes do not match its checksum.
    Damaged {
        /// Where the record begins.
        offset: usize,
    },
    /// A record whose checksum is right says what no recording says.
    Malformed {
        /// Where the record begins.
        offset: usize,
        /// What is wrong, for people.
        what: &'static str,
    },
    /// The bytes end before there is a state to begin with.
    NoStart,
    /// The replay's world is larger than the reader allows: see [`Limits`](super::Limits).
    TooLarge {
        /// Bytes of the world.
        bytes: u64,
        /// Bytes allowed.
        limit: u64,
    },
    /// The assets are not those of the world: register each through the same
    /// [`AssetSet`](super::AssetSet), from the first on.
    Assets,
    /// The replay's world cannot be made: a capacity, an asset or a keyframe is refused.
    World(Error),
}

/// What to do about a [`ReplayError`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ErrorKind {
    /// Look at the file system, or at the caller.
    Usage,
    /// The bytes are not what was written, or were never a recording.
    Corrupt,
    /// Another version reads them.
    Version,
}

impl ReplayError {
    /// What to do about it.
    pub fn kind(&self) -> ErrorKind {
        match self {
            ReplayError::Io(_) | ReplayError::Assets | ReplayError::TooLarge { .. } => ErrorKind::Usage,
            ReplayError::Format { .. } | ReplayError::Behaviour { .. } => ErrorKind::Version,
            _ => ErrorKind::Corrupt,
        }
    }
}

impl fmt::Display for ReplayError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            ReplayError::Io(error) => write!(f, "{error}"),
            ReplayError::NotAReplay => write!(f, "these bytes are no replay"),
            ReplayError::Format { found } => {
                write!(f, "the replay has format version {found}, this reads {}", super::FORMAT_VERSION)
            }
            ReplayError::Behaviour { found } => {
                write!(f, "the replay has behaviour version {found}, this is {BEHAVIOUR_VERSION}")
            }
            ReplayError::Damaged { offset } => {
                write!(f, "the record at byte {offset} does not match its checksum")
            }
            ReplayError::Malformed { offset, what } => write!(f, "the record at byte {offset}: {what}"),
            ReplayError::NoStart => write!(f, "the replay ends before its first state"),
            ReplayError::TooLarge { bytes, limit } => {
                write!(f, "the replay's world takes {bytes} bytes, {limit} are allowed")
            }
            ReplayError::Assets => write!(f, "the set of assets is not that of the world"),
            ReplayError::World(error) => write!(f, "the replay's world is refused: {error}"),
        }
    }
}

impl std::error::Error for ReplayError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match self {
            ReplayError::Io(error) => Some(error),
            ReplayError::World(error) => Some(error),
            _ => None,
        }
    }
}

impl From<io::Error> for ReplayError {
    fn from(error: io::Error) -> Self {
        ReplayError::Io(error)
    }
}

impl From<Error> for ReplayError {
    fn from(error: Error) -> Self {
        ReplayError::World(error)
    }
}
