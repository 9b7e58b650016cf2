//! `cellstep tune`: what it prints, and how it exits. Times are never asserted; errors do not depend on workers.
#![cfg(feature = "cli")]

use cellstep::Preset;
use cellstep::scene::format::SettingsDoc;
use cellstep::scene::{Limits, Scene};
use serde_json::Value;
use std::path::Path;
use std::process::{Command, Output};

fn tune(args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_cellstep")).arg("tune").args(args).output().unwrap()
}

fn text(bytes: &[u8]) -> &str {
    std::str::from_utf8(bytes).unwrap()
}

/// The JSON object of a call with an exit code.
fn told(args: &[&str], code: i32) -> Value {
    let output = tune(&[args, &["--json"]].concat());
    assert_eq!(output.status.code(), Some(code), "{args:?}: {}", text(&output.stderr));
    assert_eq!(text(&output.stderr), "", "{args:?}");
    assert_eq!(text(&output.stdout).lines().count(), 1);
    serde_json::from_slice(&output.stdout).unwrap()
}

/// The lines by name, without what depends on the machine.
fn errors(report: &Value) -> Vec<(String, Value)> {
    let lines = report["settings"].as_array().unwrap().iter().map(|line| {
        let mut line = line.clone();
        let fields = line.as_object_mut().unwrap();
        assert!(fields.remove("ms_per_step").unwrap().as_f64().unwrap() > 0.0);
        fields.remove("on_frontier");
        (line["name"].as_str().unwrap().to_string(), line)
    });
    let mut lines: Vec<_> = lines.collect();
    lines.sort_by(|a, b| a.0.cmp(&b.0));
    lines
}

const WALL: [&str; 5] = ["wall", "--size", "5", "--steps", "40"];

#[test]
fn errors_do_not_depend_on_workers_or_on_the_run() {
    let of = |workers: &str| {
        let report = told(&[&WALL[..], &["--max-error", "0.01", "--workers", workers]].concat(), 0);
        assert_eq!(report["workers"].to_string(), workers);
        (errors(&report), report["reference"].clone())
    };
    let one = of("1");
    assert_eq!(one, of("3"));
    assert_eq!(one, of("1"));
    assert_eq!(one.1["comparable_steps"], 40);
    for preset in Preset::ALL {
        let (_, line) = one.0.iter().find(|(name, _)| name == preset.name()).unwrap();
        assert_eq!(line["settings"]["preset"], preset.name());
    }
}

#[test]
fn the_recommended_setting_meets_the_bound_and_nothing_cheaper_does() {
    let report = told(&[&WALL[..], &["--max-error", "0.004"]].concat(), 0);
    assert_eq!((&report["goal"]["max_error"], &report["missed_by"]), (&0.004.into(), &Value::Null));
    let lines = report["settings"].as_array().unwrap();
    let error = |line: &Value| line["error"].as_f64().unwrap();
    let taken = lines.iter().position(|line| line["name"] == report["recommended"]["name"]).unwrap();
    assert!(error(&lines[taken]) <= 0.004);
    assert!(lines[..taken].iter().all(|line| error(line) > 0.004), "{report}");
    let mut least = f64::INFINITY;
    for (index, line) in lines.iter().enumerate() {
        let parts =
            ["penetration_p99", "joint_gap_p99", "height_error"].map(|key| line[key].as_f64().unwrap());
        assert_eq!(error(line), parts.into_iter().fold(0.0, f64::max));
        let cost = |line: &Value| line["ms_per_step"].as_f64().unwrap();
        assert!(index == 0 || cost(&lines[index - 1]) <= cost(line));
        assert_eq!(line["on_frontier"], error(line) < least);
        least = least.min(error(line));
    }
    // The dial turns the right way.
    let of = |name: &str| error(lines.iter().find(|line| line["name"] == name).unwrap());
    assert!(of("fast") > 2.0 * of("exact"), "{report}");
}

