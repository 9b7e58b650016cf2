//! The ring of snapshots: what it keeps, what it forgets, and that going back changes no bit.

use cellstep::Command;
use cellstep::math::Vec3;
use cellstep::scene::builtin::BUILTIN;
use cellstep::{
    Capacities, Error, Memory, Pool, Position, QueryFilter, Ray, Serial, SnapshotError, SnapshotRing,
    new_ring,
};
use cellstep_tests::executors::Random;
use cellstep_tests::simulator::{self, CAPACITIES, EVENTFUL, Event, Simulator, snapshot};
use cellstep_tests::worlds::{self, OwnedWorld};
use std::path::Path;
use std::thread;

/// Command sequences of the long test, and the threads that share them.
const SEQUENCES: u64 = 10_000;
const THREADS: u64 = 2;
/// Steps of a sequence at most, and those of them that the ring keeps.
const STEPS: u64 = 14;
const DEPTH: usize = 9;

/// What came of the sequences.
#[derive(Default)]
struct Counts {
    created: u32,
    removed: u32,
    restored: u32,
    taken_again: u32,
}

/// The commands before a step, and the state after it.
type Entry = (Vec<Event>, Vec<u8>);

fn step(simulator: &mut Simulator, world: &mut OwnedWorld, history: &mut Vec<Entry>, counts: &mut Counts) {
    let events = simulator.play(world);
    for (command, _) in events.iter().filter(|(_, outcome)| outcome.is_ok()) {
        counts.created += u32::from(matches!(command, Command::CreateBody(_)));
        counts.removed += u32::from(matches!(command, Command::RemoveBody(_)));
    }
    world.step(&mut Serial);
    history.push((events, world.state().to_vec()));
}

/// Plays a few steps, goes back to one of those that the ring has, and takes the steps from there again, twice.
fn check_sequence(seed: u64, counts: &mut Counts) {
    let mut random = Random::new(seed ^ 0x5eed);
    let capacities = if seed.is_multiple_of(2) { CAPACITIES } else { EVENTFUL };
    let (mut simulator, mut world) = Simulator::new(seed, capacities);
    let mut ring = new_ring(&capacities, DEPTH).expect("memory");
    let mut history = Vec::new();
    for _ in 0..=random.below(STEPS) {
        ring.save(&world).expect("a world of its capacities");
        step(&mut simulator, &mut world, &mut history, counts);
    }
    for _ in 0..2 {
        let back = 1 + random.below(history.len().min(DEPTH) as u64) as usize;
        let from = history.len() - back;
        ring.restore(&mut world, from as u64).expect("it is kept");
        counts.restored += 1;
        for (events, state) in &history[from..] {
            ring.save(&world).expect("a world of its capacities");
            simulator::replay(&mut world, events);
            world.step(&mut Serial);
            assert!(world.state() == state, "sequence {seed}: another state after step {}", world.steps());
            counts.taken_again += 1;
        }
    }
}

#[test]
fn ten_thousand_sequences_go_the_same_way_after_going_back() {
    let totals: Vec<Counts> = thread::scope(|scope| {
        let run = |thread: u64| {
            let mut counts = Counts::default();
            (0..SEQUENCES)
                .filter(|seed| seed % THREADS == thread)
                .for_each(|seed| check_sequence(seed, &mut counts));
            counts
        };
        let threads: Vec<_> = (0..THREADS).map(|thread| scope.spawn(move || run(thread))).collect();
        threads.into_iter().map(|thread| thread.join().expect("no sequence fails")).collect()
    });
    let sum = |count: fn(&Counts) -> u32| totals.iter().map(count).sum::<u32>();
    let (created, removed) = (sum(|counts| counts.created), sum(|counts| counts.removed));
    assert!(created > 5_000 && removed > 5_000, "{created} bodies created, {removed} removed");
    assert_eq!(sum(|counts| counts.restored), 20_000);
    assert!(sum(|counts| counts.taken_again) > 50_000);
}

/// In the built-in scenes too, whose caches are larger and mostly hold: what a restore keeps changes no bit.
#[test]
fn built_in_scenes_go_the_same_way_after_going_back() {
    let mut pool = Pool::new(2).expect("threads can be started");
    for builtin in BUILTIN {
        let size = builtin.golden_size;
        let scene = builtin.scene(size).expect("in range");
        let mut world = scene.build(Path::new(".")).expect("built-in scenes build").world;
        let mut ring = new_ring(world.capacities(), DEPTH).expect("memory");
        let mut sums = Vec::new();
        for round in 0..6 {
            for _ in 0..11 {
                ring.save(&world).expect("its own ring");
                world.step(&mut pool);
                sums.push(world.checksum());
            }
            for back in [8, 3, 8] {
                let from = sums.len() - back;
                ring.restore(&mut world, from as u64).expect("it is kept");
                if round % 2 == 1 {
                    // Queries bring the trees up to date, and none of that may be seen.
                    let up = Ray { origin: Position::ORIGIN, translation: Vec3::Z };
                    world.queries().cast_ray(&up, &QueryFilter::ALL).expect("a good ray");
                }
                for (step, sum) in sums.iter().enumerate().skip(from) {
                    world.step(&mut pool);
                    assert_eq!(world.checksum(), *sum, "{}, step {step}", builtin.name);
                }
            }
        }
    }
}

