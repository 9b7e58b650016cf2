//! Structures that stand or fall: arch, card house, overhang, ladder, tilting column; and a rod whose friction has
//! no answer in rigid-body mechanics.

use cellstep::math::{PI, Rotation, Vec3, cos, sin};
use cellstep::{
    BodyDef, BodyHandle, BodyKind, Capacities, Geometry, PairMaterial, Preset, Serial, Settings, ShapeDef,
};
use cellstep_tests::jointed::energy;
use cellstep_tests::oracles::{GRAVITY, Wide, center, minus, norm};
use cellstep_tests::score::{Case, Sheet};
use cellstep_tests::worlds::{OwnedWorld, add, ground};

fn rough(geometry: Geometry, friction: f32) -> ShapeDef {
    ShapeDef { friction, ..ShapeDef::new(geometry) }
}

/// Runs until a body has gone farther than `limit` from where it was, at most for so many steps. Gives the steps,
/// and the farthest way of a body, metres.
fn stand(world: &mut OwnedWorld, bodies: &[BodyHandle], (steps, limit): (u32, f64)) -> (u32, f64) {
    let start: Vec<Wide> = bodies.iter().map(|&body| center(world, body)).collect();
    let mut worst = 0.0_f64;
    for step in 0..steps {
        world.step(&mut Serial);
        for (&body, &from) in bodies.iter().zip(&start) {
            worst = worst.max(norm(minus(center(world, body), from)));
        }
        if worst > limit {
            return (step, worst);
        }
    }
    (steps, worst)
}

/// Notes how much of its time a structure stood, and how far a body went.
fn judge_standing(sheet: &mut Sheet, (steps, stood): (u32, u32), (way, marks): (f64, [f64; 2])) {
    let fallen = 1.0 - f64::from(stood) / f64::from(steps);
    sheet.judge("share of the time fallen", (fallen, "relative"), [0.0; 2]);
    sheet.judge("farthest way of a body", (way, "m"), marks);
}

/// Voussoirs of a semicircular arch of 2 m mean radius, a quarter of that thick, on rough ground.
#[test]
fn an_arch_stands() {
    Case::new("arch of 15 for 60 s").gated_from(Preset::Balanced).run(|sheet| {
        let count = 15_u16;
        let mut world = sheet.world_with(Capacities { hulls: 1, ..Capacities::for_bodies(16) });
        let half = 0.5 * PI / f32::from(count);
        let (inner, outer, depth) = (1.75, 2.25, 0.25);
        let mut points = Vec::new();
        for (radius, angle) in [(inner, half), (outer, half), (inner, -half), (outer, -half)] {
            let (x, z) = (radius * sin(angle), radius * cos(angle) - 2.0);
            points.extend([Vec3::new(x, -depth, z), Vec3::new(x, depth, z)]);
        }
        let wedge = world.add_hull(&points).expect("a wedge has a hull");
        ground(&mut world, 0.8);
        let mut stones = Vec::new();
        for i in 0..count {
            let angle = half * (2.0 * f32::from(i) + 1.0) - 0.5 * PI;
            let rotation = Rotation::from_axis_angle(Vec3::Y, angle);
            let place = Vec3::new(2.0 * sin(angle), 0.0, 2.0 * cos(angle));
            let def = BodyDef { rotation, ..BodyDef::new(BodyKind::Dynamic, place) };
            stones.push(add(&mut world, &def, &rough(Geometry::Hull(wedge), 0.8)).0);
        }
        let (stood, way) = stand(&mut world, &stones, (3600, 0.2));
        judge_standing(sheet, (3600, stood), (way, [0.01, 0.1]));
    });
}

/// Half the length, thickness and depth of a card, metres.
const CARD: [f32; 3] = [0.1, 0.001, 0.07];

/// A card of the house, its length along z before it is turned about y.
fn card(world: &mut OwnedWorld, (x, z): (f32, f32), turn: f32) -> BodyHandle {
    let rotation = Rotation::from_axis_angle(Vec3::Y, turn);
    let def = BodyDef { rotation, ..BodyDef::new(BodyKind::Dynamic, Vec3::new(x, 0.0, z)) };
    let geometry = Geometry::Box { half_extents: Vec3::new(CARD[1], CARD[2], CARD[0]) };
    add(world, &def, &rough(geometry, 0.7)).0
}

