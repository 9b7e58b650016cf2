//! From a schedule to seats and lanes.
//!
//! Each phase's blocks are dealt to *groups* of eight *chains*, one chain for each lane; a group is a task. Row
//! `k` of a group holds the `k`-th link of each of its chains. Blocks of a phase share no dynamic body, so the
//! lanes never meet; and a block's links keep their order, so neither the dealing nor the number of lanes changes
//! a bit. Few links are spread over the lanes in another way (`layout/contacts.rs`), to the same bits.
//!
//! Joints come before contacts, and have rows of their own, in which all lanes have the same signature; a lane
//! whose chain has no such joint left is empty there.
//!
//! Bodies that are refined, and their links, make a *tier* of their own, with phases of its own: it is solved after
//! the others, in more substeps. The first phases of both tiers come first, so that all movers lie in a row.

mod contacts;
mod joints;

use crate::cells::{Block, IMMOVABLE, Link, PHASES_MAX};
use crate::lanes::LANES;
use crate::pipeline::articulations::ArticulationRow;
use crate::pipeline::seat::OWN;
use crate::pipeline::tasks::TASKS_MAX;
use crate::pool::is_used;
use crate::world::Capacities;
use bytemuck::{Pod, Zeroable};
use joints::{lay_out_articulations, list_joints, place_joints};

/// Links for which a phase gets another group.
const GROUP_LINKS: usize = 512;
/// Most groups of a phase that have links; the rest of the tasks is for bodies without links.
const LINK_GROUPS_MAX: usize = 96;
/// Bodies without links for which phase 0 gets another group.
const GROUP_BODIES: usize = 512;
/// Most such groups.
const FREE_GROUPS_MAX: usize = TASKS_MAX - LINK_GROUPS_MAX;
/// Marks an empty lane.
pub(crate) const EMPTY: u32 = u32::MAX;

/// A task of the solve: runs of the seats, rows and points.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(crate) struct Group {
    /// 0 for the first phase of its tier, in which its bodies move.
    pub phase: u32,
    pub first_seat: u32,
    pub seats: u32,
    pub first_row: u32,
    pub rows: u32,
    pub first_point: u32,
    pub points: u32,
    /// 1 when some link of the group may bounce.
    pub bounces: u32,
    /// Rows of joints, of which those of plain balls come first.
    pub first_joint: u32,
    pub joints: u32,
    pub first_ball: u32,
    pub balls: u32,
    pub first_lock: u32,
    pub locks: u32,
    pub first_bound: u32,
    pub bounds: u32,
    /// Rows of articulations, whose joints are all of the group's, and those of their matrices.
    pub first_articulation: u32,
    pub articulations: u32,
    pub first_node: u32,
    pub nodes: u32,
    pub first_block: u32,
    pub blocks: u32,
    /// Index of the tier.
    pub tier: u32,
    /// Not 0 when some joint of the group leaps: see `pipeline/leapfrog.rs`.
    pub leaps: u32,
}

/// The tier of bodies that are refined; those that are not have tier 0.
pub(crate) const REFINED: usize = 1;
/// Tiers: bodies that share their substeps.
pub(crate) const TIERS: usize = 2;

/// The phases of a tier.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(crate) struct Tier {
    /// Those of the ordering that have links of the tier, then that of articulations if there are any.
    pub phases: [Phase; PHASES_MAX + 1],
    /// At least 1 when the tier has a body.
    pub phase_count: usize,
    /// Links of the tier.
    pub links: usize,
}

impl Tier {
    /// The phases in their order.
    pub fn phases(&self) -> &[Phase] {
        &self.phases[..self.phase_count]
    }
}

/// Groups of one phase.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub(crate) struct Phase {
    pub first_group: u32,
    pub groups: u32,
    pub first_seat: u32,
    pub seats: u32,
}

