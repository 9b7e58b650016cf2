//! Exact collision of two shapes: pure functions on values, which know no world.
//!
//! Everything is computed in the frame of shape A. A manifold's normal points from A to B; a point lies in
//! the middle between the two surfaces; its separation is negative when they overlap (SEED S3).

pub mod bounds;
pub(crate) mod cast;
pub mod clip;
pub mod compound;
pub mod convex;
pub mod distance;
pub mod half_space;
pub mod height_field;
pub mod hull;
pub mod mass;
pub mod mesh;
pub mod polytope;
pub mod support;
pub mod tree;
pub mod triangle;
pub(crate) mod vector64;

use crate::math::{Pose, Vec3};
use bytemuck::{Pod, Zeroable};
use mesh::Triangles;

/// Most points of a manifold.
pub const POINTS_MAX: usize = 4;
/// Most manifolds of one pair of shapes: more only for concave shapes with many directions of contact.
pub const MANIFOLDS_MAX: usize = 8;
/// Most vertices of a convex hull.
pub const HULL_VERTICES_MAX: usize = 64;
/// Most faces of a convex hull: 2 V - 4.
pub const HULL_FACES_MAX: usize = 124;
/// Most edges of a convex hull: 3 V - 6.
pub const HULL_EDGES_MAX: usize = 186;

/// Kinds of geometry in rows of shapes and children.
pub(crate) const GEOMETRY_SPHERE: u32 = 1;
pub(crate) const GEOMETRY_CAPSULE: u32 = 2;
pub(crate) const GEOMETRY_BOX: u32 = 3;
pub(crate) const GEOMETRY_HULL: u32 = 4;
pub(crate) const GEOMETRY_HALF_SPACE: u32 = 5;
pub(crate) const GEOMETRY_MESH: u32 = 6;
pub(crate) const GEOMETRY_CYLINDER: u32 = 7;
pub(crate) const GEOMETRY_CONE: u32 = 8;
pub(crate) const GEOMETRY_ROUNDED_HULL: u32 = 9;
pub(crate) const GEOMETRY_HEIGHT_FIELD: u32 = 10;
pub(crate) const GEOMETRY_COMPOUND: u32 = 11;

/// A plane: the points `x` with `normal . x = offset`. Outward for a face.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Plane {
    /// Unit normal.
    pub normal: Vec3,
    /// Distance of the plane from the origin along the normal, metres.
    pub offset: f32,
}

impl Plane {
    /// Signed distance of a point, positive on the side of the normal, metres.
    #[inline(always)]
    pub fn distance(&self, point: Vec3) -> f32 {
        self.normal.dot(point) - self.offset
    }
}

/// A face of a hull: a run of vertex indices in [`Hull::loops`], counter-clockwise seen from outside.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct Face {
    /// First entry in `loops`.
    pub first: u16,
    /// Number of vertices, at least 3.
    pub count: u16,
}

/// An edge of a hull between two of its faces.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct Edge {
    /// Vertex at which the edge starts, as the left face's loop runs.
    pub tail: u8,
    /// Vertex at which it ends.
    pub head: u8,
    /// Face whose loop runs from tail to head.
    pub left: u8,
    /// Face on the other side.
    pub right: u8,
}

/// A convex polytope as a view of tables: an asset, a box, or a triangle with two faces.
#[derive(Clone, Copy, Debug)]
pub struct Hull<'a> {
    /// Corners, metres, in the shape's frame.
    pub vertices: &'a [Vec3],
    /// One outward plane for each face.
    pub planes: &'a [Plane],
    /// Runs of `loops`.
    pub faces: &'a [Face],
    /// Vertex indices of all faces.
    pub loops: &'a [u8],
    /// Every edge once.
    pub edges: &'a [Edge],
    /// A point inside.
    pub center: Vec3,
}

impl Hull<'_> {
    /// How near the faces come to the center, metres.
    pub fn inner_radius(&self) -> f32 {
        let depth = |plane: &Plane| -plane.distance(self.center);
        let least =
            self.planes.iter().fold(f32::INFINITY, |least, plane| crate::math::min(depth(plane), least));
        if least.is_finite() { crate::math::max(least, 0.0) } else { 0.0 }
    }
}

/// Three vertices of a mesh and what lies across its edges.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct Triangle {
    /// Vertex indices, counter-clockwise seen from the front.
    pub vertices: [u32; 3],
    /// The vertex that faces edge `i` (from vertex `i` to `i + 1`) in the triangle across it; `u32::MAX` at a
    /// border, or where more than two triangles meet.
    pub across: [u32; 3],
}

/// A static triangle mesh as a view of tables. Two-sided.
#[derive(Clone, Copy, Debug)]
pub struct Mesh<'a> {
    /// Corners, metres, in the shape's frame.
    pub vertices: &'a [Vec3],
    /// Triangles.
    pub triangles: &'a [Triangle],
    /// Tree over the triangles' boxes: a leaf is the index of a triangle.
    pub tree: tree::Tree<'a>,
    /// For each triangle the index of its surface in the mesh's own table; empty when it has none.
    pub surfaces: &'a [u8],
}

