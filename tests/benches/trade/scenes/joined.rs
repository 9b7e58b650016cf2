//! Bodies on joints: pendula, a chain under a great weight, linkages with loops.

use super::{Rms, mean, most};
use crate::scene::{Axis, Body, Joint, JointKind, Kind, Probe, Scene, Seen, Setup};
use cellstep::math::{Pose, Rotation, Vec3};
use cellstep_tests::jointed::about_y;
use cellstep_tests::oracles::{self, Wide};

/// Angles from which pendula are let go, degrees.
const ANGLES: [f64; 4] = [10.0, 45.0, 90.0, 170.0];
/// How often each pendulum, chain and linkage is there.
const COPIES: usize = 4;
/// Distance of copies, metres.
const APART: f64 = 5.0;

/// A thin rod of 1 kg for each metre between two points, its x axis along it.
fn bar(from: Wide, to: Wide) -> Body {
    let along = oracles::minus(to, from);
    let length = oracles::norm(along) as f32;
    let moment = length * length * length / 12.0;
    let inertia = Vec3::new(0.01 * moment, moment, moment);
    let direction = Vec3::from_array(along.map(|x| x as f32)) / length;
    let middle = oracles::plus(from, along, 0.5);
    Body { rotation: Rotation::between(Vec3::X, direction), ..Body::massive(middle, length, inertia) }
}

/// The frame of a joint at an end of a bar, -1 or 1; its x axis is the world's y axis.
fn end(bar: &Body, length: f64, side: f64) -> Pose {
    let place = Vec3::new((0.5 * side * length) as f32, 0.0, 0.0);
    Pose::new(place, bar.rotation.inverse().after(about_y()))
}

/// Rods of 1 m that hang by an end, let go at four angles, on a ball joint and on a hinge, for 10 s.
pub fn pendula() -> Scene {
    let (mut bodies, mut joints) = (Vec::new(), Vec::new());
    for index in 0..2 * COPIES * ANGLES.len() {
        let (sine, cosine) = ANGLES[index / 2 % ANGLES.len()].to_radians().sin_cos();
        let point = [0.0, APART * index as f64, 0.0];
        let rod = bar(point, oracles::plus(point, [sine, 0.0, -cosine], 1.0));
        let kind = if index % 2 == 0 { JointKind::Ball } else { JointKind::Hinge };
        let frames = [Pose::new(Vec3::ZERO, about_y()), end(&rod, 1.0, -1.0)];
        bodies.extend([Body::anchor(point), rod]);
        joints.push(Joint { kind, bodies: [2 * index, 2 * index + 1], frames });
    }
    Scene {
        name: "pendula",
        headline: "distance of the tip from the exact motion, m, rms over 10 s and all pendula",
        floor: 1.0e-6,
        kind: Kind::Jointed,
        steps: 600,
        warm: 0,
        timed: 30,
        substeps_max: 64,
        setup: Setup { joints, ..Setup::new(bodies) },
        probe: |setup| Box::new(Pendula::new(setup)),
    }
}

/// Angles of a rod pendulum of 1 m after each step, by Runge and Kutta in double precision with 64 parts of a step:
/// `theta'' = -(3 g / 2 L) sin theta`.
fn swing(start: f64, steps: u32) -> Vec<f64> {
    let h = 1.0 / (60.0 * 64.0);
    let rate = |[angle, speed]: [f64; 2]| [speed, -1.5 * 9.81 * angle.sin()];
    let ahead = |x: [f64; 2], d: [f64; 2], s: f64| [x[0] + d[0] * s, x[1] + d[1] * s];
    let (mut state, mut angles) = ([start, 0.0], Vec::new());
    for _ in 0..steps {
        for _ in 0..64 {
            let a = rate(state);
            let b = rate(ahead(state, a, 0.5 * h));
            let c = rate(ahead(state, b, 0.5 * h));
            let d = rate(ahead(state, c, h));
            let sum = core::array::from_fn(|k| (a[k] + 2.0 * (b[k] + c[k]) + d[k]) / 6.0);
            state = ahead(state, sum, h);
        }
        angles.push(state[0]);
    }
    angles
}

struct Pendula {
    setup: Setup,
    /// Exact angles by start angle.
    exact: Vec<Vec<f64>>,
    /// By pendulum: distances of the tip, and the energy's greatest change over m g L.
    tips: Vec<Rms>,
    energies: Vec<f64>,
    gap: f64,
}

