//! One triangle of a mesh against a convex shape.
//!
//! The triangle is taken for a flat hull with two faces, the first on the side of the shape's center, and tested
//! like any hull. What a mesh adds is that a triangle does not end at its edges: an inner edge must not stop a
//! box that slides over it. So the normal found is judged by the neighbours across the edges it leans on:
//!
//! ```text
//!            d        m is the direction from the edge into the neighbour, across the edge.
//!      n ^  /         d . m <= 0   the edge is the highest part of both triangles along d: accepted;
//!        | /  m       d . m >  0   the neighbour rises above the edge along d: not the edge touches,
//!    ----e ---->                   but a face.
//! ```
//!
//! Rejected normals give way to the triangle's own, unless that would push much farther: then what touches is the
//! neighbour, and it is tested by itself. Inside of a corner only faces push. Behind the neighbour (on top of a
//! ledge, seen from the ledge's wall) the triangle is out of reach.
//!
//! Coordinates are relative to the origin of the convex shape's frame, so that f32 resolves a contact as finely on
//! a mesh of kilometres as on one of metres. Legend: `n` the triangle's normal on the shape's side, `d` a contact
//! normal from the triangle to the shape, `t` along an edge, `m` across it.

use super::clip::{self, Candidates, FacePair, Naming, Polygon, Reference};
use super::convex::round::{self, Segment};
use super::distance::{closest, unit};
use super::polytope::{self, SLACK_OF_TOLERANCE};
use super::support::{self, SupportShape};
use super::{Edge, Face, Hull, Manifold, ManifoldPoint, Mesh, Plane};
use crate::math::{Vec3, length, max, min, sqrt};

/// Sine up to which directions count as equal: 0.6 degrees. A ridge or valley so flat gives the face's normal.
const FLAT: f32 = 0.01;
/// Cosine that belongs to [`FLAT`].
const FLAT_COSINE: f32 = 0.999_95;
/// Sine from which neighbours make a corner rather than a bumpy floor: 3 degrees.
const CORNER: f32 = 0.05;
/// Sine up to which a neighbour does not rise: noise of a normal on the border of its cone.
const RISE: f32 = 1.0e-3;
/// Cosine from which a normal is like a face's.
const LIKE_FACE: f32 = 0.7;
/// A normal is a neighbour's if it is nearer to the neighbour's by so much (difference of cosines).
const NEARER: f32 = 0.01;
/// How much farther than the rejected normal the face may push.
const DEEPER: f32 = 2.0;
/// Lengths that count as equal for round shapes, as a fraction of the radius.
const ROUND_TOLERANCE: f32 = 1.0e-2;
/// The same for cylinders, cones and rounded hulls, as a fraction of their size.
const SUPPORT_TOLERANCE: f32 = 2.0e-3;
/// The same for contacts of hulls, as a fraction of their size.
const HULL_TOLERANCE: f32 = 1.0e-3;
/// How far beyond the sides a segment may be cut, as a fraction of the radius: points on an inner edge belong to
/// both triangles.
const SLACK: f32 = 1.0e-3;

const FACES: [Face; 2] = [Face { first: 0, count: 3 }, Face { first: 3, count: 3 }];
const LOOPS: [u8; 6] = [0, 1, 2, 0, 2, 1];
const EDGES: [Edge; 3] = [
    Edge { tail: 0, head: 1, left: 0, right: 1 },
    Edge { tail: 1, head: 2, left: 0, right: 1 },
    Edge { tail: 2, head: 0, left: 0, right: 1 },
];

/// A convex shape in its own origin, turned as in the mesh's frame.
#[derive(Clone, Copy, Debug)]
pub enum Convex<'a> {
    /// A ball around the origin.
    Sphere {
        /// Metres.
        radius: f32,
    },
    /// A capsule.
    Capsule(Segment),
    /// A cylinder, a cone or a rounded hull.
    Support {
        /// Its support function.
        shape: &'a SupportShape<'a>,
        /// About half of its extent, metres.
        size: f32,
    },
    /// A box or a hull.
    Hull {
        /// Its tables.
        hull: Hull<'a>,
        /// Lengths that count as equal, metres: see [`polytope::tolerance`].
        tolerance: f32,
    },
}

