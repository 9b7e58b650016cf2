//! Narrowphase (the talk's second stage, SEED S3): contact points of every pair.
//!
//! Each pair has its own run of touches, so tasks are disjoint; impulses of the step before are carried over by
//! feature. Then the touches that fit become the contacts of the step, in the order of pair and child.

use crate::collide::{self, MANIFOLDS_MAX, Manifold, ManifoldPoint, Manifolds, POINTS_MAX};
use crate::config::SPECULATIVE_DISTANCE;
use crate::executor::{Executor, Stage};
use crate::math::{Pose, Vec3, length, max, sqrt};
use crate::pipeline::tasks::{Crew, Tasks, chunk, push};
use crate::pipeline::{Counts, solid, solver};
use crate::shape::{FRESH, GEOMETRY_BOX, ShapeRow};
use crate::state::{AssetTables, ContactRow, Pair, Scratch, State, Touch};
use bytemuck::Zeroable;

/// Pairs that are worth a task.
const COLLIDE_PAIRS: usize = 64;
/// Contacts that are worth a task to copy.
const COPY_CONTACTS: usize = 512;

pub(crate) fn run<E: Executor>(
    state: &mut State<'_>,
    assets: &AssetTables<'_>,
    scratch: &mut Scratch<'_>,
    (crew, counts): (&mut Crew<'_, E>, &mut Counts),
) {
    let pairs = state.header[0].pairs as usize;
    let touches = reserve(state, scratch, pairs);
    let dropped = collide_pairs(state, assets, scratch, crew);
    let contacts = choose(state, scratch, touches, counts);
    counts.dropped_contacts += dropped;
    copy_contacts(state, scratch, contacts, crew);
    for shape in &mut state.shapes[..state.header[0].shapes.high as usize] {
        shape.flags &= !FRESH;
    }
}

/// Gives every pair its run of touches: one for convex shapes, more for a concave one while there is room.
fn reserve(state: &State<'_>, scratch: &mut Scratch<'_>, pairs: usize) -> usize {
    let mut extra = scratch.touches.len() - pairs;
    let mut next = 0;
    for (i, pair) in state.pairs[..pairs].iter().enumerate() {
        scratch.pair_first[i] = next;
        let concave = |slot: u32| state.shapes[slot as usize].kind == crate::shape::GEOMETRY_MESH;
        let more = if concave(pair.a) || concave(pair.b) { extra.min(MANIFOLDS_MAX - 1) } else { 0 };
        extra -= more;
        next += 1 + more as u32;
    }
    scratch.pair_first[pairs] = next;
    next as usize
}

/// Fills the runs. Returns how many manifolds had no room in their run.
fn collide_pairs<E: Executor>(
    state: &State<'_>,
    assets: &AssetTables<'_>,
    scratch: &mut Scratch<'_>,
    crew: &mut Crew<'_, E>,
) -> u32 {
    struct Task<'a> {
        pairs: &'a [Pair],
        first: &'a [u32],
        touches: &'a mut [Touch],
        dropped: u32,
    }
    let dt = state.header[0].settings.read().map_or(0.0, |settings| settings.dt);
    let pairs = &state.pairs[..state.header[0].pairs as usize];
    let share = chunk(pairs.len(), COLLIDE_PAIRS);
    let mut rest = &mut *scratch.touches;
    let mut tasks: Tasks<Task<'_>> = Tasks::new();
    for (i, own) in pairs.chunks(share).enumerate() {
        let first = &scratch.pair_first[i * share..=i * share + own.len()];
        let count = (first[own.len()] - first[0]) as usize;
        let touches = solver::take(&mut rest, count);
        push(&mut tasks, Task { pairs: own, first, touches, dropped: 0 });
    }
    crew.run(Stage::Narrowphase, &mut tasks, |task| {
        let mut old = Old::new(state, task.pairs[0]);
        let mut rest = &mut *task.touches;
        for (i, &pair) in task.pairs.iter().enumerate() {
            let run = solver::take(&mut rest, (task.first[i + 1] - task.first[i]) as usize);
            task.dropped += collide_pair(state, assets, (pair, dt), (run, old.of(pair)));
        }
    });
    tasks.iter().map(|task| task.dropped).sum()
}