impl Pendula {
    fn new(setup: &Setup) -> Self {
        let exact = ANGLES.iter().map(|angle| swing(angle.to_radians(), 600)).collect();
        let count = setup.joints.len();
        let (tips, energies) = (vec![Rms::default(); count], vec![0.0; count]);
        Self { setup: setup.clone(), exact, tips, energies, gap: 0.0 }
    }
}

impl Probe for Pendula {
    fn see(&mut self, step: u32, seen: &[Seen]) {
        let start: Vec<Seen> = self.setup.bodies.iter().map(Seen::at_start).collect();
        for index in 0..self.tips.len() {
            let (point, body) = (seen[2 * index].position, 2 * index + 1);
            let (sine, cosine) = self.exact[index / 2 % ANGLES.len()][step as usize - 1].sin_cos();
            let tip = oracles::turned(seen[body].rotation, [0.5, 0.0, 0.0]);
            let tip = oracles::plus(seen[body].position, tip, 1.0);
            let right = oracles::plus(point, [sine, 0.0, -cosine], 1.0);
            self.tips[index].add(oracles::norm(oracles::minus(tip, right)));
            let [now, then] = [seen, &start].map(|seen| self.setup.energy(seen, [body].into_iter()));
            self.energies[index] = most([self.energies[index], ((now - then) / 9.81).abs()].into_iter());
        }
        self.gap = most(self.setup.joints.iter().map(|joint| joint.gap(seen)).chain([self.gap]));
    }

    fn errors(&self) -> Vec<Axis> {
        let tip = |wanted: usize| {
            let all = self.tips.iter().enumerate();
            mean(all.filter(|(i, _)| i / 2 % ANGLES.len() == wanted).map(|(_, tip)| tip.value()))
        };
        vec![
            Axis::new("tip, mean", "m", mean(self.tips.iter().map(Rms::value))),
            Axis::new("tip at 10 degrees", "m", tip(0)),
            Axis::new("tip at 45 degrees", "m", tip(1)),
            Axis::new("tip at 90 degrees", "m", tip(2)),
            Axis::new("tip at 170 degrees", "m", tip(3)),
            Axis::new("energy over m g L, mean", "1", mean(self.energies.iter().copied())),
            Axis::new("joint gap, worst", "m", self.gap),
        ]
    }
}

/// Links of a chain.
const LINKS: usize = 50;
/// Length of a link, metres.
const LINK: f64 = 0.2;

/// Eight chains of 50 links of 1 kg and 0.2 m on ball joints with 1,000 kg at the end: one half hangs, the other is
/// let go at 45 degrees. 10 s.
pub fn chain() -> Scene {
    let (mut bodies, mut joints) = (Vec::new(), Vec::new());
    for side in 0..2 * COPIES {
        let degrees = if side < COPIES { 0.0_f64 } else { 45.0 };
        let (sine, cosine) = degrees.to_radians().sin_cos();
        let along = [sine, 0.0, -cosine];
        let point = [0.0, 20.0 * side as f64, 0.0];
        let first = bodies.len();
        bodies.push(Body::anchor(point));
        let at = |place: f64| Pose::new(Vec3::new(place as f32, 0.0, 0.0), Rotation::IDENTITY);
        for link in 0..LINKS {
            let from = oracles::plus(point, along, LINK * link as f64);
            let moment = (LINK * LINK / 12.0) as f32;
            let link = bar(from, oracles::plus(from, along, LINK));
            bodies.push(Body {
                rotation: link.rotation,
                ..Body::massive(link.position, 1.0, Vec3::new(0.1 * moment, moment, moment))
            });
        }
        // A steel ball: 0.31 m.
        let bob = oracles::plus(point, along, LINK * LINKS as f64);
        bodies.push(Body {
            rotation: bodies[first + 1].rotation,
            ..Body::massive(bob, 1000.0, Vec3::splat(38.4))
        });
        for place in 0..=LINKS {
            let before = if place == 0 { at(0.0) } else { at(0.5 * LINK) };
            let after = if place == LINKS { at(0.0) } else { at(-0.5 * LINK) };
            let pair = [first + place, first + place + 1];
            joints.push(Joint { kind: JointKind::Ball, bodies: pair, frames: [before, after] });
        }
    }
    Scene {
        name: "chain",
        headline: "stretch: greatest sum of gaps over the length in 10 s, mean of eight chains",
        floor: 1.0e-6,
        kind: Kind::Jointed,
        steps: 600,
        warm: 0,
        timed: 30,
        substeps_max: 64,
        setup: Setup { joints, ..Setup::new(bodies) },
        probe: |setup| {
            Box::new(Chains { setup: setup.clone(), stretches: [0.0; 2 * COPIES], gap: 0.0, energy: 0.0 })
        },
    }
}

