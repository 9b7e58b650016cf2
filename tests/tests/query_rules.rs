//! What holds for every query: the order and the overflow of what is found, filters, sectors, caches,
//! executors, and the refusal of bad input.

use cellstep::math::{Rotation, Vec3};
use cellstep::{
    BodyDef, BodyKind, BodyKinds, ClosestPoint, CompoundHandle, Error, Executor, Filter, Found, Geometry,
    HeightFieldHandle, Hit, HullHandle, MeshHandle, Overlap, Pool, Position, Probe, Queries, QueryFilter,
    QueryShape, Ray, Region, Serial, ShapeCast, ShapeDef,
};
use cellstep_tests::executors::{Random, Shuffled};
use cellstep_tests::mixed::{Draw, mixed_world};
use cellstep_tests::simulator;
use cellstep_tests::worlds::{OwnedWorld, world};

const ALL: QueryFilter = QueryFilter::ALL;

/// Some queries of each kind.
struct Questions {
    rays: Vec<Ray>,
    casts: Vec<ShapeCast>,
    regions: Vec<Region>,
    probes: Vec<Probe>,
}

/// What each of them finds first.
#[derive(Clone, Debug, PartialEq)]
struct Answers {
    rays: Vec<Option<Hit>>,
    casts: Vec<Option<Hit>>,
    regions: Vec<Option<Overlap>>,
    probes: Vec<Option<ClosestPoint>>,
}

impl Questions {
    fn new(seed: u64, count: usize) -> Self {
        let mut random = Random::new(seed);
        let mut some = Self { rays: Vec::new(), casts: Vec::new(), regions: Vec::new(), probes: Vec::new() };
        for _ in 0..count {
            let mut place = |limit| Position::at(random.vector(limit));
            let (origin, start, middle, position) = (place(14.0), place(12.0), place(10.0), place(12.0));
            let shape =
                QueryShape { geometry: random.solid(0.8), position: start, rotation: random.rotation() };
            some.rays.push(Ray { origin, translation: random.vector(25.0) });
            some.casts.push(ShapeCast { shape, translation: random.vector(20.0) });
            some.regions.push(Region::Shape(QueryShape { position: middle, ..shape }));
            some.probes.push(Probe { position, max_distance: random.between(0.0, 5.0) });
        }
        some
    }

    /// Moved by whole sectors.
    fn moved(&self, sectors: [i32; 3]) -> Self {
        let shift = |place: Position| shifted(place, sectors);
        let shape = |s: QueryShape| QueryShape { position: shift(s.position), ..s };
        Self {
            rays: self.rays.iter().map(|ray| Ray { origin: shift(ray.origin), ..*ray }).collect(),
            casts: self.casts.iter().map(|cast| ShapeCast { shape: shape(cast.shape), ..*cast }).collect(),
            regions: self
                .regions
                .iter()
                .map(|region| match *region {
                    Region::Shape(s) => Region::Shape(shape(s)),
                    other => panic!("{other:?} is not asked"),
                })
                .collect(),
            probes: self.probes.iter().map(|p| Probe { position: shift(p.position), ..*p }).collect(),
        }
    }

    fn ask(&self, queries: &Queries<'_>, filter: &QueryFilter) -> Answers {
        let good = "good questions";
        Answers {
            rays: self.rays.iter().map(|q| queries.cast_ray(q, filter).expect(good)).collect(),
            casts: self.casts.iter().map(|q| queries.cast_shape(q, filter).expect(good)).collect(),
            regions: self.regions.iter().map(|q| queries.overlap(q, filter).expect(good)).collect(),
            probes: self.probes.iter().map(|q| queries.closest_point(q, filter).expect(good)).collect(),
        }
    }

    fn ask_at_once(&self, queries: &Queries<'_>, executor: &mut impl Executor) -> Answers {
        let good = "good questions";
        let mut answers = Answers {
            rays: vec![None; self.rays.len()],
            casts: vec![None; self.casts.len()],
            regions: vec![None; self.regions.len()],
            probes: vec![None; self.probes.len()],
        };
        queries.cast_rays(&self.rays, &ALL, &mut answers.rays, executor).expect(good);
        queries.cast_shapes(&self.casts, &ALL, &mut answers.casts, executor).expect(good);
        queries.overlaps(&self.regions, &ALL, &mut answers.regions, executor).expect(good);
        queries.closest_points(&self.probes, &ALL, &mut answers.probes, executor).expect(good);
        answers
    }
}

