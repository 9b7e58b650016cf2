//! Continuous collision: fast bodies do not pass through what contacts may miss.
//!
//! Contacts are found where a body is at the start of a step and hold along their normals, so they stop a body
//! that comes straight at a surface. They miss what it meets after it has turned, bounced or been pushed aside.
//! So at the end of the step each body that moved by more than a share of its thickness is taken along its way
//! again (`collide/cast/impact.rs`), from the pose at the start to that at the end: its center straight ahead,
//! its axes at a constant rate. At the first surface that it would have passed its motion ends, a hair in
//! front, and the rest of the step's time is lost to it. Velocities stay: in the next step there is a contact,
//! which has the impact.
//!
//! - Against static and kinematic bodies always, the latter on their own way; against dynamic ones for bodies with
//!   [`BULLET`], at the poses that the solve left them in, so that the order of bodies does not matter. Of those
//!   only bodies that are still in their fat boxes are found.
//! - Nothing is solved again, so the cost is bounded: one search of the trees for each shape of a fast body.
//! - A body that is stopped is torn off its joints for that step, and they pull it back in the next. So a body with
//!   joints is stopped only where the middle of a shape would pass, and contacts are left the rest.
//! - Where no body is fast nothing runs: a body that moves less than [`WAY_FLOOR`] and turns less than
//!   [`TURN_FLOOR`] is not looked at.

use crate::body::{ASLEEP, BULLET, BodyKind, BodyRow, CHANGED_SECTOR, Motion, Position};
use crate::collide::Solid;
use crate::collide::cast::children::Parts;
use crate::collide::cast::frame::{Frame, length, narrowed, widened};
use crate::collide::cast::impact::{Course, Rider, Turn, impact};
use crate::collide::cast::support;
use crate::collide::tree::Tree;
use crate::collide::tree::search::Way;
use crate::config::Settings;
use crate::executor::{Executor, Stage};
use crate::math::{Pose, Rotation, Vec3, max_each, min, sqrt};
use crate::pipeline::broadphase::{may_meet, refresh_trees, tree_of};
use crate::pipeline::finish::follow_stance;
use crate::pipeline::integration::split_frame;
use crate::pipeline::rules::stand_in_the_way;
use crate::pipeline::tasks::{Crew, Tasks, chunk, push};
use crate::pipeline::{Counts, solid};
use crate::shape::{
    GEOMETRY_BOX, GEOMETRY_CAPSULE, GEOMETRY_COMPOUND, GEOMETRY_HULL, GEOMETRY_ROUNDED_HULL, GEOMETRY_SPHERE,
    ShapeRow,
};
use crate::state::{AssetTables, Cache, Scratch, State};
use glam::DVec3;

/// A body is fast when some point of a shape moves by more than this share of the shape's inner radius in a step.
pub(crate) const FAST_SHARE: f32 = 0.5;
/// Way in a step below which no body is fast, metres: far less than contacts look ahead.
pub(crate) const WAY_FLOOR: f32 = 0.002;
/// Turn in a step below which none is, radians.
const TURN_FLOOR: f32 = 0.02;
/// Fast bodies that are worth a task.
const FAST_BODIES: usize = 8;
/// Stands for a body that is not stopped.
const NEVER: f64 = 2.0;
/// Turn in a step from which on a body's way follows from its velocity and not from its last orientation, radians.
const TURN_MAX: f64 = 0.5;

/// What tells whether a body is fast.
pub(crate) struct Race<'a> {
    pub shapes: &'a [ShapeRow],
    pub assets: &'a AssetTables<'a>,
    pub settings: &'a Settings,
}

impl Race<'_> {
    /// True when some point of a body's shape moved by more than a share of the shape's thickness. `way` is the
    /// motion of its center, metres.
    #[inline(always)]
    pub fn is_fast(&self, way: Vec3, (motion, row): (&Motion, &BodyRow)) -> bool {
        let turn = motion.angular * self.settings.dt;
        let (way, turn) = (way.dot(way), turn.dot(turn));
        // Most bodies are not, whatever their shapes are.
        (way > WAY_FLOOR * WAY_FLOOR || turn > TURN_FLOOR * TURN_FLOOR)
            && self.settings.continuous
            && row.is_dynamic()
            && self.outruns((sqrt(way), crate::math::length(motion.angular) * self.settings.dt), row)
    }

    /// The same of a body that moved by a way, metres, and turned, radians.
    #[inline(always)]
    fn outruns(&self, (way, turn): (f32, f32), row: &BodyRow) -> bool {
        let mut next = row.first_shape;
        while let Some(shape) = self.shapes.get(next as usize) {
            let (inner, outer) = if shape.kind == GEOMETRY_SPHERE {
                (shape.size[0], shape.size[0])
            } else {
                (inner_radius(shape, self.assets), outer_radius(shape, self.assets))
            };
            let arm = crate::math::length(shape.pose.position - row.local_center);
            if way + turn * (arm + outer) > FAST_SHARE * inner {
                return true;
            }
            next = shape.next;
        }
        false
    }
}

