//! `cellstep run`: from arguments to a report.

use crate::args::RunArgs;
use crate::import;
use crate::report::{Report, StageMs};
use cellstep::executor::Stage;
use cellstep::replay::{AssetSet, Options, Recorder};
use cellstep::scene::builtin::{BUILTIN, Builtin};
use cellstep::scene::format::SettingsDoc;
use cellstep::scene::{self, Build, Limits, Scene};
use cellstep::{Memory, Pool, Timed, World};
use indicatif::{ProgressBar, ProgressStyle};
use std::fs::File;
use std::io::{self, IsTerminal, Write};
use std::path::Path;
use std::time::{Duration, Instant};

/// Makes the scene, steps it, and tells what happened. Errors are for the user.
pub fn run(args: &RunArgs) -> Result<Report, String> {
    let built = build(&args.scene, args.size)?;
    tell_notes(&built);
    let Build { mut world, assets, .. } = built;
    turn_dial(args, &mut world)?;
    let workers = args.workers.map_or_else(processors, usize::from);
    let pool = Pool::new(workers).map_err(|error| format!("--workers {workers}: {error}"))?;
    let mut executor = Timed::new(pool);
    let mut recorder = args.record.as_ref().map(|_| recorder(args, &world, &assets)).transpose()?;
    let bar = progress_bar(args);
    let mut spent = Duration::ZERO;
    let mut last = None;
    let (mut dropped, mut quarantined, mut barriers) = (0u64, 0u64, 0u64);
    for _ in 0..args.steps {
        let start = Instant::now();
        let report = match &mut recorder {
            Some(recorder) => recorder.step(&mut world, &mut executor),
            None => world.step(&mut executor),
        };
        spent += start.elapsed();
        dropped += u64::from(report.dropped);
        quarantined += u64::from(report.quarantined);
        barriers += u64::from(report.barriers);
        last = Some(report);
        bar.inc(1);
    }
    bar.finish_and_clear();
    if let Some(recorder) = recorder {
        recorder.finish(&world).map_err(|error| format!("the replay is not whole: {error}"))?;
    }
    let per_step = |total: f64| if args.steps == 0 { 0.0 } else { total / f64::from(args.steps) };
    let ms = |time: Duration| per_step(time.as_secs_f64() * 1.0e3);
    let times = executor.times();
    let stage = |stage| ms(times.stage(stage).total);
    Ok(Report {
        scene: args.scene.clone(),
        steps: args.steps,
        workers,
        substeps: world.settings().substeps,
        settings: SettingsDoc::dial(&world.settings()),
        bodies: world.bodies().count(),
        asleep: world.bodies().filter(|&body| world.is_asleep(body).unwrap_or(false)).count(),
        joints: world.joint_count(),
        pairs: last.as_ref().map_or(0, |report| report.pairs),
        contacts: last.as_ref().map_or(0, |report| report.contacts),
        phases: last.as_ref().map_or(0, |report| report.phases),
        blocks: last.as_ref().map_or(0, |report| report.blocks),
        barriers_per_step: per_step(barriers as f64),
        dropped,
        quarantined,
        state_bytes: world.snapshot_bytes(),
        checksum: format!("{:016x}", world.checksum()),
        ms_per_step: ms(spent),
        stage_ms: StageMs {
            broadphase: stage(Stage::Broadphase),
            narrowphase: stage(Stage::Narrowphase),
            islands: stage(Stage::Islands),
            ordering: stage(Stage::Ordering),
            assembly: stage(Stage::Assembly),
            solve: stage(Stage::Solve),
            finish: stage(Stage::Finish),
            serial: ms(spent.saturating_sub(times.sum().parallel)),
        },
        penetration_max: world.penetration_max(),
    })
}

/// Sets what the command line says of the dial, beside what the scene says.
fn turn_dial(args: &RunArgs, world: &mut World<Memory>) -> Result<(), String> {
    let mut settings = world.settings();
    if let Some(preset) = args.preset {
        preset.apply(&mut settings);
    }
    if let Some(substeps) = args.substeps {
        settings.substeps = substeps;
    }
    world.set_settings(&settings).map_err(|error| format!("--preset or --substeps: {error}"))
}

/// Every record is written at once, so that nothing is lost in a crash.
fn recorder(args: &RunArgs, world: &World<Memory>, assets: &AssetSet) -> Result<Recorder<File>, String> {
    let path = args.record.as_deref().unwrap_or(Path::new(""));
    let size = args.size.map_or(String::new(), |size| format!(" --size {size}"));
    let options = Options {
        checksums_every: args.checksums_every,
        keyframes_every: args.keyframes_every,
        watches_commands: false,
        note: format!("cellstep run {}{size}", args.scene),
    };
    let refused = |error: &dyn std::fmt::Display| format!("cannot write {}: {error}", path.display());
    let file = File::create(path).map_err(|error| refused(&error))?;
    Recorder::new(file, world, assets, &options).map_err(|error| refused(&error))
}

pub fn processors() -> usize {
    std::thread::available_parallelism().map_or(1, |count| count.get().min(Pool::WORKERS_MAX))
}

/// Tells what was mended in the meshes of a scene.
pub fn tell_notes(built: &Build) {
    for (mesh, notes) in &built.notes {
        // A note that cannot be shown is no reason to stop.
        let _ = writeln!(io::stderr(), "note: mesh `{mesh}`: {notes}");
    }
}

/// Makes a scene in a size, or in its own. A built-in one goes before a file of its name: `./name` is the file.
pub fn build(name: &str, size: Option<u32>) -> Result<Build, String> {
    if Builtin::find(name).is_some() {
        return builtin(name, size)?.build(Path::new("")).map_err(|error| error.to_string());
    }
    let file = Path::new(name);
    if !file.exists() {
        return Err(format!("{name:?} is neither a file nor a built-in scene ({})", names()));
    }
    if size.is_some() {
        return Err("--size is for built-in scenes: a scene file has its own".to_string());
    }
    if import::is_model(file) {
        let folder = file.parent().unwrap_or(Path::new(""));
        return import::scene(file)?.build(folder).map_err(|error| format!("{}: {error}", file.display()));
    }
    scene::load(file, &Limits::default()).map_err(|error| error.to_string())
}

/// The document of a built-in scene in a size, or in its own.
pub fn builtin(name: &str, size: Option<u32>) -> Result<Scene, String> {
    let builtin = Builtin::find(name)
        .ok_or_else(|| format!("no built-in scene is named {name:?}, expected one of {}", names()))?;
    builtin.scene(size.unwrap_or(builtin.default_size)).map_err(|error| error.to_string())
}

fn names() -> String {
    BUILTIN.iter().map(|builtin| builtin.name).collect::<Vec<_>>().join(", ")
}

/// A bar for people only: none when the output goes to a file, a pipe or another program.
fn progress_bar(args: &RunArgs) -> ProgressBar {
    if args.json || !io::stdout().is_terminal() || !io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let style = ProgressStyle::with_template("{msg} {wide_bar} {pos}/{len} steps, {eta} left")
        .unwrap_or_else(|_| ProgressStyle::default_bar());
    ProgressBar::new(u64::from(args.steps)).with_style(style).with_message(args.scene.clone())
}
