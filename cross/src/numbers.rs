//! Repeatable numbers (SplitMix64, Steele et al. 2014).

use cellstep_core::math::{Rotation, Vec3};

/// A source of numbers.
pub(crate) struct Numbers(pub u64);

impl Numbers {
    /// The next word.
    pub fn word(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// The next index below `count`.
    pub fn below(&mut self, count: u32) -> u32 {
        (((self.word() >> 32) * u64::from(count)) >> 32) as u32
    }

    /// The next number in `low..high`.
    pub fn between(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * ((self.word() >> 40) as f32 / (1 << 24) as f32)
    }

    /// The next vector with components in `-size..size`.
    pub fn vector(&mut self, size: f32) -> Vec3 {
        let (x, y, z) = (self.between(-size, size), self.between(-size, size), self.between(-size, size));
        Vec3::new(x, y, z)
    }

    /// The next rotation.
    pub fn rotation(&mut self) -> Rotation {
        Rotation::from_rotation_vector(self.vector(2.0))
    }

    /// Any bits of a number: denormals, zeros of both signs, infinities and not-a-numbers more often than by
    /// chance.
    pub fn any(&mut self) -> f32 {
        const SPECIAL: [u32; 12] = [
            0,
            0x8000_0000,
            1,
            0x8000_0001,
            0x007f_ffff,
            0x0080_0000,
            0x3f80_0000,
            0xbf80_0000,
            0x7f7f_ffff,
            0x7f80_0000,
            0xff80_0000,
            0x7fc0_0000,
        ];
        let word = self.word();
        match word & 15 {
            0 => f32::from_bits(SPECIAL[(word >> 32) as usize % SPECIAL.len()]),
            1 => f32::from_bits((word >> 32) as u32 & 0x807f_ffff),
            // Near 1, where sums cancel and products round.
            2..=9 => self.between(-2.0, 2.0),
            _ => f32::from_bits((word >> 32) as u32),
        }
    }
}
