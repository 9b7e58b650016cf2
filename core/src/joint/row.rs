//! A joint in the state.

use super::axis::TURN_Y;
use super::{Axis, AxisMotion, Coupling, Drive, JointDef, Spring};
use crate::cells::UNORDERED;
use crate::handle::BodyHandle;
use crate::math::{PI, Pose, Vec3};
use core::ops::{Deref, DerefMut};

use bytemuck::{Pod, Zeroable};

/// A spring in the state: `SPRING_*`, then its two numbers.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub(crate) struct SpringRow {
    kind: u32,
    numbers: [f32; 2],
}

const SPRING_NONE: u32 = 0;
const SPRING_FREQUENCY: u32 = 1;
const SPRING_STIFFNESS: u32 = 2;

/// How a row gives: the implicit spring and damper over a substep.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Softener {
    /// Rate for each unit of error, 1/s.
    pub rate: f32,
    /// Share of a wanted velocity that the damper gives.
    pub damping: f32,
    /// Rate that the row allows for each unit of impulse.
    pub give: f32,
}

impl SpringRow {
    fn new(spring: Option<Spring>) -> Self {
        match spring {
            None => Self::default(),
            Some(Spring::Frequency { hertz, damping_ratio }) => {
                Self { kind: SPRING_FREQUENCY, numbers: [hertz, damping_ratio] }
            }
            Some(Spring::Stiffness { stiffness, damping }) => {
                Self { kind: SPRING_STIFFNESS, numbers: [stiffness, damping] }
            }
        }
    }

    /// The spring as defined; `None` for a row that no definition makes.
    fn read(&self) -> Option<Option<Spring>> {
        let [first, second] = self.numbers;
        Some(match self.kind {
            SPRING_NONE if self.numbers == [0.0; 2] => None,
            SPRING_FREQUENCY => Some(Spring::Frequency { hertz: first, damping_ratio: second }),
            SPRING_STIFFNESS => Some(Spring::Stiffness { stiffness: first, damping: second }),
            _ => return None,
        })
    }

    /// True for a spring, however stiff.
    pub fn gives(&self) -> bool {
        self.kind != SPRING_NONE
    }

    /// How a row gives that changes its rate by `yields` for each unit of impulse, over a substep of `h` seconds:
    /// with stiffness k and damping c, `(c + h k) (rate + give impulse) = k error + c velocity`. `None` without a
    /// spring; a give of infinity where there is neither stiffness nor damping.
    pub fn softener(&self, yields: f32, h: f32) -> Option<Softener> {
        let (k, c) = match self.kind {
            SPRING_NONE => return None,
            SPRING_STIFFNESS => (self.numbers[0], self.numbers[1]),
            _ => {
                let (w, mass) = (2.0 * PI * self.numbers[0], if yields > 0.0 { 1.0 / yields } else { 0.0 });
                (mass * w * w, 2.0 * mass * self.numbers[1] * w)
            }
        };
        let s = c + h * k;
        if s > f32::MIN_POSITIVE {
            Some(Softener { rate: k / s, damping: c / s, give: 1.0 / (h * s) })
        } else {
            Some(Softener { rate: 0.0, damping: 0.0, give: f32::INFINITY })
        }
    }
}

/// One coordinate of a joint in the state.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub(crate) struct AxisRow {
    /// `MOTION_*`, and `DRIVEN`.
    pub flags: u32,
    pub lower: f32,
    pub upper: f32,
    pub limit_spring: SpringRow,
    pub target: f32,
    pub velocity: f32,
    pub drive_spring: SpringRow,
    pub max_force: f32,
    pub friction: f32,
    /// A turn as it was last, radians, counted on over half turns; 0 for shifts.
    pub turn: f32,
    /// Impulses of a substep, N s or N m s: of the limit (positive at the lower one), the drive, the friction.
    pub limit_impulse: f32,
    pub drive_impulse: f32,
    pub friction_impulse: f32,
}

