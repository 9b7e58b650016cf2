//! The contract for many of something: contacts and joints of one body, bodies in a column, joints that contradict
//! each other.

use cellstep::math::{Pose, Rotation, Vec3};
use cellstep::{
    Axis, BodyDef, BodyHandle, BodyKind, Capacities, Error, Executor, Geometry, JointDef, Pool, Preset,
    Serial, Settings, ShapeDef,
};
use cellstep_tests::extremes::Attack;
use cellstep_tests::jointed::at;
use cellstep_tests::oracles::{center, norm, velocity};
use cellstep_tests::worlds::{OwnedWorld, add, ground, world_with};

const CUBE: Geometry = Geometry::Box { half_extents: Vec3::splat(0.5) };

/// A plate on posts, with balls on it: `edge` squared of each.
fn crowded(edge: u16, preset: Preset) -> OwnedWorld {
    let count = u32::from(edge) * u32::from(edge);
    let capacities = Capacities {
        bodies: 2 * count + 1,
        shapes: 2 * count + 1,
        pairs: 30 * count + 64,
        contacts: 6 * count + 64,
        ..Capacities::for_bodies(0)
    };
    let mut world = world_with(capacities);
    world.set_settings(&Settings::from(preset)).expect("in range");
    let half = 0.1 * f32::from(edge);
    let place = |i: u16, z: f32| {
        let (x, y) = (f32::from(i % edge), f32::from(i / edge));
        Vec3::new(0.2 * x + 0.1 - half, 0.2 * y + 0.1 - half, z)
    };
    for i in 0..edge * edge {
        let post = ShapeDef::new(Geometry::Box { half_extents: Vec3::new(0.05, 0.05, 0.1) });
        add(&mut world, &BodyDef::new(BodyKind::Static, place(i, -0.1)), &post);
    }
    let plate = ShapeDef::new(Geometry::Box { half_extents: Vec3::new(half, half, 0.1) });
    add(&mut world, &BodyDef::new(BodyKind::Dynamic, Vec3::Z * 0.1), &plate);
    for i in 0..edge * edge {
        let ball = ShapeDef::new(Geometry::Sphere { radius: 0.09 });
        add(&mut world, &BodyDef::new(BodyKind::Dynamic, place(i, 0.29)), &ball);
    }
    world
}

/// Steps that scene and gives its checksum.
fn watch((edge, steps): (u16, u32), preset: Preset, executor: &mut impl Executor) -> u64 {
    let mut world = crowded(edge, preset);
    for _ in 0..steps {
        let contacts = checked(&mut world, executor);
        assert!(contacts >= 2 * u32::from(edge) * u32::from(edge), "{contacts} contacts");
    }
    let plate = world.bodies().nth(usize::from(edge) * usize::from(edge)).expect("the plate");
    let [_, _, z] = center(&world, plate);
    assert!((z - 0.1).abs() < 0.05, "{}: the plate is at {z} m", preset.name());
    world.checksum()
}

#[test]
fn a_body_has_as_many_contacts_as_there_is_room_for() {
    // 224 x 224 balls and as many posts: 1e5 contacts of one plate.
    for (edge, steps, presets) in [(40, 20, &Preset::ALL[..]), (224, 2, &[Preset::Balanced])] {
        for &preset in presets {
            let one = watch((edge, steps), preset, &mut Serial);
            let three = watch((edge, steps), preset, &mut Pool::new(3).expect("threads can be started"));
            assert_eq!(one, three, "{} with 3 workers", preset.name());
        }
    }
}

/// A step that drops and loses nothing; its contacts.
fn checked(world: &mut OwnedWorld, executor: &mut impl Executor) -> u32 {
    let report = world.step(executor);
    assert_eq!((report.dropped, report.quarantined), (0, 0));
    assert!(report.phases <= 8);
    report.contacts
}

#[test]
fn a_body_has_ten_thousand_joints() {
    // Not at `exact`: a hub that weighs a tenth of what hangs on it is thrown there.
    for preset in [Preset::Fast, Preset::Balanced, Preset::Accurate] {
        let sum = |workers: usize| {
            let count = 10_000_u32;
            let mut world = world_with(Capacities { joints: count, ..Capacities::for_bodies(count + 1) });
            world.set_settings(&Settings::from(preset)).expect("in range");
            let hub = world.create_body(&BodyDef::new(BodyKind::Static, Vec3::ZERO)).expect("room");
            let wheel = cellstep_tests::jointed::massive(
                &mut world,
                Pose::IDENTITY,
                cellstep_tests::jointed::ball(1.0, 1.0),
            );
            world.create_joint(&JointDef::ball([hub, wheel], [Pose::IDENTITY; 2])).expect("room");
            for i in 1..count {
                let angle = i as f32 * 0.01;
                let way = Vec3::new(cellstep::math::cos(angle), 0.0, cellstep::math::sin(angle));
                let place = way * (0.5 + 0.5 / i as f32);
                let mass = cellstep_tests::jointed::ball(0.001, 0.1);
                let body = cellstep_tests::jointed::massive(&mut world, at(place), mass);
                let frames = [at(place), Pose::IDENTITY];
                world.create_joint(&JointDef::ball([wheel, body], frames)).expect("room");
            }
            let mut pool = Pool::new(workers).expect("threads can be started");
            for _ in 0..4 {
                checked(&mut world, &mut pool);
            }
            let speeds = world.bodies().map(|body| norm(velocity(&world, body)));
            let fastest = speeds.fold(0.0, f64::max);
            println!("{}: {fastest} m/s", preset.name());
            assert!(fastest < 100.0, "{}: {fastest} m/s", preset.name());
            world.checksum()
        };
        assert_eq!(sum(1), sum(3), "{}", preset.name());
    }
}

