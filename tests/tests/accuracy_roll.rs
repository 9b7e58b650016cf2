//! Rolling against closed forms: down a slope, from sliding, on a turntable.

use cellstep::math::{Rotation, Vec3};
use cellstep::{BodyDef, BodyHandle, BodyKind, Geometry, MassProperties, Position, Serial, ShapeDef};
use cellstep_tests::oracles::{GRAVITY, Wide, center, dot, minus, norm, relative, spin, velocity};
use cellstep_tests::score::{Case, Sheet};
use cellstep_tests::worlds::{OwnedWorld, add, ground, run};

/// 20 degrees.
const SLOPE: f32 = core::f32::consts::PI / 9.0;
const FRICTION: f32 = 0.6;

/// What a body rolls on.
#[derive(Clone, Copy, Debug)]
enum Floor {
    HalfSpace,
    Slab,
}

fn rough(geometry: Geometry) -> ShapeDef {
    ShapeDef { friction: FRICTION, ..ShapeDef::new(geometry) }
}

/// The acceleration, m/s2, with which a round body rolls down [`SLOPE`]. `def` says how it is made and turned.
fn roll_down(sheet: &Sheet, floor: Floor, (def, geometry, radius): (&BodyDef, Geometry, f32)) -> f64 {
    let mut world = sheet.world(2);
    let tilt = Rotation::from_axis_angle(Vec3::Y, SLOPE);
    let slope = BodyDef { rotation: tilt, ..BodyDef::new(BodyKind::Static, Vec3::ZERO) };
    let slope = world.create_body(&slope).expect("room");
    let mut surface = rough(Geometry::HalfSpace);
    if let Floor::Slab = floor {
        surface.geometry = Geometry::Box { half_extents: Vec3::new(20.0, 20.0, 1.0) };
        surface.pose.position = Vec3::new(0.0, 0.0, -1.0);
    }
    world.create_shape(slope, &surface).expect("room");
    let def = BodyDef {
        position: Position::at(tilt.rotate(Vec3::new(0.0, 0.0, radius))),
        rotation: tilt.after(def.rotation),
        ..*def
    };
    let (body, _) = add(&mut world, &def, &rough(geometry));
    let downhill = [f64::from(SLOPE).cos(), 0.0, -f64::from(SLOPE).sin()];
    run(&mut world, 30);
    let before = dot(velocity(&world, body), downhill);
    run(&mut world, 90);
    let aside = velocity(&world, body)[1].abs();
    assert!(aside < 1.0e-3, "rolls aside at {aside} m/s");
    (dot(velocity(&world, body), downhill) - before) / 1.5
}

#[test]
fn round_bodies_roll_down_as_their_inertia_says() {
    Case::new("rolling down 20 degrees").run(|sheet| {
        let radius = 0.5;
        let geometry = Geometry::Sphere { radius };
        for floor in [Floor::HalfSpace, Floor::Slab] {
            for (name, share, expected) in
                [("ball", 0.4, 2.396_584), ("cylinder", 0.5, 2.236_812), ("hoop", 1.0, 1.677_609)]
            {
                let inertia = Vec3::splat(share * radius * radius);
                let mass = Some(MassProperties { mass: 1.0, inertia, ..MassProperties::default() });
                let def = BodyDef { mass, ..BodyDef::default() };
                let found = roll_down(sheet, floor, (&def, geometry, radius));
                sheet.judge(
                    &format!("{name} on a {floor:?}"),
                    (relative(found, expected), "relative"),
                    [1.0e-3, 1.0e-2],
                );
            }
        }
    });
}

#[test]
fn a_capsule_on_its_side_rolls_like_a_cylinder() {
    Case::new("capsule that rolls down 20 degrees").run(|sheet| {
        let (half_height, radius) = (1.0, 0.5);
        // Cylinder m r^2 / 2 and ball 2/5 m r^2, by their volumes: pi r^2 2 l and 4/3 pi r^3.
        let (cylinder, ball) = (2.0 * f64::from(half_height), 4.0 / 3.0 * f64::from(radius));
        let share = (0.5 * cylinder + 0.4 * ball) / (cylinder + ball);
        let expected = GRAVITY * f64::from(SLOPE).sin() / (1.0 + share);
        let def = BodyDef {
            rotation: Rotation::from_axis_angle(Vec3::X, core::f32::consts::FRAC_PI_2),
            ..BodyDef::default()
        };
        for floor in [Floor::HalfSpace, Floor::Slab] {
            let found = roll_down(sheet, floor, (&def, Geometry::Capsule { half_height, radius }, radius));
            sheet.judge(
                &format!("on a {floor:?}"),
                (relative(found, expected), "relative"),
                [1.0e-3, 1.0e-2],
            );
        }
    });
}

