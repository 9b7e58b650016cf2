//! Handles, refusals, what is read back, and what changes keep.

use cellstep::joint::axis::{TURN_X, X};
use cellstep::math::{Pose, Rotation, Vec3};
use cellstep::{
    Axis, AxisMotion, BodyDef, BodyHandle, BodyKind, Capacities, Coupling, Drive, Error, JointDef,
    JointHandle, Spring,
};
use cellstep_tests::jointed::{at, ball, force, jointed, massive, torque};
use cellstep_tests::oracles::{GRAVITY, norm, relative, velocity};
use cellstep_tests::worlds::{self, OwnedWorld, run};

/// A base and two balls.
fn three(joints: u32) -> (OwnedWorld, [BodyHandle; 3]) {
    let (mut world, base) = jointed(2, joints, 4);
    let a = massive(&mut world, at(Vec3::X), ball(1.0, 0.2));
    let b = massive(&mut world, at(Vec3::new(2.0, 0.0, 0.0)), ball(1.0, 0.2));
    (world, [base, a, b])
}

/// A definition that uses every field.
fn full(bodies: [BodyHandle; 2]) -> JointDef {
    let frame = Pose::new(Vec3::new(0.5, -0.25, 0.125), Rotation::IDENTITY);
    let mut def = JointDef::six_axis(bodies, [frame, Pose::IDENTITY]);
    def.axes[X] = Axis {
        motion: AxisMotion::Limited { lower: -1.0, upper: 2.0 },
        limit_spring: Some(Spring::Frequency { hertz: 5.0, damping_ratio: 0.5 }),
        drive: Some(Drive {
            target: 0.5,
            velocity: 0.25,
            spring: Some(Spring::Stiffness { stiffness: 100.0, damping: 3.0 }),
            max_force: 40.0,
        }),
        friction: 2.0,
    };
    def.axes[TURN_X] = Axis { drive: Some(Drive::motor(3.0, 7.0)), ..Axis::FREE };
    JointDef {
        cone: Some(0.75),
        spring: Some(Spring::Frequency { hertz: 20.0, damping_ratio: 1.0 }),
        break_force: 1.0e4,
        break_torque: 2.0e3,
        bodies_collide: true,
        user: 0x0123_4567_89AB_CDEF,
        ..def
    }
}

fn kinds(bodies: [BodyHandle; 2]) -> Vec<JointDef> {
    let frames = [Pose::IDENTITY, at(-Vec3::X)];
    let spring = Spring::Frequency { hertz: 4.0, damping_ratio: 0.7 };
    vec![
        JointDef::ball(bodies, frames),
        JointDef::hinge(bodies, frames),
        JointDef::slider(bodies, frames),
        JointDef::fixed(bodies, frames),
        JointDef::distance(bodies, [Vec3::ZERO; 2], 0.0, 1.5),
        JointDef::distance(bodies, [Vec3::ZERO; 2], 1.0, 1.0),
        JointDef::six_axis(bodies, frames),
        JointDef::wheel(bodies, frames, spring),
        JointDef::gear(bodies, frames, -2.5),
        JointDef::rack(bodies, frames, 0.3),
        full(bodies),
    ]
}

#[test]
fn a_joint_reads_back_as_defined() {
    let (mut world, [base, a, b]) = three(32);
    for bodies in [[base, a], [a, b], [b, base]] {
        for def in kinds(bodies) {
            let joint = world.create_joint(&def).expect("in range");
            assert_eq!(world.joint(joint), Ok(def));
            assert_eq!(world.joint_user(joint), Ok(def.user));
            world.set_joint_user(joint, 77).expect("it exists");
            assert_eq!(world.joint(joint), Ok(JointDef { user: 77, ..def }));
            // And after it was changed into every other kind.
            for other in kinds(bodies) {
                world.set_joint(joint, &other).expect("in range");
                assert_eq!(world.joint(joint), Ok(other));
            }
            run(&mut world, 1);
            assert_eq!(
                world.joint(joint),
                Ok(*kinds(bodies).last().expect("many")),
                "steps change no definition"
            );
            world.remove_joint(joint).expect("it exists");
        }
    }
    // An axis at a time.
    let joint = world.create_joint(&JointDef::six_axis([a, b], [Pose::IDENTITY; 2])).expect("room");
    let axis = full([a, b]).axes[X];
    for index in 0..6 {
        world.set_joint_axis(joint, index, &axis).expect("in range");
        assert_eq!(world.joint(joint).expect("it exists").axes[index], axis);
    }
}

