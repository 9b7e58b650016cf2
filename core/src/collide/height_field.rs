//! A height field: heights over a grid, as triangles that are nowhere stored.
//!
//! ```text
//!   row r+1  o-------o     the sample of column c and row r stands at (c dx, r dy, height)
//!            | 1   / |     a cell has two triangles, parted by the diagonal from its least corner:
//!            |   /   |     2 cell is the one on the side of x, 2 cell + 1 the one on the side of y;
//!            | /   0 |     cells count along x first
//!   row r    o-------o
//!          column c  c+1
//! ```
//! Contacts are found as on a mesh, triangle by triangle, each with what lies across its edges; a hole has no
//! triangles, and its neighbours end at it. No tree is needed: the cells under a region follow from its
//! coordinates, and there are never more than the field has.

use super::mesh::has_area;
use crate::math::{Aabb, Vec3};
use core::fmt;

/// Marks a cell without triangles.
pub const HOLE: u8 = u8::MAX;
/// Greatest height, and greatest length of a side, metres.
pub const COORDINATE_MAX: f32 = super::hull::COORDINATE_MAX;
/// Most cells: triangles are named with 24 bits.
pub const CELLS_MAX: usize = 1 << 23;
/// Range of the distance between samples, metres.
const SPACING_MIN: f32 = 1.0e-4;

/// A height field as a view of its tables. Made valid by [`validate`].
#[derive(Clone, Copy, Debug)]
pub struct HeightField<'a> {
    /// Samples along x, at least 2.
    pub columns: u32,
    /// Samples along y, at least 2.
    pub rows: u32,
    /// Distance of samples along x and y, metres.
    pub spacing: [f32; 2],
    /// Heights of the samples, metres, row by row: `columns x rows`.
    pub heights: &'a [f32],
    /// For each cell [`HOLE`], or the index of its surface in the field's own table; empty when there are neither.
    pub cells: &'a [u8],
    /// True when cells name surfaces.
    pub has_surfaces: bool,
    /// Least and greatest height, metres.
    pub range: [f32; 2],
}

/// Why heights make no field.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum HeightFieldError {
    /// Fewer than 2 columns or rows. Remedy: give at least one cell.
    TooFewSamples,
    /// More than [`CELLS_MAX`] cells. Remedy: split the field.
    TooManyCells,
    /// The number of heights is not columns times rows.
    HeightCount {
        /// Columns times rows.
        needed: u64,
        /// Heights that were given.
        given: u64,
    },
    /// Cells were given, but not one for each.
    CellCount {
        /// (Columns - 1) times (rows - 1).
        needed: u64,
        /// Cells that were given.
        given: u64,
    },
    /// The distance between samples is not within 1e-4 m and 1e5 m, or the field is longer than 1e5 m.
    Spacing,
    /// A height is not finite, or beyond 1e5 m. Remedy: mend this sample.
    Height {
        /// The first such sample.
        sample: u32,
    },
    /// A cell is so steep that a triangle of it has no normal in f32. Remedy: lower it, or make it a hole.
    TooSteep {
        /// The first such cell.
        cell: u32,
    },
    /// A cell names a surface that was not given.
    NoSuchSurface {
        /// The first such cell.
        cell: u32,
    },
}

impl fmt::Display for HeightFieldError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TooFewSamples => write!(f, "height field has fewer than 2 columns or rows"),
            Self::TooManyCells => write!(f, "height field has more than {CELLS_MAX} cells"),
            Self::HeightCount { needed, given } => {
                write!(f, "height field needs {needed} heights, {given} were given")
            }
            Self::CellCount { needed, given } => {
                write!(f, "height field has {needed} cells, {given} were given")
            }
            Self::Spacing => write!(f, "spacing of the height field is out of its range"),
            Self::Height { sample } => {
                write!(f, "height {sample} of the height field is not finite or beyond {COORDINATE_MAX} m")
            }
            Self::TooSteep { cell } => write!(f, "cell {cell} of the height field is too steep"),
            Self::NoSuchSurface { cell } => {
                write!(f, "cell {cell} of the height field names a surface that was not given")
            }
        }
    }
}

impl core::error::Error for HeightFieldError {}

