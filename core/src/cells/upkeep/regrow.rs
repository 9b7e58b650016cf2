//! Re-growth: the phase-0 blocks of a neighbourhood, grown again from nothing, where local moves do not help.
//!
//! A region is a block and the neighbouring blocks that it shares most links with, whole, about 6 g links with
//! those between them. Its links are grown into blocks by the rule of a fresh build. If that puts more of them
//! into phase 0, the new blocks replace the old ones, and what was in phase 0 before and is not any more goes to
//! the first phase with room. No link from the region to the outside can be in phase 0, since blocks are
//! components, so the outside is not touched.

use super::super::{Block, IMMOVABLE, Link, Schedule, carve, scratch_words};
use super::Work;
use super::graph::{NONE, PHASES};
use super::moves::DEGREE_MAX;

/// Links of the blocks of a region, in g. Measured on two piles in churn: of 2, 3, 4, 6 and 9, 4 gives most for its
/// cost; a larger region changes more and gains less at its rim.
const REGION_BLOCKS: u32 = 4;

/// Memory of a re-growth.
pub(super) struct Region<'s> {
    /// The bodies of the region; a place per body.
    pub members: &'s mut [u32],
    /// The place of each body in `members`; valid for those.
    pub slots: &'s mut [u32],
    /// The links of the region, by id; a place per link.
    pub links: &'s mut [u32],
    /// The same links by places of bodies; a place per link. Before, neighbouring blocks: (block, lowest body,
    /// shared links).
    pub local: &'s mut [Link],
    /// The new blocks; a place per link.
    pub blocks: &'s mut [Block],
    /// Memory of the growth, [`scratch_words`] of it.
    pub words: &'s mut [u32],
}

impl Work<'_, '_> {
    /// Grows the region of a body's block again; returns the links that this looked at, 0 if the block is none that
    /// can be grown.
    pub fn regrow(&mut self, body: u32, region: &mut Region<'_>) -> u32 {
        let Some(bodies) = self.choose(body, region) else { return 0 };
        let members = &mut region.members[..bodies];
        members.sort_unstable();
        for (slot, &body) in members.iter().enumerate() {
            region.slots[body as usize] = slot as u32;
        }
        let stamp = self.graph.header.stamp;
        let (mut count, mut before) = (0, 0);
        for at in 0..bodies {
            let body = region.members[at];
            for phase in 0..PHASES {
                let mut half = self.graph.bodies[body as usize].head[phase];
                while half != NONE {
                    let (other, next) = self.graph.across(half);
                    let inside = other == IMMOVABLE || self.graph.bodies[other as usize].mark == stamp;
                    if inside && half.is_multiple_of(2) {
                        let far = if other == IMMOVABLE { other } else { region.slots[other as usize] };
                        region.links[count] = half / 2;
                        region.local[count] = Link { a: at as u32, b: far, kind: 0 };
                        count += 1;
                        before += usize::from(phase == 0);
                    }
                    half = next;
                }
            }
        }
        self.clean(&region.members[..bodies]);
        let local = &region.local[..count];
        let (mut growth, _) = carve(bodies, local, &mut region.words[..scratch_words(bodies, count)]);
        growth.begin_phase(0);
        let mut grown = Schedule { order: &mut [], blocks: region.blocks, block_count: 0 };
        growth.blocks(self.g, &mut grown);
        let blocks = grown.block_count;
        if growth.grown_count > before {
            let grown = &mut growth.grown[..growth.grown_count];
            for link in &mut *grown {
                *link = region.links[*link as usize];
            }
            self.replace(
                &region.members[..bodies],
                &mut region.links[..count],
                grown,
                &region.blocks[..blocks],
            );
        }
        count as u32
    }

