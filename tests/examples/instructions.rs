//! A scene of balls alone, for counting instructions: `.ci/instructions` runs it under callgrind.
//!
//! ```text
//! cargo run --release --package cellstep-tests --example instructions [STEPS [room] [rough]]
//! ```
//! 512 balls fall on a floor of balls and come to lie. With `room` the world has capacities for all that the scene
//! does not contain: joints, assets of all kinds, materials, rules. `rough` balls resist rolling and spinning: what
//! that costs where it is asked for.

use cellstep::math::Vec3;
use cellstep::{BodyDef, BodyKind, Capacities, Geometry, MaterialTraits, Serial, ShapeDef};

/// Steps of a run without arguments.
const STEPS: u32 = 12;
/// Balls along an edge of the block that falls.
const EDGE: u32 = 8;
/// Balls along an edge of the floor.
const FLOOR: u32 = 12;

/// Balls alone, and a capacity for nothing else.
fn plain() -> Capacities {
    Capacities::for_bodies(EDGE * EDGE * EDGE + FLOOR * FLOOR)
}

/// Room for what the scene does not contain.
fn roomy() -> Capacities {
    Capacities {
        joints: 64,
        hulls: 4,
        meshes: 4,
        mesh_vertices: 256,
        mesh_triangles: 256,
        height_fields: 4,
        height_samples: 256,
        compounds: 4,
        compound_children: 64,
        surfaces: 16,
        materials: 16,
        pair_rules: 16,
        ..plain()
    }
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let steps = arguments.first().map_or(STEPS, |steps| steps.parse().expect("a number of steps"));
    let is_rough = arguments.iter().any(|word| word == "rough");
    let length = if is_rough { 0.005 } else { 0.0 };
    let traits = MaterialTraits { rolling: length, spinning: length, ..MaterialTraits::default() };
    let capacities = if arguments.iter().any(|word| word == "room") { roomy() } else { plain() };
    let mut world = cellstep::new_world(capacities).expect("capacities are in range");
    let mut put = |kind: BodyKind, place: Vec3, radius: f32| {
        let body = world.create_body(&BodyDef::new(kind, place)).expect("room");
        let shape = ShapeDef { traits, ..ShapeDef::new(Geometry::Sphere { radius }) };
        world.create_shape(body, &shape).expect("room");
    };
    for i in 0..FLOOR * FLOOR {
        let (x, y) = ((i % FLOOR) as f32, (i / FLOOR) as f32);
        // The rim is higher: nothing rolls off.
        let rim = [x, y].into_iter().any(|k| k == 0.0 || k == (FLOOR - 1) as f32);
        put(BodyKind::Static, Vec3::new(x, y, if rim { 0.8 } else { 0.0 }), 0.7);
    }
    for i in 0..EDGE * EDGE * EDGE {
        let (x, y, z) = (i % EDGE, i / EDGE % EDGE, i / EDGE / EDGE);
        // A little askew, so that columns do not stand.
        let lean = 0.02 * (z % 3) as f32;
        let place = Vec3::new(x as f32 * 0.55 + lean, y as f32 * 0.55 - lean, z as f32 * 0.55);
        put(BodyKind::Dynamic, place + Vec3::new(3.6, 3.6, 1.2), 0.25);
    }
    let mut contacts = 0;
    for _ in 0..steps {
        contacts = world.step(&mut Serial).contacts;
    }
    println!("{steps} steps, {contacts} contacts, checksum {:016x}", world.checksum());
}
