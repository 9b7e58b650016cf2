//! An implicit bounding-volume tree: boxes in one array, no pointers.
//!
//! The leaves are sorted along a Morton curve, so that neighbours in space are neighbours in the array. Level 0 is
//! the boxes of the leaves in that order; every box of the level above is the union of four neighbours, and so on
//! up to a single root. The place of a box says all about its relatives:
//!
//! ```text
//! level 2                      [ root ]                nodes[n0 + n1]
//! level 1      [ 0..4 ]         [ 4..8 ]     [ 8..10 ] nodes[n0 ..]     n1 = ceil(n0 / 4)
//! level 0   [0][1][2][3]     [4][5][6][7]     [8][9]   nodes[0 ..]      n0 = leaves
//! ```
//!
//! The children of box `i` are boxes `4 i .. 4 i + 4` of the level below. Four siblings are 96 bytes in a row, and
//! leaf boxes are stored too (32 bytes a leaf in all): a search reads boxes in sequence and never gathers them by
//! leaf. Four children halve the number of levels of a binary tree at the same number of box tests.
//!
//! Invariants: a search visits exactly the leaves whose own box overlaps the region. How good the tree is changes
//! the time and the order of the visits, never the set.

pub(crate) mod search;

use crate::math::{Aabb, Vec3, max, max_each, min_each};

/// Children of a box.
const WIDTH: usize = 4;
/// So many leaves are as soon found in any order, and stand in that of their ids.
const FEW: usize = WIDTH * WIDTH;
/// Centers farther out than this do not widen the curve, metres. They go to its ends.
const FAR: f32 = 1.0e8;
/// More levels than any tree can have: 4^16 leaves.
const LEVELS_MAX: usize = 17;

/// A tree over boxes, as a view of its tables. Made by [`build`].
#[derive(Clone, Copy, Debug)]
pub struct Tree<'a> {
    /// Boxes, level by level from the leaves to the root: [`node_count`] of them.
    pub nodes: &'a [Aabb],
    /// The id of each leaf, in the order of the first level. Distinct.
    pub order: &'a [u32],
}

/// Number of boxes of a tree with so many leaves.
pub const fn node_count(leaves: usize) -> usize {
    let mut level = leaves;
    let mut total = leaves;
    while level > 1 {
        level = level.div_ceil(WIDTH);
        total += level;
    }
    total
}

/// Builds the tree of the leaves `ids`, whose boxes are `boxes[id]`, and returns their number `n`.
///
/// Writes `order[..n]` and `nodes[..node_count(n)]`; `keys[..n]` is scratch. Ids are distinct. The result depends
/// on the set of ids and their boxes, not on the order in which ids come.
///
/// # Panics
/// When an id has no box or a table is too short.
pub fn build(
    boxes: &[Aabb],
    ids: impl Iterator<Item = u32>,
    keys: &mut [u64],
    order: &mut [u32],
    nodes: &mut [Aabb],
) -> usize {
    let mut count = 0;
    let mut id_max = 0;
    let mut bounds = Aabb::EMPTY;
    for id in ids {
        let center = boxes[id as usize].center();
        // The center of a box without end (a half-space) would leave one cell for all others.
        if center.abs().max_element() < FAR {
            bounds = Aabb { min: min_each(center, bounds.min), max: max_each(center, bounds.max) };
        }
        id_max = id_max.max(id);
        keys[count] = u64::from(id);
        count += 1;
    }
    if count > FEW {
        sort_along_curve(boxes, &bounds, id_max, &mut keys[..count]);
    } else {
        keys[..count].sort_unstable();
    }
    let id_mask = id_mask(id_max);
    for (slot, key) in order[..count].iter_mut().zip(&keys[..count]) {
        *slot = (key & id_mask) as u32;
    }
    refit(boxes, &order[..count], nodes);
    count
}

/// Computes the boxes of a tree anew, bottom up, from the boxes of its leaves: after leaves have moved.
///
/// Writes `nodes[..node_count(order.len())]`.
///
/// # Panics
/// When an id has no box or `nodes` is too short.
pub fn refit(boxes: &[Aabb], order: &[u32], nodes: &mut [Aabb]) {
    for (node, &id) in nodes[..order.len()].iter_mut().zip(order) {
        *node = boxes[id as usize];
    }
    let (mut first, mut count) = (0, order.len());
    while count > 1 {
        let (below, above) = nodes.split_at_mut(first + count);
        for (node, children) in above.iter_mut().zip(below[first..].chunks(WIDTH)) {
            *node = children.iter().fold(Aabb::EMPTY, |sum, child| sum.union(child));
        }
        first += count;
        count = count.div_ceil(WIDTH);
    }
}