fn shifted(place: Position, sectors: [i32; 3]) -> Position {
    Position { sector: std::array::from_fn(|i| place.sector[i] + sectors[i]), ..place }
}

impl Answers {
    fn count(&self) -> usize {
        let hits = self.rays.iter().chain(&self.casts).flatten().count();
        hits + self.regions.iter().flatten().count() + self.probes.iter().flatten().count()
    }

    fn moved(mut self, sectors: [i32; 3]) -> Self {
        for hit in self.rays.iter_mut().chain(&mut self.casts).flatten() {
            hit.point = shifted(hit.point, sectors);
        }
        for point in self.probes.iter_mut().flatten() {
            point.point = shifted(point.point, sectors);
        }
        self
    }
}

/// Asks with buffers of every length and checks that each holds the beginning of the longest.
fn check_overflow<T: Copy + Default + PartialEq + std::fmt::Debug>(
    ask: impl Fn(&mut [T]) -> Result<Found, Error>,
) -> usize {
    let mut all = vec![T::default(); 1024];
    let total = ask(&mut all).expect("a good question");
    assert_eq!(total.dropped, 0);
    for room in 0..=total.count {
        let mut some = vec![T::default(); room];
        let found = ask(&mut some).expect("a good question");
        assert_eq!(found, Found { count: room, dropped: total.count - room });
        assert_eq!(some, all[..room], "the first ones, in order");
    }
    total.count
}

#[test]
fn what_does_not_fit_is_the_last_and_is_counted() {
    let mut world = mixed_world(1);
    let queries = world.queries();
    let rays = Questions::new(17, 300).rays;
    let all_of = |ray| check_overflow(|buffer: &mut [Hit]| queries.cast_ray_all(ray, &ALL, buffer));
    assert!(rays.iter().map(all_of).max() > Some(3));
    let wide = QueryShape {
        geometry: Geometry::Sphere { radius: 3.0 },
        position: Position::at(Vec3::new(-14.0, 0.0, 0.0)),
        rotation: Rotation::IDENTITY,
    };
    let cast = ShapeCast { shape: wide, translation: Vec3::new(28.0, 1.0, -1.0) };
    let region = Region::Box { center: Position::ORIGIN, half_extents: Vec3::splat(8.0) };
    let probe = Probe { position: Position::ORIGIN, max_distance: 9.0 };
    assert!(check_overflow(|buffer: &mut [Hit]| queries.cast_shape_all(&cast, &ALL, buffer)) > 15);
    assert!(check_overflow(|buffer: &mut [Overlap]| queries.overlap_all(&region, &ALL, buffer)) > 60);
    assert!(
        check_overflow(|buffer: &mut [ClosestPoint]| queries.closest_point_all(&probe, &ALL, buffer)) > 60
    );
}

/// An empty world that knows the hulls that random shapes may be of.
fn mixed_world_without_bodies() -> OwnedWorld {
    let mut world = mixed_world(1);
    for body in world.bodies().collect::<Vec<_>>() {
        world.remove_body(body).expect("alive");
    }
    world
}

