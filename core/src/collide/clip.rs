//! From two touching faces to at most four contact points.
//!
//! The *reference* face gives the normal. The *incident* face of the other hull, the one at its deepest
//! vertex that looks most against the reference, is cut by the reference face's side planes (Sutherland and
//! Hodgman 1974):
//!
//! ```text
//!        incident          every edge of the polygon has a label: an edge of the incident loop or a side;
//!      .-----------.       a corner is named by the labels of the edges that meet in it
//!   ---+---.       |
//!      |   | <- side       what remains and is near the reference plane are the contacts
//!   ---+---'-------'
//! ```
//!
//! Features name vertices and edges, not the incident face, so they survive its change. Layout of the 32 bits:
//!
//! | bits | meaning |
//! |---|---|
//! | 30..32 | 0 round shapes and closest points, 1 reference face on A, 2 on B, 3 two edges |
//! | 28..30 | 0 incident vertex, 1 incident edge with side, 2 two sides |
//! | 21..28 | reference face |
//! | 18..21 | counts up where a name would occur twice (rounding only) |
//! | 0..18 | vertex; inside vertex, outside vertex and side; or side and side (6 bits each) |
//!
//! Two edges: edge of A in bits 8..16, edge of B in bits 0..8.

use super::distance::support;
use super::{Face, HULL_VERTICES_MAX, Hull, Manifold, ManifoldPoint, POINTS_MAX, Plane};
use crate::math::{Vec3, length, max};

/// Most corners of a polygon while it is cut: each side adds at most one.
pub const CORNERS_MAX: usize = 2 * HULL_VERTICES_MAX;
/// Labels from here on are sides of the reference face; below, edges of the incident loop.
pub const SIDE: u8 = 64;

/// Points within this fraction of the manifold's width of the deepest one count as equally deep.
const DEPTH_TIE: f32 = 1.0e-3;
/// The same for the corners of one face. A body on soft contacts tilts by about as much towards a corner that
/// is left out, and a choice that follows the tilt never comes to rest.
const LEVEL_TIE: f32 = 1.0e-2;
/// A point must beat another by this fraction: noise in the last bits shall not choose.
const CHOICE_TIE: f32 = 1.0e-3;
/// An incident face must look more against the reference by this (difference of cosines) than one before it.
const INCIDENT_TIE: f32 = 1.0e-4;
/// Features of made-up names differ by this.
const FEATURE_STEP: u32 = 1 << 18;

/// Which of the two shapes has the reference face.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reference {
    /// Shape A: the manifold's normal is the face's.
    A,
    /// Shape B: the manifold's normal is against the face's.
    B,
}

/// A corner of a polygon between two labelled edges.
#[derive(Clone, Copy, Debug)]
pub struct Corner {
    /// Metres, in the reference's frame.
    pub position: Vec3,
    /// Label of the edge that ends here.
    pub incoming: u8,
    /// Label of the edge that starts here.
    pub outgoing: u8,
}

/// A convex polygon.
pub type Polygon = heapless::Vec<Corner, CORNERS_MAX>;
/// Contacts before their reduction.
pub type Candidates = heapless::Vec<ManifoldPoint, CORNERS_MAX>;

/// A reference face and the hull that touches it. Both hulls are in one frame, which is the manifold's.
#[derive(Clone, Copy, Debug)]
pub struct FacePair<'a> {
    /// Hull with the reference face.
    pub reference: &'a Hull<'a>,
    /// Index of the reference face.
    pub face: usize,
    /// The other hull.
    pub incident: &'a Hull<'a>,
    /// Whose hull the reference is.
    pub side: Reference,
    /// How far beyond the sides a point may lie, metres: keeps equal stacked faces from being cut by noise.
    pub slack: f32,
}

impl FacePair<'_> {
    /// The manifold's normal: from A to B.
    pub fn normal(&self) -> Vec3 {
        let normal = self.reference.planes[self.face].normal;
        if self.side == Reference::A { normal } else { -normal }
    }
}

/// How the corners of a polygon get their names.
#[derive(Clone, Copy, Debug)]
pub struct Naming<'a> {
    /// Whose face the reference is.
    pub side: Reference,
    /// Index of the reference face.
    pub face: usize,
    /// Vertex indices of the incident face.
    pub incident: &'a [u8],
}

