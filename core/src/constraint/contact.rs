//! Projected Gauss-Seidel on contacts, lane by lane (SEED S9 to S12).
//!
//! Every update is used at once and clamped to its bounds: `lambda >= 0` along the normal, a disc
//! `|lambda_t| <= mu sum(lambda_n)` for the tangents of the patch, and the same times the patch's radius for the
//! twist; or a disc for each point, see `cones.rs`. Friction comes before the normals, whose errors are the visible
//! ones.
//!
//! Legend: `va, wa, ma` are velocity, whitened angular velocity and inverse mass of body A; `n` the normal, `t`
//! and `s` the tangents; `h` the substep.

mod bounce;
mod cones;
mod residual;
mod resist;
mod shift;
mod split;

use super::row::{Bias, ConeRow, LinkRow, PointRow, ResistRow, SUMS, TURNS};
use super::velocities::{Velocities, motions};
use crate::lanes::{Lane, LaneVec};
use crate::pipeline::seat::Seat;
use bounce::{bounce, forget_blows, record_bounces};
pub(crate) use cones::{into_disc, step_of, yields_of};
pub(crate) use residual::measure;
use shift::Shift;

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
    /// Solves velocities of the joints that leap, after the rest of their push: see `pipeline/leapfrog.rs`.
    Leap,
    /// The same where the substep is the step, and so began with half a push: the impulses count. Else they are
    /// those of a whole push already.
    LeapOnce,
    /// Gives bouncing points their speed.
    Bounce,
}

/// Numbers that all rows of a sweep share.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sweep {
    pub pass: Pass,
    /// How often each block is visited.
    pub visits: u32,
    /// Substep, seconds.
    pub substep: f32,
    pub bias: Bias,
    /// True when some rows move bodies by nudges; see `velocities.rs`.
    pub nudges: bool,
    /// True when contacts do, instead of pushing by velocity.
    pub splits: bool,
    /// True when the substep has more than one relax sweep of a row.
    pub relaxes_again: bool,
    /// True when no joint is visited any more in this step: those that only hold need not follow their bodies.
    pub ends: bool,
    /// Approach below which nothing bounces, m/s.
    pub restitution_threshold: f32,
}

/// Visits all rows of a group in their order. `resists` has a row for each, or none where nothing resists; `cones`
/// too, or none where friction is that of patches.
pub(crate) fn visit(
    sweep: &Sweep,
    (rows, resists, cones): (&mut [LinkRow], &mut [ResistRow], &mut [ConeRow]),
    points: &mut [PointRow],
    seats: &mut [Seat],
) {
    let mut rest = points;
    for (i, row) in rows.iter_mut().enumerate() {
        let (points, after) = rest.split_at_mut(row.points as usize);
        rest = after;
        if sweep.pass == Pass::Bounce && row.bounces == 0 {
            continue;
        }
        // One kernel, compiled for each number of points: its loops have no ends to test. The patch of one point is
        // its cone.
        match (row.points, cones.get_mut(i)) {
            (1, _) => visit_row::<1, _>(sweep, row, (points, &mut Patch), seats),
            (2, None) => visit_row::<2, _>(sweep, row, (points, &mut Patch), seats),
            (3, None) => visit_row::<3, _>(sweep, row, (points, &mut Patch), seats),
            (_, None) => visit_row::<4, _>(sweep, row, (points, &mut Patch), seats),
            (2, Some(cones)) => visit_row::<2, _>(sweep, row, (points, cones), seats),
            (3, Some(cones)) => visit_row::<3, _>(sweep, row, (points, cones), seats),
            (_, Some(cones)) => visit_row::<4, _>(sweep, row, (points, cones), seats),
        }
        if row.resists != 0
            && let Some(resist) = resists.get_mut(i)
        {
            resist::visit(sweep, row, (points, resist), seats);
        }
    }
}

