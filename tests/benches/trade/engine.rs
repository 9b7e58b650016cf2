//! What the bench asks of an engine, and all configurations of all engines.

use crate::scene::{Scene, Seen, Setup};
use cellstep::Preset;

pub trait Engine {
    /// One step of the setup's length, on this thread alone.
    fn step(&mut self);
    /// All bodies in the setup's order.
    fn read(&self, seen: &mut Vec<Seen>);
}

type Make = dyn Fn(&Setup) -> Box<dyn Engine> + Send + Sync;

/// An engine with settings.
pub struct Config {
    pub engine: &'static str,
    /// What differs from the engine's default, or the name of a preset.
    pub name: String,
    /// All settings that matter, in a line.
    pub settings: String,
    pub substeps: u32,
    pub preset: Option<Preset>,
    pub is_default: bool,
    pub make: Box<Make>,
}

impl Config {
    /// Name for tables and for `--run`.
    pub fn full_name(&self) -> String {
        format!("{} {}", self.engine, self.name)
    }
}

/// Names of the engines, cellstep first.
pub const ENGINES: &[&str] = &[
    crate::own::NAME,
    #[cfg(feature = "peers")]
    crate::rapier::NAME,
    #[cfg(feature = "peers")]
    crate::box3d::NAME,
];

/// What runs in a scene, cellstep first.
pub fn configs(scene: &Scene) -> Vec<Config> {
    let mut all = crate::own::configs(scene.kind);
    #[cfg(feature = "peers")]
    {
        all.extend(crate::rapier::configs(scene.kind));
        all.extend(crate::box3d::configs(scene.kind));
    }
    all.retain(|config| config.substeps <= scene.substeps_max);
    all
}