    /// Lists the bodies of the region around a body's block and marks them with the current stamp; returns how many
    /// they are.
    fn choose(&mut self, body: u32, region: &mut Region<'_>) -> Option<usize> {
        let stamp = self.graph.next_stamp();
        let first = self.graph.bodies[body as usize].block[0];
        if first == NONE || self.size(first) > 2 * self.g {
            return None;
        }
        let core = self.gather(body, 0, region.members)?;
        let (mut count, mut neighbours) = (core, 0);
        for at in 0..core {
            let body = region.members[at];
            for phase in 1..PHASES {
                let mut half = self.graph.bodies[body as usize].head[phase];
                while half != NONE {
                    let (other, next) = self.graph.across(half);
                    half = next;
                    if other == IMMOVABLE || self.graph.bodies[other as usize].mark == stamp {
                        continue;
                    }
                    let block = self.graph.bodies[other as usize].block[0];
                    if block != NONE {
                        neighbours = self.note(block, other, region.local, neighbours);
                    } else if self.graph.bodies[other as usize].degree <= DEGREE_MAX as u32 {
                        self.graph.bodies[other as usize].mark = stamp;
                        region.members[count] = other;
                        count += 1;
                    }
                }
            }
        }
        let neighbours = &mut region.local[..neighbours];
        neighbours.sort_unstable_by_key(|entry| u64::from(u32::MAX - entry.kind) << 32 | u64::from(entry.b));
        let mut links = self.size(first);
        for entry in neighbours {
            let size = self.size(entry.a);
            if links + size <= self.g.saturating_mul(REGION_BLOCKS)
                && let Some(more) = self.gather(entry.b, count, region.members)
            {
                count = more;
                links += size;
            }
        }
        Some(count)
    }

    /// Counts one more link to a neighbouring block, through its body `body`; returns how many blocks are known.
    fn note(&mut self, block: u32, body: u32, list: &mut [Link], count: usize) -> usize {
        let stamp = self.graph.header.stamp;
        let node = &mut self.graph.blocks[block as usize];
        if node.mark == stamp {
            let entry = &mut list[node.slot as usize];
            entry.b = entry.b.min(body);
            entry.kind += 1;
            return count;
        }
        node.mark = stamp;
        node.slot = count as u32;
        list[count] = Link { a: block, b: body, kind: 1 };
        count + 1
    }

    /// Appends and marks the bodies of a body's phase-0 block; returns the new count. Refuses a block with a hub.
    fn gather(&mut self, body: u32, count: usize, members: &mut [u32]) -> Option<usize> {
        let stamp = self.graph.header.stamp;
        members[count] = body;
        self.graph.bodies[body as usize].mark = stamp;
        let (mut at, mut found, mut refused) = (count, count + 1, false);
        while at < found {
            refused |= self.graph.header.heavy > 0 && self.is_hub(members[at]);
            let mut half = self.graph.bodies[members[at] as usize].head[0];
            at += 1;
            while half != NONE {
                let (other, next) = self.graph.across(half);
                half = next;
                if other != IMMOVABLE && self.graph.bodies[other as usize].mark != stamp {
                    self.graph.bodies[other as usize].mark = stamp;
                    members[found] = other;
                    found += 1;
                }
            }
        }
        if refused {
            members[count..found].iter().for_each(|&body| self.graph.bodies[body as usize].mark = 0);
            return None;
        }
        Some(found)
    }

    /// Takes the dirt off bodies.
    fn clean(&mut self, bodies: &[u32]) {
        for &body in bodies {
            self.dirt[body as usize] = 0;
            let dirt = core::mem::take(&mut self.graph.bodies[body as usize].dirt);
            let block = self.graph.bodies[body as usize].block[0];
            if block != NONE {
                self.graph.blocks[block as usize].dirt -= dirt;
            }
        }
    }

    /// Makes `blocks` the phase-0 blocks of a region; `grown` are the ids of their links.
    fn replace(&mut self, members: &[u32], links: &mut [u32], grown: &[u32], blocks: &[Block]) {
        for &id in grown {
            if self.graph.links[id as usize].phase != 0 {
                self.take_out(id);
            }
        }
        let mut old = 0;
        for at in 0..links.len() {
            let id = links[at];
            let phase = &mut self.graph.links[id as usize].phase;
            if *phase == 0 {
                *phase = NONE;
                links[old] = id;
                old += 1;
            }
        }
        self.graph.header.phase_links[0] -= old as u32;
        let stamp = self.graph.next_stamp();
        for &body in members {
            self.graph.bodies[body as usize].head[0] = NONE;
            let node = &mut self.graph.bodies[body as usize];
            node.count[0] = 0;
            let block = core::mem::replace(&mut node.block[0], NONE);
            if block != NONE && self.graph.blocks[block as usize].mark != stamp {
                self.graph.blocks[block as usize].mark = stamp;
                self.graph.free_block(block);
            }
        }
        for block in blocks {
            for &id in &grown[block.first as usize..][..block.count as usize] {
                self.place(id, 0);
            }
        }
        let mut left = 0;
        for at in 0..old {
            if self.graph.links[links[at] as usize].phase == NONE {
                links[left] = links[at];
                left += 1;
            }
        }
        let left = &mut links[..left];
        left.sort_unstable_by_key(|&id| self.graph.links[id as usize].index);
        for &mut id in left {
            self.settle(id);
        }
    }
}
