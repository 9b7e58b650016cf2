//! Shapes on meshes: what must be felt, and what must not.

extern crate std;
use super::*;
use crate::collide::tree::{self, Tree};
use crate::collide::{MANIFOLDS_MAX, POINTS_MAX, hull};
use crate::math::{PI, Rotation, atan2, cos, length, max, min, sin};
use std::vec;
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

    fn rotation(&mut self) -> Rotation {
        Rotation::new(self.next() - 0.5, self.next() - 0.5, self.next() - 0.5, self.next() - 0.5).normalized()
    }
}

struct Owned {
    vertices: Vec<Vec3>,
    triangles: Vec<Triangle>,
    nodes: Vec<Aabb>,
    order: Vec<u32>,
}

impl Owned {
    fn new(vertices: Vec<Vec3>, indices: &[[u32; 3]]) -> Self {
        let n = indices.len();
        let mut triangles: Vec<Triangle> =
            indices.iter().map(|&vertices| Triangle { vertices, across: [u32::MAX; 3] }).collect();
        let mut scratch = vec![0; scratch_len(n)];
        validate(&vertices, &triangles, &mut scratch).unwrap();
        connect(&vertices, &mut triangles, &mut scratch);
        let boxes: Vec<Aabb> = triangles.iter().map(|t| triangle_box(&vertices, t)).collect();
        let (mut order, mut nodes) = (vec![0; n], vec![Aabb::EMPTY; tree::node_count(n)]);
        tree::build(&boxes, 0..n as u32, &mut scratch, &mut order, &mut nodes);
        Self { vertices, triangles, nodes, order }
    }

    fn collide(&self, b: &Solid<'_>, pose: &Pose, distance: f32) -> Manifolds {
        let tree = Tree { nodes: &self.nodes, order: &self.order };
        let mesh = Mesh { vertices: &self.vertices, triangles: &self.triangles, tree, surfaces: &[] };
        let mut out = Manifolds::new();
        super::collide(&Triangles::Mesh(&mesh), b, pose, distance, &mut out);
        check(&out, distance);
        out
    }
}

fn deepest(manifold: &crate::collide::Manifold) -> f32 {
    crate::collide::triangle::deepest(&manifold.points)
}

/// What every result must be.
fn check(out: &Manifolds, distance: f32) {
    for pair in out.windows(2) {
        assert!(pair[0].child < pair[1].child);
    }
    for m in out {
        assert!((length(m.normal) - 1.0).abs() < 1.0e-5);
        assert!(!m.points.is_empty());
        for (i, p) in m.points.iter().enumerate() {
            assert!(p.position.is_finite() && p.separation <= distance);
            assert!(m.points[..i].iter().all(|q| q.feature != p.feature));
        }
    }
}

/// An n x n grid around the origin with random diagonals and windings; heights by place.
fn grid(n: u32, cell: f32, height: impl Fn(f32, f32) -> f32) -> Owned {
    let mut random = Random(7);
    let mut vertices = Vec::new();
    for i in 0..=n {
        for j in 0..=n {
            let [x, y] = [i, j].map(|k| (k as f32 - 0.5 * n as f32) * cell);
            vertices.push(Vec3::new(x, y, height(x, y)));
        }
    }
    let mut indices = Vec::new();
    for i in 0..n {
        for j in 0..n {
            let [a, b, c, d] = [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(x, y)| (i + x) * (n + 1) + j + y);
            let halves = if random.next() < 0.5 { [[a, b, c], [a, c, d]] } else { [[b, c, d], [b, d, a]] };
            for [a, b, c] in halves {
                indices.push(if random.next() < 0.5 { [a, b, c] } else { [b, a, c] });
            }
        }
    }
    Owned::new(vertices, &indices)
}

fn yaw(angle: f32) -> Rotation {
    Rotation::from_rotation_vector(Vec3::Z * angle)
}

