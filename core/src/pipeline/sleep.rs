//! Sleep: islands that have come to rest are taken out of the step until something wakes them.
//!
//! An island is a set of dynamic bodies that are joined by contacts and joints. It falls asleep at the end of a
//! step when each of its bodies has been quiet for `Settings::sleep_time` and none of them is kept awake, or
//! touches a kinematic body that moves, or a surface that moves on its body. Its pairs and contacts go to arrays of
//! their own, so that the stages of a step do not see them at all; its shapes join the tree of what rests.
//!
//! It wakes, as a whole and before the contacts of the step are found, when
//! - a call changes one of its bodies, or a body that one of them touches or is joined to;
//! - one of its shapes gets points of contact with an awake body, with a kinematic one that moves, or with one that
//!   was put there;
//! - a joint ties it to such a body;
//! - gravity changes.
//!
//! Its contacts come back with their impulses. All of this follows from the state: the islands are found by union
//! of links whenever somebody may fall asleep or wakes, and nothing depends on how often that was.

use crate::body::{ASLEEP, BodyKind, BodyRow, Motion, SLEEPLESS, WAKES};
use crate::cells::{IMMOVABLE, UNORDERED};
use crate::collide::Manifolds;
use crate::joint::BROKEN;
use crate::math::Vec3;
use crate::pipeline::broadphase::{SLEEPS, key, merge_sorted, pair_of, place_shape};
use crate::pipeline::meeting::{Meeting, Scene};
use crate::pipeline::ordering::Links;
use crate::pipeline::rules::Rules;
use crate::pipeline::{Counts, events, solid};
use crate::pool::{is_used, iterate};
use crate::shape::FRESH;
use crate::state::{AssetTables, Cache, ContactRow, PAIRS_DROPPED, Pair, Scratch, State, Touch};
use bytemuck::Zeroable;

/// The body, or one of its island, must wake.
const WAKE: u8 = 1;
/// The body, or one of its island, may not sleep yet.
const RESTLESS: u8 = 1;

