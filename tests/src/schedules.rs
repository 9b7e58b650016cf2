//! Orderings of the links other than the built-in one, and ways to regroup it. All are checked where they are used.

use crate::executors::Random;
use cellstep::cells::{
    self, Block, Cellular, IMMOVABLE, Link, PHASES_MAX, Schedule, Scheduler, check_words, scratch_words,
};

/// A schedule as a value: phases of blocks of links.
pub type Phases = Vec<Vec<Vec<u32>>>;

/// A scheduler made of a function, and what it has seen.
#[derive(Clone, Debug)]
pub struct Given<F> {
    order: F,
    /// Most links of a step.
    pub most_links: usize,
    /// Most phases of a step.
    pub most_phases: usize,
}

impl<F: FnMut(u32, &[Link]) -> Phases> Given<F> {
    /// Schedules by a function of the number of bodies and the links.
    pub fn new(order: F) -> Self {
        Self { order, most_links: 0, most_phases: 0 }
    }
}

impl<F: FnMut(u32, &[Link]) -> Phases> Scheduler for Given<F> {
    /// # Panics
    /// When the schedule is not valid.
    fn schedule(&mut self, bodies: u32, links: &[Link], scratch: &mut [u32], schedule: &mut Schedule<'_>) {
        let phases = (self.order)(bodies, links);
        write(&phases, schedule);
        self.most_links = self.most_links.max(links.len());
        self.most_phases = self.most_phases.max(phases.len());
        assert!(scratch.len() >= check_words(bodies as usize, links.len()));
        assert_eq!(cells::check(bodies, links, schedule, scratch), Ok(()));
    }
}

fn write(phases: &Phases, schedule: &mut Schedule<'_>) {
    let (mut next, mut count) = (0, 0);
    for (phase, blocks) in phases.iter().enumerate() {
        for block in blocks {
            schedule.order[next..next + block.len()].copy_from_slice(block);
            schedule.blocks[count] =
                Block { phase: phase as u32, first: next as u32, count: block.len() as u32 };
            next += block.len();
            count += 1;
        }
    }
    schedule.block_count = count;
}

/// The built-in ordering.
pub fn cellular(bodies: u32, links: &[Link]) -> Phases {
    let mut scratch = vec![0x5a5a_5a5a; scratch_words(bodies as usize, links.len())];
    let (mut order, mut blocks) = (vec![0; links.len()], vec![Block::default(); links.len()]);
    let mut schedule = Schedule { order: &mut order, blocks: &mut blocks, block_count: 0 };
    Cellular::default().schedule(bodies, links, &mut scratch, &mut schedule);
    let count = schedule.block_count;
    let mut phases = Phases::new();
    for block in &blocks[..count] {
        if block.phase as usize == phases.len() {
            phases.push(Vec::new());
        }
        let run = block.first as usize..(block.first + block.count) as usize;
        phases[block.phase as usize].push(order[run].to_vec());
    }
    phases
}

/// All links in their own order, one after the other.
pub fn natural(_: u32, links: &[Link]) -> Phases {
    if links.is_empty() { Phases::new() } else { vec![vec![(0..links.len() as u32).collect()]] }
}

/// Greedy colouring: each link is a block in the first phase where its bodies are free. What finds no colour below
/// the last phase is one serial block in it.
pub fn coloured(bodies: u32, links: &[Link]) -> Phases {
    const LAST: u32 = PHASES_MAX as u32 - 1;
    let mut used = vec![0_u32; bodies as usize];
    let mut phases = Phases::new();
    let mut rest = Vec::new();
    for (index, link) in links.iter().enumerate() {
        let taken = ends(link).fold(0, |taken, body| taken | used[body]);
        let colour = taken.trailing_ones();
        if colour >= LAST {
            rest.push(index as u32);
            continue;
        }
        ends(link).for_each(|body| used[body] |= 1 << colour);
        if colour as usize == phases.len() {
            phases.push(Vec::new());
        }
        phases[colour as usize].push(vec![index as u32]);
    }
    if !rest.is_empty() {
        phases.push(vec![rest]);
    }
    phases
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