impl Tree<'_> {
    /// The box around all leaves; empty when there are none.
    pub fn bounds(&self) -> Aabb {
        match self.order.len() {
            0 => Aabb::EMPTY,
            leaves => self.nodes[node_count(leaves) - 1],
        }
    }

    /// The boxes of the lowest level that has at most `count` of them.
    pub fn level_within(&self, count: usize) -> &[Aabb] {
        let (first, counts, top) = levels(self.order.len());
        let level = (0..=top).find(|&level| counts[level] <= count).unwrap_or(top);
        &self.nodes[first[level]..first[level] + counts[level]]
    }

    /// Visits the id of every leaf whose box overlaps `region` (faces included), once, in the order of the leaves.
    #[inline(always)]
    pub fn query(&self, region: &Aabb, mut visit: impl FnMut(u32)) {
        self.any(region, |id| {
            visit(id);
            false
        });
    }

    /// True when `is` says so of the id of a leaf whose box overlaps `region` (faces included). Asks leaf by leaf,
    /// in their order, until one is found.
    ///
    /// The walk keeps no stack: the box after a subtree is the next sibling, or that of the nearest ancestor that
    /// has one, and both are found from the index.
    #[inline(always)]
    pub fn any(&self, region: &Aabb, mut is: impl FnMut(u32) -> bool) -> bool {
        if self.order.is_empty() || !self.bounds().overlaps(region) {
            return false;
        }
        let (first, count, top) = levels(self.order.len());
        let (mut level, mut index) = (top, 0);
        loop {
            if self.nodes[first[level] + index].overlaps(region) {
                if level > 0 {
                    level -= 1;
                    index *= WIDTH;
                    continue;
                }
                if is(self.order[index]) {
                    return true;
                }
            }
            index += 1;
            while index % WIDTH == 0 || index == count[level] {
                if level == top {
                    return false;
                }
                level += 1;
                index = index.div_ceil(WIDTH);
            }
        }
    }
}

/// Where each level starts in the nodes, how many boxes it has, and the level of the root.
fn levels(leaves: usize) -> ([usize; LEVELS_MAX], [usize; LEVELS_MAX], usize) {
    let mut first = [0; LEVELS_MAX];
    let mut count = [0; LEVELS_MAX];
    count[0] = leaves;
    let mut top = 0;
    while count[top] > 1 {
        count[top + 1] = count[top].div_ceil(WIDTH);
        first[top + 1] = first[top] + count[top];
        top += 1;
    }
    (first, count, top)
}

/// Turns ids into unique keys, the place on the curve above and the id below, and sorts them.
fn sort_along_curve(boxes: &[Aabb], bounds: &Aabb, id_max: u32, keys: &mut [u64]) {
    // The id takes no more bits than it needs; each axis gets a third of the rest.
    let id_bits = id_mask(id_max).count_ones();
    let axis_bits = ((u64::BITS - id_bits) / 3).min(21);
    let cells = ((1_u32 << axis_bits) - 1) as f32;
    // One scale for all axes keeps cells cubes. Degenerate or infinite bounds give zero or NaN here, which the
    // casts below turn into cell 0: a poor tree, but a right one.
    let extent = bounds.max - bounds.min;
    let scale = cells / max(extent.x, max(extent.y, max(extent.z, f32::MIN_POSITIVE)));
    for key in keys.iter_mut() {
        let id = *key;
        let cell = (boxes[id as usize].center() - bounds.min) * scale;
        *key = curve_code(cell, cells) << id_bits | id;
    }
    keys.sort_unstable();
}

/// The bits of a key that hold the id.
fn id_mask(id_max: u32) -> u64 {
    u64::MAX >> (u64::from(id_max) | 1).leading_zeros()
}

/// Place of a cell on the Morton curve: the bits of its three coordinates interleaved.
fn curve_code(cell: Vec3, cells: f32) -> u64 {
    let coordinate = |x: f32| u64::from(x as u32).min(cells as u64);
    spread(coordinate(cell.x)) | spread(coordinate(cell.y)) << 1 | spread(coordinate(cell.z)) << 2
}

