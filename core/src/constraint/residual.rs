//! How far rows are from the condition that their impulses are to fulfil (SEED S8):
//!
//! ```text
//! w > 0: lambda = min      w < 0: lambda = max      w = 0 between      w = J u + bias + soft lambda
//! ```
//! It is measured by the *natural map*, as a velocity:
//! ```text
//! r = |lambda - clamp(lambda - m w)| / m        m: the step that the sweep takes, about 1 / (J M^-1 Jt + soft)
//! ```
//! which is 0 exactly where the condition holds: `|w|` for a row that is free to change, and no more than what the
//! bound leaves to change where one is near. The two tangents of a contact are one row whose bounds are a disc,
//! with the load of now. `m` only weighs how far a bound is: it does not change where r is 0.
//!
//! Rows of turning count at the radius of gyration k of what they turn, `k^2 = (1/ma + 1/mb) / (J M^-1 Jt)`, as for
//! sleep: so all rows are metres per second, and one bound serves all.
//!
//! Only maxima are taken, which no order changes. What is not finite is left out: such a body is stopped for good.

use crate::lanes::{LANES, Lane};
use crate::report::Residual;

/// Greatest residuals so far, lane by lane, m/s.
#[derive(Clone, Copy)]
pub(crate) struct Greatest {
    pub normal: Lane,
    pub friction: Lane,
    pub joint: Lane,
}

impl Greatest {
    pub const NONE: Self = Self { normal: Lane::ZERO, friction: Lane::ZERO, joint: Lane::ZERO };

    /// Over all lanes.
    pub fn all(&self) -> Residual {
        (0..LANES).fold(Residual::default(), |all, lane| {
            all.with(&Residual {
                normal: self.normal.get(lane),
                friction: self.friction.get(lane),
                joint: self.joint.get(lane),
            })
        })
    }
}

/// Raises a maximum to the size of `x`, where that is finite.
#[inline(always)]
pub(super) fn note(greatest: &mut Lane, x: Lane) {
    *greatest = size(x).finite().greatest(*greatest);
}

/// |x|.
#[inline(always)]
pub(super) fn size(x: Lane) -> Lane {
    x.greatest(-x)
}

/// `x / y`, or 0 where y is not above 0.
#[inline(always)]
pub(super) fn share(x: Lane, y: Lane) -> Lane {
    let stands = y.greater(Lane::splat(f32::MIN_POSITIVE));
    stands.keep(x / stands.select(y, Lane::splat(1.0)))
}

/// Residual of a row with `-limit <= lambda <= limit` whose step is `mass`; the limit may have moved since.
#[inline(always)]
pub(super) fn between((lambda, w, mass): (Lane, Lane, Lane), limit: Lane) -> Lane {
    let inside = size(lambda - mass * w).less(limit);
    let after = (lambda - mass * w).least(limit).greatest(-limit);
    mass.greater(Lane::splat(f32::MIN_POSITIVE)).keep(inside.select(w, share(lambda - after, mass)))
}
