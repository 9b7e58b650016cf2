//! The pool of materials: shared rows, typed errors, and nothing changed by what is refused.

use super::{ball, dynamic, rolling};
use cellstep::math::Vec3;
use cellstep::{Capacities, Error, MaterialTraits, Mix, ShapeDef};
use cellstep_tests::worlds::{OwnedWorld, add, world_with};

fn with_room(materials: u32) -> OwnedWorld {
    world_with(Capacities { materials, ..Capacities::for_bodies(8) })
}

#[test]
fn shapes_of_the_same_traits_share_a_row() {
    let mut world = with_room(2);
    let shape = |traits| ShapeDef { traits, ..ball(0.5) };
    let (body, first) = add(&mut world, &dynamic(0.0, 0.0, 0.0), &shape(rolling(0.1)));
    for _ in 0..3 {
        world.create_shape(body, &shape(rolling(0.1))).expect("a row that is there");
    }
    let other = world.create_shape(body, &shape(rolling(0.2))).expect("the second row");
    let state = world.checksum();
    let full = Err(Error::Full { name: "materials" });
    assert_eq!(world.create_shape(body, &shape(rolling(0.3))).map(|_| ()), full);
    assert_eq!(world.set_material_traits(first, &rolling(0.3)), full);
    assert_eq!(world.checksum(), state, "refused calls change nothing");
    assert_eq!(world.shape(first).expect("it exists").traits, rolling(0.1));
    // The only shape of a row may change it.
    world.set_material_traits(other, &rolling(0.3)).expect("its own row");
    assert_eq!(world.shape(other).expect("it exists").traits, rolling(0.3));
    world.set_material_traits(other, &MaterialTraits::default()).expect("needs none");
    world.set_material_traits(first, &rolling(0.4)).expect("the row that is free now");
    assert_eq!(world.shape(first).expect("it exists").traits, rolling(0.4));
    world.remove_body(body).expect("it exists");
    assert_eq!(
        world.state().iter().filter(|byte| **byte != 0).count(),
        {
            let mut fresh = with_room(2);
            let (body, _) = add(&mut fresh, &dynamic(0.0, 0.0, 0.0), &ball(0.5));
            for _ in 0..4 {
                fresh.create_shape(body, &ball(0.5)).expect("room");
            }
            fresh.remove_body(body).expect("it exists");
            fresh.state().iter().filter(|byte| **byte != 0).count()
        },
        "free rows are zero"
    );
}

#[test]
fn worlds_without_the_capacity_refuse_traits() {
    let mut world = with_room(0);
    let (_, shape) = add(&mut world, &dynamic(0.0, 0.0, 0.0), &ball(0.5));
    assert_eq!(world.set_material_traits(shape, &rolling(0.1)), Err(Error::Full { name: "materials" }));
    assert_eq!(world.set_material_traits(shape, &MaterialTraits::default()), Ok(()));
    let many = Capacities { materials: 65_536, ..Capacities::for_bodies(1) };
    assert_eq!(many.check(), Err(Error::CapacityOutOfRange { name: "materials" }));
}

#[test]
fn numbers_out_of_range_are_refused() {
    let mut world = with_room(1);
    let (_, shape) = add(&mut world, &dynamic(0.0, 0.0, 0.0), &ball(0.5));
    let none = MaterialTraits::default();
    let state = world.checksum();
    for (traits, error) in [
        (rolling(-1.0), Error::OutOfRange { name: "rolling" }),
        (rolling(f32::NAN), Error::NotFinite { name: "rolling" }),
        (MaterialTraits { spinning: 1.0e4, ..none }, Error::OutOfRange { name: "spinning" }),
        (
            MaterialTraits { surface_velocity: Vec3::new(0.0, 2.0e4, 0.0), ..none },
            Error::OutOfRange { name: "surface_velocity" },
        ),
        (MaterialTraits { one_way: Some(Vec3::ZERO), ..none }, Error::OutOfRange { name: "one_way" }),
        (
            MaterialTraits { one_way: Some(Vec3::splat(f32::INFINITY)), ..none },
            Error::NotFinite { name: "one_way" },
        ),
    ] {
        assert_eq!(world.set_material_traits(shape, &traits), Err(error));
        assert_eq!(ShapeDef { traits, ..ball(0.5) }.check(), Err(error));
    }
    assert_eq!(world.checksum(), state);
    let all = MaterialTraits {
        friction_mix: Mix::Min,
        restitution_mix: Mix::Mean,
        rolling: 1.0,
        spinning: 2.0,
        surface_velocity: Vec3::new(1.0, 2.0, 3.0),
        one_way: Some(Vec3::new(0.0, -4.0, 0.0)),
    };
    world.set_material_traits(shape, &all).expect("in range");
    let unit = MaterialTraits { one_way: Some(Vec3::new(0.0, -1.0, 0.0)), ..all };
    assert_eq!(world.shape(shape).expect("it exists").traits, unit);
}
