//! Joints against closed forms: pendula, springs, linkages, chains, a heavy top, statics and what is conserved.

use cellstep::joint::axis::{TURN_X, X};
use cellstep::math::{self, PI, Pose, Rotation, Vec3};
use cellstep::{
    Axis, BodyHandle, Drive, JointDef, JointHandle, MassProperties, Preset, Serial, Settings, Spring,
};
use cellstep_tests::executors::Random;
use cellstep_tests::jointed::{
    Bar, about_y, at, ball, coordinate, energy, force, gap, jointed, massive, rod, torque, weightless,
};
use cellstep_tests::oracles::{
    self, GRAVITY, Wide, center, mass, minus, momenta, norm, plus, relative, velocity,
};
use cellstep_tests::score::{Case, Sheet};
use cellstep_tests::worlds::{OwnedWorld, run};

/// Times at which a coordinate that `sample` reads goes from below 0 to above, seconds.
fn rising(world: &mut OwnedWorld, seconds: u32, mut sample: impl FnMut(&OwnedWorld) -> f64) -> Vec<f64> {
    let mut times = Vec::new();
    let mut last = sample(world);
    for step in 0..60 * seconds {
        world.step(&mut Serial);
        let now = sample(world);
        if last < 0.0 && now >= 0.0 {
            times.push((f64::from(step) + last / (last - now)) / 60.0);
        }
        last = now;
    }
    times
}

/// A rod of 1 m and 1 kg that hangs by one end from a ball or a hinge, let go at an angle.
fn pendulum(sheet: &Sheet, degrees: f32, is_hinge: bool) -> (OwnedWorld, BodyHandle, JointHandle) {
    let (mut world, base) = sheet.jointed(1, 1);
    let angle = degrees.to_radians();
    let bar = Bar::new(&mut world, Vec3::ZERO, Vec3::new(math::sin(angle), 0.0, -math::cos(angle)));
    let (body, frame) = bar.end(-1.0);
    let frames = [Pose::new(Vec3::ZERO, about_y()), frame];
    let def =
        if is_hinge { JointDef::hinge([base, body], frames) } else { JointDef::ball([base, body], frames) };
    let joint = world.create_joint(&def).expect("room");
    (world, body, joint)
}

#[test]
fn pendula_swing_in_time() {
    Case::new("rod pendulum").gated_from(Preset::Balanced).run(|sheet| {
        for (degrees, period) in [(10.0, 1.641_070), (45.0, 1.703_421), (90.0, 1.933_335), (170.0, 3.995_546)]
        {
            for is_hinge in [false, true] {
                let (mut world, body, joint) = pendulum(sheet, degrees, is_hinge);
                let start = energy(&world, body, GRAVITY);
                let (mut widest, mut drift) = (0.0_f64, 0.0_f64);
                let times = rising(&mut world, 50, |world| {
                    widest = widest.max(gap(world, joint));
                    drift = drift.max((energy(world, body, GRAVITY) - start).abs());
                    center(world, body)[0]
                });
                let name = format!("{} at {degrees:3} degrees", if is_hinge { "hinge" } else { "ball" });
                let found = (times[10] - times[0]) / 10.0;
                sheet.judge(
                    &format!("{name}, period"),
                    (relative(found, period), "relative"),
                    [1.0e-3, 1.0e-2],
                );
                sheet.judge(&format!("{name}, gap"), (widest, "m"), [1.0e-4, 5.0e-4]);
                // Of what there is between hanging and standing.
                sheet.judge(
                    &format!("{name}, energy in 50 s"),
                    (drift / GRAVITY, "relative"),
                    [1.0e-3, 1.0e-2],
                );
            }
        }
    });
}

/// A ball of 1 kg on a slider along x, driven to 1 m by a spring, without gravity.
fn sprung(substeps: u32, spring: Spring) -> (OwnedWorld, BodyHandle) {
    let (mut world, base) = jointed(1, 1, substeps);
    weightless(&mut world);
    let body = massive(&mut world, Pose::IDENTITY, ball(1.0, 0.3));
    let mut def = JointDef::slider([base, body], [Pose::IDENTITY; 2]);
    def.axes[X].drive = Some(Drive::spring(1.0, spring));
    world.create_joint(&def).expect("room");
    (world, body)
}

