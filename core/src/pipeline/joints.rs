//! Joints: their rows from the state, and their impulses back into it.

use crate::body::{BodyKind, turned_frame};
use crate::cells::{IMMOVABLE, UNORDERED};
use crate::config::Settings;
use crate::constraint::joint::{
    BallRow, Bound, BoundRow, FAR, JointLink, LIMIT_PUSH, LOCK_PUSH, LockRow, bounds_of, locks_of, place,
    weigh, wrench,
};
use crate::executor::{Executor, Stage};
use crate::joint::axis::{TURN_X, TURN_Z};
use crate::joint::{AxisRow, BROKEN, COLLIDES, JointRow, Signature};
use crate::lanes::{LANES, LaneVec};
use crate::math::{PI, Pose, Rotation, Vec3, length, min};
use crate::pipeline::assembly::Scene;
use crate::pipeline::integration::{along_axes, split_frame, square_roots};
use crate::pipeline::layout::{EMPTY, Group, Plan, TIERS};
use crate::pipeline::mover;
use crate::pipeline::ordering::Links;
use crate::pipeline::solver::{JointRows, take};
use crate::pipeline::tasks::{Crew, Tasks, chunk, push};
use crate::pipeline::{Counts, balls, events, leapfrog};
use crate::pool::is_used;
use crate::shape::BOX_STALE;
use crate::state::{Cache, Scratch, State, mark_shapes, principal_rotation};

/// Joints that are worth a task.
const STORE_JOINTS: usize = 256;
/// How fast a limit that gives is felt before it is reached, 1/s: not at all.
const NOT_BEFORE: f32 = 1.0e9;

/// A joint in the state.
struct View<'a> {
    row: &'a JointRow,
    axes: &'a [AxisRow; 6],
}

impl core::ops::Deref for View<'_> {
    type Target = JointRow;

    fn deref(&self) -> &JointRow {
        self.row
    }
}

/// Writes one row of joints and cuts it off `rows`; `at_once` is not 0 for one of articulations. Returns the bits
/// of the lanes that leap.
pub(crate) fn fill(
    scene: &Scene<'_>,
    rows: &mut JointRows<'_>,
    (joints, seats, at_once): (&[u32; LANES], &[u32; 2 * LANES], u32),
) -> u32 {
    let row_of = |joint: u32| {
        let slot = scene.joint_slots[joint as usize] as usize;
        View { row: &scene.joints[slot], axes: &scene.joint_axes[slot] }
    };
    let Some(&first) = joints.iter().find(|&&joint| joint != EMPTY) else { return 0 };
    let signature = row_of(first).signature();
    let link = &mut take(&mut rows.links, 1)[0];
    let locks = take(&mut rows.locks, signature.lock_rows());
    let bounds = take(&mut rows.bounds, signature.bound_rows());
    // As bytes: a row of zeros would be made elsewhere and copied.
    bytemuck::bytes_of_mut(link).fill(0);
    bytemuck::cast_slice_mut::<_, u8>(locks).fill(0);
    bytemuck::cast_slice_mut::<_, u8>(bounds).fill(0);
    (link.signature, link.at_once) = (signature.0, at_once);
    link.seats_a.copy_from_slice(&seats[..LANES]);
    link.seats_b.copy_from_slice(&seats[LANES..]);
    let mut masses = LaneVec::ZERO;
    for (lane, &joint) in joints.iter().enumerate() {
        if joint != EMPTY {
            masses.set(lane, set_bodies(scene, link, &row_of(joint), lane));
        }
    }
    place(link, locks, bounds);
    if !bounds.is_empty() {
        weigh(link, locks, bounds, masses);
    }
    for (lane, &joint) in joints.iter().enumerate() {
        if joint != EMPTY {
            let joint = &row_of(joint);
            let measure = Measure::of(link, joint, lane);
            set_locks(scene, joint, (signature, &measure), (locks, lane, masses));
            set_bounds(scene, joint, (signature, &measure), (bounds, lane));
        }
    }
    // What the rows give is known now.
    weigh(link, locks, bounds, masses);
    link.leaps
}

