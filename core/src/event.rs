//! Events: what happened in a step that a game wants to hear of.
//!
//! A world keeps the events of its last step, as far as [`Capacities::events`](crate::Capacities::events) goes.
//! They are part of the state: a world that was restored has the events of the step that was saved. The next
//! step, also one without length, replaces them.
//!
//! **Order.** The stages of the step, one after the other: woke, contacts ended, contacts began, hits, joints
//! broken, quarantined, sensors ended, sensors began, slept. Events of one kind are ascending by slot: of the
//! body, of the joint, of the two shapes (lower one first), of the sensor and then of its visitor. No executor
//! changes the order. When there are too many events, the last ones in this order are dropped, and counted in
//! [`StepReport::dropped_events`](crate::StepReport::dropped_events).
//!
//! **Who is heard.** Contacts and hits only of shapes that ask for them, see [`ShapeEvents`]: one of the two is
//! enough. All others always. [`Settings::events`](crate::Settings::events) leaves kinds out.
//!
//! **What is gone.** A contact or a visit also ends because a shape was removed; the next step tells. Then the
//! event names what was there: its handles are stale, and never name a new tenant of the slot.

use crate::body::Position;
use crate::handle::{BodyHandle, JointHandle, ShapeHandle};
use crate::math::Vec3;
use crate::state::{Field, fields};
use crate::validate;
use bytemuck::{Pod, Zeroable};

/// A set of kinds of events.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EventKinds(pub u32);

impl EventKinds {
    /// Nothing.
    pub const NONE: Self = Self(0);
    /// Contacts that began or ended.
    pub const CONTACTS: Self = Self(1);
    /// Hits.
    pub const HITS: Self = Self(2);
    /// Visits to sensors that began or ended.
    pub const SENSORS: Self = Self(4);
    /// Joints that broke.
    pub const JOINTS: Self = Self(8);
    /// Bodies that fell asleep or woke.
    pub const SLEEP: Self = Self(16);
    /// Bodies that were quarantined.
    pub const QUARANTINE: Self = Self(32);
    /// Everything.
    pub const ALL: Self = Self(63);

    /// Kinds of both.
    pub const fn and(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// The kinds of this one that are not in `other`.
    pub const fn without(self, other: Self) -> Self {
        Self(self.0 & !other.0)
    }

    /// True when all kinds of `other` are in the set.
    pub const fn has(self, other: Self) -> bool {
        self.0 & other.0 == other.0
    }
}

/// What a shape wants to be heard of. A contact is heard of when one of its two shapes wants it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ShapeEvents(pub u8);

impl ShapeEvents {
    /// Nothing.
    pub const NONE: Self = Self(0);
    /// Its contacts that begin or end.
    pub const CONTACTS: Self = Self(1);
    /// Its hits.
    pub const HITS: Self = Self(2);
    /// Both.
    pub const ALL: Self = Self(3);

    /// Those of both.
    pub const fn and(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }
}

/// Something that happened in a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Event {
    /// The step: what [`World::steps`](crate::World::steps) was after it.
    pub step: u64,
    /// What happened.
    pub kind: EventKind,
}

/// What happened.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum EventKind {
    /// A body that slept takes part in the motion again. The events of an island come together.
    Woke(BodyHandle),
    /// Two shapes have no contact any more. One that sleeps has not ended. Comes in the step after the shape was
    /// removed, its body quarantined, or the filter changed.
    ContactEnded(Touching),
    /// Two shapes have a contact that had none: at the start of the step they were nearer than the speculative
    /// distance and what they may come nearer in the step, so they need not have touched. See
    /// [`EventKind::ContactHit`].
    ContactBegan(Touching),
    /// Two shapes met faster than [`Settings::hit_speed`](crate::Settings::hit_speed) and pressed.
    ContactHit(ContactHit),
    /// A joint gave way under its load.
    JointBroken(JointBreak),
    /// A body was no longer finite and was stopped for good: see
    /// [`World::is_quarantined`](crate::World::is_quarantined).
    Quarantined(BodyHandle),
    /// A shape left a sensor.
    SensorEnded(Visit),
    /// A shape came into a sensor.
    SensorBegan(Visit),
    /// A body fell asleep. The events of an island come together.
    Slept(BodyHandle),
}

