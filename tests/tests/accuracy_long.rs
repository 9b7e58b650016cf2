//! Long runs: what rests awake for a minute, and an hour of a pendulum, a top and a stack, awake and asleep.
//!
//! The tests take a minute of the hour; `LONG=1` runs all of it. A drift is compared between the first and the last
//! quarter, so that one that grows ever faster is told from one that is linear.

use cellstep::joint::axis::TURN_X;
use cellstep::math::{PI, Pose, Rotation, Vec3, cos, sin};
use cellstep::{
    BodyDef, BodyHandle, BodyKind, Geometry, JointDef, MassProperties, Serial, Settings, ShapeDef,
};
use cellstep_tests::jointed::{Bar, about_y, at, energy, gap, massive};
use cellstep_tests::oracles::{GRAVITY, Wide, center, minus, norm, plus, velocity};
use cellstep_tests::score::{Case, Sheet};
use cellstep_tests::worlds::{OwnedWorld, add, ground, run};

const CUBE: Geometry = Geometry::Box { half_extents: Vec3::splat(0.5) };

fn cube(world: &mut OwnedWorld, place: Vec3) -> BodyHandle {
    add(world, &BodyDef::new(BodyKind::Dynamic, place), &ShapeDef::new(CUBE)).0
}

/// The root of the mean square of all speeds over some steps, m/s, and the farthest way of a body, m.
fn watch(world: &mut OwnedWorld, bodies: &[BodyHandle], steps: u32) -> (f64, f64) {
    let start: Vec<Wide> = bodies.iter().map(|&body| center(world, body)).collect();
    let (mut sum, mut creep) = (0.0, 0.0_f64);
    for _ in 0..steps {
        world.step(&mut Serial);
        for (&body, &from) in bodies.iter().zip(&start) {
            sum += norm(velocity(world, body)).powi(2);
            creep = creep.max(norm(minus(center(world, body), from)));
        }
    }
    ((sum / f64::from(steps) / bodies.len() as f64).sqrt(), creep)
}

#[test]
fn what_rests_awake_neither_jitters_nor_creeps() {
    for (name, rows) in [("stack of 5 at rest for 60 s", 0), ("pyramid of 6 rows at rest for 60 s", 6_u8)] {
        Case::new(name).run(|sheet| {
            let mut world = sheet.world(40);
            ground(&mut world, 0.6);
            for row in 0..rows {
                for i in 0..rows - row {
                    let x = f32::from(i) + 0.5 * f32::from(row);
                    cube(&mut world, Vec3::new(x, 0.0, 0.5 + f32::from(row)));
                }
            }
            if rows == 0 {
                for i in 0..5_u8 {
                    cube(&mut world, Vec3::Z * (0.5 + f32::from(i)));
                }
            }
            run(&mut world, 300);
            let bodies: Vec<BodyHandle> = world.bodies().skip(1).collect();
            let (rms, creep) = watch(&mut world, &bodies, 3600);
            sheet.judge("speed, rms", (rms, "m/s"), [1.0e-4, 1.0e-3]);
            sheet.judge("creep", (creep, "m"), [1.0e-4, 1.0e-3]);
        });
    }
}

/// Steps of the run: an hour with `LONG=1`, a minute else; and the name that says so.
fn length() -> (u32, &'static str) {
    let long = std::env::var_os("LONG").is_some_and(|value| value == "1");
    if long { (216_000, "hour") } else { (3_600, "minute") }
}

/// Runs and gives the drift of a quantity over the first quarter and over all, and the widest it was off. The
/// quantity is read as the mean over a period of so many steps.
fn drift(
    world: &mut OwnedWorld,
    (steps, period): (u32, u32),
    mut read: impl FnMut(&OwnedWorld) -> f64,
) -> [f64; 3] {
    let mut mean = |world: &mut OwnedWorld| {
        let mut sum = 0.0;
        for _ in 0..period {
            world.step(&mut Serial);
            sum += read(world);
        }
        sum / f64::from(period)
    };
    let start = mean(world);
    let (mut quarter, mut last, mut worst) = (0.0, start, 0.0_f64);
    let rounds = steps / period;
    for round in 1..rounds {
        last = mean(world);
        worst = worst.max((last - start).abs());
        if round == rounds / 4 {
            quarter = last - start;
        }
    }
    [quarter, last - start, worst]
}

