//! One ruler for all engines: how deep bodies overlap, and how far joints gape, at given poses.
//!
//! Overlap is told by [`cellstep_tests::overlap`].

use crate::own::Filled;
use crate::scenes::{Body, Joint, Scene};
use cellstep::Geometry;
use cellstep::math::Pose;
use cellstep_tests::overlap::{Ruled, Ruler};

/// Overlap of a scene at one moment, metres.
#[derive(Clone, Copy, Debug, Default)]
pub struct Overlap {
    pub pairs: usize,
    pub max: f32,
    pub p99: f32,
    pub mean: f32,
    /// Mean height of the moving bodies, metres: what has fallen over is low.
    pub height: f32,
}

/// Distances of the points that joints hold together at one moment, metres, over all joints.
#[derive(Clone, Copy, Debug)]
pub struct Gaps {
    pub p50: f32,
    pub p99: f32,
    pub max: f32,
    /// Mean height of the moving bodies, metres: whether engines saw the same fall.
    pub height: f32,
}

impl Gaps {
    /// Of a scene with joints, from the poses of all bodies in its order.
    pub fn measure(scene: &Scene, poses: &[Pose]) -> Self {
        let gap = |joint: &Joint| {
            let [a, b] = joint.bodies.map(|body| poses[body]);
            let arms = a.rotation.rotate(joint.anchors[0]) - b.rotation.rotate(joint.anchors[1]);
            ((a.position - b.position) + arms).length()
        };
        let mut gaps: Vec<f32> = scene.joints.iter().map(gap).collect();
        gaps.sort_by(f32::total_cmp);
        let part = |percent: usize| gaps[(gaps.len() * percent / 100).min(gaps.len() - 1)];
        let height = height(scene.bodies.iter().map(|body| body.moves), poses);
        Gaps { p50: part(50), p99: part(99), max: part(100), height }
    }
}

/// Mean height of the bodies that move.
fn height(moves: impl Iterator<Item = bool>, poses: &[Pose]) -> f32 {
    let heights: Vec<f32> =
        moves.zip(poses).filter(|&(moves, _)| moves).map(|(_, pose)| pose.position.z).collect();
    heights.iter().sum::<f32>() / heights.len().max(1) as f32
}

pub struct Gauge {
    ruler: Ruler,
    moves: Vec<bool>,
}

impl Gauge {
    pub fn new(scene: &Scene) -> Self {
        let radius = |geometry: &Option<Geometry>| match geometry.expect("scenes with contacts have shapes") {
            Geometry::Sphere { radius } => radius,
            Geometry::Capsule { half_height, radius } => half_height + radius,
            Geometry::Box { half_extents } => half_extents.length(),
            other => panic!("the scenes have no {other:?}"),
        };
        let filled = Filled::new(scene);
        let handles = filled.bodies.iter().zip(&filled.shapes);
        let ruled = |(body, (&handle, &shape)): (&Body, _)| Ruled {
            body: handle,
            shape,
            moves: body.moves,
            radius: radius(&body.geometry),
        };
        let bodies = scene.bodies.iter().zip(handles).map(ruled).collect();
        let moves = scene.bodies.iter().map(|body| body.moves).collect();
        Gauge { ruler: Ruler::new(filled.world, bodies), moves }
    }

    /// Measures the overlap at the poses of all bodies, in the order of the scene.
    pub fn measure(&mut self, poses: &[Pose]) -> Overlap {
        let depths = self.ruler.depths(poses);
        Overlap {
            pairs: depths.len(),
            max: depths.last().copied().unwrap_or(0.0),
            p99: depths.get(depths.len() * 99 / 100).copied().unwrap_or(0.0),
            mean: depths.iter().sum::<f32>() / depths.len().max(1) as f32,
            height: height(self.moves.iter().copied(), poses),
        }
    }
}