/// Moves bit `i` of a 21-bit number to bit `3 i`.
fn spread(x: u64) -> u64 {
    let x = (x | x << 32) & 0x001f_0000_0000_ffff;
    let x = (x | x << 16) & 0x001f_0000_ff00_00ff;
    let x = (x | x << 8) & 0x100f_00f0_0f00_f00f;
    let x = (x | x << 4) & 0x10c3_0c30_c30c_30c3;
    (x | x << 2) & 0x1249_2492_4924_9249
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use std::vec;
    use std::vec::Vec;

    fn random(state: &mut u32) -> f32 {
        *state = state.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
        (*state >> 8) as f32 / 16_777_216.0
    }

    fn random_box(state: &mut u32, spread: f32, size: f32) -> Aabb {
        let mut next = |scale: f32| Vec3::new(random(state), random(state), random(state)) * scale;
        Aabb::around(next(spread), next(size))
    }

    struct Owned {
        nodes: Vec<Aabb>,
        order: Vec<u32>,
    }

    fn built(boxes: &[Aabb], ids: &[u32]) -> Owned {
        let n = ids.len();
        let mut owned = Owned { nodes: vec![Aabb::EMPTY; node_count(n)], order: vec![0; n] };
        let mut keys = vec![0; n];
        let count = build(boxes, ids.iter().copied(), &mut keys, &mut owned.order, &mut owned.nodes);
        assert_eq!(count, n);
        owned
    }

    fn check(boxes: &[Aabb], ids: &[u32], owned: &Owned, region: &Aabb) {
        let tree = Tree { nodes: &owned.nodes, order: &owned.order };
        let mut found = Vec::new();
        tree.query(region, |id| found.push(id));
        found.sort_unstable();
        let mut expected: Vec<u32> =
            ids.iter().copied().filter(|&id| boxes[id as usize].overlaps(region)).collect();
        expected.sort_unstable();
        assert_eq!(found, expected);
        // Each of them is found, and nothing else is asked for.
        for &wanted in &expected {
            assert!(tree.any(region, |id| id == wanted));
        }
        assert!(!tree.any(region, |id| expected.binary_search(&id).is_err()));
    }

    #[test]
    fn visits_exactly_the_overlapping_leaves() {
        let mut seed = 1;
        let counts = (0..70).chain([255, 256, 257, 1023, 1024, 1025, 5000]);
        for count in counts {
            let boxes: Vec<Aabb> = (0..2 * count + 1).map(|_| random_box(&mut seed, 10.0, 0.3)).collect();
            // Every second box is no leaf, and ids come in descending order.
            let ids: Vec<u32> = (0..count as u32).rev().map(|i| 2 * i + 1).collect();
            let owned = built(&boxes, &ids);
            for _ in 0..20 {
                check(&boxes, &ids, &owned, &random_box(&mut seed, 10.0, 2.0));
            }
            check(&boxes, &ids, &owned, &Aabb::around(Vec3::ZERO, Vec3::splat(100.0)));
            check(&boxes, &ids, &owned, &Aabb::EMPTY);
        }
    }

    #[test]
    fn refit_follows_the_leaves_and_keeps_the_order() {
        let mut seed = 5;
        let mut boxes: Vec<Aabb> = (0..777).map(|_| random_box(&mut seed, 10.0, 0.3)).collect();
        let ids: Vec<u32> = (0..777).collect();
        let mut owned = built(&boxes, &ids);
        for b in &mut boxes {
            *b = random_box(&mut seed, 20.0, 0.5);
        }
        let order = owned.order.clone();
        refit(&boxes, &owned.order, &mut owned.nodes);
        assert_eq!(order, owned.order);
        for _ in 0..50 {
            check(&boxes, &ids, &owned, &random_box(&mut seed, 20.0, 2.0));
        }
        let all = boxes.iter().fold(Aabb::EMPTY, |sum, b| sum.union(b));
        assert_eq!(Tree { nodes: &owned.nodes, order: &owned.order }.bounds(), all);
    }

    #[test]
    fn order_of_ids_does_not_matter() {
        let mut seed = 9;
        let boxes: Vec<Aabb> = (0..300).map(|_| random_box(&mut seed, 10.0, 0.3)).collect();
        let ids: Vec<u32> = (0..300).collect();
        let backwards: Vec<u32> = (0..300).rev().collect();
        let (a, b) = (built(&boxes, &ids), built(&boxes, &backwards));
        assert_eq!(a.order, b.order);
        assert_eq!(a.nodes, b.nodes);
    }

    #[test]
    fn empty_coincident_and_infinite_boxes() {
        let owned = built(&[], &[]);
        let tree = Tree { nodes: &owned.nodes, order: &owned.order };
        assert_eq!(tree.bounds(), Aabb::EMPTY);
        tree.query(&Aabb::default(), |_| panic!("no leaves"));

        let everything = Aabb { min: Vec3::splat(-f32::MAX), max: Vec3::splat(f32::MAX) };
        let mut boxes = vec![Aabb::default(); 40];
        boxes[7] = everything;
        boxes[8] = Aabb { min: Vec3::splat(f32::NEG_INFINITY), max: Vec3::splat(f32::INFINITY) };
        boxes[9] = Aabb { min: Vec3::splat(-1.0e30), max: Vec3::new(1.0e30, 1.0e30, 0.0) };
        let ids: Vec<u32> = (0..40).collect();
        let owned = built(&boxes, &ids);
        check(&boxes, &ids, &owned, &Aabb::around(Vec3::splat(1.0e6), Vec3::ONE));
        check(&boxes, &ids, &owned, &Aabb::default());
    }

    #[test]
    fn keys_are_unique_for_the_largest_ids() {
        assert_eq!(id_mask(0), 1);
        assert_eq!(id_mask(5), 7);
        assert_eq!(id_mask(u32::MAX), u64::from(u32::MAX));
        assert_eq!(spread(0x1f_ffff), 0x1249_2492_4924_9249);
        assert_eq!(node_count(0), 0);
        assert_eq!(node_count(1), 1);
        assert_eq!(node_count(5), 5 + 2 + 1);
        assert_eq!(node_count(1 << 20), ((1 << 22) - 1) / 3);
        let (_, count, top) = levels(u32::MAX as usize);
        assert_eq!(count[top], 1);
    }
}
