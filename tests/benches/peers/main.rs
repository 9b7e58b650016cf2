//! The same scenes in cellstep and, with `--features peers`, in `rapier3d` and Box3D: time beside accuracy.
//!
//! `cargo bench -p cellstep-tests --features peers --bench peers -- [--scene pyramid|pile|net|all] [--steps N]`
//!
//! - `pyramid`: 5,050 boxes that stand, from the first step on: time and overlap.
//! - `pile`: 4,096 balls, boxes and capsules that fall into a box with walls: time and overlap.
//! - `net`: 100 x 100 bodies without shapes on 19,800 ball joints, that swing down from one edge: time of 200 steps
//!   after 100 that are not timed, and how far apart the points are that joints hold together, at the end.
//!
//! Equal physics: the same shapes, 1000 kg/m3, friction 0.6, no restitution, or the same masses of 1 kg and no
//! shapes; no damping, sleep off, dt 1/60, each engine's own default solver settings, also for the stiffness of
//! joints: the last lines tell them. All engines run in one process and take turns, [`RUN`] steps each, in an order
//! that rotates; a run is compared with the runs of the same turn, and the medians of those ratios are told.
//!
//! Accuracy is measured by one ruler: the poses of every engine go into a fresh world with the same shapes, and
//! the overlap of all pairs is measured there; gaps of joints follow from the poses alone (`gauge.rs`). What an
//! engine says of itself stands beside.
//!
//! Box3D is compiled with `-O3 -DNDEBUG` (`CFLAGS` in `.cargo/config.toml`).

#[cfg(feature = "peers")]
mod box3d;
mod clock;
mod gauge;
mod own;
#[cfg(feature = "peers")]
mod rapier;
mod scenes;
mod table;

use cellstep::math::Pose;
use clock::{Clock, Spent};
use gauge::{Gaps, Gauge, Overlap};
use scenes::Scene;

/// Steps of a run: as many as an engine takes before the next one has its turn.
const RUN: u32 = 50;
/// Overlap is sampled after every run from this step on: before, scenes fall into place.
const SETTLED: u32 = 100;

/// What the bench asks of an engine.
trait Engine {
    /// Name, version and threads.
    fn name(&self) -> String;
    /// Its solver settings, all defaults, in a line.
    fn settings(&self) -> String;
    /// One step of 1/60 s.
    fn step(&mut self);
    /// Poses of all bodies in the order of the scene.
    fn poses(&self) -> Vec<Pose>;
    /// The deepest overlap by the engine's own contacts, metres.
    fn own_overlap(&self) -> f32;
    /// The widest joint as the engine itself measures it, metres, where it does.
    fn own_gap(&self) -> Option<f32> {
        None
    }
    /// More to tell at the end, a line each.
    fn notes(&self) -> Vec<String> {
        Vec::new()
    }
    /// Hash of the whole state, where the engine has one.
    fn checksum(&self) -> Option<u64> {
        None
    }
}

/// An engine and what was measured of it.
struct Entrant {
    engine: Box<dyn Engine>,
    /// Milliseconds per step, by run.
    runs: Vec<Spent>,
    /// Overlap after runs, from [`SETTLED`] on; none in scenes with joints.
    samples: Vec<Overlap>,
    /// Gaps of joints at the end, in scenes with joints.
    gaps: Option<Gaps>,
}

impl Entrant {
    fn run(&mut self, steps: u32) {
        let clock = Clock::start();
        for _ in 0..steps {
            self.engine.step();
        }
        self.runs.push(clock.stop(steps));
    }
}

/// cellstep with one worker and with two come first, in this order.
fn entrants(scene: &Scene) -> Vec<Entrant> {
    let engines: Vec<Box<dyn Engine>> = vec![
        Box::new(own::Serially::new(scene)),
        Box::new(own::Pooled::new(scene, 2)),
        #[cfg(feature = "peers")]
        Box::new(rapier::Rapier::new(scene)),
        #[cfg(feature = "peers")]
        Box::new(box3d::Box3d::new(scene)),
    ];
    let entrant = |engine| Entrant { engine, runs: Vec::new(), samples: Vec::new(), gaps: None };
    engines.into_iter().map(entrant).collect()
}

fn compete(scene: &Scene, steps: u32) -> Vec<Entrant> {
    let mut entrants = entrants(scene);
    let mut gauge = scene.joints.is_empty().then(|| Gauge::new(scene));
    for entrant in &mut entrants {
        (0..scene.warm_up).for_each(|_| entrant.engine.step());
    }
    let (mut done, mut turn) = (0, 0);
    while done < steps {
        let run = RUN.min(steps - done);
        for k in 0..entrants.len() {
            let next = (k + turn) % entrants.len();
            entrants[next].run(run);
        }
        done += run;
        turn += 1;
        if let Some(gauge) = gauge.as_mut().filter(|_| done >= SETTLED || done == steps) {
            for entrant in &mut entrants {
                entrant.samples.push(gauge.measure(&entrant.engine.poses()));
            }
        }
    }
    if !scene.joints.is_empty() {
        for entrant in &mut entrants {
            entrant.gaps = Some(Gaps::measure(scene, &entrant.engine.poses()));
        }
    }
    assert_eq!(entrants[0].engine.checksum(), entrants[1].engine.checksum(), "workers change no bit");
    entrants
}

/// The scenes to run, and the steps of each when told.
fn arguments() -> Result<(Vec<&'static str>, Option<u32>), String> {
    let (mut names, mut steps) = (scenes::NAMES.to_vec(), None);
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        let mut value = || arguments.next().ok_or(format!("{argument} needs a value"));
        match argument.as_str() {
            "--bench" => {}
            "--scene" => {
                let name = value()?;
                if name != "all" {
                    names.retain(|&known| known == name);
                }
                if names.is_empty() {
                    return Err(format!("no scene {name}: expected all, {}", scenes::NAMES.join(", ")));
                }
            }
            "--steps" => {
                let text = value()?;
                let count = text.parse().ok().filter(|&count| count > 0);
                steps = Some(count.ok_or(format!("--steps {text}: expected a number above 0"))?);
            }
            _ => return Err(format!("unknown argument {argument}: expected --scene NAME, --steps N")),
        }
    }
    Ok((names, steps))
}

fn main() -> std::process::ExitCode {
    let (names, steps) = match arguments() {
        Ok(arguments) => arguments,
        Err(error) => {
            eprintln!("{error}");
            return std::process::ExitCode::from(2);
        }
    };
    for name in names {
        let scene = scenes::make(name);
        let steps = steps.unwrap_or(scene.steps);
        table::print(&scene, steps, &compete(&scene, steps));
    }
    std::process::ExitCode::SUCCESS
}
