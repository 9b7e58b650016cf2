//! Commands: the calls that change a world, as plain values with one encoding each.
//!
//! Whatever changes a world after its assets are registered is one of these, settings and gravity included. A
//! game that sends, keeps or rolls back its inputs does so with commands, and gives them to [`World::apply`], which
//! calls the method of the same name: there is no second path. Not commands are [`World::step`], and what puts a
//! world elsewhere in time as a whole ([`World::restore`], [`World::load`]).
//!
//! **Encoding.** Little-endian: a tag of two bytes, the kind in the lower and the version of this kind's fields in
//! the upper one, then the fields in the order of the definition. Numbers as they are, `bool` and `Option` as a
//! byte 0 or 1, an enumeration as a byte and the fields of its variant. A value has exactly one encoding: what
//! decodes encodes to the same bytes. What is not a number is written as `7fc00000`, since its bits differ between
//! machines; a world refuses it anyway. A kind whose fields change gets a new version; bytes of a version that this
//! build does not know are refused.
//!
//! [`World::apply`]: crate::World::apply
//! [`World::step`]: crate::World::step
//! [`World::restore`]: crate::World::restore
//! [`World::load`]: crate::World::load

mod wire;

use crate::body::{AxisLocks, BodyDef, BodyKind, MassProperties, Position};
use crate::config::Settings;
use crate::event::ShapeEvents;
use crate::handle::{BodyHandle, JointHandle, ShapeHandle};
use crate::joint::{Axis, JointDef};
use crate::material::{MaterialTraits, PairMaterial};
use crate::math::{Pose, Rotation, Vec3};
use crate::shape::{Filter, Geometry, ShapeDef};
use core::fmt;
use wire::{Input, Output, Wire};

/// A call that changes a world. Its values are those of the method, in their order; see there for units, ranges
/// and errors.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
// A joint's definition is ten times as large as a push; a box needs an allocator.
#[allow(clippy::large_enum_variant)]
pub enum Command {
    /// [`World::set_settings`](crate::World::set_settings).
    SetSettings(Settings),
    /// [`World::create_body`](crate::World::create_body).
    CreateBody(BodyDef),
    /// [`World::remove_body`](crate::World::remove_body).
    RemoveBody(BodyHandle),
    /// [`World::set_pose`](crate::World::set_pose).
    SetPose(BodyHandle, Position, Rotation),
    /// [`World::set_linear_velocity`](crate::World::set_linear_velocity).
    SetLinearVelocity(BodyHandle, Vec3),
    /// [`World::set_angular_velocity`](crate::World::set_angular_velocity).
    SetAngularVelocity(BodyHandle, Vec3),
    /// [`World::set_kinematic_target`](crate::World::set_kinematic_target).
    SetKinematicTarget(BodyHandle, Position, Rotation),
    /// [`World::set_kind`](crate::World::set_kind).
    SetKind(BodyHandle, BodyKind),
    /// [`World::set_mass`](crate::World::set_mass).
    SetMass(BodyHandle, Option<MassProperties>),
    /// [`World::set_damping`](crate::World::set_damping).
    SetDamping(BodyHandle, f32, f32),
    /// [`World::set_gravity_scale`](crate::World::set_gravity_scale).
    SetGravityScale(BodyHandle, f32),
    /// [`World::set_locks`](crate::World::set_locks).
    SetLocks(BodyHandle, AxisLocks),
    /// [`World::set_bullet`](crate::World::set_bullet).
    SetBullet(BodyHandle, bool),
    /// [`World::set_body_user`](crate::World::set_body_user).
    SetBodyUser(BodyHandle, u64),
    /// [`World::wake`](crate::World::wake).
    Wake(BodyHandle),
    /// [`World::set_can_sleep`](crate::World::set_can_sleep).
    SetCanSleep(BodyHandle, bool),
    /// [`World::apply_force`](crate::World::apply_force).
    ApplyForce(BodyHandle, Vec3),
    /// [`World::apply_force_at`](crate::World::apply_force_at).
    ApplyForceAt(BodyHandle, Vec3, Position),
    /// [`World::apply_torque`](crate::World::apply_torque).
    ApplyTorque(BodyHandle, Vec3),
    /// [`World::apply_impulse`](crate::World::apply_impulse).
    ApplyImpulse(BodyHandle, Vec3),
    /// [`World::apply_impulse_at`](crate::World::apply_impulse_at).
    ApplyImpulseAt(BodyHandle, Vec3, Position),
    /// [`World::apply_angular_impulse`](crate::World::apply_angular_impulse).
    ApplyAngularImpulse(BodyHandle, Vec3),
    /// [`World::create_shape`](crate::World::create_shape).
    CreateShape(BodyHandle, ShapeDef),
    /// [`World::remove_shape`](crate::World::remove_shape).
    RemoveShape(ShapeHandle),
    /// [`World::set_shape_user`](crate::World::set_shape_user).
    SetShapeUser(ShapeHandle, u64),
    /// [`World::set_geometry`](crate::World::set_geometry).
    SetGeometry(ShapeHandle, Geometry, Pose),
    /// [`World::set_density`](crate::World::set_density).
    SetDensity(ShapeHandle, f32),
    /// [`World::set_filter`](crate::World::set_filter).
    SetFilter(ShapeHandle, Filter),
    /// [`World::set_material`](crate::World::set_material).
    SetMaterial(ShapeHandle, f32, f32),
    /// [`World::set_material_traits`](crate::World::set_material_traits).
    SetMaterialTraits(ShapeHandle, MaterialTraits),
    /// [`World::set_shape_events`](crate::World::set_shape_events).
    SetShapeEvents(ShapeHandle, ShapeEvents),
    /// [`World::set_pair_material`](crate::World::set_pair_material).
    SetPairMaterial(ShapeHandle, ShapeHandle, PairMaterial),
    /// [`World::ignore_until_separated`](crate::World::ignore_until_separated).
    IgnoreUntilSeparated(BodyHandle, BodyHandle),
    /// [`World::stop_ignoring`](crate::World::stop_ignoring).
    StopIgnoring(BodyHandle, BodyHandle),
    /// [`World::create_joint`](crate::World::create_joint).
    CreateJoint(JointDef),
    /// [`World::remove_joint`](crate::World::remove_joint).
    RemoveJoint(JointHandle),
    /// [`World::set_joint`](crate::World::set_joint).
    SetJoint(JointHandle, JointDef),
    /// [`World::set_joint_axis`](crate::World::set_joint_axis).
    SetJointAxis(JointHandle, u32, Axis),
    /// [`World::set_joint_user`](crate::World::set_joint_user).
    SetJointUser(JointHandle, u64),
}

