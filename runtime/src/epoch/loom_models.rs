//! Loom models of the claims at the top of `epoch.rs`, one or two for each, named after them.
//!
//! Loom runs a model under every interleaving and every value that a relaxed load may return. Each claim has
//! a small model of two threads that is explored exhaustively. Three threads, several epochs and the whole
//! pool are explored with at most two to four preemptions. What must be ordered is a loom cell, whose
//! accesses loom checks for races; what must merely be counted is an ordinary atomic, which loom does not
//! see. A lost wake-up is a deadlock, which loom reports.

use super::{Barrier, Caller, Claim, Worker};
use crate::pool::Pool;
use crate::sync::Arc;
use cellstep_core::executor::{Executor, Stage};
use loom::cell::UnsafeCell;
use loom::sync::atomic::AtomicU32 as Tracked;
use loom::thread;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::atomic::{AtomicU32, Ordering::SeqCst};

const TASKS: usize = 3;

/// A barrier and what it protects.
struct Board {
    barrier: Barrier,
    /// Stands for the job: written before an epoch is published, read under claims.
    job: UnsafeCell<()>,
    /// Stands for the tasks' values: written under claims and, between epochs, by the caller.
    values: [UnsafeCell<()>; TASKS],
    /// How often each task has run.
    runs: [AtomicU32; TASKS],
}

impl Board {
    fn new(workers: usize) -> (Arc<Board>, Caller, Vec<Worker>) {
        let (barrier, caller, others) = Barrier::new(workers);
        let board = Board {
            barrier,
            job: UnsafeCell::new(()),
            values: std::array::from_fn(|_| UnsafeCell::new(())),
            runs: std::array::from_fn(|_| AtomicU32::new(0)),
        };
        (Arc::new(board), caller, others)
    }

    /// The caller's writes, and the epoch's start.
    fn publish(&self, caller: &mut Caller, tasks: usize) {
        self.job.with_mut(|_| ());
        for value in &self.values[..tasks] {
            value.with_mut(|_| ());
        }
        caller.publish(&self.barrier, tasks as u16);
    }

    fn run(&self, claim: Claim) {
        self.job.with(|_| ());
        for task in claim.tasks() {
            self.values[task].with_mut(|_| ());
            self.runs[task].fetch_add(1, SeqCst);
        }
        self.barrier.complete(claim);
    }

    fn drain(&self, worker: usize) {
        while let Some(claim) = self.barrier.claim(worker) {
            self.run(claim);
        }
    }

    /// The caller's reads after an epoch: it may do as it likes with everything.
    fn wait(&self, caller: &mut Caller, tasks: usize, epochs: u32) {
        caller.wait(&self.barrier);
        self.job.with_mut(|_| ());
        for (value, runs) in self.values[..tasks].iter().zip(&self.runs) {
            value.with_mut(|_| ());
            assert_eq!(runs.load(SeqCst), epochs, "every task once in each epoch");
        }
    }
}

/// Explores all interleavings.
fn exhaustive(model: impl Fn() + Sync + Send + 'static) {
    loom::model::Builder::new().check(model);
}

/// Explores those with at most so many preemptions.
fn bounded(preemptions: usize, model: impl Fn() + Sync + Send + 'static) {
    let mut builder = loom::model::Builder::new();
    builder.preemption_bound = Some(preemptions);
    builder.check(model);
}

/// A worker's thread, for so many epochs.
fn serve_epochs(board: &Arc<Board>, mut worker: Worker, epochs: u32) -> thread::JoinHandle<()> {
    let board = Arc::clone(board);
    thread::spawn(move || {
        for _ in 0..epochs {
            assert!(worker.next_epoch(&board.barrier), "nobody stops the pool");
            board.drain(worker.index());
        }
    })
}

/// A worker's thread, until the end.
fn serve(board: &Arc<Board>, mut worker: Worker) -> thread::JoinHandle<()> {
    let board = Arc::clone(board);
    thread::spawn(move || {
        while worker.next_epoch(&board.barrier) {
            board.drain(worker.index());
        }
    })
}

/// A thread that has not waited for an epoch: it tries to claim, a number of times.
fn intrude(board: &Arc<Board>, worker: usize, tries: usize) -> thread::JoinHandle<()> {
    let board = Arc::clone(board);
    thread::spawn(move || {
        for _ in 0..tries {
            if let Some(claim) = board.barrier.claim(worker) {
                board.run(claim);
            }
        }
    })
}

fn join(threads: impl IntoIterator<Item = thread::JoinHandle<()>>) {
    threads.into_iter().for_each(|thread| thread.join().expect("the model holds"));
}

/// Epochs with a caller who works, then the end.
fn whole_life(workers: usize, epochs: u32, tasks: usize) {
    let (board, mut caller, others) = Board::new(workers);
    let threads: Vec<_> = others.into_iter().map(|worker| serve(&board, worker)).collect();
    for epoch in 1..=epochs {
        board.publish(&mut caller, tasks);
        board.drain(0);
        board.wait(&mut caller, tasks, epoch);
    }
    caller.stop(&board.barrier);
    join(threads);
}

#[test]
fn publish_happens_before_claim() {
    exhaustive(|| {
        let (board, mut caller, _others) = Board::new(2);
        let thread = intrude(&board, 1, 1);
        board.publish(&mut caller, 3);
        join([thread]);
        board.drain(0);
        board.wait(&mut caller, 3, 1);
    });
}

