//! Scenes that are left alone once built.

use super::SceneWorld;
use super::things::{add, add_any, add_box, add_grid, add_ground, add_hulls, add_terrain, add_walls};
use crate::numbers::Numbers;
use cellstep_core::math::Vec3;
use cellstep_core::{BodyDef, BodyKind, ContactModel, Geometry, Settings, ShapeDef};

/// 175 bodies of any convex kind fall between walls.
pub(super) fn pile(world: &mut SceneWorld<'_>) {
    let mut numbers = Numbers(10);
    add_hulls(world, &mut numbers);
    add_ground(world);
    add_walls(world, 3.2);
    add_grid(world, &mut numbers, Vec3::new(-2.2, -2.2, 1.0), [5, 5, 7]);
}

/// A wall of 91 boxes with half a box's shift, and a heavy ball that flies into it.
pub(super) fn pyramid(world: &mut SceneWorld<'_>) {
    add_ground(world);
    let half = Vec3::new(0.5, 0.4, 0.3);
    for row in 0..13 {
        for column in 0..13 - row {
            let x = (column as f32 + 0.5 * row as f32) * 1.05;
            add_box(world, Vec3::new(x, 0.0, 0.3 + 0.6 * row as f32), half);
        }
    }
    let ball = BodyDef {
        linear_velocity: Vec3::new(0.5, 18.0, 1.0),
        ..BodyDef::new(BodyKind::Dynamic, Vec3::new(6.5, -20.0, 2.0))
    };
    let shape = ShapeDef { density: 5000.0, ..ShapeDef::new(Geometry::Sphere { radius: 0.6 }) };
    add(world, &ball, &shape);
}

/// 108 bodies of any convex kind fall on a mesh and roll into its valleys.
pub(super) fn terrain(world: &mut SceneWorld<'_>) {
    let mut numbers = Numbers(11);
    add_hulls(world, &mut numbers);
    add_terrain(world, &BodyDef::new(BodyKind::Static, Vec3::ZERO));
    add_grid(world, &mut numbers, Vec3::new(-3.3, -3.3, 3.0), [6, 6, 3]);
}

/// 100 bodies with restitutions from 0 to 1 and frictions from none to much, on a floor of plates.
pub(super) fn bounce(world: &mut SceneWorld<'_>) {
    let mut numbers = Numbers(12);
    add_hulls(world, &mut numbers);
    for plate in 0..16 {
        let (column, row) = ((plate % 4) as f32, (plate / 4) as f32);
        let def = BodyDef::new(BodyKind::Static, Vec3::new(4.0 * column - 6.0, 4.0 * row - 6.0, -0.5));
        let plate = Geometry::Box { half_extents: Vec3::new(2.0, 2.0, 0.5) };
        add(world, &def, &ShapeDef { friction: row * 0.3, ..ShapeDef::new(plate) });
    }
    for index in 0..100 {
        let place =
            Vec3::new((index % 10) as f32 - 4.5, (index / 10) as f32 - 4.5, numbers.between(1.0, 4.0));
        let body = add_any(world, &mut numbers, place);
        let shape = world.shapes_of(body).expect("it lives").next().expect("it has a shape");
        world.set_material(shape, numbers.between(0.0, 2.0), index as f32 / 99.0).expect("in range");
    }
}

/// Towers of boxes and capsules with rigid contacts, many sweeps, and a tilted gravity.
pub(super) fn rigid(world: &mut SceneWorld<'_>) {
    let settings = Settings {
        gravity: Vec3::new(0.4, -0.2, -9.7),
        substeps: 3,
        sweeps: 6,
        relax_sweeps: 0,
        contact_model: ContactModel::Rigid,
        ..Settings::default()
    };
    world.set_settings(&settings).expect("in range");
    add_ground(world);
    for tower in 0..9 {
        let (x, y) = ((tower % 3) as f32 * 1.6, (tower / 3) as f32 * 1.6);
        for level in 0..10 {
            let slip = 0.04 * (level % 3) as f32;
            add_box(
                world,
                Vec3::new(x + slip, y - slip, 0.25 + 0.5 * level as f32),
                Vec3::new(0.4, 0.5, 0.25),
            );
        }
        let roller = Geometry::Capsule { half_height: 0.3, radius: 0.25 };
        let def = BodyDef::new(BodyKind::Dynamic, Vec3::new(x, y, 6.0));
        add(world, &def, &ShapeDef::new(roller));
    }
}
