//! Shapes by support functions against an oracle that samples directions, and in the poses in which they rest.

extern crate std;
use super::*;
use crate::collide::hull::{self, HullTables};
use crate::collide::{Manifolds, convex, half_space};
use crate::math::{PI, length as length32};
use glam::DVec3;
use std::vec::Vec;

struct Dice(u64);

impl Dice {
    fn roll(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f32 / 16_777_216.0
    }
    fn range(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * self.roll()
    }
    fn vector(&mut self, reach: f32) -> Vec3 {
        Vec3::new(self.range(-reach, reach), self.range(-reach, reach), self.range(-reach, reach))
    }
    fn pose(&mut self, reach: f32) -> Pose {
        let turn = match (self.roll() * 3.0) as u32 {
            0 => Vec3::AXES[(self.roll() * 3.0) as usize] * (0.5 * PI),
            1 => Vec3::AXES[(self.roll() * 3.0) as usize] * (0.5 * PI) + self.vector(1.0e-2),
            _ => self.vector(3.0),
        };
        Pose::new(self.vector(reach), Rotation::from_rotation_vector(turn))
    }
}

fn rock() -> HullTables {
    let mut dice = Dice(7);
    let points: Vec<Vec3> = (0..14)
        .map(|_| {
            let v = dice.vector(1.0);
            v * (0.6 / length32(v))
        })
        .collect();
    hull::build(&points).expect("points on a ball")
}

/// Every convex kind, at a size of about one metre; the first three have support functions of their own.
fn kinds(rock: &HullTables) -> [Solid<'_>; 7] {
    [
        Solid::Cylinder { half_height: 0.7, radius: 0.4 },
        Solid::Cone { half_height: 0.5, radius: 0.6 },
        Solid::RoundedHull { hull: rock.view(), radius: 0.15 },
        Solid::Sphere { radius: 0.5 },
        Solid::Capsule { half_height: 0.5, radius: 0.3 },
        Solid::Box { half_extents: Vec3::new(0.5, 0.7, 0.3) },
        Solid::Hull(rock.view()),
    ]
}

/// Greatest `n . x` over a shape, written anew for the test.
fn reach(solid: &Solid<'_>, pose: &Pose, n: DVec3) -> f64 {
    let axes = axes_of(pose.rotation);
    let d = [axes[0].dot(n), axes[1].dot(n), axes[2].dot(n)];
    let across = libm::hypot(d[0], d[1]);
    let f = |x: &f32| f64::from(*x);
    let hull = |hull: &Hull<'_>| {
        let heights = hull.vertices.iter().map(|v| f(&v.x) * d[0] + f(&v.y) * d[1] + f(&v.z) * d[2]);
        heights.fold(f64::NEG_INFINITY, f64::max)
    };
    let own = match solid {
        Solid::Sphere { radius } => f(radius),
        Solid::Capsule { half_height, radius } => f(half_height) * d[2].abs() + f(radius),
        Solid::Box { half_extents: h } => f(&h.x) * d[0].abs() + f(&h.y) * d[1].abs() + f(&h.z) * d[2].abs(),
        Solid::Cylinder { half_height, radius } => f(half_height) * d[2].abs() + f(radius) * across,
        Solid::Cone { half_height, radius } => {
            f64::max(f(half_height) * d[2], f(radius) * across - f(half_height) * d[2])
        }
        Solid::Hull(h) => hull(h),
        Solid::RoundedHull { hull: h, radius } => hull(h) + f(radius),
        _ => unreachable!(),
    };
    own + DVec3::from(pose.position).dot(n)
}

