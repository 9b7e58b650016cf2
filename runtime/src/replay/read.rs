//! Reading a replay.

use super::format::{
    ASSET, CHECKSUMS, END, KEYFRAME, Next, Record, Records, STEP, WORLD, WorldRecord, u32_of, u64_of,
};
use super::{AssetSet, Cause, Limits, ReplayError};
use crate::{Memory, new_world};
use cellstep_core::{Capacities, Command, Line, World};
use std::fs;
use std::ops::Range;
use std::path::Path;

/// A replay that was read: its records are checked and indexed, its commands decode.
#[derive(Clone, Debug)]
pub struct Replay {
    bytes: Vec<u8>,
    world: WorldRecord,
    assets: Vec<Range<usize>>,
    first: u64,
    steps: Vec<StepPlace>,
    marks: Vec<Mark>,
    is_finished: bool,
    /// Bytes up to the end of the last whole record.
    whole: usize,
}

/// Where the commands of a step lie.
#[derive(Clone, Debug)]
struct StepPlace {
    commands: Range<usize>,
    count: u32,
}

/// Something that tells of the state between steps.
#[derive(Clone, Debug)]
struct Mark {
    /// Steps of the world then, and commands since.
    step: u64,
    after: u32,
    /// Why there is a keyframe; `None` for checksums.
    cause: Option<Cause>,
    range: Range<usize>,
}

/// Checksums in a replay.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Checksums {
    /// [`World::steps`] then.
    pub step: u64,
    /// [`World::checksum`].
    pub total: u64,
    /// [`World::checksum_by_section`], in its order.
    pub sections: Vec<u64>,
}

/// A keyframe in a replay.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Keyframe<'a> {
    /// Steps of the recording then.
    pub step: u64,
    /// Commands since that step: mostly none.
    pub after: u32,
    /// Why it is there.
    pub cause: Cause,
    /// What [`World::load`] takes.
    pub snapshot: &'a [u8],
}

/// A command in a replay.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepCommand {
    /// The command.
    pub command: Command,
    /// Whether the world refused it.
    pub is_refused: bool,
}

/// What a replay knows of the state between two steps.
pub(super) enum Evidence<'a> {
    Checksums(Checksums),
    Keyframe(Keyframe<'a>),
}

impl Replay {
    /// Reads a file.
    ///
    /// # Errors
    /// [`ReplayError::Io`], and those of [`Replay::read`].
    pub fn open(path: &Path) -> Result<Self, ReplayError> {
        Self::read(fs::read(path)?)
    }

    /// Reads bytes from anywhere. Bytes that end in the middle of a record are taken up to it, see
    /// [`Replay::is_finished`].
    ///
    /// # Errors
    /// A [`ReplayError`] for bytes that are no replay of this version, damaged, or end before the first state.
    pub fn read(bytes: Vec<u8>) -> Result<Self, ReplayError> {
        let mut records = Records::new(&bytes)?;
        let Next::Record(first) = records.next()? else { return Err(ReplayError::NoStart) };
        let world = (first.kind == WORLD).then(|| WorldRecord::read(first.payload)).flatten();
        let world = world.ok_or(malformed(&first, "it does not tell the world"))?;
        let mut index = Index::default();
        while let Next::Record(record) = records.next()? {
            if let Some(what) = index.add(&record) {
                return Err(malformed(&record, what));
            }
        }
        let Index { assets, first, steps, marks, is_finished } = index;
        let first = first.ok_or(ReplayError::NoStart)?;
        let whole = records.offset();
        Ok(Self { bytes, world, assets, first, steps, marks, is_finished, whole })
    }

    /// True when the recording was finished: nothing is missing at the end.
    pub fn is_finished(&self) -> bool {
        self.is_finished
    }

    /// Bytes at the end that are no whole record: what was being written when the recording was cut off.
    pub fn cut_bytes(&self) -> usize {
        self.bytes.len() - self.whole
    }

    /// Bytes of the replay.
    pub fn bytes(&self) -> usize {
        self.bytes.len()
    }

    /// Steps of the world at the start.
    pub fn first_step(&self) -> u64 {
        self.first
    }

    /// Steps of the world at the end.
    pub fn last_step(&self) -> u64 {
        self.first + self.steps.len() as u64
    }

    /// What its world can hold.
    pub fn capacities(&self) -> &Capacities {
        &self.world.capacities
    }

    /// The capacities with their names.
    pub fn named_capacities(&self) -> impl Iterator<Item = (&'static str, u32)> {
        super::format::NAMES.into_iter().zip(super::format::to_numbers(&self.world.capacities))
    }

