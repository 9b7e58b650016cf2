//! The solver's projection of contacts, for rows that come from elsewhere: test problems of others, which say
//! masses and jacobians but no shapes. What visits a row here is what visits the rows of a step.
//!
//! A contact has one point, a normal n and two tangents. Its rates are those of B against A, `J u + bias`; an
//! impulse on B along n is at least 0, and those along the tangents lie in a disc of friction times it.

use crate::constraint::contact::{self, Pass, Sweep};
use crate::constraint::residual::Greatest;
use crate::constraint::row::{Bias, LinkRow, PointRow};
use crate::lanes::{LANES, Lane, Words};
use crate::math::Vec3;
use crate::pipeline::seat::Seat;
use crate::report::Residual;
use bytemuck::Zeroable;

/// Contacts of a row.
pub const ROW_CONTACTS: usize = LANES;
/// Bodies at the end of the slice of bodies that belong to the lanes, for sides that do not move: they hold zeros.
pub const SPARE_BODIES: usize = 2 * LANES;

/// A body as the solver sees it.
#[derive(Clone, Copy, Debug)]
pub struct KernelBody(Seat);

impl KernelBody {
    /// One that does not move.
    pub fn spare() -> Self {
        Self(Seat::zeroed())
    }

    /// Velocity, m/s, inverse mass, 1/kg, and angular velocity *whitened*: scaled so that its mass matrix is 1.
    pub fn new(velocity: Vec3, inverse_mass: f32, whitened: Vec3) -> Self {
        let (v, w) = (velocity, whitened);
        let velocity = Words::new([v.x, v.y, v.z, inverse_mass, w.x, w.y, w.z, 0.0]);
        Self(Seat { velocity, moved: Words::ZERO })
    }
}

/// A contact of one point.
#[derive(Clone, Copy, Debug)]
pub struct KernelContact {
    /// Indices of the bodies A and B; `None` for one that does not move.
    pub bodies: [Option<u32>; 2],
    /// Unit normal from A to B, and the first tangent; the second is normal x tangent.
    pub directions: [Vec3; 2],
    /// Jacobians of the whitened angular velocities of A and B, along the normal and the tangents: the rate along k
    /// has `turns[1][k] . wb - turns[0][k] . wa`.
    pub turns: [[Vec3; 3]; 2],
    /// Added to the rates, m/s.
    pub bias: [f32; 3],
    /// Coefficient of friction.
    pub friction: f32,
}

/// Up to eight contacts of which no two share a body, with their impulses.
pub struct KernelRow {
    link: LinkRow,
    point: [PointRow; 1],
}

impl KernelRow {
    /// A row among `bodies` bodies, [`SPARE_BODIES`] included, without impulses.
    ///
    /// # Panics
    /// When two contacts share a body, or there are more than [`ROW_CONTACTS`].
    pub fn new(contacts: &[KernelContact], bodies: &[KernelBody]) -> Self {
        assert!(contacts.len() <= ROW_CONTACTS, "more contacts than lanes");
        let spare = bodies.len() - SPARE_BODIES;
        let (mut link, mut point) = (LinkRow::zeroed(), PointRow::zeroed());
        let end = |lane: usize, side: usize| contacts.get(lane).and_then(|contact| contact.bodies[side]);
        for lane in 0..LANES {
            let [a, b] = [0, 1].map(|side| end(lane, side));
            for (other, side) in (0..lane).flat_map(|other| [(other, 0), (other, 1)]) {
                let taken = end(other, side);
                assert!(taken.is_none() || (taken != a && taken != b), "two lanes share a body");
            }
            link.seats_a[lane] = a.unwrap_or((spare + lane) as u32);
            link.seats_b[lane] = b.unwrap_or((spare + LANES + lane) as u32);
        }
        (link.points, link.surfaces) = (1, 1);
        link.slide_min = Lane::splat(f32::MAX);
        for (lane, contact) in contacts.iter().enumerate() {
            write(contact, (&mut link, &mut point), lane);
            let ends = [link.seats_a[lane], link.seats_b[lane]];
            weigh(contact, ends.map(|body| bodies[body as usize]), (&mut link, &mut point), lane);
        }
        Self { link, point: [point] }
    }

