//! Mass against closed forms and against grids of cells.

extern crate std;
use super::*;
use crate::collide::hull;
use crate::collide::vector64::length;
use std::vec::Vec;

fn close(a: f32, b: f32, scale: f32) -> bool {
    (a - b).abs() <= 1.0e-6 * scale
}

fn box_points(half: Vec3) -> Vec<Vec3> {
    let sign = |i: u32, bit: u32| if i & bit == 0 { -1.0 } else { 1.0 };
    (0..8).map(|i| half * Vec3::new(sign(i, 1), sign(i, 2), sign(i, 4))).collect()
}

fn turned() -> Rotation {
    Rotation::new(0.3, -0.5, 0.2, 0.7).normalized()
}

/// The tensor in the body's frame, rebuilt from its principal form.
fn tensor(properties: &MassProperties) -> Matrix {
    let r = matrix_from(properties.axes);
    product(&product(&r, &diagonal(to_f64(properties.inertia))), &transposed(&r))
}

/// Mass, center and tensor of the union of solids by counting cells of a grid.
fn counted(inside: impl Fn(Vec3) -> f32, reach: f32, cells: usize) -> (f64, Vector, Matrix) {
    let size = 2.0 * reach / cells as f32;
    let (mut mass, mut first, mut second) = (0.0, [0.0; 3], [[0.0; 3]; 3]);
    for i in 0..cells * cells * cells {
        let cell = [i % cells, i / cells % cells, i / cells / cells].map(|k| (k as f32 + 0.5) * size - reach);
        let m = f64::from(inside(Vec3::from(cell)) * size * size * size);
        let x = cell.map(f64::from);
        mass += m;
        for j in 0..3 {
            first[j] += m * x[j];
            for k in 0..3 {
                second[j][k] += m * x[j] * x[k];
            }
        }
    }
    let center = first.map(|x| x / mass);
    let s = |a: usize, b: usize| second[a][b] - mass * center[a] * center[b];
    let trace = s(0, 0) + s(1, 1) + s(2, 2);
    let inertia = [0, 1, 2].map(|j| [0, 1, 2].map(|k| if j == k { trace } else { 0.0 } - s(j, k)));
    (mass, center, inertia)
}

#[test]
fn closed_forms() {
    let sphere = MassProperties::of(&Solid::Sphere { radius: 0.5 }, 2.0);
    let mass = 2.0 * 4.0 / 3.0 * core::f32::consts::PI * 0.125;
    assert!(close(sphere.mass, mass, mass));
    assert!(close(sphere.inertia.x, 0.4 * mass * 0.25, mass));
    assert_eq!(sphere.inertia.x, sphere.inertia.z);

    let half = Vec3::new(0.5, 1.0, 1.5);
    let cuboid = MassProperties::of(&Solid::Box { half_extents: half }, 3.0);
    assert_eq!(cuboid.mass, 18.0);
    let expected = Vec3::new(1.0 + 2.25, 0.25 + 2.25, 0.25 + 1.0) * 18.0 / 3.0;
    assert!((cuboid.inertia - expected).length() < 1.0e-5);
    assert_eq!((cuboid.axes, cuboid.center), (Rotation::IDENTITY, Vec3::ZERO));

    // A capsule without a segment is a ball; a thin one is a rod.
    let ball = MassProperties::of(&Solid::Capsule { half_height: 0.0, radius: 0.5 }, 2.0);
    assert_eq!((ball.mass, ball.inertia), (sphere.mass, sphere.inertia));
    let rod = MassProperties::of(&Solid::Capsule { half_height: 1.0, radius: 1.0e-3 }, 1000.0);
    assert!(close(rod.inertia.x / (rod.mass * 4.0 / 12.0), 1.0, 3.0e3));
    assert!(close(rod.inertia.z / (rod.mass * 0.5e-6), 1.0, 1.0e3));
}

#[test]
fn without_volume() {
    let none = MassProperties::default();
    assert_eq!(MassProperties::of(&Solid::HalfSpace, 1.0), none);
    assert_eq!(MassProperties::of(&Solid::Sphere { radius: 1.0 }, 0.0), none);
    assert_eq!(MassProperties::of(&Solid::Sphere { radius: 1.0 }, f32::NAN), none);
    assert_eq!(MassAccumulator::default().finish(), none);
}

