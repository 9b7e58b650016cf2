//! `cellstep doctor`: whether this machine computes the bits that the release was made with.

use crate::args::DoctorArgs;
use crate::run::processors;
use crate::verify::progress_bar;
use crate::{DIVERGED, Failure, json, say};
use cellstep::float_mode;
use cellstep::scene::builtin::{BUILTIN, Builtin, GOLDEN_STEPS};
use cellstep::{BEHAVIOUR_VERSION, Executor, Pool, Serial};
use serde::Serialize;
use std::fmt;
use std::io::Write;
use std::path::Path;

/// What was found. The names of the fields are the keys of the JSON object.
#[derive(Debug, Serialize)]
struct Findings {
    /// True when every checksum is that of the release.
    matches: bool,
    version: &'static str,
    behaviour_version: u32,
    architecture: &'static str,
    os: &'static str,
    pointer_bits: u32,
    endian: &'static str,
    /// Instruction sets that the compiler was allowed to use.
    built_for: Vec<&'static str>,
    /// Whether debug assertions are in.
    debug_assertions: bool,
    float_mode: Mode,
    /// Threads of the pool.
    workers: usize,
    /// Steps of each scene.
    steps: u32,
    scenes: Vec<SceneSums>,
}

/// What this thread's arithmetic does; all true in the mode that the bits are defined in.
#[derive(Debug, Serialize)]
struct Mode {
    keeps_subnormal_operands: bool,
    keeps_subnormal_results: bool,
    rounds_to_nearest: bool,
}

/// Checksums of a scene, 16 hexadecimal digits.
#[derive(Debug, Serialize)]
struct SceneSums {
    scene: &'static str,
    size: u32,
    matches: bool,
    /// Of the release.
    golden: String,
    /// Here, on one thread.
    serial: String,
    /// Here, on all workers.
    pool: String,
}

/// Steps all built-in scenes, on one thread and on several. Gives the exit code.
pub fn doctor(args: &DoctorArgs, out: &mut impl Write) -> Result<u8, Failure> {
    // More than one even where there is one processor: it is the pool that is tried.
    let workers = args.workers.map_or_else(|| processors().max(2), usize::from);
    let mut pool = Pool::new(workers).map_err(|error| format!("--workers {workers}: {error}"))?;
    let bar = progress_bar("doctor", "scenes", BUILTIN.len() as u64);
    let mut scenes = Vec::new();
    for builtin in BUILTIN {
        scenes.push(sums(builtin, &mut pool)?);
        bar.inc(1);
    }
    bar.finish_and_clear();
    let findings = findings(scenes, workers);
    let code = if findings.matches { 0 } else { DIVERGED };
    let text = if args.json { json(&findings)? } else { findings.to_string() };
    say(out, &text, code)
}

fn sums(builtin: &'static Builtin, pool: &mut Pool) -> Result<SceneSums, Failure> {
    let (golden, serial) = (builtin.golden_checksum(), checksum(builtin, &mut Serial)?);
    let pool = checksum(builtin, pool)?;
    let hex = |sum: u64| format!("{sum:016x}");
    Ok(SceneSums {
        scene: builtin.name,
        size: builtin.golden_size,
        matches: golden == Some(serial) && golden == Some(pool),
        golden: golden.map_or_else(|| "none".to_string(), hex),
        serial: hex(serial),
        pool: hex(pool),
    })
}

fn checksum(builtin: &Builtin, executor: &mut impl Executor) -> Result<u64, Failure> {
    let scene = builtin.scene(builtin.golden_size).map_err(|error| error.to_string())?;
    let mut world = scene.build(Path::new("")).map_err(|error| error.to_string())?.world;
    for _ in 0..GOLDEN_STEPS {
        world.step(executor);
    }
    Ok(world.checksum())
}