/// The feature of a contact of two edges, by their indices.
pub fn edge_feature(edge_a: usize, edge_b: usize) -> u32 {
    3 << 30 | (edge_a as u32 & 0xff) << 8 | (edge_b as u32 & 0xff)
}

/// A manifold of one point.
pub fn single(normal: Vec3, point: ManifoldPoint) -> Manifold {
    let mut points = heapless::Vec::new();
    let _ = points.push(point);
    Manifold { child: 0, normal, points, surface: 0 }
}

/// Contacts of a reference face with the other hull's incident face: `None` when the incident face has no
/// point over the reference face within `distance` (metres, along the normal).
pub fn face_manifold(pair: &FacePair<'_>, distance: f32) -> Option<Manifold> {
    let plane = pair.reference.planes[pair.face];
    let incident = face_loop(pair.incident, incident_face(pair.incident, plane.normal));
    let (mut first, mut second) = (Polygon::new(), Polygon::new());
    polygon_of(pair.incident.vertices, incident, &mut first);
    let (mut from, mut to) = (&mut first, &mut second);
    let sides = face_loop(pair.reference, pair.face);
    let mut tail = pair.reference.vertices[usize::from(sides[sides.len() - 1])];
    for (i, &vertex) in sides.iter().enumerate() {
        let head = pair.reference.vertices[usize::from(vertex)];
        let outward = (head - tail).cross(plane.normal);
        let offset = outward.dot(tail) + length(outward) * pair.slack;
        if cut(from, to, SIDE + i as u8, |point| outward.dot(point) - offset) {
            core::mem::swap(&mut from, &mut to);
        }
        tail = head;
    }
    let naming = Naming { side: pair.side, face: pair.face, incident };
    let mut near = Candidates::new();
    candidates(from, &plane, &naming, distance, &mut near);
    let points = reduce_face(&near, plane.normal);
    if points.is_empty() {
        None
    } else {
        Some(Manifold { child: 0, normal: pair.normal(), points, surface: 0 })
    }
}

/// Index of the face that looks most against `normal` among those around the vertex farthest against it.
///
/// On a pointed hull another face may look more against the normal and still be far from the contact.
pub fn incident_face(hull: &Hull<'_>, normal: Vec3) -> usize {
    let deepest = support(hull.vertices, -normal) as u8;
    let mut best = 0;
    let mut best_cosine = f32::INFINITY;
    for (i, plane) in hull.planes.iter().enumerate() {
        let cosine = plane.normal.dot(normal);
        if cosine < best_cosine - INCIDENT_TIE && face_loop(hull, i).contains(&deepest) {
            (best, best_cosine) = (i, cosine);
        }
    }
    best
}

/// Fills `out` with the corners of a face.
pub fn polygon_of(vertices: &[Vec3], face: &[u8], out: &mut Polygon) {
    let last = face.len().saturating_sub(1) as u8;
    for (i, &vertex) in face.iter().enumerate() {
        let outgoing = i as u8;
        let incoming = if i == 0 { last } else { outgoing - 1 };
        let _ = out.push(Corner { position: vertices[usize::from(vertex)], incoming, outgoing });
    }
}

/// Cuts away where `outside` is positive; the new edge gets the label `side`. False when there was nothing to
/// cut: then `out` is not touched.
#[inline]
pub fn cut(polygon: &Polygon, out: &mut Polygon, side: u8, outside: impl Fn(Vec3) -> f32) -> bool {
    if polygon.iter().all(|corner| outside(corner.position) <= 0.0) {
        return false;
    }
    out.clear();
    let Some(&last) = polygon.last() else { return false };
    let mut tail = last;
    let mut tail_height = outside(tail.position);
    for &head in polygon {
        let head_height = outside(head.position);
        if (tail_height <= 0.0) != (head_height <= 0.0) {
            let t = tail_height / (tail_height - head_height);
            let position = tail.position + (head.position - tail.position) * t;
            let edge = tail.outgoing;
            let (incoming, outgoing) = if tail_height <= 0.0 { (edge, side) } else { (side, edge) };
            // Rounding can bend a polygon of many corners so that it crosses a side twice: never overflow.
            let _ = out.push(Corner { position, incoming, outgoing });
        }
        if head_height <= 0.0 {
            let _ = out.push(head);
        }
        (tail, tail_height) = (head, head_height);
    }
    true
}

