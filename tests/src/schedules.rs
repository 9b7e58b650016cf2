//! Schedulers for tests.
