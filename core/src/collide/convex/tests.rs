//! Every pair of convex shapes against oracles in f64, at three sizes.

use super::*;
use crate::collide::clip::face_loop;
use crate::collide::{Edge, Face, HULL_EDGES_MAX, ManifoldPoint, Plane};
use crate::math::{PI, Rotation, length};

type V = [f64; 3];
const SIZES: [f32; 3] = [1.0e-3, 1.0, 1.0e4];

fn wide(v: Vec3) -> V {
    [f64::from(v.x), f64::from(v.y), f64::from(v.z)]
}
fn sub(a: V, b: V) -> V {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}
fn along(a: V, b: V, t: f64) -> V {
    [a[0] + (b[0] - a[0]) * t, a[1] + (b[1] - a[1]) * t, a[2] + (b[2] - a[2]) * t]
}
fn dot(a: V, b: V) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
fn cross(a: V, b: V) -> V {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}
fn norm(a: V) -> f64 {
    libm::sqrt(dot(a, a))
}

/// Numbers in 0..1 from a fixed seed.
struct Dice(u64);

impl Dice {
    fn roll(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f32 / 16_777_216.0
    }
    fn range(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * self.roll()
    }
    fn vector(&mut self, low: f32, high: f32) -> Vec3 {
        Vec3::new(self.range(low, high), self.range(low, high), self.range(low, high))
    }
    /// A third of the poses are turned by right angles or little more.
    fn pose(&mut self, reach: f32) -> Pose {
        let mut turn = self.vector(-3.0, 3.0);
        if self.roll() < 0.33 {
            turn = Vec3::AXES[(self.roll() * 3.0) as usize] * (0.5 * PI);
            turn += self.vector(-1.0, 1.0) * if self.roll() < 0.5 { 0.0 } else { 1.0e-3 };
        }
        Pose::new(self.vector(-reach, reach), Rotation::from_rotation_vector(turn))
    }
}

/// A hull made of faces; edges and planes are derived.
struct Tables {
    vertices: heapless::Vec<Vec3, 64>,
    planes: heapless::Vec<Plane, 124>,
    faces: heapless::Vec<Face, 124>,
    loops: heapless::Vec<u8, 744>,
    edges: heapless::Vec<Edge, HULL_EDGES_MAX>,
}

impl Tables {
    fn new(vertices: &[Vec3], loops: &[&[u8]]) -> Self {
        let vertices = heapless::Vec::from_slice(vertices).unwrap();
        let (planes, faces, edges) = (heapless::Vec::new(), heapless::Vec::new(), heapless::Vec::new());
        let mut tables = Self { vertices, planes, faces, loops: heapless::Vec::new(), edges };
        for face in loops {
            let [a, b, c] = [0, 1, 2].map(|i| tables.vertices[usize::from(face[i])]);
            let normal = (b - a).cross(c - b);
            let normal = normal / length(normal);
            tables.planes.push(Plane { normal, offset: normal.dot(a) }).unwrap();
            let first = tables.loops.len() as u16;
            tables.faces.push(Face { first, count: face.len() as u16 }).unwrap();
            tables.loops.extend_from_slice(face).unwrap();
        }
        let runs = |f: &[u8], t: u8, h: u8| (0..f.len()).any(|i| f[i] == t && f[(i + 1) % f.len()] == h);
        for (left, face) in loops.iter().enumerate() {
            for (i, &tail) in face.iter().enumerate() {
                let head = face[(i + 1) % face.len()];
                let right = loops.iter().position(|other| runs(other, head, tail)).unwrap();
                if left < right {
                    let edge = Edge { tail, head, left: left as u8, right: right as u8 };
                    tables.edges.push(edge).unwrap();
                }
            }
        }
        tables
    }

