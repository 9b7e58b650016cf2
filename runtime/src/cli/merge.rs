//! `cellstep verify --merge`: the outputs of all shards become that of one run.

use crate::args::VerifyArgs;
use crate::verify::{LastLine, Outcome, Summary};
use crate::{Failure, json, say};
use serde::Deserialize;
use std::collections::BTreeMap;
use std::io::Write;
use std::path::Path;

/// What has to be known of a replay's line.
#[derive(Deserialize)]
struct Known {
    index: usize,
    result: Outcome,
}

/// The output of a shard.
struct Shard {
    lines: Vec<(Known, String)>,
    summary: Summary,
}

/// Prints the lines of all shards in the order of the list. Gives the exit code of the whole.
pub fn merge(args: &VerifyArgs, out: &mut impl Write) -> Result<u8, Failure> {
    let mut shards = BTreeMap::new();
    for path in &args.files {
        let shard = read(path)?;
        let number = shard.summary.shard;
        if shards.insert(number, shard).is_some() {
            return Err(format!("{}: shard {number} is there twice", path.display()).into());
        }
    }
    let Some(first) = shards.values().next().map(|shard| shard.summary.clone()) else {
        return Err("no shard".to_string().into());
    };
    let mut merged =
        Summary { shard: 0, shards: 1, files: first.files, list: first.list.clone(), ..Summary::default() };
    for number in 0..first.shards {
        let Some(shard) = shards.get(&number) else {
            return Err(format!("shard {number} of {} is missing", first.shards).into());
        };
        let summary = &shard.summary;
        if (summary.shards, summary.files, &summary.list) != (first.shards, first.files, &first.list) {
            return Err(format!("shard {number} is of another list or number of shards").into());
        }
    }
    if shards.len() != first.shards as usize {
        return Err(format!("there are more than {} shards", first.shards).into());
    }
    let lines: BTreeMap<usize, (Known, String)> = shards
        .into_values()
        .flat_map(|shard| shard.lines)
        .map(|(known, text)| (known.index, (known, text)))
        .collect();
    if !lines.keys().copied().eq(0..first.files) {
        return Err("the lines are not those of the whole list".to_string().into());
    }
    let mut text = String::new();
    for (known, line) in lines.values() {
        merged.count(known.result);
        text += line;
        text.push('\n');
    }
    let code = merged.code();
    text += &json(&LastLine { summary: merged })?;
    say(out, &text, code)
}

/// Reads the output of a shard: it is whole when its last line is the summary of the lines before.
fn read(path: &Path) -> Result<Shard, Failure> {
    let wrong = |what: &str| Failure::from(format!("{}: {what}", path.display()));
    let text = std::fs::read_to_string(path).map_err(|error| wrong(&error.to_string()))?;
    let mut lines: Vec<&str> = text.lines().collect();
    let last = lines.pop().ok_or_else(|| wrong("it is empty"))?;
    let LastLine { summary } = serde_json::from_str(last)
        .map_err(|_| wrong("it does not end with a summary: the shard is not done"))?;
    let mut shard = Shard { lines: Vec::new(), summary };
    let mut counts =
        Summary { same: 0, diverged: 0, corrupt: 0, version: 0, unreadable: 0, ..shard.summary.clone() };
    for line in lines {
        let known: Known =
            serde_json::from_str(line).map_err(|error| wrong(&format!("a line is no result: {error}")))?;
        counts.count(known.result);
        if known.index % shard.summary.shards.max(1) as usize != shard.summary.shard as usize {
            return Err(wrong("a line is of another shard"));
        }
        shard.lines.push((known, line.to_string()));
    }
    if counts != shard.summary {
        return Err(wrong("its summary does not count its lines"));
    }
    Ok(shard)
}
