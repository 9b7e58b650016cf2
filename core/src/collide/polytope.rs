//! Two convex hulls: the separating-axis test and its manifold.
//!
//! Two hulls overlap by the least depth over the faces of their Minkowski difference A - B (Gregorius, "The
//! Separating Axis Test between Convex Polyhedra", GDC 2013). Those are the faces of A, the faces of B turned
//! round, and one for each pair of edges whose arcs on the sphere of normals cross:
//!
//! ```text
//!   an edge is the arc from its left face's normal L to its right face's R; L x R runs along the edge e
//!   arcs a and b cross when b's ends lie on both sides of a's plane, a's on both sides of b's, and both in
//!   one hemisphere; all three are signs of dot products with the edges themselves, which also holds for the
//!   two faces of a triangle, whose normals are opposite and span no plane
//! ```
//!
//! A face is preferred to a pair of edges, and A's face to B's, unless the other is better by a margin: nearly
//! equal axes must not alternate from step to step.

use super::clip::{self, FacePair, Reference};
use super::distance::{closest, support};
use super::{Edge, Face, HULL_FACES_MAX, HULL_VERTICES_MAX, Hull, Manifold, ManifoldPoint, Plane};
use crate::math::{Pose, Vec3, clamp, length, min, sqrt};

/// The margin of preference as a fraction of the lesser inner radius: 2 mm for a cube of one metre.
const PREFERENCE: f32 = 0.004;
/// The further margin of preference, as a fraction of the depth.
const PREFERENCE_OF_DEPTH: f32 = 0.05;
/// How far beyond a reference face's sides points may lie, as a fraction of the margin of preference.
pub const SLACK_OF_TOLERANCE: f32 = 0.25;
/// Edges whose squared sine is less make no axis: its direction would be rounding, and faces bound the depth.
pub const PARALLEL: f32 = 1.0e-6;
/// Edges miss each other when they are farther apart than their lines by this fraction of their length.
const MISS: f32 = 1.0e-3;
/// Feature of the closest points of two shapes.
const CLOSEST_FEATURE: u32 = 1;

/// Faces of a box: index 2 axis + (1 on the positive side).
pub const BOX_FACES: [Face; 6] = [
    Face { first: 0, count: 4 },
    Face { first: 4, count: 4 },
    Face { first: 8, count: 4 },
    Face { first: 12, count: 4 },
    Face { first: 16, count: 4 },
    Face { first: 20, count: 4 },
];
/// Vertices around the faces of a box; bit i of a vertex index is set on the positive side of axis i.
pub const BOX_LOOPS: [u8; 24] = [0, 4, 6, 2, 1, 3, 7, 5, 0, 1, 5, 4, 2, 6, 7, 3, 0, 2, 3, 1, 4, 5, 7, 6];
/// Edges of a box: index 4 axis + (1 on the positive side of the next axis) + (2 on that of the one after).
pub const BOX_EDGES: [Edge; 12] = [
    Edge { tail: 0, head: 1, left: 2, right: 4 },
    Edge { tail: 2, head: 3, left: 4, right: 3 },
    Edge { tail: 4, head: 5, left: 5, right: 2 },
    Edge { tail: 6, head: 7, left: 3, right: 5 },
    Edge { tail: 0, head: 2, left: 4, right: 0 },
    Edge { tail: 4, head: 6, left: 0, right: 5 },
    Edge { tail: 1, head: 3, left: 1, right: 4 },
    Edge { tail: 5, head: 7, left: 5, right: 1 },
    Edge { tail: 0, head: 4, left: 0, right: 2 },
    Edge { tail: 1, head: 5, left: 2, right: 1 },
    Edge { tail: 2, head: 6, left: 3, right: 0 },
    Edge { tail: 3, head: 7, left: 1, right: 3 },
];

/// The corners and planes of a box, to be viewed as a hull.
#[derive(Clone, Copy, Debug)]
pub struct BoxHull {
    vertices: [Vec3; 8],
    planes: [Plane; 6],
}

