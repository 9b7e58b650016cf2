//! What queries tell in the cases that are a matter of convention: starts inside, back faces, parallel rays,
//! the ends of a ray; and far from the origin.

use cellstep::math::{Rotation, Vec3, cos, sin};
use cellstep::{
    BodyDef, BodyKind, BodyKinds, Geometry, Hit, HullHandle, MeshHandle, Overlap, Position, Probe,
    QueryFilter, QueryShape, Ray, Region, ShapeCast, ShapeDef,
};
use cellstep_tests::oracles::wide;
use cellstep_tests::simulator;
use cellstep_tests::worlds::OwnedWorld;

const ALL: QueryFilter = QueryFilter::ALL;

/// A world with one static shape at the origin.
fn with(geometry: Geometry) -> OwnedWorld {
    let mut world = simulator::empty_world(simulator::CAPACITIES);
    let body = world.create_body(&BodyDef::new(BodyKind::Static, Vec3::ZERO)).expect("room");
    world.create_shape(body, &ShapeDef::new(geometry)).expect("room");
    world
}

fn ray(from: [f32; 3], translation: [f32; 3]) -> Ray {
    Ray { origin: Position::at(Vec3::from(from)), translation: Vec3::from(translation) }
}

fn cast(world: &mut OwnedWorld, from: [f32; 3], translation: [f32; 3]) -> Option<Hit> {
    world.queries().cast_ray(&ray(from, translation), &ALL).expect("a good ray")
}

const CONVEX: [Geometry; 4] = [
    Geometry::Sphere { radius: 1.0 },
    Geometry::Capsule { half_height: 0.5, radius: 0.75 },
    Geometry::Box { half_extents: Vec3::ONE },
    Geometry::Hull(HullHandle(0)),
];

#[test]
fn who_starts_inside_hits_at_once_against_the_motion() {
    for geometry in CONVEX.into_iter().chain([Geometry::HalfSpace]) {
        let mut world = with(geometry);
        // The hull stands on its base, the half-space ends at z = 0.
        let inside = if geometry == Geometry::HalfSpace { [0.1, 0.05, -0.2] } else { [0.1, 0.05, 0.2] };
        for way in [[0.0, 3.0, 4.0], [-1.0, 0.0, 0.0]] {
            let hit = cast(&mut world, inside, way).expect("inside");
            assert_eq!((hit.distance, hit.fraction, hit.child), (0.0, 0.0, 0), "{geometry:?}");
            assert!((hit.normal + Vec3::from(way).normalize()).length() < 1.0e-6, "{geometry:?} {hit:?}");
            assert_eq!(hit.point, Position::at(Vec3::from(inside)), "{geometry:?}");
            let shape = QueryShape {
                geometry: Geometry::Sphere { radius: 0.05 },
                position: hit.point,
                rotation: Rotation::IDENTITY,
            };
            let moving = ShapeCast { shape, translation: Vec3::from(way) };
            let found = world.queries().cast_shape(&moving, &ALL).expect("a good cast").expect("inside");
            assert_eq!(
                (found.distance, found.normal, found.point),
                (0.0, hit.normal, hit.point),
                "{geometry:?}"
            );
        }
        let probe = Probe { position: Position::at(Vec3::from(inside)), max_distance: 0.0 };
        let closest = world.queries().closest_point(&probe, &ALL).expect("a good probe").expect("inside");
        assert_eq!((closest.distance, closest.normal, closest.point), (0.0, Vec3::ZERO, probe.position));
        let region = Region::Point(probe.position);
        let overlap = world.queries().overlap(&region, &ALL).expect("a good region");
        assert_eq!(overlap, Some(Overlap { shape: closest.shape, body: closest.body, child: 0 }));
    }
}

#[test]
fn a_start_on_the_surface_is_inside() {
    let mut cube = with(Geometry::Box { half_extents: Vec3::ONE });
    assert_eq!(cast(&mut cube, [1.0, 0.0, 0.0], [1.0, 0.0, 0.0]).expect("closed").distance, 0.0);
    assert!(cast(&mut cube, [1.000_001, 0.0, 0.0], [1.0, 0.0, 0.0]).is_none());
    let mut ground = with(Geometry::HalfSpace);
    assert_eq!(cast(&mut ground, [5.0, 0.0, 0.0], [0.0, 0.0, 1.0]).expect("closed").distance, 0.0);
}

#[test]
fn a_ray_ends_where_it_ends() {
    for geometry in CONVEX {
        let mut world = with(geometry);
        let far = cast(&mut world, [9.0, 0.01, 0.02], [-18.0, 0.0, 0.0]).expect("in the way");
        let short = |part: f32| [-far.distance * part, 0.0, 0.0];
        assert!(cast(&mut world, [9.0, 0.01, 0.02], short(0.9999)).is_none(), "{geometry:?}");
        let hit = cast(&mut world, [9.0, 0.01, 0.02], short(1.0001)).expect("just reached");
        assert!((hit.distance - far.distance).abs() < 1.0e-6 && hit.fraction > 0.999, "{geometry:?} {hit:?}");
        assert!((far.fraction * 18.0 - far.distance).abs() < 1.0e-5, "{geometry:?} {far:?}");
        assert!(
            cast(&mut world, [9.0, 0.01, 0.02], [9.0, 0.0, 0.0]).is_none(),
            "{geometry:?}: behind the start"
        );
    }
}

