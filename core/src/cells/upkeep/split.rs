//! Links enter and leave blocks: blocks merge when a link joins them, and part when the last link between two
//! halves leaves.
//!
//! A merge relabels the smaller block. When a link leaves and both its bodies keep links in the phase, two searches
//! start from them and take one half link each in turn; if they meet, the block is whole, and if one is exhausted,
//! what it found becomes a block of its own. So either costs no more than twice the smaller part. What a block *is*
//! does not depend on the order of any walk.

use super::super::IMMOVABLE;
use super::Work;
use super::graph::{NONE, bodies_of};

/// One of two searches.
struct Side {
    /// The half link to take next.
    half: u32,
    /// Bodies whose half links have been taken or are being taken.
    opened: usize,
    /// Bodies found.
    found: usize,
    /// Half links taken that lead to dynamic bodies.
    dynamic: u32,
    /// Half links taken that lead to immovable ones.
    fixed: u32,
}

/// What a step of a search found.
enum Step {
    Onward,
    Met,
    Exhausted,
}

impl Work<'_, '_> {
    /// Puts a link without phase into a phase, whatever its cap.
    pub fn place(&mut self, id: u32, phase: usize) {
        let [a, b] = self.graph.links[id as usize].end;
        let block_a = self.graph.bodies[a as usize].block[phase];
        let block_b = if b == IMMOVABLE { block_a } else { self.graph.bodies[b as usize].block[phase] };
        let block = match (block_a, block_b) {
            (NONE, NONE) => {
                let block = self.graph.new_block();
                self.join(a, phase, block);
                if b != IMMOVABLE {
                    self.join(b, phase, block);
                }
                block
            }
            (NONE, block) => {
                self.join(a, phase, block);
                block
            }
            (block, NONE) => {
                self.join(b, phase, block);
                block
            }
            (block, other) if block == other => block,
            _ => self.merge([a, b], phase),
        };
        self.graph.list(id, phase);
        self.graph.blocks[block as usize].size += 1;
        self.phases[self.graph.links[id as usize].index as usize] = phase as u8;
    }

    /// Takes a link out of its phase. Its phase byte stays as it is: the link ends or is placed again.
    pub fn take_out(&mut self, id: u32) {
        let node = self.graph.links[id as usize];
        let phase = node.phase as usize;
        let block = self.graph.bodies[node.end[0] as usize].block[phase];
        self.graph.unlist(id);
        let mut staying = 0;
        for body in bodies_of(node.end) {
            if self.graph.bodies[body as usize].count[phase] == 0 {
                self.leave(body, phase);
            } else {
                staying += 1;
            }
        }
        let size = &mut self.graph.blocks[block as usize].size;
        *size -= 1;
        if *size == 0 {
            self.graph.free_block(block);
        } else if staying == 2 {
            self.split(node.end, phase);
        }
    }

    /// A body without block gets one.
    fn join(&mut self, body: u32, phase: usize, block: u32) {
        self.graph.bodies[body as usize].block[phase] = block;
        if phase == 0 {
            let dirt = u32::from(self.dirt[body as usize]);
            self.graph.bodies[body as usize].dirt = dirt;
            self.graph.blocks[block as usize].dirt += dirt;
        }
    }

    /// A body without links in a phase leaves its block.
    fn leave(&mut self, body: u32, phase: usize) {
        let block = core::mem::replace(&mut self.graph.bodies[body as usize].block[phase], NONE);
        if phase == 0 {
            let dirt = core::mem::take(&mut self.graph.bodies[body as usize].dirt);
            self.graph.blocks[block as usize].dirt -= dirt;
        }
    }

    /// Makes one block of those of two bodies; returns it.
    fn merge(&mut self, ends: [u32; 2], phase: usize) -> u32 {
        let [a, b] = ends.map(|body| self.graph.bodies[body as usize].block[phase]);
        let [size_a, size_b] = [a, b].map(|block| self.graph.blocks[block as usize].size);
        let (from, to, start) = if size_a < size_b { (a, b, ends[0]) } else { (b, a, ends[1]) };
        let queue = &mut *self.queues[0];
        (queue[0], self.graph.bodies[start as usize].block[phase]) = (start, to);
        let (mut at, mut found) = (0, 1);
        while at < found {
            let mut half = self.graph.bodies[queue[at] as usize].head[phase];
            at += 1;
            while half != NONE {
                let (body, next) = self.graph.across(half);
                half = next;
                if body != IMMOVABLE && self.graph.bodies[body as usize].block[phase] == from {
                    self.graph.bodies[body as usize].block[phase] = to;
                    queue[found] = body;
                    found += 1;
                }
            }
        }
        let gone = self.graph.blocks[from as usize];
        let kept = &mut self.graph.blocks[to as usize];
        kept.size += gone.size;
        kept.dirt += gone.dirt;
        self.graph.free_block(from);
        to
    }

    /// Parts a block if no path is left between two of its bodies.
    fn split(&mut self, ends: [u32; 2], phase: usize) {
        let stamp = self.graph.next_stamp();
        let mut sides = [0, 1].map(|side| {
            let body = ends[side];
            self.queues[side][0] = body;
            self.graph.bodies[body as usize].mark = stamp + side as u32;
            let half = self.graph.bodies[body as usize].head[phase];
            Side { half, opened: 1, found: 1, dynamic: 0, fixed: 0 }
        });
        let mut turn = 0;
        loop {
            match self.search(&mut sides[turn], turn, [stamp + turn as u32, stamp + 1 - turn as u32], phase) {
                Step::Onward => turn = 1 - turn,
                Step::Met => return,
                Step::Exhausted => return self.part(&sides[turn], turn, phase),
            }
        }
    }

    /// Takes one half link on one side. `stamps` are those of this side and of the other.
    fn search(&mut self, side: &mut Side, which: usize, stamps: [u32; 2], phase: usize) -> Step {
        while side.half == NONE {
            if side.opened == side.found {
                return Step::Exhausted;
            }
            side.half = self.graph.bodies[self.queues[which][side.opened] as usize].head[phase];
            side.opened += 1;
        }
        let (body, next) = self.graph.across(side.half);
        side.half = next;
        if body == IMMOVABLE {
            side.fixed += 1;
            return Step::Onward;
        }
        side.dynamic += 1;
        let mark = &mut self.graph.bodies[body as usize].mark;
        if *mark == stamps[1] {
            return Step::Met;
        }
        if *mark != stamps[0] {
            *mark = stamps[0];
            self.queues[which][side.found] = body;
            side.found += 1;
        }
        Step::Onward
    }

    /// Makes a block of what an exhausted search found.
    fn part(&mut self, side: &Side, which: usize, phase: usize) {
        let found = &self.queues[which][..side.found];
        let old = self.graph.bodies[found[0] as usize].block[phase];
        let new = self.graph.new_block();
        let mut dirt = 0;
        for &body in found {
            self.graph.bodies[body as usize].block[phase] = new;
            dirt += self.graph.bodies[body as usize].dirt;
        }
        let dirt = if phase == 0 { dirt } else { 0 };
        let size = side.dynamic / 2 + side.fixed;
        self.graph.blocks[old as usize].size -= size;
        self.graph.blocks[old as usize].dirt -= dirt;
        self.graph.blocks[new as usize].size = size;
        self.graph.blocks[new as usize].dirt = dirt;
    }
}
