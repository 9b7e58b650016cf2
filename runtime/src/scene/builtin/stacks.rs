//! Scenes that stand: tower, pyramids, wall.

use super::parts::{body, cuboid, ground};
use crate::scene::format::Scene;

/// Half the edge of a unit box, metres.
const HALF: f64 = 0.5;

/// `size` unit boxes one on the other on the ground.
pub fn tower(size: u32) -> Scene {
    let boxes = (0..size).map(|level| body([0.0, 0.0, f64::from(level) + HALF], cuboid([0.5; 3])));
    Scene { bodies: std::iter::once(ground()).chain(boxes).collect(), ..Scene::default() }
}

/// A flat pyramid of unit boxes with `size` boxes in its lowest row, one less in each row above. Neighbours
/// touch, as in the large pyramid of Box2D and Box3D.
pub fn pyramid(size: u32) -> Scene {
    let mut bodies = vec![ground()];
    for level in 0..size {
        let row = size - level;
        for column in 0..row {
            let x = f64::from(column) - HALF * f64::from(row - 1);
            bodies.push(body([x, 0.0, f64::from(level) + HALF], cuboid([0.5; 3])));
        }
    }
    Scene { bodies, ..Scene::default() }
}

/// A solid pyramid: square layers of unit boxes that touch, `size` boxes along the lowest layer's edge, one
/// less in each layer above, centered.
pub fn stacked_pyramid(size: u32) -> Scene {
    let mut bodies = vec![ground()];
    for level in 0..size {
        let edge = size - level;
        let place = |index: u32| f64::from(index) - HALF * f64::from(edge - 1);
        for row in 0..edge {
            for column in 0..edge {
                let position = [place(column), place(row), f64::from(level) + HALF];
                bodies.push(body(position, cuboid([0.5; 3])));
            }
        }
    }
    Scene { bodies, ..Scene::default() }
}

/// A wall of `size` courses of `size` bricks of 1 x 0.5 x 0.5 m; every other course starts and ends with half
/// a brick.
pub fn wall(size: u32) -> Scene {
    let mut bodies = vec![ground()];
    let brick = cuboid([0.5, 0.25, 0.25]);
    let bat = cuboid([0.25, 0.25, 0.25]);
    for course in 0..size {
        let z = 0.5 * f64::from(course) + 0.25;
        let left = -HALF * f64::from(size);
        if course % 2 == 0 {
            bodies.extend((0..size).map(|i| body([left + f64::from(i) + HALF, 0.0, z], brick.clone())));
            continue;
        }
        bodies.push(body([left + 0.25, 0.0, z], bat.clone()));
        bodies.extend((1..size).map(|i| body([left + f64::from(i), 0.0, z], brick.clone())));
        bodies.push(body([left + f64::from(size) - 0.25, 0.0, z], bat.clone()));
    }
    Scene { bodies, ..Scene::default() }
}
