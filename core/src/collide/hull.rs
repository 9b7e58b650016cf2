//! Convex hulls of points, built without allocation.
//!
//! ```text
//! points -> tetrahedron of extremes -> grow by the highest outside point (growth.rs)
//!        -> coplanar triangles become polygons (merge.rs) -> tables -> checks
//! ```
//!
//! The hull is exact up to [`TOLERANCE`] of its extent: a point that lies no farther outside is taken to lie on
//! the surface, and a face may be uneven by as much, so that the noise of rotated or exported coordinates gives no
//! slivers. Nothing else is simplified: points that need more than [`HULL_VERTICES_MAX`] vertices are an error.
//!
//! Invariants of the result: the corners are input points; faces are simple polygons of at least three corners,
//! counter-clockwise from outside; every edge has one face on each side; vertices - edges + faces = 2; no input
//! point lies more than four tolerances above a face. The result depends on the points and their order alone.

mod growth;
mod merge;

use super::mass::MassProperties;
use super::vector64::{Vector, cross, difference, dot, length, to_f64, to_vec3};
use super::{Edge, Face, HULL_EDGES_MAX, HULL_FACES_MAX, HULL_VERTICES_MAX, Hull, Plane, Solid};
use crate::math::{Vec3, max, max_each, min_each};
use bytemuck::{Pod, Zeroable};
use core::fmt;
use growth::{FACETS, Growth, VERTICES};
use merge::Loop;

/// What counts as on the surface, as a fraction of the longest side of the points' box: 0.01 mm on 1 m, well below
/// what a contact resolves and well above the noise of f32.
pub const TOLERANCE: f32 = 1.0e-5;
/// The same, as a fraction of the greatest coordinate: a few roundings of a point far from the origin.
const TOLERANCE_OF_COORDINATE: f32 = 4.0e-7;
/// Least width and thickness in tolerances. Below, faces would be made of noise.
const THICKNESS_MIN: f64 = 10.0;
/// Least longest side of the points' box, metres.
pub const EXTENT_MIN: f32 = 1.0e-4;
/// Greatest coordinate, metres.
pub const COORDINATE_MAX: f32 = 1.0e5;

/// Entries of all loops of a hull: every edge twice.
const LOOPS_MAX: usize = 2 * HULL_EDGES_MAX;
const NONE: u8 = u8::MAX;

/// Why points have no usable hull.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum HullError {
    /// A coordinate is infinite or not a number. Remedy: mend the point of this index.
    NotFinite {
        /// The first such point.
        index: u32,
    },
    /// Fewer than four points. Remedy: give at least four that do not lie in a plane.
    TooFewPoints,
    /// The points lie in a plane, on a line or in a point, or nearly: thinner than 1e-4 of their extent. Remedy:
    /// give the hull some thickness.
    Flat,
    /// Smaller than [`EXTENT_MIN`]. Remedy: check the unit (metres).
    TooSmall,
    /// A coordinate beyond [`COORDINATE_MAX`]. Remedy: check the unit (metres), or move the origin.
    TooLarge,
    /// The hull needs more than [`HULL_VERTICES_MAX`] vertices. Remedy: simplify the points.
    TooManyVertices,
    /// The points are too irregular to make clean faces. Seen on no input so far. Remedy: move points apart that
    /// nearly coincide.
    Irregular,
}

impl fmt::Display for HullError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotFinite { index } => write!(f, "hull point {index} is not finite"),
            Self::TooFewPoints => write!(f, "a hull needs at least 4 points"),
            Self::Flat => write!(f, "hull points lie in a plane or nearly"),
            Self::TooSmall => write!(f, "hull is smaller than {EXTENT_MIN} m"),
            Self::TooLarge => write!(f, "hull point is farther than {COORDINATE_MAX} m from the origin"),
            Self::TooManyVertices => write!(f, "hull needs more than {HULL_VERTICES_MAX} vertices"),
            Self::Irregular => write!(f, "hull points give no clean faces"),
        }
    }
}

impl core::error::Error for HullError {}

/// The tables of a hull.
#[derive(Clone, Debug)]
pub struct HullTables {
    /// Corners, metres.
    pub vertices: heapless::Vec<Vec3, HULL_VERTICES_MAX>,
    /// One outward plane for each face.
    pub planes: heapless::Vec<Plane, HULL_FACES_MAX>,
    /// Runs of `loops`.
    pub faces: heapless::Vec<Face, HULL_FACES_MAX>,
    /// Vertex indices of all faces.
    pub loops: heapless::Vec<u8, LOOPS_MAX>,
    /// Every edge once.
    pub edges: heapless::Vec<Edge, HULL_EDGES_MAX>,
    /// Center of the volume, metres.
    pub center: Vec3,
}

