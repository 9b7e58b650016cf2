//! Scenes of joints: a hanging bridge, ragdolls, cars.

use super::parts::{Random, body, cuboid, ground};
use super::piles::root;
use crate::scene::format::*;

/// Turns the x axis of a frame to y, to z, and to -z.
const X_TO_Y: RotationDoc = RotationDoc::AxisAngle { axis: [0.0, 0.0, 1.0], degrees: 90.0 };
const X_TO_Z: RotationDoc = RotationDoc::AxisAngle { axis: [0.0, 1.0, 0.0], degrees: -90.0 };
const X_TO_DOWN: RotationDoc = RotationDoc::AxisAngle { axis: [0.0, 1.0, 0.0], degrees: 90.0 };
/// Turns the z axis, which is that of capsules and cylinders, to y.
const Z_TO_Y: RotationDoc = RotationDoc::AxisAngle { axis: [1.0, 0.0, 0.0], degrees: -90.0 };

/// A joint of two bodies of a list, none of which is turned, at a point of the world; the frames are turned.
fn joint(
    kind: JointKindDoc,
    bodies: &[BodyDoc],
    (a, b): (usize, usize),
    (point, rotation): ([f64; 3], RotationDoc),
) -> JointDoc {
    let frame = |index: usize| {
        let from = bodies[index].position;
        FrameDoc { position: [0, 1, 2].map(|i| (point[i] - from[i]) as f32), rotation }
    };
    let ends = [a, b].map(|index| BodyRefDoc::Index(index as u32));
    JointDoc { frames: [frame(a), frame(b)], ..JointDoc::new(kind, ends) }
}

/// A bridge of `size` planks with hinges between them, which hangs on four ropes; a box falls on every other
/// plank.
pub fn bridge(size: u32) -> Scene {
    const HEIGHT: f64 = 4.0;
    const HALF_WIDTH: f64 = 0.75;
    /// Of a rope, and how far its ends are apart in the beginning, metres.
    const ROPE: [f64; 2] = [1.5, 1.0];
    let mut bodies = vec![ground()];
    let left = -0.5 * f64::from(size - 1);
    let planks = (0..size).map(|i| body([left + f64::from(i), 0.0, HEIGHT], cuboid([0.48, 0.75, 0.05])));
    bodies.extend(planks);
    let mut joints = Vec::new();
    for index in 1..size as usize {
        let point = [left + index as f64 - 0.5, 0.0, HEIGHT];
        joints.push(joint(JointKindDoc::Hinge, &bodies, (index, index + 1), (point, X_TO_Y)));
    }
    for (plank, side) in [(1, -1.0), (size as usize, 1.0)] {
        for y in [-HALF_WIDTH, HALF_WIDTH] {
            let end = side * 0.5 * f64::from(size);
            let mut rope = JointDoc::new(
                JointKindDoc::Distance,
                [BodyRefDoc::Index(0), BodyRefDoc::Index(plank as u32)],
            );
            rope.frames[0].position = [(end + side * ROPE[1]) as f32, y as f32, HEIGHT as f32];
            rope.frames[1].position = [(end - bodies[plank].position[0]) as f32, y as f32, 0.0];
            rope.axes.x = Some(AxisDoc::limited(0.0, ROPE[0] as f32));
            joints.push(rope);
        }
    }
    let boxes = (0..size.div_ceil(2))
        .map(|i| body([left + 2.0 * f64::from(i), 0.0, HEIGHT + 1.0], cuboid([0.25; 3])));
    bodies.extend(boxes);
    Scene { bodies, joints, ..Scene::default() }
}

/// Place of a limb's middle in a ragdoll, the way from there to its ends, and its radius; metres.
type Limb = ([f64; 3], [f64; 3], f32);

/// Parts of a ragdoll that stands with its arms held out and looks along x.
const LIMBS: [Limb; 11] = [
    ([0.0, 0.0, 1.0], [0.0, 0.08, 0.0], 0.11),
    ([0.0, 0.0, 1.3], [0.0, 0.1, 0.0], 0.12),
    ([0.0, 0.0, 1.62], [0.0, 0.0, 0.02], 0.1),
    ([0.0, 0.4, 1.38], [0.0, 0.11, 0.0], 0.05),
    ([0.0, 0.7, 1.38], [0.0, 0.11, 0.0], 0.045),
    ([0.0, -0.4, 1.38], [0.0, 0.11, 0.0], 0.05),
    ([0.0, -0.7, 1.38], [0.0, 0.11, 0.0], 0.045),
    ([0.0, 0.11, 0.72], [0.0, 0.0, 0.14], 0.07),
    ([0.0, 0.11, 0.28], [0.0, 0.0, 0.16], 0.06),
    ([0.0, -0.11, 0.72], [0.0, 0.0, 0.14], 0.07),
    ([0.0, -0.11, 0.28], [0.0, 0.0, 0.16], 0.06),
];

/// Two parts of a ragdoll, the point of their joint, how its frames are turned, and two numbers of its range.
type Link = ((usize, usize), [f64; 3], RotationDoc, [f32; 2]);

/// Parts of a ragdoll with balls between them, and how far these go off their axis and twist, radians.
const BALLS: [Link; 6] = [
    ((0, 1), [0.0, 0.0, 1.15], X_TO_Z, [0.5, 0.5]),
    ((1, 2), [0.0, 0.0, 1.5], X_TO_Z, [0.6, 0.8]),
    ((1, 3), [0.0, 0.25, 1.38], X_TO_Y, [1.4, 1.0]),
    (
        (1, 5),
        [0.0, -0.25, 1.38],
        RotationDoc::AxisAngle { axis: [0.0, 0.0, 1.0], degrees: -90.0 },
        [1.4, 1.0],
    ),
    ((0, 7), [0.0, 0.11, 0.92], X_TO_DOWN, [1.0, 0.5]),
    ((0, 9), [0.0, -0.11, 0.92], X_TO_DOWN, [1.0, 0.5]),
];