struct Chains {
    setup: Setup,
    /// By chain: those that hang come first.
    stretches: [f64; 2 * COPIES],
    gap: f64,
    energy: f64,
}

impl Probe for Chains {
    fn see(&mut self, _step: u32, seen: &[Seen]) {
        let gaps: Vec<f64> = self.setup.joints.iter().map(|joint| joint.gap(seen)).collect();
        for (stretch, gaps) in self.stretches.iter_mut().zip(gaps.chunks(LINKS + 1)) {
            let sum: f64 = gaps.iter().sum();
            *stretch = most([*stretch, sum / (LINK * LINKS as f64)].into_iter());
        }
        self.gap = most(gaps.into_iter().chain([self.gap]));
        let start: Vec<Seen> = self.setup.bodies.iter().map(Seen::at_start).collect();
        // The first that swings: its anchor is left out.
        let first = COPIES * (LINKS + 2);
        let swinging = || first + 1..first + LINKS + 2;
        let [now, then] = [seen, &start].map(|seen| self.setup.energy(seen, swinging()));
        self.energy = most([self.energy, ((now - then) / (1000.0 * 9.81 * 10.0)).abs()].into_iter());
    }

    fn errors(&self) -> Vec<Axis> {
        vec![
            Axis::new("stretch, mean", "1", mean(self.stretches.into_iter())),
            Axis::new("stretch, hanging", "1", mean(self.stretches[..COPIES].iter().copied())),
            Axis::new("stretch, swinging", "1", mean(self.stretches[COPIES..].iter().copied())),
            Axis::new("joint gap, worst", "m", self.gap),
            Axis::new("energy of a swinging one over m g L", "1", self.energy),
        ]
    }
}

/// Adds bars from point to point in a plane y = const, hinged in a row; returns the first one's index.
fn row(setup: &mut Setup, points: &[Wide]) -> usize {
    let first = setup.bodies.len();
    for pair in points.windows(2) {
        let here = setup.bodies.len();
        setup.bodies.push(bar(pair[0], pair[1]));
        if here > first {
            hinge(setup, [(here - 1, 1.0), (here, -1.0)]);
        }
    }
    first
}

/// Joins ends of two bars.
fn hinge(setup: &mut Setup, ends: [(usize, f64); 2]) {
    let frames = ends.map(|(index, side)| {
        let bar = &setup.bodies[index];
        end(bar, bar.inertia().0, side)
    });
    setup.joints.push(Joint { kind: JointKind::Hinge, bodies: ends.map(|end| end.0), frames });
}

/// Joins an end of a bar to a place that stays.
fn ground(setup: &mut Setup, bar: usize, side: f64, place: Wide) {
    let frames =
        [Pose::new(Vec3::ZERO, about_y()), end(&setup.bodies[bar], setup.bodies[bar].inertia().0, side)];
    let anchor = setup.bodies.len();
    setup.bodies.push(Body::anchor(place));
    setup.joints.push(Joint { kind: JointKind::Hinge, bodies: [anchor, bar], frames });
}

/// Crank 0.4 m, coupler 1 m, rocker 0.8 m, base 1 m.
fn four_bar(setup: &mut Setup, origin: Wide, spin: f32) {
    let at = |x: f64, z: f64| oracles::plus(origin, [x, 0.0, z], 1.0);
    let (b, d) = ([0.0, 0.4], [1.0, 0.0]);
    let (dx, dz): (f64, f64) = (d[0] - b[0], d[1] - b[1]);
    let away = dx.hypot(dz);
    let (ux, uz) = (dx / away, dz / away);
    let x: f64 = (1.0 - 0.64 + away * away) / (2.0 * away);
    let up = (1.0 - x * x).sqrt();
    let c = at(b[0] + ux * x - uz * up, b[1] + uz * x + ux * up);
    let first = row(setup, &[at(0.0, 0.0), at(b[0], b[1]), c, at(d[0], d[1])]);
    setup.bodies[first].spin = Vec3::new(0.0, spin, 0.0);
    ground(setup, first, -1.0, at(0.0, 0.0));
    ground(setup, first + 2, 1.0, at(d[0], d[1]));
}

