//! Addresses from C become slices here, and panics end here.
//!
//! C promises what the crate's page says: a pointer that is not null points to as many initialised things as the
//! function documents, nobody else uses them during the call, and memory of a world or a ring is left alone as long
//! as that is used. What can be checked is checked: null and alignment.

use crate::error::{CsResult, Failure, remember};
use crate::world::{CsWorld, Inner};
use bytemuck::AnyBitPattern;
use cellstep::Error;
use std::mem::MaybeUninit;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// The `count` things at an address; none when none are asked for, whatever the address.
///
/// # Safety
/// Not null, it points to `count` initialised things that nobody changes for `'a`.
pub(crate) unsafe fn slice<'a, T: AnyBitPattern>(
    start: *const T,
    count: usize,
    name: &'static str,
) -> Result<&'a [T], Failure> {
    if count == 0 {
        return Ok(&[]);
    }
    check(start, count, name)?;
    // SAFETY: not null, aligned, not longer than memory can be; the caller promises the rest.
    Ok(unsafe { std::slice::from_raw_parts(start, count) })
}

/// Room for `count` things at an address, initialised or not.
///
/// # Safety
/// Not null, it points to room for `count` things that nobody else uses for `'a`.
pub(crate) unsafe fn room<'a, T>(
    start: *mut T,
    count: usize,
    name: &'static str,
) -> Result<&'a mut [MaybeUninit<T>], Failure> {
    if count == 0 {
        return Ok(&mut []);
    }
    check(start, count, name)?;
    // SAFETY: not null, aligned, not longer than memory can be; the caller promises the rest, and `MaybeUninit`
    // asks for no content.
    Ok(unsafe { std::slice::from_raw_parts_mut(start.cast(), count) })
}

/// The `count` things at an address, to read and write.
///
/// # Safety
/// Not null, it points to `count` initialised things that nobody else uses for `'a`.
pub(crate) unsafe fn slice_mut<'a, T: AnyBitPattern>(
    start: *mut T,
    count: usize,
    name: &'static str,
) -> Result<&'a mut [T], Failure> {
    if count == 0 {
        return Ok(&mut []);
    }
    check(start, count, name)?;
    // SAFETY: not null, aligned, not longer than memory can be; the caller promises the rest.
    Ok(unsafe { std::slice::from_raw_parts_mut(start, count) })
}

fn check<T>(start: *const T, count: usize, name: &'static str) -> Result<(), Failure> {
    if start.is_null() {
        return Err(Failure::Null(name));
    }
    if !start.is_aligned() {
        return Err(Failure::Misaligned(name));
    }
    let fits = count.checked_mul(size_of::<T>()).is_some_and(|bytes| isize::try_from(bytes).is_ok());
    if fits { Ok(()) } else { Err(Error::OutOfRange { name }.into()) }
}

/// Runs a call. Whatever it throws stays here.
pub(crate) fn call(run: impl FnOnce() -> Result<(), Failure>) -> CsResult {
    match catch_unwind(AssertUnwindSafe(run)) {
        Ok(Ok(())) => CsResult::Ok,
        Ok(Err(failure)) => {
            remember(&failure);
            failure.code()
        }
        Err(payload) => {
            remember("a bug of the engine: it has panicked");
            // A payload whose own drop panics would unwind into C.
            std::mem::forget(payload);
            CsResult::Panicked
        }
    }
}

/// A thing that must be there.
pub(crate) fn there<T>(thing: Option<T>, name: &'static str) -> Result<T, Failure> {
    thing.ok_or(Failure::Null(name))
}

/// Runs a call that changes a world. One that panics leaves a world that is not used any more.
pub(crate) fn change(
    world: Option<&mut CsWorld>,
    run: impl FnOnce(&mut Inner) -> Result<(), Failure>,
) -> CsResult {
    let Some(world) = world else { return call(|| Err(Failure::Null("world"))) };
    if world.is_broken {
        return broken();
    }
    let result = call(|| run(&mut world.inner));
    world.is_broken = result == CsResult::Panicked;
    result
}

/// Runs a call that changes a world and gives something.
pub(crate) fn make<T>(
    world: Option<&mut CsWorld>,
    out: Option<&mut MaybeUninit<T>>,
    run: impl FnOnce(&mut Inner) -> Result<T, Failure>,
) -> CsResult {
    change(world, |world| {
        let out = there(out, "out")?;
        out.write(run(world)?);
        Ok(())
    })
}

/// Runs a call that reads a world and gives something.
pub(crate) fn read<T>(
    world: Option<&CsWorld>,
    out: Option<&mut MaybeUninit<T>>,
    run: impl FnOnce(&Inner) -> Result<T, Failure>,
) -> CsResult {
    if world.is_some_and(|world| world.is_broken) {
        return broken();
    }
    call(|| {
        let (world, out) = (there(world, "world")?, there(out, "out")?);
        out.write(run(&world.inner)?);
        Ok(())
    })
}

fn broken() -> CsResult {
    remember("the world is not to be used: an earlier call has panicked");
    CsResult::Panicked
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::cs_error_message;
    use crate::types::cs_capacities;
    use crate::world::{cs_world_bytes, cs_world_create, cs_world_step, cs_world_steps};
    use cellstep::Line;
    use std::ffi::CStr;

    fn message() -> &'static str {
        // SAFETY: the message ends in a zero byte, and no call fails while it is read here.
        unsafe { CStr::from_ptr(cs_error_message()) }.to_str().expect("messages are text")
    }

    #[test]
    fn a_panic_ends_at_the_border() {
        let capacities = cs_capacities(1);
        let bytes = cs_world_bytes(Some(&capacities));
        let mut memory = vec![Line::ZERO; bytes / 64];
        let mut place = MaybeUninit::uninit();
        // SAFETY: the memory is initialised, aligned, and outlives the world.
        let made = unsafe {
            cs_world_create(Some(&capacities), memory.as_mut_ptr().cast(), bytes, Some(&mut place))
        };
        assert_eq!(made, CsResult::Ok);
        // SAFETY: the call has written it, and nobody else uses it.
        let mut world = Some(unsafe { &mut *place.assume_init() });
        assert_eq!(cs_world_step(world.as_deref_mut(), None, None), CsResult::Ok);
        assert_eq!(change(world.as_deref_mut(), |_| panic!("on purpose")), CsResult::Panicked);
        assert!(message().contains("bug of the engine"), "{}", message());
        assert_eq!(cs_world_step(world.as_deref_mut(), None, None), CsResult::Panicked);
        let mut steps = MaybeUninit::uninit();
        assert_eq!(cs_world_steps(world.as_deref(), Some(&mut steps)), CsResult::Panicked);
        assert!(message().contains("not to be used"), "{}", message());
    }

    #[test]
    fn long_messages_are_cut_off() {
        remember("\u{e4}".repeat(400));
        assert!(message().len() > 200 && message().chars().all(|c| c == '\u{e4}'));
        remember("short");
        assert_eq!(message(), "short");
    }
}
