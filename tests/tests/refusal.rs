//! Every number that the public API takes is refused with a typed error when it is not finite, and the world stays
//! as it was, byte for byte.
//!
//! Each case below is a call with good numbers, every one of them passed through a [`Poison`]. The harness makes
//! the call once as it is (it must succeed), and then once for each number and each of NaN, +inf and -inf.

use cellstep::math::{Pose, Rotation, Vec3};
use cellstep::{Axis as JointAxis, Drive, JointDef, JointHandle, MaterialTraits, PairMaterial, Spring};
use cellstep::{
    AxisLocks, BodyDef, BodyHandle, BodyKind, Capacities, CompoundChild, CompoundHandle, Error, Filter,
    Geometry, HeightFieldDef, HeightFieldHandle, HullHandle, MassProperties, MeshHandle, Position, Serial,
    Settings, ShapeDef, ShapeHandle, Surface,
};
use cellstep_tests::simulator::{CAPACITIES, Simulator};
use cellstep_tests::worlds::{self, OwnedWorld};
use std::collections::BTreeSet;

/// Replaces one of the numbers that go through it.
struct Poison {
    /// Which number.
    target: usize,
    bad: f32,
    /// Numbers seen so far.
    seen: usize,
}

impl Poison {
    fn number(&mut self, good: f32) -> f32 {
        self.seen += 1;
        if self.seen - 1 == self.target { self.bad } else { good }
    }

    fn vector(&mut self, x: f32, y: f32, z: f32) -> Vec3 {
        Vec3::new(self.number(x), self.number(y), self.number(z))
    }

    fn position(&mut self) -> Position {
        Position { sector: [0, 0, 1], offset: self.vector(1.0, 2.0, 3.0) }
    }

    fn rotation(&mut self) -> Rotation {
        Rotation::new(self.number(0.0), self.number(0.6), self.number(0.0), self.number(0.8))
    }

    fn pose(&mut self) -> Pose {
        Pose::new(self.vector(0.1, 0.2, 0.3), self.rotation())
    }

    fn mass(&mut self) -> MassProperties {
        MassProperties {
            mass: self.number(2.0),
            center: self.vector(0.1, 0.0, 0.0),
            inertia: self.vector(1.0, 1.2, 1.4),
            axes: self.rotation(),
        }
    }

    fn body_def(&mut self, mass: bool) -> BodyDef {
        BodyDef {
            kind: BodyKind::Dynamic,
            position: self.position(),
            rotation: self.rotation(),
            linear_velocity: self.vector(1.0, 0.0, 0.0),
            angular_velocity: self.vector(0.0, 1.0, 0.0),
            linear_damping: self.number(0.1),
            angular_damping: self.number(0.1),
            gravity_scale: self.number(1.0),
            locks: AxisLocks::NONE,
            can_sleep: true,
            bullet: false,
            mass: mass.then(|| self.mass()),
            user: 0,
        }
    }

    fn geometry(&mut self, kind: usize) -> Geometry {
        match kind {
            0 => Geometry::Sphere { radius: self.number(0.5) },
            1 => Geometry::Capsule { half_height: self.number(0.5), radius: self.number(0.2) },
            2 => Geometry::Box { half_extents: self.vector(0.5, 0.4, 0.3) },
            3 => Geometry::Hull(HullHandle(0)),
            4 => Geometry::Cylinder { half_height: self.number(0.3), radius: self.number(0.4) },
            5 => Geometry::Cone { half_height: self.number(0.3), radius: self.number(0.4) },
            6 => Geometry::RoundedHull { hull: HullHandle(0), radius: self.number(0.1) },
            _ => Geometry::Compound(CompoundHandle(0)),
        }
    }

    fn children(&mut self) -> [CompoundChild; 2] {
        [4, 6].map(|kind| CompoundChild { geometry: self.geometry(kind), pose: self.pose() })
    }

    fn surface(&mut self) -> Surface {
        Surface { friction: self.number(0.3), restitution: self.number(0.1) }
    }

