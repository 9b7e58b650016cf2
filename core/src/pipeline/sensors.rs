//! Sensors: what overlaps them at the end of the step, exactly.
//!
//! The visits are a sorted set in the state. A sensor that moves looks for everything around it. One that rests
//! keeps what rests in it, and looks only at what moves or was changed: a sensor around a pile that sleeps
//! costs nothing. A world without sensors pays one comparison.

use super::events::{are_told, tell};
use crate::event::{EventKind, EventKinds, Visit};
use crate::executor::{Executor, Stage};
use crate::pipeline::broadphase::{MOVED, tree_of};
use crate::pipeline::solver::take;
use crate::pipeline::tasks::{Crew, TASKS_MAX, Tasks, chunk, push};
use crate::pipeline::{Counts, query_trees};
use crate::pool::is_used;
use crate::query::Queries;
use crate::state::{AssetTables, Cache, Scratch, State, VISITS_DROPPED};
use bytemuck::Zeroable;

/// Sensors that are worth a task.
const SENSORS: usize = 4;

/// Brings the visits to the poses of now, and tells what began and ended. `moved` shapes are listed in the
/// scratch: changed ones are among them.
pub(crate) fn run<E: Executor>(
    state: &mut State<'_>,
    (assets, moved): (&AssetTables<'_>, usize),
    (cache, scratch): (&mut Cache<'_>, &mut Scratch<'_>),
    (crew, counts): (&mut Crew<'_, E>, &mut Counts),
) {
    if state.header[0].sensors == 0 && state.header[0].visits == 0 {
        return;
    }
    query_trees::refresh_in_tasks(state, assets, (cache, scratch), crew);
    let sensors = list(state, scratch);
    let all = state.header[0].event_marks & VISITS_DROPPED != 0;
    let moved = &scratch.moved[..moved];
    let changed = counts.quarantined > 0 || moved.iter().any(|&slot| rests(state, slot));
    let looks = Looks { marks: scratch.is_moved, all, changed };
    let queries = view(state, assets, cache);
    let slots = &scratch.sensor_slots[..sensors];
    let found = find((&queries, &looks, state), slots, scratch.found_visits, crew);
    let total = merge((state, &looks), &scratch.found_visits[..found.stored], scratch.visits_now);
    let dropped = found.dropped + total.saturating_sub(scratch.visits_now.len());
    let count = total.min(scratch.visits_now.len());
    counts.dropped_visits += dropped as u32;
    tell_changes(state, &scratch.visits_now[..count], counts);
    let before = state.header[0].visits as usize;
    state.visits[..count].copy_from_slice(&scratch.visits_now[..count]);
    state.visits[count..before.max(count)].fill(Visit::zeroed());
    let header = &mut state.header[0];
    header.visits = count as u32;
    header.event_marks = header.event_marks & !VISITS_DROPPED | if dropped > 0 { VISITS_DROPPED } else { 0 };
}

/// Lists the sensors, ascending by slot.
fn list(state: &State<'_>, scratch: &mut Scratch<'_>) -> usize {
    let (mut count, sensors) = (0, state.header[0].sensors as usize);
    for slot in 0..state.header[0].shapes.high {
        if count == sensors {
            break;
        }
        if state.shapes[slot as usize].is_sensor() {
            scratch.sensor_slots[count] = slot;
            count += 1;
        }
    }
    count
}

fn view<'a>(state: &'a State<'_>, assets: &AssetTables<'a>, cache: &'a Cache<'_>) -> Queries<'a> {
    let header = cache.header[0];
    Queries {
        assets: *assets,
        motions: state.motions,
        bodies: state.bodies,
        body_generations: state.body_generations,
        shapes: state.shapes,
        shape_generations: state.shape_generations,
        trees: [
            tree_of(cache.static_nodes, cache.static_order, header.static_leaves),
            tree_of(cache.moving_nodes, cache.moving_order, header.moving_leaves),
        ],
        sector: header.sector,
    }
}

/// True when the shape's body is static or asleep.
fn rests(state: &State<'_>, slot: u32) -> bool {
    state.bodies[state.shapes[slot as usize].body as usize].rests()
}

/// What sensors have to look at.
struct Looks<'a> {
    /// `MOVED` for shapes that left their boxes, or were changed.
    marks: &'a [u8],
    /// Everything is to be looked at.
    all: bool,
    /// Some shape that rests has a mark.
    changed: bool,
}

impl Looks<'_> {
    /// True when a shape is where it was, and what it was, at the end of the last step.
    fn stays(&self, state: &State<'_>, slot: u32) -> bool {
        rests(state, slot) && self.marks[slot as usize] & MOVED == 0
    }

    /// True when a visit goes on without a look.
    fn keeps(&self, state: &State<'_>, visit: &Visit) -> bool {
        let lives = |slot: u32, generation: u32| {
            is_used(state.shape_used, slot) && state.shape_generations[slot as usize] == generation
        };
        let (sensor, visitor) = (visit.sensor, visit.visitor);
        !self.all
            && lives(sensor.index, sensor.generation)
            && lives(visitor.index, visitor.generation)
            && state.shapes[sensor.index as usize].is_sensor()
            && self.stays(state, sensor.index)
            && self.stays(state, visitor.index)
    }
}

