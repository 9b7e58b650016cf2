//! What the scenes are made of.

use super::SceneWorld;
use crate::numbers::Numbers;
use cellstep_core::math::{PI, Pose, Rotation, Vec3, sin};
use cellstep_core::{AxisLocks, BodyDef, BodyHandle, BodyKind, Geometry, HullHandle, ShapeDef};

/// Hulls that [`add_hulls`] registers.
const HULLS: u32 = 4;

/// Registers a wedge, a flat disc of many edges, and two clouds of points.
pub(super) fn add_hulls(world: &mut SceneWorld<'_>, numbers: &mut Numbers) {
    let wedge = [
        Vec3::new(-0.4, -0.3, -0.2),
        Vec3::new(0.4, -0.3, -0.2),
        Vec3::new(-0.4, 0.3, -0.2),
        Vec3::new(0.4, 0.3, -0.2),
        Vec3::new(-0.4, -0.3, 0.3),
        Vec3::new(-0.4, 0.3, 0.3),
    ];
    world.add_hull(&wedge).expect("a hull");
    let rim: [Vec3; 24] = core::array::from_fn(|i| {
        let turn = Rotation::from_axis_angle(Vec3::Z, (i / 2) as f32 * (PI / 6.0));
        turn.rotate(Vec3::X * 0.4) + Vec3::Z * if i % 2 == 0 { 0.1 } else { -0.1 }
    });
    world.add_hull(&rim).expect("a hull");
    let cloud: [Vec3; 14] = core::array::from_fn(|_| numbers.vector(0.35));
    world.add_hull(&cloud).expect("a hull");
    let dense: [Vec3; 60] = core::array::from_fn(|_| numbers.rotation().rotate(Vec3::Z * 0.35));
    world.add_hull(&dense).expect("a hull");
}

/// A convex geometry of one of the four kinds; hulls are registered before.
pub(super) fn any_convex(numbers: &mut Numbers) -> Geometry {
    match numbers.below(4) {
        0 => Geometry::Sphere { radius: numbers.between(0.15, 0.4) },
        1 => Geometry::Capsule { half_height: numbers.between(0.1, 0.4), radius: numbers.between(0.1, 0.3) },
        2 => {
            let (x, y, z) = (numbers.between(0.1, 0.5), numbers.between(0.1, 0.5), numbers.between(0.1, 0.5));
            Geometry::Box { half_extents: Vec3::new(x, y, z) }
        }
        _ => Geometry::Hull(HullHandle(numbers.below(HULLS))),
    }
}

/// A shape of any convex geometry and material.
pub(super) fn any_shape(numbers: &mut Numbers) -> ShapeDef {
    ShapeDef {
        density: numbers.between(200.0, 4000.0),
        friction: numbers.between(0.0, 1.2),
        restitution: numbers.between(0.0, 0.4),
        ..ShapeDef::new(any_convex(numbers))
    }
}

/// A dynamic body of one shape or two, turned anyhow, with some motion of its own.
pub(super) fn add_any(world: &mut SceneWorld<'_>, numbers: &mut Numbers, place: Vec3) -> BodyHandle {
    let def = BodyDef {
        rotation: numbers.rotation(),
        linear_velocity: numbers.vector(1.0),
        angular_velocity: numbers.vector(3.0),
        linear_damping: numbers.between(0.0, 0.1),
        angular_damping: numbers.between(0.0, 0.1),
        ..BodyDef::new(BodyKind::Dynamic, place)
    };
    let body = add(world, &def, &any_shape(numbers));
    if numbers.below(4) == 0 {
        let pose = Pose::new(numbers.vector(0.3), numbers.rotation());
        world.create_shape(body, &ShapeDef { pose, ..any_shape(numbers) }).expect("room");
    }
    body
}

/// A body of one shape.
pub(super) fn add(world: &mut SceneWorld<'_>, def: &BodyDef, shape: &ShapeDef) -> BodyHandle {
    let body = world.create_body(def).expect("room");
    world.create_shape(body, shape).expect("room");
    body
}

