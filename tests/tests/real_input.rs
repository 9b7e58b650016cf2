//! Level geometry that others made: bodies fall on it and stay on their side of every triangle.
//!
//! The files are found through the environment variable `CELLSTEP_DATA`, a folder with `meshes/*.obj`; without it
//! the tests say that they skipped.

use std::path::PathBuf;

use cellstep::math::{Rotation, Vec3};
use cellstep::scene::Scene;
use cellstep::{
    BodyDef, BodyHandle, BodyKind, Executor, Geometry, MeshHandle, Pool, Position, Serial, ShapeDef,
};
use cellstep_tests::executors::Random;
use cellstep_tests::worlds::OwnedWorld;

const BODIES: u32 = 500;
const STEPS: u32 = 600;

/// The folder of the meshes, or `None` with a note.
fn folder() -> Option<PathBuf> {
    match std::env::var_os("CELLSTEP_DATA") {
        Some(path) => Some(PathBuf::from(path).join("meshes")),
        None => {
            println!("skipped: CELLSTEP_DATA is not set");
            None
        }
    }
}

/// A world with the mesh of an OBJ file as a static body, and room for the bodies.
fn level(folder: &std::path::Path, file: &str) -> OwnedWorld {
    let text = format!(
        r#"{{
            "meshes": {{"level": {{"obj": {{
                "path": "{file}",
                "rotation": {{"axis_angle": {{"axis": [1, 0, 0], "degrees": 90}}}}
            }}}}}},
            "hulls": {{"rock": {{"points": [
                [-0.2, -0.15, -0.1], [0.2, -0.2, -0.1], [0.0, 0.25, -0.15],
                [0.05, 0.0, 0.22], [-0.15, 0.1, 0.1], [0.18, 0.12, 0.05]
            ]}}}},
            "capacities": {{"bodies": 501, "shapes": 501, "pairs": 40000, "contacts": 20000}},
            "bodies": [{{"kind": "static", "shapes": [{{"geometry": {{"mesh": "level"}}}}]}}]
        }}"#
    );
    let scene = Scene::from_json(text.as_bytes(), &cellstep::scene::Limits::default())
        .unwrap_or_else(|e| panic!("{e}"));
    scene.build(folder).unwrap_or_else(|e| panic!("{e}")).world
}

/// Adds bodies of all convex kinds above the mesh.
fn rain(world: &mut OwnedWorld) -> Vec<BodyHandle> {
    let bounds = world.mesh(MeshHandle(0)).expect("one mesh").tree.bounds();
    let mut random = Random::new(7);
    (0..BODIES)
        .map(|i| {
            let between =
                |random: &mut Random, axis: usize| random.between(bounds.min[axis], bounds.max[axis]);
            let place = Vec3::new(
                between(&mut random, 0),
                between(&mut random, 1),
                bounds.max.z + 0.5 + 0.02 * i as f32,
            );
            let turn =
                Vec3::new(random.between(-3.0, 3.0), random.between(-3.0, 3.0), random.between(-3.0, 3.0));
            let def = BodyDef {
                kind: BodyKind::Dynamic,
                position: Position::at(place),
                rotation: Rotation::from_rotation_vector(turn),
                angular_velocity: turn,
                ..BodyDef::default()
            };
            let geometry = match i % 4 {
                0 => Geometry::Sphere { radius: 0.2 },
                1 => Geometry::Box { half_extents: Vec3::new(0.2, 0.15, 0.25) },
                2 => Geometry::Capsule { half_height: 0.15, radius: 0.15 },
                _ => Geometry::Hull(cellstep::HullHandle(0)),
            };
            let body = world.create_body(&def).expect("room");
            world.create_shape(body, &ShapeDef::new(geometry)).expect("room");
            body
        })
        .collect()
}

/// Corners of all triangles, metres.
fn triangles(world: &OwnedWorld) -> Vec<[[f64; 3]; 3]> {
    let mesh = world.mesh(MeshHandle(0)).expect("one mesh");
    let corner = |vertex: u32| mesh.vertices[vertex as usize].to_array().map(f64::from);
    mesh.triangles.iter().map(|triangle| triangle.vertices.map(corner)).collect()
}

fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// True when the segment from `p` to `q` passes through the triangle (Moeller and Trumbore, in double precision).
fn crosses(p: [f64; 3], q: [f64; 3], [a, b, c]: &[[f64; 3]; 3]) -> bool {
    let (direction, ab, ac) = (minus(q, p), minus(*b, *a), minus(*c, *a));
    let h = cross(direction, ac);
    let det = dot(ab, h);
    if det == 0.0 {
        return false;
    }
    let s = minus(p, *a);
    let u = dot(s, h) / det;
    let k = cross(s, ab);
    let v = dot(direction, k) / det;
    let t = dot(ac, k) / det;
    u >= 0.0 && v >= 0.0 && u + v <= 1.0 && (0.0..=1.0).contains(&t)
}

/// Steps the rain and gives the checksum; every center's path is checked against every triangle.
fn fall(folder: &std::path::Path, file: &str, executor: &mut impl Executor) -> u64 {
    let mut world = level(folder, file);
    let bodies = rain(&mut world);
    let triangles = triangles(&world);
    let bounds = world.mesh(MeshHandle(0)).expect("one mesh").tree.bounds();
    let center = |world: &OwnedWorld, body| world.center(body).expect("alive").to_f64();
    let mut before: Vec<[f64; 3]> = bodies.iter().map(|&body| center(&world, body)).collect();
    // The meshes are open shells: a body that has left the bounding box below or beside may come back anywhere.
    let mut left = vec![false; bodies.len()];
    let mut crossings = Vec::new();
    for step in 0..STEPS {
        let report = world.step(executor);
        assert_eq!((report.dropped, report.quarantined), (0, 0), "{file} step {step}");
        for (i, &body) in bodies.iter().enumerate() {
            let now = center(&world, body);
            assert!(now.iter().all(|x| x.is_finite()), "{file} step {step} body {i}");
            left[i] |= (0..2).any(|k| now[k] < bounds.min[k].into() || now[k] > bounds.max[k].into())
                || now[2] < bounds.min.z.into();
            if !left[i] && triangles.iter().any(|triangle| crosses(before[i], now, triangle)) {
                crossings.push((step, i));
            }
            before[i] = now;
        }
    }
    let inside = left.iter().filter(|&&left| !left).count();
    println!(
        "{file}: {} triangles, {inside} of {BODIES} bodies inside at the end, {:016x}",
        triangles.len(),
        world.checksum()
    );
    assert!(inside > 50, "{file}: the mesh holds bodies");
    assert!(crossings.is_empty(), "{file}: (step, body) of centers that crossed a triangle: {crossings:?}");
    world.checksum()
}

fn check(file: &str) {
    let Some(folder) = folder() else { return };
    let one = fall(&folder, file, &mut Serial);
    let two = fall(&folder, file, &mut Pool::new(2).expect("two workers"));
    assert_eq!(one, two, "{file}: workers change no bit");
}

#[test]
fn bodies_fall_on_a_building() {
    check("building.obj");
}

#[test]
fn bodies_fall_on_a_map() {
    check("test_map01.obj");
}
