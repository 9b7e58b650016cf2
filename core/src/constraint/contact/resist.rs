//! Resistance to rolling and spinning: torques that are bounded by a length times the normal impulse.
//!
//! ```text
//! rolling    |lambda_t t + lambda_s s| <= rolling  sum(lambda_n)      on the relative turning about t and s
//! spinning   |lambda|                  <= spinning sum(lambda_n)      on that about n
//! ```
//! A row of contacts is visited for it only where a lane has some; the visit is one of its own, after the row's, so
//! that rows without it are as they were.

use super::{Pass, Sweep, load_of};
use crate::constraint::row::{LinkRow, PointRow, ResistRow};
use crate::constraint::velocities::Velocities;
use crate::lanes::{Lane, LaneVec};
use crate::pipeline::seat::Seat;

#[inline(never)]
pub(super) fn visit(
    sweep: &Sweep,
    row: &LinkRow,
    (points, resist): (&[PointRow], &mut ResistRow),
    seats: &mut [Seat],
) {
    if matches!(sweep.pass, Pass::Follow | Pass::Bounce) {
        return;
    }
    let ends = (&row.seats_a, &row.seats_b);
    let mut u = Velocities::gather(ends, seats, false);
    let before = (u.wa, u.wb);
    if sweep.pass == Pass::Warm {
        apply(&mut u, resist, resist.impulse);
    } else {
        let after = solve(&u, resist, load_of(points));
        let change = after - resist.impulse;
        apply(&mut u, resist, change);
        resist.impulse = after;
    }
    // A lane without resistance keeps its bits, whatever its neighbours do.
    let acts = (resist.rolling + resist.spinning).greater(Lane::ZERO);
    (u.wa, u.wb) = (acts.select_vec(u.wa, before.0), acts.select_vec(u.wb, before.1));
    u.scatter(ends, seats);
}

/// The impulses about the tangents, as one disc, and about the normal.
fn solve(u: &Velocities, resist: &ResistRow, load: Lane) -> LaneVec {
    let rate = |a: LaneVec, b: LaneVec| b.dot(u.wb) - a.dot(u.wa);
    let [first_a, second_a, spin_a] = resist.turns_a;
    let [first_b, second_b, spin_b] = resist.turns_b;
    let (was, surface) = (resist.impulse, resist.surface);
    let x = was.x - resist.roll_mass * (rate(first_a, first_b) + surface.x);
    let y = was.y - resist.roll_mass * (rate(second_a, second_b) + surface.y);
    let limit = resist.rolling * load;
    let square = x * x + y * y;
    let outside = square.greater(limit * limit);
    let one = Lane::splat(1.0);
    let scale = outside.select(limit / outside.select(square.sqrt(), one), one);
    let z = was.z - resist.spin_mass * (rate(spin_a, spin_b) + surface.z);
    let limit = resist.spinning * load;
    let z = z.least(limit).greatest(-limit);
    LaneVec::new((x * scale).finite().flushed(), (y * scale).finite().flushed(), z.finite().flushed())
}

fn apply(u: &mut Velocities, resist: &ResistRow, impulse: LaneVec) {
    for (i, x) in [impulse.x, impulse.y, impulse.z].into_iter().enumerate() {
        u.apply_torque(resist.turns_a[i], resist.turns_b[i], x);
    }
}
