//! Refinement: small islands under great load have substeps of their own, and nobody else pays for it or sees it.

use cellstep::config::{
    COARSEN_STEPS, CONTACT_COUPLING, REFINE, REFINE_BODIES, REFINE_CONTACTS, REFINE_STEPS, STATIC_STIFFNESS,
};
use cellstep::math::Vec3;
use cellstep::{
    AxisMotion, BodyDef, BodyHandle, BodyKind, Capacities, Geometry, JointDef, Position, Serial, Settings,
    ShapeDef,
};
use cellstep_tests::executors::Shuffled;
use cellstep_tests::jointed::at;
use cellstep_tests::oracles::{GRAVITY, center, judge, relative};
use cellstep_tests::simulator::snapshot;
use cellstep_tests::worlds::{OwnedWorld, add, ground, run, world_with};

const CUBE: Geometry = Geometry::Box { half_extents: Vec3::splat(0.5) };

fn empty() -> OwnedWorld {
    let mut world = world_with(Capacities { joints: 16, ..Capacities::for_bodies(300) });
    ground(&mut world, 0.6);
    world
}

fn cube(world: &mut OwnedWorld, place: Vec3, density: f32) -> BodyHandle {
    let def = BodyDef { position: Position::at(place), ..BodyDef::default() };
    add(world, &def, &ShapeDef { density, ..ShapeDef::new(CUBE) }).0
}

/// Unit cubes of water, one on the other.
fn column(world: &mut OwnedWorld, x: f32, cubes: u32) -> Vec<BodyHandle> {
    (0..cubes).map(|i| cube(world, Vec3::new(x, 0.0, 0.5 + i as f32), 1000.0)).collect()
}

fn refined(world: &mut OwnedWorld) -> u32 {
    world.step(&mut Serial).refined
}

#[test]
fn a_column_of_forty_sinks_by_the_law_of_its_own_substeps() {
    let mut world = empty();
    let cubes = column(&mut world, 0.0, 40);
    run(&mut world, 600);
    assert_eq!(refined(&mut world), 40);
    let frequency = f64::from(CONTACT_COUPLING) * 240.0 * f64::from(REFINE);
    let law = GRAVITY / (core::f64::consts::TAU * frequency).powi(2)
        * (40.0 * 39.0 + 40.0 * f64::from(STATIC_STIFFNESS).powi(-2));
    let sunk = 39.5 - center(&world, cubes[39])[2];
    judge(&format!("refined column of 40 sinks {:.2} mm", 1e3 * sunk), relative(sunk, law), [1.0e-3, 1.0e-2]);
    let mut worst = 0.0_f64;
    for contact in world.contacts() {
        let upper = cubes.iter().position(|cube| *cube == contact.bodies[1]).expect("a cube is above");
        let weight = (40 - upper) as f64 * 1000.0 * GRAVITY;
        worst = worst.max(relative(f64::from(contact.normal_force()), weight));
    }
    judge("forces in a refined column", worst, [1.0e-4, 1.0e-2]);
}

#[test]
fn an_island_is_refined_while_its_load_is_great() {
    let mut world = empty();
    let light = cube(&mut world, Vec3::new(0.0, 0.0, 0.5), 1000.0);
    let heavy = cube(&mut world, Vec3::new(0.0, 0.0, 1.5), 100_000.0);
    let alone = cube(&mut world, Vec3::new(9.0, 0.0, 0.5), 1000.0);
    run(&mut world, 60);
    assert_eq!(refined(&mut world), 2);
    let rest = center(&world, light);
    world.remove_body(heavy).expect("it is there");
    run(&mut world, COARSEN_STEPS as u32);
    assert_eq!(refined(&mut world), 0);
    // Let go, the lower cube comes up by what it had sunk, and by no more.
    run(&mut world, 60);
    let (up, still) = (center(&world, light)[2] - rest[2], center(&world, alone)[2]);
    assert!(up > 0.0 && up < 0.01, "{up}");
    assert!((center(&world, light)[2] - still).abs() < 1.0e-4, "it lies like the other one");
}

#[test]
fn an_island_that_begins_at_rest_is_refined_at_once_and_let_go() {
    let mut world = empty();
    column(&mut world, 9.0, 2);
    // So light that neither contact sinks enough.
    for (i, density) in [1000.0, 10.0, 10.0].into_iter().enumerate() {
        cube(&mut world, Vec3::new(0.0, 0.0, 0.5 + i as f32), density);
    }
    assert_eq!(refined(&mut world), 3, "three and not two");
    run(&mut world, COARSEN_STEPS as u32);
    assert_eq!(refined(&mut world), 0);
    // What is put on them is no island of its own.
    cube(&mut world, Vec3::new(9.0, 0.0, 2.5), 1000.0);
    assert_eq!(refined(&mut world), 0);
}

