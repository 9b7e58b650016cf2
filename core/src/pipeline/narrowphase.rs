//! Narrowphase (the talk's second stage, SEED S3): contact points of every pair.
//!
//! A task has a run of pairs and the contacts that these had in the step before. Contacts that go on are
//! brought up to date where they are; those that begin are written aside and those that end are marked, for
//! `contacts.rs`. Impulses are carried over by feature.

use crate::collide::{MANIFOLDS_MAX, Manifold, Manifolds, POINTS_MAX};
use crate::config::Settings;
use crate::executor::{Executor, Stage};
use crate::math::{Pose, Vec3, max, sqrt};
use crate::pipeline::approach::{self, Approach};
use crate::pipeline::broadphase::SLEEPS;
use crate::pipeline::contacts::{self, Change, Yield};
use crate::pipeline::meeting::{self, Meeting, Scene};
use crate::pipeline::rules::{Acts, Rules};
use crate::pipeline::tasks::{Crew, Tasks, chunk, push};
use crate::pipeline::{Counts, solid, solver};
use crate::shape::{
    FRESH, GEOMETRY_BOX, GEOMETRY_CAPSULE, GEOMETRY_COMPOUND, GEOMETRY_CONE, GEOMETRY_CYLINDER,
    GEOMETRY_HEIGHT_FIELD, GEOMETRY_MESH, ShapeRow,
};
use crate::state::{
    AssetTables, Birth, Cache, ContactRow, MEMOS_FIT, MEMOS_MARKED, Memo, Pair, Scratch, State, Tag, Touch,
};
use bytemuck::Zeroable;

/// Pairs that are worth a task.
const COLLIDE_PAIRS: usize = 64;

