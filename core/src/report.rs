//! What a step tells.

/// Counts of one step. All of them follow from the scene alone, never from the executor.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
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
}
