//! Broadphase (the talk's first stage, SEED S2): which shapes may touch, by boxes.
//!
//! Every shape has a *fat* box in the state, larger than the shape by a margin. A step makes new boxes only for
//! shapes that left theirs; pairs between other shapes stay. The pairs of the moved ones are found anew in two
//! trees (shapes of static bodies, and the rest), which are cache. Pairs are a sorted set, so the shape of a tree
//! never matters.

use crate::body::{ASLEEP, BodyKind, BodyRow, CHANGED_SECTOR, Motion, Position, turned_frame};
use crate::collide::tree::{self, Tree};
use crate::config::SPECULATIVE_DISTANCE;
use crate::executor::{Executor, Stage};
use crate::lanes::Words;
use crate::math::{Aabb, Pose, Rotation, Vec3};
use crate::pipeline::joints::are_joined;
use crate::pipeline::meeting::{frame_words, reach_radius};
use crate::pipeline::tasks::{Crew, TASKS_MAX, Tasks, chunk, push};
use crate::pipeline::{Counts, solid};
use crate::pool::is_used;
use crate::shape::{BOX_STALE, GEOMETRY_BOX, GEOMETRY_HULL, ShapeRow};
use crate::state::{AssetTables, Cache, ContactRow, PAIRS_DROPPED, Pair, Reach, Scratch, State};

/// Marks a shape that left its box, or was changed.
pub(crate) const MOVED: u8 = 1;
/// Marks a slot without a shape.
const GONE: u8 = 2;
/// Marks a shape whose body sleeps, unless it wakes in this step: it has no place in the scratch, and gets no
/// contacts.
pub(crate) const SLEEPS: u8 = 4;
/// Sectors from the trees' own to where boxes are rounded by 4 mm: 32 km.
const HOME_SECTORS: u32 = 512;
/// Shapes for which updating boxes is worth a task.
const UPDATE_SHAPES: usize = 256;
/// Moved shapes for which a search is worth a task.
const SEARCH_SHAPES: usize = 64;

