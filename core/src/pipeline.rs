//! The step: who touches what in which order.
//!
//! ```text
//! broadphase -> narrowphase -> islands -> ordering -> assembly -> solve (integration included) -> finish
//! ```
//! Every stage takes the views it needs and an executor; a stage's tasks own what they write.

pub(crate) mod approach;
pub(crate) mod articulations;
pub(crate) mod assembly;
pub(crate) mod balls;
pub(crate) mod broadphase;
pub(crate) mod contacts;
pub(crate) mod continuous;
pub(crate) mod events;
pub(crate) mod finish;
pub(crate) mod integration;
pub(crate) mod joints;
pub(crate) mod layout;
pub(crate) mod leapfrog;
pub(crate) mod meeting;
pub(crate) mod mover;
pub(crate) mod narrowphase;
pub(crate) mod ordering;
pub(crate) mod query_trees;
pub(crate) mod refine;
pub(crate) mod residual;
pub(crate) mod rows;
pub(crate) mod rules;
pub(crate) mod seat;
pub(crate) mod sensors;
pub(crate) mod sleep;
pub(crate) mod solver;
pub(crate) mod stiffening;
pub(crate) mod tasks;

use crate::cells::{IMMOVABLE, Scheduler};
use crate::collide::Solid;
use crate::config::Settings;
use crate::executor::{Executor, Stage};
use crate::math::Vec3;
use crate::observe::{Observer, Rows as ObservedRows, StageView};
use crate::pool;
use crate::report::StepReport;
use crate::shape::{
    GEOMETRY_BOX, GEOMETRY_CAPSULE, GEOMETRY_COMPOUND, GEOMETRY_CONE, GEOMETRY_CYLINDER, GEOMETRY_HALF_SPACE,
    GEOMETRY_HEIGHT_FIELD, GEOMETRY_HULL, GEOMETRY_MESH, GEOMETRY_ROUNDED_HULL, ShapeRow,
};
use crate::state::{AssetTables, Cache, Scratch, State};
use articulations::Patterns;
use layout::Plan;
use ordering::Links;
use solver::{JointRows, Solved};
use tasks::{ALONE_BODIES, ALONE_CONTACTS, Crew};

/// Events that a step counts.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Counts {
    pub dropped_pairs: u32,
    pub dropped_contacts: u32,
    pub quarantined: u32,
    pub capped: u32,
    pub broken: u32,
    /// Fast bodies, and those of them that were stopped on their way.
    pub fast: u32,
    pub cut: u32,
    /// Whether there are kinematic bodies.
    pub kinematic: bool,
    /// Bodies that have been quiet for long enough.
    pub ready: u32,
    /// Pairs in the scratch's list of those whose contacts ended, and of those whose began.
    pub ended: usize,
    pub began: usize,
    /// Contacts of the step before, in the scratch when some began or ended.
    pub contacts_before: usize,
    pub dropped_events: u32,
    pub dropped_visits: u32,
    /// Bodies that are refined.
    pub refined: u32,
}

/// The memory of a world, region by region.
pub(crate) struct Regions<'a> {
    pub assets: AssetTables<'a>,
    pub state: State<'a>,
    pub cache: Cache<'a>,
    pub scratch: Scratch<'a>,
}

