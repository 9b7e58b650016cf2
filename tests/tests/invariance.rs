//! The same bits for any executor, any number of workers and any build: checksums of the built-in scenes.
//!
//! `checksums.txt` beside the built-in scenes holds the checksum of each in its golden size after 300 steps; it is
//! part of the release (`cellstep doctor`). `UPDATE=1 cargo test --test invariance` writes it anew: a change of any
//! of them is a change of behaviour, to be named in the commit.

use cellstep::scene::builtin::{BUILTIN, Builtin, GOLDEN_STEPS};
use cellstep::{Executor, Pool, Serial};
use cellstep_tests::executors::Shuffled;
use cellstep_tests::simulator;
use cellstep_tests::worlds::OwnedWorld;
use std::fmt::Write;
use std::path::Path;
use std::sync::OnceLock;

const STEPS: u32 = GOLDEN_STEPS;
/// The scenes that every executor steps; the others stand in the golden file only.
const SCENES: [&str; 6] = ["stacked_pyramid", "wall", "mixed_pile", "bowls", "hub", "level"];

fn built(builtin: &Builtin, size: u32) -> OwnedWorld {
    let scene = builtin.scene(size).expect("the size is in range");
    scene.build(Path::new(".")).expect("built-in scenes build").world
}

/// Checksums after every tenth of the steps.
fn checksums(builtin: &Builtin, (size, steps): (u32, u32), executor: &mut impl Executor) -> Vec<u64> {
    let mut world = built(builtin, size);
    let mut sums = Vec::new();
    for step in 1..=steps {
        let report = world.step(executor);
        assert_eq!(report.quarantined, 0, "{} step {step}", builtin.name);
        if step % (steps / 10) == 0 {
            sums.push(world.checksum());
        }
    }
    sums
}

/// Checksums of all scenes in golden sizes on this thread, made once.
fn serial() -> impl Iterator<Item = (&'static Builtin, &'static [u64])> {
    static SUMS: OnceLock<Vec<Vec<u64>>> = OnceLock::new();
    let sum = |builtin: &Builtin| checksums(builtin, (builtin.golden_size, STEPS), &mut Serial);
    BUILTIN.iter().zip(SUMS.get_or_init(|| BUILTIN.iter().map(sum).collect()).iter().map(Vec::as_slice))
}

/// Those of [`SCENES`].
fn serial_of_six() -> impl Iterator<Item = (&'static Builtin, &'static [u64])> {
    assert!(SCENES.iter().all(|name| Builtin::find(name).is_some()), "a scene has another name now");
    serial().filter(|(builtin, _)| SCENES.contains(&builtin.name))
}

#[test]
fn golden_checksums() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../runtime/src/scene/builtin/checksums.txt");
    let mut found = String::new();
    for (builtin, sums) in serial() {
        let sum = sums.last().expect("ten sums");
        writeln!(found, "{} {} {sum:016x}", builtin.name, builtin.golden_size).expect("strings grow");
    }
    if std::env::var_os("UPDATE").is_some_and(|value| value == "1") {
        std::fs::write(&path, &found).expect("the table can be written");
        return;
    }
    let golden = std::fs::read_to_string(&path).expect("the table can be read");
    assert_eq!(found, golden, "checksums changed; if that is meant, run again with UPDATE=1 and say why");
}

#[test]
fn order_of_tasks_changes_no_bit() {
    for (builtin, expected) in serial_of_six() {
        for seed in 0..8 {
            let size = (builtin.golden_size, STEPS);
            let sums = checksums(builtin, size, &mut Shuffled::new(seed));
            assert_eq!(sums, expected, "{}, seed {seed}", builtin.name);
        }
    }
}

#[test]
fn number_of_workers_changes_no_bit() {
    for workers in [1, 2, 3, 8] {
        let mut pool = Pool::new(workers).expect("threads can be started");
        for (builtin, expected) in serial_of_six() {
            let sums = checksums(builtin, (builtin.golden_size, STEPS), &mut pool);
            assert_eq!(sums, expected, "{} with {workers} workers", builtin.name);
        }
    }
}

/// Golden sizes have few tasks in a stage; a larger pile has many in each.
#[test]
fn many_tasks_change_no_bit() {
    let builtin = Builtin::find("mixed_pile").expect("a built-in scene");
    let size = (2000, 40);
    let mut counting = Counting::default();
    let expected = checksums(builtin, size, &mut counting);
    assert!(counting.most_tasks >= 8, "at most {} tasks", counting.most_tasks);
    for seed in 0..2 {
        assert_eq!(checksums(builtin, size, &mut Shuffled::new(seed)), expected, "seed {seed}");
    }
    for workers in [2, 3] {
        let mut pool = Pool::new(workers).expect("threads can be started");
        assert_eq!(checksums(builtin, size, &mut pool), expected, "{workers} workers");
    }
}

/// Commands between steps, stale ones included, under a shuffled executor and a pool.
#[test]
fn commands_change_no_bit() {
    let mut pool = Pool::new(3).expect("threads can be started");
    for seed in 0..20 {
        let (mut simulator, mut world) = simulator::Simulator::new(seed, simulator::CAPACITIES);
        let (_, mut shuffled) = simulator::Simulator::new(seed, simulator::CAPACITIES);
        let (_, mut pooled) = simulator::Simulator::new(seed, simulator::CAPACITIES);
        let mut executor = Shuffled::new(seed);
        for step in 0..120 {
            let events = simulator.play(&mut world);
            let report = world.step(&mut Serial);
            simulator::replay(&mut shuffled, &events);
            simulator::replay(&mut pooled, &events);
            assert_eq!(shuffled.step(&mut executor), report, "seed {seed}, step {step}");
            assert_eq!(pooled.step(&mut pool), report, "seed {seed}, step {step}");
            assert!(world.state() == shuffled.state(), "seed {seed}, step {step}");
            assert!(world.state() == pooled.state(), "seed {seed}, step {step}");
        }
    }
}

/// Runs tasks in order, and counts them.
#[derive(Default)]
struct Counting {
    most_tasks: usize,
}

impl Executor for Counting {
    fn for_each<T: Send>(&mut self, _: cellstep::Stage, tasks: &mut [T], run: impl Fn(&mut T) + Sync) {
        self.most_tasks = self.most_tasks.max(tasks.len());
        tasks.iter_mut().for_each(run);
    }
}
