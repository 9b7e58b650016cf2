//! Closest points of two cores by their support functions (Gilbert, Johnson, Keerthi 1988), in f64.
//!
//! The same search as `../distance.rs`, but the sets are known by their farthest points alone, which also curved
//! ones have. On a curved side every corner is a new one; the simplex shrinks onto the closest point, and the
//! search ends when the bound from below meets the distance.

use super::{SupportShape, length};
use glam::DVec3;

/// Most refinements: curved sides take about 15.
const ITERATIONS_MAX: usize = 64;
/// The rounding of the search, as a fraction of the extent.
const ROUNDING: f64 = 4.0e-16;
/// A tetrahedron whose height is below this fraction of its edge counts as flat.
const FLAT: f64 = 1.0e-12;

/// How well the closest points must be known.
#[derive(Clone, Copy, Debug)]
pub(super) struct Aim {
    /// Beyond this the cores do not matter, metres.
    pub limit: f64,
    /// Nearer than this they count as overlapping, metres.
    pub touching: f64,
    /// Square of the angle by which the normal may be off.
    pub angle_squared: f64,
}

/// Where two cores are closest.
#[derive(Clone, Copy, Debug)]
pub(super) struct Near {
    pub on_a: DVec3,
    pub on_b: DVec3,
    /// Unit vector from A to B.
    pub normal: DVec3,
    /// Metres; negative for a depth.
    pub apart: f64,
    /// False when the cores overlap or touch, from [`Pair::closest`]: then nothing else is meant.
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
#[derive(Clone, Copy, Debug)]
struct Simplex {
    corners: [Corner; 4],
    count: usize,
    face: Face,
}

/// The part of a simplex that is nearest to the origin: some of its corners, and their weights.
#[derive(Clone, Copy, Debug)]
struct Face {
    corners: [usize; 3],
    weights: [f64; 3],
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

