//! Runs the tasks of a step on several threads.
//!
//! The thread that steps the world is worker 0 of its [`Pool`]; the others wait for it between lists of
//! tasks, first awake, then parked. `epoch.rs` is the protocol, `job.rs` the lending of tasks, `spin.rs` the
//! waiting.
//!
//! Invariants:
//! - results never depend on the pool: it decides when and where a task runs, never what it gets;
//! - `for_each` returns when all tasks are done, whether or not any other worker has taken part;
//! - a panic of a task reaches the caller after all other tasks have run, and the pool remains usable;
//! - `for_each` allocates nothing (unless a task panics).

use crate::epoch::{Caller, TASKS_MAX};
use crate::job::{Payload, Shared, discard};
use crate::sync::{Arc, thread};
use cellstep_core::executor::{Executor, Stage};
use std::fmt;
use std::io;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};

/// An executor with a fixed number of threads.
///
/// ```
/// use cellstep::pool::Pool;
/// use cellstep_core::executor::{Executor, Stage};
///
/// let mut pool = Pool::new(4)?;
/// let mut squares: Vec<u64> = (0..100).collect();
/// pool.for_each(Stage::Solve, &mut squares, |n| *n *= *n);
/// assert_eq!(squares[9], 81);
/// # Ok::<(), cellstep::pool::PoolError>(())
/// ```
pub struct Pool {
    shared: Arc<Shared>,
    caller: Caller,
    workers: usize,
    threads: Vec<thread::JoinHandle<()>>,
}

/// Why a [`Pool`] could not be made.
#[derive(Debug)]
#[non_exhaustive]
pub enum PoolError {
    /// The number of workers is zero or above [`Pool::WORKERS_MAX`]. One worker is the calling thread alone.
    WorkerCount(usize),
    /// The system refused a thread, mostly for want of memory or by a limit. Ask for fewer workers.
    Spawn(io::Error),
}

impl fmt::Display for PoolError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            PoolError::WorkerCount(workers) => {
                write!(out, "a pool has 1 to {} workers, not {workers}", Pool::WORKERS_MAX)
            }
            PoolError::Spawn(cause) => write!(out, "cannot start a worker: {cause}"),
        }
    }
}

impl std::error::Error for PoolError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match self {
            PoolError::WorkerCount(_) => None,
            PoolError::Spawn(cause) => Some(cause),
        }
    }
}

impl Pool {
    /// The most workers of a pool.
    pub const WORKERS_MAX: usize = 256;

    /// A pool of `workers` workers, 1 to [`Pool::WORKERS_MAX`]; the thread that uses it is one of them, so
    /// `workers - 1` threads are started. More workers than cores work, but gain nothing.
    ///
    /// # Errors
    /// [`PoolError`]; threads already started are ended.
    pub fn new(workers: usize) -> Result<Pool, PoolError> {
        if !(1..=Self::WORKERS_MAX).contains(&workers) {
            return Err(PoolError::WorkerCount(workers));
        }
        let (shared, caller, others) = Shared::new(workers);
        // A pool from the first thread on, so that its drop ends those that have started.
        let mut pool =
            Pool { shared: Arc::new(shared), caller, workers, threads: Vec::with_capacity(workers - 1) };
        for worker in others {
            let name = format!("cellstep-{}", worker.index());
            let shared = Arc::clone(&pool.shared);
            let thread = thread::Builder::new().name(name).spawn(move || shared.work(worker));
            pool.threads.push(thread.map_err(PoolError::Spawn)?);
        }
        Ok(pool)
    }

    /// How many workers there are, the caller included.
    pub fn workers(&self) -> usize {
        self.workers
    }

    /// True once a thread that took part had flush-to-zero or another rounding mode than the standard one:
    /// its results are not the engine's bits (see [`crate::float_mode`]). Probed at the start of every stage
    /// in the caller and of every list of tasks in each worker that sees it. It stays true.
    pub fn float_mode_fault(&self) -> bool {
        self.shared.float_mode_fault()
    }

    /// Runs at most [`TASKS_MAX`] tasks; what the first of the panicking ones panicked with.
    fn run<T: Send>(&mut self, tasks: &mut [T], run: &(impl Fn(&mut T) + Sync)) -> Option<Payload> {
        if self.workers > 1 && tasks.len() > 1 {
            return self.shared.run_all(&mut self.caller, tasks, run);
        }
        self.shared.probe_float_mode();
        let mut first = None;
        for task in tasks {
            first = earlier(first, catch_unwind(AssertUnwindSafe(|| run(task))).err());
        }
        first
    }
}

/// The first panic of two, in the order of tasks.
fn earlier(first: Option<Payload>, second: Option<Payload>) -> Option<Payload> {
    if first.is_none() {
        return second;
    }
    discard(second);
    first
}

impl Executor for Pool {
    /// Runs the tasks on all workers.
    ///
    /// # Panics
    /// When a task panics: with its payload, after all other tasks have run; of several, the one that is
    /// first in `tasks`.
    fn for_each<T: Send>(&mut self, _: Stage, tasks: &mut [T], run: impl Fn(&mut T) + Sync) {
        let mut first = None;
        for some in tasks.chunks_mut(TASKS_MAX) {
            first = earlier(first, self.run(some, &run));
        }
        if let Some(payload) = first {
            resume_unwind(payload);
        }
    }

    fn enter(&mut self, _: Stage) {
        self.shared.probe_float_mode();
    }
}

impl fmt::Debug for Pool {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.debug_struct("Pool").field("workers", &self.workers).finish_non_exhaustive()
    }
}

impl Drop for Pool {
    fn drop(&mut self) {
        self.shared.stop(&mut self.caller);
        for thread in self.threads.drain(..) {
            // A worker catches what its tasks throw, so it has nothing to report.
            let _ = thread.join();
        }
    }
}
