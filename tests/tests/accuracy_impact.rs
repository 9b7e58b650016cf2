//! Impacts against closed forms: momentum, restitution, billiards, bounces.

use cellstep::math::{Rotation, Vec3, cos, sin};
use cellstep::{BodyDef, BodyHandle, Geometry, MassProperties, Position, Serial, Settings, ShapeDef};
use cellstep_tests::executors::Random;
use cellstep_tests::oracles::{
    GRAVITY, Wide, apex, center, minus, momenta, norm, plus, relative, spin, spin_momentum, velocity,
};
use cellstep_tests::score::{Case, Sheet};
use cellstep_tests::worlds::{OwnedWorld, add, ground, run};

/// A ball of a mass, uniform.
fn ball(radius: f32, mass: f32) -> (BodyDef, Geometry) {
    let inertia = Vec3::splat(0.4 * mass * radius * radius);
    let mass = Some(MassProperties { mass, inertia, ..MassProperties::default() });
    (BodyDef { mass, ..BodyDef::default() }, Geometry::Sphere { radius })
}

fn shape(geometry: Geometry, (friction, restitution): (f32, f32)) -> ShapeDef {
    ShapeDef { friction, restitution, ..ShapeDef::new(geometry) }
}

#[test]
fn head_on_balls_exchange_momentum() {
    Case::new("head-on balls").run(|sheet| {
        let mut world = sheet.floating(2);
        let mut put = |mass, x, v| {
            let (def, geometry) = ball(0.5, mass);
            let def = BodyDef {
                position: Position::at(Vec3::new(x, 0.0, 0.0)),
                linear_velocity: Vec3::new(v, 0.0, 0.0),
                ..def
            };
            add(&mut world, &def, &shape(geometry, (0.6, 0.5))).0
        };
        let (light, heavy) = (put(1.0, -1.0, 2.0), put(3.0, 0.5, 0.0));
        run(&mut world, 60);
        sheet.judge("m=1", ((velocity(&world, light)[0] + 0.25).abs(), "m/s"), [1.0e-6, 1.0e-4]);
        sheet.judge("m=3", ((velocity(&world, heavy)[0] - 0.75).abs(), "m/s"), [1.0e-6, 1.0e-4]);
    });
}

/// A hundred bodies that fly at each other from all sides, turning.
fn storm(sheet: &Sheet, restitution: f32) -> (OwnedWorld, Vec<BodyHandle>) {
    let mut world = sheet.floating(100);
    let mut random = Random::new(7);
    let mut any = |size: f32| {
        let mut x = || random.between(-size, size);
        Vec3::new(x(), x(), x())
    };
    let mut bodies = Vec::new();
    for i in 0..100_i32 {
        let place = Vec3::new((i % 5 - 2) as f32, (i / 5 % 5 - 2) as f32, (i / 25) as f32 - 1.5) * 2.0;
        let def = BodyDef {
            position: Position::at(place + any(0.4)),
            rotation: Rotation::from_rotation_vector(any(3.0)),
            linear_velocity: place * -1.0 + any(2.0),
            angular_velocity: any(5.0),
            ..BodyDef::default()
        };
        let geometry = match i % 3 {
            0 => Geometry::Sphere { radius: 0.4 },
            1 => Geometry::Box { half_extents: Vec3::new(0.5, 0.35, 0.25) },
            _ => Geometry::Capsule { half_height: 0.4, radius: 0.25 },
        };
        bodies.push(add(&mut world, &def, &shape(geometry, (0.6, restitution))).0);
    }
    (world, bodies)
}

/// Sums of linear and angular momentum about the origin, and the sums of their sizes.
fn sums(world: &OwnedWorld, bodies: &[BodyHandle]) -> (Wide, Wide, [f64; 2]) {
    let (mut linear, mut angular, mut sizes) = ([0.0; 3], [0.0; 3], [0.0; 2]);
    for &body in bodies {
        let (p, l) = momenta(world, body);
        linear = plus(linear, p, 1.0);
        angular = plus(angular, l, 1.0);
        let orbit = minus(l, spin_momentum(world, body));
        sizes = [sizes[0] + norm(p), sizes[1] + norm(orbit) + norm(spin_momentum(world, body))];
    }
    (linear, angular, sizes)
}

