//! Cylinders, cones, rounded hulls, height fields and compounds in worlds: they stand, lie, roll and stay in.

#[path = "shapes/compounds.rs"]
mod compounds;
#[path = "shapes/piles.rs"]
mod piles;
#[path = "shapes/rests.rs"]
mod rests;
#[path = "shapes/stacks.rs"]
mod stacks;
#[path = "shapes/surfaces.rs"]
mod surfaces;

use cellstep::math::{Pose, Rotation, Vec3};
use cellstep::{
    BodyDef, BodyHandle, BodyKind, Capacities, CompoundChild, Geometry, HeightFieldDef, ShapeDef, ShapeHandle,
};
use cellstep_tests::worlds::{OwnedWorld, world_with};

/// Room for small scenes of the new shapes.
const ROOM: Capacities = Capacities {
    shapes: 200,
    hulls: 8,
    meshes: 2,
    mesh_vertices: 2_000,
    mesh_triangles: 4_000,
    height_fields: 2,
    height_samples: 20_000,
    compounds: 4,
    compound_children: 64,
    surfaces: 16,
    ..Capacities::for_bodies(100)
};

fn world() -> OwnedWorld {
    world_with(ROOM)
}

/// Adds a static body with a shape.
fn fixed(world: &mut OwnedWorld, pose: &Pose, geometry: Geometry) -> (BodyHandle, ShapeHandle) {
    let def = BodyDef { rotation: pose.rotation, ..BodyDef::new(BodyKind::Static, pose.position) };
    let body = world.create_body(&def).expect("room");
    let shape = world.create_shape(body, &ShapeDef::new(geometry)).expect("room");
    (body, shape)
}

/// Corners of a box.
fn corners(half: Vec3) -> [Vec3; 8] {
    core::array::from_fn(|i| {
        let side = |bit: usize, x: f32| if i >> bit & 1 == 1 { x } else { -x };
        Vec3::new(side(0, half.x), side(1, half.y), side(2, half.z))
    })
}

/// Vertices and triangles of a level grid of `n` x `n` cells of edge `cell` around the origin.
fn grid(n: u32, cell: f32) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let at = |i: u32| (i as f32 - 0.5 * n as f32) * cell;
    let vertices = (0..(n + 1) * (n + 1)).map(|i| Vec3::new(at(i % (n + 1)), at(i / (n + 1)), 0.0)).collect();
    let mut triangles = Vec::new();
    for i in 0..n * n {
        let a = i / n * (n + 1) + i % n;
        triangles.extend([[a, a + 1, a + n + 2], [a, a + n + 2, a + n + 1]]);
    }
    (vertices, triangles)
}

/// What stands under the bodies: the surface is the plane z = 0 in the frame of the floor, at least 4 m each way.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Floor {
    HalfSpace,
    Slab,
    Hull,
    RoundedHull,
    Cylinder,
    Mesh,
    HeightField,
    Compound,
}

const FLOORS: [Floor; 8] = [
    Floor::HalfSpace,
    Floor::Slab,
    Floor::Hull,
    Floor::RoundedHull,
    Floor::Cylinder,
    Floor::Mesh,
    Floor::HeightField,
    Floor::Compound,
];

impl Floor {
    /// Makes the floor, turned about the origin of the world.
    fn build(self, world: &mut OwnedWorld, turn: Rotation) -> ShapeHandle {
        let below = |z: f32| Vec3::new(0.0, 0.0, -z);
        let (middle, geometry) = match self {
            Floor::HalfSpace => (Vec3::ZERO, Geometry::HalfSpace),
            Floor::Slab => (below(1.0), Geometry::Box { half_extents: Vec3::new(20.0, 20.0, 1.0) }),
            Floor::Hull => {
                let hull = world.add_hull(&corners(Vec3::new(20.0, 20.0, 1.0))).expect("a box");
                (below(1.0), Geometry::Hull(hull))
            }
            Floor::RoundedHull => {
                let hull = world.add_hull(&corners(Vec3::new(20.0, 20.0, 0.8))).expect("a box");
                (below(1.0), Geometry::RoundedHull { hull, radius: 0.2 })
            }
            Floor::Cylinder => (below(1.0), Geometry::Cylinder { half_height: 1.0, radius: 20.0 }),
            Floor::Mesh => {
                let (vertices, triangles) = grid(20, 1.7);
                (Vec3::ZERO, Geometry::Mesh(world.add_mesh(&vertices, &triangles).expect("a grid")))
            }
            Floor::HeightField => {
                let heights = [0.0; 41 * 41];
                let def = HeightFieldDef {
                    columns: 41,
                    rows: 41,
                    spacing: [0.9, 0.8],
                    heights: &heights,
                    cells: &[],
                    surfaces: &[],
                };
                let field = world.add_height_field(&def).expect("a field");
                (Vec3::new(-18.1, -16.3, 0.0), Geometry::HeightField(field))
            }
            Floor::Compound => {
                let tile = |i: u32| CompoundChild {
                    geometry: Geometry::Box { half_extents: Vec3::new(20.0, 1.25, 0.5) },
                    pose: Pose::new(Vec3::new(0.0, 2.5 * i as f32 - 8.75, 0.0), Rotation::IDENTITY),
                };
                let tiles: Vec<CompoundChild> = (0..8).map(tile).collect();
                (below(0.5), Geometry::Compound(world.add_compound(&tiles).expect("tiles")))
            }
        };
        fixed(world, &Pose::new(turn.rotate(middle), turn), geometry).1
    }
}
