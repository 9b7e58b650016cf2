//! `load` takes bytes from anywhere: it accepts exactly or refuses, never panics, and what it accepts steps.

use cellstep::math::Vec3;
use cellstep::{BodyDef, BodyKind, Error, Geometry, JointDef, Serial, ShapeDef, SnapshotError};
use cellstep_tests::executors::Random;
use cellstep_tests::fuzzing::{self, LOAD_CAPACITIES, SNAPSHOT_HEADER};
use cellstep_tests::jointed::{at, ball, jointed, massive};
use cellstep_tests::simulator::{Simulator, snapshot};
use cellstep_tests::worlds;
use std::collections::BTreeMap;
use std::ops::Range;

const MUTANTS: usize = 10_000;
/// Bytes of the state's header, about: settings, counts and marks.
const STATE_HEADER: usize = 200;
/// Where in it the mark of pairs to be looked for again is.
const PAIRS_STALE: usize = 156;

/// Snapshots of simulated worlds at several times.
fn sources() -> Vec<Vec<u8>> {
    let mut sources = Vec::new();
    for seed in 0..12 {
        let (mut simulator, mut world) = Simulator::new(seed, LOAD_CAPACITIES);
        for step in 0..90 {
            simulator.play(&mut world);
            if step % 30 == 20 {
                // Commands are given but not stepped yet: flags are up, efforts are stored.
                sources.push(snapshot(&world));
            }
            world.step(&mut Serial);
            if step % 30 == 0 {
                sources.push(snapshot(&world));
            }
        }
    }
    sources
}

#[test]
fn snapshots_are_accepted_exactly() {
    let mut world = fuzzing::load_world();
    for source in sources() {
        assert_eq!(fuzzing::load(&mut world, &source), Ok(()));
    }
}

/// Floats at the borders of what is valid.
const FLOATS: [f32; 15] = [
    f32::NAN,
    f32::INFINITY,
    f32::NEG_INFINITY,
    0.0,
    -0.0,
    1.0e-45,
    f32::MIN_POSITIVE,
    f32::MAX,
    f32::MIN,
    1.0,
    -1.0,
    1.0e9,
    1.0e30,
    1.0e-12,
    33.0,
];

/// Words at the borders of what is valid.
const WORDS: [u32; 10] = [0, 1, 2, 3, 4, 31, 63, u32::MAX, u32::MAX - 1, 1 << 31];

/// Damages some bytes of a range, in one of many ways.
fn mutate(random: &mut Random, bytes: &mut Vec<u8>, range: Range<usize>) -> &'static str {
    let (first, size) = (range.start, range.len());
    let mut at = |size: usize| first + random.below(size as u64) as usize;
    let (byte, word) = (at(size), first + (at(size / 4) - first) * 4);
    match random.below(20) {
        0..=3 => {
            for _ in 0..=random.below(3) {
                let place = first + random.below(size as u64) as usize;
                bytes[place] ^= 1 << random.below(8);
            }
            "bits"
        }
        4..=5 => {
            bytes[byte] = random.bits() as u8;
            "byte"
        }
        6..=10 => {
            let value = FLOATS[random.below(FLOATS.len() as u64) as usize];
            bytes[word..word + 4].copy_from_slice(&value.to_le_bytes());
            "float"
        }
        11..=12 => {
            let value = WORDS[random.below(WORDS.len() as u64) as usize];
            bytes[word..word + 4].copy_from_slice(&value.to_le_bytes());
            "word"
        }
        13 => {
            let old = u32::from_le_bytes(bytes[word..word + 4].try_into().expect("four bytes"));
            let new = if random.below(2) == 0 { old.wrapping_add(1) } else { old.wrapping_sub(1) };
            bytes[word..word + 4].copy_from_slice(&new.to_le_bytes());
            "step"
        }
        14..=17 => {
            swap_rows(random, &mut bytes[range]);
            "rows"
        }
        18 => {
            bytes.truncate(byte);
            "truncated"
        }
        _ => {
            bytes.extend((0..=random.below(64)).map(|_| 0_u8));
            "extended"
        }
    }
}

/// Exchanges two neighbourhoods of the size of a row or a part of it.
fn swap_rows(random: &mut Random, bytes: &mut [u8]) {
    let row = [4, 8, 12, 16, 36, 48, 64, 104, 112][random.below(9) as usize];
    let row = row.min(bytes.len() / 2);
    let places = bytes.len() / row;
    let a = random.below(places as u64) as usize;
    // Near rows are rows of the same section, mostly.
    let b = (a + random.below(8) as usize) % places;
    for i in 0..row {
        bytes.swap(a * row + i, b * row + i);
    }
}

