//! What a model is once everything is resolved: rigid bodies with their geoms, and what joins them.
//!
//! Units are those of the format (metres, kilograms, seconds, radians). All frames are those of the initial
//! configuration (`qpos0`): every joint is at its `ref`. Bodies are rigid: what has no joint is part of the
//! body around it. Body 0 is the world.

use super::math::{Placement, Turn, Vector};
use super::settings::Options;
use super::warning::Warning;

/// A model.
#[derive(Clone, Debug, Default)]
pub struct Model {
    /// The model's name, or empty.
    pub name: String,
    /// Time step, gravity and what is disabled.
    pub options: Options,
    /// Convex meshes that geoms refer to.
    pub meshes: Vec<Mesh>,
    /// Rigid bodies, an outer one before those within it; the first is the world.
    pub bodies: Vec<Body>,
    /// What joins a body to the one around it: one for each body that is [`BodyKind::Jointed`], in their order.
    pub joints: Vec<Joint>,
    /// Constraints between frames of two bodies.
    pub equalities: Vec<Equality>,
    /// Parts whose geoms do not collide.
    pub excludes: Vec<Exclude>,
    /// Two points within a distance of each other.
    pub ropes: Vec<Rope>,
    /// What drives joints.
    pub actuators: Vec<Actuator>,
    /// What the files say and is not here.
    pub warnings: Vec<Warning>,
}

/// The points of a convex mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct Mesh {
    /// Unique.
    pub name: String,
    /// At most 64, in the geom's frame, scaled.
    pub points: Vec<[f32; 3]>,
    /// Cubic metres, of the mesh as it was given.
    pub volume: f64,
    /// Mass properties at density 1.
    pub mass: Mass,
}

/// How a rigid body moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BodyKind {
    /// The world: it never moves.
    Fixed,
    /// Moved from outside (`mocap`).
    Mocap,
    /// Nothing holds it (`freejoint`).
    Free,
    /// Held by the parts of a [`Joint`].
    Jointed,
}

/// A rigid body.
#[derive(Clone, Debug)]
pub struct Body {
    /// Name of its outermost part, or empty.
    pub name: String,
    /// How it moves.
    pub kind: BodyKind,
    /// Its frame in the world.
    pub placement: Placement,
    /// The body around it; 0 for the world itself.
    pub parent: usize,
    /// What its parts weigh together; `None` for the world and for bodies without mass that nothing moves.
    pub mass: Option<Mass>,
    /// Share of gravity that is compensated (`gravcomp`), of its outermost part.
    pub gravity_compensation: f64,
    /// Its geoms, those that collide with nothing included.
    pub geoms: Vec<Geom>,
    /// Elements `<body>` that it consists of.
    pub parts: usize,
}

/// Mass and its distribution.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mass {
    /// Kilograms.
    pub mass: f64,
    /// Center of mass in the body's frame.
    pub center: Vector,
    /// Moments of inertia about the center along the principal axes, kg m2.
    pub inertia: Vector,
    /// How the principal axes are turned in the body's frame.
    pub axes: Turn,
}

/// A form, in the geom's frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Form {
    /// Everything below the plane z = 0.
    HalfSpace,
    /// Ball.
    Sphere {
        /// Metres.
        radius: f64,
    },
    /// All points within `radius` of a segment on the z axis.
    Capsule {
        /// Half the segment.
        half_height: f64,
        /// Metres.
        radius: f64,
    },
    /// Its axis is z.
    Cylinder {
        /// Half the height.
        half_height: f64,
        /// Metres.
        radius: f64,
    },
    /// Box.
    Box {
        /// Half of each edge.
        half_extents: Vector,
    },
    /// Ellipsoid.
    Ellipsoid {
        /// Half of each axis.
        half_axes: Vector,
    },
    /// The hull of the mesh with this index.
    Hull(usize),
}

/// A form on a body.
#[derive(Clone, Debug)]
pub struct Geom {
    /// Its name, or empty.
    pub name: String,
    /// The element `<body>` that it is in, in document order; 0 is the world. See [`Exclude`].
    pub part: usize,
    /// Its form.
    pub form: Form,
    /// Its frame in that of the rigid body.
    pub placement: Placement,
    /// Coefficients: sliding, and spinning and rolling in metres. MuJoCo takes the larger of two geoms'.
    pub friction: [f64; 3],
    /// Share of the approach speed that comes back, 0..=1, of a body that presses with all its mass: see
    /// [`crate::mjcf`].
    pub restitution: f64,
    /// Directions of friction of a contact, of two geoms the larger: 1 none, 3 sliding, 4 spinning too, 6
    /// rolling too.
    pub condim: i32,
    /// Bits of what it is. Two geoms collide when a bit of one's `contype` is in the other's `conaffinity`, in
    /// either direction.
    pub contype: u32,
    /// Bits of what it collides with.
    pub conaffinity: u32,
}

