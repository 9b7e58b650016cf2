//! A room whose walls are 1 cm thick, full of bodies that never meet each other: bounces, corners and edges, at
//! any speed.

use crate::shots::{KINDS, Kind, energy, power_of_ten, room_for, shell};
use cellstep::math::{Pose, Rotation, Vec3, length};
use cellstep::{
    BodyDef, BodyHandle, BodyKind, CompoundChild, Executor, Filter, Geometry, Pool, Position, Serial,
    Settings, ShapeDef,
};
use cellstep_tests::executors::{Random, Shuffled};
use cellstep_tests::oracles::{center, minus, norm, velocity};
use cellstep_tests::simulator::snapshot;
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
            let corners: Vec<Vec3> =
                (0..8).map(|i| Vec3::new(side(i & 1), side(i & 2), side(i & 4))).collect();
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
                position: at.plus(place),
                rotation: Rotation::from_rotation_vector(Vec3::new(3.0 * any(), 3.0 * any(), 3.0 * any())),
                linear_velocity: way * (speed / length(way)),
                angular_velocity: Vec3::new(any(), any(), any()) * 50.0,
                bullet: i % 3 == 0,
                ..BodyDef::default()
            };
            let filter = Filter { group: -1, ..Filter::default() };
            let restitution = [0.0, 0.5, 1.0][i % 3];
            let friction = [0.0, 0.6][i % 2];
            let shape = ShapeDef { filter, restitution, friction, ..ShapeDef::new(shells[i % shells.len()]) };
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
fn nothing_leaves_a_room() {
    for walls in [Walls::Boxes, Walls::Mesh, Walls::Compound] {
        let (mut world, bodies) = room(walls, &KINDS, 180, Position::ORIGIN);
        let before = all_energy(&world, &bodies);
        let (mut cut, mut stands, mut crawls) = (0, 0, 0);
        for step in 0..90 {
            let before: Vec<_> = bodies.iter().map(|&body| center(&world, body)).collect();
            cut += world.step(&mut Serial).cut;
            assert_eq!(outside(&world, &bodies, Position::ORIGIN), 0, "{walls:?}, step {step}");
            if step >= 60 {
                for (&body, place) in bodies.iter().zip(before) {
                    let (speed, way) =
                        (norm(velocity(&world, body)), norm(minus(center(&world, body), place)));
                    stands += usize::from(speed > 1.0 && way < 1.0e-5);
                    crawls += usize::from(speed > 1.0 && way < 0.05 * speed / 60.0);
                }
            }
        }
        println!("{walls:?}: {cut} cut, {stands} steps without motion, {crawls} with little");
        assert!(cut > 500, "{walls:?}: {cut} cut");
        // What is stopped goes on, in the same step or in the next.
        assert!(stands < 180 * 30 / 500, "{walls:?}: {stands} steps without motion");
        assert!(crawls < 180 * 30 / 200, "{walls:?}: {crawls} steps with little motion");
        let after = all_energy(&world, &bodies);
        println!("{walls:?}: {before:.3e} J, then {after:.3e} J");
        assert!(after < before, "{walls:?}: {before} J became {after} J");
    }
}

/// Kinetic energy of bodies, J.
fn all_energy(world: &OwnedWorld, bodies: &[BodyHandle]) -> f64 {
    bodies.iter().map(|&body| energy(world, body)).sum()
}

/// Takes steps with an executor; `before` is called before each. Returns the state.
fn play(executor: &mut impl Executor, mut before: impl FnMut(&mut OwnedWorld, u32)) -> (Vec<u8>, u32) {
    let (mut world, _) = room(Walls::Mesh, &KINDS, 400, Position::ORIGIN);
    let mut cut = 0;
    for step in 0..40 {
        before(&mut world, step);
        cut += world.step(executor).cut;
    }
    (world.state().to_vec(), cut)
}

#[test]
fn bits_do_not_depend_on_workers_caches_or_restores() {
    let (state, cut) = play(&mut Serial, |_, _| {});
    assert!(cut > 1000, "{cut} cut");
    for workers in [1, 2, 3, 8] {
        let mut pool = Pool::new(workers).expect("threads");
        assert!(play(&mut pool, |_, _| {}).0 == state, "{workers} workers");
    }
    assert!(play(&mut Shuffled::new(3), |_, _| {}).0 == state, "shuffled tasks");
    assert!(play(&mut Serial, |world, _| world.drop_caches()).0 == state, "without caches");
    let again = |world: &mut OwnedWorld, step: u32| {
        if step % 7 == 3 {
            let saved = snapshot(world);
            for _ in 0..3 {
                world.step(&mut Serial);
            }
            world.restore(&saved).expect("a snapshot of this world");
        }
        if step % 5 == 1 {
            let _ = world.queries();
        }
    };
    assert!(play(&mut Serial, again).0 == state, "after restores");
}

#[test]
fn a_room_far_away_is_the_same_room() {
    let sector = [156_250, -77_777, 4096];
    let (mut here, bodies) = room(Walls::Boxes, &KINDS, 90, Position::ORIGIN);
    let far = Position { sector, ..Position::ORIGIN };
    let (mut there, others) = room(Walls::Boxes, &KINDS, 90, far);
    for _ in 0..60 {
        here.step(&mut Serial);
        there.step(&mut Serial);
    }
    for (&a, &b) in bodies.iter().zip(&others) {
        assert_eq!(here.center(a).expect("exists").offset, there.center(b).expect("exists").offset);
        assert_eq!(here.linear_velocity(a), there.linear_velocity(b));
    }
    // On the border of two sectors, where bodies change between them, nothing leaves either.
    let border = Position::at(Vec3::splat(32.5));
    let (mut world, bodies) = room(Walls::Boxes, &KINDS, 90, border);
    for _ in 0..60 {
        world.step(&mut Serial);
    }
    assert_eq!(outside(&world, &bodies, border), 0);
}
