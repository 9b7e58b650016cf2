//! Rows from a world.

use super::{FIXED, Problem, Row, Six};
use crate::oracles::{Wide, cross, dot, minus, norm, plus, turned, wide};
use crate::worlds::OwnedWorld;
use cellstep::cells::{IMMOVABLE, Link};
use cellstep::config::{CONTACT_COUPLING, RIGID_PUSH, STATIC_STIFFNESS};
use cellstep::math::any_perpendicular;
use cellstep::{BodyHandle, BodyKind, Contact, ContactModel, Settings, WorldManifold};

/// What rows need of a body.
struct Side {
    /// Index among the dynamic bodies, or [`FIXED`].
    index: usize,
    center: Wide,
    inverse_mass: f64,
    /// World axes of the principal frame, and one over the moments about them.
    axes: [Wide; 3],
    inverse_inertia: Wide,
    /// Velocity of a body that does not answer; zero for a dynamic one.
    linear: Wide,
    angular: Wide,
}

impl Side {
    fn new(world: &OwnedWorld, body: BodyHandle, index: usize) -> Self {
        let lives = "the body exists";
        let mass = world.mass_properties(body).expect(lives);
        let frame = world.rotation(body).expect(lives).after(mass.axes);
        let unit = |axis| turned(frame, core::array::from_fn(|i| f64::from(u8::from(i == axis))));
        let fixed = index == FIXED;
        let inverse = |x: f32| if fixed { 0.0 } else { 1.0 / f64::from(x) };
        let moves = fixed && world.kind(body) == Ok(BodyKind::Kinematic);
        let own = |v: Wide| if moves { v } else { [0.0; 3] };
        Self {
            index,
            center: world.center(body).expect(lives).to_f64(),
            inverse_mass: inverse(mass.mass),
            axes: [unit(0), unit(1), unit(2)],
            inverse_inertia: mass.inertia.to_array().map(inverse),
            linear: own(wide(world.linear_velocity(body).expect(lives))),
            angular: own(wide(world.angular_velocity(body).expect(lives))),
        }
    }

    /// `I^-1 v`.
    fn turn(&self, v: Wide) -> Wide {
        (0..3)
            .fold([0.0; 3], |sum, i| plus(sum, self.axes[i], self.inverse_inertia[i] * dot(self.axes[i], v)))
    }

    /// `M^-1` times a row's jacobian.
    fn answer(&self, j: &Six) -> Six {
        six([j[0], j[1], j[2]].map(|x| x * self.inverse_mass), self.turn([j[3], j[4], j[5]]))
    }

    /// Velocity of its surface at a point.
    fn surface(&self, point: Wide) -> Wide {
        plus(self.linear, cross(self.angular, minus(point, self.center)), 1.0)
    }
}

fn six(v: Wide, w: Wide) -> Six {
    [v[0], v[1], v[2], w[0], w[1], w[2]]
}

/// The two sides of a link, A dynamic, and what makes its rows.
struct Maker<'a> {
    a: &'a Side,
    b: &'a Side,
    rows: &'a mut Vec<Row>,
}

impl Maker<'_> {
    /// A row along `d` at a point: `d . (v_b - v_a)`.
    fn along(&mut self, d: Wide, point: Wide, bounds: Bounds) {
        let opposite = d.map(|x| -x);
        let turn = |side: &Side, d: Wide| cross(minus(point, side.center), d);
        let jacobian = [six(opposite, turn(self.a, opposite)), six(d, turn(self.b, d))];
        let surface = dot(d, self.b.surface(point));
        self.push(jacobian, Bounds { bias: bounds.bias + surface, ..bounds });
    }

    /// A row about `d`: `d . (w_b - w_a)`.
    fn about(&mut self, d: Wide, bounds: Bounds) {
        let jacobian = [six([0.0; 3], d.map(|x| -x)), six([0.0; 3], d)];
        self.push(jacobian, Bounds { bias: dot(d, self.b.angular), ..bounds });
    }

    fn push(&mut self, jacobian: [Six; 2], bounds: Bounds) {
        let answer = [self.a.answer(&jacobian[0]), self.b.answer(&jacobian[1])];
        let yields = super::dot(&jacobian[0], &answer[0]) + super::dot(&jacobian[1], &answer[1]);
        let (a, b) = (self.a.index, self.b.index);
        let Bounds { bias, low, high, give } = bounds;
        let (soft, diagonal) = (give * yields, (1.0 + give) * yields);
        self.rows.push(Row { a, b, jacobian, answer, soft, diagonal, bias, low, high });
    }
}

/// What a row has beside its jacobians.
#[derive(Clone, Copy)]
struct Bounds {
    bias: f64,
    low: f64,
    high: f64,
    /// Softness as a share of what the bodies yield.
    give: f64,
}

impl Bounds {
    fn friction(bound: f64) -> Self {
        Self { bias: 0.0, low: -bound, high: bound, give: 0.0 }
    }
}

/// Numbers of the substep.
struct Substep {
    /// Seconds.
    h: f64,
    push_speed: f64,
    /// Contacts between dynamic bodies, and with others.
    correction: [Correction; 2],
}

/// How overlap is removed: a share of it per second, and what the contact gives.
#[derive(Clone, Copy)]
struct Correction {
    rate: f64,
    give: f64,
}

