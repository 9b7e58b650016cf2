//! Time of a run: by the wall, and of the processor for this thread alone, which other processes hardly disturb.

use std::time::Instant;

/// Milliseconds per step.
#[derive(Clone, Copy, Debug)]
pub struct Spent {
    pub wall: f64,
    /// Of the thread that steps; `None` where the system does not tell.
    pub thread: Option<f64>,
}

pub struct Clock {
    start: Instant,
    thread: Option<u64>,
}

impl Clock {
    pub fn start() -> Self {
        Clock { thread: thread_nanoseconds(), start: Instant::now() }
    }

    /// Per step of a run of `steps` steps.
    pub fn stop(self, steps: u32) -> Spent {
        let wall = self.start.elapsed().as_secs_f64() * 1e3 / f64::from(steps);
        let thread = thread_nanoseconds().zip(self.thread);
        Spent { wall, thread: thread.map(|(end, start)| (end - start) as f64 * 1e-6 / f64::from(steps)) }
    }
}

/// Time on a processor: the first number of Linux's `schedstat`.
fn thread_nanoseconds() -> Option<u64> {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").ok()?;
    text.split_whitespace().next()?.parse().ok()
}