#[test]
fn handles_go_stale() {
    let (mut world, [base, a, b]) = three(4);
    let stale = Err(Error::Stale { what: "joint" });
    let joint = world.create_joint(&JointDef::ball([base, a], [Pose::IDENTITY; 2])).expect("room");
    assert!(world.contains_joint(joint));
    world.remove_joint(joint).expect("it exists");
    let next = world.create_joint(&JointDef::ball([a, b], [Pose::IDENTITY; 2])).expect("room");
    assert_eq!((next.index, next.generation), (joint.index, joint.generation + 1), "lowest slot first");
    let before = world.state().to_vec();
    for gone in
        [joint, JointHandle { index: 3, generation: 1 }, JointHandle { index: u32::MAX, generation: 1 }]
    {
        assert!(!world.contains_joint(gone));
        let def = JointDef::ball([base, a], [Pose::IDENTITY; 2]);
        assert_eq!(world.remove_joint(gone), stale);
        assert_eq!(world.set_joint(gone, &def), stale);
        assert_eq!(world.set_joint_axis(gone, 0, &Axis::FREE), stale);
        assert_eq!(world.set_joint_user(gone, 1), stale);
        assert_eq!(world.joint(gone).map(drop), stale);
        assert_eq!(world.joint_user(gone).map(drop), stale);
        assert_eq!(world.joint_force(gone).map(drop), stale);
        assert_eq!(world.joint_torque(gone).map(drop), stale);
        assert_eq!(world.joint_coordinates(gone).map(drop), stale);
        assert_eq!(world.is_broken(gone).map(drop), stale);
    }
    let gone = BodyHandle { generation: a.generation + 1, ..a };
    for bodies in [[gone, b], [b, gone]] {
        let refused = world.create_joint(&JointDef::ball(bodies, [Pose::IDENTITY; 2]));
        assert!(matches!(refused, Err(Error::Stale { what: "body" })), "{refused:?}");
    }
    assert!(matches!(world.joints_of(gone).map(drop), Err(Error::Stale { .. })));
    assert!(world.state() == before);
}

#[test]
fn joints_of_a_body_are_in_order() {
    let (mut world, [base, a, b]) = three(8);
    let ends = [[base, a], [a, b], [b, base], [base, a], [b, a]];
    let joints =
        ends.map(|bodies| world.create_joint(&JointDef::ball(bodies, [Pose::IDENTITY; 2])).expect("room"));
    let of = |world: &OwnedWorld, body| world.joints_of(body).expect("it exists").collect::<Vec<_>>();
    assert_eq!(of(&world, a), [joints[0], joints[1], joints[3], joints[4]]);
    assert_eq!(of(&world, b), [joints[1], joints[2], joints[4]]);
    world.remove_joint(joints[1]).expect("it exists");
    assert_eq!(of(&world, a), [joints[0], joints[3], joints[4]]);
    assert_eq!(of(&world, b), [joints[2], joints[4]]);
    // A new one takes the slot, and comes last.
    let new = world.create_joint(&JointDef::ball([a, b], [Pose::IDENTITY; 2])).expect("room");
    assert_eq!(new.index, 1);
    assert_eq!(of(&world, a), [joints[0], joints[3], joints[4], new]);
    assert_eq!(world.joints().collect::<Vec<_>>(), [joints[0], new, joints[2], joints[3], joints[4]]);
    assert_eq!(world.joint_count(), 5);
    // A body takes its joints with it.
    world.remove_body(a).expect("it exists");
    assert_eq!(world.joints().collect::<Vec<_>>(), [joints[2]]);
    assert_eq!(of(&world, b), [joints[2]]);
    assert_eq!(of(&world, base), [joints[2]]);
    run(&mut world, 2);
    world.remove_body(base).expect("it exists");
    assert_eq!((world.joint_count(), of(&world, b).len()), (0, 0));
    run(&mut world, 2);
}

