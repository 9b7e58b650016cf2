//! Projected Gauss-Seidel on contacts, eight lanes at once (SEED S9 to S12).
//!
//! Every update is used at once and clamped to its bounds: `lambda >= 0` along the normal, a disc
//! `|lambda_t| <= mu sum(lambda_n)` for the tangents of the patch, and the same times the patch's radius for the
//! twist. Friction comes before the normals, whose errors are the visible ones.
//!
//! Legend: `va, wa, ma` are velocity, whitened angular velocity and inverse mass of body A; `n` the normal, `t`
//! and `s` the tangents; `h` the substep.

use super::row::{LinkRow, PointRow};
use crate::lanes::{LANES, Lane, LaneVec, Mask, transpose};
use crate::pipeline::seat::Seat;

/// What a sweep does at each row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Pass {
    /// Applies the impulses of the step before.
    Warm,
    /// Solves velocities with position correction.
    Biased,
    /// Follows the bodies' motion of this substep, then solves velocities without correction.
    Relax,
    /// Solves velocities without correction.
    RelaxAgain,
    /// Follows the bodies' motion only.
    Follow,
    /// Gives bouncing points their speed.
    Bounce,
}

/// Numbers that all rows of a sweep share.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sweep {
    pub pass: Pass,
    /// Substep, seconds.
    pub substep: f32,
    /// Fastest push-out, m/s.
    pub push_speed: f32,
    /// Approach below which nothing bounces, m/s.
    pub restitution_threshold: f32,
}

/// Velocities of the two bodies of each lane.
struct Velocities {
    va: LaneVec,
    wa: LaneVec,
    vb: LaneVec,
    wb: LaneVec,
    /// Inverse masses along the axes: equal unless an axis is locked.
    ma: LaneVec,
    mb: LaneVec,
    /// Inverse mass and locks, as they stand in the seats.
    rest_a: [Lane; 2],
    rest_b: [Lane; 2],
}

/// Visits all rows of a group in their order.
pub(crate) fn visit(sweep: &Sweep, rows: &mut [LinkRow], points: &mut [PointRow], seats: &mut [Seat]) {
    let mut rest = points;
    for row in rows {
        let (points, after) = rest.split_at_mut(row.points as usize);
        rest = after;
        visit_row(sweep, row, points, seats);
    }
}

fn visit_row(sweep: &Sweep, row: &mut LinkRow, points: &mut [PointRow], seats: &mut [Seat]) {
    if matches!(sweep.pass, Pass::Relax | Pass::Follow) {
        follow(row, points, seats, sweep.substep);
        if sweep.pass == Pass::Follow {
            return;
        }
    }
    if sweep.pass == Pass::Bounce && row.bounces == 0 {
        return;
    }
    let shift = Shift::of(row);
    let mut u = Velocities::gather(row, seats);
    match sweep.pass {
        Pass::Warm => warm(&mut u, row, points),
        Pass::Bounce => bounce(&mut u, row, points, (sweep, &shift)),
        _ => {
            if row.turns != 0 && sweep.pass == Pass::Biased {
                u.wb = u.wb + row.turn;
                row.turns = 0;
            }
            solve_friction(&mut u, row, points, &shift);
            solve_normals(&mut u, row, points, (sweep, &shift));
        }
    }
    u.scatter(row, seats);
}

/// How B's jacobians change because the point of contact went with A: `r = r0 - slide`, so
/// `W (r x d) = W (r0 x d) + W (d x slide)` for a direction d.
struct Shift {
    normal: LaneVec,
    first: LaneVec,
    second: LaneVec,
    /// Lanes that slid far enough to matter.
    slides: Mask,
    any: bool,
}

impl Shift {
    #[inline(always)]
    fn of(row: &LinkRow) -> Self {
        let slides = row.slide.dot(row.slide).greater(row.slide_min);
        let mut shift = Self {
            normal: LaneVec::ZERO,
            first: LaneVec::ZERO,
            second: LaneVec::ZERO,
            slides,
            any: slides.any(),
        };
        if shift.any {
            let turn = |direction: LaneVec| root_times(&row.root_b, direction.cross(row.slide));
            shift.normal = turn(row.normal);
            shift.first = turn(row.tangent);
            shift.second = turn(row.normal.cross(row.tangent));
        }
        shift
    }

