//! What surfaces do beyond friction and restitution, and how two of them go together.
//!
//! Friction and restitution stand in each shape. The rest is rare: it lies in a pool of its own, where shapes of
//! the same traits share a row, and a shape without traits has none.

use crate::error::Error;
use crate::math::{Vec3, length, max, min, normalize_or, sqrt};
use crate::state::{Field, fields};
use crate::validate;
use bytemuck::{Pod, Zeroable};

/// How the coefficients of two shapes become that of their contact. If the shapes name different rules, the one
/// that stands later here is taken, whichever shape names it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Mix {
    /// No rule of its own: what the other shape says; if it says nothing either, the geometric mean of frictions
    /// and the greater restitution.
    #[default]
    Unset,
    /// The root of the product.
    GeometricMean,
    /// Half the sum.
    Mean,
    /// The lesser one.
    Min,
    /// The product.
    Multiply,
    /// The greater one.
    Max,
}

impl Mix {
    const ALL: [Self; 6] =
        [Self::Unset, Self::GeometricMean, Self::Mean, Self::Min, Self::Multiply, Self::Max];

    fn read(index: u32) -> Option<Self> {
        Self::ALL.get(index as usize).copied()
    }

    /// Two coefficients by this rule; by `unset` where there is none.
    pub(crate) fn of(self, a: f32, b: f32, unset: Self) -> f32 {
        match if self == Self::Unset { unset } else { self } {
            Self::Unset | Self::GeometricMean => sqrt(a * b),
            Self::Mean => 0.5 * (a + b),
            Self::Min => min(a, b),
            Self::Multiply => a * b,
            Self::Max => max(a, b),
        }
    }
}

/// What the surface of a shape does beyond friction and restitution. Shapes with the same traits share a row of
/// [`Capacities::materials`](crate::Capacities::materials); those of the default take none.
///
/// # Rolling and spinning
/// Resistance is a torque of at most a length times the force of contact: `rolling` against turning about axes in
/// the surface, `spinning` about the normal. Two shapes have the greater length of each. A solid ball of radius `r`
/// that rolls on a plane slows down by `5/7 g rolling / r`, and stays at rest where the slope is less than
/// `rolling / r`. Contacts of three and four points resist by themselves, and have no such torque; nor have those
/// of boxes and hulls that hardly move against each other.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MaterialTraits {
    /// How friction is mixed.
    pub friction_mix: Mix,
    /// How restitution is mixed.
    pub restitution_mix: Mix,
    /// Length of the resistance to rolling, metres, 0..=1e3. Steel on steel: some 1e-5; a tyre on a road: 5e-3.
    pub rolling: f32,
    /// Length of the resistance to spinning about the normal, metres, 0..=1e3: for a round spot of contact two
    /// thirds of its radius times the coefficient of friction.
    pub spinning: f32,
    /// Velocity of the surface in the shape's frame, m/s, each component at most 1e4 in size: friction carries what
    /// touches it along, as on a conveyor, while the shape itself does not move. What points along the normal of a
    /// contact is left out. What touches a surface that moves does not fall asleep.
    pub surface_velocity: Vec3,
    /// Direction in the shape's frame, of any length but zero, to which the shape is solid; `None` for all. Other
    /// shapes touch it when the normal of the contact, towards them, is within 45 degrees of this direction and
    /// they do not overlap by more than 5 mm. Else they pass, until this is so: things that come from the back or
    /// the side, and things that start inside. What touches once stays in touch until they part.
    pub one_way: Option<Vec3>,
}

/// The cosine of the angle within which a one-way surface is solid.
const ONE_WAY_COSINE: f32 = core::f32::consts::FRAC_1_SQRT_2;
/// Overlap with which something may begin to touch a one-way surface, metres: more than a load sinks in, so that
/// what stands on it is not let through when it is changed.
pub(crate) const ONE_WAY_SLOP: f32 = 0.005;

impl MaterialTraits {
    /// Refuses numbers that are not finite or out of the documented ranges.
    pub fn check(&self) -> Result<(), Error> {
        validate::in_range("rolling", self.rolling, 0.0, 1.0e3)?;
        validate::in_range("spinning", self.spinning, 0.0, 1.0e3)?;
        validate::vector_within("surface_velocity", self.surface_velocity, 1.0e4)?;
        let Some(direction) = self.one_way else { return Ok(()) };
        validate::vector_within("one_way", direction, 1.0e6)?;
        if length(direction) < 1.0e-6 {
            return Err(Error::OutOfRange { name: "one_way" });
        }
        Ok(())
    }

