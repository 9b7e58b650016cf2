//! Settled contacts as their user sees them: points that are kept from step to step carry, slide and tip as points
//! that are found anew in each, and whoever comes late finds the same.

use cellstep::config::MANIFOLD_DRIFT;
use cellstep::math::{PI, Pose, Rotation, Vec3, cos, sin};
use cellstep::scene::builtin::Builtin;
use cellstep::{
    BodyDef, BodyHandle, BodyKind, Capacities, Error, Geometry, MassProperties, MaterialTraits, Position,
    Serial, Settings, ShapeDef, ShapeHandle,
};
use cellstep_tests::executors::Random;
use cellstep_tests::oracles::{GRAVITY, Wide, center, judge, minus, momenta, norm, plus, relative, velocity};
use cellstep_tests::simulator::snapshot;
use cellstep_tests::worlds::{OwnedWorld, add, ground, run, world, world_with};
use std::path::Path;

const CUBE: Geometry = Geometry::Box { half_extents: Vec3::splat(0.5) };
/// Of the default settings.
const STEPS_PER_SECOND: u32 = 60;

fn built(name: &str, size: u32) -> OwnedWorld {
    let scene = Builtin::find(name).expect("a built-in scene").scene(size).expect("in range");
    scene.build(Path::new(".")).expect("built-in scenes build").world
}

/// The greatest way of any dynamic body of a scene in 20 seconds, metres, along each axis.
fn drift(name: &str, size: u32) -> Wide {
    let mut world = built(name, size);
    let bodies: Vec<BodyHandle> =
        world.bodies().filter(|&body| world.kind(body) == Ok(BodyKind::Dynamic)).collect();
    let start: Vec<Wide> = bodies.iter().map(|&body| center(&world, body)).collect();
    let mut most = [0.0_f64; 3];
    for step in 1..=20 * STEPS_PER_SECOND {
        world.step(&mut Serial);
        if step % 30 == 0 {
            for (&body, &from) in bodies.iter().zip(&start) {
                let way = minus(center(&world, body), from);
                most = core::array::from_fn(|axis| most[axis].max(way[axis].abs()));
            }
        }
    }
    most
}

#[test]
fn a_tower_of_forty_stands() {
    let [x, y, _] = drift("tower", 40);
    judge("tower of 40, drift in 20 s, m", x.hypot(y), [1.0e-4, 5.0e-3]);
}

/// 60 m high and 1 m thick. In its plane it spreads as the contacts take up the load; across the plane it sways,
/// and stands as long as it sways by less than half a box.
#[test]
fn a_pyramid_of_sixty_rows_stands() {
    let [x, y, z] = drift("pyramid", 60);
    judge("pyramid of 60 rows, drift in its plane in 20 s, m", x, [1.0e-2, 5.0e-2]);
    judge("pyramid of 60 rows, sway across its plane in 20 s, m", y, [5.0e-2, 0.5]);
    judge("pyramid of 60 rows, sinks in 20 s, m", z, [0.25, 0.3]);
}

/// Points, impulses and ordering are found again after every step, and after going back.
#[test]
fn what_is_forgotten_is_found_again() {
    for (name, size) in [("tower", 20), ("pyramid", 20), ("mixed_pile", 200)] {
        let (mut kept, mut dropped, mut restored) = (built(name, size), built(name, size), built(name, size));
        for step in 0..300 {
            dropped.drop_caches();
            if step % 7 == 0 {
                let saved = snapshot(&restored);
                run(&mut restored, 2);
                restored.restore(&saved).expect("its own snapshot");
            }
            let report = kept.step(&mut Serial);
            assert_eq!(dropped.step(&mut Serial), report, "{name}, step {step}");
            assert_eq!(restored.step(&mut Serial), report, "{name}, step {step}");
            assert!(dropped.state() == kept.state(), "{name}: caches dropped, step {step}");
            assert!(restored.state() == kept.state(), "{name}: restored, step {step}");
        }
    }
}

