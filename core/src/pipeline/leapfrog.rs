//! Bodies on joints that get half of a substep's push at the start of a step and the other half at its end.
//!
//! A substep pushes velocities and then moves by them. With the whole push first a pendulum is half a substep ahead
//! of its time: an error that falls as slowly as the substeps get shorter, and that is all there is to see where
//! joints hold exactly. A step that begins and ends with half a push is its own mirror image in time, so what is
//! left falls with the square (leapfrog; Stoermer and Verlet; with constraints: Andersen, RATTLE, 1983). What the
//! second half does to the joints is taken back by one more visit of them, which moves nothing.
//!
//! That needs rows that a visit solves exactly, whatever the impulses were before. So a body *leaps* when its
//! joints are of one articulation, or it has one joint; when all of those hold rigidly and nothing of them has
//! bounds; and when no body of them has a contact in this step. The others fall and bounce as their closed forms
//! say.
//!
//! Places are the same in both schemes: the velocities that a step leaves are those of its end where bodies leap,
//! and of half a substep before it where they do not. So the joints note which they are ([`LEAPT`], [`LAGS`]), and
//! who begins to leap starts its step with half of gravity's push more, who ends with half less. What leaps by
//! turns then moves as if it never did, and bounces or flicker pump no energy: with velocities taken as they are,
//! each blow on a floor would give half a push on the way in and another on the way out. Forces of the user act for
//! a step and are not moved to another, so that what was given is what arrives.

use crate::cells::{IMMOVABLE, Link};
use crate::config::Settings;
use crate::joint::{JointRow, LAGS, LEAPT};
use crate::lanes::{LANES, Lane, Mask};
use crate::pipeline::layout::EMPTY;
use crate::pipeline::ordering::Links;
use crate::state::{Cache, Scratch, State};

/// Bits of a body's mark; below them the number of its loose joints.
const HELD_BACK: u32 = 1 << 31;
const ARTICULATED: u32 = 1 << 30;
const LEAPS: u32 = 1 << 29;
/// The velocity is that of the end of the last step.
const WAS_EVEN: u32 = 1 << 28;
/// It is half a push behind.
const WAS_BEHIND: u32 = 1 << 27;

/// Marks the bodies that leap, by slot: see [`leaps`], and notes in the joints whether they do. The links of the
/// scratch are written.
pub(crate) fn mark(
    state: &mut State<'_>,
    (cache, scratch): (&Cache<'_>, &mut Scratch<'_>),
    (links, settings): (Links, &Settings),
) {
    if links.held() == 0 {
        return;
    }
    let relaxes = settings.relax_sweeps > 0;
    let marks = &mut scratch.joint_marks[..state.header[0].bodies.high as usize];
    marks.fill(0);
    let (contacts, joints) = scratch.slot_links[..links.contacts + links.held()].split_at(links.contacts);
    for body in contacts.iter().flat_map(ends) {
        marks[body] = HELD_BACK;
    }
    for (place, (link, &slot)) in joints.iter().zip(&*scratch.joint_slots).enumerate() {
        let is_rigid = relaxes && is_rigid(&state.joints[slot as usize]);
        for body in ends(link) {
            marks[body] = if place < links.joints { marks[body] + 1 } else { marks[body] | ARTICULATED };
            marks[body] |= if is_rigid { 0 } else { HELD_BACK };
        }
    }
    for link in &joints[..links.joints] {
        if ends(link).all(|body| marks[body] == 1) {
            ends(link).for_each(|body| marks[body] |= LEAPS);
        }
    }
    for row in &cache.articulations[..cache.header[0].articulations as usize] {
        for &first in row.first.iter().filter(|&&first| first != EMPTY) {
            let own = &joints[first as usize..(first + row.joints) as usize];
            let is_free = |body| marks[body] & !LEAPS == ARTICULATED;
            if own.iter().flat_map(ends).all(is_free) {
                own.iter().flat_map(ends).for_each(|body| marks[body] |= LEAPS);
            }
        }
    }
    for (link, &slot) in joints.iter().zip(&*scratch.joint_slots) {
        let joint = &mut state.joints[slot as usize];
        let before =
            if joint.has(LEAPT) { WAS_EVEN } else { 0 } | if joint.has(LAGS) { WAS_BEHIND } else { 0 };
        let mut leaps = false;
        for body in ends(link) {
            marks[body] |= before;
            leaps = marks[body] & LEAPS != 0;
        }
        joint.flags = joint.flags & !(LEAPT | LAGS) | if leaps { LEAPT } else { LAGS };
    }
}

/// The marks of a step that has joints.
pub(crate) fn in_use(marks: &[u32], links: Links) -> &[u32] {
    if links.held() > 0 { marks } else { &[] }
}

/// How many pushes of gravity the velocity of a body is behind what this step takes it for.
pub(crate) fn lag(marks: &[u32], slot: u32) -> f32 {
    match marks.get(slot as usize).map_or(0, |mark| mark & (LEAPS | WAS_EVEN | WAS_BEHIND)) {
        WAS_EVEN => -0.5,
        bits if bits == LEAPS | WAS_BEHIND => 0.5,
        _ => 0.0,
    }
}

/// True for a body with this mark that leaps.
pub(crate) fn leaps(marks: &[u32], slot: u32) -> bool {
    marks.get(slot as usize).is_some_and(|mark| mark & LEAPS != 0)
}

/// True for a body with this mark that leaps and has one joint. Its joint needs no warm start, and is better off
/// without: the impulses that a body has taken are known as a difference of its velocities, whose rounding would
/// go into the next substep's and so grow with the square of the substeps.
pub(crate) fn leaps_alone(marks: &[u32], slot: u32) -> bool {
    marks.get(slot as usize).is_some_and(|mark| mark & (LEAPS | ARTICULATED) == LEAPS)
}

/// The bodies of a link that move.
fn ends(link: &Link) -> impl Iterator<Item = usize> {
    [link.a, link.b].into_iter().filter(|&body| body != IMMOVABLE).map(|body| body as usize)
}

/// True for a joint that holds rigidly, and does nothing else.
fn is_rigid(joint: &JointRow) -> bool {
    let signature = joint.signature();
    signature.bound_rows() == 0 && signature.lock_rows() > 0 && !joint.spring.gives()
}

/// The lanes of some bits.
pub(crate) fn lanes_of(bits: u32) -> Mask {
    Lane::new(core::array::from_fn::<f32, LANES, _>(|lane| (bits >> lane & 1) as f32)).greater(Lane::ZERO)
}
