//! Closest points of two convex sets that are given by their corners (Gilbert, Johnson, Keerthi 1988).
//!
//! The distance of A and B is the distance of the origin from the Minkowski difference A - B. A simplex of
//! at most four of its corners is moved towards the origin: find the simplex's point `v` nearest to the origin,
//! keep the corners that carry it, add the corner farthest along `-v`, until none is farther.
//!
//! In f32 every case is decided by comparing candidates, not by one sign: a triangle takes the best of its
//! inside and its edges, a flat tetrahedron the best of its faces, so degenerate simplices need no care.
//! Inside of a triangle `v` is a multiple of the triangle's normal: its direction stays exact when the sets
//! nearly touch.
//!
//! Invariants: `|v|` falls from step to step but for a few stalls, so the search ends; ties go to the lowest
//! index.

use crate::math::{Vec3, length, max, sqrt};

/// Most refinements: bounds the time of hulls of many corners seen edge-on, not the result of usual shapes.
const ITERATIONS_MAX: usize = 48;
/// Most refinements that shorten `v` by less than its last bit: they still turn it.
const STALLS_MAX: u32 = 4;
/// By how much, as a fraction, such a refinement may lengthen the square of `v`.
const STALL: f32 = 5.0e-7;
/// The rounding of a distance, as a fraction of the extent. Sets nearer than that count as overlapping.
const ROUNDING: f32 = 2.0e-7;
/// A normal is trusted from this many times the rounding of the distance.
const TRUSTED: f32 = 64.0;
/// A tetrahedron whose height is below this fraction of its edge counts as flat.
const FLAT: f32 = 1.0e-6;

/// Where two sets are closest.
#[derive(Clone, Copy, Debug)]
pub struct Closest {
    /// Point of A.
    pub on_a: Vec3,
    /// Point of B.
    pub on_b: Vec3,
    /// Unit vector from A to B; zero when the sets overlap.
    pub normal: Vec3,
    /// Metres; zero when the sets overlap.
    pub distance: f32,
    /// About the rounding error of the distance, metres.
    pub error: f32,
}

impl Closest {
    /// True when the sets are far enough apart for the normal to mean something. Otherwise take an axis of the
    /// shapes themselves.
    pub fn has_normal(&self) -> bool {
        self.distance > TRUSTED * self.error
    }
}

/// A corner of the Minkowski difference.
#[derive(Clone, Copy, Debug, Default)]
struct Corner {
    point: Vec3,
    a: usize,
    b: usize,
}

/// The corners that carry `v`, with their weights (positive, of sum 1).
#[derive(Clone, Copy, Debug, Default)]
struct Simplex {
    corners: [Corner; 4],
    weights: [f32; 4],
    count: usize,
    v: Vec3,
}

/// Unit direction and length of a vector of any magnitude; `fallback` and 0 when it has no direction.
#[inline]
pub fn unit(v: Vec3, fallback: Vec3) -> (Vec3, f32) {
    let square = v.dot(v);
    if square > 1.0e-24 && square < 1.0e24 {
        let l = sqrt(square);
        return (v / l, l);
    }
    // Scaled first: the square of a small length would be a denormal without digits.
    let scale = max(v.x.abs(), max(v.y.abs(), v.z.abs()));
    if scale > 1.0e-30 && scale < 1.0e30 {
        let scaled = v / scale;
        let l = length(scaled);
        (scaled / l, l * scale)
    } else {
        (fallback, 0.0)
    }
}

/// Index of the corner farthest along `direction` (which need not be unit). 0 when there are none.
#[inline]
pub fn support(corners: &[Vec3], direction: Vec3) -> usize {
    let mut best = 0;
    let mut best_height = f32::NEG_INFINITY;
    for (i, corner) in corners.iter().enumerate() {
        let height = corner.dot(direction);
        if height > best_height {
            (best, best_height) = (i, height);
        }
    }
    best
}