/// Wakes the islands that have to wake. The shapes' boxes are those of the step. Returns how many contacts came
/// back; their places are in the scratch.
pub(crate) fn wake(
    state: &mut State<'_>,
    (assets, dt): (&AssetTables<'_>, f32),
    (cache, scratch): (&mut Cache<'_>, &mut Scratch<'_>),
    counts: &mut Counts,
) -> usize {
    if state.header[0].asleep == 0 && state.header[0].asleep_pairs == 0 {
        return 0;
    }
    let called = state.header[0].wakes != 0;
    let high = state.header[0].bodies.high;
    scratch.marks[..high as usize].fill(0);
    let mut any = called && mark_called(state, scratch.marks);
    any |= mark_touched(state, (assets, dt), scratch);
    any |= mark_joined(state, scratch.marks);
    if any {
        unite_asleep(state, scratch.islands);
        rouse(state, scratch, counts);
    }
    if !any && !called {
        return 0;
    }
    state.header[0].wakes = 0;
    state.header[0].static_version += 1;
    (cache.header[0].moving_fits, cache.header[0].moving_listed) = (0, 0);
    cache.header[0].memos_fit = 0;
    place_woken(state, (assets, dt), scratch);
    bring_pairs(state, scratch, counts);
    bring_contacts(state, scratch, counts)
}

/// Marks what calls have woken, and what touches it. Clears the flags.
fn mark_called(state: &mut State<'_>, marks: &mut [u8]) -> bool {
    let mut any = false;
    let high = state.header[0].bodies.high;
    for slot in iterate(state.body_used, high) {
        let row = &state.bodies[slot as usize];
        if row.has(WAKES) && row.has(ASLEEP) {
            marks[slot as usize] = WAKE;
            any = true;
        }
    }
    for pair in &state.asleep_pairs[..state.header[0].asleep_pairs as usize] {
        let changed = |shape: u32| {
            let row = &state.shapes[shape as usize];
            !is_used(state.shape_used, shape)
                || row.flags & FRESH != 0
                || state.bodies[row.body as usize].has(WAKES)
        };
        for (shape, other) in [(pair.a, pair.b), (pair.b, pair.a)] {
            if changed(shape) && is_used(state.shape_used, other) {
                let body = state.shapes[other as usize].body as usize;
                if state.bodies[body].has(ASLEEP) {
                    marks[body] = WAKE;
                    any = true;
                }
            }
        }
    }
    for slot in 0..high as usize {
        state.bodies[slot].flags &= !WAKES;
    }
    any
}

/// True when a body pushes what it touches: awake, or a kinematic one that moves.
fn is_busy(row: &BodyRow, motion: &Motion) -> bool {
    row.is_active() || is_driven(row, motion)
}

/// True for a kinematic body that moves.
fn is_driven(row: &BodyRow, motion: &Motion) -> bool {
    row.kind() == BodyKind::Kinematic && (motion.linear != Vec3::ZERO || motion.angular != Vec3::ZERO)
}

/// Marks bodies that get points of contact with a busy one in this step, or with one that was put there.
fn mark_touched(state: &State<'_>, (assets, dt): (&AssetTables<'_>, f32), scratch: &mut Scratch<'_>) -> bool {
    let mut any = false;
    let mut found = Manifolds::new();
    let rules = Rules::new(state.materials, &state.pair_rules[..state.header[0].pair_rules as usize]);
    let lie = &state.asleep_pairs[..state.header[0].asleep_pairs as usize];
    let lies = |pair: Pair| lie.binary_search(&pair).is_ok();
    for &pair in &state.pairs[..state.header[0].pairs as usize] {
        let body = |shape: u32| state.shapes[shape as usize].body as usize;
        let busy = |slot: usize| is_busy(&state.bodies[slot], &state.motions[slot]);
        let (a, b) = (body(pair.a), body(pair.b));
        let sleeps = [a, b].map(|slot| state.bodies[slot].has(ASLEEP));
        if sleeps == [false; 2] {
            continue;
        }
        // Placed even where nothing wakes: the narrowphase sees by the reach that the body sleeps.
        for (shape, _) in [pair.a, pair.b].into_iter().zip(sleeps).filter(|(_, sleeps)| *sleeps) {
            place_shape(state, (assets, dt), scratch, shape);
        }
        let (sleeper, other) = if sleeps[0] { (a, b) } else { (b, a) };
        // What has rested there since it fell asleep does not wake it; what was put there does.
        if sleeps == [true; 2] || (!busy(other) && lies(pair)) {
            continue;
        }
        if scratch.marks[sleeper] != 0 || rules.ignore([a as u32, b as u32]) {
            continue;
        }
        let scene = Scene {
            shapes: state.shapes,
            motions: state.motions,
            frames: scratch.frames,
            reaches: scratch.reaches,
            first_joints: state.first_joints,
        };
        if !scene.may_touch(pair) {
            continue;
        }
        let slots = scene.in_order(pair);
        let solids = slots.map(|slot| solid(&state.shapes[slot as usize], assets));
        found.clear();
        let meeting = Meeting::new(&scene, slots, dt);
        meeting.collide((&solids[0], &solids[1]), &mut found);
        let shapes = (&state.shapes[slots[0] as usize], &state.shapes[slots[1] as usize]);
        if !found.is_empty() && rules.let_begin(shapes, &meeting.b_in_a, &found) {
            scratch.marks[sleeper] = WAKE;
            any = true;
        }
    }
    any
}

/// Marks bodies that a joint ties to a busy one.
fn mark_joined(state: &State<'_>, marks: &mut [u8]) -> bool {
    let mut any = false;
    for slot in iterate(state.joint_used, state.header[0].joints.high) {
        let joint = &state.joints[slot as usize];
        let [a, b] = joint.bodies.map(|body| body as usize);
        if joint.has(BROKEN) {
            continue;
        }
        for (one, other) in [(a, b), (b, a)] {
            let busy = is_busy(&state.bodies[other], &state.motions[other]);
            if state.bodies[one].has(ASLEEP) && busy {
                marks[one] = WAKE;
                any = true;
            }
        }
    }
    any
}

/// The least body of the set of a body.
pub(super) fn root(islands: &mut [u32], body: u32) -> u32 {
    let mut at = body;
    while islands[at as usize] != at {
        // Halves the way for the next one.
        islands[at as usize] = islands[islands[at as usize] as usize];
        at = islands[at as usize];
    }
    at
}

/// Makes the sets of two bodies one.
pub(super) fn unite(islands: &mut [u32], a: u32, b: u32) {
    let (a, b) = (root(islands, a), root(islands, b));
    islands[a.max(b) as usize] = a.min(b);
}

