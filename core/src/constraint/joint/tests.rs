//! The matrix of an articulation against dense elimination in double precision.

extern crate std;
use super::elimination::{Elimination, JOINTS_MAX, Member, NONE, NodeSpec, Pattern};
use super::factor::{BlockRow, Matrix, NodeRow};
use super::{BlockSpec, JointLink, LockRow};
use crate::lanes::{LANES, LaneVec};
use crate::math::Vec3;
use bytemuck::Zeroable;
use std::vec;
use std::vec::Vec;

/// Signatures of a ball, a hinge and a fixed joint: axes that are held.
const KINDS: [u32; 3] = [0b00_0111, 0b11_0111, 0b11_1111];

/// Solves of what the solve before left.
const SOLVES: usize = 5;

/// Numbers that look random: xorshift.
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0
    }

    /// From -1 to 1.
    fn signed(&mut self) -> f32 {
        (self.next() >> 40) as f32 / (1_u64 << 23) as f32 - 1.0
    }

    fn vector(&mut self) -> Vec3 {
        Vec3::new(self.signed(), self.signed(), self.signed())
    }

    fn below(&mut self, end: u64) -> u64 {
        (self.next() >> 33) % end
    }
}

fn member(random: &mut Random, a: u32, b: u32) -> Member {
    Member { signature: KINDS[random.below(3) as usize], bodies: [a, b] }
}

/// A tree of so many joints, some bodies hung on the world, then some joints more between any two bodies.
fn members(random: &mut Random, joints: u32, more: u32) -> Vec<Member> {
    let mut members = vec![member(random, NONE, 0)];
    for body in 1..joints {
        let other = random.below(u64::from(body)) as u32;
        let ends = if random.below(2) == 0 { [other, body] } else { [body, other] };
        members.push(member(random, ends[0], ends[1]));
    }
    for _ in 0..more {
        let a = random.below(u64::from(joints)) as u32;
        let b = (a + 1 + random.below(u64::from(joints) - 1) as u32) % joints;
        members.push(member(random, a, b));
    }
    members
}

/// Links and locks of these joints, of bodies whose inverse masses go over three orders of magnitude.
fn rows(random: &mut Random, members: &[Member]) -> (Vec<JointLink>, Vec<LockRow>) {
    let scale = |body: u32| if body == NONE { 0.0 } else { [1.0, 0.03, 0.3][body as usize % 3] };
    let (mut links, mut locks) = (Vec::new(), Vec::new());
    for member in members {
        let mut link = JointLink::zeroed();
        link.signature = member.signature;
        let [a, b] = member.bodies.map(scale);
        let mut own = vec![LockRow::zeroed(); link.signature().lock_rows()];
        for lane in 0..LANES {
            link.scale_a.set(lane, Vec3::splat(a));
            link.scale_b.set(lane, Vec3::splat(b));
            // Moments of a ball of 0.8 m.
            let (arms, roots) = ([random.vector(), random.vector()], [2.0 * a, 2.0 * b]);
            for (row, axis) in own.iter_mut().zip((0..6).filter(|axis| member.signature >> axis & 1 != 0)) {
                let unit = [Vec3::X, Vec3::Y, Vec3::Z][axis % 3];
                let turns = if axis < 3 { arms.map(|arm| arm.cross(unit)) } else { [unit; 2] };
                row.ways.direction.set(lane, if axis < 3 { unit } else { Vec3::ZERO });
                row.ways.a.set(lane, turns[0] * roots[0]);
                row.ways.b.set(lane, turns[1] * roots[1]);
                row.give.set(lane, if lane == 3 { 0.5 } else { 0.0 });
            }
        }
        links.push(link);
        locks.extend(own);
    }
    (links, locks)
}

fn pattern(members: &[Member]) -> (Vec<NodeSpec>, Vec<BlockSpec>) {
    let elimination = Elimination::of(members).expect("little is filled");
    let (nodes, blocks) = elimination.size();
    let (mut nodes, mut blocks) = (vec![NodeSpec::zeroed(); nodes], vec![BlockSpec::zeroed(); blocks]);
    elimination.write(members, &mut nodes, &mut blocks);
    (nodes, blocks)
}

/// The rows of J of one lane, by body.
fn jacobian(members: &[Member], links: &[JointLink], locks: &[LockRow], lane: usize) -> Vec<Vec<f64>> {
    let bodies = members.iter().flat_map(|m| m.bodies).filter(|&b| b != NONE).max().unwrap_or(0) + 1;
    let (mut rows, mut locks) = (Vec::new(), locks.iter());
    for (member, link) in members.iter().zip(links) {
        for lock in locks.by_ref().take(link.signature().lock_rows()) {
            let mut row = vec![0.0; 6 * bodies as usize];
            for (end, &body) in member.bodies.iter().enumerate().filter(|(_, body)| **body != NONE) {
                let (scale, turn, sign) = if end == 0 {
                    (link.scale_a, lock.ways.a, -1.0)
                } else {
                    (link.scale_b, lock.ways.b, 1.0)
                };
                let push = lock.ways.direction.get(lane) * scale.get(lane);
                let turn = turn.get(lane);
                for (i, x) in [push.x, push.y, push.z, turn.x, turn.y, turn.z].into_iter().enumerate() {
                    row[6 * body as usize + i] += sign * f64::from(x);
                }
            }
            rows.push(row);
        }
    }
    rows
}

