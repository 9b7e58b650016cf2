//! What queries tell, against brute force over all shapes and triangles in double precision.

use cellstep::math::{Rotation, Vec3};
use cellstep::{
    BodyDef, BodyKind, ClosestPoint, Geometry, Hit, Overlap, Position, Probe, QueryFilter, QueryShape, Ray,
    Region, ShapeCast, ShapeDef,
};
use cellstep_tests::executors::Random;
use cellstep_tests::mixed::{Draw, mixed_world};
use cellstep_tests::oracles::{Wide, cross, dot, minus, norm, plus, wide};
use cellstep_tests::solids::{self, Part, Solid, unit};
use cellstep_tests::worlds::{OwnedWorld, world};

/// Errors are at most this, metres: shapes are of about one metre, so a hundredth of what is promised.
const NEAR: f64 = 2.0e-6;
const ALL: QueryFilter = QueryFilter::ALL;

fn ray(random: &mut Random) -> Ray {
    Ray { origin: Position::at(random.vector(14.0)), translation: random.vector(30.0) }
}

/// True when the balls around two sets are apart after the first has moved some way along a line of some length.
fn is_far(moving: &Solid, part: &Solid, (d, length): (Wide, f64)) -> bool {
    let ((from, own), (center, radius)) = (moving.ball(), part.ball());
    let to = minus(center, from);
    let beside = minus(to, d.map(|x| x * dot(to, d).clamp(0.0, length)));
    norm(beside) > own + radius + 0.1
}

/// Where a ray meets a part at the earliest and at the latest, if every length is off by `NEAR`. Infinity: not.
fn bounds_of_hit(part: &Part, origin: Wide, d: Wide, length: f64) -> [f64; 2] {
    let never = f64::INFINITY;
    if is_far(&Solid::Ball(origin, 0.0), &part.solid, (d, length)) {
        return [never; 2];
    }
    let early = part.solid.first_within(origin, d, (length, NEAR)).unwrap_or(never);
    let Solid::Triangle([a, b, c]) = part.solid else {
        return [early, part.solid.first_within(origin, d, (length, -NEAR)).unwrap_or(never)];
    };
    let n = unit(cross(minus(b, a), minus(c, a)));
    let s = dot(minus(a, origin), n) / dot(d, n);
    let p = plus(origin, d, s);
    let inside = |a: Wide, b: Wide| dot(unit(cross(n, minus(b, a))), minus(p, a)) > NEAR;
    let is_sure = s > 0.0 && s < length && inside(a, b) && inside(b, c) && inside(c, a);
    [early, if is_sure { s } else { never }]
}

#[test]
fn rays_meet_what_brute_force_meets() {
    let mut hits = 0;
    for seed in 0..4 {
        let mut world = mixed_world(seed);
        let parts = solids::of_world(&world);
        let queries = world.queries();
        let mut random = Random::new(seed + 100);
        for i in 0..800 {
            let ray = ray(&mut random);
            let (origin, way) = (ray.origin.to_f64(), wide(ray.translation));
            let (d, length) = (unit(way), norm(way));
            let found = queries.cast_ray(&ray, &ALL).expect("a good ray");
            let bounds: Vec<[f64; 2]> = parts.iter().map(|p| bounds_of_hit(p, origin, d, length)).collect();
            let [early, late] = [0, 1].map(|k| bounds.iter().map(|b| b[k]).fold(f64::INFINITY, f64::min));
            let Some(hit) = found else {
                assert!(late == f64::INFINITY, "{seed} {i}: missed a hit at {late}");
                continue;
            };
            hits += 1;
            let s = f64::from(hit.distance);
            let rounding = 1.0e-6 * (1.0 + s);
            assert!(s >= early - rounding && s <= late + rounding, "{seed} {i}: {early} {s} {late} {hit:?}");
            let part = parts.iter().find(|p| (p.shape, p.child) == (hit.shape, hit.child)).expect("a part");
            check_contact(&part.solid, (origin, d), &hit);
        }
    }
    assert!(hits > 1500, "{hits} rays hit");
}