#[test]
fn parallel_rays_pass_planes_and_meet_faces() {
    let mut ground = with(Geometry::HalfSpace);
    assert!(cast(&mut ground, [0.0, 0.0, 1.0e-3], [1.0e6, 0.0, 0.0]).is_none());
    let mut cube = with(Geometry::Box { half_extents: Vec3::ONE });
    // Along a face: the box is closed. Just beside it: nothing.
    let hit = cast(&mut cube, [-5.0, 0.0, 1.0], [10.0, 0.0, 0.0]).expect("along the face");
    assert_eq!((hit.distance, hit.normal), (4.0, Vec3::NEG_X));
    assert!(cast(&mut cube, [-5.0, 0.0, 1.000_001], [10.0, 0.0, 0.0]).is_none());
    let mut capsule = with(Geometry::Capsule { half_height: 1.0, radius: 0.5 });
    let hit = cast(&mut capsule, [0.0, 0.2, 5.0], [0.0, 0.0, -10.0]).expect("along the axis");
    assert!((hit.distance - (4.0 - (0.25_f32 - 0.04).sqrt())).abs() < 1.0e-6, "{hit:?}");
    assert!(cast(&mut capsule, [0.0, 0.500_01, 5.0], [0.0, 0.0, -10.0]).is_none());
}

#[test]
fn meshes_have_two_sides_and_no_thickness() {
    let mut world = simulator::empty_world(simulator::CAPACITIES);
    let body = world.create_body(&BodyDef::new(BodyKind::Static, Vec3::ZERO)).expect("room");
    world.create_shape(body, &ShapeDef::new(Geometry::Mesh(MeshHandle(0)))).expect("room");
    let above = cast(&mut world, [0.4, 0.3, 5.0], [0.0, 0.0, -10.0]).expect("from above");
    let below = cast(&mut world, [0.4, 0.3, -5.0], [0.0, 0.0, 10.0]).expect("from below");
    assert_eq!(above.child, below.child);
    assert!((above.normal + below.normal).length() < 1.0e-6 && above.normal.z > 0.5, "{above:?} {below:?}");
    assert!((above.distance + below.distance - 10.0).abs() < 1.0e-5);
    // From the middle both ways are free but for the triangle the ray starts under.
    let beside = above.point.plus(Vec3::Z * 1.0e-3);
    let up = Ray { origin: beside, translation: Vec3::Z };
    assert_eq!(world.queries().cast_ray(&up, &ALL), Ok(None));
    assert_eq!(world.queries().overlap(&Region::Point(beside), &ALL), Ok(None));
    let ball = QueryShape {
        geometry: Geometry::Sphere { radius: 2.0e-3 },
        position: beside,
        rotation: Rotation::IDENTITY,
    };
    let found = world.queries().overlap(&Region::Shape(ball), &ALL).expect("a good region").expect("touches");
    assert_eq!(found.child, above.child);
    // In a triangle's plane a ray passes: the flat mesh below is met by none along it.
    let mut flat = simulator::empty_world(simulator::CAPACITIES);
    let corners = [Vec3::ZERO, Vec3::X, Vec3::Y];
    assert!(flat.add_mesh(&corners, &[[0, 1, 2]]).is_err(), "no room for a second mesh");
    let mut flat = cellstep_tests::worlds::world_with(simulator::CAPACITIES);
    let mesh = flat.add_mesh(&corners, &[[0, 1, 2]]).expect("a triangle is a mesh");
    let body = flat.create_body(&BodyDef::new(BodyKind::Static, Vec3::ZERO)).expect("room");
    flat.create_shape(body, &ShapeDef::new(Geometry::Mesh(mesh))).expect("room");
    assert!(cast(&mut flat, [-1.0, 0.2, 0.0], [3.0, 0.0, 0.0]).is_none());
    assert!(cast(&mut flat, [-1.0, 0.2, 0.1], [3.0, 0.0, -0.2]).is_some());
}

#[test]
fn small_things_far_away_are_met_exactly() {
    // A ball of 1 cm, seen from 1 km, 10,000 km from the origin, where the trees count their coordinates: there the
    // first shape is.
    let home = Position::from_f64([1.0e7, -1.0e7, 64.0]);
    let mut world = with(Geometry::HalfSpace);
    let def = BodyDef { position: home, kind: BodyKind::Kinematic, ..BodyDef::default() };
    let body = world.create_body(&def).expect("room");
    world.create_shape(body, &ShapeDef::new(Geometry::Sphere { radius: 0.01 })).expect("room");
    for i in 0..50 {
        let turn = i as f32;
        let direction = Vec3::new(cos(turn), sin(turn), sin(3.0 * turn)).normalize();
        // Beside the center by 6 mm: the ray's line is known to 0.1 mm, by the place and direction as they are.
        let aside = direction.any_orthonormal_vector() * 0.006;
        let origin = home.plus(direction * -1000.0 + aside);
        let ray = Ray { origin, translation: direction * 2000.0 };
        let filter = QueryFilter { kinds: BodyKinds::KINEMATIC, ..ALL };
        let hit = world.queries().cast_ray(&ray, &filter).expect("a good ray").expect("in the way");
        let off = hit.point.minus(home).length() - 0.01;
        assert!(off.abs() < 1.0e-6, "{i}: {off}");
        let exact = {
            let (o, d) = (wide(origin.minus(home)), wide(ray.translation));
            let length = (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]).sqrt();
            let along: f64 = (0..3).map(|k| -o[k] * d[k] / length).sum();
            let beside: f64 = (0..3).map(|k| (o[k] + d[k] / length * along).powi(2)).sum();
            along - (1.0e-4 - beside).sqrt()
        };
        assert!((f64::from(hit.distance) - exact).abs() < 1.0e-4, "{i}: {hit:?} {exact}");
    }
}
