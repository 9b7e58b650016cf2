//! From a schedule to seats and lanes.
//!
//! Each phase's blocks are dealt to *groups* of eight *chains*, one chain for each lane; a group is a task. Row
//! `k` of a group holds the `k`-th link of each of its chains. Blocks of a phase share no dynamic body, so the
//! lanes never meet; and a block's links keep their order, so neither the dealing nor the number of lanes changes
//! a bit.
//!
//! Joints come before contacts, and have rows of their own, in which all lanes have the same signature; a lane
//! whose chain has no such joint left is empty there.

use crate::cells::{Block, IMMOVABLE, Link, PHASES_MAX};
use crate::joint::Signature;
use crate::lanes::LANES;
use crate::pipeline::articulations::ArticulationRow;
use crate::pipeline::seat::OWN;
use crate::pipeline::tasks::TASKS_MAX;
use crate::world::Capacities;
use bytemuck::{Pod, Zeroable};

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
    /// Those of the ordering, then that of articulations if there are any.
    pub phases: [Phase; PHASES_MAX + 1],
    /// At least 1 when there is an active body.
    pub phase_count: usize,
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

/// The kind of a contact's link, to which 4 less its points is added, and 4 when a surface of it acts; those below
/// are signatures of joints.
const CONTACT_KIND: u32 = 1 << 27;

/// The kind of a contact with so many points: neighbours in a lane should have as many, more points first. Those
/// whose surfaces move or resist come last.
pub(crate) fn contact_kind(points: usize, acts: bool) -> u32 {
    CONTACT_KIND + 4 - points as u32 + 4 * u32::from(acts)
}

/// The points of a contact by its kind.
fn points_of(link: &Link) -> u32 {
    4 - (link.kind - CONTACT_KIND) % 4
}

/// Most groups of any schedule.
pub(crate) const fn groups_max(c: &Capacities) -> usize {
    let articulations = c.joints as usize / 2;
    let articulations = if articulations < LINK_GROUPS_MAX { articulations } else { LINK_GROUPS_MAX };
    PHASES_MAX + links_max(c) / GROUP_LINKS + c.bodies as usize / GROUP_BODIES + 2 + articulations
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
    pub articulations: &'a [ArticulationRow],
    pub blocks: &'a [Block],
    pub bodies: u32,
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
}

/// Lays out a schedule. Seats, rows and points come phase by phase, group by group.
pub(crate) fn lay_out(schedule: &Schedule<'_>, tables: &mut Tables<'_>) -> Plan {
    let mut plan = Plan {
        phases: [Phase::default(); PHASES_MAX + 1],
        phase_count: 0,
        groups: 0,
        seats: 0,
        rows: 0,
        points: 0,
        joints: 0,
        balls: 0,
        locks: 0,
        bounds: 0,
        nodes: 0,
        matrix_blocks: 0,
        blocks: schedule.blocks.len(),
    };
    tables.last_seats[..schedule.bodies as usize].fill(OWN);
    tables.phase_seats[..schedule.bodies as usize].fill(OWN);
    let mut blocks = schedule.blocks;
    while plan.phase_count == 0 || !blocks.is_empty() {
        let phase = plan.phase_count as u32;
        let count = blocks.iter().take_while(|block| block.phase == phase).count();
        assert!(count > 0 || phase == 0, "phases ascend without gaps");
        let (own, rest) = blocks.split_at(count);
        blocks = rest;
        lay_out_phase(schedule, own, tables, &mut plan);
    }
    if !schedule.articulations.is_empty() {
        lay_out_articulations(schedule, tables, &mut plan);
    }
    // What phase 0 pulls from: the last seat of each body, unless it is its only one.
    let first = plan.phases[0].seats as usize;
    for seat in 0..first {
        let body = tables.seat_bodies[seat];
        if body != IMMOVABLE {
            let last = tables.last_seats[body as usize];
            tables.seat_sources[seat] = if last as usize == seat { OWN } else { last };
        }
    }
    plan
}

