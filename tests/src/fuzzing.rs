//! What must hold for bytes from anywhere: the oracles of the fuzz targets, which tests share.

use crate::executors::Random;
use crate::simulator::{self, CAPACITIES};
use crate::worlds::OwnedWorld;
use cellstep::mjcf::Model;
use cellstep::replay::{self, Player, Replay};
use cellstep::scene::{Limits, Scene};
use cellstep::{BEHAVIOUR_VERSION, Capacities, Command, Error, Serial, xxh64};
use std::path::Path;

/// Steps that an accepted world takes.
const STEPS: u32 = 60;
/// Sweeps per step up to which a world is stepped: bytes may ask for a quarter of a million, which is slow, not
/// wrong.
const SWEEPS_MAX: u64 = 512;
/// Where the content hash lies in a snapshot.
pub const CONTENT_HASH: core::ops::Range<usize> = 32..40;
/// Bytes of a snapshot's header.
pub const SNAPSHOT_HEADER: usize = 48;

/// How much a fuzzed scene may ask for: little, since the fuzzer looks at many.
pub const SCENE_LIMITS: Limits = Limits {
    file_bytes: 1 << 16,
    bodies: 64,
    shapes: 128,
    contacts: 1 << 12,
    joints: 64,
    memory_bytes: 32 << 20,
};

/// Room of the fuzzed world: that of the simulated ones, whose snapshots are the seeds.
pub const LOAD_CAPACITIES: Capacities = CAPACITIES;

/// Reads bytes as a scene. True when they are one whose world steps.
///
/// # Panics
/// When the scene does not come back from its own text, or its world breaks a promise in 60 steps.
pub fn scene(bytes: &[u8]) -> bool {
    let Ok(scene) = Scene::from_json(bytes, &SCENE_LIMITS) else { return false };
    let text = scene.to_json();
    let again = Scene::from_json(text.as_bytes(), &Limits::default()).expect("a scene's own text is a scene");
    assert!(scene == again, "a scene comes back from its own text");
    // The folder does not exist: meshes from files are refused, those in the document are not.
    let Ok(mut built) = scene.build_within(Path::new("/nonexistent"), &SCENE_LIMITS) else { return false };
    if !is_quick(&built.world) {
        return false;
    }
    for _ in 0..STEPS {
        built.world.step(&mut Serial);
    }
    check_reachable(&mut built.world);
    true
}

/// Reads bytes as a model in MJCF; where it becomes a scene, that goes to [`scene`]. True when it is a model.
///
/// # Panics
/// When a number of the model is not finite, or for the scene's sake.
pub fn mjcf(bytes: &[u8]) -> bool {
    let Ok(model) = Model::from_xml(bytes, &SCENE_LIMITS) else { return false };
    for body in &model.bodies {
        let numbers =
            body.placement.position.into_iter().chain(body.mass.map_or([0.0; 3], |mass| mass.inertia));
        assert!(numbers.into_iter().all(f64::is_finite), "{body:?}");
    }
    for part in model.joints.iter().flat_map(|joint| &joint.parts) {
        assert!(part.world_anchor.into_iter().chain(part.world_axis).all(f64::is_finite), "{part:?}");
    }
    if let Ok(conversion) = model.to_scene() {
        scene(conversion.scene.to_json().as_bytes());
    }
    true
}

/// Most that the world of a fuzzed replay may take.
const REPLAY_LIMITS: replay::Limits = replay::Limits { world_bytes: 16 << 20 };

/// Reads bytes as a replay and plays it as far as its steps are quick. True when it is one with a world.
///
/// # Panics
/// When the replay is read otherwise after a cut than before.
pub fn replay(bytes: &[u8]) -> bool {
    let Ok(replay) = Replay::read(bytes.to_vec()) else { return false };
    for command in (replay.first_step()..replay.last_step()).flat_map(|step| replay.commands(step)) {
        let mut room = [0; Command::BYTES_MAX];
        assert!(command.command.encode(&mut room).is_ok());
    }
    let whole = bytes.len() - replay.cut_bytes();
    let again = Replay::read(bytes[..whole].to_vec()).expect("whole records are read");
    assert_eq!((again.last_step(), again.cut_bytes()), (replay.last_step(), 0));
    let Ok(mut player) = Player::new(&replay, &REPLAY_LIMITS) else { return false };
    while !player.is_at_end() && player.steps() - replay.first_step() < u64::from(STEPS) {
        if player.compare().is_err() || player.apply().is_some() || !is_quick(player.world()) {
            return true;
        }
        player.advance(&mut Serial);
    }
    true
}

/// Bytes of a replay before its records.
const PREAMBLE: usize = 16;
/// Where the content hash lies in a keyframe's record, after its kind, cause, step and number of commands.
const KEYFRAME_HASH: core::ops::Range<usize> = 14 + CONTENT_HASH.start..14 + CONTENT_HASH.end;

