//! Contacts that carry rigidly, and whose overlap never becomes velocity or load.
//!
//! Overlap is taken back by *nudges*: velocities that move bodies in this substep and are then forgotten (split
//! impulses, as in Guendelman, Bridson and Fedkiw, Nonconvex rigid bodies with stacking, 2003, and later engines).
//! What is warm-started is then the load alone, and nothing sinks under it. What the points of one contact press
//! together is rigid; how they share it is soft, by the same springs as in the soft model: rigid shares make tall
//! stacks rock.

use super::super::row::{LinkRow, PointRow};
use super::super::velocities::Velocities;
use super::shift::Shift;
use super::{Demand, Line, Sweep, Traits, press_together, solve_points};
use crate::config::{SPLIT_PUSH, SPLIT_SLOP};
use crate::lanes::{Lane, LaneVec};
use crate::pipeline::seat::Seat;

/// The biased visit of several points.
#[inline(always)]
pub(super) fn solve<const N: usize>(
    mut line: Line<'_>,
    row: &LinkRow,
    ((points, traits), shift): ((&mut [PointRow; N], Traits), &Shift),
) {
    let demand = (row.press_mass, Demand::relaxed);
    let together = press_together(&mut line, row, ((points, traits), shift), demand);
    let share = Share::of(points, together);
    solve_points(line, row, ((points, traits), shift), (together, |point| share.demand(point)));
}

/// What an overlapping point has if they all have the same.
pub(super) struct Share {
    bias: Lane,
    load: Lane,
}

impl Share {
    #[inline(always)]
    pub(super) fn of(points: &[PointRow], together: Lane) -> Self {
        let (zero, one) = (Lane::ZERO, Lane::splat(1.0));
        let (mut bias, mut load, mut count) = (zero, zero, zero);
        for point in points {
            // Points apart, and those that a lane does not have, do not give.
            let gives = point.soft.greater(zero);
            bias = bias + gives.keep(point.bias);
            load = load + gives.keep(point.impulse + together);
            count = count + gives.keep(one);
        }
        let share = one / count.greatest(one);
        Self { bias: bias * share, load: load * share }
    }

    #[inline(always)]
    pub(super) fn demand(&self, point: &PointRow) -> Demand {
        let bias = point.bias - point.soft.greater(Lane::ZERO).keep(self.bias);
        Demand { bias, soft: point.soft, mass: point.soft_mass, load: self.load }
    }
}

/// Moves the bodies of overlapping points apart.
#[inline(always)]
pub(super) fn nudge<const N: usize>(
    u: &Velocities,
    row: &LinkRow,
    points: &[PointRow; N],
    (sweep, shift): (&Sweep, &Shift),
    seats: &mut [Seat],
) {
    let least = points.iter().fold(Lane::ZERO, |least, point| point.separation.least(least));
    // No lane that has less would be pushed.
    if least.less(Lane::splat(-SPLIT_SLOP)).any() {
        push(u, row, points, (sweep, shift), seats);
    }
}

#[inline(never)]
fn push<const N: usize>(
    u: &Velocities,
    row: &LinkRow,
    points: &[PointRow; N],
    (sweep, shift): (&Sweep, &Shift),
    seats: &mut [Seat],
) {
    let ends = (&row.seats_a, &row.seats_b);
    let mut nudges = u.gather_nudges(ends, seats);
    let mut line = Line::new(&mut nudges, row, (LaneVec::ZERO, false));
    let rate = Lane::splat(SPLIT_PUSH * sweep.bias.rate);
    let most = Lane::splat(sweep.bias.push_speed);
    let slop = Lane::splat(SPLIT_SLOP);
    let wanted = |point: &PointRow| ((-point.separation - slop) * rate).least(most);
    let has = |point: &PointRow| point.mass.greater(Lane::ZERO);
    let deep = points.iter().fold(Lane::ZERO, |deep, point| deep.greatest(has(point).keep(wanted(point))));
    // Points that overlap by less than the slop are not pressed together by others.
    let pushes = deep.greater(Lane::ZERO);
    let mut together = Lane::ZERO;
    if N > 1 {
        let (mut ja, mut jb, mut sum) = (LaneVec::ZERO, LaneVec::ZERO, Lane::ZERO);
        for point in points {
            ja = ja + point.normal_a;
            jb = jb + point.normal_b;
            sum = sum + has(point).keep(wanted(point));
        }
        let count = row.count;
        let jb = shift.apply(jb, shift.normal.times(count));
        let now = count * line.speed + (jb.dot(line.u.wb) - ja.dot(line.u.wa));
        together = pushes.keep(row.press_mass * (sum - now)).pushing();
        line.press((ja, jb), (count, together));
    }
    for point in points {
        let jb = shift.apply(point.normal_b, shift.normal);
        let now = line.rate(point.normal_a, jb);
        let own = has(point).keep(together);
        let step = shift.mass((point, point.mass), jb) * (wanted(point) - now);
        let after = pushes.keep(own + step).pushing();
        line.press((point.normal_a, jb), (Lane::splat(1.0), after - own));
    }
    line.finish(row);
    nudges.scatter_nudges(ends, seats);
}