impl BoxHull {
    /// A box around the origin; `half` is half of each edge, metres.
    pub fn new(half: Vec3) -> Self {
        let side = |i: usize, bit: usize, h: f32| if i >> bit & 1 == 1 { h } else { -h };
        let vertices =
            core::array::from_fn(|i| Vec3::new(side(i, 0, half.x), side(i, 1, half.y), side(i, 2, half.z)));
        let plane = |normal, offset| Plane { normal, offset };
        let planes = [
            plane(Vec3::NEG_X, half.x),
            plane(Vec3::X, half.x),
            plane(Vec3::NEG_Y, half.y),
            plane(Vec3::Y, half.y),
            plane(Vec3::NEG_Z, half.z),
            plane(Vec3::Z, half.z),
        ];
        Self { vertices, planes }
    }

    /// The box as a hull.
    pub fn hull(&self) -> Hull<'_> {
        Hull {
            vertices: &self.vertices,
            planes: &self.planes,
            faces: &BOX_FACES,
            loops: &BOX_LOOPS,
            edges: &BOX_EDGES,
            center: Vec3::ZERO,
        }
    }
}

/// A hull moved into another frame.
#[derive(Clone, Debug)]
pub struct Placed<'a> {
    vertices: heapless::Vec<Vec3, HULL_VERTICES_MAX>,
    planes: heapless::Vec<Plane, HULL_FACES_MAX>,
    center: Vec3,
    tables: Hull<'a>,
}

impl<'a> Placed<'a> {
    /// The hull of `hull` at `pose`.
    pub fn new(hull: &Hull<'a>, pose: &Pose) -> Self {
        let m = pose.rotation.matrix();
        let mut vertices = heapless::Vec::new();
        for &vertex in hull.vertices {
            let _ = vertices.push(m * vertex + pose.position);
        }
        let mut planes = heapless::Vec::new();
        for plane in hull.planes {
            let normal = m * plane.normal;
            let _ = planes.push(Plane { normal, offset: plane.offset + normal.dot(pose.position) });
        }
        Self { vertices, planes, center: m * hull.center + pose.position, tables: *hull }
    }

    /// The moved hull.
    pub fn hull(&self) -> Hull<'_> {
        Hull { vertices: &self.vertices, planes: &self.planes, center: self.center, ..self.tables }
    }
}

/// The face of a hull along whose normal another hull is farthest.
#[derive(Clone, Copy, Debug)]
pub struct FaceAxis {
    /// Index of the face.
    pub face: usize,
    /// Least distance of the other hull's vertices from the face's plane, metres; negative when they overlap.
    pub separation: f32,
}

/// The pair of edges along whose common perpendicular two hulls are farthest.
#[derive(Clone, Copy, Debug)]
pub struct EdgeAxis {
    /// Edge of A.
    pub edge_a: usize,
    /// Edge of B.
    pub edge_b: usize,
    /// Unit vector from A to B.
    pub normal: Vec3,
    /// Distance of the edges' lines along the normal, metres; negative when they overlap.
    pub separation: f32,
}

/// The lengths that count as equal for two hulls: see [`manifold`]. A flat hull (a triangle) has no inner radius
/// and does not count.
pub fn tolerance(a: &Hull<'_>, b: &Hull<'_>) -> f32 {
    let (ra, rb) = (inner_radius(a), inner_radius(b));
    let radius = if ra <= 0.0 || (rb > 0.0 && rb < ra) { rb } else { ra };
    tolerance_of_radius(radius)
}

/// [`tolerance`] of hulls whose lesser inner radius is known.
#[inline(always)]
pub fn tolerance_of_radius(radius: f32) -> f32 {
    if radius > 0.0 && radius < f32::INFINITY { PREFERENCE * radius } else { 0.0 }
}

/// Distance from a hull's center to its nearest face, metres.
fn inner_radius(hull: &Hull<'_>) -> f32 {
    hull.planes.iter().fold(f32::INFINITY, |r, plane| min(-plane.distance(hull.center), r))
}

