//! Assets: immutable geometry, and read access to it.

use crate::arena::region;
use crate::collide::compound::{Child, Compound};
use crate::collide::height_field::HeightField;
use crate::collide::hull::HullRow;
use crate::collide::{Mesh, Triangle, tree};
use crate::math::{Aabb, Vec3};
use crate::shape::{GEOMETRY_HEIGHT_FIELD, GEOMETRY_MESH, ShapeRow};
use bytemuck::{Pod, Zeroable};

/// Counts of the assets.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(crate) struct AssetHeader {
    /// Hash of everything registered, in order.
    pub hash: u64,
    pub hulls: u32,
    pub meshes: u32,
    pub vertices: u32,
    pub triangles: u32,
    pub nodes: u32,
    pub height_fields: u32,
    pub heights: u32,
    pub cells: u32,
    pub compounds: u32,
    pub children: u32,
    pub child_nodes: u32,
    pub surfaces: u32,
}

/// A mesh: runs of the tables of all meshes.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(crate) struct MeshRow {
    pub first_vertex: u32,
    pub vertices: u32,
    pub first_triangle: u32,
    pub triangles: u32,
    pub first_node: u32,
    pub nodes: u32,
}

/// Where a mesh has its table of surfaces. Zero for one without.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(crate) struct SurfaceRun {
    pub first: u32,
    pub count: u32,
}

/// A height field: runs of the tables of all height fields.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(crate) struct HeightFieldRow {
    pub columns: u32,
    pub rows: u32,
    /// Metres.
    pub spacing: [f32; 2],
    /// Least and greatest height, metres.
    pub range: [f32; 2],
    pub first_height: u32,
    pub first_cell: u32,
    /// 0 when there are neither holes nor surfaces by cell.
    pub cells: u32,
    pub surfaces: SurfaceRun,
}

/// A compound: runs of the tables of all compounds.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(crate) struct CompoundRow {
    pub first_child: u32,
    pub children: u32,
    pub first_node: u32,
    pub nodes: u32,
}

/// What a triangle's surface is like, in the place of its shape's.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Surface {
    /// Coefficient of friction, 0..=1e6.
    pub friction: f32,
    /// Share of the approach speed that comes back, 0..=1.
    pub restitution: f32,
}

region! {
    /// Immutable geometry.
    AssetsLayout, Assets, |c| {
        header: AssetHeader = 1,
        hulls: HullRow = c.hulls as usize,
        meshes: MeshRow = c.meshes as usize,
        vertices: Vec3 = c.mesh_vertices as usize,
        triangles: Triangle = c.mesh_triangles as usize,
        nodes: Aabb = c.mesh_triangles as usize * 3 / 2 + 16 * c.meshes as usize,
        order: u32 = c.mesh_triangles as usize,
        mesh_surfaces: SurfaceRun = if c.surfaces == 0 { 0 } else { c.meshes as usize },
        /// Index of the surface of each triangle in its mesh's table.
        triangle_surfaces: u8 = if c.surfaces == 0 { 0 } else { c.mesh_triangles as usize },
        height_fields: HeightFieldRow = c.height_fields as usize,
        heights: f32 = c.height_samples as usize,
        cells: u8 = c.height_samples as usize,
        compounds: CompoundRow = c.compounds as usize,
        children: Child = c.compound_children as usize,
        child_nodes: Aabb = c.compound_children as usize * 3 / 2 + 16 * c.compounds as usize,
        child_order: u32 = c.compound_children as usize,
        surfaces: Surface = c.surfaces as usize,
    }
}

/// Read access to the assets, shared by the tasks of a step.
#[derive(Clone, Copy)]
pub(crate) struct AssetTables<'a> {
    pub hulls: &'a [HullRow],
    pub meshes: &'a [MeshRow],
    pub vertices: &'a [Vec3],
    pub triangles: &'a [Triangle],
    pub nodes: &'a [Aabb],
    pub order: &'a [u32],
    pub mesh_surfaces: &'a [SurfaceRun],
    pub triangle_surfaces: &'a [u8],
    pub height_fields: &'a [HeightFieldRow],
    pub heights: &'a [f32],
    pub cells: &'a [u8],
    pub compounds: &'a [CompoundRow],
    pub children: &'a [Child],
    pub child_nodes: &'a [Aabb],
    pub child_order: &'a [u32],
    pub surfaces: &'a [Surface],
}

