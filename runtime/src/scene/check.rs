//! The rules that a document obeys beyond its form: names exist, numbers are in their ranges, the whole stays
//! within the limits. Needs no file and takes no memory beside error messages.

mod assets;
mod joints;

use super::error::{Problem, SceneError};
use super::format::*;
use super::place::Place;
use super::{Limits, rotation};
use cellstep_core::config::{MANIFOLD_DRIFT, SECTOR_MAX, SECTOR_SIZE, Settings};
use std::collections::BTreeMap;

/// Greatest coordinate of a position, metres: where the sectors end.
const POSITION_MAX: f64 = SECTOR_MAX as f64 * SECTOR_SIZE as f64;
/// Range of lengths of shapes, metres.
const LENGTH_MIN: f32 = 1.0e-5;
pub(super) const LENGTH_MAX: f32 = 1.0e5;
/// Greatest speed, m/s and rad/s, and greatest component of gravity, m/s^2.
const SPEED_MAX: f32 = 1.0e6;
/// Greatest damping, 1/s.
const DAMPING_MAX: f32 = 1.0e4;
/// Greatest factor on gravity.
const GRAVITY_SCALE_MAX: f32 = 1.0e3;
/// Greatest length of a resistance to rolling or spinning, metres.
const RESISTANCE_MAX: f32 = 1.0e3;
/// Greatest component of the velocity of a surface, m/s.
const SURFACE_SPEED_MAX: f32 = 1.0e4;
/// Greatest component, and least length, of the direction to which a shape is solid.
const ONE_WAY_MAX: f32 = 1.0e6;
const ONE_WAY_MIN: f64 = 1.0e-5;
/// Greatest coefficient of friction.
const FRICTION_MAX: f32 = 1.0e6;
/// Greatest number of events, and of shapes in sensors.
const EVENTS_MAX: u64 = 1 << 20;
/// Greatest density, kg/m^3.
const DENSITY_MAX: f32 = 1.0e9;
/// Range of masses, kg, and of moments of inertia, kg m^2.
const MASS_MIN: f32 = 1.0e-12;
const MASS_MAX: f32 = 1.0e12;
const INERTIA_MIN: f32 = 1.0e-18;
const INERTIA_MAX: f32 = 1.0e24;

type Checked = Result<(), SceneError>;

/// Refuses a document that breaks a rule or exceeds a limit. The first offence in document order is reported.
pub(super) fn check(scene: &Scene, limits: &Limits) -> Checked {
    let root = Place::Root;
    if scene.version != 1 {
        return Err(SceneError::invalid(root.key("version"), format!("found {}", scene.version), "1"));
    }
    vector(root.key("gravity"), &scene.gravity, SPEED_MAX)?;
    settings(root.key("settings"), &scene.settings)?;
    sizes(scene, limits)?;
    let materials = root.key("materials");
    for (name, material) in &scene.materials {
        self::material(materials.key(name), material)?;
    }
    let hulls = root.key("hulls");
    for (name, hull) in &scene.hulls {
        self::hull(hulls.key(name), hull)?;
    }
    let meshes = root.key("meshes");
    for (name, mesh) in &scene.meshes {
        self::mesh(meshes.key(name), mesh, scene)?;
    }
    self::assets::check(scene)?;
    let bodies = root.key("bodies");
    for (index, body) in scene.bodies.iter().enumerate() {
        self::body(bodies.index(index), body, scene)?;
    }
    self::joints::body_names(scene)?;
    self::joints::check(scene)
}

fn sizes(scene: &Scene, limits: &Limits) -> Checked {
    at_most("bodies", "bodies", scene.bodies.len() as u64, limits.bodies)?;
    at_most("bodies", "shapes", scene.shape_count() as u64, limits.shapes)?;
    at_most("joints", "joints", scene.joints.len() as u64, limits.joints)?;
    let place = Place::Root;
    let place = place.key("capacities");
    let counts = &scene.capacities;
    let given = [
        ("bodies", counts.bodies, scene.bodies.len(), limits.bodies),
        ("shapes", counts.shapes, scene.shape_count(), limits.shapes),
        ("pairs", counts.pairs, 0, limits.contacts),
        ("contacts", counts.contacts, 0, limits.contacts),
        ("sensor_visits", counts.sensor_visits, usize::from(scene.sensor_count() > 0), EVENTS_MAX),
        ("events", counts.events, 0, EVENTS_MAX),
        ("joints", counts.joints, super::joints::room(scene), limits.joints),
    ];
    for (name, count, least, most) in given {
        let Some(count) = count else { continue };
        at_most(place.key(name), name, u64::from(count), most)?;
        if (count as usize) < least {
            let expected = format!("at least {least}, as many as the scene has");
            return Err(SceneError::invalid(place.key(name), format!("found {count}"), expected));
        }
    }
    Ok(())
}

