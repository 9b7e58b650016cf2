//! Rays, casts, overlaps and closest points in the world as it is now.

use crate::border::{make, room, there};
use crate::error::{CsResult, Failure};
use crate::shapes::{CsFilter, CsGeometry};
use crate::types::{CS_ALL_BITS, CsBody, CsPosition, CsRotation, CsShape, CsVec3, body_kinds, same};
use crate::world::CsWorld;
use cellstep::{
    BodyKinds, ClosestPoint, Error, Found, Hit, Overlap, Probe, Queries, QueryFilter, QueryShape, Ray,
    Region, ShapeCast,
};
use std::mem::MaybeUninit;

/// What a query looks for; start from `cs_query_filter`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CsQueryFilter {
    /// 1 to find only shapes whose filter meets `meets`.
    pub has_meets: u32,
    /// Taken with `has_meets`.
    pub meets: CsFilter,
    /// The shapes of this body are not found; zeros for none.
    pub skip: CsBody,
    /// Shapes of bodies of these kinds, `CS_*_BIT`.
    pub kinds: u32,
    /// 1 to find sensors, too.
    pub sensors: u32,
}

/// Everything but sensors.
#[unsafe(no_mangle)]
pub extern "C" fn cs_query_filter() -> CsQueryFilter {
    CsQueryFilter {
        has_meets: 0,
        meets: cellstep::Filter::default().into(),
        skip: CsBody::default(),
        kinds: CS_ALL_BITS,
        sensors: 0,
    }
}

/// Null stands for everything but sensors.
fn read_filter(filter: Option<&CsQueryFilter>) -> Result<QueryFilter, Failure> {
    let Some(filter) = filter else { return Ok(QueryFilter::ALL) };
    let BodyKinds(kinds) = body_kinds(filter.kinds)?;
    Ok(QueryFilter {
        meets: (filter.has_meets != 0).then(|| filter.meets.into()),
        skip: (filter.skip != CsBody::default()).then(|| filter.skip.into()),
        kinds: BodyKinds(kinds),
        sensors: filter.sensors != 0,
    })
}

/// Where a ray or a moving shape meets a shape.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CsHit {
    /// The shape.
    pub shape: CsShape,
    /// The body.
    pub body: CsBody,
    /// The triangle of a mesh, the child of a compound; 0 else.
    pub child: u32,
    /// How far the query came, metres.
    pub distance: f32,
    /// The same as a share of its way.
    pub fraction: f32,
    /// Where they meet; the start when it starts inside.
    pub point: CsPosition,
    /// Unit normal of the shape there.
    pub normal: CsVec3,
}

/// A shape that overlaps a region.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CsOverlap {
    /// The shape.
    pub shape: CsShape,
    /// The body.
    pub body: CsBody,
    /// The triangle of a mesh, the child of a compound; 0 else.
    pub child: u32,
}

/// The point of a shape that is closest to a place.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CsClosest {
    /// The shape.
    pub shape: CsShape,
    /// The body.
    pub body: CsBody,
    /// The triangle of a mesh, the child of a compound; 0 else.
    pub child: u32,
    /// Metres; 0 inside.
    pub distance: f32,
    /// The point; the place itself inside.
    pub point: CsPosition,
    /// Unit vector from there to the place; zero inside.
    pub normal: CsVec3,
}

same! {
    CsHit = Hit { shape, body, child, distance, fraction, point, normal },
    CsOverlap = Overlap { shape, body, child },
    CsClosest = ClosestPoint { shape, body, child, distance, point, normal },
}

/// How much a query found.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CsFound {
    /// Entries at the front of the buffer, in order.
    pub count: usize,
    /// What found no room: all of it comes after the last entry.
    pub dropped: usize,
}

/// A shape with an inside, somewhere.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CsQueryShape {
    /// Its geometry.
    pub geometry: CsGeometry,
    /// Where its origin is.
    pub position: CsPosition,
    /// How it is turned; a unit quaternion within 1e-3.
    pub rotation: CsRotation,
}

impl CsQueryShape {
    fn read(&self) -> Result<QueryShape, Failure> {
        let geometry = self.geometry.read()?;
        Ok(QueryShape { geometry, position: self.position.into(), rotation: self.rotation.into() })
    }
}

/// Entries that need no memory of their own.
const FEW: usize = 64;

/// Runs a query into the caller's buffer. The engine's entries and C's are not of one type, so they pass through a
/// buffer here.
fn fill<T: Copy + Default + Into<C>, C>(
    room: &mut [MaybeUninit<C>],
    run: impl FnOnce(&mut [T]) -> Result<Found, Error>,
) -> Result<CsFound, Failure> {
    let (mut few, mut many) = ([T::default(); FEW], Vec::new());
    let buffer = match few.get_mut(..room.len()) {
        Some(few) => few,
        None => {
            many.resize(room.len(), T::default());
            &mut many[..]
        }
    };
    let found = run(buffer)?;
    for (place, entry) in room.iter_mut().zip(&buffer[..found.count]) {
        place.write((*entry).into());
    }
    Ok(CsFound { count: found.count, dropped: found.dropped })
}

/// The nearest, if any.
fn first<T, C: From<T>>(found: Option<T>, out: Option<&mut MaybeUninit<C>>) -> Result<u32, Failure> {
    let out = there(out, "out")?;
    Ok(u32::from(found.map(|found| out.write(found.into())).is_some()))
}

fn ray(origin: CsPosition, way: CsVec3) -> Ray {
    Ray { origin: origin.into(), translation: way.into() }
}

