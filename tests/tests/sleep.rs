//! Sleep: what falls asleep, what wakes, and that neither depends on anything but the state.

use cellstep::math::{Pose, Rotation, Vec3};
use cellstep::{
    BodyDef, BodyHandle, BodyKind, Capacities, Geometry, JointDef, Pool, Position, Serial, Settings, ShapeDef,
};
use cellstep_tests::executors::Shuffled;
use cellstep_tests::worlds::{OwnedWorld, add, ground, run, world_with};

/// Steps of 1/60 s after which what has come to rest is asleep.
const SOON: u32 = 240;

fn sleepy(bodies: u32) -> OwnedWorld {
    let mut world = world_with(Capacities { joints: 16, ..Capacities::for_bodies(bodies) });
    let settings = Settings { sleep_time: 0.5, ..world.settings() };
    world.set_settings(&settings).expect("in range");
    ground(&mut world, 0.6);
    world
}

fn cube() -> ShapeDef {
    ShapeDef::new(Geometry::Box { half_extents: Vec3::splat(0.5) })
}

fn box_at(world: &mut OwnedWorld, x: f32, y: f32, z: f32) -> BodyHandle {
    add(world, &BodyDef::new(BodyKind::Dynamic, Vec3::new(x, y, z)), &cube()).0
}

/// A tower of `height` boxes at x.
fn tower(world: &mut OwnedWorld, x: f32, height: u32) -> Vec<BodyHandle> {
    (0..height).map(|i| box_at(world, x, 0.0, 0.5 + i as f32)).collect()
}

fn asleep(world: &OwnedWorld, bodies: &[BodyHandle]) -> usize {
    bodies.iter().filter(|&&body| world.is_asleep(body).expect("exists")).count()
}

#[test]
fn what_rests_falls_asleep_and_costs_no_solve() {
    let mut world = sleepy(16);
    let tower = tower(&mut world, 0.0, 5);
    run(&mut world, SOON);
    assert_eq!(asleep(&world, &tower), 5);
    let report = world.step(&mut Serial);
    assert_eq!((report.active, report.asleep, report.contacts, report.pairs), (0, 5, 0, 0));
    for &body in &tower {
        assert_eq!(world.linear_velocity(body), Ok(Vec3::ZERO));
        assert_eq!(world.angular_velocity(body), Ok(Vec3::ZERO));
    }
    let before = world.checksum();
    run(&mut world, 60);
    let places: Vec<_> = tower.iter().map(|&body| world.center(body).expect("exists").to_f64()[2]).collect();
    assert!(places.iter().enumerate().all(|(i, z)| (z - (0.5 + i as f64)).abs() < 0.01), "{places:?}");
    // Only the count of steps goes on.
    assert_ne!(before, world.checksum());
}

#[test]
fn nothing_sleeps_unless_the_settings_say_so() {
    let mut world = sleepy(16);
    let settings = Settings { sleep_time: 0.0, ..world.settings() };
    world.set_settings(&settings).expect("in range");
    let tower = tower(&mut world, 0.0, 3);
    run(&mut world, 2 * SOON);
    assert_eq!(asleep(&world, &tower), 0);
}

#[test]
fn islands_sleep_and_wake_each_for_itself() {
    let mut world = sleepy(32);
    let (left, right) = (tower(&mut world, 0.0, 4), tower(&mut world, 10.0, 4));
    run(&mut world, SOON);
    assert_eq!(asleep(&world, &left) + asleep(&world, &right), 8);
    let heights = |world: &OwnedWorld| -> Vec<f64> {
        left.iter().map(|&body| world.center(body).expect("exists").to_f64()[2]).collect()
    };
    let before = heights(&world);
    world.wake(left[0]).expect("exists");
    world.step(&mut Serial);
    let moved = heights(&world).iter().zip(&before).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(moved < 1.0e-4, "its contacts wake with it: moved by {moved} m");
    assert_eq!((asleep(&world, &left), asleep(&world, &right)), (0, 4), "a call wakes the whole island");
    run(&mut world, SOON);
    assert_eq!(asleep(&world, &left), 4);
}

#[test]
fn a_body_that_may_not_sleep_keeps_its_island_awake() {
    let mut world = sleepy(16);
    let (first, second) = (tower(&mut world, 0.0, 3), tower(&mut world, 5.0, 3));
    world.set_can_sleep(first[2], false).expect("exists");
    run(&mut world, SOON);
    assert_eq!((asleep(&world, &first), asleep(&world, &second)), (0, 3));
    world.set_can_sleep(first[2], true).expect("exists");
    run(&mut world, SOON);
    assert_eq!(asleep(&world, &first), 3);
}

