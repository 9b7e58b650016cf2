//! Decides whether a schedule is valid, from the definition and in linear time.
//!
//! It shares no code with the builders: it never looks at how a schedule was made.

use super::{Block, IMMOVABLE, Link, PHASES_MAX, Schedule};

/// Why a schedule is not valid. Every variant is a bug of the scheduler, except [`Self::BodyOutOfRange`] and
/// [`Self::ScratchTooSmall`], which are the caller's.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum ScheduleError {
    /// The scratch has fewer than [`check_words`] words: pass more.
    ScratchTooSmall,
    /// The schedule's slices are shorter than its counts: `order` than the links, or `blocks` than `block_count`.
    TooShort,
    /// An end of this link is neither a body nor a permitted [`IMMOVABLE`]: correct the link.
    BodyOutOfRange {
        /// The link.
        link: u32,
    },
    /// `order` names a link that does not exist.
    LinkOutOfRange {
        /// The place in `order`.
        place: u32,
    },
    /// A link is in `order` twice, so that another is missing.
    LinkTwice {
        /// The link.
        link: u32,
    },
    /// This block is empty, or does not start where the one before it ends.
    Gap {
        /// The block.
        block: u32,
    },
    /// The blocks end before or behind the last link.
    WrongTotal,
    /// The phase of this block is neither that of the block before it nor the next one, or it is too large.
    PhaseOutOfOrder {
        /// The block.
        block: u32,
    },
    /// A body is in two blocks of one phase.
    Conflict {
        /// The body.
        body: u32,
        /// The later of the two blocks.
        block: u32,
    },
}

impl core::fmt::Display for ScheduleError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::ScratchTooSmall => write!(f, "the scratch is too small"),
            Self::TooShort => write!(f, "the schedule's slices are too short"),
            Self::BodyOutOfRange { link } => write!(f, "an end of link {link} is not a body"),
            Self::LinkOutOfRange { place } => write!(f, "place {place} of the order names no link"),
            Self::LinkTwice { link } => write!(f, "link {link} is scheduled twice"),
            Self::Gap { block } => write!(f, "block {block} is empty or does not follow the one before it"),
            Self::WrongTotal => write!(f, "the blocks do not cover the links"),
            Self::PhaseOutOfOrder { block } => write!(f, "the phase of block {block} is out of order"),
            Self::Conflict { body, block } => {
                write!(f, "body {body} of block {block} is in another block of the phase")
            }
        }
    }
}

impl core::error::Error for ScheduleError {}

/// Words of scratch that [`check`] needs; never more than [`scratch_words`](super::scratch_words).
pub const fn check_words(bodies: usize, links: usize) -> usize {
    2 * bodies + links
}

/// Whether `schedule` is a valid schedule of `links` among `bodies` bodies, as [`Schedule`] defines it.
///
/// # Errors
/// The first violation found: ends of links, then `order`, then blocks, then conflicts, each in ascending order.
pub fn check(
    bodies: u32,
    links: &[Link],
    schedule: &Schedule<'_>,
    scratch: &mut [u32],
) -> Result<(), ScheduleError> {
    if scratch.len() < check_words(bodies as usize, links.len()) {
        return Err(ScheduleError::ScratchTooSmall);
    }
    if schedule.order.len() < links.len() || schedule.blocks.len() < schedule.block_count {
        return Err(ScheduleError::TooShort);
    }
    let order = &schedule.order[..links.len()];
    let blocks = &schedule.blocks[..schedule.block_count];
    let (seen, rest) = scratch.split_at_mut(links.len());
    let (last, _) = rest.split_at_mut(2 * bodies as usize);
    check_ends(bodies, links)?;
    check_permutation(order, seen)?;
    check_blocks(blocks, links.len())?;
    check_conflicts(links, order, blocks, bytemuck::cast_slice_mut(last))
}

/// Every end of a link is a body; only `b` may be immovable.
fn check_ends(bodies: u32, links: &[Link]) -> Result<(), ScheduleError> {
    for (index, link) in links.iter().enumerate() {
        if link.a >= bodies || (link.b >= bodies && link.b != IMMOVABLE) {
            return Err(ScheduleError::BodyOutOfRange { link: index as u32 });
        }
    }
    Ok(())
}

/// Every link is in the order once.
fn check_permutation(order: &[u32], seen: &mut [u32]) -> Result<(), ScheduleError> {
    seen.fill(0);
    for (place, &link) in order.iter().enumerate() {
        let Some(seen) = seen.get_mut(link as usize) else {
            return Err(ScheduleError::LinkOutOfRange { place: place as u32 });
        };
        if *seen != 0 {
            return Err(ScheduleError::LinkTwice { link });
        }
        *seen = 1;
    }
    Ok(())
}

/// The blocks tile the order; phases ascend from 0 without gaps.
fn check_blocks(blocks: &[Block], links: usize) -> Result<(), ScheduleError> {
    let mut end = 0_u64;
    let mut next_phase = 0;
    for (index, block) in blocks.iter().enumerate() {
        let at = index as u32;
        if block.count == 0 || u64::from(block.first) != end {
            return Err(ScheduleError::Gap { block: at });
        }
        if block.phase == next_phase && (next_phase as usize) < PHASES_MAX {
            next_phase += 1;
        } else if u64::from(block.phase) + 1 != u64::from(next_phase) {
            return Err(ScheduleError::PhaseOutOfOrder { block: at });
        }
        end += u64::from(block.count);
        if end > links as u64 {
            return Err(ScheduleError::WrongTotal);
        }
    }
    if end == links as u64 { Ok(()) } else { Err(ScheduleError::WrongTotal) }
}

/// No body is in two blocks of a phase. `last` holds per body the last block that touched it and that block's
/// phase, both from 1.
fn check_conflicts(
    links: &[Link],
    order: &[u32],
    blocks: &[Block],
    last: &mut [[u32; 2]],
) -> Result<(), ScheduleError> {
    last.fill([0, 0]);
    for (index, block) in blocks.iter().enumerate() {
        let here = [index as u32 + 1, block.phase + 1];
        for &link in &order[block.first as usize..][..block.count as usize] {
            let link = &links[link as usize];
            for body in [link.a, link.b] {
                if body == IMMOVABLE {
                    continue;
                }
                let last = &mut last[body as usize];
                if last[1] == here[1] && last[0] != here[0] {
                    return Err(ScheduleError::Conflict { body, block: index as u32 });
                }
                *last = here;
            }
        }
    }
    Ok(())
}
