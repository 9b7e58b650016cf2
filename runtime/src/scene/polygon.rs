//! Polygons cut into triangles.
//!
//! A face is projected along the greatest axis of its Newell normal, which drops one coordinate and rounds
//! nothing, and ear-clipped there by `earcut`, in f64. The triangles keep the face's winding. What a fan gets
//! wrong (a concave face) comes out right; a face that is not flat gets some triangulation of its outline;
//! what crosses itself gets as good a cover as there is, and is counted.

use super::clean::Notes;
use earcut::Earcut;

/// Relative difference between the area of a polygon and the sum of its triangles that rounding explains.
const AREA_TOLERANCE: f64 = 1.0e-6;

/// Cuts polygons; keeps its memory from one to the next.
#[derive(Default)]
pub(super) struct Clipper {
    earcut: Earcut<f64>,
    flat: Vec<[f64; 2]>,
    cuts: Vec<u32>,
}

impl Clipper {
    /// Appends the triangles of the polygon `corners` (indices of finite `vertices`, in order) to
    /// `triangles`.
    pub(super) fn clip(
        &mut self,
        vertices: &[[f32; 3]],
        corners: &[u32],
        triangles: &mut Vec<[u32; 3]>,
        notes: &mut Notes,
    ) {
        if corners.len() < 3 {
            notes.degenerate_faces += 1;
            return;
        }
        if let [a, b, c] = *corners {
            triangles.push([a, b, c]);
            return;
        }
        let point = |corner: u32| vertices[corner as usize].map(f64::from);
        let normal = newell(corners.iter().map(|&corner| point(corner)));
        let Some((u, v)) = plane(normal) else {
            // No area to speak of: on a line, or as much left as right, like a bow-tie. Its fan covers what
            // there is; the cleaning drops empty triangles.
            notes.crossed_faces += 1;
            triangles.extend(corners[1..].windows(2).map(|pair| [corners[0], pair[0], pair[1]]));
            return;
        };
        self.flat.clear();
        self.flat.extend(corners.iter().map(|&corner| [point(corner)[u], point(corner)[v]]));
        self.earcut.earcut_slice::<u32>(&self.flat, &[], &mut self.cuts);
        if self.area_is_wrong() {
            notes.crossed_faces += 1;
        }
        // Counter-clockwise in the projection along the normal is the face's own winding.
        let corner = |cut: u32| corners[cut as usize];
        for cut in self.cuts.chunks_exact(3) {
            let (a, b, c) = (cut[0], cut[1], cut[2]);
            let [a, b, c] = if self.signed_area([a, b, c]) < 0.0 { [a, c, b] } else { [a, b, c] };
            triangles.push([corner(a), corner(b), corner(c)]);
        }
    }

