//! How near a convex shape is to a shape: closest points and overlap.
//!
//! A shape is a closed set: shapes that touch overlap. Two overlapping shapes have no closest points; the moving
//! shape's origin stands for them.

use super::Nearness;
use super::frame::{Frame, widened};
use super::gjk::Pair;
use super::support::Core;
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
    let mut limit = limit;
    mesh.tree.search(
        Near::limit(limit),
        |bounds| near.bound(bounds),
        |index| {
            let corners = mesh.triangles[index as usize].vertices.map(|v| widened(mesh.vertices[v as usize]));
            let found = between(&Core::triangle(corners), (core, frame), index);
            if best.is_none_or(|best| (found.distance, found.child) < (best.distance, best.child)) {
                best = Some(found);
                limit = if found.distance < limit { found.distance } else { limit };
            }
            Near::limit(limit)
        },
    );
    best
}
