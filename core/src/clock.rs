//! From the time that passes to steps, in whole numbers.
//!
//! A game gets time in pieces of any length and a world takes steps of one length. The [`Clock`] counts time in
//! nanoseconds times a rate, so that a 60th of a second is a whole number of units and nothing is ever rounded:
//! after any number of pieces it has given exactly the steps of their sum. The same pieces give the same steps
//! on every machine.

use crate::body::Position;
use crate::error::Error;
use crate::math::{Pose, Rotation, Vec3};

/// Nanoseconds of a second.
const SECOND: u64 = 1_000_000_000;

/// What to do after some time has passed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Due {
    /// Steps to take now.
    pub steps: u32,
    /// Steps that were due beyond the clock's maximum, and will not be taken: the world falls behind.
    pub dropped: u64,
}

/// Counts elapsed time and says how many steps of `numerator / denominator` seconds are due.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Clock {
    /// Seconds of a step as a fraction.
    numerator: u32,
    denominator: u32,
    steps_max: u32,
    /// Time that is not yet a step, nanoseconds times `denominator`: less than a step.
    rest: u64,
    /// Steps given.
    steps: u64,
    /// Steps dropped.
    dropped: u64,
}

impl Clock {
    /// A clock for steps of `numerator / denominator` seconds, such as `(1, 60)`, that never asks for more than
    /// `steps_max` steps at once: when a step takes longer than it simulates, time is dropped instead of steps
    /// piling up.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] unless all three are positive, the numerator at most 10^9 and the step at most a
    /// second.
    pub fn new((numerator, denominator): (u32, u32), steps_max: u32) -> Result<Self, Error> {
        if numerator == 0 || denominator == 0 || u64::from(numerator) > SECOND || numerator > denominator {
            return Err(Error::OutOfRange { name: "step" });
        }
        if steps_max == 0 {
            return Err(Error::OutOfRange { name: "steps_max" });
        }
        Ok(Self { numerator, denominator, steps_max, rest: 0, steps: 0, dropped: 0 })
    }

    /// Length of a step in units of the clock.
    fn step(&self) -> u128 {
        u128::from(self.numerator) * u128::from(SECOND)
    }

    /// Length of a step, seconds, rounded: for [`Settings::dt`](crate::Settings::dt).
    pub fn dt(&self) -> f32 {
        (f64::from(self.numerator) / f64::from(self.denominator)) as f32
    }

    /// Lets time pass, nanoseconds, and says how many steps are due.
    pub fn advance(&mut self, nanoseconds: u64) -> Due {
        let time = u128::from(nanoseconds) * u128::from(self.denominator) + u128::from(self.rest);
        let due = time / self.step();
        // Below a step, which is at most 10^18.
        self.rest = (time % self.step()) as u64;
        let steps = due.min(u128::from(self.steps_max)) as u32;
        // Up to 2^67 steps are due at once: cut where nobody counts any more.
        let dropped = u64::try_from(due - u128::from(steps)).unwrap_or(u64::MAX);
        self.steps = self.steps.saturating_add(u64::from(steps));
        self.dropped = self.dropped.saturating_add(dropped);
        Due { steps, dropped }
    }

    /// How far the time has come from the last step to the next, 0..1: where to show bodies between the poses
    /// of two steps, see [`interpolated`].
    pub fn fraction(&self) -> f32 {
        let fraction = (self.rest as f64 / self.step() as f64) as f32;
        // Rounding must not reach the step that is not yet due.
        if fraction < 1.0 { fraction } else { 1.0 - 0.5 * f32::EPSILON }
    }

    /// Steps given since the clock was made.
    pub fn steps(&self) -> u64 {
        self.steps
    }

    /// Steps dropped since the clock was made.
    pub fn dropped(&self) -> u64 {
        self.dropped
    }

    /// Forgets the time that is not yet a step, as after loading.
    pub fn reset(&mut self) {
        self.rest = 0;
    }
}

/// A pose between two: `from` at fraction 0, `to` at 1.
///
/// The place goes straight, across sectors; the turn goes the shorter way, by the normalised sum of the
/// quaternions: within 0.5 % of an even turn up to 60 degrees between the poses. For looks only; a world never
/// reads it.
pub fn interpolated(
    from: (Position, Rotation),
    to: (Position, Rotation),
    fraction: f32,
) -> (Position, Rotation) {
    let way = to.0.minus(from.0);
    (from.0.plus(way * fraction), blended(from.1, to.1, fraction))
}

/// [`interpolated`] for poses in one frame.
pub fn interpolated_pose(from: &Pose, to: &Pose, fraction: f32) -> Pose {
    let position: Vec3 = from.position + (to.position - from.position) * fraction;
    Pose::new(position, blended(from.rotation, to.rotation, fraction))
}

