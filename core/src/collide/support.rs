//! Convex shapes by their support function: cylinders, cones and rounded hulls against every convex shape.
//!
//! ```text
//! closest points of the cores (closest.rs), or the direction of least depth (depth.rs) -> a normal
//! normal -> the feature of each shape that looks that way: face, disc, line, point (here)
//!        -> their common part seen along the normal (patch.rs) -> contacts
//! ```
//! A shape is a *core* and a radius around it. A curved side is a curve throughout, never a polygon: what touches
//! is the disc, the line on the side that looks along the normal, or the point of the rim that does, so nothing
//! bumps when it rolls.
//!
//! In f64, so that a normal is good to 3e-5 rad also where curved sides nearly touch. Legend: `n` the unit normal
//! from A to B, `q` a point seen along it, `h` a height along it.

mod closest;
mod depth;
mod patch;
#[cfg(test)]
mod tests;

use super::clip::{Candidates, face_loop, reduce_face};
use super::polytope::BoxHull;
use super::{HULL_VERTICES_MAX, Hull, Manifold, ManifoldPoint, Solid};
use crate::math::{Pose, Rotation, Vec3, max, sqrt};
use closest::{Aim, Pair};
use glam::DVec3;
use patch::View;

/// Sine of the angle to the normal up to which a line or a face counts as across it: 3 degrees.
const LEVEL: f64 = 0.05;
/// Cosine that belongs to [`LEVEL`].
const LEVEL_COSINE: f64 = 0.998_75;
/// How much the points of the common part may miss of the depth of the closest points, as a fraction of the lesser
/// size; a part that misses more is not where the shapes touch.
const SLACK: f64 = 2.0e-4;
/// Square of the angle by which a normal may be off.
const EXACT: f64 = 1.0e-9;
/// A direction counts as along an axis when the part across it is a smaller fraction.
const ON_AXIS: f64 = 1.0e-12;
/// Feature of the one closest point.
const CLOSEST_FEATURE: u32 = 0;

/// What a radius is around.
#[derive(Clone, Copy, Debug)]
pub(super) enum Core<'a> {
    Point,
    /// From `-half_height` to `half_height` on the z axis.
    Segment {
        half_height: f64,
    },
    Hull(Hull<'a>),
    Cylinder {
        half_height: f64,
        radius: f64,
    },
    /// Apex at `half_height` on the z axis, base at `-half_height`.
    Cone {
        half_height: f64,
        radius: f64,
    },
}

/// A convex shape somewhere.
#[derive(Clone, Copy, Debug)]
pub struct SupportShape<'a> {
    core: Core<'a>,
    /// Metres around the core.
    radius: f64,
    /// Axes of the shape's frame.
    axes: [DVec3; 3],
    position: DVec3,
}

/// A point of a feature, with the name that it has on its shape (8 bits).
#[derive(Clone, Copy, Debug)]
struct Spot {
    at: DVec3,
    name: u32,
}

/// What a core has farthest along a direction.
#[expect(clippy::large_enum_variant, reason = "a local: there is no heap to put it on")]
#[derive(Clone, Debug)]
enum Feature {
    Point,
    Segment([Spot; 2]),
    /// Corners counter-clockwise seen from outside, and the outward normal.
    Face(heapless::Vec<Spot, HULL_VERTICES_MAX>, DVec3),
    Disc {
        center: DVec3,
        /// Two axes across the disc, and the outward normal.
        axes: [DVec3; 3],
        radius: f64,
    },
}

/// Names of the rim and of the apex on the side of a cylinder (base and top) or cone.
const BASE_NAME: u32 = 1;
const TOP_NAME: u32 = 2;

