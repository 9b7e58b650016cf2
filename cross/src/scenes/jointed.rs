//! Bodies that hang together, touch what they should not, and fall asleep.

use super::SceneWorld;
use super::things::{add, add_ground};
use crate::numbers::Numbers;
use cellstep_core::joint::axis::{TURN_X, X, Z};
use cellstep_core::math::{self, PI, Pose, Rotation, Vec3};
use cellstep_core::{
    Axis, BodyDef, BodyHandle, BodyKind, Drive, Geometry, JointDef, MaterialTraits, Settings, ShapeDef,
    ShapeEvents, Spring,
};

/// The shapes of what hangs together, round ones above all.
fn geometry(index: u32) -> Geometry {
    match index % 4 {
        0 => Geometry::Capsule { half_height: 0.2, radius: 0.1 },
        1 => Geometry::Cylinder { half_height: 0.15, radius: 0.2 },
        2 => Geometry::Cone { half_height: 0.2, radius: 0.2 },
        _ => Geometry::Box { half_extents: Vec3::new(0.1, 0.15, 0.2) },
    }
}

fn frames(a: Vec3, b: Vec3) -> [Pose; 2] {
    [Pose::new(a, Rotation::IDENTITY), Pose::new(b, Rotation::IDENTITY)]
}

/// Trees of 13 bodies with limits and friction, a chain under a weight, a bridge, a four-bar with a motor, cars on
/// wheels, rough balls on a belt, a sensor, and bodies that sleep when they have come to rest.
pub(super) fn build(world: &mut SceneWorld<'_>) {
    let mut numbers = Numbers(31);
    world.set_settings(&Settings { sleep_time: 0.5, ..world.settings() }).expect("in range");
    add_ground(world);
    for i in 0..4 {
        tree(world, &mut numbers, Vec3::new(3.0 * i as f32, 0.0, 2.0));
    }
    let base = world.create_body(&BodyDef::new(BodyKind::Static, Vec3::new(0.0, 6.0, 8.0))).expect("room");
    hang(world, (base, 16), (Vec3::X * 0.5, 500.0));
    bridge(world, base);
    four_bar(world, base);
    for i in 0..2 {
        car(world, Vec3::new(-6.0, 3.0 * i as f32, 1.0));
    }
    belt(world, &mut numbers);
    let sensor = ShapeDef::sensor(Geometry::Box { half_extents: Vec3::new(2.0, 2.0, 1.0) });
    add(world, &BodyDef::new(BodyKind::Static, Vec3::new(3.0, 0.0, 1.0)), &sensor);
}

/// A body like a doll: each body hangs on one before it.
fn tree(world: &mut SceneWorld<'_>, numbers: &mut Numbers, place: Vec3) {
    let mut bodies = [BodyHandle::default(); 13];
    let mut places = [Vec3::ZERO; 13];
    for i in 0..13 {
        let parent = if i < 2 { 0 } else { i - 2 };
        places[i] = if i == 0 {
            Vec3::ZERO
        } else {
            places[parent] + math::normalize_or(numbers.vector(1.0), Vec3::X) * 0.5
        };
        let def = BodyDef::new(BodyKind::Dynamic, place + places[i]);
        let shape = ShapeDef { events: ShapeEvents::ALL, ..ShapeDef::new(geometry(i as u32)) };
        bodies[i] = add(world, &def, &shape);
        if i == 0 {
            continue;
        }
        let half = (places[i] - places[parent]) * 0.5;
        let mut def = match i % 3 {
            0 => JointDef {
                cone: Some(0.6),
                ..JointDef::ball([bodies[parent], bodies[i]], frames(half, -half))
            },
            1 => JointDef::hinge([bodies[parent], bodies[i]], frames(half, -half)),
            _ => JointDef::ball([bodies[parent], bodies[i]], frames(half, -half)),
        };
        def.axes[TURN_X] = Axis { friction: 0.5, ..Axis::limited(-0.8, 0.8) };
        world.create_joint(&def).expect("room");
    }
}

/// A level chain of links of 1 kg, with a weight at its end.
fn hang(world: &mut SceneWorld<'_>, (base, links): (BodyHandle, u32), (way, weight): (Vec3, f32)) {
    let (mut last, mut arm) = (base, Vec3::ZERO);
    for i in 0..links {
        let density = if i + 1 == links { weight } else { 1.0 } / 0.0335;
        let def = BodyDef::new(BodyKind::Dynamic, Vec3::new(0.0, 6.0, 8.0) + way * (i as f32 + 0.5));
        let shape = ShapeDef { density, ..ShapeDef::new(Geometry::Sphere { radius: 0.2 }) };
        let body = add(world, &def, &shape);
        world.create_joint(&JointDef::ball([last, body], frames(arm, way * -0.5))).expect("room");
        (last, arm) = (body, way * 0.5);
    }
}

/// Planks between two ends, that break under too much.
fn bridge(world: &mut SceneWorld<'_>, base: BodyHandle) {
    let (mut last, mut arm) = (base, Vec3::new(0.0, 4.0, -4.0));
    for i in 0..8 {
        let def = BodyDef::new(BodyKind::Dynamic, Vec3::new(0.5 + i as f32, 10.0, 4.0));
        let plank = Geometry::Box { half_extents: Vec3::new(0.45, 0.5, 0.05) };
        let body = add(world, &def, &ShapeDef::new(plank));
        let hinge =
            JointDef { break_force: 4.0e4, ..JointDef::hinge([last, body], frames(arm, Vec3::X * -0.5)) };
        world.create_joint(&hinge).expect("room");
        (last, arm) = (body, Vec3::X * 0.5);
    }
    let end = frames(arm, Vec3::new(8.0, 4.0, -4.0));
    world.create_joint(&JointDef::ball([last, base], end)).expect("room");
}

