//! The matrix of eight alike articulations, factored into `L D Lt` block by block, and solved. See
//! `constraint/joint/elimination.rs` for the matrix and the order.
//!
//! Velocities are scaled by the square roots of the bodies' masses and inertias, so M starts as the identity and
//! an axis along which a body does not move is one that J does not touch.

use super::super::velocities::root_times;
use super::elimination::{NONE, NodeSpec, Pattern};
use super::{JointLink, LockRow};
use crate::lanes::{Lane, LaneVec};
use bytemuck::{Pod, Zeroable};

/// A pivot below this share of what it lost its digits to is taken for rounding: eight units in the last place.
/// Pivots that say what others say already come to 1e-9 of it, others to 1e-5 and more.
const PIVOT_SHARE: f32 = 1.0e-7;

/// Share of what bodies give to a row that is added to its pivot.
const DAMPING: f32 = 1.0e-5;

/// Numbers of a node at most.
const SIZE: usize = 6;

/// A node of each of eight articulations.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
pub(crate) struct NodeRow {
    /// Lower triangle by rows: L below the diagonal, the inverse of D on it.
    diagonal: [Lane; SIZE * (SIZE + 1) / 2],
    /// Right side of the system; then the answer. While it is factored: the sizes of what has met in the diagonal,
    /// each times the share of its own digits that it lost before; a pivot is told from rounding by it.
    pub side: [Lane; SIZE],
    /// While it is factored: what bodies have added to the diagonal. A share of it damps the pivot.
    added: [Lane; SIZE],
}

/// A block of L of each of eight articulations, by rows of six.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
pub(crate) struct BlockRow {
    values: [Lane; SIZE * SIZE],
}

/// The matrix of eight alike articulations.
pub(crate) struct Matrix<'a> {
    pub pattern: Pattern<'a>,
    pub nodes: &'a mut [NodeRow],
    pub blocks: &'a mut [BlockRow],
}

/// Place in a lower triangle.
#[inline(always)]
const fn at(row: usize, column: usize) -> usize {
    row * (row + 1) / 2 + column
}

/// Calls a method that is compiled for each size of a node, so that its inner loops have no ends to test.
macro_rules! sized {
    ($size:expr, $matrix:ident.$method:ident($($argument:expr),*)) => {
        match $size {
            1 => $matrix.$method::<1>($($argument),*),
            2 => $matrix.$method::<2>($($argument),*),
            3 => $matrix.$method::<3>($($argument),*),
            4 => $matrix.$method::<4>($($argument),*),
            5 => $matrix.$method::<5>($($argument),*),
            _ => $matrix.$method::<6>($($argument),*),
        }
    };
}

