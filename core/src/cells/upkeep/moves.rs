//! Where a link goes when it begins, and how it improves later: the first phase with room, then local moves.
//!
//! A link has room in a phase where the block that it would join or make stays within the cap. Bodies that the
//! step's changes touch take two kinds of moves, both of which can only raise the number of links in low phases:
//! a link is *promoted* to a lower phase that has room by now, and a body *migrates* to the phase-0 block in
//! which it has more links than in its own.

use super::super::{IMMOVABLE, UNCAPPED, cap};
use super::Work;
use super::graph::{NONE, PHASES};

/// Bodies with more links take no local moves: their links move when the bodies at the other ends do.
pub(super) const DEGREE_MAX: usize = 32;

/// The links of a body that moves, by index.
pub(super) type Links = heapless::Vec<u32, DEGREE_MAX>;

/// A phase-0 block that a body could migrate to.
#[derive(Clone, Copy)]
struct Target {
    block: u32,
    /// Links of the body to the block.
    links: u32,
    /// The lowest body at the other end of those links.
    body: u32,
}

impl Work<'_, '_> {
    /// Puts a link without phase where it belongs.
    pub fn begin(&mut self, id: u32) {
        if !self.claim(id) {
            self.settle(id);
        }
    }

    /// Puts a link without phase into the first phase with room.
    pub fn settle(&mut self, id: u32) {
        let end = self.graph.links[id as usize].end;
        let phase = (0..PHASES).find(|&phase| self.has_room(end, phase));
        self.place(id, phase.unwrap_or(PHASES - 1));
    }

    /// Whether a link between two bodies may join a phase.
    fn has_room(&self, end: [u32; 2], phase: usize) -> bool {
        let cap = cap(phase as u32, self.g);
        if cap == UNCAPPED {
            return true;
        }
        if self.graph.header.heavy > 0
            && let Some(room) = self.star_room(end, phase)
        {
            return room;
        }
        let block_a = self.graph.bodies[end[0] as usize].block[phase];
        let block_b = match end[1] {
            IMMOVABLE => block_a,
            body => self.graph.bodies[body as usize].block[phase],
        };
        if block_a == block_b {
            // Inside a block a link costs length but no conflict.
            self.size(block_a) < cap.saturating_add(self.g / 4)
        } else {
            self.size(block_a) + self.size(block_b) < cap
        }
    }

    /// Links of a block; none is none.
    pub fn size(&self, block: u32) -> u32 {
        if block == NONE { 0 } else { self.graph.blocks[block as usize].size }
    }

    /// The links of a body in some phases, by index. Of a body with at most [`DEGREE_MAX`] links.
    pub fn links_of(&self, body: u32, phases: core::ops::Range<usize>) -> Links {
        let mut keys: heapless::Vec<u64, DEGREE_MAX> = heapless::Vec::new();
        for &head in &self.graph.bodies[body as usize].head[phases] {
            let mut half = head;
            while half != NONE {
                let link = &self.graph.links[half as usize / 2];
                // As many links as places at most, hence there is one.
                let _ = keys.push(u64::from(link.index) << 32 | u64::from(half / 2));
                half = link.next[half as usize % 2];
            }
        }
        keys.sort_unstable();
        keys.iter().map(|&key| key as u32).collect()
    }

    /// The local moves of a body.
    pub fn improve(&mut self, body: u32) {
        let degree = self.graph.bodies[body as usize].degree;
        if degree > DEGREE_MAX as u32 || self.graph.bodies[body as usize].count[0] == degree {
            return;
        }
        for id in self.links_of(body, 1..PHASES) {
            self.promote(id);
        }
        if self.graph.header.heavy == 0 || !self.is_in_star(body, 0) {
            self.migrate(body);
        }
    }

    /// Moves a link to the lowest phase below its own that has room.
    fn promote(&mut self, id: u32) {
        if self.graph.links[id as usize].phase == 0 || self.claim(id) {
            return;
        }
        let node = self.graph.links[id as usize];
        let phase = (0..node.phase as usize).find(|&phase| self.has_room(node.end, phase));
        if let Some(phase) = phase {
            self.take_out(id);
            self.place(id, phase);
            self.moves += 1;
        }
    }

    /// Moves a body to the phase-0 block in which it has more links than in its own, if there is one with room.
    fn migrate(&mut self, body: u32) {
        let others = self.links_of(body, 1..PHASES);
        let Some(target) = self.target(body, &others) else { return };
        let own = self.links_of(body, 0..1);
        for &id in &own {
            self.take_out(id);
        }
        for &id in &others {
            let end = self.graph.links[id as usize].end;
            let other = end[usize::from(end[0] == body)];
            if other != IMMOVABLE && self.graph.bodies[other as usize].block[0] == target.block {
                self.take_out(id);
                self.place(id, 0);
            }
        }
        for &id in &own {
            self.settle(id);
        }
        self.moves += 1;
    }

    /// The best block for a body to migrate to: the most links, then the lowest neighbour. `others` are its links
    /// above phase 0.
    fn target(&self, body: u32, others: &Links) -> Option<Target> {
        let node = &self.graph.bodies[body as usize];
        let mut targets: heapless::Vec<Target, DEGREE_MAX> = heapless::Vec::new();
        for &id in others {
            let end = self.graph.links[id as usize].end;
            let other = end[usize::from(end[0] == body)];
            if other == IMMOVABLE {
                continue;
            }
            let block = self.graph.bodies[other as usize].block[0];
            if block == NONE || block == node.block[0] {
                continue;
            }
            if let Some(target) = targets.iter_mut().find(|target| target.block == block) {
                target.links += 1;
                target.body = target.body.min(other);
            } else {
                // As many targets as links at most, hence there is a place.
                let _ = targets.push(Target { block, links: 1, body: other });
            }
        }
        let census = self.graph.bodies[body as usize];
        let most = targets.iter().map(|target| target.links).max()?;
        if most + (census.degree - census.dynamic) <= node.count[0] {
            return None;
        }
        let fixed = self.graph.halves(body, 0).filter(|&half| self.graph.across(half).0 == IMMOVABLE);
        let fixed = fixed.count() as u32;
        targets
            .into_iter()
            .filter(|target| target.links + fixed > node.count[0])
            .filter(|target| self.size(target.block) + target.links + fixed <= self.g)
            .filter(|target| self.graph.header.heavy == 0 || !self.is_in_star(target.body, 0))
            .max_by_key(|target| (target.links, u32::MAX - target.body))
    }
}
