//! `rapier3d` as an entrant, on one thread: its defaults, and a sweep of what it offers.

use crate::engine::{Config, Engine};
use crate::scene::{JointKind, Kind, Mass, Seen, Setup, Shape};
use cellstep::math::{Pose as Frame, Rotation as Turn, Vec3};
use cellstep_tests::oracles::Wide;
use rapier3d::prelude::*;

/// Name of the engine in tables.
pub const NAME: &str = "rapier3d";

struct Rapier {
    world: PhysicsWorld,
    bodies: Vec<RigidBodyHandle>,
}

fn vector(v: Vec3) -> Vector {
    Vector::new(v.x, v.y, v.z)
}

fn rotation(q: Turn) -> Rotation {
    Rotation::from_xyzw(q.x, q.y, q.z, q.w)
}

fn shape_of(shape: Shape, hull: &[Vec3]) -> ColliderBuilder {
    match shape {
        Shape::Sphere(radius) => ColliderBuilder::ball(radius),
        Shape::Box(half) => ColliderBuilder::cuboid(half.x, half.y, half.z),
        Shape::Capsule { half_height, radius } => ColliderBuilder::capsule_z(half_height, radius),
        Shape::Hull => {
            let points: Vec<Vector> = hull.iter().map(|&point| vector(point)).collect();
            ColliderBuilder::convex_hull(&points).expect("the points span a hull")
        }
    }
}

impl Rapier {
    fn new(setup: &Setup, parameters: IntegrationParameters) -> Self {
        let mut world = PhysicsWorld::new();
        world.gravity = vector(setup.gravity);
        world.integration_parameters = IntegrationParameters { dt: setup.dt, ..parameters };
        let mut bodies = Vec::with_capacity(setup.bodies.len());
        for body in &setup.bodies {
            let kind = if body.moves { RigidBodyBuilder::dynamic() } else { RigidBodyBuilder::fixed() };
            let [x, y, z] = body.position.map(|x| x as f32);
            let pose = Pose::from_parts(Vector::new(x, y, z), rotation(body.rotation));
            let def =
                kind.pose(pose).linvel(vector(body.velocity)).angvel(vector(body.spin)).can_sleep(false);
            let def = match body.mass {
                Mass::Given(mass, inertia) if body.moves => {
                    let mass = MassProperties::new(Vector::ZERO, mass, vector(inertia));
                    def.additional_mass_properties(mass)
                }
                _ => def,
            };
            bodies.push(match (body.shape, body.mass) {
                (Some(shape), Mass::Density(density)) => {
                    let shape = shape_of(shape, &setup.hull).density(density);
                    world.insert(def, shape.friction(body.friction).restitution(body.restitution)).0
                }
                _ => world.insert_body(def),
            });
        }
        for joint in &setup.joints {
            let axes = match joint.kind {
                JointKind::Ball => JointAxesMask::LOCKED_SPHERICAL_AXES,
                JointKind::Hinge => JointAxesMask::LOCKED_REVOLUTE_AXES,
                JointKind::Slider => JointAxesMask::LOCKED_PRISMATIC_AXES,
            };
            let frame = |frame: Frame| Pose::from_parts(vector(frame.position), rotation(frame.rotation));
            let [a, b] = joint.frames.map(frame);
            let def = GenericJointBuilder::new(axes).local_frame1(a).local_frame2(b);
            let [a, b] = joint.bodies.map(|body| bodies[body]);
            world.insert_impulse_joint(a, b, def);
        }
        Self { world, bodies }
    }
}

impl Engine for Rapier {
    fn step(&mut self) {
        self.world.step();
    }

    fn read(&self, seen: &mut Vec<Seen>) {
        let wide = |v: Vector| -> Wide { [v.x, v.y, v.z].map(f64::from) };
        seen.clear();
        seen.extend(self.bodies.iter().map(|&handle| {
            let body = &self.world.bodies[handle];
            let q = body.rotation();
            Seen {
                position: wide(body.translation()),
                rotation: Turn::new(q.x, q.y, q.z, q.w),
                velocity: wide(body.linvel()),
                spin: wide(body.angvel()),
            }
        }));
    }
}

fn describe(p: &IntegrationParameters, kind: Kind) -> String {
    let sweeps = format!(
        "{} x ({} + {})",
        p.num_solver_iterations, p.num_internal_pgs_iterations, p.num_internal_stabilization_iterations
    );
    let contacts = format!(
        ", {} Hz ({} Hz fixed), damping {}, {:?} friction",
        p.contact_softness.natural_frequency,
        p.static_contact_softness.natural_frequency,
        p.contact_softness.damping_ratio,
        p.friction_model
    );
    let joints = if p.warmstart_joints { ", joints warm started" } else { ", joints not warm started" };
    let contacts = if kind.has_contacts() { contacts } else { String::new() };
    sweeps + &contacts + if kind.has_joints() { joints } else { "" }
}

/// The default, then what differs from it in one setting; contacts as stiff as the substeps allow go with these.
pub fn configs(kind: Kind) -> Vec<Config> {
    let default = IntegrationParameters::default();
    let mut named = vec![("default".to_string(), default)];
    let mut add = |name: String, parameters| named.push((name, parameters));
    for count in [1, 2, 8, 16, 32] {
        add(format!("{count} substeps"), IntegrationParameters { num_solver_iterations: count, ..default });
    }
    if kind.has_contacts() {
        for count in [8, 16, 32] {
            let mut stiff = IntegrationParameters { num_solver_iterations: count, ..default };
            stiff.contact_softness.natural_frequency = 7.5 * count as f32;
            stiff.static_contact_softness.natural_frequency = 15.0 * count as f32;
            add(format!("{count} substeps, stiffness follows"), stiff);
        }
        let friction_model = FrictionModel::Coulomb;
        add("Coulomb friction".to_string(), IntegrationParameters { friction_model, ..default });
    }
    if kind.has_joints() {
        for count in [4, 8, 16] {
            let warmstart_joints = true;
            let warm = IntegrationParameters { num_solver_iterations: count, warmstart_joints, ..default };
            add(format!("{count} substeps, joints warm started"), warm);
        }
    }
    if kind != Kind::Free {
        for count in [2, 4] {
            let more = IntegrationParameters { num_internal_pgs_iterations: count, ..default };
            add(format!("{count} sweeps"), more);
        }
        let num_internal_stabilization_iterations = 2;
        let relaxed = IntegrationParameters { num_internal_stabilization_iterations, ..default };
        add("2 relax sweeps".to_string(), relaxed);
    }
    let config = |(place, (name, parameters)): (usize, (String, IntegrationParameters))| Config {
        engine: NAME,
        name,
        settings: describe(&parameters, kind),
        substeps: parameters.num_solver_iterations as u32,
        preset: None,
        is_default: place == 0,
        make: Box::new(move |setup| Box::new(Rapier::new(setup, parameters))),
    };
    named.into_iter().enumerate().map(config).collect()
}
