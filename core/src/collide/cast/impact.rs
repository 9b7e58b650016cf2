//! When a convex shape that moves and turns first meets a shape.
//!
//! Conservative advancement (Mirtich 1996; van den Bergen, "Continuous Collision Detection of General Convex
//! Objects under Translation", 2005, and here with turns): the plane between two convex sets at the time `t` parts
//! them until some point of one has gone through it, and how fast points can come is bounded. With the unit normal
//! `n` from the moving shape to the other, `v` its way and `w` its turn over the step, `r` the arm of a point from
//! its center and `R` the greatest arm across the axis,
//! ```text
//! gap closes in d by at most   n.v d + |n x w| R d                               the rate of the fastest point
//!                        and   n.v d + max r.(n x w) d + |w| |n x w| R d^2 / 2   as points go now, and a rest
//! ```
//! and the greater of the two steps is taken. Nothing is passed, whatever turns; a motion without turns takes the
//! steps of Newton's method as `sweep.rs` does. A shape whose plane does not come nearer is done at once, so a
//! slide along a wall is one step.
//!
//! The impact is where the shapes are a small gap apart. **Shapes that touch at the start** are the business of
//! contacts, as far as their skin: of those only what is left when a skin is taken off is looked at, a thicker one
//! until the rest is free. So a wheel that rolls on a floor is not stopped, and still does not go through it.
//!
//! An impact counts only when the shapes, gone on, would overlap by more than the thinnest skin: contacts are
//! soft, and what they leave of an overlap is no reason to stop.

use super::children;
use super::course::{Course, Rider, Turn};
use super::frame::{Frame, length, widened};
use super::gjk::Pair;
use super::grid;
use super::support::Core;
use crate::collide::Solid;
use crate::collide::tree::Tree;
use crate::collide::tree::search::Way;
use glam::DVec3;

/// Most steps of an advance. One that takes more is taken for an impact where it ended: nothing passes.
const STEPS_MAX: usize = 96;
/// Skins, as shares of the inner radius, that are taken off one after the other.
const SKINS: [f64; 4] = [0.25, 0.5, 0.75, 0.95];
/// Finer ones come before them if the first shortens the ends of a shape by more than this, metres: those of a
/// slender cone or hull are thinner than the rest.
const ENDS_MAX: f64 = 0.005;
/// How thick the finer ones are, as multiples of the finest.
const FINER: [f64; 3] = [1.0, 3.0, 9.0];
/// How many skins there are of a shape.
const LAYERS: usize = FINER.len() + SKINS.len();
/// Gap at an impact as a share of the inner radius.
const GAP_SHARE: f64 = 0.05;
/// Least and greatest gap at an impact, metres: positions are resolved to 4 micrometres, and contacts are found
/// within 20 mm.
const GAP_MIN: f64 = 2.0e-5;
const GAP_MAX: f64 = 1.0e-3;
/// A shape that is off the axis of a twist by less than this share of its size is on it.
const ROUND_SHARE: f64 = 1.0e-3;
/// Fraction of a step that a body goes on if its skin allows: else one that is hindered again and again, as a
/// rod that dances on its end, would stay where it is.
const EARLY: f64 = 0.1;
/// A contact lets a gap close within a substep: points that would close it so often in a step are not held.
const HOLD: f64 = 10.0;
/// Way by which a round shape may swing, as a share of the gap at an impact, for its way to be taken as straight.
const WOBBLE_SHARE: f64 = 0.25;
/// Shapes touch when they are nearer than this share of the gap.
const TOUCH_SHARE: f64 = 1.0 / 16.0;

/// How two shapes are apart, in the axes of the courses.
#[derive(Clone, Copy)]
struct Gap {
    /// Metres.
    distance: f64,
    /// Certainly not more than that.
    least: f64,
    /// Unit vector from what moves to the other.
    normal: DVec3,
    /// A point of the other that is nearest.
    point: DVec3,
}

