//! Triangles of a height field along a way, and around a box, nearer ones first, without a tree.
//!
//! ```text
//!   along: line by line of cells across the greater part of the way       around: the nearest line of cells
//!   +---+---+---+---+                                                     next to a rectangle joins it
//!   |   |   |   | ./|   lines 0 1 2 3, and of each the cells that                 +---+
//!   |   |  .|./ |   |   the box sweeps while it is over the line                  | 2 |
//!   | ./|   |   |   |                                                         +---+---+
//!   +---+---+---+---+                                                         | 1 |   |
//! ```
//! Samples stand where f32 puts them; cells are found from coordinates with one more on each side and then held
//! against their own sides, so none is missed by rounding.

use super::frame::widened;
use crate::collide::height_field::HeightField;
use glam::DVec3;

/// By how much cells are taken for larger, as a fraction of the coordinates: more than the rounding of f64.
const PAD: f64 = 1.0e-12;
/// Distances up to this factor beyond a limit are looked at, so that ties are decided by their order.
const TIES: f64 = 1.0 + 1.0e-6;

/// Cells of a line, from the first to the last.
#[derive(Clone, Copy, Debug)]
struct Run {
    first: u32,
    last: u32,
}

/// A grid in f64.
#[derive(Clone, Copy, Debug)]
struct Grid<'a> {
    field: &'a HeightField<'a>,
    /// Cells along x and y.
    counts: [u32; 2],
    /// Least and greatest coordinates.
    low: DVec3,
    high: DVec3,
    pad: f64,
}