/// Sums over all bodies: linear and angular momentum, and the sizes of the linear ones.
fn sums(world: &OwnedWorld, bodies: &[BodyHandle]) -> (Wide, Wide, f64) {
    bodies.iter().fold(([0.0; 3], [0.0; 3], 0.0), |(p, l, size), &body| {
        let (linear, angular) = momenta(world, body);
        (plus(p, linear, 1.0), plus(l, angular, 1.0), size + norm(linear))
    })
}

/// Boxes that touch, press and slide at centimetres per second, far below what would unsettle their contacts.
#[test]
fn a_slow_lump_keeps_its_momentum() {
    let mut world = world(27);
    world.set_settings(&Settings { gravity: Vec3::ZERO, ..Settings::default() }).expect("valid");
    let mut random = Random::new(3);
    let mut bodies = Vec::new();
    for i in 0..27 {
        let place = Vec3::new((i % 3) as f32, (i / 3 % 3) as f32, (i / 9) as f32) - Vec3::ONE;
        let mut any = || random.between(-0.02, 0.02);
        let def = BodyDef {
            rotation: Rotation::from_rotation_vector(Vec3::new(any(), any(), any())),
            // Inwards, and around: as a whole they turn.
            linear_velocity: place * -0.1
                + Vec3::new(0.1, 0.0, 0.2).cross(place)
                + Vec3::new(any(), any(), any()),
            angular_velocity: Vec3::new(0.1, 0.0, 0.2),
            ..BodyDef::new(BodyKind::Dynamic, place * 1.03)
        };
        bodies.push(add(&mut world, &def, &ShapeDef::new(CUBE)).0);
    }
    let (p, l, size) = sums(&world, &bodies);
    let (mut linear, mut angular, mut contacts) = (0.0_f64, 0.0_f64, 0);
    for _ in 0..600 {
        contacts += world.step(&mut Serial).contacts;
        let (q, m, _) = sums(&world, &bodies);
        linear = linear.max(norm(minus(q, p)) / size);
        // The boxes are one metre large.
        angular = angular.max(norm(minus(m, l)) / size);
    }
    assert!(contacts > 20 * 600, "{contacts} contacts");
    judge("slow lump, linear momentum", linear, [1.0e-6, 1.0e-5]);
    judge("slow lump, angular momentum", angular, [1.0e-5, 1.0e-3]);
}

/// A box of 1 m slides over the edge of a table without friction, so many metres in a step. Where its center is,
/// past the edge, when it has tilted by a thousandth.
fn tips_at(way: f32) -> f64 {
    let mut world = world(2);
    let smooth = |geometry| ShapeDef { friction: 0.0, ..ShapeDef::new(geometry) };
    let table = Geometry::Box { half_extents: Vec3::new(2.0, 2.0, 0.5) };
    add(&mut world, &BodyDef::new(BodyKind::Static, Vec3::new(-2.0, 0.0, -0.5)), &smooth(table));
    let (cube, _) =
        add(&mut world, &BodyDef::new(BodyKind::Dynamic, Vec3::new(-0.1, 0.0, 0.5)), &smooth(CUBE));
    run(&mut world, 60);
    world.set_linear_velocity(cube, Vec3::X * (way * STEPS_PER_SECOND as f32)).expect("dynamic");
    for _ in 0..(0.2 / way) as u32 {
        world.step(&mut Serial);
        let turn = world.rotation(cube).expect("it exists").imaginary();
        if 4.0 * turn.dot(turn) > 1.0e-6 {
            assert!(turn.y > 0.0, "it tips over the edge: {turn}");
            return center(&world, cube)[0];
        }
    }
    panic!("it does not tip");
}

/// From when the center passes it takes a moment to tilt: 10 mm at 60 mm/s. Slower boxes turn round: the softness
/// of the contact tilts them by 1e-4 as they lean on the edge, and that is a slope of 1.4 mm/s2.
#[test]
fn a_box_that_slides_over_an_edge_tips_when_its_center_passes() {
    for millimetres in [1.0, 0.5] {
        let place = tips_at(1.0e-3 * millimetres);
        println!("{millimetres} mm per step: tips with its center {:.1} mm past the edge", 1.0e3 * place);
        judge("share of its length", place.abs(), [1.5e-2, 2.0e-2]);
    }
}

