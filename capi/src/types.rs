//! Values that C and the engine share.

use crate::error::Failure;
use bytemuck::{Pod, Zeroable};
use cellstep::math::{Pose, Rotation, Vec3};
use cellstep::{
    BodyHandle, BodyKind, BodyKinds, Capacities, ContactModel, EventKinds, FrictionModel, JointHandle,
    Position, Preset, Residual, Settings, ShapeHandle, StepReport,
};

/// A vector.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct CsVec3 {
    /// Along x.
    pub x: f32,
    /// Along y.
    pub y: f32,
    /// Along z.
    pub z: f32,
}

/// A rotation as a unit quaternion; `w` is the real part.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct CsRotation {
    /// First imaginary part.
    pub x: f32,
    /// Second imaginary part.
    pub y: f32,
    /// Third imaginary part.
    pub z: f32,
    /// The real part.
    pub w: f32,
}

/// Where one frame stands in another.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct CsPose {
    /// Where the origin is, metres.
    pub position: CsVec3,
    /// How the frame is turned.
    pub rotation: CsRotation,
}

/// A place in the world: a sector of 64 m and metres from its middle. A zero sector is around the origin; offsets
/// beyond 33 m are brought to their sector.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct CsPosition {
    /// Sector along x, y and z.
    pub sector: [i32; 3],
    /// Metres from the middle of the sector.
    pub offset: CsVec3,
}

/// Names a body. Goes stale when the body is removed; exact again after a restore to a time when it existed.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct CsBody {
    /// Slot in the pool.
    pub index: u32,
    /// Which tenant of the slot; 0 is never one.
    pub generation: u32,
}

/// Names a shape of a body.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct CsShape {
    /// Slot in the pool.
    pub index: u32,
    /// Which tenant of the slot; 0 is never one.
    pub generation: u32,
}

/// Names a joint.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct CsJoint {
    /// Slot in the pool.
    pub index: u32,
    /// Which tenant of the slot; 0 is never one.
    pub generation: u32,
}

macro_rules! same {
    ($($own:ident = $engine:ty { $($field:ident),* }),* $(,)?) => { $(
        impl From<$own> for $engine {
            fn from(own: $own) -> Self {
                Self { $($field: own.$field.into()),* }
            }
        }
        impl From<$engine> for $own {
            fn from(theirs: $engine) -> Self {
                Self { $($field: theirs.$field.into()),* }
            }
        }
    )* };
}
pub(crate) use same;

same! {
    CsVec3 = Vec3 { x, y, z },
    CsRotation = Rotation { x, y, z, w },
    CsPose = Pose { position, rotation },
    CsBody = BodyHandle { index, generation },
    CsShape = ShapeHandle { index, generation },
    CsJoint = JointHandle { index, generation },
    CsCapacities = Capacities {
        bodies, shapes, pairs, contacts, joints, hulls, meshes, mesh_vertices, mesh_triangles, height_fields,
        height_samples, compounds, compound_children, surfaces, materials, pair_rules, events, sensor_visits
    },
}

impl From<CsPosition> for Position {
    fn from(own: CsPosition) -> Self {
        Self { sector: own.sector, offset: own.offset.into() }.normalized()
    }
}

impl From<Position> for CsPosition {
    fn from(theirs: Position) -> Self {
        Self { sector: theirs.sector, offset: theirs.offset.into() }
    }
}

/// A body that never moves.
pub const CS_STATIC: u32 = 0;
/// A body that moves as told; pushes, is not pushed.
pub const CS_KINEMATIC: u32 = 1;
/// A body that moves by forces and contacts.
pub const CS_DYNAMIC: u32 = 2;

/// Static bodies, in sets of kinds.
pub const CS_STATIC_BIT: u32 = 1;
/// Kinematic bodies, in sets of kinds.
pub const CS_KINEMATIC_BIT: u32 = 2;
/// Dynamic bodies, in sets of kinds.
pub const CS_DYNAMIC_BIT: u32 = 4;
/// All kinds of bodies.
pub const CS_ALL_BITS: u32 = 7;

