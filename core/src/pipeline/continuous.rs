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
//! **What is at a wall already** has had its impact in this step, and is stopped because it turns on, so that
//! another of its points comes to the wall. Stopped each time it would stay where it is for good: contacts act
//! where it stands, and what they push out is undone with the rest of its motion. So a body that is stopped in the
//! first tenth of a step is shifted off the wall by what its turn needs, goes on without what comes nearer, and is
//! shifted back to the wall at the end, where contacts can stop what of its velocity leads there. All of that is
//! a motion among walls, each part of it stopped like the first; it happens a few times at most, and no velocity
//! is changed by it.
//!
//! - Against static and kinematic bodies always, the latter on their own way; against dynamic ones for bodies with
//!   [`BULLET`], at the poses that the solve left them in, so that the order of bodies does not matter. Trees find
//!   what is in its fat box; what was thrown out of it in this step is listed for bullets.
//! - Nothing is solved again, so the cost is bounded: one search of the trees for each shape of a fast body
//!   that has something in reach that stops it, and a look at their boxes for each other one.
//! - A body that is stopped is torn off its joints for that step, and they pull it back in the next. So a body with
//!   joints is stopped only where the middle of a shape would pass, and contacts are left the rest.
//! - Where no body is fast nothing runs: a body that moves less than [`WAY_FLOOR`] and turns less than
//!   [`TURN_FLOOR`] is not looked at.

mod course;

use crate::body::{ASLEEP, BULLET, BodyKind, BodyRow, CHANGED_SECTOR, Motion, Position};
use crate::collide::Solid;
use crate::collide::cast::children::Parts;
use crate::collide::cast::course::{Course, Rider};
use crate::collide::cast::frame::{Frame, length, widened};
use crate::collide::cast::impact::{Impact, impact};
use crate::collide::cast::support;
use crate::collide::tree::Tree;
use crate::collide::tree::search::Way;
use crate::config::Settings;
use crate::executor::{Executor, Stage};
use crate::math::{Aabb, Pose, Rotation, Vec3, max, max_each, min, min_each, sqrt};
use crate::pipeline::broadphase::{may_meet, refresh_trees, tree_of};
use crate::pipeline::finish::follow_stance;
use crate::pipeline::rules::stand_in_the_way;
use crate::pipeline::tasks::{Crew, Tasks, chunk, push};
use crate::pipeline::{Counts, solid};
use crate::shape::{
    GEOMETRY_BOX, GEOMETRY_CAPSULE, GEOMETRY_COMPOUND, GEOMETRY_HULL, GEOMETRY_ROUNDED_HULL, GEOMETRY_SPHERE,
    ShapeRow,
};
use crate::state::{AssetTables, Cache, Scratch, State};
use bytemuck::{Pod, Zeroable};
use course::{course, turned, turned_along};
use glam::DVec3;

/// A body is fast when some point of a shape moves by more than this share of the shape's inner radius in a step.
pub(crate) const FAST_SHARE: f32 = 0.5;
/// Way in a step below which no body is fast, metres: far less than contacts look ahead.
pub(crate) const WAY_FLOOR: f32 = 0.002;
/// Turn in a step below which none is, radians.
const TURN_FLOOR: f32 = 0.02;
/// Fast bodies that are worth a task.
const FAST_BODIES: usize = 8;
/// Fraction of the step before which a body that is stopped goes on another way.
const EARLY: f64 = 0.1;
/// How often a body may be stopped in a step.
const ROUNDS: usize = 4;
/// Least share of a normal along axes that are not locked for a body to move off along it.
const FREE_MIN: f64 = 0.25;

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
    let [x, y, z] = shape.size;
    match shape.kind {
        GEOMETRY_SPHERE => x,
        GEOMETRY_CAPSULE => x + y,
        GEOMETRY_BOX => crate::math::length(Vec3::new(x, y, z)),
        GEOMETRY_HULL => sqrt(assets.hulls[shape.asset() as usize].radius_squared),
        GEOMETRY_ROUNDED_HULL => sqrt(assets.hulls[shape.asset() as usize].radius_squared) + y,
        _ => {
            let bounds = crate::collide::bounds::aabb(&solid(shape, assets), &Pose::IDENTITY);
            crate::math::length(max_each(bounds.min.abs(), bounds.max.abs()))
        }
    }
}

