//! `<mesh>`: points from an OBJ file or from the model, and the hull that stands for them.
//!
//! MuJoCo collides with the convex hull of a mesh; so does cellstep, with at most 64 corners. A rounder hull is
//! replaced by that of its points farthest along 62 directions: it lies within. The mass is that of the mesh as
//! it was given.

use super::library::Source;
use super::mass::enclosed;
use super::math::{Turn, Vector, dot, sub};
use super::model::Mesh;
use super::tree::shortened;
use super::values::Values;
use crate::scene::{Limits, SceneError, read_obj};
use cellstep_core::collide::hull::{self, HullError, HullTables};
use cellstep_core::math::Vec3;
use std::f64::consts::PI;

/// Directions along which a rounder hull keeps its farthest points: the z axis both ways and 60 between.
const DIRECTIONS: usize = 62;
/// Most numbers of a mesh that is written in the model.
const NUMBERS_MAX: usize = 1 << 22;

/// Points and triangles.
struct Surface {
    points: Vec<Vector>,
    triangles: Vec<[u32; 3]>,
}

/// A mesh, and what is not as the file says.
pub(super) struct Loaded {
    pub mesh: Mesh,
    /// Points that were read.
    pub points: usize,
    /// True when the hull is a simplified one.
    pub simplified: bool,
}

/// A mesh's name: its own, or that of its file without folders and ending.
pub(super) fn name<'a>(values: &Values<'a>) -> Result<&'a str, SceneError> {
    let name = values.name()?;
    let file = values.own().text("file").filter(|_| name.is_empty());
    Ok(file.map_or(name, |file| {
        let last = file.rsplit(['/', '\\']).next().unwrap_or(file);
        last.rsplit_once('.').map_or(last, |(stem, _)| stem)
    }))
}

/// Reads a mesh of a source.
pub(super) fn load(values: Values<'_>, source: &Source, limits: &Limits) -> Result<Loaded, SceneError> {
    let folder = source.mesh_folder.as_str();
    let file = values.own().text("file");
    let bare = |file: &'_ str| file.rsplit(['/', '\\']).next().unwrap_or_default().to_string();
    let stripped = file.filter(|_| source.compiler.strip_path).map(bare);
    let mut surface = match (stripped.as_deref().or(file), values.own().has("vertex")) {
        (Some(_), true) => return Err(values.error("file", "a file and `vertex`, expected one of them")),
        (Some(file), _) => of_file(values, folder, file, limits)?,
        (None, true) => of_text(values)?,
        (None, false) => {
            return Err(values.error("file", "a mesh without `file` and `vertex`, expected one of them"));
        }
    };
    transform(values, &mut surface)?;
    let points: Vec<Vec3> = surface.points.iter().map(|p| Vec3::from(p.map(|x| x as f32))).collect();
    let (tables, simplified) = match hull::build(&points) {
        Err(HullError::TooManyVertices) => (hull::build(&farthest(&points)), true),
        other => (other, false),
    };
    let tables = tables.map_err(|error| {
        values.error("vertex", format!("the mesh has no hull ({error}), expected a solid"))
    })?;
    let convex = ["convex", "legacy", "exact", "shell"];
    let kind = values.keyword("inertia", &convex)?.unwrap_or(1);
    if kind == 3 {
        let message = "found \"shell\", expected a solid: give the geom's body an <inertial>";
        return Err(values.error("inertia", message));
    }
    let corner = |index: &u32| surface.points[*index as usize];
    let given = surface.triangles.iter().map(|triangle| [0, 1, 2].map(|i| corner(&triangle[i])));
    let inside = if kind == 0 { None } else { enclosed(given) };
    // A mesh with holes, or inside out, encloses nothing: its hull does.
    let mass = inside.or_else(|| enclosed(triangles(&tables).into_iter()));
    let mass = mass.ok_or_else(|| values.error("vertex", "the mesh has no volume, expected a solid"))?;
    let mesh = Mesh {
        name: name(&values)?.to_string(),
        points: tables.vertices.iter().map(|vertex| vertex.to_array()).collect(),
        volume: mass.mass,
        mass,
    };
    Ok(Loaded { mesh, points: surface.points.len(), simplified })
}

fn of_file(values: Values<'_>, folder: &str, file: &str, limits: &Limits) -> Result<Surface, SceneError> {
    let ending = file.rsplit_once('.').map_or(String::new(), |(_, ending)| ending.to_ascii_lowercase());
    if ending != "obj" {
        let message = format!("found {:?}, expected an OBJ file: convert it", shortened(file));
        return Err(values.error("file", message));
    }
    let relative = values.files.resolve(folder, file).map_err(|message| values.error("file", message))?;
    let path = values.files.path(&relative);
    let (soup, _) = read_obj(&path, limits.file_bytes).map_err(|error| values.error("file", error))?;
    let points = soup.vertices.iter().map(|vertex| vertex.map(f64::from)).collect();
    Ok(Surface { points, triangles: soup.triangles })
}

