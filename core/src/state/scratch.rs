//! Rows that each step makes anew.

use super::{ContactRow, JOINT_BOUNDS, Memo};
use crate::arena::region;
use crate::body::{BodyRow, Motion};
use crate::cells::{self, Block, Link};
use crate::constraint::joint::{
    BallRow, BlockRow, BoundRow, JointLink, LockRow, Member, NodeRow, blocks_max, nodes_max,
};
use crate::constraint::row::{ConeRow, LinkRow, PointRow, ResistRow};
use crate::event::Visit;
use crate::lanes::Words;
use crate::math::{Aabb, Vec3};
use crate::pipeline::continuous::Stop;
use crate::pipeline::layout::{links_max, mover_rows_max, seats_max};
use crate::pipeline::mover::MoverRow;
use crate::pipeline::seat::Seat;
use crate::pool::words;
use bytemuck::{Pod, Zeroable};

/// The box of a shape over the way of the step, and a ball: what may touch.
#[repr(C, align(16))]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(crate) struct Reach {
    /// Least corner, from the middle of the body's sector.
    pub min: Vec3,
    /// Slot of the body.
    pub body: u32,
    /// Greatest corner.
    pub max: Vec3,
    /// `Reach::HOME`, `Reach::DYNAMIC`.
    pub flags: u32,
    /// Origin of the shape's frame, from the middle of the body's sector.
    pub origin: Vec3,
    /// How far from there the shape's contacts may be; infinite for a shape without end.
    pub radius: f32,
}

impl Reach {
    /// The body is in the trees' sector.
    pub const HOME: u32 = 1;
    /// The body is dynamic.
    pub const DYNAMIC: u32 = 2;
}

/// What a contact is in this step.
#[repr(C, align(32))]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(crate) struct Touch {
    /// Slots of the shapes in the solver's order: A's body is dynamic, and the rounder one of two dynamic ones.
    pub shapes: [u32; 2],
    pub friction: f32,
    pub restitution: f32,
    /// From the center of body A to that of body B.
    pub centers: Vec3,
    /// [`Touch::SETTLED`], [`Touch::FAST`] or 0; [`Touch::ACTS`] is added to the last two.
    pub settled: f32,
}

impl Touch {
    /// The separations follow from the memo's points and the poses, and arms from the stances; else the memo gives
    /// the separations.
    pub const SETTLED: f32 = 1.0;
    /// The bodies come from far: the point of contact is A's, and not in the middle between the two points.
    pub const FAST: f32 = 0.5;
    /// A surface moves, or resists rolling or spinning.
    pub const ACTS: f32 = -2.0;

    /// True for what is neither settled nor fast, and has surfaces that do nothing.
    pub fn is_plain(&self) -> bool {
        self.settled.to_bits() == 0
    }

    /// True for [`Touch::FAST`], whatever the surfaces do.
    pub fn is_fast(&self) -> bool {
        self.settled == Self::FAST || self.settled == Self::FAST + Self::ACTS
    }

    /// -1 when the solver's order is not that of the slots: the sign of what is stored for the body of the
    /// higher slot.
    pub fn sign(&self) -> f32 {
        if self.shapes[0] < self.shapes[1] { 1.0 } else { -1.0 }
    }
}

/// A contact that begins.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(crate) struct Birth {
    pub row: ContactRow,
    pub memo: Memo,
    pub touch: Touch,
    /// Contacts of the step before that come before it.
    pub before: u32,
    /// Zero.
    pub reserved: [u32; 7],
}

/// A body that takes part in the solve: three rows of lanes.
#[repr(C, align(32))]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(crate) struct Active {
    /// Velocity at the start of the step, m/s.
    pub linear: Vec3,
    /// 1/kg.
    pub inverse_mass: f32,
    /// Angular velocity in the world, rad/s.
    pub angular: Vec3,
    /// World axes along which the body does not move, as x + 2 y + 4 z.
    pub locks: f32,
    /// W with W W = inverse inertia, about the world's axes at the start of the step: xx, yy, zz, xy, xz, yz.
    pub root: [f32; 6],
    /// Slot of the body.
    pub body: u32,
    /// What the principal moments of inertia gain in this step, kg m2: see `pipeline/stiffening.rs`.
    pub stiffening: Vec3,
    /// Velocity gained from gravity and force in a substep, m/s.
    pub push: Vec3,
    /// Whitened angular velocity at the start of the step.
    pub whitened: Vec3,
}

impl Active {
    /// Moments of inertia in this step, kg m2.
    #[inline]
    pub fn inertia(&self, row: &BodyRow) -> Vec3 {
        row.inertia + self.stiffening
    }
}

