//! The direction in which two cores that overlap or nearly touch are pushed apart by the least way.
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

use super::closest::{Aim, Near, Pair};
use super::{Core, SupportShape, length};
use glam::DVec3;

/// Refinements: each takes off a factor of depth over radius.
const REFINEMENTS: usize = 8;
/// How far apart the cores are pushed, as a fraction of the lesser size.
const MARGIN: f64 = 1.0e-2;
/// Of cores that are nearer than this fraction of the lesser size the normal is found here too: that of closest
/// points is a difference, which has few digits when they nearly touch.
pub(super) const TOUCHING: f64 = 1.0e-4;
/// A direction must beat another by this fraction of the lesser size: noise shall not choose.
const BETTER: f64 = 1.0e-7;
/// Square of the angle by which a refined normal may be off, before the next refinement.
const REFINED: f64 = 1.0e-9;
/// The same for a direction to start from.
const ROUGH: f64 = 1.0e-3;
/// Factors by which cores are made smaller.
const SCALES: [f64; 3] = [0.9, 0.5, 0.1];

/// Depths up to this fraction of the lesser size have the best direction tried as their start; deeper ones have
/// several ways out, and the best of every group of directions is refined.
const SHALLOW: f64 = 0.1;
/// Groups of directions.
const GROUPS: usize = 4;

/// A direction and how far the cores are apart along it.
#[derive(Clone, Copy, Debug)]
struct Try {
    normal: DVec3,
    apart: f64,
}

/// The best direction of a group so far.
struct Search<'a, 'b> {
    pair: &'b Pair<'a>,
    best: Try,
    better: f64,
}

/// The least depth of two cores that overlap or nearly touch. `is_apart` stays false.
pub(super) fn least(pair: &Pair<'_>) -> Near {
    let better = BETTER * pair.lesser_size();
    let mut groups: heapless::Vec<Try, GROUPS> = heapless::Vec::new();
    for group in 0..GROUPS {
        let none = Try { normal: DVec3::Z, apart: f64::NEG_INFINITY };
        let mut search = Search { pair, best: none, better };
        search.try_group(group);
        if search.best.apart > none.apart {
            let _ = groups.push(search.best);
        }
    }
    let mut first = Try { normal: DVec3::Z, apart: pair.apart_along(DVec3::Z) };
    for group in &groups {
        first = if group.apart > first.apart + better { *group } else { first };
    }
    let mut found = Search { pair, best: first, better }.refined();
    if found.apart < -SHALLOW * pair.lesser_size() {
        for group in &groups {
            let other = Search { pair, best: *group, better }.refined();
            found = if other.apart > found.apart + better { other } else { found };
        }
    }
    found
}

/// The axis of a shape that has one.
fn axis_of(shape: &SupportShape<'_>) -> Option<DVec3> {
    match shape.core {
        Core::Segment { .. } | Core::Cylinder { .. } | Core::Cone { .. } => Some(shape.axes[2]),
        Core::Point | Core::Hull(_) => None,
    }
}

impl Search<'_, '_> {
    fn try_group(&mut self, group: usize) {
        let pair = self.pair;
        match group {
            0 => self.try_shape(pair.a, pair.b, 1.0),
            1 => self.try_shape(pair.b, pair.a, -1.0),
            2 => {
                self.try_direction(pair.b.center() - pair.a.center());
                if let (Some(a), Some(b)) = (axis_of(pair.a), axis_of(pair.b)) {
                    self.try_both(a.cross(b));
                }
            }
            _ => {
                let aim = Aim { limit: f64::INFINITY, touching: 0.0, angle_squared: ROUGH };
                let start = pair.b.center() - pair.a.center();
                let apart = SCALES.iter().find_map(|&scale| {
                    let smaller = Pair { scale, ..*pair };
                    smaller.closest(start, &aim).filter(|near| near.is_apart)
                });
                if let Some(near) = apart {
                    self.try_direction(near.normal);
                }
            }
        }
    }

    /// Tries a direction of any length.
    fn try_direction(&mut self, direction: DVec3) -> bool {
        let size = length(direction);
        size > 1.0e-30 && self.try_unit(direction / size)
    }

    fn try_unit(&mut self, n: DVec3) -> bool {
        let apart = self.pair.apart_along(n);
        let is_better = apart > self.best.apart + self.better;
        if is_better {
            self.best = Try { normal: n, apart };
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
        let aim = Aim { limit: f64::INFINITY, touching: 0.0, angle_squared: REFINED };
        for _ in 0..REFINEMENTS {
            let shift = self.best.normal * (margin - self.best.apart);
            let pushed = Pair { shift, ..*self.pair };
            let near = pushed.closest(self.best.normal, &aim);
            let Some(near) = near.filter(|near| near.is_apart) else { break };
            witness = Some((near.on_a, near.on_b - shift));
            if !self.try_unit(near.normal) {
                break;
            }
        }
        let n = self.best.normal;
        let (on_a, on_b) = witness.unwrap_or_else(|| (self.pair.a.support(n), self.pair.b.support(-n)));
        Near { on_a, on_b, normal: n, apart: self.best.apart, is_apart: false }
    }
}
