//! Bytes into the reader of MJCF; a model that becomes a scene takes 60 steps.
//!
//! `cargo +nightly fuzz run mjcf fuzz/found/mjcf fuzz/corpus/mjcf`: finds go to the first folder, which must
//! exist; the seeds in the second are kept.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    cellstep_tests::fuzzing::mjcf(bytes);
});