    fn octahedron(h: Vec3) -> Self {
        let (x, y, z) = (Vec3::X * h.x, Vec3::Y * h.y, Vec3::Z * h.z);
        let loops: [&[u8]; 8] =
            [&[0, 2, 4], &[2, 1, 4], &[1, 3, 4], &[3, 0, 4], &[2, 0, 5], &[1, 2, 5], &[3, 1, 5], &[0, 3, 5]];
        Self::new(&[x, -x, y, -y, z, -z], &loops)
    }

    fn prism(h: Vec3) -> Self {
        let ring = [(1.0, 0.0), (0.5, 0.8), (-0.5, 0.8), (-1.0, 0.0), (-0.5, -0.8), (0.5, -0.8)];
        let mut vertices = [Vec3::ZERO; 12];
        for (i, (x, y)) in ring.into_iter().enumerate() {
            vertices[i] = Vec3::new(x, y, -1.0) * h;
            vertices[i + 6] = Vec3::new(x, y, 1.0) * h;
        }
        let loops: [&[u8]; 8] = [
            &[5, 4, 3, 2, 1, 0],
            &[6, 7, 8, 9, 10, 11],
            &[0, 1, 7, 6],
            &[1, 2, 8, 7],
            &[2, 3, 9, 8],
            &[3, 4, 10, 9],
            &[4, 5, 11, 10],
            &[5, 0, 6, 11],
        ];
        Self::new(&vertices, &loops)
    }

    fn hull(&self) -> Hull<'_> {
        Hull {
            vertices: &self.vertices,
            planes: &self.planes,
            faces: &self.faces,
            loops: &self.loops,
            edges: &self.edges,
            center: Vec3::ZERO,
        }
    }
}

fn contacts(a: &Solid<'_>, b: &Solid<'_>, pose: &Pose, distance: f32) -> Option<Manifold> {
    let mut out = Manifolds::new();
    collide(a, b, pose, distance, &mut out);
    assert!(out.len() < 2);
    let manifold = out.pop()?;
    check(&manifold, distance);
    Some(manifold)
}

fn check(m: &Manifold, distance: f32) {
    assert!((length(m.normal) - 1.0).abs() < 1.0e-5 && m.child == 0 && !m.points.is_empty(), "{m:?}");
    for (i, p) in m.points.iter().enumerate() {
        assert!(p.position.is_finite() && p.separation <= distance, "{m:?}");
        assert!(m.points[..i].iter().all(|q| q.feature != p.feature), "{m:?}");
    }
}

fn deepest(m: &Manifold) -> f32 {
    m.points.iter().fold(f32::INFINITY, |s, p| crate::math::min(p.separation, s))
}

/// Distance of the hulls' projections on a unit axis, from A to B.
fn projected(a: &Hull<'_>, b: &Hull<'_>, n: V) -> f64 {
    let top = a.vertices.iter().fold(f64::MIN, |h, &v| h.max(dot(wide(v), n)));
    b.vertices.iter().fold(f64::MAX, |h, &v| h.min(dot(wide(v), n))) - top
}

/// The greatest separation over all axes, and the greatest of any other axis.
fn oracle(a: &Hull<'_>, b: &Hull<'_>) -> (f64, f64) {
    let (mut best, mut best_axis, mut second) = (f64::MIN, [0.0; 3], f64::MIN);
    for round in 0..2 {
        let mut visit = |n: V| {
            let size = norm(n);
            for sign in [1.0, -1.0] {
                let n = n.map(|x| x * sign / size);
                let s = projected(a, b, n);
                if round == 0 && s > best {
                    (best, best_axis) = (s, n);
                }
                if round == 1 && s > second && norm(sub(n, best_axis)) > 5.0e-5 {
                    second = s;
                }
            }
        };
        for plane in a.planes.iter().chain(b.planes) {
            visit(wide(plane.normal));
        }
        for ea in a.edges {
            for eb in b.edges {
                let span = |h: &Hull<'_>, e: &Edge| {
                    sub(wide(h.vertices[usize::from(e.head)]), wide(h.vertices[usize::from(e.tail)]))
                };
                let (da, db) = (span(a, ea), span(b, eb));
                let n = cross(da, db);
                if norm(n) > 1.0e-3 * norm(da) * norm(db) {
                    visit(n);
                }
            }
        }
    }
    (best, second)
}

