//! Joints of scene documents.

use super::{full, read, refusal};
use cellstep::scene::format::*;
use std::path::Path;

/// Joints of all kinds, one with every field.
pub fn full_joints(rotation: RotationDoc) -> Vec<JointDoc> {
    let spring = SpringDoc::Stiffness { stiffness: 0.1, damping: 0.2 };
    let soft = SpringDoc::Frequency { hertz: 0.3, damping_ratio: 0.4 };
    let drive = DriveDoc { target: 0.5, velocity: -0.6, spring: Some(soft), max_force: Some(0.7) };
    let axis = |motion| AxisDoc { motion, limit_spring: Some(spring), drive: Some(drive), friction: 0.8 };
    let bodies = [BodyRefDoc::Index(1), BodyRefDoc::Name("plate".to_string())];
    let kinds = [
        JointKindDoc::Ball,
        JointKindDoc::Hinge,
        JointKindDoc::Slider,
        JointKindDoc::Fixed,
        JointKindDoc::Distance,
        JointKindDoc::Wheel,
        JointKindDoc::Gear { ratio: 0.1 },
        JointKindDoc::Rack { ratio: -0.2 },
    ];
    let mut joints: Vec<JointDoc> = kinds.map(|kind| JointDoc::new(kind, bodies.clone())).into();
    joints.push(JointDoc {
        frames: [FrameDoc::default(), FrameDoc { position: [0.1, -0.0, 0.2], rotation }],
        axes: AxesDoc {
            x: Some(axis(MotionDoc::Free)),
            y: Some(axis(MotionDoc::Locked)),
            z: Some(axis(MotionDoc::Limited { lower: Some(-0.1), upper: Some(0.2) })),
            turn_x: Some(axis(MotionDoc::Limited { lower: Some(-0.1), upper: None })),
            turn_y: Some(axis(MotionDoc::Limited { lower: None, upper: Some(-0.0) })),
            turn_z: Some(AxisDoc::default()),
        },
        cone: Some(0.3),
        spring: Some(soft),
        break_force: Some(0.1),
        break_torque: Some(0.2),
        bodies_collide: Some(false),
        user: 3,
        ..JointDoc::new(JointKindDoc::SixAxis, bodies)
    });
    joints
}

