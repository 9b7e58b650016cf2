//! What does not fit is refused or dropped by rule, is reported, and gives the same bits for any number of workers.

use cellstep::math::Vec3;
use cellstep::scene::builtin::Builtin;
use cellstep::{
    BodyDef, BodyHandle, BodyKind, Capacities, Error, Executor, Geometry, Line, Memory, Pool, Serial,
    Settings, ShapeDef, StepReport, World,
};
use cellstep_tests::executors::Shuffled;
use cellstep_tests::simulator::{self, CAPACITIES};
use cellstep_tests::worlds::{self, OwnedWorld};
use std::path::Path;

/// Tiles under each plate, in rows of 12.
const TILES: u32 = 144;

/// Plates over tiles of their own: what a region holds.
struct Region {
    plate: BodyHandle,
    height: f32,
}

/// Regions of 12 x 12 static tiles, region by region, each with a plate at a height over them.
///
/// The tiles of a region come before its plate, so that pair order is the order of regions.
fn plates(heights: &[f32], (pairs, contacts): (u32, u32)) -> (OwnedWorld, Vec<Region>) {
    let count = heights.len() as u32;
    let capacities = Capacities {
        bodies: 2 * count,
        shapes: (TILES + 1) * count,
        pairs,
        contacts,
        ..Capacities::for_bodies(0)
    };
    let mut world = worlds::world_with(capacities);
    let mut regions = Vec::new();
    for (i, &height) in heights.iter().enumerate() {
        let corner = Vec3::new((i % 16) as f32 * 13.0, (i / 16) as f32 * 13.0, 0.0);
        let floor = world.create_body(&BodyDef::new(BodyKind::Static, corner)).expect("room");
        for tile in 0..TILES {
            let mut def = ShapeDef::new(Geometry::Box { half_extents: Vec3::splat(0.49) });
            def.pose.position = Vec3::new((tile % 12) as f32 - 5.5, (tile / 12) as f32 - 5.5, -0.49);
            world.create_shape(floor, &def).expect("room");
        }
        let def = BodyDef::new(BodyKind::Dynamic, corner + Vec3::new(0.0, 0.0, height + 0.1));
        let plate = ShapeDef::new(Geometry::Box { half_extents: Vec3::new(5.9, 5.9, 0.1) });
        let (plate, _) = worlds::add(&mut world, &def, &plate);
        regions.push(Region { plate, height });
    }
    (world, regions)
}

fn pairs_of_contacts(world: &OwnedWorld) -> Vec<[u32; 2]> {
    world.contacts().map(|contact| contact.shapes.map(|shape| shape.index)).collect()
}

/// Steps and gives the last report and the states' checksums.
fn run(world: &mut OwnedWorld, executor: &mut impl Executor, steps: u32) -> (StepReport, Vec<u64>) {
    let mut report = StepReport::default();
    let sums = (0..steps).map(|_| {
        report = world.step(executor);
        world.checksum()
    });
    let sums = sums.collect();
    (report, sums)
}

/// 256 plates land on 144 tiles each, and there is room for half of the pairs or contacts.
fn half_of_the_plates(room: (u32, u32)) {
    const ALL: u32 = 256 * TILES;
    const STEPS: u32 = 8;
    let heights = [0.01; 256];
    let (mut ample, _) = plates(&heights, (ALL, ALL));
    let (report, _) = run(&mut ample, &mut Serial, STEPS);
    assert_eq!((report.pairs, report.contacts, report.dropped), (ALL, ALL, 0));
    let (mut world, _) = plates(&heights, room);
    let (report, sums) = run(&mut world, &mut Serial, STEPS);
    assert_eq!((report.contacts, report.dropped), (ALL / 2, ALL / 2), "half is dropped, and reported");
    assert_eq!(report.pairs, room.0);
    // All came at once, so pair order alone decides which half.
    assert!(pairs_of_contacts(&world) == pairs_of_contacts(&ample)[..ALL as usize / 2]);
    let (mut twin, _) = plates(&heights, room);
    let mut pool = Pool::new(3).expect("threads can be started");
    let (pool_report, pool_sums) = run(&mut twin, &mut pool, STEPS);
    assert_eq!((pool_report, pool_sums), (report, sums), "the same with 3 workers");
    assert!(twin.state() == world.state());
}

