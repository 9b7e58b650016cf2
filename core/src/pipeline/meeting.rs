//! Two shapes meet: their relative pose, their points, and whether the points of before still serve.
//!
//! **Settled contacts.** Most pairs of polytopes in a pile hardly move against each other. Their points are found
//! once, at a *base* pose that the state keeps, and stay points of the two shapes as long as the shapes are near
//! that pose: the separations follow from where the points are now. What was found lies in the cache as a
//! [`Memo`]; after a restore it is found again at the base, to the same bits.
//!
//! The base is rounded so that it takes 20 bytes. It is where points are *looked for*; where they are, and how far
//! apart, is always computed from the exact poses.

use crate::body::{Motion, Position};
use crate::collide::{self, Manifold, Manifolds, Solid};
use crate::config::{MANIFOLD_DRIFT, SPECULATIVE_DISTANCE};
use crate::lanes::Words;
use crate::math::{Pose, Rotation, Vec3, length, sqrt};
use crate::pipeline::solid;
use crate::shape::{
    GEOMETRY_BOX, GEOMETRY_CAPSULE, GEOMETRY_HALF_SPACE, GEOMETRY_HULL, GEOMETRY_SPHERE, ShapeRow,
};
use crate::state::{AssetTables, ContactRow, Memo, Pair, Reach};
use bytemuck::Zeroable;

/// Farthest that one body of a settled contact may move against the other in a step, as a share of the drift.
/// Faster than that, impulses are large, and arms that lag behind the bodies would give them an angular momentum of
/// their own.
const SLOW_SHARE: f32 = 0.25;
/// Distance of centers up to which half-spaces need no care, metres: coordinates are exact to 0.1 mm.
const PLANE_REACH: f32 = 1024.0;
/// Drift as a share of the smaller shape's radius.
const DRIFT_SHARE: f32 = 1.0 / 64.0;

/// The frame of a shape in world axes, from its body's center.
#[inline(always)]
pub(crate) fn frame_words(pose: &Pose) -> Words {
    let (p, q) = (pose.position, pose.rotation);
    Words::new([p.x, p.y, p.z, 0.0, q.x, q.y, q.z, q.w])
}

#[inline(always)]
pub(crate) fn frame_of(words: Words) -> Pose {
    let x = words.to_array();
    Pose::new(Vec3::new(x[0], x[1], x[2]), Rotation::new(x[4], x[5], x[6], x[7]))
}

/// Where everything is.
#[derive(Clone, Copy)]
pub(crate) struct Scene<'a> {
    pub shapes: &'a [ShapeRow],
    pub motions: &'a [Motion],
    pub frames: &'a [Words],
    pub reaches: &'a [Reach],
    pub first_joints: &'a [u32],
}

impl Scene<'_> {
    /// True when the boxes and the balls of two shapes over the way of the step overlap.
    #[inline]
    pub fn may_touch(&self, pair: Pair) -> bool {
        let (a, b) = (&self.reaches[pair.a as usize], &self.reaches[pair.b as usize]);
        if a.flags & b.flags & Reach::HOME != 0 {
            return overlap(a, b, Vec3::ZERO);
        }
        let middle = |reach: &Reach| {
            let sector = self.motions[reach.body as usize].center.sector;
            Position { sector, offset: Vec3::ZERO }
        };
        overlap(a, b, middle(b).minus(middle(a)))
    }

    /// True when the shape's body is dynamic.
    pub fn is_dynamic(&self, shape: u32) -> bool {
        self.reaches[shape as usize].flags & Reach::DYNAMIC != 0
    }

    pub fn motion(&self, shape: u32) -> &Motion {
        &self.motions[self.reaches[shape as usize].body as usize]
    }

    /// The frame of a shape in world axes, from its body's center.
    pub fn frame(&self, shape: u32) -> Pose {
        frame_of(self.frames[shape as usize])
    }

    /// How B moves against A in `dt` seconds, in A's frame, metres.
    pub fn motion_between(&self, [a, b]: [u32; 2], dt: f32) -> Vec3 {
        let motion = (self.motion(b).linear - self.motion(a).linear) * dt;
        self.frame(a).rotation.unrotate(motion)
    }

    /// The shapes of a pair in the order in which they are collided: the richer one first, of equals the lower
    /// slot.
    pub fn in_order(&self, pair: Pair) -> [u32; 2] {
        let shape = |slot: u32| &self.shapes[slot as usize];
        if are_in_order(shape(pair.a), shape(pair.b)) { [pair.a, pair.b] } else { [pair.b, pair.a] }
    }
}

