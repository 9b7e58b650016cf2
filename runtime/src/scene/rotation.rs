//! Rotations of the document as unit quaternions, through the engine's own trigonometry: the same bits
//! everywhere.

use super::format::RotationDoc;
use cellstep_core::math::{PI, Rotation, Vec3, length};

/// The unit quaternion that is meant; `None` when a number is not finite or there is no direction.
pub(super) fn rotation(doc: &RotationDoc) -> Option<Rotation> {
    match *doc {
        RotationDoc::Quaternion([x, y, z, w]) => {
            let q = Rotation::new(x, y, z, w);
            let norm = q.norm_squared();
            // Squares of numbers within these bounds neither vanish nor overflow.
            (norm > 1.0e-12 && norm < 1.0e12).then(|| q.normalized())
        }
        RotationDoc::AxisAngle { axis, degrees } => {
            let axis = Vec3::from(axis);
            let norm = length(axis);
            let sound = norm > 1.0e-6 && norm < 1.0e6 && degrees.is_finite();
            sound.then(|| Rotation::from_axis_angle(axis / norm, radians(degrees)).normalized())
        }
        RotationDoc::EulerDegrees(angles) => {
            if !angles.iter().all(|angle| angle.is_finite()) {
                return None;
            }
            let about = |axis, angle| Rotation::from_axis_angle(axis, radians(angle));
            let [x, y, z] = angles;
            Some(about(Vec3::Z, z).after(about(Vec3::Y, y)).after(about(Vec3::X, x)).normalized())
        }
    }
}

/// Whole turns are taken off first, exactly: the sine of a large angle would lose them in its rounding.
fn radians(degrees: f32) -> f32 {
    (degrees % 360.0) * (PI / 180.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(a: Vec3, b: Vec3) -> bool {
        length(a - b) < 1.0e-6
    }

    #[test]
    fn spellings_agree() {
        let quarter = RotationDoc::AxisAngle { axis: [0.0, 0.0, 2.0], degrees: 90.0 };
        let q = rotation(&quarter).unwrap();
        assert!(close(q.rotate(Vec3::X), Vec3::Y));
        let e = rotation(&RotationDoc::EulerDegrees([0.0, 0.0, 450.0])).unwrap();
        assert!(close(e.rotate(Vec3::X), Vec3::Y));
        let s = rotation(&RotationDoc::Quaternion([0.0, 0.0, 3.0, 3.0])).unwrap();
        assert!(close(s.rotate(Vec3::X), Vec3::Y));
    }

    #[test]
    fn euler_turns_about_fixed_axes_x_first() {
        let q = rotation(&RotationDoc::EulerDegrees([90.0, 90.0, 0.0])).unwrap();
        // y goes to z by the turn about x, and z to x by the turn about y.
        assert!(close(q.rotate(Vec3::Y), Vec3::X));
    }

    #[test]
    fn refuses_what_has_no_direction() {
        let bad = [
            RotationDoc::Quaternion([0.0; 4]),
            RotationDoc::Quaternion([0.0, f32::NAN, 0.0, 1.0]),
            RotationDoc::Quaternion([f32::INFINITY, 0.0, 0.0, 1.0]),
            RotationDoc::AxisAngle { axis: [0.0; 3], degrees: 10.0 },
            RotationDoc::AxisAngle { axis: [1.0, 0.0, 0.0], degrees: f32::INFINITY },
            RotationDoc::EulerDegrees([0.0, f32::NAN, 0.0]),
        ];
        assert!(bad.iter().all(|doc| rotation(doc).is_none()));
    }
}
