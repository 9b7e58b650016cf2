//! The same scenes in cellstep and, with `--features peers`, in `rapier3d`: time beside accuracy.
//!
//! `cargo bench -p cellstep-tests --features peers --bench peers`
//!
//! Equal physics: unit boxes of 1000 kg, friction 0.6, no damping, sleep off, dt 1/60, each engine's own default
//! solver settings. The engines take turns, a run of steps each, in one process; the medians of the runs are
//! compared.

use std::time::Instant;

use cellstep::math::Vec3;
use cellstep::{BodyDef, BodyKind, Geometry, Pool, Serial, ShapeDef, Timed};
use cellstep_tests::worlds::{OwnedWorld, add, ground, world};

/// Boxes at the base of the pyramid.
const BASE: u32 = 100;
/// Steps of a run.
const RUN: u32 = 50;
/// Runs of each engine.
const RUNS: usize = 4;

/// Centers of the boxes of a pyramid, metres.
fn pyramid() -> impl Iterator<Item = Vec3> {
    (0..BASE).flat_map(|row| {
        (0..BASE - row)
            .map(move |i| Vec3::new(i as f32 + 0.5 * row as f32 - 0.5 * BASE as f32, 0.0, 0.5 + row as f32))
    })
}

fn own_pyramid() -> OwnedWorld {
    let mut world = world(BASE * (BASE + 1) / 2 + 1);
    ground(&mut world, 0.6);
    for center in pyramid() {
        let shape = ShapeDef::new(Geometry::Box { half_extents: Vec3::splat(0.5) });
        add(&mut world, &BodyDef::new(BodyKind::Dynamic, center), &shape);
    }
    world
}

fn median(times: &mut [f64]) -> f64 {
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}

fn main() {
    let mut own = own_pyramid();
    let mut own_pool = own_pyramid();
    let mut serial = Timed::new(Serial);
    let mut pool = Pool::new(2).expect("two workers");
    let (mut serial_times, mut pool_times) = (Vec::new(), Vec::new());
    #[cfg(feature = "peers")]
    let mut rapier = rapier::World::pyramid();
    #[cfg(feature = "peers")]
    let mut rapier_times = Vec::new();
    let mut report = cellstep::StepReport::default();
    for _ in 0..RUNS {
        serial_times.push(time(|| report = own.step(&mut serial)));
        pool_times.push(time(|| {
            own_pool.step(&mut pool);
        }));
        #[cfg(feature = "peers")]
        rapier_times.push(time(|| rapier.step()));
    }
    assert_eq!(own.checksum(), own_pool.checksum(), "workers change no bit");
    let one = median(&mut serial_times);
    println!(
        "pyramid of {} boxes, {} steps, medians of {RUNS} runs",
        own.body_count() - 1,
        RUNS as u32 * RUN
    );
    println!("{report:?}");
    println!(
        "state bytes / body          {:8.1}",
        own.snapshot_bytes() as f64 / f64::from(own.body_count() - 1)
    );
    println!(
        "cellstep, 1 worker          {one:8.3} ms/step, penetration {:.2} mm",
        own.penetration_max() * 1e3
    );
    println!("cellstep, 2 workers         {:8.3} ms/step", median(&mut pool_times));
    let times = serial.take();
    for stage in cellstep::Stage::ALL {
        println!(
            "  {:12} {:8.3} ms",
            stage.name(),
            times.stage(stage).total.as_secs_f64() * 1e3 / f64::from(RUNS as u32 * RUN)
        );
    }
    #[cfg(feature = "peers")]
    {
        let other = median(&mut rapier_times);
        println!(
            "rapier3d 0.36, 1 thread     {other:8.3} ms/step, penetration {:.2} mm",
            rapier.penetration_max() * 1e3
        );
        println!("cellstep / rapier3d         {:8.3}", one / other);
    }
}

/// Milliseconds per step.
fn time(mut step: impl FnMut()) -> f64 {
    let start = Instant::now();
    for _ in 0..RUN {
        step();
    }
    start.elapsed().as_secs_f64() * 1e3 / f64::from(RUN)
}

#[cfg(feature = "peers")]
mod rapier {
    use rapier3d::prelude::*;

    /// The same pyramid in `rapier3d`, at its default settings.
    pub struct World {
        world: PhysicsWorld,
    }

    impl World {
        pub fn pyramid() -> Self {
            let mut world = PhysicsWorld::new();
            world.gravity = Vector::new(0.0, 0.0, -9.81);
            world.integration_parameters.dt = 1.0 / 60.0;
            let floor = ColliderBuilder::cuboid(200.0, 200.0, 1.0).friction(0.6);
            world.insert(RigidBodyBuilder::fixed().translation(Vector::new(0.0, 0.0, -1.0)), floor);
            for p in super::pyramid() {
                let body =
                    RigidBodyBuilder::dynamic().translation(Vector::new(p.x, p.y, p.z)).can_sleep(false);
                world.insert(body, ColliderBuilder::cuboid(0.5, 0.5, 0.5).density(1000.0).friction(0.6));
            }
            Self { world }
        }

        pub fn step(&mut self) {
            self.world.step();
        }

        /// Deepest overlap of the last step's contacts, metres.
        pub fn penetration_max(&self) -> f32 {
            let pairs = self.world.narrow_phase.contact_pairs();
            let deepest =
                |pair: &ContactPair| pair.find_deepest_contact().map_or(0.0, |(_, point)| -point.dist);
            pairs.map(deepest).fold(0.0, f32::max)
        }
    }
}