impl Correction {
    /// The implicit spring of frequency f and damping ratio z: with `s = 2 pi f`, `a = 2 z + h s`, `c = h s a` it
    /// takes back `s / a` of the overlap per second and gives `1 / c` of what the bodies yield.
    fn new(settings: &Settings, h: f64, factor: f64) -> Self {
        if settings.contact_model == ContactModel::Rigid {
            return Self { rate: f64::from(RIGID_PUSH) / h, give: 0.0 };
        }
        let own = f64::from(settings.contact_frequency);
        let frequency = if own > 0.0 { own } else { f64::from(CONTACT_COUPLING) / h };
        let s = core::f64::consts::TAU * frequency * factor;
        let a = 2.0 * f64::from(settings.contact_damping_ratio) + h * s;
        Self { rate: s / a, give: 1.0 / (h * s * a) }
    }
}

impl Substep {
    fn new(settings: &Settings) -> Self {
        let h = f64::from(settings.dt) / f64::from(settings.substeps);
        let correction =
            [1.0, f64::from(STATIC_STIFFNESS)].map(|factor| Correction::new(settings, h, factor));
        Self { h, push_speed: f64::from(settings.push_speed), correction }
    }

    fn normal(&self, separation: f32, fixed: bool) -> Bounds {
        let (s, high) = (f64::from(separation), f64::INFINITY);
        if s > 0.0 {
            return Bounds { bias: s / self.h, low: 0.0, high, give: 0.0 };
        }
        let Correction { rate, give } = self.correction[usize::from(fixed)];
        Bounds { bias: (s * rate).max(-self.push_speed), low: 0.0, high, give }
    }
}

impl Problem {
    /// The rows of the next substep of a world, between the contacts of its last step. Contacts that have come
    /// apart since have no rows.
    pub fn new(world: &OwnedWorld) -> Self {
        let settings = world.settings();
        let substep = Substep::new(&settings);
        let (index_of, velocities) = dynamic_bodies(world, wide(settings.gravity).map(|g| g * substep.h));
        let side = |body: BodyHandle| Side::new(world, body, index_of[body.index as usize]);
        let mut problem = Self { velocities, rows: Vec::new(), links: Vec::new(), first_rows: vec![0] };
        for contact in world.contacts() {
            let [a, b] = contact.bodies.map(side);
            world.manifolds(contact.shapes[0], contact.shapes[1], |manifold| {
                if manifold.child == contact.child {
                    let friction = contact
                        .shapes
                        .map(|shape| f64::from(world.shape(shape).expect("it exists").friction));
                    let normal = wide(manifold.normal);
                    // The normal goes from A to B, and A is dynamic.
                    let (a, b, n) =
                        if a.index == FIXED { (&b, &a, normal.map(|x| -x)) } else { (&a, &b, normal) };
                    let mut maker = Maker { a, b, rows: &mut problem.rows };
                    let bound = (friction[0] * friction[1]).sqrt() * f64::from(contact.normal_impulse());
                    write(&mut maker, n, manifold, (bound, &substep));
                }
            });
            problem.links.push(link(contact.points, [a.index, b.index]));
            problem.first_rows.push(problem.rows.len());
        }
        problem
    }
}

/// A contact as the orderings see it.
fn link(points: u32, [a, b]: [usize; 2]) -> Link {
    let kind = 4 - points;
    match (a, b) {
        (FIXED, b) => Link { a: b as u32, b: IMMOVABLE, kind },
        (a, FIXED) => Link { a: a as u32, b: IMMOVABLE, kind },
        (a, b) => Link { a: a as u32, b: b as u32, kind },
    }
}

/// For each slot the index of its dynamic body, or [`FIXED`]; and the velocities of those after a push of gravity.
fn dynamic_bodies(world: &OwnedWorld, push: Wide) -> (Vec<usize>, Vec<Six>) {
    let (mut index_of, mut velocities) = (Vec::new(), Vec::new());
    for body in world.bodies() {
        index_of.resize(body.index as usize + 1, FIXED);
        if world.kind(body) == Ok(BodyKind::Dynamic) {
            index_of[body.index as usize] = velocities.len();
            let linear = plus(crate::oracles::velocity(world, body), push, 1.0);
            velocities.push(six(linear, crate::oracles::spin(world, body)));
        }
    }
    (index_of, velocities)
}

/// The links of a world's last step, in the order in which its scheduler saw them, and the number of bodies they
/// name.
pub fn links(world: &OwnedWorld) -> (u32, Vec<Link>) {
    let (index_of, velocities) = dynamic_bodies(world, [0.0; 3]);
    let of =
        |contact: Contact| link(contact.points, contact.bodies.map(|body| index_of[body.index as usize]));
    (velocities.len() as u32, world.contacts().map(of).collect())
}

/// Writes the rows of a manifold: friction bounded by `bound`, then normals.
fn write(maker: &mut Maker<'_>, n: Wide, manifold: &WorldManifold, (bound, substep): (f64, &Substep)) {
    let points: Vec<Wide> = manifold.points.iter().map(|point| point.position.to_f64()).collect();
    let count = points.len() as f64;
    let middle = points.iter().fold([0.0; 3], |sum, &point| plus(sum, point, 1.0 / count));
    let radius = points.iter().map(|&point| norm(minus(point, middle))).sum::<f64>() / count;
    let first = wide(any_perpendicular(manifold.normal));
    maker.along(first, middle, Bounds::friction(bound));
    maker.along(cross(n, first), middle, Bounds::friction(bound));
    maker.about(n, Bounds::friction(bound * radius));
    let fixed = maker.b.index == FIXED;
    for (point, &place) in manifold.points.iter().zip(&points) {
        maker.along(n, place, substep.normal(point.separation, fixed));
    }
}
