//! Refinement: small islands under great load have more substeps than the rest of the scene.
//!
//! Soft contacts sink by the load that they carry: `F / (m* w^2)` for a force F, an effective mass `m*` and the
//! natural frequency `w` that goes with the substeps. Where an island has a contact that would sink by more than
//! `Settings::refine_sink`, it is *refined*: its bodies make a tier of their own, with `Settings::refine` times the
//! substeps, and contacts that are stiffer by the square of it. Large islands stay as they are: for those the dial
//! is the substeps of all.
//!
//! An island that begins at rest has no loads yet, and is refined at once if a stack of as many bodies would stay
//! so (`refine/begins.rs`), until its loads say otherwise.
//!
//! Which bodies are refined is state. It is looked at every few steps, and whenever something refined touches
//! something that is not: an island has one tier. Impulses are those of a substep, and go along with its length.

mod begins;

use crate::body::BodyRow;
use crate::cells::{IMMOVABLE, Link};
use crate::config::{COARSEN_STEPS, REFINE_CONTACTS, REFINE_STEPS, STATIC_STIFFNESS, Settings};
use crate::joint::AxisRow;
use crate::math::PI;
use crate::pipeline::layout::{REFINED, TIERS};
use crate::pipeline::sleep::{root, unite};
use crate::pool::{is_used, iterate};
use crate::state::{Cache, ContactRow, Scratch, State};
use begins::bodies_that_sink;

/// Marks of islands: a contact sinks enough for the island to be refined.
const SINKS: u8 = 1;
/// Enough for it to stay refined.
const STILL_SINKS: u8 = 2;
/// One of the bodies is refined.
const WAS_REFINED: u8 = 4;
/// Of a body: its tier changes.
const CHANGES: u8 = 8;
/// Of islands: a body stands on another since this step.
const BEGINS: u8 = 16;
/// Something touches an immovable body since this step.
const STANDS: u8 = 32;
/// A contact was there before, or a body moves.
const WENT_ON: u8 = 64;

/// Share of the sink from which on an island is refined for it to stay so.
const STAYS: f32 = 0.5;

/// The tier of a dynamic body.
#[inline]
pub(crate) fn tier_of(state: &State<'_>, slot: u32) -> usize {
    if state.header[0].refine != 0 && is_used(state.refined, slot) { REFINED } else { 0 }
}

/// Brings the tiers to the loads of the step before, and to what begins. The scratch has the links of the step, of
/// so many contacts and of joints that hold something; `began` says whether contacts did.
pub(crate) fn run(
    state: &mut State<'_>,
    (cache, scratch): (&Cache<'_>, &mut Scratch<'_>),
    settings: &Settings,
    (contacts, held, began): (usize, usize, bool),
) {
    let before = state.header[0].refine;
    if settings.refine == 1 && before == 0 {
        return;
    }
    let substeps = if settings.refine == 1 { 0 } else { settings.of_tier(REFINED).substeps };
    let is_small = contacts <= REFINE_CONTACTS;
    let is_due = is_small || state.header[0].step.is_multiple_of(REFINE_STEPS) || substeps == 0;
    let crosses = || {
        let links = scratch.slot_links[..contacts].iter().chain(&scratch.held_links[..held]);
        before != 0 && links.clone().any(|link| crosses(state, link))
    };
    let looks = is_due || crosses();
    if !looks && !began {
        return;
    }
    let high = state.header[0].bodies.high as usize;
    scratch.marks[..high].fill(0);
    let sinks = looks && mark_loads(state, scratch, settings, if substeps == 0 { 0 } else { contacts });
    let begins = began && substeps != 0 && begins::mark(state, (cache, scratch), settings, contacts);
    if !begins && !(looks && (sinks || before != 0)) {
        return;
    }
    unite_all(state, scratch, (contacts, held));
    let stays = !state.header[0].step.is_multiple_of(COARSEN_STEPS);
    let most = if substeps == 0 { 0 } else { settings.refine_bodies };
    let any = decide(state, scratch, (most, stays, bodies_that_sink(settings)));
    let lengths = [settings.substeps, if substeps == 0 { before } else { substeps }];
    rescale(state, scratch, lengths, (contacts, held));
    for slot in iterate(state.body_used, high as u32) {
        if scratch.marks[slot as usize] & CHANGES != 0 {
            state.refined[slot as usize / 64] ^= 1 << (slot % 64);
        }
    }
    state.header[0].refine = if any { substeps } else { 0 };
}

/// True for a link between bodies of two tiers.
fn crosses(state: &State<'_>, link: &Link) -> bool {
    link.a != IMMOVABLE && link.b != IMMOVABLE && tier_of(state, link.a) != tier_of(state, link.b)
}