impl Matrix<'_> {
    /// Factors the matrix of joints whose rows are placed.
    pub fn factor(&mut self, links: &[JointLink], locks: &[LockRow]) {
        self.fill(links, locks);
        for (i, spec) in self.pattern.nodes.iter().enumerate() {
            sized!(spec.size, self.take_out(i, spec));
        }
    }

    /// Factors the column of a node of size `N`, and takes it from what comes later.
    fn take_out<const N: usize>(&mut self, i: usize, spec: &NodeSpec) {
        self.nodes[i].factor::<N>(spec.joint != NONE);
        let node = self.nodes[i];
        let own = spec.own_blocks();
        for block in &mut self.blocks[own.clone()] {
            block.divide::<N>(&node);
        }
        for p in own.clone() {
            self.update::<N>((p, own.end), &node, spec);
        }
        for block in &mut self.blocks[own] {
            block.scale::<N>(&node);
        }
    }

    /// Writes the matrix.
    fn fill(&mut self, links: &[JointLink], locks: &[LockRow]) {
        let mut firsts = [0_usize; super::elimination::JOINTS_MAX + 1];
        for (k, link) in links.iter().enumerate() {
            firsts[k + 1] = firsts[k] + link.signature().lock_rows();
        }
        let rows = |joint: usize| &locks[firsts[joint]..firsts[joint + 1]];
        let one = Lane::splat(1.0);
        for (node, spec) in self.nodes.iter_mut().zip(self.pattern.nodes) {
            *node = NodeRow::zeroed();
            if spec.joint == NONE {
                (0..SIZE).for_each(|r| node.diagonal[at(r, r)] = one);
                continue;
            }
            for (r, row) in rows(spec.joint as usize).iter().enumerate() {
                node.diagonal[at(r, r)] = -row.give;
                (node.side[r], node.added[r]) = (row.give, row.give);
            }
        }
        for spec in self.pattern.nodes {
            let is_body = spec.joint == NONE;
            let own = spec.own_blocks();
            for (block, spec) in self.blocks[own.clone()].iter_mut().zip(&self.pattern.blocks[own]) {
                *block = BlockRow::zeroed();
                if spec.source == NONE {
                    continue;
                }
                let (joint, end) = (spec.source as usize / 2, spec.source as usize % 2);
                for (r, row) in rows(joint).iter().enumerate() {
                    for (c, x) in scaled(&links[joint], row, end).into_iter().enumerate() {
                        block.values[if is_body { r * SIZE + c } else { c * SIZE + r }] = x;
                    }
                }
            }
        }
    }

    /// Takes from what comes later its share of a column: the block `p` with each one from there to `end`.
    fn update<const N: usize>(&mut self, (p, end): (usize, usize), node: &NodeRow, spec: &NodeSpec) {
        let (specs, nodes) = (self.pattern.blocks, self.pattern.nodes);
        let is_body = spec.joint == NONE;
        let place = specs[p].row as usize;
        let rows = nodes[place].size as usize;
        let divided = self.blocks[p];
        let mut scaled = divided;
        scaled.scale::<N>(node);
        let to = &mut self.nodes[place];
        for r in 0..rows {
            for c in 0..=r {
                let change = divided.row_times::<N>(r, &scaled, c);
                to.diagonal[at(r, c)] = to.diagonal[at(r, c)] - change;
                if is_body && r == c {
                    to.added[r] = to.added[r] + change;
                    to.side[r] = to.side[r] + change;
                }
            }
            for k in 0..if is_body { 0 } else { N } {
                let share = scaled.values[r * SIZE + k];
                to.side[r] = to.side[r] + share * share * node.side[k];
            }
        }
        let targets = nodes[place].own_blocks();
        let (before, after) = self.blocks.split_at_mut(targets.start);
        for q in p + 1..end {
            let row = specs[q].row;
            let Some(target) = specs[targets.clone()].iter().position(|spec| spec.row == row) else {
                continue;
            };
            let to = &mut after[target].values;
            for r in 0..nodes[row as usize].size as usize {
                for c in 0..rows {
                    let i = r * SIZE + c;
                    to[i] = to[i] - before[q].row_times::<N>(r, &scaled, c);
                }
            }
        }
    }

    /// Solves for the sides of the nodes.
    pub fn solve(&mut self) {
        for (i, spec) in self.pattern.nodes.iter().enumerate() {
            sized!(spec.size, self.descend(i, spec));
        }
        for (i, spec) in self.pattern.nodes.iter().enumerate().rev() {
            sized!(spec.size, self.ascend(i, spec));
        }
    }

    /// Takes a node's side, by its column of L, from those of what comes later.
    fn descend<const N: usize>(&mut self, i: usize, spec: &NodeSpec) {
        self.nodes[i].eliminate::<N>();
        let side = self.nodes[i].side;
        let own = spec.own_blocks();
        for (block, other) in self.blocks[own.clone()].iter().zip(&self.pattern.blocks[own]) {
            let rows = self.pattern.nodes[other.row as usize].size as usize;
            let to = &mut self.nodes[other.row as usize].side;
            for (row, to) in block.values.as_chunks::<SIZE>().0.iter().zip(to).take(rows) {
                for c in 0..N {
                    *to = *to - row[c] * side[c];
                }
            }
        }
    }

    /// Finds a node's answer from those of what comes later.
    fn ascend<const N: usize>(&mut self, i: usize, spec: &NodeSpec) {
        let mut side = self.nodes[i].side;
        for (r, x) in side.iter_mut().enumerate().take(N) {
            *x = *x * self.nodes[i].diagonal[at(r, r)];
        }
        let own = spec.own_blocks();
        for (block, other) in self.blocks[own.clone()].iter().zip(&self.pattern.blocks[own]) {
            let rows = self.pattern.nodes[other.row as usize].size as usize;
            let from = &self.nodes[other.row as usize].side;
            for (row, from) in block.values.as_chunks::<SIZE>().0.iter().zip(from).take(rows) {
                for c in 0..N {
                    side[c] = side[c] - row[c] * *from;
                }
            }
        }
        self.nodes[i].side = side;
        self.nodes[i].substitute::<N>();
    }
}

