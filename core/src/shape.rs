//! Shapes: geometry on a body, with its material and filter.

pub(crate) use crate::collide::{
    GEOMETRY_BOX, GEOMETRY_CAPSULE, GEOMETRY_COMPOUND, GEOMETRY_CONE, GEOMETRY_CYLINDER, GEOMETRY_HALF_SPACE,
    GEOMETRY_HEIGHT_FIELD, GEOMETRY_HULL, GEOMETRY_MESH, GEOMETRY_ROUNDED_HULL, GEOMETRY_SPHERE,
};
use crate::config;
use crate::error::Error;
use crate::handle::{CompoundHandle, HeightFieldHandle, HullHandle, MeshHandle};
use crate::material::{MaterialRow, MaterialTraits};
use crate::math::{Aabb, Pose, Vec3};
use crate::validate::{self, EXTENT_MAX, EXTENT_MIN};
use bytemuck::{Pod, Zeroable};

/// The geometry of a shape, in the shape's own frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Geometry {
    /// Ball around the origin.
    Sphere {
        /// Metres, 1e-5..=1e5.
        radius: f32,
    },
    /// All points within `radius` of the segment from `-half_height` to `half_height` on the z axis.
    Capsule {
        /// Half the length of the segment, metres, 0..=1e5.
        half_height: f32,
        /// Metres, 1e-5..=1e5.
        radius: f32,
    },
    /// Box around the origin.
    Box {
        /// Half of each edge, metres, 1e-5..=1e5.
        half_extents: Vec3,
    },
    /// A registered convex hull.
    Hull(HullHandle),
    /// Everything below the plane z = 0. Static and kinematic bodies only take part with it.
    HalfSpace,
    /// A registered triangle mesh. Static and kinematic bodies only take part with it.
    Mesh(MeshHandle),
    /// Cylinder around the z axis, from `-half_height` to `half_height`.
    Cylinder {
        /// Half the height, metres, 1e-5..=1e5.
        half_height: f32,
        /// Metres, 1e-5..=1e5.
        radius: f32,
    },
    /// Cone around the z axis: the apex at `half_height`, the base at `-half_height`. The center of mass is not the
    /// origin, but half of `half_height` below.
    Cone {
        /// Half the height, metres, 1e-5..=1e5.
        half_height: f32,
        /// Of the base, metres, 1e-5..=1e5.
        radius: f32,
    },
    /// All points within `radius` of a registered convex hull: it is larger than the hull by the radius, and its
    /// edges and corners are round.
    RoundedHull {
        /// The core.
        hull: HullHandle,
        /// Metres, 1e-5..=1e5.
        radius: f32,
    },
    /// A registered height field. Static and kinematic bodies only take part with it.
    HeightField(HeightFieldHandle),
    /// A registered compound of convex children.
    Compound(CompoundHandle),
}

impl Geometry {
    /// Refuses sizes that are not finite or out of the documented ranges. Handles are checked by the world.
    pub fn check(&self) -> Result<(), Error> {
        match *self {
            Geometry::Sphere { radius } => validate::in_range("radius", radius, EXTENT_MIN, EXTENT_MAX),
            Geometry::Capsule { half_height, radius } => {
                validate::in_range("radius", radius, EXTENT_MIN, EXTENT_MAX)?;
                validate::in_range("half_height", half_height, 0.0, EXTENT_MAX)
            }
            Geometry::Box { half_extents } => {
                for half in [half_extents.x, half_extents.y, half_extents.z] {
                    validate::in_range("half_extents", half, EXTENT_MIN, EXTENT_MAX)?;
                }
                Ok(())
            }
            Geometry::Cylinder { half_height, radius } | Geometry::Cone { half_height, radius } => {
                validate::in_range("radius", radius, EXTENT_MIN, EXTENT_MAX)?;
                validate::in_range("half_height", half_height, EXTENT_MIN, EXTENT_MAX)
            }
            Geometry::RoundedHull { radius, .. } => {
                validate::in_range("radius", radius, EXTENT_MIN, EXTENT_MAX)
            }
            Geometry::Hull(_)
            | Geometry::HalfSpace
            | Geometry::Mesh(_)
            | Geometry::HeightField(_)
            | Geometry::Compound(_) => Ok(()),
        }
    }

