//! Joints: what they hold, limit and drive of the motion of two bodies against each other.
//!
//! Every joint has a frame on each of its bodies. How B's frame stands in A's is told by six coordinates, three
//! shifts along A's axes and three turns, and each of them is free, held, limited or driven by itself. The kinds
//! that people know are choices of these; see the constructors of [`JointDef`].
//!
//! The turns are those of a gimbal: B's frame is A's turned about z, then about its own new y, then about its own
//! new x. So the turn about z is about A's z axis, the turn about x is about B's x axis, and the turn about y is
//! between them; at 90 degrees of y the other two become one, which is to be kept away from by limits.

mod check;
mod row;

use crate::handle::BodyHandle;
use crate::math::{Pose, Vec3};

pub(crate) use row::{AxisRow, BROKEN, COLLIDES, Joint, JointRow, LAGS, LEAPT, PLAIN_BALL, Signature};

/// A spring with its damper.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Spring {
    /// By what the eye sees, whatever the masses: a frequency, Hz, 0..=1e5, and a damping ratio, 0..=1000 (1 is
    /// critical).
    Frequency {
        /// Hz.
        hertz: f32,
        /// Share of critical damping.
        damping_ratio: f32,
    },
    /// By physics: N/m and N s/m, or N m/rad and N m s/rad; each 0..=1e12.
    Stiffness {
        /// Force for each metre, or torque for each radian.
        stiffness: f32,
        /// Force for each m/s, or torque for each rad/s.
        damping: f32,
    },
}

/// What pulls a coordinate towards a target.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drive {
    /// Where the spring rests, metres or radians, within ±1e5.
    pub target: f32,
    /// Speed that the damper wants, m/s or rad/s, within ±1e5.
    pub velocity: f32,
    /// The spring and damper; `None` holds the velocity as far as the force reaches, whatever the position.
    pub spring: Option<Spring>,
    /// Greatest force or torque, N or N m, not negative; infinity for no bound.
    pub max_force: f32,
}

impl Drive {
    /// A motor that holds a velocity, m/s or rad/s.
    pub const fn motor(velocity: f32, max_force: f32) -> Self {
        Self { target: 0.0, velocity, spring: None, max_force }
    }

    /// A spring that pulls to a position, metres or radians.
    pub const fn spring(target: f32, spring: Spring) -> Self {
        Self { target, velocity: 0.0, spring: Some(spring), max_force: f32::INFINITY }
    }
}

/// How far a coordinate may go.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum AxisMotion {
    /// Anywhere.
    #[default]
    Free,
    /// Not at all.
    Locked,
    /// Between two values, metres or radians, within ±1e5 and `lower <= upper`; infinite for no limit on that
    /// side. Turns count on beyond half a turn.
    Limited {
        /// Least.
        lower: f32,
        /// Greatest.
        upper: f32,
    },
}

/// One coordinate of a joint.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Axis {
    /// Its range.
    pub motion: AxisMotion,
    /// How a limit gives; `None` is hard.
    pub limit_spring: Option<Spring>,
    /// What moves it; of no effect where the axis is locked.
    pub drive: Option<Drive>,
    /// Force or torque of dry friction, N or N m, `0..=1e12`; of no effect where the axis is locked.
    pub friction: f32,
}

impl Axis {
    /// Free.
    pub const FREE: Self = Self { motion: AxisMotion::Free, limit_spring: None, drive: None, friction: 0.0 };
    /// Locked.
    pub const LOCKED: Self =
        Self { motion: AxisMotion::Locked, limit_spring: None, drive: None, friction: 0.0 };

    /// Limited, with hard limits.
    pub const fn limited(lower: f32, upper: f32) -> Self {
        Self { motion: AxisMotion::Limited { lower, upper }, ..Self::FREE }
    }
}

/// What the coordinates of a joint are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Coupling {
    /// How B's frame stands in A's: see the module.
    Frames,
    /// The distance of the frames' origins; only axis 0 is used, metres, not negative.
    Distance,
    /// Two turns: A's about the x axis of its frame plus `ratio` times B's about the x axis of its own stays as it
    /// is. No axis is used. Negative for gears that mesh inside.
    Gear {
        /// Teeth of B over teeth of A, within ±1e4, not 0.
        ratio: f32,
    },
    /// A turn and a shift: `ratio` times A's turn about the x axis of its frame goes with B's shift along the x
    /// axis of B's frame. No axis is used.
    Rack {
        /// Metres for each radian: the radius of the pinion, within ±1e4, not 0.
        ratio: f32,
    },
}

/// The axes of a joint, by index.
pub mod axis {
    /// Shift along A's x axis.
    pub const X: usize = 0;
    /// Shift along A's y axis.
    pub const Y: usize = 1;
    /// Shift along A's z axis.
    pub const Z: usize = 2;
    /// Turn about B's x axis.
    pub const TURN_X: usize = 3;
    /// Turn about the axis between.
    pub const TURN_Y: usize = 4;
    /// Turn about A's z axis.
    pub const TURN_Z: usize = 5;
}

