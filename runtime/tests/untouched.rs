//! Room that no scene fills takes no memory. The only test of this process, since it looks at the memory of the
//! whole process.
#![cfg(all(target_os = "linux", not(loom)))]

use cellstep::{Capacities, new_world};
use std::fs;

/// Bytes of this process that are in memory now.
fn resident() -> usize {
    let status = fs::read_to_string("/proc/self/status").expect("proc is mounted");
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:")).expect("the kernel tells");
    let number = line.trim().strip_suffix("kB").expect("in kilobytes").trim();
    number.parse::<usize>().expect("a number") * 1024
}

/// Only without steps: builds with debug assertions, as tests are, write all scratch before each.
#[test]
fn worlds_take_only_what_they_fill() {
    let capacities = Capacities::for_bodies(20_000);
    let whole = capacities.lines() * size_of::<cellstep::Line>();
    let before = resident();
    let world = new_world(capacities).expect("hundreds of megabytes of addresses");
    let grown = resident().saturating_sub(before);
    // The state is zeroed, whoever gave the memory; the rest is larger by far.
    assert!(world.state().len() < whole / 4, "{} of {whole}", world.state().len());
    assert!(grown < world.state().len() + whole / 10, "{grown} of {whole} bytes for an empty world");
}
