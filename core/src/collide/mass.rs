//! Mass, center and inertia of solids and of sums of solids.
//!
//! The tensor of a sum is kept about the sum's own center and every further solid is joined by the parallel axis
//! theorem, so nothing cancels when a body stands far from its frame's origin. At the end the tensor is turned
//! into principal moments by Jacobi rotations, which find small moments of slender bodies as precisely as large
//! ones. All in f64 with `+ - * /` and square roots alone: the same bits everywhere.
//!
//! Invariants: a tensor that is diagonal already gives the identity as axes and its moments in their order; the
//! moments are not negative.

mod rounded;

use super::vector64::{Vector, cross, difference, dot, to_f64, to_vec3};
use super::{Hull, Solid};
use crate::math::{Pose, Rotation, Vec3};

/// Rows of a matrix.
type Matrix = [[f64; 3]; 3];

const IDENTITY: Matrix = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
const PI: f64 = core::f64::consts::PI;
/// A product of inertia below this fraction of the geometric mean of its two moments is rounding: it changes no
/// moment by more than this fraction (Demmel and Veselic 1992), which is less than f32 can tell.
const PRODUCT_MIN: f64 = 1.0e-8;
/// Jacobi sweeps. They converge quadratically: 3x3 matrices need five or six.
const SWEEPS_MAX: usize = 16;

/// How the mass of a body is distributed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MassProperties {
    /// Kilograms. 0 for a body without volume.
    pub mass: f32,
    /// Center of mass in the body's frame, metres.
    pub center: Vec3,
    /// Moments of inertia about the center along the principal axes, kg m2.
    pub inertia: Vec3,
    /// The frame of the principal axes in the body's frame.
    pub axes: Rotation,
}

impl Default for MassProperties {
    fn default() -> Self {
        Self { mass: 0.0, center: Vec3::ZERO, inertia: Vec3::ZERO, axes: Rotation::IDENTITY }
    }
}

impl MassProperties {
    /// The properties of one solid in its own frame. `density` in kg/m3.
    pub fn of(solid: &Solid<'_>, density: f32) -> Self {
        let mut sum = MassAccumulator::default();
        sum.add(solid, &Pose::IDENTITY, density);
        sum.finish()
    }
}

/// Adds up the mass of the solids of a body.
#[derive(Clone, Copy, Debug, Default)]
pub struct MassAccumulator {
    sum: Part,
}

/// Something with mass, in the body's frame.
#[derive(Clone, Copy, Debug, Default)]
struct Part {
    mass: f64,
    center: Vector,
    /// Integral of `x x^T dm` about the center: adds up more simply than the inertia tensor does.
    spread: Matrix,
}

impl MassAccumulator {
    /// Adds a solid of uniform `density` (kg/m3) that stands at `pose` in the body's frame.
    ///
    /// Half-spaces, meshes, height fields and densities that are not positive add nothing. Of a compound every
    /// child counts in full, also where it overlaps others.
    pub fn add(&mut self, solid: &Solid<'_>, pose: &Pose, density: f32) {
        if let Solid::Compound(compound) = solid
            && density > 0.0
        {
            for index in 0..compound.len() as u32 {
                let (child, own) = compound.child(index);
                if let Some(volume) = volume_of(&child) {
                    self.sum = self.sum.joined(&volume.scaled(f64::from(density)).moved(&own).moved(pose));
                }
            }
        }
        if let Some(volume) = volume_of(solid)
            && density > 0.0
        {
            self.sum = self.sum.joined(&volume.scaled(f64::from(density)).moved(pose));
        }
    }

    /// Mass properties of all that was added; all zero and the identity when there was no mass.
    ///
    /// Finite as long as the mass and the moments fit in f32.
    pub fn finish(&self) -> MassProperties {
        let Part { mass, center, spread } = self.sum;
        if mass <= 0.0 {
            return MassProperties::default();
        }
        // I = trace(S) 1 - S.
        let mut inertia = spread.map(|row| row.map(|x| -x));
        for (i, row) in inertia.iter_mut().enumerate() {
            // A sum of positive terms: `trace - spread[i][i]` would cancel for a needle.
            row[i] = spread[(i + 1) % 3][(i + 1) % 3] + spread[(i + 2) % 3][(i + 2) % 3];
        }
        let (moments, axes) = diagonalised(inertia);
        MassProperties {
            mass: mass as f32,
            center: to_vec3(center),
            inertia: to_vec3(moments.map(|x| if x > 0.0 { x } else { 0.0 })),
            axes: rotation_from(&axes),
        }
    }
}

impl Part {
    fn scaled(&self, density: f64) -> Self {
        let spread = self.spread.map(|row| row.map(|x| x * density));
        Self { mass: self.mass * density, center: self.center, spread }
    }

    fn moved(&self, pose: &Pose) -> Self {
        let r = matrix_from(pose.rotation);
        let center = transformed(&r, self.center);
        let position = to_f64(pose.position);
        Self {
            mass: self.mass,
            center: [center[0] + position[0], center[1] + position[1], center[2] + position[2]],
            spread: product(&product(&r, &self.spread), &transposed(&r)),
        }
    }

