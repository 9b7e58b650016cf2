//! One world with all that can lie across borders of sectors or pass them: fast and slow bodies, bullets, joints,
//! meshes, height fields and compounds of many sectors, kinematic bodies, sensors, sleep.
//!
//! The border of interest runs through x = 32 m; a body takes the next sector when its center has passed 33 m.

use cellstep::config::SECTOR_MAX;
use cellstep::math::{Pose, Rotation, Vec3, sin};
use cellstep::{
    Axis, AxisMotion, BodyDef, BodyHandle, BodyKind, BodyKinds, Capacities, CompoundChild, Drive, EventKind,
    Geometry, HeightFieldDef, JointDef, JointHandle, Position, Serial, Settings, ShapeDef, ShapeEvents,
    ShapeHandle,
};
use cellstep_tests::executors::Shuffled;
use cellstep_tests::jointed::{about_y, coordinate, gap};
use cellstep_tests::sectors::{SHIFTS, Shift, assert_same_but_for, moved};
use cellstep_tests::worlds::{OwnedWorld, world_with};

const CAPACITIES: Capacities = Capacities {
    pairs: 2000,
    contacts: 1000,
    joints: 24,
    meshes: 1,
    mesh_vertices: 41 * 41,
    mesh_triangles: 40 * 40 * 2,
    height_fields: 1,
    height_samples: 31 * 31,
    compounds: 2,
    compound_children: 24,
    events: 400,
    sensor_visits: 60,
    ..Capacities::for_bodies(90)
};

/// The world, and who is asked afterwards.
struct Course {
    world: OwnedWorld,
    by: Shift,
    fast: BodyHandle,
    slow: BodyHandle,
    bullets: Vec<BodyHandle>,
    joints: Vec<JointHandle>,
    motor: JointHandle,
    slider: JointHandle,
    stack: Vec<BodyHandle>,
    on_ground: Vec<BodyHandle>,
    pushed: BodyHandle,
    paddle: BodyHandle,
    lift: BodyHandle,
    sensor: ShapeHandle,
}

/// What is counted in a run.
#[derive(Debug, Default, PartialEq)]
struct Tally {
    crossings: usize,
    visits: usize,
    slept: usize,
    woke: usize,
    hits: usize,
    cut: u32,
}

fn ball(radius: f32) -> ShapeDef {
    ShapeDef { events: ShapeEvents::HITS, ..ShapeDef::new(Geometry::Sphere { radius }) }
}

fn cuboid(x: f32, y: f32, z: f32) -> ShapeDef {
    ShapeDef::new(Geometry::Box { half_extents: Vec3::new(x, y, z) })
}

impl Course {
    fn new(by: Shift) -> Self {
        let mut world = world_with(CAPACITIES);
        let settings = Settings {
            sleep_time: 0.4,
            hit_speed: 2.0,
            moved_list: true,
            substeps: 6,
            ..Settings::default()
        };
        world.set_settings(&settings).expect("in range");
        let none = BodyHandle::default();
        let mut course = Self {
            world,
            by,
            fast: none,
            slow: none,
            bullets: Vec::new(),
            joints: Vec::new(),
            motor: JointHandle::default(),
            slider: JointHandle::default(),
            stack: Vec::new(),
            on_ground: Vec::new(),
            pushed: none,
            paddle: none,
            lift: none,
            sensor: ShapeHandle::default(),
        };
        course.add(
            BodyKind::Static,
            [0.0; 3],
            &ShapeDef { friction: 0.6, ..ShapeDef::new(Geometry::HalfSpace) },
        );
        course.grounds();
        course.runners();
        course.shots();
        course.linkage();
        course.pushers();
        course
    }

    fn place(&self, x: [f32; 3]) -> Position {
        moved(Position::at(Vec3::from(x)), self.by)
    }

    fn add(&mut self, kind: BodyKind, x: [f32; 3], shape: &ShapeDef) -> BodyHandle {
        self.thrown(kind, x, shape, Vec3::ZERO)
    }

    fn thrown(&mut self, kind: BodyKind, x: [f32; 3], shape: &ShapeDef, velocity: Vec3) -> BodyHandle {
        let def = BodyDef { kind, position: self.place(x), linear_velocity: velocity, ..BodyDef::default() };
        let body = self.world.create_body(&def).expect("room");
        self.world.create_shape(body, shape).expect("room");
        body
    }

