//! Compounds: mass, contacts of children, and what is refused.

use super::*;
use cellstep::collide::compound::CompoundError;
use cellstep::{CompoundHandle, Error, HullHandle, MeshHandle, Serial};
use cellstep_tests::oracles::{center, norm, velocity};
use cellstep_tests::worlds::{add, run};

fn ball(x: f32, y: f32, z: f32, radius: f32) -> CompoundChild {
    CompoundChild {
        geometry: Geometry::Sphere { radius },
        pose: Pose::new(Vec3::new(x, y, z), Rotation::IDENTITY),
    }
}

#[test]
fn mass_is_that_of_a_body_with_the_children_as_shapes() {
    let mut world = world();
    let hull = world.add_hull(&corners(Vec3::splat(0.2))).expect("a box");
    let turned = Rotation::from_rotation_vector(Vec3::new(0.3, -0.8, 0.5));
    let parts = [
        (Geometry::Cylinder { half_height: 0.5, radius: 0.2 }, Vec3::new(0.4, 0.0, 0.1)),
        (Geometry::Cone { half_height: 0.3, radius: 0.25 }, Vec3::new(-0.3, 0.5, 0.0)),
        (Geometry::RoundedHull { hull, radius: 0.05 }, Vec3::new(0.0, -0.6, 0.2)),
        (Geometry::Capsule { half_height: 0.2, radius: 0.1 }, Vec3::new(0.1, 0.1, 0.7)),
    ];
    let children = parts.map(|(geometry, at)| CompoundChild { geometry, pose: Pose::new(at, turned) });
    let compound = world.add_compound(&children).expect("children");
    let own = Pose::new(Vec3::new(0.2, 0.3, -0.4), Rotation::from_axis_angle(Vec3::X, 0.7));
    let def = BodyDef::new(BodyKind::Dynamic, Vec3::Z * 5.0);
    let (one, _) =
        add(&mut world, &def, &ShapeDef { pose: own, ..ShapeDef::new(Geometry::Compound(compound)) });
    let many = world.create_body(&def).expect("room");
    for child in children {
        let def = ShapeDef { pose: own.after(&child.pose), ..ShapeDef::new(child.geometry) };
        world.create_shape(many, &def).expect("room");
    }
    let [a, b] = [one, many].map(|body| world.mass_properties(body).expect("lives"));
    assert!((a.mass - b.mass).abs() < 1.0e-5 * b.mass, "{a:?} {b:?}");
    assert!((a.center - b.center).length() < 1.0e-6, "{a:?} {b:?}");
    assert!((a.inertia - b.inertia).length() < 1.0e-5 * b.inertia.length(), "{a:?} {b:?}");
}

#[test]
fn a_contact_names_the_children_that_touch() {
    let mut world = world();
    let bumps: Vec<CompoundChild> = (0..40).map(|i| ball(i as f32, 0.0, 0.0, 0.3)).collect();
    let row = world.add_compound(&bumps).expect("balls");
    let pair = world.add_compound(&[ball(0.0, 0.0, 5.0, 0.1), ball(0.0, 0.0, 0.0, 0.3)]).expect("balls");
    let (_, under) = fixed(&mut world, &Pose::IDENTITY, Geometry::Compound(row));
    let at = |x: f32| Pose::new(Vec3::new(x, 0.0, 0.59), Rotation::IDENTITY);
    let (_, plain) = fixed(&mut world, &at(7.0), Geometry::Sphere { radius: 0.3 });
    let (_, over) = fixed(&mut world, &at(33.0), Geometry::Compound(pair));
    let (_, plane) = fixed(&mut world, &Pose::new(Vec3::Z * -0.29, Rotation::IDENTITY), Geometry::HalfSpace);
    let children = |a: ShapeHandle, b: ShapeHandle| {
        let mut found = Vec::new();
        world.manifolds(a, b, |manifold| {
            assert!(manifold.points.iter().all(|point| (point.separation + 0.01).abs() < 1.0e-5));
            found.push((manifold.child, manifold.points.len(), manifold.normal));
        });
        found
    };
    assert_eq!(children(under, plain), [(7 << 12, 1, Vec3::Z)]);
    assert_eq!(children(plain, under), [(7 << 12, 1, -Vec3::Z)]);
    assert_eq!(children(under, over), [(33 << 12 | 1, 1, Vec3::Z)]);
    assert_eq!(children(over, under), [(1 << 12 | 33, 1, -Vec3::Z)]);
    // Forty balls on a plane: one manifold by the ends of the row.
    let found = children(under, plane);
    assert_eq!((found.len(), found[0].2), (1, -Vec3::Z));
    assert!((2..=4).contains(&found[0].1));
}

