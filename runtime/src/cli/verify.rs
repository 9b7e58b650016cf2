//! `cellstep verify`: many replays on many threads, and a line for each in their order.

use crate::args::VerifyArgs;
use crate::run::processors;
use crate::{CORRUPT, DIVERGED, Failure, VERSION, WRONG, json, say};
use cellstep::replay::{Difference, ErrorKind, Limits, Replay, ReplayError, Verdict, verify_with};
use cellstep::{Serial, xxh64};
use indicatif::{ProgressBar, ProgressStyle};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::io::{self, BufRead, IsTerminal, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc;

/// What came of a replay.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Outcome {
    /// The same bits.
    Same,
    /// Others.
    Diverged,
    /// Damaged, or no replay.
    Corrupt,
    /// Of another version.
    Version,
    /// The file cannot be read, or its world is too large.
    Unreadable,
}

/// A replay's line. The names of the fields are the keys.
#[derive(Debug, Serialize)]
pub struct Line {
    /// Place in the list, from 0.
    pub index: usize,
    /// The path as it was named.
    pub file: String,
    /// What came of it.
    pub result: Outcome,
    /// Steps of the replay.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub steps: Option<u64>,
    /// Whether the recording was finished, and not cut off.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub complete: Option<bool>,
    /// Checksums and keyframes that agree.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub compared: Option<u64>,
    /// Steps after which it diverged.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub step: Option<u64>,
    /// Sections of the state that differ there.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub sections: Vec<&'static str>,
    /// What went wrong, for people.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub message: Option<String>,
}

/// How many came out how.
#[derive(Clone, Debug, Default, Deserialize, PartialEq, Eq, Serialize)]
pub struct Summary {
    /// Which shard it is, from 0.
    pub shard: u32,
    /// Of how many.
    pub shards: u32,
    /// Replays in the whole list.
    pub files: usize,
    /// Hash of the list, 16 hexadecimal digits.
    pub list: String,
    /// Same bits.
    pub same: usize,
    /// Others.
    pub diverged: usize,
    /// Damaged, or no replay.
    pub corrupt: usize,
    /// Of another version.
    pub version: usize,
    /// Not readable.
    pub unreadable: usize,
}

/// The last line.
#[derive(Debug, Deserialize, Serialize)]
pub struct LastLine {
    /// The counts.
    pub summary: Summary,
}

impl Summary {
    /// Counts a replay.
    pub fn count(&mut self, outcome: Outcome) {
        *match outcome {
            Outcome::Same => &mut self.same,
            Outcome::Diverged => &mut self.diverged,
            Outcome::Corrupt => &mut self.corrupt,
            Outcome::Version => &mut self.version,
            Outcome::Unreadable => &mut self.unreadable,
        } += 1;
    }

    /// The exit code.
    pub fn code(&self) -> u8 {
        match self {
            Summary { diverged: 1.., .. } => DIVERGED,
            Summary { corrupt: 1.., .. } => CORRUPT,
            Summary { version: 1.., .. } => VERSION,
            Summary { unreadable: 1.., .. } => WRONG,
            _ => 0,
        }
    }
}

