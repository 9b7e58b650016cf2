//! Keeping the ordering: only links that begin or end, and what is near them, are touched.
//!
//! **State** is a phase for each link, a byte of dirt for each body, and an [`OrderingRow`]. The rest follows
//! from it: *a block is a connected component of one phase's links* (over dynamic bodies), so a phase's blocks
//! share no body, whatever the phases are. Validity cannot be lost; only quality is at stake. [`Upkeep`] is that
//! derived part: lists, blocks and their lengths. It is cache: dropped at any time, it is built again from state
//! at 30 to 80 ns per link, and nothing that follows differs in a bit.
//!
//! **A step** takes all ends out first (a block whose last connection breaks parts in two; without that, blocks
//! would fill up with links that have nothing to do with each other), then puts each new link, by index, into the
//! first phase in which its block stays within the cap. Then the bodies that the changes touch take local moves,
//! by id (`moves.rs`). Each change also leaves a unit of dirt on its bodies; a phase-0 block whose bodies have
//! 2 g of it (g / 2 while few links change) is grown again with its neighbours (`regrow.rs`), as far as a credit
//! allows that changes pay into. Bodies with very many links get a block of their own (`hubs.rs`). When most links
//! are new, or g has changed by a factor of two, or more than four phases persist while the scene is calm, the
//! whole ordering is built by [`Cellular`] (`build.rs`).
//!
//! **Same bits with and without cache.** Choices depend on sets of links (blocks, degrees, counts) and are
//! ordered by link index and body id. Ids of blocks and of links, and the order of lists, are accidents of
//! history and order nothing: a merge has the same result whichever side is relabelled, a search the same answer
//! whichever way it goes. Ends come first so that what is known of the links that ended beyond `lost` does not
//! matter.
//!
//! Invariants: no recursion; no cost is quadratic in the links of a body; an update costs a linear pass over the
//! links (only to follow their indices), and otherwise in proportion to the changes.

mod build;
mod graph;
mod hubs;
mod moves;
mod recall;
mod regrow;
mod schedule;
mod split;
#[cfg(test)]
mod tests;

use super::{Block, CELLULAR_PHASES_MAX, Cellular, Link, scratch_words, words};
use build::Bulk;
use bytemuck::{Pod, Zeroable};
use graph::{BlockNode, BodyNode, Header, LinkNode, NONE, bodies_of};
use regrow::Region;

/// Marks a link that was not in the last update's list.
pub const NEW: u32 = u32::MAX;

/// Dirt of a block that is grown again, in g; a quarter of it in a calm scene, which has the time. Half as much
/// costs a seventh more and brings 0.4 points of phase 0.
const DIRTY: u32 = 2;
/// Links that re-growth may look at, per change.
const CREDIT_PER_CHANGE: i64 = 4;
/// The most credit is this part of the links, and a region at least.
const CREDIT_PARTS: i64 = 8;
/// More phases than this are not left alone.
const PHASES_WANTED: usize = 4;
/// A scene is calm when at most one link of so many changes.
const CALM_PARTS: usize = 64;
/// Calm updates with too many phases before a fresh build: a second. Doubled after each build that did not help.
const PATIENCE: u32 = 60;
const PATIENCE_MAX: u32 = 1 << 20;

/// What the ordering remembers of a world, besides phases and dirt. State; zero in a fresh world.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct OrderingRow {
    /// Links that re-growth may still look at; negative while the last one is being paid for.
    pub credit: i32,
    /// The body after the one that re-growth looked at last: the next one starts there.
    pub cursor: u32,
    /// g of the last fresh build.
    pub built: u32,
    /// Updates that too many phases have lasted, 0 while there are not too many or nothing can be done.
    pub waited: u32,
    /// How many fresh builds have left too many phases, 0 while there are not too many. Each doubles the patience.
    pub futile: u32,
}

impl OrderingRow {
    /// Whether an update without any change may be left out. Pending is only this: too many phases (left by
    /// links that trickled in) are counted in updates, until a fresh build.
    pub fn is_calm(&self) -> bool {
        self.waited == 0
    }
}

