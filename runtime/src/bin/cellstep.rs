//! The command `cellstep`: runs scenes, lists and prints the built-in ones, imports models.
//!
//! Standard output has the answer and nothing else; the progress bar, notes and errors go to standard error.
//! A reader that closes the pipe early gets what it wanted: that is no error.

#[path = "../cli/args.rs"]
mod args;
#[path = "../cli/import.rs"]
mod import;
#[path = "../cli/report.rs"]
mod report;
#[path = "../cli/run.rs"]
mod run;

use args::{Cli, Command};
use cellstep::scene::builtin::BUILTIN;
use clap::Parser;
use std::fmt::Write as _;
use std::io::{self, Write};
use std::process::ExitCode;

/// Wrong usage, or a wrong scene; clap uses the same number.
const WRONG: u8 = 2;
/// Standard output could not be written.
const NO_OUTPUT: u8 = 1;

fn main() -> ExitCode {
    let cli = Cli::parse();
    let text = match answer(&cli.command) {
        Ok(text) => text,
        Err(message) => {
            let _ = writeln!(io::stderr(), "error: {message}");
            return ExitCode::from(WRONG);
        }
    };
    let mut out = io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => {
            let _ = writeln!(io::stderr(), "error: cannot write to standard output: {error}");
            ExitCode::from(NO_OUTPUT)
        }
        _ => ExitCode::SUCCESS,
    }
}

/// The text for standard output, or a message for the user.
fn answer(command: &Command) -> Result<String, String> {
    match command {
        Command::Run(args) => {
            let report = run::run(args)?;
            if !args.json {
                return Ok(report.to_string());
            }
            serde_json::to_string(&report).map(|json| json + "\n").map_err(|error| error.to_string())
        }
        Command::Scenes => Ok(scenes()),
        Command::Scene(args) => Ok(run::builtin(&args.name, args.size)?.to_json()),
        Command::Import(args) => import::import(args),
    }
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
