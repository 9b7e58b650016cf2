//! Playing a replay, and comparing with it.

use super::read::Evidence;
use super::{Cause, Checksums, Keyframe, Limits, Replay, ReplayError, StepCommand};
use crate::Memory;
use cellstep_core::{Command, Executor, Line, Observer, StepReport, World};
use std::fmt;

/// A world that follows a replay.
#[derive(Debug)]
pub struct Player<'a> {
    replay: &'a Replay,
    world: World<Memory>,
    step: u64,
    /// A snapshot, to compare with keyframes.
    buffer: Vec<u8>,
}

/// Where a world and a replay parted.
#[derive(Clone, Debug, PartialEq)]
pub struct Divergence {
    /// Steps of the recording when it was noticed: the state after this many steps, or a command before the next.
    pub step: u64,
    /// What was noticed.
    pub difference: Difference,
}

/// How a world and a replay differ.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Difference {
    /// A command was refused that was not, or the other way round.
    Outcome {
        /// Which command of the step, from 0.
        index: usize,
        /// The command.
        command: Box<Command>,
        /// Whether it was refused when it was recorded.
        was_refused: bool,
    },
    /// The state has another checksum.
    Checksum {
        /// The checksum that was recorded.
        recorded: u64,
        /// The checksum here.
        found: u64,
        /// The sections of the state that differ.
        sections: Vec<&'static str>,
    },
    /// The state is not that of a keyframe.
    Keyframe {
        /// The sections of the state that differ.
        sections: Vec<&'static str>,
    },
    /// The recorded world was changed by calls that are not in the replay: see [`Cause::Unrecorded`].
    Unrecorded {
        /// Commands of the coming step that came before.
        after: u32,
        /// The sections of the state that were changed.
        sections: Vec<&'static str>,
    },
}

/// What came of playing a replay to its end.
#[derive(Clone, Debug, PartialEq)]
pub enum Verdict {
    /// Everything that the replay says is so.
    Same {
        /// Steps that were taken.
        steps: u64,
        /// Checksums and keyframes that were compared, the first state not included.
        compared: u64,
    },
    /// The first difference.
    Diverged(Divergence),
}

impl<'a> Player<'a> {
    /// A world at the start of a replay.
    ///
    /// # Errors
    /// Those of [`Replay::new_world`].
    pub fn new(replay: &'a Replay, limits: &Limits) -> Result<Self, ReplayError> {
        let world = replay.new_world(limits)?;
        Ok(Self { replay, world, step: replay.first_step(), buffer: Vec::new() })
    }

    /// The world as it is now.
    pub fn world(&self) -> &World<Memory> {
        &self.world
    }

    /// The world as it is now, to query it. What changes it makes it another one than the recorded.
    pub fn world_mut(&mut self) -> &mut World<Memory> {
        &mut self.world
    }

    /// Steps of the recording so far.
    pub fn steps(&self) -> u64 {
        self.step
    }

    /// Goes to the state after `step` steps: from the last keyframe before it, forwards or backwards. At a keyframe
    /// the world is as it says, also where it was changed without a record.
    ///
    /// # Errors
    /// [`ReplayError::World`] when the keyframe is refused.
    pub fn seek(&mut self, step: u64, executor: &mut impl Executor) -> Result<(), ReplayError> {
        let step = step.clamp(self.replay.first_step(), self.replay.last_step());
        let before = self.replay.keyframes().take_while(|keyframe| keyframe.step <= step);
        let keyframe = before.filter(|keyframe| keyframe.after == 0).last();
        let keyframe = keyframe.ok_or(ReplayError::NoStart)?;
        if keyframe.step > self.step || step < self.step || keyframe.step == step {
            self.world.load(keyframe.snapshot)?;
            self.step = keyframe.step;
        }
        while self.step < step {
            self.follow()?;
            self.advance(executor);
        }
        Ok(())
    }

    /// Compares the state with what the replay knows of it here. Gives the number of checksums and keyframes that
    /// were compared.
    ///
    /// # Errors
    /// The first difference.
    pub fn compare(&mut self) -> Result<u64, Divergence> {
        let mut compared = 0;
        for evidence in self.replay.evidence(self.step) {
            let difference = match evidence {
                Evidence::Keyframe(keyframe) if keyframe.cause == Cause::Start => continue,
                Evidence::Checksums(sums) => compare_sums(&self.world, &sums),
                Evidence::Keyframe(keyframe) => self.compare_keyframe(&keyframe),
            };
            compared += 1;
            if let Some(difference) = difference {
                return Err(Divergence { step: self.step, difference });
            }
        }
        Ok(compared)
    }

    fn compare_keyframe(&mut self, keyframe: &Keyframe<'_>) -> Option<Difference> {
        save(&self.world, &mut self.buffer);
        if self.buffer == keyframe.snapshot {
            return None;
        }
        let sections = differing(&self.world, &self.buffer, keyframe.snapshot);
        Some(match keyframe.cause {
            Cause::Unrecorded => Difference::Unrecorded { after: keyframe.after, sections },
            _ => Difference::Keyframe { sections },
        })
    }

    /// Gives the world the commands of the coming step, and compares with keyframes between them. Gives the first
    /// difference, of states or of outcomes.
    pub fn apply(&mut self) -> Option<Divergence> {
        let (step, mut first) = (self.step, None);
        let mut within = self.replay.keyframes_within(step).peekable();
        for (index, command) in self.replay.commands(step).enumerate() {
            first = first.or(self.give(&command, index));
            while let Some(keyframe) = within.next_if(|keyframe| keyframe.after as usize == index + 1) {
                let difference = self.compare_keyframe(&keyframe);
                first = first.or(difference.map(|difference| Divergence { step, difference }));
            }
        }
        first
    }

