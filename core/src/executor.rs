//! Who runs the tasks of a step.
//!
//! A task *owns* the `&mut` slices that it writes, so the borrow checker proves that tasks are disjoint: an
//! executor can be wrong, but it cannot race. There is no worker index, so no result can depend on one.

/// The stages of a step, in their order. The first, second, fifth and sixth are the talk's (SEED S1; its
/// integration is fused into the solve).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(usize)]
pub enum Stage {
    /// Boxes of moved shapes, candidate pairs.
    Broadphase,
    /// Contact points of pairs.
    Narrowphase,
    /// Connected groups of bodies.
    Islands,
    /// Cellular ordering of the links.
    Ordering,
    /// Rows in solver order.
    Assembly,
    /// Sweeps over the rows; integration is fused into them.
    Solve,
    /// Results written back to the state.
    Finish,
    /// Not of a step: a batch of queries.
    Query,
}

impl Stage {
    /// How many stages there are.
    pub const COUNT: usize = 8;
    /// All stages in their order.
    pub const ALL: [Stage; Self::COUNT] = [
        Stage::Broadphase,
        Stage::Narrowphase,
        Stage::Islands,
        Stage::Ordering,
        Stage::Assembly,
        Stage::Solve,
        Stage::Finish,
        Stage::Query,
    ];

    /// The stage's name in reports: lower case, one word.
    pub const fn name(self) -> &'static str {
        match self {
            Stage::Broadphase => "broadphase",
            Stage::Narrowphase => "narrowphase",
            Stage::Islands => "islands",
            Stage::Ordering => "ordering",
            Stage::Assembly => "assembly",
            Stage::Solve => "solve",
            Stage::Finish => "finish",
            Stage::Query => "query",
        }
    }
}

/// Runs tasks. Results never depend on how: any order, any threads.
pub trait Executor {
    /// Calls `run` exactly once for every task, in any order and on any threads; returns when all are done.
    fn for_each<T: Send>(&mut self, stage: Stage, tasks: &mut [T], run: impl Fn(&mut T) + Sync);

    /// Called at the start of every stage. The core owns no clock: whoever wants times takes them here.
    fn enter(&mut self, stage: Stage) {
        let _ = stage;
    }

    /// Called at the end of the step.
    fn leave(&mut self) {}
}

/// Runs the tasks one after the other on the calling thread.
#[derive(Clone, Copy, Debug, Default)]
pub struct Serial;

impl Executor for Serial {
    fn for_each<T: Send>(&mut self, _: Stage, tasks: &mut [T], run: impl Fn(&mut T) + Sync) {
        for task in tasks {
            run(task);
        }
    }
}
