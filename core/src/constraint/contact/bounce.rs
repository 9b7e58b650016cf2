//! Restitution: the speed with which a point leaves.

use super::{Demand, Line, Pass, Shift, Sweep, Traits, Velocities, solve_all};
use crate::constraint::row::{LinkRow, PointRow};
use crate::lanes::{Lane, LaneVec};

/// Fixes the energy with which a point will leave, when it presses for the first time in this step. All points of a
/// row see the velocity before the row's impulses, so that a box that falls flat does not start to spin.
///
/// Symplectic Euler conserves `H = v^2/2 - a s + a h v/2` in free flight along the normal (acceleration a, height
/// s); the point leaves with `e^2 H`: apexes then keep their height whatever the substep.
pub(super) fn record_bounces<const N: usize>(
    line: &Line<'_>,
    row: &LinkRow,
    points: &mut [PointRow; N],
    (sweep, shift): (&Sweep, &Shift),
) {
    let (zero, half) = (Lane::ZERO, Lane::splat(0.5));
    // The biased sweep sees the velocity with this substep's push (push = a h), but heights before its motion.
    let biased = sweep.pass == Pass::Biased;
    let early = if biased { row.push } else { zero };
    let e2 = row.restitution * row.restitution;
    for point in points.iter_mut() {
        let rate = line.rate(point.normal_a, shift.apply(point.normal_b, shift.normal)) + point.surface;
        let bias = if biased { point.bias } else { Demand::relaxed(point).bias };
        let fast = rate.less(Lane::splat(-sweep.restitution_threshold));
        let presses = (point.mass * (rate + bias)).less(point.impulse).and(point.mass.greater(zero));
        let unset = point.bounce.less(Lane::splat(f32::MIN_POSITIVE));
        let before = rate - early;
        let energy = half * before * (before + row.push) - height_energy(sweep, row, point);
        let record = fast.and(presses).and(unset).and(row.restitution.greater(zero));
        point.bounce = record.select((e2 * energy).finite(), point.bounce);
    }
}

/// `a s` of a point that is apart, m2/s2.
#[inline(always)]
fn height_energy(sweep: &Sweep, row: &LinkRow, point: &PointRow) -> Lane {
    row.push * Lane::splat(sweep.bias.rate) * point.separation.greatest(Lane::ZERO)
}

/// Gives the bouncing points their speed: the root of `v^2/2 + a h v/2 = E + a s`.
pub(super) fn bounce<const N: usize>(
    u: &mut Velocities,
    row: &LinkRow,
    (points, traits): (&mut [PointRow; N], Traits),
    (sweep, shift): (&Sweep, &Shift),
) {
    let (zero, half, two) = (Lane::ZERO, Lane::splat(0.5), Lane::splat(2.0));
    let half_push = half * row.push;
    for point in points.iter_mut() {
        let energy = (point.bounce + height_energy(sweep, row, point)).greatest(zero);
        let speed = (half_push * half_push + two * energy).sqrt() - half_push;
        point.bounce = point.bounce.greater(zero).keep(speed.finite());
    }
    let line = Line::new(u, row, (LaneVec::ZERO, traits.locked));
    solve_all(line, row, ((points, traits), shift), (row.press_mass, Demand::bouncing));
}

/// A point that departs keeps no warm start: its impulse was the blow of the last step. Given again, it would be
/// taken back by the row itself, but its neighbours would have seen the velocity as an approach of their own: a
/// ball that hits a row of touching balls then makes energy, four times what it brings.
pub(super) fn forget_blows<const N: usize>(
    line: &Line<'_>,
    row: &LinkRow,
    points: &mut [PointRow; N],
    (sweep, shift): (&Sweep, &Shift),
) {
    let least = Lane::splat(0.5 * sweep.restitution_threshold) * row.restitution;
    for point in points.iter_mut() {
        let rate = line.rate(point.normal_a, shift.apply(point.normal_b, shift.normal)) + point.surface;
        let departs = rate.greater(least).and(row.restitution.greater(Lane::ZERO));
        point.impulse = departs.select(Lane::ZERO, point.impulse);
    }
}
