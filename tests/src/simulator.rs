//! A seeded player: gives a world commands of all kinds, most of them valid, some stale or refused.
//!
//! What it does follows from its seed and the outcomes of its commands. It lives around the origin, so that bodies
//! meet, pile up on the ground and on a mesh, and are removed and replaced the whole time.

mod joints;
mod materials;

use crate::executors::Random;
use crate::worlds::{self, OwnedWorld};
use cellstep::config::MANIFOLD_DRIFT;
use cellstep::math::{Pose, Rotation, Vec3};
use cellstep::replay::AssetSet;
use cellstep::{
    Applied, AxisLocks, BodyDef, BodyHandle, BodyKind, BodyKinds, Capacities, Command, ContactModel, Error,
    Filter, FrictionModel, Geometry, HullHandle, JointHandle, MassProperties, MaterialTraits, MeshHandle,
    Position, Settings, ShapeDef, ShapeEvents, ShapeHandle,
};

/// Handles that are remembered; older ones are forgotten at random.
const KNOWN_MAX: usize = 48;

/// A command and what came of it.
pub type Event = (Command, Result<Applied, Error>);

/// A world, and who gives it its commands.
struct Game<'a> {
    world: &'a mut OwnedWorld,
    apply: &'a mut dyn FnMut(&mut OwnedWorld, &Command) -> Result<Applied, Error>,
}

/// The player.
#[derive(Clone, Debug)]
pub struct Simulator {
    random: Random,
    /// Bodies that exist, and some that no longer do.
    bodies: Vec<BodyHandle>,
    /// Shapes that exist, and some that no longer do.
    shapes: Vec<ShapeHandle>,
    /// Joints that exist, and some that no longer do.
    joints: Vec<JointHandle>,
    /// Whether there is room for events: then there are sensors, and bodies that sleep.
    eventful: bool,
}

/// Room of a simulated world: few bodies, so that slots are reused and creation is refused at times.
pub const CAPACITIES: Capacities = Capacities {
    bodies: 24,
    shapes: 36,
    pairs: 160,
    contacts: 120,
    hulls: 2,
    meshes: 1,
    mesh_vertices: 25,
    joints: 16,
    mesh_triangles: 32,
    materials: 6,
    pair_rules: 5,
    ..Capacities::for_bodies(0)
};

/// The same with room for events and sensors.
pub const EVENTFUL: Capacities = Capacities { events: 300, sensor_visits: 200, ..CAPACITIES };

/// An empty simulated world of some room: the assets are registered, and there is the ground.
pub fn empty_world(capacities: Capacities) -> OwnedWorld {
    let mut world = worlds::world_with(capacities);
    register(&mut world);
    world
}

/// The assets of a simulated world.
fn register(world: &mut OwnedWorld) {
    assets(world, &mut AssetSet::new());
}

/// Registers two hulls and a mesh of 5 x 5 vertices in gentle waves, and remembers them.
pub fn assets(world: &mut OwnedWorld, set: &mut AssetSet) {
    let wedge = [[-0.5, -0.5, 0.0], [0.5, -0.5, 0.0], [0.5, 0.5, 0.0], [-0.5, 0.5, 0.0], [0.0, 0.0, 0.8]];
    set.add_hull(world, &wedge.map(Vec3::from)).expect("a pyramid is a hull");
    let prism: [Vec3; 12] = core::array::from_fn(|i| {
        let turn = (i / 2) as f32 * cellstep::math::PI / 3.0;
        let z = if i % 2 == 0 { -0.2 } else { 0.2 };
        Vec3::new(0.4 * cellstep::math::cos(turn), 0.4 * cellstep::math::sin(turn), z)
    });
    set.add_hull(world, &prism).expect("a prism is a hull");
    let vertices: [Vec3; 25] = core::array::from_fn(|i| {
        let (column, row) = (i % 5, i / 5);
        let height = [0.0, 0.3, 0.1, 0.4, 0.0][(column + 2 * row) % 5];
        Vec3::new(column as f32 * 1.5 - 3.0, row as f32 * 1.5 - 3.0, height)
    });
    let mut triangles = Vec::new();
    for row in 0..4 {
        for column in 0..4 {
            let corner = row * 5 + column;
            triangles.push([corner, corner + 1, corner + 6]);
            triangles.push([corner, corner + 6, corner + 5]);
        }
    }
    set.add_mesh(world, &vertices, &triangles).expect("waves are a mesh");
}

