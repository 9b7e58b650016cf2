//! Rollback and lockstep over a bad network with `ggrs`: both machines have the bits of an offline run, and a
//! machine that computes one bit otherwise is found. The machines are those of the example `lockstep`.

#[path = "../examples/lockstep/duel.rs"]
mod duel;
#[path = "../examples/lockstep/fault.rs"]
mod fault;
#[path = "../examples/lockstep/game.rs"]
mod game;
#[path = "../examples/lockstep/network.rs"]
mod network;
#[path = "../examples/lockstep/peer.rs"]
mod peer;

use cellstep::replay::{Bisection, Limits, Replay, Verdict, bisect, verify};
use cellstep::{BodyHandle, Command, Serial};
use cellstep_tests::simulator::snapshot;
use duel::Rules;
use fault::Flip;
use ggrs::{GgrsError, SessionBuilder};
use network::Weather;
use peer::{Fault, Net, Peer, Tape, WINDOW};
use std::convert::Infallible;
use std::error::Error;

type Outcome = Result<(), Box<dyn Error>>;

const FRAMES: u64 = 600;
/// One of the crates, and the frame after which a machine goes astray.
const FLIP: Flip = Flip { frame: 200, body: BodyHandle { index: 9, generation: 1 }, bit: 2 };

fn weather(lost: [u64; 2]) -> [Weather; 2] {
    let [a, b] = lost;
    [Weather { lost: a, delay: (1, 5), seed: 11 }, Weather { lost: b, delay: (1, 5), seed: 12 }]
}

/// What a run did.
#[derive(Default)]
struct Counts {
    made: usize,
    removed: usize,
    pushed: usize,
}

/// The snapshots of a run without a network after each frame.
fn offline(delay: u64) -> (Vec<Vec<u8>>, Counts) {
    let mut world = game::yard().expect("memory");
    let (mut played, mut states, mut counts) = (Vec::new(), Vec::new(), Counts::default());
    for frame in 0..FRAMES {
        let pressed = |player| frame.checked_sub(delay).map_or(0, |frame| game::buttons(player, frame));
        played.clear();
        game::play(&mut world, [pressed(0), pressed(1)], &mut played);
        assert!(played.len() <= game::COMMANDS_MAX);
        for (command, is_refused) in &played {
            assert!(!is_refused || matches!(command, Command::CreateBody(_)), "{command:?}");
            counts.made += usize::from(matches!(command, Command::CreateBody(_)) && !is_refused);
            counts.removed += usize::from(matches!(command, Command::RemoveBody(_)));
            counts.pushed += usize::from(matches!(command, Command::ApplyImpulse(..)));
        }
        let report = world.step(&mut Serial);
        assert_eq!((report.dropped, report.quarantined), (0, 0));
        states.push(snapshot(&world));
    }
    (states, counts)
}

/// Plays a match, and compares each final state of both machines with the offline run.
fn check_match(rules: Rules) -> [Peer; 2] {
    let (states, counts) = offline(rules.delay as u64);
    assert!(counts.made > 20 && counts.removed > 10 && counts.pushed > 20, "the inputs do something");
    let mut sides = duel::sides(rules, [None, None]).expect("sockets");
    let mut compared = [0; 2];
    let outcome: Outcome = duel::run(&mut sides, FRAMES, |machine, frame, _, state| {
        if let Some(expected) = states.get(frame as usize - 1) {
            assert!(state == expected, "machine {machine}: another state after frame {frame}");
            compared[machine] += 1;
        }
        Ok(())
    });
    outcome.expect("both go on");
    assert_eq!(compared, [FRAMES; 2]);
    sides.map(|side| {
        assert_eq!((side.told, side.peer.desync), (None, None), "nobody tells of a difference");
        side.peer
    })
}

#[test]
fn rollback_has_the_bits_of_an_offline_run() {
    let peers = check_match(Rules { window: WINDOW, delay: 0, weather: weather([100; 2]) });
    for peer in peers {
        assert!(peer.loads > 20, "it went back {} times", peer.loads);
        assert!(peer.steps > FRAMES + u64::from(peer.loads), "{} steps", peer.steps);
    }
}

#[test]
fn lockstep_has_the_bits_of_an_offline_run() {
    let peers = check_match(Rules { window: 0, delay: 2, weather: weather([100; 2]) });
    assert!(peers.iter().all(|peer| peer.loads == 0), "nothing was predicted");
}

