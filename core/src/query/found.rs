//! What is kept of what a query finds: the first, or the first ones in order.

use super::walk::Query;
use super::{Queries, QueryFilter};
use crate::error::Error;
use core::cmp::Ordering;

/// How much a query found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Found {
    /// Entries at the front of the buffer, in order.
    pub count: usize,
    /// What found no room: all of it comes after the last entry.
    pub dropped: usize,
}

impl Queries<'_> {
    pub(super) fn first<Q: Query>(&self, query: &Q, filter: &QueryFilter) -> Result<Option<Q::Found>, Error> {
        query.check(self)?;
        Ok(self.first_of(query, filter))
    }

    /// The first thing that a checked query finds.
    pub(super) fn first_of<Q: Query>(&self, query: &Q, filter: &QueryFilter) -> Option<Q::Found> {
        let mut best: Option<Q::Found> = None;
        query.walk(self, filter, |found| {
            let first = match best {
                Some(best) if compare::<Q>(&best, &found) != Ordering::Greater => best,
                _ => found,
            };
            best = Some(first);
            f64::from(Q::key(&first).0)
        });
        best
    }

    pub(super) fn all<Q: Query>(
        &self,
        query: &Q,
        filter: &QueryFilter,
        buffer: &mut [Q::Found],
    ) -> Result<Found, Error> {
        query.check(self)?;
        let mut found = Found::default();
        query.walk(self, filter, |item| {
            if found.count < buffer.len() {
                buffer[found.count] = item;
                found.count += 1;
                if found.count == buffer.len() {
                    make_heap::<Q>(buffer);
                }
            } else {
                found.dropped += 1;
                if let Some(last) = buffer.first_mut()
                    && compare::<Q>(&item, last) == Ordering::Less
                {
                    *last = item;
                    sink::<Q>(buffer, 0);
                }
            }
            f64::INFINITY
        });
        buffer[..found.count].sort_unstable_by(compare::<Q>);
        Ok(found)
    }
}

/// Keys are distinct but for those of equal things, and distances are numbers.
fn compare<Q: Query>(a: &Q::Found, b: &Q::Found) -> Ordering {
    let ((distance_a, slot_a, child_a), (distance_b, slot_b, child_b)) = (Q::key(a), Q::key(b));
    distance_a.total_cmp(&distance_b).then((slot_a, child_a).cmp(&(slot_b, child_b)))
}

/// Orders a full buffer so that the last in order is on top.
fn make_heap<Q: Query>(buffer: &mut [Q::Found]) {
    for index in (0..buffer.len() / 2).rev() {
        sink::<Q>(buffer, index);
    }
}

/// Lets an entry sink to its place in the heap.
fn sink<Q: Query>(buffer: &mut [Q::Found], index: usize) {
    let mut index = index;
    loop {
        let mut last = index;
        for child in [2 * index + 1, 2 * index + 2] {
            if child < buffer.len() && compare::<Q>(&buffer[child], &buffer[last]) == Ordering::Greater {
                last = child;
            }
        }
        if last == index {
            return;
        }
        buffer.swap(index, last);
        index = last;
    }
}
