//! Which joints are solved at once.
//!
//! Joints that hang together make an *articulation*: its bodies are held by all of its joints at the same time, so
//! that a chain does not stretch and a linkage does not lag behind itself, however light its parts are. Joints
//! gather in the order of their slots until an articulation is full; one that joins two full ones, or hangs alone,
//! holds nothing rigidly (a rope), or belongs to a net in which too much would fill, stays *loose*: it is a link of
//! the ordering like a contact.
//!
//! Equal articulations are solved side by side in lanes. All of them make one phase of their own, after those of
//! the ordering.
//!
//! All of this follows from the joints, their bodies and one setting alone, and is kept as long as they stay.

use crate::cells::{IMMOVABLE, Link};
use crate::constraint::joint::{
    Articulation, BlockSpec, Elimination, JOINTS_MAX, Matrix, Member, NONE, NodeSpec, Pattern,
};
use crate::joint::Signature;
use crate::lanes::LANES;
use crate::pipeline::layout::{EMPTY, Group, REFINED_KIND};
use crate::pipeline::sleep::root;
use crate::pipeline::solver::{JointRows, take};
use bytemuck::{Pod, Zeroable};

/// More bodies than fit an articulation are a net when this many times the loops are more than the joints: pieces
/// of a net take five times as long at once as one by one.
const NET_LOOPS: u32 = 4;

/// Up to eight equal articulations.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(crate) struct ArticulationRow {
    /// Place of the first joint of each lane's articulation, or `EMPTY`: its joints follow one another.
    pub first: [u32; LANES],
    /// Joints of each.
    pub joints: u32,
    pub nodes: u32,
    pub blocks: u32,
    /// First of the nodes and blocks of the pattern, which equal articulations share.
    pub first_node: u32,
    pub first_block: u32,
    /// Zero.
    pub reserved: [u32; 3],
}

/// What the joints come to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Arrangement {
    /// Joints that are links of the ordering.
    pub loose: usize,
    /// Rows of articulations.
    pub rows: usize,
}

/// The articulations of a step.
#[derive(Clone, Copy)]
pub(crate) struct Patterns<'a> {
    pub rows: &'a [ArticulationRow],
    pub nodes: &'a [NodeSpec],
    pub blocks: &'a [BlockSpec],
}

impl<'a> Patterns<'a> {
    /// Those of a group.
    pub fn of(self, group: &Group) -> Self {
        let first = group.first_articulation as usize;
        Self { rows: &self.rows[first..first + group.articulations as usize], ..self }
    }

    /// Calls `visit` for each row of articulations, with what is theirs of the rows of joints.
    pub fn each(self, mut joints: JointRows<'_>, mut visit: impl FnMut(&mut Articulation<'_>)) {
        for row in self.rows {
            let links = take(&mut joints.links, row.joints as usize);
            let sum = |count: fn(Signature) -> usize| links.iter().map(|l| count(l.signature())).sum();
            let (locks, bounds) = (sum(Signature::lock_rows), sum(Signature::bound_rows));
            let (nodes, blocks) = (row.nodes as usize, row.blocks as usize);
            let pattern = Pattern {
                nodes: &self.nodes[row.first_node as usize..][..nodes],
                blocks: &self.blocks[row.first_block as usize..][..blocks],
            };
            let matrix = Matrix {
                pattern,
                nodes: take(&mut joints.nodes, nodes),
                blocks: take(&mut joints.blocks, blocks),
            };
            let (locks, bounds) = (take(&mut joints.locks, locks), take(&mut joints.bounds, bounds));
            visit(&mut Articulation { links, locks, bounds, matrix });
        }
    }
}