/// Elbows and knees, with the axes of their hinges and how far they bend, radians.
const HINGES: [Link; 4] = [
    ((3, 4), [0.0, 0.55, 1.38], X_TO_Z, [-2.4, 0.0]),
    ((5, 6), [0.0, -0.55, 1.38], X_TO_Z, [0.0, 2.4]),
    ((7, 8), [0.0, 0.11, 0.5], X_TO_Y, [0.0, 2.4]),
    ((9, 10), [0.0, -0.11, 0.5], X_TO_Y, [0.0, 2.4]),
];

/// `size` ragdolls of 11 bodies and 10 joints that stumble, fall and go to sleep.
pub fn ragdolls(size: u32) -> Scene {
    let mut random = Random::new(4);
    let edge = root(size, 2);
    let (mut bodies, mut joints) = (vec![ground()], Vec::new());
    for index in 0..size {
        let [x, y] = [index % edge, index / edge].map(|c| 2.0 * f64::from(c) - f64::from(edge - 1));
        let velocity = [random.within(2.0) as f32, random.within(2.0) as f32, 0.0];
        let first = bodies.len();
        for (position, way, radius) in LIMBS {
            let along_y = way[1] > 0.0;
            let half_height = if along_y { way[1] } else { way[2] } as f32;
            let mut limb = body(
                [x + position[0], y + position[1], position[2]],
                GeometryDoc::Capsule { half_height, radius },
            );
            if along_y {
                limb.shapes[0].rotation = Z_TO_Y;
            }
            bodies.push(BodyDoc { linear_velocity: velocity, angular_damping: 2.0, ..limb });
        }
        let at = |point: [f64; 3]| [x + point[0], y + point[1], point[2]];
        for ((a, b), point, turn, [cone, twist]) in BALLS {
            let mut ball = joint(JointKindDoc::Ball, &bodies, (first + a, first + b), (at(point), turn));
            ball.cone = Some(cone);
            ball.axes.turn_x = Some(AxisDoc { friction: 0.3, ..AxisDoc::limited(-twist, twist) });
            joints.push(ball);
        }
        for ((a, b), point, turn, [lower, upper]) in HINGES {
            let mut hinge = joint(JointKindDoc::Hinge, &bodies, (first + a, first + b), (at(point), turn));
            hinge.axes.turn_x = Some(AxisDoc { friction: 0.5, ..AxisDoc::limited(lower, upper) });
            joints.push(hinge);
        }
    }
    // After one relax sweep dolls that lie on their arms go on rocking.
    let settings = SettingsDoc { sleep_time: Some(0.5), relax_sweeps: Some(8), ..SettingsDoc::default() };
    Scene { settings, bodies, joints, ..Scene::default() }
}

/// `size` cars of a body and four wheels, with springs, motors behind and steering in front; they drive over a
/// step, some straight on, some in a curve.
pub fn cars(size: u32) -> Scene {
    const WHEEL: f32 = 0.4;
    let mut bodies = vec![ground()];
    let mut joints = Vec::new();
    let edge = root(size, 2);
    let width = 4.0 * f64::from(edge);
    bodies
        .push(BodyDoc { kind: KindDoc::Static, ..body([6.0, 0.0, 0.0], cuboid([0.5, width as f32, 0.08])) });
    for index in 0..size {
        let x = -6.0 * f64::from(index / edge);
        let y = 4.0 * f64::from(index % edge) - 0.5 * (width - 4.0);
        let chassis = bodies.len();
        bodies.push(body([x, y, 0.75], cuboid([1.3, 0.6, 0.25])));
        for (dx, dy) in [(-0.9, -0.85), (-0.9, 0.85), (0.9, -0.85), (0.9, 0.85)] {
            let at = [x + dx, y + dy, f64::from(WHEEL)];
            let mut wheel = body(at, GeometryDoc::Cylinder { half_height: 0.12, radius: WHEEL });
            wheel.shapes[0].rotation = Z_TO_Y;
            bodies.push(wheel);
            let ends = (chassis, bodies.len() - 1);
            let mut wheel = joint(JointKindDoc::Wheel, &bodies, ends, (at, X_TO_Y));
            let suspension = SpringDoc::Frequency { hertz: 2.5, damping_ratio: 0.5 };
            let spring = DriveDoc { spring: Some(suspension), ..DriveDoc::default() };
            wheel.axes.z = Some(AxisDoc { drive: Some(spring), ..AxisDoc::limited(-0.15, 0.15) });
            if dx < 0.0 {
                let motor = DriveDoc { velocity: 12.0, max_force: Some(400.0), ..DriveDoc::default() };
                wheel.axes.turn_x = Some(AxisDoc::driven(motor));
            } else {
                // From -0.2 to 0.2 rad, from car to car.
                let target = 0.1 * (index % 5) as f32 - 0.2;
                let spring = Some(SpringDoc::Frequency { hertz: 8.0, damping_ratio: 1.0 });
                let steering = DriveDoc { target, spring, ..DriveDoc::default() };
                wheel.axes.turn_z = Some(AxisDoc { drive: Some(steering), ..AxisDoc::limited(-0.5, 0.5) });
            }
            joints.push(wheel);
        }
    }
    Scene { bodies, joints, ..Scene::default() }
}
