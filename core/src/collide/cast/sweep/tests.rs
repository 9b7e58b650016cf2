//! A moving point against the closed forms for rays, and moving shapes where they graze.

use super::*;
use crate::collide::cast::frame::length;
use crate::collide::cast::ray;
use crate::collide::hull;
use crate::collide::polytope::BoxHull;
use crate::math::{Rotation, Vec3};

/// Numbers in -1..1.
fn random(state: &mut u64) -> f64 {
    *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    (*state >> 11) as f64 / 4_503_599_627_370_496.0 - 1.0
}

fn vector(state: &mut u64) -> DVec3 {
    DVec3::new(random(state), random(state), random(state))
}

fn first(solid: &Solid<'_>, ray: &Ray) -> Option<Contact> {
    let mut found = None;
    ray::cast(solid, ray, ray.length, |contact| {
        found = Some(contact);
        contact.distance
    });
    found
}

#[test]
fn a_moving_point_meets_what_a_ray_meets() {
    let cube = BoxHull::new(Vec3::new(0.3, 0.8, 0.5));
    let mut points = [Vec3::ZERO; 30];
    let mut seed = 3;
    points.iter_mut().for_each(|point| *point = super::super::frame::narrowed(vector(&mut seed)));
    let tables = hull::build(&points).unwrap();
    let solids = [
        Solid::Sphere { radius: 0.7 },
        Solid::Capsule { half_height: 0.8, radius: 0.3 },
        Solid::Capsule { half_height: 0.0, radius: 0.9 },
        Solid::Box { half_extents: Vec3::new(0.9, 0.002, 0.4) },
        Solid::Hull(cube.hull()),
        Solid::Hull(tables.view()),
        Solid::Cylinder { half_height: 0.8, radius: 0.4 },
        Solid::Cylinder { half_height: 0.01, radius: 0.9 },
        Solid::Cone { half_height: 0.7, radius: 0.6 },
        Solid::Cone { half_height: 0.02, radius: 1.0 },
    ];
    for solid in &solids {
        let (mut hits, mut misses, mut inside) = (0, 0, 0);
        for _ in 0..4000 {
            let (origin, to) = (vector(&mut seed) * 2.0, vector(&mut seed));
            let direction = (to - origin) / length(to - origin);
            let ray = Ray { origin, direction, length: 2.5 };
            let (closed, swept) = (first(solid, &ray), cast(solid, &Moving::point(&ray), ray.length));
            match (closed, swept) {
                (Some(a), Some(b)) => {
                    hits += 1;
                    inside += u32::from(a.distance == 0.0);
                    // A plane of a hull is rounded to f32.
                    let steep = -a.normal.dot(direction);
                    assert!((a.distance - b.distance).abs() * steep < 1.0e-6, "{solid:?} {a:?} {b:?}");
                }
                (None, None) => misses += 1,
                (Some(found), None) | (None, Some(found)) => {
                    // At an edge or grazing, or at the end of the way.
                    let end = (found.distance - ray.length).abs() < 1.0e-6;
                    let shifted = |by: f64| {
                        let origin = origin + DVec3::new(by, -by, by);
                        first(solid, &Ray { origin, ..ray }).is_some()
                    };
                    let graze = shifted(3.0e-6) != shifted(-3.0e-6);
                    assert!(end || graze, "{solid:?} {closed:?} {swept:?}");
                }
            }
        }
        assert!(hits > 300 && misses > 300, "{solid:?}: {hits} {misses} {inside}");
    }
}

#[test]
fn rays_pass_no_edge_between_triangles() {
    // A fan about a corner: rays at the corner and at points of the edges meet at least one triangle.
    let ring: [DVec3; 7] = core::array::from_fn(|i| {
        let turn = i as f64 * core::f64::consts::TAU / 7.0;
        DVec3::new(libm::cos(turn), libm::sin(turn), 0.1 * libm::sin(3.0 * turn))
    });
    let mut seed = 9;
    for i in 0..7000 {
        let target = ring[i % 7] * (random(&mut seed) * 0.499 + 0.5);
        let origin = DVec3::new(0.3, -0.2, 5.0) + vector(&mut seed);
        let direction = (target - origin) / length(target - origin);
        let ray = Ray { origin, direction, length: 20.0 };
        let met =
            (0..7).filter(|&k| ray::triangle(&ray, [DVec3::ZERO, ring[k], ring[(k + 1) % 7]], 0).is_some());
        assert!(met.count() > 0, "{i}: a ray slips through");
    }
}

