//! Joints: how they are created, read and changed.

use crate::border::{change, make, read, there};
use crate::error::{CsResult, Failure};
use crate::types::{CsBody, CsJoint, CsPose, CsVec3};
use crate::world::CsWorld;
use cellstep::{Axis, AxisMotion, Coupling, Drive, Error, JointDef, Spring};
use std::mem::MaybeUninit;

/// No spring.
pub const CS_SPRING_NONE: u32 = 0;
/// `first`: Hz, `second`: damping ratio.
pub const CS_SPRING_FREQUENCY: u32 = 1;
/// `first`: stiffness, N/m or N m/rad, `second`: damping, N s/m or N m s/rad.
pub const CS_SPRING_STIFFNESS: u32 = 2;

/// A spring with its damper, or none.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CsSpring {
    /// `CS_SPRING_*`.
    pub kind: u32,
    /// By `kind`.
    pub first: f32,
    /// By `kind`.
    pub second: f32,
}

impl CsSpring {
    fn read(&self) -> Result<Option<Spring>, Failure> {
        match self.kind {
            CS_SPRING_NONE => Ok(None),
            CS_SPRING_FREQUENCY => {
                Ok(Some(Spring::Frequency { hertz: self.first, damping_ratio: self.second }))
            }
            CS_SPRING_STIFFNESS => {
                Ok(Some(Spring::Stiffness { stiffness: self.first, damping: self.second }))
            }
            _ => Err(Failure::UnknownKind("spring")),
        }
    }
}

/// An axis that goes anywhere.
pub const CS_AXIS_FREE: u32 = 0;
/// An axis that does not move.
pub const CS_AXIS_LOCKED: u32 = 1;
/// An axis that moves between `lower` and `upper`.
pub const CS_AXIS_LIMITED: u32 = 2;

/// One coordinate of a joint: a shift in metres or a turn in radians. All zero for a free one.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CsAxis {
    /// `CS_AXIS_*`.
    pub motion: u32,
    /// Least, metres or radians; `-INFINITY` for no limit on that side.
    pub lower: f32,
    /// Greatest, metres or radians; `INFINITY` for no limit on that side.
    pub upper: f32,
    /// How a limit gives.
    pub limit_spring: CsSpring,
    /// 1 when it is driven.
    pub has_drive: u32,
    /// Where the drive's spring rests.
    pub target: f32,
    /// Speed that the drive wants.
    pub velocity: f32,
    /// Without one the drive holds the velocity.
    pub drive_spring: CsSpring,
    /// Greatest force or torque of the drive, N or N m; `INFINITY` for no bound.
    pub max_force: f32,
    /// Force or torque of dry friction.
    pub friction: f32,
}

impl CsAxis {
    fn read(&self) -> Result<Axis, Failure> {
        let motion = match self.motion {
            CS_AXIS_FREE => AxisMotion::Free,
            CS_AXIS_LOCKED => AxisMotion::Locked,
            CS_AXIS_LIMITED => AxisMotion::Limited { lower: self.lower, upper: self.upper },
            _ => return Err(Failure::UnknownKind("motion")),
        };
        let spring = self.drive_spring.read()?;
        let drive = Drive { target: self.target, velocity: self.velocity, spring, max_force: self.max_force };
        Ok(Axis {
            motion,
            limit_spring: self.limit_spring.read()?,
            drive: (self.has_drive != 0).then_some(drive),
            friction: self.friction,
        })
    }
}

/// The six coordinates are where B's frame stands in A's: shifts along A's x, y, z and turns about B's x, the axis
/// between, A's z.
pub const CS_COUPLING_FRAMES: u32 = 0;
/// Axis 0 is the distance of the frames' origins; no other is used.
pub const CS_COUPLING_DISTANCE: u32 = 1;
/// A's turn about its frame's x plus `ratio` times B's stays as it is.
pub const CS_COUPLING_GEAR: u32 = 2;
/// `ratio` times A's turn about its frame's x goes with B's shift along its frame's x.
pub const CS_COUPLING_RACK: u32 = 3;

