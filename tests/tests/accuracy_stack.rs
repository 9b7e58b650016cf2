//! Standing loads: the stiffness law, forces between stacked boxes, mass ratios.
//!
//! A soft contact of frequency f under the force F between bodies of effective mass m* rests at `F / (m* w^2)`, `w
//! = 2 pi f`; contacts with immovable bodies have twice the frequency. A column of n equal cubes on the ground
//! sinks `(g / w^2) (n (n - 1) + n / 4)`, a mass r on a mass 1 sinks `(g / w^2) (1 + r) (1 + 1/4)`.

use cellstep::config::CONTACT_COUPLING;
use cellstep::math::{Rotation, Vec3};
use cellstep::{BodyDef, BodyHandle, Geometry, Position, Serial, Settings, ShapeDef, ShapeHandle};
use cellstep_tests::executors::Random;
use cellstep_tests::oracles::{GRAVITY, center, judge, norm, relative, velocity};
use cellstep_tests::worlds::{OwnedWorld, add, ground, run, world};

const CUBE: Geometry = Geometry::Box { half_extents: Vec3::splat(0.5) };

/// `g / w^2` for a frequency, Hz.
fn compliance(frequency: f64) -> f64 {
    GRAVITY / (core::f64::consts::TAU * frequency).powi(2)
}

/// Frequency of contacts that follow the substep rate, Hz.
fn coupled(substeps: u32) -> f64 {
    f64::from(CONTACT_COUPLING) * 60.0 * f64::from(substeps)
}

/// Unit cubes of the densities on the ground, one exactly on the other.
fn column(settings: &Settings, densities: &[f32]) -> (OwnedWorld, Vec<(BodyHandle, ShapeHandle)>) {
    let mut world = world(densities.len() as u32 + 1);
    world.set_settings(settings).expect("settings are in range");
    ground(&mut world, 0.6);
    let mut cubes = Vec::new();
    for (i, &density) in densities.iter().enumerate() {
        let def =
            BodyDef { position: Position::at(Vec3::new(0.0, 0.0, 0.5 + i as f32)), ..BodyDef::default() };
        cubes.push(add(&mut world, &def, &ShapeDef { density, ..ShapeDef::new(CUBE) }));
    }
    (world, cubes)
}

/// How far the column's top sank after a time, metres. It must have come to rest.
fn sink(settings: &Settings, densities: &[f32], steps: u32) -> f64 {
    let (mut world, cubes) = column(settings, densities);
    run(&mut world, steps);
    let top = cubes[cubes.len() - 1].0;
    let speed = norm(velocity(&world, top));
    assert!(speed < 1.0e-3, "the column still moves at {speed} m/s");
    densities.len() as f64 - 0.5 - center(&world, top)[2]
}

#[test]
fn columns_sink_by_the_stiffness_law() {
    for (cubes, substeps, frequency, steps) in [
        (10_u32, 4_u32, 0.0_f32, 300),
        (10, 8, 0.0, 300),
        (10, 16, 0.0, 300),
        (10, 8, 30.0, 300),
        (10, 16, 30.0, 300),
        // So high a column is an unstable balance: kept straight it stands for ten seconds, and buckles then.
        (40, 4, 0.0, 300),
    ] {
        let settings = Settings { substeps, contact_frequency: frequency, refine: 1, ..Settings::default() };
        let sunk = sink(&settings, &vec![1000.0; cubes as usize], steps);
        let hertz = if frequency > 0.0 { f64::from(frequency) } else { coupled(substeps) };
        let n = f64::from(cubes);
        let law = compliance(hertz) * (n * (n - 1.0) + n / 4.0);
        let name = format!("column of {cubes}, N={substeps}, {hertz} Hz, sinks {:.2} mm", 1000.0 * sunk);
        judge(&name, relative(sunk, law), [1.0e-3, 1.0e-2]);
    }
}

#[test]
fn a_hundredfold_mass_on_top_sinks_by_the_law() {
    for substeps in [4, 16] {
        let settings = Settings { substeps, refine: 1, ..Settings::default() };
        let sunk = sink(&settings, &[1000.0, 100_000.0], 600);
        let law = compliance(coupled(substeps)) * 101.0 * 1.25;
        let name = format!("100:1 on top, N={substeps}, sinks {:.2} mm", 1000.0 * sunk);
        judge(&name, relative(sunk, law), [1.0e-3, 1.0e-2]);
    }
}

/// Greatest error of a force between neighbours against the weight above, relative.
fn force_error(world: &OwnedWorld, cubes: &[(BodyHandle, ShapeHandle)]) -> f64 {
    let mut worst = 0.0_f64;
    let mut found = 0;
    for contact in world.contacts() {
        let upper = cubes.iter().position(|cube| cube.1 == contact.shapes[1]).expect("a cube is above");
        let weight = (cubes.len() - upper) as f64 * 1000.0 * GRAVITY;
        worst = worst.max(relative(f64::from(contact.normal_force()), weight));
        found += 1;
    }
    assert_eq!(found, cubes.len(), "one contact below each cube");
    worst
}

#[test]
fn a_stack_of_ten_stands_and_carries_its_weight() {
    let (mut world, cubes) = column(&Settings::default(), &[1000.0; 10]);
    let (mut drift, mut force) = (0.0_f64, 0.0_f64);
    for step in 1..=600 {
        world.step(&mut Serial);
        for cube in &cubes {
            let p = center(&world, cube.0);
            drift = drift.max(p[0].hypot(p[1]));
        }
        if step >= 180 {
            force = force.max(force_error(&world, &cubes));
        }
    }
    judge("stack of ten, drift in 10 s, m", drift, [1.0e-4, 1.0e-3]);
    judge("stack of ten, forces from 3 s on", force, [1.0e-3, 1.0e-2]);
}

#[test]
fn a_crooked_stack_of_ten_stands_and_carries_its_weight() {
    let mut world = world(11);
    ground(&mut world, 0.6);
    let mut random = Random::new(5);
    let mut cubes = Vec::new();
    for i in 0..10 {
        let aside = Vec3::new(random.between(-0.05, 0.05), random.between(-0.05, 0.05), 0.5 + i as f32);
        let def = BodyDef {
            position: Position::at(aside),
            rotation: Rotation::from_axis_angle(Vec3::Z, random.between(-0.3, 0.3)),
            ..BodyDef::default()
        };
        cubes.push(add(&mut world, &def, &ShapeDef::new(CUBE)));
    }
    run(&mut world, 480);
    let settled: Vec<_> = cubes.iter().map(|cube| center(&world, cube.0)).collect();
    let (mut drift, mut force) = (0.0_f64, 0.0_f64);
    for _ in 480..840 {
        world.step(&mut Serial);
        force = force.max(force_error(&world, &cubes));
        for (cube, from) in cubes.iter().zip(&settled) {
            let p = center(&world, cube.0);
            drift = drift.max((p[0] - from[0]).hypot(p[1] - from[1]));
        }
    }
    judge("crooked stack of ten, drift from 8 to 14 s, m", drift, [1.0e-4, 1.0e-3]);
    judge("crooked stack of ten, forces from 8 s on", force, [1.0e-3, 1.0e-2]);
}