#[test]
fn an_island_begins_whatever_else_there_is() {
    let mut world = world_with(Capacities::for_bodies(1200));
    ground(&mut world, 0.6);
    for i in 0..REFINE_CONTACTS + 64 {
        cube(&mut world, Vec3::new((i % 40) as f32 * 2.0, (i / 40) as f32 * 2.0 + 4.0, 0.5), 1000.0);
    }
    run(&mut world, REFINE_STEPS as u32 + 2);
    assert_eq!(refined(&mut world), 0, "cubes that lie alone");
    column(&mut world, 0.0, 3);
    assert_eq!(refined(&mut world), 3, "between two looks at the loads");
}

#[test]
fn what_falls_is_not_refined_before_it_bears_a_load() {
    for gap in [0.0, 0.005, 0.05] {
        let mut world = empty();
        for (x, cubes) in [(0.0, 2), (9.0, 10)] {
            for i in 0..cubes {
                let height = 0.5 + 0.05 + i as f32 * (1.0 + gap);
                cube(&mut world, Vec3::new(x, 0.0, height), 1000.0);
            }
        }
        // A fall of 50 mm takes 6 steps.
        (0..6).for_each(|step| assert_eq!(refined(&mut world), 0, "step {step} of the fall"));
        run(&mut world, 2 * COARSEN_STEPS as u32);
        assert_eq!(refined(&mut world), 10, "the tall one only, gaps of {gap}");
    }
}

#[test]
fn a_row_that_waits_for_a_blow_is_not_refined() {
    let mut world = empty();
    let mut ball = |x: f32, speed: f32| {
        let def = BodyDef {
            position: Position::at(Vec3::new(x, 0.0, 0.25)),
            linear_velocity: Vec3::X * speed,
            ..BodyDef::default()
        };
        let shape =
            ShapeDef { restitution: 1.0, friction: 0.0, ..ShapeDef::new(Geometry::Sphere { radius: 0.25 }) };
        add(&mut world, &def, &shape);
    };
    (0..5).for_each(|i| ball(0.5 * i as f32, 0.0));
    ball(-1.5, 4.0);
    // It takes 15 steps to come.
    (0..14).for_each(|step| assert_eq!(refined(&mut world), 0, "step {step}"));
}

/// Blocks on a table's edge, each as far out as the harmonic series allows, times `share`. True when they stand for
/// a minute.
fn hang_over(count: u8, share: f32) -> bool {
    let mut world = empty();
    let table = world.create_body(&BodyDef::new(BodyKind::Static, Vec3::new(-2.0, 0.0, 2.5))).expect("room");
    let top = ShapeDef::new(Geometry::Box { half_extents: Vec3::new(2.0, 1.0, 0.5) });
    world.create_shape(table, &top).expect("room");
    let (mut x, mut blocks) = (-0.5, Vec::new());
    for i in 0..count {
        x += share * 0.5 / f32::from(count - i);
        let place = Vec3::new(x, 0.0, 3.1 + 0.2 * f32::from(i));
        let block = ShapeDef::new(Geometry::Box { half_extents: Vec3::new(0.5, 0.25, 0.1) });
        blocks.push(add(&mut world, &BodyDef::new(BodyKind::Dynamic, place), &block).0);
    }
    run(&mut world, 3600);
    let fallen = 3.1 + 0.2 * f64::from(count - 1) - center(&world, blocks[usize::from(count) - 1])[2];
    fallen.abs() < 0.02
}

#[test]
fn blocks_hang_over_within_a_hundredth_of_balance() {
    for count in 2..=6 {
        assert!(hang_over(count, 0.99), "{count} blocks");
        assert!(!hang_over(count, 1.01), "{count} blocks");
    }
}

#[test]
fn a_world_whose_refined_bodies_are_removed_is_accepted() {
    let mut world = empty();
    let cubes = column(&mut world, 0.0, 20);
    run(&mut world, 60);
    assert_eq!(refined(&mut world), 20);
    for cube in cubes {
        world.remove_body(cube).expect("it is there");
    }
    let bytes = snapshot(&world);
    assert_eq!(world.load(&bytes), Ok(()));
    assert_eq!(refined(&mut world), 0);
}