#[test]
fn half_of_the_pairs_fit() {
    half_of_the_plates((128 * TILES, 256 * TILES));
}

#[test]
fn half_of_the_contacts_fit() {
    half_of_the_plates((256 * TILES, 128 * TILES));
}

/// Plates rest in the later regions when others arrive in the earlier ones: those that touch keep their room,
/// though pair order would prefer the newcomers, who fall through.
fn touching_before_new(room: (u32, u32)) {
    let heights = [0.4, 0.4, 0.4, 0.4, 0.0, 0.0, 0.0, 0.0];
    let (mut world, regions) = plates(&heights, room);
    let (mut twin, _) = plates(&heights, room);
    for world in [&mut world, &mut twin] {
        // Or what has no contacts would be stopped on its way all the same.
        world.set_settings(&Settings { continuous: false, ..world.settings() }).expect("in range");
    }
    let mut pool = Pool::new(3).expect("threads can be started");
    let mut most_dropped = 0;
    let mut report = StepReport::default();
    for step in 0..90 {
        report = world.step(&mut Serial);
        assert_eq!(twin.step(&mut pool), report);
        assert!(world.state() == twin.state(), "step {step}");
        most_dropped = report.dropped.max(most_dropped);
        let first = 4 * (TILES + 1);
        let pairs = pairs_of_contacts(&world);
        assert_eq!(pairs.len() as u32, 4 * TILES, "step {step}");
        assert!(pairs.iter().all(|pair| pair[0] >= first), "step {step}: a resting plate lost a contact");
    }
    assert_eq!(most_dropped, 4 * TILES);
    assert_eq!(report.dropped, 0, "the newcomers are gone, and nothing more is dropped");
    for region in &regions {
        let height = world.center(region.plate).expect("it exists").to_f64()[2];
        if region.height > 0.0 {
            assert!(height < -1.0, "a plate without contacts falls through: {height}");
        } else {
            assert!((height - 0.1).abs() < 0.02, "a plate with contacts rests: {height}");
        }
    }
}

#[test]
fn touching_pairs_come_before_new_ones() {
    touching_before_new((4 * TILES, 8 * TILES));
}

#[test]
fn touching_contacts_come_before_new_ones() {
    touching_before_new((8 * TILES, 4 * TILES));
}

/// Room that becomes free is given to those that waited for it.
#[test]
fn dropped_pairs_are_found_when_there_is_room() {
    let (mut world, regions) = plates(&[0.0; 4], (2 * TILES, 4 * TILES));
    // The first two touch and have all the room; the other two are held in place.
    for region in &regions[2..] {
        world.set_gravity_scale(region.plate, 0.0).expect("it exists");
    }
    let (report, _) = run(&mut world, &mut Serial, 10);
    assert_eq!((report.contacts, report.dropped), (2 * TILES, 2 * TILES));
    for region in &regions[..2] {
        world.remove_body(region.plate).expect("it exists");
    }
    for region in &regions[2..] {
        world.set_gravity_scale(region.plate, 1.0).expect("it exists");
    }
    let (report, _) = run(&mut world, &mut Serial, 30);
    assert_eq!((report.contacts, report.dropped), (2 * TILES, 0));
    for region in &regions[2..] {
        let height = world.center(region.plate).expect("it exists").to_f64()[2];
        assert!((height - 0.1).abs() < 0.02, "{height}");
    }
}

/// A built-in scene with room for so many pairs and contacts.
fn tight(name: &str, size: u32, (pairs, contacts): (u32, u32)) -> OwnedWorld {
    let mut scene = Builtin::find(name).expect("a built-in scene").scene(size).expect("in range");
    scene.capacities.pairs = Some(pairs);
    scene.capacities.contacts = Some(contacts);
    scene.build(Path::new(".")).expect("built-in scenes build").world
}

