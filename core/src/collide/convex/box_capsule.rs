//! A box against a capsule: the closest points of the box and the capsule's core, without a search over corners.
//!
//! The squared distance of the box from the point at `t` of the segment is convex and piecewise quadratic: its
//! derivative rises, and is a line as long as the same coordinates are outside of the box. Newton's method is
//! exact on the last of these lines; a bracket keeps it from going round.

use super::round::{self, ALONG, FACE_COSINE, Over, SLACK, Segment};
use crate::collide::distance::{Closest, unit};
use crate::collide::polytope::BoxHull;
use crate::collide::{Manifold, Plane};
use crate::math::{Vec3, clamp, length, max, min};

/// Most steps: Newton takes two or three; where a line is short, halving the bracket finds it.
const STEPS_MAX: usize = 32;
/// The rounding of a distance, as a fraction of the coordinates.
const ROUNDING: f32 = 2.0e-7;

/// Contacts of a box (A) with a capsule.
pub fn collide(half: Vec3, b: &Segment, distance: f32) -> Option<Manifold> {
    let reach = distance + b.radius;
    for i in 0..3 {
        let (low, high) = (min(b.tail[i], b.head[i]), max(b.tail[i], b.head[i]));
        if low > half[i] + reach || high < -half[i] - reach {
            return None;
        }
    }
    let near = closest(half, b);
    if near.distance > reach {
        return None;
    }
    if !near.has_normal() {
        return round::hull_capsule_near(&BoxHull::new(half).hull(), b, &near, distance);
    }
    round::touch(
        b,
        &near,
        distance,
        || along_face(half, b, &near, distance),
        || along_edge(half, b, &near, distance),
    )
}

/// Two contacts when the closest points have a face's normal and the segment lies over that face.
fn along_face(half: Vec3, b: &Segment, near: &Closest, distance: f32) -> Option<Manifold> {
    let (n, half) = (near.normal.to_array(), half.to_array());
    let i = (0..3).find(|&i| n[i].abs() >= FACE_COSINE)?;
    let (tail, head) = (b.tail.to_array(), b.head.to_array());
    let mut over = Over::ALL;
    for j in [(i + 1) % 3, (i + 2) % 3] {
        let edge = half[j] + SLACK * b.radius;
        over = over.cut(tail[j] - edge, head[j] - edge)?.cut(-tail[j] - edge, -head[j] - edge)?;
    }
    let normal = if n[i] < 0.0 { -Vec3::AXES[i] } else { Vec3::AXES[i] };
    over.contacts(b, &Plane { normal, offset: half[i] }, distance)
}

/// Two contacts when the segment lies along an edge that is farthest along the normal.
fn along_edge(half: Vec3, b: &Segment, near: &Closest, distance: f32) -> Option<Manifold> {
    // The edges have three directions: seldom is the segment's one of them.
    let cosine = (1.0 - 2.0 * ALONG) * b.axis.length_squared();
    let runs_along = b.axis.to_array().iter().any(|x| x * x > cosine);
    if runs_along { round::along_edge(&BoxHull::new(half).hull(), b, near, distance) } else { None }
}

/// The point of the box nearest to a point.
fn inside(half: Vec3, x: Vec3) -> Vec3 {
    Vec3::new(clamp(x.x, -half.x, half.x), clamp(x.y, -half.y, half.y), clamp(x.z, -half.z, half.z))
}

/// Half the derivative of the squared distance at `x` along `way`, and half of its own derivative.
fn slopes(half: Vec3, x: Vec3, way: Vec3) -> (f32, f32) {
    let off = x - inside(half, x);
    let outside = |off: f32, way: f32| if off != 0.0 { way * way } else { 0.0 };
    (off.dot(way), outside(off.x, way.x) + outside(off.y, way.y) + outside(off.z, way.z))
}

/// The parameter of the segment's point that is nearest to the box; where many are, one of them.
fn nearest(half: Vec3, b: &Segment) -> f32 {
    let way = b.head - b.tail;
    let (at_tail, at_head) = (slopes(half, b.tail, way).0, slopes(half, b.head, way).0);
    if at_tail >= 0.0 {
        return 0.0;
    }
    if at_head <= 0.0 {
        return 1.0;
    }
    let (mut low, mut high) = (0.0, 1.0);
    let mut t = 0.5;
    for _ in 0..STEPS_MAX {
        let (slope, rise) = slopes(half, b.tail + way * t, way);
        if slope == 0.0 {
            break;
        }
        if slope < 0.0 {
            low = t;
        } else {
            high = t;
        }
        let next = t - slope / rise;
        // The comparison is false for what is no number.
        let next = if next > low && next < high { next } else { 0.5 * (low + high) };
        if (next - t).abs() <= ROUNDING {
            return next;
        }
        t = next;
    }
    t
}

/// Closest points of a box and the core of a capsule.
fn closest(half: Vec3, b: &Segment) -> Closest {
    let on_b = b.tail + (b.head - b.tail) * nearest(half, b);
    let on_a = inside(half, on_b);
    let (normal, distance) = unit(on_b - on_a, Vec3::ZERO);
    Closest { on_a, on_b, normal, distance, error: ROUNDING * (length(on_b) + length(b.head - b.tail)) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::collide::distance;
    use crate::math::{Pose, Rotation, sqrt};

    /// Numbers of an LCG in -1..=1.
    fn numbers() -> impl FnMut() -> f32 {
        let mut state = 7_u64;
        move || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            ((state >> 40) as f32 / (1_u64 << 23) as f32) - 1.0
        }
    }

    #[test]
    fn the_search_over_corners_finds_the_same() {
        let mut number = numbers();
        let (mut apart, mut crossing) = (0, 0);
        for round in 0..20_000 {
            let half = Vec3::new(0.05 + number().abs(), 0.05 + number().abs(), 0.05 + number().abs());
            let spread = if round % 2 == 0 { 1.5 } else { 3.0 };
            let center = Vec3::new(number(), number(), number()) * spread;
            let axis = Rotation::new(number(), number(), number(), number()).normalized();
            // Many lie along an axis of the box, where the derivative is flat.
            let axis = if round % 5 == 0 { Rotation::IDENTITY } else { axis };
            let b = Segment::new(0.02 + number().abs(), 0.1, &Pose::new(center, axis));
            let found = closest(half, &b);
            let hull = BoxHull::new(half);
            let expected = distance::closest(hull.hull().vertices, &[b.tail, b.head], 100.0).expect("near");
            assert!((found.distance - expected.distance).abs() < 2.0e-6, "{round}: {found:?} {expected:?}");
            let witness = found.on_b - found.on_a;
            assert!((sqrt(witness.dot(witness)) - found.distance).abs() < 1.0e-6);
            if expected.has_normal() && expected.distance > 1.0e-3 {
                assert!(found.has_normal());
                assert!(
                    (found.normal - expected.normal).length() < 2.0e-3,
                    "{round}: {found:?} {expected:?}"
                );
                apart += 1;
            } else {
                crossing += 1;
            }
        }
        assert!(apart > 10_000 && crossing > 1000, "{apart}, {crossing}");
    }
}
