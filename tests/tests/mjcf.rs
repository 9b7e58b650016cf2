//! Models in MJCF that others made: read whole, with the numbers that MuJoCo gives, and run as scenes.
//!
//! The files are found through the environment variable `CELLSTEP_DATA`, a folder with `mjcf/*.xml`; without it the
//! tests say that they skipped.

use std::path::PathBuf;

use cellstep::math::Vec3;
use cellstep::mjcf::{BodyKind, Control, Effect, Form, Model, Motion, Transmission};
use cellstep::scene::{Build, Limits, SceneError};
use cellstep::{Pool, Serial};

/// The folder of the models, or `None` with a note.
fn folder() -> Option<PathBuf> {
    match std::env::var_os("CELLSTEP_DATA") {
        Some(path) => Some(PathBuf::from(path).join("mjcf")),
        None => {
            println!("skipped: CELLSTEP_DATA is not set");
            None
        }
    }
}

fn read(file: &str) -> Option<Result<Model, SceneError>> {
    Some(Model::read(&folder()?.join(file), &Limits::default()))
}

/// A model that is sound.
fn model(file: &str) -> Option<Model> {
    Some(read(file)?.unwrap_or_else(|error| panic!("{error}")))
}

fn build(model: &Model) -> Build {
    let scene = model.to_scene().unwrap_or_else(|error| panic!("{error}")).scene;
    scene.build(&PathBuf::new()).unwrap_or_else(|error| panic!("{error}"))
}

fn geoms(model: &Model) -> usize {
    model.bodies.iter().map(|body| body.geoms.len()).sum()
}

fn joint_parts(model: &Model) -> usize {
    model.joints.iter().map(|joint| joint.parts.len()).sum()
}

fn kinds(model: &Model) -> [usize; 3] {
    [BodyKind::Fixed, BodyKind::Free, BodyKind::Jointed]
        .map(|kind| model.bodies.iter().filter(|body| body.kind == kind).count())
}

fn mass(model: &Model) -> f64 {
    model.bodies.iter().filter_map(|body| body.mass).map(|mass| mass.mass).sum()
}

#[track_caller]
fn near(found: f64, expected: f64) {
    assert!((found - expected).abs() <= 1.0e-9 * expected.abs(), "{found} {expected}");
}

/// The file has 17 bodies; the head and both hands have no joints and belong to torso and lower arms. Masses are
/// those that MuJoCo 3 prints.
fn check_humanoid(model: &Model, first: usize) {
    let names = [
        "torso",
        "waist_lower",
        "pelvis",
        "thigh_right",
        "shin_right",
        "foot_right",
        "thigh_left",
        "shin_left",
        "foot_left",
        "upper_arm_right",
        "lower_arm_right",
        "upper_arm_left",
        "lower_arm_left",
    ];
    let masses = [
        5.853834311188983 + 3.053628059289279,
        2.261946710584651,
        6.616194128460103,
        4.751750928806242,
        2.7556961671836424,
        1.1311412323899843,
    ];
    for (index, name) in names.iter().enumerate() {
        let body = &model.bodies[first + index];
        assert!(body.name.contains(name), "{} {name}", body.name);
        assert_eq!(body.kind, if index == 0 { BodyKind::Free } else { BodyKind::Jointed });
        if let Some(&expected) = masses.get(index) {
            near(body.mass.expect("a body that moves has mass").mass, expected);
        }
    }
}

#[test]
fn humanoid_is_read_whole() {
    let Some(model) = model("humanoid.xml") else { return };
    assert_eq!((kinds(&model), geoms(&model), joint_parts(&model)), ([1, 1, 12], 20, 21));
    assert_eq!(model.bodies.iter().map(|body| body.parts).sum::<usize>(), 17);
    assert_eq!((model.excludes.len(), model.actuators.len()), (2, 21));
    assert_eq!((model.equalities.len(), model.ropes.len()), (0, 0));
    near(mass(&model), 40.84402122162133);
    check_humanoid(&model, 1);
    assert_eq!(model.options.timestep, 0.005);
    // Three hinges of the right hip, which turn one after the other.
    let hip = &model.joints[2];
    let names: Vec<&str> = hip.parts.iter().map(|part| part.name.as_str()).collect();
    assert_eq!(names, ["hip_x_right", "hip_z_right", "hip_y_right"]);
    let [low, high] = hip.parts[2].range.expect("the class has a range");
    near(low, -150.0f64.to_radians());
    near(high, 20.0f64.to_radians());
    let part = &hip.parts[2];
    assert_eq!((part.motion, part.stiffness, part.damping, part.armature), (Motion::Hinge, 10.0, 5.0, 0.01));
    assert!(!hip.collide);
    near(model.actuators[5].gear, 120.0);
    assert_eq!(model.actuators[5].control, Control::Motor);
    assert_eq!(model.actuators[5].control_range, Some([-1.0, 1.0]));
    assert_eq!(model.actuators[5].transmission, Transmission::Joint(2, 2));
    let lost: Vec<&str> = (model.warnings.iter())
        .filter(|warning| matches!(warning.effect, Effect::Motion | Effect::Unknown))
        .map(|warning| warning.what.as_str())
        .collect();
    assert_eq!(lost, ["tendon/fixed"]);
}

