//! The scenes, as plain lists that every engine is filled from.
//!
//! A scene has shapes and contacts, or joints and no shapes.

use cellstep::Geometry;
use cellstep::math::Vec3;

/// Density of all moving bodies, kg/m3.
pub const DENSITY: f32 = 1000.0;
/// Coefficient of friction of all shapes: equal on both sides, so that every rule of mixing gives it.
pub const FRICTION: f32 = 0.6;
/// Length of a step, seconds.
pub const DT: f32 = 1.0 / 60.0;
/// Along z, m/s2.
pub const GRAVITY: f32 = -9.81;

/// Names for `--scene`.
pub const NAMES: [&str; 3] = ["pyramid", "pile", "net"];
/// Mass of a body without shape, kg.
pub const MASS: f32 = 1.0;
/// Its moment of inertia about every axis, kg m2: that of a solid ball of 0.4 m.
pub const INERTIA: f32 = 0.4 * MASS * 0.4 * 0.4;

/// A body of one shape in its middle, not turned.
pub struct Body {
    pub moves: bool,
    pub position: Vec3,
    /// A sphere, a box, or a capsule along z. `None` for no shape, but [`MASS`] and [`INERTIA`].
    pub geometry: Option<Geometry>,
}

/// A ball joint: it holds two points together, and leaves all turns free.
pub struct Joint {
    /// Places of the bodies in the scene.
    pub bodies: [usize; 2],
    /// The points, each in the frame of its body, metres.
    pub anchors: [Vec3; 2],
}

pub struct Scene {
    pub name: &'static str,
    /// Steps when nothing else is asked for.
    pub steps: u32,
    /// Steps before the first that is timed.
    pub warm_up: u32,
    pub bodies: Vec<Body>,
    pub joints: Vec<Joint>,
}

impl Scene {
    pub fn moving(&self) -> usize {
        self.bodies.iter().filter(|body| body.moves).count()
    }
}

/// The scene of a name out of [`NAMES`].
pub fn make(name: &'static str) -> Scene {
    match name {
        "pyramid" => pyramid(),
        "net" => net(),
        _ => pile(),
    }
}

fn fixed(position: Vec3, half_extents: Vec3) -> Body {
    Body { moves: false, position, geometry: Some(Geometry::Box { half_extents }) }
}

/// 5,050 unit boxes, 100 at the base, in the plane of x and z, just touching.
fn pyramid() -> Scene {
    const BASE: u32 = 100;
    let mut bodies = vec![fixed(Vec3::new(0.0, 0.0, -1.0), Vec3::new(200.0, 200.0, 1.0))];
    for row in 0..BASE {
        for i in 0..BASE - row {
            let x = i as f32 + 0.5 * row as f32 - 0.5 * BASE as f32;
            let position = Vec3::new(x, 0.0, 0.5 + row as f32);
            bodies.push(Body {
                moves: true,
                position,
                geometry: Some(Geometry::Box { half_extents: Vec3::splat(0.5) }),
            });
        }
    }
    Scene { name: "pyramid", steps: 200, warm_up: 0, bodies, joints: Vec::new() }
}

/// 4,096 bodies, sphere, box and capsule in turn, that fall from a jittered grid into a box with walls.
fn pile() -> Scene {
    const EDGE: u32 = 16;
    const SPACING: f32 = 1.3;
    const JITTER: f32 = 0.1;
    let inner = 0.5 * SPACING * EDGE as f32;
    let (wide, high) = (inner + 1.0, SPACING * EDGE as f32);
    let mut bodies = vec![
        fixed(Vec3::new(0.0, 0.0, -0.5), Vec3::new(wide, wide, 0.5)),
        fixed(Vec3::new(inner + 0.5, 0.0, 0.5 * high), Vec3::new(0.5, wide, 0.5 * high)),
        fixed(Vec3::new(-inner - 0.5, 0.0, 0.5 * high), Vec3::new(0.5, wide, 0.5 * high)),
        fixed(Vec3::new(0.0, inner + 0.5, 0.5 * high), Vec3::new(wide, 0.5, 0.5 * high)),
        fixed(Vec3::new(0.0, -inner - 0.5, 0.5 * high), Vec3::new(wide, 0.5, 0.5 * high)),
    ];
    let mut random = Random(1);
    for index in 0..EDGE.pow(3) {
        let cell = [index % EDGE, index / EDGE % EDGE, index / EDGE / EDGE];
        let [x, y, z] = cell.map(|c| SPACING * (c as f32 + 0.5) + JITTER * random.signed());
        let geometry = match index % 3 {
            0 => Geometry::Sphere { radius: 0.5 },
            1 => Geometry::Box { half_extents: Vec3::splat(0.45) },
            _ => Geometry::Capsule { half_height: 0.3, radius: 0.3 },
        };
        bodies.push(Body {
            moves: true,
            position: Vec3::new(x - inner, y - inner, z),
            geometry: Some(geometry),
        });
    }
    Scene { name: "pile", steps: 500, warm_up: 0, bodies, joints: Vec::new() }
}

/// 100 x 100 bodies of 1 kg, 1 m apart in a level plane, each held to its neighbours by ball joints half-way. Of
/// one edge every fourth body and the corners are fixed; from there the net swings down. (The grid of joints of
/// Box3D's own benchmarks hangs from the start, and its whole upper edge is fixed.)
fn net() -> Scene {
    const EDGE: usize = 100;
    let middle = 0.5 * (EDGE - 1) as f32;
    let (mut bodies, mut joints) = (Vec::new(), Vec::new());
    for row in 0..EDGE {
        for column in 0..EDGE {
            let fixed = column == 0 && (row % 4 == 0 || row + 1 == EDGE);
            let position = Vec3::new(column as f32 - middle, row as f32 - middle, 0.0);
            let body = bodies.len();
            bodies.push(Body { moves: !fixed, position, geometry: None });
            let mut hold = |other: usize, half: Vec3| {
                joints.push(Joint { bodies: [other, body], anchors: [half, -half] });
            };
            if row > 0 {
                hold(body - EDGE, Vec3::new(0.0, 0.5, 0.0));
            }
            if column > 0 {
                hold(body - 1, Vec3::new(0.5, 0.0, 0.0));
            }
        }
    }
    Scene { name: "net", steps: 200, warm_up: 100, bodies, joints }
}

/// A linear congruential generator: the same numbers in every run.
struct Random(u64);

impl Random {
    /// In -1..1.
    fn signed(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f32 / (1 << 23) as f32 - 1.0
    }
}
