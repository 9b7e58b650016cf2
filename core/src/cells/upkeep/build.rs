//! Blocks from phases alone, and phases from a fresh build.

use super::super::{Block, Cellular, IMMOVABLE, Link, Schedule, Scheduler, scratch_words};
use super::graph::{BodyNode, NONE, PHASES, bodies_of};
use super::{Change, NEW, Upkeep};

/// Memory of a fresh build.
pub(super) struct Bulk<'s> {
    /// The order of the links; a place per link.
    pub order: &'s mut [u32],
    /// The links by places of bodies; a place per link.
    pub local: &'s mut [Link],
    /// The blocks; a place per link.
    pub blocks: &'s mut [Block],
    /// The place of each body among those with links; valid for those.
    pub slots: &'s mut [u32],
    /// A bit per body.
    pub bits: &'s mut [u32],
    /// Memory of the builder, [`scratch_words`] of it.
    pub words: &'s mut [u32],
}

impl Upkeep<'_> {
    /// Builds the graph of the links that have a phase, and lists the others; returns how many these are.
    pub(super) fn rebuild(&mut self, change: &Change<'_>, phases: &[u8], begins: &mut [u32]) -> usize {
        self.clear();
        let mut begun = 0;
        for (index, link) in change.links.iter().enumerate() {
            self.ids[index] = NONE;
            if change.from[index] == NEW {
                begins[begun] = index as u32;
                begun += 1;
            } else {
                let id = self.admit(link, index as u32);
                self.list(id, usize::from(phases[index]));
                self.ids[index] = id;
            }
        }
        self.header.link_count = change.links.len() as u32;
        begun
    }

    /// Finds the blocks of all links that have one, from the lists alone. `queue` has a place per body.
    pub(super) fn label(&mut self, dirt: &[u8], queue: &mut [u32]) {
        for at in 0..self.header.link_count as usize {
            let id = self.ids[at];
            if id == NONE {
                continue;
            }
            let node = &self.links[id as usize];
            let (start, phase) = (node.end[0], node.phase as usize);
            if self.bodies[start as usize].block[phase] == NONE {
                self.label_block(start, phase, dirt, queue);
            }
        }
    }

    /// Finds the block of a body in a phase.
    fn label_block(&mut self, start: u32, phase: usize, dirt: &[u8], queue: &mut [u32]) {
        let block = self.new_block();
        queue[0] = start;
        self.bodies[start as usize].block[phase] = block;
        let (mut at, mut found, mut ends, mut fixed) = (0, 1, 0, 0);
        let mut dirt_sum = 0;
        while at < found {
            let body = queue[at] as usize;
            at += 1;
            if phase == 0 {
                self.bodies[body].dirt = u32::from(dirt[body]);
                dirt_sum += u32::from(dirt[body]);
            }
            let mut half = self.bodies[body].head[phase];
            while half != NONE {
                let (other, next) = self.across(half);
                half = next;
                if other == IMMOVABLE {
                    fixed += 1;
                    continue;
                }
                ends += 1;
                let label = &mut self.bodies[other as usize].block[phase];
                if *label == NONE {
                    *label = block;
                    queue[found] = other;
                    found += 1;
                }
            }
        }
        let node = &mut self.blocks[block as usize];
        node.size = ends / 2 + fixed;
        node.dirt = dirt_sum;
    }

    /// Gives every link the phase of a fresh build, and takes the dirt off its bodies. All links have ids.
    pub(super) fn build(
        &mut self,
        links: &[Link],
        block_links: u32,
        (phases, dirt): (&mut [u8], &mut [u8]),
        bulk: &mut Bulk<'_>,
    ) {
        let bodies = localise(links, bulk);
        let order = &mut bulk.order[..links.len()];
        let mut schedule = Schedule { order, blocks: bulk.blocks, block_count: 0 };
        let words = &mut bulk.words[..scratch_words(bodies, links.len())];
        Cellular { block_links }.schedule(bodies as u32, &bulk.local[..links.len()], words, &mut schedule);
        for link in links {
            for body in bodies_of([link.a, link.b]) {
                let node = &mut self.bodies[body as usize];
                let BodyNode { degree, dynamic, mark, .. } = *node;
                *node = BodyNode { degree, dynamic, mark, ..BodyNode::EMPTY };
                dirt[body as usize] = 0;
            }
        }
        self.header.block_high = 0;
        self.header.block_free = NONE;
        self.header.phase_links = [0; PHASES];
        for block in &schedule.blocks[..schedule.block_count] {
            for &index in &schedule.order[block.first as usize..][..block.count as usize] {
                phases[index as usize] = block.phase as u8;
            }
        }
        for (index, &phase) in phases[..links.len()].iter().enumerate() {
            self.list(self.ids[index], usize::from(phase));
        }
        self.label(dirt, bulk.slots);
    }
}

/// Writes the links by places of bodies, which ascend with the bodies; returns the number of bodies with links.
fn localise(links: &[Link], bulk: &mut Bulk<'_>) -> usize {
    bulk.bits.fill(0);
    for link in links {
        for body in bodies_of([link.a, link.b]) {
            bulk.bits[body as usize / 32] |= 1 << (body % 32);
        }
    }
    let mut count = 0;
    for (at, &word) in bulk.bits.iter().enumerate() {
        let mut left = word;
        while left != 0 {
            bulk.slots[32 * at + left.trailing_zeros() as usize] = count;
            count += 1;
            left &= left - 1;
        }
    }
    for (local, link) in bulk.local.iter_mut().zip(links) {
        let b = if link.b == IMMOVABLE { IMMOVABLE } else { bulk.slots[link.b as usize] };
        *local = Link { a: bulk.slots[link.a as usize], b, kind: 0 };
    }
    count as usize
}
