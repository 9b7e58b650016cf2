//! Projected Gauss-Seidel on joints, lane by lane, eight alike side by side.
//!
//! A joint has *locks*, rows that hold without bounds, and *bounds*: limits, drives and friction. A visit solves
//! the bounds one by one and then all locks together, directly (`K = J M^-1 Jt` is factored once per substep), so
//! that a joint is never loose against itself.
//!
//! Joints follow their bodies: after each substep arms and axes are turned with them, and what that changes of the
//! warm start is applied with the next one. Rigid locks are aimed at where the bodies will be at the end of the
//! substep, the way of a point on a circle included (`curvature`); then the velocities are made to fit the new
//! axes. That is the pattern of RATTLE (Andersen 1983), and keeps the energy of pendula and linkages.
//!
//! Legend: as in `constraint/contact.rs`. `g` is the way from A's point to B's.

mod articulation;
mod ball;
mod elimination;
mod factor;
mod follow;
mod residual;
mod solve;
#[cfg(test)]
mod tests;

pub(crate) use articulation::Articulation;
pub(crate) use ball::BallRow;
pub(crate) use elimination::{
    BlockSpec, Elimination, JOINTS_MAX, Member, NONE, NodeSpec, Pattern, blocks_max, nodes_max,
};
pub(crate) use factor::{BlockRow, Matrix, NodeRow};
pub(crate) use follow::{Bound, bounds_of, locks_of, place, weigh, wrench};
pub(crate) use residual::{measure, measure_balls};

use super::velocities::{Velocities, root_times};
use crate::joint::Signature;
use crate::lanes::{LANES, Lane, LaneVec};
use crate::pipeline::seat::Seat;
use bytemuck::{Pod, Zeroable};
use solve::Push;

use super::contact::{Pass, Sweep};

/// Share of the error of a rigid lock that a substep removes.
pub(crate) const LOCK_PUSH: f32 = 0.3;
/// Share of what a rigid limit is beyond that a substep removes.
pub(crate) const LIMIT_PUSH: f32 = 0.2;
/// A coordinate that is never reached.
pub(crate) const FAR: f32 = 1.0e30;

/// Eight joints and what their rows share.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
pub(crate) struct JointLink {
    /// Seats of bodies A and of bodies B, from the group's first.
    pub seats_a: [u32; LANES],
    pub seats_b: [u32; LANES],
    /// [`Signature`] of all lanes.
    pub signature: u32,
    /// 1 when a body of a lane does not move along some axis.
    pub locked: u32,
    /// 1 when an immovable body of a lane moves.
    pub kinematic: u32,
    /// 1 when the next biased sweep has to apply the changes of the warm start.
    pub turns: u32,
    /// 1 when a body of a lane is a free top: then `inertia` counts.
    pub tops: u32,
    /// Bit for each lane that leaps: see `pipeline/leapfrog.rs`.
    pub leaps: u32,
    /// Not 0 for a joint of an articulation: its locks are in the matrix of that.
    pub at_once: u32,
    /// Zero.
    pub reserved: u32,
    /// What the new axes change of the warm start: impulse on B, N s; whitened angular velocities of A and B. After
    /// the solve the first two are force and torque.
    pub turn_push: LaneVec,
    pub turn_a: LaneVec,
    pub turn_b: LaneVec,
    /// W of both bodies, fixed for the step: diagonal, then xy, xz, yz.
    pub root_a: [LaneVec; 2],
    pub root_b: [LaneVec; 2],
    /// W at the orientations now, and the inverse of the fixed one. See [`Ways`].
    pub now_a: [LaneVec; 2],
    pub now_b: [LaneVec; 2],
    pub back_a: [LaneVec; 2],
    pub back_b: [LaneVec; 2],
    /// 1 for a free top, and its axis whose moment stands out.
    pub top_a: Lane,
    pub top_b: Lane,
    pub far_a: LaneVec,
    pub far_b: LaneVec,
    /// Square roots of the inverse masses of A and B along the axes.
    pub scale_a: LaneVec,
    pub scale_b: LaneVec,
    /// From the centers to the points of the joint, and from the center of A to that of B.
    pub arm_a: LaneVec,
    pub arm_b: LaneVec,
    pub centers: LaneVec,
    /// Axes x, y, z of A's frame and x, y of B's.
    pub axes_a: [LaneVec; 3],
    pub axes_b: [LaneVec; 2],
    /// Velocities of immovable bodies that move: linear and angular of A, then of B.
    pub moves: [LaneVec; 4],
    /// Teeth of B over those of A, or metres for each radian.
    pub ratio: Lane,
    /// 1 over the distance of the points, 1/m, of a distance joint; else 0.
    pub inverse_length: Lane,
}

