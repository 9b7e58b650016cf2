//! The last step of a phase: its blocks by length, their links by kind.
//!
//! Eight blocks share the lanes of one task, so blocks next to each other should be equally long, and the
//! links at equal places of neighbouring blocks of one kind.

use super::{Block, Link, Schedule};

/// Lays out the blocks from `first_block` on: sorts them by (descending length, build order) and writes their
/// links, which `grown` holds in build order, by (kind, build order) into the schedule. `keys` has a place per
/// link.
pub(super) fn lay_out(
    links: &[Link],
    grown: &[u32],
    schedule: &mut Schedule<'_>,
    first_block: usize,
    keys: &mut [[u32; 2]],
) {
    let blocks = &mut schedule.blocks[first_block..schedule.block_count];
    // The links of a phase are contiguous in build order, so the phase starts where its first block does.
    let mut to = blocks.first().map_or(0, |block| block.first);
    blocks.sort_unstable_by_key(length_key);
    for block in blocks {
        let range = block.first as usize..(block.first + block.count) as usize;
        let order = &mut schedule.order[to as usize..][..block.count as usize];
        write_by_kind(links, &grown[range], order, keys);
        block.first = to;
        to += block.count;
    }
}

/// Unique key of the order of blocks in a phase.
fn length_key(block: &Block) -> u64 {
    u64::from(u32::MAX - block.count) << 32 | u64::from(block.first)
}

/// Copies the links of a block, sorted by kind; equal kinds keep their order.
fn write_by_kind(links: &[Link], grown: &[u32], order: &mut [u32], keys: &mut [[u32; 2]]) {
    let keys = &mut keys[..grown.len()];
    for (place, (key, &link)) in keys.iter_mut().zip(grown).enumerate() {
        *key = [links[link as usize].kind, place as u32];
    }
    keys.sort_unstable_by_key(|key| u64::from(key[0]) << 32 | u64::from(key[1]));
    for (to, key) in order.iter_mut().zip(&*keys) {
        *to = grown[key[1] as usize];
    }
}
