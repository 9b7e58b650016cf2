//! Motion with a known end: sliding, rolling, bouncing; and motion far from the origin.

use super::{mean, most};
use crate::scene::{Axis, Body, Joint, JointKind, Kind, Probe, Scene, Seen, Setup, Shape};
use cellstep::math::{Pose, Rotation, Vec3};
use cellstep_tests::oracles::{self, Wide};

/// Directions of boxes that slide, and of balls that begin to roll.
const SLIDES: usize = 16;
const SKIDS: usize = 8;
/// Radii of balls that roll down a slope of 20 degrees, metres.
const ROLLS: [f32; 4] = [0.1, 0.2, 0.3, 0.5];
/// Metres after 2 s: `v^2 / 2 mu g` for 5 m/s and 0.4; 6.116208 m until a ball of 7 m/s rolls with 5 m/s under
/// friction 0.2, at 1.019368 s, and what it rolls then; and `a t^2 / 2` for `a = 5/7 g sin 20`.
const EXACT: [f64; 3] = [3.185_525, 6.116_208 + 5.0 * (2.0 - 1.019_368), 0.5 * 2.396_584 * 4.0];

fn azimuth(index: usize, count: usize) -> Wide {
    let (sine, cosine) = (core::f64::consts::TAU * index as f64 / count as f64).sin_cos();
    [cosine, sine, 0.0]
}

fn single(v: Wide) -> Vec3 {
    Vec3::from_array(v.map(|x| x as f32))
}

/// A floor whose top is at z = 0.
fn floor(at: [f64; 2], half: f32, friction: f32) -> Body {
    Body { friction, ..Body::fixed([at[0], at[1], -1.0], Vec3::new(half, half, 1.0)) }
}

/// Cubes that slide to a stop in 16 directions, balls that slide until they roll in 8, balls on a slope.
pub fn slide_and_roll() -> Scene {
    let mut bodies = vec![floor([30.0, 30.0], 60.0, 0.4), floor([230.0, 30.0], 60.0, 0.2)];
    for index in 0..SLIDES {
        let place = [(index % 4) as f64 * 15.0, (index / 4) as f64 * 15.0, 0.5];
        let velocity = single(azimuth(index, SLIDES)) * 5.0;
        bodies.push(Body { friction: 0.4, velocity, ..Body::new(place, Shape::Box(Vec3::splat(0.5))) });
    }
    for index in 0..SKIDS {
        let way = azimuth(index, SKIDS);
        let place = oracles::plus([230.0, 30.0, 0.1], way, 5.0);
        bodies.push(Body {
            friction: 0.2,
            velocity: single(way) * 7.0,
            ..Body::new(place, Shape::Sphere(0.1))
        });
    }
    let tilt = Rotation::from_axis_angle(Vec3::Y, 20.0_f32.to_radians());
    for (index, radius) in ROLLS.into_iter().enumerate() {
        let center = [0.0, -100.0 - 10.0 * index as f64, 0.0];
        bodies.push(Body { rotation: tilt, ..Body::fixed(center, Vec3::new(15.0, 3.0, 1.0)) });
        let above = oracles::turned(tilt, [-5.0, 0.0, 1.0 + f64::from(radius)]);
        bodies.push(Body::new(oracles::plus(center, above, 1.0), Shape::Sphere(radius)));
    }
    Scene {
        name: "slide-roll",
        headline: "way in 2 s against the closed forms, mean of sliding, skidding and rolling",
        floor: 1.0e-6,
        kind: Kind::Touching,
        steps: 120,
        warm: 0,
        timed: 20,
        substeps_max: 64,
        setup: Setup::new(bodies),
        probe: |setup| Box::new(Ways { setup: setup.clone(), last: Vec::new() }),
    }
}

struct Ways {
    setup: Setup,
    last: Vec<Seen>,
}

impl Ways {
    /// How far a body has come along a direction, and aside.
    fn way(&self, body: usize, along: Wide) -> [f64; 2] {
        let moved = oracles::minus(self.last[body].position, self.setup.bodies[body].position);
        let length = oracles::dot(moved, along);
        [length, oracles::norm(oracles::plus(moved, along, -length))]
    }
}

impl Probe for Ways {
    fn wants(&self, step: u32) -> bool {
        step == 120
    }

    fn see(&mut self, _step: u32, seen: &[Seen]) {
        self.last = seen.to_vec();
    }

