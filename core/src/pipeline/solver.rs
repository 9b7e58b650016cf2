//! The solve (the talk's fourth stage): sweeps over the phases, one barrier after each.
//!
//! ```text
//! step    = first push + warm sweep, then substeps, then the last push of joints that leap and a bounce sweep, if
//!           something leaps or bounces
//! substep = biased sweeps (phase 0 of the first pushes velocities), relax sweeps (phase 0 of the first moves)
//! ```
//! so a step has `(2 x substeps + 1) x phases` barriers with one sweep of each kind. Groups of a tier that has one
//! phase know nothing of each other, and each goes through all sweeps at once: one barrier.

use crate::config::{ContactModel, Settings};
use crate::constraint::contact::{self, Pass, Sweep};
use crate::constraint::joint::{self, BallRow, BlockRow, BoundRow, JointLink, LockRow, NodeRow};
use crate::constraint::row::{Bias, ConeRow, LinkRow, PointRow, ResistRow};
use crate::executor::{Executor, Stage};
use crate::lanes::LANES;
use crate::pipeline::articulations::Patterns;
use crate::pipeline::layout::{Group, Phase, Plan, REFINED, Tier};
use crate::pipeline::mover::MoverRow;
use crate::pipeline::residual::measure;
use crate::pipeline::seat::{OtherSeats, Seat};
use crate::pipeline::tasks::{ALONE_CONTACTS, Crew, Tasks, push};
use crate::report::{Residual, Residuals};

/// Rows and seats of a step, in solver order.
pub(crate) struct Rows<'a> {
    pub plan: &'a Plan,
    pub groups: &'a [Group],
    pub links: &'a mut [LinkRow],
    pub points: &'a mut [PointRow],
    /// One for each row of links, or none.
    pub resists: &'a mut [ResistRow],
    /// The same where each point has a cone of friction.
    pub cones: &'a mut [ConeRow],
    pub joints: JointRows<'a>,
    pub patterns: Patterns<'a>,
    pub seats: &'a mut [Seat],
    pub sources: &'a [u32],
    pub movers: &'a mut [MoverRow],
}

/// Rows of joints.
#[derive(Default)]
pub(crate) struct JointRows<'a> {
    /// Of plain balls.
    pub balls: &'a mut [BallRow],
    /// Of other joints.
    pub links: &'a mut [JointLink],
    pub locks: &'a mut [LockRow],
    pub bounds: &'a mut [BoundRow],
    /// Of articulations.
    pub nodes: &'a mut [NodeRow],
    pub blocks: &'a mut [BlockRow],
}

impl<'a> JointRows<'a> {
    /// The rows from those of the first of some groups on.
    fn from(self, groups: &[Group]) -> Self {
        let Some(first) = groups.iter().find(|group| group.joints > 0) else { return Self::default() };
        Self {
            balls: &mut self.balls[first.first_ball as usize..],
            links: &mut self.links[(first.first_joint - first.first_ball) as usize..],
            locks: &mut self.locks[first.first_lock as usize..],
            bounds: &mut self.bounds[first.first_bound as usize..],
            nodes: &mut self.nodes[first.first_node as usize..],
            blocks: &mut self.blocks[first.first_block as usize..],
        }
    }

    /// The same rows, for a while.
    pub fn reborrow(&mut self) -> JointRows<'_> {
        let Self { balls, links, locks, bounds, nodes, blocks } = self;
        JointRows { balls, links, locks, bounds, nodes, blocks }
    }

    /// Cuts the rows of groups in a row off.
    pub fn take_all(&mut self, groups: &[Group]) -> JointRows<'a> {
        let joints = if self.balls.is_empty() && self.links.is_empty() { &[] } else { groups };
        let sum = |count: fn(&Group) -> u32| joints.iter().map(count).sum::<u32>() as usize;
        JointRows {
            balls: take(&mut self.balls, sum(|group| group.balls)),
            links: take(&mut self.links, sum(|group| group.joints - group.balls)),
            locks: take(&mut self.locks, sum(|group| group.locks)),
            bounds: take(&mut self.bounds, sum(|group| group.bounds)),
            nodes: take(&mut self.nodes, sum(|group| group.nodes)),
            blocks: take(&mut self.blocks, sum(|group| group.blocks)),
        }
    }

    /// Cuts the rows of a group off.
    pub fn take(&mut self, group: &Group) -> JointRows<'a> {
        self.take_all(core::slice::from_ref(group))
    }
}

/// What phase 0 does with its bodies before the rows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Motion {
    /// Nothing.
    None,
    /// Velocities of the first substep.
    PushFirst,
    /// Velocities of a later substep, with warm start.
    PushAgain,
    /// Positions.
    Advance,
    /// The rest of the push of bodies that leap.
    PushLast,
}