/// A dynamic box.
pub(super) fn add_box(world: &mut SceneWorld<'_>, place: Vec3, half_extents: Vec3) -> BodyHandle {
    let def = BodyDef::new(BodyKind::Dynamic, place);
    add(world, &def, &ShapeDef::new(Geometry::Box { half_extents }))
}

/// A static half-space below z = 0.
pub(super) fn add_ground(world: &mut SceneWorld<'_>) {
    add(world, &BodyDef::new(BodyKind::Static, Vec3::ZERO), &ShapeDef::new(Geometry::HalfSpace));
}

/// Four static walls, one of them a leaning half-space, around a square with half the edge `half`.
pub(super) fn add_walls(world: &mut SceneWorld<'_>, half: f32) {
    let (long, thin) = (half + 1.0, 0.5);
    let walls = [
        (Vec3::new(half + thin, 0.0, 3.0), Vec3::new(thin, long, 3.0)),
        (Vec3::new(-half - thin, 0.0, 3.0), Vec3::new(thin, long, 3.0)),
        (Vec3::new(0.0, half + thin, 3.0), Vec3::new(long, thin, 3.0)),
    ];
    for (place, half_extents) in walls {
        let def = BodyDef::new(BodyKind::Static, place);
        add(world, &def, &ShapeDef::new(Geometry::Box { half_extents }));
    }
    let leaning = BodyDef {
        rotation: Rotation::from_axis_angle(Vec3::X, -1.3),
        ..BodyDef::new(BodyKind::Static, Vec3::new(0.0, -half, 0.0))
    };
    add(world, &leaning, &ShapeDef::new(Geometry::HalfSpace));
}

/// Any convex bodies on the points of a grid, `counts` along each axis, from `corner` on.
pub(super) fn add_grid(world: &mut SceneWorld<'_>, numbers: &mut Numbers, corner: Vec3, counts: [u32; 3]) {
    for layer in 0..counts[2] {
        for row in 0..counts[1] {
            for column in 0..counts[0] {
                let place = Vec3::new(column as f32, row as f32, layer as f32) * 1.1 + numbers.vector(0.05);
                add_any(world, numbers, corner + place);
            }
        }
    }
}

/// Vertices along an edge of the terrain.
const TERRAIN: usize = 13;

/// A wavy terrain mesh of 288 triangles, two metres to a square, about the origin of `body`.
pub(super) fn add_terrain(world: &mut SceneWorld<'_>, def: &BodyDef) -> BodyHandle {
    const SQUARES: usize = TERRAIN - 1;
    let vertices: [Vec3; TERRAIN * TERRAIN] = core::array::from_fn(|i| {
        let (x, y) = ((i % TERRAIN) as f32 - 6.0, (i / TERRAIN) as f32 - 6.0);
        Vec3::new(2.0 * x, 2.0 * y, sin(1.3 * x) * sin(0.9 * y) + 0.05 * (x * x + y * y))
    });
    let triangles: [[u32; 3]; 2 * SQUARES * SQUARES] = core::array::from_fn(|i| {
        let (x, y) = (i / 2 % SQUARES, i / 2 / SQUARES);
        let corner = (y * TERRAIN + x) as u32;
        let (right, up) = (corner + 1, corner + TERRAIN as u32);
        if i % 2 == 0 { [corner, right, up + 1] } else { [corner, up + 1, up] }
    });
    let mesh = world.add_mesh(&vertices, &triangles).expect("a mesh");
    add(world, def, &ShapeDef::new(Geometry::Mesh(mesh)))
}

/// Locks for body number `index`: each lock and some pairs occur.
pub(super) fn locks(index: u32) -> AxisLocks {
    let single = AxisLocks(1 << (index % 6));
    match index % 8 {
        6 => AxisLocks::TURN,
        7 => single.and(AxisLocks::TURN_X),
        _ => single,
    }
}
