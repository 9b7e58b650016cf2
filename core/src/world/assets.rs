//! Registering hulls and meshes.

use super::World;
use super::checksum::hash;
use crate::arena::Line;
use crate::collide::hull::{self, HullTables};
use crate::collide::{Hull, Mesh, Triangle, mesh, tree};
use crate::error::Error;
use crate::handle::{HullHandle, MeshHandle};
use crate::math::Vec3;
use crate::shape::check_material;
use crate::state::{Assets, HullRow, MeshRow, Scratch, Surface, SurfaceRun};
use bytemuck::{Pod, Zeroable};

impl<M: AsRef<[Line]> + AsMut<[Line]>> World<M> {
    /// Registers the convex hull of some points, metres. Points inside, on faces or twice are welcome; coplanar
    /// faces are merged. The hull has at most 64 vertices.
    ///
    /// # Errors
    /// [`Error::AssetsSealed`] after the first step, [`Error::Full`], or [`Error::Hull`] for points that are flat,
    /// not finite or too many on the hull.
    pub fn add_hull(&mut self, points: &[Vec3]) -> Result<HullHandle, Error> {
        self.check_unsealed()?;
        let tables = hull::build(points).map_err(Error::Hull)?;
        let (assets, _) = self.assets_mut();
        let header = &mut assets.header[0];
        let index = header.hulls;
        let row = assets.hulls.get_mut(index as usize).ok_or(Error::Full { name: "hulls" })?;
        *row = row_of(&tables);
        assets.hull_radii[index as usize] = tables.view().inner_radius();
        header.hulls += 1;
        header.hash = hash(bytemuck::bytes_of(row), header.hash ^ 1);
        Ok(HullHandle(index))
    }

    /// Registers a triangle mesh: vertices in metres, and three vertex indices for each triangle, in any winding.
    ///
    /// # Errors
    /// [`Error::AssetsSealed`] after the first step, [`Error::Full`], or [`Error::Mesh`] naming the vertex or
    /// triangle that is not finite, out of range, without area or there twice.
    pub fn add_mesh(&mut self, vertices: &[Vec3], triangles: &[[u32; 3]]) -> Result<MeshHandle, Error> {
        self.add_mesh_of_surfaces(vertices, triangles, (&[], &[]))
    }

    /// Registers a triangle mesh whose triangles have materials of their own, in the place of the shape's: for each
    /// triangle an index into a table of at most 256 surfaces. A contact takes the material of the triangle that
    /// has its deepest point.
    ///
    /// # Errors
    /// As [`World::add_mesh`], and [`Error::Surface`].
    pub fn add_mesh_with_surfaces(
        &mut self,
        vertices: &[Vec3],
        triangles: &[[u32; 3]],
        (indices, surfaces): (&[u8], &[Surface]),
    ) -> Result<MeshHandle, Error> {
        let missing = |index: usize| Error::Surface { index: index as u32 };
        if indices.len() != triangles.len() {
            return Err(missing(indices.len().min(triangles.len())));
        }
        match indices.iter().position(|&index| usize::from(index) >= surfaces.len()) {
            Some(triangle) => Err(missing(triangle)),
            None => self.add_mesh_of_surfaces(vertices, triangles, (indices, surfaces)),
        }
    }

    fn add_mesh_of_surfaces(
        &mut self,
        vertices: &[Vec3],
        triangles: &[[u32; 3]],
        (indices, surfaces): (&[u8], &[Surface]),
    ) -> Result<MeshHandle, Error> {
        self.check_unsealed()?;
        let scratch_layout = self.layout.scratch;
        let (mut assets, scratch) = self.assets_mut();
        let mut scratch = scratch_layout.view(scratch);
        let row = reserve(&assets, vertices.len(), triangles.len())?;
        let index = assets.header[0].meshes;
        if let Err(error) = fill_mesh(&mut assets, &mut scratch, &row, (vertices, triangles)) {
            clear_mesh(&mut assets, &row);
            return Err(error);
        }
        let surfaces = match append_surfaces(&mut assets, surfaces) {
            Ok(run) => run,
            Err(error) => {
                clear_mesh(&mut assets, &row);
                return Err(error);
            }
        };
        if surfaces.count > 0 {
            assets.mesh_surfaces[index as usize] = surfaces;
            run_mut(assets.triangle_surfaces, row.first_triangle, row.triangles).copy_from_slice(indices);
        }
        assets.meshes[index as usize] = row;
        let header = &mut assets.header[0];
        header.meshes += 1;
        header.vertices += row.vertices;
        header.triangles += row.triangles;
        header.nodes += row.nodes;
        let seed = hash(bytemuck::bytes_of(&row), header.hash ^ 2);
        let seed = hash(bytes(run_mut(assets.vertices, row.first_vertex, row.vertices)), seed);
        let seed = hash(bytes(run_mut(assets.triangles, row.first_triangle, row.triangles)), seed);
        header.hash = if surfaces.count == 0 {
            seed
        } else {
            hash(indices, hash(bytes(run_mut(assets.surfaces, surfaces.first, surfaces.count)), seed))
        };
        Ok(MeshHandle(index))
    }

