//! The direction in which two overlapping cores are pushed apart by the least way.
//!
//! Along a unit vector `n` the cores are `s(n) = min_b n . x - max_a n . x` apart, which is negative while they
//! overlap; the least depth is the maximum of `s`. Directions that shapes often touch along are tried first: faces,
//! axes, from middle to middle, and the one between the cores made smaller. The best is then refined:
//!
//! ```text
//! push B along n until the cores are just apart; the direction of their closest points is n'
//! ```
//! A maximum is a fixed point, reached at once where it is a face's, and else by a factor of depth over radius of
//! curvature each time. Every step must raise `s`, so the result is never worse than the best direction tried.

use super::closest::{Near, Pair};
use super::{Core, SupportShape, length};
use crate::collide::double::DVec3;

/// Refinements: for depths of a tenth of the radius, 1e-6 rad.
const REFINEMENTS: usize = 8;
/// How far apart the cores are pushed, as a fraction of the lesser size.
const MARGIN: f64 = 1.0e-3;
/// A direction must beat another by this fraction of the lesser size: noise shall not choose.
const BETTER: f64 = 1.0e-7;
/// Factors by which cores are made smaller.
const SCALES: [f64; 3] = [0.9, 0.5, 0.1];

/// The best direction so far.
struct Search<'a, 'b> {
    pair: &'b Pair<'a>,
    normal: DVec3,
    apart: f64,
    better: f64,
}

/// The least depth of two overlapping cores.
pub(super) fn least(pair: &Pair<'_>) -> Near {
    let better = BETTER * pair.lesser_size();
    let mut search = Search { pair, normal: DVec3::Z, apart: pair.apart_along(DVec3::Z), better };
    search.try_shape(pair.a, pair.b, 1.0);
    search.try_shape(pair.b, pair.a, -1.0);
    search.try_direction(pair.b.center() - pair.a.center());
    if let (Some(a), Some(b)) = (axis_of(pair.a), axis_of(pair.b)) {
        search.try_both(a.cross(b));
    }
    for scale in SCALES {
        let smaller = Pair { scale, ..*pair };
        if let Some(near) = smaller.closest(f64::INFINITY)
            && near.is_apart
        {
            search.try_direction(near.normal);
            break;
        }
    }
    search.refined()
}

/// The axis of a shape that has one.
fn axis_of(shape: &SupportShape<'_>) -> Option<DVec3> {
    match shape.core {
        Core::Segment { .. } | Core::Cylinder { .. } | Core::Cone { .. } => Some(shape.axes[2]),
        Core::Point | Core::Hull(_) => None,
    }
}

impl Search<'_, '_> {
    /// Tries a direction of any length.
    fn try_direction(&mut self, direction: DVec3) -> bool {
        let size = length(direction);
        // Written so that a direction that is not a number is left out.
        if !(size > 1.0e-30) {
            return false;
        }
        self.try_unit(direction / size)
    }

    fn try_unit(&mut self, n: DVec3) -> bool {
        let apart = self.pair.apart_along(n);
        let is_better = apart > self.apart + self.better;
        if is_better {
            (self.normal, self.apart) = (n, apart);
        }
        is_better
    }

    fn try_both(&mut self, direction: DVec3) {
        self.try_direction(direction);
        self.try_direction(-direction);
    }

    /// Tries the directions of a shape's own surface; `outward` is 1 for A and -1 for B.
    fn try_shape(&mut self, shape: &SupportShape<'_>, other: &SupportShape<'_>, outward: f64) {
        match &shape.core {
            Core::Hull(hull) => {
                for plane in hull.planes {
                    self.try_unit(shape.turned(DVec3::from(plane.normal)) * outward);
                }
            }
            Core::Cylinder { .. } | Core::Cone { .. } | Core::Segment { .. } => {
                let axis = shape.axes[2];
                self.try_unit(axis);
                self.try_unit(-axis);
                let to_other = other.center() - shape.center();
                let across = to_other - axis * axis.dot(to_other);
                self.try_direction(across * outward);
                if let Core::Cone { half_height, radius } = shape.core {
                    // The side's normal in the plane of the axis and the other's middle.
                    let size = length(across);
                    if size > 0.0 {
                        let side = across * (2.0 * half_height / size) + axis * radius;
                        self.try_direction(side * outward);
                    }
                }
            }
            Core::Point => {}
        }
    }

    fn refined(mut self) -> Near {
        let mut witness = None;
        let margin = MARGIN * self.pair.lesser_size();
        for _ in 0..REFINEMENTS {
            let shift = self.normal * (margin - self.apart);
            let pushed = Pair { shift, ..*self.pair };
            let Some(near) = pushed.closest(f64::INFINITY).filter(|near| near.is_apart) else { break };
            witness = Some((near.on_a, near.on_b - shift));
            if !self.try_unit(near.normal) {
                break;
            }
        }
        let n = self.normal;
        let (on_a, on_b) = witness.unwrap_or_else(|| (self.pair.a.support(n), self.pair.b.support(-n)));
        Near { on_a, on_b, normal: n, apart: self.apart, is_apart: false }
    }
}
