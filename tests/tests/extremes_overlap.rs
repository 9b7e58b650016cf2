//! The contract for bodies that are where nothing should be, for shapes that are hardly any, and for calls that
//! make no sense: at every preset and for any number of workers.

use cellstep::math::{Rotation, Vec3};
use cellstep::{
    BodyDef, BodyHandle, BodyKind, Capacities, Error, Geometry, JointDef, Position, Preset, Serial, Settings,
    ShapeDef,
};
use cellstep_tests::executors::Random;
use cellstep_tests::extremes::Attack;
use cellstep_tests::jointed::at;
use cellstep_tests::worlds::{OwnedWorld, add, ground, run, world, world_with};

const CUBE: Geometry = Geometry::Box { half_extents: Vec3::splat(0.5) };

fn kind(i: u32) -> Geometry {
    match i % 4 {
        0 => Geometry::Sphere { radius: 0.5 },
        1 => CUBE,
        2 => Geometry::Capsule { half_height: 0.4, radius: 0.3 },
        _ => Geometry::Cylinder { half_height: 0.5, radius: 0.4 },
    }
}

#[test]
fn bodies_at_one_place_come_apart_within_the_contract() {
    for (count, floats) in [(2, true), (2, false), (10, true), (10, false), (100, true)] {
        for same in [true, false] {
            let build = |world: &mut OwnedWorld| {
                if floats {
                    let settings = Settings { gravity: Vec3::ZERO, ..world.settings() };
                    world.set_settings(&settings).expect("in range");
                } else {
                    ground(world, 0.6);
                }
                for i in 0..count {
                    let def = BodyDef::new(BodyKind::Dynamic, Vec3::Z);
                    add(world, &def, &ShapeDef::new(if same { CUBE } else { kind(i) }));
                }
            };
            let name = format!("{count} bodies at one place, alike {same}, floating {floats}");
            let attack = Attack::new(&name, count + 1, &build);
            let capacities = Capacities {
                pairs: 2 * count * count + 64,
                contacts: count * count + 64,
                ..attack.capacities
            };
            // All others push a body at once, to all sides, at 3 m/s each.
            let push_out = 6.0 * f64::from(count).sqrt();
            Attack { capacities, push_out, slack: 0.1, steps: 60, ..attack }.check();
        }
    }
}

/// A box of which the middle of the given wall is at the origin.
fn walled(world: &mut OwnedWorld, mesh: bool) {
    let body = world.create_body(&BodyDef::new(BodyKind::Static, Vec3::ZERO)).expect("room");
    let wall = if mesh {
        let corner = |i: u32| {
            let side = |bit: u32| if i >> bit & 1 == 0 { -1.0 } else { 1.0 };
            Vec3::new(2.0 * side(0), 2.0 * side(1), 0.5 * side(2))
        };
        let corners: Vec<Vec3> = (0..8).map(corner).collect();
        let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let triangles: Vec<[u32; 3]> =
            faces.iter().flat_map(|f| [[f[0], f[1], f[2]], [f[0], f[2], f[3]]]).collect();
        Geometry::Mesh(world.add_mesh(&corners, &triangles).expect("a mesh"))
    } else {
        Geometry::Box { half_extents: Vec3::new(2.0, 2.0, 0.5) }
    };
    world.create_shape(body, &ShapeDef::new(wall)).expect("room");
}

#[test]
fn bodies_inside_walls_and_meshes_keep_the_contract() {
    for mesh in [false, true] {
        let build = |world: &mut OwnedWorld| {
            walled(world, mesh);
            for i in 0..8_u8 {
                let x = 0.45 * f32::from(i) - 1.6;
                let def = BodyDef::new(BodyKind::Dynamic, Vec3::new(x, 0.0, 0.1 * f32::from(i % 3)));
                add(world, &def, &ShapeDef::new(kind(u32::from(i))));
            }
        };
        let attack = Attack::new(&format!("eight inside a wall, mesh {mesh}"), 9, &build);
        let capacities = Capacities {
            meshes: 1,
            mesh_vertices: 8,
            mesh_triangles: 12,
            contacts: 600,
            ..attack.capacities
        };
        Attack { capacities, push_out: 9.0, ..attack }.check();
    }
}

