//! Walls that move, bodies that hit each other, and scenes that pay nothing.

use crate::shots::energy;
use cellstep::math::{Rotation, Vec3};
use cellstep::scene::builtin::Builtin;
use cellstep::{
    AxisLocks, BodyDef, BodyHandle, BodyKind, Capacities, Geometry, Position, Serial, Settings, ShapeDef,
};
use cellstep_tests::executors::Random;
use cellstep_tests::oracles::{center, norm, velocity};
use cellstep_tests::worlds::{OwnedWorld, add, ground, run, world, world_with};

const BALL: Geometry = Geometry::Sphere { radius: 0.005 };

fn weightless(bodies: u32) -> OwnedWorld {
    let mut world = world(bodies);
    let settings = Settings { gravity: Vec3::ZERO, ..world.settings() };
    world.set_settings(&settings).expect("in range");
    world
}

/// A body with a shape at a place with a velocity.
fn put(
    world: &mut OwnedWorld,
    geometry: Geometry,
    (kind, place, linear_velocity): (BodyKind, Vec3, Vec3),
) -> BodyHandle {
    let def = BodyDef { linear_velocity, ..BodyDef::new(kind, place) };
    add(world, &def, &ShapeDef::new(geometry)).0
}

fn panel() -> Geometry {
    Geometry::Box { half_extents: Vec3::new(0.005, 2.0, 2.0) }
}

#[test]
fn a_moving_wall_is_not_passed() {
    let mut random = Random::new(5);
    for _ in 0..100 {
        let mut world = weightless(4);
        let (fast, wall_speed) = (random.between(50.0, 1000.0), random.between(-60.0, 60.0));
        let wall_way = Vec3::new(wall_speed, 0.0, 0.0);
        let wall = put(&mut world, panel(), (BodyKind::Kinematic, Vec3::ZERO, wall_way));
        let place = Vec3::new(random.between(-9.0, -1.5), random.between(-0.5, 0.5), 0.0);
        let ball = put(&mut world, BALL, (BodyKind::Dynamic, place, Vec3::new(fast, 0.0, 0.0)));
        let mut hit = false;
        for _ in 0..30 {
            world.step(&mut Serial);
            hit |= velocity(&world, ball)[0] < f64::from(fast) - 1.0;
            let (x, at) = (center(&world, ball)[0], center(&world, wall)[0]);
            assert!(x < at, "a ball of {fast} m/s is {} m behind a wall of {wall_speed} m/s", x - at);
        }
        assert!(hit || wall_speed > 0.0, "the ball came to the wall");
    }
}

#[test]
fn a_spinning_blade_does_not_pass_a_wall() {
    // A blade of 1 m and 1 cm that flies and spins is stopped at a wall, whatever its phase.
    for phase in 0..60 {
        let mut world = weightless(4);
        put(&mut world, panel(), (BodyKind::Static, Vec3::ZERO, Vec3::ZERO));
        let def = BodyDef {
            position: Position::at(Vec3::new(-0.9, 0.0, 0.0)),
            rotation: Rotation::from_axis_angle(Vec3::Z, 0.1 * phase as f32),
            linear_velocity: Vec3::new(40.0, 0.0, 0.0),
            angular_velocity: Vec3::new(0.0, 0.0, 100.0),
            ..BodyDef::default()
        };
        let blade = Geometry::Box { half_extents: Vec3::new(0.5, 0.005, 0.05) };
        let (body, _) = add(&mut world, &def, &ShapeDef::new(blade));
        for _ in 0..30 {
            world.step(&mut Serial);
            let [x, y, _] = center(&world, body);
            // Farther out it may fly past the wall's end.
            if y.abs() > 1.4 {
                break;
            }
            assert!(x < 0.0, "the blade passed, phase {phase}");
        }
    }
}