/// Takes one step.
pub(crate) fn step<E: Executor, S: Scheduler>(
    regions: &mut Regions<'_>,
    settings: &Settings,
    (executor, observer): (&mut E, &mut impl Observer),
    scheduler: Option<&mut S>,
) -> StepReport {
    let Regions { assets, state, cache, scratch } = regions;
    let mut counts = Counts::default();
    events::begin(state);
    events::begin_moved(state);
    if settings.dt == 0.0 {
        state.header[0].step += 1;
        return report(state, None, (0, &counts, 0));
    }
    // Bodies move: the trees' boxes are no longer around the shapes.
    cache.header[0].queried = 0;
    contacts::place_memos(state, cache);
    let header = &state.header[0];
    let links = header.contacts + header.joints.count;
    let is_alone = links < ALONE_CONTACTS && header.bodies.count < ALONE_BODIES;
    let mut crew = Crew { executor, barriers: 0, is_alone };
    crew.executor.enter(Stage::Broadphase);
    let moved = broadphase::run(state, (assets, settings.dt), (cache, scratch), (&mut crew, &mut counts));
    if state.header[0].pair_rules > 0 {
        rules::end_ignored(state, (assets, settings.dt));
    }
    let woken = sleep::wake(state, (assets, settings.dt), (cache, scratch), &mut counts);
    events::roused(state, &mut counts);
    observer.after(Stage::Broadphase, &StageView::new(state));
    crew.executor.enter(Stage::Narrowphase);
    let looks = (&*assets, settings, moved, woken);
    let change = narrowphase::run(state, looks, (cache, scratch), (&mut crew, &mut counts));
    events::contacts(state, scratch, &mut counts);
    observer.after(Stage::Narrowphase, &StageView::new(state));
    crew.executor.enter(Stage::Islands);
    let links = activate(state, (cache, scratch), (settings, change.any), &mut crew);
    observer.after(Stage::Islands, &StageView::new(state));
    crew.executor.enter(Stage::Ordering);
    let plan = ordering::run(state, (cache, scratch), (&change, links, settings), scheduler);
    if state.header[0].refine != 0 {
        counts.refined = cache.refined.iter().map(|bits| bits.count_ones()).sum();
    }
    observer.after(Stage::Ordering, &StageView::new(state));
    crew.executor.enter(Stage::Assembly);
    assembly::prepare_bodies(state, scratch, (settings, links), &mut crew);
    assembly::fill(state, (cache, scratch), (settings, &plan, links), &mut crew);
    let seen = ObservedRows { scratch, cache, plan: &plan, bodies: links.bodies };
    observer.after(Stage::Assembly, &StageView::with_rows(state, seen));
    crew.executor.enter(Stage::Solve);
    let solved = solve((cache, scratch), &plan, settings, &mut crew);
    let seen = ObservedRows { scratch, cache, plan: &plan, bodies: links.bodies };
    observer.after(Stage::Solve, &StageView::with_rows(state, seen));
    crew.executor.enter(Stage::Finish);
    events::hits(state, (cache, scratch), (&plan, settings), &mut counts);
    let joints = (&plan, links, settings);
    joints::store(state, (cache, scratch), joints, (&mut crew, &mut counts));
    finish::run(state, (assets, cache, scratch), (&plan, settings), (&mut crew, &mut counts));
    if counts.quarantined > 0 {
        finish::move_quarantined(state, cache, scratch);
    }
    sensors::run(state, (assets, moved), (cache, scratch), (&mut crew, &mut counts));
    if let Some(steps) = settings.sleep_steps().filter(|_| counts.ready > 0) {
        sleep::fall(state, (cache, scratch), (links, steps), &mut counts);
    }
    observer.after(Stage::Finish, &StageView::new(state));
    crew.executor.leave();
    let report = report(state, Some(&plan), (links.bodies as u32, &counts, crew.barriers));
    StepReport { residuals: solved.residuals, sweeps: solved.sweeps, unsettled: solved.unsettled, ..report }
}

/// Sweeps over the rows.
fn solve<E: Executor>(
    (cache, scratch): (&mut Cache<'_>, &mut Scratch<'_>),
    plan: &Plan,
    settings: &Settings,
    crew: &mut Crew<'_, E>,
) -> Solved {
    let mut rows = solver::Rows {
        plan,
        groups: &cache.groups[..plan.groups],
        links: scratch.link_rows,
        points: scratch.point_rows,
        resists: scratch.resist_rows,
        cones: assembly::cones_of(settings, scratch.cone_rows),
        joints: JointRows {
            balls: scratch.ball_rows,
            links: scratch.joint_links,
            locks: scratch.lock_rows,
            bounds: scratch.bound_rows,
            nodes: scratch.node_rows,
            blocks: scratch.block_rows,
        },
        patterns: Patterns { rows: cache.articulations, nodes: cache.nodes, blocks: cache.blocks },
        seats: scratch.seats,
        sources: cache.seat_sources,
        movers: scratch.movers,
    };
    solver::solve(&mut rows, settings, crew)
}

