//! Shapes of a world in double precision and world coordinates, for proving what queries tell: distances from
//! closed forms, and by brute force over all faces; nothing of the engine's own collision code.

mod apart;

use crate::oracles::{Wide, cross, dot, minus, norm, plus, turned, wide};
use crate::worlds::OwnedWorld;
use cellstep::collide::height_field::HOLE;
use cellstep::math::{Rotation, Vec3};
use cellstep::{Geometry, ShapeHandle, collide};

/// A convex set, or a half-space.
#[derive(Clone, Debug)]
pub enum Solid {
    /// Center, radius.
    Ball(Wide, f64),
    /// Ends, radius.
    Capsule([Wide; 2], f64),
    /// A polytope.
    Polytope(Polytope),
    /// Outward unit normal, offset.
    HalfSpace(Wide, f64),
    /// A triangle without thickness.
    Triangle([Wide; 3]),
    /// All points within a radius of a polytope.
    Rounded(Polytope, f64),
    /// A cylinder.
    Cylinder(Axial),
    /// A cone: its apex is at the axis' upper end.
    Cone(Axial),
}

/// What a cylinder or cone is.
#[derive(Clone, Copy, Debug)]
pub struct Axial {
    /// The middle of the axis.
    pub center: Wide,
    /// Unit vector.
    pub axis: Wide,
    /// Half of its length.
    pub half: f64,
    /// Of the base.
    pub radius: f64,
}

impl Axial {
    /// Distance from the axis, and height over the middle.
    fn profile(&self, p: Wide) -> [f64; 2] {
        let from = minus(p, self.center);
        let height = dot(from, self.axis);
        [norm(plus(from, self.axis, -height)), height]
    }
}

/// Corners, outward planes and faces.
#[derive(Clone, Debug)]
pub struct Polytope {
    /// Corners.
    pub corners: Vec<Wide>,
    /// Unit normal and offset of each face.
    pub planes: Vec<(Wide, f64)>,
    /// The faces cut into triangles.
    pub triangles: Vec<[Wide; 3]>,
    /// Directions of edges.
    pub edges: Vec<Wide>,
}

/// A part of a shape of the world.
#[derive(Clone, Debug)]
pub struct Part {
    /// The shape.
    pub shape: ShapeHandle,
    /// The triangle of a mesh or height field, or the child of a compound; 0 else.
    pub child: u32,
    /// What it is.
    pub solid: Solid,
}

/// `v` scaled to unit length.
pub fn unit(v: Wide) -> Wide {
    v.map(|x| x / norm(v))
}

/// A convex solid at a place.
fn convex(solid: &collide::Solid<'_>, (position, rotation): (Wide, Rotation)) -> Solid {
    let place = |v: Wide| plus(position, turned(rotation, v), 1.0);
    let polytope = |hull: &collide::Hull<'_>| {
        let corners: Vec<Wide> = hull.vertices.iter().map(|&v| place(wide(v))).collect();
        let loops = hull.faces.iter().map(|face| {
            let run = face.first as usize..(face.first + face.count) as usize;
            hull.loops[run].iter().map(|&i| i as usize).collect::<Vec<_>>()
        });
        Polytope::new(corners, loops)
    };
    let axial = |half: f32, radius: f32| {
        let axis = turned(rotation, [0.0, 0.0, 1.0]);
        Axial { center: position, axis, half: half.into(), radius: radius.into() }
    };
    match *solid {
        collide::Solid::Sphere { radius } => Solid::Ball(position, radius.into()),
        collide::Solid::Capsule { half_height, radius } => {
            let ends = [-half_height, half_height].map(|z| place([0.0, 0.0, z.into()]));
            Solid::Capsule(ends, radius.into())
        }
        collide::Solid::Box { half_extents: h } => {
            let h = wide(h);
            let corner = |i: usize| {
                place(std::array::from_fn(|axis| if i >> axis & 1 == 1 { h[axis] } else { -h[axis] }))
            };
            let loops = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
            let corners: Vec<Wide> = (0..8).map(corner).collect();
            Solid::Polytope(Polytope::new(corners, loops.iter().map(|l| l.to_vec())))
        }
        collide::Solid::Hull(hull) => Solid::Polytope(polytope(&hull)),
        collide::Solid::RoundedHull { hull, radius } => Solid::Rounded(polytope(&hull), radius.into()),
        collide::Solid::Cylinder { half_height, radius } => Solid::Cylinder(axial(half_height, radius)),
        collide::Solid::Cone { half_height, radius } => Solid::Cone(axial(half_height, radius)),
        _ => panic!("{solid:?} is not convex"),
    }
}