/// Between two rotations, the shorter way.
fn blended(a: Rotation, b: Rotation, fraction: f32) -> Rotation {
    // A quaternion and its negative are one rotation.
    let same = a.x * b.x + a.y * b.y + a.z * b.z + a.w * b.w >= 0.0;
    let (s, t) = (1.0 - fraction, if same { fraction } else { -fraction });
    Rotation::new(a.x * s + b.x * t, a.y * s + b.y * t, a.z * s + b.z * t, a.w * s + b.w * t).normalized()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{PI, length};

    #[test]
    fn nothing_drifts_over_a_billion_pieces() {
        // 10^9 pieces of 16,666,667 ns are 16,666,667 s exactly: what a loop of `advance` adds up to, in one sum.
        let mut clock = Clock::new((1, 60), u32::MAX).unwrap();
        let piece = 16_666_667_u64;
        let due = clock.advance(piece * SECOND);
        assert_eq!(u64::from(due.steps), piece * 60);
        assert_eq!((clock.steps(), clock.fraction(), due.dropped), (piece * 60, 0.0, 0));
        // Piece by piece a million of them come to the same, remainder included.
        let mut slow = Clock::new((1, 60), 4).unwrap();
        let mut steps = 0;
        for pieces in 1..=1_000_000_u64 {
            steps += u64::from(slow.advance(piece).steps);
            assert_eq!(steps, piece * pieces * 60 / SECOND);
        }
        let mut fast = Clock::new((1, 60), u32::MAX).unwrap();
        fast.advance(piece * 1_000_000);
        assert_eq!((slow.steps(), slow.fraction()), (fast.steps(), fast.fraction()));
    }

    #[test]
    fn a_step_of_a_third_takes_three_to_a_second() {
        let mut clock = Clock::new((1, 3), 10).unwrap();
        let steps: [u32; 6] = core::array::from_fn(|_| clock.advance(SECOND / 2).steps);
        assert_eq!(steps, [1, 2, 1, 2, 1, 2]);
        let mut odd = Clock::new((1001, 60_000), 100).unwrap();
        assert_eq!(odd.advance(SECOND * 1001 / 1000).steps, 60);
        assert_eq!(odd.fraction(), 0.0);
        assert_eq!(odd.dt(), 1001.0 / 60_000.0);
    }

    #[test]
    fn steps_never_pile_up() {
        let mut clock = Clock::new((1, 60), 4).unwrap();
        let due = clock.advance(10 * SECOND);
        assert_eq!(due, Due { steps: 4, dropped: 596 });
        assert_eq!(clock.advance(0), Due::default());
        assert_eq!(clock.advance(SECOND / 30).steps, 1);
        assert_eq!((clock.steps(), clock.dropped()), (5, 596));
        let longest = clock.advance(u64::MAX);
        assert_eq!(longest.steps, 4);
        assert!(clock.fraction() < 1.0);
        let mut finest = Clock::new((1, u32::MAX), 1).unwrap();
        assert_eq!(finest.advance(u64::MAX).dropped, u64::MAX);
    }

    #[test]
    fn fractions_are_of_the_step_to_come() {
        let mut clock = Clock::new((1, 100), 4).unwrap();
        clock.advance(2_500_000);
        assert_eq!(clock.fraction(), 0.25);
        clock.advance(7_499_999);
        assert!(clock.fraction() < 1.0 && clock.fraction() > 0.999_999);
        assert_eq!(clock.advance(1).steps, 1);
        clock.advance(5_000_000);
        clock.reset();
        assert_eq!(clock.fraction(), 0.0);
        // The greatest rest of the longest step rounds to 1 in f32.
        let mut long = Clock::new((1_000_000_000, 1_000_000_000), 4).unwrap();
        long.advance(SECOND - 1);
        assert!(long.fraction() < 1.0);
    }

    #[test]
    fn steps_without_length_are_refused() {
        for step in [(0, 60), (1, 0), (61, 60), (1_000_000_001, u32::MAX)] {
            assert_eq!(Clock::new(step, 4), Err(Error::OutOfRange { name: "step" }));
        }
        assert_eq!(Clock::new((1, 60), 0), Err(Error::OutOfRange { name: "steps_max" }));
    }

    #[test]
    fn poses_are_blended_the_shorter_way_and_across_sectors() {
        let from = Position::at(Vec3::new(31.5, 0.0, -2.0));
        let to = Position { sector: [1, 0, 0], offset: Vec3::new(-31.5, 4.0, -2.0) };
        let (a, b) = (Rotation::IDENTITY, Rotation::from_axis_angle(Vec3::Z, 0.5));
        let (place, turn) = interpolated((from, a), (to, b), 0.25);
        assert!(length(place.minus(from) - Vec3::new(0.25, 1.0, 0.0)) < 1.0e-6, "{place:?}");
        let even = Rotation::from_axis_angle(Vec3::Z, 0.125);
        assert!((turn.z - even.z).abs() < 1.0e-3 && (turn.norm_squared() - 1.0).abs() < 1.0e-6);
        let other = Rotation::new(-b.x, -b.y, -b.z, -b.w);
        assert_eq!(interpolated((from, a), (to, other), 0.25).1, turn);
        assert_eq!(interpolated((from, a), (to, b), 0.0), (from, a));
        let (end, last) = interpolated((from, a), (to, b), 1.0);
        assert!(length(end.minus(to)) < 1.0e-6 && (last.w - b.w).abs() < 1.0e-7);
        // Half of any turn is exact by symmetry.
        let half = interpolated_pose(
            &Pose::IDENTITY,
            &Pose::new(Vec3::X, Rotation::from_axis_angle(Vec3::Y, 0.9 * PI)),
            0.5,
        );
        let expected = Rotation::from_axis_angle(Vec3::Y, 0.45 * PI);
        assert!((half.rotation.y - expected.y).abs() < 1.0e-6 && half.position == Vec3::X * 0.5);
        // Poses of opposite turns have a middle, too.
        let opposite = interpolated_pose(
            &Pose::IDENTITY,
            &Pose::new(Vec3::ZERO, Rotation::new(1.0, 0.0, 0.0, 0.0)),
            0.5,
        );
        assert!((opposite.rotation.norm_squared() - 1.0).abs() < 1.0e-6);
    }
}
