//! Settings of a scene document.

use cellstep_core::{ContactModel, FrictionModel, Preset, Settings};
use serde::{Deserialize, Serialize};

/// The fields of [`Settings`] that a scene may change. `None` keeps the engine's default.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, expecting = "an object of settings")]
pub struct SettingsDoc {
    /// A place on the dial between speed and accuracy. It is set first: fields beside it change what it sets.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub preset: Option<PresetDoc>,
    /// Length of a step, seconds, greater than 0.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub dt: Option<f32>,
    /// Substeps of a step, at least 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub substeps: Option<u32>,
    /// Biased sweeps of a substep, at least 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sweeps: Option<u32>,
    /// Residual at which the biased sweeps of a substep end, m/s; 0 for as many as `sweeps` says.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tolerance: Option<f32>,
    /// Most biased sweeps of a substep where there is a tolerance.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sweeps_max: Option<u32>,
    /// Sweeps without bias at the end of a substep.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub relax_sweeps: Option<u32>,
    /// Visits of each block in a sweep, at least 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub inner_sweeps: Option<u32>,
    /// Whether joints that hang together are held at once, instead of one by one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub direct_joints: Option<bool>,
    /// How a contact removes overlap.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub contact_model: Option<ContactModelDoc>,
    /// What bounds the friction of a contact of several points.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub friction_model: Option<FrictionModelDoc>,
    /// How far boxes and hulls may move against each other until their points of contact are found anew, metres; 0
    /// for in each step.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub manifold_drift: Option<f32>,
    /// Natural frequency of a soft contact, Hz; 0 follows the substep rate.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub contact_frequency: Option<f32>,
    /// Damping of a contact as a multiple of the critical damping.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub contact_damping_ratio: Option<f32>,
    /// Greatest speed at which overlap is pushed out, m/s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub push_speed: Option<f32>,
    /// How many times the substeps small islands under great load get; 1 for no island.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub refine: Option<u32>,
    /// Most dynamic bodies of such an island.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub refine_bodies: Option<u32>,
    /// Sink of a soft contact from which on its island is refined, metres.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub refine_sink: Option<f32>,
    /// Slower approaches do not bounce, m/s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub restitution_threshold: Option<f32>,
    /// Links of a block of the cellular ordering.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub block_links: Option<u32>,
    /// Seconds of rest until an island falls asleep; 0 for never.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sleep_time: Option<f32>,
    /// Slower bodies are at rest, m/s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sleep_speed: Option<f32>,
    /// Whether fast bodies are stopped at what they would pass.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub continuous: Option<bool>,
    /// Whether steps measure how far their solve is from the answer.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub residual: Option<bool>,
}

/// A place on the dial between speed and accuracy.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum PresetDoc {
    /// The cheapest.
    Fast,
    /// The default.
    Balanced,
    /// More substeps.
    Accurate,
    /// For reference.
    Exact,
}

impl From<PresetDoc> for Preset {
    fn from(preset: PresetDoc) -> Self {
        match preset {
            PresetDoc::Fast => Preset::Fast,
            PresetDoc::Balanced => Preset::Balanced,
            PresetDoc::Accurate => Preset::Accurate,
            PresetDoc::Exact => Preset::Exact,
        }
    }
}

impl From<Preset> for PresetDoc {
    fn from(preset: Preset) -> Self {
        match preset {
            Preset::Fast => PresetDoc::Fast,
            Preset::Balanced => PresetDoc::Balanced,
            Preset::Accurate => PresetDoc::Accurate,
            Preset::Exact => PresetDoc::Exact,
        }
    }
}

/// How a contact removes overlap.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ContactModelDoc {
    /// A damped spring.
    Soft,
    /// A share of the overlap per substep.
    Rigid,
    /// Rigid loads; overlap is moved away.
    Split,
}

/// What bounds the friction of a contact of several points.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FrictionModelDoc {
    /// All points together.
    Patch,
    /// Each point by its own load.
    Points,
}