impl Gap {
    fn impact(&self, time: f64) -> Impact {
        Impact { time, normal: self.normal, point: self.point }
    }
}

/// Where a body is stopped.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Impact {
    /// Fraction of the step.
    pub time: f64,
    /// Unit vector from the body to what stops it.
    pub normal: DVec3,
    /// A point of that which is nearest.
    pub point: DVec3,
}

/// What an advance came to.
enum Outcome {
    /// The shapes touch at its start.
    Touches,
    /// They do not meet.
    Clear,
    /// They meet.
    Meets(Impact),
}

/// The other shape, convex or a half-space.
enum Wall<'a> {
    HalfSpace,
    Convex(Core<'a>),
}

/// A moving shape, its skins, and what its motion is bounded by.
#[derive(Clone, Copy)]
struct Mover<'a> {
    core: Core<'a>,
    local: Frame,
    /// Without a twist that the shape does not show.
    course: Course,
    skins: [f64; LAYERS],
    /// Greatest distance of a point of the core from the axis of the swing, metres.
    lever: f64,
    /// And of a point of the shape from the body's center.
    reach: f64,
    /// The greatest way of a point of the core by the twist, metres.
    twist: f64,
    gap: f64,
}

impl<'a> Mover<'a> {
    fn new(rider: &Rider<'a, Core<'a>>) -> Self {
        let core = rider.shape;
        let (low, high) = core.bounds(&rider.local);
        let most = |low: f64, high: f64| greater(-low, high);
        let corner = DVec3::new(most(low.x, high.x), most(low.y, high.y), most(low.z, high.z));
        let gap = lesser(greater(GAP_SHARE * core.inner_radius(), GAP_MIN), GAP_MAX);
        let skins = skins(&core);
        let mut course = *rider.course;
        let reach = length(corner);
        let mut twist = 0.0;
        if course.twist.angle != 0.0 {
            twist = course.twist.angle.abs() * lever(rider, course.twist.axis);
            let frame = course.start.at(DVec3::ZERO).after(&rider.local);
            let off = length(frame.position.cross(course.twist.axis))
                + length(core.axis_of(&frame).cross(course.twist.axis)) * reach;
            if core.is_round() && off < ROUND_SHARE * reach {
                // What turns about its own axis stands still, unless that axis swings by more than the gap shows.
                let axis = course.twist.axis;
                let swing = course.swing.axis * course.swing.angle;
                let across = swing - axis * swing.dot(axis);
                if length(across) * reach < WOBBLE_SHARE * gap {
                    course.swing = Turn::of(across);
                }
                (course.twist, twist) = (Turn::NONE, 0.0);
            }
        }
        Self {
            core,
            local: rider.local,
            course,
            skins,
            // A twist brings other points across the axis of the swing.
            lever: if twist == 0.0 { lever(rider, course.swing.axis) } else { reach },
            reach,
            twist,
            gap,
        }
    }

    fn at(&self, time: f64) -> Frame {
        self.course.at(time).after(&self.local)
    }

