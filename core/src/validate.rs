//! Checks of arguments: one place for each kind of number.

use crate::body::Position;
use crate::config::SECTOR_MAX;
use crate::error::Error;
use crate::math::{Pose, Rotation, Vec3};

/// Greatest length of any shape and of any local position, metres.
pub(crate) const EXTENT_MAX: f32 = 1.0e5;
/// Least radius and least box half extent, metres.
pub(crate) const EXTENT_MIN: f32 = 1.0e-5;
/// Greatest speed that can be given to a body, m/s and rad/s.
pub(crate) const SPEED_MAX: f32 = 1.0e6;

pub(crate) fn in_range(name: &'static str, x: f32, low: f32, high: f32) -> Result<(), Error> {
    if !x.is_finite() {
        return Err(Error::NotFinite { name });
    }
    if x < low || x > high { Err(Error::OutOfRange { name }) } else { Ok(()) }
}

pub(crate) fn count_in_range(name: &'static str, x: u32, low: u32, high: u32) -> Result<(), Error> {
    if x < low || x > high { Err(Error::OutOfRange { name }) } else { Ok(()) }
}

/// Each component at most `limit` in size.
pub(crate) fn vector_within(name: &'static str, v: Vec3, limit: f32) -> Result<(), Error> {
    in_range(name, v.x, -limit, limit)?;
    in_range(name, v.y, -limit, limit)?;
    in_range(name, v.z, -limit, limit)
}

pub(crate) fn rotation(name: &'static str, q: Rotation) -> Result<(), Error> {
    if !q.is_finite() {
        return Err(Error::NotFinite { name });
    }
    if (q.norm_squared() - 1.0).abs() > 2.0e-3 { Err(Error::NotARotation { name }) } else { Ok(()) }
}

pub(crate) fn pose(name: &'static str, pose: &Pose) -> Result<(), Error> {
    vector_within(name, pose.position, EXTENT_MAX)?;
    rotation(name, pose.rotation)
}

/// A position with its offset inside its sector's reach.
pub(crate) fn position(name: &'static str, p: &Position) -> Result<(), Error> {
    vector_within(name, p.offset, 1.0e9)?;
    if p.sector.iter().any(|s| s.unsigned_abs() > SECTOR_MAX as u32) {
        return Err(Error::OutOfRange { name });
    }
    Ok(())
}
