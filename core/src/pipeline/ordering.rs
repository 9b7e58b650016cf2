//! Ordering: which links are solved side by side (SEED S17 to S20), and where their rows lie.
//!
//! The ordering is state; a step touches what contacts that began or ended have changed of it. Where none did, and
//! every contact has as many points as before, the layout of the step before serves again.

use crate::cells::{self, Block, IMMOVABLE, Link, NEW, OrderingState, Scheduler, UNORDERED, Upkeep};
use crate::config::Settings;
use crate::executor::{Executor, Stage};
use crate::joint::Signature;
use crate::joint::{BROKEN, JointRow};
use crate::pipeline::articulations::ArticulationRow;
use crate::pipeline::contacts::Change;
use crate::pipeline::layout::{self, Plan, REFINED_KIND, TIERS};
use crate::pipeline::tasks::{Crew, Tasks, chunk, push};
use crate::pipeline::{articulations, balls, refine};
use crate::state::{
    ALL_LOOSE, Cache, CacheHeader, ContactRow, ORDERING_FITS, ORDERING_UNCHECKED, Scratch, State, Touch,
};

/// Contacts whose links are worth a task.
const LINK_CONTACTS: usize = 1024;

/// Orders the links and lays them out in seats and lanes. A `scheduler` replaces the cellular ordering for
/// this step.
pub(crate) fn run<S: Scheduler>(
    state: &mut State<'_>,
    (cache, scratch): (&mut Cache<'_>, &mut Scratch<'_>),
    (change, links, settings): (&Change, Links, &Settings),
    scheduler: Option<&mut S>,
) -> Plan {
    let (count, all) = (links.contacts + links.joints, links.contacts + links.held());
    let kept = keep(state, (cache, scratch), (change, links), settings.block_links);
    let refined = note_refined(state, scratch, links.bodies);
    let same_tiers = scratch.active_refined[..refined] == cache.refined[..refined]
        && cache.refined[refined..].iter().all(|&bits| bits == 0);
    let header = &cache.header[0];
    let same_size = header.laid_out as usize == all + 1 && header.laid_out_bodies as usize == links.bodies;
    if kept && scheduler.is_none() && same_size && same_tiers && cache.links[..all] == scratch.links[..all] {
        return cache.plan[0];
    }
    // A layout by another ordering serves one step only.
    cache.header[0].laid_out = if scheduler.is_none() { all as u32 + 1 } else { 0 };
    cache.header[0].laid_out_bodies = links.bodies as u32;
    let is_own = scheduler.is_none();
    let mut blocks = schedule(cache, scratch, (links.bodies, count), scheduler);
    if refined > 0 && !is_own {
        blocks = split_blocks(state, scratch, blocks);
    }
    let plan = lay_out(state, (cache, scratch), (links, blocks), refined);
    cache.refined.fill(0);
    cache.refined[..refined].copy_from_slice(&scratch.active_refined[..refined]);
    cache.links[..all].copy_from_slice(&scratch.links[..all]);
    cache.plan[0] = plan;
    plan
}

/// How many there are of what is ordered.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Links {
    pub bodies: usize,
    pub contacts: usize,
    /// Joints that are links of the ordering.
    pub joints: usize,
    /// Joints of articulations: they come after those.
    pub articulated: usize,
}

impl Links {
    /// Joints that hold something.
    pub fn held(&self) -> usize {
        self.joints + self.articulated
    }
}

