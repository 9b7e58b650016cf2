//! Friction against closed forms: sticking, sliding, stopping in every direction alike, a wedge.

use cellstep::math::{Rotation, Vec3};
use cellstep::{
    BodyDef, BodyHandle, BodyKind, Capacities, Geometry, MassProperties, Position, Preset, Serial, ShapeDef,
};
use cellstep_tests::oracles::{GRAVITY, Wide, center, dot, minus, relative, velocity};
use cellstep_tests::score::{Case, Sheet};
use cellstep_tests::worlds::{OwnedWorld, add, ground, run};

const CUBE: Geometry = Geometry::Box { half_extents: Vec3::splat(0.5) };
/// 30 degrees, in single precision.
const SLOPE: f32 = core::f32::consts::FRAC_PI_6;

/// A cube on a half-space that falls by [`SLOPE`] towards x. Returns the direction downhill too.
fn on_a_slope(sheet: &Sheet, friction: f32, aligned: Rotation) -> (OwnedWorld, BodyHandle, Wide) {
    let mut world = sheet.world(2);
    let tilt = Rotation::from_axis_angle(Vec3::Y, SLOPE);
    let slope = BodyDef { rotation: tilt, ..BodyDef::new(BodyKind::Static, Vec3::ZERO) };
    let slope = world.create_body(&slope).expect("room");
    let surface = ShapeDef { friction, ..ShapeDef::new(Geometry::HalfSpace) };
    world.create_shape(slope, &surface).expect("room");
    let def = BodyDef {
        position: Position::at(tilt.rotate(Vec3::new(0.0, 0.0, 0.5))),
        rotation: tilt.after(aligned),
        ..BodyDef::default()
    };
    let (body, _) = add(&mut world, &def, &ShapeDef { friction, ..ShapeDef::new(CUBE) });
    let (sine, cosine) = (f64::from(SLOPE).sin(), f64::from(SLOPE).cos());
    (world, body, [cosine, 0.0, -sine])
}