    fn add_height_field(&mut self, world: &mut OwnedWorld) -> Result<(), Error> {
        let heights: [f32; 9] = core::array::from_fn(|i| self.number(0.1 * i as f32));
        let def = HeightFieldDef {
            columns: 3,
            rows: 3,
            spacing: [self.number(1.0), self.number(2.0)],
            heights: &heights,
            cells: &[],
            surfaces: &[self.surface()],
        };
        world.add_height_field(&def).map(drop)
    }

    fn shape_def(&mut self, geometry: usize) -> ShapeDef {
        ShapeDef {
            geometry: self.geometry(geometry),
            pose: self.pose(),
            density: self.number(100.0),
            friction: self.number(0.5),
            restitution: self.number(0.1),
            traits: self.traits(),
            filter: Filter::default(),
            ..ShapeDef::new(Geometry::HalfSpace)
        }
    }

    fn traits(&mut self) -> MaterialTraits {
        MaterialTraits {
            rolling: self.number(0.1),
            spinning: self.number(0.2),
            surface_velocity: self.vector(1.0, 2.0, 0.0),
            one_way: Some(self.vector(0.0, 0.0, 1.0)),
            ..MaterialTraits::default()
        }
    }

    /// A joint in which every number is finite: bounds that may be infinite are left as they are.
    fn joint_def(&mut self, bodies: [BodyHandle; 2]) -> JointDef {
        let mut def = JointDef::six_axis(bodies, [self.pose(), self.pose()]);
        let spring = Spring::Frequency { hertz: self.number(3.0), damping_ratio: self.number(0.5) };
        let stiff = Spring::Stiffness { stiffness: self.number(30.0), damping: self.number(2.0) };
        def.axes[0] = JointAxis {
            limit_spring: Some(stiff),
            drive: Some(self.drive(Some(spring))),
            friction: self.number(0.2),
            ..JointAxis::limited(-1.0, 1.0)
        };
        def.cone = Some(self.number(0.5));
        def.spring = Some(stiff);
        def
    }

    fn drive(&mut self, spring: Option<Spring>) -> Drive {
        Drive { target: self.number(0.1), velocity: self.number(0.2), spring, max_force: 10.0 }
    }

    fn settings(&mut self) -> Settings {
        Settings {
            dt: self.number(0.01),
            gravity: self.vector(0.0, 0.0, -9.0),
            contact_frequency: self.number(30.0),
            contact_damping_ratio: self.number(5.0),
            push_speed: self.number(2.0),
            restitution_threshold: self.number(0.7),
            hit_speed: self.number(1.0),
            ..Settings::default()
        }
    }

    fn hull(&mut self) -> Vec<Vec3> {
        let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.2, 0.2, 0.2]];
        corners.iter().map(|&[x, y, z]| self.vector(x, y, z)).collect()
    }

    fn mesh(&mut self) -> Vec<Vec3> {
        let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.2], [0.0, 1.0, 0.0], [5.0, 5.0, 5.0]];
        corners.iter().map(|&[x, y, z]| self.vector(x, y, z)).collect()
    }
}

/// What the cases work on.
struct Fixture {
    world: OwnedWorld,
    body: BodyHandle,
    kinematic: BodyHandle,
    shape: ShapeHandle,
    other_shape: ShapeHandle,
    joint: JointHandle,
}

