//! What steps measure of their own solve, and sweeps that go on until it is small.

use cellstep::math::{Pose, Rotation, Vec3};
use cellstep::scene::builtin::Builtin;
use cellstep::{
    Axis, BodyDef, BodyHandle, BodyKind, Capacities, ContactModel, Executor, FrictionModel, Geometry,
    JointDef, MaterialTraits, Pool, Residuals, Serial, Settings, ShapeDef, StepReport,
};
use cellstep_tests::executors::Shuffled;
use cellstep_tests::worlds::{OwnedWorld, add, ground, world_with};
use std::path::Path;

const CUBE: Geometry = Geometry::Box { half_extents: Vec3::splat(0.5) };
const MODELS: [(ContactModel, FrictionModel); 5] = [
    (ContactModel::Soft, FrictionModel::Patch),
    (ContactModel::Rigid, FrictionModel::Patch),
    (ContactModel::Split, FrictionModel::Patch),
    (ContactModel::Soft, FrictionModel::Points),
    (ContactModel::Split, FrictionModel::Points),
];

fn world(settings: &Settings) -> OwnedWorld {
    let mut world = world_with(Capacities { joints: 600, materials: 4, ..Capacities::for_bodies(700) });
    world.set_settings(settings).expect("in range");
    world
}

fn asking() -> Settings {
    Settings { residual: true, refine: 1, ..Settings::default() }
}

fn body(world: &mut OwnedWorld, place: Vec3, geometry: Geometry) -> BodyHandle {
    let shape = ShapeDef { friction: 0.5, ..ShapeDef::new(geometry) };
    add(world, &BodyDef::new(BodyKind::Dynamic, place), &shape).0
}

fn frames(a: Vec3, b: Vec3) -> [Pose; 2] {
    [Pose::new((b - a) * 0.5, Rotation::IDENTITY), Pose::new((a - b) * 0.5, Rotation::IDENTITY)]
}

/// Everything that has rows: walls of boxes, balls that roll with resistance, chains of plain and of limited
/// joints, a net, a kinematic body that pushes.
fn all(settings: &Settings) -> OwnedWorld {
    let mut world = world(settings);
    ground(&mut world, 0.6);
    for row in 0..12 {
        for i in 0..12 - row {
            let place = Vec3::new(1.01 * i as f32 + 0.5 * row as f32, 0.0, 0.5 + row as f32);
            body(&mut world, place, CUBE);
        }
    }
    for i in 0..60 {
        let place = Vec3::new(0.9 * (i % 10) as f32, 3.0 + 0.9 * (i / 10 % 3) as f32, 0.5 + (i / 30) as f32);
        let ball = ShapeDef { friction: 0.5, ..ShapeDef::new(Geometry::Sphere { radius: 0.5 }) };
        let ball = ShapeDef { traits: MaterialTraits { rolling: 0.02, ..ball.traits }, ..ball };
        add(&mut world, &BodyDef::new(BodyKind::Dynamic, place), &ball);
    }
    net(&mut world);
    chains(&mut world);
    let pusher = BodyDef {
        linear_velocity: Vec3::new(0.0, 1.0, 0.0),
        ..BodyDef::new(BodyKind::Kinematic, Vec3::new(3.0, -2.0, 0.6))
    };
    add(&mut world, &pusher, &ShapeDef::new(CUBE));
    world
}

/// A net of plain balls that falls on the ground.
fn net(world: &mut OwnedWorld) {
    let mut bodies: Vec<(BodyHandle, Vec3)> = Vec::new();
    for i in 0..100 {
        let place = Vec3::new((i % 10) as f32, 8.0 + (i / 10) as f32, 0.4 + 0.05 * (i % 7) as f32);
        let own = body(world, place, Geometry::Sphere { radius: 0.3 });
        for (fits, other) in [(i % 10 > 0, i - 1), (i >= 10, i - 10)] {
            if fits {
                let (other, from) = bodies[other as usize];
                world.create_joint(&JointDef::ball([other, own], frames(from, place))).expect("room");
            }
        }
        bodies.push((own, place));
    }
}

/// Chains of hinges with limits, which are solved at once, and a loose rope at the end of each.
fn chains(world: &mut OwnedWorld) {
    let base = world.create_body(&BodyDef::new(BodyKind::Static, Vec3::ZERO)).expect("room");
    for chain in 0..9 {
        let place = |i: u32| Vec3::new(1.5 * chain as f32, -8.0 - 0.6 * i as f32, 5.0);
        let mut before = (base, place(0));
        for i in 1..6 {
            let own = body(world, place(i), Geometry::Box { half_extents: Vec3::splat(0.2) });
            let at = if i == 1 { Vec3::ZERO } else { before.1 };
            let middle = (before.1 + place(i)) * 0.5;
            let ends = [
                Pose::new(middle - at, Rotation::IDENTITY),
                Pose::new(middle - place(i), Rotation::IDENTITY),
            ];
            let mut def = JointDef::hinge([before.0, own], ends);
            def.axes[3] = Axis { friction: 1.0, ..Axis::limited(-0.3, 0.05 * i as f32) };
            world.create_joint(&def).expect("room");
            before = (own, place(i));
        }
        let load = body(world, place(7), Geometry::Sphere { radius: 0.2 });
        world.create_joint(&JointDef::distance([before.0, load], [Vec3::ZERO; 2], 0.0, 1.21)).expect("room");
    }
}

