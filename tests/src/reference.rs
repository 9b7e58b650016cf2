//! A solver in double precision on the rows of one step, as the talk writes them (SEED S5 to S11).
//!
//! The rows are formed here anew, from what a world shows: poses, masses, velocities, manifolds and the impulses of
//! its last step. The problem is the first substep (h) of the next step, with position correction:
//!
//! ```text
//! w = A lambda + b     A = J M^-1 Jt + S     b = J u + bias     u: velocities after gravity
//! ```
//!
//! A row's rate is `d . (v_b - v_a)` at its point, from body A to body B. A manifold has
//!
//! - for each point a normal row, `0 <= lambda`; its bias is `gap / h` when apart; when overlapping it is that of
//!   the world's contact model, with an entry in the diagonal S for soft contacts
//!   ([`Soft`](cellstep::ContactModel::Soft)) and none for rigid ones;
//! - two tangents and a twist about the normal at the points' middle, without bias: `|lambda| <= mu N` and
//!   `|lambda| <= mu N radius`, N being the normal impulse of the substep before, radius the mean distance of the
//!   points from their middle.
//!
//! So all bounds are **given numbers**, as in the talk, and friction is a **box**, not a cone: the problem is
//! convex, `w` and the velocities are unique (lambda need not be), and any method that converges finds the same.
//! Friction rows come before the normals of their manifold, as in the engine. Left out: restitution, the gyroscopic
//! moment, forces, locks and gravity scales.
//!
//! **Residual** of the condition S8 (w > 0: lambda = min; w = 0: between; w < 0: lambda = max): the natural map
//!
//! ```text
//! r_i = lambda_i - clamp(lambda_i - w_i / A_ii, min_i, max_i)
//! residual = sqrt(sum A_ii r_i^2) / (the same at lambda = 0)
//! ```
//!
//! It is 0 exactly where S8 holds, 1 at the start, and has no unit: `A_ii r_i^2` is an energy for every kind of
//! row.

mod colours;
mod methods;
mod rows;

use cellstep::cells::Link;

pub use colours::{COUPLED, colours, is_coupled};
pub use methods::{Iterate, Method};
pub use rows::links;

/// Linear and angular parts of a velocity, an impulse or a jacobian.
pub type Six = [f64; 6];

/// Marks the end of a row that does not move.
pub const FIXED: usize = usize::MAX;

/// One row of J with its bounds.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    /// Index of body A among the dynamic ones.
    pub a: usize,
    /// Index of body B, or [`FIXED`].
    pub b: usize,
    /// Jacobian of A, then of B.
    pub jacobian: [Six; 2],
    /// `M^-1 Jt`: what an impulse of 1 changes of the velocities.
    pub answer: [Six; 2],
    /// Entry in S: what the contact gives, 1/kg.
    pub soft: f64,
    /// Entry on the diagonal of A, `J M^-1 Jt + soft`.
    pub diagonal: f64,
    /// Added to the rate, m/s or rad/s.
    pub bias: f64,
    /// Least impulse, N s or N m s.
    pub low: f64,
    /// Greatest impulse.
    pub high: f64,
}

/// The rows of a step.
#[derive(Clone, Debug)]
pub struct Problem {
    /// Velocities of the dynamic bodies after gravity, before contacts; in the order in which links name bodies.
    pub velocities: Vec<Six>,
    /// All rows, those of a link together, links in their order.
    pub rows: Vec<Row>,
    /// The contacts as the orderings see them.
    pub links: Vec<Link>,
    /// Where the rows of each link start; one more for the end.
    pub first_rows: Vec<usize>,
}

fn dot(a: &Six, b: &Six) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

impl Row {
    /// `J u`.
    fn rate(&self, velocities: &[Six]) -> f64 {
        let b = if self.b == FIXED { 0.0 } else { dot(&self.jacobian[1], &velocities[self.b]) };
        dot(&self.jacobian[0], &velocities[self.a]) + b
    }

    /// Adds `M^-1 Jt x`.
    fn apply(&self, velocities: &mut [Six], x: f64) {
        let mut add = |body: usize, answer: &Six| {
            velocities[body].iter_mut().zip(answer).for_each(|(v, change)| *v += change * x);
        };
        add(self.a, &self.answer[0]);
        if self.b != FIXED {
            add(self.b, &self.answer[1]);
        }
    }

    /// The entry of A of two different rows.
    pub fn coupling(&self, other: &Row) -> f64 {
        let mut sum = 0.0;
        for (own, jacobian) in [(self.a, &self.jacobian[0]), (self.b, &self.jacobian[1])] {
            for (theirs, answer) in [(other.a, &other.answer[0]), (other.b, &other.answer[1])] {
                if own == theirs && own != FIXED {
                    sum += dot(jacobian, answer);
                }
            }
        }
        sum
    }

    /// `clamp(x, low, high)`.
    fn clamp(&self, x: f64) -> f64 {
        x.clamp(self.low, self.high)
    }
}

impl Problem {
    /// How many dynamic bodies.
    pub fn bodies(&self) -> u32 {
        self.velocities.len() as u32
    }

    /// The rows in the sequence of a schedule's links.
    pub fn sequence(&self, links: &[u32]) -> Vec<u32> {
        let rows =
            |&link: &u32| self.first_rows[link as usize] as u32..self.first_rows[link as usize + 1] as u32;
        links.iter().flat_map(rows).collect()
    }

    /// For each body the rows that have it, ascending.
    fn rows_of_bodies(&self) -> Vec<Vec<u32>> {
        let mut of_body = vec![Vec::new(); self.velocities.len()];
        for (index, row) in self.rows.iter().enumerate() {
            for body in [row.a, row.b] {
                if body != FIXED {
                    of_body[body].push(index as u32);
                }
            }
        }
        of_body
    }
}
