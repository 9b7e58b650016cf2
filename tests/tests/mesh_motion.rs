//! Motion over a triangle mesh: inner edges do not catch.
//!
//! A flat grid with random diagonals and windings is the same floor as a half-space. Every motion is made twice, on
//! the mesh and on the half-space, and must be the same: step by step in speed, and in the way that was gone.

use cellstep::math::{PI, Pose, Rotation, Vec3, max};
use cellstep::{BodyDef, BodyHandle, BodyKind, Capacities, Geometry, Position, Serial, ShapeDef};
use cellstep_tests::executors::Random;
use cellstep_tests::worlds::{self, OwnedWorld, add, run};

/// Cells along an edge of the grid.
const CELLS: u32 = 40;
/// Edge of a cell, metres: about the size of the bodies, so that there is always an edge below them.
const CELL: f32 = 0.4;
/// Steps of a motion, 1.5 s: less than it takes to the edge of the grid, downhill.
const STEPS: u32 = 90;
/// Speed of a motion at its start, m/s.
const SPEED: f32 = 3.0;

/// What a motion is made on.
#[derive(Clone, Copy, PartialEq)]
enum Floor {
    Mesh,
    HalfSpace,
}

/// A flat grid around the origin.
fn grid(seed: u64) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let mut random = Random::new(seed);
    let side = CELLS + 1;
    let place = |i: u32| (i as f32 - 0.5 * CELLS as f32) * CELL;
    let vertices = (0..side * side).map(|i| Vec3::new(place(i / side), place(i % side), 0.0)).collect();
    let mut triangles = Vec::new();
    for cell in 0..CELLS * CELLS {
        let corner = cell / CELLS * side + cell % CELLS;
        let [a, b, c, d] = [corner, corner + 1, corner + side + 1, corner + side];
        let halves = if random.below(2) == 0 { [[a, b, c], [a, c, d]] } else { [[b, c, d], [b, d, a]] };
        for [a, b, c] in halves {
            triangles.push(if random.below(2) == 0 { [a, b, c] } else { [b, a, c] });
        }
    }
    (vertices, triangles)
}

/// A world with a floor that is turned by `tilt` about the origin.
fn world_on(floor: Floor, tilt: Rotation, friction: f32) -> OwnedWorld {
    let (vertices, triangles) = grid(5);
    let mut world = worlds::world_with(Capacities {
        meshes: 1,
        mesh_vertices: vertices.len() as u32,
        mesh_triangles: triangles.len() as u32,
        ..Capacities::for_bodies(16)
    });
    let geometry = match floor {
        Floor::Mesh => Geometry::Mesh(world.add_mesh(&vertices, &triangles).expect("a grid is a mesh")),
        Floor::HalfSpace => Geometry::HalfSpace,
    };
    let def = BodyDef { rotation: tilt, ..BodyDef::new(BodyKind::Static, Vec3::ZERO) };
    add(&mut world, &def, &ShapeDef { friction, ..ShapeDef::new(geometry) });
    world
}

/// A motion in the plane of the floor.
#[derive(Clone, Copy)]
struct Start {
    geometry: Geometry,
    /// Height of the center above the floor.
    height: f32,
    /// Direction of the way, radians from the floor's x axis.
    azimuth: f32,
    /// How the body is turned about the normal.
    yaw: f32,
    friction: f32,
    tilt: Rotation,
    /// Rolls without slip.
    rolls: bool,
}

/// Where a body is and how fast, in the floor's frame.
struct Moment {
    place: Vec3,
    velocity: Vec3,
    spin: Vec3,
}

fn moment(world: &OwnedWorld, body: BodyHandle, tilt: Rotation) -> Moment {
    let place = world.center(body).expect("the body exists").minus(Position::ORIGIN);
    Moment {
        place: tilt.unrotate(place),
        velocity: tilt.unrotate(world.linear_velocity(body).expect("the body exists")),
        spin: tilt.unrotate(world.angular_velocity(body).expect("the body exists")),
    }
}