/// The point lies on the ray and on the surface, and the normal is the surface's there.
fn check_contact(solid: &Solid, (origin, d): (Wide, Wide), hit: &Hit) {
    let (point, normal) = (hit.point.to_f64(), wide(hit.normal));
    assert!((norm(normal) - 1.0).abs() < 1.0e-6, "{hit:?}");
    let s = f64::from(hit.distance);
    assert!(norm(minus(point, plus(origin, d, s))) < 1.0e-5, "{hit:?}");
    if s == 0.0 {
        assert!(solid.distance(origin) <= NEAR && norm(plus(normal, d, 1.0)) < 1.0e-6, "{hit:?}");
        return;
    }
    assert!(dot(normal, d) < 0.0, "{hit:?}");
    assert!(solid.distance(point).abs() < 1.0e-5, "{hit:?} {}", solid.distance(point));
    // Outside along the normal the distance grows as fast as the way.
    let outside = solid.distance(plus(point, normal, 0.01));
    assert!((outside - 0.01).abs() < 3.0e-5, "{hit:?} {outside}");
}

#[test]
fn all_that_a_ray_meets_is_told_in_order() {
    let mut world = mixed_world(7);
    let parts = solids::of_world(&world);
    let queries = world.queries();
    let mut random = Random::new(8);
    let (mut buffer, mut most) = (vec![Hit::default(); 256], 0);
    for i in 0..600 {
        let ray = ray(&mut random);
        let (origin, way) = (ray.origin.to_f64(), wide(ray.translation));
        let (d, length) = (unit(way), norm(way));
        let found = queries.cast_ray_all(&ray, &ALL, &mut buffer).expect("a good ray");
        assert_eq!(found.dropped, 0);
        let hits = &buffer[..found.count];
        most = most.max(found.count);
        let key = |hit: &Hit| (hit.distance, hit.shape.index, hit.child);
        assert!(hits.windows(2).all(|w| key(&w[0]) < key(&w[1])), "{i}: in order, each once");
        assert_eq!(queries.cast_ray(&ray, &ALL).expect("a good ray").as_ref(), hits.first(), "{i}");
        for part in &parts {
            let [early, late] = bounds_of_hit(part, origin, d, length);
            let hit = hits.iter().find(|hit| (hit.shape, hit.child) == (part.shape, part.child));
            match hit {
                None => assert!(late == f64::INFINITY, "{i}: {part:?} is missing"),
                Some(hit) => {
                    let s = f64::from(hit.distance);
                    let rounding = 1.0e-6 * (1.0 + s);
                    assert!(s >= early - rounding && s <= late + rounding, "{i}: {early} {s} {late}");
                    check_contact(&part.solid, (origin, d), hit);
                }
            }
        }
    }
    assert!(most > 6, "{most}");
}

fn shape_cast(random: &mut Random) -> ShapeCast {
    let shape = QueryShape {
        geometry: random.solid(0.6),
        position: Position::at(random.vector(14.0)),
        rotation: random.rotation(),
    };
    ShapeCast { shape, translation: random.vector(25.0) }
}

/// The solids that something moving or asked for consists of.
fn own_parts(world: &OwnedWorld, geometry: &Geometry, place: (Wide, Rotation)) -> Vec<Solid> {
    let parts = solids::parts(world, (Default::default(), geometry), place);
    parts.into_iter().map(|part| part.solid).collect()
}

/// The least separation of some solids from another.
fn least_separation(own: &[Solid], other: &Solid) -> f64 {
    own.iter().map(|own| own.separation(other)).fold(f64::INFINITY, f64::min)
}

/// What disproves a hit of a moving solid: at the hit a plane parts the two, and since the motion is against its
/// normal it did so all the way; and the point of contact belongs to both.
fn wrong_hit(part: &Part, (moving, d): (&Solid, Wide), hit: &Hit) -> Option<String> {
    let s = f64::from(hit.distance);
    let (normal, point) = (wide(hit.normal), hit.point.to_f64());
    let there = moving.moved(d.map(|x| x * s));
    assert!((norm(normal) - 1.0).abs() < 1.0e-6 && dot(normal, d) <= 1.0e-6, "{hit:?}");
    let gap = -there.reach(normal.map(|x| -x)) - part.solid.reach(normal);
    let off = [part.solid.distance(point), there.distance(point)];
    let is_right = gap > -1.0e-5 && off.iter().all(|off| *off < 1.0e-5);
    (!is_right).then(|| format!("overlap by {gap}, the point is off by {off:?}: {part:?} {there:?}"))
}