/// The state of an ordering.
pub struct OrderingState<'a> {
    /// The row of the world.
    pub row: &'a mut OrderingRow,
    /// Changes near each body since its block was last grown. The caller zeroes the byte of a removed body.
    pub dirt: &'a mut [u8],
    /// The phase of each link of this step: before the update [`UNORDERED`](super::UNORDERED) for links that
    /// begin, after it below [`CELLULAR_PHASES_MAX`] for all.
    pub phases: &'a mut [u8],
}

/// What has changed since the last update.
#[derive(Clone, Copy, Debug)]
pub struct Change<'a> {
    /// This step's links. Ends are ids of bodies, with gaps as they come, or [`IMMOVABLE`](super::IMMOVABLE).
    pub links: &'a [Link],
    /// The index of each link in the last update's list, ascending, or [`NEW`].
    pub from: &'a [u32],
    /// Ends of links that ended since the last update, as far as they are known.
    pub lost: &'a [[u32; 2]],
    /// False when the cache says nothing (after a restore, or in new memory).
    pub cached: bool,
    /// g as it is set; see [`Cellular`].
    pub block_links: u32,
}

/// What an update did. Equal with and without cache.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Report {
    /// Links that began.
    pub begun: u32,
    /// Links that local moves have moved, and bodies that migrated.
    pub moves: u32,
    /// Links that re-growth looked at.
    pub regrown: u32,
    /// Fresh builds: 0 or 1.
    pub builds: u32,
    /// g.
    pub block_links: u32,
    /// Links in each phase.
    pub phase_links: [u32; CELLULAR_PHASES_MAX],
}

/// Words of cache for so many bodies and links: 128 bytes per body and 52 per link.
pub const fn upkeep_words(bodies: usize, links: usize) -> usize {
    graph::HEADER_WORDS + bodies * graph::BODY_WORDS + links * graph::LINK_WORDS
}

/// Words of scratch that [`Upkeep::update`] and [`Upkeep::schedule`] need for so many bodies and links.
pub const fn upkeep_scratch_words(bodies: usize, links: usize) -> usize {
    let body_words = 5 * bodies + bodies.div_ceil(32);
    let link_words = (3 + words::<Link>() + words::<Block>()) * links;
    let update = body_words + link_words + scratch_words(bodies, links);
    let schedule = schedule::LINK_WORDS * links;
    if update > schedule { update } else { schedule }
}

/// The graph that follows from the links and their phases, in memory that keeps it from step to step.
pub struct Upkeep<'a> {
    header: &'a mut Header,
    bodies: &'a mut [BodyNode],
    links: &'a mut [LinkNode],
    blocks: &'a mut [BlockNode],
    /// The id of each link by index.
    ids: &'a mut [u32],
}

/// An update under way: the graph together with the state that follows it.
struct Work<'w, 'a> {
    graph: &'w mut Upkeep<'a>,
    phases: &'w mut [u8],
    dirt: &'w mut [u8],
    /// Two queues of bodies.
    queues: [&'w mut [u32]; 2],
    /// The cap of a block.
    g: u32,
    /// Moves so far.
    moves: u32,
}

/// The scratch of an update.
struct Memory<'s> {
    queues: [&'s mut [u32]; 2],
    /// The bodies that changes touch.
    touched: &'s mut [u32],
    /// The ids of the last update's links.
    old: &'s mut [u32],
    /// The links that begin, by index.
    begins: &'s mut [u32],
    bits: &'s mut [u32],
    region: Region<'s>,
}

impl<'a> Upkeep<'a> {
    /// Views into `words`, of which there are at least [`upkeep_words`]; their content stays. Constant time.
    pub fn new(bodies: usize, links: usize, words: &'a mut [u32]) -> Self {
        Self::carve(bodies, links, words)
    }