impl HullTables {
    /// The tables as a hull.
    pub fn view(&self) -> Hull<'_> {
        Hull {
            vertices: &self.vertices,
            planes: &self.planes,
            faces: &self.faces,
            loops: &self.loops,
            edges: &self.edges,
            center: self.center,
        }
    }
}

/// A convex hull, tables and all.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(crate) struct HullRow {
    pub vertices: [Vec3; HULL_VERTICES_MAX],
    pub planes: [Plane; HULL_FACES_MAX],
    pub faces: [Face; HULL_FACES_MAX],
    pub loops: [u8; 2 * HULL_EDGES_MAX],
    pub edges: [Edge; HULL_EDGES_MAX],
    pub center: Vec3,
    /// Of the farthest vertex from the origin, m2.
    pub radius_squared: f32,
    pub vertex_count: u32,
    pub face_count: u32,
    pub loop_count: u32,
    pub edge_count: u32,
}

impl HullRow {
    pub(crate) fn view(&self) -> Hull<'_> {
        Hull {
            vertices: &self.vertices[..self.vertex_count as usize],
            planes: &self.planes[..self.face_count as usize],
            faces: &self.faces[..self.face_count as usize],
            loops: &self.loops[..self.loop_count as usize],
            edges: &self.edges[..self.edge_count as usize],
            center: self.center,
        }
    }
}

/// Builds the convex hull of any number of points, in any order, with duplicates. The time is about that of
/// reading the points once for each triangle ever made: some hundred times.
pub fn build(points: &[Vec3]) -> Result<HullTables, HullError> {
    let tolerance = measure(points)?;
    let corners = extremes(points, THICKNESS_MIN * tolerance).ok_or(HullError::Flat)?;
    let grown = Growth::of(points, corners, tolerance)?;
    let faces = merge::faces(&grown, tolerance).ok_or(HullError::Irregular)?;
    let tables = tabulate(&grown.vertices, &faces)?;
    let covers = |point: &Vec3| {
        let above = |plane: &Plane| dot(to_f64(plane.normal), to_f64(*point)) - f64::from(plane.offset);
        tables.planes.iter().all(|plane| above(plane) <= 4.0 * tolerance)
    };
    if points.iter().all(covers) { Ok(tables) } else { Err(HullError::Irregular) }
}

/// Checks the points one by one and returns the tolerance, metres.
fn measure(points: &[Vec3]) -> Result<f64, HullError> {
    if let Some(index) = points.iter().position(|point| !point.is_finite()) {
        return Err(HullError::NotFinite { index: index as u32 });
    }
    let [first, .., _] = points else { return Err(HullError::TooFewPoints) };
    if points.len() < 4 {
        return Err(HullError::TooFewPoints);
    }
    let (mut low, mut high) = (*first, *first);
    for &point in points {
        (low, high) = (min_each(low, point), max_each(high, point));
    }
    let greatest = |v: Vec3| max(v.x, max(v.y, v.z));
    let coordinate = greatest(max_each(high.abs(), low.abs()));
    if coordinate > COORDINATE_MAX {
        return Err(HullError::TooLarge);
    }
    let extent = greatest(high - low);
    if extent < EXTENT_MIN {
        return Err(HullError::TooSmall);
    }
    Ok(f64::from(max(TOLERANCE * extent, TOLERANCE_OF_COORDINATE * coordinate)))
}

/// Four points that span a tetrahedron; none when they would be less than `thickness` apart.
fn extremes(points: &[Vec3], thickness: f64) -> Option<[Vector; 4]> {
    let key = |p: &Vec3| (p.x, p.y, p.z);
    // The least point in lexicographic order is a corner of the hull, never a point within a face.
    let least = points.iter().fold(points[0], |least, p| if key(p) < key(&least) { *p } else { least });
    let a = to_f64(least);
    let (b, span) = farthest(points, |p| length(difference(p, a)));
    if span < thickness {
        return None;
    }
    let along = difference(b, a).map(|x| x / span);
    let (c, width) = farthest(points, |p| length(cross(along, difference(p, a))));
    if width < thickness {
        return None;
    }
    let normal = cross(along, difference(c, a)).map(|x| x / width);
    let (d, height) = farthest(points, |p| dot(normal, difference(p, a)).abs());
    (height >= thickness).then_some([a, b, c, d])
}

/// The first point with the greatest measure, and the measure.
fn farthest(points: &[Vec3], measure: impl Fn(Vector) -> f64) -> (Vector, f64) {
    let mut best = ([0.0; 3], -1.0);
    for &point in points {
        let point = to_f64(point);
        let distance = measure(point);
        if distance > best.1 {
            best = (point, distance);
        }
    }
    best
}

