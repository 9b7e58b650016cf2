//! Each kind of event where it is plain what must come.

use cellstep::math::{Pose, Rotation, Vec3};
use cellstep::{
    BodyDef, BodyHandle, BodyKind, Capacities, Error, EventKind, EventKinds, Geometry, JointDef, Position,
    Serial, Settings, ShapeDef, ShapeEvents, ShapeHandle,
};
use cellstep_tests::worlds::{OwnedWorld, add, ground, run, world_with};

fn world(bodies: u32) -> OwnedWorld {
    world_with(Capacities { events: 64, sensor_visits: 16, joints: 4, ..Capacities::for_bodies(bodies) })
}

fn cube() -> ShapeDef {
    let geometry = Geometry::Box { half_extents: Vec3::splat(0.5) };
    ShapeDef { events: ShapeEvents::CONTACTS, ..ShapeDef::new(geometry) }
}

fn box_at(world: &mut OwnedWorld, x: f32, z: f32) -> (BodyHandle, ShapeHandle) {
    add(world, &BodyDef::new(BodyKind::Dynamic, Vec3::new(x, 0.0, z)), &cube())
}

fn kinds(world: &OwnedWorld) -> Vec<EventKind> {
    world.events().map(|event| event.kind).collect()
}

/// Events of the next step.
fn step(world: &mut OwnedWorld) -> Vec<EventKind> {
    world.step(&mut Serial);
    assert!(world.events().all(|event| event.step == world.steps()));
    kinds(world)
}

#[test]
fn a_contact_begins_sleeps_wakes_and_ends() {
    let mut world = world(8);
    world.set_settings(&Settings { sleep_time: 0.25, ..Settings::default() }).expect("valid");
    ground(&mut world, 0.5);
    let (body, shape) = box_at(&mut world, 0.0, 0.5);
    let first = step(&mut world);
    assert!(matches!(first[..], [EventKind::ContactBegan(t)] if t.shapes[1] == shape && t.bodies[1] == body));
    let mut told = Vec::new();
    for _ in 0..120 {
        told.extend(step(&mut world));
    }
    assert_eq!(told, [EventKind::Slept(body)]);
    assert_eq!(world.sleeping_contacts().count(), 1);
    world.wake(body).expect("exists");
    assert_eq!(step(&mut world), [EventKind::Woke(body)]);
    for _ in 0..120 {
        step(&mut world);
    }
    // Up and away.
    world.set_linear_velocity(body, Vec3::Z * 30.0).expect("exists");
    let mut told = Vec::new();
    for _ in 0..5 {
        told.extend(step(&mut world));
    }
    assert!(matches!(told[..], [EventKind::Woke(_), EventKind::ContactEnded(t)] if t.shapes[1] == shape));
}

#[test]
fn what_was_removed_is_named_by_its_own_handles() {
    for asleep in [false, true] {
        let mut world = world(8);
        world.set_settings(&Settings { sleep_time: 0.25, ..Settings::default() }).expect("valid");
        let floor = ground(&mut world, 0.5);
        let zone = ShapeDef::sensor(Geometry::Sphere { radius: 2.0 });
        let sensor = world.create_shape(floor, &zone).expect("room");
        let (body, shape) = box_at(&mut world, 0.0, 0.5);
        run(&mut world, if asleep { 120 } else { 2 });
        assert_eq!(world.is_asleep(body), Ok(asleep));
        // The slots get new tenants twice, where the old one was.
        world.remove_body(body).expect("exists");
        let (second, _) = box_at(&mut world, 0.0, 0.5);
        world.remove_body(second).expect("exists");
        let (third, own) = box_at(&mut world, 0.0, 0.5);
        assert_eq!((third.index, own.index), (body.index, shape.index));
        let told = step(&mut world);
        let [
            EventKind::ContactEnded(ended),
            EventKind::ContactBegan(began),
            EventKind::SensorEnded(left),
            EventKind::SensorBegan(came),
        ] = told[..]
        else {
            panic!("asleep {asleep}: {told:?}");
        };
        assert_eq!((ended.shapes[1], ended.bodies[1]), (shape, body));
        assert_eq!((began.shapes[1], began.bodies[1]), (own, third));
        assert_eq!((left.sensor, left.visitor, left.visitor_body), (sensor, shape, body));
        assert_eq!((came.sensor, came.visitor, came.visitor_body), (sensor, own, third));
        assert!(!world.contains_shape(ended.shapes[1]) && !world.contains_body(left.visitor_body));
        // Nothing is told twice.
        assert_eq!(step(&mut world), []);
        world.remove_shape(sensor).expect("exists");
        let told = step(&mut world);
        assert!(matches!(told[..], [EventKind::SensorEnded(v)] if v.sensor == sensor && v.visitor == own));
    }
}

#[test]
fn only_who_asks_is_heard() {
    let mut world = world(8);
    ground(&mut world, 0.5);
    let quiet = ShapeDef { events: ShapeEvents::NONE, ..cube() };
    let (_, shape) = add(&mut world, &BodyDef::new(BodyKind::Dynamic, Vec3::Z * 0.5), &quiet);
    assert_eq!(step(&mut world), []);
    world.set_shape_events(shape, ShapeEvents::CONTACTS).expect("exists");
    assert_eq!(step(&mut world), [], "it has begun already");
    let body = world.body_of(shape).expect("exists");
    world.set_pose(body, Position::at(Vec3::Z * 5.0), Rotation::IDENTITY).expect("exists");
    assert!(matches!(step(&mut world)[..], [EventKind::ContactEnded(t)] if t.shapes[1] == shape));
    assert_eq!(world.set_shape_events(shape, ShapeEvents(4)), Err(Error::OutOfRange { name: "events" }));
    world.remove_shape(shape).expect("exists");
    assert_eq!(world.set_shape_events(shape, ShapeEvents::NONE), Err(Error::Stale { what: "shape" }));
    // The settings leave kinds out.
    let (_, shape) = box_at(&mut world, 3.0, 0.5);
    let settings = Settings { events: EventKinds::ALL.without(EventKinds::CONTACTS), ..world.settings() };
    world.set_settings(&settings).expect("valid");
    assert_eq!(step(&mut world), []);
    assert!(world.contacts().any(|contact| contact.shapes[1] == shape));
}

