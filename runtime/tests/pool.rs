//! The pool seen from outside: every task once, panics, shutdown, whatever the number of workers.
#![cfg(not(loom))]

use cellstep::math::Vec3;
use cellstep::pool::{Pool, PoolError};
use cellstep::{BodyDef, BodyKind, Capacities, Geometry, Memory, Serial, ShapeDef, World, new_world};
use cellstep_core::executor::{Executor, Stage};
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::Barrier;
use std::sync::atomic::{AtomicUsize, Ordering::SeqCst};
use std::thread;
use std::time::{Duration, Instant};

const WORKERS: [usize; 4] = [1, 2, 3, 8];

fn pool(workers: usize) -> Pool {
    Pool::new(workers).expect("the system has threads")
}

/// Numbers below `bound` that differ from call to call, the same in every run.
struct Numbers(u64);

impl Numbers {
    fn below(&mut self, bound: usize) -> usize {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) as usize % bound
    }
}

/// Runs epochs of 0 to 299 tasks of uneven work, and checks each.
fn run_epochs(pool: &mut Pool, seed: u64, epochs: u64) {
    let mut numbers = Numbers(seed);
    for epoch in 0..epochs {
        let mut tasks: Vec<(u64, u32)> = (0..numbers.below(300) as u64).map(|n| (n, 0)).collect();
        let pause = numbers.below(50) as u64;
        pool.for_each(Stage::Solve, &mut tasks, |(n, runs)| {
            for _ in 0..*n % (pause + 1) {
                std::hint::spin_loop();
            }
            *n += epoch;
            *runs += 1;
        });
        for (index, task) in (0..).zip(&tasks) {
            assert_eq!(*task, (index + epoch, 1), "task {index} of {}, epoch {epoch}", tasks.len());
        }
    }
}

/// One epoch in which the tasks of `panicking` panic with their index: what reached the caller.
fn panic_in(pool: &mut Pool, tasks: usize, panicking: &[usize]) -> Option<usize> {
    let mut runs: Vec<(usize, u32)> = (0..tasks).map(|index| (index, 0)).collect();
    let outcome = catch_unwind(AssertUnwindSafe(|| {
        pool.for_each(Stage::Solve, &mut runs, |(index, runs)| {
            *runs += 1;
            if panicking.contains(index) {
                resume_unwind(Box::new(*index));
            }
        });
    }));
    assert!(runs.iter().all(|&(_, runs)| runs == 1), "all tasks run, once: {runs:?}");
    outcome.err().map(|payload| *payload.downcast::<usize>().expect("the task's own payload"))
}

#[test]
fn every_task_runs_once() {
    for workers in WORKERS {
        let mut pool = pool(workers);
        assert_eq!(pool.workers(), workers);
        run_epochs(&mut pool, workers as u64, 4000);
        assert!(!pool.float_mode_fault(), "test threads have the standard mode");
    }
}

#[test]
fn more_workers_than_cores() {
    run_epochs(&mut pool(40), 5, 300);
    run_epochs(&mut pool(Pool::WORKERS_MAX), 6, 10);
}

#[test]
fn every_worker_takes_part() {
    for workers in WORKERS {
        let mut pool = pool(workers);
        let all = Barrier::new(workers);
        let met = AtomicUsize::new(0);
        for _ in 0..20 {
            // Ends only if as many threads as workers are in a task at the same time.
            pool.for_each(Stage::Solve, &mut vec![(); workers], |()| {
                all.wait();
                met.fetch_add(1, SeqCst);
            });
        }
        assert_eq!(met.into_inner(), 20 * workers);
    }
}

#[test]
fn caller_does_not_wait_for_workers_without_tasks() {
    let mut pool = pool(8);
    let caller = thread::current().id();
    for _ in 0..100 {
        pool.for_each(Stage::Solve, &mut [0], |_| assert_eq!(thread::current().id(), caller));
    }
}

#[test]
fn tasks_borrow_from_the_stack() {
    let mut values: Vec<usize> = vec![0; 1000];
    let offsets: Vec<usize> = (0..1000).collect();
    let mut tasks: Vec<(&mut [usize], &[usize])> = values.chunks_mut(7).zip(offsets.chunks(7)).collect();
    pool(3).for_each(Stage::Solve, &mut tasks, |(values, offsets)| values.copy_from_slice(offsets));
    assert_eq!(values, offsets);
}

#[test]
fn task_lists_of_any_length() {
    let mut pool = pool(3);
    for tasks in [0, 1, 2, 65_535, 65_536, 200_000] {
        let mut runs = vec![0_u8; tasks];
        pool.for_each(Stage::Solve, &mut runs, |runs| *runs += 1);
        assert!(runs.iter().all(|&runs| runs == 1), "{tasks} tasks");
    }
}

