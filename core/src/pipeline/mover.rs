//! What phase 0 needs to integrate bodies, beside their seats: eight bodies side by side.
//!
//! Pushes go body by body, as the velocities lie in the seats. Motion goes lane by lane; which lanes are free tops
//! is data, and a row without tops skips what only tops need.

use crate::body::{BodyRow, Motion};
use crate::collide::vector64::{Vector, dot, to_f64, to_vec3};
use crate::config::{LINEAR_SPEED_MAX, TURN_MAX};
use crate::constraint::velocities::root_times;
use crate::lanes::{FLUSH, LANES, Lane, LaneVec, Mask, Words, each_lane, transpose, transpose_back};
use crate::math::{Rotation, Vec3, length, min};
use crate::pipeline::integration::{self, LaneRotation, SPLITS_MAX, TURN_STEP};
use crate::pipeline::seat::Seat;
use crate::state::{Active, principal_rotation};
use bytemuck::{Pod, Zeroable};

/// The integration of eight bodies during a step; in the order of the seats of phase 0.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(crate) struct MoverRow {
    /// Velocities after integration and before the impulses of the substep, laid out as in the seats.
    star: [Words; LANES],
    /// Velocities that gravity, force and torque give in a substep.
    push: [Words; LANES],
    /// Shares that damping takes; 0 for inverse mass and locks. Not what it leaves: a factor near 1 would be
    /// rounded once and the error raised to the number of substeps.
    loss: [Words; LANES],
    /// Motion of the centers since the step began, metres.
    displacement: LaneVec,
    /// Orientations now: of a free top the principal frame, its axes in the order of `split_frame`.
    frame: LaneRotation,
    /// From whitened angular velocity to the turn of a substep: diagonal, then xy, xz, yz. Of a free top the turn
    /// that all its axes share, along the momentum; else the whole.
    turn: [LaneVec; 2],
    /// Square of the longest such turn that is surely no faster than the maximum, rad2.
    turn_max: Lane,
    /// Free top: from `turn` times a rotation vector to the whitened rotation vector.
    whitening: Lane,
    /// Free top: rates about the second and third axis of the frame beyond the common one, as shares of that.
    near: Lane,
    far: Lane,
    /// 1 for a free top, 0 for what turns as its velocity says: equal moments, or a locked axis.
    top: Lane,
    /// 1 when a speed was capped in this step.
    capped: Lane,
    /// Slender tops: where the long axis pointed at the start, and where it points in the view that the seats
    /// have.
    axis: LaneVec,
    view: LaneVec,
    /// 1 when some lane is a free top.
    tops: u32,
    /// Bit for each lane with a slender top that has no joints.
    slender: u32,
    /// Bit for each lane whose body gets half of a push first and half last: see `pipeline/leapfrog.rs`.
    pub leaps: u32,
    /// Bit for each of them that begins a substep without the impulses of the one before.
    pub alone: u32,
    /// Zero.
    reserved: [u32; 4],
}

/// A top is slender when the moment about its long axis is less than a third of the next one.
const SLENDER: f32 = 2.0;
/// Share of the energy of a blow that may be told wrong before the seats of a slender top have the view of a body
/// that did not turn: the square of the turn of its long axis times the ratio of the moments, less 1.
const VIEW_ERROR: f32 = 0.1;

impl MoverRow {
    /// Makes the row that of bodies at the start of a step of `substep` seconds per substep, and their seats; where
    /// `entry` has none, nothing moves.
    pub fn enter<'a>(
        &mut self,
        seats: &mut [Seat; LANES],
        entry: impl Fn(usize) -> Option<(&'a Active, &'a Motion, &'a BodyRow)>,
        (substep, is_jointed): (f32, impl Fn(u32) -> bool),
    ) {
        let row = self;
        *row = Self::zeroed();
        let mut frames = [Words::new([0.0, 0.0, 0.0, 1.0, TURN_MAX * TURN_MAX, 0.0, 0.0, 0.0]); LANES];
        let mut turns = [Words::ZERO; LANES];
        for (lane, seat) in seats.iter_mut().enumerate() {
            *seat = Seat::zeroed();
            if let Some(body) = entry(lane) {
                row.enter_velocity(lane, (body.0, body.2), substep);
                seat.velocity = row.star[lane];
                let top = is_top(body.2);
                row.tops |= u32::from(top);
                (frames[lane], turns[lane]) =
                    if top { top_words(body, substep) } else { plain_words(body, substep) };
            }
        }
        let [x, y, z, w, turn_max, whitening, near, far] = transpose(frames);
        row.frame = LaneRotation { imaginary: LaneVec::new(x, y, z), real: w };
        (row.turn_max, row.whitening, row.near, row.far) = (turn_max, whitening, near, far);
        let [xx, yy, zz, xy, xz, yz, top, _] = transpose(turns);
        row.turn = [LaneVec::new(xx, yy, zz), LaneVec::new(xy, xz, yz)];
        row.top = top;
        for lane in 0..LANES {
            let may_turn = || entry(lane).is_some_and(|(active, ..)| !is_jointed(active.body));
            row.slender |= u32::from(row.far.get(lane) > SLENDER && may_turn()) << lane;
        }
        if row.slender != 0 {
            row.axis = row.frame.third();
            row.view = row.axis;
        }
    }

