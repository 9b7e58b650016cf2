//! Islands that begin at rest: what has just been built has no loads yet to tell that it needs more substeps, and
//! no impulses to start its solve from. Its first steps decide: blocks that hang over within 1 % of balance turn
//! in them, and fall later.
//!
//! An island begins when all of its contacts that press are new in this step, its bodies and what it stands on are
//! at rest, it touches something immovable, and one of its bodies stands on another. What does not touch yet
//! presses nothing: bodies that are let fall are not refined before they lie and bear their loads, and bodies that
//! stand side by side and wait for a blow bear none.

use super::{BEGINS, STANDS, STAYS, WENT_ON, normal_impulse};
use crate::cells::{IMMOVABLE, Link};
use crate::config::Settings;
use crate::math::{PI, Vec3, length, min};
use crate::pipeline::contacts::NEW;
use crate::pipeline::meeting::frame_of;
use crate::pool::iterate;
use crate::state::{Cache, Memo, Scratch, State, Touch};

/// Linear and angular speed up to which a body is at rest, m/s and rad/s.
const REST_SPEED: f32 = 0.01;
/// Separation of points that touch, either way, metres: gravity closes such a gap in a step of 1/60 s. What
/// overlaps by more will be pushed apart, and does not rest.
const TOUCH: f32 = 1.0e-3;
/// Contacts that are looked through at once for new ones.
const RUN: usize = 32;
/// Least component of gravity's direction along the normal for one body to stand on the other.
const UPRIGHT: f32 = 0.5;

/// Marks what tells the islands that begin, in a step in which contacts began: bodies A of contacts, and bodies
/// that move. True when there may be such an island.
pub(super) fn mark(
    state: &State<'_>,
    (cache, scratch): (&Cache<'_>, &mut Scratch<'_>),
    settings: &Settings,
    contacts: usize,
) -> bool {
    let weight = length(settings.gravity);
    if weight == 0.0 {
        return false;
    }
    let down = settings.gravity / weight;
    let mut any = false;
    for first in (0..contacts).step_by(RUN) {
        let run = first..contacts.min(first + RUN);
        // In a pile few contacts begin in a step: most runs have none, which is seen without a branch for each.
        if !scratch.contact_from[run.clone()].iter().fold(false, |any, &from| any | (from == NEW)) {
            continue;
        }
        for index in run.filter(|&index| scratch.contact_from[index] == NEW) {
            let mark = mark_of(state, (cache, scratch), down, index);
            scratch.marks[scratch.slot_links[index].a as usize] |= mark;
            any |= mark == BEGINS;
        }
    }
    if any {
        mark_others(state, scratch, contacts);
    }
    any
}

/// The mark of a contact that is new in this step.
fn mark_of(state: &State<'_>, (cache, scratch): (&Cache<'_>, &Scratch<'_>), down: Vec3, index: usize) -> u8 {
    let touch = &scratch.touches[index];
    let ends = touch.shapes.map(|shape| state.shapes[shape as usize].body);
    if !ends.into_iter().all(|slot| is_at_rest(state, slot)) {
        return 0;
    }
    let memo = &cache.memos[cache.header[0].memo_half as usize * state.contacts.len() + index];
    let found = Touching::new(scratch, touch, (memo, state.contacts[index].tag.points()));
    match scratch.slot_links[index].b {
        _ if found.separation > TOUCH => 0,
        _ if found.separation < -TOUCH => WENT_ON,
        IMMOVABLE => STANDS,
        _ if found.normal.dot(down).abs() >= UPRIGHT => BEGINS,
        _ => 0,
    }
}

/// Marks what keeps an island from having begun: contacts of before, those with an impulse, and bodies that move.
fn mark_others(state: &State<'_>, scratch: &mut Scratch<'_>, contacts: usize) {
    let links = scratch.contact_from[..contacts].iter().zip(&*scratch.slot_links);
    for ((from, Link { a, .. }), row) in links.zip(&*state.contacts) {
        if *from != NEW || normal_impulse(row) != 0.0 {
            scratch.marks[*a as usize] |= WENT_ON;
        }
    }
    for slot in iterate(state.body_used, state.header[0].bodies.high) {
        scratch.marks[slot as usize] |= if is_at_rest(state, slot) { 0 } else { WENT_ON };
    }
}

/// True for a body that does not move.
fn is_at_rest(state: &State<'_>, slot: u32) -> bool {
    let motion = &state.motions[slot as usize];
    let limit = REST_SPEED * REST_SPEED;
    motion.linear.dot(motion.linear) <= limit && motion.angular.dot(motion.angular) <= limit
}

/// How many bodies have to stand on one another for the lowest contact between them to keep a stack refined.
pub(super) fn bodies_that_sink(settings: &Settings) -> f32 {
    let w = 2.0 * PI * settings.frequency();
    // F / (m* w^2) for each body above, the effective mass of two equal ones being half of one.
    let each = 2.0 * length(settings.gravity) / (w * w);
    if each > 0.0 { 1.0 + STAYS * settings.refine_sink / each } else { f32::MAX }
}

/// Least separation of a contact's points, metres, and its normal in the world.
struct Touching {
    separation: f32,
    normal: Vec3,
}

impl Touching {
    fn new(scratch: &Scratch<'_>, touch: &Touch, (memo, points): (&Memo, usize)) -> Self {
        let [a, b] = touch.shapes.map(|shape| frame_of(scratch.frames[shape as usize]));
        let normal = a.rotation.rotate(memo.normal);
        let separation = |i: usize| {
            if touch.settled == Touch::SETTLED {
                normal.dot(b.transform(memo.on_b[i]) + touch.centers - a.transform(memo.on_a[i]))
            } else {
                f32::from_bits(memo.tail[i])
            }
        };
        Self { separation: (0..points).map(separation).fold(f32::MAX, min), normal }
    }
}