#[test]
fn first_panic_reaches_the_caller_and_the_pool_stays_usable() {
    for workers in WORKERS {
        let mut pool = pool(workers);
        for round in 0..200 {
            assert_eq!(panic_in(&mut pool, 90, &[round % 90]), Some(round % 90));
            assert_eq!(panic_in(&mut pool, 90, &[80, 30, 31, 89]), Some(30));
            assert_eq!(panic_in(&mut pool, 1, &[0]), Some(0));
            assert_eq!(panic_in(&mut pool, 90, &[]), None);
        }
        let everyone: Vec<usize> = (0..50).collect();
        assert_eq!(panic_in(&mut pool, 50, &everyone), Some(0));
        assert_eq!(panic_in(&mut pool, 70_000, &[66_000, 65_999]), Some(65_999));
        run_epochs(&mut pool, 9, 50);
    }
}

/// A payload whose drop panics too.
struct Bomb(AtomicUsize);

impl Drop for Bomb {
    fn drop(&mut self) {
        if self.0.load(SeqCst) != 0 {
            resume_unwind(Box::new("dropped"));
        }
    }
}

#[test]
fn payload_that_panics_when_dropped_ends_no_worker() {
    for workers in WORKERS {
        let mut pool = pool(workers);
        let outcome = catch_unwind(AssertUnwindSafe(|| {
            pool.for_each(Stage::Solve, &mut (0..30).collect::<Vec<usize>>(), |index| {
                resume_unwind(Box::new(Bomb(AtomicUsize::new(*index))));
            });
        }));
        let payload = outcome.expect_err("all tasks panic").downcast::<Bomb>();
        assert_eq!(payload.expect("a task's payload").0.load(SeqCst), 0, "the first task's");
        run_epochs(&mut pool, 10, 50);
    }
}

#[test]
fn many_pools_at_once() {
    thread::scope(|scope| {
        for seed in 0..6 {
            scope.spawn(move || {
                let mut first = pool(3);
                let mut second = pool(2);
                for round in 0..20 {
                    run_epochs(&mut first, seed + round, 10);
                    run_epochs(&mut second, seed * round, 10);
                }
            });
        }
    });
}

#[test]
fn pool_moves_between_threads() {
    let mut pool = pool(3);
    for seed in 0..20 {
        pool = thread::spawn(move || {
            run_epochs(&mut pool, seed, 20);
            pool
        })
        .join()
        .expect("the epochs are right");
    }
}

#[test]
fn drop_ends_the_threads_at_once() {
    let start = Instant::now();
    for _ in 0..100 {
        drop(pool(4));
    }
    for pause in [0, 1, 20] {
        let mut used = pool(8);
        run_epochs(&mut used, pause, 20);
        // Workers are awake after no pause and parked after the longest.
        thread::sleep(Duration::from_millis(pause));
    }
    assert!(start.elapsed() < Duration::from_secs(20), "no drop waits for a time-out: {:?}", start.elapsed());
}

#[test]
fn epochs_after_a_rest() {
    let mut pool = pool(4);
    for seed in 0..40 {
        run_epochs(&mut pool, seed, 5);
        thread::sleep(Duration::from_millis(2));
    }
}

#[test]
fn numbers_of_workers_out_of_range_are_refused() {
    for workers in [0, Pool::WORKERS_MAX + 1, usize::MAX] {
        match Pool::new(workers) {
            Err(error @ PoolError::WorkerCount(given)) => {
                assert_eq!(given, workers);
                assert_eq!(error.to_string(), format!("a pool has 1 to 256 workers, not {workers}"));
            }
            other => panic!("{workers} workers: {other:?}"),
        }
    }
}

/// A pyramid of boxes that slide and topple: pairs and contacts come and go.
fn toppling() -> World<Memory> {
    let mut world = new_world(Capacities::for_bodies(211)).expect("some megabytes");
    let ground = world.create_body(&BodyDef::new(BodyKind::Static, Vec3::ZERO)).expect("room");
    world.create_shape(ground, &ShapeDef::new(Geometry::HalfSpace)).expect("room");
    for row in 0..20 {
        for i in 0..20 - row {
            let place = Vec3::new(i as f32 + 0.5 * row as f32, 0.3 * (i % 2) as f32, 0.5 + row as f32);
            let body = world.create_body(&BodyDef::new(BodyKind::Dynamic, place)).expect("room");
            let shape = ShapeDef::new(Geometry::Box { half_extents: Vec3::splat(0.5) });
            world.create_shape(body, &shape).expect("room");
        }
    }
    world
}

#[test]
fn worlds_step_alike_with_any_number_of_workers() {
    let mut alone = toppling();
    for _ in 0..60 {
        alone.step(&mut Serial);
    }
    for workers in WORKERS {
        let (mut world, mut pool) = (toppling(), pool(workers));
        for _ in 0..60 {
            world.step(&mut pool);
        }
        assert_eq!(world.state(), alone.state(), "{workers} workers");
    }
}
