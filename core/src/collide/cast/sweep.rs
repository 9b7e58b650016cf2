//! Where a convex shape that moves along a line meets a shape.
//!
//! The distance of two convex sets is a convex function of the way `s`, and its slope is `-n . d`, with `n` the
//! unit vector from the moving shape to the other and `d` the direction of motion. So Newton's method from the
//! start never passes the first touch: each step goes to where the plane that separates the shapes now is
//! reached (conservative advancement; van den Bergen, "Ray Casting against General Convex Objects", 2004, takes
//! the same steps within its GJK). It ends in a few steps at a plain hit, and halves what is left in a grazing
//! one.
//!
//! Shapes that overlap at the start, or touch, meet at distance 0 with the normal against the motion, and the point
//! of contact is the moving shape's origin.

use super::Contact;
use super::children;
use super::frame::{Frame, widened};
use super::gjk::{Pair, Separation};
use super::grid;
use super::ray::Ray;
use super::support::Core;
use crate::collide::compound::Compound;
use crate::collide::height_field::HeightField;
use crate::collide::tree::search::Way;
use crate::collide::{Mesh, Solid};
use glam::DVec3;

/// Most steps along the way: a grazing contact halves the rest with each.
const STEPS_MAX: usize = 100;
/// Shapes touch when they are nearer than this fraction of their extent.
const TOUCH: f64 = 1.0e-10;
/// A step from a touch to the contact is taken when it is at most so many touches long.
const REST_MAX: f64 = 1.0e4;
/// Contacts up to this factor beyond the limit are found all the same, so that ties are decided by their order.
const LIMIT_SLACK: f64 = 1.0 + 1.0e-6;

/// A convex shape in motion, in the frame of what it may meet.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Moving<'a> {
    pub core: Core<'a>,
    /// Where it starts.
    pub frame: Frame,
    /// Where it goes: a unit vector.
    pub direction: DVec3,
    /// How far, metres.
    pub length: f64,
}

impl Moving<'static> {
    /// A point that moves along a ray.
    pub fn point(ray: &Ray) -> Self {
        let frame = Frame::IDENTITY.at(ray.origin);
        Self { core: Core::POINT, frame, direction: ray.direction, length: ray.length }
    }
}

impl Moving<'_> {
    /// The contact of shapes that touch at the start.
    fn inside(&self, child: u32) -> Contact {
        Contact { distance: 0.0, normal: -self.direction, point: self.frame.position, child }
    }

    /// The box around the shape relative to its origin.
    fn bounds(&self) -> (DVec3, DVec3) {
        self.core.bounds(&self.frame.at(DVec3::ZERO))
    }
}

/// The first contact with a shape; of the parts of a concave one the nearest, then the one of least index. Contacts
/// farther than `limit` metres may be left out.
pub(crate) fn cast(solid: &Solid<'_>, moving: &Moving<'_>, limit: f64) -> Option<Contact> {
    match *solid {
        Solid::HalfSpace => half_space(moving),
        Solid::Mesh(mesh) => cast_mesh(&mesh, moving, limit),
        Solid::HeightField(field) => cast_field(&field, moving, limit),
        Solid::Compound(compound) => cast_compound(&compound, moving, limit),
        _ => convex(&Core::new(solid)?, moving, (limit, 0)),
    }
}

fn half_space(moving: &Moving<'_>) -> Option<Contact> {
    let down = moving.frame.unturn(DVec3::NEG_Z);
    let lowest = moving.frame.transform(moving.core.support(down)) - DVec3::Z * moving.core.radius;
    if lowest.z <= 0.0 {
        return Some(moving.inside(0));
    }
    if moving.direction.z >= 0.0 {
        return None;
    }
    let distance = -lowest.z / moving.direction.z;
    let point = lowest + moving.direction * distance;
    (distance <= moving.length).then_some(Contact { distance, normal: DVec3::Z, point, child: 0 })
}

fn cast_mesh(mesh: &Mesh<'_>, moving: &Moving<'_>, limit: f64) -> Option<Contact> {
    let way = (moving.frame.position, moving.direction, moving.length);
    let way = Way::new(&mesh.tree, way, moving.bounds())?;
    let mut best: Option<Contact> = None;
    mesh.tree.search(
        way.limit(limit),
        |bounds| way.bound(bounds),
        |index| {
            let corners = mesh.triangles[index as usize].vertices.map(|v| widened(mesh.vertices[v as usize]));
            let within = best.map_or(limit, |best| best.distance);
            if let Some(found) = convex(&Core::triangle(corners), moving, (within, index)) {
                best = first(best, found);
            }
            way.limit(best.map_or(limit, |best| best.distance))
        },
    );
    best
}