#[test]
fn a_hundred_humanoids_are_read_whole() {
    let Some(model) = model("100_humanoids.xml") else { return };
    assert_eq!((kinds(&model), geoms(&model), joint_parts(&model)), ([1, 100, 1200], 1901, 2100));
    assert_eq!((model.excludes.len(), model.actuators.len()), (200, 2100));
    near(mass(&model), 4084.4021221621333);
    for index in 0..100 {
        check_humanoid(&model, 1 + 13 * index);
    }
    // Where MuJoCo puts the first and the second, and what it calls them.
    assert_eq!(model.bodies[1].name, "_torso-00-00");
    assert_eq!(model.bodies[1].placement.position, [1.2, 0.0, 1.282]);
    assert_eq!(model.bodies[14].name, "_torso-01-00");
    near(model.bodies[14].placement.position[0], 1.8);
    // An exclude joins bodies of one humanoid.
    assert!(
        model.excludes.iter().all(|exclude| (exclude.bodies[0] - 1) / 13 == (exclude.bodies[1] - 1) / 13)
    );
}

#[test]
fn newton_cradle_is_read_whole() {
    let Some(model) = model("newton_cradle.xml") else { return };
    assert_eq!((kinds(&model), geoms(&model), model.ropes.len()), ([1, 7, 0], 8, 14));
    for (rope, body) in model.ropes.iter().zip([1, 2, 3, 4, 5, 1, 2, 3, 4, 5, 6, 7, 6, 7]) {
        assert_eq!((rope.a.body, rope.b.body, rope.range), (0, body, Some([0.0, 0.146])));
    }
    // A ball of 2 cm and 8,000 kg/m3.
    let expected = 4.0 / 3.0 * std::f64::consts::PI * 0.02f64.powi(3) * 8000.0;
    for body in &model.bodies[1..] {
        near(body.mass.expect("it moves").mass, expected);
        near(body.mass.expect("it moves").inertia[0], 0.4 * expected * 0.02 * 0.02);
        assert_eq!(body.geoms[0].restitution, 1.0);
    }
    assert_eq!(model.bodies[7].name, "perturbed1");
}

#[test]
fn slider_crank_is_read_whole() {
    let Some(model) = model("slider_crank.xml") else { return };
    assert_eq!((kinds(&model), geoms(&model), joint_parts(&model)), ([1, 0, 3], 7, 3));
    near(mass(&model), 0.18661060362323373);
    let parents: Vec<usize> = model.bodies.iter().map(|body| body.parent).collect();
    assert_eq!(parents, [0, 0, 1, 0]);
    assert!(model.joints.iter().all(|joint| joint.parts[0].axis == [0.0, 0.0, 1.0]));
    assert_eq!(model.joints.iter().map(|joint| joint.collide).collect::<Vec<_>>(), [true, false, true]);
    assert!(model.bodies[1..].iter().all(|body| matches!(body.geoms[0].form, Form::Cylinder { .. })));
    assert_eq!(model.actuators.len(), 3);
    for (actuator, rod) in model.actuators.iter().zip([0.08, 0.06, 0.05]) {
        assert_eq!(actuator.control, Control::Position { kp: 30.0, kv: 0.0 });
        assert_eq!(actuator.control_range, Some([-0.1, 0.1]));
        let Transmission::SliderCrank { rod: found, .. } = actuator.transmission else {
            panic!("{actuator:?}")
        };
        assert_eq!(found, rod);
    }
}

#[test]
fn hammock_names_the_file_that_is_missing() {
    let Some(result) = read("hammock.xml") else { return };
    let message = result.expect_err("the file that it includes is not there").to_string();
    assert!(
        message.contains("hammock.xml: line 44, column 28: mujoco/asset/model[humanoid]/file:"),
        "{message}"
    );
    assert!(message.contains("\"../humanoid/humanoid.xml\" does not exist"), "{message}");
}

