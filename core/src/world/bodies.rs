//! Creating, changing and reading bodies.

use super::World;
use super::events::{forget_body, forget_shape};
use super::joints::remove_joints_of;
use super::materials::{drop_material, drop_rules};
use super::sleep::wake_slot;
use crate::arena::Line;
use crate::body::{
    self, ASLEEP, AxisLocks, BULLET, BodyDef, BodyKind, BodyRow, CHANGED_SECTOR, GIVEN_MASS, MassProperties,
    Motion, Position, SLEEPLESS, STOPS_AFTER_STEP,
};
use crate::collide::mass::MassAccumulator;
use crate::error::Error;
use crate::handle::{BodyHandle, ShapeHandle};
use crate::material::{RULE_IGNORE, RULE_MATERIAL};
use crate::math::{Rotation, Vec3, max};
use crate::pipeline::{events, integration, solid};
use crate::pool;
use crate::shape::{BOX_STALE, FRESH};
use crate::state::{PAIRS_REMOVED, ROUSED_LEFT, State, mark_shapes};
use crate::validate::{self, SPEED_MAX};
use bytemuck::Zeroable;

/// Least moment of inertia as a share of the body's greatest: thinner needles cannot be integrated in f32.
const INERTIA_RATIO_MIN: f32 = 1.0e-7;
/// Mass of a dynamic body whose shapes have none, kg; its inertia is that of a ball of one metre.
const MASS_DEFAULT: f32 = 1.0;

impl<M: AsRef<[Line]> + AsMut<[Line]>> World<M> {
    /// Adds a body. Its mass comes from its shapes unless the definition gives it; without either it is 1 kg.
    ///
    /// # Errors
    /// [`Error::Full`], or a number of the definition is refused; see [`BodyDef`].
    pub fn create_body(&mut self, def: &BodyDef) -> Result<BodyHandle, Error> {
        def.check()?;
        if out_of_world(def.position) {
            return Err(Error::OutOfRange { name: "position" });
        }
        let mut state = self.state_view();
        let marks = &mut state.header[0].bodies;
        let slot = pool::acquire(marks, state.body_used, state.body_generations)
            .ok_or(Error::Full { name: "bodies" })?;
        let index = slot as usize;
        let mut row = BodyRow::zeroed();
        row.user = def.user;
        row.linear_damping = def.linear_damping;
        row.angular_damping = def.angular_damping;
        row.gravity_scale = def.gravity_scale;
        row.first_shape = u32::MAX;
        row.set_kind(def.kind);
        row.set_locks(def.locks);
        if !def.can_sleep {
            row.flags |= SLEEPLESS;
        }
        if def.bullet {
            row.flags |= BULLET;
        }
        row.axes = Rotation::IDENTITY;
        row.stance = def.rotation.normalized().pack();
        let moving = def.kind != BodyKind::Static;
        state.motions[index] = Motion {
            center: def.position.normalized(),
            rotation: def.rotation.normalized(),
            linear: if moving { def.linear_velocity } else { Vec3::ZERO },
            angular: if moving { def.angular_velocity } else { Vec3::ZERO },
        };
        if def.mass.is_some() {
            row.flags |= GIVEN_MASS;
        }
        state.bodies[index] = row;
        set_mass(&mut state, slot, &def.mass.unwrap_or_else(default_mass));
        events::note_moved(&mut state, index);
        Ok(BodyHandle { index: slot, generation: state.body_generations[index] })
    }

    /// Removes a body, its shapes and its joints.
    ///
    /// # Errors
    /// [`Error::Stale`].
    pub fn remove_body(&mut self, body: BodyHandle) -> Result<(), Error> {
        let slot = self.body_slot(body)?;
        self.touch_trees();
        let mut state = self.state_view();
        wake_slot(&mut state, slot);
        if state.bodies[slot].has(ASLEEP) {
            state.header[0].asleep -= 1;
        }
        remove_joints_of(&mut state, slot as u32);
        drop_rules(&mut state, RULE_IGNORE, slot as u32);
        let mut shape = state.bodies[slot].first_shape;
        while shape != u32::MAX {
            let next = state.shapes[shape as usize].next;
            drop_material(&mut state, shape);
            drop_rules(&mut state, RULE_MATERIAL, shape);
            forget_shape(&mut state, shape as usize);
            state.shapes[shape as usize] = Zeroable::zeroed();
            pool::release(&mut state.header[0].shapes, state.shape_used, shape);
            shape = next;
        }
        forget_body(&mut state, slot);
        state.bodies[slot] = BodyRow::zeroed();
        state.motions[slot] = Zeroable::zeroed();
        state.dirt[slot] = 0;
        state.refined[slot / 64] &= !(1 << (slot % 64));
        state.loaded[slot / 64] &= !(1 << (slot % 64));
        pool::release(&mut state.header[0].bodies, state.body_used, slot as u32);
        state.header[0].pairs_stale |= PAIRS_REMOVED;
        Ok(())
    }

