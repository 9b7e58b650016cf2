//! Checks of a mesh, and which triangles share an edge.
//!
//! Corners are compared by position, not by index: files often repeat a vertex for each triangle. Edges (and
//! triangles) get a key, the hash of their corners above and their number below; sorting the keys brings equal ones
//! together, and each run of one hash is then sorted by the positions themselves.

use super::Triangle;
use crate::collide::hull;
use crate::collide::vector64::{cross, difference, length, to_f64};
use crate::math::Vec3;
use core::cmp::Ordering;
use core::fmt;

/// Greatest coordinate of a mesh, metres.
pub const COORDINATE_MAX: f32 = hull::COORDINATE_MAX;
/// Most triangles: edges are numbered with 32 bits.
const TRIANGLES_MAX: usize = 1 << 30;
/// Least height of a triangle as a fraction of its longest edge: less has no normal in f32.
const HEIGHT_MIN: f64 = 1.0e-6;
/// Least longest edge of a triangle, metres.
const EDGE_MIN: f64 = 1.0e-6;

/// Why triangles make no mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum MeshError {
    /// No triangles. Remedy: add no mesh.
    Empty,
    /// More than 2^30 triangles. Remedy: split the mesh.
    TooManyTriangles,
    /// A coordinate is infinite or not a number. Remedy: mend this vertex.
    NotFinite {
        /// The first such vertex.
        vertex: u32,
    },
    /// A coordinate beyond [`COORDINATE_MAX`]. Remedy: check the unit (metres), or split the mesh.
    TooLarge {
        /// The first such vertex.
        vertex: u32,
    },
    /// A triangle names a vertex that does not exist.
    IndexOutOfRange {
        /// The first such triangle.
        triangle: u32,
    },
    /// A triangle without area, or nearly: its corners coincide or lie on a line. Remedy: leave it out.
    ZeroArea {
        /// The first such triangle.
        triangle: u32,
    },
    /// Two triangles with the same corners, in any order. Remedy: leave one out; meshes are two-sided.
    Duplicate {
        /// The earlier one.
        first: u32,
        /// The later one.
        second: u32,
    },
}

impl fmt::Display for MeshError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Empty => write!(f, "mesh has no triangles"),
            Self::TooManyTriangles => write!(f, "mesh has more than {TRIANGLES_MAX} triangles"),
            Self::NotFinite { vertex } => write!(f, "mesh vertex {vertex} is not finite"),
            Self::TooLarge { vertex } => {
                write!(f, "mesh vertex {vertex} is farther than {COORDINATE_MAX} m from the origin")
            }
            Self::IndexOutOfRange { triangle } => write!(f, "mesh triangle {triangle} names no vertex"),
            Self::ZeroArea { triangle } => write!(f, "mesh triangle {triangle} has no area"),
            Self::Duplicate { first, second } => {
                write!(f, "mesh triangles {first} and {second} are the same")
            }
        }
    }
}

impl core::error::Error for MeshError {}

/// Length of the scratch that [`validate`] and [`connect`] need.
pub const fn scratch_len(triangles: usize) -> usize {
    3 * triangles
}

/// Checks a mesh. `across` is not looked at; `scratch` has at least [`scratch_len`] words of no defined content.
///
/// # Panics
/// When `scratch` is too short.
pub fn validate(vertices: &[Vec3], triangles: &[Triangle], scratch: &mut [u64]) -> Result<(), MeshError> {
    if triangles.is_empty() {
        return Err(MeshError::Empty);
    }
    if triangles.len() > TRIANGLES_MAX {
        return Err(MeshError::TooManyTriangles);
    }
    for (i, vertex) in vertices.iter().enumerate() {
        if !vertex.is_finite() {
            return Err(MeshError::NotFinite { vertex: i as u32 });
        }
        let v = vertex.abs();
        if v.x > COORDINATE_MAX || v.y > COORDINATE_MAX || v.z > COORDINATE_MAX {
            return Err(MeshError::TooLarge { vertex: i as u32 });
        }
    }
    for (i, triangle) in triangles.iter().enumerate() {
        if triangle.vertices.iter().any(|&vertex| vertex as usize >= vertices.len()) {
            return Err(MeshError::IndexOutOfRange { triangle: i as u32 });
        }
        if !has_area(triangle.vertices.map(|vertex| vertices[vertex as usize])) {
            return Err(MeshError::ZeroArea { triangle: i as u32 });
        }
    }
    find_duplicate(vertices, triangles, scratch)
}

