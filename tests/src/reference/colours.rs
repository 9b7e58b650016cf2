//! Algebraic multi-colour ordering (SEED S14, Mifune 2005): a greedy colouring of the rows of A.
//!
//! The talk's code, with the search for entries that are not zero limited to the rows that share a body:
//!
//! ```text
//! for row i:  color[i] = the least color of none of the rows j < i with A[i][j] != 0
//! ```
//!
//! It colours **rows**, not contacts: the seven rows of a box on a floor are coupled to each other, hence take up
//! to seven colours where the contact is one link.

use super::{FIXED, Problem, Row};

/// Entries of A smaller than this times `sqrt(A_ii A_jj)` are zero but for rounding.
pub const COUPLED: f64 = 1.0e-12;

/// Whether the entry of A of two rows is not zero.
pub fn is_coupled(one: &Row, other: &Row) -> bool {
    one.coupling(other).abs() > COUPLED * (one.diagonal * other.diagonal).sqrt()
}

/// The rows of each colour, ascending.
pub fn colours(problem: &Problem) -> Vec<Vec<u32>> {
    let of_body = problem.rows_of_bodies();
    let mut colour_of: Vec<usize> = Vec::with_capacity(problem.rows.len());
    let mut colours: Vec<Vec<u32>> = Vec::new();
    // The last row that met a colour.
    let mut met: Vec<usize> = Vec::new();
    for (index, row) in problem.rows.iter().enumerate() {
        let bodies = [row.a, row.b].into_iter().filter(|&body| body != FIXED);
        let earlier = bodies.flat_map(|body| of_body[body].iter().take_while(|&&j| (j as usize) < index));
        for &j in earlier {
            let colour = colour_of[j as usize];
            if met[colour] != index && is_coupled(row, &problem.rows[j as usize]) {
                met[colour] = index;
            }
        }
        let colour = met.iter().position(|&last| last != index).unwrap_or(met.len());
        if colour == met.len() {
            met.push(usize::MAX);
            colours.push(Vec::new());
        }
        colours[colour].push(index as u32);
        colour_of.push(colour);
    }
    colours
}