impl Simulator {
    /// A player and its world: the ground, a mesh, and half of the bodies that there is room for.
    pub fn new(seed: u64, capacities: Capacities) -> (Self, OwnedWorld) {
        let mut world = empty_world(capacities);
        worlds::ground(&mut world, 0.5);
        let terrain = world.create_body(&BodyDef::new(BodyKind::Static, Vec3::ZERO)).expect("room");
        let def = ShapeDef::new(Geometry::Mesh(MeshHandle(0)));
        let shape = world.create_shape(terrain, &def).expect("room");
        let mut simulator = Self {
            random: Random::new(seed),
            bodies: vec![terrain],
            shapes: vec![shape],
            joints: Vec::new(),
            eventful: capacities.events > 0,
        };
        if simulator.eventful {
            let settings = simulator.settings();
            world.set_settings(&Settings { dt: 1.0 / 60.0, ..settings }).expect("in range");
        }
        for _ in 0..capacities.bodies / 2 {
            let mut apply = |world: &mut OwnedWorld, command: &Command| world.apply(command);
            simulator.create(&mut Game { world: &mut world, apply: &mut apply }, &mut Vec::new());
        }
        (simulator, world)
    }

    /// Gives the world the commands before its next step, and tells which and what came of them.
    pub fn play(&mut self, world: &mut OwnedWorld) -> Vec<Event> {
        self.play_with(world, |world, command| world.apply(command))
    }

    /// [`Simulator::play`], with commands given to the world by somebody else.
    pub fn play_with(
        &mut self,
        world: &mut OwnedWorld,
        mut apply: impl FnMut(&mut OwnedWorld, &Command) -> Result<Applied, Error>,
    ) -> Vec<Event> {
        let mut game = Game { world, apply: &mut apply };
        let world = &mut game;
        let mut events = Vec::new();
        for _ in 0..self.random.below(4) {
            match self.random.below(11) {
                0 => self.create(world, &mut events),
                8..=10 => {
                    let command = self.of_joint(world.world);
                    self.give(command, world, &mut events);
                }
                1 => {
                    let command = self.removal();
                    self.give(command, world, &mut events);
                }
                2 | 3 => {
                    let command = self.placement();
                    self.give(command, world, &mut events);
                }
                4 => {
                    let command = self.of_shape();
                    self.give(command, world, &mut events);
                }
                5 => {
                    let command = self.property();
                    self.give(command, world, &mut events);
                }
                _ => {
                    let command = self.push();
                    self.give(command, world, &mut events);
                }
            }
        }
        if self.random.below(40) == 0 {
            let command = Command::SetSettings(self.settings());
            self.give(command, world, &mut events);
        }
        events
    }

    fn give(&mut self, command: Command, game: &mut Game<'_>, events: &mut Vec<Event>) {
        let outcome = (game.apply)(game.world, &command);
        match outcome {
            Ok(Applied::Body(body)) => remember(&mut self.random, &mut self.bodies, body),
            Ok(Applied::Shape(shape)) => remember(&mut self.random, &mut self.shapes, shape),
            Ok(Applied::Joint(joint)) => remember(&mut self.random, &mut self.joints, joint),
            _ => {}
        }
        events.push((command, outcome));
    }

    /// A body with one or two shapes.
    fn create(&mut self, world: &mut Game<'_>, events: &mut Vec<Event>) {
        let command = Command::CreateBody(self.body_def());
        self.give(command, world, events);
        let Some((_, Ok(Applied::Body(body)))) = events.last() else { return };
        let body = *body;
        for _ in 0..=self.random.below(4) / 3 {
            let command = Command::CreateShape(body, self.shape_def());
            self.give(command, world, events);
        }
    }

    fn removal(&mut self) -> Command {
        if self.random.below(3) == 0 {
            Command::RemoveShape(self.shape())
        } else {
            Command::RemoveBody(self.body())
        }
    }

    fn placement(&mut self) -> Command {
        let body = self.body();
        match self.random.below(5) {
            0 => Command::SetPose(body, self.position(), self.rotation()),
            1 => Command::SetLinearVelocity(body, self.vector(6.0)),
            2 => Command::SetAngularVelocity(body, self.vector(8.0)),
            3 => Command::SetKinematicTarget(body, self.position(), self.rotation()),
            _ => Command::SetKind(body, self.kind()),
        }
    }