/// How far each body's z axis is up.
fn up(build: &Build) -> Vec<f32> {
    let bodies = build.bodies.iter().skip(1);
    bodies.map(|&body| build.world.rotation(body).expect("alive").rotate(Vec3::Z).z).collect()
}

#[test]
fn every_domino_falls() {
    let Some(model) = model("dominos.xml") else { return };
    // One that leans, 3 rows and 2 rows of 15, four turns of 5; each weighs 90 g.
    assert_eq!((kinds(&model), geoms(&model)), ([1, 96, 0], 97));
    near(mass(&model), 96.0 * 0.09);
    let mut built = build(&model);
    assert!(up(&built).iter().all(|&up| up > 0.99), "they stand");
    for _ in 0..5000 {
        let report = built.world.step(&mut Serial);
        assert_eq!((report.dropped, report.quarantined), (0, 0));
    }
    let up = up(&built);
    let standing: Vec<usize> = (0..up.len()).filter(|&index| up[index] > 0.7).collect();
    println!("dominos: {} of {} fell, standing {standing:?}", up.len() - standing.len(), up.len());
    assert!(standing.is_empty(), "{standing:?} stand after 10 s");
}

#[test]
fn stacked_boxes_rest_in_their_corner() {
    let Some(model) = model("stacked_boxes.xml") else { return };
    assert_eq!((kinds(&model), geoms(&model), model.meshes.len()), ([1, 18, 0], 21, 1));
    for body in &model.bodies[1..] {
        let mass = body.mass.expect("it moves");
        assert!(
            (mass.mass - 1.0).abs() < 1.0e-6 && (mass.inertia[2] * 600.0 - 1.0).abs() < 1.0e-6,
            "{mass:?}"
        );
    }
    let mut one = build(&model);
    let mut two = build(&model);
    let mut pool = Pool::new(2).expect("two workers");
    for _ in 0..5000 {
        let report = one.world.step(&mut Serial);
        assert_eq!((report.dropped, report.quarantined), (0, 0));
        two.world.step(&mut pool);
    }
    assert_eq!(one.world.checksum(), two.world.checksum(), "workers change no bit");
    let world = &one.world;
    for (index, &body) in one.bodies.iter().enumerate().skip(1) {
        let [x, y, z] = world.position(body).expect("alive").to_f64();
        let speed = world.linear_velocity(body).expect("alive").length();
        println!("box {index}: {x:.4} {y:.4} {z:.4}, {speed:.1e} m/s");
        // Against the walls at x = -0.7 and y = 0.7, three by three, in two layers.
        let place = (index - 1) % 9;
        let expected = [
            -0.65 + 0.1 * (2 - place % 3) as f64,
            0.65 - 0.1 * (2 - place / 3) as f64,
            if index <= 9 { 0.05 } else { 0.15 },
        ];
        for (found, expected) in [x, y, z].into_iter().zip(expected) {
            assert!((found - expected).abs() < 0.005, "box {index} at {x} {y} {z}, expected {expected}");
        }
        assert!(speed < 1.0e-3, "box {index} moves at {speed}");
    }
}

fn coordinate(built: &Build, joint: usize, axis: usize) -> f64 {
    f64::from(built.world.joint_coordinates(built.joints[joint]).expect("it exists")[axis])
}

#[test]
fn slider_crank_turns_to_where_its_actuators_want_it() {
    let Some(model) = model("slider_crank.xml") else { return };
    let mut built = build(&model);
    assert_eq!((built.bodies.len(), built.joints.len()), (4, 6));
    for step in 1..=7500 {
        let report = built.world.step(&mut Serial);
        assert_eq!((report.dropped, report.quarantined), (0, 0));
        if step == 250 {
            // After half a second MuJoCo's cranks have turned by -0.53, 0.29 and -0.75 rad.
            let turned = [0, 1, 2].map(|joint| coordinate(&built, joint, 3));
            println!("slider_crank after 0.5 s: {turned:?}");
            assert!(turned[0] < -0.4 && turned[1] > 0.2 && turned[2] < -0.6, "{turned:?}");
        }
    }
    // MuJoCo's coordinates after 60 s, and the lengths of the rods.
    let rest = [-0.747758, 0.949, -1.065436];
    for (joint, (angle, rod)) in rest.into_iter().zip([0.08, 0.06, 0.05]).enumerate() {
        let (turn, length) = (coordinate(&built, joint, 3), coordinate(&built, joint + 3, 0));
        println!("crank {joint}: {turn:.5} rad, {length:.6} m");
        assert!((turn - angle).abs() < 0.005, "crank {joint} at {turn}");
        assert!((length - rod).abs() < 2.0e-4, "rod {joint} of {length} m");
    }
    assert!(
        (1..4).all(|body| !built.world.is_asleep(built.bodies[body]).expect("it exists")),
        "servos stay awake"
    );
}

