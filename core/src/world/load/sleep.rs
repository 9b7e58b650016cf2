//! What sleeps, of unknown origin.

use super::{Checked, Parts, require};
use crate::body::{ASLEEP, WAKES};
use crate::cells::UNORDERED;
use crate::state::{AssetTables, Pair};

impl Parts<'_> {
    pub(super) fn check_sleep(&self, assets: &AssetTables<'_>) -> Checked {
        let mut asleep = 0;
        for slot in 0..self.header.bodies.high {
            let row = self.bodies.get(slot);
            require(!row.has(ASLEEP) || row.is_dynamic(), "bodies", slot)?;
            require(!row.has(WAKES) || self.header.wakes == 1, "bodies", slot)?;
            asleep += u32::from(row.has(ASLEEP));
        }
        require(asleep == self.header.asleep && self.header.wakes <= 1, "header", 0)?;
        let mut before = None;
        for (i, pair) in self.asleep_pairs.iter().enumerate() {
            let ascends = before.is_none_or(|before| before < pair);
            let known = pair.a < pair.b && pair.b < self.header.shapes.high;
            require(ascends && known && self.may_sleep(pair), "asleep_pairs", i as u32)?;
            before = Some(pair);
        }
        let mut before = None;
        for (i, row) in self.asleep_contacts.iter().enumerate() {
            let ascends = before.is_none_or(|before| before < row.key());
            let holds = row.tag.phase() == UNORDERED && self.contact_is_sound(&row, assets);
            require(ascends && holds, "asleep_contacts", i as u32)?;
            before = Some(row.key());
        }
        Ok(())
    }

    /// A pair that may be collided when it wakes must be one that can be; of shapes that are gone nothing is read.
    fn may_sleep(&self, pair: Pair) -> bool {
        !self.shape_is_used(pair.a) || !self.shape_is_used(pair.b) || self.can_meet(pair)
    }
}
