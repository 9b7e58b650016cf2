//! Closed forms with friction by points: inclines, stops, belts, turntables, rollers, forces that are read.

use super::{CUBE, with, world_of};
use cellstep::math::{Rotation, Vec3, cos, sin};
use cellstep::{
    AxisLocks, BodyDef, BodyHandle, BodyKind, ContactModel, FrictionModel, Geometry, MaterialTraits,
    Position, Preset, Settings, ShapeDef,
};
use cellstep_tests::oracles::{GRAVITY, Wide, center, dot, judge, minus, norm, relative, spin, velocity};
use cellstep_tests::worlds::{OwnedWorld, add, ground, run};

/// 30 degrees.
const SLOPE: f32 = core::f32::consts::FRAC_PI_6;

fn points() -> Settings {
    with(FrictionModel::Points)
}

/// Presets and contact models with friction by points.
fn settings() -> Vec<(String, Settings)> {
    let mut all: Vec<_> = [Preset::Balanced, Preset::Accurate]
        .map(|preset| {
            let own = Settings { friction_model: FrictionModel::Points, ..Settings::from(preset) };
            (preset.name().to_string(), own)
        })
        .to_vec();
    for contact_model in [ContactModel::Rigid, ContactModel::Split] {
        all.push((format!("{contact_model:?}"), Settings { contact_model, ..points() }));
    }
    all
}

/// A cube on a slope that falls by [`SLOPE`] towards x, turned about its normal; the direction downhill.
fn on_a_slope(settings: &Settings, friction: f32, turn: f32) -> (OwnedWorld, BodyHandle, Wide) {
    let mut world = world_of(settings, 2);
    let tilt = Rotation::from_axis_angle(Vec3::Y, SLOPE);
    let slope = BodyDef { rotation: tilt, ..BodyDef::new(BodyKind::Static, Vec3::ZERO) };
    add(&mut world, &slope, &ShapeDef { friction, ..ShapeDef::new(Geometry::HalfSpace) });
    let def = BodyDef {
        position: Position::at(tilt.rotate(Vec3::Z * 0.5)),
        rotation: tilt.after(Rotation::from_axis_angle(Vec3::Z, turn)),
        ..BodyDef::default()
    };
    let (body, _) = add(&mut world, &def, &ShapeDef { friction, ..ShapeDef::new(CUBE) });
    (world, body, [f64::from(cos(SLOPE)), 0.0, -f64::from(sin(SLOPE))])
}

#[test]
fn a_cube_on_an_incline_sticks_or_slides() {
    let (sine, cosine) = f64::from(SLOPE).sin_cos();
    for (name, settings) in settings() {
        for turn in [0.0, 0.7] {
            let (mut world, body, downhill) = on_a_slope(&settings, 0.585, turn);
            let start = center(&world, body);
            run(&mut world, 300);
            let creep = dot(minus(center(&world, body), start), downhill).abs();
            judge(&format!("{name}, turned by {turn}: creep in 5 s, m"), creep, [1.0e-4, 5.0e-3]);
            for friction in [0.57, 0.3] {
                let (mut world, body, downhill) = on_a_slope(&settings, friction, turn);
                run(&mut world, 60);
                let before = dot(velocity(&world, body), downhill);
                run(&mut world, 60);
                let found = dot(velocity(&world, body), downhill) - before;
                let expected = GRAVITY * (sine - f64::from(friction) * cosine);
                let case = format!("{name}, turned by {turn}, mu {friction}: acceleration");
                judge(&case, relative(found, expected), [1.0e-3, 2.0e-2]);
            }
        }
    }
}

#[test]
fn cubes_slide_to_a_stop_alike_in_all_directions() {
    for (name, settings) in settings() {
        let mut world = world_of(&settings, 17);
        ground(&mut world, 0.4);
        let mut cubes = Vec::new();
        for i in 0..16 {
            let azimuth = core::f32::consts::TAU * i as f32 / 16.0;
            let way = Vec3::new(cos(azimuth), sin(azimuth), 0.0);
            let place = Vec3::new((i % 4) as f32 * 15.0, (i / 4) as f32 * 15.0, 0.5);
            let def = BodyDef { linear_velocity: way * 5.0, ..BodyDef::new(BodyKind::Dynamic, place) };
            let (body, _) = add(&mut world, &def, &ShapeDef { friction: 0.4, ..ShapeDef::new(CUBE) });
            cubes.push((body, center(&world, body)));
        }
        run(&mut world, 120);
        let ways: Vec<f64> =
            cubes.iter().map(|&(body, start)| norm(minus(center(&world, body), start))).collect();
        let (least, most) = ways.iter().fold((f64::MAX, 0.0_f64), |(l, m), &way| (l.min(way), m.max(way)));
        let mean = ways.iter().sum::<f64>() / 16.0;
        println!("{name}: {mean:.5} m, {least:.5} to {most:.5}");
        judge(&format!("{name}: way of 3.185525 m"), relative(mean, 3.185_525), [5.0e-3, 2.0e-2]);
        judge(&format!("{name}: spread"), (most - least) / mean, [1.0e-3, 1.0e-2]);
    }
}

