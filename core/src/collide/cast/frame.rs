//! Where one frame stands in another, in double precision.
//!
//! A query looks at small shapes from far away: at 1 km an f32 resolves 0.06 mm, in position and in direction.
//! Double precision keeps what the state holds, so that queries need no care for distance. Its `+ - * /` and
//! square roots are as fixed by IEEE 754 as those of f32.

use crate::math::{Pose, Rotation, Vec3};
use glam::DVec3;

/// A rotation and a place.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Frame {
    /// Where the frame's origin is, metres.
    pub position: DVec3,
    /// Where its axes point, unit vectors.
    axes: [DVec3; 3],
}

/// Exact.
pub(crate) fn widened(v: Vec3) -> DVec3 {
    DVec3::new(f64::from(v.x), f64::from(v.y), f64::from(v.z))
}

/// Rounded.
pub(crate) fn narrowed(v: DVec3) -> Vec3 {
    Vec3::new(v.x as f32, v.y as f32, v.z as f32)
}

/// Length of a vector.
pub(crate) fn length(v: DVec3) -> f64 {
    libm::sqrt(v.dot(v))
}

impl Frame {
    /// Same frame.
    pub const IDENTITY: Self = Self { position: DVec3::ZERO, axes: [DVec3::X, DVec3::Y, DVec3::Z] };

    /// A frame at a place, turned by a quaternion whose length is taken out.
    pub fn new(position: DVec3, rotation: Rotation) -> Self {
        let [x, y, z, w] = [rotation.x, rotation.y, rotation.z, rotation.w].map(f64::from);
        let s = 2.0 / (x * x + y * y + z * z + w * w);
        let (xx, yy, zz) = (x * x * s, y * y * s, z * z * s);
        let (xy, xz, yz) = (x * y * s, x * z * s, y * z * s);
        let (wx, wy, wz) = (w * x * s, w * y * s, w * z * s);
        let axes = [
            DVec3::new(1.0 - (yy + zz), xy + wz, xz - wy),
            DVec3::new(xy - wz, 1.0 - (xx + zz), yz + wx),
            DVec3::new(xz + wy, yz - wx, 1.0 - (xx + yy)),
        ];
        Self { position, axes }
    }

    /// The frame of a pose.
    pub fn of(pose: &Pose) -> Self {
        Self::new(widened(pose.position), pose.rotation)
    }

    /// The same axes at another place.
    pub fn at(&self, position: DVec3) -> Self {
        Self { position, axes: self.axes }
    }

    /// This frame turned about its origin by an angle, radians, about a unit axis of the outer frame.
    pub fn turned(&self, axis: DVec3, angle: f64) -> Self {
        let (sine, cosine) = (libm::sin(angle), libm::cos(angle));
        let turn = |v: DVec3| v * cosine + axis.cross(v) * sine + axis * (axis.dot(v) * (1.0 - cosine));
        Self { position: self.position, axes: self.axes.map(turn) }
    }

    /// A vector of this frame in the outer frame.
    #[inline]
    pub fn turn(&self, v: DVec3) -> DVec3 {
        self.axes[0] * v.x + self.axes[1] * v.y + self.axes[2] * v.z
    }

    /// A vector of the outer frame in this frame.
    #[inline]
    pub fn unturn(&self, v: DVec3) -> DVec3 {
        DVec3::new(self.axes[0].dot(v), self.axes[1].dot(v), self.axes[2].dot(v))
    }

    /// A point of this frame in the outer frame.
    #[inline]
    pub fn transform(&self, point: DVec3) -> DVec3 {
        self.turn(point) + self.position
    }

    /// A point of the outer frame in this frame.
    #[inline]
    pub fn untransform(&self, point: DVec3) -> DVec3 {
        self.unturn(point - self.position)
    }

    /// Where a frame that stands so in this one stands in the outer frame.
    pub fn after(&self, inner: &Self) -> Self {
        Self { position: self.transform(inner.position), axes: inner.axes.map(|axis| self.turn(axis)) }
    }

    /// Where `other` stands in this frame, both given in the same outer frame.
    pub fn relative(&self, other: &Self) -> Self {
        Self { position: self.untransform(other.position), axes: other.axes.map(|axis| self.unturn(axis)) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_agree_with_rotations() {
        let rotation = Rotation::from_rotation_vector(Vec3::new(0.7, -1.9, 0.4));
        let frame = Frame::new(DVec3::new(1.0, 2.0, 3.0), rotation);
        let v = Vec3::new(0.3, -0.6, 1.1);
        let found = frame.transform(widened(v));
        let expected = widened(rotation.rotate(v) + Vec3::new(1.0, 2.0, 3.0));
        assert!(length(found - expected) < 1.0e-6, "{found} {expected}");
        assert!(length(frame.untransform(found) - widened(v)) < 1.0e-15);
        let other = Frame::new(DVec3::new(-4.0, 0.5, 9.0), Rotation::from_axis_angle(Vec3::X, 0.9));
        let inner = frame.relative(&other);
        let point = DVec3::new(0.2, 0.1, -0.7);
        let straight = frame.untransform(other.transform(point));
        assert!(length(inner.transform(point) - straight) < 1.0e-14);
    }
}