/// Where the arrangement is written, and what is needed on the way.
pub(crate) struct Tables<'a> {
    /// Place of each joint: loose ones first, in their order, then articulation by articulation.
    pub places: &'a mut [u32],
    pub rows: &'a mut [ArticulationRow],
    pub nodes: &'a mut [NodeSpec],
    pub blocks: &'a mut [BlockSpec],
    /// Set of each body, by slot, and the joints of each set, and how many of them close a loop or are anchors.
    pub sets: &'a mut [u32],
    pub sizes: &'a mut [u32],
    pub loops: &'a mut [u32],
    /// Joints by set.
    pub keys: &'a mut [u64],
    /// Joints as members of their articulations, in the order of the keys.
    pub members: &'a mut [Member],
    /// First key and number of joints of each articulation.
    pub found: &'a mut [[u32; 2]],
}

/// Arranges joints whose links, from A to B between slots of bodies, are given in the order of the joints' slots.
pub(crate) fn arrange(links: &[Link], tables: &mut Tables<'_>) -> Arrangement {
    let joined = gather(links, tables);
    let count = find(links, joined, tables);
    let Tables { places, found, members, keys, .. } = tables;
    let of = |&[first, joints]: &[u32; 2]| &members[first as usize..(first + joints) as usize];
    // Those of one tier follow one another.
    let tier = |found: &[u32; 2]| of(found)[0].signature & REFINED_KIND;
    found[..count].sort_unstable_by(|a, b| {
        let sizes = tier(a).cmp(&tier(b)).then(b[1].cmp(&a[1]));
        sizes.then(of(a).cmp(of(b))).then(a[0].cmp(&b[0]))
    });
    places[..links.len()].fill(0);
    for &[first, joints] in &found[..count] {
        keys[first as usize..(first + joints) as usize].iter().for_each(|&key| places[rank_of(key)] = EMPTY);
    }
    let mut next = 0;
    for place in places[..links.len()].iter_mut().filter(|place| **place != EMPTY) {
        *place = next;
        next += 1;
    }
    let loose = next as usize;
    let rows = write_rows(count, next, tables);
    Arrangement { loose, rows }
}

/// Leaves all of so many joints loose, in their order.
pub(crate) fn leave_loose(joints: usize, tables: &mut Tables<'_>) -> Arrangement {
    tables.places[..joints].iter_mut().zip(0..).for_each(|(place, rank)| *place = rank);
    Arrangement { loose: joints, rows: 0 }
}

/// Gathers joints into sets of bodies; writes a key for each joint of a set, sorted by set and then rank. Returns
/// how many they are.
fn gather(links: &[Link], tables: &mut Tables<'_>) -> usize {
    // What holds nothing without bounds (a rope) has no row in a matrix.
    for (place, link) in tables.places.iter_mut().zip(links) {
        *place = u32::from(Signature::of_kind(link.kind).lock_rows() == 0);
    }
    unite(links, tables, |stays, _| stays == 0);
    // What each joint's whole component is like, before the sets are made anew.
    for (rank, link) in links.iter().enumerate() {
        let set = root(tables.sets, ends_of(link)[0]) as usize;
        let (joints, loops) = (tables.sizes[set], tables.loops[set]);
        let is_net = joints as usize > JOINTS_MAX && loops * NET_LOOPS > joints;
        tables.places[rank] |= u32::from(is_net);
    }
    let count = unite(links, tables, |stays, size| stays == 0 && size <= JOINTS_MAX);
    let Tables { sets, keys, .. } = tables;
    for key in &mut keys[..count] {
        *key |= u64::from(root(sets, ends_of(&links[*key as usize])[0])) << 32;
    }
    keys[..count].sort_unstable();
    count
}

/// Unites the bodies of joints, unless they stay apart: `fits` gets the place of a joint as it is in the tables,
/// and the joints that the set would have. Writes the ranks of the joints of sets as keys; returns how many.
fn unite(links: &[Link], tables: &mut Tables<'_>, fits: impl Fn(u32, usize) -> bool) -> usize {
    let Tables { sets, sizes, loops, keys, places, .. } = tables;
    for body in links.iter().flat_map(ends_of) {
        (sets[body as usize], sizes[body as usize], loops[body as usize]) = (body, 0, 0);
    }
    let mut count = 0;
    for (rank, link) in links.iter().enumerate() {
        let [a, b] = ends_of(link).map(|body| root(sets, body));
        let size = sizes[a as usize] + if a == b { 0 } else { sizes[b as usize] } + 1;
        if fits(places[rank], size as usize) {
            let (low, high) = (a.min(b), a.max(b));
            let own = if a == b { 1 } else { loops[high as usize] };
            sets[high as usize] = low;
            sizes[low as usize] = size;
            loops[low as usize] += own;
            keys[count] = rank as u64;
            count += 1;
        }
    }
    count
}