    /// Twice the area of a triangle of the projection, positive when it runs counter-clockwise.
    fn signed_area(&self, [a, b, c]: [u32; 3]) -> f64 {
        let [a, b, c] = [a, b, c].map(|cut| self.flat[cut as usize]);
        (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
    }

    /// True when the triangles do not cover as much as the polygon's outline encloses: it crosses itself.
    fn area_is_wrong(&self) -> bool {
        let mut outline = 0.0;
        let mut spread = 0.0;
        for index in 1..self.flat.len() as u32 - 1 {
            let fan = self.signed_area([0, index, index + 1]);
            outline += fan;
            spread += fan.abs();
        }
        let cover: f64 =
            self.cuts.chunks_exact(3).map(|cut| self.signed_area([cut[0], cut[1], cut[2]]).abs()).sum();
        (cover - outline.abs()).abs() > AREA_TOLERANCE * spread
    }
}

/// Twice the vector area of a polygon (Newell's method), about its first corner so that far-off polygons lose
/// nothing.
fn newell(corners: impl Iterator<Item = [f64; 3]>) -> Area {
    let mut corners = corners;
    let Some(origin) = corners.next() else { return Area::default() };
    let mut area = Area::default();
    let mut previous = [0.0; 3];
    for corner in corners {
        let edge = [corner[0] - origin[0], corner[1] - origin[1], corner[2] - origin[2]];
        let fan = [
            previous[1] * edge[2] - previous[2] * edge[1],
            previous[2] * edge[0] - previous[0] * edge[2],
            previous[0] * edge[1] - previous[1] * edge[0],
        ];
        for (sum, part) in area.vector.iter_mut().zip(fan) {
            *sum += part;
            area.spread += part.abs();
        }
        previous = edge;
    }
    area
}

/// A vector area and the sum of the sizes of what was added up to it, which bounds its rounding.
#[derive(Default)]
struct Area {
    vector: [f64; 3],
    spread: f64,
}

/// The two axes of the projection along the greatest component of the area, in the order in which the polygon
/// runs counter-clockwise; `None` when there is no area.
fn plane(area: Area) -> Option<(usize, usize)> {
    let size = area.vector.map(f64::abs);
    let axis = if size[0] >= size[1] && size[0] >= size[2] {
        0
    } else if size[1] >= size[2] {
        1
    } else {
        2
    };
    if size[axis] <= 1.0e-9 * area.spread || size[axis] == 0.0 {
        return None;
    }
    let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
    Some(if area.vector[axis] > 0.0 { (u, v) } else { (v, u) })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn clip(vertices: &[[f32; 3]]) -> (Vec<[u32; 3]>, Notes) {
        let corners: Vec<u32> = (0..vertices.len() as u32).collect();
        let (mut triangles, mut notes) = (Vec::new(), Notes::default());
        Clipper::default().clip(vertices, &corners, &mut triangles, &mut notes);
        (triangles, notes)
    }

    fn sub(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
        [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
    }

    fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    }

    fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
        a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
    }

    /// Triangles of a simple flat polygon: each winds like the polygon, none overlaps another, and they cover
    /// it.
    fn check(vertices: &[[f32; 3]]) {
        let (triangles, notes) = clip(vertices);
        assert_eq!(notes, Notes::default());
        let points: Vec<[f64; 3]> = vertices.iter().map(|v| v.map(f64::from)).collect();
        let whole = newell(points.iter().copied()).vector;
        let mut sum = 0.0;
        for &t in &triangles {
            let [a, b, c] = t.map(|i| points[i as usize]);
            let area = cross(sub(b, a), sub(c, a));
            assert!(dot(area, whole) > 0.0, "{t:?} is flat or winds backwards");
            sum += dot(area, area).sqrt();
        }
        // Equal areas and no triangle whose middle lies in another: a partition.
        assert!((sum - dot(whole, whole).sqrt()).abs() < 1e-6 * sum, "{triangles:?}");
        for (i, &t) in triangles.iter().enumerate() {
            let [a, b, c] = t.map(|i| points[i as usize]);
            let middle = [0, 1, 2].map(|k| (a[k] + b[k] + c[k]) / 3.0);
            for (j, &o) in triangles.iter().enumerate() {
                let corners = o.map(|i| points[i as usize]);
                let inside = (0..3).all(|k| {
                    let (p, q) = (corners[k], corners[(k + 1) % 3]);
                    dot(cross(sub(q, p), sub(middle, p)), whole) > 1e-9
                });
                assert_eq!(inside, i == j, "{t:?} and {o:?}");
            }
        }
    }

    type Turn = fn(&[f32; 2]) -> [f32; 3];

    /// The same outline in the xy, yz and zx planes, tilted, and backwards.
    fn check_all(outline: &[[f32; 2]]) {
        let turns: [Turn; 4] = [
            |p| [p[0], p[1], 2.0],
            |p| [-3.0, p[0], p[1]],
            |p| [p[1], 0.0, p[0]],
            |p| [p[0], p[1], p[0] - 0.5 * p[1]],
        ];
        for turn in turns {
            let mut vertices: Vec<[f32; 3]> = outline.iter().map(turn).collect();
            check(&vertices);
            vertices.reverse();
            check(&vertices);
        }
    }