/// Writes what one joint's bodies are; returns their inverse masses along the axes, added.
fn set_bodies(scene: &Scene<'_>, link: &mut JointLink, joint: &View<'_>, lane: usize) -> Vec3 {
    let active = joint.bodies.map(|slot| scene.active_of[slot as usize]);
    if active[0] == IMMOVABLE {
        // Links have the dynamic body first.
        let seats = (link.seats_a[lane], link.seats_b[lane]);
        (link.seats_b[lane], link.seats_a[lane]) = seats;
    }
    let mut masses = Vec3::ZERO;
    for (end, (&index, &slot)) in active.iter().zip(&joint.bodies).enumerate() {
        let slot = slot as usize;
        if index == IMMOVABLE {
            let motion = &scene.motions[slot];
            let moves = motion.linear != Vec3::ZERO || motion.angular != Vec3::ZERO;
            if scene.bodies[slot].kind() == BodyKind::Kinematic && moves {
                link.kinematic = 1;
                link.moves[2 * end].set(lane, motion.linear);
                link.moves[2 * end + 1].set(lane, motion.angular);
            }
            continue;
        }
        let body = &scene.active[index as usize];
        let locks = body.locks as u32;
        link.locked |= u32::from(locks != 0);
        link.leaps |= u32::from(leapfrog::leaps(scene.marks, slot as u32)) << lane;
        let free = |axis: u32| if locks >> axis & 1 == 1 { 0.0 } else { body.inverse_mass };
        let inverse = Vec3::new(free(0), free(1), free(2));
        masses += inverse;
        let scale = if end == 0 { &mut link.scale_a } else { &mut link.scale_b };
        scale.set(lane, Vec3::new(libm::sqrtf(inverse.x), libm::sqrtf(inverse.y), libm::sqrtf(inverse.z)));
        let root = if end == 0 { &mut link.root_a } else { &mut link.root_b };
        set_root(root, &body.root, lane);
        let row = &scene.bodies[slot];
        if mover::is_top(row) {
            let (now, back, top, far) = if end == 0 {
                (&mut link.now_a, &mut link.back_a, &mut link.top_a, &mut link.far_a)
            } else {
                (&mut link.now_b, &mut link.back_b, &mut link.top_b, &mut link.far_b)
            };
            let principal = principal_rotation(&scene.motions[slot], row);
            far.set(lane, principal.after(split_frame(body.inertia(row)).0).rotate(Vec3::Z));
            set_root(now, &body.root, lane);
            set_root(back, &along_axes(&principal.matrix(), square_roots(body.inertia(row))), lane);
            top.set(lane, 1.0);
            link.tops = 1;
        }
    }
    set_frames(scene, link, joint, lane);
    masses
}

fn set_root(to: &mut [LaneVec; 2], &[xx, yy, zz, xy, xz, yz]: &[f32; 6], lane: usize) {
    to[0].set(lane, Vec3::new(xx, yy, zz));
    to[1].set(lane, Vec3::new(xy, xz, yz));
}

/// Writes arms and axes. Held axes are held at 0 of these frames.
fn set_frames(scene: &Scene<'_>, link: &mut JointLink, joint: &View<'_>, lane: usize) {
    let [a, b] = joint.bodies.map(|slot| slot as usize);
    let (ma, mb) = (&scene.motions[a], &scene.motions[b]);
    let signature = link.signature();
    let held = |axis: usize| signature.held() >> axis & 1 != 0;
    let place = |axis: usize| if held(axis) { joint.axes[axis].lower } else { 0.0 };
    let [mut local_a, mut local_b] = joint.frames;
    if !signature.is_distance() {
        local_a.position = local_a.transform(Vec3::new(place(0), place(1), place(2)));
        let turned = |q: Rotation, axis: Vec3, angle: f32| {
            if angle == 0.0 { q } else { q.after(Rotation::from_axis_angle(axis, angle)) }
        };
        local_a.rotation = turned(local_a.rotation, Vec3::Z, place(TURN_Z));
        local_b.rotation = turned(local_b.rotation, Vec3::X, -place(TURN_X));
    }
    let frame = |motion: &crate::body::Motion, slot: usize, local: &Pose| {
        turned_frame(motion.rotation, &scene.bodies[slot], local)
    };
    let (frame_a, frame_b) = (frame(ma, a, &local_a), frame(mb, b, &local_b));
    link.arm_a.set(lane, frame_a.position);
    link.arm_b.set(lane, frame_b.position);
    link.centers.set(lane, mb.center.minus(ma.center));
    let (axes_a, axes_b) = (frame_a.rotation.matrix(), frame_b.rotation.matrix());
    for (axis, column) in link.axes_a.iter_mut().zip([axes_a.x_axis, axes_a.y_axis, axes_a.z_axis]) {
        axis.set(lane, column);
    }
    for (axis, column) in link.axes_b.iter_mut().zip([axes_b.x_axis, axes_b.y_axis]) {
        axis.set(lane, column);
    }
    link.ratio.set(lane, joint.ratio);
}

