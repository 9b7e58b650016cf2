//! What phase 0 needs to integrate a body, beside its seat.

use crate::body::{BodyRow, Motion};
use crate::collide::vector64::{Vector, cross, dot, to_f64, to_vec3};
use crate::config::{LINEAR_SPEED_MAX, TURN_MAX};
use crate::lanes::Words;
use crate::math::{Rotation, Vec3, length};
use crate::pipeline::integration::{self, TURN_STEP};
use crate::pipeline::seat::Seat;
use crate::state::{Active, principal_rotation};
use bytemuck::{Pod, Zeroable};

/// The integration of a body during a step; in the order of the seats of phase 0.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(crate) struct Mover {
    /// Velocity after integration and before the impulses of the substep, laid out as in the seat.
    pub star: Words,
    /// Velocity that gravity, force and torque give in a substep.
    pub push: Words,
    /// Shares that damping takes; 0 for inverse mass and locks. Not what it leaves: a factor near 1 would be
    /// rounded once and the error raised to the number of substeps.
    pub loss: Words,
    /// 1e-18 where numbers are flushed to zero, 0 for inverse mass and locks.
    pub flush: Words,
    /// Motion of the center since the step began, metres.
    pub displacement: Vec3,
    /// How the body turns freely: `FREE_*`.
    pub spin: u32,
    /// Orientation now.
    pub rotation: Rotation,
    /// Principal frame at the start of the step, in the world.
    pub start: Rotation,
    /// Principal frame in the body.
    pub axes: Rotation,
    /// Principal moments of inertia, kg m2.
    pub inertia: Vec3,
    /// Their square roots.
    pub inertia_root: Vec3,
    /// W, as in [`Active`].
    pub root: [f32; 6],
    /// Whitened angular velocity at the start of the step.
    pub whitened: Vec3,
    /// 1 when the speed was capped in this step.
    pub capped: u32,
}

/// Angular velocity stays as it is: equal moments, or a locked axis.
pub(crate) const SPIN_PLAIN: u32 = 0;
/// Unequal moments, nothing locked: the free top.
pub(crate) const SPIN_TOP: u32 = 1;

impl Mover {
    /// The mover and the seat of a body at the start of a step of `substep` seconds per substep.
    pub fn new(active: &Active, motion: &Motion, row: &BodyRow, substep: f32) -> (Self, Seat) {
        let start = principal_rotation(motion, row);
        let inertia_root = Vec3::new(
            crate::math::sqrt(row.inertia.x),
            crate::math::sqrt(row.inertia.y),
            crate::math::sqrt(row.inertia.z),
        );
        let turn_locked = row.locks() >> 3 != 0;
        let equal = row.inertia.x == row.inertia.y && row.inertia.y == row.inertia.z;
        let spin = if turn_locked || equal { SPIN_PLAIN } else { SPIN_TOP };
        let locks = active.locks as u32;
        let free = |axis: u32, x: f32| if locks >> axis & 1 == 1 { 0.0 } else { x };
        let velocity =
            Vec3::new(free(0, motion.linear.x), free(1, motion.linear.y), free(2, motion.linear.z));
        let whitened = integration::whiten(&active.root, motion.angular);
        let torque = integration::root_times(&active.root, row.torque) * substep;
        // v' = v / (1 + c h) = v - v c h / (1 + c h)
        let loss = |damping: f32| damping * substep / (1.0 + damping * substep);
        let row_of = |v: Vec3, m: f32, w: Vec3, l: f32| Words::new([v.x, v.y, v.z, m, w.x, w.y, w.z, l]);
        let all = Vec3::splat;
        let current = row_of(velocity, active.inverse_mass, whitened, active.locks);
        let mover = Self {
            star: current,
            push: row_of(active.push, 0.0, torque, 0.0),
            loss: row_of(all(loss(row.linear_damping)), 0.0, all(loss(row.angular_damping)), 0.0),
            flush: row_of(all(1.0e-18), 0.0, all(1.0e-18), 0.0),
            displacement: Vec3::ZERO,
            spin,
            rotation: motion.rotation,
            start,
            axes: row.axes,
            inertia: row.inertia,
            inertia_root,
            root: active.root,
            whitened,
            capped: 0,
        };
        (mover, Seat { velocity: current, moved: Words::ZERO })
    }

    /// Velocities of the first substep: gravity, forces, damping. The warm sweep follows.
    pub fn push_first(&mut self, seat: &mut Seat) {
        self.star = self.pushed(seat.velocity);
        seat.velocity = self.star;
    }

    /// Velocities of a later substep: as the first, then the impulses of the substep before as warm start. Their
    /// sum on a body is the difference `v - star` that they made.
    pub fn push_again(&mut self, seat: &mut Seat) {
        let warm = seat.velocity - self.star;
        self.star = self.pushed(seat.velocity);
        seat.velocity = self.star + warm;
    }

    fn pushed(&self, velocity: Words) -> Words {
        let v = velocity + self.push;
        let v = v - v * self.loss;
        (v + self.flush) - self.flush
    }

