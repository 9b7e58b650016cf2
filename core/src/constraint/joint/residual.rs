//! The residual of rows of joints: see `constraint/residual.rs`. Rows that hold have no bounds: what is left of the
//! rate is theirs. Those that were solved at once are measured one by one like the others.

use super::super::residual::{Greatest, note, share};
use super::super::velocities::Velocities;
use super::{BallRow, Bound, BoundRow, JointLink, LockRow, bounds_of, locks_of};
use crate::lanes::{Lane, LaneVec};
use crate::pipeline::seat::Seat;

/// Measures joints in their order, as the last visits left them.
pub(crate) fn measure(
    links: &[JointLink],
    (locks, bounds): (&[LockRow], &[BoundRow]),
    seats: &[Seat],
    greatest: &mut Greatest,
) {
    let (mut locks, mut bounds) = (locks, bounds);
    for link in links {
        let signature = link.signature();
        let (own_locks, rest) = locks.split_at(signature.lock_rows());
        locks = rest;
        let (own_bounds, rest) = bounds.split_at(signature.bound_rows());
        bounds = rest;
        let u = Velocities::gather((&link.seats_a, &link.seats_b), seats, link.locked != 0);
        let couples = signature.is_gear() || signature.is_rack();
        for (i, row) in own_locks.iter().enumerate() {
            let turns = if couples { signature.is_gear() } else { locks_of(signature).nth(i) >= Some(3) };
            let lever = if turns { lever(&u, row.turning()) } else { Lane::splat(1.0) };
            note(&mut greatest.joint, row.residual(&u) * lever);
        }
        for (row, bound) in own_bounds.iter().zip(bounds_of(signature)) {
            let turns = match bound {
                Bound::Drive(axis) | Bound::Friction(axis) | Bound::Limit(axis) => axis >= 3,
                Bound::Cone => true,
            };
            let lever = if turns { lever(&u, row.yields) } else { Lane::splat(1.0) };
            note(&mut greatest.joint, row.residual(&u) * lever);
        }
    }
}

/// Measures plain balls.
pub(crate) fn measure_balls(rows: &[BallRow], seats: &[Seat], greatest: &mut Greatest) {
    for row in rows {
        let LaneVec { x, y, z } = row.lacks(seats);
        for rate in [x, y, z] {
            note(&mut greatest.joint, rate);
        }
    }
}

/// Radius of gyration of what a row of turning turns, by its `J M^-1 Jt`, metres.
fn lever(u: &Velocities, yields: Lane) -> Lane {
    share(u.inverse_mass(), yields).sqrt()
}

impl LockRow {
    /// `J M^-1 Jt` of its torques.
    fn turning(&self) -> Lane {
        self.ways.read_a.dot(self.ways.a) + self.ways.read_b.dot(self.ways.b)
    }

    /// The rate that is left, with what the row gives and wants in all sweeps.
    fn residual(&self, u: &Velocities) -> Lane {
        let gives = self.give.greater(Lane::ZERO);
        self.ways.rate(u) + gives.keep(self.aim) + self.give * self.impulse
    }
}

impl BoundRow {
    /// The impulse that the row lacks, over its mass: its step is exact, so this is the natural map.
    fn residual(&self, u: &Velocities) -> Lane {
        self.mass.greater(Lane::ZERO).keep((self.wanted(u) - self.impulse) * (self.yields + self.give))
    }
}
