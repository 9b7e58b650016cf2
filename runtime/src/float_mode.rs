//! The floating-point mode of a thread.
//!
//! Audio and game middleware switches threads to flush-to-zero or to another rounding; such a thread computes
//! other bits than the rest of the world. The mode cannot be read without unsafe code, but its effect can:
//! five sums whose inputs the compiler cannot see. Additions of subnormal numbers are fast on the processors
//! that are slow in multiplying them, so a check takes some nanoseconds.
//!
//! Core's arithmetic wants the mode that every thread starts with on the supported systems: subnormal numbers
//! kept, ties to even. Remedy: run the step on a thread of its own, or switch the mode back around it.

use std::hint::black_box;

/// What one thread's `f32` arithmetic does now.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FloatMode {
    /// Subnormal operands count as they are (false: as zero, "denormals are zero").
    pub keeps_subnormal_operands: bool,
    /// Subnormal results are delivered (false: zero is, "flush to zero").
    pub keeps_subnormal_results: bool,
    /// Results are rounded to the nearest number, ties to even.
    pub rounds_to_nearest: bool,
}

impl FloatMode {
    /// The mode of IEEE 754 that the engine's bits are defined in.
    pub const STANDARD: FloatMode =
        FloatMode { keeps_subnormal_operands: true, keeps_subnormal_results: true, rounds_to_nearest: true };

    /// True in the only mode that gives the engine's bits.
    pub fn is_standard(self) -> bool {
        self == Self::STANDARD
    }
}

/// The mode of the calling thread.
pub fn check() -> FloatMode {
    classify(sums())
}

/// `check().is_standard()`.
#[inline]
pub fn is_standard() -> bool {
    sums() == STANDARD_SUMS
}

/// The largest power of two below the normal numbers.
const SUBNORMAL: f32 = f32::MIN_POSITIVE / 2.0;
const HALF_ULP: f32 = f32::EPSILON / 2.0;

/// Two terms each, and what the sum is in the standard mode. A sum that has a subnormal operand has a normal
/// result and the other way round, so that the two flush modes can be told apart.
const TERMS: [(f32, f32); 5] = [
    (SUBNORMAL, SUBNORMAL),
    (f32::MIN_POSITIVE + SUBNORMAL, -f32::MIN_POSITIVE),
    // A tie: down to even. Rounding upwards and ties away from zero go up.
    (1.0, HALF_ULP),
    // A tie again: up to even. Rounding downwards and towards zero go down.
    (1.0 + f32::EPSILON, HALF_ULP),
    // The mirror image of the first tie: rounding downwards goes down.
    (-1.0, -HALF_ULP),
];

/// Bits, since a thread that takes subnormal operands for zero also compares so.
const STANDARD_SUMS: [u32; 5] = [
    f32::MIN_POSITIVE.to_bits(),
    SUBNORMAL.to_bits(),
    1f32.to_bits(),
    (1.0 + 2.0 * f32::EPSILON).to_bits(),
    (-1f32).to_bits(),
];

#[inline]
fn sums() -> [u32; 5] {
    TERMS.map(|(a, b)| (black_box(a) + black_box(b)).to_bits())
}

fn classify(sums: [u32; 5]) -> FloatMode {
    FloatMode {
        keeps_subnormal_operands: sums[0] == STANDARD_SUMS[0],
        keeps_subnormal_results: sums[1] == STANDARD_SUMS[1],
        rounds_to_nearest: sums[2..] == STANDARD_SUMS[2..],
    }
}

#[cfg(all(test, not(loom)))]
mod tests {
    use super::*;

    #[test]
    fn test_threads_have_the_standard_mode() {
        assert_eq!(check(), FloatMode::STANDARD);
        assert!(check().is_standard() && is_standard());
    }

    #[test]
    fn constants_are_what_exact_arithmetic_gives() {
        for ((a, b), bits) in TERMS.into_iter().zip(STANDARD_SUMS) {
            // The sums are exact in f64, and the conversion rounds once.
            assert_eq!(((f64::from(a) + f64::from(b)) as f32).to_bits(), bits, "{a:e} + {b:e}");
        }
    }

    #[test]
    fn every_other_mode_is_told_apart() {
        let [operand, result, even_down, even_up, mirror] = STANDARD_SUMS;
        let up = (1.0 + f32::EPSILON).to_bits();
        let below = (-1.0 - f32::EPSILON).to_bits();
        let flushed_operands = classify([0, result, even_down, even_up, mirror]);
        let expected = FloatMode { keeps_subnormal_operands: false, ..FloatMode::STANDARD };
        assert_eq!(flushed_operands, expected);
        let flushed_results = classify([operand, 0, even_down, even_up, mirror]);
        assert_eq!(flushed_results, FloatMode { keeps_subnormal_results: false, ..FloatMode::STANDARD });
        let upwards = [operand, result, up, even_up, mirror];
        let downwards = [operand, result, even_down, up, below];
        let towards_zero = [operand, result, even_down, up, mirror];
        let ties_away = [operand, result, up, even_up, below];
        for sums in [upwards, downwards, towards_zero, ties_away] {
            let mode = classify(sums);
            assert_eq!(mode, FloatMode { rounds_to_nearest: false, ..FloatMode::STANDARD });
            assert!(!mode.is_standard());
        }
    }
}
