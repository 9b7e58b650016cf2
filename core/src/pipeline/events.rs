//! Events of a step, in the order of its stages; see `event.rs`.
//!
//! Contacts that began or ended are found where the set of contacts changes: `contacts.rs` and `sleep.rs` list
//! the pairs in question, and here they are looked up in the contacts of before and of now. So a step in which
//! no contact begins or ends does nothing, whatever the number of contacts.

use crate::body::{self, Motion};
use crate::cells::IMMOVABLE;
use crate::config::Settings;
use crate::event::{ContactHit, EventKind, EventKinds, EventRow, JointBreak, Tenant, Touching};
use crate::handle::{BodyHandle, JointHandle, ShapeHandle};
use crate::joint::BROKEN;
use crate::lanes::{LANES, Lane};
use crate::math::{Vec3, length};
use crate::pipeline::Counts;
use crate::pipeline::broadphase::pair_of;
use crate::pipeline::layout::{EMPTY, Plan};
use crate::pipeline::meeting::frame_of;
use crate::shape::{TELLS_CONTACTS, TELLS_HITS};
use crate::state::{Cache, ContactRow, Memo, Pair, ROUSED_LEFT, Scratch, State, TENANTS_LEFT, Touch};
use bytemuck::Zeroable;

/// Approach of a row's lane from which on a contact is looked at, as a share of the speed of a hit: the row's is
/// rounded otherwise.
const LOOK: f32 = 0.99;

/// Forgets the events of the step before.
pub(crate) fn begin(state: &mut State<'_>) {
    let count = core::mem::take(&mut state.header[0].events) as usize;
    state.events[..count].fill(EventRow::zeroed());
}

/// True when events of these kinds are told.
pub(crate) fn are_told(state: &State<'_>, kinds: EventKinds) -> bool {
    !state.events.is_empty() && state.header[0].settings.tells(kinds)
}

/// Tells an event, if there is room.
pub(crate) fn tell(state: &mut State<'_>, counts: &mut Counts, kind: EventKind) {
    let count = &mut state.header[0].events;
    match state.events.get_mut(*count as usize) {
        Some(row) => {
            *row = kind.into();
            *count += 1;
        }
        None => counts.dropped_events += 1,
    }
}

/// The handle of the body in a slot.
pub(crate) fn body_handle(state: &State<'_>, index: u32) -> BodyHandle {
    // A contact of a state of unknown origin may name a slot without a shape, and that no body.
    let generation = state.body_generations.get(index as usize).copied().unwrap_or(0);
    BodyHandle { index, generation }
}

fn shape_handle(state: &State<'_>, index: u32) -> ShapeHandle {
    ShapeHandle { index, generation: state.shape_generations[index as usize] }
}

/// Tells of bodies that slept and that a call has made something else, unless that was told with their island.
pub(crate) fn roused(state: &mut State<'_>, counts: &mut Counts) {
    if state.header[0].event_marks & ROUSED_LEFT == 0 {
        return;
    }
    state.header[0].event_marks &= !ROUSED_LEFT;
    for slot in 0..state.header[0].bodies.high {
        if is_roused(state, slot) {
            woke(state, counts, slot);
        }
    }
}

/// True when a body slept that a call has made something else.
pub(crate) fn is_roused(state: &State<'_>, slot: u32) -> bool {
    state.news[slot as usize / 64].roused >> (slot % 64) & 1 != 0
}

/// Tells that a body woke.
pub(crate) fn woke(state: &mut State<'_>, counts: &mut Counts, slot: u32) {
    state.news[slot as usize / 64].roused &= !(1 << (slot % 64));
    if are_told(state, EventKinds::SLEEP) {
        let body = body_handle(state, slot);
        tell(state, counts, EventKind::Woke(body));
    }
}

/// Tells that a body fell asleep.
pub(crate) fn slept(state: &mut State<'_>, counts: &mut Counts, slot: u32) {
    if are_told(state, EventKinds::SLEEP) {
        let body = body_handle(state, slot);
        tell(state, counts, EventKind::Slept(body));
    }
}

/// Adds a pair to a list in the scratch, which has no length without events.
pub(crate) fn note(list: &mut [u64], count: &mut usize, pair: Pair) {
    if let Some(place) = list.get_mut(*count) {
        *place = crate::pipeline::broadphase::key(pair.a, pair.b);
        *count += 1;
    }
}

