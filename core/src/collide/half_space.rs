//! A half-space against a convex shape.
//!
//! The normal is always the surface's, and the contacts are the shape's lowest points: a point of B at height
//! `z` over the surface has separation `z`, and lies in the middle at half that height.

use super::clip::{CORNERS_MAX, Candidates, reduce_face, single};
use super::polytope::BoxHull;
use super::support::{self, SupportShape};
use super::{Manifold, ManifoldPoint, Manifolds, Solid};
use crate::math::{Pose, Vec3};

/// Ends of a capsule nearer than this fraction of its radius are one.
const ONE_END: f32 = 1.0e-6;

/// Contacts of the half-space `z <= 0` (shape A, whose normal is +z) with the convex shape `b` at the pose
/// `b_in_a`. Points higher than `distance` (metres) are left out. Half-spaces and meshes have no contacts here.
pub fn collide(b: &Solid<'_>, b_in_a: &Pose, distance: f32, out: &mut Manifolds) {
    let manifold = match b {
        Solid::Sphere { radius } => sphere(b_in_a.position, *radius, distance),
        Solid::Capsule { half_height, radius } => {
            let axis = b_in_a.rotation.rotate(Vec3::Z) * *half_height;
            capsule([b_in_a.position - axis, b_in_a.position + axis], *radius, distance)
        }
        Solid::Box { half_extents } => {
            vertices(BoxHull::new(*half_extents).hull().vertices, b_in_a, distance)
        }
        Solid::Hull(hull) => vertices(hull.vertices, b_in_a, distance),
        Solid::Cylinder { .. } | Solid::Cone { .. } => curved(b, b_in_a, distance),
        Solid::RoundedHull { hull, radius } => {
            // The core's lowest vertices, over a surface that is higher by the radius.
            let up = Vec3::Z * *radius;
            let lowered = Pose::new(b_in_a.position - up, b_in_a.rotation);
            vertices(hull.vertices, &lowered, distance)
        }
        Solid::HalfSpace | Solid::Mesh(_) | Solid::HeightField(_) | Solid::Compound(_) => None,
    };
    if let Some(manifold) = manifold {
        let _ = out.push(manifold);
    }
}

/// The contact of a point of B.
fn contact(point: Vec3, feature: u32) -> ManifoldPoint {
    let position = Vec3::new(point.x, point.y, 0.5 * point.z);
    ManifoldPoint { position, separation: point.z, feature }
}

fn sphere(center: Vec3, radius: f32, distance: f32) -> Option<Manifold> {
    let lowest = contact(center - Vec3::Z * radius, 0);
    if lowest.separation <= distance { Some(single(Vec3::Z, lowest)) } else { None }
}

fn capsule(ends: [Vec3; 2], radius: f32, distance: f32) -> Option<Manifold> {
    let one = (ends[1] - ends[0]).length_squared() <= ONE_END * ONE_END * radius * radius;
    let mut points = heapless::Vec::new();
    for (end, feature) in ends[..if one { 1 } else { 2 }].iter().zip(0..) {
        let lowest = contact(*end - Vec3::Z * radius, feature);
        if lowest.separation <= distance {
            let _ = points.push(lowest);
        }
    }
    if points.is_empty() { None } else { Some(Manifold { child: 0, normal: Vec3::Z, points, surface: 0 }) }
}

/// The disc, line or point of a curved shape that looks down.
fn curved(b: &Solid<'_>, pose: &Pose, distance: f32) -> Option<Manifold> {
    let cuboid = support::box_of(b);
    let mut low = Candidates::new();
    support::lowest(&SupportShape::new(b, pose, &cuboid)?, distance, &mut low);
    let points = reduce_face(&low, Vec3::Z);
    if points.is_empty() { None } else { Some(Manifold { child: 0, normal: Vec3::Z, points, surface: 0 }) }
}

fn vertices(vertices: &[Vec3], pose: &Pose, distance: f32) -> Option<Manifold> {
    let m = pose.rotation.matrix();
    let mut low: heapless::Vec<ManifoldPoint, CORNERS_MAX> = heapless::Vec::new();
    for (vertex, feature) in vertices.iter().zip(0..) {
        let point = m * *vertex + pose.position;
        if point.z <= distance {
            let _ = low.push(contact(point, feature));
        }
    }
    let points = reduce_face(&low, Vec3::Z);
    if points.is_empty() { None } else { Some(Manifold { child: 0, normal: Vec3::Z, points, surface: 0 }) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{PI, Rotation};

    fn one(b: &Solid<'_>, pose: &Pose, distance: f32) -> Manifold {
        let mut out = Manifolds::new();
        collide(b, pose, distance, &mut out);
        assert_eq!(out.len(), 1);
        assert_eq!(out[0].normal, Vec3::Z);
        out[0].clone()
    }

    #[test]
    fn round_shapes_touch_with_their_ends() {
        let turn = Rotation::from_axis_angle(Vec3::X, PI * 0.5);
        let pose = Pose::new(Vec3::new(1.0, 2.0, 0.4), turn);
        let ball = one(&Solid::Sphere { radius: 0.5 }, &pose, 0.0);
        assert!((ball.points[0].separation + 0.1).abs() < 1.0e-6);
        assert!((ball.points[0].position - Vec3::new(1.0, 2.0, -0.05)).length_squared() < 1.0e-12);
        let lying = one(&Solid::Capsule { half_height: 1.0, radius: 0.5 }, &pose, 0.0);
        assert_eq!((lying.points.len(), lying.points[0].feature, lying.points[1].feature), (2, 0, 1));
        let standing = Pose::new(Vec3::Z * 1.45, Rotation::IDENTITY);
        let standing = one(&Solid::Capsule { half_height: 1.0, radius: 0.5 }, &standing, 0.02);
        assert_eq!(standing.points.len(), 1);
        let mut none = Manifolds::new();
        collide(&Solid::Sphere { radius: 0.5 }, &Pose::new(Vec3::Z, turn), 0.4, &mut none);
        assert!(none.is_empty());
    }

    #[test]
    fn boxes_touch_with_their_lowest_well_spread_corners() {
        let flat = Solid::Box { half_extents: Vec3::new(1.0, 1.0, 0.004) };
        let m = one(&flat, &Pose::new(Vec3::Z * 0.003, Rotation::IDENTITY), 0.02);
        // The upper corners are within reach as well; the lower ones carry the box.
        assert_eq!(m.points.len(), 4);
        for p in &m.points {
            assert!((p.separation + 0.001).abs() < 1.0e-6, "{m:?}");
        }
        let tilted = Rotation::from_rotation_vector(Vec3::new(0.3, 0.2, 0.0));
        let cube = Solid::Box { half_extents: Vec3::ONE };
        let m = one(&cube, &Pose::new(Vec3::ZERO, tilted), 10.0);
        let lowest = m.points.iter().fold(0.0, |z, p| crate::math::min(p.separation, z));
        let expected = tilted.matrix().transpose().z_axis.abs();
        assert!((lowest + expected.x + expected.y + expected.z).abs() < 1.0e-6);
    }
}
