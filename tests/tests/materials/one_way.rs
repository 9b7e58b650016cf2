//! Platforms that are solid from one side.

use super::{RATE, ball, cuboid, dynamic, place, room};
use cellstep::math::Vec3;
use cellstep::{BodyDef, BodyHandle, BodyKind, MaterialTraits, Settings, ShapeDef, ShapeHandle};
use cellstep_tests::worlds::{OwnedWorld, add, run};

fn up() -> MaterialTraits {
    MaterialTraits { one_way: Some(Vec3::new(0.0, 0.0, 3.0)), ..MaterialTraits::default() }
}

/// A platform from z = -0.1 to 0.1 that is solid from above.
fn platform(world: &mut OwnedWorld) -> ShapeHandle {
    let def = BodyDef::new(BodyKind::Static, Vec3::ZERO);
    add(world, &def, &ShapeDef { traits: up(), ..cuboid(3.0, 3.0, 0.1) }).1
}

fn thrown(world: &mut OwnedWorld, z: f32, speed: f32) -> BodyHandle {
    let def = BodyDef { linear_velocity: Vec3::new(0.0, 0.0, speed), ..dynamic(0.0, 0.0, z) };
    add(world, &def, &cuboid(0.25, 0.25, 0.25)).0
}

fn height(world: &OwnedWorld, body: BodyHandle) -> f64 {
    place(world, body)[2]
}

#[test]
fn things_from_above_land_and_stay() {
    let mut world = room(6);
    platform(&mut world);
    let bodies: Vec<BodyHandle> = [(-0.9, 0.4, 0.0), (0.0, 3.0, 0.0), (0.9, 2.0, -20.0)]
        .into_iter()
        .map(|(x, z, speed)| {
            let def = BodyDef { linear_velocity: Vec3::new(0.0, 0.0, speed), ..dynamic(x, 0.0, z) };
            add(&mut world, &def, &cuboid(0.25, 0.25, 0.25)).0
        })
        .collect();
    let (round, _) = add(&mut world, &dynamic(0.0, 1.5, 1.0), &ball(0.25));
    run(&mut world, 3 * RATE);
    for body in bodies.into_iter().chain([round]) {
        assert!((height(&world, body) - 0.35).abs() < 2.0e-3, "{}", height(&world, body));
    }
}

#[test]
fn things_from_below_go_through_and_land_on_top() {
    let mut world = room(2);
    platform(&mut world);
    // Up to 0.1 m below, then 8 m/s: through, up by some 2.5 m, down again.
    let body = thrown(&mut world, -1.0, 8.0);
    let mut highest = -1.0;
    for _ in 0..3 * RATE {
        run(&mut world, 1);
        highest = height(&world, body).max(highest);
    }
    let free = -1.0 + 64.0 / (2.0 * 9.81);
    assert!((highest - free).abs() < 0.05, "{highest}, not {free}: something held it back");
    assert!((height(&world, body) - 0.35).abs() < 2.0e-3, "{}", height(&world, body));
}

/// Too slow to come out on top, it turns round inside and falls out below.
#[test]
fn things_that_turn_round_inside_fall_out() {
    let mut world = room(2);
    platform(&mut world);
    let body = thrown(&mut world, -1.0, 4.2);
    run(&mut world, 3 * RATE);
    assert!(height(&world, body) < -5.0, "{}", height(&world, body));
}

#[test]
fn things_that_start_inside_fall_out() {
    let mut world = room(3);
    platform(&mut world);
    let (inside, _) = add(&mut world, &dynamic(-1.0, 0.0, 0.2), &cuboid(0.25, 0.25, 0.25));
    let (on_top, _) = add(&mut world, &dynamic(1.0, 0.0, 0.349), &cuboid(0.25, 0.25, 0.25));
    run(&mut world, 2 * RATE);
    assert!(height(&world, inside) < -5.0);
    assert!((height(&world, on_top) - 0.35).abs() < 2.0e-3, "a millimetre inside is on it");
}

/// Something that stands on it stays when it is given another friction, and when it is taken back and put there.
#[test]
fn what_stands_on_it_stays_when_it_is_changed() {
    let mut world = room(3);
    let shape = platform(&mut world);
    let body = thrown(&mut world, 0.36, 0.0);
    let heavy =
        add(&mut world, &dynamic(0.0, 0.0, 1.2), &ShapeDef { density: 8.0e3, ..cuboid(0.3, 0.3, 0.5) }).0;
    run(&mut world, 2 * RATE);
    world.set_material(shape, 0.1, 0.0).expect("in range");
    let owner = world.body_of(shape).expect("it exists");
    for _ in 0..RATE {
        let (position, rotation) = (world.position(owner).expect("ok"), world.rotation(owner).expect("ok"));
        world.set_pose(owner, position, rotation).expect("the same pose");
        run(&mut world, 1);
    }
    assert!((height(&world, body) - 0.35).abs() < 3.0e-3, "{}", height(&world, body));
    assert!((height(&world, heavy) - 1.1).abs() < 2.0e-2, "{}", height(&world, heavy));
}

/// The direction goes with the shape; and of two dynamic bodies one may be one-way.
#[test]
fn a_dynamic_body_may_be_one_way() {
    let mut world = room(4);
    world.set_settings(&Settings { gravity: Vec3::ZERO, ..Settings::default() }).expect("in range");
    let shield = MaterialTraits { one_way: Some(Vec3::X), ..MaterialTraits::default() };
    for (row, from, passes) in [(0.0, 2.0_f32, false), (4.0, -2.0, true)] {
        let (plate, _) =
            add(&mut world, &dynamic(0.0, row, 0.0), &ShapeDef { traits: shield, ..cuboid(0.1, 0.5, 0.5) });
        let def = BodyDef { linear_velocity: Vec3::new(-2.0 * from, 0.0, 0.0), ..dynamic(from, row, 0.0) };
        let (shot, _) = add(&mut world, &def, &ball(0.2));
        run(&mut world, RATE);
        let moved = world.linear_velocity(plate).expect("it exists").x.abs() > 0.01;
        assert_eq!(moved, !passes, "from x = {from}");
        let beyond = (place(&world, shot)[0] - place(&world, plate)[0]) * f64::from(from) < 0.0;
        assert_eq!(beyond, passes);
    }
}

/// A sleeping load is not woken by what passes below, and stands when it wakes.
#[test]
fn a_sleeping_load_stays() {
    let mut world = room(3);
    world.set_settings(&Settings { sleep_time: 0.5, ..Settings::default() }).expect("in range");
    platform(&mut world);
    let body = thrown(&mut world, 0.36, 0.0);
    run(&mut world, 2 * RATE);
    assert_eq!(world.is_asleep(body), Ok(true));
    world.wake(body).expect("it exists");
    run(&mut world, 2);
    assert_eq!(world.is_asleep(body), Ok(false));
    run(&mut world, 2 * RATE);
    assert!((height(&world, body) - 0.35).abs() < 2.0e-3);
    assert_eq!(world.is_asleep(body), Ok(true));
}