/// Overshoot, and the time from crest to crest, of a damped swing about 1 that is sampled at 60 Hz.
fn crests(samples: &[f64]) -> (f64, f64) {
    let mut found = Vec::new();
    for (i, w) in samples.windows(3).enumerate() {
        if w[1] > w[0] && w[1] >= w[2] {
            // The parabola through the three.
            let (slope, bend) = (0.5 * (w[2] - w[0]), w[2] - 2.0 * w[1] + w[0]);
            found.push(((i as f64 + 1.0 - slope / bend) / 60.0, w[1] - 0.5 * slope * slope / bend));
        }
    }
    (found[0].1 - 1.0, found[1].0 - found[0].0)
}

/// Positions of implicit Euler on `m x'' = k (1 - x) - c x'` from rest at 0, after each step.
fn implicit_euler(substeps: u32, (stiffness, damping): (f64, f64)) -> Vec<f64> {
    let h = 1.0 / (60.0 * f64::from(substeps));
    let (mut x, mut v) = (0.0, 0.0);
    let mut positions = Vec::new();
    for _ in 0..180 {
        for _ in 0..substeps {
            v = (v + h * stiffness * (1.0 - x)) / (1.0 + h * damping + h * h * stiffness);
            x += h * v;
        }
        positions.push(x);
    }
    positions
}

/// Positions after each of 180 steps.
fn swing((mut world, body): (OwnedWorld, BodyHandle)) -> Vec<f64> {
    (0..180)
        .map(|_| {
            world.step(&mut Serial);
            center(&world, body)[0]
        })
        .collect()
}

#[test]
fn springs_swing_as_their_frequency_says() {
    Case::new("2 Hz spring").run_own(|sheet| {
        let rate = 4.0 * f64::from(PI);
        for substeps in [4, 8, 16] {
            let spring = Spring::Frequency { hertz: 2.0, damping_ratio: 0.1 };
            let found = swing(sprung(substeps, spring));
            let map = implicit_euler(substeps, (rate * rate, 0.2 * rate));
            let off = found.iter().zip(&map).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            sheet.judge(&format!("{substeps:2} substeps, off its own map"), (off, "m"), [1.0e-5, 1.0e-4]);
            let (overshoot, period) = crests(&found);
            println!(
                "2 Hz spring, {substeps} substeps: overshoot {:.2} %, period {period:.6} s",
                100.0 * overshoot
            );
            sheet.judge(
                &format!("{substeps:2} substeps, period"),
                (relative(period, 0.502_519), "relative"),
                [0.01, 0.05],
            );
            // Implicit Euler damps by h w / 2 beside the damper: 5.5 points of overshoot at 4 substeps.
            if substeps >= 8 {
                let error = relative(overshoot, 0.729_2);
                sheet.judge(&format!("{substeps:2} substeps, overshoot"), (error, "relative"), [0.02, 0.05]);
            }
        }
    });
}

#[test]
fn springs_are_as_stiff_as_they_say() {
    Case::new("80 N/m spring").run_own(|sheet| {
        let spring = Spring::Stiffness { stiffness: 80.0, damping: 3.0 };
        let found = swing(sprung(4, spring));
        let map = implicit_euler(4, (80.0, 3.0));
        let off = found.iter().zip(&map).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        sheet.judge("off its own map", (off, "m"), [1.0e-5, 1.0e-4]);
        // A weight of 2 kg on a distance joint of 200 N/m.
        let (mut world, base) = jointed(1, 1, 4);
        let body = massive(&mut world, at(Vec3::new(0.0, 0.0, -1.0)), ball(2.0, 0.2));
        let mut def = JointDef::distance([base, body], [Vec3::ZERO; 2], 0.0, 10.0);
        let stiff = Spring::Stiffness { stiffness: 200.0, damping: 20.0 };
        def.axes[X].drive = Some(Drive::spring(1.0, stiff));
        let joint = world.create_joint(&def).expect("room");
        run(&mut world, 600);
        let sag = coordinate(&world, joint, X) - 1.0;
        sheet.judge(
            "200 N/m under 2 kg, sag",
            (relative(sag, 2.0 * GRAVITY / 200.0), "relative"),
            [1.0e-4, 1.0e-3],
        );
        sheet.judge(
            "200 N/m under 2 kg, force",
            (relative(force(&world, joint)[2], 2.0 * GRAVITY), "relative"),
            [1.0e-5, 1.0e-4],
        );
    });
}

