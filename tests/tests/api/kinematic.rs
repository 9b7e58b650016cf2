//! Static and kinematic bodies: by velocity, to a target pose, and what stands on them.

use super::{GRAVITY, RATE, ball, close, cuboid, dynamic, near, place, spin, velocity, weightless};
use cellstep::math::{Rotation, Vec3};
use cellstep::{BodyDef, BodyHandle, BodyKind, Error, Position, ShapeDef};
use cellstep_tests::worlds::{self, OwnedWorld, add, run};

fn kinematic(x: f32, y: f32, z: f32) -> BodyDef {
    BodyDef::new(BodyKind::Kinematic, Vec3::new(x, y, z))
}

/// A platform of 10 x 10 m with its top at z = 0, and a box of 0.5 m on it.
fn platform(def: &BodyDef, at: [f32; 2]) -> (OwnedWorld, BodyHandle, BodyHandle) {
    let mut world = worlds::world(2);
    let (floor, _) =
        add(&mut world, &BodyDef { position: Position::at(Vec3::Z * -0.5), ..*def }, &cuboid(5.0, 5.0, 0.5));
    let (load, _) = add(&mut world, &dynamic(at[0], at[1], 0.25), &cuboid(0.25, 0.25, 0.25));
    (world, floor, load)
}

#[test]
fn static_bodies_do_not_move() {
    let mut world = worlds::world(2);
    let def = BodyDef {
        linear_velocity: Vec3::X,
        angular_velocity: Vec3::X,
        ..BodyDef::new(BodyKind::Static, Vec3::ZERO)
    };
    let (block, _) = add(&mut world, &def, &cuboid(1.0, 1.0, 1.0));
    add(&mut world, &dynamic(0.1, 0.2, 3.0), &cuboid(0.5, 0.5, 0.5));
    run(&mut world, 120);
    assert_eq!(place(&world, block), [0.0; 3]);
    assert_eq!(world.rotation(block), Ok(Rotation::IDENTITY));
    let needs_motion =
        |result: Result<(), Error>| assert!(matches!(result, Err(Error::WrongKind { .. })), "{result:?}");
    needs_motion(world.set_linear_velocity(block, Vec3::X));
    needs_motion(world.set_angular_velocity(block, Vec3::X));
    needs_motion(world.apply_force(block, Vec3::X));
    needs_motion(world.apply_impulse(block, Vec3::X));
    needs_motion(world.set_kinematic_target(block, Position::ORIGIN, Rotation::IDENTITY));
}

#[test]
fn kinematic_bodies_move_by_their_velocity() {
    let mut world = worlds::world(2);
    let def = BodyDef {
        linear_velocity: Vec3::new(1.0, -2.0, 0.5),
        angular_velocity: Vec3::Z,
        ..kinematic(0.0, 0.0, 0.0)
    };
    let (body, _) = add(&mut world, &def, &cuboid(1.0, 1.0, 1.0));
    // Something heavy in its way changes nothing.
    let wall = ShapeDef { density: 1.0e6, ..cuboid(1.0, 1.0, 1.0) };
    add(&mut world, &BodyDef { gravity_scale: 0.0, ..dynamic(2.5, -4.0, 1.0) }, &wall);
    run(&mut world, 2 * RATE);
    let [x, y, z] = place(&world, body);
    near(Vec3::new(x as f32, y as f32, z as f32), Vec3::new(2.0, -4.0, 1.0), 1.0e-4);
    near(
        world.rotation(body).expect("the body exists").imaginary(),
        Vec3::Z * cellstep::math::sin(1.0),
        1.0e-5,
    );
    assert_eq!(velocity(&world, body), def.linear_velocity);
    world.set_linear_velocity(body, Vec3::ZERO).expect("it is kinematic");
    world.set_angular_velocity(body, Vec3::ZERO).expect("it is kinematic");
    let before = (world.position(body), world.rotation(body));
    run(&mut world, 10);
    assert_eq!((world.position(body), world.rotation(body)), before);
}

#[test]
fn kinematic_bodies_arrive_at_their_target_and_stop() {
    let mut world = worlds::world(1);
    let (body, _) = add(&mut world, &kinematic(1.0, 2.0, 3.0), &cuboid(0.2, 0.3, 0.4));
    let targets = [
        (Position::at(Vec3::new(1.5, 2.0, 2.0)), Rotation::from_rotation_vector(Vec3::new(0.1, 0.2, -0.3))),
        (Position::at(Vec3::new(-4.0, 2.5, 2.0)), Rotation::from_rotation_vector(Vec3::new(-2.0, 1.0, 1.5))),
        // Into the next sector, and half a turn.
        (Position::at(Vec3::new(40.0, 2.5, 2.0)), Rotation::from_rotation_vector(Vec3::new(0.0, 3.1, 0.0))),
    ];
    for (position, rotation) in targets {
        world.set_kinematic_target(body, position, rotation).expect("it is kinematic");
        run(&mut world, 1);
        near(world.position(body).expect("the body exists").minus(position), Vec3::ZERO, 1.0e-5);
        let off = world.rotation(body).expect("the body exists").after(rotation.inverse());
        near(off.imaginary(), Vec3::ZERO, 1.0e-6);
        assert_eq!((velocity(&world, body), spin(&world, body)), (Vec3::ZERO, Vec3::ZERO), "it stops");
        let before = (world.position(body), world.rotation(body));
        run(&mut world, 3);
        assert_eq!((world.position(body), world.rotation(body)), before, "and stays");
    }
}

