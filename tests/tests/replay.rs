//! Replays: what was recorded plays again with the same bytes, on any executor, from any keyframe; what was cut or
//! damaged is told.

use cellstep::math::Vec3;
use cellstep::replay::{
    AssetSet, Cause, Difference, ErrorKind, Limits, Options, Player, Recorder, Replay, ReplayError, Verdict,
    verify,
};
use cellstep::scene::builtin::BUILTIN;
use cellstep::{Applied, BodyDef, BodyKind, Capacities, Command, Executor, Geometry, Pool, Serial, ShapeDef};
use cellstep_tests::commands;
use cellstep_tests::executors::{Random, Shuffled};
use cellstep_tests::simulator::{EVENTFUL, Simulator, snapshot};
use cellstep_tests::worlds::{self, OwnedWorld};
use std::path::Path;

const LIMITS: Limits = Limits { world_bytes: 64 << 20 };

/// The assets of the simulated worlds, registered with one of them.
fn simulated(capacities: Capacities) -> (OwnedWorld, AssetSet) {
    let mut world = worlds::world_with(capacities);
    let mut assets = AssetSet::new();
    cellstep_tests::simulator::assets(&mut world, &mut assets);
    (world, assets)
}

/// A recorded game of the simulator: bytes, and the state at the end.
fn game(seed: u64, steps: u32, options: &Options, executor: &mut impl Executor) -> (Vec<u8>, Vec<u8>) {
    let (mut simulator, mut world) = Simulator::new(seed, EVENTFUL);
    let (_, assets) = simulated(EVENTFUL);
    let mut recorder = Recorder::new(Vec::new(), &world, &assets, options).expect("assets of the world");
    let mut random = Random::new(seed);
    for _ in 0..steps {
        for _ in 0..random.below(3) {
            let kind = random.below(commands::KINDS);
            // Commands without sense, mostly refused; settings stay those of the simulator.
            let command = commands::any(&mut random, 1 + kind % (commands::KINDS - 1));
            let _ = recorder.apply(&mut world, &command);
        }
        simulator.play_with(&mut world, |world, command| recorder.apply(world, command));
        if random.below(40) == 0 {
            // Mostly between the commands of a step and the step.
            recorder.keyframe_now(&world);
        }
        recorder.step(&mut world, executor);
    }
    let bytes = recorder.finish(&world).expect("a vector takes everything");
    (bytes, snapshot(&world))
}

fn options(checksums_every: u32, keyframes_every: u32) -> Options {
    Options { checksums_every, keyframes_every, note: "a test".to_string(), ..Options::default() }
}

#[test]
fn ten_thousand_random_commands_play_again() {
    let (mut commands, mut refused) = (0, 0);
    for seed in 0..6 {
        let (bytes, end) = game(seed, 800, &options(1, 100), &mut Serial);
        let replay = Replay::read(bytes).expect("a recording is read");
        assert!(replay.is_finished() && replay.cut_bytes() == 0);
        let verdict = verify(&replay, &mut Serial, &LIMITS).expect("its world is made");
        assert!(matches!(verdict, Verdict::Same { steps: 800, compared: 808.. }), "seed {seed}: {verdict:?}");
        let mut player = Player::new(&replay, &LIMITS).expect("its world is made");
        while !player.is_at_end() {
            assert_eq!(player.apply(), None);
            player.advance(&mut Serial);
        }
        assert!(snapshot(player.world()) == end, "seed {seed}");
        commands += replay.command_count();
        assert!(replay.keyframes().any(|keyframe| keyframe.after > 0 && keyframe.cause == Cause::Asked));
        let of_step = |step| replay.commands(step).filter(|command| command.is_refused).count();
        refused += (0..800).map(of_step).sum::<usize>();
    }
    assert!(commands > 10_000 && refused > 1000, "{commands} commands, {refused} refused");
}

#[test]
fn recordings_do_not_depend_on_the_executor() {
    let options = options(7, 50);
    let (serial, _) = game(3, 200, &options, &mut Serial);
    assert!(serial == game(3, 200, &options, &mut Pool::new(1).expect("a thread")).0);
    assert!(serial == game(3, 200, &options, &mut Pool::new(3).expect("threads")).0);
    assert!(serial == game(3, 200, &options, &mut Shuffled::new(1)).0);
    let replay = Replay::read(serial).expect("a recording is read");
    for workers in [1, 3] {
        let mut pool = Pool::new(workers).expect("threads");
        assert!(matches!(verify(&replay, &mut pool, &LIMITS), Ok(Verdict::Same { .. })));
    }
}