pub(crate) fn body_kind(kind: u32) -> Result<BodyKind, Failure> {
    match kind {
        CS_STATIC => Ok(BodyKind::Static),
        CS_KINEMATIC => Ok(BodyKind::Kinematic),
        CS_DYNAMIC => Ok(BodyKind::Dynamic),
        _ => Err(Failure::UnknownKind("kind")),
    }
}

pub(crate) fn body_kinds(bits: u32) -> Result<BodyKinds, Failure> {
    if bits > CS_ALL_BITS { Err(Failure::UnknownKind("kinds")) } else { Ok(BodyKinds(bits as u8)) }
}

/// How much a world can hold; part of its behaviour.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
pub struct CsCapacities {
    /// Bodies.
    pub bodies: u32,
    /// Shapes of all bodies.
    pub shapes: u32,
    /// Pairs of shapes whose boxes overlap.
    pub pairs: u32,
    /// Contacts.
    pub contacts: u32,
    /// Joints.
    pub joints: u32,
    /// Convex hulls.
    pub hulls: u32,
    /// Triangle meshes.
    pub meshes: u32,
    /// Vertices of all meshes.
    pub mesh_vertices: u32,
    /// Triangles of all meshes.
    pub mesh_triangles: u32,
    /// Height fields.
    pub height_fields: u32,
    /// Samples of all height fields.
    pub height_samples: u32,
    /// Compounds.
    pub compounds: u32,
    /// Children of all compounds.
    pub compound_children: u32,
    /// Surfaces of all meshes and height fields.
    pub surfaces: u32,
    /// Distinct traits of materials.
    pub materials: u32,
    /// Pairs with a rule of their own.
    pub pair_rules: u32,
    /// Events of a step; 0 for none.
    pub events: u32,
    /// Shapes in sensors, each counted once for each sensor; 0 for a world without sensors.
    pub sensor_visits: u32,
}

/// Room for so many bodies of one shape each with 8 pairs and 5 contacts each, no joints, assets and events.
#[unsafe(no_mangle)]
pub extern "C" fn cs_capacities(bodies: u32) -> CsCapacities {
    // More than the greatest capacity is refused later; the products must not overflow here.
    Capacities::for_bodies(bodies.min(1 << 24)).into()
}

/// Contacts are damped springs.
pub const CS_CONTACT_SOFT: u32 = 0;
/// Contacts have no softness.
pub const CS_CONTACT_RIGID: u32 = 1;
/// Contacts that carry rigidly, and whose overlap is moved away.
pub const CS_CONTACT_SPLIT: u32 = 2;

/// Friction is that of the patch of a contact.
pub const CS_FRICTION_PATCH: u32 = 0;
/// Each point of a contact has a cone of friction.
pub const CS_FRICTION_POINTS: u32 = 1;

/// The dial between speed and accuracy: for what is looked at from afar.
pub const CS_PRESET_FAST: u32 = 0;
/// The default.
pub const CS_PRESET_BALANCED: u32 = 1;
/// Twice the substeps: everything sinks a quarter as far, and heavier bodies stand on light ones.
pub const CS_PRESET_ACCURATE: u32 = 2;
/// For reference and for the tallest stacks.
pub const CS_PRESET_EXACT: u32 = 3;

/// A preset by its number.
pub(crate) fn preset(number: u32) -> Result<Preset, Failure> {
    match number {
        CS_PRESET_FAST => Ok(Preset::Fast),
        CS_PRESET_BALANCED => Ok(Preset::Balanced),
        CS_PRESET_ACCURATE => Ok(Preset::Accurate),
        CS_PRESET_EXACT => Ok(Preset::Exact),
        _ => Err(Failure::UnknownKind("preset")),
    }
}

