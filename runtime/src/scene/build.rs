//! Document to world.

use super::check;
use super::clean::{self, Notes, Soup};
use super::error::{Problem, SceneError};
use super::format::*;
use super::place::Place;
use super::{Limits, joints, obj, rotation};
use crate::replay::AssetSet;
use crate::{Memory, new_world};
use cellstep_core::collide::height_field::HOLE;
use cellstep_core::math::{Pose, Rotation, Vec3};
use cellstep_core::{
    AxisLocks, BodyDef, BodyHandle, BodyKind, BodyKinds, Capacities, CompoundChild, CompoundHandle, Error,
    Filter, Geometry, HeightFieldDef, HeightFieldHandle, HullHandle, JointHandle, Line, MassProperties,
    MaterialTraits, MeshHandle, Position, ShapeDef, ShapeEvents, Surface, World,
};
use std::collections::BTreeMap;
use std::path::Path;

/// Room for pairs of boxes that a scene gets for each shape: a dense pile of alike bodies needs about 8.
pub const PAIRS_PER_SHAPE: u32 = 16;
/// Room for contacts that a scene gets for each shape: a ball in a dense pile touches up to 12 others and a
/// contact is shared by two; the rest is for meshes, where one pair may have several.
pub const CONTACTS_PER_SHAPE: u32 = 8;
/// Room for shapes in sensors that a scene with sensors gets for each shape.
pub const VISITS_PER_SHAPE: u32 = 4;
/// Room for pairs and for contacts that a scene gets on top: small scenes are not dense.
pub const ROOM_BASE: u32 = 64;
/// Most room for pairs and for contacts that a scene gets unasked: what [`Capacities`] allow.
const ROOM_MAX: u32 = 1 << 24;

/// A world made from a scene.
pub struct Build {
    /// The world, before its first step.
    pub world: World<Memory>,
    /// Its assets, for recordings.
    pub assets: AssetSet,
    /// Its bodies, in the order of the document.
    pub bodies: Vec<BodyHandle>,
    /// Its joints, in the order of the document.
    pub joints: Vec<JointHandle>,
    /// For each mesh that was mended on import: its name in the document and what was done.
    pub notes: Vec<(String, Notes)>,
}

/// The room that a scene gets: as many bodies, shapes, joints and assets as it has; [`PAIRS_PER_SHAPE`] and
/// [`CONTACTS_PER_SHAPE`], and with sensors room for 4 visits, for each shape and [`ROOM_BASE`] more; no events;
/// where the document names a capacity, that.
///
/// `vertices` and `triangles` are those of all meshes together.
pub fn capacities(scene: &Scene, vertices: usize, triangles: usize) -> Capacities {
    let count = |n: usize| u32::try_from(n).unwrap_or(u32::MAX);
    let given = &scene.capacities;
    let shapes = given.shapes.unwrap_or(count(scene.shape_count()));
    let room = |per_shape: u32| shapes.saturating_mul(per_shape).saturating_add(ROOM_BASE).min(ROOM_MAX);
    let visits = if scene.sensor_count() == 0 { 0 } else { room(VISITS_PER_SHAPE).min(1 << 20) };
    Capacities {
        bodies: given.bodies.unwrap_or(count(scene.bodies.len())),
        shapes,
        pairs: given.pairs.unwrap_or(room(PAIRS_PER_SHAPE)),
        contacts: given.contacts.unwrap_or(room(CONTACTS_PER_SHAPE)),
        sensor_visits: given.sensor_visits.unwrap_or(visits),
        events: given.events.unwrap_or(0),
        hulls: count(scene.hulls.len()),
        meshes: count(scene.meshes.len()),
        mesh_vertices: count(vertices),
        joints: given.joints.unwrap_or(count(joints::room(scene))),
        mesh_triangles: count(triangles),
        height_fields: count(scene.height_fields.len()),
        height_samples: count(scene.height_fields.values().map(|field| field.heights.len()).sum()),
        compounds: count(scene.compounds.len()),
        compound_children: count(scene.compounds.values().map(|compound| compound.children.len()).sum()),
        surfaces: count(scene.surface_count()),
        materials: given.materials.unwrap_or(count(materials_of(scene))),
        pair_rules: given.pair_rules.unwrap_or(0),
    }
}

/// How many materials have more than friction, restitution and density: an upper limit of the distinct ones.
fn materials_of(scene: &Scene) -> usize {
    scene.materials.values().filter(|material| material.traits() != MaterialTraits::default()).count()
}

