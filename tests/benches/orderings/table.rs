//! The tables in the terminal.

use crate::WORKERS;
use crate::measure::{Curve, Measured, SWEEPS, SYNCS};
use cellstep_tests::schedules::Ordering;
use cellstep_tests::schedules::model::{BARRIER_NS, GROUP_LINKS, GROUPS_MAX, LANES, LINK_NS, Profile};

/// Phases whose links are shown one by one.
const SHOWN: usize = 4;

/// What the columns mean.
pub fn explain() {
    let row_ns = LANES as f64 * LINK_NS;
    let [barrier, each] = BARRIER_NS.map(|ns| ns * 1e-3);
    println!(
        "Orderings of the contact graph, each as a schedule for the solver; a contact is a link.
syncs: phases, i.e. barriers, of a sweep. largest: links of the largest block.
lanes: share of the lanes of all rows that hold a link, blocks dealt as the solver deals them: a group of
  {LANES} chains for every {GROUP_LINKS} links of a phase, at most {GROUPS_MAX} groups; each block goes to
  the shortest chain.
x W: modelled speed of a sweep on W workers against one worker with all lanes filled. A row of {LANES} lanes
  takes {row_ns} ns ({LINK_NS} ns per link) however many are filled; workers take groups in turn; a phase of
  several groups ends in a barrier of {barrier} us + {each} us per worker. No caches, seats, integration.
build: ns per link of one build from nothing. The baselines are plain code: read them as a magnitude.
residual: of the condition S8 by the natural map, 1 at the start, in double precision on the rows of one
  substep: soft contacts, box friction with bounds of the step before, all impulses zero at first.
  `row colours`: greedy colouring of the rows of A (Mifune), a sync per colour. `jacobi`: with 0.95 of the
  greatest factor that converges, one sync per sweep."
    );
}

/// All about one scene.
pub fn print(scene: &Measured) {
    let report = &scene.report;
    println!();
    println!(
        "{}: {} bodies, {} links after {} steps ({})",
        scene.name, report.active, report.contacts, scene.steps, scene.note
    );
    let workers: String = WORKERS.iter().map(|count| format!("{:>8}", format!("x {count}"))).collect();
    println!(
        "  {:13} {:>5}  {:34} {:>8} {:>6}{workers} {:>7}",
        "ordering", "syncs", "links per phase", "largest", "lanes", "build"
    );
    for own in &scene.orderings {
        let profile = &own.profile;
        let speeds: String =
            WORKERS.iter().map(|&count| format!("{:8.2}", profile.speed_up(count))).collect();
        println!(
            "  {:13} {:5}  {:34} {:8} {:4.0} %{speeds} {:7.0}",
            own.name(),
            profile.syncs(),
            phases(profile),
            profile.largest_block(),
            100.0 * profile.lane_fill(),
            own.build_ns
        );
    }
    println!(
        "  largest island: {:.0} % of the links; red-black cells of {:.2} m",
        islands(scene),
        scene.edge
    );
    println!(
        "  engine, one worker: ordering {:.0} ns per contact and step, {:.1} % of the step; {} phases, {} barriers",
        scene.upkeep.0,
        100.0 * scene.upkeep.1,
        report.phases,
        report.barriers
    );
    if !scene.curves.is_empty() {
        residuals(&scene.curves);
    }
}

/// Links phase by phase, as far as there is room.
fn phases(profile: &Profile) -> String {
    let shown: Vec<String> = profile.links.iter().take(SHOWN).map(usize::to_string).collect();
    let rest = profile.links.len().saturating_sub(SHOWN);
    let links: usize = profile.links.iter().skip(SHOWN).sum();
    let more = if rest > 0 { format!(" + {links} in {rest}") } else { String::new() };
    shown.join(" ") + &more
}

/// Share of the links in the largest island, percent.
fn islands(scene: &Measured) -> f64 {
    let profile = &scene.ordered(Ordering::Islands).profile;
    100.0 * profile.largest_block() as f64 / profile.link_count().max(1) as f64
}

fn residuals(curves: &[Curve]) {
    let head = |counts: &[u32]| counts.iter().map(|count| format!("{count:>9}")).collect::<String>();
    let line = |values: Vec<Option<f64>>| {
        let show = |value: Option<f64>| value.map_or(format!("{:>9}", "-"), |x| format!("{x:9.1e}"));
        values.into_iter().map(show).collect::<String>()
    };
    println!("  residual      syncs  after sweeps{}   after syncs{}", head(&SWEEPS), head(&SYNCS));
    for curve in curves {
        let sweeps = line(SWEEPS.iter().map(|&count| curve.after(count)).collect());
        let syncs = line(SYNCS.iter().map(|&count| curve.at_syncs(count)).collect());
        println!("  {:13} {:5}              {sweeps}              {syncs}", curve.name, curve.syncs);
    }
}