/// What a command that was not refused did.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Applied {
    /// It changed something.
    Done,
    /// It created this body.
    Body(BodyHandle),
    /// It created this shape.
    Shape(ShapeHandle),
    /// It created this joint.
    Joint(JointHandle),
}

/// Why bytes are no command, or a command has no room.
#[non_exhaustive]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CommandError {
    /// The output is too small: [`Command::BYTES_MAX`] is enough for any command.
    BufferTooSmall {
        /// Bytes that the command takes.
        needed: usize,
    },
    /// The bytes end within the command.
    End,
    /// No command of this build has such a tag: the bytes are of another version, or none of ours.
    Tag {
        /// The first two bytes.
        tag: u16,
    },
    /// A byte stands for no value of its kind, or a number is not written in its only way.
    Value {
        /// Where it ends, from the start of the command.
        offset: usize,
    },
}

impl Command {
    /// Bytes of the longest encoding.
    pub const BYTES_MAX: usize = <Self as Wire>::SIZE_MAX;

    /// Writes the encoding to the start of `out` and returns its length.
    ///
    /// # Errors
    /// [`CommandError::BufferTooSmall`]; `out` is then undefined.
    pub fn encode(&self, out: &mut [u8]) -> Result<usize, CommandError> {
        let mut output = Output::new(out);
        self.put(&mut output);
        output.finish()
    }

    /// Reads a command from the start of bytes from anywhere, and tells how many bytes it takes. What it says is
    /// checked by the world, when it is applied.
    ///
    /// # Errors
    /// [`CommandError::End`], [`CommandError::Tag`] or [`CommandError::Value`].
    ///
    /// ```
    /// use cellstep_core::{BodyHandle, Command, math::Vec3};
    ///
    /// let push = Command::ApplyImpulse(BodyHandle { index: 3, generation: 1 }, Vec3::new(0.0, 0.0, 5.0));
    /// let mut bytes = [0; Command::BYTES_MAX];
    /// let length = push.encode(&mut bytes).unwrap();
    /// assert_eq!(Command::decode(&bytes[..length]), Ok((push, length)));
    /// ```
    pub fn decode(bytes: &[u8]) -> Result<(Self, usize), CommandError> {
        let mut input = Input::new(bytes);
        let command = Self::take(&mut input)?;
        Ok((command, input.position()))
    }
}

impl fmt::Display for CommandError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            CommandError::BufferTooSmall { needed } => write!(f, "the command needs {needed} bytes"),
            CommandError::End => write!(f, "the bytes end within a command"),
            CommandError::Tag { tag } => write!(f, "no command has the tag {tag:04x}"),
            CommandError::Value { offset } => {
                write!(f, "what ends at byte {offset} of the command is no value of its kind")
            }
        }
    }
}

impl core::error::Error for CommandError {}
