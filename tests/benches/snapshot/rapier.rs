//! `rapier3d`, saved as its users do: the whole world by `serde` and `bincode`.

use crate::Peer;
use cellstep::math::Vec3;
use rapier3d::prelude::*;

pub struct Rapier {
    world: PhysicsWorld,
    /// What was saved last.
    saved: Vec<u8>,
}

/// The faster one of bincode's encodings.
fn encoding() -> impl bincode::config::Config {
    bincode::config::standard().with_fixed_int_encoding()
}

impl Rapier {
    pub fn new(places: &[Vec3]) -> Self {
        let mut world = PhysicsWorld::new();
        world.gravity = Vector::new(0.0, 0.0, -9.81);
        world.integration_parameters.dt = 1.0 / 60.0;
        let ground = RigidBodyBuilder::fixed().translation(Vector::new(0.0, 0.0, -1.0));
        world.insert(ground, ColliderBuilder::cuboid(200.0, 200.0, 1.0).density(1000.0));
        for p in places {
            let body = RigidBodyBuilder::dynamic().translation(Vector::new(p.x, p.y, p.z)).can_sleep(false);
            world.insert(body, ColliderBuilder::cuboid(0.5, 0.5, 0.5).density(1000.0));
        }
        Self { world, saved: Vec::new() }
    }
}

impl Peer for Rapier {
    fn name(&self) -> String {
        "rapier3d 0.36 + bincode 2".to_string()
    }

    fn step(&mut self) {
        self.world.step();
    }

    fn save(&mut self) -> usize {
        self.saved.clear();
        bincode::serde::encode_into_std_write(&self.world, &mut self.saved, encoding())
            .expect("it has no limit")
    }

    fn restore(&mut self) {
        let (world, _) = bincode::serde::decode_from_slice(&self.saved, encoding()).expect("its own bytes");
        self.world = world;
    }
}
