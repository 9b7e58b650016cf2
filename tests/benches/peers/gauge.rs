//! One ruler for all engines: how deep bodies overlap, and how far joints gape, at given poses.
//!
//! For overlap the poses are put into a world that never steps, and exact collision tells the separations of all
//! pairs whose bounding spheres meet. A pair counts once, with its deepest point.

use crate::own::Filled;
use crate::scenes::{Joint, Scene};
use cellstep::math::{Pose, Vec3};
use cellstep::{Geometry, Position};

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
    filled: Filled,
    moves: Vec<bool>,
    radii: Vec<f32>,
}

impl Gauge {
    pub fn new(scene: &Scene) -> Self {
        let radius = |geometry: &Option<Geometry>| match geometry.expect("scenes with contacts have shapes") {
            Geometry::Sphere { radius } => radius,
            Geometry::Capsule { half_height, radius } => half_height + radius,
            Geometry::Box { half_extents } => half_extents.length(),
            other => panic!("the scenes have no {other:?}"),
        };
        Gauge {
            filled: Filled::new(scene),
            moves: scene.bodies.iter().map(|body| body.moves).collect(),
            radii: scene.bodies.iter().map(|body| radius(&body.geometry)).collect(),
        }
    }

    /// Measures the overlap at the poses of all bodies, in the order of the scene.
    pub fn measure(&mut self, poses: &[Pose]) -> Overlap {
        for (&body, pose) in self.filled.bodies.iter().zip(poses) {
            let moved = self.filled.world.set_pose(body, Position::at(pose.position), pose.rotation);
            moved.expect("engines give finite poses");
        }
        let mut depths: Vec<f32> =
            self.candidates(poses).into_iter().filter_map(|pair| self.depth(pair)).collect();
        depths.sort_by(f32::total_cmp);
        Overlap {
            pairs: depths.len(),
            max: depths.last().copied().unwrap_or(0.0),
            p99: depths.get(depths.len() * 99 / 100).copied().unwrap_or(0.0),
            mean: depths.iter().sum::<f32>() / depths.len().max(1) as f32,
            height: height(self.moves.iter().copied(), poses),
        }
    }

    /// Pairs with a moving body whose bounding spheres meet; sorted along x, so that most are never looked at.
    fn candidates(&self, poses: &[Pose]) -> Vec<[usize; 2]> {
        let (mut moving, fixed): (Vec<usize>, Vec<usize>) =
            (0..poses.len()).partition(|&index| self.moves[index]);
        let near = |a: usize, b: usize| {
            let between: Vec3 = poses[a].position - poses[b].position;
            between.length() <= self.radii[a] + self.radii[b]
        };
        let left = |index: usize| poses[index].position.x - self.radii[index];
        moving.sort_by(|&a, &b| left(a).total_cmp(&left(b)));
        let mut pairs = Vec::new();
        for (k, &a) in moving.iter().enumerate() {
            let right = poses[a].position.x + self.radii[a];
            let others = moving[k + 1..].iter().take_while(|&&b| left(b) <= right);
            pairs.extend(others.chain(&fixed).filter(|&&b| near(a, b)).map(|&b| [a, b]));
        }
        pairs
    }

    /// Depth of a pair's deepest point; `None` when it does not overlap.
    fn depth(&self, [a, b]: [usize; 2]) -> Option<f32> {
        let mut deepest = 0.0;
        let [a, b] = [a, b].map(|index| self.filled.shapes[index]);
        self.filled.world.manifolds(a, b, |manifold| {
            for point in &manifold.points {
                deepest = cellstep::math::max(deepest, -point.separation);
            }
        });
        (deepest > 0.0).then_some(deepest)
    }
}
