//! Box3D, by the crate `boxddd`, as an entrant, on one thread: its defaults, and a sweep of what it offers.
//!
//! Substeps have no default there: its samples and documents use four. It bounds the frequency of contacts by an
//! eighth of the substep rate and that of joints by a quarter, so that 30 Hz (its default) are less with fewer.

use crate::engine::{Config, Engine};
use crate::scene::{Joint, JointKind, Kind, Mass, Seen, Setup, Shape};
use boxddd::{
    BodyId, BodyType, BoxHull, Capsule, Foundation, Hull, JointTuning, MassData, Matrix3, PrismaticJointDef,
    Quat, Result, RevoluteJointDef, Sphere, SphericalJointDef, Transform, World,
};
use cellstep::math::{PI, Pose, Rotation, Vec3};
use cellstep_tests::oracles::Wide;

/// Name of the engine in tables.
pub const NAME: &str = "Box3D";
/// What its samples step with.
const SUBSTEPS: u32 = 4;
/// Its defaults, Hz and damping ratios.
const CONTACT: [f32; 2] = [30.0, 10.0];
const JOINT: [f32; 2] = [60.0, 2.0];
/// Its default for the fastest push-out, m/s.
const PUSH: f32 = 3.0;

#[derive(Clone, Copy)]
struct Dial {
    substeps: u32,
    contact_hertz: f32,
    joint_hertz: f32,
    /// `None` for the default.
    recycling: Option<f32>,
}

struct Box3d {
    world: World,
    bodies: Vec<BodyId>,
    dt: f32,
    substeps: i32,
}

fn vector(v: Vec3) -> boxddd::Vec3 {
    boxddd::Vec3::new(v.x, v.y, v.z)
}

fn quaternion(q: Rotation) -> Quat {
    Quat { v: boxddd::Vec3::new(q.x, q.y, q.z), s: q.w }
}

impl Box3d {
    fn new(setup: &Setup, dial: Dial) -> Result<Self> {
        let foundation = Foundation::get().or_else(|_| Foundation::initialize_default())?;
        let def = foundation.world_def_builder().gravity(vector(setup.gravity)).enable_sleep(false);
        let def = def.contact_tuning(dial.contact_hertz, CONTACT[1], PUSH).worker_count(1).build()?;
        let mut world = foundation.create_world(def)?;
        if let Some(distance) = dial.recycling {
            world.set_contact_recycle_distance(distance)?;
        }
        let mut bodies = Vec::with_capacity(setup.bodies.len());
        for body in &setup.bodies {
            let [x, y, z] = body.position.map(|x| x as f32);
            let kind = if body.moves { BodyType::Dynamic } else { BodyType::Static };
            let def = foundation.body_def_builder().body_type(kind).position(boxddd::Vec3::new(x, y, z));
            let def = def.rotation(quaternion(body.rotation)).linear_damping(0.0).angular_damping(0.0);
            let def = def.linear_velocity(vector(body.velocity)).angular_velocity(vector(body.spin));
            let handle = world.create_body(def.allow_fast_rotation(true).build()?)?;
            bodies.push(handle);
            match (body.mass, body.shape) {
                (Mass::Given(mass, i), _) if body.moves => {
                    let axis = |x, y, z| boxddd::Vec3::new(x, y, z);
                    let inertia =
                        Matrix3 { cx: axis(i.x, 0.0, 0.0), cy: axis(0.0, i.y, 0.0), cz: axis(0.0, 0.0, i.z) };
                    world
                        .set_body_mass_data(handle, MassData { mass, center: boxddd::Vec3::ZERO, inertia })?;
                }
                (Mass::Density(density), Some(shape)) => {
                    let def = foundation.shape_def_builder().density(density).friction(body.friction);
                    let def = def.restitution(body.restitution).build()?;
                    Self::add_shape(&mut world, handle, (&def, shape), &setup.hull)?;
                }
                _ => {}
            }
        }
        for joint in &setup.joints {
            Self::join(&mut world, joint, &bodies, dial.joint_hertz)?;
        }
        Ok(Self { world, bodies, dt: setup.dt, substeps: dial.substeps as i32 })
    }

    fn add_shape(
        world: &mut World,
        body: BodyId,
        (def, shape): (&boxddd::ShapeDef, Shape),
        hull: &[Vec3],
    ) -> Result<()> {
        match shape {
            Shape::Sphere(radius) => {
                world.create_sphere_shape(body, def, &Sphere::new(boxddd::Vec3::ZERO, radius))?;
            }
            Shape::Box(h) => {
                world.create_hull_shape(body, def, &BoxHull::new(h.x, h.y, h.z)?)?;
            }
            Shape::Capsule { half_height, radius } => {
                let end = |z| boxddd::Vec3::new(0.0, 0.0, z);
                world.create_capsule_shape(
                    body,
                    def,
                    &Capsule::new(end(-half_height), end(half_height), radius),
                )?;
            }
            Shape::Hull => {
                let points: Vec<boxddd::Vec3> = hull.iter().map(|&point| vector(point)).collect();
                world.create_created_hull_shape(body, def, &Hull::from_points(&points, 64)?)?;
            }
        }
        Ok(())
    }