/// A linkage: its bodies, its joints, and its name.
struct Linkage {
    name: String,
    world: OwnedWorld,
    bodies: Vec<BodyHandle>,
    joints: Vec<JointHandle>,
}

fn hinge(world: &mut OwnedWorld, a: (BodyHandle, Pose), b: (BodyHandle, Pose)) -> JointHandle {
    world.create_joint(&JointDef::hinge([a.0, b.0], [a.1, b.1])).expect("room")
}

/// Crank 0.4 m, coupler 1 m, rocker 0.8 m, base 1 m; the crank points up and turns with `spin`, rad/s.
fn four_bar(sheet: &Sheet, spin: f32) -> Linkage {
    let (mut world, base) = sheet.jointed(3, 4);
    let (a, b, d) = (Vec3::ZERO, Vec3::new(0.0, 0.0, 0.4), Vec3::new(1.0, 0.0, 0.0));
    let away = cellstep::math::length(d - b);
    let along = (d - b) / away;
    let x = (1.0 - 0.64 + away * away) / (2.0 * away);
    let c = b + along * x + Vec3::new(-along.z, 0.0, along.x) * (1.0 - x * x).sqrt();
    let bars = [(a, b), (b, c), (c, d)].map(|(from, to)| Bar::new(&mut world, from, to));
    let fixed = |place| (base, Pose::new(place, about_y()));
    let joints = vec![
        hinge(&mut world, fixed(a), bars[0].end(-1.0)),
        hinge(&mut world, bars[0].end(1.0), bars[1].end(-1.0)),
        hinge(&mut world, bars[1].end(1.0), bars[2].end(-1.0)),
        hinge(&mut world, bars[2].end(1.0), fixed(d)),
    ];
    world.set_angular_velocity(bars[0].body, Vec3::new(0.0, spin, 0.0)).expect("dynamic");
    Linkage {
        name: format!("four-bar at {spin:.2} rad/s"),
        world,
        bodies: bars.map(|bar| bar.body).to_vec(),
        joints,
    }
}

/// Crank 0.3 m, rod 1 m, and a piston of 1 kg that slides along x.
fn slider_crank(sheet: &Sheet, spin: f32) -> Linkage {
    let (mut world, base) = sheet.jointed(3, 4);
    let (a, b) = (Vec3::ZERO, Vec3::new(0.0, 0.0, 0.3));
    let c = Vec3::new((1.0_f32 - 0.09).sqrt(), 0.0, 0.0);
    let bars = [(a, b), (b, c)].map(|(from, to)| Bar::new(&mut world, from, to));
    let piston = massive(&mut world, at(c), ball(1.0, 0.1));
    let slide = JointDef::slider([base, piston], [at(c), Pose::IDENTITY]);
    let joints = vec![
        hinge(&mut world, (base, Pose::new(a, about_y())), bars[0].end(-1.0)),
        hinge(&mut world, bars[0].end(1.0), bars[1].end(-1.0)),
        hinge(&mut world, bars[1].end(1.0), (piston, Pose::new(Vec3::ZERO, about_y()))),
        world.create_joint(&slide).expect("room"),
    ];
    world.set_angular_velocity(bars[0].body, Vec3::new(0.0, spin, 0.0)).expect("dynamic");
    let bodies = vec![bars[0].body, bars[1].body, piston];
    Linkage { name: format!("slider-crank at {spin:.2} rad/s"), world, bodies, joints }
}

impl Linkage {
    fn energy(&self, gravity: f64) -> f64 {
        self.bodies.iter().map(|&body| energy(&self.world, body, gravity)).sum()
    }

