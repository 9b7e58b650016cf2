//! Rays at cylinders and cones: the part of the line within each bounding surface, and what these parts share.
//!
//! Both are a slab `|z| <= half_height` and a quadric cut by it. Line and quadric are told from the point of the
//! ray that is nearest to the shape's origin: there coordinates are of the shape's size, wherever the ray starts.

use super::Contact;
use super::ray::Ray;
use glam::DVec3;

/// Squares of sines below this count as zero: a ray of 1e7 m leaves its direction by 1e-8 m.
const PARALLEL: f64 = 1.0e-30;

/// The part of a line within a convex set, with the normal where it enters.
#[derive(Clone, Copy, Debug)]
struct Part {
    enter: f64,
    exit: f64,
    /// Of any length; zero where the line has no beginning.
    normal: DVec3,
}

impl Part {
    const ALL: Self = Self { enter: f64::NEG_INFINITY, exit: f64::INFINITY, normal: DVec3::ZERO };

    /// What both share.
    fn and(self, other: Self) -> Self {
        let (enter, normal) =
            if other.enter > self.enter { (other.enter, other.normal) } else { (self.enter, self.normal) };
        Self { enter, normal, exit: if other.exit < self.exit { other.exit } else { self.exit } }
    }
}

/// The ray with its origin as near to the shape's as it comes, and how far that is along it.
fn rebased(ray: &Ray) -> (Ray, f64) {
    let along = -ray.origin.dot(ray.direction);
    let along = if along > 0.0 { along } else { 0.0 };
    (Ray { origin: ray.origin + ray.direction * along, ..*ray }, along)
}

/// The contact of a ray with a set in which its line has a part, from the place `along`.
fn contact(ray: &Ray, along: f64, part: &Part) -> Option<Contact> {
    // A part that is no number is none.
    let is_ahead = part.enter <= part.exit && along + part.exit >= 0.0;
    if !is_ahead {
        return None;
    }
    let distance = along + part.enter;
    if distance <= 0.0 { Some(ray.inside(0)) } else { ray.contact(distance, part.normal, 0) }
}

/// `None` when the line stays outside.
fn slab(ray: &Ray, half_height: f64) -> Option<Part> {
    let (from, speed) = (ray.origin.z, ray.direction.z);
    if speed * speed <= PARALLEL {
        let is_within = from >= -half_height && from <= half_height;
        return is_within.then_some(Part::ALL);
    }
    let side = if speed > 0.0 { half_height } else { -half_height };
    let normal = DVec3::new(0.0, 0.0, if speed > 0.0 { -1.0 } else { 1.0 });
    Some(Part { enter: (-side - from) / speed, exit: (side - from) / speed, normal })
}

fn flat(v: DVec3) -> DVec3 {
    DVec3::new(v.x, v.y, 0.0)
}

/// All points within `radius` of the z axis and `half_height` of the plane z = 0.
pub(super) fn cylinder(ray: &Ray, half_height: f64, radius: f64) -> Option<Contact> {
    let across = flat(ray.origin);
    let is_level = ray.origin.z >= -half_height && ray.origin.z <= half_height;
    if is_level && across.dot(across) <= radius * radius {
        return Some(ray.inside(0));
    }
    let (near, along) = rebased(ray);
    let slab = slab(&near, half_height)?;
    let (from, direction) = (flat(near.origin), flat(near.direction));
    let speed = direction.dot(direction);
    if speed <= PARALLEL {
        let is_within = from.dot(from) <= radius * radius;
        return is_within.then_some(slab).and_then(|part| contact(ray, along, &part));
    }
    let middle = -from.dot(direction) / speed;
    let beside = from + direction * middle;
    let half_chord = (radius * radius - beside.dot(beside)) / speed;
    if half_chord < 0.0 {
        return None;
    }
    let half_chord = libm::sqrt(half_chord);
    let enter = middle - half_chord;
    let side = Part { enter, exit: middle + half_chord, normal: (from + direction * enter) / radius };
    contact(ray, along, &slab.and(side))
}

/// Apex at `half_height` on the z axis, base of `radius` around `-half_height`.
///
/// With `w` the depth below the apex, `r` the distance from the axis and `s`, `c` the sine and cosine of the angle
/// between axis and side, the side is `c r = s w`; its square also has the cone that stands on its head above the
/// apex, which the slab leaves out.
pub(super) fn cone(ray: &Ray, half_height: f64, radius: f64) -> Option<Contact> {
    let slant = libm::sqrt(radius * radius + 4.0 * half_height * half_height);
    let (sine, cosine) = (radius / slant, 2.0 * half_height / slant);
    let outside = |p: DVec3| {
        let across = flat(p);
        cosine * libm::sqrt(across.dot(across)) - sine * (half_height - p.z)
    };
    if ray.origin.z >= -half_height && outside(ray.origin) <= 0.0 {
        return Some(ray.inside(0));
    }
    let (near, along) = rebased(ray);
    let slab = slab(&near, half_height)?;
    let side = cone_side(&near, half_height, (sine, cosine))?;
    let mut part = slab.and(side);
    if part.enter == side.enter {
        let foot = near.origin + near.direction * side.enter;
        let across = flat(foot);
        let reach = libm::sqrt(across.dot(across));
        let outward = if reach > 0.0 { across * (cosine / reach) } else { DVec3::ZERO };
        let normal = outward + DVec3::Z * sine;
        // At the apex any direction outward will do: straight up.
        part.normal = if reach > 0.0 { normal } else { DVec3::Z };
    }
    contact(ray, along, &part)
}

/// The part of a line within the double cone that goes on within the lower one; normals are left out.
fn cone_side(ray: &Ray, half_height: f64, (sine, cosine): (f64, f64)) -> Option<Part> {
    // f(t) = c^2 r^2 - s^2 w^2 = a t^2 + 2 b t + outside
    let (from, direction) = (ray.origin - DVec3::Z * half_height, ray.direction);
    let (cc, ss) = (cosine * cosine, sine * sine);
    let product = |p: DVec3, q: DVec3| cc * (p.x * q.x + p.y * q.y) - ss * (p.z * q.z);
    let (a, b, outside) = (product(direction, direction), product(from, direction), product(from, from));
    let discriminant = b * b - a * outside;
    if a > 0.0 && discriminant < 0.0 {
        return None;
    }
    // Both roots without cancellation.
    let root = libm::sqrt(if discriminant > 0.0 { discriminant } else { 0.0 });
    let sum = if b > 0.0 { -(b + root) } else { root - b };
    if sum == 0.0 {
        // Along the side, or through the apex.
        let apex = Part { enter: 0.0, exit: 0.0, normal: DVec3::ZERO };
        return if a > 0.0 { Some(apex) } else { (outside <= 0.0).then_some(Part::ALL) };
    }
    if a == 0.0 && b * direction.z <= 0.0 {
        // Parallel to the side, and within the upper cone.
        return None;
    }
    let (first, second) = (sum / a, outside / sum);
    let (low, high) = if first < second { (first, second) } else { (second, first) };
    if a > 0.0 {
        return Some(Part { enter: low, exit: high, normal: DVec3::ZERO });
    }
    // Steeper than the side, or as steep: one end of the line is in the lower cone.
    let end = if a == 0.0 {
        second
    } else if direction.z < 0.0 {
        high
    } else {
        low
    };
    Some(if direction.z < 0.0 { Part { enter: end, ..Part::ALL } } else { Part { exit: end, ..Part::ALL } })
}
