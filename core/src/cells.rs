//! Cellular ordering of the contact graph: which links are solved side by side, and which one after another.
//!
//! The talk's idea (SEED S17-S20): links that share no body may be solved at once. Colouring gives every link
//! of a body another colour, so a body with twelve contacts forces twelve barriers. Cellular ordering groups
//! links into *blocks* instead. The links of a block run in sequence, the blocks of a *phase* run side by side,
//! and a phase ends in one barrier. Each phase grows blocks in what the phases before it left over:
//!
//! ```text
//!    cccc|cccc      phase 0  cells      volumes that fill the graph
//!    cccc|cccc      phase 1  membranes  the faces between two cells      (|)
//!    ----+----      phase 2  strings    the lines where membranes meet   (-)
//!    cccc|cccc      phase 3  points     what is left in the corners      (+)
//! ```
//!
//! so that three or four barriers serve a scene of any size. Only the graph is read, never a position.
//!
//! **Growth.** A block starts at a seed and takes, again and again, the neighbouring body with the largest
//! share of its links inside: (links that would come along) / (links it has left), earliest reached first. A
//! body that enters brings all its links to bodies of the block and to immovable ones, hence parallel links of
//! a pair never part. On a pile this leaves fewer links to later phases than taking bodies breadth-first.
//!
//! **Cap.** A block holds at most g links (2 g from phase 3 on); only the body that brings the first links may
//! exceed it. Where g is small against the degree, phases multiply, and left-over without cap percolates into
//! one giant serial block; [`Cellular`] keeps g at three times the average degree or more. The eighth phase has
//! no cap: it takes connected components.
//!
//! **Hubs.** A body with more than 4 g links (a platform under a pile) would fill one capped block in each of
//! many phases. Its star, the hub and all its links, is one block without cap, made before the others of its
//! phase. In lanes a star fills one of eight for its whole length.
//!
//! Invariants: the schedule depends on the arguments alone (no threads, no content of scratch); the choice of
//! bodies depends on the graph and the body ids, not on the order of the links; at most [`CELLULAR_PHASES_MAX`]
//! phases; no recursion; time is linear in the links, times the length of a frontier.

mod adjacency;
mod check;
mod growth;
mod layout;
#[cfg(test)]
mod tests;
mod upkeep;

use adjacency::{Entry, Graph, Node};
pub use check::{ScheduleError, check, check_words};
use growth::{Growth, Reached, UNCAPPED};
pub use upkeep::{
    Change, NEW, OrderingRow, OrderingState, Report, Upkeep, upkeep_scratch_words, upkeep_words,
};

/// Marks the end of a link that does not move (static or kinematic): it makes no conflict.
pub const IMMOVABLE: u32 = u32::MAX;
/// Phase of a link that has none yet.
pub const UNORDERED: u8 = u8::MAX;
/// Most phases of any schedule.
pub const PHASES_MAX: usize = 32;
/// Most phases of a [`Cellular`] schedule. The last of them has no cap, hence takes whatever is left.
pub const CELLULAR_PHASES_MAX: usize = 8;

/// Phases from this one on have twice the cap: what is left is thin, and more phases would cost more than
/// balance.
const DOUBLED_FROM: u32 = 3;
/// g is at least this many times the average dynamic degree, so that phases stay few. Measured on five lattices,
/// pyramids and packings of 20,000 to 64,000 bodies and a random geometric graph: 1 x takes 4 to 6 phases, 2 x
/// 4 or 5, 3 x 3 to 5 (the geometric graph), 4 x 3 or 4.
const DEGREE_FACTOR: u64 = 3;
/// A hub has more links than this many g. A body with fewer fits the capped blocks of four phases: g + g + g + 2 g.
const HUB_FACTOR: u32 = 4;
/// Least g that small scenes are cut down to. Shorter blocks have so little inside that phases multiply.
const BLOCK_LINKS_MIN: usize = 12;
/// A small scene's g is this part of its links: two thirds of them stay in phase 0, so that its eight lanes get
/// two blocks each. Measured on 29 scenes of 35 to 3,000 links: 1/8, 1/16, 1/24, 1/32 take 1.74, 1.58, 1.46,
/// 1.42 x the ideal lane time in 2.8, 3.0, 3.0, 3.1 phases.
const SMALL_SCENE_PARTS: usize = 24;

/// A link joins two bodies; ends are indices of awake dynamic bodies, or [`IMMOVABLE`]. `a` is never `IMMOVABLE`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct Link {
    /// First body.
    pub a: u32,
    /// Second body, or [`IMMOVABLE`].
    pub b: u32,
    /// Links of a block run in ascending order of `kind` where the schedule is free to choose (kind and point
    /// count: neighbours in a lane should be alike).
    pub kind: u32,
}

/// A block: links that run in sequence, next to blocks of its phase that run in parallel.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct Block {
    /// The phase, from 0.
    pub phase: u32,
    /// First entry in the schedule's `order`.
    pub first: u32,
    /// Number of links, at least 1.
    pub count: u32,
}

