//! The contract at extremes of speed, spin, time, gravity and material, at every preset and for any number of
//! workers.

use cellstep::math::{Rotation, Vec3};
use cellstep::{
    BodyDef, BodyKind, Capacities, Error, Geometry, Position, Preset, Serial, Settings, ShapeDef,
};
use cellstep_tests::executors::Random;
use cellstep_tests::extremes::{Attack, Run};
use cellstep_tests::worlds::{OwnedWorld, add, ground, world};

const CUBE: Geometry = Geometry::Box { half_extents: Vec3::splat(0.5) };

fn set(world: &mut OwnedWorld, change: impl FnOnce(&mut Settings)) {
    let mut settings = world.settings();
    change(&mut settings);
    world.set_settings(&settings).expect("in range");
}

/// Twelve bodies of four kinds on the ground and on each other.
fn heap(world: &mut OwnedWorld, (friction, restitution): (f32, f32)) {
    ground(world, friction);
    let mut random = Random::new(3);
    for i in 0..12_u8 {
        let geometry = match i % 4 {
            0 => Geometry::Sphere { radius: 0.4 },
            1 => CUBE,
            2 => Geometry::Capsule { half_height: 0.4, radius: 0.3 },
            _ => Geometry::Cylinder { half_height: 0.3, radius: 0.5 },
        };
        let turn = Vec3::new(random.between(-1.0, 1.0), random.between(-1.0, 1.0), 0.0);
        let place = Vec3::new(0.9 * f32::from(i % 2), 0.3 * f32::from(i % 3), 1.0 + 1.6 * f32::from(i));
        let def = BodyDef {
            rotation: Rotation::from_rotation_vector(turn),
            ..BodyDef::new(BodyKind::Dynamic, place)
        };
        add(world, &def, &ShapeDef { friction, restitution, ..ShapeDef::new(geometry) });
    }
}

/// The heap at ordinary values.
fn ordinary() -> [Run; Preset::ALL.len()] {
    let build = |world: &mut OwnedWorld| heap(world, (0.6, 0.0));
    Attack::new("heap", 13, &build).check()
}

/// A room with walls of 1 cm.
fn room(world: &mut OwnedWorld) {
    for (axis, side) in (0..6).map(|i| (i / 2, [-1.0, 1.0][i % 2])) {
        let (mut place, mut half) = (Vec3::ZERO, Vec3::splat(3.0));
        (place[axis], half[axis]) = (side * 3.0, 0.005);
        let wall = world.create_body(&BodyDef::new(BodyKind::Static, place)).expect("room");
        world.create_shape(wall, &ShapeDef::new(Geometry::Box { half_extents: half })).expect("room");
    }
}

#[test]
fn fast_bodies_stay_behind_thin_walls() {
    for restitution in [0.0, 0.5] {
        let attack = |speed: f32| {
            let build = move |world: &mut OwnedWorld| {
                room(world);
                set(world, |settings| settings.gravity = Vec3::ZERO);
                let mut random = Random::new(5);
                for i in 0..9_u8 {
                    let mut number = || random.between(-1.0, 1.0);
                    let way = Vec3::new(number(), number(), number());
                    let geometry = match i % 3 {
                        0 => Geometry::Sphere { radius: 0.1 },
                        1 => Geometry::Box { half_extents: Vec3::new(0.2, 0.1, 0.15) },
                        _ => Geometry::Capsule { half_height: 0.1, radius: 0.1 },
                    };
                    let cell = Vec3::new(f32::from(i % 3), f32::from(i / 3), 0.0);
                    let def = BodyDef {
                        linear_velocity: way * (speed / cellstep::math::length(way)),
                        ..BodyDef::new(BodyKind::Dynamic, cell - Vec3::new(1.0, 1.0, 0.0))
                    };
                    add(world, &def, &ShapeDef { restitution, ..ShapeDef::new(geometry) });
                }
            };
            let act = |world: &mut OwnedWorld, _: u32| {
                let far = world.bodies().filter(|&body| world.kind(body) == Ok(BodyKind::Dynamic));
                for body in far {
                    let p = world.center(body).expect("lives").to_f64();
                    assert!(p.iter().all(|x| x.abs() < 3.0), "{body:?} is out at {p:?}");
                }
            };
            let name = format!("nine at {speed} m/s in a room, e={restitution}");
            Attack { act: &act, ..Attack::new(&name, 16, &build) }.check()
        };
        let ordinary = attack(10.0);
        for speed in [1.0e2, 1.0e3, 1.0e4, 1.0e5] {
            let runs = attack(speed);
            for (run, other) in runs.iter().zip(&ordinary) {
                assert!(run.cost <= 10 * other.cost, "{} of work beside {}", run.cost, other.cost);
            }
        }
    }
}

