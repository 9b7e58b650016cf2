//! Free flight and free rotation against closed forms: the integrator alone.
//!
//! "Exact for the scheme" means that the closed form is that of symplectic Euler with the substep h, so what is
//! left is rounding.

use cellstep::math::{Rotation, Vec3};
use cellstep::{BodyDef, BodyHandle, Geometry, MassProperties, Serial, ShapeDef};
use cellstep_tests::oracles::{
    self, GRAVITY, apex, body_spin, center, cross, crossing, dot, minus, norm, plus, relative, spin_energy,
    spin_momentum, velocity,
};
use cellstep_tests::score::{Case, Sheet};
use cellstep_tests::worlds::{OwnedWorld, add, run};

/// A world without gravity and a body in it.
fn floating(sheet: &Sheet, def: &BodyDef, geometry: Geometry) -> (OwnedWorld, BodyHandle) {
    let mut world = sheet.floating(1);
    let (body, _) = add(&mut world, def, &ShapeDef::new(geometry));
    (world, body)
}

fn ball() -> ShapeDef {
    ShapeDef::new(Geometry::Sphere { radius: 0.5 })
}

#[test]
fn free_fall_is_that_of_the_scheme() {
    Case::new("free fall 2 s").run(|sheet| {
        let mut world = sheet.world(1);
        let (body, _) = add(&mut world, &BodyDef::default(), &ball());
        run(&mut world, 120);
        let n = 120.0 * f64::from(sheet.settings().substeps);
        let expected = -GRAVITY * sheet.substep().powi(2) * n * (n + 1.0) / 2.0;
        assert!(n != 480.0 || (expected + 19.660875).abs() < 1.0e-9);
        sheet.judge("height", ((center(&world, body)[2] - expected).abs(), "m"), [2.0e-5, 1.0e-4]);
    });
}

#[test]
fn a_projectile_keeps_h() {
    Case::new("projectile").run(|sheet| {
        let mut world = sheet.world(1);
        let def = BodyDef { linear_velocity: Vec3::new(10.0, 0.0, 15.0), ..BodyDef::default() };
        let (body, _) = add(&mut world, &def, &ball());
        let (h, substeps) = (sheet.substep(), sheet.settings().substeps);
        let start = apex(0.0, 15.0, h);
        let (mut worst, mut worst_way) = (0.0_f64, 0.0_f64);
        for step in 1..=180 {
            world.step(&mut Serial);
            let (p, v) = (center(&world, body), velocity(&world, body));
            let n = f64::from(substeps * step);
            let height = n * h * 15.0 - GRAVITY * h * h * n * (n + 1.0) / 2.0;
            worst = worst.max(relative(apex(p[2], v[2], h), start));
            worst_way = worst_way.max((p[0] - 10.0 * n * h).abs().max((p[2] - height).abs()) / 30.0);
            assert_eq!(p[1], 0.0);
        }
        // Each substep rounds the velocity once, and all of them alike while it stays in its binade: the gates are
        // those of four substeps per step, and grow with their number.
        let marks = [1.0e-6, 1.0e-5 * (f64::from(substeps) / 4.0).max(1.0)];
        sheet.judge("H", (worst, "relative"), marks);
        sheet.judge("place over its range", (worst_way, "relative"), marks);
    });
}

#[test]
fn linear_damping_is_that_of_the_scheme() {
    let def =
        BodyDef { linear_velocity: Vec3::new(10.0, 0.0, 0.0), linear_damping: 0.5, ..BodyDef::default() };
    Case::new("linear damping").run(|sheet| {
        let (mut world, body) = floating(sheet, &def, Geometry::Sphere { radius: 0.5 });
        run(&mut world, 300);
        let h = sheet.substep();
        let expected = 10.0 * (1.0 + 0.5 * h).powf(-5.0 / h);
        let error = relative(velocity(&world, body)[0], expected);
        sheet.judge("speed after 5 s", (error, "relative"), [1.0e-5, 1.0e-4]);
    });
}

/// Spins a body for 60 s and returns the greatest changes of energy and of the angular velocity, relative.
fn spin_for_a_minute(sheet: &Sheet, geometry: Geometry, spin: Vec3) -> (f64, f64) {
    let def = BodyDef { rotation: Rotation::new(0.2, -0.5, 0.4, 0.7).normalized(), ..BodyDef::default() };
    let in_world = def.rotation.rotate(spin);
    let (mut world, body) = floating(sheet, &BodyDef { angular_velocity: in_world, ..def }, geometry);
    let (energy, before) = (spin_energy(&world, body), oracles::spin(&world, body));
    let (mut worst, mut worst_spin) = (0.0_f64, 0.0_f64);
    for _ in 0..3600 {
        world.step(&mut Serial);
        worst = worst.max(relative(spin_energy(&world, body), energy));
        let change = norm(minus(oracles::spin(&world, body), before)) / norm(before);
        worst_spin = worst_spin.max(change);
    }
    (worst, worst_spin)
}

