//! The dial: four named settings between the cheapest and the most exact.

use super::{ContactModel, FrictionModel, REFINE, REFINE_SINK, Settings};

/// A place on the dial that trades speed for accuracy. What each one costs and how exact it is stands in the
/// README, measured.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Preset {
    /// For what is looked at from afar: two substeps.
    Fast,
    /// The default.
    #[default]
    Balanced,
    /// Twice the substeps: everything sinks a quarter as far, and ten thousand times heavier bodies stand on light
    /// ones.
    Accurate,
    /// For reference, and for the tallest stacks: four times the substeps.
    Exact,
}

impl Preset {
    /// All of them, the cheapest first.
    pub const ALL: [Self; 4] = [Self::Fast, Self::Balanced, Self::Accurate, Self::Exact];

    /// Its name in scene files and on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Fast => "fast",
            Self::Balanced => "balanced",
            Self::Accurate => "accurate",
            Self::Exact => "exact",
        }
    }

    /// The preset with a name; `None` when no preset has it.
    pub fn find(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|preset| preset.name() == name)
    }

    /// The preset at which the dial of some settings stands; `None` when it stands between two or beside them.
    pub fn of(settings: &Settings) -> Option<Self> {
        Self::ALL.into_iter().find(|preset| {
            let mut turned = *settings;
            preset.apply(&mut turned);
            turned == *settings
        })
    }

    /// Turns the dial of some settings: the fields that trade speed for accuracy, and no other.
    pub fn apply(self, settings: &mut Settings) {
        let (substeps, refine, refine_sink) = match self {
            Self::Fast => (2, 1, REFINE_SINK),
            Self::Balanced => (4, REFINE, REFINE_SINK),
            Self::Accurate => (8, REFINE, REFINE_SINK / 2.0),
            Self::Exact => (16, REFINE, REFINE_SINK / 4.0),
        };
        *settings = Settings {
            substeps,
            contact_model: ContactModel::Soft,
            friction_model: FrictionModel::Patch,
            manifold_drift: super::MANIFOLD_DRIFT,
            sweeps: 1,
            relax_sweeps: 1,
            inner_sweeps: 1,
            direct_joints: true,
            refine,
            refine_bodies: super::REFINE_BODIES,
            refine_sink,
            contact_frequency: 0.0,
            contact_damping_ratio: super::CONTACT_DAMPING_RATIO,
            ..*settings
        };
    }
}

impl From<Preset> for Settings {
    /// The default settings with the dial turned to the preset.
    fn from(preset: Preset) -> Self {
        let mut settings = Self::default();
        preset.apply(&mut settings);
        settings
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn balanced_is_the_default() {
        assert_eq!(Settings::from(Preset::default()), Settings::default());
    }

    #[test]
    fn presets_leave_the_rest_alone() {
        let mut settings = Settings { dt: 0.01, sleep_time: 0.5, push_speed: 1.0, ..Settings::default() };
        for preset in Preset::ALL {
            preset.apply(&mut settings);
            assert_eq!((settings.dt, settings.sleep_time, settings.push_speed), (0.01, 0.5, 1.0));
            assert_eq!(settings.check(), Ok(()));
        }
    }

    #[test]
    fn presets_are_found_by_name_and_in_settings() {
        let mut settings = Settings { dt: 0.01, ..Settings::default() };
        for preset in Preset::ALL {
            preset.apply(&mut settings);
            assert_eq!((Preset::find(preset.name()), Preset::of(&settings)), (Some(preset), Some(preset)));
        }
        settings.inner_sweeps += 1;
        assert_eq!((Preset::find("Exact"), Preset::of(&settings)), (None, None));
    }
}
