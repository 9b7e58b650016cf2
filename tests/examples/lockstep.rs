//! Two machines play a game over a network that delays and loses datagrams, with the crate `ggrs`.
//!
//! `cargo run -p cellstep-tests --example lockstep`
//!
//! First they predict each other's inputs and go back when they were wrong. Then they wait for all inputs of each
//! frame, and send the checksum of the state along with their own. Last, one of them computes one bit otherwise:
//! that is noticed, and two recordings tell which number of which body it was.

#[path = "lockstep/duel.rs"]
mod duel;
#[path = "lockstep/fault.rs"]
mod fault;
#[path = "lockstep/game.rs"]
mod game;
#[path = "lockstep/network.rs"]
mod network;
#[path = "lockstep/peer.rs"]
mod peer;

use cellstep::BodyHandle;
use cellstep::replay::{Bisection, Limits, Replay, bisect};
use duel::Rules;
use fault::Flip;
use network::Weather;
use peer::{Peer, Tape, WINDOW};
use std::error::Error;

const FRAMES: u64 = 240;
const WEATHER: [Weather; 2] =
    [Weather { lost: 100, delay: (1, 5), seed: 1 }, Weather { lost: 100, delay: (1, 5), seed: 2 }];

/// The checksum of the world after all frames, played on one machine that has all inputs.
fn offline(delay: u64) -> Result<u64, Box<dyn Error>> {
    let mut peer = Peer::new(None)?;
    for frame in 0..FRAMES {
        let pressed = |player| frame.checked_sub(delay).map_or(0, |frame| game::buttons(player, frame));
        peer.advance([(pressed(0), 0), (pressed(1), 0)], delay);
    }
    Ok(peer.world.checksum())
}

/// Both machines play, and have the state of the offline game.
fn play(name: &str, rules: Rules) -> Result<(), Box<dyn Error>> {
    let mut sides = duel::sides(rules, [None, None])?;
    let mut last = [0; 2];
    duel::run(&mut sides, FRAMES, |machine, frame, _, snapshot| {
        if frame == FRAMES {
            let mut world = game::yard()?;
            world.restore(snapshot)?;
            last[machine] = world.checksum();
        }
        Ok::<(), Box<dyn Error>>(())
    })?;
    let offline = offline(rules.delay as u64)?;
    for (side, sum) in sides.iter().zip(last) {
        let (loads, steps) = (side.peer.loads, side.peer.steps);
        println!("{name}: went back {loads} times, {steps} steps, checksum {sum:016x}");
        assert_eq!(sum, offline, "as offline");
        assert_eq!((side.told, side.peer.desync), (None, None), "no desync");
    }
    Ok(())
}

fn main() -> Result<(), Box<dyn Error>> {
    let rollback = Rules { window: WINDOW, delay: 0, weather: WEATHER };
    play("rollback", rollback)?;
    play("lockstep", Rules { window: 0, delay: 2, weather: WEATHER })?;

    let flip = Flip { frame: 100, body: BodyHandle { index: 9, generation: 1 }, bit: 3 };
    let mut sides = duel::sides(rollback, [None, Some(flip.fault())])?;
    let mut tapes = [Tape::new()?, Tape::new()?];
    duel::run(&mut sides, 130, |machine, _, played, snapshot| {
        Ok::<(), Box<dyn Error>>(tapes[machine].note(played, snapshot)?)
    })?;
    println!("one bit flipped in frame {}: told of in frames {:?}", flip.frame, sides.map(|side| side.told));
    let [a, b] = tapes;
    let (a, b) = (Replay::read(a.finish()?)?, Replay::read(b.finish()?)?);
    let Bisection::Parted(parting) = bisect(&a, &b, &Limits::default())? else { panic!("they parted") };
    print!("{parting}");
    assert_eq!(parting.field.as_ref().and_then(|field| field.bodies[0]), Some(flip.body));
    Ok(())
}
