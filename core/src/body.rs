//! Bodies: what moves, how it is created, and its rows in the state.

use crate::config::{SECTOR_REACH, SECTOR_SIZE};
use crate::error::Error;
use crate::math::{Pose, Rotation, Vec3};
use crate::validate::{self, SPEED_MAX};
use bytemuck::{Pod, Zeroable};
use glam::DVec3;

pub use crate::collide::mass::MassProperties;

/// A place in the world: a sector of [`SECTOR_SIZE`] metres and an offset from its middle.
///
/// All arithmetic is on differences, so a world is as precise at 10,000 km as at the origin.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Position {
    /// Sector coordinates, each at most [`SECTOR_MAX`](crate::config::SECTOR_MAX) in size.
    pub sector: [i32; 3],
    /// Metres from the sector's middle.
    pub offset: Vec3,
}

impl Position {
    /// The origin.
    pub const ORIGIN: Self = Self { sector: [0; 3], offset: Vec3::ZERO };

    /// A place near the origin, metres.
    pub fn at(offset: Vec3) -> Self {
        Self { sector: [0; 3], offset }.normalized()
    }

    /// The place with coordinates given in double precision, metres; exact where an offset can hold them.
    pub fn from_f64(x: [f64; 3]) -> Self {
        let mut place = Self::ORIGIN;
        for (axis, value) in x.iter().enumerate() {
            let sector = libm::rint(value / f64::from(SECTOR_SIZE));
            place.sector[axis] = sector as i32;
            place.offset[axis] = (value - sector * f64::from(SECTOR_SIZE)) as f32;
        }
        place
    }

    /// Coordinates in double precision, metres.
    pub fn to_f64(self) -> [f64; 3] {
        core::array::from_fn(|i| {
            f64::from(self.sector[i]) * f64::from(SECTOR_SIZE) + f64::from(self.offset[i])
        })
    }

    /// The vector from `other` to here, metres. Exact within a sector.
    #[inline]
    pub fn minus(self, other: Self) -> Vec3 {
        let sectors = Vec3::new(
            self.sector[0].wrapping_sub(other.sector[0]) as f32,
            self.sector[1].wrapping_sub(other.sector[1]) as f32,
            self.sector[2].wrapping_sub(other.sector[2]) as f32,
        );
        sectors * SECTOR_SIZE + (self.offset - other.offset)
    }

    /// This place moved by `v`, metres.
    pub fn plus(self, v: Vec3) -> Self {
        Self { sector: self.sector, offset: self.offset + v }.normalized()
    }

    /// The vector from `other` to here, metres, to the last bit that the positions hold.
    pub(crate) fn minus_wide(self, other: Self) -> DVec3 {
        let axis = |i: usize| {
            let sectors = f64::from(self.sector[i]) - f64::from(other.sector[i]);
            sectors * f64::from(SECTOR_SIZE) + (f64::from(self.offset[i]) - f64::from(other.offset[i]))
        };
        DVec3::new(axis(0), axis(1), axis(2))
    }

    /// This place moved by `v`, metres, rounded once.
    pub(crate) fn plus_wide(self, v: DVec3) -> Self {
        let mut place = self;
        for axis in 0..3 {
            let offset = f64::from(self.offset[axis]) + v[axis];
            let far = offset.abs() > f64::from(SECTOR_REACH);
            let sectors = if far { libm::rint(offset / f64::from(SECTOR_SIZE)) } else { 0.0 };
            place.sector[axis] = place.sector[axis].saturating_add(sectors as i32);
            place.offset[axis] = (offset - sectors * f64::from(SECTOR_SIZE)) as f32;
        }
        place
    }