/// The contacts of the step before, read along with the pairs.
struct Old<'a> {
    rest: &'a [ContactRow],
}

impl<'a> Old<'a> {
    fn new(state: &'a State<'_>, from: Pair) -> Self {
        let rows = &state.contacts[..state.header[0].contacts as usize];
        Self { rest: &rows[rows.partition_point(|row| row.pair < from)..] }
    }

    /// The old contacts of a pair; pairs are asked for in ascending order.
    fn of(&mut self, pair: Pair) -> &'a [ContactRow] {
        let skip = self.rest.iter().take_while(|row| row.pair < pair).count();
        let rest = &self.rest[skip..];
        let count = rest.iter().take_while(|row| row.pair == pair).count();
        let (own, after) = rest.split_at(count);
        self.rest = after;
        own
    }
}

/// The relative pose of shape B's frame in shape A's, and how far apart points are looked for.
struct Meeting {
    /// Shape A's frame in world axes, relative to the center of body A.
    frame_a: Pose,
    b_in_a: Pose,
    /// From the center of body A to that of body B.
    centers: Vec3,
    distance: f32,
}

impl Meeting {
    fn new(state: &State<'_>, pair: Pair, dt: f32) -> Self {
        let (sa, sb) = (&state.shapes[pair.a as usize], &state.shapes[pair.b as usize]);
        let side = |s: &ShapeRow| (&state.bodies[s.body as usize], &state.motions[s.body as usize]);
        let ((ba, ma), (bb, mb)) = (side(sa), side(sb));
        let centers = mb.center.minus(ma.center);
        let frame_a = ma.local_to_center(ba, &sa.pose);
        let local = mb.local_to_center(bb, &sb.pose);
        let frame_b = Pose::new(local.position + centers, local.rotation);
        let b_in_a = Pose::new(
            frame_a.untransform(frame_b.position),
            frame_a.rotation.inverse().after(frame_b.rotation).normalized(),
        );
        // Fast bodies are stopped at the surface, not behind it: look as far as they come in this step.
        let distance = SPECULATIVE_DISTANCE + length(mb.linear - ma.linear) * dt;
        Self { frame_a, b_in_a, centers, distance }
    }
}

/// Fills the run of one pair; unused touches get no points. Returns how many manifolds had no room.
fn collide_pair(
    state: &State<'_>,
    assets: &AssetTables<'_>,
    (pair, dt): (Pair, f32),
    (run, old): (&mut [Touch], &[ContactRow]),
) -> u32 {
    let meeting = Meeting::new(state, pair, dt);
    let (sa, sb) = (&state.shapes[pair.a as usize], &state.shapes[pair.b as usize]);
    let mut manifolds = Manifolds::new();
    collide::collide(
        &solid(sa, assets),
        &solid(sb, assets),
        &meeting.b_in_a,
        meeting.distance,
        &mut manifolds,
    );
    // An old contact of a slot's former tenant, or of a changed shape, says nothing of this one.
    let fresh = (sa.flags | sb.flags) & FRESH != 0;
    let old = if fresh { &[] } else { old };
    for touch in run.iter_mut() {
        touch.row.points = 0;
    }
    for (touch, manifold) in run.iter_mut().zip(&manifolds) {
        *touch = touch_of(state, pair, &meeting, manifold);
        carry_over(&mut touch.row, old, &mut touch.kept);
    }
    manifolds.len().saturating_sub(run.len()) as u32
}

/// True when the solver's A is the body of shape B. A is dynamic; of two dynamic bodies it is the rounder one,
/// since the point of contact goes with A: the arm of a ball stays along the normal while it slides over a face.
fn are_exchanged(state: &State<'_>, (a, b): (&ShapeRow, &ShapeRow)) -> bool {
    let dynamic = |shape: &ShapeRow| state.bodies[shape.body as usize].is_dynamic();
    // Spheres come before capsules, and those before all others.
    let edges = |shape: &ShapeRow| shape.kind.min(GEOMETRY_BOX);
    !dynamic(a) || (dynamic(b) && edges(b) < edges(a))
}

