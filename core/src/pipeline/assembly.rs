//! Assembly (the talk's third stage, SEED S5 to S7): rows written straight into solver order.

use crate::body::{BodyRow, Motion};
use crate::cells::IMMOVABLE;
use crate::config::{CONTACT_COUPLING, ContactModel, RIGID_PUSH, STATIC_STIFFNESS, Settings};
use crate::constraint::row::{LinkRow, PointRow};
use crate::executor::{Executor, Stage};
use crate::lanes::LANES;
use crate::math::{PI, Vec3, any_perpendicular, length, max, normalize_or, sqrt};
use crate::pipeline::integration::{chord, locked_or_free_root, root_times};
use crate::pipeline::layout::{EMPTY, Group, Plan};
use crate::pipeline::mover::Mover;
use crate::pipeline::seat::Seat;
use crate::pipeline::solver::take;
use crate::pipeline::tasks::{Crew, Tasks, chunk, push};
use crate::state::{Active, Scratch, State, Touch, principal_rotation};
use bytemuck::Zeroable;

/// Bodies that are worth a task.
const PREPARE_BODIES: usize = 128;

/// What assembly reads of the step.
#[derive(Clone, Copy)]
struct Scene<'a> {
    bodies: &'a [BodyRow],
    motions: &'a [Motion],
    active_of: &'a [u32],
    active: &'a [Active],
    touches: &'a [Touch],
    contact_touch: &'a [u32],
    softness: &'a Softnesses,
    substep: f32,
    dt: f32,
}

/// Softness of contacts between dynamic bodies, and with immovable ones.
struct Softnesses {
    dynamic: Softness,
    immovable: Softness,
}

/// How a row gives: the implicit spring of natural frequency f and damping ratio z as shares of a substep.
#[derive(Clone, Copy)]
struct Softness {
    bias_rate: f32,
    mass_scale: f32,
    impulse_scale: f32,
    /// `impulse_scale / mass_scale`: what the spring gives, as a share of what the bodies give.
    give: f32,
}

impl Softness {
    /// A damped spring integrated implicitly over a substep `h`: with `w = 2 pi f`, `a = 2 z + h w`, `c = h w a`,
    /// the row takes back `w / a` of the overlap per second, acts on `c / (1 + c)` of the velocity error, and gives
    /// up `1 / (1 + c)` of its impulse.
    fn new(settings: &Settings, factor: f32) -> Self {
        let h = settings.substep();
        if settings.contact_model == ContactModel::Rigid {
            return Self { bias_rate: RIGID_PUSH / h, mass_scale: 1.0, impulse_scale: 0.0, give: 0.0 };
        }
        let frequency =
            if settings.contact_frequency > 0.0 { settings.contact_frequency } else { CONTACT_COUPLING / h };
        let w = 2.0 * PI * frequency * factor;
        let a = 2.0 * settings.contact_damping_ratio + h * w;
        let c = h * w * a;
        Self { bias_rate: w / a, mass_scale: c / (1.0 + c), impulse_scale: 1.0 / (1.0 + c), give: 1.0 / c }
    }
}

/// Derives what the solve needs of every active body.
pub(crate) fn prepare_bodies<E: Executor>(
    state: &State<'_>,
    scratch: &mut Scratch<'_>,
    (settings, bodies): (&Settings, usize),
    crew: &mut Crew<'_, E>,
) {
    let share = chunk(bodies, PREPARE_BODIES);
    let mut tasks: Tasks<&mut [Active]> = scratch.active[..bodies].chunks_mut(share).collect();
    let substep = settings.substep();
    let gravity = settings.gravity;
    crew.run(Stage::Assembly, &mut tasks, |active| {
        for active in active.iter_mut() {
            let slot = active.body as usize;
            let (row, motion) = (&state.bodies[slot], &state.motions[slot]);
            let locks = row.locks();
            let principal = principal_rotation(motion, row);
            active.root = locked_or_free_root(principal, row.inertia, locks >> 3);
            active.inverse_mass = 1.0 / row.mass;
            active.locks = u32::from(locks & 7);
            let push = (gravity * row.gravity_scale + row.force / row.mass) * substep;
            let free = |axis: usize| if locks >> axis & 1 == 1 { 0.0 } else { push[axis] };
            active.push = Vec3::new(free(0), free(1), free(2));
        }
    });
}

