//! What the command line may say.

use cellstep::Preset;
use clap::{Args, Parser, Subcommand};
use std::path::PathBuf;

const EXAMPLES: &str = "\
Examples:
  cellstep run pyramid                      the built-in pyramid of 5,050 boxes, 300 steps
  cellstep run mixed_pile --size 5000 --workers 2 --json
  cellstep scene wall --size 10 > wall.json && cellstep run wall.json
  cellstep import model.xml -o model.json
  cellstep run ragdolls --record game.replay && cellstep verify game.replay

Exit codes: 0 done, 2 wrong usage or a wrong scene. Those of replays: see `cellstep verify --help`; 1 of `doctor`:
other bits than the release; 5 of `tune`: no setting meets the goal.";

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
    /// Plays replays and tells whether the same bits come out: a line of JSON for each.
    Verify(VerifyArgs),
    /// Finds where two runs parted: step, stage, body, field and both values.
    Bisect(BisectArgs),
    /// Tries settings between fast and exact on a scene, and recommends one.
    Tune(TuneArgs),
    /// Tells what is in a replay.
    Inspect(InspectArgs),
    /// Tells whether this machine computes the bits that the release was made with.
    Doctor(DoctorArgs),
}

const RUN_HELP: &str = "\
Times are means per step. A stage's time is wall-clock from its start to the next stage's; `serial` is the
part of the whole step, over all stages, that runs on one thread. Counts are those of the last step; drops
and quarantines are totals; barriers are the mean per step. The state's size is that of a snapshot. `settings` are
those of the run, as a scene file would say them.

Examples:
  cellstep run tower --steps 600
  cellstep run level.json --workers 4 --substeps 8
  cellstep run wall --preset accurate
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
    /// A place on the dial between speed and accuracy: fast, balanced, accurate or exact. It replaces what the
    /// scene says of substeps, sweeps and contacts [default: as the scene says].
    #[arg(long, value_name = "NAME", value_parser = preset)]
    pub preset: Option<Preset>,
    /// Substeps of each step [default: as the scene or the preset says].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=256))]
    pub substeps: Option<u32>,
    /// Size of a built-in scene; `cellstep scenes` says what it counts [default: the scene's own].
    #[arg(long, value_name = "N")]
    pub size: Option<u32>,
    /// Print one JSON object and nothing else.
    #[arg(long)]
    pub json: bool,
    /// Records a replay. Times then include the recording.
    #[arg(long, value_name = "FILE")]
    pub record: Option<PathBuf>,
    /// Steps from checksums to checksums of the replay; 0 for those at the end alone.
    #[arg(long, value_name = "K", default_value_t = 10, requires = "record")]
    pub checksums_every: u32,
    /// Steps from keyframe to keyframe of the replay; 0 for the first state alone.
    #[arg(long, value_name = "N", default_value_t = 600, requires = "record")]
    pub keyframes_every: u32,
}

/// A preset by its name.
fn preset(name: &str) -> Result<Preset, String> {
    let names = || Preset::ALL.map(Preset::name).join(", ");
    Preset::find(name).ok_or_else(|| format!("expected one of {}", names()))
}

const VERIFY_HELP: &str = "\
For each replay a line of JSON: `index` in the list, `file`, `result` (same, diverged, corrupt, version or
unreadable), and what there is to tell: `steps`, `complete`, `compared` checksums and keyframes, the `step` and
`sections` of a divergence, a `message`. The last line is a `summary`. The lines stand in the order of the list,
however many workers there are.

A shard takes each N-th replay of the list, from the I-th on, I being 0..N-1. `--merge` takes the outputs of all
shards and prints what one run over the whole list prints.

Exit codes: 0 all same, 1 one diverged, 3 one is corrupt, 4 one is of another version, 2 wrong usage or one cannot
be read; of several the first in this order.

Examples:
  cellstep verify *.replay --workers 8
  find . -name '*.replay' | sort | cellstep verify --list - --shard 3/16 > shard3.jsonl
  cellstep verify --merge shard*.jsonl";

/// Arguments of `verify`.
#[derive(Args, Debug)]
#[command(after_help = VERIFY_HELP)]
pub struct VerifyArgs {
    /// Replays; with --merge outputs of shards.
    #[arg(required_unless_present = "list")]
    pub files: Vec<PathBuf>,
    /// A file with a replay's path on each line, after those of the command line; `-` is standard input.
    #[arg(long, value_name = "FILE")]
    pub list: Option<PathBuf>,
    /// Replays that are played side by side [default: one for each processor].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=256))]
    pub workers: Option<u16>,
    /// Greatest memory of a replay's world, MiB: a file from a stranger may ask for any.
    #[arg(long, value_name = "MIB", default_value_t = 4096)]
    pub memory: u64,
    /// Plays a part of the list only.
    #[arg(long, value_name = "I/N", value_parser = shard)]
    pub shard: Option<(u32, u32)>,
    /// Puts the outputs of all shards of a list together.
    #[arg(long, conflicts_with_all = ["list", "workers", "shard"])]
    pub merge: bool,
}

/// `I/N` with I below N.
fn shard(text: &str) -> Result<(u32, u32), String> {
    let parts = text.split_once('/').and_then(|(i, n)| Some((i.parse().ok()?, n.parse().ok()?)));
    let expected = || "expected I/N with I from 0 to N - 1, as 0/4".to_string();
    parts.filter(|(index, count): &(u32, u32)| index < count).ok_or_else(expected)
}

