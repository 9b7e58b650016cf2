//! Extremes, and materials beside what else there is: triangles with surfaces of their own, sleep, tall stacks.

use super::{RATE, ball, cuboid, dynamic, floor, place, rolling};
use cellstep::math::{Rotation, Vec3};
use cellstep::{
    BodyDef, BodyHandle, BodyKind, Capacities, Geometry, MaterialTraits, Mix, Settings, ShapeDef, Surface,
};
use cellstep_tests::executors::Random;
use cellstep_tests::oracles::{GRAVITY, judge, norm, relative, spin, velocity};
use cellstep_tests::worlds::{OwnedWorld, add, run, world_with};

fn room(bodies: u32) -> OwnedWorld {
    world_with(Capacities {
        materials: 16,
        meshes: 1,
        mesh_vertices: 8,
        mesh_triangles: 4,
        surfaces: 2,
        ..Capacities::for_bodies(bodies)
    })
}

/// A square of 40 m: the half with x < 0 has the first surface, that with x > 0 the second.
fn square(world: &mut OwnedWorld, surfaces: [Surface; 2], traits: MaterialTraits) {
    let corners = [-20.0, 0.0, 20.0].map(|x| [-20.0, 20.0].map(|y| Vec3::new(x, y, 0.0)));
    let triangles = [[0, 2, 1], [1, 2, 3], [2, 4, 3], [3, 4, 5]];
    let mesh = world
        .add_mesh_with_surfaces(corners.as_flattened(), &triangles, (&[0, 0, 1, 1], &surfaces))
        .expect("a square");
    let def = BodyDef::new(BodyKind::Static, Vec3::ZERO);
    add(world, &def, &ShapeDef { friction: 9.0, traits, ..ShapeDef::new(Geometry::Mesh(mesh)) });
}

fn surface(friction: f32) -> Surface {
    Surface { friction, restitution: 0.0 }
}

/// Triangles give friction; the shape's traits say how it is mixed, and move the surface.
#[test]
fn triangles_give_friction_and_the_shape_the_rest() {
    let mut world = room(4);
    let traits = MaterialTraits {
        friction_mix: Mix::Multiply,
        surface_velocity: Vec3::new(0.0, 30.0, 0.0),
        ..MaterialTraits::default()
    };
    square(&mut world, [surface(0.2), surface(0.4)], traits);
    let light = |x: f32| dynamic(x, -10.0, 0.1);
    let bodies = [-10.0, 10.0]
        .map(|x| add(&mut world, &light(x), &ShapeDef { friction: 0.5, ..cuboid(0.5, 0.5, 0.1) }).0);
    run(&mut world, RATE);
    for (body, friction) in bodies.into_iter().zip([0.1, 0.2]) {
        judge("carried", relative(velocity(&world, body)[1], friction * GRAVITY), [1.0e-2, 3.0e-2]);
    }
}

/// A ball on a mesh slows down as on a plane, over the edges of triangles too.
#[test]
fn balls_roll_to_a_halt_on_triangles() {
    let mut world = room(2);
    square(&mut world, [surface(0.6); 2], rolling(0.01));
    let def = BodyDef {
        linear_velocity: Vec3::new(3.0, 0.4, 0.0),
        angular_velocity: Vec3::new(-0.8, 6.0, 0.0),
        ..dynamic(-4.0, 0.3, 0.5)
    };
    let (body, _) = add(&mut world, &def, &ball(0.5));
    run(&mut world, 2 * RATE);
    let lost = f64::from(def.linear_velocity.length()) - norm(velocity(&world, body));
    judge("on a mesh", relative(lost, 2.0 * 5.0 / 7.0 * GRAVITY * 0.02), [1.0e-2, 3.0e-2]);
    assert!(place(&world, body)[0] > 0.5, "over the middle");
}

/// The longest resistance that is allowed holds everything, and lifts nothing.
#[test]
fn the_longest_resistance_gives_no_energy() {
    let mut world = world_with(Capacities { materials: 4, ..Capacities::for_bodies(130) });
    let traits = MaterialTraits { rolling: 1.0e3, spinning: 1.0e3, ..MaterialTraits::default() };
    floor(&mut world, ShapeDef { traits, ..ball(1.0) });
    let mut random = Random::new(4);
    let mut bodies = Vec::new();
    for i in 0..120 {
        let (x, y, z) = (i % 5, i / 5 % 5, i / 25);
        let jitter = random.between(-0.05, 0.05);
        let def = BodyDef {
            angular_velocity: Vec3::new(random.between(-9.0, 9.0), 5.0, random.between(-9.0, 9.0)),
            ..dynamic(x as f32 * 0.6 + jitter, y as f32 * 0.6 - jitter, z as f32 * 0.6 + 0.5)
        };
        let geometry = match i % 3 {
            0 => Geometry::Sphere { radius: 0.25 },
            1 => Geometry::Capsule { half_height: 0.15, radius: 0.15 },
            _ => Geometry::Cylinder { half_height: 0.2, radius: 0.2 },
        };
        bodies.push(add(&mut world, &def, &ShapeDef { traits, ..ShapeDef::new(geometry) }).0);
    }
    let energy = |world: &OwnedWorld| -> f64 { bodies.iter().map(|&body| energy_of(world, body)).sum() };
    let mut before = energy(&world);
    for step in 0..5 * RATE {
        run(&mut world, 1);
        let now = energy(&world);
        // Gravity and the push out of overlaps by soft contacts: never more than a little.
        assert!(now < before + 0.01 * before.abs() + 5.0, "step {step}: {before} J became {now} J");
        before = now;
    }
    let fastest = bodies.iter().map(|&body| norm(velocity(&world, body))).fold(0.0, f64::max);
    assert!(fastest < 0.1, "something still moves at {fastest} m/s");
}