/// Checks a field and gives its least and greatest height. `surfaces` is the length of its table; without one,
/// cells are [`HOLE`] or 0.
pub fn validate(field: &HeightField<'_>, surfaces: usize) -> Result<[f32; 2], HeightFieldError> {
    let (columns, rows) = (u64::from(field.columns), u64::from(field.rows));
    if columns < 2 || rows < 2 {
        return Err(HeightFieldError::TooFewSamples);
    }
    let cells = (columns - 1) * (rows - 1);
    if cells > CELLS_MAX as u64 {
        return Err(HeightFieldError::TooManyCells);
    }
    let (needed, given) = (columns * rows, field.heights.len() as u64);
    if needed != given {
        return Err(HeightFieldError::HeightCount { needed, given });
    }
    let given = field.cells.len() as u64;
    if given != 0 && given != cells {
        return Err(HeightFieldError::CellCount { needed: cells, given });
    }
    for (spacing, count) in field.spacing.iter().zip([columns, rows]) {
        // Also false for what is not a number.
        let fits = *spacing >= SPACING_MIN && spacing * (count - 1) as f32 <= COORDINATE_MAX;
        if !fits {
            return Err(HeightFieldError::Spacing);
        }
    }
    let mut range = [f32::INFINITY, f32::NEG_INFINITY];
    for (sample, &height) in field.heights.iter().enumerate() {
        if !height.is_finite() || height.abs() > COORDINATE_MAX {
            return Err(HeightFieldError::Height { sample: sample as u32 });
        }
        range = [crate::math::min(height, range[0]), crate::math::max(height, range[1])];
    }
    for cell in 0..cells as u32 {
        match field.cells.get(cell as usize) {
            Some(&HOLE) => continue,
            Some(&surface) if usize::from(surface) >= surfaces.max(1) => {
                return Err(HeightFieldError::NoSuchSurface { cell });
            }
            _ => {}
        }
        if !(0..2).all(|half| has_area(field.triangle(2 * cell + half).0)) {
            return Err(HeightFieldError::TooSteep { cell });
        }
    }
    Ok(range)
}