    /// What is left of the shape without a skin.
    fn thinner(&self, layer: usize) -> Core<'a> {
        self.core.eroded(self.skins[layer])
    }

    fn gap(&self, core: &Core<'_>, (wall, other): (&Wall<'_>, &Rider<'_, ()>), time: f64) -> Gap {
        let (frame, own) = (other.at(time), self.at(time));
        let b_in_a = frame.relative(&own);
        match wall {
            Wall::HalfSpace => {
                let lowest = b_in_a.transform(core.support(b_in_a.unturn(DVec3::NEG_Z)));
                let distance = lowest.z - core.radius;
                let point = frame.transform(DVec3::new(lowest.x, lowest.y, 0.0));
                Gap { distance, least: distance, normal: frame.turn(DVec3::NEG_Z), point }
            }
            Wall::Convex(a) => {
                let pair = Pair { a, b: core, b_in_a };
                let found = pair.separation(&mut pair.start());
                let radius = a.radius + core.radius;
                Gap {
                    distance: found.distance - radius,
                    least: found.least - radius,
                    normal: frame.turn(found.direction),
                    point: frame.transform(found.on_a - found.direction * a.radius),
                }
            }
        }
    }

    /// How long a gap certainly stays open from a time on; infinite when it does not close.
    fn free_time(
        &self,
        core: &Core<'_>,
        (other, time): (&Rider<'_, ()>, f64),
        (gap, normal): (f64, DVec3),
    ) -> f64 {
        let (own, theirs) = (&self.course, other.course);
        let mut linear = normal.dot(own.way - theirs.way);
        if theirs.most() != 0.0 {
            // Seen from a body that turns all else turns about it. The distance of two centers is greatest at an
            // end.
            let apart = |t: f64| length(own.at(t).position - theirs.at(t).position);
            linear += theirs.most() * (greater(apart(time), apart(1.0)) + self.reach);
        }
        let cross = normal.cross(own.swing.axis * own.swing.angle);
        let size = length(cross);
        let fastest = linear + size * self.lever + self.twist;
        let by_fastest = if fastest > 0.0 { gap / fastest } else { f64::INFINITY };
        if size == 0.0 && self.twist == 0.0 {
            return by_fastest;
        }
        let frame = own.at(time).at(DVec3::ZERO).after(&self.local);
        let cross = cross + normal.cross(own.twist_at(time));
        let now = linear + frame.transform(core.support(frame.unturn(cross))).dot(cross);
        // now d + rest d^2 = gap, the positive root.
        let rest = if self.twist == 0.0 {
            0.5 * size * own.swing.angle.abs() * self.lever
        } else {
            0.5 * own.most() * own.most() * self.reach
        };
        let root = libm::sqrt(now * now + 4.0 * rest * gap);
        let divisor = root + now;
        let by_now = if divisor > 0.0 { 2.0 * gap / divisor } else { by_fastest };
        greater(by_fastest, by_now)
    }

    /// True when the point that is nearest to a wall goes towards it faster than a contact would let it.
    fn comes_nearer(&self, other: &Rider<'_, ()>, (time, gap): (f64, &Gap)) -> bool {
        let rate = |course: &Course| {
            let turn = course.swing.axis * course.swing.angle + course.twist_at(time);
            course.way + turn.cross(gap.point - course.at(time).position)
        };
        gap.normal.dot(rate(&self.course) - rate(other.course)) > HOLD * gap.distance
    }

    /// Advances a core from a time until it meets a wall, or to the limit.
    fn advance(
        &self,
        core: &Core<'_>,
        wall: (&Wall<'_>, &Rider<'_, ()>),
        (start, limit): (f64, f64),
    ) -> Outcome {
        let mut time = start;
        let mut found = self.gap(core, wall, time);
        if found.distance <= self.gap * TOUCH_SHARE {
            return Outcome::Touches;
        }
        let mut target = self.gap;
        if found.distance <= target {
            if self.comes_nearer(wall.1, (time, &found)) {
                return Outcome::Meets(found.impact(time));
            }
            target = 0.75 * found.distance;
        }
        for _ in 0..STEPS_MAX {
            let closes = self.free_time(core, (wall.1, time), (1.0, found.normal));
            if closes == f64::INFINITY {
                return Outcome::Clear;
            }
            if found.distance <= target {
                return Outcome::Meets(found.impact(time));
            }
            // Where rounding leaves no proof the distance itself is right to rounding.
            let proved = found.least - 0.5 * target;
            let way = if proved > 0.1 * found.distance { proved } else { 0.4 * found.distance };
            let ahead = time + self.free_time(core, (wall.1, time), (way, found.normal));
            if ahead > limit {
                return Outcome::Clear;
            }
            let next = self.gap(core, wall, ahead);
            if next.distance <= 0.0 {
                // By rounding: they were apart just before.
                return Outcome::Meets(found.impact(time));
            }
            (found, time) = (next, ahead);
        }
        Outcome::Meets(found.impact(time))
    }

    /// Where the shape meets a wall, as far as contacts alone cannot stop it; at most the limit.
    fn meets(&self, wall: (&Wall<'_>, &Rider<'_, ()>), limit: f64) -> Option<Impact> {
        self.first_meeting(wall, limit).or_else(|| if limit >= 1.0 { self.ends_inside(wall) } else { None })
    }

    /// The end, if the body's last place is no end of its course, and in the wall where its first place was not.
    fn ends_inside(&self, wall: (&Wall<'_>, &Rider<'_, ()>)) -> Option<Impact> {
        let end = self.course.end?;
        let thinner = &self.thinner(if self.course.held { LAYERS - 1 } else { 0 });
        let last = Self { course: Course::still(end), ..*self };
        let found = last.gap(thinner, wall, 1.0);
        let enters = found.distance <= 0.0 && self.gap(thinner, wall, 0.0).distance > 0.0;
        enters.then(|| found.impact(1.0))
    }

    fn first_meeting(&self, wall: (&Wall<'_>, &Rider<'_, ()>), limit: f64) -> Option<Impact> {
        let from = self.course.from;
        if self.course.held {
            return match self.advance(&self.thinner(LAYERS - 1), wall, (from, limit)) {
                Outcome::Meets(impact) => Some(impact),
                Outcome::Clear | Outcome::Touches => None,
            };
        }
        match self.advance(&self.core, wall, (from, limit)) {
            Outcome::Clear => None,
            Outcome::Meets(impact) => {
                match self.advance(&self.thinner(0), wall, (impact.time, 1.0)) {
                    Outcome::Clear => None,
                    // Into the skin rather than not at all: an overlap is what contacts push out.
                    Outcome::Meets(later) if impact.time - from < EARLY => {
                        Some(Impact { time: lesser(later.time, from + EARLY), ..impact })
                    }
                    _ => Some(impact),
                }
            }
            Outcome::Touches => {
                for i in 0..LAYERS {
                    if i > 0 && self.skins[i] == self.skins[i - 1] {
                        continue;
                    }
                    match self.advance(&self.thinner(i), wall, (from, limit)) {
                        Outcome::Touches => {}
                        Outcome::Clear => return None,
                        Outcome::Meets(impact) => return Some(impact),
                    }
                }
                self.middle_meets(wall, limit)
            }
        }
    }

    /// Where the middle of a shape that touches a wall with all that is left of it does so.
    fn middle_meets(&self, wall: (&Wall<'_>, &Rider<'_, ()>), limit: f64) -> Option<Impact> {
        let local = self.local.at(self.local.transform(self.core.middle()));
        let point = Self { core: Core::POINT, local, ..*self };
        match point.advance(&point.core, wall, (self.course.from, limit)) {
            Outcome::Meets(impact) => Some(impact),
            Outcome::Clear | Outcome::Touches => None,
        }
    }

    /// The way of the moving body's center in the frame of the other shape: where it starts, its unit direction
    /// and its length; and how far from the center anything can be met.
    fn way(&self, other: &Rider<'_, ()>) -> ((DVec3, DVec3, f64), (DVec3, DVec3)) {
        let (first, last) = (other.at(self.course.from), other.at(1.0));
        let from = first.untransform(self.course.start.position);
        let to = last.untransform(self.course.at(1.0).position);
        let span = length(to - from);
        let direction = if span > 0.0 { (to - from) / span } else { DVec3::ZERO };
        // Seen from what turns the way is bent, by less than its ends are swept.
        let sag = other.course.most() * (greater(length(from), length(to)) + length(other.local.position));
        let reach = DVec3::splat(self.reach + 2.0 * self.gap + sag);
        ((from, direction, span), (-reach, reach))
    }
}