    /// [`World::layout_hash`] of its world.
    pub fn layout_hash(&self) -> u64 {
        self.world.layout_hash
    }

    /// [`World::assets_hash`] of its world.
    pub fn assets_hash(&self) -> u64 {
        self.world.assets_hash
    }

    /// How many assets its world has, and their bytes.
    pub fn assets(&self) -> (usize, usize) {
        (self.assets.len(), self.assets.iter().map(Range::len).sum())
    }

    /// How it was recorded.
    pub fn options(&self) -> super::Options {
        super::Options {
            checksums_every: self.world.checksums_every,
            keyframes_every: self.world.keyframes_every,
            watches_commands: self.world.watches_commands,
            note: self.world.note.clone(),
        }
    }

    /// The commands before step `step + 1` of the world, in their order; none for steps that it does not have.
    pub fn commands(&self, step: u64) -> impl Iterator<Item = StepCommand> + '_ {
        let place = step.checked_sub(self.first).and_then(|i| self.steps.get(usize::try_from(i).ok()?));
        let mut rest = place.map_or(&[][..], |place| &self.bytes[place.commands.clone()]);
        std::iter::from_fn(move || take_command(&mut rest))
    }

    /// The bytes of these commands: equal bytes are equal commands with equal outcomes.
    pub(super) fn command_bytes(&self, step: u64) -> &[u8] {
        let place = step.checked_sub(self.first).and_then(|i| self.steps.get(usize::try_from(i).ok()?));
        place.map_or(&[], |place| &self.bytes[place.commands.clone()])
    }

    /// Number of all commands.
    pub fn command_count(&self) -> u64 {
        self.steps.iter().map(|place| u64::from(place.count)).sum()
    }

    /// The keyframes, ascending by step; the first is the start.
    pub fn keyframes(&self) -> impl Iterator<Item = Keyframe<'_>> {
        self.marks.iter().filter_map(|mark| {
            let snapshot = &self.bytes[mark.range.clone()];
            mark.cause.map(|cause| Keyframe { step: mark.step, after: mark.after, cause, snapshot })
        })
    }

    /// The checksums, ascending by step.
    pub fn checksums(&self) -> impl Iterator<Item = Checksums> + '_ {
        let without_cause = self.marks.iter().filter(|mark| mark.cause.is_none());
        without_cause.filter_map(|mark| match self.evidence_of(mark) {
            Evidence::Checksums(sums) => Some(sums),
            Evidence::Keyframe(_) => None,
        })
    }

    /// What is known of the state after `step` steps and before the next command, in the order of the recording.
    pub(super) fn evidence(&self, step: u64) -> impl Iterator<Item = Evidence<'_>> {
        let of_step = self.marks_of(step).take_while(|mark| mark.after == 0);
        of_step.map(|mark| self.evidence_of(mark))
    }

    /// Keyframes between the commands after `step` steps.
    pub(super) fn keyframes_within(&self, step: u64) -> impl Iterator<Item = Keyframe<'_>> {
        let within = self.marks_of(step).skip_while(|mark| mark.after == 0);
        within.filter_map(|mark| match self.evidence_of(mark) {
            Evidence::Keyframe(keyframe) => Some(keyframe),
            Evidence::Checksums(_) => None,
        })
    }

    fn marks_of(&self, step: u64) -> impl Iterator<Item = &Mark> {
        let start = self.marks.partition_point(|mark| mark.step < step);
        self.marks[start..].iter().take_while(move |mark| mark.step == step)
    }

    fn evidence_of(&self, mark: &Mark) -> Evidence<'_> {
        let bytes = &self.bytes[mark.range.clone()];
        match mark.cause {
            Some(cause) => {
                let (step, after) = (mark.step, mark.after);
                Evidence::Keyframe(Keyframe { step, after, cause, snapshot: bytes })
            }
            None => {
                let mut sums = bytes.chunks_exact(8).map(|sum| {
                    let mut eight = [0; 8];
                    eight.copy_from_slice(sum);
                    u64::from_le_bytes(eight)
                });
                let total = sums.next().unwrap_or(0);
                Evidence::Checksums(Checksums { step: mark.step, total, sections: sums.collect() })
            }
        }
    }

    /// Makes the world of the replay, as it was at the start.
    ///
    /// # Errors
    /// [`ReplayError::TooLarge`]; [`ReplayError::World`] and [`ReplayError::Malformed`] for capacities, assets or a
    /// state that no recording has.
    pub fn new_world(&self, limits: &Limits) -> Result<World<Memory>, ReplayError> {
        let capacities = self.world.capacities;
        capacities.check()?;
        let bytes = (capacities.lines() as u64).saturating_mul(size_of::<Line>() as u64);
        if bytes > limits.world_bytes {
            return Err(ReplayError::TooLarge { bytes, limit: limits.world_bytes });
        }
        let mut world = new_world(capacities)?;
        let mut assets = AssetSet::new();
        for range in &self.assets {
            assets.register_bytes(&self.bytes[range.clone()], &mut world).map_err(|error| match error {
                ReplayError::World(error) => ReplayError::World(error),
                _ => ReplayError::Malformed { offset: range.start, what: "it is no asset" },
            })?;
        }
        if world.assets_hash() != self.world.assets_hash || world.layout_hash() != self.world.layout_hash {
            let what = "the world that it describes has another layout or other assets";
            return Err(ReplayError::Malformed { offset: super::format::PREAMBLE, what });
        }
        let start = self.keyframes().next().ok_or(ReplayError::NoStart)?;
        world.load(start.snapshot)?;
        Ok(world)
    }
}

