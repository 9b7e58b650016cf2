//! A compound: many convex children in one shape, in a tree of their boxes.
//!
//! ```text
//! tree -> children near the other shape -> contacts of each -> clusters of one normal (mesh/cluster.rs)
//! ```
//! Children are convex shapes of their own: where two of them meet there is a seam, which what rolls over it can
//! feel, as between two shapes of one body. Children may overlap. Of the points that share a normal those farthest
//! out remain, so a table stands on its four legs by four points, whatever else touches. A child is named by its
//! index; see [`collide`].

use super::bounds::aabb;
use super::hull::HullRow;
use super::mesh::cluster::Clusters;
use super::tree::Tree;
use super::{
    GEOMETRY_BOX, GEOMETRY_CAPSULE, GEOMETRY_CONE, GEOMETRY_CYLINDER, GEOMETRY_HULL, GEOMETRY_ROUNDED_HULL,
    GEOMETRY_SPHERE, Manifolds, Solid,
};
use crate::math::{Aabb, Pose, Vec3, length, max, min};
use bytemuck::{Pod, Zeroable};
use core::fmt;

/// Most children: they are named with 12 bits.
pub const CHILDREN_MAX: usize = 1 << 12;
/// Bits of a child's index, and of what it touches, in a manifold's `child`.
const CHILD_BITS: u32 = 12;
/// Boxes that are turned to find the box of a compound.
const BOUNDS_MAX: usize = 32;

/// A child in the compound's frame: kind and sizes as in a shape's row.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Child {
    pub(crate) kind: u32,
    pub(crate) size: [f32; 3],
    pub(crate) pose: Pose,
}

/// A compound as a view of its tables.
#[derive(Clone, Copy, Debug)]
pub struct Compound<'a> {
    pub(crate) children: &'a [Child],
    /// All hulls of the world.
    pub(crate) hulls: &'a [HullRow],
    /// Over the boxes of the children: a leaf is a child's index.
    pub(crate) tree: Tree<'a>,
}

/// Why children make no compound.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum CompoundError {
    /// No children. Remedy: give at least one.
    Empty,
    /// More than [`CHILDREN_MAX`] children. Remedy: give the body several compounds.
    TooManyChildren,
    /// A child is a half-space, a mesh, a height field or a compound. Remedy: give convex children.
    NotConvex {
        /// The first such child.
        child: u32,
    },
    /// A child's size or pose is not finite or out of its range.
    OutOfRange {
        /// The first such child.
        child: u32,
    },
    /// A child names a hull that was not registered.
    NoSuchHull {
        /// The first such child.
        child: u32,
    },
}

impl fmt::Display for CompoundError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Empty => write!(f, "compound has no children"),
            Self::TooManyChildren => write!(f, "compound has more than {CHILDREN_MAX} children"),
            Self::NotConvex { child } => write!(f, "child {child} of the compound is not convex"),
            Self::OutOfRange { child } => {
                write!(f, "child {child} of the compound has a size or pose out of its range")
            }
            Self::NoSuchHull { child } => {
                write!(f, "child {child} of the compound names a hull that was not registered")
            }
        }
    }
}

impl core::error::Error for CompoundError {}

/// The convex solid of a kind and its sizes; a ball for kinds that are none.
pub(crate) fn convex_solid(kind: u32, size: [f32; 3], hulls: &[HullRow]) -> Solid<'_> {
    let hull = |bits: f32| hulls[bits.to_bits() as usize].view();
    match kind {
        GEOMETRY_CAPSULE => Solid::Capsule { radius: size[0], half_height: size[1] },
        GEOMETRY_BOX => Solid::Box { half_extents: Vec3::from_array(size) },
        GEOMETRY_HULL => Solid::Hull(hull(size[0])),
        GEOMETRY_CYLINDER => Solid::Cylinder { radius: size[0], half_height: size[1] },
        GEOMETRY_CONE => Solid::Cone { radius: size[0], half_height: size[1] },
        GEOMETRY_ROUNDED_HULL => Solid::RoundedHull { hull: hull(size[0]), radius: size[1] },
        _ => {
            debug_assert!(kind == GEOMETRY_SPHERE);
            Solid::Sphere { radius: size[0] }
        }
    }
}