    /// Ground of many sectors, with bodies on it wherever two of them meet.
    fn grounds(&mut self) {
        let height = |x: f32, y: f32| 1.0 + sin(0.05 * x) + sin(0.07 * y);
        let corner = |i: usize, n: usize| ((i % n) as f32 * 10.0 - 200.0, (i / n) as f32 * 10.0 - 200.0);
        let vertices: Vec<Vec3> =
            (0..41 * 41).map(|i| corner(i, 41)).map(|(x, y)| Vec3::new(x, y, height(x, y))).collect();
        let corners = (0..40 * 41_u32).filter(|i| i % 41 != 40);
        let triangles: Vec<[u32; 3]> =
            corners.flat_map(|i| [[i, i + 1, i + 42], [i, i + 42, i + 41]]).collect();
        let mesh = Geometry::Mesh(self.world.add_mesh(&vertices, &triangles).expect("hills"));
        self.add(BodyKind::Static, [0.0, -300.0, 0.0], &ShapeDef::new(mesh));
        let heights: Vec<f32> =
            (0..31 * 31).map(|i| height((i % 31) as f32 * 10.0, (i / 31) as f32 * 10.0)).collect();
        let field = HeightFieldDef {
            columns: 31,
            rows: 31,
            spacing: [10.0, 10.0],
            heights: &heights,
            cells: &[],
            surfaces: &[],
        };
        let field = Geometry::HeightField(self.world.add_height_field(&field).expect("hills"));
        self.add(BodyKind::Static, [-150.0, 100.0, 0.0], &ShapeDef::new(field));
        for x in [-96.0, -32.2, 31.9, 96.0] {
            for y in [-352.1, -287.9, 160.0, 224.3] {
                let body = self.add(BodyKind::Dynamic, [x, y, 3.8], &cuboid(0.5, 0.4, 0.3));
                self.on_ground.push(body);
            }
        }
        // A walkway of 200 m in one shape, and a beam of three parts, 40 m long, that falls across it.
        let part = |x: f32, half: [f32; 3]| CompoundChild {
            geometry: Geometry::Box { half_extents: Vec3::from(half) },
            pose: Pose::new(Vec3::new(x, 0.0, 0.0), Rotation::IDENTITY),
        };
        let planks: Vec<_> = (0..20).map(|i| part(i as f32 * 10.0 - 95.0, [5.0, 2.0, 0.5])).collect();
        let walkway = Geometry::Compound(self.world.add_compound(&planks).expect("planks"));
        self.add(BodyKind::Static, [20.0, 60.0, 0.5], &ShapeDef::new(walkway));
        let parts = [-13.0, 0.0, 13.0].map(|x| part(x, [7.0, 0.3, 0.2]));
        let beam = Geometry::Compound(self.world.add_compound(&parts).expect("a beam"));
        let beam = self.add(BodyKind::Dynamic, [30.0, 60.0, 1.3], &ShapeDef::new(beam));
        self.on_ground.push(beam);
    }

    /// A ball that flies through many sectors, one that creeps over a border, and a wall that stands on it.
    fn runners(&mut self) {
        self.fast =
            self.thrown(BodyKind::Dynamic, [-60.0, 10.0, 20.0], &ball(0.5), Vec3::new(150.0, 0.0, 30.0));
        self.slow = self.thrown(BodyKind::Dynamic, [32.99, 14.0, 0.5], &ball(0.5), Vec3::new(0.01, 0.0, 0.0));
        self.world.set_can_sleep(self.slow, false).expect("alive");
        for row in 0..3 {
            for column in 0..4 {
                let x = 31.0 + column as f32 + 0.5 * (row % 2) as f32;
                let shape = ShapeDef { events: ShapeEvents::ALL, ..cuboid(0.5, 0.5, 0.5) };
                let brick = self.add(BodyKind::Dynamic, [x, 20.0, 0.5 + row as f32], &shape);
                self.stack.push(brick);
            }
        }
        let sensor = ShapeDef { sensor: Some(BodyKinds::DYNAMIC), ..cuboid(1.0, 60.0, 30.0) };
        let gate = self.add(
            BodyKind::Static,
            [32.0, 0.0, 30.0],
            &ShapeDef { density: 0.0, ..cuboid(0.1, 0.1, 0.1) },
        );
        self.sensor = self.world.create_shape(gate, &sensor).expect("room");
    }

