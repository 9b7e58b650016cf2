//! Materials and rules for pairs, of unknown origin.

use super::{Checked, Parts, is_zero, require};
use crate::material::{MaterialRow, RULE_MATERIAL};
use crate::shape::{FRESH, ShapeRow};
use crate::state::Pair;

impl Parts<'_> {
    /// Materials are used as often as they say, in sum, and every shape's is there. Rules are sorted, and for what
    /// lives.
    pub(super) fn check_materials(&self) -> Checked {
        let high = self.header.materials;
        let mut uses = 0_u64;
        for index in 0..high {
            let row = self.materials.get(index);
            let sound = if row.uses == 0 { is_zero(&row) } else { row.read().is_some() };
            // The last row is in use: the mark is as low as it can be.
            require(sound && (row.uses > 0 || index + 1 < high), "materials", index)?;
            uses += u64::from(row.uses);
        }
        let mut left = uses;
        for slot in 0..self.header.shapes.high {
            if let Some(index) = self.shapes.get(slot).material() {
                require(index < high && left > 0 && self.materials.get(index).uses > 0, "shapes", slot)?;
                left -= 1;
            }
        }
        require(left == 0, "materials", 0)?;
        self.check_rules()
    }

    fn check_rules(&self) -> Checked {
        let mut before = None;
        for (i, rule) in self.pair_rules.iter().enumerate() {
            let lives = |&slot: &u32| {
                if rule.kind == RULE_MATERIAL { self.shape_is_used(slot) } else { self.body_is_used(slot) }
            };
            let ascends = before.is_none_or(|before| before < rule.key());
            require(ascends && rule.is_sound() && rule.slots.iter().all(lives), "pair_rules", i as u32)?;
            before = Some(rule.key());
        }
        Ok(())
    }

    /// True when a contact of two shapes may have a resistance, or ends before it is read.
    pub(super) fn may_resist(&self, pair: Pair) -> bool {
        [pair.a, pair.b].into_iter().any(|slot| {
            if !self.shape_is_used(slot) {
                return true;
            }
            let row: ShapeRow = self.shapes.get(slot);
            let traits = row.material().map_or(MaterialRow::NONE, |index| self.materials.get(index));
            row.flags & FRESH != 0 || traits.resists()
        })
    }
}