/// The moments after each step.
fn motion(floor: Floor, start: &Start) -> Vec<Moment> {
    let mut world = world_on(floor, start.tilt, start.friction);
    let (sine, cosine) = (cellstep::math::sin(start.azimuth), cellstep::math::cos(start.azimuth));
    let along = Vec3::new(cosine, sine, 0.0);
    // Off the lines of the grid, and not far behind its middle.
    let place = Vec3::new(0.13, -0.07, start.height) - along * 2.0;
    let spin = if start.rolls { Vec3::Z.cross(along) * (SPEED / start.height) } else { Vec3::ZERO };
    let def = BodyDef {
        position: Position::at(start.tilt.rotate(place)),
        rotation: start.tilt.after(Rotation::from_axis_angle(Vec3::Z, start.yaw)),
        linear_velocity: start.tilt.rotate(along * SPEED),
        angular_velocity: start.tilt.rotate(spin),
        ..BodyDef::default()
    };
    let shape = ShapeDef { friction: start.friction, ..ShapeDef::new(start.geometry) };
    let (body, _) = add(&mut world, &def, &shape);
    let mut moments = Vec::new();
    for step in 0..STEPS {
        let report = world.step(&mut Serial);
        assert!(report.contacts <= 4, "step {step}: {report:?}");
        moments.push(moment(&world, body, start.tilt));
    }
    moments
}

/// How two motions differ.
#[derive(Debug, Default)]
struct Difference {
    /// Of the velocities of any step, m/s.
    velocity: f32,
    /// Of the surface speeds by spin of any step, m/s.
    surface: f32,
    /// Greatest speed along the normal in the motion on the mesh, m/s.
    hop: f32,
    /// Of the places at the end, as a share of the way.
    way: f32,
}

fn difference(start: &Start) -> Difference {
    let (mesh, plane) = (motion(Floor::Mesh, start), motion(Floor::HalfSpace, start));
    let mut worst = Difference::default();
    for (a, b) in mesh.iter().zip(&plane) {
        worst.velocity = max(worst.velocity, (a.velocity - b.velocity).length());
        worst.surface = max(worst.surface, start.height * (a.spin - b.spin).length());
        worst.hop = max(worst.hop, a.velocity.z.abs());
    }
    let (a, b) = (&mesh[mesh.len() - 1], &plane[plane.len() - 1]);
    let gone: f32 = plane.windows(2).map(|pair| (pair[1].place - pair[0].place).length()).sum();
    assert!(gone > 0.5, "the body moved {gone} m");
    worst.way = (a.place - b.place).length() / gone;
    worst
}

/// Flat, and two tilts of 20 degrees about a line of the grid and across it.
fn tilts() -> [Rotation; 3] {
    let angle = 20.0_f32.to_radians();
    let across = Vec3::new(0.6, 0.8, 0.0);
    [Rotation::IDENTITY, Rotation::from_axis_angle(Vec3::Y, angle), Rotation::from_axis_angle(across, -angle)]
}

/// Makes a motion in eight directions on three floors, and asserts that it is the same on both kinds: velocities
/// within `velocity` m/s, places at the end within `way` of the way. Nothing hops.
#[track_caller]
fn check(start: &Start, (velocity, way): (f32, f32)) {
    let mut worst = Difference::default();
    for tilt in tilts() {
        for eighth in 0..8 {
            let azimuth = eighth as f32 * 0.25 * PI;
            let found = difference(&Start { tilt, azimuth, yaw: start.yaw + azimuth, ..*start });
            worst.velocity = max(worst.velocity, found.velocity);
            worst.surface = max(worst.surface, found.surface);
            worst.hop = max(worst.hop, found.hop);
            worst.way = max(worst.way, found.way);
        }
    }
    println!("{worst:?}");
    assert!(worst.velocity < velocity && worst.surface < 1.0e-3, "{worst:?}");
    assert!(worst.hop < 1.0e-3, "{worst:?}");
    assert!(worst.way < way, "{worst:?}");
}

