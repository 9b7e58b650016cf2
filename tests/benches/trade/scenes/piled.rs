//! Many bodies on each other: SimBenchmark's balls, and a pile of all shapes.

use super::{Rms, mean, most};
use crate::own::Filled;
use crate::scene::{Axis, Body, GRAVITY, Kind, Probe, Scene, Seen, Setup, Shape};
use cellstep::Settings;
use cellstep::math::{Pose, Vec3};
use cellstep_tests::executors::Random;
use cellstep_tests::oracles;
use cellstep_tests::overlap::{Ruled, Ruler};

/// Balls along an edge of the cube, and their radius, metres.
const EDGE: usize = 6;
const RADIUS: f64 = 0.1;

/// SimBenchmark's "666": 216 balls of 10 kg in a cube, 0.21 m apart, shifted by up to a millimetre, dropped on a
/// plane without friction or restitution; 10 s in steps of 10 ms, as there.
pub fn balls() -> Scene {
    let mut random = Random::new(666);
    let frictionless = |body: Body| Body { friction: 0.0, ..body };
    let mut bodies = vec![frictionless(Body::fixed([0.0, 0.0, -1.0], Vec3::new(300.0, 300.0, 1.0)))];
    let density = 10.0 / (4.0 / 3.0 * core::f64::consts::PI * RADIUS.powi(3));
    for index in 0..EDGE.pow(3) {
        let cell = [index % EDGE, index / EDGE % EDGE, index / EDGE / EDGE];
        let mut place = cell.map(|c| 0.21 * c as f64 + f64::from(random.between(0.0, 1.0e-3)));
        place[2] += RADIUS;
        let mass = crate::scene::Mass::Density(density as f32);
        bodies.push(frictionless(Body { mass, ..Body::new(place, Shape::Sphere(RADIUS as f32)) }));
    }
    Scene {
        name: "balls",
        headline: "sum of the squares of all overlaps, m2, mean over 10 s in steps of 10 ms",
        floor: 1.0e-9,
        kind: Kind::Touching,
        steps: 1000,
        warm: 0,
        timed: 20,
        substeps_max: 64,
        setup: Setup { dt: 0.01, ..Setup::new(bodies) },
        probe: |_| Box::new(Balls { squares: Vec::new(), deepest: 0.0, lost: 0.0 }),
    }
}

struct Balls {
    /// After each step.
    squares: Vec<f64>,
    deepest: f64,
    /// Balls below the plane at the end.
    lost: f64,
}

impl Probe for Balls {
    fn see(&mut self, _step: u32, seen: &[Seen]) {
        let mut places: Vec<[f64; 3]> = seen[1..].iter().map(|ball| ball.position).collect();
        places.sort_by(|a, b| a[0].total_cmp(&b[0]));
        let mut sum = 0.0;
        let mut add = |overlap: f64| {
            if overlap > 0.0 {
                sum += overlap * overlap;
                self.deepest = most([self.deepest, overlap].into_iter());
            }
        };
        for (k, a) in places.iter().enumerate() {
            add(RADIUS - a[2]);
            for b in places[k + 1..].iter().take_while(|b| b[0] - a[0] < 2.0 * RADIUS) {
                add(2.0 * RADIUS - oracles::norm(oracles::minus(*a, *b)));
            }
        }
        self.lost = places.iter().filter(|place| place[2] < 0.0).count() as f64;
        self.squares.push(sum);
    }

    fn errors(&self) -> Vec<Axis> {
        let last = &self.squares[self.squares.len().saturating_sub(100)..];
        vec![
            Axis::new("overlap squared, mean", "m2", mean(self.squares.iter().copied())),
            Axis::new("overlap squared in the last second", "m2", mean(last.iter().copied())),
            Axis::new("overlap, worst", "m", self.deepest),
            Axis::new("balls through the plane", "1", self.lost),
        ]
    }
}

/// Bodies of the pile.
const PILE: usize = 2000;
/// Distance of the grid that it falls from, metres; how many stand along an edge of it; and how far it is shaken.
const SPACING: f64 = 1.3;
const PILE_EDGE: usize = 16;
const JITTER: f32 = 0.1;
/// Size of a body: that of the balls, metres.
const SIZE: f64 = 1.0;
/// Steps at which the pile is looked at: each 20th from here on.
const SETTLED: u32 = 160;

