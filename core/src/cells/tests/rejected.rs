//! `check` must find every way in which a schedule can be broken.

extern crate std;

use super::super::*;
use super::{Built, build, graphs};
use std::vec;

/// What `check` says after a change to a good schedule of a small pyramid.
fn verdict(change: impl FnOnce(&mut Built)) -> Result<(), ScheduleError> {
    let scene = graphs::pyramid(12);
    let mut built = build(&scene, 16, 0);
    assert!(built.phases() >= 2 && built.blocks[1].phase == 0, "the scene is too simple for this test");
    change(&mut built);
    let mut scratch = vec![0xdead_beef; check_words(scene.bodies as usize, scene.links.len())];
    let count = built.blocks.len();
    let schedule = Schedule { order: &mut built.order, blocks: &mut built.blocks, block_count: count };
    check(scene.bodies, &scene.links, &schedule, &mut scratch)
}

/// Index of the first block of phase 1.
fn first_membrane(built: &Built) -> usize {
    built.blocks.iter().position(|block| block.phase == 1).expect("a second phase")
}

#[test]
fn an_unchanged_schedule_passes() {
    assert_eq!(verdict(|_| {}), Ok(()));
}

#[test]
fn a_repeated_link_is_found() {
    let mut link = 0;
    let result = verdict(|built| {
        link = built.order[0];
        built.order[7] = link;
    });
    assert_eq!(result, Err(ScheduleError::LinkTwice { link }));
}

#[test]
fn an_unknown_link_is_found() {
    let result = verdict(|built| built.order[5] = built.order.len() as u32);
    assert_eq!(result, Err(ScheduleError::LinkOutOfRange { place: 5 }));
}

#[test]
fn gaps_overlaps_and_empty_blocks_are_found() {
    assert_eq!(verdict(|built| built.blocks[1].first += 1), Err(ScheduleError::Gap { block: 1 }));
    assert_eq!(verdict(|built| built.blocks[1].first -= 1), Err(ScheduleError::Gap { block: 1 }));
    assert_eq!(verdict(|built| built.blocks[0].count += 1), Err(ScheduleError::Gap { block: 1 }));
    let empty = verdict(|built| {
        let first = built.blocks[2].first;
        built.blocks.insert(2, Block { phase: 0, first, count: 0 });
    });
    assert_eq!(empty, Err(ScheduleError::Gap { block: 2 }));
}

#[test]
fn missing_and_excess_links_are_found() {
    assert_eq!(verdict(|built| _ = built.blocks.pop()), Err(ScheduleError::WrongTotal));
    let longer = |built: &mut Built| built.blocks.last_mut().expect("a block").count += 1;
    assert_eq!(verdict(longer), Err(ScheduleError::WrongTotal));
    let wrapping = |built: &mut Built| built.blocks.last_mut().expect("a block").count = u32::MAX;
    assert_eq!(verdict(wrapping), Err(ScheduleError::WrongTotal));
}

#[test]
fn phases_that_skip_descend_or_start_late_are_found() {
    let skip = verdict(|built| {
        let at = first_membrane(built);
        built.blocks[at..].iter_mut().for_each(|block| block.phase += 1);
    });
    assert!(matches!(skip, Err(ScheduleError::PhaseOutOfOrder { .. })), "{skip:?}");
    let descend = verdict(|built| {
        let at = first_membrane(built);
        built.blocks[at + 1].phase = 0;
    });
    assert!(matches!(descend, Err(ScheduleError::PhaseOutOfOrder { .. })), "{descend:?}");
    let late = verdict(|built| built.blocks.iter_mut().for_each(|block| block.phase += 1));
    assert_eq!(late, Err(ScheduleError::PhaseOutOfOrder { block: 0 }));
    let wrapped = verdict(|built| built.blocks[0].phase = u32::MAX);
    assert_eq!(wrapped, Err(ScheduleError::PhaseOutOfOrder { block: 0 }));
}