/// Contacts of two convex shapes: `None` when they are farther apart than `distance` metres.
///
/// `b_in_a` is the pose of B's frame in A's. Half-spaces and concave shapes have no contacts here.
pub fn collide(a: &Solid<'_>, b: &Solid<'_>, b_in_a: &Pose, distance: f32) -> Option<Manifold> {
    let (box_a, box_b) = (box_of(a), box_of(b));
    let a = SupportShape::new(a, &Pose::IDENTITY, &box_a)?;
    let b = SupportShape::new(b, b_in_a, &box_b)?;
    let mut points = Candidates::new();
    let normal = contacts(&a, &b, distance, &mut points)?;
    Some(Manifold { child: 0, normal, points: reduce_face(&points, normal), surface: 0 })
}

/// The corners of a box, for [`SupportShape::new`]; of any other shape some box that is not looked at.
pub fn box_of(solid: &Solid<'_>) -> BoxHull {
    match solid {
        Solid::Box { half_extents } => BoxHull::new(*half_extents),
        _ => BoxHull::new(Vec3::ONE),
    }
}

/// Replaces `points` by all contacts of two shapes in one frame, and returns the normal from A to B. None when
/// they are farther apart than `distance` metres.
pub fn contacts(
    a: &SupportShape<'_>,
    b: &SupportShape<'_>,
    distance: f32,
    points: &mut Candidates,
) -> Option<Vec3> {
    points.clear();
    let radii = a.radius + b.radius;
    let limit = f64::from(distance) + radii;
    let pair = Pair::new(a, b);
    let touching = depth::TOUCHING * pair.lesser_size();
    let aim = Aim { limit, touching, angle_squared: EXACT };
    let near = match pair.closest(b.center() - a.center(), &aim)? {
        near if near.is_apart => near,
        _ => depth::least(&pair),
    };
    if near.apart > limit {
        return None;
    }
    let view = View::new(near.normal, (near.on_a + near.on_b) * 0.5, (a, b));
    patch::push(&view, f64::from(distance), points);
    let slack = SLACK * pair.lesser_size();
    let least = points.iter().fold(f64::INFINITY, |least, point| {
        let separation = f64::from(point.separation);
        if separation < least { separation } else { least }
    });
    if least > near.apart - radii + slack {
        points.clear();
        let on_a = near.on_a + near.normal * a.radius;
        let on_b = near.on_b - near.normal * b.radius;
        let position = ((on_a + on_b) * 0.5).as_vec3();
        let separation = (near.apart - radii) as f32;
        let _ = points.push(ManifoldPoint { position, separation, feature: CLOSEST_FEATURE });
    }
    Some(near.normal.as_vec3())
}

/// Replaces `points` by the contacts within `distance` metres of B with a face of A, whose unit normal is given,
/// along that normal. Those of the part of B that lies over the face.
pub fn contacts_over(
    a: &SupportShape<'_>,
    b: &SupportShape<'_>,
    (normal, distance): (Vec3, f32),
    points: &mut Candidates,
) {
    points.clear();
    let n = DVec3::from(normal);
    let lowest = b.support(-n);
    let view = View::new(n, lowest, (a, b));
    patch::push(&view, f64::from(distance), points);
    if points.is_empty() && view.is_over_a(lowest) {
        let separation = (lowest - a.support(n)).dot(n) - a.radius - b.radius;
        if separation <= f64::from(distance) {
            let position = lowest - n * (b.radius + 0.5 * separation);
            let separation = separation as f32;
            let _ = points.push(ManifoldPoint {
                position: position.as_vec3(),
                separation,
                feature: CLOSEST_FEATURE,
            });
        }
    }
}

/// Adds the points of `b` that are farthest along `-z`, where a half-space ends, and at most `distance` metres
/// high.
pub fn lowest(b: &SupportShape<'_>, distance: f32, points: &mut Candidates) {
    let mut add = |at: DVec3, feature: u32| {
        let height = (at.z - b.radius) as f32;
        if height <= distance {
            let position = Vec3::new(at.x as f32, at.y as f32, 0.5 * height);
            let _ = points.push(ManifoldPoint { position, separation: height, feature });
        }
    };
    match b.feature(DVec3::NEG_Z) {
        Feature::Point => add(b.support(DVec3::NEG_Z), CLOSEST_FEATURE),
        Feature::Segment(ends) => ends.iter().for_each(|end| add(end.at, end.name)),
        Feature::Face(corners, _) => corners.iter().for_each(|corner| add(corner.at, corner.name)),
        Feature::Disc { center, axes, radius } => {
            // Its normal looks down: the disc falls against the part of it that lies in the plane.
            let fall = DVec3::new(axes[2].x, axes[2].y, 0.0) / axes[2].z;
            for rim in patch::rim_points(center, &axes, radius, fall) {
                add(rim.at, rim.name);
            }
        }
    }
}

