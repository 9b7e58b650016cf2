//! Models in MJCF, MuJoCo's XML format: read, resolved, and turned into scenes.
//!
//! ```text
//! files --> tree (includes, limits) --> Model (rigid bodies, joints, everything resolved) --> Scene
//!             text, tree                  walk, geom, joint, links                             convert
//! ```
mod convert;
mod geom;
mod joint;
mod library;
mod links;
mod mass;
mod math;
mod mesh;
mod model;
mod names;
mod settings;
mod text;
mod tree;
mod values;
mod vocabulary;
mod walk;
mod warning;

#[cfg(test)]
mod tests;

pub use convert::Conversion;
pub use math::{Placement, Turn, Vector};
pub use model::*;
pub use settings::Options;
pub use warning::{Effect, Warning};

use crate::scene::{Limits, SceneError};
use library::Library;
use std::path::Path;

impl Model {
    /// Reads a model from a file.
    pub fn read(file: &Path, limits: &Limits) -> Result<Self, SceneError> {
        walk::walk(&Library::open(file, limits)?)
    }

    /// Reads a model from text that names no other files.
    pub fn from_xml(text: &[u8], limits: &Limits) -> Result<Self, SceneError> {
        walk::walk(&Library::of_text(text, limits)?)
    }
}
