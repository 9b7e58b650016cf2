//! The scene document: one Rust struct for each JSON object.
//!
//! A document is a value: it owns no memory of a world, compares by `==`, and comes back equal (to the bit)
//! when it is written with [`Scene::to_json`] and read again. What has its default value is left out of the
//! text. `SCENES.md` describes the same fields for whoever writes scenes by hand.
//!
//! Choices: enums are externally tagged (`{"sphere": {...}}`), because the other ways buffer their input and
//! lose the line of a mistake; assets are named once and referred to by name, so a thousand rocks cost one
//! hull; unknown fields are refused, so a misspelled field is an error and not a default.

mod assets;
mod joints;
mod material;
mod settings;

use super::bounded::{bounded, unique};
pub use assets::{CHILDREN_MAX, ChildDoc, CompoundDoc, HeightFieldDoc, SURFACES_MAX};
pub use joints::{
    AxesDoc, AxisDoc, BodyRefDoc, DriveDoc, FrameDoc, JOINTS_MAX, JointDoc, JointKindDoc, MotionDoc,
    SpringDoc,
};
pub use material::{MaterialDoc, MixDoc};
use serde::{Deserialize, Serialize};
pub use settings::{ContactModelDoc, FrictionModelDoc, PresetDoc, SettingsDoc};
use std::collections::BTreeMap;

/// Most bodies of a document: refused by the reader before the rest is read.
pub const BODIES_MAX: usize = 1 << 18;
/// Most shapes of one body.
pub const SHAPES_PER_BODY_MAX: usize = 1 << 10;
/// Most entries of each table of named things (materials, hulls, meshes, height fields, compounds).
pub const NAMES_MAX: usize = 1 << 14;
/// Most points given for one hull.
pub const HULL_POINTS_MAX: usize = 1 << 12;
/// Most vertices, and most triangles, of one mesh.
pub const MESH_PARTS_MAX: usize = 1 << 22;

/// Gravity of a scene that names none, m/s^2: standard magnitude to three digits, z up.
pub const GRAVITY_DEFAULT: [f32; 3] = [0.0, 0.0, -9.81];
/// Friction of a material that names none: dry wood on wood, and what the built-in scenes use.
pub const FRICTION_DEFAULT: f32 = 0.6;
/// Density of a material that names none, kg/m^3: water.
pub const DENSITY_DEFAULT: f32 = 1000.0;

/// A scene: everything that a world starts with.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a scene object")]
pub struct Scene {
    /// Version of the format. Only 1 exists.
    #[serde(default = "version_default")]
    pub version: u32,
    /// What the scene shows, for people. Not used.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub description: String,
    /// Acceleration of free bodies, m/s^2.
    #[serde(default = "gravity_default")]
    pub gravity: [f32; 3],
    /// Time step and solver; what is left out keeps the engine's default.
    #[serde(default, skip_serializing_if = "is_default")]
    pub settings: SettingsDoc,
    /// Room to reserve; what is left out follows from the scene.
    #[serde(default, skip_serializing_if = "is_default")]
    pub capacities: CapacitiesDoc,
    /// Surfaces, by name.
    #[serde(default, deserialize_with = "unique", skip_serializing_if = "BTreeMap::is_empty")]
    pub materials: BTreeMap<String, MaterialDoc>,
    /// Convex hulls, by name. They are registered in the order of their names.
    #[serde(default, deserialize_with = "unique", skip_serializing_if = "BTreeMap::is_empty")]
    pub hulls: BTreeMap<String, HullDoc>,
    /// Triangle meshes, by name. They are registered in the order of their names.
    #[serde(default, deserialize_with = "unique", skip_serializing_if = "BTreeMap::is_empty")]
    pub meshes: BTreeMap<String, MeshDoc>,
    /// Height fields, by name. They are registered in the order of their names.
    #[serde(default, deserialize_with = "unique", skip_serializing_if = "BTreeMap::is_empty")]
    pub height_fields: BTreeMap<String, HeightFieldDoc>,
    /// Compounds, by name. They are registered in the order of their names.
    #[serde(default, deserialize_with = "unique", skip_serializing_if = "BTreeMap::is_empty")]
    pub compounds: BTreeMap<String, CompoundDoc>,
    /// Bodies, created in this order.
    #[serde(default, deserialize_with = "bounded::<_, _, BODIES_MAX>")]
    pub bodies: Vec<BodyDoc>,
    /// Joints of bodies, created in this order.
    #[serde(
        default,
        deserialize_with = "bounded::<_, _, JOINTS_MAX>",
        skip_serializing_if = "Vec::is_empty"
    )]
    pub joints: Vec<JointDoc>,
}