/// Where a convex shape meets another body's shape so that contacts alone may not stop it: at the fraction of the
/// step at which they are a small gap apart. Meetings later than `limit` may be left out.
pub(crate) fn impact(
    other: &Rider<'_, Solid<'_>>,
    rider: &Rider<'_, Core<'_>>,
    limit: f64,
) -> Option<Impact> {
    let mover = Mover::new(rider);
    let place = Rider { shape: (), local: other.local, course: other.course };
    match other.shape {
        Solid::HalfSpace => mover.meets((&Wall::HalfSpace, &place), limit),
        Solid::Mesh(mesh) => along_tree(&mesh.tree, (&mover, &place), limit, |index| {
            let corners = mesh.triangles[index as usize].vertices.map(|v| widened(mesh.vertices[v as usize]));
            Some((Wall::Convex(Core::triangle(corners)), place))
        }),
        Solid::Compound(compound) => {
            let grown = children::slack(&compound);
            along_grown(&compound.tree, (&mover, &place, grown), limit, |index| {
                let (child, pose) = compound.child(index);
                let local = place.local.after(&Frame::of(&pose));
                Core::new(&child).map(|core| (Wall::Convex(core), Rider { local, ..place }))
            })
        }
        Solid::HeightField(field) => {
            let (way, bounds) = mover.way(&place);
            let mut first = First::until(limit);
            let most = way.2;
            grid::along(&field, way, bounds, first.reach(&mover.course, most), |_, corners| {
                let wall = Wall::Convex(Core::triangle(corners));
                first.add(mover.meets((&wall, &place), first.limit));
                first.reach(&mover.course, most)
            });
            first.impact
        }
        _ => mover.meets((&Wall::Convex(Core::new(&other.shape)?), &place), limit),
    }
}