    fn property(&mut self) -> Command {
        let body = self.body();
        match self.random.below(5) {
            0 => Command::SetDamping(body, self.random.between(0.0, 2.0), self.random.between(0.0, 2.0)),
            1 => Command::SetGravityScale(body, self.random.between(-0.5, 2.0)),
            2 => Command::SetLocks(body, AxisLocks(self.random.below(70) as u8)),
            3 => Command::SetBodyUser(body, self.random.bits()),
            _ => {
                let mass = self.mass();
                Command::SetMass(body, mass)
            }
        }
    }

    fn push(&mut self) -> Command {
        let body = self.body();
        match self.random.below(6) {
            0 => Command::ApplyForce(body, self.vector(2.0e4)),
            1 => Command::ApplyForceAt(body, self.vector(5.0e3), self.position()),
            2 => Command::ApplyTorque(body, self.vector(2.0e3)),
            3 => Command::ApplyImpulse(body, self.vector(2.0e3)),
            4 => Command::ApplyImpulseAt(body, self.vector(5.0e2), self.position()),
            _ => Command::ApplyAngularImpulse(body, self.vector(1.0e2)),
        }
    }

    fn of_shape(&mut self) -> Command {
        let shape = self.shape();
        if self.eventful && self.random.below(5) == 0 {
            return Command::SetShapeEvents(shape, self.shape_events());
        }
        match self.random.below(8) {
            5..=7 => self.of_material(),
            0 => Command::SetShapeUser(shape, self.random.bits()),
            1 => Command::SetGeometry(shape, self.geometry(), self.pose()),
            2 => Command::SetDensity(shape, self.random.between(0.0, 3000.0)),
            3 => Command::SetMaterial(shape, self.random.between(0.0, 1.5), self.random.between(0.0, 1.0)),
            _ => Command::SetFilter(shape, self.filter()),
        }
    }

    fn body(&mut self) -> BodyHandle {
        self.bodies[self.random.below(self.bodies.len() as u64) as usize]
    }

    fn shape(&mut self) -> ShapeHandle {
        self.shapes[self.random.below(self.shapes.len() as u64) as usize]
    }

    fn vector(&mut self, size: f32) -> Vec3 {
        Vec3::new(
            self.random.between(-size, size),
            self.random.between(-size, size),
            self.random.between(-size, size),
        )
    }

    /// A place above the ground, rarely in another sector.
    fn position(&mut self) -> Position {
        let far = if self.random.below(12) == 0 { 40.0 } else { 0.0 };
        Position::at(self.vector(2.5) + Vec3::new(far, 0.0, 3.0))
    }

    fn rotation(&mut self) -> Rotation {
        Rotation::from_rotation_vector(self.vector(3.0))
    }

    fn pose(&mut self) -> Pose {
        if self.random.below(3) > 0 {
            return Pose::IDENTITY;
        }
        Pose::new(self.vector(0.4), self.rotation())
    }

    fn kind(&mut self) -> BodyKind {
        match self.random.below(6) {
            0 => BodyKind::Static,
            1 => BodyKind::Kinematic,
            _ => BodyKind::Dynamic,
        }
    }

    fn geometry(&mut self) -> Geometry {
        let size = self.random.between(0.2, 0.6);
        match self.random.below(12) {
            0..=2 => Geometry::Sphere { radius: size },
            3..=4 => Geometry::Capsule { half_height: size, radius: 0.5 * size },
            5..=8 => Geometry::Box { half_extents: Vec3::new(size, 0.3, 0.9 * size) },
            // Index 2 is not registered.
            9..=10 => Geometry::Hull(HullHandle(self.random.below(3) as u32)),
            _ => Geometry::Mesh(MeshHandle(0)),
        }
    }

    fn filter(&mut self) -> Filter {
        match self.random.below(4) {
            0 => Filter { group: -1, ..Filter::default() },
            1 => Filter { category: 2, mask: 1, group: 0 },
            _ => Filter::default(),
        }
    }

    fn mass(&mut self) -> Option<MassProperties> {
        let mass = self.random.between(0.5, 400.0);
        (self.random.below(2) == 0).then(|| MassProperties {
            mass,
            center: self.vector(0.1),
            inertia: Vec3::new(0.2, 0.3, 0.4) * mass,
            axes: self.rotation(),
        })
    }