/// Refuses `asked` things of a kind when there are more than `limit`.
pub(super) fn at_most(place: impl ToString, what: &'static str, asked: u64, limit: u64) -> Checked {
    if asked <= limit {
        return Ok(());
    }
    Err(SceneError::new(place, Problem::TooLarge { what, asked, limit }))
}

// The engine's own ranges, here so that the message can tell them.
fn settings(place: Place<'_>, doc: &SettingsDoc) -> Checked {
    let numbers = [
        ("dt", doc.dt, 0.25),
        ("manifold_drift", doc.manifold_drift, MANIFOLD_DRIFT),
        ("contact_frequency", doc.contact_frequency, 1.0e5),
        ("contact_damping_ratio", doc.contact_damping_ratio, 1.0e3),
        ("push_speed", doc.push_speed, 1.0e4),
        ("refine_sink", doc.refine_sink, 1.0e4),
        ("restitution_threshold", doc.restitution_threshold, 1.0e4),
        ("sleep_time", doc.sleep_time, 3600.0),
        ("sleep_speed", doc.sleep_speed, 1.0e4),
        ("tolerance", doc.tolerance, 1.0e6),
    ];
    for (name, value, high) in numbers {
        value.map_or(Ok(()), |x| range(place.key(name), x, 0.0, high))?;
    }
    let counts = [
        ("substeps", doc.substeps, 1, 256),
        ("sweeps", doc.sweeps, 1, 1024),
        ("sweeps_max", doc.sweeps_max, 1, 1024),
        ("relax_sweeps", doc.relax_sweeps, 0, 1024),
        ("inner_sweeps", doc.inner_sweeps, 1, 64),
        ("refine", doc.refine, 1, 64),
        ("refine_bodies", doc.refine_bodies, 0, 65_535),
        ("block_links", doc.block_links, 8, 4096),
    ];
    for (name, value, low, high) in counts {
        let Some(found) = value.filter(|count| !(low..=high).contains(count)) else { continue };
        let expected = format!("a whole number in {low}..={high}");
        return Err(SceneError::invalid(place.key(name), format!("found {found}"), expected));
    }
    let mut settings = Settings::default();
    doc.apply(&mut settings);
    settings.check().map_err(|error| SceneError::new(place, Problem::World(error)))
}

fn material(place: Place<'_>, material: &MaterialDoc) -> Checked {
    range(place.key("friction"), material.friction, 0.0, FRICTION_MAX)?;
    range(place.key("restitution"), material.restitution, 0.0, 1.0)?;
    range(place.key("density"), material.density, 0.0, DENSITY_MAX)?;
    range(place.key("rolling"), material.rolling, 0.0, RESISTANCE_MAX)?;
    range(place.key("spinning"), material.spinning, 0.0, RESISTANCE_MAX)?;
    vector(place.key("surface_velocity"), &material.surface_velocity, SURFACE_SPEED_MAX)?;
    let Some(direction) = &material.one_way else { return Ok(()) };
    vector(place.key("one_way"), direction, ONE_WAY_MAX)?;
    let length = direction.iter().map(|x| f64::from(*x) * f64::from(*x)).sum::<f64>().sqrt();
    if length < ONE_WAY_MIN {
        let expected = format!("a direction of length {ONE_WAY_MIN:e} at least");
        return Err(SceneError::invalid(place.key("one_way"), format!("found {direction:?}"), expected));
    }
    Ok(())
}

fn hull(place: Place<'_>, hull: &HullDoc) -> Checked {
    let points = place.key("points");
    if hull.points.len() < 4 {
        let found = format!("found {} points", hull.points.len());
        return Err(SceneError::invalid(points, found, "at least 4, not in one plane"));
    }
    hull.points
        .iter()
        .enumerate()
        .try_for_each(|(index, point)| vector(points.index(index), point, LENGTH_MAX))
}

