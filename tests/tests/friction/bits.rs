//! Friction by points is as exact in its bits as all else: the same on every executor, after a restore, and where a
//! contact has one point the same as that of patches. It gives no energy.

use super::{CUBE, MODELS, with, world_of};
use cellstep::math::{Rotation, Vec3};
use cellstep::scene::builtin::Builtin;
use cellstep::{
    BodyDef, BodyHandle, BodyKind, ContactModel, Executor, FrictionModel, Geometry, Pool, Serial, Settings,
    ShapeDef,
};
use cellstep_tests::executors::{Random, Shuffled};
use cellstep_tests::oracles::{GRAVITY, center, mass, norm, spin_energy, velocity};
use cellstep_tests::simulator::snapshot;
use cellstep_tests::worlds::{OwnedWorld, add, ground, run};
use std::path::Path;

/// Boxes of all sizes thrown on a heap, some of them turning fast.
fn heap(settings: &Settings) -> OwnedWorld {
    let mut world = world_of(settings, 121);
    ground(&mut world, 0.5);
    let mut random = Random::new(11);
    for i in 0..120 {
        let mut size = || random.between(0.2, 0.5);
        let shape = Geometry::Box { half_extents: Vec3::new(size(), size(), size()) };
        let mut any = || random.between(-1.0, 1.0);
        let place = Vec3::new((i % 5) as f32, (i / 5 % 5) as f32, 0.6 + (i / 25) as f32) * 1.75;
        let def = BodyDef {
            rotation: Rotation::from_rotation_vector(Vec3::new(any(), any(), any())),
            linear_velocity: Vec3::new(any(), any(), any()) * 3.0,
            angular_velocity: Vec3::new(any(), any(), any()) * 8.0,
            ..BodyDef::new(BodyKind::Dynamic, place)
        };
        add(&mut world, &def, &ShapeDef { friction: 0.4, ..ShapeDef::new(shape) });
    }
    world
}

fn built(name: &str, size: u32, settings: &Settings) -> OwnedWorld {
    let scene = Builtin::find(name).expect("a built-in scene").scene(size).expect("in range");
    let mut world = scene.build(Path::new(".")).expect("built-in scenes build").world;
    world
        .set_settings(&Settings { friction_model: settings.friction_model, ..world.settings() })
        .expect("valid");
    world
}

#[test]
fn every_executor_gives_the_same() {
    for contact_model in [ContactModel::Soft, ContactModel::Split] {
        let settings = Settings { contact_model, residual: true, ..with(FrictionModel::Points) };
        let mut worlds = [0; 3].map(|_| heap(&settings));
        let mut pool = Pool::new(3).expect("threads");
        fn go(world: &mut OwnedWorld, executor: &mut impl Executor) -> Vec<Option<cellstep::Residuals>> {
            (0..90).map(|_| world.step(executor).residuals).collect()
        }
        let told = [
            go(&mut worlds[0], &mut Serial),
            go(&mut worlds[1], &mut Shuffled::new(9)),
            go(&mut worlds[2], &mut pool),
        ];
        assert!(told[0] == told[1] && told[0] == told[2], "{contact_model:?}");
        assert!(worlds[0].state() == worlds[1].state() && worlds[0].state() == worlds[2].state());
        assert!(told[0].iter().flatten().any(|r| r.biased.friction > 1.0e-4));
    }
}

#[test]
fn a_world_that_was_restored_goes_on_like_one_that_was_not() {
    let settings = with(FrictionModel::Points);
    let heaps = || heap(&settings);
    let piles = || built("mixed_pile", 120, &settings);
    let towers = || built("tower", 12, &settings);
    let pairs = [[heaps(), heaps()], [piles(), piles()], [towers(), towers()]];
    for [mut kept, mut other] in pairs {
        run(&mut kept, 40);
        other.load(&snapshot(&kept)).expect("its own");
        for step in 0..60 {
            kept.drop_caches();
            assert_eq!(kept.step(&mut Serial), other.step(&mut Serial), "step {step}");
            assert!(kept.state() == other.state(), "step {step}");
        }
        let at = snapshot(&other);
        run(&mut other, 20);
        other.restore(&at).expect("its own");
        assert!(other.state() == kept.state());
        assert_eq!(other.settings().friction_model, FrictionModel::Points);
    }
}

/// Balls have one point: its patch is its cone.
#[test]
fn contacts_of_one_point_are_as_they_were() {
    let worlds = MODELS.map(|model| {
        let mut world = world_of(&with(model), 65);
        ground(&mut world, 0.5);
        for i in 0..64 {
            let place =
                Vec3::new((i % 4) as f32 * 0.93, (i / 4 % 4) as f32 * 0.97, 0.5 + (i / 16) as f32 * 0.9);
            let ball = ShapeDef { friction: 0.5, ..ShapeDef::new(Geometry::Sphere { radius: 0.5 }) };
            add(&mut world, &BodyDef::new(BodyKind::Dynamic, place), &ball);
        }
        run(&mut world, 120);
        world.bodies().map(|body| center(&world, body)).collect::<Vec<_>>()
    });
    assert_eq!(worlds[0], worlds[1]);
}

/// Kinetic and potential energy, J.
fn energy(world: &OwnedWorld) -> f64 {
    let of = |body: BodyHandle| {
        if world.kind(body) != Ok(BodyKind::Dynamic) {
            return 0.0;
        }
        let (m, v) = (mass(world, body), norm(velocity(world, body)));
        0.5 * m * v * v + m * GRAVITY * center(world, body)[2] + spin_energy(world, body)
    };
    world.bodies().map(of).sum()
}

/// Push-out of overlap lifts a little; beyond that no step gives energy, in a heap that settles as little as where
/// a cube slides, turns and stops.
#[test]
fn no_energy_comes_of_it() {
    for contact_model in [ContactModel::Soft, ContactModel::Split] {
        let settings = Settings { contact_model, ..with(FrictionModel::Points) };
        let mut worlds = [heap(&settings), world_of(&settings, 2)];
        ground(&mut worlds[1], 0.5);
        let def = BodyDef {
            linear_velocity: Vec3::new(4.0, 1.0, 0.0),
            angular_velocity: Vec3::Z * 9.0,
            ..BodyDef::new(BodyKind::Dynamic, Vec3::Z * 0.5)
        };
        add(&mut worlds[1], &def, &ShapeDef { friction: 0.5, ..ShapeDef::new(CUBE) });
        for (world, share) in worlds.iter_mut().zip([1.0e-3, 1.0e-4]) {
            let (start, mut least) = (energy(world), f64::INFINITY);
            for step in 0..240 {
                world.step(&mut Serial);
                let now = energy(world);
                assert!(
                    now <= start && now <= least + share * start,
                    "{contact_model:?}, step {step}: {now}"
                );
                least = least.min(now);
            }
        }
    }
}

/// A world changes its model while it runs: what holds goes on holding.
#[test]
fn the_model_changes_under_way() {
    let mut world = built("tower", 10, &with(FrictionModel::Patch));
    run(&mut world, 120);
    let start: Vec<_> = world.bodies().map(|body| center(&world, body)).collect();
    for step in 0..120 {
        let settings = Settings { friction_model: MODELS[step % 2], ..world.settings() };
        world.set_settings(&settings).expect("valid");
        world.step(&mut Serial);
    }
    for (body, from) in world.bodies().zip(start) {
        let way = norm(cellstep_tests::oracles::minus(center(&world, body), from));
        assert!(way < 1.0e-3, "moved by {way} m");
    }
}