/// 2,000 balls, boxes and capsules that fall into a box with walls; 4 s.
pub fn pile() -> Scene {
    let inner = 0.5 * SPACING * PILE_EDGE as f64;
    let high = SPACING * (PILE / PILE_EDGE / PILE_EDGE + 2) as f64;
    let half = |x: f64, y: f64, z: f64| Vec3::new(x as f32, y as f32, z as f32);
    let (wide, middle, wall) = (inner + 1.0, inner + 0.5, 0.5 * high);
    let mut bodies = vec![
        Body::fixed([0.0, 0.0, -0.5], half(wide, wide, 0.5)),
        Body::fixed([middle, 0.0, wall], half(0.5, wide, wall)),
        Body::fixed([-middle, 0.0, wall], half(0.5, wide, wall)),
        Body::fixed([0.0, middle, wall], half(wide, 0.5, wall)),
        Body::fixed([0.0, -middle, wall], half(wide, 0.5, wall)),
    ];
    let mut random = Random::new(1);
    for index in 0..PILE {
        let cell = [index % PILE_EDGE, index / PILE_EDGE % PILE_EDGE, index / PILE_EDGE / PILE_EDGE];
        let [x, y, z] = cell.map(|c| SPACING * (c as f64 + 0.5) + f64::from(random.between(-JITTER, JITTER)));
        let shape = match index % 3 {
            0 => Shape::Sphere(0.5),
            1 => Shape::Box(Vec3::splat(0.45)),
            _ => Shape::Capsule { half_height: 0.3, radius: 0.3 },
        };
        bodies.push(Body::new([x - inner, y - inner, z], shape));
    }
    Scene {
        name: "pile",
        headline: "overlap over size, 99th percentile, mean from 2.7 to 4 s, 2,000 bodies",
        floor: 1.0e-6,
        kind: Kind::Touching,
        steps: 240,
        warm: 90,
        timed: 10,
        substeps_max: 16,
        setup: Setup::new(bodies),
        probe: |setup| Box::new(Pile::new(setup)),
    }
}

struct Pile {
    ruler: Ruler,
    moves: Vec<bool>,
    /// Medians, 99th percentiles and greatest overlaps, metres, by look.
    looks: Vec<[f64; 3]>,
    speeds: Rms,
    height: f64,
}

impl Pile {
    fn new(setup: &Setup) -> Self {
        let filled = Filled::new(setup, &Settings { gravity: GRAVITY, ..Settings::default() });
        let ruled = |(index, body): (usize, &Body)| Ruled {
            body: filled.bodies[index],
            shape: filled.shapes[index].expect("all have shapes"),
            moves: body.moves,
            radius: match body.shape.expect("all have shapes") {
                Shape::Sphere(radius) => radius,
                Shape::Box(half) => cellstep::math::length(half),
                Shape::Capsule { half_height, radius } => half_height + radius,
                Shape::Hull => unreachable!("the pile has no hulls"),
            },
        };
        let bodies = setup.bodies.iter().enumerate().map(ruled).collect();
        let moves = setup.bodies.iter().map(|body| body.moves).collect();
        let ruler = Ruler::new(filled.world, bodies);
        Self { ruler, moves, looks: Vec::new(), speeds: Rms::default(), height: 0.0 }
    }
}

impl Probe for Pile {
    fn wants(&self, step: u32) -> bool {
        step >= SETTLED && step.is_multiple_of(20)
    }

    fn see(&mut self, _step: u32, seen: &[Seen]) {
        let pose = |body: &Seen| Pose::new(Vec3::from_array(body.position.map(|x| x as f32)), body.rotation);
        let poses: Vec<Pose> = seen.iter().map(pose).collect();
        let depths = self.ruler.depths(&poses);
        let part = |share: usize| depths.get(depths.len() * share / 100).copied().map_or(0.0, f64::from);
        let deepest = depths.last().copied().map_or(0.0, f64::from);
        self.looks.push([part(50), part(99), deepest]);
        self.speeds = Rms::default();
        let moving = || seen.iter().zip(&self.moves).filter(|(_, moves)| **moves).map(|(body, _)| body);
        moving().for_each(|body| self.speeds.add(oracles::norm(body.velocity)));
        self.height = mean(moving().map(|body| body.position[2]));
    }

    fn errors(&self) -> Vec<Axis> {
        let column = |k: usize| self.looks.iter().map(move |look| look[k] / SIZE);
        vec![
            Axis::new("overlap, p99", "1", mean(column(1))),
            Axis::new("overlap, median", "1", mean(column(0))),
            Axis::new("overlap, worst", "1", most(column(2))),
            Axis::new("speed at the end, rms", "m/s", self.speeds.value()),
            Axis::new("mean height at the end", "m", self.height),
        ]
    }
}