    fn enter_velocity(&mut self, lane: usize, (active, row): (&Active, &BodyRow), substep: f32) {
        let locks = active.locks as u32;
        let free = |axis: u32, x: f32| if locks >> axis & 1 == 1 { 0.0 } else { x };
        let velocity =
            Vec3::new(free(0, active.linear.x), free(1, active.linear.y), free(2, active.linear.z));
        let torque = integration::root_times(&active.root, row.torque) * substep;
        // v' = v / (1 + c h) = v - v c h / (1 + c h)
        let loss = |damping: f32| Vec3::splat(damping * substep / (1.0 + damping * substep));
        let row_of = |v: Vec3, m: f32, w: Vec3, l: f32| Words::new([v.x, v.y, v.z, m, w.x, w.y, w.z, l]);
        self.star[lane] = row_of(velocity, active.inverse_mass, active.whitened, active.locks);
        self.push[lane] = row_of(active.push, 0.0, torque, 0.0);
        self.loss[lane] = row_of(loss(row.linear_damping), 0.0, loss(row.angular_damping), 0.0);
    }

    /// Velocities of the first substep: gravity, forces, damping. The warm sweep follows.
    pub fn push_first(&mut self, seats: &mut [Seat; LANES]) {
        for (lane, seat) in seats.iter_mut().enumerate() {
            let push = if self.leaps >> lane & 1 == 1 { self.half_push(lane) } else { self.push[lane] };
            self.star[lane] = self.pushed(lane, seat.velocity, push);
            seat.velocity = self.star[lane];
        }
    }

    /// The second half of the push of bodies that leap, after the last substep.
    pub fn push_last(&mut self, seats: &mut [Seat; LANES], substep: f32) {
        if self.leaps == 0 {
            return;
        }
        for (lane, seat) in seats.iter_mut().enumerate() {
            if self.leaps >> lane & 1 == 1 {
                seat.velocity = seat.velocity + self.half_push(lane);
            }
        }
        self.cap(seats, (substep, self.leaps));
    }

    fn half_push(&self, lane: usize) -> Words {
        self.push[lane] * Words::new([0.5; 8])
    }

    /// Velocities of a later substep: as the first, then the impulses of the substep before as warm start. Their
    /// sum on a body is the difference `v - star` that they made.
    pub fn push_again(&mut self, seats: &mut [Seat; LANES], nudges: bool) {
        for (lane, seat) in seats.iter_mut().enumerate() {
            let is_alone = self.alone >> lane & 1 == 1;
            let warm = if is_alone { Words::ZERO } else { seat.velocity - self.star[lane] };
            self.star[lane] = self.pushed(lane, seat.velocity, self.push[lane]);
            seat.velocity = self.star[lane] + warm;
            if nudges {
                seat.moved = Words::ZERO;
            }
        }
    }

    #[inline(always)]
    fn pushed(&self, lane: usize, velocity: Words, push: Words) -> Words {
        let v = velocity + push;
        let v = v - v * self.loss[lane];
        // Inverse mass and locks stay as they are.
        v.flushed(Words::new([FLUSH, FLUSH, FLUSH, 0.0, FLUSH, FLUSH, FLUSH, 0.0]))
    }

