//! Shapes and their materials.

use crate::border::{change, make, read, there};
use crate::error::{CsResult, Failure};
use crate::types::{CsBody, CsPose, CsRotation, CsShape, CsVec3, body_kinds, same};
use crate::world::CsWorld;
use bytemuck::{Pod, Zeroable};
use cellstep::math::Vec3;
use cellstep::{
    CompoundHandle, Filter, Geometry, HeightFieldHandle, HullHandle, MaterialTraits, MeshHandle, Mix,
    ShapeDef, ShapeEvents,
};
use std::mem::MaybeUninit;

/// `size` x: radius.
pub const CS_SPHERE: u32 = 0;
/// `size` x: radius, y: half the height of the segment along z.
pub const CS_CAPSULE: u32 = 1;
/// `size`: half of each edge.
pub const CS_BOX: u32 = 2;
/// `asset`: a hull.
pub const CS_HULL: u32 = 3;
/// Everything below the plane z = 0.
pub const CS_HALF_SPACE: u32 = 4;
/// `asset`: a mesh.
pub const CS_MESH: u32 = 5;
/// `size` x: radius, y: half the height along z.
pub const CS_CYLINDER: u32 = 6;
/// `size` x: radius of the base, y: half the height along z.
pub const CS_CONE: u32 = 7;
/// `asset`: a hull; `size` x: the radius by which it is larger.
pub const CS_ROUNDED_HULL: u32 = 8;
/// `asset`: a height field.
pub const CS_HEIGHT_FIELD: u32 = 9;
/// `asset`: a compound.
pub const CS_COMPOUND: u32 = 10;

/// A geometry in its own frame, metres.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct CsGeometry {
    /// `CS_SPHERE` to `CS_COMPOUND`.
    pub kind: u32,
    /// By kind; what is not used is left alone.
    pub size: CsVec3,
    /// Number of the asset, as its function told.
    pub asset: u32,
}

impl CsGeometry {
    pub(crate) fn read(&self) -> Result<Geometry, Failure> {
        let (radius, half_height) = (self.size.x, self.size.y);
        Ok(match self.kind {
            CS_SPHERE => Geometry::Sphere { radius },
            CS_CAPSULE => Geometry::Capsule { half_height, radius },
            CS_BOX => Geometry::Box { half_extents: self.size.into() },
            CS_HULL => Geometry::Hull(HullHandle(self.asset)),
            CS_HALF_SPACE => Geometry::HalfSpace,
            CS_MESH => Geometry::Mesh(MeshHandle(self.asset)),
            CS_CYLINDER => Geometry::Cylinder { half_height, radius },
            CS_CONE => Geometry::Cone { half_height, radius },
            CS_ROUNDED_HULL => Geometry::RoundedHull { hull: HullHandle(self.asset), radius },
            CS_HEIGHT_FIELD => Geometry::HeightField(HeightFieldHandle(self.asset)),
            CS_COMPOUND => Geometry::Compound(CompoundHandle(self.asset)),
            _ => return Err(Failure::UnknownKind("geometry")),
        })
    }
}

/// Which shapes meet: those of the same positive group always, of the same negative one never, others when each
/// one's category is in the other's mask.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CsFilter {
    /// Bits of what this shape is.
    pub category: u32,
    /// Bits of what it meets.
    pub mask: u32,
    /// See the type.
    pub group: i32,
}

same! { CsFilter = Filter { category, mask, group } }

/// What the other shape says; else the geometric mean of frictions and the greater restitution.
pub const CS_MIX_UNSET: u32 = 0;
/// The root of the product.
pub const CS_MIX_GEOMETRIC_MEAN: u32 = 1;
/// Half the sum.
pub const CS_MIX_MEAN: u32 = 2;
/// The lesser one.
pub const CS_MIX_MIN: u32 = 3;
/// The product.
pub const CS_MIX_MULTIPLY: u32 = 4;
/// The greater one.
pub const CS_MIX_MAX: u32 = 5;

/// What a surface does beyond friction and restitution. All zero for nothing.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CsTraits {
    /// `CS_MIX_*`.
    pub friction_mix: u32,
    /// `CS_MIX_*`.
    pub restitution_mix: u32,
    /// Length of the resistance to rolling, metres.
    pub rolling: f32,
    /// Length of the resistance to spinning, metres.
    pub spinning: f32,
    /// Velocity of the surface in the shape's frame, m/s.
    pub surface_velocity: CsVec3,
    /// Direction in the shape's frame to which it is solid; zero for all.
    pub one_way: CsVec3,
}