/// True when an axis of this separation is so much better than another that it may take its place.
#[inline(always)]
pub fn preferred(separation: f32, over: f32, tolerance: f32) -> bool {
    separation > preference_bound(over, tolerance)
}

/// The separation that must be exceeded: see [`preferred`].
#[inline(always)]
pub fn preference_bound(over: f32, tolerance: f32) -> f32 {
    over + PREFERENCE_OF_DEPTH * over.abs() + tolerance
}

/// Contacts of two hulls in one frame, which is the manifold's: `None` when they are farther apart than
/// `distance` metres.
///
/// `tolerance` (metres, usually [`tolerance`]) is the margin by which an edge axis must beat a face and B's face
/// A's. The hulls may be flat (a triangle with two faces).
pub fn manifold(a: &Hull<'_>, b: &Hull<'_>, distance: f32, tolerance: f32) -> Option<Manifold> {
    let face_a = face_axis(a, b, distance)?;
    let face_b = face_axis(b, a, distance)?;
    let (side, face) = if preferred(face_b.separation, face_a.separation, tolerance) {
        (Reference::B, face_b)
    } else {
        (Reference::A, face_a)
    };
    let edge = edge_axis(a, b);
    if let Some(edge) = &edge {
        if edge.separation > distance {
            return None;
        }
        if preferred(edge.separation, face.separation, tolerance) {
            return edge_manifold(a, b, edge).or_else(|| closest_contact(a, b, edge.normal, distance));
        }
    }
    let slack = SLACK_OF_TOLERANCE * tolerance;
    let pair = FacePair { reference: a, face: face_a.face, incident: b, side: Reference::A, slack };
    let turned = FacePair { reference: b, face: face_b.face, incident: a, side: Reference::B, slack };
    let (pair, other) = if side == Reference::A { (pair, turned) } else { (turned, pair) };
    clip::face_manifold(&pair, distance).or_else(|| {
        // Near an edge or a corner the faces may miss each other although the hulls are near. Of overlapping
        // hulls this happens only if the margin of preference has hidden a better axis.
        match edge {
            _ if face.separation > 0.0 => None,
            Some(edge) if edge.separation > face.separation => edge_manifold(a, b, &edge),
            _ => clip::face_manifold(&other, distance),
        }
        .or_else(|| closest_contact(a, b, pair.normal(), distance))
    })
}

/// One contact where two hulls are closest; when they overlap, where B is deepest against `normal`.
pub fn closest_contact(a: &Hull<'_>, b: &Hull<'_>, normal: Vec3, distance: f32) -> Option<Manifold> {
    let near = closest(a.vertices, b.vertices, distance)?;
    if near.distance > distance {
        return None;
    }
    let feature = CLOSEST_FEATURE;
    if near.has_normal() {
        let position = (near.on_a + near.on_b) * 0.5;
        let point = ManifoldPoint { position, separation: near.distance, feature };
        return Some(clip::single(near.normal, point));
    }
    let on_b = b.vertices[support(b.vertices, -normal)];
    let on_a = a.vertices[support(a.vertices, normal)];
    let separation = min((on_b - on_a).dot(normal), 0.0);
    let position = on_b - normal * (0.5 * separation);
    Some(clip::single(normal, ManifoldPoint { position, separation, feature }))
}

/// The face of `a` from which `b` is farthest: `None` when that is more than `distance` metres.
pub fn face_axis(a: &Hull<'_>, b: &Hull<'_>, distance: f32) -> Option<FaceAxis> {
    let mut best = FaceAxis { face: 0, separation: f32::NEG_INFINITY };
    for (face, plane) in a.planes.iter().enumerate() {
        let mut separation = f32::INFINITY;
        for &vertex in b.vertices {
            separation = min(plane.distance(vertex), separation);
        }
        if separation > distance {
            return None;
        }
        if separation > best.separation {
            best = FaceAxis { face, separation };
        }
    }
    Some(best)
}

