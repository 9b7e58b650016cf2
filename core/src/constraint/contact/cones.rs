//! Friction with a cone for each point: `|lambda_t| <= mu lambda_n`, point by point.
//!
//! The points of a contact lie in its plane, and what slides on a plane moves as a rigid body there. So the rates
//! of a point at `(p, q)` along the tangents follow from those of the patch at its middle, `x`, `y` and the twist
//! `z`, and its impulses add up to those of the patch:
//! ```text
//! rates     x - q z,  y + p z
//! impulses  x,        y,        p y - q x
//! ```
//! The row's tangents and twist therefore serve as they are: their impulses are the sums of the points', which is
//! what warm-starts, follows slides, and is read by others. Only here are the points told apart.
//!
//! What each point got is not kept from step to step: at the start of one the patch's impulse is dealt to the
//! points by their loads (`pipeline/rows/cones.rs`).

use super::{Friction, Shift};
use crate::constraint::row::{ConeRow, LinkRow, PointRow};
use crate::constraint::velocities::Velocities;
use crate::lanes::{Lane, LaneVec, Mask};

/// What the points of a row are bounded by and move by, with the arms of now.
pub(super) struct Rates {
    /// Rates of the patch: along the tangents and about the normal.
    pub x: Lane,
    pub y: Lane,
    pub z: Lane,
    yields: [Lane; 6],
    /// B's jacobians of the tangents.
    first_b: LaneVec,
    second_b: LaneVec,
    second: LaneVec,
}

impl Rates {
    #[inline(always)]
    pub fn new(u: &Velocities, row: &LinkRow, cones: &ConeRow, (shift, surfaces): (&Shift, bool)) -> Self {
        let second = row.normal.cross(row.tangent);
        let first_b = shift.apply(row.first_b, shift.first);
        let second_b = shift.apply(row.second_b, shift.second);
        let surface = if surfaces { row.surface } else { LaneVec::ZERO };
        let mut yields = cones.yields;
        if shift.any {
            let now = yields_of(row, u.ma + u.mb, (first_b, second_b));
            for (own, now) in yields.iter_mut().zip(now) {
                *own = shift.slides.select(now, *own);
            }
        }
        Self {
            x: u.rate(row.tangent, row.first_a, first_b) + surface.x,
            y: u.rate(second, row.second_a, second_b) + surface.y,
            z: row.twist_b.dot(u.wb) - row.twist_a.dot(u.wa) + surface.z,
            yields,
            first_b,
            second_b,
            second,
        }
    }

    /// Rates of the point at a place.
    #[inline(always)]
    pub fn at(&self, [p, q]: [Lane; 2]) -> [Lane; 2] {
        [self.x - q * self.z, self.y + p * self.z]
    }

    /// The step of point `i`.
    #[inline(always)]
    pub fn step(&self, cones: &ConeRow, i: usize, shift: &Shift) -> Lane {
        let mass = cones.masses[i];
        if !shift.any {
            return mass;
        }
        let has = mass.greater(Lane::ZERO);
        shift.slides.and(has).select(step_of(&self.yields, cones.places[i]), mass)
    }

    /// Brings the rates to an impulse of the patch.
    #[inline(always)]
    fn push(&mut self, [dx, dy, dz]: [Lane; 3]) {
        let [xx, yy, zz, xy, xz, yz] = self.yields;
        self.x = self.x + (xx * dx + xy * dy + xz * dz);
        self.y = self.y + (xy * dx + yy * dy + yz * dz);
        self.z = self.z + (xz * dx + yz * dy + zz * dz);
    }
}

/// `J M^-1 Jt` of a row's tangents and twist, as [`ConeRow::yields`]. `free` has the inverse masses of both bodies
/// along the axes, added.
#[inline(always)]
pub(crate) fn yields_of(row: &LinkRow, free: LaneVec, (first_b, second_b): (LaneVec, LaneVec)) -> [Lane; 6] {
    let (t, s) = (row.tangent, row.normal.cross(row.tangent));
    let (first_a, second_a, za, zb) = (row.first_a, row.second_a, row.twist_a, row.twist_b);
    [
        t.dot(t.each_times(free)) + first_a.dot(first_a) + first_b.dot(first_b),
        s.dot(s.each_times(free)) + second_a.dot(second_a) + second_b.dot(second_b),
        za.dot(za) + zb.dot(zb),
        t.dot(s.each_times(free)) + first_a.dot(second_a) + first_b.dot(second_b),
        first_a.dot(za) + first_b.dot(zb),
        second_a.dot(za) + second_b.dot(zb),
    ]
}

/// 1 / greatest eigenvalue of the 2x2 block of the tangents at a place: a step of it cannot overshoot, where
/// inverting the block and clamping to the disc stalls. 0 where nothing can move.
#[inline(always)]
pub(crate) fn step_of(yields: &[Lane; 6], [p, q]: [Lane; 2]) -> Lane {
    let [xx, yy, zz, xy, xz, yz] = *yields;
    let (half, one, two) = (Lane::splat(0.5), Lane::splat(1.0), Lane::splat(2.0));
    let first = xx + q * (q * zz - two * xz);
    let second = yy + p * (p * zz + two * yz);
    let mixed = xy + (p * xz - q * (yz + p * zz));
    let difference = half * (first - second);
    let most = half * (first + second) + (difference * difference + mixed * mixed).sqrt();
    let moves = most.greater(Lane::splat(f32::MIN_POSITIVE));
    moves.keep(one / moves.select(most, one))
}

/// Brings an impulse into a disc, along its radius; and where it was outside.
#[inline(always)]
pub(crate) fn into_disc([x, y]: [Lane; 2], limit: Lane) -> ([Lane; 2], Mask) {
    let one = Lane::splat(1.0);
    let square = x * x + y * y;
    let outside = square.greater(limit * limit);
    let scale = outside.select(limit / outside.select(square.sqrt(), one), one);
    ([x * scale, y * scale], outside)
}

impl Friction for ConeRow {
    /// One point after the other; the bodies get the sum.
    #[inline(always)]
    fn solve<const N: usize>(
        &mut self,
        u: &mut Velocities,
        row: &mut LinkRow,
        points: &[PointRow; N],
        motion: (&Shift, bool),
    ) -> LaneVec {
        let mut rates = Rates::new(u, row, self, motion);
        let mut sum = [Lane::ZERO; 3];
        for (i, point) in points.iter().enumerate() {
            let ([p, q], [was_x, was_y]) = (self.places[i], self.impulses[i]);
            let ([rate_x, rate_y], mass) = (rates.at([p, q]), rates.step(self, i, motion.0));
            let limit = row.friction * point.impulse;
            let (wanted, _) = into_disc([was_x - mass * rate_x, was_y - mass * rate_y], limit);
            let [x, y] = wanted.map(|impulse| impulse.finite().flushed());
            let (dx, dy) = (x - was_x, y - was_y);
            rates.push([dx, dy, p * dy - q * dx]);
            self.impulses[i] = [x, y];
            sum = [sum[0] + x, sum[1] + y, sum[2] + (p * y - q * x)];
        }
        let [x, y, z] = sum;
        let (dx, dy, dz) = (x - row.first_impulse, y - row.second_impulse, z - row.twist_impulse);
        u.apply_torque(row.first_a, rates.first_b, dx);
        u.apply_torque(row.second_a, rates.second_b, dy);
        u.apply_torque(row.twist_a, row.twist_b, dz);
        (row.first_impulse, row.second_impulse, row.twist_impulse) = (x, y, z);
        row.tangent.times(dx) + rates.second.times(dy)
    }
}
