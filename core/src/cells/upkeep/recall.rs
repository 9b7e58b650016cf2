//! The cache of an ordering that does not change in this step.

use super::super::Link;
use super::{Memory, Upkeep};

impl Upkeep<'_> {
    /// Derives everything from links that all have a phase, and changes nothing: for a step that brings no change
    /// when the cache says nothing. `scratch` as for [`Upkeep::update`].
    pub fn recall(&mut self, links: &[Link], phases: &[u8], dirt: &[u8], scratch: &mut [u32]) {
        let [bodies, capacity] = self.capacities().map(|capacity| capacity as usize);
        let memory = Memory::carve(bodies, capacity, scratch);
        let [queue, _] = memory.queues;
        for (index, from) in memory.old[..links.len()].iter_mut().enumerate() {
            *from = index as u32;
        }
        self.rebuild(links, &memory.old[..links.len()], phases);
        self.label(dirt, queue);
    }
}
