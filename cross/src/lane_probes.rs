//! The lane type, one operation at a time.
//!
//! Every result is also compared with the scalar operation on the same machine, so that a wide instruction that
//! rounds otherwise is found without a second machine.

use crate::Probe;
use crate::hash;
use crate::lanes::{FLUSH, LANES, Lane, LaneVec, Mask, Words, transpose, transpose_back};
use crate::math::Vec3;
use crate::numbers::Numbers;
use cellstep_core::math;

/// Groups of lanes for each operation.
const GROUPS: u32 = 20_000;
/// Bit patterns of the square root's probe: a prime stride through all of the positive ones.
const ROOT_STRIDE: usize = 1021;

/// All probes of lanes.
pub(crate) const ALL: [Probe; 19] = [
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
        value: || binary(|a, _| a.finite(), |a, _| if a.is_finite() { a } else { 0.0 }),
    },
    Probe {
        name: "lane-flush",
        value: || binary(|a, _| a.flushed(), |a, _| if a > -FLUSH && a < FLUSH { 0.0 } else { a }),
    },
    Probe {
        name: "lane-push",
        value: || binary(|a, _| a.pushing(), |a, _| if a > 1.0e-18 && a.is_finite() { a } else { 0.0 }),
    },
    Probe {
        name: "lane-keep",
        value: || binary(|a, b| a.less(b).keep(a), |a, b| if a < b { a } else { 0.0 }),
    },
    Probe { name: "lane-mask", value: masks },
    Probe { name: "lane-transpose", value: transpositions },
    Probe { name: "lane-words", value: words },
    Probe { name: "lane-vector", value: vectors },
    Probe { name: "lane-vector-mask", value: vector_masks },
];

/// Hash of an operation over many pairs of numbers. Where a result is a number at all, the scalar's bits are the
/// same.
fn binary(wide: impl Fn(Lane, Lane) -> Lane, scalar: impl Fn(f32, f32) -> f32) -> u64 {
    let mut numbers = Numbers(1);
    let mut sum = hash::START;
    for _ in 0..GROUPS {
        let (a, b) = (any_lane(&mut numbers), any_lane(&mut numbers));
        let out = numbers_of(wide(Lane::new(a), Lane::new(b)));
        for lane in 0..LANES {
            let expected = scalar(a[lane], b[lane]);
            let same = are_same(out[lane], expected);
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
        let out = numbers_of(Lane::new(x).sqrt());
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
        for (lane, x) in numbers_of(both.select(left, right)).into_iter().enumerate() {
            let expected = if a[lane] < b[lane] && b[lane] > 0.0 { a[lane] } else { b[lane] };
            assert!(x.to_bits() == expected.to_bits(), "selection took {x}, not {expected}");
            sum = hash::number(sum, x);
        }
        // Rarely true in any lane, so that both answers occur. Asked of selected numbers and not of `a`: LLVM makes
        // `x > c || y > c` one comparison with a maximum, which ARM answers otherwise for signalling not-a-numbers.
        let large = left.greater(Lane::splat(1.0e30));
        let (rare, counts) = (large.any(), numbers_of(large.select(Lane::splat(1.0), Lane::ZERO)));
        assert!(rare == counts.contains(&1.0), "any() answers {rare} for {counts:?}");
        assert!(!Mask::NONE.any() && !both.and(Mask::NONE).any(), "nothing is true");
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
        let turned = transpose(rows.map(Words::new));
        let again = transpose_back(turned).map(Words::to_array);
        let columns = turned.map(numbers_of);
        for (row, numbers) in rows.iter().enumerate() {
            for (column, x) in numbers.iter().enumerate() {
                assert!(columns[column][row].to_bits() == x.to_bits(), "{x} is lost by transposition");
                assert!(again[row][column].to_bits() == x.to_bits(), "{x} does not come back");
                sum = hash::word(sum, u64::from(columns[column][row].to_bits()));
            }
        }
    }
    sum
}

/// Arithmetic on rows.
fn words() -> u64 {
    let mut numbers = Numbers(9);
    let mut sum = hash::START;
    for _ in 0..GROUPS {
        let (a, b, c) = (any_lane(&mut numbers), any_lane(&mut numbers), any_lane(&mut numbers));
        let out = Words::new(a) * Words::new(b) + (Words::new(c) - Words::ZERO);
        for (i, x) in out.to_array().into_iter().enumerate() {
            let expected = a[i] * b[i] + (c[i] - 0.0);
            assert!(are_same(x, expected), "{} {} + {}: {x} by rows, {expected} alone", a[i], b[i], c[i]);
            sum = hash::number(sum, x);
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
        let rest = (left + right.times(dot)).each_times(right - left);
        for lane in 0..LANES {
            let (a, b) = (a[lane], b[lane]);
            assert!(dot.get(lane).to_bits() == a.dot(b).to_bits(), "scalar product");
            sum = hash::number(sum, dot.get(lane));
            let d = dot.get(lane);
            let terms = |i: usize| (a[i] + b[i] * d) * (b[i] - a[i]);
            for (found, expected) in
                [(cross.get(lane), a.cross(b)), (rest.get(lane), Vec3::new(terms(0), terms(1), terms(2)))]
            {
                assert!(
                    found.to_array().map(f32::to_bits) == expected.to_array().map(f32::to_bits),
                    "{found}"
                );
                sum = found.to_array().into_iter().fold(sum, hash::number);
            }
        }
    }
    sum
}

/// Vectors chosen and kept by masks, component by component.
fn vector_masks() -> u64 {
    let mut numbers = Numbers(10);
    let mut sum = hash::START;
    let mut any = || -> [[f32; LANES]; 3] { core::array::from_fn(|_| any_lane(&mut numbers)) };
    for _ in 0..GROUPS {
        let (a, b) = (any(), any());
        let [left, right] = [a, b].map(|[x, y, z]| LaneVec::new(Lane::new(x), Lane::new(y), Lane::new(z)));
        let mask = left.x.less(right.x);
        let (chosen, kept) = (mask.select_vec(left, right), mask.keep_vec(left));
        for lane in 0..LANES {
            let holds = a[0][lane] < b[0][lane];
            let (chosen, kept) = (chosen.get(lane).to_array(), kept.get(lane).to_array());
            for axis in 0..3 {
                let (yes, no) = (a[axis][lane], b[axis][lane]);
                let expected = if holds { (yes, yes) } else { (no, 0.0) };
                let same = |x: f32, y: f32| x.to_bits() == y.to_bits();
                assert!(same(chosen[axis], expected.0) && same(kept[axis], expected.1), "{expected:?}");
                sum = hash::number(hash::number(sum, chosen[axis]), kept[axis]);
            }
        }
    }
    sum
}

/// The same bits, or both not a number.
fn are_same(a: f32, b: f32) -> bool {
    a.to_bits() == b.to_bits() || (a.is_nan() && b.is_nan())
}

fn numbers_of(lane: Lane) -> [f32; LANES] {
    core::array::from_fn(|i| lane.get(i))
}

fn any_lane(numbers: &mut Numbers) -> [f32; LANES] {
    core::array::from_fn(|_| numbers.any())
}
