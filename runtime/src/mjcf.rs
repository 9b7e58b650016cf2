//! Models in MJCF, MuJoCo's XML format: read, resolved, and turned into scenes.
//!
//! ```text
//! files --> Library (trees, classes) --> Model (rigid bodies, joints, ...) --> Scene
//!           text, tree, vocabulary,      walk, geom, joint, mass, mesh,        convert
//!           settings, library            weigh, names, links
//! ```
//! A [`Model`] says everything that the files say of bodies, in world and body frames, with no names to look up:
//! includes, default classes, frames, replicates and attached models are resolved, every rule of MuJoCo's compiler
//! that bears on bodies is applied (masses from geoms, angles, limits, what is welded to what).
//! What it does not hold is in [`Model::warnings`], one for each kind of element or attribute.
//!
//! # What is read
//!
//! - `compiler`, `option` (time step, gravity, flags), `default` with nested classes, `include`.
//! - `mesh` from OBJ files or vertices, as convex hulls; `model` and `attach` by body, by frame or whole.
//! - `body`, `frame`, `replicate`, `inertial`; `geom` (plane, sphere, capsule, cylinder, box, ellipsoid, mesh),
//!   `site`; `joint` (hinge, slide, ball, free; several of a body), `freejoint`.
//! - `connect`, `weld`, `exclude`; `spatial` tendons between two sites; `motor`, `position` and `velocity`
//!   actuators on hinges, slides and slider-cranks.
//!
//! Contacts in MuJoCo are springs by `solref`; of these only the damping is read, as [`Geom::restitution`]: a
//! spring with the damping ratio `z` gives back the share `exp(-pi z / sqrt(1 - z^2))` of a speed.
//!
//! # What a stranger's model can do
//!
//! It is refused with a place, or read within bounds. Text is checked for depth and counts before a parser sees it,
//! document types and namespaces are refused; copies, references, points and names are counted; files are read
//! below the folder of the model that was opened, each once, by relative names without links upwards.
//!
//! ```
//! use cellstep::mjcf::Model;
//! use cellstep::scene::Limits;
//!
//! let text = r#"<mujoco><worldbody>
//!   <geom type="plane" size="1 1 1"/>
//!   <replicate count="3" offset="0 0 .5">
//!     <body pos="0 0 1"><freejoint/><geom type="box" size=".2 .2 .2" rgba="1 0 0 1"/></body>
//!   </replicate>
//! </worldbody></mujoco>"#;
//! let model = Model::from_xml(text.as_bytes(), &Limits::default())?;
//! assert_eq!(model.bodies.len(), 4);
//! assert!((model.bodies[1].mass.unwrap().mass - 64.0).abs() < 1e-9);
//! assert_eq!(
//!     model.warnings[0].to_string(),
//!     "geom/rgba: without effect on motion, ignored (line 4, column 68)"
//! );
//! let mut built = model.to_scene()?.scene.build(std::path::Path::new("."))?;
//! built.world.step(&mut cellstep::Serial);
//! # Ok::<(), Box<dyn std::error::Error>>(())
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
mod weigh;

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
    /// Reads a model from a file. Files that it names are looked for from that file's folder, and below it.
    ///
    /// # Errors
    /// With file, line, column and the path of the element or attribute: text that is not XML, a value that is not
    /// what it should be, a name that nothing has, a rule of the format that is broken, or more than `limits` and
    /// the reader's own bounds allow.
    pub fn read(file: &Path, limits: &Limits) -> Result<Self, SceneError> {
        walk::walk(&Library::open(file, limits)?)
    }

    /// Reads a model from text (UTF-8) that names no other files. Errors have no file.
    ///
    /// # Errors
    /// As [`Model::read`].
    pub fn from_xml(text: &[u8], limits: &Limits) -> Result<Self, SceneError> {
        walk::walk(&Library::of_text(text, limits)?)
    }
}
