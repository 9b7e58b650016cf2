//! Bodies and shapes that come, change and go all the time.

use super::SceneWorld;
use super::things::{add_any, add_ground, add_hulls, add_walls, any_convex, any_shape};
use crate::numbers::Numbers;
use cellstep_core::math::{Pose, Vec3};
use cellstep_core::{BodyHandle, BodyKind, Filter, Position};

/// Bodies of the ground and its walls, which stay.
const FIXED: u32 = 5;

/// A walled yard with 60 bodies.
pub(super) fn build(world: &mut SceneWorld<'_>) {
    let mut numbers = Numbers(30);
    add_hulls(world, &mut numbers);
    add_ground(world);
    add_walls(world, 3.0);
    for index in 0..60 {
        let place =
            Vec3::new((index % 5) as f32 - 2.0, (index / 5 % 4) as f32 - 1.5, 1.0 + (index / 20) as f32);
        add_any(world, &mut numbers, place);
    }
}

/// One body comes, one goes once there are 110, and one is changed.
pub(super) fn change(world: &mut SceneWorld<'_>, step: u32) {
    let mut numbers = Numbers(1000 + u64::from(step));
    let place = numbers.vector(2.0) + Vec3::new(0.0, 0.0, 7.0);
    add_any(world, &mut numbers, place);
    if world.body_count() > 110 {
        let body = any_body(world, &mut numbers);
        world.remove_body(body).expect("it lives");
    }
    let body = any_body(world, &mut numbers);
    alter(world, &mut numbers, body, step % 9);
}

/// Changes a body in one of nine ways.
fn alter(world: &mut SceneWorld<'_>, numbers: &mut Numbers, body: BodyHandle, way: u32) {
    let shape = world.shapes_of(body).expect("it lives").next().expect("it has a shape");
    let done = match way {
        0 => world.set_geometry(
            shape,
            &any_convex(numbers),
            &Pose::new(numbers.vector(0.1), numbers.rotation()),
        ),
        1 => world.set_density(shape, numbers.between(100.0, 3000.0)),
        2 => world.set_filter(shape, Filter { group: numbers.below(3) as i32 - 2, ..Filter::default() }),
        3 => world.set_material(shape, numbers.between(0.0, 1.0), numbers.between(0.0, 1.0)),
        4 => {
            let position = Position::at(numbers.vector(1.5) + Vec3::new(0.0, 0.0, 5.0));
            world.set_pose(body, position, numbers.rotation())
        }
        5 => world.create_shape(body, &any_shape(numbers)).and_then(|_| world.remove_shape(shape)),
        6 => {
            let kinds = [BodyKind::Static, BodyKind::Kinematic, BodyKind::Dynamic, BodyKind::Dynamic];
            world.set_kind(body, kinds[numbers.below(4) as usize])
        }
        7 => world.set_damping(body, numbers.between(0.0, 2.0), numbers.between(0.0, 2.0)),
        _ => world.set_gravity_scale(body, numbers.between(-0.2, 1.5)),
    };
    done.expect("the change is allowed");
}

fn any_body(world: &SceneWorld<'_>, numbers: &mut Numbers) -> BodyHandle {
    let index = FIXED + numbers.below(world.body_count() - FIXED);
    world.bodies().nth(index as usize).expect("the index is below the count")
}