/// Brings the ordering to the step's links. True when it is that of the step before.
fn keep(
    state: &mut State<'_>,
    (cache, scratch): (&mut Cache<'_>, &mut Scratch<'_>),
    (change, count): (&Change, Links),
    block_links: u32,
) -> bool {
    let all = count.contacts + count.joints;
    let joints = follow_joints(state, scratch, (change.lost, count.joints));
    let fits = cache.header[0].ordering_fits == ORDERING_FITS;
    let same = !change.any && !joints.any && state.ordering[0].is_calm();
    if same && fits {
        return true;
    }
    let mut upkeep = Upkeep::new(state.bodies.len(), scratch.links.len(), cache.ordering);
    let links = &scratch.slot_links[..all];
    let phases = &mut scratch.phases[..all];
    for (phase, row) in phases.iter_mut().zip(&state.contacts[..count.contacts]) {
        *phase = row.tag.phase();
    }
    let slots = &scratch.joint_slots[..count.joints];
    for (phase, &slot) in phases[count.contacts..].iter_mut().zip(slots) {
        *phase = state.joints[slot as usize].phase as u8;
    }
    let unchecked = cache.header[0].ordering_fits == ORDERING_UNCHECKED;
    cache.header[0].ordering_fits = ORDERING_FITS;
    if same {
        if unchecked && upkeep.is_of(links, phases) {
            upkeep.refresh_dirt(state.dirt);
        } else {
            upkeep.recall(links, phases, state.dirt, scratch.ordering);
            // The layout is of the ordering that was.
            cache.header[0].laid_out = 0;
        }
        note_joints((&mut cache.header[0], cache.ordered_joints), (slots, count));
        return true;
    }
    let from = &mut scratch.contact_from[..all];
    if !change.any {
        from[..count.contacts].iter_mut().zip(0..).for_each(|(from, index)| *from = index);
    }
    let before = (&cache.header[0], &*cache.ordered_joints);
    joints_from(before, (slots, state.joints), &mut from[count.contacts..], fits);
    debug_assert!(from.iter().zip(&*phases).all(|(from, phase)| (*from == NEW) == (*phase == UNORDERED)));
    let change = cells::Change { links, from, lost: &scratch.lost[..joints.lost], cached: fits, block_links };
    let ordering = OrderingState { row: &mut state.ordering[0], dirt: state.dirt, phases };
    upkeep.update(&change, ordering, scratch.ordering);
    for (row, phase) in state.contacts.iter_mut().zip(&phases[..count.contacts]) {
        row.tag.set_phase(*phase);
    }
    for (&slot, phase) in slots.iter().zip(&phases[count.contacts..]) {
        state.joints[slot as usize].phase = u32::from(*phase);
    }
    note_joints((&mut cache.header[0], cache.ordered_joints), (slots, count));
    false
}

/// Notes the joints of the last update, so that the next one knows them again.
fn note_joints((header, noted): (&mut CacheHeader, &mut [u32]), (slots, count): (&[u32], Links)) {
    noted[..slots.len()].copy_from_slice(slots);
    header.ordered_contacts = count.contacts as u32;
    header.ordered_joints = slots.len() as u32;
}

/// Which joints began or ended to be links.
struct JointChange {
    any: bool,
    /// Links that ended, those of contacts included.
    lost: usize,
}

/// Takes their phases from joints that are no links any more, and adds their bodies to the `lost`.
fn follow_joints(
    state: &mut State<'_>,
    scratch: &mut Scratch<'_>,
    (lost, links): (usize, usize),
) -> JointChange {
    let mut change = JointChange { any: state.header[0].joints_stale != 0, lost };
    state.header[0].joints_stale = 0;
    let mut slots = scratch.joint_slots[..links].iter().copied().peekable();
    for slot in crate::pool::iterate(state.joint_used, state.header[0].joints.high) {
        let joint = &mut state.joints[slot as usize];
        let is_ordered = joint.phase != u32::from(UNORDERED);
        if slots.next_if_eq(&slot).is_some() {
            change.any |= !is_ordered;
        } else if is_ordered {
            joint.phase = u32::from(UNORDERED);
            let end = |body: u32| if state.bodies[body as usize].is_dynamic() { body } else { IMMOVABLE };
            scratch.lost[change.lost] = joint.bodies.map(end);
            change.lost += 1;
            change.any = true;
        }
    }
    change
}

