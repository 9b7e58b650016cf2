//! Bodies: how they are created, read and changed.

use crate::border::{change, make, read, there};
use crate::error::{CsResult, Failure};
use crate::types::{CsBody, CsPosition, CsRotation, CsVec3, body_kind, same};
use crate::world::CsWorld;
use cellstep::{AxisLocks, BodyDef, BodyKind, Error, MassProperties};
use std::mem::MaybeUninit;

/// Mass, center and inertia of a body.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CsMassProperties {
    /// kg.
    pub mass: f32,
    /// Center of mass in the body's frame, metres.
    pub center: CsVec3,
    /// Principal moments of inertia, kg m2.
    pub inertia: CsVec3,
    /// The frame of the principal axes in the body's frame.
    pub axes: CsRotation,
}

same! { CsMassProperties = MassProperties { mass, center, inertia, axes } }

/// What a new body is like; start from `cs_body_def`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CsBodyDef {
    /// `CS_STATIC`, `CS_KINEMATIC` or `CS_DYNAMIC`.
    pub kind: u32,
    /// Where its origin is.
    pub position: CsPosition,
    /// How it is turned; a unit quaternion within 1e-3.
    pub rotation: CsRotation,
    /// Of the center of mass, m/s.
    pub linear_velocity: CsVec3,
    /// In the world, rad/s.
    pub angular_velocity: CsVec3,
    /// 1/s.
    pub linear_damping: f32,
    /// 1/s.
    pub angular_damping: f32,
    /// Factor on gravity.
    pub gravity_scale: f32,
    /// World axes along which it does not move (1, 2, 4) or turn (8, 16, 32).
    pub locks: u32,
    /// 1 to take `mass`, 0 for that of the shapes' densities.
    pub has_mass: u32,
    /// Taken with `has_mass`.
    pub mass: CsMassProperties,
    /// 0 for a body that never falls asleep.
    pub can_sleep: u32,
    /// 1 for a body that does not pass through dynamic bodies either, fast as it may be.
    pub bullet: u32,
    /// Yours; part of the state.
    pub user: u64,
}

impl CsBodyDef {
    fn read(&self) -> Result<BodyDef, Failure> {
        Ok(BodyDef {
            kind: body_kind(self.kind)?,
            position: self.position.into(),
            rotation: self.rotation.into(),
            linear_velocity: self.linear_velocity.into(),
            angular_velocity: self.angular_velocity.into(),
            linear_damping: self.linear_damping,
            angular_damping: self.angular_damping,
            gravity_scale: self.gravity_scale,
            locks: locks(self.locks)?,
            mass: (self.has_mass != 0).then(|| self.mass.into()),
            can_sleep: self.can_sleep != 0,
            bullet: self.bullet != 0,
            user: self.user,
        })
    }
}

fn locks(bits: u32) -> Result<AxisLocks, Failure> {
    u8::try_from(bits).map(AxisLocks).map_err(|_| Error::OutOfRange { name: "locks" }.into())
}

/// A body of a kind at a place near the origin, metres, with the defaults of all else.
#[unsafe(no_mangle)]
pub extern "C" fn cs_body_def(kind: u32, offset: CsVec3) -> CsBodyDef {
    let def = BodyDef::new(BodyKind::Dynamic, offset.into());
    CsBodyDef {
        kind,
        position: def.position.into(),
        rotation: def.rotation.into(),
        linear_velocity: def.linear_velocity.into(),
        angular_velocity: def.angular_velocity.into(),
        linear_damping: def.linear_damping,
        angular_damping: def.angular_damping,
        gravity_scale: def.gravity_scale,
        locks: def.locks.0.into(),
        has_mass: 0,
        mass: MassProperties::default().into(),
        can_sleep: u32::from(def.can_sleep),
        bullet: u32::from(def.bullet),
        user: def.user,
    }
}

/// Creates a body.
#[unsafe(no_mangle)]
pub extern "C" fn cs_body_create(
    world: Option<&mut CsWorld>,
    def: Option<&CsBodyDef>,
    out: Option<&mut MaybeUninit<CsBody>>,
) -> CsResult {
    make(world, out, |world| Ok(world.create_body(&there(def, "def")?.read()?)?.into()))
}