/// Writes all rows, movers and seats of a plan.
pub(crate) fn fill<E: Executor>(
    state: &State<'_>,
    scratch: &mut Scratch<'_>,
    (settings, plan): (&Settings, &Plan),
    crew: &mut Crew<'_, E>,
) {
    let softness = Softnesses {
        dynamic: Softness::new(settings, 1.0),
        immovable: Softness::new(settings, STATIC_STIFFNESS),
    };
    let scene = Scene {
        bodies: state.bodies,
        motions: state.motions,
        active_of: scratch.active_of,
        active: scratch.active,
        touches: scratch.touches,
        contact_touch: scratch.contact_touch,
        softness: &softness,
        substep: settings.substep(),
        dt: settings.dt,
    };
    let groups = &mut scratch.groups[..plan.groups];
    let share = chunk(groups.len(), 1);
    let mut links = &mut scratch.link_rows[..plan.rows];
    let mut points = &mut scratch.point_rows[..plan.points];
    let mut seats = &mut scratch.seats[..plan.seats];
    let mut movers = &mut scratch.movers[..plan.phases[0].seats as usize];
    let (seat_bodies, lanes) = (&*scratch.seat_bodies, (&*scratch.lane_contacts, &*scratch.lane_seats));
    let mut tasks: Tasks<Task<'_>> = Tasks::new();
    for groups in groups.chunks_mut(share) {
        let sum = |count: fn(&Group) -> u32| groups.iter().map(count).sum::<u32>() as usize;
        let movers_count = sum(|g| if g.phase == 0 { g.seats } else { 0 });
        let task = Task {
            links: take(&mut links, sum(|g| g.rows)),
            points: take(&mut points, sum(|g| g.points)),
            seats: take(&mut seats, sum(|g| g.seats)),
            movers: take(&mut movers, movers_count),
            groups,
        };
        push(&mut tasks, task);
    }
    crew.run(Stage::Assembly, &mut tasks, |task| task.fill(&scene, seat_bodies, lanes));
}

/// Groups in a row, of one or more phases, and what is theirs.
struct Task<'a> {
    groups: &'a mut [Group],
    links: &'a mut [LinkRow],
    points: &'a mut [PointRow],
    seats: &'a mut [Seat],
    movers: &'a mut [Mover],
}

impl Task<'_> {
    fn fill(
        &mut self,
        scene: &Scene<'_>,
        seat_bodies: &[u32],
        (lane_contacts, lane_seats): (&[[u32; LANES]], &[[u32; 2 * LANES]]),
    ) {
        let (mut links, mut points) = (&mut *self.links, &mut *self.points);
        let (mut seats, mut movers) = (&mut *self.seats, &mut *self.movers);
        for group in self.groups.iter_mut() {
            let own_seats = take(&mut seats, group.seats as usize);
            let bodies = &seat_bodies[group.first_seat as usize..][..own_seats.len()];
            let own_movers = take(&mut movers, if group.phase == 0 { own_seats.len() } else { 0 });
            fill_seats(scene, (own_seats, own_movers), bodies);
            let mut own_points = take(&mut points, group.points as usize);
            let first = group.first_row as usize;
            for (i, row) in take(&mut links, group.rows as usize).iter_mut().enumerate() {
                fill_row(scene, row, (&lane_contacts[first + i], &lane_seats[first + i]), &mut own_points);
                group.bounces |= row.bounces;
            }
        }
    }
}

/// Seats hold zeros until they pull; those of phase 0 start with the bodies' velocities.
fn fill_seats(scene: &Scene<'_>, (seats, movers): (&mut [Seat], &mut [Mover]), bodies: &[u32]) {
    seats.fill(Seat::zeroed());
    for ((mover, seat), &body) in movers.iter_mut().zip(seats).zip(bodies) {
        *mover = Mover::zeroed();
        if body != IMMOVABLE {
            let active = &scene.active[body as usize];
            let slot = active.body as usize;
            (*mover, *seat) = Mover::new(active, &scene.motions[slot], &scene.bodies[slot], scene.substep);
        }
    }
}

/// Writes one row and cuts its points off `points`.
fn fill_row(
    scene: &Scene<'_>,
    row: &mut LinkRow,
    (contacts, seats): (&[u32; LANES], &[u32; 2 * LANES]),
    points: &mut &mut [PointRow],
) {
    *row = LinkRow::zeroed();
    row.seats_a.copy_from_slice(&seats[..LANES]);
    row.seats_b.copy_from_slice(&seats[LANES..]);
    let touch_of = |contact: u32| &scene.touches[scene.contact_touch[contact as usize] as usize];
    let filled = || contacts.iter().copied().enumerate().filter(|&(_, contact)| contact != EMPTY);
    row.points = filled().map(|(_, contact)| touch_of(contact).row.points).max().unwrap_or(0);
    let own = take(points, row.points as usize);
    own.fill(PointRow::zeroed());
    for (lane, contact) in filled() {
        LinkSides::new(scene, touch_of(contact)).write(scene, row, own, lane);
    }
}

