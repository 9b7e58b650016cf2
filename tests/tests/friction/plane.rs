//! A slab that slides and turns on a floor, against Coulomb's law of its corners in double precision.
//!
//! ```text
//! F_i = -mu l_i u_i / |u_i|     u_i = v + w x r_i      m v' = sum F_i      I w' = sum r_i x F_i
//! ```
//! The loads are linear in the plane and balance the weight and the torque of friction, which acts at the floor and
//! not at the height of the center. Those of three corners follow from that alone; those of four do for a slab
//! whose mass is in its middle, as far as it is low: else they depend on how the slab was put down.

use super::{MODELS, with};
use cellstep::math::{Rotation, Vec3};
use cellstep::{
    BodyDef, BodyHandle, Capacities, FrictionModel, Geometry, MassProperties, Position, Serial, Settings,
    ShapeDef,
};
use cellstep_tests::oracles::{GRAVITY, center, judge, norm, relative, spin, velocity};
use cellstep_tests::worlds::{OwnedWorld, add, ground, world_with};

const FRICTION: f32 = 0.4;
const SQUARE: [[f64; 2]; 4] = [[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]];
const TRIANGLE: [[f64; 2]; 3] = [[-0.5, -0.5], [0.5, -0.5], [0.0, 0.8]];
/// Moment of a square of 1 kg and 1 m about its axis.
const MOMENT: f64 = 1.0 / 6.0;

/// A slab's motion in the plane: its center of mass, velocity and spin.
#[derive(Clone, Debug)]
struct Slab {
    /// Corners from the center of mass, in the body's frame, at angle 0.
    corners: Vec<[f64; 2]>,
    /// Height of the center of mass.
    height: f64,
    place: [f64; 2],
    angle: f64,
    velocity: [f64; 2],
    spin: f64,
}

impl Slab {
    /// A square of 1 kg.
    fn square(velocity: [f64; 2], spin: f64) -> Self {
        Self::new(&SQUARE, [0.0; 2], (velocity, spin))
    }

    /// One of 1 kg whose center of mass is at a place.
    fn new(corners: &[[f64; 2]], off: [f64; 2], (velocity, spin): ([f64; 2], f64)) -> Self {
        let corners = corners.iter().map(|[x, y]| [x - off[0], y - off[1]]).collect();
        // Thicker than contacts are looked for where it is a hull.
        let height = if off == [0.0; 2] { 0.01 } else { 0.03 };
        Self { corners, height, place: off, angle: 0.0, velocity, spin }
    }

    /// Force and torque of friction.
    fn friction(&self) -> ([f64; 2], f64) {
        let (sine, cosine) = self.angle.sin_cos();
        let turn = |&[x, y]: &[f64; 2]| [cosine * x - sine * y, sine * x + cosine * y];
        let arms: Vec<[f64; 2]> = self.corners.iter().map(turn).collect();
        let way = |&[x, y]: &[f64; 2]| {
            let u = [self.velocity[0] - self.spin * y, self.velocity[1] + self.spin * x];
            let speed = u[0].hypot(u[1]).max(1.0e-12);
            [u[0] / speed, u[1] / speed]
        };
        let ways: Vec<[f64; 2]> = arms.iter().map(way).collect();
        let mut force = [0.0; 2];
        let mut loads = Vec::new();
        // Loads follow from the force and the force from the loads: a contraction as strong as the slab is low.
        for _ in 0..8 {
            loads = self.loads(&arms, force);
            force = [0, 1]
                .map(|k| -loads.iter().zip(&ways).map(|(l, u)| f64::from(FRICTION) * l * u[k]).sum::<f64>());
        }
        let torque = (0..arms.len())
            .map(|i| -f64::from(FRICTION) * loads[i] * (arms[i][0] * ways[i][1] - arms[i][1] * ways[i][0]))
            .sum();
        (force, torque)
    }

    /// `l = a + b x + c y` with the weight as sum and the torque of friction about the center as moments.
    fn loads(&self, arms: &[[f64; 2]], force: [f64; 2]) -> Vec<f64> {
        let sum = |of: fn(&[f64; 2]) -> f64| arms.iter().map(of).sum::<f64>();
        let (x, y) = (sum(|r| r[0]), sum(|r| r[1]));
        let (xx, yy, xy) = (sum(|r| r[0] * r[0]), sum(|r| r[1] * r[1]), sum(|r| r[0] * r[1]));
        let matrix = [[arms.len() as f64, x, y], [x, xx, xy], [y, xy, yy]];
        let right = [GRAVITY, -self.height * force[0], -self.height * force[1]];
        let [a, b, c] = solve(matrix, right);
        arms.iter().map(|[x, y]| (a + b * x + c * y).max(0.0)).collect()
    }

