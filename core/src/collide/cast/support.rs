//! Convex shapes as support functions: how far they reach along a direction.
//!
//! Every convex shape is a *core* and a radius around it (a ball is a point, a capsule a segment). What needs
//! no more of a shape than its core (distance, overlap, shape casts, and rays at shapes without a closed form)
//! works for any shape that has an arm in [`support::Core`], where contacts of curved shapes have theirs, or here.

use super::frame::{Frame, length, widened};
use crate::collide::{Solid, support};
use glam::DVec3;

/// A convex set in its own frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Core<'a> {
    kind: Kind<'a>,
    /// The shape is all points within this distance of the core, metres.
    pub radius: f64,
}

#[derive(Clone, Copy, Debug)]
enum Kind<'a> {
    /// As for contacts.
    Shape(support::Core<'a>),
    /// Half extents.
    Box(DVec3),
    /// The hull of three points.
    Triangle([DVec3; 3]),
}

impl<'a> Core<'a> {
    /// The origin alone.
    pub const POINT: Core<'static> = Core { kind: Kind::Shape(support::Core::Point), radius: 0.0 };

    /// A triangle without thickness.
    pub fn triangle(corners: [DVec3; 3]) -> Self {
        Self { kind: Kind::Triangle(corners), radius: 0.0 }
    }

    /// The core of a solid; `None` when it is not convex, or has no end.
    pub fn new(solid: &Solid<'a>) -> Option<Self> {
        let (kind, radius) = match *solid {
            Solid::Box { half_extents } => (Kind::Box(widened(half_extents)), 0.0),
            _ => {
                let (core, radius) = support::Core::new(solid)?;
                (Kind::Shape(core), radius)
            }
        };
        Some(Self { kind, radius })
    }

    /// A point of the core that is farthest along `direction`, which need not be a unit vector.
    #[inline]
    pub fn support(&self, direction: DVec3) -> DVec3 {
        let side = |x: f64, d: f64| if d < 0.0 { -x } else { x };
        match &self.kind {
            Kind::Shape(core) => core.support(direction),
            Kind::Box(half) => {
                DVec3::new(side(half.x, direction.x), side(half.y, direction.y), side(half.z, direction.z))
            }
            Kind::Triangle(corners) => farthest(corners, direction),
        }
    }

    /// The least and the greatest coordinates of the shape at a frame, in the outer frame.
    pub fn bounds(&self, frame: &Frame) -> (DVec3, DVec3) {
        let reach = |axis: DVec3| frame.transform(self.support(frame.unturn(axis))).dot(axis) + self.radius;
        let low = DVec3::new(reach(DVec3::NEG_X), reach(DVec3::NEG_Y), reach(DVec3::NEG_Z));
        (-low, DVec3::new(reach(DVec3::X), reach(DVec3::Y), reach(DVec3::Z)))
    }

    /// About the shape's greatest length, metres: what rounding is a fraction of.
    pub fn extent(&self) -> f64 {
        let (low, high) = self.bounds(&Frame::IDENTITY);
        length(high - low)
    }
}

/// The first of the points that lie farthest along a direction.
fn farthest(points: &[DVec3; 3], direction: DVec3) -> DVec3 {
    let (mut best, mut best_height) = (DVec3::ZERO, f64::NEG_INFINITY);
    for &point in points {
        let height = point.dot(direction);
        if height > best_height {
            (best, best_height) = (point, height);
        }
    }
    best
}