impl NodeRow {
    /// Factors the diagonal block. Pivots of bodies are 1 and more, those of joints negative; one that is
    /// rounding only says that others hold the row already, and it gets no impulse.
    fn factor<const N: usize>(&mut self, is_joint: bool) {
        let (one, share_least) = (Lane::splat(1.0), Lane::splat(PIVOT_SHARE));
        let least = Lane::splat(f32::MIN_POSITIVE);
        let a = &mut self.diagonal;
        for r in 0..N {
            for c in 0..r {
                let mut entry = a[at(r, c)];
                for k in 0..c {
                    // Row r holds L D until it is done.
                    entry = entry - a[at(r, k)] * a[at(c, k)];
                }
                a[at(r, c)] = entry;
            }
            let mut pivot = a[at(r, r)];
            for c in 0..r {
                let entry = a[at(r, c)];
                let share = entry * a[at(c, c)];
                pivot = pivot - entry * share;
                a[at(r, c)] = share;
                self.side[r] = self.side[r] + share * share * self.side[c];
            }
            let own = self.side[r];
            let stands = if is_joint {
                let stands = (-pivot).greater(own * share_least).and(own.greater(least));
                pivot = pivot - self.added[r] * Lane::splat(DAMPING);
                stands
            } else {
                pivot.greater(Lane::splat(0.5))
            };
            a[at(r, r)] = stands.select(one / stands.select(pivot, one), Lane::ZERO);
        }
    }

    /// Applies the inverse of L to the side.
    #[inline(always)]
    fn eliminate<const N: usize>(&mut self) {
        for r in 1..N {
            for c in 0..r {
                self.side[r] = self.side[r] - self.diagonal[at(r, c)] * self.side[c];
            }
        }
    }

    /// Applies the inverse of Lt to the side.
    #[inline(always)]
    fn substitute<const N: usize>(&mut self) {
        for r in (1..N).rev() {
            for c in 0..r {
                self.side[c] = self.side[c] - self.diagonal[at(r, c)] * self.side[r];
            }
        }
    }
}

impl BlockRow {
    /// From entries to L D.
    fn divide<const N: usize>(&mut self, node: &NodeRow) {
        for row in self.values.as_chunks_mut::<SIZE>().0 {
            for c in 1..N {
                for k in 0..c {
                    row[c] = row[c] - row[k] * node.diagonal[at(c, k)];
                }
            }
        }
    }

    /// From L D to L.
    fn scale<const N: usize>(&mut self, node: &NodeRow) {
        for row in self.values.as_chunks_mut::<SIZE>().0 {
            for (c, x) in row.iter_mut().enumerate().take(N) {
                *x = *x * node.diagonal[at(c, c)];
            }
        }
    }

    /// Row `r` times row `c` of another block.
    #[inline(always)]
    fn row_times<const N: usize>(&self, r: usize, other: &Self, c: usize) -> Lane {
        let mut sum = Lane::ZERO;
        for k in 0..N {
            sum = sum + self.values[r * SIZE + k] * other.values[c * SIZE + k];
        }
        sum
    }
}

/// J of a lock at one end, for velocities scaled by the roots of mass and inertia.
#[inline(always)]
fn scaled(link: &JointLink, row: &LockRow, end: usize) -> [Lane; SIZE] {
    let ways = &row.ways;
    let (scale, written, top, now, back) = if end == 0 {
        (link.scale_a, ways.a, link.top_a, &link.now_a, &link.back_a)
    } else {
        (link.scale_b, ways.b, link.top_b, &link.now_b, &link.back_b)
    };
    let push = ways.direction.each_times(scale);
    let mut turn = written;
    if link.tops != 0 {
        turn = top.greater(Lane::ZERO).select_vec(root_times(now, root_times(back, written)), written);
    }
    let (push, turn) = if end == 0 { (LaneVec::ZERO - push, LaneVec::ZERO - turn) } else { (push, turn) };
    [push.x, push.y, push.z, turn.x, turn.y, turn.z]
}