impl<'a> AssetTables<'a> {
    pub fn new(layout: &AssetsLayout, region: &'a [u8]) -> Self {
        Self {
            hulls: layout.hulls.of(region),
            meshes: layout.meshes.of(region),
            vertices: layout.vertices.of(region),
            triangles: layout.triangles.of(region),
            nodes: layout.nodes.of(region),
            order: layout.order.of(region),
            mesh_surfaces: layout.mesh_surfaces.of(region),
            triangle_surfaces: layout.triangle_surfaces.of(region),
            height_fields: layout.height_fields.of(region),
            heights: layout.heights.of(region),
            cells: layout.cells.of(region),
            compounds: layout.compounds.of(region),
            children: layout.children.of(region),
            child_nodes: layout.child_nodes.of(region),
            child_order: layout.child_order.of(region),
            surfaces: layout.surfaces.of(region),
        }
    }

    /// True when a hull of this index was registered: rows above the last one are zero.
    pub fn has_hull(&self, index: u32) -> bool {
        self.hulls.get(index as usize).is_some_and(|row| row.vertex_count > 0)
    }

    /// True when a mesh, a height field or a compound was registered: the first one is in the first row.
    pub fn have_concave(&self) -> bool {
        self.meshes.first().is_some_and(|row| row.triangles > 0)
            || self.height_fields.first().is_some_and(|row| row.columns > 0)
            || self.compounds.first().is_some_and(|row| row.children > 0)
    }

    /// The same for a compound.
    pub fn has_compound(&self, index: u32) -> bool {
        self.compounds.get(index as usize).is_some_and(|row| row.children > 0)
    }

    pub fn mesh(&self, index: u32) -> Mesh<'a> {
        let row = &self.meshes[index as usize];
        let has_surfaces = self.mesh_surfaces.get(index as usize).is_some_and(|run| run.count > 0);
        Mesh {
            vertices: &self.vertices[run(row.first_vertex, row.vertices)],
            triangles: &self.triangles[run(row.first_triangle, row.triangles)],
            tree: tree::Tree {
                nodes: &self.nodes[run(row.first_node, row.nodes)],
                order: &self.order[run(row.first_triangle, row.triangles)],
            },
            surfaces: if has_surfaces {
                &self.triangle_surfaces[run(row.first_triangle, row.triangles)]
            } else {
                &[]
            },
        }
    }

    pub fn height_field(&self, index: u32) -> HeightField<'a> {
        let row = &self.height_fields[index as usize];
        HeightField {
            columns: row.columns,
            rows: row.rows,
            spacing: row.spacing,
            heights: &self.heights[run(row.first_height, row.columns * row.rows)],
            cells: &self.cells[run(row.first_cell, row.cells)],
            has_surfaces: row.surfaces.count > 0,
            range: row.range,
        }
    }

    pub fn compound(&self, index: u32) -> Compound<'a> {
        let row = &self.compounds[index as usize];
        Compound {
            children: &self.children[run(row.first_child, row.children)],
            hulls: self.hulls,
            tree: tree::Tree {
                nodes: &self.child_nodes[run(row.first_node, row.nodes)],
                order: &self.child_order[run(row.first_child, row.children)],
            },
        }
    }

    /// The surface that a manifold with this shape names; see [`crate::collide::Manifold::surface`].
    pub fn surface(&self, shape: &ShapeRow, name: u32) -> Option<Surface> {
        let runs = match shape.kind {
            GEOMETRY_MESH => self.mesh_surfaces[shape.asset() as usize],
            GEOMETRY_HEIGHT_FIELD => self.height_fields[shape.asset() as usize].surfaces,
            _ => return None,
        };
        let index = name.checked_sub(1).filter(|index| *index < runs.count)?;
        Some(self.surfaces[(runs.first + index) as usize])
    }
}

fn run(first: u32, count: u32) -> core::ops::Range<usize> {
    first as usize..(first + count) as usize
}