#[test]
fn columns_of_any_height_keep_the_contract() {
    for (height, steps) in [(10, 60), (100, 60), (1000, 10), (10_000, 2)] {
        let build = |world: &mut OwnedWorld| {
            ground(world, 0.6);
            for i in 0..height {
                let def = BodyDef::new(BodyKind::Dynamic, Vec3::Z * (0.5 + i as f32));
                add(world, &def, &ShapeDef::new(CUBE));
            }
        };
        let name = format!("column of {height}");
        Attack { steps, ..Attack::new(&name, height + 1, &build) }.check();
    }
}

#[test]
fn joints_that_contradict_each_other_keep_the_contract() {
    type Place = fn(usize) -> Vec3;
    let cases: [(&str, Place); 3] = [
        ("the same joint four times", |_| Vec3::ZERO),
        ("four joints 0.1 m apart", |i| Vec3::new(0.1 * i as f32, 0.0, 0.0)),
        ("four joints a kilometre apart", |i| Vec3::new(1000.0 * i as f32, 0.0, 0.0)),
    ];
    for (name, place) in cases {
        let build = |world: &mut OwnedWorld| {
            let base = world.create_body(&BodyDef::new(BodyKind::Static, Vec3::ZERO)).expect("room");
            let (body, _) = add(world, &BodyDef::new(BodyKind::Dynamic, -Vec3::Z), &ShapeDef::new(CUBE));
            for i in 0..4 {
                let frames = [at(place(i)), at(Vec3::Z)];
                let def = if i % 2 == 0 {
                    JointDef::ball([base, body], frames)
                } else {
                    JointDef::fixed([base, body], frames)
                };
                world.create_joint(&def).expect("room");
            }
        };
        let attack = Attack::new(name, 2, &build);
        // Joints that cannot close pull their bodies about by nudges, which lift weights.
        let capacities = Capacities { joints: 4, ..attack.capacities };
        Attack { capacities, driven: true, ..attack }.check();
    }
    // A ring of twelve that does not close by 0.3 m, and one whose first link is listed twice.
    let build = |world: &mut OwnedWorld| {
        let bodies: Vec<BodyHandle> = (0..12_u8)
            .map(|i| {
                let turn = Rotation::from_axis_angle(Vec3::Y, f32::from(i) * core::f32::consts::FRAC_PI_6);
                let place = turn.rotate(Vec3::X * 2.05);
                add(
                    world,
                    &BodyDef::new(BodyKind::Dynamic, place),
                    &ShapeDef::new(Geometry::Sphere { radius: 0.2 }),
                )
                .0
            })
            .collect();
        for i in 0..13 {
            let ends = [bodies[i % 12], bodies[(i + 1) % 12]];
            let frames = [at(Vec3::X * 0.5), at(Vec3::X * -0.5)];
            world.create_joint(&JointDef::ball(ends, frames)).expect("room");
        }
    };
    let attack = Attack::new("a ring that does not close", 13, &build);
    let capacities = Capacities { joints: 13, ..attack.capacities };
    Attack { capacities, driven: true, ..attack }.check();
}

#[test]
fn limits_that_cross_are_refused() {
    for preset in Preset::ALL {
        let mut world = world_with(Capacities { joints: 1, ..Capacities::for_bodies(2) });
        world.set_settings(&Settings::from(preset)).expect("in range");
        let base = world.create_body(&BodyDef::new(BodyKind::Static, Vec3::ZERO)).expect("room");
        let (body, _) = add(&mut world, &BodyDef::new(BodyKind::Dynamic, Vec3::Z), &ShapeDef::new(CUBE));
        let before = world.checksum();
        for (low, high) in [(1.0, -1.0), (f32::NAN, 1.0), (0.0, f32::NAN), (f32::INFINITY, 1.0)] {
            let mut def = JointDef::hinge([base, body], [Pose::IDENTITY; 2]);
            def.axes[cellstep::joint::axis::TURN_X] = Axis::limited(low, high);
            let refused = world.create_joint(&def).expect_err("the limits are wrong");
            assert!(matches!(refused, Error::NotFinite { .. } | Error::OutOfRange { .. }), "{refused}");
        }
        assert_eq!(world.checksum(), before);
    }
}
