//! Joints of a model as joints of a scene: compounds, equalities, ropes, excludes and actuators.

use super::super::math::{Placement, dot, scaled, sub};
use super::super::model::{
    Actuator, BodyKind, Control, Equality, Exclude, Joint, JointPart, Model, Motion, Rope, Transmission,
};
use super::axes::{Compound, Coordinate, compound};
use super::{Making, rotation};
use crate::scene::format::{
    AxisDoc, BodyRefDoc, DriveDoc, FrameDoc, JointDoc, JointKindDoc, MotionDoc, SpringDoc,
};
use cellstep_core::joint::axis::{TURN_X, TURN_Y, TURN_Z};
use std::collections::{BTreeMap, BTreeSet};

/// Greatest coordinate, stiffness and force of a scene's joints.
const COORDINATE_MAX: f64 = 1.0e5;
const EFFORT_MAX: f64 = 1.0e12;
/// Range of cones, radians.
const CONE: [f64; 2] = [0.01, 3.1];
/// A rod that stands across its slider moves it at no finite rate: the rate is taken at this share of across.
const CRANK_ACROSS: f64 = 0.9;

/// Springs, dampers and motors on one coordinate, added.
#[derive(Clone, Copy, Default)]
struct Pull {
    stiffness: f64,
    damping: f64,
    /// Sum of stiffness times rest, and of damping times velocity.
    force: f64,
    push: f64,
    /// Number of forces, and the bound of the last that has one.
    forces: usize,
    bound: Option<f64>,
}

impl Pull {
    fn add(&mut self, (stiffness, rest): (f64, f64), (damping, velocity): (f64, f64), bound: Option<f64>) {
        if stiffness <= 0.0 && damping <= 0.0 {
            return;
        }
        self.stiffness += stiffness;
        self.damping += damping;
        self.force += stiffness * rest;
        self.push += damping * velocity;
        self.forces += 1;
        self.bound = bound.or(self.bound);
    }

    /// The drive of a coordinate that is `sign` times the value.
    fn drive(&self, (sign, offset): (f64, f64)) -> Option<DriveDoc> {
        if self.forces == 0 {
            return None;
        }
        let mean = |sum: f64, weight: f64| if weight > 0.0 { sum / weight } else { 0.0 };
        let rest = sign * mean(self.force, self.stiffness) + offset;
        let number = |x: f64, most: f64| x.clamp(-most, most) as f32;
        let spring = SpringDoc::Stiffness {
            stiffness: number(self.stiffness, EFFORT_MAX),
            damping: number(self.damping, EFFORT_MAX),
        };
        Some(DriveDoc {
            target: number(if self.stiffness > 0.0 { rest } else { 0.0 }, COORDINATE_MAX),
            velocity: number(sign * mean(self.push, self.damping), COORDINATE_MAX),
            spring: Some(spring),
            max_force: self.bound.filter(|_| self.forces == 1).map(|bound| number(bound, EFFORT_MAX)),
        })
    }
}

