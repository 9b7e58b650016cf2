//! Box3D, by the crate `boxddd`, as an entrant: on one thread, at its default settings.

use crate::Engine;
use crate::scenes::{DENSITY, DT, FRICTION, GRAVITY, Scene};
use boxddd::{BodyId, BodyType, BoxHull, Capsule, Foundation, Result, Sphere, World};
use cellstep::Geometry;
use cellstep::math::{Pose, Rotation, Vec3};

/// What Box3D's own samples and documents step with: it has no default.
const SUBSTEPS: i32 = 4;

pub struct Box3d {
    world: World,
    bodies: Vec<BodyId>,
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
            let shape = foundation.shape_def_builder().density(DENSITY).friction(FRICTION).build()?;
            match body.geometry {
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
        let def = foundation.world_def();
        let settings = format!(
            "{SUBSTEPS} substeps x (1 sweep + 1 relax), {} Hz, damping ratio {}, recycling within {} m",
            def.contact_hertz,
            def.contact_damping_ratio,
            world.contact_recycle_distance()?
        );
        Ok(Self { world, bodies, settings })
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
}