/// Sets of sleeping bodies that are joined by sleeping contacts and by joints.
fn unite_asleep(state: &State<'_>, islands: &mut [u32]) {
    let high = state.header[0].bodies.high;
    islands[..high as usize].iter_mut().zip(0..).for_each(|(root, slot)| *root = slot);
    let asleep = |body: u32| state.bodies[body as usize].has(ASLEEP);
    for row in &state.asleep_contacts[..state.header[0].asleep_contacts as usize] {
        if is_used(state.shape_used, row.pair.a) && is_used(state.shape_used, row.pair.b) {
            let [a, b] = [row.pair.a, row.pair.b].map(|shape| state.shapes[shape as usize].body);
            if asleep(a) && asleep(b) {
                unite(islands, a, b);
            }
        }
    }
    for slot in iterate(state.joint_used, state.header[0].joints.high) {
        let joint = &state.joints[slot as usize];
        let [a, b] = joint.bodies;
        if !joint.has(BROKEN) && asleep(a) && asleep(b) {
            unite(islands, a, b);
        }
    }
}

/// Wakes the islands of marked bodies. Their marks stay.
fn rouse(state: &mut State<'_>, scratch: &mut Scratch<'_>, counts: &mut Counts) {
    let high = state.header[0].bodies.high;
    for slot in 0..high {
        if scratch.marks[slot as usize] == WAKE {
            let root = root(scratch.islands, slot);
            scratch.marks[root as usize] = WAKE;
        }
    }
    for slot in 0..high {
        if state.bodies[slot as usize].has(ASLEEP) {
            let root = root(scratch.islands, slot);
            scratch.marks[slot as usize] = scratch.marks[root as usize];
            if scratch.marks[slot as usize] == WAKE {
                let row = &mut state.bodies[slot as usize];
                row.flags &= !ASLEEP;
                row.count_quiet(false);
                state.header[0].asleep -= 1;
                events::woke(state, counts, slot);
            }
        } else if events::is_roused(state, slot) {
            events::woke(state, counts, slot);
        }
    }
}

/// Computes frames and boxes of the shapes of bodies that woke, which the broadphase has passed over. They count as
/// far from the trees' sector: that may be another one by now than when the other shapes were placed.
fn place_woken(state: &State<'_>, (assets, dt): (&AssetTables<'_>, f32), scratch: &mut Scratch<'_>) {
    for slot in iterate(state.shape_used, state.header[0].shapes.high) {
        let body = state.shapes[slot as usize].body as usize;
        if scratch.marks[body] == WAKE {
            scratch.is_moved[slot as usize] &= !SLEEPS;
            place_shape(state, (assets, dt), scratch, slot);
        }
    }
}

/// What becomes of a pair in the arrays of what sleeps.
enum Fate {
    /// Both rest, and one of them sleeps.
    Sleeps,
    /// One of them is awake.
    Wakes,
    /// Neither can be pushed any more, or a shape was removed.
    Ends,
}

fn fate(state: &State<'_>, pair: Pair) -> Fate {
    if !is_used(state.shape_used, pair.a) || !is_used(state.shape_used, pair.b) {
        return Fate::Ends;
    }
    let [a, b] = [pair.a, pair.b].map(|shape| &state.bodies[state.shapes[shape as usize].body as usize]);
    if a.is_active() || b.is_active() {
        return Fate::Wakes;
    }
    if a.has(ASLEEP) || b.has(ASLEEP) { Fate::Sleeps } else { Fate::Ends }
}

/// Takes the pairs of what woke back.
fn bring_pairs(state: &mut State<'_>, scratch: &mut Scratch<'_>, counts: &mut Counts) {
    let before = state.header[0].asleep_pairs as usize;
    let (mut kept, mut count) = (0, 0);
    for i in 0..before {
        let pair = state.asleep_pairs[i];
        match fate(state, pair) {
            Fate::Sleeps => {
                state.asleep_pairs[kept] = pair;
                kept += 1;
            }
            Fate::Wakes if state.pairs[..state.header[0].pairs as usize].binary_search(&pair).is_err() => {
                scratch.found[count] = key(pair.a, pair.b);
                count += 1;
            }
            _ => {}
        }
    }
    state.asleep_pairs[kept..before].fill(Pair { a: 0, b: 0 });
    state.header[0].asleep_pairs = kept as u32;
    let own = state.header[0].pairs as usize;
    let room = state.pairs.len() - own;
    if count > room {
        counts.dropped_pairs += (count - room) as u32;
        state.header[0].pairs_stale |= PAIRS_DROPPED;
    }
    let count = count.min(room);
    let back = scratch.found[..count].iter().map(|&key| pair_of(key));
    merge_sorted(state.pairs, own, back, |pair| *pair);
    state.header[0].pairs = (own + count) as u32;
}

