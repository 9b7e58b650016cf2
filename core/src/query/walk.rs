//! A query on the trees: boxes first, then the filter, then the exact test at the shape's pose.

use super::check_way;
use super::{ClosestPoint, Hit, Overlap, Probe, Queries, QueryFilter, QueryShape, Ray, Region, ShapeCast};
use crate::body::{BodyRow, Motion, Position};
use crate::collide::Solid;
use crate::collide::cast::children::Parts;
use crate::collide::cast::frame::{Frame, length, narrowed, widened};
use crate::collide::cast::support::Core;
use crate::collide::cast::{Contact, Nearness, nearest, ray, sweep};
use crate::collide::tree::search::{Near, Way};
use crate::error::Error;
use crate::handle::{BodyHandle, ShapeHandle};
use crate::math::Vec3;
use crate::pipeline::solid;
use crate::shape::{Geometry, ShapeRow};
use crate::validate;
use glam::DVec3;

/// Distances up to this factor beyond a limit are looked at.
const TIES: f64 = 1.0 + 1.0e-6;

fn lesser(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

/// Something to ask.
pub(super) trait Query: Sync {
    /// What is told of each thing that is found.
    type Found: Copy + Default + Send;

    /// Refuses bad numbers.
    fn check(&self, queries: &Queries<'_>) -> Result<(), Error>;

    /// Visits everything that is found, in no order. `visit` returns the distance up to which more is wanted,
    /// metres, infinity for all.
    fn walk(&self, queries: &Queries<'_>, filter: &QueryFilter, visit: impl FnMut(Self::Found) -> f64);

    /// What the order is by: distance, slot, part.
    fn key(found: &Self::Found) -> (f32, u32, u32);
}

/// A shape that passed the filter.
pub(super) struct Candidate<'a> {
    pub shape: ShapeHandle,
    pub body: BodyHandle,
    pub solid: Solid<'a>,
    /// Where it stands from the query's position, in world axes.
    pub frame: Frame,
}

impl QueryFilter {
    /// True when the query looks for the shape.
    fn passes(&self, shape: &ShapeRow, body: &BodyRow, handle: BodyHandle) -> bool {
        self.kinds.has(body.kind())
            && (self.sensors || !shape.is_sensor())
            && self.skip != Some(handle)
            && self.meets.is_none_or(|filter| filter.meets(&shape.filter))
    }
}

impl<'a> Queries<'a> {
    /// A shape as seen from a place; `None` when the filter keeps it out.
    pub(super) fn candidate(&self, slot: u32, filter: &QueryFilter, from: Position) -> Option<Candidate<'a>> {
        let row = &self.shapes[slot as usize];
        let index = row.body;
        let body = BodyHandle { index, generation: self.body_generations[index as usize] };
        let (body_row, motion): (_, &Motion) = (&self.bodies[index as usize], &self.motions[index as usize]);
        if !filter.passes(row, body_row, body) {
            return None;
        }
        let shape = ShapeHandle { index: slot, generation: self.shape_generations[slot as usize] };
        let local = motion.local_to_center(body_row, &row.pose);
        let position = motion.center.minus_wide(from) + widened(local.position);
        let frame = Frame::new(position, local.rotation);
        Some(Candidate { shape, body, solid: solid(row, &self.assets), frame })
    }

    /// Where a place is in the trees' coordinates.
    pub(super) fn in_trees(&self, place: Position) -> DVec3 {
        place.minus_wide(Position { sector: self.sector, offset: Vec3::ZERO })
    }

    /// Visits the shapes that something may meet on a way: `visit` takes a slot and the distance that still
    /// matters, and returns the new one.
    fn along(
        &self,
        (from, direction, length): (Position, DVec3, f64),
        bounds: (DVec3, DVec3),
        mut visit: impl FnMut(u32, f64) -> f64,
    ) {
        let mut limit = length;
        for tree in &self.trees {
            let Some(way) = Way::new(tree, (self.in_trees(from), direction, length), bounds) else {
                continue;
            };
            tree.search(
                way.limit(limit),
                |bounds| way.bound(bounds),
                |slot| {
                    limit = lesser(visit(slot, limit), limit);
                    way.limit(limit)
                },
            );
        }
    }

    /// Visits how near the shapes are to a solid at a frame (from a place, in world axes), up to a distance.
    fn around(
        &self,
        (from, parts, frame): (Position, &Parts<'_>, &Frame),
        (filter, limit): (&QueryFilter, f64),
        mut visit: impl FnMut(&Candidate<'_>, &Nearness) -> f64,
    ) {
        let (low, high) = parts.bounds(frame);
        let place = self.in_trees(from);
        let near = Near::new((place + low, place + high));
        let (mut limit, most) = (limit, limit);
        for tree in &self.trees {
            tree.search(
                Near::limit(limit),
                |bounds| near.bound(bounds),
                |slot| {
                    if let Some(candidate) = self.candidate(slot, filter, from) {
                        // What is told is rounded: ties are found, and decided by their order.
                        let within = lesser(limit * TIES, most);
                        if let Some(found) = candidate.nearest((parts, frame), within) {
                            limit = lesser(visit(&candidate, &found), limit);
                        }
                    }
                    Near::limit(limit)
                },
            );
        }
    }
}

impl Candidate<'_> {
    /// How near a solid at a frame is, up to a distance: its nearest part, of equally near ones that of the least
    /// part of this shape.
    pub(super) fn nearest(&self, (parts, frame): (&Parts<'_>, &Frame), limit: f64) -> Option<Nearness> {
        parts.at(frame).fold(None, |best: Option<Nearness>, (core, frame)| {
            let inner = self.frame.relative(&frame);
            let within = best.map_or(limit, |best| best.distance);
            match nearest::nearest(&self.solid, (&core, &inner), within) {
                Some(found) => nearest::first(best, found),
                None => best,
            }
        })
    }

    /// Where a solid that starts at a frame meets the shape first, up to a distance.
    fn meeting(
        &self,
        (parts, start): (&Parts<'_>, &Frame),
        (direction, length): (DVec3, f64),
        limit: f64,
    ) -> Option<Contact> {
        let direction = self.frame.unturn(direction);
        parts.at(start).fold(None, |best: Option<Contact>, (core, start)| {
            let moving = sweep::Moving { core, frame: self.frame.relative(&start), direction, length };
            let within = best.map_or(limit, |best| lesser(best.distance, limit));
            match sweep::cast(&self.solid, &moving, within) {
                Some(found) => sweep::first(best, found),
                None => best,
            }
        })
    }

    /// A contact as it is told.
    fn hit(&self, contact: &Contact, from: Position, way: f64) -> Hit {
        Hit {
            shape: self.shape,
            body: self.body,
            child: contact.child,
            distance: contact.distance as f32,
            fraction: (contact.distance / way) as f32,
            point: from.plus_wide(self.frame.transform(contact.point)),
            normal: narrowed(self.frame.turn(contact.normal)),
        }
    }
}

impl Query for Ray {
    type Found = Hit;

    fn check(&self, _: &Queries<'_>) -> Result<(), Error> {
        validate::position("origin", &self.origin)?;
        check_way(self.translation)
    }

    fn walk(&self, queries: &Queries<'_>, filter: &QueryFilter, mut visit: impl FnMut(Hit) -> f64) {
        let way = widened(self.translation);
        let length = length(way);
        let direction = way / length;
        let none = (DVec3::ZERO, DVec3::ZERO);
        queries.along((self.origin, direction, length), none, |slot, limit| {
            let mut limit = limit;
            if let Some(candidate) = queries.candidate(slot, filter, self.origin) {
                let frame = &candidate.frame;
                let origin = frame.untransform(DVec3::ZERO);
                let ray = ray::Ray { origin, direction: frame.unturn(direction), length };
                ray::cast(&candidate.solid, &ray, limit, |contact| {
                    let mut hit = candidate.hit(&contact, self.origin, length);
                    if contact.distance == 0.0 {
                        hit.point = self.origin;
                    }
                    limit = lesser(visit(hit), limit);
                    limit
                });
            }
            limit
        });
    }

    fn key(found: &Hit) -> (f32, u32, u32) {
        (found.distance, found.shape.index, found.child)
    }
}

impl Query for ShapeCast {
    type Found = Hit;

    fn check(&self, queries: &Queries<'_>) -> Result<(), Error> {
        self.shape.check(&queries.assets)?;
        check_way(self.translation)
    }

    fn walk(&self, queries: &Queries<'_>, filter: &QueryFilter, mut visit: impl FnMut(Hit) -> f64) {
        let row = self.shape.row();
        let Some(parts) = Parts::new(&solid(&row, &queries.assets)) else { return };
        let (from, start) = (self.shape.position, Frame::new(DVec3::ZERO, self.shape.rotation));
        let way = widened(self.translation);
        let length = length(way);
        let direction = way / length;
        queries.along((from, direction, length), parts.bounds(&start), |slot, limit| {
            let Some(candidate) = queries.candidate(slot, filter, from) else { return limit };
            let met = candidate.meeting((&parts, &start), (direction, length), limit);
            let Some(contact) = met else { return limit };
            let mut hit = candidate.hit(&contact, from, length);
            if contact.distance == 0.0 {
                hit.point = from;
            }
            visit(hit)
        });
    }

    fn key(found: &Hit) -> (f32, u32, u32) {
        (found.distance, found.shape.index, found.child)
    }
}

impl Query for Probe {
    type Found = ClosestPoint;

    fn check(&self, _: &Queries<'_>) -> Result<(), Error> {
        validate::position("position", &self.position)?;
        validate::in_range("max_distance", self.max_distance, 0.0, super::WAY_MAX)
    }

    fn walk(&self, queries: &Queries<'_>, filter: &QueryFilter, mut visit: impl FnMut(ClosestPoint) -> f64) {
        let place = (self.position, &Parts::One(Core::POINT), &Frame::IDENTITY);
        let limit = f64::from(self.max_distance);
        queries.around(place, (filter, limit), |candidate, found| {
            let is_inside = found.distance == 0.0;
            let point = candidate.frame.transform(found.point);
            visit(ClosestPoint {
                shape: candidate.shape,
                body: candidate.body,
                child: found.child,
                distance: found.distance as f32,
                point: if is_inside { self.position } else { self.position.plus_wide(point) },
                normal: narrowed(candidate.frame.turn(found.normal)),
            })
        });
    }

    fn key(found: &ClosestPoint) -> (f32, u32, u32) {
        (found.distance, found.shape.index, found.child)
    }
}

impl Region {
    /// As a shape; `None` for a point.
    fn shape(&self) -> Option<QueryShape> {
        match *self {
            Region::Point(_) => None,
            Region::Box { center, half_extents } => {
                let geometry = Geometry::Box { half_extents };
                let rotation = crate::math::Rotation::IDENTITY;
                Some(QueryShape { geometry, position: center, rotation })
            }
            Region::Shape(shape) => Some(shape),
        }
    }
}

impl Query for Region {
    type Found = Overlap;

    fn check(&self, queries: &Queries<'_>) -> Result<(), Error> {
        match (self, self.shape()) {
            (_, Some(shape)) => shape.check(&queries.assets),
            (Region::Point(place), None) => validate::position("position", place),
            _ => Ok(()),
        }
    }

    fn walk(&self, queries: &Queries<'_>, filter: &QueryFilter, mut visit: impl FnMut(Overlap) -> f64) {
        let mut take = |candidate: &Candidate<'_>, found: &Nearness| {
            visit(Overlap { shape: candidate.shape, body: candidate.body, child: found.child });
            0.0
        };
        if let Region::Point(place) = *self {
            queries.around((place, &Parts::One(Core::POINT), &Frame::IDENTITY), (filter, 0.0), take);
        } else if let Some(shape) = self.shape() {
            let row = shape.row();
            let frame = Frame::new(DVec3::ZERO, shape.rotation);
            if let Some(parts) = Parts::new(&solid(&row, &queries.assets)) {
                queries.around((shape.position, &parts, &frame), (filter, 0.0), &mut take);
            }
        }
    }

    fn key(found: &Overlap) -> (f32, u32, u32) {
        (0.0, found.shape.index, found.child)
    }
}