fn lay_out_phase(schedule: &Schedule<'_>, blocks: &[Block], tables: &mut Tables<'_>, plan: &mut Plan) {
    let first_seat = plan.seats;
    let first_group = plan.groups;
    let links: usize = blocks.iter().map(|block| block.count as usize).sum();
    // A group takes eight chains, and a chain a block at least: few long blocks make no more groups.
    let group_count = links.div_ceil(GROUP_LINKS).min(blocks.len().div_ceil(LANES)).min(LINK_GROUPS_MAX);
    let mut loads = deal(blocks, group_count, tables.block_chains);
    let joints = list_joints(schedule, blocks, tables, &mut loads);
    for g in 0..group_count {
        let rows = loads[g * LANES..(g + 1) * LANES].iter().copied().max().unwrap_or(0);
        tables.groups[plan.groups] =
            Group { phase: plan.phase_count as u32, first_row: plan.rows as u32, rows, ..Group::zeroed() };
        tables.lane_contacts[plan.rows..plan.rows + rows as usize].fill([EMPTY; LANES]);
        plan.groups += 1;
        plan.rows += rows as usize;
    }
    place(schedule, blocks, tables, first_group);
    place_joints(schedule, tables, (plan, first_group), joints);
    for g in first_group..plan.groups {
        seat_group(schedule, tables, (plan, g), first_seat as u32);
    }
    if plan.phase_count == 0 {
        seat_free_bodies(schedule.bodies, tables, plan);
        let bodies = schedule.bodies as usize;
        tables.first_seats[..bodies].copy_from_slice(&tables.phase_seats[..bodies]);
    }
    end_phase(plan, first_group, first_seat);
}

/// Notes the groups and seats of a phase that is laid out.
fn end_phase(plan: &mut Plan, first_group: usize, first_seat: usize) {
    plan.phases[plan.phase_count] = Phase {
        first_group: first_group as u32,
        groups: (plan.groups - first_group) as u32,
        first_seat: first_seat as u32,
        seats: (plan.seats - first_seat) as u32,
    };
    plan.phase_count += 1;
}

/// Lays out the articulations in a phase of their own, after the others: joints follow one another row by row.
fn lay_out_articulations(schedule: &Schedule<'_>, tables: &mut Tables<'_>, plan: &mut Plan) {
    let (first_seat, first_group) = (plan.seats, plan.groups);
    let share = schedule.articulations.len().div_ceil(LINK_GROUPS_MAX);
    for (i, rows) in schedule.articulations.chunks(share).enumerate() {
        let mut group = Group {
            phase: plan.phase_count as u32,
            first_row: plan.rows as u32,
            first_joint: plan.joints as u32,
            first_ball: plan.balls as u32,
            first_lock: plan.locks as u32,
            first_bound: plan.bounds as u32,
            first_articulation: (i * share) as u32,
            articulations: rows.len() as u32,
            first_node: plan.nodes as u32,
            first_block: plan.matrix_blocks as u32,
            ..Group::zeroed()
        };
        for row in rows {
            place_articulations(schedule, tables, plan, row);
        }
        group.joints = plan.joints as u32 - group.first_joint;
        group.locks = plan.locks as u32 - group.first_lock;
        group.bounds = plan.bounds as u32 - group.first_bound;
        group.nodes = plan.nodes as u32 - group.first_node;
        group.blocks = plan.matrix_blocks as u32 - group.first_block;
        tables.groups[plan.groups] = group;
        plan.groups += 1;
        seat_group(schedule, tables, (plan, first_group + i), first_seat as u32);
    }
    end_phase(plan, first_group, first_seat);
}