#[test]
fn teleports_keep_the_contract_asleep_and_awake() {
    for sleep_time in [0.0, 0.2] {
        let build = |world: &mut OwnedWorld| {
            let settings = Settings { sleep_time, ..world.settings() };
            world.set_settings(&settings).expect("in range");
            ground(world, 0.6);
            for i in 0..6_u8 {
                let place = Vec3::new(f32::from(i / 3) * 2.0, 0.0, 0.5 + f32::from(i % 3));
                add(world, &BodyDef::new(BodyKind::Dynamic, place), &ShapeDef::new(kind(u32::from(i))));
            }
        };
        let act = |world: &mut OwnedWorld, step: u32| {
            if !step.is_multiple_of(50) {
                return;
            }
            let body = world.bodies().nth(1 + step as usize / 50 % 6).expect("a body");
            // Onto, into and far away from the others.
            let place = [Vec3::new(0.3, 0.2, 1.2), Vec3::new(2.0, 0.0, 0.4), Vec3::new(1.0e3, 0.0, 0.6)];
            let place = Position::at(place[step as usize / 50 % 3]);
            world.set_pose(body, place, Rotation::IDENTITY).expect("in range");
        };
        let name = format!("teleports, sleep after {sleep_time} s");
        Attack { act: &act, steps: 400, push_out: 9.0, ..Attack::new(&name, 7, &build) }.check();
    }
}

#[test]
fn a_hundredfold_mass_leaves_a_pile_within_the_contract() {
    let build = |world: &mut OwnedWorld| {
        ground(world, 0.6);
        for i in 0..20_u8 {
            let place = Vec3::new(f32::from(i % 2) * 1.05, 0.0, 0.5 + 1.01 * f32::from(i / 2));
            let density = if i == 19 { 100_000.0 } else { 1000.0 };
            add(world, &BodyDef::new(BodyKind::Dynamic, place), &ShapeDef { density, ..ShapeDef::new(CUBE) });
        }
    };
    let act = |world: &mut OwnedWorld, step: u32| {
        if step == 200 {
            let heavy = world.bodies().last().expect("the last one");
            world.remove_body(heavy).expect("lives");
        }
    };
    // What the weight has pressed into each other comes apart.
    Attack { act: &act, steps: 400, push_out: 3.0, ..Attack::new("100:1 leaves", 21, &build) }.check();
}

/// Bodies, shapes and joints come and go until a handle's generation has been through a million of them.
#[test]
fn a_million_bodies_come_and_go() {
    let mut world = world_with(Capacities { joints: 2, ..Capacities::for_bodies(3) });
    ground(&mut world, 0.6);
    let first = world.create_body(&BodyDef::new(BodyKind::Dynamic, Vec3::Z)).expect("room");
    world.create_shape(first, &ShapeDef::new(CUBE)).expect("room");
    let empty = world.checksum();
    let mut stale: Option<BodyHandle> = None;
    for i in 0..1_000_000_u32 {
        let (body, shape) = add(&mut world, &BodyDef::default(), &ShapeDef::new(CUBE));
        if i % 4 == 0 {
            let joint = world.create_joint(&JointDef::ball([first, body], [at(Vec3::ZERO); 2]));
            let joint = joint.expect("room");
            world.remove_joint(joint).expect("lives");
            assert!(matches!(world.remove_joint(joint), Err(Error::Stale { .. })));
        }
        world.remove_body(body).expect("lives");
        assert!(!world.contains_body(body) && !world.contains_shape(shape));
        if let Some(old) = stale.replace(body) {
            assert!(old != body, "handles are not given twice");
            assert_eq!(world.remove_body(old), Err(Error::Stale { what: "body" }));
        }
    }
    run(&mut world, 1);
    assert_eq!(world.body_count(), 2);
    assert!(world.checksum() != empty, "generations are state");
}

#[test]
fn calls_with_stale_handles_change_nothing() {
    for preset in Preset::ALL {
        let mut world = world(4);
        world.set_settings(&Settings::from(preset)).expect("in range");
        ground(&mut world, 0.6);
        let (body, shape) = add(&mut world, &BodyDef::new(BodyKind::Dynamic, Vec3::Z), &ShapeDef::new(CUBE));
        add(&mut world, &BodyDef::new(BodyKind::Dynamic, Vec3::Z * 2.0), &ShapeDef::new(CUBE));
        run(&mut world, 10);
        world.remove_body(body).expect("lives");
        let before = world.checksum();
        let stale =
            |result: Result<(), Error>| assert!(matches!(result, Err(Error::Stale { .. })), "{result:?}");
        stale(world.set_linear_velocity(body, Vec3::X));
        stale(world.set_pose(body, Position::ORIGIN, Rotation::IDENTITY));
        stale(world.apply_impulse(body, Vec3::X));
        stale(world.wake(body));
        stale(world.set_density(shape, 1.0));
        stale(world.remove_shape(shape));
        stale(world.create_joint(&JointDef::ball([body, body], [at(Vec3::ZERO); 2])).map(drop));
        assert_eq!(world.checksum(), before);
    }
}

