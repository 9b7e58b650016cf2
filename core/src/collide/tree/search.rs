//! Searches of a tree that grow narrower as they find: rays, shape casts, closest points.

use super::{LEVELS_MAX, Tree, WIDTH, levels};
use crate::collide::cast::frame::narrowed;
use crate::math::{Aabb, Vec3, max, max_each, min};
use glam::DVec3;

/// Boxes that wait: on each level but the last three of the four children.
const WAITING_MAX: usize = (WIDTH - 1) * LEVELS_MAX + 1;
/// By how much boxes are taken for larger, as a fraction of the greatest coordinate of a search: several times the
/// rounding of its f32 arithmetic.
const PAD: f32 = 1.0e-6;
/// The same for the place of a box along a way, as a fraction of the way.
const PAD_ALONG: f64 = 1.0e-6;

/// A box to be looked at.
#[derive(Clone, Copy, Debug)]
struct Waiting {
    level: u32,
    index: u32,
    bound: f32,
}

impl Tree<'_> {
    /// Visits the leaves that may matter, nearer ones first as far as the tree tells.
    ///
    /// `bound` gives the least value that anything inside a box can have, infinity when it does not matter at
    /// all; it must not be greater for a larger box. `visit` takes the id of a leaf and returns the greatest
    /// value that matters from now on, as `limit` is in the beginning; boxes with a greater bound are left out.
    pub(crate) fn search(&self, limit: f32, bound: impl Fn(&Aabb) -> f32, mut visit: impl FnMut(u32) -> f32) {
        if self.order.is_empty() {
            return;
        }
        let (first, count, top) = levels(self.order.len());
        let mut limit = limit;
        let mut waiting: heapless::Vec<Waiting, WAITING_MAX> = heapless::Vec::new();
        let _ = waiting.push(Waiting { level: top as u32, index: 0, bound: bound(&self.nodes[first[top]]) });
        while let Some(next) = waiting.pop() {
            if next.bound > limit || next.bound == f32::INFINITY {
                continue;
            }
            if next.level == 0 {
                limit = visit(self.order[next.index as usize]);
                continue;
            }
            let level = next.level as usize - 1;
            let start = next.index as usize * WIDTH;
            let end = (start + WIDTH).min(count[level]);
            let base = waiting.len();
            for index in start..end {
                let bound = bound(&self.nodes[first[level] + index]);
                if bound <= limit && bound < f32::INFINITY {
                    // The nearest last, so that it is taken first.
                    let farther = waiting[base..].iter().take_while(|other| other.bound > bound).count();
                    let place = Waiting { level: level as u32, index: index as u32, bound };
                    let _ = waiting.insert(base + farther, place);
                }
            }
        }
    }
}

/// The way of a point or a box through a tree, in the tree's coordinates, clipped to the tree's bounds.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Way {
    /// Where the clipped way starts and how long it is, metres.
    start: f64,
    span: f64,
    /// Which of a box's six numbers (least, then greatest coordinates) are met first, and which last.
    near: [usize; 3],
    far: [usize; 3],
    /// Where the clipped way starts, less what boxes grow by on those sides.
    before: Vec3,
    after: Vec3,
    /// One over the clipped way.
    inverse: Vec3,
}

/// Stands for one over the way along an axis along which nothing moves: what is ahead is never met, what is around
/// was always met.
const AT_REST: f32 = 1.0e30;

