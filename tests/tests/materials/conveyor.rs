//! Surfaces that move while their shapes do not.

use super::{RATE, ball, cuboid, dynamic, floor, place, room};
use cellstep::math::{Rotation, Vec3};
use cellstep::{BodyDef, BodyKind, MaterialTraits, Settings, ShapeDef};
use cellstep_tests::oracles::{GRAVITY, judge, relative, spin, velocity};
use cellstep_tests::worlds::{OwnedWorld, add, run};

fn belt(speed: f32) -> MaterialTraits {
    MaterialTraits { surface_velocity: Vec3::new(speed, 0.0, 0.0), ..MaterialTraits::default() }
}

/// A box put on the belt slides at mu g until it has the belt's speed, after v^2 / (2 mu g).
#[test]
fn a_box_comes_to_the_belts_speed_as_friction_allows() {
    for (speed, friction) in [(2.0_f32, 0.3_f32), (6.0, 0.8), (-3.0, 0.2)] {
        let mut world = room(2);
        floor(&mut world, ShapeDef { friction, traits: belt(speed), ..ball(1.0) });
        let (body, _) =
            add(&mut world, &dynamic(0.0, 0.0, 0.5), &ShapeDef { friction, ..cuboid(0.5, 0.5, 0.5) });
        let a = f64::from(friction) * GRAVITY;
        let v = f64::from(speed);
        let time = v.abs() / a;
        let half = (0.5 * time * f64::from(RATE)) as u32;
        run(&mut world, half);
        let now = f64::from(half) / f64::from(RATE);
        judge(
            "speed on the way",
            relative(velocity(&world, body)[0], a * now * v.signum()),
            [5.0e-3, 2.0e-2],
        );
        let steps = (time * f64::from(RATE)) as u32 + RATE;
        run(&mut world, steps - half);
        judge("speed of the belt", relative(velocity(&world, body)[0], v), [1.0e-4, 1.0e-3]);
        let end = f64::from(steps) / f64::from(RATE);
        let way = v.signum() * (0.5 * v * v / a + v.abs() * (end - time));
        // Symplectic Euler is half a substep ahead while it speeds up.
        judge("way", relative(place(&world, body)[0], way), [5.0e-3, 1.0e-2]);
        assert!(place(&world, body)[1].abs() < 1.0e-3, "went aside");
    }
}

/// The velocity is given in the shape's frame.
#[test]
fn the_belt_turns_with_its_shape() {
    let mut world = room(2);
    let quarter = Rotation::from_axis_angle(Vec3::Z, core::f32::consts::FRAC_PI_2);
    let def = BodyDef { rotation: quarter, ..BodyDef::new(BodyKind::Static, Vec3::new(0.0, 0.0, -0.5)) };
    add(&mut world, &def, &ShapeDef { traits: belt(1.0), ..cuboid(20.0, 2.0, 0.5) });
    let (body, _) = add(&mut world, &dynamic(0.0, 0.0, 0.25), &cuboid(0.25, 0.25, 0.25));
    run(&mut world, 2 * RATE);
    let v = velocity(&world, body);
    judge("along y", relative(v[1], 1.0), [1.0e-4, 1.0e-3]);
    assert!(v[0].abs() < 1.0e-3, "{v:?}");
}

/// On a kinematic body the belt's velocity comes to that of the body.
#[test]
fn a_belt_rides_on_a_kinematic_body() {
    let mut world = room(2);
    let def = BodyDef {
        linear_velocity: Vec3::new(0.5, 0.0, 0.0),
        ..BodyDef::new(BodyKind::Kinematic, Vec3::new(0.0, 0.0, -0.5))
    };
    add(&mut world, &def, &ShapeDef { traits: belt(1.0), ..cuboid(20.0, 2.0, 0.5) });
    let (body, _) = add(&mut world, &dynamic(0.0, 0.0, 0.25), &cuboid(0.25, 0.25, 0.25));
    run(&mut world, 2 * RATE);
    judge("both", relative(velocity(&world, body)[0], 1.5), [1.0e-4, 1.0e-3]);
}

/// A dynamic body with moving tracks drives itself: what it pushes is the ground.
#[test]
fn tracks_drive_their_own_body() {
    let mut world = room(2);
    floor(&mut world, ball(1.0));
    let (body, _) =
        add(&mut world, &dynamic(0.0, 0.0, 0.25), &ShapeDef { traits: belt(-2.0), ..cuboid(0.5, 0.3, 0.25) });
    run(&mut world, 2 * RATE);
    judge("tracks", relative(velocity(&world, body)[0], 2.0), [1.0e-3, 1.0e-2]);
}

/// What it is driven by leaves the normal alone: a belt that runs up into the box does not lift it.
#[test]
fn the_part_along_the_normal_is_left_out() {
    let mut world = room(2);
    let traits = MaterialTraits { surface_velocity: Vec3::new(0.0, 0.0, 5.0), ..MaterialTraits::default() };
    floor(&mut world, ShapeDef { traits, ..ball(1.0) });
    let (body, _) = add(&mut world, &dynamic(0.0, 0.0, 0.5), &cuboid(0.5, 0.5, 0.5));
    run(&mut world, RATE);
    assert!((place(&world, body)[2] - 0.5).abs() < 2.0e-3, "{:?}", place(&world, body));
    assert!(velocity(&world, body)[2].abs() < 1.0e-3);
}

/// A ball on a belt: friction gives it the belt's speed at its lowest point; it keeps 2/7 of it.
#[test]
fn a_ball_on_a_belt_rolls() {
    let mut world = room(2);
    floor(&mut world, ShapeDef { traits: belt(7.0), ..ball(1.0) });
    let (body, _) = add(&mut world, &dynamic(0.0, 0.0, 0.5), &ball(0.5));
    run(&mut world, 2 * RATE);
    judge("speed of the ball", relative(velocity(&world, body)[0], 2.0), [1.0e-3, 1.0e-2]);
    let at_the_belt = velocity(&world, body)[0] - spin(&world, body)[1] * 0.5;
    judge("at the belt", relative(at_the_belt, 7.0), [1.0e-3, 1.0e-2]);
}

fn sleepy(world: &mut OwnedWorld) {
    world.set_settings(&Settings { sleep_time: 0.5, ..Settings::default() }).expect("in range");
}

/// A box that a wall holds on a belt stays awake; when the belt stops it sleeps, and wakes when it starts again.
#[test]
fn a_belt_keeps_what_it_carries_awake() {
    let mut world = room(3);
    sleepy(&mut world);
    let traits = belt(1.0);
    let (_, surface) = floor(&mut world, ShapeDef { traits, ..ball(1.0) });
    add(&mut world, &BodyDef::new(BodyKind::Static, Vec3::new(1.5, 0.0, 0.5)), &cuboid(0.5, 1.0, 0.5));
    let (body, _) = add(&mut world, &dynamic(0.4, 0.0, 0.25), &cuboid(0.25, 0.25, 0.25));
    run(&mut world, 4 * RATE);
    assert!(velocity(&world, body)[0].abs() < 1.0e-2, "the wall holds it");
    assert_eq!(world.is_asleep(body), Ok(false));
    world.set_material_traits(surface, &MaterialTraits::default()).expect("no room needed");
    run(&mut world, 2 * RATE);
    assert_eq!(world.is_asleep(body), Ok(true));
    world.set_material_traits(surface, &belt(-1.0)).expect("room");
    run(&mut world, RATE);
    assert_eq!(world.is_asleep(body), Ok(false));
    judge("away from the wall", relative(velocity(&world, body)[0], -1.0), [1.0e-3, 1.0e-2]);
}
