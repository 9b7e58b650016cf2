//! The talk's orderings against the built-in one: synchronisations, balance, lanes, convergence, cost.
//!
//! `cargo bench -p cellstep-tests --bench orderings` (about three minutes; `-- --quick` takes small scenes)
//!
//! For ten scenes from 500 to 200,000 bodies: what each ordering makes of the contact graph, what a sweep would
//! cost on workers by the model of [`cellstep_tests::schedules::model`], and on scenes up to some 5,000 bodies how
//! fast the condition S8 is met in the double-precision solver of [`cellstep_tests::reference`], with each
//! ordering's sequence of links, with the talk's algebraic colouring of rows, and with Jacobi. Written as tables,
//! and as two plots below the target folder.

mod measure;
mod plots;
mod scenes;
mod summary;
mod table;

use measure::Measured;
use std::time::Instant;

/// Numbers of workers of the model.
const WORKERS: [usize; 4] = [2, 8, 32, 128];

fn main() {
    let quick = std::env::args().any(|argument| argument == "--quick");
    let start = Instant::now();
    table::explain();
    let mut all: Vec<Measured> = Vec::new();
    for scene in scenes::all(quick) {
        let measured = measure::measure(&scene);
        table::print(&measured);
        all.push(measured);
    }
    summary::print(&all);
    for path in plots::write(&all) {
        println!("plot: {}", path.display());
    }
    println!("{:.0} s", start.elapsed().as_secs_f64());
}
