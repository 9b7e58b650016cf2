//! The barrier of the pool: tasks are published, claimed and completed.
//!
//! An **epoch** is one list of tasks, known here by their count alone. The caller publishes it, works on it
//! as worker 0, and waits until the count of unfinished tasks is zero. It waits for tasks, never for workers:
//! a worker that comes late finds nothing to claim, and the caller can drain an epoch alone.
//!
//! ```text
//! home word of a worker   | sleeping 1 | stopped 1 | epoch 30 | first 16 | end 16 |
//! ```
//! Every worker has a **home**: one atomic word with the epoch and the range of tasks that it starts with.
//! Its owner claims from the front, so it meets the same tasks in each epoch of a solve (their bodies are in
//! its cache); who has drained its home steals from the back of others. A claim is one compare-exchange, and
//! takes a fraction of what is left. The word is also the mailbox: the owner waits for its epoch to change,
//! and says in it that it sleeps.
//!
//! What the orderings guarantee; each claim is a loom model of the same name (`epoch/loom_models.rs`):
//!
//! - `publish_happens_before_claim`: what the caller wrote before [`Caller::publish`] is seen by whoever
//!   holds a [`Claim`] of that epoch. Publishing swaps with release, claiming is a compare-exchange with
//!   acquire, and every other change of the word is a read-modify-write, which continues the release
//!   sequence.
//! - `complete_happens_before_wait_returns`: what was done under a claim is seen after [`Caller::wait`].
//!   Completion is a `fetch_sub` with release on one counter, and the caller reads its zero with acquire.
//! - `claims_are_disjoint`: the claims of an epoch cover every task exactly once, because a range leaves the
//!   word in the same exchange that gives it to a worker.
//! - `late_worker_claims_only_live_tasks`: while a claim exists, its epoch is not complete and no other is
//!   published. A worker may look at a word, stall through any number of epochs, and try its exchange then:
//!   it fails, or, should the 30 bits have come round to the same word, it is a proper claim of the newer
//!   epoch. Hence nothing about an epoch may be read before the claim.
//! - `sleeping_worker_misses_no_publish`: the sleeping bit is set by a compare-exchange on the very word that
//!   publishing swaps, so one of the two sees the other; no fence is needed.
//! - `sleeping_caller_misses_no_completion`: the same with the waiting bit in the counter of tasks.
//! - `stop_reaches_every_worker`: the same swap with the stopped bit.
//!
//! Models run with `RUSTFLAGS="--cfg loom" cargo test -p cellstep --release --lib loom`.

use crate::spin::Spin;
use crate::sync::{AtomicU32, AtomicU64, Parker, Unparker};
use crossbeam_utils::CachePadded;
use std::ops::Range;
use std::sync::atomic::Ordering::{Acquire, Relaxed, Release};

#[cfg(all(test, loom))]
mod loom_models;

/// The most tasks of one epoch: what fits the 16 bits of a home word.
pub(crate) const TASKS_MAX: usize = u16::MAX as usize;

/// A claim takes one of this many parts of the tasks left in a home, rounded up. Fewer parts make fewer
/// claims; more parts leave less behind with a worker that loses its core. Measured on a pyramid of 1,830
/// boxes, two workers by one: 0.92 with 1 part (nothing can be stolen), 0.77 with 2, 4 and 8.
const CLAIM_PARTS: u16 = 4;

/// The caller sleeps until the counter reaches zero (in [`Barrier::unfinished`]).
const WAITING: u32 = 1 << 31;

/// What all threads of a pool share.
pub(crate) struct Barrier {
    homes: Box<[CachePadded<Home>]>,
    /// Tasks of the epoch that are not completed, and the caller's [`WAITING`].
    unfinished: CachePadded<AtomicU32>,
    caller: Unparker,
}