impl Fixture {
    /// A box in the air, a kinematic ball, ground, a hull and a mesh; before the first step, or a little later.
    fn new(stepped: bool) -> Self {
        let capacities = Capacities {
            hulls: 2,
            meshes: 2,
            mesh_vertices: 16,
            mesh_triangles: 16,
            joints: 4,
            height_fields: 2,
            height_samples: 18,
            compounds: 2,
            compound_children: 4,
            surfaces: 4,
            materials: 1,
            pair_rules: 1,
            ..Capacities::for_bodies(8)
        };
        let mut world = worlds::world_with(capacities);
        let mut none = Poison { target: usize::MAX, bad: 0.0, seen: 0 };
        world.add_hull(&none.hull()).expect("a hull");
        world.add_mesh(&none.mesh(), &TRIANGLES).expect("a mesh");
        none.add_height_field(&mut world).expect("a height field");
        world.add_compound(&none.children()).expect("a compound");
        worlds::ground(&mut world, 0.5);
        let def = BodyDef::new(BodyKind::Dynamic, Vec3::new(0.0, 0.0, 0.5));
        let cube = ShapeDef::new(Geometry::Box { half_extents: Vec3::splat(0.5) });
        let (body, shape) = worlds::add(&mut world, &def, &cube);
        let def = BodyDef::new(BodyKind::Kinematic, Vec3::new(0.0, 0.0, 3.0));
        let ball = ShapeDef::new(Geometry::Sphere { radius: 0.5 });
        let (kinematic, other_shape) = worlds::add(&mut world, &def, &ball);
        let joint = JointDef::ball(
            [body, kinematic],
            [Pose::IDENTITY, Pose::new(Vec3::new(0.0, 0.0, -2.5), Rotation::IDENTITY)],
        );
        let joint = world.create_joint(&joint).expect("room");
        if stepped {
            worlds::run(&mut world, 10);
        }
        Self { world, body, kinematic, shape, other_shape, joint }
    }
}

const TRIANGLES: [[u32; 3]; 2] = [[0, 1, 2], [0, 2, 3]];

