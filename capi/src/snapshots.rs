//! Snapshots in buffers of C, and the ring.

use crate::border::{call, change, read, slice, slice_mut, there};
use crate::error::CsResult;
use crate::types::CsCapacities;
use crate::world::{CsWorld, Inner};
use cellstep::{Capacities, Error, Line, SnapshotRing};
use std::ffi::c_void;
use std::mem::MaybeUninit;

/// The last snapshots of a world. It lies at the start of the memory that was handed over.
pub struct CsRing(SnapshotRing<&'static mut [Line]>);

/// Lines of memory in front of the ring's own.
const FRONT: usize = size_of::<CsRing>().div_ceil(size_of::<Line>());

const _: () = assert!(align_of::<CsRing>() <= align_of::<Line>());

/// Bytes of a snapshot taken now.
#[unsafe(no_mangle)]
pub extern "C" fn cs_world_snapshot_bytes(
    world: Option<&CsWorld>,
    out: Option<&mut MaybeUninit<usize>>,
) -> CsResult {
    read(world, out, |world| Ok(world.snapshot_bytes()))
}

/// Bytes of the largest snapshot of a world with these capacities; 0 for capacities that are out of range.
#[unsafe(no_mangle)]
pub extern "C" fn cs_snapshot_bytes_max(capacities: Option<&CsCapacities>) -> usize {
    let capacities = capacities.map(|&capacities| Capacities::from(capacities));
    capacities.filter(|c| c.check().is_ok()).map_or(0, |c| c.snapshot_bytes_max())
}

/// Copies the state to a buffer of `bytes` initialised bytes and tells how many were written; `written` may be
/// null.
///
/// # Safety
/// See the top of the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cs_world_save(
    world: Option<&CsWorld>,
    buffer: *mut u8,
    bytes: usize,
    written: Option<&mut MaybeUninit<usize>>,
) -> CsResult {
    let mut unasked = MaybeUninit::uninit();
    read(world, Some(written.unwrap_or(&mut unasked)), |world: &Inner| {
        // SAFETY: C promises a buffer of `bytes` bytes that is ours during the call.
        let buffer = unsafe { slice_mut(buffer, bytes, "buffer")? };
        Ok(world.save(buffer)?)
    })
}

/// Writes the content hash into a snapshot that leaves the process, so that `cs_world_load` finds damage.
///
/// # Safety
/// See the top of the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cs_snapshot_seal(snapshot: *mut u8, bytes: usize) -> CsResult {
    call(|| {
        // SAFETY: C promises `bytes` bytes that are ours during the call.
        Ok(Inner::seal(unsafe { slice_mut(snapshot, bytes, "snapshot")? })?)
    })
}

/// Goes back to a snapshot that this world, or one with the same capacities and assets, has saved. Trusts the
/// bytes.
///
/// # Safety
/// See the top of the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cs_world_restore(
    world: Option<&mut CsWorld>,
    snapshot: *const u8,
    bytes: usize,
) -> CsResult {
    // SAFETY: C promises `bytes` bytes that nobody changes during the call.
    change(world, |world| Ok(world.restore(unsafe { slice(snapshot, bytes, "snapshot")? })?))
}

/// Takes a snapshot from anywhere: every row is checked.
///
/// # Safety
/// See the top of the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cs_world_load(
    world: Option<&mut CsWorld>,
    snapshot: *const u8,
    bytes: usize,
) -> CsResult {
    // SAFETY: C promises `bytes` bytes that nobody changes during the call.
    change(world, |world| Ok(world.load(unsafe { slice(snapshot, bytes, "snapshot")? })?))
}

/// Bytes of memory for a ring of `depth` snapshots; 0 for capacities that are out of range.
#[unsafe(no_mangle)]
pub extern "C" fn cs_ring_bytes(capacities: Option<&CsCapacities>, depth: usize) -> usize {
    let capacities = capacities.map(|&capacities| Capacities::from(capacities));
    let lines = capacities
        .filter(|c| c.check().is_ok())
        .and_then(|c| SnapshotRing::<Vec<Line>>::lines(&c, depth).checked_add(FRONT));
    lines.and_then(|lines| lines.checked_mul(size_of::<Line>())).unwrap_or(0)
}

/// Makes an empty ring in memory as for `cs_world_create`.
///
/// # Safety
/// See the top of the header, and the memory is left alone as long as the ring is used.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cs_ring_create(
    capacities: Option<&CsCapacities>,
    depth: usize,
    memory: *mut c_void,
    bytes: usize,
    out: Option<&mut MaybeUninit<*mut CsRing>>,
) -> CsResult {
    call(|| {
        let capacities = Capacities::from(*there(capacities, "capacities")?);
        let out = there(out, "out")?;
        // SAFETY: C promises `bytes` initialised bytes that are the ring's alone from now on.
        let lines: &'static mut [Line] =
            unsafe { slice_mut(memory.cast(), bytes / size_of::<Line>(), "memory")? };
        let given = lines.len();
        let Some((front, own)) = lines.split_at_mut_checked(FRONT) else {
            return Err(Error::MemoryTooSmall { needed: FRONT, given }.into());
        };
        let ring = SnapshotRing::new(own, &capacities, depth)?;
        let place: *mut CsRing = front.as_mut_ptr().cast();
        // SAFETY: the front is aligned to a line, has room for a ring, and nothing else uses it.
        unsafe { place.write(CsRing(ring)) };
        out.write(place);
        Ok(())
    })
}

/// Saves the world at its step, in the place of the oldest snapshot if the ring is full. Snapshots of this step and
/// of later ones are forgotten: they are of another future.
#[unsafe(no_mangle)]
pub extern "C" fn cs_ring_save(ring: Option<&mut CsRing>, world: Option<&CsWorld>) -> CsResult {
    call(|| Ok(there(ring, "ring")?.0.save(&there(world, "world")?.inner)?))
}

/// Goes back to the snapshot of a step.
#[unsafe(no_mangle)]
pub extern "C" fn cs_ring_restore(ring: Option<&CsRing>, world: Option<&mut CsWorld>, step: u64) -> CsResult {
    change(world, |world| Ok(there(ring, "ring")?.0.restore(world, step)?))
}
