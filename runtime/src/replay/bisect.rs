//! Where two runs parted: the first step, the first stage, the first body and field, and both values.
//!
//! Two replays of one game hold commands, checksums and keyframes of two machines. A third run, here, stands for
//! whichever of them it agrees with: where its checksum is the recorded one, its state is the recorded one, to the
//! bit. So one keyframe of the run that went astray is enough to name the field.

mod stages;
mod states;

pub use states::FieldDifference;

use super::play::save;
use super::read::Evidence;
use super::{Cause, Checksums, Keyframe, Limits, Player, Replay, ReplayError, total};
use crate::Memory;
use cellstep_core::{Executor, Serial, Stage, World, xxh64};
use stages::{Camera, Comparison};
use states::{Sections, first_difference, sections_of};
use std::fmt;

/// What was found.
#[derive(Clone, Debug, PartialEq)]
pub enum Bisection {
    /// No difference in so many steps.
    Same {
        /// Steps that both have.
        steps: u64,
    },
    /// The first difference.
    Parted(Box<Parting>),
}

/// Where two runs parted.
#[derive(Clone, Debug, PartialEq)]
pub struct Parting {
    /// Steps after which the states differ for the first time, as far as is known; with [`Moment::Commands`] those
    /// before the step whose commands differ.
    pub step: u64,
    /// Steps after which they were known to be equal.
    pub agreed: Option<u64>,
    /// When in the step it happened.
    pub moment: Moment,
    /// The two runs, in the order of the values.
    pub runs: [Run; 2],
    /// The first number that differs, if both states are known.
    pub field: Option<FieldDifference>,
    /// Steps after which `field` was seen: later than `step` where the first state of both that is known is.
    pub field_step: u64,
    /// What there is to say beside, for people.
    pub message: String,
}

/// When in a step something happened.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Moment {
    /// Before the first step: worlds or first states are not the same.
    Start,
    /// The commands before a step, or their outcomes, are not the same.
    Commands,
    /// Between two steps: the world was changed by calls that were not recorded.
    BetweenSteps,
    /// In this stage: seen from inside.
    Stage(Stage),
    /// In this stage or before: it is the last one that writes the field.
    LastWriter(Stage),
    /// In some step since the two agreed.
    Unknown,
}

impl Moment {
    /// In a word; a stage has its own name.
    pub const fn name(self) -> &'static str {
        match self {
            Moment::Start => "start",
            Moment::Commands => "commands",
            Moment::BetweenSteps => "between steps",
            Moment::Stage(stage) | Moment::LastWriter(stage) => stage.name(),
            Moment::Unknown => "unknown",
        }
    }
}

/// Whose values they are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Run {
    /// As the first replay tells.
    First,
    /// As the second replay tells.
    Second,
    /// Played here.
    Here,
    /// Played here, by the second executor and without caches.
    HereAgain,
}

impl Run {
    /// For people.
    pub const fn name(self) -> &'static str {
        match self {
            Run::First => "first recording",
            Run::Second => "second recording",
            Run::Here => "played here",
            Run::HereAgain => "played here again",
        }
    }
}

impl fmt::Display for Parting {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{:<10} {}", "step", self.step)?;
        if let Some(agreed) = self.agreed {
            writeln!(f, "{:<10} after step {agreed}", "agreed")?;
        }
        let how =
            if matches!(self.moment, Moment::LastWriter(_)) { " (the last that writes it)" } else { "" };
        writeln!(f, "{:<10} {}{how}", "stage", self.moment.name())?;
        writeln!(f, "{:<10} {} and {}", "runs", self.runs[0].name(), self.runs[1].name())?;
        match &self.field {
            Some(field) => writeln!(f, "{:<10} after step {}: {field}", "field", self.field_step)?,
            None => writeln!(f, "{:<10} not known: one of the two states is not in a keyframe", "field")?,
        }
        writeln!(f, "{:<10} {}", "message", self.message)
    }
}

/// A replay played twice side by side: here and again, by another executor and with all caches dropped before each
/// step. Both are compared after each stage, and with what was recorded.
///
/// # Errors
/// Those of [`Replay::new_world`].
pub fn bisect_self(
    replay: &Replay,
    first: &mut impl Executor,
    second: &mut impl Executor,
    limits: &Limits,
) -> Result<Bisection, ReplayError> {
    bisect_self_with(replay, (first, second), limits, |_| ())
}

