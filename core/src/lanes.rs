//! Lanes of `f32`: the only numbers of the solver's kernel.
//!
//! Newtypes over `wide` that let through only what IEEE 754 fixes to the last bit: `+ - * /`, square root,
//! comparisons, selection and transposition. No fused or approximate operation, no reduction, so the bits are the
//! same on every machine whatever its vector width.
//!
//! Work is dealt to [`LANES`] chains on every machine. How many of them an instruction takes is the machine's
//! [`WIDTH`]: eight with AVX, four elsewhere, where eight would need every register twice and spend half of the
//! instructions on moving them. A row is then visited in [`PARTS`] parts. A lane knows nothing of its neighbours,
//! so the width never changes a bit.

use bytemuck::{Pod, Zeroable};
use core::ops::{Add, Div, Mul, Neg, Sub};
use wide::{f32x4, f32x8};

/// Chains that are solved side by side.
pub const LANES: usize = 8;
/// Lanes of an instruction.
pub const WIDTH: usize = size_of::<Native>() / size_of::<f32>();
/// Instructions for all lanes.
pub const PARTS: usize = LANES / WIDTH;

#[cfg(target_feature = "avx")]
type Native = f32x8;
#[cfg(not(target_feature = "avx"))]
type Native = f32x4;

/// One number for each lane of an instruction.
#[repr(transparent)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Lane(Native);

/// One truth value for each lane.
#[derive(Clone, Copy, Debug)]
pub struct Mask(Native);

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
}

impl Lane {
    /// All lanes 0.
    pub const ZERO: Self = Self(Native::ZERO);

    /// The same number in every lane.
    #[inline(always)]
    pub fn splat(x: f32) -> Self {
        Self(Native::splat(x))
    }

    /// One number for each lane.
    #[inline(always)]
    pub fn new(x: [f32; WIDTH]) -> Self {
        Self(Native::new(x))
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

    /// `self` rounded to multiples of about 1e-25: denormals are slow on many machines and mean nothing here.
    #[inline(always)]
    pub fn flushed(self) -> Self {
        let tiny = Self::splat(1.0e-18);
        (self + tiny) - tiny
    }

    /// `self` where it is finite and above 1e-18, else 0: an impulse that can only push.
    #[inline(always)]
    pub fn pushing(self) -> Self {
        self.greater(Self::splat(1.0e-18)).and(self.less(Self::splat(f32::INFINITY))).keep(self)
    }
}

impl Mask {
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

/// Four rows of four numbers become columns.
#[inline(always)]
fn quarter(rows: &[[f32x4; 2]], half: usize) -> [f32x4; 4] {
    f32x4::transpose([rows[0][half], rows[1][half], rows[2][half], rows[3][half]])
}

/// The words of as many things as there are lanes, word by word.
#[inline(always)]
pub fn transpose(rows: [Words; WIDTH]) -> [Lane; 8] {
    let halves: [[f32x4; 2]; WIDTH] = rows.map(|row| bytemuck::cast(row.0));
    let mut words = [Lane::ZERO; 8];
    for half in 0..2 {
        // By quarters, because the four-wide transposition is fast everywhere.
        let mut columns = [[f32x4::ZERO; WIDTH / 4]; 4];
        for part in 0..WIDTH / 4 {
            let quarter = quarter(&halves[4 * part..], half);
            for (column, own) in columns.iter_mut().zip(quarter) {
                column[part] = own;
            }
        }
        for (word, column) in words[4 * half..].iter_mut().zip(columns) {
            *word = Lane(bytemuck::cast(column));
        }
    }
    words
}

/// Undoes [`transpose`].
#[inline(always)]
pub fn transpose_back(words: [Lane; 8]) -> [Words; WIDTH] {
    let columns: [[f32x4; WIDTH / 4]; 8] = words.map(|word| bytemuck::cast(word.0));
    let mut rows = [[f32x4::ZERO; 2]; WIDTH];
    for part in 0..WIDTH / 4 {
        for half in 0..2 {
            let [a, b, c, d] = core::array::from_fn(|i| columns[4 * half + i][part]);
            let quarter = f32x4::transpose([a, b, c, d]);
            for (row, own) in rows[4 * part..].iter_mut().zip(quarter) {
                row[half] = own;
            }
        }
    }
    rows.map(|row| Words(bytemuck::cast(row)))
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
        let rows: [Words; WIDTH] =
            core::array::from_fn(|r| Words::new(core::array::from_fn(|c| (10 * r + c) as f32)));
        let columns = transpose(rows);
        for (c, column) in columns.iter().enumerate() {
            for r in 0..WIDTH {
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
        assert_eq!(Lane::splat(cases[3]).pushing().get(0), 0.0);
        assert_eq!(Lane::splat(cases[4]).flushed().get(0), 0.0);
    }
}