/// Takes the contacts of what woke back, and notes their places.
fn bring_contacts(state: &mut State<'_>, scratch: &mut Scratch<'_>, counts: &mut Counts) -> usize {
    let before = state.header[0].asleep_contacts as usize;
    let own = state.header[0].contacts as usize;
    let (mut kept, mut count) = (0, 0);
    for i in 0..before {
        let row = state.asleep_contacts[i];
        match fate(state, row.pair) {
            Fate::Sleeps => {
                state.asleep_contacts[kept] = row;
                kept += 1;
            }
            Fate::Wakes
                if state.contacts[..own].binary_search_by(|own| own.key().cmp(&row.key())).is_err() =>
            {
                scratch.rows_before[count] = row;
                count += 1;
            }
            Fate::Wakes => {}
            Fate::Ends => events::note(scratch.ended, &mut counts.ended, row.pair),
        }
    }
    state.asleep_contacts[kept..before].fill(ContactRow::zeroed());
    state.header[0].asleep_contacts = kept as u32;
    let room = state.contacts.len() - own;
    counts.dropped_contacts += count.saturating_sub(room) as u32;
    for row in &scratch.rows_before[count.min(room)..count] {
        events::note(scratch.ended, &mut counts.ended, row.pair);
    }
    let count = count.min(room);
    merge_sorted(state.contacts, own, scratch.rows_before[..count].iter().copied(), ContactRow::key);
    state.header[0].contacts = (own + count) as u32;
    // A contact without phase is one that was not there in the step before.
    let mut woken = 0;
    for (place, row) in (0..).zip(&state.contacts[..own + count]) {
        if row.tag.phase() == UNORDERED {
            scratch.woken[woken] = place;
            woken += 1;
        }
    }
    woken
}

/// Puts islands to sleep whose bodies have all been quiet for so many steps. `links` are those of the step.
pub(crate) fn fall(
    state: &mut State<'_>,
    (cache, scratch): (&mut Cache<'_>, &mut Scratch<'_>),
    (links, steps): (Links, u32),
    counts: &mut Counts,
) {
    let high = state.header[0].bodies.high;
    let mut driven = false;
    for slot in iterate(state.body_used, high) {
        let row = &state.bodies[slot as usize];
        scratch.islands[slot as usize] = slot;
        let quiet = row.quiet_steps() >= steps && !row.has(SLEEPLESS);
        scratch.marks[slot as usize] = if row.is_active() && quiet { 0 } else { RESTLESS };
        driven |= is_driven(row, &state.motions[slot as usize]);
    }
    unite_active(state, scratch, links, driven);
    for slot in iterate(state.body_used, high) {
        if state.bodies[slot as usize].is_active() && scratch.marks[slot as usize] == RESTLESS {
            let root = root(scratch.islands, slot);
            scratch.marks[root as usize] = RESTLESS;
        }
    }
    // From here on a mark is of the body's island.
    let mut falling = 0;
    for slot in iterate(state.body_used, high) {
        if state.bodies[slot as usize].is_active() {
            let root = root(scratch.islands, slot);
            scratch.marks[slot as usize] = scratch.marks[root as usize];
            falling += u32::from(scratch.marks[slot as usize] != RESTLESS);
        }
    }
    if falling > 0 && has_room(state, scratch.marks, links.contacts) {
        lay_down(state, scratch, links.contacts, counts);
        state.header[0].static_version += 1;
        (cache.header[0].moving_fits, cache.header[0].moving_listed) = (0, 0);
    }
}

/// True for a contact with a surface that moves on its body.
fn is_carried(state: &State<'_>, touch: &Touch) -> bool {
    let moves = |slot: u32| state.shapes[slot as usize].traits(state.materials).moves();
    touch.settled < 0.0 && touch.shapes.into_iter().any(moves)
}