/// The caller's side. There is one per barrier, and its methods take it by `&mut`: epochs cannot overlap.
pub(crate) struct Caller {
    parker: Parker,
    epoch: u32,
    /// Workers to wake, kept for its memory.
    sleepers: Vec<usize>,
}

/// A worker's side, owned by its thread.
pub(crate) struct Worker {
    parker: Parker,
    index: usize,
    epoch: u32,
}

/// The right to run some tasks of the current epoch, and the duty to complete them. Only [`Barrier::claim`]
/// makes one, and it cannot be copied.
#[must_use = "an epoch ends when all its claims are completed"]
pub(crate) struct Claim {
    first: u16,
    end: u16,
}

impl Claim {
    /// Indices of the tasks.
    pub(crate) fn tasks(&self) -> Range<usize> {
        usize::from(self.first)..usize::from(self.end)
    }
}

impl Barrier {
    /// A barrier for the caller, who is worker 0, and `workers - 1` others.
    pub(crate) fn new(workers: usize) -> (Barrier, Caller, Vec<Worker>) {
        assert!(workers >= 1, "the caller is a worker");
        let caller = Caller { parker: Parker::new(), epoch: 0, sleepers: Vec::with_capacity(workers) };
        let others: Vec<Worker> =
            (1..workers).map(|index| Worker { parker: Parker::new(), index, epoch: 0 }).collect();
        let parkers = std::iter::once(&caller.parker).chain(others.iter().map(|worker| &worker.parker));
        let barrier = Barrier {
            homes: parkers.map(|parker| CachePadded::new(Home::new(parker))).collect(),
            unfinished: CachePadded::new(AtomicU32::new(0)),
            caller: caller.parker.unparker().clone(),
        };
        (barrier, caller, others)
    }

    /// Tasks for `worker`: from its home, else from the next home that has some. `None` when nothing is left
    /// to claim.
    pub(crate) fn claim(&self, worker: usize) -> Option<Claim> {
        let (before, from_own) = self.homes.split_at(worker);
        let (own, after) = from_own.split_first()?;
        own.claim(Side::Front).or_else(|| after.iter().chain(before).find_map(|home| home.claim(Side::Back)))
    }

    /// Gives a claim back, its tasks done.
    pub(crate) fn complete(&self, claim: Claim) {
        let tasks = u32::from(claim.end - claim.first);
        let before = self.unfinished.fetch_sub(tasks, Release);
        if before == tasks | WAITING {
            self.caller.unpark();
        }
    }
}

impl Caller {
    /// Starts an epoch of `tasks` tasks, at most [`TASKS_MAX`]. The previous one must have been waited for.
    pub(crate) fn publish(&mut self, barrier: &Barrier, tasks: u16) {
        debug_assert_eq!(barrier.unfinished.load(Relaxed) & !WAITING, 0, "one epoch at a time");
        self.epoch = (self.epoch + 1) & Word::EPOCH_MAX;
        // Nobody touches the counter without a claim, and the claims come from the swaps below.
        barrier.unfinished.store(u32::from(tasks), Relaxed);
        // More homes than tasks stay as they are, and their workers asleep.
        let active = barrier.homes.len().min(usize::from(tasks));
        let border = |k: usize| (k * usize::from(tasks) / active.max(1)) as u16;
        for (k, home) in barrier.homes[..active].iter().enumerate() {
            let old = home.swap(Word::new(self.epoch, border(k)..border(k + 1)));
            if old.has(Word::SLEEPING) {
                self.sleepers.push(k);
            }
        }
        self.wake_sleepers(barrier);
    }

    /// Returns when every task of the epoch is completed.
    pub(crate) fn wait(&mut self, barrier: &Barrier) {
        let mut spin = Spin::new();
        loop {
            if barrier.unfinished.load(Acquire) == 0 {
                return;
            }
            if !spin.again() {
                break;
            }
        }
        if barrier.unfinished.fetch_or(WAITING, Acquire) == 0 {
            return;
        }
        // A token of an earlier epoch may still arrive: `park` may return for nothing.
        while barrier.unfinished.load(Acquire) != WAITING {
            self.parker.park();
        }
    }