impl Way {
    /// The way of a box that reaches from `low` to `high` about a point that goes from `origin` along the unit
    /// vector `direction` for `length` metres; `None` when it misses the tree.
    pub fn new(
        tree: &Tree<'_>,
        (origin, direction, length): (DVec3, DVec3, f64),
        (low, high): (DVec3, DVec3),
    ) -> Option<Self> {
        let bounds = tree.bounds();
        let (mut enter, mut exit) = (0.0, length);
        for axis in 0..3 {
            // Slack for the rounding of the tree's own coordinates.
            let slack = 1.0e-6 * (origin[axis].abs() + high[axis] - low[axis]) + 1.0e-9 * length;
            let near = f64::from(bounds.min[axis]) - high[axis] - slack - origin[axis];
            let far = f64::from(bounds.max[axis]) - low[axis] + slack - origin[axis];
            if direction[axis] == 0.0 {
                if near > 0.0 || far < 0.0 {
                    return None;
                }
                continue;
            }
            let (a, b) = (near / direction[axis], far / direction[axis]);
            let (first, last) = if a < b { (a, b) } else { (b, a) };
            enter = if first > enter { first } else { enter };
            exit = if last < exit { last } else { exit };
        }
        if enter > exit {
            return None;
        }
        let (start, span) = (enter, exit - enter);
        let from = narrowed(origin + direction * start);
        let way = narrowed(direction * span);
        Some(Self::clipped((start, span), (from, way), (narrowed(low), narrowed(high))))
    }

    fn clipped((start, span): (f64, f64), (origin, way): (Vec3, Vec3), (low, high): (Vec3, Vec3)) -> Self {
        let reach = max_each(origin.abs(), (origin + way).abs()) + max_each(low.abs(), high.abs());
        let pad = PAD * max(reach.x, max(reach.y, max(reach.z, 1.0e-30)));
        // What moves less than the pad does not move.
        let invert = |x: f32| if x.abs() > 0.5 * pad { 1.0 / x } else { AT_REST };
        let inverse = Vec3::new(invert(way.x), invert(way.y), invert(way.z));
        let (least, greatest) = (origin + high + Vec3::splat(pad), origin + low - Vec3::splat(pad));
        let mut this =
            Self { start, span, near: [0, 1, 2], far: [3, 4, 5], before: least, after: greatest, inverse };
        for axis in 0..3 {
            if inverse[axis] < 0.0 {
                (this.near[axis], this.far[axis]) = (axis + 3, axis);
                (this.before[axis], this.after[axis]) = (greatest[axis], least[axis]);
            }
        }
        this
    }

    /// The least distance along the way at which a box can be met, as a fraction of the clipped way; infinity when
    /// it is not met.
    #[inline]
    pub fn bound(&self, bounds: &Aabb) -> f32 {
        let sides: &[f32; 6] = bytemuck::cast_ref(bounds);
        let (mut enter, mut exit) = (0.0, 1.0);
        for axis in 0..3 {
            let first = (sides[self.near[axis]] - self.before[axis]) * self.inverse[axis];
            let last = (sides[self.far[axis]] - self.after[axis]) * self.inverse[axis];
            enter = max(first, enter);
            exit = min(last, exit);
        }
        if enter <= exit { enter } else { f32::INFINITY }
    }

    /// The greatest bound that matters when distances up to `limit` metres do.
    pub fn limit(&self, limit: f64) -> f32 {
        let along = limit * (1.0 + PAD_ALONG) - self.start + PAD_ALONG * self.span;
        if along < self.span { (along / self.span) as f32 } else { 2.0 }
    }
}

/// What lies near a box, in the tree's coordinates.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Near {
    region: Aabb,
    /// What distances are taken for smaller by, metres.
    pad: f32,
}

impl Near {
    /// The surroundings of the box from `low` to `high`.
    pub fn new((low, high): (DVec3, DVec3)) -> Self {
        let (low, high) = (narrowed(low), narrowed(high));
        let reach = max_each(low.abs(), high.abs());
        Self { region: Aabb { min: low, max: high }, pad: 4.0 * PAD * max(reach.x, max(reach.y, reach.z)) }
    }

    /// The least distance from the box, metres.
    #[inline]
    pub fn bound(&self, bounds: &Aabb) -> f32 {
        let gap = max_each(bounds.min - self.region.max, self.region.min - bounds.max);
        let gap = max_each(gap, Vec3::ZERO);
        // A sum of squares may be infinite: then the box is far.
        let distance = min(crate::math::length(gap), f32::MAX);
        max(distance * (1.0 - 4.0 * PAD) - self.pad, 0.0)
    }

    /// The greatest bound that matters when distances up to `limit` metres do.
    pub fn limit(limit: f64) -> f32 {
        (limit * (1.0 + PAD_ALONG)) as f32
    }
}
