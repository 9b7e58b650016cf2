//! Where joints are: bodies are put where MuJoCo 4 puts them for given coordinates, and every joint has to show
//! these.

use cellstep::math::Rotation;
use cellstep::mjcf::Model;
use cellstep::scene::{Build, Limits};
use cellstep::{JointHandle, Position};
use std::f64::consts::FRAC_PI_4;
use std::path::{Path, PathBuf};

/// Position and rotation (real part last) of a body.
type Pose = ([f64; 3], [f64; 4]);

/// Puts bodies, from the second of the scene on.
fn put(built: &mut Build, poses: &[Pose]) {
    for (index, (position, rotation)) in poses.iter().enumerate() {
        let [x, y, z, w] = rotation.map(|x| x as f32);
        let place = Position::from_f64(*position);
        built.world.set_pose(built.bodies[index + 1], place, Rotation::new(x, y, z, w)).expect("it exists");
    }
}

fn coordinates(built: &Build, joint: JointHandle) -> [f64; 6] {
    built.world.joint_coordinates(joint).expect("it exists").map(f64::from)
}

#[track_caller]
fn near(found: f64, expected: f64, tolerance: f64) {
    assert!((found - expected).abs() <= tolerance, "{found}, expected {expected}");
}

/// Slides before and after hinges, hinges at right angles and not, three slides, a screw and a ball.
#[test]
fn compounds_have_the_coordinates_of_mujoco() {
    let model = Model::from_xml(include_bytes!("frames.xml"), &Limits::default()).expect("it is sound");
    let conversion = model.to_scene().expect("it is a scene");
    assert_eq!(conversion.warnings, []);
    let scene = conversion.scene;
    assert_eq!((scene.bodies.len(), scene.joints.len()), (9, 8));
    let mut built = scene.build(Path::new("")).expect("it is sound");
    for &joint in &built.joints {
        let start = coordinates(&built, joint);
        assert!((0..6).all(|axis| axis == 4 || start[axis].abs() < 1.0e-6), "{start:?}");
    }
    #[rustfmt::skip]
    put(&mut built, &[
        ([1.208534417, 2.105080249, 2.747243951], [0.024118034, 0.331238786, 0.164520751, 0.928779904]),
        ([1.875921094, 2.360746175, 3.563892063], [0.289144742, 0.116025856, 0.613311123, 0.725798033]),
        ([1.996237478, 2.891065522, 3.659670392], [0.313814452, 0.086022664, 0.532186415, 0.781599777]),
        ([-1.054754454, 0.032016126, 2.023306284], [0.312195055, 0.174398047, 0.110145442, 0.927355137]),
        ([-0.231836528, 0.282447518, 1.668120134], [-0.026128433, 0.405352376, 0.465309933, 0.786443528]),
        ([-0.922456096, 0.767828267, 2.096323274], [0.334244840, 0.495034067, 0.519737791, 0.610814446]),
        ([0.299379759, -2.730052302, 0.900000000], [0.000000000, 0.000000000, 0.479425539, 0.877582562]),
        ([0.448132219, -2.825565158, 1.223223305], [-0.083871191, 0.153525186, 0.618046546, 0.766429454]),
    ]);
    // MuJoCo's coordinates: 0.4, -0.3, 0.5 of the planar body; 0.7, 0.2 of the arm; 0.6, -0.8; 0.3, 0.5, -0.4; 0.9,
    // -0.6, 0.15; a turn of 0.7 about (0.6, 0, 0.8); 0.2, -0.1, 0.35; 0.8 (0.3 in the beginning), 0.25.
    let twist = 2.0 * (0.6 * 0.35f64.sin()).atan2(0.35f64.cos());
    let expected = [
        [0.0, 0.4, 0.3, 0.5, 0.0, 0.0],
        [0.0, -0.2, 0.0, -0.7, 0.0, 0.0],
        [0.0, 0.0, 0.0, -0.8, -FRAC_PI_4, 0.6],
        [0.0, 0.0, 0.0, -0.4, -0.5 - 0.5f64.atan(), 0.3],
        [0.0, 0.15, 0.0, -0.9, 0.0, 0.6],
        [0.0, 0.0, 0.0, twist, 0.0, 0.0],
        [0.2, -0.1, 0.35, 0.0, 0.0, 0.0],
        [-0.25, 0.0, 0.0, 0.5, 0.0, 0.0],
    ];
    for (&joint, expected) in built.joints.iter().zip(expected) {
        let found = coordinates(&built, joint);
        println!("{found:?}");
        (0..6).for_each(|axis| near(found[axis], expected[axis], 3.0e-6));
    }
}

