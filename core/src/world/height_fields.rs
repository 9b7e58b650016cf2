//! Registering height fields.

use super::World;
use super::assets::{append_surfaces, bytes, run_mut};
use super::checksum::hash;
use crate::arena::Line;
use crate::collide::height_field::{self, HeightField};
use crate::error::Error;
use crate::handle::HeightFieldHandle;
use crate::state::{HeightFieldRow, Surface};

/// What a new height field is like.
///
/// The sample of column `c` and row `r` stands at `(c spacing[0], r spacing[1], heights[r columns + c])`; the
/// surface between four samples is two triangles, parted by the diagonal from the least column and row. Two-sided.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeightFieldDef<'a> {
    /// Samples along x, at least 2.
    pub columns: u32,
    /// Samples along y, at least 2. At most 2^23 cells, (columns - 1) x (rows - 1).
    pub rows: u32,
    /// Distance of samples along x and y, metres, 1e-4..=1e5; the whole at most 1e5 m long.
    pub spacing: [f32; 2],
    /// Heights of the samples, metres, each at most 1e5 in size, row by row: columns x rows.
    pub heights: &'a [f32],
    /// For each cell, row by row, [`HOLE`](crate::collide::height_field::HOLE) or the index of its surface in
    /// `surfaces` (0 when there are none). Empty: no holes, and all of the first surface.
    pub cells: &'a [u8],
    /// Materials of cells in the place of the shape's; at most 255. May be empty.
    pub surfaces: &'a [Surface],
}

impl<M: AsRef<[Line]> + AsMut<[Line]>> World<M> {
    /// Registers a height field.
    ///
    /// # Errors
    /// [`Error::AssetsSealed`] after the first step, [`Error::Full`], [`Error::HeightField`] naming what is wrong,
    /// or [`Error::Surface`].
    pub fn add_height_field(&mut self, def: &HeightFieldDef<'_>) -> Result<HeightFieldHandle, Error> {
        self.check_unsealed()?;
        let field = HeightField {
            columns: def.columns,
            rows: def.rows,
            spacing: def.spacing,
            heights: def.heights,
            cells: def.cells,
            has_surfaces: !def.surfaces.is_empty(),
            range: [0.0; 2],
        };
        let range = height_field::validate(&field, def.surfaces.len()).map_err(Error::HeightField)?;
        let (mut assets, _) = self.assets_mut();
        let header = &assets.header[0];
        let index = header.height_fields;
        let (first_height, first_cell) = (header.heights, header.cells);
        if index as usize >= assets.height_fields.len() {
            return Err(Error::Full { name: "height_fields" });
        }
        if def.heights.len() > assets.heights.len() - first_height as usize {
            return Err(Error::Full { name: "height_samples" });
        }
        let surfaces = append_surfaces(&mut assets, def.surfaces)?;
        let row = HeightFieldRow {
            columns: def.columns,
            rows: def.rows,
            spacing: def.spacing,
            range,
            first_height,
            first_cell,
            cells: def.cells.len() as u32,
            surfaces,
        };
        // There are fewer cells than samples in every field, and as much room for both.
        run_mut(assets.heights, first_height, def.heights.len() as u32).copy_from_slice(def.heights);
        run_mut(assets.cells, first_cell, row.cells).copy_from_slice(def.cells);
        assets.height_fields[index as usize] = row;
        let header = &mut assets.header[0];
        header.height_fields += 1;
        header.heights += def.heights.len() as u32;
        header.cells += row.cells;
        let seed = hash(bytemuck::bytes_of(&row), header.hash ^ 3);
        let seed = hash(bytes(def.surfaces), hash(def.cells, seed));
        header.hash = hash(bytes(def.heights), seed);
        Ok(HeightFieldHandle(index))
    }

    /// The tables of a registered height field.
    ///
    /// # Errors
    /// [`Error::Stale`].
    pub fn height_field(&self, field: HeightFieldHandle) -> Result<HeightField<'_>, Error> {
        let count = self.layout.assets.header.of(self.bytes())[0].height_fields;
        if field.0 < count {
            Ok(self.asset_tables().height_field(field.0))
        } else {
            Err(Error::Stale { what: "height field" })
        }
    }
}