#[test]
fn a_body_that_is_struck_does_not_pass_a_wall() {
    // The ball rests in front of the wall: it is fast only within the step in which it is struck.
    let mut random = Random::new(6);
    for _ in 0..100 {
        let mut world = weightless(4);
        put(&mut world, panel(), (BodyKind::Static, Vec3::ZERO, Vec3::ZERO));
        let gap = random.between(0.02, 0.5);
        let ball = put(&mut world, BALL, (BodyKind::Dynamic, Vec3::new(-gap, 0.0, 0.0), Vec3::ZERO));
        let speed = random.between(20.0, 300.0);
        let hammer = Geometry::Box { half_extents: Vec3::splat(0.1) };
        let from = Vec3::new(-gap - 0.2 - random.between(0.0, 0.5), 0.0, 0.0);
        put(&mut world, hammer, (BodyKind::Dynamic, from, Vec3::new(speed, 0.0, 0.0)));
        for step in 0..20 {
            world.step(&mut Serial);
            let x = center(&world, ball)[0];
            assert!(x < 0.0, "struck at {speed} m/s the ball is at {x} in step {step}");
        }
        assert!(norm(velocity(&world, ball)) > 0.0, "the ball was struck");
    }
}

#[test]
fn a_bullet_does_not_pass_a_dynamic_panel() {
    let (mut random, mut passed) = (Random::new(8), [0; 2]);
    for shot in 0..200 {
        let bullet = shot % 2 == 0;
        let mut world = weightless(4);
        // A panel that turns: what stood elsewhere when the step began.
        let def = BodyDef { angular_velocity: Vec3::new(0.0, 3.0, 0.0), ..BodyDef::default() };
        let heavy = ShapeDef { density: 1.0e5, ..ShapeDef::new(panel()) };
        let (wall, _) = add(&mut world, &def, &heavy);
        let place = Vec3::new(-random.between(0.3, 3.0), random.between(-0.5, 0.5), 0.0);
        let speed = random.between(100.0, 1000.0);
        let rod = Geometry::Box { half_extents: Vec3::new(0.2, 0.005, 0.005) };
        let def = BodyDef {
            linear_velocity: Vec3::new(speed, 0.0, 0.0),
            angular_velocity: Vec3::new(0.0, 0.0, 90.0),
            bullet,
            ..BodyDef::new(BodyKind::Dynamic, place)
        };
        let (body, _) = add(&mut world, &def, &ShapeDef::new(rod));
        run(&mut world, 3);
        let side = center(&world, body)[0] - center(&world, wall)[0];
        passed[usize::from(bullet)] += usize::from(side > 0.0);
    }
    println!("passed a dynamic panel: {} without the flag, {} with it", passed[0], passed[1]);
    assert_eq!(passed[1], 0, "bullets passed");
    assert!(passed[0] > 10, "the test attacks: {} passed without the flag", passed[0]);
}

#[test]
fn a_bullet_does_not_pass_what_is_thrown_into_its_way() {
    // A panel that rests is struck, and comes to stand metres off in the same step. The bullet would not have come
    // to where it was.
    let (mut random, mut passed, mut thrown) = (Random::new(21), [0; 2], 0);
    for shot in 0..200 {
        let bullet = shot % 2 == 0;
        let mut world = weightless(4);
        let (wall, _) = add(&mut world, &BodyDef::default(), &ShapeDef::new(panel()));
        let hammer = ShapeDef { density: 1.0e5, ..ShapeDef::new(Geometry::Box { half_extents: Vec3::ONE }) };
        let blow = random.between(150.0, 250.0);
        let def = BodyDef {
            linear_velocity: Vec3::new(blow, 0.0, 0.0),
            ..BodyDef::new(BodyKind::Dynamic, Vec3::new(-1.0 - random.between(0.02, 0.3), 0.0, 0.0))
        };
        add(&mut world, &def, &hammer);
        let start = Vec3::new(random.between(4.0, 8.0), random.between(1.2, 1.8), 0.0);
        let speed = (start.x - random.between(0.3, 1.5)) * 60.0;
        let def = BodyDef {
            linear_velocity: Vec3::new(-speed, 0.0, 0.0),
            bullet,
            ..BodyDef::new(BodyKind::Dynamic, start)
        };
        let (body, _) = add(&mut world, &def, &ShapeDef::new(BALL));
        world.step(&mut Serial);
        thrown += usize::from(center(&world, wall)[0] > 1.6);
        passed[usize::from(bullet)] += usize::from(center(&world, body)[0] < center(&world, wall)[0]);
    }
    println!("passed a panel that was thrown: {} without the flag, {} with it", passed[0], passed[1]);
    assert_eq!(passed[1], 0, "bullets passed");
    assert!(passed[0] > 50 && thrown > 150, "the test attacks: {} passed, {thrown} were thrown", passed[0]);
}

