//! One row of contacts, assembled side by side, each in the lane in which it is solved.
//!
//! The scalars of each contact and its bodies lie in runs of eight words; transposed, a word of all contacts is a
//! [`Lane`]. An empty lane reads zeros, and every divisor is guarded, so its row is zero.

mod acting;
mod cones;

use crate::cells::IMMOVABLE;
use crate::constraint::contact::press_mass;
use crate::constraint::row::{ConeRow, LinkRow, PointRow, ResistRow};
use crate::constraint::velocities::{free_axes, root_times};
use crate::lanes::{LANES, Lane, LaneVec, Mask, Words, each_lane, transpose};
use crate::math::{Vec3, max};
use crate::pipeline::assembly::Scene;
use crate::pipeline::integration::chord;
use crate::pipeline::layout::EMPTY;
use crate::pipeline::solver::take;
use crate::state::{Active, ContactRow, Memo, Touch};
use acting::Acts;
pub(crate) use acting::resistance;
use bytemuck::{Pod, Zeroable, cast_ref};

/// Sliding, squared, from which on the first tangent lies along it, m2/s2.
const SLIDING_MIN: f32 = 1.0e-4;
/// Slides below a ten-thousandth of the arm change nothing that f32 can show.
const SLIDE_SHARE: f32 = 1.0e-6;

/// Writes one row and cuts its points off `points`. What is read only where something bounces, a surface moves or
/// there are several points is written only there.
pub(crate) fn fill(
    scene: &Scene<'_>,
    (row, resist, cones): (&mut LinkRow, Option<&mut ResistRow>, Option<&mut ConeRow>),
    (contacts, seats): (&[u32; LANES], &[u32; 2 * LANES]),
    points: &mut &mut [PointRow],
) {
    row.seats_a.copy_from_slice(&seats[..LANES]);
    row.seats_b.copy_from_slice(&seats[LANES..]);
    let count =
        |contact: u32| if contact == EMPTY { 0 } else { scene.contacts[contact as usize].tag.points() };
    let counts = contacts.map(count);
    let most = counts.iter().copied().max().unwrap_or(0);
    row.points = most as u32;
    row.uneven = u32::from(counts.iter().any(|&count| count != 0 && count != most));
    let own = take(points, most);
    let sides = Sides::gather(scene, contacts);
    row.bounces = u32::from(sides.touch[3].greater(Lane::ZERO).any());
    row.locked = u32::from(sides.are_locked());
    row.surfaces = u32::from(sides.moving() != 0);
    row.resists = 0;
    row.turns = 0;
    row.hits = u32::from(scene.hits);
    row.slide = LaneVec::ZERO;
    fill_points(scene, &sides, (row, cones), own);
    if let (Some(acts), Some(resist)) = (&sides.acts, resist) {
        row.resists = u32::from(acts.resists != 0);
        acts.write_resistance(&sides, row, resist);
    }
}

fn fill_points(
    scene: &Scene<'_>,
    sides: &Sides,
    (link, cones): (&mut LinkRow, Option<&mut ConeRow>),
    points: &mut [PointRow],
) {
    let found = sides.place(scene, link);
    let mut patch = Patch { points: points.len(), ..Patch::zeroed() };
    let mut soft = Lane::ZERO;
    for (i, point) in points.iter_mut().enumerate() {
        if link.bounces | link.surfaces != 0 {
            (point.bounce, point.surface) = (Lane::ZERO, Lane::ZERO);
        }
        let (arm_a, arm_b) = sides.write_point(&found, point, i);
        patch.places[i] = arm_a;
        patch.sum = patch.sum + arm_a;
        patch.sum_b = patch.sum_b + arm_b;
        point.aim(link, scene.bias);
        patch.normal_a = patch.normal_a + point.normal_a;
        patch.normal_b = patch.normal_b + point.normal_b;
        soft = soft + point.soft;
    }
    let (ja, jb) = (patch.normal_a, patch.normal_b);
    link.inertia = link.count * link.count * found.yields + ja.dot(ja) + jb.dot(jb);
    link.press_mass = press_mass(link.count, link.inertia);
    link.soft_press_mass = press_mass(link.count, link.inertia + soft);
    sides.write_friction(&found, link, &patch);
    if let Some(cones) = cones.filter(|_| points.len() > 1) {
        sides.write_cones(&found, (link, cones), (points, &patch));
    }
    if scene.hits {
        sides.measure_approach(&found, link, &patch);
    }
    if link.bounces != 0 {
        sides.write_push(scene, link);
    }
    if sides.moving() != 0 {
        sides.write_surfaces(scene, link, (points, &patch));
    }
}