/// A pair of polytopes as solids and as hulls.
fn check_polytopes(a: (&Solid<'_>, &Hull<'_>), b: (&Solid<'_>, &Hull<'_>), pose: &Pose, size: f32) -> bool {
    let distance = 0.05 * size;
    let placed = Placed::new(b.1, pose);
    let moved = placed.hull();
    let (best, second) = oracle(a.1, &moved);
    let tiny = 3.0e-4 * f64::from(size);
    let there = contacts(a.0, b.0, pose, distance);
    let back = contacts(b.0, a.0, &pose.inverse(), distance);
    let Some(m) = there else {
        // The closest points may be farther than any axis tells, but never where shapes overlap.
        assert!(best > f64::from(distance) - tiny || best > 0.0, "missed {best} {pose:?}");
        return false;
    };
    let margin = tiny + 0.06 * best.abs() + 0.005 * f64::from(size);
    let along = projected(a.1, &moved, wide(m.normal));
    let depth = f64::from(deepest(&m));
    // A face may stand for shapes that are apart; then its points are no nearer than the shapes.
    let value = if best > 0.0 { depth } else { along };
    assert!(value > best - margin, "{value} {best} {pose:?} {m:?}");
    assert!(best > 0.0 || along < best + tiny, "{along} {best} {pose:?} {m:?}");
    assert!(depth > along - tiny, "{depth} {along} {m:?}");
    for p in &m.points {
        // The slack at the sides of the reference face.
        let reach = 0.5 * p.separation.abs() + 0.0015 * size;
        let inside = |h: &Hull<'_>| h.planes.iter().all(|plane| plane.distance(p.position) <= reach);
        assert!(best > 0.0 || inside(a.1) && inside(&moved), "{p:?}");
    }
    if best - second > 3.0 * margin && best < 0.0 {
        let back = back.expect("the other order touches too");
        let normal = -pose.rotation.rotate(back.normal);
        assert!(length(normal - m.normal) < 1.0e-4, "{m:?} {back:?}");
        assert!((deepest(&back) - deepest(&m)).abs() < tiny as f32, "{m:?} {back:?}");
    }
    true
}

#[test]
fn polytopes_agree_with_all_projections() {
    let mut dice = Dice(1);
    let mut touching = 0;
    for i in 0..6000 {
        let size = SIZES[i % 3];
        let (ha, hb) = (dice.vector(0.2, 1.0) * size, dice.vector(0.2, 1.0) * size);
        let (box_a, box_b) = (BoxHull::new(ha), BoxHull::new(hb));
        let (prism, octahedron) = (Tables::prism(ha), Tables::octahedron(hb));
        let (sa, sb) = (Solid::Box { half_extents: ha }, Solid::Box { half_extents: hb });
        let (ta, tb) = (Solid::Hull(prism.hull()), Solid::Hull(octahedron.hull()));
        let pose = dice.pose(1.4 * size);
        let (a, b) = (box_a.hull(), box_b.hull());
        touching += u32::from(check_polytopes((&sa, &a), (&sb, &b), &pose, size));
        check_polytopes((&ta, &prism.hull()), (&tb, &octahedron.hull()), &pose, size);
        check_polytopes((&ta, &prism.hull()), (&sb, &b), &pose, size);
    }
    assert!(touching > 2000, "{touching}");
}

