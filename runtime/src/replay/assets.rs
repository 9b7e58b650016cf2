//! The assets of a world as they were registered, so that they can be registered again.
//!
//! A world keeps what it computes with: hulls with their faces, meshes with their trees. What those were made from
//! is gone, and made anew from a hull's vertices it might be another hull by a bit. So whoever records registers
//! through an [`AssetSet`], which keeps the arguments. As bytes: a kind, counts, and the numbers as they are.

use super::ReplayError;
use bytemuck::{Pod, cast_slice, pod_collect_to_vec};
use cellstep_core::math::Vec3;
use cellstep_core::{
    Command, CompoundChild, CompoundHandle, Error, HeightFieldDef, HeightFieldHandle, HullHandle, Line,
    MeshHandle, ShapeHandle, Surface, World,
};

const HULL: u8 = 1;
const MESH: u8 = 2;
const HEIGHT_FIELD: u8 = 3;
const COMPOUND: u8 = 4;

/// The assets of a world, in the order of their registration.
///
/// Each method registers an asset with a world, as the method of the same name of [`World`] does, and remembers it.
/// What the world refuses is not remembered.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct AssetSet {
    encoded: Vec<Vec<u8>>,
    /// [`World::assets_hash`] after the last one.
    hash: u64,
}

impl AssetSet {
    /// No assets.
    pub fn new() -> Self {
        Self::default()
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.encoded.len()
    }

    /// True when there are none.
    pub fn is_empty(&self) -> bool {
        self.encoded.is_empty()
    }

    /// [`World::assets_hash`] of a world that has exactly these.
    pub fn hash(&self) -> u64 {
        self.hash
    }

    /// [`World::add_hull`].
    ///
    /// # Errors
    /// Those of the method.
    pub fn add_hull<M>(&mut self, world: &mut World<M>, points: &[Vec3]) -> Result<HullHandle, Error>
    where
        M: AsRef<[Line]> + AsMut<[Line]>,
    {
        let hull = world.add_hull(points)?;
        let mut out = vec![HULL];
        put(&mut out, points);
        self.remember(out, world);
        Ok(hull)
    }

    /// [`World::add_mesh`].
    ///
    /// # Errors
    /// Those of the method.
    pub fn add_mesh<M>(
        &mut self,
        world: &mut World<M>,
        vertices: &[Vec3],
        triangles: &[[u32; 3]],
    ) -> Result<MeshHandle, Error>
    where
        M: AsRef<[Line]> + AsMut<[Line]>,
    {
        let mesh = world.add_mesh(vertices, triangles)?;
        self.remember(mesh_bytes(vertices, triangles, (&[], &[])), world);
        Ok(mesh)
    }

    /// [`World::add_mesh_with_surfaces`].
    ///
    /// # Errors
    /// Those of the method.
    pub fn add_mesh_with_surfaces<M>(
        &mut self,
        world: &mut World<M>,
        vertices: &[Vec3],
        triangles: &[[u32; 3]],
        surfaces: (&[u8], &[Surface]),
    ) -> Result<MeshHandle, Error>
    where
        M: AsRef<[Line]> + AsMut<[Line]>,
    {
        let mesh = world.add_mesh_with_surfaces(vertices, triangles, surfaces)?;
        self.remember(mesh_bytes(vertices, triangles, surfaces), world);
        Ok(mesh)
    }

    /// [`World::add_height_field`].
    ///
    /// # Errors
    /// Those of the method.
    pub fn add_height_field<M>(
        &mut self,
        world: &mut World<M>,
        def: &HeightFieldDef<'_>,
    ) -> Result<HeightFieldHandle, Error>
    where
        M: AsRef<[Line]> + AsMut<[Line]>,
    {
        let field = world.add_height_field(def)?;
        let mut out = vec![HEIGHT_FIELD];
        put(&mut out, &[def.columns, def.rows]);
        put(&mut out, &def.spacing);
        put(&mut out, def.heights);
        put(&mut out, def.cells);
        put(&mut out, def.surfaces);
        self.remember(out, world);
        Ok(field)
    }

    /// [`World::add_compound`].
    ///
    /// # Errors
    /// Those of the method.
    pub fn add_compound<M>(
        &mut self,
        world: &mut World<M>,
        children: &[CompoundChild],
    ) -> Result<CompoundHandle, Error>
    where
        M: AsRef<[Line]> + AsMut<[Line]>,
    {
        let compound = world.add_compound(children)?;
        let mut out = vec![COMPOUND];
        let mut room = [0; Command::BYTES_MAX];
        for child in children {
            // A geometry and a pose have their encoding as the command that sets them.
            let command = Command::SetGeometry(ShapeHandle::default(), child.geometry, child.pose);
            let length = command.encode(&mut room).expect("there is room for any command");
            out.extend_from_slice(&room[..length]);
        }
        self.remember(out, world);
        Ok(compound)
    }