    /// Bullets at thin walls that stand behind borders, one of them dynamic, one shot through a corner.
    fn shots(&mut self) {
        for (y, z, kind) in [(-10.0, 1.0, BodyKind::Static), (-14.0, 1.5, BodyKind::Dynamic)] {
            for x in [33.5, 32.0] {
                self.add(kind, [x, y + x - 33.0, z], &cuboid(0.01, 0.2, 1.0));
            }
            for (from, speed) in [(20.0, 400.0), (-80.0, 900.0)] {
                for x in [33.5, 32.0] {
                    let bullet = self.thrown(
                        BodyKind::Dynamic,
                        [from, y + x - 33.0, z],
                        &ball(0.04),
                        Vec3::new(speed, 0.0, 0.0),
                    );
                    self.world.set_bullet(bullet, true).expect("alive");
                    self.bullets.push(bullet);
                }
            }
        }
        self.add(BodyKind::Static, [97.0, -97.0, 40.0], &cuboid(1.5, 1.5, 0.01));
        let way = Vec3::new(200.0, -200.0, 200.0);
        let through = self.thrown(BodyKind::Dynamic, [77.0, -77.0, 20.0], &ball(0.05), way);
        self.world.set_bullet(through, true).expect("alive");
        self.bullets.push(through);
    }

    /// A chain between two posts, a door with a motor whose hinge stands on the border, and a slider over it.
    fn linkage(&mut self) {
        let post = cuboid(0.1, 0.1, 0.1);
        let mut last = self.add(BodyKind::Static, [27.0, 0.0, 8.0], &post);
        let mut end = Vec3::ZERO;
        let link = ShapeDef::new(Geometry::Box { half_extents: Vec3::new(0.4, 0.1, 0.1) });
        let at = |place: Vec3| Pose::new(place, Rotation::IDENTITY);
        for i in 0..10 {
            let next = self.add(BodyKind::Dynamic, [27.5 + i as f32, 0.0, 8.0], &link);
            let def = JointDef::ball([last, next], [at(end), at(Vec3::new(-0.5, 0.0, 0.0))]);
            self.joints.push(self.world.create_joint(&def).expect("room"));
            (last, end) = (next, Vec3::new(0.5, 0.0, 0.0));
        }
        let goal = self.add(BodyKind::Static, [37.0, 0.0, 8.0], &post);
        let def = JointDef::ball([last, goal], [at(end), at(Vec3::ZERO)]);
        self.joints.push(self.world.create_joint(&def).expect("room"));

        let frame = self.add(BodyKind::Static, [32.0, 5.0, 5.0], &post);
        let door = self.add(BodyKind::Dynamic, [33.5, 5.0, 5.0], &cuboid(1.2, 0.1, 0.8));
        let upright = |x: f32| Pose::new(Vec3::new(x, 0.0, 0.0), about_y());
        let mut def = JointDef::hinge([frame, door], [upright(0.0), upright(-1.5)]);
        def.axes[3] = Axis { drive: Some(Drive::motor(2.0, 1.0e5)), ..Axis::FREE };
        self.motor = self.world.create_joint(&def).expect("room");
        self.joints.push(self.motor);
        let rail = self.add(BodyKind::Static, [30.0, 8.0, 5.0], &post);
        let sled = self.add(BodyKind::Dynamic, [30.0, 8.0, 5.0], &cuboid(0.3, 0.3, 0.3));
        let mut def = JointDef::slider([rail, sled], [Pose::IDENTITY; 2]);
        def.axes[0] = Axis {
            motion: AxisMotion::Limited { lower: 0.0, upper: 5.0 },
            drive: Some(Drive::motor(2.0, 1.0e5)),
            ..Axis::FREE
        };
        self.slider = self.world.create_joint(&def).expect("room");
    }

    /// A paddle that pushes a box over the border, and a lift that is told where to go.
    fn pushers(&mut self) {
        let shape = cuboid(0.2, 1.0, 0.5);
        self.paddle = self.thrown(BodyKind::Kinematic, [30.0, 30.0, 0.6], &shape, Vec3::new(2.0, 0.0, 0.0));
        self.pushed = self.add(BodyKind::Dynamic, [30.8, 30.0, 0.5], &cuboid(0.5, 0.5, 0.5));
        self.lift = self.add(BodyKind::Kinematic, [31.0, 36.0, 1.0], &cuboid(2.0, 2.0, 0.2));
        let rider = self.add(BodyKind::Dynamic, [31.0, 36.0, 1.7], &cuboid(0.5, 0.5, 0.5));
        self.on_ground.push(rider);
    }

    /// What a game does before a step.
    fn command(&mut self, step: u32) {
        let along = step as f32 / 60.0;
        let place = self.place([31.0 + 2.0 * along, 36.0, 1.0 + 0.5 * along]);
        self.world.set_kinematic_target(self.lift, place, Rotation::IDENTITY).expect("alive");
        if step == 120 {
            // Something comes down on the sleeping wall; it is taken from three sectors away.
            let place = self.place([32.2, 20.0, 5.0]);
            self.world.set_pose(self.fast, place, Rotation::IDENTITY).expect("alive");
            self.world.set_linear_velocity(self.fast, Vec3::new(0.0, 0.0, -6.0)).expect("alive");
        }
        if step == 60 {
            let place = self.place([33.2, 5.0, 5.1]);
            let door = self.world.joint(self.motor).expect("alive").bodies[1];
            self.world.apply_impulse_at(door, Vec3::new(0.0, 20.0, 0.0), place).expect("alive");
        }
    }

