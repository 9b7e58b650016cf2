//! Every shape in every pose in which it rests, and rolling.

use super::*;
use cellstep::Position;
use cellstep_tests::oracles::{center, dot, judge, norm, relative, spin, velocity};
use cellstep_tests::worlds::{add, run};

/// A shape, how its frame stands over the floor when it rests, and how many points carry it.
struct Rest {
    name: &'static str,
    geometry: Geometry,
    pose: Pose,
    points: u32,
}

/// The poses of rest; registers the hulls and compounds they need.
fn rests(world: &mut OwnedWorld) -> Vec<Rest> {
    let (h, r) = (0.5_f32, 0.3_f32);
    let turn = |angle: f32| Rotation::from_axis_angle(Vec3::Y, angle);
    let quarter = core::f32::consts::FRAC_PI_2;
    let up = |z: f32, rotation: Rotation| Pose::new(Vec3::new(0.1, -0.2, z), rotation);
    let cylinder = Geometry::Cylinder { half_height: h, radius: r };
    let cone = Geometry::Cone { half_height: h, radius: r };
    let lean = cellstep::math::atan2(r, 2.0 * h);
    let half = Vec3::new(0.4, 0.3, 0.2);
    let core = world.add_hull(&corners(half)).expect("a box");
    let rounded = Geometry::RoundedHull { hull: core, radius: 0.1 };
    // A table: a top and four legs, one of them a cone on its apex.
    let leg = |x: f32, y: f32| Pose::new(Vec3::new(x, y, -0.3), Rotation::IDENTITY);
    let rod = Geometry::Cylinder { half_height: 0.25, radius: 0.05 };
    let spike = Geometry::Cone { half_height: 0.25, radius: 0.05 };
    let spiked = Pose::new(Vec3::new(0.4, 0.3, -0.3), turn(2.0 * quarter));
    let top = Geometry::Box { half_extents: Vec3::new(0.5, 0.4, 0.05) };
    let parts = [
        (top, Pose::IDENTITY),
        (rod, leg(-0.4, -0.3)),
        (rod, leg(0.4, -0.3)),
        (rod, leg(-0.4, 0.3)),
        (spike, spiked),
    ];
    let table = world.add_compound(&parts.map(|(geometry, pose)| CompoundChild { geometry, pose }));
    let table = Geometry::Compound(table.expect("a table"));
    let rest = |name, geometry, pose, points| Rest { name, geometry, pose, points };
    vec![
        rest("cylinder stands", cylinder, up(h, Rotation::IDENTITY), 4),
        rest("cylinder stands on its top", cylinder, up(h, turn(2.0 * quarter)), 4),
        rest("cylinder lies", cylinder, up(r, turn(quarter)), 2),
        rest("cone stands", cone, up(h, Rotation::IDENTITY), 4),
        rest("cone lies", cone, up(h * cellstep::math::sin(lean), turn(quarter + lean)), 2),
        rest("rounded box on its large face", rounded, up(0.3, Rotation::IDENTITY), 4),
        rest("rounded box on its side", rounded, up(0.5, turn(quarter)), 4),
        rest("table on its legs", table, up(0.55, Rotation::IDENTITY), 4),
        rest("table upside down", table, up(0.05, turn(2.0 * quarter)), 4),
    ]
}

fn put(rest: &Rest, world: &mut OwnedWorld) -> BodyHandle {
    let def = BodyDef { rotation: rest.pose.rotation, ..BodyDef::new(BodyKind::Dynamic, rest.pose.position) };
    add(world, &def, &ShapeDef::new(rest.geometry)).0
}

/// Rms speed and drift over two seconds, after two.
fn stays(body: BodyHandle, world: &mut OwnedWorld) -> (f64, f64) {
    run(world, 120);
    let before = center(world, body);
    let mut square = 0.0;
    for _ in 0..120 {
        run(world, 1);
        square += norm(velocity(world, body)).powi(2) + norm(spin(world, body)).powi(2);
    }
    let after = center(world, body);
    let drift = norm([0, 1, 2].map(|i| after[i] - before[i]));
    ((square / 120.0).sqrt(), drift)
}

