//! A machine that computes one bit otherwise.

use super::peer::Fault;
use cellstep::{BodyHandle, Memory, World};

/// One bit of a body's linear velocity, flipped in the state after a step.
#[derive(Clone, Copy, Debug)]
pub struct Flip {
    /// The step.
    pub frame: u64,
    /// The body.
    pub body: BodyHandle,
    /// Which bit: those of the mantissa are 0 to 22.
    pub bit: u32,
}

impl Flip {
    /// The machine does so each time that it takes the step.
    pub fn fault(self) -> Fault {
        Box::new(move |world| {
            if world.steps() == self.frame {
                self.plant(world);
            }
        })
    }

    /// Flips the bit.
    pub fn plant(&self, world: &mut World<Memory>) {
        let mut velocity = world.linear_velocity(self.body).expect("it lives");
        velocity.y = f32::from_bits(velocity.y.to_bits() ^ 1 << self.bit);
        world.set_linear_velocity(self.body, velocity).expect("it is still a small number");
    }
}
