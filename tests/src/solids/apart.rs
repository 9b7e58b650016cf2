//! How far two convex sets are apart, or how deep they overlap, by convex minimisation of their distances.

use super::Solid;
use crate::oracles::{Wide, cross, dot, minus, norm, plus};

/// Steps of the search for a direction that parts two sets.
const PARTING: usize = 40;
/// Steps of the ellipsoid method: each takes about an eighth off the logarithm of the volume.
const ELLIPSOIDS: usize = 600;
/// Precision, metres.
const PRECISE: f64 = 1.0e-8;

impl Solid {
    /// How near a set is to another: about their distance when they are apart, never more than it; negative when
    /// they overlap, about as deep as they do (but a triangle by how deep it is in the other).
    pub fn separation(&self, other: &Self) -> f64 {
        match (self, other) {
            (Solid::Ball(center, radius), _) => other.distance(*center) - radius,
            (Solid::Capsule([p, q], radius), _) => other.distance_of_segment(*p, *q) - radius,
            (_, Solid::Ball(..) | Solid::Capsule(..)) => other.separation(self),
            _ if self.is_flat() && other.is_flat() => self.gap(other),
            // The normal of a half-space tells all.
            (Solid::HalfSpace(..), _) | (_, Solid::HalfSpace(..)) => self.gap(other),
            _ => match self.parted(other) {
                Some(gap) => gap,
                None => self.overlap(other),
            },
        }
    }

    fn is_flat(&self) -> bool {
        matches!(self, Solid::Polytope(_) | Solid::Triangle(_) | Solid::HalfSpace(..))
    }

    /// Gradient of the distance.
    fn gradient(&self, p: Wide) -> Wide {
        let step = 1.0e-6;
        let along = |i: usize| {
            let mut by = [0.0; 3];
            by[i] = step;
            (self.distance(plus(p, by, 1.0)) - self.distance(plus(p, by, -1.0))) / (2.0 * step)
        };
        [along(0), along(1), along(2)]
    }

    /// A gap that some direction proves; none when the search finds no such direction.
    fn parted(&self, other: &Self) -> Option<f64> {
        let project = |solid: &Self, p: Wide| plus(p, solid.gradient(p), -solid.distance(p).max(0.0));
        let mut p = self.ball().0;
        for _ in 0..PARTING {
            let q = project(other, p);
            p = project(self, q);
            let apart = minus(q, p);
            let length = norm(apart);
            if length < 1.0e-7 {
                return None;
            }
            let n = apart.map(|x| x / length);
            let gap = -other.reach(n.map(|x| -x)) - self.reach(n);
            if gap > 0.0 {
                return Some(gap);
            }
        }
        None
    }

    /// Depth by search.
    fn overlap(&self, other: &Self) -> f64 {
        match (self, other) {
            (Solid::Triangle(corners), solid) | (solid, Solid::Triangle(corners)) => solid.least_on(corners),
            _ => {
                2.0 * least(
                    |p| {
                        let [a, b] = [self.distance(p), other.distance(p)];
                        if a > b { (a, self.gradient(p)) } else { (b, other.gradient(p)) }
                    },
                    if self.ball().1 < other.ball().1 { self.ball() } else { other.ball() },
                )
            }
        }
    }

    /// The least distance of a point of a triangle, negative inside.
    fn least_on(&self, [a, b, c]: &[Wide; 3]) -> f64 {
        assert!(norm(cross(minus(*b, *a), minus(*c, *a))) > 0.0);
        golden(|u| {
            let (from, to) = (plus(*a, minus(*b, *a), u), plus(*a, minus(*c, *a), u));
            golden(|v| self.distance(plus(from, minus(to, from), v)))
        })
    }
}

/// The least value of a convex function of 0..=1.
fn golden(f: impl Fn(f64) -> f64) -> f64 {
    let ratio = 0.5 * (5.0_f64.sqrt() - 1.0);
    let (mut low, mut high) = (0.0, 1.0);
    let (mut m, mut n) = (1.0 - ratio, ratio);
    let (mut at_m, mut at_n) = (f(m), f(n));
    for _ in 0..40 {
        if at_m < at_n {
            (high, n, at_n) = (n, m, at_m);
            m = high - ratio * (high - low);
            at_m = f(m);
        } else {
            (low, m, at_m) = (m, n, at_n);
            n = low + ratio * (high - low);
            at_n = f(n);
        }
    }
    at_m.min(at_n).min(f(0.0)).min(f(1.0))
}

/// The least value of a convex function of space, given with its gradient, within a ball and near it (the ellipsoid
/// method; Boyd, Barratt, "Linear Controller Design", 1991, section 14.4).
fn least(f: impl Fn(Wide) -> (f64, Wide), (center, radius): (Wide, f64)) -> f64 {
    let mut x = center;
    let size = (2.0 * radius).powi(2);
    let mut p = [[size, 0.0, 0.0], [0.0, size, 0.0], [0.0, 0.0, size]];
    let mut best = f64::INFINITY;
    for _ in 0..ELLIPSOIDS {
        let (value, gradient) = f(x);
        best = best.min(value);
        let across = p.map(|row| dot(row, gradient));
        let width = dot(across, gradient).max(0.0).sqrt();
        if width < PRECISE {
            break;
        }
        let step = across.map(|y| y / width);
        x = plus(x, step, -0.25);
        for i in 0..3 {
            for j in 0..3 {
                p[i][j] = 9.0 / 8.0 * (p[i][j] - 0.5 * step[i] * step[j]);
            }
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::super::Axial;
    use super::*;

    #[test]
    fn separations_of_cylinders_are_known() {
        let of = |x: f64, axis: Wide| {
            Solid::Cylinder(Axial { center: [x, 0.0, 0.0], axis, half: 2.0, radius: 0.5 })
        };
        let (up, along) = ([0.0, 0.0, 1.0], [0.0, 1.0, 0.0]);
        for (x, apart) in [(1.5, 0.5), (1.0001, 0.0001), (0.9, -0.1), (0.6, -0.4)] {
            let found = of(0.0, up).separation(&of(x, along));
            assert!(
                (found - apart).abs() < 1.0e-6 || (apart > 0.0 && found > 0.0 && found <= apart),
                "{x}: {found}"
            );
        }
        let cone = Solid::Cone(Axial { center: [0.0; 3], axis: up, half: 1.0, radius: 1.0 });
        // Over the middle of the side, whose normal is (2, 0, 1).
        let s = 5.0_f64.sqrt();
        for depth in [-0.1, 0.2, 1.0] {
            let at = [0.5 + 2.0 / s * depth, 0.0, 1.0 / s * depth];
            assert!((cone.distance(at) - depth).abs() < 1.0e-12);
        }
        assert!((cone.distance([0.0, 0.0, 1.7]) - 0.7).abs() < 1.0e-12);
        assert!((cone.distance([1.3, 0.0, -1.4]) - 0.5).abs() < 1.0e-12);
    }
}