/// Closest points of the convex hulls of two sets of corners in one frame, or `None` when they are certainly
/// farther apart than `limit` metres (or a set is empty). A result may still lie somewhat beyond the limit.
pub fn closest(a: &[Vec3], b: &[Vec3], limit: f32) -> Option<Closest> {
    if a.is_empty() || b.is_empty() {
        return None;
    }
    let mut simplex = Simplex::point(Corner { point: a[0] - b[0], a: 0, b: 0 });
    let mut extent = length(simplex.v);
    let mut stalls = 0;
    for _ in 0..ITERATIONS_MAX {
        let distance = length(simplex.v);
        if distance <= ROUNDING * extent {
            return Some(simplex.overlap(a, b, extent));
        }
        let (ia, ib) = (support(a, -simplex.v), support(b, simplex.v));
        let corner = Corner { point: a[ia] - b[ib], a: ia, b: ib };
        let height = simplex.v.dot(corner.point) / distance;
        if height > limit {
            return None;
        }
        extent = max(extent, length(corner.point));
        // How much nearer the corner is than the simplex. Taken from the difference, the error is that of an
        // angle of some 1e-7 and not that of the distance, whose root would be the angle.
        let step = simplex.corners[0].point - corner.point;
        let gain = simplex.v.dot(step) / distance;
        if simplex.has(&corner) || gain <= ROUNDING * length(step) {
            break;
        }
        let Some(next) = simplex.with(corner).nearest() else { return Some(simplex.overlap(a, b, extent)) };
        if next.v.length_squared() >= simplex.v.length_squared() {
            stalls += 1;
            if stalls > STALLS_MAX || next.v.length_squared() > simplex.v.length_squared() * (1.0 + STALL) {
                break;
            }
        }
        simplex = next;
    }
    Some(simplex.separated(a, b, extent))
}

impl Simplex {
    fn point(corner: Corner) -> Self {
        let mut simplex = Self { count: 1, v: corner.point, ..Self::default() };
        simplex.corners[0] = corner;
        simplex.weights[0] = 1.0;
        simplex
    }

    fn has(&self, corner: &Corner) -> bool {
        self.corners[..self.count].iter().any(|c| c.a == corner.a && c.b == corner.b)
    }

    /// With one more corner; `weights` and `v` are stale until [`Simplex::nearest`].
    fn with(&self, corner: Corner) -> Self {
        let mut simplex = *self;
        simplex.corners[self.count] = corner;
        simplex.count += 1;
        simplex
    }

    /// The face of the simplex that is nearest to the origin; `None` when the origin lies inside.
    fn nearest(&self) -> Option<Self> {
        let [a, b, c, _] = self.corners;
        match self.count {
            1 => Some(Self::point(a)),
            2 => Some(segment(a, b)),
            3 => Some(triangle(a, b, c)),
            _ => tetrahedron(&self.corners),
        }
    }

    fn witnesses(&self, a: &[Vec3], b: &[Vec3]) -> (Vec3, Vec3) {
        let (mut on_a, mut on_b) = (Vec3::ZERO, Vec3::ZERO);
        for (corner, weight) in self.corners[..self.count].iter().zip(self.weights) {
            on_a += a[corner.a] * weight;
            on_b += b[corner.b] * weight;
        }
        (on_a, on_b)
    }

    fn separated(&self, a: &[Vec3], b: &[Vec3], extent: f32) -> Closest {
        let (on_a, on_b) = self.witnesses(a, b);
        let (normal, distance) = unit(-self.v, Vec3::ZERO);
        Closest { on_a, on_b, normal, distance, error: ROUNDING * extent }
    }

    fn overlap(&self, a: &[Vec3], b: &[Vec3], extent: f32) -> Closest {
        let (on_a, on_b) = self.witnesses(a, b);
        Closest { on_a, on_b, normal: Vec3::ZERO, distance: 0.0, error: ROUNDING * extent }
    }
}

/// The nearer of two simplices; the first when they are equal.
fn nearer(a: Simplex, b: Simplex) -> Simplex {
    if b.v.length_squared() < a.v.length_squared() { b } else { a }
}

fn segment(a: Corner, b: Corner) -> Simplex {
    let ab = b.point - a.point;
    let span = ab.length_squared();
    let along = -a.point.dot(ab);
    if along <= 0.0 || span <= 0.0 {
        return Simplex::point(a);
    }
    if along >= span {
        return Simplex::point(b);
    }
    let t = along / span;
    // From the nearer end: less cancellation.
    let v = if t < 0.5 { a.point + ab * t } else { b.point - ab * (1.0 - t) };
    let none = Corner::default();
    Simplex { corners: [a, b, none, none], weights: [1.0 - t, t, 0.0, 0.0], count: 2, v }
}

