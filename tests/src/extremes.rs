//! The contract at the extremes: whatever a scene is like, a step keeps what it promises.
//!
//! [`Attack::check`] runs a scene at every preset and holds each step to this:
//!
//! - the state is finite, nothing is quarantined and nothing dropped;
//! - energy (motion, and height in the gravity of now) is at most that of the start, what was done to the world
//!   from outside, and what push-out of overlaps may give;
//! - bits are the same on one thread, with one worker and with three;
//! - the work of a step, counted in bodies, pairs, contacts and barriers, is at most ten times that of the same
//!   scene at ordinary values.

use crate::oracles::{center, dot, mass, norm, spin, spin_energy, velocity, wide};
use crate::worlds::{self, OwnedWorld};
use cellstep::{BodyKind, Capacities, Executor, Pool, Preset, Serial, Settings, StepReport};

/// By how much the energy may be above its bound, as a share of what there is: rounding, and the softness of
/// contacts.
const ENERGY_SLACK: f64 = 1.0e-3;

/// How many times the work of the ordinary scene a step may take.
const COST_MAX: u64 = 10;

/// A scene, and what is done to it.
pub struct Attack<'a> {
    /// What is tried, for messages.
    pub name: String,
    /// Room of its world.
    pub capacities: Capacities,
    /// Steps to take.
    pub steps: u32,
    /// Makes the scene in an empty world with the preset's settings.
    pub build: &'a dyn Fn(&mut OwnedWorld),
    /// Done before each step, which is given by its number; what it does to the energy is its own work.
    pub act: &'a dyn Fn(&mut OwnedWorld, u32),
    /// The greatest speed that push-out may give a body, m/s: 0 in a scene without overlaps.
    pub push_out: f64,
    /// By how much the energy may be above its bound, as a share of what there is.
    pub slack: f64,
    /// True where kinematic bodies or drives do work, which nobody counts: energy is not looked at.
    pub driven: bool,
}

/// What a run was like.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Run {
    /// Checksums after every tenth step.
    pub sums: Vec<u64>,
    /// Most work of a step.
    pub cost: u64,
    /// Bodies that were capped, over all steps.
    pub capped: u32,
    /// Greatest speed of a body's center, m/s.
    pub fastest: f64,
    /// Greatest spin, rad/s.
    pub spin: f64,
    /// Energy beyond its bound as a share of what there is.
    pub gain: f64,
}

/// Energy of all dynamic bodies in the gravity of now, and the size of its parts with one metre of height, J.
pub fn energy(world: &OwnedWorld) -> (f64, f64) {
    let gravity = wide(world.settings().gravity);
    let (mut sum, mut size) = (0.0, 0.0);
    for body in world.bodies().filter(|&body| world.kind(body) == Ok(BodyKind::Dynamic)) {
        let (m, v) = (mass(world, body), velocity(world, body));
        let moving = 0.5 * m * dot(v, v) + spin_energy(world, body);
        sum += moving - m * dot(gravity, center(world, body));
        size += moving + m * norm(gravity);
    }
    (sum, size)
}

/// What a step has to do, in bodies, pairs, contacts and barriers.
fn cost(report: &StepReport) -> u64 {
    u64::from(report.active)
        + u64::from(report.pairs)
        + 4 * u64::from(report.contacts)
        + u64::from(report.barriers)
}