impl CsTraits {
    fn read(&self) -> Result<MaterialTraits, Failure> {
        let one_way = Vec3::from(self.one_way);
        Ok(MaterialTraits {
            friction_mix: mix(self.friction_mix)?,
            restitution_mix: mix(self.restitution_mix)?,
            rolling: self.rolling,
            spinning: self.spinning,
            surface_velocity: self.surface_velocity.into(),
            one_way: (one_way != Vec3::ZERO).then_some(one_way),
        })
    }
}

fn mix(kind: u32) -> Result<Mix, Failure> {
    Ok(match kind {
        CS_MIX_UNSET => Mix::Unset,
        CS_MIX_GEOMETRIC_MEAN => Mix::GeometricMean,
        CS_MIX_MEAN => Mix::Mean,
        CS_MIX_MIN => Mix::Min,
        CS_MIX_MULTIPLY => Mix::Multiply,
        CS_MIX_MAX => Mix::Max,
        _ => return Err(Failure::UnknownKind("mix")),
    })
}

/// Contacts of the shape that begin or end are told.
pub const CS_WANTS_CONTACTS: u32 = 1;
/// Hits of the shape are told.
pub const CS_WANTS_HITS: u32 = 2;

/// What a new shape is like; start from `cs_shape_def`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CsShapeDef {
    /// Its geometry.
    pub geometry: CsGeometry,
    /// Where it stands in the body's frame.
    pub pose: CsPose,
    /// kg/m3; 0 adds no mass.
    pub density: f32,
    /// Coefficient of friction.
    pub friction: f32,
    /// Share of the approach speed that comes back, 0..=1.
    pub restitution: f32,
    /// What its surface does beside.
    pub traits: CsTraits,
    /// Which shapes it meets.
    pub filter: CsFilter,
    /// For a sensor the kinds of bodies that it detects, `CS_*_BIT`; 0 for a shape that makes contacts.
    pub sensor: u32,
    /// `CS_WANTS_*`.
    pub events: u32,
    /// Yours; part of the state.
    pub user: u64,
}

impl CsShapeDef {
    fn read(&self) -> Result<ShapeDef, Failure> {
        let detects = body_kinds(self.sensor)?;
        Ok(ShapeDef {
            geometry: self.geometry.read()?,
            pose: self.pose.into(),
            density: self.density,
            friction: self.friction,
            restitution: self.restitution,
            traits: self.traits.read()?,
            filter: self.filter.into(),
            sensor: (self.sensor != 0).then_some(detects),
            events: shape_events(self.events)?,
            user: self.user,
        })
    }
}

fn shape_events(bits: u32) -> Result<ShapeEvents, Failure> {
    u8::try_from(bits).map(ShapeEvents).map_err(|_| Failure::UnknownKind("events"))
}

/// A shape at the body's origin: density 1000 kg/m3, friction 0.6, no restitution, meets everything.
#[unsafe(no_mangle)]
pub extern "C" fn cs_shape_def(geometry: CsGeometry) -> CsShapeDef {
    let def = ShapeDef::new(Geometry::HalfSpace);
    CsShapeDef {
        geometry,
        pose: def.pose.into(),
        density: def.density,
        friction: def.friction,
        restitution: def.restitution,
        traits: CsTraits::default(),
        filter: def.filter.into(),
        sensor: 0,
        events: def.events.0.into(),
        user: def.user,
    }
}

/// A ball.
#[unsafe(no_mangle)]
pub extern "C" fn cs_sphere(radius: f32) -> CsGeometry {
    CsGeometry { kind: CS_SPHERE, size: CsVec3 { x: radius, y: 0.0, z: 0.0 }, asset: 0 }
}

/// A capsule along z.
#[unsafe(no_mangle)]
pub extern "C" fn cs_capsule(half_height: f32, radius: f32) -> CsGeometry {
    CsGeometry { kind: CS_CAPSULE, size: CsVec3 { x: radius, y: half_height, z: 0.0 }, asset: 0 }
}

/// A box.
#[unsafe(no_mangle)]
pub extern "C" fn cs_box(half_extents: CsVec3) -> CsGeometry {
    CsGeometry { kind: CS_BOX, size: half_extents, asset: 0 }
}

