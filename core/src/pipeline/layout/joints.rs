//! Joints: rows whose lanes have one signature, and articulations, which have a phase of their own.

use super::{EMPTY, Group, LINK_GROUPS_MAX, Plan, Schedule, Tables, end_phase, seat_group};
use crate::cells::Block;
use crate::joint::Signature;
use crate::lanes::LANES;
use crate::pipeline::articulations::ArticulationRow;
use bytemuck::Zeroable;

/// Lays out the articulations in a phase of their own, after the others: joints follow one another row by row.
pub(super) fn lay_out_articulations(
    schedule: &Schedule<'_>,
    tables: &mut Tables<'_>,
    (plan, tier): (&mut Plan, usize),
) {
    let (first_seat, first_group) = (plan.seats, plan.groups);
    let articulations = schedule.articulations[tier];
    let before = if tier == 0 { 0 } else { schedule.articulations[0].len() };
    let share = articulations.len().div_ceil(LINK_GROUPS_MAX);
    for (i, rows) in articulations.chunks(share).enumerate() {
        let mut group = Group {
            phase: plan.tiers[tier].phase_count as u32,
            tier: tier as u32,
            first_row: plan.rows as u32,
            first_joint: plan.joints as u32,
            first_ball: plan.balls as u32,
            first_lock: plan.locks as u32,
            first_bound: plan.bounds as u32,
            first_articulation: (before + i * share) as u32,
            articulations: rows.len() as u32,
            first_node: plan.nodes as u32,
            first_block: plan.matrix_blocks as u32,
            ..Group::zeroed()
        };
        for row in rows {
            plan.tiers[tier].links += place_articulations(schedule, tables, plan, row);
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
    end_phase((plan, tier), first_group, first_seat);
}

/// Writes the joints of a row of articulations to their rows and lanes. Returns how many they are.
fn place_articulations(
    schedule: &Schedule<'_>,
    tables: &mut Tables<'_>,
    plan: &mut Plan,
    articulations: &ArticulationRow,
) -> usize {
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
    let lanes = articulations.first.iter().filter(|&&first| first != EMPTY).count();
    plan.blocks += lanes;
    lanes * articulations.joints as usize
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
pub(super) fn list_joints(
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
pub(super) fn place_joints(
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
