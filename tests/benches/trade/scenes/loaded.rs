//! What has to stand: columns, great masses on small ones, an arch, an overhang, a house of cards.

use super::{Rms, mean, most};
use crate::scene::{Axis, Body, Kind, Mass, Probe, Scene, Seen, Setup, Shape};
use cellstep::math::{Rotation, Vec3};
use cellstep_tests::oracles;

/// Cubes of the columns.
const COLUMNS: [usize; 2] = [10, 40];
/// Mass of the upper of two cubes over that of the lower.
const RATIOS: [f32; 3] = [100.0, 1000.0, 10_000.0];
/// Distance of columns, metres.
const APART: f64 = 60.0;
/// From this step on loads are called settled.
const SETTLED: u32 = 300;

/// Columns of 10 and 40 cubes of 1 m, and cubes under cubes that are 100, 1,000 and 10,000 times as heavy; 10 s.
pub fn columns() -> Scene {
    let (mut bodies, mut stacks) = (Vec::new(), Vec::new());
    let light = |count: usize| vec![1000.0; count];
    stacks.extend(COLUMNS.map(light));
    stacks.extend(RATIOS.map(|ratio| vec![1000.0, 1000.0 * ratio]));
    for (place, densities) in stacks.iter().enumerate() {
        let x = APART * place as f64;
        bodies.push(Body::fixed([x, 0.0, -1.0], Vec3::new(25.0, 25.0, 1.0)));
        for (level, &density) in densities.iter().enumerate() {
            let cube = Body::new([x, 0.0, 0.5 + level as f64], Shape::Box(Vec3::splat(0.5)));
            bodies.push(Body { mass: Mass::Density(density), ..cube });
        }
    }
    Scene {
        name: "columns",
        headline: "force between cubes against the weight above, worst of each column, mean of 5 columns over 10 s",
        floor: 1.0e-6,
        kind: Kind::Touching,
        steps: 600,
        warm: 0,
        timed: 30,
        substeps_max: 64,
        setup: Setup::new(bodies),
        probe: |setup| Box::new(Columns::new(setup)),
    }
}

/// Forces follow from Newton's law: what the cubes above a face gain in momentum in a step is what their weight and
/// the force at that face give, whatever an engine says of its impulses. Where a cube is no longer on the one below
/// (off by half of its size), the face carries nothing: an error of 1, which is also the most.
struct Columns {
    setup: Setup,
    /// Bodies of each column, from below.
    columns: Vec<std::ops::Range<usize>>,
    before: Vec<Seen>,
    /// Sum of the errors of each face, and from [`SETTLED`] on, by body.
    errors: Vec<[f64; 2]>,
    steps: [f64; 2],
    /// Greatest way aside, by column.
    aside: Vec<f64>,
    /// Speeds from [`SETTLED`] on.
    jitter: Rms,
}

impl Columns {
    fn new(setup: &Setup) -> Self {
        let mut columns: Vec<std::ops::Range<usize>> = Vec::new();
        for (index, body) in setup.bodies.iter().enumerate() {
            if !body.moves {
                columns.push(index + 1..index + 1);
            }
            columns.last_mut().expect("the first is a floor").end = index + 1;
        }
        let before = setup.bodies.iter().map(Seen::at_start).collect();
        let (errors, aside) = (vec![[0.0; 2]; setup.bodies.len()], vec![0.0; columns.len()]);
        Self { setup: setup.clone(), columns, before, errors, steps: [0.0; 2], aside, jitter: Rms::default() }
    }

    /// How far a column's top has sunk, metres.
    fn sink(&self, column: usize) -> f64 {
        let top = self.columns[column].end - 1;
        (self.setup.bodies[top].position[2] - self.before[top].position[2]).abs()
    }

    /// Mean over the steps of the worst face of a column: all steps, or those from [`SETTLED`] on.
    fn force(&self, column: usize, from: usize) -> f64 {
        most(self.columns[column].clone().map(|body| self.errors[body][from] / self.steps[from].max(1.0)))
    }
}

impl Probe for Columns {
    fn see(&mut self, step: u32, seen: &[Seen]) {
        let is_settled = step > SETTLED;
        self.steps[0] += 1.0;
        self.steps[1] += f64::from(u8::from(is_settled));
        for (index, column) in self.columns.iter().enumerate() {
            let (mut gained, mut weight) = (0.0, 0.0);
            for body in column.clone().rev() {
                let mass = self.setup.bodies[body].inertia().0;
                gained += mass * (seen[body].velocity[2] - self.before[body].velocity[2]) * 60.0;
                weight += mass * 9.81;
                // Below the lowest cube is its floor.
                let start = |body: usize| self.setup.bodies[body].position;
                let apart = oracles::minus(seen[body].position, seen[body - 1].position);
                let off = oracles::minus(apart, oracles::minus(start(body), start(body - 1)));
                let error = (gained / weight).abs();
                let error = if oracles::norm(off) < 0.5 && error < 1.0 { error } else { 1.0 };
                self.errors[body][0] += error;
                if is_settled {
                    self.errors[body][1] += error;
                    self.jitter.add(oracles::norm(seen[body].velocity));
                }
                let [x, y, _] = oracles::minus(seen[body].position, start(body));
                self.aside[index] = most([self.aside[index], x.hypot(y)].into_iter());
            }
        }
        self.before = seen.to_vec();
    }

