//! How the code reads, as far as a machine can tell: sizes, headers, words, unsafe code, and paths in documents.
//!
//! Every source file is read twice: as it is, and as code alone, with comments and the contents of literals blanked
//! out and all lines in place. All findings are reported at once, one a line, as `file:line: what`.

use std::fmt::Write;
use std::path::{Path, PathBuf};

const FILE_LINES_MAX: usize = 600;
const FUNCTION_LINES_MAX: usize = 70;
const WIDTH_MAX: usize = 116;
/// Files that may hold unsafe code: the pool's border between threads, and borders to WebAssembly and to C. There,
/// `border.rs` makes slices of addresses, and the others take addresses from C and hand them on.
const UNSAFE_FILES: [&str; 8] = [
    "runtime/src/job.rs",
    "cross/src/wasm.rs",
    "capi/src/border.rs",
    "capi/src/world.rs",
    "capi/src/snapshots.rs",
    "capi/src/assets.rs",
    "capi/src/queries.rs",
    "capi/src/events.rs",
];
/// Where names may be exported, which the language counts as unsafe.
const EXPORTING_FOLDER: &str = "capi/src/";
/// Names that say nothing, or a second word for a thing that has one.
const WORDS: [&str; 10] =
    ["manager", "helper", "helpers", "util", "utils", "misc", "tick", "ticks", "collider", "colliders"];
/// Names of other crates.
const CRATES: [&str; 1] = ["crossbeam_utils"];
/// Files that speak of other engines in their words.
const FOREIGN_FILES: [&str; 4] = [
    "tests/benches/peers/rapier.rs",
    "tests/benches/queries/rapier.rs",
    "tests/benches/snapshot/rapier.rs",
    "tests/benches/trade/rapier.rs",
];
/// Marks of unfinished work, and folders of one machine. In two parts, so that this file does not hold them.
const MARKS: [&str; 9] = [
    concat!("todo", "!"),
    concat!("unimplemented", "!"),
    concat!("#[ig", "nore"),
    concat!("TO", "DO"),
    concat!("FIX", "ME"),
    concat!("XX", "X"),
    concat!("/wo", "rk/"),
    concat!("/ro", "ot/"),
    concat!("/fa", "rm/"),
];

/// A text file of the project.
struct Source {
    /// From the workspace's folder, with slashes.
    path: String,
    text: String,
    /// As `text`, without comments and literals; empty unless it is Rust.
    code: String,
}

impl Source {
    fn is_rust(&self) -> bool {
        self.path.ends_with(".rs")
    }
}

/// What is not as it should be.
#[derive(Default)]
struct Findings(Vec<String>);

impl Findings {
    fn add(&mut self, source: &Source, line: usize, what: impl std::fmt::Display) {
        self.0.push(format!("{}:{line}: {what}", source.path));
    }

    #[track_caller]
    fn none(mut self) {
        self.0.sort();
        let mut all = String::new();
        for finding in &self.0 {
            writeln!(all, "{finding}").expect("strings grow");
        }
        assert!(self.0.is_empty(), "{} findings:\n{all}", self.0.len());
    }
}

fn root() -> PathBuf {
    let tests = Path::new(env!("CARGO_MANIFEST_DIR"));
    tests.parent().expect("the workspace is around this package").to_path_buf()
}

/// All text files that are written by hand: what builds and fuzzers make is left out.
fn sources() -> Vec<Source> {
    let (root, mut sources) = (root(), Vec::new());
    let mut folders = vec![root.clone()];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(&folder).expect("folders can be read") {
            let path = entry.expect("folders can be read").path();
            let name = path.file_name().expect("entries have names").to_string_lossy().into_owned();
            if path.is_dir() {
                let made = ["target", "corpus", "artifacts", "coverage", ".git"];
                if !made.contains(&name.as_str()) {
                    folders.push(path);
                }
                continue;
            }
            let by_hand = [".rs", ".md", ".toml"].iter().any(|end| name.ends_with(end));
            if by_hand || folder == root.join(".ci") {
                let text = std::fs::read_to_string(&path).expect("sources are text");
                let path = path.strip_prefix(&root).expect("found below the root");
                let path = path.to_string_lossy().replace('\\', "/");
                let code = if name.ends_with(".rs") { code_of(&text) } else { String::new() };
                sources.push(Source { path, text, code });
            }
        }
    }
    assert!(sources.iter().filter(|source| source.is_rust()).count() > 50, "the walk finds the sources");
    sources
}