/// Two quads: from the y axis to the left and to the right, rising by the angles.
fn fold(left: f32, right: f32) -> Owned {
    let arm = |angle: f32, sign: f32| Vec3::new(sign * cos(angle), 0.0, sin(angle)) * 4.0;
    let (l, r, y) = (arm(left, -1.0), arm(right, 1.0), Vec3::Y * 4.0);
    let vertices = vec![-y, y, l - y, l + y, r - y, r + y];
    Owned::new(vertices, &[[0, 1, 3], [0, 3, 2], [0, 1, 5], [5, 0, 4]])
}

#[test]
fn a_box_on_a_flat_grid_feels_only_the_floor() {
    let floor = grid(16, 0.25, |_, _| 0.0);
    let half = Vec3::new(0.5, 0.3, 0.2);
    let mut random = Random(1);
    for round in 0..500 {
        let side = if round % 2 == 0 { 1.0 } else { -1.0 };
        let turn = if round % 5 == 0 { Rotation::IDENTITY } else { yaw(random.next() * 7.0) };
        let (sunk, distance) = if round % 3 == 0 { (-0.005, 0.02) } else { (0.001, 0.02) };
        // On the lines of the grid, too.
        let snap = |x: f32| if round % 7 == 0 { (x * 4.0).round() / 4.0 } else { x };
        let [x, y] = [random.next(), random.next()].map(|r| snap(2.4 * r - 1.2));
        let pose = Pose::new(Vec3::new(x, y, side * (half.z - sunk)), turn);
        let out = floor.collide(&Solid::Box { half_extents: half }, &pose, distance);
        assert_eq!(out.len(), 1, "round {round} {out:?}");
        assert_eq!(out[0].normal, Vec3::Z * side);
        for p in &out[0].points {
            assert!((p.separation + sunk).abs() < 1.0e-5, "{p:?}");
            assert!((p.position.z + 0.5 * side * sunk).abs() < 1.0e-5, "{p:?}");
        }
        for (i, j) in [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)] {
            let corner = pose.transform(half * Vec3::new(i, j, -side));
            let near = |p: &crate::collide::ManifoldPoint| length(p.position - corner) < 0.01;
            assert!(out[0].points.iter().any(near), "round {round} misses {corner} {out:?}");
        }
    }
}

#[test]
fn a_deep_box_is_pushed_up() {
    let floor = grid(20, 0.2, |_, _| 0.0);
    let mut random = Random(2);
    for round in 0..400 {
        // Smaller than a cell, and larger.
        let size = [0.02, 0.15, 0.6][round % 3];
        let sunk = 0.8 * random.next() * size;
        let pose = Pose::new(
            Vec3::new(random.next() - 0.5, random.next() - 0.5, size - sunk),
            yaw(random.next() * 7.0),
        );
        let out = floor.collide(&Solid::Box { half_extents: Vec3::splat(size) }, &pose, 0.01);
        assert_eq!(out.len(), 1, "round {round} {out:?}");
        assert_eq!(out[0].normal, Vec3::Z);
        assert!((deepest(&out[0]) + sunk).abs() < 1.0e-5 + 1.0e-3 * sunk, "{sunk} {out:?}");
    }
}

#[test]
fn a_ball_rolls_over_a_grid_as_over_a_plane() {
    let floor = grid(16, 0.25, |_, _| 0.0);
    let mut random = Random(3);
    for round in 0..3000 {
        let side = if round % 2 == 0 { 1.0 } else { -1.0 };
        let height = 0.3 + 0.04 * (random.next() - 0.5);
        let snap = |x: f32| if round % 3 == 0 { (x * 4.0).round() / 4.0 } else { x };
        let [x, y] = [random.next(), random.next()].map(|r| snap(2.8 * r - 1.4));
        let center = Vec3::new(x, y, side * height);
        let pose = Pose::new(center, random.rotation());
        let out = floor.collide(&Solid::Sphere { radius: 0.3 }, &pose, 0.03);
        assert_eq!((out.len(), out[0].points.len()), (1, 1));
        let point = out[0].points[0];
        assert_eq!(out[0].normal, Vec3::Z * side);
        assert!((point.separation - (height - 0.3)).abs() < 1.0e-6);
        assert!(length(point.position.with_z(0.0) - center.with_z(0.0)) < 1.0e-6);
    }
}

