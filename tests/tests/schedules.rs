//! Any valid schedule can be given: worlds behave under each, and what only groups the links differently gives the
//! same bits.

use cellstep::cells::{Link, PHASES_MAX};
use cellstep::scene::builtin::{BUILTIN, Builtin};
use cellstep::{Pool, Serial};
use cellstep_tests::executors::{Random, Shuffled};
use cellstep_tests::schedules::{self, Given, Phases};
use cellstep_tests::worlds::OwnedWorld;
use std::path::Path;

fn built(builtin: &Builtin) -> OwnedWorld {
    let scene = builtin.scene(builtin.golden_size).expect("the size is in range");
    scene.build(Path::new(".")).expect("built-in scenes build").world
}

fn find(name: &str) -> OwnedWorld {
    built(Builtin::find(name).expect("a built-in scene"))
}

/// Steps under an ordering, every schedule checked; says how many links and phases there were at most.
fn run(world: &mut OwnedWorld, steps: u32, order: impl FnMut(u32, &[Link]) -> Phases) -> (usize, usize) {
    let mut scheduler = Given::new(order);
    for step in 0..steps {
        let report = world.step_scheduled(&mut Serial, &mut scheduler);
        assert_eq!(report.quarantined, 0, "step {step}");
    }
    (scheduler.most_links, scheduler.most_phases)
}

#[test]
fn the_built_in_ordering_is_valid_on_all_scenes() {
    for builtin in BUILTIN {
        let (mut world, mut plain) = (built(builtin), built(builtin));
        let (links, phases) = run(&mut world, 150, schedules::cellular);
        // The kept ordering is checked by the step itself where debug assertions are on, as in tests.
        let kept = (0..150).map(|_| plain.step(&mut Serial).phases).max().unwrap_or(0);
        println!("{}: up to {links} links in {phases} phases, kept {kept}", builtin.name);
        assert!(kept <= 4, "{}: {kept} phases", builtin.name);
        let falls = builtin.name == "free_fall";
        assert!(falls || links > 15, "{}: {links} links", builtin.name);
        assert!(phases <= 4, "{}: {phases} phases", builtin.name);
    }
}

/// The pyramid of 22 rows stands: no box has left its row.
fn assert_stands(world: &OwnedWorld, name: &str) {
    let fresh = find("pyramid");
    for body in world.bodies() {
        let (now, then) = (world.center(body).expect("it exists"), fresh.center(body).expect("it exists"));
        let way = now.minus(then);
        assert!(way.x.abs() < 0.05 && way.y.abs() < 0.05, "{name}: {body:?} went {way}");
        assert!(way.z.abs() < 0.1, "{name}: {body:?} sank {way}");
    }
    assert!(world.contacts().count() > 400, "{name}");
}

#[test]
fn a_pyramid_stands_under_any_ordering() {
    const STEPS: u32 = 150;
    let mut world = find("pyramid");
    run(&mut world, STEPS, schedules::natural);
    assert_stands(&world, "natural");
    let mut world = find("pyramid");
    run(&mut world, STEPS, schedules::coloured);
    assert_stands(&world, "coloured");
    for phases in [2, 5, PHASES_MAX] {
        let mut world = find("pyramid");
        let mut seed = Random::new(phases as u64);
        run(&mut world, STEPS, |bodies, links| schedules::random(&mut seed, phases, (bodies, links)));
        assert_stands(&world, "random");
    }
}

/// A hub has more links than there are colours: all 32 phases are used, the last of them for the serial rest.
#[test]
fn as_many_phases_as_there_may_be() {
    let [mut world, mut shuffled, mut pooled] = [(); 3].map(|()| find("hub"));
    let (_, phases) = run(&mut world, 120, schedules::coloured);
    assert_eq!(phases, PHASES_MAX);
    let mut pool = Pool::new(3).expect("threads can be started");
    for _ in 0..120 {
        shuffled.step_scheduled(&mut Shuffled::new(1), &mut Given::new(schedules::coloured));
        pooled.step_scheduled(&mut pool, &mut Given::new(schedules::coloured));
    }
    assert!(shuffled.state() == world.state(), "shuffled");
    assert!(pooled.state() == world.state(), "3 workers");
    let mut world = find("hub");
    let mut seed = Random::new(9);
    let (_, phases) = run(&mut world, 120, |b, links| schedules::random(&mut seed, PHASES_MAX, (b, links)));
    assert!(phases > 8, "{phases} phases");
}

/// Blocks of a phase share no body, so their order says nothing, nor whether independent ones are one block.
#[test]
fn grouping_changes_no_bit() {
    for name in ["stacked_pyramid", "mixed_pile", "hub", "bowls"] {
        let mut plain = find(name);
        run(&mut plain, 120, schedules::cellular);
        let assert_same = |order: &mut dyn FnMut(u32, &[Link]) -> Phases, how: &str| {
            let mut world = find(name);
            run(&mut world, 120, order);
            assert!(world.state() == plain.state(), "{name}, {how}");
        };
        let mut seed = Random::new(3);
        assert_same(&mut |b, l| schedules::blocks_shuffled(&mut seed, schedules::cellular(b, l)), "shuffled");
        assert_same(&mut |b, l| schedules::blocks_split(schedules::cellular(b, l), (b, l)), "split");
        assert_same(&mut |b, l| schedules::blocks_joined(schedules::cellular(b, l)), "joined");
    }
}

/// A colouring with its phases one after the other in a single block is the same sequence of links.
#[test]
fn phases_in_one_block_change_no_bit() {
    for name in ["pyramid", "mixed_pile"] {
        let (mut world, mut serial) = (find(name), find(name));
        run(&mut world, 120, schedules::coloured);
        run(&mut serial, 120, |bodies, links| {
            let all = schedules::coloured(bodies, links).concat().concat();
            if all.is_empty() { Phases::new() } else { vec![vec![all]] }
        });
        assert!(serial.state() == world.state(), "{name}");
    }
}
