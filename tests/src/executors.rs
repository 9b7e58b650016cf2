//! Executors that look for results that depend on the order of tasks.

use cellstep::{Executor, Stage};

/// Runs the tasks of each call in a random order, on one thread: the cheapest test of determinism.
#[derive(Clone, Debug)]
pub struct Shuffled {
    random: Random,
}

impl Shuffled {
    /// The orders follow from the seed.
    pub fn new(seed: u64) -> Self {
        Self { random: Random::new(seed) }
    }
}

impl Executor for Shuffled {
    fn for_each<T: Send>(&mut self, _: Stage, tasks: &mut [T], run: impl Fn(&mut T) + Sync) {
        let mut order: Vec<usize> = (0..tasks.len()).collect();
        self.random.shuffle(&mut order);
        for i in order {
            run(&mut tasks[i]);
        }
    }
}

/// A small generator of random numbers: SplitMix64 (Steele, Lea, Flood 2014).
#[derive(Clone, Debug)]
pub struct Random {
    state: u64,
}

impl Random {
    /// A sequence for each seed.
    pub fn new(seed: u64) -> Self {
        Self { state: seed }
    }

    /// 64 random bits.
    pub fn bits(&mut self) -> u64 {
        self.state = self.state.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.state;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// Below `bound`, which is not 0.
    pub fn below(&mut self, bound: u64) -> u64 {
        self.bits() % bound
    }

    /// From `low` to `high`.
    pub fn between(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * ((self.bits() >> 40) as f32 / 16_777_216.0)
    }

    /// Brings items into a random order (Fisher, Yates).
    pub fn shuffle<T>(&mut self, items: &mut [T]) {
        for i in (1..items.len()).rev() {
            items.swap(i, self.below(i as u64 + 1) as usize);
        }
    }
}