    /// Moves the body by its velocity for a substep, and notes the motion in the seat.
    pub fn advance(&mut self, seat: &mut Seat, substep: f32) {
        let (mut v, mut whitened) = parts(&seat.velocity);
        let mut turn = integration::root_times(&self.root, whitened) * substep;
        // Squares of finite numbers may be infinite: then the speed is capped.
        if !(v.dot(v) <= LINEAR_SPEED_MAX * LINEAR_SPEED_MAX && turn.dot(turn) <= TURN_MAX * TURN_MAX) {
            self.cap(seat, (v, turn));
            (v, whitened) = parts(&seat.velocity);
            turn = integration::root_times(&self.root, whitened) * substep;
        }
        let moved = v * substep;
        self.displacement += moved;
        let turn = if self.spin == SPIN_TOP {
            self.advance_top(whitened, substep)
        } else {
            self.rotation = integration::turned(self.rotation, turn);
            whitened * substep
        };
        seat.moved = Words::new([moved.x, moved.y, moved.z, 0.0, turn.x, turn.y, turn.z, 0.0]);
    }

    /// The free top: world angular momentum stays, the orientation follows. Returns the whitened rotation vector.
    fn advance_top(&mut self, whitened: Vec3, substep: f32) -> Vec3 {
        let momentum = self.momentum(whitened);
        let before = self.rotation;
        let principal = before.after(self.axes);
        let after = integration::top(principal, momentum, self.inertia, substep);
        self.rotation = after.after(self.axes.inverse()).renormalized();
        let turn = integration::rotation_vector(self.rotation.after(before.inverse()));
        // turn~ = W^-1 turn.
        self.start.rotate(self.inertia_root * self.start.unrotate(turn))
    }

    /// World angular momentum of a free top, N m s.
    fn momentum(&self, whitened: Vec3) -> Vec3 {
        self.start.rotate(self.inertia_root * self.start.unrotate(whitened))
    }

    /// Angular velocity in the world at the current orientation, rad/s; `before` is that at the start of the step.
    ///
    /// In double precision, and from the change of the whitened velocity: a top that nothing touches keeps its
    /// angular momentum to the rounding of `before`. In f32 every step would scale it by the error of two unit
    /// quaternions, 1e-7, always in the same direction while the body spins about one axis: 1e-3 of the energy in
    /// a minute.
    pub fn angular_velocity(&self, whitened: Vec3, before: Vec3) -> Vec3 {
        if self.spin == SPIN_PLAIN {
            return integration::root_times(&self.root, whitened);
        }
        let start = Turn::of(self.start);
        let spin = start.undo(to_f64(before));
        let change = start.undo(to_f64(whitened - self.whitened));
        let (inertia, root) = (to_f64(self.inertia), to_f64(self.inertia_root));
        let momentum = start.apply(core::array::from_fn(|i| inertia[i] * spin[i] + root[i] * change[i]));
        let end = Turn::of(self.rotation.after(self.axes));
        let local = end.undo(momentum);
        to_vec3(end.apply(core::array::from_fn(|i| local[i] / inertia[i])))
    }

    /// Caps speed and spin at the documented maxima.
    #[cold]
    fn cap(&mut self, seat: &mut Seat, (v, turn): (Vec3, Vec3)) {
        let (speed, spin) = (length(v), length(turn));
        let linear = if speed > LINEAR_SPEED_MAX { LINEAR_SPEED_MAX / speed } else { 1.0 };
        let angular = if spin > TURN_MAX { TURN_MAX / spin } else { 1.0 };
        if linear < 1.0 || angular < 1.0 {
            let (l, a) = (linear, angular);
            seat.velocity = seat.velocity * Words::new([l, l, l, 1.0, a, a, a, 1.0]);
            self.capped = 1;
        }
    }
}

/// Linear and whitened angular velocity of a seat.
#[inline(always)]
fn parts(velocity: &Words) -> (Vec3, Vec3) {
    let u = velocity.to_array();
    (Vec3::new(u[0], u[1], u[2]), Vec3::new(u[4], u[5], u[6]))
}

/// A rotation in double precision. Its quaternion may have any length.
struct Turn {
    imaginary: Vector,
    real: f64,
    /// 2 over the square of the length.
    scale: f64,
}

impl Turn {
    fn of(q: Rotation) -> Self {
        let (imaginary, real) = (to_f64(q.imaginary()), f64::from(q.w));
        Self { imaginary, real, scale: 2.0 / (dot(imaginary, imaginary) + real * real) }
    }

    fn apply(&self, v: Vector) -> Vector {
        let t = cross(self.imaginary, v);
        let u = cross(self.imaginary, t);
        core::array::from_fn(|i| v[i] + (u[i] + t[i] * self.real) * self.scale)
    }

    fn undo(&self, v: Vector) -> Vector {
        let t = cross(self.imaginary, v);
        let u = cross(self.imaginary, t);
        core::array::from_fn(|i| v[i] + (u[i] - t[i] * self.real) * self.scale)
    }
}

const _: () = assert!(crate::config::TURN_MAX <= 256.0 * TURN_STEP + 0.01);