    /// Moves on by `time` in steps of 10 microseconds.
    fn run(&mut self, time: f64) {
        let h = 1.0e-5;
        for _ in 0..(time / h).round() as usize {
            let (force, torque) = self.friction();
            for ((velocity, place), force) in self.velocity.iter_mut().zip(&mut self.place).zip(force) {
                *velocity += h * force;
                *place += h * *velocity;
            }
            self.spin += h * torque / MOMENT;
            self.angle += h * self.spin;
        }
    }
}

/// Cramer's rule.
fn solve(m: [[f64; 3]; 3], right: [f64; 3]) -> [f64; 3] {
    let determinant = |m: [[f64; 3]; 3]| {
        m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0])
            + m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0])
    };
    let whole = determinant(m);
    core::array::from_fn(|k| {
        let mut other = m;
        (0..3).for_each(|i| other[i][k] = right[i]);
        determinant(other) / whole
    })
}

/// The engine's slab of the same motion.
fn slab(model: FrictionModel, like: &Slab) -> (OwnedWorld, BodyHandle) {
    let mut world = world_with(Capacities { hulls: 1, ..Capacities::for_bodies(2) });
    // What is as thin as this would be stopped on its way where it comes near the floor.
    world.set_settings(&Settings { continuous: false, ..with(model) }).expect("in range");
    ground(&mut world, FRICTION);
    let vertex = |&[p, q]: &[f64; 2], z| Vec3::new((p + like.place[0]) as f32, (q + like.place[1]) as f32, z);
    let vertices: Vec<Vec3> = like
        .corners
        .iter()
        .flat_map(|corner| [-like.height as f32, like.height as f32].map(|z| vertex(corner, z)))
        .collect();
    let geometry = if like.corners.len() == 4 {
        Geometry::Box { half_extents: Vec3::new(0.5, 0.5, like.height as f32) }
    } else {
        Geometry::Hull(world.add_hull(&vertices).expect("a prism"))
    };
    let [x, y] = like.place.map(|x| x as f32);
    let mass = MassProperties {
        mass: 1.0,
        center: Vec3::new(x, y, 0.0),
        inertia: Vec3::new(1.0 / 12.0, 1.0 / 12.0, MOMENT as f32),
        axes: Rotation::IDENTITY,
    };
    let def = BodyDef {
        position: Position::at(Vec3::Z * like.height as f32),
        mass: Some(mass),
        ..BodyDef::default()
    };
    let (body, _) = add(&mut world, &def, &ShapeDef { friction: FRICTION, ..ShapeDef::new(geometry) });
    // Those of the center of mass.
    let velocity = Vec3::new(like.velocity[0] as f32, like.velocity[1] as f32, 0.0);
    world.set_linear_velocity(body, velocity).expect("dynamic");
    world.set_angular_velocity(body, Vec3::Z * like.spin as f32).expect("dynamic");
    (world, body)
}

/// Place, velocity and spin of the engine's slab after a time.
fn state(model: FrictionModel, like: &Slab, steps: u32) -> ([f64; 2], [f64; 2], f64) {
    let (mut world, body) = slab(model, like);
    for _ in 0..steps {
        world.step(&mut Serial);
    }
    let (c, v) = (center(&world, body), velocity(&world, body));
    ([c[0], c[1]], [v[0], v[1]], spin(&world, body)[2])
}

