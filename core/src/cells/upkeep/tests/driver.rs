//! Runs the upkeep of a changing scene as a world would, with and without cache, and checks all it promises.

extern crate std;

use super::super::super::{
    Block, CELLULAR_PHASES_MAX, Cellular, IMMOVABLE, Link, Schedule, Scheduler, UNORDERED, check,
    scratch_words,
};
use super::super::{
    Change, NEW, OrderingRow, OrderingState, Report, Upkeep, upkeep_scratch_words, upkeep_words,
};
use super::churn::{Churn, Key, link};
use std::vec;
use std::vec::Vec;

/// State and outputs of one ordering.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Ordering {
    pub row: OrderingRow,
    pub dirt: Vec<u8>,
    pub phases: Vec<u8>,
    pub order: Vec<u32>,
    pub blocks: Vec<Block>,
    pub report: Report,
}

/// A scene with its ordering.
pub struct Driver<C> {
    pub churn: C,
    pub ordering: Ordering,
    pub links: Vec<Link>,
    pub from: Vec<u32>,
    pub lost: Vec<[u32; 2]>,
    keys: Vec<Key>,
    cache: Vec<u32>,
    capacity: usize,
    pub block_links: u32,
    started: bool,
}

impl<C: Churn> Driver<C> {
    /// With memory for so many links.
    pub fn new(churn: C, capacity: usize, block_links: u32) -> Self {
        let bodies = churn.bodies() as usize;
        Self {
            churn,
            ordering: Ordering { dirt: vec![0; bodies], ..Ordering::default() },
            links: vec![],
            from: vec![],
            lost: vec![],
            keys: vec![],
            cache: vec![0xdead_beef; upkeep_words(bodies, capacity)],
            capacity,
            block_links,
            started: false,
        }
    }

    /// One step of the scene, and what it means for the links.
    pub fn advance(&mut self) {
        let keys = self.churn.step();
        self.lost.clear();
        self.from.clear();
        let mut phases = vec![];
        let mut old = 0;
        for key in &keys {
            while self.keys.get(old).is_some_and(|kept| kept < key) {
                self.lost.push([self.keys[old].0, self.keys[old].1]);
                old += 1;
            }
            let kept = self.keys.get(old) == Some(key);
            self.from.push(if kept { old as u32 } else { NEW });
            phases.push(if kept { self.ordering.phases[old] } else { UNORDERED });
            old += usize::from(kept);
        }
        self.lost.extend(self.keys[old..].iter().map(|key| [key.0, key.1]));
        for &body in self.churn.removed() {
            self.ordering.dirt[body as usize] = 0;
            for body_of in self.lost.iter_mut().flatten().filter(|end| **end == body) {
                *body_of = IMMOVABLE;
            }
        }
        self.links = keys.iter().map(link).collect();
        self.keys = keys;
        self.ordering.phases = phases;
    }

    /// Updates the ordering with the cache, or in the memory of a fresh one.
    pub fn update(&mut self, cached: bool) {
        let cached = cached && self.started;
        self.started = true;
        let mut cache = core::mem::take(&mut self.cache);
        if !cached {
            cache.fill(0x5a5a_5a5a);
        }
        self.ordering = self.ordered(&mut cache, cached);
        self.cache = cache;
    }

    /// The ordering after an update in some cache.
    fn ordered(&self, cache: &mut [u32], cached: bool) -> Ordering {
        let mut next = self.ordering.clone();
        let bodies = self.churn.bodies() as usize;
        let mut scratch = vec![0xabab_abab; upkeep_scratch_words(bodies, self.capacity)];
        let mut upkeep = Upkeep::new(bodies, self.capacity, cache);
        let change = Change {
            links: &self.links,
            from: &self.from,
            lost: &self.lost,
            cached,
            block_links: self.block_links,
        };
        let state = OrderingState { row: &mut next.row, dirt: &mut next.dirt, phases: &mut next.phases };
        next.report = upkeep.update(&change, state, &mut scratch);
        next.order = vec![0; self.links.len()];
        next.blocks = vec![Block::default(); self.links.len()];
        scratch.fill(0x1234_5678);
        let mut schedule = Schedule { order: &mut next.order, blocks: &mut next.blocks, block_count: 0 };
        upkeep.schedule(&self.links, &mut scratch, &mut schedule);
        let count = schedule.block_count;
        next.blocks.truncate(count);
        next
    }

    /// Loses the cache and derives it again, between two steps.
    pub fn recall(&mut self) {
        self.cache.fill(0x5a5a_5a5a);
        let bodies = self.churn.bodies() as usize;
        let mut scratch = vec![0xabab_abab; upkeep_scratch_words(bodies, self.capacity)];
        let mut upkeep = Upkeep::new(bodies, self.capacity, &mut self.cache);
        upkeep.recall(&self.links, &self.ordering.phases, &self.ordering.dirt, &mut scratch);
    }

