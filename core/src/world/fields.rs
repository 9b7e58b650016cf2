//! Whose a row of the state is: for telling people where two states differ.

use super::World;
use crate::arena::Line;
use crate::handle::BodyHandle;
use crate::pool;
use crate::state::{ContactRow, Pair};

impl<M: AsRef<[Line]> + AsMut<[Line]>> World<M> {
    /// The bodies that a row of a section is about, as the world is now: none, one, or the two of a pair, a contact
    /// or a joint.
    pub fn bodies_of_row(&self, section: &str, row: usize) -> [Option<BodyHandle>; 2] {
        let (layout, state) = (&self.layout.state, self.state());
        let of_slot = |slot: usize| {
            let generation = *layout.body_generations.of(state).get(slot)?;
            pool::is_used(layout.body_used.of(state), slot as u32)
                .then_some(BodyHandle { index: slot as u32, generation })
        };
        let of_shape = |slot: u32| of_slot(layout.shapes.of(state).get(slot as usize)?.body as usize);
        let of_pair = |pair: Option<Pair>| pair.map_or([None; 2], |pair| [pair.a, pair.b].map(of_shape));
        let pair_of = |row: &ContactRow| row.pair;
        match section {
            "motions" | "bodies" | "body_generations" | "dirt" | "first_joints" => [of_slot(row), None],
            "shapes" | "shape_generations" | "tenants" => [of_shape(row as u32), None],
            "pairs" => of_pair(layout.pairs.of(state).get(row).copied()),
            "asleep_pairs" => of_pair(layout.asleep_pairs.of(state).get(row).copied()),
            "contacts" => of_pair(layout.contacts.of(state).get(row).map(pair_of)),
            "asleep_contacts" => of_pair(layout.asleep_contacts.of(state).get(row).map(pair_of)),
            "joints" | "joint_axes" | "joint_generations" => {
                let joint = layout.joints.of(state).get(row);
                joint.map_or([None; 2], |joint| joint.bodies.map(|slot| of_slot(slot as usize)))
            }
            _ => [None; 2],
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::state::Field;
    use crate::world::Capacities;

    #[test]
    fn every_byte_of_a_row_has_a_name() {
        let capacities = Capacities { joints: 1, events: 1, ..Capacities::for_bodies(1) };
        let header = bytemuck::Zeroable::zeroed();
        let layout = crate::world::Layout::new(&capacities);
        for section in super::super::snapshot::sections_of(&layout.state, &header) {
            let mut byte = 0;
            while byte < section.size {
                let field = Field::at(section.name, byte);
                let field = field.unwrap_or_else(|| panic!("{}, byte {byte}", section.name));
                assert_eq!(field.offset, byte, "{}: {field:?}", section.name);
                byte = field.end();
            }
            assert_eq!(byte, section.size, "{}", section.name);
            assert_eq!(Field::at(section.name, byte), None, "{}", section.name);
        }
    }
}
