//! Eight joints at their bodies' poses: axes, arms and errors, and what their rows make of them.

use super::super::velocities::{motions, root_times};
use super::solve::{PIVOT_SHARE, factor, substitute};
use super::{BoundRow, JointLink, LockRow, Ways};
use crate::joint::Signature;
use crate::lanes::{Lane, LaneVec};
use crate::pipeline::seat::Seat;

/// Squares of lengths below this have no direction.
const TINY: f32 = 1.0e-12;
/// Squared cosine of the turn about y below which the other two turns are one.
const GIMBAL: f32 = 1.0e-6;
/// Largest turn of a substep that arms follow, radians: faster bodies are put right at the next step.
const TURN: f32 = 2.0;

/// What a bound row is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Bound {
    Drive(usize),
    Friction(usize),
    Limit(usize),
    Cone,
}

/// The bound rows of a joint, in their order: what holds hardest comes last.
pub(crate) fn bounds_of(signature: Signature) -> impl Iterator<Item = Bound> {
    let has = |bits: u32, axis: usize| bits >> axis & 1 != 0;
    let drives = (0..6).filter(move |&i| has(signature.driven(), i)).map(Bound::Drive);
    let frictions = (0..6).filter(move |&i| has(signature.rubbing(), i)).map(Bound::Friction);
    let limits = (0..6).filter(move |&i| has(signature.limited(), i)).map(Bound::Limit);
    drives.chain(frictions).chain(limits).chain(signature.has_cone().then_some(Bound::Cone))
}

/// The held axes of a joint, in the order of its lock rows.
pub(crate) fn locks_of(signature: Signature) -> impl Iterator<Item = usize> {
    (0..6).filter(move |&axis| signature.held() >> axis & 1 != 0)
}

/// Directions of all coordinates, and the errors of held ones.
pub(crate) struct Basis {
    signature: Signature,
    shifts: [LaneVec; 3],
    turns: [LaneVec; 3],
    cone: LaneVec,
    /// Values of the shifts, metres.
    along: [Lane; 3],
    /// Sines of the turns.
    sines: [Lane; 3],
}

impl Basis {
    fn of(link: &JointLink) -> Self {
        let signature = link.signature();
        let none = [LaneVec::ZERO; 3];
        let mut basis = Self {
            signature,
            shifts: none,
            turns: none,
            cone: LaneVec::ZERO,
            along: [Lane::ZERO; 3],
            sines: [Lane::ZERO; 3],
        };
        let gap = link.gap();
        if signature.is_distance() {
            basis.shifts[0] = gap.times(link.inverse_length);
            basis.along[0] = gap.dot(basis.shifts[0]);
        } else if signature.shifts_in_a() {
            basis.shifts = link.axes_a;
            basis.along = link.axes_a.map(|axis| gap.dot(axis));
        } else {
            let (zero, one) = (Lane::ZERO, Lane::splat(1.0));
            basis.shifts =
                [LaneVec::new(one, zero, zero), LaneVec::new(zero, one, zero), LaneVec::new(zero, zero, one)];
            basis.along = [gap.x, gap.y, gap.z];
        }
        if signature.turns() {
            basis.turn(link);
        }
        basis
    }

    fn turn(&mut self, link: &JointLink) {
        let ([xa, ya, za], [xb, yb]) = (link.axes_a, link.axes_b);
        let one = Lane::splat(1.0);
        let inverse_of = |square: Lane, least: f32| {
            let stands = square.greater(Lane::splat(least));
            stands.select(one / stands.select(square, one), Lane::ZERO)
        };
        let across = xa.cross(xb);
        self.cone = across.times(inverse_of(across.dot(across), TINY).sqrt());
        if self.signature.is_twist() {
            // Swing and twist: the twist is about the mean of the two x axes.
            let both = xa + xb;
            let share = inverse_of(one + xa.dot(xb), TINY);
            self.turns[0] = both.times(share);
            self.sines[0] = yb.dot(za) - xb.dot(za) * xa.dot(yb) * share;
            return;
        }
        let middle = za.cross(xb);
        let square = inverse_of(middle.dot(middle), GIMBAL);
        let unit = middle.times(square.sqrt());
        self.turns = [middle.cross(za).times(square), unit, xb.cross(middle).times(square)];
        self.sines = [yb.dot(xb.cross(unit)), -xb.dot(za), xb.dot(ya)];
    }

    /// The row along or about an axis.
    #[inline(always)]
    fn ways(&self, link: &JointLink, axis: usize) -> Ways {
        if axis < 3 { shift(link, self.shifts[axis]) } else { turn(link, self.turns[axis - 3]) }
    }
}