    fn join(world: &mut World, joint: &Joint, bodies: &[BodyId], hertz: f32) -> Result<()> {
        let [a, b] = joint.bodies.map(|body| bodies[body]);
        let tuning = JointTuning::new(hertz, JOINT[1]);
        // Its hinges turn about z, ours about x.
        let turn = Rotation::from_axis_angle(Vec3::Y, 0.5 * PI);
        let frame = |frame: Pose, turn: Rotation| {
            Transform::new(vector(frame.position), quaternion(frame.rotation.after(turn)))
        };
        let turn = if joint.kind == JointKind::Hinge { turn } else { Rotation::IDENTITY };
        let [at_a, at_b] = joint.frames.map(|place| frame(place, turn));
        match joint.kind {
            JointKind::Ball => {
                let def = SphericalJointDef::new(a, b).local_frame_a(at_a).local_frame_b(at_b);
                world.create_spherical_joint(def.constraint_tuning(tuning))?;
            }
            JointKind::Hinge => {
                let def = RevoluteJointDef::new(a, b).local_frame_a(at_a).local_frame_b(at_b);
                world.create_revolute_joint(def.constraint_tuning(tuning))?;
            }
            JointKind::Slider => {
                let def = PrismaticJointDef::new(a, b).local_frame_a(at_a).local_frame_b(at_b);
                world.create_prismatic_joint(def.constraint_tuning(tuning))?;
            }
        }
        Ok(())
    }

    fn seen(&self, body: BodyId) -> Result<Seen> {
        let wide = |v: boxddd::Vec3| -> Wide { [v.x, v.y, v.z].map(f64::from) };
        let (p, q) = (self.world.body_position(body)?, self.world.body_rotation(body)?);
        Ok(Seen {
            position: [p.x, p.y, p.z].map(f64::from),
            rotation: Rotation::new(q.v.x, q.v.y, q.v.z, q.s),
            velocity: wide(self.world.body_linear_velocity(body)?),
            spin: wide(self.world.body_angular_velocity(body)?),
        })
    }
}

impl Engine for Box3d {
    fn step(&mut self) {
        self.world.step(self.dt, self.substeps).expect("nothing is called back that could fail");
    }

    fn read(&self, seen: &mut Vec<Seen>) {
        seen.clear();
        seen.extend(self.bodies.iter().map(|&body| self.seen(body).expect("the body is there")));
    }
}

fn describe(dial: &Dial, kind: Kind) -> String {
    let mut text = format!("{} x (1 + 1)", dial.substeps);
    if kind.has_contacts() {
        text += &format!(", contacts {} Hz, damping {}", dial.contact_hertz, CONTACT[1]);
    }
    if kind.has_joints() {
        text += &format!(", joints {} Hz, damping {}", dial.joint_hertz, JOINT[1]);
    }
    if let Some(distance) = dial.recycling {
        text += &format!(", recycling within {distance} m");
    }
    text
}

/// The default, then what differs from it; contacts and joints as stiff as the substeps allow go with these.
pub fn configs(kind: Kind) -> Vec<Config> {
    let default =
        Dial { substeps: SUBSTEPS, contact_hertz: CONTACT[0], joint_hertz: JOINT[0], recycling: None };
    let mut named = vec![("default".to_string(), default)];
    let mut add = |name: String, dial| named.push((name, dial));
    for substeps in [1, 2, 8, 16, 32] {
        add(format!("{substeps} substeps"), Dial { substeps, ..default });
    }
    if kind != Kind::Free {
        for substeps in [8, 16, 32] {
            let rate = substeps as f32;
            let stiff =
                Dial { substeps, contact_hertz: 7.5 * rate, joint_hertz: 15.0 * rate, recycling: None };
            add(format!("{substeps} substeps, stiffness follows"), stiff);
        }
    }
    if kind.has_contacts() {
        add("no recycling".to_string(), Dial { recycling: Some(0.0), ..default });
        add("15 Hz".to_string(), Dial { contact_hertz: 15.0, ..default });
    }
    let config = |(place, (name, dial)): (usize, (String, Dial))| Config {
        engine: NAME,
        name,
        settings: describe(&dial, kind),
        substeps: dial.substeps,
        preset: None,
        is_default: place == 0,
        make: Box::new(move |setup| {
            Box::new(Box3d::new(setup, dial).expect("the scene is within its limits"))
        }),
    };
    named.into_iter().enumerate().map(config).collect()
}
