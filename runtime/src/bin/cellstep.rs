//! The command `cellstep`: runs scenes, lists and prints the built-in ones, recommends settings for them, imports
//! models, verifies replays, and compares this machine with the release.
//!
//! Standard output has the answer and nothing else; the progress bar, notes and errors go to standard error.
//! A reader that closes the pipe early gets what it wanted: that is no error.

#[path = "../cli/args.rs"]
mod args;
#[path = "../cli/bisect.rs"]
mod bisect;
#[path = "../cli/doctor.rs"]
mod doctor;
#[path = "../cli/import.rs"]
mod import;
#[path = "../cli/inspect.rs"]
mod inspect;
#[path = "../cli/merge.rs"]
mod merge;
#[path = "../cli/report.rs"]
mod report;
#[path = "../cli/run.rs"]
mod run;
#[path = "../cli/tune.rs"]
mod tune;
#[path = "../cli/verify.rs"]
mod verify;

use args::{Cli, Command};
use cellstep::replay::{ErrorKind, Replay, ReplayError};
use cellstep::scene::builtin::BUILTIN;
use clap::Parser;
use std::fmt::Write as _;
use std::io::{self, Write};
use std::process::ExitCode;

/// One replay diverged, or this machine has other bits; or standard output could not be written.
const DIVERGED: u8 = 1;
/// Wrong usage, or a wrong scene; clap uses the same number.
const WRONG: u8 = 2;
/// A replay is corrupt.
const CORRUPT: u8 = 3;
/// A replay is of another version.
const VERSION: u8 = 4;

/// No setting meets the goal of `tune`.
const UNMET: u8 = 5;

/// Why there is no answer: the exit code, and a message for the user.
struct Failure(u8, String);

impl From<String> for Failure {
    fn from(message: String) -> Self {
        Failure(WRONG, message)
    }
}

fn main() -> ExitCode {
    let cli = Cli::parse();
    let mut out = io::stdout().lock();
    let code = match answer(&cli.command, &mut out) {
        Ok(code) => code,
        Err(Failure(code, message)) => {
            let _ = writeln!(io::stderr(), "error: {message}");
            code
        }
    };
    ExitCode::from(code)
}

/// Writes text to standard output, and gives the exit code.
fn say(out: &mut impl Write, text: &str, code: u8) -> Result<u8, Failure> {
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => {
            Err(Failure(DIVERGED, format!("cannot write to standard output: {error}")))
        }
        _ => Ok(code),
    }
}

/// Answers on standard output; gives the exit code.
fn answer(command: &Command, out: &mut impl Write) -> Result<u8, Failure> {
    match command {
        Command::Run(args) => {
            let report = run::run(args)?;
            if !args.json {
                return say(out, &report.to_string(), 0);
            }
            say(out, &json(&report)?, 0)
        }
        Command::Scenes => say(out, &scenes(), 0),
        Command::Scene(args) => say(out, &run::builtin(&args.name, args.size)?.to_json(), 0),
        Command::Import(args) => say(out, &import::import(args)?, 0),
        Command::Verify(args) if args.merge => merge::merge(args, out),
        Command::Verify(args) => verify::verify(args, out),
        Command::Bisect(args) => bisect::bisect(args, out),
        Command::Doctor(args) => doctor::doctor(args, out),
        Command::Tune(args) => tune::tune(args, out),
        Command::Inspect(args) => say(out, &inspect::inspect(args)?, 0),
    }
}

/// A line of JSON.
fn json(value: &impl serde::Serialize) -> Result<String, Failure> {
    Ok(serde_json::to_string(value).map_err(|error| error.to_string())? + "\n")
}

/// Reads a replay, or says why not.
fn open(path: &std::path::Path) -> Result<Replay, Failure> {
    Replay::open(path).map_err(|error| refusal(path, &error))
}

/// Why a replay cannot be played.
fn refusal(path: &std::path::Path, error: &ReplayError) -> Failure {
    let code = match error.kind() {
        ErrorKind::Usage => WRONG,
        ErrorKind::Corrupt => CORRUPT,
        ErrorKind::Version => VERSION,
    };
    Failure(code, format!("{}: {error}", path.display()))
}

/// A table of the built-in scenes.
fn scenes() -> String {
    let mut text = format!("{:<16} {:>7} {:>7}  description\n", "name", "default", "largest");
    for builtin in BUILTIN {
        let (name, size, most) = (builtin.name, builtin.default_size, builtin.size_max);
        // Writing to a string does not fail.
        let _ = writeln!(text, "{name:<16} {size:>7} {most:>7}  {}", builtin.description);
    }
    text
}
