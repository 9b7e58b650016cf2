//! A visit of eight joints: bounds one by one, then the locks at once.

use super::super::contact::Sweep;
use super::super::velocities::{Velocities, root_times};
use super::follow::Turning;
use super::{BoundRow, JointLink, LockRow, Ways};
use crate::lanes::{Lane, LaneVec, Mask};
use crate::pipeline::leapfrog::lanes_of;
use bytemuck::{Pod, Zeroable};

/// A pivot below this share of its row's own yield is taken for rounding: the row says what others say already.
pub(super) const PIVOT_SHARE: f32 = 1.0e-5;

/// Fastest way back of a rigid lock, m/s or rad/s: joints that contradict each other must not fling what they hold.
pub(super) const NUDGE_MAX: f32 = 10.0;

/// Applies the impulses of the step before.
pub(super) fn warm(u: &mut Velocities, locks: &[LockRow], bounds: &[BoundRow]) {
    for row in bounds {
        row.ways.apply(u, row.impulse);
    }
    for row in locks {
        row.ways.apply(u, row.impulse);
    }
}

/// A sweep with position correction.
pub(super) fn biased<const N: usize>(
    u: &mut Velocities,
    link: &mut JointLink,
    (locks, bounds): (&mut [LockRow; N], &mut [BoundRow]),
) {
    link.begin(locks);
    link.take_turns(u);
    BoundRow::visit(bounds, u, true);
    let wanted = core::array::from_fn(|i| locks[i].wanted(true));
    let x = solve_locks(u, locks, wanted);
    for (row, x) in locks.iter_mut().zip(x) {
        let x = row.add(x);
        row.ways.apply(u, x);
    }
}

/// Moves the bodies of rigid locks towards where they belong. The nudges are gone after the substep, so that no
/// error of position ever becomes velocity, or load (split impulses).
pub(super) fn nudge<const N: usize>(
    nudges: &mut Velocities,
    u: &Velocities,
    (link, locks): (&JointLink, &[LockRow; N]),
    sweep: &Sweep,
) {
    let curvature = curvature(u, link, sweep.substep);
    let wanted = core::array::from_fn(|i| locks[i].wanted_nudge(curvature));
    let x = solve_locks(nudges, locks, wanted);
    for (row, x) in locks.iter().zip(x) {
        row.apply_nudge(nudges, x);
    }
}

/// A sweep without: what gives still wants its own.
///
/// The velocities are to fit the axes at the end of the substep, and the impulses that make them fit act along
/// the mean of the axes at its two ends: then they do no work (a velocity that is turned from one tangent to the
/// next keeps its length when it is pushed along the chord's normal).
pub(super) fn relaxed<const N: usize>(
    u: &mut Velocities,
    link: &mut JointLink,
    (locks, bounds): (&mut [LockRow; N], &mut [BoundRow]),
    means: &[Push; N],
) {
    BoundRow::visit(bounds, u, false);
    let wanted = core::array::from_fn(|i| locks[i].wanted(false));
    let x = solve_locks(u, locks, wanted);
    for ((row, mean), x) in locks.iter_mut().zip(means).zip(x) {
        let x = row.add(x);
        mean.apply(u, x);
        link.note_turn(row, mean, x);
    }
    if link.leaps == 0 {
        return;
    }
    // The matrix is that of the axes of now, the impulses act along the mean ones: once more where that is what is
    // left of the error.
    let (leaps, before) = (lanes_of(link.leaps), u.all());
    let x = solve_locks(u, locks, [Lane::ZERO; N]);
    for ((row, mean), x) in locks.iter_mut().zip(means).zip(x) {
        let x = row.add(leaps.keep(x));
        mean.apply(u, x);
    }
    u.keep(leaps, before);
}