/// Fills in, for each edge of each triangle, what lies across it: see [`Triangle::across`]. The mesh is valid, but
/// any winding will do. `scratch` has at least [`scratch_len`] words of no defined content.
///
/// # Panics
/// When `scratch` is too short or an index out of range.
pub fn connect(vertices: &[Vec3], triangles: &mut [Triangle], scratch: &mut [u64]) {
    let keys = &mut scratch[..scratch_len(triangles.len())];
    for (i, key) in keys.iter_mut().enumerate() {
        *key = key_of(edge_corners(vertices, triangles, i as u32), i as u32);
    }
    keys.sort_unstable();
    for run in keys.chunk_by_mut(|a, b| a >> 32 == b >> 32) {
        let corners = |key: &u64| edge_corners(vertices, triangles, *key as u32);
        run.sort_unstable_by(|a, b| corners(a).cmp(&corners(b)).then(a.cmp(b)));
        let mut start = 0;
        while start < run.len() {
            let of_start = edge_corners(vertices, triangles, run[start] as u32);
            let same = |key: &&u64| edge_corners(vertices, triangles, **key as u32) == of_start;
            let count = run[start..].iter().take_while(same).count();
            join(triangles, &run[start..start + count]);
            start += count;
        }
    }
}

/// Writes what lies across the edges of a group, which all run between the same two points.
fn join(triangles: &mut [Triangle], group: &[u64]) {
    let place = |key: u64| ((key as u32 / 3) as usize, (key as u32 % 3) as usize);
    let opposite = |triangle: &Triangle, edge: usize| triangle.vertices[(edge + 2) % 3];
    match *group {
        [a, b] => {
            let ((ta, ea), (tb, eb)) = (place(a), place(b));
            triangles[ta].across[ea] = opposite(&triangles[tb], eb);
            triangles[tb].across[eb] = opposite(&triangles[ta], ea);
        }
        _ => {
            for &key in group {
                let (triangle, edge) = place(key);
                triangles[triangle].across[edge] = u32::MAX;
            }
        }
    }
}

fn find_duplicate(vertices: &[Vec3], triangles: &[Triangle], scratch: &mut [u64]) -> Result<(), MeshError> {
    let keys = &mut scratch[..triangles.len()];
    let corners = |key: u64| triangle_corners(vertices, &triangles[key as u32 as usize]);
    for (i, key) in keys.iter_mut().enumerate() {
        *key = key_of(triangle_corners(vertices, &triangles[i]), i as u32);
    }
    keys.sort_unstable();
    // The one with the least second triangle is reported, whatever the hashes are.
    let mut found: Option<(u32, u32)> = None;
    for run in keys.chunk_by_mut(|a, b| a >> 32 == b >> 32) {
        run.sort_unstable_by(|a, b| corners(*a).cmp(&corners(*b)).then(a.cmp(b)));
        for pair in run.windows(2) {
            let (first, second) = (pair[0] as u32, pair[1] as u32);
            if corners(pair[0]) == corners(pair[1]) && found.is_none_or(|(_, least)| second < least) {
                found = Some((first, second));
            }
        }
    }
    match found {
        Some((first, second)) => Err(MeshError::Duplicate { first, second }),
        None => Ok(()),
    }
}

/// The corners of edge `edge % 3` of triangle `edge / 3`, the same for both directions.
fn edge_corners(vertices: &[Vec3], triangles: &[Triangle], edge: u32) -> [Point; 2] {
    let triangle = &triangles[(edge / 3) as usize];
    let i = (edge % 3) as usize;
    let mut ends =
        [triangle.vertices[i], triangle.vertices[(i + 1) % 3]].map(|v| Point::of(vertices[v as usize]));
    ends.sort_unstable();
    ends
}

/// The corners of a triangle, the same for every order.
fn triangle_corners(vertices: &[Vec3], triangle: &Triangle) -> [Point; 3] {
    let mut corners = triangle.vertices.map(|v| Point::of(vertices[v as usize]));
    corners.sort_unstable();
    corners
}

/// Hash of the corners in the upper half, the number in the lower: unique.
fn key_of<const N: usize>(corners: [Point; N], number: u32) -> u64 {
    let mut hash = 0_u64;
    for Point(bits) in corners {
        for word in bits {
            hash = (hash ^ u64::from(word)).wrapping_mul(0x9e37_79b9_7f4a_7c15);
            hash ^= hash >> 29;
        }
    }
    hash & !u64::from(u32::MAX) | u64::from(number)
}

/// A position that can be compared: its bits, with one zero.
#[derive(Clone, Copy, PartialEq, Eq)]
struct Point([u32; 3]);

impl Point {
    fn of(v: Vec3) -> Self {
        // -0 + 0 = +0.
        Self([(v.x + 0.0).to_bits(), (v.y + 0.0).to_bits(), (v.z + 0.0).to_bits()])
    }
}

impl Ord for Point {
    fn cmp(&self, other: &Self) -> Ordering {
        self.0.cmp(&other.0)
    }
}