/// Energy of the cradle above its lowest, J, and how far the last ball and the first are out, metres.
fn swing(built: &Build) -> (f64, f64, f64) {
    let mass = 4.0 / 3.0 * std::f64::consts::PI * 0.02f64.powi(3) * 8000.0;
    let mut energy = 0.0;
    for &ball in &built.bodies[1..] {
        let height = built.world.position(ball).expect("it exists").to_f64()[2] - 0.04;
        let v = built.world.linear_velocity(ball).expect("it exists").as_dvec3();
        energy += mass * (9.81 * height + 0.5 * v.length_squared());
    }
    let x = |index: usize| built.world.position(built.bodies[index]).expect("it exists").to_f64()[0];
    (energy, -0.16 - x(5), x(7) - 0.08)
}

/// The two balls that are let go pass their blow through the row; the far end goes out, comes back, and so on.
#[test]
fn newton_cradle_swings() {
    let Some(model) = model("newton_cradle.xml") else { return };
    let mut built = build(&model);
    assert_eq!((built.joints.len(), built.world.settings().dt), (14, 1.0e-4));
    let (start, ..) = swing(&built);
    // Greatest ways out in each half of a period of 0.83 s after the first blow.
    let mut out = [[0.0_f64; 2]; 4];
    for step in 0..18_000 {
        let report = built.world.step(&mut Serial);
        assert_eq!((report.dropped, report.quarantined), (0, 0));
        let (energy, last, first) = swing(&built);
        assert!(energy <= start * 1.001, "{energy} J after {step} steps, {start} at first");
        let half = (f64::from(step) * 1.0e-4 - 0.21) / 0.415;
        // A blow goes through the row in some steps, and what is on its way is not in the velocities.
        let swings = (0.1..0.9).contains(&(half - half.floor()));
        assert!(!swings || energy > 0.8 * start, "{energy} J after {step} steps, {start} at first");
        if let Some(out) = out.get_mut(half as usize).filter(|_| half > 0.0) {
            *out = [out[0].max(last), out[1].max(first)];
        }
    }
    println!("newton_cradle: {} of {start} J, ways out (last, first) {out:?}", swing(&built).0);
    for (half, [last, first]) in out.into_iter().enumerate() {
        let (outer, inner) = if half % 2 == 0 { (last, first) } else { (first, last) };
        assert!(outer > 0.05 && outer > 1.3 * inner, "half {half}: {outer} m and {inner} m");
    }
}

/// Falls of 1.3 m, heaps where ten meet, and rest.
#[test]
fn a_hundred_humanoids_fall_asleep() {
    let Some(model) = model("100_humanoids.xml") else { return };
    let mut built = build(&model);
    // 1200 compound joints, and 200 excludes.
    assert_eq!((built.bodies.len(), built.joints.len()), (1301, 1400));
    let mut pool = Pool::new(2).expect("two workers");
    let mut slept = None;
    for step in 1..=4000 {
        let report = built.world.step(&mut pool);
        assert_eq!((report.dropped, report.quarantined), (0, 0));
        let asleep = |&body| built.world.is_asleep(body).expect("it exists");
        if step % 20 == 0 && built.bodies[1..].iter().all(asleep) {
            slept = Some(f64::from(step) * 0.005);
            break;
        }
    }
    println!("100_humanoids: all asleep after {slept:?} s");
    assert!(slept.is_some(), "some are awake after 20 s");
    // Nobody was torn, and nobody fell through the floor.
    for (joint, &handle) in model.joints.iter().zip(&built.joints) {
        let gap = built.world.joint_coordinates(handle).expect("it exists");
        let gap = gap[..3].iter().map(|x| x * x).sum::<f32>().sqrt();
        assert!(gap < 0.01, "a gap of {gap} m at {}", model.bodies[joint.child].name);
    }
    for &body in &built.bodies[1..] {
        assert!(built.world.center(body).expect("it exists").to_f64()[2] > 0.0);
    }
}