/// Room to reserve, in numbers of things. `None` follows from the scene (see [`crate::scene::capacities`]).
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, expecting = "an object of capacities")]
pub struct CapacitiesDoc {
    /// Bodies; at least as many as the scene has.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bodies: Option<u32>,
    /// Shapes; at least as many as the scene has.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shapes: Option<u32>,
    /// Pairs of shapes whose boxes overlap.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pairs: Option<u32>,
    /// Contacts: pairs of shapes that touch.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub contacts: Option<u32>,
    /// Joints, with four limits, drives and frictions for each on average; enough for those of the scene.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub joints: Option<u32>,
    /// Distinct materials with more than friction, restitution and density; at least as many as the scene uses.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub materials: Option<u32>,
    /// Pairs with rules of their own; none when left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pair_rules: Option<u32>,
    /// Shapes in sensors.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sensor_visits: Option<u32>,
    /// Events of a step.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub events: Option<u32>,
}

/// A convex hull.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a hull object")]
pub struct HullDoc {
    /// Points whose hull is meant, metres, in the shape's frame: at least four, not in one plane.
    #[serde(deserialize_with = "bounded::<_, _, HULL_POINTS_MAX>")]
    pub points: Vec<[f32; 3]>,
}

/// Where a mesh comes from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(
    rename_all = "snake_case",
    deny_unknown_fields,
    expecting = "a mesh, as {\"obj\": {\"path\": \"level.obj\"}}"
)]
pub enum MeshDoc {
    /// A Wavefront OBJ file.
    Obj {
        /// Path relative to the folder of the scene, without `..`, with `/` between folders.
        path: String,
        /// Every coordinate is multiplied by this, greater than 0; 0.01 reads centimetres.
        #[serde(default = "one", skip_serializing_if = "is_one")]
        scale: f32,
        /// Turns the scaled mesh: files with y up want 90 degrees about x.
        #[serde(default, skip_serializing_if = "is_default")]
        rotation: RotationDoc,
    },
    /// Vertices and triangles in the scene itself.
    Inline {
        /// Corners, metres.
        #[serde(deserialize_with = "bounded::<_, _, MESH_PARTS_MAX>")]
        vertices: Vec<[f32; 3]>,
        /// Indices of corners, from 0.
        #[serde(deserialize_with = "bounded::<_, _, MESH_PARTS_MAX>")]
        triangles: Vec<[u32; 3]>,
        /// Names of materials that triangles have in the place of the shape's.
        #[serde(
            default,
            deserialize_with = "bounded::<_, _, SURFACES_MAX>",
            skip_serializing_if = "Vec::is_empty"
        )]
        surfaces: Vec<String>,
        /// For each triangle an index into `surfaces`; empty when there are none.
        #[serde(
            default,
            deserialize_with = "bounded::<_, _, MESH_PARTS_MAX>",
            skip_serializing_if = "Vec::is_empty"
        )]
        triangle_surfaces: Vec<u8>,
    },
}

impl MeshDoc {
    /// Vertices and triangles in the scene itself, all with the material of their shape.
    pub fn inline(vertices: Vec<[f32; 3]>, triangles: Vec<[u32; 3]>) -> Self {
        Self::Inline { vertices, triangles, surfaces: Vec::new(), triangle_surfaces: Vec::new() }
    }
}

/// How a body moves.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum KindDoc {
    /// Never moves.
    Static,
    /// Moves by its velocity; nothing pushes it.
    Kinematic,
    /// Moves by forces and contacts.
    #[default]
    Dynamic,
}

/// A motion of a dynamic body that is locked, in world axes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum LockDoc {
    /// No motion along x.
    MoveX,
    /// No motion along y.
    MoveY,
    /// No motion along z.
    MoveZ,
    /// No turning about x.
    TurnX,
    /// No turning about y.
    TurnY,
    /// No turning about z.
    TurnZ,
}

/// A rotation in one of three spellings. Right-handed; need not be normalised.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(
    rename_all = "snake_case",
    deny_unknown_fields,
    expecting = "a rotation, as {\"euler_degrees\": [0, 0, 90]}"
)]
pub enum RotationDoc {
    /// `[x, y, z, w]`, the real part last.
    Quaternion([f32; 4]),
    /// A turn about an axis.
    AxisAngle {
        /// Direction, of any length but zero.
        axis: [f32; 3],
        /// Angle, degrees.
        degrees: f32,
    },
    /// About the fixed x axis first, then the fixed y axis, then the fixed z axis, degrees.
    EulerDegrees([f32; 3]),
}

