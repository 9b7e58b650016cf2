//! Where a ray meets a shape: closed forms.
//!
//! A shape is a closed set: a ray that starts in it, or on its surface, meets it at distance 0 with the normal
//! turned against the ray. Otherwise the ray meets it where it enters; the normal is the outward one there. A
//! mesh has no inside and two sides: the normal is that of the side the ray comes from, and a ray in a
//! triangle's plane passes.
//!
//! Half-spaces, and convex shapes without a closed form here, are met by a point that moves ([`sweep`]).

use super::frame::{Frame, length, widened};
use super::{Contact, axial, children, grid, sweep};
use crate::collide::compound::Compound;
use crate::collide::height_field::HeightField;
use crate::collide::tree::search::Way;
use crate::collide::{Hull, Mesh, Solid};
use glam::DVec3;

/// A ray in a shape's frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ray {
    /// Where it starts, metres.
    pub origin: DVec3,
    /// Where it goes: a unit vector.
    pub direction: DVec3,
    /// How far, metres.
    pub length: f64,
}

impl Ray {
    /// The contact of a ray that starts inside.
    pub fn inside(&self, child: u32) -> Contact {
        Contact { distance: 0.0, normal: -self.direction, point: self.origin, child }
    }

    pub(super) fn contact(&self, distance: f64, normal: DVec3, child: u32) -> Option<Contact> {
        let point = self.origin + self.direction * distance;
        (distance <= self.length).then_some(Contact { distance, normal, point, child })
    }
}

/// Visits where the ray meets a shape: once where it enters a convex one, at every triangle of a mesh, in no order.
///
/// Contacts farther than `limit` metres may be left out; `visit` returns the limit from then on.
pub(crate) fn cast(solid: &Solid<'_>, ray: &Ray, limit: f64, mut visit: impl FnMut(Contact) -> f64) {
    let found = match *solid {
        Solid::Mesh(mesh) => return cast_mesh(&mesh, ray, limit, visit),
        Solid::HeightField(field) => return cast_field(&field, ray, limit, visit),
        Solid::Compound(compound) => return cast_compound(&compound, ray, limit, visit),
        _ => convex(solid, ray, limit),
    };
    if let Some(contact) = found {
        visit(contact);
    }
}

/// Where the ray enters a convex shape or a half-space.
fn convex(solid: &Solid<'_>, ray: &Ray, limit: f64) -> Option<Contact> {
    match *solid {
        Solid::Sphere { radius } => sphere(ray, DVec3::ZERO, f64::from(radius)),
        Solid::Capsule { half_height, radius } => capsule(ray, f64::from(half_height), f64::from(radius)),
        Solid::Box { half_extents } => cuboid(ray, widened(half_extents)),
        Solid::Hull(hull) => polytope(ray, &hull),
        Solid::Cylinder { half_height, radius } => {
            axial::cylinder(ray, f64::from(half_height), f64::from(radius))
        }
        Solid::Cone { half_height, radius } => axial::cone(ray, f64::from(half_height), f64::from(radius)),
        _ => sweep::cast(solid, &sweep::Moving::point(ray), limit),
    }
}

fn sphere(ray: &Ray, center: DVec3, radius: f64) -> Option<Contact> {
    let from = ray.origin - center;
    let outside = from.dot(from) - radius * radius;
    if outside <= 0.0 {
        return Some(ray.inside(0));
    }
    let along = -from.dot(ray.direction);
    // The center's distance from the line, from the vector and not from squares (Haines, Gunther, Akenine-Moller,
    // "Precision improvements for ray/sphere intersection", 2019).
    let beside = from + ray.direction * along;
    let half_chord_squared = radius * radius - beside.dot(beside);
    if along <= 0.0 || half_chord_squared < 0.0 {
        return None;
    }
    // The nearer root by the product of both, which is `outside`: no cancellation.
    let distance = outside / (along + libm::sqrt(half_chord_squared));
    let normal = from + ray.direction * distance;
    ray.contact(distance, normal / length(normal), 0)
}

/// The union of a cylinder and a ball at each end: the first entry into any of them.
fn capsule(ray: &Ray, half_height: f64, radius: f64) -> Option<Contact> {
    let nearest = |z: f64| {
        let low = if z < -half_height { -half_height } else { z };
        if low > half_height { half_height } else { low }
    };
    let from = ray.origin - DVec3::new(0.0, 0.0, nearest(ray.origin.z));
    if from.dot(from) <= radius * radius {
        return Some(ray.inside(0));
    }
    let mut best = None;
    let mut take = |found: Option<Contact>| {
        if let Some(found) = found
            && best.is_none_or(|best: Contact| found.distance < best.distance)
        {
            best = Some(found);
        }
    };
    take(cylinder_side(ray, half_height, radius));
    take(sphere(ray, DVec3::new(0.0, 0.0, half_height), radius));
    take(sphere(ray, DVec3::new(0.0, 0.0, -half_height), radius));
    best
}

/// The curved side of a cylinder about z.
fn cylinder_side(ray: &Ray, half_height: f64, radius: f64) -> Option<Contact> {
    let flat = |v: DVec3| DVec3::new(v.x, v.y, 0.0);
    let (from, direction) = (flat(ray.origin), flat(ray.direction));
    let speed_squared = direction.dot(direction);
    let outside = from.dot(from) - radius * radius;
    let along = -from.dot(direction);
    if along <= 0.0 || outside <= 0.0 || speed_squared <= 0.0 {
        return None;
    }
    let beside = from + direction * (along / speed_squared);
    let half_chord_squared = (radius * radius - beside.dot(beside)) * speed_squared;
    if half_chord_squared < 0.0 {
        return None;
    }
    let distance = outside / (along + libm::sqrt(half_chord_squared));
    let z = ray.origin.z + ray.direction.z * distance;
    if z < -half_height || z > half_height {
        return None;
    }
    let normal = from + direction * distance;
    ray.contact(distance, normal / length(normal), 0)
}