/// A contact with its sides in the solver's order: A is dynamic.
struct LinkSides<'a> {
    touch: &'a Touch,
    a: &'a Active,
    /// `None` for an immovable body.
    b: Option<&'a Active>,
    /// From A to B.
    normal: Vec3,
    /// The patch's first tangent.
    tangent: Vec3,
    /// From the center of A to the first origin of the anchors, and of B.
    shift_a: Vec3,
    shift_b: Vec3,
    /// -1 when the sides were exchanged.
    sign: f32,
    /// Slot of body B.
    slot_b: usize,
}

impl<'a> LinkSides<'a> {
    fn new(scene: &Scene<'a>, touch: &'a Touch) -> Self {
        let of = |slot: u32| {
            let index = scene.active_of[slot as usize];
            (index != IMMOVABLE).then(|| &scene.active[index as usize])
        };
        let [a, b] = touch.sides();
        let (sign, none) = (touch.sign(), Vec3::ZERO);
        let shifts = if sign > 0.0 { (none, -touch.centers) } else { (-touch.centers, none) };
        Self {
            touch,
            a: of(a).expect("body A of a link is dynamic"),
            b: of(b),
            normal: touch.normal * sign,
            tangent: patch_tangent(scene, touch),
            shift_a: shifts.0,
            shift_b: shifts.1,
            sign,
            slot_b: b as usize,
        }
    }

    /// Velocity of an immovable B's surface at an arm of B, as a mean of the step; 0 for a dynamic one, whose seat
    /// has it. What A's center does beyond being carried along takes the point to other places of the surface:
    /// without that a ball that rolls on a turntable spirals outwards.
    fn surface(&self, scene: &Scene<'_>, arm_b: Vec3) -> Vec3 {
        if self.b.is_some() {
            return Vec3::ZERO;
        }
        let Motion { linear, angular, .. } = scene.motions[self.slot_b];
        if angular == Vec3::ZERO {
            return linear;
        }
        let carried = linear + angular.cross(self.shift_b - self.shift_a);
        let way = (scene.motions[self.a.body as usize].linear - carried) * (0.5 * scene.dt);
        linear + chord(angular, arm_b, scene.dt) + angular.cross(way)
    }

    fn jacobian_a(&self, arm: Vec3, direction: Vec3) -> Vec3 {
        root_times(&self.a.root, arm.cross(direction))
    }

    fn jacobian_b(&self, arm: Vec3, direction: Vec3) -> Vec3 {
        self.b.map_or(Vec3::ZERO, |b| root_times(&b.root, arm.cross(direction)))
    }

    /// `d . M^-1 e` of the linear parts, locked axes left out.
    fn linear(&self, d: Vec3, e: Vec3) -> f32 {
        let one = |body: &Active| {
            let free = |axis: u32| {
                if body.locks >> axis & 1 == 1 { 0.0 } else { d[axis as usize] * e[axis as usize] }
            };
            body.inverse_mass * (free(0) + free(1) + free(2))
        };
        one(self.a) + self.b.map_or(0.0, one)
    }

    fn write(&self, scene: &Scene<'_>, row: &mut LinkRow, points: &mut [PointRow], lane: usize) {
        let touch = self.touch;
        let n = self.normal;
        row.normal.set(lane, n);
        row.tangent.set(lane, self.tangent);
        if let Some(b) = self.b {
            let r = &b.root;
            row.root_b[0].set(lane, Vec3::new(r[0], r[1], r[2]));
            row.root_b[1].set(lane, Vec3::new(r[3], r[4], r[5]));
        }
        let softness = if self.b.is_some() { &scene.softness.dynamic } else { &scene.softness.immovable };
        row.bias_rate.set(lane, softness.bias_rate);
        row.mass_scale.set(lane, softness.mass_scale);
        row.impulse_scale.set(lane, softness.impulse_scale);
        row.restitution.set(lane, touch.restitution);
        row.count.set(lane, touch.row.points as f32);
        row.bounces |= u32::from(touch.restitution > 0.0);
        row.locked |= u32::from(self.a.locks != 0 || self.b.is_some_and(|b| b.locks != 0));
        row.push.set(lane, n.dot(self.b.map_or(Vec3::ZERO, |b| b.push) - self.a.push));
        for (i, point) in points[..touch.row.points as usize].iter_mut().enumerate() {
            self.write_point(scene, point, (i, lane));
            point.soft.set(lane, softness.give * inverse(point.mass.get(lane)));
        }
        self.write_friction(scene, row, lane);
    }

