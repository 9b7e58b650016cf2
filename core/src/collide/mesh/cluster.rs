//! Joins the contacts of many triangles into few manifolds.
//!
//! Triangles whose normals agree share a cluster. Its points are reduced as they come: for each of eight directions
//! across the normal the cluster remembers the point farthest that way (deeper points count as farther), and the
//! deepest point. Eight directions find every corner of a rectangle, however it is turned; four points of those
//! nine remain at the end. So the order in which triangles come matters only among points that are equally far.

use crate::collide::clip::reduce;
use crate::collide::triangle::{Convex, deepest};
use crate::collide::{MANIFOLDS_MAX, Manifold, ManifoldPoint, Manifolds, POINTS_MAX};
use crate::math::{Vec3, any_perpendicular, min};
use core::cmp::Ordering;

/// Clusters at work: more than come out, so that one that turns out deep is seldom lost.
const CLUSTERS: usize = 2 * MANIFOLDS_MAX;
/// Directions in which a cluster remembers its farthest point.
const DIRECTIONS: usize = 8;
/// Cosine from which two normals agree: 8 degrees.
const AGREE: f32 = 0.99;
/// Cosine up to which two clusters are so different that one can hide the other: 45 degrees.
const APART: f32 = 0.7;
/// Points count as farther by this fraction of the square of their distance from the center, in units of the
/// shape's size: of the points on a straight side it is then an end that is farthest.
const BULGE: f32 = 0.05;
const HALF_SQRT_2: f32 = core::f32::consts::FRAC_1_SQRT_2;

/// The same for the parts of a compound: 2.6 degrees. Triangles share normals, round parts have their own.
const AGREE_PARTS: f32 = 0.999;
/// Points of parts nearer than this are one, as a fraction of the size.
const ONE_POINT_OF_PARTS: f32 = 1.0e-3;

/// Manifolds in the making, in the frame of the convex shape's origin.
pub(in crate::collide) struct Clusters {
    clusters: heapless::Vec<Cluster, CLUSTERS>,
    measure: Measure,
}

/// How points of a shape are compared.
#[derive(Clone, Copy)]
struct Measure {
    center: Vec3,
    /// See [`BULGE`]; per metre.
    bulge: f32,
    /// Points nearer than this are one, metres.
    one_point: f32,
    /// Heights that count as equal, metres.
    tolerance: f32,
    /// Cosine from which two normals agree.
    agree: f32,
    /// True when one surface can lie behind another.
    hides: bool,
}

/// Contacts of triangles whose normals agree.
struct Cluster {
    /// Least triangle.
    child: u32,
    /// Surface of the triangle that has the deepest point.
    surface: u32,
    /// Normal of the deepest point.
    normal: Vec3,
    deepest: ManifoldPoint,
    /// Two unit vectors across the first normal.
    across: [Vec3; 2],
    /// Farthest point in each direction.
    farthest: [ManifoldPoint; DIRECTIONS],
}

impl Clusters {
    pub fn new(b: &Convex<'_>) -> Self {
        let measure = Measure {
            center: b.center(),
            bulge: BULGE / b.size(),
            one_point: b.one_point(),
            tolerance: b.tolerance(),
            agree: AGREE,
            hides: true,
        };
        Self { clusters: heapless::Vec::new(), measure }
    }

    /// For the parts of a compound that touch something of this middle and size (metres).
    pub fn of_parts(center: Vec3, size: f32) -> Self {
        let one_point = ONE_POINT_OF_PARTS * size;
        let measure = Measure {
            center,
            bulge: BULGE / size,
            one_point,
            tolerance: one_point,
            agree: AGREE_PARTS,
            hides: false,
        };
        Self { clusters: heapless::Vec::new(), measure }
    }

    /// Takes in the contacts of a triangle of some surface; see [`Manifold::surface`].
    pub fn add(&mut self, (triangle, surface): (u32, u32), normal: Vec3, points: &[ManifoldPoint]) {
        let Some(&first) = points.first() else { return };
        let agree = self.measure.agree;
        let agrees = |cluster: &Cluster| cluster.normal.dot(normal) > agree;
        let index = match self.clusters.iter().position(agrees) {
            Some(index) => index,
            None => {
                let Some(index) = self.room_for(deepest(points)) else { return };
                let cluster = Cluster::new((triangle, surface), normal, named(triangle, first));
                if index < self.clusters.len() {
                    self.clusters[index] = cluster;
                } else {
                    let _ = self.clusters.push(cluster);
                }
                index
            }
        };
        let cluster = &mut self.clusters[index];
        cluster.child = cluster.child.min(triangle);
        for &point in points {
            cluster.add((surface, normal), named(triangle, point), &self.measure);
        }
    }

    /// Where a new cluster goes: behind the others, or in the place of the shallowest if it is deeper.
    fn room_for(&self, separation: f32) -> Option<usize> {
        if !self.clusters.is_full() {
            return Some(self.clusters.len());
        }
        let (mut shallowest, mut greatest) = (None, separation);
        for (i, cluster) in self.clusters.iter().enumerate() {
            if cluster.deepest.separation > greatest {
                (shallowest, greatest) = (Some(i), cluster.deepest.separation);
            }
        }
        shallowest
    }