    /// Runs for a minute; returns the widest gap, metres, and the change of energy over the energy that there is
    /// above the lowest place.
    fn run(&mut self) -> (f64, f64) {
        // The first step makes the velocities of the other bodies.
        self.world.step(&mut Serial);
        let start = self.energy(GRAVITY);
        let (mut widest, mut drift, mut lowest) = (0.0_f64, 0.0_f64, f64::MAX);
        for _ in 0..3600 {
            self.world.step(&mut Serial);
            let now = self.energy(GRAVITY);
            drift = drift.max((now - start).abs());
            lowest = lowest.min(now - self.energy(0.0));
            let slides = |axis: usize| self.joints.len() == 4 && axis == 0;
            for (i, &joint) in self.joints.iter().enumerate() {
                let c = self.world.joint_coordinates(joint).expect("the joint exists");
                // The last joint of a slider-crank is free along x.
                let is_slider = i == 3 && self.name.starts_with("slider");
                let along = if is_slider && slides(0) { 0.0 } else { f64::from(c[0]) };
                widest = widest.max(norm([along, f64::from(c[1]), f64::from(c[2])]));
            }
        }
        let end = self.energy(GRAVITY) - start;
        println!("{}: gap {widest:.2e} m, energy {end:+.3e} of {:.3} J", self.name, start - lowest);
        (widest, drift / (start - lowest))
    }
}

/// Cranks at a turn per second, and at about two.
#[test]
fn linkages_run_for_a_minute() {
    Case::new("linkages").gated_from(Preset::Balanced).run(|sheet| {
        for spin in [2.0 * PI, 12.0] {
            for mut linkage in [four_bar(sheet, spin), slider_crank(sheet, spin)] {
                let (widest, drift) = linkage.run();
                sheet.judge(&format!("{}, gap", linkage.name), (widest, "m"), [1.0e-4, 5.0e-4]);
                sheet.judge(&format!("{}, energy in 60 s", linkage.name), (drift, "relative"), [0.01, 0.05]);
            }
        }
    });
}

/// Balls of 1 kg on ball joints, 1 m apart, under each other, with a heavy last one, for 10 s; gives the worst
/// stretch over the length.
fn stretch(sheet: &Sheet, links: u32, bob: f32) -> f64 {
    let (mut world, base) = sheet.jointed(links, links);
    let (mut above, mut place) = (base, Vec3::ZERO);
    for i in 0..links {
        let mass = if i + 1 == links { ball(bob, 0.5) } else { ball(1.0, 0.3) };
        let body = massive(&mut world, at(Vec3::new(0.0, 0.0, -0.5 - i as f32)), mass);
        let frames = [at(place), at(Vec3::new(0.0, 0.0, 0.5))];
        world.create_joint(&JointDef::ball([above, body], frames)).expect("room");
        (above, place) = (body, Vec3::new(0.0, 0.0, -0.5));
    }
    let length = f64::from(links);
    let mut worst = 0.0_f64;
    for _ in 0..600 {
        world.step(&mut Serial);
        worst = worst.max((-center(&world, above)[2] - (length - 0.5)).abs());
    }
    worst / length
}

#[test]
fn chains_hold() {
    Case::new("hanging chain").run(|sheet| {
        for links in [20, 50] {
            for bob in [1.0, 1000.0] {
                let name = format!("{links} links with {bob} kg, worst stretch over length");
                sheet.judge(
                    &name,
                    (stretch(sheet, links, bob), "relative"),
                    [1.0e-3 / f64::from(links), 0.05],
                );
            }
        }
    });
}

