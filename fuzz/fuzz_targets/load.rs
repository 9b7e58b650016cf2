//! Bytes into a small world's `load`; what it accepts takes 60 steps.
//!
//! `cargo +nightly fuzz run load fuzz/found/load fuzz/corpus/load`: finds go to the first folder, which must exist;
//! the seeds in the second are kept.
#![no_main]

use cellstep_tests::fuzzing;
use std::cell::RefCell;

thread_local! {
    static WORLD: RefCell<cellstep_tests::worlds::OwnedWorld> = RefCell::new(fuzzing::load_world());
}

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    // A refusal is as good as a load: the oracle checks both.
    let _ = WORLD.with_borrow_mut(|world| fuzzing::load(world, bytes));
});