    /// A lane's result depends on that lane alone: `any` only saves work.
    #[inline(always)]
    fn apply(&self, jacobian: LaneVec, change: LaneVec) -> LaneVec {
        if !self.any {
            return jacobian;
        }
        let sum = jacobian + change;
        LaneVec::new(
            self.slides.select(sum.x, jacobian.x),
            self.slides.select(sum.y, jacobian.y),
            self.slides.select(sum.z, jacobian.z),
        )
    }

    /// 1 / (J M^-1 Jt) of a point with the jacobian `jb`. A longer arm yields more: with the mass of the shorter
    /// one a sweep would overshoot, and bodies that slide along each other for longer than their arms would
    /// explode.
    #[inline(always)]
    fn mass(&self, point: &PointRow, jb: LaneVec) -> Lane {
        if !self.any {
            return point.mass;
        }
        let more = jb.dot(jb) - point.normal_b.dot(point.normal_b);
        // Never 0: where the bodies hardly move but by turning, the rest is rounding.
        let sum = (Lane::splat(1.0) + point.mass * more).greatest(Lane::splat(1.0e-3));
        self.slides.select(point.mass / sum, point.mass)
    }

    /// The same for both tangents, by the trace of what their 2x2 block gains.
    #[inline(always)]
    fn friction_mass(&self, row: &LinkRow, (first_b, second_b): (LaneVec, LaneVec)) -> Lane {
        if !self.any {
            return row.friction_mass;
        }
        let now = first_b.dot(first_b) + second_b.dot(second_b);
        let before = row.first_b.dot(row.first_b) + row.second_b.dot(row.second_b);
        let more = (now - before).greatest(Lane::ZERO);
        let sum = Lane::splat(1.0) + row.friction_mass * more;
        self.slides.select(row.friction_mass / sum, row.friction_mass)
    }
}

/// A symmetric matrix (diagonal, then xy, xz, yz) times a vector.
#[inline(always)]
fn root_times(root: &[LaneVec; 2], v: LaneVec) -> LaneVec {
    let [d, o] = root;
    LaneVec::new(
        d.x * v.x + o.x * v.y + o.y * v.z,
        o.x * v.x + d.y * v.y + o.z * v.z,
        o.y * v.x + o.z * v.y + d.z * v.z,
    )
}

impl Velocities {
    #[inline(always)]
    fn gather(row: &LinkRow, seats: &[Seat]) -> Self {
        let a = transpose(core::array::from_fn(|i| seats[row.seats_a[i] as usize].velocity));
        let b = transpose(core::array::from_fn(|i| seats[row.seats_b[i] as usize].velocity));
        let (ma, mb) = if row.locked == 0 {
            (LaneVec::new(a[3], a[3], a[3]), LaneVec::new(b[3], b[3], b[3]))
        } else {
            (free_axes(a[7]).times(a[3]), free_axes(b[7]).times(b[3]))
        };
        Self {
            va: LaneVec::new(a[0], a[1], a[2]),
            wa: LaneVec::new(a[4], a[5], a[6]),
            vb: LaneVec::new(b[0], b[1], b[2]),
            wb: LaneVec::new(b[4], b[5], b[6]),
            ma,
            mb,
            rest_a: [a[3], a[7]],
            rest_b: [b[3], b[7]],
        }
    }

    #[inline(always)]
    fn scatter(&self, row: &LinkRow, seats: &mut [Seat]) {
        // Each body is in one lane only, and scratch seats are the lane's own: no write meets another.
        let (va, wa, [m, l]) = (self.va, self.wa, self.rest_a);
        let a = transpose([va.x, va.y, va.z, m, wa.x, wa.y, wa.z, l]);
        let (vb, wb, [m, l]) = (self.vb, self.wb, self.rest_b);
        let b = transpose([vb.x, vb.y, vb.z, m, wb.x, wb.y, wb.z, l]);
        for i in 0..LANES {
            seats[row.seats_a[i] as usize].velocity = a[i];
            seats[row.seats_b[i] as usize].velocity = b[i];
        }
    }

