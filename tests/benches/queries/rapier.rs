//! The same rays in `rapier3d`, with the normal, as cellstep tells it.

use super::Thing;
use cellstep::Geometry;
use cellstep::math::Vec3;
use rapier3d::prelude::*;

/// Measures the rays on the same shapes.
pub fn measure(things: &[Thing], rays: &[(Vec3, Vec3)]) {
    let mut world = PhysicsWorld::new();
    for thing in things {
        let (p, q) = (thing.place, thing.rotation);
        let shape = match thing.geometry {
            Geometry::Sphere { radius } => ColliderBuilder::ball(radius),
            Geometry::Box { half_extents: h } => ColliderBuilder::cuboid(h.x, h.y, h.z),
            Geometry::Capsule { half_height, radius } => ColliderBuilder::capsule_z(half_height, radius),
            other => panic!("the scene has no {other:?}"),
        };
        let pose = Pose::from_parts(Vector::new(p.x, p.y, p.z), Rotation::from_xyzw(q.x, q.y, q.z, q.w));
        world.insert(RigidBodyBuilder::dynamic().pose(pose), shape);
    }
    world.detect_collisions(&(), &());
    let queries = world.query_pipeline();
    let rays: Vec<(Ray, f32)> = rays
        .iter()
        .map(|&(o, t)| {
            let length = t.length();
            let d = t / length;
            (Ray::new(Vector::new(o.x, o.y, o.z), Vector::new(d.x, d.y, d.z)), length)
        })
        .collect();
    super::measure("rapier3d 0.36: nearest hit of a ray", || {
        let hits =
            |(ray, length): &&(Ray, f32)| queries.cast_ray_and_get_normal(ray, *length, true).is_some();
        rays.iter().filter(hits).count()
    });
}
