//! Snapshots: going back and stepping again gives the same bytes, whatever happened in between.

use cellstep::{
    BEHAVIOUR_VERSION, Capacities, Command, Error, Executor, Serial, SnapshotError, SnapshotHeader,
};
use cellstep_tests::executors::{Random, Shuffled};
use cellstep_tests::fuzzing::{CONTENT_HASH, SNAPSHOT_HEADER};
use cellstep_tests::simulator::{self, CAPACITIES, Event, Simulator, snapshot};
use cellstep_tests::worlds::{self, OwnedWorld};

const SEEDS: u64 = 160;
const WINDOW: usize = 60;

/// A step of a history: the commands before it, and the state after it.
struct Entry {
    events: Vec<Event>,
    state: Vec<u8>,
}

fn play(simulator: &mut Simulator, world: &mut OwnedWorld, steps: usize) -> Vec<Entry> {
    (0..steps)
        .map(|_| {
            let events = simulator.play(world);
            world.step(&mut Serial);
            Entry { events, state: world.state().to_vec() }
        })
        .collect()
}

/// Takes the steps of a history again; `before` is called before each.
fn take_again(
    world: &mut OwnedWorld,
    history: &[Entry],
    executor: &mut impl Executor,
    mut before: impl FnMut(&mut OwnedWorld),
) {
    for (step, entry) in history.iter().enumerate() {
        before(world);
        simulator::replay(world, &entry.events);
        world.step(executor);
        assert!(world.state() == entry.state, "another state {step} steps after the snapshot");
    }
}

/// Capacities of a seed: every fourth world is so small that pairs and contacts are dropped.
fn capacities(seed: u64) -> Capacities {
    if seed % 4 == 3 { Capacities { pairs: 30, contacts: 16, ..CAPACITIES } } else { CAPACITIES }
}

fn restore(world: &mut OwnedWorld, bytes: &[u8]) {
    world.restore(bytes).expect("a snapshot of such a world");
}

#[test]
fn a_restored_world_goes_the_same_way() {
    let mut random = Random::new(1);
    let (mut created, mut refused, mut removed) = (0, 0, 0);
    for seed in 0..SEEDS {
        let (mut simulator, mut world) = Simulator::new(seed, capacities(seed));
        play(&mut simulator, &mut world, random.below(60) as usize);
        let saved = snapshot(&world);
        let at_save = world.state().to_vec();
        let history = play(&mut simulator, &mut world, WINDOW);
        for (command, outcome) in history.iter().flat_map(|entry| &entry.events) {
            refused += u32::from(outcome.is_err());
            created += u32::from(matches!((command, outcome), (Command::CreateBody(_), Ok(_))));
            removed += u32::from(matches!((command, outcome), (Command::RemoveBody(_), Ok(_))));
        }
        for turn in 0..2 {
            restore(&mut world, &saved);
            assert!(world.state() == at_save, "seed {seed}");
            take_again(&mut world, &history, &mut Shuffled::new(turn), |_| {});
        }
    }
    assert!(created > 200 && removed > 200 && refused > 200, "{created} {removed} {refused}");
}

#[test]
fn another_world_goes_the_same_way() {
    for seed in 100..100 + SEEDS / 2 {
        let (mut simulator, mut world) = Simulator::new(seed, capacities(seed));
        play(&mut simulator, &mut world, 30);
        let saved = snapshot(&world);
        let mut sealed = saved.clone();
        OwnedWorld::seal(&mut sealed).expect("a snapshot");
        let history = play(&mut simulator, &mut world, WINDOW);
        let (_, mut restored) = Simulator::new(seed + 1000, capacities(seed));
        restore(&mut restored, &saved);
        take_again(&mut restored, &history, &mut Serial, |_| {});
        let mut loaded = simulator::empty_world(capacities(seed));
        assert_eq!(loaded.load(&sealed), Ok(()), "seed {seed}");
        assert!(snapshot(&loaded) == saved);
        take_again(&mut loaded, &history, &mut Serial, |_| {});
        assert_eq!(loaded.checksum(), world.checksum());
    }
}

