//! Rules about pairs that a game would write as callbacks, as data: how materials mix, one-way surfaces, and bodies
//! that ignore each other until they are apart.
//!
//! All of it follows from the state. Whether something may touch a one-way surface is decided when their contact
//! begins; that it has begun is the contact itself, which is state.

use crate::collide::{self, Manifolds};
use crate::config::SPECULATIVE_DISTANCE;
use crate::material::{MaterialRow, Mix, ONE_WAY_SLOP, PairRule, RULE_IGNORE, RULE_MATERIAL, find_rule};
use crate::math::{Pose, Vec3, length};
use crate::pipeline::broadphase::{boxes_overlap, may_meet};
use crate::pipeline::meeting::{centers_between, relative};
use crate::pipeline::solid;
use crate::shape::{MATERIAL_SHIFT, ShapeRow};
use crate::state::{AssetTables, State, Touch};
use bytemuck::Zeroable;

/// What surfaces do of which the solve has to know.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Acts {
    /// A surface moves: their contact does not settle.
    pub moves: bool,
    /// A surface resists rolling or spinning: of a contact that has settled none is asked.
    pub resists: bool,
}

/// What the materials and rules of a world say.
#[derive(Clone, Copy)]
pub(crate) struct Rules<'a> {
    materials: &'a [MaterialRow],
    /// Friction and restitution of pairs of shapes.
    pairs: &'a [PairRule],
    /// Pairs of bodies that do not touch.
    ignored: &'a [PairRule],
}

impl<'a> Rules<'a> {
    pub fn new(materials: &'a [MaterialRow], rules: &'a [PairRule]) -> Self {
        let (pairs, ignored) = rules.split_at(rules.partition_point(|rule| rule.kind < RULE_IGNORE));
        Self { materials, pairs, ignored }
    }

    /// False when nothing here is about two shapes: their material is friction and restitution, and they touch.
    #[inline(always)]
    pub fn concern(&self, (a, b): (&ShapeRow, &ShapeRow)) -> bool {
        (a.flags | b.flags) >> MATERIAL_SHIFT != 0 || !self.pairs.is_empty()
    }

    /// True when some bodies ignore each other.
    pub fn ignore_any(&self) -> bool {
        !self.ignored.is_empty()
    }

    /// True when two bodies do not touch.
    pub fn ignore(&self, bodies: [u32; 2]) -> bool {
        self.ignore_any() && find_rule(self.ignored, RULE_IGNORE, bodies).is_ok()
    }

    /// What the surfaces of two shapes do.
    pub fn acts(&self, (a, b): (&ShapeRow, &ShapeRow)) -> Acts {
        let (a, b) = (a.traits(self.materials), b.traits(self.materials));
        Acts { moves: a.moves() || b.moves(), resists: a.resists() || b.resists() }
    }

    /// Writes friction and restitution of two shapes, given those of each.
    pub fn mix(
        &self,
        (a, b): (&ShapeRow, &ShapeRow),
        frictions: [f32; 2],
        restitutions: [f32; 2],
        touch: &mut Touch,
    ) {
        let [ma, mb] = [a, b].map(|shape| shape.traits(self.materials).rules());
        let [friction, restitution] = [ma[0].max(mb[0]), ma[1].max(mb[1])];
        touch.friction = friction.of(frictions[0], frictions[1], Mix::GeometricMean);
        touch.restitution = restitution.of(restitutions[0], restitutions[1], Mix::Max);
        if let Ok(place) = find_rule(self.pairs, RULE_MATERIAL, touch.shapes) {
            let own = self.pairs[place].read();
            touch.friction = own.friction.unwrap_or(touch.friction);
            touch.restitution = own.restitution.unwrap_or(touch.restitution);
        }
    }