/// Removes a body with its shapes and joints.
#[unsafe(no_mangle)]
pub extern "C" fn cs_body_remove(world: Option<&mut CsWorld>, body: CsBody) -> CsResult {
    change(world, |world| Ok(world.remove_body(body.into())?))
}

/// True when the handle names a body that exists.
#[unsafe(no_mangle)]
pub extern "C" fn cs_body_exists(world: Option<&CsWorld>, body: CsBody) -> bool {
    world.is_some_and(|world| !world.is_broken && world.inner.contains_body(body.into()))
}

/// Where the body's origin is.
#[unsafe(no_mangle)]
pub extern "C" fn cs_body_position(
    world: Option<&CsWorld>,
    body: CsBody,
    out: Option<&mut MaybeUninit<CsPosition>>,
) -> CsResult {
    read(world, out, |world| Ok(world.position(body.into())?.into()))
}

/// How the body is turned.
#[unsafe(no_mangle)]
pub extern "C" fn cs_body_rotation(
    world: Option<&CsWorld>,
    body: CsBody,
    out: Option<&mut MaybeUninit<CsRotation>>,
) -> CsResult {
    read(world, out, |world| Ok(world.rotation(body.into())?.into()))
}

/// Velocity of the center of mass, m/s.
#[unsafe(no_mangle)]
pub extern "C" fn cs_body_linear_velocity(
    world: Option<&CsWorld>,
    body: CsBody,
    out: Option<&mut MaybeUninit<CsVec3>>,
) -> CsResult {
    read(world, out, |world| Ok(world.linear_velocity(body.into())?.into()))
}

/// Angular velocity in the world, rad/s.
#[unsafe(no_mangle)]
pub extern "C" fn cs_body_angular_velocity(
    world: Option<&CsWorld>,
    body: CsBody,
    out: Option<&mut MaybeUninit<CsVec3>>,
) -> CsResult {
    read(world, out, |world| Ok(world.angular_velocity(body.into())?.into()))
}

/// The number that the body was given.
#[unsafe(no_mangle)]
pub extern "C" fn cs_body_user(
    world: Option<&CsWorld>,
    body: CsBody,
    out: Option<&mut MaybeUninit<u64>>,
) -> CsResult {
    read(world, out, |world| Ok(world.body_user(body.into())?))
}

/// 1 when the body sleeps, else 0.
#[unsafe(no_mangle)]
pub extern "C" fn cs_body_is_asleep(
    world: Option<&CsWorld>,
    body: CsBody,
    out: Option<&mut MaybeUninit<u32>>,
) -> CsResult {
    read(world, out, |world| Ok(world.is_asleep(body.into())?.into()))
}

/// Puts a body somewhere else.
#[unsafe(no_mangle)]
pub extern "C" fn cs_body_set_pose(
    world: Option<&mut CsWorld>,
    body: CsBody,
    position: CsPosition,
    rotation: CsRotation,
) -> CsResult {
    change(world, |world| Ok(world.set_pose(body.into(), position.into(), rotation.into())?))
}

/// Sets the velocity of the center of mass, m/s.
#[unsafe(no_mangle)]
pub extern "C" fn cs_body_set_linear_velocity(
    world: Option<&mut CsWorld>,
    body: CsBody,
    velocity: CsVec3,
) -> CsResult {
    change(world, |world| Ok(world.set_linear_velocity(body.into(), velocity.into())?))
}

/// Sets the angular velocity in the world, rad/s.
#[unsafe(no_mangle)]
pub extern "C" fn cs_body_set_angular_velocity(
    world: Option<&mut CsWorld>,
    body: CsBody,
    velocity: CsVec3,
) -> CsResult {
    change(world, |world| Ok(world.set_angular_velocity(body.into(), velocity.into())?))
}

/// Tells a kinematic body where to be at the end of the coming step.
#[unsafe(no_mangle)]
pub extern "C" fn cs_body_set_kinematic_target(
    world: Option<&mut CsWorld>,
    body: CsBody,
    position: CsPosition,
    rotation: CsRotation,
) -> CsResult {
    change(world, |world| Ok(world.set_kinematic_target(body.into(), position.into(), rotation.into())?))
}

/// Changes how a body moves: `CS_STATIC`, `CS_KINEMATIC` or `CS_DYNAMIC`.
#[unsafe(no_mangle)]
pub extern "C" fn cs_body_set_kind(world: Option<&mut CsWorld>, body: CsBody, kind: u32) -> CsResult {
    change(world, |world| Ok(world.set_kind(body.into(), body_kind(kind)?)?))
}

