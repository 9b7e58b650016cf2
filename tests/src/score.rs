//! Scores: cases with a known answer, run at every preset, measured and held to what was measured before.
//!
//! A [`Case`] runs at each preset and writes its errors on a [`Sheet`]. Three things can be wrong with an error:
//!
//! - it is beyond its *gate*, the greatest that is acceptable, and `golden/scores.txt` does not say so (a case may
//!   have gates from some preset on only);
//! - it is worse than the file says by more than [`MARGIN`] of that, or [`FLOOR`] of its excellent mark
//!   where there is hardly any;
//! - it has no line in that file.
//!
//! Steps have the same bits on every machine, so an error is one exact number, and a change of it is a change of
//! behaviour. `UPDATE=1` writes a case anew and prints what is worse. What is beyond its gate then says so in the
//! file, so that what falls short of the marks stands in one place: those lines fail no test until they are worse.
//! The file is sorted, a line is `case | measure | preset | error | unit | mark`, errors have two digits.

use crate::jointed;
use crate::worlds::{self, OwnedWorld};
use cellstep::{BodyHandle, Capacities, Preset, Settings};
use std::collections::BTreeMap;
use std::fs::OpenOptions;
use std::io::{Read, Seek, Write};
use std::path::PathBuf;

/// By what share an error may exceed its golden value: what rounding to two digits takes away is half of that.
pub const MARGIN: f64 = 0.1;
/// The share of its excellent mark by which an error may exceed its golden value: rounding alone moves errors that
/// are far below the mark.
pub const FLOOR: f64 = 0.3;

/// The preset's column for a case with settings of its own.
const OWN: &str = "own";

/// A case with a known answer.
#[derive(Clone, Copy, Debug)]
pub struct Case {
    name: &'static str,
    gated_from: Preset,
}

/// A measured error.
#[derive(Clone, Debug)]
struct Line {
    error: f64,
    unit: String,
    /// `excellent`, `acceptable`, [`BEYOND`], or nothing without a gate.
    mark: String,
}

/// The mark of what is worse than its gate.
const BEYOND: &str = "beyond its gate";

/// What was measured, by case, measure and preset.
type Lines = BTreeMap<[String; 3], Line>;

impl Case {
    /// A case whose gates hold at every preset.
    pub fn new(name: &'static str) -> Self {
        assert!(!name.contains('|'), "the golden file is split there");
        Self { name, gated_from: Preset::Fast }
    }

    /// Its gates hold from this preset on; below it is scored alone.
    pub fn gated_from(self, preset: Preset) -> Self {
        Self { gated_from: preset, ..self }
    }

    /// Runs it at every preset.
    ///
    /// # Panics
    /// When an error is beyond its gate, or worse than before.
    pub fn run(self, measure: impl Fn(&mut Sheet)) {
        let sheets = Preset::ALL.map(|preset| {
            let mut sheet = Sheet::new(self, Some(preset));
            measure(&mut sheet);
            sheet
        });
        self.check(&sheets);
    }

    /// Runs it once, with the settings that it gives itself.
    ///
    /// # Panics
    /// When an error is beyond its gate, or worse than before.
    pub fn run_own(self, measure: impl FnOnce(&mut Sheet)) {
        let mut sheet = Sheet::new(self, None);
        measure(&mut sheet);
        self.check(&[sheet]);
    }