impl<'a> Core<'a> {
    /// The core of a shape and the radius around it, metres; `None` for half-spaces and concave shapes, and for
    /// boxes, whose corners are in no table.
    pub fn new(solid: &Solid<'a>) -> Option<(Self, f64)> {
        Some(match *solid {
            Solid::Sphere { radius } => (Core::Point, f64::from(radius)),
            Solid::Capsule { half_height, radius } => {
                (Core::Segment { half_height: f64::from(half_height) }, f64::from(radius))
            }
            Solid::Hull(hull) => (Core::Hull(hull), 0.0),
            Solid::RoundedHull { hull, radius } => (Core::Hull(hull), f64::from(radius)),
            Solid::Cylinder { half_height, radius } => {
                (Core::Cylinder { half_height: f64::from(half_height), radius: f64::from(radius) }, 0.0)
            }
            Solid::Cone { half_height, radius } => {
                (Core::Cone { half_height: f64::from(half_height), radius: f64::from(radius) }, 0.0)
            }
            Solid::Box { .. }
            | Solid::HalfSpace
            | Solid::Mesh(_)
            | Solid::HeightField(_)
            | Solid::Compound(_) => return None,
        })
    }

    /// A ball inside: its middle and its radius, metres. The greatest one, but of a hull that around its center.
    pub fn inner_ball(&self) -> (DVec3, f64) {
        match *self {
            Core::Point | Core::Segment { .. } => (DVec3::ZERO, 0.0),
            Core::Hull(hull) => (DVec3::from(hull.center), f64::from(hull.inner_radius())),
            Core::Cylinder { half_height, radius } => {
                (DVec3::ZERO, if half_height < radius { half_height } else { radius })
            }
            Core::Cone { half_height, radius } => {
                // Of the triangle through the axis: area over half of the way around.
                let side = libm::sqrt(radius * radius + 4.0 * half_height * half_height);
                let inner = 2.0 * half_height * radius / (radius + side);
                (DVec3::Z * (inner - half_height), inner)
            }
        }
    }

    /// The radius of the smallest ball about the middle of the inner one that has the core in it, metres.
    pub fn outer_radius(&self) -> f64 {
        let middle = self.inner_ball().0;
        let from_middle = |point: DVec3| (point - middle).dot(point - middle);
        let most = |a: f64, b: f64| if a > b { a } else { b };
        libm::sqrt(match *self {
            Core::Point => 0.0,
            Core::Segment { half_height } => half_height * half_height,
            Core::Hull(hull) => hull.vertices.iter().map(|&v| from_middle(DVec3::from(v))).fold(0.0, most),
            Core::Cylinder { half_height, radius } => from_middle(DVec3::new(radius, 0.0, half_height)),
            Core::Cone { half_height, radius } => {
                most(from_middle(DVec3::Z * half_height), from_middle(DVec3::new(radius, 0.0, -half_height)))
            }
        })
    }

    /// A cylinder that is thinner by a skin all over, metres; `None` for all others.
    pub fn thinned(&self, skin: f64) -> Option<Self> {
        match *self {
            Core::Cylinder { half_height, radius } => {
                Some(Core::Cylinder { half_height: half_height - skin, radius: radius - skin })
            }
            _ => None,
        }
    }

