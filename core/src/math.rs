//! Vectors, rotations and poses in one fixed order of operations.
//!
//! Everything that reaches state is made of `+ - * /` and square roots, which IEEE 754 fixes to the last
//! bit, and of `libm` for the rest. Quaternion products are written out here, once, because the order of their
//! sums is part of the result. `min`/`max` compare, since the hardware's disagree where +0 meets -0.

use crate::lanes::FLUSH;
use bytemuck::{Pod, Zeroable};
pub use glam::{Mat3, Vec3};
use wide::f32x4;

/// Half a turn, radians.
pub const PI: f32 = core::f32::consts::PI;

/// The lesser of two numbers; `b` when they compare equal or `a` is not a number.
#[inline(always)]
pub fn min(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

/// The greater of two numbers; `b` when they compare equal or `a` is not a number.
#[inline(always)]
pub fn max(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// `x` kept within `low..=high`.
#[inline(always)]
pub fn clamp(x: f32, low: f32, high: f32) -> f32 {
    max(low, min(x, high))
}

/// Component-wise [`min`].
#[inline(always)]
pub fn min_each(a: Vec3, b: Vec3) -> Vec3 {
    Vec3::new(min(a.x, b.x), min(a.y, b.y), min(a.z, b.z))
}

/// Component-wise [`max`].
#[inline(always)]
pub fn max_each(a: Vec3, b: Vec3) -> Vec3 {
    Vec3::new(max(a.x, b.x), max(a.y, b.y), max(a.z, b.z))
}

/// Square root, correctly rounded everywhere.
#[inline(always)]
pub fn sqrt(x: f32) -> f32 {
    libm::sqrtf(x)
}

/// Sine of an angle in radians.
pub fn sin(x: f32) -> f32 {
    libm::sinf(x)
}

/// Cosine of an angle in radians.
pub fn cos(x: f32) -> f32 {
    libm::cosf(x)
}

/// Angle of the point `(x, y)` in radians, in `-PI..=PI`.
pub fn atan2(y: f32, x: f32) -> f32 {
    libm::atan2f(y, x)
}

/// Angle in radians whose cosine is `x`.
pub fn acos(x: f32) -> f32 {
    libm::acosf(x)
}

/// Length of a vector.
#[inline(always)]
pub fn length(v: Vec3) -> f32 {
    sqrt(v.dot(v))
}

/// `v` scaled to unit length, or `fallback` when it is too short (or not finite) to have a direction.
#[inline]
pub fn normalize_or(v: Vec3, fallback: Vec3) -> Vec3 {
    let length = length(v);
    if length > 1.0e-20 && length < 1.0e20 { v / length } else { fallback }
}

/// Some unit vector perpendicular to the unit vector `n`, continuous except where |n.x| crosses 0.577.
#[inline]
pub fn any_perpendicular(n: Vec3) -> Vec3 {
    // One component of a unit vector is at most 1/sqrt(3): cross with that axis.
    let v = if n.x.abs() < 0.577_350_3 { Vec3::new(0.0, n.z, -n.y) } else { Vec3::new(n.y, -n.x, 0.0) };
    v / length(v)
}

/// A rotation as a unit quaternion. `#[repr(C)]`, plain bytes.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Rotation {
    /// First imaginary part.
    pub x: f32,
    /// Second imaginary part.
    pub y: f32,
    /// Third imaginary part.
    pub z: f32,
    /// Real part.
    pub w: f32,
}

impl Default for Rotation {
    fn default() -> Self {
        Self::IDENTITY
    }
}

/// Bits of each of the three lesser components of a packed rotation.
const COMPONENT_BITS: u32 = 20;
/// Largest packed component.
const COMPONENT_MAX: i32 = (1 << (COMPONENT_BITS - 1)) - 1;
/// A lesser component of a unit quaternion is at most the root of one half.
const COMPONENT_SCALE: f32 = COMPONENT_MAX as f32 * core::f32::consts::SQRT_2;
/// Added and taken away it rounds a number of up to 2^22 to the nearest whole one, of two to the even one: sums of
/// that size have no fraction.
const TO_WHOLE: f32 = 12_582_912.0;

/// How far the square of a quaternion's length may be from 1 to be corrected without a root.
pub(crate) const RENORMAL: f32 = 1.0e-4;

impl Rotation {
    /// The rotation in 8 bytes, by its three lesser components, to 5e-6 rad. Exact for no rotation.
    pub(crate) fn pack(self) -> [u32; 2] {
        let parts = [self.x, self.y, self.z, self.w];
        let mut largest = 3;
        for i in 0..3 {
            if parts[i].abs() > parts[largest].abs() {
                largest = i;
            }
        }
        let sign = if parts[largest] < 0.0 { -1.0 } else { 1.0 };
        let [x, y, z, w] = parts;
        let rest = match largest {
            0 => [y, z, w],
            1 => [x, z, w],
            2 => [x, y, w],
            _ => [x, y, z],
        };
        let bits = rest.iter().fold(largest as u64, |bits, part| {
            let rounded = (sign * part * COMPONENT_SCALE + TO_WHOLE) - TO_WHOLE;
            let rounded = (rounded as i32).clamp(-COMPONENT_MAX, COMPONENT_MAX);
            bits << COMPONENT_BITS | (rounded as u64 & ((1 << COMPONENT_BITS) - 1))
        });
        [bits as u32, (bits >> 32) as u32]
    }

    /// The rotation that [`Rotation::pack`] wrote; `None` for bits that it does not write.
    pub(crate) fn unpack([low, high]: [u32; 2]) -> Option<Self> {
        let bits = u64::from(high) << 32 | u64::from(low);
        let largest = (bits >> (3 * COMPONENT_BITS)) as usize;
        // The shift to the left and back extends the sign.
        let component = |place: u32| {
            let raw = ((bits >> (place * COMPONENT_BITS)) as u32) << (32 - COMPONENT_BITS);
            ((raw as i32) >> (32 - COMPONENT_BITS)) as f32 * (1.0 / COMPONENT_SCALE)
        };
        let (a, b, c) = (component(2), component(1), component(0));
        let rest = 1.0 - a * a - b * b - c * c;
        let last = sqrt(if rest > 0.0 { rest } else { 0.0 });
        match largest {
            0 => Some(Self::new(last, a, b, c)),
            1 => Some(Self::new(a, last, b, c)),
            2 => Some(Self::new(a, b, last, c)),
            3 => Some(Self::new(a, b, c, last)),
            _ => None,
        }
    }
}

impl Rotation {
    /// No rotation.
    pub const IDENTITY: Self = Self { x: 0.0, y: 0.0, z: 0.0, w: 1.0 };

    /// The quaternion `x i + y j + z k + w`, as given.
    pub const fn new(x: f32, y: f32, z: f32, w: f32) -> Self {
        Self { x, y, z, w }
    }

    /// Right-handed rotation by `angle` radians about the unit vector `axis`.
    pub fn from_axis_angle(axis: Vec3, angle: f32) -> Self {
        let s = sin(angle * 0.5);
        Self::new(axis.x * s, axis.y * s, axis.z * s, cos(angle * 0.5))
    }

    /// Rotation by the vector `v`: about its direction by its length in radians (the exponential map).
    pub fn from_rotation_vector(v: Vec3) -> Self {
        let angle = length(v);
        if angle < 1.0e-4 {
            // sin(a/2)/a = 1/2 - a^2/48 and cos(a/2) = 1 - a^2/8, exact to rounding here.
            let a2 = angle * angle;
            let s = 0.5 - a2 * (1.0 / 48.0);
            return Self::new(v.x * s, v.y * s, v.z * s, 1.0 - a2 * 0.125).normalized();
        }
        Self::from_axis_angle(v / angle, angle)
    }

    /// The shortest rotation that takes the unit vector `from` to the unit vector `to`.
    pub fn between(from: Vec3, to: Vec3) -> Self {
        let w = 1.0 + from.dot(to);
        if w < 1.0e-6 {
            let axis = any_perpendicular(from);
            return Self::new(axis.x, axis.y, axis.z, 0.0);
        }
        let c = from.cross(to);
        Self::new(c.x, c.y, c.z, w).normalized()
    }

    /// The rotation of a right-handed orthonormal frame whose axes are the columns of `m` (Shepperd's method).
    pub fn from_matrix(m: &Mat3) -> Self {
        let (xx, yy, zz) = (m.x_axis.x, m.y_axis.y, m.z_axis.z);
        let (x, y, z) = (m.x_axis, m.y_axis, m.z_axis);
        let q = if zz <= 0.0 {
            if xx >= yy {
                Self::new(1.0 + xx - yy - zz, y.x + x.y, x.z + z.x, y.z - z.y)
            } else {
                Self::new(y.x + x.y, 1.0 - xx + yy - zz, z.y + y.z, z.x - x.z)
            }
        } else if xx + yy <= 0.0 {
            Self::new(x.z + z.x, z.y + y.z, 1.0 - xx - yy + zz, x.y - y.x)
        } else {
            Self::new(y.z - z.y, z.x - x.z, x.y - y.x, 1.0 + xx + yy + zz)
        };
        q.normalized()
    }

    /// Imaginary part.
    #[inline(always)]
    pub fn imaginary(self) -> Vec3 {
        Vec3::new(self.x, self.y, self.z)
    }

    /// The unit quaternion next to a quaternion that is one but for rounding: without root or division.
    #[inline]
    pub(crate) fn renormalized(self) -> Self {
        let off = self.norm_squared() - 1.0;
        if off.abs() < RENORMAL {
            // 1 / sqrt(1 + x) = 1 - x / 2 + 3 x^2 / 8 - ..., whose square term is below 4e-9.
            let k = 1.0 - 0.5 * off;
            return Self::new(self.x * k, self.y * k, self.z * k, self.w * k);
        }
        self.normalized()
    }

    /// Scaled to unit length; the identity when it has none.
    pub fn normalized(self) -> Self {
        let norm = sqrt(self.norm_squared());
        if norm > 1.0e-20 && norm < 1.0e20 {
            Self::new(self.x / norm, self.y / norm, self.z / norm, self.w / norm)
        } else {
            Self::IDENTITY
        }
    }

    /// Sum of the squares of the four parts; 1 for a rotation.
    pub fn norm_squared(self) -> f32 {
        self.x * self.x + self.y * self.y + self.z * self.z + self.w * self.w
    }

    /// True when all four parts are finite.
    pub fn is_finite(self) -> bool {
        self.x.is_finite() && self.y.is_finite() && self.z.is_finite() && self.w.is_finite()
    }

    /// The rotation backwards.
    #[inline(always)]
    pub fn inverse(self) -> Self {
        Self::new(-self.x, -self.y, -self.z, self.w)
    }

    /// With parts below 2^-56 as 0: turns that small are nothing, and their squares are slow.
    #[inline(always)]
    pub(crate) fn flushed(self) -> Self {
        let parts = f32x4::new([self.x, self.y, self.z, self.w]);
        let [x, y, z, w] = parts.abs().simd_lt(f32x4::splat(FLUSH)).bitselect(f32x4::ZERO, parts).to_array();
        Self::new(x, y, z, w)
    }

    /// `self` after `first`: `(self * first)` applied to `v` is `self` of `first` of `v`.
    #[inline]
    pub fn after(self, first: Self) -> Self {
        // w (x, y, z, w) + x (w, -z, y, -x) + y (z, w, -x, -y) + z (-y, x, w, -z): four sums side by side.
        let (a, b) = (self, first);
        let signs = |signs: [f32; 4]| f32x4::new(signs.map(|sign| if sign < 0.0 { -0.0 } else { 0.0 }));
        let (a_x, a_y, a_z, a_w) =
            (f32x4::splat(a.x), f32x4::splat(a.y), f32x4::splat(a.z), f32x4::splat(a.w));
        let by_x = f32x4::new([b.w, b.z, b.y, b.x]) ^ signs([1.0, -1.0, 1.0, -1.0]);
        let by_y = f32x4::new([b.z, b.w, b.x, b.y]) ^ signs([1.0, 1.0, -1.0, -1.0]);
        let by_z = f32x4::new([b.y, b.x, b.w, b.z]) ^ signs([-1.0, 1.0, 1.0, -1.0]);
        let sum = a_w * f32x4::new([b.x, b.y, b.z, b.w]) + a_x * by_x + a_y * by_y + a_z * by_z;
        let [x, y, z, w] = sum.to_array();
        Self::new(x, y, z, w)
    }

    /// The vector `v` rotated.
    #[inline]
    pub fn rotate(self, v: Vec3) -> Vec3 {
        let u = self.imaginary();
        let t = u.cross(v) * 2.0;
        v + t * self.w + u.cross(t)
    }

    /// The vector `v` rotated backwards.
    #[inline]
    pub fn unrotate(self, v: Vec3) -> Vec3 {
        self.inverse().rotate(v)
    }

    /// Half extents of the smallest box around a rotated box with half extents `half`.
    #[inline]
    pub(crate) fn extents(self, half: Vec3) -> Vec3 {
        let m = self.matrix();
        m.x_axis.abs() * half.x + m.y_axis.abs() * half.y + m.z_axis.abs() * half.z
    }

    /// Columns are the rotated axes.
    #[inline]
    pub fn matrix(self) -> Mat3 {
        // Products side by side by hand: a compiler that puts sums beside them multiplies what nobody reads, and
        // that is denormal for bodies that hardly turned.
        let twice = f32x4::new([self.x + self.x, self.y + self.y, self.z + self.z, 0.0]);
        let times = |factor: f32| (twice * f32x4::splat(factor)).to_array();
        let [xx, xy, xz, _] = times(self.x);
        let [_, yy, yz, _] = times(self.y);
        let [_, _, zz, _] = times(self.z);
        let [wx, wy, wz, _] = times(self.w);
        Mat3::from_cols(
            Vec3::new(1.0 - (yy + zz), xy + wz, xz - wy),
            Vec3::new(xy - wz, 1.0 - (xx + zz), yz + wx),
            Vec3::new(xz + wy, yz - wx, 1.0 - (xx + yy)),
        )
    }
}

/// A rotation and then a translation: where one frame stands in another.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Pose {
    /// Where the frame's origin is, metres.
    pub position: Vec3,
    /// How the frame is turned.
    pub rotation: Rotation,
}

