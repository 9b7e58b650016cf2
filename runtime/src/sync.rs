//! The threads, locks, atomics and cells of the pool, from `std` or from loom.
//!
//! Loom runs a model under every order that the memory model allows, which needs its own versions of all of
//! them (`--cfg loom`, see `epoch.rs`). The parker of a loom build is a flag under loom's mutex, so that
//! parking is inside the model; the parker of an ordinary build is crossbeam's, with the same contract:
//! `unpark` leaves one token, `park` waits for it and takes it, and everything before `unpark` happens before
//! what follows `park`.

pub(crate) use imp::*;
// Counting references is not what the models are about, and loom's own would multiply the interleavings.
pub(crate) use std::sync::Arc;

#[cfg(not(loom))]
mod imp {
    pub(crate) use crossbeam_utils::sync::{Parker, Unparker};
    pub(crate) use std::sync::Mutex;
    pub(crate) use std::sync::atomic::{AtomicBool, AtomicU32, AtomicU64};
    pub(crate) use std::thread;

    /// Loom's interface to a cell: the access lasts as long as the closure runs.
    pub(crate) struct UnsafeCell<T>(std::cell::UnsafeCell<T>);

    impl<T> UnsafeCell<T> {
        pub(crate) fn new(value: T) -> Self {
            UnsafeCell(std::cell::UnsafeCell::new(value))
        }

        /// For reading through the pointer.
        #[inline]
        pub(crate) fn with<R>(&self, read: impl FnOnce(*const T) -> R) -> R {
            read(self.0.get())
        }

        /// For writing through the pointer.
        #[inline]
        pub(crate) fn with_mut<R>(&self, write: impl FnOnce(*mut T) -> R) -> R {
            write(self.0.get())
        }
    }
}

#[cfg(loom)]
mod imp {
    pub(crate) use loom::cell::UnsafeCell;
    pub(crate) use loom::sync::atomic::{AtomicBool, AtomicU32, AtomicU64};
    pub(crate) use loom::sync::{Condvar, Mutex};
    pub(crate) use loom::thread;

    use super::Arc;

    struct Token {
        given: Mutex<bool>,
        changed: Condvar,
    }

    /// Waits for the token.
    pub(crate) struct Parker(Unparker);

    /// Gives the token.
    #[derive(Clone)]
    pub(crate) struct Unparker(Arc<Token>);

    impl Parker {
        pub(crate) fn new() -> Self {
            Parker(Unparker(Arc::new(Token { given: Mutex::new(false), changed: Condvar::new() })))
        }

        pub(crate) fn unparker(&self) -> &Unparker {
            &self.0
        }

        pub(crate) fn park(&self) {
            let token = &self.0.0;
            let mut given = token.given.lock().expect("no one panics with the lock");
            while !*given {
                given = token.changed.wait(given).expect("no one panics with the lock");
            }
            *given = false;
        }
    }

    impl Unparker {
        pub(crate) fn unpark(&self) {
            let mut given = self.0.given.lock().expect("no one panics with the lock");
            *given = true;
            self.0.changed.notify_one();
        }
    }
}
