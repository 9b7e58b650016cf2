//! What is measured of a scene.

use crate::WORKERS;
use crate::scenes::Scene;
use cellstep::cells::{Block, Cellular, Link, Schedule, Scheduler, scratch_words};
use cellstep::{Serial, Settings, Stage, StepReport, Timed};
use cellstep_tests::reference::{self, Method, Problem};
use cellstep_tests::schedules::model::Profile;
use cellstep_tests::schedules::{Flat, Grid, Ordering};
use cellstep_tests::worlds::OwnedWorld;
use std::time::{Duration, Instant};

/// Largest scene, in bodies, that goes to the double-precision solver.
const REFERENCE_BODIES: u32 = 5_200;
/// Longest that a scene is run.
const RUN: Duration = Duration::from_secs(20);
/// Sweeps after which residuals are shown.
pub const SWEEPS: [u32; 6] = [1, 2, 4, 8, 16, 32];
/// Further sweeps, for plots and for the way to a goal.
const MORE: [u32; 10] = [3, 6, 12, 24, 48, 64, 96, 128, 192, 256];
/// Synchronisations after which residuals are shown.
pub const SYNCS: [u32; 6] = [4, 8, 16, 32, 64, 128];

/// All about a scene.
pub struct Measured {
    /// Of the scene.
    pub name: String,
    /// Of the scene.
    pub note: &'static str,
    /// Steps taken before the graph was looked at.
    pub steps: u32,
    /// The last step.
    pub report: StepReport,
    /// Time of the ordering stage of the engine, ns per contact and step, and its share of the step.
    pub upkeep: (f64, f64),
    /// Edge of the red-black grid's cells, metres.
    pub edge: f64,
    /// By ordering.
    pub orderings: Vec<Ordered>,
    /// How residuals fall, if the scene is small enough.
    pub curves: Vec<Curve>,
}

impl Measured {
    /// What an ordering made of it.
    pub fn ordered(&self, ordering: Ordering) -> &Ordered {
        self.orderings.iter().find(|own| own.ordering == ordering).expect("all orderings are measured")
    }
}

/// What an ordering makes of the graph.
pub struct Ordered {
    /// Which.
    pub ordering: Ordering,
    /// Phases, lanes, balance.
    pub profile: Profile,
    /// Time to build it, ns per link.
    pub build_ns: f64,
    /// Modelled time of a sweep for each number of [`WORKERS`], ns.
    pub sweep_ns: [f64; WORKERS.len()],
}

impl Ordered {
    /// The ordering's name.
    pub fn name(&self) -> &'static str {
        self.ordering.name()
    }
}

/// How the residual of S8 falls.
pub struct Curve {
    /// The ordering or method.
    pub name: &'static str,
    /// Synchronisations per sweep.
    pub syncs: u32,
    /// Sweeps and the residual after them, ascending.
    pub points: Vec<(u32, f64)>,
}

impl Curve {
    /// The residual after so many sweeps; `None` if that was not measured.
    pub fn after(&self, sweeps: u32) -> Option<f64> {
        if sweeps == 0 {
            return Some(1.0);
        }
        self.points.iter().find(|point| point.0 == sweeps).map(|point| point.1)
    }

    /// Sweeps to a residual, between measured ones by their logarithms; `None` if it was not reached.
    pub fn sweeps_to(&self, goal: f64) -> Option<f64> {
        let mut before = (0.0, 0.0);
        for &(sweeps, residual) in &self.points {
            let now = (f64::from(sweeps), residual.ln());
            if residual <= goal {
                return Some(before.0 + (now.0 - before.0) * (goal.ln() - before.1) / (now.1 - before.1));
            }
            before = now;
        }
        None
    }

    /// The residual when so many synchronisations were spent.
    pub fn at_syncs(&self, syncs: u32) -> Option<f64> {
        self.after(syncs / self.syncs)
    }
}