#[test]
fn equal_distances_go_by_slot_and_then_by_triangle() {
    let mut world = mixed_world_without_bodies();
    let mut shapes = Vec::new();
    for kind in
        [BodyKind::Dynamic, BodyKind::Static, BodyKind::Kinematic, BodyKind::Static, BodyKind::Dynamic]
    {
        let body = world.create_body(&BodyDef::new(kind, Vec3::new(5.0, 0.0, 0.0))).expect("room");
        let def = ShapeDef::new(Geometry::Box { half_extents: Vec3::ONE });
        shapes.push(world.create_shape(body, &def).expect("room"));
    }
    let ray = Ray { origin: Position::ORIGIN, translation: Vec3::X * 9.0 };
    let mut hits = [Hit::default(); 8];
    let queries = world.queries();
    let found = queries.cast_ray_all(&ray, &ALL, &mut hits).expect("a good ray");
    assert!(hits[..found.count].iter().map(|hit| hit.shape).eq(shapes.iter().copied()));
    assert!(hits[..found.count].iter().all(|hit| hit.distance == 4.0 && hit.normal == Vec3::NEG_X));
    assert_eq!(queries.cast_ray(&ray, &ALL).expect("a good ray").expect("a hit").shape, shapes[0]);

    // The static ones are in a tree of their own, which is looked at first: that must not count.
    let questions = Questions::new(18, 3000);
    let answers = questions.ask(&world.queries(), &ALL);
    assert!(answers.count() > 100, "{}", answers.count());
    let met = answers.rays.iter().chain(&answers.casts).flatten().map(|hit| hit.shape);
    for shape in met.chain(answers.probes.iter().flatten().map(|point| point.shape)) {
        assert_eq!(shape, shapes[0]);
    }

    // A ray at an edge between two triangles meets both at the same place; the lower one is told.
    let mut world = simulator::empty_world(simulator::CAPACITIES);
    let body = world.create_body(&BodyDef::new(BodyKind::Static, Vec3::ZERO)).expect("room");
    world.create_shape(body, &ShapeDef::new(Geometry::Mesh(MeshHandle(0)))).expect("room");
    let origin = Position::at(Vec3::new(-3.0 + 0.75, -3.0 + 0.75, 9.0));
    let ray = Ray { origin, translation: Vec3::Z * -20.0 };
    let queries = world.queries();
    let found = queries.cast_ray_all(&ray, &ALL, &mut hits).expect("a good ray");
    assert_eq!((found.count, hits[0].child, hits[1].child), (2, 0, 1));
    assert_eq!(hits[0].distance, hits[1].distance);
    assert_eq!(queries.cast_ray(&ray, &ALL).expect("a good ray"), Some(hits[0]));
}

#[test]
fn filters_leave_out_what_they_say() {
    let mut world = mixed_world(2);
    let questions = Questions::new(3, 300);
    for kind in [BodyKind::Static, BodyKind::Kinematic, BodyKind::Dynamic] {
        let kinds = [BodyKinds::STATIC, BodyKinds::KINEMATIC, BodyKinds::DYNAMIC][kind as usize];
        let answers = questions.ask(&world.queries(), &QueryFilter { kinds, ..ALL });
        assert!(answers.count() > 40, "{kind:?}");
        let hits = answers.rays.iter().chain(&answers.casts).flatten();
        let bodies = hits.map(|hit| hit.body).chain(answers.regions.iter().flatten().map(|o| o.body));
        for body in bodies.chain(answers.probes.iter().flatten().map(|point| point.body)) {
            assert_eq!(world.kind(body), Ok(kind));
        }
    }
    let none = questions.ask(&world.queries(), &QueryFilter { kinds: BodyKinds(0), ..ALL });
    assert_eq!(none.count(), 0);

    let first = questions.ask(&world.queries(), &ALL).rays.into_iter().flatten().next().expect("a ray hits");
    let skip = QueryFilter { skip: Some(first.body), ..ALL };
    let answers = questions.ask(&world.queries(), &skip);
    assert!(answers.rays.iter().flatten().all(|hit| hit.body != first.body));

    let meets = Filter { category: 1, mask: 0b100, group: 0 };
    let answers = questions.ask(&world.queries(), &QueryFilter { meets: Some(meets), ..ALL });
    let found: Vec<_> = answers.rays.iter().chain(&answers.casts).flatten().collect();
    assert!(found.len() > 20);
    for hit in found {
        assert_eq!(world.shape(hit.shape).expect("alive").filter.category, 0b100);
    }
}

#[test]
fn a_shift_by_whole_sectors_changes_no_bit() {
    let mut here = mixed_world(4);
    // Poses are given to both, so that both are rounded alike.
    let place = |world: &mut OwnedWorld, sectors: [i32; 3]| {
        for body in world.bodies().collect::<Vec<_>>() {
            let at = shifted(world.position(body).expect("alive"), sectors);
            world.set_pose(body, at, world.rotation(body).expect("alive")).expect("inside the world");
        }
    };
    place(&mut here, [0; 3]);
    let questions = Questions::new(5, 400);
    let answers = questions.ask(&here.queries(), &ALL);
    assert!(answers.count() > 800);
    for sectors in [[156_250, -77_777, 4096], [-3, 1 << 20, 0], [1 << 27, 1 << 27, -(1 << 27)]] {
        let mut there = mixed_world(4);
        place(&mut there, sectors);
        let moved = questions.moved(sectors);
        assert_eq!(moved.ask(&there.queries(), &ALL), answers.clone().moved(sectors), "{sectors:?}");
        // Asked from the world's first place, nothing is near.
        let dynamic = QueryFilter { kinds: BodyKinds::DYNAMIC, ..ALL };
        assert_eq!(questions.ask(&there.queries(), &dynamic).count(), 0);
    }
}

