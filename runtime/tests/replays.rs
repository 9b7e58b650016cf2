//! The command `cellstep` on replays: `run --record`, `verify`, `bisect`, `inspect`.
#![cfg(feature = "cli")]

use cellstep::math::Vec3;
use cellstep::replay::{Options, Recorder, Replay};
use cellstep::scene::builtin::Builtin;
use cellstep::{BodyHandle, Command as Call, Serial};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

fn cellstep(args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_cellstep")).args(args).output().unwrap()
}

fn text(bytes: &[u8]) -> &str {
    std::str::from_utf8(bytes).unwrap()
}

/// Exit code and standard output of a call.
fn call(args: &[&str]) -> (i32, String) {
    let output = cellstep(args);
    (output.status.code().unwrap(), text(&output.stdout).to_string())
}

/// A folder for one test.
fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

fn json(line: &str) -> serde_json::Value {
    serde_json::from_str(line).unwrap()
}

/// A recording of a few balls; with `hidden` a change that is not recorded before a step.
fn recording(hidden: Option<u64>, push: f32) -> Vec<u8> {
    let scene = Builtin::find("mixed_pile").unwrap().scene(12).unwrap();
    let mut built = scene.build(Path::new("")).unwrap();
    let body = BodyHandle { index: 3, generation: 1 };
    let options =
        Options { checksums_every: 1, keyframes_every: 8, note: "a test".to_string(), ..Options::default() };
    let mut recorder = Recorder::new(Vec::new(), &built.world, &built.assets, &options).unwrap();
    for step in 0..20 {
        if hidden == Some(step) {
            built.world.set_body_user(body, 7).unwrap();
        }
        if step == 5 {
            recorder.apply(&mut built.world, &Call::ApplyImpulse(body, Vec3::X * push)).unwrap();
            let gone = BodyHandle { index: 3, generation: 9 };
            recorder.apply(&mut built.world, &Call::RemoveBody(gone)).unwrap_err();
        }
        recorder.step(&mut built.world, &mut Serial);
    }
    recorder.finish(&built.world).unwrap()
}

/// Replays of all kinds: their paths in the order of the list.
fn replays(folder: &Path) -> Vec<String> {
    let good = recording(None, 1.0);
    let mut damaged = good.clone();
    damaged[300] ^= 4;
    let mut foreign = good.clone();
    foreign[12] ^= 0x40;
    let files: [(&str, Vec<u8>); 7] = [
        ("good", good.clone()),
        ("diverged", recording(Some(11), 1.0)),
        ("cut", good[..good.len() - 40].to_vec()),
        ("damaged", damaged),
        ("version", foreign),
        ("good_too", recording(None, 2.0)),
        ("text", b"no replay".to_vec()),
    ];
    let mut paths = Vec::new();
    for (name, bytes) in files {
        let path = folder.join(name).with_extension("replay");
        std::fs::write(&path, bytes).unwrap();
        paths.push(path.to_str().unwrap().to_string());
    }
    paths.push(folder.join("absent.replay").to_str().unwrap().to_string());
    paths
}

