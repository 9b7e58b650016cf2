//! What is printed.

use crate::Entrant;
use crate::clock::Spent;
use crate::gauge::Overlap;
use crate::scenes::Scene;
use crate::{RUN, SETTLED};

pub fn print(scene: &Scene, steps: u32, entrants: &[Entrant]) {
    let joined = match scene.joints.len() {
        0 => String::new(),
        joints => format!(", {joints} joints"),
    };
    let after = match scene.warm_up {
        0 => String::new(),
        steps => format!(" after {steps} that are not timed"),
    };
    let (name, moving) = (scene.name, scene.moving());
    println!("\n{name}: {moving} moving bodies{joined}, {steps} steps in runs of {RUN}{after}");
    println!("{:34}{:>9}{:>9}{:>9}", "ms/step", "median", "mean", "thread");
    for entrant in entrants {
        let wall = walls(&entrant.runs);
        let mean = wall.iter().sum::<f64>() / wall.len() as f64;
        let thread: Option<Vec<f64>> = entrant.runs.iter().map(|run| run.thread).collect();
        let thread = thread.map_or("-".to_string(), |times| format!("{:.3}", median(times)));
        println!("{:34}{:9.3}{mean:9.3}{thread:>9}", entrant.engine.name(), median(wall));
    }
    ratios(entrants);
    if scene.joints.is_empty() {
        overlaps(entrants);
    } else {
        gaps(entrants);
    }
    for entrant in entrants {
        println!("{}: {}", entrant.engine.name(), entrant.engine.settings());
        entrant.engine.notes().iter().for_each(|note| println!("  {note}"));
    }
}

fn overlaps(entrants: &[Entrant]) {
    println!("overlap, mm, from step {SETTLED} on, same ruler for all: worst max and p99, then at the end");
    println!(
        "{:34}{:>9}{:>9}{:>9}{:>9}{:>9}{:>9}{:>9}{:>11}",
        "", "max", "p99", "max", "p99", "mean", "pairs", "own max", "height, m"
    );
    for entrant in entrants {
        let worst =
            |part: fn(&Overlap) -> f32| entrant.samples.iter().map(part).fold(0.0, cellstep::math::max) * 1e3;
        let last = entrant.samples.last().copied().unwrap_or_default();
        println!(
            "{:34}{:9.2}{:9.2}{:9.2}{:9.2}{:9.2}{:9}{:9.2}{:11.3}",
            entrant.engine.name(),
            worst(|sample| sample.max),
            worst(|sample| sample.p99),
            last.max * 1e3,
            last.p99 * 1e3,
            last.mean * 1e3,
            last.pairs,
            entrant.engine.own_overlap() * 1e3,
            last.height
        );
    }
}

/// Gaps of joints, and cellstep's as shares of each engine's.
fn gaps(entrants: &[Entrant]) {
    println!("gaps of joints, m, at the end, same ruler for all; then the shares of 1 worker / engine");
    let [p50, p99, max] = ["p50", "p99", "max"];
    println!(
        "{:34}{p50:>11}{p99:>11}{max:>11}{:>11}{:>11}{p50:>9}{p99:>9}{max:>9}",
        "", "own max", "height, m"
    );
    let first = entrants.first().and_then(|entrant| entrant.gaps);
    for entrant in entrants {
        let (Some(gaps), Some(first)) = (entrant.gaps, first) else { continue };
        let own = entrant.engine.own_gap().map_or("-".to_string(), |gap| format!("{gap:.2e}"));
        println!(
            "{:34}{:11.2e}{:11.2e}{:11.2e}{own:>11}{:11.3}{:9.3}{:9.3}{:9.3}",
            entrant.engine.name(),
            gaps.p50,
            gaps.p99,
            gaps.max,
            gaps.height,
            first.p50 / gaps.p50,
            first.p99 / gaps.p99,
            first.max / gaps.max
        );
    }
}

/// cellstep's runs against the runs of the same turn, medians.
fn ratios(entrants: &[Entrant]) {
    let [one, others @ ..] = entrants else { return };
    for other in others {
        let wall = paired(&walls(&one.runs), &walls(&other.runs));
        let thread =
            |entrant: &Entrant| entrant.runs.iter().map(|run| run.thread).collect::<Option<Vec<f64>>>();
        let by_thread = match (thread(one), thread(other)) {
            (Some(a), Some(b)) => format!("{:9.3}", paired(&a, &b)),
            _ => String::new(),
        };
        println!("{:34}{wall:9.3}{:9}{by_thread}", format!("1 worker / {}", other.engine.name()), "");
    }
}

fn walls(runs: &[Spent]) -> Vec<f64> {
    runs.iter().map(|run| run.wall).collect()
}

fn paired(a: &[f64], b: &[f64]) -> f64 {
    median(a.iter().zip(b).map(|(a, b)| a / b).collect())
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    let middle = values.len() / 2;
    if values.len() % 2 == 1 { values[middle] } else { 0.5 * (values[middle - 1] + values[middle]) }
}
