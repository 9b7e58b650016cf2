//! Finish: results of the solve written back to the state; bodies that are no longer numbers are quarantined.

use crate::body::{
    self, ASLEEP, BodyKind, BodyRow, CHANGED_SECTOR, KIND_MASK, Motion, QUARANTINED, STOPS_AFTER_STEP,
};
use crate::config::{SECTOR_MAX, Settings};
use crate::constraint::row::{LinkRow, PointRow};
use crate::event::BodyNews;
use crate::executor::{Executor, Stage};
use crate::lanes::LANES;
use crate::math::{Rotation, Vec3};
use crate::pipeline::broadphase::MOVED;
use crate::pipeline::continuous::{self, Race};
use crate::pipeline::integration;
use crate::pipeline::joints::begin_anew;
use crate::pipeline::layout::Plan;
use crate::pipeline::mover::{MoverRow, angular_velocity};
use crate::pipeline::rows::resistance;
use crate::pipeline::seat::Seat;
use crate::pipeline::solver::take;
use crate::pipeline::tasks::{Crew, Tasks, chunk, push};
use crate::pipeline::{Counts, events};
use crate::shape::BOX_STALE;
use crate::state::{Active, AssetTables, Cache, ContactRow, Scratch, State, Touch};

/// Turn from which on a body's stance follows, radians.
const STANCE_TURN: f32 = 0.01;
/// Bodies that are worth a task.
const FINISH_BODIES: usize = 256;
/// Contacts that are worth a task.
const FINISH_CONTACTS: usize = 512;

pub(crate) fn run<E: Executor>(
    state: &mut State<'_>,
    (assets, cache, scratch): (&AssetTables<'_>, &mut Cache<'_>, &mut Scratch<'_>),
    (plan, settings): (&Plan, &Settings),
    (crew, counts): (&mut Crew<'_, E>, &mut Counts),
) {
    store_impulses(state, (cache, scratch), plan, crew);
    store_motions(state, (assets, cache, scratch), (plan, settings), (crew, counts));
    if counts.fast > 0 {
        continuous::run(state, (assets, cache, scratch), settings.dt, (crew, counts));
    }
    if counts.quarantined > 0 {
        drop_shapes_of_quarantined(state);
        events::quarantined(state, scratch.active_of, counts);
    }
    state.header[0].step += 1;
}

/// Impulses of the contacts, for the next step's warm start.
fn store_impulses<E: Executor>(
    state: &mut State<'_>,
    (cache, scratch): (&Cache<'_>, &Scratch<'_>),
    plan: &Plan,
    crew: &mut Crew<'_, E>,
) {
    struct Task<'a> {
        rows: &'a mut [ContactRow],
        places: &'a [u32],
        touches: &'a [Touch],
    }
    let count = state.header[0].contacts as usize;
    if plan.rows == 0 {
        return;
    }
    let share = chunk(count, FINISH_CONTACTS);
    let mut tasks: Tasks<Task<'_>> = Tasks::new();
    for (i, rows) in state.contacts[..count].chunks_mut(share).enumerate() {
        let run = i * share..i * share + rows.len();
        let (places, touches) = (&cache.contact_places[run.clone()], &scratch.touches[run]);
        push(&mut tasks, Task { rows, places, touches });
    }
    let (links, points) = (&*scratch.link_rows, &*scratch.point_rows);
    let (first_points, resists) = (&*scratch.row_points, &*scratch.resist_rows);
    crew.run(Stage::Finish, &mut tasks, |task| {
        for ((row, &place), touch) in task.rows.iter_mut().zip(task.places).zip(task.touches) {
            let (link, lane) = (place as usize / LANES, place as usize % LANES);
            let first = first_points[link] as usize;
            store(row, (&links[link], &points[first..]), touch.sign(), lane);
            if touch.settled < 0.0 && links[link].resists != 0 && row.can_resist() {
                let axes = (links[link].normal.get(lane), links[link].tangent.get(lane));
                if let Some(torque) = resistance(&resists[link], axes, lane) {
                    row.set_resistance(torque * touch.sign());
                }
            }
        }
    });
}

fn store(row: &mut ContactRow, (link, points): (&LinkRow, &[PointRow]), sign: f32, lane: usize) {
    for (impulse, point) in row.impulses.iter_mut().zip(points).take(row.tag.points()) {
        *impulse = point.impulse.get(lane);
    }
    let (n, t) = (link.normal.get(lane), link.tangent.get(lane));
    let s = n.cross(t);
    row.friction = (t * link.first_impulse.get(lane) + s * link.second_impulse.get(lane)) * sign;
    row.twist = link.twist_impulse.get(lane);
}

/// What the bodies became.
#[derive(Clone, Copy, Default)]
struct Found {
    quarantined: u32,
    capped: u32,
    ready: u32,
    /// Fast bodies.
    fast: usize,
    kinematic: bool,
}

/// Counts a step in which the body was quiet: the mean square of its points' speeds is
/// `v^2 + w^2 I / m`, `I` being the moment about the axis of its spin; here the greatest.
fn count_quiet(motion: &Motion, row: &mut BodyRow, speed: f32) {
    let i = row.inertia;
    let gyration = crate::math::max(i.x, crate::math::max(i.y, i.z)) / row.mass;
    let squares = motion.linear.dot(motion.linear) + motion.angular.dot(motion.angular) * gyration;
    row.count_quiet(squares < speed * speed);
}

/// A run of bodies.
struct Bodies<'a> {
    first: usize,
    motions: &'a mut [Motion],
    rows: &'a mut [BodyRow],
    origins: &'a mut [Motion],
    fast: &'a mut [u32],
    /// Empty when nobody asks which bodies moved.
    moved: &'a mut [BodyNews],
    found: Found,
}

