//! Orderings of the links other than the built-in one, and ways to regroup any. All are checked where they are
//! used.
//!
//! The talk's orderings (SEED S13 to S18) are here as baselines for the built-in one, through the same solver:
//!
//! | [`Ordering`] | blocks | phases |
//! |---|---|---|
//! | `Natural` | one | one: no parallelism, the plain Gauss-Seidel sequence |
//! | `Islands` | connected components of the contact graph | one |
//! | `Coloured` | single links | first-fit colours, at most 31, and one for a serial rest |
//! | `RedBlack` | cells of a spatial grid ([`Grid`]) | eight colours of the grid, and one for a serial rest |
//! | `BreadthFirst` | grown breadth-first, with the caps of the built-in ordering | at most 8 |
//! | `Cellular` | the built-in ordering | at most 8 |

mod breadth_first;
mod colours;
pub mod model;
mod red_black;

use crate::executors::Random;
use cellstep::cells::{
    self, Block, Cellular, IMMOVABLE, Link, Schedule, Scheduler, check_words, scratch_words,
};

pub use breadth_first::{block_size, breadth_first};
pub use colours::first_fit;
pub use red_black::Grid;

/// A schedule as a value: phases of blocks of links.
pub type Phases = Vec<Vec<Vec<u32>>>;

/// A schedule that owns its memory, as flat as the solver's.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Flat {
    /// Links, block by block.
    pub order: Vec<u32>,
    /// Blocks, phase by phase.
    pub blocks: Vec<Block>,
}

impl Flat {
    /// Adds the links of `order` that are in no block yet as a block of a phase, unless there are none.
    fn close(&mut self, phase: u32) {
        let first = self.blocks.last().map_or(0, |block| block.first + block.count);
        let count = self.order.len() as u32 - first;
        if count > 0 {
            self.blocks.push(Block { phase, first, count });
        }
    }

    /// How many phases.
    pub fn phase_count(&self) -> u32 {
        self.blocks.last().map_or(0, |block| block.phase + 1)
    }

    /// Links of a block.
    pub fn links(&self, block: &Block) -> &[u32] {
        &self.order[block.first as usize..][..block.count as usize]
    }

    /// Blocks of each phase.
    pub fn phases(&self) -> impl Iterator<Item = &[Block]> {
        self.blocks.chunk_by(|a, b| a.phase == b.phase)
    }

    /// The same with the blocks of each phase by descending length, which is how they are dealt best; equal ones
    /// keep their order.
    fn longest_first(self) -> Self {
        let mut blocks = self.blocks.clone();
        blocks.sort_by_key(|block| (block.phase, u32::MAX - block.count));
        let mut sorted = Self { order: Vec::with_capacity(self.order.len()), blocks: Vec::new() };
        for block in &blocks {
            sorted.order.extend_from_slice(self.links(block));
            sorted.close(block.phase);
        }
        sorted
    }

    /// Whether it is a valid schedule of these links.
    pub fn check(&mut self, bodies: u32, links: &[Link]) -> Result<(), cells::ScheduleError> {
        let mut scratch = vec![0; check_words(bodies as usize, links.len())];
        let block_count = self.blocks.len();
        let schedule = Schedule { order: &mut self.order, blocks: &mut self.blocks, block_count };
        cells::check(bodies, links, &schedule, &mut scratch)
    }
}

impl From<Phases> for Flat {
    fn from(phases: Phases) -> Self {
        let mut flat = Self::default();
        for (phase, blocks) in phases.iter().enumerate() {
            for block in blocks {
                flat.order.extend_from_slice(block);
                flat.close(phase as u32);
            }
        }
        flat
    }
}

impl From<&Flat> for Phases {
    fn from(flat: &Flat) -> Self {
        flat.phases().map(|blocks| blocks.iter().map(|block| flat.links(block).to_vec()).collect()).collect()
    }
}

/// A scheduler made of a function, and what it has seen.
#[derive(Clone, Debug)]
pub struct Given<F> {
    order: F,
    /// Most links of a step.
    pub most_links: usize,
    /// Most phases of a step.
    pub most_phases: usize,
}

impl<F> Given<F> {
    /// Schedules by a function of the number of bodies and the links.
    pub fn new<R: Into<Flat>>(order: F) -> Self
    where
        F: FnMut(u32, &[Link]) -> R,
    {
        Self { order, most_links: 0, most_phases: 0 }
    }
}

impl<R: Into<Flat>, F: FnMut(u32, &[Link]) -> R> Scheduler for Given<F> {
    /// # Panics
    /// When the schedule is not valid.
    fn schedule(&mut self, bodies: u32, links: &[Link], scratch: &mut [u32], schedule: &mut Schedule<'_>) {
        let flat = (self.order)(bodies, links).into();
        schedule.order[..flat.order.len()].copy_from_slice(&flat.order);
        schedule.blocks[..flat.blocks.len()].copy_from_slice(&flat.blocks);
        schedule.block_count = flat.blocks.len();
        self.most_links = self.most_links.max(links.len());
        self.most_phases = self.most_phases.max(flat.phase_count() as usize);
        assert!(scratch.len() >= check_words(bodies as usize, links.len()));
        assert_eq!(cells::check(bodies, links, schedule, scratch), Ok(()));
    }
}

/// An ordering of the talk, or the built-in one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ordering {
    /// The links as they come, one after the other.
    Natural,
    /// Simulation islands side by side (SEED S13).
    Islands,
    /// Geometric multi-colour batches (SEED S15).
    Coloured,
    /// Cells of a spatial grid in eight colours (SEED S16).
    RedBlack,
    /// Cells grown breadth-first, as the talk has them (SEED S18).
    BreadthFirst,
    /// The built-in ordering.
    Cellular,
}

