//! The schedule of an ordering: blocks by phase, then descending length, then lowest link; links of a block by
//! (kind, index).

use super::super::{Block, Link, Schedule};
use super::Upkeep;
use super::graph::{NONE, PHASES};

/// Words of scratch per link.
pub(super) const LINK_WORDS: usize = 6;

/// A block on its way into the schedule.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, bytemuck::Pod, bytemuck::Zeroable)]
struct Entry {
    /// Its phase, in the upper half its length from above: the order of blocks.
    key: [u32; 2],
    /// Its place by lowest link.
    rank: u32,
}

impl Upkeep<'_> {
    /// Writes the schedule of the links of the last update: blocks by phase, then descending length, then lowest
    /// link index; links of a block by (`kind`, index). Phases without links are passed over. `scratch` has
    /// [`upkeep_scratch_words`](super::upkeep_scratch_words).
    pub fn schedule(&self, links: &[Link], scratch: &mut [u32], schedule: &mut Schedule<'_>) {
        let count = links.len();
        assert!(self.header.link_count as usize == count, "these are not the links of the last update");
        assert!(schedule.order.len() >= count, "the schedule's order is too short");
        assert!(schedule.blocks.len() >= count, "the schedule has too few blocks");
        let (ranks, rest) = scratch.split_at_mut(count);
        let (spare, rest) = rest.split_at_mut(count);
        let (map, rest) = rest.split_at_mut(self.header.block_high as usize);
        let entries: &mut [Entry] = bytemuck::cast_slice_mut(&mut rest[..3 * count]);
        let blocks = self.rank_blocks(ranks, map, entries);
        let entries = &mut entries[..blocks];
        entries.sort_unstable_by_key(|e| (u64::from(e.key[0]) << 32 | u64::from(e.key[1]), e.rank));
        let places = &mut map[..blocks];
        let (mut first, mut phase, mut original) = (0, 0, entries.first().map_or(0, |e| e.key[0]));
        for (entry, block) in entries.iter().zip(&mut *schedule.blocks) {
            phase += u32::from(entry.key[0] != original);
            original = entry.key[0];
            let count = u32::MAX - entry.key[1];
            *block = Block { phase, first, count };
            places[entry.rank as usize] = first;
            first += count;
        }
        schedule.block_count = blocks;
        let order = &mut schedule.order[..count];
        let sorted = sort_by_kind(links, spare, order);
        if sorted {
            for &link in &*spare {
                let place = &mut places[ranks[link as usize] as usize];
                order[*place as usize] = link;
                *place += 1;
            }
        } else {
            for (link, &rank) in ranks.iter().enumerate() {
                let place = &mut places[rank as usize];
                order[*place as usize] = link as u32;
                *place += 1;
            }
        }
    }

    /// Ranks the blocks by lowest link: for each link the rank of its block, and the blocks by rank. Returns how
    /// many they are.
    fn rank_blocks(&self, ranks: &mut [u32], map: &mut [u32], entries: &mut [Entry]) -> usize {
        map.fill(NONE);
        let mut blocks = 0;
        for (rank, &id) in ranks.iter_mut().zip(&*self.ids) {
            let node = &self.links[id as usize];
            let phase = node.phase as usize % PHASES;
            let block = self.bodies[node.end[0] as usize].block[phase] as usize;
            if map[block] == NONE {
                map[block] = blocks;
                let length = self.blocks[block].size;
                entries[blocks as usize] = Entry { key: [phase as u32, u32::MAX - length], rank: blocks };
                blocks += 1;
            }
            *rank = map[block];
        }
        blocks as usize
    }
}

/// Sorts the indices of the links by (kind, index) into `sorted`, one pass for each byte in which kinds differ;
/// `spare` is as long. Returns false, with nothing written, when all kinds are the same.
fn sort_by_kind(links: &[Link], sorted: &mut [u32], spare: &mut [u32]) -> bool {
    let first = links.first().map_or(0, |link| link.kind);
    let differing = links.iter().fold(0, |bits, link| bits | (link.kind ^ first));
    if differing == 0 {
        return false;
    }
    sorted.iter_mut().enumerate().for_each(|(at, link)| *link = at as u32);
    for shift in [0, 8, 16, 24] {
        if differing >> shift & 0xff == 0 {
            continue;
        }
        let digit = |link: u32| (links[link as usize].kind >> shift & 0xff) as usize;
        let mut places = [0_u32; 256];
        sorted.iter().for_each(|&link| places[digit(link)] += 1);
        let mut sum = 0;
        for place in &mut places {
            sum += core::mem::replace(place, sum);
        }
        for &link in &*sorted {
            let place = &mut places[digit(link)];
            spare[*place as usize] = link;
            *place += 1;
        }
        sorted.copy_from_slice(spare);
    }
    true
}
