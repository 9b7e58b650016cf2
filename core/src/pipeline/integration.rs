//! Integration (the talk's fifth stage): leaf math that phase 0 of the solve calls for its own bodies.
//!
//! Translation is symplectic Euler. Rotation of a body with unequal moments is one map on orientation and angular
//! momentum, the gyroscopic term `w x I w` (SEED S4) included: with `L` in the principal frame, energy splits as
//! ```text
//! E = |L|^2 / (2 Ir)  +  sum over the two other axes i of  Li^2 / 2 (1/Ii - 1/Ir)
//! ```
//! The first part turns the body about L, exactly, and commutes with the rest; each of the others is an exact
//! rotation about a principal axis. They are composed symmetrically (Strang): second order, time-reversible, no
//! energy drift; since every part turns the body and L together, L in the world is exact. The reference axis r is
//! chosen so that one of the two differences is the smallest possible: a symmetric top is solved exactly.

use crate::lanes::{LANES, Lane, LaneVec, Mask};
use crate::math::{Mat3, RENORMAL, Rotation, Vec3, length};
use bytemuck::{Pod, Zeroable};

/// Largest rotation of one split, radians; more is done in several.
pub(crate) const TURN_STEP: f32 = 0.3;
/// Squared angle from which on sine and cosine are taken from the library, rad2.
const SERIES_SQUARE: f32 = 0.5;
/// Squared sine of half an angle from which on the arc is taken from the library.
const ARC_SQUARE: f32 = 1.0 / 16.0;
/// What the splits of the fastest spin come to.
pub(crate) const SPLITS_MAX: f32 = 256.0;

/// W v for a symmetric W (xx, yy, zz, xy, xz, yz).
#[inline(always)]
pub(crate) fn root_times(w: &[f32; 6], v: Vec3) -> Vec3 {
    Vec3::new(
        w[0] * v.x + w[3] * v.y + w[4] * v.z,
        w[3] * v.x + w[1] * v.y + w[5] * v.z,
        w[4] * v.x + w[5] * v.y + w[2] * v.z,
    )
}

/// The symmetric matrix with these eigenvalues along the columns of a rotation.
pub(crate) fn along_axes(m: &Mat3, values: Vec3) -> [f32; 6] {
    let (a, b, c) = (m.x_axis, m.y_axis, m.z_axis);
    let entry = |i: usize, j: usize| values.x * a[i] * a[j] + values.y * b[i] * b[j] + values.z * c[i] * c[j];
    [entry(0, 0), entry(1, 1), entry(2, 2), entry(0, 1), entry(0, 2), entry(1, 2)]
}

/// The symmetric W with W W = inverse inertia in the world among the axes that are not locked, 0 elsewhere.
pub(crate) fn locked_root_of(principal: Rotation, inertia: Vec3, turn_locks: u8) -> [f32; 6] {
    let free: heapless::Vec<usize, 3> = (0..3).filter(|i| turn_locks >> i & 1 == 0).collect();
    let m = principal.matrix();
    let (a, b, c) = (m.x_axis, m.y_axis, m.z_axis);
    let entry =
        |i: usize, j: usize| inertia.x * a[i] * a[j] + inertia.y * b[i] * b[j] + inertia.z * c[i] * c[j];
    let mut root = [0.0; 6];
    match free.as_slice() {
        [i] => root[*i] = 1.0 / crate::math::sqrt(entry(*i, *i)),
        [i, j] => {
            // sqrt(M) = (M + sqrt(det) 1) / sqrt(trace + 2 sqrt(det)) for a 2x2 positive matrix M, and the inverse
            // of [p r; r q] is [q -r; -r p] / det.
            let (p, q, r) = (entry(*i, *i), entry(*j, *j), entry(*i, *j));
            let det = crate::math::max(p * q - r * r, f32::MIN_POSITIVE);
            let (p, q, r) = (q / det, p / det, -r / det);
            let d = crate::math::sqrt(1.0 / det);
            let t = crate::math::sqrt(p + q + 2.0 * d);
            root[*i] = (p + d) / t;
            root[*j] = (q + d) / t;
            root[off_diagonal(*i, *j)] = r / t;
        }
        _ => {}
    }
    root
}