/// Corners of the triangles of a height field, in their order; none for those of holes.
fn triangles_of(field: &collide::height_field::HeightField<'_>) -> Vec<Option<[Wide; 3]>> {
    let columns = field.columns as usize;
    let mut all = Vec::new();
    for row in 0..field.rows as usize - 1 {
        for column in 0..columns - 1 {
            let at = |dc: usize, dr: usize| {
                let (c, r) = (column + dc, row + dr);
                let [x, y] = [(c as f32 * field.spacing[0]), (r as f32 * field.spacing[1])];
                wide(Vec3::new(x, y, field.heights[r * columns + c]))
            };
            let is_hole = field.cells.get(row * (columns - 1) + column) == Some(&HOLE);
            for corners in [[at(0, 0), at(1, 0), at(1, 1)], [at(0, 0), at(1, 1), at(0, 1)]] {
                all.push((!is_hole).then_some(corners));
            }
        }
    }
    all
}

/// A geometry at a place, in parts.
pub fn parts(
    world: &OwnedWorld,
    (shape, geometry): (ShapeHandle, &Geometry),
    (position, rotation): (Wide, Rotation),
) -> Vec<Part> {
    let place = |v: Wide| plus(position, turned(rotation, v), 1.0);
    let one = |solid: collide::Solid<'_>| {
        vec![Part { shape, child: 0, solid: convex(&solid, (position, rotation)) }]
    };
    let triangle = |(child, corners): (usize, [Wide; 3])| Part {
        shape,
        child: child as u32,
        solid: Solid::Triangle(corners.map(place)),
    };
    match *geometry {
        Geometry::Sphere { radius } => one(collide::Solid::Sphere { radius }),
        Geometry::Capsule { half_height, radius } => one(collide::Solid::Capsule { half_height, radius }),
        Geometry::Cylinder { half_height, radius } => one(collide::Solid::Cylinder { half_height, radius }),
        Geometry::Cone { half_height, radius } => one(collide::Solid::Cone { half_height, radius }),
        Geometry::Box { half_extents } => one(collide::Solid::Box { half_extents }),
        Geometry::Hull(hull) => one(collide::Solid::Hull(world.hull(hull).expect("registered"))),
        Geometry::RoundedHull { hull, radius } => {
            one(collide::Solid::RoundedHull { hull: world.hull(hull).expect("registered"), radius })
        }
        Geometry::HalfSpace => {
            let normal = turned(rotation, [0.0, 0.0, 1.0]);
            vec![Part { shape, child: 0, solid: Solid::HalfSpace(normal, dot(normal, position)) }]
        }
        Geometry::Mesh(mesh) => {
            let tables = world.mesh(mesh).expect("registered");
            let corners =
                tables.triangles.iter().map(|t| t.vertices.map(|v| wide(tables.vertices[v as usize])));
            corners.enumerate().map(triangle).collect()
        }
        Geometry::HeightField(field) => {
            let all = triangles_of(&world.height_field(field).expect("registered"));
            let solid = all.into_iter().enumerate().filter_map(|(i, corners)| Some((i, corners?)));
            solid.map(triangle).collect()
        }
        Geometry::Compound(compound) => {
            let tables = world.compound(compound).expect("registered");
            (0..tables.len() as u32)
                .map(|child| {
                    let (solid, pose) = tables.child(child);
                    let at = (place(wide(pose.position)), rotation.after(pose.rotation));
                    Part { shape, child, solid: convex(&solid, at) }
                })
                .collect()
        }
    }
}

