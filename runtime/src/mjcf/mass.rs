//! Mass of forms, and of bodies put together from them.

use super::math::{Matrix, Placement, Vector, add, dot, principal, product, scaled, sub, transposed};
use super::model::{Form, Mass};
use std::f64::consts::PI;

/// Volume of a form and its moments of inertia at mass 1, about its center along its axes; `None` where it has
/// none of its own: half-spaces, and meshes, which know theirs.
pub(super) fn volume(form: &Form) -> Option<(f64, Vector)> {
    match *form {
        Form::HalfSpace | Form::Hull(_) => None,
        Form::Sphere { radius: r } => Some((4.0 / 3.0 * PI * r * r * r, [0.4 * r * r; 3])),
        Form::Capsule { half_height: h, radius: r } => {
            let (cylinder, ball) = (2.0 * PI * r * r * h, 4.0 / 3.0 * PI * r * r * r);
            let (m, n) = (cylinder / (cylinder + ball), ball / (cylinder + ball));
            // The halves of the ball stand away by h, their centers of mass by 3/8 r more.
            let across = m * (r * r / 4.0 + h * h / 3.0) + n * (0.4 * r * r + h * h + 0.75 * h * r);
            Some((cylinder + ball, [across, across, (0.5 * m + 0.4 * n) * r * r]))
        }
        Form::Cylinder { half_height: h, radius: r } => {
            let across = r * r / 4.0 + h * h / 3.0;
            Some((2.0 * PI * r * r * h, [across, across, r * r / 2.0]))
        }
        Form::Box { half_extents: [x, y, z] } => {
            let moments = [y * y + z * z, x * x + z * z, x * x + y * y];
            Some((8.0 * x * y * z, moments.map(|m| m / 3.0)))
        }
        Form::Ellipsoid { half_axes: [x, y, z] } => {
            let moments = [y * y + z * z, x * x + z * z, x * x + y * y];
            Some((4.0 / 3.0 * PI * x * y * z, moments.map(|m| m / 5.0)))
        }
    }
}

impl Mass {
    /// A mass with its center at a place, its axes along that place's.
    pub(super) fn at(placement: &Placement, mass: f64, inertia: Vector) -> Self {
        Self { mass, center: placement.position, inertia, axes: placement.turn }
    }

    /// From a symmetric tensor about the center.
    pub(super) fn of_tensor(mass: f64, center: Vector, tensor: Matrix) -> Self {
        let (inertia, axes) = principal(tensor);
        Self { mass, center, inertia, axes }
    }

    /// The same in the frame that `placement` is given in.
    pub(super) fn moved(&self, placement: &Placement) -> Self {
        let center = placement.transform(self.center);
        Self { center, axes: placement.turn.after(self.axes), ..*self }
    }

    /// With another mass, distributed alike.
    pub(super) fn with(&self, mass: f64) -> Self {
        let factor = if self.mass > 0.0 { mass / self.mass } else { 0.0 };
        Self { mass, inertia: scaled(self.inertia, factor), ..*self }
    }

    /// The tensor about the center, in the body's axes.
    pub(super) fn tensor(&self) -> Matrix {
        let r = self.axes.matrix();
        let mut diagonal = [[0.0; 3]; 3];
        (0..3).for_each(|i| diagonal[i][i] = self.inertia[i]);
        product(product(r, diagonal), transposed(r))
    }

    /// Several masses as one; `None` when there is none. A single one comes out as it is.
    pub(super) fn sum(masses: &[Self]) -> Option<Self> {
        let total = masses.iter().fold(0.0, |sum, mass| sum + mass.mass);
        if total <= 0.0 || masses.len() == 1 {
            return masses.first().filter(|_| total > 0.0).copied();
        }
        let weighed = masses.iter().fold([0.0; 3], |sum, mass| add(sum, scaled(mass.center, mass.mass)));
        let center = scaled(weighed, 1.0 / total);
        let mut tensor = [[0.0; 3]; 3];
        for mass in masses {
            let arm = sub(mass.center, center);
            let own = mass.tensor();
            for (i, row) in tensor.iter_mut().enumerate() {
                for (j, entry) in row.iter_mut().enumerate() {
                    let square = if i == j { dot(arm, arm) } else { 0.0 };
                    *entry += own[i][j] + mass.mass * (square - arm[i] * arm[j]);
                }
            }
        }
        Some(Self::of_tensor(total, center, tensor))
    }

