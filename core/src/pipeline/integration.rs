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

use crate::math::{Rotation, Vec3, length};

/// Largest rotation of one split, radians; more is done in several.
pub(crate) const TURN_STEP: f32 = 0.3;

/// W v for a symmetric W (xx, yy, zz, xy, xz, yz).
#[inline(always)]
pub(crate) fn root_times(w: &[f32; 6], v: Vec3) -> Vec3 {
    Vec3::new(
        w[0] * v.x + w[3] * v.y + w[4] * v.z,
        w[3] * v.x + w[1] * v.y + w[5] * v.z,
        w[4] * v.x + w[5] * v.y + w[2] * v.z,
    )
}

/// The symmetric W with W W = inverse inertia in the world, for a principal frame and its moments.
pub(crate) fn root_of(principal: Rotation, inertia: Vec3) -> [f32; 6] {
    let s = |moment: f32| 1.0 / crate::math::sqrt(moment);
    if inertia.x == inertia.y && inertia.y == inertia.z {
        let s = s(inertia.x);
        return [s, s, s, 0.0, 0.0, 0.0];
    }
    let m = principal.matrix();
    let (a, b, c) = (m.x_axis, m.y_axis, m.z_axis);
    let (sa, sb, sc) = (s(inertia.x), s(inertia.y), s(inertia.z));
    let entry = |i: usize, j: usize| sa * a[i] * a[j] + sb * b[i] * b[j] + sc * c[i] * c[j];
    [entry(0, 0), entry(1, 1), entry(2, 2), entry(0, 1), entry(0, 2), entry(1, 2)]
}

/// The same with some world axes locked: W W = inverse of the inertia among the free axes, 0 elsewhere.
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

/// [`root_of`] when no axis is locked against turning, else [`locked_root_of`].
pub(crate) fn locked_or_free_root(principal: Rotation, inertia: Vec3, turn_locks: u8) -> [f32; 6] {
    if turn_locks == 0 { root_of(principal, inertia) } else { locked_root_of(principal, inertia, turn_locks) }
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
    if a2 < 0.5 {
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

/// The principal frame of a free top after `time` seconds. `momentum` is in the world and stays.
pub(crate) fn top(principal: Rotation, momentum: Vec3, inertia: Vec3, time: f32) -> Rotation {
    let mut local = principal.unrotate(momentum);
    let (reference, near, far) = split_axes(inertia);
    let rate = |axis: usize| 1.0 / inertia[axis] - 1.0 / inertia[reference];
    let swing = (local[near] * rate(near)).abs() + (local[far] * rate(far)).abs();
    let splits = libm::ceilf(crate::math::clamp(swing * time / TURN_STEP, 1.0, 256.0));
    let h = time / splits;
    let mut frame = principal;
    for _ in 0..splits as u32 {
        // A symmetric top has no part of its own about the near axis.
        let symmetric = inertia[near] == inertia[reference];
        if !symmetric {
            about_axis(&mut frame, &mut local, (near, 0.5 * h * rate(near)));
        }
        about_axis(&mut frame, &mut local, (far, h * rate(far)));
        if !symmetric {
            about_axis(&mut frame, &mut local, (near, 0.5 * h * rate(near)));
        }
    }
    // The common part: a rotation about the momentum, which stays in the world.
    turned(frame, momentum * (time / inertia[reference]))
}

/// Reference axis, the axis whose moment is nearest to it, and the third.
fn split_axes(i: Vec3) -> (usize, usize, usize) {
    // Nearness of two axes is the difference of their rates.
    let difference = |a: usize, b: usize| (1.0 / i[a] - 1.0 / i[b]).abs();
    let (xy, yz, zx) = (difference(0, 1), difference(1, 2), difference(2, 0));
    if xy <= yz && xy <= zx {
        (0, 1, 2)
    } else if yz <= zx {
        (1, 2, 0)
    } else {
        (2, 0, 1)
    }
}

/// Turns the frame about one of its own axes by `local[axis] * rate`, with the momentum fixed in the world.
fn about_axis(frame: &mut Rotation, local: &mut Vec3, (axis, rate): (usize, f32)) {
    let angle = local[axis] * rate;
    let (s, c) = half_angle(angle * angle);
    let s = s * angle;
    let mut q = [0.0; 3];
    q[axis] = s;
    *frame = frame.after(Rotation::new(q[0], q[1], q[2], c)).renormalized();
    // The momentum turns the other way in the frame: double angle of (c, s).
    let (sine, cosine) = (2.0 * s * c, 1.0 - 2.0 * s * s);
    let (i, j) = ((axis + 1) % 3, (axis + 2) % 3);
    let (p, q) = (local[i], local[j]);
    local[i] = p * cosine + q * sine;
    local[j] = q * cosine - p * sine;
}

#[cfg(test)]
mod tests {
    use super::*;

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
    fn whitening_is_undone_by_the_root() {
        let q = Rotation::new(0.5, -0.1, 0.3, 0.8).normalized();
        let inertia = Vec3::new(1.0, 3.0, 2.5);
        let w = Vec3::new(1.0, -2.0, 3.0);
        for locks in 0..8 {
            let root = if locks == 0 { root_of(q, inertia) } else { locked_root_of(q, inertia, locks) };
            let back = root_times(&root, whiten(&root, w));
            for axis in 0..3 {
                let expected = if locks >> axis & 1 == 1 { 0.0 } else { w[axis] };
                assert!((back[axis] - expected).abs() < 1.0e-5, "{locks} {back}");
            }
        }
    }
}
