//! `cellstep inspect`: what is in a replay.

use crate::args::InspectArgs;
use crate::{Failure, json, open};
use cellstep::BEHAVIOUR_VERSION;
use cellstep::replay::{FORMAT_VERSION, Replay};
use serde::Serialize;
use std::collections::BTreeMap;
use std::fmt::Write;

/// What is in a replay. The names of the fields are the keys of the JSON object.
#[derive(Debug, Serialize)]
struct Contents {
    file: String,
    note: String,
    bytes: usize,
    format_version: u32,
    behaviour_version: u32,
    layout_hash: String,
    assets_hash: String,
    assets: usize,
    asset_bytes: usize,
    capacities: BTreeMap<&'static str, u32>,
    first_step: u64,
    last_step: u64,
    complete: bool,
    cut_bytes: usize,
    checksums_every: u32,
    checksums: usize,
    keyframes_every: u32,
    keyframes: Vec<KeyframeRow>,
    commands: BTreeMap<String, u64>,
    refused: u64,
    last_checksum: Option<String>,
}

#[derive(Debug, Serialize)]
struct KeyframeRow {
    step: u64,
    after: u32,
    cause: &'static str,
    bytes: usize,
}

/// The text for standard output.
pub fn inspect(args: &InspectArgs) -> Result<String, Failure> {
    let replay = open(&args.file)?;
    if let Some(step) = args.step {
        return Ok(commands(&replay, step));
    }
    let contents = contents(args, &replay);
    if args.json { json(&contents) } else { Ok(table(&contents)) }
}

fn commands(replay: &Replay, step: u64) -> String {
    let mut text = String::new();
    for (index, command) in replay.commands(step - 1).enumerate() {
        let outcome = if command.is_refused { "refused" } else { "accepted" };
        let _ = writeln!(text, "{index:>5} {outcome:<8} {:?}", command.command);
    }
    text
}

fn contents(args: &InspectArgs, replay: &Replay) -> Contents {
    let options = replay.options();
    let (mut commands, mut refused) = (BTreeMap::new(), 0);
    for command in (replay.first_step()..replay.last_step()).flat_map(|step| replay.commands(step)) {
        let text = format!("{:?}", command.command);
        let name = text.split('(').next().unwrap_or_default();
        *commands.entry(name.to_string()).or_default() += 1;
        refused += u64::from(command.is_refused);
    }
    let row = |keyframe: cellstep::replay::Keyframe<'_>| KeyframeRow {
        step: keyframe.step,
        after: keyframe.after,
        cause: keyframe.cause.name(),
        bytes: keyframe.snapshot.len(),
    };
    Contents {
        file: args.file.to_string_lossy().into_owned(),
        note: options.note,
        bytes: replay.bytes(),
        // Others are refused.
        format_version: FORMAT_VERSION,
        behaviour_version: BEHAVIOUR_VERSION,
        layout_hash: format!("{:016x}", replay.layout_hash()),
        assets_hash: format!("{:016x}", replay.assets_hash()),
        assets: replay.assets().0,
        asset_bytes: replay.assets().1,
        capacities: replay.named_capacities().filter(|(_, count)| *count > 0).collect(),
        first_step: replay.first_step(),
        last_step: replay.last_step(),
        complete: replay.is_finished(),
        cut_bytes: replay.cut_bytes(),
        checksums_every: options.checksums_every,
        checksums: replay.checksums().count(),
        keyframes_every: options.keyframes_every,
        keyframes: replay.keyframes().map(row).collect(),
        commands,
        refused,
        last_checksum: replay.checksums().last().map(|sums| format!("{:016x}", sums.total)),
    }
}

fn table(contents: &Contents) -> String {
    let mut text = String::new();
    let mut row = |name: &str, value: &dyn std::fmt::Display| {
        // Writing to a string does not fail.
        let _ = writeln!(text, "{name:<20} {value}");
    };
    row("file", &contents.file);
    row("note", &contents.note);
    row("bytes", &contents.bytes);
    row("format version", &contents.format_version);
    row("behaviour version", &contents.behaviour_version);
    row("layout hash", &contents.layout_hash);
    row("assets hash", &contents.assets_hash);
    row("assets", &format!("{}, {} bytes", contents.assets, contents.asset_bytes));
    for (name, count) in &contents.capacities {
        row("capacity", &format!("{name} {count}"));
    }
    row("steps", &format!("{} to {}", contents.first_step, contents.last_step));
    let end = match contents.cut_bytes {
        0 if contents.complete => "complete".to_string(),
        0 => "not finished".to_string(),
        cut => format!("cut off: {cut} bytes after the last whole record"),
    };
    row("end", &end);
    row("checksums", &format!("{}, every {} steps", contents.checksums, contents.checksums_every));
    row("last checksum", &contents.last_checksum.as_deref().unwrap_or("none"));
    for keyframe in &contents.keyframes {
        let KeyframeRow { step, after, cause, bytes } = keyframe;
        let commands = if *after > 0 { format!(" and {after} commands") } else { String::new() };
        row("keyframe", &format!("after step {step}{commands}, {cause}, {bytes} bytes"));
    }
    for (name, count) in &contents.commands {
        row("commands", &format!("{name} {count}"));
    }
    row("refused commands", &contents.refused);
    text
}