/// W for a principal frame and its moments, and the whitened angular velocity `W^-1 angular`: 0 on locked axes.
pub(crate) fn root_and_whitened(
    principal: Rotation,
    inertia: Vec3,
    turn_locks: u8,
    angular: Vec3,
) -> ([f32; 6], Vec3) {
    if turn_locks != 0 {
        let root = locked_root_of(principal, inertia, turn_locks);
        return (root, whiten(&root, angular));
    }
    if inertia.x == inertia.y && inertia.y == inertia.z {
        // Divided, so that its product with the root is what it was but for rounding to both sides.
        let s = 1.0 / crate::math::sqrt(inertia.x);
        return ([s, s, s, 0.0, 0.0, 0.0], angular / s);
    }
    let roots = square_roots(inertia);
    let m = principal.matrix();
    let whitened = m * (roots * (m.transpose() * angular));
    (along_axes(&m, 1.0 / roots), whitened)
}

/// Square roots of the components.
pub(crate) fn square_roots(v: Vec3) -> Vec3 {
    Vec3::new(crate::math::sqrt(v.x), crate::math::sqrt(v.y), crate::math::sqrt(v.z))
}

/// Where the entry of rows `i < j` stands.
const fn off_diagonal(i: usize, j: usize) -> usize {
    match (i, j) {
        (0, 1) => 3,
        (0, 2) => 4,
        _ => 5,
    }
}

/// `W^-1 v` on the axes that can turn; 0 on locked ones.
pub(crate) fn whiten(w: &[f32; 6], v: Vec3) -> Vec3 {
    // Gaussian elimination on the free axes; a locked axis has a zero row and column.
    let locked = |i: usize| w[i] == 0.0;
    let mut m = [[w[0], w[3], w[4]], [w[3], w[1], w[5]], [w[4], w[5], w[2]]];
    let mut x = v.to_array();
    for i in 0..3 {
        if locked(i) {
            m[i] = [0.0; 3];
            m[i][i] = 1.0;
            x[i] = 0.0;
        }
    }
    // W is positive on the free axes, so no pivoting is needed.
    for i in 0..3 {
        for k in i + 1..3 {
            let (pivot, factor) = (m[i], m[k][i] / m[i][i]);
            for (entry, above) in m[k].iter_mut().zip(pivot).skip(i) {
                *entry -= factor * above;
            }
            x[k] -= factor * x[i];
        }
    }
    for i in (0..3).rev() {
        for j in i + 1..3 {
            x[i] -= m[i][j] * x[j];
        }
        x[i] /= m[i][i];
    }
    Vec3::from_array(x)
}

/// sin(a/2)/a and cos(a/2) of an angle given by its square.
#[inline]
fn half_angle(a2: f32) -> (f32, f32) {
    if a2 < SERIES_SQUARE {
        // Taylor series: the next terms are below 1e-9 here.
        let s = 0.5 - a2 * (1.0 / 48.0 - a2 * (1.0 / 3840.0 - a2 * (1.0 / 645_120.0)));
        let c = 1.0 - a2 * (1.0 / 8.0 - a2 * (1.0 / 384.0 - a2 * (1.0 / 46_080.0)));
        return (s, c);
    }
    let a = crate::math::sqrt(a2);
    (crate::math::sin(0.5 * a) / a, crate::math::cos(0.5 * a))
}

/// `rotation` turned in the world by the rotation vector `turn` (exponential map).
#[inline]
pub(crate) fn turned(rotation: Rotation, turn: Vec3) -> Rotation {
    let (s, c) = half_angle(turn.dot(turn));
    Rotation::new(turn.x * s, turn.y * s, turn.z * s, c).after(rotation).renormalized()
}