/// Unites the bodies of the step's links; bodies that a moving kinematic one touches are restless.
fn unite_active(state: &State<'_>, scratch: &mut Scratch<'_>, links: Links, driven: bool) {
    let count = links.contacts + links.held();
    for (i, link) in scratch.slot_links[..count].iter().enumerate() {
        if i < links.contacts && is_carried(state, &scratch.touches[i]) {
            scratch.marks[link.a as usize] = RESTLESS;
        }
        if link.b != IMMOVABLE {
            unite(scratch.islands, link.a, link.b);
        } else if driven {
            let other = match i.checked_sub(links.contacts) {
                None => scratch.reaches[scratch.touches[i].shapes[1] as usize].body,
                Some(joint) => {
                    let [a, b] = state.joints[scratch.joint_slots[joint] as usize].bodies;
                    if a == link.a { b } else { a }
                }
            } as usize;
            if is_driven(&state.bodies[other], &state.motions[other]) {
                scratch.marks[link.a as usize] = RESTLESS;
            }
        }
    }
}

/// True when a pair goes with the bodies that fall asleep: both rest from now on, and one of them falls.
fn goes_along(state: &State<'_>, marks: &[u8], pair: Pair) -> bool {
    let mut falls = false;
    for shape in [pair.a, pair.b] {
        let body = state.shapes[shape as usize].body as usize;
        let row = &state.bodies[body];
        let own = row.is_active() && marks[body] != RESTLESS;
        falls |= own || row.has(ASLEEP);
        if !own && is_busy(row, &state.motions[body]) {
            return false;
        }
    }
    falls
}

/// True when the arrays of what sleeps have room.
fn has_room(state: &State<'_>, marks: &[u8], contacts: usize) -> bool {
    let header = &state.header[0];
    let pairs = state.pairs[..header.pairs as usize].iter().filter(|&&pair| goes_along(state, marks, pair));
    let rows = state.contacts[..contacts].iter().filter(|row| goes_along(state, marks, row.pair));
    header.asleep_pairs as usize + pairs.count() <= state.asleep_pairs.len()
        && header.asleep_contacts as usize + rows.count() <= state.asleep_contacts.len()
}

/// Moves pairs, copies contacts, and stops the bodies. The contacts end in the next step, for want of their pairs.
fn lay_down(state: &mut State<'_>, scratch: &mut Scratch<'_>, contacts: usize, counts: &mut Counts) {
    let before = state.header[0].pairs as usize;
    let (mut kept, mut count) = (0, 0);
    for i in 0..before {
        let pair = state.pairs[i];
        if goes_along(state, scratch.marks, pair) {
            scratch.found[count] = key(pair.a, pair.b);
            count += 1;
        } else {
            state.pairs[kept] = pair;
            kept += 1;
        }
    }
    state.pairs[kept..before].fill(Pair { a: 0, b: 0 });
    state.header[0].pairs = kept as u32;
    let own = state.header[0].asleep_pairs as usize;
    let back = scratch.found[..count].iter().map(|&key| pair_of(key));
    merge_sorted(state.asleep_pairs, own, back, |pair| *pair);
    state.header[0].asleep_pairs = (own + count) as u32;
    let mut count = 0;
    for i in 0..contacts {
        let mut row = state.contacts[i];
        if goes_along(state, scratch.marks, row.pair) {
            row.tag.set_phase(UNORDERED);
            scratch.rows_before[count] = row;
            count += 1;
        }
    }
    let own = state.header[0].asleep_contacts as usize;
    merge_sorted(state.asleep_contacts, own, scratch.rows_before[..count].iter().copied(), ContactRow::key);
    state.header[0].asleep_contacts = (own + count) as u32;
    for slot in 0..state.header[0].bodies.high {
        let index = slot as usize;
        if is_used(state.body_used, slot)
            && state.bodies[index].is_active()
            && scratch.marks[index] != RESTLESS
        {
            state.bodies[index].flags |= ASLEEP;
            state.motions[index].linear = Vec3::ZERO;
            state.motions[index].angular = Vec3::ZERO;
            state.header[0].asleep += 1;
            events::slept(state, counts, slot);
            events::note_slept(state, index);
        }
    }
}
