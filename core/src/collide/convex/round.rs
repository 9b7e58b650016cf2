//! Spheres and capsules: a point or a segment with a radius, against each other and against hulls.
//!
//! The cores are compared first: their closest points give the normal, and the radii are taken off the distance.
//! A segment along a face, an edge or another segment touches with two points, the ends of their overlap. Only
//! when a core is inside of a hull is the axis of least depth used: a continuation of the same normals.
//!
//! Legend: `x` a point of B's core, `n` the normal from A to B, `s` a parameter along a segment.

use crate::collide::clip::{face_loop, single};
use crate::collide::distance::{Closest, closest, support, unit};
use crate::collide::polytope::{PARALLEL, closest_on_edges, preferred};
use crate::collide::{Edge, Hull, Manifold, ManifoldPoint, Plane};
use crate::math::{Pose, Vec3, any_perpendicular, clamp, length, max, min};

/// Segments (and edges) whose squared sine is less touch with two points: 3 degrees.
pub(super) const ALONG: f32 = 2.5e-3;
/// The sine that belongs to [`ALONG`]: how much an edge may fall over its length and still be level.
const ALONG_HEIGHT: f32 = 0.05;
/// An edge this fraction of its length below the top still reaches it.
const TOP: f32 = 1.0e-3;
/// Cosine from which a normal counts as a face's: 1.1 degrees.
pub(super) const FACE_COSINE: f32 = 0.9998;
/// Two points nearer than this fraction of the radius are one.
const ONE_POINT: f32 = 1.0e-2;
/// Cores nearer than this fraction of the radii have no direction.
const COINCIDENT: f32 = 1.0e-6;
/// How far beyond a face's sides a segment may be cut, and how much two points may miss of the depth of the
/// closest one, as a fraction of the radius.
pub(super) const SLACK: f32 = 1.0e-3;
/// Margin of a face over an edge for a core inside of a hull, as a fraction of the radius.
const PREFERENCE: f32 = 1.0e-3;

/// Feature of the one closest point.
const CLOSEST_FEATURE: u32 = 0;
/// Features of the two points of a segment, by the end that is nearer.
const END_FEATURES: [u32; 2] = [1, 2];

/// A capsule in some frame.
#[derive(Clone, Copy, Debug)]
pub struct Segment {
    /// Start of the core, metres.
    pub tail: Vec3,
    /// End of the core, metres.
    pub head: Vec3,
    /// Unit direction from tail to head.
    pub axis: Vec3,
    /// Metres.
    pub radius: f32,
}

impl Segment {
    /// The capsule along the z axis of `pose`.
    pub fn new(half_height: f32, radius: f32, pose: &Pose) -> Self {
        let axis = pose.rotation.rotate(Vec3::Z);
        let (tail, head) = (pose.position - axis * half_height, pose.position + axis * half_height);
        Self { tail, head, axis, radius }
    }

    fn half(&self) -> f32 {
        0.5 * (self.head - self.tail).dot(self.axis)
    }

    fn center(&self) -> Vec3 {
        (self.head + self.tail) * 0.5
    }

    fn at(&self, s: f32) -> Vec3 {
        self.tail + (self.head - self.tail) * s
    }
}

/// A point of each core.
#[derive(Clone, Copy, Debug)]
pub struct Between {
    /// Point of A's core.
    pub on_a: Vec3,
    /// Point of B's core.
    pub on_b: Vec3,
    /// Unit normal where the points coincide.
    pub fallback: Vec3,
}

impl Between {
    /// Unit normal from A to B and distance of the points, metres.
    fn normal(&self, (ra, rb): (f32, f32)) -> (Vec3, f32) {
        let (normal, apart) = unit(self.on_b - self.on_a, self.fallback);
        if apart > COINCIDENT * (ra + rb) { (normal, apart) } else { (self.fallback, 0.0) }
    }

    /// The contact of balls of these radii around the points.
    pub fn manifold(&self, radii: (f32, f32), distance: f32) -> Option<Manifold> {
        let (normal, _) = self.normal(radii);
        let point = self.point(normal, radii, CLOSEST_FEATURE);
        if point.separation <= distance { Some(single(normal, point)) } else { None }
    }

