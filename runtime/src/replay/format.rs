//! The bytes of a replay: a preamble, and records that each carry their length and a checksum.
//!
//! ```text
//! preamble   "CELLRPLY", format version u32, behaviour version u32
//! record     payload length u32 | kind u8 | payload | checksum u64
//! ```
//! All little-endian. A record's checksum is XXH64 of its length, kind and payload, seeded with the checksum of the
//! record before (the first one with that of the preamble): records cannot be swapped, dropped or taken from
//! another file.
//!
//! ```text
//! World Asset* Keyframe (Step | Checksums | Keyframe)* End
//! ```

use super::ReplayError;
use cellstep_core::{BEHAVIOUR_VERSION, Capacities, xxh64};

/// Version of the format of replays that this build writes and reads.
pub const FORMAT_VERSION: u32 = 1;

pub(super) const MAGIC: [u8; 8] = *b"CELLRPLY";
/// Bytes of the preamble.
pub(super) const PREAMBLE: usize = 16;
/// Bytes of a record around its payload.
pub(super) const FRAME: usize = 4 + 1 + 8;

/// Capacities, hashes of layout and assets, intervals, note.
pub(super) const WORLD: u8 = 1;
/// One asset.
pub(super) const ASSET: u8 = 2;
/// Why, step, number of commands since, sealed snapshot.
pub(super) const KEYFRAME: u8 = 3;
/// Step, number of commands; for each whether it was refused, and its encoding.
pub(super) const STEP: u8 = 4;
/// Step, checksum, checksum of each section.
pub(super) const CHECKSUMS: u8 = 5;
/// Step: the recording was finished here.
pub(super) const END: u8 = 6;

pub(super) fn preamble() -> [u8; PREAMBLE] {
    let mut bytes = [0; PREAMBLE];
    bytes[..8].copy_from_slice(&MAGIC);
    bytes[8..12].copy_from_slice(&FORMAT_VERSION.to_le_bytes());
    bytes[12..].copy_from_slice(&BEHAVIOUR_VERSION.to_le_bytes());
    bytes
}

/// Makes a record of a payload, in `out`; `seal` is the checksum of the record before, and becomes this one's.
pub(super) fn frame(out: &mut Vec<u8>, kind: u8, parts: &[&[u8]], seal: &mut u64) {
    let length: usize = parts.iter().map(|part| part.len()).sum();
    out.clear();
    out.extend_from_slice(&u32::try_from(length).expect("a record is below 4 GiB").to_le_bytes());
    out.push(kind);
    parts.iter().for_each(|part| out.extend_from_slice(part));
    *seal = xxh64(out, *seal);
    out.extend_from_slice(&seal.to_le_bytes());
}

/// A record of a replay.
pub(super) struct Record<'a> {
    pub kind: u8,
    /// Where the record begins, and its payload.
    pub offset: usize,
    pub payload: &'a [u8],
}

/// Cuts bytes into records.
pub(super) struct Records<'a> {
    bytes: &'a [u8],
    offset: usize,
    seal: u64,
}

/// What comes after some records.
pub(super) enum Next<'a> {
    Record(Record<'a>),
    /// The bytes end here, after a whole record.
    End,
    /// The bytes end within a record, as after a crash.
    Cut,
}

impl<'a> Records<'a> {
    /// Checks the preamble.
    pub fn new(bytes: &'a [u8]) -> Result<Self, ReplayError> {
        let magic = bytes.get(..MAGIC.len()).ok_or(ReplayError::NotAReplay)?;
        if magic != MAGIC {
            return Err(ReplayError::NotAReplay);
        }
        let mut rest = &bytes[MAGIC.len()..];
        let format = u32_of(&mut rest).ok_or(ReplayError::NoStart)?;
        if format != FORMAT_VERSION {
            return Err(ReplayError::Format { found: format });
        }
        let behaviour = u32_of(&mut rest).ok_or(ReplayError::NoStart)?;
        if behaviour != BEHAVIOUR_VERSION {
            return Err(ReplayError::Behaviour { found: behaviour });
        }
        Ok(Self { bytes, offset: PREAMBLE, seal: xxh64(&bytes[..PREAMBLE], 0) })
    }

    /// Bytes that were read.
    pub fn offset(&self) -> usize {
        self.offset
    }