/// Distance along the best direction: of a dense net, and then by ever smaller steps from the best ones.
fn oracle(a: &Solid<'_>, b: &Solid<'_>, pose: &Pose) -> (f64, DVec3) {
    let apart = |n: DVec3| -reach(b, pose, -n) - reach(a, &Pose::IDENTITY, n);
    let unit = |v: DVec3| v / length(v);
    let count = 500;
    let mut net: Vec<(f64, DVec3)> = (0..count)
        .map(|i| {
            let z = 1.0 - 2.0 * (f64::from(i) + 0.5) / f64::from(count);
            let turn = f64::from(i) * 2.399_963_229_728_653;
            let r = libm::sqrt(1.0 - z * z);
            let n = DVec3::new(r * libm::cos(turn), r * libm::sin(turn), z);
            (apart(n), n)
        })
        .collect();
    net.sort_by(|x, y| y.0.total_cmp(&x.0));
    let mut best = net[0];
    for start in &net[..5] {
        let mut here = *start;
        let mut step = 0.08;
        while step > 1.0e-7 {
            let [u, v] = {
                let side = if here.1.x.abs() < 0.6 { DVec3::X } else { DVec3::Y };
                let u = unit(here.1.cross(side));
                [u, here.1.cross(u)]
            };
            let tries = (0..8).map(|k| {
                let turn = f64::from(k) * core::f64::consts::FRAC_PI_4 + step * 1.0e3;
                let n = unit(here.1 + u * (step * libm::cos(turn)) + v * (step * libm::sin(turn)));
                (apart(n), n)
            });
            let next = tries.fold(here, |x, y| if y.0 > x.0 { y } else { x });
            if next.0 > here.0 {
                here = next;
            } else {
                step *= 0.5;
            }
        }
        if here.0 > best.0 {
            best = here;
        }
    }
    best
}

fn found(a: &Solid<'_>, b: &Solid<'_>, pose: &Pose, distance: f32) -> Option<Manifold> {
    let mut out = Manifolds::new();
    convex::collide(a, b, pose, distance, &mut out);
    assert!(out.len() < 2);
    let manifold = out.pop()?;
    assert!((manifold.normal.length_squared() - 1.0).abs() < 1.0e-5);
    for (i, p) in manifold.points.iter().enumerate() {
        assert!(p.separation <= distance && p.position.is_finite(), "{manifold:?}");
        assert!(manifold.points[..i].iter().all(|q| q.feature != p.feature), "{manifold:?}");
    }
    Some(manifold)
}

fn least(manifold: &Manifold) -> f32 {
    manifold.points.iter().fold(f32::INFINITY, |x, p| crate::math::min(p.separation, x))
}

/// Every pair with one of the new kinds.
fn pairs<'a>(kinds: &'a [Solid<'a>; 7]) -> impl Iterator<Item = (&'a Solid<'a>, &'a Solid<'a>)> {
    kinds[..3].iter().flat_map(move |a| kinds.iter().map(move |b| (a, b)))
}

#[test]
fn separations_are_those_of_the_oracle() {
    let rock = rock();
    let kinds = kinds(&rock);
    let mut dice = Dice(1);
    let (mut worst, mut worst_deep) = (0.0_f64, 0.0_f64);
    for (a, b) in pairs(&kinds) {
        for _ in 0..40 {
            let pose = dice.pose(1.1);
            let (apart, _) = oracle(a, b, &pose);
            let Some(m) = found(a, b, &pose, 0.2) else {
                assert!(apart > 0.2 - 1.0e-5, "{a:?} {b:?} {pose:?}: {apart}");
                continue;
            };
            let error = (f64::from(least(&m)) - apart).abs();
            // What has sunk in by a fifth of its size has several ways out that are about as short.
            if apart > -0.1 {
                worst = worst.max(error);
                assert!(error < 6.0e-4, "{a:?} {b:?} {pose:?}: {m:?} {apart}");
            } else {
                worst_deep = worst_deep.max(error);
                assert!(error < 0.1 * apart.abs(), "{a:?} {b:?} {pose:?}: {m:?} {apart}");
            }
        }
    }
    std::eprintln!("worst error {worst:e} m, deep {worst_deep:e} m");
}

#[test]
fn exchanged_shapes_have_the_same_contacts() {
    let rock = rock();
    let kinds = kinds(&rock);
    let mut dice = Dice(2);
    for (a, b) in pairs(&kinds) {
        for _ in 0..60 {
            let pose = dice.pose(0.9);
            let (Some(m), Some(t)) = (found(a, b, &pose, 0.1), found(b, a, &pose.inverse(), 0.1)) else {
                continue;
            };
            if least(&m) < -0.1 {
                // There are several ways out that are about as short, and the search is not exhaustive.
                continue;
            }
            assert!((least(&m) - least(&t)).abs() < 2.0e-4, "{a:?} {b:?} {pose:?}: {m:?} {t:?}");
            // Where two directions are as good either may be found; nearly everywhere there is one.
            let turned = -pose.rotation.rotate(t.normal);
            if least(&m) > 1.0e-3 {
                assert!(length32(turned - m.normal) < 2.0e-3, "{a:?} {b:?} {pose:?}: {m:?} {t:?}");
            }
        }
    }
}

