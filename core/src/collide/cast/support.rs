//! Convex shapes as support functions: how far they reach along a direction.
//!
//! Every convex shape is a *core* and a radius around it (a ball is a point, a capsule a segment). What needs
//! no more of a shape than its core (distance, overlap, shape casts, and rays at shapes without a closed form)
//! works for any shape that has an arm in [`support::Core`], where contacts of curved shapes have theirs, or here.

use super::frame::{Frame, length, widened};
use crate::collide::{Solid, support};
use glam::DVec3;

/// The radius of a ball inside a convex solid, metres; 0 for others.
pub(crate) fn inner_radius(solid: &Solid<'_>) -> f32 {
    Core::new(solid).map_or(0.0, |core| core.inner_radius() as f32)
}

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
    /// A shape drawn together towards a point inside by a factor.
    Scaled(support::Core<'a>, DVec3, f64),
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
            Kind::Scaled(core, middle, scale) => *middle + (core.support(direction) - *middle) * *scale,
        }
    }

    /// True for a shape that a turn about its z axis leaves as it is.
    pub fn is_round(&self) -> bool {
        match &self.kind {
            Kind::Shape(core) | Kind::Scaled(core, ..) => !matches!(core, support::Core::Hull(_)),
            Kind::Box(_) | Kind::Triangle(_) => false,
        }
    }

    /// The axis about which a round shape at a frame is round: none of a ball.
    pub fn axis_of(&self, frame: &Frame) -> DVec3 {
        match &self.kind {
            Kind::Shape(support::Core::Point) => DVec3::ZERO,
            _ => frame.turn(DVec3::Z),
        }
    }

    /// The middle of that ball.
    pub fn middle(&self) -> DVec3 {
        match &self.kind {
            Kind::Shape(core) => core.inner_ball().0,
            Kind::Scaled(_, middle, _) => *middle,
            Kind::Box(_) => DVec3::ZERO,
            Kind::Triangle([a, b, c]) => (*a + *b + *c) / 3.0,
        }
    }

    /// The radius of the greatest ball inside the shape, or of a fair one, metres.
    pub fn inner_radius(&self) -> f64 {
        self.radius
            + match &self.kind {
                Kind::Shape(core) => core.inner_ball().1,
                Kind::Box(half) => lesser(half.x, lesser(half.y, half.z)),
                Kind::Triangle(_) => 0.0,
                Kind::Scaled(core, _, scale) => core.inner_ball().1 * scale,
            }
    }

    /// By how much the shape's farthest ends are shorter when all of the inner radius is taken off, metres.
    pub fn ends(&self) -> f64 {
        self.radius
            + match &self.kind {
                Kind::Shape(support::Core::Cylinder { .. }) => self.inner_radius() * libm::sqrt(2.0),
                // A segment and a point lose nothing but their radius.
                Kind::Shape(core) if core.inner_ball().1 > 0.0 => core.outer_radius(),
                Kind::Shape(_) => 0.0,
                Kind::Box(_) => self.inner_radius() * libm::sqrt(3.0),
                Kind::Triangle(_) | Kind::Scaled(..) => 0.0,
            }
    }

    /// What is left of the shape when a skin is taken off, `share` of the inner radius thick. Of a hull that is
    /// much longer than wide its ends lose more.
    pub fn eroded(&self, share: f64) -> Self {
        let skin = share * self.inner_radius();
        match &self.kind {
            Kind::Box(half) => Self { kind: Kind::Box(*half - DVec3::splat(skin)), ..*self },
            Kind::Shape(core) if skin > self.radius => {
                let (middle, inner) = core.inner_ball();
                let scale = if inner > 0.0 { 1.0 - (skin - self.radius) / inner } else { 1.0 };
                let kind = match core.thinned(skin - self.radius) {
                    Some(thinner) => Kind::Shape(thinner),
                    None => Kind::Scaled(*core, middle, scale),
                };
                Self { kind, radius: 0.0 }
            }
            Kind::Shape(_) => Self { radius: self.radius - skin, ..*self },
            Kind::Triangle(_) | Kind::Scaled(..) => *self,
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

fn lesser(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
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