/// Marks bodies A of contacts that soft contacts would let sink too far, now and at the last look: a load that
/// lasts, and no blow. True when there is one.
fn mark_loads(
    state: &mut State<'_>,
    scratch: &mut Scratch<'_>,
    settings: &Settings,
    contacts: usize,
) -> bool {
    let words = crate::pool::words(state.header[0].bodies.high as usize);
    scratch.loaded_now[..words].fill(0);
    let w = 2.0 * PI * settings.frequency();
    // Metres for each unit of impulse and yield, by tier.
    let scales = settings.tiers().map(|tier| 1.0 / (tier.substep() * w * w));
    let yields = |row: &BodyRow| 1.0 / row.mass;
    let mut any = false;
    for (row, link) in state.contacts[..contacts].iter().zip(&*scratch.slot_links) {
        let impulse = normal_impulse(row);
        if impulse == 0.0 {
            continue;
        }
        let yields = match link.b {
            IMMOVABLE => yields(&state.bodies[link.a as usize]) / (STATIC_STIFFNESS * STATIC_STIFFNESS),
            b => yields(&state.bodies[link.a as usize]) + yields(&state.bodies[b as usize]),
        };
        let sink = impulse * yields * scales[tier_of(state, link.a)];
        if sink > STAYS * settings.refine_sink {
            let enough = sink > settings.refine_sink;
            let lasts = enough && is_used(state.loaded, link.a);
            scratch.loaded_now[link.a as usize / 64] |= u64::from(enough) << (link.a % 64);
            scratch.marks[link.a as usize] |= STILL_SINKS | if lasts { SINKS } else { 0 };
            any |= lasts;
        }
    }
    state.loaded[..words].copy_from_slice(&scratch.loaded_now[..words]);
    any
}

/// Sum over the points, N s.
fn normal_impulse(row: &ContactRow) -> f32 {
    row.impulses[..row.tag.points()].iter().fold(0.0, |sum, impulse| sum + impulse)
}

/// Finds the islands of the step's links.
fn unite_all(state: &State<'_>, scratch: &mut Scratch<'_>, (contacts, held): (usize, usize)) {
    for slot in iterate(state.body_used, state.header[0].bodies.high) {
        scratch.islands[slot as usize] = slot;
        scratch.island_sizes[slot as usize] = 0;
    }
    for link in scratch.slot_links[..contacts].iter().chain(&scratch.held_links[..held]) {
        if link.a != IMMOVABLE && link.b != IMMOVABLE {
            unite(scratch.islands, link.a, link.b);
        }
    }
}

/// Marks the bodies whose tier changes: islands of so many bodies at most are refined, those that are stay so if
/// `stays`, and those that begin have `enough` bodies. True when some body is refined from now on.
fn decide(state: &State<'_>, scratch: &mut Scratch<'_>, (bodies, stays, enough): (u32, bool, f32)) -> bool {
    let high = state.header[0].bodies.high;
    let is_active = |slot: u32| state.bodies[slot as usize].is_active();
    for slot in iterate(state.body_used, high).filter(|&slot| is_active(slot)) {
        let own = if tier_of(state, slot) == REFINED { WAS_REFINED } else { 0 };
        let root = root(scratch.islands, slot) as usize;
        scratch.marks[root] |= scratch.marks[slot as usize] | own;
        scratch.island_sizes[root] += 1;
    }
    let mut any = false;
    for slot in iterate(state.body_used, high) {
        let was = tier_of(state, slot) == REFINED;
        // Who sleeps stays as he is; who does not move any more has no tier.
        let is = if is_active(slot) {
            let root = root(scratch.islands, slot) as usize;
            let marks = scratch.marks[root];
            let still = marks & WAS_REFINED != 0 && (stays || marks & STILL_SINKS != 0);
            let size = scratch.island_sizes[root];
            let begins = marks & (BEGINS | STANDS | WENT_ON) == BEGINS | STANDS && size as f32 >= enough;
            (marks & SINKS != 0 || still || begins) && size <= bodies
        } else {
            was && bodies > 0 && state.bodies[slot as usize].is_dynamic()
        };
        any |= is;
        let own = &mut scratch.marks[slot as usize];
        *own = *own & !CHANGES | if is != was { CHANGES } else { 0 };
    }
    any
}

/// Impulses of those that change their tier: those of a substep of another length.
fn rescale(
    state: &mut State<'_>,
    scratch: &Scratch<'_>,
    [coarse, fine]: [u32; TIERS],
    (contacts, held): (usize, usize),
) {
    let ratio = coarse as f32 / fine as f32;
    let refined = &*state.refined;
    // The first end moves, or the second does.
    let factor = |link: &Link| {
        let slot = if link.a == IMMOVABLE { link.b } else { link.a };
        let changes = scratch.marks[slot as usize] & CHANGES != 0;
        changes.then(|| if is_used(refined, slot) { 1.0 / ratio } else { ratio })
    };
    for (row, link) in state.contacts[..contacts].iter_mut().zip(&*scratch.slot_links) {
        if let Some(factor) = factor(link) {
            scale(row, factor);
        }
    }
    for (&slot, link) in scratch.held_slots[..held].iter().zip(&*scratch.held_links) {
        if let Some(factor) = factor(link) {
            let joint = &mut state.joints[slot as usize];
            joint.impulses = joint.impulses.map(|impulse| impulse * factor);
            joint.cone_impulse *= factor;
            state.joint_axes[slot as usize].iter_mut().for_each(|axis| scale_axis(axis, factor));
        }
    }
}

fn scale(row: &mut ContactRow, factor: f32) {
    if row.can_resist() {
        row.set_resistance(row.resistance() * factor);
    }
    for impulse in &mut row.impulses[..row.tag.points()] {
        *impulse *= factor;
    }
    row.friction *= factor;
    row.twist *= factor;
}

fn scale_axis(axis: &mut AxisRow, factor: f32) {
    for impulse in [&mut axis.limit_impulse, &mut axis.drive_impulse, &mut axis.friction_impulse] {
        *impulse *= factor;
    }
}
