//! The rows of a world's memory, region by region.
//!
//! **State** is everything that determines the future, and nothing else: a snapshot copies it, the checksum hashes
//! it. **Assets** never change after the first step. **Cache** is derived from state; dropping it changes time,
//! never bits. **Scratch** is made anew by each step.

mod assets;
mod fields;
mod scratch;

use crate::arena::region;
use crate::body::{BodyRow, Motion};
use crate::cells::{self, Link, OrderingRow, UNORDERED};
pub(crate) use crate::collide::hull::HullRow;
use crate::collide::tree;
use crate::config::SettingsRow;
use crate::constraint::joint::{BlockSpec, NodeSpec, blocks_max, nodes_max};
use crate::event::{BodyNews, EventRow, Tenant, Visit};
use crate::joint::{AxisRow, JointRow};
use crate::material::{MaterialRow, PairRule};
use crate::math::{Aabb, Rotation, Vec3};
use crate::pipeline::articulations::ArticulationRow;
use crate::pipeline::layout::{Group, Plan, links_max, seats_max};
use crate::pool::{Marks, words};
use crate::shape::ShapeRow;
use bytemuck::{Pod, Zeroable};

pub use assets::Surface;
pub(crate) use assets::{
    AssetTables, Assets, AssetsLayout, CompoundRow, HeightFieldRow, MeshRow, SurfaceRun,
};
pub(crate) use fields::fields;
pub use fields::{Field, FieldKind};
pub(crate) use scratch::{Active, Birth, Reach, Scratch, ScratchLayout, Touch};

/// Marks of all pools, settings and counters: the first section of the state.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(crate) struct Header {
    /// Steps taken.
    pub step: u64,
    /// Raised whenever a static shape's box changes.
    pub static_version: u64,
    pub settings: SettingsRow,
    pub bodies: Marks,
    pub shapes: Marks,
    /// Rows of `pairs` in use.
    pub pairs: u32,
    /// Rows of `contacts` in use.
    pub contacts: u32,
    /// Why the pairs are not those of the boxes: 0 they are, `PAIRS_REMOVED`, `PAIRS_DROPPED`.
    pub pairs_stale: u32,
    /// 1 when a joint was removed since the last step.
    pub joints_stale: u32,
    pub joints: Marks,
    /// Limits, drives and frictions of all joints.
    pub joint_bounds: u32,
    /// Bodies that sleep.
    pub asleep: u32,
    /// Rows of `asleep_pairs` and `asleep_contacts` in use.
    pub asleep_pairs: u32,
    pub asleep_contacts: u32,
    /// 1 when some body has to wake, or what it touches.
    pub wakes: u32,
    /// How many times the substeps the bodies in `refined` have; 0 when there is none.
    pub refine: u32,
    /// One above the highest row of `materials` in use.
    pub materials: u32,
    /// Rows of `pair_rules` in use.
    pub pair_rules: u32,
    /// Rows of `events` in use.
    pub events: u32,
    /// What the next step has to look at for its events: `TENANTS_LEFT`, `VISITS_DROPPED`,
    /// `ROUSED_LEFT`.
    pub event_marks: u32,
    /// Shapes that are sensors.
    pub sensors: u32,
    /// Shapes whose hits are told.
    pub hit_shapes: u32,
    /// Rows of `visits` in use.
    pub visits: u32,
}

/// Some rows of `tenants` are not zero.
pub(crate) const TENANTS_LEFT: u32 = 1;
/// A body is marked as roused.
pub(crate) const ROUSED_LEFT: u32 = 4;
/// Visits were dropped for want of room: all must be looked for again.
pub(crate) const VISITS_DROPPED: u32 = 2;

/// Limits, drives and frictions for each joint of the capacity, in all.
pub(crate) const JOINT_BOUNDS: usize = 4;

/// A shape was removed since the last step: its pairs must go.
pub(crate) const PAIRS_REMOVED: u32 = 1;
/// Pairs were dropped for want of room: all must be looked for again.
pub(crate) const PAIRS_DROPPED: u32 = 2;

/// Two shapes whose fat boxes overlap, lower slot first.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Pod, Zeroable)]
pub(crate) struct Pair {
    pub a: u32,
    pub b: u32,
}