/// The bodies of a joint that move; twice the same where one does not.
fn ends_of(link: &Link) -> [u32; 2] {
    match (link.a, link.b) {
        (IMMOVABLE, b) => [b; 2],
        (a, IMMOVABLE) => [a; 2],
        (a, b) => [a, b],
    }
}

/// Rank of the joint of a key.
fn rank_of(key: u64) -> usize {
    key as u32 as usize
}

/// Lists the sets that are worth a solve of their own, and their members. Returns how many.
fn find(links: &[Link], joined: usize, tables: &mut Tables<'_>) -> usize {
    let Tables { keys, members, found, .. } = tables;
    let mut count = 0;
    let mut first = 0;
    for set in keys[..joined].chunk_by(|a, b| a >> 32 == b >> 32) {
        let members = &mut members[first..first + set.len()];
        if set.len() > 1 {
            number(links, set, members);
            if Elimination::of(members).is_some() {
                found[count] = [first as u32, set.len() as u32];
                count += 1;
            }
        }
        first += set.len();
    }
    count
}

/// Numbers the bodies of a set in the order in which its joints name them.
fn number(links: &[Link], set: &[u64], members: &mut [Member]) {
    let mut bodies = [IMMOVABLE; JOINTS_MAX + 1];
    let mut count = 0;
    let mut number = |body: u32| {
        if body == IMMOVABLE {
            return NONE;
        }
        let known = bodies[..count].iter().position(|&other| other == body);
        let number = known.unwrap_or(count);
        if known.is_none() {
            bodies[count] = body;
            count += 1;
        }
        number as u32
    };
    for (member, &key) in members.iter_mut().zip(set) {
        let link = &links[rank_of(key)];
        *member = Member { signature: link.kind, bodies: [number(link.a), number(link.b)] };
    }
}

/// Deals equal articulations, which follow one another, to rows, and places their joints from `next` on. Returns
/// the number of rows.
fn write_rows(count: usize, mut next: u32, tables: &mut Tables<'_>) -> usize {
    let Tables { places, rows, nodes, blocks, keys, members, found, .. } = tables;
    let (mut row, mut lanes) = (0, LANES);
    let (mut first_node, mut first_block) = (0, 0);
    for i in 0..count {
        let [first, joints] = found[i];
        let own = |[first, joints]: [u32; 2]| first as usize..(first + joints) as usize;
        let alike = i > 0 && members[own(found[i - 1])] == members[own(found[i])];
        if !alike || lanes == LANES {
            lanes = 0;
            row += 1;
            rows[row - 1] = if alike { rows[row - 2] } else { ArticulationRow::zeroed() };
            rows[row - 1].first = [EMPTY; LANES];
        }
        let new = &mut rows[row - 1];
        if !alike && let Some(elimination) = Elimination::of(&members[own(found[i])]) {
            let (n, b) = elimination.size();
            elimination.write(&members[own(found[i])], &mut nodes[first_node..], &mut blocks[first_block..]);
            (new.joints, new.nodes, new.blocks) = (joints, n as u32, b as u32);
            (new.first_node, new.first_block) = (first_node as u32, first_block as u32);
            (first_node, first_block) = (first_node + n, first_block + b);
        }
        new.first[lanes] = next;
        lanes += 1;
        for &key in &keys[first as usize..(first + joints) as usize] {
            places[rank_of(key)] = next;
            next += 1;
        }
    }
    row
}
