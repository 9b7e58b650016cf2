//! FNV-1a, 64 bits: a hash that shares nothing with the core's.

const PRIME: u64 = 0x0100_0000_01b3;
/// The hash of nothing.
pub(crate) const START: u64 = 0xcbf2_9ce4_8422_2325;

/// Goes on with a word.
pub(crate) fn word(sum: u64, word: u64) -> u64 {
    (sum ^ word).wrapping_mul(PRIME)
}

/// Goes on with a number's bits; all not-a-numbers count as one, since machines differ in theirs.
pub(crate) fn number(sum: u64, x: f32) -> u64 {
    word(sum, u64::from(if x.is_nan() { 0x7fc0_0000 } else { x.to_bits() }))
}

/// Hash of some bytes.
pub(crate) fn bytes(bytes: &[u8]) -> u64 {
    bytes.iter().fold(START, |sum, &byte| word(sum, u64::from(byte)))
}
