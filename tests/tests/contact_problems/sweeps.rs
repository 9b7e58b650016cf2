//! Problems as rows of the solver.

use crate::read::{Bodies, Problem};
use cellstep::kernel::{KernelBody, KernelContact, KernelRow, ROW_CONTACTS, SPARE_BODIES};
use cellstep::math::Vec3;

/// Greatest departure of a direction from a unit vector.
const ROUNDING: f64 = 1.0e-6;

/// Sweeps over the rows of a problem.
pub trait Solver {
    /// How many rows of eight contacts there are.
    fn rows(&self) -> usize;
    /// Visits all rows.
    fn sweep(&mut self);
    /// Impulses by contact.
    fn impulses(&self) -> Vec<[f64; 3]>;
    /// The residual that the solver measures, m/s.
    fn residual(&mut self) -> f64;
}

/// Deals contacts to rows of eight of which no two have something in common.
fn deal(contacts: usize, meets: impl Fn(usize, usize) -> bool) -> Vec<Vec<usize>> {
    let mut rows: Vec<Vec<usize>> = Vec::new();
    for contact in 0..contacts {
        let fits = |row: &&mut Vec<usize>| {
            row.len() < ROW_CONTACTS && !row.iter().any(|&other| meets(contact, other))
        };
        match rows.iter_mut().find(fits) {
            Some(row) => row.push(contact),
            None => rows.push(vec![contact]),
        }
    }
    rows
}

fn vector(v: &[f64]) -> Vec3 {
    Vec3::new(v[0] as f32, v[1] as f32, v[2] as f32)
}

/// A row, its contacts, and the sign of each one's second tangent.
struct Dealt {
    row: KernelRow,
    contacts: Vec<usize>,
    signs: Vec<f64>,
}

impl Dealt {
    fn read(rows: &[Dealt], contacts: usize) -> Vec<[f64; 3]> {
        let mut impulses = vec![[0.0; 3]; contacts];
        for dealt in rows {
            for (lane, (&contact, sign)) in dealt.contacts.iter().zip(&dealt.signs).enumerate() {
                let [n, t, s] = dealt.row.impulse(lane).map(f64::from);
                impulses[contact] = [n, t, sign * s];
            }
        }
        impulses
    }
}

/// A problem whose bodies are known.
pub struct Jointly {
    rows: Vec<Dealt>,
    bodies: Vec<KernelBody>,
    contacts: usize,
}

impl Jointly {
    /// `None` where some contact's directions are no unit vectors across each other, as those of rows are.
    pub fn new(problem: &Problem, from: &Bodies) -> Option<Self> {
        let masses = from.roots.iter().zip(&from.velocities);
        let mut bodies: Vec<KernelBody> = masses
            .map(|(root, u)| {
                assert!(root[..3].iter().all(|x| x == &root[0]), "one mass for all directions");
                KernelBody::new(vector(u) * root[0] as f32, (root[0] * root[0]) as f32, vector(&u[3..]))
            })
            .collect();
        bodies.extend([KernelBody::spare(); SPARE_BODIES]);
        let meets = |a: usize, b: usize| {
            from.contacts[a].iter().any(|(body, _)| from.contacts[b].iter().any(|(other, _)| body == other))
        };
        let contacts = problem.friction.len();
        let rows = deal(contacts, meets).into_iter().map(|contacts| {
            let given: Option<Vec<(KernelContact, f64)>> =
                contacts.iter().map(|&contact| between(problem, from, contact)).collect();
            let (given, signs): (Vec<KernelContact>, Vec<f64>) = given?.into_iter().unzip();
            Some(Dealt { row: KernelRow::new(&given, &bodies), contacts, signs })
        });
        let rows: Option<Vec<Dealt>> = rows.collect();
        Some(Self { rows: rows?, contacts, bodies })
    }
}

/// A contact between bodies, and the sign of its second tangent against ours, which is normal x tangent.
fn between(problem: &Problem, from: &Bodies, contact: usize) -> Option<(KernelContact, f64)> {
    let ends = &from.contacts[contact];
    assert!((1..=2).contains(&ends.len()), "a contact is of one or two bodies");
    // The rate is d . (vb - va): the linear jacobian of A is -d.
    let (a, rows_a) = &ends[0];
    let linear = |k: usize| -> [f64; 3] { core::array::from_fn(|i| -rows_a[k][i] / from.roots[*a][i]) };
    let [n, t, s] = [linear(0), linear(1), linear(2)];
    let cross = [n[1] * t[2] - n[2] * t[1], n[2] * t[0] - n[0] * t[2], n[0] * t[1] - n[1] * t[0]];
    let product = |a: &[f64; 3], b: &[f64; 3]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
    let sign = product(&cross, &s).signum();
    let units = [(&n, &n, 1.0), (&t, &t, 1.0), (&n, &t, 0.0), (&cross, &s, sign)];
    if units.iter().any(|(a, b, wanted)| (product(a, b) - wanted).abs() > ROUNDING) {
        return None;
    }
    let signs = [1.0, 1.0, sign];
    let turns =
        |rows: &[[f64; 6]; 3], side: f64| [0, 1, 2].map(|k| vector(&rows[k][3..]) * (side * signs[k]) as f32);
    let mut given = KernelContact {
        bodies: [Some(*a as u32), None],
        directions: [vector(&n), vector(&t)],
        turns: [turns(rows_a, -1.0), [Vec3::ZERO; 3]],
        bias: [0, 1, 2].map(|k| (signs[k] * from.surfaces[3 * contact + k]) as f32),
        friction: problem.friction[contact] as f32,
    };
    if let Some((b, rows_b)) = ends.get(1) {
        for (k, d) in [n, t, s].iter().enumerate() {
            let opposite = (0..3).all(|i| (rows_b[k][i] / from.roots[*b][i] - d[i]).abs() < ROUNDING);
            assert!(opposite, "what is done to A is done to B");
        }
        given.bodies[1] = Some(*b as u32);
        given.turns[1] = turns(rows_b, 1.0);
    }
    Some((given, sign))
}