    fn errors(&self) -> Vec<Axis> {
        let columns = || 0..self.columns.len();
        let mut axes = vec![Axis::new("force, mean", "1", mean(columns().map(|k| self.force(k, 0))))];
        let forces =
            ["force, 10 cubes", "force, 40 cubes", "force, 100:1", "force, 1,000:1", "force, 10,000:1"];
        axes.extend(forces.into_iter().enumerate().map(|(k, name)| Axis::new(name, "1", self.force(k, 0))));
        let settled = mean(columns().map(|k| self.force(k, 1)));
        axes.push(Axis::new("force from 5 s on, mean", "1", settled));
        let sinks = ["sink, 10 cubes", "sink, 40 cubes", "sink, 100:1", "sink, 1,000:1", "sink, 10,000:1"];
        axes.extend(sinks.into_iter().enumerate().map(|(k, name)| Axis::new(name, "m", self.sink(k))));
        axes.push(Axis::new("way aside, 40 cubes", "m", self.aside[1]));
        axes.push(Axis::new("speed from 5 s on, rms", "m/s", self.jitter.value()));
        axes
    }
}

/// Seconds that structures should stand.
const STAND: f64 = 60.0;
/// What has moved by more has fallen, metres.
const FALLEN: f64 = 0.15;
/// Stones of the arch, its inner and outer radius and depth, metres.
const STONES: usize = 11;
const ARCH: [f64; 3] = [2.0, 2.6, 0.6];

/// An arch of 11 stones, four blocks that overhang by 0.99 and by 1.01 of what statics allow, a house of 15 cards.
pub fn structures() -> Scene {
    let mut setup = Setup::new(vec![Body::fixed([0.0, 0.0, -1.0], Vec3::new(60.0, 60.0, 1.0))]);
    let mut ends = vec![setup.bodies.len()];
    arch(&mut setup);
    ends.push(setup.bodies.len());
    overhang(&mut setup, [20.0, 0.0], 0.99);
    ends.push(setup.bodies.len());
    cards(&mut setup, [0.0, 20.0]);
    ends.push(setup.bodies.len());
    overhang(&mut setup, [20.0, 20.0], 1.01);
    ends.push(setup.bodies.len());
    assert_eq!(ends, STRUCTURES, "the probe knows where each begins");
    Scene {
        name: "structures",
        headline: "share of 60 s for which arch, overhang and house of cards do not stand, mean",
        floor: 1.0e-3,
        kind: Kind::Touching,
        steps: 3600,
        warm: 0,
        timed: 30,
        substeps_max: 64,
        setup,
        probe: |setup| {
            let falls = vec![f64::INFINITY; STRUCTURES.len() - 1];
            let (early, last) = (Vec::new(), Vec::new());
            Box::new(Structures { setup: setup.clone(), falls, early, last, jitter: Rms::default() })
        },
    }
}

/// First bodies of the arch, the overhang (a table and four blocks), the cards, the falling overhang; the end.
const STRUCTURES: [usize; 5] = [1, 1 + STONES, 6 + STONES, 21 + STONES, 26 + STONES];

/// Friction of stones and cards, high enough for the thrust of either.
const ROUGH: f32 = 0.6;

/// Half of a ring of equal wedges, the lowest two on the floor.
fn arch(setup: &mut Setup) {
    let half = 0.5 * core::f64::consts::PI / STONES as f64;
    let ([inner, outer, depth], (sine, cosine)) = (ARCH, half.sin_cos());
    // The center of mass of a trapezium of these two parallel sides.
    let (low, high, height) = (inner * sine, outer * sine, (outer - inner) * cosine);
    let middle = inner * cosine + height * (low + 2.0 * high) / (3.0 * (low + high));
    let mut corners = Vec::new();
    for radius in [inner, outer] {
        for (x, y) in [(-1.0, -0.5), (-1.0, 0.5), (1.0, -0.5), (1.0, 0.5)] {
            let corner = [x * radius * sine, y * depth, radius * cosine - middle];
            corners.push(Vec3::from_array(corner.map(|x| x as f32)));
        }
    }
    setup.hull = corners;
    for stone in 0..STONES {
        let angle = (2 * stone + 1) as f64 * half - 0.5 * core::f64::consts::PI;
        let (sine, cosine) = angle.sin_cos();
        let rotation = Rotation::from_axis_angle(Vec3::Y, angle as f32);
        let place = [middle * sine, 0.0, middle * cosine];
        setup.bodies.push(Body { rotation, friction: ROUGH, ..Body::new(place, Shape::Hull) });
    }
}