    /// Rate of the row with direction `d` and jacobians `ja`, `jb`.
    #[inline(always)]
    fn rate(&self, d: LaneVec, ja: LaneVec, jb: LaneVec) -> Lane {
        d.dot(self.vb - self.va) + (jb.dot(self.wb) - ja.dot(self.wa))
    }

    /// Applies the impulse `x` of that row: on B along `d`, on A against it.
    #[inline(always)]
    fn apply(&mut self, d: LaneVec, (ja, jb): (LaneVec, LaneVec), x: Lane) {
        let p = d.times(x);
        self.va = self.va - p.each_times(self.ma);
        self.vb = self.vb + p.each_times(self.mb);
        self.wa = self.wa - ja.times(x);
        self.wb = self.wb + jb.times(x);
    }

    /// Applies a pure torque impulse `x` about a shared axis.
    #[inline(always)]
    fn apply_torque(&mut self, ja: LaneVec, jb: LaneVec, x: Lane) {
        self.wa = self.wa - ja.times(x);
        self.wb = self.wb + jb.times(x);
    }
}

/// 1 for each axis along which a body moves, 0 for a locked one; locks are a number, x + 2 y + 4 z.
#[inline(always)]
fn free_axes(locks: Lane) -> LaneVec {
    let (zero, one) = (Lane::ZERO, Lane::splat(1.0));
    let z = locks.greater(Lane::splat(3.5));
    let locks = locks - z.select(Lane::splat(4.0), zero);
    let y = locks.greater(Lane::splat(1.5));
    let locks = locks - y.select(Lane::splat(2.0), zero);
    let x = locks.greater(Lane::splat(0.5));
    LaneVec::new(x.select(zero, one), y.select(zero, one), z.select(zero, one))
}

/// Brings separations and the slide to the end of the substep.
fn follow(row: &mut LinkRow, points: &mut [PointRow], seats: &[Seat], substep: f32) {
    let shift = Shift::of(row);
    let a = transpose(core::array::from_fn(|i| seats[row.seats_a[i] as usize].moved));
    let b = transpose(core::array::from_fn(|i| seats[row.seats_b[i] as usize].moved));
    let moved = LaneVec::new(b[0] - a[0], b[1] - a[1], b[2] - a[2]);
    let (ta, tb) = (LaneVec::new(a[4], a[5], a[6]), LaneVec::new(b[4], b[5], b[6]));
    let along = row.normal.dot(moved);
    let h = Lane::splat(substep);
    for point in points.iter_mut() {
        let jb = shift.apply(point.normal_b, shift.normal);
        let turned = jb.dot(tb) - point.normal_a.dot(ta);
        let change = along + turned + point.surface * h;
        // A lane without this point keeps its zeros: `press_together` sums what the points want.
        let real = point.mass.greater(Lane::ZERO);
        point.separation = real.select(point.separation + change, point.separation);
    }
    // Against an immovable body the point rides on the moving one: its arm stays.
    row.slide = row.slide + moved;
    turn_warm_start(row, points, &shift);
}

/// The impulses so far are the next substep's warm start, and come as the change of velocity that they made
/// with the arms of this one. Notes what B's new arms change of it: without that a hard blow between bodies
/// that slide leaks angular momentum, 1e-3 of all in a storm of collisions.
fn turn_warm_start(row: &mut LinkRow, points: &[PointRow], before: &Shift) {
    let after = Shift::of(row);
    // A lane that slides no longer takes back what it got.
    if !before.any && !after.any {
        return;
    }
    let load = points.iter().fold(Lane::ZERO, |sum, point| sum + point.impulse);
    let none = LaneVec::ZERO;
    let change = |old: LaneVec, new: LaneVec, impulse: Lane| {
        (after.apply(none, new) - before.apply(none, old)).times(impulse)
    };
    row.turn = change(before.normal, after.normal, load)
        + change(before.first, after.first, row.first_impulse)
        + change(before.second, after.second, row.second_impulse);
    row.turns = 1;
}

