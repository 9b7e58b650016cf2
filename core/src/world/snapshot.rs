//! Snapshots: a header and one copy per section, up to its high-water mark.

use super::World;
use super::checksum::hash;
use crate::arena::{LINE, Line};
use crate::config::BEHAVIOUR_VERSION;
use crate::error::{Error, SnapshotError};
use crate::pool::words;
use crate::state::Header;
use bytemuck::{Pod, Zeroable};
use core::mem::size_of;

/// The first bytes of a snapshot.
const MAGIC: [u8; 8] = *b"CELLSTEP";

/// What a snapshot starts with. Little-endian, as everything in it.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(super) struct SnapshotHeader {
    magic: [u8; 8],
    version: u32,
    reserved: u32,
    /// Hash of the capacities and of the rows' sizes.
    layout: u64,
    /// Hash of the registered assets.
    assets: u64,
    /// Hash of everything after this header.
    content: u64,
    /// Bytes of the snapshot, this header included.
    length: u64,
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
pub(super) const SECTIONS: usize = 25;

const _: () = assert!(cfg!(target_endian = "little"), "the state's bytes are little-endian");

impl<M: AsRef<[Line]> + AsMut<[Line]>> World<M> {
    /// The sections of the state, for the marks of a header.
    pub(super) fn sections_for(&self, header: &Header) -> [Section; SECTIONS] {
        let s = &self.layout.state;
        let (bodies, shapes) = (header.bodies.high as usize, header.shapes.high as usize);
        let joints = header.joints.high as usize;
        macro_rules! section {
            ($name:ident, $type:ty, $rows:expr) => {
                Section {
                    name: stringify!($name),
                    offset: s.$name.offset,
                    size: size_of::<$type>(),
                    rows: $rows,
                }
            };
        }
        [
            section!(header, Header, 1),
            section!(motions, crate::body::Motion, bodies),
            section!(bodies, crate::body::BodyRow, bodies),
            section!(body_generations, u32, bodies),
            section!(body_used, u64, words(bodies)),
            section!(shapes, crate::shape::ShapeRow, shapes),
            section!(shape_generations, u32, shapes),
            section!(shape_used, u64, words(shapes)),
            section!(pairs, crate::state::Pair, header.pairs as usize),
            section!(contacts, crate::state::ContactRow, header.contacts as usize),
            section!(asleep_pairs, crate::state::Pair, header.asleep_pairs as usize),
            section!(asleep_contacts, crate::state::ContactRow, header.asleep_contacts as usize),
            section!(ordering, crate::cells::OrderingRow, 1),
            section!(dirt, u8, bodies),
            section!(joints, crate::joint::JointRow, joints),
            section!(joint_axes, [crate::joint::AxisRow; 6], joints),
            section!(joint_generations, u32, joints),
            section!(joint_used, u64, words(joints)),
            section!(first_joints, u32, if self.capacities.joints == 0 { 0 } else { bodies }),
            section!(materials, crate::material::MaterialRow, header.materials as usize),
            section!(pair_rules, crate::material::PairRule, header.pair_rules as usize),
            section!(events, crate::event::EventRow, header.events as usize),
            section!(tenants, crate::event::Tenant, if self.capacities.events == 0 { 0 } else { shapes }),
            section!(visits, crate::event::Visit, header.visits as usize),
            section!(news, crate::event::BodyNews, words(bodies)),
        ]
    }

    pub(super) fn sections(&self) -> [Section; SECTIONS] {
        self.sections_for(self.header())
    }

    /// Bytes of a snapshot taken now.
    pub fn snapshot_bytes(&self) -> usize {
        size_of::<SnapshotHeader>() + self.sections().iter().map(|s| s.rows * s.size).sum::<usize>()
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
        let (head, mut rest) = out.split_at_mut(size_of::<SnapshotHeader>());
        head.copy_from_slice(bytemuck::bytes_of(&self.snapshot_header(needed)));
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
        let mut header = read_header(snapshot)?;
        let (head, content) = snapshot.split_at_mut(size_of::<SnapshotHeader>());
        header.content = hash(content, 0);
        head.copy_from_slice(bytemuck::bytes_of(&header));
        Ok(())
    }

