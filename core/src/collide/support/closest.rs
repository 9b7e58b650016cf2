//! Closest points of two cores by their support functions (Gilbert, Johnson, Keerthi 1988), in f64.
//!
//! The same search as `../distance.rs`, but the sets are known by their farthest points alone, which also curved
//! ones have. On a curved side every corner is a new one; the simplex shrinks onto the closest point, and the
//! search ends when the bound from below meets the distance.

use super::{SupportShape, length};
use glam::DVec3;

/// Most refinements: curved sides take about 20, to the last digit.
const ITERATIONS_MAX: usize = 64;
/// The search ends when a corner is nearer than the simplex by a smaller fraction of the extent: the normal is then
/// good to the root of it.
const GAIN: f64 = 1.0e-14;
/// Sets nearer than this fraction of their extent count as overlapping.
const TOUCHING: f64 = 1.0e-11;
/// A tetrahedron whose height is below this fraction of its edge counts as flat.
const FLAT: f64 = 1.0e-12;

/// Where two cores are closest.
#[derive(Clone, Copy, Debug)]
pub(super) struct Near {
    pub on_a: DVec3,
    pub on_b: DVec3,
    /// Unit vector from A to B.
    pub normal: DVec3,
    /// Metres; negative for a depth.
    pub apart: f64,
    /// False when the cores overlap; then nothing else is meant.
    pub is_apart: bool,
}

/// Two shapes, changed for a search.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pair<'a> {
    pub a: &'a SupportShape<'a>,
    pub b: &'a SupportShape<'a>,
    /// Both cores are taken smaller by this factor, about their centers.
    pub scale: f64,
    /// B is taken here, from where it is.
    pub shift: DVec3,
    /// Sizes of both.
    pub sizes: [f64; 2],
}

/// A corner of the Minkowski difference A - B.
#[derive(Clone, Copy, Debug, Default)]
struct Corner {
    point: DVec3,
    a: DVec3,
    b: DVec3,
}

/// The corners that carry `v`, with their weights (of sum 1).
#[derive(Clone, Copy, Debug, Default)]
struct Simplex {
    corners: [Corner; 4],
    weights: [f64; 4],
    count: usize,
    v: DVec3,
}

impl<'a> Pair<'a> {
    pub fn new(a: &'a SupportShape<'a>, b: &'a SupportShape<'a>) -> Self {
        Self { a, b, scale: 1.0, shift: DVec3::ZERO, sizes: [a.size(), b.size()] }
    }

    /// The size of the smaller shape, metres.
    pub fn lesser_size(&self) -> f64 {
        if self.sizes[0] < self.sizes[1] { self.sizes[0] } else { self.sizes[1] }
    }

    /// About the extent of both, metres.
    pub fn extent(&self) -> f64 {
        self.sizes[0] + self.sizes[1]
    }

    /// Distance of the cores along the unit vector `n` from A to B; at most their distance.
    pub fn apart_along(&self, n: DVec3) -> f64 {
        (self.b.support(-n) - self.a.support(n)).dot(n)
    }

    fn corner(&self, direction: DVec3) -> Corner {
        let (mut a, mut b) = (self.a.support(direction), self.b.support(-direction));
        if self.scale < 1.0 {
            let (ca, cb) = (self.a.center(), self.b.center());
            (a, b) = (ca + (a - ca) * self.scale, cb + (b - cb) * self.scale);
        }
        let b = b + self.shift;
        Corner { point: a - b, a, b }
    }

    /// Closest points; `None` when the cores are certainly farther apart than `limit` metres.
    pub fn closest(&self, limit: f64) -> Option<Near> {
        let first = self.a.center() - self.b.center() - self.shift;
        let start = if first.dot(first) > 0.0 { -first } else { DVec3::X };
        let mut simplex = Simplex::point(self.corner(start));
        let extent = self.extent();
        for _ in 0..ITERATIONS_MAX {
            let distance = length(simplex.v);
            if distance <= TOUCHING * extent {
                return Some(Near::overlapping());
            }
            let corner = self.corner(-simplex.v);
            if simplex.v.dot(corner.point) > limit * distance {
                return None;
            }
            let gain = simplex.v.dot(simplex.v - corner.point) / distance;
            if gain <= GAIN * extent {
                break;
            }
            let Some(next) = simplex.with(corner).nearest() else { return Some(Near::overlapping()) };
            if next.v.dot(next.v) >= simplex.v.dot(simplex.v) {
                break;
            }
            simplex = next;
        }
        Some(simplex.near())
    }
}

impl Near {
    fn overlapping() -> Self {
        let (on_a, on_b) = (DVec3::ZERO, DVec3::ZERO);
        Self { on_a, on_b, normal: DVec3::Z, apart: 0.0, is_apart: false }
    }
}

impl Simplex {
    fn point(corner: Corner) -> Self {
        let none = Corner::default();
        Self { corners: [corner, none, none, none], weights: [1.0, 0.0, 0.0, 0.0], count: 1, v: corner.point }
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

    fn near(&self) -> Near {
        let (mut on_a, mut on_b) = (DVec3::ZERO, DVec3::ZERO);
        for (corner, &weight) in self.corners[..self.count].iter().zip(&self.weights) {
            on_a += corner.a * weight;
            on_b += corner.b * weight;
        }
        let apart = length(self.v);
        Near { on_a, on_b, normal: -self.v / apart, apart, is_apart: true }
    }
}

/// The nearer of two simplices; the first when they are equal.
fn nearer(a: Simplex, b: Simplex) -> Simplex {
    if b.v.dot(b.v) < a.v.dot(a.v) { b } else { a }
}

fn segment(a: Corner, b: Corner) -> Simplex {
    let ab = b.point - a.point;
    let span = ab.dot(ab);
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
    let area = n.dot(n);
    // Twice the signed areas that the origin's projection makes with each edge, times |n|.
    let wa = n.dot(b.point.cross(c.point - b.point));
    let wb = n.dot(c.point.cross(-ac));
    let wc = n.dot(a.point.cross(ab));
    let sum = wa + wb + wc;
    // A sliver's normal is rounding: then an edge is as near.
    let has_area = area > FLAT * FLAT * ab.dot(ab) * ac.dot(ac);
    if wa > 0.0 && wb > 0.0 && wc > 0.0 && sum > 0.0 && has_area {
        let weights = [wa / sum, wb / sum, wc / sum, 0.0];
        let v = n * (a.point.dot(n) / area);
        return Simplex { corners: [a, b, c, Corner::default()], weights, count: 3, v };
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
        let flat = inner * inner <= FLAT * FLAT * n.dot(n) * to_opposite.dot(to_opposite);
        let origin = n.dot(-a.point);
        if flat || (origin > 0.0) != (inner > 0.0) {
            let face = triangle(a, b, c);
            best = Some(best.map_or(face, |other| nearer(other, face)));
        }
    }
    best
}
