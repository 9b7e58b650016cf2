//! Commands: every call is one, each has one encoding, and bytes from anywhere are refused or exact.

use cellstep::{Command, CommandError};
use cellstep_tests::commands::{KINDS, any};
use cellstep_tests::executors::Random;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

fn encode(command: &Command) -> Vec<u8> {
    let mut bytes = vec![0; Command::BYTES_MAX];
    let length = command.encode(&mut bytes).expect("there is room for any command");
    bytes.truncate(length);
    bytes
}

/// Name of a command's variant.
fn name(command: &Command) -> String {
    let text = format!("{command:?}");
    text.split('(').next().expect("never empty").to_string()
}

fn core(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../core/src").join(path)
}

/// Calls on a world that are no commands, and why.
const OTHERS: [(&str, &str); 13] = [
    ("add_hull", "assets are registered before the first step"),
    ("add_mesh", "assets are registered before the first step"),
    ("add_mesh_with_surfaces", "assets are registered before the first step"),
    ("add_height_field", "assets are registered before the first step"),
    ("add_compound", "assets are registered before the first step"),
    ("apply", "gives a command"),
    ("step", "the step itself"),
    ("step_scheduled", "the step itself, for comparing orderings"),
    ("step_observed", "the step itself"),
    ("drop_caches", "changes no bit of the state"),
    ("queries", "changes no bit of the state"),
    ("restore", "goes to another time as a whole"),
    ("load", "goes to another time as a whole"),
];

/// Names of the public methods of `World` that change it.
fn changing_methods() -> BTreeSet<String> {
    let mut files = vec![core("world.rs")];
    let mut folders = vec![core("world")];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).expect("the core's sources are there") {
            let path = entry.expect("an entry").path();
            if path.is_dir() { folders.push(path) } else { files.push(path) }
        }
    }
    let mut methods = BTreeSet::new();
    for file in files {
        let text = std::fs::read_to_string(file).expect("sources are text");
        // Other types have methods of the same names.
        for block in text.split("\nimpl").filter(|block| block.contains("> World<M> {\n")) {
            let block = &block[..block.find("\n}\n").unwrap_or(block.len())];
            for part in block.split("\n    pub fn ").skip(1) {
                let end = part.find(" {\n").expect("a function has a body");
                let open = part.find(['(', '<']).expect("a function has arguments");
                if part[..end].contains("&mut self") {
                    methods.insert(part[..open].to_string());
                }
            }
        }
    }
    methods
}

/// `set_linear_velocity` as `SetLinearVelocity`.
fn camel_case(name: &str) -> String {
    let capital = |word: &str| word[..1].to_uppercase() + &word[1..];
    name.split('_').map(capital).collect()
}

#[test]
fn every_call_that_changes_a_world_is_a_command() {
    let methods = changing_methods();
    assert!(methods.contains("set_settings") && methods.contains("set_joint_axis"), "{methods:?}");
    let is_other = |name: &String| OTHERS.iter().any(|(other, _)| other == name);
    let expected: BTreeSet<String> =
        methods.iter().filter(|name| !is_other(name)).map(|name| camel_case(name)).collect();
    let mut random = Random::new(1);
    let commands: BTreeSet<String> = (0..KINDS).map(|kind| name(&any(&mut random, kind))).collect();
    assert_eq!(commands.len() as u64, KINDS, "each kind once");
    let missing: Vec<_> = expected.difference(&commands).collect();
    let extra: Vec<_> = commands.difference(&expected).collect();
    assert!(missing.is_empty() && extra.is_empty(), "no command: {missing:?}, no method: {extra:?}");
    // The enumeration itself has no others.
    let text = std::fs::read_to_string(core("command.rs")).expect("sources are text");
    let body = text.split_once("pub enum Command {").expect("it is there").1;
    let variants = body[..body.find("\n}\n").expect("it ends")].matches("\n    /// [`World::").count();
    assert_eq!(variants as u64, KINDS);
    // Each is applied by the method of its name.
    let text = std::fs::read_to_string(core("world/commands.rs")).expect("sources are text");
    for method in methods.iter().filter(|name| !is_other(name)) {
        let arm = format!("Command::{}(", camel_case(method));
        let call = text.split_once(&arm).unwrap_or_else(|| panic!("{arm} is applied")).1;
        let call = call.split_once("=>").expect("an arm").1.split("Command::").next().expect("a call");
        assert!(call.contains(&format!("self.{method}(")), "{arm}: {call}");
    }
}

#[test]
fn every_command_has_one_encoding() {
    let mut random = Random::new(2);
    let (mut longest, mut tags) = (0, BTreeSet::new());
    for round in 0..400 * KINDS {
        let command = any(&mut random, round % KINDS);
        let bytes = encode(&command);
        let (again, length) = Command::decode(&bytes).expect("what was encoded decodes");
        assert_eq!(length, bytes.len());
        // Debug text, since what is not a number is not equal to itself; its sign is not kept.
        assert_eq!(format!("{again:?}"), format!("{command:?}"));
        assert_eq!(encode(&again), bytes);
        longest = longest.max(length);
        tags.insert([bytes[0], bytes[1]]);
        let cut = random.below(length as u64) as usize;
        assert_eq!(Command::decode(&bytes[..cut]), Err(CommandError::End));
        let mut small = vec![0; cut];
        assert_eq!(command.encode(&mut small), Err(CommandError::BufferTooSmall { needed: length }));
    }
    assert!(longest <= Command::BYTES_MAX && longest > Command::BYTES_MAX / 2, "{longest}");
    assert_eq!(tags.len() as u64, KINDS);
}

/// Bytes that are accepted come back exactly.
fn check_bytes(bytes: &[u8]) -> Result<(), CommandError> {
    let (command, length) = Command::decode(bytes)?;
    assert_eq!(encode(&command), bytes[..length]);
    Ok(())
}

#[test]
fn hostile_bytes_are_refused_or_exact() {
    let mut random = Random::new(3);
    let (mut taken, mut refused) = (0, 0);
    for round in 0..2000 * KINDS {
        let mut bytes = encode(&any(&mut random, round % KINDS));
        for _ in 0..1 + random.below(3) {
            let bit = random.below(bytes.len() as u64 * 8);
            bytes[bit as usize / 8] ^= 1 << (bit % 8);
        }
        match check_bytes(&bytes) {
            Ok(()) => taken += 1,
            Err(_) => refused += 1,
        }
    }
    assert!(taken > 10_000 && refused > 1000, "{taken} taken, {refused} refused");
    for _ in 0..20_000 {
        let bytes: Vec<u8> = (0..random.below(64)).map(|_| random.bits() as u8).collect();
        let _ = check_bytes(&bytes);
    }
    assert_eq!(Command::decode(&[0x11, 0x02, 0, 0]), Err(CommandError::Tag { tag: 0x0211 }));
    let wake = [0x1e, 0x01, 0, 0, 0, 0, 1, 0, 0, 0, 2];
    assert_eq!(Command::decode(&wake), Err(CommandError::Value { offset: 11 }));
}
