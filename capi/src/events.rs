//! What happened in the last step.

use crate::border::{read, room};
use crate::error::CsResult;
use crate::types::{CsBody, CsJoint, CsPosition, CsRotation, CsShape, CsVec3};
use crate::world::CsWorld;
use cellstep::{Event, EventKind, Touching, Visit};
use std::mem::MaybeUninit;

/// Contacts that began or ended, in `CsSettings::events`.
pub const CS_TELL_CONTACTS: u32 = 1;
/// Hits.
pub const CS_TELL_HITS: u32 = 2;
/// Visits to sensors.
pub const CS_TELL_SENSORS: u32 = 4;
/// Joints that broke.
pub const CS_TELL_JOINTS: u32 = 8;
/// Bodies that fell asleep or woke.
pub const CS_TELL_SLEEP: u32 = 16;
/// Bodies that were quarantined.
pub const CS_TELL_QUARANTINE: u32 = 32;

/// `bodies[0]` woke.
pub const CS_EVENT_WOKE: u32 = 1;
/// Two shapes have no contact any more.
pub const CS_EVENT_CONTACT_ENDED: u32 = 2;
/// Two shapes have a contact.
pub const CS_EVENT_CONTACT_BEGAN: u32 = 3;
/// Two shapes met fast.
pub const CS_EVENT_CONTACT_HIT: u32 = 4;
/// `joint` broke.
pub const CS_EVENT_JOINT_BROKEN: u32 = 5;
/// `bodies[0]` was no longer finite and was stopped for good.
pub const CS_EVENT_QUARANTINED: u32 = 6;
/// `shapes[1]` left the sensor `shapes[0]`.
pub const CS_EVENT_SENSOR_ENDED: u32 = 7;
/// `shapes[1]` came into the sensor `shapes[0]`.
pub const CS_EVENT_SENSOR_BEGAN: u32 = 8;
/// `bodies[0]` fell asleep.
pub const CS_EVENT_SLEPT: u32 = 9;

/// Something that happened in a step. What its kind does not name is zero.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CsEvent {
    /// What `cs_world_steps` was after it.
    pub step: u64,
    /// `CS_EVENT_*`; 0 for one that this version does not know.
    pub kind: u32,
    /// The shapes.
    pub shapes: [CsShape; 2],
    /// The bodies.
    pub bodies: [CsBody; 2],
    /// The joint that broke.
    pub joint: CsJoint,
    /// Of a hit: the point that approached fastest.
    pub point: CsPosition,
    /// Of a hit: from the first shape to the second.
    pub normal: CsVec3,
    /// Of a hit: m/s.
    pub speed: f32,
    /// Of a hit: normal impulse in the whole step, N s.
    pub impulse: f32,
    /// That the broken joint carried, N.
    pub force: f32,
    /// That the broken joint carried, N m.
    pub torque: f32,
}

impl From<Event> for CsEvent {
    fn from(event: Event) -> Self {
        let none = Self { step: event.step, ..Self::default() };
        let of_body = |kind, body: cellstep::BodyHandle| Self {
            kind,
            bodies: [body.into(), CsBody::default()],
            ..none
        };
        let of_shapes = |kind, t: Touching| Self {
            kind,
            shapes: t.shapes.map(Into::into),
            bodies: t.bodies.map(Into::into),
            ..none
        };
        let of_visit = |kind, v: Visit| Self {
            kind,
            shapes: [v.sensor.into(), v.visitor.into()],
            bodies: [v.sensor_body.into(), v.visitor_body.into()],
            ..none
        };
        match event.kind {
            EventKind::Woke(body) => of_body(CS_EVENT_WOKE, body),
            EventKind::ContactEnded(touching) => of_shapes(CS_EVENT_CONTACT_ENDED, touching),
            EventKind::ContactBegan(touching) => of_shapes(CS_EVENT_CONTACT_BEGAN, touching),
            EventKind::ContactHit(hit) => Self {
                point: hit.point.into(),
                normal: hit.normal.into(),
                speed: hit.speed,
                impulse: hit.impulse,
                ..of_shapes(CS_EVENT_CONTACT_HIT, hit.touching)
            },
            EventKind::JointBroken(broken) => Self {
                kind: CS_EVENT_JOINT_BROKEN,
                joint: broken.joint.into(),
                bodies: broken.bodies.map(Into::into),
                force: broken.force,
                torque: broken.torque,
                ..none
            },
            EventKind::Quarantined(body) => of_body(CS_EVENT_QUARANTINED, body),
            EventKind::SensorEnded(visit) => of_visit(CS_EVENT_SENSOR_ENDED, visit),
            EventKind::SensorBegan(visit) => of_visit(CS_EVENT_SENSOR_BEGAN, visit),
            EventKind::Slept(body) => of_body(CS_EVENT_SLEPT, body),
            _ => none,
        }
    }
}

/// Writes the events of the last step, as far as `room_for` of them go, and tells how many there are in all.
///
/// # Safety
/// See the top of the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cs_world_events(
    world: Option<&CsWorld>,
    events: *mut CsEvent,
    room_for: usize,
    count: Option<&mut MaybeUninit<usize>>,
) -> CsResult {
    read(world, count, |world| {
        // SAFETY: C promises room for `room_for` events that is ours during the call.
        let room = unsafe { room(events, room_for, "events")? };
        for (place, event) in room.iter_mut().zip(world.events()) {
            place.write(event.into());
        }
        Ok(world.events().count())
    })
}

/// A body that moved in the last step.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CsMoved {
    /// The body.
    pub body: CsBody,
    /// Where its origin is now.
    pub position: CsPosition,
    /// How it is turned now.
    pub rotation: CsRotation,
    /// 1 when it fell asleep in this step.
    pub fell_asleep: u32,
}

/// Writes which bodies moved in the last step, if the settings ask for it, as far as `room_for` of them go, and
/// tells how many there are in all.
///
/// # Safety
/// See the top of the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cs_world_moved(
    world: Option<&CsWorld>,
    moved: *mut CsMoved,
    room_for: usize,
    count: Option<&mut MaybeUninit<usize>>,
) -> CsResult {
    read(world, count, |world| {
        // SAFETY: C promises room for `room_for` bodies that is ours during the call.
        let room = unsafe { room(moved, room_for, "moved")? };
        for (place, moved) in room.iter_mut().zip(world.moved_bodies()) {
            place.write(CsMoved {
                body: moved.body.into(),
                position: moved.position.into(),
                rotation: moved.rotation.into(),
                fell_asleep: moved.fell_asleep.into(),
            });
        }
        Ok(world.moved_bodies().count())
    })
}