#[test]
fn boxes_agree_with_the_hulls_of_boxes() {
    let mut dice = Dice(2);
    let (mut touching, mut alike) = (0, 0);
    for i in 0..6000 {
        let size = SIZES[i % 3];
        let half = [dice.vector(0.2, 1.0) * size, dice.vector(0.2, 1.0) * size];
        let pose = dice.pose(1.4 * size);
        let (a, b) = (Solid::Box { half_extents: half[0] }, Solid::Box { half_extents: half[1] });
        let (ha, hb) = (BoxHull::new(half[0]), BoxHull::new(half[1]));
        let own = contacts(&a, &b, &pose, 0.05 * size);
        let general = contacts(&Solid::Hull(ha.hull()), &Solid::Hull(hb.hull()), &pose, 0.05 * size);
        let (Some(own), Some(general)) = (own, general) else { continue };
        touching += 1;
        let same = |p: &ManifoldPoint, q: &ManifoldPoint| {
            length(p.position - q.position) < 1.0e-3 * size
                && (p.separation - q.separation).abs() < 1.0e-3 * size
        };
        let all = own.points.iter().all(|p| general.points.iter().any(|q| same(p, q)));
        alike += u32::from(all && own.points.len() == general.points.len());
    }
    // The rest are ties that rounding breaks.
    assert!(touching > 2000 && alike * 100 >= touching * 97, "{alike} of {touching}");
}

fn point_triangle(p: V, [a, b, c]: [V; 3]) -> f64 {
    let n = cross(sub(b, a), sub(c, a));
    let over = [(a, b), (b, c), (c, a)].iter().all(|&(s, t)| dot(cross(sub(t, s), sub(p, s)), n) >= 0.0);
    if over {
        return (dot(sub(p, a), n) / norm(n)).abs();
    }
    [(a, b), (b, c), (c, a)].iter().fold(f64::MAX, |d, &(s, t)| d.min(segments((p, p), (s, t))))
}

/// Distance of two segments: the best of both inside and the four ends.
fn segments((a, b): (V, V), (c, d): (V, V)) -> f64 {
    let point = |p: V, (s, t): (V, V)| {
        let span = dot(sub(t, s), sub(t, s));
        let u = if span > 0.0 { (dot(sub(p, s), sub(t, s)) / span).clamp(0.0, 1.0) } else { 0.0 };
        norm(sub(p, along(s, t, u)))
    };
    let ends = point(a, (c, d)).min(point(b, (c, d))).min(point(c, (a, b))).min(point(d, (a, b)));
    let (u, v, r) = (sub(b, a), sub(d, c), sub(c, a));
    let n = cross(u, v);
    let (s, t) = (dot(cross(r, v), n) / dot(n, n), dot(cross(r, u), n) / dot(n, n));
    let inside = |x: f64| (0.0..=1.0).contains(&x);
    if inside(s) && inside(t) { ends.min(norm(sub(along(a, b, s), along(c, d, t)))) } else { ends }
}

/// Distance of a core from the surface of a hull.
fn surface(hull: &Hull<'_>, (p, q): (V, V)) -> f64 {
    let mut best = f64::MAX;
    for face in 0..hull.faces.len() {
        let corners = face_loop(hull, face);
        let at = |i: usize| wide(hull.vertices[usize::from(corners[i])]);
        for i in 1..corners.len() - 1 {
            let t = [at(0), at(i), at(i + 1)];
            best = best.min(point_triangle(p, t)).min(point_triangle(q, t));
            for k in 0..3 {
                best = best.min(segments((p, q), (t[k], t[(k + 1) % 3])));
            }
        }
    }
    best
}

/// True when no part of a core is inside of a hull.
fn outside(hull: &Hull<'_>, (p, q): (V, V)) -> bool {
    let (mut low, mut high) = (0.0_f64, 1.0_f64);
    for plane in hull.planes {
        let height = |x: V| dot(x, wide(plane.normal)) - f64::from(plane.offset);
        let (hp, hq) = (height(p), height(q));
        if hp > 0.0 && hq > 0.0 {
            return true;
        }
        if hp > 0.0 {
            low = low.max(hp / (hp - hq));
        } else if hq > 0.0 {
            high = high.min(hp / (hp - hq));
        }
    }
    low > high
}