fn lesser(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

fn greater(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

impl<'a> Grid<'a> {
    /// `reach` is the greatest coordinate of a search, metres.
    fn new(field: &'a HeightField<'a>, reach: f64) -> Self {
        let bounds = field.bounds();
        let (low, high) = (widened(bounds.min), widened(bounds.max));
        let size = greater(high.x, greater(high.y, greater(low.z.abs(), high.z.abs())));
        Self { field, counts: [field.columns - 1, field.rows - 1], low, high, pad: PAD * (reach + size) }
    }

    /// Where line `index` of cells begins along an axis.
    fn side(&self, axis: usize, index: u32) -> f64 {
        f64::from(index as f32 * self.field.spacing[axis])
    }

    /// The cells that may touch an interval along an axis, at least one.
    fn run(&self, axis: usize, low: f64, high: f64) -> Run {
        let spacing = f64::from(self.field.spacing[axis]);
        // Casts keep within the numbers of the type.
        let cell = |x: f64| libm::floor(x / spacing) as u32;
        let most = self.counts[axis] - 1;
        let first = cell(low).saturating_sub(1).min(most);
        Run { first, last: cell(high).saturating_add(1).min(most).max(first) }
    }

    /// Visits the triangles of a cell, unless it is a hole or `skip` says of its least and greatest height.
    fn cell(
        &self,
        (column, row): (u32, u32),
        skip: impl FnOnce(f64, f64) -> bool,
        visit: &mut impl FnMut(u32, [DVec3; 3]) -> f64,
    ) -> Option<f64> {
        let cell = self.field.solid_cell(column, row)?;
        let ([a, b, c], [_, _, d]) = self.field.triangle(2 * cell);
        let d = d.unwrap_or(a);
        let [a, b, c, d] = [a, b, c, d].map(widened);
        let low = lesser(lesser(a.z, b.z), lesser(c.z, d.z));
        let high = greater(greater(a.z, b.z), greater(c.z, d.z));
        if skip(low, high) {
            return None;
        }
        visit(2 * cell, [a, b, c]);
        Some(visit(2 * cell + 1, [a, c, d]))
    }
}

/// A box on its way.
#[derive(Clone, Copy, Debug)]
struct Sweep {
    origin: DVec3,
    direction: DVec3,
    low: DVec3,
    high: DVec3,
    pad: f64,
}

impl Sweep {
    /// The part of `[start, end]` of the way on which the box touches an interval along an axis.
    fn over(&self, axis: usize, (low, high): (f64, f64), (start, end): (f64, f64)) -> Option<(f64, f64)> {
        let near = low - self.high[axis] - self.pad - self.origin[axis];
        let far = high - self.low[axis] + self.pad - self.origin[axis];
        let speed = self.direction[axis];
        if speed == 0.0 {
            return (near <= 0.0 && far >= 0.0).then_some((start, end));
        }
        let (a, b) = (near / speed, far / speed);
        let (enter, exit) = if a < b { (a, b) } else { (b, a) };
        let (enter, exit) = (greater(enter, start), lesser(exit, end));
        (enter <= exit).then_some((enter, exit))
    }

    /// What the box covers along an axis on a part of the way.
    fn covers(&self, axis: usize, (start, end): (f64, f64)) -> (f64, f64) {
        let (a, b) = (self.direction[axis] * start, self.direction[axis] * end);
        let from = self.origin[axis];
        (from + lesser(a, b) + self.low[axis] - self.pad, from + greater(a, b) + self.high[axis] + self.pad)
    }
}

/// Visits the triangles that a box may meet on a way: one that reaches from `low` to `high` about a point that goes
/// from `origin` along the unit vector `direction` for `length` metres. Those farther along than `limit` metres may
/// be left out; `visit` takes a triangle's index and corners and returns the limit from then on.
pub(super) fn along(
    field: &HeightField<'_>,
    (origin, direction, length): (DVec3, DVec3, f64),
    (low, high): (DVec3, DVec3),
    limit: f64,
    mut visit: impl FnMut(u32, [DVec3; 3]) -> f64,
) {
    let reach = origin.abs().max_element() + length + (high - low).max_element();
    let grid = Grid::new(field, reach);
    let sweep = Sweep { origin, direction, low, high, pad: grid.pad };
    let mut part = (0.0, length);
    for axis in 0..3 {
        let Some(clipped) = sweep.over(axis, (grid.low[axis], grid.high[axis]), part) else { return };
        part = clipped;
    }
    let main = usize::from(direction.y.abs() > direction.x.abs());
    let cross = 1 - main;
    let (from, to) = sweep.covers(main, part);
    let lines = grid.run(main, from, to);
    let mut limit = limit;
    for step in 0..=lines.last - lines.first {
        let line = if direction[main] < 0.0 { lines.last - step } else { lines.first + step };
        let sides = (grid.side(main, line), grid.side(main, line + 1));
        let Some(over) = sweep.over(main, sides, part) else { continue };
        if over.0 > limit * TIES + grid.pad {
            return;
        }
        let (from, to) = sweep.covers(cross, over);
        let cells = grid.run(cross, from, to);
        for step in 0..=cells.last - cells.first {
            let cell = if direction[cross] < 0.0 { cells.last - step } else { cells.first + step };
            let sides = (grid.side(cross, cell), grid.side(cross, cell + 1));
            let Some(over) = sweep.over(cross, sides, over) else { continue };
            let (least, most) = sweep.covers(2, over);
            let place = if main == 0 { (line, cell) } else { (cell, line) };
            let skip = |low: f64, high: f64| low > most || high < least || over.0 > limit * TIES + grid.pad;
            if let Some(next) = grid.cell(place, skip, &mut visit) {
                limit = next;
            }
        }
    }
}

/// Visits the triangles that may be within `limit` metres of the box from `low` to `high`, nearer ones first as far
/// as the grid tells; `visit` takes a triangle's index and corners and returns the limit from then on.
pub(super) fn around(
    field: &HeightField<'_>,
    (low, high): (DVec3, DVec3),
    limit: f64,
    mut visit: impl FnMut(u32, [DVec3; 3]) -> f64,
) {
    let grid = Grid::new(field, low.abs().max_element() + high.abs().max_element());
    let gap = |least: f64, most: f64, axis: usize| {
        greater(greater(least - high[axis], low[axis] - most) - grid.pad, 0.0)
    };
    let height = gap(grid.low.z, grid.high.z, 2);
    let mut limit = limit;
    let mut look = |column: u32, row: u32, limit: &mut f64| {
        let beside = |axis: usize, index: u32| gap(grid.side(axis, index), grid.side(axis, index + 1), axis);
        let (x, y) = (beside(0, column), beside(1, row));
        let within = *limit * TIES;
        let skip = |least: f64, most: f64| {
            let z = gap(least, most, 2);
            x * x + y * y + z * z > within * within
        };
        if let Some(next) = grid.cell((column, row), skip, &mut visit) {
            *limit = next;
        }
    };
    let mut rectangle = [0, 1].map(|axis| grid.run(axis, low[axis], high[axis]));
    for row in rectangle[1].first..=rectangle[1].last {
        for column in rectangle[0].first..=rectangle[0].last {
            look(column, row, &mut limit);
        }
    }
    while let Some((beside, axis, is_up)) = grid.nearest_line(&rectangle, (low, high)) {
        let beside = greater(beside - grid.pad, 0.0);
        if beside * beside + height * height > limit * limit * (TIES * TIES) {
            return;
        }
        let line = if is_up { rectangle[axis].last + 1 } else { rectangle[axis].first - 1 };
        let other = rectangle[1 - axis];
        for cell in other.first..=other.last {
            if axis == 0 { look(line, cell, &mut limit) } else { look(cell, line, &mut limit) }
        }
        let run = &mut rectangle[axis];
        *if is_up { &mut run.last } else { &mut run.first } = line;
    }
}

impl Grid<'_> {
    /// The line of cells next to a rectangle that is nearest to a box: its distance, its axis, and whether it lies
    /// above. `None` when the rectangle is the grid.
    fn nearest_line(&self, rectangle: &[Run; 2], (low, high): (DVec3, DVec3)) -> Option<(f64, usize, bool)> {
        let mut best: Option<(f64, usize, bool)> = None;
        let mut take = |beside: f64, axis: usize, is_up: bool| {
            if best.is_none_or(|best| beside < best.0) {
                best = Some((beside, axis, is_up));
            }
        };
        for (axis, run) in rectangle.iter().enumerate() {
            if run.first > 0 {
                take(low[axis] - self.side(axis, run.first), axis, false);
            }
            if run.last + 1 < self.counts[axis] {
                take(self.side(axis, run.last + 1) - high[axis], axis, true);
            }
        }
        best
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::super::frame::length;
    use super::super::ray::{Ray, triangle};
    use super::*;
    use std::vec::Vec;

    fn random(state: &mut u64) -> f64 {
        *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (*state >> 11) as f64 / 4_503_599_627_370_496.0 - 1.0
    }

    fn vector(state: &mut u64) -> DVec3 {
        DVec3::new(random(state), random(state), random(state))
    }

    const COLUMNS: u32 = 61;
    const ROWS: u32 = 41;

    fn check(spacing: [f32; 2]) {
        let mut seed = 5;
        let heights: Vec<f32> = (0..COLUMNS * ROWS).map(|_| random(&mut seed) as f32).collect();
        let cells: Vec<u8> =
            (0..(COLUMNS - 1) * (ROWS - 1)).map(|i| if i % 7 == 3 { u8::MAX } else { 0 }).collect();
        let (range, has_surfaces) = ([-1.0, 1.0], false);
        let field = HeightField {
            columns: COLUMNS,
            rows: ROWS,
            spacing,
            heights: &heights,
            cells: &cells,
            has_surfaces,
            range,
        };
        let size = field.bounds().max;
        let size = DVec3::new(f64::from(size.x), f64::from(size.y), 1.0);
        let all = || (0..2 * cells.len() as u32).filter(|index| cells[*index as usize / 2] == 0);
        let (mut hits, mut visits) = (0, 0);
        for case in 0..3000 {
            let mut target = (vector(&mut seed) * 0.5 + DVec3::new(0.5, 0.5, 0.0)) * size;
            if case % 4 == 0 {
                // At a sample.
                let column = libm::floor(target.x / f64::from(spacing[0])) as u32;
                target.x = f64::from(column as f32 * spacing[0]);
            }
            let far = [1.0, 1.0e2, 1.0e6][case % 3];
            let mut origin = target + vector(&mut seed) * size * far;
            match case % 5 {
                0 => origin.x = target.x,
                1 => origin.y = target.y,
                2 => (origin.x, origin.y) = (target.x, target.y),
                _ => {}
            }
            let way = (target - origin) * 2.0;
            let ray = Ray { origin, direction: way / length(way), length: length(way) };
            let meets = |index: &u32| triangle(&ray, field.triangle(*index).0.map(widened), *index).is_some();
            let expected: Vec<u32> = all().filter(meets).collect();
            let mut found = Vec::new();
            let line = (ray.origin, ray.direction, ray.length);
            along(&field, line, (DVec3::ZERO, DVec3::ZERO), f64::INFINITY, |index, corners| {
                visits += 1;
                if triangle(&ray, corners, index).is_some() {
                    found.push(index);
                }
                f64::INFINITY
            });
            found.sort_unstable();
            assert_eq!(found, expected, "{case}: {ray:?}");
            hits += expected.len();
            // Boxes near the field: all that is as near is visited.
            let center = (vector(&mut seed) + DVec3::new(0.5, 0.5, 0.0)) * size;
            let half = vector(&mut seed).abs() * size * 0.1;
            let (low, high) = (center - half, center + half);
            let gap = |index: u32| {
                let corners = field.triangle(index).0.map(widened);
                let least = corners[0].min(corners[1]).min(corners[2]);
                let most = corners[0].max(corners[1]).max(corners[2]);
                length((least - high).max(low - most).max(DVec3::ZERO))
            };
            let mut nearest = f64::INFINITY;
            around(&field, (low, high), 1.0e7, |index, _| {
                let apart = gap(index);
                nearest = if apart < nearest { apart } else { nearest };
                nearest
            });
            let expected = all().map(gap).fold(f64::INFINITY, |a, b| if b < a { b } else { a });
            assert!((nearest - expected).abs() <= 1.0e-9, "{case}: {nearest} {expected}");
        }
        assert!(hits > 1500 && visits < 3000 * 400, "{hits} {visits}");
    }

    #[test]
    fn ways_and_surroundings_are_those_of_brute_force() {
        check([1.0, 1.0]);
        check([0.3, 2.7]);
        check([1.0e-3, 1.0e-2]);
        check([1.0e3, 17.0]);
    }
}