fn triangle(a: Corner, b: Corner, c: Corner) -> Simplex {
    let (ab, ac) = (b.point - a.point, c.point - a.point);
    let n = ab.cross(ac);
    let area = n.length_squared();
    // Twice the signed areas that the origin's projection makes with each edge, times |n|.
    let wa = n.dot(b.point.cross(c.point - b.point));
    let wb = n.dot(c.point.cross(-ac));
    let wc = n.dot(a.point.cross(ab));
    let sum = wa + wb + wc;
    if wa > 0.0 && wb > 0.0 && wc > 0.0 && area > 0.0 && sum > 0.0 {
        let weights = [wa / sum, wb / sum, wc / sum, 0.0];
        let v = n * (a.point.dot(n) / area);
        let inside = Simplex { corners: [a, b, c, Corner::default()], weights, count: 3, v };
        // A sliver's normal is rounding: then an edge is as near, or `v` is farther than a corner.
        if v.is_finite() && area > FLAT * FLAT * ab.length_squared() * ac.length_squared() {
            return inside;
        }
    }
    nearer(nearer(segment(a, b), segment(b, c)), segment(c, a))
}

fn tetrahedron(corners: &[Corner; 4]) -> Option<Simplex> {
    const FACES: [[usize; 4]; 4] = [[0, 1, 2, 3], [0, 2, 3, 1], [0, 3, 1, 2], [1, 3, 2, 0]];
    let mut best: Option<Simplex> = None;
    for [i, j, k, opposite] in FACES {
        let (a, b, c) = (corners[i], corners[j], corners[k]);
        let n = (b.point - a.point).cross(c.point - a.point);
        let to_opposite = corners[opposite].point - a.point;
        let inner = n.dot(to_opposite);
        let flat = inner * inner <= FLAT * FLAT * n.length_squared() * to_opposite.length_squared();
        let origin = n.dot(-a.point);
        if flat || (origin > 0.0) != (inner > 0.0) {
            let face = triangle(a, b, c);
            best = Some(match best {
                Some(other) => nearer(other, face),
                None => face,
            });
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closest_points_of_simple_sets_are_exact() {
        let square = [
            Vec3::new(-1.0, -1.0, 0.0),
            Vec3::new(1.0, -1.0, 0.0),
            Vec3::new(1.0, 1.0, 0.0),
            Vec3::new(-1.0, 1.0, 0.0),
        ];
        // Over the inside, beside an edge, off a corner.
        for (point, on_a, distance) in [
            (Vec3::new(0.3, -0.2, 1.0e-4), Vec3::new(0.3, -0.2, 0.0), 1.0e-4),
            (Vec3::new(4.0, 0.5, 0.0), Vec3::new(1.0, 0.5, 0.0), 3.0),
            (Vec3::new(4.0, 5.0, 12.0), Vec3::new(1.0, 1.0, 0.0), 13.0),
        ] {
            let c = closest(&square, &[point], 100.0).unwrap();
            assert!((c.distance - distance).abs() < 1.0e-6 * (1.0 + distance), "{c:?}");
            assert!(length(c.on_a - on_a) < 1.0e-5 && length(c.on_b - point) < 1.0e-5, "{c:?}");
            assert!(length(c.normal * distance - (point - on_a)) < 1.0e-5, "{c:?}");
        }
        assert!(closest(&square, &[Vec3::new(4.0, 0.5, 0.0)], 2.9).is_none());
        assert_eq!(closest(&square, &[Vec3::new(0.1, 0.2, 0.0)], 1.0).unwrap().distance, 0.0);
    }

    #[test]
    fn degenerate_sets_terminate_with_finite_results() {
        let same = [Vec3::splat(1.0e-3); 5];
        let line = [Vec3::ZERO, Vec3::X * 0.5, Vec3::X, Vec3::X * 1.0e3];
        for a in [&same[..], &line[..]] {
            for b in [&same[..], &line[..]] {
                let c = closest(a, b, 1.0e9).unwrap();
                assert!(c.on_a.is_finite() && c.on_b.is_finite() && c.normal.is_finite(), "{c:?}");
            }
        }
        let c = closest(&line, &same, 1.0).unwrap();
        assert!((c.distance - 1.414_213_6e-3).abs() < 1.0e-8, "{c:?}");
    }
}