/// What the layout came to.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(crate) struct Plan {
    pub tiers: [Tier; TIERS],
    /// Seats of the first phases of all tiers: those of the bodies that move.
    pub moving: usize,
    pub groups: usize,
    pub seats: usize,
    pub rows: usize,
    pub points: usize,
    /// Rows of joints, those of them that are of plain balls, and the others' rows that hold and that have bounds.
    pub joints: usize,
    pub balls: usize,
    pub locks: usize,
    pub bounds: usize,
    /// Nodes and blocks of matrices.
    pub nodes: usize,
    pub matrix_blocks: usize,
    /// Blocks of the ordering, and articulations.
    pub blocks: usize,
}

impl Plan {
    /// Phases of the tier that has the most.
    pub fn phases(&self) -> u32 {
        self.tiers.iter().map(|tier| tier.phase_count as u32).max().unwrap_or(0)
    }
}

/// The kind of a contact's link, to which 4 less its points is added, and 4 when a surface of it acts; those below
/// are signatures of joints.
const CONTACT_KIND: u32 = 1 << 27;

/// The kind of a contact with so many points: neighbours in a lane should have as many, more points first. Those
/// whose surfaces move or resist come last.
pub(crate) fn contact_kind(points: usize, acts: bool) -> u32 {
    CONTACT_KIND + 4 - points as u32 + 4 * u32::from(acts)
}

/// Added to the kind of a joint that is refined: articulations of two tiers are not alike.
pub(crate) const REFINED_KIND: u32 = 1 << 28;

/// The points of a contact by its kind.
fn points_of(link: &Link) -> u32 {
    4 - (link.kind - CONTACT_KIND) % 4
}

/// Most groups of any schedule.
pub(crate) const fn groups_max(c: &Capacities) -> usize {
    let articulations = c.joints as usize / 2;
    let articulations = if articulations < LINK_GROUPS_MAX { articulations } else { LINK_GROUPS_MAX };
    TIERS * (PHASES_MAX + 2 + articulations) + links_max(c) / GROUP_LINKS + c.bodies as usize / GROUP_BODIES
}

/// Most links of a step: contacts, then joints.
pub(crate) const fn links_max(c: &Capacities) -> usize {
    c.contacts as usize + c.joints as usize
}

/// Most seats of any schedule: each body once in phase 0, two for each link of a later phase, the lanes' own, and
/// those that fill groups of phase 0; and one that is written and not used.
pub(crate) const fn seats_max(c: &Capacities) -> usize {
    c.bodies as usize + 2 * links_max(c) + 2 * LANES * groups_max(c) + 1
}

/// Most rows of movers: each is of eight seats of phase 0.
pub(crate) const fn mover_rows_max(c: &Capacities) -> usize {
    (c.bodies as usize).div_ceil(LANES) + 2 * groups_max(c)
}

/// The schedule to lay out.
#[derive(Clone, Copy)]
pub(crate) struct Schedule<'a> {
    /// Contacts, then joints by place.
    pub links: &'a [Link],
    /// How many of the links are contacts.
    pub contacts: u32,
    /// Contacts and loose joints.
    pub order: &'a [u32],
    /// By tier.
    pub articulations: [&'a [ArticulationRow]; TIERS],
    /// By tier, and by phase.
    pub blocks: [&'a [Block]; TIERS],
    pub bodies: u32,
    /// A bit for each body that is refined, by active body; empty when none is.
    pub refined: &'a [u64],
}

impl Schedule<'_> {
    /// The tier of an active body.
    fn tier(&self, body: u32) -> usize {
        usize::from(!self.refined.is_empty() && is_used(self.refined, body))
    }
}