    /// The contact along a given normal.
    fn point(&self, n: Vec3, (ra, rb): (f32, f32), feature: u32) -> ManifoldPoint {
        let separation = (self.on_b - self.on_a).dot(n) - (ra + rb);
        let position = (self.on_a + n * ra + self.on_b - n * rb) * 0.5;
        ManifoldPoint { position, separation, feature }
    }
}

/// Those of two points that are within the distance; one when they fall together.
fn pair(n: Vec3, points: [ManifoldPoint; 2], (radius, distance): (f32, f32)) -> Option<Manifold> {
    let [p, q] = points;
    let apart = p.position - q.position;
    let one = apart.length_squared() <= ONE_POINT * ONE_POINT * radius * radius;
    let keep_p = p.separation <= distance && !(one && q.separation < p.separation);
    let keep_q = q.separation <= distance && !(one && keep_p);
    let mut kept = heapless::Vec::new();
    for (point, keep) in [(p, keep_p), (q, keep_q)] {
        if keep {
            let _ = kept.push(point);
        }
    }
    if kept.is_empty() { None } else { Some(Manifold { child: 0, normal: n, points: kept, surface: 0 }) }
}

/// Contact of a capsule (A) with a ball around `center`.
pub fn capsule_sphere(a: &Segment, center: Vec3, radius: f32, distance: f32) -> Option<Manifold> {
    let half = a.half();
    let s = clamp((center - a.center()).dot(a.axis), -half, half);
    let on_a = a.center() + a.axis * s;
    let between = Between { on_a, on_b: center, fallback: any_perpendicular(a.axis) };
    between.manifold((a.radius, radius), distance)
}

/// Contacts of two capsules.
pub fn capsules(a: &Segment, b: &Segment, distance: f32) -> Option<Manifold> {
    let (ha, hb, r) = (a.half(), b.half(), b.center() - a.center());
    let (ra, rb, cosine) = (r.dot(a.axis), r.dot(b.axis), a.axis.dot(b.axis));
    let crossed = a.axis.cross(b.axis);
    let sine = crossed.length_squared();
    // The part of A's axis beside which B lies.
    let low = max(-ha, ra - hb * cosine.abs());
    let high = min(ha, ra + hb * cosine.abs());
    // Minimum of |r + t b - s a|^2, clamped; of parallel lines the middle of the overlap.
    let line_s = if sine > PARALLEL { (ra - cosine * rb) / sine } else { 0.5 * (low + high) };
    let line_t = clamp(line_s, -ha, ha) * cosine - rb;
    let t = clamp(line_t, -hb, hb);
    let s = clamp(ra + t * cosine, -ha, ha);
    let (across, size) = unit(crossed, Vec3::ZERO);
    let across = if size > 1.0e-4 { across } else { any_perpendicular(a.axis) };
    let across = if across.dot(r) < 0.0 { -across } else { across };
    let between = |s: f32, t: f32| Between {
        on_a: a.center() + a.axis * s,
        on_b: b.center() + b.axis * t,
        fallback: across,
    };
    let (nearest, radii, least) = (between(s, t), (a.radius, b.radius), min(a.radius, b.radius));
    if sine < ALONG && high - low > ONE_POINT * least {
        let (n, _) = nearest.normal(radii);
        let end = |s: f32, feature| between(s, clamp((s - ra) / cosine, -hb, hb)).point(n, radii, feature);
        let [p, q] = [end(low, END_FEATURES[0]), end(high, END_FEATURES[1])];
        // Unless the closest points lie beyond the overlap.
        let enough = nearest.point(n, radii, CLOSEST_FEATURE).separation + SLACK * least;
        if min(p.separation, q.separation) <= enough {
            return pair(n, [p, q], (least, distance));
        }
    }
    if sine >= ALONG && line_s.abs() <= ha && line_t.abs() <= hb {
        // They cross: the normal is exact however near the cores are.
        let point = nearest.point(across, radii, CLOSEST_FEATURE);
        return if point.separation <= distance { Some(single(across, point)) } else { None };
    }
    nearest.manifold(radii, distance)
}