impl Attack<'_> {
    /// An attack on a world of so many bodies, with nothing done to it.
    pub fn new<'a>(name: &str, bodies: u32, build: &'a dyn Fn(&mut OwnedWorld)) -> Attack<'a> {
        Attack {
            name: name.into(),
            capacities: Capacities { pairs: 256 + 32 * bodies, ..Capacities::for_bodies(bodies) },
            steps: 120,
            build,
            act: &|_, _| {},
            push_out: 0.0,
            slack: ENERGY_SLACK,
            driven: false,
        }
    }

    /// An empty world at a preset, with the scene in it.
    fn world(&self, preset: Preset) -> OwnedWorld {
        let mut world = worlds::world_with(self.capacities);
        world.set_settings(&Settings::from(preset)).expect("presets are in range");
        (self.build)(&mut world);
        world
    }

    /// Runs it at a preset.
    ///
    /// # Panics
    /// When a step breaks the contract.
    pub fn run(&self, preset: Preset, executor: &mut impl Executor) -> Run {
        let at = |step: u32| format!("{}, {}, step {step}", self.name, preset.name());
        let mut world = self.world(preset);
        let (mut bound, mut most) = energy(&world);
        let bodies: Vec<_> = world.bodies().collect();
        let pushed: f64 = bodies.iter().map(|&body| 0.5 * mass(&world, body) * self.push_out.powi(2)).sum();
        let mut run = Run::default();
        for step in 1..=self.steps {
            let before = energy(&world).0;
            (self.act)(&mut world, step);
            let (after, size) = energy(&world);
            bound += after - before;
            most = most.max(size);
            let report = world.step(executor);
            assert_eq!((report.quarantined, report.dropped), (0, 0), "{}", at(step));
            let (now, _) = energy(&world);
            for body in world.bodies() {
                let (p, v, w) = (center(&world, body), velocity(&world, body), spin(&world, body));
                assert!(p.iter().chain(&v).chain(&w).all(|x| x.is_finite()), "{}: {body:?}", at(step));
                (run.fastest, run.spin) = (run.fastest.max(norm(v)), run.spin.max(norm(w)));
            }
            run.gain = run.gain.max((now - bound - pushed) / most.max(f64::MIN_POSITIVE));
            if !self.driven {
                assert!(
                    run.gain <= self.slack,
                    "{}: {now:.6e} J, at most {bound:.6e} + {pushed:.2e} of {most:.2e} J",
                    at(step)
                );
            }
            run.capped += report.capped;
            run.cost = run.cost.max(cost(&report));
            if step % 10 == 0 {
                run.sums.push(world.checksum());
            }
        }
        run
    }

    /// The checksums after every tenth step, and nothing else.
    fn trace(&self, preset: Preset, executor: &mut impl Executor) -> Vec<u64> {
        let mut world = self.world(preset);
        let mut sums = Vec::new();
        for step in 1..=self.steps {
            (self.act)(&mut world, step);
            world.step(executor);
            if step % 10 == 0 {
                sums.push(world.checksum());
            }
        }
        sums
    }

    /// Runs it at every preset with every executor; gives what the presets were like.
    ///
    /// # Panics
    /// When a step breaks the contract, or bits differ.
    pub fn check(&self) -> [Run; Preset::ALL.len()] {
        Preset::ALL.map(|preset| {
            let run = self.run(preset, &mut Serial);
            for workers in [1, 3] {
                let mut pool = Pool::new(workers).expect("threads can be started");
                let sums = self.trace(preset, &mut pool);
                assert!(run.sums == sums, "{}, {}, {workers} workers", self.name, preset.name());
            }
            println!(
                "{}, {}: fastest {:.3} m/s, spin {:.3} rad/s, energy {:+.1e}, capped {}, cost {}",
                self.name,
                preset.name(),
                run.fastest,
                run.spin,
                run.gain,
                run.capped,
                run.cost
            );
            run
        })
    }

    /// The same, with the work of a step held against that of an ordinary scene.
    ///
    /// # Panics
    /// When a step breaks the contract, bits differ or a step takes too much work.
    pub fn check_beside(&self, ordinary: &[Run; Preset::ALL.len()]) -> [Run; Preset::ALL.len()] {
        let runs = self.check();
        for (run, other) in runs.iter().zip(ordinary) {
            let most = COST_MAX * other.cost;
            assert!(run.cost <= most, "{}: {} of work, at most {most}", self.name, run.cost);
        }
        runs
    }
}