impl Default for RotationDoc {
    fn default() -> Self {
        Self::Quaternion([0.0, 0.0, 0.0, 1.0])
    }
}

/// A body.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a body object")]
pub struct BodyDoc {
    /// By which joints may refer to it; not empty, and no other body's. `None` for those without.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// How it moves.
    #[serde(default, skip_serializing_if = "is_default")]
    pub kind: KindDoc,
    /// Where its frame stands, metres. Held as f64: far from the origin it is split into sector and offset.
    #[serde(default)]
    pub position: [f64; 3],
    /// How its frame is turned.
    #[serde(default, skip_serializing_if = "is_default")]
    pub rotation: RotationDoc,
    /// Velocity of the center of mass, m/s.
    #[serde(default, skip_serializing_if = "is_zero_each")]
    pub linear_velocity: [f32; 3],
    /// Angular velocity, rad/s, world axes.
    #[serde(default, skip_serializing_if = "is_zero_each")]
    pub angular_velocity: [f32; 3],
    /// Rate at which linear velocity decays, 1/s, not negative.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub linear_damping: f32,
    /// Rate at which angular velocity decays, 1/s, not negative.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub angular_damping: f32,
    /// Gravity is multiplied by this for the body.
    #[serde(default = "one", skip_serializing_if = "is_one")]
    pub gravity_scale: f32,
    /// Motions that are locked.
    #[serde(default, deserialize_with = "bounded::<_, _, 6>", skip_serializing_if = "Vec::is_empty")]
    pub locks: Vec<LockDoc>,
    /// Mass in place of what the shapes and their densities give.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mass: Option<MassDoc>,
    /// Whether it may fall asleep.
    #[serde(default = "yes", skip_serializing_if = "is_true")]
    pub can_sleep: bool,
    /// Whether it is stopped at other dynamic bodies too when it is fast.
    #[serde(default, skip_serializing_if = "is_default")]
    pub bullet: bool,
    /// The game's own number.
    #[serde(default, skip_serializing_if = "is_default")]
    pub user: u64,
    /// What it consists of.
    #[serde(default, deserialize_with = "bounded::<_, _, SHAPES_PER_BODY_MAX>")]
    pub shapes: Vec<ShapeDoc>,
}

impl Default for BodyDoc {
    fn default() -> Self {
        Self {
            name: None,
            kind: KindDoc::Dynamic,
            position: [0.0; 3],
            rotation: RotationDoc::default(),
            linear_velocity: [0.0; 3],
            angular_velocity: [0.0; 3],
            linear_damping: 0.0,
            angular_damping: 0.0,
            gravity_scale: 1.0,
            locks: Vec::new(),
            mass: None,
            can_sleep: true,
            bullet: false,
            user: 0,
            shapes: Vec::new(),
        }
    }
}

/// Mass properties of a body.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, expecting = "an object of mass properties")]
pub struct MassDoc {
    /// Mass, kg, greater than 0.
    pub mass: f32,
    /// Center of mass in the body's frame, metres.
    #[serde(default, skip_serializing_if = "is_zero_each")]
    pub center: [f32; 3],
    /// Principal moments of inertia about the center of mass, kg m^2, each greater than 0.
    pub inertia: [f32; 3],
    /// How the principal axes are turned in the body's frame.
    #[serde(default, skip_serializing_if = "is_default")]
    pub axes: RotationDoc,
}

/// A shape of a body.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a shape object")]
pub struct ShapeDoc {
    /// Its form.
    pub geometry: GeometryDoc,
    /// Name of its material; the default material when left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub material: Option<String>,
    /// Where it stands in the body's frame, metres.
    #[serde(default, skip_serializing_if = "is_zero_each")]
    pub position: [f32; 3],
    /// How it is turned in the body's frame.
    #[serde(default, skip_serializing_if = "is_default")]
    pub rotation: RotationDoc,
    /// What it collides with.
    #[serde(default, skip_serializing_if = "is_default")]
    pub filter: FilterDoc,
    /// Whether it only detects shapes of bodies that may move, without contacts; it has no mass unless a material
    /// is named.
    #[serde(default, skip_serializing_if = "is_default")]
    pub sensor: bool,
    /// The game's own number.
    #[serde(default, skip_serializing_if = "is_default")]
    pub user: u64,
}

impl ShapeDoc {
    /// A shape at the body's origin with the default material and filter.
    pub fn new(geometry: GeometryDoc) -> Self {
        Self {
            geometry,
            material: None,
            position: [0.0; 3],
            rotation: RotationDoc::default(),
            filter: FilterDoc::default(),
            sensor: false,
            user: 0,
        }
    }
}