    /// Pushes the deepest clusters to `out`, ascending by child. `origin` is that of the clusters' frame.
    pub fn finish(mut self, origin: Vec3, out: &mut Manifolds) {
        let mut kept = [true; CLUSTERS];
        for (i, cluster) in self.clusters.iter().enumerate() {
            let hides = |other: &Cluster| {
                other.hides(cluster, self.measure.tolerance) && !cluster.hides(other, self.measure.tolerance)
            };
            kept[i] = !(self.measure.hides && self.clusters.iter().any(hides));
        }
        let mut index = 0;
        self.clusters.retain(|_| {
            index += 1;
            kept[index - 1]
        });
        // A triangle is in one cluster at most, so that children are distinct; two triangles that have one name in
        // a compound's contacts differ in normal. So both orders are total.
        self.clusters.sort_unstable_by(|a, b| {
            a.deepest.separation.total_cmp(&b.deepest.separation).then_with(|| a.by_child(b))
        });
        self.clusters.truncate(MANIFOLDS_MAX);
        self.clusters.sort_unstable_by(Cluster::by_child);
        for cluster in &self.clusters {
            let mut points = cluster.points(self.measure.one_point);
            for point in &mut points {
                point.position += origin;
            }
            let Cluster { child, normal, surface, .. } = *cluster;
            let _ = out.push(Manifold { child, normal, points, surface });
        }
    }
}

impl Cluster {
    fn new((child, surface): (u32, u32), normal: Vec3, point: ManifoldPoint) -> Self {
        let side = any_perpendicular(normal);
        let across = [side, normal.cross(side)];
        Self { child, surface, normal, deepest: point, across, farthest: [point; DIRECTIONS] }
    }

    fn add(&mut self, (surface, normal): (u32, Vec3), point: ManifoldPoint, measure: &Measure) {
        if point.separation < self.deepest.separation {
            (self.deepest, self.normal, self.surface) = (point, normal, surface);
        }
        let reach = measure.reach(self.across, &point);
        for (i, farthest) in self.farthest.iter_mut().enumerate() {
            if reach[i] > measure.reach(self.across, farthest)[i] {
                *farthest = point;
            }
        }
    }

    fn by_child(&self, other: &Self) -> Ordering {
        let normal = |i: usize| self.normal[i].total_cmp(&other.normal[i]);
        self.child.cmp(&other.child).then_with(|| normal(0).then(normal(1)).then(normal(2)))
    }

    /// True when another cluster's contacts lie beneath this one's surface, no deeper than the shape has sunk into
    /// it. The shape's center is above, so nothing beneath can be met but through this surface: as by a box that
    /// has sunk a little into the top of a ledge, the ledge's wall from within.
    fn hides(&self, other: &Self, tolerance: f32) -> bool {
        if self.normal.dot(other.normal) > APART {
            return false;
        }
        // The mesh's surface is half a separation beneath the contact, which is above it while they overlap.
        let separation = self.deepest.separation;
        let surface = self.normal.dot(self.deepest.position) - 0.5 * separation;
        let lowest = min(separation, 0.0) - tolerance;
        other.farthest.iter().chain([&other.deepest]).all(|point| {
            let height = self.normal.dot(point.position) - surface;
            height <= tolerance && height >= lowest
        })
    }

    /// What remains. The deepest comes last: of equally deep points `reduce` starts with the first, and that
    /// should be a far one.
    fn points(&self, one_point: f32) -> heapless::Vec<ManifoldPoint, POINTS_MAX> {
        let mut distinct = heapless::Vec::<ManifoldPoint, { DIRECTIONS + 1 }>::new();
        for &point in self.farthest.iter().chain([&self.deepest]) {
            let same = |other: &&mut ManifoldPoint| {
                (other.position - point.position).length_squared() <= one_point * one_point
            };
            match distinct.iter_mut().find(same) {
                Some(other) if point.separation < other.separation => *other = point,
                Some(_) => {}
                None => {
                    let _ = distinct.push(point);
                }
            }
        }
        if distinct.len() > 2 {
            // `reduce` leaves up to four points as they are, even one that lies on the line between two others.
            // Copies, which it never chooses twice, make it choose.
            let copy = distinct[0];
            while distinct.push(copy).is_ok() {}
        }
        reduce(&distinct, self.normal)
    }
}

impl Measure {
    /// How far a point lies in each direction; depth counts like distance.
    fn reach(&self, across: [Vec3; 2], point: &ManifoldPoint) -> [f32; DIRECTIONS] {
        let [x, y] = across.map(|side| side.dot(point.position - self.center));
        let (p, q) = ((x + y) * HALF_SQRT_2, (y - x) * HALF_SQRT_2);
        let more = self.bulge * (x * x + y * y) - point.separation;
        [x, -x, y, -y, p, -p, q, -q].map(|far| far + more)
    }
}

/// The point with a feature that names the triangle, too: one to one for the features of a triangle.
fn named(triangle: u32, point: ManifoldPoint) -> ManifoldPoint {
    let mixed = (triangle.wrapping_mul(0x9e37_79b1) ^ point.feature).wrapping_mul(0x85eb_ca6b);
    ManifoldPoint { feature: mixed ^ mixed >> 15, ..point }
}
