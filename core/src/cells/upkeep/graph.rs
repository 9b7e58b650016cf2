//! The links as lists by body and phase, and the blocks that they make: all that is derived from links and
//! phases.
//!
//! Every body has a list of half links per phase, doubly linked, so that a link comes and goes at constant cost
//! even at a body with a hundred thousand of them, and a walk through one phase never meets the links of another.
//! A half link is `2 * link + side`. Links and blocks have ids of their own, which stay as long as the link or
//! block does; ids and the order within a list are accidents of history and must never decide anything.

use super::super::{BLOCK_LINKS_MIN, CELLULAR_PHASES_MAX, HUB_FACTOR, IMMOVABLE, Link, words};
use super::Upkeep;
use bytemuck::{Pod, Zeroable};

/// No link, half link, or block.
pub(super) const NONE: u32 = u32::MAX;
/// The number of phases.
pub(super) const PHASES: usize = CELLULAR_PHASES_MAX;
/// Bodies with more links than this may be hubs, whatever g is: the limit for the least g of small scenes.
pub(super) const HEAVY: u32 = HUB_FACTOR * BLOCK_LINKS_MIN as u32;

/// A body's place in the ordering: two lines of 64 bytes, the first of which is what walks read.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(super) struct BodyNode {
    /// Its block in each phase, or [`NONE`].
    pub block: [u32; PHASES],
    /// The first half link of its list in each phase, or [`NONE`].
    pub head: [u32; PHASES],
    /// How many links it has in each phase.
    pub count: [u32; PHASES],
    /// How many links it has.
    pub degree: u32,
    /// How many of them go to other dynamic bodies.
    pub dynamic: u32,
    /// The part of its phase-0 block's dirt that it brought.
    pub dirt: u32,
    /// Stamp of the walk that last met it.
    pub mark: u32,
    /// Up to whole lines.
    pub padding: [u32; 4],
}

impl BodyNode {
    /// A body without links.
    pub const EMPTY: Self = Self {
        block: [NONE; PHASES],
        head: [NONE; PHASES],
        count: [0; PHASES],
        degree: 0,
        dynamic: 0,
        dirt: 0,
        mark: 0,
        padding: [0; 4],
    };
}

/// A link.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub(super) struct LinkNode {
    /// Its bodies; the second may be [`IMMOVABLE`].
    pub end: [u32; 2],
    /// The next half link in the list of either body.
    pub next: [u32; 2],
    /// The previous one.
    pub previous: [u32; 2],
    /// Its phase, or [`NONE`].
    pub phase: u32,
    /// Its index in the list of the step.
    pub index: u32,
}

/// A block: a connected component of the links of a phase.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub(super) struct BlockNode {
    /// Its links; the next free block while it is free.
    pub size: u32,
    /// The dirt of its bodies. Only blocks of phase 0 have any.
    pub dirt: u32,
    /// Stamp of the walk that last met it.
    pub mark: u32,
    /// Its place in the list of that walk.
    pub slot: u32,
}

/// Counts.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(super) struct Header {
    /// Capacities that the memory was made for.
    pub capacities: [u32; 2],
    /// Links of the last update.
    pub link_count: u32,
    /// Link ids that were ever used.
    pub link_high: u32,
    /// First free link id below.
    pub link_free: u32,
    /// Block ids that were ever used.
    pub block_high: u32,
    /// First free block id below.
    pub block_free: u32,
    /// Bodies with links to other dynamic bodies.
    pub dynamic_bodies: u32,
    /// Links between dynamic bodies.
    pub dynamic_links: u32,
    /// Bodies with more than [`HEAVY`] links.
    pub heavy: u32,
    /// The last stamp.
    pub stamp: u32,
    /// Links of each phase.
    pub phase_links: [u32; PHASES],
    /// Up to whole lines.
    pub padding: [u32; 13],
}

pub(super) const HEADER_WORDS: usize = words::<Header>();
pub(super) const BODY_WORDS: usize = words::<BodyNode>();
pub(super) const LINK_WORDS: usize = words::<LinkNode>() + words::<BlockNode>() + 1;

impl<'a> Upkeep<'a> {
    /// Carves the memory.
    pub(super) fn carve(bodies: usize, links: usize, words_of_cache: &'a mut [u32]) -> Self {
        let (header, rest) = words_of_cache.split_at_mut(HEADER_WORDS);
        let (body_nodes, rest) = rest.split_at_mut(bodies * words::<BodyNode>());
        let (link_nodes, rest) = rest.split_at_mut(links * words::<LinkNode>());
        let (blocks, rest) = rest.split_at_mut(links * words::<BlockNode>());
        Self {
            header: &mut bytemuck::cast_slice_mut::<u32, Header>(header)[0],
            bodies: bytemuck::cast_slice_mut(body_nodes),
            links: bytemuck::cast_slice_mut(link_nodes),
            blocks: bytemuck::cast_slice_mut(blocks),
            ids: &mut rest[..links],
        }
    }

    /// Forgets everything. Linear in the capacity for bodies.
    pub(super) fn clear(&mut self) {
        *self.header =
            Header { capacities: self.capacities(), link_free: NONE, block_free: NONE, ..Header::zeroed() };
        self.bodies.fill(BodyNode::EMPTY);
    }