/// Storeys of cards that lean at 25 degrees against each other, with cards laid across.
fn card_house(world: &mut OwnedWorld, storeys: u8) -> Vec<BodyHandle> {
    let tilt = 25.0 * PI / 180.0;
    let [half, thick, _] = CARD;
    // A leaning card's upper corner is this far above and beside its center.
    let (rise, reach) = (half * cos(tilt) + thick * sin(tilt), half * sin(tilt) + thick * cos(tilt));
    let apart = 4.0 * reach + 0.006;
    let mut cards = Vec::new();
    for storey in 0..storeys {
        let pairs = storeys - storey;
        let base = f32::from(storey) * 2.0 * (rise + thick);
        for i in 0..pairs {
            let x = (f32::from(i) - 0.5 * f32::from(pairs - 1)) * apart;
            cards.push(card(world, (x - reach, base + rise), tilt));
            cards.push(card(world, (x + reach, base + rise), -tilt));
            if i + 1 < pairs {
                cards.push(card(world, (x + 0.5 * apart, base + 2.0 * rise + thick), 0.5 * PI));
            }
        }
    }
    cards
}

#[test]
fn a_card_house_stands() {
    for (name, storeys, from) in [
        ("card house of 3 storeys for 60 s", 3, Preset::Balanced),
        ("card house of 5 storeys for 60 s", 5, Preset::Accurate),
    ] {
        Case::new(name).gated_from(from).run(|sheet| {
            let mut world = sheet.world(64);
            ground(&mut world, 0.7);
            let cards = card_house(&mut world, storeys);
            let (stood, way) = stand(&mut world, &cards, (3600, 0.05));
            judge_standing(sheet, (3600, stood), (way, [0.001, 0.02]));
        });
    }
}

/// Four blocks of 1 m on a table's edge, each as far out as the harmonic series allows, times `share`.
fn overhang(sheet: &Sheet, share: f32) -> bool {
    let mut world = sheet.world(5);
    let table = world.create_body(&BodyDef::new(BodyKind::Static, Vec3::new(-2.0, 0.0, -0.5))).expect("room");
    let top = rough(Geometry::Box { half_extents: Vec3::new(2.0, 1.0, 0.5) }, 0.6);
    world.create_shape(table, &top).expect("room");
    let (mut x, mut blocks) = (-0.5, Vec::new());
    for i in 0..4_u8 {
        x += share * 0.5 / f32::from(4 - i);
        let place = Vec3::new(x, 0.0, 0.1 + 0.2 * f32::from(i));
        let geometry = Geometry::Box { half_extents: Vec3::new(0.5, 0.25, 0.1) };
        blocks.push(add(&mut world, &BodyDef::new(BodyKind::Dynamic, place), &rough(geometry, 0.6)).0);
    }
    assert!((x - (share * 1.041_667 - 0.5)).abs() < 1.0e-5);
    stand(&mut world, &blocks, (1200, 0.1)).0 == 1200
}

#[test]
fn blocks_hang_over_as_far_as_they_may() {
    Case::new("overhang of 4 blocks").gated_from(Preset::Balanced).run(|sheet| {
        sheet.holds("stands at 0.99 of the limit for 20 s", overhang(sheet, 0.99));
        sheet.holds("falls at 1.01 of the limit within 20 s", !overhang(sheet, 1.01));
    });
}

/// A ladder of 2 m between a floor (friction 0.4) and a wall (0.2), at an angle to the floor. True when it stays
/// for 10 s.
fn ladder(sheet: &Sheet, degrees: f32) -> bool {
    let mut world = sheet.world_with(Capacities { pair_rules: 2, ..Capacities::for_bodies(3) });
    let mut side = |turn: f32| {
        let rotation = Rotation::from_axis_angle(Vec3::Y, turn);
        let def = BodyDef { rotation, ..BodyDef::new(BodyKind::Static, Vec3::ZERO) };
        let body = world.create_body(&def).expect("room");
        world.create_shape(body, &ShapeDef::new(Geometry::HalfSpace)).expect("room")
    };
    // The wall's normal is x: the ladder leans to the left.
    let (floor, wall) = (side(0.0), side(0.5 * PI));
    let (half, radius, angle) = (1.0, 0.005, degrees * PI / 180.0);
    let place = Vec3::new(half * cos(angle) + radius, 0.0, half * sin(angle) + radius);
    let rotation = Rotation::from_axis_angle(Vec3::Y, angle - 0.5 * PI);
    let def = BodyDef { rotation, ..BodyDef::new(BodyKind::Dynamic, place) };
    let rod = ShapeDef::new(Geometry::Capsule { half_height: half, radius });
    let (body, rod) = add(&mut world, &def, &rod);
    for (side, friction) in [(floor, 0.4), (wall, 0.2)] {
        let rule = PairMaterial { friction: Some(friction), restitution: None };
        world.set_pair_material(side, rod, &rule).expect("room");
    }
    stand(&mut world, &[body], (600, 0.1)).0 == 600
}

