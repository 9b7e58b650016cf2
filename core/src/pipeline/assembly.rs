//! Assembly (the talk's third stage, SEED S5 to S7): rows written straight into solver order.

use crate::body::{BodyRow, Motion};
use crate::cells::Link;
use crate::config::{ContactModel, FrictionModel, RIGID_PUSH, STATIC_STIFFNESS, Settings};
use crate::constraint::row::{Bias, ConeRow, LinkRow, PointRow, ResistRow};
use crate::executor::{Executor, Stage};
use crate::joint::{AxisRow, JointRow};
use crate::lanes::{LANES, Words};
use crate::material::MaterialRow;
use crate::math::{PI, Vec3};
use crate::pipeline::articulations::Patterns;
use crate::pipeline::continuous::has_joints;
use crate::pipeline::integration::root_and_whitened;
use crate::pipeline::layout::{Group, Plan, TIERS};
use crate::pipeline::mover::MoverRow;
use crate::pipeline::ordering::Links;
use crate::pipeline::rows;
use crate::pipeline::seat::Seat;
use crate::pipeline::solver::{self, JointRows, take, take_some};
use crate::pipeline::stiffening;
use crate::pipeline::tasks::{Crew, Tasks, chunk, push};
use crate::pipeline::{balls, events, joints, leapfrog, refine};
use crate::shape::ShapeRow;
use crate::state::{Active, Cache, ContactRow, Memo, Scratch, State, Touch, principal_rotation};
use bytemuck::Zeroable;

/// Bodies that are worth a task.
const PREPARE_BODIES: usize = 128;

/// What assembly reads of the step.
#[derive(Clone, Copy)]
pub(crate) struct Scene<'a> {
    pub shapes: &'a [ShapeRow],
    pub materials: &'a [MaterialRow],
    pub bodies: &'a [BodyRow],
    pub motions: &'a [Motion],
    /// Frames of the shapes from their bodies' centers.
    pub frames: &'a [Words],
    /// The same in the bodies' stances.
    pub stances: &'a [Words],
    pub active: &'a [Active],
    pub links: &'a [Link],
    pub contacts: &'a [ContactRow],
    pub memos: &'a [Memo],
    pub touches: &'a [Touch],
    pub joints: &'a [JointRow],
    pub joint_axes: &'a [[AxisRow; 6]],
    /// By slot of a body: not 0 for one with joints.
    pub first_joints: &'a [u32],
    /// Marks of `pipeline/leapfrog.rs` by slot of a body; none where nothing leaps.
    pub marks: &'a [u32],
    /// Slots of the joints that are links.
    pub joint_slots: &'a [u32],
    /// Index among the active bodies by slot.
    pub active_of: &'a [u32],
    pub softness: Softnesses,
    pub bias: Bias,
    pub substep: f32,
    pub dt: f32,
    /// Whether rows measure hits.
    pub hits: bool,
}

/// Softness of contacts between dynamic bodies, and with immovable ones.
#[derive(Clone, Copy)]
pub(crate) struct Softnesses {
    pub dynamic: Softness,
    pub immovable: Softness,
}

impl Softnesses {
    fn new(settings: &Settings) -> Self {
        Self { dynamic: Softness::new(settings, 1.0), immovable: Softness::new(settings, STATIC_STIFFNESS) }
    }
}

/// How a row gives: the implicit spring of natural frequency f and damping ratio z as shares of a substep.
#[derive(Clone, Copy)]
pub(crate) struct Softness {
    pub bias_rate: f32,
    pub mass_scale: f32,
    /// What the spring gives, as a share of what the bodies give: `1 / c`.
    pub give: f32,
}

impl Softness {
    /// A damped spring integrated implicitly over a substep `h`: with `w = 2 pi f`, `a = 2 z + h w`, `c = h w a`,
    /// the row takes back `w / a` of the overlap per second, acts on `c / (1 + c)` of the velocity error, and gives
    /// up `1 / (1 + c)` of its impulse.
    fn new(settings: &Settings, factor: f32) -> Self {
        let h = settings.substep();
        if settings.contact_model == ContactModel::Rigid {
            return Self { bias_rate: RIGID_PUSH / h, mass_scale: 1.0, give: 0.0 };
        }
        let w = 2.0 * PI * settings.frequency() * factor;
        let a = 2.0 * settings.contact_damping_ratio + h * w;
        let c = h * w * a;
        Self { bias_rate: w / a, mass_scale: c / (1.0 + c), give: 1.0 / c }
    }
}