/// A row along a direction, through the point on B.
fn shift(link: &JointLink, direction: LaneVec) -> Ways {
    let arm_a = link.centers + link.arm_b;
    let mut drift = Lane::ZERO;
    if link.kinematic != 0 {
        let [va, wa, vb, wb] = link.moves;
        drift = direction.dot((vb + wb.cross(link.arm_b)) - (va + wa.cross(arm_a)));
    }
    link.ways(direction, (arm_a.cross(direction), link.arm_b.cross(direction)), drift)
}

/// A row about an axis.
fn turn(link: &JointLink, axis: LaneVec) -> Ways {
    let drift = if link.kinematic != 0 { axis.dot(link.moves[3] - link.moves[1]) } else { Lane::ZERO };
    link.ways(LaneVec::ZERO, (axis, axis), drift)
}

/// The turn of A's x axis plus `ratio` times that of B's.
fn gear(link: &JointLink) -> Ways {
    let (xa, xb) = (link.axes_a[0], link.axes_b[0].times(link.ratio));
    let drift = if link.kinematic != 0 { xa.dot(link.moves[1]) + xb.dot(link.moves[3]) } else { Lane::ZERO };
    link.ways(LaneVec::ZERO, (LaneVec::ZERO - xa, xb), drift)
}

/// The shift of B along its x axis less that of the pinion's rim, where the force acts.
fn rack(link: &JointLink) -> Ways {
    let direction = link.axes_b[0];
    let rim = direction.cross(link.axes_a[0]).times(link.ratio);
    let arm_b = rim - link.centers;
    let mut drift = Lane::ZERO;
    if link.kinematic != 0 {
        let [va, wa, vb, wb] = link.moves;
        drift = direction.dot((vb + wb.cross(arm_b)) - (va + wa.cross(rim)));
    }
    link.ways(direction, (rim.cross(direction), arm_b.cross(direction)), drift)
}

impl JointLink {
    /// From A's point to B's.
    pub fn gap(&self) -> LaneVec {
        self.centers + self.arm_b - self.arm_a
    }

    /// Keeps the direction of a distance joint where its points meet.
    fn measure(&mut self) {
        if self.signature().is_distance() {
            let gap = self.gap();
            let square = gap.dot(gap);
            let stands = square.greater(Lane::splat(TINY));
            let one = Lane::splat(1.0);
            self.inverse_length = stands.select(one / stands.select(square, one).sqrt(), Lane::ZERO);
        }
    }
}

/// Writes what the rows are at the poses of the link, errors of held axes included. Returns their directions.
pub(crate) fn place(link: &mut JointLink, locks: &mut [LockRow], bounds: &mut [BoundRow]) -> Basis {
    link.measure();
    let basis = Basis::of(link);
    let signature = basis.signature;
    if signature.is_gear() || signature.is_rack() {
        locks[0].ways = if signature.is_gear() { gear(link) } else { rack(link) };
    }
    for (row, axis) in locks.iter_mut().zip(locks_of(signature)) {
        row.ways = basis.ways(link, axis);
        if !signature.is_distance() {
            row.error = if axis < 3 { basis.along[axis] } else { basis.sines[axis - 3] };
        }
    }
    for (row, bound) in bounds.iter_mut().zip(bounds_of(signature)) {
        row.ways = match bound {
            Bound::Drive(axis) | Bound::Friction(axis) | Bound::Limit(axis) => basis.ways(link, axis),
            Bound::Cone => turn(link, basis.cone),
        };
        row.shares = [Lane::ZERO; 6];
    }
    basis
}

/// Derives the masses of placed rows. `masses` are the inverse masses of both bodies along the axes.
pub(crate) fn weigh(link: &JointLink, locks: &mut [LockRow], bounds: &mut [BoundRow], masses: LaneVec) {
    if link.at_once != 0 && bounds.is_empty() {
        return;
    }
    factor(locks, masses);
    for row in bounds {
        let own = row.ways.yields(&row.ways, masses);
        pass_locks(row, locks, masses);
        row.yields = row.ways.yields(&row.ways, masses);
        let all = row.yields + row.give;
        // What the locks hold already yields by rounding only.
        let least = own * Lane::splat(PIVOT_SHARE);
        let stands = row.yields.greater(least).and(row.yields.greater(Lane::splat(f32::MIN_POSITIVE)));
        row.yields = stands.keep(row.yields);
        let one = Lane::splat(1.0);
        row.mass = stands.select(one / stands.select(all, one), Lane::ZERO);
    }
}

