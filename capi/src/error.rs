//! Codes of errors, and the message of the last one.

use cellstep::{Error, SnapshotError};
use std::cell::RefCell;
use std::ffi::c_char;
use std::fmt::{self, Write};

/// What came of a call. After anything but `CS_RESULT_OK` the world is unchanged, and `cs_error_message` says more.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CsResult {
    /// Done.
    Ok = 0,
    /// A pointer that must not be null is null.
    NullPointer = 1,
    /// Memory does not start where its type must: 64 bytes for worlds and rings.
    Misaligned = 2,
    /// The memory is too small.
    MemoryTooSmall = 3,
    /// A capacity, or the depth of a ring, is out of its range.
    CapacityOutOfRange = 4,
    /// A pool is full.
    Full = 5,
    /// A number is not finite.
    NotFinite = 6,
    /// A number is out of its range.
    OutOfRange = 7,
    /// A rotation is not a unit quaternion within 1e-3.
    NotARotation = 8,
    /// A handle names nothing that exists now.
    Stale = 9,
    /// The body's kind does not allow this.
    WrongKind = 10,
    /// A query takes shapes with an inside only.
    NotConvex = 11,
    /// An array or a buffer has another length than is needed.
    WrongLength = 12,
    /// Assets are registered before the first step only.
    AssetsSealed = 13,
    /// Points, triangles, heights or children make no asset.
    BadAsset = 14,
    /// A kind is none of its constants.
    UnknownKind = 15,
    /// The buffer is too small for the snapshot.
    BufferTooSmall = 16,
    /// The bytes are no snapshot.
    NotASnapshot = 17,
    /// The snapshot is of another behaviour version.
    OtherVersion = 18,
    /// The snapshot is of a world with other capacities.
    OtherCapacities = 19,
    /// The snapshot is of a world with other assets.
    OtherAssets = 20,
    /// The snapshot is damaged, or a row of it breaks a rule.
    Damaged = 21,
    /// The ring has no snapshot of this step.
    NotKept = 22,
    /// The system gives no threads.
    System = 23,
    /// A bug of the engine. The world is not to be used any more.
    Panicked = 24,
    /// Another error: see the message.
    Other = 25,
}

/// Why a call failed.
#[derive(Debug)]
pub(crate) enum Failure {
    Null(&'static str),
    Misaligned(&'static str),
    UnknownKind(&'static str),
    Pool(cellstep::pool::PoolError),
    Engine(Error),
}

impl From<Error> for Failure {
    fn from(error: Error) -> Self {
        Self::Engine(error)
    }
}

impl From<SnapshotError> for Failure {
    fn from(error: SnapshotError) -> Self {
        Self::Engine(Error::Snapshot(error))
    }
}

impl Failure {
    pub fn code(&self) -> CsResult {
        match self {
            Self::Null(_) => CsResult::NullPointer,
            Self::Misaligned(_) => CsResult::Misaligned,
            Self::UnknownKind(_) => CsResult::UnknownKind,
            Self::Pool(_) => CsResult::System,
            Self::Engine(error) => code_of(error),
        }
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Null(name) => write!(f, "`{name}` is null"),
            Self::Misaligned(name) => write!(f, "`{name}` is not aligned"),
            Self::UnknownKind(name) => write!(f, "`{name}` is none of its constants"),
            Self::Pool(error) => write!(f, "{error}"),
            Self::Engine(error) => write!(f, "{error}"),
        }
    }
}

fn code_of(error: &Error) -> CsResult {
    match error {
        Error::MemoryTooSmall { .. } => CsResult::MemoryTooSmall,
        Error::CapacityOutOfRange { .. } => CsResult::CapacityOutOfRange,
        Error::Full { .. } => CsResult::Full,
        Error::NotFinite { .. } => CsResult::NotFinite,
        Error::OutOfRange { .. } => CsResult::OutOfRange,
        Error::NotARotation { .. } => CsResult::NotARotation,
        Error::Stale { .. } => CsResult::Stale,
        Error::WrongKind { .. } => CsResult::WrongKind,
        Error::NotConvex => CsResult::NotConvex,
        Error::WrongLength { .. } => CsResult::WrongLength,
        Error::AssetsSealed => CsResult::AssetsSealed,
        Error::Hull(_) | Error::Mesh(_) | Error::HeightField(_) | Error::Compound(_) => CsResult::BadAsset,
        Error::Surface { .. } => CsResult::BadAsset,
        Error::Snapshot(error) => match error {
            SnapshotError::BufferTooSmall { .. } => CsResult::BufferTooSmall,
            SnapshotError::WrongLength { .. } => CsResult::WrongLength,
            SnapshotError::NotASnapshot => CsResult::NotASnapshot,
            SnapshotError::Version { .. } => CsResult::OtherVersion,
            SnapshotError::Capacities => CsResult::OtherCapacities,
            SnapshotError::Assets => CsResult::OtherAssets,
            SnapshotError::NotKept { .. } => CsResult::NotKept,
            SnapshotError::Damaged | SnapshotError::Invalid { .. } => CsResult::Damaged,
            _ => CsResult::Other,
        },
        _ => CsResult::Other,
    }
}

/// Bytes of the longest message, its end included.
const MESSAGE_BYTES: usize = 256;

/// A message that ends in a zero byte, cut off where it is too long.
struct Message {
    bytes: [u8; MESSAGE_BYTES],
    length: usize,
}

impl Write for Message {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        let room = MESSAGE_BYTES - 1 - self.length;
        let mut count = text.len().min(room);
        while !text.is_char_boundary(count) {
            count -= 1;
        }
        self.bytes[self.length..self.length + count].copy_from_slice(&text.as_bytes()[..count]);
        self.length += count;
        self.bytes[self.length] = 0;
        Ok(())
    }
}

thread_local! {
    static MESSAGE: RefCell<Message> = const { RefCell::new(Message { bytes: [0; MESSAGE_BYTES], length: 0 }) };
}

/// Keeps a message for `cs_error_message`.
pub(crate) fn remember(text: impl fmt::Display) {
    MESSAGE.with_borrow_mut(|message| {
        message.length = 0;
        message.bytes[0] = 0;
        // A message that is cut off is still one.
        let _ = write!(message, "{text}");
    });
}

/// Why the last call of this thread that failed has failed, in English. Ends in a zero byte, and stays until
/// another call of this thread fails. Empty when none has.
#[unsafe(no_mangle)]
pub extern "C" fn cs_error_message() -> *const c_char {
    MESSAGE.with_borrow(|message| message.bytes.as_ptr().cast())
}