    /// Moves the bodies by their velocities, and their nudges if there are any, for a substep, and notes the
    /// motion in the seats.
    pub fn advance(&mut self, seats: &mut [Seat; LANES], substep: f32, nudges: bool) {
        let (mut v, mut whitened) = velocities(seats);
        let mut turn = root_times(&self.turn, whitened).flushed();
        // Squares of finite numbers may be infinite: then the speed is capped.
        let slow = v.dot(v).less(Lane::splat(LINEAR_SPEED_MAX * LINEAR_SPEED_MAX));
        if !slow.and(turn.dot(turn).less(self.turn_max)).all() {
            self.cap(seats, (substep, u32::MAX));
            (v, whitened) = velocities(seats);
            turn = root_times(&self.turn, whitened).flushed();
        }
        if self.slender != 0 {
            turn = swung((self.axis, self.view), turn);
        }
        let h = Lane::splat(substep);
        let nudge = if nudges { self.take_nudges(seats, substep) } else { Nudge::NONE };
        let moved = (v + nudge.linear).times(h).flushed();
        self.displacement = self.displacement + moved;
        let before = (nudge.any && self.tops != 0).then(|| self.frame.third());
        let mut turned = self.turn_by(turn, whitened.times(h), &nudge);
        if self.slender != 0 {
            turned = self.look_again(seats, turn, turned);
        }
        if let Some(before) = before {
            self.take_back(seats, (before, nudge.momentum));
        }
        let (zero, turned) = (Lane::ZERO, turned.flushed());
        let rows = transpose_back([moved.x, moved.y, moved.z, zero, turned.x, turned.y, turned.z, zero]);
        for (seat, moved) in seats.iter_mut().zip(rows) {
            seat.moved = moved;
        }
    }

    /// Turns the bodies. `whitened` is the whitened rotation vector of those that are no tops; returns that of
    /// all.
    #[inline(always)]
    fn turn_by(&mut self, turn: LaneVec, whitened: LaneVec, nudge: &Nudge) -> LaneVec {
        let turn = if nudge.any { nudge.nudged.select_vec(turn + nudge.momentum, turn) } else { turn };
        let mut rotation = LaneRotation::by(turn);
        if nudge.any {
            let more = LaneRotation::by(nudge.turn).after(rotation);
            rotation = LaneRotation::select(nudge.nudged, more, rotation);
        }
        let mut turned = whitened + nudge.whitened;
        if self.tops != 0 {
            // World angular momentum stays, the orientation follows.
            let tops = self.top.greater(Lane::ZERO);
            let whole = rotation.after(integration::swing(self.frame, turn, (self.near, self.far)));
            rotation = LaneRotation::select(tops, whole, rotation);
            let vector = root_times(&self.turn, whole.vector()).times(self.whitening);
            turned = tops.select_vec(vector, turned);
        }
        self.frame = rotation.after(self.frame).flushed().renormalized();
        turned
    }

    /// The nudges that rows have left in the seats, as motion of a substep. A top is moved by the momentum that
    /// it would have with them.
    #[inline(never)]
    fn take_nudges(&self, seats: &[Seat; LANES], substep: f32) -> Nudge {
        let n = transpose(each_lane(|lane| seats[lane].moved));
        let (linear, whitened) = (LaneVec::new(n[0], n[1], n[2]), LaneVec::new(n[4], n[5], n[6]));
        let nudged = (linear.dot(linear) + whitened.dot(whitened)).greater(Lane::ZERO);
        if !nudged.any() {
            return Nudge::NONE;
        }
        let turn = root_times(&self.turn, whitened);
        let tops = self.top.greater(Lane::ZERO);
        let (momentum, turn) = (tops.keep_vec(turn), tops.select_vec(LaneVec::ZERO, turn));
        Nudge { linear, momentum, turn, whitened: whitened.times(Lane::splat(substep)), nudged, any: true }
    }