    /// True when no moment exceeds the sum of the other two.
    pub(super) fn is_possible(&self) -> bool {
        let [x, y, z] = self.inertia;
        let slack = 1.0e-9 * (x + y + z);
        x <= y + z + slack && y <= x + z + slack && z <= x + y + slack
    }
}

/// Mass properties at density 1 of the solid that triangles with outward normals enclose; `None` when they
/// enclose nothing.
pub(super) fn enclosed(corners: impl Iterator<Item = [Vector; 3]> + Clone) -> Option<Mass> {
    // About the first corner, so that little cancels far from the origin.
    let origin = corners.clone().next()?[0];
    let (mut volume, mut first, mut second) = (0.0, [0.0; 3], [[0.0; 3]; 3]);
    for triangle in corners {
        let [a, b, c] = triangle.map(|corner| sub(corner, origin));
        let tetrahedron = dot(a, super::math::cross(b, c)) / 6.0;
        let sum = add(add(a, b), c);
        volume += tetrahedron;
        first = add(first, scaled(sum, tetrahedron / 4.0));
        for (i, row) in second.iter_mut().enumerate() {
            for (j, entry) in row.iter_mut().enumerate() {
                let squares = a[i] * a[j] + b[i] * b[j] + c[i] * c[j];
                *entry += tetrahedron / 20.0 * (squares + sum[i] * sum[j]);
            }
        }
    }
    let sound = volume > 0.0 && volume.is_finite();
    if !sound {
        return None;
    }
    let center = scaled(first, 1.0 / volume);
    let mut tensor = [[0.0; 3]; 3];
    for (i, row) in tensor.iter_mut().enumerate() {
        for (j, entry) in row.iter_mut().enumerate() {
            // About the center, by the parallel axis theorem; I = trace(S) 1 - S.
            let spread = |i: usize, j: usize| second[i][j] - volume * center[i] * center[j];
            let trace = spread(0, 0) + spread(1, 1) + spread(2, 2);
            *entry = if i == j { trace - spread(i, i) } else { -spread(i, j) };
        }
    }
    let mass = Mass::of_tensor(volume, add(center, origin), tensor);
    mass.inertia.iter().all(|&moment| moment > 0.0).then_some(mass)
}

#[cfg(test)]
mod tests {
    use super::super::math::Turn;
    use super::*;

    fn close(a: f64, b: f64) -> bool {
        (a - b).abs() <= 1.0e-12 * (a.abs() + b.abs())
    }

    /// Volume and moments by the midpoint rule in thin discs along z, for forms that are round about z.
    fn discs(radius: impl Fn(f64) -> f64, half: f64) -> (f64, Vector) {
        let (mut volume, mut along, mut across) = (0.0, 0.0, 0.0);
        const STEPS: usize = 200_000;
        let step = 2.0 * half / STEPS as f64;
        for i in 0..STEPS {
            let z = -half + (i as f64 + 0.5) * step;
            let r = radius(z);
            let disc = PI * r * r * step;
            volume += disc;
            along += disc * r * r / 2.0;
            across += disc * (r * r / 4.0 + z * z);
        }
        (volume, [across / volume, across / volume, along / volume])
    }

    fn check(form: Form, expected: (f64, Vector)) {
        let found = volume(&form).unwrap();
        assert!((found.0 / expected.0 - 1.0).abs() < 1.0e-8, "{form:?} {found:?} {expected:?}");
        for (a, b) in found.1.into_iter().zip(expected.1) {
            assert!((a / b - 1.0).abs() < 1.0e-8, "{form:?} {found:?} {expected:?}");
        }
    }