/// A method of `World`, and a call of it.
type Case = (&'static str, fn(&mut Fixture, &mut Poison) -> Result<(), Error>);

/// Every public method that takes numbers; those that take one of several things, once for each.
const CASES: &[Case] = &[
    ("set_settings", |f, p| f.world.set_settings(&p.settings())),
    ("create_body", |f, p| f.world.create_body(&p.body_def(false)).map(drop)),
    ("create_body", |f, p| f.world.create_body(&p.body_def(true)).map(drop)),
    ("create_body", |f, p| {
        let place = Position::at(p.vector(1.0, 100.0, 3.0));
        f.world.create_body(&BodyDef { position: place, ..BodyDef::default() }).map(drop)
    }),
    ("create_body", |f, p| {
        let place = Position::from_f64(p.vector(1.0, 100.0, 3.0).to_array().map(f64::from));
        f.world.create_body(&BodyDef { position: place, ..BodyDef::default() }).map(drop)
    }),
    ("create_body", |f, p| {
        f.world.create_body(&BodyDef::new(BodyKind::Static, p.vector(1.0, 2.0, 3.0))).map(drop)
    }),
    ("create_shape", |f, p| f.world.create_shape(f.body, &p.shape_def(0)).map(drop)),
    ("create_shape", |f, p| f.world.create_shape(f.body, &p.shape_def(1)).map(drop)),
    ("create_shape", |f, p| f.world.create_shape(f.body, &p.shape_def(2)).map(drop)),
    ("create_shape", |f, p| f.world.create_shape(f.body, &p.shape_def(3)).map(drop)),
    ("create_shape", |f, p| f.world.create_shape(f.body, &p.shape_def(4)).map(drop)),
    ("create_shape", |f, p| f.world.create_shape(f.body, &p.shape_def(5)).map(drop)),
    ("create_shape", |f, p| f.world.create_shape(f.body, &p.shape_def(6)).map(drop)),
    ("create_shape", |f, p| f.world.create_shape(f.body, &p.shape_def(7)).map(drop)),
    ("create_shape", |f, p| {
        let def = ShapeDef { geometry: Geometry::HeightField(HeightFieldHandle(0)), ..p.shape_def(3) };
        f.world.create_shape(f.kinematic, &def).map(drop)
    }),
    ("create_shape", |f, p| {
        let def = ShapeDef { geometry: Geometry::Mesh(MeshHandle(0)), ..p.shape_def(3) };
        f.world.create_shape(f.kinematic, &def).map(drop)
    }),
    ("create_shape", |f, p| {
        let def = ShapeDef { geometry: Geometry::HalfSpace, ..p.shape_def(3) };
        f.world.create_shape(f.kinematic, &def).map(drop)
    }),
    ("set_pose", |f, p| f.world.set_pose(f.body, p.position(), p.rotation())),
    ("set_linear_velocity", |f, p| f.world.set_linear_velocity(f.body, p.vector(1.0, 2.0, 3.0))),
    ("set_linear_velocity", |f, p| f.world.set_linear_velocity(f.kinematic, p.vector(1.0, 2.0, 3.0))),
    ("set_angular_velocity", |f, p| f.world.set_angular_velocity(f.body, p.vector(1.0, 2.0, 3.0))),
    ("set_angular_velocity", |f, p| f.world.set_angular_velocity(f.kinematic, p.vector(1.0, 2.0, 3.0))),
    ("set_kinematic_target", |f, p| f.world.set_kinematic_target(f.kinematic, p.position(), p.rotation())),
    ("set_mass", |f, p| f.world.set_mass(f.body, Some(&p.mass()))),
    ("set_damping", |f, p| f.world.set_damping(f.body, p.number(0.1), p.number(0.2))),
    ("set_gravity_scale", |f, p| f.world.set_gravity_scale(f.body, p.number(0.5))),
    ("apply_force", |f, p| f.world.apply_force(f.body, p.vector(1.0, 2.0, 3.0))),
    ("apply_force_at", |f, p| f.world.apply_force_at(f.body, p.vector(1.0, 2.0, 3.0), p.position())),
    ("apply_torque", |f, p| f.world.apply_torque(f.body, p.vector(1.0, 2.0, 3.0))),
    ("apply_impulse", |f, p| f.world.apply_impulse(f.body, p.vector(1.0, 2.0, 3.0))),
    ("apply_impulse_at", |f, p| f.world.apply_impulse_at(f.body, p.vector(1.0, 2.0, 3.0), p.position())),
    ("apply_angular_impulse", |f, p| f.world.apply_angular_impulse(f.body, p.vector(1.0, 2.0, 3.0))),
    ("set_geometry", |f, p| f.world.set_geometry(f.shape, &p.geometry(0), &p.pose())),
    ("set_geometry", |f, p| f.world.set_geometry(f.shape, &p.geometry(1), &p.pose())),
    ("set_geometry", |f, p| f.world.set_geometry(f.shape, &p.geometry(2), &p.pose())),
    ("set_geometry", |f, p| f.world.set_geometry(f.shape, &p.geometry(3), &p.pose())),
    ("set_geometry", |f, p| f.world.set_geometry(f.shape, &p.geometry(4), &p.pose())),
    ("set_geometry", |f, p| f.world.set_geometry(f.shape, &p.geometry(5), &p.pose())),
    ("set_geometry", |f, p| f.world.set_geometry(f.shape, &p.geometry(6), &p.pose())),
    ("create_joint", |f, p| f.world.create_joint(&p.joint_def([f.body, f.kinematic])).map(drop)),
    ("create_joint", |f, p| {
        let bodies = [f.body, f.kinematic];
        f.world.create_joint(&JointDef::gear(bodies, [p.pose(), p.pose()], p.number(2.0))).map(drop)
    }),
    ("set_joint", |f, p| f.world.set_joint(f.joint, &p.joint_def([f.body, f.kinematic]))),
    ("set_joint_axis", |f, p| {
        let axis = JointAxis { drive: Some(p.drive(None)), friction: p.number(0.1), ..JointAxis::FREE };
        f.world.set_joint_axis(f.joint, 3, &axis)
    }),
    ("set_density", |f, p| f.world.set_density(f.shape, p.number(10.0))),
    ("set_material", |f, p| f.world.set_material(f.shape, p.number(0.1), p.number(0.2))),
    ("set_material_traits", |f, p| f.world.set_material_traits(f.shape, &p.traits())),
    ("set_pair_material", |f, p| {
        let material = PairMaterial { friction: Some(p.number(0.1)), restitution: Some(p.number(0.2)) };
        f.world.set_pair_material(f.shape, f.other_shape, &material)
    }),
];

/// Assets are registered before the first step.
const ASSET_CASES: &[Case] = &[
    ("add_hull", |f, p| f.world.add_hull(&p.hull()).map(drop)),
    ("add_mesh", |f, p| f.world.add_mesh(&p.mesh(), &TRIANGLES).map(drop)),
    ("add_mesh_with_surfaces", |f, p| {
        let surfaces = [p.surface(), p.surface()];
        f.world.add_mesh_with_surfaces(&p.mesh(), &TRIANGLES, (&[0, 1], &surfaces)).map(drop)
    }),
    ("add_height_field", |f, p| p.add_height_field(&mut f.world)),
    ("add_compound", |f, p| f.world.add_compound(&p.children()).map(drop)),
];

/// Public methods that change a world and take no number.
const WITHOUT_NUMBERS: &[&str] = &[
    "set_shape_events",
    "apply",
    "step",
    "step_scheduled",
    "step_observed",
    "drop_caches",
    "remove_body",
    "remove_shape",
    "remove_joint",
    "set_joint_user",
    "wake",
    "set_can_sleep",
    "set_bullet",
    "queries",
    "set_kind",
    "set_locks",
    "set_body_user",
    "set_shape_user",
    "set_filter",
    "ignore_until_separated",
    "stop_ignoring",
    "restore",
    "load",
];

fn is_typed(error: &Error) -> bool {
    use cellstep::collide::compound::CompoundError;
    use cellstep::collide::height_field::HeightFieldError;
    use cellstep::collide::{hull::HullError, mesh::MeshError};
    matches!(
        error,
        Error::NotFinite { .. }
            | Error::Hull(HullError::NotFinite { .. })
            | Error::Mesh(MeshError::NotFinite { .. })
            | Error::HeightField(HeightFieldError::Height { .. } | HeightFieldError::Spacing)
            | Error::Compound(CompoundError::OutOfRange { .. })
            | Error::Surface { .. }
    )
}

/// Checks one case in all ways; returns how many numbers it takes.
fn check(&(name, call): &Case, stepped: bool) -> usize {
    let mut good = Poison { target: usize::MAX, bad: 0.0, seen: 0 };
    assert_eq!(call(&mut Fixture::new(stepped), &mut good), Ok(()), "{name} with good numbers");
    let mut fixture = Fixture::new(stepped);
    let (checksum, state) = (fixture.world.checksum(), fixture.world.state().to_vec());
    let assets = fixture.world.assets_hash();
    for target in 0..good.seen {
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            let error = call(&mut fixture, &mut Poison { target, bad, seen: 0 }).err();
            let typed = error.as_ref().is_some_and(is_typed);
            assert!(typed, "{name}: number {target} as {bad} gives {error:?}");
            assert_eq!(fixture.world.checksum(), checksum, "{name}: number {target} as {bad}");
            assert!(fixture.world.state() == state, "{name}: number {target} as {bad}");
            assert_eq!(fixture.world.assets_hash(), assets, "{name}: number {target} as {bad}");
        }
    }
    // The refused calls left nothing behind, in caches or above marks, that a later step would find.
    let mut untouched = Fixture::new(stepped);
    for world in [&mut fixture.world, &mut untouched.world] {
        worlds::run(world, 3);
    }
    assert!(fixture.world.state() == untouched.world.state(), "{name}: another state three steps later");
    good.seen
}