/// Plays the replays of a list, or of a shard of it. Gives the exit code.
pub fn verify(args: &VerifyArgs, out: &mut impl Write) -> Result<u8, Failure> {
    let list = list(args)?;
    let (shard, shards) = args.shard.unwrap_or((0, 1));
    let own: Vec<usize> = (shard as usize..list.len()).step_by(shards as usize).collect();
    let mut summary =
        Summary { shard, shards, files: list.len(), list: hash_of(&list), ..Summary::default() };
    let workers = args.workers.map_or_else(processors, usize::from).min(own.len().max(1));
    let what = if own.len() == 1 { "steps" } else { "replays" };
    let bar = progress_bar("verify", what, own.len() as u64);
    let limits = Limits { world_bytes: args.memory.saturating_mul(1 << 20) };
    let (next, (sender, receiver)) = (AtomicUsize::new(0), mpsc::channel());
    std::thread::scope(|scope| {
        for _ in 0..workers {
            let (sender, next, own, list, bar) = (sender.clone(), &next, &own, &list, &bar);
            let limits = &limits;
            scope.spawn(move || {
                while let Some(&index) = own.get(next.fetch_add(1, Ordering::Relaxed)) {
                    let line = line(index, &list[index], limits, (bar, own.len() == 1));
                    if sender.send(line).is_err() {
                        // Nobody reads any more.
                        return;
                    }
                }
            });
        }
        drop(sender);
        let mut waiting = BTreeMap::new();
        let mut order = own.iter();
        let mut due = order.next();
        for line in receiver {
            waiting.insert(line.index, line);
            while let Some(line) = due.and_then(|index| waiting.remove(index)) {
                summary.count(line.result);
                let text = json(&line)?;
                bar.suspend(|| say(out, &text, 0))?;
                due = order.next();
            }
        }
        Ok::<(), Failure>(())
    })?;
    bar.finish_and_clear();
    let code = summary.code();
    say(out, &json(&LastLine { summary })?, code)
}

/// Paths of the command line, then those of the list.
fn list(args: &VerifyArgs) -> Result<Vec<PathBuf>, Failure> {
    let mut list = args.files.clone();
    let Some(file) = &args.list else { return Ok(list) };
    let refused = |error: io::Error| format!("{}: {error}", file.display());
    let text = if file == Path::new("-") {
        let lines: Result<Vec<String>, _> = io::stdin().lock().lines().collect();
        lines.map_err(refused)?
    } else {
        let text = std::fs::read_to_string(file).map_err(refused)?;
        text.lines().map(str::to_string).collect()
    };
    list.extend(text.into_iter().filter(|line| !line.is_empty()).map(PathBuf::from));
    Ok(list)
}

/// Shards of one list have the same.
fn hash_of(list: &[PathBuf]) -> String {
    let sum = list.iter().fold(0, |sum, path| xxh64(path.to_string_lossy().as_bytes(), sum));
    format!("{sum:016x}")
}

/// Plays one replay.
fn line(index: usize, path: &Path, limits: &Limits, (bar, is_alone): (&ProgressBar, bool)) -> Line {
    let file = path.to_string_lossy().into_owned();
    let mut line = Line {
        index,
        file,
        result: Outcome::Same,
        steps: None,
        complete: None,
        compared: None,
        step: None,
        sections: Vec::new(),
        message: None,
    };
    let verdict = Replay::open(path).and_then(|replay| {
        let steps = replay.last_step() - replay.first_step();
        (line.steps, line.complete) = (Some(steps), Some(replay.is_finished()));
        if is_alone {
            bar.set_length(steps);
        }
        verify_with(&replay, &mut Serial, limits, |step| {
            if is_alone {
                bar.set_position(step);
            }
        })
    });
    if !is_alone {
        bar.inc(1);
    }
    match verdict {
        Ok(Verdict::Same { compared, .. }) => line.compared = Some(compared),
        Ok(Verdict::Diverged(divergence)) => {
            line.result = Outcome::Diverged;
            line.message = Some(divergence.to_string());
            line.step = Some(divergence.step);
            line.sections = match divergence.difference {
                Difference::Checksum { sections, .. }
                | Difference::Keyframe { sections }
                | Difference::Unrecorded { sections, .. } => sections,
                _ => Vec::new(),
            };
        }
        Err(error) => {
            line.result = outcome_of(&error);
            line.message = Some(error.to_string());
        }
    }
    line
}

fn outcome_of(error: &ReplayError) -> Outcome {
    match error.kind() {
        ErrorKind::Usage => Outcome::Unreadable,
        ErrorKind::Corrupt => Outcome::Corrupt,
        ErrorKind::Version => Outcome::Version,
    }
}

/// A bar for people only.
pub fn progress_bar(call: &str, what: &str, length: u64) -> ProgressBar {
    if !io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let template = format!("{call} {{wide_bar}} {{pos}}/{{len}} {what}, {{eta}} left");
    let style = ProgressStyle::with_template(&template).unwrap_or_else(|_| ProgressStyle::default_bar());
    ProgressBar::new(length).with_style(style)
}
