//! An executor of one's own: rayon runs the tasks. The bits are the same, as for every executor.
//!
//! `cargo run -p cellstep-tests --example rayon`

use cellstep::scene::builtin::Builtin;
use cellstep::{Executor, Serial, Stage};
use rayon::iter::{IntoParallelRefMutIterator, ParallelIterator};
use std::path::Path;

/// Tasks on rayon's threads.
///
/// The whole contract is: call `run` once for each task, and return when all are done. A task owns what it writes,
/// so there is nothing to synchronise.
struct Rayon;

impl Executor for Rayon {
    fn for_each<T: Send>(&mut self, _: Stage, tasks: &mut [T], run: impl Fn(&mut T) + Sync) {
        // One task is not worth the way to another thread.
        match tasks {
            [task] => run(task),
            tasks => tasks.par_iter_mut().for_each(&run),
        }
    }
}

/// Checksum of a pile of mixed shapes after some steps.
fn play(executor: &mut impl Executor) -> Result<u64, Box<dyn std::error::Error>> {
    let scene = Builtin::find("mixed_pile").ok_or("a built-in scene")?.scene(400)?;
    let mut world = scene.build(Path::new("."))?.world;
    for _ in 0..120 {
        world.step(executor);
    }
    Ok(world.checksum())
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let serial = play(&mut Serial)?;
    let rayon = play(&mut Rayon)?;
    println!("one thread {serial:016x}, {} threads {rayon:016x}", rayon::current_num_threads());
    assert_eq!(serial, rayon, "who runs the tasks changes no bit");
    Ok(())
}