#[test]
fn the_fragment_goes_into_a_scene_file() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR"));
    let file = folder.join("tuned.json");
    let name = file.to_str().unwrap();
    let ball = "\"bodies\": [{\"kind\": \"static\", \"shapes\": [{\"geometry\": \"half_space\"}]}, \
                {\"position\": [0, 0, 0.5], \"shapes\": [{\"geometry\": {\"sphere\": {\"radius\": 0.5}}}]}]";
    std::fs::write(&file, format!("{{{ball}}}")).unwrap();
    let output = tune(&[name, "--max-error", "0.0005", "--steps", "30", "--workers", "1"]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let table = text(&output.stdout);
    assert!(table.starts_with(&format!("{name}: 2 bodies, 0 joints, 30 steps, 1 worker\n")), "{table}");
    assert!(table.lines().any(|line| line.starts_with("* ")), "{table}");
    let fragment = table.lines().last().unwrap();
    assert!(fragment.starts_with("\"settings\": {\"preset\":"), "{table}");
    let scene = Scene::from_json(format!("{{{fragment}, {ball}}}").as_bytes(), &Limits::default()).unwrap();
    assert_ne!(scene.settings, SettingsDoc::default());
    scene.build(folder).unwrap();
}

#[test]
fn joints_of_models_are_measured() {
    let file = Path::new(env!("CARGO_TARGET_TMPDIR")).join("tuned.xml");
    let xml = "<mujoco><worldbody><body pos='0 0 3'><joint axis='0 1 0'/><geom size='.1' pos='.5 0 0'/>\
               <body pos='1 0 0'><joint axis='0 1 0'/><geom size='.3' pos='.5 0 0'/></body>\
               </body></worldbody></mujoco>";
    std::fs::write(&file, xml).unwrap();
    let report = told(&[file.to_str().unwrap(), "--max-error", "0.5", "--steps", "60"], 0);
    assert_eq!(report["joints"], 2);
    let widest = |line: &Value| line["joint_gap_max"].as_f64().unwrap();
    let lines = report["settings"].as_array().unwrap();
    assert!(lines.iter().all(|line| widest(line) > 0.0 && widest(line) < 0.01), "{report}");
    assert!(lines.iter().any(|line| line["settings"]["relax_sweeps"] == 4));
}

#[test]
fn a_goal_that_nothing_meets_is_told_by_how_much() {
    let report = told(&[&WALL[..], &["--max-error", "1e-9"]].concat(), 5);
    assert_eq!(report["recommended"], Value::Null);
    let lines = report["settings"].as_array().unwrap();
    let least = lines.iter().map(|line| line["error"].as_f64().unwrap()).fold(f64::INFINITY, f64::min);
    assert_eq!(report["missed_by"].as_f64().unwrap(), least / 1.0e-9);
    let output = tune(&[&WALL[..], &["--budget-ms", "1e-9"]].concat());
    assert_eq!(output.status.code(), Some(5));
    let table = text(&output.stdout);
    assert!(table.contains("no setting meets --budget-ms 0.000000001: the nearest is "), "{table}");
}

#[test]
fn wrong_usage_exits_with_2() {
    for (args, expected) in [
        (&["wall"][..], "--budget-ms"),
        (&["wall", "--max-error", "1", "--budget-ms", "1"], "cannot be used with"),
        (&["wall", "--max-error", "0"], "a number greater than 0"),
        (&["wall", "--budget-ms", "inf"], "a number greater than 0"),
        (&["wall", "--max-error", "1", "--steps", "0"], "1..=1000000"),
        (&["walls", "--max-error", "1"], "neither a file nor a built-in scene"),
        (&["wall", "--max-error", "1", "--size", "0"], "1..=400"),
    ] {
        let output = tune(args);
        assert_eq!((output.status.code(), text(&output.stdout)), (Some(2), ""), "{args:?}");
        assert!(text(&output.stderr).contains(expected), "{args:?}: {}", text(&output.stderr));
    }
}
