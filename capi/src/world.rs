//! Worlds in memory that C hands over, steps, and the pool of threads.

use crate::border::{call, change, make, read, there};
use crate::error::{CsResult, Failure};
use crate::types::{CsCapacities, CsReport, CsSettings};
use cellstep::{Capacities, Error, Line, Pool, Serial, World};
use std::ffi::c_void;
use std::mem::MaybeUninit;

/// The engine's world, in memory of C.
pub(crate) type Inner = World<&'static mut [Line]>;

/// A world. It lies at the start of the memory that was handed over: there is nothing to destroy, the memory is
/// given back when the world is not used any more.
pub struct CsWorld {
    pub(crate) inner: Inner,
    /// A call has panicked.
    pub(crate) is_broken: bool,
}

/// Threads that share the work of a step.
pub struct CsPool(Pool);

/// Lines of memory in front of the world's own.
const FRONT: usize = size_of::<CsWorld>().div_ceil(size_of::<Line>());

const _: () = assert!(align_of::<CsWorld>() <= align_of::<Line>());

/// Bytes of memory that `cs_world_create` needs; 0 for capacities that are out of range.
#[unsafe(no_mangle)]
pub extern "C" fn cs_world_bytes(capacities: Option<&CsCapacities>) -> usize {
    let lines = capacities.map(|&capacities| Capacities::from(capacities)).and_then(|capacities| {
        capacities.check().ok()?;
        FRONT.checked_add(capacities.lines())
    });
    lines.and_then(|lines| lines.checked_mul(size_of::<Line>())).unwrap_or(0)
}

/// Makes an empty world with default settings in `bytes` bytes of memory that start on a border of 64 and are
/// initialised, with whatever (`calloc` and static memory are; of a large zeroed block only what is used takes
/// room). They belong to the world until it is not used any more.
///
/// # Safety
/// See the top of the header, and the memory is left alone as long as the world is used.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cs_world_create(
    capacities: Option<&CsCapacities>,
    memory: *mut c_void,
    bytes: usize,
    out: Option<&mut MaybeUninit<*mut CsWorld>>,
) -> CsResult {
    call(|| {
        let capacities = Capacities::from(*there(capacities, "capacities")?);
        let out = there(out, "out")?;
        capacities.check()?;
        // SAFETY: C promises `bytes` initialised bytes that are the world's alone from now on.
        let lines: &'static mut [Line] =
            unsafe { crate::border::slice_mut(memory.cast(), bytes / size_of::<Line>(), "memory")? };
        let (needed, given) = (FRONT + capacities.lines(), lines.len());
        if given < needed {
            return Err(Error::MemoryTooSmall { needed, given }.into());
        }
        let (front, own) = lines.split_at_mut(FRONT);
        let inner = World::new(own, capacities)?;
        let place: *mut CsWorld = front.as_mut_ptr().cast();
        // SAFETY: the front is aligned to a line, has room for a world, and nothing else uses it.
        unsafe { place.write(CsWorld { inner, is_broken: false }) };
        out.write(place);
        Ok(())
    })
}

/// The settings of a new world.
#[unsafe(no_mangle)]
pub extern "C" fn cs_settings_default() -> CsSettings {
    cellstep::Settings::default().into()
}

/// Turns the dial of some settings to a preset, `CS_PRESET_*`: substeps, sweeps and the model of contacts. Fields
/// that trade no speed for accuracy (time step, gravity, sleep, events and others) stay. On an error none changes.
#[unsafe(no_mangle)]
pub extern "C" fn cs_settings_apply_preset(settings: Option<&mut CsSettings>, preset: u32) -> CsResult {
    call(|| {
        let settings = there(settings, "settings")?;
        let preset = crate::types::preset(preset)?;
        let mut turned = settings.read()?;
        preset.apply(&mut turned);
        *settings = turned.into();
        Ok(())
    })
}

/// The settings.
#[unsafe(no_mangle)]
pub extern "C" fn cs_world_settings(
    world: Option<&CsWorld>,
    out: Option<&mut MaybeUninit<CsSettings>>,
) -> CsResult {
    read(world, out, |world| Ok(world.settings().into()))
}

/// Changes the settings. Other gravity wakes all bodies.
#[unsafe(no_mangle)]
pub extern "C" fn cs_world_set_settings(
    world: Option<&mut CsWorld>,
    settings: Option<&CsSettings>,
) -> CsResult {
    change(world, |world| {
        let settings = there(settings, "settings")?.read()?;
        Ok(world.set_settings(&settings)?)
    })
}

/// Takes one step, on the threads of a pool or, where `pool` is null, on this one: the result is the same. `report`
/// may be null.
#[unsafe(no_mangle)]
pub extern "C" fn cs_world_step(
    world: Option<&mut CsWorld>,
    pool: Option<&mut CsPool>,
    report: Option<&mut MaybeUninit<CsReport>>,
) -> CsResult {
    change(world, |world| {
        let told = match pool {
            Some(pool) => world.step(&mut pool.0),
            None => world.step(&mut Serial),
        };
        if let Some(report) = report {
            report.write(told.into());
        }
        Ok(())
    })
}

/// Steps taken.
#[unsafe(no_mangle)]
pub extern "C" fn cs_world_steps(world: Option<&CsWorld>, out: Option<&mut MaybeUninit<u64>>) -> CsResult {
    read(world, out, |world| Ok(world.steps()))
}

/// Hash of the whole state: equal for equal states, on every machine.
#[unsafe(no_mangle)]
pub extern "C" fn cs_world_checksum(world: Option<&CsWorld>, out: Option<&mut MaybeUninit<u64>>) -> CsResult {
    read(world, out, |world| Ok(world.checksum()))
}

/// The deepest overlap of any contact, metres.
#[unsafe(no_mangle)]
pub extern "C" fn cs_world_penetration_max(
    world: Option<&mut CsWorld>,
    out: Option<&mut MaybeUninit<f32>>,
) -> CsResult {
    make(world, out, |world| Ok(world.penetration_max()))
}

/// Starts a pool of so many workers, this thread included. The one thing beside its threads that takes memory of
/// its own; given back by `cs_pool_destroy`.
#[unsafe(no_mangle)]
pub extern "C" fn cs_pool_create(workers: usize, out: Option<&mut MaybeUninit<*mut CsPool>>) -> CsResult {
    call(|| {
        let out = there(out, "out")?;
        let pool = Pool::new(workers).map_err(Failure::Pool)?;
        out.write(Box::into_raw(Box::new(CsPool(pool))));
        Ok(())
    })
}

/// Ends the threads of a pool. Null is left alone.
///
/// # Safety
/// The pool is from `cs_pool_create`, and is not used any more.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cs_pool_destroy(pool: *mut CsPool) -> CsResult {
    call(|| {
        if !pool.is_null() {
            // SAFETY: C promises that it is from `cs_pool_create`, which made it from a box, and that this is its
            // end.
            drop(unsafe { Box::from_raw(pool) });
        }
        Ok(())
    })
}