/// The coordinates of a joint that are measured: distances along axes, and turns counted on.
struct Measure {
    shifts: [f32; 3],
    turns: [f32; 3],
    cone: f32,
}

impl Measure {
    /// All 0 for a joint of which no row reads them.
    fn of(link: &JointLink, joint: &View<'_>, lane: usize) -> Self {
        let signature = link.signature();
        if signature.bound_rows() == 0 && !signature.is_distance() {
            return Self { shifts: [0.0; 3], turns: [0.0; 3], cone: 0.0 };
        }
        let gap = link.gap().get(lane);
        let axes = link.axes_a.map(|axis| axis.get(lane));
        let shifts =
            if signature.is_distance() { [length(gap), 0.0, 0.0] } else { axes.map(|axis| gap.dot(axis)) };
        let mut measure = Self { shifts, turns: [0.0; 3], cone: 0.0 };
        if signature.turns() {
            let [xa, ya, za] = axes;
            let [xb, yb] = link.axes_b.map(|axis| axis.get(lane));
            measure.turns = turns_of((xa, ya, za), (xb, yb), signature.is_twist());
            measure.cone = crate::math::atan2(length(xa.cross(xb)), xa.dot(xb));
            for (turn, axis) in measure.turns.iter_mut().zip(&joint.axes[3..]) {
                *turn = counted_on(*turn, axis.turn);
            }
        }
        measure
    }

    fn along(&self, axis: usize) -> f32 {
        if axis < 3 { self.shifts[axis] } else { self.turns[axis - 3] }
    }
}

/// The turns about x, y and z of a frame with axes x and y against one with axes x, y and z; radians.
pub(crate) fn turns_of((xa, ya, za): (Vec3, Vec3, Vec3), (xb, yb): (Vec3, Vec3), is_twist: bool) -> [f32; 3] {
    use crate::math::atan2;
    if is_twist {
        let share = 1.0 / crate::math::max(1.0 + xa.dot(xb), 1.0e-6);
        let across = xa.dot(yb) * share;
        return [atan2(yb.dot(za) - xb.dot(za) * across, yb.dot(ya) - xb.dot(ya) * across), 0.0, 0.0];
    }
    let middle = za.cross(xb);
    let cosine = length(middle);
    let unit = crate::math::normalize_or(middle, ya);
    [atan2(yb.dot(xb.cross(unit)), yb.dot(unit)), atan2(-xb.dot(za), cosine), atan2(xb.dot(ya), xb.dot(xa))]
}

/// The value of an angle that is nearest to the last one.
fn counted_on(angle: f32, last: f32) -> f32 {
    angle + 2.0 * PI * libm::rintf((last - angle) / (2.0 * PI))
}

fn set_locks(
    scene: &Scene<'_>,
    joint: &View<'_>,
    (signature, measure): (Signature, &Measure),
    (locks, lane, masses): (&mut [LockRow], usize, LaneVec),
) {
    let coupled = signature.is_gear() || signature.is_rack();
    let axes = locks_of(signature).chain(coupled.then_some(0));
    let is_fresh = joint.bodies.iter().any(|&slot| leapfrog::leaps_alone(scene.marks, slot));
    for (row, axis) in locks.iter_mut().zip(axes) {
        row.impulse.set(lane, if is_fresh { 0.0 } else { joint.impulses[axis] });
        if signature.is_distance() {
            row.error.set(lane, measure.shifts[0] - joint.axes[0].lower);
        } else if coupled {
            row.error.set(lane, joint.slip);
        }
        let gives = joint.spring.gives();
        let yields = if gives { row.ways.yields(&row.ways, masses).get(lane) } else { 0.0 };
        let softener = joint.spring.softener(yields, scene.substep);
        let (rate, give) = softener.map_or((LOCK_PUSH / scene.substep, 0.0), |s| (s.rate, s.give));
        row.rate.set(lane, rate);
        row.give.set(lane, min(give, FAR));
    }
}