impl Scene {
    /// Makes the world of this scene within the default [`Limits`]. Mesh files are looked for below `folder`.
    ///
    /// Everything is checked again, since a scene is a plain value; errors have the path in the document.
    pub fn build(&self, folder: &Path) -> Result<Build, SceneError> {
        self.build_within(folder, &Limits::default())
    }

    /// Makes the world of this scene within given limits. Mesh files are looked for below `folder`.
    pub fn build_within(&self, folder: &Path, limits: &Limits) -> Result<Build, SceneError> {
        check::check(self, limits)?;
        let mut notes = Vec::new();
        let meshes = meshes(self, folder, limits, &mut notes)?;
        let vertices = meshes.iter().map(|mesh| mesh.vertices.len()).sum();
        let triangles = meshes.iter().map(|mesh| mesh.triangles.len()).sum();
        let capacities = capacities(self, vertices, triangles);
        let world = Place::Root;
        check::at_most(
            world.key("capacities"),
            "bytes of memory",
            (capacities.lines() as u64).saturating_mul(size_of::<Line>() as u64),
            limits.memory_bytes,
        )?;
        let refused = |place: Place<'_>, error| SceneError::new(place, Problem::World(error));
        let mut world = new_world(capacities).map_err(|e| refused(Place::Root.key("capacities"), e))?;
        let mut settings = world.settings();
        self.settings.apply(&mut settings);
        settings.gravity = Vec3::from(self.gravity);
        world.set_settings(&settings).map_err(|e| refused(Place::Root.key("settings"), e))?;
        let mut set = AssetSet::new();
        let assets = register(self, &meshes, (&mut set, &mut world))?;
        let bodies = bodies(self, &assets, &mut world)?;
        let joints = self::joints(self, &bodies, &mut world)?;
        Ok(Build { world, assets: set, bodies, joints, notes })
    }
}

/// All meshes in the order of their names.
fn meshes(
    scene: &Scene,
    folder: &Path,
    limits: &Limits,
    notes: &mut Vec<(String, Notes)>,
) -> Result<Vec<Soup>, SceneError> {
    let mut meshes = Vec::with_capacity(scene.meshes.len());
    let table = Place::Root;
    let table = table.key("meshes");
    let mut parts = 0;
    for (name, doc) in &scene.meshes {
        let place = table.key(name);
        let (soup, mut found) = mesh(place, doc, folder, limits)?;
        let soup = clean::clean(soup, &mut found);
        if soup.triangles.is_empty() {
            return Err(SceneError::invalid(
                place,
                format!("nothing is left ({found})"),
                "triangles with an area",
            ));
        }
        // A small file named often must not become a large world.
        parts += soup.triangles.len().max(soup.vertices.len());
        check::at_most(place, "triangles and vertices in meshes", parts as u64, MESH_PARTS_MAX as u64)?;
        if !found.is_clean() {
            notes.push((name.clone(), found));
        }
        meshes.push(soup);
    }
    Ok(meshes)
}

fn mesh(
    place: Place<'_>,
    doc: &MeshDoc,
    folder: &Path,
    limits: &Limits,
) -> Result<(Soup, Notes), SceneError> {
    let (path, scale, turned) = match doc {
        MeshDoc::Inline { vertices, triangles, triangle_surfaces, .. } => {
            let soup = Soup {
                vertices: vertices.clone(),
                triangles: triangles.clone(),
                surfaces: triangle_surfaces.clone(),
            };
            return Ok((soup, Notes::default()));
        }
        MeshDoc::Obj { path, scale, rotation } => (path, *scale, rotation),
    };
    let file = folder.join(path);
    let place = place.key("obj");
    let (mut soup, notes) = obj::read(&file, limits.file_bytes).map_err(|mut error| {
        error.path = place.key("path").to_string();
        error
    })?;
    let turn = rotation::rotation(turned).unwrap_or(Rotation::IDENTITY);
    for vertex in &mut soup.vertices {
        let moved = turn.rotate(Vec3::from(*vertex) * scale);
        let fits = moved.abs().to_array().iter().all(|&x| x <= check::LENGTH_MAX);
        if !fits {
            let found = format!("{} has a vertex at {vertex:?} times {scale}", file.display());
            let expected = format!("coordinates within {:e} m", check::LENGTH_MAX);
            return Err(SceneError::invalid(place, found, expected));
        }
        *vertex = moved.to_array();
    }
    Ok((soup, notes))
}

/// Handles of the assets by name.
struct Assets<'a> {
    hulls: BTreeMap<&'a str, HullHandle>,
    meshes: BTreeMap<&'a str, MeshHandle>,
    height_fields: BTreeMap<&'a str, HeightFieldHandle>,
    compounds: BTreeMap<&'a str, CompoundHandle>,
}

