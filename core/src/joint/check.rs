//! What a definition of a joint may hold.

use super::{Axis, AxisMotion, Coupling, Drive, JointDef, Spring};
use crate::error::Error;
use crate::validate;

/// Greatest coordinate and velocity of a joint, m or rad.
const COORDINATE_MAX: f32 = 1.0e5;
/// Greatest stiffness, damping and friction.
const EFFORT_MAX: f32 = 1.0e12;
/// Greatest ratio of gears and racks.
const RATIO_MAX: f32 = 1.0e4;

impl Spring {
    /// Refuses numbers that are not finite or out of the documented ranges.
    pub fn check(&self) -> Result<(), Error> {
        match *self {
            Spring::Frequency { hertz, damping_ratio } => {
                validate::in_range("hertz", hertz, 0.0, 1.0e5)?;
                validate::in_range("damping_ratio", damping_ratio, 0.0, 1.0e3)
            }
            Spring::Stiffness { stiffness, damping } => {
                validate::in_range("stiffness", stiffness, 0.0, EFFORT_MAX)?;
                validate::in_range("damping", damping, 0.0, EFFORT_MAX)
            }
        }
    }
}

impl Drive {
    /// Refuses numbers that are not finite or out of the documented ranges.
    pub fn check(&self) -> Result<(), Error> {
        validate::in_range("target", self.target, -COORDINATE_MAX, COORDINATE_MAX)?;
        validate::in_range("velocity", self.velocity, -COORDINATE_MAX, COORDINATE_MAX)?;
        self.spring.as_ref().map_or(Ok(()), Spring::check)?;
        not_negative("max_force", self.max_force)
    }
}

impl Axis {
    /// Refuses numbers that are not finite or out of the documented ranges.
    pub fn check(&self) -> Result<(), Error> {
        if let AxisMotion::Limited { lower, upper } = self.motion {
            if lower.is_nan() || upper.is_nan() {
                return Err(Error::NotFinite { name: "lower, upper" });
            }
            let inside = |x: f32| x.is_infinite() || x.abs() <= COORDINATE_MAX;
            let ordered = lower <= upper && lower < f32::INFINITY && upper > f32::NEG_INFINITY;
            if !ordered || !inside(lower) || !inside(upper) {
                return Err(Error::OutOfRange { name: "lower, upper" });
            }
        }
        self.limit_spring.as_ref().map_or(Ok(()), Spring::check)?;
        self.drive.as_ref().map_or(Ok(()), Drive::check)?;
        validate::in_range("friction", self.friction, 0.0, EFFORT_MAX)
    }
}

impl JointDef {
    /// Refuses numbers that are not finite or out of the documented ranges. Handles are checked by the world.
    pub fn check(&self) -> Result<(), Error> {
        self.frames.iter().try_for_each(|frame| validate::pose("frames", frame))?;
        self.axes.iter().try_for_each(Axis::check)?;
        if let Coupling::Gear { ratio } | Coupling::Rack { ratio } = self.coupling {
            validate::in_range("ratio", ratio, -RATIO_MAX, RATIO_MAX)?;
            if ratio.abs() < 1.0 / RATIO_MAX {
                return Err(Error::OutOfRange { name: "ratio" });
            }
        }
        if let Some(cone) = self.cone {
            validate::in_range("cone", cone, 0.01, 3.1)?;
        }
        self.spring.as_ref().map_or(Ok(()), Spring::check)?;
        positive("break_force", self.break_force)?;
        positive("break_torque", self.break_torque)
    }
}

fn not_negative(name: &'static str, x: f32) -> Result<(), Error> {
    if x.is_nan() {
        return Err(Error::NotFinite { name });
    }
    if x >= 0.0 { Ok(()) } else { Err(Error::OutOfRange { name }) }
}

fn positive(name: &'static str, x: f32) -> Result<(), Error> {
    not_negative(name, x)?;
    if x > 0.0 { Ok(()) } else { Err(Error::OutOfRange { name }) }
}