#[test]
fn the_flag_can_be_set() {
    let mut world = weightless(2);
    let body = world.create_body(&BodyDef { bullet: true, ..BodyDef::default() }).expect("room");
    let other = world.create_body(&BodyDef::default()).expect("room");
    assert_eq!((world.is_bullet(body), world.is_bullet(other)), (Ok(true), Ok(false)));
    world.set_bullet(body, false).expect("exists");
    world.set_bullet(other, true).expect("exists");
    assert_eq!((world.is_bullet(body), world.is_bullet(other)), (Ok(false), Ok(true)));
}

#[test]
fn grazing_impacts_gain_nothing() {
    let (mut random, mut worst) = (Random::new(12), 0.0_f64);
    let shapes = [
        (Geometry::Sphere { radius: 0.1 }, 0.1),
        (Geometry::Box { half_extents: Vec3::new(0.2, 0.1, 0.1) }, 0.25),
        (Geometry::Capsule { half_height: 0.3, radius: 0.05 }, 0.35),
    ];
    for shot in 0..300 {
        let (geometry, reach) = shapes[shot % 3];
        let mut world = weightless(2);
        ground(&mut world, [0.0, 0.6][shot % 2]);
        let speed = random.between(100.0, 1000.0);
        let slope = random.between(0.01, 0.15);
        let def = BodyDef {
            position: Position::at(Vec3::new(0.0, 0.0, reach + random.between(0.1, 1.0))),
            rotation: Rotation::from_rotation_vector(Vec3::splat(random.between(-2.0, 2.0))),
            linear_velocity: Vec3::new(speed, 0.0, -slope * speed),
            ..BodyDef::default()
        };
        let restitution = [0.0, 0.5, 1.0][shot / 3 % 3];
        let (body, _) = add(&mut world, &def, &ShapeDef { restitution, ..ShapeDef::new(geometry) });
        let before = energy(&world, body);
        for _ in 0..20 {
            world.step(&mut Serial);
            worst = worst.max(energy(&world, body) / before - 1.0);
        }
    }
    println!("grazing impacts gain {worst:.1e} of their energy");
    assert!(worst < 0.001, "{worst}");
}

#[test]
fn locked_axes_stay_locked() {
    let mut world = weightless(4);
    put(&mut world, panel(), (BodyKind::Static, Vec3::ZERO, Vec3::ZERO));
    let def = BodyDef {
        linear_velocity: Vec3::new(700.0, 20.0, 0.0),
        angular_velocity: Vec3::new(0.0, 0.0, 60.0),
        locks: AxisLocks::MOVE_Z.and(AxisLocks::TURN_X).and(AxisLocks::TURN_Y),
        ..BodyDef::new(BodyKind::Dynamic, Vec3::new(-3.0, 0.0, 0.125))
    };
    let rod = Geometry::Box { half_extents: Vec3::new(0.2, 0.005, 0.005) };
    let (body, _) = add(&mut world, &def, &ShapeDef::new(rod));
    let mut cut = 0;
    for _ in 0..30 {
        cut += world.step(&mut Serial).cut;
        assert_eq!(center(&world, body)[2], 0.125);
        let rotation = world.rotation(body).expect("exists");
        assert!(rotation.x.abs() < 1.0e-6 && rotation.y.abs() < 1.0e-6, "{rotation:?}");
    }
    assert!(cut > 0, "the rod was stopped");
    assert!(center(&world, body)[0] < 0.0);
}