/// Kinetic and potential energy, J.
fn energy_of(world: &OwnedWorld, body: BodyHandle) -> f64 {
    let mass = cellstep_tests::oracles::mass(world, body);
    let speed = norm(velocity(world, body));
    0.5 * mass * speed * speed
        + cellstep_tests::oracles::spin_energy(world, body)
        + mass * GRAVITY * place(world, body)[2]
}

/// Boxes that resist rolling settle as others do: a tower of them stands as still, to the bit.
#[test]
fn towers_of_boxes_that_resist_stand_like_others() {
    let tower = |traits: MaterialTraits| {
        let mut world = room(16);
        floor(&mut world, ShapeDef { traits, ..ball(1.0) });
        let boxes: Vec<BodyHandle> = (0..12)
            .map(|i| {
                let shape = ShapeDef { traits, ..cuboid(0.5, 0.5, 0.5) };
                add(&mut world, &dynamic(0.0, 0.0, 0.5 + i as f32), &shape).0
            })
            .collect();
        run(&mut world, 3 * RATE);
        boxes.iter().map(|&body| place(&world, body)).collect::<Vec<_>>()
    };
    assert_eq!(tower(rolling(0.05)), tower(MaterialTraits::default()));
}

/// A contact that resists no more keeps nothing of it.
#[test]
fn resistance_that_is_taken_away_leaves_nothing() {
    for sleeps in [false, true] {
        let mut world = room(3);
        let sleep_time = if sleeps { 0.3 } else { 0.0 };
        let gravity = Vec3::new(0.4, 0.0, -9.81);
        world.set_settings(&Settings { sleep_time, gravity, ..Settings::default() }).expect("in range");
        let (_, ground) = floor(&mut world, ball(1.0));
        let (body, shape) =
            add(&mut world, &dynamic(0.0, 0.0, 0.5), &ShapeDef { traits: rolling(0.1), ..ball(0.5) });
        run(&mut world, 3 * RATE);
        assert_eq!(world.is_asleep(body), Ok(sleeps));
        world.set_material_traits(shape, &MaterialTraits::default()).expect("needs no room");
        world.set_material_traits(ground, &MaterialTraits::default()).expect("needs no room");
        let mut other = room(3);
        let mut bytes = vec![0; world.snapshot_bytes()];
        world.save(&mut bytes).expect("room");
        assert_eq!(other.load(&bytes), Ok(()));
        run(&mut world, 2 * RATE);
        assert_eq!(world.contacts().next().expect("it lies").resistance, Vec3::ZERO);
        assert!(velocity(&world, body)[0] > 0.3, "it rolls down");
        let slip = velocity(&world, body)[0] - 0.5 * spin(&world, body)[1];
        assert!(slip.abs() < 1.0e-2);
    }
}

/// A cylinder that stands on its rim and one that lies: resistance is asked of two points, not of four.
#[test]
fn cylinders_stand_and_lie_with_resistance() {
    let mut world = room(4);
    floor(&mut world, ShapeDef { traits: rolling(0.02), ..ball(1.0) });
    let geometry = Geometry::Cylinder { half_height: 0.5, radius: 0.3 };
    let (upright, _) = add(&mut world, &dynamic(0.0, 0.0, 0.5), &ShapeDef::new(geometry));
    let lying = BodyDef {
        rotation: Rotation::from_axis_angle(Vec3::X, core::f32::consts::FRAC_PI_2),
        ..dynamic(3.0, 0.0, 0.3)
    };
    let (lying, _) = add(&mut world, &lying, &ShapeDef::new(geometry));
    run(&mut world, 2 * RATE);
    assert!((place(&world, upright)[2] - 0.5).abs() < 2.0e-3);
    assert!((place(&world, lying)[2] - 0.3).abs() < 2.0e-3);
    let points: Vec<u32> = world.contacts().map(|contact| contact.points).collect();
    assert_eq!(points, [4, 2]);
}
