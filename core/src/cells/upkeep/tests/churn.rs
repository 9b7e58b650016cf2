//! Scenes whose links come and go.

extern crate std;

use super::super::super::tests::graphs::Random;
use super::super::super::{IMMOVABLE, Link};
use std::vec;
use std::vec::Vec;

/// What identifies a link from step to step, in the order of the list: low body, high body, which of the parallel
/// ones.
pub type Key = (u32, u32, u32);

/// A scene that changes.
pub trait Churn {
    /// The number of body slots.
    fn bodies(&self) -> u32;
    /// The links after one more step, ascending.
    fn step(&mut self) -> Vec<Key>;
    /// Bodies that the step removed.
    fn removed(&self) -> &[u32] {
        &[]
    }
}

/// The link of a key. Its kind follows from the key.
pub fn link(&(a, b, which): &Key) -> Link {
    Link { a, b, kind: (a ^ b ^ which) % 4 }
}

/// Bodies that wobble about the places of a lattice while its layers shear: a pile in motion. Neighbours
/// closer than `reach` touch; about six links per body. Each step, some bodies are removed and come back later
/// in their slot.
pub struct Pile {
    size: [u32; 3],
    time: u32,
    /// Steps that a body's wobble takes, along each axis.
    periods: Vec<[u32; 3]>,
    /// How many bodies are removed per step.
    removals: u32,
    /// When an absent body is back.
    back: Vec<u32>,
    removed: Vec<u32>,
    random: Random,
    reach: f32,
}

impl Pile {
    pub fn new(size: [u32; 3], period: u32, removals: u32) -> Self {
        let count = size[0] * size[1] * size[2];
        let mut random = Random(11);
        let mut period = || period + random.below(period);
        let periods = (0..count).map(|_| [period(), period(), period()]).collect();
        let back = vec![0; count as usize];
        Self { size, time: 0, periods, removals, back, removed: vec![], random, reach: 1.13 }
    }

    /// Where a body is.
    fn place(&self, body: u32) -> [f32; 3] {
        let [nx, ny, _] = self.size;
        let at = [body % nx, body / nx % ny, body / nx / ny];
        let mut place = [0.0; 3];
        for axis in 0..3 {
            let period = self.periods[body as usize][axis];
            // A triangle wave with a phase of its own.
            let turn = (self.time + body.wrapping_mul(2_654_435_761) % period * (axis as u32 + 1)) % period;
            let wave = (2.0 * turn as f32 / period as f32 - 1.0).abs() - 0.5;
            place[axis] = at[axis] as f32 + 0.7 * wave;
        }
        let shear = self.time as f32 * at[2] as f32 / (40.0 * self.periods[0][0] as f32);
        place[0] = (place[0] + shear).rem_euclid(nx as f32);
        place
    }
}

impl Churn for Pile {
    fn bodies(&self) -> u32 {
        self.back.len() as u32
    }