#[test]
fn a_storm_of_collisions_keeps_momentum() {
    Case::new("collision storm").run(|sheet| {
        for restitution in [0.0, 0.5] {
            let (mut world, bodies) = storm(sheet, restitution);
            let (linear, angular, sizes) = sums(&world, &bodies);
            let (mut worst, mut worst_turning, mut contacts) = (0.0_f64, 0.0_f64, 0);
            for _ in 0..300 {
                contacts += world.step(&mut Serial).contacts;
                let (p, l, _) = sums(&world, &bodies);
                worst = worst.max(norm(minus(p, linear)) / sizes[0]);
                worst_turning = worst_turning.max(norm(minus(l, angular)) / sizes[1]);
            }
            assert!(contacts > 3000, "{contacts} contacts are no storm");
            sheet.judge(&format!("e={restitution}, linear momentum"), (worst, "relative"), [1.0e-6, 1.0e-5]);
            sheet.judge(
                &format!("e={restitution}, angular momentum"),
                (worst_turning, "relative"),
                [1.0e-5, 1.0e-3],
            );
        }
    });
}

/// Plays one ball against another, half a diameter aside. Returns the errors of speed, m/s, and of direction,
/// degrees, the greater of the two balls'.
fn play(settings: &Settings) -> (f64, f64) {
    let mut world = cellstep_tests::worlds::world(2);
    world.set_settings(settings).expect("settings are in range");
    let place = |x: f32, y: f32| Position::at(Vec3::new(x, y, 0.0));
    let (def, geometry) = ball(0.5, 1.0);
    let shape = shape(geometry, (0.0, 1.0));
    let cue = BodyDef { linear_velocity: Vec3::new(5.0, 0.0, 0.0), position: place(0.0, 0.0), ..def };
    let cue = add(&mut world, &cue, &shape).0;
    // b / 2R = 1/2: the line of centers is 30 degrees off the way.
    let other = add(&mut world, &BodyDef { position: place(0.75_f32.sqrt(), -0.5), ..def }, &shape).0;
    run(&mut world, 10);
    let (mut speeds, mut angles) = (0.0_f64, 0.0_f64);
    for (body, speed, degrees) in [(other, 18.75_f64.sqrt(), -30.0), (cue, 2.5, 60.0)] {
        let v = velocity(&world, body);
        speeds = speeds.max((norm(v) - speed).abs());
        angles = angles.max((v[1].atan2(v[0]).to_degrees() - degrees).abs());
    }
    (speeds, angles)
}

#[test]
fn billiard_balls_part_at_right_angles() {
    // Restitution comes at the end of the step. Until then the balls slide along each other, 3 cm here, and the
    // point of contact goes with one of them, so that the other takes some spin: an error of the second order in
    // dt.
    Case::new("billiards").run(|sheet| {
        let (speed, angle) = play(&Settings { gravity: Vec3::ZERO, ..sheet.settings() });
        sheet.judge("speed over 5 m/s", (speed / 5.0, "relative"), [1.0e-4, 1.0e-2]);
        sheet.judge("direction", (angle, "degrees"), [0.05, 0.5]);
    });
    Case::new("billiards at 240 steps per second").run_own(|sheet| {
        let (speed, angle) =
            play(&Settings { dt: 1.0 / 240.0, substeps: 1, gravity: Vec3::ZERO, ..sheet.settings() });
        sheet.judge("speed over 5 m/s", (speed / 5.0, "relative"), [1.0e-4, 1.0e-3]);
        sheet.judge("direction", (angle, "degrees"), [0.01, 0.05]);
    });
}

#[test]
fn a_slender_rod_strikes_the_ground() {
    Case::new("slender rod that strikes the ground").run(|sheet| {
        let mut world = sheet.floating(2);
        ground(&mut world, 0.0);
        let (radius, tilt) = (0.01, core::f32::consts::FRAC_PI_6);
        let inertia = Vec3::new(1.0 / 12.0, 1.0 / 12.0, 1.0e-4);
        let def = BodyDef {
            position: Position::at(Vec3::new(0.0, 0.0, 0.5 * sin(tilt) + radius)),
            // The rod's axis is z; it ends 30 degrees from the ground.
            rotation: Rotation::from_axis_angle(Vec3::Y, core::f32::consts::FRAC_PI_2 - tilt),
            linear_velocity: Vec3::new(0.0, 0.0, -3.0),
            mass: Some(MassProperties { mass: 1.0, inertia, ..MassProperties::default() }),
            ..BodyDef::default()
        };
        let rod = Geometry::Capsule { half_height: 0.5, radius };
        let (body, _) = add(&mut world, &def, &shape(rod, (0.0, 0.0)));
        run(&mut world, 1);
        let impulse = velocity(&world, body)[2] + 3.0;
        sheet.judge("impulse", ((impulse - 0.923_077).abs(), "N s"), [1.0e-4, 1.0e-2]);
        sheet.judge("spin", ((norm(spin(&world, body)) - 4.796_163).abs(), "rad/s"), [1.0e-4, 1.0e-2]);
    });
}