    /// True when no row is needed.
    pub(crate) fn are_default(&self) -> bool {
        *self == Self::default()
    }
}

/// [`MaterialTraits`] in the state; zero when no shape has them.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub(crate) struct MaterialRow {
    /// m/s in the shape's frame.
    pub surface_velocity: Vec3,
    /// Metres.
    pub rolling: f32,
    /// Unit vector in the shape's frame; zero for a shape that is solid to all sides.
    pub one_way: Vec3,
    /// Metres.
    pub spinning: f32,
    /// Index of the rule of friction, and 8 times that of restitution.
    pub mixes: u32,
    /// Shapes that have these traits.
    pub uses: u32,
}

impl MaterialRow {
    /// No traits.
    pub const NONE: Self = Self {
        surface_velocity: Vec3::ZERO,
        rolling: 0.0,
        one_way: Vec3::ZERO,
        spinning: 0.0,
        mixes: 0,
        uses: 0,
    };

    pub fn new(traits: &MaterialTraits) -> Self {
        // Adding 0 makes zeros of one sign: equal traits are equal bytes.
        let plain = |v: Vec3| v + Vec3::ZERO;
        let direction = |v: Vec3| plain(normalize_or(v, Vec3::Z));
        Self {
            surface_velocity: plain(traits.surface_velocity),
            rolling: traits.rolling + 0.0,
            one_way: traits.one_way.map_or(Vec3::ZERO, direction),
            spinning: traits.spinning + 0.0,
            mixes: traits.friction_mix as u32 | (traits.restitution_mix as u32) << 3,
            uses: 0,
        }
    }

    /// The traits; `None` when the row is not one that [`MaterialRow::new`] makes.
    pub fn read(&self) -> Option<MaterialTraits> {
        let traits = MaterialTraits {
            friction_mix: Mix::read(self.mixes & 7)?,
            restitution_mix: Mix::read(self.mixes >> 3)?,
            rolling: self.rolling,
            spinning: self.spinning,
            surface_velocity: self.surface_velocity,
            one_way: (self.one_way != Vec3::ZERO).then_some(self.one_way),
        };
        let unit = self.one_way == Vec3::ZERO || (length(self.one_way) - 1.0).abs() < 1.0e-3;
        (unit && traits.check().is_ok()).then_some(traits)
    }

    /// The rules of friction and restitution.
    pub fn rules(&self) -> [Mix; 2] {
        [self.mixes & 7, self.mixes >> 3].map(|index| Mix::read(index).unwrap_or_default())
    }

    /// True when the solve has to know of it.
    pub fn resists(&self) -> bool {
        self.rolling > 0.0 || self.spinning > 0.0
    }

    pub fn moves(&self) -> bool {
        self.surface_velocity != Vec3::ZERO
    }

    /// True when a contact with this normal, towards the other shape in this one's frame, is on the solid side.
    pub fn is_solid_to(&self, normal: Vec3) -> bool {
        self.one_way == Vec3::ZERO || normal.dot(self.one_way) >= ONE_WAY_COSINE
    }
}

/// Friction and restitution of two shapes in the place of what their materials give.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PairMaterial {
    /// Coefficient of friction, 0..=1e6; `None` as the shapes' materials give it.
    pub friction: Option<f32>,
    /// Coefficient of restitution, 0..=1; `None` as the shapes' materials give it.
    pub restitution: Option<f32>,
}

impl PairMaterial {
    /// Refuses numbers that are not finite or out of the documented ranges.
    pub fn check(&self) -> Result<(), Error> {
        crate::shape::check_material(self.friction.unwrap_or(0.0), self.restitution.unwrap_or(0.0))
    }
}

/// Two shapes have friction and restitution of their own.
pub(crate) const RULE_MATERIAL: u32 = 0;
/// Two bodies do not touch until they are apart.
pub(crate) const RULE_IGNORE: u32 = 1;

