//! Problems in the FCLIB layout (Acary, Bremond, Koziara, Perignon: a collection of discrete frictional contact
//! problems, 2014), from HDF5 files.
//!
//! ```text
//! local    u = W r + q
//! global   M v = H r + f      u = Ht v + w
//! ```
//! with three rows for each contact, the normal's first. A global problem says its bodies: six velocities each.

use hdf5_pure::File;
use std::path::Path;

/// A matrix as entries `(row, column, value)`.
pub type Entries = Vec<(usize, usize, f64)>;

/// A problem of contacts with friction.
pub struct Problem {
    /// W, by rows: columns and values.
    pub matrix: Vec<Vec<(usize, f64)>>,
    /// q.
    pub rates: Vec<f64>,
    /// Coefficient of friction of each contact.
    pub friction: Vec<f64>,
    /// What a global problem says of its bodies.
    pub bodies: Option<Bodies>,
}

/// The bodies of a global problem.
pub struct Bodies {
    /// Root of the inverse mass matrix of each body, block by block: the velocities times its inverse are whitened.
    pub roots: Vec<[f64; 6]>,
    /// Whitened velocities without contacts.
    pub velocities: Vec<[f64; 6]>,
    /// For each contact its bodies, and for each of them the whitened jacobians of the three rows.
    pub contacts: Vec<Vec<(usize, [[f64; 6]; 3])>>,
    /// w.
    pub surfaces: Vec<f64>,
}

/// Reads a file.
pub fn read(path: &Path) -> Result<Problem, hdf5_pure::Error> {
    let file = File::open(path)?;
    let is_local = file.root().groups()?.iter().any(|name| name == "fclib_local");
    if is_local {
        let entries = matrix(&file, "fclib_local/W")?;
        let rates = numbers(&file, "fclib_local/vectors/q")?;
        let friction = numbers(&file, "fclib_local/vectors/mu")?;
        return Ok(Problem { matrix: rows(&entries, rates.len()), rates, friction, bodies: None });
    }
    let masses = matrix(&file, "fclib_global/M")?;
    let jacobians = matrix(&file, "fclib_global/H")?;
    let vector = |name: &str| numbers(&file, &format!("fclib_global/vectors/{name}"));
    let (f, w, friction) = (vector("f")?, vector("w")?, vector("mu")?);
    let bodies = bodies(&masses, &jacobians, (&f, w));
    Ok(Problem { matrix: bodies.matrix(), rates: bodies.rates(), friction, bodies: Some(bodies) })
}

fn numbers(file: &File, name: &str) -> Result<Vec<f64>, hdf5_pure::Error> {
    file.dataset(name)?.read_f64()
}

/// A sparse matrix: compressed columns where `nz` is -1, rows where it is -2, else triplets.
fn matrix(file: &File, name: &str) -> Result<Entries, hdf5_pure::Error> {
    let integers = |field: &str| file.dataset(&format!("{name}/{field}"))?.read_i32();
    let (p, i, x) = (integers("p")?, integers("i")?, numbers(file, &format!("{name}/x"))?);
    let nz = integers("nz")?[0];
    let index = |x: i32| usize::try_from(x).expect("an index");
    if nz >= 0 {
        let triplets = i.iter().zip(&p).zip(&x).take(index(nz));
        return Ok(triplets.map(|((&row, &column), &x)| (index(row), index(column), x)).collect());
    }
    let mut entries = Vec::new();
    for (outer, range) in p.windows(2).enumerate() {
        for k in index(range[0])..index(range[1]) {
            let inner = index(i[k]);
            entries.push(if nz == -1 { (inner, outer, x[k]) } else { (outer, inner, x[k]) });
        }
    }
    Ok(entries)
}

fn rows(entries: &Entries, count: usize) -> Vec<Vec<(usize, f64)>> {
    let mut rows = vec![Vec::new(); count];
    entries.iter().for_each(|&(row, column, x)| rows[row].push((column, x)));
    rows
}

fn bodies(masses: &Entries, jacobians: &Entries, (f, surfaces): (&[f64], Vec<f64>)) -> Bodies {
    let mut diagonal = vec![0.0; f.len()];
    for &(row, column, x) in masses {
        assert!(row == column || x == 0.0, "the masses of these problems are diagonal");
        diagonal[row] += x;
    }
    let root = |k: usize| 1.0 / diagonal[k].sqrt();
    let six = |of: &dyn Fn(usize) -> f64, body: usize| core::array::from_fn(|k| of(6 * body + k));
    let count = f.len() / 6;
    let mut contacts: Vec<Vec<(usize, [[f64; 6]; 3])>> = vec![Vec::new(); surfaces.len() / 3];
    for &(row, column, x) in jacobians {
        let (body, own) = (row / 6, &mut contacts[column / 3]);
        let place = own.iter().position(|(other, _)| *other == body).unwrap_or(own.len());
        if place == own.len() {
            own.push((body, [[0.0; 6]; 3]));
        }
        own[place].1[column % 3][row % 6] += root(row) * x;
    }
    Bodies {
        roots: (0..count).map(|body| six(&root, body)).collect(),
        velocities: (0..count).map(|body| six(&|k| root(k) * f[k], body)).collect(),
        contacts,
        surfaces,
    }
}

impl Bodies {
    /// `Ht M^-1 H`.
    fn matrix(&self) -> Vec<Vec<(usize, f64)>> {
        let mut of_body = vec![Vec::new(); self.velocities.len()];
        for (contact, ends) in self.contacts.iter().enumerate() {
            ends.iter().for_each(|(body, _)| of_body[*body].push(contact));
        }
        let mut rows = Vec::new();
        for (contact, ends) in self.contacts.iter().enumerate() {
            let mut near: Vec<usize> = ends.iter().flat_map(|(body, _)| of_body[*body].clone()).collect();
            near.sort_unstable();
            near.dedup();
            for row in 0..3 {
                let columns = near.iter().flat_map(|&other| [0, 1, 2].map(|column| (other, column)));
                let entry = |(other, column): (usize, usize)| {
                    (3 * other + column, self.entry((contact, row), (other, column)))
                };
                rows.push(columns.map(entry).collect());
            }
        }
        rows
    }

    fn entry(&self, (contact, row): (usize, usize), (other, column): (usize, usize)) -> f64 {
        let mut sum = 0.0;
        for (body, own) in &self.contacts[contact] {
            for (_, theirs) in self.contacts[other].iter().filter(|(it, _)| it == body) {
                sum += own[row].iter().zip(&theirs[column]).map(|(a, b)| a * b).sum::<f64>();
            }
        }
        sum
    }

    /// The rates without contacts.
    fn rates(&self) -> Vec<f64> {
        let rate = |(k, w): (usize, &f64)| {
            let ends = self.contacts[k / 3].iter();
            let end = |(body, rows): &(usize, [[f64; 6]; 3])| -> f64 {
                rows[k % 3].iter().zip(&self.velocities[*body]).map(|(j, u)| j * u).sum()
            };
            w + ends.map(end).sum::<f64>()
        };
        self.surfaces.iter().enumerate().map(rate).collect()
    }
}
