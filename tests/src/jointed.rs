//! Bodies for scenes of joints: rods and balls without shapes, and where their frames are.

use crate::oracles::{self, Wide};
use crate::worlds::{self, OwnedWorld};
use cellstep::math::{PI, Pose, Rotation, Vec3};
use cellstep::{BodyDef, BodyHandle, BodyKind, Capacities, JointHandle, MassProperties, Settings};

/// Turns the x axis of a frame into the world's y axis: hinges turn about x.
pub fn about_y() -> Rotation {
    Rotation::from_axis_angle(Vec3::Z, 0.5 * PI)
}

/// A frame that is not turned.
pub fn at(place: Vec3) -> Pose {
    Pose::new(place, Rotation::IDENTITY)
}

/// A world of some bodies and joints, with so many substeps, and a static body at the origin.
pub fn jointed(bodies: u32, joints: u32, substeps: u32) -> (OwnedWorld, BodyHandle) {
    let mut world = worlds::world_with(Capacities { joints, ..Capacities::for_bodies(bodies + 1) });
    let settings = Settings { substeps, ..world.settings() };
    world.set_settings(&settings).expect("in range");
    let base = world.create_body(&BodyDef::new(BodyKind::Static, Vec3::ZERO)).expect("room");
    (world, base)
}

/// Switches gravity off.
pub fn weightless(world: &mut OwnedWorld) {
    let settings = Settings { gravity: Vec3::ZERO, ..world.settings() };
    world.set_settings(&settings).expect("in range");
}

/// A dynamic body with this mass and no shape.
pub fn massive(world: &mut OwnedWorld, pose: Pose, mass: MassProperties) -> BodyHandle {
    let def = BodyDef {
        rotation: pose.rotation,
        mass: Some(mass),
        ..BodyDef::new(BodyKind::Dynamic, pose.position)
    };
    world.create_body(&def).expect("room")
}

/// Mass and moments of a solid ball.
pub fn ball(mass: f32, radius: f32) -> MassProperties {
    MassProperties { mass, inertia: Vec3::splat(0.4 * mass * radius * radius), ..MassProperties::default() }
}

/// Mass and moments of a thin rod along x.
pub fn rod(mass: f32, length: f32) -> MassProperties {
    let moment = mass * length * length / 12.0;
    MassProperties { mass, inertia: Vec3::new(0.01 * moment, moment, moment), ..MassProperties::default() }
}

/// A rod between two points, and its frame's place at either end.
#[derive(Clone, Copy, Debug)]
pub struct Bar {
    /// The body; its x axis is along the bar.
    pub body: BodyHandle,
    /// How it is turned.
    pub rotation: Rotation,
    /// Metres.
    pub length: f32,
}

impl Bar {
    /// A rod of 1 kg for each metre.
    pub fn new(world: &mut OwnedWorld, from: Vec3, to: Vec3) -> Self {
        let length = cellstep::math::length(to - from);
        let rotation = Rotation::between(Vec3::X, (to - from) / length);
        let pose = Pose::new((from + to) * 0.5, rotation);
        Self { body: massive(world, pose, rod(length, length)), rotation, length }
    }

    /// The frame of a hinge about the world's y axis at the bar's start (-1) or end (1).
    pub fn end(&self, side: f32) -> (BodyHandle, Pose) {
        let place = Vec3::new(0.5 * side * self.length, 0.0, 0.0);
        (self.body, Pose::new(place, self.rotation.inverse().after(about_y())))
    }
}

/// Energy of a body: gravity along z at the given strength, and motion; J.
pub fn energy(world: &OwnedWorld, body: BodyHandle, gravity: f64) -> f64 {
    let mass = oracles::mass(world, body);
    let v = oracles::velocity(world, body);
    mass * (gravity * oracles::center(world, body)[2] + 0.5 * oracles::dot(v, v))
        + oracles::spin_energy(world, body)
}

/// How far the points of a joint are apart, metres.
pub fn gap(world: &OwnedWorld, joint: JointHandle) -> f64 {
    let c = world.joint_coordinates(joint).expect("the joint exists");
    oracles::norm(core::array::from_fn::<f64, 3, _>(|i| f64::from(c[i])))
}

/// Force on body B, N.
pub fn force(world: &OwnedWorld, joint: JointHandle) -> Wide {
    oracles::wide(world.joint_force(joint).expect("the joint exists"))
}

/// Torque on body B, N m.
pub fn torque(world: &OwnedWorld, joint: JointHandle) -> Wide {
    oracles::wide(world.joint_torque(joint).expect("the joint exists"))
}

/// A coordinate of a joint.
pub fn coordinate(world: &OwnedWorld, joint: JointHandle, axis: usize) -> f64 {
    f64::from(world.joint_coordinates(joint).expect("the joint exists")[axis])
}