/// A rule for a pair, in the state. Sorted by what comes first: kind, lower slot, higher slot.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub(crate) struct PairRule {
    /// `RULE_*`.
    pub kind: u32,
    /// Slots of shapes or bodies, the lower one first.
    pub slots: [u32; 2],
    /// 1 when friction is given, and 2 when restitution is.
    given: u32,
    friction: f32,
    restitution: f32,
}

impl PairRule {
    /// Names of the fields, for `state/fields.rs`.
    pub const FIELDS: &[Field] = fields!(PairRule {
        kind: U32 1,
        slots: U32 2,
        given: U32 1,
        friction: F32 1,
        restitution: F32 1,
    });

    pub fn material(slots: [u32; 2], material: &PairMaterial) -> Self {
        Self {
            kind: RULE_MATERIAL,
            slots: ordered(slots),
            given: u32::from(material.friction.is_some()) | u32::from(material.restitution.is_some()) << 1,
            friction: material.friction.unwrap_or(0.0),
            restitution: material.restitution.unwrap_or(0.0),
        }
    }

    pub fn ignore(slots: [u32; 2]) -> Self {
        Self { kind: RULE_IGNORE, slots: ordered(slots), given: 0, friction: 0.0, restitution: 0.0 }
    }

    pub fn key(&self) -> (u32, [u32; 2]) {
        (self.kind, self.slots)
    }

    pub fn read(&self) -> PairMaterial {
        PairMaterial {
            friction: (self.given & 1 != 0).then_some(self.friction),
            restitution: (self.given & 2 != 0).then_some(self.restitution),
        }
    }

    /// True when the row is one that this file makes.
    pub fn is_sound(&self) -> bool {
        let material = self.read();
        let again = match self.kind {
            RULE_MATERIAL if self.given != 0 => Self::material(self.slots, &material),
            RULE_IGNORE => Self::ignore(self.slots),
            _ => return false,
        };
        self.slots[0] < self.slots[1]
            && material.check().is_ok()
            && bytemuck::bytes_of(&again) == bytemuck::bytes_of(self)
    }
}

/// The lower slot first.
pub(crate) fn ordered([a, b]: [u32; 2]) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

/// The place of a rule among sorted ones.
pub(crate) fn find_rule(rules: &[PairRule], kind: u32, slots: [u32; 2]) -> Result<usize, usize> {
    rules.binary_search_by(|rule| rule.key().cmp(&(kind, ordered(slots))))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mixing_is_symmetric_and_as_documented() {
        for (i, a) in Mix::ALL.into_iter().enumerate() {
            for (k, b) in Mix::ALL.into_iter().enumerate() {
                let rule = a.max(b);
                assert_eq!(rule, b.max(a));
                assert_eq!(rule, Mix::ALL[i.max(k)], "the later one is taken");
                let mixed = rule.of(0.2, 0.7, Mix::Max);
                assert_eq!(mixed.to_bits(), rule.of(0.7, 0.2, Mix::Max).to_bits());
            }
        }
        let by = |rule: Mix| rule.of(0.25, 0.64, Mix::GeometricMean);
        assert_eq!(by(Mix::Unset), by(Mix::GeometricMean));
        assert!((by(Mix::GeometricMean) - 0.4).abs() < 1.0e-7);
        assert!((by(Mix::Mean) - 0.445).abs() < 1.0e-7);
        assert_eq!((by(Mix::Min), by(Mix::Max)), (0.25, 0.64));
        assert!((by(Mix::Multiply) - 0.16).abs() < 1.0e-7);
    }

    #[test]
    fn rows_read_as_what_they_were_made_of() {
        let traits = MaterialTraits {
            friction_mix: Mix::Max,
            restitution_mix: Mix::Min,
            rolling: 0.01,
            spinning: 0.02,
            surface_velocity: Vec3::new(1.0, -2.0, 0.0),
            one_way: Some(Vec3::Z),
        };
        assert_eq!(MaterialRow::new(&traits).read(), Some(traits));
        assert_eq!(MaterialRow::new(&MaterialTraits::default()), MaterialRow::NONE);
        let broken = MaterialRow { mixes: 6, ..MaterialRow::NONE };
        assert_eq!(broken.read(), None);
        let broken = MaterialRow { rolling: f32::NAN, ..MaterialRow::NONE };
        assert_eq!(broken.read(), None);
    }
}