const BISECT_HELP: &str = "\
Two replays of one game, recorded on two machines: plays the first one here, and says at which step the two tell
of different states, commands or outcomes. Where both have keyframes near, or this machine agrees with one of them,
it names the body and the field with both values.

With --against-self one replay: plays it twice side by side, on one thread and on several with all caches dropped
before each step, compares after each stage of each step, and both with what was recorded.

Exit codes: 0 no difference, 1 there is one, 2 wrong usage, 3 corrupt, 4 another version.

Examples:
  cellstep bisect mine.replay theirs.replay
  cellstep bisect game.replay --against-self --workers 8 --json";

/// Arguments of `bisect`.
#[derive(Args, Debug)]
#[command(after_help = BISECT_HELP)]
pub struct BisectArgs {
    /// A replay.
    pub a: PathBuf,
    /// Another replay of the same game.
    #[arg(required_unless_present = "against_self", conflicts_with = "against_self")]
    pub b: Option<PathBuf>,
    /// Compares the replay with itself.
    #[arg(long)]
    pub against_self: bool,
    /// Threads of the second of two runs.
    #[arg(long, value_name = "N", default_value_t = 3,
        value_parser = clap::value_parser!(u16).range(1..=256))]
    pub workers: u16,
    /// Print one JSON object and nothing else.
    #[arg(long)]
    pub json: bool,
}

const INSPECT_HELP: &str = "\
Exit codes: 0 done, 2 wrong usage, 3 corrupt, 4 another version.

Examples:
  cellstep inspect game.replay
  cellstep inspect game.replay --step 200";

/// Arguments of `inspect`.
#[derive(Args, Debug)]
#[command(after_help = INSPECT_HELP)]
pub struct InspectArgs {
    /// A replay.
    pub file: PathBuf,
    /// Prints the commands of this step and their outcomes, one a line, instead: those before the world's N-th
    /// step.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    pub step: Option<u64>,
    /// Print one JSON object and nothing else.
    #[arg(long, conflicts_with = "step")]
    pub json: bool,
}

const DOCTOR_HELP: &str = "\
Steps every built-in scene in a small size 300 times, on one thread and on several, and compares the checksums with
those of the release. Machine and build are told, too: to be added to a report of a difference.

Exit codes: 0 all the same, 1 one differs, 2 wrong usage.

Examples:
  cellstep doctor
  cellstep doctor --json | jq .matches";

/// Arguments of `doctor`.
#[derive(Args, Debug)]
#[command(after_help = DOCTOR_HELP)]
pub struct DoctorArgs {
    /// Threads of the second run [default: one for each processor, and at least 2].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=256))]
    pub workers: Option<u16>,
    /// Print one JSON object and nothing else.
    #[arg(long)]
    pub json: bool,
}

const TUNE_HELP: &str = "\
Runs the scene with every preset, with steps between them and with its own settings, and tells of each the median
time of a step and its errors, side by side:
  error    the headline, on which --max-error acts: the greatest of p99, gap and height
  p99, max overlap of points of contact: that of 99 in a hundred, and the deepest
  gap      how far joints are apart (99 in a hundred)
  height   how much higher or lower bodies lie than in the reference, lowest to highest, nine of ten; counted as way
  way      how far bodies are from where the reference has them, for as long as two references agree to a millimetre
  mm/s     speed over the last quarter: jitter, where all should rest
The reference is the preset `exact` with four times its substeps. Errors are the same for any number of workers and
on any machine, times are not. The last line is what the scene file has to say.

Exit codes: 0 a setting meets the goal, 2 wrong usage or a wrong scene, 5 none does; then it is told by how much the
nearest one misses it.

Examples:
  cellstep tune wall --max-error 0.002
  cellstep tune level.json --budget-ms 4 --workers 4 --steps 600
  cellstep tune model.xml --max-error 1e-3 --json | jq .recommended";

/// Arguments of `tune`.
#[derive(Args, Debug)]
#[command(after_help = TUNE_HELP)]
pub struct TuneArgs {
    /// A scene file (JSON, see SCENES.md), a model (MJCF, `.xml`), or the name of a built-in scene.
    pub scene: String,
    /// Recommends the most exact setting whose step takes at most so long, milliseconds (median).
    #[arg(long, value_name = "X", value_parser = positive, required_unless_present = "max_error",
        conflicts_with = "max_error")]
    pub budget_ms: Option<f64>,
    /// Recommends the cheapest setting whose error is at most so great, metres.
    #[arg(long, value_name = "E", value_parser = positive)]
    pub max_error: Option<f64>,
    /// Number of steps of each run.
    #[arg(long, default_value_t = 300, value_name = "N",
        value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub steps: u32,
    /// Number of threads, this one included [default: one for each processor].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=256))]
    pub workers: Option<u16>,
    /// Size of a built-in scene; `cellstep scenes` says what it counts [default: the scene's own].
    #[arg(long, value_name = "N")]
    pub size: Option<u32>,
    /// Print one JSON object and nothing else.
    #[arg(long)]
    pub json: bool,
}

/// A finite number above 0.
fn positive(text: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|number: &f64| number.is_finite() && *number > 0.0);
    number.ok_or_else(|| "expected a number greater than 0".to_string())
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
