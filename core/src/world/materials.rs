//! Materials beyond friction and restitution, and rules for pairs.

use super::World;
use super::sleep::wake_slot;
use crate::arena::Line;
use crate::error::Error;
use crate::handle::{BodyHandle, ShapeHandle};
use crate::material::{
    MaterialRow, MaterialTraits, PairMaterial, PairRule, RULE_IGNORE, RULE_MATERIAL, find_rule,
};
use crate::math::Vec3;
use crate::pipeline::rules::may_resist;
use crate::shape::{ShapeRow, check_material};
use crate::state::State;
use bytemuck::Zeroable;

impl<M: AsRef<[Line]> + AsMut<[Line]>> World<M> {
    /// Changes friction, 0..=1e6, and restitution, 0..=1. Wakes the body and what it touches.
    ///
    /// # Errors
    /// [`Error::Stale`], or a number is refused.
    pub fn set_material(&mut self, shape: ShapeHandle, friction: f32, restitution: f32) -> Result<(), Error> {
        let slot = self.shape_slot(shape)?;
        check_material(friction, restitution)?;
        let mut state = self.state_view();
        let row = &mut state.shapes[slot];
        (row.friction, row.restitution) = (friction, restitution);
        let body = row.body as usize;
        wake_slot(&mut state, body);
        Ok(())
    }

    /// Changes what the shape's surface does beyond friction and restitution. Wakes the body and what it touches.
    ///
    /// # Errors
    /// [`Error::Stale`], [`Error::Full`] when there is no room for other traits in
    /// [`Capacities::materials`](crate::Capacities::materials), or a number is refused; see [`MaterialTraits`].
    pub fn set_material_traits(&mut self, shape: ShapeHandle, traits: &MaterialTraits) -> Result<(), Error> {
        let slot = self.shape_slot(shape)? as u32;
        traits.check()?;
        let mut state = self.state_view();
        // The row of before may be the only one there is room for.
        let before = state.shapes[slot as usize].material();
        let old = before.map(|index| state.materials[index as usize]);
        drop_material(&mut state, slot);
        let room = match find_room(&state, traits) {
            Ok(room) => room,
            Err(error) => {
                if let (Some(index), Some(row)) = (before, old) {
                    put_back(&mut state, slot, (index, row));
                }
                return Err(error);
            }
        };
        take_material(&mut state, slot, (traits, room));
        forget_resistance(&mut state, slot);
        let body = state.shapes[slot as usize].body as usize;
        wake_slot(&mut state, body);
        Ok(())
    }

    /// The traits of a shape's row.
    pub(super) fn traits_of(&self, row: &ShapeRow) -> MaterialTraits {
        row.traits(self.layout.state.materials.of(self.state()))
            .read()
            .expect("materials in the state are valid")
    }

    /// Gives two shapes friction and restitution of their own. What is `None` is as the shapes' materials give it.
    /// Wakes their bodies. Goes when one of the shapes does.
    ///
    /// # Errors
    /// [`Error::Stale`]; [`Error::Full`] when there is no room in
    /// [`Capacities::pair_rules`](crate::Capacities::pair_rules); [`Error::OutOfRange`] for a shape with itself;
    /// or a number is refused, see [`PairMaterial`].
    pub fn set_pair_material(
        &mut self,
        a: ShapeHandle,
        b: ShapeHandle,
        material: &PairMaterial,
    ) -> Result<(), Error> {
        let slots = self.shape_pair(a, b)?;
        material.check()?;
        let mut state = self.state_view();
        if *material == PairMaterial::default() {
            remove_rule(&mut state, RULE_MATERIAL, slots);
        } else {
            put_rule(&mut state, PairRule::material(slots, material))?;
        }
        for slot in slots {
            let body = state.shapes[slot as usize].body as usize;
            wake_slot(&mut state, body);
        }
        Ok(())
    }

