//! Looking at a step from inside: the state after each stage.
//!
//! For finding where two steps part that should be equal. A step without an observer has no trace of this: the type
//! `()` observes nothing, and compiles to nothing.

use crate::executor::Stage;
use crate::pipeline::layout::Plan;
use crate::state::{Scratch, State, sections_in_use};
use bytemuck::cast_slice;

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
    rows: Option<(&'a Scratch<'s>, &'a Plan)>,
}

/// A run of rows with its name.
pub type Named<'a> = (&'static str, &'a [u8]);

impl<'a, 's> StageView<'a, 's> {
    #[inline(always)]
    pub(crate) fn new(state: &'a State<'s>) -> Self {
        Self { state, rows: None }
    }

    #[inline(always)]
    pub(crate) fn with_rows(state: &'a State<'s>, scratch: &'a Scratch<'s>, plan: &'a Plan) -> Self {
        Self { state, rows: Some((scratch, plan)) }
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
        let rows = self.rows.map(|(scratch, plan)| {
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