    /// Makes every worker leave.
    pub(crate) fn stop(&mut self, barrier: &Barrier) {
        for (k, home) in barrier.homes.iter().enumerate() {
            let old = home.swap(Word(Word::STOPPED));
            if old.has(Word::SLEEPING) {
                self.sleepers.push(k);
            }
        }
        self.wake_sleepers(barrier);
    }

    /// Waking is slow, so all words are written before the first sleeper is woken.
    fn wake_sleepers(&mut self, barrier: &Barrier) {
        for k in self.sleepers.drain(..) {
            barrier.homes[k].owner.unpark();
        }
    }
}

impl Worker {
    /// This worker's number, 1 or more.
    pub(crate) fn index(&self) -> usize {
        self.index
    }

    /// Waits for an epoch that is not the last one seen here. False when the pool has stopped.
    ///
    /// To be called when the last [`Barrier::claim`] found nothing.
    pub(crate) fn next_epoch(&mut self, barrier: &Barrier) -> bool {
        let home = &barrier.homes[self.index];
        let mut spin = Spin::new();
        loop {
            // Relaxed: nothing is read on the strength of this look, the claim acquires.
            let word = home.load();
            if word.has(Word::STOPPED) {
                return false;
            }
            if word.epoch() != self.epoch {
                self.epoch = word.epoch();
                return true;
            }
            if !spin.again() {
                home.sleep(word, &self.parker);
            }
        }
    }
}

/// From which end of a home's range tasks are taken.
#[derive(Clone, Copy)]
enum Side {
    Front,
    Back,
}

struct Home {
    word: AtomicU64,
    owner: Unparker,
}

impl Home {
    fn new(parker: &Parker) -> Self {
        Home { word: AtomicU64::new(Word::new(0, 0..0).0), owner: parker.unparker().clone() }
    }

    fn load(&self) -> Word {
        Word(self.word.load(Relaxed))
    }

    fn swap(&self, word: Word) -> Word {
        Word(self.word.swap(word.0, Release))
    }

    fn claim(&self, side: Side) -> Option<Claim> {
        let mut word = self.load();
        while word.len() > 0 {
            let (claim, rest) = word.split(side);
            match self.word.compare_exchange_weak(word.0, rest.0, Acquire, Relaxed) {
                Ok(_) => return Some(claim),
                Err(now) => word = Word(now),
            }
        }
        None
    }

    /// Parks the owner until the word is swapped; returns at once when it is no longer `seen`.
    fn sleep(&self, seen: Word, parker: &Parker) {
        debug_assert_eq!(seen.len(), 0, "the owner has drained its home");
        let asleep = seen.0 | Word::SLEEPING;
        if self.word.compare_exchange(seen.0, asleep, Relaxed, Relaxed).is_err() {
            return;
        }
        while self.load().has(Word::SLEEPING) {
            parker.park();
        }
    }
}

/// A home word; its picture is at the top of the file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Word(u64);

impl Word {
    const SLEEPING: u64 = 1 << 63;
    const STOPPED: u64 = 1 << 62;
    const EPOCH_MAX: u32 = (1 << 30) - 1;

    fn new(epoch: u32, tasks: Range<u16>) -> Self {
        Word(u64::from(epoch) << 32 | u64::from(tasks.start) << 16 | u64::from(tasks.end))
    }

    fn has(self, bit: u64) -> bool {
        self.0 & bit != 0
    }

    fn epoch(self) -> u32 {
        (self.0 >> 32) as u32 & Self::EPOCH_MAX
    }

    fn first(self) -> u16 {
        (self.0 >> 16) as u16
    }

    fn end(self) -> u16 {
        self.0 as u16
    }

    fn len(self) -> u16 {
        self.end() - self.first()
    }