impl Making<'_> {
    /// All that joins bodies.
    pub(super) fn links(&mut self) {
        let model = self.model;
        let mut pulls = self.joint_pulls(model);
        for (index, joint) in model.joints.iter().enumerate() {
            let pulls = pulls.remove(&index).unwrap_or_default();
            self.joint(joint, &pulls);
        }
        model.equalities.iter().filter(|equality| equality.active).for_each(|e| self.equality(e));
        model.ropes.iter().for_each(|rope| self.rope(rope));
        for actuator in &model.actuators {
            if let Transmission::SliderCrank { .. } = actuator.transmission {
                self.slider_crank(actuator);
            }
        }
        self.excludes(&model.excludes);
        self.keep_awake(model);
    }

    /// What a servo moves does not sleep: it may creep, and its control is there to be changed.
    fn keep_awake(&mut self, model: &Model) {
        for actuator in model.actuators.iter().filter(|actuator| actuator.control != Control::Motor) {
            let body = match actuator.transmission {
                Transmission::Joint(joint, _) => model.joints[joint].child,
                Transmission::SliderCrank { crank, .. } => crank.body,
            };
            if model.bodies[body].kind != BodyKind::Fixed {
                let place = self.place_of(body) as usize;
                self.scene.bodies[place].can_sleep = false;
            }
        }
    }

    /// A joint between two bodies of the model with frames in them.
    fn push(&mut self, kind: JointKindDoc, ends: [(usize, Placement); 2]) -> &mut JointDoc {
        let bodies = ends.map(|(body, _)| BodyRefDoc::Index(self.place_of(body)));
        let frames = ends.map(|(_, placement)| FrameDoc {
            position: placement.position.map(|x| x as f32),
            rotation: rotation(placement.turn),
        });
        self.scene.joints.push(JointDoc { frames, ..JointDoc::new(kind, bodies) });
        self.scene.joints.last_mut().expect("one was pushed")
    }

    /// What springs, dampers and actuators do to each part of each joint.
    fn joint_pulls(&mut self, model: &Model) -> BTreeMap<usize, Vec<Pull>> {
        let mut pulls: BTreeMap<usize, Vec<Pull>> = BTreeMap::new();
        for (index, joint) in model.joints.iter().enumerate() {
            let mut own = vec![Pull::default(); joint.parts.len()];
            for (pull, part) in own.iter_mut().zip(&joint.parts) {
                pull.add((part.stiffness, part.spring_rest), (part.damping, 0.0), None);
            }
            pulls.insert(index, own);
        }
        for actuator in &model.actuators {
            let Transmission::Joint(joint, part) = actuator.transmission else { continue };
            let reference = model.joints[joint].parts[part].reference;
            let Some((spring, damper)) = self.control(actuator, reference) else { continue };
            let bound = self.bound(actuator);
            if let Some(pull) = pulls.get_mut(&joint).and_then(|parts| parts.get_mut(part)) {
                pull.add(spring, damper, bound);
            }
        }
        let crowded = pulls.values().flatten().filter(|pull| pull.forces > 1 && pull.bound.is_some()).count();
        self.lose("actuator/forcerange beside another force on the joint", crowded);
        pulls
    }

    /// Stiffness and rest, damping and velocity of a coordinate that begins at `reference`, by an actuator whose
    /// control is as near to 0 as its range allows.
    fn control(&mut self, actuator: &Actuator, reference: f64) -> Option<((f64, f64), (f64, f64))> {
        let gear = actuator.gear;
        let control = actuator.control_range.map_or(0.0, |[low, high]| 0.0f64.max(low).min(high));
        if gear == 0.0 {
            return None;
        }
        match actuator.control {
            Control::Motor => {
                self.lose("motor: its control is 0 in a scene", usize::from(control != 0.0));
                None
            }
            Control::Position { kp, kv } => {
                Some(((kp * gear * gear, control / gear - reference), (kv * gear * gear, 0.0)))
            }
            Control::Velocity { kv } => Some(((0.0, 0.0), (kv * gear * gear, control / gear))),
        }
    }

    fn bound(&mut self, actuator: &Actuator) -> Option<f64> {
        let [low, high] = actuator.force_range?;
        self.lose("actuator/forcerange whose ends are not alike", usize::from(low != -high));
        Some(actuator.gear.abs() * high.abs().max(low.abs()))
    }

    fn joint(&mut self, joint: &Joint, pulls: &[Pull]) {
        let compound = compound(joint);
        compound.losses.iter().for_each(|loss| self.lose(loss, 1));
        let bodies = &self.model.bodies;
        let (outer, own) = (bodies[joint.parent].placement, bodies[joint.child].placement);
        let seen = |turn| Placement::new(compound.anchor, turn);
        let in_parent = |turn| outer.inverse().after(&own.after(&seen(turn)));
        let [a, b] = compound.turns;
        let ends = if compound.reversed {
            [(joint.child, seen(a)), (joint.parent, in_parent(b))]
        } else {
            [(joint.parent, in_parent(a)), (joint.child, seen(b))]
        };
        let losses = ball_losses(joint);
        losses.into_iter().for_each(|(what, count)| self.lose(what, count));
        let doc = self.push(JointKindDoc::SixAxis, ends);
        doc.bodies_collide = joint.collide.then_some(true);
        set_axes(doc, joint, (&compound, pulls));
        simplify(doc);
    }

    fn equality(&mut self, equality: &Equality) {
        let kind = if equality.weld { JointKindDoc::Fixed } else { JointKindDoc::Ball };
        self.push(kind, [equality.a, equality.b]).bodies_collide = Some(true);
    }

    fn rope(&mut self, rope: &Rope) {
        let at = |point: super::super::model::Point| {
            (point.body, Placement { position: point.position, ..Placement::IDENTITY })
        };
        let [low, high] = rope.rest;
        let slack = rope.stiffness > 0.0 && low != high;
        let mut axis = AxisDoc { friction: rope.friction_loss as f32, ..AxisDoc::default() };
        let mut pull = Pull::default();
        let stiffness = if slack { 0.0 } else { rope.stiffness };
        pull.add((stiffness, low), (rope.damping, 0.0), None);
        axis.drive = pull.drive((1.0, 0.0));
        if let Some([lower, upper]) = rope.range {
            axis.motion = between(Some(lower).filter(|&x| x > 0.0), Some(upper));
        } else if slack && low <= 0.0 {
            axis.motion = between(None, Some(high));
            let stiffness = rope.stiffness.min(EFFORT_MAX) as f32;
            axis.limit_spring = Some(SpringDoc::Stiffness { stiffness, damping: 0.0 });
        }
        let lost = slack && axis.limit_spring.is_none();
        self.lose("tendon/springlength of two lengths", usize::from(lost));
        self.push(JointKindDoc::Distance, [at(rope.a), at(rope.b)]).axes.x = Some(axis);
    }

    /// The rod of a slider-crank with its slider at 0: a spring between the crank and the slider's frame, whose
    /// length of rest is the rod's. At rest both pull alike; away from it the way of the slider is curved.
    fn slider_crank(&mut self, actuator: &Actuator) {
        let Transmission::SliderCrank { crank, body, slider, rod } = actuator.transmission else { return };
        if crank.body == body {
            return;
        }
        let Some(((stiffness, control), (damping, velocity))) = self.control(actuator, 0.0) else { return };
        let exact = control == 0.0 && velocity == 0.0;
        self.lose("slider-crank: its slider away from 0", usize::from(!exact));
        self.lose("slider-crank: as a spring of the rod's length between crank and slider", 1);
        let bodies = &self.model.bodies;
        let frame = bodies[body].placement.after(&slider);
        let crank_at = bodies[crank.body].placement.transform(crank.position);
        let way = sub(crank_at, frame.position);
        let axis = frame.turn.rotate([0.0, 0.0, 1.0]);
        let off = sub(way, scaled(axis, dot(way, axis)));
        // The slider's rate for each unit of the rod's: d(slider)/d(length) = rod / sqrt(rod^2 - across^2).
        let share = if rod > 0.0 { (dot(off, off).sqrt() / rod).min(CRANK_ACROSS) } else { 0.0 };
        let rate = 1.0 / (1.0 - share * share);
        let mut pull = Pull::default();
        pull.add((stiffness * rate, rod), (damping * rate, 0.0), self.bound(actuator));
        let ends =
            [(body, slider), (crank.body, Placement { position: crank.position, ..Placement::IDENTITY })];
        let drive = pull.drive((1.0, 0.0));
        self.push(JointKindDoc::Distance, ends).axes.x = Some(AxisDoc { drive, ..AxisDoc::default() });
    }

    /// Bodies that do not collide: a joint that leaves everything free says so.
    fn excludes(&mut self, excludes: &[Exclude]) {
        let apart: BTreeSet<[usize; 2]> = excludes.iter().map(|exclude| sorted(exclude.parts)).collect();
        let mut pairs = BTreeSet::new();
        for exclude in excludes {
            let [a, b] = sorted(exclude.bodies);
            if !pairs.insert([a, b]) {
                continue;
            }
            let bodies = &self.model.bodies;
            let meets = |a: usize, b: usize| {
                let mut geoms = bodies[a].geoms.iter().filter(|geom| self.collides(geom));
                geoms.any(|x| {
                    let others = bodies[b].geoms.iter().filter(|geom| self.collides(geom));
                    others.into_iter().any(|y| x.meets(y) && !apart.contains(&sorted([x.part, y.part])))
                })
            };
            let whole = !meets(a, b);
            self.lose("contact/exclude of parts of bodies, which do not collide at all", usize::from(!whole));
            let own = self.place_of(b);
            for place in self.places_of(a) {
                let ends = [BodyRefDoc::Index(place), BodyRefDoc::Index(own)];
                self.scene.joints.push(JointDoc::new(JointKindDoc::SixAxis, ends));
            }
        }
    }
}

