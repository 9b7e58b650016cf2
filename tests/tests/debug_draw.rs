//! What debug drawing draws: lines and points of every kind of shape at the right places.

use cellstep::collide::height_field::HOLE;
use cellstep::debug::{Color, colors};
use cellstep::joint::axis;
use cellstep::math::{PI, Pose, Rotation, Vec3, cos, sin};
use cellstep::{
    Axis, BodyDef, BodyHandle, BodyKind, Capacities, CompoundChild, DebugDraw, DebugLayers, DebugOptions,
    Geometry, HeightFieldDef, HullHandle, JointDef, MeshHandle, Position, Serial, ShapeDef,
};
use cellstep_tests::worlds::{OwnedWorld, add, ground, run, world, world_with};
use cellstep_tests::{mixed, simulator};

/// Keeps everything that is drawn.
#[derive(Default)]
struct Recorder {
    lines: Vec<(Vec3, Vec3, Color)>,
    points: Vec<(Vec3, Color)>,
    texts: Vec<(Vec3, String, Color)>,
}

impl DebugDraw for Recorder {
    fn line(&mut self, from: Vec3, to: Vec3, color: Color) {
        self.lines.push((from, to, color));
    }

    fn point(&mut self, at: Vec3, color: Color) {
        self.points.push((at, color));
    }

    fn text(&mut self, at: Vec3, text: &str, color: Color) {
        self.texts.push((at, text.to_string(), color));
    }
}

fn drawn(world: &OwnedWorld, origin: Position, layers: DebugLayers) -> Recorder {
    let mut recorder = Recorder::default();
    world.debug_draw(origin, &DebugOptions { layers, ..DebugOptions::default() }, &mut recorder);
    recorder
}

/// A world with one shape at a pose of its body.
fn with_shape(kind: BodyKind, geometry: Geometry, (place, rotation): (Vec3, Rotation)) -> OwnedWorld {
    let mut world = simulator::empty_world(simulator::CAPACITIES);
    let def = BodyDef { rotation, ..BodyDef::new(kind, place) };
    add(&mut world, &def, &ShapeDef::new(geometry));
    world
}

fn same(a: Vec3, b: Vec3) -> bool {
    (a - b).length() < 1.0e-5
}

const PLACE: Vec3 = Vec3::new(3.0, -2.0, 5.0);

fn turned() -> Rotation {
    Rotation::from_rotation_vector(Vec3::new(0.4, -1.1, 0.3))
}

#[test]
fn a_box_has_twelve_edges_between_its_corners() {
    let half = Vec3::new(0.5, 1.0, 2.0);
    let world = with_shape(BodyKind::Dynamic, Geometry::Box { half_extents: half }, (PLACE, turned()));
    let origin = Position::at(Vec3::new(1.0, 1.0, 1.0));
    let found = drawn(&world, origin, DebugLayers::SHAPES);
    assert_eq!((found.lines.len(), found.points.len(), found.texts.len()), (12, 0, 0));
    let pose = Pose::new(PLACE - Vec3::ONE, turned());
    let corner = |i: usize| {
        let side = |axis: usize| if i >> axis & 1 == 1 { half[axis] } else { -half[axis] };
        pose.transform(Vec3::new(side(0), side(1), side(2)))
    };
    for i in 0..8 {
        for axis in [1, 2, 4] {
            if i & axis == 0 {
                let (a, b) = (corner(i), corner(i | axis));
                let is_it = |line: &&(Vec3, Vec3, Color)| {
                    (same(line.0, a) && same(line.1, b)) || (same(line.0, b) && same(line.1, a))
                };
                let lines: Vec<_> = found.lines.iter().filter(is_it).collect();
                assert!(lines.len() == 1 && lines[0].2 == colors::DYNAMIC, "edge {a} {b}: {lines:?}");
            }
        }
    }
}

