//! The command `cellstep`: what it prints, and how it exits.
#![cfg(feature = "cli")]

use cellstep::scene::builtin::BUILTIN;
use cellstep::scene::format::SettingsDoc;
use cellstep::scene::{Limits, Scene};
use cellstep::{Preset, Settings};
use std::io::Read;
use std::path::Path;
use std::process::{Command, Output, Stdio};

fn cellstep(args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_cellstep")).args(args).output().unwrap()
}

fn text(bytes: &[u8]) -> &str {
    std::str::from_utf8(bytes).unwrap()
}

/// Standard output of a call that must succeed and say nothing else.
fn answer(args: &[&str]) -> String {
    let output = cellstep(args);
    assert!(output.status.success(), "{args:?}: {}", text(&output.stderr));
    assert_eq!(text(&output.stderr), "", "{args:?}");
    text(&output.stdout).to_string()
}

/// Standard error of a call that must exit with 2 and answer nothing.
fn refusal(args: &[&str]) -> String {
    let output = cellstep(args);
    assert_eq!(output.status.code(), Some(2), "{args:?}");
    assert_eq!(text(&output.stdout), "", "{args:?}");
    text(&output.stderr).to_string()
}

#[test]
fn json_is_one_object_with_the_documented_keys() {
    let json = answer(&["run", "tower", "--steps", "7", "--workers", "2", "--substeps", "3", "--json"]);
    assert_eq!(json.lines().count(), 1);
    let report: serde_json::Value = serde_json::from_str(&json).unwrap();
    let keys = |value: &serde_json::Value| value.as_object().unwrap().keys().cloned().collect::<Vec<_>>();
    let expected = "asleep barriers_per_step blocks bodies checksum contacts dropped joints ms_per_step pairs \
                    penetration_max phases quarantined scene settings stage_ms state_bytes steps substeps workers";
    assert_eq!(keys(&report).join(" "), expected);
    let stages = "assembly broadphase finish islands narrowphase ordering serial solve";
    assert_eq!(keys(&report["stage_ms"]).join(" "), stages);
    assert_eq!(report["scene"], "tower");
    assert_eq!(
        (&report["steps"], &report["workers"], &report["substeps"]),
        (&7.into(), &2.into(), &3.into())
    );
    assert_eq!(report["bodies"], 21);
    assert_eq!(report["quarantined"], 0);
    assert_eq!(report["checksum"].as_str().unwrap().len(), 16);
    assert!(report["state_bytes"].as_u64().unwrap() > 0);
    assert!(report["ms_per_step"].as_f64().unwrap() >= report["stage_ms"]["serial"].as_f64().unwrap());
}

#[test]
fn a_preset_is_told_and_replaces_what_the_scene_says() {
    let run = |more: &[&str]| {
        let args = [&["run", "wall", "--size", "4", "--steps", "30", "--json"], more].concat();
        serde_json::from_str::<serde_json::Value>(&answer(&args)).unwrap()
    };
    let plain = run(&[]);
    assert_eq!(plain["settings"]["preset"], "balanced");
    assert_eq!(run(&["--preset", "balanced"])["checksum"], plain["checksum"]);
    let file = Path::new(env!("CARGO_TARGET_TMPDIR")).join("preset.json");
    let mut scene = BUILTIN.iter().find(|builtin| builtin.name == "wall").unwrap().scene(4).unwrap();
    for preset in Preset::ALL {
        let told = run(&["--preset", preset.name()]);
        let settings = Settings::from(preset);
        assert_eq!(told["settings"]["preset"], preset.name());
        assert_eq!(
            (&told["substeps"], &told["settings"]["substeps"]),
            (&settings.substeps.into(), &settings.substeps.into())
        );
        // The same from a scene file, whatever the place of the field.
        scene.settings = SettingsDoc { preset: Some(preset.into()), ..SettingsDoc::default() };
        std::fs::write(&file, scene.to_json()).unwrap();
        let again = answer(&["run", file.to_str().unwrap(), "--steps", "30", "--json"]);
        assert_eq!(serde_json::from_str::<serde_json::Value>(&again).unwrap()["checksum"], told["checksum"]);
    }
    let mixed = run(&["--preset", "fast", "--substeps", "3"]);
    assert_eq!((&mixed["substeps"], &mixed["settings"].get("preset")), (&3.into(), &None));
    assert!(refusal(&["run", "wall", "--preset", "slow"]).contains("one of fast, balanced, accurate, exact"));
    let text = "{\"settings\": {\"substeps\": 3, \"sleep_time\": 0.5, \"preset\": \"accurate\"}}";
    let scene = Scene::from_json(text.as_bytes(), &Limits::default()).unwrap();
    let mut settings = Settings::default();
    scene.settings.apply(&mut settings);
    let expected = Settings { substeps: 3, sleep_time: 0.5, ..Preset::Accurate.into() };
    assert_eq!(settings, expected);
}