const BRICK: Geometry = Geometry::Box { half_extents: Vec3::new(0.3, 0.2, 0.15) };

fn brick(friction: f32, yaw: f32) -> Start {
    let tilt = Rotation::IDENTITY;
    Start { geometry: BRICK, height: 0.15, azimuth: 0.0, yaw, friction, tilt, rolls: false }
}

#[test]
fn a_box_without_friction_slides_as_on_a_plane() {
    for yaw in [0.0, 0.4] {
        check(&brick(0.0, yaw), (1.0e-3, 1.0e-4));
    }
}

#[test]
fn a_box_with_friction_slides_as_on_a_plane() {
    // Points on other triangles have other features, and start without impulses: the load, and with it friction, is
    // a little late.
    for yaw in [0.0, 0.4] {
        check(&brick(0.3, yaw), (0.04, 1.0e-2));
    }
}

#[test]
fn a_ball_rolls_as_on_a_plane() {
    let start =
        Start { geometry: Geometry::Sphere { radius: 0.2 }, height: 0.2, rolls: true, ..brick(0.6, 0.0) };
    check(&start, (1.0e-3, 1.0e-3));
}

#[test]
fn a_ball_without_friction_slides_as_on_a_plane() {
    check(
        &Start { geometry: Geometry::Sphere { radius: 0.2 }, height: 0.2, ..brick(0.0, 0.0) },
        (1.0e-3, 1.0e-4),
    );
}

#[test]
fn boxes_over_many_triangles_rest() {
    let mut world = world_on(Floor::Mesh, Rotation::IDENTITY, 0.6);
    let mut random = Random::new(11);
    let boxes: Vec<BodyHandle> = (0..9)
        .map(|i| {
            // From smaller than a cell to many cells.
            let half = [0.1, 0.5, 1.0][i % 3];
            let place = Vec3::new((i % 3) as f32 * 4.0 - 4.0, (i / 3) as f32 * 4.0 - 4.0, 0.5 * half);
            let off = Vec3::new(random.between(-0.5, 0.5), random.between(-0.5, 0.5), 0.0);
            let yaw = if i == 0 { 0.0 } else { random.between(0.0, 7.0) };
            let def = BodyDef {
                position: Position::at(place + off),
                rotation: Rotation::from_axis_angle(Vec3::Z, yaw),
                ..BodyDef::default()
            };
            let half_extents = Vec3::new(half, 0.8 * half, 0.5 * half);
            add(&mut world, &def, &ShapeDef::new(Geometry::Box { half_extents })).0
        })
        .collect();
    run(&mut world, 120);
    let poses = |world: &OwnedWorld| -> Vec<Pose> {
        let pose = |&body: &BodyHandle| {
            let center = world.center(body).expect("the body exists").minus(Position::ORIGIN);
            Pose::new(center, world.rotation(body).expect("the body exists"))
        };
        boxes.iter().map(pose).collect()
    };
    let (before, mut squares) = (poses(&world), 0.0);
    for _ in 0..3600 {
        run(&mut world, 1);
        assert_eq!(world.contacts().count(), boxes.len(), "a flat floor is one manifold");
        assert!(world.contacts().all(|contact| (3..=4).contains(&contact.points)));
        let speed2 =
            |&body: &BodyHandle| world.linear_velocity(body).expect("the body exists").length_squared();
        squares += boxes.iter().map(|body| f64::from(speed2(body))).sum::<f64>();
    }
    let rms = (squares / (3600.0 * boxes.len() as f64)).sqrt();
    let creep = before.iter().zip(poses(&world)).map(|(a, b)| {
        let turn = b.rotation.after(a.rotation.inverse()).imaginary().length();
        max((b.position - a.position).length(), turn)
    });
    let creep = creep.fold(0.0, max);
    println!("creep {creep} m, rms speed {rms} m/s");
    assert!(creep < 1.0e-3, "creep of {creep} m or half rad");
    assert!(rms < 1.0e-3, "rms speed {rms} m/s");
}