fn warm(u: &mut Velocities, row: &LinkRow, points: &[PointRow]) {
    let second = row.normal.cross(row.tangent);
    for point in points {
        u.apply(row.normal, (point.normal_a, point.normal_b), point.impulse);
    }
    u.apply(row.tangent, (row.first_a, row.first_b), row.first_impulse);
    u.apply(second, (row.second_a, row.second_b), row.second_impulse);
    u.apply_torque(row.twist_a, row.twist_b, row.twist_impulse);
}

/// The tangents as one disc, then the twist.
#[inline(always)]
fn solve_friction(u: &mut Velocities, row: &mut LinkRow, points: &[PointRow], shift: &Shift) {
    let load = points.iter().fold(Lane::ZERO, |sum, point| sum + point.impulse);
    let limit = row.friction * load;
    let second = row.normal.cross(row.tangent);
    let first_b = shift.apply(row.first_b, shift.first);
    let second_b = shift.apply(row.second_b, shift.second);

    let friction_mass = shift.friction_mass(row, (first_b, second_b));
    let x = row.first_impulse - friction_mass * (u.rate(row.tangent, row.first_a, first_b) + row.surface.x);
    let y = row.second_impulse - friction_mass * (u.rate(second, row.second_a, second_b) + row.surface.y);
    let size = (x * x + y * y).sqrt();
    let outside = size.greater(limit);
    let scale = outside.select(limit / outside.select(size, Lane::splat(1.0)), Lane::splat(1.0));
    let x = (x * scale).finite_or(row.first_impulse).flushed();
    let y = (y * scale).finite_or(row.second_impulse).flushed();
    u.apply(row.tangent, (row.first_a, first_b), x - row.first_impulse);
    u.apply(second, (row.second_a, second_b), y - row.second_impulse);
    (row.first_impulse, row.second_impulse) = (x, y);

    let limit = limit * row.radius;
    let rate = row.twist_b.dot(u.wb) - row.twist_a.dot(u.wa) + row.surface.z;
    let z = row.twist_impulse - row.twist_mass * rate;
    let z = z.least(limit).greatest(-limit).finite_or(row.twist_impulse).flushed();
    u.apply_torque(row.twist_a, row.twist_b, z - row.twist_impulse);
    row.twist_impulse = z;
}

/// The relative motion along the normal, kept as one number while the points of a row are solved.
struct Line<'a> {
    u: &'a mut Velocities,
    /// n . (vb - va), m/s.
    speed: Lane,
    /// What an impulse of 1 changes of it, 1/kg.
    yields: Lane,
    /// Impulse of all points, not yet given to the linear velocities.
    sum: Lane,
}

impl<'a> Line<'a> {
    #[inline(always)]
    fn new(u: &'a mut Velocities, row: &LinkRow) -> Self {
        let n = row.normal;
        let speed = n.dot(u.vb - u.va);
        let yields = n.dot(n.each_times(u.ma + u.mb));
        Self { u, speed, yields, sum: Lane::ZERO }
    }

    #[inline(always)]
    fn rate(&self, ja: LaneVec, jb: LaneVec) -> Lane {
        self.speed + (jb.dot(self.u.wb) - ja.dot(self.u.wa))
    }

    /// Gives `count` times the impulse `x` to points with the sum `ja`, `jb` of their jacobians.
    #[inline(always)]
    fn press(&mut self, (ja, jb): (LaneVec, LaneVec), (count, x): (Lane, Lane)) {
        let all = count * x;
        self.sum = self.sum + all;
        self.speed = self.speed + self.yields * all;
        self.u.apply_torque(ja, jb, x);
    }

    #[inline(always)]
    fn finish(self, row: &LinkRow) {
        let p = row.normal.times(self.sum);
        self.u.va = self.u.va - p.each_times(self.u.ma);
        self.u.vb = self.u.vb + p.each_times(self.u.mb);
    }
}