/// A row that holds, of each of eight joints. All 0 in an empty lane.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
pub(crate) struct LockRow {
    pub ways: Ways,
    /// Impulse of the substep, N s or N m s.
    pub impulse: Lane,
    /// Error, metres or radians.
    pub error: Lane,
    /// Rate for each unit of error, 1/s.
    pub rate: Lane,
    /// Rate that it allows for each unit of impulse.
    pub give: Lane,
    /// What the biased sweep wanted; a lock that gives wants it in the relax sweep too.
    pub aim: Lane,
    /// Row of the factor L (below the diagonal) and the inverse of D in `K + give = L D Lt`.
    pub factor: [Lane; 5],
    pub inverse: Lane,
    /// The mean of the ways at both ends of the substep, for later relax sweeps of it; else of no meaning.
    pub mean: Push,
}

/// A row with bounds, of each of eight joints: a limit, a drive or friction.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
pub(crate) struct BoundRow {
    pub ways: Ways,
    /// Impulse of the substep, N s or N m s.
    pub impulse: Lane,
    /// Greatest impulse.
    pub most: Lane,
    /// What an impulse of 1 changes of the rate.
    pub yields: Lane,
    /// Rate that the row allows for each unit of impulse.
    pub give: Lane,
    /// 1 / (yields + give).
    pub mass: Lane,
    /// Coordinate less its lower and its upper end, metres or radians.
    pub low: Lane,
    pub high: Lane,
    /// Rate for each unit that is left to an end, and for each beyond it, 1/s.
    pub near: Lane,
    pub beyond: Lane,
    /// Rate that is wanted.
    pub target: Lane,
    /// Fastest way back from beyond an end, m/s or rad/s.
    pub push: Lane,
    /// Bounds of the rate that the biased sweep found; a drive keeps them in the relax sweep.
    pub least: Lane,
    pub greatest: Lane,
    /// 1 where the row wants the same in all sweeps: a drive, friction, a limit that gives. 0 for a hard limit.
    pub keeps: Lane,
    /// Impulses on the rigid locks that go with an impulse of 1, and are in `ways` already: so the row leaves
    /// them as they are.
    pub shares: [Lane; 6],
    /// 1 for a limit or a cone: the way of the points in the substep matters.
    pub limits: u32,
    /// Zero.
    pub reserved: [u32; 7],
}

/// In which way a row's impulse acts: on B along `direction`, with the whitened torques `a` and `b`.
///
/// The seats hold momentum, whitened by the W of the step's start, and that is what an impulse changes. Which
/// velocity it means turns with a body of unequal moments: `w = Wn Wn W^-1 w~` with the W of now. A joint on a
/// slender rod that leaves this out feeds the spin about the rod. So a row reads by other vectors than it writes,
/// and `read . write` is its share of the true `J M^-1 Jt`.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
pub(crate) struct Ways {
    /// Unit vector, or 0 for a torque.
    pub direction: LaneVec,
    pub a: LaneVec,
    pub b: LaneVec,
    /// By which the rate is read; the same as `a` and `b` where no body is a top.
    pub read_a: LaneVec,
    pub read_b: LaneVec,
    /// Rate that immovable bodies' motion gives.
    pub drift: Lane,
}

impl JointLink {
    /// The row whose impulse acts on B along `direction` with the torque `b`, and on A against it with `a`.
    #[inline(always)]
    fn ways(&self, direction: LaneVec, (a, b): (LaneVec, LaneVec), drift: Lane) -> Ways {
        let write = (root_times(&self.root_a, a), root_times(&self.root_b, b));
        let mut read = write;
        if self.tops != 0 {
            let now =
                |(root, back, top): (&[LaneVec; 2], &[LaneVec; 2], Lane), v: LaneVec, write: LaneVec| {
                    let read = root_times(back, root_times(root, root_times(root, v)));
                    top.greater(Lane::ZERO).select_vec(read, write)
                };
            read.0 = now((&self.now_a, &self.back_a, self.top_a), a, write.0);
            read.1 = now((&self.now_b, &self.back_b, self.top_b), b, write.1);
        }
        Ways { direction, a: write.0, b: write.1, read_a: read.0, read_b: read.1, drift }
    }

    /// Angular velocities of both bodies.
    fn spins(&self, u: &Velocities) -> (LaneVec, LaneVec) {
        let (mut a, mut b) = (root_times(&self.root_a, u.wa), root_times(&self.root_b, u.wb));
        if self.tops != 0 {
            let now = |(now, back, top): (&[LaneVec; 2], &[LaneVec; 2], Lane), w: LaneVec, spin: LaneVec| {
                let turned = root_times(now, root_times(now, root_times(back, w)));
                top.greater(Lane::ZERO).select_vec(turned, spin)
            };
            a = now((&self.now_a, &self.back_a, self.top_a), u.wa, a);
            b = now((&self.now_b, &self.back_b, self.top_b), u.wb, b);
        }
        (a + self.moves[1], b + self.moves[3])
    }

