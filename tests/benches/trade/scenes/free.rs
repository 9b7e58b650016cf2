//! Bodies that turn freely: tumbling boxes, and tops.

use super::{mean, most};
use crate::scene::{Axis, Body, Joint, JointKind, Kind, Probe, Scene, Seen, Setup, Shape};
use cellstep::math::{Pose, Rotation, Vec3};
use cellstep_tests::executors::Random;
use cellstep_tests::oracles::{self, Wide};

/// First time at which the spin of the first box about its middle axis is 0, seconds: closed form.
const FIRST_ZERO: f64 = 1.271_927_465_1;

/// 64 boxes of 1 x 0.6 x 0.2 m without gravity for 10 s. The first has the spin (0.05, 10, 0.05), near to the axis
/// that is unstable; the others spin about any axis with 2 to 10 rad/s.
pub fn tumbling() -> Scene {
    let (mut random, mut bodies) = (Random::new(1), Vec::new());
    for index in 0..64 {
        let cell = [index % 4, index / 4 % 4, index / 16].map(|c| 3.0 * f64::from(c));
        let mut between = || random.between(-1.0, 1.0);
        let axis = loop {
            let axis = Vec3::new(between(), between(), between());
            if (0.1..1.0).contains(&cellstep::math::length(axis)) {
                break axis / cellstep::math::length(axis);
            }
        };
        let spin = if index == 0 { Vec3::new(0.05, 10.0, 0.05) } else { axis * (6.0 + 4.0 * between()) };
        let shape = Shape::Box(Vec3::new(0.5, 0.3, 0.1));
        bodies.push(Body { spin, ..Body::new(cell, shape) });
    }
    Scene {
        name: "tumbling",
        headline: "energy drift in 10 s, mean of 64 boxes",
        floor: 1.0e-6,
        kind: Kind::Free,
        steps: 600,
        warm: 0,
        timed: 30,
        substeps_max: 64,
        setup: Setup { gravity: Vec3::ZERO, ..Setup::new(bodies) },
        probe: |setup| Box::new(Tumbling::new(setup)),
    }
}

/// Energy and angular momentum of one body.
fn motion(inertia: Wide, seen: &Seen) -> (f64, Wide) {
    let spin = oracles::turned_back(seen.rotation, seen.spin);
    let momentum: Wide = core::array::from_fn(|k| inertia[k] * spin[k]);
    (0.5 * oracles::dot(spin, momentum), oracles::turned(seen.rotation, momentum))
}

struct Tumbling {
    inertias: Vec<Wide>,
    starts: Vec<(f64, Wide)>,
    /// Greatest changes of energy and momentum so far, as shares, by body.
    drifts: Vec<[f64; 2]>,
    /// Spin of the first box about its middle axis, after each step.
    first: Vec<f64>,
}

impl Tumbling {
    fn new(setup: &Setup) -> Self {
        let inertias: Vec<Wide> = setup.bodies.iter().map(|body| body.inertia().1).collect();
        let start = |(body, &inertia): (&Body, &Wide)| motion(inertia, &Seen::at_start(body));
        let starts = setup.bodies.iter().zip(&inertias).map(start).collect();
        let first = vec![f64::from(setup.bodies[0].spin.y)];
        Self { drifts: vec![[0.0; 2]; inertias.len()], inertias, starts, first }
    }

    /// When the spin about the middle axis first was 0, seconds.
    fn first_zero(&self) -> f64 {
        let Some(place) = self.first.windows(2).position(|pair| pair[0] > 0.0 && pair[1] <= 0.0) else {
            return f64::INFINITY;
        };
        let Some(around) = place.checked_sub(1).and_then(|from| self.first.get(from..from + 4)) else {
            return f64::INFINITY;
        };
        let around = [around[0], around[1], around[2], around[3]];
        ((place - 1) as f64 + oracles::crossing(around)) / 60.0
    }
}

impl Probe for Tumbling {
    fn see(&mut self, _step: u32, seen: &[Seen]) {
        for (index, body) in seen.iter().enumerate() {
            let (energy, momentum) = motion(self.inertias[index], body);
            let (energy_at_start, momentum_at_start) = self.starts[index];
            let change = oracles::norm(oracles::minus(momentum, momentum_at_start));
            let found = [energy / energy_at_start - 1.0, change / oracles::norm(momentum_at_start)];
            for (drift, now) in self.drifts[index].iter_mut().zip(found) {
                *drift = most([*drift, now.abs()].into_iter());
            }
        }
        self.first.push(oracles::turned_back(seen[0].rotation, seen[0].spin)[1]);
    }

    fn errors(&self) -> Vec<Axis> {
        let column = |k: usize| self.drifts.iter().map(move |drift| drift[k]);
        vec![
            Axis::new("energy, mean", "1", mean(column(0))),
            Axis::new("energy, worst", "1", most(column(0))),
            Axis::new("energy, box near its separatrix", "1", self.drifts[0][0]),
            Axis::new("angular momentum, mean", "1", mean(column(1))),
            Axis::new("angular momentum, worst", "1", most(column(1))),
            Axis::new("first zero of the middle spin", "s", (self.first_zero() - FIRST_ZERO).abs()),
        ]
    }
}

/// Distance of a top's center from its point, metres.
const ARM: f64 = 0.2;
/// Moments of a disc of 1 kg and 0.2 m: across, and about its axis, z, kg m2.
const MOMENTS: [f64; 2] = [0.01, 0.02];

