//! How two materials become one.

use super::{RATE, ball, cuboid, dynamic, floor, incline, room};
use cellstep::math::Vec3;
use cellstep::{BodyDef, MaterialTraits, Mix, PairMaterial, ShapeDef, ShapeHandle};
use cellstep_tests::oracles::{GRAVITY, judge, velocity};
use cellstep_tests::worlds::{OwnedWorld, add, run};

fn mixes(friction_mix: Mix, restitution_mix: Mix) -> MaterialTraits {
    MaterialTraits { friction_mix, restitution_mix, ..MaterialTraits::default() }
}

/// The deceleration of a box that slides on the floor, over g; box and floor have these frictions and rules.
fn slides((box_friction, box_mix): (f32, Mix), (floor_friction, floor_mix): (f32, Mix)) -> f64 {
    let mut world = room(2);
    let traits = mixes(floor_mix, Mix::Unset);
    floor(&mut world, ShapeDef { friction: floor_friction, traits, ..ball(1.0) });
    let def = BodyDef { linear_velocity: Vec3::new(10.0, 0.0, 0.0), ..dynamic(0.0, 0.0, 0.1) };
    let shape =
        ShapeDef { friction: box_friction, traits: mixes(box_mix, Mix::Unset), ..cuboid(0.5, 0.5, 0.1) };
    let (body, _) = add(&mut world, &def, &shape);
    run(&mut world, RATE / 4);
    let before = velocity(&world, body)[0];
    run(&mut world, RATE / 2);
    (before - velocity(&world, body)[0]) * 2.0 / GRAVITY
}

#[test]
fn friction_is_mixed_by_the_later_rule() {
    let all = [
        (Mix::Unset, 0.4),
        (Mix::GeometricMean, 0.4),
        (Mix::Mean, 0.5),
        (Mix::Min, 0.2),
        (Mix::Multiply, 0.16),
        (Mix::Max, 0.8),
    ];
    for (i, (first, _)) in all.into_iter().enumerate() {
        for (k, (second, _)) in all.into_iter().enumerate() {
            let expected = all[i.max(k)].1;
            let found = slides((0.2, first), (0.8, second));
            judge(&format!("{first:?} with {second:?}"), (found - expected).abs(), [2.0e-3, 1.0e-2]);
        }
    }
}

/// The speed after a bounce, over that before.
fn bounces((ball_bounce, ball_mix): (f32, Mix), (floor_bounce, floor_mix): (f32, Mix)) -> f64 {
    let mut world = room(2);
    let traits = mixes(Mix::Unset, floor_mix);
    floor(&mut world, ShapeDef { restitution: floor_bounce, traits, ..ball(1.0) });
    let shape = ShapeDef { restitution: ball_bounce, traits: mixes(Mix::Unset, ball_mix), ..ball(0.1) };
    let def =
        BodyDef { linear_velocity: Vec3::new(0.0, 0.0, -4.0), gravity_scale: 0.0, ..dynamic(0.0, 0.0, 0.5) };
    let (body, _) = add(&mut world, &def, &shape);
    run(&mut world, RATE / 4);
    velocity(&world, body)[2] / 4.0
}

#[test]
fn restitution_is_mixed_by_the_later_rule() {
    for (first, second, expected) in [
        (Mix::Unset, Mix::Unset, 0.8),
        (Mix::Min, Mix::Unset, 0.2),
        (Mix::Unset, Mix::Min, 0.2),
        (Mix::Mean, Mix::GeometricMean, 0.5),
        (Mix::Multiply, Mix::Min, 0.16),
        (Mix::Min, Mix::Max, 0.8),
    ] {
        let found = bounces((0.2, first), (0.8, second));
        judge(&format!("{first:?} with {second:?}"), (found - expected).abs(), [2.0e-3, 1.0e-2]);
    }
}

fn on_a_slope(world: &mut OwnedWorld) -> (cellstep::BodyHandle, ShapeHandle, ShapeHandle) {
    incline(world, 0.3);
    let (_, ground) = floor(world, ball(1.0));
    let (body, own) = add(world, &dynamic(0.0, 0.0, 0.1), &cuboid(0.5, 0.5, 0.1));
    (body, own, ground)
}

#[test]
fn a_pair_has_a_material_of_its_own() {
    let mut world = room(2);
    let (body, own, ground) = on_a_slope(&mut world);
    run(&mut world, RATE);
    assert!(velocity(&world, body)[0].abs() < 1.0e-3, "friction of 0.6 holds it");
    let icy = PairMaterial { friction: Some(0.0), restitution: None };
    world.set_pair_material(own, ground, &icy).expect("room");
    assert_eq!(world.pair_material(ground, own), Ok(icy));
    run(&mut world, RATE);
    let speed = GRAVITY * 0.3 / (1.0_f64 + 0.09).sqrt();
    judge("slides off", (velocity(&world, body)[0] - speed).abs(), [1.0e-2, 5.0e-2]);
    world.set_pair_material(ground, own, &PairMaterial::default()).expect("nothing is needed");
    assert_eq!(world.pair_material(own, ground), Ok(PairMaterial::default()));
    run(&mut world, 3 * RATE);
    assert!(velocity(&world, body)[0].abs() < 1.0e-3, "the floor holds it again");
}
