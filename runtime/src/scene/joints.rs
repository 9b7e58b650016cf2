//! Joints of a document as definitions of the engine, and the bodies that they name.

use super::format::*;
use super::rotation;
use cellstep_core::joint::axis;
use cellstep_core::math::{Pose, Rotation, Vec3};
use cellstep_core::{Axis, AxisMotion, BodyHandle, Drive, JointDef, Spring};
use std::collections::BTreeMap;

/// Limits, drives and frictions that there is room for with each joint.
const BOUNDS_PER_JOINT: usize = 4;

/// Indices of the bodies that have names.
pub(super) fn names(scene: &Scene) -> BTreeMap<&str, usize> {
    let named = scene.bodies.iter().enumerate();
    named.filter_map(|(index, body)| Some((body.name.as_deref()?, index))).collect()
}

/// The index of the body that is meant; `None` when there is no such body.
pub(super) fn index_of(body: &BodyRefDoc, names: &BTreeMap<&str, usize>, bodies: usize) -> Option<usize> {
    match body {
        BodyRefDoc::Index(index) => Some(*index as usize).filter(|&index| index < bodies),
        BodyRefDoc::Name(name) => names.get(name.as_str()).copied(),
    }
}

/// Joints to make room for, so that all limits, drives and frictions of the scene fit.
pub(super) fn room(scene: &Scene) -> usize {
    let of_axis = |axis: &AxisDoc| {
        let limited = matches!(axis.motion, MotionDoc::Limited { .. });
        usize::from(limited) + usize::from(axis.drive.is_some()) + usize::from(axis.friction > 0.0)
    };
    let of_joint = |joint: &JointDoc| {
        let axes = joint.axes.list().into_iter().filter_map(|(_, axis)| axis);
        axes.map(of_axis).sum::<usize>() + usize::from(joint.cone.is_some())
    };
    let bounds: usize = scene.joints.iter().map(of_joint).sum();
    scene.joints.len().max(bounds.div_ceil(BOUNDS_PER_JOINT))
}

/// The definition of a joint that was checked.
pub(super) fn definition(doc: &JointDoc, bodies: [BodyHandle; 2]) -> JointDef {
    let frame = |frame: &FrameDoc| {
        let turn = rotation::rotation(&frame.rotation).unwrap_or(Rotation::IDENTITY);
        Pose::new(Vec3::from(frame.position), turn)
    };
    let frames = [frame(&doc.frames[0]), frame(&doc.frames[1])];
    let mut def = match doc.kind {
        JointKindDoc::Ball => JointDef::ball(bodies, frames),
        JointKindDoc::Hinge => JointDef::hinge(bodies, frames),
        JointKindDoc::Slider => JointDef::slider(bodies, frames),
        JointKindDoc::Fixed => JointDef::fixed(bodies, frames),
        JointKindDoc::Distance => {
            let points = [frames[0].position, frames[1].position];
            JointDef::distance(bodies, points, 0.0, f32::INFINITY)
        }
        JointKindDoc::Wheel => {
            let mut def = JointDef::hinge(bodies, frames);
            def.axes[axis::Z] = Axis::FREE;
            def
        }
        JointKindDoc::SixAxis => JointDef::six_axis(bodies, frames),
        JointKindDoc::Gear { ratio } => JointDef::gear(bodies, frames, ratio),
        JointKindDoc::Rack { ratio } => JointDef::rack(bodies, frames, ratio),
    };
    for (axis, (_, doc)) in def.axes.iter_mut().zip(doc.axes.list()) {
        if let Some(doc) = doc {
            *axis = self::axis(doc);
        }
    }
    def.cone = doc.cone;
    def.spring = doc.spring.map(spring);
    def.break_force = doc.break_force.unwrap_or(f32::INFINITY);
    def.break_torque = doc.break_torque.unwrap_or(f32::INFINITY);
    def.bodies_collide = doc.bodies_collide.unwrap_or(def.bodies_collide);
    def.user = doc.user;
    def
}

fn axis(doc: &AxisDoc) -> Axis {
    Axis {
        motion: match doc.motion {
            MotionDoc::Free => AxisMotion::Free,
            MotionDoc::Locked => AxisMotion::Locked,
            MotionDoc::Limited { lower, upper } => AxisMotion::Limited {
                lower: lower.unwrap_or(f32::NEG_INFINITY),
                upper: upper.unwrap_or(f32::INFINITY),
            },
        },
        limit_spring: doc.limit_spring.map(spring),
        drive: doc.drive.map(|drive| Drive {
            target: drive.target,
            velocity: drive.velocity,
            spring: drive.spring.map(spring),
            max_force: drive.max_force.unwrap_or(f32::INFINITY),
        }),
        friction: doc.friction,
    }
}

fn spring(doc: SpringDoc) -> Spring {
    match doc {
        SpringDoc::Frequency { hertz, damping_ratio } => Spring::Frequency { hertz, damping_ratio },
        SpringDoc::Stiffness { stiffness, damping } => Spring::Stiffness { stiffness, damping },
    }
}
