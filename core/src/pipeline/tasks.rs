//! How work is cut into tasks: by the scene alone, never by the number of workers.

use crate::executor::{Executor, Stage};

/// Most tasks of one call of the executor.
pub(crate) const TASKS_MAX: usize = 128;

/// The tasks of one call, on the stack.
pub(crate) type Tasks<T> = heapless::Vec<T, TASKS_MAX>;

/// An executor that counts its barriers. Empty stages and single tasks never reach the executor's pool.
pub(crate) struct Crew<'e, E> {
    pub executor: &'e mut E,
    /// Calls of the executor: those with two tasks or more.
    pub barriers: u32,
    /// True in a scene so small that a barrier costs more than the work: its tasks run here, one after the other.
    pub is_alone: bool,
}

/// A scene with fewer contacts, and fewer bodies, is stepped without the executor. A barrier takes 1 to 2
/// microseconds of workers that are awake, and up to 50 to wake them; 160 contacts are solved in 5 per sweep.
pub(crate) const ALONE_CONTACTS: u32 = 160;
/// See [`ALONE_CONTACTS`].
pub(crate) const ALONE_BODIES: u32 = 256;

impl<E: Executor> Crew<'_, E> {
    pub fn run<T: Send>(&mut self, stage: Stage, tasks: &mut [T], run: impl Fn(&mut T) + Sync) {
        match tasks {
            [] => {}
            [task] => run(task),
            _ if self.is_alone => tasks.iter_mut().for_each(run),
            _ => {
                self.barriers += 1;
                self.executor.for_each(stage, tasks, run);
            }
        }
    }
}

/// Elements for each task: at least `least`, and few enough tasks.
pub(crate) const fn chunk(count: usize, least: usize) -> usize {
    let share = count.div_ceil(TASKS_MAX);
    if share > least { share } else { least }
}

/// Pushes a task; that there is room follows from [`chunk`].
pub(crate) fn push<T>(tasks: &mut Tasks<T>, task: T) {
    assert!(tasks.push(task).is_ok(), "more tasks than TASKS_MAX");
}