    /// The point farthest along a direction of any length, the first one where there are several.
    pub fn support(&self, d: DVec3) -> DVec3 {
        match self {
            Core::Point => DVec3::ZERO,
            Core::Segment { half_height } => DVec3::Z * if d.z < 0.0 { -half_height } else { *half_height },
            Core::Hull(hull) => DVec3::from(hull.vertices[support_vertex(hull, d)]),
            Core::Cylinder { half_height, radius } => {
                rim(d, *radius, if d.z < 0.0 { -half_height } else { *half_height })
            }
            Core::Cone { half_height, radius } => {
                let across = libm::sqrt(d.x * d.x + d.y * d.y);
                if 2.0 * half_height * d.z >= radius * across {
                    DVec3::Z * *half_height
                } else {
                    rim(d, *radius, -half_height)
                }
            }
        }
    }
}

impl<'a> SupportShape<'a> {
    /// A shape at a pose; `None` for half-spaces and concave shapes. `cuboid` is [`box_of`] the shape.
    pub fn new(solid: &Solid<'a>, pose: &Pose, cuboid: &'a BoxHull) -> Option<Self> {
        let (core, radius) = match *solid {
            Solid::Box { .. } => (Core::Hull(cuboid.hull()), 0.0),
            _ => Core::new(solid)?,
        };
        let position = DVec3::from(pose.position);
        Some(Self { core, radius, axes: axes_of(pose.rotation), position })
    }

    /// A hull in the common frame; it may be flat.
    pub fn of_hull(hull: Hull<'a>) -> Self {
        let axes = [DVec3::X, DVec3::Y, DVec3::Z];
        Self { core: Core::Hull(hull), radius: 0.0, axes, position: DVec3::ZERO }
    }

    fn local(&self, v: DVec3) -> DVec3 {
        DVec3::new(self.axes[0].dot(v), self.axes[1].dot(v), self.axes[2].dot(v))
    }

    fn turned(&self, v: DVec3) -> DVec3 {
        self.axes[0] * v.x + self.axes[1] * v.y + self.axes[2] * v.z
    }

    fn placed(&self, v: DVec3) -> DVec3 {
        self.turned(v) + self.position
    }

    /// A point in the middle of the core.
    pub fn center(&self) -> DVec3 {
        match &self.core {
            Core::Hull(hull) => self.placed(DVec3::from(hull.center)),
            _ => self.position,
        }
    }

    /// About half of the core's extent, with the radius, metres.
    pub fn size(&self) -> f64 {
        let core = match &self.core {
            Core::Point => 0.0,
            Core::Segment { half_height } => *half_height,
            Core::Hull(hull) => {
                let square = |vertex: Vec3| (vertex - hull.center).length_squared();
                f64::from(sqrt(hull.vertices.iter().fold(0.0, |most, &vertex| max(square(vertex), most))))
            }
            Core::Cylinder { half_height, radius } | Core::Cone { half_height, radius } => {
                libm::sqrt(half_height * half_height + radius * radius)
            }
        };
        core + self.radius
    }

    /// The core's point farthest along a direction of any length.
    pub fn support(&self, direction: DVec3) -> DVec3 {
        self.placed(self.core.support(self.local(direction)))
    }

    /// What the core has farthest along the unit vector `n`.
    fn feature(&self, n: DVec3) -> Feature {
        let d = self.local(n);
        let spot = |at: DVec3, name: u32| Spot { at: self.placed(at), name };
        let disc = |z: f64, up: f64, radius: f64| Feature::Disc {
            center: self.placed(DVec3::Z * z),
            axes: [self.axes[0], self.axes[1], self.axes[2] * up],
            radius,
        };
        match &self.core {
            Core::Point => Feature::Point,
            Core::Segment { half_height } if d.z.abs() <= LEVEL && *half_height > 0.0 => Feature::Segment([
                spot(DVec3::Z * -half_height, BASE_NAME),
                spot(DVec3::Z * *half_height, TOP_NAME),
            ]),
            Core::Segment { .. } => Feature::Point,
            Core::Hull(hull) => self.hull_feature(hull, d),
            Core::Cylinder { half_height, radius } => {
                if d.z.abs() >= LEVEL_COSINE {
                    let up = if d.z < 0.0 { -1.0 } else { 1.0 };
                    disc(up * half_height, up, *radius)
                } else if d.z.abs() <= LEVEL {
                    let ends = [rim(d, *radius, -half_height), rim(d, *radius, *half_height)];
                    Feature::Segment([spot(ends[0], BASE_NAME), spot(ends[1], TOP_NAME)])
                } else {
                    Feature::Point
                }
            }
            Core::Cone { half_height, radius } => {
                let (foot, apex) = (rim(d, *radius, -half_height), DVec3::Z * *half_height);
                let side = apex - foot;
                if d.z <= -LEVEL_COSINE {
                    disc(-half_height, -1.0, *radius)
                } else if side.dot(d).abs() <= LEVEL * length(side) {
                    Feature::Segment([spot(foot, BASE_NAME), spot(apex, TOP_NAME)])
                } else {
                    Feature::Point
                }
            }
        }
    }