/// A plank turns by half a degree per second under a box.
#[test]
fn a_box_on_a_tilting_ramp_slides_at_the_friction_angle() {
    let rough = |geometry| ShapeDef { friction: 0.4, ..ShapeDef::new(geometry) };
    let mut world = world(2);
    let start = 17.0 * PI / 180.0;
    let rotation = Rotation::from_axis_angle(Vec3::Y, start);
    let plank = BodyDef { rotation, ..BodyDef::new(BodyKind::Kinematic, Vec3::ZERO) };
    let (plank, _) =
        add(&mut world, &plank, &rough(Geometry::Box { half_extents: Vec3::new(4.0, 2.0, 0.1) }));
    let place = Vec3::new(sin(start), 0.0, cos(start)) * 0.6;
    let def = BodyDef { rotation, ..BodyDef::new(BodyKind::Dynamic, place) };
    let (cube, _) = add(&mut world, &def, &rough(CUBE));
    run(&mut world, 120);
    let rate = PI / 360.0;
    world.set_angular_velocity(plank, Vec3::Y * rate).expect("kinematic");
    let mut degrees = 17.0;
    // Beside the plank's own motion: that of a point of it at the cube's center.
    let sliding = |world: &OwnedWorld| {
        let p = center(world, cube);
        norm(minus(velocity(world, cube), [p[2] * f64::from(rate), 0.0, -p[0] * f64::from(rate)]))
    };
    run(&mut world, 10);
    assert!(sliding(&world) < 1.0e-3, "it sticks at first: {} m/s", sliding(&world));
    let mut steps = 10;
    while sliding(&world) < 0.02 && steps < 1_200 {
        world.step(&mut Serial);
        steps += 1;
        degrees = 17.0 + 0.5 * f64::from(steps) / f64::from(STEPS_PER_SECOND);
    }
    let expected = 0.4_f64.atan().to_degrees();
    // From the angle of friction on it takes 0.3 degrees to become that fast.
    println!("slides at {degrees:.2} degrees, friction angle {expected:.2}");
    judge("tilting ramp, degrees from the friction angle", (degrees - expected).abs(), [0.5, 1.0]);
}

/// A cube on a cube on the ground, at rest.
fn two_cubes() -> (OwnedWorld, [(BodyHandle, ShapeHandle); 2]) {
    let mut world = world(3);
    ground(&mut world, 0.6);
    let cubes = [0.5, 1.5].map(|z| {
        add(&mut world, &BodyDef::new(BodyKind::Dynamic, Vec3::new(0.0, 0.0, z)), &ShapeDef::new(CUBE))
    });
    run(&mut world, 120);
    (world, cubes)
}

/// Force between two shapes, N; 0 when they do not touch.
fn force(world: &OwnedWorld, shapes: [ShapeHandle; 2]) -> f64 {
    let of = world.contacts().find(|contact| contact.shapes == shapes);
    of.map_or(0.0, |contact| f64::from(contact.normal_force()))
}

fn mass_with_center(mass: f32, center: Vec3) -> MassProperties {
    MassProperties { mass, center, inertia: Vec3::splat(mass / 6.0), axes: Rotation::IDENTITY }
}

#[test]
fn a_changed_mass_is_carried() {
    let (mut world, [lower, upper]) = two_cubes();
    let pair = [lower.1, upper.1];
    judge("force before", relative(force(&world, pair), 1_000.0 * GRAVITY), [1.0e-3, 1.0e-2]);
    // Heavier, and its center aside, but over the cube below.
    world.set_mass(upper.0, Some(&mass_with_center(3_000.0, Vec3::new(0.2, -0.1, 0.0)))).expect("valid");
    run(&mut world, 240);
    judge("force of thrice the mass", relative(force(&world, pair), 3_000.0 * GRAVITY), [1.0e-3, 1.0e-2]);
    let speed = norm(velocity(&world, upper.0));
    assert!(speed < 1.0e-3, "it still moves at {speed} m/s");
    let tilt = world.rotation(upper.0).expect("it exists").imaginary();
    assert!(tilt.dot(tilt) < 1.0e-4, "it stands: {tilt}");
    // Beyond the edge of the cube below it tips.
    world.set_mass(upper.0, Some(&mass_with_center(3_000.0, Vec3::new(0.6, 0.0, 0.0)))).expect("valid");
    run(&mut world, 240);
    let low = world.center(upper.0).expect("it exists").to_f64()[2];
    assert!(low < 1.0, "it fell off: its center is at {low} m");
}