impl Convex<'_> {
    /// A point in the middle.
    pub fn center(&self) -> Vec3 {
        match self {
            Self::Sphere { .. } => Vec3::ZERO,
            Self::Capsule(segment) => (segment.tail + segment.head) * 0.5,
            Self::Hull { hull, .. } => hull.center,
            Self::Support { shape, .. } => shape.center().as_vec3(),
        }
    }

    /// Greatest distance of its points from the center, metres.
    pub fn size(&self) -> f32 {
        match self {
            Self::Sphere { radius } => *radius,
            Self::Capsule(segment) => 0.5 * length(segment.head - segment.tail) + segment.radius,
            Self::Hull { hull, .. } => {
                let mut square = 0.0;
                for &vertex in hull.vertices {
                    square = max((vertex - hull.center).length_squared(), square);
                }
                sqrt(square)
            }
            Self::Support { size, .. } => *size,
        }
    }

    /// Lengths that count as equal, metres.
    pub fn tolerance(&self) -> f32 {
        match self {
            Self::Sphere { radius } => ROUND_TOLERANCE * radius,
            Self::Capsule(segment) => ROUND_TOLERANCE * segment.radius,
            Self::Hull { tolerance, .. } => *tolerance,
            Self::Support { size, .. } => SUPPORT_TOLERANCE * size,
        }
    }

    /// Contacts nearer than this are one, metres: a ball has only one in any direction.
    pub fn one_point(&self) -> f32 {
        match self {
            Self::Sphere { radius } => *radius,
            Self::Capsule(segment) => ROUND_TOLERANCE * segment.radius,
            Self::Hull { .. } | Self::Support { .. } => HULL_TOLERANCE * self.size(),
        }
    }
}

/// A triangle as its neighbours and a convex shape see it.
#[derive(Clone, Copy, Debug)]
pub struct Facet {
    /// Corners, counter-clockwise seen from the shape's center.
    vertices: [Vec3; 3],
    /// The side of the shape's center, then the other.
    planes: [Plane; 2],
    /// For each edge (from corner `i` to `i + 1`) the neighbour's corner that faces it.
    across: [Option<Vec3>; 3],
    /// The shape's center.
    center: Vec3,
}

/// What becomes of a contact normal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Verdict {
    /// It stands.
    Accepted,
    /// It is the face's normal but for little.
    Face,
    /// A neighbour is in the way: the face's normal takes its place if that is plausible.
    Rejected,
    /// The triangle lies behind its neighbour.
    Covered,
}

impl Facet {
    /// Triangle `index` of a mesh with the origin at `origin`, turned to `center` (from that origin).
    pub fn new(mesh: &Mesh<'_>, index: u32, origin: Vec3, center: Vec3) -> Self {
        let triangle = mesh.triangles[index as usize];
        let corner = |vertex: u32| mesh.vertices[vertex as usize] - origin;
        let across = triangle.across.map(|v| (v != u32::MAX).then(|| corner(v)));
        Self::of(triangle.vertices.map(corner), across, center)
    }

    /// The triangle of three corners, turned to `center`; `across` are the corners that face its edges.
    pub fn of([a, b, c]: [Vec3; 3], [ab, bc, ca]: [Option<Vec3>; 3], center: Vec3) -> Self {
        let (normal, _) = unit((b - a).cross(c - a), Vec3::Z);
        let offset = normal.dot(a);
        if normal.dot(center) >= offset {
            let planes = [Plane { normal, offset }, Plane { normal: -normal, offset: -offset }];
            Self { vertices: [a, b, c], planes, across: [ab, bc, ca], center }
        } else {
            let planes = [Plane { normal: -normal, offset: -offset }, Plane { normal, offset }];
            Self { vertices: [a, c, b], planes, across: [ca, bc, ab], center }
        }
    }

    /// Finds the contacts with the shape within `distance` metres: replaces `points` by them and returns their
    /// normal, from the triangle to the shape. None when there are none.
    pub fn contact(&self, b: &Convex<'_>, distance: f32, points: &mut Candidates) -> Option<Vec3> {
        points.clear();
        match b {
            Convex::Sphere { radius } => self.sphere(*radius, distance, points),
            Convex::Capsule(segment) => self.capsule(segment, distance, points),
            Convex::Hull { hull, tolerance } => self.polytope(hull, *tolerance, distance, points),
            Convex::Support { shape, .. } => self.support(shape, b.tolerance(), distance, points),
        }
    }

