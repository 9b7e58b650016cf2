//! Contact graphs for the tests of the ordering.

extern crate std;

use super::super::{IMMOVABLE, Link};
use std::vec;
use std::vec::Vec;

/// A named contact graph.
#[derive(Clone, Debug)]
pub struct Scene {
    pub name: &'static str,
    pub bodies: u32,
    pub links: Vec<Link>,
}

/// A linear congruential generator; the upper bits are used.
pub struct Random(pub u64);

impl Random {
    /// A number below `limit`.
    pub fn below(&mut self, limit: u32) -> u32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((self.0 >> 33) % u64::from(limit)) as u32
    }

    /// A random permutation.
    pub fn shuffle<T>(&mut self, items: &mut [T]) {
        for last in (1..items.len()).rev() {
            items.swap(last, self.below(last as u32 + 1) as usize);
        }
    }
}

/// A link of kind 4.
fn link(a: u32, b: u32) -> Link {
    Link { a, b, kind: 4 }
}

/// Graphs like those of stacked boxes.
pub fn regular() -> Vec<Scene> {
    vec![
        pyramid(10),
        pyramid(60),
        solid_pyramid(14),
        lattice([60, 1, 40]),
        lattice([12, 12, 12]),
        lattice([30, 30, 2]),
        lattice([400, 1, 1]),
    ]
}

/// All kinds of graphs.
pub fn all() -> Vec<Scene> {
    let mut random = Random(1);
    let mut scenes = regular();
    scenes.extend([
        chain(1000),
        pairs(300, 1),
        pairs(5, 300),
        only_immovable(100),
        star(1000),
        platform(20),
        touching_hubs(5, 400),
        bipartite(3, 600),
        bipartite(40, 60),
        complete(40),
        complete(3),
        dense_core(60, 600),
        knotted_chain(1000, 60),
        skewed(2000, 9000, &mut random),
        anywhere(3000, 9000, &mut random),
        anywhere(300, 6000, &mut random),
        pile([14, 14, 14], &mut random),
    ]);
    for _ in 0..40 {
        scenes.push(arbitrary(&mut random));
    }
    scenes
}

/// A face of boxes, `base` of them at the bottom: each touches two below and its neighbours, the lowest the ground.
pub fn pyramid(base: u32) -> Scene {
    let mut links = vec![];
    let (mut start, mut below) = (0, 0);
    for row in 0..base {
        let width = base - row;
        for at in 0..width {
            let body = start + at;
            if row == 0 {
                links.push(link(body, IMMOVABLE));
            } else {
                links.extend([0, 1].map(|step| Link { kind: 2, ..link(below + at + step, body) }));
            }
            if at + 1 < width {
                links.push(link(body, body + 1));
            }
        }
        (below, start) = (start, start + width);
    }
    Scene { name: "pyramid", bodies: start, links }
}

/// Square layers of boxes, each on four boxes of the layer below.
pub fn solid_pyramid(base: u32) -> Scene {
    let mut links = vec![];
    let (mut start, mut below) = (0, 0);
    for layer in 0..base {
        let width = base - layer;
        for at in 0..width * width {
            let (x, y) = (at % width, at / width);
            if layer == 0 {
                links.push(link(start + at, IMMOVABLE));
            } else {
                let under = [(0, 0), (1, 0), (0, 1), (1, 1)];
                links.extend(under.map(|(i, j)| link(below + (y + j) * (width + 1) + x + i, start + at)));
            }
        }
        (below, start) = (start, start + width * width);
    }
    Scene { name: "solid pyramid", bodies: start, links }
}

/// Boxes in rows, columns and layers, touching face to face, on the ground.
pub fn lattice(size: [u32; 3]) -> Scene {
    let steps = [(1, 0, 0), (0, 1, 0), (0, 0, 1)];
    Scene { name: "lattice", bodies: size[0] * size[1] * size[2], links: lattice_links(size, &steps) }
}

/// A lattice with random ones of all 26 neighbours: about six links per body, of four kinds.
pub fn pile(size: [u32; 3], random: &mut Random) -> Scene {
    let steps: Vec<(i32, i32, i32)> = (14..27).map(|at| (at % 3 - 1, at / 3 % 3 - 1, at / 9 - 1)).collect();
    let mut links = lattice_links(size, &steps);
    links.retain(|link| link.b == IMMOVABLE || random.below(4) == 0);
    for link in &mut links {
        link.kind = 1 + random.below(4);
    }
    Scene { name: "pile", bodies: size[0] * size[1] * size[2], links }
}

/// Links of a lattice along the given steps, and of its lowest layer to the ground.
fn lattice_links(size: [u32; 3], steps: &[(i32, i32, i32)]) -> Vec<Link> {
    let mut links = vec![];
    for body in 0..size[0] * size[1] * size[2] {
        let (x, y, z) = (body % size[0], body / size[0] % size[1], body / size[0] / size[1]);
        if z == 0 {
            links.push(link(body, IMMOVABLE));
        }
        for step in steps {
            let to =
                [x.wrapping_add_signed(step.0), y.wrapping_add_signed(step.1), z.wrapping_add_signed(step.2)];
            if to[0] < size[0] && to[1] < size[1] && to[2] < size[2] {
                links.push(link(body, (to[2] * size[1] + to[1]) * size[0] + to[0]));
            }
        }
    }
    links
}