/// Everything that a step needs beside bodies and shapes.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CsSettings {
    /// Length of a step, seconds, 0..=0.25.
    pub dt: f32,
    /// m/s2.
    pub gravity: CsVec3,
    /// 1..=256.
    pub substeps: u32,
    /// Sweeps with position correction per substep, 1..=1024. With a tolerance the least number.
    pub sweeps: u32,
    /// Residual at which the sweeps of a substep end, m/s; 0 for as many as `sweeps` says.
    pub tolerance: f32,
    /// Most sweeps where there is a tolerance, 1..=1024.
    pub sweeps_max: u32,
    /// Sweeps without, 0..=1024.
    pub relax_sweeps: u32,
    /// Visits of each block in a sweep, 1..=64.
    pub inner_sweeps: u32,
    /// 1 to hold joints that hang together at once, 0 to visit each by itself.
    pub direct_joints: u32,
    /// `CS_CONTACT_SOFT`, `CS_CONTACT_RIGID` or `CS_CONTACT_SPLIT`.
    pub contact_model: u32,
    /// `CS_FRICTION_PATCH` or `CS_FRICTION_POINTS`.
    pub friction_model: u32,
    /// How far boxes and hulls may move against each other until their points of contact are found anew, metres,
    /// 0..=0.005; 0 for in each step.
    pub manifold_drift: f32,
    /// Hz; 0 follows the substep rate.
    pub contact_frequency: f32,
    /// 0..=1000.
    pub contact_damping_ratio: f32,
    /// Fastest push-out of overlap, m/s.
    pub push_speed: f32,
    /// How many times the substeps small islands under great load get, 1..=64; 1 for no island.
    pub refine: u32,
    /// Most dynamic bodies of such an island, 0..=65535.
    pub refine_bodies: u32,
    /// Sink of a soft contact from which on its island is refined, metres.
    pub refine_sink: f32,
    /// Approach speed below which nothing bounces, m/s.
    pub restitution_threshold: f32,
    /// Target number of links of a block, 8..=4096.
    pub block_links: u32,
    /// Seconds of quiet until an island falls asleep; 0 for never.
    pub sleep_time: f32,
    /// m/s.
    pub sleep_speed: f32,
    /// 1 to stop fast bodies at what they would pass.
    pub continuous: u32,
    /// Kinds of events that are told, `CS_TELL_*`.
    pub events: u32,
    /// Approach speed from which on a contact is a hit, m/s.
    pub hit_speed: f32,
    /// 1 for steps that note which bodies moved.
    pub moved_list: u32,
    /// 1 for steps that measure their residuals.
    pub residual: u32,
}

impl From<Settings> for CsSettings {
    fn from(s: Settings) -> Self {
        Self {
            dt: s.dt,
            gravity: s.gravity.into(),
            substeps: s.substeps,
            sweeps: s.sweeps,
            tolerance: s.tolerance,
            sweeps_max: s.sweeps_max,
            relax_sweeps: s.relax_sweeps,
            inner_sweeps: s.inner_sweeps,
            direct_joints: u32::from(s.direct_joints),
            contact_model: match s.contact_model {
                ContactModel::Soft => CS_CONTACT_SOFT,
                ContactModel::Rigid => CS_CONTACT_RIGID,
                ContactModel::Split => CS_CONTACT_SPLIT,
            },
            friction_model: match s.friction_model {
                FrictionModel::Patch => CS_FRICTION_PATCH,
                FrictionModel::Points => CS_FRICTION_POINTS,
            },
            manifold_drift: s.manifold_drift,
            contact_frequency: s.contact_frequency,
            contact_damping_ratio: s.contact_damping_ratio,
            push_speed: s.push_speed,
            refine: s.refine,
            refine_bodies: s.refine_bodies,
            refine_sink: s.refine_sink,
            restitution_threshold: s.restitution_threshold,
            block_links: s.block_links,
            sleep_time: s.sleep_time,
            sleep_speed: s.sleep_speed,
            continuous: u32::from(s.continuous),
            events: s.events.0,
            hit_speed: s.hit_speed,
            moved_list: u32::from(s.moved_list),
            residual: u32::from(s.residual),
        }
    }
}

