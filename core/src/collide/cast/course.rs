//! How a body goes through a step, or through what is left of one: straight ahead, turning at a constant rate.

use super::frame::{Frame, length};
use glam::DVec3;

/// A turn at a constant rate.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Turn {
    /// Unit vector.
    pub axis: DVec3,
    /// Over the step, radians.
    pub angle: f64,
}

impl Turn {
    pub const NONE: Self = Self { axis: DVec3::Z, angle: 0.0 };

    /// The turn with a rotation vector.
    pub fn of(vector: DVec3) -> Self {
        let angle = length(vector);
        if angle == 0.0 { Self::NONE } else { Self { axis: vector / angle, angle } }
    }
}

/// How a body goes through a step: its center straight ahead, its axes at constant rates. Time is a fraction of
/// the step, and places are from a point that all courses share.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Course {
    /// The body at the start: its center and axes.
    pub start: Frame,
    /// Way of the center over the step, metres.
    pub way: DVec3,
    /// The turn of the body, but for its twist.
    pub swing: Turn,
    /// The turn about an axis of the body, given as it stands at the start.
    pub twist: Turn,
    /// Where the body is at the end if that is not where its course leads.
    pub end: Option<Frame>,
    /// True for a body that is stopped only where the middle of a shape would pass.
    pub held: bool,
    /// When it starts: 0, or later for what is left of a step. Way and angles are those of a whole step.
    pub from: f64,
}

impl Course {
    /// One that stays.
    pub fn still(frame: Frame) -> Self {
        Self {
            start: frame,
            way: DVec3::ZERO,
            swing: Turn::NONE,
            twist: Turn::NONE,
            end: None,
            held: false,
            from: 0.0,
        }
    }

    /// The body at a time.
    pub fn at(&self, time: f64) -> Frame {
        let time = time - self.from;
        let mut frame = self.start.at(self.start.position + self.way * time);
        // The twist first: its axis swings.
        for Turn { axis, angle } in [self.twist, self.swing] {
            if angle != 0.0 {
                frame = frame.turned(axis, angle * time);
            }
        }
        frame
    }

    /// Rotation vector of the twist as it stands at a time.
    pub fn twist_at(&self, time: f64) -> DVec3 {
        if self.twist.angle == 0.0 {
            return DVec3::ZERO;
        }
        let swing = Frame::IDENTITY.turned(self.swing.axis, self.swing.angle * (time - self.from));
        swing.turn(self.twist.axis) * self.twist.angle
    }

    /// Its share up to a time.
    pub fn share(&self, time: f64) -> f64 {
        (time - self.from) / (1.0 - self.from)
    }

    /// What is left of it at a time at which the body stands in a frame.
    pub fn resumed(&self, time: f64, start: Frame) -> Self {
        let mut twist = self.twist;
        if twist.angle != 0.0 {
            twist.axis = self.twist_at(time) / twist.angle;
        }
        Self { start, twist, end: None, from: time, ..*self }
    }

    /// The least angle that is certainly not exceeded by the turn of the step.
    pub fn most(&self) -> f64 {
        self.swing.angle.abs() + self.twist.angle.abs()
    }
}

/// A shape of a body, convex for what moves.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rider<'a, S> {
    pub shape: S,
    /// Where it stands from the body's center.
    pub local: Frame,
    pub course: &'a Course,
}

impl<S> Rider<'_, S> {
    pub fn at(&self, time: f64) -> Frame {
        self.course.at(time).after(&self.local)
    }
}