impl Bodies<'_> {
    /// Writes what one of the dynamic bodies became, and lists it if it is fast.
    fn store(&mut self, i: usize, (results, race): (&Results<'_>, &Race<'_>), sleep: Option<u32>) {
        let (slot, motion, row) = (self.first + i, &mut self.motions[i], &mut self.rows[i]);
        if let Some((after, way)) = results.motion(slot, motion, row, &mut self.found) {
            let fast = race.is_fast(way, (&after, row));
            if fast || row.has(CHANGED_SECTOR) {
                self.origins[i] = *motion;
            }
            if fast {
                self.fast[self.found.fast] = slot as u32;
                self.found.fast += 1;
            }
            *motion = after;
        } else if row.has(CHANGED_SECTOR) {
            self.origins[i] = *motion;
        }
        if let Some(steps) = sleep {
            count_quiet(motion, row, race.settings.sleep_speed);
            self.found.ready += u32::from(row.quiet_steps() >= steps);
        }
    }
}

fn store_motions<E: Executor>(
    state: &mut State<'_>,
    (assets, cache, scratch): (&AssetTables<'_>, &Cache<'_>, &mut Scratch<'_>),
    (plan, settings): (&Plan, &Settings),
    (crew, counts): (&mut Crew<'_, E>, &mut Counts),
) {
    let high = state.header[0].bodies.high as usize;
    // Whole words of the list of what moved.
    let share = chunk(high, FINISH_BODIES).next_multiple_of(64);
    let notes = state.header[0].settings.notes_moved();
    let mut words = if notes { &mut *state.news } else { &mut [] };
    let results = Results {
        active_of: scratch.active_of,
        first_seats: cache.first_seats,
        last_seats: cache.last_seats,
        seats: &scratch.seats[..plan.seats],
        movers: scratch.movers,
        active: scratch.active,
    };
    let used = &*state.body_used;
    let (dt, sleep) = (settings.dt, settings.sleep_steps());
    let race = Race { shapes: state.shapes, assets, settings };
    let mut tasks: Tasks<Bodies<'_>> = Tasks::new();
    let parts = state.motions[..high].chunks_mut(share).zip(state.bodies[..high].chunks_mut(share));
    let places = scratch.origins[..high].chunks_mut(share).zip(scratch.fast[..high].chunks_mut(share));
    for (i, ((motions, rows), (origins, fast))) in parts.zip(places).enumerate() {
        let count = words.len().min(share / 64);
        let moved = take(&mut words, count);
        let found = Found::default();
        push(&mut tasks, Bodies { first: i * share, motions, rows, origins, fast, moved, found });
    }
    crew.run(Stage::Finish, &mut tasks, |task| {
        for i in 0..task.rows.len() {
            if crate::pool::is_used(used, (task.first + i) as u32) {
                // A fast body may be put elsewhere later, wherever the solve left it.
                let seen =
                    |task: &Bodies<'_>| (task.motions[i].center, task.motions[i].rotation, task.found.fast);
                let before = notes.then(|| seen(task));
                match task.rows[i].kind() {
                    BodyKind::Static => {}
                    BodyKind::Kinematic => {
                        task.origins[i] = task.motions[i];
                        task.found.kinematic = true;
                        move_kinematic(&mut task.motions[i], &mut task.rows[i], dt);
                    }
                    BodyKind::Dynamic if task.rows[i].has(ASLEEP) => {}
                    BodyKind::Dynamic => task.store(i, (&results, &race), sleep),
                }
                if before.is_some_and(|before| before != seen(task)) {
                    task.moved[i / 64].moved |= 1 << (i % 64);
                }
            }
        }
    });
    let mut listed: Tasks<(usize, usize)> = Tasks::new();
    for task in &tasks {
        counts.quarantined += task.found.quarantined;
        counts.capped += task.found.capped;
        counts.ready += task.found.ready;
        counts.kinematic |= task.found.kinematic;
        push(&mut listed, (task.first, task.found.fast));
    }
    drop(tasks);
    // One list of the tasks' lists, in their order.
    for (first, fast) in listed {
        scratch.fast.copy_within(first..first + fast, counts.fast as usize);
        counts.fast += fast as u32;
    }
}

/// A kinematic body moves by its velocity; one with a target arrives and stops.
fn move_kinematic(motion: &mut Motion, row: &mut BodyRow, dt: f32) {
    let place = motion.center;
    let rotation = integration::turned(motion.rotation, motion.angular * dt);
    let moved = place.plus(motion.linear * dt);
    if moved.sector.iter().any(|s| s.unsigned_abs() > SECTOR_MAX as u32) {
        motion.linear = Vec3::ZERO;
        return;
    }
    if moved.sector != place.sector {
        row.flags |= CHANGED_SECTOR;
    }
    motion.center = moved;
    motion.rotation = rotation;
    if row.has(STOPS_AFTER_STEP) {
        row.flags &= !STOPS_AFTER_STEP;
        motion.linear = Vec3::ZERO;
        motion.angular = Vec3::ZERO;
    }
}

/// Where the solve left the bodies.
struct Results<'a> {
    active_of: &'a [u32],
    first_seats: &'a [u32],
    last_seats: &'a [u32],
    seats: &'a [Seat],
    movers: &'a [MoverRow],
    active: &'a [Active],
}

impl Results<'_> {
    /// Where a body is after the step and how it moves, and the motion of its center, metres; `None` for one that
    /// is quarantined. The rest of the row follows.
    #[inline(always)]
    fn motion(
        &self,
        slot: usize,
        motion: &mut Motion,
        row: &mut BodyRow,
        found: &mut Found,
    ) -> Option<(Motion, Vec3)> {
        let index = self.active_of[slot] as usize;
        let first_seat = self.first_seats[index] as usize;
        let (mover, lane) = (&self.movers[first_seat / LANES], first_seat % LANES);
        let u = self.seats[self.last_seats[index] as usize].velocity.to_array();
        let whitened = Vec3::new(u[4], u[5], u[6]);
        let (displacement, rotation) = mover.outcome(lane, (&self.active[index], row));
        let after = Motion {
            center: motion.center.plus(displacement),
            rotation,
            linear: Vec3::new(u[0], u[1], u[2]),
            angular: angular_velocity(
                (&self.active[index], motion, row),
                (whitened, mover.view(lane)),
                rotation,
            ),
        };
        row.force = Vec3::ZERO;
        row.torque = Vec3::ZERO;
        found.capped += u32::from(mover.is_capped(lane));
        let inside = after.center.sector.iter().all(|s| s.unsigned_abs() <= SECTOR_MAX as u32);
        if !after.is_finite() || !displacement.is_finite() || !inside {
            quarantine(motion, row);
            found.quarantined += 1;
            return None;
        }
        if after.center.sector != motion.center.sector {
            row.flags |= CHANGED_SECTOR;
        }
        follow_stance(&after, row);
        Some((after, displacement))
    }
}