/// Adds the corners within `distance` of the reference plane to `out`, as contacts midway between the surfaces.
#[inline]
pub fn candidates(
    polygon: &Polygon,
    plane: &Plane,
    naming: &Naming<'_>,
    distance: f32,
    out: &mut Candidates,
) {
    for corner in polygon {
        let separation = plane.distance(corner.position);
        if separation <= distance {
            let position = corner.position - plane.normal * (0.5 * separation);
            let _ = out.push(ManifoldPoint { position, separation, feature: naming.feature(corner) });
        }
    }
}

impl Naming<'_> {
    /// The feature of a corner.
    pub fn feature(&self, corner: &Corner) -> u32 {
        let kind: u32 = if self.side == Reference::A { 1 << 30 } else { 2 << 30 };
        let base = kind | (self.face as u32 & 0x7f) << 21;
        let (incoming, outgoing) = (corner.incoming, corner.outgoing);
        match (incoming < SIDE, outgoing < SIDE) {
            (true, true) => base | self.vertex(outgoing),
            (true, false) => base | 1 << 28 | self.crossing(incoming, incoming + 1, outgoing),
            (false, true) => base | 1 << 28 | self.crossing(outgoing + 1, outgoing, incoming),
            (false, false) => base | 2 << 28 | u32::from(incoming & 63) << 6 | u32::from(outgoing & 63),
        }
    }

    fn vertex(&self, corner: u8) -> u32 {
        let i = usize::from(corner);
        u32::from(self.incident[if i == self.incident.len() { 0 } else { i }] & 63)
    }

    fn crossing(&self, inside: u8, outside: u8, side: u8) -> u32 {
        self.vertex(inside) << 12 | self.vertex(outside) << 6 | u32::from(side & 63)
    }
}

/// At most four of the points, which carry about what all of them would: the deepest, the one farthest from it,
/// and those that widen the area most. Distances are taken across the unit vector `normal`. The features of the
/// result are distinct; equal ones are renamed by a fixed rule.
pub fn reduce(points: &[ManifoldPoint], normal: Vec3) -> heapless::Vec<ManifoldPoint, POINTS_MAX> {
    reduce_within(points, normal, DEPTH_TIE)
}

/// The same for the corners of one face, which lie in a plane: the first need not be quite the deepest.
pub fn reduce_face(points: &[ManifoldPoint], normal: Vec3) -> heapless::Vec<ManifoldPoint, POINTS_MAX> {
    reduce_within(points, normal, LEVEL_TIE)
}

fn reduce_within(
    points: &[ManifoldPoint],
    normal: Vec3,
    tie: f32,
) -> heapless::Vec<ManifoldPoint, POINTS_MAX> {
    let mut out = heapless::Vec::new();
    if points.len() <= POINTS_MAX {
        for &point in points {
            let _ = out.push(point);
        }
    } else {
        let chosen = choose(points, normal, tie);
        for i in chosen {
            let _ = out.push(points[i]);
        }
    }
    make_distinct(&mut out);
    out
}

/// Index of the greatest positive score; an earlier point wins unless it is beaten clearly.
fn best_of(count: usize, score: impl Fn(usize) -> f32) -> Option<usize> {
    let mut best = None;
    let mut best_score = 0.0;
    for i in 0..count {
        let s = score(i);
        if s > best_score * (1.0 + CHOICE_TIE) {
            (best, best_score) = (Some(i), s);
        }
    }
    best
}

fn choose(points: &[ManifoldPoint], normal: Vec3, tie: f32) -> heapless::Vec<usize, POINTS_MAX> {
    let mut deepest = f32::INFINITY;
    let mut width = 0.0;
    for point in points {
        deepest = if point.separation < deepest { point.separation } else { deepest };
        width = max(width, (point.position - points[0].position).length_squared());
    }
    let width = crate::math::sqrt(width);
    let enough = deepest + tie * width;
    let first = points.iter().position(|p| p.separation <= enough).unwrap_or(0);
    let across = |from: usize, to: usize| {
        let d = points[to].position - points[from].position;
        d - normal * d.dot(normal)
    };
    // Of points one over the other the deeper is wanted: height counts against a point.
    let height = |i: usize| points[i].separation - deepest;
    let mut chosen = heapless::Vec::new();
    let _ = chosen.push(first);
    let second = best_of(points.len(), |i| across(first, i).length_squared() - height(i) * height(i));
    let Some(second) = second else { return chosen };
    let _ = chosen.push(second);
    let weight = |i: usize| max(1.0 - height(i) / width, 0.5);
    let area = |i: usize, j: usize, k: usize| across(i, j).cross(across(i, k)).dot(normal);
    // Less than this is a line.
    let least = DEPTH_TIE * width * width;
    let third = best_of(points.len(), |k| area(first, second, k).abs() * weight(k) - least);
    let Some(third) = third else { return chosen };
    let _ = chosen.push(third);
    // What a fourth point adds lies outside of an edge of the triangle.
    let turn = if area(first, second, third) < 0.0 { -1.0 } else { 1.0 };
    let fourth = best_of(points.len(), |k| {
        let (x, y, z) = (area(first, second, k), area(second, third, k), area(third, first, k));
        max(-turn * x, max(-turn * y, -turn * z)) * weight(k) - least
    });
    if let Some(fourth) = fourth {
        let _ = chosen.push(fourth);
    }
    chosen
}