/// What a contact carries from step to step.
#[repr(C, align(32))]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub(crate) struct ContactRow {
    pub pair: Pair,
    /// See [`Tag`].
    pub tag: Tag,
    /// Settled contact: the pose at which its points were found; `pipeline/meeting.rs` tells when they are found
    /// anew. Else the features of the points, and 0 or the bits of the resistance's third component.
    pub memory: [u32; 5],
    /// Normal impulses of the points, N s, not negative. Of one or two points that resist rolling or spinning the
    /// last two are components of the resistance; see [`ContactRow::resistance`].
    pub impulses: [f32; 4],
    /// Friction impulse on the body of shape B, N s, in the world.
    pub friction: Vec3,
    /// Impulse of the twist about the normal on the body of shape B, N m s.
    pub twist: f32,
}

impl ContactRow {
    /// Sort key of the pool: pair, then child.
    pub fn key(&self) -> (Pair, u32) {
        (self.pair, self.tag.child())
    }

    /// True when there is a place for the impulse of a resistance.
    pub fn can_resist(&self) -> bool {
        self.tag.points() <= 2 && !self.tag.is_settled()
    }

    /// Impulse of the torque that resists rolling and spinning on the body of shape B, N m s in the world.
    pub fn resistance(&self) -> Vec3 {
        Vec3::new(self.impulses[2], self.impulses[3], f32::from_bits(self.memory[4]))
    }

    pub fn set_resistance(&mut self, torque: Vec3) {
        (self.impulses[2], self.impulses[3], self.memory[4]) = (torque.x, torque.y, torque.z.to_bits());
    }
}

/// What a contact is, in a word: part of a concave shape (24 bits), points (3), settled (1), phase (4).
#[repr(transparent)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
pub(crate) struct Tag(u32);

/// The phase bits of a link that has none yet.
const TAG_UNORDERED: u32 = 15;

impl Tag {
    /// A contact without phase.
    pub fn new(child: u32, points: usize, is_settled: bool) -> Self {
        Self(child << 8 | (points as u32) << 5 | u32::from(is_settled) << 4 | TAG_UNORDERED)
    }

    /// Part of a concave shape: its least triangle; 0 else.
    pub fn child(self) -> u32 {
        self.0 >> 8
    }

    /// Points, 1..=4; 0 when the contact has ended.
    pub fn points(self) -> usize {
        (self.0 >> 5 & 7) as usize
    }

    pub fn is_settled(self) -> bool {
        self.0 >> 4 & 1 != 0
    }

    /// Phase of the ordering, or `cells::UNORDERED`.
    pub fn phase(self) -> u8 {
        if self.0 & 15 == TAG_UNORDERED { UNORDERED } else { (self.0 & 15) as u8 }
    }

    pub fn set_phase(&mut self, phase: u8) {
        let bits = if phase == UNORDERED { TAG_UNORDERED } else { u32::from(phase) };
        self.0 = self.0 & !15 | bits;
    }

    /// Marks the contact as ended.
    pub fn end(&mut self) {
        self.0 &= !(7 << 5);
    }
}

region! {
    /// Everything that determines the future.
    StateLayout, State, |c| {
        header: Header = 1,
        motions: Motion = c.bodies as usize,
        bodies: BodyRow = c.bodies as usize,
        body_generations: u32 = c.bodies as usize,
        body_used: u64 = words(c.bodies as usize),
        shapes: ShapeRow = c.shapes as usize,
        shape_generations: u32 = c.shapes as usize,
        shape_used: u64 = words(c.shapes as usize),
        /// Sorted, distinct.
        pairs: Pair = c.pairs as usize,
        /// Sorted by key, distinct.
        contacts: ContactRow = c.contacts as usize,
        /// Pairs and contacts of bodies that sleep, with each other and with what rests; sorted as those awake. A
        /// contact has no phase.
        asleep_pairs: Pair = c.pairs as usize,
        asleep_contacts: ContactRow = c.contacts as usize,
        ordering: OrderingRow = 1,
        /// Changes of the ordering near each body.
        dirt: u8 = c.bodies as usize,
        /// A bit for each body that is refined.
        refined: u64 = words(c.bodies as usize),
        /// A bit for each body A of a contact whose load was great when loads were last looked at.
        loaded: u64 = words(c.bodies as usize),
        joints: JointRow = c.joints as usize,
        joint_axes: [AxisRow; 6] = c.joints as usize,
        joint_generations: u32 = c.joints as usize,
        joint_used: u64 = words(c.joints as usize),
        /// The first joint of each body: its slot plus 1, or 0. Of no length without joints.
        first_joints: u32 = if c.joints == 0 { 0 } else { c.bodies as usize },
        /// What shapes have beyond friction and restitution; rows without use are zero.
        materials: MaterialRow = c.materials as usize,
        /// Sorted by key, distinct.
        pair_rules: PairRule = c.pair_rules as usize,
        /// Of the last step, in their order.
        events: EventRow = c.events as usize,
        /// Who had each shape's slot in the last step and was removed since. Of no length without events.
        tenants: Tenant = if c.events == 0 { 0 } else { c.shapes as usize },
        /// What is in each sensor: sorted by the slots of the sensor and the visitor, distinct.
        visits: Visit = c.sensor_visits as usize,
        /// Bodies that moved, if the settings ask for it, and those that a call has roused, if there is room for
        /// events.
        news: BodyNews = words(c.bodies as usize),
    }
}

