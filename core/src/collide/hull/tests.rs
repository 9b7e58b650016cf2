//! What a hull must be, on clean, noisy, degenerate and random points.

extern crate std;
use super::*;
use crate::math::Rotation;
use std::vec::Vec;

/// Deterministic random numbers in 0..1.
struct Random(u32);

impl Random {
    fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
        let x = (self.0 >> (self.0 >> 28).wrapping_add(4) ^ self.0).wrapping_mul(277_803_737);
        ((x >> 22 ^ x) >> 8) as f32 / 16_777_216.0
    }

    fn vector(&mut self) -> Vec3 {
        Vec3::new(self.next(), self.next(), self.next()) * 2.0 - Vec3::ONE
    }

    fn direction(&mut self) -> Vec3 {
        loop {
            let v = self.vector();
            if v.dot(v) < 1.0 && v.dot(v) > 0.01 {
                return v / v.dot(v).sqrt();
            }
        }
    }

    fn rotation(&mut self) -> Rotation {
        Rotation::new(self.next() - 0.5, self.next() - 0.5, self.next() - 0.5, self.next() - 0.5).normalized()
    }
}

/// Checks everything the file's head promises, independently of how it was built.
fn check(points: &[Vec3]) -> HullTables {
    let hull = build(points)
        .unwrap_or_else(|e| panic!("{e:?} for {} points {:?}", points.len(), &points[..8.min(points.len())]));
    let tolerance = measure(points).unwrap();
    assert_eq!(hull.vertices.len() + hull.faces.len(), hull.edges.len() + 2);
    assert_eq!(hull.planes.len(), hull.faces.len());
    assert_eq!(hull.loops.len(), 2 * hull.edges.len());
    for vertex in &hull.vertices {
        assert!(points.contains(vertex));
    }
    for plane in &hull.planes {
        assert!((plane.normal.dot(plane.normal) - 1.0).abs() < 1.0e-6);
        assert!(plane.distance(hull.center) < 0.0);
        for &point in points {
            let above = dot(to_f64(plane.normal), to_f64(point)) - f64::from(plane.offset);
            assert!(above <= 4.0 * tolerance, "{above} above");
        }
    }
    let mut used = 0;
    for (face, plane) in hull.faces.iter().zip(&hull.planes) {
        assert_eq!(usize::from(face.first), used);
        used += usize::from(face.count);
        assert!(face.count >= 3);
        for (tail, _) in directed_edges(&hull, face) {
            let above = dot(to_f64(plane.normal), to_f64(hull.vertices[usize::from(tail)]));
            assert!((above - f64::from(plane.offset)).abs() <= 4.0 * tolerance);
        }
    }
    for edge in &hull.edges {
        let runs = |face: u8, tail, head| {
            directed_edges(&hull, &hull.faces[usize::from(face)]).filter(|&e| e == (tail, head)).count()
        };
        assert_eq!(runs(edge.left, edge.tail, edge.head), 1);
        assert_eq!(runs(edge.right, edge.head, edge.tail), 1);
        assert_ne!(edge.left, edge.right);
    }
    hull
}

fn shape(hull: &HullTables) -> (usize, usize, usize) {
    (hull.vertices.len(), hull.faces.len(), hull.edges.len())
}

fn cube_corners(half: Vec3) -> Vec<Vec3> {
    (0..8)
        .map(|i| {
            let sign = |bit: u32| if i & bit == 0 { -1.0 } else { 1.0 };
            half * Vec3::new(sign(1), sign(2), sign(4))
        })
        .collect()
}

#[test]
fn cube_with_duplicates_and_points_within() {
    let half = Vec3::new(0.5, 1.0, 2.0);
    let corners = cube_corners(half);
    assert_eq!(shape(&check(&corners)), (8, 6, 12));

    let mut random = Random(1);
    let mut points = Vec::new();
    for _ in 0..40 {
        let mut p = random.vector();
        points.push(p * half);
        p.x = p.x.signum();
        points.push(p * half);
        p.z = p.z.signum();
        points.push(p * half);
        points.push(corners[(random.next() * 8.0) as usize % 8]);
    }
    points.extend(&corners);
    let hull = check(&points);
    assert_eq!(shape(&hull), (8, 6, 12));
    assert!(hull.center.length() < 1.0e-6);
    for plane in &hull.planes {
        assert_eq!(plane.normal.abs().element_sum(), 1.0);
        assert_eq!(plane.offset, (plane.normal.abs() * half).element_sum());
    }
}

#[test]
fn noisy_turned_and_moved_boxes_keep_six_faces() {
    let mut random = Random(2);
    for round in 0..300 {
        let rotation = random.rotation();
        let half = Vec3::new(random.next() + 0.01, random.next() + 0.01, random.next() + 0.01);
        let far = random.vector() * if round % 2 == 0 { 0.0 } else { 3.0 };
        let mut points = cube_corners(half);
        for _ in 0..30 {
            let mut p = random.vector();
            p.y = p.y.signum();
            points.push(p * half);
            p.x = p.x.signum();
            points.push(p * half);
        }
        // Any order of the points.
        for i in 0..points.len() {
            let j = (random.next() * points.len() as f32) as usize;
            points.swap(i, j);
        }
        for p in &mut points {
            *p = rotation.rotate(*p) + far;
        }
        let hull = check(&points);
        assert_eq!(shape(&hull), (8, 6, 12), "round {round}");
    }
}