    /// Brings the ordering to this step's links. `scratch` has [`upkeep_scratch_words`] of any content.
    ///
    /// # Panics
    /// When the memory or a slice is too small, or with `cached` but memory that no update has seen.
    pub fn update(&mut self, change: &Change<'_>, state: OrderingState<'_>, scratch: &mut [u32]) -> Report {
        let count = change.links.len();
        assert!(count <= self.ids.len(), "more links than the cache was made for");
        assert!(change.from.len() == count && state.phases.len() >= count, "one entry per link");
        assert!(state.dirt.len() >= self.bodies.len(), "one byte of dirt per body");
        let [bodies, links] = self.capacities().map(|capacity| capacity as usize);
        let mut memory = Memory::carve(bodies, links, scratch);
        if change.cached {
            assert!(self.header.capacities == self.capacities(), "the cache is not of this world");
        }
        let begun = if change.cached {
            self.follow(change, state.dirt, &mut memory)
        } else {
            let begun = self.rebuild(change, state.phases, memory.begins);
            self.label(state.dirt, memory.queues[0]);
            begun
        };
        // Only now: before the ends are out, there may be no room.
        for &index in &memory.begins[..begun] {
            self.ids[index as usize] = self.admit(&change.links[index as usize], index);
        }
        let sums = (u64::from(self.header.dynamic_bodies), 2 * u64::from(self.header.dynamic_links));
        let g = Cellular { block_links: change.block_links }.size(count, sums);
        let row = state.row;
        let mut report = Report { begun: begun as u32, block_links: g, ..Report::default() };
        let resized = g / 2 >= row.built || g <= row.built / 2;
        let tired = row.waited > PATIENCE.saturating_mul(1 << row.futile.min(31)).min(PATIENCE_MAX);
        let fresh = count > 0 && (begun > (count - begun) / 2 || resized || tired);
        if fresh {
            let mut bulk = memory.bulk();
            self.build(change.links, change.block_links, (state.phases, state.dirt), &mut bulk);
            *row = OrderingRow { built: g, waited: row.waited, futile: row.futile, ..OrderingRow::default() };
            report.builds = 1;
        } else {
            let mut work = Work {
                graph: self,
                phases: state.phases,
                dirt: state.dirt,
                queues: memory.queues,
                g,
                moves: 0,
            };
            let touched = work.touch(change, &memory.begins[..begun], memory.touched);
            report.regrown = work.run(row, &memory.begins[..begun], touched, &mut memory.region);
            report.moves = work.moves;
        }
        self.wait(row, fresh, begun + change.lost.len());
        report.phase_links = self.header.phase_links;
        report
    }

    /// Takes out what ended, follows the indices of the links that stay, and lists those that begin; returns how
    /// many they are.
    fn follow(&mut self, change: &Change<'_>, dirt: &mut [u8], memory: &mut Memory<'_>) -> usize {
        let old_count = self.header.link_count as usize;
        let old = &mut memory.old[..old_count];
        old.copy_from_slice(&self.ids[..old_count]);
        self.header.link_count = change.links.len() as u32;
        let [first, second] = &mut memory.queues;
        let mut work = Work { graph: self, phases: &mut [], dirt, queues: [first, second], g: 0, moves: 0 };
        let (mut next, mut begun) = (0, 0);
        for (index, &from) in change.from.iter().enumerate() {
            if from == NEW {
                memory.begins[begun] = index as u32;
                begun += 1;
            } else {
                debug_assert!(next <= from, "the indices of kept links ascend");
                if next < from {
                    work.end(&old[next as usize..from as usize]);
                }
                next = from + 1;
            }
        }
        work.end(&old[next as usize..]);
        let ids = &mut self.ids[..change.from.len()];
        for (index, (id, &from)) in ids.iter_mut().zip(change.from).enumerate() {
            if from != NEW {
                *id = old[from as usize];
                self.links[*id as usize].index = index as u32;
            }
        }
        begun
    }

    /// Counts how long there have been too many phases.
    fn wait(&self, row: &mut OrderingRow, fresh: bool, changes: usize) {
        let links = self.header.link_count as usize;
        let phases = self.header.phase_links.iter().filter(|&&links| links > 0).count();
        if phases <= PHASES_WANTED {
            (row.waited, row.futile) = (0, 0);
        } else if fresh {
            // A second build would give the same: only a change can help.
            row.futile = (row.futile + 1).min(31);
            row.waited = 0;
        } else if changes > 0 || row.waited > 0 {
            row.waited = if changes * CALM_PARTS <= links { row.waited.saturating_add(1) } else { 1 };
        }
    }
}

impl Work<'_, '_> {
    /// Takes out links that ended.
    fn end(&mut self, ids: &[u32]) {
        for &id in ids {
            self.take_out(id);
            self.graph.dismiss(id);
        }
    }

