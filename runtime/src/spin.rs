//! How long a thread waits awake before it parks.
//!
//! Parking and waking cost microseconds, and a step has dozens of barriers, so a waiting thread first stays
//! awake: a short spin, then yields, which hand the core to a thread that has work. With more workers than
//! cores a spin only steals time from whoever is waited for; therefore the spin is short and the yields do
//! the waiting. An idle pool parks within some tens of microseconds and then costs nothing.

#[cfg(not(loom))]
use crossbeam_utils::Backoff;

/// Yields after the backoff's own few. On an idle core a yield returns in less than a microsecond, so this
/// many bridge the serial part between two barriers of a small scene; on a busy core each gives a time slice
/// away.
#[cfg(not(loom))]
const YIELDS: u32 = 32;

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