    fn step(&mut self) -> Vec<Key> {
        self.time += 1;
        self.removed.clear();
        for _ in 0..self.removals {
            let body = self.random.below(self.bodies());
            if self.back[body as usize] <= self.time {
                self.back[body as usize] = self.time + 5 + self.random.below(40);
                self.removed.push(body);
            }
        }
        let [nx, ny, nz] = self.size;
        let cell = |place: [f32; 3]| {
            let at = |axis: usize, n: u32| (place[axis] as u32).min(n - 1);
            (at(2, nz) * ny + at(1, ny)) * nx + at(0, nx)
        };
        let places: Vec<[f32; 3]> = (0..self.bodies()).map(|body| self.place(body)).collect();
        let mut cells = vec![Vec::new(); self.bodies() as usize];
        let mut keys = vec![];
        for body in 0..self.bodies() {
            if self.back[body as usize] > self.time {
                continue;
            }
            cells[cell(places[body as usize]) as usize].push(body);
            if places[body as usize][2] < 0.0 {
                keys.push((body, IMMOVABLE, 0));
            }
        }
        for (at, bodies) in cells.iter().enumerate() {
            let at = at as u32;
            let (x, y, z) = (at % nx, at / nx % ny, at / nx / ny);
            for step in 0..27 {
                let (i, j, k) = (step % 3, step / 3 % 3, step / 9);
                let (x, y, z) = ((x + nx + i - 1) % nx, y + j, z + k);
                if y < 1 || y > ny || z < 1 || z > nz {
                    continue;
                }
                for &other in &cells[(((z - 1) * ny + y - 1) * nx + x) as usize] {
                    for &body in bodies {
                        let (p, q) = (places[body as usize], places[other as usize]);
                        let mut dx = (p[0] - q[0]).abs();
                        dx = if dx > nx as f32 / 2.0 { nx as f32 - dx } else { dx };
                        let square = dx * dx + (p[1] - q[1]) * (p[1] - q[1]) + (p[2] - q[2]) * (p[2] - q[2]);
                        if body < other && square < self.reach * self.reach {
                            keys.push((body, other, 0));
                            // Now and then two shapes of a body touch.
                            if (body ^ other) % 16 == 0 {
                                keys.push((body, other, 1));
                            }
                        }
                    }
                }
            }
        }
        keys.sort_unstable();
        keys
    }

    fn removed(&self) -> &[u32] {
        &self.removed
    }
}

/// A list of links that comes in link by link, in a random order, and stays.
pub struct Trickle {
    bodies: u32,
    /// Those still to come, the next one last.
    coming: Vec<Key>,
    present: Vec<Key>,
    /// How many come per step.
    pub pace: usize,
}

impl Trickle {
    pub fn new(bodies: u32, links: &[Link], pace: usize) -> Self {
        let mut pairs: Vec<(u32, u32)> =
            links.iter().map(|link| (link.a.min(link.b), link.a.max(link.b))).collect();
        pairs.sort_unstable();
        let mut coming: Vec<Key> = vec![];
        for (a, b) in pairs {
            let which = match coming.last() {
                Some(&(c, d, which)) if (c, d) == (a, b) => which + 1,
                _ => 0,
            };
            coming.push((a, b, which));
        }
        Random(5).shuffle(&mut coming);
        Self { bodies, coming, present: vec![], pace }
    }

    /// Lets some come at once.
    pub fn start(&mut self, which: impl Fn(&Key) -> bool) {
        self.present.extend(self.coming.iter().copied().filter(&which));
        self.coming.retain(|key| !which(key));
    }

    /// Whether all have come.
    pub fn is_done(&self) -> bool {
        self.coming.is_empty()
    }
}

impl Churn for Trickle {
    fn bodies(&self) -> u32 {
        self.bodies
    }

    fn step(&mut self) -> Vec<Key> {
        let left = self.coming.len().saturating_sub(self.pace);
        self.present.extend(self.coming.drain(left..));
        self.present.sort_unstable();
        self.present.clone()
    }
}

/// Random links among a pool of possible ones: each step some are switched on and some off.
pub struct Flicker {
    bodies: u32,
    /// Possible links, ascending, and whether they are there.
    pool: Vec<(Key, bool)>,
    random: Random,
    /// How many are switched per step.
    pub switches: u32,
    /// Switched links since the beginning.
    pub switched: u32,
}

impl Flicker {
    pub fn new(bodies: u32, links: &[Link], switches: u32) -> Self {
        let mut all = Trickle::new(bodies, links, links.len());
        let pool = all.step().into_iter().map(|key| (key, false)).collect();
        Self { bodies, pool, random: Random(77), switches, switched: 0 }
    }
}

impl Churn for Flicker {
    fn bodies(&self) -> u32 {
        self.bodies
    }

    fn step(&mut self) -> Vec<Key> {
        for _ in 0..self.switches {
            let at = self.random.below(self.pool.len() as u32) as usize;
            self.pool[at].1 ^= true;
            self.switched += 1;
        }
        self.pool.iter().filter(|(_, present)| *present).map(|(key, _)| *key).collect()
    }
}
