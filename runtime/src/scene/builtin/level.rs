//! A game level in one mesh: hills, a flight of stairs, and a rim that keeps bodies in.
//!
//! ```text
//!        rim, 4 m
//!      +----------+
//!      |  hills   |   a field of squares, two triangles each
//!      |----+     |
//!      |####|     |   stairs: treads and risers, standing in the hills
//!      +----------+
//! ```

use super::parts::{ROCK, Random, body, mixed, rock};
use crate::scene::format::{BodyDoc, GeometryDoc, KindDoc, MeshDoc, Scene, ShapeDoc};
use cellstep_core::math::sin;
use std::collections::BTreeMap;

/// Squares along an edge of the field.
const SQUARES: u32 = 40;
/// Edge of a square, metres.
const SQUARE: f32 = 1.0;
/// Half the edge of the field, metres.
const HALF: f32 = 0.5 * SQUARE * SQUARES as f32;
/// Height of the rim, metres.
const RIM: f32 = 4.0;
/// Steps of the stairs, their depth, rise and width, metres.
const STEPS: u32 = 10;
const TREAD: f32 = 1.0;
const RISE: f32 = 0.3;
const WIDTH: f32 = 8.0;

/// `size` mixed bodies that fall on the level.
pub fn level(size: u32) -> Scene {
    const NAME: &str = "level";
    /// Bodies along an edge of each falling layer, and their distance, metres.
    const EDGE: u32 = 20;
    const DISTANCE: f64 = 1.625;
    let mut random = Random::new(4);
    let mut bodies = vec![BodyDoc {
        kind: KindDoc::Static,
        shapes: vec![ShapeDoc::new(GeometryDoc::Mesh(NAME.to_string()))],
        ..BodyDoc::default()
    }];
    for index in 0..size {
        let cell = [index % EDGE, index / EDGE % EDGE, index / EDGE / EDGE];
        let at = |c: u32| DISTANCE * (f64::from(c) - 0.5 * f64::from(EDGE - 1));
        let position = [
            at(cell[0]) + random.within(0.2),
            at(cell[1]) + random.within(0.2),
            6.0 + DISTANCE * f64::from(cell[2]) + random.within(0.2),
        ];
        bodies.push(BodyDoc { rotation: random.rotation(), ..body(position, mixed(index as usize)) });
    }
    let mut mesh = Builder::default();
    mesh.hills();
    mesh.stairs();
    mesh.rim();
    let mesh = MeshDoc::inline(mesh.vertices, mesh.triangles);
    Scene {
        hulls: BTreeMap::from([(ROCK.to_string(), rock())]),
        meshes: BTreeMap::from([(NAME.to_string(), mesh)]),
        bodies,
        ..Scene::default()
    }
}

/// Height of the hills at a place, metres, in whole millimetres.
fn height(x: f32, y: f32) -> f32 {
    let z = 0.8 * sin(0.35 * x) * sin(0.3 * y + 1.0) + 0.3 * sin(0.9 * x + 0.5 * y);
    (z * 1000.0).round() / 1000.0
}

#[derive(Default)]
struct Builder {
    vertices: Vec<[f32; 3]>,
    triangles: Vec<[u32; 3]>,
}

impl Builder {
    fn vertex(&mut self, x: f32, y: f32, z: f32) -> u32 {
        self.vertices.push([x, y, z]);
        self.vertices.len() as u32 - 1
    }

    /// Two triangles of four corners in order.
    fn quad(&mut self, [a, b, c, d]: [u32; 4]) {
        self.triangles.push([a, b, c]);
        self.triangles.push([a, c, d]);
    }

    fn hills(&mut self) {
        let place = |index: u32| SQUARE * index as f32 - HALF;
        for row in 0..=SQUARES {
            for column in 0..=SQUARES {
                let (x, y) = (place(column), place(row));
                self.vertex(x, y, height(x, y));
            }
        }
        for row in 0..SQUARES {
            for column in 0..SQUARES {
                let [low, high] = [field(column, row), field(column, row + 1)];
                self.quad([low, low + 1, high + 1, high]);
            }
        }
    }

    /// A flight that rises along x from the middle of the field, closed at its sides and its back, and deep
    /// enough in the hills to have no gap below.
    fn stairs(&mut self) {
        let (left, right, base) = (-0.5 * WIDTH, 0.5 * WIDTH, -1.5);
        let mut foot = [self.vertex(0.0, left, base), self.vertex(0.0, right, base)];
        let mut edge = foot;
        for step in 0..STEPS {
            let (near, far, z) = (TREAD * step as f32, TREAD * (step + 1) as f32, RISE * (step + 1) as f32);
            let front = [self.vertex(near, left, z), self.vertex(near, right, z)];
            let back = [self.vertex(far, left, z), self.vertex(far, right, z)];
            let below = [self.vertex(far, left, base), self.vertex(far, right, base)];
            self.quad([edge[0], edge[1], front[1], front[0]]);
            self.quad([front[0], front[1], back[1], back[0]]);
            self.quad([foot[0], front[0], back[0], below[0]]);
            self.quad([foot[1], below[1], back[1], front[1]]);
            (edge, foot) = (back, below);
        }
        self.quad([foot[1], foot[0], edge[0], edge[1]]);
    }

    /// Upright walls on the four edges of the field, which share its vertices.
    fn rim(&mut self) {
        let last = SQUARES;
        for side in 0..4 {
            let along = |index: u32| match side {
                0 => field(index, 0),
                1 => field(last, index),
                2 => field(last - index, last),
                _ => field(0, last - index),
            };
            let mut low = along(0);
            let mut high = self.above(low);
            for index in 1..=last {
                let (next_low, next_high) = (along(index), self.above(along(index)));
                self.quad([low, high, next_high, next_low]);
                (low, high) = (next_low, next_high);
            }
        }
    }

    fn above(&mut self, vertex: u32) -> u32 {
        let [x, y, _] = self.vertices[vertex as usize];
        self.vertex(x, y, RIM)
    }
}

/// Index of a vertex of the field.
fn field(column: u32, row: u32) -> u32 {
    row * (SQUARES + 1) + column
}