    fn errors(&self) -> Vec<Axis> {
        let slides: Vec<[f64; 2]> = (0..SLIDES).map(|i| self.way(2 + i, azimuth(i, SLIDES))).collect();
        let skids: Vec<[f64; 2]> = (0..SKIDS).map(|i| self.way(2 + SLIDES + i, azimuth(i, SKIDS))).collect();
        let down = |i: usize| {
            let ramp = 2 + SLIDES + SKIDS + 2 * i;
            self.way(ramp + 1, oracles::turned(self.setup.bodies[ramp].rotation, [1.0, 0.0, 0.0]))
        };
        let rolls: Vec<[f64; 2]> = (0..ROLLS.len()).map(down).collect();
        let off = |ways: &[[f64; 2]], exact: f64| mean(ways.iter().map(|way| (way[0] / exact - 1.0).abs()));
        let each = [off(&slides, EXACT[0]), off(&skids, EXACT[1]), off(&rolls, EXACT[2])];
        let lengths = || slides.iter().map(|way| way[0]);
        let least = lengths().fold(f64::INFINITY, f64::min);
        vec![
            Axis::new("way, mean", "1", mean(each.into_iter())),
            Axis::new("way of sliding boxes", "1", each[0]),
            Axis::new("way of skidding balls", "1", each[1]),
            Axis::new("way of rolling balls", "1", each[2]),
            Axis::new("spread over 16 directions", "1", most(lengths()) / least - 1.0),
            Axis::new("deflection of boxes", "m", most(slides.iter().map(|way| way[1]))),
        ]
    }
}

/// Balls of each restitution.
const DROPS: usize = 8;
/// Restitutions, and apexes that are looked at: all of 10 s for 1.
const RESTITUTIONS: [f64; 2] = [0.5, 1.0];
const DROP_RADIUS: f32 = 0.25;

/// Height of the lowest point of a ball at the start, metres.
fn drop_height(index: usize) -> f64 {
    3.0 + 0.37 * index as f64
}

/// Balls that fall from 3 to 5.6 m, half of them with restitution 0.5, half with 1; 10 s.
pub fn bounce() -> Scene {
    let mut bodies = Vec::new();
    for (side, restitution) in RESTITUTIONS.into_iter().enumerate() {
        let restitution = restitution as f32;
        let x = 100.0 * side as f64;
        bodies.push(Body { restitution, ..floor([x, 0.0], 40.0, 0.6) });
        for index in 0..DROPS {
            let place = [x, 3.0 * index as f64 - 10.0, drop_height(index) + f64::from(DROP_RADIUS)];
            bodies.push(Body { restitution, ..Body::new(place, Shape::Sphere(DROP_RADIUS)) });
        }
    }
    Scene {
        name: "bounce",
        headline: "height of apexes against the closed form, mean: 3 at restitution 0.5, all of 10 s at 1",
        floor: 1.0e-6,
        kind: Kind::Touching,
        steps: 600,
        warm: 0,
        timed: 60,
        substeps_max: 64,
        setup: Setup::new(bodies),
        probe: |_| Box::new(Bounces { heights: vec![Vec::new(); 2 * DROPS] }),
    }
}

/// Heights of the lowest point of each ball, after each step.
struct Bounces {
    heights: Vec<Vec<f64>>,
}

/// Apexes after the start: vertices of the parabolas through three samples. Between impacts the samples of
/// semi-implicit Euler lie on a parabola at any number of substeps.
fn apexes(heights: &[f64]) -> Vec<f64> {
    let apex = |w: &[f64]| {
        let (slope, bend) = (0.5 * (w[2] - w[0]), w[2] - 2.0 * w[1] + w[0]);
        (w[1] > w[0] && w[1] >= w[2]).then(|| w[1] - 0.5 * slope * slope / bend)
    };
    heights.windows(3).filter_map(apex).collect()
}

impl Bounces {
    /// Relative errors of the apexes of a ball, with sign; one that is not there is off by all of it.
    fn errors_of(&self, ball: usize) -> Vec<f64> {
        let (restitution, height) = (RESTITUTIONS[ball / DROPS], drop_height(ball % DROPS));
        let count = if restitution < 1.0 { 3 } else { (10.0 / (8.0 * height / 9.81).sqrt() - 0.1) as usize };
        let found = apexes(&self.heights[ball]);
        let error = |k: usize| {
            let exact = height * restitution.powi(2 * (k as i32 + 1));
            found.get(k).map_or(-1.0, |apex| apex / exact - 1.0)
        };
        (0..count).map(error).collect()
    }
}

impl Probe for Bounces {
    fn see(&mut self, _step: u32, seen: &[Seen]) {
        for (ball, heights) in self.heights.iter_mut().enumerate() {
            let body = 1 + ball + ball / DROPS;
            heights.push(seen[body].position[2] - f64::from(DROP_RADIUS));
        }
    }

