//! Bodies that fly past a wall by a hair: as if it were not there.

use crate::shots::power_of_ten;
use cellstep::math::Vec3;
use cellstep::{BodyDef, BodyKind, Geometry, Position, Serial, Settings, ShapeDef};
use cellstep_tests::executors::Random;
use cellstep_tests::oracles::{minus, norm, spin, velocity, wide};
use cellstep_tests::worlds::{add, world};

/// How near the wall a body passes, metres.
const GAP: f32 = 0.001;

/// Flies past the long side, the corner and through the gap; returns the greatest change of velocity as a share of
/// the speed.
fn fly(geometry: Geometry, reach: f32, (speed, seed): (f32, u64)) -> f64 {
    let mut random = Random::new(seed);
    let mut world = world(4);
    let settings = Settings { gravity: Vec3::ZERO, ..world.settings() };
    world.set_settings(&settings).expect("in range");
    // A wall whose top is the plane z = 0, from x = 0 on.
    let half_extents = Vec3::new(5.0, 5.0, 0.5);
    let wall = BodyDef::new(BodyKind::Static, Vec3::new(5.0, 0.0, -0.5));
    add(&mut world, &wall, &ShapeDef::new(Geometry::Box { half_extents }));
    let height = reach + GAP;
    let before = random.between(0.2, 1.0) * speed / 60.0 + reach;
    let place = Vec3::new(-before, random.between(-1.0, 1.0), height);
    let def = BodyDef {
        position: Position::at(place),
        linear_velocity: Vec3::new(speed, 0.0, 0.0),
        ..BodyDef::default()
    };
    let (body, _) = add(&mut world, &def, &ShapeDef::new(geometry));
    let mut worst = 0.0_f64;
    for _ in 0..20 {
        let report = world.step(&mut Serial);
        assert_eq!(report.cut, 0, "stopped at {speed} m/s");
        let change = norm(minus(velocity(&world, body), wide(def.linear_velocity)));
        worst = worst.max(change / f64::from(speed)).max(norm(spin(&world, body)));
    }
    worst
}

#[test]
fn what_passes_beside_a_wall_is_not_disturbed() {
    let shapes = [
        (Geometry::Sphere { radius: 0.005 }, 0.005),
        (Geometry::Box { half_extents: Vec3::splat(0.05) }, 0.05),
        (Geometry::Capsule { half_height: 0.1, radius: 0.02 }, 0.12),
        (Geometry::Cylinder { half_height: 0.02, radius: 0.1 }, 0.02),
    ];
    for (geometry, reach) in shapes {
        let mut random = Random::new(9);
        for shot in 0..100 {
            let speed = power_of_ten(random.between(1.0, 3.0));
            let change = fly(geometry, reach, (speed, shot));
            assert!(change < 1.0e-5, "{geometry:?} at {speed} m/s: {change}");
        }
    }
}
