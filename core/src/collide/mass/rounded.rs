//! A convex hull with a radius, in closed form.
//!
//! All points within `r` of a polytope are the polytope itself and, without overlap (Steiner 1840):
//!
//! ```text
//! over each face     a prism of height r
//! along each edge    a wedge: a sector of a circle between the normals of its faces, times its length
//! at each corner     a sector of a ball over the spherical polygon of the normals that meet there
//! ```
//! Of a spherical polygon with unit sides' arcs from p to q, of length t and outward conormal v (the normal of the
//! arc's plane), with w the integral of u along the arc:
//!
//! ```text
//! area                    sum of the triangles from an inner point     (van Oosterom and Strackee 1983)
//! integral of u           -1/2 sum of t v                              (the divergence theorem on the cone)
//! integral of u u^T       area/3 1 - 1/6 sum of (v w^T + w v^T)        (u u^T - 1/3 is harmonic of degree 2)
//! ```

use super::{Matrix, Part, Vector, cross, difference, dot, polytope, to_f64};
use crate::collide::vector64::length;
use crate::collide::{Edge, Hull};

/// Mass, center and spread of all points within `radius` of a hull.
pub(super) fn hull(hull: &Hull<'_>, radius: f64) -> Part {
    let mut sum = polytope(hull);
    for face in 0..hull.faces.len() {
        add_face(&mut sum, hull, face, radius);
    }
    for edge in hull.edges {
        add_edge(&mut sum, hull, edge, radius);
    }
    for vertex in 0..hull.vertices.len() {
        sum = sum.joined(&corner(hull, vertex, radius));
    }
    sum
}

fn plus(a: Vector, b: Vector, scale: f64) -> Vector {
    [a[0] + b[0] * scale, a[1] + b[1] * scale, a[2] + b[2] * scale]
}

fn add_outer(m: &mut Matrix, a: Vector, b: Vector, scale: f64) {
    for (row, x) in m.iter_mut().zip(a) {
        for (cell, y) in row.iter_mut().zip(b) {
            *cell += x * y * scale;
        }
    }
}

fn normal_of(hull: &Hull<'_>, face: usize) -> Vector {
    let n = to_f64(hull.planes[face].normal);
    let size = length(n);
    n.map(|x| x / size)
}

/// The prisms over the triangles of a face's fan.
fn add_face(sum: &mut Part, hull: &Hull<'_>, face: usize, radius: f64) {
    let n = normal_of(hull, face);
    let run = hull.faces[face];
    let corners = &hull.loops[usize::from(run.first)..usize::from(run.first + run.count)];
    let at = |i: usize| to_f64(hull.vertices[usize::from(corners[i])]);
    for i in 2..corners.len() {
        let triangle = [at(0), at(i - 1), at(i)];
        let area =
            0.5 * dot(cross(difference(triangle[1], triangle[0]), difference(triangle[2], triangle[0])), n);
        let middle = triangle.iter().fold([0.0; 3], |sum, &corner| plus(sum, corner, 1.0 / 3.0));
        let mass = area * radius;
        let mut spread = [[0.0; 3]; 3];
        for corner in triangle {
            let d = difference(corner, middle);
            add_outer(&mut spread, d, d, mass / 12.0);
        }
        add_outer(&mut spread, n, n, mass * radius * radius / 12.0);
        *sum = sum.joined(&Part { mass, center: plus(middle, n, 0.5 * radius), spread });
    }
}

