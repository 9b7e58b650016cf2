//! What the upkeep promises: valid schedules after every change, the same bits with and without cache, and
//! orderings hardly worse than fresh ones.

extern crate std;

mod churn;
mod driver;

use super::super::tests::graphs;
use super::super::tests::graphs::{Random, Scene};
use super::super::{IMMOVABLE, Link};
use super::{NEW, OrderingRow};
use churn::{Churn, Flicker, Pile, Trickle};
use driver::Driver;
use std::vec;
use std::vec::Vec;

/// Random links between few bodies, parallel and immovable ones among them; the first body has a third of them.
fn tangle(hub: u32, random: &mut Random) -> Scene {
    let bodies = 150;
    let mut links: Vec<Link> = (0..500)
        .map(|_| {
            let a = random.below(bodies);
            let b = (a + 1 + random.below(6)) % bodies;
            Link { a, b: if random.below(8) == 0 { IMMOVABLE } else { b }, kind: 0 }
        })
        .collect();
    links.extend((0..hub).map(|at| Link { a: 0, b: 1 + at % (bodies - 1), kind: 0 }));
    Scene { name: "tangle", bodies, links }
}

/// A wide platform with two layers of boxes on it.
fn platform() -> Scene {
    graphs::platform(20)
}

/// A hub under many small stacks: its block fills with links between boxes before it has enough for a hub.
fn carpet() -> Scene {
    let (stacks, height) = (150, 4);
    let hub = stacks * height;
    let links = (0..hub).flat_map(|body| {
        let above = (body % height + 1 < height).then_some(Link { a: body, b: body + 1, kind: 0 });
        above.into_iter().chain([Link { a: body, b: hub, kind: 0 }])
    });
    Scene { name: "carpet", bodies: hub + 1, links: links.collect() }
}

/// Runs a scene, with and without cache at every step; the cache that goes on is dropped now and then.
fn run_twice(churn: impl Churn, capacity: usize, steps: u32) {
    let mut driver = Driver::new(churn, capacity, 64);
    let mut random = Random(3);
    for _ in 0..steps {
        driver.advance();
        driver.update_twice(random.below(10) > 0);
        if random.below(20) == 0 {
            driver.recall();
        }
    }
    driver.check();
}

/// Switches links of a graph on and off, and checks the ordering after every update.
fn flicker(scene: &Scene, switches: u32) -> u32 {
    let mut driver = Driver::new(Flicker::new(scene.bodies, &scene.links, 3), scene.links.len(), 64);
    for step in 0.. {
        // A burst now and then, large enough for a fresh build.
        driver.churn.switches = if step % 500 == 0 { scene.links.len() as u32 } else { 1 + step % 5 };
        driver.advance();
        driver.update(true);
        driver.check();
        if driver.churn.switched >= switches {
            break;
        }
    }
    driver.churn.switched
}

#[test]
fn a_hundred_thousand_switched_links_leave_a_valid_schedule_each_time() {
    let random = &mut Random(17);
    let scenes = [tangle(0, random), tangle(250, random), graphs::pairs(20, 15), graphs::lattice([6, 6, 4])];
    let switched: u32 = scenes.iter().map(|scene| flicker(scene, 25_000)).sum();
    assert!(switched >= 100_000, "{switched}");
}

#[test]
fn the_cache_does_not_matter_in_a_pile() {
    run_twice(Pile::new([9, 9, 9], 60, 0), 4000, 150);
}

#[test]
fn the_cache_does_not_matter_when_bodies_come_and_go() {
    run_twice(Pile::new([9, 9, 9], 100, 12), 4000, 150);
}

#[test]
fn the_cache_does_not_matter_while_a_lattice_grows() {
    let lattice = graphs::lattice([8, 8, 8]);
    run_twice(Trickle::new(lattice.bodies, &lattice.links, 3), lattice.links.len(), 600);
}