/// Bars of 1, 3, 2.5 and, in the world, 3 m; the shortest is driven.
fn four_bar(world: &mut SceneWorld<'_>, base: BodyHandle) {
    let about_y = Rotation::from_axis_angle(Vec3::Z, 0.5 * PI);
    // The third point is 3 m from the second and 2.5 m from the fourth.
    let points = [Vec3::ZERO, Vec3::Z, Vec3::new(2.7083, 0.0, 2.2902), Vec3::X * 3.0];
    let mut last = (base, Pose::new(Vec3::Z * -4.0, about_y));
    for i in 0..3 {
        let (from, to) = (points[i], points[i + 1]);
        let length = math::length(to - from);
        let rotation = Rotation::between(Vec3::X, (to - from) / length);
        let place = Vec3::new(0.0, 6.0, 4.0) + (from + to) * 0.5;
        let def = BodyDef { rotation, ..BodyDef::new(BodyKind::Dynamic, place) };
        let bar = Geometry::Capsule { half_height: 0.05, radius: 0.05 };
        let body = add(world, &def, &ShapeDef::new(bar));
        let end = |side: f32| Pose::new(Vec3::X * (side * length), rotation.inverse().after(about_y));
        let mut hinge = JointDef::hinge([last.0, body], [last.1, end(-0.5)]);
        if i == 0 {
            hinge.axes[TURN_X].drive = Some(Drive::motor(2.0, 50.0));
        }
        world.create_joint(&hinge).expect("room");
        last = (body, end(0.5));
    }
    let end = Pose::new(points[3] + Vec3::Z * -4.0, about_y);
    world.create_joint(&JointDef::hinge([last.0, base], [last.1, end])).expect("room");
}

/// A box on four driven wheels.
fn car(world: &mut SceneWorld<'_>, place: Vec3) {
    let chassis = Geometry::Box { half_extents: Vec3::new(0.5, 1.0, 0.2) };
    let body = add(world, &BodyDef::new(BodyKind::Dynamic, place), &ShapeDef::new(chassis));
    let spring = Spring::Frequency { hertz: 4.0, damping_ratio: 0.7 };
    for (x, y) in [(-0.7, -0.8), (0.7, -0.8), (-0.7, 0.8), (0.7, 0.8)] {
        let arm = Vec3::new(x, y, -0.3);
        let wheel = Geometry::Sphere { radius: 0.3 };
        let wheel = add(world, &BodyDef::new(BodyKind::Dynamic, place + arm), &ShapeDef::new(wheel));
        let mut def = JointDef::wheel([body, wheel], frames(arm, Vec3::ZERO), spring);
        def.axes[Z].motion = Axis::limited(-0.2, 0.2).motion;
        def.axes[TURN_X].drive = Some(Drive::motor(-4.0, 40.0));
        world.create_joint(&def).expect("room");
    }
}

/// Balls that resist rolling on a plate whose surface moves, and one too fast to be caught by contacts alone.
fn belt(world: &mut SceneWorld<'_>, numbers: &mut Numbers) {
    let moving = MaterialTraits { surface_velocity: Vec3::new(1.0, 0.5, 0.0), ..MaterialTraits::default() };
    let plate = Geometry::Box { half_extents: Vec3::new(3.0, 3.0, 0.02) };
    let plate = ShapeDef { traits: moving, ..ShapeDef::new(plate) };
    add(world, &BodyDef::new(BodyKind::Static, Vec3::new(0.0, -8.0, 1.0)), &plate);
    let rough = MaterialTraits { rolling: 0.01, spinning: 0.02, ..MaterialTraits::default() };
    for i in 0..12 {
        let place = Vec3::new((i % 4) as f32 - 1.5, (i / 4) as f32 - 9.0, 1.6) + numbers.vector(0.2);
        let def =
            BodyDef { angular_velocity: numbers.vector(20.0), ..BodyDef::new(BodyKind::Dynamic, place) };
        let shape = ShapeDef { traits: rough, ..ShapeDef::new(Geometry::Sphere { radius: 0.25 }) };
        add(world, &def, &shape);
    }
    let fast = BodyDef {
        linear_velocity: Vec3::new(3.0, 1.0, -300.0),
        bullet: true,
        ..BodyDef::new(BodyKind::Dynamic, Vec3::new(0.3, -8.2, 60.0))
    };
    add(world, &fast, &ShapeDef::new(Geometry::Box { half_extents: Vec3::new(0.01, 0.1, 0.3) }));
}

/// A push now and then, on what sleeps too.
pub(super) fn push(world: &mut SceneWorld<'_>, step: u32) {
    if step % 60 == 0 {
        let mut numbers = Numbers(step.into());
        let index = numbers.below(60) as usize;
        let body = world.bodies().nth(index).filter(|&body| world.kind(body) == Ok(BodyKind::Dynamic));
        if let Some(body) = body {
            world.apply_impulse(body, numbers.vector(50.0)).expect("it is dynamic");
        }
    }
    if step == 150 {
        let joint = world.joints().nth(3).expect("there are more");
        world.set_joint_axis(joint, X, &Axis::limited(-0.01, 0.01)).expect("in range");
    }
}
