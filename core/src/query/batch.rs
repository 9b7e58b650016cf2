//! Many queries on an executor: each task owns a part of the results.

use super::walk::Query;
use super::{Queries, QueryFilter};
use crate::error::Error;
use crate::executor::{Executor, Stage};
use crate::pipeline::tasks::{Tasks, chunk, push};

/// Some queries, and where their results go.
type Task<'t, Q> = (&'t [Q], &'t mut [Option<<Q as Query>::Found>]);

/// Queries that are worth a task.
const BATCH_QUERIES: usize = 32;

impl Queries<'_> {
    pub(super) fn batch<Q: Query>(
        &self,
        batch: &[Q],
        filter: &QueryFilter,
        results: &mut [Option<Q::Found>],
        executor: &mut impl Executor,
    ) -> Result<(), Error> {
        if results.len() != batch.len() {
            return Err(Error::WrongLength { needed: batch.len(), given: results.len() });
        }
        for query in batch {
            query.check(self)?;
        }
        let share = chunk(batch.len(), BATCH_QUERIES);
        let mut tasks: Tasks<Task<'_, Q>> = Tasks::new();
        for task in batch.chunks(share).zip(results.chunks_mut(share)) {
            push(&mut tasks, task);
        }
        let run = |(queries, results): &mut Task<'_, Q>| {
            for (query, result) in queries.iter().zip(results.iter_mut()) {
                *result = self.first_of(query, filter);
            }
        };
        match &mut tasks[..] {
            [] => {}
            [task] => run(task),
            tasks => executor.for_each(Stage::Query, tasks, run),
        }
        Ok(())
    }
}