#[test]
fn hulls_of_any_points_are_taken_or_refused() {
    let mut random = Random::new(11);
    let mut cloud = |count: usize, size: Vec3| -> Vec<Vec3> {
        let mut number = || random.between(-1.0, 1.0);
        (0..count).map(|_| size * Vec3::new(number(), number(), number())).collect()
    };
    let line: Vec<Vec3> = (0..10).map(|i| Vec3::X * i as f32).collect();
    let mut cube = cloud(100_000, Vec3::splat(0.5));
    cube.extend((0..8).map(|i| Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32) - 0.5));
    let cases = [
        ("no points", vec![], false),
        ("one point a hundred times", vec![Vec3::ONE; 100], false),
        ("a line", line, false),
        ("a plane", cloud(50, Vec3::new(1.0, 1.0, 0.0)), false),
        ("not a number", vec![Vec3::NAN; 8], false),
        ("a box of 1 x 1 x 0.01 m", cloud(50, Vec3::new(0.5, 0.5, 0.005)), true),
        ("each point ten times", cloud(20, Vec3::splat(0.5)).repeat(10), true),
        ("1e5 points, of which more than 64 are corners", cloud(100_000, Vec3::splat(0.5)), false),
        ("1e5 points in a cube of 8 corners", cube, true),
    ];
    for (name, points, taken) in cases {
        let mut world = world_with(Capacities { hulls: 1, ..Capacities::for_bodies(4) });
        let before = world.assets_hash();
        match world.add_hull(&points) {
            Ok(hull) => {
                assert!(taken, "{name} makes no hull");
                ground(&mut world, 0.6);
                for level in 0..3_u8 {
                    let def = BodyDef::new(BodyKind::Dynamic, Vec3::Z * (0.6 + 1.2 * f32::from(level)));
                    add(&mut world, &def, &ShapeDef::new(Geometry::Hull(hull)));
                }
                run(&mut world, 200);
                let lives = world.bodies().skip(1).all(|body| {
                    let [_, _, z] = world.center(body).expect("lives").to_f64();
                    z.is_finite() && z > -0.01
                });
                assert!(lives, "{name}: hulls are on the ground");
            }
            Err(error) => {
                assert!(
                    !taken && matches!(error, Error::Hull(_) | Error::NotFinite { .. }),
                    "{name}: {error}"
                );
                assert_eq!(world.assets_hash(), before, "{name}");
            }
        }
    }
}

#[test]
fn meshes_of_any_triangles_are_taken_or_refused() {
    let square = [
        Vec3::new(-5.0, -5.0, 0.0),
        Vec3::new(5.0, -5.0, 0.0),
        Vec3::new(5.0, 5.0, 0.0),
        Vec3::new(-5.0, 5.0, 0.0),
    ];
    let (one, two) = ([0, 1, 2], [0, 2, 3]);
    let mut broken = square;
    broken[2].z = f32::NAN;
    for (name, vertices, triangles, taken) in [
        ("not a number", &broken, vec![one, two], Some(false)),
        ("an index beyond the vertices", &square, vec![one, [0, 2, 9]], Some(false)),
        ("each triangle three times", &square, vec![one, two, one, two, one, two], None),
        ("a triangle without area", &square, vec![one, two, [0, 0, 1], [1, 1, 1]], None),
        ("triangles of both sides", &square, vec![one, two, [2, 1, 0], [3, 2, 0]], None),
    ] {
        for preset in Preset::ALL {
            let capacities = Capacities {
                meshes: 1,
                mesh_vertices: 16,
                mesh_triangles: 16,
                contacts: 200,
                ..Capacities::for_bodies(5)
            };
            let mut world = world_with(capacities);
            world.set_settings(&Settings::from(preset)).expect("in range");
            let before = world.assets_hash();
            match world.add_mesh(vertices, &triangles) {
                Ok(mesh) => {
                    assert_ne!(taken, Some(false), "{name} makes no mesh");
                    let floor = world.create_body(&BodyDef::new(BodyKind::Static, Vec3::ZERO)).expect("room");
                    world.create_shape(floor, &ShapeDef::new(Geometry::Mesh(mesh))).expect("room");
                    for i in 0..4_u8 {
                        let place = Vec3::new(1.5 * f32::from(i) - 2.0, 0.1, 1.0);
                        let shape = ShapeDef::new(kind(u32::from(i)));
                        add(&mut world, &BodyDef::new(BodyKind::Dynamic, place), &shape);
                    }
                    run(&mut world, 120);
                    for body in world.bodies().skip(1) {
                        let [_, _, z] = world.center(body).expect("lives").to_f64();
                        assert!(z > 0.2, "{name}, {}: {body:?} at {z} m", preset.name());
                    }
                }
                Err(error) => {
                    let typed =
                        matches!(error, Error::Mesh(_) | Error::NotFinite { .. } | Error::OutOfRange { .. });
                    assert!(taken != Some(true) && typed, "{name}: {error}");
                    assert_eq!(world.assets_hash(), before, "{name}");
                    let _: Result<u64, ()> = Ok(world.step(&mut Serial).step);
                }
            }
        }
    }
}
