//! What the command line may say.

use clap::{Args, Parser, Subcommand};
use std::path::PathBuf;

const EXAMPLES: &str = "\
Examples:
  cellstep run pyramid                      the built-in pyramid of 5,050 boxes, 300 steps
  cellstep run mixed_pile --size 5000 --workers 2 --json
  cellstep scene wall --size 10 > wall.json && cellstep run wall.json
  cellstep import model.xml -o model.json

Exit codes: 0 done, 2 wrong usage or a wrong scene.";

/// Runs scenes of rigid bodies, with the same bits for any number of workers.
#[derive(Debug, Parser)]
#[command(name = "cellstep", version, about, after_help = EXAMPLES)]
pub struct Cli {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

/// The subcommands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Steps a scene and reports times, counts and the checksum.
    Run(RunArgs),
    /// Lists the built-in scenes.
    Scenes,
    /// Prints a built-in scene as a JSON document.
    Scene(SceneArgs),
    /// Turns a model in MJCF, MuJoCo's XML format, into a scene document.
    Import(ImportArgs),
}

const RUN_HELP: &str = "\
Times are means per step. A stage's time is wall-clock from its start to the next stage's; `serial` is the
part of the whole step, over all stages, that runs on one thread. Counts are those of the last step; drops
and quarantines are totals; barriers are the mean per step. The state's size is that of a snapshot.

Examples:
  cellstep run tower --steps 600
  cellstep run level.json --workers 4 --substeps 8
  cellstep run pyramid --size 20 --json | jq .checksum";

/// Arguments of `run`.
#[derive(Args, Debug)]
#[command(after_help = RUN_HELP)]
pub struct RunArgs {
    /// A scene file (JSON, see SCENES.md), a model (MJCF, `.xml`), or the name of a built-in scene.
    pub scene: String,
    /// Number of steps.
    #[arg(long, default_value_t = 300, value_name = "N")]
    pub steps: u32,
    /// Number of threads, this one included [default: one for each processor].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=256))]
    pub workers: Option<u16>,
    /// Substeps of each step [default: as the scene says].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=256))]
    pub substeps: Option<u32>,
    /// Size of a built-in scene; `cellstep scenes` says what it counts [default: the scene's own].
    #[arg(long, value_name = "N")]
    pub size: Option<u32>,
    /// Print one JSON object and nothing else.
    #[arg(long)]
    pub json: bool,
}

const SCENE_HELP: &str = "\
Examples:
  cellstep scene bowls > bowls.json
  cellstep scene tower --size 3";

/// Arguments of `scene`.
#[derive(Args, Debug)]
#[command(after_help = SCENE_HELP)]
pub struct SceneArgs {
    /// Name of a built-in scene.
    pub name: String,
    /// Its size [default: the scene's own].
    #[arg(long, value_name = "N")]
    pub size: Option<u32>,
}

const IMPORT_HELP: &str = "\
What the model says and a scene does not have is told on standard error: a warning for each kind of element or
attribute that changes how bodies move, notes for the others. Files that the model names must lie below its
folder.

Examples:
  cellstep import model.xml -o model.json
  cellstep import model.xml | jq .bodies";

/// Arguments of `import`.
#[derive(Args, Debug)]
#[command(after_help = IMPORT_HELP)]
pub struct ImportArgs {
    /// The model's file.
    pub file: PathBuf,
    /// Where the scene goes [default: standard output].
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
}