#[test]
fn the_target_of_an_eccentric_body_is_its_origins() {
    let mut world = worlds::world(1);
    let body = world.create_body(&kinematic(0.0, 0.0, 0.0)).expect("room");
    let pose = cellstep::math::Pose::new(Vec3::new(2.0, 0.0, 0.0), Rotation::IDENTITY);
    world.create_shape(body, &ShapeDef { pose, ..cuboid(0.5, 0.1, 0.1) }).expect("room");
    let target = (Position::at(Vec3::new(0.0, 1.0, 0.0)), Rotation::from_rotation_vector(Vec3::Z));
    world.set_kinematic_target(body, target.0, target.1).expect("it is kinematic");
    run(&mut world, 1);
    near(world.position(body).expect("the body exists").minus(target.0), Vec3::ZERO, 1.0e-5);
}

#[test]
fn a_moving_platform_carries_what_stands_on_it() {
    let def = BodyDef { linear_velocity: Vec3::new(1.0, 0.0, 0.0), ..kinematic(0.0, 0.0, 0.0) };
    let (mut world, floor, load) = platform(&def, [0.0, 0.0]);
    run(&mut world, 2 * RATE);
    near(velocity(&world, load), Vec3::X, 1.0e-3);
    // Until it had the platform's speed it slid back by v^2 / (2 mu g).
    let lag = place(&world, floor)[0] - place(&world, load)[0];
    close(lag, 1.0 / (2.0 * 0.6 * GRAVITY), 0.02 * lag);
    near(spin(&world, load), Vec3::ZERO, 1.0e-3);
}

#[test]
fn a_platform_moved_by_targets_carries_too() {
    let (mut world, floor, load) = platform(&kinematic(0.0, 0.0, 0.0), [0.0, 0.0]);
    // From rest up to 1 m/s in a second, and down as slowly: never more than friction can give.
    let mut way = 0.0;
    for step in 0..4 * RATE {
        let speed = cellstep::math::min(step.min(4 * RATE - step) as f32 / RATE as f32, 1.0);
        way += speed / RATE as f32;
        let target = Position::at(Vec3::new(way, 0.0, -0.5 + 0.1 * way));
        world.set_kinematic_target(floor, target, Rotation::IDENTITY).expect("it is kinematic");
        run(&mut world, 1);
    }
    run(&mut world, RATE);
    let ([x, _, z], [fx, _, fz]) = (place(&world, load), place(&world, floor));
    close(fx, 3.0, 1.0e-3);
    close(x - fx, 0.0, 5.0e-3);
    close(z - fz, 0.75, 3.0e-3);
    near(velocity(&world, load), Vec3::ZERO, 1.0e-3);
}

#[test]
fn a_spinning_platform_spins_what_stands_on_it() {
    let def = BodyDef { angular_velocity: Vec3::Z * 2.0, ..kinematic(0.0, 0.0, 0.0) };
    let (mut world, _, load) = platform(&def, [0.0, 0.0]);
    run(&mut world, 2 * RATE);
    near(spin(&world, load), Vec3::Z * 2.0, 2.0e-3);
    near(velocity(&world, load), Vec3::ZERO, 2.0e-3);
}

#[test]
fn a_turntable_carries_a_box_round() {
    let def = BodyDef { angular_velocity: Vec3::Z, ..kinematic(0.0, 0.0, 0.0) };
    let (mut world, floor, load) = platform(&def, [1.0, 0.0]);
    world.set_linear_velocity(load, Vec3::Y).expect("it is dynamic");
    world.set_angular_velocity(load, Vec3::Z).expect("it is dynamic");
    run(&mut world, 5 * RATE);
    // Where it stands on the table is where it stood at first.
    let frame = world.rotation(floor).expect("the body exists");
    let arm = world.position(load).expect("the body exists").minus(Position::ORIGIN);
    near(frame.unrotate(arm) * Vec3::new(1.0, 1.0, 0.0), Vec3::X, 1.0e-2);
    near(spin(&world, load), Vec3::Z, 2.0e-3);
}

#[test]
fn a_paddle_hits_a_ball_at_its_own_speed() {
    let mut world = weightless(2);
    let def = BodyDef { angular_velocity: Vec3::Z * 3.0, ..kinematic(0.0, 0.0, 0.0) };
    add(&mut world, &def, &ShapeDef { friction: 0.0, ..cuboid(2.0, 0.1, 0.5) });
    let (stone, _) = add(&mut world, &dynamic(1.5, 0.6, 0.0), &ShapeDef { friction: 0.0, ..ball(0.1) });
    run(&mut world, RATE);
    // Without bounce it takes the speed of the point that hit it, w r, along the normal, and then slides outwards
    // along the paddle: faster than that, never slower.
    let speed = velocity(&world, stone).length();
    assert!((4.0..9.0).contains(&speed), "{speed} m/s");
    assert!(place(&world, stone)[2].abs() < 1.0e-4);
}