    fn write_point(&self, scene: &Scene<'_>, point: &mut PointRow, (i, lane): (usize, usize)) {
        let (n, touch) = (self.normal, self.touch);
        let arm_a = touch.anchors[i] + self.shift_a;
        let arm_b = touch.anchors[i] + self.shift_b;
        let (ja, jb) = (self.jacobian_a(arm_a, n), self.jacobian_b(arm_b, n));
        point.normal_a.set(lane, ja);
        point.normal_b.set(lane, jb);
        point.mass.set(lane, inverse(self.linear(n, n) + ja.dot(ja) + jb.dot(jb)));
        point.separation.set(lane, touch.separations[i]);
        point.impulse.set(lane, touch.row.impulses[i]);
        point.surface.set(lane, n.dot(self.surface(scene, arm_b)));
    }

    /// One patch for the manifold: two tangents and the twist at the points' middle.
    fn write_friction(&self, scene: &Scene<'_>, row: &mut LinkRow, lane: usize) {
        let touch = self.touch;
        let anchors = &touch.anchors[..touch.row.points as usize];
        let count = anchors.len() as f32;
        let middle = anchors.iter().fold(Vec3::ZERO, |sum, &p| sum + p) / count;
        let spread = anchors.iter().fold(0.0, |sum, &p| sum + length(p - middle)) / count;
        let (arm_a, arm_b) = (middle + self.shift_a, middle + self.shift_b);
        let (n, t) = (self.normal, self.tangent);
        let s = n.cross(t);
        let (ta, tb) = (self.jacobian_a(arm_a, t), self.jacobian_b(arm_b, t));
        let (sa, sb) = (self.jacobian_a(arm_a, s), self.jacobian_b(arm_b, s));
        row.first_a.set(lane, ta);
        row.first_b.set(lane, tb);
        row.second_a.set(lane, sa);
        row.second_b.set(lane, sb);
        // Greatest eigenvalue of the tangents' 2x2 block: a step of its inverse cannot overshoot, whatever the
        // block's shape, where inverting the block and clamping to the disc stalls.
        let p = self.linear(t, t) + ta.dot(ta) + tb.dot(tb);
        let q = self.linear(s, s) + sa.dot(sa) + sb.dot(sb);
        let r = self.linear(t, s) + ta.dot(sa) + tb.dot(sb);
        let half = 0.5 * (p - q);
        row.friction_mass.set(lane, inverse(0.5 * (p + q) + sqrt(half * half + r * r)));
        let wa = root_times(&self.a.root, n);
        let wb = self.b.map_or(Vec3::ZERO, |b| root_times(&b.root, n));
        row.twist_a.set(lane, wa);
        row.twist_b.set(lane, wb);
        row.twist_mass.set(lane, inverse(wa.dot(wa) + wb.dot(wb)));
        row.friction.set(lane, touch.friction);
        row.radius.set(lane, spread);
        let stored = touch.row.friction * self.sign;
        row.first_impulse.set(lane, stored.dot(t));
        row.second_impulse.set(lane, stored.dot(s));
        row.twist_impulse.set(lane, touch.row.twist);
        // Slides below a ten-thousandth of the arm change nothing that f32 can show.
        let reach = max(arm_b.dot(arm_b), arm_a.dot(arm_a));
        row.slide_min.set(lane, max(reach * 1.0e-8, f32::MIN_POSITIVE));
        let velocity = self.surface(scene, arm_b);
        let spin = if self.b.is_some() { 0.0 } else { n.dot(scene.motions[self.slot_b].angular) };
        row.surface.set(lane, Vec3::new(t.dot(velocity), s.dot(velocity), spin));
    }
}

/// 1 / x, or 0 where nothing can move.
fn inverse(x: f32) -> f32 {
    if x > f32::MIN_POSITIVE { 1.0 / x } else { 0.0 }
}

/// The first tangent lies along the sliding velocity, so that isotropy does not depend on the axes; at rest along
/// the stored impulse, else anywhere.
fn patch_tangent(scene: &Scene<'_>, touch: &Touch) -> Vec3 {
    let n = touch.normal;
    let anchors = &touch.anchors[..touch.row.points as usize];
    let middle = anchors.iter().fold(Vec3::ZERO, |sum, &p| sum + p) / anchors.len() as f32;
    let at = |slot: u32, arm: Vec3| {
        let motion = &scene.motions[slot as usize];
        motion.linear + motion.angular.cross(arm)
    };
    let sliding = at(touch.bodies[1], middle - touch.centers) - at(touch.bodies[0], middle);
    let flat = sliding - n * n.dot(sliding);
    if flat.dot(flat) > 1.0e-4 {
        return normalize_or(flat, any_perpendicular(n));
    }
    any_perpendicular(n)
}
