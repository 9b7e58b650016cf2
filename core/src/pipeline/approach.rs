//! Two shapes of which one is fast: where they will touch in the coming step, and not where they are nearest now.
//!
//! Slow shapes have contacts where they are nearest, along the normal there, up to the distance that they come in
//! the step. For a fast one that is the wrong place: a ball that comes along beside a wall is nearest to its
//! corner, and would be held by a plane through that corner across its way. So a pair that passes by more than a
//! share of its thickness is cast along its motion (`collide/cast/sweep.rs`): what it misses makes no contact, and
//! what it hits makes the contacts that it has there, farther off by the way until then.
//!
//! A shape that turns meanwhile has no place from which contacts could be told in advance. It has those of
//! where it stands, and is stopped when it comes (`continuous.rs`).

use crate::collide::cast::children::Parts;
use crate::collide::cast::frame::{Frame, length, narrowed, widened};
use crate::collide::cast::sweep::{self, Moving};
use crate::collide::{self, Manifold, Manifolds, Solid};
use crate::config::SPECULATIVE_DISTANCE;
use crate::math::{Pose, Vec3, max_each, min, sqrt};
use crate::pipeline::continuous::{FAST_SHARE, WAY_FLOOR, has_joints, inner_radius};
use crate::pipeline::meeting::{Meeting, Scene};
use crate::shape::{GEOMETRY_SPHERE, ShapeRow};
use crate::state::AssetTables;
use glam::DVec3;

/// Turn in a step, radians, up to which shapes are taken to come as they stand.
const TURN_MAX: f32 = 0.25;
/// Sum of squares of turns that is below the square of that one, however it is rounded.
const TURN_SURE: f32 = 0.99 * TURN_MAX * TURN_MAX;

/// The share of its reach by which a shape that touches may move on in a step and have points farther ahead.
const SLENDER_SHARE: f32 = 0.25;

/// How far behind the plane of a contact shapes may be that do not touch, metres: rounding.
const PASS_DEPTH: f32 = 1.0e-5;

/// How two shapes come to each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Approach {
    /// So slowly that they touch where they are nearest now.
    Slow,
    /// Fast, and as they stand.
    Straight,
    /// Turning by much.
    Turning,
}