/// Where each joint was among the links of the last update. Without a cache any ascending numbers serve.
fn joints_from(
    (header, noted): (&CacheHeader, &[u32]),
    (slots, joints): (&[u32], &[JointRow]),
    from: &mut [u32],
    cached: bool,
) {
    let before = &noted[..if cached { header.ordered_joints as usize } else { 0 }];
    let mut place = 0;
    for ((from, &slot), index) in from.iter_mut().zip(slots).zip(0_u32..) {
        *from = NEW;
        if joints[slot as usize].phase == u32::from(UNORDERED) {
            continue;
        }
        if !cached {
            // More than any contact had.
            *from = u32::MAX / 2 + index;
            continue;
        }
        while before.get(place).is_some_and(|&old| old < slot) {
            place += 1;
        }
        debug_assert!(before.get(place) == Some(&slot), "an ordered joint was in the last update");
        *from = header.ordered_contacts + place as u32;
    }
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

/// Another scheduler may put several islands in a block: makes a block for each tier of them. The links of a tier
/// keep their order. Returns the number of blocks.
fn split_blocks(state: &State<'_>, scratch: &mut Scratch<'_>, blocks: usize) -> usize {
    let mut end = blocks;
    for index in 0..blocks {
        let block = scratch.blocks[index];
        let own = &mut scratch.order[block.first as usize..(block.first + block.count) as usize];
        let (mut coarse, mut fine) = (0, 0);
        for i in 0..own.len() {
            let link = own[i];
            if refine::tier_of(state, scratch.slot_links[link as usize].a) == 0 {
                own[coarse] = link;
                coarse += 1;
            } else {
                scratch.block_chains[fine] = link;
                fine += 1;
            }
        }
        own[coarse..].copy_from_slice(&scratch.block_chains[..fine]);
        if coarse > 0 && fine > 0 {
            scratch.blocks[index].count = coarse as u32;
            scratch.blocks[end] = Block { first: block.first + coarse as u32, count: fine as u32, ..block };
            end += 1;
        }
    }
    end
}

fn lay_out(
    state: &State<'_>,
    (cache, scratch): (&mut Cache<'_>, &mut Scratch<'_>),
    (links, blocks): (Links, usize),
    refined: usize,
) -> Plan {
    let count = links.contacts + links.joints;
    let blocks = &mut scratch.blocks[..blocks];
    let articulations = &cache.articulations[..cache.header[0].articulations as usize];
    let (mut cut, mut cut_articulations) = (blocks.len(), articulations.len());
    if refined > 0 {
        let tier = |link: u32| refine::tier_of(state, scratch.slot_links[link as usize].a);
        let of_block = |block: &Block| tier(scratch.order[block.first as usize]);
        blocks.sort_unstable_by_key(|block| (of_block(block), block.phase, block.first));
        cut = blocks.partition_point(|block| of_block(block) == 0);
        let of_row = |row: &ArticulationRow| tier(links.contacts as u32 + row.first[0]);
        cut_articulations = articulations.iter().take_while(|row| of_row(row) == 0).count();
    }
    let schedule = layout::Schedule {
        links: &scratch.links[..links.contacts + links.held()],
        contacts: links.contacts as u32,
        order: &scratch.order[..count],
        articulations: articulations.split_at(cut_articulations).into(),
        blocks: <[&[Block]; TIERS]>::from(blocks.split_at(cut)),
        bodies: links.bodies as u32,
        refined: &scratch.active_refined[..refined],
    };
    let mut tables = layout::Tables {
        groups: cache.groups,
        lane_contacts: cache.lane_contacts,
        lane_seats: cache.lane_seats,
        contact_places: cache.contact_places,
        lane_joints: cache.lane_joints,
        joint_seats: cache.joint_seats,
        joint_places: cache.joint_places,
        joint_keys: scratch.joint_keys,
        seat_sources: cache.seat_sources,
        seat_bodies: cache.seat_bodies,
        last_seats: cache.last_seats,
        phase_seats: scratch.phase_seats,
        first_seats: cache.first_seats,
        block_chains: scratch.block_chains,
        body_rows: scratch.body_rows,
    };
    layout::lay_out(&schedule, &mut tables)
}

/// Notes which of the active bodies are refined. Returns the number of words: none where no body is.
fn note_refined(state: &State<'_>, scratch: &mut Scratch<'_>, bodies: usize) -> usize {
    if state.header[0].refine == 0 {
        return 0;
    }
    let words = crate::pool::words(bodies);
    scratch.active_refined[..words].fill(0);
    for (i, active) in scratch.active[..bodies].iter().enumerate() {
        scratch.active_refined[i / 64] |= (refine::tier_of(state, active.body) as u64) << (i % 64);
    }
    words
}

/// Writes the links of the step's contacts, between active bodies for the layout and between slots for the
/// ordering. Returns how many they are.
pub(crate) fn write_contacts<E: Executor>(
    state: &State<'_>,
    scratch: &mut Scratch<'_>,
    crew: &mut Crew<'_, E>,
) -> usize {
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
            (*link, *slot_link) =
                link_of(slots, active_of, layout::contact_kind(row.tag.points(), touch.settled < 0.0));
        }
    });
    count
}

