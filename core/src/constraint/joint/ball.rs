//! Plain ball joints, eight side by side: the rows of nets and cloths.
//!
//! The same visit as that of any joint (`constraint/joint.rs`), for joints that hold two points together rigidly
//! between bodies that are no free tops and no moving immovable ones. The three rows of such a joint lie along the
//! world's axes, so that nothing but arms, impulses and a 3x3 factor is kept: a fifth of the bytes of a row that
//! any joint may have, and a net of joints is bound by memory.
//!
//! Legend: as in `constraint/contact.rs`.

use super::super::contact::{Pass, Sweep};
use super::super::velocities::{Velocities, motions, root_times};
use super::follow::Turning;
use super::solve::{NUDGE_MAX, inverse};
use crate::lanes::{LANES, Lane, LaneVec};
use crate::math::Vec3;
use crate::pipeline::leapfrog::lanes_of;
use crate::pipeline::seat::Seat;
use bytemuck::{Pod, Zeroable};

/// Share of a gap that a substep closes. More than other locks take back: in a net each joint's nudges open the
/// gaps of its neighbours again, and all that is left to fear, an overshoot, begins at 2.
const PUSH: f32 = 0.5;

/// Eight joints. All 0 in an empty lane.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
pub(crate) struct BallRow {
    /// Seats of bodies A and of bodies B, from the group's first.
    pub seats_a: [u32; LANES],
    pub seats_b: [u32; LANES],
    /// 1 when a body of a lane does not move along some axis.
    pub locked: u32,
    /// 1 when the next biased sweep has to apply the changes of the warm start.
    pub turns: u32,
    /// Bit for each lane that leaps: see `pipeline/leapfrog.rs`.
    pub leaps: u32,
    /// Zero.
    pub reserved: [u32; 5],
    /// W of both bodies, fixed for the step: diagonal, then xy, xz, yz.
    pub root_a: [LaneVec; 2],
    pub root_b: [LaneVec; 2],
    /// From the center of A to A's point, and to B's, where the impulses act; from the center of B to B's point.
    pub arm_a: LaneVec,
    pub lever_a: LaneVec,
    pub arm_b: LaneVec,
    /// Half of what the levers of A and B changed by in the last substep.
    pub half_a: LaneVec,
    pub half_b: LaneVec,
    /// Impulse of the substep on B, N s, and what it was before the relax sweeps.
    pub impulse: LaneVec,
    pub pressed: LaneVec,
    /// L below the diagonal (yx, zx, zy), and the inverse of D, in `K = L D Lt`.
    factor: [Lane; 3],
    inverse: [Lane; 3],
}

impl BallRow {
    /// Visits the rows of a group in their order.
    pub fn visit_all(rows: &mut [Self], sweep: &Sweep, seats: &mut [Seat]) {
        match sweep.pass {
            Pass::Warm => rows.iter_mut().for_each(|row| row.warm(seats)),
            Pass::Biased => rows.iter_mut().for_each(|row| row.press(sweep, seats)),
            Pass::Follow if sweep.ends => {}
            Pass::Follow => rows.iter_mut().for_each(|row| row.follow_only(seats)),
            Pass::Relax => rows.iter_mut().for_each(|row| row.relax(seats, true)),
            Pass::RelaxAgain => rows.iter_mut().for_each(|row| row.relax(seats, false)),
            Pass::Leap | Pass::LeapOnce => {
                let counts = sweep.pass == Pass::LeapOnce;
                rows.iter_mut().filter(|row| row.leaps != 0).for_each(|row| row.leap(seats, counts));
            }
            Pass::Bounce => {}
        }
    }

    #[inline(always)]
    fn velocities(&self, seats: &[Seat]) -> Velocities {
        Velocities::gather((&self.seats_a, &self.seats_b), seats, self.locked != 0)
    }

    /// Applies the impulses of the step before.
    fn warm(&mut self, seats: &mut [Seat]) {
        let mut u = self.velocities(seats);
        self.push(&mut u, self.impulse, (self.lever_a, self.arm_b));
        u.scatter((&self.seats_a, &self.seats_b), seats);
    }