/// Derives what the solve needs of every active body.
pub(crate) fn prepare_bodies<E: Executor>(
    state: &State<'_>,
    scratch: &mut Scratch<'_>,
    (settings, links): (&Settings, Links),
    crew: &mut Crew<'_, E>,
) {
    let bodies = links.bodies;
    let marks = leapfrog::in_use(scratch.joint_marks, links);
    let share = chunk(bodies, PREPARE_BODIES);
    let mut tasks: Tasks<&mut [Active]> = Tasks::new();
    scratch.active[..bodies].chunks_mut(share).for_each(|active| push(&mut tasks, active));
    let substeps = settings.tiers().map(|tier| tier.substep());
    let gravity = settings.gravity;
    crew.run(Stage::Assembly, &mut tasks, |active| {
        for active in active.iter_mut() {
            let slot = active.body as usize;
            let (row, motion) = (&state.bodies[slot], &state.motions[slot]);
            let substep = substeps[refine::tier_of(state, active.body)];
            let locks = row.locks();
            let principal = principal_rotation(motion, row);
            (active.stiffening, active.linear, active.angular) = (Vec3::ZERO, motion.linear, motion.angular);
            if has_joints(state.first_joints, active.body) {
                active.stiffening = stiffening::stiffening(state, active.body, substep);
                active.angular = stiffening::eased(active, row, (principal, motion.angular));
                let lag = leapfrog::lag(marks, active.body);
                if lag != 0.0 {
                    active.linear += gravity * (row.gravity_scale * lag * substep);
                }
            }
            (active.root, active.whitened) =
                root_and_whitened(principal, active.inertia(row), locks >> 3, active.angular);
            active.inverse_mass = 1.0 / row.mass;
            active.locks = f32::from(locks & 7);
            let push = (gravity * row.gravity_scale + row.force / row.mass) * substep;
            let free = |axis: usize| if locks >> axis & 1 == 1 { 0.0 } else { push[axis] };
            active.push = Vec3::new(free(0), free(1), free(2));
        }
    });
}

/// Writes all rows, movers and seats of a plan.
pub(crate) fn fill<E: Executor>(
    state: &State<'_>,
    (cache, scratch): (&mut Cache<'_>, &mut Scratch<'_>),
    (settings, plan, links): (&Settings, &Plan, Links),
    crew: &mut Crew<'_, E>,
) {
    let scenes = settings.tiers().map(|settings| Scene {
        bodies: state.bodies,
        motions: state.motions,
        shapes: state.shapes,
        materials: state.materials,
        frames: scratch.frames,
        stances: scratch.stances,
        active: scratch.active,
        links: scratch.links,
        contacts: state.contacts,
        memos: &cache.memos[cache.header[0].memo_half as usize * state.contacts.len()..],
        touches: scratch.touches,
        joints: state.joints,
        joint_axes: state.joint_axes,
        first_joints: state.first_joints,
        marks: leapfrog::in_use(scratch.joint_marks, links),
        joint_slots: scratch.joint_slots,
        active_of: scratch.active_of,
        softness: Softnesses::new(&settings),
        bias: solver::bias(&settings),
        substep: settings.substep(),
        dt: settings.dt,
        hits: events::measures_hits(state),
    });
    let (mut links, mut seats) = (&mut scratch.link_rows[..plan.rows], &mut scratch.seats[..plan.seats]);
    let mut points = &mut scratch.point_rows[..plan.points];
    let mut first_points = &mut scratch.row_points[..plan.rows];
    let (mut resists, mut cones) = (&mut *scratch.resist_rows, cones_of(settings, scratch.cone_rows));
    let mut movers = &mut scratch.movers[..plan.moving / LANES];
    let mut joints = JointRows {
        balls: &mut scratch.ball_rows[..plan.balls],
        links: &mut scratch.joint_links[..plan.joints - plan.balls],
        locks: &mut scratch.lock_rows[..plan.locks],
        bounds: &mut scratch.bound_rows[..plan.bounds],
        nodes: &mut scratch.node_rows[..plan.nodes],
        blocks: &mut scratch.block_rows[..plan.matrix_blocks],
    };
    let lanes = Lanes {
        seat_bodies: cache.seat_bodies,
        contacts: cache.lane_contacts,
        contact_seats: cache.lane_seats,
        joints: cache.lane_joints,
        joint_seats: cache.joint_seats,
        patterns: Patterns { rows: cache.articulations, nodes: cache.nodes, blocks: cache.blocks },
    };
    let mut tasks: Tasks<Task<'_>> = Tasks::new();
    for groups in cache.groups[..plan.groups].chunks_mut(chunk(plan.groups, 1)) {
        let rows = sum(groups, |g| g.rows);
        let task = Task {
            links: take(&mut links, rows),
            points: take(&mut points, sum(groups, |g| g.points)),
            first_points: take(&mut first_points, rows),
            resists: take_some(&mut resists, rows as u32),
            cones: take_some(&mut cones, rows as u32),
            seats: take(&mut seats, sum(groups, |g| g.seats)),
            movers: take(&mut movers, sum(groups, |g| if g.phase == 0 { g.seats } else { 0 }) / LANES),
            joints: joints.take_all(groups),
            groups,
        };
        push(&mut tasks, task);
    }
    crew.run(Stage::Assembly, &mut tasks, |task| task.fill(&scenes, &lanes));
}

/// What some groups have in all.
fn sum(groups: &[Group], count: fn(&Group) -> u32) -> usize {
    groups.iter().map(count).sum::<u32>() as usize
}

