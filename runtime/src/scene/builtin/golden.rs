//! Checksums that the built-in scenes have everywhere: on any machine, with any number of workers, in any build.
//!
//! The table is `checksums.txt`: name, golden size, checksum. The test `invariance` compares it with this machine
//! and writes it anew when a change of behaviour is meant, so it cannot be another than that of the release.

use super::Builtin;

/// Steps after which the checksums are taken.
pub const GOLDEN_STEPS: u32 = 300;

const TABLE: &str = include_str!("checksums.txt");

impl Builtin {
    /// [`World::checksum`](cellstep_core::World::checksum) of the scene in its golden size after [`GOLDEN_STEPS`]
    /// steps, as it was when this version was made. `None` for a scene that the table does not have.
    pub fn golden_checksum(&self) -> Option<u64> {
        find(TABLE, self.name, self.golden_size)
    }
}

fn find(table: &str, name: &str, size: u32) -> Option<u64> {
    table.lines().find_map(|line| {
        let mut words = line.split(' ');
        let is_it = words.next() == Some(name) && words.next()?.parse() == Ok(size);
        is_it.then(|| u64::from_str_radix(words.next()?, 16).ok()).flatten()
    })
}

#[cfg(test)]
mod tests {
    use super::super::BUILTIN;
    use super::*;

    #[test]
    fn every_scene_has_a_checksum_of_its_own() {
        let mut sums: Vec<u64> = BUILTIN.iter().map(|builtin| builtin.golden_checksum().unwrap()).collect();
        assert_eq!(TABLE.lines().count(), sums.len());
        sums.sort();
        sums.dedup();
        assert_eq!(sums.len(), BUILTIN.len());
    }

    #[test]
    fn name_and_size_are_looked_for() {
        let table = "a 10 00000000000000ff\nab 7 0000000000000001\n";
        assert_eq!(find(table, "a", 10), Some(255));
        assert_eq!(find(table, "ab", 7), Some(1));
        assert_eq!((find(table, "a", 7), find(table, "b", 7), find("a 10", "a", 10)), (None, None, None));
    }
}