/// Drops a ball from 5 m for a time. Returns the moment of the first impact and the apex after each.
fn drop_ball(sheet: &Sheet, restitution: f32, steps: u32) -> (f64, Vec<f64>) {
    let radius = 0.5;
    let mut world = sheet.world(2);
    ground(&mut world, 0.0);
    let (def, geometry) = ball(radius, 1.0);
    let def = BodyDef { position: Position::at(Vec3::new(0.0, 0.0, 5.0 + radius)), ..def };
    let (body, _) = add(&mut world, &def, &shape(geometry, (0.0, restitution)));
    let (mut impact, mut apexes, mut falling) = (0.0, Vec::new(), true);
    for step in 1..=steps {
        let (z, v) = (center(&world, body)[2] - f64::from(radius), velocity(&world, body)[2]);
        world.step(&mut Serial);
        let (after, up) = (center(&world, body)[2] - f64::from(radius), velocity(&world, body)[2]);
        if up > 0.0 && falling {
            if apexes.is_empty() {
                // The rest of the fall: 0 = z + v t - g t^2 / 2.
                let rest = (v + (v * v + 2.0 * GRAVITY * z).sqrt()) / GRAVITY;
                impact = f64::from(step - 1) / 60.0 + rest;
            }
            apexes.push(apex(after, up, sheet.substep()));
        }
        falling = up < 0.0;
    }
    (impact, apexes)
}

#[test]
fn bounces_reach_their_heights() {
    Case::new("drop 5 m, e=.5").run(|sheet| {
        let (impact, apexes) = drop_ball(sheet, 0.5, 200);
        sheet.judge("first impact", (relative(impact, 1.009_638), "relative"), [1.0e-2, 5.0e-2]);
        for (i, expected) in [1.25, 0.3125, 0.078_125].into_iter().enumerate() {
            let found = apexes.get(i).copied().expect("the ball bounces");
            sheet.judge(
                &format!("apex {}", i + 1),
                (relative(found, expected), "relative"),
                [1.0e-2, 5.0e-2],
            );
        }
    });
}

#[test]
fn full_restitution_neither_gains_nor_loses() {
    Case::new("drop 5 m, e=1").run(|sheet| {
        let (_, apexes) = drop_ball(sheet, 1.0, 1200);
        assert!(apexes.len() >= 9, "{apexes:?}");
        let (mut before, mut worst, mut gain) = (5.0, 0.0_f64, 0.0_f64);
        for &apex in &apexes {
            worst = worst.max(relative(apex, before));
            gain = gain.max(apex / 5.0 - 1.0);
            before = apex;
        }
        sheet.judge("change per bounce", (worst, "relative"), [2.0e-3, 2.0e-2]);
        sheet.judge("gain over all bounces", (gain, "relative"), [2.0e-4, 2.0e-3]);
    });
}

#[test]
fn a_box_that_falls_flat_does_not_start_to_spin() {
    Case::new("box that falls flat").run(|sheet| {
        for restitution in [0.0, 0.5, 1.0] {
            let mut world = sheet.world(2);
            ground(&mut world, 0.6);
            let turn = 0.3;
            let def = BodyDef {
                position: Position::at(Vec3::new(0.0, 0.0, 2.5)),
                rotation: Rotation::new(0.0, 0.0, sin(turn), cos(turn)),
                ..BodyDef::default()
            };
            let geometry = Geometry::Box { half_extents: Vec3::splat(0.5) };
            let (body, _) = add(&mut world, &def, &shape(geometry, (0.6, restitution)));
            let mut worst = 0.0_f64;
            for _ in 0..60 {
                world.step(&mut Serial);
                worst = worst.max(norm(spin(&world, body)));
            }
            sheet.judge(&format!("e={restitution}, spin"), (worst, "rad/s"), [1.0e-3, 1.0e-2]);
        }
    });
}
