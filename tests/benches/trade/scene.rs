//! What a scene is: a plain list of bodies and joints that every engine is filled from, and a probe that looks at
//! the bodies after each step and says how wrong they are.

use cellstep::math::{Pose, Rotation, Vec3};
use cellstep_tests::oracles::{self, Wide};

/// Earth's gravity along z, m/s2.
pub const GRAVITY: Vec3 = Vec3::new(0.0, 0.0, -9.81);
/// Length of a step unless the scene says otherwise, seconds.
pub const DT: f32 = 1.0 / 60.0;
/// What is beyond this is as wrong as what is not finite: an explosion.
pub const LOST: f64 = 1.0e6;

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shape {
    Sphere(f32),
    /// By half of its edges.
    Box(Vec3),
    /// Along z.
    Capsule {
        half_height: f32,
        radius: f32,
    },
    /// The world's hull.
    Hull,
}

/// Mass of a body, its center in the body's origin, its principal axes those of the body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Mass {
    /// Of its shape, by a density, kg/m3.
    Density(f32),
    /// kg and kg m2; such bodies have no shape.
    Given(f32, Vec3),
}

#[derive(Clone, Debug)]
pub struct Body {
    pub moves: bool,
    pub position: Wide,
    pub rotation: Rotation,
    pub velocity: Vec3,
    pub spin: Vec3,
    pub shape: Option<Shape>,
    pub mass: Mass,
    /// Equal for the two shapes of every contact, so that every rule of mixing gives it.
    pub friction: f32,
    pub restitution: f32,
}

impl Body {
    /// A body of a shape that moves, at rest and not turned: 1000 kg/m3, friction 0.6, no restitution.
    pub fn new(position: Wide, shape: Shape) -> Self {
        Self {
            moves: true,
            position,
            rotation: Rotation::IDENTITY,
            velocity: Vec3::ZERO,
            spin: Vec3::ZERO,
            shape: Some(shape),
            mass: Mass::Density(1000.0),
            friction: 0.6,
            restitution: 0.0,
        }
    }

    /// A body without shape.
    pub fn massive(position: Wide, mass: f32, inertia: Vec3) -> Self {
        Self { shape: None, mass: Mass::Given(mass, inertia), ..Self::new(position, Shape::Sphere(1.0)) }
    }

    /// A body without shape that stays where it is.
    pub fn anchor(position: Wide) -> Self {
        Self { moves: false, ..Self::massive(position, 1.0, Vec3::ONE) }
    }

    /// A box that stays where it is.
    pub fn fixed(position: Wide, half: Vec3) -> Self {
        Self { moves: false, ..Self::new(position, Shape::Box(half)) }
    }

