//! What the ordering promises, on graphs of many kinds; equality with a naive builder; `check` against broken
//! schedules.

extern crate std;

pub(super) mod graphs;
mod reference;
mod rejected;

use super::*;
use graphs::{Random, Scene};
use std::collections::{BTreeMap, BTreeSet};
use std::format;
use std::vec;
use std::vec::Vec;

/// A schedule that owns its slices.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Built {
    order: Vec<u32>,
    blocks: Vec<Block>,
}

impl Built {
    /// Links of a block.
    fn links(&self, block: &Block) -> &[u32] {
        &self.order[block.first as usize..][..block.count as usize]
    }

    /// How many phases.
    fn phases(&self) -> u32 {
        self.blocks.last().map_or(0, |block| block.phase + 1)
    }
}

/// Builds the ordering in scratch of exactly the promised size and of the given content, and checks it.
fn build(scene: &Scene, block_links: u32, poison: u32) -> Built {
    let links = &scene.links[..];
    let mut scratch = vec![poison; scratch_words(scene.bodies as usize, links.len())];
    let mut order = vec![poison; links.len()];
    let mut blocks = vec![Block { phase: poison, first: poison, count: poison }; links.len()];
    let mut schedule = Schedule { order: &mut order, blocks: &mut blocks, block_count: poison as usize };
    Cellular { block_links }.schedule(scene.bodies, links, &mut scratch, &mut schedule);
    let result = check(scene.bodies, links, &schedule, &mut scratch);
    assert_eq!(result, Ok(()), "{} at {block_links}", scene.name);
    let count = schedule.block_count;
    blocks.truncate(count);
    Built { order, blocks }
}

/// g as the documentation states it.
fn documented_size(scene: &Scene, block_links: u32) -> u32 {
    let mut ends = BTreeMap::new();
    for link in scene.links.iter().filter(|link| link.b != IMMOVABLE && link.a != link.b) {
        *ends.entry(link.a).or_insert(0_usize) += 1;
        *ends.entry(link.b).or_insert(0_usize) += 1;
    }
    let sum: usize = ends.values().sum();
    let least = (3 * sum).div_ceil(ends.len().max(1));
    (block_links.max(1) as usize).min((scene.links.len() / 24).max(12)).max(least) as u32
}

/// Whether all links have a body in common.
fn have_common_body(scene: &Scene, links: &[u32]) -> bool {
    let first = scene.links[links[0] as usize];
    [first.a, first.b].into_iter().filter(|&body| body != IMMOVABLE).any(|body| {
        links.iter().all(|&link| scene.links[link as usize].a == body || scene.links[link as usize].b == body)
    })
}

/// Everything that every cellular schedule promises beyond validity.
fn assert_promises(scene: &Scene, block_links: u32, built: &Built) {
    let at = format!("{} at {block_links}", scene.name);
    assert!(built.phases() as usize <= CELLULAR_PHASES_MAX, "{at}: {} phases", built.phases());
    let g = documented_size(scene, block_links);
    let mut home = BTreeMap::new();
    for (index, block) in built.blocks.iter().enumerate() {
        let links = built.links(block);
        let cap = [g, g, g, 2 * g, 2 * g, 2 * g, 2 * g, u32::MAX][block.phase as usize];
        assert!(block.count <= cap || have_common_body(scene, links), "{at}: block {index} exceeds {cap}");
        let kinds = links.iter().map(|&link| scene.links[link as usize].kind);
        assert!(kinds.is_sorted(), "{at}: kinds of block {index}");
        for &link in links {
            let Link { a, b, .. } = scene.links[link as usize];
            let pair = (a.min(b), a.max(b));
            assert_eq!(*home.entry(pair).or_insert(index), index, "{at}: {pair:?} is parted");
        }
    }
    for two in built.blocks.windows(2) {
        assert!(two[0].phase < two[1].phase || two[0].count >= two[1].count, "{at}: lengths ascend");
    }
}

#[test]
fn every_graph_gets_a_valid_schedule_that_keeps_the_promises() {
    for scene in graphs::all() {
        for block_links in [0, 1, 8, 32, 64, 128, u32::MAX] {
            let built = build(&scene, block_links, 0);
            assert_promises(&scene, block_links, &built);
        }
    }
}

#[test]
fn the_content_of_scratch_does_not_matter() {
    for scene in graphs::all() {
        let clean = build(&scene, 64, 0);
        for poison in [1, 0x5a5a_5a5a, u32::MAX] {
            assert!(build(&scene, 64, poison) == clean, "{}", scene.name);
        }
    }
}

#[test]
fn lattices_walls_and_pyramids_need_at_most_four_phases() {
    for scene in graphs::regular() {
        for block_links in [32, 64, 96, 128] {
            let phases = build(&scene, block_links, 0).phases();
            assert!(phases <= 4, "{} at {block_links}: {phases} phases", scene.name);
        }
    }
}

#[test]
fn most_links_of_a_large_wall_are_in_cells() {
    let scene = graphs::pyramid(60);
    let built = build(&scene, 64, 0);
    let cells: u32 = built.blocks.iter().filter(|block| block.phase == 0).map(|block| block.count).sum();
    assert!(cells as usize * 10 > scene.links.len() * 7, "{cells} of {}", scene.links.len());
}

