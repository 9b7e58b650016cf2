//! Iterations on the rows: projected Gauss-Seidel in any sequence, and Jacobi.

use super::{Problem, Row, Six};
use crate::executors::Random;

/// Rounds of the power iteration.
const POWER_ROUNDS: u32 = 100;
/// Jacobi's factor, as a share of the limit of convergence: the power iteration finds that limit to a few percent.
const JACOBI_SHARE: f64 = 0.95;

/// Impulses, and the velocities that go with them.
#[derive(Clone, Debug)]
pub struct Iterate {
    /// lambda, row by row.
    pub impulses: Vec<f64>,
    /// `u + M^-1 Jt lambda`.
    pub velocities: Vec<Six>,
}

/// How a sweep goes.
#[derive(Clone, Debug)]
pub enum Method {
    /// Projected Gauss-Seidel (SEED S9, S10): the rows in this sequence, each update used at once.
    GaussSeidel(Vec<u32>),
    /// Projected Jacobi: all updates from the same velocities, each `-factor w_i / A_ii`.
    Jacobi {
        /// See [`Problem::jacobi`].
        factor: f64,
    },
}

impl Row {
    /// `(A lambda + b)_i` from the velocities.
    fn w(&self, impulse: f64, velocities: &[Six]) -> f64 {
        self.rate(velocities) + self.bias + self.soft * impulse
    }

    /// The clamped impulse after a change by `-factor w / A_ii`.
    fn update(&self, impulse: f64, (velocities, factor): (&[Six], f64)) -> f64 {
        let w = self.w(impulse, velocities);
        self.clamp(impulse - factor * w / self.diagonal)
    }
}

impl Problem {
    /// Impulses all zero: no warm start, so that methods are compared over the whole way. (0 is within all bounds.)
    pub fn start(&self) -> Iterate {
        Iterate { impulses: vec![0.0; self.rows.len()], velocities: self.velocities.clone() }
    }

    /// One sweep.
    pub fn sweep(&self, method: &Method, iterate: &mut Iterate) {
        match method {
            Method::GaussSeidel(sequence) => {
                for &index in sequence {
                    let (row, impulse) = (&self.rows[index as usize], &mut iterate.impulses[index as usize]);
                    let next = row.update(*impulse, (&iterate.velocities, 1.0));
                    row.apply(&mut iterate.velocities, next - *impulse);
                    *impulse = next;
                }
            }
            Method::Jacobi { factor } => {
                let before = iterate.velocities.clone();
                for (row, impulse) in self.rows.iter().zip(&mut iterate.impulses) {
                    let next = row.update(*impulse, (&before, *factor));
                    row.apply(&mut iterate.velocities, next - *impulse);
                    *impulse = next;
                }
            }
        }
    }

    /// Jacobi with the largest factor that converges. Projected Jacobi converges on a convex problem for factors
    /// below `2 / (greatest eigenvalue of D^-1 A)`, D being A's diagonal; this takes 0.95 of it.
    pub fn jacobi(&self) -> Method {
        Method::Jacobi { factor: JACOBI_SHARE * 2.0 / self.greatest_eigenvalue() }
    }

    /// Of `D^-1/2 A D^-1/2`, which has the eigenvalues of `D^-1 A`, by power iteration; 1 if there are no rows.
    pub fn greatest_eigenvalue(&self) -> f64 {
        let mut random = Random::new(1);
        let mut x: Vec<f64> = self.rows.iter().map(|_| f64::from(random.between(0.5, 1.0))).collect();
        let mut value = 1.0;
        for _ in 0..POWER_ROUNDS {
            let length = x.iter().map(|x| x * x).sum::<f64>().sqrt();
            if length == 0.0 {
                return 1.0;
            }
            let mut velocities = vec![[0.0; 6]; self.velocities.len()];
            for (row, x) in self.rows.iter().zip(&x) {
                row.apply(&mut velocities, x / length / row.diagonal.sqrt());
            }
            let next = |(row, x): (&Row, &f64)| {
                row.rate(&velocities) / row.diagonal.sqrt() + row.soft / row.diagonal * x / length
            };
            let answer: Vec<f64> = self.rows.iter().zip(&x).map(next).collect();
            value = x.iter().zip(&answer).map(|(x, y)| x * y).sum::<f64>() / length;
            x = answer;
        }
        value
    }

    /// w, row by row.
    pub fn rates(&self, iterate: &Iterate) -> Vec<f64> {
        let w = |(row, &impulse): (&Row, &f64)| row.w(impulse, &iterate.velocities);
        self.rows.iter().zip(&iterate.impulses).map(w).collect()
    }

    /// How far S8 is from holding, see the [module](super).
    pub fn residual(&self, iterate: &Iterate) -> f64 {
        let start = self.violation(&self.start());
        if start == 0.0 { 0.0 } else { self.violation(iterate) / start }
    }

    /// `sqrt(sum A_ii r_i^2)`, the square root of twice an energy: no row's w is further from 0 than `sqrt(A_ii)`
    /// times this unless its impulse is within `1 / sqrt(A_ii)` times this of the bound that S8 then asks for.
    pub fn violation(&self, iterate: &Iterate) -> f64 {
        let square = |(row, &impulse): (&Row, &f64)| {
            let r = impulse - row.update(impulse, (&iterate.velocities, 1.0));
            row.diagonal * r * r
        };
        self.rows.iter().zip(&iterate.impulses).map(square).sum::<f64>().sqrt()
    }
}