fn make_distinct(points: &mut heapless::Vec<ManifoldPoint, POINTS_MAX>) {
    for i in 1..points.len() {
        while points[..i].iter().any(|p| p.feature == points[i].feature) {
            points[i].feature = points[i].feature.wrapping_add(FEATURE_STEP);
        }
    }
}

/// Vertex indices of a face, counter-clockwise seen from outside.
#[inline]
pub fn face_loop<'a>(hull: &Hull<'a>, face: usize) -> &'a [u8] {
    let Face { first, count } = hull.faces[face];
    &hull.loops[usize::from(first)..usize::from(first) + usize::from(count)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{cos, sin};

    fn ring(count: usize, radius: f32, phase: f32) -> heapless::Vec<Vec3, HULL_VERTICES_MAX> {
        let angle = |i: usize| phase + 2.0 * crate::math::PI * i as f32 / count as f32;
        (0..count).map(|i| Vec3::new(radius * cos(angle(i)), radius * sin(angle(i)), 0.0)).collect()
    }

    #[test]
    fn largest_polygons_never_overflow_and_keep_distinct_names() {
        let loops: heapless::Vec<u8, 64> = (0..64).collect();
        let (inner, outer) = (ring(64, 1.0, 0.0), ring(64, 1.0, 0.049));
        let mut first = Polygon::new();
        let mut second = Polygon::new();
        polygon_of(&inner, &loops, &mut first);
        let (mut from, mut to) = (&mut first, &mut second);
        for i in 0..64 {
            let (tail, head) = (outer[i], outer[(i + 1) % 64]);
            let outward = (head - tail).cross(Vec3::Z);
            if cut(from, to, SIDE + i as u8, |p| outward.dot(p - tail)) {
                core::mem::swap(&mut from, &mut to);
            }
        }
        assert_eq!(from.len(), 128);
        let naming = Naming { side: Reference::A, face: 123, incident: &loops };
        let plane = Plane { normal: Vec3::Z, offset: 0.0 };
        let mut all = Candidates::new();
        candidates(from, &plane, &naming, 0.0, &mut all);
        for (i, p) in all.iter().enumerate() {
            assert!(all[..i].iter().all(|q| q.feature != p.feature));
        }
        let four = reduce(&all, Vec3::Z);
        assert_eq!(four.len(), 4);
        let (d, e) = (four[0].position - four[1].position, four[2].position - four[3].position);
        assert!(0.5 * length(d.cross(e)) > 1.9, "nearly the square in the circle: {four:?}");
    }

    #[test]
    fn reduction_keeps_the_deepest_and_renames_equal_features() {
        let mut points = Candidates::new();
        for (i, p) in ring(9, 2.0, 0.1).iter().enumerate() {
            let separation = if i == 5 { -0.5 } else { -0.01 };
            points.push(ManifoldPoint { position: *p, separation, feature: 7 }).unwrap();
        }
        let out = reduce(&points, Vec3::Z);
        assert_eq!(out[0].separation, -0.5);
        for (i, p) in out.iter().enumerate() {
            assert!(out[..i].iter().all(|q| q.feature != p.feature));
        }
    }

    #[test]
    fn points_on_a_line_give_its_ends() {
        let points: heapless::Vec<ManifoldPoint, 8> = (0..8)
            .map(|i| ManifoldPoint { position: Vec3::X * i as f32, separation: 0.0, feature: i })
            .collect();
        let out = reduce(&points, Vec3::Z);
        assert_eq!(out.iter().map(|p| p.feature).collect::<heapless::Vec<_, 4>>(), [0, 7]);
    }
}