fn check_round((a, hull): (&Solid<'_>, &Hull<'_>), half_height: f32, radius: f32, pose: &Pose) -> bool {
    let b = if half_height > 0.0 { Solid::Capsule { half_height, radius } } else { Solid::Sphere { radius } };
    let distance = 0.1 * radius;
    let core = Segment::new(half_height, radius, pose);
    let core = (wide(core.tail), wide(core.head));
    let tiny = if half_height > 0.0 { 1.2e-3 } else { 2.0e-5 } * f64::from(radius);
    let there = contacts(a, &b, pose, distance);
    let back = contacts(&b, a, &pose.inverse(), distance);
    let apart = surface(hull, core) - f64::from(radius);
    if outside(hull, core) {
        let Some(m) = &there else {
            assert!(apart > f64::from(distance) - tiny, "missed {apart} {pose:?}");
            return false;
        };
        assert!((f64::from(deepest(m)) - apart).abs() < tiny, "{apart} {m:?} {pose:?}");
    } else {
        let m = there.as_ref().expect("the core is inside");
        let moved = [core.0, core.1].map(|x| Vec3::new(x[0] as f32, x[1] as f32, x[2] as f32));
        let point = Hull { vertices: &moved, planes: &[], faces: &[], loops: &[], edges: &[], ..*hull };
        let along = projected(hull, &point, wide(m.normal)) - f64::from(radius);
        // What moves the core out along the normal; no face may need less, but for the margin.
        let best = hull.planes.iter().fold(f64::MIN, |s, p| s.max(projected(hull, &point, wide(p.normal))));
        assert!(along > best - f64::from(radius) - 1.1 * tiny - 0.06 * best.abs(), "{along} {best} {m:?}");
    }
    if let (Some(m), Some(back)) = (there, back) {
        let normal = -pose.rotation.rotate(back.normal);
        assert!((deepest(&m) - deepest(&back)).abs() < tiny as f32);
        let turn = length(normal - m.normal);
        // A core that nearly touches has an ill-conditioned normal, more so along an edge.
        let far = apart + f64::from(radius) > f64::from(2.0e-3 * length(hull.vertices[0]));
        let least = if half_height > 0.0 { 2.0e-3 } else { 1.0e-4 };
        assert!(turn < least || !far, "{m:?} {back:?}");
    }
    true
}

#[test]
fn round_shapes_agree_with_the_distance_to_all_faces() {
    let mut dice = Dice(3);
    let mut touching = 0;
    for i in 0..4000 {
        let size = SIZES[i % 3];
        let half = dice.vector(0.3, 1.0) * size;
        let (box_hull, prism, octahedron) =
            (BoxHull::new(half), Tables::prism(half), Tables::octahedron(half));
        let solid = Solid::Box { half_extents: half };
        let (radius, half_height) = (dice.range(0.1, 0.5) * size, dice.range(0.2, 1.0) * size);
        let pose = dice.pose(1.3 * size);
        for hull in [box_hull.hull(), prism.hull(), octahedron.hull()] {
            touching += u32::from(check_round((&Solid::Hull(hull), &hull), 0.0, radius, &pose));
            touching += u32::from(check_round((&Solid::Hull(hull), &hull), half_height, radius, &pose));
        }
        check_round((&solid, &box_hull.hull()), 0.0, radius, &pose);
        check_round((&solid, &box_hull.hull()), half_height, radius, &pose);
    }
    assert!(touching > 8000, "{touching}");
}