fn set_bounds(
    scene: &Scene<'_>,
    joint: &View<'_>,
    (signature, measure): (Signature, &Measure),
    (bounds, lane): (&mut [BoundRow], usize),
) {
    for (row, bound) in bounds.iter_mut().zip(bounds_of(signature)) {
        let mut sight = Sight { row, lane, substep: scene.substep, push: scene.bias.push_speed };
        match bound {
            Bound::Drive(axis) => sight.drive(&joint.axes[axis], measure.along(axis)),
            Bound::Friction(axis) => sight.friction(&joint.axes[axis]),
            Bound::Limit(axis) => sight.limit(&joint.axes[axis], measure.along(axis)),
            Bound::Cone => sight.cone(joint, measure.cone),
        }
    }
}

/// One lane of a bound row.
struct Sight<'a> {
    row: &'a mut BoundRow,
    lane: usize,
    substep: f32,
    push: f32,
}

impl Sight<'_> {
    fn drive(&mut self, axis: &AxisRow, coordinate: f32) {
        let (row, lane) = (&mut *self.row, self.lane);
        row.impulse.set(lane, axis.drive_impulse);
        row.most.set(lane, min(axis.max_force * self.substep, FAR));
        row.keeps.set(lane, 1.0);
        row.push.set(lane, FAR);
        let Some(softener) = axis.drive_spring.softener(row.yields.get(lane), self.substep) else {
            row.target.set(lane, axis.velocity);
            return;
        };
        let left = coordinate - axis.target;
        row.low.set(lane, left);
        row.high.set(lane, left);
        row.near.set(lane, softener.rate);
        row.beyond.set(lane, softener.rate);
        row.target.set(lane, softener.damping * axis.velocity);
        row.give.set(lane, min(softener.give, FAR));
    }

    fn friction(&mut self, axis: &AxisRow) {
        let (row, lane) = (&mut *self.row, self.lane);
        row.impulse.set(lane, axis.friction_impulse);
        row.most.set(lane, axis.friction * self.substep);
        row.keeps.set(lane, 1.0);
    }

    fn limit(&mut self, axis: &AxisRow, coordinate: f32) {
        let low = if axis.lower.is_finite() { coordinate - axis.lower } else { FAR };
        let high = if axis.upper.is_finite() { coordinate - axis.upper } else { -FAR };
        let (yields, substep) = (self.row.yields.get(self.lane), self.substep);
        self.ends(low, high, axis.limit_impulse);
        if let Some(softener) = axis.limit_spring.softener(yields, substep) {
            let (row, lane) = (&mut *self.row, self.lane);
            row.near.set(lane, NOT_BEFORE);
            row.beyond.set(lane, softener.rate);
            row.give.set(lane, min(softener.give, FAR));
            row.push.set(lane, FAR);
            row.keeps.set(lane, 1.0);
        }
    }

    fn cone(&mut self, joint: &View<'_>, angle: f32) {
        self.ends(FAR, angle - joint.cone, joint.cone_impulse);
    }

    /// A hard limit.
    fn ends(&mut self, low: f32, high: f32, impulse: f32) {
        let (row, lane) = (&mut *self.row, self.lane);
        row.impulse.set(lane, impulse);
        row.most.set(lane, FAR);
        row.low.set(lane, low);
        row.high.set(lane, high);
        row.near.set(lane, 1.0 / self.substep);
        row.beyond.set(lane, LIMIT_PUSH / self.substep);
        row.push.set(lane, self.push);
        row.limits = 1;
    }
}

