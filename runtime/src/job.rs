//! Runs borrowed tasks on the threads of the pool. All unsafe code of the pool is in this file.
//!
//! The tasks and the closure of `for_each` live on the caller's stack and have types that the worker threads
//! do not know. [`Job`] is a pointer to each with the types erased; [`Shared::run_all`] lends them for one
//! epoch.

use crate::epoch::{Barrier, Caller, Claim, TASKS_MAX, Worker};
use crate::float_mode;
use crate::sync::{AtomicBool, Mutex, UnsafeCell};
use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::PoisonError;
use std::sync::atomic::Ordering::Relaxed;

/// What a task panicked with.
pub(crate) type Payload = Box<dyn Any + Send>;

/// The borrowed tasks and closure of one epoch, types erased.
///
/// Invariant, while any [`Claim`] of the barrier next to it exists:
/// 1. `tasks` points to `count` values of the type `T`, and `run` to a value of the type `F`, for which
///    `call` was made; both are borrowed by a `run_all` that has not returned (T: `&mut`, F: `&`), with `T:
///    Send` and `F: Sync`;
/// 2. the cell that holds it is not written;
/// 3. no other claim has the same tasks.
///
/// Guaranteed by [`Shared::run_all`], the only writer, which writes before it publishes and neither returns
/// nor unwinds before the barrier says that all tasks are completed; and by the barrier's
/// `late_worker_claims_only_live_tasks` (1, 2) and `claims_are_disjoint` (3), see `epoch.rs`.
#[derive(Clone, Copy)]
struct Job {
    tasks: *mut (),
    run: *const (),
    count: usize,
    call: unsafe fn(&Job, usize),
}

impl Job {
    fn new<T: Send, F: Fn(&mut T) + Sync>(tasks: &mut [T], run: &F) -> Self {
        Job {
            count: tasks.len(),
            tasks: tasks.as_mut_ptr().cast(),
            run: std::ptr::from_ref(run).cast(),
            call: Job::call::<T, F>,
        }
    }

    /// Runs the task `index`.
    ///
    /// # Safety
    /// The job was made with these types, and the caller holds a [`Claim`] of its epoch that has the task
    /// `index`, which it runs once.
    unsafe fn call<T, F: Fn(&mut T)>(&self, index: usize) {
        assert!(index < self.count, "the barrier counts as many tasks as the job");
        // SAFETY: by invariant 1 the pointers are valid and of these types; by invariant 3 nobody else has
        // this task, and by `publish_happens_before_claim` the caller's writes to it are seen here.
        let (task, run) = unsafe { (&mut *self.tasks.cast::<T>().add(index), &*self.run.cast::<F>()) };
        run(task);
    }
}

/// Where the caller leaves the job of an epoch.
struct JobCell(UnsafeCell<Option<Job>>);

// SAFETY: the pointers in a job are used on other threads under a claim only, where invariant 1 gives `T:
// Send` and `F: Sync`.
unsafe impl Send for JobCell {}
// SAFETY: the cell is read under a claim only and never written while one exists (invariant 2).
unsafe impl Sync for JobCell {}

/// What the threads of a pool share.
pub(crate) struct Shared {
    barrier: Barrier,
    job: JobCell,
    /// The panic of the task with the lowest index in this epoch, so that the caller's panic does not depend
    /// on threads.
    panic: Mutex<Option<(usize, Payload)>>,
    /// Some thread was seen with a float mode that is not the standard one.
    float_fault: AtomicBool,
}

impl Shared {
    /// What `workers` threads share, the caller's side, and the side of each other worker.
    pub(crate) fn new(workers: usize) -> (Shared, Caller, Vec<Worker>) {
        let (barrier, caller, others) = Barrier::new(workers);
        let shared = Shared {
            barrier,
            job: JobCell(UnsafeCell::new(None)),
            panic: Mutex::new(None),
            float_fault: AtomicBool::new(false),
        };
        (shared, caller, others)
    }

