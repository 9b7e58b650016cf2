//! Red-black ordering (SEED S16): a spatial grid whose cells are coloured so that equal colours never touch.
//!
//! In one dimension the cells alternate red and black; in three there are 2 x 2 x 2 colours, by the parity of each
//! coordinate. A link that spans two neighbouring cells belongs to the lower one along each axis, so that the links
//! of cell `c` have all their bodies in cells `c` and `c + 1`; cells of equal colour are two apart or more, hence
//! share no body:
//!
//! ```text
//!     red    |  black  |   red   |  black        o-o is in a red cell, o---o too: its lower end is there
//!    o-o   o-|--o      |      o--|--o
//! ```
//!
//! A link whose bodies are further apart than one cell (a long body's) goes to one serial block in a ninth phase.
//!
//! The solver shows a scheduler links alone: whoever steps the world gives the places between the steps.

use super::Flat;
use crate::worlds::OwnedWorld;
use cellstep::BodyKind;
use cellstep::cells::{IMMOVABLE, Link};

/// Colours of the grid; the phase of the rest.
const COLOURS: u32 = 8;
/// Share of the links that must span no more than one cell when an edge is chosen: a platform's need not.
const SPANNED: f64 = 0.95;
/// Cells that a grid should have: two for each of eight lanes in each of eight colours.
const CELLS: f64 = 128.0;
/// Factor between edges that are tried.
const TRY: f64 = 1.25;

/// A spatial grid over the bodies of a step.
#[derive(Clone, Debug, Default)]
pub struct Grid {
    /// Centers of the bodies that links name, metres.
    places: Vec<[f64; 3]>,
    /// Edge of a cell, metres.
    edge: f64,
}

impl Grid {
    /// A grid with cells of an edge, metres; [`Grid::look`] gives it places.
    pub fn with_edge(edge: f64) -> Self {
        Self { places: Vec::new(), edge }
    }

    /// Takes the places of all dynamic bodies, in the order in which links name them.
    pub fn look(&mut self, world: &OwnedWorld) {
        self.places.clear();
        let dynamic = world.bodies().filter(|&body| world.kind(body) == Ok(BodyKind::Dynamic));
        self.places.extend(dynamic.map(|body| world.center(body).expect("the body exists").to_f64()));
    }

    /// Edge of a cell, metres.
    pub fn edge(&self) -> f64 {
        self.edge
    }

    /// A grid over a world with the least edge at which nearly all links span one cell at most and a cell has
    /// `block_links` links on average, or fewer in a small scene, so that there are cells enough for eight lanes.
    pub fn fitted(world: &OwnedWorld, links: &[Link], block_links: u32) -> Self {
        let mut grid = Self::with_edge(1.0);
        grid.look(world);
        let mut spans: Vec<f64> = links.iter().map(|link| grid.span(link)).collect();
        spans.sort_unstable_by(f64::total_cmp);
        let Some(&least) = spans.get((spans.len() as f64 * SPANNED) as usize) else { return grid };
        grid.edge = if least > 0.0 { least } else { 1.0 };
        // In the end one cell holds all.
        let wanted = f64::from(block_links).min(links.len() as f64 / CELLS);
        while grid.mean_links(links) < wanted {
            grid.edge *= TRY;
        }
        grid
    }

    /// Greatest distance of a link's bodies along an axis.
    fn span(&self, link: &Link) -> f64 {
        if link.b == IMMOVABLE {
            return 0.0;
        }
        let (a, b) = (self.places[link.a as usize], self.places[link.b as usize]);
        (0..3).map(|axis| (a[axis] - b[axis]).abs()).fold(0.0, f64::max)
    }

    /// Links of a cell that has some, on average.
    fn mean_links(&self, links: &[Link]) -> f64 {
        let mut cells: Vec<[i64; 3]> = links.iter().filter_map(|link| self.cell(link)).collect();
        let count = cells.len();
        cells.sort_unstable();
        cells.dedup();
        count as f64 / cells.len().max(1) as f64
    }

    /// The cell of a link, or `None` if it spans more than two along an axis.
    fn cell(&self, link: &Link) -> Option<[i64; 3]> {
        let cell_of = |body: u32| self.places[body as usize].map(|x| (x / self.edge).floor() as i64);
        let a = cell_of(link.a);
        if link.b == IMMOVABLE {
            return Some(a);
        }
        let b = cell_of(link.b);
        let near = (0..3).all(|axis| (a[axis] - b[axis]).abs() <= 1);
        near.then(|| core::array::from_fn(|axis| a[axis].min(b[axis])))
    }

    /// Orders links: a block for each cell, a phase for each colour that occurs.
    ///
    /// # Panics
    /// When a link names a body whose place was not taken.
    pub fn order(&self, _: u32, links: &[Link]) -> Flat {
        let mut keys: Vec<(u32, [i64; 3], u32, u32)> = Vec::with_capacity(links.len());
        for (index, link) in links.iter().enumerate() {
            keys.push(match self.cell(link) {
                Some(cell) => (colour(cell), cell, link.kind, index as u32),
                None => (COLOURS, [0; 3], 0, index as u32),
            });
        }
        keys.sort_unstable();
        let mut flat = Flat { order: Vec::with_capacity(links.len()), blocks: Vec::new() };
        let (mut phase, mut last) = (0, None);
        for (colour, cell, _, index) in keys {
            if last != Some((colour, cell)) {
                flat.close(phase);
                phase += u32::from(last.is_some_and(|(before, _)| before != colour));
                last = Some((colour, cell));
            }
            flat.order.push(index);
        }
        flat.close(phase);
        flat.longest_first()
    }
}

/// By the parity of each coordinate.
fn colour(cell: [i64; 3]) -> u32 {
    cell.iter().fold(0, |bits, c| bits << 1 | c.rem_euclid(2) as u32)
}
