//! Triangles as the engine takes them: equal vertices made one, empty and repeated triangles dropped and
//! counted.

use std::fmt;

/// What an importer left out or mended. All zero when there was nothing to say.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Notes {
    /// Faces with fewer than three corners, dropped.
    pub degenerate_faces: usize,
    /// Faces whose outline crosses itself or encloses nothing, triangulated as well as can be.
    pub crossed_faces: usize,
    /// Triangles without area, dropped.
    pub empty_triangles: usize,
    /// Triangles with the same corners as an earlier one, dropped.
    pub repeated_triangles: usize,
    /// Vertices at the place of an earlier one, made one with it.
    pub merged_vertices: usize,
}

impl Notes {
    /// True when nothing was left out of the surface: merging vertices changes no triangle.
    pub fn is_clean(&self) -> bool {
        *self == Self { merged_vertices: self.merged_vertices, ..Self::default() }
    }
}

impl fmt::Display for Notes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let parts = [
            (self.degenerate_faces, "faces with fewer than 3 corners dropped"),
            (self.crossed_faces, "faces cross themselves"),
            (self.empty_triangles, "triangles without area dropped"),
            (self.repeated_triangles, "repeated triangles dropped"),
            (self.merged_vertices, "vertices merged"),
        ];
        let mut separator = "";
        for (count, text) in parts.into_iter().filter(|part| part.0 > 0) {
            write!(f, "{separator}{count} {text}")?;
            separator = ", ";
        }
        Ok(())
    }
}

/// Triangles with shared vertices.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Soup {
    /// Corners, metres, finite.
    pub vertices: Vec<[f32; 3]>,
    /// Indices of corners.
    pub triangles: Vec<[u32; 3]>,
    /// Index of each triangle's surface; empty when they have none.
    pub surfaces: Vec<u8>,
}

/// Least height of a triangle as a share of its longest edge: twice what the engine asks, so that rounding
/// never lets through what it refuses.
const HEIGHT_MIN: f64 = 2.0e-6;
/// Least longest edge, metres: twice what the engine asks.
const EDGE_MIN: f64 = 2.0e-6;

/// Makes equal vertices one, drops empty and repeated triangles and unused vertices. Keeps the order of what
/// stays.
pub(super) fn clean(soup: Soup, notes: &mut Notes) -> Soup {
    let (same, merged) = merge(&soup.vertices);
    notes.merged_vertices += merged;
    let mut kept: Vec<[u32; 3]> = Vec::with_capacity(soup.triangles.len());
    let mut surfaces = Vec::with_capacity(soup.surfaces.len());
    for (index, triangle) in soup.triangles.into_iter().enumerate() {
        let triangle = triangle.map(|vertex| same[vertex as usize]);
        if is_empty(triangle.map(|vertex| soup.vertices[vertex as usize])) {
            notes.empty_triangles += 1;
        } else {
            kept.push(triangle);
            surfaces.extend(soup.surfaces.get(index));
        }
    }
    let repeated = repeats(&kept);
    notes.repeated_triangles += repeated.iter().filter(|&&is| is).count();
    let mut index = 0;
    kept.retain(|_| {
        index += 1;
        !repeated[index - 1]
    });
    let mut index = 0;
    surfaces.retain(|_| {
        index += 1;
        !repeated[index - 1]
    });
    Soup { surfaces, ..compact(&soup.vertices, kept) }
}

/// For each vertex the first at the same place, and how many are not the first.
fn merge(vertices: &[[f32; 3]]) -> (Vec<u32>, usize) {
    // Adding zero makes -0 and +0 one place.
    let place = |index: u32| vertices[index as usize].map(|x| (x + 0.0).to_bits());
    let mut order: Vec<u32> = (0..vertices.len() as u32).collect();
    order.sort_unstable_by_key(|&index| (place(index), index));
    let mut same: Vec<u32> = (0..vertices.len() as u32).collect();
    let mut merged = 0;
    for pair in order.windows(2) {
        if place(pair[0]) == place(pair[1]) {
            same[pair[1] as usize] = same[pair[0] as usize];
            merged += 1;
        }
    }
    (same, merged)
}