    fn sphere(&self, radius: f32, distance: f32, points: &mut Candidates) -> Option<Vec3> {
        let found = round::hull_sphere(&self.hull(), self.center, radius, distance)?;
        match self.judge(found.normal) {
            Verdict::Accepted => take(&found, points),
            Verdict::Face => {
                let _ = points.push(self.point_over_face(self.center, radius, found.points[0].feature));
                self.normal_within(distance, points)
            }
            // Where a neighbour is nearer it has the contact.
            Verdict::Rejected | Verdict::Covered => None,
        }
    }

    fn capsule(&self, b: &Segment, distance: f32, points: &mut Candidates) -> Option<Vec3> {
        let found = take(&round::hull_capsule(&self.hull(), b, distance)?, points);
        let face = |points: &mut Candidates| self.segment_over_face(b, distance, points);
        self.settle(found?, points, ROUND_TOLERANCE * b.radius, face)
    }

    fn support(
        &self,
        b: &SupportShape<'_>,
        tolerance: f32,
        distance: f32,
        points: &mut Candidates,
    ) -> Option<Vec3> {
        let own = SupportShape::of_hull(self.hull());
        let found = support::contacts(&own, b, distance, points)?;
        self.settle(found, points, tolerance, |points| {
            support::contacts_over(&own, b, (self.normal(), distance), points);
            (!points.is_empty()).then_some(self.normal())
        })
    }

    /// Along the axis that [`polytope::manifold`] would choose.
    fn polytope(&self, b: &Hull<'_>, tolerance: f32, distance: f32, points: &mut Candidates) -> Option<Vec3> {
        let hull = self.hull();
        let own = polytope::face_axis(&hull, b, distance)?;
        let other = polytope::face_axis(b, &hull, distance)?;
        let slack = SLACK_OF_TOLERANCE * tolerance;
        let own_pair = FacePair { reference: &hull, face: 0, incident: b, side: Reference::A, slack };
        let other_pair =
            FacePair { reference: b, face: other.face, incident: &hull, side: Reference::B, slack };
        let is_other = polytope::preferred(other.separation, own.separation, tolerance);
        let (best, first, second) = match is_other {
            true => (other.separation, &other_pair, &own_pair),
            false => (own.separation, &own_pair, &other_pair),
        };
        let edge = polytope::edge_axis(&hull, b)
            .filter(|edge| polytope::preferred(edge.separation, best, tolerance));
        let found = match edge {
            Some(edge) if edge.separation > distance => return None,
            Some(edge) => polytope::edge_manifold(&hull, b, &edge).and_then(|found| take(&found, points)),
            None => face_contacts(first, distance, points),
        };
        // Near an edge or a corner the faces may miss each other although the hulls are near, or overlap.
        let found = found
            .or_else(|| closest_contact(&hull, b, distance, points))
            .or_else(|| face_contacts(second, distance, points))?;
        self.settle(found, points, tolerance, |points| face_contacts(&own_pair, distance, points))
    }

    /// Keeps what was found for the triangle alone, or replaces it by the contacts of its face, or drops it.
    fn settle(
        &self,
        found: Vec3,
        points: &mut Candidates,
        tolerance: f32,
        face: impl Fn(&mut Candidates) -> Option<Vec3>,
    ) -> Option<Vec3> {
        if found == self.normal() {
            return Some(found);
        }
        match self.judge(found) {
            Verdict::Accepted => Some(found),
            Verdict::Face => face(points),
            Verdict::Rejected => {
                let least = self.least_separation(found, deepest(points), tolerance);
                face(points).filter(|_| deepest(points) >= least)
            }
            Verdict::Covered => None,
        }
    }

