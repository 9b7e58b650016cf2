//! Shapes of jointed bodies: whether they meet, breaking, and joints among contacts.

use cellstep::joint::axis::TURN_X;
use cellstep::math::{Pose, Rotation, Vec3};
use cellstep::{
    Axis, BodyDef, BodyHandle, BodyKind, Capacities, Geometry, JointDef, JointHandle, Serial, ShapeDef,
};
use cellstep_tests::jointed::{at, ball, force, gap, jointed, massive, rod};
use cellstep_tests::oracles::{GRAVITY, center, norm, spin, velocity};
use cellstep_tests::worlds::{self, OwnedWorld, add, run};

fn room(bodies: u32) -> OwnedWorld {
    worlds::world_with(Capacities { joints: bodies, ..Capacities::for_bodies(bodies) })
}

/// Two balls that overlap, weightless, with a ball joint between them.
fn overlapping(bodies_collide: bool) -> (OwnedWorld, [BodyHandle; 2], JointHandle) {
    let mut world = room(4);
    let mut settings = world.settings();
    settings.gravity = Vec3::ZERO;
    world.set_settings(&settings).expect("in range");
    let shape = ShapeDef::new(Geometry::Sphere { radius: 0.5 });
    let bodies = [0.0, 0.9]
        .map(|x| add(&mut world, &BodyDef::new(BodyKind::Dynamic, Vec3::new(x, 0.0, 0.0)), &shape).0);
    let frames = [at(Vec3::new(0.45, 0.0, 0.0)), at(Vec3::new(-0.45, 0.0, 0.0))];
    let def = JointDef { bodies_collide, ..JointDef::ball(bodies, frames) };
    let joint = world.create_joint(&def).expect("room");
    (world, bodies, joint)
}

#[test]
fn joined_bodies_meet_only_when_they_are_to() {
    let (mut world, _, joint) = overlapping(true);
    assert_eq!(world.step(&mut Serial).contacts, 1);
    // Changed while they touch, and back again.
    let mut def = world.joint(joint).expect("it exists");
    for bodies_collide in [false, true, false] {
        def.bodies_collide = bodies_collide;
        world.set_joint(joint, &def).expect("in range");
        assert_eq!(world.step(&mut Serial).contacts, u32::from(bodies_collide));
        assert_eq!(world.step(&mut Serial).contacts, u32::from(bodies_collide));
    }
    world.remove_joint(joint).expect("it exists");
    assert_eq!(world.step(&mut Serial).contacts, 1, "they meet again when the joint is gone");
    // One of two joints that keeps them apart is enough.
    let (mut world, bodies, first) = overlapping(false);
    let second = JointDef { bodies_collide: true, ..JointDef::ball(bodies, [Pose::IDENTITY; 2]) };
    let second = world.create_joint(&second).expect("room");
    assert_eq!(world.step(&mut Serial).contacts, 0);
    world.remove_joint(second).expect("it exists");
    assert_eq!(world.step(&mut Serial).contacts, 0);
    world.remove_joint(first).expect("it exists");
    assert_eq!(world.step(&mut Serial).contacts, 1);
}

#[test]
fn a_joint_breaks_by_force() {
    for (limit, breaks) in [(19.7, false), (19.5, true)] {
        let (mut world, base) = jointed(1, 1, 4);
        let body = massive(&mut world, at(Vec3::new(0.0, 0.0, -1.0)), ball(2.0, 0.2));
        let def = JointDef {
            break_force: limit,
            ..JointDef::ball([base, body], [Pose::IDENTITY, at(Vec3::new(0.0, 0.0, 1.0))])
        };
        let joint = world.create_joint(&def).expect("room");
        let broken: u32 = (0..60).map(|_| world.step(&mut Serial).broken).sum();
        assert_eq!(broken, u32::from(breaks), "2 kg weigh 19.62 N, limit {limit}");
        assert_eq!(world.is_broken(joint), Ok(breaks));
        assert_eq!(velocity(&world, body)[2] < -5.0, breaks, "it falls when the joint is broken");
        // Broken, it is still there, as defined, until it is removed.
        assert_eq!(world.joint(joint).expect("it exists").break_force, limit);
        assert_eq!(world.joint_count(), 1);
        if breaks {
            assert!(norm(force(&world, joint)) > 19.5, "the load that broke it");
        }
        world.remove_joint(joint).expect("it exists");
    }
}