/// A game that predicts rolls back a few steps at almost every step.
#[test]
fn rolling_back_at_every_step_changes_nothing() {
    for seed in 200..212 {
        let (mut simulator, mut world) = Simulator::new(seed, capacities(seed));
        let mut snapshots = vec![snapshot(&world)];
        let mut history: Vec<Entry> = Vec::new();
        let mut random = Random::new(seed);
        for _ in 0..80 {
            history.extend(play(&mut simulator, &mut world, 1));
            snapshots.push(snapshot(&world));
            let back = random.below(8.min(history.len() as u64) + 1) as usize;
            let from = history.len() - back;
            restore(&mut world, &snapshots[from]);
            take_again(&mut world, &history[from..], &mut Serial, |_| {});
            assert!(snapshot(&world) == *snapshots.last().expect("the one just taken"));
        }
    }
}

#[test]
fn dropped_caches_change_no_bit() {
    let mut random = Random::new(2);
    for seed in 300..300 + SEEDS / 2 {
        let (mut simulator, mut world) = Simulator::new(seed, capacities(seed));
        let history = play(&mut simulator, &mut world, 2 * WINDOW);
        let (_, mut twin) = Simulator::new(seed, capacities(seed));
        take_again(&mut twin, &history, &mut Serial, |world| {
            if random.below(3) == 0 {
                world.drop_caches();
            }
        });
        let (_, mut twin) = Simulator::new(seed, capacities(seed));
        take_again(&mut twin, &history, &mut Serial, OwnedWorld::drop_caches);
    }
}

/// Asserts that `restore` and `load` both refuse, with this error, and change nothing.
fn assert_refused(world: &mut OwnedWorld, bytes: &[u8], expected: SnapshotError) {
    let before = world.state().to_vec();
    assert_eq!(world.restore(bytes), Err(Error::Snapshot(expected)));
    assert_eq!(world.load(bytes), Err(Error::Snapshot(expected)));
    assert!(world.state() == before, "a refused snapshot changes nothing");
}

fn stepped() -> (OwnedWorld, Vec<u8>) {
    let (mut simulator, mut world) = Simulator::new(7, CAPACITIES);
    play(&mut simulator, &mut world, 20);
    let saved = snapshot(&world);
    play(&mut simulator, &mut world, 5);
    (world, saved)
}

#[test]
fn other_capacities_are_refused() {
    let (_, saved) = stepped();
    let more = [
        Capacities { bodies: CAPACITIES.bodies + 1, ..CAPACITIES },
        Capacities { shapes: CAPACITIES.shapes + 1, ..CAPACITIES },
        Capacities { pairs: CAPACITIES.pairs + 1, ..CAPACITIES },
        Capacities { contacts: CAPACITIES.contacts - 1, ..CAPACITIES },
        Capacities { hulls: CAPACITIES.hulls + 1, ..CAPACITIES },
        Capacities { meshes: CAPACITIES.meshes + 1, ..CAPACITIES },
        Capacities { mesh_vertices: CAPACITIES.mesh_vertices + 1, ..CAPACITIES },
        Capacities { mesh_triangles: CAPACITIES.mesh_triangles + 1, ..CAPACITIES },
        Capacities { height_fields: 1, ..CAPACITIES },
        Capacities { height_samples: 1, ..CAPACITIES },
        Capacities { compounds: 1, ..CAPACITIES },
        Capacities { compound_children: 1, ..CAPACITIES },
        Capacities { surfaces: 1, ..CAPACITIES },
    ];
    for capacities in more {
        let mut other = simulator::empty_world(capacities);
        assert_refused(&mut other, &saved, SnapshotError::Capacities);
    }
}

#[test]
fn other_assets_are_refused() {
    let (_, saved) = stepped();
    let mut without = worlds::world_with(CAPACITIES);
    assert_refused(&mut without, &saved, SnapshotError::Assets);
    let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    without.add_hull(&corners.map(cellstep::math::Vec3::from)).expect("a hull");
    assert_refused(&mut without, &saved, SnapshotError::Assets);
}

#[test]
fn another_version_is_refused() {
    let (mut world, mut saved) = stepped();
    let found = BEHAVIOUR_VERSION + 1;
    saved[8..12].copy_from_slice(&found.to_le_bytes());
    assert_refused(&mut world, &saved, SnapshotError::Version { found });
}

#[test]
fn other_bytes_are_refused() {
    let (mut world, mut saved) = stepped();
    saved[3] ^= 1;
    assert_refused(&mut world, &saved, SnapshotError::NotASnapshot);
    assert_eq!(OwnedWorld::seal(&mut saved), Err(Error::Snapshot(SnapshotError::NotASnapshot)));
    let text = [b'{'; 200];
    assert_refused(&mut world, &text, SnapshotError::NotASnapshot);
}