/// The radius of a ball around a shape about its body's center, metres, but for its rounding.
fn reach_of(row: &BodyRow, shape: &ShapeRow, assets: &AssetTables<'_>) -> f32 {
    crate::math::length(shape.pose.position - row.local_center) + outer_radius(shape, assets)
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
        stops: &'a mut [Stop],
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
    let strays = list_strays(state, (assets, origins), (&scratch.fast[..count], scratch.strays));
    let header = &cache.header[0];
    let chase = Chase {
        state,
        assets,
        origins,
        trees: [
            tree_of(cache.static_nodes, cache.static_order, header.static_leaves),
            tree_of(cache.moving_nodes, cache.moving_order, header.moving_leaves),
        ],
        moving_stops: counts.kinematic || counts.quarantined > 0,
        strays: &scratch.strays[..strays],
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
            *stop = chase.stop(body);
        }
    });
    drop(tasks);
    for (&body, stop) in scratch.fast[..count].iter().zip(&scratch.stops[..count]) {
        if stop.is_one() {
            let slot = body as usize;
            cut(&scratch.origins[slot], (&mut state.motions[slot], &mut state.bodies[slot]), stop);
            counts.cut += 1;
        }
    }
}

/// Lists the shapes of fast bodies that have left their fat boxes, if one of the bodies is a bullet; says how many.
fn list_strays(
    state: &State<'_>,
    (assets, origins): (&AssetTables<'_>, &[Motion]),
    (fast, strays): (&[u32], &mut [u32]),
) -> usize {
    if !fast.iter().any(|&body| state.bodies[body as usize].has(BULLET)) {
        return 0;
    }
    let mut count = 0;
    for &body in fast {
        let (row, motion) = (&state.bodies[body as usize], &state.motions[body as usize]);
        let sector = origins[body as usize].center.sector;
        let from_box = motion.center.minus(Position { sector, offset: Vec3::ZERO });
        let mut next = row.first_shape;
        while let Some(shape) = state.shapes.get(next as usize) {
            let pose = motion.local_to_center(row, &shape.pose);
            let bounds = crate::collide::bounds::aabb(&solid(shape, assets), &pose);
            let now = Aabb { min: bounds.min + from_box, max: bounds.max + from_box };
            if !shape.fat_box.contains(&now) {
                strays[count] = next;
                count += 1;
            }
            next = shape.next;
        }
    }
    count
}

/// Where a fast body ends its step, if not where the solve left it.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(crate) struct Stop {
    /// From where its center started, metres.
    way: [f64; 3],
    rotation: Rotation,
    /// 0 when it is not stopped.
    stops: f64,
}

impl Stop {
    fn is_one(&self) -> bool {
        self.stops != 0.0
    }
}

/// Ends a body's motion. Velocities stay, the angular one in the view of the body's odd axis: so the energy does,
/// where a spin about the long axis of a rod that has turned would be one across it.
fn cut(origin: &Motion, (motion, row): (&mut Motion, &mut BodyRow), stop: &Stop) {
    motion.center = origin.center.plus_wide(DVec3::from_array(stop.way));
    motion.angular = turned_along(motion.angular, row, (motion.rotation, stop.rotation));
    motion.rotation = stop.rotation;
    row.flags &= !CHANGED_SECTOR;
    if motion.center.sector != origin.center.sector {
        row.flags |= CHANGED_SECTOR;
    }
    follow_stance(motion, row);
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
    /// True when the second tree may have shapes that stop other bodies than bullets: of kinematic ones, and of
    /// those that were quarantined in this step.
    moving_stops: bool,
    /// Shapes that bullets may meet where the trees do not have them.
    strays: &'a [u32],
    /// The trees' sector.
    sector: [i32; 3],
    dt: f32,
}

/// Which walls a body meets: as they move in the step, or as they stand at a time.
#[derive(Clone, Copy)]
enum Walls {
    Moving,
    At(f64),
}

/// A body on a course.
#[derive(Clone, Copy)]
struct Runner<'a> {
    row: &'a BodyRow,
    origin: &'a Motion,
    course: &'a Course,
    walls: Walls,
}

