//! What queries need of a compound's tree.

use crate::collide::compound::Compound;
use glam::DVec3;

/// Boxes of children are rounded by less than this fraction of the tree's greatest coordinate.
const SLACK: f64 = 1.0e-6;

/// A box (least and greatest coordinates) that grows by the rounding of the children's boxes.
pub(super) fn grown(compound: &Compound<'_>, (low, high): (DVec3, DVec3)) -> (DVec3, DVec3) {
    let bounds = compound.tree.bounds();
    let reach = crate::math::max_each(bounds.min.abs(), bounds.max.abs()).max_element();
    let slack = DVec3::splat(SLACK * f64::from(reach));
    (low - slack, high + slack)
}
