//! Visits of articulations: the bounds of all their joints one by one, then all locks at once.

use super::super::contact::{Pass, Sweep};
use super::super::velocities::{Velocities, root_times};
use super::elimination::{JOINTS_MAX, NONE, NodeSpec};
use super::factor::Matrix;
use super::solve::{NUDGE_MAX, Push, curvature, take_along, warm};
use super::{BoundRow, JointLink, LockRow, follow};
use crate::lanes::{Lane, LaneVec};
use crate::pipeline::leapfrog::lanes_of;
use crate::pipeline::seat::Seat;

/// Fastest turn by a nudge, rad/s.
const NUDGE_SPIN_MAX: f32 = 50.0;

/// Eight alike articulations: a link for each joint, in the order of the joints' numbers.
pub(crate) struct Articulation<'a> {
    pub links: &'a mut [JointLink],
    pub locks: &'a mut [LockRow],
    pub bounds: &'a mut [BoundRow],
    pub matrix: Matrix<'a>,
}

/// What the locks are asked for.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Ask {
    /// The velocities of a biased sweep.
    Biased,
    /// Those of a relax sweep.
    Relaxed,
    /// Nudges.
    Nudge,
    /// The velocities after the rest of a push, by impulses that count or do not.
    Leap { counts: bool },
}

