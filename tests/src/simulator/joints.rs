//! What the player does with joints: all kinds, where the bodies are or somewhere else.

use super::Simulator;
use crate::worlds::OwnedWorld;
use cellstep::joint::axis::{TURN_X, TURN_Z, X, Z};
use cellstep::math::{Pose, Vec3};
use cellstep::{Axis, AxisMotion, BodyHandle, Command, Coupling, Drive, JointDef, JointHandle, Spring};

impl Simulator {
    /// A command about joints.
    pub(super) fn of_joint(&mut self, world: &OwnedWorld) -> Command {
        if self.joints.is_empty() || self.random.below(10) < 4 {
            return Command::CreateJoint(self.joint_def(world));
        }
        let joint = self.joint();
        match self.random.below(8) {
            0..2 => Command::RemoveJoint(joint),
            2..4 => {
                let mut def = self.joint_def(world);
                // Mostly the same bodies: others are refused.
                match world.joint(joint) {
                    Ok(old) if self.random.below(8) > 0 => {
                        def.bodies = old.bodies;
                        if self.random.below(2) == 0 {
                            def = JointDef { axes: def.axes, ..old };
                        }
                    }
                    _ => {}
                }
                Command::SetJoint(joint, def)
            }
            4..7 => Command::SetJointAxis(joint, self.random.below(7) as u32, self.axis()),
            _ => Command::SetJointUser(joint, self.random.bits()),
        }
    }

    fn joint(&mut self) -> JointHandle {
        self.joints[self.random.below(self.joints.len() as u64) as usize]
    }

    /// A joint of any kind between any two bodies.
    fn joint_def(&mut self, world: &OwnedWorld) -> JointDef {
        let bodies = [self.body(), self.body()];
        let frames = self.frames(world, bodies);
        let def = self.kind_of_joint(bodies, frames);
        JointDef {
            spring: (self.random.below(4) == 0).then(|| self.spring()),
            break_force: if self.random.below(4) == 0 {
                self.random.between(100.0, 2.0e4)
            } else {
                f32::INFINITY
            },
            break_torque: if self.random.below(4) == 0 {
                self.random.between(10.0, 2.0e3)
            } else {
                f32::INFINITY
            },
            bodies_collide: self.random.below(3) == 0,
            user: self.random.bits(),
            ..def
        }
    }

    fn kind_of_joint(&mut self, bodies: [BodyHandle; 2], frames: [Pose; 2]) -> JointDef {
        let points = [frames[0].position, frames[1].position];
        match self.random.below(9) {
            0 => {
                let mut def = JointDef::ball(bodies, frames);
                def.cone = (self.random.below(2) == 0).then(|| self.random.between(0.2, 1.5));
                if self.random.below(2) == 0 {
                    def.axes[TURN_X] = Axis::limited(-0.5, 0.7);
                }
                def
            }
            1 => {
                let mut def = JointDef::hinge(bodies, frames);
                def.axes[TURN_X] = self.axis();
                def
            }
            2 => {
                let mut def = JointDef::slider(bodies, frames);
                def.axes[X] = self.axis();
                def
            }
            3 => JointDef::fixed(bodies, frames),
            4 => {
                let (lower, more) = (self.random.between(0.0, 1.0), self.random.between(0.0, 1.0));
                let upper = if self.random.below(2) == 0 { lower } else { lower + more };
                let mut def = JointDef::distance(bodies, points, lower, upper);
                if self.random.below(3) == 0 {
                    def.axes[X] = self.axis();
                }
                def
            }
            5 => {
                let mut def = JointDef::wheel(bodies, frames, self.spring());
                def.axes[TURN_X].drive = Some(Drive::motor(self.random.between(-5.0, 5.0), 50.0));
                if self.random.below(2) == 0 {
                    def.axes[TURN_Z] = Axis::limited(-0.6, 0.6);
                    def.axes[Z].motion = AxisMotion::Limited { lower: -0.2, upper: 0.2 };
                }
                def
            }
            6 => JointDef::gear(bodies, frames, self.random.between(0.5, 3.0)),
            7 => JointDef { coupling: Coupling::Rack { ratio: 0.4 }, ..JointDef::rack(bodies, frames, 1.0) },
            _ => {
                let mut def = JointDef::six_axis(bodies, frames);
                for axis in &mut def.axes {
                    *axis = self.axis();
                }
                def
            }
        }
    }

    /// Frames that meet where the bodies are, or any.
    fn frames(&mut self, world: &OwnedWorld, [a, b]: [BodyHandle; 2]) -> [Pose; 2] {
        let pose = |body: BodyHandle| Some((world.position(body).ok()?, world.rotation(body).ok()?));
        let on_a = Pose::new(self.vector(0.4), self.rotation());
        if self.random.below(5) > 0
            && let (Some((place_a, turn_a)), Some((place_b, turn_b))) = (pose(a), pose(b))
        {
            let gap = place_b.minus(place_a);
            // Near bodies only: far ones would have anchors out of range.
            if gap.dot(gap) < 100.0 {
                let (in_a, in_b) = (Pose::new(Vec3::ZERO, turn_a), Pose::new(gap, turn_b));
                return [on_a, in_b.inverse().after(&in_a.after(&on_a))];
            }
        }
        [on_a, Pose::new(self.vector(0.4), self.rotation())]
    }

    fn axis(&mut self) -> Axis {
        let motion = match self.random.below(8) {
            0..3 => AxisMotion::Free,
            3..5 => AxisMotion::Locked,
            5..7 => {
                let lower = self.random.between(-1.0, 0.5);
                AxisMotion::Limited { lower, upper: lower + self.random.between(0.0, 1.0) }
            }
            _ => [
                AxisMotion::Limited { lower: 0.3, upper: 0.3 },
                AxisMotion::Limited { lower: f32::NEG_INFINITY, upper: 0.4 },
                AxisMotion::Limited { lower: f32::NEG_INFINITY, upper: f32::INFINITY },
                // Refused.
                AxisMotion::Limited { lower: 1.0, upper: 0.5 },
            ][self.random.below(4) as usize],
        };
        Axis {
            motion,
            limit_spring: (self.random.below(5) == 0).then(|| self.spring()),
            drive: (self.random.below(3) == 0).then(|| self.drive()),
            friction: if self.random.below(4) == 0 { self.random.between(0.0, 50.0) } else { 0.0 },
        }
    }

    fn drive(&mut self) -> Drive {
        Drive {
            target: self.random.between(-1.0, 1.0),
            velocity: self.random.between(-3.0, 3.0),
            spring: (self.random.below(2) == 0).then(|| self.spring()),
            max_force: [0.0, 30.0, 1.0e3, f32::INFINITY][self.random.below(4) as usize],
        }
    }

    fn spring(&mut self) -> Spring {
        match self.random.below(3) {
            0 => Spring::Stiffness {
                stiffness: self.random.between(0.0, 5.0e3),
                damping: self.random.between(0.0, 100.0),
            },
            _ => Spring::Frequency {
                hertz: self.random.between(0.0, 10.0),
                damping_ratio: self.random.between(0.0, 2.0),
            },
        }
    }
}