/// The sections of the state in their order, each as `$section!(name, rows)` makes it of the rows that the marks of
/// a header say are in use; those of sections of no length are none.
macro_rules! sections_in_use {
    ($header:expr, $section:ident) => {{
        let header: &$crate::state::Header = $header;
        let (bodies, shapes) = (header.bodies.high as usize, header.shapes.high as usize);
        let joints = header.joints.high as usize;
        [
            $section!(header, 1),
            $section!(motions, bodies),
            $section!(bodies, bodies),
            $section!(body_generations, bodies),
            $section!(body_used, $crate::pool::words(bodies)),
            $section!(shapes, shapes),
            $section!(shape_generations, shapes),
            $section!(shape_used, $crate::pool::words(shapes)),
            $section!(pairs, header.pairs as usize),
            $section!(contacts, header.contacts as usize),
            $section!(asleep_pairs, header.asleep_pairs as usize),
            $section!(asleep_contacts, header.asleep_contacts as usize),
            $section!(ordering, 1),
            $section!(dirt, bodies),
            $section!(refined, $crate::pool::words(bodies)),
            $section!(loaded, $crate::pool::words(bodies)),
            $section!(joints, joints),
            $section!(joint_axes, joints),
            $section!(joint_generations, joints),
            $section!(joint_used, $crate::pool::words(joints)),
            $section!(first_joints, bodies),
            $section!(materials, header.materials as usize),
            $section!(pair_rules, header.pair_rules as usize),
            $section!(events, header.events as usize),
            $section!(tenants, shapes),
            $section!(visits, header.visits as usize),
            $section!(news, $crate::pool::words(bodies)),
        ]
    }};
}
pub(crate) use sections_in_use;

/// The memo of each contact is in its place.
pub(crate) const MEMOS_FIT: u32 = 1;
/// After a restore: where the memo of each settled contact is stands in `memo_sources`.
pub(crate) const MEMOS_LISTED: u32 = 2;
/// Memos are in their places, but for those that are marked as unknown.
pub(crate) const MEMOS_MARKED: u32 = 3;
/// In `memo_sources`: the memo must be found again.
pub(crate) const NO_MEMO: u32 = u32::MAX;
/// The ordering is that of the contacts in the state.
pub(crate) const ORDERING_FITS: u32 = 1;
/// After a restore: the ordering, and the layout with it, are of a state before. The next step compares.
pub(crate) const ORDERING_UNCHECKED: u32 = 2;

/// Bit of an arrangement of joints: all of them are links of the ordering.
pub(crate) const ALL_LOOSE: u32 = 1 << 31;

/// What the trees of the broadphase were built from.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(crate) struct CacheHeader {
    /// `static_version + 1` of the state when the static tree was built; 0 when there is none.
    pub static_stamp: u64,
    /// 1 when the tree of moving shapes fits the fat boxes in the state.
    pub moving_fits: u32,
    /// Whether the memos are those of the contacts in the state: 0, [`MEMOS_FIT`], or [`MEMOS_LISTED`], or
    /// [`MEMOS_MARKED`] within a step.
    pub memos_fit: u32,
    /// Which half of the memos is in use: 0 or 1.
    pub memo_half: u32,
    /// Number of links that are laid out, plus 1; 0 when there is no layout.
    pub laid_out: u32,
    /// Number of bodies in the layout.
    pub laid_out_bodies: u32,
    pub static_leaves: u32,
    pub moving_leaves: u32,
    /// Whether `ordering` is that of the contacts in the state: 0, [`ORDERING_FITS`] or [`ORDERING_UNCHECKED`].
    pub ordering_fits: u32,
    /// Sector in which both trees count their coordinates.
    pub sector: [i32; 3],
    /// Number of contacts among the links of the last update of the ordering.
    pub ordered_contacts: u32,
    /// Number of joints among them.
    pub ordered_joints: u32,
    /// 1 when the leaves of the tree of moving shapes are the right ones, whatever their boxes.
    pub moving_listed: u32,
    /// 1 when the boxes of both trees are around the shapes as they are now: for queries.
    pub queried: u32,
    /// Number of joints that are arranged, plus 1, and `ALL_LOOSE` if none was to be held at once; 0 when there is
    /// no arrangement.
    pub arranged: u32,
    /// Of these, joints that are links of the ordering.
    pub loose_joints: u32,
    /// Rows of articulations.
    pub articulations: u32,
}