/// Mean velocity, over `time` seconds, of the point at `arm` of a body that turns about its center: along the chord
/// of its arc, so that what goes along with the point is where the point is at the end.
pub(crate) fn chord(angular: Vec3, arm: Vec3, time: f32) -> Vec3 {
    // (R - 1) r = sin(a) / a (t x r) + (1 - cos(a)) / a^2 t x (t x r) for the rotation vector t, of length a.
    let turn = angular * time;
    let (s, c) = half_angle(turn.dot(turn));
    let tangent = angular.cross(arm);
    tangent * (2.0 * s * c) + turn.cross(tangent) * (2.0 * s * s)
}

/// The rotation vector of a rotation, of at most half a turn.
pub(crate) fn rotation_vector(q: Rotation) -> Vec3 {
    let q = if q.w < 0.0 { Rotation::new(-q.x, -q.y, -q.z, -q.w) } else { q };
    let v = q.imaginary();
    let sine = length(v);
    if sine < 1.0e-3 {
        // asin(s) / s = 1 + s^2 / 6.
        return v * (2.0 + sine * sine * (1.0 / 3.0));
    }
    v * (2.0 * crate::math::atan2(sine, q.w) / sine)
}

/// The order of the principal axes in which a free top is turned: the reference axis first, then the one whose
/// moment is nearest to it, as a rotation of the frame; and the moments in that order.
pub(crate) fn split_frame(inertia: Vec3) -> (Rotation, Vec3) {
    let i = inertia;
    // Nearness of two axes is the difference of their rates.
    let difference = |a: usize, b: usize| (1.0 / i[a] - 1.0 / i[b]).abs();
    let (xy, yz, zx) = (difference(0, 1), difference(1, 2), difference(2, 0));
    if xy <= yz && xy <= zx {
        (Rotation::IDENTITY, i)
    } else if yz <= zx {
        (Rotation::new(0.5, 0.5, 0.5, 0.5), Vec3::new(i.y, i.z, i.x))
    } else {
        (Rotation::new(-0.5, -0.5, -0.5, 0.5), Vec3::new(i.z, i.x, i.y))
    }
}

/// A rotation in every lane.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(crate) struct LaneRotation {
    pub imaginary: LaneVec,
    pub real: Lane,
}

impl LaneRotation {
    /// The rotation of one lane.
    pub fn get(&self, lane: usize) -> Rotation {
        let v = self.imaginary.get(lane);
        Rotation::new(v.x, v.y, v.z, self.real.get(lane))
    }

    /// Writes the rotation of one lane.
    pub fn set(&mut self, lane: usize, q: Rotation) {
        self.imaginary.set(lane, q.imaginary());
        self.real.set(lane, q.w);
    }

    /// By a rotation vector (exponential map).
    #[inline(always)]
    pub fn by(turn: LaneVec) -> Self {
        let (s, c) = half_angles(turn.dot(turn));
        Self { imaginary: turn.times(s), real: c }
    }

    /// With small imaginary parts as 0: see [`Rotation::flushed`].
    #[inline(always)]
    pub fn flushed(self) -> Self {
        Self { imaginary: self.imaginary.flushed(), real: self.real }
    }

    /// `self` after `first`.
    #[inline(always)]
    pub fn after(self, first: Self) -> Self {
        let (a, b) = (self.imaginary, first.imaginary);
        Self {
            imaginary: b.times(self.real) + a.times(first.real) + a.cross(b),
            real: self.real * first.real - a.dot(b),
        }
    }

    /// `yes` where true, `no` where false.
    #[inline(always)]
    pub fn select(mask: Mask, yes: Self, no: Self) -> Self {
        Self { imaginary: mask.select_vec(yes.imaginary, no.imaginary), real: mask.select(yes.real, no.real) }
    }

