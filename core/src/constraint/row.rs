//! The rows of contacts in solver order: eight links side by side.
//!
//! A row says `J u`, the rate of one relative coordinate of two bodies (SEED S5), with bounds on its impulse. The
//! talk writes `w = n . (va - vb)`; here `n` points from A to B and the rate is `n . (vb - va)`, which is the same
//! with A and B exchanged.
//!
//! Angular velocity is *whitened*: the seats hold `w~` with `w = W w~` and `W W = inverse inertia` (W symmetric,
//! fixed for the step), so
//! ```text
//! J u      = n . (vb - va) + jb . wb~ - ja . wa~        with j = W (r x n)
//! J M^-1 Jt = 1/ma + 1/mb + ja . ja + jb . jb
//! ```
//! and a row holds no inertia. `ma` comes with the seat. Body A of a link is always dynamic; an immovable B has
//! `jb = 0`, a scratch seat of zeros, and its surface's speed in the row.

use crate::lanes::{LANES, Lane, LaneVec};
use bytemuck::{Pod, Zeroable};

/// Eight links and what their points share.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
pub(crate) struct LinkRow {
    /// Seats of bodies A, from the group's first.
    pub seats_a: [u32; LANES],
    /// Seats of bodies B.
    pub seats_b: [u32; LANES],
    /// Most points of a lane.
    pub points: u32,
    /// 1 when a lane bounces.
    pub bounces: u32,
    /// 1 when a body of a lane does not move along some axis.
    pub locked: u32,
    /// 1 when a lane has fewer points than another.
    pub uneven: u32,
    /// 1 when the surface of an immovable body of a lane moves.
    pub surfaces: u32,
    /// What the next biased sweep has to do first: `TURNS` for applying `turn`, `SUMS` for adding to `total`.
    pub turns: u32,
    /// 1 when a lane resists rolling or spinning: then its row of resistances serves.
    pub resists: u32,
    /// 1 when `approach` and `total` are measured.
    pub hits: u32,
    // What every sweep reads comes first.
    pub normal: LaneVec,
    pub tangent: LaneVec,
    /// Jacobians of the first tangent.
    pub first_a: LaneVec,
    pub first_b: LaneVec,
    /// Jacobians of the second tangent, normal x tangent.
    pub second_a: LaneVec,
    pub second_b: LaneVec,
    /// Jacobians of the twist about the normal: W n.
    pub twist_a: LaneVec,
    pub twist_b: LaneVec,
    /// Number of points.
    pub count: Lane,
    /// What a common impulse of all points changes of the sum of their rates, 1/kg.
    pub inertia: Lane,
    /// Its inverse, and with the springs of overlaps; 0 for one point.
    pub press_mass: Lane,
    pub soft_press_mass: Lane,
    /// Step of both tangents: 1 / greatest eigenvalue of their 2x2 block.
    pub friction_mass: Lane,
    pub twist_mass: Lane,
    /// Coefficient of friction.
    pub friction: Lane,
    /// Mean distance of the points from the patch's center, metres: lever of the twist.
    pub radius: Lane,
    /// Impulses of the tangents and of the twist.
    pub first_impulse: Lane,
    pub second_impulse: Lane,
    pub twist_impulse: Lane,
    /// How far B's center moved relative to A's in this step: the point of contact goes with A, so B's arm is
    /// shorter by this, and action and reaction stay on one line.
    pub slide: LaneVec,
    /// Slide, squared, from which on B's arm is corrected.
    pub slide_min: Lane,
    /// Softness: share of the overlap taken back, 1/s.
    pub bias_rate: Lane,
    pub mass_scale: Lane,
    /// W of body B: diagonal, then xy, xz, yz.
    pub root_b: [LaneVec; 2],
    /// What the last change of B's arm changes of the warm start: whitened angular velocity of B, rad/s.
    pub turn: LaneVec,
    /// Coefficient of restitution.
    pub restitution: Lane,
    /// Relative velocity along the normal that gravity and forces give in a substep, m/s.
    pub push: Lane,
    /// Velocity of an immovable B's surface along tangents, and its spin about the normal.
    pub surface: LaneVec,
    /// Where hits are measured: fastest approach of a point at the start of the step, m/s, 0 when none approaches;
    /// and normal impulse of all points in the substeps before the last, N s.
    pub approach: Lane,
    pub total: Lane,
}

