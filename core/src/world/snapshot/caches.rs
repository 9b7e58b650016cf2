//! What of the caches still holds after a restore: a game that rolls back at every step pays for a copy, and not
//! for finding again what has not changed.
//!
//! The state that goes is compared with the one that comes, row by row, before it is overwritten:
//!
//! - *Memos* of settled contacts follow from the contact's base and the geometries of its shapes. The contacts of
//!   both states are sorted, so one pass finds for each contact the memo to take over (`memo_sources`); the next
//!   step brings these into place and finds the others again.
//! - *The tree of what rests* holds while the same shapes rest in the same boxes.
//! - *The ordering* is compared by the next step itself, which has the links at hand; so is the layout.
//! - The tree of what moves is built anew by every step that needs it.

use super::super::World;
use super::super::load::Rows;
use super::Section;
use crate::arena::Line;
use crate::body::{BodyKind, BodyRow, KIND_MASK, Motion};
use crate::pipeline::Regions;
use crate::pool::{is_used, words};
use crate::shape::{BOX_STALE, FRESH, ShapeRow};
use crate::state::{ContactRow, Header, MEMOS_FIT, MEMOS_LISTED, NO_MEMO, ORDERING_UNCHECKED};
use bytemuck::Zeroable;

/// What of a restore is done before the copy.
pub(in super::super) struct Done {
    /// Contacts that are copied, from the first on.
    contacts: usize,
    /// The rows of the shapes are the same.
    shapes: bool,
    /// The rows of the bodies are the same.
    bodies: bool,
}

impl Done {
    /// Nothing.
    pub const NONE: Self = Self { contacts: 0, shapes: false, bodies: false };

    /// Bytes of a section, from the first on, that need no copy.
    pub fn of(&self, section: &Section) -> usize {
        match section.name {
            "contacts" => self.contacts * section.size,
            "shapes" if self.shapes => section.rows * section.size,
            "bodies" if self.bodies => section.rows * section.size,
            _ => 0,
        }
    }
}

/// The sections of the state that comes, in bytes of any alignment.
struct Coming<'a> {
    motions: Rows<'a, Motion>,
    bodies: Rows<'a, BodyRow>,
    shapes: Rows<'a, ShapeRow>,
    used: Rows<'a, u64>,
    contacts: Rows<'a, ContactRow>,
}

