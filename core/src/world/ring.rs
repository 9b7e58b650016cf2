//! The last snapshots of a world, in memory that was handed over: what a game that predicts goes back to.
//!
//! ```text
//! slot:  | mark: step, bytes | snapshot, up to the largest that the capacities allow |
//! ring:  slot 0 | slot 1 | .. | slot n - 1       oldest at `first`, then round
//! ```
//! Saving is a copy for each section of the state, and so is going back. Nothing is allocated.

use super::{Capacities, World};
use crate::arena::{LINE, Line};
use crate::error::{Error, SnapshotError};
use bytemuck::{Pod, Zeroable};
use core::mem::size_of;

/// What a slot starts with.
#[repr(C, align(64))]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct Mark {
    step: u64,
    /// Bytes of the snapshot.
    bytes: u64,
    reserved: [u64; 6],
}

const _: () = assert!(size_of::<Mark>() == LINE);

/// Snapshots of the last steps at which it was told to save.
///
/// ```
/// use cellstep_core::{Capacities, Line, Serial, SnapshotRing, World};
///
/// let capacities = Capacities::for_bodies(1);
/// let mut world = World::new(vec![Line::ZERO; capacities.lines()], capacities)?;
/// let memory = vec![Line::ZERO; SnapshotRing::<Vec<Line>>::lines(&capacities, 8)];
/// let mut ring = SnapshotRing::new(memory, &capacities, 8)?;
/// for _ in 0..20 {
///     ring.save(&world)?;
///     world.step(&mut Serial);
/// }
/// ring.restore(&mut world, 13)?;
/// assert_eq!(world.steps(), 13);
/// assert!(ring.restore(&mut world, 11).is_err(), "12 is the oldest of the last eight");
/// # Ok::<(), cellstep_core::Error>(())
/// ```
#[derive(Debug)]
pub struct SnapshotRing<M> {
    memory: M,
    layout_hash: u64,
    depth: usize,
    slot_lines: usize,
    /// Slot of the oldest snapshot.
    first: usize,
    /// Snapshots that are kept.
    count: usize,
}

impl<M: AsRef<[Line]> + AsMut<[Line]>> SnapshotRing<M> {
    /// Lines of memory for `depth` snapshots of a world with these capacities.
    pub fn lines(capacities: &Capacities, depth: usize) -> usize {
        depth.saturating_mul(slot_lines(capacities))
    }

    /// An empty ring. What is in the memory does not matter.
    ///
    /// # Errors
    /// [`Error::CapacityOutOfRange`] for bad capacities and for a depth of 0 (`depth`), or
    /// [`Error::MemoryTooSmall`].
    pub fn new(memory: M, capacities: &Capacities, depth: usize) -> Result<Self, Error> {
        capacities.check()?;
        if depth == 0 {
            return Err(Error::CapacityOutOfRange { name: "depth" });
        }
        let (needed, given) = (Self::lines(capacities, depth), memory.as_ref().len());
        if given < needed {
            return Err(Error::MemoryTooSmall { needed, given });
        }
        let (layout_hash, slot_lines) = (capacities.layout_hash(), slot_lines(capacities));
        Ok(Self { memory, layout_hash, depth, slot_lines, first: 0, count: 0 })
    }

    /// How many snapshots there is room for.
    pub fn depth(&self) -> usize {
        self.depth
    }

    /// Steps of the snapshots that are kept, ascending.
    pub fn steps(&self) -> impl DoubleEndedIterator<Item = u64> + '_ {
        (0..self.count).map(|place| self.mark(place).step)
    }

    /// Saves the world at its step, in the place of the oldest snapshot if the ring is full. Snapshots of this step
    /// and of later ones are forgotten: they are of another future.
    ///
    /// # Errors
    /// [`SnapshotError::Capacities`] for a world with other capacities; the ring is unchanged.
    pub fn save<W>(&mut self, world: &World<W>) -> Result<(), Error>
    where
        W: AsRef<[Line]> + AsMut<[Line]>,
    {
        self.check(world)?;
        let step = world.steps();
        self.forget_from(step);
        if self.count == self.depth {
            self.first = (self.first + 1) % self.depth;
            self.count -= 1;
        }
        let slot = self.slot(self.count);
        let (mark, rest) = self.memory.as_mut()[slot..slot + self.slot_lines].split_at_mut(1);
        let bytes = world.save(bytemuck::cast_slice_mut(rest))? as u64;
        mark[0] = bytemuck::cast(Mark { step, bytes, reserved: [0; 6] });
        self.count += 1;
        Ok(())
    }

    /// Goes back to the snapshot of a step. Later ones stay until other ones are saved.
    ///
    /// # Errors
    /// [`SnapshotError::NotKept`], [`SnapshotError::Capacities`] or [`SnapshotError::Assets`]; the world is
    /// unchanged.
    pub fn restore<W>(&self, world: &mut World<W>, step: u64) -> Result<(), Error>
    where
        W: AsRef<[Line]> + AsMut<[Line]>,
    {
        self.check(world)?;
        world.restore(self.get(step)?)
    }

    /// The snapshot of a step, as [`World::save`] wrote it.
    ///
    /// # Errors
    /// [`SnapshotError::NotKept`].
    pub fn get(&self, step: u64) -> Result<&[u8], SnapshotError> {
        let newest_first = (0..self.count).rev();
        let mut marks = newest_first.map(|place| (place, self.mark(place)));
        let Some((place, mark)) = marks.find(|(_, mark)| mark.step == step) else {
            return Err(SnapshotError::NotKept { step });
        };
        let start = self.slot(place) + 1;
        let lines = &self.memory.as_ref()[start..start + self.slot_lines - 1];
        Ok(&bytemuck::cast_slice(lines)[..mark.bytes as usize])
    }

    /// Forgets all snapshots.
    pub fn clear(&mut self) {
        self.count = 0;
    }

    /// The memory back.
    pub fn into_memory(self) -> M {
        self.memory
    }

    fn check<W>(&self, world: &World<W>) -> Result<(), SnapshotError>
    where
        W: AsRef<[Line]> + AsMut<[Line]>,
    {
        if world.layout_hash() == self.layout_hash { Ok(()) } else { Err(SnapshotError::Capacities) }
    }

    fn forget_from(&mut self, step: u64) {
        while self.count > 0 && self.mark(self.count - 1).step >= step {
            self.count -= 1;
        }
    }

    /// First line of a slot; `place` counts from the oldest snapshot.
    fn slot(&self, place: usize) -> usize {
        (self.first + place) % self.depth * self.slot_lines
    }

    fn mark(&self, place: usize) -> Mark {
        bytemuck::cast(self.memory.as_ref()[self.slot(place)])
    }
}

/// Lines of a slot.
fn slot_lines(capacities: &Capacities) -> usize {
    1 + capacities.snapshot_bytes_max().div_ceil(LINE)
}
