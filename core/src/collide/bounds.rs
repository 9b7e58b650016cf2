//! Axis-aligned boxes around shapes.
//!
//! Tight for every bounded shape (to rounding; callers grow boxes by a margin anyway). A mesh or height field is
//! bounded by its own box, so its box is tight only when it is not turned; a compound of many children by some
//! boxes of its tree.

use super::Solid;
use crate::math::{Aabb, Pose, Vec3, max_each, min_each, sqrt};

/// Stands for "without end", metres: far beyond any pose, and its differences are finite.
pub const UNBOUNDED: f32 = 1.0e30;

/// The box around a shape at a pose, in the outer frame, metres. Always finite and not empty.
pub fn aabb(solid: &Solid<'_>, pose: &Pose) -> Aabb {
    match *solid {
        Solid::Sphere { radius } => Aabb::around(pose.position, Vec3::splat(radius)),
        Solid::Capsule { half_height, radius } => {
            let axis = pose.rotation.rotate(Vec3::Z).abs() * half_height;
            Aabb::around(pose.position, axis + Vec3::splat(radius))
        }
        Solid::Box { half_extents } => Aabb::around(pose.position, pose.rotation.extents(half_extents)),
        Solid::Hull(hull) => around_points(hull.vertices, pose),
        Solid::HalfSpace => half_space(pose),
        Solid::Cylinder { half_height, radius } => {
            let axis = pose.rotation.rotate(Vec3::Z);
            Aabb::around(pose.position, axis.abs() * half_height + disc(axis) * radius)
        }
        Solid::Cone { half_height, radius } => {
            let axis = pose.rotation.rotate(Vec3::Z);
            let apex = pose.position + axis * half_height;
            let base = Aabb::around(pose.position - axis * half_height, disc(axis) * radius);
            base.union(&Aabb { min: apex, max: apex })
        }
        Solid::RoundedHull { hull, radius } => around_points(hull.vertices, pose).grown(radius),
        Solid::HeightField(field) => field.bounds().transformed(pose),
        Solid::Compound(compound) => compound.bounds(pose),
        Solid::Mesh(mesh) => {
            let root = mesh.tree.bounds();
            // An empty tree's box is turned inside out, and infinite.
            let full = root.min.x <= root.max.x;
            if full { root.transformed(pose) } else { Aabb::around(pose.position, Vec3::ZERO) }
        }
    }
}

/// How far a disc of radius 1 across a unit axis reaches along each axis of the frame.
fn disc(axis: Vec3) -> Vec3 {
    // 1 - x^2 of a unit vector, as the sum of the other squares: exact near 0.
    let reach = |u: f32, v: f32| sqrt(u * u + v * v);
    Vec3::new(reach(axis.y, axis.z), reach(axis.z, axis.x), reach(axis.x, axis.y))
}

fn around_points(points: &[Vec3], pose: &Pose) -> Aabb {
    let m = pose.rotation.matrix();
    let Some((first, rest)) = points.split_first() else {
        return Aabb::around(pose.position, Vec3::ZERO);
    };
    let first = m * *first;
    let mut bounds = Aabb { min: first, max: first };
    for point in rest {
        let point = m * *point;
        bounds = Aabb { min: min_each(point, bounds.min), max: max_each(point, bounds.max) };
    }
    Aabb { min: bounds.min + pose.position, max: bounds.max + pose.position }
}

/// Bounded on one side when the surface lies along two axes exactly: the least tilt reaches everywhere.
fn half_space(pose: &Pose) -> Aabb {
    let up = pose.rotation.rotate(Vec3::Z).to_array();
    let position = pose.position.to_array();
    let (mut low, mut high) = ([-UNBOUNDED; 3], [UNBOUNDED; 3]);
    for i in 0..3 {
        if up[(i + 1) % 3] == 0.0 && up[(i + 2) % 3] == 0.0 {
            if up[i] > 0.0 {
                high[i] = position[i];
            } else {
                low[i] = position[i];
            }
        }
    }
    Aabb { min: Vec3::from_array(low), max: Vec3::from_array(high) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::collide::polytope::BoxHull;
    use crate::math::{Rotation, length};

    #[test]
    fn boxes_are_tight_around_turned_shapes() {
        let half = Vec3::new(0.5, 2.0, 0.01);
        let cube = BoxHull::new(half);
        for i in 0..50 {
            let f = i as f32;
            let turn = Rotation::from_rotation_vector(Vec3::new(f * 0.3, 1.0 - f * 0.2, f * 0.05));
            let pose = Pose::new(Vec3::new(f, -3.0, 0.1 * f), turn);
            let tight = around_points(cube.hull().vertices, &pose);
            for solid in [Solid::Box { half_extents: half }, Solid::Hull(cube.hull())] {
                let bounds = aabb(&solid, &pose);
                assert!(length(bounds.min - tight.min) < 1.0e-5 && length(bounds.max - tight.max) < 1.0e-5);
            }
            let capsule = aabb(&Solid::Capsule { half_height: 1.5, radius: 0.25 }, &pose);
            let ends = [pose.transform(Vec3::Z * 1.5), pose.transform(Vec3::Z * -1.5)];
            let rounded = around_points(&ends, &Pose::IDENTITY).grown(0.25);
            assert!(length(capsule.min - rounded.min) < 1.0e-5, "{capsule:?} {rounded:?}");
            assert!(length(capsule.max - rounded.max) < 1.0e-5, "{capsule:?} {rounded:?}");
        }
    }

    #[test]
    fn half_spaces_are_bounded_only_across_their_axis() {
        let at = Vec3::new(1.0, 2.0, 3.0);
        let level = aabb(&Solid::HalfSpace, &Pose::new(at, Rotation::IDENTITY));
        assert_eq!(level.max, Vec3::new(UNBOUNDED, UNBOUNDED, 3.0));
        assert_eq!(level.min, Vec3::splat(-UNBOUNDED));
        let over = aabb(&Solid::HalfSpace, &Pose::new(at, Rotation::new(1.0, 0.0, 0.0, 0.0)));
        assert_eq!((over.min.z, over.max.z), (3.0, UNBOUNDED));
        let tilted = Rotation::from_rotation_vector(Vec3::new(1.0e-6, 0.0, 0.0));
        let tilted = aabb(&Solid::HalfSpace, &Pose::new(at, tilted));
        assert_eq!((tilted.min, tilted.max), (Vec3::splat(-UNBOUNDED), Vec3::splat(UNBOUNDED)));
    }
}