#[test]
fn numbers_that_are_not_finite_are_refused() {
    let mut numbers = 0;
    for case in CASES {
        numbers += check(case, false);
        check(case, true);
    }
    assert!(numbers > 200, "{numbers} numbers");
}

#[test]
fn assets_that_are_not_finite_are_refused() {
    for case in ASSET_CASES {
        assert!(check(case, false) >= 13);
    }
}

/// After refused assets the same ones get the same places, and give the same worlds.
#[test]
fn refused_assets_leave_no_trace() {
    let mut none = Poison { target: usize::MAX, bad: 0.0, seen: 0 };
    let (mut refused, mut plain) = (Fixture::new(false), Fixture::new(false));
    let mut bad = Poison { target: 7, bad: f32::NAN, seen: 0 };
    assert!(refused.world.add_mesh(&bad.mesh(), &TRIANGLES).is_err());
    assert!(refused.world.add_mesh(&none.mesh(), &[[0, 1, 2], [0, 1, 9]]).is_err());
    assert!(refused.world.add_hull(&[Vec3::ZERO; 8]).is_err());
    bad.seen = 0;
    assert!(bad.add_height_field(&mut refused.world).is_err());
    bad.seen = 0;
    assert!(refused.world.add_compound(&bad.children()).is_err());
    let surfaces = [Surface { friction: 0.5, restitution: 0.0 }; 9];
    assert!(refused.world.add_mesh_with_surfaces(&none.mesh(), &TRIANGLES, (&[0, 1], &surfaces)).is_err());
    for fixture in [&mut refused, &mut plain] {
        let mesh = fixture.world.add_mesh(&none.mesh(), &TRIANGLES).expect("a mesh");
        let hull = fixture.world.add_hull(&none.hull()).expect("a hull");
        assert_eq!((mesh, hull), (MeshHandle(1), HullHandle(1)));
        none.add_height_field(&mut fixture.world).expect("a height field");
        fixture.world.add_compound(&none.children()).expect("a compound");
        let terrain = fixture.world.create_body(&BodyDef::new(BodyKind::Static, Vec3::ZERO)).expect("room");
        fixture.world.create_shape(terrain, &ShapeDef::new(Geometry::Mesh(mesh))).expect("room");
        worlds::run(&mut fixture.world, 30);
    }
    assert_eq!(refused.world.assets_hash(), plain.world.assets_hash());
    assert!(refused.world.state() == plain.world.state());
}