/// The rows of cones that a step has: none where friction is that of patches.
pub(crate) fn cones_of<'a>(settings: &Settings, rows: &'a mut [ConeRow]) -> &'a mut [ConeRow] {
    match settings.friction_model {
        FrictionModel::Patch => &mut [],
        FrictionModel::Points => rows,
    }
}

/// What lies in which lane, and in which seat.
struct Lanes<'a> {
    seat_bodies: &'a [u32],
    contacts: &'a [[u32; LANES]],
    contact_seats: &'a [[u32; 2 * LANES]],
    joints: &'a [[u32; LANES]],
    joint_seats: &'a [[u32; 2 * LANES]],
    patterns: Patterns<'a>,
}

/// Groups in a row, of one or more phases, and what is theirs.
struct Task<'a> {
    groups: &'a mut [Group],
    links: &'a mut [LinkRow],
    points: &'a mut [PointRow],
    /// First point of each row.
    first_points: &'a mut [u32],
    /// Resistance of each row; none in a world without materials.
    resists: &'a mut [ResistRow],
    /// Cones of each row's points; none where friction is that of patches.
    cones: &'a mut [ConeRow],
    seats: &'a mut [Seat],
    movers: &'a mut [MoverRow],
    joints: JointRows<'a>,
}

impl Task<'_> {
    fn fill(&mut self, scenes: &[Scene<'_>; TIERS], lanes: &Lanes<'_>) {
        let (mut links, mut points) = (&mut *self.links, &mut *self.points);
        let (mut firsts, mut resists) = (&mut *self.first_points, &mut *self.resists);
        let mut cones = &mut *self.cones;
        let (mut seats, mut movers) = (&mut *self.seats, &mut *self.movers);
        for group in self.groups.iter_mut() {
            let scene = &scenes[group.tier as usize];
            let own_seats = take(&mut seats, group.seats as usize);
            let bodies = &lanes.seat_bodies[group.first_seat as usize..][..own_seats.len()];
            let own_movers = take(&mut movers, if group.phase == 0 { own_seats.len() / LANES } else { 0 });
            fill_seats(scene, (own_seats, own_movers), bodies);
            group.leaps = 0;
            let mut joints = self.joints.take(group);
            let mut left = joints.reborrow();
            let first = group.first_joint as usize;
            let (balls, end) = (first + group.balls as usize, first + group.joints as usize);
            for (row, ball) in (first..balls).zip(&mut *left.balls) {
                balls::fill(scene, ball, (&lanes.joints[row], &lanes.joint_seats[row]));
                group.leaps |= ball.leaps;
            }
            for row in balls..end {
                let lanes = (&lanes.joints[row], &lanes.joint_seats[row], group.articulations);
                group.leaps |= joints::fill(scene, &mut left, lanes);
            }
            lanes.patterns.of(group).each(joints, |articulation| articulation.factor());
            let mut own_points = take(&mut points, group.points as usize);
            group.bounces = 0;
            let first = group.first_row as usize;
            let rows = take(&mut links, group.rows as usize).iter_mut();
            let own_resists = take_some(&mut resists, group.rows);
            let own_cones = take_some(&mut cones, group.rows);
            let mut next_point = group.first_point;
            for (i, (row, first_point)) in rows.zip(take(&mut firsts, group.rows as usize)).enumerate() {
                let lanes = (&lanes.contacts[first + i], &lanes.contact_seats[first + i]);
                let parts = (&mut *row, own_resists.get_mut(i), own_cones.get_mut(i));
                rows::fill(scene, parts, lanes, &mut own_points);
                *first_point = next_point;
                next_point += row.points;
                group.bounces |= row.bounces;
            }
        }
    }
}

/// Seats hold zeros until they pull; those of phase 0 start with the bodies' velocities.
fn fill_seats(scene: &Scene<'_>, (seats, movers): (&mut [Seat], &mut [MoverRow]), bodies: &[u32]) {
    if movers.is_empty() {
        seats.fill(Seat::zeroed());
        return;
    }
    let (eights, _) = seats.as_chunks_mut::<LANES>();
    for ((mover, seats), bodies) in movers.iter_mut().zip(eights).zip(bodies.chunks(LANES)) {
        // A seat without a body has no index of one.
        let entry = |lane: usize| {
            let active = scene.active.get(*bodies.get(lane)? as usize)?;
            let slot = active.body as usize;
            Some((active, &scene.motions[slot], &scene.bodies[slot]))
        };
        let is_jointed = |slot: u32| has_joints(scene.first_joints, slot);
        mover.enter(seats, entry, (scene.substep, is_jointed));
        if !scene.marks.is_empty() {
            let bits = |of: fn(&[u32], u32) -> bool| {
                let is = |lane| entry(lane).is_some_and(|(active, ..)| of(scene.marks, active.body));
                (0..LANES).fold(0, |bits, lane| bits | u32::from(is(lane)) << lane)
            };
            (mover.leaps, mover.alone) = (bits(leapfrog::leaps), bits(leapfrog::leaps_alone));
        }
    }
}
