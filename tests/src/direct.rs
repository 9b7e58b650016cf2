//! The talk's condition S8 solved exactly, in double precision: `w = A lambda + b`, each row with given bounds,
//! `w > 0: lambda = low`, `w < 0: lambda = high`, `w = 0` between.
//!
//! Dantzig's method as Baraff gives it (Fast contact force computation for nonpenetrating rigid bodies, 1994), with
//! bounds: rows are taken in one after the other. The impulse of the row that comes in is driven to where its
//! condition holds, and the impulses of the *free* rows (between their bounds) go with it so that their rates stay
//! 0; where a row meets its bound, or a rate meets 0, the row changes sides and the drive goes on. Every drive
//! ends: it solves a convex problem over fewer rows each time.

mod seen;

pub use seen::{Answer, Seen};

/// A problem with bounds. `low <= 0 <= high`.
#[derive(Clone, Debug, Default)]
pub struct Bounded {
    /// A, symmetric, row by row. Rows that depend on each other need a little on the diagonal.
    pub matrix: Vec<Vec<f64>>,
    /// b.
    pub rates: Vec<f64>,
    /// Least impulses; minus infinity for none.
    pub low: Vec<f64>,
    /// Greatest impulses.
    pub high: Vec<f64>,
}

/// On which side of its condition a row is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Side {
    /// Not taken in yet.
    Out,
    /// `lambda = low` or `high`, whichever is nearer.
    AtLow,
    AtHigh,
    /// `w = 0`.
    Free,
}

/// What ends a drive's step.
#[derive(Clone, Copy, Debug)]
enum End {
    /// The driven row gets this side.
    Driven(Side),
    /// Another row changes to this side.
    Other(usize, Side),
}

/// Changes of sides for each row, after which a drive is said to turn in a circle.
const CHANGES_MAX: usize = 200;

impl Bounded {
    /// `w` for these impulses.
    pub fn rates_of(&self, impulses: &[f64]) -> Vec<f64> {
        let row = |(row, b): (&Vec<f64>, &f64)| b + row.iter().zip(impulses).map(|(a, x)| a * x).sum::<f64>();
        self.matrix.iter().zip(&self.rates).map(row).collect()
    }

    /// The greatest `|lambda - clamp(lambda - w / A_ii)| A_ii`: 0 for the answer.
    pub fn residual(&self, impulses: &[f64]) -> f64 {
        let rates = self.rates_of(impulses);
        (0..rates.len()).fold(0.0, |most: f64, i| {
            let x = (impulses[i] - rates[i] / self.matrix[i][i]).clamp(self.low[i], self.high[i]);
            most.max((x - impulses[i]).abs() * self.matrix[i][i])
        })
    }

    /// The answer.
    ///
    /// # Panics
    /// When rows depend on each other so that no drive ends.
    pub fn solve(&self) -> Vec<f64> {
        let count = self.rates.len();
        let (mut x, mut w) = (vec![0.0; count], self.rates.clone());
        let mut sides = vec![Side::Out; count];
        for row in 0..count {
            self.drive(row, (&mut x, &mut w), &mut sides);
        }
        x
    }

    fn drive(&self, row: usize, (x, w): (&mut [f64], &mut [f64]), sides: &mut [Side]) {
        for _ in 0..CHANGES_MAX {
            if w[row] >= 0.0 && x[row] <= self.low[row] {
                sides[row] = Side::AtLow;
                return;
            }
            if w[row] <= 0.0 && x[row] >= self.high[row] {
                sides[row] = Side::AtHigh;
                return;
            }
            if w[row] == 0.0 {
                sides[row] = Side::Free;
                return;
            }
            let step = self.direction(row, -w[row].signum(), sides);
            let change = self.product(&step);
            let (length, end) = self.reach(row, (x, w), (&step, &change), sides);
            x.iter_mut().zip(&step).for_each(|(x, d)| *x += length * d);
            w.iter_mut().zip(&change).for_each(|(w, d)| *w += length * d);
            let (other, side) = match end {
                End::Driven(side) => (row, side),
                End::Other(other, side) => (other, side),
            };
            match side {
                Side::AtLow => x[other] = self.low[other],
                Side::AtHigh => x[other] = self.high[other],
                _ => w[other] = 0.0,
            }
            sides[other] = side;
            if other == row {
                return;
            }
        }
        panic!("row {row} turns in a circle");
    }

