//! Two boxes: the pair that piles are made of.
//!
//! All 15 axes are written out in A's frame, where the axes of A are the unit vectors and `r[i][j]` is the
//! cosine between axis i of A and axis j of B (Gottschalk, Lin, Manocha 1996). An edge axis must beat the better
//! face axis by a margin, so its square root is taken only when it does: resting boxes never take one. The
//! incident face is cut in the frame of the reference box, where a side plane is one coordinate.
//!
//! Vertices, faces and edges have the indices of [`BoxHull`].

use crate::collide::clip::{self, Candidates, Naming, Polygon, Reference, SIDE};
use crate::collide::polytope::{
    self, BOX_LOOPS, BoxHull, PARALLEL, Placed, SLACK_OF_TOLERANCE, closest_contact, edge_position,
    preference_bound, preferred,
};
use crate::collide::{Manifold, ManifoldPoint, Plane};
use crate::math::{Mat3, Pose, Vec3, min, sqrt};

const NEXT: [usize; 3] = [1, 2, 0];
const AFTER: [usize; 3] = [2, 0, 1];
/// An incident face must look more against the reference by this than one before it.
const INCIDENT_TIE: f32 = 1.0e-4;

/// One box as the other sees it.
struct View {
    /// Half extents of the box whose frame this is.
    half: [f32; 3],
    /// Half extents of the other box.
    other_half: [f32; 3],
    /// Axes of the other box in this frame.
    axes: [Vec3; 3],
    /// Center of the other box in this frame.
    center: [f32; 3],
}

/// A face axis of a box: the faces across `axis`.
#[derive(Clone, Copy)]
struct FaceAxis {
    axis: usize,
    separation: f32,
}

/// An edge axis: axis `i` of A and axis `j` of B.
#[derive(Clone, Copy)]
struct EdgeAxis {
    i: usize,
    j: usize,
    normal: Vec3,
    separation: f32,
}

/// What the edge axes tell.
enum Edges {
    /// One of them separates by more than the distance.
    Separated,
    /// None is better than the faces.
    Worse,
    Better(EdgeAxis),
}

/// Contacts of two boxes of the given half extents (A's, B's): see `convex::collide`.
pub fn collide(half: [Vec3; 2], b_in_a: &Pose, distance: f32) -> Option<Manifold> {
    let m = b_in_a.rotation.matrix();
    let (x, y, z) = (m.x_axis, m.y_axis, m.z_axis);
    let t = b_in_a.position;
    let (half_a, half_b) = (half[0].to_array(), half[1].to_array());
    let a = View { half: half_a, other_half: half_b, axes: [x, y, z], center: t.to_array() };
    let face_a = face_axis(&a, distance)?;
    let back = m.transpose();
    let center = [-t.dot(x), -t.dot(y), -t.dot(z)];
    let axes = [back.x_axis, back.y_axis, back.z_axis];
    let b = View { half: half_b, other_half: half_a, axes, center };
    let face_b = face_axis(&b, distance)?;
    let tolerance = polytope::tolerance_of_radius(min(half[0].min_element(), half[1].min_element()));
    let use_b = preferred(face_b.separation, face_a.separation, tolerance);
    let face = if use_b { face_b } else { face_a };
    let (found, normal) = match edge_axis(&a, distance, preference_bound(face.separation, tolerance)) {
        Edges::Separated => return None,
        Edges::Better(edge) => (edge_contact(&a, &edge), edge.normal),
        Edges::Worse => {
            let slack = SLACK_OF_TOLERANCE * tolerance;
            if use_b {
                let found = face_contacts(&b, &face, (Reference::B, slack), distance);
                (found.map(|manifold| moved(manifold, &m, t)), m * -toward(&b, face.axis))
            } else {
                (face_contacts(&a, &face, (Reference::A, slack), distance), toward(&a, face.axis))
            }
        }
    };
    found.or_else(|| {
        // The features of the axis miss each other: near an edge or a corner.
        let (hull_a, hull_b) = (BoxHull::new(half[0]), BoxHull::new(half[1]));
        let placed = Placed::new(&hull_b.hull(), b_in_a);
        if face.separation > 0.0 {
            closest_contact(&hull_a.hull(), &placed.hull(), normal, distance)
        } else {
            polytope::manifold(&hull_a.hull(), &placed.hull(), distance, tolerance)
        }
    })
}