/// What was found.
#[derive(Clone, Copy, Default)]
struct Found {
    /// Visits at the front of the buffer, sorted.
    stored: usize,
    /// Those that found no room: all of them come after the last one.
    dropped: usize,
}

/// Some sensors and the room for what is in them.
struct Task<'t> {
    sensors: &'t [u32],
    visits: &'t mut [Visit],
    stored: usize,
    dropped: usize,
}

/// What all tasks read.
type View<'v, 'a> = (&'v Queries<'a>, &'v Looks<'v>, &'v State<'a>);

/// Finds the visits that have to be looked for. Every task has an even part of the room; where one's is too small,
/// the room is cut again by what was found.
fn find<E: Executor>(
    view: View<'_, '_>,
    sensors: &[u32],
    visits: &mut [Visit],
    crew: &mut Crew<'_, E>,
) -> Found {
    let share = chunk(sensors.len(), SENSORS);
    let tasks = sensors.len().div_ceil(share).max(1);
    let even = visits.len() / tasks;
    let (mut parts, mut counts) = ([even; TASKS_MAX], [Found::default(); TASKS_MAX]);
    search(view, (sensors, share), (visits, &parts[..tasks]), (&mut counts, crew));
    if counts[..tasks].iter().any(|count| count.dropped > 0) {
        let mut room = visits.len();
        for (part, count) in parts.iter_mut().zip(&counts[..tasks]) {
            *part = room.min(count.stored + count.dropped);
            room -= *part;
        }
        search(view, (sensors, share), (visits, &parts[..tasks]), (&mut counts, crew));
    }
    let (mut start, mut found) = (0, Found::default());
    for (part, count) in parts.iter().zip(&counts[..tasks]) {
        visits.copy_within(start..start + count.stored, found.stored);
        start += part;
        found.stored += count.stored;
        found.dropped += count.dropped;
    }
    found
}

/// Each task writes what is in its sensors to its part of the room.
fn search<E: Executor>(
    (queries, looks, state): View<'_, '_>,
    (sensors, share): (&[u32], usize),
    (visits, parts): (&mut [Visit], &[usize]),
    (counts, crew): (&mut [Found; TASKS_MAX], &mut Crew<'_, E>),
) {
    let mut rest = visits;
    let mut tasks: Tasks<Task<'_>> = Tasks::new();
    for (sensors, &part) in sensors.chunks(share).zip(parts) {
        push(&mut tasks, Task { sensors, visits: take(&mut rest, part), stored: 0, dropped: 0 });
    }
    crew.run(Stage::Finish, &mut tasks, |task| {
        for &slot in task.sensors {
            let stays = !looks.all && looks.stays(state, slot);
            let marks = stays.then_some(if looks.changed { looks.marks } else { [].as_slice() });
            let found = queries.visits(slot, marks, &mut task.visits[task.stored..]);
            task.stored += found.count;
            task.dropped += found.dropped;
        }
    });
    for (count, task) in counts.iter_mut().zip(&tasks) {
        *count = Found { stored: task.stored, dropped: task.dropped };
    }
}

/// Writes the visits that go on and those that were found, as far as there is room; says how many there are.
fn merge((state, looks): (&State<'_>, &Looks<'_>), found: &[Visit], now: &mut [Visit]) -> usize {
    let before = &state.visits[..state.header[0].visits as usize];
    let mut kept = before.iter().filter(|visit| looks.keeps(state, visit)).peekable();
    let mut found = found.iter().peekable();
    let mut count = 0;
    loop {
        let next = match (kept.peek(), found.peek()) {
            (Some(a), Some(b)) if a.key() > b.key() => found.next(),
            (Some(a), Some(b)) if a.key() == b.key() => {
                kept.next();
                continue;
            }
            (Some(_), _) => kept.next(),
            (None, _) => found.next(),
        };
        let Some(next) = next else { return count };
        if let Some(place) = now.get_mut(count) {
            *place = *next;
        }
        count += 1;
    }
}

/// Tells which visits are no more, then which are new.
fn tell_changes(state: &mut State<'_>, now: &[Visit], counts: &mut Counts) {
    if !are_told(state, EventKinds::SENSORS) {
        return;
    }
    let (before, mut place) = (state.header[0].visits as usize, 0);
    for i in 0..before {
        let visit = state.visits[i];
        if !is_next(now, &mut place, &visit) {
            tell(state, counts, EventKind::SensorEnded(visit));
        }
    }
    let mut place = 0;
    for visit in now {
        if !is_next(&state.visits[..before], &mut place, visit) {
            tell(state, counts, EventKind::SensorBegan(*visit));
        }
    }
}

/// True when a visit is among sorted ones, looked for from a place on that moves up to it.
fn is_next(visits: &[Visit], place: &mut usize, visit: &Visit) -> bool {
    while visits.get(*place).is_some_and(|other| other.key() < visit.key()) {
        *place += 1;
    }
    visits.get(*place) == Some(visit)
}