    /// What [`World::set_pair_material`] has set; nothing by default.
    ///
    /// # Errors
    /// [`Error::Stale`], or [`Error::OutOfRange`] for a shape with itself.
    pub fn pair_material(&self, a: ShapeHandle, b: ShapeHandle) -> Result<PairMaterial, Error> {
        let slots = self.shape_pair(a, b)?;
        let rules = self.pair_rules();
        Ok(find_rule(rules, RULE_MATERIAL, slots)
            .map_or_else(|_| PairMaterial::default(), |i| rules[i].read()))
    }

    /// Lets two bodies pass through each other until they are apart: no contacts are made between them from the
    /// next step on, up to the first step in which none of their shapes are within the distance at which contacts
    /// are found (2 cm, and the way of the step). Where they are apart already it ends in the next step. Joints
    /// hold as before.
    ///
    /// # Errors
    /// [`Error::Stale`]; [`Error::Full`] when there is no room in
    /// [`Capacities::pair_rules`](crate::Capacities::pair_rules); [`Error::OutOfRange`] for a body with itself.
    pub fn ignore_until_separated(&mut self, a: BodyHandle, b: BodyHandle) -> Result<(), Error> {
        let slots = self.body_pair(a, b)?;
        let mut state = self.state_view();
        put_rule(&mut state, PairRule::ignore(slots))?;
        slots.into_iter().for_each(|slot| wake_slot(&mut state, slot as usize));
        Ok(())
    }

    /// True while the two bodies pass through each other by [`World::ignore_until_separated`].
    ///
    /// # Errors
    /// [`Error::Stale`], or [`Error::OutOfRange`] for a body with itself.
    pub fn ignores(&self, a: BodyHandle, b: BodyHandle) -> Result<bool, Error> {
        let slots = self.body_pair(a, b)?;
        Ok(find_rule(self.pair_rules(), RULE_IGNORE, slots).is_ok())
    }

    /// Lets two bodies touch again that were to pass through each other until they are apart.
    ///
    /// # Errors
    /// [`Error::Stale`], or [`Error::OutOfRange`] for a body with itself.
    pub fn stop_ignoring(&mut self, a: BodyHandle, b: BodyHandle) -> Result<(), Error> {
        let slots = self.body_pair(a, b)?;
        let mut state = self.state_view();
        remove_rule(&mut state, RULE_IGNORE, slots);
        slots.into_iter().for_each(|slot| wake_slot(&mut state, slot as usize));
        Ok(())
    }

    fn pair_rules(&self) -> &[PairRule] {
        &self.layout.state.pair_rules.of(self.state())[..self.header().pair_rules as usize]
    }

    fn shape_pair(&self, a: ShapeHandle, b: ShapeHandle) -> Result<[u32; 2], Error> {
        distinct([self.shape_slot(a)? as u32, self.shape_slot(b)? as u32], "shapes")
    }

    fn body_pair(&self, a: BodyHandle, b: BodyHandle) -> Result<[u32; 2], Error> {
        distinct([self.body_slot(a)? as u32, self.body_slot(b)? as u32], "bodies")
    }
}

fn distinct(slots: [u32; 2], name: &'static str) -> Result<[u32; 2], Error> {
    if slots[0] == slots[1] { Err(Error::OutOfRange { name }) } else { Ok(slots) }
}

/// The row for such traits: that of shapes with the same ones, else the lowest free one; none for the default.
pub(super) fn find_room(state: &State<'_>, traits: &MaterialTraits) -> Result<Option<u32>, Error> {
    if traits.are_default() {
        return Ok(None);
    }
    let row = MaterialRow::new(traits);
    let used = &state.materials[..state.header[0].materials as usize];
    let same = |other: &MaterialRow| other.uses > 0 && MaterialRow { uses: 0, ..*other } == row;
    let index = used
        .iter()
        .position(same)
        .or_else(|| used.iter().position(|row| row.uses == 0))
        .unwrap_or(used.len());
    if index == state.materials.len() {
        Err(Error::Full { name: "materials" })
    } else {
        Ok(Some(index as u32))
    }
}

