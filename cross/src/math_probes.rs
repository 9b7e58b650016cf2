//! The scalar functions of `math.rs`, and the casts that positions go through.

use crate::Probe;
use crate::hash;
use crate::numbers::Numbers;
use cellstep_core::math::{self, Rotation, Vec3};
use cellstep_core::{BodyDef, Geometry, MassProperties, Position, Settings};

/// Arguments for each function.
const COUNT: u32 = 100_000;

/// All probes of scalar functions.
pub(crate) const ALL: [Probe; 10] = [
    Probe { name: "math-sin", value: || over(|n| math::sin(n.between(-100.0, 100.0))) },
    Probe { name: "math-cos", value: || over(|n| math::cos(n.between(-100.0, 100.0))) },
    Probe { name: "math-sin-any", value: || over(|n| math::sin(n.any())) },
    Probe { name: "math-acos", value: || over(|n| math::acos(n.between(-1.0, 1.0))) },
    Probe { name: "math-atan2", value: || over(|n| math::atan2(n.any(), n.any())) },
    Probe { name: "math-sqrt", value: || over(|n| math::sqrt(n.any())) },
    Probe { name: "math-bounds", value: || over(|n| math::max(math::min(n.any(), n.any()), n.any())) },
    Probe { name: "math-rotation", value: rotations },
    Probe { name: "math-position", value: positions },
    Probe { name: "math-refusal", value: refusals },
];

fn over(function: impl Fn(&mut Numbers) -> f32) -> u64 {
    let mut numbers = Numbers(5);
    (0..COUNT).fold(hash::START, |sum, _| hash::number(sum, function(&mut numbers)))
}

/// A rotation that is turned, made a matrix and taken back, many times over.
fn rotations() -> u64 {
    let mut numbers = Numbers(6);
    let mut turned = Rotation::IDENTITY;
    let mut sum = hash::START;
    for _ in 0..COUNT {
        turned = Rotation::from_rotation_vector(numbers.vector(4.0)).after(turned).normalized();
        let again = Rotation::from_matrix(&turned.matrix());
        let v = turned.rotate(numbers.vector(10.0)) + again.unrotate(Vec3::Z);
        sum = [v.x, v.y, v.z, turned.w, again.x].into_iter().fold(sum, hash::number);
    }
    sum
}

/// Places taken apart into sectors and offsets, and moved.
fn positions() -> u64 {
    let mut numbers = Numbers(7);
    let mut sum = hash::START;
    for _ in 0..COUNT {
        let far = |n: &mut Numbers| f64::from(n.between(-1.0e6, 1.0e6)) * f64::from(n.between(0.0, 1.0e3));
        let place = Position::from_f64([far(&mut numbers), far(&mut numbers), far(&mut numbers)]);
        let moved = place.plus(numbers.vector(200.0));
        let way = moved.minus(place);
        sum = [way.x, way.y, way.z].into_iter().fold(sum, hash::number);
        sum = moved.sector.into_iter().fold(sum, |sum, sector| hash::word(sum, sector as u64));
        sum = moved.to_f64().into_iter().fold(sum, |sum, x| hash::word(sum, x.to_bits()));
    }
    sum
}

/// Which of many arguments, not-a-numbers of both kinds among them, the core's checks let through.
fn refusals() -> u64 {
    let mut numbers = Numbers(8);
    let mut sum = hash::START;
    for _ in 0..COUNT {
        // Half of the components are harmless, so that one bad one decides.
        let mut any = || if numbers.below(2) == 0 { 0.5 } else { numbers.any() };
        let (x, y, z) = (any(), any(), any());
        let vector = Vec3::new(x, y, z);
        let finite = [x, y, z].iter().all(|x| x.to_bits() & 0x7f80_0000 != 0x7f80_0000);
        let settings = Settings { gravity: vector, dt: 0.01, ..Settings::default() };
        let mass = MassProperties { mass: 1.0, inertia: vector, ..MassProperties::default() };
        let answers = [
            settings.check().is_ok(),
            Settings { dt: x, push_speed: y, ..Settings::default() }.check().is_ok(),
            BodyDef { linear_velocity: vector, ..BodyDef::default() }.check().is_ok(),
            BodyDef { position: Position { sector: [0; 3], offset: vector }, ..BodyDef::default() }
                .check()
                .is_ok(),
            BodyDef { rotation: Rotation::new(x, y, z, 0.5), ..BodyDef::default() }.check().is_ok(),
            BodyDef { mass: Some(mass), ..BodyDef::default() }.check().is_ok(),
            Geometry::Box { half_extents: vector }.check().is_ok(),
        ];
        for (index, answer) in answers.into_iter().enumerate() {
            assert!(finite || !answer || index == 1, "check {index} lets {vector} through");
            sum = hash::word(sum, u64::from(answer));
        }
    }
    sum
}