#[test]
fn built_in_scenes_stand_alone() {
    for builtin in BUILTIN {
        let scene = builtin.scene(builtin.golden_size.min(6)).expect("in range");
        let mut built = scene.build(Path::new("")).expect("it builds");
        let mut recorder =
            Recorder::new(Vec::new(), &built.world, &built.assets, &options(5, 0)).expect("its own assets");
        for _ in 0..20 {
            recorder.step(&mut built.world, &mut Serial);
        }
        let replay = Replay::read(recorder.finish(&built.world).expect("room")).expect("it is read");
        let verdict = verify(&replay, &mut Serial, &Limits::default()).expect("its world is made");
        assert!(matches!(verdict, Verdict::Same { steps: 20, compared: 4 }), "{}: {verdict:?}", builtin.name);
    }
}

#[test]
fn players_go_to_any_step() {
    let (bytes, _) = game(4, 120, &options(1, 40), &mut Serial);
    let replay = Replay::read(bytes).expect("a recording is read");
    let sums: Vec<u64> = replay.checksums().map(|sums| sums.total).collect();
    let mut player = Player::new(&replay, &LIMITS).expect("its world is made");
    for step in [120, 1, 79, 80, 81, 40, 39, 119, 2] {
        player.seek(step, &mut Serial).expect("keyframes are states");
        assert_eq!((player.steps(), player.world().checksum()), (step, sums[step as usize - 1]));
    }
}

/// A short recording of few bodies.
fn short() -> Vec<u8> {
    let mut world = worlds::world(2);
    let mut recorder =
        Recorder::new(Vec::new(), &world, &AssetSet::new(), &options(2, 4)).expect("no assets");
    for step in 0..6 {
        if step == 1 {
            let body = BodyDef::new(BodyKind::Dynamic, Vec3::Z);
            let Ok(Applied::Body(body)) = recorder.apply(&mut world, &Command::CreateBody(body)) else {
                panic!("there is room")
            };
            let shape = ShapeDef::new(Geometry::Sphere { radius: 0.5 });
            recorder.apply(&mut world, &Command::CreateShape(body, shape)).expect("there is room");
        }
        recorder.step(&mut world, &mut Serial);
    }
    recorder.finish(&world).expect("a vector takes everything")
}

#[test]
fn a_cut_file_is_read_up_to_its_last_whole_step() {
    let bytes = short();
    let whole = Replay::read(bytes.clone()).expect("a recording is read");
    assert_eq!((whole.first_step(), whole.last_step(), whole.command_count()), (0, 6, 2));
    let (mut started, mut last) = (0, 0);
    for length in 0..bytes.len() {
        let replay = match Replay::read(bytes[..length].to_vec()) {
            Ok(replay) => replay,
            Err(ReplayError::NotAReplay) => {
                assert!(length < 8);
                continue;
            }
            Err(error) => {
                assert!(matches!(error, ReplayError::NoStart) && started == 0, "{length}: {error}");
                continue;
            }
        };
        started += 1;
        assert!(!replay.is_finished() && replay.last_step() >= last, "{length}");
        last = replay.last_step();
        let mut zeros = bytes[..length].to_vec();
        zeros.resize(bytes.len() + 9, 0);
        let padded = Replay::read(zeros).expect("zeros after a crash are no damage");
        assert_eq!(padded.last_step(), last);
        assert_eq!(length - replay.cut_bytes(), bytes.len() + 9 - padded.cut_bytes());
        if replay.cut_bytes() == 0 {
            let verdict = verify(&replay, &mut Serial, &LIMITS).expect("its world is made");
            assert!(matches!(verdict, Verdict::Same { steps, .. } if steps == last), "{length}: {verdict:?}");
        }
    }
    assert!(started > 100 && last == 6, "{started} lengths, {last} steps");
}