#[test]
fn a_changed_geometry_rests_on_its_own_surface() {
    let (mut world, [lower, upper]) = two_cubes();
    let low = Geometry::Box { half_extents: Vec3::new(0.5, 0.5, 0.2) };
    let sphere = Geometry::Sphere { radius: 0.3 };
    for (geometry, height) in [(low, 0.2), (sphere, 0.3), (CUBE, 0.5), (low, 0.2)] {
        world.set_geometry(upper.1, &geometry, &Pose::IDENTITY).expect("convex");
        let overlap = center(&world, upper.0)[2] - center(&world, lower.0)[2] - 0.5 - height;
        run(&mut world, 240);
        let (a, b) = (center(&world, lower.0), center(&world, upper.0));
        let gap = b[2] - a[2] - 0.5 - height;
        println!("{geometry:?}: {:.2} mm apart at first, {:.2} mm at rest", 1.0e3 * overlap, 1.0e3 * gap);
        assert!(gap.abs() < 2.0e-3, "{geometry:?} rests {gap} m above the cube");
        let weight = f64::from(world.mass_properties(upper.0).expect("it exists").mass) * GRAVITY;
        judge("its force", relative(force(&world, [lower.1, upper.1]), weight), [1.0e-3, 1.0e-2]);
        assert!(norm(velocity(&world, upper.0)) < 1.0e-3, "{geometry:?} rests");
    }
}

#[test]
fn a_body_put_elsewhere_has_no_contact_where_it_was() {
    let (mut world, [lower, upper]) = two_cubes();
    world.set_pose(upper.0, Position::at(Vec3::new(3.0, 0.0, 0.5)), Rotation::IDENTITY).expect("valid");
    world.step(&mut Serial);
    assert_eq!(force(&world, [lower.1, upper.1]), 0.0);
    run(&mut world, 120);
    judge("height on the ground, m", (center(&world, upper.0)[2] - 0.5).abs(), [1.0e-3, 2.0e-3]);
    // A kinematic cube that goes away leaves the other without support.
    world.set_pose(upper.0, Position::at(Vec3::new(0.0, 0.0, 1.5)), Rotation::IDENTITY).expect("valid");
    run(&mut world, 60);
    world.set_kind(lower.0, BodyKind::Kinematic).expect("convex");
    run(&mut world, 60);
    judge(
        "force on a kinematic cube",
        relative(force(&world, [lower.1, upper.1]), 1_000.0 * GRAVITY),
        [1.0e-3, 1.0e-2],
    );
    world.remove_body(lower.0).expect("it exists");
    run(&mut world, 120);
    judge("height after the fall, m", (center(&world, upper.0)[2] - 0.5).abs(), [1.0e-3, 2.0e-3]);
}

/// Cubes on a static table, stacked and beside each other, some pushed a little: settled contacts everywhere. A
/// surface that moves by nothing that counts keeps contacts from settling.
fn stacks(manifold_drift: f32, surface: f32) -> OwnedWorld {
    let mut world = world_with(Capacities { materials: 1, ..Capacities::for_bodies(40) });
    world.set_settings(&Settings { manifold_drift, ..Settings::default() }).expect("in range");
    let shape = |geometry| {
        let shape = ShapeDef { friction: 0.5, ..ShapeDef::new(geometry) };
        let traits = MaterialTraits { surface_velocity: Vec3::X * surface, ..shape.traits };
        ShapeDef { traits, ..shape }
    };
    let table = Geometry::Box { half_extents: Vec3::new(8.0, 8.0, 0.5) };
    add(&mut world, &BodyDef::new(BodyKind::Static, Vec3::Z * -0.5), &shape(table));
    let mut random = Random::new(17);
    for i in 0..36 {
        let mut any = || random.between(-0.02, 0.02);
        let place = Vec3::new(1.02 * (i % 3) as f32 + any(), 1.02 * (i / 3 % 3) as f32 + any(), 0.5);
        let def = BodyDef {
            linear_velocity: Vec3::new(any(), any(), 0.0),
            ..BodyDef::new(BodyKind::Dynamic, place + Vec3::Z * (i / 9) as f32)
        };
        add(&mut world, &def, &shape(CUBE));
    }
    world
}