const MOTION_MASK: u32 = 3;
const MOTION_FREE: u32 = 0;
const MOTION_LOCKED: u32 = 1;
const MOTION_LIMITED: u32 = 2;
const DRIVEN: u32 = 4;

impl AxisRow {
    /// Takes over a definition; impulses and the turn stay.
    pub fn define(&mut self, axis: &Axis) {
        let (motion, lower, upper) = match axis.motion {
            AxisMotion::Free => (MOTION_FREE, 0.0, 0.0),
            AxisMotion::Locked => (MOTION_LOCKED, 0.0, 0.0),
            AxisMotion::Limited { lower, upper } => (MOTION_LIMITED, lower, upper),
        };
        (self.flags, self.lower, self.upper) = (motion, lower, upper);
        self.limit_spring = SpringRow::new(axis.limit_spring);
        self.friction = axis.friction;
        let none = Drive::motor(0.0, 0.0);
        let drive = axis.drive.as_ref().unwrap_or(&none);
        (self.target, self.velocity, self.max_force) = (drive.target, drive.velocity, drive.max_force);
        self.drive_spring = SpringRow::new(drive.spring);
        if axis.drive.is_some() {
            self.flags |= DRIVEN;
        }
    }

    /// The axis as defined; `None` for a row that no definition makes.
    pub fn read(&self) -> Option<Axis> {
        let motion = match self.flags & MOTION_MASK {
            MOTION_FREE if (self.lower, self.upper) == (0.0, 0.0) => AxisMotion::Free,
            MOTION_LOCKED if (self.lower, self.upper) == (0.0, 0.0) => AxisMotion::Locked,
            MOTION_LIMITED => AxisMotion::Limited { lower: self.lower, upper: self.upper },
            _ => return None,
        };
        let drive = Drive {
            target: self.target,
            velocity: self.velocity,
            spring: self.drive_spring.read()?,
            max_force: self.max_force,
        };
        let driven = self.flags & DRIVEN != 0;
        if self.flags > MOTION_MASK + DRIVEN || !driven && drive != Drive::motor(0.0, 0.0) {
            return None;
        }
        Some(Axis {
            motion,
            limit_spring: self.limit_spring.read()?,
            drive: driven.then_some(drive),
            friction: self.friction,
        })
    }

    /// Held: locked, or limited to one value without a spring.
    fn is_held(&self) -> bool {
        match self.flags & MOTION_MASK {
            MOTION_LOCKED => true,
            MOTION_LIMITED => self.lower == self.upper && self.limit_spring.kind == SPRING_NONE,
            _ => false,
        }
    }

    /// Limited on some side.
    fn is_limited(&self) -> bool {
        self.flags & MOTION_MASK == MOTION_LIMITED && (self.lower.is_finite() || self.upper.is_finite())
    }

    pub fn is_finite(&self) -> bool {
        [self.turn, self.limit_impulse, self.drive_impulse, self.friction_impulse]
            .iter()
            .all(|x| x.is_finite())
    }

    /// Forgets what was pressed.
    pub fn forget(&mut self) {
        (self.limit_impulse, self.drive_impulse, self.friction_impulse) = (0.0, 0.0, 0.0);
    }

    /// True when a drive pulls to a position.
    pub fn has_position_drive(&self) -> bool {
        self.flags & DRIVEN != 0 && self.drive_spring.kind != SPRING_NONE
    }
}

/// A joint in the state.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub(crate) struct JointRow {
    /// Yours.
    pub user: u64,
    /// Slots of bodies A and B.
    pub bodies: [u32; 2],
    /// Next joint of each body: its slot plus 1, or 0.
    pub next: [u32; 2],
    /// `COUPLING_*` and the flags below.
    pub flags: u32,
    /// Phase in the ordering, or `UNORDERED` for a joint that is no link.
    pub phase: u32,
    /// [`Signature`]: which rows the joint has in the solver. It follows from the definition.
    pub signature: u32,
    pub break_force: f32,
    pub break_torque: f32,
    /// Frames in the bodies' frames.
    pub frames: [Pose; 2],
    pub spring: SpringRow,
    /// Impulses of the held rows in a substep, N s or N m s.
    pub impulses: [f32; 6],
    /// Force and torque about the joint's point, on body B, in the last substep; N, N m, in the world.
    pub force: Vec3,
    pub torque: Vec3,
    /// Of gears and racks.
    pub ratio: f32,
    /// Cosine side of the cone: its half angle, radians; 0 without.
    pub cone: f32,
    pub cone_impulse: f32,
    /// How far a gear or a rack has slipped, rad or m.
    pub slip: f32,
}