#[test]
fn capsules_agree_with_the_distance_of_their_cores() {
    let mut dice = Dice(4);
    for i in 0..6000 {
        let size = SIZES[i % 3];
        let [ha, ra, hb, rb] = core::array::from_fn(|_| dice.range(0.1, 1.0) * size);
        let pose = dice.pose(1.5 * size);
        let (a, b) = (Segment::new(ha, ra, &Pose::IDENTITY), Segment::new(hb, rb, &pose));
        let apart = segments((wide(a.tail), wide(a.head)), (wide(b.tail), wide(b.head)));
        let apart = apart - f64::from(ra + rb);
        let (a, b) =
            (Solid::Capsule { half_height: ha, radius: ra }, Solid::Capsule { half_height: hb, radius: rb });
        let there = contacts(&a, &b, &pose, 0.1 * size);
        let back = contacts(&b, &a, &pose.inverse(), 0.1 * size);
        let Some(m) = there else {
            assert!(apart > f64::from(0.0989 * size), "{apart}");
            continue;
        };
        assert!((f64::from(deepest(&m)) - apart).abs() < 1.1e-3 * f64::from(size), "{apart} {m:?}");
        if let Some(back) = back {
            let turn = length(m.normal + pose.rotation.rotate(back.normal));
            assert!(turn < 2.0e-3 || apart + f64::from(ra + rb) < f64::from(1.0e-3 * size), "{m:?} {back:?}");
        }
    }
}

#[test]
fn every_pair_is_finite_at_coincident_and_aligned_poses() {
    let turns =
        [Vec3::ZERO, Vec3::Z * 1.0e-7, Vec3::X * (0.5 * PI), Vec3::new(1.0, 1.0, 0.0), Vec3::Y * (0.25 * PI)];
    for size in SIZES {
        let (prism, octahedron) = (Tables::prism(Vec3::splat(size)), Tables::octahedron(Vec3::splat(size)));
        let solids = [
            Solid::Sphere { radius: size },
            Solid::Capsule { half_height: size, radius: size },
            Solid::Box { half_extents: Vec3::splat(size) },
            Solid::Box { half_extents: Vec3::new(size, size, 0.01 * size) },
            Solid::Hull(prism.hull()),
            Solid::Hull(octahedron.hull()),
        ];
        for a in &solids {
            for b in &solids {
                for turn in turns {
                    for step in 0..27 {
                        let at = Vec3::new((step % 3) as f32, (step / 3 % 3) as f32, (step / 9) as f32)
                            - Vec3::ONE;
                        for reach in [0.0, 1.0e-12, 1.0e-6, 1.0, 2.0] {
                            let pose = Pose::new(at * (size * reach), Rotation::from_rotation_vector(turn));
                            let m = contacts(a, b, &pose, 0.01 * size);
                            assert!(m.is_some() || reach >= 1.0, "{a:?} {b:?} {pose:?}");
                        }
                    }
                }
            }
        }
    }
}

#[test]
fn resting_shapes_have_as_many_points_as_they_stand_on() {
    let cube = Solid::Box { half_extents: Vec3::splat(0.5) };
    let capsule = Solid::Capsule { half_height: 0.5, radius: 0.2 };
    let lying = Rotation::from_rotation_vector(Vec3::X * (0.5 * PI));
    let count = |a: &Solid<'_>, b: &Solid<'_>, position: Vec3, rotation: Rotation| {
        contacts(a, b, &Pose::new(position, rotation), 0.01).map_or(0, |m| m.points.len())
    };
    for turn in [0.0, 0.3, 0.25 * PI] {
        let turn = Rotation::from_rotation_vector(Vec3::Z * turn);
        assert_eq!(count(&cube, &cube, Vec3::Z * 0.999, turn), 4);
        assert_eq!(count(&cube, &capsule, Vec3::Z * 0.699, turn.after(lying)), 2);
    }
    // Beside the upper edge, along it.
    assert_eq!(count(&cube, &capsule, Vec3::new(0.63, 0.0, 0.63), lying), 2);
    assert_eq!(count(&cube, &capsule, Vec3::new(0.0, 0.2, 1.199), Rotation::IDENTITY), 1);
    assert_eq!(count(&capsule, &capsule, Vec3::new(0.39, 0.0, 0.4), Rotation::IDENTITY), 2);
    assert_eq!(count(&capsule, &capsule, Vec3::new(0.0, 0.39, 0.0), lying), 1);
    // Edge over edge, crosswise: the lower about x, the upper about y.
    let lower = Rotation::from_rotation_vector(Vec3::X * (0.25 * PI));
    let upper = Rotation::from_rotation_vector(Vec3::Y * (0.25 * PI));
    let at = lower.unrotate(Vec3::Z * 1.41);
    assert_eq!(count(&cube, &cube, at, lower.inverse().after(upper)), 1);
    assert_eq!(count(&Solid::Sphere { radius: 0.5 }, &cube, Vec3::Z * 1.22, lower), 0);
    assert_eq!(count(&Solid::Sphere { radius: 0.5 }, &cube, Vec3::Z * 0.99, Rotation::IDENTITY), 1);
}