    /// The same place with its offset inside the sector's reach, so that it is written in one way only as long
    /// as it stays in the sector's inner 64 m.
    pub fn normalized(self) -> Self {
        let mut place = self;
        for axis in 0..3 {
            let offset = place.offset[axis];
            if offset.abs() > SECTOR_REACH {
                let sectors = libm::rintf(offset / SECTOR_SIZE);
                place.sector[axis] = place.sector[axis].saturating_add(sectors as i32);
                place.offset[axis] = offset - sectors * SECTOR_SIZE;
            }
        }
        place
    }
}

/// How a body moves.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum BodyKind {
    /// Never moves.
    Static,
    /// Moves as told, by velocity or towards a target pose; pushes, is not pushed.
    Kinematic,
    /// Moves by forces and contacts.
    #[default]
    Dynamic,
}

/// Axes of the world along which a dynamic body does not move or turn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct AxisLocks(pub u8);

impl AxisLocks {
    /// Nothing locked.
    pub const NONE: Self = Self(0);
    /// No motion along x.
    pub const MOVE_X: Self = Self(1);
    /// No motion along y.
    pub const MOVE_Y: Self = Self(2);
    /// No motion along z.
    pub const MOVE_Z: Self = Self(4);
    /// No turning about x.
    pub const TURN_X: Self = Self(8);
    /// No turning about y.
    pub const TURN_Y: Self = Self(16);
    /// No turning about z.
    pub const TURN_Z: Self = Self(32);
    /// No turning at all.
    pub const TURN: Self = Self(56);
    /// Nothing moves.
    pub const ALL: Self = Self(63);

    /// Locks of both.
    pub const fn and(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }
}

/// What a new body is like.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BodyDef {
    /// How it moves.
    pub kind: BodyKind,
    /// Where its origin is.
    pub position: Position,
    /// How it is turned; a unit quaternion within 1e-3 (it is normalised).
    pub rotation: Rotation,
    /// Velocity of its center of mass, m/s; each component at most 1e6 in size.
    pub linear_velocity: Vec3,
    /// Angular velocity in the world, rad/s; each component at most 1e6 in size.
    pub angular_velocity: Vec3,
    /// Rate of loss of linear velocity, 1/s, `0..=1e4`.
    pub linear_damping: f32,
    /// Rate of loss of angular velocity, 1/s, `0..=1e4`.
    pub angular_damping: f32,
    /// Factor on gravity, -1e3..=1e3.
    pub gravity_scale: f32,
    /// World axes along which it does not move or turn.
    pub locks: AxisLocks,
    /// Mass, center and inertia; `None` takes them from the shapes' densities.
    pub mass: Option<MassProperties>,
    /// False for a body that never falls asleep, and keeps awake what it touches.
    pub can_sleep: bool,
    /// True for a dynamic body that does not pass through other dynamic bodies either, fast as it may be. Through
    /// static and kinematic ones none does; see [`Settings::continuous`](crate::config::Settings::continuous).
    pub bullet: bool,
    /// Yours; part of the state.
    pub user: u64,
}

impl Default for BodyDef {
    fn default() -> Self {
        Self {
            kind: BodyKind::Dynamic,
            position: Position::ORIGIN,
            rotation: Rotation::IDENTITY,
            linear_velocity: Vec3::ZERO,
            angular_velocity: Vec3::ZERO,
            linear_damping: 0.0,
            angular_damping: 0.0,
            gravity_scale: 1.0,
            locks: AxisLocks::NONE,
            mass: None,
            can_sleep: true,
            bullet: false,
            user: 0,
        }
    }
}

impl BodyDef {
    /// A body of a kind at a place near the origin, metres.
    pub fn new(kind: BodyKind, position: Vec3) -> Self {
        Self { kind, position: Position::at(position), ..Self::default() }
    }

