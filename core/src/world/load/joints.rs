//! Joints of unknown origin: every row, every list.

use super::{Checked, Limits, Parts, check_pool, is_zero, require};
use crate::cells::{CELLULAR_PHASES_MAX, UNORDERED};
use crate::handle::BodyHandle;
use crate::joint::{AxisRow, Joint};
use crate::state::JOINT_BOUNDS;

impl Parts<'_> {
    pub(super) fn check_joints(&self, limits: &Limits<'_>) -> Checked {
        let header = &self.header;
        let capacity = limits.joints;
        check_pool(&header.joints, &self.joint_used, &self.joint_generations, capacity, "joint_used")?;
        let mut bounds = 0;
        for slot in 0..header.joints.high {
            require(self.joint_holds(slot), "joints", slot)?;
            if self.joint_is_used(slot) {
                bounds += self.joints.get(slot).signature().bound_rows() as u64;
            }
        }
        let room = JOINT_BOUNDS as u64 * u64::from(capacity);
        require(header.joint_bounds as u64 == bounds && bounds <= room, "header", 0)?;
        require(header.joints_stale <= 1, "header", 0)?;
        self.check_joint_lists()
    }

    fn joint_is_used(&self, slot: u32) -> bool {
        slot < self.header.joints.high && self.joint_used.get(slot / 64) >> (slot % 64) & 1 == 1
    }

    fn joint_holds(&self, slot: u32) -> bool {
        let row = Joint { row: self.joints.get(slot), axes: self.joint_axes.get(slot) };
        if !self.joint_is_used(slot) {
            return is_zero(&row.row) && is_zero(&row.axes);
        }
        let phase = row.phase == u32::from(UNORDERED) || row.phase < CELLULAR_PHASES_MAX as u32;
        let defined = row.read([BodyHandle::default(); 2]).is_some_and(|def| def.check().is_ok());
        row.bodies.iter().all(|&body| self.body_is_used(body))
            && row.bodies[0] != row.bodies[1]
            && phase
            && defined
            && row.is_finite()
            && row.axes.iter().all(AxisRow::is_finite)
    }

    /// Every joint is in the lists of its two bodies, once.
    fn check_joint_lists(&self) -> Checked {
        let mut listed = 0;
        for body in 0..self.first_joints.len() {
            let mut next = self.first_joints.get(body);
            require(next == 0 || self.body_is_used(body), "first_joints", body)?;
            while next != 0 {
                // A list that runs in a circle, or into another, counts more joints than there are.
                listed += 1;
                let slot = next - 1;
                let holds = self.joint_is_used(slot)
                    && self.joints.get(slot).bodies.contains(&body)
                    && listed <= 2 * self.header.joints.count;
                require(holds, "first_joints", body)?;
                next = self.joints.get(slot).next_of(body);
            }
        }
        require(listed == 2 * self.header.joints.count, "first_joints", 0)
    }
}
