//! Lanes of `f32`: the only numbers of the solver's kernel.
//!
//! Newtypes over `wide` that let through only what IEEE 754 fixes to the last bit: `+ - * /`, square root,
//! comparisons, selection and transposition. No fused or approximate operation, no reduction, so the bits are the
//! same on every machine whatever its vector width.
//!
//! Eight lanes on every machine: where an instruction takes four, two of them have their chains of dependent
//! operations side by side, which costs moves between registers but fills the waits (with four lanes and the same
//! kernel SSE2 takes 20 % fewer instructions and 15 % more time). A lane knows nothing of its neighbours.

use bytemuck::{Pod, Zeroable};
use core::ops::{Add, Div, Mul, Neg, Sub};
use wide::{f32x4, f32x8};

/// Number of lanes.
pub const LANES: usize = 8;

/// Magnitude below which velocities, impulses and the parts of rotations are 0, 2^-56. What comes to rest decays
/// through ever smaller numbers, and where one of them, or its square, is denormal, an instruction takes a hundred
/// times as long on many machines: a sixth of the step of columns of cubes at rest. Squares of what is left are
/// normal numbers, and it means nothing at any scale: a body that moves so fast for a year has moved by 0.4 nm.
pub const FLUSH: f32 = 1.0 / (1_u64 << 56) as f32;

/// One number for each lane.
#[repr(transparent)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Lane(f32x8);

/// One truth value for each lane.
#[derive(Clone, Copy, Debug)]
pub struct Mask(f32x8);

/// Eight numbers of one thing, a body or a contact, next to each other in memory.
#[repr(transparent)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Words(f32x8);

impl Words {
    /// All 0.
    pub const ZERO: Self = Self(f32x8::ZERO);

    /// From numbers.
    #[inline(always)]
    pub fn new(x: [f32; 8]) -> Self {
        Self(f32x8::new(x))
    }

    /// The numbers.
    #[inline(always)]
    pub fn to_array(self) -> [f32; 8] {
        self.0.to_array()
    }

    /// 0 where the magnitude is below that in `least`, else `self`, what is no number included.
    #[inline(always)]
    pub fn flushed(self, least: Self) -> Self {
        Self(self.0.abs().simd_lt(least.0).bitselect(f32x8::ZERO, self.0))
    }
}

impl Lane {
    /// All lanes 0.
    pub const ZERO: Self = Self(f32x8::ZERO);

    /// The same number in every lane.
    #[inline(always)]
    pub fn splat(x: f32) -> Self {
        Self(f32x8::splat(x))
    }

    /// One number for each lane.
    #[inline(always)]
    pub fn new(x: [f32; LANES]) -> Self {
        Self(f32x8::new(x))
    }

    /// The number in one lane.
    #[inline(always)]
    pub fn get(&self, lane: usize) -> f32 {
        self.0.as_array()[lane]
    }

    /// Writes the number in one lane.
    #[inline(always)]
    pub fn set(&mut self, lane: usize, x: f32) {
        self.0.as_mut_array()[lane] = x;
    }

    /// Square root, correctly rounded.
    #[inline(always)]
    pub fn sqrt(self) -> Self {
        Self(self.0.sqrt())
    }

    /// `self < other`, lane by lane; false where one is not a number.
    #[inline(always)]
    pub fn less(self, other: Self) -> Mask {
        Mask(self.0.simd_lt(other.0))
    }

    /// `self > other`, lane by lane; false where one is not a number.
    #[inline(always)]
    pub fn greater(self, other: Self) -> Mask {
        Mask(self.0.simd_gt(other.0))
    }

    /// The lesser; `other` where they compare equal or `self` is not a number.
    #[inline(always)]
    pub fn least(self, other: Self) -> Self {
        self.less(other).select(self, other)
    }

    /// The greater; `other` where they compare equal or `self` is not a number.
    #[inline(always)]
    pub fn greatest(self, other: Self) -> Self {
        self.greater(other).select(self, other)
    }

    /// `self` where it is finite, else 0: keeps a non-finite impulse from spreading.
    #[inline(always)]
    #[expect(clippy::eq_op, reason = "x - x tells finite numbers from the rest")]
    pub fn finite(self) -> Self {
        // x - x is 0 for finite x and NaN for the rest, and NaN compares false.
        let rest = self - self;
        rest.less(Self::splat(1.0)).keep(self)
    }