impl Pose {
    /// Same frame.
    pub const IDENTITY: Self = Self { position: Vec3::ZERO, rotation: Rotation::IDENTITY };

    /// A frame moved by `position` and turned by `rotation`.
    pub const fn new(position: Vec3, rotation: Rotation) -> Self {
        Self { position, rotation }
    }

    /// A point of this frame in the outer frame.
    #[inline]
    pub fn transform(&self, point: Vec3) -> Vec3 {
        self.rotation.rotate(point) + self.position
    }

    /// A point of the outer frame in this frame.
    #[inline]
    pub fn untransform(&self, point: Vec3) -> Vec3 {
        self.rotation.unrotate(point - self.position)
    }

    /// The pose of a frame that stands at `inner` in this frame.
    #[inline]
    pub fn after(&self, inner: &Pose) -> Pose {
        Pose::new(self.transform(inner.position), self.rotation.after(inner.rotation))
    }

    /// Where the outer frame stands in this one.
    #[inline]
    pub fn inverse(&self) -> Pose {
        let rotation = self.rotation.inverse();
        Pose::new(-rotation.rotate(self.position), rotation)
    }

    /// True when all numbers are finite.
    pub fn is_finite(&self) -> bool {
        self.position.is_finite() && self.rotation.is_finite()
    }
}

