//! `cellstep bisect`: where two runs parted, as a table or as JSON.

use crate::args::BisectArgs;
use crate::verify::progress_bar;
use crate::{DIVERGED, Failure, json, open, refusal, say};
use cellstep::replay::{Bisection, FieldDifference, Limits, Moment, Parting, bisect_self_with, bisect_with};
use cellstep::{BodyHandle, Pool, Serial};
use serde::Serialize;
use std::io::Write;

/// What was found. The names of the fields are the keys of the JSON object.
#[derive(Debug, Serialize)]
struct Found {
    result: &'static str,
    /// Steps that were compared, when nothing was found.
    #[serde(skip_serializing_if = "Option::is_none")]
    steps: Option<u64>,
    #[serde(flatten)]
    #[serde(skip_serializing_if = "Option::is_none")]
    parting: Option<Row>,
}

#[derive(Debug, Serialize)]
struct Row {
    step: u64,
    agreed: Option<u64>,
    stage: &'static str,
    stage_is: &'static str,
    runs: [&'static str; 2],
    field: Option<FieldRow>,
    field_step: u64,
    message: String,
}

#[derive(Debug, Serialize)]
struct FieldRow {
    bodies: Vec<[u32; 2]>,
    section: &'static str,
    row: usize,
    field: &'static str,
    component: usize,
    hex: [Option<String>; 2],
    decimal: [Option<String>; 2],
    bodies_that_differ: usize,
}

/// Finds and tells. Gives the exit code.
pub fn bisect(args: &BisectArgs, out: &mut impl Write) -> Result<u8, Failure> {
    let a = open(&args.a)?;
    let limits = Limits::default();
    let bar = progress_bar("bisect", "steps", a.last_step() - a.first_step());
    let progress = |step| bar.set_position(step);
    let found = match &args.b {
        Some(b) => bisect_with(&a, &open(b)?, &limits, progress),
        None => {
            let workers = usize::from(args.workers);
            let mut pool = Pool::new(workers).map_err(|error| format!("--workers {workers}: {error}"))?;
            bisect_self_with(&a, (&mut Serial, &mut pool), &limits, progress)
        }
    };
    bar.finish_and_clear();
    let found = found.map_err(|error| refusal(&args.a, &error))?;
    let code = if matches!(found, Bisection::Same { .. }) { 0 } else { DIVERGED };
    let text = match &found {
        _ if args.json => json(&row(&found))?,
        Bisection::Same { steps } => format!("no difference in {steps} steps\n"),
        Bisection::Parted(parting) => parting.to_string(),
    };
    say(out, &text, code)
}

fn row(found: &Bisection) -> Found {
    match found {
        Bisection::Same { steps } => Found { result: "same", steps: Some(*steps), parting: None },
        Bisection::Parted(parting) => Found { result: "parted", steps: None, parting: Some(of(parting)) },
    }
}

fn of(parting: &Parting) -> Row {
    Row {
        step: parting.step,
        agreed: parting.agreed,
        stage: parting.moment.name(),
        stage_is: match parting.moment {
            Moment::Stage(_) => "observed",
            Moment::LastWriter(_) => "last writer",
            _ => "no stage",
        },
        runs: parting.runs.map(|run| run.name()),
        field: parting.field.as_ref().map(field),
        field_step: parting.field_step,
        message: parting.message.clone(),
    }
}

fn field(found: &FieldDifference) -> FieldRow {
    let names = |body: &BodyHandle| [body.index, body.generation];
    FieldRow {
        bodies: found.bodies.iter().flatten().map(names).collect(),
        section: found.section,
        row: found.row,
        field: found.field,
        component: found.component,
        hex: found.bits.map(|bits| bits.map(|bits| found.hex(bits))),
        decimal: found.bits.map(|bits| bits.map(|bits| found.decimal(bits))),
        bodies_that_differ: found.bodies_that_differ,
    }
}