/// Where a scheduler writes its schedule.
///
/// Valid: `order[..links]` is a permutation of the links; `blocks[..block_count]` tile it without gaps, phases
/// ascend from 0 without gaps and stay below [`PHASES_MAX`]; no body is in two blocks of one phase.
/// [`check`] decides it.
pub struct Schedule<'a> {
    /// Link indices, block by block. As long as there are links.
    pub order: &'a mut [u32],
    /// At least as long as there are links.
    pub blocks: &'a mut [Block],
    /// How many blocks were written.
    pub block_count: usize,
}

/// Chooses a schedule for the links of a step.
pub trait Scheduler {
    /// Writes a valid schedule of `links` among `bodies` bodies. `scratch` has at least
    /// [`scratch_words`]`(bodies, links)` words of no defined content. The result depends on the arguments alone.
    fn schedule(&mut self, bodies: u32, links: &[Link], scratch: &mut [u32], schedule: &mut Schedule<'_>);
}

/// Words of scratch that [`Cellular`] and [`check`] need for so many bodies and links: 40 bytes per body and about
/// 28 per link.
pub const fn scratch_words(bodies: usize, links: usize) -> usize {
    bodies * BODY_WORDS + links * LINK_WORDS + links.div_ceil(32)
}

/// Words per body: its node, its place among the active, its place in the frontier.
const BODY_WORDS: usize = words::<Node>() + 1 + words::<Reached>();
/// Words per link: an entry at each end, its place in build order, its sort key.
const LINK_WORDS: usize = 2 * words::<Entry>() + 1 + 2;

/// Size of a scratch record in words.
const fn words<T>() -> usize {
    size_of::<T>() / size_of::<u32>()
}

/// Cellular ordering, built from nothing at every call.
///
/// Blocks of a phase come by descending length, then in the order they were built; links of a block by
/// (`kind`, order of growth). A star block is preceded by longer blocks only.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cellular {
    /// g, the intended number of links of a block; 32 to 128 is sensible. Longer blocks leave fewer links to
    /// later phases, shorter ones balance better. It is raised to three times the average number of dynamic
    /// contacts of a body, and lowered for small scenes so that they still give eight lanes work.
    pub block_links: u32,
}

impl Default for Cellular {
    fn default() -> Self {
        Self { block_links: 64 }
    }
}

impl Scheduler for Cellular {
    fn schedule(&mut self, bodies: u32, links: &[Link], scratch: &mut [u32], schedule: &mut Schedule<'_>) {
        assert!(scratch.len() >= scratch_words(bodies as usize, links.len()), "scratch is too small");
        assert!(schedule.order.len() >= links.len(), "the schedule's order is too short");
        assert!(schedule.blocks.len() >= links.len(), "the schedule has too few blocks");
        schedule.block_count = 0;
        let (mut growth, keys) = carve(bodies as usize, links, scratch);
        let g = self.size(links.len(), growth.graph.dynamic_ends());
        let mut phase = 0;
        while growth.grown_count < links.len() {
            let first = schedule.block_count;
            growth.begin_phase(phase);
            let cap = cap(phase, g);
            if cap != UNCAPPED {
                growth.stars(g.saturating_mul(HUB_FACTOR), schedule);
            }
            growth.blocks(cap, schedule);
            layout::lay_out(links, growth.grown, schedule, first, keys);
            growth.end_phase();
            phase += 1;
        }
    }
}

impl Cellular {
    /// g for a scene: the setting, lowered for small scenes, then raised above the percolation threshold.
    /// `dynamic_ends` counts the bodies with links to dynamic bodies, and the ends of such links.
    fn size(&self, links: usize, dynamic_ends: (u64, u64)) -> u32 {
        let small = (links / SMALL_SCENE_PARTS).max(BLOCK_LINKS_MIN);
        let wanted = u64::from(self.block_links.max(1)).min(small as u64);
        let (bodies, ends) = dynamic_ends;
        let least = (DEGREE_FACTOR * ends).div_ceil(bodies.max(1));
        wanted.max(least).min(u64::from(u32::MAX / 2 - 1)) as u32
    }
}

/// Most links of a block of a phase.
fn cap(phase: u32, g: u32) -> u32 {
    match phase {
        p if p + 1 >= CELLULAR_PHASES_MAX as u32 => UNCAPPED,
        p if p >= DOUBLED_FROM => 2 * g,
        _ => g,
    }
}

/// Carves the scratch and builds the graph in it; the second part is the memory for sort keys.
fn carve<'a>(bodies: usize, links: &[Link], scratch: &'a mut [u32]) -> (Growth<'a>, &'a mut [[u32; 2]]) {
    let (nodes, rest) = scratch.split_at_mut(bodies * words::<Node>());
    let (active, rest) = rest.split_at_mut(bodies);
    let (frontier, rest) = rest.split_at_mut(bodies * words::<Reached>());
    let (entries, rest) = rest.split_at_mut(2 * links.len() * words::<Entry>());
    let (grown, rest) = rest.split_at_mut(links.len());
    let (keys, rest) = rest.split_at_mut(2 * links.len());
    let assigned = &mut rest[..links.len().div_ceil(32)];
    assigned.fill(0);
    let graph =
        Graph::build(links, bytemuck::cast_slice_mut(nodes), bytemuck::cast_slice_mut(entries), active);
    let growth = Growth::new(graph, bytemuck::cast_slice_mut(frontier), grown, assigned);
    (growth, bytemuck::cast_slice_mut(keys))
}