#[test]
fn spin_about_a_stable_axis_stays() {
    let geometry = Geometry::Box { half_extents: Vec3::new(0.5, 0.3, 0.1) };
    Case::new("box that spins 60 s").run(|sheet| {
        for (name, axis) in [("longest", Vec3::X), ("shortest", Vec3::Z)] {
            let (energy, spin) = spin_for_a_minute(sheet, geometry, axis * 10.0);
            sheet.judge(&format!("{name} axis, energy"), (energy, "relative"), [1.0e-6, 1.0e-4]);
            sheet.judge(&format!("{name} axis, angular velocity"), (spin, "relative"), [1.0e-4, 1.0e-2]);
        }
    });
}

#[test]
fn a_ball_at_a_thousand_radians_per_second_stays() {
    Case::new("ball at 1e3 rad/s 60 s").run(|sheet| {
        let spin = Vec3::new(600.0, 0.0, 800.0);
        let (energy, spin) = spin_for_a_minute(sheet, Geometry::Sphere { radius: 0.5 }, spin);
        sheet.judge("energy", (energy, "relative"), [1.0e-6, 1.0e-4]);
        sheet.judge("angular velocity", (spin, "relative"), [1.0e-6, 1.0e-4]);
    });
}

/// The difference of two angles, radians, to the nearest turn.
fn angle_between(a: f64, b: f64) -> f64 {
    let turn = core::f64::consts::TAU;
    let d = a - b;
    (d - turn * (d / turn).round()).abs()
}

#[test]
fn a_symmetric_top_precesses() {
    let inertia = Vec3::new(1.0, 1.0, 2.0);
    let mass = MassProperties { mass: 1.0, inertia, ..MassProperties::default() };
    let def = BodyDef { mass: Some(mass), angular_velocity: Vec3::new(1.0, 0.0, 5.0), ..BodyDef::default() };
    Case::new("symmetric top").run(|sheet| {
        let (mut world, body) = floating(sheet, &def, Geometry::Sphere { radius: 0.5 });
        run(&mut world, 600);
        let w = body_spin(&world, body);
        let error = angle_between(w[1].atan2(w[0]), 50.0);
        sheet.judge("body precession in 10 s", (error, "rad"), [0.01, 0.1]);
        // The body's axis turns about L at |L| / I1.
        let momentum = [1.0, 0.0, 10.0];
        let along = momentum.map(|x| x / norm(momentum));
        let flat = |v| plus(v, along, -dot(v, along));
        let (from, to) =
            (flat([0.0, 0.0, 1.0]), flat(oracles::turned(world.rotation(body).unwrap(), [0.0, 0.0, 1.0])));
        let angle = dot(cross(from, to), along).atan2(dot(from, to));
        let error = angle_between(angle, 10.0 * norm(momentum));
        sheet.judge("space precession in 10 s", (error, "rad"), [0.01, 0.1]);
    });
}

#[test]
fn a_tumbling_box_flips_in_time() {
    let geometry = Geometry::Box { half_extents: Vec3::new(0.5, 0.3, 0.1) };
    let def = BodyDef { angular_velocity: Vec3::new(0.05, 10.0, 0.05), ..BodyDef::default() };
    Case::new("tumbling box").run(|sheet| {
        let (mut world, body) = floating(sheet, &def, geometry);
        let (energy, momentum) = (spin_energy(&world, body), spin_momentum(&world, body));
        let (mut worst, mut worst_momentum) = (0.0_f64, 0.0_f64);
        let mut samples = vec![10.0];
        for _ in 0..600 {
            world.step(&mut Serial);
            samples.push(body_spin(&world, body)[1]);
            worst = worst.max(relative(spin_energy(&world, body), energy));
            let change = norm(minus(spin_momentum(&world, body), momentum)) / norm(momentum);
            worst_momentum = worst_momentum.max(change);
        }
        let first = samples.iter().position(|&w| w < 0.0).expect("the box flips");
        let near = core::array::from_fn(|i| samples[first - 2 + i]);
        let time = (first as f64 - 2.0 + crossing(near)) / 60.0;
        sheet.judge("first flip", ((time - 1.271_927_465_1).abs(), "s"), [0.005, 0.05]);
        sheet.judge("energy in 10 s", (worst, "relative"), [1.0e-5, 1.0e-4]);
        sheet.judge("momentum in 10 s", (worst_momentum, "relative"), [1.0e-6, 1.0e-5]);
    });
}