/// Crank 0.3 m, rod 1 m, and a piston of 1 kg that slides along x.
fn slider_crank(setup: &mut Setup, origin: Wide, spin: f32) {
    let at = |x: f64, z: f64| oracles::plus(origin, [x, 0.0, z], 1.0);
    let c = at((1.0_f64 - 0.09).sqrt(), 0.0);
    let first = row(setup, &[at(0.0, 0.0), at(0.0, 0.3), c]);
    setup.bodies[first].spin = Vec3::new(0.0, spin, 0.0);
    ground(setup, first, -1.0, at(0.0, 0.0));
    let piston = setup.bodies.len();
    setup.bodies.extend([Body::massive(c, 1.0, Vec3::splat(0.004)), Body::anchor(c)]);
    let rod = &setup.bodies[first + 1];
    let frames = [end(rod, rod.inertia().0, 1.0), Pose::new(Vec3::ZERO, about_y())];
    setup.joints.push(Joint { kind: JointKind::Hinge, bodies: [first + 1, piston], frames });
    let frames = [Pose::IDENTITY; 2];
    setup.joints.push(Joint { kind: JointKind::Slider, bodies: [piston + 1, piston], frames });
}

/// Four-bars and slider-cranks whose cranks turn with 1 and about 2 turns per second, for 20 s.
pub fn loops() -> Scene {
    let mut setup = Setup::new(Vec::new());
    let mut ends = Vec::new();
    for copy in 0..COPIES {
        for (k, spin) in [6.283_185_5, 12.0].into_iter().enumerate() {
            let y = APART * (2 * copy + k) as f64;
            four_bar(&mut setup, [0.0, y, 0.0], spin);
            ends.push((setup.bodies.len(), setup.joints.len()));
            slider_crank(&mut setup, [10.0, y, 0.0], spin);
            ends.push((setup.bodies.len(), setup.joints.len()));
        }
    }
    Scene {
        name: "loops",
        headline: "widest gap of a joint in 20 s, m, mean of the linkages",
        floor: 1.0e-6,
        kind: Kind::Jointed,
        steps: 1200,
        warm: 0,
        timed: 30,
        substeps_max: 64,
        setup,
        probe: |setup| Box::new(Loops::new(setup)),
    }
}

/// A linkage: where its bodies and joints end.
struct Loops {
    setup: Setup,
    /// First and last joint of each, and bodies.
    linkages: Vec<[std::ops::Range<usize>; 2]>,
    gaps: Vec<f64>,
    energies: Vec<f64>,
    /// After the first step, which makes the velocities of the bodies that the crank drives.
    starts: Vec<f64>,
}

impl Loops {
    fn new(setup: &Setup) -> Self {
        // Each has 4 joints; bodies: three bars and two anchors, or two bars, an anchor, a piston and its rail.
        let linkages = |index: usize| [4 * index..4 * index + 4, 5 * index..5 * index + 5];
        let count = setup.joints.len() / 4;
        assert_eq!((setup.joints.len(), setup.bodies.len()), (4 * count, 5 * count));
        Self {
            setup: setup.clone(),
            linkages: (0..count).map(linkages).collect(),
            gaps: vec![0.0; count],
            energies: vec![0.0; count],
            starts: Vec::new(),
        }
    }

    fn energies(&self, seen: &[Seen]) -> Vec<f64> {
        let moving = |bodies: &std::ops::Range<usize>| {
            self.setup.energy(seen, bodies.clone().filter(|&body| self.setup.bodies[body].moves))
        };
        self.linkages.iter().map(|[_, bodies]| moving(bodies)).collect()
    }
}

impl Probe for Loops {
    fn see(&mut self, _step: u32, seen: &[Seen]) {
        let energies = self.energies(seen);
        if self.starts.is_empty() {
            self.starts.clone_from(&energies);
        }
        for (index, [joints, _]) in self.linkages.iter().enumerate() {
            let gaps = self.setup.joints[joints.clone()].iter().map(|joint| joint.gap(seen));
            self.gaps[index] = most(gaps.chain([self.gaps[index]]));
            let change = (energies[index] / self.starts[index] - 1.0).abs();
            self.energies[index] = most([self.energies[index], change].into_iter());
        }
    }

    fn errors(&self) -> Vec<Axis> {
        vec![
            Axis::new("gap, mean", "m", mean(self.gaps.iter().copied())),
            Axis::new("gap, worst", "m", most(self.gaps.iter().copied())),
            Axis::new("energy, mean", "1", mean(self.energies.iter().copied())),
        ]
    }
}
