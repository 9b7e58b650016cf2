//! Materials of a document.

use super::{DENSITY_DEFAULT, FRICTION_DEFAULT};
use super::{density_default, friction_default, is_default, is_zero, is_zero_each};
use cellstep_core::math::Vec3;
use cellstep_core::{MaterialTraits, Mix};
use serde::{Deserialize, Serialize};

/// How the coefficients of two materials become one. Of two rules the one that stands later here is taken.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum MixDoc {
    /// The other material's rule; if it has none either, the geometric mean of frictions, the greater restitution.
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

impl From<MixDoc> for Mix {
    fn from(doc: MixDoc) -> Self {
        match doc {
            MixDoc::Unset => Mix::Unset,
            MixDoc::GeometricMean => Mix::GeometricMean,
            MixDoc::Mean => Mix::Mean,
            MixDoc::Min => Mix::Min,
            MixDoc::Multiply => Mix::Multiply,
            MixDoc::Max => Mix::Max,
        }
    }
}

/// A surface and what lies under it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a material object")]
pub struct MaterialDoc {
    /// Coefficient of friction, not negative.
    #[serde(default = "friction_default")]
    pub friction: f32,
    /// Coefficient of restitution, 0 (no bounce) to 1.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub restitution: f32,
    /// Mass of a cubic metre, kg, not negative; 0 adds no mass.
    #[serde(default = "density_default")]
    pub density: f32,
    /// How friction is mixed.
    #[serde(default, skip_serializing_if = "is_default")]
    pub friction_mix: MixDoc,
    /// How restitution is mixed.
    #[serde(default, skip_serializing_if = "is_default")]
    pub restitution_mix: MixDoc,
    /// Length of the resistance to rolling, metres.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub rolling: f32,
    /// Length of the resistance to spinning, metres.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub spinning: f32,
    /// Velocity of the surface in the shape's frame, m/s.
    #[serde(default, skip_serializing_if = "is_zero_each")]
    pub surface_velocity: [f32; 3],
    /// Direction in the shape's frame to which it is solid; to all when left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub one_way: Option<[f32; 3]>,
}

impl Default for MaterialDoc {
    fn default() -> Self {
        Self {
            friction: FRICTION_DEFAULT,
            restitution: 0.0,
            density: DENSITY_DEFAULT,
            friction_mix: MixDoc::Unset,
            restitution_mix: MixDoc::Unset,
            rolling: 0.0,
            spinning: 0.0,
            surface_velocity: [0.0; 3],
            one_way: None,
        }
    }
}

impl MaterialDoc {
    /// What it has beyond friction, restitution and density.
    pub fn traits(&self) -> MaterialTraits {
        MaterialTraits {
            friction_mix: self.friction_mix.into(),
            restitution_mix: self.restitution_mix.into(),
            rolling: self.rolling,
            spinning: self.spinning,
            surface_velocity: Vec3::from(self.surface_velocity),
            one_way: self.one_way.map(Vec3::from),
        }
    }
}