#[test]
fn round_shapes_are_drawn_on_their_surface() {
    let ball = with_shape(BodyKind::Kinematic, Geometry::Sphere { radius: 0.7 }, (PLACE, turned()));
    let found = drawn(&ball, Position::ORIGIN, DebugLayers::SHAPES);
    assert_eq!(found.lines.len(), 72);
    for (a, b, color) in &found.lines {
        assert!(((*a - PLACE).length() - 0.7).abs() < 1.0e-5 && ((*b - PLACE).length() - 0.7).abs() < 1.0e-5);
        assert_eq!(*color, colors::KINEMATIC);
    }
    let geometry = Geometry::Capsule { half_height: 1.0, radius: 0.3 };
    let capsule = with_shape(BodyKind::Dynamic, geometry, (PLACE, turned()));
    let found = drawn(&capsule, Position::ORIGIN, DebugLayers::SHAPES);
    // Two circles of 24, four arches of 12, four lines.
    assert_eq!(found.lines.len(), 2 * 24 + 4 * 12 + 4);
    let pose = Pose::new(PLACE, turned());
    for end in found.lines.iter().flat_map(|line| [line.0, line.1]) {
        let p = pose.untransform(end);
        let on_axis = Vec3::Z * cellstep::math::clamp(p.z, -1.0, 1.0);
        assert!(((p - on_axis).length() - 0.3).abs() < 1.0e-5, "{p}");
    }
    let top = found.lines.iter().map(|line| pose.untransform(line.1).z).fold(0.0, cellstep::math::max);
    assert!((top - 1.3).abs() < 1.0e-5);
}

#[test]
fn hulls_meshes_and_half_spaces_are_drawn_whole() {
    let pose = Pose::new(PLACE, turned());
    let hull = with_shape(BodyKind::Static, Geometry::Hull(HullHandle(0)), (PLACE, turned()));
    let found = drawn(&hull, Position::ORIGIN, DebugLayers::SHAPES);
    let tables = hull.hull(HullHandle(0)).expect("registered");
    assert_eq!(found.lines.len(), 8, "a pyramid has eight edges");
    for (line, edge) in found.lines.iter().zip(tables.edges) {
        assert!(same(line.0, pose.transform(tables.vertices[edge.tail as usize])));
        assert!(same(line.1, pose.transform(tables.vertices[edge.head as usize])));
    }
    let mesh = with_shape(BodyKind::Static, Geometry::Mesh(MeshHandle(0)), (PLACE, turned()));
    let found = drawn(&mesh, Position::ORIGIN, DebugLayers::SHAPES);
    assert_eq!(found.lines.len(), 3 * 32);
    let corners: Vec<Vec3> =
        mesh.mesh(MeshHandle(0)).expect("registered").vertices.iter().map(|&v| pose.transform(v)).collect();
    for end in found.lines.iter().flat_map(|line| [line.0, line.1]) {
        assert!(corners.iter().any(|&corner| same(corner, end)));
    }
    let plane = with_shape(BodyKind::Static, Geometry::HalfSpace, (PLACE, turned()));
    let found = drawn(&plane, Position::ORIGIN, DebugLayers::SHAPES);
    assert_eq!(found.lines.len(), 2 * 11 + 1);
    let normal = turned().rotate(Vec3::Z);
    for line in &found.lines[..22] {
        assert!((line.0 - PLACE).dot(normal).abs() < 1.0e-5 && (line.1 - PLACE).dot(normal).abs() < 1.0e-5);
    }
    assert!(same(found.lines[22].1 - found.lines[22].0, normal));
}

