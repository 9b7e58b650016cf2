//! Box3D, by the crate `boxddd`, as an entrant: on one thread, at its default settings.

use crate::Engine;
use crate::scenes::{DENSITY, DT, FRICTION, GRAVITY, INERTIA, Joint, MASS, Scene};
use boxddd::{
    BodyId, BodyType, BoxHull, Capsule, Foundation, JointId, MassData, Matrix3, Quat, Result, Sphere,
    SphericalJointDef, Transform, World, WorldDef,
};
use cellstep::Geometry;
use cellstep::math::{Pose, Rotation, Vec3};

/// What Box3D's own samples and documents step with: it has no default.
const SUBSTEPS: i32 = 4;

pub struct Box3d {
    world: World,
    bodies: Vec<BodyId>,
    joints: Vec<JointId>,
    settings: String,
}

impl Box3d {
    pub fn new(scene: &Scene) -> Self {
        Self::fill(scene).expect("the scene is within Box3D's limits")
    }

    fn fill(scene: &Scene) -> Result<Self> {
        let foundation = Foundation::get().or_else(|_| Foundation::initialize_default())?;
        let gravity = boxddd::Vec3::new(0.0, 0.0, GRAVITY);
        let def =
            foundation.world_def_builder().gravity(gravity).enable_sleep(false).worker_count(1).build()?;
        let mut world = foundation.create_world(def)?;
        let mut bodies = Vec::with_capacity(scene.bodies.len());
        for body in &scene.bodies {
            let p = body.position;
            let kind = if body.moves { BodyType::Dynamic } else { BodyType::Static };
            let def =
                foundation.body_def_builder().body_type(kind).position(boxddd::Vec3::new(p.x, p.y, p.z));
            let handle = world.create_body(def.linear_damping(0.0).angular_damping(0.0).build()?)?;
            let Some(geometry) = body.geometry else {
                let axis = |x, y, z| boxddd::Vec3::new(INERTIA * x, INERTIA * y, INERTIA * z);
                let inertia =
                    Matrix3 { cx: axis(1.0, 0.0, 0.0), cy: axis(0.0, 1.0, 0.0), cz: axis(0.0, 0.0, 1.0) };
                let mass = MassData { mass: MASS, center: boxddd::Vec3::ZERO, inertia };
                if body.moves {
                    world.set_body_mass_data(handle, mass)?;
                }
                bodies.push(handle);
                continue;
            };
            let shape = foundation.shape_def_builder().density(DENSITY).friction(FRICTION).build()?;
            match geometry {
                Geometry::Sphere { radius } => {
                    let sphere = Sphere::new(boxddd::Vec3::ZERO, radius);
                    world.create_sphere_shape(handle, &shape, &sphere)?;
                }
                Geometry::Box { half_extents: h } => {
                    world.create_hull_shape(handle, &shape, &BoxHull::new(h.x, h.y, h.z)?)?;
                }
                Geometry::Capsule { half_height, radius } => {
                    let end = |z| boxddd::Vec3::new(0.0, 0.0, z);
                    let capsule = Capsule::new(end(-half_height), end(half_height), radius);
                    world.create_capsule_shape(handle, &shape, &capsule)?;
                }
                other => panic!("the scenes have no {other:?}"),
            }
            bodies.push(handle);
        }
        let joints = Self::join(&mut world, scene, &bodies)?;
        let settings = Self::describe(&world, foundation.world_def(), joints.first())?;
        Ok(Self { world, bodies, joints, settings })
    }

    fn join(world: &mut World, scene: &Scene, bodies: &[BodyId]) -> Result<Vec<JointId>> {
        let frame = |v: Vec3| Transform::new(boxddd::Vec3::new(v.x, v.y, v.z), Quat::IDENTITY);
        let join = |joint: &Joint| {
            let ([a, b], [at_a, at_b]) = (joint.bodies.map(|body| bodies[body]), joint.anchors.map(frame));
            let def = SphericalJointDef::new(a, b).local_frame_a(at_a).local_frame_b(at_b);
            world.create_spherical_joint(def)
        };
        scene.joints.iter().map(join).collect()
    }

    fn describe(world: &World, def: WorldDef, joint: Option<&JointId>) -> Result<String> {
        if let Some(&joint) = joint {
            let tuning = world.joint_constraint_tuning(joint)?;
            let (hertz, ratio) = (tuning.hertz, tuning.damping_ratio);
            return Ok(format!(
                "{SUBSTEPS} substeps x (1 sweep + 1 relax), joints at {hertz} Hz, damping ratio {ratio}"
            ));
        }
        Ok(format!(
            "{SUBSTEPS} substeps x (1 sweep + 1 relax), {} Hz, damping ratio {}, recycling within {} m",
            def.contact_hertz,
            def.contact_damping_ratio,
            world.contact_recycle_distance()?
        ))
    }

    fn deepest(&self) -> Result<f32> {
        let (mut deepest, mut contacts) = (0.0, Vec::new());
        for &body in &self.bodies {
            self.world.body_contacts_into(body, &mut contacts)?;
            let points = contacts.iter().flat_map(|contact| &contact.manifolds).flat_map(|m| m.points());
            deepest = points.fold(deepest, |deepest, point| cellstep::math::max(deepest, -point.separation));
        }
        Ok(deepest)
    }
}

impl Engine for Box3d {
    fn name(&self) -> String {
        "boxddd 0.4 (Box3D), 1 thread".to_string()
    }

    fn settings(&self) -> String {
        self.settings.clone()
    }

    fn step(&mut self) {
        self.world.step(DT, SUBSTEPS).expect("nothing is called back that could fail");
    }

    fn poses(&self) -> Vec<Pose> {
        let pose = |&body: &BodyId| -> Result<Pose> {
            let (p, q) = (self.world.body_position(body)?, self.world.body_rotation(body)?);
            Ok(Pose::new(Vec3::new(p.x, p.y, p.z), Rotation::new(q.v.x, q.v.y, q.v.z, q.s)))
        };
        self.bodies.iter().map(|body| pose(body).expect("the body is there")).collect()
    }

    fn own_overlap(&self) -> f32 {
        self.deepest().expect("the bodies are there")
    }

    fn own_gap(&self) -> Option<f32> {
        let gap = |&joint| self.world.joint_linear_separation(joint).expect("the joint is there");
        Some(self.joints.iter().map(gap).fold(0.0, cellstep::math::max))
    }
}