/// The first impact of those found.
#[derive(Clone, Copy)]
pub(crate) struct First {
    pub impact: Option<Impact>,
    /// What comes later is no longer looked for.
    pub limit: f64,
}

impl First {
    /// None yet; none after `limit` will be asked for.
    pub fn until(limit: f64) -> Self {
        Self { impact: None, limit }
    }

    /// Takes an impact if it is earlier than the one before.
    pub fn add(&mut self, found: Option<Impact>) {
        if let Some(impact) = found.filter(|impact| self.impact.is_none() || impact.time < self.limit) {
            (self.impact, self.limit) = (found, impact.time);
        }
    }

    /// How far along a way of this length there may be an earlier one, metres; without end before any is found.
    pub fn reach(&self, course: &Course, length: f64) -> f64 {
        if self.limit < 1.0 { course.share(self.limit) * length } else { f64::MAX }
    }
}

/// The skins that are taken off a shape, as shares of its inner radius; some twice.
fn skins(core: &Core<'_>) -> [f64; LAYERS] {
    let ends = core.ends();
    let finest = if SKINS[0] * ends > ENDS_MAX { ENDS_MAX / ends } else { SKINS[0] };
    let [a, b, c] = FINER.map(|times| lesser(times * finest, SKINS[0]));
    let [d, e, f, g] = SKINS;
    [a, b, c, d, e, f, g]
}

/// The greatest distance of a point of a shape's core from an axis through its body's center, at the start,
/// metres.
fn lever(rider: &Rider<'_, Core<'_>>, axis: DVec3) -> f64 {
    let frame = rider.course.start.at(DVec3::ZERO).after(&rider.local);
    let away = if axis.x.abs() < 0.6 { DVec3::X } else { DVec3::Y };
    let first = axis.cross(away);
    let first = first / length(first);
    let second = axis.cross(first);
    let core = rider.shape;
    let along = |d: DVec3| frame.transform(core.support(frame.unturn(d))).dot(d);
    let most = |d: DVec3| greater(along(d), along(-d));
    let (x, y) = (most(first), most(second));
    libm::sqrt(x * x + y * y)
}

fn along_tree<'a>(
    tree: &Tree<'_>,
    (mover, place): (&Mover<'_>, &Rider<'_, ()>),
    limit: f64,
    wall: impl Fn(u32) -> Option<(Wall<'a>, Rider<'a, ()>)>,
) -> Option<Impact> {
    along_grown(tree, (mover, place, 0.0), limit, wall)
}