/// A top in steady precession: its axis keeps its angle to the vertical and goes round at a constant rate.
#[derive(Clone, Copy)]
struct Steady {
    tilt: f64,
    /// Azimuth at the start, radians.
    azimuth: f64,
    /// Precession, rad/s.
    rate: f64,
    /// Spin about the axis, with what precession gives to it, rad/s.
    spin: f64,
}

impl Steady {
    /// The slow one of the two precessions of a spin:
    /// `m g l = I3 w3 p - I1 p^2 cos(tilt)`, `I1` about the point.
    fn new(tilt: f64, azimuth: f64, spin: f64) -> Self {
        let (weight, across) = (9.81 * ARM, MOMENTS[0] + ARM * ARM);
        let (momentum, a) = (MOMENTS[1] * spin, across * tilt.cos());
        let rate = 2.0 * weight / (momentum + (momentum * momentum - 4.0 * a * weight).sqrt());
        Self { tilt, azimuth, rate, spin }
    }

    fn axis(&self, time: f64) -> Wide {
        let (sine, cosine) = (self.azimuth + self.rate * time).sin_cos();
        [self.tilt.sin() * cosine, self.tilt.sin() * sine, self.tilt.cos()]
    }

    /// At the start: of the axis about the vertical, and the rest about the axis.
    fn angular_velocity(&self) -> Wide {
        let rest = self.spin - self.rate * self.tilt.cos();
        oracles::plus([0.0, 0.0, self.rate], self.axis(0.0), rest)
    }
}

fn tops() -> Vec<Steady> {
    let mut tops = Vec::new();
    for (i, degrees) in [30.0_f64, 60.0, 80.0, 100.0].into_iter().enumerate() {
        for (k, spin) in [45.0, 60.0, 80.0, 100.0].into_iter().enumerate() {
            tops.push(Steady::new(degrees.to_radians(), 0.3 + (4 * i + k) as f64, spin));
        }
    }
    tops
}

/// 16 discs on arms, each held by a ball joint at a point, in steady precession for 10 s.
pub fn top() -> Scene {
    let (mut bodies, mut joints) = (Vec::new(), Vec::new());
    let single = |v: Wide| Vec3::from_array(v.map(|x| x as f32));
    for (index, steady) in tops().into_iter().enumerate() {
        let point = [(index % 4) as f64, (index / 4) as f64, 0.0];
        let center = oracles::plus(point, steady.axis(0.0), ARM);
        let spin = steady.angular_velocity();
        let across = MOMENTS[0] as f32;
        let body = Body {
            rotation: Rotation::between(Vec3::Z, single(steady.axis(0.0))),
            velocity: single(oracles::cross(spin, oracles::minus(center, point))),
            spin: single(spin),
            ..Body::massive(center, 1.0, Vec3::new(across, across, MOMENTS[1] as f32))
        };
        bodies.extend([Body::anchor(point), body]);
        let frames = [Vec3::ZERO, Vec3::new(0.0, 0.0, -ARM as f32)];
        let frames = frames.map(|place| Pose::new(place, Rotation::IDENTITY));
        joints.push(Joint { kind: JointKind::Ball, bodies: [2 * index, 2 * index + 1], frames });
    }
    Scene {
        name: "top",
        headline: "angle of the axis off the closed form, mean of 16 tops over 10 s",
        floor: 1.0e-6,
        kind: Kind::Jointed,
        steps: 600,
        warm: 0,
        timed: 30,
        substeps_max: 64,
        setup: Setup { joints, ..Setup::new(bodies) },
        probe: |setup| {
            let energies = Vec::new();
            let setup = setup.clone();
            Box::new(Tops { setup, tops: tops(), angles: Vec::new(), gap: 0.0, energies, worst: 0.0 })
        },
    }
}

struct Tops {
    setup: Setup,
    tops: Vec<Steady>,
    /// After each step, mean over the tops.
    angles: Vec<f64>,
    /// Greatest angle at the end, over the tops.
    worst: f64,
    gap: f64,
    /// Greatest change of each top's energy over what its precession and height have, as shares.
    energies: Vec<f64>,
}

impl Probe for Tops {
    fn see(&mut self, step: u32, seen: &[Seen]) {
        let time = f64::from(step) / 60.0;
        let angle = |(index, steady): (usize, &Steady)| {
            let axis = oracles::turned(seen[2 * index + 1].rotation, [0.0, 0.0, 1.0]);
            let right = steady.axis(time);
            oracles::norm(oracles::cross(axis, right)).atan2(oracles::dot(axis, right))
        };
        let angles: Vec<f64> = self.tops.iter().enumerate().map(angle).collect();
        self.worst = most(angles.iter().copied());
        self.angles.push(mean(angles.into_iter()));
        self.gap = most(self.setup.joints.iter().map(|joint| joint.gap(seen)).chain([self.gap]));
        self.energies.resize(self.tops.len(), 0.0);
        for (index, most_so_far) in self.energies.iter_mut().enumerate() {
            let body = 2 * index + 1;
            let start: Vec<Seen> = self.setup.bodies.iter().map(Seen::at_start).collect();
            let [now, then] = [seen, &start].map(|seen| self.setup.energy(seen, [body].into_iter()));
            *most_so_far = most([*most_so_far, ((now - then) / (9.81 * ARM)).abs()].into_iter());
        }
    }

    fn errors(&self) -> Vec<Axis> {
        vec![
            Axis::new("axis angle, mean", "rad", mean(self.angles.iter().copied())),
            Axis::new("axis angle at the end, worst", "rad", self.worst),
            Axis::new("joint gap, worst", "m", self.gap),
            Axis::new("energy over m g l, mean", "1", mean(self.energies.iter().copied())),
        ]
    }
}
