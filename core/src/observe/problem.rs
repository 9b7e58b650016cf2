//! The rows of the solver as the talk writes them (SEED S5 to S8), for checking answers by other methods.
//!
//! ```text
//! w = J u + bias + soft lambda = A lambda + b      A = J M^-1 Jt + soft      b = J u0 + bias
//! ```
//! Angular velocity is whitened: `w = W w~` with `W W` = inverse inertia, so `M^-1` is the inverse mass three times
//! and then 1 three times.

use super::{Rows, StageView};
use crate::cells::IMMOVABLE;
use crate::constraint::joint::{BallRow, BoundRow, JointLink, LockRow, Ways};
use crate::constraint::row::{ConeRow, LinkRow, PointRow};
use crate::joint::JointRow;
use crate::lanes::{LANES, LaneVec};
use crate::math::Vec3;
use crate::pipeline::layout::{EMPTY, Group};

/// A body of the problem, after [`Stage::Assembly`](crate::Stage::Assembly).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProblemBody {
    /// Slot of the body: the index of its handle.
    pub slot: u32,
    /// 1/kg, whatever axes are locked.
    pub inverse_mass: f32,
    /// Velocity with which the first substep is solved, m/s, before damping; then whitened angular velocity before
    /// torques.
    pub velocity: [f32; 6],
}

/// One row. Its rate is from body A to body B: `J u = jacobian[1] . u_b + jacobian[0] . u_a`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProblemRow {
    /// Index of the contact or joint, alike for all of its rows; those of a contact or joint follow one another.
    pub link: u32,
    /// Indices of the bodies A and B among [`StageView::bodies`]; `None` for one that is immovable.
    pub bodies: [Option<u32>; 2],
    /// Jacobians of A and B: linear parts, then those of the whitened angular velocities.
    pub jacobian: [[f32; 6]; 2],
    /// What is added to the rate, m/s or rad/s. Of joints without what bounds want; errors of position are no part
    /// of the velocities' problem.
    pub bias: f32,
    /// Rate that the row allows for each unit of impulse.
    pub soft: f32,
    /// Impulse of the substep on B along the row, N s or N m s.
    pub impulse: f32,
    /// What the impulse may be.
    pub kind: ProblemKind,
}

/// The bounds of a row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ProblemKind {
    /// A point of a contact: `0 <= lambda`.
    Normal,
    /// The first of two tangents, which follow one another: both impulses lie within a disc of `friction` times the
    /// sum of the contact's normal impulses.
    Tangent {
        /// Coefficient of friction.
        friction: f32,
    },
    /// The first of two tangents of a point, which follow one another: both impulses lie within a disc of
    /// `friction` times the normal impulse of point `point` of the contact, whose [`ProblemKind::Normal`] comes
    /// after all of these. The two models of [`FrictionModel`](crate::FrictionModel) do not mix: a contact has a
    /// `Tangent` or these.
    PointTangent {
        /// Coefficient of friction.
        friction: f32,
        /// The point, from 0.
        point: u32,
    },
    /// Turning about the normal, bounded by `friction` times `radius` times the sum of the normal impulses.
    Twist {
        /// Coefficient of friction.
        friction: f32,
        /// Mean distance of the points from their middle, metres.
        radius: f32,
    },
    /// A row of a joint that holds, whatever its impulse.
    Hold,
    /// A limit, drive or friction of a joint: an impulse of at most `most` that keeps the rate in a range. After
    /// [`Stage::Solve`](crate::Stage::Solve) the range is that of the last sweep.
    Bound {
        /// Least rate; a lesser one gets a positive impulse.
        least: f32,
        /// Greatest rate; a greater one gets a negative impulse.
        greatest: f32,
        /// Greatest size of the impulse.
        most: f32,
    },
}

impl StageView<'_, '_> {
    /// The bodies that are solved, after [`Stage::Assembly`](crate::Stage::Assembly); none after others.
    pub fn bodies(&self) -> impl Iterator<Item = ProblemBody> + '_ {
        let bodies = self.rows.map_or(&[][..], |rows| &rows.scratch.active[..rows.bodies]);
        bodies.iter().map(|body| {
            let (v, w) = (body.linear + body.push, body.whitened);
            let velocity = [v.x, v.y, v.z, w.x, w.y, w.z];
            ProblemBody { slot: body.body, inverse_mass: body.inverse_mass, velocity }
        })
    }

    /// Calls `tell` for each row of the solver, group by group in their order, after
    /// [`Stage::Assembly`](crate::Stage::Assembly) and [`Stage::Solve`](crate::Stage::Solve). After the solve the
    /// impulses are those of the last substep, while the jacobians are already at its end; those of the first
    /// substep are there after assembly. Resistance to rolling is left out.
    pub fn each_row(&self, mut tell: impl FnMut(ProblemRow)) {
        let Some(rows) = self.rows else { return };
        let has_cones = self.state.header[0].settings.has_cones();
        let cones = if has_cones { &*rows.scratch.cone_rows } else { &[] };
        for group in &rows.cache.groups[..rows.plan.groups] {
            rows.joints((group, self.state.joints), &mut tell);
            rows.contacts((group, cones), &mut tell);
        }
    }
}