#[test]
fn belts_turntables_and_rails_are_felt() {
    // A belt of 2 m/s brings a cube along.
    let mut world = world_of(&points(), 2);
    let table = Geometry::Box { half_extents: Vec3::new(30.0, 2.0, 0.5) };
    let belt = ShapeDef {
        friction: 0.5,
        traits: MaterialTraits { surface_velocity: Vec3::X * 2.0, ..ShapeDef::new(table).traits },
        ..ShapeDef::new(table)
    };
    add(&mut world, &BodyDef::new(BodyKind::Static, Vec3::Z * -0.5), &belt);
    let cube = ShapeDef { friction: 0.5, ..ShapeDef::new(CUBE) };
    let (body, _) = add(&mut world, &BodyDef::new(BodyKind::Dynamic, Vec3::Z * 0.5), &cube);
    run(&mut world, 12);
    judge("belt: pull", relative(velocity(&world, body)[0], 0.2 * 0.5 * GRAVITY), [2.0e-2, 5.0e-2]);
    run(&mut world, 60);
    judge("belt: speed", relative(velocity(&world, body)[0], 2.0), [1.0e-3, 1.0e-2]);
    // A turntable takes it round: at 1 m and 1 rad/s it needs 1 m/s2.
    let mut world = world_of(&points(), 2);
    let table = Geometry::Box { half_extents: Vec3::new(3.0, 3.0, 0.5) };
    let plate = BodyDef { angular_velocity: Vec3::Z, ..BodyDef::new(BodyKind::Kinematic, Vec3::Z * -0.5) };
    add(&mut world, &plate, &ShapeDef { friction: 0.5, ..ShapeDef::new(table) });
    let def = BodyDef {
        linear_velocity: Vec3::Y,
        angular_velocity: Vec3::Z,
        ..BodyDef::new(BodyKind::Dynamic, Vec3::new(1.0, 0.0, 0.5))
    };
    let (body, _) = add(&mut world, &def, &cube);
    run(&mut world, 377);
    judge("turntable: after a turn, m", norm(minus(center(&world, body), [1.0, 0.0, 0.5])), [1.0e-2, 5.0e-2]);
    judge("turntable: spin", relative(spin(&world, body)[2], 1.0), [1.0e-3, 1.0e-2]);
    // A cube that may not move along x slides along y alone.
    let mut world = world_of(&points(), 2);
    ground(&mut world, 0.3);
    let def = BodyDef {
        locks: AxisLocks::MOVE_X,
        linear_velocity: Vec3::Y * 3.0,
        angular_velocity: Vec3::Z * 0.5,
        ..BodyDef::new(BodyKind::Dynamic, Vec3::Z * 0.5)
    };
    let (body, _) = add(&mut world, &def, &ShapeDef { friction: 0.3, ..ShapeDef::new(CUBE) });
    run(&mut world, 30);
    assert_eq!(center(&world, body)[0], 0.0);
    let slower = 3.0 - velocity(&world, body)[1];
    judge("rail: slows down", relative(slower, 0.5 * 0.3 * GRAVITY), [2.0e-2, 5.0e-2]);
}

/// A cylinder that lies on two points rolls down 20 degrees without sliding: `a = g sin / (1 + 1/2)`.
#[test]
fn a_cylinder_rolls() {
    let mut world = world_of(&points(), 2);
    let angle = 20.0_f32.to_radians();
    let tilt = Rotation::from_axis_angle(Vec3::Y, angle);
    let slope = BodyDef { rotation: tilt, ..BodyDef::new(BodyKind::Static, Vec3::ZERO) };
    add(&mut world, &slope, &ShapeDef { friction: 0.6, ..ShapeDef::new(Geometry::HalfSpace) });
    let cylinder = Geometry::Cylinder { half_height: 0.5, radius: 0.25 };
    // Its axis lies along y.
    let def = BodyDef {
        position: Position::at(tilt.rotate(Vec3::Z * 0.25)),
        rotation: Rotation::between(Vec3::Z, Vec3::Y),
        ..BodyDef::default()
    };
    let (body, shape) = add(&mut world, &def, &ShapeDef { friction: 0.6, ..ShapeDef::new(cylinder) });
    run(&mut world, 30);
    let before = norm(velocity(&world, body));
    assert!(world.contacts().any(|contact| contact.shapes.contains(&shape) && contact.points == 2));
    run(&mut world, 60);
    let found = norm(velocity(&world, body)) - before;
    judge("cylinder: acceleration", relative(found, 2.236_812), [1.0e-3, 1.0e-2]);
}

/// Who reads the friction of a contact gets the sum of its points.
#[test]
fn the_force_that_is_read_is_that_of_all_points() {
    for settings in [points(), Settings { friction_model: FrictionModel::Patch, ..points() }] {
        let (mut world, body, downhill) = on_a_slope(&settings, 0.8, 0.4);
        run(&mut world, 120);
        let mass = f64::from(world.mass_properties(body).expect("it lives").mass);
        let contact = world.contacts().next().expect("it lies");
        assert_eq!(contact.points, 4);
        // On the second body, which is the cube.
        let force = contact.friction.to_array().map(|x| f64::from(x) / f64::from(contact.substep));
        let (sine, cosine) = f64::from(SLOPE).sin_cos();
        judge("friction", relative(-dot(force, downhill), mass * GRAVITY * sine), [1.0e-3, 1.0e-2]);
        judge(
            "normal",
            relative(f64::from(contact.normal_force()), mass * GRAVITY * cosine),
            [1.0e-3, 1.0e-2],
        );
    }
}
