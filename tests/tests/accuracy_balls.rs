//! SimBenchmark's "666": 216 balls dropped on a frictionless plane.
//!
//! A cube of 6 x 6 x 6 balls of 10 kg and 0.1 m radius, 0.21 m apart, each moved by up to 1 mm per axis, falls and
//! spreads without friction and without bounce for 10 s. The error is the mean over the steps of the sum of the
//! squares of all overlaps, in m2 (Hwangbo, Lee, Hutter, Per-contact iteration method for solving contact dynamics,
//! 2018, and the benchmark that came with it, which tells 1.35e-4 for its own engine at 1 ms and 1.5e-2 at 10 ms).

use cellstep::math::Vec3;
use cellstep::{
    BodyDef, BodyHandle, Capacities, Geometry, MassProperties, Position, Serial, Settings, ShapeDef,
};
use cellstep_tests::executors::Random;
use cellstep_tests::oracles::center;
use cellstep_tests::score::{Case, Sheet};
use cellstep_tests::worlds::{OwnedWorld, add, ground};

const RADIUS: f32 = 0.1;
const EDGE: u32 = 6;

fn balls(sheet: &Sheet, dt: f32) -> (OwnedWorld, Vec<BodyHandle>) {
    let count = EDGE * EDGE * EDGE;
    let mut world = sheet.world_with(Capacities { pairs: 6000, ..Capacities::for_bodies(count + 1) });
    world.set_settings(&Settings { dt, ..sheet.settings() }).expect("in range");
    ground(&mut world, 0.0);
    let mut random = Random::new(666);
    let (mass, inertia) = (10.0, Vec3::splat(0.4 * 10.0 * RADIUS * RADIUS));
    let mass = Some(MassProperties { mass, inertia, ..MassProperties::default() });
    let shape =
        ShapeDef { friction: 0.0, restitution: 0.0, ..ShapeDef::new(Geometry::Sphere { radius: RADIUS }) };
    let bodies = (0..count).map(|i| {
        let cell = Vec3::new((i % EDGE) as f32, (i / EDGE % EDGE) as f32, (i / EDGE / EDGE) as f32);
        let mut jitter = || random.between(0.0, 1.0e-3);
        let aside = Vec3::new(jitter(), jitter(), jitter());
        let position = Position::at(cell * 0.21 + aside + Vec3::Z * RADIUS);
        add(&mut world, &BodyDef { mass, position, ..BodyDef::default() }, &shape).0
    });
    let bodies = bodies.collect();
    (world, bodies)
}

/// Sum of the squares of all overlaps, m2, by the centers alone.
fn overlap(world: &OwnedWorld, bodies: &[BodyHandle]) -> f64 {
    let radius = f64::from(RADIUS);
    let places: Vec<_> = bodies.iter().map(|&body| center(world, body)).collect();
    let mut sum = 0.0;
    for (i, a) in places.iter().enumerate() {
        sum += (radius - a[2]).max(0.0).powi(2);
        for b in &places[i + 1..] {
            let apart: f64 = (0..3).map(|k| (a[k] - b[k]).powi(2)).sum();
            if apart < 4.0 * radius * radius {
                sum += (2.0 * radius - apart.sqrt()).powi(2);
            }
        }
    }
    sum
}

/// The mean over all steps.
fn fall(sheet: &Sheet, dt: f32, steps: u32) -> f64 {
    let (mut world, bodies) = balls(sheet, dt);
    let mut sum = 0.0;
    for _ in 0..steps {
        let report = world.step(&mut Serial);
        assert_eq!((report.dropped, report.quarantined), (0, 0));
        sum += overlap(&world, &bodies);
    }
    sum / f64::from(steps)
}

#[test]
fn balls_hardly_overlap_at_ten_milliseconds() {
    Case::new("216 balls at 10 ms").run(|sheet| {
        sheet.judge("squared overlap", (fall(sheet, 0.01, 1000), "m2"), [1.5e-3, 1.5e-2]);
    });
}

#[test]
fn balls_hardly_overlap_at_one_millisecond() {
    Case::new("216 balls at 1 ms, first 0.5 s").run(|sheet| {
        sheet.judge("squared overlap", (fall(sheet, 0.001, 500), "m2"), [1.35e-5, 1.35e-4]);
    });
    // Ten seconds take half a minute for all presets.
    if std::env::var_os("LONG").is_none_or(|value| value != "1") {
        println!("skipped: the other 9.5 s; LONG=1 runs them");
        return;
    }
    Case::new("216 balls at 1 ms").run(|sheet| {
        sheet.judge("squared overlap", (fall(sheet, 0.001, 10_000), "m2"), [1.35e-5, 1.35e-4]);
    });
}
