//! Sensors: what is in them, against queries and against distances.

use cellstep::math::{Pose, Rotation, Vec3, length};
use cellstep::{
    BodyDef, BodyHandle, BodyKind, BodyKinds, Capacities, Error, EventKind, Filter, Geometry, Overlap,
    Position, QueryFilter, QueryShape, Ray, Region, Serial, Settings, ShapeDef, ShapeHandle,
};
use cellstep_tests::executors::Random;
use cellstep_tests::mixed::Draw;
use cellstep_tests::simulator::{EVENTFUL, Simulator};
use cellstep_tests::worlds::{OwnedWorld, add, ground, run, world_with};
use std::collections::BTreeSet;

/// How far a shape is moved to find out whether it just touches, metres.
const HAIR: f32 = 5.0e-5;

fn room(bodies: u32) -> Capacities {
    Capacities { events: 200, sensor_visits: 200, joints: 4, ..Capacities::for_bodies(bodies) }
}

fn visitors(world: &OwnedWorld, sensor: ShapeHandle) -> Vec<ShapeHandle> {
    world.visits(sensor).expect("exists").map(|visit| visit.visitor).collect()
}

fn place(world: &OwnedWorld, shape: ShapeHandle) -> (Position, Rotation) {
    let body = world.body_of(shape).expect("exists");
    let (position, rotation) = (world.position(body).expect("exists"), world.rotation(body).expect("exists"));
    let pose = world.shape(shape).expect("exists").pose;
    (position.plus(rotation.rotate(pose.position)), rotation.after(pose.rotation))
}

/// True when a query at a shape's place finds the other shape.
fn query_finds(world: &mut OwnedWorld, [shape, other]: [ShapeHandle; 2], shift: Vec3) -> bool {
    let geometry = world.shape(shape).expect("exists").geometry;
    let (position, rotation) = place(world, shape);
    let shape = QueryShape { geometry, position: position.plus(shift), rotation };
    let filter = QueryFilter { sensors: true, ..QueryFilter::ALL };
    let mut found = [Overlap::default(); 64];
    let count = world.queries().overlap_all(&Region::Shape(shape), &filter, &mut found).expect("valid").count;
    found[..count].iter().any(|overlap| overlap.shape == other)
}

/// Whether two shapes overlap; `None` when it is too close to tell.
fn overlap(world: &mut OwnedWorld, a: ShapeHandle, b: ShapeHandle) -> Option<bool> {
    let surface = |shape| world.shape(shape).expect("exists").geometry.is_surface();
    let pair = match (surface(a), surface(b)) {
        (true, true) => return Some(false),
        (true, false) => [b, a],
        _ => [a, b],
    };
    let shifts = [Vec3::ZERO, Vec3::X, -Vec3::X, Vec3::Y, -Vec3::Y, Vec3::Z, -Vec3::Z];
    let found = shifts.map(|shift| query_finds(world, pair, shift * HAIR));
    found.iter().all(|&each| each == found[0]).then_some(found[0])
}

fn detects(world: &OwnedWorld, sensor: ShapeHandle, other: ShapeHandle) -> bool {
    let (def, own) = (world.shape(sensor).expect("exists"), world.shape(other).expect("exists"));
    let (body, other_body) = (world.body_of(sensor).expect("exists"), world.body_of(other).expect("exists"));
    let Some(kinds) = def.sensor else { return false };
    own.sensor.is_none()
        && body != other_body
        && kinds.has(world.kind(other_body).expect("exists"))
        && def.filter.meets(&own.filter)
}

#[test]
fn visits_are_what_queries_find_after_every_step() {
    let (mut inside, mut outside, mut unclear) = (0, 0, 0);
    for seed in 200..220 {
        let (mut simulator, mut world) = Simulator::new(seed, EVENTFUL);
        for step in 0..120 {
            simulator.play(&mut world);
            world.step(&mut Serial);
            if world.settings().dt == 0.0 {
                continue;
            }
            let bodies: Vec<BodyHandle> = world.bodies().collect();
            let of = |world: &OwnedWorld, body| world.shapes_of(body).expect("exists").collect::<Vec<_>>();
            let shapes: Vec<ShapeHandle> = bodies.iter().flat_map(|&body| of(&world, body)).collect();
            for &sensor in &shapes {
                let told: BTreeSet<ShapeHandle> = visitors(&world, sensor).into_iter().collect();
                for &other in &shapes {
                    let found = match detects(&world, sensor, other) {
                        true => overlap(&mut world, sensor, other),
                        false => Some(false),
                    };
                    match found {
                        Some(found) => {
                            let case = (seed, step, sensor, other);
                            assert_eq!(told.contains(&other), found, "{case:?}");
                            inside += u32::from(found);
                            outside += u32::from(!found);
                        }
                        None => unclear += 1,
                    }
                }
            }
        }
    }
    assert!(inside > 1000 && outside > 10_000 && unclear < inside / 20, "{inside} {outside} {unclear}");
}

