//! Resistance to rolling and spinning.

use super::{RATE, ball, dynamic, floor, incline, place, rolling, room};
use cellstep::math::{Rotation, Vec3};
use cellstep::{BodyDef, BodyKind, Geometry, MaterialTraits, Position, ShapeDef};
use cellstep_tests::oracles::{GRAVITY, judge, relative, spin, velocity};
use cellstep_tests::worlds::{OwnedWorld, add, run};

/// Rolls a shape whose moment is `share m r^2` along x at 3 m/s; its deceleration, m/s2, over the second second.
fn deceleration((def, shape): (BodyDef, ShapeDef), ground: MaterialTraits, radius: f32) -> f64 {
    let mut world = room(2);
    floor(&mut world, ShapeDef { traits: ground, ..ball(1.0) });
    let speed = 3.0;
    let def = BodyDef {
        position: Position::at(Vec3::new(0.0, 0.0, radius)),
        linear_velocity: Vec3::new(speed, 0.0, 0.0),
        angular_velocity: Vec3::new(0.0, speed / radius, 0.0),
        ..def
    };
    let (body, _) = add(&mut world, &def, &shape);
    run(&mut world, RATE);
    let before = velocity(&world, body)[0];
    run(&mut world, RATE);
    let slip = velocity(&world, body)[0] - spin(&world, body)[1] * f64::from(radius);
    assert!(slip.abs() < 1.0e-2, "slips at {slip} m/s");
    before - velocity(&world, body)[0]
}

#[test]
fn a_ball_slows_down_by_five_sevenths_of_g_d_over_r() {
    for (radius, length) in [(0.5_f32, 0.01_f32), (0.1, 0.002), (1.0, 0.1)] {
        let expected = 5.0 / 7.0 * GRAVITY * f64::from(length / radius);
        for (own, ground) in [(length, 0.0), (0.0, length), (0.5 * length, length)] {
            let shape = ShapeDef { traits: rolling(own), ..ball(radius) };
            let found = deceleration((dynamic(0.0, 0.0, 0.0), shape), rolling(ground), radius);
            let case = format!("ball of {radius} m, resistance {own} and {ground} m");
            judge(&case, relative(found, expected), [2.0e-3, 1.0e-2]);
        }
    }
}

#[test]
fn cylinders_and_capsules_slow_down_as_their_inertia_says() {
    let (half_height, radius, length) = (0.4_f32, 0.25_f32, 0.01_f32);
    let lying = BodyDef {
        rotation: Rotation::from_axis_angle(Vec3::X, core::f32::consts::FRAC_PI_2),
        ..dynamic(0.0, 0.0, 0.0)
    };
    // Cylinder m r^2 / 2 and ball 2/5 m r^2, by their volumes.
    let (cylinder, caps) = (2.0 * f64::from(half_height), 4.0 / 3.0 * f64::from(radius));
    let capsule = (0.5 * cylinder + 0.4 * caps) / (cylinder + caps);
    for (geometry, share) in [
        (Geometry::Cylinder { half_height, radius }, 0.5),
        (Geometry::Capsule { half_height, radius }, capsule),
    ] {
        let expected = GRAVITY * f64::from(length / radius) / (1.0 + share);
        let found = deceleration((lying, ShapeDef::new(geometry)), rolling(length), radius);
        judge(&format!("{geometry:?} rolls"), relative(found, expected), [2.0e-3, 1.0e-2]);
    }
}

#[test]
fn a_ball_rolls_to_a_halt_and_stays() {
    let mut world = room(2);
    floor(&mut world, ShapeDef { traits: rolling(0.02), ..ball(1.0) });
    let def = BodyDef { linear_velocity: Vec3::new(1.0, 0.0, 0.0), ..dynamic(0.0, 0.0, 0.5) };
    let (body, _) =
        add(&mut world, &BodyDef { angular_velocity: Vec3::new(0.0, 2.0, 0.0), ..def }, &ball(0.5));
    // v^2 / 2a with a = 5/7 g d/r.
    let a = 5.0 / 7.0 * GRAVITY * 0.04;
    run(&mut world, (1.2 / a * f64::from(RATE)) as u32);
    let way = place(&world, body)[0];
    judge("way until the ball stands", relative(way, 0.5 / a), [5.0e-3, 2.0e-2]);
    run(&mut world, 5 * RATE);
    assert!((place(&world, body)[0] - way).abs() < 1.0e-4, "rolls on");
    let contact = world.contacts().next().expect("it lies");
    assert_eq!(contact.points, 1);
    assert_eq!(contact.impulses[1..], [0.0; 3]);
}

