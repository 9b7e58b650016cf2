//! Stacks of the new shapes stand.

use super::*;
use cellstep_tests::oracles::{center, norm, velocity};
use cellstep_tests::worlds::{add, run};

/// Ten of a kind one on the other: they stand for 20 s and do not creep.
#[test]
fn towers_of_ten_stand() {
    let mut probe = world();
    let core = probe.add_hull(&corners(Vec3::splat(0.4))).expect("a box");
    let towers = [
        ("cylinders", Geometry::Cylinder { half_height: 0.5, radius: 0.5 }),
        ("coins", Geometry::Cylinder { half_height: 0.05, radius: 0.5 }),
        ("rounded boxes", Geometry::RoundedHull { hull: core, radius: 0.1 }),
    ];
    for (name, geometry) in towers {
        let mut world = world();
        assert_eq!(world.add_hull(&corners(Vec3::splat(0.4))), Ok(core));
        Floor::Slab.build(&mut world, Rotation::IDENTITY);
        let half = if name == "coins" { 0.05 } else { 0.5 };
        let bodies: Vec<BodyHandle> = (0..10)
            .map(|i| {
                let at = Vec3::new(0.01 * (i % 2) as f32, 0.0, half * (2 * i + 1) as f32);
                add(&mut world, &BodyDef::new(BodyKind::Dynamic, at), &ShapeDef::new(geometry)).0
            })
            .collect();
        run(&mut world, 600);
        let before: Vec<[f64; 3]> = bodies.iter().map(|&body| center(&world, body)).collect();
        run(&mut world, 600);
        let (mut drift, mut fastest) = (0.0_f64, 0.0_f64);
        for (&body, before) in bodies.iter().zip(&before) {
            let after = center(&world, body);
            drift = drift.max(norm([0, 1, 2].map(|i| after[i] - before[i])));
            fastest = fastest.max(norm(velocity(&world, body)));
        }
        println!("tower of ten {name}: drift {drift:.1e} m in 10 s, fastest {fastest:.1e} m/s");
        assert!(drift < 1.0e-3, "{name} drift {drift} m");
        assert!(fastest < 1.0e-3, "{name} move at {fastest} m/s");
    }
}