/// A group at work.
pub(crate) struct Task<'a> {
    pub seats: &'a mut [Seat],
    pub sources: &'a [u32],
    /// Empty after phase 0.
    movers: &'a mut [MoverRow],
    pub joints: JointRows<'a>,
    patterns: Patterns<'a>,
    pub links: &'a mut [LinkRow],
    pub points: &'a mut [PointRow],
    pub resists: &'a mut [ResistRow],
    pub cones: &'a mut [ConeRow],
}

/// How contacts are biased.
pub(crate) fn bias(settings: &Settings) -> Bias {
    Bias { rate: 1.0 / settings.substep(), push_speed: settings.push_speed }
}

/// What the solve tells.
#[derive(Clone, Copy, Default)]
pub(crate) struct Solved {
    /// What the last substep of each tier left, where that is asked for.
    pub residuals: Option<Residuals>,
    /// Biased sweeps of all tiers.
    pub sweeps: u32,
    /// Substeps that had their most sweeps and were not within the tolerance.
    pub unsettled: u32,
}

impl Solved {
    /// Notes how the biased sweeps of a substep ended; what is left counts where it is asked for.
    fn note(&mut self, sweeps: u32, (left, asks): (Option<Residual>, bool), settings: &Settings) {
        self.sweeps += sweeps;
        let Some(left) = left else { return };
        self.unsettled += u32::from(exceeds(settings, &left));
        if let Some(residuals) = self.residuals.as_mut().filter(|_| asks) {
            residuals.biased = residuals.biased.with(&left);
            if settings.relax_sweeps == 0 {
                residuals.last = residuals.last.with(&left);
            }
        }
    }
}

/// True when a tolerance asks for less than what is left.
fn exceeds(settings: &Settings, left: &Residual) -> bool {
    settings.tolerance > 0.0 && left.greatest() > settings.tolerance
}

/// Solves and integrates the step, tier by tier.
pub(crate) fn solve<E: Executor>(rows: &mut Rows<'_>, settings: &Settings, crew: &mut Crew<'_, E>) -> Solved {
    let plan = rows.plan;
    let mut solved = Solved { residuals: settings.residual.then(Residuals::default), ..Solved::default() };
    for (index, tier) in plan.tiers.iter().enumerate().filter(|(_, tier)| tier.phase_count > 0) {
        let was_alone = crew.is_alone;
        // What is refined are small islands: few of them are not worth a barrier.
        crew.is_alone |= index == REFINED && tier.links < ALONE_CONTACTS as usize;
        solve_tier((rows, &mut solved), (index, tier), &settings.of_tier(index), crew);
        crew.is_alone = was_alone;
    }
    solved
}

/// What is done with the rows of a tier.
#[derive(Clone, Copy)]
enum Act {
    /// Bodies move so first, then all rows are visited.
    Visit(Motion),
    /// What is left is measured.
    Measure,
}

/// The sweeps of a tier.
struct Sweeps<'s> {
    settings: &'s Settings,
    nudges: bool,
    /// Some bodies leap.
    leaps: bool,
    /// A contact may bounce.
    bounces: bool,
}

