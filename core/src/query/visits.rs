//! What is in a sensor: a query of a shape of the world, at its own pose.

use super::walk::{Candidate, Query};
use super::{Found, Queries, QueryFilter};
use crate::collide::Solid;
use crate::collide::bounds;
use crate::collide::cast::children::Parts;
use crate::collide::cast::frame::{Frame, widened};
use crate::collide::cast::nearest::nearest;
use crate::collide::tree::search::Near;
use crate::error::Error;
use crate::event::Visit;
use crate::handle::{BodyHandle, ShapeHandle};
use crate::math::{Pose, Vec3};
use crate::pipeline::broadphase::MOVED;
use crate::pipeline::solid;
use glam::DVec3;

/// Boxes of surfaces are grown by this fraction of their coordinates: more than the rounding.
const SLACK: f32 = 1.0e-5;

/// A sensor that looks for what is in it.
struct Sensor<'s> {
    slot: u32,
    marks: Option<&'s [u8]>,
}

impl Queries<'_> {
    /// What is in the sensor of a slot, ascending by slot; what finds no room has the highest ones. With
    /// `marks` those of shapes that rest are left out that are not marked as `MOVED`, and all of them with an
    /// empty slice.
    pub(crate) fn visits(&self, slot: u32, marks: Option<&[u8]>, visits: &mut [Visit]) -> Found {
        // Nothing about a sensor of the world is refused.
        self.all(&Sensor { slot, marks }, &QueryFilter::ALL, visits).unwrap_or_default()
    }
}

/// A sensor's geometry.
enum Body<'a> {
    /// Convex parts.
    Parts(Parts<'a>),
    /// A half-space, a mesh or a height field.
    Surface(Solid<'a>),
}

impl<'a> Body<'a> {
    fn new(solid: &Solid<'a>) -> Self {
        Parts::new(solid).map_or(Self::Surface(*solid), Self::Parts)
    }

    /// Least and greatest coordinates at a frame.
    fn bounds(&self, (frame, local): (&Frame, &Pose)) -> (DVec3, DVec3) {
        match self {
            Self::Parts(parts) => parts.bounds(frame),
            Self::Surface(solid) => {
                let tight = bounds::aabb(solid, local);
                let slack = |v: Vec3| v.abs() * SLACK;
                (widened(tight.min - slack(tight.min)), widened(tight.max + slack(tight.max)))
            }
        }
    }

    /// True when it overlaps a shape, or touches it.
    fn overlaps(&self, frame: &Frame, other: &Candidate<'_>) -> bool {
        match self {
            Self::Parts(parts) => other.nearest((parts, frame), 0.0).is_some(),
            Self::Surface(solid) => Parts::new(&other.solid).is_some_and(|parts| {
                parts
                    .at(&other.frame)
                    .any(|(core, place)| nearest(solid, (&core, &frame.relative(&place)), 0.0).is_some())
            }),
        }
    }
}

impl Query for Sensor<'_> {
    type Found = Visit;

    fn check(&self, _: &Queries<'_>) -> Result<(), Error> {
        Ok(())
    }

    fn walk(&self, queries: &Queries<'_>, _: &QueryFilter, mut visit: impl FnMut(Visit) -> f64) {
        let row = &queries.shapes[self.slot as usize];
        let Some(kinds) = row.sensor() else { return };
        let index = row.body;
        let (body, motion) = (&queries.bodies[index as usize], &queries.motions[index as usize]);
        let sensor_body = BodyHandle { index, generation: queries.body_generations[index as usize] };
        let generation = queries.shape_generations[self.slot as usize];
        let sensor = ShapeHandle { index: self.slot, generation };
        let filter = QueryFilter { meets: Some(row.filter), skip: Some(sensor_body), kinds, sensors: false };
        let local = motion.local_to_center(body, &row.pose);
        let frame = Frame::new(widened(local.position), local.rotation);
        let shape = Body::new(&solid(row, &queries.assets));
        let (low, high) = shape.bounds((&frame, &local));
        let place = queries.in_trees(motion.center);
        let near = Near::new((place + low, place + high));
        let limit = Near::limit(0.0);
        // The first tree has what rests.
        for (tree, marks) in queries.trees.iter().zip([self.marks, None]) {
            if marks.is_some_and(<[u8]>::is_empty) {
                continue;
            }
            tree.search(
                limit,
                |bounds| near.bound(bounds),
                |slot| {
                    let looks = marks.is_none_or(|marks| marks[slot as usize] & MOVED != 0);
                    if looks
                        && let Some(other) = queries.candidate(slot, &filter, motion.center)
                        && shape.overlaps(&frame, &other)
                    {
                        let (visitor, visitor_body) = (other.shape, other.body);
                        visit(Visit { sensor, visitor, sensor_body, visitor_body });
                    }
                    limit
                },
            );
        }
    }

    fn key(found: &Visit) -> (f32, u32, u32) {
        (0.0, found.visitor.index, 0)
    }
}
