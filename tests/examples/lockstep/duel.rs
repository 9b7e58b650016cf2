//! A match of two machines in one process, over UDP.

use super::game::{self, Played};
use super::network::{Network, Weather};
use super::peer::{Fault, Input, Net, Peer};
use cellstep::Error;
use ggrs::{DesyncDetection, GgrsError, GgrsEvent, P2PSession, PlayerType, SessionBuilder};
use std::net::SocketAddr;
use std::time::Duration;

/// How a match is played.
#[derive(Clone, Copy, Debug)]
pub struct Rules {
    /// Frames that a machine may run ahead of what it knows; 0: it waits for the inputs of each frame.
    pub window: usize,
    /// Frames from a press to its effect.
    pub delay: usize,
    /// The network before each machine.
    pub weather: [Weather; 2],
}

/// One machine with its session.
pub struct Side {
    /// The machine.
    pub peer: Peer,
    /// The first frame that its session told to have two checksums.
    pub told: Option<i32>,
    session: P2PSession<Net>,
    player: usize,
    rules: Rules,
}

/// Both machines before the first frame.
pub fn sides(rules: Rules, faults: [Option<Fault>; 2]) -> Result<[Side; 2], Box<dyn std::error::Error>> {
    let [a, b] = rules.weather.map(Network::new);
    let (a, b) = (a?, b?);
    let (at_a, at_b) = (a.address()?, b.address()?);
    let [fault_a, fault_b] = faults;
    let new = |player: usize, network: Network, other: SocketAddr, fault: Option<Fault>| {
        // Without a window the session saves nothing, and so has no checksums to compare.
        let detection =
            if rules.window == 0 { DesyncDetection::Off } else { DesyncDetection::On { interval: 1 } };
        let session = SessionBuilder::<Net>::new()
            .with_max_prediction_window(rules.window)
            .with_input_delay(rules.delay)
            .with_desync_detection_mode(detection)
            // A machine that has much to do is no machine that has left.
            .with_disconnect_timeout(Duration::from_secs(120))
            .with_disconnect_notify_delay(Duration::from_secs(60))
            .add_player(PlayerType::Local, player)?
            .add_player(PlayerType::Remote(other), 1 - player)?
            .start_p2p_session(network)?;
        let peer = Peer::new(fault)?;
        Ok::<Side, Box<dyn std::error::Error>>(Side { peer, told: None, session, player, rules })
    };
    Ok([new(0, a, at_b, fault_a)?, new(1, b, at_a, fault_b)?])
}

impl Side {
    /// One pass of the machine's loop: network, inputs, steps. True when the session went on by a frame.
    ///
    /// `hand_on` gets final states, as [`Peer::settle`] gives them.
    pub fn pass<E: From<Error> + From<GgrsError>>(
        &mut self,
        hand_on: impl FnMut(u64, &[Played], &[u8]) -> Result<(), E>,
    ) -> Result<bool, E> {
        let (session, peer) = (&mut self.session, &mut self.peer);
        let frame = session.current_frame();
        let mut input: Input = (game::buttons(self.player, frame as u64), 0);
        if session.in_lockstep_mode() {
            input.1 = peer.world.checksum();
        }
        session.add_local_input(self.player, input)?;
        match session.advance_frame() {
            Ok(requests) => peer.fulfil(requests, self.rules.delay as u64)?,
            Err(GgrsError::NotSynchronized | GgrsError::PredictionThreshold) => {}
            Err(error) => return Err(error.into()),
        }
        if session.in_lockstep_mode() {
            peer.save()?;
        }
        peer.settle(session.confirmed_frame(), hand_on)?;
        for event in session.events() {
            if let GgrsEvent::DesyncDetected { frame, .. } = event {
                self.told = Some(self.told.map_or(frame, |told| told.min(frame)));
            }
        }
        Ok(session.current_frame() > frame)
    }
}

/// Plays until both machines have final states up to that of frame `frames`. `hand_on` gets the machine, and what
/// [`Peer::settle`] gives.
pub fn run<E: From<Error> + From<GgrsError>>(
    sides: &mut [Side; 2],
    frames: u64,
    mut hand_on: impl FnMut(usize, u64, &[Played], &[u8]) -> Result<(), E>,
) -> Result<(), E> {
    while sides.iter().any(|side| side.peer.settled() < frames) {
        let mut went_on = false;
        for (machine, side) in sides.iter_mut().enumerate() {
            went_on |= side.pass(|frame, played, state| hand_on(machine, frame, played, state))?;
        }
        if !went_on {
            // Both wait for the network, which sends again after a while.
            std::thread::sleep(Duration::from_micros(200));
        }
    }
    Ok(())
}
