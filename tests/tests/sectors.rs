//! Positions are a sector and an offset: moving everything by whole sectors changes no bit of the motion.

use cellstep::math::Vec3;
use cellstep::scene::builtin::Builtin;
use cellstep::{BodyDef, BodyKind, Geometry, Position, Serial, ShapeDef};
use cellstep_tests::worlds::{OwnedWorld, add, run, world};

/// A scene at its golden size, every body moved by whole sectors.
fn shifted(name: &str, sectors: [i32; 3]) -> OwnedWorld {
    let builtin = Builtin::find(name).expect("built in");
    let scene = builtin.scene(builtin.golden_size).expect("golden size");
    let mut build = scene.build(std::path::Path::new(".")).expect("builds");
    for &body in &build.bodies {
        let mut place = build.world.position(body).expect("alive");
        for (own, moved) in place.sector.iter_mut().zip(sectors) {
            *own += moved;
        }
        let rotation = build.world.rotation(body).expect("alive");
        build.world.set_pose(body, place, rotation).expect("inside the world");
    }
    build.world
}

/// Checks that two worlds are the same but for the sectors.
fn assert_same_but_for(sectors: [i32; 3], a: &OwnedWorld, b: &OwnedWorld, what: &str) {
    for body in a.bodies() {
        let (pa, pb) = (a.center(body).expect("alive"), b.center(body).expect("alive"));
        assert_eq!(pa.offset.to_array().map(f32::to_bits), pb.offset.to_array().map(f32::to_bits), "{what}");
        let moved: [i32; 3] = std::array::from_fn(|i| pb.sector[i] - pa.sector[i]);
        assert_eq!(moved, sectors, "{what}");
        assert_eq!(a.rotation(body), b.rotation(body), "{what}");
        assert_eq!(a.linear_velocity(body), b.linear_velocity(body), "{what}");
        assert_eq!(a.angular_velocity(body), b.angular_velocity(body), "{what}");
    }
    assert!(a.contacts().eq(b.contacts()), "{what}: contacts and impulses");
}

#[test]
fn a_shift_by_whole_sectors_changes_no_bit() {
    for name in ["mixed_pile", "level", "stacked_pyramid", "bowls"] {
        for sectors in [[156_250, -77_777, 4096], [-3, 1 << 20, 0]] {
            let mut here = shifted(name, [0; 3]);
            let mut there = shifted(name, sectors);
            for step in 0..120 {
                here.step(&mut Serial);
                there.step(&mut Serial);
                if step % 20 == 19 {
                    assert_same_but_for(sectors, &here, &there, &format!("{name} {sectors:?} step {step}"));
                }
            }
            assert!(here.contacts().count() > 20, "{name}: bodies touch");
        }
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