    /// Refuses numbers that are not finite or out of the documented ranges.
    pub fn check(&self) -> Result<(), Error> {
        validate::position("position", &self.position)?;
        validate::rotation("rotation", self.rotation)?;
        validate::vector_within("linear_velocity", self.linear_velocity, SPEED_MAX)?;
        validate::vector_within("angular_velocity", self.angular_velocity, SPEED_MAX)?;
        validate::in_range("linear_damping", self.linear_damping, 0.0, 1.0e4)?;
        validate::in_range("angular_damping", self.angular_damping, 0.0, 1.0e4)?;
        validate::in_range("gravity_scale", self.gravity_scale, -1.0e3, 1.0e3)?;
        if self.locks.0 > AxisLocks::ALL.0 {
            return Err(Error::OutOfRange { name: "locks" });
        }
        self.mass.as_ref().map_or(Ok(()), check_mass)
    }
}

/// Refuses masses that are no body's: negative, beyond 1e-12..1e12 kg, or moments against the triangle rule.
pub fn check_mass(mass: &MassProperties) -> Result<(), Error> {
    validate::in_range("mass", mass.mass, 1.0e-12, 1.0e12)?;
    validate::vector_within("center", mass.center, validate::EXTENT_MAX)?;
    validate::rotation("axes", mass.axes)?;
    let i = mass.inertia;
    for moment in [i.x, i.y, i.z] {
        validate::in_range("inertia", moment, 1.0e-18, 1.0e24)?;
    }
    // Moments are sums of m r^2 over two axes: none exceeds the sum of the others (a millionth for rounding).
    let slack = 1.0e-6 * (i.x + i.y + i.z);
    if i.x > i.y + i.z + slack || i.y > i.z + i.x + slack || i.z > i.x + i.y + slack {
        return Err(Error::OutOfRange { name: "inertia" });
    }
    Ok(())
}

/// Where a body's center of mass is and how it moves: the part that every step writes.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub(crate) struct Motion {
    /// Center of mass.
    pub center: Position,
    /// Orientation of the body's frame.
    pub rotation: Rotation,
    /// Velocity of the center of mass, m/s.
    pub linear: Vec3,
    /// Angular velocity in the world, rad/s.
    pub angular: Vec3,
}

/// The part of a body that changes by calls.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub(crate) struct BodyRow {
    /// Yours.
    pub user: u64,
    /// Force on the center in the coming step, N.
    pub force: Vec3,
    /// Torque in the coming step, N m.
    pub torque: Vec3,
    /// kg; the dynamic mass also of a body that is static for now.
    pub mass: f32,
    /// Principal moments of inertia, kg m2.
    pub inertia: Vec3,
    /// Principal frame in the body's frame.
    pub axes: Rotation,
    /// Center of mass in the body's frame, metres.
    pub local_center: Vec3,
    /// 1/s.
    pub linear_damping: f32,
    /// 1/s.
    pub angular_damping: f32,
    /// Factor on gravity.
    pub gravity_scale: f32,
    /// First shape's slot, or `u32::MAX`.
    pub first_shape: u32,
    /// `KIND_*`, `LOCKS_SHIFT` and the flags below.
    pub flags: u32,
    /// Orientation for which the arms of settled contacts are taken, packed; see `pipeline/rows.rs`.
    pub stance: [u32; 2],
}

pub(crate) const KIND_MASK: u32 = 3;
pub(crate) const LOCKS_SHIFT: u32 = 8;
/// Mass was given, not computed from the shapes.
pub(crate) const GIVEN_MASS: u32 = 4;
/// The body became non-finite and was stopped for good.
pub(crate) const QUARANTINED: u32 = 8;
/// The sector changed since the shapes' boxes were made.
pub(crate) const CHANGED_SECTOR: u32 = 16;
/// A kinematic body reaches its target at the end of the coming step, and stops.
pub(crate) const STOPS_AFTER_STEP: u32 = 32;
/// The body sleeps: it is not solved, and stands for a static one until something wakes it.
pub(crate) const ASLEEP: u32 = 64;
/// The body was changed by a call: it wakes, and what touches it.
pub(crate) const WAKES: u32 = 128;
/// The body never sleeps, and keeps its island awake.
pub(crate) const SLEEPLESS: u32 = 1 << 14;
/// The body is stopped at dynamic bodies too when it is fast.
pub(crate) const BULLET: u32 = 1 << 15;
/// Bits of the number of steps that the body has been quiet.
pub(crate) const QUIET_SHIFT: u32 = 16;