fn touch_of(state: &State<'_>, pair: Pair, meeting: &Meeting, manifold: &Manifold) -> Touch {
    let (sa, sb) = (&state.shapes[pair.a as usize], &state.shapes[pair.b as usize]);
    let mut touch = Touch::zeroed();
    touch.row.pair = pair;
    touch.row.child = manifold.child;
    touch.row.points = manifold.points.len() as u32;
    touch.bodies = [sa.body, sb.body];
    touch.normal = meeting.frame_a.rotation.rotate(manifold.normal);
    touch.centers = meeting.centers;
    touch.friction = sqrt(sa.friction * sb.friction);
    touch.restitution = max(sa.restitution, sb.restitution);
    touch.exchanged = u32::from(are_exchanged(state, (sa, sb)));
    for (i, point) in manifold.points.iter().enumerate() {
        let ManifoldPoint { position, separation, feature } = *point;
        touch.anchors[i] = meeting.frame_a.transform(position);
        touch.separations[i] = separation;
        touch.row.features[i] = feature;
    }
    touch
}

/// Takes over the impulses of points whose features touched before. New points share what the lost ones carried.
///
/// Of a face's many corners four are chosen, and which four can change in every step: a load that was dropped each
/// time shook stacks of turned boxes until they crept (8 mm/s in a tower of ten).
fn carry_over(row: &mut ContactRow, old: &[ContactRow], kept: &mut u32) {
    let mut fresh: heapless::Vec<usize, POINTS_MAX> = heapless::Vec::new();
    for (i, feature) in row.features[..row.points as usize].iter().enumerate() {
        let place =
            |before: &ContactRow| before.features[..before.points as usize].iter().position(|f| f == feature);
        match old.iter().find_map(|before| place(before).map(|k| before.impulses[k])) {
            Some(impulse) => {
                row.impulses[i] = impulse;
                *kept = 1;
            }
            None => {
                let _ = fresh.push(i);
            }
        }
    }
    let Some(before) = old.iter().find(|before| before.child == row.child) else { return };
    row.friction = before.friction;
    row.twist = before.twist;
    *kept = 1;
    let stays = |feature: &u32| row.features[..row.points as usize].contains(feature);
    let mut lost = 0.0;
    for (feature, impulse) in before.features[..before.points as usize].iter().zip(before.impulses) {
        lost += if stays(feature) { 0.0 } else { impulse };
    }
    for &i in &fresh {
        row.impulses[i] = lost / fresh.len() as f32;
    }
}

/// Lists the touches that become contacts, in order. When there are too many, touching ones come before new ones,
/// then pair order decides.
fn choose(state: &State<'_>, scratch: &mut Scratch<'_>, touches: usize, counts: &mut Counts) -> usize {
    let room = state.contacts.len();
    let mut count = 0;
    for (i, touch) in scratch.touches[..touches].iter().enumerate() {
        if touch.row.points > 0 {
            scratch.candidates[count] = i as u32;
            count += 1;
        }
    }
    if count > room {
        let touches = &*scratch.touches;
        let candidates = &mut scratch.candidates[..count];
        candidates.sort_unstable_by_key(|&i| (touches[i as usize].kept == 0, i));
        counts.dropped_contacts += (count - room) as u32;
        count = room;
        scratch.candidates[..count].sort_unstable();
    }
    scratch.contact_touch[..count].copy_from_slice(&scratch.candidates[..count]);
    count
}

/// Writes the chosen touches' rows to the state.
fn copy_contacts<E: Executor>(
    state: &mut State<'_>,
    scratch: &Scratch<'_>,
    count: usize,
    crew: &mut Crew<'_, E>,
) {
    let before = state.header[0].contacts as usize;
    let (rows, rest) = state.contacts.split_at_mut(count);
    if before > count {
        rest[..before - count].fill(ContactRow::zeroed());
    }
    state.header[0].contacts = count as u32;
    let share = chunk(count, COPY_CONTACTS);
    let touches = &*scratch.touches;
    let mut tasks: Tasks<(&mut [ContactRow], &[u32])> =
        rows.chunks_mut(share).zip(scratch.contact_touch[..count].chunks(share)).collect();
    crew.run(Stage::Narrowphase, &mut tasks, |(rows, from)| {
        for (row, &touch) in rows.iter_mut().zip(*from) {
            *row = touches[touch as usize].row;
        }
    });
}