/// The replay whose records, each kind and payload, are changed by `change`, with checksums that match; records
/// that `change` empties are left out. What follows the last whole record stays.
fn rewritten(bytes: &[u8], mut change: impl FnMut(&mut Vec<u8>)) -> Vec<u8> {
    let Some((preamble, mut rest)) = bytes.split_at_checked(PREAMBLE) else { return bytes.to_vec() };
    let mut out = preamble.to_vec();
    let mut seal = xxh64(&out, 0);
    while let Some(length) = rest.first_chunk::<4>() {
        let length = u32::from_le_bytes(*length) as usize;
        let Some(end) = length.checked_add(13).filter(|end| *end <= rest.len()) else { break };
        let mut record = rest[4..5 + length].to_vec();
        rest = &rest[end..];
        change(&mut record);
        if record.is_empty() {
            continue;
        }
        let start = out.len();
        out.extend_from_slice(&(record.len() as u32 - 1).to_le_bytes());
        out.extend_from_slice(&record);
        seal = xxh64(&out[start..], seal);
        out.extend_from_slice(&seal.to_le_bytes());
    }
    out.extend_from_slice(rest);
    out
}

/// The replay with the versions of this build and checksums that match: what a fuzzer changed then gets further
/// than the checksum.
pub fn resealed_replay(bytes: &[u8]) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    if let Some(versions) = bytes.get_mut(8..PREAMBLE) {
        versions[..4].copy_from_slice(&replay::FORMAT_VERSION.to_le_bytes());
        versions[4..].copy_from_slice(&BEHAVIOUR_VERSION.to_le_bytes());
    }
    rewritten(&bytes, |record| {
        if let (3, Some(hash)) = (record[0], record.get_mut(KEYFRAME_HASH)) {
            hash.fill(0);
        }
    })
}

/// A replay with some bytes of its records changed, and checksums that match.
pub fn forged_replay(bytes: &[u8], random: &mut Random) -> Vec<u8> {
    rewritten(bytes, |record| match random.below(40) {
        0 => record.clear(),
        1 => record.truncate(1 + random.below(record.len() as u64) as usize),
        2 => record.extend((0..random.below(20)).map(|_| random.bits() as u8)),
        3..6 => {
            let bit = random.below(record.len() as u64 * 8) as usize;
            record[bit / 8] ^= 1 << (bit % 8);
        }
        _ => {}
    })
}

/// Loads bytes into a small world. Gives the refusal, or the world after 60 steps.
///
/// # Panics
/// When what was accepted is not exactly the bytes, a refusal changed the world, the world breaks a promise in 60
/// steps, or it goes another way when its caches are dropped before each of them.
pub fn load(world: &mut OwnedWorld, bytes: &[u8]) -> Result<(), Error> {
    let before = world.checksum();
    if let Err(error) = world.load(bytes) {
        assert_eq!(world.checksum(), before, "a refused snapshot changes nothing");
        assert!(matches!(error, Error::Snapshot(_)), "{error:?}");
        return Err(error);
    }
    let mut saved = simulator::snapshot(world);
    saved[CONTENT_HASH].copy_from_slice(&bytes[CONTENT_HASH]);
    assert!(saved == bytes, "an accepted snapshot is taken exactly");
    if is_quick(world) {
        for _ in 0..STEPS {
            world.step(&mut Serial);
        }
        let state = world.state().to_vec();
        assert_eq!(world.load(bytes), Ok(()), "what was accepted once is accepted");
        for _ in 0..STEPS {
            world.drop_caches();
            world.step(&mut Serial);
        }
        assert!(world.state() == state, "caches change no bit");
        check_reachable(world);
    }
    Ok(())
}

/// True when a step asks for few sweeps.
fn is_quick(world: &OwnedWorld) -> bool {
    let settings = world.settings();
    let most =
        if settings.tolerance > 0.0 { settings.sweeps.max(settings.sweeps_max) } else { settings.sweeps };
    let sweeps = u64::from(most) + u64::from(settings.relax_sweeps);
    u64::from(settings.substeps) * sweeps * u64::from(settings.inner_sweeps) <= SWEEPS_MAX
}

/// What holds for every world that was stepped: nothing is non-finite, and a late joiner can take its state.
fn check_reachable(world: &mut OwnedWorld) {
    for body in world.bodies() {
        let place = world.position(body).expect("the body exists").to_f64();
        assert!(place.iter().all(|x| x.is_finite()), "{body:?} is at {place:?}");
        assert!(
            world.rotation(body).expect("the body exists").is_finite(),
            "{body:?} is turned by no number"
        );
        assert!(world.linear_velocity(body).expect("the body exists").is_finite(), "{body:?}");
        assert!(world.angular_velocity(body).expect("the body exists").is_finite(), "{body:?}");
    }
    let checksum = world.checksum();
    let state = world.state().to_vec();
    let snapshot = simulator::snapshot(world);
    assert_eq!(world.load(&snapshot), Ok(()), "the state that a step leaves can be loaded");
    assert_eq!(world.checksum(), checksum);
    assert!(world.state() == state, "the state comes back from its snapshot, byte for byte");
}

/// The world that [`load`] takes for fuzzing: empty, with the simulated worlds' assets.
pub fn load_world() -> OwnedWorld {
    simulator::empty_world(LOAD_CAPACITIES)
}
