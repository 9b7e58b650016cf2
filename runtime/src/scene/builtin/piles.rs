//! Scenes that fall: free fall, a pile in a box, bowls, and the platform that everything rests on.

use super::parts::{ROCK, Random, body, cuboid, ground, mixed, rock};
use crate::scene::format::{BodyDoc, GeometryDoc, KindDoc, MeshDoc, Scene, ShapeDoc};
use cellstep_core::math::{PI, cos, sin};
use std::collections::BTreeMap;

/// Distance of falling bodies, metres: more than twice the radius of the largest, and the jitter.
const SPACING: f64 = 1.375;
/// Greatest jitter, metres.
const JITTER: f64 = 0.08;
/// Balls above each bowl.
const BALLS: u32 = 30;

/// The least number whose `power`-th power is at least `n`.
pub(super) fn root(n: u32, power: u32) -> u32 {
    (1..).find(|&edge: &u32| edge.pow(power) >= n).unwrap_or(1)
}

/// `size` mixed bodies that fall from rest on a grid and never meet anything.
pub fn free_fall(size: u32) -> Scene {
    let mut random = Random::new(1);
    let edge = root(size, 3);
    let bodies = (0..size)
        .map(|index| {
            let cell = [index % edge, index / edge % edge, index / edge / edge];
            let position = cell.map(|c| 2.0 * f64::from(c));
            BodyDoc { rotation: random.rotation(), ..body(position, mixed(index as usize)) }
        })
        .collect();
    Scene { hulls: rocks(), bodies, ..Scene::default() }
}

fn rocks() -> BTreeMap<String, crate::scene::format::HullDoc> {
    BTreeMap::from([(ROCK.to_string(), rock())])
}

/// `size` mixed bodies that fall into a box with walls, wide enough for a pile about as high as it is wide.
pub fn mixed_pile(size: u32) -> Scene {
    let mut random = Random::new(2);
    let edge = root(size, 3);
    let inner = SPACING * f64::from(edge) * 0.5;
    let mut bodies = vec![walled_box(inner as f32, (SPACING * f64::from(edge)) as f32)];
    for index in 0..size {
        let cell = [index % edge, index / edge % edge, index / edge / edge];
        let at = |c: u32| SPACING * (f64::from(c) + 0.5);
        let position = [
            at(cell[0]) - inner + random.within(JITTER),
            at(cell[1]) - inner + random.within(JITTER),
            at(cell[2]) + 0.5 + random.within(JITTER),
        ];
        bodies.push(BodyDoc { rotation: random.rotation(), ..body(position, mixed(index as usize)) });
    }
    Scene { hulls: rocks(), bodies, ..Scene::default() }
}

/// A static floor with four walls around a square of half edge `inner`, `height` high, metres.
fn walled_box(inner: f32, height: f32) -> BodyDoc {
    const HALF_THICKNESS: f32 = 0.5;
    let half = inner + 2.0 * HALF_THICKNESS;
    let slab = |position, half_extents| ShapeDoc { position, ..ShapeDoc::new(cuboid(half_extents)) };
    let side = inner + HALF_THICKNESS;
    let middle = height * 0.5;
    BodyDoc {
        kind: KindDoc::Static,
        shapes: vec![
            slab([0.0, 0.0, -HALF_THICKNESS], [half, half, HALF_THICKNESS]),
            slab([side, 0.0, middle], [HALF_THICKNESS, half, middle]),
            slab([-side, 0.0, middle], [HALF_THICKNESS, half, middle]),
            slab([0.0, side, middle], [half, HALF_THICKNESS, middle]),
            slab([0.0, -side, middle], [half, HALF_THICKNESS, middle]),
        ],
        ..BodyDoc::default()
    }
}

/// `size` bowls in a square, each with thirty balls that fall into it. All bowls are one mesh.
pub fn bowls(size: u32) -> Scene {
    const NAME: &str = "bowl";
    const DISTANCE: f64 = 6.0;
    let mut random = Random::new(3);
    let edge = root(size, 2);
    let mut bodies = vec![ground()];
    let mut balls = Vec::new();
    for index in 0..size {
        let [x, y] = [index % edge, index / edge].map(|c| DISTANCE * f64::from(c));
        bodies.push(BodyDoc {
            kind: KindDoc::Static,
            position: [x, y, 0.0],
            shapes: vec![ShapeDoc::new(GeometryDoc::Mesh(NAME.to_string()))],
            ..BodyDoc::default()
        });
        for ball in 0..BALLS {
            // Layers of three by three, well inside the rim.
            let [column, row, layer] = [ball % 3, ball / 3 % 3, ball / 9].map(f64::from);
            let position = [
                x + (column - 1.0) * 0.6875 + random.within(JITTER),
                y + (row - 1.0) * 0.6875 + random.within(JITTER),
                3.0 + layer * 0.6875 + random.within(JITTER),
            ];
            balls.push(body(position, GeometryDoc::Sphere { radius: 0.25 }));
        }
    }
    bodies.extend(balls);
    Scene { meshes: BTreeMap::from([(NAME.to_string(), bowl())]), bodies, ..Scene::default() }
}

/// Half a sphere of radius 2.5 m that stands on z = 0, open above, as rings of flat faces around its pole.
fn bowl() -> MeshDoc {
    const RADIUS: f32 = 2.5;
    const RINGS: u32 = 8;
    const SIDES: u32 = 24;
    let mut vertices = vec![[0.0, 0.0, 0.0]];
    let mut triangles = Vec::new();
    // Millimetres: short in JSON.
    let round = |x: f32| (x * 1000.0).round() / 1000.0;
    for ring in 1..=RINGS {
        let polar = PI * 0.5 * ring as f32 / RINGS as f32;
        for side in 0..SIDES {
            let turn = 2.0 * PI * side as f32 / SIDES as f32;
            let flat = RADIUS * sin(polar);
            vertices.push([
                round(flat * cos(turn)),
                round(flat * sin(turn)),
                round(RADIUS * (1.0 - cos(polar))),
            ]);
        }
    }
    let corner = |ring: u32, side: u32| 1 + (ring - 1) * SIDES + side % SIDES;
    for side in 0..SIDES {
        triangles.push([0, corner(1, side), corner(1, side + 1)]);
        for ring in 1..RINGS {
            let [a, b] = [corner(ring, side), corner(ring, side + 1)];
            let [c, d] = [corner(ring + 1, side + 1), corner(ring + 1, side)];
            triangles.push([a, d, c]);
            triangles.push([a, c, b]);
        }
    }
    MeshDoc::inline(vertices, triangles)
}

/// One dynamic platform on the ground under `size` boxes that rest on it: every box is a neighbour of one
/// body.
pub fn hub(size: u32) -> Scene {
    const DISTANCE: f64 = 0.75;
    let edge = root(size, 2);
    let half = DISTANCE * 0.5 * f64::from(edge) + 0.25;
    let mut bodies = vec![ground(), body([0.0, 0.0, 0.25], cuboid([half as f32, half as f32, 0.25]))];
    for index in 0..size {
        let [x, y] =
            [index % edge, index / edge].map(|c| DISTANCE * (f64::from(c) - 0.5 * f64::from(edge - 1)));
        bodies.push(body([x, y, 0.75], cuboid([0.25; 3])));
    }
    Scene { bodies, ..Scene::default() }
}