    pub fn next(&mut self) -> Result<Next<'a>, ReplayError> {
        let rest = &self.bytes[self.offset..];
        if rest.is_empty() {
            return Ok(Next::End);
        }
        // A file system may leave zeros where a write did not arrive; no record has kind 0.
        if rest.iter().take(FRAME).all(|&byte| byte == 0) && rest.iter().all(|&byte| byte == 0) {
            return Ok(Next::Cut);
        }
        let Some(length) = rest.first_chunk::<4>() else { return Ok(Next::Cut) };
        let length = u32::from_le_bytes(*length) as usize;
        let Some(record) = length.checked_add(FRAME).and_then(|size| rest.get(..size)) else {
            return self.cut_or_damaged(rest);
        };
        let (content, seal) = record.split_at(record.len() - 8);
        let found = xxh64(content, self.seal);
        if found.to_le_bytes() != *seal {
            // Zeros from within the record to the end of the file are a write that did not arrive.
            let after = &rest[record.len()..];
            let has_zeros = !after.is_empty() || seal.last() == Some(&0);
            let is_cut = has_zeros && after.iter().all(|&byte| byte == 0);
            return if is_cut { Ok(Next::Cut) } else { Err(ReplayError::Damaged { offset: self.offset }) };
        }
        let record = Record { kind: content[4], offset: self.offset, payload: &content[5..] };
        self.seal = found;
        self.offset += record.payload.len() + FRAME;
        Ok(Next::Record(record))
    }

    /// A record that goes on beyond the bytes: its end is missing, unless its kind is none.
    fn cut_or_damaged(&self, rest: &[u8]) -> Result<Next<'a>, ReplayError> {
        match rest.get(4) {
            Some(&kind) if !(WORLD..=END).contains(&kind) => {
                Err(ReplayError::Damaged { offset: self.offset })
            }
            _ => Ok(Next::Cut),
        }
    }
}

pub(super) fn u32_of(rest: &mut &[u8]) -> Option<u32> {
    let (bytes, after) = rest.split_first_chunk()?;
    *rest = after;
    Some(u32::from_le_bytes(*bytes))
}

pub(super) fn u64_of(rest: &mut &[u8]) -> Option<u64> {
    let (bytes, after) = rest.split_first_chunk()?;
    *rest = after;
    Some(u64::from_le_bytes(*bytes))
}

/// Numbers of a [`Capacities`].
const CAPACITIES: usize = 18;

/// What the first record says.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct WorldRecord {
    pub capacities: Capacities,
    pub layout_hash: u64,
    pub assets_hash: u64,
    pub checksums_every: u32,
    pub keyframes_every: u32,
    pub watches_commands: bool,
    pub note: String,
}

impl WorldRecord {
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut out = Vec::new();
        for number in to_numbers(&self.capacities) {
            out.extend_from_slice(&number.to_le_bytes());
        }
        out.extend_from_slice(&self.layout_hash.to_le_bytes());
        out.extend_from_slice(&self.assets_hash.to_le_bytes());
        out.extend_from_slice(&self.checksums_every.to_le_bytes());
        out.extend_from_slice(&self.keyframes_every.to_le_bytes());
        out.extend_from_slice(&u32::from(self.watches_commands).to_le_bytes());
        out.extend_from_slice(self.note.as_bytes());
        out
    }

    pub fn read(payload: &[u8]) -> Option<Self> {
        let mut rest = payload;
        let mut numbers = [0; CAPACITIES];
        for number in &mut numbers {
            *number = u32_of(&mut rest)?;
        }
        Some(Self {
            capacities: from_numbers(numbers),
            layout_hash: u64_of(&mut rest)?,
            assets_hash: u64_of(&mut rest)?,
            checksums_every: u32_of(&mut rest)?,
            keyframes_every: u32_of(&mut rest)?,
            watches_commands: u32_of(&mut rest).filter(|&watches| watches <= 1)? == 1,
            note: String::from_utf8(rest.to_vec()).ok()?,
        })
    }
}

/// Names of the numbers of a [`Capacities`], in the order of the format.
macro_rules! capacities {
    ($($name:ident),* $(,)?) => {
        pub(super) fn to_numbers(capacities: &Capacities) -> [u32; CAPACITIES] {
            let Capacities { $($name),* } = *capacities;
            [$($name),*]
        }

        fn from_numbers(numbers: [u32; CAPACITIES]) -> Capacities {
            let [$($name),*] = numbers;
            Capacities { $($name),* }
        }

        /// Capacities with their names.
        pub(super) const NAMES: [&str; CAPACITIES] = [$(stringify!($name)),*];
    };
}

capacities!(
    bodies,
    shapes,
    pairs,
    contacts,
    joints,
    hulls,
    meshes,
    mesh_vertices,
    mesh_triangles,
    height_fields,
    height_samples,
    compounds,
    compound_children,
    surfaces,
    materials,
    pair_rules,
    events,
    sensor_visits,
);