fn mesh(place: Place<'_>, mesh: &MeshDoc, scene: &Scene) -> Checked {
    match mesh {
        MeshDoc::Obj { path, scale, rotation } => {
            let place = place.key("obj");
            super::obj::check_path(path).map_err(|found| {
                SceneError::invalid(
                    place.key("path"),
                    found,
                    "a path below the folder of the scene, without `..`",
                )
            })?;
            range(place.key("scale"), *scale, 1.0e-6, 1.0e6)?;
            turned(place.key("rotation"), rotation)
        }
        MeshDoc::Inline { vertices, triangles, surfaces, triangle_surfaces } => {
            let place = place.key("inline");
            let given = (surfaces.as_slice(), triangle_surfaces.as_slice());
            assets::surfaces(place, "triangle_surfaces", (given, triangles.len()), scene)?;
            let corners = place.key("vertices");
            for (index, vertex) in vertices.iter().enumerate() {
                vector(corners.index(index), vertex, LENGTH_MAX)?;
            }
            let place = place.key("triangles");
            for (index, triangle) in triangles.iter().enumerate() {
                if let Some(bad) = triangle.iter().find(|&&vertex| vertex as usize >= vertices.len()) {
                    let expected = format!("indices below {}, the number of vertices", vertices.len());
                    return Err(SceneError::invalid(
                        place.index(index),
                        format!("found index {bad}"),
                        expected,
                    ));
                }
            }
            if triangles.is_empty() {
                return Err(SceneError::invalid(place, "found none", "at least one triangle"));
            }
            Ok(())
        }
    }
}

fn body(place: Place<'_>, body: &BodyDoc, scene: &Scene) -> Checked {
    for x in body.position {
        if x.is_nan() || x.abs() > POSITION_MAX {
            let expected = format!("metres in -{POSITION_MAX:e}..={POSITION_MAX:e}");
            return Err(SceneError::invalid(place.key("position"), format!("found {x}"), expected));
        }
    }
    turned(place.key("rotation"), &body.rotation)?;
    vector(place.key("linear_velocity"), &body.linear_velocity, SPEED_MAX)?;
    vector(place.key("angular_velocity"), &body.angular_velocity, SPEED_MAX)?;
    range(place.key("linear_damping"), body.linear_damping, 0.0, DAMPING_MAX)?;
    range(place.key("angular_damping"), body.angular_damping, 0.0, DAMPING_MAX)?;
    range(place.key("gravity_scale"), body.gravity_scale, -GRAVITY_SCALE_MAX, GRAVITY_SCALE_MAX)?;
    if let Some(mass) = &body.mass {
        self::mass(place.key("mass"), mass)?;
    }
    let shapes = place.key("shapes");
    if body.kind == KindDoc::Dynamic && body.mass.is_none() && body.shapes.is_empty() {
        return Err(SceneError::invalid(
            shapes,
            "found none",
            "at least one shape, or `mass`, on a dynamic body",
        ));
    }
    for (index, shape) in body.shapes.iter().enumerate() {
        self::shape(shapes.index(index), shape, body.kind, scene)?;
    }
    Ok(())
}

fn mass(place: Place<'_>, mass: &MassDoc) -> Checked {
    range(place.key("mass"), mass.mass, MASS_MIN, MASS_MAX)?;
    vector(place.key("center"), &mass.center, LENGTH_MAX)?;
    let inertia = place.key("inertia");
    mass.inertia
        .iter()
        .enumerate()
        .try_for_each(|(i, &x)| range(inertia.index(i), x, INERTIA_MIN, INERTIA_MAX))?;
    turned(place.key("axes"), &mass.axes)?;
    let [x, y, z] = mass.inertia;
    let slack = 1.0e-6 * (x + y + z);
    if x > y + z + slack || y > z + x + slack || z > x + y + slack {
        let expected = "moments of which none exceeds the sum of the other two";
        return Err(SceneError::invalid(inertia, format!("found {:?}", mass.inertia), expected));
    }
    Ok(())
}

fn shape(place: Place<'_>, shape: &ShapeDoc, kind: KindDoc, scene: &Scene) -> Checked {
    let geometry = place.key("geometry");
    self::geometry(geometry, &shape.geometry, kind, scene)?;
    if let Some(name) = &shape.material {
        named(place.key("material"), "material", name, &scene.materials)?;
    }
    vector(place.key("position"), &shape.position, LENGTH_MAX)?;
    turned(place.key("rotation"), &shape.rotation)
}