/// Takes from a bound what it does to rigid locks: then it finds the rate that there will be when the locks hold,
/// and leaves them as they are. With `K z = J_locks M^-1 Jt` the row becomes `J - zt J_locks`.
fn pass_locks(row: &mut BoundRow, locks: &[LockRow], masses: LaneVec) {
    let mut shares = [Lane::ZERO; 6];
    for (share, lock) in shares.iter_mut().zip(locks) {
        *share = lock.ways.yields(&row.ways, masses);
    }
    substitute(locks, &mut shares);
    for ((share, lock), sum) in shares.iter().zip(locks).zip(&mut row.shares) {
        let share = lock.give.greater(Lane::ZERO).select(Lane::ZERO, *share);
        let (ways, of) = (&mut row.ways, &lock.ways);
        ways.direction = ways.direction - of.direction.times(share);
        ways.a = ways.a - of.a.times(share);
        ways.b = ways.b - of.b.times(share);
        ways.read_a = ways.read_a - of.read_a.times(share);
        ways.read_b = ways.read_b - of.read_b.times(share);
        ways.drift = ways.drift - of.drift * share;
        *sum = *sum + share;
    }
}

/// Force and torque about the joint's point that all impulses of a substep stand for, on B.
pub(crate) fn wrench(
    link: &JointLink,
    (locks, bounds): (&[LockRow], &[BoundRow]),
    rate: f32,
) -> (LaneVec, LaneVec) {
    let signature = link.signature();
    let rate = Lane::splat(rate);
    let [push, ..] = efforts(locks, bounds);
    let mut torque = LaneVec::ZERO;
    if signature.is_gear() {
        torque = link.axes_b[0].times(link.ratio * locks[0].impulse);
    } else if signature.turns() && !signature.is_rack() {
        let basis = Basis::of(link);
        let mut add = |axis: LaneVec, impulse: Lane| torque = torque + axis.times(impulse);
        for (i, (row, axis)) in locks.iter().zip(locks_of(signature)).enumerate() {
            if axis >= 3 {
                let shares = bounds.iter().fold(Lane::ZERO, |sum, row| sum + row.shares[i] * row.impulse);
                add(basis.turns[axis - 3], row.impulse - shares);
            }
        }
        for (row, bound) in bounds.iter().zip(bounds_of(signature)) {
            match bound {
                Bound::Drive(axis) | Bound::Friction(axis) | Bound::Limit(axis) if axis >= 3 => {
                    add(basis.turns[axis - 3], row.impulse);
                }
                Bound::Cone => add(basis.cone, row.impulse),
                _ => {}
            }
        }
    }
    (push.times(rate), torque.times(rate))
}

/// What all impulses of a link do: on B, and the whitened torques.
fn efforts(locks: &[LockRow], bounds: &[BoundRow]) -> [LaneVec; 3] {
    let mut sum = [LaneVec::ZERO; 3];
    let rows = locks.iter().map(|row| (&row.ways, row.impulse));
    for (ways, x) in rows.chain(bounds.iter().map(|row| (&row.ways, row.impulse))) {
        sum[0] = sum[0] + ways.direction.times(x);
        sum[1] = sum[1] + ways.a.times(x);
        sum[2] = sum[2] + ways.b.times(x);
    }
    sum
}

/// Brings arms, axes, errors and rows to the end of the substep.
pub(super) fn follow(
    link: &mut JointLink,
    (locks, bounds): (&mut [LockRow], &mut [BoundRow]),
    seats: &[Seat],
    (substep, masses): (f32, LaneVec),
) {
    let signature = link.signature();
    let before = efforts(locks, bounds);
    let measures = !bounds.is_empty() || (signature.is_distance() && !locks.is_empty());
    let old = measures.then(|| Basis::of(link));
    let [moved, turn_a, turn_b] = advance(link, seats, substep);
    let new = place(link, locks, bounds);
    if signature.is_gear() {
        let (xa, xb) = (link.axes_a[0], link.axes_b[0]);
        locks[0].error = locks[0].error + xa.dot(turn_a) + link.ratio * xb.dot(turn_b);
    } else if signature.is_rack() {
        let direction = link.axes_b[0];
        let rim = direction.cross(link.axes_a[0]).times(link.ratio);
        let way = moved + turn_b.cross(rim - link.centers) - turn_a.cross(rim);
        locks[0].error = locks[0].error + direction.dot(way);
    }
    if let Some(old) = old {
        let turned = (turn_b - turn_a).times(Lane::splat(0.5));
        let change = |axis: usize| {
            if axis < 3 {
                new.along[axis] - old.along[axis]
            } else {
                (old.turns[axis - 3] + new.turns[axis - 3]).dot(turned)
            }
        };
        if signature.is_distance() && !locks.is_empty() {
            locks[0].error = locks[0].error + change(0);
        }
        for (row, bound) in bounds.iter_mut().zip(bounds_of(signature)) {
            let change = match bound {
                Bound::Drive(axis) | Bound::Limit(axis) => change(axis),
                Bound::Cone => (old.cone + new.cone).dot(turned),
                Bound::Friction(_) => Lane::ZERO,
            };
            (row.low, row.high) = (row.low + change, row.high + change);
        }
    }
    weigh(link, locks, bounds, masses);
    let after = efforts(locks, bounds);
    link.turn_push = after[0] - before[0];
    link.turn_a = after[1] - before[1];
    link.turn_b = after[2] - before[2];
    link.turns = 1;
}