#[test]
fn balls_are_in_a_ball_by_their_distance() {
    let mut world = world_with(room(60));
    world.set_settings(&Settings { gravity: Vec3::ZERO, ..Settings::default() }).expect("valid");
    let mut random = Random::new(5);
    let far = Position { sector: [70_000, -3, 5], offset: Vec3::new(20.0, 0.0, 0.0) };
    let def = BodyDef { kind: BodyKind::Static, position: far, ..BodyDef::default() };
    let (_, sensor) = add(&mut world, &def, &ShapeDef::sensor(Geometry::Sphere { radius: 3.0 }));
    let balls: Vec<(BodyHandle, ShapeHandle, f32)> = (0..50)
        .map(|_| {
            let position = far.plus(random.vector(4.0));
            let def = BodyDef { position, linear_velocity: random.vector(2.0), ..BodyDef::default() };
            let radius = random.between(0.1, 0.5);
            let filter = Filter { group: -1, ..Filter::default() };
            let shape = ShapeDef { filter, ..ShapeDef::new(Geometry::Sphere { radius }) };
            let (body, shape) = add(&mut world, &def, &shape);
            (body, shape, radius)
        })
        .collect();
    let mut changes = 0;
    let mut before = Vec::new();
    for _ in 0..200 {
        world.step(&mut Serial);
        let told = visitors(&world, sensor);
        for &(body, shape, radius) in &balls {
            let way = length(world.position(body).expect("exists").minus(far));
            if (way - 3.0 - radius).abs() > 1.0e-4 {
                assert_eq!(told.contains(&shape), way < 3.0 + radius);
            }
        }
        changes += usize::from(told != before);
        before = told;
    }
    assert!(changes > 20, "{changes}");
}

#[test]
fn a_sensor_makes_no_contact_has_no_mass_and_keeps_nobody_awake() {
    let mut world = world_with(room(8));
    world.set_settings(&Settings { sleep_time: 0.25, ..Settings::default() }).expect("valid");
    ground(&mut world, 0.5);
    let cube = ShapeDef::new(Geometry::Box { half_extents: Vec3::splat(0.5) });
    let (body, shape) = add(&mut world, &BodyDef::new(BodyKind::Dynamic, Vec3::Z * 0.5), &cube);
    let mass = world.mass_properties(body);
    let zone = ShapeDef::sensor(Geometry::Sphere { radius: 3.0 });
    world.create_shape(body, &zone).expect("room");
    assert_eq!(world.mass_properties(body), mass);
    let heavy = ShapeDef { density: 1000.0, ..zone };
    let extra = world.create_shape(body, &heavy).expect("room");
    assert!(world.mass_properties(body).expect("exists").mass > mass.expect("exists").mass);
    world.remove_shape(extra).expect("exists");
    let (_, fixed) = add(&mut world, &BodyDef::new(BodyKind::Static, Vec3::Z), &zone);
    let def = BodyDef::new(BodyKind::Kinematic, Vec3::X * 2.0);
    let (lift, riding) = add(&mut world, &def, &zone);
    world.set_linear_velocity(lift, Vec3::new(0.0, 0.01, 0.0)).expect("moves");
    run(&mut world, 120);
    assert_eq!(world.is_asleep(body), Ok(true), "a kinematic sensor moves through it");
    assert_eq!(world.contacts().count(), 0);
    assert_eq!(world.sleeping_contacts().count(), 1);
    // The sleeper stays in both, and is there after they were away.
    assert_eq!((visitors(&world, fixed), visitors(&world, riding)), (vec![shape], vec![shape]));
    world.set_linear_velocity(lift, Vec3::X * 60.0).expect("moves");
    run(&mut world, 6);
    assert_eq!(visitors(&world, riding), vec![]);
    world.set_linear_velocity(lift, Vec3::X * -60.0).expect("moves");
    run(&mut world, 6);
    assert_eq!((visitors(&world, riding), world.is_asleep(body)), (vec![shape], Ok(true)));
}