/// The pair of edges along whose common perpendicular the hulls are farthest: `None` when no pair has one.
pub fn edge_axis(a: &Hull<'_>, b: &Hull<'_>) -> Option<EdgeAxis> {
    let mut best: Option<EdgeAxis> = None;
    // Side of each face of B with respect to the plane of an edge of A. B's normals count turned round.
    let mut sides = [0.0_f32; HULL_FACES_MAX];
    for (edge_a, ea) in a.edges.iter().enumerate() {
        let tail = a.vertices[usize::from(ea.tail)];
        let along = a.vertices[usize::from(ea.head)] - tail;
        let (left, right) = (a.planes[usize::from(ea.left)].normal, a.planes[usize::from(ea.right)].normal);
        for (side, plane) in sides.iter_mut().zip(b.planes) {
            *side = -plane.normal.dot(along);
        }
        for (edge_b, eb) in b.edges.iter().enumerate() {
            let (cba, dba) = (sides[usize::from(eb.right)], sides[usize::from(eb.left)]);
            if (cba > 0.0) == (dba > 0.0) {
                continue;
            }
            let tail_b = b.vertices[usize::from(eb.tail)];
            let along_b = b.vertices[usize::from(eb.head)] - tail_b;
            let (bdc, adc) = (left.dot(along_b), right.dot(along_b));
            if (bdc > 0.0) == (adc > 0.0) || (cba > 0.0) != (bdc > 0.0) {
                continue;
            }
            // The arcs cross at C |dba| + D |cba|, which is the cross product with the sign of cba.
            let axis = along.cross(along_b);
            let sine = axis.length_squared();
            if sine <= PARALLEL * along.length_squared() * along_b.length_squared() {
                continue;
            }
            let size = sqrt(sine);
            let normal = if cba > 0.0 { axis / size } else { -axis / size };
            let separation = normal.dot(tail_b - tail);
            if best.is_none_or(|old| separation > old.separation) {
                best = Some(EdgeAxis { edge_a, edge_b, normal, separation });
            }
        }
    }
    best
}

/// The contact of two crossing edges; `None` when they are apart and do not cross (see [`edge_position`]).
pub fn edge_manifold(a: &Hull<'_>, b: &Hull<'_>, axis: &EdgeAxis) -> Option<Manifold> {
    let ends = |hull: &Hull<'_>, edge: usize| {
        let Edge { tail, head, .. } = hull.edges[edge];
        (hull.vertices[usize::from(tail)], hull.vertices[usize::from(head)])
    };
    let position = edge_position(ends(a, axis.edge_a), ends(b, axis.edge_b), axis.separation)?;
    let feature = clip::edge_feature(axis.edge_a, axis.edge_b);
    let point = ManifoldPoint { position, separation: axis.separation, feature };
    Some(clip::single(axis.normal, point))
}

/// Middle between two edges whose lines are `separation` apart. `None` when that is positive and the edges are
/// clearly farther apart than their lines: then the shapes are closest elsewhere.
pub fn edge_position(a: (Vec3, Vec3), b: (Vec3, Vec3), separation: f32) -> Option<Vec3> {
    let (on_a, on_b) = closest_on_edges(a, b);
    let reach = separation + MISS * min(length(a.1 - a.0), length(b.1 - b.0));
    let misses = separation > 0.0 && (on_b - on_a).length_squared() > reach * reach;
    if misses { None } else { Some((on_a + on_b) * 0.5) }
}

