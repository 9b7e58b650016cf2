//! Games of the simulator around a corner of eight sectors, here and far away: commands of all kinds, joints,
//! sensors, sleep and events.

use cellstep::clock::interpolated;
use cellstep::delta;
use cellstep::math::Vec3;
use cellstep::replay::{AssetSet, Limits, Options, Player, Recorder, Replay, Verdict, verify};
use cellstep::{Executor, Pool, Serial};
use cellstep_tests::executors::Shuffled;
use cellstep_tests::sectors::{
    SHIFTS, Shift, assert_same_but_for, has_left, move_bodies, moved, moved_command,
};
use cellstep_tests::simulator::{self, CAPACITIES, EVENTFUL, Simulator, snapshot};
use cellstep_tests::worlds::{OwnedWorld, world_with};

/// From the middle of a sector to a corner of eight of them.
const CORNER: Vec3 = Vec3::new(32.0, 32.0, 32.0);

/// A player and two worlds for it, one of them shifted.
fn start(seed: u64, by: Shift) -> (Simulator, OwnedWorld, OwnedWorld) {
    let capacities = if seed.is_multiple_of(3) { CAPACITIES } else { EVENTFUL };
    let (_, mut there) = Simulator::new(seed, capacities);
    let (simulator, mut here) = Simulator::new(seed, capacities);
    move_bodies(&mut here, CORNER, [0; 3]);
    move_bodies(&mut there, CORNER, by);
    (simulator, here, there)
}

/// Gives both worlds the commands before their next step. They must come to the same.
fn play(simulator: &mut Simulator, here: &mut OwnedWorld, there: &mut OwnedWorld, by: Shift) {
    simulator.play_with(here, |world, command| {
        let outcome = world.apply(&moved_command(command, CORNER, [0; 3]));
        assert_eq!(there.apply(&moved_command(command, CORNER, by)), outcome, "{command:?}");
        outcome
    });
}

/// Plays and compares after each step; tells how many bodies changed their sector.
fn compare(seed: u64, by: Shift, executor: &mut impl Executor) -> usize {
    let (mut simulator, mut here, mut there) = start(seed, by);
    let mut crossings = 0;
    for step in 0..120 {
        let places = |world: &OwnedWorld| -> Vec<_> {
            world.bodies().map(|body| (body, world.center(body), world.rotation(body))).collect()
        };
        play(&mut simulator, &mut here, &mut there, by);
        let before = places(&here);
        let (near, far) = (here.step(&mut Serial), there.step(executor));
        if has_left(by, &near, &far) {
            return crossings;
        }
        assert_same_but_for(by, &here, &there, &format!("seed {seed}, step {step}"));
        for (body, center, rotation) in before {
            let (Ok(from), Ok(to), Ok(turn), Ok(turned)) =
                (center, here.center(body), rotation, here.rotation(body))
            else {
                continue;
            };
            crossings += usize::from(from.sector != to.sector);
            let between = |by| interpolated((moved(from, by), turn), (moved(to, by), turned), 0.3);
            let (own, far) = (between([0; 3]), between(by));
            assert_eq!((moved(own.0, by), own.1), far, "seed {seed}, step {step}: poses between");
        }
    }
    crossings
}

#[test]
fn a_game_at_the_corner_of_eight_sectors_is_the_same_everywhere() {
    let mut crossings = 0;
    for (index, by) in SHIFTS.into_iter().enumerate() {
        for seed in 0..4 {
            let seed = 10 * index as u64 + seed;
            crossings += match seed % 3 {
                0 => compare(seed, by, &mut Serial),
                1 => compare(seed, by, &mut Shuffled::new(seed)),
                _ => compare(seed, by, &mut Pool::new(3).expect("threads")),
            };
        }
    }
    assert!(crossings > 200, "{crossings} times a body changed its sector");
}

/// Saves, restores, loads and sends the state of a far world; each goes on as the near one does.
#[test]
fn states_go_everywhere_from_far_away() {
    for (seed, by) in SHIFTS.into_iter().enumerate() {
        let (mut simulator, mut here, mut there) = start(100 + seed as u64, by);
        let capacities = *there.capacities();
        let base = snapshot(&there);
        let mut late = simulator::empty_world(capacities);
        for step in 0..60 {
            play(&mut simulator, &mut here, &mut there, by);
            if step % 12 == 5 {
                // Back, into another world, and as the difference from the start.
                let mut bytes = snapshot(&there);
                there.step(&mut Serial);
                there.restore(&bytes).expect("its own");
                OwnedWorld::seal(&mut bytes).expect("a snapshot");
                late.load(&bytes).expect("states of far worlds are sound");
                let sent = delta::encode(&there, &base, &bytes).expect("its own snapshots");
                assert!(delta::apply(&late, &base, &sent).expect("the same base") == bytes);
                assert_same_but_for(by, &here, &late, &format!("loaded before step {step}"));
                std::mem::swap(&mut there, &mut late);
            }
            let (near, far) = (here.step(&mut Serial), there.step(&mut Serial));
            if has_left(by, &near, &far) {
                break;
            }
            assert_same_but_for(by, &here, &there, &format!("step {step}"));
        }
    }
}

#[test]
fn far_games_are_recorded_and_play_again() {
    for (seed, by) in SHIFTS.into_iter().enumerate() {
        let (mut simulator, mut here, mut there) = start(200 + seed as u64, by);
        let mut assets = AssetSet::new();
        simulator::assets(&mut world_with(*there.capacities()), &mut assets);
        let options = Options { checksums_every: 1, keyframes_every: 20, ..Options::default() };
        let mut recorder = Recorder::new(Vec::new(), &there, &assets, &options).expect("its assets");
        let (mut steps, mut left) = (0, false);
        while steps < 60 && !left {
            simulator.play_with(&mut here, |world, command| {
                let outcome = world.apply(&moved_command(command, CORNER, [0; 3]));
                let far = recorder.apply(&mut there, &moved_command(command, CORNER, by));
                assert_eq!(far, outcome);
                outcome
            });
            let (near, far) = (here.step(&mut Serial), recorder.step(&mut there, &mut Serial));
            (steps, left) = (steps + 1, has_left(by, &near, &far));
        }
        let replay = Replay::read(recorder.finish(&there).expect("room")).expect("it is read");
        let limits = Limits::default();
        let verdict = verify(&replay, &mut Serial, &limits).expect("its world is made");
        assert!(matches!(verdict, Verdict::Same { steps: told, .. } if told == steps), "{by:?}: {verdict:?}");
        let mut player = Player::new(&replay, &limits).expect("its world is made");
        player.seek(steps, &mut Serial).expect("its keyframes are states");
        assert!(snapshot(player.world()) == snapshot(&there), "{by:?}");
        if !left {
            assert_same_but_for(by, &here, &there, "recorded");
        }
    }
}