#[test]
fn surfaces_are_sensors_too() {
    let mut world = world_with(room(4));
    let def = BodyDef::new(BodyKind::Static, Vec3::Z * 2.0);
    let (_, below) = add(&mut world, &def, &ShapeDef::sensor(Geometry::HalfSpace));
    let ball = ShapeDef::new(Geometry::Sphere { radius: 0.5 });
    let (body, shape) = add(&mut world, &BodyDef::new(BodyKind::Dynamic, Vec3::Z * 4.0), &ball);
    let mut came = None;
    for _ in 0..120 {
        world.step(&mut Serial);
        let z = world.position(body).expect("exists").offset.z;
        let is_in = visitors(&world, below) == vec![shape];
        assert_eq!(is_in, z <= 2.5);
        let began = world.events().any(|event| matches!(event.kind, EventKind::SensorBegan(_)));
        assert_eq!(began, is_in && came.is_none());
        if is_in && came.is_none() {
            came = Some(z);
        }
    }
    assert!(came.is_some());
}

#[test]
fn kinds_filters_and_sensors_are_left_out() {
    let mut world = world_with(room(8));
    world.set_settings(&Settings { gravity: Vec3::ZERO, ..Settings::default() }).expect("valid");
    let ball = Geometry::Sphere { radius: 0.5 };
    let bodies = [BodyKind::Static, BodyKind::Kinematic, BodyKind::Dynamic]
        .map(|kind| add(&mut world, &BodyDef::new(kind, Vec3::ZERO), &ShapeDef::new(ball)).1);
    let filter = Filter { category: 4, mask: 1, group: 0 };
    let masked = ShapeDef { filter: Filter { mask: 2, ..filter }, ..ShapeDef::new(ball) };
    add(&mut world, &BodyDef::new(BodyKind::Dynamic, Vec3::ZERO), &masked);
    let kinds = [BodyKinds::STATIC, BodyKinds::KINEMATIC, BodyKinds::DYNAMIC, BodyKinds::ALL];
    let all = kinds.map(|kinds| {
        let def = ShapeDef { sensor: Some(kinds), ..ShapeDef::sensor(ball) };
        let own = ShapeDef { filter: Filter { category: 4, ..filter }, ..def };
        add(&mut world, &BodyDef::new(BodyKind::Static, Vec3::ZERO), &own).1
    });
    world.step(&mut Serial);
    for (i, sensor) in all.into_iter().enumerate() {
        let expected = bodies.iter().enumerate().filter(|(k, _)| i == 3 || i == *k).map(|(_, shape)| *shape);
        assert_eq!(visitors(&world, sensor), expected.collect::<Vec<_>>());
    }
}

#[test]
fn rays_pass_through_sensors_unless_they_ask_for_them() {
    let mut world = world_with(room(2));
    let zone = ShapeDef::sensor(Geometry::Sphere { radius: 1.0 });
    let (_, sensor) = add(&mut world, &BodyDef::new(BodyKind::Static, Vec3::ZERO), &zone);
    let ray = Ray { origin: Position::at(Vec3::X * -5.0), translation: Vec3::X * 10.0 };
    assert_eq!(world.queries().cast_ray(&ray, &QueryFilter::ALL), Ok(None));
    let filter = QueryFilter { sensors: true, ..QueryFilter::ALL };
    let hit = world.queries().cast_ray(&ray, &filter).expect("valid").expect("there");
    assert_eq!((hit.shape, hit.distance), (sensor, 4.0));
}

#[test]
fn what_is_no_sensor_is_refused() {
    let mut none = world_with(Capacities::for_bodies(2));
    let body = none.create_body(&BodyDef::default()).expect("room");
    let zone = ShapeDef::sensor(Geometry::Sphere { radius: 1.0 });
    assert_eq!(none.create_shape(body, &zone), Err(Error::Full { name: "sensor_visits" }));
    let mut world = world_with(room(2));
    let body = world.create_body(&BodyDef::default()).expect("room");
    for bits in [0, 8, 255] {
        let def = ShapeDef { sensor: Some(BodyKinds(bits)), ..zone };
        assert_eq!(world.create_shape(body, &def), Err(Error::OutOfRange { name: "sensor" }));
    }
    let sensor = world.create_shape(body, &zone).expect("room");
    assert_eq!(world.shape(sensor), Ok(ShapeDef { pose: Pose::IDENTITY, ..zone }));
    world.remove_shape(sensor).expect("exists");
    assert_eq!(world.visits(sensor).err(), Some(Error::Stale { what: "shape" }));
}