fn ring_of(capacities: &Capacities, steps: u64, depth: usize) -> (OwnedWorld, SnapshotRing<Memory>) {
    let mut world = worlds::world_with(*capacities);
    worlds::ground(&mut world, 0.5);
    let mut ring = new_ring(capacities, depth).expect("memory");
    for _ in 0..steps {
        ring.save(&world).expect("a world of its capacities");
        world.step(&mut Serial);
    }
    (world, ring)
}

#[test]
fn the_last_steps_are_kept() {
    let capacities = Capacities::for_bodies(2);
    for steps in 0..20 {
        let (mut world, ring) = ring_of(&capacities, steps, 5);
        let oldest = steps.saturating_sub(5);
        assert!(ring.steps().eq(oldest..steps), "{steps}");
        assert_eq!(ring.depth(), 5);
        for kept in oldest..steps {
            ring.restore(&mut world, kept).expect("it is kept");
            assert_eq!(world.steps(), kept);
            assert!(ring.get(kept).expect("it is kept") == snapshot(&world));
        }
        let before = world.state().to_vec();
        for absent in [oldest.wrapping_sub(1), steps, steps + 1, u64::MAX] {
            let expected = SnapshotError::NotKept { step: absent };
            assert_eq!(ring.restore(&mut world, absent), Err(Error::Snapshot(expected)));
            assert_eq!(ring.get(absent), Err(expected));
        }
        assert!(world.state() == before, "what is not kept changes nothing");
    }
}

#[test]
fn saving_after_going_back_forgets_the_other_future() {
    let capacities = Capacities::for_bodies(2);
    let (mut world, mut ring) = ring_of(&capacities, 10, 4);
    ring.restore(&mut world, 7).expect("it is kept");
    assert!(ring.steps().eq(6..10), "going back alone forgets nothing");
    world.step(&mut Serial);
    ring.save(&world).expect("room");
    assert!(ring.steps().eq(6..9));
    // Steps that were not saved are not there.
    world.step(&mut Serial);
    world.step(&mut Serial);
    ring.save(&world).expect("room");
    assert!(ring.steps().eq([6, 7, 8, 10]));
    ring.save(&world).expect("room");
    assert!(ring.steps().eq([6, 7, 8, 10]), "the same step again takes no room");
    ring.clear();
    assert_eq!(ring.steps().count(), 0);
}

#[test]
fn a_full_world_fits() {
    let capacities =
        Capacities { joints: 3, events: 9, sensor_visits: 5, materials: 2, ..Capacities::for_bodies(70) };
    assert_eq!(
        SnapshotRing::<Memory>::lines(&capacities, 3),
        3 * (1 + capacities.snapshot_bytes_max().div_ceil(64))
    );
    let (mut simulator, mut world) = Simulator::new(5, EVENTFUL);
    for _ in 0..50 {
        simulator.play(&mut world);
        world.step(&mut Serial);
        assert!(world.snapshot_bytes() <= EVENTFUL.snapshot_bytes_max());
    }
}

#[test]
fn what_does_not_fit_is_refused() {
    let capacities = Capacities::for_bodies(2);
    let (mut world, mut ring) = ring_of(&Capacities::for_bodies(3), 2, 2);
    let mut other = worlds::world_with(capacities);
    let refused = Err(Error::Snapshot(SnapshotError::Capacities));
    assert_eq!(ring.save(&other), refused);
    assert_eq!(ring.restore(&mut other, 1), refused);
    assert!(ring.steps().eq(0..2));
    ring.restore(&mut world, 1).expect("it is kept");

    let lines = SnapshotRing::<Memory>::lines(&capacities, 2);
    let memory = Memory::zeroed(lines - 1).expect("some bytes");
    let error = SnapshotRing::new(memory, &capacities, 2).err();
    assert_eq!(error, Some(Error::MemoryTooSmall { needed: lines, given: lines - 1 }));
    let memory = Memory::zeroed(lines).expect("some bytes");
    let error = SnapshotRing::new(memory, &capacities, 0).err();
    assert_eq!(error, Some(Error::CapacityOutOfRange { name: "depth" }));
    assert!(matches!(new_ring(&capacities, usize::MAX), Err(Error::MemoryTooSmall { .. })));
}