/// Where all bodies are and how they move, to the bit.
fn motion(world: &OwnedWorld) -> Vec<[u64; 6]> {
    let of = |body| {
        let (p, v) = (center(world, body), velocity(world, body));
        [p[0], p[1], p[2], v[0], v[1], v[2]].map(f64::to_bits)
    };
    world.bodies().map(of).collect()
}

#[test]
fn without_drift_every_manifold_is_found_anew() {
    // A contact with a surface that moves never settles, and a speed as small as this is none.
    let (mut none, mut fresh, mut kept) =
        (stacks(0.0, 0.0), stacks(MANIFOLD_DRIFT, 1.0e-37), stacks(MANIFOLD_DRIFT, 0.0));
    for world in [&mut none, &mut fresh, &mut kept] {
        run(world, 90);
    }
    assert!(motion(&none) == motion(&fresh), "0 m: as contacts that do not settle");
    assert!(motion(&none) != motion(&kept), "there are some that would");
}

#[test]
fn any_drift_carries_and_is_found_again() {
    for drift in [0.0, 1.0e-4, 1.0e-3, MANIFOLD_DRIFT] {
        let (mut kept, mut dropped) = (stacks(drift, 0.0), stacks(drift, 0.0));
        let mut loaded = stacks(MANIFOLD_DRIFT, 0.0);
        for step in 0..120 {
            dropped.drop_caches();
            if step % 10 == 0 {
                loaded.load(&snapshot(&kept)).expect("its own");
                assert_eq!(loaded.settings().manifold_drift, drift);
            }
            for world in [&mut kept, &mut dropped, &mut loaded] {
                world.step(&mut Serial);
            }
            assert!(dropped.state() == kept.state(), "{drift} m: caches dropped, step {step}");
            assert!(loaded.state() == kept.state(), "{drift} m: loaded, step {step}");
        }
        let deepest = kept.bodies().map(|body| center(&kept, body)[2]).fold(f64::INFINITY, f64::min);
        assert!(kept.contacts().count() >= 36 && deepest > -0.51, "{drift} m: they stand");
    }
}

/// The setting changes while contacts are settled: they go on from where they are.
#[test]
fn the_drift_changes_under_way() {
    let mut world = stacks(MANIFOLD_DRIFT, 0.0);
    run(&mut world, 240);
    let start: Vec<Wide> = world.bodies().map(|body| center(&world, body)).collect();
    for step in 0..120 {
        let manifold_drift = [0.0, 2.0e-3, MANIFOLD_DRIFT][step % 3];
        world.set_settings(&Settings { manifold_drift, ..world.settings() }).expect("in range");
        world.step(&mut Serial);
    }
    let ways = world.bodies().zip(&start).map(|(body, &from)| norm(minus(center(&world, body), from)));
    judge("way while the drift changes, m", ways.fold(0.0, f64::max), [1.0e-3, 5.0e-3]);
}

#[test]
fn a_drift_out_of_range_is_refused() {
    let mut world = world(1);
    let before = world.settings();
    for manifold_drift in [-1.0e-3, 5.1e-3, f32::NAN, f32::INFINITY] {
        let name = "manifold_drift";
        let error =
            if manifold_drift.is_finite() { Error::OutOfRange { name } } else { Error::NotFinite { name } };
        assert_eq!(world.set_settings(&Settings { manifold_drift, ..before }), Err(error));
    }
    assert_eq!(world.settings(), before);
}