/// Piles and levels (meshes have several contacts in a pair) in all kinds of need.
#[test]
fn tight_worlds_give_the_same_bits() {
    let mut pool = Pool::new(3).expect("threads can be started");
    for (name, size) in [("mixed_pile", 120), ("level", 80), ("bowls", 3), ("pyramid", 12)] {
        for room in [(0, 0), (1, 1), (7, 3), (60, 400), (400, 60), (90, 90), (1000, 0)] {
            let [mut world, mut pooled, mut shuffled] = [(); 3].map(|()| tight(name, size, room));
            let mut executor = Shuffled::new(u64::from(room.0));
            let mut dropped = 0;
            for step in 0..100 {
                let report = world.step(&mut Serial);
                assert!(report.pairs <= room.0 && report.contacts <= room.1);
                assert_eq!(pooled.step(&mut pool), report, "{name} with {room:?}, step {step}");
                assert_eq!(shuffled.step(&mut executor), report, "{name} with {room:?}, step {step}");
                dropped += report.dropped;
            }
            assert!(dropped > 0, "{name} with {room:?}");
            assert!(pooled.state() == world.state(), "{name} with {room:?}");
            assert!(shuffled.state() == world.state(), "{name} with {room:?}");
        }
    }
}

/// From the same state, what is there and what is dropped add up to what an ample world has.
#[test]
fn drops_are_counted() {
    for steps in [1, 60, 120] {
        let mut ample = tight("mixed_pile", 120, (4000, 4000));
        worlds::run(&mut ample, steps - 1);
        let positions: Vec<_> = ample.bodies().collect();
        let copy = |room| {
            // Another room is another world: bodies are put where the ample world's are.
            let mut world = tight("mixed_pile", 120, room);
            for &body in &positions {
                let place = ample.position(body).expect("it exists");
                world.set_pose(body, place, ample.rotation(body).expect("it exists")).expect("a pose");
            }
            world
        };
        let all = copy((4000, 4000)).step(&mut Serial);
        assert_eq!(all.dropped, 0);
        for room in [0, 1, all.pairs / 3, all.pairs - 1] {
            let report = copy((room, 4000)).step(&mut Serial);
            assert_eq!((report.pairs, report.dropped), (room, all.pairs - room), "after {steps} steps");
        }
        if all.contacts == 0 {
            continue;
        }
        for room in [0, all.contacts / 3, all.contacts - 1] {
            let report = copy((4000, room)).step(&mut Serial);
            assert_eq!((report.contacts, report.dropped), (room, all.contacts - room), "after {steps} steps");
        }
    }
}

fn assert_full<T: std::fmt::Debug>(outcome: Result<T, Error>, expected: &str) {
    assert!(matches!(outcome, Err(Error::Full { name }) if name == expected), "{outcome:?}");
}

#[test]
fn full_pools_refuse() {
    let mut world = worlds::world_with(Capacities { shapes: 5, ..Capacities::for_bodies(3) });
    let ball = ShapeDef::new(Geometry::Sphere { radius: 0.5 });
    let def = BodyDef::new(BodyKind::Dynamic, Vec3::ZERO);
    let bodies: Vec<_> = (0..3).map(|_| world.create_body(&def).expect("room")).collect();
    let shapes: Vec<_> = (0..5).map(|i| world.create_shape(bodies[i / 2], &ball).expect("room")).collect();
    let state = world.state().to_vec();
    assert_full(world.create_body(&def), "bodies");
    assert_full(world.create_shape(bodies[0], &ball), "shapes");
    assert!(world.state() == state, "a refused creation changes nothing");
    world.remove_shape(shapes[1]).expect("it exists");
    let shape = world.create_shape(bodies[2], &ball).expect("there is room again");
    assert_eq!(shape.index, shapes[1].index, "the lowest free slot is taken");
    assert!(shape.generation != shapes[1].generation && !world.contains_shape(shapes[1]));
    world.remove_body(bodies[1]).expect("it exists");
    let body = world.create_body(&def).expect("there is room again");
    assert_eq!(body.index, bodies[1].index, "the lowest free slot is taken");
    assert!(world.contains_body(body) && !world.contains_body(bodies[1]));
    assert!(!world.contains_shape(shapes[2]), "a body takes its shapes along");
}