/// How the friction of a row is bounded.
trait Friction {
    /// Solves the row along its tangents and about its normal. Returns the impulse across the normal, which the
    /// linear velocities have yet to get: see [`Line`].
    fn solve<const N: usize>(
        &mut self,
        u: &mut Velocities,
        row: &mut LinkRow,
        points: &[PointRow; N],
        motion: (&Shift, bool),
    ) -> LaneVec;
}

/// As one: see [`solve_friction`].
struct Patch;

impl Friction for Patch {
    #[inline(always)]
    fn solve<const N: usize>(
        &mut self,
        u: &mut Velocities,
        row: &mut LinkRow,
        points: &[PointRow; N],
        motion: (&Shift, bool),
    ) -> LaneVec {
        solve_friction::<N>(u, row, load_of(points), motion)
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

impl Traits {
    const NONE: Self = Self { bounces: false, locked: false, uneven: false, surfaces: false };
}

fn visit_row<const N: usize, F: Friction>(
    sweep: &Sweep,
    row: &mut LinkRow,
    (points, friction): (&mut [PointRow], &mut F),
    seats: &mut [Seat],
) {
    let traits = Traits {
        bounces: row.bounces != 0,
        locked: row.locked != 0,
        uneven: row.uneven != 0,
        surfaces: row.surfaces != 0,
    };
    let Some(points) = points.first_chunk_mut::<N>() else { return };
    if row.bounces | row.locked | row.uneven | row.surfaces == 0 {
        // The same code: that nothing is to be looked up is known when it is compiled.
        visit_points(sweep, row, (points, friction, Traits::NONE), seats);
    } else {
        visit_points(sweep, row, (points, friction, traits), seats);
    }
}

#[inline(always)]
fn visit_points<const N: usize, F: Friction>(
    sweep: &Sweep,
    row: &mut LinkRow,
    (points, friction, traits): (&mut [PointRow; N], &mut F, Traits),
    seats: &mut [Seat],
) {
    if matches!(sweep.pass, Pass::Relax | Pass::Follow) {
        follow(row, (points, traits), seats, sweep);
        if sweep.pass == Pass::Follow {
            return;
        }
    }
    let shift = Shift::of(row);
    let mut u = Velocities::gather((&row.seats_a, &row.seats_b), seats, traits.locked);
    match sweep.pass {
        Pass::Warm => {
            if traits.bounces {
                forget_blows(&Line::new(&mut u, row, (LaneVec::ZERO, false)), row, points, (sweep, &shift));
            }
            warm(&mut u, row, points);
        }
        Pass::Bounce => bounce(&mut u, row, (points, traits), (sweep, &shift)),
        _ => {
            if row.turns != 0 && sweep.pass == Pass::Biased {
                if row.turns & TURNS != 0 {
                    u.wb = u.wb + row.turn;
                }
                if row.turns & SUMS != 0 {
                    row.total = row.total + load_of(points);
                }
                row.turns = 0;
            }
            if shift.any {
                solve_sliding(&mut u, row, (points, friction, traits), (sweep, &shift));
            } else {
                solve(&mut u, row, (points, friction, traits), (sweep, &Shift::NONE));
            }
        }
    }
    u.scatter((&row.seats_a, &row.seats_b), seats);
    if sweep.splits && sweep.pass == Pass::Biased {
        split::nudge(&u, row, points, (sweep, &shift), seats);
    }
}

/// Sum of the points' impulses.
#[inline(always)]
fn load_of(points: &[PointRow]) -> Lane {
    points.iter().fold(Lane::ZERO, |sum, point| sum + point.impulse)
}

/// A row whose bodies have not slid along each other.
#[inline(always)]
fn solve<const N: usize, F: Friction>(
    u: &mut Velocities,
    row: &mut LinkRow,
    (points, friction, traits): (&mut [PointRow; N], &mut F, Traits),
    (sweep, shift): (&Sweep, &Shift),
) {
    let across = friction.solve(u, row, points, (shift, traits.surfaces));
    solve_normals(u, row, (points, traits), (sweep, shift, across));
}

/// The same for one whose bodies have: it is rare, and kept out of the way.
#[inline(never)]
fn solve_sliding<const N: usize, F: Friction>(
    u: &mut Velocities,
    row: &mut LinkRow,
    (points, friction, traits): (&mut [PointRow; N], &mut F, Traits),
    (sweep, shift): (&Sweep, &Shift),
) {
    solve(u, row, (points, friction, traits), (sweep, shift));
}

/// Brings separations and the slide to the end of the substep.
#[inline(always)]
fn follow<const N: usize>(
    row: &mut LinkRow,
    (points, traits): (&mut [PointRow; N], Traits),
    seats: &[Seat],
    sweep: &Sweep,
) {
    let shift = Shift::of(row);
    let [a, b] = motions((&row.seats_a, &row.seats_b), seats);
    let moved = LaneVec::new(b[0] - a[0], b[1] - a[1], b[2] - a[2]);
    let (ta, tb) = (LaneVec::new(a[4], a[5], a[6]), LaneVec::new(b[4], b[5], b[6]));
    let along = row.normal.dot(moved);
    let h = Lane::splat(sweep.substep);
    let mut soft = Lane::ZERO;
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
        point.aim(row, sweep.bias);
        soft = soft + point.soft;
    }
    if N > 1 {
        row.soft_press_mass = press_mass(row.count, row.inertia + soft);
    }
    // Against an immovable body the point rides on the moving one: its arm stays.
    row.slide = shift::limited(row.slide + moved, row.slide_min);
    if row.hits != 0 {
        row.turns |= SUMS;
    }
    turn_warm_start(row, points, &shift);
}

/// The impulses so far are the next substep's warm start, and come as the change of velocity that they made
/// with the arms of this one. Notes what B's new arms change of it: without that a hard blow between bodies
/// that slide leaks angular momentum, 1e-3 of all in a storm of collisions.
fn turn_warm_start<const N: usize>(row: &mut LinkRow, points: &[PointRow; N], before: &Shift) {
    let after = Shift::of(row);
    // A lane that slides no longer takes back what it got.
    if !before.any && !after.any {
        return;
    }
    let none = LaneVec::ZERO;
    let change = |old: LaneVec, new: LaneVec, impulse: Lane| {
        (after.apply(none, new) - before.apply(none, old)).times(impulse)
    };
    row.turn = change(before.normal, after.normal, load_of(points))
        + change(before.first, after.first, row.first_impulse)
        + change(before.second, after.second, row.second_impulse);
    row.turns |= TURNS;
}

fn warm<const N: usize>(u: &mut Velocities, row: &LinkRow, points: &[PointRow; N]) {
    let second = row.normal.cross(row.tangent);
    for point in points.iter() {
        u.apply(row.normal, (point.normal_a, point.normal_b), point.impulse);
    }
    u.apply(row.tangent, (row.first_a, row.first_b), row.first_impulse);
    u.apply(second, (row.second_a, row.second_b), row.second_impulse);
    if N > 1 {
        u.apply_torque(row.twist_a, row.twist_b, row.twist_impulse);
    }
}

/// The tangents as one disc, then the twist. Returns the impulse across the normal, which the linear velocities
/// have yet to get: see [`Line`].
#[inline(always)]
fn solve_friction<const N: usize>(
    u: &mut Velocities,
    row: &mut LinkRow,
    load: Lane,
    (shift, surfaces): (&Shift, bool),
) -> LaneVec {
    let limit = row.friction * load;
    let second = row.normal.cross(row.tangent);
    let first_b = shift.apply(row.first_b, shift.first);
    let second_b = shift.apply(row.second_b, shift.second);
    let surface = if surfaces { row.surface } else { LaneVec::ZERO };

    let friction_mass = shift.friction_mass(row, (first_b, second_b));
    let x = row.first_impulse - friction_mass * (u.rate(row.tangent, row.first_a, first_b) + surface.x);
    let y = row.second_impulse - friction_mass * (u.rate(second, row.second_a, second_b) + surface.y);
    let (mut x, mut y) = (x.flushed(), y.flushed());
    let square = x * x + y * y;
    let outside = square.greater(limit * limit);
    // A lane inside the disc is multiplied by 1: `any` only saves the root and the division.
    if outside.any() {
        let one = Lane::splat(1.0);
        let scale = outside.select(limit / outside.select(square.sqrt(), one), one);
        (x, y) = (x * scale, y * scale);
    }
    let (x, y) = (x.finite(), y.finite());
    let (dx, dy) = (x - row.first_impulse, y - row.second_impulse);
    u.apply_torque(row.first_a, first_b, dx);
    u.apply_torque(row.second_a, second_b, dy);
    let across = row.tangent.times(dx) + second.times(dy);
    (row.first_impulse, row.second_impulse) = (x, y);

    // One point has no lever.
    if N == 1 {
        return across;
    }
    let limit = limit * row.radius;
    let rate = row.twist_b.dot(u.wb) - row.twist_a.dot(u.wa) + surface.z;
    let z = row.twist_impulse - row.twist_mass * rate;
    let z = z.least(limit).greatest(-limit).finite().flushed();
    u.apply_torque(row.twist_a, row.twist_b, z - row.twist_impulse);
    row.twist_impulse = z;
    across
}

/// The relative motion along the normal, kept as one number while the points of a row are solved: the linear
/// velocities get the impulses of friction and of all points at once.
struct Line<'a> {
    u: &'a mut Velocities,
    /// n . (vb - va), m/s.
    speed: Lane,
    /// What an impulse of 1 changes of it, 1/kg.
    yields: Lane,
    /// Impulse of all points, not yet given to the linear velocities.
    sum: Lane,
    /// The same across the normal.
    across: LaneVec,
}

