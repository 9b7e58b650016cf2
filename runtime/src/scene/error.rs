//! What can be wrong with a scene, said so that its author can mend it: file, line, column, path in the
//! document, what was found and what was expected.

use cellstep_core::Error;
use std::fmt;
use std::path::{Path, PathBuf};

/// Why a scene was refused.
#[derive(Debug)]
pub struct SceneError {
    /// The file that is wrong; `None` for a scene that came from memory.
    pub file: Option<PathBuf>,
    /// Line and column in that file, from 1; `None` where it has no such place.
    pub at: Option<(usize, usize)>,
    /// Where in the document, as `bodies[3].shapes[0].geometry.sphere.radius`; empty for the document itself.
    pub path: String,
    /// What is wrong and what was expected.
    pub problem: Problem,
}

/// What is wrong.
#[non_exhaustive]
#[derive(Debug)]
pub enum Problem {
    /// The file could not be read: check its name and its permissions.
    Read(std::io::Error),
    /// The text is not a scene document: mend it at the given place.
    Format(String),
    /// A value breaks a rule of the format.
    Invalid {
        /// What was found.
        found: String,
        /// What was expected.
        expected: String,
    },
    /// The scene asks for more than the limits allow; nothing was allocated for it.
    TooLarge {
        /// What there is too much of.
        what: &'static str,
        /// How much was asked.
        asked: u64,
        /// How much is allowed.
        limit: u64,
    },
    /// A mesh file is not one that can be read.
    Mesh(String),
    /// The engine refused what the document asks for.
    World(Error),
}

impl SceneError {
    pub(super) fn new(path: impl ToString, problem: Problem) -> Self {
        Self { file: None, at: None, path: path.to_string(), problem }
    }

    pub(super) fn invalid(path: impl ToString, found: impl ToString, expected: impl ToString) -> Self {
        Self::new(path, Problem::Invalid { found: found.to_string(), expected: expected.to_string() })
    }

    /// Names the scene's file, where no file is named yet, and finds line and column of the path in its text.
    pub fn in_text(mut self, file: &Path, text: &[u8]) -> Self {
        if self.file.is_none() {
            self.file = Some(file.to_path_buf());
            if self.at.is_none() {
                self.at = super::place::locate(text, &self.path);
            }
        }
        self
    }
}

impl fmt::Display for SceneError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(file) = &self.file {
            write!(f, "{}", file.display())?;
        }
        if let Some((line, column)) = self.at {
            write!(f, "{}line {line}, column {column}", if self.file.is_some() { ": " } else { "" })?;
        }
        if self.file.is_some() || self.at.is_some() {
            write!(f, ": ")?;
        }
        if !self.path.is_empty() {
            write!(f, "{}: ", self.path)?;
        }
        write!(f, "{}", self.problem)
    }
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Problem::Read(error) => write!(f, "cannot be read: {error}"),
            Problem::Format(message) => write!(f, "{message}"),
            Problem::Invalid { found, expected } => write!(f, "{found}, expected {expected}"),
            Problem::TooLarge { what, asked, limit } => {
                write!(f, "{asked} {what} are too many, expected at most {limit}")
            }
            Problem::Mesh(message) => write!(f, "{message}"),
            Problem::World(error) => write!(f, "refused by the engine: {error}"),
        }
    }
}

impl std::error::Error for SceneError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match &self.problem {
            Problem::Read(error) => Some(error),
            Problem::World(error) => Some(error),
            _ => None,
        }
    }
}