/// A name, and a way to spoil a definition with a number.
type Spoil = (&'static str, fn(&mut JointDef, f32));

const SPOILS: &[Spoil] = &[
    ("frames", |d, x| d.frames[0].position.x = x),
    ("frames", |d, x| d.frames[1].position.z = x),
    ("frames", |d, x| d.frames[0].rotation.w = x),
    ("frames", |d, x| d.frames[1].rotation.y = x),
    ("lower", |d, x| d.axes[3].motion = AxisMotion::Limited { lower: x, upper: 2.0 }),
    ("upper", |d, x| d.axes[0].motion = AxisMotion::Limited { lower: -1.0, upper: x }),
    ("limit hertz", |d, x| d.axes[1].limit_spring = Some(Spring::Frequency { hertz: x, damping_ratio: 1.0 })),
    ("limit ratio", |d, x| d.axes[1].limit_spring = Some(Spring::Frequency { hertz: 1.0, damping_ratio: x })),
    ("stiffness", |d, x| d.spring = Some(Spring::Stiffness { stiffness: x, damping: 1.0 })),
    ("damping", |d, x| d.spring = Some(Spring::Stiffness { stiffness: 1.0, damping: x })),
    ("target", |d, x| d.axes[5].drive = Some(Drive { target: x, ..Drive::motor(0.0, 1.0) })),
    ("velocity", |d, x| d.axes[4].drive = Some(Drive::motor(x, 1.0))),
    ("drive spring", |d, x| {
        d.axes[2].drive = Some(Drive::spring(0.0, Spring::Stiffness { stiffness: x, damping: 1.0 }));
    }),
    ("max_force", |d, x| d.axes[3].drive = Some(Drive::motor(0.0, x))),
    ("friction", |d, x| d.axes[2].friction = x),
    ("cone", |d, x| d.cone = Some(x)),
    ("break_force", |d, x| d.break_force = x),
    ("break_torque", |d, x| d.break_torque = x),
    ("gear", |d, x| d.coupling = Coupling::Gear { ratio: x }),
    ("rack", |d, x| d.coupling = Coupling::Rack { ratio: x }),
];

/// What is refused besides NaN, by name.
fn refused_values(name: &str) -> &'static [f32] {
    const INFINITE: [f32; 2] = [f32::INFINITY, f32::NEG_INFINITY];
    const NEGATIVE: &[f32] = &[-1.0, f32::INFINITY, f32::NEG_INFINITY, f32::MAX, 2.0e12];
    match name {
        // A rotation is no unit quaternion with any of these.
        "frames" => &[f32::INFINITY, f32::NEG_INFINITY, f32::MAX],
        "lower" => &[f32::INFINITY, 2.5, -2.0e5, f32::MIN],
        "upper" => &[f32::NEG_INFINITY, -1.5, 2.0e5, f32::MAX],
        "target" | "velocity" => &[f32::INFINITY, f32::NEG_INFINITY, 2.0e5, -2.0e5],
        "max_force" => &[-1.0, f32::NEG_INFINITY],
        "cone" => &[0.0, 0.005, 3.2, -1.0, f32::INFINITY],
        "break_force" | "break_torque" => &[0.0, -1.0, f32::NEG_INFINITY],
        "gear" | "rack" => &[0.0, 1.0e-5, 2.0e4, -2.0e4, f32::INFINITY, f32::NEG_INFINITY],
        "limit hertz" | "limit ratio" => &[-1.0, 2.0e5, f32::INFINITY, INFINITE[1]],
        _ => NEGATIVE,
    }
}

#[test]
fn every_number_is_checked() {
    let (mut world, [base, a, _]) = three(4);
    let joint = world.create_joint(&full([base, a])).expect("room");
    run(&mut world, 5);
    let before = world.state().to_vec();
    for (name, spoil) in SPOILS {
        for &bad in refused_values(name).iter().chain(&[f32::NAN]) {
            let mut def = full([base, a]);
            spoil(&mut def, bad);
            let typed = |outcome: Result<(), Error>| match outcome {
                Err(Error::NotFinite { .. }) => bad.is_nan() || bad.is_infinite(),
                Err(Error::OutOfRange { .. }) => !bad.is_nan(),
                Err(Error::NotARotation { .. }) => *name == "frames",
                _ => false,
            };
            let created = world.create_joint(&def).map(drop);
            assert!(typed(created), "{name} as {bad}: {created:?}");
            assert_eq!(world.set_joint(joint, &def), created, "{name} as {bad}");
            for index in 0..6 {
                if def.axes[index] != full([base, a]).axes[index] {
                    assert_eq!(
                        world.set_joint_axis(joint, index, &def.axes[index]),
                        created,
                        "{name} as {bad}"
                    );
                }
            }
            assert!(world.state() == before, "{name} as {bad} changed the world");
        }
    }
    let itself = world.create_joint(&JointDef::ball([a, a], [Pose::IDENTITY; 2]));
    assert_eq!(itself, Err(Error::OutOfRange { name: "bodies" }));
    assert_eq!(world.set_joint_axis(joint, 6, &Axis::FREE), Err(Error::OutOfRange { name: "index" }));
    let other = world.set_joint(joint, &full([a, base]));
    assert!(matches!(other, Err(Error::WrongKind { .. })), "{other:?}");
    assert!(world.state() == before);
}