/// Some change of a world, the same for the same numbers.
fn change(world: &mut OwnedWorld, random: &mut Random) {
    let bodies: Vec<_> = world.bodies().collect();
    let body = bodies[random.below(bodies.len() as u64) as usize];
    let place = Position::at(random.vector(10.0));
    let done = match random.below(6) {
        0 => world.set_pose(body, place, random.rotation()),
        1 => world.remove_body(body),
        2 => world
            .create_body(&BodyDef { position: place, kind: BodyKind::Static, ..BodyDef::default() })
            .and_then(|body| world.create_shape(body, &ShapeDef::new(random.solid(1.0))))
            .map(|_| ()),
        3 => world
            .create_body(&BodyDef { position: place, ..BodyDef::default() })
            .and_then(|body| world.create_shape(body, &ShapeDef::new(random.solid(1.0))))
            .map(|_| ()),
        4 => world.set_kind(body, [BodyKind::Static, BodyKind::Kinematic][random.below(2) as usize]),
        _ => {
            let shapes: Vec<_> = world.shapes_of(body).expect("alive").collect();
            let geometry = random.solid(1.0);
            let pose = cellstep::math::Pose::new(random.vector(0.5), random.rotation());
            shapes.first().map_or(Ok(()), |&shape| world.set_geometry(shape, &geometry, &pose))
        }
    };
    assert!(matches!(done, Ok(()) | Err(Error::Full { .. })), "{done:?}");
}

#[test]
fn caches_and_queries_change_no_bit() {
    let (mut asked, mut quiet, mut dropped) = (mixed_world(6), mixed_world(6), mixed_world(6));
    let (mut a, mut b, mut c) = (Random::new(60), Random::new(60), Random::new(60));
    let questions = Questions::new(61, 25);
    let mut snapshot = Vec::new();
    let mut found = 0;
    for round in 0..120 {
        if round % 3 != 0 {
            change(&mut asked, &mut a);
            change(&mut quiet, &mut b);
            change(&mut dropped, &mut c);
        }
        if round % 2 == 0 {
            let before = asked.checksum();
            let answers = questions.ask(&asked.queries(), &ALL);
            assert_eq!(asked.checksum(), before, "round {round}: queries only read");
            dropped.drop_caches();
            assert_eq!(questions.ask(&dropped.queries(), &ALL), answers, "round {round}: without caches");
            assert_eq!(questions.ask(&asked.queries(), &ALL), answers, "round {round}: again");
            snapshot.resize(asked.snapshot_bytes(), 0);
            asked.save(&mut snapshot).expect("room");
            dropped.restore(&snapshot).expect("the same capacities");
            assert_eq!(questions.ask(&dropped.queries(), &ALL), answers, "round {round}: restored");
            found += answers.count();
        }
        if round % 4 != 1 {
            for world in [&mut asked, &mut quiet, &mut dropped] {
                world.step(&mut Serial);
            }
        }
        assert_eq!(
            asked.checksum(),
            quiet.checksum(),
            "round {round}: a world that was asked goes the same way"
        );
    }
    assert!(found > 2000, "{found}");
}

#[test]
fn batches_tell_what_single_queries_tell() {
    let mut world = mixed_world(9);
    let questions = Questions::new(10, 500);
    let queries = world.queries();
    let singles = questions.ask(&queries, &ALL);
    assert_eq!(questions.ask_at_once(&queries, &mut Serial), singles);
    assert_eq!(questions.ask_at_once(&queries, &mut Shuffled::new(3)), singles);
    for workers in [1, 2, 3] {
        let mut pool = Pool::new(workers).expect("threads can be started");
        assert_eq!(questions.ask_at_once(&queries, &mut pool), singles, "{workers} workers");
    }
    let few = Questions::new(10, 0);
    assert_eq!(few.ask_at_once(&queries, &mut Serial).count(), 0);
}