/// Momentum that a ball brings goes into what it hits, asleep or not.
#[test]
fn a_blow_wakes_in_the_step_in_which_it_strikes() {
    let strike = |sleeps: bool| {
        let mut world = sleepy(16);
        let row: Vec<_> = (0..4).map(|i| box_at(&mut world, i as f32, 0.0, 0.5)).collect();
        if !sleeps {
            let settings = Settings { sleep_time: 0.0, ..world.settings() };
            world.set_settings(&settings).expect("in range");
        }
        run(&mut world, SOON);
        assert_eq!(asleep(&world, &row), if sleeps { 4 } else { 0 });
        let mut def = BodyDef::new(BodyKind::Dynamic, Vec3::new(-4.0, 0.0, 0.6));
        def.linear_velocity = Vec3::new(20.0, 0.0, 0.0);
        def.gravity_scale = 0.0;
        let sphere = ShapeDef { friction: 0.0, ..ShapeDef::new(Geometry::Sphere { radius: 0.4 }) };
        let (ball, _) = add(&mut world, &def, &sphere);
        let mut woke = None;
        for step in 0..60 {
            world.step(&mut Serial);
            if asleep(&world, &row) == 0 && woke.is_none() {
                woke = Some(step);
            }
        }
        assert!(woke.is_some(), "the blow wakes the row");
        let pushed: f32 =
            row.iter().map(|&body| world.center(body).expect("exists").to_f64()[0] as f32).sum();
        (world.linear_velocity(ball).expect("exists").x, pushed)
    };
    let ((slept, way), (waked, other_way)) = (strike(true), strike(false));
    assert!((slept - waked).abs() < 0.2, "{slept} {waked}");
    assert!((way - other_way).abs() < 0.2, "{way} {other_way}");
}

#[test]
fn what_loses_its_support_wakes() {
    for case in 0..3 {
        let mut world = sleepy(16);
        let shelf =
            world.create_body(&BodyDef::new(BodyKind::Static, Vec3::new(0.0, 0.0, 2.0))).expect("room");
        let plank = ShapeDef::new(Geometry::Box { half_extents: Vec3::new(2.0, 2.0, 0.1) });
        let plank = world.create_shape(shelf, &plank).expect("room");
        let body = box_at(&mut world, 0.0, 0.0, 2.6);
        run(&mut world, SOON);
        assert_eq!(asleep(&world, &[body]), 1);
        match case {
            0 => world.remove_body(shelf).expect("exists"),
            1 => world.remove_shape(plank).expect("exists"),
            _ => {
                let away = Position::at(Vec3::new(50.0, 0.0, 2.0));
                world.set_pose(shelf, away, Rotation::IDENTITY).expect("exists");
            }
        }
        run(&mut world, 30);
        let z = world.center(body).expect("exists").to_f64()[2];
        assert!(z < 1.7, "case {case}: {z}");
        run(&mut world, SOON);
        assert_eq!(asleep(&world, &[body]), 1, "case {case}");
    }
}

#[test]
fn removing_a_sleeper_wakes_what_it_carried() {
    let mut world = sleepy(16);
    let tower = tower(&mut world, 0.0, 4);
    run(&mut world, SOON);
    world.remove_body(tower[0]).expect("exists");
    run(&mut world, 60);
    let z = world.center(tower[3]).expect("exists").to_f64()[2];
    assert!((z - 2.5).abs() < 0.05, "{z}");
}

#[test]
fn gravity_wakes_all() {
    let mut world = sleepy(16);
    let tower = tower(&mut world, 0.0, 2);
    run(&mut world, SOON);
    let settings = Settings { gravity: Vec3::new(0.0, 0.0, 5.0), ..world.settings() };
    world.set_settings(&settings).expect("in range");
    run(&mut world, 30);
    assert_eq!(asleep(&world, &tower), 0);
    assert!(world.center(tower[0]).expect("exists").to_f64()[2] > 0.8);
}

#[test]
fn joints_tie_islands_and_wake_them() {
    let mut world = sleepy(16);
    let (a, b) = (box_at(&mut world, 0.0, 0.0, 0.5), box_at(&mut world, 3.0, 0.0, 0.5));
    run(&mut world, SOON);
    assert_eq!(asleep(&world, &[a, b]), 2);
    let at = |x: f32| Pose::new(Vec3::new(x, 0.0, 0.0), Rotation::IDENTITY);
    world.create_joint(&JointDef::fixed([a, b], [at(1.5), at(-1.5)])).expect("room");
    world.step(&mut Serial);
    assert_eq!(asleep(&world, &[a, b]), 0, "a new joint wakes");
    run(&mut world, SOON);
    assert_eq!(asleep(&world, &[a, b]), 2);
    world.apply_impulse(a, Vec3::new(0.0, 0.0, 10.0)).expect("dynamic");
    world.step(&mut Serial);
    assert_eq!(asleep(&world, &[a, b]), 0, "the joint carries the call over");
}

#[test]
fn a_moving_platform_keeps_awake_and_wakes() {
    let mut world = sleepy(16);
    let platform =
        world.create_body(&BodyDef::new(BodyKind::Kinematic, Vec3::new(0.0, 0.0, 1.0))).expect("room");
    let plank = ShapeDef::new(Geometry::Box { half_extents: Vec3::new(4.0, 4.0, 0.1) });
    world.create_shape(platform, &plank).expect("room");
    let body = box_at(&mut world, 0.0, 0.0, 1.6);
    run(&mut world, SOON);
    assert_eq!(asleep(&world, &[body]), 1);
    world.set_linear_velocity(platform, Vec3::new(0.01, 0.0, 0.0)).expect("kinematic");
    run(&mut world, SOON);
    assert_eq!(asleep(&world, &[body]), 0, "slow, but moved");
    let x = world.center(body).expect("exists").to_f64()[0];
    assert!((x - 0.04).abs() < 0.002, "{x}");
    world.set_linear_velocity(platform, Vec3::ZERO).expect("kinematic");
    run(&mut world, SOON);
    assert_eq!(asleep(&world, &[body]), 1);
}