#[test]
fn cylinders_cones_and_rounded_hulls_are_drawn_on_their_surface() {
    let pose = Pose::new(PLACE, turned());
    let geometry = Geometry::Cylinder { half_height: 0.5, radius: 0.3 };
    let cylinder = with_shape(BodyKind::Dynamic, geometry, (PLACE, turned()));
    let found = drawn(&cylinder, Position::ORIGIN, DebugLayers::SHAPES);
    assert_eq!(found.lines.len(), 2 * 24 + 4);
    let across = |p: Vec3| (p.x * p.x + p.y * p.y).sqrt();
    for end in found.lines.iter().flat_map(|line| [line.0, line.1]) {
        let p = pose.untransform(end);
        assert!((across(p) - 0.3).abs() < 1.0e-5 && (p.z.abs() - 0.5).abs() < 1.0e-5, "{p}");
    }
    let geometry = Geometry::Cone { half_height: 0.5, radius: 0.3 };
    let cone = with_shape(BodyKind::Dynamic, geometry, (PLACE, turned()));
    // The origin of a body with a cone is not its center.
    let found = drawn(&cone, Position::ORIGIN, DebugLayers::SHAPES);
    assert_eq!(found.lines.len(), 24 + 4);
    let mut tops = 0;
    for end in found.lines.iter().flat_map(|line| [line.0, line.1]) {
        let p = pose.untransform(end);
        let is_top = same(p, Vec3::Z * 0.5);
        tops += usize::from(is_top);
        let on_rim = (across(p) - 0.3).abs() < 1.0e-5 && (p.z + 0.5).abs() < 1.0e-5;
        assert!(is_top || on_rim, "{p}");
    }
    assert_eq!(tops, 4);
    let geometry = Geometry::RoundedHull { hull: HullHandle(0), radius: 0.2 };
    let rounded = with_shape(BodyKind::Dynamic, geometry, (PLACE, turned()));
    let found = drawn(&rounded, Position::ORIGIN, DebugLayers::SHAPES);
    let tables = rounded.hull(HullHandle(0)).expect("registered");
    assert_eq!(found.lines.len(), 2 * 8, "every edge once for each of its faces");
    for line in &found.lines {
        let ends = [line.0, line.1].map(|end| pose.untransform(end));
        let is_out = |end: &Vec3| {
            let off = |corner: &&Vec3| ((*end - **corner).length() - 0.2).abs() < 1.0e-5;
            tables.vertices.iter().any(|corner| off(&corner))
        };
        let most = |end: &Vec3| {
            tables
                .planes
                .iter()
                .map(|plane| plane.distance(*end))
                .fold(f32::NEG_INFINITY, cellstep::math::max)
        };
        assert!(ends.iter().all(|end| is_out(end) && (most(end) - 0.2).abs() < 1.0e-5), "{ends:?}");
    }
}

#[test]
fn height_fields_and_compounds_are_drawn_part_by_part() {
    let mut world = world_with(mixed::CAPACITIES);
    let heights = [0.0, 0.1, 0.2, 0.3, 0.0, 0.5, 0.1, 0.0, 0.2, 0.1, 0.0, 0.4];
    let cells = [0, HOLE, 0, 0, 0, 0];
    let def = HeightFieldDef {
        columns: 4,
        rows: 3,
        spacing: [1.0, 2.0],
        heights: &heights,
        cells: &cells,
        surfaces: &[],
    };
    let field = world.add_height_field(&def).expect("a field");
    let children = [
        (Geometry::Sphere { radius: 0.5 }, Vec3::X),
        (Geometry::Box { half_extents: Vec3::splat(0.2) }, -Vec3::X),
    ]
    .map(|(geometry, at)| CompoundChild { geometry, pose: Pose::new(at, Rotation::IDENTITY) });
    let compound = world.add_compound(&children).expect("two children");
    let def = BodyDef { rotation: turned(), ..BodyDef::new(BodyKind::Static, PLACE) };
    add(&mut world, &def, &ShapeDef::new(Geometry::HeightField(field)));
    let found = drawn(&world, Position::ORIGIN, DebugLayers::SHAPES);
    assert_eq!(found.lines.len(), 5 * 2 * 3, "five cells and a hole");
    let pose = Pose::new(PLACE, turned());
    for end in found.lines.iter().flat_map(|line| [line.0, line.1]) {
        let is_sample = |i: usize| {
            let sample = Vec3::new((i % 4) as f32, (i / 4) as f32 * 2.0, heights[i]);
            same(end, pose.transform(sample))
        };
        assert!((0..12).any(is_sample), "{end}");
    }
    let def = BodyDef { rotation: turned(), ..BodyDef::new(BodyKind::Dynamic, -PLACE) };
    add(&mut world, &def, &ShapeDef::new(Geometry::Compound(compound)));
    let found = drawn(&world, Position::ORIGIN, DebugLayers::SHAPES);
    let pose = Pose::new(-PLACE, turned());
    let of_compound: Vec<_> = found.lines.iter().filter(|line| line.2 == colors::DYNAMIC).collect();
    assert_eq!(of_compound.len(), 72 + 12);
    let ball = of_compound.iter().filter(|line| {
        let off = |p: Vec3| ((pose.untransform(p) - Vec3::X).length() - 0.5).abs() < 1.0e-5;
        off(line.0) && off(line.1)
    });
    assert_eq!(ball.count(), 72);
}