    /// Registers all of these with a world that has none.
    ///
    /// # Errors
    /// [`ReplayError::World`] with the world's refusal.
    pub fn register<M>(&self, world: &mut World<M>) -> Result<(), ReplayError>
    where
        M: AsRef<[Line]> + AsMut<[Line]>,
    {
        let mut again = AssetSet::new();
        self.encoded.iter().try_for_each(|bytes| again.register_bytes(bytes, world))
    }

    fn remember<M: AsRef<[Line]> + AsMut<[Line]>>(&mut self, bytes: Vec<u8>, world: &World<M>) {
        self.encoded.push(bytes);
        self.hash = world.assets_hash();
    }

    /// Each asset as bytes.
    pub(super) fn encoded(&self) -> impl Iterator<Item = &[u8]> {
        self.encoded.iter().map(Vec::as_slice)
    }

    /// Registers an asset of a replay.
    pub(super) fn register_bytes<M>(&mut self, bytes: &[u8], world: &mut World<M>) -> Result<(), ReplayError>
    where
        M: AsRef<[Line]> + AsMut<[Line]>,
    {
        let malformed = ReplayError::Malformed { offset: 0, what: "an asset's bytes end early or go on" };
        let (&kind, mut rest) = bytes.split_first().ok_or(ReplayError::NoStart)?;
        let added = match kind {
            HULL => read_hull(&mut rest).map(|points| self.add_hull(world, &points).map(drop)),
            MESH => read_mesh(&mut rest).map(|mesh| {
                let (vertices, triangles) = (&mesh.0, &mesh.1);
                if mesh.3.is_empty() {
                    self.add_mesh(world, vertices, triangles).map(drop)
                } else {
                    self.add_mesh_with_surfaces(world, vertices, triangles, (&mesh.2, &mesh.3)).map(drop)
                }
            }),
            HEIGHT_FIELD => self.read_height_field(&mut rest, world),
            COMPOUND => {
                read_compound(&mut rest).map(|children| self.add_compound(world, &children).map(drop))
            }
            _ => None,
        };
        match added {
            Some(Ok(())) if rest.is_empty() => Ok(()),
            Some(Err(error)) => Err(ReplayError::World(error)),
            _ => Err(malformed),
        }
    }

    fn read_height_field<M>(&mut self, rest: &mut &[u8], world: &mut World<M>) -> Option<Result<(), Error>>
    where
        M: AsRef<[Line]> + AsMut<[Line]>,
    {
        let size: Vec<u32> = get(rest)?;
        let spacing: Vec<f32> = get(rest)?;
        let (heights, cells, surfaces) = (get(rest)?, get::<u8>(rest)?, get(rest)?);
        let (&[columns, rows], &[x, y]) = (size.as_slice(), spacing.as_slice()) else { return None };
        let def = HeightFieldDef {
            columns,
            rows,
            spacing: [x, y],
            heights: &heights,
            cells: &cells,
            surfaces: &surfaces,
        };
        Some(self.add_height_field(world, &def).map(drop))
    }
}

/// A count of four bytes, and that many rows.
fn put<T: Pod>(out: &mut Vec<u8>, rows: &[T]) {
    let count = u32::try_from(rows.len()).expect("no asset has so many rows");
    out.extend_from_slice(&count.to_le_bytes());
    out.extend_from_slice(cast_slice(rows));
}

/// What [`put`] wrote; memory is taken only for bytes that are there.
fn get<T: Pod>(rest: &mut &[u8]) -> Option<Vec<T>> {
    let (count, after) = rest.split_first_chunk::<4>()?;
    let length = (u32::from_le_bytes(*count) as usize).checked_mul(size_of::<T>())?;
    let (own, after) = after.split_at_checked(length)?;
    *rest = after;
    Some(pod_collect_to_vec(own))
}

fn mesh_bytes(
    vertices: &[Vec3],
    triangles: &[[u32; 3]],
    (indices, surfaces): (&[u8], &[Surface]),
) -> Vec<u8> {
    let mut out = vec![MESH];
    put(&mut out, vertices);
    put(&mut out, triangles);
    put(&mut out, indices);
    put(&mut out, surfaces);
    out
}

fn read_hull(rest: &mut &[u8]) -> Option<Vec<Vec3>> {
    get(rest)
}

type Mesh = (Vec<Vec3>, Vec<[u32; 3]>, Vec<u8>, Vec<Surface>);

fn read_mesh(rest: &mut &[u8]) -> Option<Mesh> {
    Some((get(rest)?, get(rest)?, get(rest)?, get(rest)?))
}

fn read_compound(rest: &mut &[u8]) -> Option<Vec<CompoundChild>> {
    let mut children = Vec::new();
    while !rest.is_empty() {
        let (command, length) = Command::decode(rest).ok()?;
        let Command::SetGeometry(_, geometry, pose) = command else { return None };
        children.push(CompoundChild { geometry, pose });
        *rest = &rest[length..];
    }
    Some(children)
}