impl<'a> Compound<'a> {
    /// Number of children.
    pub fn len(&self) -> usize {
        self.children.len()
    }

    /// True when there are no children, which no registered compound is.
    pub fn is_empty(&self) -> bool {
        self.children.is_empty()
    }

    /// A child and where it stands in the compound's frame.
    ///
    /// # Panics
    /// When there is no such child.
    pub fn child(&self, index: u32) -> (Solid<'a>, Pose) {
        let child = &self.children[index as usize];
        (convex_solid(child.kind, child.size, self.hulls), child.pose)
    }

    /// The box around the compound at a pose: that of its children, of many that of their groups in the tree.
    pub fn bounds(&self, pose: &Pose) -> Aabb {
        if self.children.len() <= BOUNDS_MAX {
            return (0..self.children.len() as u32).fold(Aabb::EMPTY, |sum, index| {
                let (solid, own) = self.child(index);
                sum.union(&aabb(&solid, &pose.after(&own)))
            });
        }
        let level = self.tree.level_within(BOUNDS_MAX);
        level.iter().fold(Aabb::EMPTY, |sum, group| sum.union(&group.transformed(pose)))
    }
}

/// Finds the contacts of a compound (A) with any shape `b` at `b_in_a`, within `distance` metres.
///
/// At most [`super::MANIFOLDS_MAX`] manifolds are pushed to `out`, the deepest when there are more, in ascending
/// order of `child`: the index of A's child in the upper 12 bits; in the lower 12 the index of B's child when that
/// is a compound, the low bits of the triangle when it is a mesh or height field, else 0. Where two manifolds would
/// have the same, the next number is taken.
pub fn collide(a: &Compound<'_>, b: &Solid<'_>, b_in_a: &Pose, distance: f32, out: &mut Manifolds) {
    let own = a.tree.bounds();
    let other = aabb(b, b_in_a);
    let smaller = if span(&other) < span(&own) { other } else { own };
    let mut clusters = Clusters::of_parts(smaller.center(), 0.5 * span(&smaller));
    let mut found = Manifolds::new();
    a.tree.query(&other.grown(distance), |index| {
        let (child, pose) = a.child(index);
        let relative = pose.inverse().after(b_in_a);
        let relative = Pose::new(relative.position, relative.rotation.normalized());
        found.clear();
        super::collide(&child, b, &relative, distance, &mut found);
        for manifold in &mut found {
            for point in &mut manifold.points {
                point.position = pose.transform(point.position);
            }
            let key = index << CHILD_BITS | part(b, manifold.child);
            let normal = pose.rotation.rotate(manifold.normal);
            clusters.add((key, manifold.surface), normal, &manifold.points);
        }
    });
    clusters.finish(Vec3::ZERO, out);
    make_distinct(out);
}

/// What names B's part of a contact of one child, 12 bits.
fn part(b: &Solid<'_>, child: u32) -> u32 {
    match b {
        Solid::Compound(_) => child >> CHILD_BITS,
        _ => child & ((1 << CHILD_BITS) - 1),
    }
}

/// The diagonal of a box, metres, as far as it has an end.
fn span(bounds: &Aabb) -> f32 {
    let side = bounds.max - bounds.min;
    max(min(length(side), 1.0e9), f32::MIN_POSITIVE)
}