impl HeightField<'_> {
    /// The box around the field.
    pub fn bounds(&self) -> Aabb {
        let side = |count: u32, spacing: f32| (count - 1) as f32 * spacing;
        Aabb {
            min: Vec3::new(0.0, 0.0, self.range[0]),
            max: Vec3::new(
                side(self.columns, self.spacing[0]),
                side(self.rows, self.spacing[1]),
                self.range[1],
            ),
        }
    }

    fn sample(&self, column: u32, row: u32) -> Vec3 {
        let height = self.heights[row as usize * self.columns as usize + column as usize];
        Vec3::new(column as f32 * self.spacing[0], row as f32 * self.spacing[1], height)
    }

    /// The cell of a column and row; none outside, and none for a hole.
    pub(crate) fn solid_cell(&self, column: u32, row: u32) -> Option<u32> {
        // What lies before 0 wraps to far beyond.
        if column >= self.columns - 1 || row >= self.rows - 1 {
            return None;
        }
        let cell = row * (self.columns - 1) + column;
        (self.cells.get(cell as usize) != Some(&HOLE)).then_some(cell)
    }

    /// Corners of a triangle, counter-clockwise from above, and the corner across each edge, where there is one.
    pub fn triangle(&self, triangle: u32) -> ([Vec3; 3], [Option<Vec3>; 3]) {
        let (c, r) = (triangle / 2 % (self.columns - 1), triangle / 2 / (self.columns - 1));
        let at = |dc: u32, dr: u32| self.sample(c.wrapping_add(dc), r.wrapping_add(dr));
        let (before, none) = (u32::MAX, None);
        let across = |(dc, dr): (u32, u32), corner: (u32, u32)| {
            let cell = self.solid_cell(c.wrapping_add(dc), r.wrapping_add(dr));
            cell.map_or(none, |_| Some(at(corner.0, corner.1)))
        };
        if triangle.is_multiple_of(2) {
            let across = [across((0, before), (0, before)), across((1, 0), (2, 1)), Some(at(0, 1))];
            ([at(0, 0), at(1, 0), at(1, 1)], across)
        } else {
            let across = [Some(at(1, 0)), across((0, 1), (1, 2)), across((before, 0), (before, 0))];
            ([at(0, 0), at(1, 1), at(0, 1)], across)
        }
    }

    /// 1 + the index of a triangle's surface; 0 when it has none.
    pub fn surface_of(&self, triangle: u32) -> u32 {
        if !self.has_surfaces {
            return 0;
        }
        // Without cells all have the first one.
        1 + self.cells.get((triangle / 2) as usize).map_or(0, |&surface| u32::from(surface))
    }

    /// Visits the triangles whose boxes overlap a region, in ascending order.
    pub fn query(&self, region: &Aabb, mut visit: impl FnMut(u32)) {
        // Casts keep within the numbers of the type, so regions may be as large as they like.
        let cells = |low: f32, high: f32, spacing: f32, count: u32| {
            let first = libm::floorf(low / spacing) as u32;
            let last = libm::floorf(high / spacing);
            let none = last < 0.0 || first >= count;
            // One more on each side: the division is rounded.
            let end = if none { 0 } else { (last as u32).saturating_add(2).min(count) };
            first.saturating_sub(1).min(end)..end
        };
        let columns = cells(region.min.x, region.max.x, self.spacing[0], self.columns - 1);
        let rows = cells(region.min.y, region.max.y, self.spacing[1], self.rows - 1);
        for row in rows {
            for column in columns.clone() {
                let Some(cell) = self.solid_cell(column, row) else { continue };
                for half in 0..2 {
                    let (corners, _) = self.triangle(2 * cell + half);
                    let near = corners
                        .iter()
                        .fold(Aabb::EMPTY, |sum, &corner| sum.union(&Aabb { min: corner, max: corner }));
                    if near.overlaps(region) {
                        visit(2 * cell + half);
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use std::vec::Vec;

    const SPACING: [f32; 2] = [0.5, 2.0];

    fn field<'a>(heights: &'a [f32], cells: &'a [u8]) -> HeightField<'a> {
        let rows = heights.len() as u32 / 4;
        HeightField {
            columns: 4,
            rows,
            spacing: SPACING,
            heights,
            cells,
            has_surfaces: false,
            range: [0.0, 1.0],
        }
    }

    #[test]
    fn neighbours_are_those_of_a_connected_mesh() {
        let heights: Vec<f32> = (0..12_u32).map(|i| (i * 7 % 5) as f32 * 0.25).collect();
        let mut cells = [0; 6];
        cells[4] = HOLE;
        let field = field(&heights, &cells);
        assert_eq!(validate(&field, 0), Ok([0.0, 1.0]));
        let solid: Vec<u32> = (0..12).filter(|triangle| triangle / 2 != 4).collect();
        for &triangle in &solid {
            let (corners, across) = field.triangle(triangle);
            let up = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
            assert!(up.z > 0.0);
            for i in 0..3 {
                let edge = [corners[i], corners[(i + 1) % 3]];
                let others = solid.iter().filter(|&&other| other != triangle);
                let found: Vec<Vec3> = others
                    .map(|&other| field.triangle(other).0)
                    .filter(|other| edge.iter().all(|corner| other.contains(corner)))
                    .map(|other| *other.iter().find(|corner| !edge.contains(corner)).unwrap())
                    .collect();
                assert!(found.len() <= 1);
                assert_eq!(across[i], found.first().copied(), "{triangle} {i}");
            }
        }
    }

    #[test]
    fn a_query_visits_the_triangles_near_the_region_and_no_hole() {
        let heights: Vec<f32> = (0..16_u32).map(|i| (i * 7 % 5) as f32 * 0.25).collect();
        let mut cells = [0; 9];
        cells[2] = HOLE;
        let field = field(&heights, &cells);
        let mut seed = 1_u32;
        let mut random = |low: f32, high: f32| {
            seed = seed.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
            low + (high - low) * (seed >> 8) as f32 / 16_777_216.0
        };
        for _ in 0..2000 {
            let center = Vec3::new(random(-1.0, 3.0), random(-3.0, 8.0), random(-0.5, 1.5));
            let half = Vec3::new(random(0.0, 1.0), random(0.0, 2.0), random(0.0, 0.5));
            let region = Aabb::around(center, half);
            let mut found = Vec::new();
            field.query(&region, |triangle| found.push(triangle));
            let near = |triangle: &u32| {
                let corners = field.triangle(*triangle).0;
                let bounds = corners.iter().fold(Aabb::EMPTY, |b, &c| b.union(&Aabb { min: c, max: c }));
                triangle / 2 != 2 && bounds.overlaps(&region)
            };
            let expected: Vec<u32> = (0..18).filter(near).collect();
            assert_eq!(found, expected, "{region:?}");
        }
        let everything = Aabb { min: Vec3::splat(-1.0e30), max: Vec3::splat(1.0e30) };
        let mut count = 0;
        field.query(&everything, |_| count += 1);
        assert_eq!(count, 16);
    }

    #[test]
    fn bad_fields_are_refused() {
        let flat = [0.0; 8];
        let good = field(&flat, &[]);
        let check = |field: HeightField<'_>| validate(&field, 0).unwrap_err();
        assert_eq!(check(HeightField { rows: 1, ..good }), HeightFieldError::TooFewSamples);
        assert_eq!(check(HeightField { rows: u32::MAX, ..good }), HeightFieldError::TooManyCells);
        let counted = HeightFieldError::HeightCount { needed: 12, given: 8 };
        assert_eq!(check(HeightField { rows: 3, ..good }), counted);
        let counted = HeightFieldError::CellCount { needed: 3, given: 2 };
        assert_eq!(check(HeightField { cells: &[0, 0], ..good }), counted);
        for bad in [0.0, -1.0, f32::NAN, f32::INFINITY, 5.0e4] {
            assert_eq!(check(HeightField { spacing: [bad, 1.0], ..good }), HeightFieldError::Spacing);
        }
        let surface = HeightFieldError::NoSuchSurface { cell: 1 };
        assert_eq!(check(HeightField { cells: &[0, 1, HOLE], ..good }), surface);
        for bad in [f32::NAN, 2.0e5] {
            let mut heights = flat;
            heights[5] = bad;
            assert_eq!(check(field(&heights, &[])), HeightFieldError::Height { sample: 5 });
        }
        let mut heights = flat;
        heights[7] = 9.0e4;
        let steep = HeightField { spacing: [1.0e-3; 2], ..field(&heights, &[]) };
        assert_eq!(check(steep), HeightFieldError::TooSteep { cell: 2 });
    }
}
