//! Names of the numbers in the rows of the state: for telling people what differs between two states.

use super::Header;
use crate::body::{BodyRow, Motion};
use crate::cells::OrderingRow;
use crate::config::SettingsRow;
use crate::event::{BodyNews, EventRow, Tenant, Visit};
use crate::joint::{AxisRow, JointRow};
use crate::material::{MaterialRow, PairRule};
use crate::shape::ShapeRow;
use crate::state::{ContactRow, Pair};
use core::mem::{offset_of, size_of};

/// How the bytes of a number are read; little-endian.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FieldKind {
    /// Single precision.
    F32,
    /// Unsigned, or bits.
    U32,
    /// Signed.
    I32,
    /// Unsigned, or bits.
    U64,
    /// A byte.
    U8,
}

impl FieldKind {
    /// Bytes of a number.
    pub const fn size(self) -> usize {
        match self {
            FieldKind::U8 => 1,
            FieldKind::U64 => 8,
            _ => 4,
        }
    }
}

/// Numbers of one meaning in a row of the state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Field {
    /// What they are called, as in the documentation of the core.
    pub name: &'static str,
    /// How each is read.
    pub kind: FieldKind,
    /// Where the first one lies, bytes from the start of the row.
    pub offset: usize,
    /// How many there are, one after the other.
    pub count: usize,
}

impl Field {
    /// The field of a section that has a byte, counted from the start of a row; sections are those of
    /// [`World::checksum_by_section`](crate::World::checksum_by_section). `None` beyond the row and for other
    /// names. The six axes of a joint are one row: a field of the third axis has its offset there.
    pub fn at(section: &str, byte: usize) -> Option<Self> {
        let is_axes = section == "joint_axes";
        if is_axes && byte >= 6 * size_of::<AxisRow>() {
            return None;
        }
        let within = if is_axes { byte % size_of::<AxisRow>() } else { byte };
        fields_of(section).into_iter().find_map(|(fields, start)| {
            let own = within.checked_sub(start)?;
            let field = fields.iter().find(|field| field.offset <= own && own < field.end())?;
            Some(Field { offset: byte - within + start + field.offset, ..*field })
        })
    }

    /// Where the field ends, bytes from the start of the row.
    pub const fn end(&self) -> usize {
        self.offset + self.count * self.kind.size()
    }
}

/// The fields of a row: name, kind and count of numbers.
macro_rules! fields {
    ($row:ty { $($first:ident $(. $rest:ident)* : $kind:ident $count:literal),* $(,)? }) => {
        &[$(
            $crate::state::Field {
                name: concat!(stringify!($first) $(, ".", stringify!($rest))*),
                kind: $crate::state::FieldKind::$kind,
                offset: core::mem::offset_of!($row, $first $(. $rest)*),
                count: $count,
            },
        )*]
    };
}
pub(crate) use fields;

/// A section whose rows are single numbers.
const fn plain(name: &'static str, kind: FieldKind) -> Field {
    Field { name, kind, offset: 0, count: 1 }
}

const HEADER: &[Field] = fields!(Header {
    step: U64 1,
    static_version: U64 1,
    bodies: U32 4,
    shapes: U32 4,
    pairs: U32 1,
    contacts: U32 1,
    pairs_stale: U32 1,
    joints_stale: U32 1,
    joints: U32 4,
    joint_bounds: U32 1,
    asleep: U32 1,
    asleep_pairs: U32 1,
    asleep_contacts: U32 1,
    wakes: U32 1,
    refine: U32 1,
    materials: U32 1,
    pair_rules: U32 1,
    events: U32 1,
    event_marks: U32 1,
    sensors: U32 1,
    hit_shapes: U32 1,
    visits: U32 1,
});
/// Where the settings lie in the header.
const SETTINGS: usize = offset_of!(Header, settings);

const MOTION: &[Field] = fields!(Motion {
    center.sector: I32 3,
    center.offset: F32 3,
    rotation: F32 4,
    linear: F32 3,
    angular: F32 3,
});

const BODY: &[Field] = fields!(BodyRow {
    user: U64 1,
    force: F32 3,
    torque: F32 3,
    mass: F32 1,
    inertia: F32 3,
    axes: F32 4,
    local_center: F32 3,
    linear_damping: F32 1,
    angular_damping: F32 1,
    gravity_scale: F32 1,
    first_shape: U32 1,
    flags: U32 1,
    stance: U32 2,
});