/// Writes impulses, forces and turns back into the state, and breaks joints whose load is too great.
pub(crate) fn store<E: Executor>(
    state: &mut State<'_>,
    (cache, scratch): (&Cache<'_>, &mut Scratch<'_>),
    (plan, links, settings): (&Plan, Links, &Settings),
    (crew, counts): (&mut Crew<'_, E>, &mut Counts),
) {
    struct Task<'a> {
        /// Ascending.
        slots: &'a [u32],
        /// Places of the same joints.
        order: &'a [u32],
        /// Slot of the first of the rows.
        first: u32,
        rows: &'a mut [JointRow],
        axes: &'a mut [[AxisRow; 6]],
        broken: u32,
    }
    let joints = links.held();
    if joints == 0 {
        return;
    }
    let rates = settings.tiers().map(|tier| 1.0 / tier.substep());
    index_rows(&cache.groups[..plan.groups], scratch.joint_links, scratch.joint_firsts);
    if plan.joints > plan.balls {
        measure_wrenches(scratch, (&cache.groups[..plan.groups], plan), rates, crew);
    }
    let share = chunk(joints, STORE_JOINTS);
    let mut tasks: Tasks<Task<'_>> = Tasks::new();
    let (mut rest, mut rest_axes, mut first) = (&mut *state.joints, &mut *state.joint_axes, 0);
    let slots = scratch.held_slots[..joints].chunks(share);
    for (slots, order) in slots.zip(cache.joint_order[..joints].chunks(share)) {
        let end = slots[slots.len() - 1] + 1;
        let rows = take(&mut rest, (end - first) as usize);
        let axes = take(&mut rest_axes, rows.len());
        push(&mut tasks, Task { slots, order, first, rows, axes, broken: 0 });
        first = end;
    }
    let results = Results {
        balls: scratch.ball_rows,
        links: scratch.joint_links,
        locks: scratch.lock_rows,
        bounds: scratch.bound_rows,
        firsts: scratch.joint_firsts,
    };
    let (has_tiers, refined) = (state.header[0].refine != 0, &*state.refined);
    crew.run(Stage::Finish, &mut tasks, |task| {
        for (&slot, &place) in task.slots.iter().zip(task.order) {
            let i = (slot - task.first) as usize;
            let joint = &mut task.rows[i];
            let end = scratch.slot_links[links.contacts + place as usize].a;
            let rate = rates[usize::from(has_tiers && is_used(refined, end))];
            results.store((joint, &mut task.axes[i]), cache.joint_places[place as usize] as usize, rate);
            task.broken += u32::from(joint.has(BROKEN));
        }
    });
    let broken: u32 = tasks.iter().map(|task| task.broken).sum();
    drop(tasks);
    counts.broken += broken;
    if broken > 0 {
        part_broken(state, &scratch.held_slots[..joints], counts);
    }
}

/// Writes force and torque of each row where the changes of its warm start were.
fn measure_wrenches<E: Executor>(
    scratch: &mut Scratch<'_>,
    (groups, plan): (&[Group], &Plan),
    rates: [f32; TIERS],
    crew: &mut Crew<'_, E>,
) {
    struct Task<'a> {
        groups: &'a [Group],
        rows: JointRows<'a>,
    }
    let mut rows = JointRows {
        balls: &mut scratch.ball_rows[..plan.balls],
        links: &mut scratch.joint_links[..plan.joints - plan.balls],
        locks: &mut scratch.lock_rows[..plan.locks],
        bounds: &mut scratch.bound_rows[..plan.bounds],
        nodes: &mut scratch.node_rows[..plan.nodes],
        blocks: &mut scratch.block_rows[..plan.matrix_blocks],
    };
    let mut tasks: Tasks<Task<'_>> = Tasks::new();
    for groups in groups.chunks(chunk(groups.len(), 1)) {
        push(&mut tasks, Task { groups, rows: rows.take_all(groups) });
    }
    crew.run(Stage::Finish, &mut tasks, |task| {
        for group in task.groups {
            let rows = task.rows.take(group);
            let (mut locks, mut bounds) = (&*rows.locks, &*rows.bounds);
            for link in rows.links {
                let signature = link.signature();
                let (own_locks, rest) = locks.split_at(signature.lock_rows());
                locks = rest;
                let (own_bounds, rest) = bounds.split_at(signature.bound_rows());
                bounds = rest;
                let rate = rates[group.tier as usize];
                (link.turn_push, link.turn_a) = wrench(link, (own_locks, own_bounds), rate);
            }
        }
    });
}

/// Shapes of bodies whose joint broke may meet from now on.
fn part_broken(state: &mut State<'_>, slots: &[u32], counts: &mut Counts) {
    for &slot in slots {
        events::broke(state, counts, slot);
        let joint = &state.joints[slot as usize];
        if joint.has(BROKEN) {
            for body in joint.bodies {
                mark_shapes(state, body as usize, BOX_STALE);
            }
        }
    }
}

/// True when a joint keeps the shapes of two bodies from meeting. Walks both lists at once, so that a hub costs
/// no more than the other body.
pub(crate) fn are_joined(state: &State<'_>, a: u32, b: u32) -> bool {
    let first = |body: u32| state.first_joints.get(body as usize).copied().unwrap_or(0);
    let (mut of_a, mut of_b) = (first(a), first(b));
    let joins = |row: &JointRow| {
        let ends = [row.bodies[0].min(row.bodies[1]), row.bodies[0].max(row.bodies[1])];
        ends == [a.min(b), a.max(b)] && !row.has(COLLIDES | BROKEN)
    };
    while of_a != 0 && of_b != 0 {
        let (row_a, row_b) = (&state.joints[of_a as usize - 1], &state.joints[of_b as usize - 1]);
        if joins(row_a) || joins(row_b) {
            return true;
        }
        (of_a, of_b) = (row_a.next_of(a), row_b.next_of(b));
    }
    false
}