#[test]
fn small_moves_turn_the_normal_by_little() {
    let rock = rock();
    let kinds = kinds(&rock);
    let mut dice = Dice(3);
    let mut compared = 0;
    for (a, b) in pairs(&kinds) {
        for _ in 0..100 {
            let pose = dice.pose(1.2);
            let moved = Pose::new(
                pose.position + dice.vector(1.0e-4),
                Rotation::from_rotation_vector(dice.vector(1.0e-4)).after(pose.rotation),
            );
            let (Some(m), Some(t)) = (found(a, b, &pose, 0.3), found(a, b, &moved, 0.3)) else { continue };
            let apart = least(&m);
            if apart > 0.01 {
                // The closest points move by no more than some 3e-4 each.
                assert!(length32(m.normal - t.normal) < 1.0e-3 / apart, "{a:?} {b:?} {pose:?}: {m:?} {t:?}");
                assert!((apart - least(&t)).abs() < 1.0e-3, "{a:?} {b:?} {pose:?}: {m:?} {t:?}");
                compared += 1;
            }
        }
    }
    assert!(compared > 300, "{compared}");
}

#[test]
fn the_normal_goes_on_while_shapes_sink_in() {
    let rock = rock();
    let kinds = kinds(&rock);
    let mut dice = Dice(4);
    let mut compared = 0;
    for (a, b) in pairs(&kinds) {
        for _ in 0..30 {
            let pose = dice.pose(1.2);
            let Some(m) = found(a, b, &pose, 0.4) else { continue };
            if least(&m) < 0.02 {
                continue;
            }
            // From 10 mm apart to 10 mm deep along the normal. At an edge or a corner another direction may become
            // the shorter way out as soon as they overlap.
            let mut before: Option<Vec3> = None;
            for step in 0..40 {
                let way = m.normal * (least(&m) - 0.01 + 5.0e-4 * step as f32);
                let moved = Pose::new(pose.position - way, pose.rotation);
                let n = found(a, b, &moved, 0.4).expect("nearer than before");
                let apart = 0.01 - 5.0e-4 * step as f32;
                let error = least(&n) - apart;
                let most = if apart > 0.0 { 2.0e-4 } else { 2.0e-4 - apart };
                assert!(error > -2.0e-4 && error < most, "{a:?} {b:?} {moved:?}: {n:?} {apart}");
                if apart > 2.0e-4
                    && let Some(before) = before.replace(n.normal)
                {
                    assert!(length32(n.normal - before) < 2.0e-3, "{a:?} {b:?} {moved:?}: {n:?} {before}");
                    compared += 1;
                }
            }
        }
    }
    assert!(compared > 2000, "{compared}");
}

/// The poses in which a cylinder and a cone rest on the plane z = 0, and how many points they rest on.
fn rests() -> Vec<(Solid<'static>, Pose, usize)> {
    let (h, r) = (0.7_f32, 0.4_f32);
    let cylinder = Solid::Cylinder { half_height: h, radius: r };
    let cone = Solid::Cone { half_height: h, radius: r };
    let turn = |angle: f32| Rotation::from_axis_angle(Vec3::Y, angle);
    // The side of a cone leans against its axis by the angle of tangent r / 2 h; it lies when that is level.
    let lean = crate::math::atan2(r, 2.0 * h);
    let height = h * crate::math::sin(lean);
    vec_of([
        (cylinder, Pose::new(Vec3::Z * h, Rotation::IDENTITY), 4),
        (cylinder, Pose::new(Vec3::Z * h, turn(PI)), 4),
        (cylinder, Pose::new(Vec3::Z * r, turn(0.5 * PI)), 2),
        (cone, Pose::new(Vec3::Z * h, Rotation::IDENTITY), 4),
        (cone, Pose::new(Vec3::Z * h, turn(PI)), 1),
        (cone, Pose::new(Vec3::Z * height, turn(0.5 * PI + lean)), 2),
    ])
}

fn vec_of<T, const N: usize>(items: [T; N]) -> Vec<T> {
    items.into_iter().collect()
}

