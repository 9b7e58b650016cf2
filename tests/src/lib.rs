//! Scenes, commands, oracles and executors shared by tests, benches and fuzz targets.

pub mod commands;
pub mod executors;
pub mod extremes;
pub mod fuzzing;
pub mod jointed;
pub mod mixed;
pub mod oracles;
pub mod reference;
pub mod schedules;
pub mod score;
pub mod sectors;
pub mod simulator;
pub mod solids;
pub mod worlds;
