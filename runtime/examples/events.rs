//! Reads the events of each step: a ball comes into a sensor and hits the ground.

use cellstep::math::Vec3;
use cellstep::{
    BodyDef, BodyKind, Capacities, EventKind, Geometry, Serial, ShapeDef, ShapeEvents, new_world,
};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let room = Capacities { events: 256, sensor_visits: 64, ..Capacities::for_bodies(100) };
    let mut world = new_world(room)?;
    let ground = world.create_body(&BodyDef::new(BodyKind::Static, Vec3::ZERO))?;
    world.create_shape(ground, &ShapeDef::new(Geometry::HalfSpace))?;
    world.create_shape(ground, &ShapeDef::sensor(Geometry::Sphere { radius: 2.0 }))?;
    let ball = world.create_body(&BodyDef::new(BodyKind::Dynamic, Vec3::Z * 5.0))?;
    let shape = ShapeDef::new(Geometry::Sphere { radius: 0.5 });
    world.create_shape(ball, &ShapeDef { events: ShapeEvents::HITS, ..shape })?;
    let mut told = Vec::new();
    for _ in 0..120 {
        world.step(&mut Serial);
        for event in world.events() {
            match event.kind {
                EventKind::SensorBegan(visit) => told.push((event.step, "came", visit.visitor_body)),
                EventKind::ContactHit(hit) => told.push((event.step, "hit", hit.touching.bodies[1])),
                _ => {}
            }
        }
    }
    assert_eq!(told.iter().map(|(_, what, _)| *what).collect::<Vec<_>>(), ["came", "hit"]);
    assert!(told.iter().all(|(_, _, body)| *body == ball));
    Ok(())
}