/// A joint's row and its axes. These lie apart in the state: a step has no need of the axes of joints that hold or
/// leave them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Joint {
    pub row: JointRow,
    pub axes: [AxisRow; 6],
}

impl Deref for Joint {
    type Target = JointRow;

    fn deref(&self) -> &JointRow {
        &self.row
    }
}

impl DerefMut for Joint {
    fn deref_mut(&mut self) -> &mut JointRow {
        &mut self.row
    }
}

pub(crate) const COUPLING_MASK: u32 = 3;
const COUPLING_FRAMES: u32 = 0;
const COUPLING_DISTANCE: u32 = 1;
const COUPLING_GEAR: u32 = 2;
const COUPLING_RACK: u32 = 3;
/// Shapes of the two bodies meet.
pub(crate) const COLLIDES: u32 = 4;
/// The joint broke: it holds nothing any more.
pub(crate) const BROKEN: u32 = 8;
/// There is a cone.
pub(crate) const CONE: u32 = 16;
/// Holds its points together rigidly, and nothing else.
pub(crate) const PLAIN_BALL: u32 = 32;
/// The bodies leapt in the last step: their velocities are of its end. See `pipeline/leapfrog.rs`.
pub(crate) const LEAPT: u32 = 64;
/// They did not: their velocities are half a substep's gravity behind.
pub(crate) const LAGS: u32 = 128;
const FLAGS_ALL: u32 = COUPLING_MASK | COLLIDES | BROKEN | CONE | PLAIN_BALL | LEAPT | LAGS;

impl JointRow {
    /// The next joint in the list of one of its bodies: its slot plus 1, or 0.
    pub fn next_of(&self, body: u32) -> u32 {
        self.next[self.end_of(body)]
    }

    /// The same, to change.
    pub fn next_of_mut(&mut self, body: u32) -> &mut u32 {
        &mut self.next[self.end_of(body)]
    }

    fn end_of(&self, body: u32) -> usize {
        usize::from(self.bodies[0] != body)
    }

    pub fn has(&self, flag: u32) -> bool {
        self.flags & flag != 0
    }

    /// Forgets what was pressed: for a joint that was changed or put elsewhere.
    pub fn forget(&mut self) {
        (self.impulses, self.cone_impulse) = ([0.0; 6], 0.0);
        (self.force, self.torque) = (Vec3::ZERO, Vec3::ZERO);
    }

    pub fn is_finite(&self) -> bool {
        self.impulses.iter().all(|x| x.is_finite())
            && self.cone_impulse.is_finite()
            && self.slip.is_finite()
            && self.force.is_finite()
            && self.torque.is_finite()
    }

    /// Which rows the joint has in the solver.
    pub fn signature(&self) -> Signature {
        Signature(self.signature)
    }
}

impl Joint {
    /// A joint between two slots, in no list and no phase.
    pub fn new(bodies: [u32; 2], def: &JointDef) -> Self {
        let mut row = Self { row: JointRow::zeroed(), axes: [AxisRow::zeroed(); 6] };
        row.bodies = bodies;
        row.phase = u32::from(UNORDERED);
        row.user = def.user;
        row.frames = def.frames.map(|frame| Pose::new(frame.position, frame.rotation.normalized()));
        for (row, axis) in row.axes.iter_mut().zip(&def.axes) {
            row.define(axis);
        }
        let (coupling, ratio) = match def.coupling {
            Coupling::Frames => (COUPLING_FRAMES, 0.0),
            Coupling::Distance => (COUPLING_DISTANCE, 0.0),
            Coupling::Gear { ratio } => (COUPLING_GEAR, ratio),
            Coupling::Rack { ratio } => (COUPLING_RACK, ratio),
        };
        (row.flags, row.ratio) = (coupling, ratio);
        if def.bodies_collide {
            row.flags |= COLLIDES;
        }
        if let Some(cone) = def.cone {
            row.flags |= CONE;
            row.cone = cone;
        }
        row.spring = SpringRow::new(def.spring);
        (row.break_force, row.break_torque) = (def.break_force, def.break_torque);
        row.derive();
        row
    }

