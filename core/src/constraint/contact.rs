//! Projected Gauss-Seidel on contacts, lane by lane (SEED S9 to S12).
//!
//! Every update is used at once and clamped to its bounds: `lambda >= 0` along the normal, a disc
//! `|lambda_t| <= mu sum(lambda_n)` for the tangents of the patch, and the same times the patch's radius for the
//! twist. Friction comes before the normals, whose errors are the visible ones.
//!
//! Legend: `va, wa, ma` are velocity, whitened angular velocity and inverse mass of body A; `n` the normal, `t`
//! and `s` the tangents; `h` the substep.

use super::row::{Bias, LinkPart, LinkRow, PointPart, PointRow};
use crate::lanes::{Lane, LaneVec, Mask, PARTS, WIDTH, transpose, transpose_back};
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
    pub bias: Bias,
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
        if sweep.pass == Pass::Bounce && row.bounces == 0 {
            continue;
        }
        for index in 0..PARTS {
            visit_part(sweep, row, (points, index), seats);
        }
    }
}

/// What a row has beside resting contacts of free bodies.
#[derive(Clone, Copy)]
struct Traits {
    bounces: bool,
    locked: bool,
    uneven: bool,
    surfaces: bool,
}

/// The points of a row, as one part of its lanes sees them.
struct Points<'a> {
    rows: &'a mut [PointRow],
    part: usize,
}

impl Points<'_> {
    #[inline(always)]
    fn iter(&self) -> impl Iterator<Item = &PointPart> {
        self.rows.iter().map(|row| &row.parts[self.part])
    }

    #[inline(always)]
    fn iter_mut(&mut self) -> impl Iterator<Item = &mut PointPart> {
        self.rows.iter_mut().map(|row| &mut row.parts[self.part])
    }

    #[inline(always)]
    fn load(&self) -> Lane {
        self.iter().fold(Lane::ZERO, |sum, point| sum + point.impulse)
    }
}

fn visit_part(
    sweep: &Sweep,
    row: &mut LinkRow,
    (points, index): (&mut [PointRow], usize),
    seats: &mut [Seat],
) {
    let traits = Traits {
        bounces: row.bounces != 0,
        locked: row.locked != 0,
        uneven: row.uneven != 0,
        surfaces: row.surfaces != 0,
    };
    let lanes = index * WIDTH..(index + 1) * WIDTH;
    let (seats_a, seats_b) = (&row.seats_a[lanes.clone()], &row.seats_b[lanes]);
    let link = &mut row.parts[index];
    let mut points = Points { rows: points, part: index };
    if matches!(sweep.pass, Pass::Relax | Pass::Follow) {
        if follow(link, (&mut points, traits), (seats_a, seats_b, seats), sweep) {
            row.turns |= 1 << index;
        }
        if sweep.pass == Pass::Follow {
            return;
        }
    }
    let shift = Shift::of(link);
    let mut u = Velocities::gather((seats_a, seats_b), seats, traits.locked);
    match sweep.pass {
        Pass::Warm => warm(&mut u, link, &points),
        Pass::Bounce => bounce(&mut u, link, (&mut points, traits), (sweep, &shift)),
        _ => {
            if row.turns >> index & 1 != 0 && sweep.pass == Pass::Biased {
                u.wb = u.wb + link.turn;
                row.turns &= !(1 << index);
            }
            solve_friction(&mut u, link, points.load(), (&shift, traits.surfaces));
            solve_normals(&mut u, link, (&mut points, traits), (sweep, &shift));
        }
    }
    u.scatter((seats_a, seats_b), seats);
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
    fn of(link: &LinkPart) -> Self {
        let slides = link.slide.dot(link.slide).greater(link.slide_min);
        let mut shift = Self {
            normal: LaneVec::ZERO,
            first: LaneVec::ZERO,
            second: LaneVec::ZERO,
            slides,
            any: slides.any(),
        };
        if shift.any {
            let turn = |direction: LaneVec| root_times(&link.root_b, direction.cross(link.slide));
            shift.normal = turn(link.normal);
            shift.first = turn(link.tangent);
            shift.second = turn(link.normal.cross(link.tangent));
        }
        shift
    }

    /// A lane's result depends on that lane alone: `any` only saves work.
    #[inline(always)]
    fn apply(&self, jacobian: LaneVec, change: LaneVec) -> LaneVec {
        if self.any { jacobian + self.slides.keep_vec(change) } else { jacobian }
    }

    /// What the mass of a point is divided by for the jacobian `jb`. A longer arm yields more: with the mass of the
    /// shorter one a sweep would overshoot, and bodies that slide along each other for longer than their arms would
    /// explode.
    #[inline(always)]
    fn mass(&self, (point, mass): (&PointPart, Lane), jb: LaneVec) -> Lane {
        if !self.any {
            return mass;
        }
        let more = jb.dot(jb) - point.normal_b.dot(point.normal_b);
        // Never 0: where the bodies hardly move but by turning, the rest is rounding.
        let sum = (Lane::splat(1.0) + mass * more).greatest(Lane::splat(1.0e-3));
        self.slides.select(mass / sum, mass)
    }

    /// The same for both tangents, by the trace of what their 2x2 block gains.
    #[inline(always)]
    fn friction_mass(&self, link: &LinkPart, (first_b, second_b): (LaneVec, LaneVec)) -> Lane {
        if !self.any {
            return link.friction_mass;
        }
        let now = first_b.dot(first_b) + second_b.dot(second_b);
        let before = link.first_b.dot(link.first_b) + link.second_b.dot(link.second_b);
        let more = (now - before).greatest(Lane::ZERO);
        let sum = Lane::splat(1.0) + link.friction_mass * more;
        self.slides.select(link.friction_mass / sum, link.friction_mass)
    }
}

