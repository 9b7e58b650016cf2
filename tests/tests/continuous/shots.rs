//! Shots at walls: many bodies that do not meet each other, from seeded places, directions and speeds.

use cellstep::math::{PI, Pose, Rotation, Vec3, cos, length, sin};
use cellstep::{
    BodyDef, BodyHandle, BodyKind, Capacities, CompoundChild, Filter, Geometry, HeightFieldDef, Position,
    Serial, Settings, ShapeDef,
};
use cellstep_tests::executors::Random;
use cellstep_tests::oracles::{Wide, center, dot, plus, turned, wide};
use cellstep_tests::worlds::{self, OwnedWorld, add};

/// Shots of a world.
pub const SHOTS: usize = 150;
/// Steps after a shot.
const STEPS: u32 = 24;
/// Half the edge of a wall, metres.
const EXTENT: f32 = 100.0;
/// Half the thickness of thin things, metres.
const THIN: f32 = 0.005;

/// What is shot at. Its surface is the plane z = 0 through its frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Wall {
    /// A box 1 cm thick.
    Box,
    HalfSpace,
    Mesh,
    HeightField,
    /// Boxes 1 cm thick, side by side.
    Compound,
}

impl Wall {
    pub const ALL: [Self; 5] = [Self::Box, Self::HalfSpace, Self::Mesh, Self::HeightField, Self::Compound];
}

/// What is shot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    Sphere,
    Capsule,
    Cube,
    /// 1 cm x 1 m x 1 m.
    Plate,
    /// 1 cm x 1 cm x 1 m.
    Rod,
    Hull,
    Cylinder,
    Cone,
    /// Two balls on a stick.
    Compound,
}

pub const KINDS: [Kind; 9] = [
    Kind::Sphere,
    Kind::Capsule,
    Kind::Cube,
    Kind::Plate,
    Kind::Rod,
    Kind::Hull,
    Kind::Cylinder,
    Kind::Cone,
    Kind::Compound,
];

/// A geometry and points that span it.
pub struct Shell {
    pub geometry: Geometry,
    /// Corners, and a radius around them.
    pub corners: Vec<Vec3>,
    pub radius: f32,
    pub inner: f32,
}

fn box_corners(half: Vec3) -> Vec<Vec3> {
    let side = |bit: u32| if bit == 0 { -1.0 } else { 1.0 };
    (0..8).map(|i| half * Vec3::new(side(i & 1), side(i & 2), side(i & 4))).collect()
}

fn ring(radius: f32, z: f32) -> Vec<Vec3> {
    (0..32)
        .map(|i| {
            let angle = i as f32 * PI / 16.0;
            Vec3::new(radius * cos(angle), radius * sin(angle), z)
        })
        .collect()
}

pub fn shell(world: &mut OwnedWorld, kind: Kind) -> Shell {
    let of_box = |half: Vec3| Shell {
        geometry: Geometry::Box { half_extents: half },
        corners: box_corners(half),
        radius: 0.0,
        inner: half.min_element(),
    };
    match kind {
        Kind::Sphere => Shell {
            geometry: Geometry::Sphere { radius: THIN },
            corners: vec![Vec3::ZERO],
            radius: THIN,
            inner: THIN,
        },
        Kind::Capsule => Shell {
            geometry: Geometry::Capsule { half_height: 0.3, radius: THIN },
            corners: vec![Vec3::Z * 0.3, Vec3::Z * -0.3],
            radius: THIN,
            inner: THIN,
        },
        Kind::Cube => of_box(Vec3::splat(0.05)),
        Kind::Plate => of_box(Vec3::new(0.5, 0.5, THIN)),
        Kind::Rod => of_box(Vec3::new(0.5, THIN, THIN)),
        Kind::Hull => {
            let mut random = Random::new(3);
            let mut any = || random.between(-1.0, 1.0);
            let corners: Vec<Vec3> =
                (0..12).map(|_| Vec3::new(0.3 * any(), 0.1 * any(), 0.05 * any())).collect();
            let hull = world.add_hull(&corners).expect("a hull");
            Shell { geometry: Geometry::Hull(hull), corners, radius: 0.0, inner: 0.03 }
        }
        Kind::Cylinder => Shell {
            geometry: Geometry::Cylinder { half_height: THIN, radius: 0.2 },
            corners: [ring(0.2, THIN), ring(0.2, -THIN)].concat(),
            radius: 0.0,
            inner: THIN,
        },
        Kind::Cone => Shell {
            geometry: Geometry::Cone { half_height: 0.2, radius: 0.05 },
            corners: [ring(0.05, -0.2), vec![Vec3::Z * 0.2]].concat(),
            radius: 0.0,
            inner: 0.04,
        },
        Kind::Compound => {
            let at = |geometry, z: f32| CompoundChild {
                geometry,
                pose: Pose::new(Vec3::Z * z, Rotation::IDENTITY),
            };
            let ball = Geometry::Sphere { radius: 0.02 };
            let stick = Geometry::Capsule { half_height: 0.3, radius: THIN };
            let children = [at(ball, 0.3), at(ball, -0.3), at(stick, 0.0)];
            let compound = world.add_compound(&children).expect("a compound");
            Shell {
                geometry: Geometry::Compound(compound),
                corners: vec![Vec3::Z * 0.3, Vec3::Z * -0.3],
                radius: THIN,
                inner: THIN,
            }
        }
    }
}