/// Lists the bodies that take part in the solve, and the links between them, and brings their tiers up to date.
fn activate<E: Executor>(
    state: &mut State<'_>,
    (cache, scratch): (&mut Cache<'_>, &mut Scratch<'_>),
    (settings, began): (&Settings, bool),
    crew: &mut Crew<'_, E>,
) -> Links {
    let header = &state.header[0];
    let mut count = 0;
    scratch.active_of[..header.bodies.high as usize].fill(IMMOVABLE);
    for slot in pool::iterate(state.body_used, header.bodies.high) {
        if state.bodies[slot as usize].is_active() {
            scratch.active_of[slot as usize] = count as u32;
            scratch.active[count].body = slot;
            count += 1;
        }
    }
    let contacts = ordering::write_contacts(state, scratch, crew);
    let held = ordering::list_held(state, scratch);
    refine::run(state, (cache, scratch), settings, (contacts, held, began));
    let loose = ordering::write_joints(state, (cache, scratch), (contacts, held), settings.direct_joints);
    let links = Links { bodies: count, contacts, joints: loose, articulated: held - loose };
    leapfrog::mark(state, (cache, scratch), (links, settings));
    links
}

fn report(
    state: &State<'_>,
    plan: Option<&Plan>,
    (bodies, counts, barriers): (u32, &Counts, u32),
) -> StepReport {
    let header = &state.header[0];
    StepReport {
        step: header.step,
        bodies: header.bodies.count,
        active: bodies,
        refined: counts.refined,
        asleep: header.asleep,
        pairs: header.pairs,
        contacts: header.contacts,
        joints: header.joints.count,
        phases: plan.filter(|plan| plan.blocks > 0).map_or(0, Plan::phases),
        blocks: plan.map_or(0, |plan| plan.blocks as u32),
        barriers,
        dropped: counts.dropped_pairs + counts.dropped_contacts,
        quarantined: counts.quarantined,
        capped: counts.capped,
        cut: counts.cut,
        broken: counts.broken,
        events: header.events,
        dropped_events: counts.dropped_events,
        visits: header.visits,
        dropped_visits: counts.dropped_visits,
        sweeps: 0,
        unsettled: 0,
        residuals: None,
    }
}

/// A shape's geometry with its tables.
#[inline]
pub(crate) fn solid<'a>(shape: &ShapeRow, assets: &AssetTables<'a>) -> Solid<'a> {
    let size = shape.size;
    match shape.kind {
        GEOMETRY_CAPSULE => Solid::Capsule { radius: size[0], half_height: size[1] },
        GEOMETRY_BOX => Solid::Box { half_extents: Vec3::from_array(size) },
        GEOMETRY_HULL => Solid::Hull(assets.hulls[shape.asset() as usize].view()),
        GEOMETRY_HALF_SPACE => Solid::HalfSpace,
        GEOMETRY_MESH => Solid::Mesh(assets.mesh(shape.asset())),
        GEOMETRY_CYLINDER => Solid::Cylinder { radius: size[0], half_height: size[1] },
        GEOMETRY_CONE => Solid::Cone { radius: size[0], half_height: size[1] },
        GEOMETRY_ROUNDED_HULL => {
            Solid::RoundedHull { hull: assets.hulls[shape.asset() as usize].view(), radius: size[1] }
        }
        GEOMETRY_HEIGHT_FIELD => Solid::HeightField(assets.height_field(shape.asset())),
        GEOMETRY_COMPOUND => Solid::Compound(assets.compound(shape.asset())),
        _ => Solid::Sphere { radius: size[0] },
    }
}