impl Ordering {
    /// All of them.
    pub const ALL: [Self; 6] =
        [Self::Natural, Self::Islands, Self::Coloured, Self::RedBlack, Self::BreadthFirst, Self::Cellular];

    /// Its name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Natural => "natural",
            Self::Islands => "islands",
            Self::Coloured => "coloured",
            Self::RedBlack => "red-black",
            Self::BreadthFirst => "breadth-first",
            Self::Cellular => "cellular",
        }
    }

    /// Orders links; only `RedBlack` looks at the grid.
    pub fn order(self, bodies: u32, links: &[Link], grid: &Grid) -> Flat {
        match self {
            Self::Natural => natural(bodies, links).into(),
            Self::Islands => islands(bodies, links),
            Self::Coloured => first_fit(bodies, links),
            Self::RedBlack => grid.order(bodies, links),
            Self::BreadthFirst => breadth_first(bodies, links, Cellular::default().block_links),
            Self::Cellular => cellular_flat(bodies, links),
        }
    }
}

/// The built-in ordering.
pub fn cellular(bodies: u32, links: &[Link]) -> Phases {
    Phases::from(&cellular_flat(bodies, links))
}

/// The built-in ordering.
pub fn cellular_flat(bodies: u32, links: &[Link]) -> Flat {
    let mut scratch = vec![0x5a5a_5a5a; scratch_words(bodies as usize, links.len())];
    let (mut order, mut blocks) = (vec![0; links.len()], vec![Block::default(); links.len()]);
    let mut schedule = Schedule { order: &mut order, blocks: &mut blocks, block_count: 0 };
    Cellular::default().schedule(bodies, links, &mut scratch, &mut schedule);
    let count = schedule.block_count;
    blocks.truncate(count);
    Flat { order, blocks }
}

/// All links in their own order, one after the other.
pub fn natural(_: u32, links: &[Link]) -> Phases {
    if links.is_empty() { Phases::new() } else { vec![vec![(0..links.len() as u32).collect()]] }
}

/// Simulation islands: connected components side by side, the links of each in their own order.
pub fn islands(bodies: u32, links: &[Link]) -> Flat {
    let all: Vec<u32> = (0..links.len() as u32).collect();
    let blocks = components(bodies, links, &all);
    Flat::from(if blocks.is_empty() { Phases::new() } else { vec![blocks] }).longest_first()
}

/// Greedy colouring, see [`first_fit`].
pub fn coloured(bodies: u32, links: &[Link]) -> Phases {
    Phases::from(&first_fit(bodies, links))
}

/// Random links in each of some phases, their connected components as blocks; the last phase takes the rest.
pub fn random(random: &mut Random, phases: usize, (bodies, links): (u32, &[Link])) -> Phases {
    let mut rest: Vec<u32> = (0..links.len() as u32).collect();
    random.shuffle(&mut rest);
    let mut chosen = Phases::new();
    for phase in 0..phases {
        let take =
            if phase + 1 == phases { rest.len() } else { random.below(rest.len() as u64 / 2 + 1) as usize };
        let own = rest.split_off(rest.len() - take);
        if !own.is_empty() {
            let mut blocks = components(bodies, links, &own);
            random.shuffle(&mut blocks);
            chosen.push(blocks);
        }
    }
    chosen
}

/// The same phases with the blocks of each in another order.
pub fn blocks_shuffled(random: &mut Random, mut phases: Phases) -> Phases {
    phases.iter_mut().for_each(|blocks| random.shuffle(blocks));
    phases
}

/// The same phases with every block cut into its connected components: the links of each keep their order.
pub fn blocks_split(phases: Phases, (bodies, links): (u32, &[Link])) -> Phases {
    let split =
        |blocks: Vec<Vec<u32>>| blocks.iter().flat_map(|block| components(bodies, links, block)).collect();
    phases.into_iter().map(split).collect()
}

/// The same phases with all blocks of each joined to one.
pub fn blocks_joined(phases: Phases) -> Phases {
    phases.into_iter().map(|blocks| vec![blocks.concat()]).collect()
}

/// The bodies of a link that can move.
fn ends(link: &Link) -> impl Iterator<Item = usize> {
    [link.a, link.b].into_iter().filter(|&body| body != IMMOVABLE).map(|body| body as usize)
}

/// Links that share bodies, directly or through others, together; in the order given.
fn components(bodies: u32, links: &[Link], own: &[u32]) -> Vec<Vec<u32>> {
    let mut parent: Vec<usize> = (0..bodies as usize).collect();
    fn root(parent: &mut [usize], mut body: usize) -> usize {
        while parent[body] != body {
            parent[body] = parent[parent[body]];
            body = parent[body];
        }
        body
    }
    for &link in own {
        let link = &links[link as usize];
        if link.b != IMMOVABLE {
            let (a, b) = (root(&mut parent, link.a as usize), root(&mut parent, link.b as usize));
            parent[a] = b;
        }
    }
    let mut place = vec![usize::MAX; bodies as usize];
    let mut blocks: Vec<Vec<u32>> = Vec::new();
    for &index in own {
        let body = root(&mut parent, links[index as usize].a as usize);
        if place[body] == usize::MAX {
            place[body] = blocks.len();
            blocks.push(Vec::new());
        }
        blocks[place[body]].push(index);
    }
    blocks
}
