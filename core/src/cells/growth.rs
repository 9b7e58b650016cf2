//! Growth of blocks: from a seed by the largest share of links inside, and stars of hubs.
//!
//! The frontier lists the bodies that a block has reached, in the order it reached them; a body that was taken
//! or refused leaves a hole (gain 0). It is scanned whole for each body taken: it has a few dozen places. Nothing
//! is cleared between blocks, since every block has its own stamp and an older stamp means "not here".
//!
//! Invariants: a body has one owner per phase; links leave the graph only at the end of a phase, so that during a
//! phase all links of a body without owner are still to be assigned.

use super::adjacency::{Graph, set};
use super::{Block, IMMOVABLE, Schedule};

/// The cap of a block that takes all it can reach.
pub(super) const UNCAPPED: u32 = u32::MAX;
/// Most places of a capped block's frontier; then it reaches no more bodies. Piles, walls and lattices
/// stay below 150 places at g = 64 and below 320 at 256. It bounds the scans where everything touches everything.
const FRONTIER_MAX: usize = 1024;
/// `Node::place` of a body that was refused.
const REFUSED: u32 = u32::MAX;

/// A body that the block has reached.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, bytemuck::Pod, bytemuck::Zeroable)]
pub(super) struct Reached {
    /// Links that would come along: those to bodies of the block and to immovable ones. 0 marks a hole.
    gain: u32,
    /// Links it has left.
    degree: u32,
    /// The body.
    body: u32,
}

/// Blocks growing in a graph.
pub(super) struct Growth<'a> {
    /// The links left at the start of the phase.
    pub graph: Graph<'a>,
    /// Links in the order in which blocks took them; `grown_count` of them are valid.
    pub grown: &'a mut [u32],
    /// How many links are in blocks.
    pub grown_count: usize,
    frontier: &'a mut [Reached],
    frontier_count: usize,
    assigned: &'a mut [u32],
    stamp: u32,
    phase: u32,
    phase_stamp: u32,
}

impl<'a> Growth<'a> {
    /// Nothing grown yet. A frontier place per body, a place in `grown` and a zero bit in `assigned` per link.
    pub fn new(
        graph: Graph<'a>,
        frontier: &'a mut [Reached],
        grown: &'a mut [u32],
        assigned: &'a mut [u32],
    ) -> Self {
        Self {
            graph,
            grown,
            grown_count: 0,
            frontier,
            frontier_count: 0,
            assigned,
            stamp: 0,
            phase: 0,
            phase_stamp: 1,
        }
    }

    /// From here on no body has an owner.
    pub fn begin_phase(&mut self, phase: u32) {
        self.phase = phase;
        self.phase_stamp = self.stamp + 1;
    }

    /// Takes the links that are in blocks out of the graph.
    pub fn end_phase(&mut self) {
        self.graph.thin(self.assigned);
    }

    /// Makes a block of the star of each body with more than `limit` links left, by ascending id.
    pub fn stars(&mut self, limit: u32, schedule: &mut Schedule<'_>) {
        for at in 0..self.graph.active().len() {
            let body = self.graph.active()[at];
            if self.graph.nodes[body as usize].degree > limit {
                self.star(body, limit, schedule);
            }
        }
    }

    /// Grows a block from each body without owner, by ascending id.
    pub fn blocks(&mut self, cap: u32, schedule: &mut Schedule<'_>) {
        for at in 0..self.graph.active().len() {
            let body = self.graph.active()[at];
            if self.is_free(body) {
                self.grow(body, cap, schedule);
            }
        }
    }

    /// The star of a hub: its links to immovable bodies and to those bodies without owner that are no hubs
    /// themselves, so that every hub gets a star. Links between the outer bodies are left to later phases, which
    /// can solve them in parallel.
    pub fn star(&mut self, hub: u32, limit: u32, schedule: &mut Schedule<'_>) {
        let first = self.next_stamp();
        let node = self.graph.nodes[hub as usize];
        for at in node.first..node.first + node.degree {
            let entry = self.graph.entries[at as usize];
            if entry.other == IMMOVABLE {
                self.assign(entry.link);
                continue;
            }
            let other = &mut self.graph.nodes[entry.other as usize];
            let free = other.owner < self.phase_stamp && other.degree <= limit;
            if free || other.owner == self.stamp {
                other.owner = self.stamp;
                self.assign(entry.link);
            }
        }
        if self.grown_count > first {
            self.graph.nodes[hub as usize].owner = self.stamp;
        }
        self.close(first, schedule);
    }

