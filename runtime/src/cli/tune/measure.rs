//! What a run of a scene tells of its settings: the time of a step, and errors that need no closed form.

use super::dial::Place;
use cellstep::joint::AxisMotion;
use cellstep::math::Vec3;
use cellstep::{BodyHandle, BodyKind, Coupling, Executor, JointDef, JointHandle, Memory, Settings, World};
use std::time::Instant;

/// Errors are measured every so many steps, and after the last one.
const SAMPLE: u32 = 4;
/// Bodies whose ways are compared; of more, as many of them evenly.
const FOLLOWED: usize = 1024;
/// Two runs are comparable as long as the bodies of two references are not farther apart than this, metres.
const COMPARABLE: f64 = 1.0e-3;

/// How often lengths were met, in classes of less than 2 % of them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Lengths {
    /// By the upper half of the bits of a length as f32.
    classes: Vec<u64>,
    count: u64,
    /// The greatest one, metres.
    pub max: f32,
}

impl Lengths {
    /// Bits of a length that make no class of their own: 6 of the mantissa are left.
    const DROPPED: u32 = 17;

    /// Counts a length; one that is not positive is none.
    pub fn add(&mut self, length: f32) {
        if length.is_nan() || length <= 0.0 {
            return;
        }
        let class = (length.to_bits() >> Self::DROPPED) as usize;
        if self.classes.len() <= class {
            self.classes.resize(class + 1, 0);
        }
        self.classes[class] += 1;
        self.count += 1;
        if length > self.max {
            self.max = length;
        }
    }

    /// The length that 99 of a hundred do not exceed, metres, rounded up to its class; 0 without lengths.
    pub fn p99(&self) -> f32 {
        let beyond = self.count / 100;
        let mut above = 0;
        for (class, count) in self.classes.iter().enumerate().rev() {
            above += count;
            if above > beyond {
                let upper = f32::from_bits((class as u32 + 1) << Self::DROPPED);
                return if upper < self.max { upper } else { self.max };
            }
        }
        0.0
    }
}

/// A scene that can be run again and again.
pub struct Stage<'a, E> {
    pub world: &'a mut World<Memory>,
    /// Its first state.
    pub start: &'a [u8],
    pub executor: &'a mut E,
    pub steps: u32,
}

/// What was measured in a run.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Run {
    /// Wall-clock time of each step, milliseconds. Nothing else of a run depends on the machine.
    pub ms: Vec<f64>,
    /// Overlaps of all points of contact.
    pub penetration: Lengths,
    /// How far anchors of joints are from where they may be.
    pub gap: Lengths,
    /// Against gravity; zero without gravity.
    up: [f64; 3],
    /// Where the bodies that are followed were, metres, at each sample.
    places: Vec<Vec<[f64; 3]>>,
    /// Root of the mean square of the bodies' speeds over the last quarter, m/s.
    pub speed: f64,
    /// Bodies stopped because they became non-finite.
    pub quarantined: u64,
}

impl Run {
    /// Median time of a step, milliseconds.
    pub fn ms_per_step(&self) -> f64 {
        let mut sorted = self.ms.clone();
        sorted.sort_by(f64::total_cmp);
        sorted.get(sorted.len() / 2).copied().unwrap_or_default()
    }

    /// How differently high the bodies of two runs lie, metres, whichever body lies where: both lists of heights in
    /// order, place by place, what nine of ten places do not exceed; the greatest of the first samples. A body that
    /// gets lost moves each place by one, and makes little difference where there are many.
    pub fn height_error(&self, reference: &Run, samples: usize) -> f64 {
        let sorted = |run: &Run, sample: usize| {
            let height = |place: &[f64; 3]| place.iter().zip(run.up).map(|(x, up)| x * up).sum::<f64>();
            let mut heights: Vec<f64> = run.places[sample].iter().map(height).collect();
            heights.sort_by(f64::total_cmp);
            heights
        };
        let at = |sample: usize| {
            let (own, other) = (sorted(self, sample), sorted(reference, sample));
            let mut apart: Vec<f64> = own.iter().zip(other).map(|(own, other)| (own - other).abs()).collect();
            apart.sort_by(f64::total_cmp);
            let most = apart.len().saturating_sub(1) * 9 / 10;
            apart.get(most).copied().unwrap_or_default()
        };
        (0..samples).map(at).fold(0.0, f64::max)
    }