#[test]
fn rays_meet_cylinders_and_cones_of_any_proportions() {
    let mut seed = 29;
    let mut hits = 0;
    for case in 0..60_000 {
        let size = |exponent: f64| libm::pow(10.0, exponent);
        let (half, radius) = (size(4.0 * random(&mut seed)), size(4.0 * random(&mut seed)));
        let reach = libm::sqrt(half * half + radius * radius);
        // At points of and in the shape, some from far away, some straight along an axis.
        let (p, turn) = (vector(&mut seed), 3.2 * random(&mut seed));
        let target = DVec3::new(libm::cos(turn) * radius * p.x, libm::sin(turn) * radius * p.x, half * p.y);
        let mut origin = target + vector(&mut seed) * reach * size(3.0 * (p.z + 1.0));
        match case % 5 {
            0 => (origin.x, origin.y) = (target.x, target.y),
            1 => origin.z = target.z,
            _ => {}
        }
        let away = length(target - origin);
        let direction = (target - origin) / away;
        let ray = Ray { origin, direction, length: 2.0 * away };
        let [half, radius] = [half as f32, radius as f32];
        let solid = if case % 2 == 0 {
            Solid::Cylinder { half_height: half, radius }
        } else {
            Solid::Cone { half_height: half, radius }
        };
        let [half, radius] = [half, radius].map(f64::from);
        let round = 1.0e-13 * (reach + away);
        // How far outside a point is, by its greatest excess over a bounding surface.
        let slant = libm::sqrt(radius * radius + 4.0 * half * half);
        let outside = |p: DVec3| {
            let across = libm::sqrt(p.x * p.x + p.y * p.y);
            let side = if case % 2 == 0 {
                across - radius
            } else {
                (2.0 * half * across - radius * (half - p.z)) / slant
            };
            let end = if case % 2 == 0 { p.z.abs() - half } else { -half - p.z };
            if side > end { side } else { end }
        };
        let Some(found) = first(&solid, &ray) else {
            assert!(outside(target) > -round, "{case}: {ray:?} misses {solid:?}");
            continue;
        };
        hits += 1;
        if found.distance == 0.0 {
            assert!(outside(origin) <= round, "{case}: {ray:?} {solid:?}");
            continue;
        }
        let at = origin + direction * found.distance;
        // Where the ray grazes, its place is as uncertain as the root of the rounding.
        assert!(outside(at).abs() < 1.0e-7 * reach + round, "{case}: {} {ray:?} {solid:?}", outside(at));
        assert!((length(found.normal) - 1.0).abs() < 1.0e-6, "{case}: {found:?} {solid:?}");
        assert!(found.normal.dot(direction) < 1.0e-6, "{case}: {found:?} {ray:?} {solid:?}");
        let before = origin + direction * (found.distance * 0.999);
        assert!(outside(before) > -round - 1.0e-9 * reach, "{case}: {found:?} {ray:?} {solid:?}");
    }
    assert!(hits > 30_000, "{hits}");
}

#[test]
fn grazing_balls_meet_or_pass() {
    let ball = Solid::Sphere { radius: 1.0 };
    let core = Core::new(&ball).unwrap();
    let direction = DVec3::X;
    for offset in [1.0e-3, 1.0e-5, 1.0e-7, 1.0e-8] {
        for side in [-1.0, 1.0] {
            let height = 2.0 + side * offset;
            let frame = Frame::IDENTITY.at(DVec3::new(-10.0, height, 0.0));
            let moving = Moving { core, frame, direction, length: 20.0 };
            let found = cast(&ball, &moving, 20.0);
            assert_eq!(found.is_some(), side < 0.0, "{height}");
            if let Some(found) = found {
                let exact = 10.0 - libm::sqrt(4.0 - height * height);
                assert!((found.distance - exact).abs() < 1.0e-6, "{height}: {found:?} {exact}");
            }
        }
    }
}