impl CsSettings {
    pub(crate) fn read(&self) -> Result<Settings, Failure> {
        Ok(Settings {
            dt: self.dt,
            gravity: self.gravity.into(),
            substeps: self.substeps,
            sweeps: self.sweeps,
            tolerance: self.tolerance,
            sweeps_max: self.sweeps_max,
            relax_sweeps: self.relax_sweeps,
            inner_sweeps: self.inner_sweeps,
            direct_joints: self.direct_joints != 0,
            contact_model: match self.contact_model {
                CS_CONTACT_SOFT => ContactModel::Soft,
                CS_CONTACT_RIGID => ContactModel::Rigid,
                CS_CONTACT_SPLIT => ContactModel::Split,
                _ => return Err(Failure::UnknownKind("contact_model")),
            },
            friction_model: match self.friction_model {
                CS_FRICTION_PATCH => FrictionModel::Patch,
                CS_FRICTION_POINTS => FrictionModel::Points,
                _ => return Err(Failure::UnknownKind("friction_model")),
            },
            manifold_drift: self.manifold_drift,
            contact_frequency: self.contact_frequency,
            contact_damping_ratio: self.contact_damping_ratio,
            push_speed: self.push_speed,
            refine: self.refine,
            refine_bodies: self.refine_bodies,
            refine_sink: self.refine_sink,
            restitution_threshold: self.restitution_threshold,
            block_links: self.block_links,
            sleep_time: self.sleep_time,
            sleep_speed: self.sleep_speed,
            continuous: self.continuous != 0,
            events: EventKinds(self.events),
            hit_speed: self.hit_speed,
            moved_list: self.moved_list != 0,
            residual: self.residual != 0,
        })
    }
}

/// The greatest residual of rows, by kind, m/s.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CsResidual {
    /// Points of contacts along their normals.
    pub normal: f32,
    /// Friction of contacts.
    pub friction: f32,
    /// Joints.
    pub joint: f32,
}

impl From<Residual> for CsResidual {
    fn from(r: Residual) -> Self {
        Self { normal: r.normal, friction: r.friction, joint: r.joint }
    }
}

/// What a step tells.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CsReport {
    /// Steps taken so far.
    pub step: u64,
    /// Bodies in the world.
    pub bodies: u32,
    /// Bodies that were solved.
    pub active: u32,
    /// Of these, bodies that were refined.
    pub refined: u32,
    /// Bodies that sleep.
    pub asleep: u32,
    /// Pairs of shapes whose boxes overlap.
    pub pairs: u32,
    /// Contacts, each of 1 to 4 points.
    pub contacts: u32,
    /// Joints in the world.
    pub joints: u32,
    /// Pairs and contacts that found no room.
    pub dropped: u32,
    /// Bodies that were no longer finite and were stopped for good.
    pub quarantined: u32,
    /// Bodies whose speed or spin was capped.
    pub capped: u32,
    /// Fast bodies that were stopped on their way.
    pub cut: u32,
    /// Joints that broke.
    pub broken: u32,
    /// Events of this step.
    pub events: u32,
    /// Events that found no room.
    pub dropped_events: u32,
    /// Biased sweeps of all substeps.
    pub sweeps: u32,
    /// Substeps that ended with more than the tolerance.
    pub unsettled: u32,
    /// Residual after the last biased sweep; 0 unless the settings ask for it.
    pub biased: CsResidual,
    /// Residual after the last sweep of all.
    pub last: CsResidual,
}

impl From<StepReport> for CsReport {
    fn from(r: StepReport) -> Self {
        let residuals = r.residuals.unwrap_or_default();
        Self {
            step: r.step,
            bodies: r.bodies,
            active: r.active,
            refined: r.refined,
            asleep: r.asleep,
            pairs: r.pairs,
            contacts: r.contacts,
            joints: r.joints,
            dropped: r.dropped,
            quarantined: r.quarantined,
            capped: r.capped,
            cut: r.cut,
            broken: r.broken,
            events: r.events,
            dropped_events: r.dropped_events,
            sweeps: r.sweeps,
            unsettled: r.unsettled,
            biased: residuals.biased.into(),
            last: residuals.last.into(),
        }
    }
}