impl Geom {
    /// The contact bits' rule.
    pub fn meets(&self, other: &Self) -> bool {
        self.contype & other.conaffinity != 0 || other.contype & self.conaffinity != 0
    }
}

/// What joins a body to the one around it. Its parts move one after the other: the last is nearest to the body.
#[derive(Clone, Debug)]
pub struct Joint {
    /// The body that the first part is attached to.
    pub parent: usize,
    /// The body that is moved.
    pub child: usize,
    /// At least one.
    pub parts: Vec<JointPart>,
    /// Whether the two bodies collide: only with the world they do, unless the model says otherwise.
    pub collide: bool,
}

/// What a part of a joint lets free.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Motion {
    /// Turning about the axis, radians, right-handed.
    Hinge,
    /// Moving along the axis, metres.
    Slide,
    /// Turning about the anchor.
    Ball,
}

/// One motion. Its value is 0 in the initial configuration.
#[derive(Clone, Debug)]
pub struct JointPart {
    /// Its name, or empty.
    pub name: String,
    /// What moves.
    pub motion: Motion,
    /// The fixed point in the child's frame.
    pub anchor: Vector,
    /// Unit axis in the child's frame; z for a ball.
    pub axis: Vector,
    /// The anchor in the world.
    pub world_anchor: Vector,
    /// The axis in the world.
    pub world_axis: Vector,
    /// Least and greatest value; of a ball the greatest angle, as `[0, angle]`.
    pub range: Option<[f64; 2]>,
    /// Spring: N/m, or N m/rad.
    pub stiffness: f64,
    /// Value at which the spring rests; always 0 for a ball.
    pub spring_rest: f64,
    /// N s/m, or N m s/rad.
    pub damping: f64,
    /// Greatest force or torque of dry friction, N or N m.
    pub friction_loss: f64,
    /// Inertia of what turns with the joint, kg or kg m2.
    pub armature: f64,
    /// What MuJoCo's coordinate is in the initial configuration: add it to a value for MuJoCo's.
    pub reference: f64,
}

/// Frames of two bodies that are kept together.
#[derive(Clone, Debug)]
pub struct Equality {
    /// Its name, or empty.
    pub name: String,
    /// Whether the origins alone, or the axes too.
    pub weld: bool,
    /// First body and the frame in it.
    pub a: (usize, Placement),
    /// Second body and the frame in it; it need not be at the first's in the beginning.
    pub b: (usize, Placement),
    /// Whether it is in force from the beginning.
    pub active: bool,
}

/// Two elements `<body>` whose geoms do not collide.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Exclude {
    /// The rigid bodies.
    pub bodies: [usize; 2],
    /// The elements, as in [`Geom::part`].
    pub parts: [usize; 2],
}

/// A point of a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// The body.
    pub body: usize,
    /// In its frame.
    pub position: Vector,
}

/// A tendon straight from one site to another.
#[derive(Clone, Debug)]
pub struct Rope {
    /// Its name, or empty.
    pub name: String,
    /// First end.
    pub a: Point,
    /// Other end.
    pub b: Point,
    /// Least and greatest length, metres.
    pub range: Option<[f64; 2]>,
    /// Spring, N/m, outside of `rest`.
    pub stiffness: f64,
    /// N s/m.
    pub damping: f64,
    /// Lengths between which the spring rests.
    pub rest: [f64; 2],
    /// Greatest force of dry friction, N.
    pub friction_loss: f64,
}

/// How an actuator's force follows from its control.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Control {
    /// The control is the force.
    Motor,
    /// The control is a position: `kp (control - length) - kv velocity`.
    Position {
        /// N/m, or N m/rad.
        kp: f64,
        /// N s/m, or N m s/rad.
        kv: f64,
    },
    /// The control is a velocity: `kv (control - velocity)`.
    Velocity {
        /// N s/m, or N m s/rad.
        kv: f64,
    },
}

/// What an actuator moves. Its length is `gear` times that of what it moves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Transmission {
    /// A part of a joint that is not a ball, by indices into [`Model::joints`] and [`Joint::parts`]; the length is
    /// [`JointPart::reference`] and the part's value.
    Joint(usize, usize),
    /// A rod from a crank's point to a slider on the z axis of a frame.
    SliderCrank {
        /// Where the rod begins.
        crank: Point,
        /// The slider's body.
        body: usize,
        /// The slider's frame in it; it moves along z, and the length is how far it is.
        slider: Placement,
        /// Length of the rod, metres.
        rod: f64,
    },
}

/// What drives a joint. Controls are 0 in the beginning.
#[derive(Clone, Debug)]
pub struct Actuator {
    /// Its name, or empty.
    pub name: String,
    /// Force from control.
    pub control: Control,
    /// What moves.
    pub transmission: Transmission,
    /// Ratio of lengths: a force is multiplied by it.
    pub gear: f64,
    /// Range of controls.
    pub control_range: Option<[f64; 2]>,
    /// Range of forces.
    pub force_range: Option<[f64; 2]>,
}