    /// The face, edge or corner of a hull that looks along the unit vector `d` in its frame.
    fn hull_feature(&self, hull: &Hull<'_>, d: DVec3) -> Feature {
        let top = support_vertex(hull, d) as u8;
        let mut best = (LEVEL_COSINE, None);
        for (face, plane) in hull.planes.iter().enumerate() {
            let cosine = DVec3::from(plane.normal).dot(d);
            if cosine > best.0 && face_loop(hull, face).contains(&top) {
                best = (cosine, Some(face));
            }
        }
        let spot = |vertex: u8| Spot {
            at: self.placed(DVec3::from(hull.vertices[usize::from(vertex)])),
            name: u32::from(vertex),
        };
        if let Some(face) = best.1 {
            let corners = face_loop(hull, face).iter().map(|&vertex| spot(vertex)).collect();
            return Feature::Face(corners, self.turned(DVec3::from(hull.planes[face].normal)));
        }
        let mut best = (LEVEL, None);
        for edge in hull.edges.iter().filter(|edge| edge.tail == top || edge.head == top) {
            let along =
                DVec3::from(hull.vertices[usize::from(edge.head)] - hull.vertices[usize::from(edge.tail)]);
            let sine = along.dot(d).abs() / length(along);
            if sine < best.0 {
                best = (sine, Some(edge));
            }
        }
        best.1.map_or(Feature::Point, |edge| Feature::Segment([spot(edge.tail), spot(edge.head)]))
    }
}

/// The point of a circle around the z axis at height `z` that is farthest along `d`; its center along the axis.
fn rim(d: DVec3, radius: f64, z: f64) -> DVec3 {
    let across = libm::sqrt(d.x * d.x + d.y * d.y);
    if across <= ON_AXIS * d.z.abs() {
        return DVec3::new(0.0, 0.0, z);
    }
    DVec3::new(radius * (d.x / across), radius * (d.y / across), z)
}

fn support_vertex(hull: &Hull<'_>, d: DVec3) -> usize {
    let mut best = (0, f64::NEG_INFINITY);
    for (i, vertex) in hull.vertices.iter().enumerate() {
        let height = DVec3::from(*vertex).dot(d);
        if height > best.1 {
            best = (i, height);
        }
    }
    best.0
}

fn length(v: DVec3) -> f64 {
    libm::sqrt(v.dot(v))
}

/// Columns of the rotation's matrix. Parts in f32 have norm 1 only to 1e-7: divided by it here, axes are unit.
fn axes_of(rotation: Rotation) -> [DVec3; 3] {
    let [x, y, z, w] = [rotation.x, rotation.y, rotation.z, rotation.w].map(f64::from);
    let norm = x * x + y * y + z * z + w * w;
    let k = if norm > 0.0 { 2.0 / norm } else { 0.0 };
    [
        DVec3::new(1.0 - k * (y * y + z * z), k * (x * y + w * z), k * (x * z - w * y)),
        DVec3::new(k * (x * y - w * z), 1.0 - k * (x * x + z * z), k * (y * z + w * x)),
        DVec3::new(k * (x * z + w * y), k * (y * z - w * x), 1.0 - k * (x * x + y * y)),
    ]
}