/// What a sweep wants of a point that presses: `rate + bias + soft . impulse = 0`.
struct Demand {
    bias: Lane,
    soft: Lane,
}

/// Apart, a point may close the gap in this substep, but not more. Overlapping, a spring pushes.
#[inline(always)]
fn biased(sweep: &Sweep, row: &LinkRow, point: &PointRow) -> (Mask, Lane) {
    let s = point.separation;
    let apart = s.greater(Lane::ZERO);
    let push = (s * row.bias_rate).greatest(Lane::splat(-sweep.push_speed));
    (apart, apart.select(s * Lane::splat(1.0 / sweep.substep), push))
}

/// The same without a push.
#[inline(always)]
fn relaxed(sweep: &Sweep, point: &PointRow) -> Lane {
    point.separation.greatest(Lane::ZERO) * Lane::splat(1.0 / sweep.substep)
}

/// One exact step along "the same impulse more at every point"; returns that impulse. The points have yet to take
/// it.
///
/// Points taken one after the other share a change of the load unequally: the first takes most of it, the body
/// tilts, and a tower sways while it settles (24 mm for ten boxes; 1 micrometre with this step). The step is
/// the minimum of the row's energy in that direction, so it never slows the sweeps down; it stops where the first
/// point would pull. Where points are apart, that is at once.
#[inline(always)]
fn press_together(
    line: &mut Line<'_>,
    row: &LinkRow,
    (points, shift): (&[PointRow], &Shift),
    demand: impl Fn(&PointRow) -> Demand,
) -> Lane {
    let (zero, one) = (Lane::ZERO, Lane::splat(1.0));
    let (mut ja, mut jb) = (LaneVec::ZERO, LaneVec::ZERO);
    let (mut wanted, mut soft) = (zero, zero);
    let mut least = Lane::splat(f32::MAX);
    // In a lane without this point all of it is 0.
    for point in points {
        let demand = demand(point);
        ja = ja + point.normal_a;
        jb = jb + point.normal_b;
        soft = soft + demand.soft;
        wanted = wanted + (demand.bias + point.surface + demand.soft * point.impulse);
        least = point.mass.greater(zero).select(point.impulse.least(least), least);
    }
    let count = row.count;
    let jb = shift.apply(jb, shift.normal.times(count));
    let rate = count * line.speed + (jb.dot(line.u.wb) - ja.dot(line.u.wa));
    let inertia = count * count * line.yields + ja.dot(ja) + jb.dot(jb) + soft;
    let several = count.greater(Lane::splat(1.5)).and(inertia.greater(zero));
    let x = -(rate + wanted) / several.select(inertia, one);
    let x = several.select(x.greatest(-least).finite_or(zero), zero);
    line.press((ja, jb), (count, x));
    x
}

/// All points together, then one after the other. `change` says what a point's rate takes off its impulse.
#[inline(always)]
fn solve_points(
    mut line: Line<'_>,
    row: &LinkRow,
    (points, shift): (&mut [PointRow], &Shift),
    (demand, change): (impl Fn(&PointRow) -> Demand, impl Fn(&PointRow, Lane, Lane) -> Lane),
) {
    let (zero, one) = (Lane::ZERO, Lane::splat(1.0));
    if points.len() > 1 {
        let x = press_together(&mut line, row, (points, shift), demand);
        for point in points.iter_mut() {
            point.impulse = point.mass.greater(zero).select(point.impulse + x, point.impulse);
        }
    }
    for point in points {
        let jb = shift.apply(point.normal_b, shift.normal);
        let rate = line.rate(point.normal_a, jb) + point.surface;
        let before = point.impulse;
        let off = change(point, rate, shift.mass(point, jb));
        point.impulse = (before - off).greatest(zero).finite_or(before).flushed();
        line.press((point.normal_a, jb), (one, point.impulse - before));
    }
    line.finish(row);
}