/// A world with two bodies 2 m apart on the x axis, and frames on them that meet halfway.
fn two_bodies() -> (OwnedWorld, [BodyHandle; 2], [Pose; 2]) {
    let mut world = world_with(Capacities { joints: 4, ..Capacities::for_bodies(8) });
    let body = |world: &mut OwnedWorld, at: Vec3| {
        let shape = ShapeDef::new(Geometry::Box { half_extents: Vec3::splat(0.1) });
        add(world, &BodyDef::new(BodyKind::Dynamic, at), &shape).0
    };
    let bodies = [body(&mut world, Vec3::ZERO), body(&mut world, Vec3::X * 2.0)];
    let frames = [Pose::new(Vec3::X, Rotation::IDENTITY), Pose::new(-Vec3::X, Rotation::IDENTITY)];
    (world, bodies, frames)
}

/// What is drawn of the joints and their limits, with axes of 0.5 m.
fn joints_of(world: &OwnedWorld, origin: Position) -> Vec<(Vec3, Vec3, Color)> {
    let options = DebugOptions {
        layers: DebugLayers::JOINTS.and(DebugLayers::JOINT_LIMITS),
        axis_length: 0.5,
        ..DebugOptions::default()
    };
    let mut found = Recorder::default();
    world.debug_draw(origin, &options, &mut found);
    assert!(found.points.is_empty() && found.texts.is_empty());
    found.lines
}

fn is(line: [Vec3; 2], [a, b]: [Vec3; 2]) -> bool {
    same(line[0], a) && same(line[1], b)
}

#[test]
fn joints_are_drawn_with_their_limits() {
    let (mut world, bodies, frames) = two_bodies();
    let mut hinge = JointDef::hinge(bodies, frames);
    hinge.axes[axis::TURN_X] = Axis::limited(-0.5 * PI, 0.25 * PI);
    world.create_joint(&hinge).expect("room");
    // The second body turns by a sixth of a turn about the hinge, and leaves a gap of 0.1 m.
    let turn = Rotation::from_axis_angle(Vec3::X, -PI / 3.0);
    world.set_pose(bodies[1], Position::at(Vec3::X * 2.1), turn).expect("a good pose");
    let found = joints_of(&world, Position::ORIGIN);
    let of = |color: Color| found.iter().filter(move |line| line.2 == color).map(|line| [line.0, line.1]);
    let (near, far) = (Vec3::X, Vec3::X * 1.1);
    let own: Vec<_> = of(colors::JOINT).collect();
    let hand = far + turn.rotate(Vec3::Y) * 0.5;
    for expected in [[Vec3::ZERO, near], [Vec3::X * 2.1, far], [far, hand]] {
        assert!(own.iter().any(|&line| is(line, expected)), "{expected:?} {own:?}");
    }
    assert_eq!(own.len(), 3);
    assert!(of(colors::JOINT_GAP).all(|line| is(line, [near, far])));
    assert_eq!(of(colors::JOINT_GAP).count(), 1);
    for (axis, color) in [Vec3::X, Vec3::Y, Vec3::Z].into_iter().zip(colors::AXES) {
        assert!(of(color).any(|line| is(line, [near, near + axis * 0.5])));
        assert!(of(color).any(|line| is(line, [far, far + turn.rotate(axis) * 0.5])));
    }
    // Three quarters of a half circle, and its ends: at -90 and 45 degrees from the y axis of the first body.
    let limits: Vec<_> = of(colors::JOINT_LIMIT).collect();
    assert_eq!(limits.len(), 9 + 2);
    assert!(limits.iter().all(|line| line.iter().all(|end| (end.x - 1.1).abs() < 1.0e-5)));
    let ends = [-0.5 * PI, 0.25 * PI].map(|turn| Vec3::new(0.0, cos(turn), sin(turn)) * 0.5);
    assert!(ends.iter().all(|&end| limits.iter().any(|&line| is(line, [far, far + end]))));
}

