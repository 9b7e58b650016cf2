//! What can go wrong at the border. A refused call leaves the world unchanged; a step never fails.

use core::fmt;

/// Why a call was refused.
#[non_exhaustive]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Error {
    /// The memory is smaller than [`Capacities::lines`](crate::Capacities::lines) asks: give more lines.
    MemoryTooSmall {
        /// Lines that the capacities need.
        needed: usize,
        /// Lines that were given.
        given: usize,
    },
    /// A capacity is outside its range: see [`Capacities`](crate::Capacities).
    CapacityOutOfRange {
        /// Name of the capacity.
        name: &'static str,
    },
    /// A pool is full: make the world with a greater capacity, or remove something first.
    Full {
        /// Name of the capacity that is exhausted.
        name: &'static str,
    },
    /// A number is not finite: check where it was computed.
    NotFinite {
        /// Name of the argument.
        name: &'static str,
    },
    /// A number is outside its range; the documentation of the named field has the range.
    OutOfRange {
        /// Name of the argument.
        name: &'static str,
    },
    /// A rotation is not a unit quaternion within 1e-3: normalise it.
    NotARotation {
        /// Name of the argument.
        name: &'static str,
    },
    /// The handle names nothing that exists now: it was removed, or it is from another world.
    Stale {
        /// What the handle names: `body`, `shape`, `hull`, `mesh`, `height field` or `compound`.
        what: &'static str,
    },
    /// The body's kind does not allow this: a static body does not move, only a dynamic one takes forces.
    WrongKind {
        /// What the call needs, for people.
        needs: &'static str,
    },
    /// Only shapes with an inside can be moved or laid over others by a query: no half-space, mesh or height field.
    NotConvex,
    /// A slice is not as long as the call needs.
    WrongLength {
        /// Elements that are needed.
        needed: usize,
        /// Elements that were given.
        given: usize,
    },
    /// Assets are registered before the first step only.
    AssetsSealed,
    /// The points have no convex hull that this engine takes.
    Hull(crate::collide::hull::HullError),
    /// The triangles make no mesh that this engine takes.
    Mesh(crate::collide::mesh::MeshError),
    /// The heights make no height field that this engine takes.
    HeightField(crate::collide::height_field::HeightFieldError),
    /// The children make no compound that this engine takes.
    Compound(crate::collide::compound::CompoundError),
    /// A triangle names a surface that was not given, or a number of a surface is out of its range, see
    /// [`Surface`](crate::Surface).
    Surface {
        /// The first such triangle or surface.
        index: u32,
    },
    /// The bytes are no snapshot that this world takes.
    Snapshot(SnapshotError),
}

/// Why bytes were refused by `restore` or `load`.
#[non_exhaustive]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SnapshotError {
    /// The output buffer is smaller than [`snapshot_bytes`](crate::World::snapshot_bytes).
    BufferTooSmall {
        /// Bytes needed.
        needed: usize,
    },
    /// The bytes end too early or go on too long.
    WrongLength {
        /// Bytes that the header promises, or that a header needs.
        needed: usize,
        /// Bytes that were given.
        given: usize,
    },
    /// The first eight bytes are not a snapshot's.
    NotASnapshot,
    /// Written by another behaviour version: replay it with that version.
    Version {
        /// The version in the bytes.
        found: u32,
    },
    /// Made by a world with other capacities, see [`Capacities::layout_hash`](crate::Capacities::layout_hash):
    /// overflow rules depend on them, so they must be the same.
    Capacities,
    /// Made with another set of assets, see [`World::assets_hash`](crate::World::assets_hash): register the same
    /// assets in the same order.
    Assets,
    /// The ring has no snapshot of this step (any more): save at each step, or make the ring deeper.
    NotKept {
        /// The step that was asked for.
        step: u64,
    },
    /// The content hash does not match the bytes: damaged on the way.
    Damaged,
    /// A row breaks a rule of the state.
    Invalid {
        /// The section of the row.
        section: &'static str,
        /// The row's index in the section.
        index: u32,
    },
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Error::MemoryTooSmall { needed, given } => {
                write!(f, "the world needs {needed} lines of 64 bytes, {given} were given")
            }
            Error::CapacityOutOfRange { name } => write!(f, "capacity `{name}` is out of its range"),
            Error::Full { name } => write!(f, "no room left: raise the capacity `{name}`"),
            Error::NotFinite { name } => write!(f, "`{name}` is not finite"),
            Error::OutOfRange { name } => write!(f, "`{name}` is out of its range"),
            Error::NotARotation { name } => write!(f, "`{name}` is not a unit quaternion"),
            Error::Stale { what } => write!(f, "the handle names no {what} that exists now"),
            Error::WrongKind { needs } => write!(f, "wrong kind of body: {needs}"),
            Error::NotConvex => write!(f, "a query takes shapes with an inside only"),
            Error::WrongLength { needed, given } => {
                write!(f, "a slice of {needed} elements was expected, {given} were given")
            }
            Error::AssetsSealed => write!(f, "assets are registered before the first step"),
            Error::Hull(error) => write!(f, "{error}"),
            Error::Mesh(error) => write!(f, "{error}"),
            Error::HeightField(error) => write!(f, "{error}"),
            Error::Compound(error) => write!(f, "{error}"),
            Error::Surface { index } => {
                write!(f, "surface {index}, or that of triangle {index}, does not exist or is out of range")
            }
            Error::Snapshot(error) => write!(f, "{error}"),
        }
    }
}

impl fmt::Display for SnapshotError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            SnapshotError::BufferTooSmall { needed } => write!(f, "the snapshot needs {needed} bytes"),
            SnapshotError::WrongLength { needed, given } => {
                write!(f, "a snapshot of {needed} bytes was expected, {given} were given")
            }
            SnapshotError::NotASnapshot => write!(f, "these bytes are no snapshot"),
            SnapshotError::Version { found } => {
                let own = crate::config::BEHAVIOUR_VERSION;
                write!(f, "the snapshot has behaviour version {found}, this is {own}")
            }
            SnapshotError::Capacities => write!(f, "the snapshot is of a world with other capacities"),
            SnapshotError::Assets => write!(f, "the snapshot is of a world with other assets"),
            SnapshotError::NotKept { step } => write!(f, "no snapshot of step {step} is kept"),
            SnapshotError::Damaged => write!(f, "the snapshot's content does not match its hash"),
            SnapshotError::Invalid { section, index } => {
                write!(f, "row {index} of section `{section}` of the snapshot breaks a rule")
            }
        }
    }
}

impl core::error::Error for Error {}
impl core::error::Error for SnapshotError {}

impl From<SnapshotError> for Error {
    fn from(error: SnapshotError) -> Self {
        Error::Snapshot(error)
    }
}
