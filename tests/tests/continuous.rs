//! Continuous collision: nothing passes through a wall, however fast, and nothing that passes beside one is disturbed.
//!
//! The oracle knows no shape of the engine's: a wall is a plane here, or a sum of sines, and a body is on one side of
//! it with its center and with all points of a cloud that spans its shape.

mod continuous {
    pub mod shots;
}

use continuous::shots::{self, Wall};

#[test]
fn nothing_passes_a_wall() {
    for wall in Wall::ALL {
        for kind in shots::KINDS {
            if std::env::var("ONE").is_ok_and(|o| o != format!("{wall:?}{kind:?}")) { continue; } let report = shots::fire(wall, kind, 1, true);
            println!("{wall:?} {kind:?}: {report:?}");
        }
    }
}

#[test]
fn without() {
    for wall in Wall::ALL {
        for kind in shots::KINDS {
            if std::env::var("ONE").is_ok_and(|o| o != format!("{wall:?}{kind:?}")) { continue; } let report = shots::fire(wall, kind, 1, false);
            println!("{wall:?} {kind:?}: {report:?}");
        }
    }
}