    /// The tables of a registered hull.
    ///
    /// # Errors
    /// [`Error::Stale`].
    pub fn hull(&self, hull: HullHandle) -> Result<Hull<'_>, Error> {
        let count = self.layout.assets.header.of(self.bytes())[0].hulls;
        let rows = self.layout.assets.hulls.of(self.bytes());
        if hull.0 < count { Ok(rows[hull.0 as usize].view()) } else { Err(Error::Stale { what: "hull" }) }
    }

    /// The tables of a registered mesh.
    ///
    /// # Errors
    /// [`Error::Stale`].
    pub fn mesh(&self, mesh: MeshHandle) -> Result<Mesh<'_>, Error> {
        let count = self.layout.assets.header.of(self.bytes())[0].meshes;
        if mesh.0 < count { Ok(self.asset_tables().mesh(mesh.0)) } else { Err(Error::Stale { what: "mesh" }) }
    }

    /// Hash of all registered assets, in order: worlds that exchange snapshots have the same.
    pub fn assets_hash(&self) -> u64 {
        self.layout.assets.header.of(self.bytes())[0].hash
    }

    pub(super) fn check_unsealed(&self) -> Result<(), Error> {
        if self.steps() == 0 { Ok(()) } else { Err(Error::AssetsSealed) }
    }
}

/// Where the next mesh goes.
fn reserve(assets: &Assets<'_>, vertices: usize, triangles: usize) -> Result<MeshRow, Error> {
    let header = &assets.header[0];
    let fits = |used: u32, more: usize, room: usize| more <= room - used as usize;
    if header.meshes as usize >= assets.meshes.len() {
        return Err(Error::Full { name: "meshes" });
    }
    if !fits(header.vertices, vertices, assets.vertices.len()) {
        return Err(Error::Full { name: "mesh_vertices" });
    }
    let nodes = tree::node_count(triangles);
    let room = fits(header.triangles, triangles, assets.triangles.len());
    if !room || !fits(header.nodes, nodes, assets.nodes.len()) {
        return Err(Error::Full { name: "mesh_triangles" });
    }
    Ok(MeshRow {
        first_vertex: header.vertices,
        vertices: vertices as u32,
        first_triangle: header.triangles,
        triangles: triangles as u32,
        first_node: header.nodes,
        nodes: nodes as u32,
    })
}

fn fill_mesh(
    assets: &mut Assets<'_>,
    scratch: &mut Scratch<'_>,
    row: &MeshRow,
    (vertices, triangles): (&[Vec3], &[[u32; 3]]),
) -> Result<(), Error> {
    let own_vertices = run_mut(assets.vertices, row.first_vertex, row.vertices);
    own_vertices.copy_from_slice(vertices);
    let own = run_mut(assets.triangles, row.first_triangle, row.triangles);
    for (slot, &vertices) in own.iter_mut().zip(triangles) {
        *slot = Triangle { vertices, across: [u32::MAX; 3] };
    }
    mesh::validate(own_vertices, own, scratch.mesh_words).map_err(Error::Mesh)?;
    mesh::connect(own_vertices, own, scratch.mesh_words);
    for (slot, triangle) in scratch.mesh_boxes.iter_mut().zip(own.iter()) {
        *slot = mesh::triangle_box(own_vertices, triangle);
    }
    tree::build(
        scratch.mesh_boxes,
        0..row.triangles,
        scratch.mesh_words,
        run_mut(assets.order, row.first_triangle, row.triangles),
        run_mut(assets.nodes, row.first_node, row.nodes),
    );
    Ok(())
}

/// What was written of a refused mesh stays above the marks; makes it zeros again.
fn clear_mesh(assets: &mut Assets<'_>, row: &MeshRow) {
    run_mut(assets.vertices, row.first_vertex, row.vertices).fill(Vec3::ZERO);
    run_mut(assets.triangles, row.first_triangle, row.triangles).fill(Triangle::zeroed());
}

/// Puts a table of surfaces behind those of before; writes nothing when it is refused.
pub(super) fn append_surfaces(assets: &mut Assets<'_>, surfaces: &[Surface]) -> Result<SurfaceRun, Error> {
    if surfaces.is_empty() {
        return Ok(SurfaceRun::zeroed());
    }
    let is_bad = |surface: &Surface| check_material(surface.friction, surface.restitution).is_err();
    if let Some(index) = surfaces.iter().position(is_bad) {
        return Err(Error::Surface { index: index as u32 });
    }
    let first = assets.header[0].surfaces;
    if surfaces.len() > assets.surfaces.len() - first as usize {
        return Err(Error::Full { name: "surfaces" });
    }
    let run = SurfaceRun { first, count: surfaces.len() as u32 };
    run_mut(assets.surfaces, run.first, run.count).copy_from_slice(surfaces);
    assets.header[0].surfaces += run.count;
    Ok(run)
}

pub(super) fn run_mut<T>(table: &mut [T], first: u32, count: u32) -> &mut [T] {
    &mut table[first as usize..(first + count) as usize]
}

pub(super) fn bytes<T: Pod>(rows: &[T]) -> &[u8] {
    bytemuck::cast_slice(rows)
}

fn row_of(tables: &HullTables) -> HullRow {
    let mut row = HullRow::zeroed();
    row.vertices[..tables.vertices.len()].copy_from_slice(&tables.vertices);
    row.planes[..tables.planes.len()].copy_from_slice(&tables.planes);
    row.faces[..tables.faces.len()].copy_from_slice(&tables.faces);
    row.loops[..tables.loops.len()].copy_from_slice(&tables.loops);
    row.edges[..tables.edges.len()].copy_from_slice(&tables.edges);
    row.center = tables.center;
    row.radius_squared = tables.vertices.iter().fold(0.0, |most, v| crate::math::max(v.dot(*v), most));
    row.vertex_count = tables.vertices.len() as u32;
    row.face_count = tables.faces.len() as u32;
    row.loop_count = tables.loops.len() as u32;
    row.edge_count = tables.edges.len() as u32;
    row
}
