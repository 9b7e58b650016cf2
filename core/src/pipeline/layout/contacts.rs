//! Contacts: the row and the lane of each.
//!
//! Where there are many blocks each lane has a chain of them, link after link. A world of a few small islands has
//! fewer blocks than lanes, and rows would be mostly empty; there the links are placed by *levels*: each in the
//! first row with a free lane after the last one that has a body of it. Links of a block that share a body keep
//! their order that way, and all others commute, so both give the same bits.

use super::{EMPTY, GROUP_LINKS, LINK_GROUPS_MAX, Schedule, Tables};
use crate::cells::{Block, IMMOVABLE, Link};
use crate::lanes::LANES;

/// True when chains of these loads, of one group, would leave lanes empty.
pub(super) fn are_sparse(loads: &[u32], groups: usize) -> bool {
    let longest = loads.iter().copied().max().unwrap_or(0) as usize;
    let links = loads.iter().sum::<u32>() as usize;
    groups == 1 && links <= GROUP_LINKS && links < longest * LANES
}

/// Writes each contact to the next row of its chain. Links and contacts have the same indices.
pub(super) fn place(schedule: &Schedule<'_>, blocks: &[Block], tables: &mut Tables<'_>, first_group: usize) {
    let mut lengths = [0_u32; LINK_GROUPS_MAX * LANES];
    for (i, block) in blocks.iter().enumerate() {
        let chain = tables.block_chains[i] as usize;
        let (group, lane) = (chain / LANES, chain % LANES);
        let first_row = tables.groups[first_group + group].first_row;
        for link in contacts_of(schedule, block) {
            set(tables, link, (first_row + lengths[chain], lane));
            lengths[chain] += 1;
        }
    }
}

/// Writes each contact of a group to the first row with a free lane in which its bodies are free. Returns the
/// number of rows.
pub(super) fn place_by_levels(
    schedule: &Schedule<'_>,
    blocks: &[Block],
    tables: &mut Tables<'_>,
    first_row: u32,
) -> u32 {
    let ends = |link: u32| {
        let Link { a, b, .. } = schedule.links[link as usize];
        [a, b].into_iter().filter(|&body| body != IMMOVABLE)
    };
    for link in blocks.iter().flat_map(|block| contacts_of(schedule, block)) {
        ends(link).for_each(|body| tables.body_rows[body as usize] = 0);
    }
    // Links of each row, and the first row that has room.
    let (mut filled, mut open, mut rows) = ([0_u8; GROUP_LINKS], 0, 0);
    for link in blocks.iter().flat_map(|block| contacts_of(schedule, block)) {
        let level = ends(link).map(|body| tables.body_rows[body as usize]).fold(open, u32::max);
        let full = filled[level as usize..].iter().take_while(|&&count| usize::from(count) == LANES);
        let row = level + full.count() as u32;
        if row == rows {
            tables.lane_contacts[(first_row + row) as usize] = [EMPTY; LANES];
            rows += 1;
        }
        set(tables, link, (first_row + row, usize::from(filled[row as usize])));
        filled[row as usize] += 1;
        ends(link).for_each(|body| tables.body_rows[body as usize] = row + 1);
        while open < rows && usize::from(filled[open as usize]) == LANES {
            open += 1;
        }
    }
    rows
}

/// The contacts of a block, in their order.
fn contacts_of<'a>(schedule: &Schedule<'a>, block: &Block) -> impl Iterator<Item = u32> + use<'a> {
    let contacts = schedule.contacts;
    let links = &schedule.order[block.first as usize..(block.first + block.count) as usize];
    links.iter().copied().filter(move |&link| link < contacts)
}

fn set(tables: &mut Tables<'_>, link: u32, (row, lane): (u32, usize)) {
    tables.lane_contacts[row as usize][lane] = link;
    tables.contact_places[link as usize] = row * LANES as u32 + lane as u32;
}