    /// Grows one block of at most `cap` links from `seed`; only the first body to bring links may exceed it.
    /// Without cap the order of taking does not matter, and bodies are taken breadth-first.
    pub fn grow(&mut self, seed: u32, cap: u32, schedule: &mut Schedule<'_>) {
        let first = self.next_stamp();
        let places = if cap == UNCAPPED { usize::MAX } else { FRONTIER_MAX };
        self.frontier_count = 0;
        self.enter(seed, places);
        let mut turn = 0;
        loop {
            let best = if cap == UNCAPPED { turn } else { self.best() };
            turn += 1;
            if best >= self.frontier_count {
                break;
            }
            let Reached { gain, body, .. } = self.frontier[best];
            self.frontier[best].gain = 0;
            let count = (self.grown_count - first) as u32;
            if count == 0 || gain <= cap.saturating_sub(count) {
                self.enter(body, places);
            } else {
                // Its gain can only rise and the room only shrink: it is refused for good.
                self.graph.nodes[body as usize].place = REFUSED;
            }
        }
        self.close(first, schedule);
    }

    /// Whether no block of this phase has taken the body.
    fn is_free(&self, body: u32) -> bool {
        self.graph.nodes[body as usize].owner < self.phase_stamp
    }

    /// Starts a block; returns where its links start.
    fn next_stamp(&mut self) -> usize {
        self.stamp += 1;
        self.grown_count
    }

    /// Adds the block to the schedule unless it is empty.
    fn close(&mut self, first: usize, schedule: &mut Schedule<'_>) {
        let count = (self.grown_count - first) as u32;
        if count > 0 {
            schedule.blocks[schedule.block_count] = Block { phase: self.phase, first: first as u32, count };
            schedule.block_count += 1;
        }
    }

    /// Puts a link into the block.
    fn assign(&mut self, link: u32) {
        self.grown[self.grown_count] = link;
        self.grown_count += 1;
        set(self.assigned, link);
    }

    /// Takes a body into the block with its links to the block and to immovable bodies, and reaches its neighbours.
    fn enter(&mut self, body: u32, places: usize) {
        let node = &mut self.graph.nodes[body as usize];
        node.owner = self.stamp;
        for at in node.first..node.first + node.degree {
            let entry = self.graph.entries[at as usize];
            if entry.other == IMMOVABLE {
                self.assign(entry.link);
                continue;
            }
            let owner = self.graph.nodes[entry.other as usize].owner;
            if owner == self.stamp {
                self.assign(entry.link);
            } else if owner < self.phase_stamp {
                self.reach(entry.other, places);
            }
        }
    }

    /// Notes one more link from the block to a body without owner.
    fn reach(&mut self, body: u32, places: usize) {
        let node = &mut self.graph.nodes[body as usize];
        if node.reached == self.stamp {
            if let Some(reached) = self.frontier.get_mut(node.place as usize) {
                reached.gain += 1;
            }
        } else if self.frontier_count < places {
            node.reached = self.stamp;
            node.place = self.frontier_count as u32;
            self.frontier[self.frontier_count] = Reached { gain: node.fixed + 1, degree: node.degree, body };
            self.frontier_count += 1;
        }
    }

    /// The place with the largest gain / degree, the first of equals; the frontier's length if it is all holes.
    fn best(&self) -> usize {
        let frontier = &self.frontier[..self.frontier_count];
        let (mut best, mut gain, mut degree) = (frontier.len(), 0, 1);
        for (place, reached) in frontier.iter().enumerate() {
            // gain / degree compared without rounding.
            if u64::from(reached.gain) * degree > gain * u64::from(reached.degree) {
                best = place;
                gain = u64::from(reached.gain);
                degree = u64::from(reached.degree);
            }
        }
        best
    }
}