/// The velocities of joints that leap fit again after the rest of the push.
pub(super) fn leap<const N: usize>(
    u: &mut Velocities,
    (link, locks): (&JointLink, &mut [LockRow; N]),
    counts: bool,
) {
    let (leaps, before) = (lanes_of(link.leaps), u.all());
    let x = solve_locks(u, locks, [Lane::ZERO; N]);
    for (row, x) in locks.iter_mut().zip(x) {
        row.leap(u, leaps.keep(x), counts);
    }
    u.keep(leaps, before);
}

/// What an impulse of 1 changes.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
pub(crate) struct Push {
    direction: LaneVec,
    a: LaneVec,
    b: LaneVec,
}

impl Push {
    pub const NONE: Self = Self { direction: LaneVec::ZERO, a: LaneVec::ZERO, b: LaneVec::ZERO };

    pub fn of(ways: &Ways) -> Self {
        Self { direction: ways.direction, a: ways.a, b: ways.b }
    }

    /// The mean of this and another.
    pub fn mean(&self, other: &Ways) -> Self {
        let half = Lane::splat(0.5);
        Self {
            direction: (self.direction + other.direction).times(half),
            a: (self.a + other.a).times(half),
            b: (self.b + other.b).times(half),
        }
    }

    #[inline(always)]
    pub fn apply(&self, u: &mut Velocities, x: Lane) {
        u.apply(self.direction, (self.a, self.b), x);
    }
}

/// Gives torques on tops the share about their axes that they had, when the axes were `axes`. The mean of what
/// was and of what is then lies across an axis if both did: otherwise every relax sweep would spin a slender body
/// about it.
pub(super) fn take_along(pushes: &mut [Push], link: &JointLink, axes: (LaneVec, LaneVec)) {
    let (changed_a, changed_b) = (axes.0 - link.far_a, axes.1 - link.far_b);
    let (far_a, far_b) = (root_times(&link.root_a, link.far_a), root_times(&link.root_b, link.far_b));
    for push in pushes {
        // The axes of what is no top are 0.
        push.a = push.a + far_a.times(changed_a.dot(root_times(&link.back_a, push.a)));
        push.b = push.b + far_b.times(changed_b.dot(root_times(&link.back_b, push.b)));
    }
}

/// How much faster the points part in the mean of the substep than now because the bodies turn: by half a substep's
/// acceleration.
#[inline(always)]
pub(super) fn curvature(u: &Velocities, link: &JointLink, substep: f32) -> LaneVec {
    let (spin_a, spin_b) = link.spins(u);
    let about_a = spin_a.cross(link.arm_a);
    let about_b = spin_b.cross(link.arm_b);
    let half = Lane::splat(0.5 * substep);
    let mut turned_a = spin_a.cross(about_a).times(half);
    let mut turned_b = spin_b.cross(about_b).times(half);
    if link.tops != 0 {
        let zero = Lane::ZERO;
        let (roots, arm) = ((&link.now_a, &link.back_a), link.arm_a);
        let way = top_way(u.wa, (spin_a, arm), roots, substep);
        turned_a = link.top_a.greater(zero).select_vec(way - about_a, turned_a);
        let (roots, arm) = ((&link.now_b, &link.back_b), link.arm_b);
        let way = top_way(u.wb, (spin_b, arm), roots, substep);
        turned_b = link.top_b.greater(zero).select_vec(way - about_b, turned_b);
    }
    let turned = turned_b - turned_a;
    if !link.signature().is_distance() {
        return turned;
    }
    // The line between the points turns too: v^2 / r of what crosses it.
    let gap = link.centers + link.arm_b - link.arm_a;
    let along = gap.times(link.inverse_length);
    let speed = (u.vb + link.moves[2] + about_b) - (u.va + link.moves[0] + about_a);
    let outward = speed.dot(along);
    let across = speed.dot(speed) - outward * outward;
    turned + along.times(half * across * link.inverse_length)
}