    /// Mass, kg, and principal moments, kg m2; of bodies without hull.
    pub fn inertia(&self) -> (f64, Wide) {
        let (density, shape) = match (self.mass, self.shape) {
            (Mass::Given(mass, inertia), _) => return (f64::from(mass), oracles::wide(inertia)),
            (Mass::Density(density), shape) => (f64::from(density), shape.expect("a density has a shape")),
        };
        match shape {
            Shape::Box(half) => {
                let [x, y, z] = oracles::wide(half).map(|h| h * h);
                let [a, b, c] = oracles::wide(half);
                let mass = 8.0 * density * a * b * c;
                (mass, [y + z, x + z, x + y].map(|sum| mass * sum / 3.0))
            }
            Shape::Sphere(radius) => {
                let r = f64::from(radius);
                let mass = density * 4.0 / 3.0 * core::f64::consts::PI * r * r * r;
                (mass, [0.4 * mass * r * r; 3])
            }
            other => panic!("no probe asks for the inertia of a {other:?}"),
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum JointKind {
    Ball,
    /// B turns about the x axis of the frames.
    Hinge,
    /// B slides along the x axis of A's frame.
    Slider,
}

#[derive(Clone, Copy, Debug)]
pub struct Joint {
    pub kind: JointKind,
    pub bodies: [usize; 2],
    /// Frames of the joint on the bodies.
    pub frames: [Pose; 2],
}

impl Joint {
    /// How far the joint is open, metres.
    pub fn gap(&self, seen: &[Seen]) -> f64 {
        let end = |side: usize| {
            let body = &seen[self.bodies[side]];
            let arm = oracles::turned(body.rotation, oracles::wide(self.frames[side].position));
            oracles::plus(body.position, arm, 1.0)
        };
        let apart = oracles::minus(end(1), end(0));
        if self.kind != JointKind::Slider {
            return oracles::norm(apart);
        }
        let axis = oracles::wide(self.frames[0].rotation.rotate(Vec3::X));
        let axis = oracles::turned(seen[self.bodies[0]].rotation, axis);
        oracles::norm(oracles::plus(apart, axis, -oracles::dot(apart, axis)))
    }
}

/// What every engine is filled with. Sleep off, no damping.
#[derive(Clone, Debug)]
pub struct Setup {
    pub dt: f32,
    pub gravity: Vec3,
    pub bodies: Vec<Body>,
    pub joints: Vec<Joint>,
    /// Corners of [`Shape::Hull`], around its center of mass.
    pub hull: Vec<Vec3>,
}

impl Setup {
    pub fn new(bodies: Vec<Body>) -> Self {
        Self { dt: DT, gravity: GRAVITY, bodies, joints: Vec::new(), hull: Vec::new() }
    }

    pub fn moving(&self) -> usize {
        self.bodies.iter().filter(|body| body.moves).count()
    }

    /// Energy of motion and of height of some bodies, J.
    pub fn energy(&self, seen: &[Seen], bodies: impl Iterator<Item = usize>) -> f64 {
        let one = |index: usize| {
            let (body, seen) = (&self.bodies[index], &seen[index]);
            let ((mass, inertia), g) = (body.inertia(), oracles::wide(self.gravity));
            let spin = oracles::turned_back(seen.rotation, seen.spin);
            let turning: f64 = (0..3).map(|k| 0.5 * inertia[k] * spin[k] * spin[k]).sum();
            let motion = 0.5 * mass * oracles::dot(seen.velocity, seen.velocity);
            turning + motion - mass * oracles::dot(g, seen.position)
        };
        bodies.map(one).sum()
    }
}

/// A body after a step.
#[derive(Clone, Copy, Debug)]
pub struct Seen {
    pub position: Wide,
    pub rotation: Rotation,
    pub velocity: Wide,
    /// In the world, rad/s.
    pub spin: Wide,
}

impl Seen {
    /// As the body is put in.
    pub fn at_start(body: &Body) -> Self {
        Self {
            position: body.position,
            rotation: body.rotation,
            velocity: oracles::wide(body.velocity),
            spin: oracles::wide(body.spin),
        }
    }

    pub fn is_finite(&self) -> bool {
        let within = |v: &Wide| v.iter().all(|x| x.abs() < LOST * 100.0);
        within(&self.position) && within(&self.velocity) && within(&self.spin) && self.rotation.is_finite()
    }
}

/// One measure of error.
#[derive(Clone, Debug)]
pub struct Axis {
    pub name: &'static str,
    /// `1` for a share.
    pub unit: &'static str,
    /// Infinite when the run was lost.
    pub value: f64,
}

impl Axis {
    /// A measured error; what is not a number, or beyond [`LOST`], is infinite.
    pub fn new(name: &'static str, unit: &'static str, value: f64) -> Self {
        Self { name, unit, value: if value.abs() < LOST { value } else { f64::INFINITY } }
    }
}

/// Looks at a run.
pub trait Probe {
    /// Whether it wants to look after this step; the first is 1.
    fn wants(&self, _step: u32) -> bool {
        true
    }
    /// All bodies after a step, those that do not move too.
    fn see(&mut self, step: u32, seen: &[Seen]);
    /// The headline error first.
    fn errors(&self) -> Vec<Axis>;
}

/// Which settings of an engine can matter in a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Nothing touches and nothing is joined.
    Free,
    Jointed,
    Touching,
    Both,
}

impl Kind {
    pub fn has_joints(self) -> bool {
        matches!(self, Kind::Jointed | Kind::Both)
    }

    pub fn has_contacts(self) -> bool {
        matches!(self, Kind::Touching | Kind::Both)
    }
}

/// A scene of the bench.
pub struct Scene {
    pub name: &'static str,
    /// What the headline error is, in a few words.
    pub headline: &'static str,
    /// Error below which everything is alike: what is measured there is rounding.
    pub floor: f64,
    pub kind: Kind,
    /// Steps of the run that is measured for its error.
    pub steps: u32,
    /// Steps before the first that are timed.
    pub warm: u32,
    /// Steps of each of the turns that are timed.
    pub timed: u32,
    /// Configurations with more substeps are left out, since they would take too long.
    pub substeps_max: u32,
    pub setup: Setup,
    pub probe: fn(&Setup) -> Box<dyn Probe>,
}
