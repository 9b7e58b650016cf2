//! What `cellstep tune` tells: a line for each setting, the frontier, and the one to take.

use crate::report::{model_name, sweeps};
use cellstep::scene::format::SettingsDoc;
use serde::Serialize;
use std::fmt::{self, Display};

/// What is asked for.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Goal {
    /// The most exact setting whose step takes at most so long, milliseconds.
    BudgetMs(f64),
    /// The cheapest setting whose error is at most so great, metres.
    MaxError(f64),
}

/// A setting that was tried. The names of the fields are the keys of the JSON object; lengths are metres.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Line {
    /// The preset's name, `scene`, or what differs from a preset.
    pub name: String,
    /// Where the dial stands.
    pub settings: SettingsDoc,
    /// Wall-clock time of a step, milliseconds, median.
    pub ms_per_step: f64,
    /// The headline: the greatest of `penetration_p99`, `joint_gap_p99` and `height_error`; none when bodies were
    /// lost.
    pub error: Option<f64>,
    /// Overlap that 99 of a hundred overlapping points of contact do not exceed.
    pub penetration_p99: f64,
    /// Deepest overlap.
    pub penetration_max: f64,
    /// The same of the gaps of joints.
    pub joint_gap_p99: f64,
    /// Widest gap of a joint.
    pub joint_gap_max: f64,
    /// How differently high the bodies lie in the reference, while references agree, less what they differ by.
    pub height_error: f64,
    /// Root of the mean square of the speeds over the last quarter, m/s: jitter where all should rest.
    pub speed: f64,
    /// Greatest distance of the bodies to where the reference has them, while references agree.
    pub distance: f64,
    /// Bodies that were stopped because they became non-finite.
    pub quarantined: u64,
    /// No other setting is both cheaper and more exact.
    pub on_frontier: bool,
}

/// With what the settings are compared.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Reference {
    /// Substeps of the reference.
    pub substeps: u32,
    /// Substeps of the run that the reference is compared with.
    pub compared_with: u32,
    /// Steps for which these two agree to a millimetre, body by body.
    pub comparable_steps: u32,
    /// How differently high the bodies of the two lie, metres.
    pub height_spread: f64,
}

/// The answer.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Report {
    /// The scene as it was named.
    pub scene: String,
    /// Steps of each run.
    pub steps: u32,
    /// Threads.
    pub workers: usize,
    /// Bodies at the start.
    pub bodies: usize,
    /// Joints at the start.
    pub joints: u32,
    /// What is asked for.
    pub goal: Goal,
    /// With what is compared.
    pub reference: Reference,
    /// All that was tried, the cheapest first.
    pub settings: Vec<Line>,
    /// The one to take, if any meets the goal.
    pub recommended: Option<Recommended>,
    /// By what factor the nearest one misses the goal, when none meets it.
    pub missed_by: Option<f64>,
    /// The name of that one.
    pub nearest: Option<String>,
}

/// The setting to take.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Recommended {
    /// Its name.
    pub name: String,
    /// What the scene file has to say.
    pub settings: SettingsDoc,
}

/// Puts the lines in order, the cheapest first, and marks the frontier.
pub fn rank(lines: &mut [Line]) {
    lines.sort_by(|a, b| a.ms_per_step.total_cmp(&b.ms_per_step));
    let mut least = f64::INFINITY;
    for line in lines {
        let error = line.error.unwrap_or(f64::INFINITY);
        line.on_frontier = error < least;
        least = least.min(error);
    }
}

/// The line to take, by index; or the nearest one and by what factor it misses the goal. `None` when no setting
/// kept its bodies. Lines are in the order of [`rank`].
pub fn choose(lines: &[Line], goal: Goal) -> Option<Result<usize, (usize, f64)>> {
    let sound = || lines.iter().enumerate().filter_map(|(index, line)| Some((index, line, line.error?)));
    match goal {
        Goal::MaxError(most) => {
            if let Some((index, ..)) = sound().find(|&(.., error)| error <= most) {
                return Some(Ok(index));
            }
            let (index, _, error) = sound().min_by(|a, b| a.2.total_cmp(&b.2))?;
            Some(Err((index, error / most)))
        }
        Goal::BudgetMs(most) => {
            let within = sound().filter(|(_, line, _)| line.ms_per_step <= most);
            if let Some((index, ..)) = within.min_by(|a, b| a.2.total_cmp(&b.2)) {
                return Some(Ok(index));
            }
            let (index, line, _) = sound().next()?;
            Some(Err((index, line.ms_per_step / most)))
        }
    }
}

impl Display for Goal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Goal::BudgetMs(ms) => write!(f, "--budget-ms {ms}"),
            Goal::MaxError(error) => write!(f, "--max-error {error}"),
        }
    }
}