/// A link between active bodies, and between slots. The first end moves.
#[inline(always)]
fn link_of(slots: [u32; 2], active_of: &[u32], kind: u32) -> (Link, Link) {
    let active = slots.map(|slot| active_of[slot as usize]);
    let b = if active[1] == IMMOVABLE { IMMOVABLE } else { slots[1] };
    (Link { a: active[0], b: active[1], kind }, Link { a: slots[0], b, kind })
}

/// Writes the links of joints that hold a dynamic body after the contacts, by place. Returns how many are loose.
pub(crate) fn write_joints(
    state: &State<'_>,
    (cache, scratch): (&mut Cache<'_>, &mut Scratch<'_>),
    (contacts, held): (usize, usize),
    direct: bool,
) -> usize {
    if state.header[0].refine != 0 {
        for link in &mut scratch.held_links[..held] {
            let slot = if link.a == IMMOVABLE { link.b } else { link.a };
            link.kind |= refine::tier_of(state, slot) as u32 * REFINED_KIND;
        }
    }
    let loose = arrange(cache, scratch, held, direct);
    let active_of = &*scratch.active_of;
    for (rank, &slot) in scratch.held_slots[..held].iter().enumerate() {
        let place = cache.joint_order[rank] as usize;
        scratch.joint_slots[place] = slot;
        let link = scratch.held_links[rank];
        let is_plain = place < loose && balls::is_plain(state, &state.joints[slot as usize], &link);
        let Link { a, b, kind } = Link {
            kind: if is_plain { Signature::PLAIN.0 } else { Signature::of_kind(link.kind).0 },
            ..link
        };
        let (a, b) = if a == IMMOVABLE { (b, a) } else { (a, b) };
        let active = |body: u32| active_of.get(body as usize).copied().unwrap_or(IMMOVABLE);
        let i = contacts + place;
        scratch.links[i] = Link { a: active(a), b: active(b), kind };
        scratch.slot_links[i] = Link { a, b, kind };
    }
    loose
}

/// Lists the joints that hold a dynamic body, ascending, and their links. Returns how many they are.
pub(crate) fn list_held(state: &State<'_>, scratch: &mut Scratch<'_>) -> usize {
    let active_of = &*scratch.active_of;
    let mut held = 0;
    for slot in crate::pool::iterate(state.joint_used, state.header[0].joints.high) {
        let joint = &state.joints[slot as usize];
        let signature = joint.signature();
        let holds = signature.lock_rows() + signature.bound_rows() > 0 && !joint.has(BROKEN);
        let end = |body: u32| if active_of[body as usize] == IMMOVABLE { IMMOVABLE } else { body };
        let [a, b] = joint.bodies.map(end);
        if holds && (a != IMMOVABLE || b != IMMOVABLE) {
            scratch.held_slots[held] = slot;
            scratch.held_links[held] = Link { a, b, kind: signature.0 };
            held += 1;
        }
    }
    held
}

/// Arranges the held joints, unless they are those of the step before: for a direct solve, or all of them loose.
/// Returns how many are loose.
fn arrange(cache: &mut Cache<'_>, scratch: &mut Scratch<'_>, held: usize, direct: bool) -> usize {
    let links = &scratch.held_links[..held];
    let header = &mut cache.header[0];
    let arranged = (held as u32 + 1) | if direct { 0 } else { ALL_LOOSE };
    if header.arranged == arranged && cache.arranged_links[..held] == *links {
        return header.loose_joints as usize;
    }
    let mut tables = articulations::Tables {
        places: cache.joint_order,
        rows: cache.articulations,
        nodes: cache.nodes,
        blocks: cache.blocks,
        sets: scratch.joint_sets,
        sizes: scratch.joint_set_sizes,
        loops: scratch.joint_set_loops,
        keys: scratch.joint_keys,
        members: scratch.joint_members,
        found: scratch.joint_runs,
    };
    let arrangement = if direct {
        articulations::arrange(links, &mut tables)
    } else {
        articulations::leave_loose(held, &mut tables)
    };
    cache.arranged_links[..held].copy_from_slice(links);
    header.arranged = arranged;
    header.loose_joints = arrangement.loose as u32;
    header.articulations = arrangement.rows as u32;
    // Equal links may lie in other rows.
    header.laid_out = 0;
    arrangement.loose
}