    /// True when the handle names a body that exists.
    pub fn contains_body(&self, body: BodyHandle) -> bool {
        self.body_slot(body).is_ok()
    }

    /// Handles of all bodies, ascending by slot.
    pub fn bodies(&self) -> impl Iterator<Item = BodyHandle> + '_ {
        let generations = self.layout.state.body_generations.of(self.state());
        pool::iterate(self.layout.state.body_used.of(self.state()), self.header().bodies.high)
            .map(|slot| BodyHandle { index: slot, generation: generations[slot as usize] })
    }

    /// Number of bodies.
    pub fn body_count(&self) -> u32 {
        self.header().bodies.count
    }

    /// Handles of a body's shapes, in the order of their creation.
    ///
    /// # Errors
    /// [`Error::Stale`].
    pub fn shapes_of(&self, body: BodyHandle) -> Result<impl Iterator<Item = ShapeHandle> + '_, Error> {
        let mut next = self.body_row(body)?.first_shape;
        let shapes = self.layout.state.shapes.of(self.state());
        let generations = self.layout.state.shape_generations.of(self.state());
        Ok(core::iter::from_fn(move || {
            (next != u32::MAX).then(|| {
                let slot = next;
                next = shapes[slot as usize].next;
                ShapeHandle { index: slot, generation: generations[slot as usize] }
            })
        }))
    }

    /// How the body moves.
    ///
    /// # Errors
    /// [`Error::Stale`], as for all accessors of a body.
    pub fn kind(&self, body: BodyHandle) -> Result<BodyKind, Error> {
        Ok(self.body_row(body)?.kind())
    }

    /// True when the body became non-finite and was stopped for good.
    pub fn is_quarantined(&self, body: BodyHandle) -> Result<bool, Error> {
        Ok(self.body_row(body)?.has(body::QUARANTINED))
    }

    /// Place of the body's origin.
    pub fn position(&self, body: BodyHandle) -> Result<Position, Error> {
        let (row, motion) = (self.body_row(body)?, self.motion(body)?);
        Ok(motion.center.plus(motion.origin_offset(row)))
    }

    /// Place of the body's center of mass.
    pub fn center(&self, body: BodyHandle) -> Result<Position, Error> {
        Ok(self.motion(body)?.center)
    }

    /// Orientation of the body's frame.
    pub fn rotation(&self, body: BodyHandle) -> Result<Rotation, Error> {
        Ok(self.motion(body)?.rotation)
    }

    /// Velocity of the center of mass, m/s.
    pub fn linear_velocity(&self, body: BodyHandle) -> Result<Vec3, Error> {
        Ok(self.motion(body)?.linear)
    }

    /// Angular velocity in the world, rad/s.
    pub fn angular_velocity(&self, body: BodyHandle) -> Result<Vec3, Error> {
        Ok(self.motion(body)?.angular)
    }

    /// Mass, center and inertia; those it would have, for a body that is not dynamic.
    pub fn mass_properties(&self, body: BodyHandle) -> Result<MassProperties, Error> {
        Ok(self.body_row(body)?.mass_properties())
    }

    /// True when the body is stopped at dynamic bodies too when it is fast; see [`BodyDef::bullet`].
    ///
    /// # Errors
    /// [`Error::Stale`].
    pub fn is_bullet(&self, body: BodyHandle) -> Result<bool, Error> {
        Ok(self.body_row(body)?.has(BULLET))
    }

    /// Sets whether the body is stopped at dynamic bodies too when it is fast; see [`BodyDef::bullet`].
    ///
    /// # Errors
    /// [`Error::Stale`].
    pub fn set_bullet(&mut self, body: BodyHandle, bullet: bool) -> Result<(), Error> {
        let row = self.body_row_mut(body)?;
        row.flags = if bullet { row.flags | BULLET } else { row.flags & !BULLET };
        Ok(())
    }

    /// Yours.
    pub fn body_user(&self, body: BodyHandle) -> Result<u64, Error> {
        Ok(self.body_row(body)?.user)
    }

    /// Sets your value.
    pub fn set_body_user(&mut self, body: BodyHandle, user: u64) -> Result<(), Error> {
        self.body_row_mut(body)?.user = user;
        Ok(())
    }

    /// Puts the body elsewhere. Velocities stay. Contacts are looked for anew in the next step.
    ///
    /// # Errors
    /// [`Error::Stale`], or the pose is refused.
    pub fn set_pose(
        &mut self,
        body: BodyHandle,
        position: Position,
        rotation: Rotation,
    ) -> Result<(), Error> {
        let slot = self.body_slot(body)?;
        check_pose(position, rotation)?;
        self.touch_trees();
        let mut state = self.state_view();
        wake_slot(&mut state, slot);
        let rotation = rotation.normalized();
        let local_center = state.bodies[slot].local_center;
        state.motions[slot].center = position.normalized().plus(rotation.rotate(local_center));
        state.motions[slot].rotation = rotation;
        state.bodies[slot].stance = rotation.pack();
        state.bodies[slot].flags &= !(STOPS_AFTER_STEP | CHANGED_SECTOR);
        mark_shapes(&mut state, slot, BOX_STALE | FRESH);
        events::note_moved(&mut state, slot);
        Ok(())
    }

    /// Sets the velocity of the center of mass, m/s; each component at most 1e6 in size.
    ///
    /// # Errors
    /// [`Error::Stale`], [`Error::WrongKind`] for a static body, or the vector is refused.
    pub fn set_linear_velocity(&mut self, body: BodyHandle, velocity: Vec3) -> Result<(), Error> {
        let slot = self.moving_slot(body)?;
        validate::vector_within("velocity", velocity, SPEED_MAX)?;
        let mut state = self.state_view();
        wake_slot(&mut state, slot);
        state.motions[slot].linear = velocity;
        state.bodies[slot].flags &= !STOPS_AFTER_STEP;
        Ok(())
    }

    /// Sets the angular velocity, rad/s in the world; each component at most 1e6 in size.
    ///
    /// # Errors
    /// As [`World::set_linear_velocity`].
    pub fn set_angular_velocity(&mut self, body: BodyHandle, velocity: Vec3) -> Result<(), Error> {
        let slot = self.moving_slot(body)?;
        validate::vector_within("velocity", velocity, SPEED_MAX)?;
        let mut state = self.state_view();
        wake_slot(&mut state, slot);
        state.motions[slot].angular = velocity;
        state.bodies[slot].flags &= !STOPS_AFTER_STEP;
        Ok(())
    }

    /// Sends a kinematic body to a pose: it gets the velocities that take it there in the next step (as long as the
    /// settings' `dt` is not changed meanwhile), and stops.
    ///
    /// # Errors
    /// [`Error::Stale`], [`Error::WrongKind`] unless kinematic, [`Error::OutOfRange`] when `dt` is 0 or the way is
    /// longer than 1e6 m/s allow, or the pose is refused.
    pub fn set_kinematic_target(
        &mut self,
        body: BodyHandle,
        position: Position,
        rotation: Rotation,
    ) -> Result<(), Error> {
        let slot = self.body_slot(body)?;
        check_pose(position, rotation)?;
        let dt = self.settings().dt;
        let mut state = self.state_view();
        if state.bodies[slot].kind() != BodyKind::Kinematic {
            return Err(Error::WrongKind { needs: "only a kinematic body has a target pose" });
        }
        if dt == 0.0 {
            return Err(Error::OutOfRange { name: "dt" });
        }
        let motion = &mut state.motions[slot];
        let rotation = rotation.normalized();
        let center = position.normalized().plus(rotation.rotate(state.bodies[slot].local_center));
        let linear = center.minus(motion.center) / dt;
        let turn = rotation.after(motion.rotation.inverse()).normalized();
        let angular = integration::rotation_vector(turn) / dt;
        validate::vector_within("position", linear, SPEED_MAX)?;
        validate::vector_within("rotation", angular, SPEED_MAX)?;
        motion.linear = linear;
        motion.angular = angular;
        state.bodies[slot].flags |= STOPS_AFTER_STEP;
        wake_slot(&mut state, slot);
        Ok(())
    }

    /// Changes how the body moves. A body that becomes static loses its velocities.
    ///
    /// # Errors
    /// [`Error::Stale`], or [`Error::WrongKind`] when a body with a half-space, a mesh or a height field shall
    /// become dynamic.
    pub fn set_kind(&mut self, body: BodyHandle, kind: BodyKind) -> Result<(), Error> {
        let slot = self.body_slot(body)?;
        if kind == BodyKind::Dynamic && !has_no_surface(&self.state_view(), slot) {
            return Err(Error::WrongKind {
                needs: "half-spaces, meshes and height fields are for static and kinematic bodies",
            });
        }
        self.touch_trees();
        let mut state = self.state_view();
        wake_slot(&mut state, slot);
        let row = &mut state.bodies[slot];
        if row.has(ASLEEP) {
            row.flags &= !ASLEEP;
            state.header[0].asleep -= 1;
            if !state.events.is_empty() {
                state.news[slot / 64].roused |= 1 << (slot % 64);
                state.header[0].event_marks |= ROUSED_LEFT;
            }
        }
        row.set_kind(kind);
        row.flags &= !(STOPS_AFTER_STEP | body::QUARANTINED);
        row.force = Vec3::ZERO;
        row.torque = Vec3::ZERO;
        if kind == BodyKind::Static {
            state.motions[slot].linear = Vec3::ZERO;
            state.motions[slot].angular = Vec3::ZERO;
        }
        state.bodies[slot].stance = state.motions[slot].rotation.pack();
        // Links of the ordering have other ends now: contacts and joints begin anew.
        mark_shapes(&mut state, slot, BOX_STALE | FRESH);
        crate::pipeline::joints::begin_anew(&mut state, slot as u32);
        Ok(())
    }

    /// Gives the body a mass of its own, or with `None` takes it from the shapes.
    ///
    /// # Errors
    /// [`Error::Stale`], or a number is refused; see [`MassProperties`].
    pub fn set_mass(&mut self, body: BodyHandle, mass: Option<&MassProperties>) -> Result<(), Error> {
        let slot = self.body_slot(body)?;
        // A far center rounds the pose anew.
        self.cache_header_mut().queried = 0;
        match mass {
            Some(mass) => {
                body::check_mass(mass)?;
                let mut state = self.state_view();
                state.bodies[slot].flags |= GIVEN_MASS;
                set_mass(&mut state, slot as u32, mass);
            }
            None => {
                self.state_view().bodies[slot].flags &= !GIVEN_MASS;
                self.update_mass(slot);
            }
        }
        Ok(())
    }

    /// Sets the rates of loss of velocity, 1/s, each 0..=1e4.
    pub fn set_damping(&mut self, body: BodyHandle, linear: f32, angular: f32) -> Result<(), Error> {
        validate::in_range("linear", linear, 0.0, 1.0e4)?;
        validate::in_range("angular", angular, 0.0, 1.0e4)?;
        let row = self.body_row_mut(body)?;
        (row.linear_damping, row.angular_damping) = (linear, angular);
        Ok(())
    }

    /// Sets the factor on gravity, -1e3..=1e3.
    pub fn set_gravity_scale(&mut self, body: BodyHandle, scale: f32) -> Result<(), Error> {
        validate::in_range("scale", scale, -1.0e3, 1.0e3)?;
        let slot = self.body_slot(body)?;
        let mut state = self.state_view();
        state.bodies[slot].gravity_scale = scale;
        wake_slot(&mut state, slot);
        Ok(())
    }

    /// Locks axes of the world for the body's motion.
    pub fn set_locks(&mut self, body: BodyHandle, locks: AxisLocks) -> Result<(), Error> {
        if locks.0 > AxisLocks::ALL.0 {
            return Err(Error::OutOfRange { name: "locks" });
        }
        let slot = self.body_slot(body)?;
        let mut state = self.state_view();
        state.bodies[slot].set_locks(locks);
        wake_slot(&mut state, slot);
        Ok(())
    }

    /// Recomputes a body's mass from its shapes, unless it was given.
    pub(super) fn update_mass(&mut self, slot: usize) {
        let tables = self.asset_tables();
        let bodies = self.layout.state.bodies.of(self.state());
        if bodies[slot].has(GIVEN_MASS) {
            return;
        }
        let shapes = self.layout.state.shapes.of(self.state());
        let mut sum = MassAccumulator::default();
        let mut next = bodies[slot].first_shape;
        while next != u32::MAX {
            let shape = &shapes[next as usize];
            sum.add(&solid(shape, &tables), &shape.pose, shape.density);
            next = shape.next;
        }
        let mass = sum.finish();
        let mass = if mass.mass > 0.0 && body::check_mass(&mass).is_ok() { mass } else { default_mass() };
        set_mass(&mut self.state_view(), slot as u32, &mass);
    }

    /// The trees no longer fit the shapes.
    pub(super) fn touch_trees(&mut self) {
        self.header_mut().static_version += 1;
        let cache = self.cache_header_mut();
        cache.moving_fits = 0;
        cache.moving_listed = 0;
        cache.queried = 0;
    }

    pub(super) fn body_slot(&self, body: BodyHandle) -> Result<usize, Error> {
        let used = self.layout.state.body_used.of(self.state());
        let generations = self.layout.state.body_generations.of(self.state());
        let lives =
            pool::is_used(used, body.index) && generations.get(body.index as usize) == Some(&body.generation);
        if lives { Ok(body.index as usize) } else { Err(Error::Stale { what: "body" }) }
    }

    fn moving_slot(&self, body: BodyHandle) -> Result<usize, Error> {
        if self.body_row(body)?.kind() == BodyKind::Static {
            return Err(Error::WrongKind { needs: "a static body does not move" });
        }
        Ok(body.index as usize)
    }

    pub(super) fn dynamic_slot(&self, body: BodyHandle) -> Result<usize, Error> {
        if !self.body_row(body)?.is_dynamic() {
            return Err(Error::WrongKind { needs: "forces and impulses act on dynamic bodies only" });
        }
        Ok(body.index as usize)
    }

    pub(super) fn body_row(&self, body: BodyHandle) -> Result<&BodyRow, Error> {
        let slot = self.body_slot(body)?;
        Ok(&self.layout.state.bodies.of(self.state())[slot])
    }

    fn body_row_mut(&mut self, body: BodyHandle) -> Result<&mut BodyRow, Error> {
        let slot = self.body_slot(body)?;
        let span = self.layout.state.bodies;
        Ok(&mut span.of_mut(self.state_mut())[slot])
    }

    pub(super) fn motion(&self, body: BodyHandle) -> Result<&Motion, Error> {
        let slot = self.body_slot(body)?;
        Ok(&self.layout.state.motions.of(self.state())[slot])
    }
}