#[test]
fn hull_of_a_box_is_the_box() {
    let half = Vec3::new(0.3, 1.0, 0.7);
    let tables = hull::build(&box_points(half)).unwrap();
    let hull = MassProperties::of(&Solid::Hull(tables.view()), 5.0);
    let cuboid = MassProperties::of(&Solid::Box { half_extents: half }, 5.0);
    assert!(close(hull.mass, cuboid.mass, cuboid.mass));
    assert!((hull.inertia - cuboid.inertia).length() < 1.0e-6 * cuboid.inertia.length());
    assert!(hull.center.length() < 1.0e-7);
    assert_eq!(hull.axes, Rotation::IDENTITY);
}

#[test]
fn hull_far_from_its_origin_keeps_its_inertia() {
    let half = Vec3::new(0.25, 1.0, 0.5);
    let far = Vec3::new(512.0, -256.0, 1024.0);
    let points: Vec<Vec3> = box_points(half).iter().map(|&p| p + far).collect();
    let tables = hull::build(&points).unwrap();
    let hull = MassProperties::of(&Solid::Hull(tables.view()), 5.0);
    let cuboid = MassProperties::of(&Solid::Box { half_extents: half }, 5.0);
    assert_eq!(hull.center, far);
    assert!((hull.inertia - cuboid.inertia).length() < 1.0e-6 * cuboid.inertia.length());
}

#[test]
fn capsule_and_hull_against_a_grid() {
    let (h, r) = (0.6_f32, 0.35_f32);
    let in_capsule = |p: Vec3| {
        let z = p.z - crate::math::clamp(p.z, -h, h);
        if p.x * p.x + p.y * p.y + z * z <= r * r { 1.0 } else { 0.0 }
    };
    let points: Vec<Vec3> = (0..30_u32)
        .map(|i| {
            let t = |k: u32| (i.wrapping_mul(k) % 997) as f32 / 997.0 - 0.5;
            Vec3::new(1.6 * t(7919), t(104_729) + 0.2, 1.2 * t(1_299_709))
        })
        .collect();
    let tables = hull::build(&points).unwrap();
    let in_hull =
        |p: Vec3| if tables.planes.iter().all(|plane| plane.distance(p) <= 0.0) { 1.0 } else { 0.0 };
    let capsule = MassProperties::of(&Solid::Capsule { half_height: h, radius: r }, 1.0);
    let hull = MassProperties::of(&Solid::Hull(tables.view()), 1.0);
    let counts = [(capsule, counted(in_capsule, 1.0, 160)), (hull, counted(in_hull, 1.0, 160))];
    for (exact, (mass, center, inertia)) in counts {
        assert!((f64::from(exact.mass) / mass - 1.0).abs() < 5.0e-3);
        assert!(length(difference(to_f64(exact.center), center)) < 3.0e-3);
        let rebuilt = tensor(&exact);
        for i in 0..9 {
            assert!((rebuilt[i / 3][i % 3] - inertia[i / 3][i % 3]).abs() < 6.0e-3 * inertia[0][0]);
        }
    }
}

#[test]
fn several_solids_against_a_grid() {
    let cuboid = Vec3::new(0.4, 0.1, 0.2);
    let pose = Pose::new(Vec3::new(0.4, 0.3, -0.2), turned());
    let center = Vec3::new(-0.5, -0.4, 0.1);
    let mut sum = MassAccumulator::default();
    sum.add(&Solid::Box { half_extents: cuboid }, &pose, 3.0);
    sum.add(&Solid::HalfSpace, &Pose::IDENTITY, 9.0);
    sum.add(&Solid::Sphere { radius: 0.3 }, &Pose::new(center, turned()), 2.0);
    let exact = sum.finish();
    let density = |p: Vec3| {
        let local = pose.untransform(p).abs();
        let inside = local.x <= cuboid.x && local.y <= cuboid.y && local.z <= cuboid.z;
        (if inside { 3.0 } else { 0.0 }) + if (p - center).length() <= 0.3 { 2.0 } else { 0.0 }
    };
    let (mass, center, inertia) = counted(density, 1.0, 160);
    assert!((f64::from(exact.mass) / mass - 1.0).abs() < 3.0e-3);
    assert!(length(difference(to_f64(exact.center), center)) < 3.0e-3);
    let rebuilt = tensor(&exact);
    for i in 0..9 {
        assert!((rebuilt[i / 3][i % 3] - inertia[i / 3][i % 3]).abs() < 6.0e-3 * inertia[0][0]);
    }
}

