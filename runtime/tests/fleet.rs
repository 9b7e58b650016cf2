//! The files of `examples/fleet`: their syntax, and that the shards which they start come to what one run comes to.
#![cfg(all(feature = "cli", unix))]

use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use yaml_rust2::{Yaml, YamlLoader};

const CELLSTEP: &str = env!("CARGO_BIN_EXE_cellstep");
const SHARDS: usize = 16;

fn fleet() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/fleet").canonicalize().unwrap()
}

fn text(bytes: &[u8]) -> &str {
    std::str::from_utf8(bytes).unwrap()
}

fn cellstep(args: &[&str], folder: &Path) -> Output {
    Command::new(CELLSTEP).args(args).current_dir(folder).output().unwrap()
}

/// A folder with replays, one of which is corrupt, `list.txt`, and an empty folder `results`.
fn replays(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(folder.join("results")).unwrap();
    let mut list = String::new();
    for size in 1..=20 {
        let file = format!("a tower of {size}.replay");
        let (size, steps) = (size.to_string(), ["--steps", "3", "--workers", "1"]);
        let args = [&["run", "tower", "--size", &size, "--record", &file], &steps[..]].concat();
        assert!(cellstep(&args, &folder).status.success());
        list += &format!("{file}\n");
    }
    let broken = folder.join("a tower of 7.replay");
    let mut bytes = std::fs::read(&broken).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    std::fs::write(broken, bytes).unwrap();
    std::fs::write(folder.join("list.txt"), list).unwrap();
    folder
}

/// The merged results are one run's; without one of them they are refused.
fn check_merged(folder: &Path) {
    let single = cellstep(&["verify", "--list", "list.txt"], folder);
    assert_eq!(single.status.code(), Some(3), "one is corrupt");
    let file = |shard: usize| format!("results/shard-{shard}.jsonl");
    let files: Vec<String> = (0..SHARDS).map(file).collect();
    let mut args = vec!["verify", "--merge"];
    args.extend(files.iter().map(String::as_str));
    let merged = cellstep(&args, folder);
    assert_eq!(merged.status.code(), Some(3), "{}", text(&merged.stderr));
    assert_eq!(text(&merged.stdout), text(&single.stdout));
    args.remove(2 + 5);
    let missing = cellstep(&args, folder);
    assert_eq!((missing.status.code(), text(&missing.stdout)), (Some(2), ""));
    assert!(text(&missing.stderr).contains("shard 5 of 16 is missing"), "{}", text(&missing.stderr));
}

#[test]
fn scripts_are_scripts() {
    for (shell, script) in [("sh", "shard.sh"), ("bash", "parallel.sh"), ("bash", "slurm.sh")] {
        let output = Command::new(shell).arg("-n").arg(fleet().join(script)).output().unwrap();
        assert!(output.status.success(), "{script}: {}", text(&output.stderr));
    }
}

#[test]
fn a_slurm_array_does_what_one_run_does() {
    let script = std::fs::read_to_string(fleet().join("slurm.sh")).unwrap();
    let array = script.lines().find_map(|line| line.strip_prefix("#SBATCH --array=")).unwrap();
    assert_eq!(array, format!("0-{}", SHARDS - 1));
    let folder = replays("slurm");
    for index in 0..SHARDS {
        let mut job = Command::new("bash");
        job.arg(fleet().join("slurm.sh")).env("SLURM_SUBMIT_DIR", &folder).env("FLEET", fleet());
        job.env("SLURM_ARRAY_TASK_ID", index.to_string()).env("SLURM_ARRAY_TASK_COUNT", SHARDS.to_string());
        let output = job.env("CELLSTEP", CELLSTEP).output().unwrap();
        assert!(output.status.success(), "{}", text(&output.stderr));
    }
    check_merged(&folder);
}

#[test]
fn a_kubernetes_job_does_what_one_run_does() {
    let manifest = std::fs::read_to_string(fleet().join("kubernetes.yaml")).unwrap();
    let documents = YamlLoader::load_from_str(&manifest).unwrap();
    let [job] = &documents[..] else { panic!("one document") };
    let word = |value: &Yaml| value.as_str().unwrap().to_string();
    assert_eq!((word(&job["apiVersion"]), word(&job["kind"])), ("batch/v1".into(), "Job".into()));
    let spec = &job["spec"];
    assert_eq!(word(&spec["completionMode"]), "Indexed");
    assert_eq!(spec["completions"].as_i64(), Some(SHARDS as i64));
    let pod = &spec["template"]["spec"];
    assert_eq!(word(&pod["restartPolicy"]), "Never");
    let container = &pod["containers"][0];
    let [shards] = &container["env"].as_vec().unwrap()[..] else { panic!("one variable") };
    assert_eq!((word(&shards["name"]), word(&shards["value"])), ("SHARDS".into(), SHARDS.to_string()));
    // Each mounted volume is there.
    let names =
        |list: &Yaml| list.as_vec().unwrap().iter().map(|entry| word(&entry["name"])).collect::<Vec<_>>();
    assert_eq!(names(&container["volumeMounts"]), names(&pod["volumes"]));

    // What a pod runs, with the paths of this machine in place of the mounted ones.
    let command: Vec<String> = container["command"].as_vec().unwrap().iter().map(word).collect();
    let [shell, option, script] = &command[..] else { panic!("{command:?}") };
    let script = script.replace("/fleet/", "$FLEET/").replace("/replays/", "");
    let folder = replays("kubernetes");
    for index in 0..SHARDS {
        let mut pod = Command::new(shell);
        pod.arg(option).arg(&script).current_dir(&folder).env("FLEET", fleet()).env("CELLSTEP", CELLSTEP);
        pod.env("JOB_COMPLETION_INDEX", index.to_string()).env("SHARDS", SHARDS.to_string());
        let output = pod.output().unwrap();
        assert!(output.status.success(), "{}", text(&output.stderr));
    }
    check_merged(&folder);
}

/// A list that is not there: nothing that looks like an answer is left.
#[test]
fn a_shard_that_fails_leaves_no_answer() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("no_list");
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    let mut shard = Command::new("sh");
    shard.arg(fleet().join("shard.sh")).args(["0", "1", "no list.txt", "."]).current_dir(&folder);
    let output = shard.env("CELLSTEP", CELLSTEP).output().unwrap();
    assert_eq!(output.status.code(), Some(2));
    assert!(!folder.join("shard-0.jsonl").exists());
}
