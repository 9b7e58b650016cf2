//! The built-in scenes in their golden sizes: the checksums that `cellstep doctor` compares with the release's.

use alloc::{format, string::String};
use cellstep::scene::builtin::BUILTIN;
use cellstep_core::Serial;
use std::path::Path;

/// The line of the scene with this index after some steps; `None` after the last scene.
///
/// # Panics
/// When the scene is not built, or loses a body: it would prove less than it claims.
pub(crate) fn line(index: usize, steps: u32) -> Option<String> {
    let builtin = BUILTIN.get(index)?;
    let scene = builtin.scene(builtin.golden_size).expect("the golden size is in range");
    let mut world =
        scene.build(Path::new("")).unwrap_or_else(|error| panic!("{}: {error}", builtin.name)).world;
    for _ in 0..steps {
        let report = world.step(&mut Serial);
        assert!(report.quarantined == 0, "scene {}: {report:?}", builtin.name);
    }
    Some(format!("builtin-{} {} {:016x}", builtin.name, builtin.golden_size, world.checksum()))
}