impl Approach {
    /// How the shapes in two slots come to each other in a step of `dt` seconds.
    #[inline(always)]
    pub fn new(
        scene: &Scene<'_>,
        meeting: &Meeting,
        (slots, shapes, assets, dt): ([u32; 2], (&ShapeRow, &ShapeRow), &AssetTables<'_>, f32),
    ) -> Self {
        // Most pairs: no more than two comparisons.
        if (meeting.turns <= TURN_MAX * TURN_MAX && meeting.way <= WAY_FLOOR)
            || (meeting.turns <= TURN_SURE && !passes_by(meeting.way, shapes, assets))
        {
            return Self::Slow;
        }
        Self::of_moving(scene, meeting, (slots, assets, dt))
    }

    #[inline(never)]
    fn of_moving(
        scene: &Scene<'_>,
        meeting: &Meeting,
        (slots, assets, dt): ([u32; 2], &AssetTables<'_>, f32),
    ) -> Self {
        // What has joints keeps its contacts: it is hardly ever stopped.
        if slots.iter().any(|&slot| has_joints(scene.first_joints, scene.shapes[slot as usize].body)) {
            return Self::Slow;
        }
        // A ball about its body's center looks the same when it turns.
        let turn = |slot: u32| {
            let is_ball = scene.shapes[slot as usize].kind == GEOMETRY_SPHERE;
            let shows = !is_ball || scene.frame(slot).position != Vec3::ZERO;
            let turn = scene.motion(slot).angular * dt;
            if shows { turn.dot(turn) } else { 0.0 }
        };
        if turn(slots[0]) + turn(slots[1]) > TURN_MAX * TURN_MAX {
            return Self::Turning;
        }
        let shapes = (&scene.shapes[slots[0] as usize], &scene.shapes[slots[1] as usize]);
        if passes_by(meeting.way, shapes, assets) { Self::Straight } else { Self::Slow }
    }
}

/// True when two shapes come by more than a share of the thinner one's thickness.
#[inline(always)]
fn passes_by(way: f32, (a, b): (&ShapeRow, &ShapeRow), assets: &AssetTables<'_>) -> bool {
    let thickness = |shape: &ShapeRow| {
        if shape.kind == GEOMETRY_SPHERE {
            shape.size[0]
        } else if shape.is_surface() {
            f32::MAX
        } else {
            inner_radius(shape, assets)
        }
    };
    way > FAST_SHARE * min(thickness(a), thickness(b))
}

/// The contacts of two shapes that are not slow, as they stand now or as they will when they touch. Returns how
/// far B moves against A until then, in A's frame, metres: contacts are that much farther off. `motion` is how
/// B moves in the whole step.
pub(crate) fn collide(
    meeting: &Meeting,
    solids: (&Solid<'_>, &Solid<'_>),
    (approach, motion): (Approach, Vec3),
    found: &mut Manifolds,
) -> Vec3 {
    let pose = Pose::new(meeting.b_in_a.position, meeting.b_in_a.rotation.renormalized());
    if approach == Approach::Turning {
        collide::collide(solids.0, solids.1, &pose, SPECULATIVE_DISTANCE, found);
        return Vec3::ZERO;
    }
    let Some(way) = way_to_touch(solids, &pose, motion) else {
        collide::collide(solids.0, solids.1, &pose, SPECULATIVE_DISTANCE, found);
        drop_passed(motion, found);
        return Vec3::ZERO;
    };
    let touch = Pose::new(pose.position + way, pose.rotation);
    collide::collide(solids.0, solids.1, &touch, SPECULATIVE_DISTANCE, found);
    if found.len() == 1 && is_plain(solids.0) && is_plain(solids.1) {
        let (left, reach) = (crate::math::length(motion - way), thinner_reach(solids));
        // One plane, which is the right one, since they touch there. Of a rod that falls over one end lies on the
        // floor and the other one comes, fast for its thickness alone: it needs a point, too. What is fast for
        // its length slides so far that its points are elsewhere by then.
        if left < SLENDER_SHARE * reach {
            let ahead = left + sqrt(meeting.turns) * reach;
            found.clear();
            collide::collide(solids.0, solids.1, &touch, SPECULATIVE_DISTANCE + ahead, found);
        }
    }
    way
}

/// True for a solid that has one plane of contact with another such.
fn is_plain(solid: &Solid<'_>) -> bool {
    !matches!(solid, Solid::Mesh(_) | Solid::HeightField(_) | Solid::Compound(_))
}

/// How far points of the smaller of two solids are from the origin of its frame, metres.
fn thinner_reach(solids: (&Solid<'_>, &Solid<'_>)) -> f32 {
    let reach = |solid: &Solid<'_>| {
        let bounds = collide::bounds::aabb(solid, &Pose::IDENTITY);
        crate::math::length(max_each(bounds.min.abs(), bounds.max.abs()))
    };
    min(reach(solids.0), reach(solids.1))
}

/// Of shapes that do not touch on their way, drops the contacts whose plane is crossed all the same: beside a
/// corner.
fn drop_passed(motion: Vec3, found: &mut Manifolds) {
    let is_passed = |manifold: &Manifold| {
        let nearer = manifold.normal.dot(motion);
        manifold.points.iter().any(|point| point.separation + nearer < -PASS_DEPTH)
    };
    let mut kept = 0;
    for i in 0..found.len() {
        if !is_passed(&found[i]) {
            found.swap(kept, i);
            kept += 1;
        }
    }
    found.truncate(kept);
}

/// How far B moves against A until they touch; `None` when they do not in this step.
fn way_to_touch((a, b): (&Solid<'_>, &Solid<'_>), b_in_a: &Pose, motion: Vec3) -> Option<Vec3> {
    let (frame, way) = (Frame::of(b_in_a), widened(motion));
    let contact = match Parts::new(b) {
        Some(parts) => first_touch(a, &parts, (&frame, way)),
        // What has no inside is what the other one moves against.
        None => Parts::new(a).and_then(|parts| {
            first_touch(b, &parts, (&frame.relative(&Frame::IDENTITY), -frame.unturn(way)))
        }),
    };
    contact.map(|share| narrowed(way * share))
}

/// The share of a motion after which the parts of a solid touch another one.
fn first_touch(solid: &Solid<'_>, parts: &Parts<'_>, (frame, way): (&Frame, DVec3)) -> Option<f64> {
    let span = length(way);
    let direction = if span > 0.0 { way / span } else { return None };
    let mut best: Option<f64> = None;
    for (core, frame) in parts.at(frame) {
        let within = best.unwrap_or(span);
        let found = sweep::cast(solid, &Moving { core, frame, direction, length: span }, within);
        if let Some(contact) = found.filter(|contact| contact.distance < within || best.is_none()) {
            best = Some(contact.distance);
        }
    }
    best.map(|distance| distance / span)
}