#[test]
fn who_touches_and_leaves_is_not_stopped() {
    let cube = Solid::Box { half_extents: Vec3::ONE };
    let core = Core::new(&cube).unwrap();
    let at = |x: f64, direction: DVec3| {
        let frame = Frame::new(DVec3::new(x, 0.2, 0.1), Rotation::IDENTITY);
        cast(&cube, &Moving { core, frame, direction, length: 5.0 }, 5.0)
    };
    assert!(at(2.0 + 1.0e-9, DVec3::X).is_none());
    assert!(at(2.0 + 1.0e-9, DVec3::Y).is_none());
    let back = at(2.0 + 1.0e-9, DVec3::NEG_X).unwrap();
    assert!(back.distance < 2.0e-9 && length(back.normal - DVec3::X) < 1.0e-6, "{back:?}");
    let deep = at(1.5, DVec3::X).unwrap();
    assert_eq!((deep.distance, deep.normal), (0.0, DVec3::NEG_X));
}

/// A convex shape of a size, some with thin sides.
fn shape(kind: usize, size: f32, hull: &hull::HullTables) -> Solid<'_> {
    match kind {
        0 => Solid::Sphere { radius: size },
        1 => Solid::Capsule { half_height: size, radius: 0.2 * size },
        2 => Solid::Box { half_extents: Vec3::new(1.0, 0.05, 0.6) * size },
        3 => Solid::Cylinder { half_height: size, radius: 0.4 * size },
        4 => Solid::Cone { half_height: 0.5 * size, radius: size },
        5 => Solid::RoundedHull { hull: hull.view(), radius: 0.1 * size },
        _ => Solid::Hull(hull.view()),
    }
}

#[test]
fn shapes_of_all_sizes_stop_where_they_touch() {
    let mut seed = 17;
    let sizes = [1.0e-3_f32, 1.0, 1.0e3];
    let hulls = sizes.map(|size| {
        let points: [Vec3; 20] =
            core::array::from_fn(|_| super::super::frame::narrowed(vector(&mut seed)) * size);
        hull::build(&points).unwrap()
    });
    let (mut hits, mut worst) = (0, 0.0);
    for case in 0..12_000 {
        let [i, j] = [case % 3, case / 3 % 3];
        let (a, b) = (shape(case / 9 % 7, sizes[i], &hulls[i]), shape(case / 63 % 7, sizes[j], &hulls[j]));
        let (core_a, core_b) = (Core::new(&a).unwrap(), Core::new(&b).unwrap());
        let reach = core_a.extent() + core_b.extent();
        let turn = super::super::frame::narrowed(vector(&mut seed) * 3.0);
        let away = vector(&mut seed);
        let start = away / length(away) * reach * (1.0 + 20.0 * (random(&mut seed) + 1.0));
        let target = vector(&mut seed) * 0.6 * core_a.extent();
        let way = length(target - start);
        let direction = (target - start) / way;
        let moving = Moving {
            core: core_b,
            frame: Frame::new(start, Rotation::from_rotation_vector(turn)),
            direction,
            length: 2.0 * way,
        };
        let Some(found) = cast(&a, &moving, moving.length) else { continue };
        hits += 1;
        let smaller = if sizes[i] < sizes[j] { sizes[i] } else { sizes[j] };
        // The plane of the contact parts the shapes there, so it did all the way.
        let frame = moving.frame.at(start + direction * found.distance);
        let low =
            frame.transform(core_b.support(frame.unturn(-found.normal))).dot(found.normal) - core_b.radius;
        let high = core_a.support(found.normal).dot(found.normal) + core_a.radius;
        let gap = (low - high).abs() / f64::from(smaller);
        worst = if gap > worst { gap } else { worst };
        assert!(found.normal.dot(direction) < 1.0e-9, "{case}: {found:?}");
        assert!(gap < 1.0e-5, "{case}: {gap} {found:?} {a:?} {b:?}");
        // The point belongs to both.
        let off = (found.point.dot(found.normal) - high).abs();
        let point =
            Pair { a: &core_b, b: &Core::POINT, b_in_a: Frame::IDENTITY.at(frame.untransform(found.point)) };
        let off_moving = point.separation(&mut point.start()).distance - core_b.radius;
        assert!(off < 1.0e-5 * f64::from(smaller), "{case}: {off} {found:?}");
        // A point is as exact as a direction times the larger shape.
        let limit = 1.0e-5 * f64::from(smaller) + 1.0e-9 * reach;
        assert!(off_moving < limit, "{case}: {off_moving} {found:?} {a:?} {b:?}");
    }
    assert!(hits > 2000, "{hits} hits, worst gap {worst} of the smaller size");
}