/// Contact of a box (A) with a ball around `center`.
pub fn box_sphere(half: Vec3, center: Vec3, radius: f32, distance: f32) -> Option<Manifold> {
    let (c, h) = (center.to_array(), half.to_array());
    let nearest = Vec3::from_array(core::array::from_fn(|i| clamp(c[i], -h[i], h[i])));
    let mut axis = 0;
    for i in 1..3 {
        if c[i].abs() - h[i] > c[axis].abs() - h[axis] {
            axis = i;
        }
    }
    let face = if c[axis] < 0.0 { -Vec3::AXES[axis] } else { Vec3::AXES[axis] };
    let (normal, apart) = unit(center - nearest, face);
    let (normal, apart) =
        if apart > COINCIDENT * radius { (normal, apart) } else { (face, c[axis].abs() - h[axis]) };
    core_contact(normal, center, (apart, radius), distance)
}

/// The contact of a core at `x`, `apart` metres beyond A's surface along `n`.
fn core_contact(n: Vec3, x: Vec3, (apart, radius): (f32, f32), distance: f32) -> Option<Manifold> {
    let point = core_point(n, x, (apart, radius), CLOSEST_FEATURE);
    if point.separation <= distance { Some(single(n, point)) } else { None }
}

fn core_point(n: Vec3, x: Vec3, (apart, radius): (f32, f32), feature: u32) -> ManifoldPoint {
    // A's surface is at x - n apart, B's at x - n radius.
    ManifoldPoint { position: x - n * (0.5 * (apart + radius)), separation: apart - radius, feature }
}

/// Contact of a hull (A) with a ball around `center`. The hull may be flat.
pub fn hull_sphere(hull: &Hull<'_>, center: Vec3, radius: f32, distance: f32) -> Option<Manifold> {
    let core = [center];
    let (face, apart) = face_axis(hull, &core);
    if apart > distance + radius {
        return None;
    }
    let normal = hull.planes[face].normal;
    // Inside, or over the face. A point in the plane of a flat hull need not be inside.
    if apart < 0.0 || over_face(hull, face, center) {
        return core_contact(normal, center, (apart, radius), distance);
    }
    let near = closest(hull.vertices, &core, distance + radius)?;
    if near.has_normal() {
        return core_contact(near.normal, center, (near.distance, radius), distance);
    }
    core_contact(normal, center, (apart, radius), distance)
}

/// The face beyond which the corners of a core are farthest, and by how much.
fn face_axis(hull: &Hull<'_>, core: &[Vec3]) -> (usize, f32) {
    let mut best = (0, f32::NEG_INFINITY);
    for (face, plane) in hull.planes.iter().enumerate() {
        let mut apart = f32::INFINITY;
        for &x in core {
            apart = min(plane.distance(x), apart);
        }
        if apart > best.1 {
            best = (face, apart);
        }
    }
    best
}

/// True when a point lies over the inside of a face.
fn over_face(hull: &Hull<'_>, face: usize, x: Vec3) -> bool {
    let normal = hull.planes[face].normal;
    let sides = face_loop(hull, face);
    let mut tail = hull.vertices[usize::from(sides[sides.len() - 1])];
    for &vertex in sides {
        let head = hull.vertices[usize::from(vertex)];
        if (head - tail).cross(normal).dot(x - tail) > 0.0 {
            return false;
        }
        tail = head;
    }
    true
}

/// Contacts of a hull (A) with a capsule. The hull may be flat.
pub fn hull_capsule(hull: &Hull<'_>, b: &Segment, distance: f32) -> Option<Manifold> {
    let core = [b.tail, b.head];
    let (_, apart) = face_axis(hull, &core);
    if apart > distance + b.radius {
        return None;
    }
    let near = closest(hull.vertices, &core, distance + b.radius)?;
    if near.distance > distance + b.radius {
        return None;
    }
    hull_capsule_near(hull, b, &near, distance)
}

/// The same, with the closest points of hull and core at hand.
pub fn hull_capsule_near(hull: &Hull<'_>, b: &Segment, near: &Closest, distance: f32) -> Option<Manifold> {
    if !near.has_normal() {
        return deep_capsule(hull, b, face_axis(hull, &[b.tail, b.head]), distance);
    }
    touch(b, near, distance, || along_face(hull, b, near, distance), || along_edge(hull, b, near, distance))
}

