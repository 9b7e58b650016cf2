//! The answer of the sweeps against a direct method, on the solver's own rows.
//!
//! A and b of the talk (SEED S7) are formed from the rows of a step after assembly, in double precision. Dantzig's
//! method solves them exactly for given bounds; those of friction follow from the loads, and the disc from the
//! direction in which friction acts, so both are found by repetition. After enough sweeps ours is to be the same.

use cellstep::joint::axis::{TURN_X, X};
use cellstep::math::{Pose, Rotation, Vec3};
use cellstep::{
    Axis, BodyDef, BodyHandle, BodyKind, Capacities, ContactModel, Drive, FrictionModel, Geometry, JointDef,
    Settings, ShapeDef,
};
use cellstep_tests::direct::Seen;
use cellstep_tests::executors::Random;
use cellstep_tests::oracles::velocity;
use cellstep_tests::worlds::{OwnedWorld, add, ground, world_with};

/// Residual with which the sweeps end, m/s.
const TOLERANCE: f32 = 5.0e-8;
/// What it is at most when they do not, m/s: rounding.
const RESIDUAL: f32 = 4.0e-7;
/// Greatest difference, as a share of the greatest impulse or velocity: rounding.
const EXACT: f64 = 1.0e-5;

/// Many sweeps of one substep, and no relax sweeps: the rows of the first sweep are those of the last.
fn patient() -> Settings {
    Settings {
        contact_model: ContactModel::Rigid,
        substeps: 1,
        refine: 1,
        tolerance: TOLERANCE,
        sweeps_max: 1024,
        relax_sweeps: 0,
        restitution_threshold: 1.0e4,
        residual: true,
        ..Settings::default()
    }
}

fn scene(bodies: u32) -> OwnedWorld {
    let mut world = world_with(Capacities { joints: 32, ..Capacities::for_bodies(bodies + 1) });
    world.set_settings(&patient()).expect("in range");
    world
}

fn body(world: &mut OwnedWorld, place: Vec3, geometry: Geometry, friction: f32) -> BodyHandle {
    let shape = ShapeDef { friction, ..ShapeDef::new(geometry) };
    add(world, &BodyDef::new(BodyKind::Dynamic, place), &shape).0
}

/// Compares one step; `unique` when the rows do not depend on each other, so that each impulse counts.
fn compare(name: &str, world: &mut OwnedWorld, unique: bool) {
    let seen = Seen::step(world);
    assert!(!seen.rows.is_empty(), "{name}: rows");
    let (ours, exact) = (seen.ours(), seen.solve());
    let size = |values: &[f64]| values.iter().fold(f64::MIN_POSITIVE, |most, x| most.max(x.abs()));
    let difference =
        |a: &[f64], b: &[f64]| a.iter().zip(b).fold(0.0_f64, |most, (a, b)| most.max((a - b).abs()));
    let impulses = difference(&ours, &exact) / size(&exact);
    let [own, other] = [&ours, &exact].map(|answer| seen.velocities(answer).concat());
    let start = seen.velocities(&vec![0.0; ours.len()]).concat();
    let velocities = difference(&own, &other) / size(&start).max(size(&other));
    let loads = |answer: &[f64]| -> Vec<f64> {
        let links = seen.rows.iter().map(|row| row.link).max().unwrap_or(0);
        (0..=links).map(|link| seen.load(answer, link)).collect()
    };
    let load = difference(&loads(&ours), &loads(&exact)) / size(&exact);
    let residual = seen.report.residuals.expect("asked for").biased.greatest();
    println!(
        "{name}: {} rows, {} sweeps, residual {residual:.1e} m/s; impulses {impulses:.1e}, loads {load:.1e}, \
         velocities {velocities:.1e}",
        ours.len(),
        seen.report.sweeps,
    );
    assert!(velocities < EXACT && load < EXACT, "{name}: velocities {velocities}, loads {load}");
    assert!(!unique || impulses < EXACT, "{name}: impulses {impulses}");
    assert!(residual <= RESIDUAL, "{name}: residual {residual}");
    // The bodies have the velocities that the impulses make.
    for (i, body) in seen.bodies.iter().enumerate() {
        let handle = world.bodies().find(|handle| handle.index == body.slot).expect("it lives");
        let off = difference(&velocity(world, handle), &other[6 * i..6 * i + 3]) / size(&other);
        assert!(off < EXACT, "{name}: body {i} is off by {off}");
    }
}