/// All shapes of a world, in parts.
pub fn of_world(world: &OwnedWorld) -> Vec<Part> {
    let mut all = Vec::new();
    for body in world.bodies() {
        let origin = world.position(body).expect("alive").to_f64();
        let rotation = world.rotation(body).expect("alive");
        for shape in world.shapes_of(body).expect("alive") {
            let def = world.shape(shape).expect("alive");
            let position = plus(origin, turned(rotation, wide(def.pose.position)), 1.0);
            let pose = (position, rotation.after(def.pose.rotation));
            all.extend(parts(world, (shape, &def.geometry), pose));
        }
    }
    all
}

impl Polytope {
    fn new(corners: Vec<Wide>, loops: impl Iterator<Item = Vec<usize>>) -> Self {
        let (mut planes, mut triangles, mut edges) = (Vec::new(), Vec::new(), Vec::new());
        for face in loops {
            let mut normal = [0.0; 3];
            for (i, &a) in face.iter().enumerate() {
                let b = face[(i + 1) % face.len()];
                normal = plus(
                    normal,
                    cross(minus(corners[a], corners[face[0]]), minus(corners[b], corners[face[0]])),
                    1.0,
                );
                edges.push(minus(corners[b], corners[a]));
            }
            let normal = unit(normal);
            let offset = face.iter().map(|&i| dot(normal, corners[i])).fold(f64::NEG_INFINITY, f64::max);
            planes.push((normal, offset));
            triangles.extend((2..face.len()).map(|i| [face[0], face[i - 1], face[i]].map(|c| corners[c])));
        }
        Self { corners, planes, triangles, edges }
    }

    /// Signed distance of a point: negative inside.
    fn distance(&self, p: Wide) -> f64 {
        let depth = |&(n, offset): &(Wide, f64)| dot(n, p) - offset;
        let inside = self.planes.iter().map(depth).fold(f64::NEG_INFINITY, f64::max);
        if inside <= 0.0 {
            return inside;
        }
        let outside = |&t: &[Wide; 3]| norm(minus(on_triangle(t, p), p));
        self.triangles.iter().map(outside).fold(f64::INFINITY, f64::min)
    }

    fn moved(&self, by: Wide) -> Self {
        let shift = |p: Wide| plus(p, by, 1.0);
        Self {
            corners: self.corners.iter().copied().map(shift).collect(),
            planes: self.planes.iter().map(|&(n, offset)| (n, offset + dot(n, by))).collect(),
            triangles: self.triangles.iter().map(|t| t.map(shift)).collect(),
            edges: self.edges.clone(),
        }
    }
}

/// The point of a triangle nearest to `p` (Ericson, Real-Time Collision Detection, 5.1.5).
pub fn on_triangle([a, b, c]: [Wide; 3], p: Wide) -> Wide {
    let on_segment = |a: Wide, b: Wide| {
        let ab = minus(b, a);
        plus(a, ab, (dot(minus(p, a), ab) / dot(ab, ab)).clamp(0.0, 1.0))
    };
    let n = cross(minus(b, a), minus(c, a));
    let over = |a: Wide, b: Wide| dot(cross(n, minus(b, a)), minus(p, a)) >= 0.0;
    if over(a, b) && over(b, c) && over(c, a) {
        return plus(p, n, -dot(minus(p, a), n) / dot(n, n));
    }
    let nearest = |x: Wide, y: Wide| if norm(minus(y, p)) < norm(minus(x, p)) { y } else { x };
    nearest(nearest(on_segment(a, b), on_segment(b, c)), on_segment(c, a))
}