/// What is left of `y` by `J v + give x`, with `v = Jt x`.
fn left_of(jacobian: &[Vec<f64>], give: f64, (x, y): (&[f64], &[f64])) -> Vec<f64> {
    let mut v = vec![0.0; jacobian[0].len()];
    for (row, x) in jacobian.iter().zip(x) {
        v.iter_mut().zip(row).for_each(|(v, j)| *v += j * x);
    }
    let rate = |row: &[f64]| row.iter().zip(&v).map(|(j, v)| j * v).sum::<f64>();
    jacobian.iter().zip(x.iter().zip(y)).map(|(row, (x, y))| y - rate(row) - give * x).collect()
}

/// Solves some articulation for random sides, and then for what is left, as the sweeps of a step do; returns the
/// greatest share that is left in the end.
fn solve(random: &mut Random, members: &[Member]) -> f64 {
    let (links, locks) = rows(random, members);
    let (specs, block_specs) = pattern(members);
    let mut nodes = vec![NodeRow::zeroed(); specs.len()];
    let mut blocks = vec![BlockRow::zeroed(); block_specs.len()];
    let pattern = Pattern { nodes: &specs, blocks: &block_specs };
    let mut matrix = Matrix { pattern, nodes: &mut nodes, blocks: &mut blocks };
    matrix.factor(&links, &locks);
    // Node and row of each lock.
    let places: Vec<(usize, usize)> = links
        .iter()
        .enumerate()
        .flat_map(|(joint, link)| {
            let place = specs.iter().position(|spec| spec.joint as usize == joint);
            (0..link.signature().lock_rows()).map(move |row| (place.expect("each joint is a node"), row))
        })
        .collect();
    let lanes: Vec<_> = (0..LANES).map(|lane| jacobian(members, &links, &locks, lane)).collect();
    // Rates that some motion has, so that rows which say the same agree.
    let y: Vec<Vec<f64>> = lanes
        .iter()
        .map(|jacobian| {
            let motion: Vec<f64> = jacobian[0].iter().map(|_| f64::from(random.signed())).collect();
            jacobian.iter().map(|row| row.iter().zip(&motion).map(|(j, v)| j * v).sum()).collect()
        })
        .collect();
    let mut x = vec![vec![0.0; locks.len()]; LANES];
    let mut left = y.clone();
    for _ in 0..SOLVES {
        matrix.nodes.iter_mut().for_each(|node| node.side = [LaneVec::ZERO.x; 6]);
        for (i, &(place, row)) in places.iter().enumerate() {
            (0..LANES).for_each(|lane| matrix.nodes[place].side[row].set(lane, left[lane][i] as f32));
        }
        matrix.solve();
        for lane in 0..LANES {
            for (x, &(place, row)) in x[lane].iter_mut().zip(&places) {
                *x -= f64::from(matrix.nodes[place].side[row].get(lane));
            }
            let give = if lane == 3 { 0.5 } else { 0.0 };
            left[lane] = left_of(&lanes[lane], give, (&x[lane], &y[lane]));
        }
    }
    left.iter().flatten().fold(0.0, |worst: f64, left| worst.max(left.abs()))
}

#[test]
fn trees_are_solved() {
    let mut random = Random(0x9e37_79b9_7f4a_7c15);
    for joints in [2, 3, 5, 12, 30, JOINTS_MAX as u32] {
        for _ in 0..20 {
            let members = members(&mut random, joints, 0);
            let blocks = pattern(&members).1.len();
            assert!(blocks < 2 * members.len(), "a tree fills nothing: {blocks} of {joints}");
            let worst = solve(&mut random, &members);
            assert!(worst < 1.0e-5, "{joints} joints: {worst:e}");
        }
    }
}

#[test]
fn loops_are_solved() {
    let mut random = Random(77);
    for (joints, more) in [(3, 1), (5, 2), (12, 2), (30, 3)] {
        let mut tried = 0;
        while tried < 20 {
            let mut members = members(&mut random, joints, more);
            // As few rows as a loop leaves free, or there is no solution.
            members.iter_mut().for_each(|member| member.signature = KINDS[0]);
            if Elimination::of(&members).is_none() {
                continue;
            }
            tried += 1;
            let worst = solve(&mut random, &members);
            // What is nearly said by others is damped, and needs more sweeps.
            assert!(worst < 5.0e-2, "{joints} and {more} joints: {worst:e}");
        }
    }
}

#[test]
fn every_joint_and_body_goes_once() {
    let mut random = Random(5);
    for _ in 0..50 {
        let joints = 2 + random.below(40) as u32;
        let members = members(&mut random, joints, 1);
        let Some(elimination) = Elimination::of(&members) else { continue };
        let (nodes, blocks) = elimination.size();
        assert_eq!(nodes, members.len() + joints as usize);
        let (nodes, block_specs) = pattern(&members);
        let mut seen: Vec<u32> = nodes.iter().map(|node| node.joint).filter(|&joint| joint != NONE).collect();
        seen.sort_unstable();
        assert!(seen.iter().copied().eq(0..members.len() as u32));
        // Each block of J is started from once, and rows come after their columns.
        let mut sources: Vec<u32> =
            block_specs.iter().map(|block| block.source).filter(|&source| source != NONE).collect();
        sources.sort_unstable();
        sources.dedup();
        let ends = members.iter().flat_map(|m| m.bodies).filter(|&b| b != NONE).count();
        assert_eq!((sources.len(), block_specs.len()), (ends, blocks));
        for (place, node) in nodes.iter().enumerate() {
            let own = &block_specs[node.first_block as usize..(node.first_block + node.blocks) as usize];
            assert!(own.iter().all(|block| block.row as usize > place));
            assert!(own.is_sorted_by_key(|block| block.row));
        }
    }
}