/// A symmetric matrix (diagonal, then xy, xz, yz) times a vector.
#[inline(always)]
pub(crate) fn root_times(root: &[LaneVec; 2], v: LaneVec) -> LaneVec {
    let [d, o] = root;
    LaneVec::new(
        d.x * v.x + o.x * v.y + o.y * v.z,
        o.x * v.x + d.y * v.y + o.z * v.z,
        o.y * v.x + o.z * v.y + d.z * v.z,
    )
}

impl Velocities {
    #[inline(always)]
    fn gather((seats_a, seats_b): (&[u32], &[u32]), seats: &[Seat], locked: bool) -> Self {
        let a = transpose(core::array::from_fn(|i| seats[seats_a[i] as usize].velocity));
        let b = transpose(core::array::from_fn(|i| seats[seats_b[i] as usize].velocity));
        let (ma, mb) = if locked {
            (free_axes(a[7]).times(a[3]), free_axes(b[7]).times(b[3]))
        } else {
            (LaneVec::new(a[3], a[3], a[3]), LaneVec::new(b[3], b[3], b[3]))
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
    fn scatter(&self, (seats_a, seats_b): (&[u32], &[u32]), seats: &mut [Seat]) {
        // Each body is in one lane only, and scratch seats are the lane's own: no write meets another.
        let (va, wa, [m, l]) = (self.va, self.wa, self.rest_a);
        let a = transpose_back([va.x, va.y, va.z, m, wa.x, wa.y, wa.z, l]);
        let (vb, wb, [m, l]) = (self.vb, self.wb, self.rest_b);
        let b = transpose_back([vb.x, vb.y, vb.z, m, wb.x, wb.y, wb.z, l]);
        for i in 0..WIDTH {
            seats[seats_a[i] as usize].velocity = a[i];
            seats[seats_b[i] as usize].velocity = b[i];
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
        self.apply_torque(ja, jb, x);
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
pub(crate) fn free_axes(locks: Lane) -> LaneVec {
    let (zero, one) = (Lane::ZERO, Lane::splat(1.0));
    let z = locks.greater(Lane::splat(3.5));
    let locks = locks - z.select(Lane::splat(4.0), zero);
    let y = locks.greater(Lane::splat(1.5));
    let locks = locks - y.select(Lane::splat(2.0), zero);
    let x = locks.greater(Lane::splat(0.5));
    LaneVec::new(x.select(zero, one), y.select(zero, one), z.select(zero, one))
}

/// Brings separations and the slide to the end of the substep. True when the warm start has to be turned.
fn follow(
    link: &mut LinkPart,
    (points, traits): (&mut Points<'_>, Traits),
    (seats_a, seats_b, seats): (&[u32], &[u32], &[Seat]),
    sweep: &Sweep,
) -> bool {
    let shift = Shift::of(link);
    let a = transpose(core::array::from_fn(|i| seats[seats_a[i] as usize].moved));
    let b = transpose(core::array::from_fn(|i| seats[seats_b[i] as usize].moved));
    let moved = LaneVec::new(b[0] - a[0], b[1] - a[1], b[2] - a[2]);
    let (ta, tb) = (LaneVec::new(a[4], a[5], a[6]), LaneVec::new(b[4], b[5], b[6]));
    let along = link.normal.dot(moved);
    let h = Lane::splat(sweep.substep);
    for point in points.iter_mut() {
        let jb = shift.apply(point.normal_b, shift.normal);
        let mut change = along + (jb.dot(tb) - point.normal_a.dot(ta));
        if traits.surfaces {
            change = change + point.surface * h;
        }
        if traits.uneven {
            // A lane without this point keeps its zeros: `press_together` sums what the points want.
            change = point.mass.greater(Lane::ZERO).keep(change);
        }
        point.separation = point.separation + change;
        point.aim(link, sweep.bias);
    }
    // Against an immovable body the point rides on the moving one: its arm stays.
    link.slide = link.slide + moved;
    turn_warm_start(link, points, &shift)
}

/// The impulses so far are the next substep's warm start, and come as the change of velocity that they made
/// with the arms of this one. Notes what B's new arms change of it: without that a hard blow between bodies
/// that slide leaks angular momentum, 1e-3 of all in a storm of collisions.
fn turn_warm_start(link: &mut LinkPart, points: &Points<'_>, before: &Shift) -> bool {
    let after = Shift::of(link);
    // A lane that slides no longer takes back what it got.
    if !before.any && !after.any {
        return false;
    }
    let none = LaneVec::ZERO;
    let change = |old: LaneVec, new: LaneVec, impulse: Lane| {
        (after.apply(none, new) - before.apply(none, old)).times(impulse)
    };
    link.turn = change(before.normal, after.normal, points.load())
        + change(before.first, after.first, link.first_impulse)
        + change(before.second, after.second, link.second_impulse);
    true
}

fn warm(u: &mut Velocities, link: &LinkPart, points: &Points<'_>) {
    let second = link.normal.cross(link.tangent);
    for point in points.iter() {
        u.apply(link.normal, (point.normal_a, point.normal_b), point.impulse);
    }
    u.apply(link.tangent, (link.first_a, link.first_b), link.first_impulse);
    u.apply(second, (link.second_a, link.second_b), link.second_impulse);
    u.apply_torque(link.twist_a, link.twist_b, link.twist_impulse);
}

/// The tangents as one disc, then the twist.
#[inline(always)]
fn solve_friction(u: &mut Velocities, link: &mut LinkPart, load: Lane, (shift, surfaces): (&Shift, bool)) {
    let limit = link.friction * load;
    let second = link.normal.cross(link.tangent);
    let first_b = shift.apply(link.first_b, shift.first);
    let second_b = shift.apply(link.second_b, shift.second);
    let surface = if surfaces { link.surface } else { LaneVec::ZERO };

    let friction_mass = shift.friction_mass(link, (first_b, second_b));
    let x = link.first_impulse - friction_mass * (u.rate(link.tangent, link.first_a, first_b) + surface.x);
    let y = link.second_impulse - friction_mass * (u.rate(second, link.second_a, second_b) + surface.y);
    let size = (x * x + y * y).sqrt();
    let outside = size.greater(limit);
    let one = Lane::splat(1.0);
    let scale = outside.select(limit / outside.select(size, one), one);
    let (x, y) = ((x * scale).finite().flushed(), (y * scale).finite().flushed());
    u.apply(link.tangent, (link.first_a, first_b), x - link.first_impulse);
    u.apply(second, (link.second_a, second_b), y - link.second_impulse);
    (link.first_impulse, link.second_impulse) = (x, y);

    let limit = limit * link.radius;
    let rate = link.twist_b.dot(u.wb) - link.twist_a.dot(u.wa) + surface.z;
    let z = link.twist_impulse - link.twist_mass * rate;
    let z = z.least(limit).greatest(-limit).finite().flushed();
    u.apply_torque(link.twist_a, link.twist_b, z - link.twist_impulse);
    link.twist_impulse = z;
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
    fn new(u: &'a mut Velocities, link: &LinkPart) -> Self {
        let n = link.normal;
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
    fn finish(self, link: &LinkPart) {
        let p = link.normal.times(self.sum);
        self.u.va = self.u.va - p.each_times(self.u.ma);
        self.u.vb = self.u.vb + p.each_times(self.u.mb);
    }
}

/// What a sweep wants of a point that presses: `rate + bias + soft . impulse = 0`, reached at one point by the
/// impulse `mass . (rate + bias + soft . impulse)` less.
struct Demand {
    bias: Lane,
    soft: Lane,
    mass: Lane,
}

impl Demand {
    /// With a spring for overlaps.
    #[inline(always)]
    fn biased(point: &PointPart) -> Self {
        Self { bias: point.bias, soft: point.soft, mass: point.soft_mass }
    }

    /// Without: an overlap may stay.
    #[inline(always)]
    fn relaxed(point: &PointPart) -> Self {
        let bias = point.bias.greater(Lane::ZERO).keep(point.bias);
        Self { bias, soft: Lane::ZERO, mass: point.mass }
    }

    /// The speed of departure; a point that does not bounce may go on as it does.
    #[inline(always)]
    fn bouncing(point: &PointPart) -> Self {
        let mass = point.bounce.greater(Lane::ZERO).keep(point.mass);
        Self { bias: -point.bounce, soft: Lane::ZERO, mass }
    }
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
    link: &LinkPart,
    ((points, traits), shift): ((&Points<'_>, Traits), &Shift),
    demand: impl Fn(&PointPart) -> Demand,
) -> Lane {
    let (zero, one) = (Lane::ZERO, Lane::splat(1.0));
    let (mut ja, mut jb) = (LaneVec::ZERO, LaneVec::ZERO);
    let (mut wanted, mut soft) = (zero, zero);
    let mut least = Lane::splat(f32::MAX);
    // In a lane without this point all of it is 0.
    for point in points.iter() {
        let demand = demand(point);
        ja = ja + point.normal_a;
        jb = jb + point.normal_b;
        soft = soft + demand.soft;
        wanted = wanted + (demand.bias + demand.soft * point.impulse);
        if traits.surfaces {
            wanted = wanted + point.surface;
        }
        let lesser = point.impulse.least(least);
        least = if traits.uneven { point.mass.greater(zero).select(lesser, least) } else { lesser };
    }
    let count = link.count;
    let jb = shift.apply(jb, shift.normal.times(count));
    let rate = count * line.speed + (jb.dot(line.u.wb) - ja.dot(line.u.wa));
    let inertia = count * count * line.yields + ja.dot(ja) + jb.dot(jb) + soft;
    let several = count.greater(Lane::splat(1.5)).and(inertia.greater(zero));
    let x = -(rate + wanted) / several.select(inertia, one);
    let x = several.keep(x.greatest(-least)).finite();
    line.press((ja, jb), (count, x));
    x
}

/// All points together, then one after the other.
#[inline(always)]
fn solve_points(
    mut line: Line<'_>,
    link: &LinkPart,
    ((points, traits), shift): ((&mut Points<'_>, Traits), &Shift),
    demand: impl Fn(&PointPart) -> Demand,
) {
    let one = Lane::splat(1.0);
    let mut together = Lane::ZERO;
    if points.rows.len() > 1 {
        together = press_together(&mut line, link, ((points, traits), shift), &demand);
    }
    for point in points.iter_mut() {
        let jb = shift.apply(point.normal_b, shift.normal);
        let mut rate = line.rate(point.normal_a, jb);
        if traits.surfaces {
            rate = rate + point.surface;
        }
        let own = if traits.uneven { point.mass.greater(Lane::ZERO).keep(together) } else { together };
        let before = point.impulse + own;
        let demand = demand(point);
        let mass = shift.mass((point, demand.mass), jb);
        let after = (before - mass * (rate + demand.bias + demand.soft * before)).pushing();
        point.impulse = after;
        line.press((point.normal_a, jb), (one, after - before));
    }
    line.finish(link);
}

#[inline(always)]
fn solve_normals(
    u: &mut Velocities,
    link: &LinkPart,
    (points, traits): (&mut Points<'_>, Traits),
    (sweep, shift): (&Sweep, &Shift),
) {
    let line = Line::new(u, link);
    if traits.bounces {
        record_bounces(&line, link, points, (sweep, shift));
    }
    if sweep.pass == Pass::Biased {
        solve_points(line, link, ((points, traits), shift), Demand::biased);
    } else {
        solve_points(line, link, ((points, traits), shift), Demand::relaxed);
    }
}

/// Fixes the energy with which a point will leave, when it presses for the first time in this step. All points of a
/// row see the velocity before the row's impulses, so that a box that falls flat does not start to spin.
///
/// Symplectic Euler conserves `H = v^2/2 - a s + a h v/2` in free flight along the normal (acceleration a, height
/// s); the point leaves with `e^2 H`: apexes then keep their height whatever the substep.
fn record_bounces(
    line: &Line<'_>,
    link: &LinkPart,
    points: &mut Points<'_>,
    (sweep, shift): (&Sweep, &Shift),
) {
    let (zero, half) = (Lane::ZERO, Lane::splat(0.5));
    // The biased sweep sees the velocity with this substep's push (push = a h), but heights before its motion.
    let biased = sweep.pass == Pass::Biased;
    let early = if biased { link.push } else { zero };
    let e2 = link.restitution * link.restitution;
    for point in points.iter_mut() {
        let rate = line.rate(point.normal_a, shift.apply(point.normal_b, shift.normal)) + point.surface;
        let bias = if biased { point.bias } else { Demand::relaxed(point).bias };
        let fast = rate.less(Lane::splat(-sweep.restitution_threshold));
        let presses = (point.mass * (rate + bias)).less(point.impulse).and(point.mass.greater(zero));
        let unset = point.bounce.less(Lane::splat(f32::MIN_POSITIVE));
        let before = rate - early;
        let energy = half * before * (before + link.push) - height_energy(sweep, link, point);
        let record = fast.and(presses).and(unset).and(link.restitution.greater(zero));
        point.bounce = record.select((e2 * energy).finite(), point.bounce);
    }
}

/// `a s` of a point that is apart, m2/s2.
#[inline(always)]
fn height_energy(sweep: &Sweep, link: &LinkPart, point: &PointPart) -> Lane {
    link.push * Lane::splat(sweep.bias.rate) * point.separation.greatest(Lane::ZERO)
}

/// Gives the bouncing points their speed: the root of `v^2/2 + a h v/2 = E + a s`.
fn bounce(
    u: &mut Velocities,
    link: &LinkPart,
    (points, traits): (&mut Points<'_>, Traits),
    (sweep, shift): (&Sweep, &Shift),
) {
    let (zero, half, two) = (Lane::ZERO, Lane::splat(0.5), Lane::splat(2.0));
    let half_push = half * link.push;
    for point in points.iter_mut() {
        let energy = (point.bounce + height_energy(sweep, link, point)).greatest(zero);
        let speed = (half_push * half_push + two * energy).sqrt() - half_push;
        point.bounce = point.bounce.greater(zero).keep(speed.finite());
    }
    solve_points(Line::new(u, link), link, ((points, traits), shift), Demand::bouncing);
}
