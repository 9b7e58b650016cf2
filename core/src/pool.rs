//! Slots that are taken lowest first, so that equal histories give equal bytes.

use bytemuck::{Pod, Zeroable};

/// Marks of one pool; part of the state. The occupancy bitset and the generations are arrays beside it.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub(crate) struct Marks {
    /// Slots in use.
    pub count: u32,
    /// One above the highest slot ever used: rows from here on are zero.
    pub high: u32,
    /// Lowest free slot.
    pub first_free: u32,
    /// Zero.
    pub reserved: u32,
}

/// Words of an occupancy bitset for `slots`.
pub(crate) const fn words(slots: usize) -> usize {
    slots.div_ceil(64)
}

/// True when `slot` is in use.
#[inline(always)]
pub(crate) fn is_used(used: &[u64], slot: u32) -> bool {
    let word = (slot / 64) as usize;
    word < used.len() && (used[word] >> (slot % 64)) & 1 == 1
}

/// Takes the lowest free slot of `capacity`, or `None` when all are taken. Raises the slot's generation.
pub(crate) fn acquire(marks: &mut Marks, used: &mut [u64], generations: &mut [u32]) -> Option<u32> {
    let slot = marks.first_free;
    if slot as usize >= generations.len() {
        return None;
    }
    used[(slot / 64) as usize] |= 1 << (slot % 64);
    let generation = &mut generations[slot as usize];
    *generation = if *generation == u32::MAX { 1 } else { *generation + 1 };
    marks.count += 1;
    marks.high = marks.high.max(slot + 1);
    marks.first_free = next_free(used, slot + 1, generations.len() as u32);
    Some(slot)
}

/// Gives a slot back. The caller zeroes its rows.
pub(crate) fn release(marks: &mut Marks, used: &mut [u64], slot: u32) {
    debug_assert!(is_used(used, slot));
    used[(slot / 64) as usize] &= !(1 << (slot % 64));
    marks.count -= 1;
    marks.first_free = marks.first_free.min(slot);
}

/// The lowest free slot from `from` on; `capacity` when there is none.
pub(crate) fn next_free(used: &[u64], from: u32, capacity: u32) -> u32 {
    let mut slot = from;
    while slot < capacity {
        let free = !used[(slot / 64) as usize] >> (slot % 64);
        if free != 0 {
            return (slot + free.trailing_zeros()).min(capacity);
        }
        slot = (slot / 64 + 1) * 64;
    }
    capacity
}

/// Slots in use, ascending.
pub(crate) fn iterate(used: &[u64], high: u32) -> impl Iterator<Item = u32> + '_ {
    (0..words(high as usize)).flat_map(move |word| {
        let mut bits = used[word];
        core::iter::from_fn(move || {
            if bits == 0 {
                return None;
            }
            let bit = bits.trailing_zeros();
            bits &= bits - 1;
            Some(word as u32 * 64 + bit)
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lowest_free_slot_first() {
        let (mut marks, mut used, mut generations) = (Marks::default(), [0u64; 2], [0u32; 70]);
        for expected in 0..70 {
            assert_eq!(acquire(&mut marks, &mut used, &mut generations), Some(expected));
        }
        assert_eq!(acquire(&mut marks, &mut used, &mut generations), None);
        release(&mut marks, &mut used, 66);
        release(&mut marks, &mut used, 3);
        assert_eq!(acquire(&mut marks, &mut used, &mut generations), Some(3));
        assert_eq!(acquire(&mut marks, &mut used, &mut generations), Some(66));
        assert_eq!((generations[3], generations[66], generations[4]), (2, 2, 1));
        release(&mut marks, &mut used, 0);
        assert!(iterate(&used, marks.high).eq(1..70));
    }
}