/// The form of a shape.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(
    rename_all = "snake_case",
    deny_unknown_fields,
    expecting = "a geometry, as {\"sphere\": {\"radius\": 1}}"
)]
pub enum GeometryDoc {
    /// Ball around the origin.
    Sphere {
        /// Metres, greater than 0.
        radius: f32,
    },
    /// All points within `radius` of a segment on the z axis.
    Capsule {
        /// Half the length of the segment, metres, not negative.
        half_height: f32,
        /// Metres, greater than 0.
        radius: f32,
    },
    /// Box around the origin.
    Box {
        /// Half of each edge, metres, each greater than 0.
        half_extents: [f32; 3],
    },
    /// A hull of the scene, by name.
    Hull(String),
    /// All points with z <= 0. Not on dynamic bodies.
    HalfSpace,
    /// A mesh of the scene, by name. Not on dynamic bodies.
    Mesh(String),
    /// Cylinder around the z axis.
    Cylinder {
        /// Half the height, metres, greater than 0.
        half_height: f32,
        /// Metres, greater than 0.
        radius: f32,
    },
    /// Cone around the z axis, apex up.
    Cone {
        /// Half the height, metres, greater than 0.
        half_height: f32,
        /// Of the base, metres, greater than 0.
        radius: f32,
    },
    /// All points within `radius` of a hull.
    RoundedHull {
        /// A hull of the scene, by name.
        hull: String,
        /// Metres, greater than 0.
        radius: f32,
    },
    /// A height field of the scene, by name. Not on dynamic bodies.
    HeightField(String),
    /// A compound of the scene, by name.
    Compound(String),
}

/// Which shapes collide: when each one's category is in the other's mask; shapes of one group other than 0
/// always (positive) or never (negative).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a filter object")]
pub struct FilterDoc {
    /// Bits of what the shape is.
    #[serde(default = "category_default")]
    pub category: u32,
    /// Bits of what it collides with.
    #[serde(default = "mask_default")]
    pub mask: u32,
    /// Group, or 0.
    #[serde(default, skip_serializing_if = "is_default")]
    pub group: i32,
}

impl Default for FilterDoc {
    fn default() -> Self {
        Self { category: category_default(), mask: mask_default(), group: 0 }
    }
}

impl Default for Scene {
    fn default() -> Self {
        Self {
            version: version_default(),
            description: String::new(),
            gravity: GRAVITY_DEFAULT,
            settings: SettingsDoc::default(),
            capacities: CapacitiesDoc::default(),
            materials: BTreeMap::new(),
            hulls: BTreeMap::new(),
            meshes: BTreeMap::new(),
            height_fields: BTreeMap::new(),
            compounds: BTreeMap::new(),
            bodies: Vec::new(),
            joints: Vec::new(),
        }
    }
}

impl Scene {
    /// Number of shapes of all bodies.
    pub fn shape_count(&self) -> usize {
        self.bodies.iter().map(|body| body.shapes.len()).sum()
    }

    /// Sensors of all bodies.
    pub fn sensor_count(&self) -> usize {
        self.bodies.iter().flat_map(|body| &body.shapes).filter(|shape| shape.sensor).count()
    }

    /// Number of surfaces of all meshes and height fields.
    pub fn surface_count(&self) -> usize {
        let of_mesh = |mesh: &MeshDoc| match mesh {
            MeshDoc::Inline { surfaces, .. } => surfaces.len(),
            MeshDoc::Obj { .. } => 0,
        };
        let of_meshes: usize = self.meshes.values().map(of_mesh).sum();
        of_meshes + self.height_fields.values().map(|field| field.surfaces.len()).sum::<usize>()
    }
}

fn yes() -> bool {
    true
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde asks for a reference")]
fn is_true(x: &bool) -> bool {
    *x
}

fn version_default() -> u32 {
    1
}

fn gravity_default() -> [f32; 3] {
    GRAVITY_DEFAULT
}

fn friction_default() -> f32 {
    FRICTION_DEFAULT
}

fn density_default() -> f32 {
    DENSITY_DEFAULT
}

fn category_default() -> u32 {
    1
}

fn mask_default() -> u32 {
    u32::MAX
}

fn one() -> f32 {
    1.0
}

fn is_one(x: &f32) -> bool {
    *x == 1.0
}

// Compared by bits: -0.0 must come back as it was.
fn is_zero(x: &f32) -> bool {
    x.to_bits() == 0
}

fn is_zero_each(v: &[f32; 3]) -> bool {
    v.iter().all(is_zero)
}

fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}