/// Mean velocity in a substep of the point at `arm` of a free top, whose momentum stays while its angular velocity
/// `spin` does not: taken with that of half time (midpoint rule). With the velocity of now, the nudges would turn a
/// fast top off its momentum.
#[inline(always)]
fn top_way(
    whitened: LaneVec,
    (spin, arm): (LaneVec, LaneVec),
    (now, back): (&[LaneVec; 2], &[LaneVec; 2]),
    substep: f32,
) -> LaneVec {
    let root = Turning::new(spin.times(Lane::splat(0.5 * substep))).of_root(now);
    let momentum = root_times(back, whitened);
    let middle = root_times(&root, root_times(&root, momentum));
    Turning::new(middle.times(Lane::splat(substep))).change(arm).times(Lane::splat(1.0 / substep))
}

impl JointLink {
    /// Forgets the impulses of the substep before where the bodies leap alone.
    #[inline(always)]
    fn begin(&mut self, locks: &mut [LockRow]) {
        if self.leaps != 0 && self.turns != 0 {
            let (leaps, zero) = (lanes_of(self.leaps), Lane::ZERO);
            let none = |v: LaneVec| leaps.select_vec(LaneVec::ZERO, v);
            locks.iter_mut().for_each(|row| row.impulse = leaps.select(zero, row.impulse));
            self.turn_push = none(self.turn_push);
            (self.turn_a, self.turn_b) = (none(self.turn_a), none(self.turn_b));
        }
    }

    /// Applies what the new axes change of the warm start, once.
    #[inline(always)]
    pub(super) fn take_turns(&mut self, u: &mut Velocities) {
        if self.turns != 0 {
            u.push(self.turn_push, (self.turn_a, self.turn_b));
            self.turns = 0;
        }
    }

    /// Notes an impulse that was given along `mean`: the next substep's warm start is along the axes of now.
    #[inline(always)]
    pub(super) fn note_turn(&mut self, row: &LockRow, mean: &Push, x: Lane) {
        self.turn_push = self.turn_push + (row.ways.direction - mean.direction).times(x);
        self.turn_a = self.turn_a + (row.ways.a - mean.a).times(x);
        self.turn_b = self.turn_b + (row.ways.b - mean.b).times(x);
    }
}

impl LockRow {
    /// The rate that is wanted, opposite, with what the row gives already.
    #[inline(always)]
    pub(super) fn wanted(&mut self, biased: bool) -> Lane {
        let gives = self.give.greater(Lane::ZERO);
        if biased {
            // A spring is a force; the errors of rigid locks are nudged away.
            self.aim = gives.keep(self.error * self.rate);
        }
        // A spring keeps its aim in relax sweeps; a rigid row leaves the velocity without correction.
        gives.keep(self.aim) + self.give * self.impulse
    }

    /// The same of a nudge. `curvature` is how much faster the points part because the bodies turn.
    #[inline(always)]
    pub(super) fn wanted_nudge(&self, curvature: LaneVec) -> Lane {
        let most = Lane::splat(NUDGE_MAX);
        // Immovable bodies have no nudges: their motion is in the velocities.
        let back = (self.error * self.rate).least(most).greatest(-most);
        back + self.ways.direction.dot(curvature) - self.ways.drift
    }

    /// Applies an impulse that counts as one of the substep, or does not.
    #[inline(always)]
    pub(super) fn leap(&mut self, u: &mut Velocities, x: Lane, counts: bool) {
        let x = if counts { self.add(x) } else { x.finite() };
        self.ways.apply(u, x);
    }

    /// Adds to the impulse; returns by how much it changes.
    #[inline(always)]
    pub(super) fn add(&mut self, x: Lane) -> Lane {
        let after = (self.impulse + x).finite().flushed();
        let change = after - self.impulse;
        self.impulse = after;
        change
    }

    /// Nudges the bodies of a rigid lock.
    #[inline(always)]
    pub(super) fn apply_nudge(&self, nudges: &mut Velocities, x: Lane) {
        let x = self.give.greater(Lane::ZERO).select(Lane::ZERO, x.finite());
        self.ways.apply(nudges, x);
    }
}

impl BoundRow {
    /// Visits rows one by one.
    #[inline(always)]
    pub(super) fn visit(bounds: &mut [BoundRow], u: &mut Velocities, biased: bool) {
        for row in bounds {
            row.aim(biased);
            row.solve(u);
        }
    }

