//! The fuzz targets' seeds: files in `fuzz/corpus` that `UPDATE=1 cargo test --test fuzz_seeds` writes.
//!
//! Seeds are inputs that get far: every one is accepted and takes its steps. An input that a fuzzer found is kept
//! beside them, with a name that does not start with `seed`: it need only hold what the oracle asks.

use cellstep::Serial;
use cellstep::mjcf::Model;
use cellstep::replay::{AssetSet, Options, Recorder};
use cellstep::scene::builtin::BUILTIN;
use cellstep_tests::fuzzing::{self, LOAD_CAPACITIES};
use cellstep_tests::simulator::{self, CAPACITIES, Simulator, snapshot};
use cellstep_tests::worlds;
use std::collections::BTreeMap;
use std::path::PathBuf;

fn corpus(target: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../fuzz/corpus").join(target)
}

/// Small built-in scenes, and one document that uses what they do not.
fn scenes() -> BTreeMap<String, Vec<u8>> {
    let small = |name| if matches!(name, "level" | "bowls" | "ragdolls" | "cars") { 1 } else { 3 };
    let mut seeds: BTreeMap<_, _> = BUILTIN
        .iter()
        .map(|builtin| {
            let scene = builtin.scene(small(builtin.name)).expect("the size is in range");
            (format!("seed_{}.json", builtin.name), scene.to_json().into_bytes())
        })
        // Meshes of many triangles are too long to be mutated with success.
        .filter(|(_, text)| text.len() < 12_000)
        .collect();
    seeds.insert("seed_all.json".to_string(), ALL.as_bytes().to_vec());
    seeds
}

/// A document with a bit of everything.
const ALL: &str = include_str!("fuzz_seeds/all.json");

/// Models: with a bit of everything, with copies, and with joints, equalities, ropes and actuators.
const MODELS: [(&str, &str); 3] = [
    ("seed_scene.xml", include_str!("../../runtime/src/mjcf/tests/seed.xml")),
    ("seed_copies.xml", include_str!("fuzz_seeds/copies.xml")),
    ("seed_links.xml", include_str!("fuzz_seeds/links.xml")),
];

/// Snapshots of simulated worlds.
fn snapshots() -> BTreeMap<String, Vec<u8>> {
    (0..6)
        .map(|seed| {
            let (mut simulator, mut world) = Simulator::new(seed, LOAD_CAPACITIES);
            for _ in 0..10 * seed {
                simulator.play(&mut world);
                world.step(&mut Serial);
            }
            (format!("seed_{seed}.snapshot"), snapshot(&world))
        })
        .collect()
}

/// Recordings of simulated worlds, with refused commands and keyframes.
fn replays() -> BTreeMap<String, Vec<u8>> {
    (0..4)
        .map(|seed| {
            let (mut simulator, mut world) = Simulator::new(seed, CAPACITIES);
            let (mut assets, mut other) = (AssetSet::new(), worlds::world_with(CAPACITIES));
            simulator::assets(&mut other, &mut assets);
            let options = Options {
                checksums_every: 2,
                keyframes_every: 4,
                note: "a seed".to_string(),
                ..Options::default()
            };
            let mut recorder = Recorder::new(Vec::new(), &world, &assets, &options).expect("its assets");
            for _ in 0..6 {
                simulator.play_with(&mut world, |world, command| recorder.apply(world, command));
                recorder.step(&mut world, &mut Serial);
            }
            let bytes = recorder.finish(&world).expect("a vector takes everything");
            (format!("seed_{seed}.replay"), bytes)
        })
        .collect()
}

/// Compares the seeds with the files, or writes them; then gives every file of the corpus to the oracle.
fn check(target: &str, seeds: &BTreeMap<String, Vec<u8>>, mut accepts: impl FnMut(&[u8]) -> bool) {
    let folder = corpus(target);
    if std::env::var_os("UPDATE").is_some_and(|value| value == "1") {
        std::fs::create_dir_all(&folder).expect("the folder can be made");
        for (name, bytes) in seeds {
            std::fs::write(folder.join(name), bytes).expect("the corpus can be written");
        }
    }
    let mut found = 0;
    for entry in std::fs::read_dir(&folder).expect("the corpus can be read") {
        let path = entry.expect("an entry").path();
        let bytes = std::fs::read(&path).expect("a seed can be read");
        let name = path.file_name().expect("a file").to_string_lossy().into_owned();
        let accepted = accepts(&bytes);
        if name.starts_with("seed") {
            assert!(accepted, "{name} is refused: write the seeds anew with UPDATE=1");
            assert!(seeds.contains_key(&name), "{name} is no seed any more");
            found += 1;
        }
    }
    assert_eq!(found, seeds.len(), "seeds are missing: write them with UPDATE=1");
}

#[test]
fn scene_seeds_step() {
    check("scene", &scenes(), fuzzing::scene);
}

#[test]
fn model_seeds_are_read() {
    let seeds = MODELS.map(|(name, text)| (name.to_string(), text.as_bytes().to_vec()));
    check("mjcf", &BTreeMap::from(seeds), fuzzing::mjcf);
    let models = MODELS.map(|(_, text)| {
        Model::from_xml(text.as_bytes(), &fuzzing::SCENE_LIMITS).unwrap_or_else(|error| panic!("{error}"))
    });
    for model in &models {
        let scene = model.to_scene().unwrap_or_else(|error| panic!("{error}")).scene;
        assert!(fuzzing::scene(scene.to_json().as_bytes()), "it steps");
    }
    let [.., links] = &models;
    let counts = [links.joints.len(), links.equalities.len(), links.ropes.len(), links.actuators.len()];
    assert_eq!(counts, [3, 2, 2, 3]);
}

#[test]
fn replay_seeds_play() {
    let play = |bytes: &[u8]| fuzzing::replay(&fuzzing::resealed_replay(bytes)) && fuzzing::replay(bytes);
    check("replay", &replays(), play);
}

#[test]
fn snapshot_seeds_step() {
    let mut world = fuzzing::load_world();
    check("load", &snapshots(), |bytes| fuzzing::load(&mut world, bytes).is_ok());
}