const SHAPE: &[Field] = fields!(ShapeRow {
    user: U64 1,
    body: U32 1,
    next: U32 1,
    kind: U32 1,
    size: F32 3,
    pose.position: F32 3,
    pose.rotation: F32 4,
    density: F32 1,
    friction: F32 1,
    restitution: F32 1,
    filter.category: U32 1,
    filter.mask: U32 1,
    filter.group: I32 1,
    fat_box.min: F32 3,
    fat_box.max: F32 3,
    flags: U32 1,
});

const PAIR: &[Field] = fields!(Pair { a: U32 1, b: U32 1 });

const CONTACT: &[Field] = fields!(ContactRow {
    pair.a: U32 1,
    pair.b: U32 1,
    tag: U32 1,
    memory: U32 5,
    impulses: F32 4,
    friction: F32 3,
    twist: F32 1,
});

const ORDERING: &[Field] = fields!(OrderingRow {
    credit: I32 1,
    cursor: U32 1,
    built: U32 1,
    waited: U32 1,
    futile: U32 1,
});

const JOINT: &[Field] = fields!(JointRow {
    user: U64 1,
    bodies: U32 2,
    next: U32 2,
    flags: U32 1,
    phase: U32 1,
    signature: U32 1,
    break_force: F32 1,
    break_torque: F32 1,
    frames: F32 14,
    spring: U32 3,
    impulses: F32 6,
    force: F32 3,
    torque: F32 3,
    ratio: F32 1,
    cone: F32 1,
    cone_impulse: F32 1,
    slip: F32 1,
});

/// Of one of the six axes of a row.
const AXIS: &[Field] = fields!(AxisRow {
    flags: U32 1,
    lower: F32 1,
    upper: F32 1,
    limit_spring: U32 3,
    target: F32 1,
    velocity: F32 1,
    drive_spring: U32 3,
    max_force: F32 1,
    friction: F32 1,
    turn: F32 1,
    limit_impulse: F32 1,
    drive_impulse: F32 1,
    friction_impulse: F32 1,
});

const MATERIAL: &[Field] = fields!(MaterialRow {
    surface_velocity: F32 3,
    rolling: F32 1,
    one_way: F32 3,
    spinning: F32 1,
    mixes: U32 1,
    uses: U32 1,
});

const TENANT: &[Field] =
    fields!(Tenant { generation: U32 1, body.index: U32 1, body.generation: U32 1, flags: U32 1 });

const VISIT: &[Field] = fields!(Visit {
    sensor: U32 2,
    visitor: U32 2,
    sensor_body: U32 2,
    visitor_body: U32 2,
});

const NEWS: &[Field] = fields!(BodyNews { moved: U64 1, called: U64 1, slept: U64 1, roused: U64 1 });

const GENERATION: &[Field] = &[plain("generation", FieldKind::U32)];
const USED: &[Field] = &[plain("used", FieldKind::U64)];
const REFINED: &[Field] = &[plain("refined", FieldKind::U64)];
const LOADED: &[Field] = &[plain("loaded", FieldKind::U64)];
const DIRT: &[Field] = &[plain("dirt", FieldKind::U8)];
const FIRST_JOINT: &[Field] = &[plain("first_joint", FieldKind::U32)];

/// The fields of a section's rows and where in the row they start; what starts elsewhere comes second.
fn fields_of(section: &str) -> [(&'static [Field], usize); 2] {
    let none: (&'static [Field], usize) = (&[], 0);
    let fields = match section {
        "header" => return [(HEADER, 0), (SettingsRow::FIELDS, SETTINGS)],
        "motions" => MOTION,
        "bodies" => BODY,
        "body_generations" | "shape_generations" | "joint_generations" => GENERATION,
        "body_used" | "shape_used" | "joint_used" => USED,
        "shapes" => SHAPE,
        "pairs" | "asleep_pairs" => PAIR,
        "contacts" | "asleep_contacts" => CONTACT,
        "ordering" => ORDERING,
        "dirt" => DIRT,
        "refined" => REFINED,
        "loaded" => LOADED,
        "joints" => JOINT,
        "joint_axes" => AXIS,
        "first_joints" => FIRST_JOINT,
        "materials" => MATERIAL,
        "pair_rules" => PairRule::FIELDS,
        "events" => EventRow::FIELDS,
        "tenants" => TENANT,
        "visits" => VISIT,
        "news" => NEWS,
        _ => &[],
    };
    [(fields, 0), none]
}