#[test]
fn large_islands_are_not_refined() {
    let mut world = empty();
    column(&mut world, 0.0, REFINE_BODIES + 1);
    run(&mut world, 60);
    assert_eq!(refined(&mut world), 0);
    let settings = Settings { refine_bodies: REFINE_BODIES + 1, ..world.settings() };
    world.set_settings(&settings).expect("settings are in range");
    run(&mut world, 2 * REFINE_STEPS as u32);
    assert_eq!(refined(&mut world), REFINE_BODIES + 1);
    world.set_settings(&Settings { refine: 1, ..settings }).expect("settings are in range");
    assert_eq!(refined(&mut world), 0, "switched off at once");
}

#[test]
fn other_islands_have_the_same_bits() {
    let scene = |refine: u32| {
        let mut world = empty();
        let settings = Settings { refine, refine_sink: 4.0e-3, ..world.settings() };
        world.set_settings(&settings).expect("settings are in range");
        column(&mut world, 0.0, 30);
        // They slide, and carry nothing.
        let others: Vec<_> = (0..5)
            .map(|i| {
                let other = cube(&mut world, Vec3::new(9.0 + 3.0 * i as f32, 0.0, 0.5), 1000.0);
                let velocity = Vec3::new(0.5, 3.0 + i as f32, 0.0);
                world.set_linear_velocity(other, velocity).expect("it is there");
                other
            })
            .collect();
        run(&mut world, 120);
        let sum = |body: &BodyHandle| world.body_checksum(*body).expect("it is there");
        (others.iter().map(sum).collect::<Vec<_>>(), world.step(&mut Serial).refined)
    };
    let ((plain, none), (others, some)) = (scene(1), scene(4));
    assert_eq!((none, some), (0, 30));
    assert_eq!(plain, others);
}

/// Loads that come and go: a column, a swing under a heavy weight, and something that falls from one to the other.
fn busy() -> OwnedWorld {
    let mut world = empty();
    column(&mut world, 0.0, 24);
    for x in [4.0, 8.0] {
        let lower = cube(&mut world, Vec3::new(x, 0.0, 0.5), 1000.0);
        let upper = cube(&mut world, Vec3::new(x + 0.3, 0.0, 1.5), 60_000.0);
        let swing = cube(&mut world, Vec3::new(x + 0.3, 0.0, 3.5), 1000.0);
        let ball = JointDef::ball([upper, swing], [at(Vec3::Z * 0.5), at(Vec3::Z * -1.5)]);
        world.create_joint(&ball).expect("there is room");
        // Two joints that hold make an articulation.
        let tail = cube(&mut world, Vec3::new(x + 0.3, 0.0, 5.0), 1000.0);
        let ball = JointDef::ball([swing, tail], [at(Vec3::Z * 0.75), at(Vec3::Z * -0.75)]);
        world.create_joint(&ball).expect("there is room");
        let mut rope = JointDef::six_axis([lower, swing], [at(Vec3::Z * 0.5), at(Vec3::Z * -2.5)]);
        for axis in &mut rope.axes[..3] {
            axis.motion = AxisMotion::Limited { lower: -1.0, upper: 1.0 };
        }
        world.create_joint(&rope).expect("there is room");
    }
    for i in 0..30 {
        let place = Vec3::new(-3.0 + 0.4 * i as f32, 0.3, 6.0 + 2.0 * (i % 7) as f32);
        cube(&mut world, place, if i % 5 == 0 { 40_000.0 } else { 500.0 });
    }
    world
}

#[test]
fn bits_do_not_depend_on_executors_or_caches() {
    let (mut one, mut two, mut three) = (busy(), busy(), busy());
    let mut shuffled = Shuffled::new(7);
    let mut counts = Vec::new();
    for step in 0..240 {
        if step == 101 {
            // An island that begins at rest.
            for world in [&mut one, &mut two, &mut three] {
                column(world, -9.0, 4);
            }
        }
        counts.push(refined(&mut one));
        two.step(&mut shuffled);
        assert!(one.state() == two.state(), "step {step}: another order of tasks");
        let bytes = snapshot(&three);
        three.load(&bytes).expect("its own snapshot");
        three.step(&mut Serial);
        assert!(one.state() == three.state(), "step {step}: without caches");
    }
    counts.dedup();
    assert!(counts.len() > 4, "islands were refined and let go: {counts:?}");
}

#[test]
fn a_restore_brings_the_tiers_back() {
    let mut world = busy();
    run(&mut world, 50);
    column(&mut world, -9.0, 4);
    let early = snapshot(&world);
    let mut states = Vec::new();
    for _ in 0..120 {
        world.step(&mut Serial);
        states.push(world.state().to_vec());
    }
    for _ in 0..2 {
        world.restore(&early).expect("its own snapshot");
        for (step, state) in states.iter().enumerate() {
            world.step(&mut Serial);
            assert!(world.state() == *state, "another state {step} steps after the restore");
        }
    }
}