fn step(world: &mut OwnedWorld, executor: &mut impl Executor, steps: u32) -> Vec<StepReport> {
    (0..steps).map(|_| world.step(executor)).collect()
}

fn residuals(report: &StepReport) -> Residuals {
    report.residuals.expect("asked for")
}

/// Where all bodies are and how they move, to the bit.
fn motion(world: &OwnedWorld) -> Vec<[u32; 10]> {
    let of = |body: BodyHandle| {
        let lives = "it lives";
        let place = world.position(body).expect(lives).offset;
        let turn = world.rotation(body).expect(lives);
        let (v, w) = (world.linear_velocity(body).expect(lives), world.angular_velocity(body).expect(lives));
        [place.x, place.y, place.z, turn.x, turn.y, turn.z, v.x, v.y, w.x, w.y].map(f32::to_bits)
    };
    world.bodies().map(of).collect()
}

#[test]
fn nothing_is_left_where_nothing_acts() {
    let mut world = world(&asking());
    let ball = body(&mut world, Vec3::Z * 50.0, Geometry::Sphere { radius: 0.5 });
    for report in step(&mut world, &mut Serial, 30) {
        assert_eq!(residuals(&report), Residuals::default(), "a ball falls");
    }
    ground(&mut world, 0.5);
    let place = cellstep::Position::at(Vec3::Z * 0.5);
    world.set_pose(ball, place, Rotation::IDENTITY).expect("it lives");
    world.set_linear_velocity(ball, Vec3::ZERO).expect("dynamic");
    let reports = step(&mut world, &mut Serial, 60);
    let last = residuals(&reports[59]);
    assert!(last.biased.greatest() < 1.0e-6 && last.last.greatest() < 1.0e-6, "a ball rests: {last:?}");
    let quiet = Settings { residual: false, ..asking() };
    world.set_settings(&quiet).expect("in range");
    assert_eq!(world.step(&mut Serial).residuals, None, "nobody asks");
}

#[test]
fn it_is_a_velocity() {
    // A ball slides on the ground. Friction comes before the normal, and finds no load in the first sweep of all:
    // what it lacks is mu m g h, which changes the slip by 1 / m + r2 / (2/5 m r2) = 7 / (2 m) of that.
    let (friction, sweeps) = (0.5, 1);
    for slip in [0.1, 5.0] {
        let rigid =
            Settings { contact_model: ContactModel::Rigid, substeps: 1, relax_sweeps: 0, sweeps, ..asking() };
        let mut world = world(&rigid);
        ground(&mut world, friction);
        let ball = body(&mut world, Vec3::Z * 0.5, Geometry::Sphere { radius: 0.5 });
        world.set_linear_velocity(ball, Vec3::new(0.6, 0.8, 0.0) * slip).expect("dynamic");
        let found = residuals(&world.step(&mut Serial)).last;
        let lacks = 3.5 * friction * 9.81 * rigid.substep();
        // Where less is enough to hold it, the whole slip is left.
        let expected = if slip < lacks { slip } else { lacks };
        assert!((found.friction - expected).abs() < 1.0e-5 * expected, "{found:?}, expected {expected}");
        assert!(found.normal < 1.0e-6 && found.joint == 0.0, "{found:?}");
    }
}

#[test]
fn asking_changes_no_bit_of_the_motion() {
    for (contact_model, friction_model) in MODELS {
        let asks = Settings { contact_model, friction_model, refine: 2, ..asking() };
        let [mut one, mut other] =
            [asks, Settings { residual: false, ..asks }].map(|settings| all(&settings));
        for _ in 0..40 {
            one.step(&mut Serial);
            other.step(&mut Serial);
        }
        assert!(motion(&one) == motion(&other), "{contact_model:?}, {friction_model:?}");
    }
}

#[test]
fn every_executor_measures_the_same() {
    let joints = [true, false].into_iter().cycle();
    for ((contact_model, friction_model), direct_joints) in MODELS.into_iter().zip(joints) {
        let dial = Settings { contact_model, friction_model, direct_joints, ..asking() };
        let settings = Settings { tolerance: 2.0e-2, sweeps_max: 6, refine: 4, ..dial };
        let mut worlds = [0; 3].map(|_| all(&settings));
        let mut pool = Pool::new(3).expect("threads");
        let reports = [
            step(&mut worlds[0], &mut Serial, 30),
            step(&mut worlds[1], &mut Shuffled::new(5), 30),
            step(&mut worlds[2], &mut pool, 30),
        ];
        let measured: Vec<Vec<_>> = reports
            .iter()
            .map(|r| r.iter().map(|r| (r.residuals, r.sweeps, r.unsettled)).collect())
            .collect();
        assert!(
            measured[0] == measured[1] && measured[0] == measured[2],
            "{contact_model:?}, {friction_model:?}"
        );
        let sums = worlds.map(|world| world.checksum());
        assert!(sums[0] == sums[1] && sums[0] == sums[2], "{contact_model:?}, {friction_model:?}");
        let of = |of: fn(&Residuals) -> f32| reports[0].iter().any(|report| of(&residuals(report)) > 1.0e-4);
        assert!(
            of(|r| r.biased.normal) && of(|r| r.last.normal),
            "{contact_model:?}, {friction_model:?}: normals"
        );
        assert!(
            of(|r| r.biased.friction) && of(|r| r.last.friction),
            "{contact_model:?}, {friction_model:?}: friction"
        );
        assert!(
            of(|r| r.biased.joint) && of(|r| r.last.joint),
            "{contact_model:?}, {friction_model:?}: joints"
        );
    }
}

