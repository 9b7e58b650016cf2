//! Geometric multi-colour batches (SEED S15; Chen 2007, Keogh 2007): links of a colour share no body.

use super::{Flat, ends};
use cellstep::cells::{Link, PHASES_MAX};

/// The phase that takes what found no colour.
const REST: u32 = PHASES_MAX as u32 - 1;

/// Greedy first-fit colouring: each link, in its turn, takes the first colour that its bodies have not yet. The
/// links of a colour come by kind, so that those in neighbouring lanes are alike. With 31 colours used up, a link
/// goes to one serial block in the last phase.
pub fn first_fit(bodies: u32, links: &[Link]) -> Flat {
    let mut used = vec![0_u32; bodies as usize];
    // Sorted by (colour, kind, index): each key is one link's.
    let mut keys = Vec::with_capacity(links.len());
    for (index, link) in links.iter().enumerate() {
        let taken = ends(link).fold(0, |taken, body| taken | used[body]);
        let colour = taken.trailing_ones().min(REST);
        if colour < REST {
            ends(link).for_each(|body| used[body] |= 1 << colour);
        }
        let kind = if colour < REST { link.kind } else { 0 };
        keys.push((u64::from(colour) << 56) | (u64::from(kind.min(0xff_ffff)) << 32) | index as u64);
    }
    keys.sort_unstable();
    let mut flat = Flat { order: Vec::with_capacity(links.len()), blocks: Vec::with_capacity(links.len()) };
    let (mut phase, mut colour) = (0, 0);
    for key in keys {
        let own = (key >> 56) as u32;
        if own != colour {
            flat.close(phase);
            (phase, colour) = (phase + 1, own);
        }
        flat.order.push(key as u32);
        if own < REST {
            flat.close(phase);
        }
    }
    flat.close(phase);
    flat
}