/// A manifold of B's frame in A's.
fn moved(mut manifold: Manifold, m: &Mat3, t: Vec3) -> Manifold {
    manifold.normal = *m * manifold.normal;
    for point in &mut manifold.points {
        point.position = *m * point.position + t;
    }
    manifold
}

/// The axis of this frame, or its opposite, that points to the other box.
fn toward(view: &View, axis: usize) -> Vec3 {
    if view.center[axis] < 0.0 { -Vec3::AXES[axis] } else { Vec3::AXES[axis] }
}

#[inline(always)]
fn face_axis(view: &View, distance: f32) -> Option<FaceAxis> {
    let [x, y, z] = view.axes;
    let [hx, hy, hz] = view.other_half;
    let reach = (x.abs() * hx + y.abs() * hy + z.abs() * hz).to_array();
    let mut best = FaceAxis { axis: 0, separation: f32::NEG_INFINITY };
    let mut gap = 0.0;
    for (axis, center) in view.center.iter().enumerate() {
        let separation = center.abs() - (view.half[axis] + reach[axis]);
        if separation > best.separation {
            best = FaceAxis { axis, separation };
        }
        if separation > 0.0 {
            gap += separation * separation;
        }
    }
    // The axes are perpendicular: boxes beyond a corner are farther than any one of them tells.
    if gap > distance * distance { None } else { Some(best) }
}

/// True when `s / sqrt(square) > bound`, without the root.
#[inline(always)]
fn exceeds(s: f32, square: f32, bound: f32) -> bool {
    if bound >= 0.0 {
        s > 0.0 && s * s > bound * bound * square
    } else {
        s >= 0.0 || s * s < bound * bound * square
    }
}

/// The best edge axis among those whose separation is more than `bound`.
fn edge_axis(view: &View, distance: f32, bound: f32) -> Edges {
    let r = [view.axes[0].to_array(), view.axes[1].to_array(), view.axes[2].to_array()];
    let (ha, hb, t) = (view.half, view.other_half, view.center);
    let mut best: Option<EdgeAxis> = None;
    let mut bound = bound;
    for i in 0..3 {
        let (k, l) = (NEXT[i], AFTER[i]);
        for j in 0..3 {
            let (m, n) = (NEXT[j], AFTER[j]);
            // a_i x b_j has the components -b_l at k and b_k at l; its square is 1 - cos^2.
            let (bk, bl) = (r[j][k], r[j][l]);
            let square = bk * bk + bl * bl;
            if square < PARALLEL {
                continue;
            }
            let shift = t[l] * bk - t[k] * bl;
            // b_m . (a_i x b_j) = a_i . (b_j x b_m), another axis of B.
            let reach_a = ha[k] * bl.abs() + ha[l] * bk.abs();
            let reach_b = hb[m] * r[n][i].abs() + hb[n] * r[m][i].abs();
            let s = shift.abs() - (reach_a + reach_b);
            if s > 0.0 && exceeds(s, square, distance) {
                return Edges::Separated;
            }
            if exceeds(s, square, bound) {
                let size = sqrt(square);
                let sign = if shift < 0.0 { -1.0 } else { 1.0 };
                let mut normal = [0.0; 3];
                (normal[k], normal[l]) = (-bl * sign / size, bk * sign / size);
                bound = s / size;
                best = Some(EdgeAxis { i, j, normal: Vec3::from_array(normal), separation: bound });
            }
        }
    }
    best.map_or(Edges::Worse, Edges::Better)
}