/// Where the layout is written.
pub(crate) struct Tables<'a> {
    pub groups: &'a mut [Group],
    pub lane_contacts: &'a mut [[u32; LANES]],
    /// Seats of bodies A and then B of each lane, from the group's first.
    pub lane_seats: &'a mut [[u32; 2 * LANES]],
    pub contact_places: &'a mut [u32],
    /// The same for joints, by their place among the links that are joints.
    pub lane_joints: &'a mut [[u32; LANES]],
    pub joint_seats: &'a mut [[u32; 2 * LANES]],
    pub joint_places: &'a mut [u32],
    /// For sorting.
    pub joint_keys: &'a mut [u64],
    pub seat_sources: &'a mut [u32],
    pub seat_bodies: &'a mut [u32],
    pub last_seats: &'a mut [u32],
    pub phase_seats: &'a mut [u32],
    pub first_seats: &'a mut [u32],
    /// Chain of each block.
    pub block_chains: &'a mut [u32],
    /// Row after the last one that has a body.
    pub body_rows: &'a mut [u32],
}

/// Lays out a schedule. Seats, rows and points come phase by phase, group by group.
pub(crate) fn lay_out(schedule: &Schedule<'_>, tables: &mut Tables<'_>) -> Plan {
    let mut plan = Plan { blocks: schedule.blocks.iter().map(|blocks| blocks.len()).sum(), ..Plan::zeroed() };
    let bodies = schedule.bodies as usize;
    tables.last_seats[..bodies].fill(OWN);
    tables.phase_seats[..bodies].fill(OWN);
    let mut left = schedule.blocks;
    let tiers = if schedule.refined.is_empty() { 1 } else { TIERS };
    for (tier, blocks) in left[..tiers].iter_mut().enumerate() {
        lay_out_phase(schedule, cut_phase(blocks), tables, (&mut plan, tier));
    }
    plan.moving = plan.seats;
    tables.first_seats[..bodies].copy_from_slice(&tables.phase_seats[..bodies]);
    for (tier, blocks) in left[..tiers].iter_mut().enumerate() {
        while !blocks.is_empty() {
            lay_out_phase(schedule, cut_phase(blocks), tables, (&mut plan, tier));
        }
        if !schedule.articulations[tier].is_empty() {
            lay_out_articulations(schedule, tables, (&mut plan, tier));
        }
    }
    // What the first phase pulls from: the last seat of each body, unless it is its only one.
    for seat in 0..plan.moving {
        let body = tables.seat_bodies[seat];
        if body != IMMOVABLE {
            let last = tables.last_seats[body as usize];
            tables.seat_sources[seat] = if last as usize == seat { OWN } else { last };
        }
    }
    plan
}

/// Cuts the blocks of the first phase off; none of none.
fn cut_phase<'a>(blocks: &mut &'a [Block]) -> &'a [Block] {
    let phase = blocks.first().map_or(0, |block| block.phase);
    let (own, rest) = blocks.split_at(blocks.iter().take_while(|block| block.phase == phase).count());
    *blocks = rest;
    own
}

fn lay_out_phase(
    schedule: &Schedule<'_>,
    blocks: &[Block],
    tables: &mut Tables<'_>,
    (plan, tier): (&mut Plan, usize),
) {
    let first_seat = plan.seats;
    let first_group = plan.groups;
    let phase = plan.tiers[tier].phase_count as u32;
    let links: usize = blocks.iter().map(|block| block.count as usize).sum();
    // A group takes eight chains, and a chain a block at least: few long blocks make no more groups.
    let group_count = links.div_ceil(GROUP_LINKS).min(blocks.len().div_ceil(LANES)).min(LINK_GROUPS_MAX);
    let mut loads = deal(blocks, group_count, tables.block_chains);
    let joints = list_joints(schedule, blocks, tables, &mut loads);
    let by_levels = contacts::are_sparse(&loads, group_count);
    for g in 0..group_count {
        let rows = loads[g * LANES..(g + 1) * LANES].iter().copied().max().unwrap_or(0);
        tables.groups[plan.groups] =
            Group { phase, tier: tier as u32, first_row: plan.rows as u32, rows, ..Group::zeroed() };
        tables.lane_contacts[plan.rows..plan.rows + rows as usize].fill([EMPTY; LANES]);
        plan.groups += 1;
        plan.rows += rows as usize;
    }
    if by_levels {
        let group = tables.groups[first_group];
        let rows = contacts::place_by_levels(schedule, blocks, tables, group.first_row);
        tables.groups[first_group].rows = rows;
        plan.rows = (group.first_row + rows) as usize;
    } else {
        contacts::place(schedule, blocks, tables, first_group);
    }
    place_joints(schedule, tables, (plan, first_group), joints);
    for g in first_group..plan.groups {
        seat_group(schedule, tables, (plan, g), first_seat as u32);
    }
    if phase == 0 {
        seat_free_bodies(schedule, tables, (plan, tier));
    }
    plan.tiers[tier].links += links;
    end_phase((plan, tier), first_group, first_seat);
}