#[test]
fn a_joint_breaks_by_torque() {
    // A rod of 3 kg and 1 m, held at its end: 14.715 N m.
    for (limit, breaks) in [(14.75, false), (14.68, true)] {
        let (mut world, base) = jointed(1, 1, 4);
        let body = massive(&mut world, at(Vec3::new(0.5, 0.0, 0.0)), rod(3.0, 1.0));
        let frames = [Pose::IDENTITY, at(Vec3::new(-0.5, 0.0, 0.0))];
        let def = JointDef { break_torque: limit, ..JointDef::fixed([base, body], frames) };
        let joint = world.create_joint(&def).expect("room");
        let broken: u32 = (0..60).map(|_| world.step(&mut Serial).broken).sum();
        assert_eq!((broken, world.is_broken(joint)), (u32::from(breaks), Ok(breaks)), "limit {limit}");
    }
}

#[test]
fn what_broke_meets_again() {
    let (mut world, bodies, joint) = overlapping(false);
    let mut def = world.joint(joint).expect("it exists");
    def.break_force = 100.0;
    world.set_joint(joint, &def).expect("in range");
    assert_eq!(world.step(&mut Serial).contacts, 0);
    world.apply_force(bodies[0], Vec3::new(0.0, 0.0, 1.0e5)).expect("dynamic");
    let report = world.step(&mut Serial);
    assert_eq!((report.broken, report.contacts), (1, 0));
    assert_eq!(world.step(&mut Serial).contacts, 1);
    assert_eq!(world.is_broken(joint), Ok(true));
    // A new definition does not mend it.
    world.set_joint(joint, &def).expect("in range");
    assert_eq!(world.is_broken(joint), Ok(true));
}

#[test]
fn a_chain_lies_on_the_ground() {
    let mut world = room(20);
    worlds::ground(&mut world, 0.6);
    let shape = ShapeDef::new(Geometry::Capsule { half_height: 0.2, radius: 0.1 });
    let mut last: Option<BodyHandle> = None;
    let mut links = Vec::new();
    let mut joints = Vec::new();
    let lying = Rotation::between(Vec3::Z, Vec3::X);
    for i in 0..16 {
        let place = Vec3::new(0.5 * i as f32 - 4.0, 0.0, 1.0);
        let def = BodyDef { rotation: lying, ..BodyDef::new(BodyKind::Dynamic, place) };
        let (body, _) = add(&mut world, &def, &shape);
        if let Some(last) = last {
            let frames = [at(Vec3::new(0.0, 0.0, 0.25)), at(Vec3::new(0.0, 0.0, -0.25))];
            joints.push(world.create_joint(&JointDef::ball([last, body], frames)).expect("room"));
        }
        last = Some(body);
        links.push(body);
    }
    // One end is thrown over the others.
    world.set_linear_velocity(links[0], Vec3::new(4.0, 1.0, 4.0)).expect("dynamic");
    run(&mut world, 900);
    let mut places: Vec<[f64; 3]> = links.iter().map(|&body| center(&world, body)).collect();
    run(&mut world, 120);
    for (&body, before) in links.iter().zip(&mut places) {
        let (v, c) = (norm(velocity(&world, body)), center(&world, body));
        assert!(v < 0.02 && norm(spin(&world, body)) < 0.2, "a link moves with {v} m/s");
        assert!(c[2] > 0.09, "a link is {} m deep", 0.1 - c[2]);
        let creep = norm([c[0] - before[0], c[1] - before[1], c[2] - before[2]]);
        assert!(creep < 5.0e-3, "a link creeps {creep} m in 2 s");
    }
    for &joint in &joints {
        assert!(gap(&world, joint) < 2.0e-3, "{}", gap(&world, joint));
    }
}

