//! Scenes: what a world starts with, as a JSON document, as a value, and as built-in makers.
//!
//! ```text
//! text --read--> Scene (a value, checked) --build--> World
//!                  ^
//!                  builtin::*
//! ```
//! A document may come from a stranger. It is read within [`Limits`], its numbers are checked before any
//! memory is taken for them, the files that it names lie below its own folder, and whatever is wrong is said
//! with file, line, column, path in the document and what was expected ([`SceneError`]).
//!
//! The format is described in `SCENES.md` at the root of the repository and, field by field, in
//! [`format`](mod@format).
//!
//! ```
//! use cellstep::scene::{Limits, Scene};
//!
//! let text = r#"{
//!   "bodies": [
//!     { "kind": "static", "shapes": [{ "geometry": "half_space" }] },
//!     { "position": [0, 0, 5], "shapes": [{ "geometry": { "sphere": { "radius": 0.5 } } }] }
//!   ]
//! }"#;
//! let scene = Scene::from_json(text.as_bytes(), &Limits::default())?;
//! let mut built = scene.build(std::path::Path::new("."))?;
//! built.world.step(&mut cellstep::Serial);
//! assert!(built.world.position(built.bodies[1]).unwrap().to_f64()[2] < 5.0);
//!
//! let error = Scene::from_json(br#"{ "bodies": [{ "mas": 1 }] }"#, &Limits::default()).unwrap_err();
//! assert!(error.to_string().starts_with("line 1, column 23: bodies[0].mas: unknown field `mas`, expected"));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod bounded;
mod build;
pub mod builtin;
mod check;
mod clean;
mod error;
pub mod format;
mod joints;
mod obj;
mod place;
mod polygon;
mod read;
mod rotation;
mod strict;
mod text;

pub use build::{Build, CONTACTS_PER_SHAPE, PAIRS_PER_SHAPE, ROOM_BASE, capacities};
pub use clean::Notes;
pub use error::{Problem, SceneError};
pub use format::Scene;
pub(crate) use obj::{read as read_obj, read_file};
pub use read::load;

/// How much a scene may ask for. The defaults suit a tool on a desktop; a server that takes scenes from
/// players sets them lower.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Bytes of a document, and of each mesh file.
    pub file_bytes: u64,
    /// Bodies, and room for bodies. Documents are never read beyond [`format::BODIES_MAX`].
    pub bodies: u64,
    /// Shapes, and room for shapes.
    pub shapes: u64,
    /// Room for pairs, and for contacts.
    pub contacts: u64,
    /// Joints, and room for joints. Documents are never read beyond [`format::JOINTS_MAX`].
    pub joints: u64,
    /// Bytes of the world that is made.
    pub memory_bytes: u64,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            // A body takes about 200 bytes of text: enough for the most bodies.
            file_bytes: 128 << 20,
            bodies: format::BODIES_MAX as u64,
            shapes: 1 << 20,
            contacts: 1 << 24,
            joints: format::JOINTS_MAX as u64,
            memory_bytes: 16 << 30,
        }
    }
}