    /// Kind and sizes as rows keep them.
    pub(crate) fn to_row(self) -> (u32, [f32; 3]) {
        let asset = |index: u32| [f32::from_bits(index), 0.0, 0.0];
        match self {
            Geometry::Sphere { radius } => (GEOMETRY_SPHERE, [radius, 0.0, 0.0]),
            Geometry::Capsule { half_height, radius } => (GEOMETRY_CAPSULE, [radius, half_height, 0.0]),
            Geometry::Box { half_extents } => (GEOMETRY_BOX, half_extents.to_array()),
            Geometry::Hull(HullHandle(index)) => (GEOMETRY_HULL, asset(index)),
            Geometry::HalfSpace => (GEOMETRY_HALF_SPACE, [0.0; 3]),
            Geometry::Mesh(MeshHandle(index)) => (GEOMETRY_MESH, asset(index)),
            Geometry::Cylinder { half_height, radius } => (GEOMETRY_CYLINDER, [radius, half_height, 0.0]),
            Geometry::Cone { half_height, radius } => (GEOMETRY_CONE, [radius, half_height, 0.0]),
            Geometry::RoundedHull { hull: HullHandle(index), radius } => {
                (GEOMETRY_ROUNDED_HULL, [f32::from_bits(index), radius, 0.0])
            }
            Geometry::HeightField(HeightFieldHandle(index)) => (GEOMETRY_HEIGHT_FIELD, asset(index)),
            Geometry::Compound(CompoundHandle(index)) => (GEOMETRY_COMPOUND, asset(index)),
        }
    }

    /// What [`Geometry::to_row`] wrote; `None` when there is no such kind.
    pub(crate) fn from_row(kind: u32, size: [f32; 3]) -> Option<Self> {
        let asset = size[0].to_bits();
        Some(match kind {
            GEOMETRY_SPHERE => Geometry::Sphere { radius: size[0] },
            GEOMETRY_CAPSULE => Geometry::Capsule { radius: size[0], half_height: size[1] },
            GEOMETRY_BOX => Geometry::Box { half_extents: Vec3::from_array(size) },
            GEOMETRY_HULL => Geometry::Hull(HullHandle(asset)),
            GEOMETRY_HALF_SPACE => Geometry::HalfSpace,
            GEOMETRY_MESH => Geometry::Mesh(MeshHandle(asset)),
            GEOMETRY_CYLINDER => Geometry::Cylinder { radius: size[0], half_height: size[1] },
            GEOMETRY_CONE => Geometry::Cone { radius: size[0], half_height: size[1] },
            GEOMETRY_ROUNDED_HULL => Geometry::RoundedHull { hull: HullHandle(asset), radius: size[1] },
            GEOMETRY_HEIGHT_FIELD => Geometry::HeightField(HeightFieldHandle(asset)),
            GEOMETRY_COMPOUND => Geometry::Compound(CompoundHandle(asset)),
            _ => return None,
        })
    }

    /// True for surfaces without an inside: half-spaces, meshes and height fields. Dynamic bodies have none, and
    /// they never meet each other.
    pub fn is_surface(&self) -> bool {
        matches!(self, Geometry::HalfSpace | Geometry::Mesh(_) | Geometry::HeightField(_))
    }
}

/// Which shapes meet. Two shapes of one non-zero group meet if it is positive and not if it is negative; else they
/// meet when each one's category is in the other's mask.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
pub struct Filter {
    /// Bits of what this shape is.
    pub category: u32,
    /// Bits of what it meets.
    pub mask: u32,
    /// See the type.
    pub group: i32,
}

impl Default for Filter {
    fn default() -> Self {
        Self { category: 1, mask: u32::MAX, group: 0 }
    }
}

impl Filter {
    /// True when shapes with these filters meet.
    #[inline]
    pub fn meets(&self, other: &Self) -> bool {
        if self.group != 0 && self.group == other.group {
            return self.group > 0;
        }
        self.category & other.mask != 0 && other.category & self.mask != 0
    }
}

/// What a new shape is like.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShapeDef {
    /// Its geometry.
    pub geometry: Geometry,
    /// Where it stands in the body's frame; position at most 1e5 m from the origin.
    pub pose: Pose,
    /// kg/m3, 0..=1e9; 0 adds no mass.
    pub density: f32,
    /// Coefficient of friction, 0..=1e6; two shapes mix by the geometric mean, unless their traits say otherwise.
    pub friction: f32,
    /// Share of the approach speed that comes back, 0..=1; two shapes mix by the maximum, unless their traits
    /// say otherwise.
    pub restitution: f32,
    /// What its surface does beside.
    pub traits: MaterialTraits,
    /// Which shapes it meets.
    pub filter: Filter,
    /// Yours; part of the state.
    pub user: u64,
}