#[test]
fn diagonal_tensors_keep_their_axes() {
    // A dumb-bell along each axis, a box turned by a quarter, a heap of boxes in a plane of symmetry.
    for axis in [Vec3::X, Vec3::Y, Vec3::Z] {
        let mut sum = MassAccumulator::default();
        sum.add(&Solid::Sphere { radius: 0.1 }, &Pose::new(axis, turned()), 1.0);
        sum.add(&Solid::Sphere { radius: 0.1 }, &Pose::new(-axis * 3.0, Rotation::IDENTITY), 1.0);
        let properties = sum.finish();
        assert_eq!(properties.axes, Rotation::IDENTITY);
        assert_eq!(properties.inertia.min_element(), properties.inertia.dot(axis));
    }
    let half_extents = Vec3::new(0.5, 1.0, 1.5);
    let quarter = Rotation::new(0.0, 0.0, 0.707_106_77, 0.707_106_77);
    let mut sum = MassAccumulator::default();
    sum.add(&Solid::Box { half_extents }, &Pose::new(Vec3::new(7.0, 8.0, 9.0), quarter), 1.0);
    let properties = sum.finish();
    assert_eq!(properties.axes, Rotation::IDENTITY);
    assert!(properties.inertia.x < properties.inertia.y);
}

#[test]
fn axes_of_a_turned_solid_diagonalise_it() {
    let half_extents = Vec3::new(1.0e-3, 2.0e-3, 1.0);
    let mut sum = MassAccumulator::default();
    sum.add(&Solid::Box { half_extents }, &Pose::new(Vec3::ONE, turned()), 1000.0);
    let properties = sum.finish();
    let own = MassProperties::of(&Solid::Box { half_extents }, 1000.0).inertia;
    let mut moments = properties.inertia.to_array();
    moments.sort_by(f32::total_cmp);
    // The needle's small moment is as precise as the large ones.
    for (found, expected) in moments.iter().zip([own.z, own.y, own.x]) {
        assert!((found / expected - 1.0).abs() < 2.0e-6, "{found} {expected}");
    }
    // The axis of the small moment is the needle's.
    let (small, _) = properties
        .inertia
        .to_array()
        .iter()
        .enumerate()
        .fold((0, f32::MAX), |best, (i, &m)| if m < best.1 { (i, m) } else { best });
    let axis = properties.axes.rotate([Vec3::X, Vec3::Y, Vec3::Z][small]);
    assert!(axis.dot(turned().rotate(Vec3::Z)).abs() > 1.0 - 1.0e-6);
}

/// Compares mass, center and tensor with those of a grid.
fn agrees(exact: &MassProperties, (mass, center, inertia): (f64, Vector, Matrix)) {
    assert!((f64::from(exact.mass) / mass - 1.0).abs() < 3.0e-3, "{exact:?} {mass}");
    assert!(length(difference(to_f64(exact.center), center)) < 1.0e-3, "{exact:?} {center:?}");
    let rebuilt = tensor(exact);
    for i in 0..9 {
        let (found, expected) = (rebuilt[i / 3][i % 3], inertia[i / 3][i % 3]);
        assert!((found - expected).abs() < 4.0e-3 * inertia[0][0], "{rebuilt:?} {inertia:?}");
    }
}