/// Finds the contacts of the step. Says which began and ended. `moved` shapes are listed in the scratch: new and
/// changed ones are among them. `woken` contacts are back from sleep, and listed too.
pub(crate) fn run<E: Executor>(
    state: &mut State<'_>,
    (assets, settings, moved, woken): (&AssetTables<'_>, &Settings, usize, usize),
    (cache, scratch): (&mut Cache<'_>, &mut Scratch<'_>),
    (crew, counts): (&mut Crew<'_, E>, &mut Counts),
) -> Change {
    let yields = collide_pairs(state, (assets, settings), (cache, scratch), crew);
    cache.header[0].memos_fit = MEMOS_FIT;
    let change = contacts::merge(state, (cache, scratch), (&yields, woken), (crew, counts));
    for &slot in &scratch.moved[..moved] {
        state.shapes[slot as usize].flags &= !FRESH;
    }
    change
}

/// Brings every pair's contacts up to date.
fn collide_pairs<E: Executor>(
    state: &mut State<'_>,
    (assets, settings): (&AssetTables<'_>, &Settings),
    (cache, scratch): (&mut Cache<'_>, &mut Scratch<'_>),
    crew: &mut Crew<'_, E>,
) -> Tasks<Yield> {
    let header = &state.header[0];
    let (pair_count, count) = (header.pairs as usize, header.contacts as usize);
    let look = Look {
        scene: Scene {
            shapes: state.shapes,
            motions: state.motions,
            frames: scratch.frames,
            reaches: scratch.reaches,
            first_joints: state.first_joints,
        },
        rules: Rules::new(state.materials, &state.pair_rules[..header.pair_rules as usize]),
        assets,
        dt: settings.dt,
        continuous: settings.continuous,
        drift: settings.manifold_drift,
        memos_fit: cache.header[0].memos_fit,
        marks: scratch.is_moved,
        any_sleeps: header.asleep > 0,
    };
    let pairs = &state.pairs[..pair_count];
    let half = cache.header[0].memo_half as usize * (cache.memos.len() / 2);
    let mut rows = &mut state.contacts[..count];
    let mut memos = &mut cache.memos[half..half + count];
    let mut touches = &mut scratch.touches[..count];
    let mut extra = scratch.births.len() - pair_count;
    let mut births = &mut *scratch.births;
    let share = chunk(pair_count, COLLIDE_PAIRS);
    let mut tasks: Tasks<Task<'_>> = Tasks::new();
    let (mut first, mut first_birth) = (0, 0);
    for run in 0..pair_count.div_ceil(share).max(1) {
        let own = &pairs[run * share..pair_count.min((run + 1) * share)];
        // The contacts before the next task's first pair; those without a pair end.
        let next = pairs.get((run + 1) * share);
        let contacts = next.map_or(rows.len(), |next| count_before(rows, next));
        let more = look.extra_births(own).min(extra);
        extra -= more;
        let task = Task {
            pairs: own,
            rows: solver::take(&mut rows, contacts),
            memos: solver::take(&mut memos, contacts),
            touches: solver::take(&mut touches, contacts),
            births: solver::take(&mut births, own.len() + more),
            result: Yield { first, contacts: contacts as u32, first_birth, born: 0, died: 0, dropped: 0 },
            next: 0,
        };
        first += contacts as u32;
        first_birth += (own.len() + more) as u32;
        push(&mut tasks, task);
    }
    crew.run(Stage::Narrowphase, &mut tasks, |task| task.run(&look, &mut Room::default()));
    tasks.iter().map(|task| task.result).collect()
}

/// How many contacts come before a pair. Few of many: looked for from the front.
fn count_before(rows: &[ContactRow], pair: &Pair) -> usize {
    let mut end = COLLIDE_PAIRS;
    while rows.get(end).is_some_and(|row| row.pair < *pair) {
        end *= 2;
    }
    rows[..end.min(rows.len())].partition_point(|row| row.pair < *pair)
}

/// What all tasks read.
struct Look<'a> {
    scene: Scene<'a>,
    rules: Rules<'a>,
    assets: &'a AssetTables<'a>,
    dt: f32,
    continuous: bool,
    /// How far points may drift; see `Settings::manifold_drift`.
    drift: f32,
    /// See `CacheHeader`.
    memos_fit: u32,
    /// Which shapes sleep; see `broadphase.rs`.
    marks: &'a [u8],
    /// Whether any does.
    any_sleeps: bool,
}

impl Look<'_> {
    fn shape(&self, slot: u32) -> &ShapeRow {
        &self.scene.shapes[slot as usize]
    }

    /// False when a shape of the pair sleeps: had it points with something that pushes, it would have woken.
    #[inline(always)]
    fn is_awake(&self, pair: Pair) -> bool {
        !self.any_sleeps || (self.marks[pair.a as usize] | self.marks[pair.b as usize]) & SLEEPS == 0
    }

    /// Contacts that a run of pairs may begin beyond one each: concave shapes have several.
    fn extra_births(&self, pairs: &[Pair]) -> usize {
        if !self.assets.have_concave() {
            return 0;
        }
        let concave = |slot: u32| {
            matches!(self.shape(slot).kind, GEOMETRY_MESH | GEOMETRY_HEIGHT_FIELD | GEOMETRY_COMPOUND)
        };
        pairs.iter().filter(|pair| concave(pair.a) || concave(pair.b)).count() * (MANIFOLDS_MAX - 1)
    }

    /// How the two shapes of a pair come to each other, and what rules are about them.
    fn find(&self, pair: Pair, slots: [u32; 2]) -> Found<'_> {
        let shapes = (self.shape(slots[0]), self.shape(slots[1]));
        let meeting = Meeting::new(&self.scene, slots, self.dt);
        let ruled = self.rules.concern(shapes);
        let acts = if ruled { self.rules.acts(shapes) } else { Acts::default() };
        let approach = if self.continuous {
            Approach::new(&self.scene, &meeting, (slots, shapes, self.assets, self.dt))
        } else {
            Approach::Slow
        };
        Found {
            pair,
            slots,
            shapes,
            meeting,
            exchanged: self.are_exchanged(slots),
            ruled,
            acts,
            approach,
            way: Vec3::ZERO,
        }
    }

    /// True when the solver's A is the body of shape B. A is dynamic; of two dynamic bodies it is the rounder one.
    fn are_exchanged(&self, [a, b]: [u32; 2]) -> bool {
        let dynamic = |slot: u32| self.scene.is_dynamic(slot);
        // Spheres come before capsules, cylinders and cones, and those before all others.
        let edges = |slot: u32| match self.shape(slot).kind {
            GEOMETRY_CYLINDER | GEOMETRY_CONE => GEOMETRY_CAPSULE,
            kind => kind.min(GEOMETRY_BOX),
        };
        !dynamic(a) || (dynamic(b) && edges(b) < edges(a))
    }
}

/// A run of pairs and what belongs to it.
struct Task<'a> {
    pairs: &'a [Pair],
    rows: &'a mut [ContactRow],
    memos: &'a mut [Memo],
    touches: &'a mut [Touch],
    births: &'a mut [Birth],
    result: Yield,
    /// First contact that no pair has asked for.
    next: usize,
}

/// A contact of the step before, with the features of its points.
#[derive(Clone, Copy)]
struct Old {
    row: ContactRow,
    features: [u32; POINTS_MAX],
    /// Place among the task's contacts.
    place: usize,
}

type Olds = heapless::Vec<Old, MANIFOLDS_MAX>;