#[test]
fn the_checksum_does_not_depend_on_workers_and_comes_back_from_a_file() {
    let checksum = |scene: &str, workers: &str, more: &[&str]| {
        let args = [&["run", scene, "--steps", "20", "--json", "--workers", workers], more].concat();
        let report: serde_json::Value = serde_json::from_str(&answer(&args)).unwrap();
        report["checksum"].as_str().unwrap().to_string()
    };
    let one = checksum("mixed_pile", "1", &["--size", "60"]);
    assert_eq!(one, checksum("mixed_pile", "3", &["--size", "60"]));
    assert_ne!(one, checksum("mixed_pile", "1", &["--size", "61"]));
    let file = Path::new(env!("CARGO_TARGET_TMPDIR")).join("pile.json");
    std::fs::write(&file, answer(&["scene", "mixed_pile", "--size", "60"])).unwrap();
    assert_eq!(one, checksum(file.to_str().unwrap(), "2", &[]));
}

#[test]
fn the_table_names_everything() {
    let table = answer(&["run", "wall", "--size", "3", "--steps", "2", "--workers", "1"]);
    for row in ["scene", "bodies", "pairs", "contacts", "phases", "blocks", "barriers per step", "dropped"] {
        assert!(table.lines().any(|line| line.starts_with(row)), "{row} in\n{table}");
    }
    for row in
        ["quarantined", "checksum", "broadphase", "narrowphase", "ordering", "assembly", "solve", "finish"]
    {
        assert!(table.lines().any(|line| line.starts_with(row)), "{row} in\n{table}");
    }
    let idle = answer(&["run", "tower", "--steps", "0"]);
    assert!(idle.contains(&format!("{:<20} {:>16}", "whole step", "0.000")), "{idle}");
}

#[test]
fn scenes_are_listed_and_printed() {
    let list = answer(&["scenes"]);
    assert_eq!(list.lines().count(), BUILTIN.len() + 1);
    for builtin in BUILTIN {
        assert!(list.contains(builtin.name) && list.contains(builtin.description));
        let json = answer(&["scene", builtin.name, "--size", "2"]);
        let scene = Scene::from_json(json.as_bytes(), &Limits::default()).unwrap();
        assert_eq!(scene, builtin.scene(2).unwrap());
    }
}

#[test]
fn wrong_usage_exits_with_2() {
    assert!(refusal(&[]).contains("Usage"));
    assert!(refusal(&["fly"]).contains("unrecognized subcommand"));
    assert!(refusal(&["run"]).contains("<SCENE>"));
    assert!(refusal(&["run", "tower", "--steps", "few"]).contains("--steps"));
    assert!(refusal(&["run", "tower", "--workers", "0"]).contains("1..=256"));
    assert!(refusal(&["run", "tower", "--substeps", "0"]).contains("1..=256"));
    assert!(refusal(&["run", "tower", "--size", "0"]).contains("1..=10000"));
    assert!(refusal(&["run", "towr"]).contains("neither a file nor a built-in scene (free_fall, tower"));
    assert!(refusal(&["scene", "towr"]).contains("expected one of free_fall, tower"));
    assert!(
        refusal(&["scene", "pyramid", "--size", "4000000000"]).contains("found 4000000000, expected 1..=600")
    );
}

#[test]
fn a_wrong_scene_exits_with_2_and_is_told_where() {
    let file = Path::new(env!("CARGO_TARGET_TMPDIR")).join("wrong.json");
    let name = file.to_str().unwrap();
    std::fs::write(&file, "{\n  \"bodies\": [{\"mass\": 1}]\n}\n").unwrap();
    let message = refusal(&["run", name]);
    assert!(message.starts_with(&format!("error: {name}: line 2, column 23: bodies[0].mass: ")), "{message}");
    std::fs::write(&file, "{\"capacities\": {\"bodies\": 1000000000}}").unwrap();
    assert!(refusal(&["run", name]).contains("1000000000 bodies are too many"));
    std::fs::write(&file, "{}").unwrap();
    assert!(refusal(&["run", name, "--size", "3"]).contains("--size is for built-in scenes"));
}