impl Articulation<'_> {
    /// Factors the matrix of placed joints.
    pub fn factor(&mut self) {
        self.matrix.factor(self.links, self.locks);
    }

    /// One pass over all joints.
    pub fn visit(&mut self, sweep: &Sweep, seats: &mut [Seat]) {
        match sweep.pass {
            Pass::Warm => self.each(seats, |_, (locks, bounds), u| warm(u, locks, bounds)),
            Pass::Biased => {
                self.each(seats, |link, (_, bounds), u| {
                    link.take_turns(u);
                    BoundRow::visit(bounds, u, true);
                });
                self.hold(sweep, seats, Ask::Biased);
                self.hold(sweep, seats, Ask::Nudge);
            }
            Pass::Follow => self.follow(sweep, seats),
            Pass::Relax => {
                self.follow(sweep, seats);
                self.relax(sweep, seats);
            }
            Pass::RelaxAgain => self.relax(sweep, seats),
            Pass::Leap | Pass::LeapOnce => {
                if self.links.iter().any(|link| link.leaps != 0) {
                    self.hold(sweep, seats, Ask::Leap { counts: sweep.pass == Pass::LeapOnce });
                }
            }
            Pass::Bounce => {}
        }
    }

    fn relax(&mut self, sweep: &Sweep, seats: &mut [Seat]) {
        self.each(seats, |_, (_, bounds), u| BoundRow::visit(bounds, u, false));
        self.hold(sweep, seats, Ask::Relaxed);
    }

    /// Visits the joints one by one.
    fn each(
        &mut self,
        seats: &mut [Seat],
        mut visit: impl FnMut(&mut JointLink, (&mut [LockRow], &mut [BoundRow]), &mut Velocities),
    ) {
        let (mut locks, mut bounds) = (&mut *self.locks, &mut *self.bounds);
        for link in &mut *self.links {
            let (own_locks, own_bounds) = cut(link, (&mut locks, &mut bounds));
            let ends = (&link.seats_a, &link.seats_b);
            let mut u = Velocities::gather(ends, seats, link.locked != 0);
            visit(link, (own_locks, own_bounds), &mut u);
            u.scatter((&link.seats_a, &link.seats_b), seats);
        }
    }

    /// Brings all rows to the end of the substep, and the matrix.
    fn follow(&mut self, sweep: &Sweep, seats: &mut [Seat]) {
        let substep = sweep.substep;
        let (mut locks, mut bounds) = (&mut *self.locks, &mut *self.bounds);
        for link in &mut *self.links {
            let (locks, bounds) = cut(link, (&mut locks, &mut bounds));
            if sweep.ends {
                if link.signature().counts_on() {
                    follow::follow(link, (locks, bounds), seats, (substep, link.masses()));
                }
                continue;
            }
            let mut before = [Push::NONE; 6];
            before.iter_mut().zip(&*locks).for_each(|(push, row)| *push = Push::of(&row.ways));
            let axes = (link.far_a, link.far_b);
            let masses = link.masses();
            follow::follow(link, (locks, bounds), seats, (substep, masses));
            if link.tops != 0 {
                take_along(&mut before, link, axes);
            }
            for (row, before) in locks.iter_mut().zip(&before) {
                row.mean = before.mean(&row.ways);
            }
        }
        if !sweep.ends {
            self.factor();
        }
    }

    /// Solves all locks for what is asked of them, and applies it.
    fn hold(&mut self, sweep: &Sweep, seats: &mut [Seat], ask: Ask) {
        self.ask(sweep, seats, ask);
        self.matrix.solve();
        self.answer(seats, ask);
    }

    /// Writes what each lock lacks to the right side.
    fn ask(&mut self, sweep: &Sweep, seats: &[Seat], ask: Ask) {
        let mut locks = &mut *self.locks;
        let (specs, nodes) = (self.matrix.pattern.nodes, &mut *self.matrix.nodes);
        nodes.iter_mut().for_each(|node| node.side = [Lane::ZERO; 6]);
        for (link, place) in self.links.iter().zip(joint_places(specs)) {
            let own = cut_locks(link, &mut locks);
            let ends = (&link.seats_a, &link.seats_b);
            let u = Velocities::gather(ends, seats, link.locked != 0);
            let side = nodes[place as usize].side.iter_mut();
            if ask == Ask::Nudge {
                let nudges = u.gather_nudges(ends, seats);
                let way = curvature(&u, link, sweep.substep);
                for (row, side) in own.iter().zip(side) {
                    *side = -(row.ways.rate(&nudges) + row.wanted_nudge(way));
                }
            } else {
                for (row, side) in own.iter_mut().zip(side) {
                    let wanted = row.wanted(ask == Ask::Biased);
                    *side = -(row.ways.rate(&u) + wanted);
                }
            }
        }
    }

    /// The share of the nudges that is given, so that no body is moved faster than they may: joints that nearly
    /// contradict each other ask for more than they could ever get.
    fn share(&self) -> Lane {
        let one = Lane::splat(1.0);
        let mut most = one;
        let bodies = self.matrix.pattern.nodes.iter().zip(&*self.matrix.nodes);
        for (spec, node) in bodies.filter(|(spec, _)| spec.joint == NONE) {
            let link = &self.links[spec.end as usize / 2];
            let (scale, root, now, top) = if spec.end % 2 == 0 {
                (link.scale_a, &link.root_a, &link.now_a, link.top_a)
            } else {
                (link.scale_b, &link.root_b, &link.now_b, link.top_b)
            };
            let [x, y, z, rest @ ..] = node.side;
            let speed = LaneVec::new(x, y, z).each_times(scale).times(Lane::splat(1.0 / NUDGE_MAX));
            let whitened = LaneVec::new(rest[0], rest[1], rest[2]);
            let mut spin = root_times(root, whitened);
            if link.tops != 0 {
                spin = top.greater(Lane::ZERO).select_vec(root_times(now, whitened), spin);
            }
            let spin = spin.times(Lane::splat(1.0 / NUDGE_SPIN_MAX));
            most = most.greatest(speed.dot(speed)).greatest(spin.dot(spin));
        }
        one / most.sqrt()
    }

    /// Applies the impulses that the solution says.
    fn answer(&mut self, seats: &mut [Seat], ask: Ask) {
        let share = if ask == Ask::Nudge { self.share() } else { Lane::ZERO };
        let mut locks = &mut *self.locks;
        let (specs, nodes) = (self.matrix.pattern.nodes, &*self.matrix.nodes);
        for (link, place) in self.links.iter_mut().zip(joint_places(specs)) {
            let own = cut_locks(link, &mut locks);
            let ends = (&link.seats_a, &link.seats_b);
            // The unknowns of joints are the impulses' opposites.
            let answers = nodes[place as usize].side.iter().map(|&side| -side);
            let mut u = Velocities::gather(ends, seats, link.locked != 0);
            if ask == Ask::Nudge {
                let mut nudges = u.gather_nudges(ends, seats);
                for (row, x) in own.iter().zip(answers) {
                    row.apply_nudge(&mut nudges, x * share);
                }
                nudges.scatter_nudges(ends, seats);
                continue;
            }
            if let Ask::Leap { counts } = ask {
                let (leaps, before) = (lanes_of(link.leaps), u.all());
                for (row, x) in own.iter_mut().zip(answers) {
                    row.leap(&mut u, leaps.keep(x), counts);
                }
                u.keep(leaps, before);
                u.scatter((&link.seats_a, &link.seats_b), seats);
                continue;
            }
            for (row, x) in own.iter_mut().zip(answers) {
                let x = row.add(x);
                if ask == Ask::Biased {
                    row.ways.apply(&mut u, x);
                } else {
                    let mean = row.mean;
                    mean.apply(&mut u, x);
                    link.note_turn(row, &mean, x);
                }
            }
            u.scatter((&link.seats_a, &link.seats_b), seats);
        }
    }
}

/// Place of each joint among the nodes.
fn joint_places(nodes: &[NodeSpec]) -> [u8; JOINTS_MAX] {
    let mut places = [0; JOINTS_MAX];
    for (place, spec) in nodes.iter().enumerate().filter(|(_, spec)| spec.joint != NONE) {
        places[spec.joint as usize] = place as u8;
    }
    places
}

/// Cuts the rows of a link off.
fn cut<'a>(
    link: &JointLink,
    (locks, bounds): (&mut &'a mut [LockRow], &mut &'a mut [BoundRow]),
) -> (&'a mut [LockRow], &'a mut [BoundRow]) {
    let (own, rest) = core::mem::take(bounds).split_at_mut(link.signature().bound_rows());
    *bounds = rest;
    (cut_locks(link, locks), own)
}

fn cut_locks<'a>(link: &JointLink, locks: &mut &'a mut [LockRow]) -> &'a mut [LockRow] {
    let (own, rest) = core::mem::take(locks).split_at_mut(link.signature().lock_rows());
    *locks = rest;
    own
}
