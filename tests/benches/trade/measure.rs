//! Errors, then cost, of every configuration in a scene.
//!
//! Errors depend on no clock: two threads share the runs. Then one thread times them: all worlds stand side by side
//! and take turns of some steps each, in an order that rotates; the median of a world's turns is its cost.

use crate::engine::{Config, Engine, configs};
use crate::scene::{Axis, Scene, Seen};
use cellstep::Preset;
use cellstep_tests::trade::{Point, median};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

/// Turns of each configuration.
const TURNS: usize = 7;
/// Threads that measure errors.
const THREADS: usize = 2;

/// A configuration and what was measured of it.
pub struct Measured {
    pub engine: &'static str,
    pub name: String,
    pub settings: String,
    pub preset: Option<Preset>,
    pub is_default: bool,
    /// Nanoseconds per moving body and simulated second.
    pub cost: f64,
    /// The headline first; all infinite when the run was lost.
    pub errors: Vec<Axis>,
}

impl Measured {
    pub fn point(&self) -> Point {
        Point { cost: self.cost, error: self.errors[0].value }
    }
}

/// A scene and all that ran in it.
pub struct Outcome {
    pub scene: Scene,
    pub all: Vec<Measured>,
}

impl Outcome {
    pub fn of(&self, engine: &str) -> Vec<&Measured> {
        self.all.iter().filter(|measured| measured.engine == engine).collect()
    }

    /// Unit of the headline error.
    pub fn unit(&self) -> &'static str {
        self.all.first().map_or("1", |measured| measured.errors[0].unit)
    }

    pub fn points(&self, engine: &str) -> Vec<Point> {
        self.of(engine).into_iter().map(Measured::point).collect()
    }
}

pub fn measure(scene: Scene) -> Outcome {
    let configs = configs(&scene);
    let errors = all_errors(&scene, &configs);
    let costs = costs(&scene, &configs);
    let measured = |((config, errors), cost): ((Config, Vec<Axis>), f64)| Measured {
        engine: config.engine,
        name: config.name,
        settings: config.settings,
        preset: config.preset,
        is_default: config.is_default,
        cost,
        errors,
    };
    let all = configs.into_iter().zip(errors).zip(costs).map(measured).collect();
    Outcome { scene, all }
}

fn all_errors(scene: &Scene, configs: &[Config]) -> Vec<Vec<Axis>> {
    let found: Mutex<Vec<Option<Vec<Axis>>>> = Mutex::new(configs.iter().map(|_| None).collect());
    let next = AtomicUsize::new(0);
    let work = || {
        loop {
            // The dearest come last in each engine's list; from the end, so that none of them is left alone.
            let taken = next.fetch_add(1, Ordering::Relaxed);
            let Some(place) = configs.len().checked_sub(taken + 1) else { return };
            let errors = errors(scene, &configs[place]);
            found.lock().expect("no run panics outside of its catch")[place] = Some(errors);
        }
    };
    std::thread::scope(|scope| {
        for _ in 1..THREADS {
            scope.spawn(work);
        }
        work();
    });
    let found = found.into_inner().expect("no run panics outside of its catch");
    found.into_iter().map(|errors| errors.expect("all places were taken")).collect()
}

/// Of one run. An engine that panics, or a body that is no longer finite, is a lost run.
fn errors(scene: &Scene, config: &Config) -> Vec<Axis> {
    let run = || {
        let mut probe = (scene.probe)(&scene.setup);
        let mut engine = (config.make)(&scene.setup);
        let mut seen = Vec::new();
        for step in 1..=scene.steps {
            engine.step();
            if probe.wants(step) {
                engine.read(&mut seen);
                if !seen.iter().all(Seen::is_finite) {
                    return None;
                }
                probe.see(step, &seen);
            }
        }
        Some(probe.errors())
    };
    match catch_unwind(AssertUnwindSafe(run)) {
        Ok(Some(errors)) => errors,
        _ => lost(scene),
    }
}

/// The axes of a scene, all infinite. Their names are those of a probe that has seen the start.
fn lost(scene: &Scene) -> Vec<Axis> {
    let mut probe = (scene.probe)(&scene.setup);
    let start: Vec<Seen> = scene.setup.bodies.iter().map(Seen::at_start).collect();
    probe.see(1, &start);
    let infinite = |axis: Axis| Axis { value: f64::INFINITY, ..axis };
    probe.errors().into_iter().map(infinite).collect()
}

/// Nanoseconds per moving body and simulated second of each configuration.
fn costs(scene: &Scene, configs: &[Config]) -> Vec<f64> {
    let mut engines: Vec<Option<Box<dyn Engine>>> =
        configs.iter().map(|config| Some((config.make)(&scene.setup))).collect();
    let mut turns: Vec<Vec<f64>> = vec![Vec::new(); engines.len()];
    for turn in 0..TURNS {
        for k in 0..engines.len() {
            let place = (k + turn * engines.len() / TURNS) % engines.len();
            let Some(engine) = engines[place].as_mut() else { continue };
            let warm = if turn == 0 { scene.warm } else { 0 };
            let run = catch_unwind(AssertUnwindSafe(|| {
                (0..warm).for_each(|_| engine.step());
                let clock = Instant::now();
                (0..scene.timed).for_each(|_| engine.step());
                clock.elapsed().as_nanos() as f64 / f64::from(scene.timed)
            }));
            match run {
                Ok(spent) => turns[place].push(spent),
                // It is not stepped again, nor dropped: it may be in any state.
                Err(_) => std::mem::forget(engines[place].take()),
            }
        }
    }
    let bodies = scene.setup.moving().max(1) as f64;
    let per_second = 1.0 / (f64::from(scene.setup.dt) * bodies);
    turns.into_iter().map(|turns| median(turns) * per_second).collect()
}
