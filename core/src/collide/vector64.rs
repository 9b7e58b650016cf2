//! Vectors in f64: for the building of assets (hulls, masses), and where a step would lose what is conserved.

use crate::math::Vec3;

/// A vector or a point.
pub(crate) type Vector = [f64; 3];

pub(crate) fn to_f64(v: Vec3) -> Vector {
    [f64::from(v.x), f64::from(v.y), f64::from(v.z)]
}

pub(crate) fn to_vec3(v: Vector) -> Vec3 {
    Vec3::new(v[0] as f32, v[1] as f32, v[2] as f32)
}

pub(crate) fn difference(a: Vector, b: Vector) -> Vector {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

pub(crate) fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(crate) fn cross(a: Vector, b: Vector) -> Vector {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

pub(crate) fn length(v: Vector) -> f64 {
    libm::sqrt(dot(v, v))
}