/// What the rows of a body hold, lane by lane.
struct Body {
    linear: LaneVec,
    angular: LaneVec,
    /// Inverse masses along the axes: equal unless an axis is locked.
    mass: LaneVec,
    locks: Lane,
    root: [LaneVec; 2],
}

impl Body {
    fn of(bodies: [&Active; LANES]) -> Self {
        let u = transpose(each_lane(|lane| words::<_, 3>(bodies[lane])[0]));
        let r = transpose(each_lane(|lane| words::<_, 3>(bodies[lane])[1]));
        Self {
            linear: LaneVec::new(u[0], u[1], u[2]),
            angular: LaneVec::new(u[4], u[5], u[6]),
            mass: LaneVec::new(u[3], u[3], u[3]),
            locks: u[7],
            root: [LaneVec::new(r[0], r[1], r[2]), LaneVec::new(r[3], r[4], r[5])],
        }
    }

    fn jacobian(&self, arm: LaneVec, direction: LaneVec) -> LaneVec {
        root_times(&self.root, arm.cross(direction))
    }
}

/// Everything that is read of the contacts of a part.
struct Sides {
    contacts: [u32; LANES],
    /// Points of each.
    counts: [u8; LANES],
    a: Body,
    b: Body,
    /// Frames of the shapes: position from the center of the body, and rotation.
    frame_a: Frame,
    frame_b: Frame,
    /// The same in the bodies' stances, when a contact is settled.
    stances: Option<[Frame; 2]>,
    /// Words of the memos.
    memo: [Lane; 32],
    /// Words of the touches.
    touch: [Lane; 8],
    /// Stored impulses: four points, friction, twist.
    stored: [Lane; 8],
    /// 1 or -1; see `Touch::sign`.
    sign: Lane,
    /// Bit for each lane whose immovable body moves.
    surfaces: u32,
    /// Where a surface moves or resists by its material.
    acts: Option<Acts>,
    /// True when a contact is a fast one.
    hurries: bool,
}

/// A frame in every lane.
pub(crate) struct Frame {
    pub position: LaneVec,
    /// Columns of the rotation.
    axes: [LaneVec; 3],
}

impl Frame {
    /// From `[position, 0, rotation]` of each lane.
    pub fn of(frames: [Words; LANES]) -> Self {
        let [px, py, pz, _, x, y, z, w] = transpose(frames);
        let (one, two) = (Lane::splat(1.0), Lane::splat(2.0));
        let (x2, y2, z2) = (two * x, two * y, two * z);
        let (xx, yy, zz) = (x * x2, y * y2, z * z2);
        let (xy, xz, yz) = (x * y2, x * z2, y * z2);
        let (wx, wy, wz) = (w * x2, w * y2, w * z2);
        Self {
            position: LaneVec::new(px, py, pz),
            axes: [
                LaneVec::new(one - (yy + zz), xy + wz, xz - wy),
                LaneVec::new(xy - wz, one - (xx + zz), yz + wx),
                LaneVec::new(xz + wy, yz - wx, one - (xx + yy)),
            ],
        }
    }

    #[inline(always)]
    pub fn rotate(&self, v: LaneVec) -> LaneVec {
        self.axes[0].times(v.x) + self.axes[1].times(v.y) + self.axes[2].times(v.z)
    }
}

/// What all points of the row need.
struct Placed {
    normal: LaneVec,
    /// Inverse masses of both bodies along the axes.
    free: LaneVec,
    /// From the center of A to that of B.
    centers: LaneVec,
    /// What an impulse of 1 along the normal changes of the speed between the centers, 1/kg.
    yields: Lane,
    count: Lane,
    /// Whether the separations follow from the points.
    settled: Mask,
    /// The same, or whether the point of contact is A's; when it is for some lane.
    fast: Option<Mask>,
    /// What a spring gives, as a share of what the bodies give.
    give: Lane,
}

/// Arms of the points from the center of A.
#[derive(Clone, Copy, Zeroable)]
#[repr(C)]
struct Patch {
    sum: LaneVec,
    /// The same from the center of B.
    sum_b: LaneVec,
    /// Sums of the normals' jacobians.
    normal_a: LaneVec,
    normal_b: LaneVec,
    places: [LaneVec; 4],
    /// Most points of a lane of the row.
    points: usize,
}

