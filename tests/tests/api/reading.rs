//! User data, iteration, and contacts with their impulses and manifolds.

use super::{GRAVITY, SUBSTEP, ball, close, cuboid, dynamic, near, slope};
use cellstep::math::{Pose, Rotation, Vec3};
use cellstep::{BodyDef, BodyHandle, BodyKind, Capacities, Filter, Geometry, ShapeDef, WorldManifold};
use cellstep_tests::worlds::{self, OwnedWorld, add, run};

#[test]
fn user_data_is_kept() {
    let mut world = worlds::world(2);
    let (body, shape) = add(
        &mut world,
        &BodyDef { user: u64::MAX, ..dynamic(0.0, 0.0, 5.0) },
        &ShapeDef { user: 0x0123_4567_89ab_cdef, ..ball(0.5) },
    );
    let mut snapshot = vec![0; world.snapshot_bytes()];
    world.save(&mut snapshot).expect("the buffer is large enough");
    run(&mut world, 10);
    assert_eq!(world.body_user(body), Ok(u64::MAX));
    assert_eq!(world.shape_user(shape), Ok(0x0123_4567_89ab_cdef));
    world.set_body_user(body, 1).expect("it exists");
    world.set_shape_user(shape, 2).expect("it exists");
    run(&mut world, 10);
    assert_eq!((world.body_user(body), world.shape_user(shape)), (Ok(1), Ok(2)));
    world.restore(&snapshot).expect("its own snapshot");
    assert_eq!(world.body_user(body), Ok(u64::MAX));
    assert_eq!(world.shape(shape).expect("it exists").user, 0x0123_4567_89ab_cdef);
}

#[test]
fn bodies_come_in_the_order_of_their_slots() {
    let mut world = worlds::world(5);
    let made: Vec<BodyHandle> =
        (0..5).map(|i| world.create_body(&dynamic(i as f32, 0.0, 0.0)).expect("room")).collect();
    assert_eq!(world.bodies().collect::<Vec<_>>(), made);
    world.remove_body(made[1]).expect("it exists");
    world.remove_body(made[3]).expect("it exists");
    assert_eq!(world.bodies().collect::<Vec<_>>(), [made[0], made[2], made[4]]);
    assert_eq!(world.body_count(), 3);
    // The lowest free slot is taken first.
    let again = world.create_body(&dynamic(9.0, 0.0, 0.0)).expect("room");
    assert_eq!((again.index, again.generation), (made[1].index, made[1].generation + 1));
    assert_eq!(world.bodies().collect::<Vec<_>>(), [made[0], again, made[2], made[4]]);
}

#[test]
fn shapes_come_in_the_order_of_their_creation() {
    let mut world = worlds::world_with(Capacities { shapes: 4, ..Capacities::for_bodies(2) });
    let [body, other] = [0.0, 9.0].map(|x| world.create_body(&dynamic(x, 0.0, 0.0)).expect("room"));
    let filter = Filter { category: 4, mask: 5, group: -6 };
    let pose = Pose::new(Vec3::X, Rotation::IDENTITY);
    let def = ShapeDef { pose, filter, density: 7.0, friction: 0.25, restitution: 0.5, user: 9, ..ball(0.5) };
    let first = world.create_shape(body, &def).expect("room");
    let alien = world.create_shape(other, &ball(0.1)).expect("room");
    let second = world.create_shape(body, &cuboid(0.1, 0.2, 0.3)).expect("room");
    let third = world.create_shape(body, &ball(0.2)).expect("room");
    let shapes = |world: &OwnedWorld| world.shapes_of(body).expect("it exists").collect::<Vec<_>>();
    assert_eq!(shapes(&world), [first, second, third]);
    assert_eq!(world.shape(first), Ok(def), "a shape reads as it was defined");
    assert_eq!((world.body_of(alien), world.body_of(third)), (Ok(other), Ok(body)));
    world.remove_shape(second).expect("it exists");
    assert_eq!(shapes(&world), [first, third]);
    let fourth = world.create_shape(body, &ball(0.3)).expect("room");
    assert_eq!(fourth.index, second.index);
    assert_eq!(shapes(&world), [first, third, fourth]);
}

#[test]
fn a_resting_box_tells_its_weight() {
    let mut world = worlds::world(2);
    let ground = worlds::ground(&mut world, 0.6);
    let (body, shape) = add(&mut world, &dynamic(3.0, -2.0, 0.5), &cuboid(0.5, 0.5, 0.5));
    run(&mut world, 120);
    let floor = world.shapes_of(ground).expect("it exists").next().expect("a half-space");
    let contacts: Vec<_> = world.contacts().collect();
    assert_eq!(contacts.len(), 1);
    let contact = &contacts[0];
    assert_eq!((contact.shapes, contact.bodies), ([floor, shape], [ground, body]));
    assert_eq!((contact.points, contact.child), (4, 0));
    let weight = 1000.0 * GRAVITY;
    close(f64::from(contact.normal_impulse()) / SUBSTEP, weight, 1.0e-3 * weight);
    for impulse in contact.impulses {
        close(f64::from(impulse) / SUBSTEP, 0.25 * weight, 1.0e-2 * weight);
    }
    assert!(f64::from(contact.friction.length()) / SUBSTEP < 1.0e-3 * weight, "{}", contact.friction);

    let mut seen: Vec<WorldManifold> = Vec::new();
    world.manifolds(floor, shape, |manifold| seen.push(manifold.clone()));
    assert_eq!(seen.len(), 1);
    near(seen[0].normal, Vec3::Z, 1.0e-6);
    assert_eq!(seen[0].points.len(), 4, "the manifold has the contact's points");
    for point in &seen[0].points {
        let [x, y, z] = point.position.to_f64();
        close((x - 3.0).abs(), 0.5, 1.0e-3);
        close((y + 2.0).abs(), 0.5, 1.0e-3);
        close(z, 0.5 * f64::from(point.separation), 1.0e-6);
        assert!((-1.0e-3..0.0).contains(&point.separation), "{}", point.separation);
    }
    // The other way round it is the same contact with the opposite normal.
    world.manifolds(shape, floor, |manifold| near(manifold.normal, -Vec3::Z, 1.0e-6));
    let deepest = seen[0].points.iter().map(|point| -point.separation).fold(0.0, cellstep::math::max);
    assert_eq!(world.penetration_max(), deepest);
    let mut count = 0;
    world.separations(|_| count += 1);
    assert_eq!(count, 4);
}

