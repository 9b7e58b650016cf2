//! The outcome in words, from the numbers of this run alone.

use crate::WORKERS;
use crate::measure::{Measured, Ordered, SYNCS};
use cellstep_tests::schedules::Ordering;

/// Orderings nearer than this are as good as each other.
const SAME: f64 = 0.02;
/// Sweeps at which convergence is compared.
const COMPARED: u32 = 16;

/// The residual to which the time is asked for.
const GOAL: f64 = 0.1;

/// What to take from it.
pub fn print(all: &[Measured]) {
    println!();
    println!("Outcome: the fastest sweep by the model (in brackets, how much faster than cellular)");
    outcome(all, |_, own, place| Some(own.sweep_ns[place]));
    println!("The least modelled time to a residual of {GOAL}");
    outcome(all, |scene, own, place| {
        let curve = scene.curves.iter().find(|curve| curve.name == own.name())?;
        Some(curve.sweeps_to(GOAL)? * scene.ordered(own.ordering).sweep_ns[place])
    });
    syncs(all);
    convergence(all);
}

/// A table of the best ordering by a time, and how often each is it. Scenes without times are left out.
fn outcome(all: &[Measured], time: impl Fn(&Measured, &Ordered, usize) -> Option<f64>) {
    let mut wins = [[0; Ordering::ALL.len()]; WORKERS.len()];
    for scene in all {
        let best: Vec<String> = (0..WORKERS.len())
            .filter_map(|place| {
                let (winner, gain) = winner(&scene.orderings, |own| time(scene, own, place))?;
                wins[place][winner as usize] += 1;
                let bracket =
                    if winner == Ordering::Cellular { String::new() } else { format!(" ({gain:.2})") };
                Some(format!("{:26}", format!("x{}: {}{bracket}", WORKERS[place], winner.name())))
            })
            .collect();
        if !best.is_empty() {
            println!("  {:20} {}", scene.name, best.concat().trim_end());
        }
    }
    for (workers, wins) in WORKERS.iter().zip(wins) {
        let named = Ordering::ALL.iter().zip(wins).filter(|&(_, count)| count > 0);
        let list: Vec<String> =
            named.map(|(ordering, count)| format!("{} {count}", ordering.name())).collect();
        println!("  at {workers} workers: {}", list.join(", "));
    }
}

/// The fastest ordering, cellular if it is as good, and cellular's time over its.
fn winner(orderings: &[Ordered], time: impl Fn(&Ordered) -> Option<f64>) -> Option<(Ordering, f64)> {
    let times: Vec<(Ordering, f64)> =
        orderings.iter().filter_map(|own| Some((own.ordering, time(own)?))).collect();
    let cellular = times.iter().find(|(ordering, _)| *ordering == Ordering::Cellular)?.1;
    let (best, least) = times.into_iter().min_by(|a, b| a.1.total_cmp(&b.1))?;
    let same = cellular <= least * (1.0 + SAME);
    Some(if same { (Ordering::Cellular, 1.0) } else { (best, cellular / least) })
}

/// Least and most phases of each ordering, and how its lanes fill.
fn syncs(all: &[Measured]) {
    println!("Over all scenes");
    for ordering in Ordering::ALL {
        let (mut syncs, mut fills) = (Vec::new(), Vec::new());
        for own in all.iter().map(|scene| scene.ordered(ordering)) {
            syncs.push(own.profile.syncs());
            fills.push(own.profile.lane_fill());
        }
        println!(
            "  {:13} {:2} to {:2} syncs per sweep, lanes filled {:3.0} % to {:3.0} %",
            ordering.name(),
            syncs.iter().min().copied().unwrap_or(0),
            syncs.iter().max().copied().unwrap_or(0),
            100.0 * fills.iter().copied().fold(1.0, f64::min),
            100.0 * fills.iter().copied().fold(0.0, f64::max)
        );
    }
}

/// Residuals against those of the natural order, over all scenes that have them.
fn convergence(all: &[Measured]) {
    let with: Vec<&Measured> = all.iter().filter(|scene| !scene.curves.is_empty()).collect();
    let Some(first) = with.first() else { return };
    let spent = SYNCS[SYNCS.len() - 2];
    println!(
        "Residual over that of the natural order at {COMPARED} sweeps, and over that of cellular at {spent} syncs,
geometric means of {} scenes:",
        with.len()
    );
    for (place, curve) in first.curves.iter().enumerate() {
        let mean = |ratio: &dyn Fn(&Measured) -> Option<f64>| {
            let logs: Vec<f64> = with.iter().filter_map(|scene| ratio(scene)).map(f64::ln).collect();
            (logs.iter().sum::<f64>() / logs.len().max(1) as f64).exp()
        };
        let sweeps =
            mean(&|scene| Some(scene.curves[place].after(COMPARED)? / scene.curves[0].after(COMPARED)?));
        let cellular = Ordering::Cellular as usize;
        let syncs = mean(&|scene| {
            Some(scene.curves[place].at_syncs(spent)? / scene.curves[cellular].at_syncs(spent)?)
        });
        println!("  {:13} {sweeps:6.2} {syncs:9.2}", curve.name);
    }
}