/// The code alone: comments and the insides of literals become spaces, lines stay.
fn code_of(text: &str) -> String {
    let chars: Vec<char> = text.chars().collect();
    let mut code = String::with_capacity(text.len());
    let mut i = 0;
    while i < chars.len() {
        let end = skip(&chars, i);
        if end == i {
            code.push(chars[i]);
            i += 1;
        } else {
            code.extend(chars[i..end].iter().map(|&c| if c == '\n' { c } else { ' ' }));
            i = end;
        }
    }
    code
}

/// Where the comment or literal that starts at `i` ends; `i` when there is none.
fn skip(chars: &[char], i: usize) -> usize {
    let at = |k: usize| chars.get(k).copied().unwrap_or(' ');
    let find = |from: usize, stop: &dyn Fn(usize) -> bool| (from..chars.len()).find(|&k| stop(k));
    let end = chars.len();
    match (at(i), at(i + 1)) {
        ('/', '/') => find(i, &|k| at(k) == '\n').unwrap_or(end),
        ('/', '*') => {
            let (mut depth, mut k) = (1, i + 2);
            while depth > 0 && k < end {
                match (at(k), at(k + 1)) {
                    ('/', '*') => (depth, k) = (depth + 1, k + 2),
                    ('*', '/') => (depth, k) = (depth - 1, k + 2),
                    _ => k += 1,
                }
            }
            k
        }
        ('r', '"' | '#') if i == 0 || !is_word(at(i - 1)) || at(i - 1) == 'b' => {
            let hashes = (i + 1..end).take_while(|&k| at(k) == '#').count();
            if at(i + 1 + hashes) != '"' {
                return i;
            }
            let closes = |k: usize| at(k) == '"' && (1..=hashes).all(|h| at(k + h) == '#');
            find(i + 2 + hashes, &closes).map_or(end, |k| k + 1 + hashes)
        }
        ('"', _) => {
            let mut k = i + 1;
            while k < end && at(k) != '"' {
                k += if at(k) == '\\' { 2 } else { 1 };
            }
            (k + 1).min(end)
        }
        // A character; what has no closing quote near is a lifetime.
        ('\'', '\\') => find(i + 3, &|k| at(k) == '\'').map_or(end, |k| k + 1),
        ('\'', _) if at(i + 2) == '\'' => i + 3,
        _ => i,
    }
}

fn is_word(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}

/// Words of code with the character before them and their byte offset.
fn words(code: &str) -> impl Iterator<Item = (usize, char, &str)> {
    let mut before = ' ';
    let mut rest = 0;
    std::iter::from_fn(move || {
        let start = rest + code[rest..].find(is_word)?;
        before = code[..start].chars().rev().find(|c| !c.is_whitespace()).unwrap_or(before);
        let end = code[start..].find(|c| !is_word(c)).map_or(code.len(), |n| start + n);
        rest = end;
        Some((start, before, &code[start..end]))
    })
}

fn line_of(text: &str, offset: usize) -> usize {
    1 + text[..offset].matches('\n').count()
}

/// First and last line of every function with a body.
fn functions(code: &str) -> Vec<(usize, usize)> {
    let starts = words(code).filter(|&(_, _, word)| word == "fn").map(|(offset, _, _)| offset);
    starts
        .filter_map(|start| Some((line_of(code, start), line_of(code, start + body_end(&code[start..])?))))
        .collect()
}

/// Where the body of the function that starts here ends; `None` when it has none.
fn body_end(code: &str) -> Option<usize> {
    let (mut braces, mut brackets) = (0, 0);
    for (offset, c) in code.char_indices() {
        match c {
            '(' | '[' => brackets += 1,
            ')' | ']' => brackets -= 1,
            // An array type in the signature has a semicolon, too, and a function type ends before a comma.
            ';' | ',' if brackets == 0 && braces == 0 => return None,
            _ if brackets < 0 => return None,
            '{' => braces += 1,
            '}' if braces == 1 => return Some(offset),
            '}' if braces == 0 => return None,
            '}' => braces -= 1,
            _ => {}
        }
    }
    None
}

