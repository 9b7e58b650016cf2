//! The tables in the terminal.

use crate::engine::ENGINES;
use crate::measure::{Measured, Outcome};
use crate::own;
use cellstep_tests::trade::{Verdict, frontier, verdict};

/// By how much the worst ratio may be above 1 (issue's bound).
const WORSE: f64 = 1.1;
/// Share of the scenes in which the own error has to be lower everywhere.
const SHARE: f64 = 0.75;

/// A number in the width of a column.
pub fn number(value: f64) -> String {
    if value.is_infinite() {
        "lost".to_string()
    } else if value == 0.0 {
        "0".to_string()
    } else {
        format!("{value:.1e}")
    }
}

/// All configurations of a scene: cost, headline error, the other errors, settings.
pub fn print(outcome: &Outcome) {
    let scene = &outcome.scene;
    println!();
    println!(
        "{}: {} moving bodies, {} steps of {:.2} ms; {}",
        scene.name,
        scene.setup.moving(),
        scene.steps,
        scene.setup.dt * 1e3,
        scene.headline
    );
    let axes = &outcome.all[0].errors;
    for (place, axis) in axes.iter().enumerate().skip(1) {
        println!("  [{place}] {}, {}", axis.name, axis.unit);
    }
    let heads: String = (1..axes.len()).map(|place| format!("{:>9}", format!("[{place}]"))).collect();
    println!("  {:42}{:>9}{:>9}{heads}  settings", "* on the engine's frontier", "ns", "error");
    for engine in ENGINES {
        let all = outcome.of(engine);
        let best = frontier(&outcome.points(engine));
        for (place, measured) in all.into_iter().enumerate() {
            line(measured, best.contains(&place));
        }
    }
}

fn line(measured: &Measured, is_best: bool) {
    let star = if is_best { "*" } else { " " };
    let name = format!("{star} {} {}", measured.engine, measured.name);
    let errors: String = measured.errors.iter().map(|axis| format!("{:>9}", number(axis.value))).collect();
    println!("  {name:42}{:9.0}{errors}  {}", measured.cost, measured.settings);
}

/// A peer's verdicts, with the scenes' names.
pub fn verdicts<'a>(all: &'a [Outcome], peer: &str) -> Vec<(&'a str, Verdict)> {
    let one = |outcome: &'a Outcome| {
        let points = [own::NAME, peer].map(|engine| outcome.points(engine));
        Some((outcome.scene.name, verdict(&points[0], &points[1], outcome.scene.floor)?))
    };
    all.iter().filter_map(one).collect()
}

/// Verdicts of a peer over all scenes.
pub struct Sum<'a> {
    /// Scenes in which the own error is lower at all costs that count.
    pub ahead: usize,
    pub count: usize,
    /// The worst ratio, and its scene.
    pub worst: f64,
    pub scene: &'a str,
}

/// At every cost between the peer's cheapest and dearest setting.
pub fn all_costs(verdict: &Verdict) -> (bool, f64) {
    (verdict.is_ahead, verdict.worst)
}

/// At the costs of these that both offer.
pub fn both(verdict: &Verdict) -> (bool, f64) {
    verdict.both
}

pub fn sum_up<'a>(verdicts: &[(&'a str, Verdict)], part: fn(&Verdict) -> (bool, f64)) -> Sum<'a> {
    let mut sum = Sum { ahead: 0, count: verdicts.len(), worst: 0.0, scene: "" };
    for (name, verdict) in verdicts {
        let (is_ahead, worst) = part(verdict);
        sum.ahead += usize::from(is_ahead);
        if worst > sum.worst {
            (sum.worst, sum.scene) = (worst, name);
        }
    }
    sum
}

/// Whether the own frontier is ahead of each peer's, scene by scene.
pub fn print_verdicts(all: &[Outcome]) {
    println!();
    println!(
        "Verdict: cellstep's headline error over the peer's, each the best that its engine gives within a cost, at
every cost between the peer's cheapest and dearest setting that is not lost. Errors below a scene's floor count
as the floor: what is measured there is rounding; both at the floor is no loss. `inf`: nothing own is so cheap,
or lost. Then the same at the costs that both offer, and the own cheapest cost over the peer's."
    );
    for peer in &ENGINES[1..] {
        let verdicts = verdicts(all, peer);
        println!();
        println!(
            "  {:14}{:>8}{:>10}{:>12}{:>10}{:>12}{:>10}{:>12}  against {peer}",
            "", "lower", "worst", "at cost, ns", "share", "both: lower", "worst", "cheapest"
        );
        for (name, verdict) in &verdicts {
            println!(
                "  {name:14}{:>8}{:>10.3}{:>12.0}{:>8.0} %{:>12}{:>10.3}{:>12.2}",
                yes(verdict.is_ahead),
                verdict.worst,
                verdict.worst_cost,
                100.0 * verdict.share,
                yes(verdict.both.0),
                verdict.both.1,
                verdict.cheapest
            );
        }
        for (at, sum) in
            [("every cost", sum_up(&verdicts, all_costs)), ("costs of both", sum_up(&verdicts, both))]
        {
            let holds = sum.ahead as f64 >= SHARE * sum.count as f64 && sum.worst <= WORSE;
            println!(
                "  at {at}: lower on {} of {} scenes (bound: {:.0}), worst ratio {:.3} on {} (bound: {WORSE}): {}",
                sum.ahead,
                sum.count,
                (SHARE * sum.count as f64).ceil(),
                sum.worst,
                sum.scene,
                if holds { "holds" } else { "does not hold" }
            );
        }
    }
}

fn yes(is_so: bool) -> &'static str {
    if is_so { "yes" } else { "no" }
}