#[test]
fn features_survive_the_noise_of_resting() {
    let mut dice = Dice(5);
    let half = Vec3::splat(0.5);
    let (box_hull, prism) = (BoxHull::new(half), Tables::prism(half));
    let solids = [Solid::Box { half_extents: half }, Solid::Hull(box_hull.hull()), Solid::Hull(prism.hull())];
    for a in &solids {
        for b in &solids {
            for (x, turn) in [(0.0, 0.0), (0.2, 0.0), (0.1, 0.7)] {
                let turn = Rotation::from_rotation_vector(Vec3::Z * turn);
                let at = Vec3::new(x, 0.5 * x, 0.9995);
                let features = |pose: &Pose| {
                    let m = contacts(a, b, pose, 0.01).unwrap();
                    let mut names: heapless::Vec<u32, 4> = m.points.iter().map(|p| p.feature).collect();
                    names.sort_unstable();
                    names
                };
                let still = features(&Pose::new(at, turn));
                for _ in 0..20 {
                    let noise = Rotation::from_rotation_vector(dice.vector(-1.0e-5, 1.0e-5));
                    let pose = Pose::new(at + dice.vector(-1.0e-5, 1.0e-5), noise.after(turn));
                    assert_eq!(features(&pose), still, "{a:?} {b:?} {pose:?}");
                }
            }
        }
    }
}

#[test]
fn flat_hulls_are_touched_by_round_shapes_on_both_sides_and_on_the_border() {
    let corners = [Vec3::new(-2.0, -2.0, 0.0), Vec3::new(2.0, -2.0, 0.0), Vec3::new(0.0, 2.0, 0.0)];
    let triangle = Tables::new(&corners, &[&[0, 1, 2], &[0, 2, 1]]);
    let (ball, bar) = (Solid::Sphere { radius: 0.5 }, Solid::Capsule { half_height: 0.5, radius: 0.2 });
    let triangle = Solid::Hull(triangle.hull());
    let lying = Rotation::from_rotation_vector(Vec3::Y * (0.5 * PI));
    let expect = |b: &Solid<'_>, pose: &Pose, normal: Vec3, (count, separation): (usize, f32)| {
        let m = contacts(&triangle, b, pose, 0.01).unwrap();
        assert!(length(m.normal - normal) < 1.0e-4 && m.points.len() == count, "{m:?}");
        assert!((deepest(&m) - separation).abs() < 1.0e-5, "{m:?}");
    };
    for (z, normal) in [(0.4, Vec3::Z), (-0.4, Vec3::NEG_Z)] {
        expect(&ball, &Pose::new(Vec3::new(0.1, -0.2, z), lying), normal, (1, -0.1));
        expect(&bar, &Pose::new(Vec3::new(0.1, -0.2, 0.4 * z), lying), normal, (2, -0.04));
    }
    // Beside the border, in the plane.
    expect(&ball, &Pose::new(Vec3::new(0.5, -2.4, 0.0), lying), Vec3::NEG_Y, (1, -0.1));
    expect(&bar, &Pose::new(Vec3::new(0.5, -2.1, 0.0), lying), Vec3::NEG_Y, (2, -0.1));
    // Through the triangle near the border: out across the edge, by the core's depth and the radius.
    expect(&bar, &Pose::new(Vec3::new(0.5, -1.9, 0.1), Rotation::IDENTITY), Vec3::NEG_Y, (1, -0.3));
}
