//! Which axes of a six-axis joint the parts of a joint are.
//!
//! MuJoCo moves a body by its parts one after the other, the first next to the body around it. A six-axis joint
//! shifts along A's axes and then turns about z, about the new y and about the new x. So of three hinges the first
//! is z, the second y and the third x; slides come before the hinges. Where hinges come first, the same joint is
//! seen from the other side: A is the child, the order is the opposite, and every value changes its sign.
//!
//! With z the axis of the first hinge, x that of the last and y across both, the frames of A and B stand at an
//! angle of y in the beginning, 0 where the two axes are at right angles: so hinges need not be at right angles,
//! but for the second of three, which has to be across the others.

use super::super::math::{Turn, Vector, add, cross, direction, dot, scaled, sub};
use super::super::model::{Joint, JointPart, Motion};
use cellstep_core::joint::axis::{TURN_X, TURN_Y, TURN_Z};

/// Directions are the same, or at right angles, when their product is this near to 1, or to 0.
const NEAR: f64 = 1.0e-6;
/// Axes meet when they pass each other at no more than this, metres.
const MEET: f64 = 1.0e-5;
/// A middle turn is kept away from 90 degrees by this, radians: there the other two are one.
const POLE: f64 = 0.05;

/// A part as an axis of a six-axis joint: its coordinate there is `sign` times the part's value, and `offset`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Coordinate {
    /// Index of the axis.
    pub axis: usize,
    /// 1 or -1.
    pub sign: f64,
    /// Radians; not 0 for a middle turn only.
    pub offset: f64,
}

/// A joint seen as one six-axis joint. All coordinates are 0 in the beginning, but for the offset of the turn y.
#[derive(Debug)]
pub(super) struct Compound {
    /// True when the child is A.
    pub reversed: bool,
    /// The point in the child's frame.
    pub anchor: Vector,
    /// How the frames of A and of B are turned in the child's frame.
    pub turns: [Turn; 2],
    /// Where turn y starts.
    pub tilt: f64,
    /// For each part its axis; `None` for a ball, and for what there is no axis for.
    pub parts: Vec<Option<Coordinate>>,
    /// Whether all turns are free.
    pub ball: bool,
    /// What is not as the model says.
    pub losses: Vec<&'static str>,
}

/// Finds the axes.
pub(super) fn compound(joint: &Joint) -> Compound {
    let parts = &joint.parts;
    let of = |motion: Motion| -> Vec<usize> {
        (0..parts.len()).filter(|&index| parts[index].motion == motion).collect()
    };
    let (mut hinges, slides, balls) = (of(Motion::Hinge), of(Motion::Slide), of(Motion::Ball));
    let mut losses = Vec::new();
    if !balls.is_empty() && !hinges.is_empty() || balls.len() > 1 {
        losses.push("joint: a hinge or a ball beside a ball");
    }
    if balls.is_empty() && hinges.len() > 3 {
        losses.push("joint: more than three hinges of a body, which turns freely instead");
    }
    let ball = !balls.is_empty() || hinges.len() > 3;
    let turns_of: Vec<usize> = hinges.iter().chain(&balls).copied().collect();
    if ball {
        hinges.clear();
    }
    let reversed = is_reversed(parts, (&turns_of, &slides), &mut losses);
    if reversed {
        hinges.reverse();
    }
    let anchor = match balls.first().or(turns_of.first()).or(slides.first()) {
        Some(&index) if turns_of.len() < 2 || ball => parts[index].anchor,
        _ => meeting(parts, &hinges, &mut losses),
    };
    let axes: Vec<Vector> = hinges.iter().map(|&index| parts[index].axis).collect();
    let leads: Vec<Vector> = slides.iter().map(|&index| parts[index].axis).collect();
    let frames = Frames::of(&axes, &leads);
    let sign = if reversed { -1.0 } else { 1.0 };
    let mut found = vec![None; parts.len()];
    frames.turns(&axes, (&hinges, sign), &mut found, &mut losses);
    frames.shifts((&slides, &leads), sign, &mut found, &mut losses);
    check_pole(parts, &found, &mut losses);
    let turns = [Turn::from_columns(frames.a), Turn::from_columns(frames.b)];
    Compound { reversed, anchor, turns, tilt: frames.tilt, parts: found, ball, losses }
}

/// Whether the slides come after the turns. Where they come in between, the first way is taken.
fn is_reversed(
    parts: &[JointPart],
    (turns, slides): (&[usize], &[usize]),
    losses: &mut Vec<&'static str>,
) -> bool {
    let (Some(&first), Some(&last)) = (turns.iter().min(), turns.iter().max()) else { return false };
    let after = slides.iter().filter(|&&slide| slide > first).count();
    // Along the axis of a single hinge it makes no difference.
    let is_along = |slide: &usize| dot(parts[*slide].axis, parts[first].axis).abs() > 1.0 - NEAR;
    if after == 0 || turns.len() == 1 && slides.iter().all(is_along) {
        return false;
    }
    if slides.iter().all(|&slide| slide > last) {
        return true;
    }
    losses.push("joint: slides between the hinges of a body, which go before them instead");
    false
}