impl<'a> Coming<'a> {
    fn new(sections: &[Section], parts: &[&'a [u8]]) -> Self {
        let named = |name: &str| {
            let place = sections.iter().position(|section| section.name == name);
            place.map_or(&[][..], |place| parts[place])
        };
        Self {
            motions: Rows::new(named("motions")),
            bodies: Rows::new(named("bodies")),
            shapes: Rows::new(named("shapes")),
            used: Rows::new(named("shape_used")),
            contacts: Rows::new(named("contacts")),
        }
    }

    /// Flags of a body's row; those of a static body for a body that is not there, in bytes that no save wrote.
    fn body_flags(&self, body: u32) -> u32 {
        if body < self.bodies.len() { self.bodies.get(body).flags } else { BodyKind::Static as u32 }
    }

    fn sector(&self, body: u32) -> [i32; 3] {
        if body < self.motions.len() { self.motions.get(body).center.sector } else { [i32::MAX; 3] }
    }

    fn is_used(&self, slot: u32) -> bool {
        slot / 64 < self.used.len() && self.used.get(slot / 64) >> (slot % 64) & 1 == 1
    }
}

impl<M: AsRef<[Line]> + AsMut<[Line]>> World<M> {
    /// Keeps the caches that will hold for a checked snapshot, and drops the others. Comes before the copy; says
    /// what of that is done.
    pub(super) fn keep_caches(&mut self, snapshot: &[u8], header: &Header) -> Done {
        let sections = self.sections_for(header);
        let coming = Coming::new(&sections, &super::parts(snapshot, &sections));
        let mut regions = self.regions();
        let (shapes, bodies) = (are_same_shapes(&regions, &coming), are_same_bodies(&regions, &coming));
        let rests_as_before = if shapes && bodies {
            look_through(&mut regions, &coming)
        } else {
            compare_shapes(&mut regions, &coming)
        };
        let contacts = keep_memos(&mut regions, &coming);
        let cache = &mut regions.cache.header[0];
        let fits = cache.static_stamp == regions.state.header[0].static_version + 1;
        cache.static_stamp = if fits && rests_as_before { header.static_version + 1 } else { 0 };
        (cache.moving_fits, cache.moving_listed, cache.queried) = (0, 0, 0);
        if cache.ordering_fits != 0 {
            cache.ordering_fits = ORDERING_UNCHECKED;
        }
        Done { contacts, shapes, bodies }
    }
}

/// True when the rows of the shapes are the same.
fn are_same_shapes(regions: &Regions<'_>, coming: &Coming<'_>) -> bool {
    let state = &regions.state;
    let high = state.header[0].shapes.high as usize;
    coming.shapes.are(&state.shapes[..high]) && coming.used.are(&state.shape_used[..words(high)])
}

/// True when the rows of the bodies are the same.
fn are_same_bodies(regions: &Regions<'_>, coming: &Coming<'_>) -> bool {
    let state = &regions.state;
    coming.bodies.are(&state.bodies[..state.header[0].bodies.high as usize])
}

/// As [`compare_shapes`], where the rows of shapes and bodies are the same.
fn look_through(regions: &mut Regions<'_>, coming: &Coming<'_>) -> bool {
    let state = &regions.state;
    let mut rests_as_before = true;
    let shapes = state.shapes[..state.header[0].shapes.high as usize].iter();
    for (slot, (row, same)) in (0..).zip(shapes.zip(&mut *regions.scratch.is_moved)) {
        let used = is_used(state.shape_used, slot);
        *same = u8::from(used & (row.flags & FRESH == 0));
        // The row of a slot without shape is zero.
        let body = row.body as usize;
        if used & state.bodies[body].rests() {
            rests_as_before &=
                row.flags & BOX_STALE == 0 && state.motions[body].center.sector == coming.sector(row.body);
        }
    }
    rests_as_before
}

/// Notes in the scratch which shapes are as memos know them. True when the same shapes rest in the same boxes.
fn compare_shapes(regions: &mut Regions<'_>, coming: &Coming<'_>) -> bool {
    let state = &regions.state;
    let high = state.header[0].shapes.high.max(coming.shapes.len());
    let mut rests_as_before = true;
    for slot in 0..high {
        let same = &mut regions.scratch.is_moved[slot as usize];
        *same = 0;
        let old = is_used(state.shape_used, slot).then(|| &state.shapes[slot as usize]);
        let old = old.map(|row| (row, &state.bodies[row.body as usize]));
        let new = coming.is_used(slot).then(|| coming.shapes.get(slot));
        let Some(((row, body), new)) = old.zip(new) else {
            let rests = |flags| BodyRow { flags, ..BodyRow::zeroed() }.rests();
            rests_as_before &= !old.is_some_and(|(_, body)| body.rests());
            rests_as_before &= !new.is_some_and(|new| rests(coming.body_flags(new.body)));
            continue;
        };
        let geometry = |row: &ShapeRow| (row.kind, row.size.map(f32::to_bits));
        let as_known = (row.flags & FRESH == 0) & (geometry(row) == geometry(&new));
        let flags = coming.body_flags(new.body);
        *same = u8::from(as_known & ((body.flags ^ flags) & KIND_MASK == 0));
        let new_body = BodyRow { flags, ..BodyRow::zeroed() };
        if body.rests() | new_body.rests() {
            let sector = state.motions[row.body as usize].center.sector;
            rests_as_before &= body.rests() == new_body.rests()
                && row.flags & BOX_STALE == 0
                && bytemuck::bytes_of(&row.fat_box) == bytemuck::bytes_of(&new.fat_box)
                && sector == coming.sector(new.body);
        }
    }
    rests_as_before
}

/// Finds the memo of each contact that comes among those of the contacts that go. The contacts up to the first that
/// is another one are copied on the way, since the rows are at hand; says how many they are.
fn keep_memos(regions: &mut Regions<'_>, coming: &Coming<'_>) -> usize {
    let (state, cache, scratch) = (&mut regions.state, &mut regions.cache, &mut regions.scratch);
    let fit = cache.header[0].memos_fit;
    if fit != MEMOS_FIT && fit != MEMOS_LISTED {
        return 0;
    }
    let old = &mut state.contacts[..state.header[0].contacts as usize];
    // Between two restores no step has brought the memos into place.
    let listed = fit == MEMOS_LISTED;
    if listed {
        scratch.contact_from[..old.len()].copy_from_slice(&cache.memo_sources[..old.len()]);
    }
    let same = &*scratch.is_moved;
    let source = |old: &ContactRow, new: &ContactRow, place: usize| {
        let is_same = |slot: u32| same.get(slot as usize).is_some_and(|&same| same != 0);
        let known = is_same(new.pair.a) & is_same(new.pair.b);
        match known & has_same_base(old, new) {
            true if listed => scratch.contact_from[place],
            true => place as u32,
            false => NO_MEMO,
        }
    };
    let sources = &mut cache.memo_sources[..coming.contacts.len() as usize];
    let mut moved = u32::from(listed);
    let mut copied = 0;
    for (place, (old, from)) in old.iter_mut().zip(&mut *sources).enumerate() {
        let row = coming.contacts.get(place as u32);
        if old.key() != row.key() {
            break;
        }
        *from = source(old, &row, place);
        moved |= if row.tag.is_settled() { *from ^ place as u32 } else { 0 };
        *old = row;
        copied += 1;
    }
    let mut next = copied;
    for (place, from) in sources.iter_mut().enumerate().skip(copied) {
        let row = coming.contacts.get(place as u32);
        while old.get(next).is_some_and(|old| old.key() < row.key()) {
            next += 1;
        }
        *from = old.get(next).map_or(NO_MEMO, |old| source(old, &row, next));
        moved |= 1;
    }
    cache.header[0].memos_fit = if moved == 0 { MEMOS_FIT } else { MEMOS_LISTED };
    copied
}

/// True for the same settled contact of the same shapes, found at the same pose.
fn has_same_base(a: &ContactRow, b: &ContactRow) -> bool {
    let mut tag = b.tag;
    tag.set_phase(a.tag.phase());
    b.tag.is_settled() & (a.pair == b.pair) & (a.tag == tag) & (a.memory == b.memory)
}