/// Children ascend; equal ones take the next number. The last, which has none after it, would be left out.
fn make_distinct(out: &mut Manifolds) {
    let mut least = 0;
    out.retain_mut(|manifold| {
        manifold.child = manifold.child.max(least);
        least = manifold.child + 1;
        manifold.child < 1 << (2 * CHILD_BITS)
    });
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use crate::collide::tree::{self, node_count};
    use crate::math::Rotation;
    use std::vec;
    use std::vec::Vec;

    struct Owned {
        children: Vec<Child>,
        nodes: Vec<Aabb>,
        order: Vec<u32>,
    }

    impl Owned {
        /// Balls of radius 0.1 at random places within a metre.
        fn balls(count: usize) -> Self {
            let mut seed = 1_u32;
            let mut random = || {
                seed = seed.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
                (seed >> 8) as f32 / 8_388_608.0 - 1.0
            };
            let child = |_| {
                let pose = Pose::new(Vec3::new(random(), random(), random()), Rotation::IDENTITY);
                Child { kind: GEOMETRY_SPHERE, size: [0.1, 0.0, 0.0], pose }
            };
            let children: Vec<Child> = (0..count).map(child).collect();
            let boxes: Vec<Aabb> =
                children.iter().map(|c| Aabb::around(c.pose.position, Vec3::splat(c.size[0]))).collect();
            let (mut nodes, mut order) = (vec![Aabb::EMPTY; node_count(count)], vec![0; count]);
            tree::build(&boxes, 0..count as u32, &mut vec![0; count], &mut order, &mut nodes);
            Self { children, nodes, order }
        }

        fn view(&self) -> Compound<'_> {
            let tree = Tree { nodes: &self.nodes, order: &self.order };
            Compound { children: &self.children, hulls: &[], tree }
        }
    }

    #[test]
    fn boxes_hold_all_children_and_little_more() {
        for count in [1, 7, 32, 33, 500] {
            let owned = Owned::balls(count);
            let compound = owned.view();
            for i in 0..20 {
                let turn = Rotation::from_rotation_vector(Vec3::new(0.3 * i as f32, 1.0, -0.2 * i as f32));
                let pose = Pose::new(Vec3::new(5.0, -1.0, 2.0), turn);
                let tight = (0..count as u32).fold(Aabb::EMPTY, |sum, index| {
                    let (solid, own) = compound.child(index);
                    sum.union(&aabb(&solid, &pose.after(&own)))
                });
                let found = compound.bounds(&pose);
                assert!(found.grown(1.0e-5).contains(&tight), "{count} {i}: {found:?} {tight:?}");
                // Of many children by groups of them, whose boxes are turned.
                let slack = if count <= BOUNDS_MAX { 1.0e-5 } else { 0.6 };
                assert!(tight.grown(slack).contains(&found), "{count} {i}: {found:?} {tight:?}");
            }
        }
    }

    #[test]
    fn two_compounds_touch_as_their_children_do() {
        let (a, b) = (Owned::balls(40), Owned::balls(60));
        for i in 0..60 {
            let turn = Rotation::from_rotation_vector(Vec3::new(0.1 * i as f32, 0.7, -0.3 * i as f32));
            let pose = Pose::new(Vec3::new(1.9, 0.05 * i as f32 - 1.5, 0.3), turn);
            let mut found = Manifolds::new();
            collide(&a.view(), &Solid::Compound(b.view()), &pose, 0.05, &mut found);
            let mut deepest = (f32::INFINITY, 0);
            for (i, x) in a.children.iter().enumerate() {
                for (j, y) in b.children.iter().enumerate() {
                    let apart = length(pose.transform(y.pose.position) - x.pose.position) - 0.2;
                    if apart < deepest.0 {
                        deepest = (apart, (i as u32) << CHILD_BITS | j as u32);
                    }
                }
            }
            assert_eq!(found.is_empty(), deepest.0 > 0.05, "{i}");
            let points = found.iter().flat_map(|m| &m.points);
            let least = points.fold(f32::INFINITY, |least, p| min(p.separation, least));
            assert!(found.is_empty() || (least - deepest.0).abs() < 1.0e-5, "{i}: {found:?} {deepest:?}");
            assert!(found.windows(2).all(|pair| pair[0].child < pair[1].child), "{i}: {found:?}");
        }
    }
}
