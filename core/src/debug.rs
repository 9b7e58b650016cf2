//! Debug drawing: what a world holds as lines, points and text, for any renderer.
//!
//! The world is drawn relative to a place that the caller gives, usually the camera's: near it coordinates are
//! small, so that f32 shows a millimetre at 10,000 km from the origin. Nothing is allocated, and nothing is
//! changed: a world that is drawn goes the same way as one that is not.
//!
//! `debug/wireframe.rs` has the lines of each geometry, `world/debug.rs` the layers.

pub(crate) mod wireframe;

use crate::math::Vec3;

/// A color: red, green, blue and opacity, a byte each, red in the highest.
pub type Color = u32;

/// Where debug drawing goes. Coordinates are metres from the origin of the drawing, along the world's axes.
pub trait DebugDraw {
    /// Draws a line.
    fn line(&mut self, from: Vec3, to: Vec3, color: Color);

    /// Draws a point, usually as a dot of some pixels.
    fn point(&mut self, at: Vec3, color: Color);

    /// Writes text that starts at a place.
    fn text(&mut self, at: Vec3, text: &str, color: Color) {
        let _ = (at, text, color);
    }
}

/// A set of things to draw.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DebugLayers(pub u32);

impl DebugLayers {
    /// Nothing.
    pub const NONE: Self = Self(0);
    /// Wireframes of the shapes, colored by the kind of their body.
    pub const SHAPES: Self = Self(1);
    /// The broadphase's boxes, as of the last step.
    pub const FAT_BOXES: Self = Self(2);
    /// Points of contact and their normals, at the poses now.
    pub const CONTACTS: Self = Self(4);
    /// Impulses of the last step's contacts: normal ones along the normal, friction across.
    pub const IMPULSES: Self = Self(8);
    /// Centers of mass.
    pub const CENTERS: Self = Self(16);
    /// Axes of the bodies' frames at their origins: x red, y green, z blue.
    pub const AXES: Self = Self(32);
    /// Slots and masses of bodies, and impulses of contacts, as text beside what is drawn.
    pub const LABELS: Self = Self(64);
    /// Joints that are not broken: the axes of both frames, a line from each center of mass to its frame, and one
    /// between the frames' origins, which is seen where a joint has room or gives.
    pub const JOINTS: Self = Self(128);
    /// Limits of the same joints: the range of every limited turn as an arc with its ends and a hand at the turn as
    /// it is, that of every limited shift or distance as a line, and cones by their rim. Of a range without an end
    /// half a turn or the drawing's reach is drawn.
    pub const JOINT_LIMITS: Self = Self(256);
    /// Everything.
    pub const ALL: Self = Self(511);

    /// Things of both.
    pub const fn and(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// True when all of the other set is in this one.
    pub const fn has(self, other: Self) -> bool {
        self.0 & other.0 == other.0
    }
}

/// What is drawn, and how large.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DebugOptions {
    /// What is drawn.
    pub layers: DebugLayers,
    /// How far around the origin of the drawing, metres: shapes, triangles and bodies beyond are left out.
    pub reach: f32,
    /// Length of normals and axes, metres.
    pub axis_length: f32,
    /// Length of an impulse of 1 N s, metres.
    pub impulse_scale: f32,
}

impl Default for DebugOptions {
    /// Shapes and contacts up to 1 km; axes of 0.25 m, impulses of 1 cm for each N s.
    fn default() -> Self {
        Self {
            layers: DebugLayers::SHAPES.and(DebugLayers::CONTACTS),
            reach: 1.0e3,
            axis_length: 0.25,
            impulse_scale: 0.01,
        }
    }
}

/// The colors of what is drawn.
pub mod colors {
    use super::Color;

    /// Shapes of static bodies: grey.
    pub const STATIC: Color = 0x9aa0a6ff;
    /// Shapes of kinematic bodies: blue.
    pub const KINEMATIC: Color = 0x4f8fefff;
    /// Shapes of dynamic bodies: orange.
    pub const DYNAMIC: Color = 0xf0a030ff;
    /// Shapes of bodies that were quarantined: magenta.
    pub const QUARANTINED: Color = 0xff00ffff;
    /// Sensors, of whatever body: green.
    pub const SENSOR: Color = 0x40d060ff;
    /// The broadphase's boxes: dim green.
    pub const FAT_BOX: Color = 0x40805080;
    /// Points of contact that are apart: white.
    pub const CONTACT: Color = 0xffffffff;
    /// Points of contact that overlap: red.
    pub const OVERLAP: Color = 0xff4040ff;
    /// Normals: light grey.
    pub const NORMAL: Color = 0xd0d0d0ff;
    /// Normal impulses: yellow.
    pub const IMPULSE: Color = 0xffff00ff;
    /// Friction impulses: cyan.
    pub const FRICTION: Color = 0x00ffffff;
    /// Joints: violet.
    pub const JOINT: Color = 0xb070ffff;
    /// Gaps between the frames of joints: pink.
    pub const JOINT_GAP: Color = 0xff80c0ff;
    /// Limits of joints: dark yellow.
    pub const JOINT_LIMIT: Color = 0xc0a020ff;
    /// Centers of mass: yellow green.
    pub const CENTER: Color = 0xc0ff40ff;
    /// The x, y and z axes.
    pub const AXES: [Color; 3] = [0xff0000ff, 0x00ff00ff, 0x0000ffff];
}