    /// Brings the wanted rates to the coordinate.
    #[inline(always)]
    fn aim(&mut self, biased: bool) {
        let beyond = if biased { self.beyond } else { Lane::ZERO };
        let zero = Lane::ZERO;
        let low = self.low.greater(zero).select(self.near, beyond) * self.low;
        let high = self.high.less(zero).select(self.near, beyond) * self.high;
        let keeps = if biased { Mask::NONE } else { self.keeps.greater(zero) };
        self.least = keeps.select(self.least, self.target - low.greatest(-self.push));
        self.greatest = keeps.select(self.greatest, self.target - high.least(self.push));
    }

    /// One step of the row.
    #[inline(always)]
    fn solve(&mut self, u: &mut Velocities) {
        let x = self.wanted(u);
        self.ways.apply(u, x - self.impulse);
        self.impulse = x;
    }

    /// The impulse with which the rate is in its bounds.
    #[inline(always)]
    pub(super) fn wanted(&self, u: &Velocities) -> Lane {
        // The rate that there would be without the row's impulse, and the impulse that brings it into its bounds.
        let free = self.ways.rate(u) - self.yields * self.impulse;
        let raise = (self.least - free) * self.mass;
        let lower = (self.greatest - free) * self.mass;
        let x = raise.greatest(Lane::ZERO) + lower.least(Lane::ZERO);
        x.least(self.most).greatest(-self.most).finite().flushed()
    }
}

/// The impulses that solve all locks at once: `(K + give) x = -(rate + wanted)`.
#[inline(always)]
fn solve_locks<const N: usize>(u: &Velocities, locks: &[LockRow; N], wanted: [Lane; N]) -> [Lane; N] {
    let mut x: [Lane; N] = core::array::from_fn(|i| -(locks[i].ways.rate(u) + wanted[i]));
    substitute(locks, &mut x);
    x
}

/// Solves `L D Lt x = y`; `x` holds y.
#[inline(always)]
pub(super) fn substitute(locks: &[LockRow], x: &mut [Lane]) {
    for (i, row) in locks.iter().enumerate() {
        for (j, factor) in row.factor.iter().enumerate().take(i) {
            x[i] = x[i] - *factor * x[j];
        }
    }
    for (i, row) in locks.iter().enumerate().rev() {
        x[i] = x[i] * row.inverse;
        for (j, other) in locks.iter().enumerate().skip(i + 1) {
            x[i] = x[i] - other.factor[i] * x[j];
        }
    }
}

/// Factors `K + give` into `L D Lt`. A row that the rows before it imply gets no pivot, and no impulse. `masses`
/// are the inverse masses of both bodies along the axes.
pub(super) fn factor(locks: &mut [LockRow], masses: LaneVec) {
    for i in 0..locks.len() {
        let own = locks[i].ways.yields(&locks[i].ways, masses) + locks[i].give;
        let mut pivot = own;
        for j in 0..i {
            let mut entry = locks[i].ways.yields(&locks[j].ways, masses);
            for k in 0..j {
                // `factor` of row i holds L D until the row is done.
                entry = entry - locks[i].factor[k] * locks[j].factor[k];
            }
            locks[i].factor[j] = entry;
        }
        for j in 0..i {
            let entry = locks[i].factor[j];
            let share = entry * locks[j].inverse;
            pivot = pivot - entry * share;
            locks[i].factor[j] = share;
        }
        locks[i].inverse = inverse(pivot, own);
    }
}

/// The inverse of a pivot, or 0 where nothing but rounding is left of its row's own yield.
#[inline(always)]
pub(super) fn inverse(pivot: Lane, own: Lane) -> Lane {
    let stands =
        pivot.greater(own * Lane::splat(PIVOT_SHARE)).and(own.greater(Lane::splat(f32::MIN_POSITIVE)));
    let one = Lane::splat(1.0);
    stands.select(one / stands.select(pivot, one), Lane::ZERO)
}