#[test]
fn the_cache_does_not_matter_at_hubs() {
    for (switches, steps) in [(20, 150), (400, 40)] {
        let platform = platform();
        run_twice(Flicker::new(platform.bodies, &platform.links, switches), platform.links.len(), steps);
    }
    let bipartite = graphs::bipartite(3, 600);
    run_twice(Flicker::new(bipartite.bodies, &bipartite.links, 30), bipartite.links.len(), 100);
    for (hubs, pace, steps) in [(graphs::touching_hubs(5, 400), 20, 105), (platform(), 6, 370)] {
        run_twice(Trickle::new(hubs.bodies, &hubs.links, pace), hubs.links.len(), steps);
    }
}

#[test]
fn the_cache_does_not_matter_when_a_body_becomes_a_hub() {
    // A lattice beside the carpet, there from the beginning, for a large g.
    let (carpet, lattice) = (carpet(), graphs::lattice([9, 9, 9]));
    let mut links = carpet.links.clone();
    let shift = |body| if body == IMMOVABLE { body } else { body + carpet.bodies };
    links.extend(lattice.links.iter().map(|link| Link { a: shift(link.a), b: shift(link.b), kind: 0 }));
    let mut trickle = Trickle::new(carpet.bodies + lattice.bodies, &links, 4);
    trickle.start(|key| key.0 >= carpet.bodies);
    run_twice(trickle, links.len(), 260);
}

#[test]
fn the_cache_does_not_matter_with_parallel_links() {
    let mut random = Random(8);
    for scene in [tangle(200, &mut random), graphs::pairs(30, 40), graphs::knotted_chain(300, 60)] {
        run_twice(Flicker::new(scene.bodies, &scene.links, 9), scene.links.len(), 300);
    }
}

#[test]
fn any_block_size_will_do() {
    for block_links in [0, 1, 20, 1000, u32::MAX] {
        let lattice = graphs::lattice([7, 7, 7]);
        let flicker = Flicker::new(lattice.bodies, &lattice.links, 25);
        let mut driver = Driver::new(flicker, lattice.links.len(), block_links);
        for _ in 0..100 {
            driver.advance();
            driver.update_twice(true);
            driver.check();
        }
    }
}

#[test]
fn a_changed_block_size_makes_a_fresh_build() {
    let lattice = graphs::lattice([12, 12, 12]);
    let flicker = Flicker::new(lattice.bodies, &lattice.links, 40);
    let mut driver = Driver::new(flicker, lattice.links.len(), 64);
    let mut builds = 0;
    for step in 0..400 {
        driver.block_links = if step < 300 { 64 } else { 24 };
        driver.advance();
        driver.update_twice(true);
        builds += if step >= 290 { driver.ordering.report.builds } else { 0 };
    }
    assert_eq!(builds, 1);
    assert_eq!(driver.ordering.row.built, 24);
    driver.check();
}

#[test]
fn a_thousand_steps_of_churn_stay_near_a_fresh_build() {
    for (removals, period) in [(0, 120), (15, 240)] {
        let mut driver = Driver::new(Pile::new([12, 12, 12], period, removals), 9000, 64);
        let (mut sum, mut worst, mut count) = (0.0, 0.0_f64, 0);
        for step in 0..1000 {
            driver.advance();
            driver.update(true);
            assert!(driver.phases() <= 4, "step {step}: {} phases", driver.phases());
            if step % 4 == 0 {
                let gap = driver.fresh_share() - driver.share();
                (sum, worst, count) = (sum + gap, worst.max(gap), count + 1);
            }
        }
        driver.check();
        let average = sum / f64::from(count);
        assert!(average <= 4.0 && worst <= 7.0, "{removals} removals: average {average}, worst {worst}");
    }
}

#[test]
fn what_trickles_in_ends_with_few_phases_and_near_a_fresh_build() {
    for scene in [graphs::lattice([12, 12, 12]), graphs::lattice([50, 1, 40]), graphs::pyramid(60)] {
        let mut driver = Driver::new(Trickle::new(scene.bodies, &scene.links, 7), scene.links.len(), 64);
        while !driver.churn.is_done() {
            driver.advance();
            driver.update(true);
        }
        let mut rest = 0;
        while !driver.ordering.row.is_calm() {
            driver.advance();
            driver.update(true);
            rest += 1;
            assert!(rest < 1000, "{}: never calm", scene.name);
        }
        driver.check();
        let gap = driver.fresh_share() - driver.share();
        assert!(driver.phases() <= 4, "{}: {} phases", scene.name, driver.phases());
        assert!(gap <= 7.0, "{}: {gap} points below a fresh build", scene.name);
    }
}