    /// The capacities of this memory.
    pub(super) fn capacities(&self) -> [u32; 2] {
        [self.bodies.len() as u32, self.ids.len() as u32]
    }

    /// A stamp that no body or block has, nor the one after it.
    pub(super) fn next_stamp(&mut self) -> u32 {
        if self.header.stamp > u32::MAX - 8 {
            self.bodies.iter_mut().for_each(|body| body.mark = 0);
            self.blocks.iter_mut().for_each(|block| block.mark = 0);
            self.header.stamp = 0;
        }
        self.header.stamp += 2;
        self.header.stamp
    }

    /// Takes in a link without phase; returns its id.
    pub(super) fn admit(&mut self, link: &Link, index: u32) -> u32 {
        let id = match self.header.link_free {
            NONE => {
                self.header.link_high += 1;
                self.header.link_high - 1
            }
            free => {
                self.header.link_free = self.links[free as usize].next[0];
                free
            }
        };
        let far = if link.b == link.a { IMMOVABLE } else { link.b };
        let none = [NONE; 2];
        self.links[id as usize] =
            LinkNode { end: [link.a, far], next: none, previous: none, phase: NONE, index };
        let dynamic = u32::from(far != IMMOVABLE);
        self.header.dynamic_links += dynamic;
        for body in bodies_of([link.a, far]) {
            let census = &mut self.bodies[body as usize];
            census.degree += 1;
            self.header.heavy += u32::from(census.degree == HEAVY + 1);
            self.header.dynamic_bodies += u32::from(dynamic != 0 && census.dynamic == 0);
            census.dynamic += dynamic;
        }
        id
    }

    /// Forgets a link that is in no list.
    pub(super) fn dismiss(&mut self, id: u32) {
        let end = self.links[id as usize].end;
        self.links[id as usize].next[0] = self.header.link_free;
        self.header.link_free = id;
        let dynamic = u32::from(end[1] != IMMOVABLE);
        self.header.dynamic_links -= dynamic;
        for body in bodies_of(end) {
            let census = &mut self.bodies[body as usize];
            self.header.heavy -= u32::from(census.degree == HEAVY + 1);
            census.degree -= 1;
            census.dynamic -= dynamic;
            self.header.dynamic_bodies -= u32::from(dynamic != 0 && census.dynamic == 0);
        }
    }

    /// Puts a link into the lists of a phase; blocks are not touched.
    pub(super) fn list(&mut self, id: u32, phase: usize) {
        let end = self.links[id as usize].end;
        for (side, body) in end.into_iter().enumerate() {
            if body == IMMOVABLE {
                continue;
            }
            let half = 2 * id + side as u32;
            let first = core::mem::replace(&mut self.bodies[body as usize].head[phase], half);
            if first != NONE {
                self.links[first as usize / 2].previous[first as usize % 2] = half;
            }
            let link = &mut self.links[id as usize];
            link.next[side] = first;
            link.previous[side] = NONE;
            self.bodies[body as usize].count[phase] += 1;
        }
        self.links[id as usize].phase = phase as u32;
        self.header.phase_links[phase] += 1;
    }

    /// Takes a link out of the lists of its phase; blocks are not touched.
    pub(super) fn unlist(&mut self, id: u32) {
        let link = self.links[id as usize];
        let phase = link.phase as usize;
        for side in 0..2 {
            let body = link.end[side];
            if body == IMMOVABLE {
                continue;
            }
            let (next, previous) = (link.next[side], link.previous[side]);
            if next != NONE {
                self.links[next as usize / 2].previous[next as usize % 2] = previous;
            }
            if previous == NONE {
                self.bodies[body as usize].head[phase] = next;
            } else {
                self.links[previous as usize / 2].next[previous as usize % 2] = next;
            }
            self.bodies[body as usize].count[phase] -= 1;
        }
        self.links[id as usize].phase = NONE;
        self.header.phase_links[phase] -= 1;
    }

    /// The body at the other end of a half link, and the half link that follows it.
    pub(super) fn across(&self, half: u32) -> (u32, u32) {
        let link = &self.links[half as usize / 2];
        (link.end[1 - half as usize % 2], link.next[half as usize % 2])
    }

    /// The half links of a body in a phase, in no defined order.
    pub(super) fn halves(&self, body: u32, phase: usize) -> impl Iterator<Item = u32> {
        let mut half = self.bodies[body as usize].head[phase];
        core::iter::from_fn(move || {
            let this = half;
            (this != NONE).then(|| {
                half = self.across(this).1;
                this
            })
        })
    }

    /// A new block without links.
    pub(super) fn new_block(&mut self) -> u32 {
        let block = match self.header.block_free {
            NONE => {
                self.header.block_high += 1;
                self.header.block_high - 1
            }
            free => {
                self.header.block_free = self.blocks[free as usize].size;
                free
            }
        };
        self.blocks[block as usize] = BlockNode::default();
        block
    }

    /// Gives a block back that no body is in.
    pub(super) fn free_block(&mut self, block: u32) {
        self.blocks[block as usize].size = self.header.block_free;
        self.header.block_free = block;
    }
}

/// The ends that are bodies.
pub(super) fn bodies_of(end: [u32; 2]) -> impl Iterator<Item = u32> {
    end.into_iter().filter(|&body| body != IMMOVABLE)
}
