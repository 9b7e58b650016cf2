//! Documents of joints.
//!
//! They say what [`JointDef`](cellstep_core::JointDef) says, with the same meanings and units. A kind chooses the
//! axes; an axis that a document names takes the place of the kind's.

use super::{is_default, is_zero, is_zero_each};
use crate::scene::format::RotationDoc;
use serde::de::{Deserializer, Error, Visitor};
use serde::ser::Serializer;
use serde::{Deserialize, Serialize};
use std::fmt;

/// Most joints of a document: refused by the reader before the rest is read.
pub const JOINTS_MAX: usize = 1 << 18;

/// A joint of two bodies, A and B.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a joint object")]
pub struct JointDoc {
    /// What it lets free.
    pub kind: JointKindDoc,
    /// A and B: two bodies of the scene.
    pub bodies: [BodyRefDoc; 2],
    /// The joint's frame on each body, in the body's frame.
    #[serde(default, skip_serializing_if = "is_default")]
    pub frames: [FrameDoc; 2],
    /// Axes that are otherwise than the kind has them.
    #[serde(default, skip_serializing_if = "is_default")]
    pub axes: AxesDoc,
    /// Greatest angle between the x axes of the frames, radians; `None` for any.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cone: Option<f32>,
    /// How locked axes, gears and racks give; `None` is rigid.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub spring: Option<SpringDoc>,
    /// Force at which it breaks, N, greater than 0; `None` for never.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub break_force: Option<f32>,
    /// Torque at which it breaks, N m, greater than 0; `None` for never.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub break_torque: Option<f32>,
    /// Whether shapes of the two bodies meet all the same; `None`: only for distances, gears and racks.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bodies_collide: Option<bool>,
    /// The game's own number.
    #[serde(default, skip_serializing_if = "is_default")]
    pub user: u64,
}

impl JointDoc {
    /// A joint of a kind whose frames are those of the bodies.
    pub fn new(kind: JointKindDoc, bodies: [BodyRefDoc; 2]) -> Self {
        Self {
            kind,
            bodies,
            frames: <[FrameDoc; 2]>::default(),
            axes: AxesDoc::default(),
            cone: None,
            spring: None,
            break_force: None,
            break_torque: None,
            bodies_collide: None,
            user: 0,
        }
    }
}

/// What a joint is, by the constructors of [`JointDef`](cellstep_core::JointDef).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields, expecting = "a kind of joint, as \"hinge\"")]
pub enum JointKindDoc {
    /// A point of one body stays on a point of the other.
    Ball,
    /// B turns about the x axis of the frames.
    Hinge,
    /// B slides along the x axis of A's frame.
    Slider,
    /// The two bodies move as one.
    Fixed,
    /// About the distance of the frames' origins, which is axis `x`; limits make it a rope or a rod.
    Distance,
    /// A wheel B on a chassis A: free along z, spins about x. The suspension is a drive on axis `z`, steering is
    /// axis `turn_z`.
    Wheel,
    /// All axes free.
    SixAxis,
    /// Two wheels that mesh, on axes of their own joints.
    Gear {
        /// Teeth of B over teeth of A; negative for gears that mesh inside.
        ratio: f32,
    },
    /// A pinion A and a rack B, on axes of their own joints.
    Rack {
        /// Metres for each radian: the radius of the pinion.
        ratio: f32,
    },
}

/// A body of the scene: its place in the list, from 0, or its name.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum BodyRefDoc {
    /// Index into [`Scene::bodies`](super::Scene::bodies).
    Index(u32),
    /// [`BodyDoc::name`](super::BodyDoc::name).
    Name(String),
}

impl Serialize for BodyRefDoc {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Index(index) => serializer.serialize_u32(*index),
            Self::Name(name) => serializer.serialize_str(name),
        }
    }
}

// By hand: serde's way of choosing between a number and a text loses the line of a mistake.
impl<'de> Deserialize<'de> for BodyRefDoc {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(BodyRef)
    }
}

struct BodyRef;

impl Visitor<'_> for BodyRef {
    type Value = BodyRefDoc;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("the index or the name of a body")
    }

    fn visit_u64<E: Error>(self, index: u64) -> Result<BodyRefDoc, E> {
        let index = u32::try_from(index);
        index.map(BodyRefDoc::Index).map_err(|_| E::custom("too large for the index of a body"))
    }

    fn visit_str<E: Error>(self, name: &str) -> Result<BodyRefDoc, E> {
        Ok(BodyRefDoc::Name(name.to_string()))
    }
}

