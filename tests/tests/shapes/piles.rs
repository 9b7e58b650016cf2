//! A pile of everything in a box: nothing leaves, and no bit depends on the executor, on caches or on a restore.

use super::*;
use cellstep::{Pool, Position, Serial};
use cellstep_tests::executors::{Random, Shuffled};
use cellstep_tests::oracles::{center, norm, velocity};

/// A tray with walls of 2 m, over a height field, and 60 bodies of every kind that fall into it.
fn pile() -> (OwnedWorld, Vec<BodyHandle>) {
    let mut world = world_with(Capacities { contacts: 1_500, pairs: 3_000, ..ROOM });
    let heights: Vec<f32> = (0..169).map(|i| 0.05 * ((i * 7) % 5) as f32).collect();
    let def = HeightFieldDef {
        columns: 13,
        rows: 13,
        spacing: [0.5, 0.5],
        heights: &heights,
        cells: &[],
        surfaces: &[],
    };
    let field = world.add_height_field(&def).expect("a field");
    fixed(
        &mut world,
        &Pose::new(Vec3::new(-3.0, -3.0, 0.0), Rotation::IDENTITY),
        Geometry::HeightField(field),
    );
    for (x, y) in [(1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)] {
        let half = Vec3::new(0.5 + 2.0 * f32::abs(y), 0.5 + 2.0 * f32::abs(x), 3.0);
        let pose = Pose::new(Vec3::new(2.5 * x, 2.5 * y, 2.5), Rotation::IDENTITY);
        fixed(&mut world, &pose, Geometry::Box { half_extents: half });
    }
    let hull = world.add_hull(&corners(Vec3::new(0.2, 0.15, 0.1))).expect("a box");
    let rod = |x: f32, y: f32| CompoundChild {
        geometry: Geometry::Cylinder { half_height: 0.2, radius: 0.06 },
        pose: Pose::new(Vec3::new(x, y, -0.2), Rotation::IDENTITY),
    };
    let top = CompoundChild {
        geometry: Geometry::Box { half_extents: Vec3::new(0.3, 0.3, 0.05) },
        pose: Pose::IDENTITY,
    };
    let stool = [top, rod(0.2, 0.2), rod(-0.2, 0.2), rod(0.2, -0.2), rod(-0.2, -0.2)];
    let stool = world.add_compound(&stool).expect("a stool");
    let bodies = (0..60)
        .map(|i| {
            let geometry = match i % 8 {
                0 | 1 => Geometry::Cylinder { half_height: 0.2, radius: 0.2 },
                2 => Geometry::Cone { half_height: 0.25, radius: 0.25 },
                3 => Geometry::RoundedHull { hull, radius: 0.06 },
                4 => Geometry::Compound(stool),
                5 => Geometry::Sphere { radius: 0.2 },
                6 => Geometry::Capsule { half_height: 0.2, radius: 0.12 },
                _ => Geometry::Hull(hull),
            };
            let (x, y, z) = (i % 4, i / 4 % 4, i / 16);
            let at = Vec3::new(0.8 * x as f32 - 1.2, 0.8 * y as f32 - 1.2, 1.0 + 0.8 * z as f32);
            let turn = Rotation::from_rotation_vector(Vec3::new(0.3, 0.7, -0.2) * i as f32);
            // Nothing else takes energy from what rolls, or rocks on its rim.
            let angular_damping = 1.0;
            let def = BodyDef { rotation: turn, angular_damping, ..BodyDef::new(BodyKind::Dynamic, at) };
            let body = world.create_body(&def).expect("room");
            world.create_shape(body, &ShapeDef::new(geometry)).expect("room");
            body
        })
        .collect();
    (world, bodies)
}

