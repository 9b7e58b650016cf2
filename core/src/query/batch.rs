//! Many queries on an executor: each task owns a part of the results.

use super::walk::Query;
use super::{Queries, QueryFilter};
use crate::error::Error;
use crate::executor::{Executor, Stage};
use crate::pipeline::tasks::{Tasks, chunk, push};

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
        let mut tasks: Tasks<(&[Q], &mut [Option<Q::Found>])> = Tasks::new();
        for task in batch.chunks(share).zip(results.chunks_mut(share)) {
            push(&mut tasks, task);
        }
        let run = |(queries, results): &mut (&[Q], &mut [Option<Q::Found>])| {
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