    /// Takes back from tops what a nudge gave: as it stands to the body now that this has turned. What was given
    /// across the axis `before`, that of the moment which stands out, is taken across that axis, so that no
    /// correction spins a slender body about it. (Turning the whole momentum instead is a torque on a fast top.)
    #[cold]
    fn take_back(&mut self, seats: &mut [Seat; LANES], (before, momentum): (LaneVec, LaneVec)) {
        // The least rotation from one axis to the other: v + c x v + c x (c x v) / (1 + a . b) with c = a x b.
        let after = self.frame.third();
        let across = before.cross(after);
        let one = Lane::splat(1.0);
        let share = one / (one + before.dot(after)).greatest(Lane::splat(1.0e-3));
        let turned = across.cross(momentum);
        let change = integration::solve(&self.turn, turned + across.cross(turned).times(share));
        let change = self.top.greater(Lane::ZERO).keep_vec(change);
        let zero = Lane::ZERO;
        let rows = transpose_back([zero, zero, zero, zero, change.x, change.y, change.z, zero]);
        for ((seat, star), change) in seats.iter_mut().zip(&mut self.star).zip(rows) {
            seat.velocity = seat.velocity - change;
            *star = *star - change;
        }
    }

    /// Gives the seats of slender tops that have turned in this step, and were touched, the view of a body that
    /// did not turn. `turn` is that of the momentum, and `turned` the whitened rotation vector of the substep,
    /// which is returned as the seats see it.
    ///
    /// Rows keep the arms and the inertia of the start of the step. A rod that has turned by then takes the
    /// impulse at its end about its long axis, of which it has hardly any inertia: in a step a blow could give
    /// it a hundred times its energy. So the seats see the momentum turned back with the long axis, and what
    /// they change of it is turned on. The body stays the one that the rows know; the price is that action and
    /// reaction are turned against each other as the arms are.
    #[inline(never)]
    fn look_again(&mut self, seats: &mut [Seat; LANES], turn: LaneVec, turned: LaneVec) -> LaneVec {
        let third = self.frame.third();
        let cosine = self.axis.dot(third);
        let back = |view: LaneVec| (view, self.axis);
        let mut view = self.axis;
        let mut any = false;
        for (lane, (seat, star)) in seats.iter().zip(&self.star).enumerate() {
            if self.slender >> lane & 1 == 0 {
                continue;
            }
            let (u, v) = (seat.velocity.to_array(), star.to_array());
            let viewed = self.view.get(lane) != self.axis.get(lane);
            any |= viewed;
            if 2.0 * (1.0 - cosine.get(lane)) * self.far.get(lane) > VIEW_ERROR
                && (viewed || u[4..7] != v[4..7])
            {
                view.set(lane, third.get(lane));
                any = true;
            }
        }
        if !any {
            return turned;
        }
        let vector = integration::solve(&self.turn, turned);
        let seen = root_times(&self.turn, swung(back(self.view), vector));
        let whitened = integration::solve(&self.turn, swung(back(view), turn));
        let old = core::mem::replace(&mut self.view, view);
        let mut result = turned;
        for (lane, (seat, star)) in seats.iter_mut().zip(&mut self.star).enumerate() {
            let axis = self.axis.get(lane);
            if old.get(lane) != axis {
                result.set(lane, seen.get(lane));
            }
            if old.get(lane) != axis || view.get(lane) != axis {
                let u = seat.velocity.to_array();
                let w = whitened.get(lane);
                let change = Words::new([0.0, 0.0, 0.0, 0.0, w.x - u[4], w.y - u[5], w.z - u[6], 0.0]);
                seat.velocity = seat.velocity + change;
                *star = *star + change;
            }
        }
        result
    }

    /// From where to where the long axis of a body is turned that the seats see as at the start of the step;
    /// `None` where they see it as it is.
    pub fn view(&self, lane: usize) -> Option<(Vec3, Vec3)> {
        let (axis, view) = (self.axis.get(lane), self.view.get(lane));
        (self.slender >> lane & 1 != 0 && axis != view).then_some((axis, view))
    }

    /// Caps speed and spin at the documented maxima, in the lanes of some bits.
    #[cold]
    fn cap(&mut self, seats: &mut [Seat; LANES], (substep, lanes): (f32, u32)) {
        for (lane, seat) in seats.iter_mut().enumerate().filter(|(lane, _)| lanes >> lane & 1 == 1) {
            let u = seat.velocity.to_array();
            let (v, whitened) = (Vec3::new(u[0], u[1], u[2]), Vec3::new(u[4], u[5], u[6]));
            let (speed, spin) = (length(v), length(self.velocity_turn(lane, whitened, substep)));
            let linear = if speed > LINEAR_SPEED_MAX { LINEAR_SPEED_MAX / speed } else { 1.0 };
            let angular = if spin > TURN_MAX { TURN_MAX / spin } else { 1.0 };
            if linear < 1.0 || angular < 1.0 {
                let (l, a) = (linear, angular);
                seat.velocity = seat.velocity * Words::new([l, l, l, 1.0, a, a, a, 1.0]);
                self.capped.set(lane, 1.0);
            }
        }
    }