impl PartialOrd for Point {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

pub fn has_area(corners: [Vec3; 3]) -> bool {
    let [a, b, c] = corners.map(to_f64);
    let (ab, ac, bc) = (difference(b, a), difference(c, a), difference(c, b));
    let mut longest = 0.0;
    for edge in [length(ab), length(ac), length(bc)] {
        longest = if edge > longest { edge } else { longest };
    }
    longest > EDGE_MIN && length(cross(ab, ac)) > HEIGHT_MIN * longest * longest
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use std::vec;
    use std::vec::Vec;

    fn triangles(indices: &[[u32; 3]]) -> Vec<Triangle> {
        indices.iter().map(|&vertices| Triangle { vertices, across: [7; 3] }).collect()
    }

    fn connected(vertices: &[Vec3], indices: &[[u32; 3]]) -> Vec<[u32; 3]> {
        let mut triangles = triangles(indices);
        let mut scratch = vec![0; scratch_len(triangles.len())];
        assert_eq!(validate(vertices, &triangles, &mut scratch), Ok(()));
        connect(vertices, &mut triangles, &mut scratch);
        triangles.iter().map(|t| t.across).collect()
    }

    const NONE: u32 = u32::MAX;
    const SQUARE: [Vec3; 5] = [Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0), Vec3::Y, Vec3::Z];

    #[test]
    fn neighbours_by_any_winding() {
        assert_eq!(connected(&SQUARE, &[[0, 1, 2], [0, 2, 3]]), [[NONE, NONE, 3], [1, NONE, NONE]]);
        assert_eq!(connected(&SQUARE, &[[0, 1, 2], [2, 0, 3]]), [[NONE, NONE, 3], [1, NONE, NONE]]);
    }

    #[test]
    fn more_than_two_triangles_have_no_neighbour() {
        let across = connected(&SQUARE, &[[0, 1, 2], [0, 2, 3], [0, 2, 4]]);
        assert_eq!(across, [[NONE; 3]; 3]);
    }

    #[test]
    fn repeated_vertices_are_one() {
        let mut vertices = SQUARE.to_vec();
        vertices.extend([Vec3::new(-0.0, 0.0, -0.0), Vec3::new(1.0, 1.0, 0.0)]);
        let across = connected(&vertices, &[[0, 1, 2], [5, 6, 3]]);
        assert_eq!(across, [[NONE, NONE, 3], [1, NONE, NONE]]);
    }

    #[test]
    fn closed_surface_has_all_neighbours() {
        let corner = |i: u32, bit: u32| if i & bit == 0 { 0.0 } else { 1.0 };
        let vertices: Vec<Vec3> =
            (0..8).map(|i| Vec3::new(corner(i, 1), corner(i, 2), corner(i, 4))).collect();
        let quads = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
        let indices: Vec<[u32; 3]> = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [c, a, d]]).collect();
        for (across, triangle) in connected(&vertices, &indices).iter().zip(&indices) {
            for (i, &vertex) in across.iter().enumerate() {
                assert!(vertex < 8 && !triangle.contains(&vertex));
                // The vertex makes a triangle with the edge.
                let edge = [triangle[i], triangle[(i + 1) % 3]];
                assert!(indices.iter().any(|t| t.contains(&vertex) && edge.iter().all(|v| t.contains(v))));
            }
        }
    }

    #[test]
    fn refuses_bad_meshes() {
        let check = |vertices: &[Vec3], indices: &[[u32; 3]]| {
            validate(vertices, &triangles(indices), &mut vec![0; 99])
        };
        let mut bad = SQUARE;
        assert_eq!(check(&bad, &[]), Err(MeshError::Empty));
        assert_eq!(check(&bad, &[[0, 1, 2], [0, 5, 2]]), Err(MeshError::IndexOutOfRange { triangle: 1 }));
        assert_eq!(check(&bad, &[[0, 1, 2], [0, 3, 3]]), Err(MeshError::ZeroArea { triangle: 1 }));
        let twice = Err(MeshError::Duplicate { first: 1, second: 3 });
        assert_eq!(check(&bad, &[[0, 1, 2], [0, 2, 3], [0, 1, 4], [2, 0, 3]]), twice);
        bad[2] = Vec3::new(2.0, 0.0, 0.0);
        assert_eq!(check(&bad, &[[0, 1, 2]]), Err(MeshError::ZeroArea { triangle: 0 }));
        bad[2] = Vec3::new(2.0e5, 0.0, 0.0);
        assert_eq!(check(&bad, &[[0, 1, 3]]), Err(MeshError::TooLarge { vertex: 2 }));
        bad[1] = Vec3::NAN;
        assert_eq!(check(&bad, &[[0, 1, 2]]), Err(MeshError::NotFinite { vertex: 1 }));
    }
}
