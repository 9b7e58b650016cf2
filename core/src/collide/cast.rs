//! Rays, shapes that move along a line, and how near shapes are: pure math of two shapes, in double precision.
//!
//! ```text
//! support.rs   convex shapes as support functions           contacts share it
//! gjk.rs       distance of two convex sets
//! ray.rs       closed forms for rays, triangles of meshes
//! axial.rs     those for cylinders and cones
//! grid.rs      cells of a height field along a way, and around a box
//! children.rs  compounds: boxes of their children, and their children as what moves
//! sweep.rs     a convex shape that moves against any shape   also rays at shapes without a closed form
//! nearest.rs   distance and overlap of a convex shape and any shape
//! impact.rs    a convex shape that moves and turns against any shape
//! ```
//! Concave shapes have an arm beside that of meshes in the last four.

mod axial;
pub(crate) mod children;
pub(crate) mod course;
pub(crate) mod frame;
pub(crate) mod gjk;
mod grid;
pub(crate) mod impact;
pub(crate) mod nearest;
pub(crate) mod ray;
pub(crate) mod support;
pub(crate) mod sweep;

use frame::Frame;
use glam::DVec3;

/// Where something that moves meets a shape, in the shape's frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Contact {
    /// How far it came, metres.
    pub distance: f64,
    /// Unit normal of the shape, against the motion.
    pub normal: DVec3,
    /// The point of contact.
    pub point: DVec3,
    /// Part of a concave shape; 0 else.
    pub child: u32,
}

impl Contact {
    /// The same in the frame in which its frame stands so.
    fn outside(self, frame: &Frame) -> Self {
        Self { normal: frame.turn(self.normal), point: frame.transform(self.point), ..self }
    }
}

/// How near a convex shape is to another shape, in that shape's frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Nearness {
    /// Metres; 0 when they overlap or touch.
    pub distance: f64,
    /// Unit vector from the other shape to this one; zero when they overlap.
    pub normal: DVec3,
    /// The nearest point of the other shape.
    pub point: DVec3,
    /// Part of a concave shape; 0 else.
    pub child: u32,
}

impl Nearness {
    /// The same in the frame in which its frame stands so.
    fn outside(self, frame: &Frame) -> Self {
        Self { normal: frame.turn(self.normal), point: frame.transform(self.point), ..self }
    }
}