#[test]
fn models_are_imported_and_run() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR"));
    let (model, scene) = (folder.join("model.xml"), folder.join("model.json"));
    let (model, scene) = (model.to_str().unwrap(), scene.to_str().unwrap());
    let xml = "<mujoco><option solver='CG'/><worldbody><light/><geom type='plane' size='1 1 1' gap='1'/>\n\
               <body pos='0 0 1'><freejoint/><geom size='.1' rgba='1 1 1 1'/></body></worldbody></mujoco>";
    std::fs::write(model, xml).unwrap();
    let output = cellstep(&["import", model, "-o", scene]);
    assert!(output.status.success() && output.stdout.is_empty());
    let expected = format!(
        "warning: geom/gap: not modelled ({model}: line 1, column 81)\n\
         note: ignored, of MuJoCo's solver: option/solver (1)\n\
         note: ignored, without effect on motion: worldbody/light (1), geom/rgba (1)\n"
    );
    assert_eq!(text(&output.stderr), expected);
    assert_eq!(text(&cellstep(&["import", model]).stdout), std::fs::read_to_string(scene).unwrap());
    let checksum = |scene: &str| {
        let output = cellstep(&["run", scene, "--steps", "50", "--json"]);
        let report: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        assert_eq!(report["bodies"], 2);
        report["checksum"].clone()
    };
    assert_eq!(checksum(model), checksum(scene));
    let hinge = xml.replace("<freejoint/>", "<joint/>");
    std::fs::write(model, hinge).unwrap();
    let output = cellstep(&["run", model, "--steps", "1500", "--json"]);
    let report: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!((&report["joints"], &report["asleep"]), (&1.into(), &1.into()));
    // What a scene may not say is refused.
    let heavy = xml.replace("size='.1'", "size='.1' mass='1e15'");
    std::fs::write(model, heavy).unwrap();
    let message = refusal(&["import", model]);
    assert!(message.contains("its scene is refused: ") && message.contains("bodies[1].mass"), "{message}");
    std::fs::write(model, "<mujoco>\n<include file='absent.xml'/></mujoco>").unwrap();
    let message = refusal(&["import", model]);
    assert!(
        message.starts_with(&format!("error: {model}: line 2, column 10: mujoco/include/file: ")),
        "{message}"
    );
    assert!(message.contains("absent.xml: cannot be read: "), "{message}");
    assert!(refusal(&["import", "absent.xml"]).starts_with("error: absent.xml: cannot be read: "));
    assert!(refusal(&["import"]).contains("<FILE>"));
}

#[test]
fn a_closed_pipe_is_no_error() {
    for args in [&["scene", "pyramid"][..], &["run", "tower", "--steps", "1", "--json"], &["scenes"]] {
        let mut child = Command::new(env!("CARGO_BIN_EXE_cellstep"))
            .args(args)
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        drop(child.stdout.take());
        let mut errors = String::new();
        child.stderr.take().unwrap().read_to_string(&mut errors).unwrap();
        assert!(child.wait().unwrap().success(), "{args:?}");
        assert_eq!(errors, "", "{args:?}");
    }
}

#[test]
fn the_doctor_finds_the_bits_of_the_release() {
    let output = cellstep(&["doctor", "--json", "--workers", "3"]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stdout));
    let found: serde_json::Value = serde_json::from_str(text(&output.stdout)).unwrap();
    assert_eq!(
        (&found["matches"], &found["workers"], &found["steps"]),
        (&true.into(), &3.into(), &300.into())
    );
    assert_eq!(found["architecture"], std::env::consts::ARCH);
    assert_eq!(found["float_mode"]["rounds_to_nearest"], true);
    let scenes = found["scenes"].as_array().unwrap();
    assert_eq!(scenes.len(), BUILTIN.len());
    for (scene, builtin) in scenes.iter().zip(BUILTIN) {
        let golden = format!("{:016x}", builtin.golden_checksum().unwrap());
        assert_eq!((&scene["scene"], &scene["size"]), (&builtin.name.into(), &builtin.golden_size.into()));
        for key in ["golden", "serial", "pool"] {
            assert_eq!(scene[key], golden.as_str(), "{scene}");
        }
    }
}