    /// Angular velocity times substep of a body at the orientation at which the step began, radians.
    fn velocity_turn(&self, lane: usize, whitened: Vec3, substep: f32) -> Vec3 {
        let (d, o) = (self.turn[0].get(lane), self.turn[1].get(lane));
        let turn = [d.x, d.y, d.z, o.x, o.y, o.z];
        if self.top.get(lane) == 0.0 {
            return integration::root_times(&turn, whitened);
        }
        integration::whiten(&turn, whitened) * (substep / self.whitening.get(lane))
    }

    /// Motion of a body's center in the step, metres, and its orientation.
    pub fn outcome(&self, lane: usize, (active, row): (&Active, &BodyRow)) -> (Vec3, Rotation) {
        let frame = self.frame.get(lane);
        let rotation =
            if is_top(row) { frame.after(frame_axes(active, row).inverse()).flushed() } else { frame };
        (self.displacement.get(lane), rotation.normalized())
    }

    /// True when the speed of a body was capped in this step.
    pub fn is_capped(&self, lane: usize) -> bool {
        self.capped.get(lane) != 0.0
    }
}

/// A motion beside the velocities; see `constraint/velocities.rs`.
struct Nudge {
    /// m/s.
    linear: LaneVec,
    /// Of tops, added to the turn that all their axes share.
    momentum: LaneVec,
    /// Of the others: rotation vector of the substep, radians.
    turn: LaneVec,
    /// The same whitened, of bodies that are no tops.
    whitened: LaneVec,
    /// Lanes that have one; the others are as if there was none anywhere.
    nudged: Mask,
    any: bool,
}

impl Nudge {
    const NONE: Self = Self {
        linear: LaneVec::ZERO,
        momentum: LaneVec::ZERO,
        turn: LaneVec::ZERO,
        whitened: LaneVec::ZERO,
        nudged: Mask::NONE,
        any: false,
    };
}

/// A vector under the least rotation that takes one unit vector to another: `v + c x v + c x (c x v) / (1 + a .
/// b)` with `c = a x b`.
fn swung((from, to): (LaneVec, LaneVec), v: LaneVec) -> LaneVec {
    let across = from.cross(to);
    let one = Lane::splat(1.0);
    let share = one / (one + from.dot(to)).greatest(Lane::splat(1.0e-6));
    let turned = across.cross(v);
    v + turned + across.cross(turned).times(share)
}

/// True when a body of unequal moments turns about all axes.
pub(crate) fn is_top(row: &BodyRow) -> bool {
    let equal = row.inertia.x == row.inertia.y && row.inertia.y == row.inertia.z;
    !equal && row.locks() >> 3 == 0
}

/// The frame in which a free top is turned, in the body.
fn frame_axes(active: &Active, row: &BodyRow) -> Rotation {
    row.axes.after(integration::split_frame(active.inertia(row)).0)
}

/// What a body that turns as its velocity says has in its lane: `[frame, turn_max, whitening, near, far]` and
/// `[turn, top, 0]`.
fn plain_words((active, motion, _): (&Active, &Motion, &BodyRow), substep: f32) -> (Words, Words) {
    let q = motion.rotation;
    let [xx, yy, zz, xy, xz, yz] = active.root.map(|x| x * substep);
    (
        Words::new([q.x, q.y, q.z, q.w, TURN_MAX * TURN_MAX, 0.0, 0.0, 0.0]),
        Words::new([xx, yy, zz, xy, xz, yz, 0.0, 0.0]),
    )
}

