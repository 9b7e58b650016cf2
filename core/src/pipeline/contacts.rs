//! The contacts of a step: those of before without the ones that ended, merged with the ones that began.
//!
//! Where nothing began or ended, as at rest, nothing is moved.

use crate::cells::{IMMOVABLE, UNORDERED};
use crate::executor::{Executor, Stage};
use crate::pipeline::tasks::{Crew, Tasks, chunk, push};
use crate::pipeline::{Counts, events};
use crate::shape::FRESH;
use crate::state::{Birth, Cache, ContactRow, MEMOS_LISTED, MEMOS_MARKED, Memo, Scratch, State, Touch};
use bytemuck::Zeroable;

/// Contacts that are worth a task to copy.
const COPY_CONTACTS: usize = 512;
/// Marks a contact that was not there in the step before.
pub(crate) const NEW: u32 = u32::MAX;
/// Marks the index of a birth.
const BORN: u32 = 1 << 31;

/// What a task of the narrowphase came to.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Yield {
    /// Its contacts of the step before.
    pub first: u32,
    pub contacts: u32,
    /// Its run of the births.
    pub first_birth: u32,
    pub born: u32,
    /// Contacts that ended: they have no points.
    pub died: u32,
    /// Contacts that began and had no room in the run.
    pub dropped: u32,
}

/// Which contacts began and ended.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Change {
    /// False when the contacts are those of before, in their places.
    pub any: bool,
    /// Contacts that ended; their bodies are in the scratch.
    pub lost: usize,
}

/// Brings the contacts in the state, their memos and touches into the order of the step.
pub(crate) fn merge<E: Executor>(
    state: &mut State<'_>,
    (cache, scratch): (&mut Cache<'_>, &mut Scratch<'_>),
    (yields, woken): (&[Yield], usize),
    (crew, counts): (&mut Crew<'_, E>, &mut Counts),
) -> Change {
    counts.dropped_contacts += yields.iter().map(|task| task.dropped).sum::<u32>();
    if woken == 0 && yields.iter().all(|task| task.born == 0 && task.died == 0) {
        return Change::default();
    }
    let before = state.header[0].contacts as usize;
    counts.contacts_before = before;
    let (count, lost) = list(state, scratch, yields, counts);
    copy_rows(&state.contacts[..before], &mut scratch.rows_before[..before], crew);
    core::mem::swap(&mut scratch.touches, &mut scratch.touches_before);
    let (low, high) = cache.memos.split_at_mut(state.contacts.len());
    let (from, to) = if cache.header[0].memo_half == 0 { (low, high) } else { (high, low) };
    cache.header[0].memo_half ^= 1;
    let source = Source {
        rows: &scratch.rows_before[..before],
        memos: &from[..before],
        touches: &scratch.touches_before[..before],
        births: scratch.births,
        woken: &scratch.woken[..woken],
    };
    let share = chunk(count, COPY_CONTACTS);
    let mut tasks: Tasks<Task<'_>> = Tasks::new();
    let parts = state.contacts[..count].chunks_mut(share).zip(to[..count].chunks_mut(share));
    let others =
        scratch.touches[..count].chunks_mut(share).zip(scratch.contact_from[..count].chunks_mut(share));
    for ((rows, memos), (touches, from)) in parts.zip(others) {
        push(&mut tasks, Task { rows, memos, touches, from });
    }
    crew.run(Stage::Narrowphase, &mut tasks, |task| task.gather(&source));
    drop(tasks);
    if before > count {
        state.contacts[count..before].fill(ContactRow::zeroed());
    }
    state.header[0].contacts = count as u32;
    Change { any: true, lost }
}

/// After a restore: brings the memos that still hold to their contacts, and marks the others.
pub(crate) fn place_memos(state: &State<'_>, cache: &mut Cache<'_>) {
    if cache.header[0].memos_fit != MEMOS_LISTED {
        return;
    }
    let (low, high) = cache.memos.split_at_mut(state.contacts.len());
    let (from, to) = if cache.header[0].memo_half == 0 { (low, high) } else { (high, low) };
    let count = state.header[0].contacts as usize;
    for (memo, &source) in to[..count].iter_mut().zip(&*cache.memo_sources) {
        match from.get(source as usize) {
            Some(known) => *memo = *known,
            None => memo.is_unknown = 1,
        }
    }
    cache.header[0].memo_half ^= 1;
    cache.header[0].memos_fit = MEMOS_MARKED;
}

/// Lists where each contact comes from, and the bodies of those that ended. When there are too many, those of
/// before stay and pair order decides among the new. Returns the number of contacts, and of those that ended.
fn list(
    state: &State<'_>,
    scratch: &mut Scratch<'_>,
    yields: &[Yield],
    counts: &mut Counts,
) -> (usize, usize) {
    let kept: u32 = yields.iter().map(|task| task.contacts - task.died).sum();
    let mut room = state.contacts.len() - kept as usize;
    let (mut count, mut lost) = (0, 0);
    let mut add = |from: u32| {
        scratch.contact_from[count] = from;
        count += 1;
    };
    for task in yields {
        let mut old = task.first;
        let mut keep_until = |end: u32, add: &mut dyn FnMut(u32)| {
            for index in old..end {
                let row = &state.contacts[index as usize];
                if row.tag.points() > 0 {
                    add(index);
                } else {
                    events::note(scratch.ended, &mut counts.ended, row.pair);
                    scratch.lost[lost] = [row.pair.a, row.pair.b].map(|slot| known_body(state, slot));
                    lost += 1;
                }
            }
            old = end;
        };
        for birth in task.first_birth..task.first_birth + task.born {
            keep_until(scratch.births[birth as usize].before, &mut add);
            if room > 0 {
                room -= 1;
                add(BORN | birth);
                events::note(scratch.began, &mut counts.began, scratch.births[birth as usize].row.pair);
            } else {
                counts.dropped_contacts += 1;
            }
        }
        keep_until(task.first + task.contacts, &mut add);
    }
    (count, lost)
}

/// The dynamic body of a shape that is what it was in the step before, or `IMMOVABLE`.
fn known_body(state: &State<'_>, slot: u32) -> u32 {
    let shape = &state.shapes[slot as usize];
    let known = crate::pool::is_used(state.shape_used, slot) && shape.flags & FRESH == 0;
    if known && state.bodies[shape.body as usize].is_dynamic() { shape.body } else { IMMOVABLE }
}

/// Everything in the order of before.
struct Source<'a> {
    rows: &'a [ContactRow],
    memos: &'a [Memo],
    touches: &'a [Touch],
    births: &'a [Birth],
    /// Places of contacts that came back from sleep: to the ordering they are new.
    woken: &'a [u32],
}

