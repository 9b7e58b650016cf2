//! The lines of each geometry.

use super::{Color, DebugDraw};
use crate::collide::height_field::HeightField;
use crate::collide::polytope::{BOX_EDGES, BoxHull};
use crate::collide::{Edge, Hull, Mesh, Solid};
use crate::math::{Aabb, PI, Pose, Vec3, cos, sin};

/// Lines of a full circle: a multiple of four.
pub(crate) const CIRCLE: usize = 24;
/// Lines of a half-space's grid, each way.
pub(crate) const GRID: i32 = 11;
/// Distance between the grid's lines, metres.
const GRID_STEP: f32 = 1.0;

/// Draws in one color.
pub(crate) struct Pen<'a, D> {
    pub draw: &'a mut D,
    pub color: Color,
    /// How far from the origin, metres.
    pub reach: f32,
}

impl<D: DebugDraw> Pen<'_, D> {
    /// Draws a shape at a pose in the drawing's frame.
    pub fn solid(&mut self, solid: &Solid<'_>, pose: &Pose) {
        match solid {
            Solid::Sphere { radius } => self.ball(pose, *radius),
            Solid::Capsule { half_height, radius } => self.capsule(pose, *half_height, *radius),
            Solid::Box { half_extents } => {
                let cuboid = BoxHull::new(*half_extents);
                self.edges(cuboid.hull().vertices, &BOX_EDGES, pose);
            }
            Solid::Hull(hull) => self.edges(hull.vertices, hull.edges, pose),
            Solid::HalfSpace => self.half_space(pose),
            Solid::Mesh(mesh) => self.mesh(mesh, pose),
            Solid::Cylinder { half_height, radius } => self.cylinder(pose, *half_height, *radius),
            Solid::Cone { half_height, radius } => self.cone(pose, *half_height, *radius),
            Solid::RoundedHull { hull, radius } => self.rounded(hull, *radius, pose),
            Solid::HeightField(field) => self.height_field(field, pose),
            Solid::Compound(compound) => {
                for index in 0..compound.len() as u32 {
                    let (child, own) = compound.child(index);
                    self.solid(&child, &pose.after(&own));
                }
            }
        }
    }

    /// Draws the twelve edges of a box in the drawing's frame.
    pub fn cuboid(&mut self, bounds: &Aabb) {
        let cuboid = BoxHull::new(bounds.half_extents());
        let pose = Pose::new(bounds.center(), crate::math::Rotation::IDENTITY);
        self.edges(cuboid.hull().vertices, &BOX_EDGES, &pose);
    }

    pub fn line(&mut self, pose: &Pose, from: Vec3, to: Vec3) {
        self.draw.line(pose.transform(from), pose.transform(to), self.color);
    }

    fn edges(&mut self, corners: &[Vec3], edges: &[Edge], pose: &Pose) {
        for edge in edges {
            self.line(pose, corners[edge.tail as usize], corners[edge.head as usize]);
        }
    }

    /// An arc about the origin of a pose from an angle to another, radians from the direction `x` over `y`, in lines
    /// that are not longer than those of a full circle.
    pub fn sector(&mut self, pose: &Pose, (x, y): (Vec3, Vec3), [from, to]: [f32; 2]) {
        let step = 2.0 * PI / CIRCLE as f32;
        let lines = libm::ceilf((to - from) / step - 1.0e-3);
        let lines = crate::math::clamp(lines, 1.0, CIRCLE as f32) as usize;
        let at = |i: usize| {
            let turn = from + (to - from) * (i as f32 / lines as f32);
            x * cos(turn) + y * sin(turn)
        };
        for i in 0..lines {
            self.line(pose, at(i), at(i + 1));
        }
    }

    /// An arc about `center` from the direction `x` over `y`; `lines` of a full circle's.
    fn arc(&mut self, pose: &Pose, center: Vec3, (x, y): (Vec3, Vec3), lines: usize) {
        let at = |i: usize| {
            let turn = 2.0 * PI * i as f32 / CIRCLE as f32;
            center + x * cos(turn) + y * sin(turn)
        };
        for i in 0..lines {
            self.line(pose, at(i), at(i + 1));
        }
    }

    /// Three great circles.
    fn ball(&mut self, pose: &Pose, radius: f32) {
        let [x, y, z] = [Vec3::X, Vec3::Y, Vec3::Z].map(|axis| axis * radius);
        for plane in [(x, y), (y, z), (z, x)] {
            self.arc(pose, Vec3::ZERO, plane, CIRCLE);
        }
    }

    /// A circle and two arches at each end, and four lines between.
    fn capsule(&mut self, pose: &Pose, half_height: f32, radius: f32) {
        let [x, y, z] = [Vec3::X, Vec3::Y, Vec3::Z].map(|axis| axis * radius);
        for side in [-1.0, 1.0] {
            let end = Vec3::Z * (side * half_height);
            self.arc(pose, end, (x, y), CIRCLE);
            self.arc(pose, end, (x, z * side), CIRCLE / 2);
            self.arc(pose, end, (y, z * side), CIRCLE / 2);
        }
        let up = Vec3::Z * half_height;
        for side in [x, -x, y, -y] {
            self.line(pose, side - up, side + up);
        }
    }

    /// A circle at each end, and four lines between.
    fn cylinder(&mut self, pose: &Pose, half_height: f32, radius: f32) {
        let [x, y] = [Vec3::X, Vec3::Y].map(|axis| axis * radius);
        let up = Vec3::Z * half_height;
        self.arc(pose, up, (x, y), CIRCLE);
        self.arc(pose, -up, (x, y), CIRCLE);
        for side in [x, -x, y, -y] {
            self.line(pose, side - up, side + up);
        }
    }

    /// The circle of the base, and four lines to the apex.
    fn cone(&mut self, pose: &Pose, half_height: f32, radius: f32) {
        let [x, y] = [Vec3::X, Vec3::Y].map(|axis| axis * radius);
        let up = Vec3::Z * half_height;
        self.arc(pose, -up, (x, y), CIRCLE);
        for side in [x, -x, y, -y] {
            self.line(pose, side - up, up);
        }
    }

    /// The edges of the faces, each face moved out by the radius.
    fn rounded(&mut self, hull: &Hull<'_>, radius: f32, pose: &Pose) {
        for edge in hull.edges {
            let [tail, head] = [edge.tail, edge.head].map(|corner| hull.vertices[usize::from(corner)]);
            for face in [edge.left, edge.right] {
                let out = hull.planes[usize::from(face)].normal * radius;
                self.line(pose, tail + out, head + out);
            }
        }
    }

    /// The edges of the triangles within reach.
    fn height_field(&mut self, field: &HeightField<'_>, pose: &Pose) {
        let region = Aabb::around(pose.untransform(Vec3::ZERO), Vec3::splat(self.reach));
        field.query(&region, |index| {
            let ([a, b, c], _) = field.triangle(index);
            self.line(pose, a, b);
            self.line(pose, b, c);
            self.line(pose, c, a);
        });
    }

    /// A grid on the surface under the drawing's origin, at whole steps of the shape's own coordinates, and a line
    /// along the normal.
    fn half_space(&mut self, pose: &Pose) {
        let under = pose.untransform(Vec3::ZERO);
        let snap = |x: f32| libm::rintf(x / GRID_STEP) * GRID_STEP;
        let middle = Vec3::new(snap(under.x), snap(under.y), 0.0);
        let half = (GRID / 2) as f32 * GRID_STEP;
        for i in -GRID / 2..=GRID / 2 {
            let aside = i as f32 * GRID_STEP;
            for (along, across) in [(Vec3::X, Vec3::Y), (Vec3::Y, Vec3::X)] {
                let at = middle + across * aside;
                self.line(pose, at - along * half, at + along * half);
            }
        }
        self.line(pose, middle, middle + Vec3::Z * GRID_STEP);
    }

    /// The edges of the triangles within reach.
    fn mesh(&mut self, mesh: &Mesh<'_>, pose: &Pose) {
        let region = Aabb::around(pose.untransform(Vec3::ZERO), Vec3::splat(self.reach));
        mesh.tree.query(&region, |index| {
            let [a, b, c] = mesh.triangles[index as usize].vertices.map(|v| mesh.vertices[v as usize]);
            self.line(pose, a, b);
            self.line(pose, b, c);
            self.line(pose, c, a);
        });
    }
}
