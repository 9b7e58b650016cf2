//! What a model says and cellstep does not do: one entry for each kind of element or attribute.

use std::collections::BTreeMap;
use std::fmt;
use std::path::PathBuf;

/// What is lost when something is left out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Effect {
    /// Bodies move otherwise than the model says.
    Motion,
    /// Not a word of the format, or not at this place: probably misspelled.
    Unknown,
    /// How MuJoCo solves; cellstep solves in its own way.
    Solver,
    /// Nothing that moves: looks, sensors, names, sizes of buffers.
    Nothing,
}

/// Something that was left out.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Warning {
    /// What it changes.
    pub effect: Effect,
    /// What it is: `geom/solimp` for an attribute, `light` for an element, or a sentence.
    pub what: String,
    /// How often it is in the files; what is replicated counts once.
    pub count: usize,
    /// File of the first place; `None` for text from memory.
    pub file: Option<PathBuf>,
    /// Line and column of the first place, from 1; `None` for what only a conversion leaves out.
    pub at: Option<(usize, usize)>,
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let said = match self.effect {
            Effect::Motion => "not modelled",
            Effect::Unknown => "not a word of MJCF here, ignored",
            Effect::Solver => "of MuJoCo's solver, ignored",
            Effect::Nothing => "without effect on motion, ignored",
        };
        write!(f, "{}: {said}", self.what)?;
        let Some((line, column)) = self.at else {
            return if self.count > 1 { write!(f, " ({} times)", self.count) } else { Ok(()) };
        };
        let times = if self.count > 1 { format!("{} times, first at ", self.count) } else { String::new() };
        let file = self.file.as_ref().map_or(String::new(), |file| format!("{}: ", file.display()));
        write!(f, " ({times}{file}line {line}, column {column})")
    }
}

/// Warnings in the order of their first places.
#[derive(Clone, Default)]
pub(super) struct Warnings {
    pub list: Vec<Warning>,
    known: BTreeMap<(Effect, String), usize>,
}

impl Warnings {
    /// Adds a warning, or counts it where it is known.
    pub(super) fn add(&mut self, new: Warning) {
        let key = (new.effect, new.what.clone());
        if let Some(&known) = self.known.get(&key) {
            self.list[known].count += new.count;
        } else if self.list.len() < KINDS_MAX {
            self.known.insert(key, self.list.len());
            self.list.push(new);
        } else if self.list.len() == KINDS_MAX {
            // A stranger may make up words without end: they share an entry.
            self.list.push(Warning { effect: Effect::Unknown, what: "others".to_string(), ..new });
        } else {
            self.list[KINDS_MAX].count += new.count;
        }
    }
}

/// Most kinds of things that are told apart: far more than the format has.
const KINDS_MAX: usize = 1000;