/// The same of a free top.
fn top_words((active, motion, row): (&Active, &Motion, &BodyRow), substep: f32) -> (Words, Words) {
    let (axes, moments) = integration::split_frame(active.inertia(row));
    let principal = principal_rotation(motion, row);
    // Momentum W^-1 w~, and by the reference moment the velocity that all axes share.
    let share = substep / moments.x;
    let roots = integration::square_roots(active.inertia(row));
    let turn = integration::along_axes(&principal.matrix(), roots * share);
    // The fastest that this momentum can mean is about the axis of the least moment.
    let most = TURN_MAX * (min(moments.x, min(moments.y, moments.z)) / moments.x);
    let (near, far) = ((moments.x - moments.y) / moments.y, (moments.x - moments.z) / moments.z);
    let q = principal.after(axes);
    let [xx, yy, zz, xy, xz, yz] = turn;
    (
        Words::new([q.x, q.y, q.z, q.w, most * most, 1.0 / share, near, far]),
        Words::new([xx, yy, zz, xy, xz, yz, 1.0, 0.0]),
    )
}

/// Linear and whitened angular velocities of eight seats.
#[inline(always)]
fn velocities(seats: &[Seat; LANES]) -> (LaneVec, LaneVec) {
    let u = transpose(each_lane(|lane| seats[lane].velocity));
    (LaneVec::new(u[0], u[1], u[2]).flushed(), LaneVec::new(u[4], u[5], u[6]).flushed())
}

/// Angular velocity in the world of a body that ends the step with this whitened velocity and orientation, rad/s;
/// `motion` is that at the start of the step.
///
/// In double precision, and from the change of the whitened velocity: a top that nothing touches keeps its angular
/// momentum to the rounding of the velocity before. In f32 every step would scale it by the error of two unit
/// quaternions, 1e-7, always in the same direction while the body spins about one axis: 1e-3 of the energy in a
/// minute.
pub(crate) fn angular_velocity(
    (active, motion, row): (&Active, &Motion, &BodyRow),
    (whitened, view): (Vec3, Option<(Vec3, Vec3)>),
    rotation: Rotation,
) -> Vec3 {
    if !is_top(row) {
        return integration::root_times(&active.root, whitened);
    }
    let start = Turn::of(principal_rotation(motion, row));
    let spin = start.undo(to_f64(active.angular));
    let change = start.undo(to_f64(whitened - active.whitened));
    let moments = active.inertia(row);
    let (inertia, root) = (to_f64(moments), to_f64(integration::square_roots(moments)));
    let mut momentum = start.apply(core::array::from_fn(|i| inertia[i] * spin[i] + root[i] * change[i]));
    if let Some((from, to)) = view {
        momentum = swung_wide(to_f64(from), to_f64(to), momentum);
    }
    let end = Turn::of(rotation.after(row.axes));
    let local = end.undo(momentum);
    to_vec3(end.apply(core::array::from_fn(|i| local[i] / inertia[i])))
}

/// See [`swung`].
fn swung_wide(from: Vector, to: Vector, v: Vector) -> Vector {
    let cross = |a: Vector, b: Vector| {
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    };
    let across = cross(from, to);
    let along = 1.0 + dot(from, to);
    let share = 1.0 / if along > 1.0e-6 { along } else { 1.0e-6 };
    let turned = cross(across, v);
    let again = cross(across, turned);
    core::array::from_fn(|i| v[i] + turned[i] + again[i] * share)
}

/// A rotation in double precision: the rows of its matrix.
struct Turn([Vector; 3]);

impl Turn {
    /// Of a quaternion of any length.
    fn of(q: Rotation) -> Self {
        let ([x, y, z], w) = (to_f64(q.imaginary()), f64::from(q.w));
        let scale = 2.0 / (x * x + y * y + z * z + w * w);
        let (sx, sy, sz) = (x * scale, y * scale, z * scale);
        let (xx, yy, zz) = (x * sx, y * sy, z * sz);
        let (xy, xz, yz) = (x * sy, x * sz, y * sz);
        let (wx, wy, wz) = (w * sx, w * sy, w * sz);
        Self([
            [1.0 - (yy + zz), xy - wz, xz + wy],
            [xy + wz, 1.0 - (xx + zz), yz - wx],
            [xz - wy, yz + wx, 1.0 - (xx + yy)],
        ])
    }

    fn apply(&self, v: Vector) -> Vector {
        self.0.map(|row| dot(row, v))
    }

    fn undo(&self, v: Vector) -> Vector {
        let [a, b, c] = self.0;
        core::array::from_fn(|i| a[i] * v[0] + b[i] * v[1] + c[i] * v[2])
    }
}

const _: () = assert!(TURN_MAX <= SPLITS_MAX * TURN_STEP + 0.01);