#[test]
fn mutants_are_refused_or_step() {
    let sources = sources();
    let mut random = Random::new(0);
    let mut world = fuzzing::load_world();
    let (mut accepted, mut by_rows) = (0, 0);
    let mut refusals: BTreeMap<String, u32> = BTreeMap::new();
    for _ in 0..MUTANTS {
        let mut bytes = sources[random.below(sources.len() as u64) as usize].clone();
        // The header of the snapshot, where little is valid; that of the state, which is small; or all the rows.
        let range = match random.below(20) {
            0 => 0..SNAPSHOT_HEADER,
            1..=4 => SNAPSHOT_HEADER..SNAPSHOT_HEADER + STATE_HEADER,
            _ => SNAPSHOT_HEADER..bytes.len(),
        };
        let kind = mutate(&mut random, &mut bytes, range);
        match fuzzing::load(&mut world, &bytes) {
            Ok(()) => {
                accepted += 1;
                *refusals.entry(format!("{kind}: accepted")).or_default() += 1;
            }
            Err(Error::Snapshot(error)) => {
                let name = match error {
                    SnapshotError::Invalid { section, .. } => section.to_string(),
                    other => format!("{other:?}").chars().take_while(|c| c.is_alphabetic()).collect(),
                };
                by_rows += u32::from(matches!(error, SnapshotError::Invalid { .. }));
                *refusals.entry(name).or_default() += 1;
            }
            Err(error) => panic!("{error:?} is not a refusal of a snapshot"),
        }
    }
    println!("{accepted} of {MUTANTS} accepted, {by_rows} refused for a row: {refusals:?}");
    // The mutants are of use only if many get as far as the rows, and many past them.
    assert!(accepted > MUTANTS / 5, "{accepted} accepted");
    assert!(by_rows as usize > MUTANTS / 5, "{by_rows} refused for a row");
    for section in
        ["header", "bodies", "body_used", "shapes", "shape_used", "pairs", "contacts", "WrongLength"]
    {
        assert!(refusals.contains_key(section), "nothing was refused for {section}: {refusals:?}");
    }
}

/// Counters that only ever rise must not be near their end: a step raises them.
#[test]
fn counters_near_their_end_are_refused() {
    let source = sources().swap_remove(3);
    let mut world = fuzzing::load_world();
    // The steps taken and the version of the static boxes come first in the state.
    for counter in [SNAPSHOT_HEADER, SNAPSHOT_HEADER + 8] {
        for end in [u64::MAX, u64::MAX - 1, u64::MAX - 30, 1 << 63] {
            let mut bytes = source.clone();
            bytes[counter..counter + 8].copy_from_slice(&end.to_le_bytes());
            let expected = SnapshotError::Invalid { section: "header", index: 0 };
            assert_eq!(fuzzing::load(&mut world, &bytes), Err(Error::Snapshot(expected)));
        }
    }
}

/// A ball on another one on the ground, after a step.
fn two_balls() -> (worlds::OwnedWorld, [cellstep::BodyHandle; 2]) {
    let mut world = worlds::world(3);
    worlds::ground(&mut world, 0.5);
    let ball = ShapeDef::new(Geometry::Sphere { radius: 0.5 });
    let bodies = [0.5, 1.5]
        .map(|z| worlds::add(&mut world, &BodyDef::new(BodyKind::Dynamic, Vec3::new(0.0, 0.0, z)), &ball).0);
    world.step(&mut Serial);
    (world, bodies)
}

/// Every contact that a step leaves has a place in the ordering.
#[test]
fn a_contact_without_phase_is_refused() {
    let (mut world, _) = two_balls();
    let mut bytes = snapshot(&world);
    // Behind the contacts of 64 bytes are the ordering, a byte and two bits per body, and a row of news.
    let last = bytes.len() - 32 - 16 - 3 - 20 - 64;
    bytes[last + 8] |= 15;
    let expected = SnapshotError::Invalid { section: "contacts", index: 1 };
    assert_eq!(world.load(&bytes), Err(Error::Snapshot(expected)));
}

/// Pairs of shapes that are gone stay until the next step, which must know of them.
#[test]
fn forgotten_pairs_of_removed_shapes_are_refused() {
    let (mut world, bodies) = two_balls();
    for body in bodies {
        world.remove_body(body).expect("it exists");
    }
    let mut bytes = snapshot(&world);
    assert_eq!(world.load(&bytes), Ok(()));
    let mark = SNAPSHOT_HEADER + PAIRS_STALE;
    assert_eq!(bytes[mark..mark + 4], 1_u32.to_le_bytes());
    bytes[mark] = 0;
    let expected = SnapshotError::Invalid { section: "pairs", index: 0 };
    assert_eq!(world.load(&bytes), Err(Error::Snapshot(expected)));
}

/// The bodies of a joint have leapt or they have not: one flag, the other, or none before their first step.
#[test]
fn a_joint_that_leapt_and_did_not_is_refused() {
    let (mut world, base) = jointed(1, 1, 4);
    let body = massive(&mut world, at(Vec3::X), ball(1.0, 0.3));
    world.create_joint(&JointDef::ball([base, body], [at(Vec3::ZERO), at(-Vec3::X)])).expect("room");
    world.step(&mut Serial);
    let bytes = snapshot(&world);
    let mut load = |place: usize, flags: u32| {
        let mut bytes = bytes.clone();
        bytes[place..place + 4].copy_from_slice(&flags.to_le_bytes());
        world.load(&bytes)
    };
    let (plain, leapt, lags) = (32_u32, 64, 128);
    let flags = (plain | leapt).to_le_bytes();
    let places: Vec<usize> = (0..bytes.len() - 4).filter(|&i| bytes[i..i + 4] == flags).collect();
    let expected = Err(Error::Snapshot(SnapshotError::Invalid { section: "joints", index: 0 }));
    let found = places.into_iter().filter(|&place| {
        load(place, plain | lags) == Ok(())
            && load(place, plain) == Ok(())
            && load(place, plain | leapt | lags) == expected
    });
    assert_eq!(found.count(), 1);
}
