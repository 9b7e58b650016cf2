//! The order of the contacts of short blocks: by colors, so that a small island fills the lanes.
//!
//! A large scene fills the lanes with blocks. A small one has few, and were its links one chain, a row would hold
//! one of them. So the contacts of a block of few links are ordered by *colors*, each the first that no contact of
//! its bodies before it has: those of one color share no body, and lie side by side (`layout/contacts.rs`). Which
//! color a contact has depends on its block alone, whatever else is in the world.

use crate::cells::{Block, IMMOVABLE, Link};

/// Most links of a block that is spread: longer ones are those of scenes that have many.
const SPREAD_LINKS: u32 = 16;

/// Orders the contacts of short blocks by colors. `colors` has a word for each active body, of any content.
pub(crate) fn run(
    order: &mut [u32],
    blocks: &[Block],
    (links, contacts): (&[Link], u32),
    colors: &mut [u32],
) {
    for block in blocks.iter().filter(|block| block.count <= SPREAD_LINKS) {
        let own = &mut order[block.first as usize..(block.first + block.count) as usize];
        // Joints come first, and have rows of their own.
        let first = own.iter().take_while(|&&link| link >= contacts).count();
        spread(&mut own[first..], links, colors);
    }
}

fn spread(own: &mut [u32], links: &[Link], colors: &mut [u32]) {
    let ends = |link: u32| {
        let Link { a, b, .. } = links[link as usize];
        [a, b].into_iter().filter(|&body| body != IMMOVABLE)
    };
    own.iter().flat_map(|&link| ends(link)).for_each(|body| colors[body as usize] = 0);
    // A block has fewer links than a word has bits, so there is always a color.
    let mut keys = [(0, 0); SPREAD_LINKS as usize];
    for (key, &link) in keys.iter_mut().zip(&*own) {
        let used = ends(link).fold(0, |used, body| used | colors[body as usize]);
        let color = used.trailing_ones();
        ends(link).for_each(|body| colors[body as usize] |= 1 << color);
        *key = (color, link);
    }
    // Of one color they keep their order: by number of points, then by index.
    let keys = &mut keys[..own.len()];
    sort_by_color(keys);
    own.iter_mut().zip(&*keys).for_each(|(link, key)| *link = key.1);
}

/// Sorts by color; equal ones keep their order. Few, and nearly sorted.
fn sort_by_color(keys: &mut [(u32, u32)]) {
    for end in 1..keys.len() {
        let mut at = end;
        while at > 0 && keys[at - 1].0 > keys[at].0 {
            keys.swap(at - 1, at);
            at -= 1;
        }
    }
}