    /// 0 where the magnitude is below [`FLUSH`], else `self`, what is no number included.
    #[inline(always)]
    pub fn flushed(self) -> Self {
        Self(self.0.abs().simd_lt(f32x8::splat(FLUSH)).bitselect(f32x8::ZERO, self.0))
    }

    /// `self` where it is finite and above 1e-18, else 0: an impulse that can only push. What carries bodies of
    /// picograms is not cut off.
    #[inline(always)]
    pub fn pushing(self) -> Self {
        self.greater(Self::splat(1.0e-18)).and(self.less(Self::splat(f32::INFINITY))).keep(self)
    }
}

impl Mask {
    /// All false.
    pub const NONE: Self = Self(f32x8::ZERO);

    /// `yes` where true, `no` where false.
    #[inline(always)]
    pub fn select(self, yes: Lane, no: Lane) -> Lane {
        Lane(self.0.bitselect(yes.0, no.0))
    }

    /// `yes` where true, `no` where false.
    #[inline(always)]
    pub fn select_vec(self, yes: LaneVec, no: LaneVec) -> LaneVec {
        LaneVec::new(self.select(yes.x, no.x), self.select(yes.y, no.y), self.select(yes.z, no.z))
    }

    /// `x` where true, 0 where false.
    #[inline(always)]
    pub fn keep(self, x: Lane) -> Lane {
        Lane(self.0 & x.0)
    }

    /// `v` where true, 0 where false.
    #[inline(always)]
    pub fn keep_vec(self, v: LaneVec) -> LaneVec {
        LaneVec::new(self.keep(v.x), self.keep(v.y), self.keep(v.z))
    }

    /// True when some lane is.
    #[inline(always)]
    pub fn any(self) -> bool {
        self.0.any()
    }

    /// True when every lane is.
    #[inline(always)]
    pub fn all(self) -> bool {
        self.0.all()
    }

    /// True where both are.
    #[inline(always)]
    pub fn and(self, other: Self) -> Self {
        Self(self.0 & other.0)
    }
}

macro_rules! operator {
    ($type:ident, $trait:ident, $method:ident) => {
        impl $trait for $type {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self(self.0.$method(other.0))
            }
        }
    };
}
operator!(Lane, Add, add);
operator!(Lane, Sub, sub);
operator!(Lane, Mul, mul);
operator!(Lane, Div, div);
operator!(Words, Add, add);
operator!(Words, Sub, sub);
operator!(Words, Mul, mul);

impl Neg for Lane {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self(-self.0)
    }
}

/// Rows become columns. By quarters, because the four-wide transposition is fast without AVX too.
#[inline(always)]
fn turn_over([a, b, c, d, e, f, g, h]: [[f32x4; 2]; LANES]) -> [[f32x4; 2]; LANES] {
    let low = f32x4::transpose([a[0], b[0], c[0], d[0]]);
    let high = f32x4::transpose([e[0], f[0], g[0], h[0]]);
    let next_low = f32x4::transpose([a[1], b[1], c[1], d[1]]);
    let next_high = f32x4::transpose([e[1], f[1], g[1], h[1]]);
    [
        [low[0], high[0]],
        [low[1], high[1]],
        [low[2], high[2]],
        [low[3], high[3]],
        [next_low[0], next_high[0]],
        [next_low[1], next_high[1]],
        [next_low[2], next_high[2]],
        [next_low[3], next_high[3]],
    ]
}

/// Something of each lane. Written out: through an array's `map` the compiler makes copies of what is large.
#[inline(always)]
pub fn each_lane<T>(of: impl Fn(usize) -> T) -> [T; LANES] {
    [of(0), of(1), of(2), of(3), of(4), of(5), of(6), of(7)]
}

/// The words of eight things, word by word.
#[inline(always)]
pub fn transpose(rows: [Words; LANES]) -> [Lane; 8] {
    bytemuck::cast(turn_over(bytemuck::cast(rows)))
}

/// Undoes [`transpose`].
#[inline(always)]
pub fn transpose_back(words: [Lane; 8]) -> [Words; LANES] {
    bytemuck::cast(turn_over(bytemuck::cast(words)))
}

/// A vector in every lane.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct LaneVec {
    /// First component.
    pub x: Lane,
    /// Second component.
    pub y: Lane,
    /// Third component.
    pub z: Lane,
}

