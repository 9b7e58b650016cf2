//! Stepping allocates nothing: neither the core, nor the pool on the thread that steps. Reading replays is bounded.

use cellstep::math::Vec3;
use cellstep::replay::{Options, Recorder, Replay};
use cellstep::scene::Build;
use cellstep::scene::builtin::Builtin;
use cellstep::{
    BodyHandle, Command, Executor, Hit, Pool, Position, Probe, QueryFilter, QueryShape, Ray, Region, Serial,
    ShapeCast,
};
use cellstep_tests::commands;
use cellstep_tests::executors::Random;
use cellstep_tests::fuzzing::forged_replay;
use cellstep_tests::mixed::{Draw, mixed_world};
use cellstep_tests::simulator::{self, Simulator};
use cellstep_tests::worlds::OwnedWorld;
use std::path::Path;

/// A pile that falls into a walled box.
fn pile() -> OwnedWorld {
    let scene = Builtin::find("mixed_pile").expect("a built-in scene").scene(150).expect("in range");
    scene.build(Path::new(".")).expect("built-in scenes build").world
}

fn allocations(world: &mut OwnedWorld, executor: &mut impl Executor, steps: u32) -> u64 {
    let mut contacts = 0;
    let found = allocation_counter::measure(|| {
        for _ in 0..steps {
            contacts = world.step(executor).contacts;
        }
    });
    assert!(contacts > 150, "the pile has come together: {contacts} contacts");
    found.count_total
}

#[test]
fn a_counter_counts() {
    let found = allocation_counter::measure(|| drop(std::hint::black_box(vec![0_u8; 100])));
    assert_eq!(found.count_total, 1);
}

#[test]
fn a_thousand_steps_allocate_nothing() {
    assert_eq!(allocations(&mut pile(), &mut Serial, 1000), 0);
}

#[test]
fn a_pool_allocates_nothing_on_the_thread_that_steps() {
    let mut pool = Pool::new(2).expect("threads can be started");
    assert_eq!(allocations(&mut pile(), &mut pool, 300), 0);
}

#[test]
fn commands_and_snapshots_allocate_nothing() {
    let (mut simulator, mut world) = Simulator::new(1, simulator::CAPACITIES);
    let mut history = Vec::new();
    let mut buffer = Vec::new();
    for _ in 0..200 {
        history.push(simulator.play(&mut world));
        world.step(&mut Serial);
        buffer.resize(buffer.len().max(world.snapshot_bytes()), 0);
    }
    let (_, mut world) = Simulator::new(1, simulator::CAPACITIES);
    let found = allocation_counter::measure(|| {
        for events in &history {
            simulator::replay(&mut world, events);
            world.step(&mut Serial);
            let length = world.save(&mut buffer).expect("the buffer is large enough");
            world.restore(&buffer[..length]).expect("its own snapshot");
            OwnedWorld::seal(&mut buffer[..length]).expect("a snapshot");
            world.load(&buffer[..length]).expect("its own snapshot");
            let touching = world.contacts().filter(|contact| contact.normal_impulse() > 0.0).count();
            std::hint::black_box((touching, world.penetration_max(), world.checksum()));
        }
    });
    assert_eq!(found.count_total, 0);
}

/// A recording of few balls and boxes with a command in each step.
fn recording() -> Vec<u8> {
    let scene = Builtin::find("mixed_pile").expect("a built-in scene").scene(8).expect("in range");
    let Build { mut world, assets, .. } = scene.build(Path::new(".")).expect("built-in scenes build");
    let options = Options { checksums_every: 3, keyframes_every: 30, ..Options::default() };
    let mut recorder = Recorder::new(Vec::new(), &world, &assets, &options).expect("its own assets");
    for step in 0..100 {
        let body = BodyHandle { index: 2 + step % 4, generation: 1 };
        let _ = recorder.apply(&mut world, &Command::ApplyImpulse(body, Vec3::X));
        recorder.step(&mut world, &mut Serial);
    }
    recorder.finish(&world).expect("a vector takes everything")
}

#[test]
fn reading_a_replay_takes_memory_in_proportion_to_its_bytes() {
    let bytes = recording();
    let mut random = Random::new(4);
    let mut read = 0;
    for round in 0..600 {
        let mut hostile = if round == 0 { bytes.clone() } else { forged_replay(&bytes, &mut random) };
        if round % 3 == 1 {
            // Lengths and counts of any size, without right checksums.
            let at = random.below(hostile.len() as u64 - 4) as usize;
            hostile[at..at + 4].copy_from_slice(&(random.bits() as u32).to_le_bytes());
        }
        let length = hostile.len() as u64;
        let found = allocation_counter::measure(|| read += u32::from(Replay::read(hostile).is_ok()));
        assert!(found.bytes_max <= 3 * length + 4096, "{} for {length}", found.bytes_max);
    }
    assert!(read > 0);
}

#[test]
fn commands_are_coded_without_memory() {
    let mut random = Random::new(5);
    let commands: Vec<Command> = (0..commands::KINDS).map(|kind| commands::any(&mut random, kind)).collect();
    let mut room = [0; Command::BYTES_MAX];
    let found = allocation_counter::measure(|| {
        for command in &commands {
            let length = command.encode(&mut room).expect("there is room");
            std::hint::black_box(Command::decode(&room[..length]).expect("what was encoded decodes"));
        }
    });
    assert_eq!(found.count_total, 0);
}

#[test]
fn a_ring_of_snapshots_allocates_nothing() {
    let mut world = pile();
    let mut ring = cellstep::new_ring(world.capacities(), 8).expect("memory");
    let found = allocation_counter::measure(|| {
        for _ in 0..60 {
            ring.save(&world).expect("a world of its capacities");
            world.step(&mut Serial);
            if world.steps().is_multiple_of(20) {
                let back = world.steps() - 8;
                ring.restore(&mut world, back).expect("it is kept");
                while world.steps() < back + 8 {
                    world.step(&mut Serial);
                }
            }
        }
    });
    assert_eq!(found.count_total, 0);
}

#[test]
fn queries_allocate_nothing() {
    let mut world = mixed_world(1);
    let mut random = Random::new(2);
    let mut hits = [Hit::default(); 8];
    let mut found = 0;
    let counted = allocation_counter::measure(|| {
        for _ in 0..200 {
            world.step(&mut Serial);
            let queries = world.queries();
            let ray = Ray { origin: Position::at(random.vector(14.0)), translation: random.vector(30.0) };
            let shape =
                QueryShape { geometry: random.solid(1.0), position: ray.origin, rotation: random.rotation() };
            let cast = ShapeCast { shape, translation: ray.translation };
            let probe = Probe { position: ray.origin, max_distance: 5.0 };
            let filter = &QueryFilter::ALL;
            found += queries.cast_ray_all(&ray, filter, &mut hits).expect("good").count;
            found += queries.cast_shape_all(&cast, filter, &mut hits).expect("good").count;
            found += usize::from(queries.overlap(&Region::Shape(shape), filter).expect("good").is_some());
            found += usize::from(queries.closest_point(&probe, filter).expect("good").is_some());
            queries.cast_rays(&[ray], filter, &mut [None], &mut Serial).expect("good");
        }
    });
    assert!(found > 500, "{found}");
    assert_eq!(counted.count_total, 0);
}