/// The geometry of a shape with its tables at hand.
#[derive(Clone, Copy, Debug)]
pub enum Solid<'a> {
    /// Ball around the origin.
    Sphere {
        /// Metres.
        radius: f32,
    },
    /// All points within `radius` of the segment from `-half_height` to `half_height` on the z axis.
    Capsule {
        /// Half the length of the segment, metres.
        half_height: f32,
        /// Metres.
        radius: f32,
    },
    /// Box around the origin.
    Box {
        /// Half of each edge, metres.
        half_extents: Vec3,
    },
    /// Convex hull.
    Hull(Hull<'a>),
    /// All points with z <= 0.
    HalfSpace,
    /// Triangles.
    Mesh(Mesh<'a>),
    /// All points within `radius` of the z axis and `half_height` of the plane z = 0.
    Cylinder {
        /// Half the height, metres.
        half_height: f32,
        /// Metres.
        radius: f32,
    },
    /// Apex at `half_height` on the z axis, base of `radius` around `-half_height`.
    Cone {
        /// Half the height, metres.
        half_height: f32,
        /// Of the base, metres.
        radius: f32,
    },
    /// All points within `radius` of a convex hull.
    RoundedHull {
        /// The core.
        hull: Hull<'a>,
        /// Metres.
        radius: f32,
    },
    /// Heights over a grid.
    HeightField(height_field::HeightField<'a>),
    /// Convex children.
    Compound(compound::Compound<'a>),
}

/// One point of contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ManifoldPoint {
    /// Middle between the two surfaces, in A's frame, metres.
    pub position: Vec3,
    /// Distance of the surfaces along the normal, metres; negative when they overlap.
    pub separation: f32,
    /// Names the pair of features that touch: equal from step to step while the same features do.
    pub feature: u32,
}

/// Points of contact that share a normal.
#[derive(Clone, Debug)]
pub struct Manifold {
    /// Which part of a concave shape is meant, 24 bits: the least triangle index of the manifold; of a compound see
    /// [`compound::collide`]; 0 between convex shapes.
    pub child: u32,
    /// Unit normal from A to B, in A's frame.
    pub normal: Vec3,
    /// At least one point. Features are distinct.
    pub points: heapless::Vec<ManifoldPoint, POINTS_MAX>,
    /// Surface of the triangle that has the deepest point: 1 + its index in the table of the mesh or height field;
    /// 0 when the triangle has none.
    pub surface: u32,
}

/// What two shapes have in common. Children are distinct and ascending.
pub type Manifolds = heapless::Vec<Manifold, MANIFOLDS_MAX>;

/// Finds the contacts of two shapes.
///
/// `b_in_a` is the pose of B's frame in A's frame. Points farther apart than `distance` (metres, not negative)
/// are left out. Manifolds are pushed to `out`, which comes empty. At least one of the shapes has an inside, or
/// there are none. Finite poses and valid shapes give finite results; the result depends on the arguments alone.
pub fn collide(a: &Solid<'_>, b: &Solid<'_>, b_in_a: &Pose, distance: f32, out: &mut Manifolds) {
    match (a, b) {
        (
            Solid::HalfSpace | Solid::Mesh(_) | Solid::HeightField(_),
            Solid::HalfSpace | Solid::Mesh(_) | Solid::HeightField(_),
        ) => {}
        (Solid::Compound(compound), _) => compound::collide(compound, b, b_in_a, distance, out),
        (_, Solid::Compound(_)) => {
            collide(b, a, &b_in_a.inverse(), distance, out);
            for manifold in out {
                flip(manifold, b_in_a);
            }
        }
        (Solid::HalfSpace, _) => half_space::collide(b, b_in_a, distance, out),
        (Solid::Mesh(mesh), _) => mesh::collide(&Triangles::Mesh(mesh), b, b_in_a, distance, out),
        (Solid::HeightField(field), _) => {
            mesh::collide(&Triangles::HeightField(field), b, b_in_a, distance, out);
        }
        (_, Solid::HalfSpace | Solid::Mesh(_) | Solid::HeightField(_)) => {
            collide(b, a, &b_in_a.inverse(), distance, out);
            for manifold in out {
                flip(manifold, b_in_a);
            }
        }
        _ => convex::collide(a, b, b_in_a, distance, out),
    }
}

/// Turns a manifold of (B, A) in B's frame into one of (A, B) in A's frame.
fn flip(manifold: &mut Manifold, b_in_a: &Pose) {
    manifold.normal = -b_in_a.rotation.rotate(manifold.normal);
    for point in &mut manifold.points {
        point.position = b_in_a.transform(point.position);
    }
}
