//! Cones of the points of a row, and the patch's stored impulse dealt to them.

use super::{Patch, Placed, Sides};
use crate::constraint::contact::{step_of, yields_of};
use crate::constraint::row::{ConeRow, LinkRow, PointRow};
use crate::lanes::Lane;
use bytemuck::Zeroable;

impl Sides {
    /// Writes the cones of a row of several points whose patch is written, and brings the patch to their sum.
    #[inline(never)]
    pub(super) fn write_cones(
        &self,
        found: &Placed,
        (row, cones): (&mut LinkRow, &mut ConeRow),
        (points, patch): (&[PointRow], &Patch),
    ) {
        let one = Lane::splat(1.0);
        let live = found.count.greater(Lane::ZERO);
        let middle = patch.sum.times(one / live.select(found.count, one));
        let (t, s) = (row.tangent, row.normal.cross(row.tangent));
        *cones = ConeRow::zeroed();
        cones.yields = yields_of(row, found.free, (row.first_b, row.second_b));
        for (i, &place) in patch.places[..points.len()].iter().enumerate() {
            let has = found.count.greater(Lane::splat(i as f32));
            let off = has.keep_vec(place - middle);
            cones.places[i] = [t.dot(off), s.dot(off)];
            cones.masses[i] = has.keep(step_of(&cones.yields, cones.places[i]));
        }
        deal(row, cones, points);
    }
}

/// Deals the impulse of a patch to its points: the force by their loads, and what twist about the middle of the
/// loads is then left as a turning about it, by loads too. Among all ways to deal them this one has the least sum of
/// squares of `lambda_t / lambda_n`: what the cones can bear, it bears as evenly as it can. A twist is lost whose
/// load stands on one point.
fn deal(row: &mut LinkRow, cones: &mut ConeRow, points: &[PointRow]) {
    let (zero, one) = (Lane::ZERO, Lane::splat(1.0));
    let (x, y) = (row.first_impulse, row.second_impulse);
    let loads = points.iter().zip(&cones.places);
    let [load, first, second] = loads.clone().fold([zero; 3], |sum, (point, &[p, q])| {
        let load = point.impulse;
        [sum[0] + load, sum[1] + load * p, sum[2] + load * q]
    });
    let presses = load.greater(Lane::splat(f32::MIN_POSITIVE));
    let share = presses.keep(one / presses.select(load, one));
    let (p0, q0) = (first * share, second * share);
    let spread = loads.fold(zero, |sum, (point, &[p, q])| {
        let (p, q) = (p - p0, q - q0);
        sum + point.impulse * (p * p + q * q)
    });
    let left = row.twist_impulse - presses.keep(p0 * y - q0 * x);
    let turns = spread.greater(Lane::splat(f32::MIN_POSITIVE));
    let turn = turns.keep(left / turns.select(spread, one));
    let mut sum = [zero; 3];
    for (i, point) in points.iter().enumerate() {
        let [p, q] = cones.places[i];
        let load = point.impulse;
        let own_x = load * (x * share - turn * (q - q0));
        let own_y = load * (y * share + turn * (p - p0));
        let (own_x, own_y) = (own_x.finite(), own_y.finite());
        cones.impulses[i] = [own_x, own_y];
        sum = [sum[0] + own_x, sum[1] + own_y, sum[2] + (p * own_y - q * own_x)];
    }
    [row.first_impulse, row.second_impulse, row.twist_impulse] = sum;
}