#[test]
fn what_slides_and_turns_is_held_as_by_its_corners() {
    let cases = [
        ("slides", &SQUARE[..], [0.0, 0.0], [3.0, 0.0], 0.0),
        ("turns", &SQUARE, [0.0, 0.0], [0.0, 0.0], 12.0),
        ("slides and turns", &SQUARE, [0.0, 0.0], [2.0, 1.0], 8.0),
        ("turns fast", &SQUARE, [0.0, 0.0], [1.0, 0.0], 20.0),
        ("triangle, slides and turns", &TRIANGLE, [0.0, 0.1], [2.0, 0.0], 6.0),
        ("triangle, turns about its side", &TRIANGLE, [0.05, -0.2], [0.0, 0.0], 8.0),
        ("triangle, slides on a corner", &TRIANGLE, [0.0, 0.4], [0.0, 3.0], 1.0),
    ];
    let steps = 24;
    let mut by_patch = 0.0_f64;
    for (name, corners, off, v, w) in cases {
        let start = Slab::new(corners, off, (v, w));
        let mut exact = start.clone();
        exact.run(f64::from(steps) / 60.0);
        let scale = norm([v[0], v[1], 0.7 * w]);
        let errors = MODELS.map(|model| {
            let (c, u, s) = state(model, &start, steps);
            let place = (c[0] - exact.place[0]).hypot(c[1] - exact.place[1]);
            let speed = (u[0] - exact.velocity[0]).hypot(u[1] - exact.velocity[1]);
            println!(
                "{name}, {model:?}: {place:.1e} m, {speed:.1e} m/s, {:.1e} rad/s of {:.3}",
                s - exact.spin,
                exact.spin
            );
            (speed + 0.7 * (s - exact.spin).abs()) / scale
        });
        judge(&format!("{name}: speeds, as a share"), errors[1], [5.0e-3, 2.0e-2]);
        by_patch = by_patch.max(errors[0]);
    }
    assert!(by_patch > 0.1, "the models differ: {by_patch}");
}

/// `I = m / 6`, and all corners at the distance `r = sqrt(1/2)`: the spin falls by `6 mu g r`.
#[test]
fn a_spin_stops_when_it_should() {
    for model in MODELS {
        let start = Slab::square([0.0; 2], 10.0);
        let fall = 6.0 * f64::from(FRICTION) * GRAVITY * 0.5_f64.sqrt();
        let after = |steps: u32| state(model, &start, steps).2;
        let found = (after(6) - after(30)) / (24.0 / 60.0);
        judge(&format!("{model:?}: torque"), relative(found, fall), [5.0e-3, 1.0e-2]);
        let stops = 10.0 / fall;
        let steps = (60.0 * stops) as u32;
        assert!(after(steps - 1) > 0.1, "{model:?}: stops too early");
        assert!(after(steps + 3).abs() < 1.0e-4, "{model:?}: stops too late: {}", after(steps + 3));
    }
}

/// Greatest force, as a share of `mu m g`, that four corners of a square of 1 m bear at the middle of an edge and
/// along it: by the upper bound theorem the least over all centers of turning, which lie on the middle line.
fn bearable() -> f64 {
    let by = |d: f64| {
        let corners = 2.0 * (0.5 + d).hypot(0.5) + 2.0 * (d - 0.5).hypot(0.5);
        0.25 * corners / (0.5 + d)
    };
    (0..40_000).map(|i| by(1.0e-4 * f64::from(i))).fold(f64::INFINITY, f64::min)
}

/// How far a slab turns in a second under a push at the middle of an edge, radians: a share of `mu m g`.
fn turned(model: FrictionModel, share: f64) -> f64 {
    let (mut world, body) = slab(model, &Slab::square([0.0; 2], 0.0));
    for _ in 0..30 {
        world.step(&mut Serial);
    }
    let mut angle = 0.0;
    for _ in 0..60 {
        let push = Vec3::Y * (share * f64::from(FRICTION) * GRAVITY) as f32;
        world.apply_force_at(body, push, Position::at(Vec3::X * 0.5)).expect("dynamic");
        world.step(&mut Serial);
        angle += spin(&world, body)[2] / 60.0;
    }
    angle
}

#[test]
fn a_push_at_an_edge_is_borne_as_by_the_corners() {
    let most = bearable();
    assert!((0.755..0.765).contains(&most), "{most}");
    let [below, above] = [0.97, 1.03].map(|share| turned(FrictionModel::Points, share * most));
    let patch = turned(FrictionModel::Patch, 1.03 * most);
    println!("turns by {below:.1e} below what it bears, by {above:.3} above; a patch by {patch:.1e}");
    assert!(below.abs() < 1.0e-3, "{below}");
    assert!(above > 1.0e-2, "{above}");
    assert!(patch.abs() < 1.0e-3, "a patch does not tell force and torque from each other: {patch}");
}
