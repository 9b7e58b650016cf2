//! Replays: record a game loop, verify it, and find where a run went astray.
//!
//! `cargo run -p cellstep --example replay`

use cellstep::math::Vec3;
use cellstep::replay::{
    AssetSet, Bisection, Limits, Options, Recorder, Replay, Verdict, bisect, bisect_self, verify,
};
use cellstep::{
    Applied, BodyDef, BodyHandle, BodyKind, Capacities, Command, Geometry, Pool, Serial, ShapeDef, new_world,
};

/// Steps of the game.
const STEPS: u64 = 240;

/// Plays the game and records it; with `cheat` somebody changes a body past the recorder before that step.
fn play(cheat: Option<u64>) -> Result<Vec<u8>, Box<dyn std::error::Error>> {
    let mut world = new_world(Capacities { hulls: 1, ..Capacities::for_bodies(40) })?;
    // Assets go through a set that remembers them: a replay stands alone.
    let mut assets = AssetSet::new();
    let tent = [Vec3::X, -Vec3::X, Vec3::Y, -Vec3::Y, Vec3::Z];
    let tent = assets.add_hull(&mut world, &tent)?;
    let ground = world.create_body(&BodyDef::new(BodyKind::Static, Vec3::ZERO))?;
    world.create_shape(ground, &ShapeDef::new(Geometry::HalfSpace))?;

    // A file in a game: it is whole up to the last step, whatever happens.
    let options = Options {
        checksums_every: 1,
        keyframes_every: 120,
        note: "the example".to_string(),
        ..Options::default()
    };
    let mut recorder = Recorder::new(Vec::new(), &world, &assets, &options)?;
    let mut bodies: Vec<BodyHandle> = Vec::new();
    for step in 0..STEPS {
        if cheat == Some(step) {
            let velocity = world.linear_velocity(bodies[2])?;
            world.set_linear_velocity(bodies[2], velocity + Vec3::Z * 1.0e-6)?;
        }
        // What players do goes through the recorder; what the world refuses, too.
        if step % 8 == 0 {
            let place = Vec3::new((step % 3) as f32, (step % 5) as f32, 6.0);
            let create = Command::CreateBody(BodyDef::new(BodyKind::Dynamic, place));
            if let Applied::Body(body) = recorder.apply(&mut world, &create)? {
                let shape = ShapeDef::new(Geometry::Hull(tent));
                recorder.apply(&mut world, &Command::CreateShape(body, shape))?;
                bodies.push(body);
            }
        }
        let body = bodies[step as usize % bodies.len()];
        recorder.apply(&mut world, &Command::ApplyImpulse(body, Vec3::new(200.0, 0.0, 50.0)))?;
        recorder.step(&mut world, &mut Serial);
    }
    Ok(recorder.finish(&world)?)
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let limits = Limits::default();
    let honest = Replay::read(play(None)?)?;
    println!("{} bytes, {} commands in {STEPS} steps", honest.bytes(), honest.command_count());

    // The same bits on any number of threads.
    let mut pool = Pool::new(3)?;
    let verdict = verify(&honest, &mut pool, &limits)?;
    println!("{verdict:?}");
    assert!(matches!(verdict, Verdict::Same { steps: STEPS, .. }));
    let same = bisect_self(&honest, &mut Serial, &mut pool, &limits)?;
    assert_eq!(same, Bisection::Same { steps: STEPS });

    // A game that changes a body without telling the recorder does not verify, and the body is named.
    let other = Replay::read(play(Some(200))?)?;
    let Verdict::Diverged(divergence) = verify(&other, &mut Serial, &limits)? else {
        panic!("the change is noticed")
    };
    println!("{divergence}");
    let Bisection::Parted(parting) = bisect(&honest, &other, &limits)? else { panic!("the change is found") };
    print!("{parting}");
    let field = parting.field.as_ref().expect("both states are known");
    assert_eq!((parting.step, field.place().as_str()), (200, "motions[3].linear[2]"));
    Ok(())
}