/// Notes the groups and seats of a phase that is laid out.
fn end_phase((plan, tier): (&mut Plan, usize), first_group: usize, first_seat: usize) {
    let own = &mut plan.tiers[tier];
    own.phases[own.phase_count] = Phase {
        first_group: first_group as u32,
        groups: (plan.groups - first_group) as u32,
        first_seat: first_seat as u32,
        seats: (plan.seats - first_seat) as u32,
    };
    own.phase_count += 1;
}

/// Deals blocks to chains, each to the chain with the least links, the first of equals; long blocks come first.
/// Returns the loads.
fn deal(blocks: &[Block], groups: usize, chains: &mut [u32]) -> [u32; LINK_GROUPS_MAX * LANES] {
    let mut loads = [0_u32; LINK_GROUPS_MAX * LANES];
    // A heap of (load, chain): the least is in front.
    let mut heap = [(0_u32, 0_u32); LINK_GROUPS_MAX * LANES];
    let heap = &mut heap[..groups * LANES];
    heap.iter_mut().zip(0..).for_each(|(entry, chain)| entry.1 = chain);
    for (block, chain) in blocks.iter().zip(chains) {
        let (load, best) = heap[0];
        *chain = best;
        loads[best as usize] = load + block.count;
        sink(heap, (load + block.count, best));
    }
    loads
}

/// Puts an entry in the place of the heap's front.
fn sink(heap: &mut [(u32, u32)], entry: (u32, u32)) {
    let mut at = 0;
    loop {
        let left = 2 * at + 1;
        let Some(&first) = heap.get(left) else { break };
        let (next, least) = match heap.get(left + 1) {
            Some(&second) if second < first => (left + 1, second),
            _ => (left, first),
        };
        if entry <= least {
            break;
        }
        heap[at] = least;
        at = next;
    }
    heap[at] = entry;
}

/// Gives the lanes of a group their scratch seats, and every body of the group a seat, in the order of the rows.
fn seat_group(
    schedule: &Schedule<'_>,
    tables: &mut Tables<'_>,
    (plan, g): (&mut Plan, usize),
    phase_first_seat: u32,
) {
    let first_seat = plan.seats as u32;
    (0..LANES).for_each(|_| seat_nobody(tables, plan));
    let group = tables.groups[g];
    for row in group.first_joint as usize..(group.first_joint + group.joints) as usize {
        let links = tables.lane_joints[row]
            .map(|joint| if joint == EMPTY { EMPTY } else { joint + schedule.contacts });
        tables.joint_seats[row] = seat_row(schedule, tables, plan, (&links, phase_first_seat, first_seat));
    }
    let mut points = 0;
    for row in group.first_row as usize..(group.first_row + group.rows) as usize {
        let links = tables.lane_contacts[row];
        let live = links.iter().filter(|&&link| link != EMPTY);
        points += live.map(|&link| points_of(&schedule.links[link as usize])).max().unwrap_or(0);
        tables.lane_seats[row] = seat_row(schedule, tables, plan, (&links, phase_first_seat, first_seat));
    }
    if group.phase == 0 {
        fill_up(tables, plan);
    }
    let group = &mut tables.groups[g];
    group.first_seat = first_seat;
    group.seats = plan.seats as u32 - first_seat;
    group.first_point = plan.points as u32;
    group.points = points;
    plan.points += points as usize;
}

