//! The rows of one step, and the problem that they are.

use super::Bounded;
use crate::worlds::OwnedWorld;
use cellstep::observe::{ProblemBody, ProblemKind, ProblemRow};
use cellstep::{Observer, Serial, Stage, StageView, StepReport};

/// Impulses from which on a bound is none, N s.
const NO_BOUND: f32 = 1.0e20;
/// Share of a row's own entry that is added to it, so that rows that depend on each other have an answer: it
/// changes that by no more than this share.
const DIAGONAL: f64 = 1.0e-11;
/// What a step of one substep without relax sweeps showed.
#[derive(Default)]
pub struct Seen {
    /// Bodies that were solved.
    pub bodies: Vec<ProblemBody>,
    /// Rows as they were solved, with the impulses that came out.
    pub rows: Vec<ProblemRow>,
    /// What the step told.
    pub report: StepReport,
}

impl Observer for Seen {
    fn after(&mut self, stage: Stage, view: &StageView<'_, '_>) {
        match stage {
            Stage::Assembly => {
                self.bodies = view.bodies().collect();
                self.rows.clear();
                view.each_row(|row| self.rows.push(row));
            }
            Stage::Solve => {
                let mut index = 0;
                view.each_row(|after| {
                    let row = &mut self.rows[index];
                    assert_eq!(
                        (row.link, row.bodies),
                        (after.link, after.bodies),
                        "the rows keep their order"
                    );
                    row.impulse = after.impulse;
                    if let ProblemKind::Bound { .. } = row.kind {
                        row.kind = after.kind;
                    }
                    index += 1;
                });
            }
            _ => {}
        }
    }
}

/// An answer for the rows of a step: impulses by row.
pub type Answer = Vec<f64>;

/// Load and direction of friction of a row.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Friction {
    load: f64,
    /// Cosine and sine of the direction from the first tangent.
    direction: [f64; 2],
}

impl Seen {
    /// Steps a world.
    pub fn step(world: &mut OwnedWorld) -> Self {
        let mut seen = Self::default();
        let report = world.step_observed(&mut Serial, &mut seen);
        seen.report = report;
        seen
    }

    /// The solver's impulses.
    pub fn ours(&self) -> Answer {
        self.rows.iter().map(|row| row.impulse.into()).collect()
    }

    /// Velocities of the bodies after these impulses: linear, then whitened angular.
    pub fn velocities(&self, answer: &[f64]) -> Vec<[f64; 6]> {
        let mut u: Vec<[f64; 6]> = self.bodies.iter().map(|body| body.velocity.map(f64::from)).collect();
        for (row, x) in self.rows.iter().zip(answer) {
            for (end, body) in row.bodies.iter().enumerate() {
                if let Some(body) = body {
                    let masses = inverse_masses(&self.bodies[*body as usize]);
                    for (k, u) in u[*body as usize].iter_mut().enumerate() {
                        *u += masses[k] * f64::from(row.jacobian[end][k]) * x;
                    }
                }
            }
        }
        u
    }

    /// Sum of the normal impulses of a link.
    pub fn load(&self, answer: &[f64], link: u32) -> f64 {
        let normals = self.rows.iter().zip(answer);
        normals.filter(|(row, _)| is_normal(row) && row.link == link).map(|(_, x)| x).sum()
    }

    /// The normal impulses that bound the friction of a row: those of its link, or that of its point.
    fn bounding(&self, answer: &[f64], row: &ProblemRow) -> f64 {
        let ProblemKind::PointTangent { point, .. } = row.kind else { return self.load(answer, row.link) };
        let normals = self.rows.iter().zip(answer);
        let mut own = normals.filter(|(other, _)| is_normal(other) && other.link == row.link);
        own.nth(point as usize).map_or(0.0, |(_, x)| *x)
    }

    /// The answer by the direct method, for the bounds that the loads of ours give, and with a box along the
    /// direction of our friction in the place of the disc. Where ours is the answer, so is this: friction that
    /// slides lies along an axis of its box, and friction that holds is within.
    pub fn solve(&self) -> Answer {
        let ours = self.ours();
        let mut frictions: Vec<Friction> = self
            .rows
            .iter()
            .map(|row| Friction { load: self.bounding(&ours, row), direction: [1.0, 0.0] })
            .collect();
        for i in (0..self.rows.len()).filter(|&i| starts_pair(&self.rows, i)) {
            let size = ours[i].hypot(ours[i + 1]);
            if size > 0.0 {
                frictions[i].direction = [ours[i] / size, ours[i + 1] / size];
            }
        }
        self.solve_once(&frictions)
    }

    /// The answer for given loads and directions: a box along the direction takes the place of the disc.
    fn solve_once(&self, frictions: &[Friction]) -> Answer {
        let mut split = Split::default();
        let mut rest = self.rows.as_slice();
        while let [row, after @ ..] = rest {
            let friction = &frictions[self.rows.len() - rest.len()];
            rest = match (row.kind, after) {
                (
                    ProblemKind::Tangent { friction: share }
                    | ProblemKind::PointTangent { friction: share, .. },
                    [other, rest @ ..],
                ) => {
                    split.add_tangents([row, other], friction.direction, f64::from(share) * friction.load);
                    rest
                }
                _ => {
                    split.add(row, friction.load);
                    after
                }
            };
        }
        let matrix = self.matrix(&split.rows);
        let rates = split.rows.iter().map(|row| row.bias + self.rate(row)).collect();
        let (low, high) = split.rows.iter().map(|row| (row.low, row.high)).unzip();
        let x = Bounded { matrix, rates, low, high }.solve();
        split.parts.iter().map(|parts| parts.iter().map(|&(row, factor)| factor * x[row]).sum()).collect()
    }