/// Two shapes with a contact.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Touching {
    /// The two shapes, lower slot first.
    pub shapes: [ShapeHandle; 2],
    /// Their bodies.
    pub bodies: [BodyHandle; 2],
}

/// Two shapes that met. A concave shape may be hit at several parts in one step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactHit {
    /// The shapes and their bodies.
    pub touching: Touching,
    /// The point of the contact that approached fastest, at the start of the step: the middle between the
    /// surfaces.
    pub point: Position,
    /// Unit normal from the first shape to the second.
    pub normal: Vec3,
    /// How fast that point approached along the normal at the start of the step, m/s.
    pub speed: f32,
    /// Normal impulse of all points of the contact in the whole step, N s.
    pub impulse: f32,
}

/// A joint that broke. It is still there, holds nothing, and waits to be removed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointBreak {
    /// The joint.
    pub joint: JointHandle,
    /// Its bodies.
    pub bodies: [BodyHandle; 2],
    /// Force that it carried in the last substep, N.
    pub force: f32,
    /// Torque that it carried, N m.
    pub torque: f32,
}

/// A shape in a sensor.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct Visit {
    /// The sensor.
    pub sensor: ShapeHandle,
    /// The shape in it.
    pub visitor: ShapeHandle,
    /// The sensor's body.
    pub sensor_body: BodyHandle,
    /// The visitor's body.
    pub visitor_body: BodyHandle,
}

impl Visit {
    /// What visits are sorted by.
    pub(crate) fn key(&self) -> u64 {
        u64::from(self.sensor.index) << 32 | u64::from(self.visitor.index)
    }
}

/// An event in the state.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub(crate) struct EventRow {
    /// `WOKE` to `SLEPT`.
    kind: u32,
    /// Shapes, or the joint and zeros, or zeros.
    shapes: [ShapeHandle; 2],
    bodies: [BodyHandle; 2],
    point: Position,
    normal: Vec3,
    /// Speed of a hit, m/s; force on a joint, N.
    first: f32,
    /// Impulse of a hit, N s; torque on a joint, N m.
    second: f32,
}

impl EventRow {
    /// Names of the fields, for `state/fields.rs`.
    pub const FIELDS: &[Field] = fields!(EventRow {
        kind: U32 1,
        shapes: U32 4,
        bodies: U32 4,
        point.sector: I32 3,
        point.offset: F32 3,
        normal: F32 3,
        first: F32 1,
        second: F32 1,
    });
}

const WOKE: u32 = 1;
const CONTACT_ENDED: u32 = 2;
const CONTACT_BEGAN: u32 = 3;
const HIT: u32 = 4;
const JOINT_BROKEN: u32 = 5;
const QUARANTINED: u32 = 6;
const SENSOR_ENDED: u32 = 7;
const SENSOR_BEGAN: u32 = 8;
const SLEPT: u32 = 9;

