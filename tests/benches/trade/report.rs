//! What is written to files: all numbers as CSV, and the part of the README between the markers.

use crate::engine::ENGINES;
use crate::measure::{Measured, Outcome};
use crate::table::{all_costs, both, number, sum_up, verdicts};
use cellstep::Preset;
use cellstep_tests::trade::{between_markers, csv_line};
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// Around what this bench writes into the README.
pub const MARKERS: [&str; 2] = ["<!-- trade: begin, written by the bench `trade` -->", "<!-- trade: end -->"];
/// The command that writes it.
const COMMAND: &str = "cargo bench -p cellstep-tests --features peers --bench trade -- --write docs/trade";

/// A line for each configuration and error.
pub fn write_csv(folder: &Path, all: &[Outcome]) -> PathBuf {
    let heads =
        ["scene", "engine", "configuration", "settings", "ns_per_body_second", "error", "unit", "value"];
    let mut text = csv_line(&heads.map(str::to_string));
    for outcome in all {
        for measured in &outcome.all {
            for axis in &measured.errors {
                text += &csv_line(&[
                    outcome.scene.name.to_string(),
                    measured.engine.to_string(),
                    measured.name.clone(),
                    measured.settings.clone(),
                    format!("{:.0}", measured.cost),
                    axis.name.to_string(),
                    axis.unit.to_string(),
                    format!("{:.4e}", axis.value),
                ]);
            }
        }
    }
    let path = folder.join("trade.csv");
    std::fs::write(&path, text).expect("the folder can be written");
    path
}

/// Puts plot, tables and verdicts between the markers of a README whose folder holds `plots`.
pub fn write_readme(readme: &Path, plots: &str, all: &[Outcome]) {
    let old = std::fs::read_to_string(readme).expect("the README is there");
    let new = between_markers(&old, MARKERS, &section(plots, all)).expect("the README has the markers once");
    std::fs::write(readme, new).expect("the README can be written");
}

fn section(plots: &str, all: &[Outcome]) -> String {
    let link = |outcome: &Outcome| {
        let name = outcome.scene.name;
        format!("[{name}]({plots}/{name}.svg)")
    };
    let links: Vec<String> = all.iter().map(link).collect();
    let mut text = format!(
        "`{COMMAND}`
writes this part from one run: cost against error of every preset, of a sweep of each knob, and of other engines
at default and at swept settings, on one thread, sleep off, f32. Lines are frontiers, rings are presets. All
settings, and all errors beside the headline, are in a CSV, written below the target folder. By scene:
{}.

![cost against error]({plots}/overview.svg)

",
        links.join(",\n")
    );
    preset_table(&mut text, all);
    scene_list(&mut text, all);
    for peer in &ENGINES[1..] {
        let verdicts = verdicts(all, peer);
        let [every, shared] = [sum_up(&verdicts, all_costs), sum_up(&verdicts, both)];
        let ratio =
            |worst: f64| if worst.is_finite() { format!("{worst:.2}") } else { "infinite".to_string() };
        let words = format!(
            "\nAgainst {peer}, each with the best that it gives within a cost: the error is lower at every cost \
             between its\ncheapest and its dearest setting on {} of {} scenes, worst ratio {} (`{}`); at those of \
             these costs that both\noffer, on {}, worst ratio {} (`{}`).",
            every.ahead,
            every.count,
            ratio(every.worst),
            every.scene,
            shared.ahead,
            ratio(shared.worst),
            shared.scene
        );
        writeln!(text, "{words}").expect("strings grow");
    }
    text
}

/// Costs and errors of the presets, and of the peers' defaults.
fn preset_table(text: &mut String, all: &[Outcome]) {
    type Wanted = Box<dyn Fn(&Measured) -> bool>;
    let mut columns: Vec<(String, Wanted)> = Vec::new();
    for preset in Preset::ALL {
        columns.push((format!("`{}`", preset.name()), Box::new(move |m| m.preset == Some(preset))));
    }
    for peer in &ENGINES[1..] {
        columns.push((format!("{peer}, default"), Box::new(move |m| m.engine == *peer && m.is_default)));
    }
    let heads: Vec<&str> = columns.iter().map(|column| column.0.as_str()).collect();
    writeln!(text, "| scene: ns per body and simulated second; error | {} |", heads.join(" | "))
        .expect("grows");
    writeln!(text, "|---{}|", "|---".repeat(columns.len())).expect("grows");
    for outcome in all {
        let cell = |(_, wanted): &(String, Wanted)| {
            let found = outcome.all.iter().find(|measured| wanted(measured));
            found.map_or("-".to_string(), |m| format!("{:.0}; {}", m.cost, number(m.errors[0].value)))
        };
        let cells: Vec<String> = columns.iter().map(cell).collect();
        writeln!(text, "| {} | {} |", outcome.scene.name, cells.join(" | ")).expect("grows");
    }
}

/// What the errors are.
fn scene_list(text: &mut String, all: &[Outcome]) {
    writeln!(text, "\nErrors:\n").expect("grows");
    for outcome in all {
        writeln!(text, "- {}: {}", outcome.scene.name, outcome.scene.headline).expect("grows");
    }
}
