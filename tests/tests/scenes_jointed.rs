//! The built-in scenes of joints do what they show.

use cellstep::scene::Build;
use cellstep::scene::builtin::Builtin;
use cellstep::{Pool, Serial};
use std::path::Path;

fn built(name: &str, size: u32) -> Build {
    let scene =
        Builtin::find(name).expect("there is such a scene").scene(size).expect("the size is in range");
    let built = scene.build(Path::new("")).unwrap_or_else(|error| panic!("{name}: {error}"));
    assert_eq!(built.joints.len(), scene.joints.len());
    built
}

fn steps(built: &mut Build, count: u32) {
    for step in 0..count {
        let report = built.world.step(&mut Serial);
        assert_eq!((report.dropped, report.quarantined), (0, 0), "step {step}");
    }
}

/// Distance of the points of a joint, metres.
fn gap(built: &Build, joint: usize) -> f32 {
    let c = built.world.joint_coordinates(built.joints[joint]).expect("it exists");
    (c[0] * c[0] + c[1] * c[1] + c[2] * c[2]).sqrt()
}

fn position(built: &Build, body: usize) -> [f64; 3] {
    built.world.position(built.bodies[body]).expect("it exists").to_f64()
}

#[test]
fn the_bridge_hangs_on_its_ropes() {
    const PLANKS: usize = 12;
    let mut built = built("bridge", PLANKS as u32);
    steps(&mut built, 900);
    // Hinges hold, ropes are tight, and the middle hangs lowest.
    for joint in 0..PLANKS - 1 {
        assert!(gap(&built, joint) < 2.0e-3, "hinge {joint}: {} m", gap(&built, joint));
    }
    for rope in PLANKS - 1..PLANKS + 3 {
        // A rope of 1.5 m holds; while the bridge sways it may be a little slack.
        assert!((1.45..1.505).contains(&gap(&built, rope)), "rope {rope}: {} m", gap(&built, rope));
    }
    let height = |plank: usize| position(&built, plank)[2];
    println!("bridge: {:?}", (1..=PLANKS).map(height).collect::<Vec<_>>());
    assert!(height(1) < 4.0 && (2..=PLANKS / 2).all(|plank| height(plank) < height(plank - 1)));
    // Boxes lie on it, or have slid off to the ground: nothing went through either.
    for index in PLANKS + 1..built.bodies.len() {
        let [.., z] = position(&built, index);
        assert!(z > 0.2, "box {index} at {z} m");
    }
}

#[test]
fn ragdolls_fall_and_sleep() {
    let mut built = built("ragdolls", 9);
    steps(&mut built, 1200);
    for joint in 0..built.joints.len() {
        assert!(gap(&built, joint) < 5.0e-3, "joint {joint}: {} m", gap(&built, joint));
    }
    let mut awake = 0;
    for body in 1..built.bodies.len() {
        let [.., z] = position(&built, body);
        assert!((0.0..1.0).contains(&z), "body {body} at {z} m");
        let is_awake = !built.world.is_asleep(built.bodies[body]).expect("it exists");
        if is_awake {
            let speed = built.world.linear_velocity(built.bodies[body]).expect("it exists").length();
            println!("ragdoll {}, part {}: awake at {speed} m/s", (body - 1) / 11, (body - 1) % 11);
        }
        awake += usize::from(is_awake);
    }
    assert_eq!(awake, 0, "bodies are awake after 20 s");
}

#[test]
fn cars_drive_over_the_step() {
    let mut built = built("cars", 5);
    steps(&mut built, 360);
    for car in 0..5 {
        let body = built.bodies[2 + 5 * car];
        let ([x, y, z], up) = (
            position(&built, 2 + 5 * car),
            built.world.rotation(body).expect("it exists").rotate(cellstep::math::Vec3::Z),
        );
        let v = built.world.linear_velocity(body).expect("it exists").length();
        println!("car {car}: {x:.2} {y:.2} {z:.2}, {v:.2} m/s");
        assert!(up.z > 0.95, "car {car} tips: {up:?}");
        // Wheels of 0.4 m at 12 rad/s.
        assert!((3.0..5.3).contains(&v), "car {car} at {v} m/s");
    }
}

#[test]
fn workers_change_no_bit() {
    for (name, size) in [("bridge", 20), ("ragdolls", 30), ("cars", 30)] {
        let (mut one, mut three) = (built(name, size), built(name, size));
        let mut pool = Pool::new(3).expect("three workers");
        for _ in 0..120 {
            one.world.step(&mut Serial);
            three.world.step(&mut pool);
        }
        assert_eq!(one.world.checksum(), three.world.checksum(), "{name}");
    }
}