impl Solid {
    /// Signed distance of a point: negative inside; a triangle has no inside.
    pub fn distance(&self, p: Wide) -> f64 {
        match self {
            Solid::Ball(center, radius) => norm(minus(p, *center)) - radius,
            Solid::Capsule([a, b], radius) => {
                let ab = minus(*b, *a);
                let length = dot(ab, ab);
                let t = if length > 0.0 { (dot(minus(p, *a), ab) / length).clamp(0.0, 1.0) } else { 0.0 };
                norm(minus(p, plus(*a, ab, t))) - radius
            }
            Solid::Polytope(polytope) => polytope.distance(p),
            Solid::Rounded(polytope, radius) => polytope.distance(p) - radius,
            Solid::Cylinder(axial) => {
                let [across, height] = axial.profile(p);
                let (side, end) = (across - axial.radius, height.abs() - axial.half);
                if side <= 0.0 || end <= 0.0 { side.max(end) } else { side.hypot(end) }
            }
            Solid::Cone(axial) => {
                let [across, height] = axial.profile(p);
                let (half, radius) = (axial.half, axial.radius);
                let slant = radius.hypot(2.0 * half);
                // From the rim to the apex.
                let along = [-radius / slant, 2.0 * half / slant];
                let from = [across - radius, height + half];
                let beyond = from[0] * along[1] - from[1] * along[0];
                let below = -half - height;
                if beyond <= 0.0 && below <= 0.0 {
                    return beyond.max(below);
                }
                let on_side = (from[0] * along[0] + from[1] * along[1]).clamp(0.0, slant);
                let side = (from[0] - along[0] * on_side).hypot(from[1] - along[1] * on_side);
                side.min(below.hypot((across - radius).max(0.0)))
            }
            Solid::HalfSpace(normal, offset) => dot(*normal, p) - offset,
            Solid::Triangle(corners) => norm(minus(on_triangle(*corners, p), p)),
        }
    }

    /// How far the set reaches along a direction; infinite for a half-space.
    pub fn reach(&self, direction: Wide) -> f64 {
        let most =
            |points: &[Wide]| points.iter().map(|&p| dot(p, direction)).fold(f64::NEG_INFINITY, f64::max);
        match self {
            Solid::Ball(center, radius) => dot(*center, direction) + radius * norm(direction),
            Solid::Capsule(ends, radius) => most(ends) + radius * norm(direction),
            Solid::Polytope(polytope) => most(&polytope.corners),
            Solid::Rounded(polytope, radius) => most(&polytope.corners) + radius * norm(direction),
            Solid::Cylinder(axial) => {
                let along = dot(axial.axis, direction);
                let across = norm(plus(direction, axial.axis, -along));
                dot(axial.center, direction) + axial.half * along.abs() + axial.radius * across
            }
            Solid::Cone(axial) => {
                let along = dot(axial.axis, direction);
                let across = norm(plus(direction, axial.axis, -along));
                dot(axial.center, direction)
                    + (axial.half * along).max(axial.radius * across - axial.half * along)
            }
            Solid::HalfSpace(normal, offset) => {
                if norm(minus(*normal, direction)) < 1.0e-3 {
                    *offset
                } else {
                    f64::INFINITY
                }
            }
            Solid::Triangle(corners) => most(corners),
        }
    }

    /// Center and radius of a ball around the set; the radius of a half-space is infinite.
    pub fn ball(&self) -> (Wide, f64) {
        let around = |points: &[Wide]| {
            let sum = points.iter().fold([0.0; 3], |sum, &p| plus(sum, p, 1.0));
            let center = sum.map(|x| x / points.len() as f64);
            (center, points.iter().map(|&p| norm(minus(p, center))).fold(0.0, f64::max))
        };
        match self {
            Solid::Ball(center, radius) => (*center, *radius),
            Solid::Capsule(ends, radius) => (around(ends).0, around(ends).1 + radius),
            Solid::Polytope(polytope) => around(&polytope.corners),
            Solid::Rounded(polytope, radius) => {
                let (center, own) = around(&polytope.corners);
                (center, own + radius)
            }
            Solid::Cylinder(axial) | Solid::Cone(axial) => (axial.center, axial.half.hypot(axial.radius)),
            Solid::HalfSpace(..) => ([0.0; 3], f64::INFINITY),
            Solid::Triangle(corners) => around(corners),
        }
    }