    /// Changes an axis; what was pressed by rows that the joint does not have any more is forgotten.
    pub fn define_axis(&mut self, index: usize, axis: &Axis) {
        self.axes[index].define(axis);
        self.derive();
        self.drop_unused();
    }

    /// The joint as defined, between bodies with these handles; `None` for a row that no definition makes.
    pub fn read(&self, bodies: [BodyHandle; 2]) -> Option<JointDef> {
        let coupling = match self.flags & COUPLING_MASK {
            COUPLING_FRAMES if self.ratio == 0.0 => Coupling::Frames,
            COUPLING_DISTANCE if self.ratio == 0.0 => Coupling::Distance,
            COUPLING_GEAR => Coupling::Gear { ratio: self.ratio },
            COUPLING_RACK => Coupling::Rack { ratio: self.ratio },
            _ => return None,
        };
        let has_cone = self.flags & CONE != 0;
        let mut derived = *self;
        derived.derive();
        if self.flags > FLAGS_ALL
            || self.flags & (LEAPT | LAGS) == LEAPT | LAGS
            || !has_cone && self.cone != 0.0
            || (derived.signature, derived.flags) != (self.signature, self.flags)
        {
            return None;
        }
        let mut axes = [Axis::FREE; 6];
        for (axis, row) in axes.iter_mut().zip(&self.axes) {
            *axis = row.read()?;
        }
        Some(JointDef {
            bodies,
            frames: self.frames,
            coupling,
            axes,
            cone: has_cone.then_some(self.cone),
            spring: self.spring.read()?,
            break_force: self.break_force,
            break_torque: self.break_torque,
            bodies_collide: self.flags & COLLIDES != 0,
            user: self.user,
        })
    }

    /// Takes over what another row of the same joint has gathered, as far as their rows are the same.
    pub fn carry_over(&mut self, old: &Self) {
        (self.next, self.phase) = (old.next, old.phase);
        self.flags |= old.flags & (BROKEN | LEAPT | LAGS);
        for (axis, before) in self.axes.iter_mut().zip(&old.axes) {
            axis.turn = before.turn;
        }
        if self.signature() == old.signature() {
            for (axis, before) in self.axes.iter_mut().zip(&old.axes) {
                axis.limit_impulse = before.limit_impulse;
                axis.drive_impulse = before.drive_impulse;
                axis.friction_impulse = before.friction_impulse;
            }
            (self.impulses, self.cone_impulse) = (old.impulses, old.cone_impulse);
            (self.slip, self.force, self.torque) = (old.slip, old.force, old.torque);
        }
    }

    /// Zeroes impulses of rows that the joint does not have.
    fn drop_unused(&mut self) {
        let signature = self.signature();
        let has = |bits: u32, axis: usize| bits >> axis & 1 != 0;
        for (i, (axis, held)) in self.axes.iter_mut().zip(&mut self.row.impulses).enumerate() {
            let keep = |kept: bool, impulse: &mut f32| *impulse = if kept { *impulse } else { 0.0 };
            keep(has(signature.held(), i) || (i == 0 && signature.lock_rows() == 1), held);
            keep(has(signature.limited(), i), &mut axis.limit_impulse);
            keep(has(signature.driven(), i), &mut axis.drive_impulse);
            keep(has(signature.rubbing(), i), &mut axis.friction_impulse);
        }
    }

