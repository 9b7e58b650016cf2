//! Hits: how fast, how hard and where.

use cellstep::math::{Vec3, length};
use cellstep::{
    BodyDef, BodyHandle, BodyKind, Capacities, ContactHit, EventKind, Geometry, Serial, Settings, ShapeDef,
    ShapeEvents,
};
use cellstep_tests::worlds::{OwnedWorld, add, world_with};

fn empty(bodies: u32, settings: &Settings) -> OwnedWorld {
    let mut world = world_with(Capacities { events: 64, ..Capacities::for_bodies(bodies) });
    world.set_settings(settings).expect("valid");
    world
}

fn loud(geometry: Geometry) -> ShapeDef {
    ShapeDef { events: ShapeEvents::HITS, ..ShapeDef::new(geometry) }
}

fn hits(world: &OwnedWorld) -> Vec<ContactHit> {
    let hit = |kind| match kind {
        EventKind::ContactHit(hit) => Some(hit),
        _ => None,
    };
    world.events().filter_map(|event| hit(event.kind)).collect()
}

/// Drops a body and returns its first hit with what it was and its velocity before and after.
fn drop(world: &mut OwnedWorld, body: BodyHandle) -> (ContactHit, Vec3, Vec3) {
    for _ in 0..200 {
        let before = world.linear_velocity(body).expect("exists");
        world.step(&mut Serial);
        if let [hit, ..] = hits(world)[..] {
            return (hit, before, world.linear_velocity(body).expect("exists"));
        }
    }
    panic!("no hit");
}

#[test]
fn a_ball_hits_the_ground_with_its_momentum() {
    for (substeps, restitution) in [(1, 0.0), (4, 0.0), (8, 0.0), (4, 0.7), (1, 1.0)] {
        let settings = Settings { substeps, ..Settings::default() };
        let mut world = empty(2, &settings);
        let (floor, _) =
            add(&mut world, &BodyDef::new(BodyKind::Static, Vec3::ZERO), &ShapeDef::new(Geometry::HalfSpace));
        let shape = ShapeDef { restitution, ..loud(Geometry::Sphere { radius: 0.5 }) };
        let (body, ball) =
            add(&mut world, &BodyDef::new(BodyKind::Dynamic, Vec3::new(1.0, 2.0, 3.0)), &shape);
        let (hit, before, after) = drop(&mut world, body);
        assert_eq!(hit.touching.shapes[1], ball);
        assert_eq!(hit.touching.bodies, [floor, body]);
        assert!(length(hit.normal - Vec3::Z) < 1.0e-6);
        assert!((hit.speed + before.z).abs() < 1.0e-4, "{} {before}", hit.speed);
        let mass = world.mass_properties(body).expect("exists").mass;
        // What gravity gave in the step went into the ground as well.
        let expected = mass * (after.z - before.z + 9.81 * settings.dt);
        assert!((hit.impulse / expected - 1.0).abs() < 1.0e-3, "{} {expected}", hit.impulse);
        // On the line of contact, between the ball at the start of the step and the ground.
        let point = hit.point.offset;
        assert!((point.x - 1.0).abs() < 1.0e-5 && (point.y - 2.0).abs() < 1.0e-5, "{point}");
        assert!(point.z >= 0.0 && point.z <= -before.z * settings.dt, "{point}");
        // One blow is one hit.
        world.step(&mut Serial);
        assert_eq!(hits(&world), []);
    }
}

#[test]
fn two_bodies_hit_along_their_normal() {
    let settings = Settings { gravity: Vec3::ZERO, ..Settings::default() };
    let mut world = empty(2, &settings);
    let fast = BodyDef { linear_velocity: Vec3::X * 5.0, ..BodyDef::new(BodyKind::Dynamic, Vec3::X * -2.0) };
    let cube = loud(Geometry::Box { half_extents: Vec3::splat(0.5) });
    let (a, _) = add(&mut world, &fast, &ShapeDef { friction: 0.0, ..cube });
    let slow = BodyDef { linear_velocity: Vec3::X * -1.0, ..BodyDef::new(BodyKind::Dynamic, Vec3::ZERO) };
    let quiet = ShapeDef { events: ShapeEvents::NONE, friction: 0.0, ..cube };
    let (b, _) = add(&mut world, &slow, &quiet);
    let (hit, before, after) = drop(&mut world, a);
    assert_eq!(hit.touching.bodies, [a, b]);
    assert!((hit.speed - 6.0).abs() < 1.0e-4 && length(hit.normal - Vec3::X) < 1.0e-5);
    let mass = world.mass_properties(a).expect("exists").mass;
    let expected = mass * (before.x - after.x);
    assert!((hit.impulse / expected - 1.0).abs() < 1.0e-3, "{} {expected}", hit.impulse);
}

#[test]
fn slow_ones_are_no_hits_and_resting_ones_neither() {
    let mut world = empty(3, &Settings::default());
    add(&mut world, &BodyDef::new(BodyKind::Static, Vec3::ZERO), &loud(Geometry::HalfSpace));
    let cube = loud(Geometry::Box { half_extents: Vec3::splat(0.5) });
    add(&mut world, &BodyDef::new(BodyKind::Dynamic, Vec3::new(0.0, 0.0, 0.5)), &cube);
    // Falls 3 cm: 0.77 m/s.
    let (falls, _) = add(&mut world, &BodyDef::new(BodyKind::Dynamic, Vec3::new(3.0, 0.0, 0.53)), &cube);
    for _ in 0..120 {
        world.step(&mut Serial);
        assert_eq!(hits(&world), []);
    }
    // Half a metre: 3.1 m/s.
    world.apply_impulse(falls, Vec3::Z * 3130.0).expect("dynamic");
    let (hit, ..) = drop(&mut world, falls);
    assert!((hit.speed - 3.1).abs() < 0.2, "{}", hit.speed);
    assert_eq!(hits(&world).len(), 1);
}

#[test]
fn a_kinematic_hammer_hits_with_its_speed() {
    let settings = Settings { gravity: Vec3::ZERO, hit_speed: 2.0, ..Settings::default() };
    let mut world = empty(2, &settings);
    let def = BodyDef {
        angular_velocity: Vec3::Z * 4.0,
        ..BodyDef::new(BodyKind::Kinematic, Vec3::new(0.0, -2.0, 0.0))
    };
    let arm = Geometry::Box { half_extents: Vec3::new(2.0, 0.1, 0.1) };
    let (_, _) = add(&mut world, &def, &ShapeDef::new(arm));
    let ball = loud(Geometry::Sphere { radius: 0.25 });
    let (body, _) = add(&mut world, &BodyDef::new(BodyKind::Dynamic, Vec3::new(1.5, -1.2, 0.0)), &ball);
    let (hit, before, after) = drop(&mut world, body);
    // The arm's point goes at 4 rad/s times its distance from the axis.
    let lever = hit.point.offset - Vec3::new(0.0, -2.0, 0.0);
    let expected = Vec3::Z.cross(lever).dot(hit.normal) * 4.0;
    assert!((hit.speed - expected).abs() < 1.0e-2 && hit.speed > 4.0, "{} {expected}", hit.speed);
    let mass = world.mass_properties(body).expect("exists").mass;
    let gain = (after - before).dot(hit.normal) * mass;
    assert!((hit.impulse / gain - 1.0).abs() < 0.05, "{} {gain}", hit.impulse);
}