/// A world for some bodies and the assets of walls and shapes.
pub fn room_for(bodies: usize) -> OwnedWorld {
    let cells = 40 * 40;
    worlds::world_with(Capacities {
        hulls: 1,
        meshes: 1,
        mesh_vertices: 2000,
        mesh_triangles: 2 * cells,
        height_fields: 1,
        height_samples: 2000,
        compounds: 2,
        compound_children: 100,
        ..Capacities::for_bodies(bodies as u32 + 2)
    })
}

/// The geometry of a wall, and where its surface is from its frame's origin.
fn wall_of(world: &mut OwnedWorld, wall: Wall) -> (Geometry, f32, Vec3) {
    let cells = 40_u32;
    let cell = 2.0 * EXTENT / cells as f32;
    let side = cells + 1;
    match wall {
        Wall::Box => {
            let half_extents = Vec3::new(EXTENT, EXTENT, THIN);
            (Geometry::Box { half_extents }, THIN, Vec3::ZERO)
        }
        Wall::HalfSpace => (Geometry::HalfSpace, 0.0, Vec3::ZERO),
        Wall::Mesh => {
            let place = |i: u32| i as f32 * cell - EXTENT;
            let vertices: Vec<Vec3> =
                (0..side * side).map(|i| Vec3::new(place(i / side), place(i % side), 0.0)).collect();
            let triangles: Vec<[u32; 3]> = (0..cells * cells)
                .flat_map(|i| {
                    let a = i / cells * side + i % cells;
                    [[a, a + side, a + side + 1], [a, a + side + 1, a + 1]]
                })
                .collect();
            (Geometry::Mesh(world.add_mesh(&vertices, &triangles).expect("a mesh")), 0.0, Vec3::ZERO)
        }
        Wall::HeightField => {
            let heights = vec![0.0; (side * side) as usize];
            let def = HeightFieldDef {
                columns: side,
                rows: side,
                spacing: [cell; 2],
                heights: &heights,
                cells: &[],
                surfaces: &[],
            };
            let field = world.add_height_field(&def).expect("a field");
            (Geometry::HeightField(field), 0.0, Vec3::new(-EXTENT, -EXTENT, 0.0))
        }
        Wall::Compound => {
            let children: Vec<CompoundChild> = (0..64)
                .map(|i| {
                    let place = |k: i32| (2 * k - 7) as f32 * EXTENT / 8.0;
                    let half_extents = Vec3::new(EXTENT / 8.0, EXTENT / 8.0, THIN);
                    let at = Vec3::new(place(i % 8), place(i / 8), 0.0);
                    let pose = Pose::new(at, Rotation::IDENTITY);
                    CompoundChild { geometry: Geometry::Box { half_extents }, pose }
                })
                .collect();
            (Geometry::Compound(world.add_compound(&children).expect("a compound")), THIN, Vec3::ZERO)
        }
    }
}

/// What came of the shots.
#[derive(Clone, Copy, Debug, Default)]
pub struct Outcome {
    /// Bodies whose center was behind the surface after a step.
    pub passed: usize,
    /// Bodies with a point more than half their thickness deep.
    pub pierced: usize,
    /// Greatest depth of a point, metres.
    pub deepest: f64,
    /// Bodies that gained more than a hundredth of their energy.
    pub gained: usize,
    pub gain: f64,
    /// Bodies that were stopped on their way.
    pub cut: u32,
}

pub fn energy(world: &OwnedWorld, body: BodyHandle) -> f64 {
    let mass = world.mass_properties(body).expect("exists");
    let v = wide(world.linear_velocity(body).expect("exists"));
    let rotation = world.rotation(body).expect("exists").after(mass.axes);
    let w = turned(rotation.inverse(), wide(world.angular_velocity(body).expect("exists")));
    let i = wide(mass.inertia);
    0.5 * (f64::from(mass.mass) * dot(v, v) + i[0] * w[0] * w[0] + i[1] * w[1] * w[1] + i[2] * w[2] * w[2])
}