/// Writes the joints of a row of articulations to their rows and lanes.
fn place_articulations(
    schedule: &Schedule<'_>,
    tables: &mut Tables<'_>,
    plan: &mut Plan,
    articulations: &ArticulationRow,
) {
    for k in 0..articulations.joints {
        let lanes = articulations.first.map(|first| if first == EMPTY { EMPTY } else { first + k });
        for (lane, &joint) in lanes.iter().enumerate().filter(|&(_, &joint)| joint != EMPTY) {
            tables.joint_places[joint as usize] = (plan.joints * LANES + lane) as u32;
        }
        let signature = Signature(schedule.links[(schedule.contacts + lanes[0]) as usize].kind);
        tables.lane_joints[plan.joints] = lanes;
        plan.joints += 1;
        plan.locks += signature.lock_rows();
        plan.bounds += signature.bound_rows();
    }
    plan.nodes += articulations.nodes as usize;
    plan.matrix_blocks += articulations.blocks as usize;
    plan.blocks += articulations.first.iter().filter(|&&first| first != EMPTY).count();
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

/// Number of joints of a block: they come first in it.
fn joints_of(schedule: &Schedule<'_>, block: &Block) -> u32 {
    let links = &schedule.order[block.first as usize..(block.first + block.count) as usize];
    links.iter().take_while(|&&link| link >= schedule.contacts).count() as u32
}

/// Bits of a key of a joint, from the highest: group 7, signature 27, lane 3, place in the order 27.
const LANE_SHIFT: u32 = 27;
const SIGNATURE_SHIFT: u32 = 30;
const GROUP_SHIFT: u32 = 57;

/// Writes a key for each joint of a phase, and takes them off the loads of their chains. Returns how many they are.
fn list_joints(
    schedule: &Schedule<'_>,
    blocks: &[Block],
    tables: &mut Tables<'_>,
    loads: &mut [u32; LINK_GROUPS_MAX * LANES],
) -> usize {
    let mut count = 0;
    if schedule.order.len() as u32 == schedule.contacts {
        return count;
    }
    for (block, &chain) in blocks.iter().zip(&*tables.block_chains) {
        let joints = joints_of(schedule, block);
        loads[chain as usize] -= joints;
        let (group, lane) = (u64::from(chain) / LANES as u64, u64::from(chain) % LANES as u64);
        for place in block.first..block.first + joints {
            let signature = u64::from(schedule.links[schedule.order[place as usize] as usize].kind);
            tables.joint_keys[count] =
                group << GROUP_SHIFT | signature << SIGNATURE_SHIFT | lane << LANE_SHIFT | u64::from(place);
            count += 1;
        }
    }
    tables.joint_keys[..count].sort_unstable();
    count
}

/// Writes each joint to its row and lane: rows of one signature after those of another.
fn place_joints(
    schedule: &Schedule<'_>,
    tables: &mut Tables<'_>,
    (plan, first_group): (&mut Plan, usize),
    joints: usize,
) {
    let mut lengths = [0_u32; LANES];
    let mut before = u64::MAX;
    let mut base = plan.joints as u32;
    for i in 0..joints {
        let key = tables.joint_keys[i];
        let group = &mut tables.groups[first_group + (key >> GROUP_SHIFT) as usize];
        if key >> SIGNATURE_SHIFT != before {
            before = key >> SIGNATURE_SHIFT;
            (base, lengths) = (plan.joints as u32, [0; LANES]);
        }
        if group.joints == 0 {
            group.first_joint = plan.joints as u32;
            group.first_ball = plan.balls as u32;
            (group.first_lock, group.first_bound) = (plan.locks as u32, plan.bounds as u32);
        }
        let lane = (key >> LANE_SHIFT) as usize % LANES;
        let row = base + lengths[lane];
        lengths[lane] += 1;
        if row as usize == plan.joints {
            let link = &schedule.links[schedule.order[order_of(key)] as usize];
            let signature = Signature(link.kind);
            tables.lane_joints[plan.joints] = [EMPTY; LANES];
            let is_ball = signature == Signature::PLAIN;
            plan.joints += 1;
            plan.balls += usize::from(is_ball);
            plan.locks += signature.lock_rows();
            plan.bounds += signature.bound_rows();
            group.joints += 1;
            group.balls += u32::from(is_ball);
            group.locks += signature.lock_rows() as u32;
            group.bounds += signature.bound_rows() as u32;
        }
        let joint = schedule.order[order_of(key)] - schedule.contacts;
        tables.lane_joints[row as usize][lane] = joint;
        tables.joint_places[joint as usize] = row * LANES as u32 + lane as u32;
    }
}

/// The place in the order that a key of a joint names.
fn order_of(key: u64) -> usize {
    (key & ((1 << LANE_SHIFT) - 1)) as usize
}

/// Writes each contact to its row and lane. Links and contacts have the same indices.
fn place(schedule: &Schedule<'_>, blocks: &[Block], tables: &mut Tables<'_>, first_group: usize) {
    let mut lengths = [0_u32; LINK_GROUPS_MAX * LANES];
    for (i, block) in blocks.iter().enumerate() {
        let chain = tables.block_chains[i] as usize;
        let (group, lane) = (chain / LANES, chain % LANES);
        let first_row = tables.groups[first_group + group].first_row;
        for k in block.first..block.first + block.count {
            let link = schedule.order[k as usize];
            if link >= schedule.contacts {
                continue;
            }
            let row = first_row + lengths[chain];
            lengths[chain] += 1;
            tables.lane_contacts[row as usize][lane] = link;
            tables.contact_places[link as usize] = row * LANES as u32 + lane as u32;
        }
    }
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

/// Seats the bodies that no link of phase 0 has.
fn seat_free_bodies(bodies: u32, tables: &mut Tables<'_>, plan: &mut Plan) {
    let free = tables.phase_seats[..bodies as usize].iter().filter(|&&seat| seat == OWN).count();
    if free == 0 {
        return;
    }
    let share = GROUP_BODIES.max(free.div_ceil(FREE_GROUPS_MAX));
    let (mut open, mut left) = (0, free);
    for body in 0..bodies {
        if tables.phase_seats[body as usize] != OWN {
            continue;
        }
        if open == 0 {
            tables.groups[plan.groups] = Group {
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