/// The radius of a ball inside a shape, metres: of a compound the least of its children; 0 without an inside.
pub(crate) fn inner_radius(shape: &ShapeRow, assets: &AssetTables<'_>) -> f32 {
    let [x, y, z] = shape.size;
    match shape.kind {
        GEOMETRY_SPHERE | GEOMETRY_CAPSULE => x,
        GEOMETRY_BOX => min(x, min(y, z)),
        GEOMETRY_HULL => assets.hull_radii[shape.asset() as usize],
        GEOMETRY_ROUNDED_HULL => assets.hull_radii[shape.asset() as usize] + y,
        GEOMETRY_COMPOUND => assets.compound_radii[shape.asset() as usize],
        _ => support::inner_radius(&solid(shape, assets)),
    }
}

/// The radius of a ball around a shape about the origin of its frame, metres.
fn outer_radius(shape: &ShapeRow, assets: &AssetTables<'_>) -> f32 {
    let [x, y, _] = shape.size;
    match shape.kind {
        GEOMETRY_SPHERE => x,
        GEOMETRY_CAPSULE => x + y,
        GEOMETRY_HULL => sqrt(assets.hulls[shape.asset() as usize].radius_squared),
        GEOMETRY_ROUNDED_HULL => sqrt(assets.hulls[shape.asset() as usize].radius_squared) + y,
        _ => {
            let bounds = crate::collide::bounds::aabb(&solid(shape, assets), &Pose::IDENTITY);
            crate::math::length(max_each(bounds.min.abs(), bounds.max.abs()))
        }
    }
}

