//! How long a thread waits awake before it parks.
//!
//! Parking and waking cost microseconds, and a step has dozens of barriers, so a waiting thread first stays
//! awake: a short spin, then yields, which hand the core to a thread that has work. With more workers than
//! cores a spin only steals time from whoever is waited for; therefore the spin is short and the yields do
//! the waiting. An idle pool parks within some hundreds of microseconds and then costs nothing.

#[cfg(not(loom))]
use crossbeam_utils::Backoff;

/// Yields after the backoff's own few. On an idle core one takes about 0.25 microseconds, so this many bridge the
/// serial parts between the barriers of a step, where waking parked threads costs far more; on a busy core each
/// gives a time slice away. Measured on two cores, a step's time with two workers by that with one:
///
/// | yields | pyramid of 1,830 boxes | of 190 boxes | pile of 200 |
/// |---|---|---|---|
/// | 32 | 0.72 | 1.08 | 0.78 |
/// | 128 | 0.66 | 0.96 | 0.78 |
/// | 512 | 0.62 | 0.94 | 0.72 |
/// | 2048 | 0.61 | 0.93 | 0.72 |
///
/// and with 16 workers on one core, where waiting awake could only harm, 1.01 to 1.02 for all of them.
#[cfg(not(loom))]
const YIELDS: u32 = 512;

/// One wait: ask [`Spin::again`] between two looks at what is waited for.
#[cfg(not(loom))]
pub(crate) struct Spin {
    backoff: Backoff,
    yields: u32,
}

#[cfg(not(loom))]
impl Spin {
    pub(crate) fn new() -> Self {
        Spin { backoff: Backoff::new(), yields: 0 }
    }

    /// Passes a little time and returns true; false when it is time to park.
    pub(crate) fn again(&mut self) -> bool {
        if !self.backoff.is_completed() {
            self.backoff.snooze();
            return true;
        }
        if self.yields == YIELDS {
            return false;
        }
        self.yields += 1;
        std::thread::yield_now();
        true
    }
}

/// In a model nobody spins: looking again at an unchanged word adds no behaviour, only interleavings.
#[cfg(loom)]
pub(crate) struct Spin;

#[cfg(loom)]
impl Spin {
    pub(crate) fn new() -> Self {
        Spin
    }

    pub(crate) fn again(&mut self) -> bool {
        false
    }
}
