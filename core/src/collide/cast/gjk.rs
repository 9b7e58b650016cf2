//! Distance of two convex sets that are given by their support functions (Gilbert, Johnson, Keerthi 1988), in
//! double precision.
//!
//! The method is that of `distance.rs`, which works on corners in f32 for contacts: a simplex of the Minkowski
//! difference A - B moves towards the origin, and every case is decided by comparing candidates, so that flat
//! simplices need no care. Here the sets may be curved, and the search also tells a *lower* bound of the distance
//! and the direction that proves it: what a shape cast steps by.

use super::frame::{Frame, length};
use super::support::Core;
use glam::DVec3;

/// Most refinements: polytopes take a few, curved sets gain a digit with each two or three.
const ITERATIONS_MAX: usize = 64;
/// The distance is found when its bounds differ by this fraction.
const CONVERGED: f64 = 1.0e-11;
/// Sets nearer than this fraction of their coordinates count as overlapping: rounding.
const ROUNDING: f64 = 1.0e-14;
/// A triangle or tetrahedron whose height is below this fraction of its edge counts as flat.
const FLAT: f64 = 1.0e-12;
/// As does a tetrahedron whose height is below this fraction of its coordinates.
const NOISE: f64 = 1.0e-14;

/// A point of the Minkowski difference.
#[derive(Clone, Copy, Debug, Default)]
struct Corner {
    /// A's point minus B's.
    point: DVec3,
    /// A's point.
    on_a: DVec3,
}

/// At most four corners; those that carry the point nearest to the origin, with their weights.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Simplex {
    corners: [Corner; 4],
    weights: [f64; 4],
    count: usize,
    /// The nearest point.
    v: DVec3,
}

/// How two cores lie. Vectors are in A's frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Separation {
    /// Distance of the cores, metres; zero when they overlap.
    pub distance: f64,
    /// Certainly not more than the distance, metres.
    pub least: f64,
    /// Unit vector from B to A that proves `least`; zero when they overlap.
    pub direction: DVec3,
    /// The point of A's core that is nearest to B.
    pub on_a: DVec3,
}

/// Two cores: A in its own frame, B at a pose in it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pair<'a> {
    pub a: &'a Core<'a>,
    pub b: &'a Core<'a>,
    pub b_in_a: Frame,
}

impl Pair<'_> {
    fn corner(&self, direction: DVec3) -> Corner {
        let on_a = self.a.support(direction);
        let on_b = self.b_in_a.transform(self.b.support(self.b_in_a.unturn(-direction)));
        Corner { point: on_a - on_b, on_a }
    }

    /// A simplex to start from.
    pub fn start(&self) -> Simplex {
        Simplex::point(self.corner(self.b_in_a.position))
    }

    /// Moves B, and a simplex with it.
    pub fn shift(&mut self, by: DVec3, simplex: &mut Simplex) {
        self.b_in_a.position += by;
        for corner in &mut simplex.corners {
            corner.point -= by;
        }
        if let Some(nearest) = simplex.nearest() {
            *simplex = nearest;
        } else {
            // The origin lies inside. Any corner serves to begin with.
            *simplex = Simplex::point(simplex.corners[0]);
        }
    }

    /// Distance of the cores, and the simplex that tells it.
    pub fn separation(&self, simplex: &mut Simplex) -> Separation {
        let mut extent = 0.0;
        for corner in &simplex.corners[..simplex.count] {
            extent = greater(extent, length(corner.on_a) + length(corner.point));
        }
        let mut found = simplex.overlap();
        for _ in 0..ITERATIONS_MAX {
            let distance = length(simplex.v);
            if distance <= ROUNDING * extent {
                return simplex.overlap();
            }
            let direction = simplex.v / distance;
            let corner = self.corner(-direction);
            extent = greater(extent, length(corner.on_a) + length(corner.point));
            // From the difference of corners: its rounding is that of the direction, not of the coordinates.
            let gain = direction.dot(simplex.corners[0].point - corner.point);
            found = Separation { distance, least: distance - gain, direction, on_a: simplex.on_a() };
            if gain <= CONVERGED * distance || gain <= ROUNDING * extent || simplex.has(&corner) {
                break;
            }
            let Some(next) = simplex.with(corner).nearest() else { return simplex.overlap() };
            if next.v.dot(next.v) >= simplex.v.dot(simplex.v) {
                break;
            }
            *simplex = next;
        }
        found
    }
}