    pub fn signature(&self) -> Signature {
        Signature(self.signature)
    }

    /// Inverse masses of both bodies along the axes, added.
    fn masses(&self) -> LaneVec {
        self.scale_a.each_times(self.scale_a) + self.scale_b.each_times(self.scale_b)
    }
}

impl Ways {
    #[inline(always)]
    fn rate(&self, u: &Velocities) -> Lane {
        u.rate(self.direction, self.read_a, self.read_b) + self.drift
    }

    #[inline(always)]
    fn apply(&self, u: &mut Velocities, x: Lane) {
        u.apply(self.direction, (self.a, self.b), x);
    }

    /// What an impulse of 1 along `self` changes of the rate of `other`.
    #[inline(always)]
    pub fn yields(&self, other: &Self, masses: LaneVec) -> Lane {
        let torques = self.read_a.dot(other.a) + self.read_b.dot(other.b);
        self.direction.dot(other.direction.each_times(masses)) + torques
    }
}

/// Visits the joints of a group in their order.
pub(crate) fn visit(
    sweep: &Sweep,
    links: &mut [JointLink],
    (locks, bounds): (&mut [LockRow], &mut [BoundRow]),
    seats: &mut [Seat],
) {
    if sweep.pass == Pass::Bounce {
        return;
    }
    let (mut locks, mut bounds) = (locks, bounds);
    for link in links {
        let signature = link.signature();
        let (own_locks, rest) = core::mem::take(&mut locks).split_at_mut(signature.lock_rows());
        locks = rest;
        let (own_bounds, rest) = core::mem::take(&mut bounds).split_at_mut(signature.bound_rows());
        bounds = rest;
        let only_leaps = matches!(sweep.pass, Pass::Leap | Pass::LeapOnce);
        if sweep.ends && !signature.counts_on() || only_leaps && link.leaps == 0 {
            continue;
        }
        match own_locks.len() {
            0 => visit_link::<0>(sweep, link, (own_locks, own_bounds), seats),
            1 => visit_link::<1>(sweep, link, (own_locks, own_bounds), seats),
            2 => visit_link::<2>(sweep, link, (own_locks, own_bounds), seats),
            3 => visit_link::<3>(sweep, link, (own_locks, own_bounds), seats),
            4 => visit_link::<4>(sweep, link, (own_locks, own_bounds), seats),
            5 => visit_link::<5>(sweep, link, (own_locks, own_bounds), seats),
            _ => visit_link::<6>(sweep, link, (own_locks, own_bounds), seats),
        }
    }
}

fn visit_link<const N: usize>(
    sweep: &Sweep,
    link: &mut JointLink,
    (locks, bounds): (&mut [LockRow], &mut [BoundRow]),
    seats: &mut [Seat],
) {
    let Some(locks) = locks.first_chunk_mut::<N>() else { return };
    let mut u = Velocities::gather((&link.seats_a, &link.seats_b), seats, link.locked != 0);
    match sweep.pass {
        Pass::Warm => solve::warm(&mut u, locks, bounds),
        Pass::Biased => {
            solve::biased(&mut u, link, (locks, bounds));
            let mut nudges = u.gather_nudges((&link.seats_a, &link.seats_b), seats);
            solve::nudge(&mut nudges, &u, (link, locks), sweep);
            nudges.scatter_nudges((&link.seats_a, &link.seats_b), seats);
        }
        Pass::Follow => follow::follow(link, (locks, bounds), seats, (sweep.substep, u.ma + u.mb)),
        Pass::Relax => {
            let mut before: [Push; N] = core::array::from_fn(|i| Push::of(&locks[i].ways));
            let axes = (link.far_a, link.far_b);
            follow::follow(link, (locks, bounds), seats, (sweep.substep, u.ma + u.mb));
            if link.tops != 0 {
                solve::take_along(&mut before, link, axes);
            }
            let means: [Push; N] = core::array::from_fn(|i| before[i].mean(&locks[i].ways));
            solve::relaxed(&mut u, link, (locks, bounds), &means);
            if sweep.relaxes_again {
                locks.iter_mut().zip(means).for_each(|(row, mean)| row.mean = mean);
            }
        }
        Pass::Leap | Pass::LeapOnce => {
            solve::leap(&mut u, (link, locks), sweep.pass == Pass::LeapOnce);
        }
        _ => {
            let means: [Push; N] = core::array::from_fn(|i| locks[i].mean);
            solve::relaxed(&mut u, link, (locks, bounds), &means);
        }
    }
    u.scatter((&link.seats_a, &link.seats_b), seats);
}
