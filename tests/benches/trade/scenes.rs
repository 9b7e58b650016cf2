//! The twelve scenes.

mod free;
mod joined;
mod loaded;
mod piled;
mod smooth;

use crate::scene::Scene;

/// All of them, in the order of the tables.
pub fn all() -> Vec<Scene> {
    vec![
        free::tumbling(),
        free::top(),
        joined::pendula(),
        joined::chain(),
        joined::loops(),
        smooth::slide_and_roll(),
        smooth::bounce(),
        piled::balls(),
        loaded::columns(),
        loaded::structures(),
        piled::pile(),
        smooth::far(),
    ]
}

/// Root of the mean square that is collected one by one.
#[derive(Clone, Copy, Default)]
struct Rms {
    sum: f64,
    count: f64,
}

impl Rms {
    fn add(&mut self, value: f64) {
        self.sum += value * value;
        self.count += 1.0;
    }

    fn value(&self) -> f64 {
        (self.sum / self.count.max(1.0)).sqrt()
    }
}

/// Mean; 0 for nothing.
fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0);
    for value in values {
        sum += value;
        count += 1.0;
    }
    if count > 0.0 { sum / count } else { 0.0 }
}

/// The greatest; what is not a number counts as infinite.
fn most(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(0.0, |most, value| {
        if value <= most {
            most
        } else if value.is_nan() {
            f64::INFINITY
        } else {
            value
        }
    })
}