/// True when a pair is collided in the order of its slots: the other one would have to be turned round.
pub(crate) fn are_in_order(a: &ShapeRow, b: &ShapeRow) -> bool {
    a.kind >= b.kind
}

/// True when the boxes and the balls of two shapes overlap, the second moved by `shift`. All is compared: what
/// parts them cannot be foretold, and a wrong guess costs more than the rest.
#[inline(always)]
fn overlap(a: &Reach, b: &Reach, shift: Vec3) -> bool {
    let (away, reach) = (b.origin + shift - a.origin, a.radius + b.radius);
    a.min.cmple(b.max + shift).all() & (b.min + shift).cmple(a.max).all() & (away.dot(away) <= reach * reach)
}

/// The pose of B's frame in A's, both given from the centers of their bodies, B's center at `centers` from A's.
#[inline(always)]
pub(crate) fn relative(frame_a: &Pose, frame_b: &Pose, centers: Vec3) -> Pose {
    Pose::new(
        frame_a.untransform(frame_b.position + centers),
        frame_a.rotation.inverse().after(frame_b.rotation).flushed(),
    )
}

/// A shape, its frame from its body's center, and its body.
pub(crate) type Side<'a> = (&'a ShapeRow, &'a Pose, &'a Motion);

/// From the center of body A to that of body B, metres.
///
/// A half-space is the same everywhere along its surface. So far from its body's center, where the way along it
/// would be rounded by more than a contact bears, it is met as if that center were right under the other body.
#[inline(always)]
pub(crate) fn centers_between(a: Side<'_>, b: Side<'_>) -> Vec3 {
    let centers = b.2.center.minus(a.2.center);
    if centers.dot(centers) <= PLANE_REACH * PLANE_REACH {
        return centers;
    }
    if is_plane(a) {
        above(a, b.2)
    } else if is_plane(b) {
        -above(b, a.2)
    } else {
        centers
    }
}

/// True for a half-space that does not turn: on one that turns it matters where a body is.
fn is_plane((shape, _, motion): Side<'_>) -> bool {
    shape.kind == GEOMETRY_HALF_SPACE && motion.angular == Vec3::ZERO
}

/// From the center of a half-space's body, moved along the surface to under a body, to that body's center.
#[inline(never)]
fn above((_, frame, plane): Side<'_>, body: &Motion) -> Vec3 {
    let normal = frame.rotation.rotate(Vec3::Z);
    let [n, p] = [normal, frame.position].map(|v| v.to_array().map(f64::from));
    let way = body.center.minus_wide(plane.center).to_array();
    let height = (way[0] - p[0]) * n[0] + (way[1] - p[1]) * n[1] + (way[2] - p[2]) * n[2];
    frame.position + normal * height as f32
}

/// The relative pose of two shapes, and how far apart points are looked for.
pub(crate) struct Meeting {
    /// Pose of B's frame in A's.
    pub b_in_a: Pose,
    /// From the center of body A to that of body B.
    pub centers: Vec3,
    /// How far one center moves against the other in this step, metres.
    pub way: f32,
    /// Squares of the angles by which the bodies turn in this step, added.
    pub turns: f32,
}

