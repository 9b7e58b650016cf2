//! Rays, shape casts, overlaps and closest points per second, in cellstep and, with `--features peers`, rays in
//! `rapier3d`.
//!
//! `cargo bench -p cellstep-tests --features peers --bench queries`
//!
//! A cube of 8,000 boxes, balls and capsules at random places and turns, and the same rays for both: one meets
//! something after a few metres. One thread; medians of [`ROUNDS`] rounds in turns. Nothing is asserted but
//! that both engines hit about equally often.

#[cfg(feature = "peers")]
mod rapier;

use cellstep::math::{Rotation, Vec3};
use cellstep::{
    BodyDef, BodyKind, Capacities, Geometry, Position, Probe, QueryFilter, QueryShape, Ray, Region, Serial,
    ShapeCast, ShapeDef,
};
use cellstep_tests::executors::Random;
use cellstep_tests::mixed::Draw;
use cellstep_tests::worlds::{OwnedWorld, world_with};
use std::time::Instant;

/// Shapes of the scene.
const SHAPES: u32 = 8000;
/// Half of the cube's edge, metres.
const REACH: f32 = 30.0;
/// Queries of a round.
const QUERIES: usize = 20_000;
const ROUNDS: usize = 9;

/// A body of one shape.
struct Thing {
    place: Vec3,
    rotation: Rotation,
    geometry: Geometry,
}

fn things(random: &mut Random) -> Vec<Thing> {
    let mut thing = |i: u32| {
        let geometry = match i % 3 {
            0 => Geometry::Box { half_extents: Vec3::new(0.5, 0.3, 0.7) },
            1 => Geometry::Sphere { radius: 0.5 },
            _ => Geometry::Capsule { half_height: 0.5, radius: 0.3 },
        };
        Thing { place: random.vector(REACH), rotation: random.rotation(), geometry }
    };
    (0..SHAPES).map(&mut thing).collect()
}

fn filled(things: &[Thing]) -> OwnedWorld {
    let mut world = world_with(Capacities::for_bodies(SHAPES));
    for thing in things {
        let def = BodyDef { rotation: thing.rotation, ..BodyDef::new(BodyKind::Dynamic, thing.place) };
        let body = world.create_body(&def).expect("room");
        world.create_shape(body, &ShapeDef::new(thing.geometry)).expect("room");
    }
    world
}

/// Queries per second, the median, and how many found something.
fn measure(name: &str, mut round: impl FnMut() -> usize) {
    let mut times = Vec::new();
    let mut hits = 0;
    for _ in 0..ROUNDS {
        let start = Instant::now();
        hits = std::hint::black_box(round());
        times.push(start.elapsed().as_secs_f64());
    }
    times.sort_by(f64::total_cmp);
    let each = times[ROUNDS / 2] / QUERIES as f64;
    println!(
        "{name:<36} {:>7.2} us each, {:>9.0} per second, {hits} of {QUERIES} hit",
        each * 1.0e6,
        1.0 / each
    );
}

fn main() {
    let mut random = Random::new(1);
    let things = things(&mut random);
    let rays: Vec<(Vec3, Vec3)> = (0..QUERIES).map(|_| (random.vector(REACH), random.vector(40.0))).collect();
    let mut world = filled(&things);
    let start = Instant::now();
    world.queries();
    println!("{SHAPES} shapes: trees built in {:.2} ms", start.elapsed().as_secs_f64() * 1.0e3);
    world.step(&mut Serial);
    let start = Instant::now();
    world.queries();
    println!(
        "{SHAPES} shapes: boxes renewed after a step in {:.2} ms",
        start.elapsed().as_secs_f64() * 1.0e3
    );

    let mut world = filled(&things);
    let queries = world.queries();
    let all = &QueryFilter::ALL;
    let ray = |&(origin, translation): &(Vec3, Vec3)| Ray { origin: Position::at(origin), translation };
    let own: Vec<Ray> = rays.iter().map(ray).collect();
    let shape = |ray: &Ray| QueryShape {
        geometry: Geometry::Box { half_extents: Vec3::splat(0.3) },
        position: ray.origin,
        rotation: Rotation::IDENTITY,
    };
    measure("cellstep: nearest hit of a ray", || {
        own.iter().filter(|ray| queries.cast_ray(ray, all).expect("good").is_some()).count()
    });
    #[cfg(feature = "peers")]
    rapier::measure(&things, &rays);
    measure("cellstep: cast of a box", || {
        let cast = |ray: &&Ray| {
            let cast = ShapeCast { shape: shape(ray), translation: ray.translation };
            queries.cast_shape(&cast, all).expect("good").is_some()
        };
        own.iter().filter(cast).count()
    });
    measure("cellstep: overlap of a box", || {
        let overlaps = |ray: &&Ray| queries.overlap(&Region::Shape(shape(ray)), all).expect("good").is_some();
        own.iter().filter(overlaps).count()
    });
    measure("cellstep: closest point within 3 m", || {
        let probe = |ray: &&Ray| {
            let probe = Probe { position: ray.origin, max_distance: 3.0 };
            queries.closest_point(&probe, all).expect("good").is_some()
        };
        own.iter().filter(probe).count()
    });
}
