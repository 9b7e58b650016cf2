//! One ruler for the overlap of all engines: poses go into a world that never steps, and exact collision tells the
//! separations of all pairs whose bounding spheres meet. A pair counts once, with its deepest point.

use crate::worlds::OwnedWorld;
use cellstep::math::{Pose, Vec3};
use cellstep::{BodyHandle, Position, ShapeHandle};

/// A body of one shape, for the ruler.
#[derive(Clone, Copy, Debug)]
pub struct Ruled {
    /// Its body in the world.
    pub body: BodyHandle,
    /// Its shape there.
    pub shape: ShapeHandle,
    /// Whether it moves: pairs of two that do not are left out.
    pub moves: bool,
    /// Of a sphere around the body's origin that holds the shape, metres.
    pub radius: f32,
}

/// The ruler: a world with the shapes to be measured.
pub struct Ruler {
    world: OwnedWorld,
    bodies: Vec<Ruled>,
}

impl Ruler {
    /// Takes a world that is never stepped.
    pub fn new(world: OwnedWorld, bodies: Vec<Ruled>) -> Self {
        Self { world, bodies }
    }

    /// Depths of all pairs that overlap, metres, the least first, at the poses of all bodies in their order.
    pub fn depths(&mut self, poses: &[Pose]) -> Vec<f32> {
        for (ruled, pose) in self.bodies.iter().zip(poses) {
            let moved = self.world.set_pose(ruled.body, Position::at(pose.position), pose.rotation);
            moved.expect("engines give finite poses");
        }
        let mut depths: Vec<f32> =
            self.candidates(poses).into_iter().filter_map(|pair| self.depth(pair)).collect();
        depths.sort_by(f32::total_cmp);
        depths
    }

    /// Pairs with a moving body whose bounding spheres meet; sorted along x, so that most are never looked at.
    fn candidates(&self, poses: &[Pose]) -> Vec<[usize; 2]> {
        let (mut moving, fixed): (Vec<usize>, Vec<usize>) =
            (0..poses.len()).partition(|&index| self.bodies[index].moves);
        let radius = |index: usize| self.bodies[index].radius;
        let near = |a: usize, b: usize| {
            let between: Vec3 = poses[a].position - poses[b].position;
            between.length() <= radius(a) + radius(b)
        };
        let left = |index: usize| poses[index].position.x - radius(index);
        moving.sort_by(|&a, &b| left(a).total_cmp(&left(b)));
        let mut pairs = Vec::new();
        for (k, &a) in moving.iter().enumerate() {
            let right = poses[a].position.x + radius(a);
            let others = moving[k + 1..].iter().take_while(|&&b| left(b) <= right);
            pairs.extend(others.chain(&fixed).filter(|&&b| near(a, b)).map(|&b| [a, b]));
        }
        pairs
    }

    /// Depth of a pair's deepest point; `None` when it does not overlap.
    fn depth(&self, [a, b]: [usize; 2]) -> Option<f32> {
        let mut deepest = 0.0;
        let [a, b] = [a, b].map(|index| self.bodies[index].shape);
        self.world.manifolds(a, b, |manifold| {
            for point in &manifold.points {
                deepest = cellstep::math::max(deepest, -point.separation);
            }
        });
        (deepest > 0.0).then_some(deepest)
    }
}