impl<'a> Line<'a> {
    #[inline(always)]
    fn new(u: &'a mut Velocities, row: &LinkRow, (across, locked): (LaneVec, bool)) -> Self {
        let n = row.normal;
        let free = u.ma + u.mb;
        let mut speed = n.dot(u.vb - u.va);
        if locked {
            // An impulse across the normal gives speed along it where axes are locked; else only rounding would.
            speed = u.are_locked().select(speed + n.dot(across.each_times(free)), speed);
        }
        let yields = n.dot(n.each_times(free));
        Self { u, speed, yields, sum: Lane::ZERO, across }
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
        let p = self.across + row.normal.times(self.sum);
        self.u.va = self.u.va - p.each_times(self.u.ma);
        self.u.vb = self.u.vb + p.each_times(self.u.mb);
    }
}

/// What a sweep wants of a point that presses: `rate + bias + soft . impulse = 0`, reached at one point by the
/// impulse `mass . (rate + bias + soft . impulse)` less. What gives is the impulse beyond `load`.
struct Demand {
    bias: Lane,
    soft: Lane,
    mass: Lane,
    load: Lane,
}

impl Demand {
    /// With a spring for overlaps.
    #[inline(always)]
    fn biased(point: &PointRow) -> Self {
        Self { bias: point.bias, soft: point.soft, mass: point.soft_mass, load: Lane::ZERO }
    }