/// An axis-aligned box, metres. Empty when a minimum exceeds its maximum.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Aabb {
    /// Least corner.
    pub min: Vec3,
    /// Greatest corner.
    pub max: Vec3,
}

impl Aabb {
    /// The box that holds nothing: neutral in [`Aabb::union`].
    pub const EMPTY: Self = Self { min: Vec3::splat(f32::INFINITY), max: Vec3::splat(f32::NEG_INFINITY) };

    /// The box of a center and half extents.
    pub fn around(center: Vec3, half: Vec3) -> Self {
        Self { min: center - half, max: center + half }
    }

    /// The smallest box around both.
    #[inline]
    pub fn union(&self, other: &Self) -> Self {
        Self { min: min_each(self.min, other.min), max: max_each(self.max, other.max) }
    }

    /// Grown by `margin` on every side.
    #[inline]
    pub fn grown(&self, margin: f32) -> Self {
        Self { min: self.min - Vec3::splat(margin), max: self.max + Vec3::splat(margin) }
    }

    /// True when the boxes share a point, faces included.
    #[inline]
    pub fn overlaps(&self, other: &Self) -> bool {
        self.min.x <= other.max.x
            && other.min.x <= self.max.x
            && self.min.y <= other.max.y
            && other.min.y <= self.max.y
            && self.min.z <= other.max.z
            && other.min.z <= self.max.z
    }

    /// True when `other` lies inside, faces included.
    #[inline]
    pub fn contains(&self, other: &Self) -> bool {
        self.min.x <= other.min.x
            && self.min.y <= other.min.y
            && self.min.z <= other.min.z
            && other.max.x <= self.max.x
            && other.max.y <= self.max.y
            && other.max.z <= self.max.z
    }

    /// Middle of the box.
    pub fn center(&self) -> Vec3 {
        (self.min + self.max) * 0.5
    }

    /// Half of each edge.
    pub fn half_extents(&self) -> Vec3 {
        (self.max - self.min) * 0.5
    }

    /// The smallest box around this one after it was moved by `pose`.
    pub fn transformed(&self, pose: &Pose) -> Self {
        Self::around(pose.transform(self.center()), pose.rotation.extents(self.half_extents()))
    }
}
