//! What a schedule would cost on lanes and workers, by a model with stated numbers.
//!
//! The solver deals the blocks of a phase to *groups* of eight chains, one for each lane: a group for every 512
//! links, at most 96 in a phase; blocks come by descending length and each goes to the chain with the fewest links.
//! A group has as many rows as its longest chain, and a row costs the same however few of its lanes are filled.
//! Groups are tasks: workers claim them in order, each when it is free, and a phase with several tasks ends in a
//! barrier.
//!
//! The model leaves out: caches and memory bandwidth, pulls of seats, integration, and unequal point counts. Real
//! speed-ups are lower.

use super::Flat;

/// Lanes of a row.
pub const LANES: usize = 8;
/// Links for which a phase gets another group.
pub const GROUP_LINKS: usize = 512;
/// Most groups of a phase.
pub const GROUPS_MAX: usize = 96;
/// Time of a link in a row whose eight lanes are filled, ns: a row takes eight times that.
pub const LINK_NS: f64 = 30.0;
/// Time of a barrier, ns, and what every worker adds to it.
pub const BARRIER_NS: [f64; 2] = [2_000.0, 100.0];

/// What a schedule looks like to lanes and workers.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Profile {
    /// Links of each phase.
    pub links: Vec<usize>,
    /// Links of the largest block of each phase.
    pub largest: Vec<usize>,
    /// Rows of each group of each phase.
    pub rows: Vec<Vec<usize>>,
}

impl Profile {
    /// Deals a schedule as the solver does.
    pub fn new(flat: &Flat) -> Self {
        let mut profile = Self::default();
        for blocks in flat.phases() {
            let lengths: Vec<usize> = blocks.iter().map(|block| block.count as usize).collect();
            let links = lengths.iter().sum::<usize>();
            profile.rows.push(deal(&lengths, links.div_ceil(GROUP_LINKS).min(GROUPS_MAX)));
            profile.links.push(links);
            profile.largest.push(lengths.iter().copied().max().unwrap_or(0));
        }
        profile
    }

    /// Phases of a sweep: how often all wait for all.
    pub fn syncs(&self) -> usize {
        self.links.len()
    }

    /// All links.
    pub fn link_count(&self) -> usize {
        self.links.iter().sum()
    }

    /// Links of the largest block.
    pub fn largest_block(&self) -> usize {
        self.largest.iter().copied().max().unwrap_or(0)
    }

    /// Share of the lanes of all rows that have a link; 1 if there are none.
    pub fn lane_fill(&self) -> f64 {
        let rows: usize = self.rows.iter().flatten().sum();
        if rows == 0 { 1.0 } else { self.link_count() as f64 / (LANES * rows) as f64 }
    }

    /// Time of a sweep on some workers, ns.
    pub fn sweep_ns(&self, workers: usize) -> f64 {
        self.rows.iter().map(|groups| phase_ns(groups, workers)).sum()
    }

    /// How much faster a sweep is than on one worker whose lanes are all filled: the same measure for every
    /// ordering.
    pub fn speed_up(&self, workers: usize) -> f64 {
        let time = self.sweep_ns(workers);
        if time == 0.0 { 1.0 } else { self.link_count() as f64 * LINK_NS / time }
    }
}

/// Rows of each group once blocks of these lengths are dealt, each to the chain with the fewest links, the first of
/// equals.
fn deal(lengths: &[usize], groups: usize) -> Vec<usize> {
    // A heap of (links, chain), least first.
    let mut chains: std::collections::BinaryHeap<_> =
        (0..groups * LANES).map(|chain| std::cmp::Reverse((0, chain))).collect();
    for length in lengths {
        if let Some(mut least) = chains.peek_mut() {
            least.0.0 += length;
        }
    }
    let mut rows = vec![0; groups];
    for std::cmp::Reverse((links, chain)) in chains {
        let group = &mut rows[chain / LANES];
        *group = links.max(*group);
    }
    rows
}

/// Time of a phase: list scheduling of its groups, and the barrier.
fn phase_ns(groups: &[usize], workers: usize) -> f64 {
    let mut free = vec![0_usize; workers.max(1)];
    for rows in groups {
        if let Some(first) = free.iter_mut().min() {
            *first += rows;
        }
    }
    let rows = free.into_iter().max().unwrap_or(0);
    let several = workers > 1 && groups.len() > 1;
    let barrier = if several { BARRIER_NS[0] + BARRIER_NS[1] * workers as f64 } else { 0.0 };
    rows as f64 * LANES as f64 * LINK_NS + barrier
}
