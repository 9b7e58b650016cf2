//! Split contacts: they carry rigidly, and overlap goes by motion that is no velocity.

use cellstep::math::{Vec3, length};
use cellstep::{BodyDef, BodyHandle, ContactModel, Geometry, Position, Serial, Settings, ShapeDef};
use cellstep_tests::executors::Random;
use cellstep_tests::oracles::{GRAVITY, center, norm, relative, velocity};
use cellstep_tests::worlds::{OwnedWorld, add, ground, run, world};

const CUBE: Geometry = Geometry::Box { half_extents: Vec3::splat(0.5) };

fn split(substeps: u32) -> Settings {
    Settings { contact_model: ContactModel::Split, substeps, ..Settings::default() }
}

/// Unit cubes of these densities on the ground, one exactly on the other, and how far from touching they start.
fn column(settings: &Settings, densities: &[f32], apart: f32) -> (OwnedWorld, Vec<BodyHandle>) {
    let mut world = world(densities.len() as u32 + 1);
    world.set_settings(settings).expect("settings are in range");
    ground(&mut world, 0.6);
    let place = |i: usize| Position::at(Vec3::Z * (0.5 + apart + i as f32 * (1.0 + apart)));
    let cubes = densities.iter().enumerate().map(|(i, &density)| {
        let def = BodyDef { position: place(i), ..BodyDef::default() };
        add(&mut world, &def, &ShapeDef { density, ..ShapeDef::new(CUBE) }).0
    });
    let cubes = cubes.collect();
    (world, cubes)
}

/// Sink of a column's top in millimetres, and the greatest error of a contact's force, as a share of the weight.
fn sink(settings: &Settings, densities: &[f32], steps: u32) -> (f64, f64) {
    let (mut world, cubes) = column(settings, densities, 0.0);
    run(&mut world, steps);
    let mut forces: Vec<f64> = world.contacts().map(|c| f64::from(c.normal_force())).collect();
    assert_eq!(forces.len(), cubes.len(), "one contact below each cube");
    forces.sort_unstable_by(f64::total_cmp);
    let (mut above, mut worst) = (0.0, 0.0_f64);
    for (force, density) in forces.iter().zip(densities.iter().rev()) {
        above += f64::from(*density) * GRAVITY;
        worst = worst.max(relative(*force, above));
    }
    (1.0e3 * (densities.len() as f64 - 0.5 - center(&world, cubes[cubes.len() - 1])[2]), worst)
}

#[test]
fn columns_hardly_sink() {
    // The stiffness law says 25.5 mm, 34.9 mm and, with 8 substeps, 108 mm for soft contacts.
    for (substeps, densities, steps, most) in [
        (4, vec![1000.0; 10], 300, 3.0),
        (4, vec![1000.0, 100_000.0], 600, 1.0),
        (8, vec![1000.0; 40], 600, 20.0),
    ] {
        let (sunk, force) = sink(&split(substeps), &densities, steps);
        println!("{} cubes, {substeps} substeps: sink {sunk:.2} mm, forces {force:.1e}", densities.len());
        assert!(sunk > -0.01 && sunk < most, "{sunk} mm");
        assert!(force < 1.0e-2, "{force}");
    }
}

#[test]
fn ten_thousand_times_the_mass_is_carried() {
    let (mut world, cubes) = column(&split(16), &[1000.0, 1.0e7], 0.0);
    let mut deepest = 0.0_f64;
    for _ in 0..600 {
        world.step(&mut Serial);
        deepest = deepest.max(1.5 - center(&world, cubes[1])[2]);
    }
    let left = 1.5 - center(&world, cubes[1])[2];
    println!("sinks by {deepest:.3} m at most, {left:.3} m at the end");
    assert!(deepest < 0.3 && left < 0.1, "{deepest} m, {left} m");
}

#[test]
fn overlap_goes_without_speed() {
    // Cubes a third of a metre in each other and in the ground.
    let (mut world, cubes) = column(&split(4), &[1000.0; 3], -0.3);
    let mut fastest = 0.0_f64;
    for _ in 0..240 {
        world.step(&mut Serial);
        for &cube in &cubes {
            fastest = fastest.max(velocity(&world, cube)[2]);
        }
    }
    println!("fastest {fastest:.2e} m/s, overlap {:.2} mm", 1.0e3 * world.penetration_max());
    assert!(fastest < 0.02, "{fastest} m/s");
    assert!(world.penetration_max() < 1.0e-3);
    assert!(cubes.iter().all(|&cube| norm(velocity(&world, cube)) < 1.0e-3));
}

#[test]
fn lumps_that_come_apart_keep_their_momentum() {
    let mut world = world(60);
    world.set_settings(&Settings { gravity: Vec3::ZERO, ..split(4) }).expect("in range");
    let mut random = Random::new(9);
    let mut bodies = Vec::new();
    for i in 0..60 {
        let mut number = || random.between(-1.2, 1.2);
        let place = Vec3::new(number(), number(), number());
        let geometry = if i % 2 == 0 { CUBE } else { Geometry::Sphere { radius: 0.4 } };
        let (body, _) = add(
            &mut world,
            &BodyDef { position: Position::at(place), ..BodyDef::default() },
            &ShapeDef::new(geometry),
        );
        world.set_linear_velocity(body, Vec3::new(number(), number(), number())).expect("lives");
        bodies.push(body);
    }
    let sums = |world: &OwnedWorld| {
        bodies.iter().fold((Vec3::ZERO, 0.0), |(sum, sizes), &body| {
            let mass = world.mass_properties(body).expect("lives").mass;
            let momentum = world.linear_velocity(body).expect("lives") * mass;
            (sum + momentum, sizes + length(momentum))
        })
    };
    let (before, size) = sums(&world);
    run(&mut world, 300);
    let error = length(sums(&world).0 - before) / size;
    println!("momentum {error:.1e}, overlap {:.2} mm", 1.0e3 * world.penetration_max());
    assert!(error < 1.0e-6, "{error}");
    assert!(world.penetration_max() < 0.02);
}
