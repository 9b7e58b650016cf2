//! The programs in `examples` are compiled without a warning and run under the sanitizers, against both libraries.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

const WARNINGS: [&str; 5] = ["-std=c11", "-Wall", "-Wextra", "-Werror", "-pedantic"];
const SANITIZERS: [&str; 3] = ["-g", "-fsanitize=address,undefined", "-fno-sanitize-recover=all"];

/// The C compiler: that of the environment, or the first that is there.
///
/// # Panics
/// When there is none.
fn compiler() -> String {
    let wanted = std::env::var("CC").ok();
    let known = ["cc", "gcc", "clang"].map(String::from);
    let runs =
        |name: &String| Command::new(name).arg("--version").output().is_ok_and(|out| out.status.success());
    let found = wanted.into_iter().chain(known).find(runs);
    found.expect("no C compiler: install gcc or clang (apt-get install gcc libc6-dev), or name one in CC")
}

/// The folder of the libraries that cargo has built with this test.
fn libraries() -> PathBuf {
    let test = std::env::current_exe().expect("a test has a path");
    test.parent().expect("in a folder").to_path_buf()
}

#[track_caller]
fn done(what: &str, output: &Output) {
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    assert!(
        output.status.success(),
        "{what}: {}\n{}{}",
        output.status,
        text(&output.stdout),
        text(&output.stderr)
    );
}

/// Compiles an example against a library, runs it, and gives what it prints.
fn run(name: &str, library: &[&str]) -> String {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let program = libraries().join(format!("{name}-{}-{}", library.len(), std::process::id()));
    let built = Command::new(compiler())
        .args(WARNINGS)
        .args(SANITIZERS)
        .arg("-I")
        .arg(root.join("include"))
        .arg(root.join("examples").join(name).with_extension("c"))
        .args(library)
        .args(["-lpthread", "-ldl", "-lm", "-o"])
        .arg(&program)
        .output()
        .expect("the compiler runs");
    done(&format!("compiling {name}.c"), &built);
    let ran = Command::new(&program)
        .env("LD_LIBRARY_PATH", libraries())
        .env("ASAN_OPTIONS", "detect_leaks=1:halt_on_error=1")
        .output()
        .expect("the program runs");
    std::fs::remove_file(&program).expect("it was just made");
    done(name, &ran);
    String::from_utf8(ran.stdout).expect("text")
}

/// Against the static library, and against the shared one.
fn run_with_both(name: &str) -> [String; 2] {
    let folder = libraries();
    let (fixed, shared) = (folder.join("libcellstep_c.a"), folder.join("libcellstep_c.so"));
    assert!(fixed.exists() && shared.exists(), "no libraries in {}", folder.display());
    let search = format!("-L{}", folder.display());
    [run(name, &[fixed.to_str().expect("a path in UTF-8")]), run(name, &[&search, "-lcellstep_c"])]
}

#[test]
fn the_game_plays() {
    let [fixed, shared] = run_with_both("game");
    assert!(fixed.contains("checksum") && fixed == shared, "{fixed}{shared}");
}

#[test]
fn bad_arguments_are_refused() {
    for text in run_with_both("refusals") {
        assert_eq!(text, "all refused\n");
    }
}
