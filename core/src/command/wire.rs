//! Fields to bytes and back. A type is listed once; the compiler sees that no field is left out.

use super::{Command, CommandError};
use crate::body::{AxisLocks, BodyDef, BodyKind, MassProperties, Position};
use crate::config::{ContactModel, FrictionModel, Settings};
use crate::event::{EventKinds, ShapeEvents};
use crate::handle::{
    BodyHandle, CompoundHandle, HeightFieldHandle, HullHandle, JointHandle, MeshHandle, ShapeHandle,
};
use crate::joint::{Axis, AxisMotion, Coupling, Drive, JointDef, Spring};
use crate::material::{MaterialTraits, Mix, PairMaterial};
use crate::math::{Pose, Rotation, Vec3};
use crate::query::BodyKinds;
use crate::shape::{Filter, Geometry, ShapeDef};

/// The only bits of what is not a number.
const NAN_BITS: u32 = 0x7fc0_0000;

/// Where an encoding goes.
pub(super) struct Output<'a> {
    bytes: &'a mut [u8],
    /// Bytes so far, those without room included.
    length: usize,
}

impl<'a> Output<'a> {
    pub fn new(bytes: &'a mut [u8]) -> Self {
        Self { bytes, length: 0 }
    }

    fn put(&mut self, bytes: &[u8]) {
        let end = self.length + bytes.len();
        if let Some(room) = self.bytes.get_mut(self.length..end) {
            room.copy_from_slice(bytes);
        }
        self.length = end;
    }

    pub fn finish(self) -> Result<usize, CommandError> {
        if self.length <= self.bytes.len() {
            Ok(self.length)
        } else {
            Err(CommandError::BufferTooSmall { needed: self.length })
        }
    }
}

/// Where an encoding comes from.
pub(super) struct Input<'a> {
    bytes: &'a [u8],
    position: usize,
}

impl<'a> Input<'a> {
    pub fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, position: 0 }
    }

    /// Bytes read so far.
    pub fn position(&self) -> usize {
        self.position
    }

    fn take<const N: usize>(&mut self) -> Result<[u8; N], CommandError> {
        let (bytes, _) = self.bytes[self.position..].split_first_chunk::<N>().ok_or(CommandError::End)?;
        self.position += N;
        Ok(*bytes)
    }

    fn refuse<T>(&self) -> Result<T, CommandError> {
        Err(CommandError::Value { offset: self.position })
    }
}

