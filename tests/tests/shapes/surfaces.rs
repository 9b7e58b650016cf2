//! Height fields with holes, and materials of triangles and cells.

use super::*;
use cellstep::collide::height_field::{HOLE, HeightFieldError};
use cellstep::{Error, HeightFieldHandle, HullHandle, Surface};
use cellstep_tests::oracles::{center, norm, velocity};
use cellstep_tests::worlds::{add, run};

const ICE: Surface = Surface { friction: 0.0, restitution: 0.0 };
const RUBBER: Surface = Surface { friction: 1.0, restitution: 0.9 };

/// A level field of 10 x 10 cells of a metre from the origin on; the cells of the first five columns are of the
/// first surface, the others of the second.
fn halves(world: &mut OwnedWorld) -> HeightFieldHandle {
    let cells: Vec<u8> = (0..100).map(|cell| u8::from(cell % 10 >= 5)).collect();
    let def = HeightFieldDef {
        columns: 11,
        rows: 11,
        spacing: [1.0, 1.0],
        heights: &[0.0; 121],
        cells: &cells,
        surfaces: &[ICE, RUBBER],
    };
    world.add_height_field(&def).expect("a field")
}

/// The same as a mesh.
fn mesh_halves(world: &mut OwnedWorld) -> Geometry {
    let (vertices, triangles) = grid(10, 1.0);
    let vertices: Vec<Vec3> = vertices.iter().map(|v| *v + Vec3::new(5.0, 5.0, 0.0)).collect();
    let indices: Vec<u8> = (0..200).map(|i| u8::from(i / 2 % 10 >= 5)).collect();
    let mesh = world.add_mesh_with_surfaces(&vertices, &triangles, (&indices, &[ICE, RUBBER]));
    Geometry::Mesh(mesh.expect("a grid"))
}

#[test]
fn triangles_have_their_own_friction_and_restitution() {
    for is_mesh in [false, true] {
        let mut world = world();
        let geometry =
            if is_mesh { mesh_halves(&mut world) } else { Geometry::HeightField(halves(&mut world)) };
        fixed(&mut world, &Pose::IDENTITY, geometry);
        // Boxes that slide, and balls that fall, on each half.
        let half = Geometry::Box { half_extents: Vec3::splat(0.2) };
        let slides = [1.0, 6.0].map(|x| {
            let def = BodyDef {
                linear_velocity: Vec3::Y * 2.0,
                ..BodyDef::new(BodyKind::Dynamic, Vec3::new(x, 1.0, 0.2))
            };
            add(&mut world, &def, &ShapeDef { friction: 0.5, ..ShapeDef::new(half) }).0
        });
        let falls = [3.0, 8.0].map(|x| {
            let def = BodyDef::new(BodyKind::Dynamic, Vec3::new(x, 8.0, 1.2));
            add(&mut world, &def, &ShapeDef::new(Geometry::Sphere { radius: 0.2 })).0
        });
        run(&mut world, 30);
        let mut highest = [0.0_f64; 2];
        for _ in 0..60 {
            run(&mut world, 1);
            for (high, ball) in highest.iter_mut().zip(falls) {
                *high = high.max(center(&world, ball)[2]);
            }
        }
        let [ice, rubber] = slides.map(|body| velocity(&world, body)[1]);
        assert!((ice - 2.0).abs() < 1.0e-3, "slides on ice at {ice} m/s");
        assert!(rubber.abs() < 1.0e-3, "stands on rubber: {rubber} m/s");
        assert!(highest[0] < 0.21, "does not bounce on ice: {highest:?}");
        assert!((highest[1] - 0.2 - 0.81).abs() < 0.02, "bounces to e^2 h: {highest:?}");
    }
}