/// How a cube is turned about the slope's normal: flush, and askew.
fn turns() -> [(&'static str, Rotation); 2] {
    [("flush", Rotation::IDENTITY), ("askew", Rotation::from_axis_angle(Vec3::Z, 0.7))]
}

#[test]
fn a_box_sticks_above_the_angle_of_friction() {
    Case::new("incline 30 degrees, mu=.585").gated_from(Preset::Balanced).run(|sheet| {
        // tan 30 degrees = .57735.
        for (name, turn) in turns() {
            let (mut world, body, downhill) = on_a_slope(sheet, 0.585, turn);
            let start = center(&world, body);
            let mut creep = 0.0_f64;
            for _ in 0..300 {
                world.step(&mut Serial);
                creep = creep.max(dot(minus(center(&world, body), start), downhill).abs());
            }
            sheet.judge(&format!("{name}, creep in 5 s"), (creep, "m"), [1.0e-4, 5.0e-3]);
        }
    });
}

#[test]
fn a_box_slides_below_the_angle_of_friction() {
    Case::new("incline 30 degrees, mu=.57").run(|sheet| {
        for (name, turn) in turns() {
            let (mut world, body, downhill) = on_a_slope(sheet, 0.57, turn);
            run(&mut world, 60);
            let before = dot(velocity(&world, body), downhill);
            run(&mut world, 240);
            let found = (dot(velocity(&world, body), downhill) - before) / 4.0;
            let slope = f64::from(SLOPE);
            let expected = GRAVITY * (slope.sin() - f64::from(0.57_f32) * slope.cos());
            sheet.judge(
                &format!("{name}, acceleration"),
                (relative(found, expected), "relative"),
                [1.0e-3, 1.0e-2],
            );
        }
    });
}

#[test]
fn sliding_accelerates_as_it_should() {
    Case::new("sliding, 30 degrees, mu=.3").run(|sheet| {
        for (name, turn) in turns() {
            let (mut world, body, downhill) = on_a_slope(sheet, 0.3, turn);
            run(&mut world, 30);
            let before = dot(velocity(&world, body), downhill);
            run(&mut world, 90);
            let found = (dot(velocity(&world, body), downhill) - before) / 1.5;
            sheet.judge(
                &format!("{name}, acceleration"),
                (relative(found, 2.356_287), "relative"),
                [1.0e-3, 1.0e-2],
            );
        }
    });
}

#[test]
fn boxes_slide_alike_in_all_directions() {
    Case::new("slide to stop over 16 azimuths").gated_from(Preset::Balanced).run(|sheet| {
        let mut world = sheet.world(17);
        let friction = 0.4;
        ground(&mut world, friction);
        let mut boxes = Vec::new();
        for i in 0..16 {
            let azimuth = core::f64::consts::TAU * f64::from(i) / 16.0;
            let way = [azimuth.cos(), azimuth.sin(), 0.0];
            let start = Position::at(Vec3::new((i % 4) as f32 * 15.0, (i / 4) as f32 * 15.0, 0.5));
            let def = BodyDef {
                position: start,
                linear_velocity: Vec3::new(5.0 * way[0] as f32, 5.0 * way[1] as f32, 0.0),
                ..BodyDef::default()
            };
            let (body, _) = add(&mut world, &def, &ShapeDef { friction, ..ShapeDef::new(CUBE) });
            boxes.push((body, way, start.to_f64()));
        }
        run(&mut world, 150);
        let (mut least, mut most, mut aside, mut worst) = (f64::MAX, 0.0_f64, 0.0_f64, 0.0_f64);
        for (body, way, start) in boxes {
            let moved = minus(center(&world, body), start);
            let length = dot(moved, way);
            least = least.min(length);
            most = most.max(length);
            worst = worst.max(relative(length, 3.185_525));
            aside = aside.max(dot(moved, [-way[1], way[0], 0.0]).abs() / length);
        }
        sheet.judge("distance", (worst, "relative"), [5.0e-3, 1.0e-2]);
        sheet.judge("spread", ((most - least) / least, "relative"), [1.0e-4, 1.0e-3]);
        sheet.judge("deflection", (aside, "relative"), [1.0e-3, 1.0e-2]);
    });
}

#[test]
fn a_wedge_gives_way_on_a_frictionless_floor() {
    Case::new("wedge").run(|sheet| {
        let mut world = sheet.world_with(Capacities { hulls: 1, ..Capacities::for_bodies(3) });
        // It falls by 30 degrees towards x.
        let (length, height, depth) = (6.0, 6.0 * (1.0_f32 / 3.0).sqrt(), 1.0);
        let corner = |x: f32, z: f32| [Vec3::new(x, -depth, z), Vec3::new(x, depth, z)];
        let points = [corner(0.0, 0.0), corner(length, 0.0), corner(0.0, height)].concat();
        let prism = world.add_hull(&points).expect("a prism has a hull");
        ground(&mut world, 0.0);
        let slippery = |geometry| ShapeDef { friction: 0.0, ..ShapeDef::new(geometry) };
        let mass = |mass, inertia, center| {
            Some(MassProperties { mass, inertia: Vec3::splat(inertia), center, ..MassProperties::default() })
        };
        let middle = Vec3::new(length / 3.0, 0.0, height / 3.0);
        let def = BodyDef { mass: mass(3.0, 10.0, middle), ..BodyDef::default() };
        let (wedge, _) = add(&mut world, &def, &slippery(Geometry::Hull(prism)));
        let tilt = Rotation::from_axis_angle(Vec3::Y, SLOPE);
        let (sine, cosine) = (f64::from(SLOPE).sin(), f64::from(SLOPE).cos());
        let along = |s: f32, up: f32| Vec3::new(0.0, 0.0, height) + tilt.rotate(Vec3::new(s, 0.0, up));
        let def = BodyDef {
            position: Position::at(along(1.0, 0.25)),
            rotation: tilt,
            mass: mass(1.0, 0.05, Vec3::ZERO),
            ..BodyDef::default()
        };
        let cube = Geometry::Box { half_extents: Vec3::splat(0.25) };
        let (block, _) = add(&mut world, &def, &slippery(cube));
        let speeds = |world: &OwnedWorld| {
            let slip = minus(velocity(world, block), velocity(world, wedge));
            (velocity(world, wedge)[0], dot(slip, [cosine, 0.0, -sine]))
        };
        run(&mut world, 6);
        let before = speeds(&world);
        run(&mut world, 48);
        let after = speeds(&world);
        sheet.judge(
            "its acceleration",
            (relative((before.0 - after.0) / 0.8, 1.307_032), "relative"),
            [5.0e-3, 2.0e-2],
        );
        sheet.judge(
            "relative acceleration",
            (relative((after.1 - before.1) / 0.8, 6.036_923), "relative"),
            [5.0e-3, 2.0e-2],
        );
    });
}
