//! Commands: the calls that change a world, as values.
//!
//! A game that rolls back keeps its commands and gives them again. So do the tests: a [`Command`] holds everything
//! that the call takes, handles included, and a list of commands with their outcomes is a history that can be
//! replayed on another world.

use crate::worlds::OwnedWorld;
use cellstep::math::{Pose, Rotation, Vec3};
use cellstep::{
    Axis, AxisLocks, BodyDef, BodyHandle, BodyKind, Error, Filter, Geometry, JointDef, JointHandle,
    MassProperties, MaterialTraits, PairMaterial, Position, Settings, ShapeDef, ShapeHandle,
};

/// A call that changes a world. The names are those of the methods of `World`.
#[derive(Clone, Debug, PartialEq)]
#[allow(missing_docs)] // Each variant is documented at the method of its name.
pub enum Command {
    CreateBody(BodyDef),
    RemoveBody(BodyHandle),
    CreateShape(BodyHandle, ShapeDef),
    RemoveShape(ShapeHandle),
    SetPose(BodyHandle, Position, Rotation),
    SetLinearVelocity(BodyHandle, Vec3),
    SetAngularVelocity(BodyHandle, Vec3),
    SetKinematicTarget(BodyHandle, Position, Rotation),
    SetKind(BodyHandle, BodyKind),
    SetMass(BodyHandle, Option<MassProperties>),
    SetDamping(BodyHandle, f32, f32),
    SetGravityScale(BodyHandle, f32),
    SetLocks(BodyHandle, AxisLocks),
    SetBodyUser(BodyHandle, u64),
    ApplyForce(BodyHandle, Vec3),
    ApplyForceAt(BodyHandle, Vec3, Position),
    ApplyTorque(BodyHandle, Vec3),
    ApplyImpulse(BodyHandle, Vec3),
    ApplyImpulseAt(BodyHandle, Vec3, Position),
    ApplyAngularImpulse(BodyHandle, Vec3),
    SetShapeUser(ShapeHandle, u64),
    SetGeometry(ShapeHandle, Geometry, Pose),
    SetDensity(ShapeHandle, f32),
    SetMaterial(ShapeHandle, f32, f32),
    SetMaterialTraits(ShapeHandle, MaterialTraits),
    SetPairMaterial(ShapeHandle, ShapeHandle, PairMaterial),
    IgnoreUntilSeparated(BodyHandle, BodyHandle),
    StopIgnoring(BodyHandle, BodyHandle),
    SetFilter(ShapeHandle, Filter),
    CreateJoint(Box<JointDef>),
    RemoveJoint(JointHandle),
    SetJoint(JointHandle, Box<JointDef>),
    SetJointAxis(JointHandle, usize, Axis),
    SetJointUser(JointHandle, u64),
    SetSettings(Settings),
}

/// What a command that was not refused did.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// It changed something.
    Done,
    /// It created this body.
    Body(BodyHandle),
    /// It created this shape.
    Shape(ShapeHandle),
    /// It created this joint.
    Joint(JointHandle),
}

impl Command {
    /// Gives the command to a world.
    ///
    /// # Errors
    /// That of the method.
    pub fn apply(&self, world: &mut OwnedWorld) -> Result<Outcome, Error> {
        match self {
            Self::CreateBody(def) => return world.create_body(def).map(Outcome::Body),
            Self::CreateShape(body, def) => return world.create_shape(*body, def).map(Outcome::Shape),
            Self::CreateJoint(def) => return world.create_joint(def).map(Outcome::Joint),
            Self::RemoveJoint(joint) => world.remove_joint(*joint)?,
            Self::SetJoint(joint, def) => world.set_joint(*joint, def)?,
            Self::SetJointAxis(joint, index, axis) => world.set_joint_axis(*joint, *index, axis)?,
            Self::SetJointUser(joint, user) => world.set_joint_user(*joint, *user)?,
            Self::RemoveShape(shape) => world.remove_shape(*shape)?,
            Self::SetShapeUser(shape, user) => world.set_shape_user(*shape, *user)?,
            Self::SetGeometry(shape, geometry, pose) => world.set_geometry(*shape, geometry, pose)?,
            Self::SetDensity(shape, density) => world.set_density(*shape, *density)?,
            Self::SetMaterial(shape, friction, bounce) => world.set_material(*shape, *friction, *bounce)?,
            Self::SetMaterialTraits(shape, traits) => world.set_material_traits(*shape, traits)?,
            Self::SetPairMaterial(a, b, material) => world.set_pair_material(*a, *b, material)?,
            Self::IgnoreUntilSeparated(a, b) => world.ignore_until_separated(*a, *b)?,
            Self::StopIgnoring(a, b) => world.stop_ignoring(*a, *b)?,
            Self::SetFilter(shape, filter) => world.set_filter(*shape, *filter)?,
            Self::SetSettings(settings) => world.set_settings(settings)?,
            of_body => return of_body.apply_to_body(world),
        }
        Ok(Outcome::Done)
    }

    fn apply_to_body(&self, world: &mut OwnedWorld) -> Result<Outcome, Error> {
        match self {
            Self::RemoveBody(body) => world.remove_body(*body)?,
            Self::SetPose(body, position, rotation) => world.set_pose(*body, *position, *rotation)?,
            Self::SetLinearVelocity(body, velocity) => world.set_linear_velocity(*body, *velocity)?,
            Self::SetAngularVelocity(body, velocity) => world.set_angular_velocity(*body, *velocity)?,
            Self::SetKinematicTarget(body, position, rotation) => {
                world.set_kinematic_target(*body, *position, *rotation)?;
            }
            Self::SetKind(body, kind) => world.set_kind(*body, *kind)?,
            Self::SetMass(body, mass) => world.set_mass(*body, mass.as_ref())?,
            Self::SetDamping(body, linear, angular) => world.set_damping(*body, *linear, *angular)?,
            Self::SetGravityScale(body, scale) => world.set_gravity_scale(*body, *scale)?,
            Self::SetLocks(body, locks) => world.set_locks(*body, *locks)?,
            Self::SetBodyUser(body, user) => world.set_body_user(*body, *user)?,
            Self::ApplyForce(body, force) => world.apply_force(*body, *force)?,
            Self::ApplyForceAt(body, force, place) => world.apply_force_at(*body, *force, *place)?,
            Self::ApplyTorque(body, torque) => world.apply_torque(*body, *torque)?,
            Self::ApplyImpulse(body, impulse) => world.apply_impulse(*body, *impulse)?,
            Self::ApplyImpulseAt(body, impulse, place) => world.apply_impulse_at(*body, *impulse, *place)?,
            Self::ApplyAngularImpulse(body, impulse) => world.apply_angular_impulse(*body, *impulse)?,
            other => unreachable!("{other:?} is not of a body"),
        }
        Ok(Outcome::Done)
    }
}