/// [`bisect_self`], which calls `progress` with the number of steps so far.
///
/// # Errors
/// Those of [`Replay::new_world`].
pub fn bisect_self_with(
    replay: &Replay,
    (first, second): (&mut impl Executor, &mut impl Executor),
    limits: &Limits,
    mut progress: impl FnMut(u64),
) -> Result<Bisection, ReplayError> {
    let (mut here, mut again) = (Player::new(replay, limits)?, Player::new(replay, limits)?);
    let mut known = Known::new(replay, None);
    loop {
        if let Some(parting) = known.compare(&mut here)? {
            return Ok(Bisection::Parted(parting));
        }
        progress(here.steps() - replay.first_step());
        if here.is_at_end() {
            return Ok(Bisection::Same { steps: replay.last_step() - replay.first_step() });
        }
        if let Some(parting) = known.compare_within(&here, replay, limits)? {
            return Ok(Bisection::Parted(parting));
        }
        known.remember(&here);
        if let Some(divergence) = here.apply() {
            let (step, message) = (divergence.step, divergence.to_string());
            return Ok(commands_differ(step, [Run::First, Run::Here], message));
        }
        again.apply();
        again.world_mut().drop_caches();
        known.camera = Camera::default();
        here.advance_observed(first, &mut known.camera);
        let mut comparison = Comparison::new(&known.camera);
        again.advance_observed(second, &mut comparison);
        let (stage, states) = (comparison.first, comparison.states);
        if let Some(stage) =
            stage.or((here.world().state() != again.world().state()).then_some(Stage::Finish))
        {
            let [mine, other] = [here.world(), again.world()].map(state_of);
            let (mine, other) = states.unwrap_or((mine, other));
            return Ok(Bisection::Parted(Box::new(Parting {
                step: here.steps(),
                agreed: Some(here.steps() - 1),
                moment: Moment::Stage(stage),
                runs: [Run::Here, Run::HereAgain],
                field: first_difference(here.world(), &mine, &other),
                field_step: here.steps(),
                message: "two runs of the same commands gave other bits".to_string(),
            })));
        }
    }
}

/// Two replays of one game.
///
/// # Errors
/// Those of [`Replay::new_world`].
pub fn bisect(a: &Replay, b: &Replay, limits: &Limits) -> Result<Bisection, ReplayError> {
    bisect_with(a, b, limits, |_| ())
}

/// [`bisect`], which calls `progress` with the number of steps so far.
///
/// # Errors
/// Those of [`Replay::new_world`].
pub fn bisect_with(
    a: &Replay,
    b: &Replay,
    limits: &Limits,
    mut progress: impl FnMut(u64),
) -> Result<Bisection, ReplayError> {
    let runs = [Run::First, Run::Second];
    let start = |field, message: &str| {
        let (step, moment, message) = (a.first_step(), Moment::Start, message.to_string());
        let parting = Parting { step, agreed: None, moment, runs, field, field_step: step, message };
        Ok(Bisection::Parted(Box::new(parting)))
    };
    if (a.layout_hash(), a.assets_hash()) != (b.layout_hash(), b.assets_hash()) {
        return start(None, "the worlds have other capacities or other assets");
    }
    let mut here = Player::new(a, limits)?;
    let [first, second] = [a, b].map(|replay| replay.keyframes().next());
    let (first, second) = (first.ok_or(ReplayError::NoStart)?, second.ok_or(ReplayError::NoStart)?);
    if a.first_step() != b.first_step() || first.snapshot != second.snapshot {
        let [x, y] = [first, second].map(|keyframe| sections_of(here.world(), keyframe.snapshot));
        return start(first_difference(here.world(), &x, &y), "the first states are not the same");
    }
    let last = a.last_step().min(b.last_step());
    let mut known = Known::new(a, Some(b));
    loop {
        if let Some(parting) = known.compare(&mut here)? {
            return Ok(Bisection::Parted(parting));
        }
        let step = here.steps();
        progress(step - a.first_step());
        if step >= last {
            return Ok(Bisection::Same { steps: last - a.first_step() });
        }
        known.remember(&here);
        if a.command_bytes(step) != b.command_bytes(step) {
            return other_commands(&mut here, [a, b], limits);
        }
        if let Some(parting) = known.compare_within(&here, a, limits)? {
            return Ok(Bisection::Parted(parting));
        }
        if let Some(divergence) = here.apply() {
            return Ok(commands_differ(step, [Run::First, Run::Here], divergence.to_string()));
        }
        known.camera = Camera::default();
        here.advance_observed(&mut Serial, &mut known.camera);
    }
}

