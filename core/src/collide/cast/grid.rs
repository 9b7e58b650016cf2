//! Triangles of a height field along a way, and around a box.

use super::frame::{narrowed, widened};
use crate::collide::height_field::HeightField;
use crate::math::Aabb;
use glam::DVec3;

/// Visits the triangles that a box may meet on a way.
pub(super) fn along(
    field: &HeightField<'_>,
    (origin, direction, length): (DVec3, DVec3, f64),
    (low, high): (DVec3, DVec3),
    _limit: f64,
    mut visit: impl FnMut(u32, [DVec3; 3]) -> f64,
) {
    let end = origin + direction * length;
    let each = |a: DVec3, b: DVec3| (a.min(b), a.max(b));
    let (least, most) = each(origin, end);
    let slack = DVec3::splat(1.0e-6) * (origin.abs() + end.abs());
    let region = Aabb { min: narrowed(least + low - slack), max: narrowed(most + high + slack) };
    field.query(&region, |index| {
        visit(index, field.triangle(index).0.map(widened));
    });
}

/// Visits the triangles that may be within `limit` metres of a box.
pub(super) fn around(
    field: &HeightField<'_>,
    (low, high): (DVec3, DVec3),
    limit: f64,
    mut visit: impl FnMut(u32, [DVec3; 3]) -> f64,
) {
    let slack = DVec3::splat(limit) + DVec3::splat(1.0e-6) * (low.abs() + high.abs());
    let region = Aabb { min: narrowed(low - slack), max: narrowed(high + slack) };
    field.query(&region, |index| {
        visit(index, field.triangle(index).0.map(widened));
    });
}