/// Points of two edges where their lines are closest, each kept within its edge. The edges are not parallel.
pub fn closest_on_edges((pa, qa): (Vec3, Vec3), (pb, qb): (Vec3, Vec3)) -> (Vec3, Vec3) {
    let (da, db, r) = (qa - pa, qb - pb, pb - pa);
    let (aa, bb, ab) = (da.length_squared(), db.length_squared(), da.dot(db));
    let (ra, rb) = (da.dot(r), db.dot(r));
    // Minimum of |r + t db - s da|^2:  aa s - ab t = ra,  ab s - bb t = rb.
    let determinant = da.cross(db).length_squared();
    let (s, t) = ((ra * bb - rb * ab) / determinant, (ra * ab - rb * aa) / determinant);
    let inside = |x: f32| if x.is_finite() { clamp(x, 0.0, 1.0) } else { 0.5 };
    (pa + da * inside(s), pb + db * inside(t))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_of_the_box_agree() {
        let half = Vec3::new(1.0, 2.0, 3.0);
        let box_hull = BoxHull::new(half);
        let hull = box_hull.hull();
        for (i, plane) in hull.planes.iter().enumerate() {
            let face = clip::face_loop(&hull, i);
            let corner = |k: usize| hull.vertices[usize::from(face[k % 4])];
            for k in 0..4 {
                assert_eq!(plane.distance(corner(k)), 0.0);
                let turn = (corner(k + 1) - corner(k)).cross(corner(k + 2) - corner(k + 1));
                assert!(turn.dot(plane.normal) > 0.0);
            }
        }
        for (i, edge) in hull.edges.iter().enumerate() {
            let runs = |face: u8, tail: u8, head: u8| {
                let face = clip::face_loop(&hull, usize::from(face));
                (0..4).any(|k| face[k] == tail && face[(k + 1) % 4] == head)
            };
            assert!(runs(edge.left, edge.tail, edge.head) && runs(edge.right, edge.head, edge.tail));
            let (axis, tail) = (i / 4, usize::from(edge.tail));
            assert_eq!(usize::from(edge.head) - tail, 1 << axis);
            let bits = (tail >> ((axis + 1) % 3) & 1) + 2 * (tail >> ((axis + 2) % 3) & 1);
            assert_eq!(i % 4, bits);
        }
    }

    #[test]
    fn a_flat_triangle_is_touched_on_both_faces_and_on_its_edge() {
        let vertices = [Vec3::new(-2.0, -2.0, 0.0), Vec3::new(2.0, -2.0, 0.0), Vec3::new(0.0, 2.0, 0.0)];
        let planes = [Plane { normal: Vec3::Z, offset: 0.0 }, Plane { normal: Vec3::NEG_Z, offset: 0.0 }];
        let faces = [Face { first: 0, count: 3 }, Face { first: 3, count: 3 }];
        let edge = |tail, head| Edge { tail, head, left: 0, right: 1 };
        let triangle = Hull {
            vertices: &vertices,
            planes: &planes,
            faces: &faces,
            loops: &[0, 1, 2, 0, 2, 1],
            edges: &[edge(0, 1), edge(1, 2), edge(2, 0)],
            center: Vec3::new(0.0, -0.67, 0.0),
        };
        let cube = BoxHull::new(Vec3::splat(0.5));
        for (z, normal) in [(0.49, Vec3::Z), (-0.49, Vec3::NEG_Z)] {
            let placed =
                Placed::new(&cube.hull(), &Pose { position: Vec3::new(0.0, -1.0, z), ..Pose::IDENTITY });
            let b = placed.hull();
            let m = manifold(&triangle, &b, 0.0, tolerance(&triangle, &b)).unwrap();
            assert_eq!((m.points.len(), m.normal), (4, normal));
            assert!(m.points.iter().all(|p| (p.separation + 0.01).abs() < 1.0e-6));
        }
        // A cube on its edge, across the triangle's edge from below left: the edges cross.
        let turn = crate::math::Rotation::new(0.0, 0.382_683_43, 0.0, 0.923_879_5);
        let at = Vec3::new(0.0, -2.0 - 0.69, 0.0);
        let upright = crate::math::Rotation::between(Vec3::Y, Vec3::Z);
        let placed = Placed::new(&cube.hull(), &Pose::new(at, upright.after(turn)));
        let b = placed.hull();
        let m = manifold(&triangle, &b, 0.0, tolerance(&triangle, &b)).unwrap();
        assert_eq!(m.points.len(), 1);
        assert!((m.normal - Vec3::NEG_Y).length_squared() < 1.0e-6, "{m:?}");
        assert!((m.points[0].separation + 0.017_106_8).abs() < 1.0e-5, "{m:?}");
    }
}