/// The contact of the edge of A farthest along the normal with the edge of B farthest against it.
fn edge_contact(view: &View, axis: &EdgeAxis) -> Option<Manifold> {
    let EdgeAxis { i, j, normal, separation } = *axis;
    let n = normal.to_array();
    let (ha, hb) = (view.half, view.other_half);
    let signed = |positive: bool, h: f32| if positive { h } else { -h };
    let (k, l) = (NEXT[i], AFTER[i]);
    let (k_up, l_up) = (n[k] >= 0.0, n[l] >= 0.0);
    let mut middle = [0.0; 3];
    (middle[k], middle[l]) = (signed(k_up, ha[k]), signed(l_up, ha[l]));
    let (middle_a, along_a) = (Vec3::from_array(middle), Vec3::AXES[i] * ha[i]);
    let (p, q) = (NEXT[j], AFTER[j]);
    let (p_up, q_up) = (normal.dot(view.axes[p]) < 0.0, normal.dot(view.axes[q]) < 0.0);
    let middle_b = Vec3::from_array(view.center)
        + view.axes[p] * signed(p_up, hb[p])
        + view.axes[q] * signed(q_up, hb[q]);
    let along_b = view.axes[j] * hb[j];
    let edge_a = (middle_a - along_a, middle_a + along_a);
    let position = edge_position(edge_a, (middle_b - along_b, middle_b + along_b), separation)?;
    let index = |axis: usize, next: bool, after: bool| 4 * axis + usize::from(next) + 2 * usize::from(after);
    let feature = clip::edge_feature(index(i, k_up, l_up), index(j, p_up, q_up));
    Some(clip::single(normal, ManifoldPoint { position, separation, feature }))
}

/// Contacts of a face of this box with the other box, in this frame.
fn face_contacts(
    view: &View,
    face: &FaceAxis,
    (side, slack): (Reference, f32),
    distance: f32,
) -> Option<Manifold> {
    let i = face.axis;
    let normal = toward(view, i);
    let reference_face = 2 * i + usize::from(view.center[i] >= 0.0);
    let incident = incident_face(view, normal);
    let incident_loop = &BOX_LOOPS[4 * incident..4 * incident + 4];
    let (mut first, mut second) = (Polygon::new(), Polygon::new());
    clip::polygon_of(&corners(view), incident_loop, &mut first);
    let (mut from, mut to) = (&mut first, &mut second);
    for (label, axis) in (SIDE..).step_by(2).zip([NEXT[i], AFTER[i]]) {
        let edge = view.half[axis] + slack;
        if clip::cut(from, to, label, |point| point[axis] - edge) {
            core::mem::swap(&mut from, &mut to);
        }
        if clip::cut(from, to, label + 1, |point| -point[axis] - edge) {
            core::mem::swap(&mut from, &mut to);
        }
    }
    let plane = Plane { normal, offset: view.half[i] };
    let naming = Naming { side, face: reference_face, incident: incident_loop };
    let mut near = Candidates::new();
    clip::candidates(from, &plane, &naming, distance, &mut near);
    let points = clip::reduce_face(&near, normal);
    let normal = if side == Reference::A { normal } else { -normal };
    if points.is_empty() { None } else { Some(Manifold { child: 0, normal, points, surface: 0 }) }
}

/// The face of the other box that looks most against `normal`.
fn incident_face(view: &View, normal: Vec3) -> usize {
    let mut best = 0;
    let mut best_cosine = 0.0;
    for (j, axis) in view.axes.iter().enumerate() {
        let cosine = axis.dot(normal);
        if cosine.abs() > best_cosine + INCIDENT_TIE {
            best = 2 * j + usize::from(cosine < 0.0);
            best_cosine = cosine.abs();
        }
    }
    best
}

/// Corners of the other box.
fn corners(view: &View) -> [Vec3; 8] {
    let center = Vec3::from_array(view.center);
    let [x, y, z] = [
        view.axes[0] * view.other_half[0],
        view.axes[1] * view.other_half[1],
        view.axes[2] * view.other_half[2],
    ];
    let (low, high) = (center - z, center + z);
    let (ll, lh, hl, hh) = (low - y, low + y, high - y, high + y);
    [ll - x, ll + x, lh - x, lh + x, hl - x, hl + x, hh - x, hh + x]
}
