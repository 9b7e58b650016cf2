//! What the makers share: the ground, boxes, mixed bodies, and numbers that look random.

use crate::scene::format::*;

/// A generator of numbers that look random (PCG XSH-RR 64/32, O'Neill 2014): the same on every machine.
pub(super) struct Random(u64);

impl Random {
    pub(super) fn new(seed: u64) -> Self {
        let mut random = Self(seed.wrapping_mul(2).wrapping_add(1));
        random.next();
        random
    }

    fn next(&mut self) -> u32 {
        let state = self.0;
        self.0 = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let mixed = (((state >> 18) ^ state) >> 27) as u32;
        mixed.rotate_right((state >> 59) as u32)
    }

    /// A number from `-reach` to `reach` in steps of 1/1024: short in JSON, and exact in f32.
    pub(super) fn within(&mut self, reach: f64) -> f64 {
        let steps = (reach * 1024.0).floor() as i64;
        let step = i64::from(self.next()) % (2 * steps + 1) - steps;
        step as f64 / 1024.0
    }

    /// A rotation by whole degrees.
    pub(super) fn rotation(&mut self) -> RotationDoc {
        let mut angle = || (self.next() % 360) as f32;
        RotationDoc::EulerDegrees([angle(), angle(), angle()])
    }
}

/// A static half-space below z = 0.
pub(super) fn ground() -> BodyDoc {
    BodyDoc {
        kind: KindDoc::Static,
        shapes: vec![ShapeDoc::new(GeometryDoc::HalfSpace)],
        ..BodyDoc::default()
    }
}

/// A dynamic body of one shape.
pub(super) fn body(position: [f64; 3], geometry: GeometryDoc) -> BodyDoc {
    BodyDoc { position, shapes: vec![ShapeDoc::new(geometry)], ..BodyDoc::default() }
}

pub(super) fn cuboid(half_extents: [f32; 3]) -> GeometryDoc {
    GeometryDoc::Box { half_extents }
}

/// Name of the hull in [`rock`].
pub(super) const ROCK: &str = "rock";

/// A convex rock of 12 corners, about 1 m across: an icosahedron with its corners pulled out of symmetry.
pub(super) fn rock() -> HullDoc {
    let points = vec![
        [-0.26, 0.43, 0.02],
        [0.25, 0.41, -0.03],
        [-0.27, -0.44, 0.0],
        [0.28, -0.42, 0.04],
        [0.02, -0.25, 0.42],
        [0.0, 0.27, 0.39],
        [-0.03, -0.26, -0.41],
        [0.01, 0.24, -0.43],
        [0.44, 0.02, -0.27],
        [0.41, -0.01, 0.26],
        [-0.42, 0.0, -0.25],
        [-0.45, 0.03, 0.28],
    ];
    HullDoc { points }
}

/// The shapes of a mixed scene in turn: ball, box, capsule, rock. Each fits into a ball of 0.56 m around its
/// origin.
pub(super) fn mixed(index: usize) -> GeometryDoc {
    match index % 4 {
        0 => GeometryDoc::Sphere { radius: 0.4 },
        1 => cuboid([0.4, 0.3, 0.25]),
        2 => GeometryDoc::Capsule { half_height: 0.3, radius: 0.25 },
        _ => GeometryDoc::Hull(ROCK.to_string()),
    }
}