    #[test]
    fn concave_polygons_are_partitioned() {
        check_all(&[[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [2.0, 1.0]]);
        check_all(&[[0.0, 0.0], [4.0, 0.0], [4.0, 1.0], [1.0, 1.0], [1.0, 4.0], [0.0, 4.0]]);
        // Stairs, as a side of a flight of steps.
        let mut stairs = vec![[0.0, 0.0], [8.0, 0.0]];
        for step in (0..8).rev() {
            stairs.push([step as f32 + 1.0, step as f32 + 1.0]);
            stairs.push([step as f32, step as f32 + 1.0]);
        }
        check_all(&stairs);
        // A comb with long thin teeth.
        let mut comb = vec![[0.0, 0.0], [20.0, 0.0]];
        for tooth in (0..10).rev() {
            let x = 2.0 * tooth as f32;
            comb.extend([
                [x + 2.0, 9.0],
                [x + 1.5, 9.0],
                [x + 1.5, 1.0],
                [x + 0.5, 1.0],
                [x + 0.5, 9.0],
                [x, 9.0],
            ]);
        }
        comb.dedup();
        check_all(&comb);
    }

    #[test]
    fn vertices_on_straight_edges_are_kept() {
        // Neighbouring faces may end there: dropping them would leave a crack in the topology.
        let outline =
            [[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [2.0, 1.0], [2.0, 2.0], [1.0, 2.0], [0.0, 2.0], [0.0, 1.0]];
        let vertices = outline.map(|p: [f32; 2]| [p[0], p[1], 0.0]);
        check(&vertices);
        let (triangles, _) = clip(&vertices);
        for vertex in 0..8 {
            assert!(triangles.iter().flatten().any(|&v| v == vertex), "{vertex} in {triangles:?}");
        }
    }

    #[test]
    fn random_stars_are_partitioned() {
        let mut seed = 1u64;
        let mut random = || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (seed >> 40) as f32 / (1u32 << 24) as f32
        };
        for count in 4..60 {
            // Star-shaped about the origin, hence simple; radii jump, hence concave.
            let outline: Vec<[f32; 2]> = (0..count)
                .map(|i| {
                    let angle = i as f64 / count as f64 * std::f64::consts::TAU;
                    let radius = 1.0 + 9.0 * f64::from(random());
                    [(radius * angle.cos()) as f32, (radius * angle.sin()) as f32]
                })
                .collect();
            check(&outline.iter().map(|p| [p[0], p[1], 0.0]).collect::<Vec<_>>());
        }
    }

    #[test]
    fn faces_that_are_not_flat_keep_their_outline() {
        let (triangles, notes) = clip(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.3], [1.0, 1.0, 0.0], [0.0, 1.0, 0.3]]);
        assert_eq!((triangles.len(), notes), (2, Notes::default()));
    }

    #[test]
    fn crossing_and_empty_faces_are_counted() {
        let (_, notes) = clip(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]]);
        assert_eq!(notes.degenerate_faces, 1);
        let (triangles, notes) = clip(&[[0.0, 0.0, 0.0], [1.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
        assert_eq!((triangles.len(), notes.crossed_faces), (2, 1));
        let line = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [3.0, 0.0, 0.0]];
        assert_eq!(clip(&line).1.crossed_faces, 1);
        let pentagram: Vec<[f32; 3]> = (0..5)
            .map(|i| {
                let angle = f64::from(i) * 2.0 * std::f64::consts::TAU / 5.0;
                [angle.cos() as f32, angle.sin() as f32, 0.0]
            })
            .collect();
        assert_eq!(clip(&pentagram).1.crossed_faces, 1);
    }
}
