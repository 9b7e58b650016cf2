//! More inertia for bodies whose joints are loaded heavily for what they weigh.
//!
//! A force f on a point at the arm r turns a body like a spring: the torque `r x f` changes by `-K t` when the body
//! turns by t, with `K = (f . r) 1 - (r ft + f rt) / 2` (the geometric stiffness of constrained bodies). Substeps
//! of length h follow the swing of that spring only while it is slower than they are: the square of its angular
//! frequency times h, `h^2 K / I`, must stay below 4. A light chain under a heavy weight swings faster, and
//! explodes where its joints hold exactly. Here it gets what inertia it lacks to stay below 1: it turns slower
//! than it would.
//! (Andrews, Teichmann and Kry, Geometric stiffness for real-time constrained multibody dynamics, 2017.)
//!
//! Only bodies with joints are looked at, and few of them gain any: a link of 1 kg and 1 m at 4 substeps from a
//! load of half a ton on.

use crate::body::BodyRow;
use crate::math::{Rotation, Vec3, max, min, sqrt};
use crate::state::{Active, State};

/// What the principal moments of a body gain in a step, kg m2. The forces are those of the step before.
pub(crate) fn stiffening(state: &State<'_>, body: u32, substep: f32) -> Vec3 {
    let mut next = state.first_joints.get(body as usize).copied().unwrap_or(0);
    if next == 0 {
        return Vec3::ZERO;
    }
    let row = &state.bodies[body as usize];
    let motion = &state.motions[body as usize];
    if !is_loaded(state, (body, next), substep) {
        return Vec3::ZERO;
    }
    let to_body = motion.rotation.inverse();
    let to_principal = row.axes.inverse();
    // K about the principal axes: diagonal, then xy, xz, yz.
    let (mut diagonal, mut rest) = (Vec3::ZERO, Vec3::ZERO);
    while next != 0 {
        let joint = &state.joints[next as usize - 1];
        let is_b = joint.bodies[0] != body;
        let frame = &joint.frames[usize::from(is_b)];
        let force = to_principal.rotate(to_body.rotate(if is_b { joint.force } else { -joint.force }));
        let arm = to_principal.rotate(frame.position - row.local_center);
        diagonal += Vec3::splat(force.dot(arm)) - force * arm;
        rest -= Vec3::new(
            arm.x * force.y + force.x * arm.y,
            arm.x * force.z + force.x * arm.z,
            arm.y * force.z + force.y * arm.z,
        ) * 0.5;
        next = joint.next_of(body);
    }
    // The sum of a row of K, scaled by the inertia, is no less than what that axis takes part in.
    let i = row.inertia;
    let (x, y, z) = (sqrt(i.x), sqrt(i.y), sqrt(i.z));
    let rest = rest.abs();
    let sums = diagonal.abs()
        + Vec3::new(
            x * (rest.x / y + rest.y / z),
            y * (rest.x / x + rest.z / z),
            z * (rest.y / x + rest.z / y),
        );
    let gain = sums * (substep * substep) - i;
    Vec3::new(max(gain.x, 0.0), max(gain.y, 0.0), max(gain.z, 0.0))
}

/// False when no axis of a body can gain anything: its joints' forces are too small for any direction of theirs.
fn is_loaded(state: &State<'_>, (body, first): (u32, u32), substep: f32) -> bool {
    let row = &state.bodies[body as usize];
    let mut loads = 0.0;
    let mut next = first;
    while next != 0 {
        let joint = &state.joints[next as usize - 1];
        let arm = joint.frames[usize::from(joint.bodies[0] != body)].position - row.local_center;
        loads += sqrt(joint.force.length_squared() * arm.length_squared());
        next = joint.next_of(body);
    }
    // An element of K is at most the load, one beside the diagonal half of it.
    let Vec3 { x, y, z } = row.inertia;
    let (least, most) = (min(min(x, y), z), max(max(x, y), z));
    let sums = loads * (1.0 + sqrt(most / least));
    // The margin is for rounding. What is no number is looked at.
    let is_light = sums * (substep * substep) < 0.99 * least;
    !is_light
}

/// The angular velocity that a body's momentum means with its inertia in this step: what it gains of inertia it
/// does not gain of momentum, so that loads that come and go give no energy.
pub(crate) fn eased(active: &Active, row: &BodyRow, (principal, angular): (Rotation, Vec3)) -> Vec3 {
    if active.stiffening == Vec3::ZERO {
        return angular;
    }
    let shares = row.inertia / active.inertia(row);
    principal.rotate(shares * principal.inverse().rotate(angular))
}