    /// The distance of the bodies to where they are in another run, metres, at a sample: root of the mean square.
    fn distance_at(&self, other: &Run, sample: usize) -> f64 {
        let (own, other) = (&self.places[sample], &other.places[sample]);
        let square = |(a, b): (&[f64; 3], &[f64; 3])| {
            (0..3).map(|axis| (a[axis] - b[axis]) * (a[axis] - b[axis])).sum::<f64>()
        };
        let sum: f64 = own.iter().zip(other).map(square).sum();
        if own.is_empty() { 0.0 } else { (sum / own.len() as f64).sqrt() }
    }

    /// Samples from the start for which this run and another one may be compared body by body.
    pub fn comparable(&self, other: &Run) -> usize {
        let parted = (0..self.places.len()).find(|&sample| self.distance_at(other, sample) > COMPARABLE);
        parted.unwrap_or(self.places.len())
    }

    /// The greatest distance to a reference in the first samples, metres.
    pub fn distance(&self, reference: &Run, samples: usize) -> f64 {
        (0..samples).map(|sample| self.distance_at(reference, sample)).fold(0.0, f64::max)
    }
}

/// The step after which a sample is taken.
pub fn step_of(sample: usize, steps: u32) -> u32 {
    steps.min((sample as u32 + 1) * SAMPLE)
}

impl<E: Executor> Stage<'_, E> {
    /// Runs the scene from its start with some settings. `told` hears of each step.
    pub fn run(&mut self, settings: &Settings, mut told: impl FnMut()) -> Result<Run, String> {
        let refused = |error: cellstep::Error| error.to_string();
        self.world.restore(self.start).map_err(refused)?;
        self.world.set_settings(settings).map_err(refused)?;
        let dynamic: Vec<BodyHandle> =
            (self.world.bodies()).filter(|&body| self.world.kind(body) == Ok(BodyKind::Dynamic)).collect();
        let stride = dynamic.len().div_ceil(FOLLOWED).max(1);
        let followed: Vec<BodyHandle> = dynamic.iter().step_by(stride).copied().collect();
        let mut run = Run { up: upward(settings.gravity), ..Run::default() };
        let (mut squares, mut counted) = (0.0, 0u64);
        for step in 1..=self.steps {
            let start = Instant::now();
            let report = self.world.step(self.executor);
            run.ms.push(start.elapsed().as_secs_f64() * 1.0e3);
            run.quarantined += u64::from(report.quarantined);
            if step % SAMPLE == 0 || step == self.steps {
                run.sample(self.world, &followed);
            }
            if 4 * step > 3 * self.steps {
                for &body in &dynamic {
                    let speed =
                        self.world.linear_velocity(body).unwrap_or_default().to_array().map(f64::from);
                    squares += speed.iter().map(|part| part * part).sum::<f64>();
                    counted += 1;
                }
            }
            told();
        }
        run.speed = if counted == 0 { 0.0 } else { (squares / counted as f64).sqrt() };
        Ok(run)
    }

    /// [`Stage::run`] for a place on the dial; errors name it.
    pub fn try_place(&mut self, place: &Place, told: impl FnMut()) -> Result<Run, String> {
        self.run(&place.settings, told).map_err(|error| format!("{}: {error}", place.name))
    }
}

/// Against gravity; zero without gravity.
fn upward(gravity: Vec3) -> [f64; 3] {
    let g = gravity.to_array().map(f64::from);
    let length = g.iter().map(|part| part * part).sum::<f64>().sqrt();
    if length == 0.0 { [0.0; 3] } else { g.map(|part| -part / length) }
}

impl Run {
    fn sample(&mut self, world: &World<Memory>, followed: &[BodyHandle]) {
        world.separations(|separation| self.penetration.add(-separation));
        for joint in world.joints() {
            if let Some(gap) = gap_of(world, joint) {
                self.gap.add(gap);
            }
        }
        let place = |body: &BodyHandle| world.center(*body).map_or([0.0; 3], |place| place.to_f64());
        self.places.push(followed.iter().map(place).collect());
    }
}

/// How far a joint's anchors are from where they may be, metres; `None` for one that gives, or is broken.
fn gap_of(world: &World<Memory>, joint: JointHandle) -> Option<f32> {
    let def = world.joint(joint).ok()?;
    if def.spring.is_some() || world.is_broken(joint).ok()? {
        return None;
    }
    Some(beyond(&def, world.joint_coordinates(joint).ok()?))
}