impl Solver for Jointly {
    fn rows(&self) -> usize {
        self.rows.len()
    }

    fn sweep(&mut self) {
        for dealt in &mut self.rows {
            dealt.row.visit(&mut self.bodies);
        }
    }

    fn impulses(&self) -> Vec<[f64; 3]> {
        Dealt::read(&self.rows, self.contacts)
    }

    fn residual(&mut self) -> f64 {
        let rows = self.rows.iter().map(|dealt| dealt.row.residual(&self.bodies).greatest());
        rows.fold(0.0, |most: f64, own| most.max(own.into()))
    }
}

/// A problem of which no more is known than W.
pub struct Blocks<'a> {
    rows: Vec<Dealt>,
    /// A body for each lane of a row.
    bodies: Vec<KernelBody>,
    problem: &'a Problem,
    /// W by columns: rows and values. It need not be quite symmetric: that of the
    /// capsules is off by up to 2.4 %.
    columns: Vec<Vec<(usize, f64)>>,
    /// `W r + q`.
    rates: Vec<f64>,
}

impl<'a> Blocks<'a> {
    pub fn new(problem: &'a Problem) -> Self {
        let contacts = problem.friction.len();
        let bodies = vec![KernelBody::spare(); ROW_CONTACTS + SPARE_BODIES];
        let meets = |a: usize, b: usize| {
            (0..3).any(|k| problem.matrix[3 * a + k].iter().any(|&(column, x)| column / 3 == b && x != 0.0))
        };
        let rows = deal(contacts, |a, b| meets(a, b) || meets(b, a)).into_iter().map(|contacts| {
            let given: Vec<KernelContact> = contacts
                .iter()
                .enumerate()
                .map(|(lane, &contact)| KernelContact {
                    bodies: [Some(lane as u32), None],
                    directions: [Vec3::X, Vec3::Y],
                    turns: [factor(problem, contact), [Vec3::ZERO; 3]],
                    bias: [0.0; 3],
                    friction: problem.friction[contact] as f32,
                })
                .collect();
            let signs = vec![1.0; contacts.len()];
            Dealt { row: KernelRow::new(&given, &bodies), contacts, signs }
        });
        let rows = rows.collect();
        let mut columns = vec![Vec::new(); problem.rates.len()];
        for (row, entries) in problem.matrix.iter().enumerate() {
            entries.iter().for_each(|&(column, x)| columns[column].push((row, x)));
        }
        Self { rows, bodies, problem, columns, rates: problem.rates.clone() }
    }

    /// Writes the rates of a row's contacts to its bodies.
    fn aim(&mut self, row: usize) {
        for (lane, &contact) in self.rows[row].contacts.iter().enumerate() {
            let velocity = vector(&self.rates[3 * contact..]) * -1.0;
            self.bodies[lane] = KernelBody::new(velocity, 0.0, Vec3::ZERO);
        }
    }
}

/// Three vectors whose products are a contact's own block of W: the rows of its Cholesky factor.
fn factor(problem: &Problem, contact: usize) -> [Vec3; 3] {
    let entry = |i: usize, k: usize| -> f64 {
        let row = &problem.matrix[3 * contact + i];
        row.iter().filter(|entry| entry.0 == 3 * contact + k).map(|entry| entry.1).sum()
    };
    let mut l = [[0.0; 3]; 3];
    for i in 0..3 {
        for k in 0..=i {
            let known: f64 = (0..k).map(|j| l[i][j] * l[k][j]).sum();
            l[i][k] = if i == k { (entry(i, i) - known).sqrt() } else { (entry(i, k) - known) / l[k][k] };
        }
    }
    l.map(|row| vector(&row))
}

impl Solver for Blocks<'_> {
    fn rows(&self) -> usize {
        self.rows.len()
    }

    fn sweep(&mut self) {
        for row in 0..self.rows.len() {
            self.aim(row);
            let dealt = &mut self.rows[row];
            let before: Vec<[f32; 3]> =
                (0..dealt.contacts.len()).map(|lane| dealt.row.impulse(lane)).collect();
            dealt.row.visit(&mut self.bodies);
            for (lane, (&contact, before)) in dealt.contacts.iter().zip(before).enumerate() {
                let after = dealt.row.impulse(lane);
                for k in 0..3 {
                    let change = f64::from(after[k]) - f64::from(before[k]);
                    for &(other, x) in &self.columns[3 * contact + k] {
                        self.rates[other] += x * change;
                    }
                }
            }
        }
    }

    fn impulses(&self) -> Vec<[f64; 3]> {
        Dealt::read(&self.rows, self.problem.friction.len())
    }

    fn residual(&mut self) -> f64 {
        let mut most = 0.0_f64;
        for row in 0..self.rows.len() {
            self.aim(row);
            most = most.max(self.rows[row].row.residual(&self.bodies).greatest().into());
        }
        most
    }
}
