//! What `cellstep run` tells, as a JSON object and as a table.

use cellstep::Preset;
use cellstep::scene::format::{ContactModelDoc, FrictionModelDoc, SettingsDoc};
use serde::Serialize;
use std::fmt::{self, Display};

/// The outcome of a run. The names of the fields are the keys of the JSON object.
#[derive(Debug, Serialize)]
pub struct Report {
    /// The scene as it was named.
    pub scene: String,
    /// Steps made.
    pub steps: u32,
    /// Threads.
    pub workers: usize,
    /// Substeps of a step.
    pub substeps: u32,
    /// Where the dial between speed and accuracy stands, as a scene file would say it.
    pub settings: SettingsDoc,
    /// Bodies at the end.
    pub bodies: usize,
    /// Bodies that are asleep at the end.
    pub asleep: usize,
    /// Joints at the end.
    pub joints: u32,
    /// Pairs of boxes in the last step.
    pub pairs: u32,
    /// Contacts in the last step.
    pub contacts: u32,
    /// Phases of the last step's ordering.
    pub phases: u32,
    /// Blocks of the last step's ordering.
    pub blocks: u32,
    /// Barriers, mean of the steps.
    pub barriers_per_step: f64,
    /// What did not fit into the capacities, in all steps.
    pub dropped: u64,
    /// Bodies stopped because they became non-finite, in all steps.
    pub quarantined: u64,
    /// Bytes of a snapshot at the end.
    pub state_bytes: usize,
    /// Checksum of the state at the end, 16 hexadecimal digits: JSON numbers do not hold 64 bits everywhere.
    pub checksum: String,
    /// Wall-clock time of a step, milliseconds, mean.
    pub ms_per_step: f64,
    /// The same by stage.
    pub stage_ms: StageMs,
    /// Deepest overlap at the end, metres.
    pub penetration_max: f32,
}

/// Wall-clock time of each stage of a step, milliseconds, mean.
#[derive(Debug, Serialize)]
pub struct StageMs {
    /// Candidate pairs.
    pub broadphase: f64,
    /// Contact points.
    pub narrowphase: f64,
    /// Connected groups.
    pub islands: f64,
    /// Cellular ordering.
    pub ordering: f64,
    /// Rows.
    pub assembly: f64,
    /// Sweeps and integration.
    pub solve: f64,
    /// Results written back.
    pub finish: f64,
    /// The part of the whole step that runs on one thread; it is contained in the stages.
    pub serial: f64,
}

impl Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut row = |name: &str, value: &dyn Display| writeln!(f, "{name:<20} {value:>16}");
        row("scene", &self.scene)?;
        row("steps", &self.steps)?;
        row("workers", &self.workers)?;
        let preset = self.settings.preset.map_or("none", |preset| Preset::from(preset).name());
        row("preset", &preset)?;
        row("substeps", &self.substeps)?;
        row("refine", &self.settings.refine.unwrap_or(1))?;
        row("sweeps", &sweeps(&self.settings))?;
        row("contact model", &self.settings.contact_model.map_or("", model_name))?;
        row("friction model", &self.settings.friction_model.map_or("", friction_name))?;
        let drift = f64::from(self.settings.manifold_drift.unwrap_or_default());
        row("manifold drift, mm", &format!("{:.3}", drift * 1.0e3))?;
        row("bodies", &self.bodies)?;
        row("asleep", &self.asleep)?;
        row("joints", &self.joints)?;
        row("pairs", &self.pairs)?;
        row("contacts", &self.contacts)?;
        row("phases", &self.phases)?;
        row("blocks", &self.blocks)?;
        row("barriers per step", &format!("{:.1}", self.barriers_per_step))?;
        row("dropped", &self.dropped)?;
        row("quarantined", &self.quarantined)?;
        row("state bytes", &self.state_bytes)?;
        row("penetration, mm", &format!("{:.3}", self.penetration_max * 1.0e3))?;
        row("checksum", &self.checksum)?;
        row("", &"ms per step")?;
        let stages = &self.stage_ms;
        let times = [
            ("broadphase", stages.broadphase),
            ("narrowphase", stages.narrowphase),
            ("islands", stages.islands),
            ("ordering", stages.ordering),
            ("assembly", stages.assembly),
            ("solve", stages.solve),
            ("finish", stages.finish),
            ("whole step", self.ms_per_step),
            ("of it on one thread", stages.serial),
        ];
        times.into_iter().try_for_each(|(name, ms)| row(name, &format!("{ms:.3}")))
    }
}

/// The name of a friction model in scene files.
fn friction_name(model: FrictionModelDoc) -> &'static str {
    match model {
        FrictionModelDoc::Patch => "patch",
        FrictionModelDoc::Points => "points",
    }
}

/// Biased, relax and inner sweeps.
pub fn sweeps(settings: &SettingsDoc) -> String {
    let count = |sweeps: Option<u32>| sweeps.unwrap_or_default();
    let (biased, relax) = (count(settings.sweeps), count(settings.relax_sweeps));
    format!("{biased} + {relax} x {}", count(settings.inner_sweeps))
}

/// Its name in scene files.
pub fn model_name(model: ContactModelDoc) -> &'static str {
    match model {
        ContactModelDoc::Soft => "soft",
        ContactModelDoc::Rigid => "rigid",
        ContactModelDoc::Split => "split",
    }
}
