//! The contact graph as lists of neighbours: for each body a contiguous range of entries, one per link that
//! is not yet in a block.
//!
//! Entries of a body ascend by (neighbour, link), so that what grows from them does not depend on the order of the
//! links. [`Graph::thin`] drops assigned links in place at the end of a phase: ranges shrink where they are.

use super::{IMMOVABLE, Link};

/// What the ordering knows about a body.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, bytemuck::Pod, bytemuck::Zeroable)]
pub(super) struct Node {
    /// First of its entries.
    pub first: u32,
    /// How many links it has left: the length of its range of entries.
    pub degree: u32,
    /// How many of those go to [`IMMOVABLE`].
    pub fixed: u32,
    /// Stamp of the block that last took it; stamps ascend, 0 is none.
    pub owner: u32,
    /// Stamp of the block that last reached it.
    pub reached: u32,
    /// Its place in the frontier of the block that last reached it, or `u32::MAX` once refused there.
    pub place: u32,
}

/// One end of a link, as seen from the body at the other end.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, bytemuck::Pod, bytemuck::Zeroable)]
pub(super) struct Entry {
    /// The neighbour, or [`IMMOVABLE`].
    pub other: u32,
    /// Index of the link.
    pub link: u32,
}

impl Entry {
    /// Unique key of the order of a body's entries.
    fn key(self) -> u64 {
        u64::from(self.other) << 32 | u64::from(self.link)
    }
}

/// The bodies with links left, and those links.
pub(super) struct Graph<'a> {
    /// One per body.
    pub nodes: &'a mut [Node],
    /// The ranges of all bodies, in ascending order of bodies.
    pub entries: &'a mut [Entry],
    /// Bodies with links left, ascending, in the first `active_count` places.
    active: &'a mut [u32],
    active_count: usize,
}

impl<'a> Graph<'a> {
    /// Builds the graph of `links` in memory of any content: a node and an active place per body, two entries per
    /// link. A link of a body to itself counts as one to [`IMMOVABLE`].
    pub fn build(
        links: &[Link],
        nodes: &'a mut [Node],
        entries: &'a mut [Entry],
        active: &'a mut [u32],
    ) -> Self {
        nodes.fill(Node::default());
        for link in links {
            nodes[link.a as usize].degree += 1;
            match far_end(link) {
                IMMOVABLE => nodes[link.a as usize].fixed += 1,
                b => nodes[b as usize].degree += 1,
            }
        }
        let mut graph = Self { nodes, entries, active, active_count: 0 };
        graph.place_ranges();
        graph.fill(links);
        graph.sort_ranges();
        graph
    }

    /// Bodies with links left, ascending.
    pub fn active(&self) -> &[u32] {
        &self.active[..self.active_count]
    }

    /// The number of bodies with links to dynamic bodies, and of ends of such links.
    pub fn dynamic_ends(&self) -> (u64, u64) {
        let mut sums = (0, 0);
        for &body in self.active() {
            let node = &self.nodes[body as usize];
            sums.0 += u64::from(node.degree > node.fixed);
            sums.1 += u64::from(node.degree - node.fixed);
        }
        sums
    }

    /// Drops the links whose bit in `assigned` is set, and the bodies that have none left.
    pub fn thin(&mut self, assigned: &[u32]) {
        let mut kept_bodies = 0;
        for at in 0..self.active_count {
            let body = self.active[at];
            let node = &mut self.nodes[body as usize];
            let range = &mut self.entries[node.first as usize..][..node.degree as usize];
            let (mut kept, mut fixed) = (0, 0);
            for from in 0..range.len() {
                let entry = range[from];
                if !is_set(assigned, entry.link) {
                    range[kept] = entry;
                    kept += 1;
                    fixed += u32::from(entry.other == IMMOVABLE);
                }
            }
            node.degree = kept as u32;
            node.fixed = fixed;
            if kept > 0 {
                self.active[kept_bodies] = body;
                kept_bodies += 1;
            }
        }
        self.active_count = kept_bodies;
    }

    /// Gives each body its range, and lists the active bodies. `place` becomes the write position of
    /// [`Self::fill`].
    fn place_ranges(&mut self) {
        let mut first = 0;
        for (body, node) in self.nodes.iter_mut().enumerate() {
            node.first = first;
            node.place = first;
            first += node.degree;
            if node.degree > 0 {
                self.active[self.active_count] = body as u32;
                self.active_count += 1;
            }
        }
    }

    /// Writes the entries, those of a body in ascending order of links.
    fn fill(&mut self, links: &[Link]) {
        for (index, link) in links.iter().enumerate() {
            let other = far_end(link);
            self.push(link.a, Entry { other, link: index as u32 });
            if other != IMMOVABLE {
                self.push(other, Entry { other: link.a, link: index as u32 });
            }
        }
    }

    /// Appends an entry to the range of a body.
    fn push(&mut self, body: u32, entry: Entry) {
        let place = &mut self.nodes[body as usize].place;
        self.entries[*place as usize] = entry;
        *place += 1;
    }

    /// Sorts each range. Links that come sorted by (low body, high body) give sorted ranges: then this only looks.
    fn sort_ranges(&mut self) {
        for node in self.nodes.iter() {
            let range = &mut self.entries[node.first as usize..][..node.degree as usize];
            if !range.is_sorted_by_key(|entry| entry.key()) {
                range.sort_unstable_by_key(|entry| entry.key());
            }
        }
    }
}

/// The body that a link makes a conflict with besides `a`, or [`IMMOVABLE`].
fn far_end(link: &Link) -> u32 {
    if link.b == link.a { IMMOVABLE } else { link.b }
}

/// Whether a bit is set.
fn is_set(bits: &[u32], index: u32) -> bool {
    bits[index as usize / 32] >> (index % 32) & 1 != 0
}

/// Sets a bit.
pub(super) fn set(bits: &mut [u32], index: u32) {
    bits[index as usize / 32] |= 1 << (index % 32);
}
