//! Deltas between snapshots: byte-equal, small, and refused when they do not fit.

use cellstep::delta::{self, DeltaError};
use cellstep::scene::builtin::Builtin;
use cellstep::{Capacities, Serial, SnapshotError};
use cellstep_tests::executors::Random;
use cellstep_tests::simulator::{self, CAPACITIES, EVENTFUL, Simulator, snapshot};
use cellstep_tests::worlds::{self, OwnedWorld};
use std::path::Path;

/// Bytes of a delta's header, and where in it things are.
const HEADER: usize = 64;
const VERSION: usize = 8;
const LAYOUT: usize = 16;
const ASSETS: usize = 24;
const BYTES: usize = 56;

/// Snapshots of a world some steps apart, with commands in between.
fn history(seed: u64, capacities: Capacities) -> (OwnedWorld, Vec<Vec<u8>>) {
    let (mut simulator, mut world) = Simulator::new(seed, capacities);
    let mut snapshots = vec![snapshot(&world)];
    for step in 0..40 {
        simulator.play(&mut world);
        world.step(&mut Serial);
        if step % 8 == 7 {
            snapshots.push(snapshot(&world));
        }
    }
    (world, snapshots)
}

#[test]
fn a_delta_gives_the_snapshot_byte_for_byte() {
    for seed in 0..40 {
        let (world, mut snapshots) = history(seed, if seed % 2 == 0 { CAPACITIES } else { EVENTFUL });
        OwnedWorld::seal(&mut snapshots[2]).expect("a snapshot");
        snapshots.push(Vec::new());
        for base in &snapshots {
            for goal in &snapshots[..snapshots.len() - 1] {
                let delta = delta::encode(&world, base, goal).expect("its own snapshots");
                let found = delta::apply(&world, base, &delta).expect("the same base");
                assert!(found == *goal, "seed {seed}");
            }
        }
    }
}

/// Late join: a world that has only the scene goes on like the one that has played.
#[test]
fn who_joins_late_goes_on_like_the_others() {
    let scene = Builtin::find("mixed_pile").expect("a built-in scene").scene(200).expect("in range");
    let build = || scene.build(Path::new(".")).expect("built-in scenes build").world;
    let (mut world, mut late) = (build(), build());
    let base = snapshot(&late);
    for _ in 0..100 {
        world.step(&mut Serial);
    }
    let now = snapshot(&world);
    let delta = delta::encode(&world, &base, &now).expect("its own snapshots");
    let received = delta::apply(&late, &base, &delta).expect("the same base");
    late.load(&received).expect("a state that was stepped");
    (0..20).for_each(|_| _ = world.step(&mut Serial));
    (0..20).for_each(|_| _ = late.step(&mut Serial));
    assert!(world.state() == late.state());
    let later = snapshot(&world);
    let size = |base: &[u8]| delta::encode(&world, base, &later).expect("its own snapshots").len();
    let (alone, since) = (size(&[]), size(&now));
    println!("{} bytes, compressed {alone}, against 20 steps before {since}", later.len());
    assert!(since < alone && alone < later.len() / 2);
    let nothing = delta::encode(&world, &now, &now).expect("its own snapshot").len();
    assert!(nothing < now.len() / 100, "{nothing} bytes for no change");
}

#[test]
fn what_does_not_fit_is_refused() {
    let (world, snapshots) = history(3, CAPACITIES);
    let (base, goal) = (&snapshots[1], &snapshots[4]);
    let good = delta::encode(&world, base, goal).expect("its own snapshots");
    let apply = |base: &[u8], delta: &[u8]| delta::apply(&world, base, delta);
    assert_eq!(apply(&snapshots[2], &good), Err(DeltaError::OtherBase));
    assert_eq!(apply(&[], &good), Err(DeltaError::OtherBase));
    assert_eq!(apply(base, &good[..HEADER - 1]), Err(DeltaError::NotADelta));
    assert_eq!(apply(base, goal), Err(DeltaError::NotADelta));
    assert_eq!(apply(base, &good[..good.len() - 1]), Err(DeltaError::Damaged));
    let changed = |at: usize, with: &[u8]| {
        let mut bytes = good.clone();
        bytes[at..at + with.len()].copy_from_slice(with);
        bytes
    };
    let refused = |error| Err(DeltaError::Snapshot(error));
    assert_eq!(apply(base, &changed(VERSION, &[9])), refused(SnapshotError::Version { found: 9 }));
    assert_eq!(apply(base, &changed(LAYOUT, &[!good[LAYOUT]])), refused(SnapshotError::Capacities));
    assert_eq!(apply(base, &changed(ASSETS, &[!good[ASSETS]])), refused(SnapshotError::Assets));
    let endless = changed(BYTES, &u64::MAX.to_le_bytes());
    assert_eq!(apply(base, &endless), Err(DeltaError::TooLong { bytes: u64::MAX }));
    let other = worlds::world_with(CAPACITIES);
    assert_eq!(delta::apply(&other, &[], &good), refused(SnapshotError::Assets));
    assert_eq!(delta::encode(&other, &[], goal), refused(SnapshotError::Assets));
    assert_eq!(delta::encode(&world, &base[1..], goal), refused(SnapshotError::NotASnapshot));
}

#[test]
fn hostile_deltas_end_in_errors() {
    let (mut world, snapshots) = history(8, EVENTFUL);
    let mut random = Random::new(4);
    let largest = EVENTFUL.snapshot_bytes_max();
    let (mut refused, mut taken) = (0, 0);
    for round in 0..4000_usize {
        let (base, goal) = (&snapshots[round % 5], &snapshots[(round / 5) % 6]);
        let mut delta = delta::encode(&world, base, goal).expect("its own snapshots");
        match random.below(4) {
            0 => delta.truncate(random.below(delta.len() as u64) as usize),
            1 => {
                let at = random.below(delta.len() as u64) as usize;
                delta[at] ^= 1 << random.below(8);
            }
            2 => {
                let at = HEADER + random.below((delta.len() - HEADER) as u64) as usize;
                delta[at..].iter_mut().for_each(|byte| *byte = random.bits() as u8);
            }
            // The base's hash and length, the snapshot's hash and length, and the first bytes of the block.
            _ => {
                let at = 32 + random.below(48).min(delta.len() as u64 - 33) as usize;
                delta[at] = random.bits() as u8;
            }
        }
        let mut counted = Err(DeltaError::Damaged);
        let found = allocation_counter::measure(|| counted = delta::apply(&world, base, &delta));
        assert!(found.bytes_max < 3 * largest as u64 + 4096, "{} bytes at once", found.bytes_max);
        match counted {
            Ok(bytes) => {
                taken += 1;
                assert!(bytes == *goal, "what passes the hash is what was sent");
                world.load(&bytes).expect("a state that was stepped");
            }
            Err(_) => refused += 1,
        }
    }
    assert!(refused > 3000, "{refused} refused, {taken} taken");
    assert!(simulator::snapshot(&world).len() <= largest);
}