    /// Both together, by the parallel axis theorem.
    fn joined(&self, other: &Self) -> Self {
        if self.mass <= 0.0 {
            return *other;
        }
        let mass = self.mass + other.mass;
        let share = other.mass / mass;
        let d = difference(other.center, self.center);
        let mut sum = *self;
        sum.mass = mass;
        for i in 0..3 {
            sum.center[i] += d[i] * share;
            for j in 0..3 {
                sum.spread[i][j] += other.spread[i][j] + d[i] * d[j] * (self.mass * share);
            }
        }
        sum
    }
}

/// A solid of density 1 in its own frame; none when it has no volume.
fn volume_of(solid: &Solid<'_>) -> Option<Part> {
    match solid {
        Solid::Sphere { radius } => Some(sphere(f64::from(*radius))),
        Solid::Capsule { half_height, radius } => Some(capsule(f64::from(*half_height), f64::from(*radius))),
        Solid::Box { half_extents } => Some(cuboid(to_f64(*half_extents))),
        Solid::Hull(hull) => Some(polytope(hull)),
        Solid::Cylinder { half_height, radius } => {
            Some(cylinder(f64::from(*half_height), f64::from(*radius)))
        }
        Solid::Cone { half_height, radius } => Some(cone(f64::from(*half_height), f64::from(*radius))),
        Solid::RoundedHull { hull, radius } => Some(rounded::hull(hull, f64::from(*radius))),
        Solid::HalfSpace | Solid::Mesh(_) | Solid::HeightField(_) | Solid::Compound(_) => None,
    }
}

fn sphere(radius: f64) -> Part {
    let mass = 4.0 / 3.0 * PI * radius * radius * radius;
    let s = mass * radius * radius / 5.0;
    Part { mass, center: [0.0; 3], spread: diagonal([s, s, s]) }
}

fn capsule(half_height: f64, radius: f64) -> Part {
    let (h, r2) = (half_height, radius * radius);
    let cylinder = PI * r2 * 2.0 * h;
    let ball = 4.0 / 3.0 * PI * r2 * radius;
    let across = cylinder * r2 / 4.0 + ball * r2 / 5.0;
    // A half ball has its center 3/8 r from its base: integral of (h + z)^2 over both is m (h^2 + 3/4 h r + r^2/5).
    let along = cylinder * h * h / 3.0 + ball * (h * h + 0.75 * h * radius + r2 / 5.0);
    Part { mass: cylinder + ball, center: [0.0; 3], spread: diagonal([across, across, along]) }
}

fn cylinder(half_height: f64, radius: f64) -> Part {
    let (h, r2) = (half_height, radius * radius);
    let mass = PI * r2 * 2.0 * h;
    let across = mass * r2 / 4.0;
    Part { mass, center: [0.0; 3], spread: diagonal([across, across, mass * h * h / 3.0]) }
}

/// A cone of height H = 2 h has its center H / 4 above its base; about it the integral of z^2 is 3/80 m H^2, that
/// of x^2 is 3/20 m r^2.
fn cone(half_height: f64, radius: f64) -> Part {
    let (h, r2) = (half_height, radius * radius);
    let mass = PI * r2 * 2.0 * h / 3.0;
    let across = 0.15 * mass * r2;
    Part { mass, center: [0.0, 0.0, -0.5 * h], spread: diagonal([across, across, 0.15 * mass * h * h]) }
}

fn cuboid(half: Vector) -> Part {
    let mass = 8.0 * half[0] * half[1] * half[2];
    Part { mass, center: [0.0; 3], spread: diagonal(half.map(|x| mass * x * x / 3.0)) }
}

/// A polytope as tetrahedra that join an inner point to the triangles of a fan over each face.
///
/// Over a tetrahedron of volume V with corners 0, a, b, c:  ∫x = V/4 s  and  ∫x x^T = V/20 (a a^T + b b^T +
/// c c^T + s s^T)  with  s = a + b + c.
fn polytope(hull: &Hull<'_>) -> Part {
    let inner = to_f64(hull.center);
    let mut volume = 0.0;
    let mut first = [0.0; 3];
    let mut second = [[0.0; 3]; 3];
    for face in hull.faces {
        let corners = &hull.loops[usize::from(face.first)..usize::from(face.first + face.count)];
        let corner = |i: usize| difference(to_f64(hull.vertices[usize::from(corners[i])]), inner);
        for i in 2..corners.len() {
            let (a, b, c) = (corner(0), corner(i - 1), corner(i));
            let v = dot(a, cross(b, c)) / 6.0;
            let s = [a[0] + b[0] + c[0], a[1] + b[1] + c[1], a[2] + b[2] + c[2]];
            volume += v;
            for j in 0..3 {
                first[j] += v / 4.0 * s[j];
                for k in 0..3 {
                    second[j][k] += v / 20.0 * (a[j] * a[k] + b[j] * b[k] + c[j] * c[k] + s[j] * s[k]);
                }
            }
        }
    }
    if volume <= 0.0 {
        return Part { mass: 0.0, center: inner, spread: [[0.0; 3]; 3] };
    }
    // `inner` may be any point inside: what is left of the offset is small, so this subtraction is harmless.
    let offset = first.map(|x| x / volume);
    for j in 0..3 {
        for k in 0..3 {
            second[j][k] -= volume * offset[j] * offset[k];
        }
    }
    let center = [inner[0] + offset[0], inner[1] + offset[1], inner[2] + offset[2]];
    Part { mass: volume, center, spread: second }
}