#[test]
fn cylinder_and_cone_against_a_grid() {
    let (h, r) = (0.6_f32, 0.45_f32);
    let within = |p: Vec3, r: f32| if p.z.abs() <= h && p.x * p.x + p.y * p.y <= r * r { 1.0 } else { 0.0 };
    let cylinder = MassProperties::of(&Solid::Cylinder { half_height: h, radius: r }, 1.0);
    // Turned against the grid, so that flat faces do not fall between cells.
    let pose = Pose::new(Vec3::new(0.02, 0.01, -0.03), turned());
    let moved = |solid: &Solid<'_>| {
        let mut sum = MassAccumulator::default();
        sum.add(solid, &pose, 1.0);
        sum.finish()
    };
    let solid = Solid::Cylinder { half_height: h, radius: r };
    agrees(&moved(&solid), counted(|p| within(pose.untransform(p), r), 0.8, 160));
    let cone = MassProperties::of(&Solid::Cone { half_height: h, radius: r }, 1.0);
    let in_cone = |p: Vec3| within(p, r * (h - p.z) / (2.0 * h));
    let solid = Solid::Cone { half_height: h, radius: r };
    agrees(&moved(&solid), counted(|p| in_cone(pose.untransform(p)), 0.8, 160));
    // m (3 r^2 + 4 h^2) / 12 across a cylinder; 3/10 m r^2 along a cone, 3/80 m (4 r^2 + (2 h)^2) across it.
    let (m, n) = (cylinder.mass, cone.mass);
    assert!(close(cylinder.inertia.x, m * (3.0 * r * r + 4.0 * h * h) / 12.0, m), "{cylinder:?}");
    assert!(close(cone.inertia.z, 0.3 * n * r * r, n) && close(cone.center.z, -0.5 * h, 1.0), "{cone:?}");
    assert!(close(cone.inertia.x, 0.15 * n * (r * r + h * h), n), "{cone:?}");
}

#[test]
fn rounded_hulls_against_closed_forms_and_a_grid() {
    // A box with a radius: its own volume, slabs over the faces, quarter cylinders, and a ball.
    let (half, r) = (Vec3::new(0.3, 0.2, 0.1), 0.15_f32);
    let tables = hull::build(&box_points(half)).unwrap();
    let rounded = Solid::RoundedHull { hull: tables.view(), radius: r };
    let cuboid = MassProperties::of(&rounded, 1.0);
    let (x, y, z, pi) = (2.0 * half.x, 2.0 * half.y, 2.0 * half.z, core::f32::consts::PI);
    let volume = x * y * z + 2.0 * r * (x * y + y * z + z * x) + pi * r * r * (x + y + z);
    let volume = volume + 4.0 / 3.0 * pi * r * r * r;
    assert!(close(cuboid.mass, volume, volume), "{cuboid:?} {volume}");
    let in_box = |p: Vec3| {
        let d = p - crate::math::max_each(-half, crate::math::min_each(p, half));
        if d.dot(d) <= r * r { 1.0 } else { 0.0 }
    };
    agrees(&cuboid, counted(in_box, 0.5, 160));
    // A hull without symmetry.
    let points: Vec<Vec3> = (0..12_u32)
        .map(|i| {
            let t = |k: u32| (i.wrapping_mul(k) % 997) as f32 / 997.0 - 0.5;
            Vec3::new(0.9 * t(7919), 0.6 * t(104_729) + 0.1, 0.5 * t(1_299_709))
        })
        .collect();
    let tables = hull::build(&points).unwrap();
    let r = 0.2;
    let within = |p: Vec3| {
        let near = crate::collide::distance::closest(&tables.vertices, &[p], r);
        if near.is_some_and(|near| near.distance <= r) { 1.0 } else { 0.0 }
    };
    let rounded = |radius: f32| MassProperties::of(&Solid::RoundedHull { hull: tables.view(), radius }, 1.0);
    agrees(&rounded(r), counted(within, 0.75, 100));
    // Hardly rounded it is the hull.
    let (little, hull) = (rounded(1.0e-6), MassProperties::of(&Solid::Hull(tables.view()), 1.0));
    assert!((little.mass / hull.mass - 1.0).abs() < 1.0e-4, "{little:?} {hull:?}");
    assert!((little.inertia - hull.inertia).length() < 1.0e-4 * hull.inertia.length());
}