/// Uniform: slips below `tan a = (1 - mu_f mu_w) / (2 mu_f)`, 48.99 degrees.
#[test]
fn a_ladder_slips_below_its_angle() {
    Case::new("ladder between floor and wall").gated_from(Preset::Balanced).run(|sheet| {
        sheet.holds("stands a degree above 48.99 for 10 s", ladder(sheet, 49.99));
        sheet.holds("slips a degree below 48.99 within 10 s", !ladder(sheet, 47.99));
    });
}

/// A column of 1 x 1 x 2 m while gravity turns by half a degree per second, which is what a ramp does that turns so
/// slowly. Gives the angle at which it has begun to slide or to turn, degrees.
fn tilt(sheet: &Sheet, friction: f32) -> (f64, f64) {
    let mut world = sheet.world(2);
    ground(&mut world, friction);
    let place = Vec3::new(0.0, 0.0, 1.0);
    let column = rough(Geometry::Box { half_extents: Vec3::new(0.5, 0.5, 1.0) }, friction);
    let (body, _) = add(&mut world, &BodyDef::new(BodyKind::Dynamic, place), &column);
    for step in 0..2400_u16 {
        let degrees = 15.0 + f32::from(step) / 120.0;
        let angle = degrees * PI / 180.0;
        let gravity = Vec3::new(sin(angle), 0.0, -cos(angle)) * 9.81;
        world.set_settings(&Settings { gravity, ..world.settings() }).expect("in range");
        world.step(&mut Serial);
        let turned = 2.0 * f64::from(world.rotation(body).expect("lives").y.abs()).asin();
        // Half a degree of turn, or 5 mm of way at the foot.
        let way = center(&world, body)[0] - turned.sin();
        if turned > 0.01 || way > 0.005 {
            return (f64::from(degrees), turned);
        }
    }
    (f64::INFINITY, 0.0)
}

#[test]
fn a_column_tips_or_slides_at_its_angle() {
    Case::new("column on a ramp that tilts").gated_from(Preset::Balanced).run(|sheet| {
        let (degrees, turned) = tilt(sheet, 0.7);
        sheet.judge("tips at 26.565 degrees", ((degrees - 26.565).abs(), "degrees"), [0.3, 1.0]);
        sheet.holds("tips with friction 0.7", turned > 0.01);
        let (degrees, turned) = tilt(sheet, 0.4);
        sheet.judge("slides at 21.80 degrees", ((degrees - 21.80).abs(), "degrees"), [0.3, 1.0]);
        sheet.holds("slides with friction 0.4", turned < 0.01);
    });
}

/// A rod at 60 degrees with friction 1.5 that slides on its lower end: for one direction the rigid equations have
/// no solution, or two (Painleve 1895). Gives the greatest gain of energy and the greatest speed of a point.
fn painleve(sheet: &Sheet, speed: f32) -> (f64, f64) {
    let mut world = sheet.world(2);
    ground(&mut world, 1.5);
    let (half, radius, angle) = (0.5, 0.01, PI / 3.0);
    let place = Vec3::new(0.0, 0.0, half * sin(angle) + radius);
    let def = BodyDef {
        rotation: Rotation::from_axis_angle(Vec3::Y, 0.5 * PI - angle),
        linear_velocity: Vec3::X * speed,
        ..BodyDef::new(BodyKind::Dynamic, place)
    };
    let rod = rough(Geometry::Capsule { half_height: half, radius }, 1.5);
    let (body, _) = add(&mut world, &def, &rod);
    let start = energy(&world, body, GRAVITY);
    let (mut gain, mut fastest) = (0.0_f64, 0.0_f64);
    for _ in 0..240 {
        let report = world.step(&mut Serial);
        assert_eq!((report.quarantined, report.capped), (0, 0));
        gain = gain.max(energy(&world, body, GRAVITY) / start - 1.0);
        fastest = fastest.max(norm(cellstep_tests::oracles::velocity(&world, body)));
    }
    (gain, fastest)
}

#[test]
fn a_rod_that_jams_gains_no_energy() {
    Case::new("Painleve rod").run(|sheet| {
        for speed in [-20.0, -10.0, -3.0, -1.0, 1.0, 3.0, 10.0, 20.0] {
            let (gain, fastest) = painleve(sheet, speed);
            let name = format!("{speed:+5} m/s");
            sheet.judge(&format!("{name}, energy gained"), (gain, "relative"), [1.0e-5, 1.0e-3]);
            // Falling adds 3 m/s at most.
            let gate = 1.05 * (f64::from(speed).powi(2) + 10.0).sqrt();
            sheet.judge(&format!("{name}, fastest"), (fastest, "m/s"), [gate, gate]);
        }
    });
}
