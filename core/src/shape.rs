//! Shapes: geometry on a body, with its material and filter.

use crate::config;
use crate::error::Error;
use crate::handle::{HullHandle, MeshHandle};
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
            Geometry::Hull(_) | Geometry::HalfSpace | Geometry::Mesh(_) => Ok(()),
        }
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
    /// Coefficient of friction, 0..=1e6; two shapes mix by the geometric mean.
    pub friction: f32,
    /// Share of the approach speed that comes back, 0..=1; two shapes mix by the maximum.
    pub restitution: f32,
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
            filter: Filter::default(),
            user: 0,
        }
    }

    /// Refuses numbers that are not finite or out of the documented ranges.
    pub fn check(&self) -> Result<(), Error> {
        self.geometry.check()?;
        validate::pose("pose", &self.pose)?;
        validate::in_range("density", self.density, 0.0, 1.0e9)?;
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
    /// Sizes, by kind; hulls and meshes keep their index in the first one's bits.
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
    /// `BOX_STALE`, `FRESH`.
    pub flags: u32,
}

pub(crate) const GEOMETRY_SPHERE: u32 = 1;
pub(crate) const GEOMETRY_CAPSULE: u32 = 2;
pub(crate) const GEOMETRY_BOX: u32 = 3;
pub(crate) const GEOMETRY_HULL: u32 = 4;
pub(crate) const GEOMETRY_HALF_SPACE: u32 = 5;
pub(crate) const GEOMETRY_MESH: u32 = 6;

/// The box must be made anew, and the shape's pairs looked for.
pub(crate) const BOX_STALE: u32 = 1;
/// The shape is new in its slot, or changed: impulses of its contacts are not carried over.
pub(crate) const FRESH: u32 = 2;

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
        (self.kind, self.size) = match *geometry {
            Geometry::Sphere { radius } => (GEOMETRY_SPHERE, [radius, 0.0, 0.0]),
            Geometry::Capsule { half_height, radius } => (GEOMETRY_CAPSULE, [radius, half_height, 0.0]),
            Geometry::Box { half_extents } => (GEOMETRY_BOX, half_extents.to_array()),
            Geometry::Hull(HullHandle(index)) => (GEOMETRY_HULL, [f32::from_bits(index), 0.0, 0.0]),
            Geometry::HalfSpace => (GEOMETRY_HALF_SPACE, [0.0; 3]),
            Geometry::Mesh(MeshHandle(index)) => (GEOMETRY_MESH, [f32::from_bits(index), 0.0, 0.0]),
        };
    }

    /// The geometry; `None` when the row is not one that [`ShapeRow::set_geometry`] makes.
    pub fn geometry(&self) -> Option<Geometry> {
        Some(match self.kind {
            GEOMETRY_SPHERE => Geometry::Sphere { radius: self.size[0] },
            GEOMETRY_CAPSULE => Geometry::Capsule { radius: self.size[0], half_height: self.size[1] },
            GEOMETRY_BOX => Geometry::Box { half_extents: Vec3::from_array(self.size) },
            GEOMETRY_HULL => Geometry::Hull(HullHandle(self.asset())),
            GEOMETRY_HALF_SPACE => Geometry::HalfSpace,
            GEOMETRY_MESH => Geometry::Mesh(MeshHandle(self.asset())),
            _ => return None,
        })
    }

    /// Index of the hull or mesh.
    #[inline(always)]
    pub fn asset(&self) -> u32 {
        self.size[0].to_bits()
    }

    /// Half-spaces and meshes have no inside to push out of, and never meet each other.
    #[inline(always)]
    pub fn is_convex(&self) -> bool {
        self.kind <= GEOMETRY_HULL
    }

    /// The margin of a fat box; bodies that never move need none.
    pub fn margin(dynamic: bool) -> f32 {
        config::SPECULATIVE_DISTANCE + if dynamic { config::BOX_MARGIN } else { 0.0 }
    }
}