    fn step(&mut self, step: u32, tally: &mut Tally, executor: &mut impl cellstep::Executor) {
        let sectors = |world: &OwnedWorld| -> Vec<_> {
            world.bodies().map(|body| world.center(body).expect("alive").sector).collect()
        };
        self.command(step);
        let before = sectors(&self.world);
        tally.cut += self.world.step(executor).cut;
        let changed = before.iter().zip(sectors(&self.world)).filter(|(from, to)| **from != *to);
        tally.crossings += changed.count();
        for event in self.world.events() {
            match event.kind {
                EventKind::SensorBegan(visit) | EventKind::SensorEnded(visit) => {
                    tally.visits += usize::from(visit.sensor == self.sensor);
                }
                EventKind::Slept(_) => tally.slept += 1,
                EventKind::Woke(_) => tally.woke += 1,
                EventKind::ContactHit(_) => tally.hits += 1,
                _ => {}
            }
        }
    }

    /// Metres from the course's own origin.
    fn at(&self, body: BodyHandle) -> [f64; 3] {
        let place = self.world.position(body).expect("alive");
        moved(place, self.by.map(|sectors| -sectors)).to_f64()
    }
}

const STEPS: u32 = 200;

/// Checks that borders do nothing to the motion.
fn assert_sound(course: &Course, tally: &Tally) {
    assert!(tally.crossings >= 15 && tally.visits >= 8 && tally.hits > 5 && tally.cut > 4, "{tally:?}");
    assert!(tally.slept > 20 && tally.woke > 8, "{tally:?}");
    // It slides at first, then rolls with five sevenths of its speed.
    let (crept, expected) = (course.at(course.slow)[0] - 32.99, 0.01 * 5.0 / 7.0 * f64::from(STEPS) / 60.0);
    assert!((crept - expected).abs() < 3.0e-4, "the slow ball crept {crept} m, not {expected}");
    for (index, &bullet) in course.bullets.iter().enumerate() {
        let [x, _, z] = course.at(bullet);
        let is_stopped = if index < 8 { x < 34.5 } else { z < 40.2 };
        assert!(is_stopped || index >= 4, "bullet {index} went through to {:?}", course.at(bullet));
    }
    for &joint in &course.joints {
        assert!(gap(&course.world, joint) < 2.0e-3, "{joint:?} has a gap of {} m", gap(&course.world, joint));
    }
    let slid = coordinate(&course.world, course.slider, 0);
    assert!((slid - 5.0).abs() < 2.0e-3, "the sled slid {slid} m");
    for &body in &course.on_ground {
        assert!(course.at(body)[2] > 0.0, "{body:?} fell through the ground: {:?}", course.at(body));
    }
    let [x, y, _] = course.at(course.pushed);
    assert!(
        (x - course.at(course.paddle)[0] - 0.7).abs() < 0.1 && (y - 30.0).abs() < 0.2,
        "pushed to {x} {y}"
    );
    let lift = course.at(course.lift)[0];
    assert!((lift - 31.0 - 2.0 * f64::from(STEPS - 1) / 60.0).abs() < 1.0e-3, "the lift is at {lift}");
    assert!(course.world.penetration_max() < 0.02, "{}", course.world.penetration_max());
}

#[test]
fn what_lies_across_borders_or_passes_them_is_the_same_everywhere() {
    // Room for the fastest bullets only.
    let edge = [SECTOR_MAX - 60, 20 - SECTOR_MAX, SECTOR_MAX - 20];
    for (seed, by) in SHIFTS.into_iter().chain([edge]).enumerate() {
        let (mut here, mut there) = (Course::new([0; 3]), Course::new(by));
        let (mut told, mut far) = (Tally::default(), Tally::default());
        let mut shuffled = Shuffled::new(seed as u64);
        for step in 0..STEPS {
            here.step(step, &mut told, &mut Serial);
            there.step(step, &mut far, &mut shuffled);
            if step % 20 == 0 {
                there.world.drop_caches();
            }
            if step % 4 == 3 {
                assert_same_but_for(by, &here.world, &there.world, &format!("step {step}"));
            }
        }
        assert_eq!(told, far);
        assert_sound(&there, &far);
    }
}
