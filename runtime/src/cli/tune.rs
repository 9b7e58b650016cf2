//! `cellstep tune`: runs a scene at many places on the dial, and recommends one of them.
//!
//! ```text
//! tune/dial.rs      which settings are tried, and how a scene file says one
//! tune/measure.rs   a run of one: time of a step, and errors that need no closed form
//! tune/report.rs    the table, the frontier, and the choice
//! ```
//! Axes of error are told side by side and never added up. The one that the choice acts on, the headline, is the
//! greatest of three lengths: how deep things overlap, how far joints gape, and by how much the bodies lie higher
//! or lower than in a reference; the last is how a stack that has fallen shows, whose rubble overlaps by nothing.
//! Two references say for how long runs of the scene can be compared at all: a pile falls otherwise with any
//! settings, and what two good runs of it differ by tells nothing of a third.

#[path = "tune/dial.rs"]
mod dial;
#[path = "tune/measure.rs"]
mod measure;
#[path = "tune/report.rs"]
mod report;

use crate::args::TuneArgs;
use crate::run::{build, processors, tell_notes};
use crate::verify::progress_bar;
use crate::{Failure, UNMET, json, say};
use cellstep::scene::format::SettingsDoc;
use cellstep::{Pool, Preset, Settings};
use dial::Place;
use measure::{Run, Stage};
use report::{Goal, Line, Recommended, Reference, Report};
use std::io::Write;

/// The reference has so many times the substeps of the preset `exact`, and the run that it is compared with half of
/// that.
const REFERENCE: u32 = 4;
const SUBSTEPS_MAX: u32 = 256;

/// Tries the settings and tells of them. Gives the exit code.
pub fn tune(args: &TuneArgs, out: &mut impl Write) -> Result<u8, Failure> {
    let report = measure_all(args)?;
    let code = if report.recommended.is_some() { 0 } else { UNMET };
    let text = if args.json { json(&report)? } else { report.to_string() };
    say(out, &text, code)
}

fn measure_all(args: &TuneArgs) -> Result<Report, String> {
    let mut built = build(&args.scene, args.size)?;
    tell_notes(&built);
    let workers = args.workers.map_or_else(processors, usize::from);
    let mut pool = Pool::new(workers).map_err(|error| format!("--workers {workers}: {error}"))?;
    let world = &mut built.world;
    let mut start = vec![0; world.snapshot_bytes()];
    world.save(&mut start).map_err(|error| error.to_string())?;
    let (own, bodies, joints) = (world.settings(), world.bodies().count(), world.joint_count());
    let places = dial::places(&own, joints > 0);
    let references = references(&own);
    let work = |settings: &Settings| u64::from(args.steps) * u64::from(settings.substeps);
    let total = references.iter().chain(places.iter().map(|place| &place.settings)).map(work).sum();
    let bar = progress_bar("tune", "substeps", total);
    let mut stage = Stage { world, start: &start, executor: &mut pool, steps: args.steps };
    let [reference, near] = {
        let mut of = |settings: &Settings| stage.run(settings, || bar.inc(u64::from(settings.substeps)));
        [of(&references[0])?, of(&references[1])?]
    };
    let samples = reference.comparable(&near);
    let spread = near.height_error(&reference, samples);
    let mut lines = Vec::new();
    for place in &places {
        let run = stage.try_place(place, || bar.inc(u64::from(place.settings.substeps)))?;
        lines.push(line(place, &run, &reference, (samples, spread)));
    }
    bar.finish_and_clear();
    report::rank(&mut lines);
    let goal = match (args.budget_ms, args.max_error) {
        (Some(ms), _) => Goal::BudgetMs(ms),
        (None, error) => Goal::MaxError(error.unwrap_or_default()),
    };
    let choice = report::choose(&lines, goal);
    let recommended = choice.and_then(Result::ok).map(|index| {
        let place = places.iter().find(|place| place.name == lines[index].name);
        let settings = place.map_or_else(SettingsDoc::default, |place| dial::fragment(&place.settings));
        Recommended { name: lines[index].name.clone(), settings }
    });
    let nearest = choice.and_then(Result::err);
    Ok(Report {
        scene: args.scene.clone(),
        steps: args.steps,
        workers,
        bodies,
        joints,
        goal,
        reference: Reference {
            substeps: references[0].substeps,
            compared_with: references[1].substeps,
            comparable_steps: if samples == 0 { 0 } else { measure::step_of(samples - 1, args.steps) },
            height_spread: spread,
        },
        recommended,
        missed_by: nearest.map(|(_, factor)| factor),
        nearest: nearest.map(|(index, _)| lines[index].name.clone()),
        settings: lines,
    })
}

/// The settings of the reference and of the run that it is compared with.
fn references(own: &Settings) -> [Settings; 2] {
    let mut exact = *own;
    Preset::Exact.apply(&mut exact);
    let with = |factor: u32| Settings { substeps: SUBSTEPS_MAX.min(exact.substeps * factor), ..exact };
    [with(REFERENCE), with(REFERENCE / 2)]
}

fn line(place: &Place, run: &Run, reference: &Run, (samples, spread): (usize, f64)) -> Line {
    let (penetration, gap) = (f64::from(run.penetration.p99()), f64::from(run.gap.p99()));
    let height = (run.height_error(reference, samples) - spread).max(0.0);
    Line {
        name: place.name.clone(),
        settings: SettingsDoc::dial(&place.settings),
        ms_per_step: run.ms_per_step(),
        error: (run.quarantined == 0).then(|| penetration.max(gap).max(height)),
        penetration_p99: penetration,
        penetration_max: f64::from(run.penetration.max),
        joint_gap_p99: gap,
        joint_gap_max: f64::from(run.gap.max),
        height_error: height,
        speed: run.speed,
        distance: run.distance(reference, samples),
        quarantined: run.quarantined,
        on_frontier: false,
    }
}