impl Rows<'_, '_> {
    fn joints(&self, (group, state): (&Group, &[JointRow]), tell: &mut impl FnMut(ProblemRow)) {
        let first = group.first_joint as usize;
        let (balls, joints) = (group.balls as usize, group.joints as usize);
        for i in 0..balls {
            let ball = &self.scratch.ball_rows[group.first_ball as usize + i];
            self.each_joint((first + i, state), |lane, link, bodies| {
                write_ball(ball, (lane, link, bodies), tell)
            });
        }
        let (mut lock, mut bound) = (group.first_lock as usize, group.first_bound as usize);
        for i in balls..joints {
            let link = &self.scratch.joint_links[first - group.first_ball as usize + i - balls];
            let signature = link.signature();
            let locks = &self.scratch.lock_rows[lock..lock + signature.lock_rows()];
            let bounds = &self.scratch.bound_rows[bound..bound + signature.bound_rows()];
            (lock, bound) = (lock + locks.len(), bound + bounds.len());
            self.each_joint((first + i, state), |lane, index, bodies| {
                write_joint(link, (locks, bounds), (lane, index, bodies), tell);
            });
        }
    }

    /// Calls `of` for each joint of a row: its lane, its index and its bodies.
    fn each_joint(
        &self,
        (row, joints): (usize, &[JointRow]),
        mut of: impl FnMut(usize, u32, [Option<u32>; 2]),
    ) {
        for (lane, &joint) in self.cache.lane_joints[row].iter().enumerate() {
            if joint != EMPTY {
                let slot = self.scratch.joint_slots[joint as usize] as usize;
                of(lane, joint, joints[slot].bodies.map(|body| self.active(body)));
            }
        }
    }

    fn active(&self, slot: u32) -> Option<u32> {
        Some(self.scratch.active_of[slot as usize]).filter(|&index| index != IMMOVABLE)
    }

    fn contacts(&self, (group, cones): (&Group, &[ConeRow]), tell: &mut impl FnMut(ProblemRow)) {
        let mut point = group.first_point as usize;
        for row in group.first_row as usize..(group.first_row + group.rows) as usize {
            let link = &self.scratch.link_rows[row];
            let points = &self.scratch.point_rows[point..point + link.points as usize];
            point += points.len();
            for (lane, &contact) in self.cache.lane_contacts[row].iter().enumerate() {
                if contact != EMPTY {
                    let ends = &self.scratch.links[contact as usize];
                    let bodies = [ends.a, ends.b].map(|body| Some(body).filter(|&body| body != IMMOVABLE));
                    write_contact((link, points, cones.get(row)), (lane, contact, bodies), tell);
                }
            }
        }
    }
}

/// Lane, index of the link, and bodies.
type Place = (usize, u32, [Option<u32>; 2]);

/// The jacobians of a row that acts on B along `d`.
fn jacobian(d: Vec3, (a, b): (Vec3, Vec3)) -> [[f32; 6]; 2] {
    [[-d.x, -d.y, -d.z, -a.x, -a.y, -a.z], [d.x, d.y, d.z, b.x, b.y, b.z]]
}

fn write_contact(
    (row, points, cones): (&LinkRow, &[PointRow], Option<&ConeRow>),
    (lane, link, bodies): Place,
    tell: &mut impl FnMut(ProblemRow),
) {
    let count = row.count.get(lane) as usize;
    match cones.filter(|_| count > 1) {
        None => write_patch(row, (lane, link, bodies), tell),
        Some(cones) => (0..count).for_each(|i| write_cone((row, cones, i), (lane, link, bodies), tell)),
    }
    let n = row.normal.get(lane);
    for point in &points[..count] {
        let surface = if row.surfaces != 0 { point.surface.get(lane) } else { 0.0 };
        tell(ProblemRow {
            link,
            bodies,
            jacobian: jacobian(n, (point.normal_a.get(lane), point.normal_b.get(lane))),
            bias: point.bias.get(lane) + surface,
            soft: point.soft.get(lane),
            impulse: point.impulse.get(lane),
            kind: ProblemKind::Normal,
        });
    }
}