/// All 21 hinges of the humanoid at once.
#[test]
fn a_humanoid_has_the_coordinates_of_mujoco() {
    let Some(folder) = std::env::var_os("CELLSTEP_DATA") else {
        println!("skipped: CELLSTEP_DATA is not set");
        return;
    };
    let file = PathBuf::from(folder).join("mjcf/humanoid.xml");
    let model = Model::read(&file, &Limits::default()).unwrap_or_else(|error| panic!("{error}"));
    let mut built = model.to_scene().expect("a scene").scene.build(Path::new("")).expect("sound");
    #[rustfmt::skip]
    put(&mut built, &[
        ([0.000000000, 0.000000000, 1.282000000], [0.500000000, -0.100000000, 0.700000000, 0.500000000]),
        ([-0.154108591, 0.158016559, 1.144205885], [0.436467705, -0.176294275, 0.802279001, 0.367103085]),
        ([-0.249047388, 0.256894968, 1.052368882], [0.438297757, -0.172280693, 0.803150440, 0.364916167]),
        ([-0.198460906, 0.348190819, 1.025796802], [0.596283360, -0.303623181, 0.388338543, 0.633602631]),
        ([-0.244394618, 0.738734587, 0.979109023], [0.435462413, -0.078435852, 0.562790509, 0.698202798]),
        ([-0.353251524, 1.027137425, 0.766729462], [0.422526700, -0.305948174, 0.211274771, 0.826577204]),
        ([-0.345898034, 0.213328597, 1.034426651], [0.680415972, -0.339954791, 0.589079006, 0.272856685]),
        ([-0.582898026, 0.526821913, 1.084958015], [0.456698588, -0.235032868, 0.775503945, 0.367123387]),
        ([-0.750041917, 0.779021511, 0.869486859], [0.081823026, -0.294946970, 0.769421561, 0.560626203]),
        ([0.172000000, 0.043200000, 1.249600000], [0.417103685, 0.132775649, 0.816637465, 0.376162722]),
        ([0.055616857, 0.313888070, 1.147703324], [0.355076809, 0.182653311, 0.815934266, 0.418102261]),
        ([-0.100000000, -0.120000000, 1.372000000], [0.139676861, -0.058248720, 0.920131590, 0.361185988]),
        ([-0.387277179, -0.097645194, 1.252953433], [0.115382584, -0.052732094, 0.931961260, 0.339638626]),
    ]);
    let mut values = [
        0.38, 0.09, 0.01, -0.29, -0.81, -0.57, -0.67, -0.63, -0.63, 0.1, -0.02, -0.75, -0.65, 0.66, 0.56,
        0.54, -0.27, -0.18, 0.24, -0.87, -0.07,
    ]
    .into_iter();
    for (joint, &handle) in model.joints.iter().zip(&built.joints) {
        // The first hinge is turn z, the last turn x.
        let axes: &[usize] = [&[3][..], &[5, 3], &[5, 4, 3]][joint.parts.len() - 1];
        let mut expected = [0.0; 6];
        axes.iter().for_each(|&axis| expected[axis] = values.next().expect("21 hinges"));
        let found = coordinates(&built, handle);
        (3..6).for_each(|axis| near(found[axis], expected[axis], 5.0e-6));
        // The two axes of an ankle pass each other: here they meet in between.
        let feet = model.bodies[joint.child].name.starts_with("foot");
        (0..3).for_each(|axis| near(found[axis], 0.0, if feet { 0.025 } else { 5.0e-6 }));
    }
    assert_eq!(values.next(), None);
}