region! {
    /// Made anew by each step.
    ScratchLayout, Scratch, |c| {
        /// Boxes of the leaves of a tree that is built, by shape.
        tree_boxes: Aabb = c.shapes as usize,
        tree_keys: u64 = c.shapes as usize,
        /// Shapes whose boxes changed, ascending.
        moved: u32 = c.shapes as usize,
        /// Bits of `broadphase.rs` for each slot: `MOVED`, `GONE`, `SLEEPS`.
        is_moved: u8 = c.shapes as usize,
        /// Pairs found for moved shapes, twice the capacity so that the best can be chosen.
        found: u64 = 2 * c.pairs as usize,
        reaches: Reach = c.shapes as usize,
        /// Frames of the shapes in world axes, from their bodies' centers: `[position, 0, rotation]`.
        frames: Words = c.shapes as usize,
        /// The same with the bodies turned as in their stances.
        stances: Words = c.shapes as usize,
        /// Contacts that begin, in runs by pair.
        births: Birth = c.pairs as usize + c.contacts as usize,
        /// Of the contacts of the step before; then, if some began or ended, of those of this one.
        touches: Touch = c.contacts as usize,
        touches_before: Touch = c.contacts as usize,
        rows_before: ContactRow = c.contacts as usize,
        /// Index of each link in the step before, or `NEW`.
        contact_from: u32 = links_max(c),
        /// Places of the contacts that woke in this step, ascending.
        woken: u32 = c.contacts as usize,
        /// Sets of bodies that are joined by links, by slot.
        islands: u32 = c.bodies as usize,
        /// Bodies of a set, at its least body.
        island_sizes: u32 = c.bodies as usize,
        /// What `loaded` becomes.
        loaded_now: u64 = words(c.bodies as usize),
        /// A bit for each active body that is refined.
        active_refined: u64 = words(c.bodies as usize),
        /// What becomes of a body or of its island, by slot.
        marks: u8 = c.bodies as usize,
        /// Bodies of the links that ended.
        lost: [u32; 2] = links_max(c),
        /// Index among the active bodies by slot; `u32::MAX` for none.
        active_of: u32 = c.bodies as usize,
        active: Active = c.bodies as usize,
        /// Contacts, then joints.
        links: Link = links_max(c),
        /// The same links between slots of bodies.
        slot_links: Link = links_max(c),
        /// Slots of the joints that hold something, by place.
        joint_slots: u32 = c.joints as usize,
        /// The same in ascending order, and their links between slots, from A to B.
        held_slots: u32 = c.joints as usize,
        held_links: Link = c.joints as usize,
        /// For arranging joints; of no length without any.
        joint_sets: u32 = if c.joints == 0 { 0 } else { c.bodies as usize },
        joint_set_sizes: u32 = if c.joints == 0 { 0 } else { c.bodies as usize },
        joint_set_loops: u32 = if c.joints == 0 { 0 } else { c.bodies as usize },
        /// By slot of a body: see `pipeline/leapfrog.rs`.
        joint_marks: u32 = if c.joints == 0 { 0 } else { c.bodies as usize },
        joint_members: Member = c.joints as usize,
        joint_runs: [u32; 2] = c.joints as usize / 2,
        phases: u8 = links_max(c),
        order: u32 = links_max(c),
        blocks: Block = links_max(c),
        ordering: u32 = cells::upkeep_scratch_words(c.bodies as usize, links_max(c)),
        ball_rows: BallRow = c.joints as usize,
        joint_links: JointLink = c.joints as usize,
        lock_rows: LockRow = 6 * c.joints as usize,
        bound_rows: BoundRow = JOINT_BOUNDS * c.joints as usize,
        /// Nodes and blocks of the articulations' matrices.
        node_rows: NodeRow = nodes_max(c.joints as usize),
        block_rows: BlockRow = blocks_max(c.joints as usize),
        joint_keys: u64 = c.joints as usize,
        /// Where each row of joints is, and its first lock and bound; `EMPTY` for those of plain balls.
        joint_firsts: [u32; 3] = c.joints as usize,
        link_rows: LinkRow = c.contacts as usize,
        /// Resistance of each row of links that has some.
        resist_rows: ResistRow = if c.materials == 0 { 0 } else { c.contacts as usize },
        /// Cones of the points of each row of links, where each point has one: else never touched.
        cone_rows: ConeRow = c.contacts as usize,
        point_rows: PointRow = 4 * c.contacts as usize,
        seats: Seat = seats_max(c),
        /// First point of each row.
        row_points: u32 = c.contacts as usize,
        /// Chain of each block of the phase that is laid out.
        block_chains: u32 = links_max(c),
        /// Row after the last one that has a body, by active body.
        body_rows: u32 = c.bodies as usize,
        /// The body's seat in the phase that is laid out, by active body.
        phase_seats: u32 = c.bodies as usize,
        /// Where fast bodies, kinematic ones and those that changed their sector were before the step, by slot.
        origins: Motion = c.bodies as usize,
        /// Slots of the fast bodies, ascending.
        fast: u32 = c.bodies as usize,
        /// Shapes of theirs that have left their fat boxes, if there are bullets.
        strays: u32 = c.shapes as usize,
        /// Where each of the fast bodies is stopped.
        stops: Stop = c.bodies as usize,
        /// Eight seats of phase 0 each.
        movers: MoverRow = mover_rows_max(c),
        /// Pairs of shapes of contacts that ended in this step, and that began; contacts that are hits. Of no
        /// length without events.
        ended: u64 = if c.events == 0 { 0 } else { 2 * c.contacts as usize },
        began: u64 = if c.events == 0 { 0 } else { c.contacts as usize },
        hits: u32 = if c.events == 0 { 0 } else { c.contacts as usize },
        /// Slots of the sensors; visits that are found, and then all of the step.
        sensor_slots: u32 = if c.sensor_visits == 0 { 0 } else { c.shapes as usize },
        found_visits: Visit = c.sensor_visits as usize,
        visits_now: Visit = c.sensor_visits as usize,
        /// For registering a mesh.
        mesh_words: u64 = crate::collide::mesh::scratch_len(c.mesh_triangles as usize),
        mesh_boxes: Aabb = c.mesh_triangles as usize,
        /// For registering a compound.
        child_words: u64 = c.compound_children as usize,
        child_boxes: Aabb = c.compound_children as usize,
    }
}