/// Stops the bodies that are listed as fast at what they would have passed.
pub(crate) fn run<E: Executor>(
    state: &mut State<'_>,
    (assets, cache, scratch): (&AssetTables<'_>, &mut Cache<'_>, &mut Scratch<'_>),
    dt: f32,
    (crew, counts): (&mut Crew<'_, E>, &mut Counts),
) {
    struct Task<'a> {
        bodies: &'a [u32],
        stops: &'a mut [f64],
    }
    let count = counts.fast as usize;
    let origins = &*scratch.origins;
    // Fat boxes are in the sectors of before.
    let sector_of = |body: u32| {
        let changed = state.bodies[body as usize].has(CHANGED_SECTOR);
        let motions = if changed { origins } else { &*state.motions };
        motions[body as usize].center.sector
    };
    refresh_trees((state, sector_of), cache, (scratch.tree_boxes, scratch.tree_keys));
    let header = &cache.header[0];
    let chase = Chase {
        state,
        assets,
        origins,
        trees: [
            tree_of(cache.static_nodes, cache.static_order, header.static_leaves),
            tree_of(cache.moving_nodes, cache.moving_order, header.moving_leaves),
        ],
        sector: header.sector,
        dt,
    };
    let share = chunk(count, FAST_BODIES);
    let mut tasks: Tasks<Task<'_>> = Tasks::new();
    for (bodies, stops) in scratch.fast[..count].chunks(share).zip(scratch.stops[..count].chunks_mut(share)) {
        push(&mut tasks, Task { bodies, stops });
    }
    crew.run(Stage::Finish, &mut tasks, |task| {
        for (&body, stop) in task.bodies.iter().zip(task.stops.iter_mut()) {
            *stop = chase.first_stop(body);
        }
    });
    drop(tasks);
    for (&body, &stop) in scratch.fast[..count].iter().zip(&scratch.stops[..count]) {
        if stop <= 1.0 {
            let slot = body as usize;
            cut(&scratch.origins[slot], (&mut state.motions[slot], &mut state.bodies[slot]), (stop, dt));
            counts.cut += 1;
        }
    }
}

/// Ends a body's motion at a fraction of the step. Velocities stay, the angular one in the view of the body's odd
/// axis: so the energy does, where a spin about the long axis of a rod that has turned would be one across it.
fn cut(origin: &Motion, (motion, row): (&mut Motion, &mut BodyRow), (stop, dt): (f64, f32)) {
    let course = course(origin.center, (origin, motion, row), dt);
    motion.center = origin.center.plus_wide(course.way * stop);
    let turn =
        |turn: Turn, share: f64| Rotation::from_rotation_vector(narrowed(turn.axis * (turn.angle * share)));
    let start = turn(course.twist, stop).after(origin.rotation);
    let rotation = turn(course.swing, stop).after(start).normalized();
    if let Some((axis, _)) = odd_axis(row) {
        let (before, after) =
            (Quaternion::of(motion.rotation).rotate(axis), Quaternion::of(rotation).rotate(axis));
        motion.angular =
            narrowed(Quaternion::about(swing_between(before, after)).rotate(widened(motion.angular)));
    }
    motion.rotation = rotation;
    row.flags &= !CHANGED_SECTOR;
    if motion.center.sector != origin.center.sector {
        row.flags |= CHANGED_SECTOR;
    }
    follow_stance(motion, row);
}

/// The way of a body through the step, places from `from`; the angular velocity is that at the end.
///
/// What turns by much in the step goes on a way of its own: two orientations do not tell how it came from one to
/// the other. It is taken to turn freely at its last velocity from its first orientation, as a symmetric top does,
/// exactly: about its momentum by `L / I`, and about the odd axis by what is left. Then the point that meets a
/// surface is one that comes nearer by the body's velocities, and the contact of the next step has something to
/// stop.
fn course(from: Position, (origin, end, row): (&Motion, &Motion, &BodyRow), dt: f32) -> Course {
    let start = Frame::new(origin.center.minus_wide(from), origin.rotation);
    let way = end.center.minus_wide(origin.center);
    let turn = widened(end.angular) * f64::from(dt);
    let odd = odd_axis(row);
    let (first, last) = (Quaternion::of(origin.rotation), Quaternion::of(end.rotation));
    let loose = turn.dot(turn) >= TURN_MAX * TURN_MAX;
    let (swing, twist) = if !loose {
        turns_between(first, last, odd)
    } else if let Some((axis, ratio)) = odd {
        let (before, after) = (first.rotate(axis), last.rotate(axis));
        let turn = Quaternion::about(swing_between(after, before)).rotate(turn);
        let spin = turn.dot(before);
        let swing = turn + before * (spin * (ratio - 1.0));
        let twist = Turn { axis: before, angle: spin * (1.0 - ratio) };
        (Turn::of(swing), twist)
    } else {
        (Turn::of(turn), Turn::NONE)
    };
    let end = loose.then(|| Frame::new(end.center.minus_wide(from), end.rotation));
    Course { start, way, swing, twist, end, held: false }
}

/// The axis of the moment of inertia that stands out, in the body's frame, and its moment over the mean of the
/// others.
fn odd_axis(row: &BodyRow) -> Option<(DVec3, f64)> {
    let i = row.inertia;
    if i.x == i.y && i.y == i.z {
        return None;
    }
    let (frame, moments) = split_frame(i);
    let axis = widened(row.axes.after(frame).rotate(Vec3::Z));
    Some((axis, 2.0 * f64::from(moments.z) / (f64::from(moments.x) + f64::from(moments.y))))
}

/// The least turn that takes one unit vector to another.
fn swing_between(before: DVec3, after: DVec3) -> Turn {
    let across = before.cross(after);
    let sine = length(across);
    if sine == 0.0 {
        Turn::NONE
    } else {
        Turn { axis: across / sine, angle: libm::atan2(sine, before.dot(after)) }
    }
}

/// The turn from one orientation to another: the least one that takes the odd axis along, and a twist about that
/// axis. Of a body without such an axis all is swing.
fn turns_between(from: Quaternion, to: Quaternion, odd: Option<(DVec3, f64)>) -> (Turn, Turn) {
    let whole = to.after(from.inverse());
    let Some((axis, _)) = odd else { return (whole.turn(None), Turn::NONE) };
    let (before, after) = (from.rotate(axis), to.rotate(axis));
    let swing = swing_between(before, after);
    (swing, Quaternion::about(swing).inverse().after(whole).turn(Some(before)))
}

/// A rotation in double precision, of length 1 but for the rounding of the state.
#[derive(Clone, Copy)]
struct Quaternion {
    imaginary: DVec3,
    real: f64,
}

impl Quaternion {
    fn of(q: Rotation) -> Self {
        let [x, y, z, w] = [q.x, q.y, q.z, q.w].map(f64::from);
        Self { imaginary: DVec3::new(x, y, z), real: w }
    }

    fn about(turn: Turn) -> Self {
        let half = 0.5 * turn.angle;
        Self { imaginary: turn.axis * libm::sin(half), real: libm::cos(half) }
    }

    fn inverse(self) -> Self {
        Self { imaginary: -self.imaginary, ..self }
    }

    /// First `first`, then this.
    fn after(self, first: Self) -> Self {
        let (a, b) = (self.imaginary, first.imaginary);
        Self {
            imaginary: b * self.real + a * first.real + a.cross(b),
            real: self.real * first.real - a.dot(b),
        }
    }

    fn rotate(self, v: DVec3) -> DVec3 {
        let t = self.imaginary.cross(v) * 2.0;
        v + t * self.real + self.imaginary.cross(t)
    }

    /// Axis and angle, at most half a turn; about a given unit axis what there is about it.
    fn turn(self, axis: Option<DVec3>) -> Turn {
        let (v, w) =
            if self.real < 0.0 { (-self.imaginary, -self.real) } else { (self.imaginary, self.real) };
        if let Some(axis) = axis {
            return Turn { axis, angle: 2.0 * libm::atan2(v.dot(axis), w) };
        }
        let size = length(v);
        if size == 0.0 { Turn::NONE } else { Turn { axis: v / size, angle: 2.0 * libm::atan2(size, w) } }
    }
}

/// True when a body has joints.
pub(crate) fn has_joints(first_joints: &[u32], body: u32) -> bool {
    first_joints.get(body as usize).is_some_and(|&first| first != 0)
}

/// What fast bodies may meet.
struct Chase<'a> {
    state: &'a State<'a>,
    assets: &'a AssetTables<'a>,
    origins: &'a [Motion],
    /// Of what rests, and of the rest.
    trees: [Tree<'a>; 2],
    /// The trees' sector.
    sector: [i32; 3],
    dt: f32,
}

impl Chase<'_> {
    /// The fraction of the step at which a body meets the first surface that it would pass.
    fn first_stop(&self, body: u32) -> f64 {
        let (row, origin) = (&self.state.bodies[body as usize], &self.origins[body as usize]);
        let mut course = course(origin.center, (origin, &self.state.motions[body as usize], row), self.dt);
        course.held = has_joints(self.state.first_joints, body);
        let mut best = NEVER;
        let mut next = row.first_shape;
        while let Some(shape) = self.state.shapes.get(next as usize) {
            best = self.stop_of((next, shape), (row, origin, &course), best);
            next = shape.next;
        }
        best
    }

    /// The same for one of its shapes, if it is before `best`.
    fn stop_of(
        &self,
        (slot, shape): (u32, &ShapeRow),
        (row, origin, course): (&BodyRow, &Motion, &Course),
        best: f64,
    ) -> f64 {
        let Some(parts) = Parts::new(&solid(shape, self.assets)) else { return best };
        let local = local_frame(row, shape);
        let (low, high) = parts.bounds(&local);
        let reach = DVec3::splat(length(crate::collide::cast::children::most(low, high)) + SEARCH_MARGIN);
        let span = length(course.way);
        let direction = if span > 0.0 { course.way / span } else { DVec3::ZERO };
        let from = origin.center.minus_wide(Position { sector: self.sector, offset: Vec3::ZERO });
        let limit = |best: f64| if best < 1.0 { best * span } else { f64::MAX };
        let mut best = best;
        for tree in &self.trees {
            let Some(way) = Way::new(tree, (from, direction, span), (-reach, reach)) else { continue };
            tree.search(
                way.limit(limit(best)),
                |bounds| way.bound(bounds),
                |other| {
                    if other != slot && self.stops(row, slot, other) {
                        best = self.meet((&parts, &local), (origin, course), (other, best));
                    }
                    way.limit(limit(best))
                },
            );
        }
        best
    }

    /// True when a body is stopped at a shape.
    fn stops(&self, row: &BodyRow, slot: u32, other: u32) -> bool {
        let theirs = &self.state.bodies[self.state.shapes[other as usize].body as usize];
        (!theirs.is_dynamic() || theirs.has(ASLEEP) || row.has(BULLET))
            && may_meet(self.state, slot, other)
            && stand_in_the_way(self.state, [slot, other])
    }

    /// The first meeting of a shape's parts with another shape, if it is before `best`.
    fn meet(
        &self,
        (parts, local): (&Parts<'_>, &Frame),
        (origin, course): (&Motion, &Course),
        (other, best): (u32, f64),
    ) -> f64 {
        let shape = &self.state.shapes[other as usize];
        let index = shape.body as usize;
        let (row, motion) = (&self.state.bodies[index], &self.state.motions[index]);
        let theirs = if row.kind() == BodyKind::Kinematic {
            self::course(origin.center, (&self.origins[index], motion, row), self.dt)
        } else {
            Course::still(Frame::new(motion.center.minus_wide(origin.center), motion.rotation))
        };
        let wall: Rider<'_, Solid<'_>> =
            Rider { shape: solid(shape, self.assets), local: local_frame(row, shape), course: &theirs };
        parts.at(local).fold(best, |best, (core, local)| {
            let limit = if best < 1.0 { best } else { 1.0 };
            impact(&wall, &Rider { shape: core, local, course }, limit)
                .map_or(best, |time| if time < best { time } else { best })
        })
    }
}

/// By how much more than its size a shape is looked around, metres: the gap at an impact, and rounding.
const SEARCH_MARGIN: f64 = 0.005;

/// Where a shape stands from its body's center, in the body's axes.
fn local_frame(row: &BodyRow, shape: &ShapeRow) -> Frame {
    Frame::new(widened(shape.pose.position) - widened(row.local_center), shape.pose.rotation)
}