    /// A biased sweep: the velocities of the points meet, and nudges close the gap.
    fn press(&mut self, sweep: &Sweep, seats: &mut [Seat]) {
        let mut u = self.velocities(seats);
        if self.turns != 0 {
            if self.leaps != 0 {
                // What leaps alone begins anew.
                let none = |v: LaneVec| lanes_of(self.leaps).select_vec(LaneVec::ZERO, v);
                (self.impulse, self.pressed) = (none(self.impulse), none(self.pressed));
            }
            // The impulse acts along the levers of now; half of what the relax sweeps gave did already.
            let both = self.impulse + self.pressed;
            let turn_a = root_times(&self.root_a, self.half_a.cross(both));
            let turn_b = root_times(&self.root_b, self.half_b.cross(both));
            u.wa = u.wa - turn_a;
            u.wb = u.wb + turn_b;
            self.turns = 0;
        }
        let x = self.substitute(self.rate(&u));
        let x = self.add(x);
        self.push(&mut u, x, (self.lever_a, self.arm_b));
        let ends = (&self.seats_a, &self.seats_b);
        u.scatter(ends, seats);
        let mut nudges = u.gather_nudges(ends, seats);
        let most = Lane::splat(NUDGE_MAX);
        let rate = Lane::splat(PUSH / sweep.substep);
        let back = |gap: Lane| (gap * rate).least(most).greatest(-most);
        let gap = self.lever_a - self.arm_a;
        let back = LaneVec::new(back(gap.x), back(gap.y), back(gap.z));
        let x = self.substitute(self.rate(&nudges) + back + self.curvature(&u, sweep.substep));
        self.push(&mut nudges, x.finite(), (self.lever_a, self.arm_b));
        nudges.scatter_nudges(ends, seats);
    }

    /// A relax sweep: the velocities fit the levers at the end of the substep, by impulses at the mean of those at
    /// both ends.
    fn relax(&mut self, seats: &mut [Seat], follows: bool) {
        let mut u = self.velocities(seats);
        if follows {
            self.follow(seats, u.ma + u.mb);
        }
        let x = self.substitute(self.rate(&u));
        let x = self.add(x);
        let levers = (self.lever_a - self.half_a, self.arm_b - self.half_b);
        self.push(&mut u, x, levers);
        if self.leaps != 0 {
            // The factor is that of the levers of now.
            let (leaps, before) = (lanes_of(self.leaps), u.all());
            let x = leaps.keep_vec(self.substitute(self.rate(&u)));
            let x = self.add(x);
            self.push(&mut u, x, levers);
            u.keep(leaps, before);
        }
        u.scatter((&self.seats_a, &self.seats_b), seats);
    }

    /// The velocities fit the levers again after the rest of the push.
    fn leap(&mut self, seats: &mut [Seat], counts: bool) {
        let mut u = self.velocities(seats);
        let (leaps, before) = (lanes_of(self.leaps), u.all());
        let x = leaps.keep_vec(self.substitute(self.rate(&u))).finite();
        let x = if counts { self.add(x) } else { x };
        self.push(&mut u, x, (self.lever_a, self.arm_b));
        u.keep(leaps, before);
        u.scatter((&self.seats_a, &self.seats_b), seats);
    }

    fn follow_only(&mut self, seats: &[Seat]) {
        let u = self.velocities(seats);
        self.follow(seats, u.ma + u.mb);
    }

    /// Jacobians of a lane's row along `d`.
    pub fn jacobians(&self, lane: usize, d: Vec3) -> (Vec3, Vec3) {
        let mut all = LaneVec::ZERO;
        all.set(lane, d);
        let a = root_times(&self.root_a, self.lever_a.cross(all));
        let b = root_times(&self.root_b, self.arm_b.cross(all));
        (a.get(lane), b.get(lane))
    }

    /// The rates that are left.
    pub(super) fn lacks(&self, seats: &[Seat]) -> LaneVec {
        self.rate(&self.velocities(seats))
    }

    /// How fast B's point leaves A's.
    #[inline(always)]
    fn rate(&self, u: &Velocities) -> LaneVec {
        let spin_a = root_times(&self.root_a, u.wa);
        let spin_b = root_times(&self.root_b, u.wb);
        (u.vb - u.va) + (spin_b.cross(self.arm_b) - spin_a.cross(self.lever_a))
    }

    /// Applies an impulse on B, and its opposite on A.
    #[inline(always)]
    fn push(&self, u: &mut Velocities, x: LaneVec, (lever_a, lever_b): (LaneVec, LaneVec)) {
        u.push(x, (root_times(&self.root_a, lever_a.cross(x)), root_times(&self.root_b, lever_b.cross(x))));
    }