/// Everything below the plane z = 0 of the shape's frame.
#[unsafe(no_mangle)]
pub extern "C" fn cs_half_space() -> CsGeometry {
    CsGeometry { kind: CS_HALF_SPACE, ..CsGeometry::default() }
}

/// A shape of an asset: `kind` is `CS_HULL`, `CS_MESH`, `CS_HEIGHT_FIELD` or `CS_COMPOUND`.
#[unsafe(no_mangle)]
pub extern "C" fn cs_asset(kind: u32, asset: u32) -> CsGeometry {
    CsGeometry { kind, size: CsVec3::default(), asset }
}

/// Creates a shape on a body.
#[unsafe(no_mangle)]
pub extern "C" fn cs_shape_create(
    world: Option<&mut CsWorld>,
    body: CsBody,
    def: Option<&CsShapeDef>,
    out: Option<&mut MaybeUninit<CsShape>>,
) -> CsResult {
    make(world, out, |world| Ok(world.create_shape(body.into(), &there(def, "def")?.read()?)?.into()))
}

/// Removes a shape.
#[unsafe(no_mangle)]
pub extern "C" fn cs_shape_remove(world: Option<&mut CsWorld>, shape: CsShape) -> CsResult {
    change(world, |world| Ok(world.remove_shape(shape.into())?))
}

/// True when the handle names a shape that exists.
#[unsafe(no_mangle)]
pub extern "C" fn cs_shape_exists(world: Option<&CsWorld>, shape: CsShape) -> bool {
    world.is_some_and(|world| !world.is_broken && world.inner.contains_shape(shape.into()))
}

/// The body of a shape.
#[unsafe(no_mangle)]
pub extern "C" fn cs_shape_body(
    world: Option<&CsWorld>,
    shape: CsShape,
    out: Option<&mut MaybeUninit<CsBody>>,
) -> CsResult {
    read(world, out, |world| Ok(world.body_of(shape.into())?.into()))
}

/// The number that the shape was given.
#[unsafe(no_mangle)]
pub extern "C" fn cs_shape_user(
    world: Option<&CsWorld>,
    shape: CsShape,
    out: Option<&mut MaybeUninit<u64>>,
) -> CsResult {
    read(world, out, |world| Ok(world.shape_user(shape.into())?))
}

/// Gives a shape another geometry and place on its body.
#[unsafe(no_mangle)]
pub extern "C" fn cs_shape_set_geometry(
    world: Option<&mut CsWorld>,
    shape: CsShape,
    geometry: CsGeometry,
    position: CsVec3,
    rotation: CsRotation,
) -> CsResult {
    change(world, |world| {
        let pose = CsPose { position, rotation }.into();
        Ok(world.set_geometry(shape.into(), &geometry.read()?, &pose)?)
    })
}

/// Sets the density, kg/m3.
#[unsafe(no_mangle)]
pub extern "C" fn cs_shape_set_density(
    world: Option<&mut CsWorld>,
    shape: CsShape,
    density: f32,
) -> CsResult {
    change(world, |world| Ok(world.set_density(shape.into(), density)?))
}

/// Sets friction and restitution.
#[unsafe(no_mangle)]
pub extern "C" fn cs_shape_set_material(
    world: Option<&mut CsWorld>,
    shape: CsShape,
    friction: f32,
    restitution: f32,
) -> CsResult {
    change(world, |world| Ok(world.set_material(shape.into(), friction, restitution)?))
}

/// Sets what the surface does beside.
#[unsafe(no_mangle)]
pub extern "C" fn cs_shape_set_traits(
    world: Option<&mut CsWorld>,
    shape: CsShape,
    traits: CsTraits,
) -> CsResult {
    change(world, |world| Ok(world.set_material_traits(shape.into(), &traits.read()?)?))
}

/// Sets which shapes it meets.
#[unsafe(no_mangle)]
pub extern "C" fn cs_shape_set_filter(
    world: Option<&mut CsWorld>,
    shape: CsShape,
    filter: CsFilter,
) -> CsResult {
    change(world, |world| Ok(world.set_filter(shape.into(), filter.into())?))
}

/// Sets what is told of it, `CS_WANTS_*`.
#[unsafe(no_mangle)]
pub extern "C" fn cs_shape_set_events(world: Option<&mut CsWorld>, shape: CsShape, events: u32) -> CsResult {
    change(world, |world| Ok(world.set_shape_events(shape.into(), shape_events(events)?)?))
}
