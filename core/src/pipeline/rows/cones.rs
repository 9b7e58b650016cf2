//! Cones of the points of a row, and the patch's stored impulse dealt to them.

use super::{Patch, Placed, Sides, inverse};
use crate::constraint::contact::{into_disc, step_of, yields_of};
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

/// How often what a cone did not bear is dealt again. Close to what all cones together bear the last bits come
/// slowly: with 97 % of it a push at a slab's edge needs about so many.
const ROUNDS: usize = 8;

/// A force along the tangents and a twist about the middle of the patch.
#[derive(Clone, Copy)]
struct Wrench {
    x: Lane,
    y: Lane,
    z: Lane,
}

/// The points' loads, and how a wrench is dealt to points by them: the force in proportion, and what twist about
/// the middle of the loads is then left as a turning about it. Of all ways to deal it this one has the least sum of
/// `lambda_t^2 / lambda_n`.
struct Shares<'a> {
    points: &'a [PointRow],
    places: &'a [[Lane; 2]; 4],
    /// 1 / the load of all.
    share: Lane,
    /// Middle of the loads.
    middle: [Lane; 2],
    /// 1 / the moment of the loads about it; 0 where the load stands on one point.
    turning: Lane,
}

impl<'a> Shares<'a> {
    fn new(points: &'a [PointRow], places: &'a [[Lane; 2]; 4]) -> Self {
        let zero = Lane::ZERO;
        let (mut load, mut first, mut second) = (zero, zero, zero);
        for (point, &[p, q]) in points.iter().zip(places) {
            load = load + point.impulse;
            first = first + point.impulse * p;
            second = second + point.impulse * q;
        }
        let share = inverse(load);
        let middle = [first * share, second * share];
        let (mut spread, mut reach) = (zero, zero);
        for (point, &[p, q]) in points.iter().zip(places) {
            let (dp, dq) = (p - middle[0], q - middle[1]);
            spread = spread + point.impulse * (dp * dp + dq * dq);
            reach = reach.greatest(p * p + q * q);
        }
        // On a lever that short a twist is rounding.
        let several = spread.greater(load * reach * Lane::splat(1.0e-6));
        Self { points, places, share, middle, turning: several.keep(inverse(spread)) }
    }

    /// What point `i` gets of a wrench.
    fn of(&self, i: usize, wrench: Wrench) -> [Lane; 2] {
        let ([p, q], [p0, q0]) = (self.places[i], self.middle);
        let turn = self.turning * (wrench.z - (p0 * wrench.y - q0 * wrench.x));
        let load = self.points[i].impulse;
        [load * (wrench.x * self.share - turn * (q - q0)), load * (wrench.y * self.share + turn * (p - p0))]
    }

    /// The wrench of some impulses.
    fn sum(&self, impulses: &[[Lane; 2]; 4]) -> Wrench {
        let zero = Lane::ZERO;
        let mut sum = Wrench { x: zero, y: zero, z: zero };
        for (&[x, y], &[p, q]) in impulses.iter().zip(self.places) {
            sum = Wrench { x: sum.x + x, y: sum.y + y, z: sum.z + (p * y - q * x) };
        }
        sum
    }
}

/// Deals the impulse of a patch to its points, each within its cone: what is beyond a cone is cut off and dealt
/// again to all, some times (alternating projections onto the cones and onto what has the right sum). What the
/// cones do not bear, and a twist whose load stands on one point, is lost.
fn deal(row: &mut LinkRow, cones: &mut ConeRow, points: &[PointRow]) {
    let one = Lane::splat(1.0);
    let shares = Shares::new(points, &cones.places);
    let all = Wrench { x: row.first_impulse, y: row.second_impulse, z: row.twist_impulse };
    let mut dealt = [[Lane::ZERO; 2]; 4];
    for (i, dealt) in dealt.iter_mut().enumerate().take(points.len()) {
        *dealt = shares.of(i, all).map(Lane::finite);
    }
    for round in 0..=ROUNDS {
        let mut cut = Lane::ZERO;
        for (point, dealt) in points.iter().zip(&mut dealt) {
            let (borne, outside) = into_disc(*dealt, row.friction * point.impulse);
            *dealt = borne.map(Lane::finite);
            cut = outside.select(one, cut);
        }
        let cut = cut.greater(Lane::ZERO);
        if round == ROUNDS || !cut.any() {
            break;
        }
        // A lane that is done stays, whatever its neighbours do.
        let sum = shares.sum(&dealt);
        let left = Wrench { x: all.x - sum.x, y: all.y - sum.y, z: all.z - sum.z };
        for (i, [x, y]) in dealt.iter_mut().enumerate().take(points.len()) {
            let [dx, dy] = shares.of(i, left);
            (*x, *y) = (*x + cut.keep(dx).finite(), *y + cut.keep(dy).finite());
        }
    }
    let sum = shares.sum(&dealt);
    (row.first_impulse, row.second_impulse, row.twist_impulse) = (sum.x, sum.y, sum.z);
    cones.impulses = dealt;
}
