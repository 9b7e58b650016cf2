//! Friction by points: a cone for each point of a contact, against closed forms, a model in double precision and
//! the friction of patches.

mod bits;
mod forms;
mod plane;

use cellstep::math::Vec3;
use cellstep::{Capacities, FrictionModel, Geometry, Settings};
use cellstep_tests::worlds::{OwnedWorld, world_with};

const CUBE: Geometry = Geometry::Box { half_extents: Vec3::splat(0.5) };
const MODELS: [FrictionModel; 2] = [FrictionModel::Patch, FrictionModel::Points];

fn with(friction_model: FrictionModel) -> Settings {
    Settings { friction_model, ..Settings::default() }
}

fn world_of(settings: &Settings, bodies: u32) -> OwnedWorld {
    let mut world = world_with(Capacities { materials: 4, ..Capacities::for_bodies(bodies) });
    world.set_settings(settings).expect("in range");
    world
}
