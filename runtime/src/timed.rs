//! Where the time of a step goes.
//!
//! The core owns no clock; [`Timed`] wraps any executor and takes the times of its calls. It changes no
//! result.

use cellstep_core::executor::{Executor, Stage};
use std::time::{Duration, Instant};

/// The time spent in one stage.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct StageTime {
    /// From the stage's start to the next one's, wall-clock.
    pub total: Duration,
    /// The part of `total` in `for_each`: what more workers can shorten.
    pub parallel: Duration,
    /// Calls of `for_each` with two tasks or more: each ends in one barrier when there are several workers.
    pub barriers: u64,
}

impl StageTime {
    /// The part outside of `for_each`, on one thread however many workers there are.
    pub fn serial(&self) -> Duration {
        self.total.saturating_sub(self.parallel)
    }

    fn add(&mut self, other: &StageTime) {
        self.total += other.total;
        self.parallel += other.parallel;
        self.barriers += other.barriers;
    }
}

/// The times of all stages, summed over steps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct StepTimes {
    /// How many steps were completed.
    pub steps: u64,
    stages: [StageTime; Stage::COUNT],
}

impl StepTimes {
    /// The time of one stage.
    pub fn stage(&self, stage: Stage) -> StageTime {
        self.stages[stage as usize]
    }

    /// The sum over all stages.
    pub fn sum(&self) -> StageTime {
        let mut sum = StageTime::default();
        for stage in &self.stages {
            sum.add(stage);
        }
        sum
    }
}

/// An executor that takes the times of another.
#[derive(Debug)]
pub struct Timed<E> {
    executor: E,
    times: StepTimes,
    /// The stage that is running, and since when.
    open: Option<(Stage, Instant)>,
}

impl<E: Executor> Timed<E> {
    /// Takes the times of `executor`, all zero at first.
    pub fn new(executor: E) -> Self {
        Timed { executor, times: StepTimes::default(), open: None }
    }

    /// The times since the start, or since the last [`Timed::take`].
    pub fn times(&self) -> &StepTimes {
        &self.times
    }

    /// The times, which start again from zero.
    pub fn take(&mut self) -> StepTimes {
        std::mem::take(&mut self.times)
    }

    /// The executor whose times are taken.
    pub fn executor(&self) -> &E {
        &self.executor
    }

    /// The executor, without the clock.
    pub fn into_executor(self) -> E {
        self.executor
    }

    fn close(&mut self, now: Instant) {
        if let Some((stage, since)) = self.open.take() {
            self.times.stages[stage as usize].total += now - since;
        }
    }
}

impl<E: Executor> Executor for Timed<E> {
    fn for_each<T: Send>(&mut self, stage: Stage, tasks: &mut [T], run: impl Fn(&mut T) + Sync) {
        let several = tasks.len() >= 2;
        // Out of the way while tasks run: after a panic the next step must not count the time in between.
        let open = self.open.take();
        let start = Instant::now();
        self.executor.for_each(stage, tasks, run);
        let spent = start.elapsed();
        let time = &mut self.times.stages[stage as usize];
        time.parallel += spent;
        time.barriers += u64::from(several);
        if open.is_none() {
            time.total += spent;
        }
        self.open = open;
    }

    fn enter(&mut self, stage: Stage) {
        let now = Instant::now();
        self.close(now);
        self.executor.enter(stage);
        self.open = Some((stage, now));
    }

    fn leave(&mut self) {
        self.executor.leave();
        self.close(Instant::now());
        self.times.steps += 1;
    }
}

#[cfg(all(test, not(loom)))]
mod tests {
    use super::*;
    use cellstep_core::executor::Serial;
    use std::panic::{AssertUnwindSafe, catch_unwind};
    use std::thread::sleep;

    const PAUSE: Duration = Duration::from_millis(4);

    #[test]
    fn times_add_up_by_stage() {
        let mut timed = Timed::new(Serial);
        let start = Instant::now();
        for _ in 0..2 {
            timed.enter(Stage::Narrowphase);
            timed.for_each(Stage::Narrowphase, &mut [0, 1], |_| sleep(PAUSE));
            sleep(PAUSE);
            timed.enter(Stage::Solve);
            timed.for_each(Stage::Solve, &mut [0], |_| sleep(PAUSE));
            timed.for_each(Stage::Solve, &mut [0; 0], |_| ());
            timed.leave();
        }
        let wall = start.elapsed();
        let times = timed.take();
        assert_eq!(times.steps, 2);
        let narrowphase = times.stage(Stage::Narrowphase);
        assert!(narrowphase.parallel >= 4 * PAUSE && narrowphase.serial() >= 2 * PAUSE);
        assert_eq!(narrowphase.barriers, 2);
        let solve = times.stage(Stage::Solve);
        assert!(solve.parallel >= 2 * PAUSE && solve.total >= solve.parallel);
        assert_eq!(solve.barriers, 0, "one task needs no barrier");
        assert_eq!(times.stage(Stage::Finish), StageTime::default());
        let sum = times.sum();
        assert_eq!(sum.total, narrowphase.total + solve.total);
        assert!(sum.total <= wall && sum.serial() + sum.parallel == sum.total);
        assert_eq!(*timed.times(), StepTimes::default());
    }

    #[test]
    fn time_between_steps_counts_nowhere() {
        let mut timed = Timed::new(Serial);
        let start = Instant::now();
        timed.enter(Stage::Finish);
        timed.leave();
        sleep(10 * PAUSE);
        timed.enter(Stage::Broadphase);
        let outcome = catch_unwind(AssertUnwindSafe(|| {
            timed.for_each(Stage::Broadphase, &mut [0], |_| std::panic::panic_any(1))
        }));
        assert!(outcome.is_err());
        sleep(10 * PAUSE);
        timed.enter(Stage::Broadphase);
        timed.leave();
        assert!(timed.times().sum().total + 20 * PAUSE <= start.elapsed());
        assert_eq!(timed.times().steps, 2);
    }

    #[test]
    fn call_outside_of_a_stage_counts_for_its_own() {
        let mut timed = Timed::new(Serial);
        timed.for_each(Stage::Assembly, &mut [0, 0], |_| sleep(PAUSE));
        let assembly = timed.times().stage(Stage::Assembly);
        assert!(assembly.total >= 2 * PAUSE);
        assert_eq!(assembly.total, assembly.parallel);
    }
}