/// Tells which contacts ended and which began. The lists in the scratch have the pairs that lost a contact and
/// those that got one.
pub(crate) fn contacts(state: &mut State<'_>, scratch: &mut Scratch<'_>, counts: &mut Counts) {
    let (ended, began) = (&mut scratch.ended[..counts.ended], &scratch.began[..counts.began]);
    if !(ended.is_empty() && began.is_empty()) && are_told(state, EventKinds::CONTACTS) {
        ended.sort_unstable();
        let before = &scratch.rows_before[..counts.contacts_before];
        let mut last = None;
        for &key in &*ended {
            if last.replace(key) != Some(key) && has_ended(state, pair_of(key)) {
                let touching = touching_before(state, pair_of(key));
                tell(state, counts, EventKind::ContactEnded(touching));
            }
        }
        let mut last = None;
        for &key in began {
            let pair = pair_of(key);
            let is_new = last.replace(key) != Some(key)
                && wants(state, pair, TELLS_CONTACTS)
                && (is_taken_over(state, pair) || (!has(before, pair) && ended.binary_search(&key).is_err()));
            if is_new {
                let touching = touching_now(state, pair);
                tell(state, counts, EventKind::ContactBegan(touching));
            }
        }
    }
    if state.header[0].event_marks & TENANTS_LEFT != 0 {
        state.header[0].event_marks &= !TENANTS_LEFT;
        let high = state.header[0].shapes.high as usize;
        state.tenants[..high].fill(Tenant::zeroed());
    }
}

/// True when a pair is among sorted contacts.
fn has(rows: &[ContactRow], pair: Pair) -> bool {
    rows.binary_search_by(|row| row.pair.cmp(&pair)).is_ok()
}

/// Who had the slot in the last step, if it was removed since.
fn former<'a>(state: &'a State<'_>, slot: u32) -> Option<&'a Tenant> {
    state.tenants.get(slot as usize).filter(|tenant| tenant.generation != 0)
}

/// True when a slot of the pair has lost its tenant of the last step.
fn is_taken_over(state: &State<'_>, pair: Pair) -> bool {
    former(state, pair.a).is_some() || former(state, pair.b).is_some()
}

/// True when a shape of the pair asks for events.
fn wants(state: &State<'_>, pair: Pair, events: u32) -> bool {
    (state.shapes[pair.a as usize].flags | state.shapes[pair.b as usize].flags) & events != 0
}

/// True when nothing is left of a pair's contacts, and this is to be told.
fn has_ended(state: &State<'_>, pair: Pair) -> bool {
    let flags = |slot: u32| match former(state, slot) {
        Some(tenant) => tenant.flags,
        None => state.shapes[slot as usize].flags,
    };
    let header = &state.header[0];
    let awake = &state.contacts[..header.contacts as usize];
    let asleep = &state.asleep_contacts[..header.asleep_contacts as usize];
    (flags(pair.a) | flags(pair.b)) & TELLS_CONTACTS != 0
        && (is_taken_over(state, pair) || !(has(awake, pair) || has(asleep, pair)))
}

fn touching_now(state: &State<'_>, pair: Pair) -> Touching {
    let slots = [pair.a, pair.b];
    Touching {
        shapes: slots.map(|slot| shape_handle(state, slot)),
        bodies: slots.map(|slot| body_handle(state, state.shapes[slot as usize].body)),
    }
}

/// The same for the tenants of the last step.
fn touching_before(state: &State<'_>, pair: Pair) -> Touching {
    let mut touching = touching_now(state, pair);
    for (side, slot) in [pair.a, pair.b].into_iter().enumerate() {
        if let Some(tenant) = former(state, slot) {
            touching.shapes[side].generation = tenant.generation;
            touching.bodies[side] = tenant.body;
        }
    }
    touching
}

/// True when the rows of contacts measure hits.
pub(crate) fn measures_hits(state: &State<'_>) -> bool {
    state.header[0].hit_shapes > 0 && are_told(state, EventKinds::HITS)
}

/// Tells which contacts were hits. The bodies are still where they were at the start of the step.
pub(crate) fn hits(
    state: &mut State<'_>,
    (cache, scratch): (&Cache<'_>, &mut Scratch<'_>),
    (plan, settings): (&Plan, &Settings),
    counts: &mut Counts,
) {
    if plan.rows == 0 || !measures_hits(state) {
        return;
    }
    let mut count = 0;
    for (row, link) in scratch.link_rows[..plan.rows].iter().enumerate() {
        let fast = link.approach.greater(Lane::splat(LOOK * settings.hit_speed));
        if fast.any() {
            for (lane, &contact) in cache.lane_contacts[row].iter().enumerate() {
                if contact != EMPTY && link.approach.get(lane) > LOOK * settings.hit_speed {
                    scratch.hits[count] = contact;
                    count += 1;
                }
            }
        }
    }
    scratch.hits[..count].sort_unstable();
    let memos = &cache.memos[cache.header[0].memo_half as usize * state.contacts.len()..];
    for &contact in &scratch.hits[..count] {
        let index = contact as usize;
        let row = state.contacts[index];
        if !wants(state, row.pair, TELLS_HITS) {
            continue;
        }
        let place = cache.contact_places[index] as usize;
        let (link, lane) = (place / LANES, place % LANES);
        let points = &scratch.point_rows[scratch.row_points[link] as usize..];
        let last = points.iter().take(row.tag.points()).fold(0.0, |sum, point| sum + point.impulse.get(lane));
        let impulse = scratch.link_rows[link].total.get(lane) + last;
        let hit = measure(state, (scratch, &memos[index], &scratch.touches[index]), &row);
        if impulse > 0.0 && hit.speed > settings.hit_speed {
            tell(state, counts, EventKind::ContactHit(ContactHit { impulse, ..hit }));
        }
    }
}