    /// Moved by a vector.
    pub fn moved(&self, by: Wide) -> Self {
        let shift = |p: Wide| plus(p, by, 1.0);
        match self {
            Solid::Ball(center, radius) => Solid::Ball(shift(*center), *radius),
            Solid::Capsule(ends, radius) => Solid::Capsule(ends.map(shift), *radius),
            Solid::Polytope(polytope) => Solid::Polytope(polytope.moved(by)),
            Solid::Rounded(polytope, radius) => Solid::Rounded(polytope.moved(by), *radius),
            Solid::Cylinder(axial) => Solid::Cylinder(Axial { center: shift(axial.center), ..*axial }),
            Solid::Cone(axial) => Solid::Cone(Axial { center: shift(axial.center), ..*axial }),
            Solid::HalfSpace(normal, offset) => Solid::HalfSpace(*normal, offset + dot(*normal, by)),
            Solid::Triangle(corners) => Solid::Triangle(corners.map(shift)),
        }
    }

    /// Least length of the segment from `a` to `b` to this set along it, by search: the distance of a convex
    /// set is a convex function.
    pub fn distance_of_segment(&self, a: Wide, b: Wide) -> f64 {
        let at = |t: f64| self.distance(plus(a, minus(b, a), t));
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..100 {
            let (m, n) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
            if at(m) < at(n) { high = n } else { low = m }
        }
        at(0.5 * (low + high)).min(at(0.0)).min(at(1.0))
    }

    /// Where a point that moves along the unit vector `d` first comes as near as `gap`, up to `length`; `None`
    /// when it does not. By steps of the distance, which never pass.
    pub fn first_within(&self, origin: Wide, d: Wide, (length, gap): (f64, f64)) -> Option<f64> {
        let mut s = 0.0;
        for _ in 0..20_000 {
            let left = self.distance(plus(origin, d, s)) - gap;
            if left <= 1.0e-9 * (1.0 + s) {
                return Some(s);
            }
            s += left;
            if s > length {
                return None;
            }
        }
        Some(s)
    }

    /// The greatest gap between two convex polytopes (triangles, half-spaces and round shapes too, by their cores)
    /// over all axes of faces and pairs of edges: the separation when positive, minus the depth else.
    pub fn gap(&self, other: &Self) -> f64 {
        let mut axes: Vec<Wide> = self.normals().chain(other.normals()).collect();
        for a in self.edges() {
            for b in other.edges() {
                let axis = cross(a, b);
                if norm(axis) > 1.0e-9 * norm(a) * norm(b) {
                    axes.push(unit(axis));
                }
            }
        }
        let along = |axis: Wide| -other.reach(axis.map(|x| -x)) - self.reach(axis);
        axes.into_iter()
            .map(|axis| along(axis).max(along(axis.map(|x| -x))))
            .fold(f64::NEG_INFINITY, f64::max)
    }

    fn normals(&self) -> impl Iterator<Item = Wide> {
        let normals: Vec<Wide> = match self {
            Solid::Polytope(polytope) => polytope.planes.iter().map(|plane| plane.0).collect(),
            Solid::HalfSpace(normal, _) => vec![*normal],
            Solid::Triangle([a, b, c]) => {
                let n = unit(cross(minus(*b, *a), minus(*c, *a)));
                [minus(*b, *a), minus(*c, *b), minus(*a, *c)]
                    .iter()
                    .map(|&e| unit(cross(e, n)))
                    .chain([n])
                    .collect()
            }
            _ => Vec::new(),
        };
        normals.into_iter()
    }

    fn edges(&self) -> Vec<Wide> {
        match self {
            Solid::Polytope(polytope) => polytope.edges.clone(),
            Solid::Triangle([a, b, c]) => vec![minus(*b, *a), minus(*c, *b), minus(*a, *c)],
            _ => Vec::new(),
        }
    }
}

/// A vector in single precision.
pub fn narrow(v: Wide) -> Vec3 {
    Vec3::new(v[0] as f32, v[1] as f32, v[2] as f32)
}