/// Runs a scene and measures all orderings on its last contact graph.
pub fn measure(scene: &Scene) -> Measured {
    let mut world = scene.world();
    let (steps, report, upkeep) = run(&mut world, scene.steps);
    let (bodies, links) = reference::links(&world);
    let block_links = Settings::default().block_links;
    let grid = Grid::fitted(&world, &links, block_links);
    let mut flats = Vec::new();
    let mut orderings = Vec::new();
    for ordering in Ordering::ALL {
        let (mut flat, build_ns) = build(ordering, (bodies, &links), &grid);
        assert_eq!(flat.check(bodies, &links), Ok(()), "{}", ordering.name());
        let profile = Profile::new(&flat);
        let sweep_ns = WORKERS.map(|workers| profile.sweep_ns(workers));
        flats.push((ordering.name(), flat.phase_count(), flat.order));
        orderings.push(Ordered { ordering, profile, build_ns, sweep_ns });
    }
    let curves = if bodies <= REFERENCE_BODIES { curves(&Problem::new(&world), flats) } else { Vec::new() };
    let (name, note) = (scene.name.clone(), scene.note);
    Measured { name, note, steps, report, upkeep, edge: grid.edge(), orderings, curves }
}

/// Steps until all are taken or the time is up.
fn run(world: &mut OwnedWorld, steps: u32) -> (u32, StepReport, (f64, f64)) {
    let mut executor = Timed::new(Serial);
    let mut report = StepReport::default();
    let mut contacts = 0;
    let start = Instant::now();
    for step in 1..=steps {
        report = world.step(&mut executor);
        contacts += u64::from(report.contacts);
        if step == steps || start.elapsed() > RUN {
            break;
        }
    }
    let times = executor.take();
    let ordering = times.stage(Stage::Ordering).total.as_secs_f64();
    let upkeep = (ordering * 1e9 / contacts.max(1) as f64, ordering / times.sum().total.as_secs_f64());
    (times.steps as u32, report, upkeep)
}

/// The schedule, and the least time of three builds in ns per link.
fn build(ordering: Ordering, (bodies, links): (u32, &[Link]), grid: &Grid) -> (Flat, f64) {
    let mut least = f64::INFINITY;
    let mut flat = Flat::default();
    for _ in 0..3 {
        let start = Instant::now();
        flat = ordering.order(bodies, links, grid);
        least = least.min(start.elapsed().as_secs_f64());
    }
    if ordering == Ordering::Cellular {
        least = build_in_place(bodies, links);
    }
    (flat, least * 1e9 / links.len().max(1) as f64)
}

/// The built-in ordering in memory that is there already, as in the engine, seconds.
fn build_in_place(bodies: u32, links: &[Link]) -> f64 {
    let mut scratch = vec![0; scratch_words(bodies as usize, links.len())];
    let (mut order, mut blocks) = (vec![0; links.len()], vec![Block::default(); links.len()]);
    let mut least = f64::INFINITY;
    for _ in 0..3 {
        let mut schedule = Schedule { order: &mut order, blocks: &mut blocks, block_count: 0 };
        let start = Instant::now();
        Cellular::default().schedule(bodies, links, &mut scratch, &mut schedule);
        least = least.min(start.elapsed().as_secs_f64());
    }
    least
}

/// Residuals of all methods.
fn curves(problem: &Problem, flats: Vec<(&'static str, u32, Vec<u32>)>) -> Vec<Curve> {
    let mut methods: Vec<(&'static str, u32, Method)> = flats
        .into_iter()
        .map(|(name, syncs, order)| (name, syncs, Method::GaussSeidel(problem.sequence(&order))))
        .collect();
    let colours = reference::colours(problem);
    methods.push(("row colours", colours.len() as u32, Method::GaussSeidel(colours.concat())));
    methods.push(("jacobi", 1, problem.jacobi()));
    methods.into_iter().map(|(name, syncs, method)| curve(problem, (name, syncs.max(1)), &method)).collect()
}

fn curve(problem: &Problem, (name, syncs): (&'static str, u32), method: &Method) -> Curve {
    let mut marks: Vec<u32> = SWEEPS.into_iter().chain(MORE).collect();
    marks.extend(SYNCS.iter().map(|spent| spent / syncs));
    marks.sort_unstable();
    marks.dedup();
    let (mut iterate, mut done, mut points) = (problem.start(), 0, Vec::new());
    for mark in marks.into_iter().filter(|&mark| mark > 0) {
        (done..mark).for_each(|_| problem.sweep(method, &mut iterate));
        done = mark;
        points.push((mark, problem.residual(&iterate)));
    }
    Curve { name, syncs, points }
}