impl BodyRow {
    #[inline(always)]
    pub fn kind(&self) -> BodyKind {
        match self.flags & KIND_MASK {
            0 => BodyKind::Static,
            1 => BodyKind::Kinematic,
            _ => BodyKind::Dynamic,
        }
    }

    #[inline(always)]
    pub fn is_dynamic(&self) -> bool {
        self.kind() == BodyKind::Dynamic
    }

    /// Dynamic and not asleep: it takes part in the solve.
    #[inline(always)]
    pub fn is_active(&self) -> bool {
        self.flags & (KIND_MASK | ASLEEP) == BodyKind::Dynamic as u32
    }

    /// Static or asleep: it stays where it is.
    #[inline(always)]
    pub fn rests(&self) -> bool {
        self.flags & ASLEEP != 0 || self.kind() == BodyKind::Static
    }

    /// Steps that the body has been quiet, at most 65535.
    #[inline(always)]
    pub fn quiet_steps(&self) -> u32 {
        self.flags >> QUIET_SHIFT
    }

    /// Counts a quiet step, or starts again.
    pub fn count_quiet(&mut self, is_quiet: bool) {
        let steps = if is_quiet { (self.quiet_steps() + 1).min(0xffff) } else { 0 };
        self.flags = self.flags & ((1 << QUIET_SHIFT) - 1) | steps << QUIET_SHIFT;
    }

    #[inline(always)]
    pub fn locks(&self) -> u8 {
        (self.flags >> LOCKS_SHIFT) as u8 & 63
    }

    #[inline(always)]
    pub fn has(&self, flag: u32) -> bool {
        self.flags & flag != 0
    }

    pub fn set_kind(&mut self, kind: BodyKind) {
        self.flags = (self.flags & !KIND_MASK) | kind as u32;
    }

    pub fn set_locks(&mut self, locks: AxisLocks) {
        self.flags = (self.flags & !(63 << LOCKS_SHIFT)) | (u32::from(locks.0) << LOCKS_SHIFT);
    }

    pub fn mass_properties(&self) -> MassProperties {
        MassProperties { mass: self.mass, center: self.local_center, inertia: self.inertia, axes: self.axes }
    }

    pub fn set_mass_properties(&mut self, mass: &MassProperties) {
        self.mass = mass.mass;
        self.local_center = mass.center;
        self.inertia = mass.inertia;
        self.axes = mass.axes;
    }
}

/// A local pose of a body with this rotation in world axes, relative to the center of mass.
#[inline]
pub(crate) fn turned_frame(rotation: Rotation, row: &BodyRow, local: &Pose) -> Pose {
    Pose::new(rotation.rotate(local.position - row.local_center), rotation.after(local.rotation))
}

impl Motion {
    /// The pose of the body's origin relative to its center of mass.
    #[inline]
    pub fn origin_offset(&self, row: &BodyRow) -> Vec3 {
        -self.rotation.rotate(row.local_center)
    }

    /// A local pose of the body in world axes, relative to the center of mass.
    #[inline]
    pub fn local_to_center(&self, row: &BodyRow, local: &Pose) -> Pose {
        turned_frame(self.rotation, row, local)
    }

    #[expect(clippy::eq_op, reason = "x - x tells finite numbers from the rest")]
    pub fn is_finite(&self) -> bool {
        // x - x is 0 for finite x and not a number for the rest, and so is the sum.
        let (p, q, v, w) = (self.center.offset, self.rotation, self.linear, self.angular);
        let off = (p - p) + (v - v) + (w - w);
        off.x + off.y + off.z + (q.x - q.x) + (q.y - q.y) + (q.z - q.z) + (q.w - q.w) == 0.0
    }
}