    /// Leaves dirt at the ends of all changes; lists the bodies, by id.
    fn touch<'t>(&mut self, change: &Change<'_>, begins: &[u32], list: &'t mut [u32]) -> &'t [u32] {
        let stamp = self.graph.next_stamp();
        let mut count = 0;
        let lost = change.lost.iter().copied();
        let begun = begins.iter().map(|&index| change.links[index as usize]).map(|link| [link.a, link.b]);
        for end in lost.chain(begun) {
            for body in bodies_of(end) {
                self.soil(body);
                let mark = &mut self.graph.bodies[body as usize].mark;
                if *mark != stamp {
                    *mark = stamp;
                    list[count] = body;
                    count += 1;
                }
            }
        }
        let list = &mut list[..count];
        list.sort_unstable();
        list
    }

    /// Leaves a unit of dirt on a body.
    fn soil(&mut self, body: u32) {
        let dirt = &mut self.dirt[body as usize];
        if *dirt == u8::MAX {
            return;
        }
        *dirt += 1;
        let block = self.graph.bodies[body as usize].block[0];
        if block != NONE {
            self.graph.bodies[body as usize].dirt += 1;
            self.graph.blocks[block as usize].dirt += 1;
        }
    }

    /// Begins, local moves, re-growth; returns how many links re-growth looked at.
    fn run(
        &mut self,
        row: &mut OrderingRow,
        begins: &[u32],
        touched: &[u32],
        region: &mut Region<'_>,
    ) -> u32 {
        for &index in begins {
            self.begin(self.graph.ids[index as usize]);
        }
        if self.graph.header.heavy > 0 {
            for &body in touched {
                self.purify(body, region.links);
            }
        }
        for &body in touched {
            self.improve(body);
        }
        let most = (self.graph.header.link_count as i64 / CREDIT_PARTS).max(8 * i64::from(self.g));
        let changes = touched.len() as i64 / 2;
        let mut credit = (i64::from(row.credit) + CREDIT_PER_CHANGE * changes).min(most);
        let calm = touched.len() * CALM_PARTS <= self.graph.header.link_count as usize;
        let dirty = if calm { self.g / 2 } else { DIRTY * self.g };
        let mut regrown = 0;
        let start = touched.partition_point(|&body| body < row.cursor);
        for &body in touched[start..].iter().chain(&touched[..start]) {
            if credit <= 0 {
                break;
            }
            let block = self.graph.bodies[body as usize].block[0];
            if block != NONE && self.graph.blocks[block as usize].dirt >= dirty {
                let looked = self.regrow(body, region);
                credit -= i64::from(looked);
                regrown += looked;
                row.cursor = body + 1;
            }
        }
        row.credit = credit.clamp(i64::from(i32::MIN), i64::from(i32::MAX)) as i32;
        regrown
    }
}

impl<'s> Memory<'s> {
    /// Carves the scratch.
    fn carve(bodies: usize, links: usize, scratch: &'s mut [u32]) -> Self {
        let (first, rest) = scratch.split_at_mut(bodies);
        let (second, rest) = rest.split_at_mut(bodies);
        let (touched, rest) = rest.split_at_mut(bodies);
        let (members, rest) = rest.split_at_mut(bodies);
        let (slots, rest) = rest.split_at_mut(bodies);
        let (bits, rest) = rest.split_at_mut(bodies.div_ceil(32));
        let (old, rest) = rest.split_at_mut(links);
        let (begins, rest) = rest.split_at_mut(links);
        let (list, rest) = rest.split_at_mut(links);
        let (local, rest) = rest.split_at_mut(words::<Link>() * links);
        let (blocks, words) = rest.split_at_mut(words::<Block>() * links);
        let region = Region {
            members,
            slots,
            links: list,
            local: bytemuck::cast_slice_mut(local),
            blocks: bytemuck::cast_slice_mut(blocks),
            words,
        };
        Self { queues: [first, second], touched, old, begins, bits, region }
    }

    /// The same memory for a fresh build.
    fn bulk(&mut self) -> Bulk<'_> {
        Bulk {
            order: self.region.links,
            local: self.region.local,
            blocks: self.region.blocks,
            slots: self.region.slots,
            bits: self.bits,
            words: self.region.words,
        }
    }
}
