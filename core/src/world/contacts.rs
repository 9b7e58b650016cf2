//! Reading contacts.

use super::World;
use crate::arena::Line;
use crate::body::Position;
use crate::collide::{self, Manifolds};
use crate::config::SPECULATIVE_DISTANCE;
use crate::handle::{BodyHandle, ShapeHandle};
use crate::math::Vec3;
use crate::pipeline::meeting::{centers_between, relative};
use crate::pipeline::solid;
use crate::pool;
use crate::shape::{FRESH, GEOMETRY_HALF_SPACE};
use crate::state::ContactRow;

/// A contact of the last step: a manifold of 1 to 4 points between two shapes, with its impulses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// The two shapes, lower slot first. The normal goes from the first to the second.
    pub shapes: [ShapeHandle; 2],
    /// Their bodies.
    pub bodies: [BodyHandle; 2],
    /// Part of a concave shape: its least triangle; 0 else.
    pub child: u32,
    /// Number of points, 1..=4.
    pub points: u32,
    /// Normal impulses of the points in the last substep, N s: force times substep. Not negative.
    pub impulses: [f32; 4],
    /// Friction impulse on the second body in the last substep, N s in the world.
    pub friction: Vec3,
    /// Impulse of the twist about the normal on the second body, N m s.
    pub twist: f32,
    /// Impulse of the torque on the second body that resists rolling and spinning, N m s in the world.
    pub resistance: Vec3,
    /// Length of the substeps in which the impulses act, seconds: shorter where an island is refined (see
    /// [`Settings::refine`](crate::Settings::refine)).
    pub substep: f32,
}

impl Contact {
    /// Sum of the normal impulses, N s.
    pub fn normal_impulse(&self) -> f32 {
        self.impulses[..self.points as usize].iter().fold(0.0, |sum, x| sum + x)
    }

    /// The normal force in the last substep, N.
    pub fn normal_force(&self) -> f32 {
        self.normal_impulse() / self.substep
    }
}

/// The geometry of a contact at the bodies' poses now.
#[derive(Clone, Debug)]
pub struct WorldManifold {
    /// Part of a concave shape: its least triangle; 0 else.
    pub child: u32,
    /// Unit normal from the first shape to the second.
    pub normal: Vec3,
    /// Points of contact.
    pub points: heapless::Vec<ContactPoint, 4>,
}

/// A point of a [`WorldManifold`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactPoint {
    /// Middle between the surfaces.
    pub position: Position,
    /// Distance of the surfaces, metres; negative when they overlap.
    pub separation: f32,
    /// Names the features that touch.
    pub feature: u32,
}

