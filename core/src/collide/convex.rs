//! Two convex shapes: which routine serves which pair.
//!
//! Every unordered pair is written once, the richer shape first; the other order is turned round.
//!
//! | A \ B | sphere | capsule | box | hull |
//! |---|---|---|---|---|
//! | sphere | centers | | | |
//! | capsule | point and segment | two segments | | |
//! | box | clamp | line by line | 15 axes | |
//! | hull | closest points | closest points, clip | clip | clip |
//!
//! Cylinders, cones and rounded hulls meet everything by their support functions (`support.rs`).

mod box_capsule;
mod boxes;
pub mod round;
#[cfg(test)]
mod tests;

use super::polytope::{self, BoxHull, Placed};
use super::{Hull, Manifold, Manifolds, Solid, support};
use crate::math::{Pose, Vec3};
use round::Segment;

/// Contacts of two convex shapes: at most one manifold of at most four points is pushed to `out`.
///
/// `b_in_a` is the pose of B's frame in A's; points farther apart than `distance` metres are left out.
/// Half-spaces and meshes have no contacts here.
pub fn collide(a: &Solid<'_>, b: &Solid<'_>, b_in_a: &Pose, distance: f32, out: &mut Manifolds) {
    let manifold = if rank(a) < rank(b) {
        let mut manifold = ordered(b, a, &b_in_a.inverse(), distance);
        if let Some(manifold) = &mut manifold {
            super::flip(manifold, b_in_a);
        }
        manifold
    } else {
        ordered(a, b, b_in_a, distance)
    };
    if let Some(manifold) = manifold {
        let _ = out.push(manifold);
    }
}

/// The richer shape is A.
fn rank(solid: &Solid<'_>) -> u32 {
    match solid {
        Solid::Sphere { .. } => 0,
        Solid::Capsule { .. } => 1,
        Solid::Box { .. } => 2,
        Solid::Hull(_) => 3,
        Solid::Cylinder { .. } => 4,
        Solid::Cone { .. } => 5,
        Solid::RoundedHull { .. } => 6,
        Solid::HalfSpace | Solid::Mesh(_) | Solid::HeightField(_) | Solid::Compound(_) => 7,
    }
}

fn ordered(a: &Solid<'_>, b: &Solid<'_>, b_in_a: &Pose, distance: f32) -> Option<Manifold> {
    match *a {
        Solid::Sphere { radius } => match *b {
            Solid::Sphere { radius: other } => {
                let between = round::Between { on_a: Vec3::ZERO, on_b: b_in_a.position, fallback: Vec3::Z };
                between.manifold((radius, other), distance)
            }
            _ => None,
        },
        Solid::Capsule { half_height, radius } => {
            let a = Segment::new(half_height, radius, &Pose::IDENTITY);
            match *b {
                Solid::Sphere { radius } => round::capsule_sphere(&a, b_in_a.position, radius, distance),
                Solid::Capsule { half_height, radius } => {
                    round::capsules(&a, &Segment::new(half_height, radius, b_in_a), distance)
                }
                _ => None,
            }
        }
        Solid::Box { half_extents } => match *b {
            Solid::Sphere { radius } => round::box_sphere(half_extents, b_in_a.position, radius, distance),
            Solid::Capsule { radius, half_height } => {
                box_capsule::collide(half_extents, &Segment::new(half_height, radius, b_in_a), distance)
            }
            Solid::Box { half_extents: other } => boxes::collide([half_extents, other], b_in_a, distance),
            _ => with_hull(&BoxHull::new(half_extents).hull(), b, b_in_a, distance),
        },
        Solid::Hull(hull) => with_hull(&hull, b, b_in_a, distance),
        _ => support::collide(a, b, b_in_a, distance),
    }
}

/// Contacts of a hull (A) with any convex shape.
fn with_hull(a: &Hull<'_>, b: &Solid<'_>, b_in_a: &Pose, distance: f32) -> Option<Manifold> {
    match *b {
        Solid::Sphere { radius } => round::hull_sphere(a, b_in_a.position, radius, distance),
        Solid::Capsule { half_height, radius } => {
            round::hull_capsule(a, &Segment::new(half_height, radius, b_in_a), distance)
        }
        Solid::Box { half_extents } => hulls(a, &BoxHull::new(half_extents).hull(), b_in_a, distance),
        Solid::Hull(hull) => hulls(a, &hull, b_in_a, distance),
        // Shapes of a higher rank come first, others have no contacts.
        _ => None,
    }
}

fn hulls(a: &Hull<'_>, b: &Hull<'_>, b_in_a: &Pose, distance: f32) -> Option<Manifold> {
    let placed = Placed::new(b, b_in_a);
    let b = placed.hull();
    polytope::manifold(a, &b, distance, polytope::tolerance(a, &b))
}
