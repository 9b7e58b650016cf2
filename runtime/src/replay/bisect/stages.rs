//! Steps seen from inside: what each stage left, and the first stage that left something else.

use super::states::Sections;
use cellstep_core::{Observer, Stage, StageView};

/// What there was to see after a stage.
#[derive(Clone, Debug)]
pub(super) struct Sight {
    pub stage: Stage,
    pub sections: Sections,
    /// Rows of the solver.
    rows: Sections,
}

impl Sight {
    fn new(stage: Stage, view: &StageView<'_, '_>) -> Self {
        let owned = |(name, bytes): (&'static str, &[u8])| (name, bytes.to_vec());
        Self { stage, sections: view.sections().map(owned).collect(), rows: view.rows().map(owned).collect() }
    }
}

/// Keeps what there is to see of one step.
#[derive(Clone, Debug, Default)]
pub(super) struct Camera {
    pub sights: Vec<Sight>,
}

impl Observer for Camera {
    fn after(&mut self, stage: Stage, view: &StageView<'_, '_>) {
        self.sights.push(Sight::new(stage, view));
    }
}

impl Camera {
    /// The last stage that changed some bytes of a section, from what they were before the step.
    pub fn last_writer(&self, before: &Sections, section: &str, byte: usize) -> Option<Stage> {
        let read = |sections: &Sections| {
            let bytes = sections.iter().find(|(name, _)| *name == section).map(|(_, bytes)| bytes);
            bytes.and_then(|bytes| bytes.get(byte).copied())
        };
        let (mut last, mut value) = (None, read(before));
        for sight in &self.sights {
            let now = read(&sight.sections);
            if now != value {
                (last, value) = (Some(sight.stage), now);
            }
        }
        last
    }
}

fn same<'v>(mut own: impl Iterator<Item = (&'static str, &'v [u8])>, other: &Sections) -> bool {
    let mut others = other.iter();
    own.all(|(name, bytes)| others.next().is_some_and(|other| other.0 == name && other.1 == bytes))
        && others.next().is_none()
}

/// Compares a step with what was seen of another.
#[derive(Debug)]
pub(super) struct Comparison<'a> {
    other: &'a Camera,
    seen: usize,
    /// The first stage after which anything differed, the solver's rows included.
    pub first: Option<Stage>,
    /// The first state that differed: what the other had, and what is here.
    pub states: Option<(Sections, Sections)>,
}

impl<'a> Comparison<'a> {
    pub fn new(other: &'a Camera) -> Self {
        Self { other, seen: 0, first: None, states: None }
    }
}

impl Observer for Comparison<'_> {
    fn after(&mut self, stage: Stage, view: &StageView<'_, '_>) {
        let Some(other) = self.other.sights.get(self.seen) else { return };
        self.seen += 1;
        if self.states.is_some() {
            return;
        }
        let same_state = same(view.sections(), &other.sections);
        if self.first.is_none() && !(same_state && same(view.rows(), &other.rows)) {
            self.first = Some(stage);
        }
        if !same_state {
            self.states = Some((other.sections.clone(), Sight::new(stage, view).sections));
        }
    }
}
