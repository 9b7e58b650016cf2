//! The cache of an ordering that does not change in this step.

use super::super::Link;
use super::{Change, Memory, Upkeep};

impl Upkeep<'_> {
    /// Derives everything from links that all have a phase, and changes nothing: for a step that brings no change
    /// when the cache says nothing. `scratch` as for [`Upkeep::update`].
    pub fn recall(&mut self, links: &[Link], phases: &[u8], dirt: &[u8], scratch: &mut [u32]) {
        let [bodies, capacity] = self.capacities().map(|capacity| capacity as usize);
        let Memory { queues: [queue, _], old, begins, .. } = Memory::carve(bodies, capacity, scratch);
        let from = &mut old[..links.len()];
        from.iter_mut().enumerate().for_each(|(index, from)| *from = index as u32);
        let change = Change { links, from, lost: &[], cached: false, block_links: 0 };
        self.rebuild(&change, phases, begins);
        self.label(dirt, queue);
    }
}
