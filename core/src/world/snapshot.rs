//! Snapshots: a header and one copy per section, up to its high-water mark.

mod caches;
mod header;

use super::World;
use super::checksum::hash;
use crate::arena::Line;
use crate::error::{Error, SnapshotError};
use crate::state::{Header, StateLayout, sections_in_use};
use core::mem::size_of;
use core::ops::Range;

pub(super) use caches::Done;
pub use header::SnapshotHeader;

/// A section of a snapshot, as [`World::snapshot_sections`] tells.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SnapshotSection {
    /// Name, as in [`World::checksum_by_section`].
    pub name: &'static str,
    /// Bytes of a row.
    pub row_bytes: usize,
    /// Where its rows lie in the snapshot: whole rows, without gaps between sections.
    pub range: Range<usize>,
}

/// A section of the state as bytes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Section {
    pub name: &'static str,
    pub offset: usize,
    /// Bytes of a row.
    pub size: usize,
    /// Rows below the high-water mark.
    pub rows: usize,
}

impl Section {
    /// The rows below the mark.
    pub fn live<'a>(&self, state: &'a [u8]) -> &'a [u8] {
        &state[self.offset..self.offset + self.rows * self.size]
    }
}

/// How many sections the state has.
pub(super) const SECTIONS: usize = 27;

const _: () = assert!(cfg!(target_endian = "little"), "the state's bytes are little-endian");

/// The sections of a state, for the marks of a header that are within the capacities.
pub(super) fn sections_of(s: &StateLayout, header: &Header) -> [Section; SECTIONS] {
    macro_rules! section {
        ($name:ident, $rows:expr) => {
            Section {
                name: stringify!($name),
                offset: s.$name.offset,
                size: s.$name.row_bytes(),
                rows: $rows.min(s.$name.count),
            }
        };
    }
    sections_in_use!(header, section)
}

impl<M: AsRef<[Line]> + AsMut<[Line]>> World<M> {
    pub(super) fn sections_for(&self, header: &Header) -> [Section; SECTIONS] {
        sections_of(&self.layout.state, header)
    }

    pub(super) fn sections(&self) -> [Section; SECTIONS] {
        self.sections_for(self.header())
    }

    /// Bytes of a snapshot taken now.
    pub fn snapshot_bytes(&self) -> usize {
        SnapshotHeader::BYTES + self.sections().iter().map(|s| s.rows * s.size).sum::<usize>()
    }

    /// The sections of a snapshot in their order: which bytes are what. They begin right after the header.
    ///
    /// # Errors
    /// A [`SnapshotError`] when this world would refuse the header or the length; rows are not looked at.
    pub fn snapshot_sections(
        &self,
        snapshot: &[u8],
    ) -> Result<impl Iterator<Item = SnapshotSection> + use<M>, SnapshotError> {
        let sections = self.sections_for(&self.check_header(snapshot)?);
        let mut start = SnapshotHeader::BYTES;
        Ok(sections.into_iter().map(move |section| {
            let range = start..start + section.rows * section.size;
            start = range.end;
            SnapshotSection { name: section.name, row_bytes: section.size, range }
        }))
    }

    /// Copies the state to `out` and returns the number of bytes written: a copy for each section.
    ///
    /// The content hash is left 0, which `restore` does not look at and `load` accepts; [`World::seal`] fills it in
    /// for a snapshot that leaves the process.
    ///
    /// # Errors
    /// [`SnapshotError::BufferTooSmall`].
    pub fn save(&self, out: &mut [u8]) -> Result<usize, Error> {
        let needed = self.snapshot_bytes();
        let out = out.get_mut(..needed).ok_or(SnapshotError::BufferTooSmall { needed })?;
        let (head, mut rest) = out.split_at_mut(SnapshotHeader::BYTES);
        head.copy_from_slice(&self.snapshot_header(needed).to_bytes());
        for section in self.sections() {
            let live = section.live(self.state());
            let (own, after) = rest.split_at_mut(live.len());
            own.copy_from_slice(live);
            rest = after;
        }
        Ok(needed)
    }