#[test]
fn a_pile_of_everything_stays_in_its_box_and_comes_to_rest() {
    let (mut world, bodies) = pile();
    let mut dropped = 0;
    for _ in 0..600 {
        dropped += world.step(&mut Serial).dropped;
    }
    assert_eq!(dropped, 0);
    let mut fastest = 0.0_f64;
    for &body in &bodies {
        let at = center(&world, body);
        assert!(at[0].abs() < 2.0 && at[1].abs() < 2.0 && at[2] > 0.0 && at[2] < 4.0, "{at:?}");
        fastest = fastest.max(norm(velocity(&world, body)));
    }
    println!("fastest after 10 s {fastest:.1e} m/s, deepest {:.4} m", world.penetration_max());
    assert!(fastest < 0.2, "{fastest}");
    assert!(world.penetration_max() < 0.03, "{}", world.penetration_max());
}

#[test]
fn bits_do_not_depend_on_executor_caches_or_a_restore() {
    let (mut world, _) = pile();
    let mut pool = Pool::new(2).expect("threads");
    let mut shuffled = Shuffled::new(3);
    let (mut other, _) = pile();
    let (mut third, _) = pile();
    let mut snapshot = Vec::new();
    for step in 0..150 {
        world.step(&mut Serial);
        other.step(&mut shuffled);
        third.step(&mut pool);
        assert_eq!(world.state(), other.state(), "step {step}");
        assert_eq!(world.state(), third.state(), "step {step}");
        if step % 20 == 7 {
            other.drop_caches();
            snapshot = vec![0; third.snapshot_bytes()];
            third.save(&mut snapshot).expect("the buffer is large enough");
            third.restore(&snapshot).expect("its own snapshot");
        }
    }
    // Bytes from elsewhere are accepted exactly.
    let (mut fourth, _) = pile();
    fourth.load(&snapshot).expect("a snapshot of an equal world");
    let mut again = vec![0; fourth.snapshot_bytes()];
    fourth.save(&mut again).expect("the buffer is large enough");
    assert_eq!(snapshot, again);
}

#[test]
fn snapshots_with_shapes_that_do_not_exist_are_refused() {
    let (mut world, bodies) = pile();
    world.step(&mut Serial);
    let mut snapshot = vec![0; world.snapshot_bytes()];
    world.save(&mut snapshot).expect("the buffer is large enough");
    // The rows of shapes hold kind and size: find the first cylinder's and change them.
    let row = |kind: u32, size: [u32; 3]| -> Vec<u8> {
        [kind, size[0], size[1], size[2]].iter().flat_map(|word| word.to_le_bytes()).collect()
    };
    let (h, r) = (0.2_f32.to_bits(), 0.2_f32.to_bits());
    let known = row(7, [r, h, 0]);
    let place = snapshot.windows(16).position(|bytes| bytes == known).expect("a cylinder");
    let bad = [
        row(7, [r, 0, 0]),
        row(7, [f32::NAN.to_bits(), h, 0]),
        row(7, [r, h, 1]),
        row(8, [(-0.2_f32).to_bits(), h, 0]),
        row(9, [1, r, 0]),
        row(9, [0, 0, 0]),
        row(10, [0, 0, 0]),
        row(11, [1, 0, 0]),
        row(12, [0, 0, 0]),
    ];
    let before = world.checksum();
    for bad in bad {
        let mut changed = snapshot.clone();
        changed[place..place + 16].copy_from_slice(&bad);
        assert!(world.load(&changed).is_err(), "{bad:?}");
        assert_eq!(world.checksum(), before);
    }
    // Other shapes that do exist are welcome.
    for good in [row(8, [r, h, 0]), row(9, [0, r, 0]), row(11, [0, 0, 0])] {
        let mut changed = snapshot.clone();
        changed[place..place + 16].copy_from_slice(&good);
        world.load(&changed).expect("exists");
        for _ in 0..20 {
            world.step(&mut Serial);
        }
    }
    assert!(world.contains_body(bodies[0]));
}