    /// How deep the face may push in the place of a rejected normal `d`, along which the separation was `rejected`.
    ///
    /// A normal much like the face's may be replaced by it unless that pushes much farther. One that runs along
    /// the face comes from an edge near which the shape passes, most often one that a neighbour has: the face
    /// counts only if the shape stands on it.
    fn least_separation(&self, d: Vec3, rejected: f32, tolerance: f32) -> f32 {
        if d.dot(self.normal()) >= LIKE_FACE {
            return -(DEEPER * max(-rejected, 0.0) + tolerance);
        }
        let is_over = (0..3).all(|i| {
            let (tail, head) = (self.vertices[i], self.vertices[(i + 1) % 3]);
            let outward = (head - tail).cross(self.normal());
            outward.dot(self.center - tail) <= length(outward) * tolerance
        });
        if is_over { f32::NEG_INFINITY } else { f32::INFINITY }
    }

    /// Judges a contact normal by the neighbours of the edges that reach highest along it.
    fn judge(&self, d: Vec3) -> Verdict {
        if d.dot(self.normal()) >= FLAT_COSINE {
            return Verdict::Face;
        }
        let heights = self.vertices.map(|vertex| vertex.dot(d));
        let top = max(heights[0], max(heights[1], heights[2]));
        let on_top = |i: usize| heights[i] >= top;
        let highest = if on_top(0) { 0 } else { 1 + usize::from(!on_top(1)) };
        let reaches = [0, 1, 2].map(|i| {
            let along = self.vertices[i] - self.vertices[highest];
            top - heights[i] <= FLAT * length(along)
        });
        let mut verdict = Verdict::Accepted;
        for i in 0..3 {
            let next = (i + 1) % 3;
            // Of an edge on top only that edge counts, of a corner both of its edges.
            let counts = match reaches.iter().filter(|&&reach| reach).count() {
                1 => reaches[i] || reaches[next],
                2 => reaches[i] && reaches[next],
                _ => return Verdict::Rejected,
            };
            if counts {
                let corner = if reaches[i] { i } else { next };
                match self.judge_at_edge(d, i, corner) {
                    Verdict::Covered => return Verdict::Covered,
                    Verdict::Accepted => {}
                    other => verdict = other,
                }
            }
        }
        verdict
    }

    /// Judges a normal by the neighbour across edge `i`, whose end `corner` is on top along `d`.
    fn judge_at_edge(&self, d: Vec3, i: usize, corner: usize) -> Verdict {
        let Some(neighbour) = self.across[i] else { return Verdict::Accepted };
        let (tail, head) = (self.vertices[i], self.vertices[(i + 1) % 3]);
        let (t, _) = unit(head - tail, Vec3::ZERO);
        let to_neighbour = neighbour - tail;
        let (m, _) = unit(to_neighbour - t * to_neighbour.dot(t), Vec3::ZERO);
        let (toward, _) = unit(neighbour - self.vertices[corner], Vec3::ZERO);
        let rises = d.dot(m) > RISE || d.dot(toward) > RISE;
        if m.dot(self.normal()) > CORNER {
            // A corner: m x t is the neighbour's normal that looks into it.
            let inside = m.cross(t).dot(self.center - tail) >= 0.0;
            return match (inside, rises) {
                (true, _) => Verdict::Rejected,
                (false, true) => Verdict::Covered,
                (false, false) => Verdict::Accepted,
            };
        }
        // m x t continues the triangle's normal beyond the edge.
        let beyond = d.dot(m.cross(t));
        match rises {
            false => Verdict::Accepted,
            true if beyond > LIKE_FACE && beyond > d.dot(self.normal()) + NEARER => Verdict::Covered,
            true => Verdict::Rejected,
        }
    }

    /// Contacts of the part of a capsule that lies over the face, along the face's normal.
    fn segment_over_face(&self, b: &Segment, distance: f32, points: &mut Candidates) -> Option<Vec3> {
        points.clear();
        let (mut low, mut high) = (0.0, 1.0);
        for i in 0..3 {
            let (tail, head) = (self.vertices[i], self.vertices[(i + 1) % 3]);
            let outward = (head - tail).cross(self.normal());
            let slack = length(outward) * SLACK * b.radius;
            let (p, q) = (outward.dot(b.tail - tail) - slack, outward.dot(b.head - tail) - slack);
            if p > 0.0 && q > 0.0 {
                return None;
            }
            if p > 0.0 {
                low = max(p / (p - q), low);
            } else if q > 0.0 {
                high = min(p / (p - q), high);
            }
        }
        if low > high {
            return None;
        }
        for (s, feature) in [(low, 1), (high, 2)] {
            let x = b.tail + (b.head - b.tail) * s;
            let _ = points.push(self.point_over_face(x, b.radius, feature));
        }
        self.normal_within(distance, points)
    }

