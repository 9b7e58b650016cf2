//! A scene in which everything happens that makes events.

use cellstep::math::{Pose, Vec3};
use cellstep::{
    BodyDef, BodyKind, Capacities, EventKinds, Filter, Geometry, JointDef, Settings, ShapeDef, ShapeEvents,
};
use cellstep_tests::executors::Random;
use cellstep_tests::mixed::Draw;
use cellstep_tests::worlds::{OwnedWorld, add, ground, world_with};

/// What of the scene is wanted.
pub struct Busy {
    /// Capacity for events.
    pub events: u32,
    /// Whether the settings tell events.
    pub told: bool,
}

impl Default for Busy {
    fn default() -> Self {
        Self { events: 4000, told: true }
    }
}

/// A convex geometry that needs no asset.
fn solid(random: &mut Random, scale: f32) -> Geometry {
    loop {
        match random.convex(scale) {
            Geometry::Hull(_) | Geometry::RoundedHull { .. } => {}
            geometry => return geometry,
        }
    }
}

/// A heap of 400 bodies that falls on the ground, 24 sensors, some of which move, and pendulums that break off.
/// Enough for many tasks.
pub fn busy(wanted: &Busy) -> OwnedWorld {
    let mut world = world_with(Capacities {
        events: wanted.events,
        sensor_visits: 2000,
        joints: 24,
        ..Capacities::for_bodies(480)
    });
    world
        .set_settings(&Settings {
            sleep_time: 0.1,
            sleep_speed: 0.3,
            moved_list: true,
            hit_speed: 0.5,
            events: if wanted.told { EventKinds::ALL } else { EventKinds::NONE },
            ..Settings::default()
        })
        .expect("valid");
    let floor = ground(&mut world, 0.5);
    let mut random = Random::new(3);
    for i in 0..400 {
        let layer = (i / 25) as f32;
        let place = Vec3::new((i % 5) as f32 - 2.0, (i / 5 % 5) as f32 - 2.0, 0.5 + 0.9 * layer);
        let def = BodyDef {
            rotation: random.rotation(),
            ..BodyDef::new(BodyKind::Dynamic, place * 1.1 + random.vector(0.1))
        };
        let events = ShapeEvents(random.below(4) as u8);
        add(&mut world, &def, &ShapeDef { events, ..ShapeDef::new(solid(&mut random, 0.4)) });
    }
    for i in 0..24 {
        let kind = [BodyKind::Static, BodyKind::Kinematic][i % 2];
        let place = random.vector(4.0) + Vec3::Z * 4.0;
        let def = BodyDef { linear_velocity: random.vector(4.0), ..BodyDef::new(kind, place) };
        add(&mut world, &def, &ShapeDef::sensor(solid(&mut random, 1.5)));
    }
    for i in 0..20 {
        let place = Vec3::new(8.0 + i as f32, 0.0, 3.0);
        let filter = Filter { mask: 0, ..Filter::default() };
        let ball = ShapeDef { filter, ..ShapeDef::new(Geometry::Sphere { radius: 0.2 }) };
        let (body, _) = add(&mut world, &BodyDef::new(BodyKind::Dynamic, place), &ball);
        let mass = world.mass_properties(body).expect("exists").mass;
        let frames = [
            Pose { position: place - Vec3::X, ..Pose::IDENTITY },
            Pose { position: -Vec3::X, ..Pose::IDENTITY },
        ];
        // A pendulum that falls from level pulls with up to three times its weight.
        let break_force = mass * 9.81 * (0.5 + 0.2 * i as f32);
        let def = JointDef { break_force, ..JointDef::ball([floor, body], frames) };
        world.create_joint(&def).expect("room");
    }
    world
}