/// How far shifts are beyond what a joint allows, metres.
fn beyond(def: &JointDef, coordinates: [f32; 6]) -> f32 {
    let shifts = match def.coupling {
        Coupling::Frames => 3,
        Coupling::Distance => 1,
        _ => 0,
    };
    let axes = def.axes[..shifts].iter().zip(coordinates);
    let squares = axes.map(|(axis, x)| {
        let excess = match axis.motion {
            AxisMotion::Locked => x,
            AxisMotion::Limited { lower, upper } if axis.limit_spring.is_none() => {
                if x < lower {
                    lower - x
                } else if x > upper {
                    x - upper
                } else {
                    0.0
                }
            }
            _ => 0.0,
        };
        excess * excess
    });
    squares.sum::<f32>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use cellstep::Axis;
    use cellstep::math::Pose;

    #[test]
    fn one_in_a_hundred_is_above_the_p99() {
        let mut lengths = Lengths::default();
        assert_eq!((lengths.p99(), lengths.max), (0.0, 0.0));
        for length in [0.0, -1.0, f32::NAN] {
            lengths.add(length);
        }
        assert_eq!(lengths.p99(), 0.0);
        for i in 1..=1000 {
            lengths.add(i as f32 * 1.0e-3);
        }
        let p99 = lengths.p99();
        assert!((0.99..=0.99 * 1.02).contains(&p99) && lengths.max == 1.0, "{p99}");
        let mut one = Lengths::default();
        one.add(0.25);
        assert_eq!((one.p99(), one.max), (0.25, 0.25));
    }

    #[test]
    fn only_what_a_joint_forbids_is_a_gap() {
        let mut def = JointDef::slider([BodyHandle::default(); 2], [Pose::IDENTITY; 2]);
        def.axes[0] = Axis::limited(-1.0, 2.0);
        assert_eq!(beyond(&def, [1.5, 0.0, 0.0, 0.3, 0.0, 0.0]), 0.0);
        assert_eq!(beyond(&def, [5.0, 0.0, 4.0, 0.0, 0.0, 0.0]), 5.0);
        assert_eq!(beyond(&def, [-1.5, 0.0, 0.0, 0.0, 0.0, 0.0]), 0.5);
        let rope = JointDef::distance([BodyHandle::default(); 2], [Vec3::ZERO; 2], 0.0, 2.0);
        assert_eq!(beyond(&rope, [1.0, 9.0, 9.0, 0.0, 0.0, 0.0]), 0.0);
        assert_eq!(beyond(&rope, [2.5, 0.0, 0.0, 0.0, 0.0, 0.0]), 0.5);
    }

    #[test]
    fn a_fallen_stack_is_told_from_a_lost_body() {
        let run = |heights: &[f64]| Run {
            places: vec![heights.iter().map(|&z| [0.0, 0.0, z]).collect()],
            up: [0.0, 0.0, 1.0],
            ..Run::default()
        };
        let stack: Vec<f64> = (0..20).map(|i| f64::from(i) + 0.5).collect();
        let mut fallen = stack.clone();
        fallen[19] = 0.5;
        assert_eq!(run(&fallen).height_error(&run(&stack), 1), 1.0);
        let heap: Vec<f64> = (0..200).map(|i| f64::from(i) * 0.01).collect();
        let mut lost = heap.clone();
        lost[7] = -500.0;
        assert!(run(&lost).height_error(&run(&heap), 1) < 0.011);
        assert_eq!(run(&fallen).height_error(&run(&stack), 0), 0.0);
    }

    #[test]
    fn runs_are_compared_until_the_references_part() {
        let run = |xs: &[f64]| Run {
            places: xs.iter().map(|&x| vec![[x, 0.0, 0.0], [0.0, x, 0.0]]).collect(),
            up: [1.0, 0.0, 0.0],
            ..Run::default()
        };
        let (reference, other) = (run(&[0.0, 0.0, 0.0, 0.0]), run(&[0.0, 0.0005, 0.002, 0.0]));
        assert_eq!(reference.comparable(&other), 2);
        assert_eq!(reference.comparable(&reference), 4);
        let own = run(&[0.0, 0.25, 8.0, 1.0]);
        assert_eq!((own.distance(&reference, 2), own.distance(&reference, 0)), (0.25, 0.0));
        assert_eq!(own.distance(&reference, 3), 8.0);
        // Of two bodies the lower difference counts: that of the one that does not move up.
        assert_eq!(own.height_error(&reference, 3), 0.0);
        assert_eq!(upward(Vec3::new(0.0, 0.0, -9.81)), [0.0, 0.0, 1.0]);
        assert_eq!(upward(Vec3::ZERO), [0.0; 3]);
    }
}
