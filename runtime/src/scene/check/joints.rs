//! The rules of joints: their bodies exist, and their numbers are those that the engine takes.

use super::{Checked, LENGTH_MAX, range, turned, vector};
use crate::scene::error::SceneError;
use crate::scene::format::*;
use crate::scene::joints::{index_of, names};
use crate::scene::place::Place;
use std::collections::{BTreeMap, BTreeSet};

/// Greatest coordinate, metres or radians, and greatest velocity of a drive.
const COORDINATE_MAX: f32 = 1.0e5;
/// Greatest stiffness, damping, force of friction, and of what bounds a drive or breaks a joint.
const EFFORT_MAX: f32 = 1.0e12;
/// Range of the ratios of gears and racks, but for the sign.
const RATIO_MAX: f32 = 1.0e4;
const RATIO_MIN: f32 = 1.0 / RATIO_MAX;
/// Range of cones, radians.
const CONE: [f32; 2] = [0.01, 3.1];
/// Least force or torque that breaks a joint.
const BREAK_MIN: f32 = 1.0e-12;

/// Refuses names of bodies that are empty or used twice.
pub(super) fn body_names(scene: &Scene) -> Checked {
    let root = Place::Root;
    let bodies = root.key("bodies");
    let mut known = BTreeSet::new();
    for (index, body) in scene.bodies.iter().enumerate() {
        let Some(name) = &body.name else { continue };
        let body = bodies.index(index);
        if name.is_empty() {
            return Err(SceneError::invalid(body.key("name"), "found none", "a text that is not empty"));
        }
        if !known.insert(name) {
            let found = format!("the name {name:?} is used twice");
            return Err(SceneError::invalid(body.key("name"), found, "each name once"));
        }
    }
    Ok(())
}

pub(super) fn check(scene: &Scene) -> Checked {
    let root = Place::Root;
    let list = root.key("joints");
    let names = names(scene);
    for (index, doc) in scene.joints.iter().enumerate() {
        let place = list.index(index);
        bodies(place, doc, scene, &names)?;
        joint(place, doc)?;
    }
    Ok(())
}

fn bodies(place: Place<'_>, doc: &JointDoc, scene: &Scene, names: &BTreeMap<&str, usize>) -> Checked {
    let place = place.key("bodies");
    let count = scene.bodies.len();
    let mut found = [0; 2];
    for (index, (body, found)) in doc.bodies.iter().zip(&mut found).enumerate() {
        let Some(known) = index_of(body, names, count) else {
            let (found, expected) = match body {
                BodyRefDoc::Index(index) => {
                    (format!("found {index}"), format!("an index below {count}, the number of bodies"))
                }
                BodyRefDoc::Name(name) => {
                    (format!("no body is named {name:?}"), "the name of a body".to_string())
                }
            };
            return Err(SceneError::invalid(place.index(index), found, expected));
        };
        *found = known;
    }
    if found[0] == found[1] {
        let text = format!("found body {} twice", found[0]);
        return Err(SceneError::invalid(place, text, "two bodies"));
    }
    Ok(())
}

fn joint(place: Place<'_>, doc: &JointDoc) -> Checked {
    let kind = place.key("kind");
    if let JointKindDoc::Gear { ratio } | JointKindDoc::Rack { ratio } = doc.kind {
        let name = if let JointKindDoc::Gear { .. } = doc.kind { "gear" } else { "rack" };
        let size = ratio.abs();
        if !(RATIO_MIN..=RATIO_MAX).contains(&size) {
            let expected = format!("a number in {RATIO_MIN:?}..={RATIO_MAX:?}, or its negative");
            return Err(SceneError::invalid(kind.key(name).key("ratio"), format!("found {ratio}"), expected));
        }
    }
    let frames = place.key("frames");
    for (index, frame) in doc.frames.iter().enumerate() {
        let place = frames.index(index);
        vector(place.key("position"), &frame.position, LENGTH_MAX)?;
        turned(place.key("rotation"), &frame.rotation)?;
    }
    let used = match doc.kind {
        JointKindDoc::Gear { .. } | JointKindDoc::Rack { .. } => 0,
        JointKindDoc::Distance => 1,
        _ => 6,
    };
    let axes = place.key("axes");
    for (index, (name, axis)) in doc.axes.list().into_iter().enumerate() {
        let Some(axis) = axis else { continue };
        if index >= used {
            let expected = "an axis that the kind has: a distance has `x`, gears and racks have none";
            return Err(SceneError::invalid(axes.key(name), format!("found `{name}`"), expected));
        }
        self::axis(axes.key(name), axis)?;
    }
    if let Some(cone) = doc.cone {
        if used < 6 {
            let expected = "no cone on a distance, a gear or a rack";
            return Err(SceneError::invalid(place.key("cone"), format!("found {cone}"), expected));
        }
        range(place.key("cone"), cone, CONE[0], CONE[1])?;
    }
    if let Some(spring) = &doc.spring {
        self::spring(place.key("spring"), spring)?;
    }
    for (name, value) in [("break_force", doc.break_force), ("break_torque", doc.break_torque)] {
        value.map_or(Ok(()), |x| range(place.key(name), x, BREAK_MIN, EFFORT_MAX))?;
    }
    Ok(())
}

fn axis(place: Place<'_>, doc: &AxisDoc) -> Checked {
    if let MotionDoc::Limited { lower, upper } = doc.motion {
        let motion = place.key("motion");
        let place = motion.key("limited");
        for (name, value) in [("lower", lower), ("upper", upper)] {
            value.map_or(Ok(()), |x| range(place.key(name), x, -COORDINATE_MAX, COORDINATE_MAX))?;
        }
        if let (Some(lower), Some(upper)) = (lower, upper)
            && lower > upper
        {
            let expected = format!("at least {lower:?}, the lower one");
            return Err(SceneError::invalid(place.key("upper"), format!("found {upper}"), expected));
        }
    }
    if let Some(spring) = &doc.limit_spring {
        self::spring(place.key("limit_spring"), spring)?;
    }
    if let Some(drive) = &doc.drive {
        let place = place.key("drive");
        range(place.key("target"), drive.target, -COORDINATE_MAX, COORDINATE_MAX)?;
        range(place.key("velocity"), drive.velocity, -COORDINATE_MAX, COORDINATE_MAX)?;
        if let Some(spring) = &drive.spring {
            self::spring(place.key("spring"), spring)?;
        }
        drive.max_force.map_or(Ok(()), |x| range(place.key("max_force"), x, 0.0, EFFORT_MAX))?;
    }
    range(place.key("friction"), doc.friction, 0.0, EFFORT_MAX)
}

fn spring(place: Place<'_>, doc: &SpringDoc) -> Checked {
    match *doc {
        SpringDoc::Frequency { hertz, damping_ratio } => {
            let place = place.key("frequency");
            range(place.key("hertz"), hertz, 0.0, 1.0e5)?;
            range(place.key("damping_ratio"), damping_ratio, 0.0, 1.0e3)
        }
        SpringDoc::Stiffness { stiffness, damping } => {
            let place = place.key("stiffness");
            range(place.key("stiffness"), stiffness, 0.0, EFFORT_MAX)?;
            range(place.key("damping"), damping, 0.0, EFFORT_MAX)
        }
    }
}
