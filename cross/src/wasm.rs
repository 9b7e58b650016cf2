//! The entry for WebAssembly, to be called without bindings: numbers in, numbers out.
#![allow(unsafe_code, reason = "exported symbols; nothing else in this module of its own has their names")]

use cellstep_core::Line;
use cellstep_cross::{lines, scenes};

/// The checksum of scene number `scene` after `steps` steps.
#[unsafe(no_mangle)]
pub extern "C" fn run(scene: u32, steps: u32) -> u64 {
    let scene = &scenes::ALL[scene as usize];
    cellstep_cross::run(&mut vec![Line::ZERO; lines(scene)], scene, steps).checksum
}

/// A line to compare: its address in the upper half, its length in bytes in the lower; 0 after the last.
///
/// The line is never freed.
#[unsafe(no_mangle)]
pub extern "C" fn line(index: u32, steps: u32) -> u64 {
    cellstep_cross::line(index as usize, steps).map_or(0, |text| {
        let bytes = text.leak().as_bytes();
        (bytes.as_ptr().addr() as u64) << 32 | bytes.len() as u64
    })
}