/// The point nearest to the axes of hinges.
fn meeting(parts: &[JointPart], hinges: &[usize], losses: &mut Vec<&'static str>) -> Vector {
    let Some(&first) = hinges.first() else { return [0.0; 3] };
    let start = parts[first].anchor;
    // Each axis pulls to its nearest point, from the mean of the anchors on: projections converge, and where all
    // axes are parallel they stay at the mean.
    let sum = hinges.iter().fold([0.0; 3], |sum, &index| add(sum, sub(parts[index].anchor, start)));
    let mut point = add(start, scaled(sum, 1.0 / hinges.len() as f64));
    let off = |point: Vector, index: usize| {
        let part = &parts[index];
        let way = sub(point, part.anchor);
        sub(way, scaled(part.axis, dot(way, part.axis)))
    };
    for _ in 0..200 {
        let pull = hinges.iter().fold([0.0; 3], |sum, &index| sub(sum, off(point, index)));
        point = add(point, scaled(pull, 1.0 / hinges.len() as f64));
    }
    if hinges.iter().any(|&index| dot(off(point, index), off(point, index)) > MEET * MEET) {
        losses.push(
            "joint/pos: axes of a body's hinges that do not meet, which turn about the point between them",
        );
    }
    point
}

/// Columns of the frames of A and B in the child's frame.
struct Frames {
    a: [Vector; 3],
    b: [Vector; 3],
    tilt: f64,
}

impl Frames {
    /// Of hinges, from A to B, and slides along A's axes.
    fn of(hinges: &[Vector], slides: &[Vector]) -> Self {
        if let [z, .., x] = *hinges {
            // Across both; across the first and the second where the others are parallel.
            let second = if hinges.len() == 3 { cross(cross(z, hinges[1]), z) } else { across(z) };
            let y = direction(cross(z, x)).or(direction(second)).unwrap_or(across(z));
            let a = [cross(y, z), y, z];
            let b = [x, y, cross(x, y)];
            return Self { a, b, tilt: libm::atan2(-dot(x, z), dot(x, a[0])) };
        }
        let all: Vec<Vector> = hinges.iter().chain(slides).copied().collect();
        let x = all.first().copied().unwrap_or([1.0, 0.0, 0.0]);
        let rest =
            |v: &Vector| direction(sub(*v, scaled(x, dot(*v, x)))).filter(|_| dot(*v, x).abs() < 1.0 - NEAR);
        let y = all.iter().find_map(rest).unwrap_or(across(x));
        let a = [x, y, cross(x, y)];
        Self { a, b: a, tilt: 0.0 }
    }

    /// Axes of hinges.
    fn turns(
        &self,
        axes: &[Vector],
        (hinges, sign): (&[usize], f64),
        found: &mut [Option<Coordinate>],
        losses: &mut Vec<&'static str>,
    ) {
        let order: &[usize] = match hinges.len() {
            0 | 1 => &[TURN_X],
            2 => &[TURN_Z, TURN_X],
            _ => &[TURN_Z, TURN_Y, TURN_X],
        };
        for ((&axis, &hinge), &direction) in order.iter().zip(hinges).zip(axes) {
            let mut coordinate = Coordinate { axis, sign, offset: 0.0 };
            if axis == TURN_Y {
                let along = dot(direction, self.a[1]);
                coordinate.offset = self.tilt;
                coordinate.sign = if along < 0.0 { -sign } else { sign };
                if along.abs() < 1.0 - NEAR {
                    losses.push("joint/axis: the second of three hinges not at right angles to the others");
                }
            }
            found[hinge] = Some(coordinate);
        }
    }

    /// Axes of slides: each the nearest that is left.
    fn shifts(
        &self,
        (slides, leads): (&[usize], &[Vector]),
        sign: f64,
        found: &mut [Option<Coordinate>],
        losses: &mut Vec<&'static str>,
    ) {
        let mut free = [true; 3];
        for (&slide, &lead) in slides.iter().zip(leads) {
            let along = self.a.map(|axis| dot(axis, lead));
            let nearest = (0..3)
                .filter(|&i| free[i])
                .reduce(|best, i| if along[i].abs() > along[best].abs() { i } else { best });
            let Some(axis) = nearest else {
                losses.push("joint: more than three slides of a body");
                return;
            };
            free[axis] = false;
            if along[axis].abs() < 1.0 - NEAR {
                losses.push("joint/axis: a slide not at right angles to the other slides and hinges");
            }
            let sign = if along[axis] < 0.0 { -sign } else { sign };
            found[slide] = Some(Coordinate { axis, sign, offset: 0.0 });
        }
    }
}

/// A unit vector at right angles to a unit vector.
fn across(v: Vector) -> Vector {
    let least = (1..3).fold(0, |least, i| if v[i].abs() < v[least].abs() { i } else { least });
    let mut axis = [0.0; 3];
    axis[least] = 1.0;
    direction(cross(v, axis)).unwrap_or([1.0, 0.0, 0.0])
}

/// Tells of a middle turn that may reach 90 degrees.
fn check_pole(parts: &[JointPart], found: &[Option<Coordinate>], losses: &mut Vec<&'static str>) {
    for (part, coordinate) in parts.iter().zip(found) {
        let Some(Coordinate { axis: TURN_Y, sign, offset }) = *coordinate else { continue };
        let most = std::f64::consts::FRAC_PI_2 - POLE;
        let inside = |x: f64| (sign * x + offset).abs() <= most;
        if !part.range.is_some_and(|range| range.into_iter().all(inside)) {
            losses.push(
                "joint/range: the second of three hinges beyond 87 degrees, where the others turn as one",
            );
        }
    }
}