/// Gives a shape the row that [`find_room`] has found.
pub(super) fn take_material(
    state: &mut State<'_>,
    shape: u32,
    (traits, room): (&MaterialTraits, Option<u32>),
) {
    let Some(index) = room else { return };
    let row = &mut state.materials[index as usize];
    *row = MaterialRow { uses: row.uses.saturating_add(1), ..MaterialRow::new(traits) };
    state.shapes[shape as usize].set_material(Some(index));
    let high = &mut state.header[0].materials;
    *high = (*high).max(index + 1);
}

/// Takes a shape's row from it.
pub(super) fn drop_material(state: &mut State<'_>, shape: u32) {
    let Some(index) = state.shapes[shape as usize].material() else { return };
    state.shapes[shape as usize].set_material(None);
    let row = &mut state.materials[index as usize];
    // A loaded state may count too few.
    row.uses = row.uses.saturating_sub(1);
    if row.uses > 0 {
        return;
    }
    *row = MaterialRow::NONE;
    let high = &mut state.header[0].materials;
    while *high > 0 && state.materials[*high as usize - 1].uses == 0 {
        *high -= 1;
    }
}

/// Undoes [`drop_material`].
fn put_back(state: &mut State<'_>, shape: u32, (index, row): (u32, MaterialRow)) {
    state.materials[index as usize] = row;
    state.shapes[shape as usize].set_material(Some(index));
    let high = &mut state.header[0].materials;
    *high = (*high).max(index + 1);
}

/// Clears what contacts of a shape that resist no more have kept.
fn forget_resistance(state: &mut State<'_>, shape: u32) {
    let (awake, asleep) = (state.header[0].contacts as usize, state.header[0].asleep_contacts as usize);
    let (shapes, materials) = (&*state.shapes, &*state.materials);
    for row in state.contacts[..awake].iter_mut().chain(&mut state.asleep_contacts[..asleep]) {
        let slots = [row.pair.a, row.pair.b];
        if slots.contains(&shape) && row.can_resist() && !may_resist(slots, shapes, materials) {
            row.set_resistance(Vec3::ZERO);
        }
    }
}

/// Adds a rule, or replaces that of the same pair.
fn put_rule(state: &mut State<'_>, rule: PairRule) -> Result<(), Error> {
    let count = state.header[0].pair_rules as usize;
    match find_rule(&state.pair_rules[..count], rule.kind, rule.slots) {
        Ok(place) => state.pair_rules[place] = rule,
        Err(_) if count == state.pair_rules.len() => return Err(Error::Full { name: "pair_rules" }),
        Err(place) => {
            state.pair_rules.copy_within(place..count, place + 1);
            state.pair_rules[place] = rule;
            state.header[0].pair_rules += 1;
        }
    }
    Ok(())
}

fn remove_rule(state: &mut State<'_>, kind: u32, slots: [u32; 2]) {
    let slots = crate::material::ordered(slots);
    retain_rules(state, |rule| rule.key() != (kind, slots));
}

/// Removes the rules of a shape, or of a body.
pub(super) fn drop_rules(state: &mut State<'_>, kind: u32, slot: u32) {
    if state.header[0].pair_rules > 0 {
        retain_rules(state, |rule| rule.kind != kind || !rule.slots.contains(&slot));
    }
}

fn retain_rules(state: &mut State<'_>, stays: impl Fn(&PairRule) -> bool) {
    let count = state.header[0].pair_rules as usize;
    let mut kept = 0;
    for i in 0..count {
        let rule = state.pair_rules[i];
        if stays(&rule) {
            state.pair_rules[kept] = rule;
            kept += 1;
        }
    }
    state.pair_rules[kept..count].fill(PairRule::zeroed());
    state.header[0].pair_rules = kept as u32;
}
