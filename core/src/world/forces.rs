//! Forces and impulses on bodies.

use super::World;
use super::sleep::wake_slot;
use crate::arena::Line;
use crate::body::Position;
use crate::error::Error;
use crate::handle::BodyHandle;
use crate::math::Vec3;
use crate::pipeline::integration;
use crate::validate::{self, SPEED_MAX};

/// Greatest force, torque, impulse or angular impulse component that can be given, SI units.
const EFFORT_MAX: f32 = 1.0e15;

impl<M: AsRef<[Line]> + AsMut<[Line]>> World<M> {
    /// Adds a force on the center of mass for the coming step, N.
    ///
    /// # Errors
    /// [`Error::Stale`], [`Error::WrongKind`] unless dynamic, or the sum of the forces leaves ±1e15.
    pub fn apply_force(&mut self, body: BodyHandle, force: Vec3) -> Result<(), Error> {
        self.add_effort(body, force, Vec3::ZERO)
    }

    /// Adds a force at a place, for the coming step, N.
    ///
    /// # Errors
    /// As [`World::apply_force`]; the place may be at most 1e6 m from the body.
    pub fn apply_force_at(&mut self, body: BodyHandle, force: Vec3, place: Position) -> Result<(), Error> {
        let arm = self.arm(body, place)?;
        validate::vector_within("force", force, EFFORT_MAX)?;
        self.add_effort(body, force, arm.cross(force))
    }

    /// Adds a torque for the coming step, N m in the world.
    ///
    /// # Errors
    /// As [`World::apply_force`].
    pub fn apply_torque(&mut self, body: BodyHandle, torque: Vec3) -> Result<(), Error> {
        self.add_effort(body, Vec3::ZERO, torque)
    }

    /// Changes velocity at once by an impulse on the center of mass, N s.
    ///
    /// # Errors
    /// As [`World::apply_force`]; also when the velocity would leave ±1e6.
    pub fn apply_impulse(&mut self, body: BodyHandle, impulse: Vec3) -> Result<(), Error> {
        self.add_impulse(body, impulse, Vec3::ZERO)
    }

    /// Changes velocities at once by an impulse at a place, N s.
    ///
    /// # Errors
    /// As [`World::apply_impulse`]; the place may be at most 1e6 m from the body.
    pub fn apply_impulse_at(
        &mut self,
        body: BodyHandle,
        impulse: Vec3,
        place: Position,
    ) -> Result<(), Error> {
        let arm = self.arm(body, place)?;
        validate::vector_within("impulse", impulse, EFFORT_MAX)?;
        self.add_impulse(body, impulse, arm.cross(impulse))
    }

    /// Changes angular velocity at once by an angular impulse, N m s in the world.
    ///
    /// # Errors
    /// As [`World::apply_impulse`].
    pub fn apply_angular_impulse(&mut self, body: BodyHandle, impulse: Vec3) -> Result<(), Error> {
        self.add_impulse(body, Vec3::ZERO, impulse)
    }

    fn arm(&self, body: BodyHandle, place: Position) -> Result<Vec3, Error> {
        validate::position("place", &place)?;
        let arm = place.minus(self.motion(body)?.center);
        validate::vector_within("place", arm, 1.0e6)?;
        Ok(arm)
    }

    fn add_effort(&mut self, body: BodyHandle, force: Vec3, torque: Vec3) -> Result<(), Error> {
        let slot = self.dynamic_slot(body)?;
        let mut state = self.state_view();
        let row = &mut state.bodies[slot];
        validate::vector_within("force", force, EFFORT_MAX)?;
        validate::vector_within("torque", torque, EFFORT_MAX)?;
        validate::vector_within("force", row.force + force, EFFORT_MAX)?;
        validate::vector_within("torque", row.torque + torque, EFFORT_MAX)?;
        row.force += force;
        row.torque += torque;
        wake_slot(&mut state, slot);
        Ok(())
    }

    fn add_impulse(&mut self, body: BodyHandle, impulse: Vec3, angular: Vec3) -> Result<(), Error> {
        let slot = self.dynamic_slot(body)?;
        validate::vector_within("impulse", impulse, EFFORT_MAX)?;
        validate::vector_within("impulse", angular, EFFORT_MAX)?;
        let mut state = self.state_view();
        let (row, motion) = (&state.bodies[slot], &mut state.motions[slot]);
        let locks = row.locks();
        let mut change = impulse / row.mass;
        for axis in 0..3 {
            if locks >> axis & 1 == 1 {
                change[axis] = 0.0;
            }
        }
        let principal = crate::state::principal_rotation(motion, row);
        let (root, _) = integration::root_and_whitened(principal, row.inertia, locks >> 3, Vec3::ZERO);
        let turn = integration::root_times(&root, integration::root_times(&root, angular));
        validate::vector_within("impulse", motion.linear + change, SPEED_MAX)?;
        validate::vector_within("impulse", motion.angular + turn, SPEED_MAX)?;
        motion.linear += change;
        motion.angular += turn;
        wake_slot(&mut state, slot);
        Ok(())
    }
}