/// Rows of the visits of a crowd: slots of sensor and visitor.
fn crowd(visits: u32, steps: u32) -> (Vec<[u32; 2]>, Vec<u32>) {
    let mut world = world_with(Capacities { sensor_visits: visits, ..room(80) });
    world
        .set_settings(&Settings { gravity: Vec3::ZERO, sleep_time: 0.25, ..Settings::default() })
        .expect("valid");
    let mut random = Random::new(9);
    for i in 0..20 {
        let kind = [BodyKind::Static, BodyKind::Kinematic][i % 2];
        let zone = ShapeDef::sensor(Geometry::Sphere { radius: 1.5 });
        add(&mut world, &BodyDef::new(kind, random.vector(3.0)), &zone);
    }
    for i in 0..50 {
        let velocity = if i % 3 == 0 { Vec3::ZERO } else { random.vector(3.0) };
        let def =
            BodyDef { linear_velocity: velocity, ..BodyDef::new(BodyKind::Dynamic, random.vector(3.0)) };
        let filter = Filter { group: -1, ..Filter::default() };
        let ball = ShapeDef { filter, ..ShapeDef::new(Geometry::Sphere { radius: 0.3 }) };
        add(&mut world, &def, &ball);
    }
    let mut dropped = Vec::new();
    let mut rows = Vec::new();
    for _ in 0..steps {
        dropped.push(world.step(&mut Serial).dropped_visits);
        let bodies: Vec<BodyHandle> = world.bodies().collect();
        for shape in bodies.iter().flat_map(|&body| world.shapes_of(body).expect("exists")) {
            rows.extend(world.visits(shape).expect("exists").map(|v| [v.sensor.index, v.visitor.index]));
        }
        rows.push([u32::MAX; 2]);
    }
    (rows, dropped)
}

#[test]
fn what_finds_no_room_are_the_last_ones_and_counted() {
    let (all, none) = crowd(2000, 60);
    assert!(none.iter().all(|&dropped| dropped == 0));
    for room in [1, 2, 7, 40] {
        let (some, dropped) = crowd(room, 60);
        let (all, some) = (all.split(|row| *row == [u32::MAX; 2]), some.split(|row| *row == [u32::MAX; 2]));
        let mut cut = 0;
        for ((all, some), dropped) in all.zip(some).zip(dropped) {
            let kept = all.len().min(room as usize);
            assert_eq!((some, dropped as usize), (&all[..kept], all.len() - kept));
            cut += u32::from(dropped > 0);
        }
        assert!(cut > 5, "room for {room}: {cut}");
    }
}

#[test]
fn a_body_that_is_quarantined_stays_where_it_is_seen() {
    let mut world = world_with(room(4));
    world
        .set_settings(&Settings { sleep_time: 0.1, gravity: Vec3::ZERO, ..Settings::default() })
        .expect("valid");
    let edge = Position { sector: [1 << 29, 0, 0], offset: Vec3::ZERO };
    let at = |kind| BodyDef { position: edge, kind, ..BodyDef::default() };
    let (_, sensor) =
        add(&mut world, &at(BodyKind::Static), &ShapeDef::sensor(Geometry::Sphere { radius: 60.0 }));
    let all =
        ShapeDef { sensor: Some(BodyKinds::ALL), ..ShapeDef::sensor(Geometry::Sphere { radius: 60.0 }) };
    let (_, every) = add(&mut world, &at(BodyKind::Static), &all);
    let ball = ShapeDef::new(Geometry::Sphere { radius: 0.5 });
    let (body, shape) = add(&mut world, &at(BodyKind::Dynamic), &ball);
    run(&mut world, 20);
    assert_eq!(world.is_asleep(body), Ok(true));
    assert_eq!((visitors(&world, sensor), visitors(&world, every)), (vec![shape], vec![shape]));
    // It wakes and leaves the world in the same step: from now on it is a static body, where it was.
    world.set_linear_velocity(body, Vec3::X * 6000.0).expect("dynamic");
    for _ in 0..3 {
        world.step(&mut Serial);
        assert_eq!(world.is_quarantined(body), Ok(true));
        assert_eq!((visitors(&world, sensor), visitors(&world, every)), (vec![], vec![shape]));
        assert!(query_finds(&mut world, [every, shape], Vec3::ZERO));
    }
}
