//! Scenes with kinematic bodies, forces and impulses, locked axes, and places far from the origin.

use super::SceneWorld;
use super::things::{add, add_any, add_grid, add_hulls, add_terrain, locks};
use crate::numbers::Numbers;
use cellstep_core::math::{Rotation, Vec3, cos, sin};
use cellstep_core::{BodyDef, BodyHandle, BodyKind, Geometry, MassProperties, Position, Settings, ShapeDef};

/// A platform that is told its poses, one that has a velocity, a bowl that turns, and 105 bodies on them, half of
/// which have locked axes.
pub(super) fn movers(world: &mut SceneWorld<'_>) {
    let mut numbers = Numbers(20);
    add_hulls(world, &mut numbers);
    let plate =
        ShapeDef { friction: 0.9, ..ShapeDef::new(Geometry::Box { half_extents: Vec3::new(3.0, 3.0, 0.2) }) };
    add(world, &BodyDef::new(BodyKind::Kinematic, platform_place(0)), &plate);
    let lift = BodyDef {
        linear_velocity: Vec3::new(0.0, 0.3, 0.4),
        angular_velocity: Vec3::new(0.0, 0.0, 0.5),
        ..BodyDef::new(BodyKind::Kinematic, Vec3::new(12.0, 0.0, 0.0))
    };
    add(world, &lift, &plate);
    let bowl = BodyDef {
        angular_velocity: Vec3::new(0.02, 0.03, 0.4),
        ..BodyDef::new(BodyKind::Kinematic, Vec3::new(0.0, 20.0, -1.0))
    };
    add_terrain(world, &bowl);
    add(
        world,
        &BodyDef::new(BodyKind::Static, Vec3::new(0.0, 0.0, -8.0)),
        &ShapeDef::new(Geometry::HalfSpace),
    );
    for corner in [Vec3::new(-2.2, -2.2, 1.5), Vec3::new(9.8, -2.2, 1.5), Vec3::new(-2.2, 17.8, 2.0)] {
        add_grid(world, &mut numbers, corner, [5, 7, 1]);
    }
    for index in (0..105).step_by(2) {
        let body = nth(world, 4 + index);
        world.set_locks(body, locks(index / 2)).expect("it lives");
    }
}

fn platform_place(step: u32) -> Vec3 {
    let turn = step as f32 * 0.02;
    Vec3::new(1.5 * sin(turn), 1.0 - cos(turn), 0.5 * sin(2.0 * turn))
}

/// Moves the first platform on, and pushes, turns and throws a body each step.
pub(super) fn move_on(world: &mut SceneWorld<'_>, step: u32) {
    let platform = nth(world, 0);
    let tilt = Rotation::from_axis_angle(Vec3::Y, 0.2 * sin(step as f32 * 0.05));
    world.set_kinematic_target(platform, Position::at(platform_place(step)), tilt).expect("near");
    let mut numbers = Numbers(u64::from(step));
    let body = nth(world, 4 + numbers.below(105));
    let mass = world.mass_properties(body).expect("it lives").mass;
    let handle = world.center(body).expect("it lives").plus(numbers.vector(0.2));
    let push = numbers.vector(3.0 * mass);
    match step % 5 {
        0 => world.apply_impulse(body, push),
        1 => world.apply_impulse_at(body, push, handle),
        2 => world.apply_force_at(body, push * 20.0, handle),
        3 => world.apply_torque(body, push),
        _ => world.apply_angular_impulse(body, push * 0.02),
    }
    .expect("finite and dynamic");
}

/// Heaps at three borders of sectors, 10,000 km out, and weightless bodies of unequal inertia that tumble through
/// the sectors between them.
pub(super) fn far(world: &mut SceneWorld<'_>) {
    let mut numbers = Numbers(21);
    add_hulls(world, &mut numbers);
    for (index, center) in HEAPS.iter().enumerate() {
        let floor =
            BodyDef { position: Position::from_f64(*center), ..BodyDef::new(BodyKind::Static, Vec3::ZERO) };
        let slab = Geometry::Box { half_extents: Vec3::new(30.0, 30.0, 1.0) };
        add(world, &floor, &ShapeDef::new(slab));
        for _ in 0..25 + index {
            let body = add_any(world, &mut numbers, Vec3::ZERO);
            let place = numbers.vector(2.0) + Vec3::new(0.0, 0.0, 4.0);
            let rotation = numbers.rotation();
            world.set_pose(body, floor.position.plus(place), rotation).expect("within the world");
            world.set_linear_velocity(body, numbers.vector(6.0)).expect("finite");
        }
    }
    for index in 0..24_u8 {
        let from = Position::from_f64(HEAPS[index as usize % 3]);
        let side = numbers.vector(1.0) + Vec3::new(3.0 * f32::from(index), 0.0, 25.0);
        let def = BodyDef {
            position: from.plus(side),
            rotation: numbers.rotation(),
            linear_velocity: numbers.vector(60.0),
            angular_velocity: numbers.vector(1.0 + 3.0 * f32::from(index)),
            gravity_scale: 0.0,
            mass: Some(MassProperties {
                mass: numbers.between(0.5, 50.0),
                center: numbers.vector(0.1),
                inertia: Vec3::new(1.0, 1.7, 2.4),
                axes: numbers.rotation(),
            }),
            ..BodyDef::default()
        };
        add(world, &def, &ShapeDef::new(Geometry::Box { half_extents: Vec3::new(0.2, 0.5, 0.8) }));
    }
}

/// Middles of the floors, metres: on borders of sectors.
const HEAPS: [[f64; 3]; 3] =
    [[1.0e7 + 32.0, -1.0e7 - 32.0, 32.0], [1.0e7 + 160.0, -1.0e7 - 32.0, -31.5], [-2.5e9 + 32.0, 3.0, 1.0e9]];

/// Turns gravity slowly, and changes the substeps on the way.
pub(super) fn steer(world: &mut SceneWorld<'_>, step: u32) {
    let turn = step as f32 * 0.01;
    let settings = Settings {
        gravity: Vec3::new(2.0 * sin(turn), 2.0 - 2.0 * cos(turn), -9.81),
        substeps: 2 + step / 100,
        ..Settings::default()
    };
    world.set_settings(&settings).expect("in range");
}

/// The living body number `index`, by slot.
fn nth(world: &SceneWorld<'_>, index: u32) -> BodyHandle {
    world.bodies().nth(index as usize).expect("the scene has as many")
}