#[test]
fn many_threads_ask_at_once() {
    let mut world = mixed_world(11);
    let queries = world.queries();
    let questions = Questions::new(12, 100);
    let expected = questions.ask(&queries, &ALL);
    std::thread::scope(|scope| {
        for _ in 0..4 {
            scope.spawn(|| assert_eq!(questions.ask(&queries, &ALL), expected));
        }
    });
}

#[test]
fn bad_input_is_refused() {
    let mut world = mixed_world(13);
    let queries = world.queries();
    let ray = Ray { origin: Position::ORIGIN, translation: Vec3::X };
    let shape = QueryShape {
        geometry: Geometry::Sphere { radius: 1.0 },
        position: Position::ORIGIN,
        rotation: Rotation::IDENTITY,
    };
    let cast = ShapeCast { shape, translation: Vec3::X };
    let ray_error = |ray: Ray| queries.cast_ray(&ray, &ALL).expect_err("refused");
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let translation = Vec3::new(0.0, bad, 1.0);
        assert_eq!(ray_error(Ray { translation, ..ray }), Error::NotFinite { name: "translation" });
        let origin = Position { offset: translation, ..Position::ORIGIN };
        assert_eq!(ray_error(Ray { origin, ..ray }), Error::NotFinite { name: "origin" });
        let found = queries.cast_shape(&ShapeCast { translation, ..cast }, &ALL);
        assert_eq!(found, Err(Error::NotFinite { name: "translation" }));
        let turned = QueryShape { rotation: Rotation::new(0.0, bad, 0.0, 1.0), ..shape };
        let found = queries.cast_shape(&ShapeCast { shape: turned, ..cast }, &ALL);
        assert_eq!(found, Err(Error::NotFinite { name: "rotation" }));
        assert_eq!(queries.overlap(&Region::Point(origin), &ALL), Err(Error::NotFinite { name: "position" }));
        let probe = Probe { position: Position::ORIGIN, max_distance: bad };
        assert_eq!(queries.closest_point(&probe, &ALL), Err(Error::NotFinite { name: "max_distance" }));
        let region = Region::Box { center: Position::ORIGIN, half_extents: Vec3::new(1.0, bad, 1.0) };
        assert_eq!(queries.overlap(&region, &ALL), Err(Error::NotFinite { name: "half_extents" }));
    }
    for translation in [Vec3::ZERO, -Vec3::ZERO, Vec3::X * 1.1e7] {
        assert_eq!(ray_error(Ray { translation, ..ray }), Error::OutOfRange { name: "translation" });
        let found = queries.cast_shape(&ShapeCast { translation, ..cast }, &ALL);
        assert_eq!(found, Err(Error::OutOfRange { name: "translation" }));
    }
    let origin = Position { sector: [i32::MIN, 0, 0], offset: Vec3::ZERO };
    assert_eq!(ray_error(Ray { origin, ..ray }), Error::OutOfRange { name: "origin" });
    let probe = Probe { position: Position::ORIGIN, max_distance: -1.0 };
    assert_eq!(queries.closest_point(&probe, &ALL), Err(Error::OutOfRange { name: "max_distance" }));
    let skewed = QueryShape { rotation: Rotation::new(0.0, 0.0, 0.0, 0.5), ..shape };
    let found = queries.overlap(&Region::Shape(skewed), &ALL);
    assert_eq!(found, Err(Error::NotARotation { name: "rotation" }));
    for (geometry, error) in [
        (Geometry::HalfSpace, Error::NotConvex),
        (Geometry::Mesh(MeshHandle(0)), Error::NotConvex),
        (Geometry::HeightField(HeightFieldHandle(0)), Error::NotConvex),
        (Geometry::Compound(CompoundHandle(2)), Error::Stale { what: "compound" }),
        (Geometry::RoundedHull { hull: HullHandle(2), radius: 0.1 }, Error::Stale { what: "hull" }),
        (Geometry::RoundedHull { hull: HullHandle(0), radius: -0.1 }, Error::OutOfRange { name: "radius" }),
        (Geometry::Cone { half_height: 0.0, radius: 1.0 }, Error::OutOfRange { name: "half_height" }),
        (Geometry::Hull(HullHandle(2)), Error::Stale { what: "hull" }),
        (Geometry::Hull(HullHandle(u32::MAX)), Error::Stale { what: "hull" }),
        (Geometry::Sphere { radius: 0.0 }, Error::OutOfRange { name: "radius" }),
    ] {
        let found = queries.cast_shape(&ShapeCast { shape: QueryShape { geometry, ..shape }, ..cast }, &ALL);
        assert_eq!(found, Err(error));
    }
    let bad = Ray { translation: Vec3::ZERO, ..ray };
    let mut hits = [Some(Hit::default()); 2];
    let found = queries.cast_rays(&[ray, bad], &ALL, &mut hits, &mut Serial);
    assert_eq!(found, Err(Error::OutOfRange { name: "translation" }));
    assert_eq!(hits, [Some(Hit::default()); 2], "nothing was written");
    let found = queries.cast_rays(&[ray], &ALL, &mut hits, &mut Serial);
    assert_eq!(found, Err(Error::WrongLength { needed: 1, given: 2 }));
}

