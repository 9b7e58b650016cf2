//! Surfaces that move, and contacts that resist rolling and spinning, lane by lane.

use super::{Sides, inverse};
use crate::constraint::row::{LinkRow, ResistRow};
use crate::constraint::velocities::root_times;
use crate::lanes::{LANES, Lane, LaneVec};
use crate::math::{Rotation, Vec3, max};
use crate::pipeline::assembly::Scene;
use crate::pipeline::layout::EMPTY;

/// What the materials of a row's shapes say, for lanes whose surfaces act.
pub(super) struct Acts {
    /// Bit for each lane one of whose surfaces moves.
    pub belts: u32,
    /// Bit for each lane that resists.
    pub resists: u32,
    /// Velocity of B's surface less that of A's, in the world, m/s.
    pub velocity: LaneVec,
    rolling: Lane,
    spinning: Lane,
    /// Stored impulse of the resistance, for the solver's B.
    torque: LaneVec,
}

impl Acts {
    pub fn gather(scene: &Scene<'_>, contacts: &[u32; LANES]) -> Self {
        let (zero, none) = (Lane::ZERO, LaneVec::ZERO);
        let mut acts =
            Self { belts: 0, resists: 0, velocity: none, rolling: zero, spinning: zero, torque: none };
        for (lane, &contact) in contacts.iter().enumerate() {
            if contact == EMPTY || scene.touches[contact as usize].settled >= 0.0 {
                continue;
            }
            acts.add(scene, contact as usize, lane);
        }
        acts
    }

    fn add(&mut self, scene: &Scene<'_>, contact: usize, lane: usize) {
        let (touch, row) = (&scene.touches[contact], &scene.contacts[contact]);
        let [a, b] = touch.shapes.map(|slot| scene.shapes[slot as usize].traits(scene.materials));
        if a.moves() || b.moves() {
            let [va, vb] = [(a, touch.shapes[0]), (b, touch.shapes[1])].map(|(row, slot)| {
                let x = scene.frames[slot as usize].to_array();
                Rotation::new(x[4], x[5], x[6], x[7]).rotate(row.surface_velocity)
            });
            self.belts |= 1 << lane;
            self.velocity.set(lane, vb - va);
        }
        if row.can_resist() && (a.resists() || b.resists()) {
            self.resists |= 1 << lane;
            self.rolling.set(lane, max(a.rolling, b.rolling));
            self.spinning.set(lane, max(a.spinning, b.spinning));
            self.torque.set(lane, row.resistance() * touch.sign());
        }
    }

    /// The sliding velocity with that of the surfaces; lanes whose surfaces stand still keep theirs.
    pub fn slide(&self, sliding: LaneVec) -> LaneVec {
        let moves = self.velocity.dot(self.velocity).greater(Lane::ZERO);
        moves.select_vec(sliding + self.velocity, sliding)
    }

    /// Writes the resistance of a row whose tangents are known.
    pub fn write_resistance(&self, sides: &Sides, row: &LinkRow, resist: &mut ResistRow) {
        let (n, t) = (row.normal, row.tangent);
        let axes = [t, n.cross(t), n];
        resist.turns_a = axes.map(|axis| root_times(&sides.a.root, axis));
        resist.turns_b = axes.map(|axis| root_times(&sides.b.root, axis));
        let [a, b] = [&resist.turns_a, &resist.turns_b];
        // As the tangents' block: a step of the inverse of its greatest eigenvalue cannot overshoot.
        let product = |i: usize, k: usize| a[i].dot(a[k]) + b[i].dot(b[k]);
        let (p, q, r) = (product(0, 0), product(1, 1), product(0, 1));
        let half = Lane::splat(0.5) * (p - q);
        resist.roll_mass = inverse(Lane::splat(0.5) * (p + q) + (half * half + r * r).sqrt());
        resist.spin_mass = inverse(product(2, 2));
        (resist.rolling, resist.spinning) = (self.rolling, self.spinning);
        let along = |v: LaneVec| LaneVec::new(axes[0].dot(v), axes[1].dot(v), axes[2].dot(v));
        resist.impulse = along(self.torque);
        let mut turning = LaneVec::ZERO;
        for lane in 0..LANES {
            if sides.surfaces >> lane & 1 != 0 {
                turning.set(lane, sides.b.angular.get(lane));
            }
        }
        resist.surface = along(turning);
    }
}

/// The impulse of a lane's resistance on B, N m s in the world; `None` where there is none.
pub(crate) fn resistance(resist: &ResistRow, (n, t): (Vec3, Vec3), lane: usize) -> Option<Vec3> {
    let x = resist.impulse.get(lane);
    let acts = resist.rolling.get(lane) > 0.0 || resist.spinning.get(lane) > 0.0;
    acts.then(|| t * x.x + n.cross(t) * x.y + n * x.z)
}
