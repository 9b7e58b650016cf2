//! The core's bits on other machines: scenes that use every part of it, and numbers to compare.
//!
//! `.ci/cross` builds this for several architectures, runs it there, and compares every line that is printed
//! with the one of this machine. There are four kinds of lines: the lane type operation by operation, the
//! functions of `math.rs`, scenes that need the core alone, and the built-in scenes, whose documents need the
//! standard library, after some steps. A lane or math line that differs names the cause; a scene of the core that
//! differs is bisected by its `trace`.
#![no_std]
#![forbid(unsafe_code)]

extern crate alloc;
// For the built-in scenes alone.
extern crate std;

pub mod scenes;

mod builtin;
mod hash;
mod lane_probes;
mod math_probes;
mod numbers;

use alloc::{format, string::String, vec};
use cellstep_core::{Line, Serial, World};
use scenes::Scene;

/// The lane type, compiled from the core's own file: the core keeps it to itself.
#[path = "../../core/src/lanes.rs"]
#[allow(dead_code, reason = "the probes use the operations with arithmetic in them, not the constructors")]
mod lanes;

/// What the lanes' file takes from its crate.
mod math {
    pub use cellstep_core::math::Vec3;
}

/// A named number that has to be the same everywhere.
struct Probe {
    /// Its name in the printed lines: one word.
    name: &'static str,
    /// Computes it.
    value: fn() -> u64,
}

/// The line that is compared: of the probe or, after the last probe, of the scene with this index, those of the
/// core first; `None` after the last scene.
pub fn line(index: usize, steps: u32) -> Option<String> {
    let mut probes = lane_probes::ALL.iter().chain(&math_probes::ALL);
    if let Some(probe) = probes.nth(index) {
        return Some(format!("{} {:016x}", probe.name, (probe.value)()));
    }
    let index = index - lane_probes::ALL.len() - math_probes::ALL.len();
    let Some(scene) = scenes::ALL.get(index) else {
        return builtin::line(index - scenes::ALL.len(), steps);
    };
    let out = run(&mut vec![Line::ZERO; lines(scene)], scene, steps);
    let (sum, snapshot) = (out.checksum, out.snapshot);
    Some(format!(
        "scene-{} {sum:016x} snapshot {snapshot:016x} bodies {} contacts {}",
        scene.name, out.bodies, out.contacts
    ))
}

/// What a scene came to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Outcome {
    /// [`World::checksum`] after the last step.
    pub checksum: u64,
    /// Hash of a sealed snapshot after the last step.
    pub snapshot: u64,
    /// Bodies after the last step.
    pub bodies: u32,
    /// Contacts of all steps: that the scene is no empty one.
    pub contacts: u32,
}

/// Lines of memory that a scene needs: its world's, and as many bytes again for a snapshot.
pub fn lines(scene: &Scene) -> usize {
    2 * scene.capacities.lines()
}

/// Builds a scene in `memory` and takes `steps` steps.
///
/// # Panics
/// When `memory` has fewer than [`lines`] lines, or when a scene loses a body or finds no room: it would prove less
/// than it claims.
pub fn run(memory: &mut [Line], scene: &Scene, steps: u32) -> Outcome {
    run_watched(memory, scene, steps, |_, _| {})
}

/// As [`run`], and shows the world after every step, the build being step 0.
pub fn run_watched(
    memory: &mut [Line],
    scene: &Scene,
    steps: u32,
    mut watch: impl FnMut(u32, &World<&mut [Line]>),
) -> Outcome {
    let (own, spare) = memory[..lines(scene)].split_at_mut(scene.capacities.lines());
    let spare: &mut [u8] = bytemuck::cast_slice_mut(spare);
    let mut world = World::new(own, scene.capacities).expect("the scene's capacities are in range");
    (scene.build)(&mut world);
    watch(0, &world);
    let mut contacts = 0;
    for step in 1..=steps {
        (scene.before_step)(&mut world, step);
        if step % LOAD_EVERY == 0 {
            let length = save(&world, spare);
            world.load(&spare[..length]).expect("a world takes its own snapshot");
        }
        let report = world.step(&mut Serial);
        assert!(report.dropped == 0 && report.quarantined == 0, "scene {}: {report:?}", scene.name);
        contacts += report.contacts;
        watch(step, &world);
    }
    let length = save(&world, spare);
    Outcome {
        checksum: world.checksum(),
        snapshot: hash::bytes(&spare[..length]),
        bodies: world.body_count(),
        contacts,
    }
}

/// The world goes through a snapshot and its validation this often, steps.
const LOAD_EVERY: u32 = 97;

/// Writes a sealed snapshot to the front of `spare` and returns its length.
fn save(world: &World<&mut [Line]>, spare: &mut [u8]) -> usize {
    let length = world.save(spare).expect("a snapshot is smaller than the world");
    World::<&mut [Line]>::seal(&mut spare[..length]).expect("it is a snapshot");
    length
}
