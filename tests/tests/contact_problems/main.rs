//! The solver's own projection on problems that others made: frictional contacts of real runs, in the FCLIB layout.
//!
//! ```text
//! CELLSTEP_DATA=... cargo test --package cellstep-tests --test contact_problems -- --nocapture
//! ```
//! prints how the residual falls with the sweeps. The files are found through the environment variable
//! `CELLSTEP_DATA`, a folder with `contact-problems/*.hdf5`; without it the test says that it skipped.
//!
//! Problems that say their bodies become rows between those bodies, exactly as in a step. One that says no more
//! than W cannot: which bodies its contacts share, and with which jacobians, is not in it. Its contacts become
//! rows on a body each whose `J M^-1 Jt` is the contact's own block of W; what an impulse does to other
//! contacts is added from W to their rates, which stand in the bodies' velocities before each visit. The
//! projection is the same. So are problems treated whose three directions are not across each other, as those
//! of the balls, which are off by up to 0.03: rows have right angles.

mod read;
mod sweeps;

use read::Problem;
use std::path::PathBuf;
use sweeps::{Blocks, Jointly, Solver};

/// Sweeps after which the residual is told.
const TOLD: [u32; 11] = [1, 2, 4, 8, 16, 32, 64, 128, 256, 512, 1024];

/// Residual in double precision, m/s: greatest of the normals, and of the discs of friction.
fn residual(problem: &Problem, impulses: &[[f64; 3]]) -> f64 {
    let flat: Vec<f64> = impulses.iter().flatten().copied().collect();
    let entry = |row: usize, column: usize| {
        problem.matrix[row].iter().filter(|entry| entry.0 == column).map(|entry| entry.1).sum::<f64>()
    };
    let mut most = 0.0_f64;
    for (contact, [n, t, s]) in impulses.iter().enumerate() {
        let u = [0, 1, 2].map(|k| {
            let row = &problem.matrix[3 * contact + k];
            problem.rates[3 * contact + k] + row.iter().map(|&(column, x)| x * flat[column]).sum::<f64>()
        });
        let at = |i: usize, k: usize| entry(3 * contact + i, 3 * contact + k);
        most = most.max(u[0].min(n * at(0, 0)).abs());
        let (half, other) = (0.5 * (at(1, 1) - at(2, 2)), at(1, 2));
        let yields = 0.5 * (at(1, 1) + at(2, 2)) + half.hypot(other);
        let (x, y) = (t - u[1] / yields, s - u[2] / yields);
        let scale = (problem.friction[contact] * n / x.hypot(y).max(f64::MIN_POSITIVE)).min(1.0);
        most = most.max((t - x * scale).hypot(s - y * scale) * yields);
    }
    most
}

/// Residuals after the told numbers of sweeps, as shares of that without impulses.
fn run(name: &str, problem: &Problem, solver: &mut dyn Solver) -> Vec<f64> {
    let contacts = problem.friction.len();
    let start = residual(problem, &vec![[0.0; 3]; contacts]);
    println!(
        "{name}: {contacts} contacts, {} rows of eight, residual {start:.3e} m/s at first",
        solver.rows()
    );
    let mut told = Vec::new();
    let mut done = 0;
    for sweeps in TOLD {
        (done..sweeps).for_each(|_| solver.sweep());
        done = sweeps;
        let exact = residual(problem, &solver.impulses());
        let own = solver.residual();
        println!(
            "  {sweeps:>5} sweeps: {exact:.2e} m/s, {:.2e} of the first; the solver says {own:.2e}",
            exact / start
        );
        // The solver's own measure is of f32 velocities.
        assert!((own - exact).abs() < 1.0e-2 * exact + 2.0e-5 * start, "{own} and {exact}");
        told.push(exact / start);
    }
    told
}

#[test]
fn problems_of_others_converge() {
    let Some(path) = std::env::var_os("CELLSTEP_DATA") else {
        println!("skipped: CELLSTEP_DATA is not set");
        return;
    };
    let folder = PathBuf::from(path).join("contact-problems");
    // Residuals after 8, 64 and 1,024 sweeps, as shares of the first: a double-precision solver has the same.
    for (file, bounds) in [
        ("Box_Stacks-i0122-82-5", [2.0e-2, 1.0e-6, 1.0e-5]),
        ("Capsules-i125-1213", [3.0e-2, 8.0e-4, 2.0e-4]),
        ("spheres-in-a-box-98-i10000-256-10", [0.4, 1.5e-2, 1.5e-3]),
    ] {
        let problem = read::read(&folder.join(format!("{file}.hdf5"))).expect("the file is readable");
        let mut jointly = problem.bodies.as_ref().and_then(|bodies| Jointly::new(&problem, bodies));
        assert_eq!(jointly.is_some(), file.starts_with("Box"), "{file}: rows between bodies");
        let told = match &mut jointly {
            Some(solver) => run(file, &problem, solver),
            None => run(file, &problem, &mut Blocks::new(&problem)),
        };
        for (sweeps, bound) in [8, 64, 1024].into_iter().zip(bounds) {
            let place = TOLD.iter().position(|&other| other == sweeps).expect("it is told");
            assert!(told[place] < bound, "{file}: {} after {sweeps} sweeps", told[place]);
        }
    }
}
