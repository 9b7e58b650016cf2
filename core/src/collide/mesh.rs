//! A triangle mesh against a convex shape.
//!
//! ```text
//! tree -> triangles near the shape -> a manifold each (../triangle.rs) -> clusters of one normal (cluster.rs)
//! ```
//!
//! Meshes are two-sided: a triangle pushes to the side of the shape's center, and no winding matters. Any number of
//! triangles may touch; they are taken one by one, in the order of the tree, and nothing is stored for each.
//!
//! A mesh is prepared once, as an asset: [`validate`], [`connect`], then the tree over [`triangle_box`].

mod cluster;
#[cfg(test)]
mod tests;
mod topology;

pub use topology::{COORDINATE_MAX, MeshError, connect, scratch_len, validate};

use super::bounds::aabb;
use super::clip::Candidates;
use super::convex::round::Segment;
use super::polytope::{self, BoxHull, Placed};
use super::triangle::{Convex, Facet};
use super::{Manifolds, Mesh, Solid, Triangle};
use crate::math::{Aabb, Pose, Vec3, max_each, min_each};
use cluster::Clusters;

/// The box around a triangle: a leaf of the mesh's tree.
pub fn triangle_box(vertices: &[Vec3], triangle: &Triangle) -> Aabb {
    let [a, b, c] = triangle.vertices.map(|vertex| vertices[vertex as usize]);
    Aabb { min: min_each(a, min_each(b, c)), max: max_each(a, max_each(b, c)) }
}

/// Finds the contacts of a mesh (A) with a convex shape `b` at `b_in_a`, within `distance` metres.
///
/// Pushes at most [`super::MANIFOLDS_MAX`] manifolds to `out`, the deepest when there are more, in ascending order
/// of `child`, the least triangle of the manifold. Half-spaces and meshes have no contacts here.
pub fn collide(mesh: &Mesh<'_>, b: &Solid<'_>, b_in_a: &Pose, distance: f32, out: &mut Manifolds) {
    let region = aabb(b, b_in_a).grown(distance);
    let search = Search { mesh, region, origin: b_in_a.position, distance };
    // The shape stays in its origin; the mesh comes to it.
    let turned = Pose::new(Vec3::ZERO, b_in_a.rotation);
    match *b {
        Solid::Sphere { radius } => search.run(&Convex::Sphere { radius }, out),
        Solid::Capsule { half_height, radius } => {
            search.run(&Convex::Capsule(Segment::new(half_height, radius, &turned)), out);
        }
        Solid::Box { half_extents } => {
            let cuboid = BoxHull::new(half_extents);
            search.run_hull(&Placed::new(&cuboid.hull(), &turned), out);
        }
        Solid::Hull(hull) => search.run_hull(&Placed::new(&hull, &turned), out),
        Solid::HalfSpace | Solid::Mesh(_) => {}
    }
}

/// Where in the mesh contacts are searched.
struct Search<'a> {
    mesh: &'a Mesh<'a>,
    region: Aabb,
    /// Origin of the shape's frame in the mesh's.
    origin: Vec3,
    distance: f32,
}

impl Search<'_> {
    fn run_hull(&self, placed: &Placed<'_>, out: &mut Manifolds) {
        let hull = placed.hull();
        let tolerance = polytope::tolerance(&hull, &hull);
        self.run(&Convex::Hull { hull, tolerance }, out);
    }

    fn run(&self, b: &Convex<'_>, out: &mut Manifolds) {
        let center = b.center();
        let mut clusters = Clusters::new(b);
        let mut points = Candidates::new();
        self.mesh.tree.query(&self.region, |triangle| {
            let facet = Facet::new(self.mesh, triangle, self.origin, center);
            if let Some(normal) = facet.contact(b, self.distance, &mut points) {
                clusters.add(triangle, normal, &points);
            }
        });
        clusters.finish(self.origin, out);
    }
}