    /// See [`Rotation::renormalized`].
    #[inline(always)]
    pub fn renormalized(self) -> Self {
        let off = self.imaginary.dot(self.imaginary) + self.real * self.real - Lane::splat(1.0);
        let k = Lane::splat(1.0) - Lane::splat(0.5) * off;
        let mut unit = Self { imaginary: self.imaginary.times(k), real: self.real * k };
        let (least, most) = (Lane::splat(-RENORMAL), Lane::splat(RENORMAL));
        let near = off.greater(least).and(off.less(most));
        if !near.all() {
            self.normalize_far(off, &mut unit);
        }
        unit
    }

    #[cold]
    fn normalize_far(&self, off: Lane, unit: &mut Self) {
        for lane in 0..LANES {
            let off = off.get(lane);
            if !(off > -RENORMAL && off < RENORMAL) {
                unit.set(lane, self.get(lane).normalized());
            }
        }
    }

    /// Where the second axis of the frame points.
    #[inline(always)]
    fn second(self) -> LaneVec {
        let (LaneVec { x, y, z }, w) = (self.imaginary, self.real);
        let (one, two) = (Lane::splat(1.0), Lane::splat(2.0));
        LaneVec::new(two * (x * y - w * z), one - two * (x * x + z * z), two * (y * z + w * x))
    }

    /// Where the third axis of the frame points.
    #[inline(always)]
    pub fn third(self) -> LaneVec {
        let (LaneVec { x, y, z }, w) = (self.imaginary, self.real);
        let (one, two) = (Lane::splat(1.0), Lane::splat(2.0));
        LaneVec::new(two * (x * z + w * y), two * (y * z - w * x), one - two * (x * x + y * y))
    }

    /// The rotation vector, of at most half a turn.
    #[inline(always)]
    pub fn vector(self) -> LaneVec {
        let square = self.imaginary.dot(self.imaginary);
        // 2 asin(s) / s; the next term is below 1e-7 here.
        let terms = [105.0 / 1728.0, 5.0 / 56.0, 3.0 / 20.0, 1.0 / 3.0, 2.0];
        let scale = terms.iter().fold(Lane::ZERO, |sum, &term| sum * square + Lane::splat(term));
        let mut vector = self.imaginary.times(scale);
        let near = square.less(Lane::splat(ARC_SQUARE)).and(self.real.greater(Lane::ZERO));
        if !near.all() {
            self.far_vector(&mut vector);
        }
        vector
    }

    #[cold]
    fn far_vector(&self, vector: &mut LaneVec) {
        for lane in 0..LANES {
            let q = self.get(lane);
            let v = q.imaginary();
            if !(v.dot(v) < ARC_SQUARE && q.w > 0.0) {
                vector.set(lane, rotation_vector(q));
            }
        }
    }
}

/// [`half_angle`] of eight angles.
#[inline(always)]
fn half_angles(a2: Lane) -> (Lane, Lane) {
    let series = |terms: [f32; 4]| {
        let [a, b, c, d] = terms.map(Lane::splat);
        a - a2 * (b - a2 * (c - a2 * d))
    };
    let mut s = series([0.5, 1.0 / 48.0, 1.0 / 3840.0, 1.0 / 645_120.0]);
    let mut c = series([1.0, 1.0 / 8.0, 1.0 / 384.0, 1.0 / 46_080.0]);
    if !a2.less(Lane::splat(SERIES_SQUARE)).all() {
        far_half_angles(a2, (&mut s, &mut c));
    }
    (s, c)
}

#[cold]
fn far_half_angles(a2: Lane, (s, c): (&mut Lane, &mut Lane)) {
    for lane in 0..LANES {
        let (sine, cosine) = half_angle(a2.get(lane));
        s.set(lane, sine);
        c.set(lane, cosine);
    }
}

