//! Seats: the solver's copies of a body, one in each phase that has the body.
//!
//! A body lives in the block that is working on it. When a block starts, it *pulls* each of its seats from the
//! seat that had the body last. The seats of a phase are contiguous by group, so a task owns its own by
//! `split_at_mut` and reads those of the other phases shared: no gather over the world, no false sharing.

use crate::lanes::Words;
use bytemuck::{Pod, Zeroable};

/// A body's velocity and motion while it is solved. Two rows of 32 bytes.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(crate) struct Seat {
    /// `[v, inverse mass, w~, locks]`: m/s, 1/kg, whitened angular velocity, locked axes as x + 2 y + 4 z.
    pub velocity: Words,
    /// `[dx, 0, turn~, 0]`: motion in this substep, metres and whitened rotation vector.
    pub moved: Words,
}

/// The seat keeps what it has: no other phase has the body.
pub(crate) const OWN: u32 = u32::MAX;

/// The seats of all phases but one, whose seats start at `first` and end before `end`.
#[derive(Clone, Copy)]
pub(crate) struct OtherSeats<'a> {
    pub before: &'a [Seat],
    pub after: &'a [Seat],
    /// Index of the first seat of `after`.
    pub end: usize,
}

impl OtherSeats<'_> {
    /// Copies to every seat with a source what the source has.
    pub fn pull(&self, seats: &mut [Seat], sources: &[u32]) {
        for (seat, &source) in seats.iter_mut().zip(sources) {
            if source != OWN {
                let source = source as usize;
                *seat = if source < self.end { self.before[source] } else { self.after[source - self.end] };
            }
        }
    }
}