/// What a new joint is like; start from `cs_joint_ball`, `cs_joint_hinge` and their like.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CsJointDef {
    /// A and B.
    pub bodies: [CsBody; 2],
    /// The joint's frame on each body.
    pub frames: [CsPose; 2],
    /// `CS_COUPLING_*`.
    pub coupling: u32,
    /// Of a gear or a rack.
    pub ratio: f32,
    /// Shifts along x, y, z and turns about x, y, z.
    pub axes: [CsAxis; 6],
    /// Greatest angle between the x axes of the frames, radians; 0 for any.
    pub cone: f32,
    /// How locked axes give; none for a rigid joint.
    pub spring: CsSpring,
    /// N; `INFINITY` for never.
    pub break_force: f32,
    /// N m; `INFINITY` for never.
    pub break_torque: f32,
    /// 1 when shapes of the two bodies meet all the same.
    pub bodies_collide: u32,
    /// Yours; part of the state.
    pub user: u64,
}

impl CsJointDef {
    fn read(&self) -> Result<JointDef, Failure> {
        let ratio = self.ratio;
        let mut axes = [Axis::FREE; 6];
        for (axis, own) in axes.iter_mut().zip(&self.axes) {
            *axis = own.read()?;
        }
        Ok(JointDef {
            bodies: self.bodies.map(Into::into),
            frames: self.frames.map(Into::into),
            coupling: match self.coupling {
                CS_COUPLING_FRAMES => Coupling::Frames,
                CS_COUPLING_DISTANCE => Coupling::Distance,
                CS_COUPLING_GEAR => Coupling::Gear { ratio },
                CS_COUPLING_RACK => Coupling::Rack { ratio },
                _ => return Err(Failure::UnknownKind("coupling")),
            },
            axes,
            cone: (self.cone != 0.0).then_some(self.cone),
            spring: self.spring.read()?,
            break_force: self.break_force,
            break_torque: self.break_torque,
            bodies_collide: self.bodies_collide != 0,
            user: self.user,
        })
    }

    /// With these axes locked, from the first bit on.
    fn locking(bodies: [CsBody; 2], frames: [CsPose; 2], locked: u32) -> Self {
        let axis = |i: usize| CsAxis { motion: locked >> i & 1, ..CsAxis::default() };
        Self {
            bodies,
            frames,
            coupling: CS_COUPLING_FRAMES,
            ratio: 0.0,
            axes: core::array::from_fn(axis),
            cone: 0.0,
            spring: CsSpring::default(),
            break_force: f32::INFINITY,
            break_torque: f32::INFINITY,
            bodies_collide: 0,
            user: 0,
        }
    }
}

const _: () = assert!(CS_AXIS_FREE == 0 && CS_AXIS_LOCKED == 1);

/// All six coordinates are free.
#[unsafe(no_mangle)]
pub extern "C" fn cs_joint_six_axis(a: CsBody, b: CsBody, on_a: CsPose, on_b: CsPose) -> CsJointDef {
    CsJointDef::locking([a, b], [on_a, on_b], 0)
}

/// A point of one body stays on a point of the other.
#[unsafe(no_mangle)]
pub extern "C" fn cs_joint_ball(a: CsBody, b: CsBody, on_a: CsPose, on_b: CsPose) -> CsJointDef {
    CsJointDef::locking([a, b], [on_a, on_b], 0b000_111)
}

/// B turns about the x axis of the frames: limits and drives go on axis 3.
#[unsafe(no_mangle)]
pub extern "C" fn cs_joint_hinge(a: CsBody, b: CsBody, on_a: CsPose, on_b: CsPose) -> CsJointDef {
    CsJointDef::locking([a, b], [on_a, on_b], 0b110_111)
}

/// B slides along the x axis of A's frame: limits and drives go on axis 0.
#[unsafe(no_mangle)]
pub extern "C" fn cs_joint_slider(a: CsBody, b: CsBody, on_a: CsPose, on_b: CsPose) -> CsJointDef {
    CsJointDef::locking([a, b], [on_a, on_b], 0b111_110)
}

/// The two bodies move as one.
#[unsafe(no_mangle)]
pub extern "C" fn cs_joint_fixed(a: CsBody, b: CsBody, on_a: CsPose, on_b: CsPose) -> CsJointDef {
    CsJointDef::locking([a, b], [on_a, on_b], 0b111_111)
}