fn geometry(geometry: Place<'_>, doc: &GeometryDoc, kind: KindDoc, scene: &Scene) -> Checked {
    match doc {
        GeometryDoc::Sphere { radius } => length(geometry.key("sphere").key("radius"), *radius)?,
        GeometryDoc::Capsule { half_height, radius } => {
            let capsule = geometry.key("capsule");
            range(capsule.key("half_height"), *half_height, 0.0, LENGTH_MAX)?;
            length(capsule.key("radius"), *radius)?;
        }
        GeometryDoc::Box { half_extents } => {
            let outer = geometry.key("box");
            let edges = outer.key("half_extents");
            half_extents.iter().enumerate().try_for_each(|(i, &x)| length(edges.index(i), x))?;
        }
        GeometryDoc::Hull(name) => named(geometry.key("hull"), "hull", name, &scene.hulls)?,
        GeometryDoc::HalfSpace => immovable(geometry, kind)?,
        GeometryDoc::Mesh(name) => {
            named(geometry.key("mesh"), "mesh", name, &scene.meshes)?;
            immovable(geometry, kind)?;
        }
        GeometryDoc::Cylinder { half_height, radius } => {
            let cylinder = geometry.key("cylinder");
            length(cylinder.key("half_height"), *half_height)?;
            length(cylinder.key("radius"), *radius)?;
        }
        GeometryDoc::Cone { half_height, radius } => {
            let cone = geometry.key("cone");
            length(cone.key("half_height"), *half_height)?;
            length(cone.key("radius"), *radius)?;
        }
        GeometryDoc::RoundedHull { hull, radius } => {
            let rounded = geometry.key("rounded_hull");
            named(rounded.key("hull"), "hull", hull, &scene.hulls)?;
            length(rounded.key("radius"), *radius)?;
        }
        GeometryDoc::HeightField(name) => {
            named(geometry.key("height_field"), "height field", name, &scene.height_fields)?;
            immovable(geometry, kind)?;
        }
        GeometryDoc::Compound(name) => {
            named(geometry.key("compound"), "compound", name, &scene.compounds)?;
        }
    }
    Ok(())
}

fn immovable(place: Place<'_>, kind: KindDoc) -> Checked {
    if kind != KindDoc::Dynamic {
        return Ok(());
    }
    let expected = "a body of kind \"static\" or \"kinematic\"";
    Err(SceneError::invalid(
        place,
        "found a half-space, a mesh or a height field on a dynamic body",
        expected,
    ))
}

fn named<T>(place: Place<'_>, what: &str, name: &str, table: &BTreeMap<String, T>) -> Checked {
    if table.contains_key(name) {
        return Ok(());
    }
    // A table may be long: a few names are enough to see a misspelling.
    let known: Vec<&str> = table.keys().take(8).map(String::as_str).collect();
    let expected = if known.is_empty() {
        format!("the name of an entry of `{}`, which has none", plural(what))
    } else {
        let more = if table.len() > known.len() { ", ..." } else { "" };
        format!("one of {}{more}", known.join(", "))
    };
    Err(SceneError::invalid(place, format!("no {what} is named {name:?}"), expected))
}

fn plural(what: &str) -> String {
    if what == "mesh" { "meshes".to_string() } else { format!("{}s", what.replace(' ', "_")) }
}

fn length(place: Place<'_>, x: f32) -> Checked {
    range(place, x, LENGTH_MIN, LENGTH_MAX)
}

fn vector(place: Place<'_>, v: &[f32; 3], limit: f32) -> Checked {
    v.iter().enumerate().try_for_each(|(index, &x)| range(place.index(index), x, -limit, limit))
}

fn range(place: Place<'_>, x: f32, low: f32, high: f32) -> Checked {
    // Not a number is in no range.
    if x >= low && x <= high {
        return Ok(());
    }
    Err(SceneError::invalid(place, format!("found {x}"), format!("a number in {low:?}..={high:?}")))
}

fn turned(place: Place<'_>, rotation: &RotationDoc) -> Checked {
    if rotation::rotation(rotation).is_some() {
        return Ok(());
    }
    let expected = "finite numbers, and an axis or a quaternion that is not zero";
    Err(SceneError::invalid(place, format!("found {rotation:?}"), expected))
}