#[test]
fn geometry_comes_back_as_it_was_given() {
    let (mut world, _) = pile();
    let hull = cellstep::HullHandle(0);
    let body = world.create_body(&BodyDef::new(BodyKind::Static, Vec3::Z * 50.0)).expect("room");
    let geometries = [
        Geometry::Cylinder { half_height: 0.3, radius: 0.7 },
        Geometry::Cone { half_height: 1.0e-5, radius: 1.0e5 },
        Geometry::RoundedHull { hull, radius: 0.01 },
        Geometry::HeightField(cellstep::HeightFieldHandle(0)),
        Geometry::Compound(cellstep::CompoundHandle(0)),
    ];
    for geometry in geometries {
        let shape = world.create_shape(body, &ShapeDef::new(geometry)).expect("room");
        assert_eq!(world.shape(shape).expect("lives").geometry, geometry);
        world.set_geometry(shape, &geometries[0], &Pose::IDENTITY).expect("in range");
        assert_eq!(world.shape(shape).expect("lives").geometry, geometries[0]);
    }
}

/// Bodies that come, go, change their form and are thrown about: bits stay equal, and `load` takes every state.
#[test]
fn bits_stay_equal_while_everything_changes() {
    let kinds = |i: u64, size: f32| match i {
        0 => Geometry::Cylinder { half_height: size, radius: 0.3 },
        1 => Geometry::Cone { half_height: 0.3, radius: size },
        2 => Geometry::RoundedHull { hull: cellstep::HullHandle(0), radius: 0.3 * size },
        3 => Geometry::Compound(cellstep::CompoundHandle(0)),
        4 => Geometry::Cylinder { half_height: 0.02, radius: size },
        5 => Geometry::Hull(cellstep::HullHandle(0)),
        _ => Geometry::Sphere { radius: size },
    };
    let play = |world: &mut OwnedWorld, bodies: &mut Vec<BodyHandle>, random: &mut Random| {
        for _ in 0..4 {
            let body = bodies[random.below(bodies.len() as u64) as usize];
            let at =
                Vec3::new(random.between(-1.5, 1.5), random.between(-1.5, 1.5), random.between(1.0, 4.0));
            let turn = Rotation::from_rotation_vector(at * 2.0);
            let geometry = kinds(random.below(7), random.between(0.1, 0.4));
            match random.below(4) {
                0 => world.set_pose(body, Position::at(at), turn).expect("lives"),
                1 => {
                    let shape = world.shapes_of(body).expect("lives").next().expect("one shape");
                    world.set_geometry(shape, &geometry, &Pose::IDENTITY).expect("in range");
                }
                2 => world.set_linear_velocity(body, at * 3.0).expect("lives"),
                _ => {
                    world.remove_body(body).expect("lives");
                    let def = BodyDef { rotation: turn, ..BodyDef::new(BodyKind::Dynamic, at) };
                    let new = world.create_body(&def).expect("room");
                    world.create_shape(new, &ShapeDef::new(geometry)).expect("room");
                    bodies.retain(|old| *old != body);
                    bodies.push(new);
                }
            }
        }
    };
    let (mut world, mut bodies) = pile();
    let (mut other, mut others) = pile();
    let (mut random, mut twin) = (Random::new(5), Random::new(5));
    let mut shuffled = Shuffled::new(8);
    for step in 0..300 {
        if step % 3 == 0 {
            play(&mut world, &mut bodies, &mut random);
            play(&mut other, &mut others, &mut twin);
        }
        let report = world.step(&mut Serial);
        assert_eq!(report.quarantined, 0, "step {step}");
        other.step(&mut shuffled);
        assert_eq!(world.state(), other.state(), "step {step}");
        if step % 10 == 4 {
            let mut snapshot = vec![0; other.snapshot_bytes()];
            other.save(&mut snapshot).expect("the buffer is large enough");
            other.load(&snapshot).expect("a state that steps made");
        }
    }
    // Most are still in the tray; some were thrown over its walls.
    let within = bodies.iter().filter(|&&body| center(&world, body)[2] > 0.0).count();
    assert!(within > 50, "{within} of {}", bodies.len());
}
