//! What a row reads and writes of the seats of its bodies, lane by lane.

use crate::lanes::{LANES, Lane, LaneVec, Mask, Words, each_lane, transpose, transpose_back};
use crate::pipeline::seat::Seat;

/// Seats of the bodies A and of the bodies B.
pub(crate) type Ends<'a> = (&'a [u32; LANES], &'a [u32; LANES]);

/// Velocities of the two bodies of each lane.
pub(crate) struct Velocities {
    pub va: LaneVec,
    pub wa: LaneVec,
    pub vb: LaneVec,
    pub wb: LaneVec,
    /// Inverse masses along the axes: equal unless an axis is locked.
    pub ma: LaneVec,
    pub mb: LaneVec,
    /// Inverse mass and locks, as they stand in the seats.
    rest_a: [Lane; 2],
    rest_b: [Lane; 2],
}

impl Velocities {
    #[inline(always)]
    pub fn gather((seats_a, seats_b): Ends<'_>, seats: &[Seat], locked: bool) -> Self {
        let a = transpose(pick(seats, seats_a, |seat| seat.velocity));
        let b = transpose(pick(seats, seats_b, |seat| seat.velocity));
        let (ma, mb) = if locked {
            (free_axes(a[7]).times(a[3]), free_axes(b[7]).times(b[3]))
        } else {
            (LaneVec::new(a[3], a[3], a[3]), LaneVec::new(b[3], b[3], b[3]))
        };
        Self {
            va: LaneVec::new(a[0], a[1], a[2]),
            wa: LaneVec::new(a[4], a[5], a[6]),
            vb: LaneVec::new(b[0], b[1], b[2]),
            wb: LaneVec::new(b[4], b[5], b[6]),
            ma,
            mb,
            rest_a: [a[3], a[7]],
            rest_b: [b[3], b[7]],
        }
    }

    #[inline(always)]
    pub fn scatter(&self, (seats_a, seats_b): Ends<'_>, seats: &mut [Seat]) {
        // Each body is in one lane only, and scratch seats are the lane's own: no write meets another.
        let (va, wa, [m, l]) = (self.va, self.wa, self.rest_a);
        let a = transpose_back([va.x, va.y, va.z, m, wa.x, wa.y, wa.z, l]);
        let (vb, wb, [m, l]) = (self.vb, self.wb, self.rest_b);
        let b = transpose_back([vb.x, vb.y, vb.z, m, wb.x, wb.y, wb.z, l]);
        for i in 0..LANES {
            seats[seats_a[i] as usize].velocity = a[i];
            seats[seats_b[i] as usize].velocity = b[i];
        }
    }

    /// The nudges of the same bodies: velocities that move them in this substep and are then forgotten. They lie
    /// where the motion is noted later.
    #[inline(always)]
    pub fn gather_nudges(&self, (seats_a, seats_b): Ends<'_>, seats: &[Seat]) -> Self {
        let a = transpose(pick(seats, seats_a, |seat| seat.moved));
        let b = transpose(pick(seats, seats_b, |seat| seat.moved));
        Self {
            va: LaneVec::new(a[0], a[1], a[2]),
            wa: LaneVec::new(a[4], a[5], a[6]),
            vb: LaneVec::new(b[0], b[1], b[2]),
            wb: LaneVec::new(b[4], b[5], b[6]),
            ma: self.ma,
            mb: self.mb,
            rest_a: [Lane::ZERO; 2],
            rest_b: [Lane::ZERO; 2],
        }
    }

    /// Writes nudges back.
    #[inline(always)]
    pub fn scatter_nudges(&self, (seats_a, seats_b): Ends<'_>, seats: &mut [Seat]) {
        let (va, wa, zero) = (self.va, self.wa, Lane::ZERO);
        let a = transpose_back([va.x, va.y, va.z, zero, wa.x, wa.y, wa.z, zero]);
        let (vb, wb) = (self.vb, self.wb);
        let b = transpose_back([vb.x, vb.y, vb.z, zero, wb.x, wb.y, wb.z, zero]);
        for i in 0..LANES {
            seats[seats_a[i] as usize].moved = a[i];
            seats[seats_b[i] as usize].moved = b[i];
        }
    }

    /// Inverse masses of both bodies, added, whatever axes are locked; 0 for an immovable one, 1/kg.
    #[inline(always)]
    pub fn inverse_mass(&self) -> Lane {
        self.rest_a[0] + self.rest_b[0]
    }