    /// Writes the content hash into a snapshot, so that `load` finds damage.
    ///
    /// # Errors
    /// [`SnapshotError::WrongLength`] or [`SnapshotError::NotASnapshot`].
    pub fn seal(snapshot: &mut [u8]) -> Result<(), Error> {
        let mut header = SnapshotHeader::read(snapshot)?;
        let (head, content) = snapshot.split_at_mut(SnapshotHeader::BYTES);
        header.content_hash = hash(content, 0);
        head.copy_from_slice(&header.to_bytes());
        Ok(())
    }

    /// Goes back (or forward) to a snapshot that this world, or one with the same capacities and assets, has saved.
    /// A copy for each section, and a look at what of the caches still holds.
    ///
    /// Checks version, capacities, assets and length, and trusts the rest: bytes that no `save` wrote may make
    /// later calls panic. For bytes from elsewhere there is [`World::load`].
    ///
    /// # Errors
    /// A [`SnapshotError`]; the world is unchanged.
    pub fn restore(&mut self, snapshot: &[u8]) -> Result<(), Error> {
        let header = self.check_header(snapshot)?;
        let done = self.keep_caches(snapshot, &header);
        self.copy_in(snapshot, &header, &done);
        Ok(())
    }

    /// Checks a snapshot's header and length, and gives the state header in it.
    pub(super) fn check_header(&self, snapshot: &[u8]) -> Result<Header, SnapshotError> {
        let header = SnapshotHeader::read(snapshot)?;
        self.accepts(&header)?;
        let first = SnapshotHeader::BYTES;
        let state: Header = match snapshot.get(first..first + size_of::<Header>()) {
            Some(bytes) => bytemuck::pod_read_unaligned(bytes),
            None => return Err(wrong_length(first + size_of::<Header>(), snapshot)),
        };
        let c = &self.capacities;
        let marks = [
            (state.bodies.high, c.bodies),
            (state.shapes.high, c.shapes),
            (state.pairs, c.pairs),
            (state.contacts, c.contacts),
            (state.asleep_pairs, c.pairs),
            (state.asleep_contacts, c.contacts),
            (state.joints.high, c.joints),
            (state.materials, c.materials),
            (state.pair_rules, c.pair_rules),
            (state.events, c.events),
            (state.visits, c.sensor_visits),
        ];
        if marks.iter().any(|(mark, capacity)| mark > capacity) {
            return Err(SnapshotError::Invalid { section: "header", index: 0 });
        }
        let needed = first + self.sections_for(&state).iter().map(|s| s.rows * s.size).sum::<usize>();
        if needed != snapshot.len() || header.length != needed as u64 {
            return Err(wrong_length(needed, snapshot));
        }
        Ok(state)
    }

    /// Copies the sections of a checked snapshot into the state, but for what is done; rows above the new marks
    /// become zero.
    pub(super) fn copy_in(&mut self, snapshot: &[u8], header: &Header, done: &Done) {
        let before = self.sections();
        let after = self.sections_for(header);
        let mut rest = &snapshot[SnapshotHeader::BYTES..];
        let state = self.state_mut();
        for (old, new) in before.iter().zip(&after) {
            let (own, next) = rest.split_at(new.rows * new.size);
            rest = next;
            let section = &mut state[new.offset..];
            let done = done.of(new);
            section[done..own.len()].copy_from_slice(&own[done..]);
            if old.rows > new.rows {
                section[own.len()..old.rows * old.size].fill(0);
            }
        }
    }
}

/// Byte range of each section of a snapshot with these sections.
pub(super) fn parts<'a>(snapshot: &'a [u8], sections: &[Section; SECTIONS]) -> [&'a [u8]; SECTIONS] {
    let mut rest = &snapshot[SnapshotHeader::BYTES..];
    sections.map(|section| {
        let (own, after) = rest.split_at(section.rows * section.size);
        rest = after;
        own
    })
}

fn wrong_length(needed: usize, snapshot: &[u8]) -> SnapshotError {
    SnapshotError::WrongLength { needed, given: snapshot.len() }
}

/// Refuses a snapshot whose content does not match its hash; 0 stands for no hash.
pub(super) fn check_content(snapshot: &[u8]) -> Result<(), SnapshotError> {
    let header = SnapshotHeader::read(snapshot)?;
    let content = &snapshot[SnapshotHeader::BYTES..];
    if header.content_hash != 0 && header.content_hash != hash(content, 0) {
        return Err(SnapshotError::Damaged);
    }
    Ok(())
}