/// The parts of a name: of `pairOf_bodies` and `PairOfBodies` pair, of, bodies.
fn parts(name: &str) -> Vec<String> {
    let mut parts = vec![String::new()];
    let mut before = '_';
    for c in name.chars() {
        if c == '_' || (c.is_uppercase() && before.is_lowercase()) {
            parts.push(String::new());
        }
        if c != '_' {
            parts.last_mut().expect("never empty").extend(c.to_lowercase());
        }
        before = c;
    }
    parts
}

/// True when a name has a forbidden part.
fn is_forbidden(name: &str) -> bool {
    parts(name).iter().any(|part| WORDS.contains(&part.as_str()))
}

#[test]
fn files_and_functions_are_short() {
    let mut findings = Findings::default();
    for source in sources().iter().filter(|source| source.is_rust()) {
        let lines = source.text.lines().count();
        if lines > FILE_LINES_MAX {
            findings.add(source, lines, format!("more than {FILE_LINES_MAX} lines"));
        }
        for (i, line) in source.text.lines().enumerate() {
            let width = line.chars().count();
            if width > WIDTH_MAX {
                findings.add(source, i + 1, format!("{width} characters, more than {WIDTH_MAX}"));
            }
        }
        for (first, last) in functions(&source.code) {
            let lines = last - first + 1;
            if lines > FUNCTION_LINES_MAX {
                let what = format!("a function of {lines} lines, more than {FUNCTION_LINES_MAX}");
                findings.add(source, first, what);
            }
        }
    }
    findings.none();
}

#[test]
fn files_open_with_their_purpose() {
    let mut findings = Findings::default();
    for source in sources().iter().filter(|source| source.is_rust()) {
        let first = source.text.lines().next().unwrap_or_default();
        if !first.starts_with("//! ") || first.len() < 12 {
            findings.add(source, 1, "does not open with a line `//! ` that tells its purpose");
        }
    }
    findings.none();
}

#[test]
fn nothing_is_left_undone() {
    let mut findings = Findings::default();
    for source in sources() {
        for (i, line) in source.text.lines().enumerate() {
            for mark in MARKS.iter().filter(|mark| line.contains(**mark)) {
                findings.add(&source, i + 1, format!("`{mark}`"));
            }
        }
    }
    findings.none();
}

#[test]
fn names_say_what_things_are() {
    let mut findings = Findings::default();
    for source in sources().iter().filter(|source| source.is_rust()) {
        if FOREIGN_FILES.contains(&source.path.as_str()) {
            continue;
        }
        if source.path.split(['/', '.']).any(is_forbidden) {
            findings.add(source, 1, "a forbidden word in the path");
        }
        // What follows a dot was named by its definition, which is here or in another crate.
        for (offset, _, name) in words(&source.code).filter(|&(_, before, _)| before != '.') {
            if is_forbidden(name) && !CRATES.contains(&name) {
                findings.add(source, line_of(&source.code, offset), format!("a forbidden word in `{name}`"));
            }
        }
    }
    findings.none();
}

#[test]
fn unsafe_code_is_where_it_belongs() {
    let mut findings = Findings::default();
    for source in sources().iter().filter(|source| source.is_rust()) {
        if UNSAFE_FILES.contains(&source.path.as_str()) {
            continue;
        }
        let exports = source.path.starts_with(EXPORTING_FOLDER);
        for (offset, _, _) in words(&source.code).filter(|&(_, _, word)| word == "unsafe") {
            if exports
                && source.code[..offset].ends_with("#[")
                && source.code[offset..].starts_with("unsafe(no_mangle)]")
            {
                continue;
            }
            findings.add(source, line_of(&source.code, offset), "unsafe code");
        }
    }
    findings.none();
}