    /// Leaves out the points beyond `distance`; the face's normal when some remain.
    fn normal_within(&self, distance: f32, points: &mut Candidates) -> Option<Vec3> {
        points.retain(|point| point.separation <= distance);
        (!points.is_empty()).then_some(self.normal())
    }

    /// The contact of a ball around `x` along the face's normal.
    fn point_over_face(&self, x: Vec3, radius: f32, feature: u32) -> ManifoldPoint {
        let height = self.planes[0].distance(x);
        let position = x - self.normal() * (0.5 * (height + radius));
        ManifoldPoint { position, separation: height - radius, feature }
    }

    fn normal(&self) -> Vec3 {
        self.planes[0].normal
    }

    fn hull(&self) -> Hull<'_> {
        let [a, b, c] = self.vertices;
        Hull {
            vertices: &self.vertices,
            planes: &self.planes,
            faces: &FACES,
            loops: &LOOPS,
            edges: &EDGES,
            center: (a + b + c) / 3.0,
        }
    }
}

/// Replaces `points` by those of a manifold and returns its normal.
fn take(manifold: &Manifold, points: &mut Candidates) -> Option<Vec3> {
    points.clear();
    for &point in &manifold.points {
        let _ = points.push(point);
    }
    Some(manifold.normal)
}

/// Replaces `points` by the middle of the closest points of two hulls that do not overlap, and returns the normal.
fn closest_contact(a: &Hull<'_>, b: &Hull<'_>, distance: f32, points: &mut Candidates) -> Option<Vec3> {
    points.clear();
    let near = closest(a.vertices, b.vertices, distance)?;
    if near.distance > distance || !near.has_normal() {
        return None;
    }
    let position = (near.on_a + near.on_b) * 0.5;
    let _ = points.push(ManifoldPoint { position, separation: near.distance, feature: 0 });
    Some(near.normal)
}

/// Replaces `points` by all contacts of a reference face with the other hull's incident face, and returns the
/// normal. None when there are none. Not reduced: what counts is seen only next to the other triangles.
fn face_contacts(pair: &FacePair<'_>, distance: f32, points: &mut Candidates) -> Option<Vec3> {
    points.clear();
    let plane = pair.reference.planes[pair.face];
    let incident = face_loop(pair.incident, clip::incident_face(pair.incident, plane.normal));
    let (mut first, mut second) = (Polygon::new(), Polygon::new());
    clip::polygon_of(pair.incident.vertices, incident, &mut first);
    let (mut from, mut to) = (&mut first, &mut second);
    let sides = face_loop(pair.reference, pair.face);
    let mut tail = pair.reference.vertices[usize::from(sides[sides.len() - 1])];
    for (i, &vertex) in sides.iter().enumerate() {
        let head = pair.reference.vertices[usize::from(vertex)];
        let outward = (head - tail).cross(plane.normal);
        let offset = outward.dot(tail) + length(outward) * pair.slack;
        if clip::cut(from, to, clip::SIDE + i as u8, |point| outward.dot(point) - offset) {
            core::mem::swap(&mut from, &mut to);
        }
        tail = head;
    }
    let naming = Naming { side: pair.side, face: pair.face, incident };
    for corner in from.iter() {
        let separation = plane.distance(corner.position);
        if separation <= distance {
            let position = corner.position - plane.normal * (0.5 * separation);
            let _ = points.push(ManifoldPoint { position, separation, feature: naming.feature(corner) });
        }
    }
    let normal = if pair.side == Reference::A { plane.normal } else { -plane.normal };
    (!points.is_empty()).then_some(normal)
}

fn face_loop<'a>(hull: &Hull<'a>, face: usize) -> &'a [u8] {
    let Face { first, count } = hull.faces[face];
    &hull.loops[usize::from(first)..usize::from(first) + usize::from(count)]
}

/// The least separation of some points; infinite when there are none.
pub fn deepest(points: &[ManifoldPoint]) -> f32 {
    points.iter().fold(f32::INFINITY, |least, point| min(point.separation, least))
}