impl Sides {
    fn gather(scene: &Scene<'_>, contacts: &[u32; LANES]) -> Self {
        let none = Active::zeroed();
        let mut a = [&none; LANES];
        let mut b = [&none; LANES];
        let mut moving = [Active::zeroed(); LANES];
        let (mut frames_a, mut frames_b) = ([Words::ZERO; LANES], [Words::ZERO; LANES]);
        let (mut stances_a, mut stances_b) = ([Words::ZERO; LANES], [Words::ZERO; LANES]);
        let no_memo = Memo::zeroed();
        let mut memos = [&no_memo; LANES];
        let (mut touches, mut stored) = ([Words::ZERO; LANES], [Words::ZERO; LANES]);
        let mut sign = Lane::ZERO;
        let mut counts = [0; LANES];
        let (mut surfaces, mut settles, mut hurries, mut acts) = (0, false, false, false);
        for (lane, &contact) in contacts.iter().enumerate() {
            if contact == EMPTY {
                continue;
            }
            let contact = contact as usize;
            let (touch, link, row) =
                (&scene.touches[contact], &scene.links[contact], &scene.contacts[contact]);
            a[lane] = &scene.active[link.a as usize];
            if link.b != IMMOVABLE {
                b[lane] = &scene.active[link.b as usize];
            } else if let Some(row) = moving_immovable(scene, touch.shapes[1]) {
                moving[lane] = row;
                surfaces |= 1 << lane;
            }
            frames_a[lane] = scene.frames[touch.shapes[0] as usize];
            frames_b[lane] = scene.frames[touch.shapes[1] as usize];
            memos[lane] = &scene.memos[contact];
            touches[lane] = words::<_, 1>(touch)[0];
            stored[lane] = words::<_, 2>(row)[1];
            stances_a[lane] = frames_a[lane];
            stances_b[lane] = frames_b[lane];
            if touch.settled == Touch::SETTLED {
                settles = true;
                stances_a[lane] = scene.stances[touch.shapes[0] as usize];
                stances_b[lane] = scene.stances[touch.shapes[1] as usize];
            } else if !touch.is_plain() {
                hurries |= touch.is_fast();
                if touch.settled < 0.0 {
                    acts = true;
                    stored[lane] = without_resistance(row);
                }
            }
            sign.set(lane, touch.sign());
            counts[lane] = row.tag.points() as u8;
        }
        for (lane, row) in moving.iter().enumerate() {
            if surfaces >> lane & 1 != 0 {
                b[lane] = row;
            }
        }
        Self {
            contacts: *contacts,
            counts,
            a: Body::of(a),
            b: Body::of(b),
            frame_a: Frame::of(frames_a),
            frame_b: Frame::of(frames_b),
            stances: settles.then(|| [Frame::of(stances_a), Frame::of(stances_b)]),
            memo: words_of(memos, counts.iter().any(|&count| count > 1)),
            touch: transpose(touches),
            stored: transpose(stored),
            sign,
            surfaces,
            acts: acts.then(|| Acts::gather(scene, contacts)),
            hurries,
        }
    }

    /// Bit for each lane that has a surface that moves.
    fn moving(&self) -> u32 {
        self.surfaces | self.acts.as_ref().map_or(0, |acts| acts.belts)
    }

    fn memo_vector(&self, word: usize) -> LaneVec {
        LaneVec::new(self.memo[word], self.memo[word + 1], self.memo[word + 2])
    }

    /// Writes what does not depend on the points.
    fn place(&self, scene: &Scene<'_>, row: &mut LinkRow) -> Placed {
        let zero = Lane::ZERO;
        let [_, _, friction, restitution, x, y, z, settled] = self.touch;
        let frame = self.stances.as_ref().map_or(&self.frame_a, |[a, _]| a);
        let normal = frame.rotate(self.memo_vector(0));
        row.normal = normal;
        row.root_b = self.b.root;
        row.friction = friction;
        row.restitution = restitution;
        row.count = Lane::new(self.counts.map(f32::from));
        let live = row.count.greater(zero);
        let dynamic = self.b.mass.x.greater(zero);
        let soft = |of: fn(&crate::pipeline::assembly::Softness) -> f32| {
            let pick = dynamic
                .select(Lane::splat(of(&scene.softness.dynamic)), Lane::splat(of(&scene.softness.immovable)));
            live.select(pick, zero)
        };
        row.bias_rate = soft(|s| s.bias_rate);
        row.mass_scale = soft(|s| s.mass_scale);
        let free = self.free_masses();
        Placed {
            free,
            normal,
            centers: LaneVec::new(x, y, z),
            yields: normal.dot(normal.each_times(free)),
            count: row.count,
            settled: settled.greater(Lane::splat(Touch::FAST)),
            fast: self.hurries.then(|| {
                let acts = settled.less(zero);
                acts.select(settled - Lane::splat(Touch::ACTS), settled).greater(zero)
            }),
            give: soft(|s| s.give),
        }
    }

