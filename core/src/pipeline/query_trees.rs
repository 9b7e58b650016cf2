//! The broadphase's trees as queries need them: boxes around the shapes as they are now.
//!
//! After a step the bodies have moved on from the boxes of the tree of moving shapes, and calls may have added,
//! moved or removed shapes since. So before queries the tree of moving shapes gets boxes of their poses: its
//! order serves as long as its shapes are the same ones, so nothing is sorted. The tree of static shapes is
//! built anew only when one of them changed. The state is only read; what is written is cache.

use crate::body::{CHANGED_SECTOR, Position};
use crate::collide::{bounds, tree};
use crate::executor::{Executor, Stage};
use crate::math::{Aabb, Pose, Vec3, max, max_each, min};
use crate::pipeline::broadphase::{home_sector, tree_box};
use crate::pipeline::solid;
use crate::pipeline::tasks::{Crew, Tasks, chunk, push};
use crate::pool::is_used;
use crate::shape::BOX_STALE;
use crate::state::{AssetTables, Cache, Scratch, State};

/// Boxes are larger than their shapes by this fraction of their coordinates: more than the rounding.
const SLACK: f32 = 1.0e-6;
/// And by this fraction of their size.
const SLACK_OF_SIZE: f32 = 1.0e-5;
/// Shapes whose boxes are worth a task.
const BOX_SHAPES: usize = 256;
/// Sizes beyond this do not widen the slack, metres: shapes without end.
const SIZE_MAX: f32 = 1.0e6;

/// Brings both trees to the shapes as they are.
pub(crate) fn refresh(
    state: &State<'_>,
    assets: &AssetTables<'_>,
    cache: &mut Cache<'_>,
    scratch: &mut Scratch<'_>,
) {
    if cache.header[0].queried != 0 {
        return;
    }
    refresh_static(state, assets, cache, scratch);
    let header = &cache.header[0];
    let order = &cache.moving_order[..header.moving_leaves as usize];
    if header.moving_listed != 0 {
        for &slot in order {
            scratch.tree_boxes[slot as usize] = current_box((state, assets), slot, header.sector);
        }
    } else {
        for slot in shapes(state, false) {
            scratch.tree_boxes[slot as usize] = current_box((state, assets), slot, header.sector);
        }
    }
    refresh_moving(state, cache, scratch);
}

/// The same at the end of a step, on an executor.
pub(crate) fn refresh_in_tasks<E: Executor>(
    state: &State<'_>,
    assets: &AssetTables<'_>,
    (cache, scratch): (&mut Cache<'_>, &mut Scratch<'_>),
    crew: &mut Crew<'_, E>,
) {
    refresh_static(state, assets, cache, scratch);
    let sector = cache.header[0].sector;
    let high = state.header[0].shapes.high as usize;
    let share = chunk(high, BOX_SHAPES);
    let mut tasks: Tasks<(usize, &mut [Aabb])> = Tasks::new();
    for (i, boxes) in scratch.tree_boxes[..high].chunks_mut(share).enumerate() {
        push(&mut tasks, (i * share, boxes));
    }
    crew.run(Stage::Finish, &mut tasks, |(first, boxes)| {
        for (i, own) in boxes.iter_mut().enumerate() {
            let slot = *first + i;
            if is_used(state.shape_used, slot as u32) {
                let body = &state.bodies[state.shapes[slot].body as usize];
                if !body.rests() {
                    *own = current_box((state, assets), slot as u32, sector);
                }
            }
        }
    });
    drop(tasks);
    refresh_moving(state, cache, scratch);
}

/// Builds the tree of shapes that rest anew when one of them changed.
fn refresh_static(
    state: &State<'_>,
    assets: &AssetTables<'_>,
    cache: &mut Cache<'_>,
    scratch: &mut Scratch<'_>,
) {
    let stamp = state.header[0].static_version + 1;
    if cache.header[0].static_stamp == stamp {
        return;
    }
    cache.header[0].sector = home_sector(state);
    let sector = cache.header[0].sector;
    for slot in shapes(state, true) {
        scratch.tree_boxes[slot as usize] = static_box((state, assets), slot, sector);
    }
    let (order, nodes) = (&mut *cache.static_order, &mut *cache.static_nodes);
    let leaves = tree::build(scratch.tree_boxes, shapes(state, true), scratch.tree_keys, order, nodes);
    cache.header[0].static_leaves = leaves as u32;
    cache.header[0].static_stamp = stamp;
}

/// Brings the tree of shapes that move to their boxes in the scratch.
fn refresh_moving(state: &State<'_>, cache: &mut Cache<'_>, scratch: &mut Scratch<'_>) {
    let (order, nodes) = (&mut *cache.moving_order, &mut *cache.moving_nodes);
    if cache.header[0].moving_listed != 0 {
        tree::refit(scratch.tree_boxes, &order[..cache.header[0].moving_leaves as usize], nodes);
    } else {
        let leaves = tree::build(scratch.tree_boxes, shapes(state, false), scratch.tree_keys, order, nodes);
        cache.header[0].moving_leaves = leaves as u32;
        cache.header[0].moving_listed = 1;
    }
    cache.header[0].moving_fits = 0;
    cache.header[0].queried = 1;
}

/// Slots of the shapes of bodies that rest (static or asleep), or of the others.
fn shapes<'a>(state: &'a State<'_>, is_static: bool) -> impl Iterator<Item = u32> + 'a {
    crate::pool::iterate(state.shape_used, state.header[0].shapes.high).filter(move |&slot| {
        let body = state.shapes[slot as usize].body as usize;
        state.bodies[body].rests() == is_static
    })
}

/// The fat box of a static shape, unless it is not of the shape as it is.
fn static_box((state, assets): (&State<'_>, &AssetTables<'_>), slot: u32, sector: [i32; 3]) -> Aabb {
    let shape = &state.shapes[slot as usize];
    let is_stale = shape.flags & BOX_STALE != 0 || state.bodies[shape.body as usize].has(CHANGED_SECTOR);
    if is_stale { current_box((state, assets), slot, sector) } else { tree_box(state, slot, sector) }
}

/// A box around a shape as it is, in the trees' coordinates.
fn current_box((state, assets): (&State<'_>, &AssetTables<'_>), slot: u32, sector: [i32; 3]) -> Aabb {
    let shape = &state.shapes[slot as usize];
    let (motion, body) = (&state.motions[shape.body as usize], &state.bodies[shape.body as usize]);
    let local = motion.local_to_center(body, &shape.pose);
    let center = motion.center.minus(Position { sector, offset: Vec3::ZERO });
    let tight = bounds::aabb(&solid(shape, assets), &Pose::new(local.position + center, local.rotation));
    let size = tight.half_extents();
    let size = min(max(size.x, max(size.y, size.z)), SIZE_MAX) * SLACK_OF_SIZE;
    // Each number that went into a coordinate was rounded: the center's, the arm's, and the sum.
    let arm = local.position.abs();
    let slack = (max_each(tight.min.abs(), tight.max.abs()) + center.abs() + arm) * SLACK;
    let slack = crate::math::min_each(slack, Vec3::splat(SIZE_MAX)) + Vec3::splat(size);
    Aabb { min: tight.min - slack, max: tight.max + slack }
}
