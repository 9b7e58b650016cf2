//! What a game that rolls back pays: bytes of a state, saving, going back, and taking steps again.
//!
//! `cargo bench -p cellstep-tests --features peers --bench snapshot`
//!
//! The pyramid of 5,050 boxes, sleep off, after [`SETTLED`] steps. Beside it a plain copy of as many bytes and,
//! with `--features peers`, `rapier3d` with the same boxes, saved and restored by `serde` and `bincode` (fixed-size
//! integers, into a buffer that is there). All take turns, [`TURNS`] of them; a number is compared with those
//! of the same turn, and the medians of the ratios are told beside what is promised.

#[cfg(feature = "peers")]
mod rapier;

use cellstep::math::Vec3;
use cellstep::{
    BodyDef, BodyKind, Capacities, Geometry, Memory, Serial, Settings, ShapeDef, SnapshotRing, new_ring,
};
use cellstep_tests::worlds::{OwnedWorld, add, world_with};
use std::hint::black_box;
use std::time::Instant;

/// Boxes of the lowest row.
const BASE: u32 = 100;
/// Steps before the first measure.
const SETTLED: u32 = 300;
const TURNS: usize = 21;
/// Copies of a turn.
const COPIES: u32 = 20;
/// Frames of a rollback.
const FRAMES: u32 = 8;

/// Middles of the boxes, 1 m wide, just touching.
fn places() -> Vec<Vec3> {
    let row = |row: u32| {
        (0..BASE - row).map(move |i| {
            let x = i as f32 + 0.5 * row as f32 - 0.5 * BASE as f32;
            Vec3::new(x, 0.0, 0.5 + row as f32)
        })
    };
    (0..BASE).flat_map(row).collect()
}

fn pyramid(places: &[Vec3]) -> OwnedWorld {
    let mut world = world_with(Capacities::for_bodies(places.len() as u32 + 1));
    let settings = Settings { dt: 1.0 / 60.0, gravity: Vec3::new(0.0, 0.0, -9.81), ..world.settings() };
    world.set_settings(&settings).expect("numbers in range");
    let of = |half: Vec3| ShapeDef { density: 1000.0, ..ShapeDef::new(Geometry::Box { half_extents: half }) };
    let ground = BodyDef::new(BodyKind::Static, Vec3::new(0.0, 0.0, -1.0));
    add(&mut world, &ground, &of(Vec3::new(200.0, 200.0, 1.0)));
    for &place in places {
        add(&mut world, &BodyDef::new(BodyKind::Dynamic, place), &of(Vec3::splat(0.5)));
    }
    world
}

/// Another way to save a world.
trait Peer {
    fn name(&self) -> String;
    fn step(&mut self);
    /// Bytes of a saved world.
    fn save(&mut self) -> usize;
    /// Back to what was saved last.
    fn restore(&mut self);
}

#[cfg(feature = "peers")]
fn peer(places: &[Vec3]) -> Option<Box<dyn Peer>> {
    Some(Box::new(rapier::Rapier::new(places)))
}

#[cfg(not(feature = "peers"))]
fn peer(_: &[Vec3]) -> Option<Box<dyn Peer>> {
    None
}

/// Seconds of one of `count` calls.
fn time(count: u32, mut call: impl FnMut()) -> f64 {
    let start = Instant::now();
    for _ in 0..count {
        call();
    }
    start.elapsed().as_secs_f64() / f64::from(count)
}

/// Seconds of what is measured, by turn.
#[derive(Default)]
struct Times {
    copy: Vec<f64>,
    save: Vec<f64>,
    restore: Vec<f64>,
    /// Of a step, in a run of [`FRAMES`] that goes straight on.
    step: Vec<f64>,
    /// Of going back and [`FRAMES`] steps.
    rollback: Vec<f64>,
    /// The same with saving before each step, as a game does.
    with_saves: Vec<f64>,
    peer_save: Vec<f64>,
    peer_restore: Vec<f64>,
}