/// The part of the motion of free tops that is not the common one, in a time in which that turns them by `turn`:
/// the rotation about principal axes, in the world. The frames' axes are in the order of [`split_frame`]; `near`
/// and `far` are the rates about the second and the third beyond the common one, as shares of that.
#[inline(always)]
pub(crate) fn swing(frame: LaneRotation, turn: LaneVec, (near, far): (Lane, Lane)) -> LaneRotation {
    let uneven = not_zero(near);
    let about = |axis: LaneVec, share: Lane| LaneRotation::by(axis.times(turn.dot(axis) * share));
    if !uneven.any() {
        // A symmetric top has no part of its own about the near axis.
        return about(frame.third(), far);
    }
    let (second, third) = (frame.second(), frame.third());
    let splits = splits(turn, (second, near), (third, far));
    let share = Lane::splat(1.0) / splits;
    let (near, split_far) = (near * share, far * share);
    let half = Lane::splat(0.5);
    // Near half, far, near, far ..., near half: halves about one axis that follow each other are one.
    let mut total = about(uneven.select_vec(second, third), uneven.select(near * half, far));
    let most = (0..LANES).fold(1.0, |most, lane| crate::math::max(splits.get(lane), most)) as u32;
    for k in 0..most {
        let goes_on = uneven.and(splits.greater(Lane::splat(k as f32)));
        let step = about(total.after(frame).third(), split_far);
        total = LaneRotation::select(goes_on, step.after(total), total);
        let is_last = splits.less(Lane::splat(k as f32 + 1.5));
        let step = about(total.after(frame).second(), near * is_last.select(half, Lane::splat(1.0)));
        total = LaneRotation::select(goes_on, step.after(total), total);
    }
    total
}

/// `m^-1 v` for a symmetric matrix (diagonal, then xy, xz, yz); 0 where it has none.
pub(crate) fn solve([d, o]: &[LaneVec; 2], v: LaneVec) -> LaneVec {
    let columns = [LaneVec::new(d.x, o.x, o.y), LaneVec::new(o.x, d.y, o.z), LaneVec::new(o.y, o.z, d.z)];
    let [a, b, c] = columns;
    let cofactors = [b.cross(c), c.cross(a), a.cross(b)];
    let determinant = a.dot(cofactors[0]);
    let stands = not_zero(determinant);
    let one = Lane::splat(1.0);
    let inverse = stands.select(one / stands.select(determinant, one), Lane::ZERO);
    LaneVec::new(cofactors[0].dot(v), cofactors[1].dot(v), cofactors[2].dot(v)).times(inverse)
}

/// In how many parts a swing is taken.
fn splits(turn: LaneVec, near: (LaneVec, Lane), far: (LaneVec, Lane)) -> Lane {
    let angle = |(axis, share): (LaneVec, Lane)| {
        let angle = turn.dot(axis) * share;
        angle.greatest(-angle)
    };
    let parts = (angle(near) + angle(far)) * Lane::splat(1.0 / TURN_STEP);
    let mut splits = Lane::splat(1.0);
    if parts.greater(splits).any() {
        for lane in 0..LANES {
            splits.set(lane, libm::ceilf(crate::math::clamp(parts.get(lane), 1.0, SPLITS_MAX)));
        }
    }
    splits
}