    /// Goes back (or forward) to a snapshot that this world, or one with the same capacities and assets, has saved.
    ///
    /// Checks version, capacities, assets and length, and trusts the rest: bytes that no `save` wrote may make
    /// later calls panic. For bytes from elsewhere there is [`World::load`].
    ///
    /// # Errors
    /// A [`SnapshotError`]; the world is unchanged.
    pub fn restore(&mut self, snapshot: &[u8]) -> Result<(), Error> {
        let header = self.check_header(snapshot)?;
        self.copy_in(snapshot, &header);
        Ok(())
    }

    fn snapshot_header(&self, length: usize) -> SnapshotHeader {
        SnapshotHeader {
            magic: MAGIC,
            version: BEHAVIOUR_VERSION,
            reserved: 0,
            layout: self.layout_hash(),
            assets: self.layout.assets.header.of(self.bytes())[0].hash,
            content: 0,
            length: length as u64,
        }
    }

    /// Hash of what decides how the state's bytes are read.
    fn layout_hash(&self) -> u64 {
        let c = &self.capacities;
        let state = [
            c.bodies,
            c.shapes,
            c.pairs,
            c.contacts,
            c.joints,
            c.materials,
            c.pair_rules,
            c.events,
            c.sensor_visits,
        ];
        let assets = [
            c.hulls,
            c.meshes,
            c.mesh_vertices,
            c.mesh_triangles,
            c.height_fields,
            c.height_samples,
            c.compounds,
            c.compound_children,
            c.surfaces,
        ];
        let counts = hash(bytemuck::bytes_of(&assets), hash(bytemuck::bytes_of(&state), 0));
        self.sections().iter().fold(counts, |sum, section| hash(&(section.size as u64).to_le_bytes(), sum))
    }

    /// Checks a snapshot's header and length, and gives the state header in it.
    pub(super) fn check_header(&self, snapshot: &[u8]) -> Result<Header, SnapshotError> {
        let header = read_header(snapshot)?;
        if header.version != BEHAVIOUR_VERSION {
            return Err(SnapshotError::Version { found: header.version });
        }
        let own = self.snapshot_header(0);
        if header.layout != own.layout || header.reserved != 0 {
            return Err(SnapshotError::Capacities);
        }
        if header.assets != own.assets {
            return Err(SnapshotError::Assets);
        }
        let first = size_of::<SnapshotHeader>();
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

    /// Copies the sections of a checked snapshot into the state; rows above the new marks become zero.
    pub(super) fn copy_in(&mut self, snapshot: &[u8], header: &Header) {
        let before = self.sections();
        let after = self.sections_for(header);
        let mut rest = &snapshot[size_of::<SnapshotHeader>()..];
        let state = self.state_mut();
        for (old, new) in before.iter().zip(&after) {
            let (own, next) = rest.split_at(new.rows * new.size);
            rest = next;
            let section = &mut state[new.offset..];
            section[..own.len()].copy_from_slice(own);
            if old.rows > new.rows {
                section[own.len()..old.rows * old.size].fill(0);
            }
        }
        self.drop_caches();
    }
}

/// Byte range of each section of a snapshot with these sections.
pub(super) fn parts<'a>(snapshot: &'a [u8], sections: &[Section; SECTIONS]) -> [&'a [u8]; SECTIONS] {
    let mut rest = &snapshot[size_of::<SnapshotHeader>()..];
    sections.map(|section| {
        let (own, after) = rest.split_at(section.rows * section.size);
        rest = after;
        own
    })
}

fn wrong_length(needed: usize, snapshot: &[u8]) -> SnapshotError {
    SnapshotError::WrongLength { needed, given: snapshot.len() }
}

pub(super) fn read_header(snapshot: &[u8]) -> Result<SnapshotHeader, SnapshotError> {
    let Some(bytes) = snapshot.get(..size_of::<SnapshotHeader>()) else {
        return Err(wrong_length(size_of::<SnapshotHeader>(), snapshot));
    };
    let header: SnapshotHeader = bytemuck::pod_read_unaligned(bytes);
    if header.magic == MAGIC { Ok(header) } else { Err(SnapshotError::NotASnapshot) }
}

/// Refuses a snapshot whose content does not match its hash; 0 stands for no hash.
pub(super) fn check_content(snapshot: &[u8]) -> Result<(), SnapshotError> {
    let header = read_header(snapshot)?;
    let content = &snapshot[size_of::<SnapshotHeader>()..];
    if header.content != 0 && header.content != hash(content, 0) {
        return Err(SnapshotError::Damaged);
    }
    Ok(())
}

const _: () = assert!(size_of::<SnapshotHeader>() <= LINE);