    /// How the impulses go with one of `row` by `sign`.
    fn direction(&self, row: usize, sign: f64, sides: &[Side]) -> Vec<f64> {
        let free: Vec<usize> = (0..sides.len()).filter(|&i| sides[i] == Side::Free).collect();
        let block = free.iter().map(|&i| free.iter().map(|&k| self.matrix[i][k]).collect()).collect();
        let side = free.iter().map(|&i| -sign * self.matrix[i][row]).collect();
        let mut step = vec![0.0; sides.len()];
        for (&i, x) in free.iter().zip(eliminate(block, side)) {
            step[i] = x;
        }
        step[row] = sign;
        step
    }

    fn product(&self, x: &[f64]) -> Vec<f64> {
        self.matrix.iter().map(|row| row.iter().zip(x).map(|(a, x)| a * x).sum()).collect()
    }

    /// How far the drive goes, and what ends it.
    fn reach(
        &self,
        row: usize,
        (x, w): (&[f64], &[f64]),
        (step, change): (&[f64], &[f64]),
        sides: &[Side],
    ) -> (f64, End) {
        let bound = |i: usize| if step[i] > 0.0 { self.high[i] } else { self.low[i] };
        let side = |i: usize| if step[i] > 0.0 { Side::AtHigh } else { Side::AtLow };
        let mut best = (f64::INFINITY, End::Driven(Side::Free));
        let mut offer = |length: f64, end: End| {
            if length < best.0 {
                best = (length.max(0.0), end);
            }
        };
        offer(-w[row] / change[row], End::Driven(Side::Free));
        offer((bound(row) - x[row]) / step[row], End::Driven(side(row)));
        for (i, &now) in sides.iter().enumerate().filter(|&(i, _)| i != row) {
            match now {
                Side::Free if step[i] != 0.0 => offer((bound(i) - x[i]) / step[i], End::Other(i, side(i))),
                Side::AtLow if change[i] < 0.0 => offer(-w[i] / change[i], End::Other(i, Side::Free)),
                Side::AtHigh if change[i] > 0.0 => offer(-w[i] / change[i], End::Other(i, Side::Free)),
                _ => {}
            }
        }
        assert!(best.0.is_finite(), "row {row} finds no end");
        best
    }
}

/// Solves a dense system by elimination with the largest pivots.
fn eliminate(mut a: Vec<Vec<f64>>, mut b: Vec<f64>) -> Vec<f64> {
    let count = b.len();
    for column in 0..count {
        let size = |row: &usize| a[*row][column].abs();
        let pivot = (column..count).max_by(|i, k| size(i).total_cmp(&size(k))).unwrap_or(column);
        a.swap(column, pivot);
        b.swap(column, pivot);
        for row in column + 1..count {
            let share = a[row][column] / a[column][column];
            let (above, below) = a.split_at_mut(row);
            let pivots = above[column][column..].iter();
            below[0][column..].iter_mut().zip(pivots).for_each(|(x, pivot)| *x -= share * pivot);
            b[row] -= share * b[column];
        }
    }
    for row in (0..count).rev() {
        let known: f64 = (row + 1..count).map(|k| a[row][k] * b[k]).sum();
        b[row] = (b[row] - known) / a[row][row];
    }
    b
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::executors::Random;

    #[test]
    fn the_answer_fulfils_the_condition() {
        let mut random = Random::new(7);
        for count in 1..24 {
            // A = G Gt: rows that depend on each other get a millionth on the diagonal.
            let g: Vec<Vec<f64>> = (0..count)
                .map(|_| (0..count / 2 + 3).map(|_| random.between(-1.0, 1.0).into()).collect())
                .collect();
            let product = |i: usize, k: usize| g[i].iter().zip(&g[k]).map(|(a, b)| a * b).sum::<f64>();
            let entry = |i: usize, k: usize| product(i, k) + if i == k { 1.0e-6 } else { 0.0 };
            let problem = Bounded {
                matrix: (0..count).map(|i| (0..count).map(|k| entry(i, k)).collect()).collect(),
                rates: (0..count).map(|_| random.between(-1.0, 1.0).into()).collect(),
                low: (0..count).map(|i| if i % 3 == 0 { 0.0 } else { -0.3 }).collect(),
                high: (0..count).map(|i| if i % 3 == 2 { 0.3 } else { f64::INFINITY }).collect(),
            };
            let residual = problem.residual(&problem.solve());
            assert!(residual < 1.0e-9, "{count} rows: {residual}");
        }
    }
}