impl Sweeps<'_> {
    fn of(&self, pass: Pass, visits: u32) -> Sweep {
        let settings = self.settings;
        Sweep {
            pass,
            visits,
            substep: settings.substep(),
            bias: bias(settings),
            nudges: self.nudges,
            splits: settings.contact_model == ContactModel::Split,
            relaxes_again: settings.relax_sweeps > 1 || settings.inner_sweeps > 1,
            ends: false,
            restitution_threshold: settings.restitution_threshold,
        }
    }

    /// Visits of a block in a sweep: the last sweep of a substep is plain.
    fn visits(&self, is_last: bool) -> u32 {
        if is_last { 1 } else { self.settings.inner_sweeps }
    }

    /// True when some sweep is measured.
    fn measures(&self) -> bool {
        self.settings.residual || self.settings.tolerance > 0.0
    }

    /// The sweeps of a step, one after the other. `act` answers what is left where it is asked to measure.
    fn run(&self, solved: &mut Solved, mut act: impl FnMut(&Sweep, Act) -> Residual) {
        let settings = self.settings;
        let relax_sweeps = settings.relax_sweeps;
        act(&self.of(Pass::Warm, 1), Act::Visit(Motion::PushFirst));
        for substep in 0..settings.substeps {
            let first = if substep == 0 { Motion::None } else { Motion::PushAgain };
            let asks = settings.residual && substep + 1 == settings.substeps;
            let (done, left) = self.press((first, asks), &mut act);
            solved.note(done, (left, asks), settings);
            let pass = if relax_sweeps == 0 { Pass::Follow } else { Pass::Relax };
            let sweep = self.of(pass, self.visits(relax_sweeps <= 1));
            let ends = relax_sweeps == 0 && substep + 1 == settings.substeps;
            act(&Sweep { ends, ..sweep }, Act::Visit(Motion::Advance));
            for k in 1..relax_sweeps {
                act(&self.of(Pass::RelaxAgain, self.visits(k + 1 == relax_sweeps)), Act::Visit(Motion::None));
            }
        }
        if self.leaps {
            let pass = if settings.substeps == 1 { Pass::LeapOnce } else { Pass::Leap };
            act(&self.of(pass, 1), Act::Visit(Motion::PushLast));
        }
        if let Some(residuals) = solved.residuals.as_mut().filter(|_| relax_sweeps > 0) {
            let left = act(&self.of(Pass::RelaxAgain, 1), Act::Measure);
            residuals.last = residuals.last.with(&left);
        }
        if self.bounces {
            act(&self.of(Pass::Bounce, 1), Act::Visit(Motion::None));
        }
    }

    /// The biased sweeps of a substep: as many as the settings say, then more until what is left is within the
    /// tolerance. Returns how many there were, and what is left where that is measured.
    fn press(
        &self,
        (first, asks): (Motion, bool),
        act: &mut impl FnMut(&Sweep, Act) -> Residual,
    ) -> (u32, Option<Residual>) {
        let Settings { sweeps, sweeps_max, relax_sweeps, tolerance, .. } = *self.settings;
        let mut done = 0;
        loop {
            let biased = self.of(Pass::Biased, self.visits(relax_sweeps == 0 && done + 1 >= sweeps));
            act(&biased, Act::Visit(if done == 0 { first } else { Motion::None }));
            done += 1;
            if done < sweeps {
                continue;
            }
            let left = (asks || tolerance > 0.0).then(|| act(&biased, Act::Measure));
            if done >= sweeps_max || !left.is_some_and(|left| exceeds(self.settings, &left)) {
                return (done, left);
            }
        }
    }
}

fn solve_tier<E: Executor>(
    (rows, solved): (&mut Rows<'_>, &mut Solved),
    (index, tier): (usize, &Tier),
    settings: &Settings,
    crew: &mut Crew<'_, E>,
) {
    let splits = settings.contact_model == ContactModel::Split;
    let some =
        |is: fn(&Group) -> bool| rows.groups.iter().any(|group| is(group) && group.tier as usize == index);
    let (leaps, bounces) = (some(|group| group.leaps != 0), some(|group| group.bounces != 0));
    let sweeps = Sweeps { settings, nudges: rows.plan.joints > 0 || splits, leaps, bounces };
    match tier.phases() {
        // No group knows another: each goes through all sweeps by itself.
        [phase] if !sweeps.measures() => {
            let mut tasks = Tasks::new();
            let others = cut_phase(rows, phase, &mut tasks);
            crew.run(Stage::Solve, &mut tasks, |task| {
                sweeps.run(&mut Solved::default(), |sweep, act| {
                    if let Act::Visit(motion) = act {
                        visit(task, sweep, motion, &others);
                    }
                    Residual::default()
                });
            });
            // What they did is counted once.
            sweeps.run(solved, |_, _| Residual::default());
        }
        _ => sweeps.run(solved, |sweep, act| match act {
            Act::Visit(motion) => {
                run_sweep((rows, tier), sweep, motion, crew);
                Residual::default()
            }
            Act::Measure => measure((rows, tier), sweep, crew),
        }),
    }
}

fn run_sweep<E: Executor>(
    (rows, tier): (&mut Rows<'_>, &Tier),
    sweep: &Sweep,
    motion: Motion,
    crew: &mut Crew<'_, E>,
) {
    for (index, phase) in tier.phases().iter().enumerate() {
        run_phase((rows, phase), sweep, if index == 0 { motion } else { Motion::None }, crew);
    }
}

fn run_phase<E: Executor>(
    (rows, phase): (&mut Rows<'_>, &Phase),
    sweep: &Sweep,
    motion: Motion,
    crew: &mut Crew<'_, E>,
) {
    let mut tasks = Tasks::new();
    let others = cut_phase(rows, phase, &mut tasks);
    crew.run(Stage::Solve, &mut tasks, |task| visit(task, sweep, motion, &others));
}

/// Writes the tasks of a phase; returns the seats of the others.
#[inline(always)]
pub(crate) fn cut_phase<'r>(
    rows: &'r mut Rows<'_>,
    phase: &Phase,
    tasks: &mut Tasks<Task<'r>>,
) -> OtherSeats<'r> {
    let (first, end) = (phase.first_seat as usize, (phase.first_seat + phase.seats) as usize);
    let (before, rest) = rows.seats[..rows.plan.seats].split_at_mut(first);
    let (own, after) = rest.split_at_mut(end - first);
    let others = OtherSeats { before, after, end };
    let groups = &rows.groups[phase.first_group as usize..(phase.first_group + phase.groups) as usize];
    let moves = first < rows.plan.moving;
    let movers = if moves { &mut rows.movers[first / LANES..end / LANES] } else { &mut [] };
    let links = (&mut *rows.links, &mut *rows.resists, &mut *rows.cones);
    let parts =
        ((own, &rows.sources[first..end], movers), (links, &mut *rows.points, rows.joints.reborrow()));
    cut((groups, rows.patterns), parts, tasks);
    others
}

/// Rows of links, of their resistances and of their cones.
type ContactRows<'a> = (&'a mut [LinkRow], &'a mut [ResistRow], &'a mut [ConeRow]);

