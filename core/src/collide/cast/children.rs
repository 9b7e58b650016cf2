//! Compounds in queries: the boxes of their children, and their children as what moves.

use super::frame::Frame;
use super::support::Core;
use crate::collide::Solid;
use crate::collide::compound::Compound;
use glam::DVec3;

/// Boxes of children are rounded by less than this fraction of the tree's greatest coordinate.
const SLACK: f64 = 1.0e-6;

/// By how much the children's boxes may be off, metres.
pub(super) fn slack(compound: &Compound<'_>) -> f64 {
    let bounds = compound.tree.bounds();
    let reach = crate::math::max_each(bounds.min.abs(), bounds.max.abs()).max_element();
    SLACK * f64::from(reach)
}

/// A box (least and greatest coordinates) that grows by the rounding of the children's boxes.
pub(super) fn grown(compound: &Compound<'_>, (low, high): (DVec3, DVec3)) -> (DVec3, DVec3) {
    let slack = DVec3::splat(slack(compound));
    (low - slack, high + slack)
}

/// A solid as convex parts.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Parts<'a> {
    /// A convex shape.
    One(Core<'a>),
    /// Children.
    Many(Compound<'a>),
}

impl<'a> Parts<'a> {
    /// `None` when the solid has no inside, or no end.
    pub fn new(solid: &Solid<'a>) -> Option<Self> {
        match *solid {
            Solid::Compound(compound) => Some(Self::Many(compound)),
            _ => Core::new(solid).map(Self::One),
        }
    }

    /// Every part with its frame, the whole standing at `frame`.
    pub fn at(&self, frame: &Frame) -> impl Iterator<Item = (Core<'a>, Frame)> {
        let (parts, frame) = (*self, *frame);
        let count = match parts {
            Self::One(_) => 1,
            Self::Many(compound) => compound.len() as u32,
        };
        (0..count).filter_map(move |index| match parts {
            Self::One(core) => Some((core, frame)),
            Self::Many(compound) => {
                let (child, pose) = compound.child(index);
                Core::new(&child).map(|core| (core, frame.after(&Frame::of(&pose))))
            }
        })
    }

    /// The least and the greatest coordinates at a frame, in the outer frame.
    pub fn bounds(&self, frame: &Frame) -> (DVec3, DVec3) {
        let none = (DVec3::splat(f64::INFINITY), DVec3::splat(f64::NEG_INFINITY));
        self.at(frame).fold(none, |(least, most), (core, frame)| {
            let (low, high) = core.bounds(&frame);
            (each(least, low, |a, b| a < b), each(most, high, |a, b| a > b))
        })
    }
}

/// The greatest size of each coordinate of a box.
pub(crate) fn most(low: DVec3, high: DVec3) -> DVec3 {
    each(-low, high, |a, b| a > b)
}

/// Of each component of two vectors the one that `is_first` says.
fn each(a: DVec3, b: DVec3, is_first: impl Fn(f64, f64) -> bool) -> DVec3 {
    let of = |a: f64, b: f64| if is_first(a, b) { a } else { b };
    DVec3::new(of(a.x, b.x), of(a.y, b.y), of(a.z, b.z))
}
