//! What a snapshot starts with: enough to say on any machine why it does not fit, before its rows are looked at.

use super::super::checksum::hash;
use super::super::{Capacities, World};
use super::sections_of;
use crate::arena::Line;
use crate::config::BEHAVIOUR_VERSION;
use crate::error::SnapshotError;
use crate::pool::Marks;
use crate::state::{Header, StateLayout};
use bytemuck::{Pod, Zeroable};
use core::mem::size_of;

/// The first bytes of a snapshot.
const MAGIC: [u8; 8] = *b"CELLSTEP";

/// The header as bytes. Little-endian, as everything in a snapshot.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct HeaderRow {
    magic: [u8; 8],
    version: u32,
    /// Zero.
    reserved: u32,
    layout: u64,
    assets: u64,
    content: u64,
    length: u64,
}

/// What a snapshot says of itself.
///
/// A world takes a snapshot whose version, layout hash and assets hash are its own, whatever machine wrote it:
/// the bytes after the header are the same on all little-endian machines.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SnapshotHeader {
    /// [`BEHAVIOUR_VERSION`] of the writer.
    pub version: u32,
    /// [`Capacities::layout_hash`] of the writer.
    pub layout_hash: u64,
    /// [`World::assets_hash`] of the writer.
    pub assets_hash: u64,
    /// XXH64 of everything after the header; 0 until [`World::seal`].
    pub content_hash: u64,
    /// Bytes of the snapshot, the header included.
    pub length: u64,
}

impl SnapshotHeader {
    /// Bytes of a header.
    pub const BYTES: usize = size_of::<HeaderRow>();

    /// Reads the header of a snapshot.
    ///
    /// # Errors
    /// [`SnapshotError::WrongLength`] for less than [`SnapshotHeader::BYTES`] bytes, and
    /// [`SnapshotError::NotASnapshot`].
    pub fn read(snapshot: &[u8]) -> Result<Self, SnapshotError> {
        let Some(bytes) = snapshot.get(..Self::BYTES) else {
            return Err(SnapshotError::WrongLength { needed: Self::BYTES, given: snapshot.len() });
        };
        let row: HeaderRow = bytemuck::pod_read_unaligned(bytes);
        if row.magic != MAGIC || row.reserved != 0 {
            return Err(SnapshotError::NotASnapshot);
        }
        Ok(Self {
            version: row.version,
            layout_hash: row.layout,
            assets_hash: row.assets,
            content_hash: row.content,
            length: row.length,
        })
    }

    /// XXH64 of everything after the header of a snapshot: what [`World::seal`] writes into it.
    ///
    /// # Errors
    /// Those of [`SnapshotHeader::read`].
    pub fn content_hash_of(snapshot: &[u8]) -> Result<u64, SnapshotError> {
        Self::read(snapshot)?;
        Ok(hash(&snapshot[Self::BYTES..], 0))
    }

    pub(in super::super) fn to_bytes(self) -> [u8; Self::BYTES] {
        bytemuck::cast(HeaderRow {
            magic: MAGIC,
            version: self.version,
            reserved: 0,
            layout: self.layout_hash,
            assets: self.assets_hash,
            content: self.content_hash,
            length: self.length,
        })
    }
}

impl Capacities {
    /// Hash of what decides how the bytes of a state are read: the capacities and the sizes of the rows. Equal on
    /// all machines.
    pub fn layout_hash(&self) -> u64 {
        let state = [
            self.bodies,
            self.shapes,
            self.pairs,
            self.contacts,
            self.joints,
            self.materials,
            self.pair_rules,
            self.events,
            self.sensor_visits,
        ];
        let assets = [
            self.hulls,
            self.meshes,
            self.mesh_vertices,
            self.mesh_triangles,
            self.height_fields,
            self.height_samples,
            self.compounds,
            self.compound_children,
            self.surfaces,
        ];
        let counts = hash(bytemuck::bytes_of(&assets), hash(bytemuck::bytes_of(&state), 0));
        let sections = sections_of(&StateLayout::new(self), &Header::zeroed());
        sections.iter().fold(counts, |sum, section| hash(&(section.size as u64).to_le_bytes(), sum))
    }

    /// Bytes of the largest snapshot of a world with these capacities.
    pub fn snapshot_bytes_max(&self) -> usize {
        let full = |high| Marks { high, ..Marks::default() };
        let header = Header {
            bodies: full(self.bodies),
            shapes: full(self.shapes),
            joints: full(self.joints),
            pairs: self.pairs,
            contacts: self.contacts,
            asleep_pairs: self.pairs,
            asleep_contacts: self.contacts,
            materials: self.materials,
            pair_rules: self.pair_rules,
            events: self.events,
            visits: self.sensor_visits,
            ..Header::zeroed()
        };
        let sections = sections_of(&StateLayout::new(self), &header);
        SnapshotHeader::BYTES + sections.iter().map(|s| s.rows * s.size).sum::<usize>()
    }
}

impl<M: AsRef<[Line]> + AsMut<[Line]>> World<M> {
    /// [`Capacities::layout_hash`] of this world: worlds that exchange snapshots have the same.
    pub fn layout_hash(&self) -> u64 {
        self.layout_hash
    }

    /// Whether this world takes snapshots with such a header.
    ///
    /// # Errors
    /// [`SnapshotError::Version`], [`SnapshotError::Capacities`] or [`SnapshotError::Assets`]: the first of them
    /// that differs.
    pub fn accepts(&self, header: &SnapshotHeader) -> Result<(), SnapshotError> {
        if header.version != BEHAVIOUR_VERSION {
            return Err(SnapshotError::Version { found: header.version });
        }
        if header.layout_hash != self.layout_hash() {
            return Err(SnapshotError::Capacities);
        }
        if header.assets_hash != self.assets_hash() {
            return Err(SnapshotError::Assets);
        }
        Ok(())
    }

    pub(super) fn snapshot_header(&self, length: usize) -> SnapshotHeader {
        SnapshotHeader {
            version: BEHAVIOUR_VERSION,
            layout_hash: self.layout_hash(),
            assets_hash: self.assets_hash(),
            content_hash: 0,
            length: length as u64,
        }
    }
}