region! {
    /// Derived from the state, kept between steps.
    CacheLayout, Cache, |c| {
        header: CacheHeader = 1,
        static_nodes: Aabb = tree::node_count(c.shapes as usize),
        static_order: u32 = c.shapes as usize,
        moving_nodes: Aabb = tree::node_count(c.shapes as usize),
        moving_order: u32 = c.shapes as usize,
        /// Of the contacts, in two halves of which one is in use.
        memos: Memo = 2 * c.contacts as usize,
        /// After a restore: the place of each contact's memo, or `NO_MEMO`.
        memo_sources: u32 = c.contacts as usize,
        /// What follows from the ordering in the state.
        ordering: u32 = cells::upkeep_words(c.bodies as usize, links_max(c)),
        /// Slots of the joints among the links of the last update of the ordering.
        ordered_joints: u32 = c.joints as usize,
        /// The joints that are arranged: their links between slots, from A to B, in the order of
        /// the joints' slots.
        arranged_links: Link = c.joints as usize,
        /// Place of each of them: see `pipeline/articulations.rs`, as for the rest.
        joint_order: u32 = c.joints as usize,
        articulations: ArticulationRow = c.joints as usize / 2,
        nodes: NodeSpec = nodes_max(c.joints as usize),
        blocks: BlockSpec = blocks_max(c.joints as usize),
        /// The active bodies that are laid out as refined.
        refined: u64 = words(c.bodies as usize),
        /// The links that are laid out.
        links: Link = links_max(c),
        plan: Plan = 1,
        groups: Group = crate::pipeline::layout::groups_max(c),
        /// Contact of each lane of each row; `u32::MAX` for none.
        lane_contacts: [u32; 8] = c.contacts as usize,
        /// Seats of bodies A and then B of each lane of each row, from the group's first.
        lane_seats: [u32; 16] = c.contacts as usize,
        /// Where a contact was placed: row * 8 + lane.
        contact_places: u32 = c.contacts as usize,
        /// The same three for joints, by their place.
        lane_joints: [u32; 8] = c.joints as usize,
        joint_seats: [u32; 16] = c.joints as usize,
        joint_places: u32 = c.joints as usize,
        seat_sources: u32 = seats_max(c),
        /// Active body of each seat; `u32::MAX` for the scratch seats of lanes.
        seat_bodies: u32 = seats_max(c),
        /// The seat that has the body last, by active body.
        last_seats: u32 = c.bodies as usize,
        /// The seat of phase 0, by active body.
        first_seats: u32 = c.bodies as usize,
    }
}

/// Points of a contact in the frames of its shapes: what they are in the world follows from the poses.
///
/// A is the side that the solver calls A; see [`Touch`]. Unused points are zero.
#[repr(C, align(32))]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub(crate) struct Memo {
    /// Unit normal from A to B in A's frame.
    pub normal: Vec3,
    /// 0, or 1 while the memo must be found again.
    pub is_unknown: u32,
    /// The points on A's surface, in A's frame.
    pub on_a: [Vec3; 4],
    /// The points on B's surface, in B's frame.
    pub on_b: [Vec3; 4],
    /// Settled contact: features of the points. Else the bits of their separations, metres.
    pub tail: [u32; 4],
}

/// The rotation of a body's principal frame.
pub(crate) fn principal_rotation(motion: &Motion, row: &BodyRow) -> Rotation {
    motion.rotation.after(row.axes)
}

/// Raises flags on all shapes of a body.
pub(crate) fn mark_shapes(state: &mut State<'_>, slot: usize, flags: u32) {
    let mut next = state.bodies[slot].first_shape;
    while next != u32::MAX {
        let shape = &mut state.shapes[next as usize];
        shape.flags |= flags;
        next = shape.next;
    }
}