    /// Without: an overlap may stay.
    #[inline(always)]
    fn relaxed(point: &PointRow) -> Self {
        let bias = point.bias.greater(Lane::ZERO).keep(point.bias);
        Self { bias, soft: Lane::ZERO, mass: point.mass, load: Lane::ZERO }
    }

    /// The speed of departure; a point that does not bounce may go on as it does.
    #[inline(always)]
    fn bouncing(point: &PointRow) -> Self {
        let mass = point.bounce.greater(Lane::ZERO).keep(point.mass);
        Self { bias: -point.bounce, soft: Lane::ZERO, mass, load: Lane::ZERO }
    }
}

/// What "the same impulse more at every point" takes off the sum of the points' rates, inverted. 0 for one point.
#[inline(always)]
pub(crate) fn press_mass(count: Lane, inertia: Lane) -> Lane {
    let one = Lane::splat(1.0);
    let several = count.greater(Lane::splat(1.5)).and(inertia.greater(Lane::splat(f32::MIN_POSITIVE)));
    several.keep(one / several.select(inertia, one))
}

/// One exact step along "the same impulse more at every point"; returns that impulse. The points have yet to take
/// it.
///
/// Points taken one after the other share a change of the load unequally: the first takes most of it, the body
/// tilts, and a tower sways while it settles (24 mm for ten boxes; 1 micrometre with this step). The step is
/// the minimum of the row's energy in that direction, so it never slows the sweeps down; it stops where the first
/// point would pull. Where points are apart, that is at once.
#[inline(always)]
fn press_together<const N: usize>(
    line: &mut Line<'_>,
    row: &LinkRow,
    ((points, traits), shift): ((&[PointRow; N], Traits), &Shift),
    (mass, demand): (Lane, impl Fn(&PointRow) -> Demand),
) -> Lane {
    let zero = Lane::ZERO;
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
    let count = row.count;
    let jb = shift.apply(jb, shift.normal.times(count));
    let rate = count * line.speed + (jb.dot(line.u.wb) - ja.dot(line.u.wa));
    let mass = if shift.any {
        press_mass(count, count * count * line.yields + ja.dot(ja) + jb.dot(jb) + soft)
    } else {
        mass
    };
    let x = (mass * -(rate + wanted)).greatest(-least).finite();
    line.press((ja, jb), (count, x));
    x
}