/// Mistakes in the joints of a document with three bodies, the last of which is named.
const JOINT_MISTAKES: &[(&str, &str, &str)] = &[
    ("{}", "joints[0]: missing field `kind`", ""),
    ("[]", "joints[0]", "sequence, expected a joint object"),
    ("{\"kind\": \"weld\"}", "joints[0].kind", "`ball`, `hinge`, `slider`"),
    ("{\"kind\": {\"gear\": {}}}", "joints[0].kind.gear", "missing field `ratio`"),
    ("{\"kind\": \"ball\"}", "joints[0]", "missing field `bodies`"),
    ("{\"kind\": \"ball\", \"bodies\": [0]}", "joints[0].bodies", "array of length 2"),
    (
        "{\"kind\": \"ball\", \"bodies\": [0, 3]}",
        "joints[0].bodies[1]: found 3",
        "below 3, the number of bodies",
    ),
    ("{\"kind\": \"ball\", \"bodies\": [0, -1]}", "joints[0].bodies[1]", "the index or the name of a body"),
    ("{\"kind\": \"ball\", \"bodies\": [0, 1.5]}", "joints[0].bodies[1]", "the index or the name of a body"),
    ("{\"kind\": \"ball\", \"bodies\": [0, null]}", "joints[0].bodies[1]", "the index or the name of a body"),
    ("{\"kind\": \"ball\", \"bodies\": [5000000000, 0]}", "joints[0].bodies[0]", "too large for the index"),
    (
        "{\"kind\": \"ball\", \"bodies\": [0, \"lam\"]}",
        "joints[0].bodies[1]: no body is named \"lam\"",
        "the name of",
    ),
    ("{\"kind\": \"ball\", \"bodies\": [2, \"lamp\"]}", "joints[0].bodies: found body 2 twice", "two bodies"),
    (
        "{JOINED, \"kind\": {\"gear\": {\"ratio\": 0}}}",
        "joints[0].kind.gear.ratio: found 0",
        "or its negative",
    ),
    (
        "{JOINED, \"kind\": {\"rack\": {\"ratio\": 1e5}}}",
        "joints[0].kind.rack.ratio: found 100000",
        "or its negative",
    ),
    ("{HINGE, \"frames\": [{}]}", "joints[0].frames", "array of length 2"),
    (
        "{HINGE, \"frames\": [{}, {\"position\": [0, 0, 1e6]}]}",
        "joints[0].frames[1].position[2]: found",
        "a number",
    ),
    (
        "{HINGE, \"frames\": [{\"rotation\": {\"quaternion\": [0,0,0,0]}}, {}]}",
        "joints[0].frames[0].rotation",
        "not zero",
    ),
    ("{HINGE, \"axes\": {\"turn\": {}}}", "joints[0].axes.turn", "`turn_x`, `turn_y`"),
    (
        "{HINGE, \"axes\": {\"turn_x\": {\"motion\": \"fast\"}}}",
        "joints[0].axes.turn_x.motion",
        "`free`, `locked`",
    ),
    (
        "{HINGE, \"axes\": {\"turn_x\": {\"motion\": {\"limited\": {\"lower\": 1, \"upper\": 0.5}}}}}",
        "joints[0].axes.turn_x.motion.limited.upper: found 0.5",
        "at least 1.0, the lower one",
    ),
    (
        "{HINGE, \"axes\": {\"y\": {\"motion\": {\"limited\": {\"lower\": -1e6}}}}}",
        "joints[0].axes.y.motion.limited.lower: found -1000000",
        "a number in -100000.0",
    ),
    (
        "{HINGE, \"axes\": {\"y\": {\"friction\": -1}}}",
        "joints[0].axes.y.friction: found -1",
        "a number in 0.0",
    ),
    (
        "{HINGE, \"axes\": {\"y\": {\"drive\": {\"max_force\": -1}}}}",
        "joints[0].axes.y.drive.max_force: found -1",
        "a number in 0.0",
    ),
    (
        "{HINGE, \"axes\": {\"y\": {\"drive\": {\"spring\": {\"frequency\": {\"hertz\": 1}}}}}}",
        "joints[0].axes.y.drive.spring.frequency",
        "missing field `damping_ratio`",
    ),
    (
        "{HINGE, \"axes\": {\"y\": {\"limit_spring\": {\"stiffness\": {\"stiffness\": -1, \"damping\": 0}}}}}",
        "joints[0].axes.y.limit_spring.stiffness.stiffness: found -1",
        "a number in 0.0",
    ),
    ("{HINGE, \"cone\": 0}", "joints[0].cone: found 0", "a number in 0.01..=3.1"),
    ("{JOINED, \"kind\": \"distance\", \"cone\": 1}", "joints[0].cone: found 1", "no cone on a distance"),
    (
        "{JOINED, \"kind\": \"distance\", \"axes\": {\"y\": {}}}",
        "joints[0].axes.y: found `y`",
        "a distance has `x`",
    ),
    ("{HINGE, \"break_force\": 0}", "joints[0].break_force: found 0", "a number in 1e-12"),
    (
        "{HINGE, \"spring\": {\"frequency\": {\"hertz\": 1e6, \"damping_ratio\": 1}}}",
        "spring.frequency.hertz",
        "a number",
    ),
];