#[test]
fn too_many_phases_are_found() {
    let links: [Link; PHASES_MAX + 1] =
        core::array::from_fn(|body| Link { a: body as u32, b: IMMOVABLE, kind: 0 });
    let mut order: [u32; PHASES_MAX + 1] = core::array::from_fn(|link| link as u32);
    let mut blocks: [Block; PHASES_MAX + 1] =
        core::array::from_fn(|at| Block { phase: at as u32, first: at as u32, count: 1 });
    let mut scratch = [0; 200];
    let schedule = Schedule { order: &mut order, blocks: &mut blocks, block_count: PHASES_MAX + 1 };
    let result = check(links.len() as u32, &links, &schedule, &mut scratch);
    assert_eq!(result, Err(ScheduleError::PhaseOutOfOrder { block: PHASES_MAX as u32 }));
}

#[test]
fn a_body_in_two_blocks_of_a_phase_is_found() {
    // A membrane touches cells on both sides: as a cell it conflicts with them.
    let merged = verdict(|built| {
        let at = first_membrane(built);
        built.blocks[at].phase = 0;
    });
    assert!(matches!(merged, Err(ScheduleError::Conflict { .. })), "{merged:?}");
    // A connected block cut in two shares a body with itself.
    let cut = verdict(|built| {
        let block = &mut built.blocks[0];
        let half = block.count / 2;
        let rest = Block { phase: 0, first: block.first + half, count: block.count - half };
        block.count = half;
        built.blocks.insert(1, rest);
    });
    assert!(matches!(cut, Err(ScheduleError::Conflict { block: 1, .. })), "{cut:?}");
}

#[test]
fn a_conflict_across_blocks_in_between_is_found() {
    let links = [(0, 1), (2, 3), (1, 4)].map(|(a, b)| Link { a, b, kind: 0 });
    let mut blocks = [0, 1, 2].map(|at| Block { phase: 0, first: at, count: 1 });
    let schedule = Schedule { order: &mut [0, 1, 2], blocks: &mut blocks, block_count: 3 };
    let result = check(5, &links, &schedule, &mut [7; 20]);
    assert_eq!(result, Err(ScheduleError::Conflict { body: 1, block: 2 }));
}

#[test]
fn immovable_ends_make_no_conflict() {
    let links = [0, 1].map(|a| Link { a, b: IMMOVABLE, kind: 0 });
    let mut blocks = [0, 1].map(|at| Block { phase: 0, first: at, count: 1 });
    let schedule = Schedule { order: &mut [0, 1], blocks: &mut blocks, block_count: 2 };
    assert_eq!(check(2, &links, &schedule, &mut [7; 20]), Ok(()));
}

#[test]
fn the_arguments_are_checked_too() {
    let links = [Link { a: 0, b: 1, kind: 0 }];
    let run = |bodies: u32, links: &[Link], scratch: usize, order: &mut [u32], block_count: usize| {
        let mut blocks = [Block { phase: 0, first: 0, count: 1 }];
        let schedule = Schedule { order, blocks: &mut blocks, block_count };
        check(bodies, links, &schedule, &mut vec![0; scratch])
    };
    assert_eq!(run(2, &links, 5, &mut [0], 1), Ok(()));
    assert_eq!(run(2, &links, 4, &mut [0], 1), Err(ScheduleError::ScratchTooSmall));
    assert_eq!(run(2, &links, 5, &mut [], 1), Err(ScheduleError::TooShort));
    assert_eq!(run(2, &links, 5, &mut [0], 2), Err(ScheduleError::TooShort));
    assert_eq!(run(1, &links, 5, &mut [0], 1), Err(ScheduleError::BodyOutOfRange { link: 0 }));
    let immovable = [Link { a: IMMOVABLE, b: 0, kind: 0 }];
    assert_eq!(run(2, &immovable, 5, &mut [0], 1), Err(ScheduleError::BodyOutOfRange { link: 0 }));
}

#[test]
fn errors_say_what_is_wrong() {
    let text = std::format!("{}", ScheduleError::Conflict { body: 3, block: 7 });
    assert_eq!(text, "body 3 of block 7 is in another block of the phase");
}