/// Balls heaped on each other, some pressed in a little.
fn heap(friction: f32) -> OwnedWorld {
    let mut world = scene(24);
    ground(&mut world, friction);
    let mut random = Random::new(3);
    for layer in 0..3 {
        for i in 0..(3 - layer) * (3 - layer) {
            let (x, y) = ((i % (3 - layer)) as f32, (i / (3 - layer)) as f32);
            let at = |k: f32| 0.99 * k + 0.5 * layer as f32;
            let jitter = Vec3::new(random.between(-0.01, 0.01), random.between(-0.01, 0.01), 0.0);
            let place = Vec3::new(at(x), at(y), 0.499 + 0.7 * layer as f32) + jitter;
            let ball = body(&mut world, place, Geometry::Sphere { radius: 0.5 }, friction);
            let push = Vec3::new(random.between(-0.3, 0.3), random.between(-0.3, 0.3), -0.1);
            world.set_linear_velocity(ball, push).expect("dynamic");
        }
    }
    world
}

/// Boxes on each other, shifted, some of them pushed: all of them slide or hold clearly. Near the border between
/// both a friction of 0.4 has so slow a mode that f32 leaves 5e-5 of the velocities.
fn boxes(friction: f32) -> OwnedWorld {
    let mut world = scene(8);
    ground(&mut world, friction);
    let cube = Geometry::Box { half_extents: Vec3::splat(0.5) };
    for i in 0..3 {
        let place = Vec3::new(0.1 * i as f32, 0.07 * i as f32, 0.5 + 0.999 * i as f32);
        let handle = body(&mut world, place, cube, friction);
        let push = Vec3::new(0.4 * i as f32, 0.1, 0.0);
        world.set_linear_velocity(handle, push).expect("dynamic");
        world.set_angular_velocity(handle, Vec3::Z * (0.3 * i as f32)).expect("dynamic");
    }
    world
}

#[test]
fn frictionless_contacts_are_solved() {
    let mut world = heap(0.0);
    for _ in 0..3 {
        compare("balls", &mut world, true);
    }
    let mut world = boxes(0.0);
    for _ in 0..3 {
        compare("boxes", &mut world, false);
    }
}

#[test]
fn friction_is_solved() {
    let scenes = [heap(0.2), heap(0.8), boxes(0.2), boxes(0.3)];
    for (name, mut world) in ["balls", "rough balls", "boxes", "rough boxes"].into_iter().zip(scenes) {
        for _ in 0..3 {
            compare(name, &mut world, false);
        }
    }
}

/// Friction of each point by its own load. How the points of a box share what holds it is not unique, what they
/// give together is.
#[test]
fn friction_of_points_is_solved() {
    for (name, mut world) in [("balls", heap(0.2)), ("boxes", boxes(0.2)), ("rough boxes", boxes(0.3))] {
        let settings = Settings { friction_model: FrictionModel::Points, ..patient() };
        world.set_settings(&settings).expect("in range");
        for _ in 0..3 {
            compare(&format!("{name}, by points"), &mut world, false);
        }
    }
}

/// A frame at a place of a body, whose x axis is the world's y axis.
fn across(place: Vec3) -> Pose {
    Pose::new(place, Rotation::between(Vec3::X, Vec3::Y))
}