/// The first impact of those found; of impacts at one time that of the lowest slots, in whatever order they are
/// found.
struct Best {
    impact: Option<Impact>,
    slots: [u32; 2],
}

impl Best {
    fn limit(&self) -> f64 {
        self.impact.map_or(1.0, |impact| impact.time)
    }

    fn add(&mut self, found: Impact, slots: [u32; 2]) {
        if self.impact.is_none_or(|best| (found.time, slots) < (best.time, self.slots)) {
            (self.impact, self.slots) = (Some(found), slots);
        }
    }
}

impl Chase<'_> {
    /// Where a body is stopped.
    fn stop(&self, body: u32) -> Stop {
        let (row, origin) = (&self.state.bodies[body as usize], &self.origins[body as usize]);
        let end = &self.state.motions[body as usize];
        if self.is_clear(row, (origin.center, end.center)) {
            return Stop::zeroed();
        }
        let mut course = course(origin.center, (origin, end, row), self.dt);
        course.held = has_joints(self.state.first_joints, body);
        let runner = Runner { row, origin, course: &course, walls: Walls::Moving };
        let Some((impact, wall)) = self.first_impact(&runner) else { return Stop::zeroed() };
        let rotation = turned(origin.rotation, &course, impact.time);
        let way = course.way * impact.time;
        if course.held || impact.time >= EARLY || self.is_pushed(wall) {
            return Stop { way: way.to_array(), rotation, stops: 1.0 };
        }
        self.go_on(&runner, (impact, way, rotation))
    }

    /// True when surely nothing that stops a body is in its way: in a box around balls about its center at the
    /// start and at the end that no shape of it leaves. Most fast bodies have no need of a course.
    fn is_clear(&self, row: &BodyRow, (start, end): (Position, Position)) -> bool {
        if row.has(BULLET) {
            return false;
        }
        let mut reach = 0.0;
        let mut next = row.first_shape;
        while let Some(shape) = self.state.shapes.get(next as usize) {
            reach = max(reach_of(row, shape, self.assets), reach);
            next = shape.next;
        }
        let home = Position { sector: self.sector, offset: Vec3::ZERO };
        let (start, end) = (start.minus(home), end.minus(home));
        let far = max_each(start.abs(), end.abs()).max_element() + reach;
        let reach = reach + SEARCH_MARGIN as f32 + CLEAR_SLACK * far;
        let region = Aabb { min: min_each(start, end), max: max_each(start, end) }.grown(reach);
        let [resting, moving] = &self.trees;
        let stops = |other: u32| {
            let theirs = &self.state.bodies[self.state.shapes[other as usize].body as usize];
            !theirs.is_dynamic() || theirs.has(ASLEEP)
        };
        let any = resting.any(&region, stops) || (self.moving_stops && moving.any(&region, stops));
        !any
    }

    /// Where a body ends that would be stopped at once: it is at a wall and turns so that another point of it
    /// comes there, and were it stopped each time, it would stay where it is. It is moved off the wall by what
    /// its turn needs, and goes on without coming nearer; so a few times.
    fn go_on(
        &self,
        runner: &Runner<'_>,
        (mut impact, mut place, mut rotation): (Impact, DVec3, Rotation),
    ) -> Stop {
        let mut course = *runner.course;
        let mut lifts = [DVec3::ZERO; ROUNDS];
        let mut time = impact.time;
        for lifted in &mut lifts {
            course = course.resumed(time, Frame::new(place, rotation));
            let Some((free, lift)) = self.leave(runner.row, &course, &impact) else { break };
            course.way = free;
            *lifted = self.shift(runner, (course.start, lift), time);
            place += *lifted;
            course.start = course.start.at(place);
            let next = self.first_impact(&Runner { course: &course, ..*runner });
            time = next.map_or(1.0, |(next, _)| next.time);
            place = course.at(time).position;
            rotation = turned(rotation, &course, time);
            match next {
                Some((next, wall)) if !self.is_pushed(wall) => impact = next,
                _ => break,
            }
        }
        // Back to the wall: only there contacts can stop what comes to it.
        for lifted in lifts.into_iter().rev() {
            place += self.shift(runner, (Frame::new(place, rotation), -lifted), time);
        }
        Stop { way: place.to_array(), rotation, stops: 1.0 }
    }

    /// How far a body in a frame can be shifted at a time, metres.
    fn shift(&self, runner: &Runner<'_>, (start, way): (Frame, DVec3), time: f64) -> DVec3 {
        if way == DVec3::ZERO {
            return way;
        }
        let course = Course { way, ..Course::still(start) };
        let met = self.first_impact(&Runner { course: &course, walls: Walls::At(time), ..*runner });
        way * met.map_or(1.0, |(met, _)| met.time)
    }

    /// True for a shape of a body that may be pushed: where a bullet meets it their contact is to decide.
    fn is_pushed(&self, slot: u32) -> bool {
        let row = &self.state.bodies[self.state.shapes[slot as usize].body as usize];
        row.is_dynamic() && !row.has(ASLEEP)
    }

    /// The way of a course without what comes nearer at an impact, and how far the body is to be moved off so that
    /// it can turn: both over the rest of the step, metres. `None` for a body that cannot move off.
    fn leave(&self, row: &BodyRow, course: &Course, impact: &Impact) -> Option<(DVec3, DVec3)> {
        let n = impact.normal;
        let locks = row.locks();
        let free = |axis: usize| if locks >> axis & 1 == 1 { 0.0 } else { n[axis] };
        let free = DVec3::new(free(0), free(1), free(2));
        let share = free.dot(n);
        if share < FREE_MIN {
            return None;
        }
        let nearer = course.way.dot(n);
        let way = if nearer > 0.0 { course.way - free * (nearer / share) } else { course.way };
        let rest = 1.0 - course.from;
        let arm = impact.point - course.start.position;
        let turn = course.swing.axis * course.swing.angle + course.twist_at(course.from);
        let (across, reach) = (length(turn.cross(n)), self.reach(row));
        // First and second order of how far the turn brings points nearer, and how far there are any.
        let rate = way.dot(n) + turn.cross(arm).dot(n);
        let bend = 0.5 * across * length(turn) * reach;
        let room = reach - arm.dot(n);
        let need = (if rate > 0.0 { rate } else { 0.0 } + bend * rest) * rest;
        let lift = if need < room { need } else { room };
        Some((way, free * (if lift > 0.0 { -lift / share } else { 0.0 })))
    }

    /// The greatest distance of a point of a body's shapes from its center, metres.
    fn reach(&self, row: &BodyRow) -> f64 {
        let mut reach = 0.0;
        let mut next = row.first_shape;
        while let Some(shape) = self.state.shapes.get(next as usize) {
            if let Some(parts) = Parts::new(&solid(shape, self.assets)) {
                let (low, high) = parts.bounds(&local_frame(row, shape));
                let own = length(crate::collide::cast::children::most(low, high));
                reach = if own > reach { own } else { reach };
            }
            next = shape.next;
        }
        reach
    }

    /// Where a body meets the first surface that it would pass, and the slot of its shape.
    fn first_impact(&self, runner: &Runner<'_>) -> Option<(Impact, u32)> {
        let mut best = Best { impact: None, slots: [0; 2] };
        let mut next = runner.row.first_shape;
        while let Some(shape) = self.state.shapes.get(next as usize) {
            self.impact_of((next, shape), runner, &mut best);
            next = shape.next;
        }
        best.impact.map(|impact| (impact, best.slots[1]))
    }

    /// The same for one of its shapes.
    fn impact_of(&self, (slot, shape): (u32, &ShapeRow), runner: &Runner<'_>, best: &mut Best) {
        let Some(parts) = Parts::new(&solid(shape, self.assets)) else { return };
        let Runner { row, origin, course, .. } = runner;
        let local = local_frame(row, shape);
        let reach = DVec3::splat(f64::from(reach_of(row, shape, self.assets)) * REACH_SLACK + SEARCH_MARGIN);
        let way = course.way * (1.0 - course.from);
        let span = length(way);
        let direction = if span > 0.0 { way / span } else { DVec3::ZERO };
        let home = Position { sector: self.sector, offset: Vec3::ZERO };
        let from = origin.center.minus_wide(home) + course.start.position;
        let limit = |best: &Best| match best.impact {
            Some(impact) if impact.time < 1.0 => course.share(impact.time) * span,
            _ => f64::MAX,
        };
        let [resting, moving] = &self.trees;
        let moving = Some(moving).filter(|_| self.moving_stops || row.has(BULLET));
        for tree in core::iter::once(resting).chain(moving) {
            let Some(way) = Way::new(tree, (from, direction, span), (-reach, reach)) else { continue };
            tree.search(
                way.limit(limit(best)),
                |bounds| way.bound(bounds),
                |other| {
                    if other != slot && self.stops(row, slot, other) {
                        self.meet((&parts, &local), runner, ([slot, other], best));
                    }
                    way.limit(limit(best))
                },
            );
        }
        for &other in if row.has(BULLET) { self.strays } else { &[] } {
            if other != slot && self.comes_near(runner, (other, way, reach.x)) && self.stops(row, slot, other)
            {
                self.meet((&parts, &local), runner, ([slot, other], best));
            }
        }
    }

    /// True when a ball of a radius about the body's center comes near a shape on its way.
    fn comes_near(&self, runner: &Runner<'_>, (other, way, radius): (u32, DVec3, f64)) -> bool {
        let shape = &self.state.shapes[other as usize];
        let (row, motion) =
            (&self.state.bodies[shape.body as usize], &self.state.motions[shape.body as usize]);
        let reach = radius + f64::from(reach_of(row, shape, self.assets)) * REACH_SLACK;
        let start = runner.course.start.position;
        let off = motion.center.minus_wide(runner.origin.center) - start;
        let square = way.dot(way);
        // The nearest point of the way.
        let along = off.dot(way);
        let share = match along {
            _ if along <= 0.0 => 0.0,
            _ if along >= square => 1.0,
            _ => along / square,
        };
        let rest = off - way * share;
        rest.dot(rest) <= reach * reach
    }

    /// True when a body is stopped at a shape.
    fn stops(&self, row: &BodyRow, slot: u32, other: u32) -> bool {
        let theirs = &self.state.bodies[self.state.shapes[other as usize].body as usize];
        (!theirs.is_dynamic() || theirs.has(ASLEEP) || row.has(BULLET))
            && may_meet(self.state, slot, other)
            && stand_in_the_way(self.state, [slot, other])
    }

    /// The first meeting of a shape's parts with another shape.
    fn meet(
        &self,
        (parts, local): (&Parts<'_>, &Frame),
        runner: &Runner<'_>,
        (slots, best): ([u32; 2], &mut Best),
    ) {
        let center = runner.origin.center;
        let shape = &self.state.shapes[slots[1] as usize];
        let index = shape.body as usize;
        let (row, motion) = (&self.state.bodies[index], &self.state.motions[index]);
        let mut theirs = if row.kind() == BodyKind::Kinematic {
            course(center, (&self.origins[index], motion, row), self.dt)
        } else {
            Course::still(Frame::new(motion.center.minus_wide(center), motion.rotation))
        };
        if let Walls::At(time) = runner.walls {
            theirs = Course::still(theirs.at(time));
        }
        let wall: Rider<'_, Solid<'_>> =
            Rider { shape: solid(shape, self.assets), local: local_frame(row, shape), course: &theirs };
        for (core, local) in parts.at(local) {
            let rider = Rider { shape: core, local, course: runner.course };
            if let Some(found) = impact(&wall, &rider, best.limit()) {
                best.add(found, slots);
            }
        }
    }
}

/// By how much more than its size a shape is looked around, metres: the gap at an impact, and rounding.
const SEARCH_MARGIN: f64 = 0.005;
/// By what such a radius is multiplied so that it is none too small.
const REACH_SLACK: f64 = 1.0 + 1.0e-5;
/// What a body is looked around by, as a fraction of the greatest coordinate where single precision has to do:
/// several times its rounding, and that of a search along the way.
const CLEAR_SLACK: f32 = 4.0e-6;

/// Where a shape stands from its body's center, in the body's axes.
fn local_frame(row: &BodyRow, shape: &ShapeRow) -> Frame {
    Frame::new(widened(shape.pose.position) - widened(row.local_center), shape.pose.rotation)
}