/// One point after the other. Each has yet to take `together`, which is pressed already.
#[inline(always)]
fn solve_points<const N: usize>(
    mut line: Line<'_>,
    row: &LinkRow,
    ((points, traits), shift): ((&mut [PointRow; N], Traits), &Shift),
    (together, demand): (Lane, impl Fn(&PointRow) -> Demand),
) {
    let one = Lane::splat(1.0);
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
        let give = demand.soft * (before - demand.load);
        let after = (before - mass * (rate + demand.bias + give)).pushing();
        point.impulse = after;
        line.press((point.normal_a, jb), (one, after - before));
    }
    line.finish(row);
}

#[inline(always)]
fn solve_normals<const N: usize>(
    u: &mut Velocities,
    row: &LinkRow,
    (points, traits): (&mut [PointRow; N], Traits),
    (sweep, shift, across): (&Sweep, &Shift, LaneVec),
) {
    let line = Line::new(u, row, (across, traits.locked));
    if traits.bounces {
        record_bounces(&line, row, points, (sweep, shift));
    }
    match (sweep.pass, sweep.splits) {
        (Pass::Biased, false) => {
            solve_all(line, row, ((points, traits), shift), (row.soft_press_mass, Demand::biased));
        }
        (Pass::Biased, true) if N > 1 => split::solve(line, row, ((points, traits), shift)),
        _ => solve_all(line, row, ((points, traits), shift), (row.press_mass, Demand::relaxed)),
    }
}

/// All points together, then one after the other.
#[inline(always)]
fn solve_all<const N: usize>(
    mut line: Line<'_>,
    row: &LinkRow,
    ((points, traits), shift): ((&mut [PointRow; N], Traits), &Shift),
    (press_mass, demand): (Lane, impl Fn(&PointRow) -> Demand),
) {
    let mut together = Lane::ZERO;
    if N > 1 {
        together = press_together(&mut line, row, ((points, traits), shift), (press_mass, &demand));
    }
    solve_points(line, row, ((points, traits), shift), (together, demand));
}