/// The wedge along an edge.
fn add_edge(sum: &mut Part, hull: &Hull<'_>, edge: &Edge, radius: f64) {
    let (left, right) = (normal_of(hull, usize::from(edge.left)), normal_of(hull, usize::from(edge.right)));
    let (tail, head) =
        (to_f64(hull.vertices[usize::from(edge.tail)]), to_f64(hull.vertices[usize::from(edge.head)]));
    let along = difference(head, tail);
    let side = cross(left, right);
    let angle = libm::atan2(length(side), dot(left, right));
    let outward = plus(left, right, 1.0);
    let size = length(outward);
    if angle <= 0.0 || size <= 0.0 {
        return;
    }
    // Axes of the sector: along its middle, and across it. Half angle a:
    // area a r^2, center 2/3 r sin a / a, integrals of the squares r^4/4 (a + sin a cos a) and r^4/4 (a - sin a cos
    // a).
    let middle = outward.map(|x| x / size);
    let across = difference(left, right);
    let across = across.map(|x| x / length(across));
    let half = 0.5 * angle;
    let (sine, cosine) = (libm::sin(half), libm::cos(half));
    let (span, area) = (length(along), half * radius * radius);
    let mass = area * span;
    let reach = 2.0 / 3.0 * radius * sine / half;
    let fourth = 0.25 * radius * radius * radius * radius * span;
    let mut spread = [[0.0; 3]; 3];
    add_outer(&mut spread, middle, middle, fourth * (half + sine * cosine) - mass * reach * reach);
    add_outer(&mut spread, across, across, fourth * (half - sine * cosine));
    add_outer(&mut spread, along, along, mass / 12.0);
    let center = plus(plus(tail, along, 0.5), middle, reach);
    *sum = sum.joined(&Part { mass, center, spread });
}

/// The sector of a ball at a corner.
fn corner(hull: &Hull<'_>, vertex: usize, radius: f64) -> Part {
    let at = to_f64(hull.vertices[vertex]);
    let arcs = || {
        hull.edges.iter().filter(|edge| usize::from(edge.tail) == vertex || usize::from(edge.head) == vertex)
    };
    let normals =
        |edge: &Edge| (normal_of(hull, usize::from(edge.left)), normal_of(hull, usize::from(edge.right)));
    let inner = arcs().fold([0.0; 3], |sum, edge| {
        let (p, q) = normals(edge);
        plus(plus(sum, p, 1.0), q, 1.0)
    });
    let inner = inner.map(|x| x / length(inner));
    let (mut area, mut first, mut second) = (0.0, [0.0; 3], [[0.0; 3]; 3]);
    for edge in arcs() {
        let (p, q) = normals(edge);
        let side = cross(p, q);
        let sine = length(side);
        if sine <= 0.0 {
            continue;
        }
        let angle = libm::atan2(sine, dot(p, q));
        let turn = if dot(side, inner) > 0.0 { -1.0 } else { 1.0 };
        let outward = side.map(|x| x * (turn / sine));
        let volume = dot(inner, side);
        let volume = if volume < 0.0 { -volume } else { volume };
        area += 2.0 * libm::atan2(volume, 1.0 + dot(inner, p) + dot(p, q) + dot(q, inner));
        first = plus(first, outward, -0.5 * angle);
        // Along the arc u = p cos s + p' sin s with p' across p towards q; w is its integral over 0..angle.
        let ahead = plus(q, p, -dot(p, q)).map(|x| x / sine);
        let along = plus(p.map(|x| x * sine), ahead, 1.0 - dot(p, q));
        add_outer(&mut second, outward, along, -1.0 / 6.0);
        add_outer(&mut second, along, outward, -1.0 / 6.0);
    }
    for (i, row) in second.iter_mut().enumerate() {
        row[i] += area / 3.0;
    }
    // Integrals over the ball's radius: r^3/3, r^4/4 and r^5/5.
    let mass = area * radius * radius * radius / 3.0;
    if mass <= 0.0 {
        return Part::default();
    }
    let offset = first.map(|x| 0.75 * radius * x / area);
    let scale = radius * radius * radius * radius * radius / 5.0;
    let mut spread = second.map(|row| row.map(|x| x * scale));
    add_outer(&mut spread, offset, offset, -mass);
    Part { mass, center: plus(at, offset, 1.0), spread }
}