fn commands_differ(step: u64, runs: [Run; 2], message: String) -> Bisection {
    let (agreed, moment) = (Some(step), Moment::Commands);
    Bisection::Parted(Box::new(Parting {
        step,
        agreed,
        moment,
        runs,
        field: None,
        field_step: step,
        message,
    }))
}

/// The replays have other commands for the coming step: says which, and what becomes of it.
fn other_commands(
    here: &mut Player<'_>,
    [a, b]: [&Replay; 2],
    limits: &Limits,
) -> Result<Bisection, ReplayError> {
    let step = here.steps();
    let mut pairs = (0..).zip(a.commands(step).map(Some).chain(std::iter::repeat(None)));
    let mut others = b.commands(step).map(Some).chain(std::iter::repeat(None));
    let (index, mine, other) = loop {
        let (index, mine) = pairs.next().expect("it goes on");
        let other = others.next().expect("it goes on");
        // Texts, since what is not a number is not equal to itself.
        if format!("{mine:?}") != format!("{other:?}") || mine.is_none() {
            break (index, mine, other);
        }
    };
    let text = |command: Option<super::StepCommand>| match command {
        None => "nothing".to_string(),
        Some(command) => {
            let outcome = if command.is_refused { "refused" } else { "accepted" };
            format!("{:?} ({outcome})", command.command)
        }
    };
    let message = format!("command {index} of step {}: {} and {}", step + 1, text(mine), text(other));
    // What follows from it: after the commands, or after the step.
    let mut snapshot = Vec::new();
    save(here.world(), &mut snapshot);
    let mut there = Player::new(b, limits)?;
    there.jump(step, &snapshot)?;
    let mut field_step = step;
    here.apply();
    there.apply();
    if here.world().state() == there.world().state() {
        here.advance(&mut Serial);
        there.advance(&mut Serial);
        field_step += 1;
    }
    let [x, y] = [here.world(), there.world()].map(state_of);
    let field = first_difference(here.world(), &x, &y);
    let (agreed, moment, runs) = (Some(step), Moment::Commands, [Run::First, Run::Second]);
    Ok(Bisection::Parted(Box::new(Parting { step, agreed, moment, runs, field, field_step, message })))
}

fn state_of(world: &World<Memory>) -> Sections {
    let mut snapshot = Vec::new();
    save(world, &mut snapshot);
    sections_of(world, &snapshot)
}

/// What the recordings say, against the run here.
struct Known<'a> {
    replays: [Option<&'a Replay>; 2],
    /// Steps after which each is known to agree with the run here.
    agreed: [Option<u64>; 2],
    /// The state before the step that was taken last, and what was seen of it.
    before: Sections,
    camera: Camera,
}

/// A recording that tells of another state than there is here.
struct Stray {
    is_between: bool,
    /// Its state, if there is a keyframe.
    state: Option<Sections>,
    /// Its checksums, if there are.
    sums: Option<Checksums>,
    message: String,
}

impl Stray {
    /// True when both tell of one state, as far as they can be compared.
    fn agrees(&self, other: &Self) -> bool {
        match (&self.state, &other.state, &self.sums, &other.sums) {
            (Some(x), Some(y), ..) => x == y,
            (_, _, Some(x), Some(y)) => x == y,
            _ => false,
        }
    }
}

impl<'a> Known<'a> {
    fn new(first: &'a Replay, second: Option<&'a Replay>) -> Self {
        let start = Some(first.first_step());
        Self {
            replays: [Some(first), second],
            agreed: [start, start],
            before: Vec::new(),
            camera: Camera::default(),
        }
    }

    /// Keeps the state before a step, if somebody tells of that after it.
    fn remember(&mut self, here: &Player<'_>) {
        let next = here.steps() + 1;
        let is_told = self.replays.iter().flatten().any(|replay| replay.evidence(next).next().is_some());
        self.before = if is_told { state_of(here.world()) } else { Vec::new() };
    }