#[test]
fn every_shape_rests_on_every_floor() {
    for floor in FLOORS {
        for index in 0..9 {
            let mut world = world();
            let rest = rests(&mut world).swap_remove(index);
            // The floor's shape comes first, or the body's.
            let early = (index % 2 == 0).then(|| floor.build(&mut world, Rotation::IDENTITY));
            let body = put(&rest, &mut world);
            let under = early.unwrap_or_else(|| floor.build(&mut world, Rotation::IDENTITY));
            let (speed, drift) = stays(body, &mut world);
            let name = format!("{} on a {floor:?}", rest.name);
            println!("{name}: rms speed {speed:.1e}, drift {drift:.1e} m");
            assert!(speed < 2.0e-4, "{name}: rms speed {speed}");
            assert!(drift < 1.0e-4, "{name}: drifts {drift} m in 2 s");
            let moved = world.position(body).expect("lives").minus(Position::at(rest.pose.position));
            assert!(moved.length() < 5.0e-3, "{name}: moved by {moved}");
            let shape = world.shapes_of(body).expect("lives").next().expect("one shape");
            let (mut points, mut deepest) = (0, 0.0_f32);
            world.manifolds(under, shape, |manifold| {
                for point in &manifold.points {
                    points += u32::from(point.separation < 1.0e-3);
                    deepest = cellstep::math::min(deepest, point.separation);
                }
            });
            assert!(deepest > -5.0e-3, "{name}: sunk by {deepest}");
            // A face that is cut by the edges of triangles or tiles touches with points on those.
            let cut = matches!(floor, Floor::Mesh | Floor::HeightField | Floor::Compound);
            assert!(points == rest.points || cut && points >= 2, "{name}: {points} points");
        }
    }
}

#[test]
fn cylinders_roll_down_as_their_inertia_says() {
    let slope = core::f32::consts::PI / 9.0;
    let tilt = Rotation::from_axis_angle(Vec3::Y, slope);
    let lying = Rotation::from_axis_angle(Vec3::X, core::f32::consts::FRAC_PI_2);
    let downhill = [f64::from(slope).cos(), 0.0, -f64::from(slope).sin()];
    for floor in FLOORS {
        let mut world = world();
        floor.build(&mut world, tilt);
        let radius = 0.5;
        let def = BodyDef {
            rotation: tilt.after(lying),
            ..BodyDef::new(BodyKind::Dynamic, tilt.rotate(Vec3::new(-3.0, 0.0, radius)))
        };
        let geometry = Geometry::Cylinder { half_height: 0.3, radius };
        let (body, _) = add(&mut world, &def, &ShapeDef::new(geometry));
        run(&mut world, 30);
        let before = dot(velocity(&world, body), downhill);
        let uphill = [f64::from(slope).sin(), 0.0, f64::from(slope).cos()];
        let mut bump = 0.0_f64;
        for _ in 0..90 {
            run(&mut world, 1);
            bump = bump.max(dot(velocity(&world, body), uphill).abs());
        }
        let found = (dot(velocity(&world, body), downhill) - before) / 1.5;
        let name = format!("cylinder rolls down a {floor:?}");
        judge(&name, relative(found, 2.236_812), [1.0e-3, 1.0e-2]);
        println!("{name}: {found:.6} m/s2, leaves the slope at {bump:.1e} m/s at most");
        assert!(bump < 2.0e-3, "{name}: bumps at {bump} m/s");
        assert!(velocity(&world, body)[1].abs() < 2.0e-3, "{name}: rolls aside");
    }
}

#[test]
fn a_cone_rolls_in_a_circle_about_its_apex() {
    let mut world = world();
    Floor::Slab.build(&mut world, Rotation::IDENTITY);
    let (h, r) = (0.5_f32, 0.3_f32);
    let lean = cellstep::math::atan2(r, 2.0 * h);
    let rotation = Rotation::from_axis_angle(Vec3::Y, core::f32::consts::FRAC_PI_2 + lean);
    let height = h * cellstep::math::sin(lean);
    // The line on the floor is at rest: the spin is along it, and the axis goes round with what of it is upright.
    let def = BodyDef {
        rotation,
        angular_velocity: Vec3::X * 1.0,
        ..BodyDef::new(BodyKind::Dynamic, Vec3::Z * height)
    };
    let def = BodyDef { linear_velocity: Vec3::ZERO, ..def };
    let (body, _) = add(&mut world, &def, &ShapeDef::new(Geometry::Cone { half_height: h, radius: r }));
    // v = w x r from a point of the line at rest to the center of mass.
    let from_line = rotation.rotate(Vec3::Z * (-0.5 * h)) + Vec3::Z * height;
    world.set_linear_velocity(body, Vec3::X.cross(from_line)).expect("a number");
    run(&mut world, 10);
    let apex = |world: &OwnedWorld| {
        let pose = world.rotation(body).expect("lives");
        let tip = pose.rotate(Vec3::Z * (1.5 * h));
        let at = center(world, body);
        [at[0] + f64::from(tip.x), at[1] + f64::from(tip.y), at[2] + f64::from(tip.z)]
    };
    let before = apex(&world);
    let speed = norm(velocity(&world, body));
    run(&mut world, 240);
    let after = apex(&world);
    let moved = norm([0, 1, 2].map(|i| after[i] - before[i]));
    println!("apex moved {moved:.4} m in 4 s, speed {speed:.4} to {:.4}", norm(velocity(&world, body)));
    assert!(moved < 0.02, "the apex moved by {moved} m");
    judge("cone's speed after 4 s", relative(norm(velocity(&world, body)), speed), [2.0e-2, 5.0e-2]);
}
