//! Plain breadth-first cells (SEED S18), with the caps of the built-in ordering.
//!
//! Everything but the growth rule is as documented for [`cellstep::cells`], written here again: g from the setting,
//! the scene's size and its average degree, 2 g from the fourth phase on, no cap in the eighth, stars of hubs
//! first. A block takes the bodies that it reached in the order in which it reached them, not by their share of
//! links inside.

use super::{Flat, ends};
use cellstep::cells::{CELLULAR_PHASES_MAX, IMMOVABLE, Link};
use std::collections::VecDeque;

/// Marks a body that no block of the phase has.
const FREE: u32 = u32::MAX;

/// g as the documentation of [`Cellular`](cellstep::cells::Cellular) has it: `block_links`, at most a 24th of the
/// links but at least 12, and never less than three times the average degree among dynamic bodies.
pub fn block_size(bodies: u32, links: &[Link], block_links: u32) -> u32 {
    let mut degree = vec![0_u64; bodies as usize];
    let inner = links.iter().filter(|link| link.b != IMMOVABLE && link.a != link.b);
    inner.for_each(|link| ends(link).for_each(|body| degree[body] += 1));
    let (sum, count) = (degree.iter().sum::<u64>(), degree.iter().filter(|&&d| d > 0).count() as u64);
    let least = (3 * sum).div_ceil(count.max(1)) as u32;
    block_links.min((links.len() as u32 / 24).max(12)).max(least)
}

/// Orders links in blocks grown breadth-first.
pub fn breadth_first(bodies: u32, links: &[Link], block_links: u32) -> Flat {
    let g = block_size(bodies, links, block_links);
    let mut growth = Growth::new(bodies, links);
    let last = CELLULAR_PHASES_MAX as u32 - 1;
    for phase in 0..=last {
        if growth.flat.order.len() == links.len() {
            break;
        }
        growth.begin(phase);
        if phase < last {
            growth.stars(4 * g);
        }
        let cap = if phase == last { u32::MAX } else { g << u32::from(phase >= 3) };
        for seed in 0..bodies {
            growth.grow(seed, cap);
        }
    }
    growth.flat.longest_first()
}

/// Blocks growing in the links that are left.
struct Growth<'a> {
    links: &'a [Link],
    /// For each body its links, from `first[body]` to `first[body + 1]`.
    near: Vec<u32>,
    first: Vec<u32>,
    assigned: Vec<bool>,
    /// The block of this phase that has a body.
    owner: Vec<u32>,
    /// The block that last reached a body.
    reached: Vec<u32>,
    phase: u32,
    stamp: u32,
    queue: VecDeque<u32>,
    flat: Flat,
}

impl<'a> Growth<'a> {
    fn new(bodies: u32, links: &'a [Link]) -> Self {
        let mut first = vec![0_u32; bodies as usize + 1];
        for link in links {
            ends(link).for_each(|body| first[body + 1] += 1);
        }
        for body in 0..bodies as usize {
            first[body + 1] += first[body];
        }
        let mut next = first.clone();
        let mut near = vec![0; first[bodies as usize] as usize];
        for (index, link) in links.iter().enumerate() {
            for body in ends(link) {
                near[next[body] as usize] = index as u32;
                next[body] += 1;
            }
        }
        Self {
            links,
            near,
            first,
            assigned: vec![false; links.len()],
            owner: vec![FREE; bodies as usize],
            reached: vec![FREE; bodies as usize],
            phase: 0,
            stamp: 0,
            queue: VecDeque::new(),
            flat: Flat { order: Vec::with_capacity(links.len()), blocks: Vec::new() },
        }
    }

    fn begin(&mut self, phase: u32) {
        self.phase = phase;
        self.owner.fill(FREE);
    }

    /// Links of a body that are in no block, each with its other end.
    fn left(&self, body: u32) -> impl Iterator<Item = (u32, u32)> + '_ {
        let range = self.first[body as usize] as usize..self.first[body as usize + 1] as usize;
        self.near[range].iter().filter(|&&link| !self.assigned[link as usize]).map(move |&index| {
            let link = &self.links[index as usize];
            (index, if link.a == body { link.b } else { link.a })
        })
    }

    /// A block of the links between each body with more than `limit` links left and those that are no such bodies.
    fn stars(&mut self, limit: u32) {
        let degree: Vec<u32> =
            (0..self.owner.len() as u32).map(|body| self.left(body).count() as u32).collect();
        for hub in (0..self.owner.len() as u32).filter(|&hub| degree[hub as usize] > limit) {
            let stamp = self.next_stamp();
            let free = |&(_, other): &(u32, u32)| {
                other == IMMOVABLE
                    || (degree[other as usize] <= limit
                        && [FREE, stamp].contains(&self.owner[other as usize]))
            };
            let own: Vec<(u32, u32)> = self.left(hub).filter(free).collect();
            for (link, other) in own {
                if other != IMMOVABLE {
                    self.owner[other as usize] = stamp;
                }
                self.owner[hub as usize] = stamp;
                self.assign(link);
            }
            self.close();
        }
    }

    /// Grows a block from a body that no block has; only its first links may exceed the cap.
    fn grow(&mut self, seed: u32, cap: u32) {
        if self.owner[seed as usize] != FREE || self.left(seed).next().is_none() {
            return;
        }
        let stamp = self.next_stamp();
        let mut count = 0_u32;
        self.queue.clear();
        self.queue.push_back(seed);
        self.reached[seed as usize] = stamp;
        while let Some(body) = self.queue.pop_front() {
            let inside = |other: u32| other == IMMOVABLE || self.owner[other as usize] == stamp;
            let (own, out): (Vec<_>, Vec<_>) = self.left(body).partition(|&(_, other)| inside(other));
            let gain = own.len() as u32;
            if count > 0 && count.saturating_add(gain) > cap {
                continue;
            }
            count += gain;
            self.owner[body as usize] = stamp;
            own.into_iter().for_each(|(link, _)| self.assign(link));
            for (_, other) in out {
                let reached = &mut self.reached[other as usize];
                if self.owner[other as usize] == FREE && *reached != stamp {
                    *reached = stamp;
                    self.queue.push_back(other);
                }
            }
        }
        self.close();
    }

    fn next_stamp(&mut self) -> u32 {
        self.stamp += 1;
        self.stamp
    }

    fn assign(&mut self, link: u32) {
        self.assigned[link as usize] = true;
        self.flat.order.push(link);
    }

    /// Ends the block, its links by kind.
    fn close(&mut self) {
        let from = self.flat.blocks.last().map_or(0, |block| block.first + block.count) as usize;
        self.flat.order[from..].sort_by_key(|&link| self.links[link as usize].kind);
        self.flat.close(self.phase);
    }
}