#[test]
fn a_capsule_lies_on_its_two_ends() {
    let floor = grid(16, 0.25, |_, _| 0.0);
    let mut random = Random(4);
    let solid = Solid::Capsule { half_height: 0.6, radius: 0.2 };
    for round in 0..500 {
        let side = if round % 2 == 0 { 1.0 } else { -1.0 };
        let lying = yaw(random.next() * 7.0).after(Rotation::between(Vec3::Z, Vec3::X));
        let sunk = 0.004 * random.next() - 0.002;
        let center = Vec3::new(random.next() - 0.5, random.next() - 0.5, side * (0.2 - sunk));
        let pose = Pose::new(center, lying);
        let out = floor.collide(&solid, &pose, 0.02);
        assert_eq!((out.len(), out[0].points.len()), (1, 2), "round {round} {out:?}");
        assert_eq!(out[0].normal, Vec3::Z * side);
        for end in [-0.6, 0.6] {
            let end = pose.transform(Vec3::Z * end);
            let near = |p: &crate::collide::ManifoldPoint| length((p.position - end).with_z(0.0)) < 0.005;
            assert!(out[0].points.iter().any(near), "{out:?}");
        }
        assert!(out[0].points.iter().all(|p| (p.separation + sunk).abs() < 1.0e-5));
        // Standing on its head it has one.
        let upright = Pose::new(Vec3::new(center.x, center.y, side * (0.8 - sunk)), Rotation::IDENTITY);
        let out = floor.collide(&solid, &upright, 0.02);
        assert_eq!((out.len(), out[0].points.len()), (1, 1), "round {round} {out:?}");
        assert_eq!(out[0].normal, Vec3::Z * side);
    }
}

#[test]
fn inside_of_a_corner_both_walls_are_felt() {
    let corner = fold(0.0, core::f32::consts::FRAC_PI_2);
    let mut random = Random(5);
    for _ in 0..200 {
        let [gap_x, gap_z] = [random.next(), random.next()].map(|r| 0.004 * r - 0.002);
        let at = Vec3::new(-0.5 - gap_x, random.next() - 0.5, 0.5 + gap_z);
        let solids = [
            (Solid::Sphere { radius: 0.5 }, Rotation::IDENTITY),
            (Solid::Box { half_extents: Vec3::splat(0.5) }, Rotation::IDENTITY),
            (Solid::Capsule { half_height: 0.3, radius: 0.5 }, Rotation::between(Vec3::Z, Vec3::Y)),
        ];
        for (solid, turn) in solids {
            let out = corner.collide(&solid, &Pose::new(at, turn), 0.01);
            assert_eq!(out.len(), 2, "{out:?}");
            for (normal, gap) in [(Vec3::Z, gap_z), (Vec3::NEG_X, gap_x)] {
                let wall = out.iter().find(|m| length(m.normal - normal) < 1.0e-6).unwrap();
                assert!((deepest(wall) - gap).abs() < 1.0e-5, "{wall:?}");
            }
        }
    }
}

#[test]
fn a_ridge_is_felt_within_its_cone() {
    let mut random = Random(6);
    for round in 0..600 {
        let angle = 0.1 + random.next();
        let ridge = fold(-angle, -angle);
        let lean = (2.0 * random.next() - 1.0) * 0.8 * angle;
        let up = Vec3::new(sin(lean), 0.0, cos(lean));
        let gap = 0.006 * random.next() - 0.003;
        // A box on its bottom, on the ridge, leaning less than the slopes fall.
        let turn = Rotation::between(Vec3::Z, up);
        let shift = turn.rotate(Vec3::new(random.next() * 0.4 - 0.2, random.next() - 0.5, 0.3 + gap));
        let solids = [
            (Solid::Box { half_extents: Vec3::new(0.4, 0.5, 0.3) }, Pose::new(shift, turn)),
            (Solid::Sphere { radius: 0.3 }, Pose::new(up * (0.3 + gap), turn)),
            (
                Solid::Capsule { half_height: 0.5, radius: 0.3 },
                Pose::new(up * (0.3 + gap), Rotation::between(Vec3::Z, Vec3::Y)),
            ),
        ];
        for (solid, pose) in &solids {
            let out = ridge.collide(solid, pose, 0.01);
            assert!(!out.is_empty());
            for m in &out {
                assert!(m.normal.y.abs() < 1.0e-3);
                assert!(atan2(m.normal.x, m.normal.z).abs() <= angle + 0.011, "round {round} {out:?}");
            }
            let least = out.iter().map(deepest).fold(f32::INFINITY, min);
            assert!((least - gap).abs() < 3.0e-4 + 0.1 * gap.abs(), "round {round} {gap} {out:?}");
        }
    }
}

