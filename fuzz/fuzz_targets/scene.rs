//! Bytes into the scene reader; what it accepts takes 60 steps.
//!
//! `cargo +nightly fuzz run scene fuzz/found/scene fuzz/corpus/scene`: finds go to the first folder, which must
//! exist; the seeds in the second are kept.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    cellstep_tests::fuzzing::scene(bytes);
});