    fn are_locked(&self) -> bool {
        self.a.locks.greater(Lane::ZERO).any() || self.b.locks.greater(Lane::ZERO).any()
    }

    /// Inverse masses of both bodies along the axes.
    fn free_masses(&self) -> LaneVec {
        if !self.are_locked() {
            return self.a.mass + self.b.mass;
        }
        let free = |body: &Body| free_axes(body.locks).each_times(body.mass);
        free(&self.a) + free(&self.b)
    }

    /// Writes point `i`; returns its arms, 0 where there is none.
    fn write_point(&self, found: &Placed, point: &mut PointRow, i: usize) -> (LaneVec, LaneVec) {
        let n = found.normal;
        let live = found.count.greater(Lane::splat(i as f32));
        let (a, b) = (self.memo_vector(4 + 3 * i), self.memo_vector(16 + 3 * i));
        let on_a = self.frame_a.rotate(a) + self.frame_a.position;
        let on_b = self.frame_b.rotate(b) + self.frame_b.position + found.centers;
        let mut place = (on_a + on_b).times(Lane::splat(0.5));
        if let Some(fast) = found.fast {
            // Far ahead: friction will act where A's surface is, and B's arm follows the slide.
            place = fast.select_vec(on_a, place);
        }
        let mut arm_b = place - found.centers;
        if let Some([stance_a, stance_b]) = &self.stances {
            place = found.settled.select_vec(stance_a.rotate(a) + stance_a.position, place);
            arm_b = found.settled.select_vec(stance_b.rotate(b) + stance_b.position, arm_b);
        }
        let (place, arm_b) = (live.keep_vec(place), live.keep_vec(arm_b));
        let ja = live.keep_vec(self.a.jacobian(place, n));
        let jb = live.keep_vec(self.b.jacobian(arm_b, n));
        let yields = found.yields + ja.dot(ja) + jb.dot(jb);
        point.normal_a = ja;
        point.normal_b = jb;
        point.mass = live.select(inverse(yields), Lane::ZERO);
        let gives = point.mass.greater(Lane::ZERO);
        point.spring = gives.keep(found.give * yields);
        let apart = found.settled.select(n.dot(on_b - on_a), self.memo[28 + i]);
        point.separation = live.select(apart, Lane::ZERO);
        point.impulse = self.stored[i];
        (place, arm_b)
    }

    /// How fast the points approach, as far as a hit is looked for.
    #[inline(never)]
    fn measure_approach(&self, found: &Placed, row: &mut LinkRow, patch: &Patch) {
        (row.approach, row.total) = (Lane::ZERO, Lane::ZERO);
        for (i, &arm_a) in patch.places[..patch.points].iter().enumerate() {
            let at_a = self.a.linear + self.a.angular.cross(arm_a);
            let at_b = self.b.linear + self.b.angular.cross(arm_a - found.centers);
            let live = found.count.greater(Lane::splat(i as f32));
            row.approach = live.keep(found.normal.dot(at_a - at_b)).greatest(row.approach);
        }
    }