/// A trunk, a head, and limbs of two parts, of capsules and boxes, at a height.
fn ragdoll(world: &mut OwnedWorld, place: Vec3, rotation: Rotation) -> (Vec<BodyHandle>, Vec<JointHandle>) {
    let mut joints = Vec::new();
    let part = |world: &mut OwnedWorld, offset: Vec3, geometry: Geometry| {
        let def = BodyDef { rotation, ..BodyDef::new(BodyKind::Dynamic, place + rotation.rotate(offset)) };
        add(world, &def, &ShapeDef { friction: 0.6, ..ShapeDef::new(geometry) }).0
    };
    let trunk = part(world, Vec3::ZERO, Geometry::Box { half_extents: Vec3::new(0.15, 0.1, 0.3) });
    let head = part(world, Vec3::new(0.0, 0.0, 0.45), Geometry::Sphere { radius: 0.12 });
    let mut neck =
        JointDef::ball([trunk, head], [at(Vec3::new(0.0, 0.0, 0.3)), at(Vec3::new(0.0, 0.0, -0.15))]);
    neck.cone = Some(0.6);
    neck.axes[TURN_X] = Axis::limited(-0.8, 0.8);
    joints.push(world.create_joint(&neck).expect("room"));
    let mut bodies = vec![trunk, head];
    let limb = Geometry::Capsule { half_height: 0.13, radius: 0.06 };
    for (x, z) in [(0.23, 0.25), (-0.23, 0.25), (0.1, -0.35), (-0.1, -0.35)] {
        let upper = part(world, Vec3::new(x, 0.0, z - 0.2), limb);
        let lower = part(world, Vec3::new(x, 0.0, z - 0.6), limb);
        let down = |z: f32| Pose::new(Vec3::new(0.0, 0.0, z), Rotation::between(Vec3::X, -Vec3::Z));
        let mut shoulder = JointDef::ball([trunk, upper], [down(z), down(0.2)]);
        shoulder.frames[0].position = Vec3::new(x, 0.0, z);
        shoulder.cone = Some(1.0);
        shoulder.axes[TURN_X] = Axis::limited(-0.5, 0.5);
        joints.push(world.create_joint(&shoulder).expect("room"));
        let frames = [at(Vec3::new(0.0, 0.0, -0.2)), at(Vec3::new(0.0, 0.0, 0.2))];
        let mut elbow = JointDef::hinge([upper, lower], frames);
        elbow.axes[TURN_X] = Axis { friction: 0.5, ..Axis::limited(0.0, 2.2) };
        joints.push(world.create_joint(&elbow).expect("room"));
        bodies.extend([upper, lower]);
    }
    (bodies, joints)
}

#[test]
fn ragdolls_come_to_rest() {
    for seed in 0..4 {
        let mut world = room(40);
        worlds::ground(&mut world, 0.6);
        let turn = Rotation::from_rotation_vector(Vec3::new(seed as f32, 0.5, -0.7 * seed as f32));
        let (bodies, joints) = ragdoll(&mut world, Vec3::new(0.0, 0.0, 2.0), turn);
        let mut widest = 0.0_f64;
        for _ in 0..900 {
            world.step(&mut Serial);
            widest = joints.iter().map(|&joint| gap(&world, joint)).fold(widest, f64::max);
        }
        let mut speeds: Vec<f64> = bodies.iter().map(|&body| norm(velocity(&world, body))).collect();
        speeds.sort_by(f64::total_cmp);
        let speed = speeds[speeds.len() - 1];
        println!("ragdoll {seed}: gap {widest:.2e} m, fastest part {speed:.2e} m/s after 15 s");
        // One forearm that is held up by its limit may rock the arm on the ground, by millimetres.
        assert!(speeds[speeds.len() - 2] < 0.05 && speed < 0.2, "parts move with {speeds:?} m/s");
        assert!(widest < 0.05, "a joint opens by {widest} m at the fall");
        let rest = joints.iter().map(|&joint| gap(&world, joint)).fold(0.0, f64::max);
        assert!(rest < 1.0e-3, "a joint is open by {rest} m at rest");
        for &body in &bodies {
            assert!(center(&world, body)[2] > 0.0, "a part is under the ground");
        }
        let weight: f64 =
            bodies.iter().map(|&body| cellstep_tests::oracles::mass(&world, body) * GRAVITY).sum();
        // The ground's shape is the first.
        let on_ground = world.contacts().filter(|contact| contact.shapes[0].index == 0);
        let borne: f64 = on_ground.map(|contact| f64::from(contact.normal_force())).sum::<f64>();
        assert!((borne / weight - 1.0).abs() < 0.05, "the ground bears {borne} N of {weight} N");
    }
}