    /// The tasks to claim, and the word that is left. The word has tasks, hence no bit set.
    fn split(self, side: Side) -> (Claim, Word) {
        let (first, end, taken) = (self.first(), self.end(), self.len().div_ceil(CLAIM_PARTS));
        match side {
            Side::Front => (Claim { first, end: first + taken }, Word::new(self.epoch(), first + taken..end)),
            Side::Back => (Claim { first: end - taken, end }, Word::new(self.epoch(), first..end - taken)),
        }
    }
}

#[cfg(all(test, not(loom)))]
mod tests {
    use super::*;

    /// Claims of one epoch, alternating between workers in a fixed but uneven pattern.
    fn drain(barrier: &Barrier, caller: &mut Caller, tasks: u16) -> Vec<u32> {
        let workers = barrier.homes.len();
        let mut runs = vec![0; usize::from(tasks)];
        caller.publish(barrier, tasks);
        for turn in 0.. {
            let Some(claim) = barrier.claim(turn * turn % workers) else { break };
            claim.tasks().for_each(|task| runs[task] += 1);
            barrier.complete(claim);
        }
        caller.wait(barrier);
        runs
    }

    #[test]
    fn claims_cover_every_task_once() {
        for workers in [1, 2, 3, 7, 256] {
            let (barrier, mut caller, _others) = Barrier::new(workers);
            for tasks in [1, 2, 3, 5, 64, 255, 256, 257, 1000, u16::MAX] {
                let runs = drain(&barrier, &mut caller, tasks);
                assert!(runs.iter().all(|&n| n == 1), "{workers} workers, {tasks} tasks: {runs:?}");
            }
        }
    }

    #[test]
    fn owner_claims_from_the_front_of_its_home_and_thief_from_the_back() {
        let (barrier, mut caller, _others) = Barrier::new(2);
        caller.publish(&barrier, 64);
        let claims = [1, 1, 0].map(|worker| barrier.claim(worker).expect("tasks are left"));
        let ranges = claims.each_ref().map(Claim::tasks);
        assert_eq!(ranges, [32..40, 40..46, 0..8]);
        claims.into_iter().for_each(|claim| barrier.complete(claim));
        while let Some(claim) = barrier.claim(0) {
            barrier.complete(claim);
        }
        caller.wait(&barrier);

        caller.publish(&barrier, 8);
        let own = barrier.claim(0).expect("tasks are left");
        assert_eq!(own.tasks(), 0..1);
        barrier.complete(own);
        let mut last = 0..0;
        while let Some(claim) = barrier.claim(0) {
            if last == (3..4) {
                assert_eq!(claim.tasks(), 7..8, "the first theft comes from the far end");
            }
            last = claim.tasks();
            barrier.complete(claim);
        }
        caller.wait(&barrier);
    }

    #[test]
    fn epoch_number_comes_round() {
        let (barrier, mut caller, mut others) = Barrier::new(2);
        caller.epoch = Word::EPOCH_MAX - 1;
        for expected in [Word::EPOCH_MAX, 0, 1] {
            assert_eq!(drain(&barrier, &mut caller, 5), [1; 5]);
            assert_eq!(caller.epoch, expected);
            assert!(others[0].next_epoch(&barrier));
            assert_eq!(others[0].epoch, expected);
        }
        caller.stop(&barrier);
        assert!(!others[0].next_epoch(&barrier));
    }

    #[test]
    fn word_keeps_its_parts_apart() {
        let word = Word::new(Word::EPOCH_MAX, 65_534..65_535);
        assert_eq!((word.epoch(), word.first(), word.end()), (Word::EPOCH_MAX, 65_534, 65_535));
        assert!(!word.has(Word::SLEEPING) && !word.has(Word::STOPPED));
        let asleep = Word(word.0 | Word::SLEEPING | Word::STOPPED);
        assert_eq!((asleep.epoch(), asleep.len()), (Word::EPOCH_MAX, 1));
    }
}