#[test]
fn bodies_cross_the_edges_of_cells_without_a_bump() {
    let lying = Rotation::from_axis_angle(Vec3::X, core::f32::consts::FRAC_PI_2);
    let mut probe = world();
    let hull = probe.add_hull(&corners(Vec3::splat(0.15))).expect("a box");
    let moving = [
        ("box", Geometry::Box { half_extents: Vec3::splat(0.2) }, Rotation::IDENTITY, 0.2),
        (
            "cylinder on its base",
            Geometry::Cylinder { half_height: 0.2, radius: 0.3 },
            Rotation::IDENTITY,
            0.2,
        ),
        ("rolling cylinder", Geometry::Cylinder { half_height: 0.2, radius: 0.3 }, lying, 0.3),
        ("cone on its base", Geometry::Cone { half_height: 0.2, radius: 0.3 }, Rotation::IDENTITY, 0.2),
        ("rounded box", Geometry::RoundedHull { hull, radius: 0.05 }, Rotation::IDENTITY, 0.2),
        ("ball", Geometry::Sphere { radius: 0.2 }, Rotation::IDENTITY, 0.2),
    ];
    for (name, geometry, rotation, height) in moving {
        for is_mesh in [false, true] {
            let mut world = world();
            let registered = world.add_hull(&corners(Vec3::splat(0.15))).expect("a box");
            assert_eq!(registered, hull);
            let under =
                if is_mesh { mesh_halves(&mut world) } else { Geometry::HeightField(halves(&mut world)) };
            fixed(&mut world, &Pose::IDENTITY, under);
            let direction = Vec3::new(0.6, 3.0, 0.0);
            let def = BodyDef {
                rotation,
                linear_velocity: direction,
                ..BodyDef::new(BodyKind::Dynamic, Vec3::new(1.3, 1.0, height))
            };
            let (body, _) = add(&mut world, &def, &ShapeDef { friction: 0.0, ..ShapeDef::new(geometry) });
            let mut bump = 0.0_f64;
            for step in 0..120 {
                run(&mut world, 1);
                let v = velocity(&world, body);
                if step > 20 {
                    bump = bump.max(v[2].abs());
                }
            }
            let v = velocity(&world, body);
            println!("{name}, mesh {is_mesh}: bumps at {bump:.1e} m/s, velocity {v:.4?}");
            assert!(bump < 5.0e-3, "{name}, mesh {is_mesh}: bumps at {bump} m/s");
            let lost = norm([v[0] - f64::from(direction.x), v[1] - f64::from(direction.y), 0.0]);
            assert!(lost < 5.0e-3, "{name}, mesh {is_mesh}: {v:?}");
        }
    }
}

#[test]
fn what_comes_over_a_hole_falls_through() {
    let mut world = world();
    let mut cells = [0; 100];
    for cell in [44, 45, 54, 55] {
        cells[cell] = HOLE;
    }
    let heights: Vec<f32> = (0..121).map(|i| 0.1 * (i % 3) as f32).collect();
    let def = HeightFieldDef {
        columns: 11,
        rows: 11,
        spacing: [1.0, 1.0],
        heights: &heights,
        cells: &cells,
        surfaces: &[],
    };
    let field = world.add_height_field(&def).expect("a field");
    fixed(&mut world, &Pose::IDENTITY, Geometry::HeightField(field));
    let geometries = [
        Geometry::Sphere { radius: 0.3 },
        Geometry::Box { half_extents: Vec3::splat(0.3) },
        Geometry::Cylinder { half_height: 0.3, radius: 0.3 },
        Geometry::Cone { half_height: 0.3, radius: 0.3 },
    ];
    let mut put = |geometry, at: Vec3| {
        add(&mut world, &BodyDef::new(BodyKind::Dynamic, at), &ShapeDef::new(geometry)).0
    };
    let mut fallen = Vec::new();
    let mut held = Vec::new();
    for (i, &geometry) in geometries.iter().enumerate() {
        fallen.push(put(geometry, Vec3::new(5.0, 5.0, 1.0 + i as f32)));
        held.push(put(geometry, Vec3::new(2.0 + 2.0 * i as f32, 1.5, 1.0)));
        held.push(put(geometry, Vec3::new(2.0 + 2.0 * i as f32, 8.5, 1.0)));
    }
    run(&mut world, 240);
    for body in fallen {
        assert!(center(&world, body)[2] < -5.0, "{:?}", center(&world, body));
    }
    for body in held {
        assert!(center(&world, body)[2] > 0.1, "{:?}", center(&world, body));
    }
}