#[test]
fn limits_of_ropes_sliders_and_cones_are_drawn() {
    let (mut world, bodies, frames) = two_bodies();
    let near = Vec3::X;
    let rope = JointDef::distance(bodies, [Vec3::ZERO, Vec3::ZERO], 0.5, 3.0);
    let rope = world.create_joint(&rope).expect("room");
    let limit = |world: &OwnedWorld| {
        let lines = joints_of(world, Position::ORIGIN).into_iter();
        let limits = lines.filter(|line| line.2 == colors::JOINT_LIMIT);
        limits.map(|line| [line.0, line.1]).collect::<Vec<_>>()
    };
    let found = limit(&world);
    assert!(found.len() == 1 && is(found[0], [Vec3::X * 0.5, Vec3::X * 3.0]), "{found:?}");
    world.remove_joint(rope).expect("lives");
    let mut slider = JointDef::slider(bodies, frames);
    slider.axes[axis::X] = Axis::limited(-0.25, 0.75);
    let slider = world.create_joint(&slider).expect("room");
    let found = limit(&world);
    assert!(found.len() == 1 && is(found[0], [near - Vec3::X * 0.25, near + Vec3::X * 0.75]), "{found:?}");
    world.remove_joint(slider).expect("lives");
    let ball = JointDef { cone: Some(0.5), ..JointDef::ball(bodies, frames) };
    world.create_joint(&ball).expect("room");
    let found = limit(&world);
    assert_eq!(found.len(), 24 + 4);
    for end in found.iter().flatten().filter(|end| !same(**end, near)) {
        let from = *end - near;
        assert!((from.length() - 0.5).abs() < 1.0e-5 && (from.x - 0.5 * cos(0.5)).abs() < 1.0e-5, "{end}");
    }
    assert!(joints_of(&world, Position::at(Vec3::X * 5.0e3)).is_empty(), "out of reach");
}

#[test]
fn what_is_out_of_reach_is_left_out() {
    let geometry = Geometry::Box { half_extents: Vec3::ONE };
    let world = with_shape(BodyKind::Dynamic, geometry, (Vec3::new(40.0, 0.0, 0.0), Rotation::IDENTITY));
    for (reach, lines) in [(30.0, 0), (38.5, 0), (39.5, 12), (41.0, 15)] {
        let mut recorder = Recorder::default();
        let layers = DebugLayers::SHAPES.and(DebugLayers::AXES);
        let options = DebugOptions { layers, reach, ..DebugOptions::default() };
        world.debug_draw(Position::ORIGIN, &options, &mut recorder);
        assert_eq!(recorder.lines.len(), lines, "{reach}");
    }
}