#[test]
fn a_sliding_ball_begins_to_roll() {
    Case::new("slide to roll").run(|sheet| {
        let (radius, friction) = (0.1, 0.2);
        let mut world = sheet.world(2);
        ground(&mut world, friction);
        let def = BodyDef {
            position: Position::at(Vec3::new(0.0, 0.0, radius)),
            linear_velocity: Vec3::new(7.0, 0.0, 0.0),
            ..BodyDef::default()
        };
        let (body, _) =
            add(&mut world, &def, &ShapeDef { friction, ..ShapeDef::new(Geometry::Sphere { radius }) });
        let slip = |world: &OwnedWorld| velocity(world, body)[0] - f64::from(radius) * spin(world, body)[1];
        // The slip falls evenly, so two moments of it tell when it ends.
        run(&mut world, 12);
        let early = slip(&world);
        run(&mut world, 36);
        let late = slip(&world);
        let time = 0.2 + 0.6 * early / (early - late);
        sheet.judge("time", (relative(time, 1.019_368), "relative"), [5.0e-3, 2.0e-2]);
        run(&mut world, 42);
        let (speed, place) = (velocity(&world, body)[0], center(&world, body)[0]);
        sheet.judge("speed", (relative(speed, 5.0), "relative"), [5.0e-3, 2.0e-2]);
        sheet.judge("way", (relative(place - speed * (1.5 - time), 6.116_208), "relative"), [5.0e-3, 2.0e-2]);
        // The point of contact lies half the sink above the lowest point: 0.03 mm of 100.
        sheet.judge("slip left over speed", (slip(&world).abs() / speed, "relative"), [1.0e-3, 1.0e-2]);
    });
}

/// Turntable, ball, and the ball's place and velocity at the start.
fn turntable(sheet: &Sheet, floor: Floor) -> (OwnedWorld, BodyHandle) {
    let (turn, radius, speed) = (3.0, 0.1, 0.4);
    let mut world = sheet.world(2);
    let table = BodyDef { angular_velocity: Vec3::Z * turn, ..BodyDef::new(BodyKind::Kinematic, Vec3::ZERO) };
    let table = world.create_body(&table).expect("room");
    let mut surface = ShapeDef { friction: 1.0, ..ShapeDef::new(Geometry::HalfSpace) };
    if let Floor::Slab = floor {
        surface.geometry = Geometry::Box { half_extents: Vec3::new(3.0, 3.0, 0.5) };
        surface.pose.position = Vec3::new(0.0, 0.0, -0.5);
    }
    world.create_shape(table, &surface).expect("room");
    // The circle's center is at the origin: v = 2/7 w z x p. No slip: v - R (wy, -wx) = w z x p.
    let place = Vec3::new(0.0, -speed * 3.5 / turn, radius);
    let surface_speed = -turn * place.y;
    let def = BodyDef {
        position: Position::at(place),
        linear_velocity: Vec3::X * speed,
        angular_velocity: Vec3::Y * ((speed - surface_speed) / radius),
        ..BodyDef::default()
    };
    let ball = ShapeDef { friction: 1.0, ..ShapeDef::new(Geometry::Sphere { radius }) };
    let (body, _) = add(&mut world, &def, &ball);
    (world, body)
}

#[test]
fn a_ball_on_a_turntable_goes_in_a_circle() {
    Case::new("turntable").run(|sheet| {
        for floor in [Floor::HalfSpace, Floor::Slab] {
            let (mut world, body) = turntable(sheet, floor);
            let (mut angle, mut radius_error) = (0.0, 0.0_f64);
            let mut before: Wide = velocity(&world, body);
            let mut period = None;
            for step in 1..=480 {
                world.step(&mut Serial);
                let v = velocity(&world, body);
                let turned = (before[0] * v[1] - before[1] * v[0]).atan2(dot(before, v));
                let full = core::f64::consts::TAU;
                if angle < full && angle + turned >= full {
                    period = Some((f64::from(step - 1) + (full - angle) / turned) / 60.0);
                }
                angle += turned;
                before = v;
                let p = center(&world, body);
                radius_error = radius_error.max(relative(norm(minus(p, [0.0, 0.0, p[2]])), 0.466_667));
            }
            let period = period.expect("the ball comes round");
            sheet.judge(
                &format!("{floor:?}, period"),
                (relative(period, 7.330_383), "relative"),
                [5.0e-3, 1.0e-2],
            );
            sheet.judge(&format!("{floor:?}, radius"), (radius_error, "relative"), [5.0e-3, 1.0e-2]);
        }
    });
}