impl<M: AsRef<[Line]> + AsMut<[Line]>> World<M> {
    /// Contacts of the last step, in the order of their shapes' slots. Those of shapes that were removed, moved or
    /// changed since are left out.
    pub fn contacts(&self) -> impl Iterator<Item = Contact> + '_ {
        let rows = self.layout.state.contacts.of(self.state());
        self.living(&rows[..self.header().contacts as usize])
    }

    /// Contacts of bodies that sleep, with each other and with what rests, as they were when they fell asleep;
    /// in the order of their shapes' slots. In the step in which a body falls asleep its contacts are among
    /// [`World::contacts`], too. Those of shapes that were removed, moved or changed since are left out.
    pub fn sleeping_contacts(&self) -> impl Iterator<Item = Contact> + '_ {
        let rows = self.layout.state.asleep_contacts.of(self.state());
        self.living(&rows[..self.header().asleep_contacts as usize])
    }

    /// The contacts of shapes that are what they were in the last step.
    fn living<'a>(&'a self, rows: &'a [ContactRow]) -> impl Iterator<Item = Contact> + 'a {
        let spans = &self.layout.state;
        let used = spans.shape_used.of(self.state());
        let shapes = spans.shapes.of(self.state());
        let lives = move |slot: u32| pool::is_used(used, slot) && shapes[slot as usize].flags & FRESH == 0;
        rows.iter().filter(move |row| lives(row.pair.a) && lives(row.pair.b)).map(|row| self.contact(row))
    }

    fn contact(&self, row: &ContactRow) -> Contact {
        let spans = &self.layout.state;
        let shape_generations = spans.shape_generations.of(self.state());
        let body_generations = spans.body_generations.of(self.state());
        let shapes = spans.shapes.of(self.state());
        let slots = [row.pair.a, row.pair.b];
        let (bodies, refined) = (spans.bodies.of(self.state()), spans.refined.of(self.state()));
        let is_refined = self.header().refine != 0
            && slots
                .map(|slot| shapes[slot as usize].body)
                .into_iter()
                .any(|body| bodies[body as usize].is_dynamic() && pool::is_used(refined, body));
        Contact {
            shapes: slots.map(|index| ShapeHandle { index, generation: shape_generations[index as usize] }),
            bodies: slots.map(|slot| {
                let index = shapes[slot as usize].body;
                BodyHandle { index, generation: body_generations[index as usize] }
            }),
            child: row.tag.child(),
            points: row.tag.points() as u32,
            impulses: core::array::from_fn(|i| if i < row.tag.points() { row.impulses[i] } else { 0.0 }),
            friction: row.friction,
            twist: row.twist,
            resistance: if row.can_resist() { row.resistance() } else { Vec3::ZERO },
            substep: self.settings().of_tier(usize::from(is_refined)).substep(),
        }
    }

    /// The manifolds of two shapes at the poses now, points up to the speculative distance apart included. Visits
    /// none when the shapes do not touch or a handle is stale.
    pub fn manifolds(&self, a: ShapeHandle, b: ShapeHandle, mut visit: impl FnMut(&WorldManifold)) {
        let (Ok(a), Ok(b)) = (self.shape_slot(a), self.shape_slot(b)) else { return };
        let spans = &self.layout.state;
        let shapes = spans.shapes.of(self.state());
        let (bodies, motions) = (spans.bodies.of(self.state()), spans.motions.of(self.state()));
        let side = |slot: usize| {
            (&shapes[slot], &bodies[shapes[slot].body as usize], &motions[shapes[slot].body as usize])
        };
        let ((sa, ba, ma), (sb, bb, mb)) = (side(a), side(b));
        let frame_a = ma.local_to_center(ba, &sa.pose);
        let frame_b = mb.local_to_center(bb, &sb.pose);
        let centers = centers_between((sa, &frame_a, ma), (sb, &frame_b, mb));
        let b_in_a = relative(&frame_a, &frame_b, centers);
        // Far out on a half-space, points are known from the other body.
        let is_near = sa.kind != GEOMETRY_HALF_SPACE || centers == mb.center.minus(ma.center);
        let place = |from_a: Vec3| {
            if is_near { ma.center.plus(from_a) } else { mb.center.plus(from_a - centers) }
        };
        let tables = self.asset_tables();
        let mut found = Manifolds::new();
        collide::collide(&solid(sa, &tables), &solid(sb, &tables), &b_in_a, SPECULATIVE_DISTANCE, &mut found);
        for manifold in &found {
            let points = manifold.points.iter().map(|point| ContactPoint {
                position: place(frame_a.transform(point.position)),
                separation: point.separation,
                feature: point.feature,
            });
            visit(&WorldManifold {
                child: manifold.child,
                normal: frame_a.rotation.rotate(manifold.normal),
                points: points.collect(),
            });
        }
    }

    /// Visits the separation of every point of every contact at the poses now, metres; negative when overlapping.
    pub fn separations(&self, mut visit: impl FnMut(f32)) {
        let mut before = None;
        for contact in self.contacts() {
            // A mesh has several contacts with one shape: one look finds all.
            if before != Some(contact.shapes) {
                self.manifolds(contact.shapes[0], contact.shapes[1], |manifold| {
                    manifold.points.iter().for_each(|point| visit(point.separation));
                });
            }
            before = Some(contact.shapes);
        }
    }

    /// Deepest overlap of all contacts at the poses now, metres; 0 when there is none.
    pub fn penetration_max(&self) -> f32 {
        let mut deepest = 0.0;
        self.separations(|separation| deepest = crate::math::max(deepest, -separation));
        deepest
    }
}