fn greater(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

impl Simplex {
    fn point(corner: Corner) -> Self {
        let mut simplex = Self { count: 1, v: corner.point, ..Self::default() };
        simplex.corners[0] = corner;
        simplex.weights[0] = 1.0;
        simplex
    }

    fn has(&self, corner: &Corner) -> bool {
        self.corners[..self.count].iter().any(|own| own.point == corner.point)
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
            0 | 1 => Some(Self::point(a)),
            2 => Some(segment(a, b)),
            3 => Some(triangle(a, b, c)),
            _ => tetrahedron(&self.corners),
        }
    }

    fn on_a(&self) -> DVec3 {
        let mut sum = DVec3::ZERO;
        for (corner, weight) in self.corners[..self.count].iter().zip(self.weights) {
            sum += corner.on_a * weight;
        }
        sum
    }

    fn overlap(&self) -> Separation {
        Separation { distance: 0.0, least: 0.0, direction: DVec3::ZERO, on_a: self.on_a() }
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
    // From the corner across the longest edge: on curved sides triangles become slivers, and the product of their
    // two long edges would be rounding.
    let square = |from: &Corner, to: &Corner| (to.point - from.point).dot(to.point - from.point);
    let (of_a, of_b, of_c) = (square(&b, &c), square(&c, &a), square(&a, &b));
    let [a, b, c] = if of_a >= of_b && of_a >= of_c {
        [a, b, c]
    } else if of_b >= of_c {
        [b, c, a]
    } else {
        [c, a, b]
    };
    let (ab, ac) = (b.point - a.point, c.point - a.point);
    let n = ab.cross(ac);
    let area = n.dot(n);
    // Twice the signed areas that the origin's projection makes with each edge, times |n|.
    let wa = n.dot(b.point.cross(c.point - b.point));
    let wb = n.dot(c.point.cross(-ac));
    let wc = n.dot(a.point.cross(ab));
    let sum = wa + wb + wc;
    if wa > 0.0 && wb > 0.0 && wc > 0.0 && sum > 0.0 && area > FLAT * FLAT * ab.dot(ab) * ac.dot(ac) {
        let weights = [wa / sum, wb / sum, wc / sum, 0.0];
        // A multiple of the normal: its direction stays exact when the sets nearly touch.
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
        // Corners on curved sides come close together: then the rounding of the points they are the differences of
        // counts, and a sign means nothing.
        let noise = NOISE * (length(a.on_a) + length(a.point)) + FLAT * length(to_opposite);
        let flat = inner.abs() <= noise * length(n);
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
    use crate::collide::Solid;
    use crate::math::{Rotation, Vec3};

    fn separation(a: &Solid<'_>, b: &Solid<'_>, at: DVec3, rotation: Rotation) -> Separation {
        let (a, b) = (Core::new(a).unwrap(), Core::new(b).unwrap());
        let pair = Pair { a: &a, b: &b, b_in_a: Frame::new(at, rotation) };
        pair.separation(&mut pair.start())
    }

    #[test]
    fn distances_of_boxes_are_exact_from_millimetres_to_kilometres() {
        for size in [1.0e-3_f32, 1.0, 1.0e3] {
            let cube = Solid::Box { half_extents: Vec3::splat(size) };
            let s = f64::from(size);
            // Face to face, edge to edge, corner to corner, and nearly touching.
            for (at, distance) in [
                (DVec3::new(2.5, 0.3, -0.2), 0.5),
                (DVec3::new(2.3, 2.4, 0.0), 0.5),
                (DVec3::new(2.0 + 2.0e-9, 0.0, 0.0), 2.0e-9),
                (DVec3::new(3.0, 4.0, 4.0), 3.0),
            ] {
                let found = separation(&cube, &cube, at * s, Rotation::IDENTITY);
                assert!((found.distance - distance * s).abs() < 1.0e-14 * s, "{at}: {found:?}");
                assert!((found.least - found.distance).abs() < 1.0e-12 * s, "{at}: {found:?}");
            }
            let inside = separation(&cube, &cube, DVec3::new(0.1, 1.9, 0.3) * s, Rotation::IDENTITY);
            assert_eq!(inside.distance, 0.0);
        }
    }

    #[test]
    fn the_least_distance_is_proved_by_its_direction() {
        let plank = Solid::Box { half_extents: Vec3::new(2.0, 0.3, 0.01) };
        let pin = Solid::Capsule { half_height: 1.5, radius: 0.1 };
        for i in 0..200 {
            let f = f64::from(i);
            let turn = Rotation::from_rotation_vector(Vec3::new(0.1 * i as f32, 1.0, -0.03 * i as f32));
            let at = DVec3::new(libm::sin(f) * 3.0, libm::cos(1.7 * f) * 2.0, libm::sin(0.3 * f) * 2.0);
            let found = separation(&plank, &pin, at, turn);
            if found.distance > 0.0 {
                let (a, b) = (Core::new(&plank).unwrap(), Core::new(&pin).unwrap());
                let frame = Frame::new(at, turn);
                let low_a = a.support(-found.direction).dot(found.direction);
                let high_b = frame.transform(b.support(frame.unturn(found.direction))).dot(found.direction);
                assert!((low_a - high_b - found.least).abs() < 1.0e-12, "{found:?}");
                assert!(found.distance - found.least < 1.0e-10, "{found:?}");
            }
        }
    }
}