/// A closed block with its top at z = 0, from -1 to 1; each side of n x n squares.
fn block(n: u32) -> Owned {
    let mut vertices = Vec::new();
    let mut indices = Vec::new();
    for face in 0..6 {
        let first = vertices.len() as u32;
        for i in 0..=n {
            for j in 0..=n {
                let [u, v] = [i, j].map(|k| 2.0 * k as f32 / n as f32 - 1.0);
                let w = if face % 2 == 0 { -1.0 } else { 1.0 };
                let p = [Vec3::new(w, u, v), Vec3::new(v, w, u), Vec3::new(u, v, w)][face / 2];
                vertices.push(p - Vec3::Z);
            }
        }
        for i in 0..n {
            for j in 0..n {
                let [a, b, c, d] =
                    [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(x, y)| first + (i + x) * (n + 1) + j + y);
                indices.extend([[a, b, c], [a, c, d]]);
            }
        }
    }
    Owned::new(vertices, &indices)
}

#[test]
fn on_a_ledge_the_wall_below_does_not_push() {
    let mut random = Random(8);
    for round in 0..9000 {
        let ledge = block(1 + 2 * (round % 3));
        let half = [Vec3::new(0.5, 0.4, 0.3), Vec3::new(0.05, 0.4, 0.3), Vec3::new(0.5, 0.5, 0.02)]
            [round as usize / 3 % 3];
        // Over the ledge with a part of its width, on either side of the middle, or about to reach it.
        let overhang = if round % 5 == 0 { -1.0 - 0.01 * random.next() } else { 1.2 * random.next() - 0.8 };
        let x = 1.0 + overhang * half.x;
        let sunk = 0.002 * random.next();
        let tilt = Rotation::from_rotation_vector(random.vector() * 0.004);
        let turn = tilt.after(if round % 2 == 0 { Rotation::IDENTITY } else { yaw(0.02 * random.next()) });
        let pose = Pose::new(Vec3::new(x, random.next() - 0.5, half.z - sunk), turn);
        let out = ledge.collide(&Solid::Box { half_extents: half }, &pose, 0.005);
        assert!(!out.is_empty());
        for m in &out {
            assert!(m.normal.z > 0.99, "round {round} {pose:?} {out:?}");
            assert!(deepest(m) > -0.01, "round {round} {out:?}");
        }
    }
}

