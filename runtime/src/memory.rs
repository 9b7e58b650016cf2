//! A world's memory from the heap, of which only what is used takes room.
//!
//! A world has room for its worst step, most of which no scene ever fills. The system hands out zeroed memory
//! page by page as it is first touched, but only where the allocator passes the wish on: for the alignment of a
//! [`Line`], Rust's allocator zeroes all of it by hand. So the memory is taken as plain bytes, one line too many,
//! and the lines begin at the first border inside.

use cellstep_core::Line;
use std::fmt;

/// Bytes of a line.
const LINE: usize = size_of::<Line>();

/// [`Line`]s that are zero until they are written. What was never written takes no room in the machine's memory,
/// as far as the system gives zeroed memory lazily (Linux, macOS and Windows do).
///
/// ```
/// use cellstep::{Capacities, Memory, World};
///
/// let capacities = Capacities::for_bodies(1000);
/// let memory = Memory::zeroed(capacities.lines()).expect("the system has some megabytes");
/// let world = World::new(memory, capacities)?;
/// # Ok::<(), cellstep::Error>(())
/// ```
pub struct Memory {
    /// `lines` lines, and what lies before the first border of one and after the last. Never resized: it must
    /// not move.
    bytes: Vec<u8>,
    lines: usize,
}

impl Memory {
    /// `lines` lines of zeros; `None` when the system refuses.
    pub fn zeroed(lines: usize) -> Option<Self> {
        let size = lines.checked_mul(LINE)?.checked_add(LINE - 1)?;
        let bytes = bytemuck::allocation::try_zeroed_vec(size).ok()?;
        Some(Memory { bytes, lines })
    }
}

impl AsRef<[Line]> for Memory {
    #[inline]
    fn as_ref(&self) -> &[Line] {
        let (_, lines, _) = bytemuck::pod_align_to(&self.bytes);
        &lines[..self.lines]
    }
}

impl AsMut<[Line]> for Memory {
    #[inline]
    fn as_mut(&mut self) -> &mut [Line] {
        let (_, lines, _) = bytemuck::pod_align_to_mut(&mut self.bytes);
        &mut lines[..self.lines]
    }
}

impl fmt::Debug for Memory {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.debug_struct("Memory").field("lines", &self.lines).finish_non_exhaustive()
    }
}

#[cfg(all(test, not(loom)))]
mod tests {
    use super::*;

    #[test]
    fn all_lines_are_there_zero_and_kept() {
        for count in [0, 1, 2, 63, 64, 1000] {
            // Several at once, so that the allocator gives different alignments.
            let mut several: Vec<Memory> =
                (0..5).map(|_| Memory::zeroed(count).expect("some kilobytes")).collect();
            for memory in &mut several {
                assert_eq!(memory.as_ref().len(), count);
                assert!(memory.as_ref().iter().all(|line| line.0 == [0; LINE]));
                memory.as_mut().fill(Line([7; LINE]));
            }
            let moved = several;
            for memory in &moved {
                assert_eq!(memory.as_ref().len(), count);
                assert!(memory.as_ref().iter().all(|line| line.0 == [7; LINE]));
            }
        }
    }

    #[test]
    fn too_much_is_refused() {
        assert!(Memory::zeroed(usize::MAX).is_none());
        assert!(Memory::zeroed(usize::MAX / LINE).is_none());
        assert!(Memory::zeroed(isize::MAX as usize / LINE).is_none());
    }
}