/// The tangents of a point: those of the patch, carried to its place in the plane.
fn write_cone(
    (row, cones, i): (&LinkRow, &ConeRow, usize),
    (lane, link, bodies): Place,
    tell: &mut impl FnMut(ProblemRow),
) {
    let (n, t) = (row.normal.get(lane), row.tangent.get(lane));
    let surface = if row.surfaces != 0 { row.surface.get(lane) } else { Vec3::ZERO };
    let ([p, q], impulses) = (cones.places[i].map(|x| x.get(lane)), cones.impulses[i].map(|x| x.get(lane)));
    let twist = [row.twist_a.get(lane), row.twist_b.get(lane)];
    let ways = [
        (t, [&row.first_a, &row.first_b], -q, surface.x),
        (n.cross(t), [&row.second_a, &row.second_b], p, surface.y),
    ];
    for ((d, [a, b], lever, speed), impulse) in ways.into_iter().zip(impulses) {
        let turns = (a.get(lane) + twist[0] * lever, b.get(lane) + twist[1] * lever);
        let (jacobian, bias) = (jacobian(d, turns), speed + surface.z * lever);
        let kind = ProblemKind::PointTangent { friction: row.friction.get(lane), point: i as u32 };
        tell(ProblemRow { link, bodies, jacobian, bias, soft: 0.0, impulse, kind });
    }
}

fn write_patch(row: &LinkRow, (lane, link, bodies): Place, tell: &mut impl FnMut(ProblemRow)) {
    let n = row.normal.get(lane);
    let t = row.tangent.get(lane);
    let surface = if row.surfaces != 0 { row.surface.get(lane) } else { Vec3::ZERO };
    let friction = row.friction.get(lane);
    let mut add = |d: Vec3, (a, b): (&LaneVec, &LaneVec), bias: f32, impulse: f32, kind: ProblemKind| {
        let jacobian = jacobian(d, (a.get(lane), b.get(lane)));
        tell(ProblemRow { link, bodies, jacobian, bias, soft: 0.0, impulse, kind });
    };
    let (first, second) = ((&row.first_a, &row.first_b), (&row.second_a, &row.second_b));
    add(t, first, surface.x, row.first_impulse.get(lane), ProblemKind::Tangent { friction });
    add(n.cross(t), second, surface.y, row.second_impulse.get(lane), ProblemKind::Tangent { friction });
    if row.count.get(lane) > 1.0 {
        let kind = ProblemKind::Twist { friction, radius: row.radius.get(lane) };
        add(Vec3::ZERO, (&row.twist_a, &row.twist_b), surface.z, row.twist_impulse.get(lane), kind);
    }
}

fn write_ball(row: &BallRow, (lane, link, bodies): Place, tell: &mut impl FnMut(ProblemRow)) {
    let impulse = row.impulse.get(lane).to_array();
    for (d, impulse) in [Vec3::X, Vec3::Y, Vec3::Z].into_iter().zip(impulse) {
        let jacobian = jacobian(d, row.jacobians(lane, d));
        tell(ProblemRow { link, bodies, jacobian, bias: 0.0, soft: 0.0, impulse, kind: ProblemKind::Hold });
    }
}

fn write_joint(
    joint: &JointLink,
    (locks, bounds): (&[LockRow], &[BoundRow]),
    (lane, link, bodies): Place,
    tell: &mut impl FnMut(ProblemRow),
) {
    debug_assert!(lane < LANES && joint.signature().lock_rows() == locks.len());
    let of = |ways: &Ways| jacobian(ways.direction.get(lane), (ways.a.get(lane), ways.b.get(lane)));
    for row in locks {
        let (soft, impulse) = (row.give.get(lane), row.impulse.get(lane));
        let aim = if soft > 0.0 { row.aim.get(lane) } else { 0.0 };
        let bias = row.ways.drift.get(lane) + aim;
        let jacobian = of(&row.ways);
        tell(ProblemRow { link, bodies, jacobian, bias, soft, impulse, kind: ProblemKind::Hold });
    }
    for row in bounds {
        let (least, greatest) = (row.least.get(lane), row.greatest.get(lane));
        tell(ProblemRow {
            link,
            bodies,
            jacobian: of(&row.ways),
            bias: row.ways.drift.get(lane),
            soft: row.give.get(lane),
            impulse: row.impulse.get(lane),
            kind: ProblemKind::Bound { least, greatest, most: row.most.get(lane) },
        });
    }
}
