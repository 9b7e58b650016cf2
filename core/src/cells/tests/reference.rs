//! The rules of cellular ordering once more, as plainly as possible: sets and lists, everything counted anew
//! whenever it is asked for.

extern crate std;

use super::super::{Block, IMMOVABLE, Link};
use super::Built;
use super::graphs::Scene;
use std::vec;
use std::vec::Vec;

/// Links left over, and who took which body in this phase.
struct Naive<'a> {
    links: &'a [Link],
    left: Vec<bool>,
    owner: Vec<Option<usize>>,
    blocks: Vec<Vec<u32>>,
}

/// The schedule of a scene for a given g.
pub fn schedule(scene: &Scene, g: u32) -> Built {
    let mut naive =
        Naive { links: &scene.links, left: vec![true; scene.links.len()], owner: vec![], blocks: vec![] };
    let mut built = Built { order: vec![], blocks: vec![] };
    let mut phase = 0;
    while naive.left.contains(&true) {
        naive.owner = vec![None; scene.bodies as usize];
        naive.blocks = vec![];
        if phase < 7 {
            naive.stars(4 * g);
        }
        let cap = [g, g, g, 2 * g, 2 * g, 2 * g, 2 * g, u32::MAX][phase as usize];
        for seed in 0..scene.bodies {
            if naive.owner[seed as usize].is_none() {
                naive.grow(seed, cap as usize);
            }
        }
        for block in &naive.blocks {
            block.iter().for_each(|&link| naive.left[link as usize] = false);
        }
        naive.blocks.retain(|block| !block.is_empty());
        naive.blocks.sort_by_key(|block| core::cmp::Reverse(block.len()));
        for mut block in core::mem::take(&mut naive.blocks) {
            block.sort_by_key(|&link| scene.links[link as usize].kind);
            let (first, count) = (built.order.len() as u32, block.len() as u32);
            built.blocks.push(Block { phase, first, count });
            built.order.extend(block);
        }
        phase += 1;
    }
    built
}

impl Naive<'_> {
    /// The links of a body that were left at the start of the phase, as (other body, link), ascending.
    fn links_of(&self, body: u32) -> Vec<(u32, u32)> {
        let mut list = vec![];
        for (index, link) in self.links.iter().enumerate().filter(|(index, _)| self.left[*index]) {
            if link.a == body {
                list.push((link.b, index as u32));
            } else if link.b == body {
                list.push((link.a, index as u32));
            }
        }
        list.sort_unstable();
        list
    }

    fn stars(&mut self, limit: u32) {
        let is_hub: Vec<bool> =
            (0..self.owner.len()).map(|body| self.links_of(body as u32).len() > limit as usize).collect();
        for hub in (0..is_hub.len()).filter(|&hub| is_hub[hub]) {
            let id = self.blocks.len();
            let mut star = vec![];
            for (other, link) in self.links_of(hub as u32) {
                if other == IMMOVABLE {
                    star.push(link);
                } else if !is_hub[other as usize]
                    && self.owner[other as usize].is_none_or(|owner| owner == id)
                {
                    self.owner[other as usize] = Some(id);
                    star.push(link);
                }
            }
            if !star.is_empty() {
                self.owner[hub] = Some(id);
            }
            self.blocks.push(star);
        }
    }

    fn grow(&mut self, seed: u32, cap: usize) {
        let id = self.blocks.len();
        let (mut block, mut reached) = (vec![], vec![]);
        let mut next = Some(seed);
        while let Some(body) = next {
            self.owner[body as usize] = Some(id);
            reached.retain(|&other| other != body);
            for (other, link) in self.links_of(body) {
                if other == IMMOVABLE || self.owner[other as usize] == Some(id) {
                    block.push(link);
                } else if self.owner[other as usize].is_none() && !reached.contains(&other) {
                    reached.push(other);
                }
            }
            next = self.choose(&reached, id, block.len(), cap);
        }
        self.blocks.push(block);
    }

    /// The reached body with the largest share of links inside, among those that fit; the first one without cap.
    fn choose(&self, reached: &[u32], id: usize, count: usize, cap: usize) -> Option<u32> {
        if cap == u32::MAX as usize {
            return reached.first().copied();
        }
        let mut best: Option<(u32, usize, usize)> = None;
        for &body in reached {
            let links = self.links_of(body);
            let inside =
                |&&(other, _): &&(u32, u32)| other == IMMOVABLE || self.owner[other as usize] == Some(id);
            let gain = links.iter().filter(inside).count();
            let fits = count == 0 || count + gain <= cap;
            if fits && best.is_none_or(|(_, gain_best, all)| gain * all > gain_best * links.len()) {
                best = Some((body, gain, links.len()));
            }
        }
        best.map(|(body, ..)| body)
    }
}