#[test]
fn a_joint_breaks_with_its_load() {
    let mut world = world(4);
    let fixed = world.create_body(&BodyDef::new(BodyKind::Static, Vec3::ZERO)).expect("room");
    let (body, _) = box_at(&mut world, 0.0, -2.0);
    let mass = world.mass_properties(body).expect("exists").mass;
    let frames = [Pose::IDENTITY, Pose { position: Vec3::Z * 2.0, ..Pose::IDENTITY }];
    let def = JointDef { break_force: 1.5 * mass * 9.81, ..JointDef::ball([fixed, body], frames) };
    let joint = world.create_joint(&def).expect("room");
    for _ in 0..30 {
        assert_eq!(step(&mut world), []);
    }
    world.apply_force(body, Vec3::Z * (-mass * 9.81)).expect("dynamic");
    let told = step(&mut world);
    let [EventKind::JointBroken(broken)] = told[..] else { panic!("{told:?}") };
    assert_eq!((broken.joint, broken.bodies), (joint, [fixed, body]));
    assert!((broken.force / (2.0 * mass * 9.81) - 1.0).abs() < 1.0e-3, "{}", broken.force);
    assert_eq!(world.is_broken(joint), Ok(true));
    assert_eq!(step(&mut world), []);
}

#[test]
fn who_leaves_the_world_is_quarantined() {
    let mut world = world(4);
    let edge = Position { sector: [1 << 29, 0, 0], offset: Vec3::ZERO };
    let def = BodyDef { position: edge, linear_velocity: Vec3::X * 6000.0, ..BodyDef::default() };
    let (body, _) = add(&mut world, &def, &cube());
    assert_eq!(step(&mut world), [EventKind::Quarantined(body)]);
    assert_eq!(world.is_quarantined(body), Ok(true));
    assert_eq!(step(&mut world), []);
}

#[test]
fn a_sleeper_that_becomes_something_else_has_woken() {
    for kind in [BodyKind::Static, BodyKind::Kinematic, BodyKind::Dynamic] {
        let mut world = world(8);
        world.set_settings(&Settings { sleep_time: 0.25, ..Settings::default() }).expect("valid");
        ground(&mut world, 0.5);
        let (low, _) = box_at(&mut world, 0.0, 0.5);
        let (high, _) = box_at(&mut world, 0.0, 1.5);
        run(&mut world, 120);
        assert_eq!((world.is_asleep(low), world.is_asleep(high)), (Ok(true), Ok(true)));
        world.set_kind(high, kind).expect("exists");
        let told = step(&mut world);
        let woken: Vec<_> = told.iter().filter(|kind| matches!(kind, EventKind::Woke(_))).collect();
        assert_eq!(woken, [&EventKind::Woke(low), &EventKind::Woke(high)], "{kind:?}");
        // With the only sleeper it is no other.
        let mut alone = self::world(2);
        alone
            .set_settings(&Settings { sleep_time: 0.25, gravity: Vec3::ZERO, ..Settings::default() })
            .expect("valid");
        let (body, _) = box_at(&mut alone, 0.0, 0.5);
        run(&mut alone, 60);
        assert_eq!(alone.is_asleep(body), Ok(true));
        alone.set_kind(body, kind).expect("exists");
        assert_eq!(step(&mut alone), [EventKind::Woke(body)]);
        assert_eq!(step(&mut alone), []);
    }
}

#[test]
fn a_step_without_length_has_no_events() {
    let mut world = world(4);
    ground(&mut world, 0.5);
    let (body, shape) = box_at(&mut world, 0.0, 0.5);
    assert_eq!(step(&mut world).len(), 1);
    let moving = world.settings();
    world.set_settings(&Settings { dt: 0.0, ..moving }).expect("valid");
    world.remove_body(body).expect("exists");
    assert_eq!(step(&mut world), []);
    world.set_settings(&moving).expect("valid");
    assert!(matches!(step(&mut world)[..], [EventKind::ContactEnded(t)] if t.shapes[1] == shape));
}

#[test]
fn something_immovable_put_into_a_sleeper_wakes_it_before_it_has_contacts() {
    let mut world = world(8);
    world.set_settings(&Settings { sleep_time: 0.25, ..Settings::default() }).expect("valid");
    ground(&mut world, 0.5);
    let (body, _) = box_at(&mut world, 0.0, 0.5);
    run(&mut world, 120);
    assert_eq!(world.is_asleep(body), Ok(true));
    // Other scratch than before: a sleeper's place in it is of long ago.
    let (other, _) = box_at(&mut world, 5.0, 0.5);
    add(&mut world, &BodyDef::new(BodyKind::Static, Vec3::new(0.99, 0.0, 0.5)), &cube());
    add(&mut world, &BodyDef::new(BodyKind::Kinematic, Vec3::new(-0.99, 0.0, 0.5)), &cube());
    let woken = step(&mut world);
    assert!(woken.contains(&EventKind::Woke(body)), "{woken:?}");
    assert_eq!(world.is_asleep(body), Ok(false));
    assert!(world.contacts().any(|contact| contact.bodies.contains(&other)));
    assert_eq!(world.contacts().filter(|contact| contact.bodies.contains(&body)).count(), 3);
}