impl Meeting {
    pub fn new(scene: &Scene<'_>, [a, b]: [u32; 2], dt: f32) -> Self {
        let (ma, mb) = (scene.motion(a), scene.motion(b));
        let (frame_a, frame_b) = (frame_of(scene.frames[a as usize]), frame_of(scene.frames[b as usize]));
        let [sa, sb] = [a, b].map(|slot| &scene.shapes[slot as usize]);
        let centers = centers_between((sa, &frame_a, ma), (sb, &frame_b, mb));
        let b_in_a = relative(&frame_a, &frame_b, centers);
        let turns = (ma.angular.dot(ma.angular) + mb.angular.dot(mb.angular)) * (dt * dt);
        Self { b_in_a, centers, way: length(mb.linear - ma.linear) * dt, turns }
    }

    /// True when points can be kept: the bodies hardly move in this step, as seen at the smaller one. `drift` is
    /// that of the settings.
    pub fn is_slow(&self, (a, b): (Radius, Radius), drift: f32) -> bool {
        let squared = crate::math::min(a.squared, b.squared);
        let most = drift * SLOW_SHARE;
        drift > 0.0 && self.way <= most && self.turns * squared <= most * most
    }

    /// Points at the poses now. Bodies are stopped at the surface, not behind it: look as far as they come.
    pub fn collide(&self, solids: (&Solid<'_>, &Solid<'_>), found: &mut Manifolds) {
        let pose = Pose::new(self.b_in_a.position, self.b_in_a.rotation.renormalized());
        collide::collide(solids.0, solids.1, &pose, SPECULATIVE_DISTANCE + self.way, found);
    }

    /// True when the pose is still within the drift of a settled contact with this base.
    pub fn is_near(&self, base: &Pose, (a, b): (Radius, Radius), drift: f32) -> bool {
        let turn = self.b_in_a.rotation.after(base.rotation.inverse()).flushed();
        // The motion of the smaller shape's middle in the frame of the larger one.
        let (radius, way) = if b.squared <= a.squared {
            (b.squared, self.b_in_a.position - base.position)
        } else {
            let now = self.b_in_a.rotation.unrotate(self.b_in_a.position);
            (a.squared, now - base.rotation.unrotate(base.position))
        };
        let i = turn.imaginary();
        let most = crate::math::min(drift * drift, DRIFT_SHARE * DRIFT_SHARE * radius);
        // The angle is twice the imaginary part for a small turn; the real part is -1 as well as 1.
        way.dot(way) <= most && 4.0 * i.dot(i) * radius <= most
    }
}

/// Points of a settled contact: those found at its base, a little farther apart than they may come to touch. They
/// depend on no setting, so that they are found again whatever was set meanwhile.
pub(crate) fn collide_at(base: &Pose, solids: (&Solid<'_>, &Solid<'_>), found: &mut Manifolds) {
    collide::collide(solids.0, solids.1, base, SPECULATIVE_DISTANCE + MANIFOLD_DRIFT, found);
}

/// How far a polytope reaches from the origin of its frame.
#[derive(Clone, Copy)]
pub(crate) struct Radius {
    /// m2.
    pub squared: f32,
}

/// The radii of a pair whose contact may settle: both are polytopes. Round shapes roll, and are quickly collided.
pub(crate) fn settling_radii(
    (a, b): (&ShapeRow, &ShapeRow),
    assets: &AssetTables<'_>,
) -> Option<(Radius, Radius)> {
    Some((radius(a, assets)?, radius(b, assets)?))
}

fn radius(shape: &ShapeRow, assets: &AssetTables<'_>) -> Option<Radius> {
    match shape.kind {
        GEOMETRY_BOX => {
            let half = Vec3::from_array(shape.size);
            Some(Radius { squared: half.dot(half) })
        }
        GEOMETRY_HULL => Some(Radius { squared: assets.hulls[shape.asset() as usize].radius_squared }),
        _ => None,
    }
}

