//! Scenes, commands, oracles and executors shared by tests, benches and fuzz targets.

pub mod executors;
pub mod worlds;