fn register<'a>(
    scene: &'a Scene,
    soups: &[Soup],
    (set, world): (&mut AssetSet, &mut World<Memory>),
) -> Result<Assets<'a>, SceneError> {
    let refused = |table: &str, name: &str, error| {
        SceneError::new(Place::Root.key(table).key(name), Problem::World(error))
    };
    let mut hulls = BTreeMap::new();
    for (name, hull) in &scene.hulls {
        let points: Vec<Vec3> = hull.points.iter().copied().map(Vec3::from).collect();
        hulls.insert(name.as_str(), set.add_hull(world, &points).map_err(|e| refused("hulls", name, e))?);
    }
    let mut meshes = BTreeMap::new();
    for ((name, doc), soup) in scene.meshes.iter().zip(soups) {
        let vertices: Vec<Vec3> = soup.vertices.iter().copied().map(Vec3::from).collect();
        let surfaces = match doc {
            MeshDoc::Inline { surfaces, .. } => self::surfaces(surfaces, scene),
            MeshDoc::Obj { .. } => Vec::new(),
        };
        let mesh = if surfaces.is_empty() {
            set.add_mesh(world, &vertices, &soup.triangles)
        } else {
            set.add_mesh_with_surfaces(world, &vertices, &soup.triangles, (&soup.surfaces, &surfaces))
        };
        meshes.insert(name.as_str(), mesh.map_err(|e| refused("meshes", name, e))?);
    }
    let mut height_fields = BTreeMap::new();
    for (name, doc) in &scene.height_fields {
        let field = height_field(doc, scene, (set, world)).map_err(|e| refused("height_fields", name, e))?;
        height_fields.insert(name.as_str(), field);
    }
    let mut assets = Assets { hulls, meshes, height_fields, compounds: BTreeMap::new() };
    for (name, doc) in &scene.compounds {
        let child = |child: &ChildDoc| CompoundChild {
            geometry: geometry(&child.geometry, &assets),
            pose: Pose::new(Vec3::from(child.position), checked(&child.rotation)),
        };
        let children: Vec<CompoundChild> = doc.children.iter().map(child).collect();
        let compound = set.add_compound(world, &children).map_err(|e| refused("compounds", name, e))?;
        assets.compounds.insert(name.as_str(), compound);
    }
    Ok(assets)
}

/// Surfaces by the names of their materials, which were checked.
fn surfaces(names: &[String], scene: &Scene) -> Vec<Surface> {
    let surface = |name: &String| {
        let material = &scene.materials[name];
        Surface { friction: material.friction, restitution: material.restitution }
    };
    names.iter().map(surface).collect()
}

fn height_field(
    doc: &HeightFieldDoc,
    scene: &Scene,
    (set, world): (&mut AssetSet, &mut World<Memory>),
) -> Result<HeightFieldHandle, Error> {
    let surfaces = surfaces(&doc.surfaces, scene);
    let mut cells = doc.cell_surfaces.clone();
    if !doc.holes.is_empty() {
        cells.resize((doc.columns as usize - 1) * (doc.rows as usize - 1), 0);
    }
    for &[column, row] in &doc.holes {
        cells[row as usize * (doc.columns as usize - 1) + column as usize] = HOLE;
    }
    let def = HeightFieldDef {
        columns: doc.columns,
        rows: doc.rows,
        spacing: doc.spacing,
        heights: &doc.heights,
        cells: &cells,
        surfaces: &surfaces,
    };
    set.add_height_field(world, &def)
}

fn bodies(
    scene: &Scene,
    assets: &Assets<'_>,
    world: &mut World<Memory>,
) -> Result<Vec<BodyHandle>, SceneError> {
    let mut handles = Vec::with_capacity(scene.bodies.len());
    let list = Place::Root;
    let list = list.key("bodies");
    for (index, doc) in scene.bodies.iter().enumerate() {
        let place = list.index(index);
        let handle =
            world.create_body(&body_def(doc)).map_err(|e| SceneError::new(place, Problem::World(e)))?;
        let shapes = place.key("shapes");
        for (index, shape) in doc.shapes.iter().enumerate() {
            let refused = |e: Error| SceneError::new(shapes.index(index), Problem::World(e));
            world.create_shape(handle, &shape_def(shape, scene, assets)).map_err(refused)?;
        }
        handles.push(handle);
    }
    Ok(handles)
}

