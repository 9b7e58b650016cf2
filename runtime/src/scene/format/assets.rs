//! Documents of height fields and compounds.

use super::super::bounded::bounded;
use super::{GeometryDoc, MESH_PARTS_MAX, RotationDoc, is_default, is_zero_each};
use serde::{Deserialize, Serialize};

/// Most children of a compound.
pub const CHILDREN_MAX: usize = 1 << 12;
/// Most surfaces of a mesh or height field: their indices are bytes, of which 255 marks a hole.
pub const SURFACES_MAX: usize = 255;

/// Heights over a grid in the x-y plane, from the origin on.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a height field object")]
pub struct HeightFieldDoc {
    /// Samples along x, at least 2.
    pub columns: u32,
    /// Samples along y, at least 2.
    pub rows: u32,
    /// Distance of samples along x and y, metres.
    pub spacing: [f32; 2],
    /// Heights, metres, row by row: columns x rows.
    #[serde(deserialize_with = "bounded::<_, _, MESH_PARTS_MAX>")]
    pub heights: Vec<f32>,
    /// Cells without ground: column and row of their least corner.
    #[serde(
        default,
        deserialize_with = "bounded::<_, _, MESH_PARTS_MAX>",
        skip_serializing_if = "Vec::is_empty"
    )]
    pub holes: Vec<[u32; 2]>,
    /// Names of materials that cells have in the place of the shape's.
    #[serde(
        default,
        deserialize_with = "bounded::<_, _, SURFACES_MAX>",
        skip_serializing_if = "Vec::is_empty"
    )]
    pub surfaces: Vec<String>,
    /// For each cell, row by row, an index into `surfaces`. Empty: all have the first.
    #[serde(
        default,
        deserialize_with = "bounded::<_, _, MESH_PARTS_MAX>",
        skip_serializing_if = "Vec::is_empty"
    )]
    pub cell_surfaces: Vec<u8>,
}

/// Convex children in one shape.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a compound object")]
pub struct CompoundDoc {
    /// At least one.
    #[serde(deserialize_with = "bounded::<_, _, CHILDREN_MAX>")]
    pub children: Vec<ChildDoc>,
}

/// A child of a compound.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, expecting = "an object of a compound's child")]
pub struct ChildDoc {
    /// Its form: convex.
    pub geometry: GeometryDoc,
    /// Where it stands in the compound's frame, metres.
    #[serde(default, skip_serializing_if = "is_zero_each")]
    pub position: [f32; 3],
    /// How it is turned in the compound's frame.
    #[serde(default, skip_serializing_if = "is_default")]
    pub rotation: RotationDoc,
}