#[test]
fn what_does_not_fit_is_refused() {
    let full_up = Err(Error::Full { name: "joints" });
    let (mut world, [base, a, b]) = three(2);
    let def = JointDef::ball([base, a], [Pose::IDENTITY; 2]);
    let first = world.create_joint(&def).expect("room");
    let second = world.create_joint(&JointDef::ball([a, b], [Pose::IDENTITY; 2])).expect("room");
    let before = world.state().to_vec();
    assert_eq!(world.create_joint(&def).map(drop), full_up);
    assert!(world.state() == before);
    // Four limits, drives and frictions for each joint of the room: eight in all.
    let busy = Axis { drive: Some(Drive::motor(1.0, 1.0)), friction: 1.0, ..Axis::limited(-1.0, 1.0) };
    for index in 3..5 {
        world.set_joint_axis(first, index, &busy).expect("room for six");
    }
    let two = Axis { drive: Some(Drive::motor(1.0, 1.0)), ..Axis::limited(-1.0, 1.0) };
    let before = world.state().to_vec();
    assert_eq!(world.set_joint_axis(second, 3, &busy), full_up);
    let mut def = JointDef::ball([a, b], [Pose::IDENTITY; 2]);
    def.axes[4] = busy;
    assert_eq!(world.set_joint(second, &def), full_up);
    assert!(world.state() == before);
    world.set_joint_axis(second, 3, &two).expect("room for eight");
    let axis = Axis { friction: 1.0, ..Axis::FREE };
    assert_eq!(world.set_joint_axis(second, 4, &axis), full_up);
    run(&mut world, 5);
    // Room that is given back can be had again.
    world.set_joint_axis(first, 3, &Axis::FREE).expect("less");
    world.set_joint_axis(second, 4, &busy).expect("room again");
    world.remove_joint(first).expect("it exists");
    world.set_joint_axis(second, 5, &busy).expect("room again");
    run(&mut world, 5);
    // A world without room for joints has none.
    let mut none = worlds::world_with(Capacities { joints: 0, ..Capacities::for_bodies(4) });
    let bodies = [0.0, 1.0]
        .map(|x| none.create_body(&BodyDef::new(BodyKind::Static, Vec3::new(x, 0.0, 0.0))).expect("room"));
    assert_eq!(none.create_joint(&JointDef::ball(bodies, [Pose::IDENTITY; 2])).map(drop), full_up);
    assert_eq!(none.joints_of(bodies[0]).expect("it exists").count(), 0);
}

#[test]
fn changes_keep_what_is_pressed_where_rows_stay() {
    let hanging = || {
        let (mut world, base) = jointed(1, 1, 4);
        let body = massive(&mut world, at(-Vec3::Z), ball(2.0, 0.2));
        let frames = [Pose::IDENTITY, at(Vec3::Z)];
        let mut def = JointDef::hinge([base, body], frames);
        def.axes[TURN_X] = Axis { friction: 0.1, ..Axis::limited(-1.0, 1.0) };
        let joint = world.create_joint(&def).expect("room");
        run(&mut world, 120);
        (world, body, joint, def)
    };
    // Other limits, other frames by a hair: the load is kept, and nothing starts to fall.
    let (mut world, body, joint, mut def) = hanging();
    let load = force(&world, joint);
    assert!(relative(load[2], 2.0 * GRAVITY) < 1.0e-4);
    def.axes[TURN_X] = Axis { friction: 0.2, ..Axis::limited(-0.5, 0.5) };
    world.set_joint(joint, &def).expect("in range");
    assert_eq!(force(&world, joint), load);
    // With another row it is forgotten.
    let mut other = def;
    other.axes[TURN_X].drive = Some(Drive::motor(0.0, 1.0));
    world.set_joint(joint, &other).expect("in range");
    assert_eq!((force(&world, joint), torque(&world, joint)), ([0.0; 3], [0.0; 3]));
    run(&mut world, 60);
    assert!(norm(velocity(&world, body)) < 1.0e-3);
    assert!(relative(force(&world, joint)[2], 2.0 * GRAVITY) < 1.0e-4);
    // One axis: the other rows keep theirs.
    let (mut world, body, joint, _) = hanging();
    world
        .set_joint_axis(joint, TURN_X, &Axis { drive: Some(Drive::motor(0.0, 5.0)), ..Axis::FREE })
        .expect("in range");
    assert_eq!(force(&world, joint), load);
    run(&mut world, 1);
    assert!(norm(velocity(&world, body)) < 1.0e-4, "{:?}", velocity(&world, body));
    assert!(relative(force(&world, joint)[2], 2.0 * GRAVITY) < 1.0e-3);
}