/// Eigenvalues of a symmetric matrix and the rotation whose columns are its eigenvectors, by cyclic Jacobi
/// rotations of at most an eighth of a turn: axes keep their order when they hardly turn.
fn diagonalised(mut m: Matrix) -> (Vector, Matrix) {
    let mut axes = IDENTITY;
    for _ in 0..SWEEPS_MAX {
        let mut turned = 0;
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            if m[p][q] * m[p][q] > PRODUCT_MIN * PRODUCT_MIN * (m[p][p] * m[q][q]).abs() {
                turn(&mut m, &mut axes, p, q);
                turned += 1;
            }
        }
        if turned == 0 {
            break;
        }
    }
    ([m[0][0], m[1][1], m[2][2]], axes)
}

/// One Jacobi rotation: makes `m[p][q]` zero by turning axes `p` and `q`.
fn turn(m: &mut Matrix, axes: &mut Matrix, p: usize, q: usize) {
    // tan(2a) = 2 m_pq / (m_qq - m_pp); the smaller root keeps the angle within an eighth of a turn.
    let theta = (m[q][q] - m[p][p]) / (2.0 * m[p][q]);
    let root = libm::sqrt(theta * theta + 1.0);
    let t = if theta >= 0.0 { 1.0 / (theta + root) } else { 1.0 / (theta - root) };
    let c = 1.0 / libm::sqrt(t * t + 1.0);
    let s = t * c;
    let r = 3 - p - q;
    let off = m[p][q];
    m[p][p] -= t * off;
    m[q][q] += t * off;
    (m[p][q], m[q][p]) = (0.0, 0.0);
    let (rp, rq) = (m[r][p], m[r][q]);
    m[r][p] = c * rp - s * rq;
    m[r][q] = s * rp + c * rq;
    (m[p][r], m[q][r]) = (m[r][p], m[r][q]);
    for row in axes {
        (row[p], row[q]) = (c * row[p] - s * row[q], s * row[p] + c * row[q]);
    }
}

fn rotation_from(m: &Matrix) -> Rotation {
    // Shepperd's method in f64: divide by the largest part.
    let (xx, yy, zz) = (m[0][0], m[1][1], m[2][2]);
    let q = if xx + yy + zz > 0.0 {
        [m[2][1] - m[1][2], m[0][2] - m[2][0], m[1][0] - m[0][1], 1.0 + xx + yy + zz]
    } else if xx >= yy && xx >= zz {
        [1.0 + xx - yy - zz, m[0][1] + m[1][0], m[0][2] + m[2][0], m[2][1] - m[1][2]]
    } else if yy >= zz {
        [m[0][1] + m[1][0], 1.0 - xx + yy - zz, m[1][2] + m[2][1], m[0][2] - m[2][0]]
    } else {
        [m[0][2] + m[2][0], m[1][2] + m[2][1], 1.0 - xx - yy + zz, m[1][0] - m[0][1]]
    };
    let norm = libm::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    let [x, y, z, w] = q.map(|part| (part / norm) as f32);
    Rotation::new(x, y, z, w)
}

fn matrix_from(rotation: Rotation) -> Matrix {
    let q = [rotation.x, rotation.y, rotation.z, rotation.w].map(f64::from);
    let norm2 = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
    // f32 parts have norm 1 only to 1e-7: dividing by it here keeps the matrix orthonormal to 1e-16.
    let k = if norm2 > 0.0 { 2.0 / norm2 } else { 0.0 };
    let [x, y, z, w] = q;
    [
        [1.0 - k * (y * y + z * z), k * (x * y - w * z), k * (x * z + w * y)],
        [k * (x * y + w * z), 1.0 - k * (x * x + z * z), k * (y * z - w * x)],
        [k * (x * z - w * y), k * (y * z + w * x), 1.0 - k * (x * x + y * y)],
    ]
}

fn diagonal(d: Vector) -> Matrix {
    [[d[0], 0.0, 0.0], [0.0, d[1], 0.0], [0.0, 0.0, d[2]]]
}

fn product(a: &Matrix, b: &Matrix) -> Matrix {
    a.map(|row| [0, 1, 2].map(|j| row[0] * b[0][j] + row[1] * b[1][j] + row[2] * b[2][j]))
}

fn transposed(a: &Matrix) -> Matrix {
    [0, 1, 2].map(|i| [a[0][i], a[1][i], a[2][i]])
}

fn transformed(a: &Matrix, v: Vector) -> Vector {
    a.map(|row| dot(row, v))
}

#[cfg(test)]
mod tests;