/// Moves arms and axes with the bodies; returns how far B went against A, and how A and B turned.
fn advance(link: &mut JointLink, seats: &[Seat], substep: f32) -> [LaneVec; 3] {
    let signature = link.signature();
    let [a, b] = motions((&link.seats_a, &link.seats_b), seats);
    let mut moved = LaneVec::new(b[0] - a[0], b[1] - a[1], b[2] - a[2]);
    let mut turn_a = root_times(&link.root_a, LaneVec::new(a[4], a[5], a[6]));
    let mut turn_b = root_times(&link.root_b, LaneVec::new(b[4], b[5], b[6]));
    if link.kinematic != 0 {
        let h = Lane::splat(substep);
        let [va, wa, vb, wb] = link.moves;
        moved = moved + (vb - va).times(h);
        turn_a = turn_a + wa.times(h);
        turn_b = turn_b + wb.times(h);
    }
    // A body that is no longer finite keeps its arms, so that it does not spread.
    let (moved, turn_a, turn_b) = (moved.finite(), turn_a.finite(), turn_b.finite());
    link.centers = link.centers + moved;
    let (about_a, about_b) = (Turning::new(turn_a), Turning::new(turn_b));
    link.arm_a = about_a.of(link.arm_a);
    link.arm_b = about_b.of(link.arm_b);
    if signature.turns() || signature.shifts_in_a() {
        link.axes_a = link.axes_a.map(|axis| about_a.of(axis));
    }
    if signature.turns() {
        link.axes_b = link.axes_b.map(|axis| about_b.of(axis));
    }
    if link.tops != 0 {
        link.now_a = about_a.of_root(&link.now_a);
        link.now_b = about_b.of_root(&link.now_b);
        link.far_a = about_a.of(link.far_a);
        link.far_b = about_b.of(link.far_b);
    }
    [moved, turn_a, turn_b]
}

/// A rotation by a vector (Rodrigues).
pub(super) struct Turning {
    vector: LaneVec,
    /// sin(t) / t and (1 - cos(t)) / t^2.
    sine: Lane,
    cosine: Lane,
}

impl Turning {
    pub fn new(vector: LaneVec) -> Self {
        let square = vector.dot(vector);
        let most = Lane::splat(TURN * TURN);
        let inside = square.less(most);
        let one = Lane::splat(1.0);
        let scale = inside.select(one, (most / inside.select(one, square)).sqrt());
        let vector = vector.times(scale);
        let x = inside.select(square, most);
        let series = |c: [f32; 6]| c.iter().rev().fold(Lane::ZERO, |sum, &term| sum * x + Lane::splat(term));
        // Series of sin(t) / t and (1 - cos(t)) / t^2 in t^2: good to 1e-6 up to 2 radians.
        let sine =
            series([1.0, -1.0 / 6.0, 1.0 / 120.0, -1.0 / 5040.0, 1.0 / 362_880.0, -1.0 / 39_916_800.0]);
        let cosine =
            series([0.5, -1.0 / 24.0, 1.0 / 720.0, -1.0 / 40_320.0, 1.0 / 3_628_800.0, -1.0 / 479_001_600.0]);
        Self { vector, sine, cosine }
    }

    #[inline(always)]
    fn of(&self, v: LaneVec) -> LaneVec {
        v + self.change(v)
    }

    /// By how much a vector changes.
    #[inline(always)]
    pub fn change(&self, v: LaneVec) -> LaneVec {
        let across = self.vector.cross(v);
        across.times(self.sine) + self.vector.cross(across).times(self.cosine)
    }

    /// R W Rt of a symmetric matrix W (diagonal, then xy, xz, yz).
    pub fn of_root(&self, [d, o]: &[LaneVec; 2]) -> [LaneVec; 2] {
        let columns = [LaneVec::new(d.x, o.x, o.y), LaneVec::new(o.x, d.y, o.z), LaneVec::new(o.y, o.z, d.z)]
            .map(|c| self.of(c));
        // Rows of R W, turned again.
        let row =
            |i: fn(&LaneVec) -> Lane| self.of(LaneVec::new(i(&columns[0]), i(&columns[1]), i(&columns[2])));
        let (x, y, z) = (row(|c| c.x), row(|c| c.y), row(|c| c.z));
        [LaneVec::new(x.x, y.y, z.z), LaneVec::new(x.y, x.z, y.z)]
    }
}