    fn check(self, sheets: &[Sheet]) {
        let found: Lines = sheets.iter().flat_map(|sheet| sheet.lines.clone()).collect();
        let excellent: BTreeMap<_, _> = sheets.iter().flat_map(|sheet| sheet.excellent.clone()).collect();
        if std::env::var_os("UPDATE").is_some_and(|value| value == "1") {
            renew(self.name, &found);
            return;
        }
        let golden = parse(&read());
        let mut worse = Vec::new();
        for (key, line) in &found {
            let (name, error, unit) = (key.join(", "), line.error, &line.unit);
            let Some(before) = golden.get(key) else {
                worse.push(format!("{name}: {error:.1e} {unit}, without a golden score"));
                continue;
            };
            let floor = FLOOR * excellent.get(key).copied().unwrap_or(0.0);
            if line.mark == BEYOND && before.mark != BEYOND {
                worse.push(format!("{name}: {error:.2e} {unit}, beyond its gate, was {:.1e}", before.error));
            } else if error > before.error * (1.0 + MARGIN) + floor {
                worse.push(format!("{name}: {error:.2e} {unit}, was {:.1e}", before.error));
            } else if error < before.error * (1.0 - MARGIN) - floor {
                println!("{name}: {error:.1e} {unit}, was {:.1e}: renew with UPDATE=1", before.error);
            }
        }
        let gone = golden.keys().filter(|key| key[0] == self.name && !found.contains_key(*key));
        worse.extend(gone.map(|key| format!("{}: not measured any more", key.join(", "))));
        assert!(
            worse.is_empty(),
            "scores fell (if that is meant: UPDATE=1, and say why):\n{}",
            worse.join("\n")
        );
    }
}

/// Where a case writes what it measures.
#[derive(Debug)]
pub struct Sheet {
    case: Case,
    preset: Option<Preset>,
    lines: Lines,
    excellent: BTreeMap<[String; 3], f64>,
}

impl Sheet {
    fn new(case: Case, preset: Option<Preset>) -> Self {
        Self { case, preset, lines: Lines::new(), excellent: BTreeMap::new() }
    }

    /// The preset that is measured; the default for a case with settings of its own.
    pub fn preset(&self) -> Preset {
        self.preset.unwrap_or_default()
    }

    /// The settings that are measured.
    pub fn settings(&self) -> Settings {
        Settings::from(self.preset())
    }

    /// Length of a substep, seconds, to double precision.
    pub fn substep(&self) -> f64 {
        1.0 / (60.0 * f64::from(self.settings().substeps))
    }

    /// An empty world for some bodies.
    pub fn world(&self, bodies: u32) -> OwnedWorld {
        self.world_with(Capacities::for_bodies(bodies))
    }

    /// An empty world.
    pub fn world_with(&self, capacities: Capacities) -> OwnedWorld {
        let mut world = worlds::world_with(capacities);
        world.set_settings(&self.settings()).expect("presets are in range");
        world
    }

    /// A world of some bodies and joints, and a static body at the origin.
    pub fn jointed(&self, bodies: u32, joints: u32) -> (OwnedWorld, BodyHandle) {
        let (mut world, base) = jointed::jointed(bodies, joints, 1);
        world.set_settings(&self.settings()).expect("presets are in range");
        (world, base)
    }

    /// An empty world without gravity.
    pub fn floating(&self, bodies: u32) -> OwnedWorld {
        let mut world = self.world(bodies);
        jointed::weightless(&mut world);
        world
    }

    /// Holds a measured error against its marks, the excellent one first, the gate second.
    pub fn judge(&mut self, measure: &str, (error, unit): (f64, &str), [excellent, gate]: [f64; 2]) {
        let gated = self.preset.is_none_or(|preset| preset >= self.case.gated_from);
        // What is no number is beyond all of them.
        let mark = match error {
            e if e <= excellent => "excellent",
            e if e <= gate => "acceptable",
            _ if gated => BEYOND,
            _ => "",
        };
        let key = self.note(measure, (error, unit), mark);
        println!("{}: {error:.3e} {unit}, marks {excellent:.1e} / {gate:.1e}: {mark}", key.join(", "));
        self.excellent.insert(key, excellent);
    }

    /// Notes an error that has no gate.
    pub fn score(&mut self, measure: &str, (error, unit): (f64, &str)) {
        let key = self.note(measure, (error, unit), "");
        println!("{}: {error:.3e} {unit}", key.join(", "));
    }

    /// Notes whether something that must hold does not.
    pub fn holds(&mut self, measure: &str, does: bool) {
        self.judge(measure, (f64::from(u8::from(!does)), "failures"), [0.0; 2]);
    }

