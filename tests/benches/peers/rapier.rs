//! `rapier3d` as an entrant, on one thread, at its default settings.

use crate::Engine;
use crate::scenes::{DENSITY, DT, FRICTION, GRAVITY, INERTIA, MASS, Scene};
use cellstep::Geometry;
use cellstep::math::{Pose, Rotation, Vec3};
use rapier3d::prelude::*;

pub struct Rapier {
    world: PhysicsWorld,
    bodies: Vec<RigidBodyHandle>,
}

impl Rapier {
    pub fn new(scene: &Scene) -> Self {
        let mut world = PhysicsWorld::new();
        world.gravity = Vector::new(0.0, 0.0, GRAVITY);
        world.integration_parameters.dt = DT;
        let mut bodies = Vec::with_capacity(scene.bodies.len());
        for body in &scene.bodies {
            let (p, geometry) = (body.position, body.geometry);
            let kind = if body.moves { RigidBodyBuilder::dynamic() } else { RigidBodyBuilder::fixed() };
            let body = kind.translation(Vector::new(p.x, p.y, p.z)).can_sleep(false);
            let Some(geometry) = geometry else {
                let inertia = Vector::new(INERTIA, INERTIA, INERTIA);
                let mass = MassProperties::new(Vector::ZERO, MASS, inertia);
                bodies.push(world.insert_body(body.additional_mass_properties(mass)));
                continue;
            };
            let shape = match geometry {
                Geometry::Sphere { radius } => ColliderBuilder::ball(radius),
                Geometry::Box { half_extents: h } => ColliderBuilder::cuboid(h.x, h.y, h.z),
                Geometry::Capsule { half_height, radius } => ColliderBuilder::capsule_z(half_height, radius),
                other => panic!("the scenes have no {other:?}"),
            };
            let (handle, _) = world.insert(body, shape.density(DENSITY).friction(FRICTION));
            bodies.push(handle);
        }
        for joint in &scene.joints {
            let [a, b] = joint.bodies.map(|body| bodies[body]);
            let [at_a, at_b] = joint.anchors.map(|anchor| Vector::new(anchor.x, anchor.y, anchor.z));
            let ball = SphericalJointBuilder::new().local_anchor1(at_a).local_anchor2(at_b);
            world.insert_impulse_joint(a, b, ball);
        }
        Self { world, bodies }
    }
}

impl Engine for Rapier {
    fn name(&self) -> String {
        "rapier3d 0.36, 1 thread".to_string()
    }

    fn settings(&self) -> String {
        let p = &self.world.integration_parameters;
        if let Some((_, joint)) = self.world.impulse_joints().next() {
            let softness = joint.data.softness;
            return format!(
                "{} substeps x ({} sweep + {} relax), impulse joints at {:.0} Hz, damping ratio {}",
                p.num_solver_iterations,
                p.num_internal_pgs_iterations,
                p.num_internal_stabilization_iterations,
                softness.natural_frequency,
                softness.damping_ratio
            );
        }
        format!(
            "{} substeps x ({} sweep + {} relax), {:.0} Hz ({:.0} Hz with fixed bodies), damping ratio {}, \
             recycling {}, {:?} friction",
            p.num_solver_iterations,
            p.num_internal_pgs_iterations,
            p.num_internal_stabilization_iterations,
            p.contact_softness.natural_frequency,
            p.static_contact_softness.natural_frequency,
            p.contact_softness.damping_ratio,
            p.contact_recycling,
            p.friction_model
        )
    }

    fn step(&mut self) {
        self.world.step();
    }

    fn poses(&self) -> Vec<Pose> {
        let pose = |&handle: &RigidBodyHandle| {
            let (p, q) = (self.world.bodies[handle].translation(), self.world.bodies[handle].rotation());
            Pose::new(Vec3::new(p.x, p.y, p.z), Rotation::new(q.x, q.y, q.z, q.w))
        };
        self.bodies.iter().map(pose).collect()
    }

    fn own_overlap(&self) -> f32 {
        let pairs = self.world.narrow_phase.contact_pairs();
        let deepest = |pair: &ContactPair| pair.find_deepest_contact().map_or(0.0, |(_, point)| -point.dist);
        pairs.map(deepest).fold(0.0, cellstep::math::max)
    }
}