#[test]
fn the_order_of_the_links_does_not_matter() {
    for mut scene in graphs::regular() {
        let pairs = |scene: &Scene, built: &Built| -> Vec<(u32, u32)> {
            let ends = |&link: &u32| (scene.links[link as usize].a, scene.links[link as usize].b);
            built.order.iter().map(ends).collect()
        };
        let before = build(&scene, 64, 0);
        let pairs_before = pairs(&scene, &before);
        Random(7).shuffle(&mut scene.links);
        let after = build(&scene, 64, 0);
        assert!(before.blocks == after.blocks, "{}", scene.name);
        assert!(pairs_before == pairs(&scene, &after), "{}", scene.name);
    }
}

#[test]
fn equals_the_naive_builder() {
    let mut random = Random(99);
    for round in 0..300 {
        let scene = graphs::arbitrary(&mut random);
        for block_links in [1, 20, 64] {
            let built = build(&scene, block_links, round);
            let expected = reference::schedule(&scene, documented_size(&scene, block_links));
            assert!(built == expected, "round {round} at {block_links}: {scene:?}");
        }
    }
    for scene in [graphs::pyramid(14), graphs::platform(12), graphs::lattice([6, 5, 4]), graphs::complete(24)]
    {
        let expected = reference::schedule(&scene, documented_size(&scene, 64));
        assert!(build(&scene, 64, 3) == expected, "{}", scene.name);
    }
}

#[test]
fn no_links_give_no_blocks() {
    for bodies in [0, 5] {
        let built = build(&Scene { name: "empty", bodies, links: vec![] }, 64, 9);
        assert_eq!(built, Built { order: vec![], blocks: vec![] });
    }
}

#[test]
fn links_to_immovable_bodies_make_one_block_per_body() {
    let built = build(&graphs::only_immovable(100), 64, 0);
    assert_eq!(built.phases(), 1);
    assert_eq!(built.blocks.len(), 100);
    assert!(built.blocks.iter().all(|block| block.count == 3));
}

#[test]
fn pairs_apart_make_one_phase() {
    let built = build(&graphs::pairs(500, 2), 64, 0);
    assert_eq!(built.phases(), 1);
    assert_eq!(built.blocks.len(), 500);
}

#[test]
fn a_pair_with_more_links_than_the_cap_stays_whole() {
    let built = build(&graphs::pairs(2, 5000), 64, 0);
    assert_eq!(built.phases(), 1);
    assert_eq!(built.blocks.iter().map(|block| block.count).collect::<Vec<_>>(), [5000, 5000]);
}

#[test]
fn a_body_that_brings_more_than_the_cap_is_taken_first_or_not_at_all() {
    let scene = graphs::knotted_chain(1000, 60);
    let built = build(&scene, 20, 0);
    assert_eq!(built.phases(), 2);
    assert!(built.blocks.iter().any(|block| block.count == 61), "the knot and its chain link");
    assert!(built == reference::schedule(&scene, 20));
}

#[test]
fn a_lone_star_is_one_block() {
    let built = build(&graphs::star(1000), 64, 0);
    assert_eq!(built.blocks, [Block { phase: 0, first: 0, count: 1000 }]);
}

#[test]
fn the_star_of_a_platform_is_its_links_alone() {
    let scene = graphs::platform(30);
    let built = build(&scene, 64, 0);
    let star = built.links(&built.blocks[0]);
    let hub = scene.bodies - 1;
    let of_hub = |link: &u32| scene.links[*link as usize].a == hub || scene.links[*link as usize].b == hub;
    assert_eq!(star.len(), 901);
    assert!(star.iter().all(of_hub));
    assert!(built.phases() <= 4, "{} phases", built.phases());
}

#[test]
fn every_hub_gets_its_star_in_the_first_phase() {
    let scene = graphs::touching_hubs(5, 400);
    let built = build(&scene, 64, 0);
    let stars = built.blocks.iter().filter(|block| block.phase == 0 && block.count == 400).count();
    assert_eq!(stars, 5);
    assert_eq!(built.phases(), 2);
}

#[test]
fn hubs_that_share_all_bodies_need_a_phase_each() {
    let built = build(&graphs::bipartite(3, 600), 64, 0);
    assert_eq!(built.phases(), 3);
    assert!(built.blocks.iter().all(|block| block.count == 600));
}

#[test]
fn the_last_phase_takes_connected_components() {
    let scene = graphs::dense_core(60, 600);
    let built = build(&scene, 1, 0);
    assert_eq!(built.phases() as usize, CELLULAR_PHASES_MAX);
    let last: Vec<&Block> = built.blocks.iter().filter(|block| block.phase == 7).collect();
    assert_eq!(last.len(), 1);
    assert!(last[0].count > 2 * documented_size(&scene, 1));
    assert!(built == reference::schedule(&scene, documented_size(&scene, 1)));
}

#[test]
fn a_closed_frontier_keeps_the_schedule_valid() {
    // 30,000 bodies with about six links to anywhere: a block of 3,750 links reaches many more bodies than it can
    // list.
    let scene = graphs::anywhere(30_000, 90_000, &mut Random(3));
    assert_promises(&scene, 100_000, &build(&scene, 100_000, 0));
}

#[test]
fn a_link_of_a_body_to_itself_is_harmless() {
    let links = vec![Link { a: 1, b: 1, kind: 0 }, Link { a: 0, b: 1, kind: 0 }];
    let built = build(&Scene { name: "self", bodies: 2, links }, 64, 0);
    let all: BTreeSet<u32> = built.order.iter().copied().collect();
    assert_eq!(all, BTreeSet::from([0, 1]));
    assert_eq!(built.blocks.len(), 1);
}
