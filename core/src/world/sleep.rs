//! Falling asleep and waking, as far as calls go; `pipeline/sleep.rs` has the rest.

use super::World;
use crate::arena::Line;
use crate::body::{ASLEEP, SLEEPLESS, WAKES};
use crate::error::Error;
use crate::handle::BodyHandle;
use crate::state::State;

impl<M: AsRef<[Line]> + AsMut<[Line]>> World<M> {
    /// True when the body sleeps: it is not solved, and rests where it is until something wakes it.
    ///
    /// # Errors
    /// [`Error::Stale`].
    pub fn is_asleep(&self, body: BodyHandle) -> Result<bool, Error> {
        Ok(self.body_row(body)?.has(ASLEEP))
    }

    /// Wakes the body, and what it touches, in the next step. Calls that change a body do this by themselves.
    ///
    /// # Errors
    /// [`Error::Stale`].
    pub fn wake(&mut self, body: BodyHandle) -> Result<(), Error> {
        let slot = self.body_slot(body)?;
        wake_slot(&mut self.state_view(), slot);
        Ok(())
    }

    /// Lets the body fall asleep, or keeps it awake.
    ///
    /// # Errors
    /// [`Error::Stale`].
    pub fn set_can_sleep(&mut self, body: BodyHandle, can_sleep: bool) -> Result<(), Error> {
        let slot = self.body_slot(body)?;
        let mut state = self.state_view();
        wake_slot(&mut state, slot);
        let row = &mut state.bodies[slot];
        row.flags = if can_sleep { row.flags & !SLEEPLESS } else { row.flags | SLEEPLESS };
        Ok(())
    }
}

/// The body was changed: it starts to be quiet anew, and wakes with what it touches.
pub(super) fn wake_slot(state: &mut State<'_>, slot: usize) {
    state.bodies[slot].count_quiet(false);
    if state.header[0].asleep > 0 {
        state.bodies[slot].flags |= WAKES;
        state.header[0].wakes = 1;
    }
}

/// Wakes every body that sleeps.
pub(super) fn wake_all(state: &mut State<'_>) {
    if state.header[0].asleep == 0 {
        return;
    }
    for slot in 0..state.header[0].bodies.high as usize {
        if state.bodies[slot].has(ASLEEP) {
            wake_slot(state, slot);
        }
    }
}