fn malformed(record: &Record<'_>, what: &'static str) -> ReplayError {
    ReplayError::Malformed { offset: record.offset, what }
}

/// The next command, as long as there are whole ones.
fn take_command(rest: &mut &[u8]) -> Option<StepCommand> {
    let (&refused, after) = rest.split_first()?;
    let (command, length) = Command::decode(after).ok()?;
    *rest = &after[length..];
    (refused <= 1).then_some(StepCommand { command, is_refused: refused == 1 })
}

/// Where the records are, as far as they were read.
#[derive(Default)]
struct Index {
    assets: Vec<Range<usize>>,
    /// Steps at the start, once there is one.
    first: Option<u64>,
    steps: Vec<StepPlace>,
    marks: Vec<Mark>,
    is_finished: bool,
}

impl Index {
    /// Notes a record; says what is wrong with it, if something is.
    fn add(&mut self, record: &Record<'_>) -> Option<&'static str> {
        let start = record.offset + 5;
        let range = |skip: usize| start + skip..start + record.payload.len();
        let mut rest = record.payload;
        if self.is_finished {
            return Some("it stands after the end");
        }
        if record.kind == ASSET {
            self.assets.push(range(0));
            return self.first.is_some().then_some("assets stand before the first state");
        }
        let cause = if record.kind == KEYFRAME {
            let Some((&cause, after)) = rest.split_first() else { return Some("it is too short") };
            rest = after;
            let Some(&cause) = Cause::ALL.get(usize::from(cause)) else {
                return Some("a cause is not known");
            };
            Some(cause)
        } else {
            None
        };
        let Some(step) = u64_of(&mut rest) else { return Some("it is too short") };
        let is_start = cause == Some(Cause::Start);
        if is_start != self.first.is_none() {
            return Some("there is one first state, before all steps");
        }
        let first = *self.first.get_or_insert(step);
        if first.checked_add(self.steps.len() as u64) != Some(step) {
            return Some("its step is not the next one");
        }
        match record.kind {
            KEYFRAME => {
                let Some(after) = u32_of(&mut rest) else { return Some("it is too short") };
                let before = self.marks.last().filter(|mark| mark.step == step).map_or(0, |mark| mark.after);
                if after < before || is_start && after > 0 {
                    return Some("its state is before that of the mark before");
                }
                self.marks.push(Mark { step, after, cause, range: range(13) });
            }
            CHECKSUMS if rest.is_empty() || !rest.len().is_multiple_of(8) => {
                return Some("it has no whole checksums");
            }
            CHECKSUMS if self.marks.last().is_some_and(|mark| mark.step == step && mark.after > 0) => {
                return Some("checksums stand before the commands of a step");
            }
            CHECKSUMS => self.marks.push(Mark { step, after: 0, cause: None, range: range(8) }),
            STEP => return self.add_step(&mut rest, step, range(12)),
            END if rest.is_empty() => self.is_finished = true,
            _ => return Some("it is of no known kind"),
        }
        None
    }

    fn add_step(&mut self, rest: &mut &[u8], step: u64, commands: Range<usize>) -> Option<&'static str> {
        let Some(count) = u32_of(rest) else { return Some("it is too short") };
        if self.marks.last().is_some_and(|mark| mark.step == step && mark.after > count) {
            return Some("a keyframe stands after more commands than there are");
        }
        let mut found = 0u64;
        while take_command(rest).is_some() {
            found += 1;
        }
        if found != u64::from(count) || !rest.is_empty() {
            return Some("its commands are not as many as it says, or one is none");
        }
        self.steps.push(StepPlace { commands, count });
        None
    }
}
