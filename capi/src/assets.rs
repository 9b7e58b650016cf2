//! Hulls, meshes, height fields and compounds. They are registered before the first step, in the same order on
//! every machine.

use crate::border::{make, slice};
use crate::error::{CsResult, Failure};
use crate::shapes::CsGeometry;
use crate::types::{CsPose, CsVec3};
use crate::world::CsWorld;
use bytemuck::{Pod, Zeroable};
use cellstep::math::Vec3;
use cellstep::{CompoundChild, Error, HeightFieldDef};
use std::mem::MaybeUninit;

/// A part of a compound.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct CsChild {
    /// Its geometry.
    pub geometry: CsGeometry,
    /// Where it stands in the compound's frame.
    pub pose: CsPose,
}

/// Registers the convex hull of some points.
///
/// # Safety
/// See the top of the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cs_add_hull(
    world: Option<&mut CsWorld>,
    points: *const CsVec3,
    count: usize,
    out: Option<&mut MaybeUninit<u32>>,
) -> CsResult {
    make(world, out, |world| {
        // SAFETY: C promises `count` points that nobody changes during the call.
        let points = unsafe { slice(points, count, "points")? };
        Ok(world.add_hull(&vectors(points))?.0)
    })
}

/// Registers a triangle mesh: three indices of vertices for each triangle.
///
/// # Safety
/// See the top of the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cs_add_mesh(
    world: Option<&mut CsWorld>,
    vertices: *const CsVec3,
    vertex_count: usize,
    triangles: *const u32,
    triangle_count: usize,
    out: Option<&mut MaybeUninit<u32>>,
) -> CsResult {
    make(world, out, |world| {
        // SAFETY: C promises `vertex_count` vertices that nobody changes during the call.
        let vertices = unsafe { slice(vertices, vertex_count, "vertices")? };
        // SAFETY: C promises three indices for each triangle that nobody changes during the call.
        let triangles = unsafe { slice(triangles.cast::<[u32; 3]>(), triangle_count, "triangles")? };
        Ok(world.add_mesh(&vectors(vertices), triangles)?.0)
    })
}

/// Registers a height field of `columns` x `rows` samples, row by row, `spacing_x` and `spacing_y` metres apart.
/// `cells` is null, or has a byte for each cell, row by row: 255 for a hole, else 0.
///
/// # Safety
/// See the top of the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cs_add_height_field(
    world: Option<&mut CsWorld>,
    heights: *const f32,
    columns: u32,
    rows: u32,
    spacing_x: f32,
    spacing_y: f32,
    cells: *const u8,
    out: Option<&mut MaybeUninit<u32>>,
) -> CsResult {
    make(world, out, |world| {
        let many = |a: u32, b: u32| (a as usize).checked_mul(b as usize);
        let samples = many(columns, rows).ok_or(Error::OutOfRange { name: "columns" })?;
        let cell_count =
            if cells.is_null() { 0 } else { many(columns.max(1) - 1, rows.max(1) - 1).unwrap_or(0) };
        // SAFETY: C promises `columns` x `rows` heights that nobody changes during the call.
        let heights = unsafe { slice(heights, samples, "heights")? };
        // SAFETY: C promises a byte for each cell, unless there are none.
        let cells = unsafe { slice(cells, cell_count, "cells")? };
        let spacing = [spacing_x, spacing_y];
        let def = HeightFieldDef { columns, rows, spacing, heights, cells, surfaces: &[] };
        Ok(world.add_height_field(&def)?.0)
    })
}

/// Registers a compound of convex children.
///
/// # Safety
/// See the top of the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cs_add_compound(
    world: Option<&mut CsWorld>,
    children: *const CsChild,
    count: usize,
    out: Option<&mut MaybeUninit<u32>>,
) -> CsResult {
    make(world, out, |world| {
        // SAFETY: C promises `count` children that nobody changes during the call.
        let children = unsafe { slice(children, count, "children")? };
        let read =
            |child: &CsChild| Ok(CompoundChild { geometry: child.geometry.read()?, pose: child.pose.into() });
        let children: Vec<CompoundChild> = children.iter().map(read).collect::<Result<_, Failure>>()?;
        Ok(world.add_compound(&children)?.0)
    })
}

fn vectors(points: &[CsVec3]) -> Vec<Vec3> {
    points.iter().map(|&point| point.into()).collect()
}
