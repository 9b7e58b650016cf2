//! How near a convex shape is to a shape: closest points and overlap.
//!
//! A shape is a closed set: shapes that touch overlap. Two overlapping shapes have no closest points; the moving
//! shape's origin stands for them.

use super::Nearness;
use super::frame::{Frame, widened};
use super::gjk::Pair;
use super::support::Core;
use super::{children, grid};
use crate::collide::compound::Compound;
use crate::collide::height_field::HeightField;
use crate::collide::tree::search::Near;
use crate::collide::{Mesh, Solid};
use glam::DVec3;

/// How near a convex shape at a frame is to a shape, up to `limit` metres; of the parts of a concave one the
/// nearest, then the one of least index.
pub(crate) fn nearest(solid: &Solid<'_>, (core, frame): (&Core<'_>, &Frame), limit: f64) -> Option<Nearness> {
    let found = match *solid {
        Solid::HalfSpace => {
            let lowest = frame.transform(core.support(frame.unturn(DVec3::NEG_Z)));
            let distance = lowest.z - core.radius;
            let point = DVec3::new(lowest.x, lowest.y, 0.0);
            if distance <= 0.0 {
                overlap(frame, 0)
            } else {
                Nearness { distance, normal: DVec3::Z, point, child: 0 }
            }
        }
        Solid::Mesh(mesh) => nearest_triangle(&mesh, (core, frame), limit)?,
        Solid::HeightField(field) => nearest_cell(&field, (core, frame), limit)?,
        Solid::Compound(compound) => nearest_child(&compound, (core, frame), limit)?,
        _ => between(&Core::new(solid)?, (core, frame), 0),
    };
    (found.distance <= limit).then_some(found)
}

fn overlap(frame: &Frame, child: u32) -> Nearness {
    Nearness { distance: 0.0, normal: DVec3::ZERO, point: frame.position, child }
}

fn between(other: &Core<'_>, (core, frame): (&Core<'_>, &Frame), child: u32) -> Nearness {
    let pair = Pair { a: other, b: core, b_in_a: *frame };
    let found = pair.separation(&mut pair.start());
    let distance = found.distance - other.radius - core.radius;
    if distance <= 0.0 {
        return overlap(frame, child);
    }
    let normal = -found.direction;
    Nearness { distance, normal, point: found.on_a + normal * other.radius, child }
}

fn nearest_triangle(mesh: &Mesh<'_>, (core, frame): (&Core<'_>, &Frame), limit: f64) -> Option<Nearness> {
    let near = Near::new(core.bounds(frame));
    let mut best: Option<Nearness> = None;
    mesh.tree.search(
        Near::limit(limit),
        |bounds| near.bound(bounds),
        |index| {
            let corners = mesh.triangles[index as usize].vertices.map(|v| widened(mesh.vertices[v as usize]));
            let found = between(&Core::triangle(corners), (core, frame), index);
            best = first(best, found);
            Near::limit(reach(best, limit))
        },
    );
    best
}

fn nearest_cell(field: &HeightField<'_>, (core, frame): (&Core<'_>, &Frame), limit: f64) -> Option<Nearness> {
    let mut best: Option<Nearness> = None;
    grid::around(field, core.bounds(frame), limit, |index, corners| {
        best = first(best, between(&Core::triangle(corners), (core, frame), index));
        reach(best, limit)
    });
    best
}

fn nearest_child(
    compound: &Compound<'_>,
    (core, frame): (&Core<'_>, &Frame),
    limit: f64,
) -> Option<Nearness> {
    let near = Near::new(children::grown(compound, core.bounds(frame)));
    let mut best: Option<Nearness> = None;
    compound.tree.search(
        Near::limit(limit),
        |bounds| near.bound(bounds),
        |index| {
            let (child, pose) = compound.child(index);
            let place = Frame::of(&pose);
            if let Some(other) = Core::new(&child) {
                let found = between(&other, (core, &place.relative(frame)), index);
                best = first(best, found.outside(&place));
            }
            Near::limit(reach(best, limit))
        },
    );
    best
}

/// The first of two, in order of distance and part.
pub(crate) fn first(best: Option<Nearness>, found: Nearness) -> Option<Nearness> {
    best.filter(|best| (best.distance, best.child) <= (found.distance, found.child)).or(Some(found))
}

/// How far matters when this was found.
fn reach(best: Option<Nearness>, limit: f64) -> f64 {
    best.map_or(limit, |best| if best.distance < limit { best.distance } else { limit })
}
