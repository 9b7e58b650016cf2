//! Random commands of every kind, sense or nonsense: for what must hold of any of them.

pub use cellstep::Command;

use crate::executors::Random;
use cellstep::joint::AxisMotion;
use cellstep::math::{Pose, Rotation, Vec3};
use cellstep::{
    Axis, AxisLocks, BodyDef, BodyHandle, BodyKind, BodyKinds, CompoundHandle, ContactModel, Coupling, Drive,
    EventKinds, Filter, FrictionModel, Geometry, HeightFieldHandle, HullHandle, JointDef, JointHandle,
    MassProperties, MaterialTraits, MeshHandle, Mix, PairMaterial, Position, Settings, ShapeDef, ShapeEvents,
    ShapeHandle, Spring,
};

/// How many kinds of commands [`any`] makes: all of them.
pub const KINDS: u64 = 39;

/// Some command of a kind, `0..KINDS`. Its numbers are mostly small, and any bits at times.
pub fn any(random: &mut Random, kind: u64) -> Command {
    Any(random).command(kind)
}

struct Any<'a>(&'a mut Random);

impl Any<'_> {
    fn command(&mut self, kind: u64) -> Command {
        let (body, shape, joint) = (self.body(), self.shape(), self.joint());
        match kind {
            0 => Command::SetSettings(self.settings()),
            1 => Command::CreateBody(self.body_def()),
            2 => Command::RemoveBody(body),
            3 => Command::SetPose(body, self.position(), self.rotation()),
            4 => Command::SetLinearVelocity(body, self.vector()),
            5 => Command::SetAngularVelocity(body, self.vector()),
            6 => Command::SetKinematicTarget(body, self.position(), self.rotation()),
            7 => Command::SetKind(body, self.kind()),
            8 => Command::SetMass(body, self.mass()),
            9 => Command::SetDamping(body, self.number(), self.number()),
            10 => Command::SetGravityScale(body, self.number()),
            11 => Command::SetLocks(body, AxisLocks(self.bits() as u8)),
            12 => Command::SetBullet(body, self.flag()),
            13 => Command::SetBodyUser(body, self.bits()),
            14 => Command::Wake(body),
            15 => Command::SetCanSleep(body, self.flag()),
            16 => Command::ApplyForce(body, self.vector()),
            17 => Command::ApplyForceAt(body, self.vector(), self.position()),
            18 => Command::ApplyTorque(body, self.vector()),
            19 => Command::ApplyImpulse(body, self.vector()),
            20 => Command::ApplyImpulseAt(body, self.vector(), self.position()),
            21 => Command::ApplyAngularImpulse(body, self.vector()),
            22 => Command::CreateShape(body, self.shape_def()),
            23 => Command::RemoveShape(shape),
            24 => Command::SetShapeUser(shape, self.bits()),
            25 => Command::SetGeometry(shape, self.geometry(), self.pose()),
            26 => Command::SetDensity(shape, self.number()),
            27 => Command::SetFilter(shape, self.filter()),
            28 => Command::SetMaterial(shape, self.number(), self.number()),
            29 => Command::SetMaterialTraits(shape, self.traits()),
            30 => Command::SetShapeEvents(shape, ShapeEvents(self.bits() as u8)),
            31 => Command::SetPairMaterial(shape, self.shape(), self.pair_material()),
            32 => Command::IgnoreUntilSeparated(body, self.body()),
            33 => Command::StopIgnoring(body, self.body()),
            34 => Command::CreateJoint(self.joint_def()),
            35 => Command::RemoveJoint(joint),
            36 => Command::SetJoint(joint, self.joint_def()),
            37 => Command::SetJointAxis(joint, self.0.below(7) as u32, self.axis()),
            38 => Command::SetJointUser(joint, self.bits()),
            _ => panic!("there are {KINDS} kinds"),
        }
    }

    fn bits(&mut self) -> u64 {
        self.0.bits()
    }

    fn flag(&mut self) -> bool {
        self.0.below(2) == 0
    }

    fn some<T>(&mut self, value: impl FnOnce(&mut Self) -> T) -> Option<T> {
        if self.flag() { Some(value(self)) } else { None }
    }

    /// Mostly something that a world takes; at times any bits, those that are no number included.
    fn number(&mut self) -> f32 {
        match self.0.below(12) {
            0 => f32::from_bits(self.bits() as u32),
            1 => [0.0, -0.0, f32::NAN, -f32::NAN, f32::INFINITY, f32::MIN_POSITIVE][self.0.below(6) as usize],
            _ => self.0.between(0.0, 1.0),
        }
    }

    fn vector(&mut self) -> Vec3 {
        Vec3::new(self.number(), self.number(), self.number())
    }

    /// Few slots, so that commands meet what exists.
    fn slot(&mut self) -> (u32, u32) {
        (self.0.below(12) as u32, 1 + self.0.below(2) as u32)
    }

    fn body(&mut self) -> BodyHandle {
        let (index, generation) = self.slot();
        BodyHandle { index, generation }
    }

    fn shape(&mut self) -> ShapeHandle {
        let (index, generation) = self.slot();
        ShapeHandle { index, generation }
    }

    fn joint(&mut self) -> JointHandle {
        let (index, generation) = self.slot();
        JointHandle { index, generation }
    }

    fn position(&mut self) -> Position {
        let sector = [0; 3].map(|_: i32| self.0.below(3) as i32 - 1);
        Position { sector, offset: self.vector() }
    }

    fn rotation(&mut self) -> Rotation {
        if self.0.below(8) == 0 {
            return Rotation { x: self.number(), y: self.number(), z: self.number(), w: self.number() };
        }
        Rotation::from_rotation_vector(Vec3::new(self.0.between(-3.0, 3.0), self.0.between(-3.0, 3.0), 0.5))
    }

    fn pose(&mut self) -> Pose {
        Pose::new(self.vector(), self.rotation())
    }

    fn kind(&mut self) -> BodyKind {
        [BodyKind::Static, BodyKind::Kinematic, BodyKind::Dynamic][self.0.below(3) as usize]
    }

    fn mass(&mut self) -> Option<MassProperties> {
        self.some(|any| MassProperties {
            mass: any.number(),
            center: any.vector(),
            inertia: any.vector(),
            axes: any.rotation(),
        })
    }

    fn filter(&mut self) -> Filter {
        Filter { category: self.bits() as u32, mask: self.bits() as u32, group: self.0.below(3) as i32 - 1 }
    }

    fn mix(&mut self) -> Mix {
        let all = [Mix::Unset, Mix::GeometricMean, Mix::Mean, Mix::Min, Mix::Multiply, Mix::Max];
        all[self.0.below(6) as usize]
    }

    fn traits(&mut self) -> MaterialTraits {
        MaterialTraits {
            friction_mix: self.mix(),
            restitution_mix: self.mix(),
            rolling: self.number(),
            spinning: self.number(),
            surface_velocity: self.vector(),
            one_way: self.some(Self::vector),
        }
    }

    fn pair_material(&mut self) -> PairMaterial {
        PairMaterial { friction: self.some(Self::number), restitution: self.some(Self::number) }
    }

    fn body_def(&mut self) -> BodyDef {
        BodyDef {
            kind: self.kind(),
            position: self.position(),
            rotation: self.rotation(),
            linear_velocity: self.vector(),
            angular_velocity: self.vector(),
            linear_damping: self.number(),
            angular_damping: self.number(),
            gravity_scale: self.number(),
            locks: AxisLocks(self.0.below(70) as u8),
            mass: self.mass(),
            can_sleep: self.flag(),
            bullet: self.flag(),
            user: self.bits(),
        }
    }

    fn geometry(&mut self) -> Geometry {
        let index = self.0.below(3) as u32;
        let (radius, half_height) = (self.number(), self.number());
        match self.0.below(11) {
            0 => Geometry::Sphere { radius },
            1 => Geometry::Capsule { half_height, radius },
            2 => Geometry::Box { half_extents: self.vector() },
            3 => Geometry::Hull(HullHandle(index)),
            4 => Geometry::HalfSpace,
            5 => Geometry::Mesh(MeshHandle(index)),
            6 => Geometry::Cylinder { half_height, radius },
            7 => Geometry::Cone { half_height, radius },
            8 => Geometry::RoundedHull { hull: HullHandle(index), radius },
            9 => Geometry::HeightField(HeightFieldHandle(index)),
            _ => Geometry::Compound(CompoundHandle(index)),
        }
    }

    fn shape_def(&mut self) -> ShapeDef {
        ShapeDef {
            geometry: self.geometry(),
            pose: self.pose(),
            density: self.number(),
            friction: self.number(),
            restitution: self.number(),
            traits: self.traits(),
            filter: self.filter(),
            sensor: self.some(|any| BodyKinds(any.bits() as u8)),
            events: ShapeEvents(self.0.below(5) as u8),
            user: self.bits(),
        }
    }

    fn spring(&mut self) -> Spring {
        let (a, b) = (self.number(), self.number());
        if self.flag() {
            Spring::Frequency { hertz: a, damping_ratio: b }
        } else {
            Spring::Stiffness { stiffness: a, damping: b }
        }
    }

    fn axis(&mut self) -> Axis {
        let motion = match self.0.below(3) {
            0 => AxisMotion::Free,
            1 => AxisMotion::Locked,
            _ => AxisMotion::Limited { lower: -self.number(), upper: self.number() },
        };
        let drive = self.some(|any| Drive {
            target: any.number(),
            velocity: any.number(),
            spring: any.some(Self::spring),
            max_force: any.number(),
        });
        Axis { motion, limit_spring: self.some(Self::spring), drive, friction: self.number() }
    }

    fn joint_def(&mut self) -> JointDef {
        let ratio = self.number();
        let coupling = match self.0.below(4) {
            0 => Coupling::Gear { ratio },
            1 => Coupling::Rack { ratio },
            2 => Coupling::Distance,
            _ => Coupling::Frames,
        };
        JointDef {
            bodies: [self.body(), self.body()],
            frames: [self.pose(), self.pose()],
            coupling,
            axes: [0; 6].map(|_| self.axis()),
            cone: self.some(Self::number),
            spring: self.some(Self::spring),
            break_force: self.number(),
            break_torque: self.number(),
            bodies_collide: self.flag(),
            user: self.bits(),
        }
    }

    fn settings(&mut self) -> Settings {
        let models = [ContactModel::Soft, ContactModel::Rigid, ContactModel::Split];
        let model = models[self.0.below(3) as usize];
        Settings {
            dt: self.0.between(0.0, 0.02),
            gravity: self.vector(),
            substeps: 1 + self.0.below(4) as u32,
            sweeps: 1 + self.0.below(2) as u32,
            tolerance: self.number(),
            sweeps_max: 1 + self.0.below(8) as u32,
            relax_sweeps: self.0.below(2) as u32,
            inner_sweeps: 1 + self.0.below(2) as u32,
            direct_joints: self.flag(),
            contact_model: model,
            friction_model: if self.flag() { FrictionModel::Patch } else { FrictionModel::Points },
            manifold_drift: self.number(),
            contact_frequency: self.number(),
            contact_damping_ratio: self.number(),
            push_speed: self.number(),
            refine: self.0.below(9) as u32,
            refine_bodies: self.0.below(200) as u32,
            refine_sink: self.number(),
            restitution_threshold: self.number(),
            block_links: 8 + self.0.below(64) as u32,
            sleep_time: self.number(),
            sleep_speed: self.number(),
            continuous: self.flag(),
            events: EventKinds(self.0.below(70) as u32),
            hit_speed: self.number(),
            moved_list: self.flag(),
            residual: self.flag(),
        }
    }
}