#[test]
fn hills_hold_a_ball_and_a_box_at_their_true_depth() {
    let hills = |x: f32, y: f32| 0.04 * (sin(5.0 * x) + cos(4.0 * y + x));
    let ground = grid(24, 0.17, hills);
    let mut random = Random(11);
    for round in 0..300 {
        let [x, y] = [random.next(), random.next()].map(|r| 1.6 * r - 0.8);
        // The depth of a ball is the least over the triangles one by one: no contact that counts may be judged
        // away.
        let radius = [0.03, 0.1, 0.4][round % 3];
        let center = Vec3::new(x, y, hills(x, y) + radius + 0.004 * random.next());
        let out = ground.collide(&Solid::Sphere { radius }, &Pose::new(center, Rotation::IDENTITY), 0.02);
        let alone = ground.triangles.iter().filter_map(|t| {
            let one = Owned::new(t.vertices.map(|v| ground.vertices[v as usize]).to_vec(), &[[0, 1, 2]]);
            let out = one.collide(&Solid::Sphere { radius }, &Pose::new(center, Rotation::IDENTITY), 0.02);
            out.first().map(deepest)
        });
        let least = alone.fold(f32::INFINITY, min);
        let found = out.iter().map(deepest).fold(f32::INFINITY, min);
        assert!((found - least).abs() < 1.0e-4 * max(radius, 0.1), "round {round} {found} {least} {out:?}");

        // A level box sinks by what the highest ground under it rises above its bottom.
        let half = Vec3::new(0.4, 0.3, 0.2);
        let turn = yaw(random.next() * 7.0);
        let mut top = f32::NEG_INFINITY;
        for triangle in &ground.triangles {
            let [a, b, c] = triangle.vertices.map(|v| ground.vertices[v as usize]);
            for i in 0..=24 * 24 {
                let (u, v) = ((i / 24) as f32 / 24.0, (i % 24) as f32 / 24.0);
                let p = a + (b - a) * u + (c - a) * v;
                let local = turn.unrotate(p - Vec3::new(x, y, 0.0)).abs();
                if u + v <= 1.0 && local.x < half.x && local.y < half.y {
                    top = max(p.z, top);
                }
            }
        }
        let pose = Pose::new(Vec3::new(x, y, top - 0.002 + half.z), turn);
        let out = ground.collide(&Solid::Box { half_extents: half }, &pose, 0.01);
        let found = out.iter().map(deepest).fold(f32::INFINITY, min);
        // Between samples the ground is a little higher; where a face takes the place of an edge, lower.
        assert!((-0.004..-0.0014).contains(&found), "round {round} {found} {out:?}");
        assert!(out.iter().all(|m| m.normal.z > 0.85), "round {round} {out:?}");
    }
}

#[test]
fn winding_does_not_matter() {
    let mut random = Random(9);
    let hills = |x: f32, y: f32| 0.2 * (sin(3.0 * x) + cos(2.0 * y + x));
    let one = grid(12, 0.25, hills);
    let flipped: Vec<[u32; 3]> =
        one.triangles.iter().map(|t| t.vertices).map(|[a, b, c]| [a, c, b]).collect();
    let other = Owned::new(one.vertices.clone(), &flipped);
    for _ in 0..300 {
        let pose = Pose::new(random.vector() * Vec3::new(1.0, 1.0, 0.5), random.rotation());
        let solid = Solid::Box { half_extents: Vec3::new(0.3, 0.2, 0.1) };
        let (a, b) = (one.collide(&solid, &pose, 0.05), other.collide(&solid, &pose, 0.05));
        assert_eq!(a.len(), b.len());
        for (a, b) in a.iter().zip(&b) {
            assert_eq!(a.child, b.child);
            assert!(length(a.normal - b.normal) < 1.0e-4, "{a:?} {b:?}");
            assert!((deepest(a) - deepest(b)).abs() < 1.0e-4, "{a:?} {b:?}");
        }
    }
}

#[test]
fn far_from_the_origin_a_contact_is_as_fine() {
    let far = Vec3::new(8192.0, -4096.0, 2048.0);
    let mut floor = grid(8, 0.5, |_, _| 0.0);
    let vertices: Vec<Vec3> = floor.vertices.iter().map(|&v| v + far).collect();
    let indices: Vec<[u32; 3]> = floor.triangles.iter().map(|t| t.vertices).collect();
    floor = Owned::new(vertices, &indices);
    let pose = Pose::new(far + Vec3::new(0.25, 0.125, 0.25 - 0.001_953_125), yaw(0.3));
    let out = floor.collide(&Solid::Box { half_extents: Vec3::splat(0.25) }, &pose, 0.01);
    assert_eq!((out.len(), out[0].points.len()), (1, 4));
    assert_eq!(out[0].normal, Vec3::Z);
    for p in &out[0].points {
        assert!((p.separation + 0.001_953_125).abs() < 1.0e-6, "{p:?}");
    }
}