#[test]
fn full_assets_refuse() {
    let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(Vec3::from);
    let triangles = [[0, 1, 2], [0, 2, 3]];
    let mut world = simulator::empty_world(CAPACITIES);
    let hash = world.assets_hash();
    assert_full(world.add_hull(&corners), "hulls");
    assert_full(world.add_mesh(&corners, &triangles), "meshes");
    assert_eq!(world.assets_hash(), hash);
    let mut world = simulator::empty_world(Capacities { meshes: 2, ..CAPACITIES });
    assert_full(world.add_mesh(&corners, &triangles), "mesh_vertices");
    let mut world = simulator::empty_world(Capacities { meshes: 2, mesh_vertices: 29, ..CAPACITIES });
    assert_full(world.add_mesh(&corners, &triangles), "mesh_triangles");
    let room = Capacities { meshes: 2, mesh_vertices: 29, mesh_triangles: 34, ..CAPACITIES };
    let mut world = simulator::empty_world(room);
    world.add_mesh(&corners, &triangles).expect("exactly enough room");
    worlds::run(&mut world, 1);
    assert_eq!(world.add_mesh(&corners, &triangles), Err(Error::AssetsSealed));
    assert_eq!(world.add_hull(&corners), Err(Error::AssetsSealed));
}

#[test]
fn capacities_and_memory_are_checked() {
    let out_of_range = |capacities: Capacities, expected: &str| {
        let outcome = World::new(Vec::<Line>::new(), capacities).err();
        assert!(
            matches!(outcome, Some(Error::CapacityOutOfRange { name }) if name == expected),
            "{outcome:?}"
        );
        assert_eq!(cellstep::new_world(capacities).err(), outcome);
    };
    let none = Capacities::for_bodies(0);
    out_of_range(Capacities { bodies: u32::MAX, ..none }, "bodies");
    out_of_range(Capacities { shapes: (1 << 22) + 1, ..none }, "shapes");
    out_of_range(Capacities { pairs: u32::MAX, ..none }, "pairs");
    out_of_range(Capacities { contacts: (1 << 24) + 1, ..none }, "contacts");
    out_of_range(Capacities { hulls: u32::MAX, ..none }, "hulls");
    out_of_range(Capacities { meshes: u32::MAX, ..none }, "meshes");
    out_of_range(Capacities { mesh_vertices: u32::MAX, ..none }, "mesh_vertices");
    out_of_range(Capacities { mesh_triangles: u32::MAX, ..none }, "mesh_triangles");
    out_of_range(Capacities { height_fields: (1 << 16) + 1, ..none }, "height_fields");
    out_of_range(Capacities { height_samples: u32::MAX, ..none }, "height_samples");
    out_of_range(Capacities { compounds: u32::MAX, ..none }, "compounds");
    out_of_range(Capacities { compound_children: (1 << 20) + 1, ..none }, "compound_children");
    out_of_range(Capacities { surfaces: u32::MAX, ..none }, "surfaces");
    out_of_range(Capacities { events: (1 << 20) + 1, ..none }, "events");
    out_of_range(Capacities { sensor_visits: (1 << 20) + 1, ..none }, "sensor_visits");
    let needed = CAPACITIES.lines();
    let outcome = World::new(vec![Line::ZERO; needed - 1], CAPACITIES).err();
    assert_eq!(outcome, Some(Error::MemoryTooSmall { needed, given: needed - 1 }));
    // Memory that somebody used before, and more of it than is needed.
    let more = Memory::zeroed(needed + 3).expect("some megabytes");
    let mut used = World::new(more, CAPACITIES).expect("enough memory");
    worlds::ground(&mut used, 0.5);
    worlds::run(&mut used, 2);
    let again = World::new(used.into_memory(), CAPACITIES).expect("enough memory");
    assert!(again.state() == worlds::world_with(CAPACITIES).state());
}

/// A world without room for anything is still a world.
#[test]
fn no_room_at_all() {
    let mut world = worlds::world_with(Capacities { pairs: 0, contacts: 0, ..Capacities::for_bodies(0) });
    worlds::run(&mut world, 3);
    assert_full(world.create_body(&BodyDef::default()), "bodies");
    assert_eq!((world.steps(), world.body_count()), (3, 0));
    let snapshot = simulator::snapshot(&world);
    assert_eq!(world.load(&snapshot), Ok(()));
}