/// A table and four blocks of 1 m, each as far over the one below as balance allows, times a factor.
fn overhang(setup: &mut Setup, at: [f64; 2], factor: f64) {
    let half = Vec3::new(0.5, 0.3, 0.1);
    // The table's edge is at x = 0; the lowest block comes first.
    setup.bodies.push(Body::fixed([at[0] - 1.0, at[1], 0.5], Vec3::new(1.0, 1.0, 0.5)));
    let mut edge = 0.0;
    for (level, above) in [4.0, 3.0, 2.0, 1.0].into_iter().enumerate() {
        edge += factor * 0.5 / above;
        let place = [at[0] + edge - 0.5, at[1], 1.1 + 0.2 * level as f64];
        setup.bodies.push(Body { friction: ROUGH, ..Body::new(place, Shape::Box(half)) });
    }
}

/// Three tents of cards, two on these, one on these, with level cards between; the cards lean by 25 degrees.
fn cards(setup: &mut Setup, at: [f64; 2]) {
    let (length, thick) = (0.5, 0.02);
    let lean = 25.0_f64.to_radians();
    let (sine, cosine) = lean.sin_cos();
    let (half_width, half_height) = (length * sine + thick * cosine, length * cosine + thick * sine);
    let pitch = 4.0 * half_width + 0.02;
    let card = |half: f64, x: f64, z: f64, turn: f64| {
        let shape = Shape::Box(Vec3::new(thick as f32, 0.35, half as f32));
        let rotation = Rotation::from_axis_angle(Vec3::Y, turn as f32);
        let mass = Mass::Density(500.0);
        Body { rotation, mass, friction: ROUGH, ..Body::new([at[0] + x, at[1], z], shape) }
    };
    let mut floor = 0.0;
    for tents in [3, 2, 1] {
        let first = -0.5 * pitch * f64::from(tents - 1);
        for tent in 0..tents {
            let x = first + pitch * f64::from(tent);
            setup.bodies.push(card(length, x - half_width, floor + half_height, lean));
            setup.bodies.push(card(length, x + half_width, floor + half_height, -lean));
        }
        for level in 0..tents - 1 {
            let x = first + pitch * (f64::from(level) + 0.5);
            let turn = core::f64::consts::FRAC_PI_2;
            setup.bodies.push(card(0.5 * pitch - 0.005, x, floor + 2.0 * half_height + thick, turn));
        }
        floor += 2.0 * (half_height + thick);
    }
}

struct Structures {
    setup: Setup,
    /// When each fell, seconds.
    falls: Vec<f64>,
    /// At 5 s, when all has settled, and now.
    early: Vec<Seen>,
    last: Vec<Seen>,
    jitter: Rms,
}

impl Structures {
    /// Bodies of those that should stand.
    fn standing(&self) -> impl Iterator<Item = usize> + '_ {
        (STRUCTURES[0]..STRUCTURES[3]).filter(|&body| self.setup.bodies[body].moves)
    }
}

impl Probe for Structures {
    fn see(&mut self, step: u32, seen: &[Seen]) {
        let time = f64::from(step) / 60.0;
        for (fall, range) in self.falls.iter_mut().zip(STRUCTURES.windows(2)) {
            let moved = |body: usize| {
                oracles::norm(oracles::minus(seen[body].position, self.setup.bodies[body].position))
            };
            if fall.is_infinite() && (range[0]..range[1]).any(|body| moved(body) > FALLEN) {
                *fall = time;
            }
        }
        if step == SETTLED {
            self.early = seen.to_vec();
        }
        if step > SETTLED {
            let speeds: Vec<f64> = self.standing().map(|body| oracles::norm(seen[body].velocity)).collect();
            speeds.into_iter().for_each(|speed| self.jitter.add(speed));
        }
        self.last = seen.to_vec();
    }

    fn errors(&self) -> Vec<Axis> {
        let down = |k: usize| 1.0 - self.falls[k].min(STAND) / STAND;
        let creep =
            |body: usize| oracles::norm(oracles::minus(self.last[body].position, self.early[body].position));
        let creep = if self.early.is_empty() { f64::INFINITY } else { most(self.standing().map(creep)) };
        vec![
            Axis::new("not standing, mean", "1", mean((0..3).map(down))),
            Axis::new("not standing, arch", "1", down(0)),
            Axis::new("not standing, overhang of 0.99", "1", down(1)),
            Axis::new("not standing, house of cards", "1", down(2)),
            Axis::new("overhang of 1.01 falls after", "s", self.falls[3]),
            Axis::new("creep from 5 to 60 s, worst", "m", creep),
            Axis::new("speed from 5 s on, rms", "m/s", self.jitter.value()),
        ]
    }
}
