//! What a step tells.

use crate::math::max;

/// What one step counts and measures. All of it follows from the scene alone, never from the executor.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StepReport {
    /// Steps taken so far, this one included.
    pub step: u64,
    /// Bodies in the world.
    pub bodies: u32,
    /// Bodies that were solved.
    pub active: u32,
    /// Of these, bodies that were refined: see [`Settings::refine`](crate::Settings::refine).
    pub refined: u32,
    /// Bodies that sleep at the end of the step.
    pub asleep: u32,
    /// Pairs of shapes whose boxes overlap.
    pub pairs: u32,
    /// Contacts, each a manifold of 1 to 4 points: the links of the ordering.
    pub contacts: u32,
    /// Joints in the world.
    pub joints: u32,
    /// Phases of a sweep: barriers between them.
    pub phases: u32,
    /// Blocks of all phases.
    pub blocks: u32,
    /// Calls of the executor with two tasks or more: synchronisations of this step.
    pub barriers: u32,
    /// Pairs and contacts that found no room.
    pub dropped: u32,
    /// Bodies that were no longer finite and were stopped for good.
    pub quarantined: u32,
    /// Bodies whose speed or spin was capped.
    pub capped: u32,
    /// Fast bodies that were stopped on their way, at a surface that they would have passed.
    pub cut: u32,
    /// Joints that broke in this step.
    pub broken: u32,
    /// Events of this step: see [`World::events`](crate::World::events).
    pub events: u32,
    /// Events that found no room.
    pub dropped_events: u32,
    /// Shapes in sensors, each counted once for each sensor.
    pub visits: u32,
    /// Visits that found no room.
    pub dropped_visits: u32,
    /// Biased sweeps of all substeps: more than the settings say where a
    /// [tolerance](crate::Settings::tolerance) asked for more. Those of refined islands count too.
    pub sweeps: u32,
    /// Substeps that had their most sweeps and ended with more than the tolerance.
    pub unsettled: u32,
    /// How far the solve was from the answer; `None` unless [`Settings::residual`](crate::Settings::residual) asks
    /// for it, and in a step of no time.
    pub residuals: Option<Residuals>,
}

/// How far the rows of a step's last substep were from the condition on their impulses (SEED S8: a row whose rate
/// grows has its least impulse, one whose rate falls its greatest, any other a rate of 0).
///
/// A substep has two kinds of sweeps, with two kinds of rows. *Biased* sweeps want gaps and overlaps corrected,
/// give where contacts are soft, and find the loads; then the bodies move. *Relax* sweeps want no more than
/// that nothing approaches at the new places. Each is a problem of its own, so both are measured: after the
/// last sweep of its kind, with what that sweep asked. Left out are the nudges that take back errors of
/// position without becoming velocity (joints, split contacts), and the speeds that restitution gives after the
/// last sweep.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Residuals {
    /// After the last biased sweep.
    pub biased: Residual,
    /// After the last sweep of all: the last relax sweep, or the last biased one where there is no relax sweep.
    pub last: Residual,
}

/// The greatest residual of rows, by kind, m/s, at least 0: of a row that is within its bounds, how fast its bodies
/// still move along it against what it wants; of one at a bound, no more than what the bound leaves to change.
/// 0 where the condition holds. For example 0.01: no two bodies approach by more than 1 cm each second along a
/// contact that could still push.
///
/// It is the natural map `|lambda - clamp(lambda - m w)| / m`, with the rate w, the row's inverse mass 1 / m, and
/// what a row of turning turns taken at its radius of gyration. Rounding leaves about 1e-7 of the fastest speed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Residual {
    /// Points of contacts along their normals.
    pub normal: f32,
    /// Friction of contacts: sliding, twist, and resistance to rolling and spinning.
    pub friction: f32,
    /// Joints: what they hold, limits, drives and friction.
    pub joint: f32,
}

impl Residual {
    /// The greatest of all rows, m/s.
    pub fn greatest(&self) -> f32 {
        max(self.normal, max(self.friction, self.joint))
    }

    /// The greater of both, kind by kind.
    pub fn with(&self, other: &Self) -> Self {
        Self {
            normal: max(self.normal, other.normal),
            friction: max(self.friction, other.friction),
            joint: max(self.joint, other.joint),
        }
    }
}
