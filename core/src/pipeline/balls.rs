//! Rows of plain ball joints from the state, and their impulses back into it.

use crate::body::BodyKind;
use crate::cells::{IMMOVABLE, Link};
use crate::constraint::joint::BallRow;
use crate::constraint::velocities::free_axes;
use crate::joint::{JointRow, PLAIN_BALL};
use crate::lanes::{LANES, LaneVec, Words, transpose};
use crate::math::Vec3;
use crate::pipeline::assembly::Scene;
use crate::pipeline::layout::EMPTY;
use crate::pipeline::leapfrog::lanes_of;
use crate::pipeline::rows::Frame;
use crate::pipeline::{leapfrog, mover};
use crate::state::State;
use bytemuck::Zeroable;

/// True for a joint whose row is a [`BallRow`]: a plain ball between bodies whose velocities their seats say.
pub(crate) fn is_plain(state: &State<'_>, joint: &JointRow, link: &Link) -> bool {
    let fits = |(&slot, end): (&u32, u32)| {
        let body = &state.bodies[slot as usize];
        if end == IMMOVABLE { body.kind() != BodyKind::Kinematic } else { !mover::is_top(body) }
    };
    joint.has(PLAIN_BALL) && joint.bodies.iter().zip([link.a, link.b]).all(fits)
}

/// What the row reads of a joint, lane by lane.
struct Gathered {
    /// Arms in the bodies' frames, and the bodies' rotations.
    frames: [[Words; LANES]; 2],
    /// `[W, inverse mass, locks]` of the bodies.
    masses: [[Words; LANES]; 2],
    /// From the center of A to that of B, and the impulse.
    rest: [Words; LANES],
}

/// Writes one row.
pub(crate) fn fill(
    scene: &Scene<'_>,
    row: &mut BallRow,
    (joints, seats): (&[u32; LANES], &[u32; 2 * LANES]),
) {
    *row = BallRow::zeroed();
    row.seats_a.copy_from_slice(&seats[..LANES]);
    row.seats_b.copy_from_slice(&seats[LANES..]);
    let none = [Words::zeroed(); LANES];
    let mut gathered = Gathered { frames: [none; 2], masses: [none; 2], rest: none };
    for (lane, &joint) in joints.iter().enumerate() {
        if joint != EMPTY {
            gather(scene, (row, &mut gathered), (joint, lane));
        }
    }
    let Gathered { frames, masses, rest } = gathered;
    let [frame_a, frame_b] = frames.map(Frame::of);
    let arms = [&frame_a, &frame_b].map(|frame| frame.rotate(frame.position));
    let [a, b] = masses.map(transpose);
    let root = |[xx, yy, zz, xy, xz, yz, ..]: [crate::lanes::Lane; 8]| {
        [LaneVec::new(xx, yy, zz), LaneVec::new(xy, xz, yz)]
    };
    (row.root_a, row.root_b) = (root(a), root(b));
    let [cx, cy, cz, _, x, y, z, _] = transpose(rest);
    row.impulse = lanes_of(row.leaps).select_vec(LaneVec::ZERO, LaneVec::new(x, y, z));
    (row.arm_a, row.arm_b) = (arms[0], arms[1]);
    row.lever_a = LaneVec::new(cx, cy, cz) + arms[1];
    row.weigh(free_axes(a[7]).times(a[6]) + free_axes(b[7]).times(b[6]));
}

fn gather(scene: &Scene<'_>, (row, to): (&mut BallRow, &mut Gathered), (joint, lane): (u32, usize)) {
    let joint = &scene.joints[scene.joint_slots[joint as usize] as usize];
    let active = joint.bodies.map(|slot| scene.active_of[slot as usize]);
    if active[0] == IMMOVABLE {
        // Links have the dynamic body first.
        (row.seats_b[lane], row.seats_a[lane]) = (row.seats_a[lane], row.seats_b[lane]);
    }
    for (end, (&slot, &index)) in joint.bodies.iter().zip(&active).enumerate() {
        let motion = &scene.motions[slot as usize];
        let arm = joint.frames[end].position - scene.bodies[slot as usize].local_center;
        let q = motion.rotation;
        to.frames[end][lane] = Words::new([arm.x, arm.y, arm.z, 0.0, q.x, q.y, q.z, q.w]);
        if index != IMMOVABLE {
            let body = &scene.active[index as usize];
            row.locked |= u32::from(body.locks != 0.0);
            row.leaps |= u32::from(leapfrog::leaps(scene.marks, slot)) << lane;
            let [xx, yy, zz, xy, xz, yz] = body.root;
            to.masses[end][lane] = Words::new([xx, yy, zz, xy, xz, yz, body.inverse_mass, body.locks]);
        }
    }
    let [a, b] = joint.bodies.map(|slot| scene.motions[slot as usize].center);
    let (c, [x, y, z, ..]) = (b.minus(a), joint.impulses);
    to.rest[lane] = Words::new([c.x, c.y, c.z, 0.0, x, y, z, 0.0]);
}

/// Writes the impulse and the force of a lane into the state.
pub(crate) fn store(row: &BallRow, lane: usize, (joint, rate): (&mut JointRow, f32)) {
    let impulse = row.impulse.get(lane);
    // A row adds nothing that is not finite.
    (joint.impulses[0], joint.impulses[1], joint.impulses[2]) = (impulse.x, impulse.y, impulse.z);
    (joint.force, joint.torque) = (impulse * rate, Vec3::ZERO);
    if !joint.force.is_finite() {
        joint.forget();
    }
}
