//! Asking what is where.

use super::World;
use crate::arena::Line;
use crate::pipeline::{Regions, broadphase::tree_of, query_trees};
use crate::query::Queries;

impl<M: AsRef<[Line]> + AsMut<[Line]>> World<M> {
    /// A view that answers queries about the world as it is now, changes since the last step included.
    ///
    /// Boxes and trees are brought up to date first: about 0.1 microseconds for each shape that can move, once
    /// after each step or change; static shapes cost only when one of them changed. They are cache, so that queries
    /// never change a bit of the state, and no result depends on what the cache held. The view is read-only and can
    /// be shared by threads.
    pub fn queries(&mut self) -> Queries<'_> {
        let Regions { assets, state, mut cache, mut scratch } = self.regions();
        query_trees::refresh(&state, &assets, &mut cache, &mut scratch);
        let header = cache.header[0];
        Queries {
            assets,
            motions: state.motions,
            bodies: state.bodies,
            body_generations: state.body_generations,
            shapes: state.shapes,
            shape_generations: state.shape_generations,
            trees: [
                tree_of(cache.static_nodes, cache.static_order, header.static_leaves),
                tree_of(cache.moving_nodes, cache.moving_order, header.moving_leaves),
            ],
            sector: header.sector,
        }
    }
}
