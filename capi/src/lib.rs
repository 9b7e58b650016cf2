//! The engine for C: worlds on caller-owned memory, snapshots in caller-owned buffers, errors as codes.
//!
//! The header is `include/cellstep.h`, made by cbindgen; `examples/game.c` is a game loop. Every function returns
//! a [`CsResult`](error::CsResult), unless it cannot fail; after an error `cs_error_message` says more. Nothing is
//! unwound into C: a panic, which is a bug of the engine, ends in `CS_RESULT_PANICKED`.
//!
//! **What C promises** stands at the top of the header (`cbindgen.toml`): a pointer is null or points to as many
//! valid, aligned things of its type as its function says, which nobody else uses during the call; memory that is
//! read is initialised. Where null is not allowed it is answered by `CS_RESULT_NULL_POINTER`.
//!
//! References in signatures stand for pointers that may be null; results go to `MaybeUninit`, so that C need not
//! set them before. All that remains unsafe is to turn an address and a length into a slice (`border.rs`), and to
//! put a world, a ring or a pool at an address.

pub mod assets;
pub mod bodies;
mod border;
pub mod error;
pub mod events;
pub mod joints;
pub mod queries;
pub mod shapes;
pub mod snapshots;
pub mod types;
pub mod world;
