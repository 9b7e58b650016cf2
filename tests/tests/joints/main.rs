//! What every kind of joint does: limits, drives, partners, refusals, and bits.

mod api;
mod bits;
mod drives;
mod iterative;
mod leapfrog;
mod limits;
mod meeting;
mod partners;
mod plain;
mod robust;

use cellstep::math::{Pose, Vec3};
use cellstep::{BodyHandle, JointDef, JointHandle};
use cellstep_tests::jointed::{Bar, about_y, jointed};
use cellstep_tests::worlds::OwnedWorld;

/// So many rods of 1 kg and 1 m in a chain from the origin along a direction, on plain balls or on hinges.
fn chain_of_rods(
    (rods, substeps): (usize, u32),
    along: Vec3,
    is_hinge: bool,
) -> (OwnedWorld, Vec<BodyHandle>, Vec<JointHandle>) {
    let (mut world, base) = jointed(rods as u32 + 1, rods as u32, substeps);
    let (mut bodies, mut joints) = (Vec::new(), Vec::new());
    let mut before = (base, Pose::new(Vec3::ZERO, about_y()));
    for rod in 0..rods {
        let bar = Bar::new(&mut world, along * rod as f32, along * (rod + 1) as f32);
        let (ends, frames) = ([before.0, bar.body], [before.1, bar.end(-1.0).1]);
        let def = if is_hinge { JointDef::hinge(ends, frames) } else { JointDef::ball(ends, frames) };
        joints.push(world.create_joint(&def).expect("room"));
        bodies.push(bar.body);
        before = bar.end(1.0);
    }
    (world, bodies, joints)
}