#[test]
fn resting_shapes_touch_with_their_face_or_line() {
    let slab = Solid::Box { half_extents: Vec3::new(3.0, 3.0, 0.5) };
    let disc = Solid::Cylinder { half_height: 0.5, radius: 3.0 };
    let corners: Vec<Vec3> = (0..8)
        .map(|i| {
            let side = |bit: u32, x: f32| if i >> bit & 1 == 1 { x } else { -x };
            Vec3::new(side(0, 3.0), side(1, 3.0), side(2, 0.5))
        })
        .collect();
    let tables = hull::build(&corners).expect("a slab");
    let inner: Vec<Vec3> =
        corners.iter().map(|c| *c - Vec3::Z * (0.1 * if c.z > 0.0 { 1.0 } else { 0.0 })).collect();
    let inner = hull::build(&inner).expect("a slab");
    let floors =
        [slab, disc, Solid::Hull(tables.view()), Solid::RoundedHull { hull: inner.view(), radius: 0.1 }];
    for (solid, rest, count) in rests() {
        for sink in [-1.0e-3_f32, -1.0e-6, 1.0e-6, 1.0e-3] {
            for slide in [Vec3::ZERO, Vec3::new(0.3, -0.2, 0.0)] {
                let pose = Pose::new(rest.position + slide + Vec3::Z * sink, rest.rotation);
                let mut on_plane = Manifolds::new();
                half_space::collide(&solid, &pose, 0.02, &mut on_plane);
                let all = floors.iter().map(|floor| {
                    let pose = Pose::new(pose.position + Vec3::Z * 0.5, pose.rotation);
                    found(floor, &solid, &pose, 0.02).expect("touches")
                });
                for m in all.chain(on_plane) {
                    assert_eq!(m.points.len(), count, "{solid:?} {pose:?}: {m:?}");
                    assert!(length32(m.normal - Vec3::Z) < 1.0e-5, "{solid:?} {pose:?}: {m:?}");
                    for p in &m.points {
                        assert!((p.separation - sink).abs() < 2.0e-6, "{solid:?} {pose:?}: {m:?}");
                    }
                }
            }
        }
    }
}

#[test]
fn a_coin_on_its_edge_touches_at_the_lowest_point_of_the_rim() {
    let coin = Solid::Cylinder { half_height: 0.05, radius: 1.0 };
    for k in 0..400 {
        let (lean, turn) = (0.0011 * (k % 20 + 1) as f32, 0.37 * k as f32);
        let rotation =
            Rotation::from_axis_angle(Vec3::Z, turn).after(Rotation::from_axis_angle(Vec3::X, lean));
        let rotation = rotation.after(Rotation::from_axis_angle(Vec3::Z, 1.3 * turn));
        let height = 0.05 * crate::math::cos(lean) + crate::math::sin(lean);
        let mut out = Manifolds::new();
        half_space::collide(&coin, &Pose::new(Vec3::Z * (height - 1.0e-3), rotation), 0.02, &mut out);
        assert!((least(&out[0]) + 1.0e-3).abs() < 1.0e-6, "{lean} {turn}: {out:?}");
        let slab = Solid::Box { half_extents: Vec3::splat(2.0) };
        let m = found(&slab, &coin, &Pose::new(Vec3::Z * (2.0 + height - 1.0e-3), rotation), 0.02).unwrap();
        assert!((least(&m) + 1.0e-3).abs() < 2.0e-6, "{lean} {turn}: {m:?}");
    }
}

#[test]
fn a_rolling_cylinder_has_no_corners() {
    let (wheel, slab) =
        (Solid::Cylinder { half_height: 0.2, radius: 0.5 }, Solid::Box { half_extents: Vec3::splat(2.0) });
    let lying = Rotation::from_axis_angle(Vec3::X, 0.5 * PI);
    for k in 0..500 {
        let turn = Rotation::from_axis_angle(Vec3::Y, 0.0137 * k as f32);
        let pose = Pose::new(Vec3::new(0.0, 0.0, 2.499), turn.after(lying));
        let m = found(&slab, &wheel, &pose, 0.02).expect("touches");
        assert_eq!(m.points.len(), 2, "{m:?}");
        assert!(length32(m.normal - Vec3::Z) < 1.0e-6, "{m:?}");
        for p in &m.points {
            assert!((p.separation + 1.0e-3).abs() < 1.0e-6 && p.position.x.abs() < 1.0e-5, "{m:?}");
            assert!((p.position.y.abs() - 0.2).abs() < 1.0e-5, "{m:?}");
        }
    }
}