    /// One visit of the row: changes its impulses and the velocities of its bodies.
    pub fn visit(&mut self, bodies: &mut [KernelBody]) {
        let mut seats = [Seat::zeroed(); 2 * LANES];
        let link = self.gather(bodies, &mut seats);
        let at = (self.link.seats_a, self.link.seats_b);
        (self.link.seats_a, self.link.seats_b) = (link.seats_a, link.seats_b);
        contact::visit(
            &sweep(),
            (core::slice::from_mut(&mut self.link), &mut [], &mut []),
            &mut self.point,
            &mut seats,
        );
        (self.link.seats_a, self.link.seats_b) = at;
        for (seat, body) in seats.into_iter().zip(at.0.into_iter().chain(at.1)) {
            bodies[body as usize].0 = seat;
        }
    }

    /// The greatest residual of its rows.
    pub fn residual(&self, bodies: &[KernelBody]) -> Residual {
        let mut seats = [Seat::zeroed(); 2 * LANES];
        let link = self.gather(bodies, &mut seats);
        let mut greatest = Greatest::NONE;
        contact::measure(&sweep(), (&[link], &[], &[]), &self.point, &seats, &mut greatest);
        greatest.all()
    }

    /// The impulse of a contact along the normal and the tangents, N s.
    pub fn impulse(&self, lane: usize) -> [f32; 3] {
        let [point] = &self.point;
        [&point.impulse, &self.link.first_impulse, &self.link.second_impulse].map(|x| x.get(lane))
    }

    /// The seats of the row's bodies, A and then B, and the row with these seats.
    fn gather(&self, bodies: &[KernelBody], seats: &mut [Seat; 2 * LANES]) -> LinkRow {
        let mut link = self.link;
        for lane in 0..LANES {
            seats[lane] = bodies[link.seats_a[lane] as usize].0;
            seats[LANES + lane] = bodies[link.seats_b[lane] as usize].0;
            (link.seats_a[lane], link.seats_b[lane]) = (lane as u32, (LANES + lane) as u32);
        }
        link
    }
}

/// A sweep with bias, of rigid contacts.
fn sweep() -> Sweep {
    Sweep {
        pass: Pass::Biased,
        visits: 1,
        substep: 1.0,
        bias: Bias { rate: 1.0, push_speed: 0.0 },
        nudges: false,
        splits: false,
        relaxes_again: false,
        ends: false,
        restitution_threshold: f32::MAX,
    }
}

fn write(contact: &KernelContact, (link, point): (&mut LinkRow, &mut PointRow), lane: usize) {
    let [n, t] = contact.directions;
    link.normal.set(lane, n);
    link.tangent.set(lane, t);
    let [[na, ta, sa], [nb, tb, sb]] = contact.turns;
    link.first_a.set(lane, ta);
    link.first_b.set(lane, tb);
    link.second_a.set(lane, sa);
    link.second_b.set(lane, sb);
    point.normal_a.set(lane, na);
    point.normal_b.set(lane, nb);
    let [bias, x, y] = contact.bias;
    point.bias.set(lane, bias);
    link.surface.set(lane, Vec3::new(x, y, 0.0));
    link.friction.set(lane, contact.friction);
    link.count.set(lane, 1.0);
}

/// Steps of the normal and of the tangents, as in `pipeline/rows.rs`.
fn weigh(
    contact: &KernelContact,
    ends: [KernelBody; 2],
    (link, point): (&mut LinkRow, &mut PointRow),
    lane: usize,
) {
    let free: f32 = ends.iter().map(|body| body.0.velocity.to_array()[3]).sum();
    let product = |i: usize, k: usize| contact.turns.iter().map(|turns| turns[i].dot(turns[k])).sum::<f32>();
    let mass = 1.0 / (free + product(0, 0));
    point.mass.set(lane, mass);
    point.soft_mass.set(lane, mass);
    let (p, q, r) = (free + product(1, 1), free + product(2, 2), product(1, 2));
    let half = 0.5 * (p - q);
    link.friction_mass.set(lane, 1.0 / (0.5 * (p + q) + libm::sqrtf(half * half + r * r)));
}
