//! The ten scenes.

use cellstep::Geometry;
use cellstep::math::Vec3;
use cellstep::scene::Limits;
use cellstep::scene::builtin::Builtin;
use cellstep::{BodyDef, BodyKind, ShapeDef};
use cellstep_tests::executors::Random;
use cellstep_tests::worlds::{OwnedWorld, add, ground, world};
use std::path::Path;

/// Share of its height and width that a compact pile keeps: its bodies then fill some 50 % of the space, and touch
/// from the first step on.
const COMPACT: f64 = 0.6;

/// A scene and how it is run before its contact graph is taken.
pub struct Scene {
    /// Its maker and size.
    pub name: String,
    /// Why the graph looks as it does.
    pub note: &'static str,
    /// Steps to take; fewer when time runs out, and that is said.
    pub steps: u32,
    make: Make,
}

enum Make {
    Builtin(&'static str, u32),
    Compact(u32),
    Rain(u32),
}

impl Scene {
    fn new(make: Make, steps: u32, note: &'static str) -> Self {
        let name = match make {
            Make::Builtin(name, size) => format!("{name} {size}"),
            Make::Compact(size) => format!("compact pile {size}"),
            Make::Rain(size) => format!("rain {size}"),
        };
        Self { name, note, steps, make }
    }

    /// Before its first step.
    pub fn world(&self) -> OwnedWorld {
        match self.make {
            Make::Builtin(name, size) => build(name, size, 1.0),
            Make::Compact(size) => build("mixed_pile", size, COMPACT),
            Make::Rain(size) => rain(size),
        }
    }
}

/// Ten scenes; small ones when it must be quick.
pub fn all(quick: bool) -> Vec<Scene> {
    use Make::{Builtin, Compact, Rain};
    let size = |full, small| if quick { small } else { full };
    let stands = "stands";
    let settled = "fell together and settles";
    vec![
        Scene::new(Builtin("wall", size(22, 10)), 100, stands),
        Scene::new(Builtin("pyramid", size(44, 14)), 100, stands),
        Scene::new(Builtin("hub", size(1000, 200)), 100, "one platform under all boxes"),
        Scene::new(Builtin("bowls", size(60, 6)), 100, "many small islands"),
        Scene::new(Rain(size(3000, 300)), 60, "most lie or fall alone"),
        Scene::new(Builtin("mixed_pile", size(4000, 300)), 150, settled),
        Scene::new(Builtin("stacked_pyramid", size(24, 8)), 100, stands),
        Scene::new(Builtin("pyramid", size(100, 20)), 100, stands),
        Scene::new(Builtin("wall", size(200, 14)), 100, stands),
        Scene::new(
            Compact(size(200_000, 500)),
            100,
            "too many to wait until they rest: starts compact, overlapping, and is pushed apart",
        ),
    ]
}

fn build(name: &str, size: u32, scale: f64) -> OwnedWorld {
    let mut scene = Builtin::find(name).expect("a built-in scene").scene(size).expect("the size is in range");
    for body in &mut scene.bodies {
        body.position = body.position.map(|x| x * scale);
    }
    let limits = Limits { memory_bytes: u64::MAX, ..Limits::default() };
    scene.build_within(Path::new("."), &limits).expect("built-in scenes build").world
}

/// Balls and boxes that fall on a wide ground from different heights.
fn rain(size: u32) -> OwnedWorld {
    let mut world = world(size + 1);
    ground(&mut world, 0.6);
    let mut random = Random::new(6);
    let edge = f64::from(size).sqrt() as f32 * 1.4;
    // Layers over each other, so that none starts in another.
    for index in 0..size {
        let layer = index as f32 / size as f32;
        let [x, y] = [(); 2].map(|()| random.between(-0.5, 0.5) * edge);
        let at = Vec3::new(x, y, 0.5 + 4.0 * layer);
        let geometry = match index % 2 {
            0 => Geometry::Sphere { radius: 0.4 },
            _ => Geometry::Box { half_extents: Vec3::new(0.4, 0.3, 0.25) },
        };
        add(&mut world, &BodyDef::new(BodyKind::Dynamic, at), &ShapeDef::new(geometry));
    }
    world
}