/// Brings the pairs up to date. Says how many shapes left their boxes: they are listed in the scratch.
pub(crate) fn run<E: Executor>(
    state: &mut State<'_>,
    (assets, dt): (&AssetTables<'_>, f32),
    (cache, scratch): (&mut Cache<'_>, &mut Scratch<'_>),
    (crew, counts): (&mut Crew<'_, E>, &mut Counts),
) -> usize {
    let had_stances = asks_for_stances(state);
    update_boxes(state, (assets, dt), (cache.header[0].sector, scratch), crew);
    let (moved, statics_moved) = list_moved(state, scratch);
    if moved == 0 && state.header[0].pairs_stale == 0 {
        return 0;
    }
    if statics_moved {
        state.header[0].static_version += 1;
    }
    cache.header[0].moving_fits = 0;
    let sector_of = |body: u32| state.motions[body as usize].center.sector;
    refresh_trees((state, sector_of), cache, (scratch.tree_boxes, scratch.tree_keys));
    find_pairs(state, cache, scratch, (moved, crew, counts));
    if !had_stances {
        place_stances(state, scratch);
    }
    clear_flags(state, &scratch.moved[..moved]);
    moved
}

/// Computes the shapes' frames, makes new boxes for shapes that left theirs, and marks those.
fn update_boxes<E: Executor>(
    state: &mut State<'_>,
    (assets, dt): (&AssetTables<'_>, f32),
    (home, scratch): ([i32; 3], &mut Scratch<'_>),
    crew: &mut Crew<'_, E>,
) {
    struct Task<'a> {
        first: u32,
        shapes: &'a mut [ShapeRow],
        is_moved: &'a mut [u8],
        frames: &'a mut [Words],
        stances: &'a mut [Words],
        reaches: &'a mut [Reach],
    }
    let high = state.header[0].shapes.high as usize;
    let share = chunk(high, UPDATE_SHAPES);
    let all = state.header[0].pairs_stale & PAIRS_DROPPED != 0;
    let asks = asks_for_stances(state);
    let (used, bodies, motions) = (&*state.shape_used, &*state.bodies, &*state.motions);
    let mut tasks: Tasks<Task<'_>> = Tasks::new();
    let parts = state.shapes[..high].chunks_mut(share).zip(scratch.is_moved[..high].chunks_mut(share));
    let frames = scratch.frames[..high].chunks_mut(share).zip(scratch.stances[..high].chunks_mut(share));
    let parts = parts.zip(frames.zip(scratch.reaches[..high].chunks_mut(share)));
    for (i, ((shapes, is_moved), ((frames, stances), reaches))) in parts.enumerate() {
        push(&mut tasks, Task { first: (i * share) as u32, shapes, is_moved, frames, stances, reaches });
    }
    crew.run(Stage::Broadphase, &mut tasks, |task| {
        let frames = task.frames.iter_mut().zip(task.stances.iter_mut()).zip(task.reaches.iter_mut());
        let slots = task.shapes.iter_mut().zip(task.is_moved.iter_mut()).zip(frames);
        for (i, ((shape, moved), ((frame, stance), reach))) in slots.enumerate() {
            *moved = GONE;
            if is_used(used, task.first + i as u32) {
                let (body, motion) = (&bodies[shape.body as usize], &motions[shape.body as usize]);
                *moved = if body.has(ASLEEP) { SLEEPS } else { 0 };
                if body.has(ASLEEP) && !is_stale(shape, body) {
                    continue;
                }
                let bounds;
                ((*frame, *reach), bounds) = place_of(shape, (body, motion), (assets, dt, home));
                if asks {
                    *stance = stance_of(shape, body, *frame);
                }
                *moved |= if update_box(shape, body, &bounds) || all { MOVED } else { 0 };
            }
        }
    });
}

/// True when contacts may ask for frames in stances: those of the pairs that there are, or that wake.
fn asks_for_stances(state: &State<'_>) -> bool {
    state.header[0].pairs > 0 || state.header[0].asleep > 0
}

/// Frames in the bodies' stances of the shapes that have pairs, where none had in the step before.
fn place_stances(state: &State<'_>, scratch: &mut Scratch<'_>) {
    for pair in &state.pairs[..state.header[0].pairs as usize] {
        for slot in [pair.a as usize, pair.b as usize] {
            let shape = &state.shapes[slot];
            scratch.stances[slot] =
                stance_of(shape, &state.bodies[shape.body as usize], scratch.frames[slot]);
        }
    }
}

/// The frame of a shape in its body's stance; `frame` is that in its orientation, which serves for shapes whose
/// contacts never settle.
#[inline(always)]
fn stance_of(shape: &ShapeRow, body: &BodyRow, frame: Words) -> Words {
    if !matches!(shape.kind, GEOMETRY_BOX | GEOMETRY_HULL) {
        return frame;
    }
    match Rotation::unpack(body.stance) {
        Some(rotation) if body.is_dynamic() => frame_words(&turned_frame(rotation, body, &shape.pose)),
        _ => frame,
    }
}

/// The frame of a shape and its reach; and its bounds.
#[inline(always)]
fn place_of(
    shape: &ShapeRow,
    (body, motion): (&BodyRow, &Motion),
    (assets, dt, home): (&AssetTables<'_>, f32, [i32; 3]),
) -> ((Words, Reach), Bounds) {
    let pose = motion.local_to_center(body, &shape.pose);
    let frame = frame_words(&pose);
    let bounds = reach_of(shape, (body, motion, &pose), (assets, dt));
    let is_home = u32::from(motion.center.sector == home);
    let flags = (Reach::HOME * is_home) | (Reach::DYNAMIC * u32::from(body.is_dynamic()));
    let (min, max) = (bounds.reach.min, bounds.reach.max);
    let origin = pose.position + motion.center.offset;
    let radius = reach_radius(shape, (motion, assets, dt));
    ((frame, Reach { min, body: shape.body, max, flags, origin, radius }), bounds)
}

/// Computes frame and reach of a shape that the update of boxes has passed over, because its body slept. It counts
/// as far from the trees' sector.
pub(crate) fn place_shape(
    state: &State<'_>,
    (assets, dt): (&AssetTables<'_>, f32),
    scratch: &mut Scratch<'_>,
    slot: u32,
) {
    let shape = &state.shapes[slot as usize];
    let body = (&state.bodies[shape.body as usize], &state.motions[shape.body as usize]);
    let index = slot as usize;
    let (place, _) = place_of(shape, body, (assets, dt, [i32::MAX; 3]));
    (scratch.frames[index], scratch.reaches[index]) = place;
    scratch.stances[index] = stance_of(shape, body.0, scratch.frames[index]);
}

/// Where a shape is in the step.
struct Bounds {
    /// Its box over the way of the step.
    swept: Aabb,
    /// The same as far as contacts are looked for.
    reach: Aabb,
}

/// The bounds of a shape whose frame stands at `local` from the body's center.
fn reach_of(
    shape: &ShapeRow,
    (body, motion, local): (&BodyRow, &Motion, &Pose),
    (assets, dt): (&AssetTables<'_>, f32),
) -> Bounds {
    let is_static = body.kind() == BodyKind::Static;
    if is_static && !is_stale(shape, body) {
        return Bounds { swept: shape.fat_box, reach: shape.fat_box };
    }
    let pose = Pose::new(local.position + motion.center.offset, local.rotation);
    let tight = crate::collide::bounds::aabb(&solid(shape, assets), &pose);
    // The box reaches as far as contacts are looked for: over the coming step's path and the speculative distance.
    let path = if is_static { Vec3::ZERO } else { motion.linear * dt };
    let swept = tight.union(&Aabb { min: tight.min + path, max: tight.max + path });
    Bounds { swept, reach: swept.grown(SPECULATIVE_DISTANCE) }
}

fn is_stale(shape: &ShapeRow, body: &BodyRow) -> bool {
    shape.flags & BOX_STALE != 0 || body.has(CHANGED_SECTOR)
}

/// Makes a new fat box if the shape left its own; true when it did.
fn update_box(shape: &mut ShapeRow, body: &BodyRow, bounds: &Bounds) -> bool {
    if !is_stale(shape, body) && shape.fat_box.contains(&bounds.reach) {
        return false;
    }
    shape.fat_box = bounds.swept.grown(ShapeRow::margin(body.kind() != BodyKind::Static));
    true
}

/// Lists the marked shapes; says how many, and whether one belongs to a static body.
fn list_moved(state: &State<'_>, scratch: &mut Scratch<'_>) -> (usize, bool) {
    let high = state.header[0].shapes.high as usize;
    let (mut count, mut statics) = (0, false);
    for slot in 0..high {
        if scratch.is_moved[slot] & MOVED != 0 {
            scratch.moved[count] = slot as u32;
            count += 1;
            let body = state.shapes[slot].body as usize;
            statics |= state.bodies[body].rests();
        }
    }
    (count, statics)
}

fn clear_flags(state: &mut State<'_>, moved: &[u32]) {
    for &slot in moved {
        state.shapes[slot as usize].flags &= !BOX_STALE;
        let body = state.shapes[slot as usize].body as usize;
        state.bodies[body].flags &= !CHANGED_SECTOR;
    }
}

/// Brings both trees to the boxes in the state, which are given in the sectors of their bodies.
pub(crate) fn refresh_trees(
    (state, sector_of): (&State<'_>, impl Fn(u32) -> [i32; 3]),
    cache: &mut Cache<'_>,
    (boxes, keys): (&mut [Aabb], &mut [u64]),
) {
    let stamp = state.header[0].static_version + 1;
    let mut statics_fit = cache.header[0].static_stamp == stamp;
    if !statics_fit || cache.header[0].moving_fits == 0 {
        let home = home_sector(state);
        // What moves may have gone far from where the trees count from.
        statics_fit &= !is_far(home, cache.header[0].sector);
        if !statics_fit {
            cache.header[0].sector = home;
            cache.header[0].moving_fits = 0;
        }
    }
    let sector = cache.header[0].sector;
    for is_static in [true, false] {
        let fits = if is_static { statics_fit } else { cache.header[0].moving_fits != 0 };
        if fits {
            continue;
        }
        let header = &mut cache.header[0];
        let (order, nodes) = if is_static {
            (&mut *cache.static_order, &mut *cache.static_nodes)
        } else {
            (&mut *cache.moving_order, &mut *cache.moving_nodes)
        };
        let belongs = |slot: &u32| {
            let body = state.shapes[*slot as usize].body as usize;
            state.bodies[body].rests() == is_static
        };
        let used = || crate::pool::iterate(state.shape_used, state.header[0].shapes.high).filter(belongs);
        for slot in used() {
            let shape = &state.shapes[slot as usize];
            boxes[slot as usize] = box_between(shape, sector_of(shape.body), sector);
        }
        let leaves = tree::build(boxes, used(), keys, order, nodes) as u32;
        if is_static {
            header.static_leaves = leaves;
            header.static_stamp = stamp;
        } else {
            header.moving_leaves = leaves;
            (header.moving_fits, header.moving_listed) = (1, 1);
        }
    }
}

/// The sector in which the trees count their coordinates: that of a shape that moves, from the middle of the slots
/// if there is one, or of the first one where nothing moves. It decides how much boxes are rounded, never which
/// overlap; so it has to be near what moves, wherever the scene is, and wherever the ground's own middle is.
pub(crate) fn home_sector(state: &State<'_>) -> [i32; 3] {
    let shapes = || crate::pool::iterate(state.shape_used, state.header[0].shapes.high);
    let body = |slot: u32| state.shapes[slot as usize].body as usize;
    let moves = |slot: u32| !state.bodies[body(slot)].rests();
    let middle = state.header[0].shapes.high / 2;
    let slot = shapes().find(|&slot| slot >= middle && moves(slot));
    let slot = slot.or_else(|| shapes().find(|&slot| moves(slot))).or_else(|| shapes().next());
    slot.map_or([0; 3], |slot| state.motions[body(slot)].center.sector)
}

/// True when coordinates of one sector are better not counted in another.
fn is_far(a: [i32; 3], b: [i32; 3]) -> bool {
    a.iter().zip(b).any(|(a, b)| a.abs_diff(b) > HOME_SECTORS)
}

/// A shape's fat box in the tree's coordinates, never smaller than it is.
pub(crate) fn tree_box(state: &State<'_>, slot: u32, sector: [i32; 3]) -> Aabb {
    let shape = &state.shapes[slot as usize];
    box_between(shape, state.motions[shape.body as usize].center.sector, sector)
}

/// The fat box of a shape, given in one sector, in another one.
fn box_between(shape: &ShapeRow, from: [i32; 3], sector: [i32; 3]) -> Aabb {
    let shift = Position { sector: from, offset: Vec3::ZERO }.minus(Position { sector, offset: Vec3::ZERO });
    if shift == Vec3::ZERO {
        return shape.fat_box;
    }
    // Far from the tree's sector the sum is rounded: grow by more than its last bit.
    let min = shape.fat_box.min + shift;
    let max = shape.fat_box.max + shift;
    let slack = |v: Vec3| v.abs() * 2.4e-7;
    Aabb { min: min - slack(min), max: max + slack(max) }
}

/// True when two shapes' fat boxes overlap, whatever their sectors.
pub(crate) fn boxes_overlap(state: &State<'_>, a: u32, b: u32) -> bool {
    let (sa, sb) = (&state.shapes[a as usize], &state.shapes[b as usize]);
    let sector =
        |s: &ShapeRow| Position { sector: state.motions[s.body as usize].center.sector, offset: Vec3::ZERO };
    let shift = sector(sb).minus(sector(sa));
    let moved = Aabb { min: sb.fat_box.min + shift, max: sb.fat_box.max + shift };
    sa.fat_box.overlaps(&moved)
}

/// True when two shapes can make contacts at all.
#[inline(always)]
pub(crate) fn may_meet(state: &State<'_>, a: u32, b: u32) -> bool {
    let (sa, sb) = (&state.shapes[a as usize], &state.shapes[b as usize]);
    let dynamic = |s: &ShapeRow| state.bodies[s.body as usize].is_dynamic();
    sa.body != sb.body
        && (dynamic(sa) || dynamic(sb))
        && !(sa.is_surface() && sb.is_surface())
        && !(sa.is_sensor() || sb.is_sensor())
        && sa.filter.meets(&sb.filter)
        && !are_joined(state, sa.body, sb.body)
}

pub(crate) fn key(a: u32, b: u32) -> u64 {
    u64::from(a.min(b)) << 32 | u64::from(a.max(b))
}

pub(crate) fn pair_of(key: u64) -> Pair {
    Pair { a: (key >> 32) as u32, b: key as u32 }
}

/// Replaces the pairs of moved shapes.
fn find_pairs<E: Executor>(
    state: &mut State<'_>,
    cache: &Cache<'_>,
    scratch: &mut Scratch<'_>,
    (moved, crew, counts): (usize, &mut Crew<'_, E>, &mut Counts),
) {
    let statics = tree_of(cache.static_nodes, cache.static_order, cache.header[0].static_leaves);
    let moving = tree_of(cache.moving_nodes, cache.moving_order, cache.header[0].moving_leaves);
    let search = Search {
        state,
        trees: [statics, moving],
        sector: cache.header[0].sector,
        is_moved: scratch.is_moved,
    };
    let moved = &scratch.moved[..moved];
    let found = match search.all(moved, scratch.found, crew) {
        Some(found) => found,
        None => search.best(moved, scratch.found, counts),
    };
    scratch.found[..found].sort_unstable();
    merge(state, scratch, found, counts);
}

/// The search for pairs of moved shapes.
struct Search<'a> {
    state: &'a State<'a>,
    /// Of static bodies, and of the rest.
    trees: [Tree<'a>; 2],
    /// The trees' sector.
    sector: [i32; 3],
    is_moved: &'a [u8],
}

impl Search<'_> {
    /// Visits the keys of the new pairs of one moved shape. A pair of two moved shapes is the lower one's.
    fn of(&self, slot: u32, mut visit: impl FnMut(u64)) {
        let state = self.state;
        let region = tree_box(state, slot, self.sector);
        let mut found = |other: u32| {
            let twice = self.is_moved[other as usize] & MOVED != 0 && other < slot;
            let new = other != slot && !twice && self.is_moved[other as usize] != GONE;
            if new && may_meet(state, slot, other) && boxes_overlap(state, slot, other) {
                visit(key(slot, other));
            }
        };
        self.trees.iter().for_each(|tree| tree.query(&region, &mut found));
    }

    /// Writes all keys, in no order. `None` when they do not fit.
    ///
    /// Every task has a part of the room; where one's is too small, its count says so, and the room is cut again by
    /// the counts.
    fn all<E: Executor>(&self, moved: &[u32], keys: &mut [u64], crew: &mut Crew<'_, E>) -> Option<usize> {
        let share = chunk(moved.len(), SEARCH_SHAPES);
        let even = keys.len() / moved.len().div_ceil(share).max(1);
        let mut counts = [even; TASKS_MAX];
        let fits = self.search(moved, (keys, &mut counts), crew);
        let counts = &mut counts[..moved.len().div_ceil(share)];
        let total: usize = counts.iter().sum();
        if total > keys.len() {
            return None;
        }
        if fits {
            let mut end = 0;
            for (task, &count) in counts.iter().enumerate() {
                keys.copy_within(task * even..task * even + count, end);
                end += count;
            }
        } else {
            let mut places = [0; TASKS_MAX];
            places[..counts.len()].copy_from_slice(counts);
            self.search(moved, (keys, &mut places), crew);
        }
        Some(total)
    }

    /// Each task writes its keys to its part of the room, `parts` long, as far as they fit; `parts` become the
    /// numbers of keys. True when all fitted.
    fn search<E: Executor>(
        &self,
        moved: &[u32],
        (keys, parts): (&mut [u64], &mut [usize; TASKS_MAX]),
        crew: &mut Crew<'_, E>,
    ) -> bool {
        let share = chunk(moved.len(), SEARCH_SHAPES);
        let mut rest = keys;
        let mut tasks: Tasks<(&[u32], &mut [u64], usize)> = Tasks::new();
        for (shapes, &part) in moved.chunks(share).zip(&*parts) {
            push(&mut tasks, (shapes, crate::pipeline::solver::take(&mut rest, part), 0));
        }
        crew.run(Stage::Broadphase, &mut tasks, |(shapes, keys, count)| {
            for &slot in *shapes {
                self.of(slot, |key| {
                    if let Some(place) = keys.get_mut(*count) {
                        *place = key;
                    }
                    *count += 1;
                });
            }
        });
        let fits = tasks.iter().all(|(_, keys, count)| *count <= keys.len());
        for (part, (_, _, count)) in parts.iter_mut().zip(&tasks) {
            *part = *count;
        }
        fits
    }

    /// Writes the best keys, as they come, when there are too many.
    fn best(&self, moved: &[u32], keys: &mut [u64], counts: &mut Counts) -> usize {
        let contacts = contacts_of(self.state);
        let mut best = Best { keys, count: 0, dropped: 0, room: self.state.pairs.len() };
        for &slot in moved {
            self.of(slot, |key| best.add(key, contacts));
        }
        best.cut(contacts);
        counts.dropped_pairs += best.dropped;
        best.count
    }
}

pub(crate) fn tree_of<'a>(nodes: &'a [Aabb], order: &'a [u32], leaves: u32) -> Tree<'a> {
    let leaves = leaves as usize;
    Tree { nodes: &nodes[..tree::node_count(leaves)], order: &order[..leaves] }
}

fn contacts_of<'a>(state: &'a State<'_>) -> &'a [ContactRow] {
    &state.contacts[..state.header[0].contacts as usize]
}

/// True when the pair had a contact in the step before.
fn touches(contacts: &[ContactRow], pair: Pair) -> bool {
    contacts.binary_search_by(|row| row.pair.cmp(&pair)).is_ok()
}

/// The best keys of a stream that is longer than the buffer: touching pairs first, then pair order.
struct Best<'a> {
    keys: &'a mut [u64],
    count: usize,
    dropped: u32,
    room: usize,
}

impl Best<'_> {
    fn add(&mut self, key: u64, contacts: &[ContactRow]) {
        if self.room == 0 {
            self.dropped += 1;
            return;
        }
        if self.count == self.keys.len() {
            self.cut(contacts);
        }
        self.keys[self.count] = key;
        self.count += 1;
    }

    fn cut(&mut self, contacts: &[ContactRow]) {
        if self.count > self.room {
            self.keys[..self.count].sort_unstable_by_key(|&key| (!touches(contacts, pair_of(key)), key));
            self.dropped += (self.count - self.room) as u32;
            self.count = self.room;
        }
    }
}

/// Merges the found keys (sorted) with the pairs that stay, and writes the pairs of the step.
fn merge(state: &mut State<'_>, scratch: &mut Scratch<'_>, found: usize, counts: &mut Counts) {
    let is_moved = &*scratch.is_moved;
    let old = state.header[0].pairs as usize;
    let stays = |pair: &Pair| (is_moved[pair.a as usize] | is_moved[pair.b as usize]) & (MOVED | GONE) == 0;
    let mut kept = 0;
    for i in 0..old {
        if stays(&state.pairs[i]) {
            state.pairs[kept] = state.pairs[i];
            kept += 1;
        }
    }
    let room = state.pairs.len();
    state.header[0].pairs_stale = 0;
    let mut found = found;
    if kept + found > room {
        // Which pairs stay is decided among all of them, so all are looked for again in the next step.
        let contacts = &state.contacts[..state.header[0].contacts as usize];
        let mut best = Best { keys: scratch.found, count: found, dropped: 0, room };
        for pair in &state.pairs[..kept] {
            best.add(key(pair.a, pair.b), contacts);
        }
        best.cut(contacts);
        counts.dropped_pairs += best.dropped;
        found = best.count;
        scratch.found[..found].sort_unstable();
        kept = 0;
    }
    if counts.dropped_pairs > 0 {
        state.header[0].pairs_stale = PAIRS_DROPPED;
    }
    merge_sorted(state.pairs, kept, scratch.found[..found].iter().map(|&key| pair_of(key)), |pair| *pair);
    let count = kept + found;
    let before = old.max(count);
    state.pairs[count..before].fill(Pair { a: 0, b: 0 });
    state.header[0].pairs = count as u32;
}

/// Merges `new` sorted rows into the first `kept` sorted ones of `rows`, from the back.
pub(crate) fn merge_sorted<T: Copy, K: Ord>(
    rows: &mut [T],
    kept: usize,
    new: impl DoubleEndedIterator<Item = T> + ExactSizeIterator,
    key: impl Fn(&T) -> K,
) {
    let (mut i, mut j) = (kept, new.len());
    for row in new.rev() {
        while i > 0 && key(&rows[i - 1]) > key(&row) {
            rows[i + j - 1] = rows[i - 1];
            i -= 1;
        }
        rows[i + j - 1] = row;
        j -= 1;
    }
}