    /// Compares the state here with the recordings, and them with each other.
    fn compare(&mut self, here: &mut Player<'_>) -> Result<Option<Box<Parting>>, ReplayError> {
        let step = here.steps();
        let mut strays = [None, None];
        for (which, replay) in self.replays.iter().enumerate() {
            let Some(replay) = replay else { continue };
            match stray(replay, here)? {
                Some(stray) => strays[which] = Some(stray),
                None if replay.evidence(step).next().is_some() => self.agreed[which] = Some(step),
                None => {}
            }
        }
        let (which, partner) = match (&strays[0], &strays[1]) {
            (None, None) => return Ok(None),
            // The same change without a record in both, as by a game that always does so.
            (Some(a), Some(b)) if a.is_between && b.is_between && a.state == b.state => {
                let unrecorded = self.replays[0].into_iter().flat_map(Replay::keyframes);
                let keyframe = unrecorded.filter(|other| other.step == step && other.after == 0).last();
                here.jump(step, keyframe.ok_or(ReplayError::NoStart)?.snapshot)?;
                return Ok(None);
            }
            (Some(a), Some(b)) if !a.agrees(b) => (0, Some(1)),
            (Some(_), _) => (0, None),
            (None, Some(_)) => (1, None),
        };
        let name = |which: usize| if which == 0 { Run::First } else { Run::Second };
        let both = partner.is_some();
        let stray = strays[which].take().expect("it strays");
        let other_state = match partner {
            Some(partner) => strays[partner].take().and_then(|stray| stray.state),
            None => Some(state_of(here.world())),
        };
        let (states, field_step) = match (stray.state, other_state) {
            (Some(mine), Some(other)) => (Some([mine, other]), step),
            (None, Some(_)) if !both => match self.later(here, which)? {
                Some((states, later)) => (Some(states), later),
                None => (None, step),
            },
            _ => (None, step),
        };
        // The run here stands for the other recording, unless that differs from it in the same way.
        let here_stands = self.replays[1].is_some() && strays[1 - which].is_none();
        let runs = if both || here_stands { [Run::First, Run::Second] } else { [name(which), Run::Here] };
        let states = states.map(|[mine, other]| if which == 1 { [other, mine] } else { [mine, other] });
        let field = states.and_then(|[x, y]| first_difference(here.world(), &x, &y));
        let agreed = if stray.is_between { Some(step) } else { self.agreed[which] };
        let moment = self.moment(&field, (step, field_step, agreed), stray.is_between);
        let message = if both {
            format!("{}; the second recording differs from the run here, too", stray.message)
        } else if here_stands {
            let (own, other) = (name(which).name(), name(1 - which).name());
            format!(
                "{}: in the {own}; the {other} agrees with the run here as far as it tells",
                stray.message
            )
        } else if strays[1 - which].is_some() {
            format!("{}: both recordings differ from the run here in the same way", stray.message)
        } else {
            stray.message
        };
        Ok(Some(Box::new(Parting { step, agreed, moment, runs, field, field_step, message })))
    }