/// The contacts of a capsule whose core is outside, by the closest points and what lies along a face or an edge.
pub(super) fn touch(
    b: &Segment,
    near: &Closest,
    distance: f32,
    along_face: impl FnOnce() -> Option<Manifold>,
    along_edge: impl FnOnce() -> Option<Manifold>,
) -> Option<Manifold> {
    // Two points where the segment lies along something, unless the closest points lie on something else.
    let enough = near.distance - b.radius + SLACK * b.radius;
    let deep_enough = |m: &Manifold| m.points.iter().any(|p| p.separation <= enough);
    along_face()
        .filter(deep_enough)
        .or_else(|| along_edge().filter(deep_enough))
        .or_else(|| core_contact(near.normal, near.on_b, (near.distance, b.radius), distance))
}

/// Two contacts when the closest points have a face's normal and the segment lies over that face.
fn along_face(hull: &Hull<'_>, b: &Segment, near: &Closest, distance: f32) -> Option<Manifold> {
    let mut face = 0;
    let mut cosine = f32::NEG_INFINITY;
    for (i, plane) in hull.planes.iter().enumerate() {
        let c = plane.normal.dot(near.normal);
        if c > cosine {
            (face, cosine) = (i, c);
        }
    }
    if cosine < FACE_COSINE { None } else { face_contacts(hull, b, face, distance) }
}

/// The part of a segment that lies over a face, by parameters.
#[derive(Clone, Copy)]
pub(super) struct Over {
    low: f32,
    high: f32,
}

impl Over {
    pub const ALL: Self = Self { low: 0.0, high: 1.0 };

    /// Cuts off what is beyond a side of the face, beyond which the segment's ends are by `p` and `q`; `None` when
    /// that is all.
    pub fn cut(self, p: f32, q: f32) -> Option<Self> {
        let Self { low, high } = self;
        if p > 0.0 && q > 0.0 {
            return None;
        }
        if p > 0.0 {
            Some(Self { low: max(p / (p - q), low), high })
        } else if q > 0.0 {
            Some(Self { low, high: min(p / (p - q), high) })
        } else {
            Some(self)
        }
    }

    /// The contacts of its ends with the face.
    pub fn contacts(self, b: &Segment, plane: &Plane, distance: f32) -> Option<Manifold> {
        if self.low > self.high {
            return None;
        }
        let end = |s: f32, feature| {
            let x = b.at(s);
            core_point(plane.normal, x, (plane.distance(x), b.radius), feature)
        };
        let ends = [end(self.low, END_FEATURES[0]), end(self.high, END_FEATURES[1])];
        pair(plane.normal, ends, (b.radius, distance))
    }
}

/// The ends of the part of a segment that lies over a face.
fn face_contacts(hull: &Hull<'_>, b: &Segment, face: usize, distance: f32) -> Option<Manifold> {
    let plane = hull.planes[face];
    let sides = face_loop(hull, face);
    let mut over = Over::ALL;
    let mut tail = hull.vertices[usize::from(sides[sides.len() - 1])];
    for &vertex in sides {
        let head = hull.vertices[usize::from(vertex)];
        let outward = (head - tail).cross(plane.normal);
        let offset = outward.dot(tail) + length(outward) * SLACK * b.radius;
        over = over.cut(outward.dot(b.tail) - offset, outward.dot(b.head) - offset)?;
        tail = head;
    }
    over.contacts(b, &plane, distance)
}