    /// Where one of the bodies does not move along some axis.
    #[inline(always)]
    pub fn are_locked(&self) -> Mask {
        (self.rest_a[1] + self.rest_b[1]).greater(Lane::ZERO)
    }

    /// Rate of the row with direction `d` and jacobians `ja`, `jb`.
    #[inline(always)]
    pub fn rate(&self, d: LaneVec, ja: LaneVec, jb: LaneVec) -> Lane {
        d.dot(self.vb - self.va) + (jb.dot(self.wb) - ja.dot(self.wa))
    }

    /// Applies the impulse `x` of that row: on B along `d`, on A against it.
    #[inline(always)]
    pub fn apply(&mut self, d: LaneVec, (ja, jb): (LaneVec, LaneVec), x: Lane) {
        let p = d.times(x);
        self.va = self.va - p.each_times(self.ma);
        self.vb = self.vb + p.each_times(self.mb);
        self.apply_torque(ja, jb, x);
    }

    /// Applies a pure torque impulse `x` about a shared axis.
    #[inline(always)]
    pub fn apply_torque(&mut self, ja: LaneVec, jb: LaneVec, x: Lane) {
        self.wa = self.wa - ja.times(x);
        self.wb = self.wb + jb.times(x);
    }

    /// The four velocities, for [`Self::keep`].
    #[inline(always)]
    pub fn all(&self) -> [LaneVec; 4] {
        [self.va, self.wa, self.vb, self.wb]
    }

    /// Takes `before` again in all lanes but some, to the last bit: an impulse of 0 can change the sign of a zero.
    #[inline(always)]
    pub fn keep(&mut self, lanes: Mask, [va, wa, vb, wb]: [LaneVec; 4]) {
        self.va = lanes.select_vec(self.va, va);
        self.wa = lanes.select_vec(self.wa, wa);
        self.vb = lanes.select_vec(self.vb, vb);
        self.wb = lanes.select_vec(self.wb, wb);
    }

    /// Applies the impulse `p` on B and its opposite on A, and whitened torques.
    #[inline(always)]
    pub fn push(&mut self, p: LaneVec, (a, b): (LaneVec, LaneVec)) {
        self.va = self.va - p.each_times(self.ma);
        self.vb = self.vb + p.each_times(self.mb);
        self.wa = self.wa - a;
        self.wb = self.wb + b;
    }
}

/// What eight seats have.
#[inline(always)]
fn pick(seats: &[Seat], at: &[u32; LANES], of: impl Fn(&Seat) -> Words) -> [Words; LANES] {
    each_lane(|lane| of(&seats[at[lane] as usize]))
}

/// The motions of the bodies of a row: three numbers of the shift, 0, three of the whitened turn, 0.
#[inline(always)]
pub(crate) fn motions((seats_a, seats_b): Ends<'_>, seats: &[Seat]) -> [[Lane; 8]; 2] {
    // No `map`: see `each_lane`.
    let of = |at| transpose(pick(seats, at, |seat| seat.moved));
    [of(seats_a), of(seats_b)]
}

/// A symmetric matrix (diagonal, then xy, xz, yz) times a vector.
#[inline(always)]
pub(crate) fn root_times(root: &[LaneVec; 2], v: LaneVec) -> LaneVec {
    let [d, o] = root;
    LaneVec::new(
        d.x * v.x + o.x * v.y + o.y * v.z,
        o.x * v.x + d.y * v.y + o.z * v.z,
        o.y * v.x + o.z * v.y + d.z * v.z,
    )
}

/// 1 for each axis along which a body moves, 0 for a locked one; locks are a number, x + 2 y + 4 z.
#[inline(always)]
pub(crate) fn free_axes(locks: Lane) -> LaneVec {
    let (zero, one) = (Lane::ZERO, Lane::splat(1.0));
    let z = locks.greater(Lane::splat(3.5));
    let locks = locks - z.select(Lane::splat(4.0), zero);
    let y = locks.greater(Lane::splat(1.5));
    let locks = locks - y.select(Lane::splat(2.0), zero);
    let x = locks.greater(Lane::splat(0.5));
    LaneVec::new(x.select(zero, one), y.select(zero, one), z.select(zero, one))
}
