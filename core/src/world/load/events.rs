//! Events, visits and moved bodies, of unknown origin.

use super::{Checked, Parts, is_zero, require};
use crate::body::ASLEEP;
use crate::shape::TELLS_HITS;
use crate::state::{ROUSED_LEFT, TENANTS_LEFT, VISITS_DROPPED};

impl Parts<'_> {
    pub(super) fn check_events(&self) -> Checked {
        let header = &self.header;
        let marks = header.event_marks;
        require(marks & !(TENANTS_LEFT | VISITS_DROPPED | ROUSED_LEFT) == 0, "header", 0)?;
        let remembers = self.tenants.len() == header.shapes.high;
        require(marks & TENANTS_LEFT == 0 || remembers, "header", 0)?;
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
        self.check_news()
    }

    fn check_news(&self) -> Checked {
        let header = &self.header;
        for (i, row) in (0..).zip(self.news.iter()) {
            let moved = row.moved | row.called | row.slept;
            let roused = header.event_marks & ROUSED_LEFT != 0;
            require((moved | row.roused) & !self.body_used.get(i) == 0, "news", i)?;
            require(moved == 0 || header.settings.notes_moved(), "news", i)?;
            require(row.roused == 0 || roused, "news", i)?;
        }
        for slot in 0..header.bodies.high {
            let is_roused = self.news.get(slot / 64).roused >> (slot % 64) & 1 != 0;
            require(!is_roused || !self.bodies.get(slot).has(ASLEEP), "news", slot / 64)?;
        }
        Ok(())
    }
}