fn is_empty(corners: [[f32; 3]; 3]) -> bool {
    let [a, b, c] = corners.map(|corner| corner.map(f64::from));
    let sub = |p: [f64; 3], q: [f64; 3]| [p[0] - q[0], p[1] - q[1], p[2] - q[2]];
    let dot = |p: [f64; 3], q: [f64; 3]| p[0] * q[0] + p[1] * q[1] + p[2] * q[2];
    let (u, v, w) = (sub(b, a), sub(c, a), sub(c, b));
    let cross = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    let longest = dot(u, u).max(dot(v, v)).max(dot(w, w));
    // Written so that an overflow to not-a-number counts as empty.
    !(longest > EDGE_MIN * EDGE_MIN && dot(cross, cross).sqrt() > HEIGHT_MIN * longest)
}

/// For each triangle whether an earlier one has the same corners, in whatever order: meshes are two-sided.
fn repeats(triangles: &[[u32; 3]]) -> Vec<bool> {
    let key = |index: u32| {
        let mut corners = triangles[index as usize];
        corners.sort_unstable();
        corners
    };
    let mut order: Vec<u32> = (0..triangles.len() as u32).collect();
    order.sort_unstable_by_key(|&index| (key(index), index));
    let mut repeated = vec![false; triangles.len()];
    for pair in order.windows(2) {
        repeated[pair[1] as usize] = key(pair[0]) == key(pair[1]);
    }
    repeated
}

/// Drops vertices that no triangle has.
fn compact(vertices: &[[f32; 3]], mut triangles: Vec<[u32; 3]>) -> Soup {
    let mut used = vec![false; vertices.len()];
    triangles.iter().flatten().for_each(|&vertex| used[vertex as usize] = true);
    let mut renamed = vec![0u32; vertices.len()];
    let mut kept = Vec::new();
    for (index, vertex) in vertices.iter().enumerate().filter(|(index, _)| used[*index]) {
        renamed[index] = kept.len() as u32;
        kept.push(*vertex);
    }
    for vertex in triangles.iter_mut().flatten() {
        *vertex = renamed[*vertex as usize];
    }
    Soup { vertices: kept, triangles, surfaces: Vec::new() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn drops_and_merges() {
        let soup = Soup {
            vertices: vec![
                [9.0, 9.0, 9.0],
                [0.0, 0.0, 0.0],
                [1.0, 0.0, 0.0],
                [0.0, 1.0, 0.0],
                [-0.0, 0.0, 0.0],
                [1.0, 1.0, 0.0],
                [2.0, 0.0, 0.0],
            ],
            triangles: vec![[1, 2, 3], [3, 2, 4], [2, 5, 3], [1, 2, 6], [1, 4, 2], [3, 1, 2]],
            surfaces: vec![4, 0, 2, 0, 0, 1],
        };
        let mut notes = Notes::default();
        let soup = clean(soup, &mut notes);
        assert_eq!(soup.vertices, [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]]);
        assert_eq!(soup.triangles, [[0, 1, 2], [1, 3, 2]]);
        assert_eq!(soup.surfaces, [4, 2]);
        let expected =
            Notes { empty_triangles: 2, repeated_triangles: 2, merged_vertices: 1, ..Notes::default() };
        assert_eq!(notes, expected);
        assert!(!notes.is_clean());
        let text = "2 triangles without area dropped, 2 repeated triangles dropped, 1 vertices merged";
        assert_eq!(notes.to_string(), text);
    }

    #[test]
    fn slivers_are_empty() {
        assert!(is_empty([[0.0; 3], [1000.0, 0.0, 0.0], [500.0, 5.0e-4, 0.0]]));
        assert!(!is_empty([[0.0; 3], [1000.0, 0.0, 0.0], [500.0, 5.0e-2, 0.0]]));
        assert!(is_empty([[0.0; 3], [1.0e-6, 0.0, 0.0], [0.0, 1.0e-6, 0.0]]));
        assert!(is_empty([[f32::MAX; 3], [-f32::MAX; 3], [f32::MAX; 3]]));
    }
}