#[test]
fn friction_of_a_box_on_a_slope_is_its_share_of_the_weight() {
    let mut world = slope(2, (20.0, 0.8));
    let (_, _) =
        add(&mut world, &dynamic(0.0, 0.0, 0.25), &ShapeDef { friction: 0.8, ..cuboid(0.5, 0.5, 0.25) });
    run(&mut world, 120);
    let contact = world.contacts().next().expect("it rests on the slope");
    let (weight, angle) = (500.0 * GRAVITY, 20.0_f64.to_radians());
    // The second body is the box: friction holds it back.
    close(f64::from(contact.friction.x) / SUBSTEP, -weight * angle.sin(), 5.0e-3 * weight);
    close(f64::from(contact.normal_impulse()) / SUBSTEP, weight * angle.cos(), 5.0e-3 * weight);
    near(contact.friction * Vec3::new(0.0, 1.0, 1.0), Vec3::ZERO, (1.0e-3 * weight * SUBSTEP) as f32);
}

#[test]
fn friction_acts_on_the_second_body_whichever_is_static() {
    // The box has the lower slot here: the ground is the second body, and is dragged downhill.
    let mut world = slope(3, (20.0, 0.8));
    let ground = world.bodies().next().expect("the ground");
    world.remove_body(ground).expect("it exists");
    add(&mut world, &dynamic(0.0, 0.0, 0.25), &ShapeDef { friction: 0.8, ..cuboid(0.5, 0.5, 0.25) });
    worlds::ground(&mut world, 0.8);
    run(&mut world, 120);
    let contact = world.contacts().next().expect("it rests on the slope");
    let (weight, angle) = (500.0 * GRAVITY, 20.0_f64.to_radians());
    assert_eq!(world.kind(contact.bodies[1]), Ok(BodyKind::Static));
    close(f64::from(contact.friction.x) / SUBSTEP, weight * angle.sin(), 5.0e-3 * weight);
}

#[test]
fn a_mesh_has_a_contact_for_each_of_its_manifolds() {
    let room = Capacities { meshes: 1, mesh_vertices: 6, mesh_triangles: 4, ..Capacities::for_bodies(2) };
    let mut world = worlds::world_with(room);
    // A gutter along y: two planes that rise at 45 degrees.
    let vertices = [
        [-2.0, -5.0, 2.0],
        [-2.0, 5.0, 2.0],
        [0.0, -5.0, 0.0],
        [0.0, 5.0, 0.0],
        [2.0, -5.0, 2.0],
        [2.0, 5.0, 2.0],
    ];
    let triangles = [[0, 1, 2], [1, 3, 2], [2, 3, 4], [3, 5, 4]];
    let mesh = world.add_mesh(&vertices.map(Vec3::from), &triangles).expect("a mesh");
    let (ground, gutter) =
        add(&mut world, &BodyDef::new(BodyKind::Static, Vec3::ZERO), &ShapeDef::new(Geometry::Mesh(mesh)));
    // Without friction, which could carry any share of the weight.
    let smooth = ShapeDef { friction: 0.0, ..ball(0.5) };
    let (_, stone) = add(&mut world, &dynamic(0.0, 1.0, 0.5 * 2.0_f32.sqrt()), &smooth);
    run(&mut world, 120);
    let contacts: Vec<_> = world.contacts().collect();
    assert_eq!(contacts.len(), 2, "one for each side: {contacts:?}");
    assert!(contacts.iter().all(|contact| contact.shapes == [gutter, stone] && contact.bodies[0] == ground));
    assert!(contacts[0].child < contacts[1].child, "children are ascending");
    // Each side carries weight / (2 cos 45).
    let weight = 1000.0 * 4.0 / 3.0 * std::f64::consts::PI * 0.125 * GRAVITY;
    for contact in &contacts {
        close(f64::from(contact.normal_impulse()) / SUBSTEP, weight / 2.0_f64.sqrt(), 0.01 * weight);
    }
    let mut normals = Vec::new();
    world.manifolds(gutter, stone, |manifold| normals.push(manifold.normal));
    assert_eq!(normals.len(), 2);
    near(normals[0] + normals[1], Vec3::Z * 2.0_f32.sqrt(), 1.0e-3);
}