/// The frames' origins stay between `lower` and `upper` metres apart.
#[unsafe(no_mangle)]
pub extern "C" fn cs_joint_distance(
    a: CsBody,
    b: CsBody,
    on_a: CsPose,
    on_b: CsPose,
    lower: f32,
    upper: f32,
) -> CsJointDef {
    let mut def = CsJointDef::locking([a, b], [on_a, on_b], 0);
    def.coupling = CS_COUPLING_DISTANCE;
    def.axes[0] = CsAxis { motion: CS_AXIS_LIMITED, lower, upper, ..CsAxis::default() };
    def.bodies_collide = 1;
    def
}

/// A wheel B on a chassis A: it springs along the z axis of A's frame (axis 2), spins about x (axis 3), and steers
/// about z where axis 5 is given another range.
#[unsafe(no_mangle)]
pub extern "C" fn cs_joint_wheel(
    a: CsBody,
    b: CsBody,
    on_a: CsPose,
    on_b: CsPose,
    suspension: CsSpring,
) -> CsJointDef {
    let mut def = CsJointDef::locking([a, b], [on_a, on_b], 0b110_011);
    (def.axes[2].has_drive, def.axes[2].drive_spring) = (1, suspension);
    def.axes[2].max_force = f32::INFINITY;
    def
}

/// Creates a joint.
#[unsafe(no_mangle)]
pub extern "C" fn cs_joint_create(
    world: Option<&mut CsWorld>,
    def: Option<&CsJointDef>,
    out: Option<&mut MaybeUninit<CsJoint>>,
) -> CsResult {
    make(world, out, |world| Ok(world.create_joint(&there(def, "def")?.read()?)?.into()))
}

/// Removes a joint.
#[unsafe(no_mangle)]
pub extern "C" fn cs_joint_remove(world: Option<&mut CsWorld>, joint: CsJoint) -> CsResult {
    change(world, |world| Ok(world.remove_joint(joint.into())?))
}

/// Makes a joint like another def, with the same bodies.
#[unsafe(no_mangle)]
pub extern "C" fn cs_joint_set(
    world: Option<&mut CsWorld>,
    joint: CsJoint,
    def: Option<&CsJointDef>,
) -> CsResult {
    change(world, |world| Ok(world.set_joint(joint.into(), &there(def, "def")?.read()?)?))
}

/// Changes one axis, 0..=5.
#[unsafe(no_mangle)]
pub extern "C" fn cs_joint_set_axis(
    world: Option<&mut CsWorld>,
    joint: CsJoint,
    index: u32,
    axis: Option<&CsAxis>,
) -> CsResult {
    change(world, |world| {
        let axis = there(axis, "axis")?.read()?;
        if index > 5 {
            return Err(Error::OutOfRange { name: "index" }.into());
        }
        Ok(world.set_joint_axis(joint.into(), index as usize, &axis)?)
    })
}

/// 1 when the joint is broken, else 0.
#[unsafe(no_mangle)]
pub extern "C" fn cs_joint_is_broken(
    world: Option<&CsWorld>,
    joint: CsJoint,
    out: Option<&mut MaybeUninit<u32>>,
) -> CsResult {
    read(world, out, |world| Ok(world.is_broken(joint.into())?.into()))
}

/// Force of the joint on B in the last substep, N.
#[unsafe(no_mangle)]
pub extern "C" fn cs_joint_force(
    world: Option<&CsWorld>,
    joint: CsJoint,
    out: Option<&mut MaybeUninit<CsVec3>>,
) -> CsResult {
    read(world, out, |world| Ok(world.joint_force(joint.into())?.into()))
}

/// Torque of the joint on B in the last substep, N m.
#[unsafe(no_mangle)]
pub extern "C" fn cs_joint_torque(
    world: Option<&CsWorld>,
    joint: CsJoint,
    out: Option<&mut MaybeUninit<CsVec3>>,
) -> CsResult {
    read(world, out, |world| Ok(world.joint_torque(joint.into())?.into()))
}

/// The six coordinates of a joint.
#[unsafe(no_mangle)]
pub extern "C" fn cs_joint_coordinates(
    world: Option<&CsWorld>,
    joint: CsJoint,
    out: Option<&mut MaybeUninit<CsCoordinates>>,
) -> CsResult {
    read(world, out, |world| Ok(CsCoordinates { values: world.joint_coordinates(joint.into())? }))
}

/// The coordinates of a joint: shifts along x, y, z, metres, and turns about x, y, z, radians.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CsCoordinates {
    /// By axis.
    pub values: [f32; 6],
}
