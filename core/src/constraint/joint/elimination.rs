//! In which order the unknowns of an articulation are eliminated, and which blocks that fills.
//!
//! The unknowns are the changes of its bodies' velocities and the impulses of its joints, so the matrix is
//!
//! ```text
//! [ M   Jt    ]   M: a block for each body    J: a block for each joint and each of its two bodies
//! [ J  -give  ]
//! ```
//!
//! A body that hangs by one joint goes first, then that joint, and so on: a tree fills nothing, and a body only
//! ever gets heavier on the way by what hangs on it (Featherstone's articulated inertia; the matrix is that of
//! Baraff, Linear-time dynamics using Lagrange multipliers, 1996). Sums of positive numbers lose no digits, so
//! that a ton on a chain of grams is held in single precision. Where joints make loops, the body or joint with
//! the fewest neighbours goes next (minimum degree).

use crate::joint::Signature;
use bytemuck::{Pod, Zeroable};

/// Most joints of an articulation.
pub(crate) const JOINTS_MAX: usize = 63;
/// Most bodies that so many joints join.
const BODIES_MAX: usize = JOINTS_MAX + 1;
/// Most unknown blocks.
const NODES_MAX: usize = BODIES_MAX + JOINTS_MAX;
/// Most blocks of the factor for each joint: a tree has two, a bridge three, a net many.
const BLOCKS_FOR_JOINT: usize = 5;
/// Stands for an immovable body, and for no source.
pub(crate) const NONE: u32 = u32::MAX;

/// A joint of an articulation: joints of two articulations that are solved side by side are equal.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Pod, Zeroable)]
pub(crate) struct Member {
    /// [`Signature`].
    pub signature: u32,
    /// Numbers of bodies A and B among those of the articulation, or [`NONE`].
    pub bodies: [u32; 2],
}

/// An unknown in its place in the order.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(crate) struct NodeSpec {
    /// Number of the joint, or [`NONE`] for a body.
    pub joint: u32,
    /// Of a body: number of a joint that has it, times 2, plus 1 for the end B.
    pub end: u32,
    /// Numbers that it has.
    pub size: u32,
    /// Its blocks, from the articulation's first.
    pub first_block: u32,
    pub blocks: u32,
}

impl NodeSpec {
    /// Its blocks, from the articulation's first.
    pub fn own_blocks(&self) -> core::ops::Range<usize> {
        self.first_block as usize..(self.first_block + self.blocks) as usize
    }
}

/// A block of the factor: the columns are those of the node that lists it.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(crate) struct BlockSpec {
    /// Place of the node whose rows it has.
    pub row: u32,
    /// Number of the joint whose J it starts with, times 2, plus 1 for the end B; or [`NONE`] where it starts
    /// with zeros.
    pub source: u32,
}

/// Nodes and blocks of an articulation.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pattern<'a> {
    pub nodes: &'a [NodeSpec],
    pub blocks: &'a [BlockSpec],
}

/// An order of elimination.
pub(crate) struct Elimination {
    order: [u8; NODES_MAX],
    nodes: usize,
    /// By node: the nodes that come later and share a block with it.
    columns: [u128; NODES_MAX],
    blocks: usize,
}

/// Bodies have the first numbers of the nodes, joints those from here on.
const FIRST_JOINT: usize = BODIES_MAX;