#[test]
fn other_lengths_are_refused() {
    let (mut world, saved) = stepped();
    let before = world.state().to_vec();
    for given in (0..saved.len()).step_by(7).chain([saved.len() - 1]) {
        let is_length = |result| match result {
            Err(Error::Snapshot(SnapshotError::WrongLength { given: found, .. })) => found == given,
            _ => false,
        };
        assert!(is_length(world.restore(&saved[..given])), "{given} bytes");
        assert!(is_length(world.load(&saved[..given])), "{given} bytes");
    }
    let mut long = saved.clone();
    long.push(0);
    let expected = SnapshotError::WrongLength { needed: saved.len(), given: long.len() };
    assert_refused(&mut world, &long, expected);
    assert!(world.state() == before);
    let needed = world.snapshot_bytes();
    let mut short = vec![0; needed - 1];
    assert_eq!(world.save(&mut short), Err(Error::Snapshot(SnapshotError::BufferTooSmall { needed })));
    assert!(short.iter().all(|&byte| byte == 0), "nothing is written into a buffer that is too small");
}

#[test]
fn damage_is_found_by_the_content_hash() {
    let (mut world, saved) = stepped();
    let mut sealed = saved.clone();
    OwnedWorld::seal(&mut sealed).expect("a snapshot");
    assert!(sealed[CONTENT_HASH] != saved[CONTENT_HASH]);
    assert!(sealed[SNAPSHOT_HEADER..] == saved[SNAPSHOT_HEADER..], "only the hash is written");
    assert_eq!(world.load(&sealed), Ok(()));
    let before = world.state().to_vec();
    for bit in [0, 3, 7] {
        // The last byte is in a contact's twist, where any number may stand.
        let mut damaged = sealed.clone();
        let last = damaged.len() - 1;
        damaged[last] ^= 1 << bit;
        assert_eq!(world.load(&damaged), Err(Error::Snapshot(SnapshotError::Damaged)));
    }
    assert!(world.state() == before);
}

/// Who gets a snapshot from elsewhere can say why it does not fit before looking at its rows.
#[test]
fn the_header_says_what_differs() {
    let (world, saved) = stepped();
    let header = SnapshotHeader::read(&saved).expect("a snapshot");
    assert_eq!(SnapshotHeader::BYTES, SNAPSHOT_HEADER);
    assert_eq!(header.version, BEHAVIOUR_VERSION);
    assert_eq!(header.layout_hash, CAPACITIES.layout_hash());
    assert_eq!(header.layout_hash, world.layout_hash());
    assert_eq!(header.assets_hash, world.assets_hash());
    assert_eq!((header.content_hash, header.length), (0, saved.len() as u64));
    assert_eq!(world.accepts(&header), Ok(()));
    let others = [
        (SnapshotHeader { version: 1, ..header }, SnapshotError::Version { found: 1 }),
        (SnapshotHeader { layout_hash: header.layout_hash ^ 1, ..header }, SnapshotError::Capacities),
        (SnapshotHeader { assets_hash: header.assets_hash ^ 1, ..header }, SnapshotError::Assets),
    ];
    for (other, expected) in others {
        assert_eq!(world.accepts(&other), Err(expected));
    }
    let short = SnapshotHeader::read(&saved[..SNAPSHOT_HEADER - 1]);
    assert_eq!(
        short,
        Err(SnapshotError::WrongLength { needed: SNAPSHOT_HEADER, given: SNAPSHOT_HEADER - 1 })
    );
}

#[test]
fn sections_fill_a_snapshot() {
    let (world, saved) = stepped();
    let mut end = SNAPSHOT_HEADER;
    let mut names = Vec::new();
    for section in world.snapshot_sections(&saved).expect("its own snapshot") {
        assert_eq!(section.range.start, end, "{}", section.name);
        assert_eq!(section.range.len() % section.row_bytes, 0, "{}", section.name);
        end = section.range.end;
        names.push(section.name);
    }
    assert_eq!(end, saved.len());
    assert!(names.iter().copied().eq(world.checksum_by_section().map(|(name, _)| name)));
    assert!(world.snapshot_sections(&saved[1..]).is_err());
}