impl ShapeDef {
    /// A shape at the body's origin: density 1000 kg/m3, friction 0.6, no restitution, meets everything.
    pub fn new(geometry: Geometry) -> Self {
        Self {
            geometry,
            pose: Pose::IDENTITY,
            density: 1000.0,
            friction: 0.6,
            restitution: 0.0,
            traits: MaterialTraits::default(),
            filter: Filter::default(),
            user: 0,
        }
    }

    /// Refuses numbers that are not finite or out of the documented ranges.
    pub fn check(&self) -> Result<(), Error> {
        self.geometry.check()?;
        validate::pose("pose", &self.pose)?;
        validate::in_range("density", self.density, 0.0, 1.0e9)?;
        self.traits.check()?;
        check_material(self.friction, self.restitution)
    }
}

/// Refuses materials out of the ranges of [`ShapeDef`].
pub(crate) fn check_material(friction: f32, restitution: f32) -> Result<(), Error> {
    validate::in_range("friction", friction, 0.0, 1.0e6)?;
    validate::in_range("restitution", restitution, 0.0, 1.0)
}

/// A shape in the state.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub(crate) struct ShapeRow {
    /// Yours.
    pub user: u64,
    /// Slot of its body.
    pub body: u32,
    /// Next shape of the body, or `u32::MAX`.
    pub next: u32,
    /// `GEOMETRY_*`.
    pub kind: u32,
    /// Sizes, by kind; hulls, meshes, height fields and compounds keep their index in the first one's bits.
    pub size: [f32; 3],
    /// In the body's frame.
    pub pose: Pose,
    /// kg/m3.
    pub density: f32,
    /// Coefficient of friction.
    pub friction: f32,
    /// Coefficient of restitution.
    pub restitution: f32,
    /// Which shapes it meets.
    pub filter: Filter,
    /// Box with a margin, relative to the middle of the sector of the body's center.
    pub fat_box: Aabb,
    /// `BOX_STALE`, `FRESH`; in the upper half the index of the material's row, plus 1.
    pub flags: u32,
}

/// The box must be made anew, and the shape's pairs looked for.
pub(crate) const BOX_STALE: u32 = 1;
/// The shape is new in its slot, or changed: impulses of its contacts are not carried over.
pub(crate) const FRESH: u32 = 2;
/// Flags from this bit on are the index of the material's row, plus 1.
pub(crate) const MATERIAL_SHIFT: u32 = 16;

impl ShapeRow {
    pub fn new(body: u32, def: &ShapeDef) -> Self {
        let mut row = Self {
            user: def.user,
            body,
            next: u32::MAX,
            kind: 0,
            size: [0.0; 3],
            pose: Pose::new(def.pose.position, def.pose.rotation.normalized()),
            density: def.density,
            friction: def.friction,
            restitution: def.restitution,
            filter: def.filter,
            fat_box: Aabb::default(),
            flags: BOX_STALE | FRESH,
        };
        row.set_geometry(&def.geometry);
        row
    }

    pub fn set_geometry(&mut self, geometry: &Geometry) {
        (self.kind, self.size) = geometry.to_row();
    }

    /// The geometry; `None` when the row is not one that [`ShapeRow::set_geometry`] makes.
    pub fn geometry(&self) -> Option<Geometry> {
        Geometry::from_row(self.kind, self.size)
    }

    /// Index of the hull, mesh, height field or compound.
    #[inline(always)]
    pub fn asset(&self) -> u32 {
        self.size[0].to_bits()
    }

    /// Index of the row of what the material has beyond friction and restitution.
    pub fn material(&self) -> Option<u32> {
        (self.flags >> MATERIAL_SHIFT).checked_sub(1)
    }

    pub fn set_material(&mut self, index: Option<u32>) {
        let bits = index.map_or(0, |index| index + 1) << MATERIAL_SHIFT;
        self.flags = self.flags & ((1 << MATERIAL_SHIFT) - 1) | bits;
    }

    /// What the material has beyond friction and restitution.
    pub fn traits<'a>(&self, materials: &'a [MaterialRow]) -> &'a MaterialRow {
        self.material().map_or(&MaterialRow::NONE, |index| &materials[index as usize])
    }

    /// Half-spaces, meshes and height fields have no inside to push out of, and never meet each other.
    #[inline(always)]
    pub fn is_surface(&self) -> bool {
        matches!(self.kind, GEOMETRY_HALF_SPACE | GEOMETRY_MESH | GEOMETRY_HEIGHT_FIELD)
    }

    /// The margin of a fat box; bodies that never move need none.
    pub fn margin(dynamic: bool) -> f32 {
        config::SPECULATIVE_DISTANCE + if dynamic { config::BOX_MARGIN } else { 0.0 }
    }
}
