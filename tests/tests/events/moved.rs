//! The list of moved bodies: a renderer that reads nothing else shows every body where it is.

use cellstep::clock::interpolated;
use cellstep::math::{Rotation, Vec3};
use cellstep::{
    BodyDef, BodyHandle, BodyKind, Capacities, Geometry, MovedBody, Position, Serial, Settings, ShapeDef,
};
use cellstep_tests::simulator::{EVENTFUL, Simulator};
use cellstep_tests::worlds::{OwnedWorld, add, ground, run, world_with};
use std::collections::BTreeMap;

type Place = (Position, Rotation);

fn place(world: &OwnedWorld, body: BodyHandle) -> Place {
    (world.position(body).expect("exists"), world.rotation(body).expect("exists"))
}

fn moved(world: &OwnedWorld) -> Vec<MovedBody> {
    world.moved_bodies().collect()
}

fn noting(world: &mut OwnedWorld, moved_list: bool) {
    let settings = Settings { moved_list, ..world.settings() };
    world.set_settings(&settings).expect("valid");
}

#[test]
fn a_renderer_needs_nothing_else() {
    let (mut listed, mut still) = (0, 0);
    for seed in 600..640 {
        let (mut simulator, mut world) = Simulator::new(seed, EVENTFUL);
        noting(&mut world, true);
        let mut shown: BTreeMap<BodyHandle, Place> =
            world.bodies().map(|body| (body, place(&world, body))).collect();
        let mut asleep = Vec::new();
        for step in 0..150 {
            simulator.play(&mut world);
            if !world.settings().moved_list {
                // The list was dropped, and begins anew.
                noting(&mut world, true);
                shown = world.bodies().map(|body| (body, place(&world, body))).collect();
            }
            world.step(&mut Serial);
            let list = moved(&world);
            assert!(list.windows(2).all(|two| two[0].body.index < two[1].body.index), "by slot");
            for entry in &list {
                assert_eq!((entry.position, entry.rotation), place(&world, entry.body));
                shown.insert(entry.body, (entry.position, entry.rotation));
                let fell = world.is_asleep(entry.body) == Ok(true) && !asleep.contains(&entry.body);
                assert_eq!(entry.fell_asleep, fell, "seed {seed} step {step}");
            }
            let center = |body| world.mass_properties(body).expect("exists").center;
            for body in world.bodies() {
                let (found, exact) = (shown[&body], place(&world, body));
                // A new mass moves the center about which the origin is kept: it is rounded anew.
                let near =
                    cellstep::math::length(found.0.minus(exact.0)) <= 1.0e-5 * (1.0 + center(body).length());
                assert!(near && found.1 == exact.1, "seed {seed} step {step} {body:?}: {found:?} {exact:?}");
            }
            asleep = world.bodies().filter(|&body| world.is_asleep(body) == Ok(true)).collect();
            listed += list.len();
            still += world.body_count() as usize - list.len();
        }
    }
    assert!(listed > 10_000 && still > 10_000, "{listed} {still}");
}

fn tower() -> (OwnedWorld, Vec<BodyHandle>) {
    let mut world = world_with(Capacities::for_bodies(20));
    let settings = Settings { sleep_time: 0.25, moved_list: true, ..Settings::default() };
    world.set_settings(&settings).expect("valid");
    ground(&mut world, 0.6);
    let cube = ShapeDef::new(Geometry::Box { half_extents: Vec3::splat(0.5) });
    let at = |i: usize| BodyDef::new(BodyKind::Dynamic, Vec3::Z * (0.5 + i as f32));
    let bodies = (0..5).map(|i| add(&mut world, &at(i), &cube).0).collect();
    (world, bodies)
}

#[test]
fn who_falls_asleep_is_told_once_and_then_is_still() {
    let (mut world, bodies) = tower();
    let mut fell = Vec::new();
    for _ in 0..300 {
        world.step(&mut Serial);
        fell.extend(moved(&world).iter().filter(|entry| entry.fell_asleep).map(|entry| entry.body));
    }
    assert_eq!(fell, bodies);
    assert_eq!(moved(&world), []);
    // A call is seen at once and after the next step, not later.
    world
        .set_pose(bodies[0], Position::at(Vec3::X * 9.0 + Vec3::Z * 0.5), Rotation::IDENTITY)
        .expect("exists");
    let only = |world: &OwnedWorld| moved(world).iter().map(|entry| entry.body).collect::<Vec<_>>();
    assert_eq!(only(&world), [bodies[0]]);
    let floor = world.bodies().next().expect("the ground");
    world.set_pose(floor, Position::ORIGIN, Rotation::IDENTITY).expect("exists");
    world.step(&mut Serial);
    assert!(only(&world).starts_with(&[floor, bodies[0]]));
    run(&mut world, 1);
    assert!(!only(&world).contains(&floor));
}

#[test]
fn nothing_is_noted_unless_asked_for() {
    let (mut world, bodies) = tower();
    run(&mut world, 1);
    assert_eq!(moved(&world).len(), 6, "all are new");
    noting(&mut world, false);
    assert_eq!(moved(&world), []);
    world.set_linear_velocity(bodies[4], Vec3::X * 9.0).expect("exists");
    run(&mut world, 10);
    assert_eq!(moved(&world), []);
    let sections: Vec<_> = world.checksum_by_section().collect();
    let sum = sections.iter().find(|(name, _)| *name == "news").expect("a section").1;
    let (mut fresh, _) = tower();
    noting(&mut fresh, false);
    let empty = fresh.checksum_by_section().find(|(name, _)| *name == "news").expect("a section").1;
    assert_eq!(sum, empty);
}

#[test]
fn poses_between_two_steps_come_from_the_list() {
    let mut world = world_with(Capacities::for_bodies(3));
    world
        .set_settings(&Settings { moved_list: true, gravity: Vec3::ZERO, ..Settings::default() })
        .expect("valid");
    let def = |velocity| BodyDef {
        linear_velocity: velocity,
        ..BodyDef::new(BodyKind::Kinematic, Vec3::new(31.9, 0.0, 0.0))
    };
    let goes = world.create_body(&def(Vec3::X * 60.0)).expect("room");
    let stands = world.create_body(&def(Vec3::ZERO)).expect("room");
    run(&mut world, 1);
    let mut last: BTreeMap<BodyHandle, Place> =
        world.bodies().map(|body| (body, place(&world, body))).collect();
    for _ in 0..120 {
        let from = last.clone();
        run(&mut world, 1);
        for entry in world.moved_bodies() {
            last.insert(entry.body, (entry.position, entry.rotation));
        }
        let half = |body: &BodyHandle| interpolated(from[body], last[body], 0.5).0.to_f64()[0];
        let exact = world.position(goes).expect("exists").to_f64()[0] - 0.5;
        assert!((half(&goes) - exact).abs() < 1.0e-5, "across sectors too");
        assert_eq!(half(&stands), f64::from(31.9_f32));
    }
}