/// Cubes of 0.4 m in a row, joined by hinges about y from a fixed point on: limits, motors and friction on their
/// turns, in turn. The last lies on the ground.
fn arm(friction: f32) -> OwnedWorld {
    let mut world = scene(8);
    // Its impulses' last bits are worth this: more sweeps would only add to the rounding.
    world.set_settings(&Settings { tolerance: 3.0e-7, ..patient() }).expect("in range");
    let base = ground(&mut world, friction);
    let axes = [
        Axis::limited(-0.002, 0.003),
        Axis { drive: Some(Drive::motor(0.5, 20.0)), ..Axis::FREE },
        Axis { friction: 30.0, ..Axis::FREE },
        Axis { drive: Some(Drive::motor(-0.2, 1.0e4)), ..Axis::limited(-1.0, 1.0) },
        Axis::limited(-0.5, 0.001),
        Axis { friction: 1.0e4, ..Axis::FREE },
    ];
    let mut before = (base, Vec3::new(0.0, 0.0, 0.2));
    for (i, turn) in axes.into_iter().enumerate() {
        let heavy = if i == 3 { 2.0 } else { 1.0 };
        let lift = if i == 5 { 0.1995 } else { 0.3 };
        let place = Vec3::new(0.3 + 0.5 * i as f32, 0.0, lift);
        let cube = Geometry::Box { half_extents: Vec3::splat(0.2) };
        let shape = ShapeDef { friction, density: 1000.0 * heavy, ..ShapeDef::new(cube) };
        let (link, _) = add(&mut world, &BodyDef::new(BodyKind::Dynamic, place), &shape);
        world.set_linear_velocity(link, Vec3::new(0.0, 0.0, -0.05 * i as f32)).expect("dynamic");
        let middle = Vec3::new(0.05 + 0.5 * i as f32, 0.0, 0.25);
        let at = if i == 0 { Vec3::ZERO } else { before.1 };
        let frames = [across(middle - at), across(middle - place)];
        let mut def = JointDef::hinge([before.0, link], frames);
        def.axes[TURN_X] = turn;
        world.create_joint(&def).expect("room");
        before = (link, place);
    }
    world
}

/// Pairs of balls that a ball joint holds together, one pair across the other, on the ground: each joint alone.
fn pairs(friction: f32) -> OwnedWorld {
    let mut world = scene(16);
    ground(&mut world, friction);
    for i in 0..5 {
        let lift = Vec3::new(0.1 * i as f32, 0.05 * i as f32, 0.3 + 0.59 * i as f32);
        let half = Vec3::new(0.4, 0.1 * (i % 2) as f32, 0.0);
        let ball = Geometry::Sphere { radius: 0.3 };
        let ends = [lift - half, lift + half].map(|place| body(&mut world, place, ball, friction));
        let frames = [half, half * -1.0].map(|at| Pose::new(at, Rotation::IDENTITY));
        world.create_joint(&JointDef::ball(ends, frames)).expect("room");
        world.set_linear_velocity(ends[0], Vec3::new(0.2, 0.1, -0.3)).expect("dynamic");
    }
    world
}

/// A slider with a limit and a rope that is pulled.
fn ropes() -> OwnedWorld {
    let mut world = scene(4);
    let base = world.create_body(&BodyDef::new(BodyKind::Static, Vec3::ZERO)).expect("room");
    let car = body(&mut world, Vec3::ZERO, Geometry::Sphere { radius: 0.2 }, 0.5);
    let load = body(&mut world, Vec3::new(0.6, 0.0, -0.8), Geometry::Sphere { radius: 0.2 }, 0.5);
    let flat = |_| Pose::new(Vec3::ZERO, Rotation::IDENTITY);
    let mut def = JointDef::slider([base, car], [0, 1].map(flat));
    def.axes[X] = Axis { friction: 20.0, ..Axis::limited(-0.5, 0.004) };
    world.create_joint(&def).expect("room");
    world.create_joint(&JointDef::distance([car, load], [Vec3::ZERO; 2], 0.0, 1.001)).expect("room");
    world.set_linear_velocity(load, Vec3::new(1.0, 0.3, 0.0)).expect("dynamic");
    world
}

#[test]
fn joints_are_solved() {
    for (name, mut world) in
        [("arm", arm(0.4)), ("slippery arm", arm(0.0)), ("pairs", pairs(0.5)), ("slider and rope", ropes())]
    {
        for _ in 0..3 {
            compare(name, &mut world, false);
        }
    }
}