/// Notes a drift, relative to a size, and whether it grew faster than time.
fn judge_drift(sheet: &mut Sheet, [quarter, whole, worst]: [f64; 3], (size, marks): (f64, [f64; 2])) {
    sheet.judge("drift", (worst / size, "relative"), marks);
    // Four times that of the quarter, twice over, and what rounding does.
    sheet.holds("linear", whole.abs() <= 8.0 * quarter.abs() + 0.1 * marks[1] * size);
}

#[test]
fn a_pendulum_swings_on() {
    let (steps, how_long) = length();
    let name = if how_long == "hour" { "pendulum for an hour" } else { "pendulum for a minute" };
    Case::new(name).run(|sheet| {
        let (mut world, base) = sheet.jointed(1, 1);
        let angle = 0.25 * PI;
        let bar = Bar::new(&mut world, Vec3::ZERO, Vec3::new(sin(angle), 0.0, -cos(angle)));
        let (body, frame) = bar.end(-1.0);
        let frames = [Pose::new(Vec3::ZERO, about_y()), frame];
        let joint = world.create_joint(&JointDef::hinge([base, body], frames)).expect("room");
        assert!(world.joint_coordinates(joint).expect("lives")[TURN_X].is_finite());
        let mut widest = 0.0_f64;
        let found = drift(&mut world, (steps, 102), |world| {
            widest = widest.max(gap(world, joint));
            energy(world, body, GRAVITY)
        });
        // Of what there is between hanging and standing; a pendulum loses some per mille in a minute.
        let marks = if how_long == "hour" { [0.01, 0.2] } else { [1.0e-3, 1.0e-2] };
        judge_drift(sheet, found, (GRAVITY, marks));
        sheet.judge("gap", (widest, "m"), [1.0e-4, 1.0e-3]);
    });
}

#[test]
fn a_top_spins_on() {
    let (steps, how_long) = length();
    let name = if how_long == "hour" { "free top for an hour" } else { "free top for a minute" };
    Case::new(name).run(|sheet| {
        let mut world = sheet.floating(1);
        let inertia = Vec3::new(1.0, 1.0, 2.0);
        let mass = MassProperties { mass: 1.0, inertia, ..MassProperties::default() };
        let body = massive(&mut world, at(Vec3::ZERO), mass);
        world.set_angular_velocity(body, Vec3::new(1.0, 0.0, 5.0)).expect("dynamic");
        let start = energy(&world, body, 0.0);
        let found = drift(&mut world, (steps, 60), |world| energy(world, body, 0.0));
        let marks = if how_long == "hour" { [1.0e-4, 1.0e-2] } else { [1.0e-5, 1.0e-3] };
        judge_drift(sheet, found, (start, marks));
    });
}

#[test]
fn a_stack_stands_on() {
    let (steps, how_long) = length();
    for (asleep, names) in [
        (false, ["stack awake for a minute", "stack awake for an hour"]),
        (true, ["stack asleep for a minute", "stack asleep for an hour"]),
    ] {
        Case::new(names[usize::from(how_long == "hour")]).run(|sheet| {
            let mut world = sheet.world(6);
            let sleep_time = if asleep { 0.5 } else { 0.0 };
            world.set_settings(&Settings { sleep_time, ..sheet.settings() }).expect("in range");
            ground(&mut world, 0.6);
            for i in 0..5_u8 {
                let turn = Rotation::from_axis_angle(Vec3::Z, 0.2 * f32::from(i));
                let place = Vec3::new(0.02 * f32::from(i % 2), 0.0, 0.5 + f32::from(i));
                let def = BodyDef { rotation: turn, ..BodyDef::new(BodyKind::Dynamic, place) };
                add(&mut world, &def, &ShapeDef::new(CUBE));
            }
            run(&mut world, 300);
            let bodies: Vec<BodyHandle> = world.bodies().skip(1).collect();
            assert!(bodies.iter().all(|&body| world.is_asleep(body) == Ok(asleep)), "asleep {asleep}");
            let start: Vec<Wide> = bodies.iter().map(|&body| center(&world, body)).collect();
            let found = drift(&mut world, (steps, 60), |world| {
                let off = |i: usize| norm(plus(center(world, bodies[i]), start[i], -1.0));
                (0..bodies.len()).map(off).fold(0.0, f64::max)
            });
            judge_drift(sheet, found, (1.0, [1.0e-5, 1.0e-3]));
        });
    }
}