impl From<EventKind> for EventRow {
    fn from(kind: EventKind) -> Self {
        let none = Self::zeroed();
        let of_body = |kind: u32, body: BodyHandle| Self { kind, bodies: [body, none.bodies[1]], ..none };
        let of_shapes = |kind: u32, shapes, bodies| Self { kind, shapes, bodies, ..none };
        let of_visit =
            |kind: u32, v: Visit| of_shapes(kind, [v.sensor, v.visitor], [v.sensor_body, v.visitor_body]);
        match kind {
            EventKind::Woke(body) => of_body(WOKE, body),
            EventKind::ContactEnded(t) => of_shapes(CONTACT_ENDED, t.shapes, t.bodies),
            EventKind::ContactBegan(t) => of_shapes(CONTACT_BEGAN, t.shapes, t.bodies),
            EventKind::ContactHit(hit) => Self {
                kind: HIT,
                shapes: hit.touching.shapes,
                bodies: hit.touching.bodies,
                point: hit.point,
                normal: hit.normal,
                first: hit.speed,
                second: hit.impulse,
            },
            EventKind::JointBroken(broken) => {
                let JointHandle { index, generation } = broken.joint;
                let joint = ShapeHandle { index, generation };
                Self {
                    first: broken.force,
                    second: broken.torque,
                    ..of_shapes(JOINT_BROKEN, [joint, none.shapes[1]], broken.bodies)
                }
            }
            EventKind::Quarantined(body) => of_body(QUARANTINED, body),
            EventKind::SensorEnded(visit) => of_visit(SENSOR_ENDED, visit),
            EventKind::SensorBegan(visit) => of_visit(SENSOR_BEGAN, visit),
            EventKind::Slept(body) => of_body(SLEPT, body),
        }
    }
}

impl EventRow {
    /// What happened; `None` when the row was not made from an [`EventKind`].
    pub fn read(&self) -> Option<EventKind> {
        let touching = Touching { shapes: self.shapes, bodies: self.bodies };
        let body = self.bodies[0];
        let visit = Visit {
            sensor: self.shapes[0],
            visitor: self.shapes[1],
            sensor_body: self.bodies[0],
            visitor_body: self.bodies[1],
        };
        Some(match self.kind {
            WOKE => EventKind::Woke(body),
            CONTACT_ENDED => EventKind::ContactEnded(touching),
            CONTACT_BEGAN => EventKind::ContactBegan(touching),
            HIT => EventKind::ContactHit(ContactHit {
                touching,
                point: self.point,
                normal: self.normal,
                speed: self.first,
                impulse: self.second,
            }),
            JOINT_BROKEN => {
                let ShapeHandle { index, generation } = self.shapes[0];
                EventKind::JointBroken(JointBreak {
                    joint: JointHandle { index, generation },
                    bodies: self.bodies,
                    force: self.first,
                    torque: self.second,
                })
            }
            QUARANTINED => EventKind::Quarantined(body),
            SENSOR_ENDED => EventKind::SensorEnded(visit),
            SENSOR_BEGAN => EventKind::SensorBegan(visit),
            SLEPT => EventKind::Slept(body),
            _ => return None,
        })
    }

    /// True for a row that could be a step's: of a known kind, finite, and nothing in it that its kind does not
    /// say.
    pub fn is_sound(&self) -> bool {
        let canonical = |kind| bytemuck::bytes_of(&EventRow::from(kind)) == bytemuck::bytes_of(self);
        self.read().is_some_and(canonical)
            && validate::position("", &self.point).is_ok()
            && self.normal.is_finite()
            && self.first.is_finite()
            && self.second.is_finite()
    }
}

/// Who had a shape's slot in the last step, when it was removed since. Zero otherwise.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
pub(crate) struct Tenant {
    pub generation: u32,
    pub body: BodyHandle,
    /// The shape's flags.
    pub flags: u32,
}

/// What happened to 64 bodies: a bit each.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub(crate) struct BodyNews {
    /// Moved in the last step, or by calls before it.
    pub moved: u64,
    /// Moved by calls since.
    pub called: u64,
    /// Fell asleep in the last step.
    pub slept: u64,
    /// Slept at the end of the last step, and was made something that does not by a call since.
    pub roused: u64,
}

/// A body that is elsewhere than it was a step ago.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MovedBody {
    /// The body.
    pub body: BodyHandle,
    /// Where its origin is now.
    pub position: Position,
    /// How it is turned now.
    pub rotation: crate::math::Rotation,
    /// True when it fell asleep in this step: it stays there until it is in the list again.
    pub fell_asleep: bool,
}