#[test]
fn damage_is_told() {
    let bytes = short();
    for bit in 0..bytes.len() * 8 {
        let mut bad = bytes.clone();
        bad[bit / 8] ^= 1 << (bit % 8);
        match Replay::read(bad) {
            // A length that reaches beyond the end looks like a cut.
            Ok(replay) => assert!(!replay.is_finished() && replay.cut_bytes() > 0, "bit {bit}"),
            Err(ReplayError::Format { .. }) => assert_eq!(bit / 32, 2),
            Err(ReplayError::Behaviour { .. }) => assert_eq!(bit / 32, 3),
            Err(error) => assert!(error.kind() == ErrorKind::Corrupt, "bit {bit}: {error}"),
        }
    }
    let mut more = bytes.clone();
    more.extend_from_slice(&bytes[16..]);
    assert!(matches!(Replay::read(more), Err(ReplayError::Damaged { .. })));
    let replay = Replay::read(bytes).expect("a recording is read");
    let small = Limits { world_bytes: 1000 };
    assert!(matches!(verify(&replay, &mut Serial, &small), Err(ReplayError::TooLarge { limit: 1000, .. })));
}

/// Writes records with right checksums that say anything.
#[test]
fn hostile_records_are_refused_or_played() {
    let bytes = short();
    assert!(cellstep_tests::fuzzing::replay(&cellstep_tests::fuzzing::resealed_replay(&bytes)));
    let mut random = Random::new(5);
    let (mut played, mut refused) = (0, 0);
    for _ in 0..4000 {
        let bad = cellstep_tests::fuzzing::forged_replay(&bytes, &mut random);
        if cellstep_tests::fuzzing::replay(&bad) { played += 1 } else { refused += 1 }
    }
    assert!(played > 100 && refused > 1000, "{played} played, {refused} refused");
}

#[test]
fn what_is_not_recorded_is_noticed() {
    let (mut world, assets) = simulated(EVENTFUL);
    worlds::ground(&mut world, 0.5);
    let shape = ShapeDef::new(Geometry::Sphere { radius: 0.5 });
    let (body, _) = worlds::add(&mut world, &BodyDef::new(BodyKind::Dynamic, Vec3::Z * 3.0), &shape);
    let options = options(1, 0);
    let mut recorder = Recorder::new(Vec::new(), &world, &assets, &options).expect("its assets");
    for step in 0..20 {
        if step == 12 {
            world.set_linear_velocity(body, Vec3::X).expect("it moves");
        }
        recorder.step(&mut world, &mut Serial);
    }
    let replay = Replay::read(recorder.finish(&world).expect("room")).expect("it is read");
    let Ok(Verdict::Diverged(divergence)) = verify(&replay, &mut Serial, &LIMITS) else {
        panic!("the change is noticed")
    };
    assert_eq!(divergence.step, 12);
    let Difference::Unrecorded { after: 0, sections } = &divergence.difference else {
        panic!("{divergence}")
    };
    assert!(sections.contains(&"motions") && !sections.contains(&"shapes"), "{sections:?}");
    // From the keyframe of the change on it goes on.
    let mut player = Player::new(&replay, &LIMITS).expect("its world is made");
    player.seek(20, &mut Serial).expect("a keyframe is a state");
    assert_eq!(snapshot(player.world()), snapshot(&world));
    let causes: Vec<Cause> = replay.keyframes().map(|keyframe| keyframe.cause).collect();
    assert_eq!(causes, [Cause::Start, Cause::Unrecorded]);
    // Another world's assets are refused.
    let none = AssetSet::new();
    assert!(matches!(Recorder::new(Vec::new(), &world, &none, &options), Err(ReplayError::Assets)));
}

/// An output that takes so many bytes.
struct Full(usize);

impl std::io::Write for Full {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.0 = self.0.checked_sub(bytes.len()).ok_or(std::io::ErrorKind::StorageFull)?;
        Ok(bytes.len())
    }
    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

#[test]
fn a_full_disk_ends_the_recording_and_not_the_game() {
    let mut world = worlds::world(1);
    let mut recorder = Recorder::new(Full(5000), &world, &AssetSet::new(), &options(1, 0)).expect("room");
    for _ in 0..100 {
        recorder.step(&mut world, &mut Serial);
    }
    assert_eq!(world.steps(), 100);
    assert!(recorder.error().is_some());
    assert!(matches!(recorder.finish(&world), Err(ReplayError::Io(_))));
}