fn joints(
    scene: &Scene,
    bodies: &[BodyHandle],
    world: &mut World<Memory>,
) -> Result<Vec<JointHandle>, SceneError> {
    let mut handles = Vec::with_capacity(scene.joints.len());
    let list = Place::Root;
    let list = list.key("joints");
    let names = joints::names(scene);
    for (index, doc) in scene.joints.iter().enumerate() {
        // Checked: there is such a body.
        let body = |end: usize| joints::index_of(&doc.bodies[end], &names, bodies.len()).unwrap_or(0);
        let def = joints::definition(doc, [bodies[body(0)], bodies[body(1)]]);
        let refused = |e: Error| SceneError::new(list.index(index), Problem::World(e));
        handles.push(world.create_joint(&def).map_err(refused)?);
    }
    Ok(handles)
}

fn body_def(doc: &BodyDoc) -> BodyDef {
    let locks = doc.locks.iter().map(|lock| match lock {
        LockDoc::MoveX => AxisLocks::MOVE_X,
        LockDoc::MoveY => AxisLocks::MOVE_Y,
        LockDoc::MoveZ => AxisLocks::MOVE_Z,
        LockDoc::TurnX => AxisLocks::TURN_X,
        LockDoc::TurnY => AxisLocks::TURN_Y,
        LockDoc::TurnZ => AxisLocks::TURN_Z,
    });
    BodyDef {
        kind: match doc.kind {
            KindDoc::Static => BodyKind::Static,
            KindDoc::Kinematic => BodyKind::Kinematic,
            KindDoc::Dynamic => BodyKind::Dynamic,
        },
        position: Position::from_f64(doc.position),
        rotation: checked(&doc.rotation),
        linear_velocity: Vec3::from(doc.linear_velocity),
        angular_velocity: Vec3::from(doc.angular_velocity),
        linear_damping: doc.linear_damping,
        angular_damping: doc.angular_damping,
        gravity_scale: doc.gravity_scale,
        can_sleep: doc.can_sleep,
        bullet: doc.bullet,
        locks: locks.fold(AxisLocks::NONE, AxisLocks::and),
        mass: doc.mass.as_ref().map(|mass| MassProperties {
            mass: mass.mass,
            center: Vec3::from(mass.center),
            inertia: Vec3::from(mass.inertia),
            axes: checked(&mass.axes),
        }),
        user: doc.user,
    }
}

fn shape_def(doc: &ShapeDoc, scene: &Scene, assets: &Assets<'_>) -> ShapeDef {
    let geometry = geometry(&doc.geometry, assets);
    let material =
        doc.material.as_ref().map_or_else(MaterialDoc::default, |name| scene.materials[name].clone());
    let massless = doc.sensor && doc.material.is_none();
    ShapeDef {
        geometry,
        pose: Pose::new(Vec3::from(doc.position), checked(&doc.rotation)),
        density: if massless { 0.0 } else { material.density },
        friction: material.friction,
        restitution: material.restitution,
        traits: material.traits(),
        filter: Filter { category: doc.filter.category, mask: doc.filter.mask, group: doc.filter.group },
        sensor: doc.sensor.then_some(BodyKinds::MOVING),
        events: ShapeEvents::NONE,
        user: doc.user,
    }
}

/// The geometry of a document whose names were checked: each is in its table.
fn geometry(doc: &GeometryDoc, assets: &Assets<'_>) -> Geometry {
    match doc {
        GeometryDoc::Sphere { radius } => Geometry::Sphere { radius: *radius },
        GeometryDoc::Capsule { half_height, radius } => {
            Geometry::Capsule { half_height: *half_height, radius: *radius }
        }
        GeometryDoc::Box { half_extents } => Geometry::Box { half_extents: Vec3::from(*half_extents) },
        GeometryDoc::Hull(name) => Geometry::Hull(assets.hulls[name.as_str()]),
        GeometryDoc::HalfSpace => Geometry::HalfSpace,
        GeometryDoc::Mesh(name) => Geometry::Mesh(assets.meshes[name.as_str()]),
        GeometryDoc::Cylinder { half_height, radius } => {
            Geometry::Cylinder { half_height: *half_height, radius: *radius }
        }
        GeometryDoc::Cone { half_height, radius } => {
            Geometry::Cone { half_height: *half_height, radius: *radius }
        }
        GeometryDoc::RoundedHull { hull, radius } => {
            Geometry::RoundedHull { hull: assets.hulls[hull.as_str()], radius: *radius }
        }
        GeometryDoc::HeightField(name) => Geometry::HeightField(assets.height_fields[name.as_str()]),
        GeometryDoc::Compound(name) => Geometry::Compound(assets.compounds[name.as_str()]),
    }
}

/// A rotation that was checked before.
fn checked(doc: &RotationDoc) -> Rotation {
    rotation::rotation(doc).unwrap_or(Rotation::IDENTITY)
}
