//! Checksums of the state: one of all, one for each section, one for each body.
//!
//! The hash is XXH64 (Yann Collet's 64-bit xxHash, seed 0), part of the format.

use super::World;
use crate::arena::Line;
use crate::error::Error;
use crate::handle::BodyHandle;

const P1: u64 = 0x9E37_79B1_85EB_CA87;
const P2: u64 = 0xC2B2_AE3D_27D4_EB4F;
const P3: u64 = 0x1656_67B1_9E37_79F9;
const P4: u64 = 0x85EB_CA77_C2B2_AE63;
const P5: u64 = 0x27D4_EB2F_1656_67C5;

/// XXH64 of some bytes: the hash of checksums, snapshots and replays, the same on every machine.
pub fn hash(bytes: &[u8], seed: u64) -> u64 {
    let mut rest = bytes;
    let mut h = if bytes.len() >= 32 {
        let mut lanes =
            [seed.wrapping_add(P1).wrapping_add(P2), seed.wrapping_add(P2), seed, seed.wrapping_sub(P1)];
        while let Some((stripe, after)) = rest.split_first_chunk::<32>() {
            for (i, lane) in lanes.iter_mut().enumerate() {
                *lane = round(*lane, word(&stripe[8 * i..]));
            }
            rest = after;
        }
        let turns = [1, 7, 12, 18];
        let mut h =
            lanes.iter().zip(turns).fold(0_u64, |h, (lane, turn)| h.wrapping_add(lane.rotate_left(turn)));
        for lane in lanes {
            h = (h ^ round(0, lane)).wrapping_mul(P1).wrapping_add(P4);
        }
        h
    } else {
        seed.wrapping_add(P5)
    };
    h = h.wrapping_add(bytes.len() as u64);
    while let Some((eight, after)) = rest.split_first_chunk::<8>() {
        h = (h ^ round(0, word(eight))).rotate_left(27).wrapping_mul(P1).wrapping_add(P4);
        rest = after;
    }
    if let Some((four, after)) = rest.split_first_chunk::<4>() {
        let four = u64::from(u32::from_le_bytes(*four));
        h = (h ^ four.wrapping_mul(P1)).rotate_left(23).wrapping_mul(P2).wrapping_add(P3);
        rest = after;
    }
    for &byte in rest {
        h = (h ^ u64::from(byte).wrapping_mul(P5)).rotate_left(11).wrapping_mul(P1);
    }
    h = (h ^ (h >> 33)).wrapping_mul(P2);
    h = (h ^ (h >> 29)).wrapping_mul(P3);
    h ^ (h >> 32)
}

fn round(lane: u64, input: u64) -> u64 {
    lane.wrapping_add(input.wrapping_mul(P2)).rotate_left(31).wrapping_mul(P1)
}

fn word(bytes: &[u8]) -> u64 {
    let mut eight = [0; 8];
    eight.copy_from_slice(&bytes[..8]);
    u64::from_le_bytes(eight)
}

impl<M: AsRef<[Line]> + AsMut<[Line]>> World<M> {
    /// Hash of the whole state: equal for equal states, on every machine.
    pub fn checksum(&self) -> u64 {
        let mut sum = 0;
        for (_, part) in self.checksum_by_section() {
            sum = hash(&part.to_le_bytes(), sum);
        }
        sum
    }

    /// Hash of each section of the state, in order, with the section's name: where two worlds part.
    pub fn checksum_by_section(&self) -> impl Iterator<Item = (&'static str, u64)> + '_ {
        self.sections().into_iter().map(|section| (section.name, hash(section.live(self.state()), 0)))
    }

    /// Hash of a body with its motion and shapes.
    ///
    /// # Errors
    /// [`Error::Stale`].
    pub fn body_checksum(&self, body: BodyHandle) -> Result<u64, Error> {
        let slot = self.body_slot(body)?;
        let spans = &self.layout.state;
        let row = spans.bodies.of(self.state())[slot];
        let mut sum = hash(bytemuck::bytes_of(&spans.motions.of(self.state())[slot]), 0);
        sum = hash(bytemuck::bytes_of(&row), sum);
        for shape in self.shapes_of(body)? {
            sum = hash(bytemuck::bytes_of(&spans.shapes.of(self.state())[shape.index as usize]), sum);
        }
        Ok(sum)
    }
}

#[cfg(test)]
mod tests {
    use super::hash;

    #[test]
    fn published_vectors() {
        assert_eq!(hash(b"", 0), 0xEF46_DB37_51D8_E999);
        assert_eq!(hash(b"a", 0), 0xD24E_C4F1_A98C_6E5B);
        assert_eq!(hash(b"abc", 0), 0x44BC_2CF5_AD77_0999);
        assert_eq!(hash(b"Nobody inspects the spammish repetition", 0), 0xFBCE_A83C_8A37_8BF1);
    }
}
