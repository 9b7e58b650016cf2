//! Positions are a sector and an offset: moving everything by whole sectors changes no bit of the motion, of what
//! queries find, or of what is saved, sent and recorded.

mod asked;
mod border;
mod origins;
mod player;

use cellstep::math::Vec3;
use cellstep::scene::builtin::Builtin;
use cellstep::{BodyDef, BodyKind, Geometry, Position, Serial, ShapeDef};
use cellstep_tests::sectors::{SHIFTS, Shift, assert_same_but_for, move_bodies};
use cellstep_tests::worlds::{OwnedWorld, add, run, world};

/// A scene at its golden size, every body moved by whole sectors.
fn shifted(name: &str, sectors: Shift) -> OwnedWorld {
    let builtin = Builtin::find(name).expect("built in");
    let scene = builtin.scene(builtin.golden_size).expect("golden size");
    let mut world = scene.build(std::path::Path::new(".")).expect("builds").world;
    move_bodies(&mut world, Vec3::ZERO, sectors);
    world
}

#[test]
fn a_shift_by_whole_sectors_changes_no_bit() {
    for (index, name) in ["mixed_pile", "level", "stacked_pyramid", "bowls", "ragdolls", "bridge", "cars"]
        .into_iter()
        .enumerate()
    {
        let shifts = [SHIFTS[3], SHIFTS[index]];
        let mut here = shifted(name, [0; 3]);
        let mut there = shifts.map(|sectors| shifted(name, sectors));
        for step in 0..120 {
            here.step(&mut Serial);
            for (there, sectors) in there.iter_mut().zip(shifts) {
                there.step(&mut Serial);
                if step % 20 == 19 {
                    assert_same_but_for(sectors, &here, there, &format!("{name} step {step}"));
                }
            }
        }
        assert!(here.contacts().count() > 20 || here.joint_count() > 20, "{name}: bodies touch");
    }
}

#[test]
fn slow_bodies_move_ten_thousand_kilometres_out() {
    // In plain f32 a body at 10,000 km would stand still below 60 m/s.
    let mut world = world(1);
    let start = Position::from_f64([1.0e7, -1.0e7, 3.0]);
    let def = BodyDef {
        position: start,
        linear_velocity: Vec3::new(1.0e-3, 0.0, 0.0),
        gravity_scale: 0.0,
        ..BodyDef::default()
    };
    let shape = ShapeDef::new(Geometry::Sphere { radius: 0.5 });
    let (body, _) = add(&mut world, &def, &shape);
    run(&mut world, 600);
    let moved = world.position(body).expect("alive").minus(start);
    assert!((moved.x - 0.01).abs() < 1.0e-5, "{moved}");
}

#[test]
fn bodies_on_both_sides_of_a_sector_border_touch() {
    // The border runs through x = 32 m: a plank lies across it on two posts, one on each side.
    let mut world = world(4);
    for x in [31.0, 33.5] {
        let post = world.create_body(&BodyDef::new(BodyKind::Static, Vec3::new(x, 0.0, 0.5))).expect("room");
        let shape = ShapeDef::new(Geometry::Box { half_extents: Vec3::new(0.2, 0.5, 0.5) });
        world.create_shape(post, &shape).expect("room");
    }
    let plank = ShapeDef::new(Geometry::Box { half_extents: Vec3::new(2.0, 0.4, 0.1) });
    let (plank, _) = add(&mut world, &BodyDef::new(BodyKind::Dynamic, Vec3::new(32.25, 0.0, 1.1)), &plank);
    run(&mut world, 600);
    let place = world.position(plank).expect("alive").to_f64();
    assert!((place[2] - 1.1).abs() < 2.0e-3 && (place[0] - 32.25).abs() < 2.0e-3, "{place:?}");
}
