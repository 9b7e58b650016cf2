//! What is true of a world: conserved quantities in double precision, and marks to hold measurements against.

use crate::worlds::OwnedWorld;
use cellstep::BodyHandle;
use cellstep::math::{Rotation, Vec3};

/// A vector in double precision.
pub type Wide = [f64; 3];

/// Gravity of the default settings, m/s2.
pub const GRAVITY: f64 = 9.81;

/// Prints a measured error beside its marks, the excellent one first, and refuses one beyond the second (the gate).
///
/// # Panics
/// When the error is beyond the gate or not a number.
pub fn judge(case: &str, error: f64, [excellent, gate]: [f64; 2]) {
    let verdict = if error <= excellent { "excellent" } else { "acceptable" };
    assert!(error <= gate, "{case}: {error:.3e}, marks {excellent:.1e} / {gate:.1e}: beyond the gate");
    println!("{case}: {error:.3e}, marks {excellent:.1e} / {gate:.1e}: {verdict}");
}

/// `|found / expected - 1|`.
pub fn relative(found: f64, expected: f64) -> f64 {
    (found / expected - 1.0).abs()
}

/// A vector in double precision.
pub fn wide(v: Vec3) -> Wide {
    v.to_array().map(f64::from)
}

/// `a + b s`.
pub fn plus(a: Wide, b: Wide, s: f64) -> Wide {
    core::array::from_fn(|i| a[i] + b[i] * s)
}

/// `a - b`.
pub fn minus(a: Wide, b: Wide) -> Wide {
    plus(a, b, -1.0)
}

/// Scalar product.
pub fn dot(a: Wide, b: Wide) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Vector product.
pub fn cross(a: Wide, b: Wide) -> Wide {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Length.
pub fn norm(a: Wide) -> f64 {
    dot(a, a).sqrt()
}

/// `v` turned by `q`, whose length is taken out.
pub fn turned(q: Rotation, v: Wide) -> Wide {
    let (u, w) = ([q.x, q.y, q.z].map(f64::from), f64::from(q.w));
    let t = cross(u, v);
    let s = 2.0 / (dot(u, u) + w * w);
    plus(plus(v, t, s * w), cross(u, t), s)
}

/// `v` turned back by `q`.
pub fn turned_back(q: Rotation, v: Wide) -> Wide {
    turned(q.inverse(), v)
}

/// Place of the center of mass, metres.
pub fn center(world: &OwnedWorld, body: BodyHandle) -> Wide {
    world.center(body).expect("the body exists").to_f64()
}

/// Velocity of the center of mass, m/s.
pub fn velocity(world: &OwnedWorld, body: BodyHandle) -> Wide {
    wide(world.linear_velocity(body).expect("the body exists"))
}

/// Angular velocity in the world, rad/s.
pub fn spin(world: &OwnedWorld, body: BodyHandle) -> Wide {
    wide(world.angular_velocity(body).expect("the body exists"))
}

/// Angular velocity along the body's own axes, rad/s.
pub fn body_spin(world: &OwnedWorld, body: BodyHandle) -> Wide {
    turned_back(world.rotation(body).expect("the body exists"), spin(world, body))
}

/// Mass, kg.
pub fn mass(world: &OwnedWorld, body: BodyHandle) -> f64 {
    f64::from(world.mass_properties(body).expect("the body exists").mass)
}

/// Angular velocity and angular momentum along the principal axes.
fn principal(world: &OwnedWorld, body: BodyHandle) -> (Wide, Wide, Rotation) {
    let mass = world.mass_properties(body).expect("the body exists");
    let frame = world.rotation(body).expect("the body exists").after(mass.axes);
    let local = turned_back(frame, spin(world, body));
    let inertia = wide(mass.inertia);
    (local, core::array::from_fn(|i| inertia[i] * local[i]), frame)
}

/// Angular momentum about the body's own center, N m s in the world.
pub fn spin_momentum(world: &OwnedWorld, body: BodyHandle) -> Wide {
    let (_, momentum, frame) = principal(world, body);
    turned(frame, momentum)
}

/// Kinetic energy of the turning, J.
pub fn spin_energy(world: &OwnedWorld, body: BodyHandle) -> f64 {
    let (spin, momentum, _) = principal(world, body);
    0.5 * dot(spin, momentum)
}

/// Linear momentum, and angular momentum about the world's origin.
pub fn momenta(world: &OwnedWorld, body: BodyHandle) -> (Wide, Wide) {
    let p = velocity(world, body).map(|v| v * mass(world, body));
    (p, plus(cross(center(world, body), p), spin_momentum(world, body), 1.0))
}

/// The height above its start of the apex of the flight, metres: symplectic Euler conserves
/// `H = v^2/2 + g z - g h v/2` to rounding, so any moment of the flight tells it, without the bias of sampling.
pub fn apex(height: f64, speed: f64, substep: f64) -> f64 {
    height + (0.5 * speed * speed - 0.5 * GRAVITY * substep * speed) / GRAVITY
}

/// Where the cubic through four samples at 0, 1, 2, 3 is zero between the middle two.
pub fn crossing(samples: [f64; 4]) -> f64 {
    let [a, b, c, d] = samples;
    let value = |x: f64| {
        let (p, q, r, s) = (x, x - 1.0, x - 2.0, x - 3.0);
        -a * q * r * s / 6.0 + b * p * r * s / 2.0 - c * p * q * s / 2.0 + d * p * q * r / 6.0
    };
    let (mut low, mut high) = (1.0, 2.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if (value(middle) > 0.0) == (b > 0.0) { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}