#[test]
fn complete_happens_before_wait_returns() {
    exhaustive(|| {
        let (board, mut caller, _others) = Board::new(2);
        board.publish(&mut caller, 3);
        let thread = intrude(&board, 1, 3);
        board.drain(0);
        board.wait(&mut caller, 3, 1);
        join([thread]);
    });
}

#[test]
fn complete_happens_before_wait_returns_over_epochs() {
    bounded(4, || whole_life(2, 1, 2));
    bounded(2, || whole_life(2, 2, 2));
    bounded(2, || whole_life(3, 1, 2));
}

#[test]
fn claims_are_disjoint() {
    exhaustive(|| {
        let (board, mut caller, _others) = Board::new(2);
        board.publish(&mut caller, 3);
        let thread = intrude(&board, 1, 3);
        board.drain(0);
        join([thread]);
        board.wait(&mut caller, 3, 1);
    });
}

#[test]
fn claims_are_disjoint_with_three_threads() {
    bounded(2, || {
        let (board, mut caller, _others) = Board::new(3);
        board.publish(&mut caller, 3);
        let threads = [1, 2].map(|worker| intrude(&board, worker, 3));
        board.drain(0);
        board.wait(&mut caller, 3, 1);
        join(threads);
    });
}

/// Two epochs of two tasks against a thread that may stall anywhere, also between its look at a word and its
/// exchange.
fn late_worker(first_epoch: u32, second_epoch: u32) {
    let (board, mut caller, _others) = Board::new(2);
    let thread = intrude(&board, 1, 1);
    for (before, runs) in [(first_epoch - 1, 1), (second_epoch - 1, 2)] {
        caller.epoch = before;
        board.publish(&mut caller, 2);
        board.drain(0);
        board.wait(&mut caller, 2, runs);
    }
    join([thread]);
}

#[test]
fn late_worker_claims_only_live_tasks() {
    exhaustive(|| late_worker(1, 2));
}

#[test]
fn late_worker_claims_only_live_tasks_when_the_epoch_number_has_come_round() {
    exhaustive(|| late_worker(1, 1));
}

#[test]
fn sleeping_worker_misses_no_publish() {
    exhaustive(|| {
        let (board, mut caller, mut others) = Board::new(2);
        let thread = serve_epochs(&board, others.remove(0), 1);
        // The caller claims nothing: without the worker the model does not end.
        board.publish(&mut caller, 2);
        join([thread]);
        board.wait(&mut caller, 2, 1);
    });
}

#[test]
fn sleeping_worker_misses_no_publish_over_epochs() {
    bounded(3, || {
        let (board, mut caller, mut others) = Board::new(2);
        let thread = serve_epochs(&board, others.remove(0), 2);
        for epoch in 1..=2 {
            board.publish(&mut caller, 2);
            board.wait(&mut caller, 2, epoch);
        }
        join([thread]);
    });
}

#[test]
fn sleeping_caller_misses_no_completion() {
    exhaustive(|| {
        let (board, mut caller, _others) = Board::new(2);
        board.publish(&mut caller, 3);
        let thread = intrude(&board, 1, 3);
        board.wait(&mut caller, 3, 1);
        join([thread]);
    });
}

#[test]
fn sleeping_caller_misses_no_completion_with_three_threads() {
    bounded(2, || {
        let (board, mut caller, _others) = Board::new(3);
        board.publish(&mut caller, 3);
        // Either thread may be the last to complete.
        let threads = [1, 2].map(|worker| intrude(&board, worker, 3));
        board.wait(&mut caller, 3, 1);
        join(threads);
    });
}

#[test]
fn stop_reaches_every_worker() {
    exhaustive(|| whole_life(2, 0, 0));
    bounded(2, || whole_life(3, 0, 0));
}

/// Tasks that only one thread may have at a time.
fn tracked_tasks() -> [Tracked; 2] {
    std::array::from_fn(|_| Tracked::new(0))
}

#[test]
fn pool_runs_every_task_once_and_ends() {
    bounded(2, || {
        let mut pool = Pool::new(2).expect("a thread");
        let mut tasks = tracked_tasks();
        for _ in 0..2 {
            pool.for_each(Stage::Solve, &mut tasks, |task| task.with_mut(|runs| *runs += 1));
        }
        drop(pool);
        assert_eq!(tasks.map(Tracked::into_inner), [2, 2]);
    });
}

#[test]
fn panic_reaches_the_caller_and_leaves_the_pool_usable() {
    bounded(2, || {
        let mut pool = Pool::new(2).expect("a thread");
        let mut tasks = [Tracked::new(10), Tracked::new(20)];
        let outcome = catch_unwind(AssertUnwindSafe(|| {
            pool.for_each(Stage::Solve, &mut tasks, |task| {
                let value = task.with_mut(|value| std::mem::replace(value, 0));
                // Not `panic!`: its message would be printed in every interleaving.
                resume_unwind(Box::new(value));
            });
        }));
        let payload = outcome.expect_err("both tasks panic");
        assert_eq!(payload.downcast_ref::<u32>(), Some(&10), "the first task's panic is the one to arrive");
        pool.for_each(Stage::Solve, &mut tasks, |task| task.with_mut(|value| *value += 1));
        drop(pool);
        assert_eq!(tasks.map(Tracked::into_inner), [1, 1], "both ran both times");
    });
}
