//! The rules of height fields, compounds and surfaces.

use super::{Checked, LENGTH_MAX, geometry, named, range, turned, vector};
use crate::scene::error::SceneError;
use crate::scene::format::*;
use crate::scene::place::Place;

/// Least distance of the samples of a height field, metres.
const SPACING_MIN: f32 = 1.0e-4;

pub(super) fn check(scene: &Scene) -> Checked {
    let root = Place::Root;
    let fields = root.key("height_fields");
    for (name, field) in &scene.height_fields {
        height_field(fields.key(name), field, scene)?;
    }
    let compounds = root.key("compounds");
    for (name, compound) in &scene.compounds {
        self::compound(compounds.key(name), compound, scene)?;
    }
    Ok(())
}

fn height_field(place: Place<'_>, field: &HeightFieldDoc, scene: &Scene) -> Checked {
    for (name, count) in [("columns", field.columns), ("rows", field.rows)] {
        if count < 2 {
            return Err(SceneError::invalid(place.key(name), format!("found {count}"), "at least 2"));
        }
    }
    let samples = u64::from(field.columns) * u64::from(field.rows);
    if field.heights.len() as u64 != samples {
        let found = format!("found {} heights", field.heights.len());
        let expected = format!("{samples}, columns times rows");
        return Err(SceneError::invalid(place.key("heights"), found, expected));
    }
    let spacing = place.key("spacing");
    for (index, &x) in field.spacing.iter().enumerate() {
        range(spacing.index(index), x, SPACING_MIN, LENGTH_MAX)?;
    }
    let heights = place.key("heights");
    for (index, &height) in field.heights.iter().enumerate() {
        range(heights.index(index), height, -LENGTH_MAX, LENGTH_MAX)?;
    }
    let (columns, rows) = (field.columns - 1, field.rows - 1);
    let holes = place.key("holes");
    for (index, &[column, row]) in field.holes.iter().enumerate() {
        if column >= columns || row >= rows {
            let expected = format!("a cell: a column below {columns} and a row below {rows}");
            let found = format!("found [{column}, {row}]");
            return Err(SceneError::invalid(holes.index(index), found, expected));
        }
    }
    let given = (field.surfaces.as_slice(), field.cell_surfaces.as_slice());
    // Without indices every cell has the first surface.
    let cells = if field.cell_surfaces.is_empty() { 0 } else { columns as usize * rows as usize };
    surfaces(place, "cell_surfaces", (given, cells), scene)
}

/// Surfaces name materials, and there is an index for each of `count` parts when there are any.
pub(super) fn surfaces(
    place: Place<'_>,
    field: &'static str,
    ((names, indices), count): ((&[String], &[u8]), usize),
    scene: &Scene,
) -> Checked {
    let list = place.key("surfaces");
    for (index, name) in names.iter().enumerate() {
        named(list.index(index), "material", name, &scene.materials)?;
    }
    let place = place.key(field);
    let needed = if names.is_empty() { 0 } else { count };
    if indices.len() != needed {
        let expected = format!("{needed}, one for each part that has a surface");
        return Err(SceneError::invalid(place, format!("found {} indices", indices.len()), expected));
    }
    for (index, &surface) in indices.iter().enumerate() {
        if usize::from(surface) >= names.len() {
            let expected = format!("an index below {}, the number of surfaces", names.len());
            return Err(SceneError::invalid(place.index(index), format!("found {surface}"), expected));
        }
    }
    Ok(())
}

fn compound(place: Place<'_>, compound: &CompoundDoc, scene: &Scene) -> Checked {
    let children = place.key("children");
    if compound.children.is_empty() {
        return Err(SceneError::invalid(children, "found none", "at least one child"));
    }
    for (index, child) in compound.children.iter().enumerate() {
        let place = children.index(index);
        if let GeometryDoc::Compound(_) = child.geometry {
            let expected = "a convex geometry";
            return Err(SceneError::invalid(place.key("geometry"), "found a compound", expected));
        }
        geometry(place.key("geometry"), &child.geometry, KindDoc::Dynamic, scene)?;
        vector(place.key("position"), &child.position, LENGTH_MAX)?;
        turned(place.key("rotation"), &child.rotation)?;
    }
    Ok(())
}