/// Where a task writes what it finds of a pair: one place for all its pairs.
#[derive(Default)]
struct Room {
    olds: Olds,
    manifolds: Manifolds,
}

/// How two shapes stand, and what their contacts have in common.
struct Found<'a> {
    pair: Pair,
    /// Slots of A and B: see `Scene::in_order`.
    slots: [u32; 2],
    shapes: (&'a ShapeRow, &'a ShapeRow),
    meeting: Meeting,
    /// Whether the solver's A is B.
    exchanged: bool,
    /// Whether some rule is about the shapes.
    ruled: bool,
    /// What the surfaces do.
    acts: Acts,
    approach: Approach,
    /// How far B moves against A until they stand as their contacts were found, in A's frame, metres.
    way: Vec3,
}

impl Found<'_> {
    /// The memo of one of the pair's manifolds, found at a pose of B in A's frame less the way.
    #[inline(always)]
    fn memo(&self, manifold: &Manifold, b_in_a: &Pose, settled: bool) -> Memo {
        if self.approach == Approach::Slow || self.way == Vec3::ZERO {
            return meeting::memo(manifold, b_in_a, self.exchanged, settled);
        }
        self.memo_ahead(manifold, b_in_a, settled)
    }

    /// The same of shapes that come from far.
    #[inline(never)]
    fn memo_ahead(&self, manifold: &Manifold, b_in_a: &Pose, settled: bool) -> Memo {
        let touch = Pose::new(b_in_a.position + self.way, b_in_a.rotation);
        let mut memo = meeting::memo(manifold, &touch, self.exchanged, settled);
        for (tail, point) in memo.tail.iter_mut().zip(&manifold.points) {
            *tail = (point.separation - manifold.normal.dot(self.way)).to_bits();
        }
        memo
    }

    fn touch(&self, settled: bool) -> Touch {
        let Found { slots, shapes: (a, b), meeting, exchanged, .. } = self;
        let shapes = if *exchanged { [slots[1], slots[0]] } else { *slots };
        Touch {
            shapes,
            friction: sqrt(a.friction * b.friction),
            restitution: max(a.restitution, b.restitution),
            centers: if *exchanged { -meeting.centers } else { meeting.centers },
            settled: match (settled, self.approach) {
                (true, _) => Touch::SETTLED,
                (_, Approach::Slow) => 0.0,
                _ => Touch::FAST,
            },
        }
    }

    /// The touch of a manifold that is not settled.
    fn touch_of(&self, manifold: &Manifold, look: &Look<'_>) -> Touch {
        let mut touch = self.touch(false);
        if manifold.surface != 0 || self.ruled {
            self.take_material(manifold.surface, look, &mut touch);
            // More points than two resist by themselves.
            if self.acts.moves || (self.acts.resists && manifold.points.len() <= 2) {
                touch.settled += Touch::ACTS;
            }
        }
        touch
    }

    /// The touch of a settled contact: of boxes and hulls, which have no surfaces of their own.
    fn settled_touch(&self, look: &Look<'_>) -> Touch {
        let mut touch = self.touch(true);
        if self.ruled {
            self.take_material(0, look, &mut touch);
        }
        touch
    }

    /// Mixes the materials by their rules, the mesh's or height field's replaced by that of one of its surfaces.
    fn take_material(&self, name: u32, look: &Look<'_>, touch: &mut Touch) {
        let (a, b) = self.shapes;
        let mut frictions = [a.friction, b.friction];
        let mut restitutions = [a.restitution, b.restitution];
        let concave = usize::from(!a.is_surface());
        if name != 0
            && let Some(surface) = look.assets.surface([a, b][concave], name)
        {
            (frictions[concave], restitutions[concave]) = (surface.friction, surface.restitution);
        }
        look.rules.mix(self.shapes, frictions, restitutions, touch);
    }
}

