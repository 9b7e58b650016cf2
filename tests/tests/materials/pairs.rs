//! Bodies that ignore each other until they are apart, and groups.

use super::{RATE, ball, cuboid, dynamic, floor, place, room};
use cellstep::math::Vec3;
use cellstep::{BodyDef, BodyKind, Capacities, Error, Filter, PairMaterial, Settings, ShapeDef};
use cellstep_tests::worlds::{add, run, world_with};

#[test]
fn a_shot_leaves_the_gun_it_starts_in() {
    let mut world = room(3);
    world.set_settings(&Settings { gravity: Vec3::ZERO, ..Settings::default() }).expect("in range");
    let (gun, _) = add(&mut world, &dynamic(0.0, 0.0, 0.0), &cuboid(0.5, 0.5, 0.5));
    let def = BodyDef { linear_velocity: Vec3::new(5.0, 0.0, 0.0), ..dynamic(0.2, 0.0, 0.0) };
    let (shot, _) = add(&mut world, &def, &ball(0.1));
    add(
        &mut world,
        &BodyDef::new(BodyKind::Static, Vec3::new(3.0, 0.0, 0.0)),
        &ShapeDef { restitution: 1.0, ..cuboid(0.1, 2.0, 2.0) },
    );
    world.ignore_until_separated(shot, gun).expect("room");
    assert_eq!(world.ignores(gun, shot), Ok(true));
    let mut until = 0;
    for step in 1..=2 * RATE {
        run(&mut world, 1);
        let apart = place(&world, shot)[0] - 0.6;
        if world.ignores(gun, shot) == Ok(true) {
            until = step;
            assert!(apart < 0.25, "still ignored {apart} m apart");
        }
        if until == step {
            assert_eq!(world.linear_velocity(gun).expect("it exists"), Vec3::ZERO, "step {step}");
        }
    }
    assert!(until > 2 && until < 12, "ignored for {until} steps");
    // It came back from the wall and hit the gun.
    assert!(world.linear_velocity(gun).expect("it exists").x < -1.0e-3);
}

#[test]
fn what_is_apart_is_ignored_no_longer() {
    let mut world = room(3);
    let (a, _) = add(&mut world, &dynamic(0.0, 0.0, 0.0), &ball(0.5));
    let (b, _) = add(&mut world, &dynamic(2.0, 0.0, 0.0), &ball(0.5));
    world.ignore_until_separated(a, b).expect("room");
    run(&mut world, 1);
    assert_eq!(world.ignores(a, b), Ok(false));
}

/// A box on the floor falls through it when the two ignore each other; and lies again on another floor.
#[test]
fn a_resting_box_falls_when_it_is_to_ignore_its_floor() {
    for sleeps in [false, true] {
        let mut world = room(3);
        world
            .set_settings(&Settings { sleep_time: if sleeps { 0.25 } else { 0.0 }, ..Settings::default() })
            .expect("in range");
        let thin = BodyDef::new(BodyKind::Static, Vec3::new(0.0, 0.0, 2.0));
        let (upper, _) = add(&mut world, &thin, &cuboid(2.0, 2.0, 0.05));
        floor(&mut world, ball(1.0));
        let (body, _) = add(&mut world, &dynamic(0.0, 0.0, 2.55), &cuboid(0.5, 0.5, 0.5));
        run(&mut world, 2 * RATE);
        assert!((place(&world, body)[2] - 2.55).abs() < 2.0e-3);
        assert_eq!(world.is_asleep(body), Ok(sleeps));
        world.ignore_until_separated(upper, body).expect("room");
        run(&mut world, 3 * RATE);
        assert!((place(&world, body)[2] - 0.5).abs() < 2.0e-3, "{}", place(&world, body)[2]);
        assert_eq!(world.ignores(upper, body), Ok(false));
    }
}

#[test]
fn ignoring_can_be_stopped() {
    let mut world = room(3);
    let (ground, _) = floor(&mut world, ball(1.0));
    let (body, _) = add(&mut world, &dynamic(0.0, 0.0, 0.5), &cuboid(0.5, 0.5, 0.5));
    world.ignore_until_separated(ground, body).expect("room");
    run(&mut world, 6);
    let sunk = place(&world, body)[2];
    assert!(sunk < 0.47, "{sunk}");
    world.stop_ignoring(body, ground).expect("it exists");
    run(&mut world, RATE);
    assert!((place(&world, body)[2] - 0.5).abs() < 2.0e-3, "pushed out");
}

/// Shapes of one group meet when it is positive and not when it is negative, whatever their masks.
#[test]
fn groups_come_before_masks() {
    for (group, mask, meets) in [(-3, u32::MAX, false), (3, 0, true), (0, 0, false), (0, u32::MAX, true)] {
        let mut world = room(2);
        let filter = Filter { mask, group, ..Filter::default() };
        floor(&mut world, ShapeDef { filter, ..ball(1.0) });
        let (body, _) = add(&mut world, &dynamic(0.0, 0.0, 0.5), &ShapeDef { filter, ..ball(0.5) });
        run(&mut world, RATE);
        assert_eq!(place(&world, body)[2] > 0.4, meets, "group {group}, mask {mask}");
    }
    let one = Filter { group: -1, ..Filter::default() };
    assert!(one.meets(&Filter { group: -2, ..Filter::default() }), "other groups go by masks");
}

#[test]
fn rules_go_with_what_they_are_about() {
    let mut world = world_with(Capacities { pair_rules: 2, ..Capacities::for_bodies(4) });
    let (a, sa) = add(&mut world, &dynamic(0.0, 0.0, 0.0), &ball(0.5));
    let (b, sb) = add(&mut world, &dynamic(0.1, 0.0, 0.0), &ball(0.5));
    let (c, sc) = add(&mut world, &dynamic(0.2, 0.0, 0.0), &ball(0.5));
    let rough = PairMaterial { friction: Some(2.0), restitution: Some(0.5) };
    world.set_pair_material(sa, sb, &rough).expect("room");
    world.ignore_until_separated(b, c).expect("room");
    let state = world.checksum();
    assert_eq!(world.set_pair_material(sb, sc, &rough), Err(Error::Full { name: "pair_rules" }));
    assert_eq!(world.ignore_until_separated(a, c), Err(Error::Full { name: "pair_rules" }));
    assert_eq!(world.set_pair_material(sb, sb, &rough), Err(Error::OutOfRange { name: "shapes" }));
    assert_eq!(world.ignore_until_separated(b, b), Err(Error::OutOfRange { name: "bodies" }));
    let bad = PairMaterial { friction: Some(f32::NAN), restitution: None };
    assert_eq!(world.set_pair_material(sa, sb, &bad), Err(Error::NotFinite { name: "friction" }));
    assert_eq!(world.checksum(), state, "refused calls change nothing");
    world.ignore_until_separated(c, b).expect("the same pair again needs no room");
    assert_eq!(world.checksum(), state);
    world.remove_shape(sb).expect("it exists");
    assert_eq!(world.pair_material(sa, sb), Err(Error::Stale { what: "shape" }));
    let again = world.create_shape(b, &ball(0.5)).expect("room");
    assert_eq!(world.pair_material(sa, again), Ok(PairMaterial::default()));
    world.set_pair_material(again, sc, &rough).expect("room again");
    world.remove_body(b).expect("it exists");
    world.set_pair_material(sa, sc, &rough).expect("all rules of the body are gone");
    world.ignore_until_separated(a, c).expect("both of them");
}