    /// Compares the states between the commands of the coming step with the recordings that tell of them.
    fn compare_within(
        &self,
        here: &Player<'_>,
        replay: &Replay,
        limits: &Limits,
    ) -> Result<Option<Box<Parting>>, ReplayError> {
        let step = here.steps();
        let told = self.replays.map(|replay| {
            replay.map_or(Vec::new(), |replay| replay.keyframes_within(step).collect::<Vec<_>>())
        });
        if told.iter().all(Vec::is_empty) {
            return Ok(None);
        }
        let mut snapshot = Vec::new();
        save(here.world(), &mut snapshot);
        let mut there = Player::new(replay, limits)?;
        there.jump(step, &snapshot)?;
        for (index, command) in replay.commands(step).enumerate() {
            there.give(&command, index);
            save(there.world(), &mut snapshot);
            for (which, keyframes) in told.iter().enumerate() {
                let strays = |keyframe: &&Keyframe<'_>| {
                    keyframe.after as usize == index + 1 && keyframe.snapshot != snapshot.as_slice()
                };
                let Some(stray) = keyframes.iter().find(strays) else { continue };
                let [mine, other] =
                    [stray.snapshot, snapshot.as_slice()].map(|bytes| sections_of(there.world(), bytes));
                let (own, other, runs) = match (which, self.replays[1]) {
                    (0, None) => (mine, other, [Run::First, Run::Here]),
                    (0, Some(_)) => (mine, other, [Run::First, Run::Second]),
                    _ => (other, mine, [Run::First, Run::Second]),
                };
                let message = format!(
                    "after command {index} of step {} the world was changed by calls that were not recorded: \
                     in the {}",
                    step + 1,
                    if which == 0 { Run::First.name() } else { Run::Second.name() },
                );
                return Ok(Some(Box::new(Parting {
                    step,
                    agreed: Some(step),
                    moment: Moment::Commands,
                    runs,
                    field: first_difference(there.world(), &own, &other),
                    field_step: step,
                    message,
                })));
            }
        }
        Ok(None)
    }

    fn moment(
        &self,
        field: &Option<FieldDifference>,
        (step, field_step, agreed): (u64, u64, Option<u64>),
        is_between: bool,
    ) -> Moment {
        if is_between {
            return Moment::BetweenSteps;
        }
        let Some(field) =
            field.as_ref().filter(|_| field_step == step && agreed.is_some_and(|a| a + 1 == step))
        else {
            return Moment::Unknown;
        };
        let writer = self.camera.last_writer(&self.before, field.section, field.byte());
        writer.map_or(Moment::Unknown, Moment::LastWriter)
    }

    /// The first state of a recording after the one that is only known to differ, and that of the run here then.
    fn later(
        &self,
        here: &mut Player<'_>,
        which: usize,
    ) -> Result<Option<([Sections; 2], u64)>, ReplayError> {
        let step = here.steps();
        let Some(replay) = self.replays[which] else { return Ok(None) };
        let is_later = |keyframe: &Keyframe<'_>| keyframe.step > step && keyframe.after == 0;
        let Some(keyframe) = replay.keyframes().find(is_later) else {
            return Ok(None);
        };
        while here.steps() < keyframe.step && !here.is_at_end() {
            here.apply();
            here.advance(&mut Serial);
        }
        let mine = sections_of(here.world(), keyframe.snapshot);
        Ok((here.steps() == keyframe.step).then(|| ([mine, state_of(here.world())], keyframe.step)))
    }
}

/// What a recording tells of another state than there is here.
fn stray(replay: &Replay, here: &Player<'_>) -> Result<Option<Stray>, ReplayError> {
    let mut own: Option<(Vec<u8>, Checksums)> = None;
    let mut found: Option<Stray> = None;
    // What was recorded of this state before and is as here: then it was changed after the step.
    let mut same = 0;
    for evidence in replay.evidence(here.steps()) {
        let (snapshot, sums) = own.get_or_insert_with(|| {
            let mut snapshot = Vec::new();
            save(here.world(), &mut snapshot);
            let sections: Vec<u64> = here.world().checksum_by_section().map(|(_, sum)| sum).collect();
            (snapshot, Checksums { step: here.steps(), total: total(&sections), sections })
        });
        match evidence {
            Evidence::Checksums(recorded) if recorded != *sums => {
                let message = format!("checksum {:016x}, here {:016x}", recorded.total, sums.total);
                let stray = Stray { is_between: false, state: None, sums: None, message };
                found.get_or_insert(stray).sums = Some(recorded);
            }
            Evidence::Keyframe(keyframe) if keyframe.snapshot != snapshot.as_slice() => {
                let is_between = found.is_none() && (keyframe.cause == Cause::Unrecorded || same > 0);
                let message = if is_between {
                    "the world was changed by calls that were not recorded".to_string()
                } else {
                    let [x, y] = [keyframe.snapshot, snapshot.as_slice()].map(|bytes| xxh64(bytes, 0));
                    format!("a keyframe with hash {x:016x}, here {y:016x}")
                };
                let state = Some(sections_of(here.world(), keyframe.snapshot));
                match &mut found {
                    Some(found) => found.state = found.state.take().or(state),
                    None => found = Some(Stray { is_between, state, sums: None, message }),
                }
            }
            _ => same += 1,
        }
    }
    Ok(found)
}