/// A chain that lies level and falls with its weight: the loads on its links are many times what they weigh.
fn swung(sheet: &Sheet, links: u32, bob: f32) -> (f64, f64) {
    let (mut world, base) = sheet.jointed(links, links);
    let (mut last, mut place) = (base, Vec3::ZERO);
    let (mut bodies, mut joints) = (Vec::new(), Vec::new());
    for i in 0..links {
        let mass = if i + 1 == links { ball(bob, 0.5) } else { ball(1.0, 0.3) };
        let body = massive(&mut world, at(Vec3::new(i as f32 + 0.5, 0.0, 0.0)), mass);
        let frames = [at(place), at(Vec3::new(-0.5, 0.0, 0.0))];
        joints.push(world.create_joint(&JointDef::ball([last, body], frames)).expect("room"));
        bodies.push(body);
        (last, place) = (body, Vec3::new(0.5, 0.0, 0.0));
    }
    let sum = |world: &OwnedWorld| bodies.iter().map(|&body| energy(world, body, GRAVITY)).sum::<f64>();
    let (mut widest, mut most) = (0.0_f64, sum(&world));
    for _ in 0..600 {
        world.step(&mut Serial);
        widest = joints.iter().fold(widest, |widest, &joint| widest.max(gap(&world, joint)));
        most = most.max(sum(&world));
    }
    (widest / f64::from(links), most / (GRAVITY * f64::from(bob) * f64::from(links)))
}

#[test]
fn chains_swing() {
    Case::new("swinging chain").run(|sheet| {
        for (links, bob) in [(50, 1000.0), (20, 1.0e4), (20, 1.0e6)] {
            let (gap, gain) = swung(sheet, links, bob);
            let name = format!("{links} links that swing with {bob} kg");
            sheet.judge(&format!("{name}, widest gap over length"), (gap, "relative"), [1.0e-4, 1.0e-2]);
            sheet.judge(
                &format!("{name}, energy gained over that of the fall"),
                (gain, "relative"),
                [1.0e-6, 1.0e-3],
            );
        }
    });
}

/// A disc on a light axle whose foot stands on a ball joint, at 30 degrees, in steady precession:
/// `I1 W^2 cos(t) - I3 w3 W + m g l = 0` with the moment I1 about the foot.
#[test]
fn a_heavy_top_precesses() {
    Case::new("heavy top").gated_from(Preset::Balanced).run(|sheet| {
        let (l, inertia) = (0.5_f64, Vec3::new(0.0225, 0.0225, 0.045));
        let (i1, i3, spin) = (0.0225 + l * l, 0.045, 100.0_f64);
        let (sine, cosine) = (0.5, 0.75_f64.sqrt());
        let root = (i3 * i3 * spin * spin - 4.0 * i1 * cosine * GRAVITY * l).sqrt();
        let precession = (i3 * spin - root) / (2.0 * i1 * cosine);
        {
            let (mut world, base) = sheet.jointed(1, 1);
            let tilt = Rotation::from_axis_angle(Vec3::Y, PI / 6.0);
            let axis = [sine, 0.0, cosine];
            let mass = MassProperties { mass: 1.0, inertia, ..MassProperties::default() };
            let body = massive(&mut world, Pose::new(Vec3::new(0.25, 0.0, 0.5 * cosine as f32), tilt), mass);
            // w = W z + p e3, with w3 = W cos(t) + p.
            let w = plus([0.0, 0.0, precession], axis, spin - precession * cosine).map(|x| x as f32);
            world.set_angular_velocity(body, Vec3::from(w)).expect("dynamic");
            world
                .set_linear_velocity(body, Vec3::new(0.0, (precession * l * sine) as f32, 0.0))
                .expect("dynamic");
            let frames = [Pose::IDENTITY, at(Vec3::new(0.0, 0.0, -0.5))];
            let joint = world.create_joint(&JointDef::ball([base, body], frames)).expect("room");
            let (mut angle, mut last, mut nods, mut widest) = (0.0, 0.0_f64, 0.0_f64, 0.0_f64);
            for _ in 0..600 {
                world.step(&mut Serial);
                let c = center(&world, body);
                let now = c[1].atan2(c[0]);
                angle += (now - last + 3.0).rem_euclid(2.0 * core::f64::consts::PI) - 3.0;
                last = now;
                nods = nods.max((c[2] / l - cosine).abs());
                widest = widest.max(gap(&world, joint));
            }
            println!("{angle:.4} of {:.4} rad, nods {nods:.1e}, gap {widest:.1e}", 10.0 * precession);
            sheet.judge(
                "precession in 10 s",
                (relative(angle, 10.0 * precession), "relative"),
                [1.0e-3, 1.0e-2],
            );
            sheet.judge("nodding", (nods, "cosine"), [1.0e-3, 1.0e-2]);
            sheet.judge("gap", (widest, "m"), [1.0e-4, 1.0e-3]);
            let kept = relative(oracles::body_spin(&world, body)[2], spin);
            sheet.judge("spin kept for 10 s", (kept, "relative"), [1.0e-4, 1.0e-3]);
        }
    });
}