/// Handles that name nothing, and calls that a body's kind forbids, change nothing either.
#[test]
fn stale_handles_and_wrong_kinds_are_refused() {
    for stepped in [false, true] {
        let mut f = Fixture::new(stepped);
        let (body, shape, other_shape) = (f.body, f.shape, f.other_shape);
        f.world.remove_body(body).expect("it exists");
        let ground = f.world.bodies().next().expect("the ground");
        let state = f.world.state().to_vec();
        for (name, call) in CASES {
            let mut none = Poison { target: usize::MAX, bad: 0.0, seen: 0 };
            let mut stale =
                Fixture { world: f.world, body, kinematic: body, shape, other_shape, joint: f.joint };
            let outcome = call(&mut stale, &mut none);
            f.world = stale.world;
            if matches!(*name, "create_body" | "set_settings") {
                f = Fixture::new(stepped);
                f.world.remove_body(body).expect("it exists");
                continue;
            }
            assert!(matches!(outcome, Err(Error::Stale { .. })), "{name}: {outcome:?}");
            assert!(f.world.state() == state, "{name}");
        }
        let wrong = |outcome: Result<(), Error>| {
            assert!(matches!(outcome, Err(Error::WrongKind { .. })), "{outcome:?}")
        };
        wrong(f.world.set_linear_velocity(ground, Vec3::ONE));
        wrong(f.world.set_angular_velocity(ground, Vec3::ONE));
        wrong(f.world.apply_force(ground, Vec3::ONE));
        wrong(f.world.apply_force_at(ground, Vec3::ONE, Position::ORIGIN));
        wrong(f.world.apply_torque(f.kinematic, Vec3::ONE));
        wrong(f.world.apply_impulse(f.kinematic, Vec3::ONE));
        wrong(f.world.apply_impulse_at(ground, Vec3::ONE, Position::ORIGIN));
        wrong(f.world.apply_angular_impulse(ground, Vec3::ONE));
        wrong(f.world.set_kinematic_target(ground, Position::ORIGIN, Rotation::IDENTITY));
        wrong(f.world.set_kind(ground, BodyKind::Dynamic));
        assert!(f.world.state() == state);
    }
}