    /// Writes what follows from the definition.
    fn derive(&mut self) {
        self.signature = self.derived_signature().0;
        let at_zero = self.axes[..3].iter().all(|axis| axis.lower == 0.0);
        let plain = self.signature == Signature::BALL.0 && at_zero && self.spring.kind == SPRING_NONE;
        self.flags = self.flags & !PLAIN_BALL | if plain { PLAIN_BALL } else { 0 };
    }

    fn derived_signature(&self) -> Signature {
        let coupling = self.flags & COUPLING_MASK;
        let mut bits = coupling << 25;
        let axes = match coupling {
            COUPLING_FRAMES => 6,
            COUPLING_DISTANCE => 1,
            _ => 0,
        };
        for (i, axis) in self.axes[..axes].iter().enumerate() {
            // The middle turn is held at 0 only: elsewhere its sine is no measure of its error.
            if axis.is_held() && (i != TURN_Y || axis.lower == 0.0) {
                bits |= 1 << i;
                continue;
            }
            bits |= u32::from(axis.is_limited()) << (6 + i)
                | u32::from(axis.flags & DRIVEN != 0) << (12 + i)
                | u32::from(axis.friction > 0.0) << (18 + i);
        }
        if coupling == COUPLING_FRAMES && self.has(CONE) {
            bits |= 1 << 24;
        }
        Signature(bits)
    }
}

/// The rows of a joint: 6 bits each for held, limited, driven and rubbing axes, one for the cone, two for the
/// coupling. Joints side by side in lanes have the same.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Signature(pub u32);

impl Signature {
    /// Three shifts that are held.
    pub const BALL: Self = Self(7);
    /// In the solver: a plain ball, which has a row of its own format. No joint that holds anything has it.
    pub const PLAIN: Self = Self(0);

    /// The signature in a link's kind, which may say its tier too.
    pub fn of_kind(kind: u32) -> Self {
        Self(kind & ((1 << 27) - 1))
    }

    pub fn held(self) -> u32 {
        self.0 & 63
    }

    pub fn limited(self) -> u32 {
        self.0 >> 6 & 63
    }

    pub fn driven(self) -> u32 {
        self.0 >> 12 & 63
    }

    pub fn rubbing(self) -> u32 {
        self.0 >> 18 & 63
    }

    pub fn has_cone(self) -> bool {
        self.0 >> 24 & 1 != 0
    }

    pub fn is_distance(self) -> bool {
        self.0 >> 25 == COUPLING_DISTANCE
    }

    pub fn is_gear(self) -> bool {
        self.0 >> 25 == COUPLING_GEAR
    }

    pub fn is_rack(self) -> bool {
        self.0 >> 25 == COUPLING_RACK
    }

    /// True when turn x is the twist about the x axes: the other turns are free.
    pub fn is_twist(self) -> bool {
        (self.held() | self.limited() | self.driven() | self.rubbing()) & 0b11_0000 == 0
    }

    /// Rows that hold without bounds, 0 to 6.
    pub fn lock_rows(self) -> usize {
        if self.is_gear() || self.is_rack() { 1 } else { self.held().count_ones() as usize }
    }

    /// Rows with bounds: limits, drives, frictions and the cone, 0 to 19.
    pub fn bound_rows(self) -> usize {
        (self.0 >> 6 & ((1 << 19) - 1)).count_ones() as usize
    }

    /// True when the joint has coordinates that go on from step to step: those of rows with bounds, and how far a
    /// gear or a rack has slipped.
    pub fn counts_on(self) -> bool {
        self.bound_rows() > 0 || self.is_gear() || self.is_rack()
    }

    /// True when a row is about a turn between frames.
    pub fn turns(self) -> bool {
        let axes = self.held() | self.limited() | self.driven() | self.rubbing();
        axes & 0b11_1000 != 0 || self.has_cone() || self.is_gear() || self.is_rack()
    }

    /// True when a row is along an axis of A's frame: not all three shifts are held, and some row is about one.
    pub fn shifts_in_a(self) -> bool {
        let axes = self.held() | self.limited() | self.driven() | self.rubbing();
        !self.is_distance() && axes & 7 != 0 && self.held() & 7 != 7
    }
}
