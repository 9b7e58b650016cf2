//! Joints visited one by one, instead of those that hang together at once.

use super::chain_of_rods;
use cellstep::math::{Pose, Rotation, Vec3, length, max};
use cellstep::{BodyHandle, JointDef, JointHandle, Serial, Settings};
use cellstep_tests::jointed::{Bar, about_y, at, ball, force, gap, jointed, massive, weightless};
use cellstep_tests::oracles::GRAVITY;
use cellstep_tests::worlds::{OwnedWorld, run};

const LINKS: usize = 6;

/// Says how joints are held.
fn hold(world: &mut OwnedWorld, direct_joints: bool) {
    let settings = Settings { direct_joints, ..world.settings() };
    world.set_settings(&settings).expect("in range");
}

/// Six rods from the origin: along x, or hanging.
fn chain(substeps: u32, along: Vec3, is_hinge: bool) -> (OwnedWorld, Vec<BodyHandle>, Vec<JointHandle>) {
    chain_of_rods((LINKS, substeps), along, is_hinge)
}

#[test]
fn a_joint_that_hangs_alone_is_the_same_to_the_bit() {
    let place = |direct_joints| {
        let (mut world, base) = jointed(2, 2, 4);
        hold(&mut world, direct_joints);
        let bar = Bar::new(&mut world, Vec3::ZERO, Vec3::X);
        let hinge = JointDef::hinge([base, bar.body], [Pose::new(Vec3::ZERO, about_y()), bar.end(-1.0).1]);
        let other = massive(&mut world, at(Vec3::Y), ball(1.0, 0.3));
        let plain = JointDef::ball([base, other], [at(Vec3::ZERO), at(-Vec3::Y)]);
        for def in [hinge, plain] {
            world.create_joint(&def).expect("room");
        }
        run(&mut world, 120);
        [bar.body, other].map(|body| {
            let (place, turn) = (world.center(body).expect("lives"), world.rotation(body).expect("lives"));
            (place.offset.to_array(), [turn.x, turn.y, turn.z, turn.w])
        })
    };
    assert_eq!(place(true), place(false));
}

#[test]
fn a_hanging_chain_carries_its_weight() {
    for is_hinge in [false, true] {
        let (mut world, _, joints) = chain(4, -Vec3::Z, is_hinge);
        hold(&mut world, false);
        run(&mut world, 600);
        for (place, &joint) in joints.iter().enumerate() {
            let expected = (LINKS - place) as f64 * GRAVITY;
            let (found, gap) = (force(&world, joint)[2], gap(&world, joint));
            println!("hinges: {is_hinge}, joint {place}: {found:.4} of {expected:.4} N, gap {gap:.2e} m");
            assert!((found - expected).abs() < 1.0e-3 * expected, "joint {place}: {found} of {expected} N");
            assert!(gap < 1.0e-4, "joint {place}: {gap} m");
        }
    }
}

/// How far the bodies of a weightless chain that turns from its end are from those that a direct solve holds, after
/// half a second, and the widest gap on the way, metres.
fn apart(is_hinge: bool, (substeps, sweeps): (u32, u32)) -> (f32, f64) {
    let mut places = Vec::new();
    let mut widest = 0.0_f64;
    for direct_joints in [true, false] {
        let (mut world, bodies, joints) = chain(substeps, Vec3::X, is_hinge);
        let settings = Settings { sweeps, relax_sweeps: sweeps, ..world.settings() };
        world.set_settings(&settings).expect("in range");
        hold(&mut world, direct_joints);
        weightless(&mut world);
        world.set_angular_velocity(bodies[0], Vec3::new(0.0, 6.0, 0.0)).expect("dynamic");
        for _ in 0..30 {
            world.step(&mut Serial);
            let gaps = joints.iter().map(|&joint| gap(&world, joint));
            widest = gaps.fold(if direct_joints { 0.0 } else { widest }, f64::max);
        }
        places.push(bodies.iter().map(|&body| world.center(body).expect("lives")).collect::<Vec<_>>());
    }
    let pairs = places[0].iter().zip(&places[1]);
    (pairs.map(|(a, b)| length(b.minus(*a))).fold(0.0, max), widest)
}

#[test]
fn sweeps_bring_it_to_the_direct_solve() {
    for is_hinge in [false, true] {
        let all = [(4, 1), (4, 4), (4, 16), (4, 64)].map(|dial| (dial, apart(is_hinge, dial)));
        for ((_, sweeps), (way, gap)) in all {
            println!("hinges: {is_hinge}, {sweeps} sweeps: {way:.2e} m apart, widest gap {gap:.2e} m");
        }
        let [first, .., last] = all.map(|(_, (way, _))| way);
        assert!(last < 0.05 * first && last < 0.01, "{first} m apart, with 64 sweeps {last} m");
    }
}

#[test]
fn the_setting_can_change_between_steps() {
    let (mut world, _, joints) = chain(4, Vec3::X, true);
    for step in 0..240 {
        hold(&mut world, step / 7 % 2 == 0);
        let report = world.step(&mut Serial);
        assert_eq!((report.quarantined, report.joints), (0, LINKS as u32));
        let widest = joints.iter().map(|&joint| gap(&world, joint)).fold(0.0, f64::max);
        assert!(widest < 0.02, "step {step}: {widest} m");
    }
    let rotation = world.rotation(world.bodies().next().expect("the base")).expect("lives");
    assert_eq!(rotation, Rotation::IDENTITY, "the base stands");
}