/// Plays a match in which the second machine goes astray, and finds the place in the recordings. Gives both sides.
fn check_flip(rules: Rules) -> [duel::Side; 2] {
    let mut sides = duel::sides(rules, [None, Some(FLIP.fault())]).expect("sockets");
    let mut tapes = [Tape::new().expect("memory"), Tape::new().expect("memory")];
    let outcome: Outcome = duel::run(&mut sides, FLIP.frame + 30, |machine, _, played, state| {
        Ok(tapes[machine].note(played, state)?)
    });
    outcome.expect("both go on");
    let [a, b] = tapes.map(|tape| Replay::read(tape.finish().expect("memory")).expect("it is whole"));
    let found = bisect(&a, &b, &Limits::default()).expect("worlds are made");
    let Bisection::Parted(found) = found else { panic!("they are not the same") };
    assert_eq!((found.step, found.agreed), (FLIP.frame, Some(FLIP.frame - 1)), "{found}");
    let field = found.field.as_ref().expect("both states are known");
    assert_eq!(field.place(), format!("motions[{}].linear[1]", FLIP.body.index), "{found}");
    assert_eq!((field.bodies, field.bodies_that_differ), ([Some(FLIP.body), None], 1), "{found}");
    let [Some(x), Some(y)] = field.bits else { panic!("{found}") };
    assert_eq!(x ^ y, 1 << FLIP.bit, "{found}");
    // The first recording is right, the second is not: its own machine alone tells so.
    let verdict = |replay: &Replay| verify(replay, &mut Serial, &Limits::default()).expect("worlds are made");
    assert!(matches!(verdict(&a), Verdict::Same { .. }));
    let Verdict::Diverged(divergence) = verdict(&b) else { panic!("it is noticed") };
    assert_eq!(divergence.step, FLIP.frame);
    sides
}

/// Reports of checksums are not sent again: what comes to the first machine is delayed, but not lost.
#[test]
fn a_flipped_bit_is_told_of_in_its_frame() {
    let [first, second] = check_flip(Rules { window: WINDOW, delay: 0, weather: weather([0, 100]) });
    assert_eq!(first.told, Some(FLIP.frame as i32));
    assert!(second.told.is_none_or(|frame| frame >= FLIP.frame as i32));
    assert!(first.peer.loads > 10 && second.peer.loads > 10, "the step was taken more than once");
}

/// Checksums that go with the inputs arrive when these do, whatever is lost.
#[test]
fn a_flipped_bit_is_told_of_in_its_frame_in_lockstep() {
    for side in check_flip(Rules { window: 0, delay: 2, weather: weather([100; 2]) }) {
        assert_eq!((side.peer.desync, side.told), (Some(FLIP.frame), None));
    }
}

/// Plays alone, going back by `distance` frames after each.
fn sync_test(distance: usize, fault: Option<Fault>) -> Result<Peer, GgrsError> {
    let session =
        SessionBuilder::<Net>::new().with_max_prediction_window(WINDOW).with_check_distance(distance);
    let mut session = session.start_synctest_session()?;
    let mut peer = Peer::new(fault).expect("memory");
    for frame in 0..200 {
        for player in 0..2 {
            session.add_local_input(player, (game::buttons(player, frame), 0))?;
        }
        let requests = session.advance_frame()?;
        peer.fulfil(requests, 0).expect("the ring has the state");
    }
    Ok(peer)
}

#[test]
fn steps_taken_again_give_the_same_bits() {
    let (states, _) = offline(0);
    for distance in [2, 3, 5, 7] {
        let peer = sync_test(distance, None).expect("no difference");
        assert!(peer.loads > 190, "it went back {} times", peer.loads);
        assert!(snapshot(&peer.world) == states[199], "distance {distance}");
    }
}

/// The same machine as before, which computes another bit when it takes a step for the third time.
#[test]
fn another_bit_the_next_time_is_noticed() {
    let mut times = 0;
    let fault = move |world: &mut cellstep::World<cellstep::Memory>| {
        if world.steps() == 100 {
            times += 1;
            if times == 3 {
                FLIP.plant(world);
            }
        }
    };
    let Err(GgrsError::MismatchedChecksum { mismatched_frames, .. }) = sync_test(5, Some(Box::new(fault)))
    else {
        panic!("it is noticed")
    };
    assert_eq!(mismatched_frames.first(), Some(&100));
}

/// On our side: requests, commands, steps, snapshots, checksums and going back.
#[test]
fn a_frame_allocates_nothing() {
    let session = SessionBuilder::<Net>::new().with_max_prediction_window(WINDOW).with_check_distance(4);
    let mut session = session.start_synctest_session().expect("two players");
    let mut peer = Peer::new(None).expect("memory");
    for frame in 0..120 {
        for player in 0..2 {
            session.add_local_input(player, (game::buttons(player, frame), 0)).expect("a player");
        }
        let requests = session.advance_frame().expect("no difference");
        let found = allocation_counter::measure(|| peer.fulfil(requests, 0).expect("the ring has the state"));
        assert_eq!(found.count_total, 0, "in frame {frame}");
        let mut bytes = 0;
        let found = allocation_counter::measure(|| {
            let outcome = peer.settle(frame as i32 - 5, |_, _, state| {
                bytes += state.len();
                Ok::<(), Infallible>(())
            });
            outcome.expect("nothing is refused");
        });
        assert_eq!(found.count_total, 0, "in frame {frame}");
        assert!(bytes > 0 || frame <= 5);
    }
    assert!(peer.loads > 100);
}
