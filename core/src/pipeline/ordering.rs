//! Ordering: which links are solved side by side (SEED S17 to S20), and where their rows lie.
//!
//! The ordering is state; a step touches what contacts that began or ended have changed of it. Where none did, and
//! every contact has as many points as before, the layout of the step before serves again.

use crate::cells::{self, IMMOVABLE, Link, NEW, OrderingState, Scheduler, UNORDERED, Upkeep};
use crate::executor::{Executor, Stage};
use crate::pipeline::contacts::Change;
use crate::pipeline::layout::{self, Plan};
use crate::pipeline::tasks::{Crew, Tasks, chunk, push};
use crate::state::{Cache, ContactRow, Scratch, State, Touch};

/// Contacts whose links are worth a task.
const LINK_CONTACTS: usize = 1024;

/// Orders the links and lays them out in seats and lanes. A `scheduler` replaces the cellular ordering for
/// this step.
pub(crate) fn run<S: Scheduler>(
    state: &mut State<'_>,
    (cache, scratch): (&mut Cache<'_>, &mut Scratch<'_>),
    (change, block_links, bodies): (&Change, u32, usize),
    scheduler: Option<&mut S>,
) -> Plan {
    let count = state.header[0].contacts as usize;
    let kept = keep(state, (cache, scratch), change, block_links);
    let header = &cache.header[0];
    let same_size = header.laid_out as usize == count + 1 && header.laid_out_bodies as usize == bodies;
    if kept && scheduler.is_none() && same_size && cache.links[..count] == scratch.links[..count] {
        return cache.plan[0];
    }
    // A layout by another ordering serves one step only.
    cache.header[0].laid_out = if scheduler.is_none() { count as u32 + 1 } else { 0 };
    cache.header[0].laid_out_bodies = bodies as u32;
    let blocks = schedule(cache, scratch, (bodies, count), scheduler);
    let plan = lay_out(cache, scratch, (bodies, count, blocks));
    cache.links[..count].copy_from_slice(&scratch.links[..count]);
    cache.plan[0] = plan;
    plan
}

/// Brings the ordering to the step's links. True when it is that of the step before.
fn keep(
    state: &mut State<'_>,
    (cache, scratch): (&mut Cache<'_>, &mut Scratch<'_>),
    change: &Change,
    block_links: u32,
) -> bool {
    let count = state.header[0].contacts as usize;
    let links = &scratch.slot_links[..count];
    let phases = &mut scratch.phases[..count];
    let fits = cache.header[0].ordering_fits != 0;
    let same = !change.any && state.ordering[0].is_calm();
    if same && fits {
        return true;
    }
    let mut upkeep = Upkeep::new(state.bodies.len(), state.contacts.len(), cache.ordering);
    for (phase, row) in phases.iter_mut().zip(&*state.contacts) {
        *phase = row.tag.phase();
    }
    cache.header[0].ordering_fits = 1;
    if same {
        upkeep.recall(links, phases, state.dirt, scratch.ordering);
        return true;
    }
    let from = &mut scratch.contact_from[..count];
    if !change.any {
        from.iter_mut().zip(0..).for_each(|(from, index)| *from = index);
    }
    debug_assert!(from.iter().zip(&*phases).all(|(from, phase)| (*from == NEW) == (*phase == UNORDERED)));
    let change = cells::Change { links, from, lost: &scratch.lost[..change.lost], cached: fits, block_links };
    let ordering = OrderingState { row: &mut state.ordering[0], dirt: state.dirt, phases };
    upkeep.update(&change, ordering, scratch.ordering);
    for (row, phase) in state.contacts.iter_mut().zip(&*phases) {
        row.tag.set_phase(*phase);
    }
    false
}

/// Writes the schedule; returns the number of blocks.
fn schedule<S: Scheduler>(
    cache: &mut Cache<'_>,
    scratch: &mut Scratch<'_>,
    (bodies, count): (usize, usize),
    scheduler: Option<&mut S>,
) -> usize {
    let mut schedule =
        cells::Schedule { order: &mut scratch.order[..count], blocks: scratch.blocks, block_count: 0 };
    match scheduler {
        Some(scheduler) => {
            scheduler.schedule(bodies as u32, &scratch.links[..count], scratch.ordering, &mut schedule);
        }
        None => {
            let upkeep = Upkeep::new(scratch.active_of.len(), scratch.links.len(), cache.ordering);
            upkeep.schedule(&scratch.slot_links[..count], scratch.ordering, &mut schedule);
        }
    }
    if cfg!(debug_assertions) {
        let links = &scratch.links[..count];
        assert_eq!(cells::check(bodies as u32, links, &schedule, scratch.ordering), Ok(()));
    }
    schedule.block_count
}

fn lay_out(
    cache: &mut Cache<'_>,
    scratch: &mut Scratch<'_>,
    (bodies, count, blocks): (usize, usize, usize),
) -> Plan {
    let links = &scratch.links[..count];
    let schedule = layout::Schedule {
        links,
        order: &scratch.order[..count],
        blocks: &scratch.blocks[..blocks],
        bodies: bodies as u32,
    };
    let mut tables = layout::Tables {
        groups: cache.groups,
        lane_contacts: cache.lane_contacts,
        lane_seats: cache.lane_seats,
        contact_places: cache.contact_places,
        seat_sources: cache.seat_sources,
        seat_bodies: cache.seat_bodies,
        last_seats: cache.last_seats,
        phase_seats: scratch.phase_seats,
        first_seats: cache.first_seats,
        block_chains: scratch.block_chains,
    };
    layout::lay_out(&schedule, &mut tables, |contact| 4 - links[contact as usize].kind)
}

/// Writes the links of the step, between active bodies for the layout and between slots for the ordering.
pub(crate) fn write_links<E: Executor>(state: &State<'_>, scratch: &mut Scratch<'_>, crew: &mut Crew<'_, E>) {
    struct Task<'a> {
        rows: &'a [ContactRow],
        touches: &'a [Touch],
        links: &'a mut [Link],
        slot_links: &'a mut [Link],
    }
    let count = state.header[0].contacts as usize;
    let share = chunk(count, LINK_CONTACTS);
    let (reaches, active_of) = (&*scratch.reaches, &*scratch.active_of);
    let from = state.contacts[..count].chunks(share).zip(scratch.touches[..count].chunks(share));
    let links = scratch.links[..count].chunks_mut(share);
    let mut tasks: Tasks<Task<'_>> = Tasks::new();
    for ((rows, touches), (links, slot_links)) in
        from.zip(links.zip(scratch.slot_links[..count].chunks_mut(share)))
    {
        push(&mut tasks, Task { rows, touches, links, slot_links });
    }
    crew.run(Stage::Islands, &mut tasks, |task| {
        let links = task.links.iter_mut().zip(task.slot_links.iter_mut());
        for ((row, touch), (link, slot_link)) in task.rows.iter().zip(task.touches).zip(links) {
            let slots = touch.shapes.map(|shape| reaches[shape as usize].body);
            let active = slots.map(|slot| active_of[slot as usize]);
            // Links with more points first: neighbours in a lane should have as many.
            let kind = 4 - row.tag.points() as u32;
            let b = if active[1] == IMMOVABLE { IMMOVABLE } else { slots[1] };
            *link = Link { a: active[0], b: active[1], kind };
            *slot_link = Link { a: slots[0], b, kind };
        }
    });
}
