//! Vectors, rotations and poses in f64, with `+ - * /`, square roots and `libm` alone: a model has the same bits
//! on every machine.

use std::f64::consts::PI;

/// Coordinates, metres, or a direction.
pub type Vector = [f64; 3];
/// Rows of a matrix.
pub(super) type Matrix = [[f64; 3]; 3];

/// Jacobi sweeps. They converge quadratically: 3x3 matrices need five or six.
const SWEEPS_MAX: usize = 16;
/// A product of inertia below this fraction of its two moments' geometric mean is rounding.
const PRODUCT_MIN: f64 = 1.0e-15;

pub(super) fn add(a: Vector, b: Vector) -> Vector {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

pub(super) fn sub(a: Vector, b: Vector) -> Vector {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

pub(super) fn scaled(a: Vector, factor: f64) -> Vector {
    a.map(|x| x * factor)
}

pub(super) fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(super) fn cross(a: Vector, b: Vector) -> Vector {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

pub(super) fn length(a: Vector) -> f64 {
    dot(a, a).sqrt()
}

/// The direction of `a`; `None` when it is shorter than 1e-10.
pub(super) fn direction(a: Vector) -> Option<Vector> {
    let length = length(a);
    (length > 1.0e-10).then(|| scaled(a, 1.0 / length))
}

/// A rotation as a unit quaternion, the real part last.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Turn {
    /// Imaginary part.
    pub xyz: Vector,
    /// Real part.
    pub w: f64,
}

impl Turn {
    /// No rotation.
    pub const IDENTITY: Self = Self { xyz: [0.0; 3], w: 1.0 };

    /// `[x, y, z, w]`.
    pub fn to_array(self) -> [f64; 4] {
        let [x, y, z] = self.xyz;
        [x, y, z, self.w]
    }

    /// By `angle` radians about a unit vector.
    pub(super) fn about(axis: Vector, angle: f64) -> Self {
        // Whole turns are taken off first, exactly: the sine of a large angle would lose them in its rounding.
        let half = (angle % (4.0 * PI)) * 0.5;
        Self { xyz: scaled(axis, libm::sin(half)), w: libm::cos(half) }
    }

    /// From `[w, x, y, z]`, as MJCF writes it, of any length; `None` when it is nearly zero.
    pub(super) fn from_wxyz([w, x, y, z]: [f64; 4]) -> Option<Self> {
        let norm = (w * w + x * x + y * y + z * z).sqrt();
        (norm > 1.0e-10).then(|| Self { xyz: [x / norm, y / norm, z / norm], w: w / norm })
    }

    /// The least rotation that takes the z axis to a direction of any length.
    pub(super) fn z_to(to: Vector) -> Option<Self> {
        let to = direction(to)?;
        let axis = cross([0.0, 0.0, 1.0], to);
        let sine = length(axis);
        // Up or down: any axis across will do.
        let axis = direction(axis).unwrap_or([1.0, 0.0, 0.0]);
        Some(Self::about(axis, libm::atan2(sine, to[2])))
    }

    /// From unit columns at right angles.
    pub(super) fn from_columns([x, y, z]: [Vector; 3]) -> Self {
        // The largest of the four squares is at least a quarter (Shepperd 1978).
        let squares = [
            1.0 + x[0] + y[1] + z[2],
            1.0 + x[0] - y[1] - z[2],
            1.0 - x[0] + y[1] - z[2],
            1.0 - x[0] - y[1] + z[2],
        ];
        let largest = (1..4).fold(0, |best, i| if squares[i] > squares[best] { i } else { best });
        let (a, b, c) = (y[2] - z[1], z[0] - x[2], x[1] - y[0]);
        let (d, e, f) = (x[1] + y[0], z[0] + x[2], y[2] + z[1]);
        let wxyz = match largest {
            0 => [squares[0], a, b, c],
            1 => [a, squares[1], d, e],
            2 => [b, d, squares[2], f],
            _ => [c, e, f, squares[3]],
        };
        Self::from_wxyz(wxyz).unwrap_or(Self::IDENTITY)
    }

    /// First `first`, then this.
    pub(super) fn after(self, first: Self) -> Self {
        let xyz = add(add(scaled(first.xyz, self.w), scaled(self.xyz, first.w)), cross(self.xyz, first.xyz));
        let w = self.w * first.w - dot(self.xyz, first.xyz);
        let norm = (dot(xyz, xyz) + w * w).sqrt();
        Self { xyz: scaled(xyz, 1.0 / norm), w: w / norm }
    }

    pub(super) fn inverse(self) -> Self {
        Self { xyz: scaled(self.xyz, -1.0), w: self.w }
    }

    pub(super) fn rotate(self, v: Vector) -> Vector {
        let t = scaled(cross(self.xyz, v), 2.0);
        add(add(v, scaled(t, self.w)), cross(self.xyz, t))
    }

    /// Rows of the rotation's matrix.
    pub(super) fn matrix(self) -> Matrix {
        transposed([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(|axis| self.rotate(axis)))
    }
}

/// A place and a rotation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    /// Metres.
    pub position: Vector,
    /// How the frame is turned.
    pub turn: Turn,
}

impl Placement {
    /// At the origin, not turned.
    pub const IDENTITY: Self = Self { position: [0.0; 3], turn: Turn::IDENTITY };

    pub(super) fn new(position: Vector, turn: Turn) -> Self {
        Self { position, turn }
    }

    /// A point of the inner frame in the outer one.
    pub(super) fn transform(&self, point: Vector) -> Vector {
        add(self.position, self.turn.rotate(point))
    }

    /// The frame `inner`, given in this one, in the frame that this one is given in.
    pub(super) fn after(&self, inner: &Self) -> Self {
        Self { position: self.transform(inner.position), turn: self.turn.after(inner.turn) }
    }

    pub(super) fn inverse(&self) -> Self {
        let turn = self.turn.inverse();
        Self { position: scaled(turn.rotate(self.position), -1.0), turn }
    }
}

pub(super) fn transposed(m: Matrix) -> Matrix {
    [0, 1, 2].map(|i| [m[0][i], m[1][i], m[2][i]])
}

pub(super) fn product(a: Matrix, b: Matrix) -> Matrix {
    let columns = transposed(b);
    a.map(|row| columns.map(|column| dot(row, column)))
}

/// Principal moments and the rotation of their axes, of a symmetric matrix, by Jacobi rotations.
///
/// A matrix that is diagonal already gives its diagonal and no rotation.
pub(super) fn principal(mut m: Matrix) -> (Vector, Turn) {
    let mut axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    for _ in 0..SWEEPS_MAX {
        let mut turned = false;
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            if m[p][q] == 0.0 || m[p][q] * m[p][q] <= PRODUCT_MIN * PRODUCT_MIN * (m[p][p] * m[q][q]).abs() {
                continue;
            }
            turned = true;
            let theta = (m[q][q] - m[p][p]) / (2.0 * m[p][q]);
            let sign = if theta < 0.0 { -1.0 } else { 1.0 };
            let tangent = sign / (theta.abs() + (theta * theta + 1.0).sqrt());
            let cosine = 1.0 / (tangent * tangent + 1.0).sqrt();
            let sine = tangent * cosine;
            let mut rotation = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
            rotation[p][p] = cosine;
            rotation[q][q] = cosine;
            rotation[p][q] = sine;
            rotation[q][p] = -sine;
            m = product(product(transposed(rotation), m), rotation);
            axes = product(axes, rotation);
        }
        if !turned {
            break;
        }
    }
    ([m[0][0], m[1][1], m[2][2]], Turn::from_columns(transposed(axes)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(a: Vector, b: Vector) -> bool {
        length(sub(a, b)) < 1.0e-14
    }

    #[test]
    fn rotations() {
        let quarter = Turn::about([0.0, 0.0, 1.0], PI / 2.0);
        assert!(close(quarter.rotate([1.0, 0.0, 0.0]), [0.0, 1.0, 0.0]));
        let tilt = Turn::about([1.0, 0.0, 0.0], 0.3);
        let both = quarter.after(tilt);
        let v = [0.3, -0.7, 2.0];
        assert!(close(both.rotate(v), quarter.rotate(tilt.rotate(v))));
        assert!(close(both.inverse().rotate(both.rotate(v)), v));
        for to in [[0.0, 0.0, 2.0], [0.0, 0.0, -1.0], [1.0, 2.0, -3.0], [-1.0, 0.0, 0.0]] {
            let turned = Turn::z_to(to).unwrap().rotate([0.0, 0.0, 1.0]);
            assert!(close(turned, direction(to).unwrap()), "{to:?}");
        }
        assert_eq!(Turn::z_to([0.0; 3]), None);
    }

    #[test]
    fn columns_give_the_rotation_back() {
        for angle in [0.1, 1.0, 2.0, 3.0, PI, 5.0] {
            for axis in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.6, 0.0, 0.8], [0.0, -0.6, 0.8]]
            {
                let turn = Turn::about(axis, angle);
                let again = Turn::from_columns(transposed(turn.matrix()));
                let v = [0.3, -0.7, 2.0];
                assert!(close(again.rotate(v), turn.rotate(v)), "{axis:?} {angle}");
            }
        }
    }

    #[test]
    fn poses() {
        let outer = Placement::new([1.0, 2.0, 3.0], Turn::about([0.0, 1.0, 0.0], 0.4));
        let inner = Placement::new([0.5, 0.0, -1.0], Turn::about([1.0, 0.0, 0.0], -0.9));
        let p = [0.1, 0.2, 0.3];
        assert!(close(outer.after(&inner).transform(p), outer.transform(inner.transform(p))));
        assert!(close(outer.inverse().transform(outer.transform(p)), p));
    }

    #[test]
    fn principal_moments() {
        let turn = Turn::about([0.6, 0.0, 0.8], 0.7).after(Turn::about([0.0, 1.0, 0.0], 0.3));
        let r = turn.matrix();
        let moments = [3.0, 1.0e-6, 2.0];
        let diagonal = [[3.0, 0.0, 0.0], [0.0, 1.0e-6, 0.0], [0.0, 0.0, 2.0]];
        let m = product(product(r, diagonal), transposed(r));
        let (found, axes) = principal(m);
        let r = axes.matrix();
        let mut sorted = found;
        sorted.sort_by(f64::total_cmp);
        for (a, b) in sorted.into_iter().zip([1.0e-6, 2.0, 3.0]) {
            assert!((a - b).abs() < 1.0e-13, "{found:?}");
        }
        let found = [[found[0], 0.0, 0.0], [0.0, found[1], 0.0], [0.0, 0.0, found[2]]];
        let again = product(product(r, found), transposed(r));
        for (a, b) in again.iter().flatten().zip(m.iter().flatten()) {
            assert!((a - b).abs() < 1.0e-14);
        }
        assert_eq!(principal(diagonal), (moments, Turn::IDENTITY));
    }
}
