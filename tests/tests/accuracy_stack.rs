//! Standing loads: the stiffness law, forces between stacked boxes, mass ratios.
//!
//! A soft contact of frequency f under the force F between bodies of effective mass m* rests at `F / (m* w^2)`, `w
//! = 2 pi f`; contacts with immovable bodies have twice the frequency. A column of n equal cubes on the ground
//! sinks `(g / w^2) (n (n - 1) + n / s^2)`, a mass r on a mass 1 sinks `(g / w^2) (1 + r) (1 + 1 / s^2)`, s being
//! how many times stiffer in frequency contacts with the ground are.

use cellstep::config::{CONTACT_COUPLING, STATIC_STIFFNESS};
use cellstep::math::{Rotation, Vec3};
use cellstep::{
    BodyDef, BodyHandle, ContactModel, Geometry, Position, Preset, Serial, Settings, ShapeDef, ShapeHandle,
};
use cellstep_tests::executors::Random;
use cellstep_tests::oracles::{GRAVITY, center, norm, relative, velocity};
use cellstep_tests::score::Case;
use cellstep_tests::worlds::{OwnedWorld, add, ground, run, world};

const CUBE: Geometry = Geometry::Box { half_extents: Vec3::splat(0.5) };

/// `g / w^2` for a frequency, Hz.
fn compliance(frequency: f64) -> f64 {
    GRAVITY / (core::f64::consts::TAU * frequency).powi(2)
}