    /// One patch for the manifold: two tangents and the twist at the points' middle.
    fn write_friction(&self, found: &Placed, row: &mut LinkRow, patch: &Patch) {
        let one = Lane::splat(1.0);
        let live = found.count.greater(Lane::ZERO);
        let share = one / live.select(found.count, one);
        let middle = patch.sum.times(share);
        let (arm_a, arm_b) = (middle, patch.sum_b.times(share));
        let n = found.normal;
        let t = live.keep_vec(self.tangent(n, (arm_a, arm_b)));
        let s = n.cross(t);
        row.tangent = t;
        row.first_a = self.a.jacobian(arm_a, t);
        row.first_b = self.b.jacobian(arm_b, t);
        row.second_a = self.a.jacobian(arm_a, s);
        row.second_b = self.b.jacobian(arm_b, s);
        // Greatest eigenvalue of the tangents' 2x2 block: a step of its inverse cannot overshoot, whatever the
        // block's shape, where inverting the block and clamping to the disc stalls.
        let free = found.free;
        let p = t.dot(t.each_times(free)) + row.first_a.dot(row.first_a) + row.first_b.dot(row.first_b);
        let q = s.dot(s.each_times(free)) + row.second_a.dot(row.second_a) + row.second_b.dot(row.second_b);
        let r = t.dot(s.each_times(free)) + row.first_a.dot(row.second_a) + row.first_b.dot(row.second_b);
        let half = Lane::splat(0.5) * (p - q);
        row.friction_mass = inverse(Lane::splat(0.5) * (p + q) + (half * half + r * r).sqrt());
        // One point has no lever, and no twist.
        row.twist_impulse = Lane::ZERO;
        if patch.points > 1 {
            self.write_twist(found, row, (patch, share));
        }
        let [_, _, _, _, x, y, z, _] = self.stored;
        let stored = LaneVec::new(x, y, z).times(self.sign);
        row.first_impulse = stored.dot(t);
        row.second_impulse = stored.dot(s);
        let reach = arm_b.dot(arm_b).greatest(arm_a.dot(arm_a));
        let slide_min = (reach * Lane::splat(SLIDE_SHARE)).greatest(Lane::splat(f32::MIN_POSITIVE));
        // The arms of a settled contact stay.
        row.slide_min = found.settled.select(Lane::splat(f32::MAX), slide_min);
    }

    fn write_twist(&self, found: &Placed, row: &mut LinkRow, (patch, share): (&Patch, Lane)) {
        let middle = patch.sum.times(share);
        let mut spread = Lane::ZERO;
        for (i, &place) in patch.places[..patch.points].iter().enumerate() {
            let off = place - middle;
            spread = spread + found.count.greater(Lane::splat(i as f32)).keep(off.dot(off).sqrt());
        }
        row.radius = spread * share;
        row.twist_a = root_times(&self.a.root, found.normal);
        row.twist_b = root_times(&self.b.root, found.normal);
        row.twist_mass = inverse(row.twist_a.dot(row.twist_a) + row.twist_b.dot(row.twist_b));
        // What a lane does with one point may not depend on the points of its neighbours.
        let several = found.count.greater(Lane::splat(1.5));
        row.twist_impulse = several.keep(self.stored[7]);
    }

    /// The first tangent lies along the sliding velocity, so that isotropy does not depend on the axes; at rest
    /// anywhere.
    fn tangent(&self, n: LaneVec, (arm_a, arm_b): (LaneVec, LaneVec)) -> LaneVec {
        let (zero, one) = (Lane::ZERO, Lane::splat(1.0));
        let at_a = self.a.linear + self.a.angular.cross(arm_a);
        let at_b = self.b.linear + self.b.angular.cross(arm_b);
        let mut sliding = at_b - at_a;
        if let Some(acts) = &self.acts {
            sliding = acts.slide(sliding);
        }
        let flat = sliding - n.times(n.dot(sliding));
        let square = flat.dot(flat);
        let slides = square.greater(Lane::splat(SLIDING_MIN)).and(square.less(Lane::splat(1.0e38)));
        // One component of a unit vector is at most the root of a third: across that axis.
        let low = (n.x * n.x).less(Lane::splat(1.0 / 3.0));
        let across = LaneVec::new(low.select(zero, n.y), low.select(n.z, -n.x), low.select(-n.y, zero));
        let v = LaneVec::new(
            slides.select(flat.x, across.x),
            slides.select(flat.y, across.y),
            slides.select(flat.z, across.z),
        );
        let length = v.dot(v).sqrt();
        v.times(one / length.greater(zero).select(length, one))
    }

    /// Relative velocity along the normal that gravity and forces give in a substep.
    fn write_push(&self, scene: &Scene<'_>, row: &mut LinkRow) {
        let n = row.normal;
        row.push = Lane::ZERO;
        for (lane, &contact) in self.contacts.iter().enumerate() {
            if contact != EMPTY {
                let link = &scene.links[contact as usize];
                let of = |body: u32| scene.active.get(body as usize).map_or(Vec3::ZERO, |body| body.push);
                let b = if link.b == IMMOVABLE { Vec3::ZERO } else { of(link.b) };
                row.push.set(lane, n.get(lane).dot(b - of(link.a)));
            }
        }
    }

