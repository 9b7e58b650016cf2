//! How the arms of a contact follow the slide of its bodies within a step.

use crate::constraint::row::{LinkRow, PointRow};
use crate::constraint::velocities::root_times;
use crate::lanes::{Lane, LaneVec, Mask};

/// How B's jacobians change because the point of contact went with A: `r = r0 - slide`, so
/// `W (r x d) = W (r0 x d) + W (d x slide)` for a direction d.
pub(super) struct Shift {
    pub(super) normal: LaneVec,
    pub(super) first: LaneVec,
    pub(super) second: LaneVec,
    /// Lanes that slid far enough to matter.
    pub(super) slides: Mask,
    pub(super) any: bool,
}

/// Square of how many times the least slide that matters a slide may be: twice the arms.
const SLIDE_MAX: f32 = 4.0e6;

/// A slide that is no longer than twice the bodies' arms: what flies on past the other one at thousands
/// of metres per second has no point of contact with it there, and a lever of its whole way would throw both.
#[inline(always)]
pub(super) fn limited(slide: LaneVec, slide_min: Lane) -> LaneVec {
    let (square, most) = (slide.dot(slide), slide_min * Lane::splat(SLIDE_MAX));
    let far = square.greater(most);
    if !far.any() {
        return slide;
    }
    let one = Lane::splat(1.0);
    slide.times(far.select((most / far.select(square, one)).sqrt(), one))
}

impl Shift {
    /// None.
    pub(super) const NONE: Self = Self {
        normal: LaneVec::ZERO,
        first: LaneVec::ZERO,
        second: LaneVec::ZERO,
        slides: Mask::NONE,
        any: false,
    };

    #[inline(always)]
    pub(super) fn of(row: &LinkRow) -> Self {
        let slides = row.slide.dot(row.slide).greater(row.slide_min);
        let mut shift = Self {
            normal: LaneVec::ZERO,
            first: LaneVec::ZERO,
            second: LaneVec::ZERO,
            slides,
            any: slides.any(),
        };
        if shift.any {
            let turn = |direction: LaneVec| root_times(&row.root_b, direction.cross(row.slide));
            shift.normal = turn(row.normal);
            shift.first = turn(row.tangent);
            shift.second = turn(row.normal.cross(row.tangent));
        }
        shift
    }

    /// A lane's result depends on that lane alone: `any` only saves work.
    #[inline(always)]
    pub(super) fn apply(&self, jacobian: LaneVec, change: LaneVec) -> LaneVec {
        if self.any { jacobian + self.slides.keep_vec(change) } else { jacobian }
    }

    /// What the mass of a point is divided by for the jacobian `jb`. A longer arm yields more: with the mass of the
    /// shorter one a sweep would overshoot, and bodies that slide along each other for longer than their arms would
    /// explode.
    #[inline(always)]
    pub(super) fn mass(&self, (point, mass): (&PointRow, Lane), jb: LaneVec) -> Lane {
        if !self.any {
            return mass;
        }
        let more = jb.dot(jb) - point.normal_b.dot(point.normal_b);
        // Never 0: where the bodies hardly move but by turning, the rest is rounding.
        let sum = (Lane::splat(1.0) + mass * more).greatest(Lane::splat(1.0e-3));
        self.slides.select(mass / sum, mass)
    }

    /// The same for both tangents, by the trace of what their 2x2 block gains.
    #[inline(always)]
    pub(super) fn friction_mass(&self, row: &LinkRow, (first_b, second_b): (LaneVec, LaneVec)) -> Lane {
        if !self.any {
            return row.friction_mass;
        }
        let now = first_b.dot(first_b) + second_b.dot(second_b);
        let before = row.first_b.dot(row.first_b) + row.second_b.dot(row.second_b);
        let more = (now - before).greatest(Lane::ZERO);
        let sum = Lane::splat(1.0) + row.friction_mass * more;
        self.slides.select(row.friction_mass / sum, row.friction_mass)
    }
}