/// Fires at a wall that stands at random.
pub fn fire(wall: Wall, kind: Kind, seed: u64, continuous: bool) -> Outcome {
    let mut random = Random::new(seed);
    let mut world = room_for(SHOTS);
    let settings = Settings { continuous, gravity: Vec3::ZERO, ..world.settings() };
    world.set_settings(&settings).expect("in range");
    let (geometry, surface, at) = wall_of(&mut world, wall);
    let mut any = || random.between(-1.0, 1.0);
    let stand = Rotation::from_rotation_vector(Vec3::new(3.0 * any(), 3.0 * any(), 3.0 * any()));
    let origin = Vec3::new(20.0 * any(), 20.0 * any(), 20.0 * any());
    let def = BodyDef { rotation: stand, ..BodyDef::new(BodyKind::Static, origin + stand.rotate(at)) };
    add(&mut world, &def, &ShapeDef::new(geometry));
    let shell = shell(&mut world, kind);
    let mut bodies = Vec::new();
    for shot in 0..SHOTS {
        let mut random = Random::new(seed * 1000 + shot as u64);
        let mut any = || random.between(-1.0, 1.0);
        let speed = power_of_ten(1.5 + 1.5 * any());
        let down = Vec3::new(any(), any(), -(0.02 + (0.5 + 0.5 * any())));
        let way = down * (1.0 / length(down));
        let height = 0.8 + surface + (0.5 + 0.5 * any()) * 3.0;
        let spin = 75.0 + 25.0 * any();
        let axis = Vec3::new(any(), any(), any());
        let place = Vec3::new(4.0 * any(), 4.0 * any(), height);
        let def = BodyDef {
            position: Position::at(origin + stand.rotate(place)),
            rotation: Rotation::from_rotation_vector(Vec3::new(3.0 * any(), 3.0 * any(), 3.0 * any())),
            linear_velocity: stand.rotate(way * speed),
            angular_velocity: axis * (spin / length(axis)),
            ..BodyDef::default()
        };
        let filter = Filter { group: -1, ..Filter::default() };
        let restitution = if shot % 2 == 0 { 0.0 } else { 0.5 };
        let shape = ShapeDef { filter, restitution, ..ShapeDef::new(shell.geometry) };
        bodies.push(add(&mut world, &def, &shape).0);
    }
    watch(&mut world, &bodies, (&shell, surface), (origin, stand))
}

/// So that slow and fast shots are as many.
pub fn power_of_ten(x: f32) -> f32 {
    10.0_f64.powf(f64::from(x)) as f32
}

fn watch(
    world: &mut OwnedWorld,
    bodies: &[BodyHandle],
    (shell, surface): (&Shell, f32),
    (origin, stand): (Vec3, Rotation),
) -> Outcome {
    let mut outcome = Outcome::default();
    let before: Vec<f64> = bodies.iter().map(|&body| energy(world, body)).collect();
    let (mut passed, mut pierced, mut gained) =
        (vec![false; bodies.len()], vec![false; bodies.len()], vec![false; bodies.len()]);
    let up = turned(stand, [0.0, 0.0, 1.0]);
    let sides = [turned(stand, [1.0, 0.0, 0.0]), turned(stand, [0.0, 1.0, 0.0])];
    for _ in 0..STEPS {
        outcome.cut += world.step(&mut Serial).cut;
        for (i, &body) in bodies.iter().enumerate() {
            let c = plus(center(world, body), wide(origin), -1.0);
            // Beside the wall there is nothing to hold it.
            if sides.iter().any(|&side| dot(c, side).abs() > f64::from(EXTENT) - 2.0) {
                continue;
            }
            let height = dot(c, up) - f64::from(surface);
            passed[i] |= height < 0.0;
            let rotation = world.rotation(body).expect("exists");
            let lowest = shell.corners.iter().fold(f64::INFINITY, |least: f64, &corner| {
                let p: Wide =
                    plus(world.position(body).expect("exists").to_f64(), turned(rotation, wide(corner)), 1.0);
                least.min(dot(plus(p, wide(origin), -1.0), up) - f64::from(surface + shell.radius))
            });
            if !passed[i] {
                pierced[i] |= -lowest > 0.5 * f64::from(shell.inner);
                outcome.deepest = outcome.deepest.max(-lowest);
            }
            let gain = energy(world, body) / before[i] - 1.0;
            gained[i] |= gain > 0.01;
            outcome.gain = outcome.gain.max(gain);
        }
    }
    let count = |flags: &[bool]| flags.iter().filter(|&&flag| flag).count();
    (outcome.passed, outcome.pierced, outcome.gained) = (count(&passed), count(&pierced), count(&gained));
    outcome
}