/// Numbers the vertices that faces use and fills the tables.
fn tabulate(
    points: &heapless::Vec<Vector, VERTICES>,
    loops: &heapless::Vec<Loop, FACETS>,
) -> Result<HullTables, HullError> {
    let mut tables = HullTables {
        vertices: heapless::Vec::new(),
        planes: heapless::Vec::new(),
        faces: heapless::Vec::new(),
        loops: heapless::Vec::new(),
        edges: heapless::Vec::new(),
        center: Vec3::ZERO,
    };
    let mut number = [NONE; VERTICES];
    for (i, &point) in points.iter().enumerate() {
        if loops.iter().flatten().any(|&corner| usize::from(corner) == i) {
            number[i] = tables.vertices.len() as u8;
            tables.vertices.push(to_vec3(point)).map_err(|_| HullError::TooManyVertices)?;
        }
    }
    for corners in loops {
        // With V vertices numbered, Euler's formula bounds what follows; a surface that is none is refused.
        let first = tables.loops.len() as u16;
        let face = Face { first, count: corners.len() as u16 };
        tables.faces.push(face).map_err(|_| HullError::Irregular)?;
        tables.planes.push(plane_of(points, corners)).map_err(|_| HullError::Irregular)?;
        for &corner in corners {
            tables.loops.push(number[usize::from(corner)]).map_err(|_| HullError::Irregular)?;
        }
    }
    tables.edges = edges_of(&tables).ok_or(HullError::Irregular)?;
    tables.center = center_of(&tables);
    Ok(tables)
}

/// The plane of a polygon that need not be quite even: normal by Newell's sum, through the mean of the corners.
fn plane_of(points: &heapless::Vec<Vector, VERTICES>, corners: &Loop) -> Plane {
    let corner = |i: usize| points[usize::from(corners[i % corners.len()])];
    let base = corner(0);
    let mut sum = [0.0; 3];
    for i in 1..corners.len() - 1 {
        let c = cross(difference(corner(i), base), difference(corner(i + 1), base));
        sum = [sum[0] + c[0], sum[1] + c[1], sum[2] + c[2]];
    }
    let size = length(sum);
    let normal = to_vec3(sum.map(|x| x / size));
    // Measured with the rounded normal, relative to a corner.
    let mut offset = 0.0;
    for i in 0..corners.len() {
        offset += dot(to_f64(normal), corner(i));
    }
    Plane { normal, offset: (offset / corners.len() as f64) as f32 }
}

/// Every edge once, in the order of the faces; none when the faces do not close.
fn edges_of(tables: &HullTables) -> Option<heapless::Vec<Edge, HULL_EDGES_MAX>> {
    let mut owner = [[NONE; HULL_VERTICES_MAX]; HULL_VERTICES_MAX];
    for (index, face) in tables.faces.iter().enumerate() {
        for (tail, head) in directed_edges(tables, face) {
            let slot = &mut owner[usize::from(tail)][usize::from(head)];
            if *slot != NONE || tail == head {
                return None;
            }
            *slot = index as u8;
        }
    }
    let mut edges = heapless::Vec::new();
    for (index, face) in tables.faces.iter().enumerate() {
        for (tail, head) in directed_edges(tables, face) {
            let right = owner[usize::from(head)][usize::from(tail)];
            if right == NONE {
                return None;
            }
            if tail < head {
                edges.push(Edge { tail, head, left: index as u8, right }).ok()?;
            }
        }
    }
    let is_closed = tables.vertices.len() + tables.faces.len() == edges.len() + 2;
    (is_closed && tables.faces.len() >= 4).then_some(edges)
}

fn directed_edges<'a>(tables: &'a HullTables, face: &Face) -> impl Iterator<Item = (u8, u8)> + use<'a> {
    let (first, count) = (usize::from(face.first), usize::from(face.count));
    let corners = &tables.loops[first..first + count];
    (0..count).map(move |i| (corners[i], corners[(i + 1) % count]))
}

/// Center of the volume. The tables' own center is set first, to a point inside.
fn center_of(tables: &HullTables) -> Vec3 {
    let mut sum = [0.0; 3];
    for &vertex in &tables.vertices {
        let v = to_f64(vertex);
        sum = [sum[0] + v[0], sum[1] + v[1], sum[2] + v[2]];
    }
    let inner = to_vec3(sum.map(|x| x / tables.vertices.len() as f64));
    MassProperties::of(&Solid::Hull(Hull { center: inner, ..tables.view() }), 1.0).center
}

#[cfg(test)]
mod tests;