    /// Velocities of the surfaces of immovable bodies that move, where those of dynamic ones are in their seats;
    /// and of surfaces that move on their bodies, as far as they lie across the normal.
    fn write_surfaces(
        &self,
        scene: &Scene<'_>,
        row: &mut LinkRow,
        (points, patch): (&mut [PointRow], &Patch),
    ) {
        row.surface = LaneVec::ZERO;
        for (lane, &contact) in self.contacts.iter().enumerate() {
            let (n, t) = (row.normal.get(lane), row.tangent.get(lane));
            let belt = self.acts.as_ref().map_or(Vec3::ZERO, |acts| acts.velocity.get(lane));
            if self.surfaces >> lane & 1 == 0 {
                row.surface.set(lane, Vec3::new(t.dot(belt), n.cross(t).dot(belt), 0.0));
                continue;
            }
            let surface = Surface::new(scene, contact as usize);
            let count = usize::from(self.counts[lane]);
            for (point, place) in points.iter_mut().zip(&patch.places).take(count) {
                point.surface.set(lane, n.dot(surface.velocity(place.get(lane))));
            }
            let middle = patch.sum.get(lane) / max(count as f32, 1.0);
            let velocity = surface.velocity(middle) + belt;
            let spin = n.dot(surface.angular);
            row.surface.set(lane, Vec3::new(t.dot(velocity), n.cross(t).dot(velocity), spin));
        }
    }
}

/// A row as runs of eight words.
#[inline(always)]
fn words<T: Pod, const N: usize>(row: &T) -> &[Words; N] {
    cast_ref(row)
}

/// The words of memos, of one point each or of several.
#[inline(always)]
fn words_of(memos: [&Memo; LANES], several: bool) -> [Lane; 32] {
    let mut found = [Lane::ZERO; 32];
    // The second run of words has the points on A after the first: 1 to 3.
    for (k, own) in found.chunks_exact_mut(8).enumerate().filter(|&(k, _)| several || k != 1) {
        own.copy_from_slice(&transpose(each_lane(|lane| words::<_, 4>(memos[lane])[k])));
    }
    found
}

/// The stored impulses of a contact, as a run of words, without those of its resistance.
fn without_resistance(row: &ContactRow) -> Words {
    let mut row = *row;
    if row.can_resist() {
        row.set_resistance(Vec3::ZERO);
    }
    words::<_, 2>(&row)[1]
}

/// The velocities of an immovable body that moves, as a row; `None` for one that stands still.
fn moving_immovable(scene: &Scene<'_>, shape: u32) -> Option<Active> {
    let motion = &scene.motions[scene.shapes[shape as usize].body as usize];
    let moves = motion.linear != Vec3::ZERO || motion.angular != Vec3::ZERO;
    moves.then(|| Active { linear: motion.linear, angular: motion.angular, ..Active::zeroed() })
}

/// How the surface of a kinematic body moves under a dynamic one.
struct Surface {
    linear: Vec3,
    angular: Vec3,
    /// From the center of the dynamic body to that of the kinematic one.
    centers: Vec3,
    dt: f32,
    /// What the dynamic body's center does in half a step beyond being carried along.
    way: Vec3,
}

impl Surface {
    fn new(scene: &Scene<'_>, contact: usize) -> Self {
        let touch = &scene.touches[contact];
        let motion = &scene.motions[scene.shapes[touch.shapes[1] as usize].body as usize];
        let other = &scene.motions[scene.shapes[touch.shapes[0] as usize].body as usize];
        let (linear, angular) = (motion.linear, motion.angular);
        let carried = linear + angular.cross(-touch.centers);
        let way = (other.linear - carried) * (0.5 * scene.dt);
        Self { linear, angular, centers: touch.centers, dt: scene.dt, way }
    }

    /// Velocity of the surface at a place from the center of the dynamic body, as a mean of the step. What that
    /// center does beyond being carried along takes the point to other places of the surface: without that a ball
    /// that rolls on a turntable spirals outwards.
    fn velocity(&self, place: Vec3) -> Vec3 {
        if self.angular == Vec3::ZERO {
            return self.linear;
        }
        self.linear + chord(self.angular, place - self.centers, self.dt) + self.angular.cross(self.way)
    }
}

/// 1 / x, or 0 where nothing can move.
#[inline(always)]
fn inverse(x: Lane) -> Lane {
    let moves = x.greater(Lane::splat(f32::MIN_POSITIVE));
    let one = Lane::splat(1.0);
    moves.select(one / moves.select(x, one), Lane::ZERO)
}