/// Millimetres in four digits or so.
fn millimetres(metres: f64) -> String {
    let mm = metres * 1.0e3;
    if mm != 0.0 && !(1.0e-3..1.0e5).contains(&mm) { format!("{mm:.2e}") } else { format!("{mm:.3}") }
}

impl Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (reference, plural) = (&self.reference, if self.workers == 1 { "" } else { "s" });
        writeln!(
            f,
            "{}: {} bodies, {} joints, {} steps, {} worker{plural}",
            self.scene, self.bodies, self.joints, self.steps, self.workers
        )?;
        writeln!(
            f,
            "reference: exact with {} substeps; agrees with {} substeps for {} steps\n",
            reference.substeps, reference.compared_with, reference.comparable_steps
        )?;
        writeln!(
            f,
            "  {:<20} {:<6} {:>8} {:>6} {:>9} {:>9} {:>9} | {:>9} {:>9} {:>9} {:>9} | {:>9} {:>9}",
            "setting",
            "model",
            "substeps",
            "refine",
            "sweeps",
            "ms/step",
            "error, mm",
            "p99, mm",
            "max, mm",
            "gap, mm",
            "height,mm",
            "way, mm",
            "mm/s"
        )?;
        for line in &self.settings {
            let error = line.error.map_or("lost".to_string(), millimetres);
            writeln!(
                f,
                "{} {:<20} {:<6} {:>8} {:>6} {:>9} {:>9.3} {:>9} | {:>9} {:>9} {:>9} {:>9} | {:>9} {:>9}",
                if line.on_frontier { '*' } else { ' ' },
                line.name,
                line.settings.contact_model.map_or("", model_name),
                line.settings.substeps.unwrap_or_default(),
                line.settings.refine.unwrap_or(1),
                sweeps(&line.settings),
                line.ms_per_step,
                error,
                millimetres(line.penetration_p99),
                millimetres(line.penetration_max),
                millimetres(line.joint_gap_p99),
                millimetres(line.height_error),
                millimetres(line.distance),
                millimetres(line.speed),
            )?;
        }
        writeln!(f, "\n* on the frontier: nothing cheaper is as exact")?;
        if let Some(recommended) = &self.recommended {
            let fragment = serde_json::to_string(&recommended.settings).map_err(|_| fmt::Error)?;
            let name = &recommended.name;
            return write!(f, "recommended for {}: {name}\n\"settings\": {fragment}\n", self.goal);
        }
        match (&self.nearest, self.missed_by) {
            (Some(name), Some(factor)) => {
                writeln!(
                    f,
                    "no setting meets {}: the nearest is {name}, {factor:.3} times as much",
                    self.goal
                )
            }
            _ => writeln!(f, "no setting meets {}: all of them lose bodies", self.goal),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(ms_per_step: f64, error: Option<f64>) -> Line {
        Line {
            name: format!("{ms_per_step}"),
            settings: SettingsDoc::default(),
            ms_per_step,
            error,
            penetration_p99: 0.0,
            penetration_max: 0.0,
            joint_gap_p99: 0.0,
            joint_gap_max: 0.0,
            height_error: 0.0,
            speed: 0.0,
            distance: 0.0,
            quarantined: 0,
            on_frontier: false,
        }
    }

    #[test]
    fn the_frontier_is_what_nothing_cheaper_beats() {
        let mut lines = [line(3.0, Some(0.2)), line(1.0, None), line(2.0, Some(0.3)), line(4.0, Some(0.2))];
        rank(&mut lines);
        let found = lines.each_ref().map(|line| (line.ms_per_step, line.on_frontier));
        assert_eq!(found, [(1.0, false), (2.0, true), (3.0, true), (4.0, false)]);
    }

    #[test]
    fn the_cheapest_that_is_exact_enough_and_the_most_exact_that_is_cheap_enough() {
        let lines = [line(1.0, None), line(2.0, Some(0.3)), line(3.0, Some(0.2)), line(4.0, Some(0.1))];
        assert_eq!(choose(&lines, Goal::MaxError(0.25)), Some(Ok(2)));
        assert_eq!(choose(&lines, Goal::MaxError(0.3)), Some(Ok(1)));
        assert_eq!(choose(&lines, Goal::MaxError(0.05)), Some(Err((3, 2.0))));
        assert_eq!(choose(&lines, Goal::BudgetMs(3.5)), Some(Ok(2)));
        assert_eq!(choose(&lines, Goal::BudgetMs(0.5)), Some(Err((1, 4.0))));
        assert_eq!(choose(&lines[..1], Goal::BudgetMs(9.0)), None);
    }

    #[test]
    fn lengths_are_told_in_millimetres() {
        assert_eq!([0.0, 0.0123, 1.0e-8, 1.0e6].map(millimetres), ["0.000", "12.300", "1.00e-5", "1.00e9"]);
    }
}
