//! Trees count their coordinates from some sector. Which one it is must change no bit, only time.

use cellstep::math::{Pose, Rotation, Vec3};
use cellstep::{BodyDef, BodyHandle, BodyKind, Geometry, Position, Serial, Settings, ShapeDef};
use cellstep_tests::sectors::{SHIFTS, Shift, assert_same_but_for, moved};
use cellstep_tests::simulator::snapshot;
use cellstep_tests::worlds::{OwnedWorld, add, world};

fn cuboid(x: f32, y: f32, z: f32) -> ShapeDef {
    ShapeDef::new(Geometry::Box { half_extents: Vec3::new(x, y, z) })
}

fn body(world: &mut OwnedWorld, kind: BodyKind, place: Position, shape: &ShapeDef) -> BodyHandle {
    add(world, &BodyDef { kind, position: place, ..BodyDef::default() }, shape).0
}

/// Boxes that sleep right behind a border, on a floor whose middle is there, too, and balls in front of it.
fn sleepers() -> (OwnedWorld, Vec<BodyHandle>) {
    let mut world = world(40);
    let settings = Settings { sleep_time: 0.2, ..Settings::default() };
    world.set_settings(&settings).expect("in range");
    let at = |x: f32, y: f32, z: f32| Position::at(Vec3::new(x, y, z));
    body(&mut world, BodyKind::Static, at(40.0, 0.0, -0.5), &cuboid(20.0, 20.0, 0.5));
    let mut balls = Vec::new();
    for i in 0..12 {
        let y = i as f32 - 5.5;
        body(&mut world, BodyKind::Dynamic, at(33.1, y, 0.3), &cuboid(0.3, 0.3, 0.3));
        let ball = ShapeDef::new(Geometry::Sphere { radius: 0.2 });
        balls.push(body(&mut world, BodyKind::Dynamic, at(25.0, y, 0.2), &ball));
    }
    (world, balls)
}

#[test]
fn what_wakes_across_a_border_meets_at_once_whatever_the_caches() {
    let (mut kept, balls) = sleepers();
    let (mut dropped, _) = sleepers();
    let mut woken = 0;
    for step in 0..240 {
        for world in [&mut kept, &mut dropped] {
            if step >= 60 && step % 12 == 0 {
                // Beside a sleeper, on the other side of the border: the ball has a new box in this very step.
                let ball = balls[(step as usize / 12) % balls.len()];
                let y = world.position(ball).expect("alive").offset.y;
                let place = Position::at(Vec3::new(32.58, y, 0.25));
                world.set_pose(ball, place, Rotation::IDENTITY).expect("alive");
                world.set_linear_velocity(ball, Vec3::new(1.0, 0.0, 0.0)).expect("alive");
            }
        }
        let before = kept.bodies().filter(|&body| kept.is_asleep(body) == Ok(true)).count();
        dropped.drop_caches();
        kept.step(&mut Serial);
        dropped.step(&mut Serial);
        assert!(snapshot(&kept) == snapshot(&dropped), "step {step}");
        let after = kept.bodies().filter(|&body| kept.is_asleep(body) == Ok(true)).count();
        woken += usize::from(after < before);
    }
    assert!(woken > 5, "{woken} steps in which somebody woke");
}

/// Two floors with a pile on each, the first at the origin, the second far away.
fn two_places(apart: Shift, by: Shift) -> OwnedWorld {
    let mut world = world(80);
    for sectors in [[0; 3], apart] {
        let at = |x: f32, y: f32, z: f32| {
            let home = moved(Position::at(Vec3::new(x, y, z)), sectors);
            moved(home, by)
        };
        body(&mut world, BodyKind::Static, at(32.0, 0.0, -0.5), &cuboid(10.0, 10.0, 0.5));
        for i in 0..30_u8 {
            let (x, y, z) =
                (f32::from(i % 3) * 0.9 + 31.0, f32::from(i / 3 % 3) * 0.9, f32::from(i / 9) * 1.1);
            body(&mut world, BodyKind::Dynamic, at(x, y, z + 0.5), &cuboid(0.4, 0.45, 0.5));
        }
    }
    world
}

