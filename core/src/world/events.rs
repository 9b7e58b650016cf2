//! Reading events, visits to sensors, and which bodies moved.

use super::World;
use crate::arena::Line;
use crate::error::Error;
use crate::event::{Event, MovedBody, ShapeEvents, Tenant, Visit};
use crate::handle::{BodyHandle, ShapeHandle};
use crate::pipeline::events;
use crate::pool;
use crate::shape::{ShapeRow, TELLS_HITS, check_shape_events};
use crate::state::{State, TENANTS_LEFT};

impl<M: AsRef<[Line]> + AsMut<[Line]>> World<M> {
    /// What happened in the last step, in the order of its stages: see [`EventKind`](crate::EventKind). None
    /// without [`Capacities::events`](crate::Capacities::events).
    pub fn events(&self) -> impl Iterator<Item = Event> + '_ {
        let step = self.steps();
        let rows = &self.layout.state.events.of(self.state())[..self.header().events as usize];
        rows.iter().filter_map(move |row| row.read().map(|kind| Event { step, kind }))
    }

    /// The shapes that are in a sensor at the end of the last step, ascending by slot, as far as
    /// [`Capacities::sensor_visits`](crate::Capacities::sensor_visits) goes. Those that were removed since are
    /// left out.
    ///
    /// A shape is in a sensor when the two overlap or touch at the poses at the end of the step, their filters
    /// meet, and the shape's body is of a kind that the sensor detects and not the sensor's own. It need not be
    /// awake. Sensors do not detect each other, surfaces (half-spaces, meshes, height fields) not one another,
    /// and what passes through a sensor within one step is not detected. Joints do not matter.
    ///
    /// # Errors
    /// [`Error::Stale`]. A shape that is no sensor has no visits.
    pub fn visits(&self, sensor: ShapeHandle) -> Result<impl Iterator<Item = Visit> + '_, Error> {
        self.shape_slot(sensor)?;
        let rows = &self.layout.state.visits.of(self.state())[..self.header().visits as usize];
        let first = rows.partition_point(|visit| visit.sensor.index < sensor.index);
        let own = rows[first..].iter().take_while(move |visit| visit.sensor.index == sensor.index);
        Ok(own.filter(move |visit| visit.sensor == sensor && self.shape_slot(visit.visitor).is_ok()).copied())
    }

    /// Changes what about a shape events are made of.
    ///
    /// # Errors
    /// [`Error::Stale`], or [`Error::OutOfRange`] for bits that stand for nothing.
    pub fn set_shape_events(&mut self, shape: ShapeHandle, wanted: ShapeEvents) -> Result<(), Error> {
        let slot = self.shape_slot(shape)?;
        check_shape_events(wanted)?;
        let state = self.state_view();
        let row = &mut state.shapes[slot];
        state.header[0].hit_shapes -= u32::from(row.flags & TELLS_HITS != 0);
        row.set_events(wanted);
        state.header[0].hit_shapes += u32::from(row.flags & TELLS_HITS != 0);
        Ok(())
    }

    /// The bodies that are elsewhere, or turned otherwise, than at the end of the step before the last: those
    /// that the last step moved, and those that calls created or put elsewhere before it or after it. Ascending
    /// by slot. The time does not depend on how many bodies rest, but for a bit each. None unless
    /// [`Settings::moved_list`](crate::Settings::moved_list).
    ///
    /// For a renderer that shows poses between the last two steps, see
    /// [`interpolated`](crate::clock::interpolated): a body that is not in the list stands where it was in
    /// both.
    pub fn moved_bodies(&self) -> impl Iterator<Item = MovedBody> + '_ {
        let spans = &self.layout.state;
        let words = spans.news.of(self.state());
        let (bodies, motions) = (spans.bodies.of(self.state()), spans.motions.of(self.state()));
        let generations = spans.body_generations.of(self.state());
        events::moved_slots(words, self.header().bodies.high).map(move |index| {
            let slot = index as usize;
            let motion = &motions[slot];
            MovedBody {
                body: BodyHandle { index, generation: generations[slot] },
                position: motion.center.plus(motion.origin_offset(&bodies[slot])),
                rotation: motion.rotation,
                fell_asleep: words[slot / 64].slept >> (slot % 64) & 1 != 0,
            }
        })
    }
}

/// Counts a new shape among sensors and those whose hits are told.
pub(super) fn count_shape(state: &mut State<'_>, slot: usize) {
    let row = &state.shapes[slot];
    state.header[0].sensors += u32::from(row.is_sensor());
    state.header[0].hit_shapes += u32::from(row.flags & TELLS_HITS != 0);
}

/// A shape is removed: takes it off the counts, and remembers whose contacts end.
pub(super) fn forget_shape(state: &mut State<'_>, slot: usize) {
    let ShapeRow { body, flags, .. } = state.shapes[slot];
    state.header[0].sensors -= u32::from(state.shapes[slot].is_sensor());
    state.header[0].hit_shapes -= u32::from(flags & TELLS_HITS != 0);
    let body = events::body_handle(state, body);
    let generation = state.shape_generations[slot];
    if let Some(tenant) = state.tenants.get_mut(slot).filter(|tenant| tenant.generation == 0) {
        *tenant = Tenant { generation, body, flags };
        state.header[0].event_marks |= TENANTS_LEFT;
    }
}

/// A body is removed: there is no news of it.
pub(super) fn forget_body(state: &mut State<'_>, slot: usize) {
    let word = &mut state.news[slot / 64];
    let others = !(1 << (slot % 64));
    (word.moved, word.called) = (word.moved & others, word.called & others);
    (word.slept, word.roused) = (word.slept & others, word.roused & others);
}

/// Whether anything moved is noted no longer.
pub(super) fn forget_moved(state: &mut State<'_>) {
    let count = pool::words(state.header[0].bodies.high as usize);
    for word in &mut state.news[..count] {
        (word.moved, word.called, word.slept) = (0, 0, 0);
    }
}