fn of_text(values: Values<'_>) -> Result<Surface, SceneError> {
    let numbers = values.own().list("vertex", 12, NUMBERS_MAX)?.unwrap_or_default();
    if !numbers.len().is_multiple_of(3) {
        let message = format!("found {} numbers, expected three for each vertex", numbers.len());
        return Err(values.error("vertex", message));
    }
    let points: Vec<Vector> = numbers.chunks_exact(3).map(|p| [p[0], p[1], p[2]]).collect();
    let indices = values.own().list("face", 3, NUMBERS_MAX)?.unwrap_or_default();
    let sound = |&index: &f64| index >= 0.0 && index < points.len() as f64 && index as u32 as f64 == index;
    if let Some(bad) = indices.iter().find(|index| !sound(index)) {
        let message = format!("found the index {bad}, expected 0 up to {}", points.len() - 1);
        return Err(values.error("face", message));
    }
    if !indices.len().is_multiple_of(3) {
        let message = format!("found {} indices, expected three for each face", indices.len());
        return Err(values.error("face", message));
    }
    let triangles = indices.chunks_exact(3).map(|f| [f[0] as u32, f[1] as u32, f[2] as u32]).collect();
    Ok(Surface { points, triangles })
}

/// `refpos` and `refquat` become the origin and the axes, then `scale`.
fn transform(values: Values<'_>, surface: &mut Surface) -> Result<(), SceneError> {
    let origin = values.own().numbers::<3>("refpos")?.unwrap_or([0.0; 3]);
    let turn = values.own().numbers::<4>("refquat")?.unwrap_or([1.0, 0.0, 0.0, 0.0]);
    let zero = || values.error("refquat", "zero, expected a rotation");
    let back = Turn::from_wxyz(turn).ok_or_else(zero)?.inverse();
    let scale = values.numbers::<3>("scale")?.unwrap_or([1.0; 3]);
    for point in &mut surface.points {
        let turned = back.rotate(sub(*point, origin));
        *point = [turned[0] * scale[0], turned[1] * scale[1], turned[2] * scale[2]];
    }
    if scale[0] * scale[1] * scale[2] < 0.0 {
        // A mirror turns the triangles inside out.
        surface.triangles.iter_mut().for_each(|triangle| triangle.swap(1, 2));
    }
    Ok(())
}

/// The points that are farthest along each of [`DIRECTIONS`], evenly spread (Fibonacci's spiral).
fn farthest(points: &[Vec3]) -> Vec<Vec3> {
    let mut kept: Vec<usize> = Vec::new();
    for i in 0..DIRECTIONS {
        let z = 1.0 - 2.0 * i as f64 / (DIRECTIONS - 1) as f64;
        let ring = (1.0 - z * z).sqrt();
        // The golden angle.
        let angle = i as f64 * PI * (3.0 - 5.0f64.sqrt());
        let direction = [ring * libm::cos(angle), ring * libm::sin(angle), z];
        let along = |p: &Vec3| dot(p.to_array().map(f64::from), direction);
        let first = (0, along(&points[0]));
        let best = points.iter().map(along).enumerate().fold(first, |a, b| if b.1 > a.1 { b } else { a });
        if !kept.contains(&best.0) {
            kept.push(best.0);
        }
    }
    kept.into_iter().map(|index| points[index]).collect()
}

/// The faces of a hull, cut into fans.
fn triangles(tables: &HullTables) -> Vec<[Vector; 3]> {
    let corner = |index: u8| tables.vertices[usize::from(index)].to_array().map(f64::from);
    let fans = tables.faces.iter().flat_map(|face| {
        let (first, count) = (usize::from(face.first), usize::from(face.count));
        let corners = &tables.loops[first..first + count];
        (1..count - 1).map(move |i| [corners[0], corners[i], corners[i + 1]].map(corner))
    });
    fans.collect()
}

/// Points on an ellipsoid, as many as a hull may have: MuJoCo's form, for which cellstep has none.
pub(super) fn ellipsoid(half_axes: Vector) -> Vec<[f32; 3]> {
    let (rings, sectors) = (7, 8);
    let mut points = vec![[0.0, 0.0, half_axes[2]], [0.0, 0.0, -half_axes[2]]];
    for ring in 1..=rings {
        let (up, out) = sine_cosine(PI / 2.0 - PI * ring as f64 / (rings + 1) as f64);
        for sector in 0..sectors {
            let (y, x) = sine_cosine(2.0 * PI * sector as f64 / sectors as f64);
            points.push([half_axes[0] * out * x, half_axes[1] * out * y, half_axes[2] * up]);
        }
    }
    points.into_iter().map(|p| p.map(|x| x as f32)).collect()
}

fn sine_cosine(angle: f64) -> (f64, f64) {
    (libm::sin(angle), libm::cos(angle))
}
