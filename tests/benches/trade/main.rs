//! The trade of speed for accuracy: what cellstep's presets and knobs cost and how wrong they are, beside
//! `rapier3d` and Box3D at default and at swept settings.
//!
//! `cargo bench -p cellstep-tests --features peers --bench trade -- [--scene NAME] [--write FOLDER]`
//!
//! Twelve scenes (`scenes.rs`), each with a headline error against a closed form, a known end or what has to stand,
//! and further errors that are told beside it and never added up. Cost is that of whole steps on one thread, ns per
//! moving body and simulated second, the median of turns that all configurations take in one process. Physics are
//! equal: the same shapes, masses, friction and restitution, no damping, sleep off, the same length of a step. All
//! configurations are told with their settings.
//!
//! Told are a table for each scene, then the verdict against each peer (`cellstep_tests::trade`). CSV and plots
//! (SVG) are written below the target folder. With `--write docs/trade` the plots are written there, from the
//! repository's folder, and the README gets plot, preset table and verdict; that takes all scenes.
//!
//! Counts of instructions, which repeat exactly, come from callgrind, by the difference of two runs of one
//! configuration without measuring: `--run SCENE CONFIGURATION STEPS`, with the name from the table:
//!
//! ```text
//! cargo bench -p cellstep-tests --features peers --bench trade --no-run
//! for steps in 10 110; do
//!     valgrind --tool=callgrind --callgrind-out-file=out.$steps \
//!         target/release/deps/trade-HASH --run pile "cellstep balanced" $steps
//! done
//! grep totals out.10 out.110
//! ```

#[cfg(feature = "peers")]
mod box3d;
mod engine;
mod measure;
mod own;
mod plots;
#[cfg(feature = "peers")]
mod rapier;
mod report;
mod scene;
mod scenes;
mod table;

use scene::Scene;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

/// What was asked for.
enum Task {
    /// Scenes to measure, and the folder in the repository to write to.
    Measure(Vec<Scene>, Option<PathBuf>),
    /// A configuration to step, and how often.
    Run(Scene, String, u32),
}

fn arguments() -> Result<Task, String> {
    let (mut scenes, mut folder) = (scenes::all(), None);
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        let mut value = || arguments.next().ok_or(format!("{argument} needs a value"));
        match argument.as_str() {
            "--bench" => {}
            "--scene" => scenes = vec![named(scenes, &value()?)?],
            "--write" => folder = Some(PathBuf::from(value()?)),
            "--run" => {
                let (scene, config, steps) = (named(scenes, &value()?)?, value()?, value()?);
                let steps = steps.parse().map_err(|_| format!("{steps}: expected a number of steps"))?;
                return Ok(Task::Run(scene, config, steps));
            }
            _ => return Err(format!("unknown argument {argument}: expected --scene, --write, --run")),
        }
    }
    if folder.is_some() && scenes.len() == 1 {
        return Err("--write takes all scenes: the README has a row for each".to_string());
    }
    Ok(Task::Measure(scenes, folder))
}

fn named(scenes: Vec<Scene>, name: &str) -> Result<Scene, String> {
    let names: Vec<&str> = scenes.iter().map(|scene| scene.name).collect();
    let error = format!("no scene {name}: expected one of {}", names.join(", "));
    scenes.into_iter().find(|scene| scene.name == name).ok_or(error)
}

/// Steps one configuration, for a profiler.
fn run(scene: &Scene, name: &str, steps: u32) -> Result<(), String> {
    let configs = engine::configs(scene);
    let config = configs.iter().find(|config| config.full_name() == name);
    let names: Vec<String> = configs.iter().map(engine::Config::full_name).collect();
    let config = config.ok_or(format!("no configuration {name}: expected one of\n{}", names.join("\n")))?;
    let mut engine = (config.make)(&scene.setup);
    (0..steps).for_each(|_| engine.step());
    Ok(())
}

/// The folder of the repository: cargo starts benches in that of their package.
fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("the package lies in the workspace")
}

fn measure(scenes: Vec<Scene>, written: Option<&Path>) {
    let start = Instant::now();
    let mut all = Vec::new();
    for scene in scenes {
        let outcome = measure::measure(scene);
        table::print(&outcome);
        all.push(outcome);
    }
    table::print_verdicts(&all);
    let below_target = Path::new(env!("CARGO_TARGET_TMPDIR")).with_file_name("trade");
    let folder = written.map_or(below_target.clone(), |folder| root().join(folder));
    for folder in [&below_target, &folder] {
        std::fs::create_dir_all(folder).expect("the folder can be made");
    }
    println!();
    println!("{}", report::write_csv(&below_target, &all).display());
    for path in plots::write(&folder, &all) {
        println!("{}", path.display());
    }
    if let Some(written) = written {
        let plots = written.to_string_lossy().replace('\\', "/");
        report::write_readme(&root().join("README.md"), &plots, &all);
        println!("{}", root().join("README.md").display());
    }
    println!("{:.0} s", start.elapsed().as_secs_f64());
}

fn main() -> ExitCode {
    let outcome = arguments().and_then(|task| match task {
        Task::Measure(scenes, written) => {
            measure(scenes, written.as_deref());
            Ok(())
        }
        Task::Run(scene, name, steps) => run(&scene, &name, steps),
    });
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::from(2)
        }
    }
}