/// The stance follows a body that has turned.
pub(crate) fn follow_stance(motion: &Motion, row: &mut BodyRow) {
    if !is_near(motion.rotation, row.stance) {
        row.stance = motion.rotation.pack();
    }
}

/// True when the stance still serves.
fn is_near(rotation: Rotation, stance: [u32; 2]) -> bool {
    Rotation::unpack(stance).is_some_and(|stance| {
        // The imaginary part is half the angle of a small turn.
        let turn = rotation.after(stance.inverse()).imaginary();
        4.0 * turn.dot(turn) <= STANCE_TURN * STANCE_TURN
    })
}

/// Stops a body for good at its last finite pose.
fn quarantine(motion: &mut Motion, row: &mut BodyRow) {
    motion.linear = Vec3::ZERO;
    motion.angular = Vec3::ZERO;
    row.flags = (row.flags & !KIND_MASK) | BodyKind::Static as u32 | QUARANTINED;
}

/// Shapes of quarantined bodies are among those that rest from now on.
pub(crate) fn move_quarantined(state: &mut State<'_>, cache: &mut Cache<'_>, scratch: &mut Scratch<'_>) {
    state.header[0].static_version += 1;
    (cache.header[0].moving_fits, cache.header[0].moving_listed) = (0, 0);
    for slot in 0..state.header[0].shapes.high as usize {
        let shape = &state.shapes[slot];
        if crate::pool::is_used(state.shape_used, slot as u32)
            && state.bodies[shape.body as usize].has(body::QUARANTINED)
        {
            scratch.is_moved[slot] |= MOVED;
        }
    }
}

/// The shapes' pairs are looked for again, now that their body is static; their contacts go with the pairs.
fn drop_shapes_of_quarantined(state: &mut State<'_>) {
    for slot in 0..state.header[0].shapes.high {
        if crate::pool::is_used(state.shape_used, slot) {
            let shape = &mut state.shapes[slot as usize];
            if state.bodies[shape.body as usize].has(body::QUARANTINED) {
                shape.flags |= BOX_STALE | crate::shape::FRESH;
            }
        }
    }
    for slot in 0..state.first_joints.len() as u32 {
        if state.bodies[slot as usize].has(body::QUARANTINED) {
            begin_anew(state, slot);
        }
    }
}