/// What the groups of a phase share: seats, their sources and movers; rows of contacts, points, rows of joints.
type Parts<'a> =
    ((&'a mut [Seat], &'a [u32], &'a mut [MoverRow]), (ContactRows<'a>, &'a mut [PointRow], JointRows<'a>));

/// Writes a task for each group of a phase, from the phase's slices. The list is written where it is used: it is
/// of 18 KB, and a copy of it in each phase of each sweep was 4 % of a step of 500 balls.
fn cut<'a>(
    (groups, patterns): (&[Group], Patterns<'a>),
    ((mut seats, mut sources, mut movers), ((links, resists, cones), points, joints)): Parts<'a>,
    tasks: &mut Tasks<Task<'a>>,
) {
    let Some(front) = groups.first() else { return };
    let mut links = &mut links[front.first_row as usize..];
    let mut resists = resists.get_mut(front.first_row as usize..).unwrap_or_default();
    let mut cones = cones.get_mut(front.first_row as usize..).unwrap_or_default();
    let mut points = &mut points[front.first_point as usize..];
    let mut joints = joints.from(groups);
    for group in groups {
        let count = group.seats as usize;
        let task = Task {
            seats: take(&mut seats, count),
            sources: {
                let (own, rest) = sources.split_at(count);
                sources = rest;
                own
            },
            movers: {
                let count = if movers.is_empty() { 0 } else { count / LANES };
                take(&mut movers, count)
            },
            joints: joints.take(group),
            patterns: patterns.of(group),
            links: take(&mut links, group.rows as usize),
            points: take(&mut points, group.points as usize),
            resists: take_some(&mut resists, group.rows),
            cones: take_some(&mut cones, group.rows),
        };
        push(tasks, task);
    }
}

/// Cuts the first `count` elements off a slice.
pub(crate) fn take<'a, T>(rest: &mut &'a mut [T], count: usize) -> &'a mut [T] {
    let (own, after) = core::mem::take(rest).split_at_mut(count);
    *rest = after;
    own
}

/// The same for rows of which there may be none.
pub(crate) fn take_some<'a, T>(rest: &mut &'a mut [T], rows: u32) -> &'a mut [T] {
    let count = rest.len().min(rows as usize);
    take(rest, count)
}

/// A group's visit: pull, move, sweep.
fn visit(task: &mut Task<'_>, sweep: &Sweep, motion: Motion, others: &OtherSeats<'_>) {
    // Before the first push the other phases' seats hold nothing yet.
    if motion != Motion::PushFirst {
        others.pull(task.seats, task.sources);
    }
    if motion != Motion::None {
        let (seats, _) = task.seats.as_chunks_mut::<LANES>();
        for (mover, seats) in task.movers.iter_mut().zip(seats) {
            match motion {
                Motion::PushFirst => mover.push_first(seats),
                Motion::PushAgain => mover.push_again(seats, sweep.nudges),
                Motion::PushLast => mover.push_last(seats, sweep.substep),
                Motion::Advance => mover.advance(seats, sweep.substep, sweep.nudges),
                Motion::None => {}
            }
        }
    }
    sweep_rows(task, sweep);
    // The chains of a group share no body: visiting the group again is visiting each of its blocks again.
    let again =
        Sweep { pass: if sweep.pass == Pass::Relax { Pass::RelaxAgain } else { sweep.pass }, ..*sweep };
    for _ in 1..sweep.visits {
        sweep_rows(task, &again);
    }
}

/// Joints first: the errors of contacts are the visible ones.
fn sweep_rows(task: &mut Task<'_>, sweep: &Sweep) {
    let seats = &mut *task.seats;
    if task.patterns.rows.is_empty() {
        let JointRows { balls, links, locks, bounds, .. } = &mut task.joints;
        BallRow::visit_all(balls, sweep, seats);
        joint::visit(sweep, links, (locks, bounds), seats);
    } else {
        task.patterns.each(task.joints.reborrow(), |articulation| articulation.visit(sweep, seats));
    }
    if !matches!(sweep.pass, Pass::Leap | Pass::LeapOnce) {
        contact::visit(sweep, (task.links, task.resists, task.cones), task.points, task.seats);
    }
}
