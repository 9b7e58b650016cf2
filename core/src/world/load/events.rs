//! Events, visits and moved bodies, of unknown origin.

use super::{Checked, Parts, is_zero, require};
use crate::body::{ASLEEP, ROUSED};
use crate::shape::TELLS_HITS;
use crate::state::{ROUSED_LEFT, TENANTS_LEFT, VISITS_DROPPED};

impl Parts<'_> {
    pub(super) fn check_events(&self) -> Checked {
        let header = &self.header;
        let marks = header.event_marks;
        require(marks & !(TENANTS_LEFT | VISITS_DROPPED | ROUSED_LEFT) == 0, "header", 0)?;
        let (mut sensors, mut hit_shapes) = (0, 0);
        for slot in (0..header.shapes.high).filter(|&slot| self.shape_is_used(slot)) {
            let shape = self.shapes.get(slot);
            sensors += u32::from(shape.is_sensor());
            hit_shapes += u32::from(shape.flags & TELLS_HITS != 0);
        }
        require(header.sensors == sensors && header.hit_shapes == hit_shapes, "header", 0)?;
        for (i, row) in (0..).zip(self.events.iter()) {
            require(row.is_sound(), "events", i)?;
        }
        for (i, row) in (0..).zip(self.tenants.iter()) {
            let empty = row.generation == 0 && is_zero(&row);
            require(empty || (row.generation != 0 && marks & TENANTS_LEFT != 0), "tenants", i)?;
        }
        let mut before = None;
        for (i, row) in (0..).zip(self.visits.iter()) {
            let ascends = before.is_none_or(|before| before < row.key());
            let known = row.sensor.index < header.shapes.high && row.visitor.index < header.shapes.high;
            require(ascends && known, "visits", i)?;
            before = Some(row.key());
        }
        self.check_moved()
    }

    fn check_moved(&self) -> Checked {
        let header = &self.header;
        for (i, row) in (0..).zip(self.moved.iter()) {
            let bits = row.moved | row.called | row.slept;
            require(bits & !self.body_used.get(i) == 0, "moved", i)?;
            require(bits == 0 || header.settings.notes_moved(), "moved", i)?;
        }
        for slot in 0..header.bodies.high {
            let row = self.bodies.get(slot);
            let told = header.event_marks & ROUSED_LEFT != 0 && !row.has(ASLEEP);
            require(!row.has(ROUSED) || told, "bodies", slot)?;
        }
        Ok(())
    }
}