    fn body_def(&mut self) -> BodyDef {
        BodyDef {
            kind: self.kind(),
            position: self.position(),
            rotation: self.rotation(),
            linear_velocity: self.vector(2.0),
            angular_velocity: self.vector(2.0),
            linear_damping: self.random.between(0.0, 0.2),
            mass: self.mass(),
            user: self.random.bits(),
            ..BodyDef::default()
        }
    }

    /// Mostly everything.
    fn shape_events(&mut self) -> ShapeEvents {
        ShapeEvents([0, 1, 2, 3, 3, 3, 3, 4][self.random.below(8) as usize])
    }

    fn shape_def(&mut self) -> ShapeDef {
        let mut def = self.plain_shape_def();
        if self.eventful {
            def.events = self.shape_events();
            if self.random.below(3) == 0 {
                def.sensor = Some(BodyKinds(self.random.below(8) as u8));
            }
        }
        def
    }

    fn plain_shape_def(&mut self) -> ShapeDef {
        ShapeDef {
            pose: self.pose(),
            density: self.random.between(100.0, 2000.0),
            friction: self.random.between(0.0, 1.0),
            restitution: if self.random.below(3) == 0 { 0.6 } else { 0.0 },
            traits: if self.random.below(4) == 0 { self.traits() } else { MaterialTraits::default() },
            filter: self.filter(),
            user: self.random.bits(),
            ..ShapeDef::new(self.geometry())
        }
    }

    fn settings(&mut self) -> Settings {
        let settings = self.plain_settings();
        if !self.eventful {
            return settings;
        }
        Settings {
            tolerance: [0.0, 1.0e-3, 0.1][settings.substeps as usize % 3],
            sweeps_max: 4,
            sleep_time: self.random.between(0.05, 0.3),
            sleep_speed: self.random.between(0.02, 0.3),
            hit_speed: self.random.between(0.0, 3.0),
            moved_list: self.random.below(4) > 0,
            residual: settings.substeps.is_multiple_of(2),
            direct_joints: !settings.substeps.is_multiple_of(3),
            ..settings
        }
    }

    fn plain_settings(&mut self) -> Settings {
        Settings {
            dt: [1.0 / 60.0, 1.0 / 60.0, 1.0 / 120.0, 1.0 / 30.0, 0.0][self.random.below(5) as usize],
            gravity: Vec3::new(self.random.between(-1.0, 1.0), 0.0, -9.81),
            substeps: 1 + self.random.below(6) as u32,
            sweeps: 1 + self.random.below(2) as u32,
            relax_sweeps: self.random.below(3) as u32,
            inner_sweeps: 1 + self.random.below(2) as u32,
            contact_model: match self.random.below(8) {
                0 | 1 => ContactModel::Rigid,
                2 | 3 => ContactModel::Split,
                _ => ContactModel::Soft,
            },
            friction_model: match self.random.below(3) {
                0 => FrictionModel::Points,
                _ => FrictionModel::Patch,
            },
            manifold_drift: [MANIFOLD_DRIFT, MANIFOLD_DRIFT, 1.0e-3, 0.0][self.random.below(4) as usize],
            refine: 1 + self.random.below(4) as u32,
            refine_bodies: self.random.below(100) as u32,
            // Small, so that islands are refined and let go often.
            refine_sink: [0.0, 1.0e-4, 4.0e-3][self.random.below(3) as usize],
            ..Settings::default()
        }
    }
}

/// Remembers a handle, in the place of another when there are many.
fn remember<T>(random: &mut Random, known: &mut Vec<T>, handle: T) {
    if known.len() < KNOWN_MAX {
        known.push(handle);
    } else {
        known[random.below(KNOWN_MAX as u64) as usize] = handle;
    }
}

/// Gives a world the same commands again. Their outcomes must be the same.
///
/// # Panics
/// When a command has another outcome than it had.
pub fn replay(world: &mut OwnedWorld, events: &[Event]) {
    for (command, outcome) in events {
        assert_eq!(world.apply(command), *outcome, "{command:?}");
    }
}

/// A snapshot of the world as it is now.
pub fn snapshot(world: &OwnedWorld) -> Vec<u8> {
    let mut bytes = vec![0; world.snapshot_bytes()];
    world.save(&mut bytes).expect("the buffer is large enough");
    bytes
}
