//! Eight lanes of `f32`: the only numbers of the solver's kernel.
//!
//! A newtype over `wide::f32x8` that lets through only what IEEE 754 fixes to the last bit: `+ - * /`, square
//! root, comparisons, selection and transposition. No fused or approximate operation, no reduction, so the bits
//! are the same on every machine whatever its vector width.

use bytemuck::{Pod, Zeroable};
use core::ops::{Add, Div, Mul, Neg, Sub};
use wide::{f32x4, f32x8};

/// Number of lanes.
pub const LANES: usize = 8;

/// One number for each lane.
#[repr(transparent)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Lane(f32x8);

/// One truth value for each lane.
#[derive(Clone, Copy, Debug)]
pub struct Mask(f32x8);

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

    /// The numbers of the lanes.
    #[inline(always)]
    pub fn to_array(self) -> [f32; LANES] {
        self.0.to_array()
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

    /// `self` where it is finite, else `other`: keeps a non-finite impulse from spreading.
    #[inline(always)]
    #[expect(clippy::eq_op, reason = "x - x tells finite numbers from the rest")]
    pub fn finite_or(self, other: Self) -> Self {
        // x - x is 0 for finite x and NaN for the rest, and NaN compares false.
        let rest = self - self;
        Mask(rest.0.simd_lt(f32x8::splat(1.0))).select(self, other)
    }

    /// 0 where the size is below 1e-18: denormals are slow on many machines and mean nothing here.
    #[inline(always)]
    pub fn flushed(self) -> Self {
        let tiny = Self::splat(1.0e-18);
        let large = Mask(self.0.simd_gt(tiny.0) | self.0.simd_lt((-tiny).0));
        large.select(self, Self::ZERO)
    }
}

impl Mask {
    /// `yes` where true, `no` where false.
    #[inline(always)]
    pub fn select(self, yes: Lane, no: Lane) -> Lane {
        Lane(self.0.bitselect(yes.0, no.0))
    }

    /// True when some lane is.
    #[inline(always)]
    pub fn any(self) -> bool {
        self.0.any()
    }

    /// True where both are.
    #[inline(always)]
    pub fn and(self, other: Self) -> Self {
        Self(self.0 & other.0)
    }
}

macro_rules! operator {
    ($trait:ident, $method:ident) => {
        impl $trait for Lane {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self(self.0.$method(other.0))
            }
        }
    };
}
operator!(Add, add);
operator!(Sub, sub);
operator!(Mul, mul);
operator!(Div, div);

impl Neg for Lane {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self(-self.0)
    }
}

/// Rows become columns. By quarters, because the four-wide transposition is fast without AVX too.
#[inline(always)]
pub fn transpose(rows: [Lane; LANES]) -> [Lane; LANES] {
    let halves: [[f32x4; 2]; LANES] = rows.map(|row| bytemuck::cast(row.0));
    let quarter = |first: usize, half: usize| {
        f32x4::transpose([
            halves[first][half],
            halves[first + 1][half],
            halves[first + 2][half],
            halves[first + 3][half],
        ])
    };
    let (a, b, c, d) = (quarter(0, 0), quarter(4, 0), quarter(0, 1), quarter(4, 1));
    core::array::from_fn(|i| {
        let halves = if i < 4 { [a[i], b[i]] } else { [c[i - 4], d[i - 4]] };
        Lane(bytemuck::cast(halves))
    })
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
        let rows = core::array::from_fn(|r| Lane::new(core::array::from_fn(|c| (10 * r + c) as f32)));
        for (c, column) in transpose(rows).iter().enumerate() {
            for r in 0..LANES {
                assert_eq!(column.get(r), (10 * r + c) as f32);
            }
        }
    }

    #[test]
    fn non_finite_and_tiny_numbers_are_replaced() {
        let x = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1.0e-19, -1.0e-19, 2.0, -2.0, 0.0];
        let kept = Lane::new(x).finite_or(Lane::splat(7.0)).flushed().to_array();
        assert_eq!(kept, [7.0, 7.0, 7.0, 0.0, 0.0, 2.0, -2.0, 0.0]);
    }
}