impl LaneVec {
    /// All 0.
    pub const ZERO: Self = Self { x: Lane::ZERO, y: Lane::ZERO, z: Lane::ZERO };

    /// From components.
    #[inline(always)]
    pub fn new(x: Lane, y: Lane, z: Lane) -> Self {
        Self { x, y, z }
    }

    /// Writes the vector of one lane.
    #[inline(always)]
    pub fn set(&mut self, lane: usize, v: crate::math::Vec3) {
        self.x.set(lane, v.x);
        self.y.set(lane, v.y);
        self.z.set(lane, v.z);
    }

    /// The vector of one lane.
    #[inline(always)]
    pub fn get(&self, lane: usize) -> crate::math::Vec3 {
        crate::math::Vec3::new(self.x.get(lane), self.y.get(lane), self.z.get(lane))
    }

    /// The components, each 0 where its magnitude is below [`FLUSH`].
    #[inline(always)]
    pub fn flushed(self) -> Self {
        Self { x: self.x.flushed(), y: self.y.flushed(), z: self.z.flushed() }
    }

    /// The components, each 0 where it is not finite.
    #[inline(always)]
    pub fn finite(self) -> Self {
        Self { x: self.x.finite(), y: self.y.finite(), z: self.z.finite() }
    }

    /// Scalar product.
    #[inline(always)]
    pub fn dot(self, o: Self) -> Lane {
        self.x * o.x + self.y * o.y + self.z * o.z
    }

    /// Vector product.
    #[inline(always)]
    pub fn cross(self, o: Self) -> Self {
        Self {
            x: self.y * o.z - self.z * o.y,
            y: self.z * o.x - self.x * o.z,
            z: self.x * o.y - self.y * o.x,
        }
    }

    /// Scaled, lane by lane.
    #[inline(always)]
    pub fn times(self, s: Lane) -> Self {
        Self { x: self.x * s, y: self.y * s, z: self.z * s }
    }

    /// Multiplied component by component.
    #[inline(always)]
    pub fn each_times(self, o: Self) -> Self {
        Self { x: self.x * o.x, y: self.y * o.y, z: self.z * o.z }
    }
}

impl Add for LaneVec {
    type Output = Self;
    #[inline(always)]
    fn add(self, o: Self) -> Self {
        Self { x: self.x + o.x, y: self.y + o.y, z: self.z + o.z }
    }
}

impl Sub for LaneVec {
    type Output = Self;
    #[inline(always)]
    fn sub(self, o: Self) -> Self {
        Self { x: self.x - o.x, y: self.y - o.y, z: self.z - o.z }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn transposition_swaps_rows_and_columns() {
        let rows: [Words; LANES] =
            core::array::from_fn(|r| Words::new(core::array::from_fn(|c| (10 * r + c) as f32)));
        let columns = transpose(rows);
        for (c, column) in columns.iter().enumerate() {
            for r in 0..LANES {
                assert_eq!(column.get(r), (10 * r + c) as f32);
            }
        }
        for (row, again) in rows.iter().zip(transpose_back(columns)) {
            assert_eq!(row.to_array(), again.to_array());
        }
    }

    #[test]
    fn non_finite_and_tiny_numbers_are_replaced() {
        let cases = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1.0e-19, -1.0e-40, 2.0, -2.0, 0.0];
        for (x, kept, pushing) in [
            (cases[0], 0.0, 0.0),
            (cases[1], 0.0, 0.0),
            (cases[2], 0.0, 0.0),
            (cases[5], 2.0, 2.0),
            (cases[6], -2.0, 0.0),
            (cases[7], 0.0, 0.0),
        ] {
            assert_eq!(Lane::splat(x).finite().flushed().get(0), kept);
            assert_eq!(Lane::splat(x).pushing().get(0), pushing);
        }
        assert!(
            Lane::splat(f32::NAN).flushed().get(0).is_nan(),
            "who is no longer finite is not put to rest"
        );
        assert_eq!(Lane::splat(-FLUSH).flushed().get(0), -FLUSH);
        const { assert!(FLUSH * FLUSH > f32::MIN_POSITIVE) };
        assert_eq!(Lane::splat(cases[3]).pushing().get(0), 0.0);
        assert_eq!(Lane::splat(cases[4]).flushed().get(0), 0.0);
    }
}