fn findings(scenes: Vec<SceneSums>, workers: usize) -> Findings {
    let mode = float_mode::check();
    Findings {
        matches: scenes.iter().all(|scene| scene.matches),
        version: env!("CARGO_PKG_VERSION"),
        behaviour_version: BEHAVIOUR_VERSION,
        architecture: std::env::consts::ARCH,
        os: std::env::consts::OS,
        pointer_bits: usize::BITS,
        endian: if cfg!(target_endian = "little") { "little" } else { "big" },
        built_for: built_for(),
        debug_assertions: cfg!(debug_assertions),
        float_mode: Mode {
            keeps_subnormal_operands: mode.keeps_subnormal_operands,
            keeps_subnormal_results: mode.keeps_subnormal_results,
            rounds_to_nearest: mode.rounds_to_nearest,
        },
        workers,
        steps: GOLDEN_STEPS,
        scenes,
    }
}

/// Those that matter to lanes and square roots, and `fma`, which must change nothing.
fn built_for() -> Vec<&'static str> {
    macro_rules! present {
        ($($name:literal),*) => {
            [$(($name, cfg!(target_feature = $name))),*]
        };
    }
    let known = present!("sse2", "sse4.1", "avx", "avx2", "avx512f", "fma", "neon", "simd128");
    known.into_iter().filter(|(_, is_present)| *is_present).map(|(name, _)| name).collect()
}

impl fmt::Display for Findings {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "cellstep    {}, behaviour version {}", self.version, self.behaviour_version)?;
        writeln!(
            f,
            "machine     {}, {}, {} bits, {} endian",
            self.architecture, self.os, self.pointer_bits, self.endian
        )?;
        let assertions = if self.debug_assertions { ", with debug assertions" } else { "" };
        writeln!(f, "built for   {}{assertions}", self.built_for.join(" "))?;
        let mode = &self.float_mode;
        for (holds, fault) in [
            (mode.keeps_subnormal_operands, "takes subnormal operands for zero"),
            (mode.keeps_subnormal_results, "flushes subnormal results to zero"),
            (mode.rounds_to_nearest, "does not round to nearest"),
        ] {
            if !holds {
                writeln!(f, "arithmetic  {fault}: this thread was switched to another mode")?;
            }
        }
        writeln!(f, "checksums   after {} steps, on one thread and on {}\n", self.steps, self.workers)?;
        writeln!(f, "{:<16} {:>5}  {:<16}  {:<16}  {:<16}", "scene", "size", "release", "serial", "pool")?;
        for sums in &self.scenes {
            let verdict = if sums.matches { "same" } else { "DIFFERS" };
            let SceneSums { scene, size, golden, serial, pool, .. } = sums;
            writeln!(f, "{scene:<16} {size:>5}  {golden:<16}  {serial:<16}  {pool:<16}  {verdict}")?;
        }
        let differing = self.scenes.iter().filter(|scene| !scene.matches).count();
        match differing {
            0 => writeln!(f, "\nThis machine has the release's bits."),
            _ => writeln!(f, "\nThis machine has OTHER bits than the release in {differing} scenes."),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scene(pool: &str) -> SceneSums {
        let sum = "00000000000000aa".to_string();
        SceneSums {
            scene: "wall",
            size: 3,
            matches: sum == pool,
            golden: sum.clone(),
            serial: sum,
            pool: pool.to_string(),
        }
    }

    #[test]
    fn one_difference_is_told() {
        let (same, other) = ("00000000000000aa", "00000000000000ab");
        let good = findings(vec![scene(same), scene(same)], 2);
        assert!(good.matches && good.to_string().contains("has the release's bits"));
        let bad = findings(vec![scene(same), scene(other)], 2);
        assert!(!bad.matches);
        let text = bad.to_string();
        assert_eq!(text.matches("DIFFERS").count(), 1, "{text}");
        assert!(text.contains("OTHER bits than the release in 1 scenes"), "{text}");
    }

    #[test]
    fn another_mode_is_told() {
        let mut found = findings(Vec::new(), 2);
        assert!(!found.to_string().contains("arithmetic"));
        found.float_mode.keeps_subnormal_results = false;
        assert!(found.to_string().contains("flushes subnormal results to zero"));
    }
}