/// A trunk, a head and four limbs of two parts, thrown with a spin; no gravity and nothing to touch.
fn tumbler() -> (OwnedWorld, Vec<BodyHandle>) {
    let (mut world, _) = jointed(10, 9, 4);
    weightless(&mut world);
    let mut random = Random::new(3);
    let boxed = |mass: f32, x: f32, y: f32, z: f32| {
        let square = Vec3::new(y * y + z * z, z * z + x * x, x * x + y * y);
        MassProperties { mass, inertia: square * (mass / 12.0), ..MassProperties::default() }
    };
    let trunk = massive(&mut world, Pose::IDENTITY, boxed(30.0, 0.3, 0.2, 0.6));
    let mut bodies = vec![trunk];
    let head = massive(&mut world, at(Vec3::new(0.0, 0.0, 0.45)), boxed(5.0, 0.2, 0.2, 0.25));
    bodies.push(head);
    let mut neck =
        JointDef::ball([trunk, head], [at(Vec3::new(0.0, 0.0, 0.3)), at(Vec3::new(0.0, 0.0, -0.15))]);
    neck.cone = Some(0.6);
    neck.axes[TURN_X] = Axis::limited(-0.8, 0.8);
    world.create_joint(&neck).expect("room");
    for (x, z) in [(0.2, 0.25), (-0.2, 0.25), (0.12, -0.35), (-0.12, -0.35)] {
        let upper = massive(&mut world, at(Vec3::new(x, 0.0, z - 0.2)), boxed(4.0, 0.1, 0.1, 0.4));
        let lower = massive(&mut world, at(Vec3::new(x, 0.0, z - 0.6)), boxed(3.0, 0.08, 0.08, 0.4));
        let mut shoulder =
            JointDef::ball([trunk, upper], [at(Vec3::new(x, 0.0, z)), at(Vec3::new(0.0, 0.0, 0.2))]);
        shoulder.cone = Some(1.2);
        world.create_joint(&shoulder).expect("room");
        let frames = [at(Vec3::new(0.0, 0.0, -0.2)), at(Vec3::new(0.0, 0.0, 0.2))];
        let mut elbow = JointDef::hinge([upper, lower], frames);
        elbow.axes[TURN_X] = Axis { friction: 0.2, ..Axis::limited(-0.1, 2.2) };
        world.create_joint(&elbow).expect("room");
        bodies.extend([upper, lower]);
    }
    for &body in &bodies {
        let mut vector = |size: f32| {
            Vec3::new(random.between(-size, size), random.between(-size, size), random.between(-size, size))
        };
        world.set_linear_velocity(body, vector(2.0)).expect("dynamic");
        world.set_angular_velocity(body, vector(6.0)).expect("dynamic");
    }
    (world, bodies)
}

fn total(world: &OwnedWorld, bodies: &[BodyHandle]) -> (Wide, Wide) {
    bodies
        .iter()
        .map(|&body| momenta(world, body))
        .fold(([0.0; 3], [0.0; 3]), |sum, (p, l)| (plus(sum.0, p, 1.0), plus(sum.1, l, 1.0)))
}

