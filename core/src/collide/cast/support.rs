//! Convex shapes as support functions: how far they reach along a direction.
//!
//! Every convex shape is a *core* and a radius around it (a ball is a point, a capsule a segment). What needs
//! no more of a shape than its core (distance, overlap, shape casts, and rays at shapes without a closed form)
//! works for any shape that has an arm in [`Core::new`] and in [`Core::support`].

use super::frame::{Frame, length, widened};
use crate::collide::Solid;
use crate::math::Vec3;
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
    /// The origin.
    Point,
    /// From minus to plus this along z.
    Segment(f64),
    /// Half extents.
    Box(DVec3),
    /// The hull of some points.
    Points(&'a [Vec3]),
    /// The hull of three points.
    Triangle([DVec3; 3]),
    /// About z, from minus to plus the first along it; then the radius.
    Cylinder(f64, f64),
    /// Apex at the first on z, base at minus that; then the base's radius.
    Cone(f64, f64),
}

impl<'a> Core<'a> {
    /// The origin alone.
    pub const POINT: Core<'static> = Core { kind: Kind::Point, radius: 0.0 };

    /// A triangle without thickness.
    pub fn triangle(corners: [DVec3; 3]) -> Self {
        Self { kind: Kind::Triangle(corners), radius: 0.0 }
    }

    /// The core of a solid; `None` when it is not convex, or has no end.
    pub fn new(solid: &Solid<'a>) -> Option<Self> {
        Some(match *solid {
            Solid::Sphere { radius } => Self { kind: Kind::Point, radius: f64::from(radius) },
            Solid::Capsule { half_height, radius } => {
                Self { kind: Kind::Segment(f64::from(half_height)), radius: f64::from(radius) }
            }
            Solid::Box { half_extents } => Self { kind: Kind::Box(widened(half_extents)), radius: 0.0 },
            Solid::Hull(hull) => Self { kind: Kind::Points(hull.vertices), radius: 0.0 },
            Solid::Cylinder { half_height, radius } => {
                Self { kind: Kind::Cylinder(f64::from(half_height), f64::from(radius)), radius: 0.0 }
            }
            Solid::Cone { half_height, radius } => {
                Self { kind: Kind::Cone(f64::from(half_height), f64::from(radius)), radius: 0.0 }
            }
            Solid::RoundedHull { hull, radius } => {
                Self { kind: Kind::Points(hull.vertices), radius: f64::from(radius) }
            }
            Solid::HalfSpace | Solid::Mesh(_) | Solid::HeightField(_) | Solid::Compound(_) => return None,
        })
    }

    /// A point of the core that is farthest along `direction`, which need not be a unit vector.
    #[inline]
    pub fn support(&self, direction: DVec3) -> DVec3 {
        let side = |x: f64, d: f64| if d < 0.0 { -x } else { x };
        match self.kind {
            Kind::Point => DVec3::ZERO,
            Kind::Segment(half) => DVec3::new(0.0, 0.0, side(half, direction.z)),
            Kind::Box(half) => {
                DVec3::new(side(half.x, direction.x), side(half.y, direction.y), side(half.z, direction.z))
            }
            Kind::Points(points) => farthest(points.iter().map(|&point| widened(point)), direction),
            Kind::Triangle(corners) => farthest(corners.into_iter(), direction),
            Kind::Cylinder(half, radius) => rim(direction, radius, side(half, direction.z)),
            Kind::Cone(half, radius) => {
                let across = libm::sqrt(direction.x * direction.x + direction.y * direction.y);
                if 2.0 * half * direction.z >= radius * across {
                    DVec3::new(0.0, 0.0, half)
                } else {
                    rim(direction, radius, -half)
                }
            }
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

/// The point of a circle about z at a height that is farthest along `d`; its center along the axis.
fn rim(d: DVec3, radius: f64, z: f64) -> DVec3 {
    let across = libm::sqrt(d.x * d.x + d.y * d.y);
    if across <= 1.0e-12 * d.z.abs() {
        return DVec3::new(0.0, 0.0, z);
    }
    DVec3::new(radius * (d.x / across), radius * (d.y / across), z)
}

/// The first of the points that lie farthest along a direction.
fn farthest(points: impl Iterator<Item = DVec3>, direction: DVec3) -> DVec3 {
    let (mut best, mut best_height) = (DVec3::ZERO, f64::NEG_INFINITY);
    for point in points {
        let height = point.dot(direction);
        if height > best_height {
            (best, best_height) = (point, height);
        }
    }
    best
}