#[inline(always)]
fn solve_normals(
    u: &mut Velocities,
    row: &LinkRow,
    points: &mut [PointRow],
    (sweep, shift): (&Sweep, &Shift),
) {
    let line = Line::new(u, row);
    if row.bounces != 0 {
        record_bounces(&line, row, points, (sweep, shift));
    }
    if sweep.pass != Pass::Biased {
        let demand = |point: &PointRow| Demand { bias: relaxed(sweep, point), soft: Lane::ZERO };
        let change = |point: &PointRow, rate: Lane, mass: Lane| mass * (rate + relaxed(sweep, point));
        return solve_points(line, row, (points, shift), (demand, change));
    }
    let demand = |point: &PointRow| {
        let (apart, bias) = biased(sweep, row, point);
        Demand { bias, soft: apart.select(Lane::ZERO, point.soft) }
    };
    let change = |point: &PointRow, rate: Lane, mass: Lane| {
        let (apart, bias) = biased(sweep, row, point);
        let firm = mass * (rate + bias);
        apart.select(firm, firm * row.mass_scale + row.impulse_scale * point.impulse)
    };
    solve_points(line, row, (points, shift), (demand, change));
}

/// Fixes the energy with which a point will leave, when it presses for the first time in this step. All points of a
/// row see the velocity before the row's impulses, so that a box that falls flat does not start to spin.
///
/// Symplectic Euler conserves `H = v^2/2 - a s + a h v/2` in free flight along the normal (acceleration a, height
/// s); the point leaves with `e^2 H`: apexes then keep their height whatever the substep.
fn record_bounces(line: &Line<'_>, row: &LinkRow, points: &mut [PointRow], (sweep, shift): (&Sweep, &Shift)) {
    let (zero, half) = (Lane::ZERO, Lane::splat(0.5));
    // The biased sweep sees the velocity with this substep's push (push = a h), but heights before its motion.
    let early = if sweep.pass == Pass::Biased { row.push } else { zero };
    let e2 = row.restitution * row.restitution;
    for point in points {
        let rate = line.rate(point.normal_a, shift.apply(point.normal_b, shift.normal)) + point.surface;
        let bias =
            if sweep.pass == Pass::Biased { biased(sweep, row, point).1 } else { relaxed(sweep, point) };
        let fast = rate.less(Lane::splat(-sweep.restitution_threshold));
        let presses = (point.mass * (rate + bias)).less(point.impulse).and(point.mass.greater(zero));
        let unset = point.bounce.less(Lane::splat(f32::MIN_POSITIVE));
        let before = rate - early;
        let energy = half * before * (before + row.push) - height_energy(sweep, row, point);
        let record = fast.and(presses).and(unset).and(row.restitution.greater(zero));
        point.bounce = record.select((e2 * energy).finite_or(zero), point.bounce);
    }
}

/// `a s` of a point that is apart, m2/s2.
#[inline(always)]
fn height_energy(sweep: &Sweep, row: &LinkRow, point: &PointRow) -> Lane {
    row.push * Lane::splat(1.0 / sweep.substep) * point.separation.greatest(Lane::ZERO)
}

/// Gives the bouncing points their speed: the root of `v^2/2 + a h v/2 = E + a s`.
fn bounce(u: &mut Velocities, row: &LinkRow, points: &mut [PointRow], (sweep, shift): (&Sweep, &Shift)) {
    let (zero, half, two) = (Lane::ZERO, Lane::splat(0.5), Lane::splat(2.0));
    let half_push = half * row.push;
    for point in points.iter_mut() {
        let energy = (point.bounce + height_energy(sweep, row, point)).greatest(zero);
        let speed = (half_push * half_push + two * energy).sqrt() - half_push;
        point.bounce = point.bounce.greater(zero).select(speed.finite_or(zero), zero);
    }
    // A point that does not bounce may go on as it does.
    let leaves = |point: &PointRow| point.bounce.greater(zero);
    let demand = |point: &PointRow| Demand { bias: -point.bounce, soft: zero };
    let change =
        |point: &PointRow, rate: Lane, mass: Lane| leaves(point).select(mass * (rate - point.bounce), zero);
    solve_points(Line::new(u, row), row, (points, shift), (demand, change));
}