impl From<FrictionModelDoc> for FrictionModel {
    fn from(model: FrictionModelDoc) -> Self {
        match model {
            FrictionModelDoc::Patch => FrictionModel::Patch,
            FrictionModelDoc::Points => FrictionModel::Points,
        }
    }
}

impl From<FrictionModel> for FrictionModelDoc {
    fn from(model: FrictionModel) -> Self {
        match model {
            FrictionModel::Patch => FrictionModelDoc::Patch,
            FrictionModel::Points => FrictionModelDoc::Points,
        }
    }
}

impl From<ContactModelDoc> for ContactModel {
    fn from(model: ContactModelDoc) -> Self {
        match model {
            ContactModelDoc::Soft => ContactModel::Soft,
            ContactModelDoc::Rigid => ContactModel::Rigid,
            ContactModelDoc::Split => ContactModel::Split,
        }
    }
}

impl From<ContactModel> for ContactModelDoc {
    fn from(model: ContactModel) -> Self {
        match model {
            ContactModel::Soft => ContactModelDoc::Soft,
            ContactModel::Rigid => ContactModelDoc::Rigid,
            ContactModel::Split => ContactModelDoc::Split,
        }
    }
}

impl SettingsDoc {
    /// The fields on the dial between speed and accuracy, all of them written out, and the preset that they are
    /// if they are one.
    pub fn dial(settings: &Settings) -> Self {
        Self {
            preset: Preset::of(settings).map(Into::into),
            substeps: Some(settings.substeps),
            sweeps: Some(settings.sweeps),
            relax_sweeps: Some(settings.relax_sweeps),
            inner_sweeps: Some(settings.inner_sweeps),
            direct_joints: Some(settings.direct_joints),
            contact_model: Some(settings.contact_model.into()),
            friction_model: Some(settings.friction_model.into()),
            manifold_drift: Some(settings.manifold_drift),
            contact_frequency: Some(settings.contact_frequency),
            contact_damping_ratio: Some(settings.contact_damping_ratio),
            refine: Some(settings.refine),
            refine_bodies: Some(settings.refine_bodies),
            refine_sink: Some(settings.refine_sink),
            ..Self::default()
        }
    }

    /// Writes what this document changes: what the preset sets, then what the other fields say.
    pub fn apply(&self, settings: &mut Settings) {
        if let Some(preset) = self.preset {
            Preset::from(preset).apply(settings);
        }
        set(&mut settings.dt, self.dt);
        set(&mut settings.substeps, self.substeps);
        set(&mut settings.sweeps, self.sweeps);
        set(&mut settings.tolerance, self.tolerance);
        set(&mut settings.sweeps_max, self.sweeps_max);
        set(&mut settings.relax_sweeps, self.relax_sweeps);
        set(&mut settings.inner_sweeps, self.inner_sweeps);
        set(&mut settings.direct_joints, self.direct_joints);
        set(&mut settings.contact_model, self.contact_model.map(Into::into));
        set(&mut settings.friction_model, self.friction_model.map(Into::into));
        set(&mut settings.manifold_drift, self.manifold_drift);
        set(&mut settings.contact_frequency, self.contact_frequency);
        set(&mut settings.contact_damping_ratio, self.contact_damping_ratio);
        set(&mut settings.push_speed, self.push_speed);
        set(&mut settings.refine, self.refine);
        set(&mut settings.refine_bodies, self.refine_bodies);
        set(&mut settings.refine_sink, self.refine_sink);
        set(&mut settings.restitution_threshold, self.restitution_threshold);
        set(&mut settings.block_links, self.block_links);
        set(&mut settings.sleep_time, self.sleep_time);
        set(&mut settings.sleep_speed, self.sleep_speed);
        set(&mut settings.continuous, self.continuous);
        set(&mut settings.residual, self.residual);
    }
}

fn set<T>(field: &mut T, value: Option<T>) {
    if let Some(value) = value {
        *field = value;
    }
}