/// A chain that hangs from the ceiling.
pub fn chain(bodies: u32) -> Scene {
    let mut links: Vec<Link> = (1..bodies).map(|body| link(body - 1, body)).collect();
    links.push(link(0, IMMOVABLE));
    Scene { name: "chain", bodies, links }
}

/// A chain with one pair in the middle that has many links, more than g but not enough for a hub.
pub fn knotted_chain(bodies: u32, parallel: u32) -> Scene {
    let mut links = chain(bodies).links;
    links.extend((0..parallel).map(|_| link(bodies / 2, bodies / 2 + 1)));
    Scene { name: "knotted chain", bodies, links }
}

/// Pairs of bodies with parallel links in both directions.
pub fn pairs(pairs: u32, parallel: u32) -> Scene {
    let mut links = vec![];
    for pair in 0..pairs {
        for at in 0..parallel {
            let (a, b) = if at % 2 == 0 { (0, 1) } else { (1, 0) };
            links.push(Link { a: 2 * pair + a, b: 2 * pair + b, kind: at % 3 });
        }
    }
    Scene { name: "pairs", bodies: 2 * pairs, links }
}

/// Bodies with three links to immovable ones.
pub fn only_immovable(bodies: u32) -> Scene {
    let links = (0..3 * bodies).map(|at| link(at % bodies, IMMOVABLE)).collect();
    Scene { name: "only immovable", bodies, links }
}

/// A hub in the middle of the ids, with leaves.
pub fn star(leaves: u32) -> Scene {
    let hub = leaves / 2;
    let links = (0..=leaves).filter(|&leaf| leaf != hub).map(|leaf| link(leaf, hub)).collect();
    Scene { name: "star", bodies: leaves + 1, links }
}

/// Two layers of boxes on one large body on the ground.
pub fn platform(side: u32) -> Scene {
    let mut scene = lattice([side, side, 2]);
    let hub = scene.bodies;
    for link in scene.links.iter_mut().filter(|link| link.b == IMMOVABLE) {
        link.b = hub;
    }
    scene.links.push(link(hub, IMMOVABLE));
    Scene { name: "platform", bodies: hub + 1, links: scene.links }
}

/// Hubs with leaves of their own, in a row.
pub fn touching_hubs(hubs: u32, leaves: u32) -> Scene {
    let mut links: Vec<Link> = (1..hubs).map(|hub| link(hub - 1, hub)).collect();
    links.extend((0..hubs * leaves).map(|at| link(at / leaves, hubs + at)));
    Scene { name: "touching hubs", bodies: hubs + hubs * leaves, links }
}

/// Every body of one side touches every one of the other.
pub fn bipartite(left: u32, right: u32) -> Scene {
    let links = (0..left * right).map(|at| link(at / right, left + at % right)).collect();
    Scene { name: "bipartite", bodies: left + right, links }
}

/// Every body touches every other.
pub fn complete(bodies: u32) -> Scene {
    let links = (0..bodies).flat_map(|a| (a + 1..bodies).map(move |b| link(a, b))).collect();
    Scene { name: "complete", bodies, links }
}

/// A complete graph hidden in a long chain, so that g follows the chain: it fills capped blocks for phases on end.
pub fn dense_core(core: u32, bodies: u32) -> Scene {
    let mut links = complete(core).links;
    links.extend((core..bodies).map(|body| link(body - 1, body)));
    Scene { name: "dense core", bodies, links }
}

/// Links between random bodies, no two alike.
pub fn anywhere(bodies: u32, links: u32, random: &mut Random) -> Scene {
    let mut pairs: Vec<(u32, u32)> = (0..links)
        .map(|_| (random.below(bodies), random.below(bodies)))
        .filter(|(a, b)| a < b)
        .chain((1..bodies).map(|body| (body - 1, body)))
        .collect();
    pairs.sort_unstable();
    pairs.dedup();
    Scene { name: "anywhere", bodies, links: pairs.into_iter().map(|(a, b)| link(a, b)).collect() }
}

/// Bodies of low id have most of the links.
pub fn skewed(bodies: u32, links: u32, random: &mut Random) -> Scene {
    let mut list = vec![];
    for _ in 0..links {
        let range = 1 + random.below(bodies - 1);
        let (a, b) = (random.below(range), random.below(bodies));
        if a != b {
            list.push(Link { a, b, kind: random.below(3) });
        }
    }
    Scene { name: "skewed", bodies, links: list }
}

/// A small graph with everything at once: parallel and immovable links, hubs, kinds, any order.
pub fn arbitrary(random: &mut Random) -> Scene {
    let bodies = 2 + random.below(70);
    let (hubs, hub_share) = (1 + random.below(3).min(bodies - 1), random.below(4));
    let mut links = vec![];
    for _ in 0..random.below(400) {
        let near = random.below(2) == 0;
        let a = if random.below(8) < hub_share { random.below(hubs) } else { random.below(bodies) };
        let b = if near { (a + 1 + random.below(4)) % bodies } else { random.below(bodies) };
        let b = if random.below(7) == 0 || b == a { IMMOVABLE } else { b };
        links.push(Link { a, b, kind: random.below(4) });
    }
    Scene { name: "arbitrary", bodies, links }
}