#[test]
fn sweeps_bring_it_down() {
    for (contact_model, friction_model) in MODELS {
        let left = [1, 8, 64, 512].map(|sweeps| {
            let settings = Settings {
                contact_model,
                friction_model,
                sweeps,
                relax_sweeps: sweeps,
                substeps: 1,
                ..asking()
            };
            let mut world = all(&settings);
            let report = world.step(&mut Serial);
            assert_eq!(report.sweeps, sweeps);
            residuals(&report)
        });
        println!("{contact_model:?}, {friction_model:?}: {left:?}");
        // What relax sweeps start with depends on what the biased ones found: only the end is compared.
        let [biased, last] =
            [|r: &Residuals| r.biased, |r: &Residuals| r.last].map(|of| left.map(|r| of(&r).greatest()));
        assert!(
            biased.windows(2).all(|pair| pair[1] < pair[0]),
            "{contact_model:?}, {friction_model:?}: {biased:?}"
        );
        assert!(
            biased[3] < 0.02 * biased[0] && last[3] < 0.02 * last[0],
            "{contact_model:?}, {friction_model:?}: {left:?}"
        );
    }
}

#[test]
fn sweeps_end_at_the_tolerance() {
    for (contact_model, friction_model) in MODELS {
        let settings = Settings {
            contact_model,
            friction_model,
            substeps: 2,
            tolerance: 2.0e-3,
            sweeps_max: 1024,
            ..asking()
        };
        let mut world = all(&settings);
        for report in step(&mut world, &mut Serial, 4) {
            println!(
                "{contact_model:?}, {friction_model:?}: {} sweeps, {:?}",
                report.sweeps,
                residuals(&report).biased
            );
            assert!(report.sweeps > 2 && report.unsettled == 0, "{report:?}");
            assert!(residuals(&report).biased.greatest() <= settings.tolerance, "{report:?}");
        }
        // Looser than what there is: as many as the settings say.
        let loose = Settings { tolerance: 1.0e3, sweeps: 3, ..settings };
        world.set_settings(&loose).expect("in range");
        let report = world.step(&mut Serial);
        assert_eq!((report.sweeps, report.unsettled), (6, 0));
        // Tighter than rounding: up to the most, or the least if that is more.
        for (sweeps, sweeps_max, done) in [(1, 5, 10), (7, 5, 14)] {
            let tight = Settings { tolerance: 1.0e-12, sweeps, sweeps_max, ..settings };
            world.set_settings(&tight).expect("in range");
            let report = world.step(&mut Serial);
            assert_eq!((report.sweeps, report.unsettled), (done, 2));
        }
    }
}

#[test]
fn scenes_of_joints_come_to_rest_in_their_rows() {
    // Wheels with springs, motors, cones, drives with springs, ropes, in all passes.
    for name in ["cars", "ragdolls", "bridge"] {
        let builtin = Builtin::find(name).expect("it is built in");
        let scene = builtin.scene(builtin.golden_size).expect("in range");
        let mut world = scene.build(Path::new(".")).expect("it builds").world;
        step(&mut world, &mut Serial, 60);
        let mut start = vec![0; world.snapshot_bytes()];
        world.save(&mut start).expect("room");
        let left = [1, 1024].map(|sweeps| {
            world.restore(&start).expect("its own");
            let settings =
                Settings { residual: true, sweeps, relax_sweeps: sweeps, refine: 1, ..world.settings() };
            world.set_settings(&settings).expect("in range");
            residuals(&world.step(&mut Serial))
        });
        println!("{name}: {left:?}");
        let most = [left[1].biased, left[1].last].map(|residual| residual.greatest());
        assert!(most.iter().all(|&most| most < 1.0e-4), "{name}: {left:?}");
        assert!(left[0].biased.joint > 1.0e-4, "{name}: {left:?}");
    }
}

#[test]
fn a_tolerance_out_of_range_is_refused() {
    let mut world = world(&asking());
    let before = world.settings();
    for tolerance in [-1.0, f32::NAN, f32::INFINITY, 2.0e6] {
        assert!(world.set_settings(&Settings { tolerance, ..before }).is_err(), "{tolerance}");
    }
    for sweeps_max in [0, 1025] {
        assert!(world.set_settings(&Settings { sweeps_max, ..before }).is_err(), "{sweeps_max}");
    }
    assert_eq!(world.settings(), before);
}
