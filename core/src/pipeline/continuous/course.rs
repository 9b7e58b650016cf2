//! The way that a fast body takes through a step: from where it was and what the solve made of it.

use crate::body::{BodyRow, Motion, Position};
use crate::collide::cast::course::{Course, Turn};
use crate::collide::cast::frame::{Frame, length, narrowed, widened};
use crate::math::{Rotation, Vec3};
use crate::pipeline::integration::split_frame;
use glam::DVec3;

/// Turn in a step from which on a body's way follows from its velocity and not from its last orientation, radians.
const TURN_MAX: f64 = 0.5;

/// The way of a body through the step, places from `from`; the angular velocity is that at the end.
///
/// What turns by much in the step goes on a way of its own: two orientations do not tell how it came from one to
/// the other. It is taken to turn freely at its last velocity from its first orientation, as a symmetric top does,
/// exactly: about its momentum by `L / I`, and about the odd axis by what is left. Then the point that meets a
/// surface is one that comes nearer by the body's velocities, and the contact of the next step has something to
/// stop.
pub(super) fn course(from: Position, (origin, end, row): (&Motion, &Motion, &BodyRow), dt: f32) -> Course {
    let start = Frame::new(origin.center.minus_wide(from), origin.rotation);
    let way = end.center.minus_wide(origin.center);
    let turn = widened(end.angular) * f64::from(dt);
    let odd = odd_axis(row);
    let (first, last) = (Quaternion::of(origin.rotation), Quaternion::of(end.rotation));
    let loose = turn.dot(turn) >= TURN_MAX * TURN_MAX;
    let (swing, twist) = if !loose {
        turns_between(first, last, odd)
    } else if let Some((axis, ratio)) = odd {
        let (before, after) = (first.rotate(axis), last.rotate(axis));
        let turn = Quaternion::about(swing_between(after, before)).rotate(turn);
        let spin = turn.dot(before);
        let swing = turn + before * (spin * (ratio - 1.0));
        let twist = Turn { axis: before, angle: spin * (1.0 - ratio) };
        (Turn::of(swing), twist)
    } else {
        (Turn::of(turn), Turn::NONE)
    };
    let end = loose.then(|| Frame::new(end.center.minus_wide(from), end.rotation));
    Course { start, way, swing, twist, end, held: false, from: 0.0 }
}

/// A rotation that goes with a course up to a time.
pub(super) fn turned(rotation: Rotation, course: &Course, time: f64) -> Rotation {
    let share = time - course.from;
    let turn = |turn: Turn| Rotation::from_rotation_vector(narrowed(turn.axis * (turn.angle * share)));
    turn(course.swing).after(turn(course.twist).after(rotation)).normalized()
}

/// An angular velocity in the view of the body's odd axis when a body that stands in one orientation is put in
/// another. Of a body with three moments that turns about the other axes too: slower, if it had more energy.
pub(super) fn turned_along(angular: Vec3, row: &BodyRow, (from, to): (Rotation, Rotation)) -> Vec3 {
    let Some((axis, _)) = odd_axis(row) else { return angular };
    let (before, after) = (Quaternion::of(from).rotate(axis), Quaternion::of(to).rotate(axis));
    let turned = Quaternion::about(swing_between(before, after)).rotate(widened(angular));
    let energy = |angular: DVec3, rotation: Rotation| {
        let local = Quaternion::of(rotation.after(row.axes)).inverse().rotate(angular);
        (local * local).dot(widened(row.inertia))
    };
    let (before, after) = (energy(widened(angular), from), energy(turned, to));
    narrowed(if after > before { turned * libm::sqrt(before / after) } else { turned })
}

/// The axis of the moment of inertia that stands out, in the body's frame, and its moment over the mean of the
/// others.
fn odd_axis(row: &BodyRow) -> Option<(DVec3, f64)> {
    let i = row.inertia;
    if i.x == i.y && i.y == i.z {
        return None;
    }
    let (frame, moments) = split_frame(i);
    let axis = widened(row.axes.after(frame).rotate(Vec3::Z));
    Some((axis, 2.0 * f64::from(moments.z) / (f64::from(moments.x) + f64::from(moments.y))))
}

/// The least turn that takes one unit vector to another.
fn swing_between(before: DVec3, after: DVec3) -> Turn {
    let across = before.cross(after);
    let sine = length(across);
    if sine == 0.0 {
        Turn::NONE
    } else {
        Turn { axis: across / sine, angle: libm::atan2(sine, before.dot(after)) }
    }
}

/// The turn from one orientation to another: the least one that takes the odd axis along, and a twist about that
/// axis. Of a body without such an axis all is swing.
fn turns_between(from: Quaternion, to: Quaternion, odd: Option<(DVec3, f64)>) -> (Turn, Turn) {
    let whole = to.after(from.inverse());
    let Some((axis, _)) = odd else { return (whole.turn(None), Turn::NONE) };
    let (before, after) = (from.rotate(axis), to.rotate(axis));
    let swing = swing_between(before, after);
    (swing, Quaternion::about(swing).inverse().after(whole).turn(Some(before)))
}

/// A rotation in double precision, of length 1 but for the rounding of the state.
#[derive(Clone, Copy)]
struct Quaternion {
    imaginary: DVec3,
    real: f64,
}

impl Quaternion {
    fn of(q: Rotation) -> Self {
        let [x, y, z, w] = [q.x, q.y, q.z, q.w].map(f64::from);
        Self { imaginary: DVec3::new(x, y, z), real: w }
    }

    fn about(turn: Turn) -> Self {
        let half = 0.5 * turn.angle;
        Self { imaginary: turn.axis * libm::sin(half), real: libm::cos(half) }
    }

    fn inverse(self) -> Self {
        Self { imaginary: -self.imaginary, ..self }
    }

    /// First `first`, then this.
    fn after(self, first: Self) -> Self {
        let (a, b) = (self.imaginary, first.imaginary);
        Self {
            imaginary: b * self.real + a * first.real + a.cross(b),
            real: self.real * first.real - a.dot(b),
        }
    }

    fn rotate(self, v: DVec3) -> DVec3 {
        let t = self.imaginary.cross(v) * 2.0;
        v + t * self.real + self.imaginary.cross(t)
    }

    /// Axis and angle, at most half a turn; about a given unit axis what there is about it.
    fn turn(self, axis: Option<DVec3>) -> Turn {
        let (v, w) =
            if self.real < 0.0 { (-self.imaginary, -self.real) } else { (self.imaginary, self.real) };
        if let Some(axis) = axis {
            return Turn { axis, angle: 2.0 * libm::atan2(v.dot(axis), w) };
        }
        let size = length(v);
        if size == 0.0 { Turn::NONE } else { Turn { axis: v / size, angle: 2.0 * libm::atan2(size, w) } }
    }
}