/// A scene in which islands fall asleep and wake all the time.
fn restless(world: &mut OwnedWorld, step: u32) {
    if step % 97 == 13 {
        let mut def = BodyDef::new(BodyKind::Dynamic, Vec3::new((step % 5) as f32 * 3.0 + 0.2, 0.3, 7.0));
        def.linear_velocity = Vec3::new(0.0, 0.0, -6.0);
        add(world, &def, &ShapeDef::new(Geometry::Sphere { radius: 0.4 }));
    }
    if step % 131 == 57 {
        let bodies: Vec<_> = world.bodies().collect();
        let body = bodies[1 + step as usize % (bodies.len() - 1)];
        if step.is_multiple_of(2) {
            world.remove_body(body).expect("exists");
        } else {
            world.apply_impulse(body, Vec3::new(0.0, 900.0, 300.0)).expect("dynamic");
        }
    }
}

fn towers() -> OwnedWorld {
    let mut world = sleepy(64);
    for i in 0..5 {
        tower(&mut world, 3.0 * i as f32, 3 + i % 3);
    }
    world
}

#[test]
fn the_bits_are_the_same_with_any_executor_with_caches_or_without_and_after_restore() {
    let (mut plain, mut dropped, mut pooled, mut shuffled) = (towers(), towers(), towers(), towers());
    let (mut pool, mut shuffler) = (Pool::new(3).expect("threads"), Shuffled::new(7));
    let mut restored = towers();
    let mut snapshot = vec![0; 1 << 20];
    let (mut slept, mut woke, mut before) = (0, 0, 0);
    for step in 0..1500 {
        for world in [&mut plain, &mut dropped, &mut pooled, &mut shuffled, &mut restored] {
            restless(world, step);
        }
        if step % 3 == 0 {
            dropped.drop_caches();
        }
        let report = plain.step(&mut Serial);
        dropped.step(&mut Serial);
        pooled.step(&mut pool);
        shuffled.step(&mut shuffler);
        let length = restored.save(&mut snapshot).expect("room");
        let mut other = towers();
        other.load(&snapshot[..length]).expect("a snapshot of this world");
        other.step(&mut Serial);
        restored = other;
        slept += u32::from(report.asleep > before);
        woke += u32::from(report.asleep < before);
        before = report.asleep;
        let sums = [&plain, &dropped, &pooled, &shuffled, &restored].map(cellstep::World::checksum);
        assert!(sums.iter().all(|sum| *sum == sums[0]), "step {step}: {sums:x?}");
    }
    assert!(slept >= 8 && woke >= 8, "{slept} {woke}");
}

/// A static body that is put into a sleeper wakes it, whoever else is near.
#[test]
fn a_static_body_that_is_put_there_wakes() {
    for watched in [false, true] {
        let mut world = sleepy(4);
        let sleeper = box_at(&mut world, 0.0, 0.0, 0.5);
        let def = BodyDef::new(BodyKind::Static, Vec3::new(5.0, 0.0, 0.5));
        let (block, _) = add(&mut world, &def, &cube());
        run(&mut world, SOON);
        if watched {
            // Awake, and too far to touch.
            let def = BodyDef {
                gravity_scale: 0.0,
                can_sleep: false,
                ..BodyDef::new(BodyKind::Dynamic, Vec3::new(0.0, 1.04, 0.5))
            };
            add(&mut world, &def, &cube());
        }
        run(&mut world, 3);
        assert_eq!(asleep(&world, &[sleeper]), 1);
        world.set_pose(block, Position::at(Vec3::new(0.9, 0.0, 0.5)), Rotation::IDENTITY).expect("in range");
        run(&mut world, 1);
        assert_eq!(asleep(&world, &[sleeper]), 0);
        run(&mut world, 30);
        assert!(world.position(sleeper).expect("exists").to_f64()[0] < -0.05, "pushed out");
    }
}

/// A body may rest so near a sleeper that points between them would be kept, but not so near that it wakes.
#[test]
fn a_body_that_stands_near_leaves_the_sleeper_asleep() {
    for gap in [0.0205, 0.0215, 0.0225, 0.0235, 0.0245] {
        let mut world = sleepy(4);
        let sleeper = box_at(&mut world, 0.0, 0.0, 0.5);
        run(&mut world, SOON);
        let def =
            BodyDef { can_sleep: false, ..BodyDef::new(BodyKind::Dynamic, Vec3::new(0.0, 1.0 + gap, 0.5)) };
        add(&mut world, &def, &cube());
        run(&mut world, 30);
        assert_eq!(asleep(&world, &[sleeper]), 1, "{gap} m apart");
    }
}