#[test]
fn moving_shapes_meet_what_they_meet_and_nothing_before() {
    let (mut hits, mut starts_inside) = (0, 0);
    for seed in 0..3 {
        let mut world = mixed_world(seed + 20);
        let parts = solids::of_world(&world);
        let mut random = Random::new(seed + 200);
        let casts: Vec<ShapeCast> = (0..350).map(|_| shape_cast(&mut random)).collect();
        let mut buffer = vec![Hit::default(); 256];
        for (i, cast) in casts.iter().enumerate() {
            let place = (cast.shape.position.to_f64(), cast.shape.rotation);
            let moving = own_parts(&world, &cast.shape.geometry, place);
            let queries = world.queries();
            let found = queries.cast_shape_all(cast, &ALL, &mut buffer).expect("a good cast");
            let all = &buffer[..found.count];
            assert_eq!(queries.cast_shape(cast, &ALL).expect("a good cast").as_ref(), all.first(), "{i}");
            let key = |hit: &Hit| (hit.distance, hit.shape.index, hit.child);
            assert!(all.windows(2).all(|w| key(&w[0]) < key(&w[1])), "{i}: in order");
            let (way, d) = (wide(cast.translation), unit(wide(cast.translation)));
            for hit in all {
                let part =
                    parts.iter().find(|p| (p.shape, p.child) == (hit.shape, hit.child)).expect("a part");
                if hit.distance == 0.0 {
                    assert!(least_separation(&moving, &part.solid) < NEAR, "{i}: {hit:?}");
                    assert!(
                        norm(plus(wide(hit.normal), d, 1.0)) < 1.0e-6 && hit.point == cast.shape.position
                    );
                    starts_inside += 1;
                } else {
                    let wrong: Vec<_> =
                        moving.iter().filter_map(|own| wrong_hit(part, (own, d), hit)).collect();
                    assert!(wrong.len() < moving.len(), "{i}: {hit:?} {wrong:?}");
                }
                hits += 1;
            }
            // What is not told is not met, and no triangle is met before the one that is told.
            for (part, own) in parts.iter().flat_map(|part| moving.iter().map(move |own| (part, own))) {
                let hit = all.iter().find(|hit| hit.shape == part.shape);
                let end = hit.map_or(norm(way), |hit| f64::from(hit.distance) - 1.0e-4);
                for k in 0..if end > 0.0 { 16 } else { 0 } {
                    let s = end * f64::from(k) / 15.0;
                    if is_far(own, &part.solid, (d, s)) {
                        continue;
                    }
                    let overlap = own.moved(d.map(|x| x * s)).separation(&part.solid);
                    assert!(overlap > -NEAR, "{seed} {i}: {overlap} at {s} of {end} with {part:?}");
                }
            }
        }
    }
    assert!(hits > 1500 && starts_inside > 100, "{hits} {starts_inside}");
}

#[test]
fn regions_overlap_what_brute_force_finds() {
    let mut found_any = [0; 3];
    for seed in 0..3 {
        let mut world = mixed_world(seed + 30);
        let parts = solids::of_world(&world);
        let mut random = Random::new(seed + 300);
        let mut buffer = vec![Overlap::default(); 256];
        for i in 0..500 {
            let position = Position::at(random.vector(11.0));
            let (region, geometry, rotation) = match i % 3 {
                0 => (Region::Point(position), Geometry::Sphere { radius: 0.0 }, Default::default()),
                1 => {
                    let half_extents = random.vector(1.5).abs() + Vec3::splat(1.0e-3);
                    let region = Region::Box { center: position, half_extents };
                    (region, Geometry::Box { half_extents }, Default::default())
                }
                _ => {
                    let (geometry, rotation) = (random.solid(1.0), random.rotation());
                    (Region::Shape(QueryShape { geometry, position, rotation }), geometry, rotation)
                }
            };
            let place = (position.to_f64(), rotation);
            let own = own_parts(&world, &geometry, place);
            let queries = world.queries();
            let found = queries.overlap_all(&region, &ALL, &mut buffer).expect("a good region");
            let all = &buffer[..found.count];
            assert!(all.windows(2).all(|w| w[0].shape.index < w[1].shape.index), "{i}: each shape once");
            assert_eq!(queries.overlap(&region, &ALL).expect("a good region").as_ref(), all.first(), "{i}");
            for part in &parts {
                let told = all.iter().find(|overlap| overlap.shape == part.shape);
                let is_near = |own: &&Solid| !is_far(own, &part.solid, ([0.0; 3], 0.0));
                let near: Vec<Solid> = own.iter().filter(is_near).cloned().collect();
                let apart = least_separation(&near, &part.solid);
                match told {
                    None => assert!(apart > -NEAR, "{i}: {part:?} overlaps by {apart}"),
                    Some(told) if told.child == part.child => assert!(apart < NEAR, "{i}: {part:?} {apart}"),
                    Some(told) => assert!(told.child < part.child || apart > -NEAR, "{i}: the least part"),
                }
            }
            found_any[i % 3] += all.len();
        }
    }
    assert!(found_any.iter().all(|count| *count > 50), "{found_any:?}");
}