/// Something with one encoding.
pub(super) trait Wire: Sized {
    /// Bytes of the longest encoding.
    const SIZE_MAX: usize;
    fn put(&self, out: &mut Output<'_>);
    fn take(input: &mut Input<'_>) -> Result<Self, CommandError>;
}

macro_rules! integers {
    ($($type:ty),*) => { $(
        impl Wire for $type {
            const SIZE_MAX: usize = size_of::<$type>();
            fn put(&self, out: &mut Output<'_>) {
                out.put(&self.to_le_bytes());
            }
            fn take(input: &mut Input<'_>) -> Result<Self, CommandError> {
                Ok(<$type>::from_le_bytes(input.take()?))
            }
        }
    )* };
}

integers!(u8, u16, u32, u64, i32);

impl Wire for f32 {
    const SIZE_MAX: usize = 4;
    fn put(&self, out: &mut Output<'_>) {
        let bits = if self.is_nan() { NAN_BITS } else { self.to_bits() };
        bits.put(out);
    }
    fn take(input: &mut Input<'_>) -> Result<Self, CommandError> {
        let bits = u32::take(input)?;
        let x = f32::from_bits(bits);
        if x.is_nan() && bits != NAN_BITS { input.refuse() } else { Ok(x) }
    }
}

impl Wire for bool {
    const SIZE_MAX: usize = 1;
    fn put(&self, out: &mut Output<'_>) {
        u8::from(*self).put(out);
    }
    fn take(input: &mut Input<'_>) -> Result<Self, CommandError> {
        match u8::take(input)? {
            0 => Ok(false),
            1 => Ok(true),
            _ => input.refuse(),
        }
    }
}

impl<T: Wire> Wire for Option<T> {
    const SIZE_MAX: usize = 1 + T::SIZE_MAX;
    fn put(&self, out: &mut Output<'_>) {
        self.is_some().put(out);
        if let Some(value) = self {
            value.put(out);
        }
    }
    fn take(input: &mut Input<'_>) -> Result<Self, CommandError> {
        Ok(if bool::take(input)? { Some(T::take(input)?) } else { None })
    }
}

impl<T: Wire + Copy, const N: usize> Wire for [T; N] {
    const SIZE_MAX: usize = N * T::SIZE_MAX;
    fn put(&self, out: &mut Output<'_>) {
        self.iter().for_each(|value| value.put(out));
    }
    fn take(input: &mut Input<'_>) -> Result<Self, CommandError> {
        let mut values = [T::take(input)?; N];
        for value in &mut values[1..] {
            *value = T::take(input)?;
        }
        Ok(values)
    }
}

/// A structure: its fields one after the other.
macro_rules! fields {
    ($type:ty { $($field:ident : $kind:ty),* $(,)? }) => {
        impl Wire for $type {
            const SIZE_MAX: usize = 0 $(+ <$kind as Wire>::SIZE_MAX)*;
            fn put(&self, out: &mut Output<'_>) {
                let Self { $($field),* } = self;
                $( $field.put(out); )*
            }
            fn take(input: &mut Input<'_>) -> Result<Self, CommandError> {
                Ok(Self { $( $field: <$kind as Wire>::take(input)? ),* })
            }
        }
    };
}

/// A structure around one value.
macro_rules! around {
    ($($type:ident($kind:ty)),* $(,)?) => { $(
        impl Wire for $type {
            const SIZE_MAX: usize = <$kind as Wire>::SIZE_MAX;
            fn put(&self, out: &mut Output<'_>) {
                self.0.put(out);
            }
            fn take(input: &mut Input<'_>) -> Result<Self, CommandError> {
                Ok(Self(<$kind as Wire>::take(input)?))
            }
        }
    )* };
}

/// An enumeration: a tag, and the fields of the variant. `0 x: T` is the field `0`, called `x`.
macro_rules! variants {
    ($tags:ty; $type:ident {
        $( $tag:literal => $variant:ident { $( $member:tt $name:ident : $kind:ty ),* } ),* $(,)?
    }) => {
        impl Wire for $type {
            const SIZE_MAX: usize = {
                let mut most = 0;
                $(
                    let size = 0 $(+ <$kind as Wire>::SIZE_MAX)*;
                    if size > most {
                        most = size;
                    }
                )*
                size_of::<$tags>() + most
            };
            fn put(&self, out: &mut Output<'_>) {
                match self {
                    $( Self::$variant { $($member: $name),* } => {
                        <$tags as Wire>::put(&$tag, out);
                        $( $name.put(out); )*
                    } )*
                }
            }
            fn take(input: &mut Input<'_>) -> Result<Self, CommandError> {
                match <$tags as Wire>::take(input)? {
                    $( $tag => Ok(Self::$variant { $( $member: <$kind as Wire>::take(input)? ),* }), )*
                    tag => <$tags as Tags>::unknown(tag, input),
                }
            }
        }
    };
}

/// What to say of a tag that stands for nothing.
trait Tags: Sized {
    fn unknown<T>(self, input: &Input<'_>) -> Result<T, CommandError>;
}

impl Tags for u8 {
    fn unknown<T>(self, input: &Input<'_>) -> Result<T, CommandError> {
        input.refuse()
    }
}

impl Tags for u16 {
    fn unknown<T>(self, _: &Input<'_>) -> Result<T, CommandError> {
        Err(CommandError::Tag { tag: self })
    }
}

around!(
    HullHandle(u32),
    MeshHandle(u32),
    HeightFieldHandle(u32),
    CompoundHandle(u32),
    AxisLocks(u8),
    BodyKinds(u8),
    ShapeEvents(u8),
    EventKinds(u32),
);

fields!(BodyHandle { index: u32, generation: u32 });
fields!(ShapeHandle { index: u32, generation: u32 });
fields!(JointHandle { index: u32, generation: u32 });
fields!(Vec3 { x: f32, y: f32, z: f32 });
fields!(Rotation { x: f32, y: f32, z: f32, w: f32 });
fields!(Pose { position: Vec3, rotation: Rotation });
fields!(Position { sector: [i32; 3], offset: Vec3 });
fields!(MassProperties { mass: f32, center: Vec3, inertia: Vec3, axes: Rotation });
fields!(Filter { category: u32, mask: u32, group: i32 });
fields!(PairMaterial { friction: Option<f32>, restitution: Option<f32> });
fields!(MaterialTraits {
    friction_mix: Mix,
    restitution_mix: Mix,
    rolling: f32,
    spinning: f32,
    surface_velocity: Vec3,
    one_way: Option<Vec3>,
});
fields!(BodyDef {
    kind: BodyKind,
    position: Position,
    rotation: Rotation,
    linear_velocity: Vec3,
    angular_velocity: Vec3,
    linear_damping: f32,
    angular_damping: f32,
    gravity_scale: f32,
    locks: AxisLocks,
    mass: Option<MassProperties>,
    can_sleep: bool,
    bullet: bool,
    user: u64,
});
fields!(ShapeDef {
    geometry: Geometry,
    pose: Pose,
    density: f32,
    friction: f32,
    restitution: f32,
    traits: MaterialTraits,
    filter: Filter,
    sensor: Option<BodyKinds>,
    events: ShapeEvents,
    user: u64,
});
fields!(Drive { target: f32, velocity: f32, spring: Option<Spring>, max_force: f32 });
fields!(Axis { motion: AxisMotion, limit_spring: Option<Spring>, drive: Option<Drive>, friction: f32 });
fields!(JointDef {
    bodies: [BodyHandle; 2],
    frames: [Pose; 2],
    coupling: Coupling,
    axes: [Axis; 6],
    cone: Option<f32>,
    spring: Option<Spring>,
    break_force: f32,
    break_torque: f32,
    bodies_collide: bool,
    user: u64,
});
fields!(Settings {
    dt: f32,
    gravity: Vec3,
    substeps: u32,
    sweeps: u32,
    tolerance: f32,
    sweeps_max: u32,
    relax_sweeps: u32,
    inner_sweeps: u32,
    direct_joints: bool,
    contact_model: ContactModel,
    friction_model: FrictionModel,
    manifold_drift: f32,
    contact_frequency: f32,
    contact_damping_ratio: f32,
    push_speed: f32,
    refine: u32,
    refine_bodies: u32,
    refine_sink: f32,
    restitution_threshold: f32,
    block_links: u32,
    sleep_time: f32,
    sleep_speed: f32,
    continuous: bool,
    events: EventKinds,
    hit_speed: f32,
    moved_list: bool,
    residual: bool,
});

variants!(u8; BodyKind { 0 => Static {}, 1 => Kinematic {}, 2 => Dynamic {} });
variants!(u8; FrictionModel { 0 => Patch {}, 1 => Points {} });
variants!(u8; ContactModel { 0 => Soft {}, 1 => Rigid {}, 2 => Split {} });
variants!(u8; Mix {
    0 => Unset {},
    1 => GeometricMean {},
    2 => Mean {},
    3 => Min {},
    4 => Multiply {},
    5 => Max {},
});
variants!(u8; Spring {
    0 => Frequency { hertz hertz: f32, damping_ratio ratio: f32 },
    1 => Stiffness { stiffness stiffness: f32, damping damping: f32 },
});
variants!(u8; AxisMotion {
    0 => Free {},
    1 => Locked {},
    2 => Limited { lower lower: f32, upper upper: f32 },
});
variants!(u8; Coupling {
    0 => Frames {},
    1 => Distance {},
    2 => Gear { ratio ratio: f32 },
    3 => Rack { ratio ratio: f32 },
});
variants!(u8; Geometry {
    0 => Sphere { radius radius: f32 },
    1 => Capsule { half_height half: f32, radius radius: f32 },
    2 => Box { half_extents half: Vec3 },
    3 => Hull { 0 hull: HullHandle },
    4 => HalfSpace {},
    5 => Mesh { 0 mesh: MeshHandle },
    6 => Cylinder { half_height half: f32, radius radius: f32 },
    7 => Cone { half_height half: f32, radius radius: f32 },
    8 => RoundedHull { hull hull: HullHandle, radius radius: f32 },
    9 => HeightField { 0 field: HeightFieldHandle },
    10 => Compound { 0 compound: CompoundHandle },
});

// The upper byte of a tag is the version of the fields, the lower one the kind. A kind whose fields change gets the
// next version; a number is never used again.
variants!(u16; Command {
    0x0201 => SetSettings { 0 settings: Settings },
    0x0110 => CreateBody { 0 def: BodyDef },
    0x0111 => RemoveBody { 0 body: BodyHandle },
    0x0112 => SetPose { 0 body: BodyHandle, 1 position: Position, 2 rotation: Rotation },
    0x0113 => SetLinearVelocity { 0 body: BodyHandle, 1 velocity: Vec3 },
    0x0114 => SetAngularVelocity { 0 body: BodyHandle, 1 velocity: Vec3 },
    0x0115 => SetKinematicTarget { 0 body: BodyHandle, 1 position: Position, 2 rotation: Rotation },
    0x0116 => SetKind { 0 body: BodyHandle, 1 kind: BodyKind },
    0x0117 => SetMass { 0 body: BodyHandle, 1 mass: Option<MassProperties> },
    0x0118 => SetDamping { 0 body: BodyHandle, 1 linear: f32, 2 angular: f32 },
    0x0119 => SetGravityScale { 0 body: BodyHandle, 1 scale: f32 },
    0x011a => SetLocks { 0 body: BodyHandle, 1 locks: AxisLocks },
    0x011b => SetBullet { 0 body: BodyHandle, 1 bullet: bool },
    0x011c => SetBodyUser { 0 body: BodyHandle, 1 user: u64 },
    0x011d => Wake { 0 body: BodyHandle },
    0x011e => SetCanSleep { 0 body: BodyHandle, 1 can_sleep: bool },
    0x0120 => ApplyForce { 0 body: BodyHandle, 1 force: Vec3 },
    0x0121 => ApplyForceAt { 0 body: BodyHandle, 1 force: Vec3, 2 place: Position },
    0x0122 => ApplyTorque { 0 body: BodyHandle, 1 torque: Vec3 },
    0x0123 => ApplyImpulse { 0 body: BodyHandle, 1 impulse: Vec3 },
    0x0124 => ApplyImpulseAt { 0 body: BodyHandle, 1 impulse: Vec3, 2 place: Position },
    0x0125 => ApplyAngularImpulse { 0 body: BodyHandle, 1 impulse: Vec3 },
    0x0140 => CreateShape { 0 body: BodyHandle, 1 def: ShapeDef },
    0x0141 => RemoveShape { 0 shape: ShapeHandle },
    0x0142 => SetShapeUser { 0 shape: ShapeHandle, 1 user: u64 },
    0x0143 => SetGeometry { 0 shape: ShapeHandle, 1 geometry: Geometry, 2 pose: Pose },
    0x0144 => SetDensity { 0 shape: ShapeHandle, 1 density: f32 },
    0x0145 => SetFilter { 0 shape: ShapeHandle, 1 filter: Filter },
    0x0146 => SetMaterial { 0 shape: ShapeHandle, 1 friction: f32, 2 restitution: f32 },
    0x0147 => SetMaterialTraits { 0 shape: ShapeHandle, 1 traits: MaterialTraits },
    0x0148 => SetShapeEvents { 0 shape: ShapeHandle, 1 events: ShapeEvents },
    0x0149 => SetPairMaterial { 0 a: ShapeHandle, 1 b: ShapeHandle, 2 material: PairMaterial },
    0x0150 => IgnoreUntilSeparated { 0 a: BodyHandle, 1 b: BodyHandle },
    0x0151 => StopIgnoring { 0 a: BodyHandle, 1 b: BodyHandle },
    0x0160 => CreateJoint { 0 def: JointDef },
    0x0161 => RemoveJoint { 0 joint: JointHandle },
    0x0162 => SetJoint { 0 joint: JointHandle, 1 def: JointDef },
    0x0163 => SetJointAxis { 0 joint: JointHandle, 1 index: u32, 2 axis: Axis },
    0x0164 => SetJointUser { 0 joint: JointHandle, 1 user: u64 },
});