    /// True when two shapes that did not touch may begin to: neither is one-way, or all that was found is on the
    /// solid side and hardly overlaps. `found` is in the frame of the first shape.
    pub fn let_begin(&self, (a, b): (&ShapeRow, &ShapeRow), b_in_a: &Pose, found: &Manifolds) -> bool {
        let (ma, mb) = (a.traits(self.materials), b.traits(self.materials));
        if ma.one_way == Vec3::ZERO && mb.one_way == Vec3::ZERO {
            return true;
        }
        found.iter().all(|manifold| {
            let n = manifold.normal;
            ma.is_solid_to(n)
                && mb.is_solid_to(b_in_a.rotation.unrotate(-n))
                && manifold.points.iter().all(|point| point.separation >= -ONE_WAY_SLOP)
        })
    }
}

/// True when a contact of two shapes may resist rolling or spinning.
pub(crate) fn may_resist(slots: [u32; 2], shapes: &[ShapeRow], materials: &[MaterialRow]) -> bool {
    slots.into_iter().any(|slot| shapes[slot as usize].traits(materials).resists())
}

/// False when something may pass between two shapes: their bodies ignore each other, or one is solid from one side.
/// Such a one stops by its contacts, which look as far as a step goes.
pub(crate) fn stand_in_the_way(state: &State<'_>, slots: [u32; 2]) -> bool {
    let [a, b] = slots.map(|slot| &state.shapes[slot as usize]);
    let rules = Rules::new(state.materials, &state.pair_rules[..state.header[0].pair_rules as usize]);
    let one_way = [a, b].into_iter().any(|shape| shape.traits(state.materials).one_way != Vec3::ZERO);
    !one_way && !rules.ignore([a.body, b.body])
}

/// Lets bodies touch again that are apart by now. The boxes are those of the step.
pub(crate) fn end_ignored(state: &mut State<'_>, (assets, dt): (&AssetTables<'_>, f32)) {
    let count = state.header[0].pair_rules as usize;
    let first = state.pair_rules[..count].partition_point(|rule| rule.kind < RULE_IGNORE);
    let mut kept = first;
    for i in first..count {
        let rule = state.pair_rules[i];
        if are_near(state, (assets, dt), rule.slots) {
            state.pair_rules[kept] = rule;
            kept += 1;
        }
    }
    state.pair_rules[kept..count].fill(PairRule::zeroed());
    state.header[0].pair_rules = kept as u32;
}

/// True when points of contact would be found between two bodies.
fn are_near(state: &State<'_>, (assets, dt): (&AssetTables<'_>, f32), [a, b]: [u32; 2]) -> bool {
    let shapes = |body: u32| {
        let mut next = state.bodies[body as usize].first_shape;
        core::iter::from_fn(move || {
            let slot = next;
            (slot != u32::MAX).then(|| {
                next = state.shapes[slot as usize].next;
                slot
            })
        })
    };
    shapes(a).any(|first| {
        shapes(b).any(|second| {
            may_meet(state, first, second)
                && boxes_overlap(state, first, second)
                && touch(state, (assets, dt), [first, second])
        })
    })
}

fn touch(state: &State<'_>, (assets, dt): (&AssetTables<'_>, f32), slots: [u32; 2]) -> bool {
    let [a, b] = slots.map(|slot| &state.shapes[slot as usize]);
    let [(ba, ma), (bb, mb)] =
        [a, b].map(|shape| (&state.bodies[shape.body as usize], &state.motions[shape.body as usize]));
    let (frame_a, frame_b) = (ma.local_to_center(ba, &a.pose), mb.local_to_center(bb, &b.pose));
    let mut b_in_a = relative(&frame_a, &frame_b, centers_between((a, &frame_a, ma), (b, &frame_b, mb)));
    b_in_a.rotation = b_in_a.rotation.renormalized();
    let way = length(mb.linear - ma.linear) * dt;
    let mut found = Manifolds::new();
    let solids = (&solid(a, assets), &solid(b, assets));
    collide::collide(solids.0, solids.1, &b_in_a, SPECULATIVE_DISTANCE + way, &mut found);
    !found.is_empty()
}
