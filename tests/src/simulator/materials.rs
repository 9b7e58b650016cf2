//! Commands about materials and rules for pairs.

use super::Simulator;
use cellstep::math::Vec3;
use cellstep::{Command, MaterialTraits, Mix, PairMaterial};

impl Simulator {
    /// A command about the material of a shape, or about a pair.
    pub(super) fn of_material(&mut self) -> Command {
        let (shape, other) = (self.shape(), self.shape());
        let (body, partner) = (self.body(), self.body());
        match self.random.below(6) {
            0..=2 => Command::SetMaterialTraits(shape, self.traits()),
            3 => Command::SetPairMaterial(shape, other, self.pair_material()),
            4 => Command::IgnoreUntilSeparated(body, partner),
            _ => Command::StopIgnoring(body, partner),
        }
    }

    /// One of some ten materials, and rarely one that nothing else has.
    pub(super) fn traits(&mut self) -> MaterialTraits {
        let mut traits = MaterialTraits::default();
        match self.random.below(8) {
            0 => traits.rolling = 0.05,
            1 => (traits.rolling, traits.spinning) = (0.1, self.random.between(0.0, 0.1)),
            2 => traits.surface_velocity = Vec3::new(1.5, 0.0, -0.5),
            3 => traits.one_way = Some(Vec3::Z),
            4 => traits.friction_mix = [Mix::Min, Mix::Max, Mix::Mean][self.random.below(3) as usize],
            5 => traits.restitution_mix = Mix::Multiply,
            _ => {}
        }
        traits
    }

    fn pair_material(&mut self) -> PairMaterial {
        PairMaterial {
            friction: (self.random.below(2) == 0).then(|| self.random.between(0.0, 1.5)),
            restitution: (self.random.below(2) == 0).then(|| self.random.between(0.0, 1.0)),
        }
    }
}