impl Task<'_> {
    fn run(&mut self, look: &Look<'_>, room: &mut Room) {
        for pairs in self.pairs.chunks(COLLIDE_PAIRS) {
            // First which boxes overlap, without a branch: half of them do, in no order.
            let mut near = [0_u8; COLLIDE_PAIRS];
            let mut count = 0;
            for (i, &pair) in pairs.iter().enumerate() {
                near[count] = i as u8;
                count += usize::from(look.is_awake(pair) && look.scene.may_touch(pair));
            }
            for &i in &near[..count] {
                let pair = pairs[usize::from(i)];
                self.end_until(|row| row.pair < pair);
                self.meet(look, pair, room);
            }
        }
        self.end_until(|_| true);
    }

    /// Ends the next contacts while they are of pairs that are no more.
    fn end_until(&mut self, ends: impl Fn(&ContactRow) -> bool) {
        while self.next < self.rows.len() && ends(&self.rows[self.next]) {
            self.end(self.next);
            self.next += 1;
        }
    }

    fn end(&mut self, place: usize) {
        self.rows[place].tag.end();
        self.result.died += 1;
    }

    /// Brings the contacts of a pair up to date.
    fn meet(&mut self, look: &Look<'_>, pair: Pair, room: &mut Room) {
        let slots = look.scene.in_order(pair);
        let shapes = (look.shape(slots[0]), look.shape(slots[1]));
        if look.rules.ignore_any()
            && look.rules.ignore(slots.map(|slot| look.scene.reaches[slot as usize].body))
        {
            self.end_until(|row| row.pair == pair);
            return;
        }
        let mut found = look.find(pair, slots);
        let (approach, acts) = (found.approach, found.acts);
        // An old contact of a slot's former tenant, or of a changed shape, says nothing of this one.
        if (shapes.0.flags | shapes.1.flags) & FRESH != 0 {
            self.end_until(|row| row.pair == pair);
        }
        let first = self.next;
        self.next += self.rows[first..].iter().take_while(|row| row.pair == pair).count();
        let radii = if acts.moves { None } else { meeting::settling_radii(shapes, look.assets) };
        let settles = radii.is_some_and(|radii| found.meeting.is_slow(radii, look.drift));
        if let (Some(row), Some(radii)) = (self.rows[first..self.next].first(), radii) {
            let near = |base| found.meeting.is_near(&base, radii, look.drift);
            let stays = settles && row.tag.is_settled() && meeting::unpack(&row.memory).is_some_and(near);
            if stays && (self.knows(look, first) || self.remember(look, &found, first)) {
                self.touches[first] = found.settled_touch(look);
                return;
            }
        }
        let Room { olds, manifolds } = room;
        manifolds.clear();
        let solids = (&solid(shapes.0, look.assets), &solid(shapes.1, look.assets));
        if settles {
            let memory = meeting::pack(&found.meeting.b_in_a);
            let base = meeting::unpack(&memory).unwrap_or(Pose::IDENTITY);
            meeting::collide_at(&base, solids, manifolds);
            self.hold_back(look, (&found, first), manifolds);
            self.list_olds(look, (&found, first), olds);
            for manifold in &*manifolds {
                self.take_over(look, &found, (manifold, &base, Some(memory)), olds);
            }
        } else {
            if approach == Approach::Slow {
                found.meeting.collide(solids, manifolds);
            } else {
                let motion = look.scene.motion_between(slots, look.dt);
                found.way = approach::collide(&found.meeting, solids, (approach, motion), manifolds);
            }
            self.hold_back(look, (&found, first), manifolds);
            if self.goes_on(look, (&found, first), manifolds) {
                return;
            }
            self.list_olds(look, (&found, first), olds);
            for manifold in &*manifolds {
                self.take_over(look, &found, (manifold, &found.meeting.b_in_a, None), olds);
            }
        }
        // What was not taken over has ended.
        for old in &*olds {
            if self.touches[old.place].shapes == [0; 2] {
                self.end(old.place);
            }
        }
    }

    /// Leaves out what comes to a one-way surface from where it is not solid. What has touched it goes on.
    #[inline(always)]
    fn hold_back(&self, look: &Look<'_>, (found, first): (&Found<'_>, usize), manifolds: &mut Manifolds) {
        if found.ruled
            && first == self.next
            && !look.rules.let_begin(found.shapes, &found.meeting.b_in_a, manifolds)
        {
            manifolds.clear();
        }
    }

    /// True when the pair's only contact, from `first` on, has the points of its only manifold: then its row stays
    /// as it is, and only where the points are is new.
    fn goes_on(
        &mut self,
        look: &Look<'_>,
        (found, first): (&Found<'_>, usize),
        manifolds: &Manifolds,
    ) -> bool {
        let ([row], [manifold]) = (&self.rows[first..self.next], manifolds.as_slice()) else { return false };
        let mut features = [0; POINTS_MAX];
        for (feature, point) in features.iter_mut().zip(&manifold.points) {
            *feature = point.feature;
        }
        let count = manifold.points.len();
        let same = !row.tag.is_settled()
            && row.tag.child() == manifold.child
            && row.tag.points() == count
            && row.memory[..POINTS_MAX] == features;
        if same {
            self.memos[first] = found.memo(manifold, &found.meeting.b_in_a, false);
            self.touches[first] = found.touch_of(manifold, look);
        }
        same
    }

    /// True when the memo of a settled contact is there.
    #[inline(always)]
    fn knows(&self, look: &Look<'_>, place: usize) -> bool {
        look.memos_fit == MEMOS_FIT || (look.memos_fit == MEMOS_MARKED && self.memos[place].is_unknown == 0)
    }

    /// Finds the points of a settled contact again. False when they are not those of the contact.
    fn remember(&mut self, look: &Look<'_>, found: &Found<'_>, place: usize) -> bool {
        let memo = meeting::memo_again(&self.rows[place], found.shapes, found.exchanged, look.assets);
        memo.inspect(|memo| self.memos[place] = *memo).is_some()
    }

    /// Copies of the pair's contacts, whose touches are cleared: they end unless they are taken over.
    fn list_olds(&mut self, look: &Look<'_>, (found, first): (&Found<'_>, usize), olds: &mut Olds) {
        olds.clear();
        for place in first..self.next {
            let row = self.rows[place];
            let settled = row.tag.is_settled();
            let remembered = !settled || self.knows(look, place) || self.remember(look, found, place);
            let features = match (settled, remembered) {
                (false, _) => [row.memory[0], row.memory[1], row.memory[2], row.memory[3]],
                (_, true) => self.memos[place].tail,
                (_, false) => [0; POINTS_MAX],
            };
            self.touches[place].shapes = [0; 2];
            if olds.push(Old { row, features, place }).is_err() {
                self.end(place);
            }
        }
    }

    /// Writes a manifold over the contact of before, or as one that begins. `base` is what a settled contact
    /// keeps.
    fn take_over(
        &mut self,
        look: &Look<'_>,
        found: &Found<'_>,
        (manifold, b_in_a, base): (&Manifold, &Pose, Option<[u32; 5]>),
        olds: &Olds,
    ) {
        let mut features = [0; POINTS_MAX];
        for (feature, point) in features.iter_mut().zip(&manifold.points) {
            *feature = point.feature;
        }
        let [f, g, h, i] = features;
        let mut row = ContactRow {
            pair: found.pair,
            tag: Tag::new(manifold.child, manifold.points.len(), base.is_some()),
            memory: base.unwrap_or([f, g, h, i, 0]),
            ..ContactRow::zeroed()
        };
        let old = olds.iter().find(|old| old.row.tag.child() == manifold.child);
        carry_over(&mut row, &features, old, olds);
        if let Some(old) = old
            && found.acts.resists
            && row.can_resist()
            && old.row.can_resist()
        {
            row.set_resistance(old.row.resistance());
        }
        let memo = found.memo(manifold, b_in_a, base.is_some());
        let touch = if base.is_some() { found.settled_touch(look) } else { found.touch_of(manifold, look) };
        if let Some(old) = old {
            self.rows[old.place] = row;
            self.memos[old.place] = memo;
            self.touches[old.place] = touch;
            return;
        }
        let Some(birth) = self.births.get_mut(self.result.born as usize) else {
            self.result.dropped += 1;
            return;
        };
        let later =
            olds.iter().find(|old| old.row.tag.child() > manifold.child).map_or(self.next, |old| old.place);
        *birth = Birth { row, memo, touch, before: self.result.first + later as u32, reserved: [0; 7] };
        self.result.born += 1;
    }
}