#[test]
fn spinning_bodies_on_the_ground_keep_the_contract() {
    for (name, geometry) in [
        ("ball", Geometry::Sphere { radius: 0.5 }),
        ("box", Geometry::Box { half_extents: Vec3::new(0.5, 0.4, 0.3) }),
        ("rod", Geometry::Capsule { half_height: 0.5, radius: 0.05 }),
        ("coin", Geometry::Cylinder { half_height: 0.02, radius: 0.3 }),
    ] {
        for speed in [1.0, 1.0e2, 1.0e3, 1.0e4] {
            let build = |world: &mut OwnedWorld| {
                ground(world, 0.6);
                let def = BodyDef {
                    angular_velocity: Vec3::new(0.3, 0.9, 0.3) * speed,
                    ..BodyDef::new(BodyKind::Dynamic, Vec3::Z * 1.2)
                };
                add(world, &def, &ShapeDef::new(geometry));
            };
            let slack = if speed < 1.0e2 { 1.0e-3 } else { 5.0e-2 };
            Attack { slack, ..Attack::new(&format!("{name} at {speed} rad/s"), 2, &build) }.check();
        }
    }
}

#[test]
fn any_length_of_step_keeps_the_contract() {
    let ordinary = ordinary();
    for dt in [0.0, 1.0e-5, 1.0e-3, 1.0 / 30.0, 0.1] {
        let build = |world: &mut OwnedWorld| {
            heap(world, (0.6, 0.0));
            set(world, |settings| settings.dt = dt);
        };
        // Bodies that come by a metre in a step touch when they are deep in each other.
        let push_out = if dt > 0.05 { 3.0 } else { 0.0 };
        Attack { push_out, ..Attack::new(&format!("dt {dt} s"), 13, &build) }.check_beside(&ordinary);
    }
    let build = |world: &mut OwnedWorld| heap(world, (0.6, 0.0));
    let act = |world: &mut OwnedWorld, step: u32| {
        let dt = [1.0 / 60.0, 1.0e-4, 0.05, 0.0, 1.0 / 240.0][step as usize % 5];
        set(world, |settings| settings.dt = dt);
    };
    Attack { act: &act, push_out: 1.0, ..Attack::new("dt that alternates", 13, &build) }
        .check_beside(&ordinary);
}

#[test]
fn a_step_of_no_length_changes_nothing_but_the_count() {
    for preset in Preset::ALL {
        let mut world = world(13);
        world.set_settings(&Settings { dt: 0.0, ..Settings::from(preset) }).expect("in range");
        heap(&mut world, (0.6, 0.5));
        let bodies: Vec<_> = world.bodies().collect();
        let places = |world: &OwnedWorld| {
            bodies
                .iter()
                .map(|&body| {
                    (world.position(body), world.linear_velocity(body), world.angular_velocity(body))
                })
                .collect::<Vec<_>>()
        };
        let before = places(&world);
        for step in 1..=5 {
            assert_eq!(world.step(&mut Serial).step, step);
        }
        assert_eq!(places(&world), before);
    }
}

#[test]
fn any_gravity_keeps_the_contract() {
    let ordinary = ordinary();
    for gravity in
        [Vec3::ZERO, -Vec3::Z * 100.0, -Vec3::Z * 1.0e4, Vec3::new(9.81, 0.0, -1.0), Vec3::Z * 9.81]
    {
        let build = |world: &mut OwnedWorld| {
            heap(world, (0.6, 0.0));
            set(world, |settings| settings.gravity = gravity);
        };
        // At 1e4 m/s2 bodies gain 170 m/s in a step, and meet deep in each other: what lifts them out of that has
        // their weight to lift, which is most of the energy there is.
        let driven = gravity.z < -1.0e3;
        Attack { driven, ..Attack::new(&format!("gravity {gravity:?}"), 13, &build) }.check_beside(&ordinary);
    }
    let build = |world: &mut OwnedWorld| heap(world, (0.6, 0.0));
    for strength in [9.81, 1000.0] {
        let act = |world: &mut OwnedWorld, step: u32| {
            let way = [-Vec3::Z, Vec3::X, Vec3::Z, -Vec3::Y][step as usize / 10 % 4];
            set(world, |settings| settings.gravity = way * strength);
        };
        let name = format!("gravity of {strength} m/s2 that flips");
        Attack { act: &act, ..Attack::new(&name, 13, &build) }.check_beside(&ordinary);
    }
}