#[test]
fn one_world_can_be_in_two_far_places() {
    for apart in SHIFTS {
        let by = [5, -7, 100];
        let mut worlds = [two_places(apart, [0; 3]), two_places(apart, [0; 3]), two_places(apart, by)];
        for step in 0..90 {
            worlds[1].drop_caches();
            for world in &mut worlds {
                world.step(&mut Serial);
            }
            assert!(snapshot(&worlds[0]) == snapshot(&worlds[1]), "{apart:?}, step {step}");
            if step % 10 == 9 {
                assert_same_but_for(by, &worlds[0], &worlds[2], &format!("{apart:?}, step {step}"));
            }
        }
        // Both piles are the same, too, but for the order in which they are solved.
        let world = &worlds[0];
        let dynamic: Vec<BodyHandle> =
            world.bodies().filter(|&body| world.kind(body) == Ok(BodyKind::Dynamic)).collect();
        for (near, far) in dynamic[..30].iter().zip(&dynamic[30..]) {
            let [near, far] = [near, far].map(|&body| world.position(body).expect("alive"));
            let parted = moved(near, apart).minus(far).length();
            assert!(parted < 0.02, "{apart:?}: {parted} m");
        }
    }
}

/// A slope around the origin, a ball that rolls and a box that stays, `far` metres along it: their ways in 2 s.
fn on_a_slope(far: f64, tilt: f32) -> [[f64; 3]; 2] {
    let mut world = world(4);
    let rotation = Rotation::from_rotation_vector(Vec3::new(0.1, tilt, 0.3));
    let slope = BodyDef { kind: BodyKind::Static, rotation, ..BodyDef::default() };
    let friction = 0.9;
    let ground = ShapeDef {
        friction,
        pose: Pose::new(Vec3::new(1.0, 2.0, 0.0), Rotation::IDENTITY),
        ..ShapeDef::new(Geometry::HalfSpace)
    };
    add(&mut world, &slope, &ground);
    let n = rotation.rotate(Vec3::Z).to_array().map(f64::from);
    // Along the surface to the last bit, whatever the length of the normal.
    let at = |along: f64, height: f64| {
        let x = [n[2] * along + n[0] * height, n[1] * height, n[2] * height - n[0] * along];
        Position::from_f64(x)
    };
    let starts = [at(far, 0.5), at(far + 3.0, 0.5)];
    let shapes = [ShapeDef::new(Geometry::Sphere { radius: 0.5 }), cuboid(0.5, 0.5, 0.5)];
    let bodies = [0, 1].map(|i| {
        let def = BodyDef { position: starts[i], rotation, ..BodyDef::default() };
        add(&mut world, &def, &ShapeDef { friction, ..shapes[i] }).0
    });
    for _ in 0..120 {
        world.step(&mut Serial);
    }
    let way = |i: usize| {
        let (from, to) = (starts[i].to_f64(), world.position(bodies[i]).expect("alive").to_f64());
        [to[0] - from[0], to[1] - from[1], to[2] - from[2]]
    };
    assert!(world.penetration_max() < 1.0e-3, "{far} m out: {} m deep", world.penetration_max());
    [way(0), way(1)]
}

#[test]
fn a_half_space_goes_on_for_ten_thousand_kilometres() {
    for tilt in [0.0, 0.25] {
        let near = on_a_slope(0.0, tilt);
        assert!(near[0].iter().map(|x| x * x).sum::<f64>() > 0.5, "the ball rolls {near:?}");
        for far in [64.0, 900.0, 2.0e3, 1.0e5, 1.0e6, 1.0e7, -1.0e7] {
            let ways = on_a_slope(far, tilt);
            for (near, far_way) in near.iter().zip(ways) {
                for axis in 0..3 {
                    let error = (near[axis] - far_way[axis]).abs();
                    assert!(error < 2.0e-3, "{tilt}, {far} m out: {error} m, {near:?} {far_way:?}");
                }
            }
        }
    }
}