fn check_pose(position: Position, rotation: Rotation) -> Result<(), Error> {
    validate::position("position", &position)?;
    validate::rotation("rotation", rotation)?;
    if out_of_world(position) { Err(Error::OutOfRange { name: "position" }) } else { Ok(()) }
}

/// True when the offset carries the position out of the sectors.
fn out_of_world(position: Position) -> bool {
    position.normalized().sector.iter().any(|s| s.unsigned_abs() > crate::config::SECTOR_MAX as u32)
}

fn default_mass() -> MassProperties {
    MassProperties {
        mass: MASS_DEFAULT,
        center: Vec3::ZERO,
        inertia: Vec3::splat(0.4 * MASS_DEFAULT),
        axes: Rotation::IDENTITY,
    }
}

/// Sets mass, center and inertia. The origin stays where it is; the velocity is that of the new center.
fn set_mass(state: &mut State<'_>, slot: u32, mass: &MassProperties) {
    let slot = slot as usize;
    wake_slot(state, slot);
    let (row, motion) = (&mut state.bodies[slot], &mut state.motions[slot]);
    let shift = motion.rotation.rotate(mass.center - row.local_center);
    let mut mass = *mass;
    let i = mass.inertia;
    let floor = INERTIA_RATIO_MIN * max(i.x, max(i.y, i.z));
    mass.inertia = Vec3::new(max(i.x, floor), max(i.y, floor), max(i.z, floor));
    mass.axes = mass.axes.normalized();
    row.set_mass_properties(&mass);
    if shift != Vec3::ZERO {
        let before = motion.center.sector;
        motion.center = motion.center.plus(shift);
        motion.linear += motion.angular.cross(shift);
        if motion.center.sector != before {
            row.flags |= CHANGED_SECTOR;
        }
    }
}

/// True when the body has neither a half-space nor a mesh nor a height field.
fn has_no_surface(state: &State<'_>, slot: usize) -> bool {
    let mut next = state.bodies[slot].first_shape;
    while next != u32::MAX {
        let shape = &state.shapes[next as usize];
        if shape.is_surface() {
            return false;
        }
        next = shape.next;
    }
    true
}