#[test]
fn slow_scenes_are_the_same_without() {
    for name in ["pyramid", "tower", "wall", "stacked_pyramid"] {
        let builtin = Builtin::find(name).expect("built in");
        let scene = builtin.scene(builtin.golden_size).expect("golden size");
        let play = |continuous: bool| {
            let mut world = scene.build(std::path::Path::new(".")).expect("builds").world;
            let settings = Settings { continuous, ..world.settings() };
            world.set_settings(&settings).expect("in range");
            let cut: u32 = (0..120).map(|_| world.step(&mut Serial).cut).sum();
            assert_eq!(cut, 0, "{name}");
            let sums: Vec<u64> =
                world.bodies().map(|body| world.body_checksum(body).expect("exists")).collect();
            sums
        };
        assert_eq!(play(true), play(false), "{name}");
    }
}

#[test]
fn what_rolls_and_slides_is_not_stopped() {
    // Fast for their size, and on the ground all the time.
    let mut world = world_with(Capacities { hulls: 1, ..Capacities::for_bodies(8) });
    ground(&mut world, 0.5);
    let wheel = Geometry::Cylinder { half_height: 0.02, radius: 0.1 };
    // Slender ones, whose ends are thin.
    let corner = |i: u32| {
        let side = |bit: u32| if bit == 0 { -1.0 } else { 1.0 };
        Vec3::new(0.3 * side(i & 1), 0.05 * side(i & 2), 0.02 * side(i & 4))
    };
    let brick = world.add_hull(&[0, 1, 2, 3, 4, 5, 6, 7].map(corner)).expect("a hull");
    let shapes = [
        (Geometry::Sphere { radius: 0.02 }, 0.02, Rotation::IDENTITY),
        (Geometry::Box { half_extents: Vec3::splat(0.02) }, 0.02, Rotation::IDENTITY),
        (wheel, 0.1, Rotation::from_axis_angle(Vec3::X, core::f32::consts::FRAC_PI_2)),
        (Geometry::Box { half_extents: Vec3::new(0.3, 0.05, 0.02) }, 0.02, Rotation::IDENTITY),
        (Geometry::Hull(brick), 0.02, Rotation::IDENTITY),
        (Geometry::Cone { half_height: 0.02, radius: 0.2 }, 0.02, Rotation::IDENTITY),
    ];
    let speed = 20.0;
    let mut place = 0.0;
    let bodies = shapes.map(|(geometry, height, rotation)| {
        place += 1.0;
        let rolls = matches!(geometry, Geometry::Sphere { .. } | Geometry::Cylinder { .. });
        let spin = if rolls { speed / height } else { 0.0 };
        let def = BodyDef {
            rotation,
            linear_velocity: Vec3::new(speed, 0.0, 0.0),
            angular_velocity: Vec3::new(0.0, spin, 0.0),
            ..BodyDef::new(BodyKind::Dynamic, Vec3::new(0.0, place, height))
        };
        add(&mut world, &def, &ShapeDef::new(geometry)).0
    });
    let mut cut = 0;
    for _ in 0..30 {
        cut += world.step(&mut Serial).cut;
    }
    assert_eq!(cut, 0, "stopped on the ground");
    let ways = bodies.map(|body| center(&world, body)[0]);
    assert!(ways[0] > 9.8 && ways[2] > 9.8, "{ways:?}");
    assert!([1, 3, 4, 5].iter().all(|&i| ways[i] > 8.0), "{ways:?}");
}