fn sorted([a, b]: [usize; 2]) -> [usize; 2] {
    if a < b { [a, b] } else { [b, a] }
}

/// What a ball does otherwise than the model says.
fn ball_losses(joint: &Joint) -> [(&'static str, usize); 2] {
    let count = |is: &dyn Fn(&JointPart) -> bool| {
        joint.parts.iter().filter(|part| part.motion == Motion::Ball && is(part)).count()
    };
    [
        ("joint/range of a ball: as a cone and a twist of that angle", count(&|part| part.range.is_some())),
        (
            "joint: forces of a ball by its three turns, each by itself",
            count(&|part| part.stiffness + part.damping + part.friction_loss > 0.0),
        ),
    ]
}

/// Writes the axes of a compound.
fn set_axes(doc: &mut JointDoc, joint: &Joint, (compound, pulls): (&Compound, &[Pull])) {
    for index in 0..6 {
        let free = compound.ball && index >= TURN_X;
        let motion = if free { MotionDoc::Free } else { MotionDoc::Locked };
        *doc.axes.at(index) = Some(AxisDoc { motion, ..AxisDoc::default() });
    }
    if compound.tilt != 0.0 {
        let tilt = Some(compound.tilt);
        *doc.axes.at(TURN_Y) = Some(AxisDoc { motion: between(tilt, tilt), ..AxisDoc::default() });
    }
    for ((part, pull), coordinate) in joint.parts.iter().zip(pulls).zip(&compound.parts) {
        match coordinate {
            Some(coordinate) => *doc.axes.at(coordinate.axis) = Some(axis_of(part, pull, coordinate)),
            None if part.motion == Motion::Ball => {
                for index in [TURN_X, TURN_Y, TURN_Z] {
                    let axis = AxisDoc {
                        drive: pull.drive((1.0, 0.0)),
                        friction: part.friction_loss as f32,
                        ..AxisDoc::default()
                    };
                    *doc.axes.at(index) = Some(axis);
                }
                if let Some([_, angle]) = part.range {
                    let angle = angle.clamp(CONE[0], CONE[1]);
                    doc.cone = Some(angle as f32);
                    let twist = doc.axes.at(TURN_X).get_or_insert_default();
                    twist.motion = between(Some(-angle), Some(angle));
                }
            }
            None => {}
        }
    }
}

fn axis_of(part: &JointPart, pull: &Pull, coordinate: &Coordinate) -> AxisDoc {
    let Coordinate { sign, offset, .. } = *coordinate;
    let motion = part.range.map_or(MotionDoc::Free, |range| {
        let [a, b] = range.map(|x| sign * x + offset);
        between(Some(a.min(b)), Some(a.max(b)))
    });
    AxisDoc {
        motion,
        drive: pull.drive((sign, offset)),
        friction: part.friction_loss.min(EFFORT_MAX) as f32,
        ..AxisDoc::default()
    }
}

/// A range; what is beyond the coordinates of scenes is no limit.
fn between(lower: Option<f64>, upper: Option<f64>) -> MotionDoc {
    let inside = |x: Option<f64>| x.filter(|x| x.abs() <= COORDINATE_MAX).map(|x| x as f32);
    MotionDoc::Limited { lower: inside(lower), upper: inside(upper) }
}

/// Says the same by a kind with a name, where there is one.
fn simplify(doc: &mut JointDoc) {
    use MotionDoc::Locked;
    let locked = |axis: Option<&AxisDoc>| axis.is_some_and(|axis| axis.motion == Locked);
    let held: Vec<bool> = doc.axes.list().iter().map(|(_, axis)| locked(*axis)).collect();
    let (kind, kept): (JointKindDoc, &[bool; 6]) = match held[..] {
        [true, true, true, false, true, true] => {
            (JointKindDoc::Hinge, &[true, true, true, false, true, true])
        }
        [false, true, true, true, true, true] => {
            (JointKindDoc::Slider, &[false, true, true, true, true, true])
        }
        [true, true, true, ..] => (JointKindDoc::Ball, &[true, true, true, false, false, false]),
        _ => return,
    };
    doc.kind = kind;
    for (index, &held) in kept.iter().enumerate() {
        let axis = doc.axes.at(index);
        let plain = AxisDoc { motion: if held { Locked } else { MotionDoc::Free }, ..AxisDoc::default() };
        if axis.as_ref() == Some(&plain) {
            *axis = None;
        }
    }
}
