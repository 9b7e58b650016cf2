//! The built-in scenes: one maker for each, shared by tests, benches and the command.
//!
//! A maker takes a size, whose meaning its entry in [`BUILTIN`] states, and returns a document. The same size
//! gives the same document, bit for bit: what looks random comes from a small generator with a fixed seed, in
//! steps of 1/1024 m. All scenes are in SI units with z up; the material is the default one (friction 0.6).

mod golden;
mod jointed;
mod level;
mod parts;
mod piles;
mod stacks;

pub use golden::GOLDEN_STEPS;
pub use jointed::{bridge, cars, ragdolls};
pub use level::level;
pub use piles::{bowls, free_fall, hub, mixed_pile};
pub use stacks::{pyramid, stacked_pyramid, tower, wall};

use super::error::SceneError;
use super::format::Scene;

/// A built-in scene.
#[derive(Clone, Copy, Debug)]
pub struct Builtin {
    /// Its name for the command, lower case.
    pub name: &'static str,
    /// One line of what it shows, and what its size counts.
    pub description: &'static str,
    /// Size when none is asked for.
    pub default_size: u32,
    /// Size in the golden tests: at most 300 bodies.
    pub golden_size: u32,
    /// Greatest size: at most [`BODIES_MAX`](super::format::BODIES_MAX) bodies.
    pub size_max: u32,
    make: fn(u32) -> Scene,
}

impl Builtin {
    /// The built-in scene of a name.
    pub fn find(name: &str) -> Option<&'static Self> {
        BUILTIN.iter().find(|builtin| builtin.name == name)
    }

    /// Makes the scene in a size from 1 to `size_max`; other sizes are refused before memory is taken.
    pub fn scene(&self, size: u32) -> Result<Scene, SceneError> {
        if size == 0 || size > self.size_max {
            let expected = format!("1..={} for the scene `{}`", self.size_max, self.name);
            return Err(SceneError::invalid("size", format!("found {size}"), expected));
        }
        Ok(Scene { description: self.description.to_string(), ..(self.make)(size) })
    }
}

/// All built-in scenes.
pub const BUILTIN: &[Builtin] = &[
    Builtin {
        name: "free_fall",
        description: "balls, boxes, capsules and hulls that fall and never meet; size: bodies",
        default_size: 1000,
        golden_size: 100,
        size_max: 200_000,
        make: free_fall,
    },
    Builtin {
        name: "tower",
        description: "unit boxes one on the other; size: boxes",
        default_size: 20,
        golden_size: 20,
        size_max: 10_000,
        make: tower,
    },
    Builtin {
        name: "pyramid",
        description: "a flat pyramid of unit boxes that touch; size: boxes in the lowest row",
        default_size: 100,
        golden_size: 22,
        size_max: 600,
        make: pyramid,
    },
    Builtin {
        name: "stacked_pyramid",
        description: "a solid pyramid of square layers of unit boxes; size: layers",
        default_size: 20,
        golden_size: 8,
        size_max: 80,
        make: stacked_pyramid,
    },
    Builtin {
        name: "wall",
        description: "a brick wall in running bond; size: courses, each of as many bricks",
        default_size: 20,
        golden_size: 14,
        size_max: 400,
        make: wall,
    },
    Builtin {
        name: "mixed_pile",
        description: "balls, boxes, capsules and hulls fall into a walled box; size: bodies",
        default_size: 1000,
        golden_size: 200,
        size_max: 200_000,
        make: mixed_pile,
    },
    Builtin {
        name: "bowls",
        description: "bowls (one mesh) with thirty balls falling into each; size: bowls",
        default_size: 16,
        golden_size: 6,
        size_max: 4_000,
        make: bowls,
    },
    Builtin {
        name: "hub",
        description: "one dynamic platform under many boxes; size: boxes",
        default_size: 1000,
        golden_size: 200,
        size_max: 100_000,
        make: hub,
    },
    Builtin {
        name: "level",
        description: "mixed bodies fall on a mesh with hills, stairs and a rim; size: bodies",
        default_size: 500,
        golden_size: 150,
        size_max: 20_000,
        make: level,
    },
    Builtin {
        name: "bridge",
        description: "planks with hinges between them hang on ropes and boxes fall on them; size: planks",
        default_size: 40,
        golden_size: 40,
        size_max: 100_000,
        make: bridge,
    },
    Builtin {
        name: "ragdolls",
        description: "ragdolls of 11 bodies stumble, fall and go to sleep; size: ragdolls",
        default_size: 100,
        golden_size: 16,
        size_max: 20_000,
        make: ragdolls,
    },
    Builtin {
        name: "cars",
        description: "cars on springs with motors and steering drive over a step; size: cars",
        default_size: 100,
        golden_size: 20,
        size_max: 40_000,
        make: cars,
    },
];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Limits, format::BODIES_MAX};

    #[test]
    fn golden_sizes_are_small() {
        for builtin in BUILTIN {
            let scene = builtin.scene(builtin.golden_size).unwrap();
            assert!(scene.bodies.len() <= 300, "{}: {}", builtin.name, scene.bodies.len());
            assert!(scene.bodies.len() > 10, "{}: {}", builtin.name, scene.bodies.len());
        }
    }

    #[test]
    fn sizes_are_bounded() {
        for builtin in BUILTIN {
            let largest = builtin.scene(builtin.size_max).unwrap();
            assert!(largest.bodies.len() <= BODIES_MAX, "{}", builtin.name);
            for size in [0, builtin.size_max + 1, u32::MAX] {
                let message = builtin.scene(size).unwrap_err().to_string();
                assert!(message.contains(&format!("1..={}", builtin.size_max)), "{message}");
            }
        }
    }

    #[test]
    fn every_scene_comes_back_from_json() {
        for builtin in BUILTIN {
            for size in [1, 2, 3, builtin.golden_size, builtin.default_size] {
                let scene = builtin.scene(size).unwrap();
                let text = scene.to_json();
                let back = Scene::from_json(text.as_bytes(), &Limits::default()).unwrap();
                assert!(scene == back, "{} of size {size}", builtin.name);
                assert_eq!(text, back.to_json(), "{} of size {size}", builtin.name);
                assert_eq!(builtin.scene(size).unwrap(), scene, "{} of size {size}", builtin.name);
            }
        }
    }

    #[test]
    fn sizes_are_what_the_descriptions_say() {
        let dynamic = |name: &str, size| {
            let scene = Builtin::find(name).unwrap().scene(size).unwrap();
            scene.bodies.iter().filter(|body| body.kind == crate::scene::format::KindDoc::Dynamic).count()
        };
        assert_eq!(dynamic("pyramid", 100), 5050);
        assert_eq!(dynamic("stacked_pyramid", 4), 16 + 9 + 4 + 1);
        assert_eq!(dynamic("tower", 7), 7);
        assert_eq!(dynamic("wall", 4), 4 * 4 + 2);
        assert_eq!(dynamic("mixed_pile", 77), 77);
        assert_eq!(dynamic("bowls", 5), 150);
        assert_eq!(dynamic("hub", 1000), 1001);
        assert_eq!(dynamic("level", 33), 33);
        assert_eq!(dynamic("free_fall", 9), 9);
        assert_eq!(dynamic("bridge", 7), 7 + 4);
        assert_eq!(dynamic("ragdolls", 3), 3 * 11);
        assert_eq!(dynamic("cars", 3), 3 * 5);
    }
}