/// A run of contacts in the order of this step.
struct Task<'a> {
    rows: &'a mut [ContactRow],
    memos: &'a mut [Memo],
    touches: &'a mut [Touch],
    from: &'a mut [u32],
}

impl Task<'_> {
    fn gather(&mut self, source: &Source<'_>) {
        for (i, from) in self.from.iter_mut().enumerate() {
            if *from & BORN == 0 {
                let old = *from as usize;
                self.rows[i] = source.rows[old];
                self.memos[i] = source.memos[old];
                self.touches[i] = source.touches[old];
                if !source.woken.is_empty() {
                    let before = source.woken.partition_point(|&place| place < *from);
                    let is_woken = source.woken.get(before) == Some(from);
                    *from = if is_woken { NEW } else { *from - before as u32 };
                }
            } else {
                let birth = &source.births[(*from & !BORN) as usize];
                self.rows[i] = birth.row;
                self.memos[i] = birth.memo;
                self.touches[i] = birth.touch;
                *from = NEW;
                debug_assert!(birth.row.tag.phase() == UNORDERED);
            }
        }
    }
}

fn copy_rows<E: Executor>(from: &[ContactRow], to: &mut [ContactRow], crew: &mut Crew<'_, E>) {
    let share = chunk(from.len(), COPY_CONTACTS);
    let mut tasks: Tasks<(&[ContactRow], &mut [ContactRow])> =
        from.chunks(share).zip(to.chunks_mut(share)).collect();
    crew.run(Stage::Narrowphase, &mut tasks, |(from, to)| to.copy_from_slice(from));
}