fn cast_field(field: &HeightField<'_>, moving: &Moving<'_>, limit: f64) -> Option<Contact> {
    let mut best: Option<Contact> = None;
    let way = (moving.frame.position, moving.direction, moving.length);
    grid::along(field, way, moving.bounds(), limit, |index, corners| {
        let within = best.map_or(limit, |best| best.distance);
        if let Some(found) = convex(&Core::triangle(corners), moving, (within, index)) {
            best = first(best, found);
        }
        best.map_or(limit, |best| best.distance)
    });
    best
}

fn cast_compound(compound: &Compound<'_>, moving: &Moving<'_>, limit: f64) -> Option<Contact> {
    let way = (moving.frame.position, moving.direction, moving.length);
    let way = Way::new(&compound.tree, way, children::grown(compound, moving.bounds()))?;
    let mut best: Option<Contact> = None;
    compound.tree.search(
        way.limit(limit),
        |bounds| way.bound(bounds),
        |index| {
            let within = best.map_or(limit, |best| best.distance);
            let (child, pose) = compound.child(index);
            let frame = Frame::of(&pose);
            let direction = frame.unturn(moving.direction);
            let inner = Moving { frame: frame.relative(&moving.frame), direction, ..*moving };
            if let Some(found) = Core::new(&child).and_then(|core| convex(&core, &inner, (within, index))) {
                best = first(best, found.outside(&frame));
            }
            way.limit(best.map_or(limit, |best| best.distance))
        },
    );
    best
}

/// The first of two contacts, in order of distance and part.
pub(crate) fn first(best: Option<Contact>, found: Contact) -> Option<Contact> {
    best.filter(|best| (best.distance, best.child) <= (found.distance, found.child)).or(Some(found))
}

/// The first contact of two convex shapes.
fn convex(other: &Core<'_>, moving: &Moving<'_>, (limit, child): (f64, u32)) -> Option<Contact> {
    let mut pair = Pair { a: other, b: &moving.core, b_in_a: moving.frame };
    let radius = other.radius + moving.core.radius;
    let touch = TOUCH * (other.extent() + moving.core.extent());
    let limit = if limit < moving.length { limit * LIMIT_SLACK } else { moving.length };
    let mut simplex = pair.start();
    let mut way = 0.0;
    let mut found = pair.separation(&mut simplex);
    if found.distance <= radius {
        return Some(moving.inside(child));
    }
    for _ in 0..STEPS_MAX {
        let gap = found.distance - radius;
        let closing = found.direction.dot(moving.direction);
        if closing <= 0.0 && (gap > touch || way == 0.0) {
            // The distance is convex: it will not fall again.
            return None;
        }
        if gap <= touch {
            let rest = if gap > 0.0 && closing > 0.0 { gap / closing } else { 0.0 };
            // A grazing touch ends here: the rest of the way could be any length.
            way += if rest <= touch * REST_MAX { rest } else { 0.0 };
            let normal = -found.direction;
            let point = found.on_a + normal * other.radius;
            return (way <= moving.length).then_some(Contact { distance: way, normal, point, child });
        }
        let ahead = advance(&found, (gap, radius, touch), closing);
        way += ahead;
        if way > limit {
            return None;
        }
        pair.shift(moving.direction * ahead, &mut simplex);
        let mut next = pair.separation(&mut simplex);
        let mut back = touch / closing;
        while next.distance <= 0.0 && back < ahead {
            // Rounding made an overlap of the touch: a little less far there are nearest points.
            way -= back;
            pair.shift(moving.direction * -back, &mut simplex);
            next = pair.separation(&mut simplex);
            back *= 4.0;
        }
        // What overlaps by rounding has no direction: that of the step before serves.
        let direction = if next.distance > 0.0 { next.direction } else { found.direction };
        found = Separation { direction, ..next };
    }
    None
}

/// How far the shapes may move until their separating plane is nearly reached, metres: half a touch is left, so
/// that rounding makes no overlap of it.
fn advance(found: &Separation, (gap, radius, touch): (f64, f64, f64), closing: f64) -> f64 {
    let proved = found.least - radius - 0.5 * touch;
    // Where rounding leaves no proof the distance itself is right to rounding; half of it is safe.
    if proved > 0.1 * gap { proved / closing } else { 0.4 * gap / closing }
}

#[cfg(test)]
mod tests;