/// How much more a contact with the ground gives than others.
fn on_ground() -> f64 {
    f64::from(STATIC_STIFFNESS).powi(-2)
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

/// Soft contacts that follow the substep rate.
fn soft(substeps: u32) -> Settings {
    Settings { substeps, contact_model: ContactModel::Soft, refine: 1, ..Settings::default() }
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
    Case::new("stiffness law of soft contacts").run_own(|sheet| {
        for (cubes, substeps, frequency, steps) in [
            (10_u32, 4_u32, 0.0_f32, 300),
            (10, 8, 0.0, 300),
            (10, 16, 0.0, 300),
            (10, 8, 30.0, 300),
            (10, 16, 30.0, 300),
            // So high a column is an unstable balance: kept straight it stands for ten seconds, and buckles then.
            (40, 4, 0.0, 300),
        ] {
            let settings = Settings { contact_frequency: frequency, ..soft(substeps) };
            let sunk = sink(&settings, &vec![1000.0; cubes as usize], steps);
            let hertz = if frequency > 0.0 { f64::from(frequency) } else { coupled(substeps) };
            let n = f64::from(cubes);
            let law = compliance(hertz) * (n * (n - 1.0) + n * on_ground());
            let kind = if frequency > 0.0 { "at 30 Hz" } else { "coupled" };
            let name = format!("column of {cubes}, {substeps:2} substeps, {kind}");
            println!("{name} ({hertz:.1} Hz) sinks {:.2} mm", 1000.0 * sunk);
            sheet.judge(&name, (relative(sunk, law), "relative"), [1.0e-3, 1.0e-2]);
        }
    });
}

#[test]
fn a_hundredfold_mass_on_top_sinks_by_the_law() {
    Case::new("stiffness law under 100:1").run_own(|sheet| {
        for substeps in [4, 16] {
            let sunk = sink(&soft(substeps), &[1000.0, 100_000.0], 600);
            let law = compliance(coupled(substeps)) * 101.0 * (1.0 + on_ground());
            println!("100:1 on top, {substeps} substeps, sinks {:.2} mm", 1000.0 * sunk);
            let name = format!("{substeps:2} substeps");
            sheet.judge(&name, (relative(sunk, law), "relative"), [1.0e-3, 1.0e-2]);
        }
    });
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
    Case::new("stack of 10").run(|sheet| {
        let (mut world, cubes) = column(&sheet.settings(), &[1000.0; 10]);
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
        sheet.judge("drift in 10 s", (drift, "m"), [1.0e-4, 1.0e-3]);
        sheet.judge("forces from 3 s on", (force, "relative"), [1.0e-3, 1.0e-2]);
        sheet.score("sink", (9.5 - center(&world, cubes[9].0)[2], "m"));
    });
}

#[test]
fn a_crooked_stack_of_ten_stands_and_carries_its_weight() {
    Case::new("crooked stack of 10").gated_from(Preset::Balanced).run(|sheet| {
        let mut world = sheet.world(11);
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
        sheet.judge("drift from 8 to 14 s", (drift, "m"), [1.0e-4, 1.0e-3]);
        sheet.judge("forces from 8 s on", (force, "relative"), [1.0e-3, 1.0e-2]);
    });
}

/// What a column does in ten seconds: the worst force from 8 s on, how far it went aside, how far its top sank.
fn tall(settings: &Settings, cubes: u32) -> (f64, f64, f64) {
    let (mut world, cubes) = column(settings, &vec![1000.0; cubes as usize]);
    let (mut aside, mut force) = (0.0_f64, 0.0_f64);
    for step in 1..=600 {
        world.step(&mut Serial);
        for cube in &cubes {
            let p = center(&world, cube.0);
            aside = aside.max(p[0].hypot(p[1]));
        }
        if step >= 480 && aside < 1.0 {
            force = force.max(force_error(&world, &cubes));
        }
    }
    let sunk = cubes.len() as f64 - 0.5 - center(&world, cubes[cubes.len() - 1].0)[2];
    // The forces of a heap are those of nothing.
    (if aside < 1.0 { force } else { 1.0 }, aside, sunk)
}

#[test]
fn a_stack_of_forty_carries_its_weight() {
    Case::new("stack of 40").gated_from(Preset::Balanced).run(|sheet| {
        let (force, aside, sunk) = tall(&sheet.settings(), 40);
        sheet.judge("forces from 8 s on", (force, "relative"), [1.0e-3, 1.0e-2]);
        sheet.judge("drift in 10 s", (aside, "m"), [1.0e-3, 1.0e-2]);
        let gate = if sheet.preset() >= Preset::Accurate { 0.03 } else { 0.1 };
        sheet.judge("sink", (sunk, "m"), [0.01, gate]);
    });
}

#[test]
fn a_stack_of_a_hundred_is_scored() {
    Case::new("stack of 100").run(|sheet| {
        let (force, aside, sunk) = tall(&sheet.settings(), 100);
        sheet.score("forces from 8 s on", (force, "relative"));
        sheet.score("drift in 10 s", (aside, "m"));
        sheet.score("sink", (sunk, "m"));
    });
}

/// A heavy cube on a light one for ten seconds: how deep its bottom came below the light one's top, and how fast
/// anything flew.
fn weigh(settings: &Settings, ratio: f32) -> (f64, f64) {
    let (mut world, cubes) = column(settings, &[1000.0, 1000.0 * ratio]);
    let (mut deepest, mut fastest) = (0.0_f64, 0.0_f64);
    for _ in 0..600 {
        world.step(&mut Serial);
        deepest = deepest.max(1.5 - center(&world, cubes[1].0)[2]);
        for cube in &cubes {
            fastest = fastest.max(norm(velocity(&world, cube.0)));
        }
    }
    (deepest, fastest)
}

#[test]
fn heavy_cubes_stand_on_light_ones() {
    for (name, ratio, stands) in [
        ("mass ratio 1e1", 1.0e1, Preset::Fast),
        ("mass ratio 1e2", 1.0e2, Preset::Fast),
        ("mass ratio 1e3", 1.0e3, Preset::Accurate),
        ("mass ratio 1e4", 1.0e4, Preset::Exact),
    ] {
        Case::new(name).gated_from(stands).run(|sheet| {
            let (deepest, fastest) = weigh(&sheet.settings(), ratio);
            sheet.judge("deepest", (deepest, "m"), [0.01, 0.3]);
            sheet.judge("fastest", (fastest, "m/s"), [0.5, 3.0]);
        });
    }
}

/// What is lost is pushed aside, but nothing is thrown.
#[test]
fn the_greatest_masses_eject_nothing() {
    for (name, ratio) in [("mass ratio 1e5", 1.0e5), ("mass ratio 1e6", 1.0e6)] {
        Case::new(name).run(|sheet| {
            let (deepest, fastest) = weigh(&sheet.settings(), ratio);
            sheet.score("deepest", (deepest, "m"));
            // The heavy cube falls by one metre at most: 4.4 m/s, and the light one may be squeezed out.
            sheet.judge("fastest", (fastest, "m/s"), [4.5, 20.0]);
        });
    }
}
