//! Two worlds that differ by a shift of whole sectors: how to make one, and what it takes for them to be the same.

use crate::simulator::snapshot;
use crate::worlds::OwnedWorld;
use cellstep::config::SECTOR_MAX;
use cellstep::math::Vec3;
use cellstep::{Command, EventKind, Field, Position, StepReport};

/// A shift, sectors.
pub type Shift = [i32; 3];

/// Sectors that are left to the end of the world, so that what flies at the greatest speed does not leave it.
const ROOM: i32 = 1 << 20;

/// 64 m, 1 km, 10,000 km and almost to the last sector, along mixed axes to both sides.
pub const SHIFTS: [Shift; 7] = [
    [1, 0, 0],
    [-1, 1, -1],
    [16, -16, 16],
    [156_250, -156_250, 156_250],
    [-3, 1 << 20, 0],
    [SECTOR_MAX - ROOM, ROOM - SECTOR_MAX, ROOM - SECTOR_MAX],
    [0, 0, SECTOR_MAX - ROOM],
];

/// A place moved by whole sectors.
pub fn moved(place: Position, by: Shift) -> Position {
    Position { sector: std::array::from_fn(|axis| place.sector[axis] + by[axis]), ..place }
}

/// Moves all bodies of a world by metres, then by whole sectors. What stood apart by less than a last bit may stand
/// otherwise after the metres, but in the same way whatever the sectors.
pub fn move_bodies(world: &mut OwnedWorld, metres: Vec3, by: Shift) {
    let bodies: Vec<_> = world.bodies().collect();
    for body in bodies {
        let place = world.position(body).expect("alive").plus(metres);
        let rotation = world.rotation(body).expect("alive");
        world.set_pose(body, moved(place, by), rotation).expect("inside the world");
    }
}

/// A command whose places are moved by metres, then by whole sectors.
pub fn moved_command(command: &Command, metres: Vec3, by: Shift) -> Command {
    let place = |own: Position| moved(own.plus(metres), by);
    match *command {
        Command::CreateBody(mut def) => {
            def.position = place(def.position);
            Command::CreateBody(def)
        }
        Command::SetPose(body, own, rotation) => Command::SetPose(body, place(own), rotation),
        Command::SetKinematicTarget(body, own, turn) => Command::SetKinematicTarget(body, place(own), turn),
        Command::ApplyForceAt(body, force, own) => Command::ApplyForceAt(body, force, place(own)),
        Command::ApplyImpulseAt(body, impulse, own) => Command::ApplyImpulseAt(body, impulse, place(own)),
        other => other,
    }
}

/// True when a body of the far world has left the world in a step, which it can only near the last sector: it was
/// thrown out at thousands of kilometres per second, by commands without sense. Then the two part for good.
pub fn has_left(by: Shift, here: &StepReport, there: &StepReport) -> bool {
    let is_near_the_end = by.iter().any(|sectors| sectors.unsigned_abs() > SECTOR_MAX as u32 / 2);
    is_near_the_end && there.quarantined > here.quarantined
}

/// A snapshot without its header and without the numbers of sectors, for comparing states that differ in these.
fn rest_of(world: &OwnedWorld) -> Vec<(&'static str, Vec<u8>)> {
    let bytes = snapshot(world);
    let sections = world.snapshot_sections(&bytes).expect("its own");
    let rest = sections.map(|section| {
        let mut rows = bytes[section.range.clone()].to_vec();
        let mut byte = 0;
        while let Some(field) = Field::at(section.name, byte).filter(|_| byte < section.row_bytes) {
            if field.name.ends_with(".sector") {
                for row in rows.chunks_exact_mut(section.row_bytes) {
                    row[field.offset..field.end()].fill(0);
                }
            }
            byte = field.end();
        }
        (section.name, rows)
    });
    rest.collect()
}

/// Checks that two worlds are the same, bit for bit, but for the sectors: the whole state, events included.
///
/// # Panics
/// When anything else differs.
pub fn assert_same_but_for(by: Shift, here: &OwnedWorld, there: &OwnedWorld, what: &str) {
    for ((name, own), (_, far)) in rest_of(here).iter().zip(&rest_of(there)) {
        assert!(own == far, "{what}, shifted by {by:?}: section {name} differs");
    }
    for body in here.bodies() {
        for place in [OwnedWorld::center, OwnedWorld::position] {
            let own = place(here, body).expect("alive");
            assert_eq!(Ok(moved(own, by)), place(there, body), "{what}, {body:?}");
        }
    }
    let mut far = there.events();
    for mut event in here.events() {
        if let EventKind::ContactHit(hit) = &mut event.kind {
            hit.point = moved(hit.point, by);
        }
        assert_eq!(Some(event), far.next(), "{what}");
    }
}
