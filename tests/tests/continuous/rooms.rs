//! A room whose walls are 1 cm thick, full of bodies that never meet each other: bounces, corners and edges, at any
//! speed.

use crate::shots::{Kind, KINDS, power_of_ten, room_for, shell};
use cellstep::math::{Pose, Rotation, Vec3, length};
use cellstep::{
    BodyDef, BodyHandle, BodyKind, CompoundChild, Executor, Filter, Geometry, Position, Serial, Settings, ShapeDef,
};
use cellstep_tests::executors::Random;
use cellstep_tests::oracles::{center, minus, wide};
use cellstep_tests::worlds::{OwnedWorld, add};

/// Half the inner edge of a room, metres.
pub const HALF: f32 = 2.0;
/// Half the thickness of its walls.
const THIN: f32 = 0.005;

/// What the walls are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Walls {
    Boxes,
    Mesh,
    Compound,
}

/// The middles and half extents of the walls.
fn walls() -> [(Vec3, Vec3); 6] {
    core::array::from_fn(|i| {
        let axis = [Vec3::X, Vec3::Y, Vec3::Z][i / 2];
        let side = if i % 2 == 0 { 1.0 } else { -1.0 };
        let half = Vec3::splat(HALF) + (Vec3::splat(THIN) - Vec3::splat(HALF)) * axis;
        (axis * (side * (HALF + THIN)), half)
    })
}

/// A room around a place, and bodies in it that move at 10 to 1,000 m/s. Every third has the flag.
pub fn room(walls_are: Walls, kinds: &[Kind], bodies: usize, at: Position) -> (OwnedWorld, Vec<BodyHandle>) {
    let mut world = room_for(bodies + 8);
    let settings = Settings { gravity: Vec3::new(0.0, 0.0, -9.81), ..world.settings() };
    world.set_settings(&settings).expect("in range");
    let body = world.create_body(&BodyDef { kind: BodyKind::Static, position: at, ..BodyDef::default() });
    let body = body.expect("room");
    match walls_are {
        Walls::Boxes => {
            for (place, half_extents) in walls() {
                let pose = Pose::new(place, Rotation::IDENTITY);
                let def = ShapeDef { pose, ..ShapeDef::new(Geometry::Box { half_extents }) };
                world.create_shape(body, &def).expect("room");
            }
        }
        Walls::Mesh => {
            let side = |bit: u32| if bit == 0 { -HALF } else { HALF };
            let corners: Vec<Vec3> = (0..8).map(|i| Vec3::new(side(i & 1), side(i & 2), side(i & 4))).collect();
            let quads = [[0, 1, 3, 2], [4, 5, 7, 6], [0, 1, 5, 4], [2, 3, 7, 6], [0, 2, 6, 4], [1, 3, 7, 5]];
            let triangles: Vec<[u32; 3]> =
                quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
            let mesh = world.add_mesh(&corners, &triangles).expect("a mesh");
            world.create_shape(body, &ShapeDef::new(Geometry::Mesh(mesh))).expect("room");
        }
        Walls::Compound => {
            let children = walls().map(|(place, half_extents)| CompoundChild {
                geometry: Geometry::Box { half_extents },
                pose: Pose::new(place, Rotation::IDENTITY),
            });
            let compound = world.add_compound(&children).expect("a compound");
            world.create_shape(body, &ShapeDef::new(Geometry::Compound(compound))).expect("room");
        }
    }
    let shells: Vec<Geometry> = kinds.iter().map(|&kind| shell(&mut world, kind).geometry).collect();
    let mut random = Random::new(17);
    let mut any = || random.between(-1.0, 1.0);
    let handles = (0..bodies)
        .map(|i| {
            let way = Vec3::new(any(), any(), any());
            let speed = power_of_ten(2.0 + any());
            let place = Vec3::new(any(), any(), any()) * (HALF - 0.8);
            let def = BodyDef {
                position: Position { offset: at.offset + place, ..at },
                rotation: Rotation::from_rotation_vector(Vec3::new(3.0 * any(), 3.0 * any(), 3.0 * any())),
                linear_velocity: way * (speed / length(way)),
                angular_velocity: Vec3::new(any(), any(), any()) * 50.0,
                bullet: i % 3 == 0,
                ..BodyDef::default()
            };
            let filter = Filter { group: -1, ..Filter::default() };
            let restitution = [0.0, 0.5, 1.0][i % 3];
            let friction = [0.0, 0.6][i % 2];
            let shape =
                ShapeDef { filter, restitution, friction, ..ShapeDef::new(shells[i % shells.len()]) };
            add(&mut world, &def, &shape).0
        })
        .collect();
    (world, handles)
}

/// How many bodies have left the room.
pub fn outside(world: &OwnedWorld, bodies: &[BodyHandle], at: Position) -> usize {
    let is_out = |&&body: &&BodyHandle| {
        let place = minus(center(world, body), at.to_f64());
        place.iter().any(|x| x.abs() > f64::from(HALF))
    };
    bodies.iter().filter(is_out).count()
}

#[test]
fn stuck() {
    for kind in KINDS {
        let (mut world, bodies) = room(Walls::Boxes, &[kind], 60, Position::ORIGIN);
        for step in 0..120 {
            let before: Vec<_> = bodies.iter().map(|&b| (center(&world, b), world.linear_velocity(b).unwrap(), world.angular_velocity(b).unwrap())).collect();
            let r = world.step(&mut Serial);
            if step % 30 == 29 {
                let mut rows: Vec<_> = bodies.iter().zip(&before).enumerate().map(|(i, (&b, (c, v, w)))| {
                    let d = cellstep_tests::oracles::norm(minus(center(&world, b), *c));
                    (d / (f64::from(length(*v)) / 60.0 + 1e-9), length(*v), length(*w), i)
                }).collect();
                rows.sort_by(|a, b| a.0.total_cmp(&b.0));
                println!("{kind:?} step {step} cut {} ratios {:?}", r.cut, rows.iter().step_by(8).map(|r| (format!("{:.2} v{:.0} w{:.0} #{}", r.0, r.1, r.2, r.3))).collect::<Vec<_>>());
            }
        }
    }
}
#[test]
fn trace() {
    let kind = KINDS[std::env::var("K").unwrap().parse::<usize>().unwrap()];
    let me: usize = std::env::var("ME").unwrap().parse().unwrap();
    let from: u32 = std::env::var("FROM").unwrap().parse().unwrap();
    let (mut world, bodies) = room(Walls::Boxes, &[kind], 60, Position::ORIGIN);
    for (i, &b) in bodies.iter().enumerate() { if i != me { world.remove_body(b).unwrap(); } }
    let b = bodies[me];
    for step in 0..from + 8 {
        let r = world.step(&mut Serial);
        if step >= from {
            println!("-- {step} cut {} contacts {} c {:.5?} v {:.3?} w {:.2?} q {:?}", r.cut, r.contacts, center(&world, b), world.linear_velocity(b).unwrap(), world.angular_velocity(b).unwrap(), world.rotation(b).unwrap());
            for c in world.contacts() { println!("     points {} imp {:?} fr {:?}", c.points, c.impulses, c.friction); }
            world.separations(|s| print!(" {s:.6}")); println!();
        }
    }
}