/// The core has one behaviour: no features, no `cfg` that changes it, no standard library, no allocator.
#[test]
fn the_core_stands_alone() {
    let mut findings = Findings::default();
    let sources = sources();
    let of_core = |source: &&Source| source.path.starts_with("core/");
    for source in sources.iter().filter(of_core) {
        if source.path == "core/src/lib.rs" {
            for attribute in ["#![no_std]", "#![forbid(unsafe_code)]"] {
                if !source.code.contains(attribute) {
                    findings.add(source, 1, format!("no `{attribute}`"));
                }
            }
        }
        if source.path == "core/Cargo.toml" && source.text.contains("[features]") {
            findings.add(source, 1, "features");
        }
        // Files of tests, and the rest of a file from its tests on.
        let is_test = source.path.ends_with("/tests.rs") || source.path.contains("/tests/");
        let tests = source.code.find("#[cfg(test)]\nmod tests {");
        let own = &source.code[..if is_test { 0 } else { tests.unwrap_or(source.code.len()) }];
        for (offset, _, word) in words(own) {
            let after = &own[offset + word.len()..];
            let line = line_of(own, offset);
            let checks = ["(test)", "!(debug_assertions)", "!(target_endian"];
            if word == "cfg" && !checks.iter().any(|check| after.starts_with(check)) || word == "cfg_attr" {
                findings.add(source, line, "`cfg` in the core");
            }
            if word == "std" || word == "alloc" {
                findings.add(source, line, format!("`{word}` in the core"));
            }
        }
    }
    findings.none();
}

/// Names in backticks that look like paths, and the targets of links.
fn paths(text: &str) -> Vec<(usize, &str)> {
    let mut paths = Vec::new();
    let mut fenced = false;
    for (i, line) in text.lines().enumerate() {
        if line.starts_with("```") {
            fenced = !fenced;
        }
        if fenced {
            continue;
        }
        paths.extend(
            line.split('`').skip(1).step_by(2).filter(|name| is_path(name)).map(|name| (i + 1, name)),
        );
        let links = line.split("](").skip(1).filter_map(|rest| rest.split([')', '#']).next());
        paths
            .extend(links.filter(|link| !link.is_empty() && !link.contains("://")).map(|link| (i + 1, link)));
    }
    paths
}

fn is_path(name: &str) -> bool {
    let plain = name.chars().all(|c| is_word(c) || "/.-".contains(c)) && name.contains(char::is_alphabetic);
    plain && (name.contains('/') || [".rs", ".md", ".toml"].iter().any(|end| name.ends_with(end)))
}

#[test]
fn paths_in_documents_exist() {
    let mut findings = Findings::default();
    for source in
        sources().iter().filter(|source| ["ARCHITECTURE.md", "README.md"].contains(&source.path.as_str()))
    {
        for (line, path) in paths(&source.text) {
            // The map speaks of the core's files by their place in `core/src`, too.
            if !root().join(path).exists() && !root().join("core/src").join(path).exists() {
                findings.add(source, line, format!("`{path}` does not exist"));
            }
        }
    }
    findings.none();
}

#[test]
fn code_is_told_from_comments_and_literals() {
    let text = "let a = \"un\\\"safe {\"; // fn {\n\
        let b = r#\"fn \" {\"#; /* a /* b */ { */ let c = '{'; let d: &'a str = '\\'';\n";
    let code = code_of(text);
    assert_eq!(code.matches('\n').count(), 2);
    assert!(!code.contains('{') && !code.contains("fn") && !code.contains("safe"), "{code}");
    let names: Vec<&str> = words(&code).map(|(_, _, word)| word).collect();
    assert_eq!(names, ["let", "a", "let", "b", "let", "c", "let", "d", "a", "str"]);
}

#[test]
fn functions_are_found() {
    let code = "trait T {\n fn a();\n fn b(x: [u8; 3]) -> u8\n {\n { x[0] }\n }\n}\n\
        struct S { f: fn(u8) -> u8, g: u8 }\nfn c(f: impl Fn(fn(u8)) -> u8) {\n if f { g }\n}\n";
    assert_eq!(functions(code), [(3, 6), (9, 11)]);
}

#[test]
fn names_are_split_into_parts() {
    assert!(is_forbidden("collision_helper") && is_forbidden("PairManager") && is_forbidden("TICKS_MAX"));
    assert!(!is_forbidden("ticket") && !is_forbidden("particle") && !is_forbidden("utilised"));
    let name = concat!("core/src/x", ".rs");
    assert!(is_path(name) && is_path("ARCHITECTURE.md") && !is_path("+ - * / sqrt") && !is_path("1/60"));
}