#[test]
fn soup_gives_finite_results() {
    let mut random = Random(10);
    let mut touched = 0;
    for _ in 0..60 {
        let vertices: Vec<Vec3> = (0..90).map(|_| random.vector()).collect();
        let indices: Vec<[u32; 3]> =
            (0..30).map(|i| [3 * i, 3 * i + 1, if i % 2 == 0 { 3 * i + 2 } else { 3 * i - 1 }]).collect();
        let soup = Owned::new(vertices, &indices);
        let points: Vec<Vec3> = (0..20).map(|_| random.vector() * 0.4).collect();
        let tables = hull::build(&points).unwrap();
        let solids = [
            Solid::Sphere { radius: 0.3 },
            Solid::Capsule { half_height: 0.3, radius: 0.1 },
            Solid::Box { half_extents: Vec3::new(0.3, 0.2, 0.1) },
            Solid::Hull(tables.view()),
        ];
        for solid in &solids {
            for _ in 0..20 {
                let out = soup.collide(solid, &Pose::new(random.vector(), random.rotation()), 0.05);
                assert!(out.len() <= MANIFOLDS_MAX);
                touched += out.len();
            }
        }
    }
    assert!(touched > 5000);
}

#[test]
fn more_directions_than_manifolds_keep_the_deepest() {
    // A sphere of triangles seen from inside, a box in its middle.
    let mut vertices = vec![Vec3::Z, Vec3::NEG_Z];
    let (rings, sides) = (9, 16);
    for ring in 1..rings {
        for side in 0..sides {
            let (a, b) = (ring as f32 * PI / rings as f32, side as f32 * 2.0 * PI / sides as f32);
            vertices.push(Vec3::new(sin(a) * cos(b), sin(a) * sin(b), cos(a)));
        }
    }
    let at = |ring: u32, side: u32| 2 + (ring - 1) * sides + side % sides;
    let mut indices = Vec::new();
    for side in 0..sides {
        indices.push([0, at(1, side), at(1, side + 1)]);
        indices.push([1, at(rings - 1, side), at(rings - 1, side + 1)]);
        for ring in 1..rings - 1 {
            indices.push([at(ring, side), at(ring + 1, side), at(ring + 1, side + 1)]);
            indices.push([at(ring, side), at(ring + 1, side + 1), at(ring, side + 1)]);
        }
    }
    let shell = Owned::new(vertices, &indices);
    let points: Vec<Vec3> = (0..60)
        .map(|i| {
            let z = 1.0 - (2 * i + 1) as f32 / 60.0;
            let (s, a) = ((1.0 - z * z).sqrt(), 2.4 * i as f32);
            Vec3::new(s * cos(a), s * sin(a), z) * 0.98
        })
        .collect();
    let tables = hull::build(&points).unwrap();
    let all = shell.collide(&Solid::Hull(tables.view()), &Pose::IDENTITY, 0.3);
    assert_eq!(all.len(), MANIFOLDS_MAX);
    for m in &all {
        // Each pushes inwards, from where it is.
        assert!(m.points.len() <= POINTS_MAX);
        assert!(m.normal.dot(m.points[0].position) < 0.0, "{m:?}");
    }
    let ball =
        shell.collide(&Solid::Sphere { radius: 0.9 }, &Pose::new(Vec3::Z * 0.15, Rotation::IDENTITY), 0.0);
    assert!(!ball.is_empty() && ball.iter().all(|m| m.normal.z < 0.0 && m.points.len() == 1));
}