/// A slope holds a ball while its tangent is less than d / r.
#[test]
fn a_ball_stays_on_a_gentle_slope_and_rolls_down_a_steeper_one() {
    let (radius, length) = (0.5, 0.05);
    for share in [0.5_f32, 0.9, 1.1, 2.0] {
        let mut world = room(2);
        let tangent = share * length / radius;
        incline(&mut world, tangent);
        floor(&mut world, ShapeDef { traits: rolling(length), ..ball(1.0) });
        let (body, _) = add(&mut world, &dynamic(0.0, 0.0, radius), &ball(radius));
        run(&mut world, 4 * RATE);
        let speed = velocity(&world, body)[0];
        if share < 1.0 {
            assert!(speed.abs() < 1.0e-3 && place(&world, body)[0].abs() < 2.0e-3, "{share}: {speed} m/s");
            let torque = f64::from(world.contacts().next().expect("it lies").resistance.y) * 240.0;
            let weight = f64::from(world.mass_properties(body).expect("it exists").mass) * GRAVITY;
            let expected =
                weight * f64::from(tangent) / f64::from(1.0 + tangent * tangent).sqrt() * f64::from(radius);
            judge("torque of the resistance", relative(torque.abs(), expected), [5.0e-3, 2.0e-2]);
        } else {
            let cosine = 1.0 / f64::from(1.0 + tangent * tangent).sqrt();
            let pull = f64::from(tangent - length / radius);
            let expected = 5.0 / 7.0 * GRAVITY * cosine * pull * 4.0;
            judge("speed down the slope", relative(speed, expected), [1.0e-2, 3.0e-2]);
        }
    }
}

fn spinning_ball(world: &mut OwnedWorld, spinning: f32) -> cellstep::BodyHandle {
    let traits = MaterialTraits { spinning, ..MaterialTraits::default() };
    floor(world, ShapeDef { traits, ..ball(1.0) });
    let def = BodyDef { angular_velocity: Vec3::new(0.0, 0.0, 10.0), ..dynamic(0.0, 0.0, 0.5) };
    add(world, &def, &ball(0.5)).0
}

/// A torque of d m g takes the spin 2/5 m r^2 w away in the time 2/5 r^2 w / (d g).
#[test]
fn spin_about_the_normal_stops_after_its_time() {
    let length = 0.05;
    let time = 0.4 * 0.25 * 10.0 / (f64::from(length) * GRAVITY);
    let mut world = room(2);
    let body = spinning_ball(&mut world, length);
    let half = (0.5 * time * f64::from(RATE)) as u32;
    run(&mut world, half);
    let expected = 10.0 * (1.0 - f64::from(half) / f64::from(RATE) / time);
    judge("spin half way", relative(spin(&world, body)[2], expected), [5.0e-3, 2.0e-2]);
    let left = (time * f64::from(RATE)) as u32 - half;
    run(&mut world, left - 3);
    assert!(spin(&world, body)[2] > 0.05, "stopped too early");
    run(&mut world, 8);
    assert!(spin(&world, body)[2].abs() < 1.0e-4, "spins on at {}", spin(&world, body)[2]);
    let mut world = room(2);
    let body = spinning_ball(&mut world, 0.0);
    run(&mut world, 2 * RATE);
    assert_eq!(spin(&world, body)[2], 10.0, "nothing resists");
}

/// On a kinematic floor that turns, spinning resistance brings the ball to the floor's turning; rolling resistance
/// between two balls acts on both.
#[test]
fn resistance_acts_on_the_relative_turning() {
    let mut world = room(2);
    let turning = BodyDef {
        angular_velocity: Vec3::new(0.0, 0.0, 2.0),
        ..BodyDef::new(BodyKind::Kinematic, Vec3::new(0.0, 0.0, -0.5))
    };
    let traits = MaterialTraits { spinning: 0.1, ..MaterialTraits::default() };
    let table = ShapeDef { traits, ..ShapeDef::new(Geometry::Cylinder { half_height: 0.5, radius: 5.0 }) };
    add(&mut world, &turning, &table);
    let (body, _) = add(&mut world, &dynamic(0.0, 0.0, 0.5), &ball(0.5));
    run(&mut world, 2 * RATE);
    judge("spin of a ball on a turntable", relative(spin(&world, body)[2], 2.0), [1.0e-4, 1.0e-3]);

    let mut world = room(2);
    world
        .set_settings(&cellstep::Settings { gravity: Vec3::ZERO, ..cellstep::Settings::default() })
        .expect("in range");
    let rough = ShapeDef { traits, ..ball(0.5) };
    let def = BodyDef { angular_velocity: Vec3::new(4.0, 0.0, 0.0), ..dynamic(-0.5, 0.0, 0.0) };
    let (a, _) = add(&mut world, &def, &rough);
    let (b, _) = add(&mut world, &dynamic(0.5, 0.0, 0.0), &rough);
    for _ in 0..2 * RATE {
        world.apply_force(a, Vec3::new(100.0, 0.0, 0.0)).expect("dynamic");
        world.apply_force(b, Vec3::new(-100.0, 0.0, 0.0)).expect("dynamic");
        run(&mut world, 1);
    }
    // 100 N x 0.1 m for 2 s could take 20 N m s; the moment is 52 kg m2, so 105 N m s have to be shared.
    let (wa, wb) = (spin(&world, a)[0], spin(&world, b)[0]);
    let moment = 0.4 * f64::from(world.mass_properties(a).expect("it exists").mass) * 0.25;
    judge("what one ball loses", relative(moment * (4.0 - wa), 20.0), [1.0e-2, 3.0e-2]);
    judge("is what the other gains", relative(wa + wb, 4.0), [1.0e-5, 1.0e-4]);
}