#[test]
fn an_empty_world_has_nothing_to_find() {
    let mut world = world(4);
    let questions = Questions::new(14, 20);
    let some: Vec<_> = questions.rays.iter().map(|ray| world.queries().cast_ray(ray, &ALL)).collect();
    assert!(some.iter().all(|found| *found == Ok(None)));
    let body = world.create_body(&BodyDef::default()).expect("room");
    let probe = Probe { position: Position::ORIGIN, max_distance: 1.0 };
    assert_eq!(world.queries().closest_point(&probe, &ALL), Ok(None));
    world.create_shape(body, &ShapeDef::new(Geometry::Sphere { radius: 0.1 })).expect("room");
    assert!(world.queries().closest_point(&probe, &ALL).expect("a good probe").is_some());
}

/// Numbers of any size, most of them odd.
fn wild(random: &mut Random) -> f32 {
    match random.below(8) {
        0 => 0.0,
        1 => f32::from_bits(random.bits() as u32),
        2 => -0.0,
        3 => random.between(-1.0e-30, 1.0e-30),
        4 => random.between(-1.0e7, 1.0e7),
        _ => random.between(-20.0, 20.0),
    }
}

#[test]
fn any_numbers_are_refused_or_answered() {
    let mut world = mixed_world(15);
    let queries = world.queries();
    let mut random = Random::new(16);
    let (mut answered, mut hits) = (0, [Hit::default(); 4]);
    for _ in 0..40_000 {
        let mut vector = || Vec3::new(wild(&mut random), wild(&mut random), wild(&mut random));
        let (offset, translation, half) = (vector(), vector(), vector());
        let origin = Position { sector: [0, 0, (offset.x * 0.1) as i32], offset };
        let geometry = match (half.y as i32).rem_euclid(5) {
            0 => Geometry::Sphere { radius: half.x.abs() },
            1 => Geometry::Capsule { half_height: half.x.abs(), radius: half.z.abs() },
            2 => Geometry::Cylinder { half_height: half.x.abs(), radius: half.z.abs() },
            3 => Geometry::Cone { half_height: half.x.abs(), radius: half.z.abs() },
            _ => Geometry::Box { half_extents: half.abs() },
        };
        let shape = QueryShape { geometry, position: origin, rotation: random.rotation() };
        let ray = Ray { origin, translation };
        let single = queries.cast_ray(&ray, &ALL);
        let many = queries.cast_ray_all(&ray, &ALL, &mut hits);
        assert_eq!(single.is_ok(), many.is_ok());
        let cast = queries.cast_shape(&ShapeCast { shape, translation }, &ALL);
        for hit in single.iter().chain(&cast).flatten() {
            let finite = hit.point.offset.is_finite() && hit.distance.is_finite() && hit.fraction <= 1.0;
            assert!(finite && (hit.normal.length() - 1.0).abs() < 1.0e-5, "{hit:?} {ray:?}");
            answered += 1;
        }
        let region = queries.overlap(&Region::Shape(shape), &ALL);
        let probe = queries.closest_point(&Probe { position: origin, max_distance: half.x.abs() }, &ALL);
        for point in probe.iter().flatten() {
            assert!(
                point.distance <= half.x.abs() * 1.000_001 && point.point.offset.is_finite(),
                "{point:?}"
            );
        }
        answered += usize::from(matches!(region, Ok(Some(_))));
    }
    assert!(answered > 5000, "{answered}");
}