/// Joints of a body whose kind has changed have other ends in the ordering: they are new links.
pub(crate) fn begin_anew(state: &mut State<'_>, body: u32) {
    let mut next = state.first_joints.get(body as usize).copied().unwrap_or(0);
    while next != 0 {
        let joint = &mut state.joints[next as usize - 1];
        joint.phase = u32::from(UNORDERED);
        next = joint.next_of(body);
        state.header[0].joints_stale = 1;
    }
}

/// Writes where each row of joints is, and its first lock and bound.
fn index_rows(groups: &[Group], links: &[JointLink], firsts: &mut [[u32; 3]]) {
    let (mut ball, mut next) = (0, [0; 3]);
    for group in groups {
        let first = group.first_joint as usize;
        let (balls, end) = (first + group.balls as usize, first + group.joints as usize);
        for own in &mut firsts[first..balls] {
            *own = [ball, EMPTY, EMPTY];
            ball += 1;
        }
        for own in &mut firsts[balls..end] {
            *own = next;
            let signature = links[next[0] as usize].signature();
            next[0] += 1;
            next[1] += signature.lock_rows() as u32;
            next[2] += signature.bound_rows() as u32;
        }
    }
}

/// What the solve left of the joints.
struct Results<'a> {
    balls: &'a [BallRow],
    links: &'a [JointLink],
    locks: &'a [LockRow],
    bounds: &'a [BoundRow],
    firsts: &'a [[u32; 3]],
}

impl Results<'_> {
    /// `rate`: substeps in a second.
    fn store(&self, (joint, axes): (&mut JointRow, &mut [AxisRow; 6]), place: usize, rate: f32) {
        let (row, lane) = (self.firsts[place / LANES], place % LANES);
        if row[1] == EMPTY {
            balls::store(&self.balls[row[0] as usize], lane, (joint, rate));
        } else {
            let has_bounds = self.store_link((joint, axes), row, lane);
            // Without bounds the axes are what they were.
            if !(joint.is_finite() && (!has_bounds || axes.iter().all(AxisRow::is_finite))) {
                joint.forget();
                axes.iter_mut().for_each(AxisRow::forget);
                axes.iter_mut().for_each(|axis| axis.turn = 0.0);
                joint.slip = 0.0;
            }
        }
        if length(joint.force) > joint.break_force || length(joint.torque) > joint.break_torque {
            joint.flags |= BROKEN;
        }
    }

    /// Returns whether the joint has bounds.
    fn store_link(
        &self,
        (joint, axes): (&mut JointRow, &mut [AxisRow; 6]),
        row: [u32; 3],
        lane: usize,
    ) -> bool {
        let [link, locks, bounds] = row.map(|first| first as usize);
        let link = &self.links[link];
        let signature = link.signature();
        let locks = &self.locks[locks..locks + signature.lock_rows()];
        let bounds = &self.bounds[bounds..bounds + signature.bound_rows()];
        let coupled = signature.is_gear() || signature.is_rack();
        for (row, axis) in locks.iter().zip(locks_of(signature).chain(coupled.then_some(0))) {
            joint.impulses[axis] = row.impulse.get(lane);
            if coupled {
                joint.slip = row.error.get(lane);
            }
        }
        for (row, bound) in bounds.iter().zip(bounds_of(signature)) {
            let impulse = row.impulse.get(lane);
            match bound {
                Bound::Drive(axis) => {
                    let own = &mut axes[axis];
                    own.drive_impulse = impulse;
                    if axis >= 3 && own.has_position_drive() {
                        own.turn = row.low.get(lane) + own.target;
                    }
                }
                Bound::Friction(axis) => axes[axis].friction_impulse = impulse,
                Bound::Limit(axis) => {
                    let own = &mut axes[axis];
                    own.limit_impulse = impulse;
                    if axis >= 3 {
                        let from_low = own.lower.is_finite();
                        own.turn = if from_low {
                            row.low.get(lane) + own.lower
                        } else {
                            row.high.get(lane) + own.upper
                        };
                    }
                }
                Bound::Cone => joint.cone_impulse = impulse,
            }
        }
        (joint.force, joint.torque) = (link.turn_push.get(lane), link.turn_a.get(lane));
        !bounds.is_empty()
    }
}