    /// Runs every task once, on this thread and on those that are in [`Shared::work`]. At most [`TASKS_MAX`]
    /// tasks. Returns what the first of the panicking tasks panicked with; the others have run all the same.
    pub(crate) fn run_all<T: Send, F: Fn(&mut T) + Sync>(
        &self,
        caller: &mut Caller,
        tasks: &mut [T],
        run: &F,
    ) -> Option<Payload> {
        assert!(tasks.len() <= TASKS_MAX, "at most {TASKS_MAX} tasks in an epoch");
        let count = tasks.len() as u16;
        let job = Job::new(tasks, run);
        // SAFETY: no claim exists, hence no reader: `caller` is the only one that publishes, we have it
        // alone, and its last epoch is complete (below).
        self.job.0.with_mut(|cell| unsafe { *cell = Some(job) });
        let unwinding_would_free_the_tasks = AbortOnDrop;
        caller.publish(&self.barrier, count);
        self.drain(0);
        caller.wait(&self.barrier);
        std::mem::forget(unwinding_would_free_the_tasks);
        self.take_panic()
    }

    /// The life of a worker's thread.
    pub(crate) fn work(&self, mut worker: Worker) {
        while worker.next_epoch(&self.barrier) {
            self.drain(worker.index());
        }
    }

    /// Makes every worker return from [`Shared::work`].
    pub(crate) fn stop(&self, caller: &mut Caller) {
        caller.stop(&self.barrier);
    }

    /// Notes the float mode of this thread.
    #[inline]
    pub(crate) fn probe_float_mode(&self) {
        if !float_mode::is_standard() {
            // Seen by the caller after the epoch: a thread probes before its first completion.
            self.float_fault.store(true, Relaxed);
        }
    }

    /// True once a probe has failed.
    pub(crate) fn float_mode_fault(&self) -> bool {
        self.float_fault.load(Relaxed)
    }

    /// Claims, runs and completes until nothing is left to claim.
    fn drain(&self, worker: usize) {
        self.probe_float_mode();
        while let Some(claim) = self.barrier.claim(worker) {
            self.run(&claim);
            self.barrier.complete(claim);
        }
    }

    fn run(&self, claim: &Claim) {
        // SAFETY: the claim exists, so the cell is not being written (invariant 2).
        let job = self
            .job
            .0
            .with(|cell| unsafe { *cell })
            .expect("the job is written before its tasks are published");
        for index in claim.tasks() {
            // SAFETY: `call` was made with the job, and each task of the claim is run once.
            let outcome = catch_unwind(AssertUnwindSafe(|| unsafe { (job.call)(&job, index) }));
            if let Err(payload) = outcome {
                self.keep_panic(index, payload);
            }
        }
    }

    fn keep_panic(&self, index: usize, payload: Payload) {
        let mut kept = self.panic.lock().unwrap_or_else(PoisonError::into_inner);
        let surplus = match &*kept {
            Some((first, _)) if *first < index => Some(payload),
            _ => kept.replace((index, payload)).map(|(_, later)| later),
        };
        drop(kept);
        discard(surplus);
    }

    fn take_panic(&self) -> Option<Payload> {
        let mut kept = self.panic.lock().unwrap_or_else(PoisonError::into_inner);
        kept.take().map(|(_, payload)| payload)
    }
}

/// Drops a payload that nobody will see. The payload is the game's own type, and its drop may panic too: that
/// last payload is leaked, since a worker must not unwind.
pub(crate) fn discard(payload: Option<Payload>) {
    if let Err(again) = catch_unwind(AssertUnwindSafe(|| drop(payload))) {
        std::mem::forget(again);
    }
}

/// Dropped by an unwinding only: the frame that owns the tasks must not end while others may use them.
/// Nothing between publishing and waiting panics, unless the pool itself has an error.
struct AbortOnDrop;

impl Drop for AbortOnDrop {
    fn drop(&mut self) {
        std::process::abort();
    }
}