#[test]
fn fields_are_two_sided_and_hills_hold() {
    let mut world = world();
    let heights: Vec<f32> =
        (0..441).map(|i| 0.3 * cellstep::math::sin((i % 21) as f32 * 0.7) * (i / 21) as f32 * 0.1).collect();
    let def = HeightFieldDef {
        columns: 21,
        rows: 21,
        spacing: [0.5, 0.5],
        heights: &heights,
        cells: &[],
        surfaces: &[],
    };
    let field = world.add_height_field(&def).expect("a field");
    // Upside down: the half turn about x puts the field on the side of negative y.
    let over = Rotation::from_axis_angle(Vec3::X, core::f32::consts::PI);
    fixed(&mut world, &Pose::new(Vec3::Y * 10.0, over), Geometry::HeightField(field));
    let bodies: Vec<BodyHandle> = (0..16)
        .map(|i| {
            let at = Vec3::new(2.0 + 2.0 * (i % 4) as f32, 2.0 + 2.0 * (i / 4) as f32, 1.5);
            let geometry = match i % 4 {
                0 => Geometry::Cylinder { half_height: 0.3, radius: 0.2 },
                1 => Geometry::Cone { half_height: 0.3, radius: 0.3 },
                2 => Geometry::Box { half_extents: Vec3::splat(0.25) },
                _ => Geometry::Capsule { half_height: 0.3, radius: 0.2 },
            };
            let def =
                BodyDef { angular_damping: 2.0, linear_damping: 1.0, ..BodyDef::new(BodyKind::Dynamic, at) };
            add(&mut world, &def, &ShapeDef { friction: 1.0, ..ShapeDef::new(geometry) }).0
        })
        .collect();
    run(&mut world, 300);
    for body in bodies {
        let at = center(&world, body);
        assert!(at[2] > -1.0 && at[2] < 1.5, "{at:?}");
    }
    assert!(world.penetration_max() < 0.02, "{}", world.penetration_max());
}

#[test]
fn bad_fields_and_surfaces_are_refused_and_change_nothing() {
    let mut world = world();
    let before = (world.assets_hash(), world.checksum());
    let good = HeightFieldDef {
        columns: 3,
        rows: 2,
        spacing: [1.0, 1.0],
        heights: &[0.0; 6],
        cells: &[],
        surfaces: &[],
    };
    let refused = |world: &mut OwnedWorld, def: HeightFieldDef<'_>, error: Error| {
        assert_eq!(world.add_height_field(&def), Err(error));
        assert_eq!((world.assets_hash(), world.checksum()), before);
    };
    let field = Error::HeightField;
    refused(&mut world, HeightFieldDef { rows: 1, ..good }, field(HeightFieldError::TooFewSamples));
    refused(
        &mut world,
        HeightFieldDef { spacing: [f32::NAN, 1.0], ..good },
        field(HeightFieldError::Spacing),
    );
    let few = HeightFieldError::HeightCount { needed: 9, given: 6 };
    refused(&mut world, HeightFieldDef { rows: 3, ..good }, field(few));
    let infinite = [0.0, 0.0, f32::INFINITY, 0.0, 0.0, 0.0];
    let bad = field(HeightFieldError::Height { sample: 2 });
    refused(&mut world, HeightFieldDef { heights: &infinite, ..good }, bad);
    let bad = field(HeightFieldError::NoSuchSurface { cell: 1 });
    refused(&mut world, HeightFieldDef { cells: &[HOLE, 1], surfaces: &[ICE], ..good }, bad);
    for bad in [Surface { friction: -1.0, ..ICE }, Surface { restitution: f32::NAN, ..ICE }] {
        let def = HeightFieldDef { surfaces: &[ICE, bad], ..good };
        refused(&mut world, def, Error::Surface { index: 1 });
    }
    refused(&mut world, HeightFieldDef { surfaces: &[ICE; 17], ..good }, Error::Full { name: "surfaces" });
    let (vertices, triangles) = grid(1, 1.0);
    for (indices, surfaces, index) in [(&[0_u8][..], &[ICE][..], 1), (&[0, 1], &[ICE], 1), (&[0, 0], &[], 0)]
    {
        let found = world.add_mesh_with_surfaces(&vertices, &triangles, (indices, surfaces));
        assert_eq!(found, Err(Error::Surface { index }));
    }
    let found = world.add_mesh_with_surfaces(&vertices, &triangles, (&[0, 0], &[ICE; 17]));
    assert_eq!(found, Err(Error::Full { name: "surfaces" }));
    assert_eq!((world.assets_hash(), world.checksum()), before);
    let field = world.add_height_field(&good).expect("a field");
    assert_ne!(world.assets_hash(), before.0);
    assert_eq!(world.height_field(field).expect("registered").columns, 3);
    let body = world.create_body(&BodyDef::new(BodyKind::Dynamic, Vec3::ZERO)).expect("room");
    let needs = "half-spaces, meshes and height fields are for static and kinematic bodies";
    let on_dynamic = world.create_shape(body, &ShapeDef::new(Geometry::HeightField(field)));
    assert_eq!(on_dynamic, Err(Error::WrongKind { needs }));
    let stale = ShapeDef::new(Geometry::HeightField(HeightFieldHandle(9)));
    assert_eq!(world.create_shape(body, &stale), Err(Error::Stale { what: "height field" }));
    let stale = ShapeDef::new(Geometry::RoundedHull { hull: HullHandle(9), radius: 0.1 });
    assert_eq!(world.create_shape(body, &stale), Err(Error::Stale { what: "hull" }));
}