#[test]
fn any_material_keeps_the_contract() {
    let ordinary = ordinary();
    for friction in [0.0, 1.0, 100.0, 1.0e6] {
        for restitution in [0.0, 0.5, 1.0] {
            let build = |world: &mut OwnedWorld| heap(world, (friction, restitution));
            let name = format!("friction {friction}, restitution {restitution}");
            // Of blows that come at several points at once, each gives its full speed back.
            let slack = if restitution == 1.0 { 0.1 } else { 1.0e-3 };
            Attack { slack, ..Attack::new(&name, 13, &build) }.check_beside(&ordinary);
        }
    }
}

#[test]
fn denormal_velocities_keep_the_contract_and_fade() {
    let ordinary = ordinary();
    for size in [f32::MIN_POSITIVE, 1.0e-42, 1.0e-30, 1.0e-18] {
        let build = |world: &mut OwnedWorld| {
            heap(world, (0.6, 0.0));
            set(world, |settings| settings.gravity = Vec3::ZERO);
            let bodies: Vec<_> = world.bodies().skip(1).collect();
            for body in bodies {
                world.set_linear_velocity(body, Vec3::splat(size)).expect("dynamic");
                world.set_angular_velocity(body, Vec3::splat(-size)).expect("dynamic");
            }
        };
        Attack::new(&format!("velocities of {size:e}"), 13, &build).check_beside(&ordinary);
    }
}

#[test]
fn motion_far_away_keeps_the_contract() {
    let ordinary = ordinary();
    for kilometres in [1.0, 1.0e3, 1.0e4] {
        let build = |world: &mut OwnedWorld| {
            heap(world, (0.6, 0.0));
            let bodies: Vec<_> = world.bodies().collect();
            for body in bodies {
                let [x, y, z] = world.position(body).expect("lives").to_f64();
                // A whole number of sectors: the ground is where it was for them.
                let away = 64.0 * (kilometres * 1000.0_f64 / 64.0).round();
                let place = Position::from_f64([x + away, y - away, z]);
                let rotation = world.rotation(body).expect("lives");
                world.set_pose(body, place, rotation).expect("in range");
            }
        };
        Attack::new(&format!("{kilometres} km away"), 13, &build).check_beside(&ordinary);
    }
}

#[test]
fn numbers_outside_their_ranges_are_refused_and_change_nothing() {
    for preset in Preset::ALL {
        let mut world = cellstep_tests::worlds::world_with(Capacities::for_bodies(13));
        world.set_settings(&Settings::from(preset)).expect("in range");
        heap(&mut world, (0.6, 0.0));
        world.step(&mut Serial);
        let before = world.checksum();
        let good = world.settings();
        let body = world.bodies().nth(1).expect("a body");
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -1.0, f32::MAX] {
            for settings in [
                Settings { dt: bad, ..good },
                Settings { contact_frequency: bad, ..good },
                Settings { contact_damping_ratio: bad, ..good },
                Settings { push_speed: bad, ..good },
                Settings { restitution_threshold: bad, ..good },
            ] {
                let refused = world.set_settings(&settings).expect_err("out of range");
                assert!(matches!(refused, Error::NotFinite { .. } | Error::OutOfRange { .. }), "{refused}");
            }
            for def in [
                ShapeDef { friction: bad, ..ShapeDef::new(CUBE) },
                ShapeDef { restitution: bad, ..ShapeDef::new(CUBE) },
                ShapeDef { density: bad, ..ShapeDef::new(CUBE) },
                ShapeDef::new(Geometry::Sphere { radius: bad }),
                ShapeDef::new(Geometry::Box { half_extents: Vec3::new(1.0, bad, 1.0) }),
                ShapeDef::new(Geometry::Capsule { half_height: bad, radius: 1.0 }),
            ] {
                let refused = world.create_shape(body, &def).expect_err("out of range");
                assert!(matches!(refused, Error::NotFinite { .. } | Error::OutOfRange { .. }), "{refused}");
            }
        }
        for def in [
            ShapeDef { restitution: 1.001, ..ShapeDef::new(CUBE) },
            ShapeDef::new(Geometry::Sphere { radius: 0.0 }),
            ShapeDef::new(Geometry::Box { half_extents: Vec3::ZERO }),
        ] {
            assert!(matches!(world.create_shape(body, &def), Err(Error::OutOfRange { .. })));
        }
        assert_eq!(world.checksum(), before);
    }
}
