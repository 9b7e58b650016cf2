//! Stepping allocates nothing: neither the core, nor the pool on the thread that steps.

use cellstep::scene::builtin::Builtin;
use cellstep::{Executor, Pool, Serial};
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
