//! The scenes: between them every kind of shape, body and command.

mod churn;
mod falling;
mod jointed;
mod moved;
mod things;

use cellstep_core::{Capacities, Line, World};

/// The world that a scene fills.
pub type SceneWorld<'m> = World<&'m mut [Line]>;

/// Steps that are compared.
pub const STEPS: u32 = 300;

/// A world to build, and what is done to it as it runs.
pub struct Scene {
    /// One word.
    pub name: &'static str,
    /// Room for it.
    pub capacities: Capacities,
    /// Fills the empty world.
    pub build: fn(&mut SceneWorld<'_>),
    /// Called before each step; the first is step 1.
    pub before_step: fn(&mut SceneWorld<'_>, u32),
}

/// All scenes.
pub const ALL: [Scene; 9] = [
    Scene { name: "pile", capacities: room(200), build: falling::pile, before_step: nothing },
    Scene { name: "pyramid", capacities: room(120), build: falling::pyramid, before_step: nothing },
    Scene { name: "terrain", capacities: room(140), build: falling::terrain, before_step: nothing },
    Scene { name: "bounce", capacities: room(140), build: falling::bounce, before_step: nothing },
    Scene { name: "rigid", capacities: room(120), build: falling::rigid, before_step: nothing },
    Scene { name: "movers", capacities: room(140), build: moved::movers, before_step: moved::move_on },
    Scene { name: "far", capacities: room(140), build: moved::far, before_step: moved::steer },
    Scene { name: "churn", capacities: room(140), build: churn::build, before_step: churn::change },
    Scene { name: "jointed", capacities: JOINTED, build: jointed::build, before_step: jointed::push },
];

/// Room for joints, and for what is told of bodies.
const JOINTED: Capacities =
    Capacities { joints: 160, materials: 4, events: 512, sensor_visits: 128, ..room(200) };

fn nothing(_: &mut SceneWorld<'_>, _: u32) {}

/// Room for some bodies of up to two shapes, a few hulls and meshes.
const fn room(bodies: u32) -> Capacities {
    Capacities {
        shapes: 2 * bodies,
        pairs: 64 + 32 * bodies,
        contacts: 32 + 16 * bodies,
        hulls: 8,
        meshes: 2,
        mesh_vertices: 512,
        joints: 0,
        mesh_triangles: 512,
        ..Capacities::for_bodies(bodies)
    }
}