    /// Updates, and asserts that an update without cache gives the same in every byte.
    pub fn update_twice(&mut self, cached: bool) {
        let mut fresh = vec![0x7777_7777; self.cache.len()];
        let twin = self.ordered(&mut fresh, false);
        self.update(cached);
        assert!(twin == self.ordering, "the cache changes the ordering");
    }

    /// Asserts that the schedule is valid and its blocks are the components of the phases.
    pub fn check(&mut self) {
        let count = self.links.len();
        let bodies = self.churn.bodies();
        let ordering = &mut self.ordering;
        let block_count = ordering.blocks.len();
        let schedule = Schedule { order: &mut ordering.order, blocks: &mut ordering.blocks, block_count };
        let mut scratch = vec![0; scratch_words(bodies as usize, count)];
        assert_eq!(check(bodies, &self.links, &schedule, &mut scratch), Ok(()));
        assert_eq!(blocks_by_union(bodies, &self.links, &ordering.phases), *ordering);
        for block in &ordering.blocks {
            let links = &ordering.order[block.first as usize..][..block.count as usize];
            assert!(links.is_sorted_by_key(|&link| (self.links[link as usize].kind, link)));
        }
    }

    /// How many phases have links.
    pub fn phases(&self) -> usize {
        self.ordering.blocks.last().map_or(0, |block| block.phase as usize + 1)
    }

    /// The share of links in phase 0, in percent.
    pub fn share(&self) -> f64 {
        100.0 * f64::from(self.ordering.report.phase_links[0]) / self.links.len().max(1) as f64
    }

    /// The same of a fresh build.
    pub fn fresh_share(&self) -> f64 {
        let count = self.links.len();
        let mut scratch = vec![0; scratch_words(self.churn.bodies() as usize, count)];
        let (mut order, mut blocks) = (vec![0; count], vec![Block::default(); count]);
        let mut schedule = Schedule { order: &mut order, blocks: &mut blocks, block_count: 0 };
        Cellular { block_links: self.block_links }.schedule(
            self.churn.bodies(),
            &self.links,
            &mut scratch,
            &mut schedule,
        );
        let blocks = schedule.blocks[..schedule.block_count].iter();
        let cells: u32 = blocks.filter(|block| block.phase == 0).map(|block| block.count).sum();
        100.0 * f64::from(cells) / count.max(1) as f64
    }
}

/// What union and find make of the phases: the order of blocks within the schedule is that of (phase, descending
/// length, lowest link), and the links of a block are those of a component.
struct Union {
    phases: Vec<u8>,
    /// Lowest link of the component of each link, and its length.
    components: Vec<(u32, u32)>,
}

impl PartialEq<Ordering> for Union {
    fn eq(&self, ordering: &Ordering) -> bool {
        let mut last = (0, 0, 0);
        let mut originals = [NEW; CELLULAR_PHASES_MAX];
        ordering.blocks.iter().all(|block| {
            let links = &ordering.order[block.first as usize..][..block.count as usize];
            let (lowest, length) = self.components[links[0] as usize];
            let phase = u32::from(self.phases[links[0] as usize]);
            let key = (phase, u32::MAX - length, lowest);
            let ascends = last <= key;
            last = key;
            let original = &mut originals[block.phase as usize];
            let same_phase = *original == NEW || *original == phase;
            *original = phase;
            let same = |&link: &u32| {
                self.components[link as usize] == (lowest, length)
                    && u32::from(self.phases[link as usize]) == phase
            };
            ascends && same_phase && length == block.count && links.iter().all(same)
        })
    }
}

impl core::fmt::Debug for Union {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "components of {} links", self.phases.len())
    }
}

/// The components of each phase's links.
fn blocks_by_union(bodies: u32, links: &[Link], phases: &[u8]) -> Union {
    let node = |body: u32, phase: u8| body as usize * CELLULAR_PHASES_MAX + usize::from(phase);
    let mut parent: Vec<usize> = (0..bodies as usize * CELLULAR_PHASES_MAX).collect();
    let find = |parent: &mut Vec<usize>, mut at: usize| {
        while parent[at] != at {
            parent[at] = parent[parent[at]];
            at = parent[at];
        }
        at
    };
    for (link, &phase) in links.iter().zip(phases).filter(|(link, _)| link.b != IMMOVABLE) {
        let [a, b] = [link.a, link.b].map(|body| find(&mut parent, node(body, phase)));
        parent[a] = b;
    }
    let mut lowest = vec![(NEW, 0); parent.len()];
    let roots: Vec<usize> =
        links.iter().zip(phases).map(|(link, &phase)| find(&mut parent, node(link.a, phase))).collect();
    for (index, &root) in roots.iter().enumerate() {
        lowest[root].0 = lowest[root].0.min(index as u32);
        lowest[root].1 += 1;
    }
    Union { phases: phases.to_vec(), components: roots.iter().map(|&root| lowest[root]).collect() }
}
