//! Commands to calls.

use super::World;
use crate::arena::Line;
use crate::command::{Applied, Command};
use crate::error::Error;

impl<M: AsRef<[Line]> + AsMut<[Line]>> World<M> {
    /// Does what the method does that the command is named after, and tells what was created.
    ///
    /// # Errors
    /// Those of the method; the world is unchanged.
    pub fn apply(&mut self, command: &Command) -> Result<Applied, Error> {
        match command {
            Command::SetSettings(settings) => self.set_settings(settings)?,
            Command::CreateBody(def) => return self.create_body(def).map(Applied::Body),
            Command::CreateShape(body, def) => return self.create_shape(*body, def).map(Applied::Shape),
            Command::CreateJoint(def) => return self.create_joint(def).map(Applied::Joint),
            Command::RemoveJoint(joint) => self.remove_joint(*joint)?,
            Command::SetJoint(joint, def) => self.set_joint(*joint, def)?,
            Command::SetJointAxis(joint, index, axis) => {
                self.set_joint_axis(*joint, *index as usize, axis)?
            }
            Command::SetJointUser(joint, user) => self.set_joint_user(*joint, *user)?,
            Command::RemoveShape(shape) => self.remove_shape(*shape)?,
            Command::SetShapeUser(shape, user) => self.set_shape_user(*shape, *user)?,
            Command::SetGeometry(shape, geometry, pose) => self.set_geometry(*shape, geometry, pose)?,
            Command::SetDensity(shape, density) => self.set_density(*shape, *density)?,
            Command::SetFilter(shape, filter) => self.set_filter(*shape, *filter)?,
            Command::SetMaterial(shape, friction, bounce) => self.set_material(*shape, *friction, *bounce)?,
            Command::SetMaterialTraits(shape, traits) => self.set_material_traits(*shape, traits)?,
            Command::SetShapeEvents(shape, events) => self.set_shape_events(*shape, *events)?,
            Command::SetPairMaterial(a, b, material) => self.set_pair_material(*a, *b, material)?,
            Command::RemoveBody(body) => self.remove_body(*body)?,
            Command::SetPose(body, position, rotation) => self.set_pose(*body, *position, *rotation)?,
            Command::SetLinearVelocity(body, velocity) => self.set_linear_velocity(*body, *velocity)?,
            Command::SetAngularVelocity(body, velocity) => self.set_angular_velocity(*body, *velocity)?,
            Command::SetKinematicTarget(body, position, rotation) => {
                self.set_kinematic_target(*body, *position, *rotation)?;
            }
            Command::SetKind(body, kind) => self.set_kind(*body, *kind)?,
            Command::SetMass(body, mass) => self.set_mass(*body, mass.as_ref())?,
            Command::SetDamping(body, linear, angular) => self.set_damping(*body, *linear, *angular)?,
            Command::SetGravityScale(body, scale) => self.set_gravity_scale(*body, *scale)?,
            Command::SetLocks(body, locks) => self.set_locks(*body, *locks)?,
            Command::SetBullet(body, bullet) => self.set_bullet(*body, *bullet)?,
            Command::SetBodyUser(body, user) => self.set_body_user(*body, *user)?,
            Command::Wake(body) => self.wake(*body)?,
            Command::SetCanSleep(body, can_sleep) => self.set_can_sleep(*body, *can_sleep)?,
            Command::ApplyForce(body, force) => self.apply_force(*body, *force)?,
            Command::ApplyForceAt(body, force, place) => self.apply_force_at(*body, *force, *place)?,
            Command::ApplyTorque(body, torque) => self.apply_torque(*body, *torque)?,
            Command::ApplyImpulse(body, impulse) => self.apply_impulse(*body, *impulse)?,
            Command::ApplyImpulseAt(body, impulse, place) => {
                self.apply_impulse_at(*body, *impulse, *place)?
            }
            Command::ApplyAngularImpulse(body, impulse) => self.apply_angular_impulse(*body, *impulse)?,
            Command::IgnoreUntilSeparated(a, b) => self.ignore_until_separated(*a, *b)?,
            Command::StopIgnoring(a, b) => self.stop_ignoring(*a, *b)?,
        }
        Ok(Applied::Done)
    }
}
