//! Looking at a step from inside: the state after each stage.
//!
//! For finding where two steps part that should be equal. A step without an observer has no trace of this: the type
//! `()` observes nothing, and compiles to nothing.

mod problem;

use crate::executor::Stage;
use crate::pipeline::layout::Plan;
use crate::state::{Cache, Scratch, State, sections_in_use};
use bytemuck::cast_slice;

pub use problem::{ProblemBody, ProblemKind, ProblemRow};

/// Looks at a step: see [`World::step_observed`](crate::World::step_observed).
pub trait Observer {
    /// Called when a stage has ended, on the thread that steps. Integration is fused into the solve. The solve's
    /// results are in its rows until the stage [`Stage::Finish`] writes them into the state.
    fn after(&mut self, stage: Stage, view: &StageView<'_, '_>);
}

impl Observer for () {
    #[inline(always)]
    fn after(&mut self, _: Stage, _: &StageView<'_, '_>) {}
}

/// What there is to see after a stage.
pub struct StageView<'a, 's> {
    state: &'a State<'s>,
    rows: Option<Rows<'a, 's>>,
}

/// What the rows of a step lie in.
#[derive(Clone, Copy)]
pub(crate) struct Rows<'a, 's> {
    pub scratch: &'a Scratch<'s>,
    pub cache: &'a Cache<'s>,
    pub plan: &'a Plan,
    /// Bodies that are solved.
    pub bodies: usize,
}

/// A run of rows with its name.
pub type Named<'a> = (&'static str, &'a [u8]);

impl<'a, 's> StageView<'a, 's> {
    #[inline(always)]
    pub(crate) fn new(state: &'a State<'s>) -> Self {
        Self { state, rows: None }
    }

    #[inline(always)]
    pub(crate) fn with_rows(state: &'a State<'s>, rows: Rows<'a, 's>) -> Self {
        Self { state, rows: Some(rows) }
    }

    /// The sections of the state, as far as they are in use, in the order and with the names of
    /// [`World::checksum_by_section`](crate::World::checksum_by_section).
    pub fn sections(&self) -> impl Iterator<Item = Named<'a>> + use<'a, 's> {
        let state = self.state;
        macro_rules! section {
            ($name:ident, $rows:expr) => {
                (stringify!($name), cast_slice(&state.$name[..$rows.min(state.$name.len())]))
            };
        }
        sections_in_use!(&state.header[0], section).into_iter()
    }

    /// The rows of the solver, after [`Stage::Assembly`] and [`Stage::Solve`]; none after others. They follow from
    /// the state alone.
    pub fn rows(&self) -> impl Iterator<Item = Named<'a>> + use<'a, 's> {
        let rows = self.rows.map(|Rows { scratch, plan, .. }| {
            macro_rules! used {
                ($($name:ident: $count:expr),* $(,)?) => {
                    [$((stringify!($name), cast_slice(&scratch.$name[..($count).min(scratch.$name.len())]))),*]
                };
            }
            used!(
                link_rows: plan.rows,
                point_rows: plan.points,
                ball_rows: plan.balls,
                joint_links: plan.joints - plan.balls,
                lock_rows: plan.locks,
                bound_rows: plan.bounds,
                seats: plan.seats,
            )
        });
        rows.into_iter().flatten()
    }
}
