//! Bytes into the reader of replays; what it takes is played.
//!
//! `cargo +nightly fuzz run replay fuzz/found/replay fuzz/corpus/replay`: finds go to the first folder, which must
//! exist; the seeds in the second are kept.
#![no_main]

use cellstep_tests::fuzzing;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    fuzzing::replay(bytes);
    // With right checksums changes get past them.
    fuzzing::replay(&fuzzing::resealed_replay(bytes));
});