fn cuboid(ray: &Ray, half: DVec3) -> Option<Contact> {
    let (mut enter, mut exit) = (f64::NEG_INFINITY, f64::INFINITY);
    let mut normal = DVec3::ZERO;
    for axis in 0..3 {
        let (from, direction) = (ray.origin[axis], ray.direction[axis]);
        if direction == 0.0 {
            if from < -half[axis] || from > half[axis] {
                return None;
            }
            continue;
        }
        let side = if direction > 0.0 { half[axis] } else { -half[axis] };
        let (near, far) = ((-side - from) / direction, (side - from) / direction);
        if near > enter {
            enter = near;
            normal = DVec3::ZERO;
            normal[axis] = if direction > 0.0 { -1.0 } else { 1.0 };
        }
        exit = if far < exit { far } else { exit };
    }
    if enter > exit || exit < 0.0 {
        return None;
    }
    if enter <= 0.0 { Some(ray.inside(0)) } else { ray.contact(enter, normal, 0) }
}

fn polytope(ray: &Ray, hull: &Hull<'_>) -> Option<Contact> {
    let (mut enter, mut exit) = (f64::NEG_INFINITY, f64::INFINITY);
    let mut normal = DVec3::ZERO;
    for plane in hull.planes {
        let n = widened(plane.normal);
        let height = n.dot(ray.origin) - f64::from(plane.offset);
        let speed = n.dot(ray.direction);
        if speed == 0.0 {
            if height > 0.0 {
                return None;
            }
            continue;
        }
        let at = -height / speed;
        if speed < 0.0 && at > enter {
            (enter, normal) = (at, n);
        } else if speed > 0.0 && at < exit {
            exit = at;
        }
    }
    if enter > exit || exit < 0.0 {
        return None;
    }
    if enter <= 0.0 { Some(ray.inside(0)) } else { ray.contact(enter, normal / length(normal), 0) }
}

fn cast_mesh(mesh: &Mesh<'_>, ray: &Ray, limit: f64, mut visit: impl FnMut(Contact) -> f64) {
    let way = (ray.origin, ray.direction, ray.length);
    let Some(way) = Way::new(&mesh.tree, way, (DVec3::ZERO, DVec3::ZERO)) else { return };
    let mut limit = limit;
    mesh.tree.search(
        way.limit(limit),
        |bounds| way.bound(bounds),
        |index| {
            let corners = mesh.triangles[index as usize].vertices.map(|v| widened(mesh.vertices[v as usize]));
            if let Some(contact) = triangle(ray, corners, index) {
                limit = visit(contact);
            }
            way.limit(limit)
        },
    );
}

fn cast_field(field: &HeightField<'_>, ray: &Ray, limit: f64, mut visit: impl FnMut(Contact) -> f64) {
    let mut limit = limit;
    let way = (ray.origin, ray.direction, ray.length);
    grid::along(field, way, (DVec3::ZERO, DVec3::ZERO), limit, |index, corners| {
        if let Some(contact) = triangle(ray, corners, index) {
            limit = visit(contact);
        }
        limit
    });
}

fn cast_compound(compound: &Compound<'_>, ray: &Ray, limit: f64, mut visit: impl FnMut(Contact) -> f64) {
    let way = (ray.origin, ray.direction, ray.length);
    let bounds = children::grown(compound, (DVec3::ZERO, DVec3::ZERO));
    let Some(way) = Way::new(&compound.tree, way, bounds) else { return };
    let mut limit = limit;
    compound.tree.search(
        way.limit(limit),
        |bounds| way.bound(bounds),
        |index| {
            let (child, pose) = compound.child(index);
            let frame = Frame::of(&pose);
            let inner = Ray {
                origin: frame.untransform(ray.origin),
                direction: frame.unturn(ray.direction),
                length: ray.length,
            };
            if let Some(contact) = convex(&child, &inner, limit) {
                limit = visit(Contact { child: index, ..contact.outside(&frame) });
            }
            way.limit(limit)
        },
    );
}

/// A triangle, two-sided. Its edges belong to it, and neighbours agree on which side of their edge a ray passes, so
/// that no ray slips through between them.
pub(crate) fn triangle(ray: &Ray, corners: [DVec3; 3], child: u32) -> Option<Contact> {
    let [a, b, c] = corners.map(|corner| corner - ray.origin);
    // Volumes spanned by the ray and each edge: exchanging an edge's ends changes the sign and no other bit.
    let (u, v, w) =
        (ray.direction.dot(b.cross(c)), ray.direction.dot(c.cross(a)), ray.direction.dot(a.cross(b)));
    let is_crossed = (u >= 0.0 && v >= 0.0 && w >= 0.0) || (u <= 0.0 && v <= 0.0 && w <= 0.0);
    let n = (b - a).cross(c - a);
    let speed = n.dot(ray.direction);
    if !is_crossed || speed == 0.0 || u + v + w == 0.0 {
        return None;
    }
    let distance = n.dot(a) / speed;
    let normal = if speed > 0.0 { -n } else { n };
    if distance < 0.0 { None } else { ray.contact(distance, normal / length(normal), child) }
}
