//! Joints as lines.

use crate::arena::Line;
use crate::body::{Position, turned_frame};
use crate::debug::wireframe::Pen;
use crate::debug::{Color, DebugDraw, DebugLayers, DebugOptions, colors};
use crate::joint::{AxisMotion, BROKEN, Coupling, JointDef, axis};
use crate::math::{PI, Pose, Rotation, Vec3, cos, length, max, min, normalize_or, sin};
use crate::world::World;

/// Lines from a cone's apex to its rim, and what they are apart.
const CONE_SIDES: [(f32, f32); 4] = [(1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0)];

/// A joint as it stands, relative to the drawing's origin.
struct Standing {
    def: JointDef,
    frames: [Pose; 2],
    /// The bodies' centers of mass.
    centers: [Vec3; 2],
    coordinates: [f32; 6],
}

impl<M: AsRef<[Line]> + AsMut<[Line]>> World<M> {
    /// Draws the joints that have a frame within reach.
    pub(super) fn draw_joints(&self, origin: Position, options: &DebugOptions, draw: &mut impl DebugDraw) {
        let spans = &self.layout.state;
        let (rows, bodies) = (spans.joints.of(self.state()), spans.bodies.of(self.state()));
        let motions = spans.motions.of(self.state());
        for joint in self.joints() {
            let row = &rows[joint.index as usize];
            let (Ok(def), Ok(coordinates)) = (self.joint(joint), self.joint_coordinates(joint)) else {
                continue;
            };
            let [first, second] = row.bodies.map(|slot| slot as usize);
            let centers = [first, second].map(|slot| motions[slot].center.minus(origin));
            let arm = turned_frame(motions[first].rotation, &bodies[first], &row.frames[0]).position;
            let frames = self.joint_frames(row).map(|f| Pose::new(f.position + arm + centers[0], f.rotation));
            let is_far = frames.iter().all(|frame| length(frame.position) > options.reach);
            if is_far || row.has(BROKEN) {
                continue;
            }
            let joint = Standing { def, frames, centers, coordinates };
            if options.layers.has(DebugLayers::JOINTS) {
                joint.draw(options, draw);
            }
            if options.layers.has(DebugLayers::JOINT_LIMITS) {
                joint.draw_limits(options, draw);
            }
        }
    }
}

fn pen<'a, D: DebugDraw>(draw: &'a mut D, color: Color, options: &DebugOptions) -> Pen<'a, D> {
    Pen { draw, color, reach: options.reach }
}

impl Standing {
    fn draw(&self, options: &DebugOptions, draw: &mut impl DebugDraw) {
        for (frame, center) in self.frames.iter().zip(self.centers) {
            draw.line(center, frame.position, colors::JOINT);
            let m = frame.rotation.matrix();
            for (axis, color) in [m.x_axis, m.y_axis, m.z_axis].into_iter().zip(colors::AXES) {
                draw.line(frame.position, frame.position + axis * options.axis_length, color);
            }
        }
        draw.line(self.frames[0].position, self.frames[1].position, colors::JOINT_GAP);
    }

    fn draw_limits(&self, options: &DebugOptions, draw: &mut impl DebugDraw) {
        let [a, b] = &self.frames;
        let m = a.rotation.matrix();
        match self.def.coupling {
            Coupling::Frames => {
                for (index, along) in [m.x_axis, m.y_axis, m.z_axis].into_iter().enumerate() {
                    self.draw_range(index, along, options, draw);
                }
                for index in [axis::TURN_X, axis::TURN_Y, axis::TURN_Z] {
                    self.draw_turn(index, options, draw);
                }
                if let Some(angle) = self.def.cone {
                    self.draw_cone(angle, options, draw);
                }
            }
            Coupling::Distance => {
                self.draw_range(0, normalize_or(b.position - a.position, m.x_axis), options, draw);
            }
            Coupling::Gear { .. } | Coupling::Rack { .. } => {}
        }
    }

    /// The range of a limited coordinate, at most `span` to either side of where it is.
    fn range(&self, index: usize, span: f32) -> Option<[f32; 2]> {
        let AxisMotion::Limited { lower, upper } = self.def.axes[index].motion else { return None };
        let now = self.coordinates[index];
        let lower = if lower.is_finite() { lower } else { min(now, upper) - span };
        let upper = if upper.is_finite() { upper } else { max(now, lower) + span };
        Some([lower, upper])
    }

    /// Where B's frame may stand along a line from A's.
    fn draw_range(&self, index: usize, along: Vec3, options: &DebugOptions, draw: &mut impl DebugDraw) {
        if let Some([lower, upper]) = self.range(index, options.reach) {
            let from = self.frames[0].position;
            draw.line(from + along * lower, from + along * upper, colors::JOINT_LIMIT);
        }
    }

    /// An arc about the axis of a turn: see [`crate::joint`] for which that is.
    fn draw_turn(&self, index: usize, options: &DebugOptions, draw: &mut impl DebugDraw) {
        let Some([lower, upper]) = self.range(index, PI) else { return };
        let [a, b] = &self.frames;
        let turn = self.coordinates[index];
        let length = options.axis_length;
        let (pose, from, over) = match index {
            axis::TURN_X => {
                let start = b.rotation.after(Rotation::from_axis_angle(Vec3::X, -turn));
                (Pose::new(b.position, start), Vec3::Y, Vec3::Z)
            }
            axis::TURN_Y => {
                let about_z = Rotation::from_axis_angle(Vec3::Z, self.coordinates[axis::TURN_Z]);
                (Pose::new(a.position, a.rotation.after(about_z)), Vec3::X, Vec3::NEG_Z)
            }
            _ => (*a, Vec3::X, Vec3::Y),
        };
        let (from, over) = (from * length, over * length);
        let at = |turn: f32| from * cos(turn) + over * sin(turn);
        let mut limits = pen(&mut *draw, colors::JOINT_LIMIT, options);
        limits.sector(&pose, (from, over), [lower, min(upper, lower + 2.0 * PI)]);
        limits.line(&pose, Vec3::ZERO, at(lower));
        limits.line(&pose, Vec3::ZERO, at(upper));
        pen(draw, colors::JOINT, options).line(&pose, Vec3::ZERO, at(turn));
    }

    /// The rim that the x axis of B's frame may not pass, and four lines to it.
    fn draw_cone(&self, angle: f32, options: &DebugOptions, draw: &mut impl DebugDraw) {
        let (height, radius) = (cos(angle) * options.axis_length, sin(angle) * options.axis_length);
        let a = &self.frames[0];
        let rim = Pose::new(a.transform(Vec3::X * height), a.rotation);
        let mut limits = pen(draw, colors::JOINT_LIMIT, options);
        limits.sector(&rim, (Vec3::Y * radius, Vec3::Z * radius), [0.0, 2.0 * PI]);
        for (y, z) in CONE_SIDES {
            limits.line(a, Vec3::ZERO, Vec3::new(height, y * radius, z * radius));
        }
    }
}