fn turn(
    world: &mut OwnedWorld,
    ring: &mut SnapshotRing<Memory>,
    peer: Option<&mut dyn Peer>,
    times: &mut Times,
) {
    let size = world.snapshot_bytes();
    let (source, mut target) = (vec![1_u8; size], vec![2_u8; size]);
    times.copy.push(time(COPIES, || black_box(&mut target).copy_from_slice(black_box(&source))));
    times
        .save
        .push(time(COPIES, || _ = black_box(&*world).save(black_box(&mut target)).expect("it has room")));
    times.restore.push(time(COPIES, || world.restore(black_box(&target)).expect("its own snapshot")));

    // What the copies have thrown out of the processor's caches comes back.
    world.step(&mut Serial);
    let start = world.steps();
    ring.save(world).expect("its own ring");
    let steps = time(1, || (0..FRAMES).for_each(|_| _ = world.step(&mut Serial)));
    let straight = world.checksum();
    let rollback = time(1, || {
        ring.restore(world, start).expect("it was saved");
        (0..FRAMES).for_each(|_| _ = world.step(&mut Serial));
    });
    assert_eq!(world.checksum(), straight, "a rollback changes no bit");
    let with_saves = time(1, || {
        ring.restore(world, start).expect("it was saved");
        for _ in 0..FRAMES {
            ring.save(world).expect("its own ring");
            world.step(&mut Serial);
        }
    });
    assert_eq!(world.checksum(), straight, "a rollback changes no bit");
    times.step.push(steps / f64::from(FRAMES));
    times.rollback.push(rollback);
    times.with_saves.push(with_saves);
    if let Some(peer) = peer {
        times.peer_save.push(time(1, || _ = black_box(peer.save())));
        times.peer_restore.push(time(1, || peer.restore()));
    }
}

fn median(mut numbers: Vec<f64>) -> f64 {
    numbers.sort_by(f64::total_cmp);
    numbers[numbers.len() / 2]
}

/// The median of the turns' ratios.
fn ratio(over: &[f64], under: &[f64]) -> f64 {
    median(over.iter().zip(under).map(|(a, b)| a / b).collect())
}

fn line(what: &str, found: f64, promise: &str) {
    println!("{what:<58} {found:>9.2}   {promise}");
}

fn tell(times: &Times, name: Option<&str>) {
    let microseconds = |numbers: &[f64]| median(numbers.to_vec()) * 1e6;
    line("plain copy of a snapshot's bytes, us", microseconds(&times.copy), "");
    line("save, us", microseconds(&times.save), "");
    line("restore, us", microseconds(&times.restore), "");
    line("step, us", microseconds(&times.step), "");
    line("speed of save / of a plain copy", ratio(&times.copy, &times.save), ">= 0.5");
    line("speed of restore / of a plain copy", ratio(&times.copy, &times.restore), ">= 0.5");
    line("rollback of 8 frames, in steps", ratio(&times.rollback, &times.step), "<= 8.5");
    line("the same, saving each frame again, in steps", ratio(&times.with_saves, &times.step), "");
    if let Some(name) = name {
        line(&format!("{name}: save, us"), microseconds(&times.peer_save), "");
        line(&format!("{name}: restore, us"), microseconds(&times.peer_restore), "");
        line("speed of save / of theirs", ratio(&times.peer_save, &times.save), ">= 50");
        line("speed of restore / of theirs", ratio(&times.peer_restore, &times.restore), ">= 50");
    }
}

fn main() {
    let places = places();
    let mut world = pyramid(&places);
    let mut peer = peer(&places);
    for _ in 0..SETTLED {
        world.step(&mut Serial);
        if let Some(peer) = &mut peer {
            peer.step();
        }
    }
    let bodies = f64::from(world.body_count());
    println!("{bodies} bodies, {} contacts, after {SETTLED} steps\n", world.contacts().count());
    line("state bytes / bodies", world.snapshot_bytes() as f64 / bodies, "<= 512");
    let mut ring = new_ring(world.capacities(), FRAMES as usize + 1).expect("memory");
    let mut times = Times::default();
    for _ in 0..TURNS {
        turn(&mut world, &mut ring, peer.as_mut().map(|peer| &mut **peer as &mut dyn Peer), &mut times);
    }
    let name = peer.as_ref().map(|peer| peer.name());
    if let Some(peer) = &mut peer {
        line("bytes of the peer / bodies", peer.save() as f64 / bodies, "");
    }
    tell(&times, name.as_deref());
}