/// Two rows of balls that lie crosswise, like combs, and a ring over a peg: what only concave shapes do.
#[test]
fn a_ring_hangs_on_a_peg() {
    let mut world = world();
    let parts: Vec<CompoundChild> = (0..12)
        .map(|i| {
            let turn = Rotation::from_axis_angle(Vec3::Y, i as f32 * core::f32::consts::PI / 6.0);
            let along = turn.after(Rotation::from_axis_angle(Vec3::Y, 0.0));
            CompoundChild {
                geometry: Geometry::Capsule { half_height: 0.12, radius: 0.05 },
                pose: Pose::new(along.rotate(Vec3::X * 0.4), along),
            }
        })
        .collect();
    let ring = world.add_compound(&parts).expect("a ring");
    let peg = Rotation::from_axis_angle(Vec3::X, core::f32::consts::FRAC_PI_2);
    let geometry = Geometry::Cylinder { half_height: 0.6, radius: 0.1 };
    fixed(&mut world, &Pose::new(Vec3::Z * 3.0, peg), geometry);
    let def = BodyDef { angular_damping: 0.5, ..BodyDef::new(BodyKind::Dynamic, Vec3::Z * 2.8) };
    let (body, _) = add(&mut world, &def, &ShapeDef::new(Geometry::Compound(ring)));
    run(&mut world, 900);
    let at = center(&world, body);
    assert!((at[2] - 2.75).abs() < 0.03 && at[0].abs() < 0.2 && at[1].abs() < 0.5, "{at:?}");
    assert!(norm(velocity(&world, body)) < 0.3, "{:?}", velocity(&world, body));
}

#[test]
fn bad_compounds_are_refused_and_change_nothing() {
    let mut world = world();
    let (vertices, triangles) = grid(2, 1.0);
    let mesh = world.add_mesh(&vertices, &triangles).expect("a grid");
    let good = ball(0.0, 0.0, 0.0, 1.0);
    let compound = world.add_compound(&[good]).expect("one child");
    let before = (world.assets_hash(), world.checksum());
    let of = |geometry| CompoundChild { geometry, ..good };
    let refused = |world: &mut OwnedWorld, bad: CompoundChild, error: CompoundError| {
        assert_eq!(world.add_compound(&[good, bad]), Err(Error::Compound(error)));
        assert_eq!((world.assets_hash(), world.checksum()), before);
    };
    for bad in [Geometry::HalfSpace, Geometry::Mesh(mesh), Geometry::Compound(compound)] {
        refused(&mut world, of(bad), CompoundError::NotConvex { child: 1 });
    }
    refused(&mut world, of(Geometry::Hull(HullHandle(0))), CompoundError::NoSuchHull { child: 1 });
    let rounded = Geometry::RoundedHull { hull: HullHandle(7), radius: 0.1 };
    refused(&mut world, of(rounded), CompoundError::NoSuchHull { child: 1 });
    for radius in [0.0, f32::NAN, f32::INFINITY, 1.0e6] {
        let cone = Geometry::Cone { half_height: 1.0, radius };
        refused(&mut world, of(cone), CompoundError::OutOfRange { child: 1 });
        let cylinder = Geometry::Cylinder { half_height: radius, radius: 1.0 };
        refused(&mut world, of(cylinder), CompoundError::OutOfRange { child: 1 });
    }
    let far = CompoundChild { pose: Pose::new(Vec3::X * 2.0e5, Rotation::IDENTITY), ..good };
    refused(&mut world, far, CompoundError::OutOfRange { child: 1 });
    assert_eq!(world.add_compound(&[]), Err(Error::Compound(CompoundError::Empty)));
    let many = vec![good; 4097];
    assert_eq!(world.add_compound(&many), Err(Error::Compound(CompoundError::TooManyChildren)));
    assert_eq!(world.add_compound(&many[..64]), Err(Error::Full { name: "compound_children" }));
    for _ in 0..3 {
        world.add_compound(&[good]).expect("room");
    }
    assert_eq!(world.add_compound(&[good]), Err(Error::Full { name: "compounds" }));
    let def = BodyDef::new(BodyKind::Dynamic, Vec3::ZERO);
    let body = world.create_body(&def).expect("room");
    let stale = ShapeDef::new(Geometry::Compound(CompoundHandle(4)));
    assert_eq!(world.create_shape(body, &stale), Err(Error::Stale { what: "compound" }));
    assert_eq!(world.compound(CompoundHandle(4)).err(), Some(Error::Stale { what: "compound" }));
    assert_eq!(world.compound(compound).expect("registered").len(), 1);
    world.step(&mut Serial);
    assert_eq!(world.add_compound(&[good]), Err(Error::AssetsSealed));
    let _ = MeshHandle(0);
}