/// A frame in a body.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, expecting = "an object of a frame")]
pub struct FrameDoc {
    /// Where it stands in the body's frame, metres.
    #[serde(default, skip_serializing_if = "is_zero_each")]
    pub position: [f32; 3],
    /// How it is turned in the body's frame.
    #[serde(default, skip_serializing_if = "is_default")]
    pub rotation: RotationDoc,
}

/// The axes of a joint that a document names.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, expecting = "an object of axes")]
pub struct AxesDoc {
    /// Shift along A's x axis, or the distance; metres.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub x: Option<AxisDoc>,
    /// Shift along A's y axis, metres.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub y: Option<AxisDoc>,
    /// Shift along A's z axis, metres.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub z: Option<AxisDoc>,
    /// Turn about B's x axis, radians.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub turn_x: Option<AxisDoc>,
    /// Turn about the axis between, radians.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub turn_y: Option<AxisDoc>,
    /// Turn about A's z axis, radians.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub turn_z: Option<AxisDoc>,
}

impl AxesDoc {
    /// Names and axes, by their index in [`JointDef::axes`](cellstep_core::JointDef::axes).
    pub fn list(&self) -> [(&'static str, Option<&AxisDoc>); 6] {
        [
            ("x", self.x.as_ref()),
            ("y", self.y.as_ref()),
            ("z", self.z.as_ref()),
            ("turn_x", self.turn_x.as_ref()),
            ("turn_y", self.turn_y.as_ref()),
            ("turn_z", self.turn_z.as_ref()),
        ]
    }

    /// The axis with this index, to be filled in.
    ///
    /// # Panics
    /// For an index above 5.
    pub fn at(&mut self, index: usize) -> &mut Option<AxisDoc> {
        let axes =
            [&mut self.x, &mut self.y, &mut self.z, &mut self.turn_x, &mut self.turn_y, &mut self.turn_z];
        axes.into_iter().nth(index).expect("a joint has six axes")
    }
}

/// One coordinate of a joint.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, expecting = "an object of an axis")]
pub struct AxisDoc {
    /// Its range.
    #[serde(default, skip_serializing_if = "is_default")]
    pub motion: MotionDoc,
    /// How a limit gives; `None` is hard.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub limit_spring: Option<SpringDoc>,
    /// What moves it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub drive: Option<DriveDoc>,
    /// Force or torque of dry friction, N or N m, not negative.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub friction: f32,
}

impl AxisDoc {
    /// Between two values.
    pub fn limited(lower: f32, upper: f32) -> Self {
        let motion = MotionDoc::Limited { lower: Some(lower), upper: Some(upper) };
        Self { motion, ..Self::default() }
    }

    /// Free, with a drive.
    pub fn driven(drive: DriveDoc) -> Self {
        Self { drive: Some(drive), ..Self::default() }
    }
}

/// How far a coordinate may go.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(
    rename_all = "snake_case",
    deny_unknown_fields,
    expecting = "a motion, as \"locked\" or {\"limited\": {\"lower\": -1, \"upper\": 1}}"
)]
pub enum MotionDoc {
    /// Anywhere.
    #[default]
    Free,
    /// Not at all.
    Locked,
    /// Between two values, metres or radians.
    Limited {
        /// Least; `None` for none.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        lower: Option<f32>,
        /// Greatest; `None` for none.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        upper: Option<f32>,
    },
}

/// What pulls a coordinate towards a target.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, expecting = "an object of a drive")]
pub struct DriveDoc {
    /// Where the spring rests, metres or radians.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub target: f32,
    /// Speed that the damper wants, m/s or rad/s.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub velocity: f32,
    /// Spring and damper; `None` holds the velocity as far as the force reaches.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub spring: Option<SpringDoc>,
    /// Greatest force or torque, N or N m, not negative; `None` for no bound.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max_force: Option<f32>,
}

/// A spring with its damper.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(
    rename_all = "snake_case",
    deny_unknown_fields,
    expecting = "a spring, as {\"frequency\": {\"hertz\": 2, \"damping_ratio\": 0.5}}"
)]
pub enum SpringDoc {
    /// By what the eye sees, whatever the masses.
    Frequency {
        /// Hz.
        hertz: f32,
        /// Share of critical damping.
        damping_ratio: f32,
    },
    /// By physics.
    Stiffness {
        /// N/m, or N m/rad.
        stiffness: f32,
        /// N s/m, or N m s/rad.
        damping: f32,
    },
}