#[test]
fn a_recorded_run_verifies() {
    let folder = folder("recorded");
    let file = folder.join("run.replay");
    let name = file.to_str().unwrap();
    let args = ["run", "ragdolls", "--size", "2", "--steps", "40", "--json", "--record", name];
    let (code, report) = call(&[&args[..], &["--checksums-every", "5", "--keyframes-every", "10"]].concat());
    assert_eq!(code, 0);
    let replay = Replay::open(&file).unwrap();
    assert_eq!((replay.last_step(), replay.is_finished(), replay.keyframes().count()), (40, true, 5));
    let last = format!("{:016x}", replay.checksums().last().unwrap().total);
    assert_eq!(json(&report)["checksum"], last);
    let (code, lines) = call(&["verify", name]);
    assert_eq!(code, 0, "{lines}");
    let line = json(lines.lines().next().unwrap());
    assert_eq!(
        (&line["result"], &line["steps"], &line["compared"]),
        (&"same".into(), &40.into(), &12.into())
    );
    assert_eq!((&line["file"], &line["complete"]), (&name.into(), &true.into()));
    let (code, found) = call(&["bisect", name, "--against-self", "--workers", "2"]);
    assert_eq!((code, found.as_str()), (0, "no difference in 40 steps\n"));
    let (code, found) = call(&["bisect", name, name, "--json"]);
    assert_eq!((code, found.as_str()), (0, "{\"result\":\"same\",\"steps\":40}\n"));
    let output = cellstep(&["run", "tower", "--checksums-every", "5"]);
    assert_eq!(output.status.code(), Some(2));
    let nowhere = folder.join("no/folder");
    let output = cellstep(&["run", "tower", "--steps", "1", "--record", nowhere.to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(2));
    assert!(text(&output.stderr).starts_with("error: cannot write "), "{}", text(&output.stderr));
}

#[test]
fn a_recording_survives_the_end_of_its_process() {
    let folder = folder("killed");
    let file = folder.join("run.replay");
    let name = file.to_str().unwrap();
    let mut child = Command::new(env!("CARGO_BIN_EXE_cellstep"))
        .args(["run", "tower", "--size", "3", "--steps", "4000000", "--workers", "1", "--record", name])
        .stdout(Stdio::null())
        .spawn()
        .unwrap();
    while std::fs::metadata(&file).map_or(0, |file| file.len()) < 20_000 {
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    let replay = Replay::open(&file).unwrap();
    assert!(!replay.is_finished() && replay.last_step() > 10);
    let (code, lines) = call(&["verify", name]);
    let line = json(lines.lines().next().unwrap());
    assert_eq!((code, &line["complete"], &line["steps"]), (0, &false.into(), &replay.last_step().into()));
}

#[test]
fn exit_codes_tell_the_worst() {
    let paths = replays(&folder("codes"));
    let [good, diverged, cut, damaged, version, _, no_replay, absent] = &paths[..] else { unreachable!() };
    let result = |args: &[&str]| {
        let (code, lines) = call(&[&["verify"], args].concat());
        (code, json(lines.lines().next().unwrap()))
    };
    let expect = |path: &str, expected: i32, outcome: &str| {
        let (code, line) = result(&[path]);
        assert_eq!((code, &line["result"]), (expected, &outcome.into()), "{line}");
        line
    };
    assert_eq!(expect(good, 0, "same")["complete"], true);
    let line = expect(cut, 0, "same");
    assert_eq!((&line["complete"], &line["steps"]), (&false.into(), &20.into()));
    let line = expect(diverged, 1, "diverged");
    assert_eq!((&line["step"], &line["sections"]), (&11.into(), &vec!["bodies"].into()));
    assert!(line["message"].as_str().unwrap().contains("changed without a record"));
    expect(damaged, 3, "corrupt");
    expect(no_replay, 3, "corrupt");
    expect(version, 4, "version");
    expect(absent, 2, "unreadable");
    let (code, line) = result(&[good, "--memory", "0"]);
    assert_eq!((code, &line["result"]), (2, &"unreadable".into()));
    assert!(line["message"].as_str().unwrap().ends_with(" bytes, 0 are allowed"), "{line}");
    assert_eq!(result(&[absent, version]).0, 4);
    assert_eq!(result(&[absent, version, damaged]).0, 3);
    assert_eq!(result(&[absent, version, damaged, diverged, good]).0, 1);
    for wrong in [&["verify"][..], &["verify", good, "--shard", "2/2"], &["verify", "--list", absent]] {
        assert_eq!(call(wrong).0, 2, "{wrong:?}");
    }
    assert_eq!(call(&["inspect", damaged]).0, 3);
    assert_eq!(call(&["inspect", version]).0, 4);
    assert_eq!(call(&["inspect", absent]).0, 2);
    assert_eq!(call(&["bisect", damaged, "--against-self"]).0, 3);
    assert_eq!(call(&["bisect", good]).0, 2);
}

#[test]
fn the_output_does_not_depend_on_workers_or_shards() {
    let folder = folder("shards");
    let paths = replays(&folder);
    let list = folder.join("list");
    std::fs::write(&list, paths.join("\n")).unwrap();
    let list = list.to_str().unwrap();
    let (code, whole) = call(&["verify", "--list", list, "--workers", "1"]);
    assert_eq!((code, whole.lines().count()), (1, paths.len() + 1));
    for (index, line) in whole.lines().take(paths.len()).enumerate() {
        let line = json(line);
        assert_eq!((&line["index"], &line["file"]), (&index.into(), &paths[index].as_str().into()));
    }
    let summary = &json(whole.lines().last().unwrap())["summary"];
    let counts = ["same", "diverged", "corrupt", "version", "unreadable"].map(|key| &summary[key]);
    assert_eq!(counts, [3, 1, 2, 1, 1]);
    assert_eq!(call(&["verify", "--list", list, "--workers", "4"]), (1, whole.clone()));
    let mut names = vec!["verify"];
    names.extend(paths.iter().map(String::as_str));
    assert_eq!(call(&names), (1, whole.clone()));
    // From standard input.
    let mut child = Command::new(env!("CARGO_BIN_EXE_cellstep"))
        .args(["verify", "--list", "-"])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    child.stdin.take().unwrap().write_all((paths.join("\n") + "\n").as_bytes()).unwrap();
    assert_eq!(text(&child.wait_with_output().unwrap().stdout), whole);
    let mut shards = Vec::new();
    for shard in 0..3 {
        let (_, lines) =
            call(&["verify", "--list", list, "--shard", &format!("{shard}/3"), "--workers", "2"]);
        let file = folder.join(format!("shard{shard}"));
        std::fs::write(&file, lines).unwrap();
        shards.push(file.to_str().unwrap().to_string());
    }
    let merge = |shards: &[&str]| {
        let output = cellstep(&[&["verify", "--merge"], shards].concat());
        (output.status.code().unwrap(), text(&output.stdout).to_string(), text(&output.stderr).to_string())
    };
    let [a, b, c] = [0, 1, 2].map(|shard: usize| shards[shard].as_str());
    assert_eq!(merge(&[c, a, b]), (1, whole.clone(), String::new()));
    let missing = merge(&[a, c]);
    assert_eq!((missing.0, missing.1.as_str()), (2, ""));
    assert_eq!(missing.2, "error: shard 1 of 3 is missing\n");
    assert!(merge(&[a, b, c, b]).2.contains("shard 1 is there twice"));
    // A job that was killed.
    let lines = std::fs::read_to_string(b).unwrap();
    let cut: String = lines.lines().take(2).map(|line| format!("{line}\n")).collect();
    std::fs::write(b, cut).unwrap();
    assert!(merge(&[a, b, c]).2.contains("the shard is not done"));
    let fewer: String = lines.lines().skip(1).map(|line| format!("{line}\n")).collect();
    std::fs::write(b, fewer).unwrap();
    assert!(merge(&[a, b, c]).2.contains("does not count its lines"));
    // A shard of another list.
    let (_, other) = call(&["verify", &paths[0], &paths[1], "--shard", "1/3"]);
    std::fs::write(b, other).unwrap();
    assert!(merge(&[a, b, c]).2.contains("of another list"));
    // More shards than replays.
    let (code, lines) = call(&["verify", &paths[0], "--shard", "4/5"]);
    assert_eq!((code, lines.lines().count()), (0, 1));
}

#[test]
fn bisect_names_the_body_and_inspect_tells_all() {
    let folder = folder("bisect");
    let paths = replays(&folder);
    let (code, found) = call(&["bisect", &paths[0], &paths[1], "--json"]);
    let found = json(&found);
    assert_eq!((code, &found["result"], &found["step"]), (1, &"parted".into(), &11.into()), "{found}");
    assert_eq!((&found["stage"], &found["agreed"]), (&"between steps".into(), &11.into()), "{found}");
    let field = &found["field"];
    assert_eq!(field["bodies"], serde_json::json!([[3, 1]]));
    assert_eq!((&field["section"], &field["field"]), (&"bodies".into(), &"user".into()));
    assert_eq!(field["hex"], serde_json::json!(["0x0000000000000000", "0x0000000000000007"]));
    assert_eq!(field["decimal"], serde_json::json!(["0", "7"]));
    let (code, table) = call(&["bisect", &paths[0], &paths[1]]);
    assert_eq!(code, 1);
    assert!(
        table.contains("body 3 (generation 1): bodies[3].user[0] is 0x0000000000000000 (0) and"),
        "{table}"
    );
    let (code, found) = call(&["bisect", &paths[0], &paths[5], "--json"]);
    let found = json(&found);
    assert_eq!((code, &found["step"], &found["stage"]), (1, &5.into(), &"commands".into()), "{found}");
    assert_eq!(found["field"]["field"], "linear");
    let (code, table) = call(&["inspect", &paths[2]]);
    assert_eq!(code, 0);
    for row in
        ["note                 a test", "steps                0 to 20", "commands             RemoveBody 1"]
    {
        assert!(table.lines().any(|line| line == row), "{row} in\n{table}");
    }
    assert!(table.contains("end                  cut off: "), "{table}");
    let (code, contents) = call(&["inspect", &paths[0], "--json"]);
    let contents = json(&contents);
    assert_eq!((code, &contents["refused"], &contents["complete"]), (0, &1.into(), &true.into()));
    let steps: Vec<u64> =
        contents["keyframes"].as_array().unwrap().iter().map(|k| k["step"].as_u64().unwrap()).collect();
    assert_eq!(steps, [0, 8, 16]);
    let (code, commands) = call(&["inspect", &paths[0], "--step", "6"]);
    assert_eq!((code, commands.lines().count()), (0, 2));
    assert!(commands.starts_with("    0 accepted ApplyImpulse("), "{commands}");
    assert_eq!(call(&["inspect", &paths[0], "--step", "7"]), (0, String::new()));
}