#[test]
fn mistakes_of_joints_are_told_where_they_are() {
    let ball = "{\"shapes\": [{\"geometry\": {\"sphere\": {\"radius\": 1}}}]}";
    let named = ball.replacen('{', "{\"name\": \"lamp\", ", 1);
    let document = |joint: &str| {
        let joint = joint.replace("JOINED", "\"bodies\": [0, \"lamp\"]");
        let joint = joint.replace("HINGE", "\"kind\": \"hinge\", \"bodies\": [0, \"lamp\"]");
        format!("{{\"bodies\": [{ball}, {ball}, {named}],\n \"joints\": [{joint}]}}")
    };
    for (joint, path, expected) in JOINT_MISTAKES {
        let message = refusal(&document(joint));
        assert!(message.starts_with("line 2, column "), "{joint}\n{message}");
        assert!(message.contains(path), "{joint}\n{message}\nshould contain {path}");
        assert!(message.contains(expected), "{joint}\n{message}\nshould contain {expected}");
    }
    let twice = format!("{{\"bodies\": [{named},\n {named}]}}");
    let message = refusal(&twice);
    assert!(
        message.starts_with("line 2, column 11: bodies[1].name: the name \"lamp\" is used twice"),
        "{message}"
    );
    let empty = format!("{{\"bodies\": [{}]}}", named.replace("lamp", ""));
    assert!(
        refusal(&empty).starts_with("line 1, column 22: bodies[0].name: found none"),
        "{}",
        refusal(&empty)
    );
    let many = format!(
        "{{\"joints\": [{}]}}",
        vec!["{\"kind\": \"ball\", \"bodies\": [0, 1]}"; JOINTS_MAX + 1].join(",")
    );
    assert!(refusal(&many).contains("a list of at most 262144 entries"));
    // Room: a hinge with a limit and a drive takes two of the four bounds that come with each joint.
    let rich = "{HINGE, \"axes\": {\"x\": A, \"y\": A, \"z\": A, \"turn_x\": A}}"
        .replace('A', "{\"drive\": {}, \"friction\": 1, \"motion\": {\"limited\": {\"lower\": 0}}}");
    let scene = read(&document(&rich)).unwrap();
    assert_eq!(scene.build(Path::new("")).unwrap().world.joint_count(), 1);
    let few = document(&rich).replacen('{', "{\"capacities\": {\"joints\": 2}, ", 1);
    let message = refusal(&few);
    assert!(message.contains("capacities.joints: found 2") && message.contains("at least 3"), "{message}");
}

/// What a document says is what the engine has.
#[test]
fn joints_arrive_in_the_world() {
    use cellstep::joint::axis;
    use cellstep::{AxisMotion, Coupling, Spring};
    let mut scene = full();
    scene.meshes.remove("file");
    let built = scene.build(Path::new("")).unwrap();
    assert_eq!(built.joints.len(), scene.joints.len());
    let def = |index: usize| built.world.joint(built.joints[index]).unwrap();
    let locked = |index: usize| -> Vec<usize> {
        let axes = def(index).axes;
        (0..6).filter(|&axis| axes[axis].motion == AxisMotion::Locked).collect()
    };
    let expected: [&[usize]; 9] = [
        &[0, 1, 2],
        &[0, 1, 2, 4, 5],
        &[1, 2, 3, 4, 5],
        &[0, 1, 2, 3, 4, 5],
        &[],
        &[0, 1, 4, 5],
        &[],
        &[],
        &[1],
    ];
    for (index, expected) in expected.into_iter().enumerate() {
        assert_eq!(locked(index), expected, "joint {index}");
        assert_eq!(def(index).bodies, [built.bodies[1], built.bodies[0]]);
        assert_eq!(def(index).bodies_collide, [4, 6, 7].contains(&index), "joint {index}");
    }
    assert_eq!(def(4).coupling, Coupling::Distance);
    assert_eq!(def(6).coupling, Coupling::Gear { ratio: 0.1 });
    assert_eq!(def(7).coupling, Coupling::Rack { ratio: -0.2 });
    let six = def(8);
    assert_eq!(six.coupling, Coupling::Frames);
    assert_eq!((six.cone, six.break_force, six.break_torque, six.user), (Some(0.3), 0.1, 0.2, 3));
    assert_eq!(six.spring, Some(Spring::Frequency { hertz: 0.3, damping_ratio: 0.4 }));
    assert_eq!(six.frames[1].position.to_array(), [0.1, -0.0, 0.2]);
    assert_eq!(six.axes[axis::Z].motion, AxisMotion::Limited { lower: -0.1, upper: 0.2 });
    assert_eq!(six.axes[axis::TURN_X].motion, AxisMotion::Limited { lower: -0.1, upper: f32::INFINITY });
    assert_eq!(six.axes[axis::TURN_Y].motion, AxisMotion::Limited { lower: f32::NEG_INFINITY, upper: 0.0 });
    let drive = six.axes[axis::X].drive.unwrap();
    assert_eq!((drive.target, drive.velocity, drive.max_force), (0.5, -0.6, 0.7));
    assert_eq!(six.axes[axis::X].friction, 0.8);
    assert_eq!(six.axes[axis::X].limit_spring, Some(Spring::Stiffness { stiffness: 0.1, damping: 0.2 }));
}
