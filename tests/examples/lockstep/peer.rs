//! One machine of a match: what its session asks for, done with a world and a ring of snapshots.
//!
//! ```text
//! SaveGameState   ring.save(world), and the world's checksum into the session's cell
//! LoadGameState   ring.restore(world, frame)
//! AdvanceFrame    inputs -> commands -> world.step
//! ```
//! The session gets no state, only checksums: the ring has the states, in memory that is taken once. A state is
//! final when all inputs before it have arrived; then it is handed on, to be recorded.

use super::game::{self, CAPACITIES, COMMANDS_MAX, Played};
use cellstep::replay::{AssetSet, Cause, Options, ReplayError, Writer};
use cellstep::{Error, Memory, Serial, SnapshotRing, World, new_ring};
use ggrs::{Config, GgrsRequest, PredictRepeatLast};
use std::net::SocketAddr;

/// Frames that a session may run ahead of what it knows.
pub const WINDOW: usize = 8;
/// States that are kept: those to go back to, and those that are not handed on yet.
const DEPTH: usize = WINDOW + 4;

/// What goes over the network: buttons, and, without a window, the checksum of the state that they were pressed in.
pub type Input = (u8, u64);

/// The session's types.
pub struct Net;

impl Config for Net {
    type Input = Input;
    type InputPredictor = PredictRepeatLast;
    // The ring has the states.
    type State = ();
    type Address = SocketAddr;
}

/// A machine that computes something else: called after each step.
pub type Fault = Box<dyn FnMut(&mut World<Memory>)>;

/// One machine's side of a match.
pub struct Peer {
    /// The world.
    pub world: World<Memory>,
    /// How often it went back.
    pub loads: u32,
    /// Steps that it has taken, those that were taken again included.
    pub steps: u64,
    /// The first frame whose checksums differ, of those that came with inputs.
    pub desync: Option<u64>,
    ring: SnapshotRing<Memory>,
    /// Commands of the last frames.
    played: Vec<Vec<Played>>,
    /// Frames whose final states were handed on.
    settled: u64,
    fault: Option<Fault>,
}

impl Peer {
    /// A machine before the first frame.
    pub fn new(fault: Option<Fault>) -> Result<Self, Error> {
        let (world, ring) = (game::yard()?, new_ring(&CAPACITIES, DEPTH)?);
        let played = (0..DEPTH).map(|_| Vec::with_capacity(COMMANDS_MAX)).collect();
        Ok(Self { world, loads: 0, steps: 0, desync: None, ring, played, settled: 0, fault })
    }

    /// Does what the session asks for. Allocates nothing. `delay` is the number of frames from a press to its
    /// effect.
    pub fn fulfil(&mut self, requests: Vec<GgrsRequest<Net>>, delay: u64) -> Result<(), Error> {
        for request in requests {
            match request {
                GgrsRequest::SaveGameState { cell, frame } => {
                    assert_eq!(self.world.steps(), frame as u64, "a frame is a step");
                    self.ring.save(&self.world)?;
                    cell.save(frame, None, Some(u128::from(self.world.checksum())));
                }
                GgrsRequest::LoadGameState { frame, .. } => {
                    self.ring.restore(&mut self.world, frame as u64)?;
                    self.loads += 1;
                }
                GgrsRequest::AdvanceFrame { inputs } => self.advance([inputs[0].0, inputs[1].0], delay),
            }
        }
        Ok(())
    }

    /// One step with the inputs of all players.
    pub fn advance(&mut self, [first, second]: [Input; 2], delay: u64) {
        let frame = self.world.steps();
        if first.1 != second.1 && self.desync.is_none() {
            self.desync = Some(frame - delay);
        }
        let played = &mut self.played[frame as usize % DEPTH];
        played.clear();
        game::play(&mut self.world, [first.0, second.0], played);
        self.world.step(&mut Serial);
        self.steps += 1;
        if let Some(fault) = &mut self.fault {
            fault(&mut self.world);
        }
    }

    /// Hands on the final states up to that of frame `confirmed`, in order: the commands before the step, and the
    /// snapshot after it.
    pub fn settle<E>(
        &mut self,
        confirmed: i32,
        mut hand_on: impl FnMut(u64, &[Played], &[u8]) -> Result<(), E>,
    ) -> Result<(), E> {
        while i64::try_from(self.settled).is_ok_and(|settled| settled < i64::from(confirmed)) {
            let Ok(snapshot) = self.ring.get(self.settled + 1) else { break };
            hand_on(self.settled + 1, &self.played[self.settled as usize % DEPTH], snapshot)?;
            self.settled += 1;
        }
        Ok(())
    }

    /// Frames whose final states were handed on.
    pub fn settled(&self) -> u64 {
        self.settled
    }

    /// Saves the state, where the session does not ask for it.
    pub fn save(&mut self) -> Result<(), Error> {
        self.ring.save(&self.world)
    }
}

/// Writes final states as a replay, each with a keyframe: two of them tell which number of which body differs.
pub struct Tape(Writer<Vec<u8>>);

impl Tape {
    /// A replay that begins with the yard.
    pub fn new() -> Result<Self, ReplayError> {
        let world = game::yard()?;
        let options = Options { checksums_every: 0, keyframes_every: 1, ..Options::default() };
        Ok(Self(Writer::new(Vec::new(), &world, &AssetSet::new(), &options)?))
    }

    /// Takes what [`Peer::settle`] hands on.
    pub fn note(&mut self, played: &[Played], snapshot: &[u8]) -> Result<(), ReplayError> {
        for (command, is_refused) in played {
            self.0.command(command, *is_refused);
        }
        self.0.step()?;
        self.0.keyframe(snapshot, Cause::Periodic)
    }

    /// The replay's bytes.
    pub fn finish(self) -> Result<Vec<u8>, ReplayError> {
        self.0.finish()
    }
}