    fn errors(&self) -> Vec<Axis> {
        let errors: Vec<Vec<f64>> = (0..2 * DROPS).map(|ball| self.errors_of(ball)).collect();
        let (half, whole) = errors.split_at(DROPS);
        let off = |errors: &[Vec<f64>]| mean(errors.iter().flatten().map(|error| error.abs()));
        let [half_off, whole_off] = [half, whole].map(off);
        let all = || errors.iter().flatten();
        vec![
            Axis::new("apex, mean of both", "1", mean([half_off, whole_off].into_iter())),
            Axis::new("apex at restitution 0.5, mean", "1", half_off),
            Axis::new("apex at restitution 1, mean", "1", whole_off),
            Axis::new("apex, worst", "1", most(all().map(|error| error.abs()))),
            Axis::new("apex, greatest gain of height", "1", most(all().copied())),
        ]
    }
}

/// Where the far copies are, metres: 14 km off, and no whole number of sectors.
const AWAY: Wide = [10_000.0, -10_000.0, 0.0];
/// Sets of bodies here, and as many there.
const LANES: usize = 4;
/// Bodies of a set that move.
const MOVERS: usize = 5;

/// The same motion at the origin and 14 km away, in one world: a cube that slides, a ball that begins to roll, one
/// that rolls with 5 cm/s, a box that tumbles through the air, a pendulum. 3 s.
pub fn far() -> Scene {
    let mut setup = Setup::new(Vec::new());
    for origin in [[0.0; 3], AWAY] {
        setup.bodies.push(floor([origin[0], origin[1]], 60.0, 0.4));
        for lane in 0..LANES {
            let at = |x: f64, z: f64| oracles::plus(origin, [x, 6.0 * lane as f64 - 9.0, z], 1.0);
            let way = single(azimuth(2 * lane + 1, 32));
            let body = |place, shape, velocity| Body { friction: 0.4, velocity, ..Body::new(place, shape) };
            let spin = Vec3::new(1.0, 3.0, 2.0);
            let thrown =
                body(at(70.0, 0.0), Shape::Box(Vec3::new(0.5, 0.3, 0.1)), Vec3::new(10.0, 0.0, 15.0));
            let point = setup.bodies.len() + 4;
            setup.bodies.extend([
                body(at(-30.0, 0.5), Shape::Box(Vec3::splat(0.5)), way * 5.0),
                body(at(-15.0, 0.25), Shape::Sphere(0.25), way * 7.0),
                body(at(15.0, 0.25), Shape::Sphere(0.25), way * 0.05),
                Body { spin, ..thrown },
                Body::anchor(at(30.0, 4.0)),
                Body::massive(at(31.0, 4.0), 1.0, Vec3::splat(0.1)),
            ]);
            let arm = |x: f32| Pose::new(Vec3::new(x, 0.0, 0.0), Rotation::IDENTITY);
            let frames = [arm(0.0), arm(-1.0)];
            setup.joints.push(Joint { kind: JointKind::Ball, bodies: [point, point + 1], frames });
        }
    }
    Scene {
        name: "far",
        headline: "way off the same motion at the origin, m, greatest in 3 s, mean of 20 bodies 14 km away",
        floor: 1.0e-5,
        kind: Kind::Both,
        steps: 180,
        warm: 0,
        timed: 30,
        substeps_max: 64,
        setup,
        probe: |setup| {
            let half = setup.bodies.len() / 2;
            let moving = (0..half).filter(|&body| setup.bodies[body].moves).collect();
            Box::new(Copies { half, moving, worst: vec![0.0; LANES * MOVERS] })
        },
    }
}

struct Copies {
    /// A body and its copy are so many places apart.
    half: usize,
    moving: Vec<usize>,
    /// Greatest distance so far, by moving body.
    worst: Vec<f64>,
}

impl Probe for Copies {
    fn see(&mut self, _step: u32, seen: &[Seen]) {
        for (&body, worst) in self.moving.iter().zip(&mut self.worst) {
            let [here, there] = [body, body + self.half].map(|body| seen[body].position);
            let off = oracles::minus(oracles::minus(there, here), AWAY);
            *worst = most([*worst, oracles::norm(off)].into_iter());
        }
    }

    fn errors(&self) -> Vec<Axis> {
        let kind = |k: usize| mean(self.worst.iter().skip(k).step_by(MOVERS).copied());
        vec![
            Axis::new("off, mean", "m", mean(self.worst.iter().copied())),
            Axis::new("off, sliding cube", "m", kind(0)),
            Axis::new("off, ball that begins to roll", "m", kind(1)),
            Axis::new("off, ball of 5 cm/s", "m", kind(2)),
            Axis::new("off, thrown box", "m", kind(3)),
            Axis::new("off, pendulum", "m", kind(4)),
        ]
    }
}