/// Gives a body a mass, or with null that of its shapes.
#[unsafe(no_mangle)]
pub extern "C" fn cs_body_set_mass(
    world: Option<&mut CsWorld>,
    body: CsBody,
    mass: Option<&CsMassProperties>,
) -> CsResult {
    change(world, |world| {
        let mass = mass.map(|&mass| mass.into());
        Ok(world.set_mass(body.into(), mass.as_ref())?)
    })
}

/// Sets the rates of loss of velocity, 1/s.
#[unsafe(no_mangle)]
pub extern "C" fn cs_body_set_damping(
    world: Option<&mut CsWorld>,
    body: CsBody,
    linear: f32,
    angular: f32,
) -> CsResult {
    change(world, |world| Ok(world.set_damping(body.into(), linear, angular)?))
}

/// Sets the factor on gravity.
#[unsafe(no_mangle)]
pub extern "C" fn cs_body_set_gravity_scale(
    world: Option<&mut CsWorld>,
    body: CsBody,
    scale: f32,
) -> CsResult {
    change(world, |world| Ok(world.set_gravity_scale(body.into(), scale)?))
}

/// Sets the world axes along which a body does not move (1, 2, 4) or turn (8, 16, 32).
#[unsafe(no_mangle)]
pub extern "C" fn cs_body_set_locks(world: Option<&mut CsWorld>, body: CsBody, bits: u32) -> CsResult {
    change(world, |world| Ok(world.set_locks(body.into(), locks(bits)?)?))
}

/// Sets the number of a body.
#[unsafe(no_mangle)]
pub extern "C" fn cs_body_set_user(world: Option<&mut CsWorld>, body: CsBody, user: u64) -> CsResult {
    change(world, |world| Ok(world.set_body_user(body.into(), user)?))
}

/// Wakes a body.
#[unsafe(no_mangle)]
pub extern "C" fn cs_body_wake(world: Option<&mut CsWorld>, body: CsBody) -> CsResult {
    change(world, |world| Ok(world.wake(body.into())?))
}

/// Adds a force on the center of mass in the coming step, N.
#[unsafe(no_mangle)]
pub extern "C" fn cs_body_apply_force(world: Option<&mut CsWorld>, body: CsBody, force: CsVec3) -> CsResult {
    change(world, |world| Ok(world.apply_force(body.into(), force.into())?))
}

/// Adds a force at a place in the coming step, N.
#[unsafe(no_mangle)]
pub extern "C" fn cs_body_apply_force_at(
    world: Option<&mut CsWorld>,
    body: CsBody,
    force: CsVec3,
    place: CsPosition,
) -> CsResult {
    change(world, |world| Ok(world.apply_force_at(body.into(), force.into(), place.into())?))
}

/// Adds a torque in the coming step, N m.
#[unsafe(no_mangle)]
pub extern "C" fn cs_body_apply_torque(
    world: Option<&mut CsWorld>,
    body: CsBody,
    torque: CsVec3,
) -> CsResult {
    change(world, |world| Ok(world.apply_torque(body.into(), torque.into())?))
}

/// Pushes the center of mass at once, N s.
#[unsafe(no_mangle)]
pub extern "C" fn cs_body_apply_impulse(
    world: Option<&mut CsWorld>,
    body: CsBody,
    impulse: CsVec3,
) -> CsResult {
    change(world, |world| Ok(world.apply_impulse(body.into(), impulse.into())?))
}

/// Pushes at a place at once, N s.
#[unsafe(no_mangle)]
pub extern "C" fn cs_body_apply_impulse_at(
    world: Option<&mut CsWorld>,
    body: CsBody,
    impulse: CsVec3,
    place: CsPosition,
) -> CsResult {
    change(world, |world| Ok(world.apply_impulse_at(body.into(), impulse.into(), place.into())?))
}

/// Turns at once, N m s.
#[unsafe(no_mangle)]
pub extern "C" fn cs_body_apply_angular_impulse(
    world: Option<&mut CsWorld>,
    body: CsBody,
    impulse: CsVec3,
) -> CsResult {
    change(world, |world| Ok(world.apply_angular_impulse(body.into(), impulse.into())?))
}
