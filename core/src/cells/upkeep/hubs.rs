//! Stars: the blocks of bodies with very many links.
//!
//! A hub would fill a capped block in each of many phases. All its links to bodies that are no hubs make one block
//! without cap instead, its star: a block in which every link has the hub. Nothing else may join a star, for it
//! would lengthen it. A body that a hub touches leaves its phase-0 block for the hub's star, since its other links
//! can be solved beside each other in later phases and the hub's cannot.
//!
//! Whether a body is a hub follows from its degree, and whether a block is a star from its links, so neither is
//! remembered. While no body has more than 48 links, nothing here runs.

use super::super::IMMOVABLE;
use super::Work;
use super::graph::{HEAVY, NONE, PHASES, bodies_of};
use super::moves::DEGREE_MAX;

impl Work<'_, '_> {
    /// Whether a body is a hub: more links than four blocks hold.
    pub fn is_hub(&self, body: u32) -> bool {
        let limit = self.g.saturating_mul(super::super::HUB_FACTOR).max(HEAVY);
        self.graph.bodies[body as usize].degree > limit
    }

    /// Whether a body that is no hub has a link to one in a phase.
    pub fn is_in_star(&self, body: u32, phase: usize) -> bool {
        !self.is_hub(body)
            && self.graph.halves(body, phase).any(|half| {
                let other = self.graph.across(half).0;
                other != IMMOVABLE && self.is_hub(other)
            })
    }

    /// The hub of a link that has one, and the other end; none for a link between two hubs.
    fn hub_of(&self, end: [u32; 2]) -> Option<(u32, u32)> {
        let [a, b] = end;
        let hub_b = b != IMMOVABLE && self.is_hub(b);
        match (self.is_hub(a), hub_b) {
            (true, false) => Some((a, b)),
            (false, true) => Some((b, a)),
            _ => None,
        }
    }

    /// Whether the block of a hub in a phase is its star, or it has none.
    fn is_star(&self, hub: u32, phase: usize) -> bool {
        let node = &self.graph.bodies[hub as usize];
        node.count[phase] == self.size(node.block[phase])
    }

    /// Whether a link may join a phase, where hubs decide that.
    pub fn star_room(&self, end: [u32; 2], phase: usize) -> Option<bool> {
        if let Some((hub, other)) = self.hub_of(end) {
            let block = self.graph.bodies[hub as usize].block[phase];
            let free =
                other == IMMOVABLE || [NONE, block].contains(&self.graph.bodies[other as usize].block[phase]);
            return Some(free && self.is_star(hub, phase));
        }
        let hubs = bodies_of(end).all(|body| self.is_hub(body));
        let refused = if hubs { phase == 0 } else { bodies_of(end).any(|body| self.is_in_star(body, phase)) };
        refused.then_some(false)
    }

    /// Brings a hub's link into the hub's star of phase 0, if the link has a hub and the other body can leave its
    /// block. The link may have a phase.
    pub fn claim(&mut self, id: u32) -> bool {
        if self.graph.header.heavy == 0 {
            return false;
        }
        let Some((hub, other)) = self.hub_of(self.graph.links[id as usize].end) else { return false };
        if !self.is_star(hub, 0) {
            return false;
        }
        let star = self.graph.bodies[hub as usize].block[0];
        let mut evicted = super::moves::Links::new();
        if other != IMMOVABLE && ![NONE, star].contains(&self.graph.bodies[other as usize].block[0]) {
            let degree = self.graph.bodies[other as usize].degree;
            if degree > DEGREE_MAX as u32 || self.is_in_star(other, 0) {
                return false;
            }
            evicted = self.links_of(other, 0..1);
        }
        for &id in &evicted {
            self.take_out(id);
        }
        if self.graph.links[id as usize].phase != NONE {
            self.take_out(id);
        }
        self.place(id, 0);
        for &id in &evicted {
            self.settle(id);
        }
        self.moves += evicted.len() as u32;
        true
    }

    /// Makes a star of a hub's phase-0 block: what is not of the hub leaves, and the hub's links come. For a body
    /// that has become a hub; otherwise nothing happens. `list` has a place per link.
    pub fn purify(&mut self, hub: u32, list: &mut [u32]) {
        if self.graph.header.heavy == 0 || !self.is_hub(hub) || self.is_star(hub, 0) {
            return;
        }
        let count = self.foreign(hub, list);
        let (foreign, list) = list.split_at_mut(count);
        let key = |id: &u32| self.graph.links[*id as usize].index;
        foreign.sort_unstable_by_key(key);
        let mut count = 0;
        for phase in 1..PHASES {
            for half in self.graph.halves(hub, phase) {
                list[count] = half / 2;
                count += 1;
            }
        }
        let own = &mut list[..count];
        own.sort_unstable_by_key(key);
        for &mut id in &mut *foreign {
            self.take_out(id);
        }
        for &mut id in own {
            self.claim(id);
        }
        for &mut id in foreign {
            self.begin(id);
        }
    }

    /// Lists the links of a hub's phase-0 block that are not the hub's; returns how many there are.
    fn foreign(&mut self, hub: u32, list: &mut [u32]) -> usize {
        let stamp = self.graph.next_stamp();
        let queue = &mut *self.queues[0];
        queue[0] = hub;
        self.graph.bodies[hub as usize].mark = stamp;
        let (mut at, mut found, mut count) = (0, 1, 0);
        while at < found {
            let body = queue[at];
            at += 1;
            let mut half = self.graph.bodies[body as usize].head[0];
            while half != NONE {
                let (other, next) = self.graph.across(half);
                if body != hub && other != hub && half.is_multiple_of(2) {
                    list[count] = half / 2;
                    count += 1;
                }
                half = next;
                if other != IMMOVABLE && self.graph.bodies[other as usize].mark != stamp {
                    self.graph.bodies[other as usize].mark = stamp;
                    queue[found] = other;
                    found += 1;
                }
            }
        }
        count
    }
}