/// The first meeting with the leaves of a tree, whose boxes are off by at most `slack` metres.
fn along_grown<'a>(
    tree: &Tree<'_>,
    (mover, place, slack): (&Mover<'_>, &Rider<'_, ()>, f64),
    limit: f64,
    wall: impl Fn(u32) -> Option<(Wall<'a>, Rider<'a, ()>)>,
) -> Option<Impact> {
    let (course, (low, high)) = mover.way(place);
    let most = course.2;
    let way = Way::new(tree, course, (low - DVec3::splat(slack), high + DVec3::splat(slack)))?;
    let mut first = First::until(limit);
    tree.search(
        way.limit(first.reach(&mover.course, most)),
        |bounds| way.bound(bounds),
        |index| {
            if let Some((wall, rider)) = wall(index) {
                first.add(mover.meets((&wall, &rider), first.limit));
            }
            way.limit(first.reach(&mover.course, most))
        },
    );
    first.impact
}

fn lesser(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

fn greater(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{Rotation, Vec3};

    fn rod() -> Core<'static> {
        Core::new(&Solid::Box { half_extents: Vec3::new(0.5, 0.01, 0.01) }).expect("convex")
    }

    fn meeting(wall: Solid<'_>, course: &Course) -> Option<f64> {
        let still = Course::still(Frame::IDENTITY);
        let wall = Rider { shape: wall, local: Frame::IDENTITY, course: &still };
        impact(&wall, &Rider { shape: rod(), local: Frame::IDENTITY, course }, 1.0).map(|impact| impact.time)
    }

    fn at(place: DVec3) -> Course {
        Course::still(Frame::new(place, Rotation::IDENTITY))
    }

    #[test]
    fn a_rod_that_turns_meets_the_ground_when_its_end_does() {
        for height in [0.2, 0.3, 0.45] {
            let swing = Turn { axis: DVec3::Y, angle: 3.0 };
            let found = meeting(Solid::HalfSpace, &Course { swing, ..at(DVec3::Z * height) });
            let found = found.expect("its end comes down");
            // The lowest corner: half the length times the sine, and half the thickness times the cosine.
            let angle = 3.0 * found;
            let low = height - 0.5 * libm::sin(angle) - 0.01 * libm::cos(angle);
            assert!((0.0..=GAP_MAX).contains(&low), "{height}: {low} m above the ground");
        }
        let swing = Turn { axis: DVec3::Z, angle: 3.0 };
        assert_eq!(meeting(Solid::HalfSpace, &Course { swing, ..at(DVec3::Z * 0.02) }), None);
    }

    #[test]
    fn what_flies_straight_meets_a_thin_wall_and_passes_beside_it() {
        let wall = Solid::Box { half_extents: Vec3::new(0.005, 1.0, 1.0) };
        let way = DVec3::X * 16.0;
        let found = meeting(wall, &Course { way, ..at(DVec3::X * -8.0) }).expect("it is in the way");
        let gap = 8.0 - 16.0 * found - 0.505;
        assert!((0.0..=GAP_MAX).contains(&gap), "{gap} m before the wall");
        assert_eq!(meeting(wall, &Course { way, ..at(DVec3::new(-8.0, 1.011, 0.0)) }), None);
        assert_eq!(meeting(wall, &Course { way: -way, ..at(DVec3::X * -8.0) }), None);
    }

    #[test]
    fn what_lies_on_the_ground_slides_and_does_not_sink() {
        let slide = Course { way: DVec3::X * 10.0, ..at(DVec3::Z * 0.0099) };
        assert_eq!(meeting(Solid::HalfSpace, &slide), None);
        let sinks = Course { way: DVec3::new(10.0, 0.0, -0.1), ..at(DVec3::Z * 0.0099) };
        let found = meeting(Solid::HalfSpace, &sinks).expect("it would go under");
        let depth = 0.0001 + 0.1 * found;
        assert!(depth < 0.25 * 0.01 + 1.0e-3, "{depth} m deep");
    }
}