impl Elimination {
    /// Orders the unknowns of some joints; `None` when too much would fill.
    pub fn of(members: &[Member]) -> Option<Self> {
        let mut neighbours = [0_u128; NODES_MAX];
        let mut left = 0_u128;
        for (k, member) in members.iter().enumerate() {
            let joint = FIRST_JOINT + k;
            left |= 1 << joint;
            for body in member.bodies.iter().filter(|&&body| body != NONE) {
                let body = *body as usize;
                left |= 1 << body;
                neighbours[joint] |= 1 << body;
                neighbours[body] |= 1 << joint;
            }
        }
        let mut result = Self { order: [0; NODES_MAX], nodes: 0, columns: [0; NODES_MAX], blocks: 0 };
        // Joints that a whole body hangs on: what they leave to it has full rank.
        let mut carrying = 0_u128;
        while left != 0 {
            let node = next(&neighbours, left, carrying);
            left &= !(1 << node);
            let column = neighbours[node] & left;
            if node < FIRST_JOINT && column.count_ones() == 1 {
                carrying |= column;
            }
            for other in bits(column) {
                neighbours[other] |= column & !(1 << other);
            }
            result.order[result.nodes] = node as u8;
            result.columns[node] = column;
            result.nodes += 1;
            result.blocks += column.count_ones() as usize;
            if result.blocks > BLOCKS_FOR_JOINT * members.len() {
                return None;
            }
        }
        Some(result)
    }

    /// Numbers of nodes and blocks.
    pub fn size(&self) -> (usize, usize) {
        (self.nodes, self.blocks)
    }

    /// Writes nodes and blocks in the order of elimination.
    pub fn write(&self, members: &[Member], nodes: &mut [NodeSpec], blocks: &mut [BlockSpec]) {
        let mut places = [0_u8; FIRST_JOINT + JOINTS_MAX];
        for (place, &node) in self.order[..self.nodes].iter().enumerate() {
            places[node as usize] = place as u8;
        }
        let mut count = 0;
        for (spec, &node) in nodes.iter_mut().zip(&self.order[..self.nodes]) {
            let node = node as usize;
            let first = count;
            for other in bits(self.columns[node]) {
                let row = u32::from(places[other]);
                blocks[count] = BlockSpec { row, source: source(members, (node, other)) };
                count += 1;
            }
            blocks[first..count].sort_unstable_by_key(|block| block.row);
            let joint = node.checked_sub(FIRST_JOINT);
            *spec = NodeSpec {
                joint: joint.map_or(NONE, |joint| joint as u32),
                end: members.iter().flat_map(|m| m.bodies).position(|b| b as usize == node).unwrap_or(0)
                    as u32,
                size: joint
                    .map_or(6, |joint| Signature::of_kind(members[joint].signature).lock_rows() as u32),
                first_block: first as u32,
                blocks: (count - first) as u32,
            };
        }
    }
}

/// Most nodes and blocks of articulations with so many joints together.
pub(crate) const fn nodes_max(joints: usize) -> usize {
    // Two joints join three bodies.
    joints * 5 / 2 + 1
}

/// See [`nodes_max`].
pub(crate) const fn blocks_max(joints: usize) -> usize {
    BLOCKS_FOR_JOINT * joints
}

/// The node with the fewest neighbours, the first of equals. A joint waits until its bodies have gone, or one that
/// hung on it alone.
fn next(neighbours: &[u128; NODES_MAX], left: u128, carrying: u128) -> usize {
    let bodies = left & ((1 << FIRST_JOINT) - 1);
    let ready =
        |&node: &usize| node < FIRST_JOINT || carrying >> node & 1 != 0 || neighbours[node] & bodies == 0;
    let degree = |&node: &usize| (neighbours[node] & left).count_ones();
    bits(left).filter(ready).min_by_key(degree).unwrap_or(0)
}

/// The block of J at two nodes that have not been joined by elimination.
fn source(members: &[Member], (node, other): (usize, usize)) -> u32 {
    let (body, joint) = (node.min(other), node.max(other));
    if body >= FIRST_JOINT || joint < FIRST_JOINT {
        return NONE;
    }
    let joint = joint - FIRST_JOINT;
    let end = members[joint].bodies.iter().position(|&b| b as usize == body);
    end.map_or(NONE, |end| (2 * joint + end) as u32)
}

/// The set bits, ascending.
fn bits(mut mask: u128) -> impl Iterator<Item = usize> {
    core::iter::from_fn(move || {
        let bit = mask.trailing_zeros() as usize;
        mask &= mask.wrapping_sub(1);
        (bit < 128).then_some(bit)
    })
}

const _: () = assert!(FIRST_JOINT + JOINTS_MAX <= 128);