    /// `J u0`.
    fn rate(&self, row: &Wide) -> f64 {
        let ends = row.bodies.iter().zip(&row.jacobian);
        let end = |(body, jacobian): (&Option<u32>, &[f64; 6])| {
            let velocity = body.map(|body| self.bodies[body as usize].velocity)?;
            Some(velocity.iter().zip(jacobian).map(|(&u, j)| f64::from(u) * j).sum::<f64>())
        };
        ends.filter_map(end).sum()
    }

    /// `J M^-1 Jt + soft`.
    fn matrix(&self, rows: &[Wide]) -> Vec<Vec<f64>> {
        let entry = |a: &Wide, b: &Wide| {
            let mut sum = 0.0;
            for (own, jacobian) in a.bodies.iter().zip(&a.jacobian) {
                for (other, with) in b.bodies.iter().zip(&b.jacobian) {
                    if let (Some(body), true) = (own, own == other) {
                        let masses = inverse_masses(&self.bodies[*body as usize]);
                        sum += (0..6).map(|k| masses[k] * jacobian[k] * with[k]).sum::<f64>();
                    }
                }
            }
            sum
        };
        let mut matrix: Vec<Vec<f64>> =
            rows.iter().map(|a| rows.iter().map(|b| entry(a, b)).collect()).collect();
        for (i, row) in rows.iter().enumerate() {
            matrix[i][i] += row.soft + DIAGONAL * matrix[i][i];
        }
        matrix
    }
}

/// A row in double precision, with given bounds.
struct Wide {
    jacobian: [[f64; 6]; 2],
    bodies: [Option<u32>; 2],
    soft: f64,
    bias: f64,
    low: f64,
    high: f64,
}

/// Our rows as rows with given bounds.
#[derive(Default)]
struct Split {
    rows: Vec<Wide>,
    /// For each row of ours those that it is the sum of, with factors.
    parts: Vec<Vec<(usize, f64)>>,
}

impl Split {
    fn push(&mut self, row: &ProblemRow, jacobian: [[f64; 6]; 2], bias: f64, [low, high]: [f64; 2]) -> usize {
        self.rows.push(Wide { jacobian, bodies: row.bodies, soft: row.soft.into(), bias, low, high });
        self.rows.len() - 1
    }

    fn add(&mut self, row: &ProblemRow, load: f64) {
        let own = wide(&row.jacobian);
        let bias = f64::from(row.bias);
        let mut parts = Vec::new();
        let mut add = |bias: f64, bounds: [f64; 2]| parts.push((self.push(row, own, bias, bounds), 1.0));
        match row.kind {
            ProblemKind::Normal => add(bias, [0.0, f64::INFINITY]),
            ProblemKind::Tangent { .. } | ProblemKind::PointTangent { .. } | ProblemKind::Hold => {
                add(bias, [f64::NEG_INFINITY, f64::INFINITY]);
            }
            ProblemKind::Twist { friction, radius } => {
                let most = f64::from(friction) * f64::from(radius) * load;
                add(bias, [-most, most]);
            }
            ProblemKind::Bound { least, greatest, most } => {
                let most = if most < NO_BOUND { f64::from(most) } else { f64::INFINITY };
                if least == greatest {
                    add(bias - f64::from(least), [-most, most]);
                } else {
                    add(bias - f64::from(least), [0.0, most]);
                    add(bias - f64::from(greatest), [-most, 0.0]);
                }
            }
        }
        self.parts.push(parts);
    }

    /// Two tangents as rows along a direction and across it.
    fn add_tangents(&mut self, [row, other]: [&ProblemRow; 2], [c, s]: [f64; 2], most: f64) {
        let (first, second) = (wide(&row.jacobian), wide(&other.jacobian));
        let mix = |x: f64, y: f64| {
            let jacobian: [[f64; 6]; 2] =
                core::array::from_fn(|end| core::array::from_fn(|k| x * first[end][k] + y * second[end][k]));
            (jacobian, x * f64::from(row.bias) + y * f64::from(other.bias))
        };
        let ((along, slip), (across, drift)) = (mix(c, s), mix(-s, c));
        let along = self.push(row, along, slip, [-most, most]);
        let across = self.push(row, across, drift, [-most, most]);
        self.parts.push(vec![(along, c), (across, -s)]);
        self.parts.push(vec![(along, s), (across, c)]);
    }
}

fn wide(jacobian: &[[f32; 6]; 2]) -> [[f64; 6]; 2] {
    jacobian.map(|end| end.map(f64::from))
}

fn inverse_masses(body: &ProblemBody) -> [f64; 6] {
    let m = f64::from(body.inverse_mass);
    [m, m, m, 1.0, 1.0, 1.0]
}

fn is_normal(row: &ProblemRow) -> bool {
    row.kind == ProblemKind::Normal
}

fn is_tangent(row: &ProblemRow) -> bool {
    matches!(row.kind, ProblemKind::Tangent { .. } | ProblemKind::PointTangent { .. })
}

/// True when the row at `i` is the first of two tangents.
fn starts_pair(rows: &[ProblemRow], i: usize) -> bool {
    let next = rows.get(i + 1);
    // Pairs follow one another, so that every second row starts one.
    let before = rows[..i].iter().rev().take_while(|row| is_tangent(row)).count();
    is_tangent(&rows[i]) && before % 2 == 0 && next.is_some_and(|next| next.kind == rows[i].kind)
}
