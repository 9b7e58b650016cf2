//! The residual of rows of contacts: see `constraint/residual.rs`. It asks of each point what the pass asked.

use super::cones::Rates;
use super::split::Share;
use super::{Demand, Pass, Shift, Sweep, load_of};
use crate::constraint::residual::{Greatest, between, note, share, size};
use crate::constraint::row::{ConeRow, LinkRow, PointRow, ResistRow};
use crate::constraint::velocities::Velocities;
use crate::lanes::{Lane, LaneVec};
use crate::pipeline::seat::Seat;

/// Measures the rows of a group as the sweep's pass leaves them. `resists` and `cones` as in a visit.
pub(crate) fn measure(
    sweep: &Sweep,
    (rows, resists, cones): (&[LinkRow], &[ResistRow], &[ConeRow]),
    points: &[PointRow],
    seats: &[Seat],
    greatest: &mut Greatest,
) {
    let mut rest = points;
    for (i, row) in rows.iter().enumerate() {
        let (points, after) = rest.split_at(row.points as usize);
        rest = after;
        let u = Velocities::gather((&row.seats_a, &row.seats_b), seats, row.locked != 0);
        let shift = Shift::of(row);
        measure_normals(sweep, (row, points), (&u, &shift), &mut greatest.normal);
        match cones.get(i).filter(|_| points.len() > 1) {
            None => measure_friction((row, points), (&u, &shift), &mut greatest.friction),
            Some(cones) => measure_cones((row, points, cones), (&u, &shift), &mut greatest.friction),
        }
        if row.resists != 0
            && let Some(resist) = resists.get(i)
        {
            measure_resistance(&u, resist, load_of(points), &mut greatest.friction);
        }
    }
}

fn measure_normals(
    sweep: &Sweep,
    (row, points): (&LinkRow, &[PointRow]),
    (u, shift): (&Velocities, &Shift),
    greatest: &mut Lane,
) {
    let shared = Share::of(points, Lane::ZERO);
    for point in points {
        let jb = shift.apply(point.normal_b, shift.normal);
        let demand = match (sweep.pass, sweep.splits) {
            (Pass::Biased, false) => Demand::biased(point),
            (Pass::Biased, true) if points.len() > 1 => shared.demand(point),
            _ => Demand::relaxed(point),
        };
        let mut rate = u.rate(row.normal, point.normal_a, jb);
        if row.surfaces != 0 {
            rate = rate + point.surface;
        }
        let w = rate + demand.bias + demand.soft * (point.impulse - demand.load);
        let mass = shift.mass((point, demand.mass), jb);
        // lambda - greatest(0, lambda - m w), over m.
        let has = mass.greater(Lane::splat(f32::MIN_POSITIVE));
        note(greatest, has.keep(w.least(share(point.impulse, mass))));
    }
}

fn measure_friction(
    (row, points): (&LinkRow, &[PointRow]),
    (u, shift): (&Velocities, &Shift),
    greatest: &mut Lane,
) {
    let limit = row.friction * load_of(points);
    let first_b = shift.apply(row.first_b, shift.first);
    let second_b = shift.apply(row.second_b, shift.second);
    let mass = shift.friction_mass(row, (first_b, second_b));
    let second = row.normal.cross(row.tangent);
    let surface = if row.surfaces != 0 { row.surface } else { LaneVec::ZERO };
    let w = [
        u.rate(row.tangent, row.first_a, first_b) + surface.x,
        u.rate(second, row.second_a, second_b) + surface.y,
    ];
    note(greatest, in_disc([row.first_impulse, row.second_impulse], w, (mass, limit)));
    // One point has no lever, and a row of such no twist.
    if points.len() < 2 {
        return;
    }
    let w = row.twist_b.dot(u.wb) - row.twist_a.dot(u.wa) + surface.z;
    let twist = between((row.twist_impulse, w, row.twist_mass), limit * row.radius);
    let several = row.count.greater(Lane::splat(1.5));
    note(greatest, several.keep(twist * lever(u, row.twist_mass)));
}

fn measure_cones(
    (row, points, cones): (&LinkRow, &[PointRow], &ConeRow),
    (u, shift): (&Velocities, &Shift),
    greatest: &mut Lane,
) {
    let rates = Rates::new(u, row, cones, (shift, row.surfaces != 0));
    for (i, point) in points.iter().enumerate() {
        let (mass, limit) = (rates.step(cones, i, shift), row.friction * point.impulse);
        note(greatest, in_disc(cones.impulses[i], rates.at(cones.places[i]), (mass, limit)));
    }
}

fn measure_resistance(u: &Velocities, resist: &ResistRow, load: Lane, greatest: &mut Lane) {
    let rate = |i: usize| resist.turns_b[i].dot(u.wb) - resist.turns_a[i].dot(u.wa);
    let w = [rate(0) + resist.surface.x, rate(1) + resist.surface.y];
    let roll = in_disc([resist.impulse.x, resist.impulse.y], w, (resist.roll_mass, resist.rolling * load));
    note(greatest, roll * lever(u, resist.roll_mass));
    let w = rate(2) + resist.surface.z;
    let spin = between((resist.impulse.z, w, resist.spin_mass), resist.spinning * load);
    note(greatest, spin * lever(u, resist.spin_mass));
}

/// Residual of two rows with `|lambda| <= limit` together.
fn in_disc([x, y]: [Lane; 2], [wx, wy]: [Lane; 2], (mass, limit): (Lane, Lane)) -> Lane {
    let (ax, ay) = (x - mass * wx, y - mass * wy);
    let length = (ax * ax + ay * ay).sqrt();
    let scale = share(limit, length);
    let (dx, dy) = (x - ax * scale, y - ay * scale);
    let slides = share((dx * dx + dy * dy).sqrt(), mass);
    let inside = length.less(limit);
    let residual = inside.select((wx * wx + wy * wy).sqrt(), slides);
    mass.greater(Lane::splat(f32::MIN_POSITIVE)).keep(size(residual))
}

/// Radius of gyration of what a row of turning turns, whose `1 / (J M^-1 Jt)` is given, metres.
fn lever(u: &Velocities, mass: Lane) -> Lane {
    (u.inverse_mass() * mass).sqrt()
}