    /// Closest points; `None` when the cores are certainly farther apart than the limit. `start` is about the
    /// direction from A to B.
    pub fn closest(&self, start: DVec3, aim: &Aim) -> Option<Near> {
        let start = if start.dot(start) > 0.0 { start } else { DVec3::X };
        let first = self.corner(start);
        let mut simplex = Simplex { corners: [first; 4], count: 1, face: Face::point(&[first; 4], 0) };
        let extent = self.extent();
        let touching = if aim.touching > ROUNDING * extent { aim.touching } else { ROUNDING * extent };
        for _ in 0..ITERATIONS_MAX {
            let v = simplex.face.v;
            let distance = length(v);
            if distance <= touching {
                return Some(Near::overlapping());
            }
            let corner = self.corner(-v);
            if v.dot(corner.point) > aim.limit * distance {
                return None;
            }
            // The square of the error of `v` is at most this gain times the distance. Its rounding is that of the
            // direction of `v`, over the extent.
            let gain = v.dot(v - corner.point) / distance;
            if gain <= aim.angle_squared * distance + ROUNDING * extent * (extent / distance) {
                break;
            }
            simplex.push(corner);
            let Some(face) = simplex.nearest() else { return Some(Near::overlapping()) };
            if face.v.dot(face.v) >= v.dot(v) {
                simplex.count -= 1;
                break;
            }
            simplex.keep(face);
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
    fn push(&mut self, corner: Corner) {
        self.corners[self.count] = corner;
        self.count += 1;
    }

    /// Leaves only the corners of a face.
    fn keep(&mut self, face: Face) {
        let [a, b, c] = face.corners.map(|i| self.corners[i]);
        (self.corners[0], self.corners[1], self.corners[2]) = (a, b, c);
        (self.count, self.face) = (face.count, Face { corners: [0, 1, 2], ..face });
    }

    /// The face that is nearest to the origin; `None` when the origin lies inside.
    fn nearest(&self) -> Option<Face> {
        match self.count {
            1 => Some(Face::point(&self.corners, 0)),
            2 => Some(segment(&self.corners, 0, 1)),
            3 => Some(triangle(&self.corners, [0, 1, 2])),
            _ => tetrahedron(&self.corners),
        }
    }

    fn near(&self) -> Near {
        let (mut on_a, mut on_b) = (DVec3::ZERO, DVec3::ZERO);
        for i in 0..self.face.count {
            let (corner, weight) = (&self.corners[self.face.corners[i]], self.face.weights[i]);
            on_a += corner.a * weight;
            on_b += corner.b * weight;
        }
        let apart = length(self.face.v);
        Near { on_a, on_b, normal: -self.face.v / apart, apart, is_apart: true }
    }
}

impl Face {
    fn point(corners: &[Corner; 4], i: usize) -> Self {
        Self { corners: [i; 3], weights: [1.0, 0.0, 0.0], count: 1, v: corners[i].point }
    }

    /// The nearer of two; the first when they are equal.
    fn nearer(self, other: Self) -> Self {
        if other.v.dot(other.v) < self.v.dot(self.v) { other } else { self }
    }
}

fn segment(corners: &[Corner; 4], i: usize, j: usize) -> Face {
    let (a, b) = (corners[i].point, corners[j].point);
    let ab = b - a;
    let span = ab.dot(ab);
    let along = -a.dot(ab);
    if along <= 0.0 || span <= 0.0 {
        return Face::point(corners, i);
    }
    if along >= span {
        return Face::point(corners, j);
    }
    let t = along / span;
    // From the nearer end: less cancellation.
    let v = if t < 0.5 { a + ab * t } else { b - ab * (1.0 - t) };
    Face { corners: [i, j, j], weights: [1.0 - t, t, 0.0], count: 2, v }
}

fn triangle(corners: &[Corner; 4], [i, j, k]: [usize; 3]) -> Face {
    let [a, b, c] = [i, j, k].map(|i| corners[i].point);
    let (ab, ac) = (b - a, c - a);
    let n = ab.cross(ac);
    let area = n.dot(n);
    // Twice the signed areas that the origin's projection makes with each edge, times |n|.
    let wa = n.dot(b.cross(c - b));
    let wb = n.dot(c.cross(-ac));
    let wc = n.dot(a.cross(ab));
    // A sliver's normal is rounding: then an edge is as near.
    let has_area = area > FLAT * FLAT * ab.dot(ab) * ac.dot(ac);
    if wa > 0.0 && wb > 0.0 && wc > 0.0 && has_area {
        let sum = wa + wb + wc;
        let weights = [wa / sum, wb / sum, wc / sum];
        return Face { corners: [i, j, k], weights, count: 3, v: n * (a.dot(n) / area) };
    }
    // Only edges beyond which the origin lies can be nearest.
    let mut best: Option<Face> = None;
    for (weight, (p, q)) in [(wa, (j, k)), (wb, (k, i)), (wc, (i, j))] {
        if weight <= 0.0 || !has_area {
            let edge = segment(corners, p, q);
            best = Some(best.map_or(edge, |other| other.nearer(edge)));
        }
    }
    // A weight that is no number leaves no edge.
    best.unwrap_or_else(|| segment(corners, i, j))
}

fn tetrahedron(corners: &[Corner; 4]) -> Option<Face> {
    const FACES: [[usize; 4]; 4] = [[0, 1, 2, 3], [0, 2, 3, 1], [0, 3, 1, 2], [1, 3, 2, 0]];
    let mut best: Option<Face> = None;
    for [i, j, k, opposite] in FACES {
        let a = corners[i].point;
        let n = (corners[j].point - a).cross(corners[k].point - a);
        let to_opposite = corners[opposite].point - a;
        let inner = n.dot(to_opposite);
        let flat = inner * inner <= FLAT * FLAT * n.dot(n) * to_opposite.dot(to_opposite);
        let origin = n.dot(-a);
        if flat || (origin > 0.0) != (inner > 0.0) {
            let face = triangle(corners, [i, j, k]);
            best = Some(best.map_or(face, |other| other.nearer(face)));
        }
    }
    best
}