#[test]
fn joints_conserve_momentum() {
    Case::new("tumbling tree").run(|sheet| {
        {
            let (mut world, bodies) = tumbler();
            let substeps = sheet.settings().substeps;
            let settings = Settings { gravity: Vec3::ZERO, ..sheet.settings() };
            world.set_settings(&settings).expect("in range");
            let (p, l) = total(&world, &bodies);
            let sums = bodies.iter().fold((0.0, 0.0), |sum, &body| {
                let (p, l) = momenta(&world, body);
                (sum.0 + norm(p), sum.1 + norm(l))
            });
            let before: f64 = bodies.iter().map(|&body| energy(&world, body, 0.0)).sum();
            let (mut worst, mut worst_turning, mut most) = (0.0_f64, 0.0_f64, 0.0_f64);
            for _ in 0..600 {
                world.step(&mut Serial);
                let (p_now, l_now) = total(&world, &bodies);
                worst = worst.max(norm(minus(p_now, p)) / sums.0);
                worst_turning = worst_turning.max(norm(minus(l_now, l)) / sums.1);
                most = most.max(bodies.iter().map(|&body| energy(&world, body, 0.0)).sum());
            }
            println!("angular momentum {worst_turning:.2e}, energy {before:.3} to {most:.3} J");
            // Rounding of some 45 impulses a substep on the heaviest body: a random walk, longer with more
            // substeps.
            let steps = f64::from(substeps) / 4.0;
            sheet.judge("momentum in 10 s", (worst, "relative"), [1.0e-6, 1.0e-5 * steps.max(1.0)]);
            sheet.judge("angular momentum in 10 s", (worst_turning, "relative"), [1.0e-5, 1.0e-3]);
            assert!(most <= before, "energy rises from {before} to {most} J");
        }
    });
}

#[test]
fn forces_and_torques_are_those_of_statics() {
    Case::new("forces of joints").run(|sheet| {
        // Three weights under each other: each joint bears what hangs on it.
        let (mut world, base) = sheet.jointed(4, 4);
        let (mut above, mut joints) = (base, Vec::new());
        for i in 0..3 {
            let body =
                massive(&mut world, at(Vec3::new(0.0, 0.0, -1.0 - i as f32)), ball(2.0 + i as f32, 0.2));
            let frames = [at(Vec3::new(0.0, 0.0, -0.5)), at(Vec3::new(0.0, 0.0, 0.5))];
            joints.push(world.create_joint(&JointDef::ball([above, body], frames)).expect("room"));
            above = body;
        }
        run(&mut world, 300);
        for (&joint, weight) in joints.iter().zip([9.0, 7.0, 4.0]) {
            let found = force(&world, joint);
            sheet.judge(
                &format!("hanging weight of {weight} kg"),
                (relative(found[2], weight * GRAVITY), "relative"),
                [1.0e-5, 1.0e-4],
            );
            assert!(norm(torque(&world, joint)) == 0.0, "a ball joint has no torque");
        }
        // A rod of 3 kg and 1 m, held at its end: m g l / 2 about y, and the sum over two rods in a row.
        for kind in ["fixed", "held by a stiff spring"] {
            let (mut world, base) = sheet.jointed(2, 2);
            let mut joints = Vec::new();
            let mut above = (base, Vec3::ZERO);
            for i in 0..2 {
                let body = massive(&mut world, at(Vec3::new(0.5 + i as f32, 0.0, 0.0)), rod(3.0, 1.0));
                let mut def = JointDef::fixed([above.0, body], [at(above.1), at(Vec3::new(-0.5, 0.0, 0.0))]);
                def.spring =
                    (kind != "fixed").then_some(Spring::Frequency { hertz: 60.0, damping_ratio: 2.0 });
                joints.push(world.create_joint(&def).expect("room"));
                above = (body, Vec3::new(0.5, 0.0, 0.0));
            }
            run(&mut world, 600);
            // On B and against the weight: up, so about -y.
            for (&joint, (count, lever)) in joints.iter().zip([(2.0, 2.0), (1.0, 0.5)]) {
                let (f, t) = (force(&world, joint), torque(&world, joint));
                sheet.judge(
                    &format!("cantilever {kind}, force of {count}"),
                    (relative(f[2], 3.0 * count * GRAVITY), "relative"),
                    [1.0e-5, 1.0e-4],
                );
                let marks = if kind == "fixed" { [1.0e-5, 1.0e-4] } else { [1.0e-4, 1.0e-2] };
                sheet.judge(
                    &format!("cantilever {kind}, torque of {count}"),
                    (relative(t[1], -3.0 * lever * GRAVITY), "relative"),
                    marks,
                );
            }
        }
        assert!(mass(&world, above) > 0.0 && norm(velocity(&world, above)) < 1.0e-4);
    });
}
