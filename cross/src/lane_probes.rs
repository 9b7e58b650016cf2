//! The lane type, one operation at a time.
//!
//! Every result is also compared with the scalar operation on the same machine, so that a wide instruction that
//! rounds otherwise is found without a second machine.

use crate::Probe;
use crate::hash;
use crate::lanes::{LANES, Lane, LaneVec, transpose};
use crate::math::Vec3;
use crate::numbers::Numbers;
use cellstep_core::math;

/// Groups of lanes for each operation.
const GROUPS: u32 = 20_000;
/// Bit patterns of the square root's probe: a prime stride through all of the positive ones.
const ROOT_STRIDE: usize = 1021;

/// All probes of lanes.
pub(crate) const ALL: [Probe; 15] = [
    Probe { name: "lane-add", value: || binary(|a, b| a + b, |a, b| a + b) },
    Probe { name: "lane-sub", value: || binary(|a, b| a - b, |a, b| a - b) },
    Probe { name: "lane-mul", value: || binary(|a, b| a * b, |a, b| a * b) },
    Probe { name: "lane-div", value: || binary(|a, b| a / b, |a, b| a / b) },
    Probe { name: "lane-neg", value: || binary(|a, _| -a, |a, _| -a) },
    Probe { name: "lane-sqrt", value: roots },
    Probe { name: "lane-sqrt-any", value: || binary(|a, _| a.sqrt(), |a, _| math::sqrt(a)) },
    Probe {
        name: "lane-less",
        value: || binary(|a, b| a.less(b).select(a, b), |a, b| if a < b { a } else { b }),
    },
    Probe {
        name: "lane-greater",
        value: || binary(|a, b| a.greater(b).select(a, b), |a, b| if a > b { a } else { b }),
    },
    Probe {
        name: "lane-bounds",
        value: || {
            binary(
                |a, b| a.least(b).greatest(-b),
                |a, b| {
                    let least = if a < b { a } else { b };
                    if least > -b { least } else { -b }
                },
            )
        },
    },
    Probe {
        name: "lane-finite",
        value: || binary(|a, b| a.finite_or(b), |a, b| if a.is_finite() { a } else { b }),
    },
    Probe {
        name: "lane-flush",
        value: || binary(|a, _| a.flushed(), |a, _| if a.abs() > 1.0e-18 { a } else { 0.0 }),
    },
    Probe { name: "lane-mask", value: masks },
    Probe { name: "lane-transpose", value: transpositions },
    Probe { name: "lane-vector", value: vectors },
];

/// Hash of an operation over many pairs of numbers. Where a result is a number at all, the scalar's bits are the
/// same.
fn binary(wide: impl Fn(Lane, Lane) -> Lane, scalar: impl Fn(f32, f32) -> f32) -> u64 {
    let mut numbers = Numbers(1);
    let mut sum = hash::START;
    for _ in 0..GROUPS {
        let (a, b) = (any_lane(&mut numbers), any_lane(&mut numbers));
        let out = wide(Lane::new(a), Lane::new(b)).to_array();
        for lane in 0..LANES {
            let expected = scalar(a[lane], b[lane]);
            let same = out[lane].to_bits() == expected.to_bits() || (out[lane].is_nan() && expected.is_nan());
            assert!(same, "{} and {}: {} by lanes, {expected} alone", a[lane], b[lane], out[lane]);
            sum = hash::number(sum, out[lane]);
        }
    }
    sum
}

/// Square roots of positive numbers from all binades, denormals included.
fn roots() -> u64 {
    let mut sum = hash::START;
    let mut bits = (1..0x7f80_0000_u32).step_by(ROOT_STRIDE);
    while let Some(first) = bits.next() {
        let x = core::array::from_fn(|lane| if lane == 0 { first } else { bits.next().unwrap_or(first) });
        let x = x.map(f32::from_bits);
        let out = Lane::new(x).sqrt().to_array();
        for lane in 0..LANES {
            assert!(out[lane] == math::sqrt(x[lane]), "root of {} by lanes is {}", x[lane], out[lane]);
            sum = hash::number(sum, out[lane]);
        }
    }
    sum
}

/// Masks joined and asked, for all their uses in the solver.
fn masks() -> u64 {
    let mut numbers = Numbers(2);
    let mut sum = hash::START;
    for _ in 0..GROUPS {
        let (a, b) = (any_lane(&mut numbers), any_lane(&mut numbers));
        let (left, right) = (Lane::new(a), Lane::new(b));
        let both = left.less(right).and(right.greater(Lane::ZERO));
        for (lane, x) in both.select(left, right).to_array().into_iter().enumerate() {
            let expected = if a[lane] < b[lane] && b[lane] > 0.0 { a[lane] } else { b[lane] };
            assert!(x.to_bits() == expected.to_bits(), "selection took {x}, not {expected}");
            sum = hash::number(sum, x);
        }
        // Rarely true in any lane, so that both answers occur. Asked of selected numbers and not of `a`: LLVM makes
        // `x > c || y > c` one comparison with a maximum, which ARM answers otherwise for signalling not-a-numbers.
        let large = left.greater(Lane::splat(1.0e30));
        let (rare, counts) = (large.any(), large.select(Lane::splat(1.0), Lane::ZERO).to_array());
        assert!(rare == counts.contains(&1.0), "any() answers {rare} for {counts:?}");
        sum = hash::word(sum, u64::from(rare));
    }
    sum
}

/// Rows to columns and back, for bits of all kinds.
fn transpositions() -> u64 {
    let mut numbers = Numbers(3);
    let mut sum = hash::START;
    for _ in 0..GROUPS / 8 {
        let rows: [[f32; LANES]; LANES] = core::array::from_fn(|_| any_lane(&mut numbers));
        let columns = transpose(rows.map(Lane::new)).map(Lane::to_array);
        for (row, numbers) in rows.iter().enumerate() {
            for (column, x) in numbers.iter().enumerate() {
                assert!(columns[column][row].to_bits() == x.to_bits(), "{x} is lost by transposition");
                sum = hash::word(sum, u64::from(columns[column][row].to_bits()));
            }
        }
    }
    sum
}

/// Scalar and vector products, where a fused multiplication would show.
fn vectors() -> u64 {
    let mut numbers = Numbers(4);
    let mut sum = hash::START;
    for _ in 0..GROUPS {
        let a: [Vec3; LANES] = core::array::from_fn(|_| numbers.vector(3.0));
        let b: [Vec3; LANES] = core::array::from_fn(|_| numbers.vector(3.0));
        let (mut left, mut right) = (LaneVec::ZERO, LaneVec::ZERO);
        for lane in 0..LANES {
            left.set(lane, a[lane]);
            right.set(lane, b[lane]);
        }
        let (dot, cross) = (left.dot(right), left.cross(right));
        for lane in 0..LANES {
            let expected = a[lane].cross(b[lane]);
            let found = Vec3::new(cross.x.get(lane), cross.y.get(lane), cross.z.get(lane));
            assert!(found.to_array().map(f32::to_bits) == expected.to_array().map(f32::to_bits), "{found}");
            assert!(dot.get(lane).to_bits() == a[lane].dot(b[lane]).to_bits(), "scalar product");
            sum = hash::number(sum, dot.get(lane));
            sum = [found.x, found.y, found.z].into_iter().fold(sum, hash::number);
        }
    }
    sum
}

fn any_lane(numbers: &mut Numbers) -> [f32; LANES] {
    core::array::from_fn(|_| numbers.any())
}