    fn note(&mut self, measure: &str, (error, unit): (f64, &str), mark: &str) -> [String; 3] {
        let error = if error.is_nan() { f64::INFINITY } else { error };
        assert!(!measure.contains('|') && !unit.contains('|'), "the golden file is split there");
        let preset = self.preset.map_or(OWN, Preset::name);
        let key = [self.case.name, measure.trim(), preset].map(String::from);
        let line = Line { error, unit: unit.into(), mark: mark.into() };
        let before = self.lines.insert(key.clone(), line);
        assert!(before.is_none(), "{} is measured twice", key.join(", "));
        key
    }
}

/// The golden file.
fn path() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("golden/scores.txt")
}

fn read() -> String {
    std::fs::read_to_string(path()).unwrap_or_default()
}

/// The golden lines.
///
/// # Panics
/// When a line is not `case | measure | preset | error | unit | mark`.
fn parse(text: &str) -> Lines {
    let line = |line: &str| {
        let fields: Vec<String> = line.split('|').map(|field| field.trim().into()).collect();
        let [case, measure, preset, error, unit, mark] =
            <[String; 6]>::try_from(fields).expect("a line has six fields");
        let error = error.parse().expect("an error is a number");
        ([case, measure, preset], Line { error, unit, mark })
    };
    text.lines().map(line).collect()
}

fn print(lines: &Lines) -> String {
    let line = |([case, measure, preset], line): (&[String; 3], &Line)| {
        let Line { error, unit, mark } = line;
        format!("{case} | {measure} | {preset} | {error:.1e} | {unit} | {mark}").trim_end().to_owned() + "\n"
    };
    lines.iter().map(line).collect()
}

/// Writes the lines of a case anew. Tests run at once, so the file is locked.
fn renew(case: &str, found: &Lines) {
    let mut options = OpenOptions::new();
    let mut file =
        options.read(true).write(true).create(true).truncate(false).open(path()).expect("it opens");
    file.lock().expect("it can be locked");
    let mut text = String::new();
    file.read_to_string(&mut text).expect("it is text");
    let mut lines = parse(&text);
    for (key, Line { error, unit, mark }) in found {
        let before = lines.get(key).map_or(f64::INFINITY, |line| line.error);
        if *error > before * (1.0 + MARGIN) || mark == BEYOND {
            println!("{}: {error:.1e} {unit}, was {before:.1e}; {mark}", key.join(", "));
        }
    }
    lines.retain(|key, _| key[0] != case);
    lines.extend(found.clone());
    file.rewind().expect("a file");
    file.set_len(0).expect("it can be cut");
    file.write_all(print(&lines).as_bytes()).expect("it can be written");
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_golden_file_is_sorted_and_names_presets() {
        let text = read();
        let lines = parse(&text);
        assert!(!lines.is_empty() && print(&lines) == text, "write it with UPDATE=1");
        for key in lines.keys() {
            let known = Preset::ALL.iter().any(|preset| preset.name() == key[2]) || key[2] == OWN;
            assert!(known, "{}", key.join(", "));
        }
    }

    #[test]
    fn errors_beyond_the_gate_are_marked_where_there_is_one() {
        let case = Case::new("a case").gated_from(Preset::Balanced);
        for (preset, marks) in [(Preset::Fast, ["", ""]), (Preset::Balanced, [BEYOND; 2])] {
            let mut sheet = Sheet::new(case, Some(preset));
            sheet.judge("not a number", (f64::NAN, "m"), [0.5, 1.0]);
            sheet.judge("some measure", (2.0, "m"), [0.5, 1.0]);
            sheet.judge("well", (0.5, "m"), [0.5, 1.0]);
            let found: Vec<&str> = sheet.lines.values().map(|line| line.mark.as_str()).collect();
            assert_eq!(found, [marks[0], marks[1], "excellent"]);
        }
    }
}