/// The first shape on a ray from `origin` to `origin + way`. `found` becomes 1 and `hit` is written, or `found`
/// becomes 0. `filter` may be null.
#[unsafe(no_mangle)]
pub extern "C" fn cs_cast_ray(
    world: Option<&mut CsWorld>,
    origin: CsPosition,
    way: CsVec3,
    filter: Option<&CsQueryFilter>,
    hit: Option<&mut MaybeUninit<CsHit>>,
    found: Option<&mut MaybeUninit<u32>>,
) -> CsResult {
    make(world, found, |world| {
        let filter = read_filter(filter)?;
        first(world.queries().cast_ray(&ray(origin, way), &filter)?, hit)
    })
}

/// All shapes on a ray by distance, as far as `room_for` of them go.
///
/// # Safety
/// See the top of the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cs_cast_ray_all(
    world: Option<&mut CsWorld>,
    origin: CsPosition,
    way: CsVec3,
    filter: Option<&CsQueryFilter>,
    hits: *mut CsHit,
    room_for: usize,
    found: Option<&mut MaybeUninit<CsFound>>,
) -> CsResult {
    make(world, found, |world| {
        let filter = read_filter(filter)?;
        // SAFETY: C promises room for `room_for` hits that is ours during the call.
        let room = unsafe { room(hits, room_for, "hits")? };
        fill(room, |hits| world.queries().cast_ray_all(&ray(origin, way), &filter, hits))
    })
}

/// The first shape that a shape meets on its way, which it goes without turning.
#[unsafe(no_mangle)]
pub extern "C" fn cs_cast_shape(
    world: Option<&mut CsWorld>,
    shape: Option<&CsQueryShape>,
    way: CsVec3,
    filter: Option<&CsQueryFilter>,
    hit: Option<&mut MaybeUninit<CsHit>>,
    found: Option<&mut MaybeUninit<u32>>,
) -> CsResult {
    make(world, found, |world| {
        let filter = read_filter(filter)?;
        let cast = ShapeCast { shape: there(shape, "shape")?.read()?, translation: way.into() };
        first(world.queries().cast_shape(&cast, &filter)?, hit)
    })
}

/// All shapes that a shape meets on its way by distance, as far as `room_for` of them go.
///
/// # Safety
/// See the top of the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cs_cast_shape_all(
    world: Option<&mut CsWorld>,
    shape: Option<&CsQueryShape>,
    way: CsVec3,
    filter: Option<&CsQueryFilter>,
    hits: *mut CsHit,
    room_for: usize,
    found: Option<&mut MaybeUninit<CsFound>>,
) -> CsResult {
    make(world, found, |world| {
        let filter = read_filter(filter)?;
        let cast = ShapeCast { shape: there(shape, "shape")?.read()?, translation: way.into() };
        // SAFETY: C promises room for `room_for` hits that is ours during the call.
        let room = unsafe { room(hits, room_for, "hits")? };
        fill(room, |hits| world.queries().cast_shape_all(&cast, &filter, hits))
    })
}

fn overlap_all(
    queries: &Queries<'_>,
    region: &Region,
    filter: &QueryFilter,
    room: &mut [MaybeUninit<CsOverlap>],
) -> Result<CsFound, Failure> {
    fill(room, |overlaps| queries.overlap_all(region, filter, overlaps))
}

/// All shapes that overlap a shape, by slot, as far as `room_for` of them go.
///
/// # Safety
/// See the top of the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cs_overlap_shape(
    world: Option<&mut CsWorld>,
    shape: Option<&CsQueryShape>,
    filter: Option<&CsQueryFilter>,
    overlaps: *mut CsOverlap,
    room_for: usize,
    found: Option<&mut MaybeUninit<CsFound>>,
) -> CsResult {
    make(world, found, |world| {
        let region = Region::Shape(there(shape, "shape")?.read()?);
        // SAFETY: C promises room for `room_for` overlaps that is ours during the call.
        let room = unsafe { room(overlaps, room_for, "overlaps")? };
        overlap_all(&world.queries(), &region, &read_filter(filter)?, room)
    })
}

/// All shapes that overlap a box along the world's axes, by slot, as far as `room_for` of them go.
///
/// # Safety
/// See the top of the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cs_overlap_box(
    world: Option<&mut CsWorld>,
    center: CsPosition,
    half_extents: CsVec3,
    filter: Option<&CsQueryFilter>,
    overlaps: *mut CsOverlap,
    room_for: usize,
    found: Option<&mut MaybeUninit<CsFound>>,
) -> CsResult {
    make(world, found, |world| {
        let region = Region::Box { center: center.into(), half_extents: half_extents.into() };
        // SAFETY: C promises room for `room_for` overlaps that is ours during the call.
        let room = unsafe { room(overlaps, room_for, "overlaps")? };
        overlap_all(&world.queries(), &region, &read_filter(filter)?, room)
    })
}

/// The point of any shape that is closest to a place, no farther than `max_distance` metres.
#[unsafe(no_mangle)]
pub extern "C" fn cs_closest_point(
    world: Option<&mut CsWorld>,
    place: CsPosition,
    max_distance: f32,
    filter: Option<&CsQueryFilter>,
    closest: Option<&mut MaybeUninit<CsClosest>>,
    found: Option<&mut MaybeUninit<u32>>,
) -> CsResult {
    make(world, found, |world| {
        let probe = Probe { position: place.into(), max_distance };
        first(world.queries().closest_point(&probe, &read_filter(filter)?)?, closest)
    })
}