/// Two contacts when the segment lies along an edge that is farthest along the normal.
pub(super) fn along_edge(hull: &Hull<'_>, b: &Segment, near: &Closest, distance: f32) -> Option<Manifold> {
    let n = near.normal;
    let (tail, head) = top_edge(hull, b, n)?;
    let along = head - tail;
    let (cosine, square) = (along.dot(b.axis), along.length_squared());
    // Where the segment passes the ends of the edge.
    let (half, middle) = (b.half(), b.center());
    let (x, y) = ((tail - middle).dot(along) / cosine, (head - middle).dot(along) / cosine);
    let (low, high) = (max(min(x, y), -half), min(max(x, y), half));
    if high - low <= ONE_POINT * b.radius {
        return None;
    }
    let end = |s: f32, feature| {
        let x = middle + b.axis * s;
        let on_a = tail + along * ((x - tail).dot(along) / square);
        core_point(n, x, ((x - on_a).dot(n), b.radius), feature)
    };
    pair(n, [end(low, END_FEATURES[0]), end(high, END_FEATURES[1])], (b.radius, distance))
}

/// The ends of the highest edge along `n` that reaches the top, is about level and runs along the segment.
fn top_edge(hull: &Hull<'_>, b: &Segment, n: Vec3) -> Option<(Vec3, Vec3)> {
    let top = hull.vertices[support(hull.vertices, n)].dot(n);
    let mut best = None;
    let mut best_height = f32::NEG_INFINITY;
    for edge in hull.edges {
        let (tail, head) = ends(hull, edge);
        let along = head - tail;
        let square = along.length_squared();
        let cosine = along.dot(b.axis);
        // sin^2 < ALONG, from the cosine: exact enough at this size.
        if cosine * cosine <= (1.0 - ALONG) * square {
            continue;
        }
        let (size, tail_height, head_height) = (length(along), tail.dot(n), head.dot(n));
        let reaches = max(tail_height, head_height) >= top - TOP * size;
        let level = (tail_height - head_height).abs() <= ALONG_HEIGHT * size;
        if reaches && level && tail_height + head_height > best_height {
            (best, best_height) = (Some((tail, head)), tail_height + head_height);
        }
    }
    best
}

fn ends(hull: &Hull<'_>, edge: &Edge) -> (Vec3, Vec3) {
    (hull.vertices[usize::from(edge.tail)], hull.vertices[usize::from(edge.head)])
}

/// Contacts of a capsule whose core enters the hull: along the axis of least depth.
fn deep_capsule(
    hull: &Hull<'_>,
    b: &Segment,
    (face, apart): (usize, f32),
    distance: f32,
) -> Option<Manifold> {
    if let Some((edge, n, edge_apart)) = edge_axis(hull, b)
        && preferred(edge_apart, apart, PREFERENCE * b.radius)
    {
        let (on_a, on_b) = closest_on_edges(ends(hull, &edge), (b.tail, b.head));
        let position = (on_a + on_b - n * b.radius) * 0.5;
        let separation = edge_apart - b.radius;
        let point = ManifoldPoint { position, separation, feature: CLOSEST_FEATURE };
        return if separation <= distance { Some(single(n, point)) } else { None };
    }
    let plane = hull.planes[face];
    face_contacts(hull, b, face, distance).or_else(|| {
        let lower = if plane.distance(b.head) < plane.distance(b.tail) { b.head } else { b.tail };
        core_contact(plane.normal, lower, (apart, b.radius), distance)
    })
}

/// The edge along whose common perpendicular with the segment the two are farthest, with that unit normal and
/// the separation of the core.
fn edge_axis(hull: &Hull<'_>, b: &Segment) -> Option<(Edge, Vec3, f32)> {
    let mut best: Option<(Edge, Vec3, f32)> = None;
    for edge in hull.edges {
        let left = hull.planes[usize::from(edge.left)].normal.dot(b.axis);
        let right = hull.planes[usize::from(edge.right)].normal.dot(b.axis);
        // The edge's arc of normals must cross the circle of those perpendicular to the segment.
        if (left > 0.0) == (right > 0.0) {
            continue;
        }
        let (tail, head) = ends(hull, edge);
        let along = head - tail;
        let axis = along.cross(b.axis);
        if axis.length_squared() <= PARALLEL * along.length_squared() {
            continue;
        }
        // It crosses at L |right| + R |left|, which is the cross product with the sign of left.
        let (n, _) = unit(if left > 0.0 { axis } else { -axis }, Vec3::Z);
        let apart = n.dot(b.center() - tail);
        if best.is_none_or(|(_, _, old)| apart > old) {
            best = Some((*edge, n, apart));
        }
    }
    best
}