#[test]
fn contacts_and_their_impulses_are_drawn() {
    let mut world = world(2);
    ground(&mut world, 0.5);
    let shape = ShapeDef::new(Geometry::Box { half_extents: Vec3::splat(0.5) });
    let (body, _) = add(&mut world, &BodyDef::new(BodyKind::Dynamic, Vec3::new(2.0, 0.0, 0.5)), &shape);
    run(&mut world, 120);
    let weight = 1000.0 * 9.81;
    let substep = world.settings().substep();
    let options = DebugOptions {
        layers: DebugLayers::ALL,
        impulse_scale: 1.0 / (weight * substep),
        axis_length: 0.125,
        ..DebugOptions::default()
    };
    let mut found = Recorder::default();
    world.debug_draw(Position::ORIGIN, &options, &mut found);
    let of = |color: Color| found.lines.iter().filter(move |line| line.2 == color);
    let normals: Vec<_> = of(colors::NORMAL).collect();
    assert_eq!(normals.len(), 4);
    assert!(normals.iter().all(|line| same(line.1 - line.0, Vec3::Z * 0.125)));
    // The ground has the lower slot: impulses act on the box, upwards, and carry its weight.
    let impulse: Vec<_> = of(colors::IMPULSE).collect();
    assert_eq!(impulse.len(), 1);
    assert!((impulse[0].1 - impulse[0].0 - Vec3::Z).length() < 0.01, "{impulse:?}");
    assert!((impulse[0].0 - Vec3::new(2.0, 0.0, 0.0)).length() < 0.02, "{impulse:?}");
    assert_eq!(of(colors::FRICTION).count(), 1);
    let points = found.points.iter().filter(|point| point.1 != colors::CENTER);
    assert_eq!(points.count(), 4);
    let center = world.center(body).expect("alive").offset;
    assert!(found.points.contains(&(center, colors::CENTER)));
    // One box of the broadphase: the half-space's has no end.
    assert_eq!(of(colors::FAT_BOX).count(), 12);
    let fat =
        of(colors::FAT_BOX).map(|line| (line.0 - center).abs().max_element()).fold(0.0, cellstep::math::max);
    assert!(fat > 0.51 && fat < 0.7, "{fat}");
    for (axis, color) in [Vec3::X, Vec3::Y, Vec3::Z].into_iter().zip(colors::AXES) {
        // Of the ground and of the box.
        assert_eq!(of(color).count(), 2);
        assert!(of(color).all(|line| (line.1 - line.0 - axis * 0.125).length() < 1.0e-3));
    }
    let texts: Vec<&str> = found.texts.iter().map(|text| text.1.as_str()).collect();
    assert_eq!(texts[..2], ["0", "1: 1000 kg"]);
    assert!(texts.len() == 3 && texts[2].ends_with(" N s"), "{texts:?}");
}

#[test]
fn drawing_is_as_fine_far_away_and_changes_nothing() {
    let far = Position::from_f64([1.0e7 + 0.5, -1.0e7, 3.0]);
    let mut world = world(2);
    let def = BodyDef { position: far, rotation: turned(), ..BodyDef::default() };
    add(&mut world, &def, &ShapeDef::new(Geometry::Box { half_extents: Vec3::splat(0.5) }));
    let before = world.checksum();
    let near = drawn(&world, Position { offset: far.offset + Vec3::X, ..far }, DebugLayers::ALL);
    assert_eq!(world.checksum(), before);
    let pose = Pose::new(-Vec3::X, turned());
    let corner = pose.transform(Vec3::splat(0.5));
    assert!(near.lines.iter().any(|line| same(line.0, corner) || same(line.1, corner)));
    world.step(&mut Serial);
    assert!(drawn(&world, far, DebugLayers::NONE).lines.is_empty());
}

#[test]
fn sensors_have_a_color_of_their_own() {
    let mut world = world_with(Capacities { shapes: 2, sensor_visits: 4, ..Capacities::for_bodies(1) });
    let body = BodyDef::new(BodyKind::Dynamic, PLACE);
    let (body, _) = add(&mut world, &body, &ShapeDef::new(Geometry::Box { half_extents: Vec3::ONE }));
    world
        .create_shape(body, &ShapeDef::sensor(Geometry::Box { half_extents: Vec3::ONE * 2.0 }))
        .expect("room");
    let lines = drawn(&world, Position::ORIGIN, DebugLayers::SHAPES).lines;
    assert_eq!(lines.len(), 24);
    for (from, _, color) in lines {
        let is_outer = (from - PLACE).length() > 2.0;
        assert_eq!(color, if is_outer { colors::SENSOR } else { colors::DYNAMIC });
    }
}