/// The seats of a row's bodies, A's and then B's, from the group's first; immovable ones share the lane's own.
fn seat_row(
    schedule: &Schedule<'_>,
    tables: &mut Tables<'_>,
    plan: &mut Plan,
    (links, phase_first_seat, first_seat): (&[u32; LANES], u32, u32),
) -> [u32; 2 * LANES] {
    let mut seats: [u32; 2 * LANES] = core::array::from_fn(|i| (i % LANES) as u32);
    for (lane, &link) in links.iter().enumerate() {
        if link == EMPTY {
            continue;
        }
        let link = schedule.links[link as usize];
        for (end, body) in [link.a, link.b].into_iter().enumerate() {
            if body != IMMOVABLE {
                seats[end * LANES + lane] = take_seat(body, tables, plan, phase_first_seat) - first_seat;
            }
        }
    }
    seats
}

/// A seat without a body.
fn seat_nobody(tables: &mut Tables<'_>, plan: &mut Plan) {
    tables.seat_bodies[plan.seats] = IMMOVABLE;
    tables.seat_sources[plan.seats] = OWN;
    plan.seats += 1;
}

/// Fills the last eight seats of a group of phase 0: bodies are integrated by eights.
fn fill_up(tables: &mut Tables<'_>, plan: &mut Plan) {
    while !plan.seats.is_multiple_of(LANES) {
        seat_nobody(tables, plan);
    }
}

/// The body's seat in this phase, a new one if it has none yet.
fn take_seat(body: u32, tables: &mut Tables<'_>, plan: &mut Plan, phase_first_seat: u32) -> u32 {
    let body_index = body as usize;
    let seat = tables.phase_seats[body_index];
    // Seats ascend, so a seat from before this phase's first is an earlier phase's. The next seat is written in
    // any case: half the bodies need one, in no order, and a wrong guess costs more.
    let is_new = seat == OWN || seat < phase_first_seat;
    let seat = if is_new { plan.seats as u32 } else { seat };
    tables.phase_seats[body_index] = seat;
    tables.seat_bodies[plan.seats] = body;
    tables.seat_sources[plan.seats] = tables.last_seats[body_index];
    tables.last_seats[body_index] = seat;
    plan.seats += usize::from(is_new);
    seat
}

/// Seats the bodies of a tier that no link of its first phase has.
fn seat_free_bodies(schedule: &Schedule<'_>, tables: &mut Tables<'_>, (plan, tier): (&mut Plan, usize)) {
    let is_free = |tables: &Tables<'_>, body: u32| {
        tables.phase_seats[body as usize] == OWN && schedule.tier(body) == tier
    };
    let free = (0..schedule.bodies).filter(|&body| is_free(tables, body)).count();
    if free == 0 {
        return;
    }
    let share = GROUP_BODIES.max(free.div_ceil(FREE_GROUPS_MAX));
    let (mut open, mut left) = (0, free);
    for body in 0..schedule.bodies {
        if !is_free(tables, body) {
            continue;
        }
        if open == 0 {
            tables.groups[plan.groups] = Group {
                tier: tier as u32,
                first_seat: plan.seats as u32,
                first_row: plan.rows as u32,
                first_point: plan.points as u32,
                ..Group::zeroed()
            };
            plan.groups += 1;
            open = share;
        }
        take_seat(body, tables, plan, 0);
        open -= 1;
        left -= 1;
        if open == 0 || left == 0 {
            fill_up(tables, plan);
            let group = &mut tables.groups[plan.groups - 1];
            group.seats = plan.seats as u32 - group.first_seat;
        }
    }
}
