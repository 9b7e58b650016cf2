//! The cache of an ordering that does not change in this step.

use super::super::{IMMOVABLE, Link};
use super::graph::NONE;
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

    /// True when the cache, which some update has left, is that of these links and phases, whatever the dirt.
    pub fn is_of(&self, links: &[Link], phases: &[u8]) -> bool {
        self.header.capacities == self.capacities()
            && self.header.link_count as usize == links.len()
            && links.iter().zip(phases).zip(&*self.ids).all(|((link, &phase), &id)| {
                let node = &self.links[id as usize];
                let far = if link.b == link.a { IMMOVABLE } else { link.b };
                node.end == [link.a, far] && node.phase == u32::from(phase)
            })
    }

    /// Takes over other dirt of the bodies.
    pub fn refresh_dirt(&mut self, dirt: &[u8]) {
        for block in &mut self.blocks[..self.header.block_high as usize] {
            block.dirt = 0;
        }
        for (body, &dirt) in self.bodies.iter_mut().zip(dirt) {
            let block = body.block[0];
            if block != NONE {
                body.dirt = u32::from(dirt);
                self.blocks[block as usize].dirt += u32::from(dirt);
            }
        }
    }
}
