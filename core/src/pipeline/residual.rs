//! Measuring what a sweep left: see `constraint/residual.rs`.
//!
//! It is one more pass over the phases, since velocities are final only when the last phase has ended: each phase
//! pulls its seats, and changes nothing. A task notes the greatest residuals of its group; the caller takes the
//! greatest of these when all tasks of a phase are done, so no bit depends on who did them.

use crate::constraint::contact::{self, Sweep};
use crate::constraint::joint;
use crate::constraint::residual::Greatest;
use crate::executor::{Executor, Stage};
use crate::pipeline::layout::Tier;
use crate::pipeline::solver::{Rows, Task, cut_phase};
use crate::pipeline::tasks::{Crew, Tasks, push};
use crate::report::Residual;

/// Measures the rows of a tier as the sweep's pass leaves them. Velocities, impulses and rows stay.
pub(crate) fn measure<E: Executor>(
    (rows, tier): (&mut Rows<'_>, &Tier),
    sweep: &Sweep,
    crew: &mut Crew<'_, E>,
) -> Residual {
    let mut all = Residual::default();
    for phase in tier.phases() {
        let mut groups = Tasks::new();
        let others = cut_phase(rows, phase, &mut groups);
        let mut tasks: Tasks<(Task<'_>, Residual)> = Tasks::new();
        groups.into_iter().for_each(|group| push(&mut tasks, (group, Residual::default())));
        crew.run(Stage::Solve, &mut tasks, |(task, residual)| {
            others.pull(task.seats, task.sources);
            *residual = measure_group(task, sweep);
        });
        all = tasks.iter().fold(all, |all, (_, residual)| all.with(residual));
    }
    all
}

fn measure_group(task: &mut Task<'_>, sweep: &Sweep) -> Residual {
    let mut greatest = Greatest::NONE;
    let seats = &*task.seats;
    joint::measure_balls(task.joints.balls, seats, &mut greatest);
    // Articulations have the joints of a group one after the other, like others.
    joint::measure(task.joints.links, (task.joints.locks, task.joints.bounds), seats, &mut greatest);
    contact::measure(sweep, (task.links, task.resists, task.cones), task.points, seats, &mut greatest);
    greatest.all()
}