/// How far from the origin of its frame a shape's contacts may be in the coming step: two shapes whose balls of
/// this radius are apart have none, fast as they may be.
pub(crate) fn reach_radius(shape: &ShapeRow, (motion, assets, dt): (&Motion, &AssetTables<'_>, f32)) -> f32 {
    let own = match shape.kind {
        GEOMETRY_SPHERE => shape.size[0],
        GEOMETRY_CAPSULE => shape.size[0] + shape.size[1],
        _ => radius(shape, assets).map_or(f32::INFINITY, |radius| sqrt(radius.squared)),
    };
    // A hundred-thousandth more: what is rounded away.
    (own + 0.5 * SPECULATIVE_DISTANCE + length(motion.linear) * dt) * 1.000_01
}

/// The memo of a manifold in the frames of A and B; `exchanged` when the order of the solver is the other.
pub(crate) fn memo(manifold: &Manifold, b_in_a: &Pose, exchanged: bool, settled: bool) -> Memo {
    let mut memo = Memo::zeroed();
    let n = manifold.normal;
    memo.normal = if exchanged { -b_in_a.rotation.unrotate(n) } else { n };
    for (i, point) in manifold.points.iter().enumerate() {
        let half = n * (0.5 * point.separation);
        let on_a = point.position - half;
        let on_b = b_in_a.untransform(point.position + half);
        (memo.on_a[i], memo.on_b[i]) = if exchanged { (on_b, on_a) } else { (on_a, on_b) };
        memo.tail[i] = if settled { point.feature } else { point.separation.to_bits() };
    }
    memo
}

/// The memo of a settled contact, found again at its base. `None` when it has other points than the contact: no
/// step made such a state.
pub(crate) fn memo_again(
    row: &ContactRow,
    shapes: (&ShapeRow, &ShapeRow),
    exchanged: bool,
    assets: &AssetTables<'_>,
) -> Option<Memo> {
    let base = unpack(&row.memory)?;
    let mut found = Manifolds::new();
    collide_at(&base, (&solid(shapes.0, assets), &solid(shapes.1, assets)), &mut found);
    let manifold = found.first()?;
    (manifold.points.len() == row.tag.points()).then(|| memo(manifold, &base, exchanged, true))
}

/// A pose in 20 bytes.
pub(crate) fn pack(pose: &Pose) -> [u32; 5] {
    let (p, [low, high]) = (pose.position, pose.rotation.pack());
    [p.x.to_bits(), p.y.to_bits(), p.z.to_bits(), low, high]
}

/// The pose that [`pack`] wrote; `None` for bits that it does not write.
pub(crate) fn unpack(memory: &[u32; 5]) -> Option<Pose> {
    let [x, y, z, low, high] = *memory;
    let position = Vec3::new(f32::from_bits(x), f32::from_bits(y), f32::from_bits(z));
    let rotation = Rotation::unpack([low, high])?;
    position.is_finite().then_some(Pose::new(position, rotation))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_packed_pose_comes_back() {
        let axes = [Vec3::X, Vec3::Y, Vec3::Z, Vec3::ONE / length(Vec3::ONE), Vec3::new(0.6, 0.0, -0.8)];
        for axis in axes {
            for k in -40..=40 {
                let rotation = Rotation::from_axis_angle(axis, 0.1 * k as f32);
                let pose = Pose::new(Vec3::new(1.5, -2.25e3, 1.0e-7), rotation);
                let again = unpack(&pack(&pose)).expect("packed");
                assert_eq!(again.position, pose.position);
                let turn = again.rotation.after(rotation.inverse()).imaginary();
                assert!(2.0 * length(turn) < 5.0e-6, "{axis} {k}: {turn}");
            }
        }
        assert_eq!(unpack(&pack(&Pose::IDENTITY)), Some(Pose::IDENTITY));
    }

    #[test]
    fn bits_that_are_no_pose_are_refused() {
        assert_eq!(unpack(&[f32::NAN.to_bits(), 0, 0, 0, 0]), None);
        assert_eq!(unpack(&[f32::INFINITY.to_bits(), 0, 0, 0, 3 << 28]), None);
        assert_eq!(unpack(&[0, 0, 0, 0, 1 << 31]), None);
    }
}