#[test]
fn closest_points_are_those_of_brute_force() {
    for seed in 0..3 {
        let mut world = mixed_world(seed + 40);
        let parts = solids::of_world(&world);
        let queries = world.queries();
        let mut random = Random::new(seed + 400);
        let mut buffer = vec![ClosestPoint::default(); 256];
        for i in 0..700 {
            let probe =
                Probe { position: Position::at(random.vector(14.0)), max_distance: random.between(0.0, 6.0) };
            let place = probe.position.to_f64();
            let found = queries.closest_point_all(&probe, &ALL, &mut buffer).expect("a good probe");
            let all = &buffer[..found.count];
            let key = |point: &ClosestPoint| (point.distance, point.shape.index);
            assert!(all.windows(2).all(|w| key(&w[0]) < key(&w[1])), "{i}: in order");
            assert_eq!(
                queries.closest_point(&probe, &ALL).expect("a good probe").as_ref(),
                all.first(),
                "{i}"
            );
            let mut shapes: Vec<_> = parts.iter().map(|part| part.shape).collect();
            shapes.dedup();
            for shape in shapes {
                let own = || parts.iter().filter(move |part| part.shape == shape);
                let nearest =
                    own().map(|part| part.solid.distance(place)).fold(f64::INFINITY, f64::min).max(0.0);
                let Some(told) = all.iter().find(|point| point.shape == shape) else {
                    assert!(nearest > f64::from(probe.max_distance) - NEAR, "{i}: {shape:?} is at {nearest}");
                    continue;
                };
                assert!((f64::from(told.distance) - nearest).abs() < NEAR, "{i}: {told:?} {nearest}");
                let part = own().find(|part| part.child == told.child).expect("a part");
                let point = told.point.to_f64();
                assert!(part.solid.distance(point) < 1.0e-5, "{i}: {told:?}");
                assert!((norm(minus(place, point)) - nearest).abs() < 1.0e-5, "{i}: {told:?}");
                if told.distance > 0.0 {
                    let back = plus(point, wide(told.normal), nearest);
                    assert!(norm(minus(back, place)) < 1.0e-5, "{i}: {told:?}");
                } else {
                    assert!(told.normal == Vec3::ZERO && told.point == probe.position, "{i}: {told:?}");
                }
            }
        }
    }
}

/// A cast of a box of some size at a box of another size, started `away` metres off.
fn box_at_box([own, other]: [f32; 2], away: f32) -> Hit {
    let mut world = world(1);
    let body = world.create_body(&BodyDef::new(BodyKind::Static, Vec3::ZERO)).expect("room");
    let shape = ShapeDef::new(Geometry::Box { half_extents: Vec3::splat(other) });
    world.create_shape(body, &shape).expect("room");
    let cast = ShapeCast {
        shape: QueryShape {
            geometry: Geometry::Box { half_extents: Vec3::splat(own) },
            position: Position::from_f64([-f64::from(own + other + away), 0.3 * f64::from(other), 0.0]),
            rotation: Default::default(),
        },
        translation: Vec3::new(away * 2.0, 0.0, 0.0),
    };
    world.queries().cast_shape(&cast, &ALL).expect("a good cast").expect("in the way")
}

#[test]
fn casts_are_exact_from_millimetres_to_kilometres() {
    for own in [1.0e-3, 1.0, 1.0e3] {
        for other in [1.0e-3, 1.0, 1.0e3] {
            for away in [1.0e-2, 1.0, 1.0e3] {
                let hit = box_at_box([own, other], away);
                let error = (hit.distance - away).abs();
                // Half a last bit of the start's place, of the result, and a ten-thousandth of the smaller box.
                let limit = 4.0e-6
                    + 1.0e-7 * away
                    + 1.0e-7 * (own + other)
                    + 1.0e-4 * cellstep::math::min(own, other);
                assert!(error < limit, "{own} {other} {away}: {hit:?}");
                assert!((hit.normal - Vec3::NEG_X).length() < 1.0e-6, "{own} {other} {away}: {hit:?}");
            }
        }
    }
}