/// A height field touches where the mesh of its triangles does.
#[test]
fn height_fields_touch_like_the_mesh_of_their_triangles() {
    let mut random = Random(11);
    let heights: Vec<f32> = (0..49).map(|_| 0.6 * random.next()).collect();
    let mut cells = [0; 36];
    cells[14] = super::super::height_field::HOLE;
    let field = HeightField {
        columns: 7,
        rows: 7,
        spacing: [0.7, 0.5],
        heights: &heights,
        cells: &cells,
        has_surfaces: false,
        range: [0.0, 0.6],
    };
    assert!(super::super::height_field::validate(&field, 0).is_ok());
    let place = |i: usize| Vec3::new((i % 7) as f32 * 0.7, (i / 7) as f32 * 0.5, heights[i]);
    let vertices: Vec<Vec3> = (0..49).map(place).collect();
    let cell = |c: u32| {
        let a = c / 6 * 7 + c % 6;
        [[a, a + 1, a + 8], [a, a + 8, a + 7]]
    };
    let indices: Vec<[u32; 3]> = (0..36).filter(|&c| c != 14).flat_map(cell).collect();
    let mesh = Owned::new(vertices, &indices);
    let solids = [
        Solid::Sphere { radius: 0.3 },
        Solid::Capsule { half_height: 0.3, radius: 0.2 },
        Solid::Box { half_extents: Vec3::new(0.4, 0.3, 0.2) },
        Solid::Cylinder { half_height: 0.3, radius: 0.3 },
        Solid::Cone { half_height: 0.4, radius: 0.3 },
    ];
    let mut touched = 0;
    for solid in &solids {
        for _ in 0..200 {
            let at =
                Vec3::new(4.6 * random.next() - 0.2, 3.4 * random.next() - 0.2, 1.2 * random.next() - 0.2);
            let pose = Pose::new(at, random.rotation());
            let mut found = Manifolds::new();
            collide(&Triangles::HeightField(&field), solid, &pose, 0.05, &mut found);
            check(&found, 0.05);
            let expected = mesh.collide(solid, &pose, 0.05);
            // Triangles are visited in another order and have other names, which only decides among equals.
            let deepest = |m: &Manifolds| {
                m.iter().flat_map(|m| &m.points).fold(f32::INFINITY, |least, p| min(p.separation, least))
            };
            assert_eq!(found.is_empty(), expected.is_empty(), "{solid:?} {pose:?}");
            if !found.is_empty() {
                let (a, b) = (deepest(&found), deepest(&expected));
                assert!((a - b).abs() < 1.0e-6, "{solid:?} {pose:?}: {found:?} {expected:?}");
                touched += 1;
            }
        }
    }
    assert!(touched > 300, "{touched}");
}

/// Lying, standing and rolling shapes on a grid of triangles feel one plane, wherever the edges run.
#[test]
fn curved_shapes_on_a_grid_touch_a_plane() {
    let (mut vertices, mut indices) = (Vec::new(), Vec::new());
    for i in 0..121_u32 {
        vertices.push(Vec3::new((i % 11) as f32 * 0.37 - 1.8, (i / 11) as f32 * 0.31 - 1.5, 0.0));
        if i % 11 < 10 && i / 11 < 10 {
            indices.extend([[i, i + 1, i + 12], [i, i + 12, i + 11]]);
        }
    }
    let mesh = Owned::new(vertices, &indices);
    let mut random = Random(3);
    let (h, r) = (0.4_f32, 0.25_f32);
    let lean = atan2(r, 2.0 * h);
    let rests = [
        (Solid::Cylinder { half_height: h, radius: r }, h, 0.0),
        (Solid::Cylinder { half_height: h, radius: r }, r, 0.5 * PI),
        (Solid::Cone { half_height: h, radius: r }, h, 0.0),
        (Solid::Cone { half_height: h, radius: r }, h * sin(lean), 0.5 * PI + lean),
        (Solid::Cone { half_height: h, radius: r }, h, PI),
    ];
    for (solid, height, turn) in rests {
        for _ in 0..200 {
            let about = Rotation::from_axis_angle(Vec3::Z, 6.3 * random.next());
            let own = Rotation::from_axis_angle(Vec3::Z, 6.3 * random.next());
            let rotation = about.after(Rotation::from_axis_angle(Vec3::Y, turn)).after(own);
            let sink = 0.01 * random.next() - 0.005;
            let at = Vec3::new(random.next() - 0.5, random.next() - 0.5, height + sink);
            let found = mesh.collide(&solid, &Pose::new(at, rotation), 0.02);
            assert_eq!(found.len(), 1, "{solid:?} {at}: {found:?}");
            assert!(length(found[0].normal - Vec3::Z) < 1.0e-5, "{solid:?} {at}: {found:?}");
            let least = found[0].points.iter().fold(f32::INFINITY, |least, p| min(p.separation, least));
            assert!((least - sink).abs() < 2.0e-6, "{solid:?} {at}: {found:?}");
        }
    }
}
