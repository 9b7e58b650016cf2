//! cellstep as an entrant.

use crate::Engine;
use crate::scenes::{DENSITY, DT, FRICTION, GRAVITY, INERTIA, MASS, Scene};
use cellstep::math::{Pose, Rotation, Vec3};
use cellstep::{
    BodyDef, BodyHandle, BodyKind, Capacities, JointDef, JointHandle, MassProperties, Pool, Serial, Settings,
    ShapeDef, ShapeHandle, Stage, StepReport, Timed,
};
use cellstep_tests::worlds::{OwnedWorld, add, world_with};

/// A world of a scene and its handles.
pub struct Filled {
    pub world: OwnedWorld,
    pub bodies: Vec<BodyHandle>,
    /// One a body, or none at all in scenes without shapes.
    pub shapes: Vec<ShapeHandle>,
    pub joints: Vec<JointHandle>,
}

impl Filled {
    pub fn new(scene: &Scene) -> Self {
        let capacities = Capacities {
            joints: scene.joints.len() as u32,
            ..Capacities::for_bodies(scene.bodies.len() as u32)
        };
        let mut world = world_with(capacities);
        let settings = Settings { dt: DT, gravity: Vec3::new(0.0, 0.0, GRAVITY), ..world.settings() };
        world.set_settings(&settings).expect("numbers in range");
        let (mut bodies, mut shapes) = (Vec::with_capacity(scene.bodies.len()), Vec::new());
        for body in &scene.bodies {
            let kind = if body.moves { BodyKind::Dynamic } else { BodyKind::Static };
            let def = BodyDef::new(kind, body.position);
            if let Some(geometry) = body.geometry {
                let shape = ShapeDef { density: DENSITY, friction: FRICTION, ..ShapeDef::new(geometry) };
                let (body, shape) = add(&mut world, &def, &shape);
                bodies.push(body);
                shapes.push(shape);
            } else {
                let (center, inertia) = (Vec3::ZERO, Vec3::splat(INERTIA));
                let mass = MassProperties { mass: MASS, center, inertia, axes: Rotation::IDENTITY };
                bodies.push(world.create_body(&BodyDef { mass: Some(mass), ..def }).expect("room"));
            }
        }
        let join = |joint: &crate::scenes::Joint| {
            let frames = joint.anchors.map(|anchor| Pose::new(anchor, Rotation::IDENTITY));
            let def = JointDef::ball(joint.bodies.map(|body| bodies[body]), frames);
            world.create_joint(&def).expect("room")
        };
        let joints = scene.joints.iter().map(join).collect();
        Filled { world, bodies, shapes, joints }
    }

    fn poses(&self) -> Vec<Pose> {
        let pose = |&body: &BodyHandle| {
            let [x, y, z] = self.world.position(body).expect("it is there").to_f64();
            let rotation = self.world.rotation(body).expect("it is there");
            Pose::new(Vec3::new(x as f32, y as f32, z as f32), rotation)
        };
        self.bodies.iter().map(pose).collect()
    }

    /// The widest joint by its own coordinates.
    fn gap(&self) -> f32 {
        let gap = |&joint: &JointHandle| {
            let [x, y, z, ..] = self.world.joint_coordinates(joint).expect("it is there");
            Vec3::new(x, y, z).length()
        };
        self.joints.iter().map(gap).fold(0.0, cellstep::math::max)
    }

    fn settings(&self) -> String {
        let s = self.world.settings();
        if !self.joints.is_empty() {
            let Settings { substeps, sweeps, relax_sweeps, .. } = s;
            return format!("{substeps} substeps x ({sweeps} sweep + {relax_sweeps} relax), rigid joints");
        }
        format!(
            "{} substeps x ({} sweep + {} relax), soft contacts, coupling {} / substep, damping ratio {}",
            s.substeps,
            s.sweeps,
            s.relax_sweeps,
            cellstep::config::CONTACT_COUPLING,
            s.contact_damping_ratio
        )
    }
}

/// One worker, with the times of its stages.
pub struct Serially {
    filled: Filled,
    executor: Timed<Serial>,
    report: StepReport,
    dropped: u64,
}

impl Serially {
    pub fn new(scene: &Scene) -> Self {
        let report = StepReport::default();
        Serially { filled: Filled::new(scene), executor: Timed::new(Serial), report, dropped: 0 }
    }
}

impl Engine for Serially {
    fn name(&self) -> String {
        "cellstep, 1 worker".to_string()
    }

    fn settings(&self) -> String {
        self.filled.settings()
    }

    fn step(&mut self) {
        self.report = self.filled.world.step(&mut self.executor);
        self.dropped += u64::from(self.report.dropped);
    }

    fn poses(&self) -> Vec<Pose> {
        self.filled.poses()
    }

    fn own_overlap(&self) -> f32 {
        self.filled.world.penetration_max()
    }

    fn own_gap(&self) -> Option<f32> {
        Some(self.filled.gap())
    }

    fn notes(&self) -> Vec<String> {
        let world = &self.filled.world;
        let r = &self.report;
        let bytes = world.snapshot_bytes() as f64 / f64::from(world.body_count().max(1));
        let mut notes = vec![
            format!(
                "pairs {}, contacts {}, joints {}, phases {}, blocks {}, barriers {}, dropped in all steps {}",
                r.pairs, r.contacts, r.joints, r.phases, r.blocks, r.barriers, self.dropped
            ),
            format!("state bytes / body {bytes:.1}"),
        ];
        let times = self.executor.times();
        let per_step = |time: std::time::Duration| time.as_secs_f64() * 1e3 / times.steps.max(1) as f64;
        let stage = |stage: &Stage| format!("{} {:.3}", stage.name(), per_step(times.stage(*stage).total));
        let stages: Vec<String> = Stage::ALL.iter().map(stage).collect();
        notes.push(format!("ms/step by stage: {}", stages.join(", ")));
        notes.push(format!("of these outside of tasks: {:.3}", per_step(times.sum().serial())));
        notes
    }

    fn checksum(&self) -> Option<u64> {
        Some(self.filled.world.checksum())
    }
}

/// Several workers.
pub struct Pooled {
    filled: Filled,
    pool: Pool,
}

impl Pooled {
    pub fn new(scene: &Scene, workers: usize) -> Self {
        Pooled { filled: Filled::new(scene), pool: Pool::new(workers).expect("the system has threads") }
    }
}

impl Engine for Pooled {
    fn name(&self) -> String {
        format!("cellstep, {} workers", self.pool.workers())
    }

    fn settings(&self) -> String {
        self.filled.settings()
    }

    fn step(&mut self) {
        self.filled.world.step(&mut self.pool);
    }

    fn poses(&self) -> Vec<Pose> {
        self.filled.poses()
    }

    fn own_overlap(&self) -> f32 {
        self.filled.world.penetration_max()
    }

    fn own_gap(&self) -> Option<f32> {
        Some(self.filled.gap())
    }

    fn checksum(&self) -> Option<u64> {
        Some(self.filled.world.checksum())
    }
}