    #[test]
    fn forms_by_numeric_integration() {
        let (h, r) = (0.7, 0.3);
        check(Form::Sphere { radius: r }, discs(|z| (r * r - z * z).sqrt(), r));
        check(Form::Cylinder { half_height: h, radius: r }, discs(|_| r, h));
        let round = |z: f64| {
            let over = (z.abs() - h).max(0.0);
            (r * r - over * over).sqrt()
        };
        check(Form::Capsule { half_height: h, radius: r }, discs(round, h + r));
        let half_axes = [r, r, h];
        check(Form::Ellipsoid { half_axes }, discs(|z| r * (1.0 - z * z / (h * h)).sqrt(), h));
    }

    /// The twelve triangles of a box, outwards.
    fn box_triangles(half: Vector, center: Vector) -> Vec<[Vector; 3]> {
        let mut triangles = Vec::new();
        for axis in 0..3 {
            for side in [-1.0, 1.0] {
                let corner = |u: f64, v: f64| {
                    let mut p = [0.0; 3];
                    p[axis] = side;
                    p[(axis + 1) % 3] = u * side;
                    p[(axis + 2) % 3] = v;
                    add(center, [p[0] * half[0], p[1] * half[1], p[2] * half[2]])
                };
                let quad = [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
                triangles.push([quad[0], quad[1], quad[2]]);
                triangles.push([quad[0], quad[2], quad[3]]);
            }
        }
        triangles
    }

    #[test]
    fn triangles_enclose_a_box() {
        let half = [0.5, 1.0, 2.0];
        let center = [100.0, -20.0, 3.0];
        let mass = enclosed(box_triangles(half, center).into_iter()).unwrap();
        let (volume, moments) = volume(&Form::Box { half_extents: half }).unwrap();
        assert!(close(mass.mass, volume), "{mass:?}");
        (0..3).for_each(|i| assert!((mass.center[i] - center[i]).abs() < 1.0e-12));
        let (mut found, mut expected) = (mass.inertia, scaled(moments, volume));
        found.sort_by(f64::total_cmp);
        expected.sort_by(f64::total_cmp);
        (0..3).for_each(|i| assert!((found[i] - expected[i]).abs() < 1.0e-11, "{found:?} {expected:?}"));
        let inwards = box_triangles(half, center).into_iter().map(|[a, b, c]| [a, c, b]);
        assert_eq!(enclosed(inwards.collect::<Vec<_>>().into_iter()), None);
    }

    #[test]
    fn two_halves_are_the_whole() {
        let whole = Form::Box { half_extents: [1.0, 0.4, 0.3] };
        let half = Form::Box { half_extents: [0.5, 0.4, 0.3] };
        let turn = Turn::about([0.6, 0.0, 0.8], 0.7);
        let outer = Placement::new([3.0, 2.0, 1.0], turn);
        let part = |x: f64| {
            let (volume, moments) = volume(&half).unwrap();
            let inner = Placement::new([x, 0.0, 0.0], Turn::IDENTITY);
            Mass::at(&Placement::IDENTITY, volume, scaled(moments, volume)).moved(&inner).moved(&outer)
        };
        let sum = Mass::sum(&[part(-0.5), part(0.5)]).unwrap();
        let (volume, moments) = volume(&whole).unwrap();
        let expected = Mass::at(&outer, volume, scaled(moments, volume));
        assert!(close(sum.mass, volume));
        (0..3).for_each(|i| assert!((sum.center[i] - outer.position[i]).abs() < 1.0e-14));
        let (a, b) = (sum.tensor(), expected.tensor());
        for (a, b) in a.iter().flatten().zip(b.iter().flatten()) {
            assert!((a - b).abs() < 1.0e-14, "{sum:?} {expected:?}");
        }
        assert_eq!(Mass::sum(&[]), None);
        assert_eq!(Mass::sum(&[part(0.5)]), Some(part(0.5)));
    }
}