#[test]
fn discs_that_overhang_touch_within_both_outlines() {
    let coin = Solid::Cylinder { half_height: 0.1, radius: 1.0 };
    let slab = Solid::Box { half_extents: Vec3::new(1.0, 1.0, 0.1) };
    let mut dice = Dice(5);
    for _ in 0..300 {
        let slide = Vec3::new(dice.range(-1.6, 1.6), dice.range(-1.6, 1.6), 0.0);
        let turn = Rotation::from_axis_angle(Vec3::Z, dice.range(-3.0, 3.0));
        let pose = Pose::new(slide + Vec3::Z * 0.1999, turn);
        for floor in [&slab, &coin] {
            let Some(m) = found(floor, &coin, &pose, 0.02) else { continue };
            if m.normal.z < 0.999 {
                continue;
            }
            for p in &m.points {
                let from_center = p.position - pose.position;
                assert!(libm::hypotf(from_center.x, from_center.y) < 1.001, "{slide}: {m:?}");
                let inside = match floor {
                    Solid::Box { .. } => p.position.x.abs() < 1.001 && p.position.y.abs() < 1.001,
                    _ => libm::hypotf(p.position.x, p.position.y) < 1.001,
                };
                assert!(inside, "{slide}: {m:?}");
            }
        }
    }
}

#[test]
fn boxes_are_tight() {
    let rock = rock();
    let kinds = kinds(&rock);
    let mut dice = Dice(9);
    for solid in &kinds[..3] {
        for _ in 0..200 {
            let pose = dice.pose(2.0);
            let bounds = crate::collide::bounds::aabb(solid, &pose);
            for (i, axis) in [DVec3::X, DVec3::Y, DVec3::Z].into_iter().enumerate() {
                let (high, low) = (reach(solid, &pose, axis), -reach(solid, &pose, -axis));
                assert!((f64::from(bounds.max[i]) - high).abs() < 1.0e-6, "{solid:?} {pose:?}: {bounds:?}");
                assert!((f64::from(bounds.min[i]) - low).abs() < 1.0e-6, "{solid:?} {pose:?}: {bounds:?}");
            }
        }
    }
}

/// Needles, coins and specks at all sizes, deep in each other or apart: results are finite. Where a shape is not
/// absurdly slender, the shapes are that far apart along the normal that is claimed.
#[test]
fn extreme_sizes_give_finite_results() {
    let mut dice = Dice(10);
    let (mut touching, mut compared) = (0, 0);
    for i in 0..8000 {
        let sizes = [0; 7].map(|_| [1.0e-5, 1.0e-2, 1.0, 3.0e2, 1.0e5][(dice.roll() * 5.0) as usize]);
        let solid = |kind: u32, [half_height, radius, z]: [f32; 3]| match kind {
            0 => Solid::Cylinder { half_height, radius },
            1 => Solid::Cone { half_height, radius },
            2 => Solid::Sphere { radius },
            3 => Solid::Capsule { half_height, radius },
            _ => Solid::Box { half_extents: Vec3::new(half_height, radius, z) },
        };
        let a = solid(i % 2, [sizes[0], sizes[1], sizes[2]]);
        let b = solid(i / 2 % 5, [sizes[3], sizes[4], sizes[5]]);
        let pose = if i % 7 == 0 { Pose::IDENTITY } else { dice.pose(sizes[6]) };
        let Some(m) = found(&a, &b, &pose, 0.02) else { continue };
        touching += 1;
        let (mut low, mut high) = (f32::INFINITY, 0.0_f32);
        for &size in &sizes[..6] {
            (low, high) = (crate::math::min(size, low), crate::math::max(size, high));
        }
        if high > 3.1e4 * low {
            continue;
        }
        compared += 1;
        let n = DVec3::from(m.normal);
        let n = n / length(n);
        let apart = -reach(&b, &pose, -n) - reach(&a, &Pose::IDENTITY, n);
        // The normal in f32 is good to 1e-7 rad, which counts over the length of the shapes.
        let slack = 4.0e-6 * f64::from(high + length32(pose.position)) + 1.0e-3 * apart.abs();
        let error = (f64::from(least(&m)) - apart).abs();
        assert!(error < slack, "{a:?} {b:?} {pose:?}: {m:?} {apart}");
    }
    assert!(touching > 2000 && compared > 200, "{touching} {compared}");
}