/// True where a number is not 0.
#[inline(always)]
fn not_zero(x: Lane) -> Mask {
    (x * x).greater(Lane::ZERO)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Where a free top is after a time.
    fn top(frame: Rotation, momentum: Vec3, inertia: Vec3, time: f32) -> Rotation {
        let (axes, moments) = split_frame(inertia);
        let mut before = LaneRotation { imaginary: LaneVec::ZERO, real: Lane::splat(1.0) };
        let mut turn = LaneVec::ZERO;
        let (mut near, mut far) = (Lane::ZERO, Lane::ZERO);
        before.set(3, frame.after(axes));
        turn.set(3, momentum * (time / moments.x));
        near.set(3, (moments.x - moments.y) / moments.y);
        far.set(3, (moments.x - moments.z) / moments.z);
        let swing = swing(before, turn, (near, far));
        let after = LaneRotation::by(turn).after(swing).after(before).renormalized();
        after.get(3).after(axes.inverse())
    }

    fn energy(frame: Rotation, momentum: Vec3, inertia: Vec3) -> f32 {
        let local = frame.unrotate(momentum);
        0.5 * local.dot(local / inertia)
    }

    #[test]
    fn the_top_keeps_its_energy() {
        let inertia = Vec3::new(0.113_333, 0.346_666, 0.453_333);
        let mut frame = Rotation::IDENTITY;
        let momentum = inertia * Vec3::new(1.0, 10.0, 1.0);
        let start = energy(frame, momentum, inertia);
        for _ in 0..2400 {
            frame = top(frame, momentum, inertia, 1.0 / 240.0);
        }
        let drift = (energy(frame, momentum, inertia) / start - 1.0).abs();
        assert!(drift < 1.0e-4, "{drift}");
    }

    #[test]
    fn a_symmetric_top_precesses_exactly() {
        // I = (1, 1, 2), w = (1, 0, 5): the body axis turns about L at |L| / I1 = 10.0499 rad/s.
        let inertia = Vec3::new(1.0, 1.0, 2.0);
        let momentum = Vec3::new(1.0, 0.0, 10.0);
        let mut frame = Rotation::IDENTITY;
        for _ in 0..600 {
            frame = top(frame, momentum, inertia, 1.0 / 60.0);
        }
        let axis = frame.rotate(Vec3::Z);
        let along = momentum / length(momentum);
        let flat = |v: Vec3| v - along * v.dot(along);
        let (a, b) = (flat(Vec3::Z), flat(axis));
        let angle = crate::math::atan2(a.cross(b).dot(along), a.dot(b));
        let expected = 10.049_876 * 10.0_f32;
        let turns = libm::rintf((expected - angle) / (2.0 * crate::math::PI));
        let error = (angle + turns * 2.0 * crate::math::PI - expected).abs();
        assert!(error < 0.01, "{error}");
    }

    #[test]
    fn a_lane_depends_on_itself_alone() {
        // Nothing, a slow and a fast symmetric top, an uneven one in one part, and one in many with large angles.
        let cases = [(0.0, 0.0, 0.1), (0.0, 0.7, 0.2), (0.0, -0.4, 2.5), (0.3, -0.4, 0.2), (0.2, 0.9, 3.0)];
        let row = |present: &dyn Fn(usize) -> bool| {
            let mut frame = LaneRotation { imaginary: LaneVec::ZERO, real: Lane::splat(1.0) };
            let (mut turn, mut near, mut far) = (LaneVec::ZERO, Lane::ZERO, Lane::ZERO);
            for (lane, &(n, f, size)) in cases.iter().enumerate().filter(|(lane, _)| present(*lane)) {
                let tilt = 0.2 + 0.3 * lane as f32;
                frame.set(lane, Rotation::new(tilt, -0.4, 0.3, 0.7).normalized());
                turn.set(lane, Vec3::new(0.5, -0.7, 0.6) * size);
                near.set(lane, n);
                far.set(lane, f);
            }
            let whole = LaneRotation::by(turn).after(swing(frame, turn, (near, far)));
            (whole.after(frame).renormalized(), whole.vector())
        };
        let (together, vectors) = row(&|_| true);
        for lane in 0..cases.len() {
            let (alone, vector) = row(&|other| other == lane);
            assert_eq!(alone.get(lane), together.get(lane), "{lane}");
            assert_eq!(vector.get(lane), vectors.get(lane), "{lane}");
            assert!((alone.get(lane).norm_squared() - 1.0).abs() < 1.0e-6, "{lane}");
        }
    }

    #[test]
    fn whitening_is_undone_by_the_root() {
        let q = Rotation::new(0.5, -0.1, 0.3, 0.8).normalized();
        let inertia = Vec3::new(1.0, 3.0, 2.5);
        let w = Vec3::new(1.0, -2.0, 3.0);
        for locks in 0..8 {
            let (root, whitened) = root_and_whitened(q, inertia, locks, w);
            let back = root_times(&root, whitened);
            for axis in 0..3 {
                let expected = if locks >> axis & 1 == 1 { 0.0 } else { w[axis] };
                assert!((back[axis] - expected).abs() < 1.0e-5, "{locks} {back}");
            }
        }
    }
}
