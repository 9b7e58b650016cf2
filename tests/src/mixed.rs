//! A world with every kind of shape, at random poses around the origin, for tests of queries.

use crate::executors::Random;
use crate::worlds::{OwnedWorld, world_with};
use cellstep::collide::height_field::HOLE;
use cellstep::math::{Pose, Rotation, Vec3};
use cellstep::{
    BodyDef, BodyHandle, BodyKind, Capacities, CompoundChild, CompoundHandle, Filter, Geometry,
    HeightFieldDef, HullHandle, Position, ShapeDef,
};

/// Room for the world and some more.
pub const CAPACITIES: Capacities = Capacities {
    shapes: 320,
    pairs: 4000,
    contacts: 4000,
    hulls: 2,
    meshes: 1,
    mesh_vertices: 289,
    mesh_triangles: 512,
    height_fields: 1,
    height_samples: 13 * 11,
    compounds: 2,
    compound_children: 43,
    ..Capacities::for_bodies(160)
};

/// Random things.
pub trait Draw {
    /// A vector with components up to `limit` in size.
    fn vector(&mut self, limit: f32) -> Vec3;
    /// Any rotation.
    fn rotation(&mut self) -> Rotation;
    /// A convex geometry of sizes about `scale`, metres.
    fn convex(&mut self, scale: f32) -> Geometry;
    /// A convex geometry, or one of the two compounds.
    fn solid(&mut self, scale: f32) -> Geometry;
}

impl Draw for Random {
    fn vector(&mut self, limit: f32) -> Vec3 {
        Vec3::new(self.between(-limit, limit), self.between(-limit, limit), self.between(-limit, limit))
    }

    fn rotation(&mut self) -> Rotation {
        loop {
            let mut part = || self.between(-1.0, 1.0);
            let q = Rotation::new(part(), part(), part(), part());
            if q.norm_squared() > 0.01 && q.norm_squared() < 1.0 {
                return q.normalized();
            }
        }
    }

    fn convex(&mut self, scale: f32) -> Geometry {
        let size = |random: &mut Self| scale * random.between(0.2, 1.0);
        match self.below(10) {
            0 => Geometry::Sphere { radius: size(self) },
            1 => Geometry::Capsule { half_height: size(self), radius: size(self) * 0.5 },
            2 => Geometry::Hull(HullHandle(0)),
            3 => Geometry::Hull(HullHandle(1)),
            4 | 5 => Geometry::Cylinder { half_height: size(self), radius: size(self) },
            6 | 7 => Geometry::Cone { half_height: size(self), radius: size(self) },
            8 => {
                let hull = HullHandle(self.below(2) as u32);
                Geometry::RoundedHull { hull, radius: 0.5 * size(self) }
            }
            _ => Geometry::Box { half_extents: Vec3::new(size(self), size(self), size(self)) },
        }
    }

    fn solid(&mut self, scale: f32) -> Geometry {
        match self.below(8) {
            0 => Geometry::Compound(CompoundHandle(self.below(2) as u32)),
            _ => self.convex(scale),
        }
    }
}

/// Makes the world: a half-space, a mesh of 512 triangles in waves, a height field with holes, and 120 bodies of
/// all kinds with one to three shapes each, some of them compounds of 3 or 40 children.
pub fn mixed_world(seed: u64) -> OwnedWorld {
    let mut random = Random::new(seed);
    let mut world = world_with(CAPACITIES);
    for count in [9, 40] {
        let points: Vec<Vec3> = (0..count).map(|_| random.vector(0.8)).collect();
        world.add_hull(&points).expect("points in a cube have a hull");
    }
    for (count, spread, scale) in [(3, 0.8, 0.7), (40, 1.5, 0.3)] {
        let children: Vec<CompoundChild> = (0..count)
            .map(|_| {
                let pose = Pose::new(random.vector(spread), random.rotation());
                CompoundChild { geometry: random.convex(scale), pose }
            })
            .collect();
        world.add_compound(&children).expect("convex children");
    }
    add_height_field(&mut world, &mut random);
    let vertices: Vec<Vec3> = (0..289)
        .map(|i| {
            let (x, y) = ((i % 17) as f32 - 8.0, (i / 17) as f32 - 8.0);
            Vec3::new(x * 1.5, y * 1.5, cellstep::math::sin(x * 0.7) + cellstep::math::cos(y * 0.9))
        })
        .collect();
    let mut triangles = Vec::new();
    for corner in (0..288).filter(|corner| corner % 17 != 16 && corner / 17 != 16) {
        triangles.push([corner, corner + 1, corner + 18]);
        triangles.push([corner, corner + 18, corner + 17]);
    }
    let mesh = world.add_mesh(&vertices, &triangles).expect("waves are a mesh");
    add(
        &mut world,
        BodyKind::Static,
        (Vec3::new(0.0, 0.0, -9.0), random.rotation_about_up()),
        Geometry::HalfSpace,
    );
    add(
        &mut world,
        BodyKind::Static,
        (Vec3::new(1.0, -1.0, -3.0), random.rotation_about_up()),
        Geometry::Mesh(mesh),
    );
    for i in 0..120 {
        let kind = [BodyKind::Dynamic, BodyKind::Dynamic, BodyKind::Static, BodyKind::Kinematic][i % 4];
        let (place, rotation) = (random.vector(10.0), random.rotation());
        let geometry = random.solid(1.0);
        let body = add(&mut world, kind, (place, rotation), geometry);
        for _ in 0..random.below(3) {
            let pose = Pose::new(random.vector(1.5), random.rotation());
            let filter = Filter { category: 1 << random.below(4), ..Filter::default() };
            let def = ShapeDef { pose, filter, ..ShapeDef::new(random.convex(0.7)) };
            world.create_shape(body, &def).expect("room");
        }
    }
    world
}

/// Adds a height field of 120 cells of unequal sides, a sixth of them holes.
fn add_height_field(world: &mut OwnedWorld, random: &mut Random) {
    let heights: Vec<f32> = (0..13 * 11).map(|_| random.between(-0.8, 0.8)).collect();
    let cells: Vec<u8> = (0..12 * 10).map(|_| if random.below(6) == 0 { HOLE } else { 0 }).collect();
    let def = HeightFieldDef {
        columns: 13,
        rows: 11,
        spacing: [1.4, 1.9],
        heights: &heights,
        cells: &cells,
        surfaces: &[],
    };
    let field = world.add_height_field(&def).expect("gentle hills");
    let place = (Vec3::new(-9.0, -8.0, 5.0), random.rotation_about_up());
    add(world, BodyKind::Static, place, Geometry::HeightField(field));
}

impl Random {
    /// A small tilt.
    fn rotation_about_up(&mut self) -> Rotation {
        Rotation::from_rotation_vector(self.vector(0.1))
    }
}

fn add(
    world: &mut OwnedWorld,
    kind: BodyKind,
    (place, rotation): (Vec3, Rotation),
    geometry: Geometry,
) -> BodyHandle {
    let def = BodyDef { rotation, position: Position::at(place), ..BodyDef::new(kind, place) };
    let body = world.create_body(&def).expect("room");
    world.create_shape(body, &ShapeDef::new(geometry)).expect("room");
    body
}
