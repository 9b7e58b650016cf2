//! A triangle mesh or a height field against a convex shape.
//!
//! ```text
//! tree -> triangles near the shape -> a manifold each (../triangle.rs) -> clusters of one normal (cluster.rs)
//! ```
//!
//! Meshes are two-sided: a triangle pushes to the side of the shape's center, and no winding matters. Any number of
//! triangles may touch; they are taken one by one, in the order of the tree, and nothing is stored for each.
//!
//! A mesh is prepared once, as an asset: [`validate`], [`connect`], then the tree over [`triangle_box`].

pub(super) mod cluster;
#[cfg(test)]
mod tests;
mod topology;

pub(super) use topology::has_area;
pub use topology::{COORDINATE_MAX, MeshError, connect, scratch_len, validate};

use super::bounds::aabb;
use super::clip::Candidates;
use super::convex::round::Segment;
use super::height_field::HeightField;
use super::polytope::{self, BoxHull, Placed};
use super::support::{self, SupportShape};
use super::triangle::{Convex, Facet};
use super::{Manifolds, Mesh, Solid, Triangle};
use crate::math::{Aabb, Pose, Vec3, max_each, min_each};
use cluster::Clusters;

/// The box around a triangle: a leaf of the mesh's tree.
pub fn triangle_box(vertices: &[Vec3], triangle: &Triangle) -> Aabb {
    let [a, b, c] = triangle.vertices.map(|vertex| vertices[vertex as usize]);
    Aabb { min: min_each(a, min_each(b, c)), max: max_each(a, max_each(b, c)) }
}

/// A surface of triangles.
#[derive(Clone, Copy, Debug)]
pub enum Triangles<'a> {
    /// Triangles in a tree.
    Mesh(&'a Mesh<'a>),
    /// Triangles over a grid.
    HeightField(&'a HeightField<'a>),
}

impl Triangles<'_> {
    /// Visits the triangles near a region: their index, and they themselves with the origin at `origin`, turned to
    /// `center` from there.
    #[inline]
    fn visit(&self, region: &Aabb, (origin, center): (Vec3, Vec3), mut visit: impl FnMut(u32, Facet)) {
        match self {
            Self::Mesh(mesh) => mesh
                .tree
                .query(region, |triangle| visit(triangle, Facet::new(mesh, triangle, origin, center))),
            Self::HeightField(field) => field.query(region, |triangle| {
                let (corners, across) = field.triangle(triangle);
                let from_origin = |corner: Vec3| corner - origin;
                let across = across.map(|corner| corner.map(from_origin));
                visit(triangle, Facet::of(corners.map(from_origin), across, center));
            }),
        }
    }

    /// 1 + the index of a triangle's surface; 0 when it has none.
    fn surface_of(&self, triangle: u32) -> u32 {
        match self {
            Self::Mesh(mesh) => mesh.surfaces.get(triangle as usize).map_or(0, |&index| u32::from(index) + 1),
            Self::HeightField(field) => field.surface_of(triangle),
        }
    }
}

/// Finds the contacts of a surface (A) with a convex shape `b` at `b_in_a`, within `distance` metres.
///
/// Pushes at most [`super::MANIFOLDS_MAX`] manifolds to `out`, the deepest when there are more, in ascending order
/// of `child`, the least triangle of the manifold. Half-spaces and concave shapes have no contacts here.
pub fn collide(surface: &Triangles<'_>, b: &Solid<'_>, b_in_a: &Pose, distance: f32, out: &mut Manifolds) {
    let region = aabb(b, b_in_a).grown(distance);
    let search = Search { surface, region, origin: b_in_a.position, distance };
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
        Solid::Cylinder { .. } | Solid::Cone { .. } | Solid::RoundedHull { .. } => {
            let cuboid = support::box_of(b);
            if let Some(shape) = SupportShape::new(b, &turned, &cuboid) {
                search.run(&Convex::Support { size: shape.size() as f32, shape: &shape }, out);
            }
        }
        Solid::HalfSpace | Solid::Mesh(_) | Solid::HeightField(_) | Solid::Compound(_) => {}
    }
}

/// Where on the surface contacts are searched.
struct Search<'a> {
    surface: &'a Triangles<'a>,
    region: Aabb,
    /// Origin of the shape's frame in the surface's.
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
        self.surface.visit(&self.region, (self.origin, center), |triangle, facet| {
            if let Some(normal) = facet.contact(b, self.distance, &mut points) {
                clusters.add((triangle, self.surface.surface_of(triangle)), normal, &points);
            }
        });
        clusters.finish(self.origin, out);
    }
}