#[test]
fn known_polytopes() {
    let tetrahedron = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z];
    assert_eq!(shape(&check(&tetrahedron)), (4, 4, 6));
    let octahedron = [Vec3::X, -Vec3::X, Vec3::Y, -Vec3::Y, Vec3::Z, -Vec3::Z];
    assert_eq!(shape(&check(&octahedron)), (6, 8, 12));
    for sides in [3, 5, 8, 17, 32] {
        let mut prism = Vec::new();
        for i in 0..sides {
            let angle = i as f32 / sides as f32 * 2.0 * core::f32::consts::PI;
            let (y, x) = (libm::sinf(angle), libm::cosf(angle));
            prism.push(Vec3::new(x, y, -1.0));
            prism.push(Vec3::new(x, y, 1.0));
        }
        assert_eq!(shape(&check(&prism)), (2 * sides, sides + 2, 3 * sides));
    }
}

#[test]
fn grids_of_points() {
    for n in [2, 3, 5, 12] {
        let mut points = Vec::new();
        for i in 0..n * n * n {
            points.push(Vec3::new((i % n) as f32, (i / n % n) as f32, (i / n / n) as f32) * 0.1);
        }
        assert_eq!(shape(&check(&points)), (8, 6, 12));
        // A corner cut off: a triangle more.
        points.retain(|p| p.element_sum() > 0.05);
        if n > 2 {
            assert_eq!(shape(&check(&points)), (10, 7, 15));
        }
    }
}

#[test]
fn random_clouds() {
    let mut random = Random(3);
    for round in 0..400 {
        let count = 4 + (random.next() * 60.0) as usize;
        let scale = Vec3::new(1.0, 0.01 + random.next(), 0.01 + random.next());
        let on_sphere = round % 2 == 0;
        let points: Vec<Vec3> = (0..count)
            .map(|_| if on_sphere { random.direction() } else { random.vector() } * scale)
            .collect();
        let hull = match build(&points) {
            Err(HullError::Flat) if count < 8 => continue,
            _ => check(&points),
        };
        if on_sphere && count > 8 {
            // Every point of a sphere is a corner, but for such as nearly coincide.
            assert!(hull.vertices.len() + 8 >= count);
        }
    }
}

#[test]
fn nearly_coplanar_clouds() {
    let mut random = Random(4);
    for round in 0..400 {
        // Noise from far below to far above the tolerance, on the faces of a turned box.
        let noise = [1.0e-8, 1.0e-6, 5.0e-6, 1.0e-5, 3.0e-5, 1.0e-4][round % 6];
        let rotation = random.rotation();
        let mut points = cube_corners(Vec3::ONE);
        for _ in 0..24 {
            let mut p = random.vector();
            p.z = if random.next() < 0.5 { 1.0 } else { -1.0 };
            points.push(p);
        }
        for p in &mut points {
            *p = rotation.rotate(*p + random.vector() * noise);
        }
        let hull = check(&points);
        assert!(hull.vertices.len() >= 8);
    }
}

#[test]
fn many_points_reduce_to_few() {
    let mut random = Random(5);
    let mut points: Vec<Vec3> = (0..100_000).map(|_| random.vector() * 0.99).collect();
    let corners: Vec<Vec3> = (0..60).map(|_| random.direction() * 1.8).collect();
    points.extend(&corners);
    let hull = check(&points);
    assert!(hull.vertices.len() <= 64 && hull.vertices.len() >= 50);

    let sphere: Vec<Vec3> = (0..100_000).map(|_| random.direction()).collect();
    assert_eq!(build(&sphere).unwrap_err(), HullError::TooManyVertices);
}

#[test]
fn refuses_what_has_no_hull() {
    let cube = cube_corners(Vec3::ONE);
    let with = |i: usize, p: Vec3| {
        let mut points = cube.clone();
        points[i] = p;
        build(&points).map(|_| ())
    };
    assert_eq!(with(5, Vec3::NAN), Err(HullError::NotFinite { index: 5 }));
    assert_eq!(with(2, Vec3::new(0.0, f32::INFINITY, 0.0)), Err(HullError::NotFinite { index: 2 }));
    assert_eq!(with(2, Vec3::new(0.0, 1.0e6, 0.0)), Err(HullError::TooLarge));
    assert_eq!(with(2, Vec3::splat(f32::MAX)), Err(HullError::TooLarge));
    let err = |points: &[Vec3]| build(points).unwrap_err();
    assert_eq!(err(&[]), HullError::TooFewPoints);
    assert_eq!(err(&cube[..3]), HullError::TooFewPoints);
    assert_eq!(err(&[Vec3::ONE; 9]), HullError::TooSmall);
    assert_eq!(err(&[Vec3::ZERO, Vec3::X, Vec3::X * 2.0, Vec3::X * 3.0]), HullError::Flat);
    assert_eq!(err(&[Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::ONE - Vec3::Z]), HullError::Flat);
    let tiny: Vec<Vec3> = cube.iter().map(|p| *p * 1.0e-6).collect();
    assert_eq!(err(&tiny), HullError::TooSmall);
    let sliver: Vec<Vec3> = cube.iter().map(|p| *p * Vec3::new(1.0, 1.0, 1.0e-6)).collect();
    assert_eq!(err(&sliver), HullError::Flat);
    let thin: Vec<Vec3> = cube.iter().map(|p| *p * Vec3::new(1.0, 1.0, 1.0e-3)).collect();
    assert_eq!(shape(&check(&thin)), (8, 6, 12));
}

#[test]
fn sizes_from_a_millimetre_to_ten_kilometres() {
    for size in [1.0e-3, 1.0, 1.0e2, 1.0e4] {
        let mut random = Random(6);
        let points: Vec<Vec3> = (0..30).map(|_| random.direction() * size).collect();
        check(&points);
    }
}