#[test]
fn a_hub_that_trickles_in_has_its_star_and_few_phases() {
    let scene = platform();
    let hub = scene.bodies - 1;
    let mut driver = Driver::new(Trickle::new(scene.bodies, &scene.links, 2), scene.links.len(), 32);
    while !driver.churn.is_done() {
        driver.advance();
        driver.update(true);
        let g = driver.ordering.report.block_links;
        for block in driver.ordering.blocks.iter().filter(|block| block.count > 2 * g) {
            let links = &driver.ordering.order[block.first as usize..][..block.count as usize];
            let of_hub = |&link: &u32| {
                let link = driver.links[link as usize];
                link.a == hub || link.b == hub
            };
            assert!(links.iter().all(of_hub), "a block of {} links is no star", block.count);
        }
    }
    driver.check();
    assert!(driver.phases() <= 4, "{} phases", driver.phases());
    let star = driver.ordering.blocks[0];
    assert!(star.count > 350, "the star has {} of 401 links", star.count);
}

#[test]
fn a_hub_loses_and_gains_all_its_links_in_linear_time() {
    let star = graphs::star(100_000);
    let mut driver = Driver::new(Flicker::new(star.bodies, &star.links, 100_000), star.links.len(), 64);
    for _ in 0..4 {
        driver.advance();
        driver.update(true);
        assert_eq!(driver.phases(), 1);
        assert_eq!(driver.ordering.blocks.len(), 1);
    }
    driver.check();
}

#[test]
fn nothing_changes_at_rest() {
    let mut driver = Driver::new(Pile::new([9, 9, 9], 60, 3), 4000, 64);
    for _ in 0..50 {
        driver.advance();
        driver.update(true);
    }
    assert!(driver.ordering.row.is_calm());
    let before = driver.ordering.clone();
    driver.from = (0..driver.links.len() as u32).collect();
    driver.lost.clear();
    for cached in [true, true, false, true] {
        driver.update_twice(cached);
        let report = driver.ordering.report;
        assert_eq!((report.begun, report.moves, report.regrown, report.builds), (0, 0, 0, 0));
        driver.ordering.report = before.report;
        assert!(driver.ordering == before);
    }
}

#[test]
fn most_links_new_make_a_fresh_build() {
    let scene = graphs::lattice([9, 9, 9]);
    let mut driver =
        Driver::new(Trickle::new(scene.bodies, &scene.links, scene.links.len()), scene.links.len(), 64);
    driver.advance();
    driver.update(true);
    assert_eq!(driver.ordering.report.builds, 1);
    assert!((driver.share() - driver.fresh_share()).abs() < 1e-9);
    assert_eq!(driver.ordering.dirt, vec![0; scene.bodies as usize]);
    assert_eq!(driver.ordering.row, OrderingRow { built: 64, ..OrderingRow::default() });
    driver.check();
}

#[test]
fn no_links_are_no_trouble() {
    let mut driver = Driver::new(Flicker::new(5, &[Link { a: 1, b: 2, kind: 0 }], 1), 1, 64);
    for present in [1, 0, 1, 0] {
        driver.advance();
        driver.update_twice(true);
        driver.check();
        assert_eq!(driver.ordering.blocks.len(), present);
        assert_eq!(driver.from, vec![NEW; present]);
    }
}

#[test]
fn the_order_of_what_was_lost_does_not_matter() {
    let mut one = Driver::new(Pile::new([8, 8, 8], 60, 5), 4000, 64);
    let mut other = Driver::new(Pile::new([8, 8, 8], 60, 5), 4000, 64);
    for _ in 0..60 {
        for driver in [&mut one, &mut other] {
            driver.advance();
        }
        other.lost.reverse();
        other.lost.iter_mut().for_each(|ends| ends.reverse());
        one.update(true);
        other.update(true);
        assert!(one.ordering == other.ordering);
    }
}