/// Whatever a player tries: a refused command changes nothing.
#[test]
fn refused_commands_change_nothing() {
    let mut refused = 0;
    for seed in 0..40 {
        let (mut simulator, mut world) = Simulator::new(seed, CAPACITIES);
        let (_, mut twin) = Simulator::new(seed, CAPACITIES);
        for _ in 0..100 {
            for (command, outcome) in simulator.play(&mut world) {
                let before = outcome.is_err().then(|| twin.state().to_vec());
                assert_eq!(twin.apply(&command), outcome);
                if let Some(before) = before {
                    refused += 1;
                    assert!(twin.state() == before, "{command:?} gave {outcome:?} and changed the state");
                }
            }
            worlds::run(&mut world, 1);
            worlds::run(&mut twin, 1);
        }
    }
    assert!(refused > 1000, "{refused} refused");
}

/// Numbers that are finite but not sensible: refused, or taken without harm.
#[test]
fn extreme_numbers_are_refused_or_taken() {
    for &(name, call) in CASES {
        let mut good = Poison { target: usize::MAX, bad: 0.0, seen: 0 };
        call(&mut Fixture::new(true), &mut good).expect("good numbers");
        for target in 0..good.seen {
            for bad in [f32::MAX, f32::MIN, 1.0e6, -1.0e6, 1.0e9, f32::MIN_POSITIVE, 1.0e-45, -0.0, 0.0] {
                let mut fixture = Fixture::new(true);
                let state = fixture.world.state().to_vec();
                if call(&mut fixture, &mut Poison { target, bad, seen: 0 }).is_err() {
                    assert!(fixture.world.state() == state, "{name}: number {target} as {bad}");
                    continue;
                }
                for _ in 0..4 {
                    let report = fixture.world.step(&mut Serial);
                    assert_eq!(report.quarantined, 0, "{name}: number {target} as {bad}");
                }
                let mut snapshot = vec![0; fixture.world.snapshot_bytes()];
                fixture.world.save(&mut snapshot).expect("the buffer is large enough");
                assert_eq!(fixture.world.load(&snapshot), Ok(()), "{name}: number {target} as {bad}");
            }
        }
    }
}

/// Who adds a public method that changes a world must add it to the cases, or to the list of those without numbers.
#[test]
fn every_public_method_is_listed() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../core/src");
    let mut files = vec![folder.join("world.rs")];
    for entry in std::fs::read_dir(folder.join("world")).expect("core/src/world can be read") {
        files.push(entry.expect("an entry").path());
    }
    files.retain(|file| file.is_file());
    let mut listed = BTreeSet::new();
    for file in files {
        let text = std::fs::read_to_string(&file).expect("source can be read");
        // Of the world alone: other types have methods of the same names.
        let blocks = text.split("\nimpl").filter(|block| block.contains("> World<M> {\n"));
        let blocks = blocks.map(|block| &block[..block.find("\n}\n").unwrap_or(block.len())]);
        for signature in blocks.flat_map(|block| block.split("    pub fn ").skip(1)) {
            let head = signature.split('{').next().expect("a signature");
            let name = head.split(['(', '<']).next().expect("a name");
            if !head.contains("&mut self") {
                continue;
            }
            let is_case = CASES.iter().chain(ASSET_CASES).any(|case| case.0 == name);
            assert!(
                is_case || WITHOUT_NUMBERS.contains(&name),
                "`{name}` of {} is not listed",
                file.display()
            );
            listed.insert(name.to_string());
        }
    }
    for name in CASES.iter().chain(ASSET_CASES).map(|case| case.0).chain(WITHOUT_NUMBERS.iter().copied()) {
        assert!(listed.contains(name), "`{name}` is listed, but is no public method");
    }
}