    /// Gives the world the commands of the coming step, and takes over what was changed between them without a
    /// record.
    fn follow(&mut self) -> Result<(), ReplayError> {
        let mut within = self.replay.keyframes_within(self.step).peekable();
        for (index, command) in self.replay.commands(self.step).enumerate() {
            self.give(&command, index);
            while let Some(keyframe) = within.next_if(|keyframe| keyframe.after as usize == index + 1) {
                self.world.load(keyframe.snapshot)?;
            }
        }
        Ok(())
    }

    /// Gives the world a command; says when its outcome is another than recorded.
    pub(super) fn give(&mut self, command: &StepCommand, index: usize) -> Option<Divergence> {
        let is_refused = self.world.apply(&command.command).is_err();
        let was_refused = command.is_refused;
        (is_refused != was_refused).then(|| {
            let difference = Difference::Outcome { index, command: Box::new(command.command), was_refused };
            Divergence { step: self.step, difference }
        })
    }

    /// Takes the step.
    pub fn advance(&mut self, executor: &mut impl Executor) -> StepReport {
        self.step += 1;
        self.world.step(executor)
    }

    /// Takes the step with somebody who looks.
    pub(super) fn advance_observed(
        &mut self,
        executor: &mut impl Executor,
        observer: &mut impl Observer,
    ) -> StepReport {
        self.step += 1;
        self.world.step_observed(executor, observer)
    }

    /// Goes to a state.
    pub(super) fn jump(&mut self, step: u64, snapshot: &[u8]) -> Result<(), ReplayError> {
        self.world.load(snapshot)?;
        self.step = step;
        Ok(())
    }

    /// True when all steps of the replay were taken.
    pub fn is_at_end(&self) -> bool {
        self.step >= self.replay.last_step()
    }
}

/// Plays a replay from its start to its end, and compares with all that it says.
///
/// # Errors
/// Those of [`Replay::new_world`].
pub fn verify(
    replay: &Replay,
    executor: &mut impl Executor,
    limits: &Limits,
) -> Result<Verdict, ReplayError> {
    verify_with(replay, executor, limits, |_| ())
}

/// [`verify`], which calls `progress` with the number of steps so far after each.
///
/// # Errors
/// Those of [`Replay::new_world`].
pub fn verify_with(
    replay: &Replay,
    executor: &mut impl Executor,
    limits: &Limits,
    mut progress: impl FnMut(u64),
) -> Result<Verdict, ReplayError> {
    let mut player = Player::new(replay, limits)?;
    let mut compared = 0;
    loop {
        match player.compare() {
            Ok(count) => compared += count,
            Err(divergence) => return Ok(Verdict::Diverged(divergence)),
        }
        if player.is_at_end() {
            let steps = replay.last_step() - replay.first_step();
            return Ok(Verdict::Same { steps, compared });
        }
        if let Some(divergence) = player.apply() {
            return Ok(Verdict::Diverged(divergence));
        }
        player.advance(executor);
        progress(player.steps() - replay.first_step());
    }
}

fn compare_sums(world: &World<Memory>, recorded: &Checksums) -> Option<Difference> {
    let own: Vec<(&'static str, u64)> = world.checksum_by_section().collect();
    let sums: Vec<u64> = own.iter().map(|(_, sum)| *sum).collect();
    let found = super::total(&sums);
    if found == recorded.total && sums == recorded.sections {
        return None;
    }
    let differ = own.iter().enumerate().filter(|(i, (_, sum))| recorded.sections.get(*i) != Some(sum));
    let sections = differ.map(|(_, (name, _))| *name).collect();
    Some(Difference::Checksum { recorded: recorded.total, found, sections })
}

/// A sealed snapshot.
pub(super) fn save(world: &World<Memory>, out: &mut Vec<u8>) {
    out.resize(world.snapshot_bytes(), 0);
    world.save(out).expect("there is room");
    World::<Vec<Line>>::seal(out).expect("it is a snapshot");
}

/// Names of the sections that differ between two snapshots.
pub(super) fn differing(world: &World<Memory>, a: &[u8], b: &[u8]) -> Vec<&'static str> {
    let (Ok(a_sections), Ok(b_sections)) = (world.snapshot_sections(a), world.snapshot_sections(b)) else {
        return Vec::new();
    };
    let differ = a_sections.zip(b_sections).filter(|(x, y)| a[x.range.clone()] != b[y.range.clone()]);
    differ.map(|(section, _)| section.name).collect()
}

impl fmt::Display for Divergence {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let step = self.step;
        match &self.difference {
            Difference::Outcome { index, command, was_refused } => {
                let (was, now) = if *was_refused { ("refused", "accepted") } else { ("accepted", "refused") };
                write!(f, "before step {}: command {index} was {was} and is {now}: {command:?}", step + 1)
            }
            Difference::Checksum { recorded, found, sections } => {
                let sections = sections.join(", ");
                write!(f, "after step {step}: checksum {found:016x}, recorded {recorded:016x}, in {sections}")
            }
            Difference::Keyframe { sections } => {
                write!(f, "after step {step}: the state differs from the keyframe in {}", sections.join(", "))
            }
            Difference::Unrecorded { after, sections } => {
                write!(f, "after step {step}")?;
                if *after > 0 {
                    write!(f, " and {after} commands")?;
                }
                write!(f, ": the recorded world was changed without a record, in {}", sections.join(", "))
            }
        }
    }
}