/// Takes over the impulses of points whose features touched before. New points share what the lost ones carried.
///
/// Of a face's many corners four are chosen, and which four can change in every step: a load that was dropped each
/// time shook stacks of turned boxes until they crept (8 mm/s in a tower of ten).
fn carry_over(row: &mut ContactRow, features: &[u32; POINTS_MAX], old: Option<&Old>, olds: &Olds) {
    let count = row.tag.points();
    let mut fresh: heapless::Vec<usize, POINTS_MAX> = heapless::Vec::new();
    for (i, feature) in features[..count].iter().enumerate() {
        let place = |old: &Old| old.features[..old.row.tag.points()].iter().position(|f| f == feature);
        match olds.iter().find_map(|old| place(old).map(|k| old.row.impulses[k])) {
            Some(impulse) => row.impulses[i] = impulse,
            None => {
                let _ = fresh.push(i);
            }
        }
    }
    let Some(old) = old else { return };
    row.friction = old.row.friction;
    row.twist = old.row.twist;
    row.tag.set_phase(old.row.tag.phase());
    let mut lost = 0.0;
    for (feature, impulse) in old.features[..old.row.tag.points()].iter().zip(old.row.impulses) {
        lost += if features[..count].contains(feature) { 0.0 } else { impulse };
    }
    for &i in &fresh {
        row.impulses[i] = lost / fresh.len() as f32;
    }
}