/// What a new joint is like.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointDef {
    /// A and B. One at least must be dynamic for the joint to do anything.
    pub bodies: [BodyHandle; 2],
    /// The joint's frame on each body, in the body's frame; positions at most 1e5 m from its origin.
    pub frames: [Pose; 2],
    /// What the coordinates are.
    pub coupling: Coupling,
    /// What becomes of them: shifts along x, y, z and turns about x, y, z; see [`axis`].
    pub axes: [Axis; 6],
    /// Greatest angle between the x axes of the frames, radians, 0.01..=3.1; `None` for any. Together with free
    /// turns.
    pub cone: Option<f32>,
    /// How locked axes, gears and racks give; `None` is rigid.
    pub spring: Option<Spring>,
    /// Force on the joint at which it breaks, N, positive; infinity for never.
    pub break_force: f32,
    /// Torque at which it breaks, N m, positive; infinity for never.
    pub break_torque: f32,
    /// True when shapes of the two bodies meet all the same.
    pub bodies_collide: bool,
    /// Yours; part of the state.
    pub user: u64,
}

impl JointDef {
    /// All six coordinates free; to be filled in.
    pub const fn six_axis(bodies: [BodyHandle; 2], frames: [Pose; 2]) -> Self {
        Self {
            bodies,
            frames,
            coupling: Coupling::Frames,
            axes: [Axis::FREE; 6],
            cone: None,
            spring: None,
            break_force: f32::INFINITY,
            break_torque: f32::INFINITY,
            bodies_collide: false,
            user: 0,
        }
    }

    /// A point of one body stays on a point of the other.
    pub const fn ball(bodies: [BodyHandle; 2], frames: [Pose; 2]) -> Self {
        let mut def = Self::six_axis(bodies, frames);
        (def.axes[0], def.axes[1], def.axes[2]) = (Axis::LOCKED, Axis::LOCKED, Axis::LOCKED);
        def
    }

    /// B turns about the x axis of the frames. Limits and drives go on [`axis::TURN_X`].
    pub const fn hinge(bodies: [BodyHandle; 2], frames: [Pose; 2]) -> Self {
        let mut def = Self::ball(bodies, frames);
        (def.axes[4], def.axes[5]) = (Axis::LOCKED, Axis::LOCKED);
        def
    }

    /// B slides along the x axis of A's frame. Limits and drives go on [`axis::X`].
    pub const fn slider(bodies: [BodyHandle; 2], frames: [Pose; 2]) -> Self {
        let mut def = Self::fixed(bodies, frames);
        def.axes[0] = Axis::FREE;
        def
    }

    /// The two bodies move as one.
    pub const fn fixed(bodies: [BodyHandle; 2], frames: [Pose; 2]) -> Self {
        let mut def = Self::hinge(bodies, frames);
        def.axes[3] = Axis::LOCKED;
        def
    }

    /// Two points stay between `lower` and `upper` metres apart: a rope for `lower` 0, a rod for equal lengths, a
    /// spring with a drive on [`axis::X`].
    pub const fn distance(bodies: [BodyHandle; 2], points: [Vec3; 2], lower: f32, upper: f32) -> Self {
        use crate::math::Rotation;
        let frames = [Pose::new(points[0], Rotation::IDENTITY), Pose::new(points[1], Rotation::IDENTITY)];
        let mut def = Self::six_axis(bodies, frames);
        def.coupling = Coupling::Distance;
        def.axes[0] = Axis::limited(lower, upper);
        def.bodies_collide = true;
        def
    }

    /// A wheel B on a chassis A: it springs along the z axis of A's frame, spins about the x axis of its own, and
    /// steers about z where that axis is given another range. Suspension goes on [`axis::Z`], the motor on
    /// [`axis::TURN_X`], steering on [`axis::TURN_Z`].
    pub const fn wheel(bodies: [BodyHandle; 2], frames: [Pose; 2], suspension: Spring) -> Self {
        let mut def = Self::hinge(bodies, frames);
        def.axes[2] = Axis { drive: Some(Drive::spring(0.0, suspension)), ..Axis::FREE };
        def
    }

    /// Two wheels that mesh, on axes of their own joints: see [`Coupling::Gear`].
    pub const fn gear(bodies: [BodyHandle; 2], frames: [Pose; 2], ratio: f32) -> Self {
        let mut def = Self::six_axis(bodies, frames);
        def.coupling = Coupling::Gear { ratio };
        def.bodies_collide = true;
        def
    }

    /// A pinion A and a rack B, on axes of their own joints: see [`Coupling::Rack`].
    pub const fn rack(bodies: [BodyHandle; 2], frames: [Pose; 2], ratio: f32) -> Self {
        let mut def = Self::six_axis(bodies, frames);
        def.coupling = Coupling::Rack { ratio };
        def.bodies_collide = true;
        def
    }
}