/// The point of a contact that approaches fastest, and how fast.
fn measure(
    state: &State<'_>,
    (scratch, memo, touch): (&Scratch<'_>, &Memo, &Touch),
    row: &ContactRow,
) -> ContactHit {
    let [frame_a, frame_b] = touch.shapes.map(|slot| frame_of(scratch.frames[slot as usize]));
    let motion = |slot: u32| -> &Motion { &state.motions[state.shapes[slot as usize].body as usize] };
    let (a, b) = (motion(touch.shapes[0]), motion(touch.shapes[1]));
    let normal = frame_a.rotation.rotate(memo.normal);
    let mut fastest = (f32::NEG_INFINITY, Vec3::ZERO);
    for (on_a, on_b) in memo.on_a.iter().zip(&memo.on_b).take(row.tag.points()) {
        let place = (frame_a.transform(*on_a) + frame_b.transform(*on_b) + touch.centers) * 0.5;
        let at_a = a.linear + a.angular.cross(place);
        let at_b = b.linear + b.angular.cross(place - touch.centers);
        let speed = normal.dot(at_a - at_b);
        if speed > fastest.0 {
            fastest = (speed, place);
        }
    }
    ContactHit {
        touching: touching_now(state, row.pair),
        point: a.center.plus(fastest.1),
        normal: normal * touch.sign(),
        speed: fastest.0,
        impulse: 0.0,
    }
}

/// Tells that a joint broke.
pub(crate) fn broke(state: &mut State<'_>, counts: &mut Counts, slot: u32) {
    let joint = &state.joints[slot as usize];
    if !joint.has(BROKEN) || !are_told(state, EventKinds::JOINTS) {
        return;
    }
    let broken = JointBreak {
        joint: JointHandle { index: slot, generation: state.joint_generations[slot as usize] },
        bodies: joint.bodies.map(|body| body_handle(state, body)),
        force: length(joint.force),
        torque: length(joint.torque),
    };
    tell(state, counts, EventKind::JointBroken(broken));
}

/// Tells which of the bodies that were solved are quarantined now.
pub(crate) fn quarantined(state: &mut State<'_>, active_of: &[u32], counts: &mut Counts) {
    if !are_told(state, EventKinds::QUARANTINE) {
        return;
    }
    for slot in 0..state.header[0].bodies.high {
        let index = slot as usize;
        if active_of[index] != IMMOVABLE && state.bodies[index].has(body::QUARANTINED) {
            let body = body_handle(state, slot);
            tell(state, counts, EventKind::Quarantined(body));
        }
    }
}

/// Forgets which bodies moved in the step before; those that calls have moved since are the first of this one.
pub(crate) fn begin_moved(state: &mut State<'_>) {
    if state.header[0].settings.notes_moved() {
        let words = crate::pool::words(state.header[0].bodies.high as usize);
        for word in &mut state.news[..words] {
            (word.moved, word.called, word.slept) = (word.called, 0, 0);
        }
    }
}

/// Notes that a body was moved by a call.
pub(crate) fn note_moved(state: &mut State<'_>, slot: usize) {
    if state.header[0].settings.notes_moved() {
        state.news[slot / 64].called |= 1 << (slot % 64);
    }
}

/// Notes that a body fell asleep in this step.
pub(crate) fn note_slept(state: &mut State<'_>, slot: usize) {
    if state.header[0].settings.notes_moved() {
        state.news[slot / 64].slept |= 1 << (slot % 64);
    }
}

/// Slots that are listed as moved, ascending.
pub(crate) fn moved_slots(words: &[crate::event::BodyNews], high: u32) -> impl Iterator<Item = u32> + '_ {
    let count = crate::pool::words(high as usize);
    (0..).zip(&words[..count]).flat_map(|(word, bits)| {
        let mut rest = bits.moved | bits.called;
        core::iter::from_fn(move || {
            let bit = (rest != 0).then(|| rest.trailing_zeros())?;
            rest &= rest - 1;
            Some(word * 64 + bit)
        })
    })
}