/// B's arm has changed.
pub(crate) const TURNS: u32 = 1;
/// A substep has ended whose impulses are to be summed.
pub(crate) const SUMS: u32 = 2;

/// One point of each of eight links. All 0 in a lane without this point.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
pub(crate) struct PointRow {
    /// Jacobians of the normal.
    pub normal_a: LaneVec,
    pub normal_b: LaneVec,
    /// 1 / (J M^-1 Jt), kg.
    pub mass: Lane,
    /// Normal impulse of the substep, N s.
    pub impulse: Lane,
    /// What the biased sweep adds to the rate, m/s; where it is positive the relax sweep does too.
    pub bias: Lane,
    /// What the contact gives in the biased sweep: the rate that it allows for each N s of impulse, 1/kg.
    pub soft: Lane,
    /// 1 / (J M^-1 Jt + soft), kg.
    pub soft_mass: Lane,
    /// `soft` of an overlap.
    pub spring: Lane,
    /// Distance along the normal now, metres.
    pub separation: Lane,
    /// Velocity of an immovable B's surface along the normal, m/s.
    pub surface: Lane,
    /// Energy over mass with which the point is to leave, m2/s2; in the bounce sweep its speed, m/s. 0 when it does
    /// not bounce.
    pub bounce: Lane,
}

/// Resistance of eight links to rolling and spinning. All 0 in a lane without.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
pub(crate) struct ResistRow {
    /// Jacobians of the relative turning about the tangents and the normal: W t, W s, W n.
    pub turns_a: [LaneVec; 3],
    pub turns_b: [LaneVec; 3],
    /// Step about both tangents: 1 / greatest eigenvalue of their 2x2 block, kg m2.
    pub roll_mass: Lane,
    pub spin_mass: Lane,
    /// Greatest torque as a share of the force of contact, metres.
    pub rolling: Lane,
    pub spinning: Lane,
    /// How an immovable B turns about the three axes, rad/s.
    pub surface: LaneVec,
    /// Impulses about them, N m s.
    pub impulse: LaneVec,
}

/// Friction of the points of eight links, each with a cone of its own; see `contact/cones.rs`. What the patch has
/// in the row of the link is their sum.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
pub(crate) struct ConeRow {
    /// Places of the points along both tangents, from the patch's middle, metres.
    pub places: [[Lane; 2]; 4],
    /// Step of each point's tangents: 1 / greatest eigenvalue of their 2x2 block, kg. 0 in a lane without this
    /// point.
    pub masses: [Lane; 4],
    /// Impulses along both tangents, N s.
    pub impulses: [[Lane; 2]; 4],
    /// What impulses of the patch change of its rates: J M^-1 Jt of the tangents and the twist, as the diagonal and
    /// then the products of the first two, of the first and third, and of the last two.
    pub yields: [Lane; 6],
}

/// How contacts are biased, from the settings.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bias {
    /// Substeps per second.
    pub rate: f32,
    /// Fastest push-out, m/s.
    pub push_speed: f32,
}

impl PointRow {
    /// Brings what the sweeps want of the point to its separation. Apart, it may close the gap in this substep, but
    /// not more. Overlapping, a spring pushes.
    #[inline(always)]
    pub fn aim(&mut self, link: &LinkRow, bias: Bias) {
        let s = self.separation;
        let apart = s.greater(Lane::ZERO);
        let push = (s * link.bias_rate).greatest(Lane::splat(-bias.push_speed));
        self.bias = apart.select(s * Lane::splat(bias.rate), push);
        self.soft = apart.select(Lane::ZERO, self.spring);
        self.soft_mass = apart.select(self.mass, self.mass * link.mass_scale);
    }
}