    /// Adds to the impulse; returns by how much it changes.
    #[inline(always)]
    fn add(&mut self, x: LaneVec) -> LaneVec {
        let after = (self.impulse + x).finite().flushed();
        let change = after - self.impulse;
        self.impulse = after;
        change
    }

    /// How much faster the points part in the mean of the substep than now because the bodies turn.
    #[inline(always)]
    fn curvature(&self, u: &Velocities, substep: f32) -> LaneVec {
        let spin_a = root_times(&self.root_a, u.wa);
        let spin_b = root_times(&self.root_b, u.wb);
        let turned = spin_b.cross(spin_b.cross(self.arm_b)) - spin_a.cross(spin_a.cross(self.arm_a));
        turned.times(Lane::splat(0.5 * substep))
    }

    /// Brings arms and factor to the end of the substep. `masses` are the inverse masses of both bodies along the
    /// axes, added.
    #[inline(always)]
    fn follow(&mut self, seats: &[Seat], masses: LaneVec) {
        let [a, b] = motions((&self.seats_a, &self.seats_b), seats);
        // A body that is no longer finite keeps its arms, so that it does not spread.
        let moved = LaneVec::new(b[0] - a[0], b[1] - a[1], b[2] - a[2]).finite();
        let turn_a = root_times(&self.root_a, LaneVec::new(a[4], a[5], a[6])).finite();
        let turn_b = root_times(&self.root_b, LaneVec::new(b[4], b[5], b[6])).finite();
        let half = Lane::splat(0.5);
        let change_b = Turning::new(turn_b).change(self.arm_b);
        let change_a = moved + change_b;
        self.arm_a = self.arm_a + Turning::new(turn_a).change(self.arm_a);
        self.arm_b = self.arm_b + change_b;
        self.lever_a = self.lever_a + change_a;
        self.half_a = change_a.times(half);
        self.half_b = change_b.times(half);
        self.pressed = self.impulse;
        self.turns = 1;
        self.weigh(masses);
    }

    /// Factors `K = m 1 - [r] W W [r] ...` of both bodies. A row that the rows before it imply gets no pivot, and
    /// no impulse.
    #[inline(always)]
    pub fn weigh(&mut self, masses: LaneVec) {
        let [xx, yy, zz, xy, xz, yz] = self.yields(masses);
        let x = inverse(xx, xx);
        let (yx, zx) = (xy * x, xz * x);
        let y = inverse(yy - xy * yx, yy);
        let entry = yz - zx * xy;
        let zy = entry * y;
        let z = inverse(zz - xz * zx - entry * zy, zz);
        self.factor = [yx, zx, zy];
        self.inverse = [x, y, z];
    }

    /// K: xx, yy, zz, xy, xz, yz.
    #[inline(always)]
    fn yields(&self, masses: LaneVec) -> [Lane; 6] {
        let mut k = [masses.x, masses.y, masses.z, Lane::ZERO, Lane::ZERO, Lane::ZERO];
        for ([d, o], r) in [(&self.root_a, self.lever_a), (&self.root_b, self.arm_b)] {
            // W (r x e) for the axes e.
            let x = LaneVec::new(o.x * r.z - o.y * r.y, d.y * r.z - o.z * r.y, o.z * r.z - d.z * r.y);
            let y = LaneVec::new(o.y * r.x - d.x * r.z, o.z * r.x - o.x * r.z, d.z * r.x - o.y * r.z);
            let z = LaneVec::new(d.x * r.y - o.x * r.x, o.x * r.y - d.y * r.x, o.y * r.y - o.z * r.x);
            for (sum, (p, q)) in k.iter_mut().zip([(x, x), (y, y), (z, z), (x, y), (x, z), (y, z)]) {
                *sum = *sum + p.dot(q);
            }
        }
        k
    }

    /// Solves `L D Lt x = -rate`.
    #[inline(always)]
    fn substitute(&self, rate: LaneVec) -> LaneVec {
        let [yx, zx, zy] = self.factor;
        let x = -rate.x;
        let y = -rate.y - yx * x;
        let z = -rate.z - zx * x - zy * y;
        let z = z * self.inverse[2];
        let y = y * self.inverse[1] - zy * z;
        let x = x * self.inverse[0] - yx * y - zx * z;
        LaneVec::new(x, y, z)
    }
}
