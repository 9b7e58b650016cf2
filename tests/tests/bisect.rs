//! Bisection: planted differences are named by step, stage, body and field, with both values.

use cellstep::math::Vec3;
use cellstep::replay::{
    AssetSet, Bisection, Cause, Limits, Moment, Options, Parting, Player, Recorder, Replay, Run, Verdict,
    Writer, bisect, bisect_self, verify,
};
use cellstep::scene::Build;
use cellstep::scene::builtin::{BUILTIN, Builtin};
use cellstep::{
    BodyDef, BodyHandle, BodyKind, Capacities, Command, Executor, Geometry, Observer, Pool, Serial, ShapeDef,
    Stage, StageView, xxh64,
};
use cellstep_tests::executors::{Random, Shuffled};
use cellstep_tests::simulator::snapshot;
use cellstep_tests::worlds::{self, OwnedWorld};
use std::path::Path;

const LIMITS: Limits = Limits { world_bytes: 256 << 20 };
const STEPS: u64 = 60;

fn options(checksums_every: u32, keyframes_every: u32) -> Options {
    Options { checksums_every, keyframes_every, note: String::new(), ..Options::default() }
}

/// The ground and a heap of balls and boxes that touch.
fn heap() -> (OwnedWorld, Vec<BodyHandle>) {
    let mut world = worlds::world_with(Capacities::for_bodies(13));
    worlds::ground(&mut world, 0.6);
    let bodies = (0..12).map(|i| {
        let place = Vec3::new(0.3 * (i % 3) as f32, 0.2 * (i % 2) as f32, 0.6 + 0.9 * i as f32);
        let half_extents = Vec3::splat(0.4);
        let geometry =
            if i % 2 == 0 { Geometry::Sphere { radius: 0.5 } } else { Geometry::Box { half_extents } };
        let def = BodyDef::new(BodyKind::Dynamic, place);
        worlds::add(&mut world, &def, &ShapeDef::new(geometry)).0
    });
    let bodies = bodies.collect();
    (world, bodies)
}

/// One bit of a body's motion.
#[derive(Clone, Copy, Debug)]
struct Flip {
    step: u64,
    /// Index of the number among those of a motion: three sectors, then floats.
    number: usize,
    bit: u32,
    body: BodyHandle,
}

impl Flip {
    /// Field and component of the number.
    fn field(&self) -> (&'static str, usize) {
        let fields = [("center.offset", 3), ("rotation", 6), ("linear", 10), ("angular", 13)];
        let (name, first) = fields.into_iter().rfind(|(_, first)| *first <= self.number).expect("a float");
        (name, self.number - first)
    }

    fn plant(&self, world: &mut OwnedWorld) {
        let mut bytes = snapshot(world);
        let motions =
            world.snapshot_sections(&bytes).expect("its own").find(|section| section.name == "motions");
        let motions = motions.expect("there are bodies");
        let byte = motions.range.start + self.body.index as usize * motions.row_bytes + 4 * self.number;
        bytes[byte + self.bit as usize / 8] ^= 1 << (self.bit % 8);
        world.load(&bytes).expect("another number is no less valid");
    }
}

/// Records the heap, with a push at each step, and a flip.
fn recorded(options: &Options, flip: Option<Flip>) -> Replay {
    let (mut world, bodies) = heap();
    let mut recorder =
        Recorder::new(Vec::new(), &world, &AssetSet::new(), options).expect("there are no assets");
    for step in 0..STEPS {
        if let Some(flip) = flip.filter(|flip| flip.step == step) {
            flip.plant(&mut world);
        }
        let push = Vec3::new((step % 5) as f32 - 2.0, 1.0, 0.0);
        let body = bodies[step as usize % bodies.len()];
        recorder.apply(&mut world, &Command::ApplyImpulse(body, push)).expect("it is dynamic");
        recorder.step(&mut world, &mut Serial);
    }
    Replay::read(recorder.finish(&world).expect("room")).expect("it is read")
}

fn parting(found: Bisection) -> Parting {
    match found {
        Bisection::Parted(parting) => *parting,
        Bisection::Same { steps } => panic!("no difference in {steps} steps"),
    }
}

#[track_caller]
fn check_field(parting: &Parting, flip: &Flip) {
    let field = parting.field.as_ref().expect("both states are known");
    assert_eq!(field.section, "motions", "{parting}");
    assert_eq!((field.field, field.component), flip.field(), "{parting}");
    assert_eq!(field.bodies, [Some(flip.body), None], "{parting}");
    assert_eq!(field.bodies_that_differ, 1, "{parting}");
    let [Some(a), Some(b)] = field.bits else { panic!("{parting}") };
    assert_eq!(a ^ b, 1 << flip.bit, "{parting}");
    let text = parting.to_string();
    assert!(text.contains(&field.hex(a)) && text.contains(&field.decimal(b)), "{text}");
}

#[test]
fn a_flipped_bit_is_named() {
    let mut random = Random::new(7);
    let (_, bodies) = heap();
    let straight = recorded(&options(1, 0), None);
    for _ in 0..24 {
        let flip = Flip {
            step: 1 + random.below(STEPS - 1),
            number: 3 + random.below(13) as usize,
            // The mantissa without its upper bits: a rotation stays one.
            bit: random.below(12) as u32,
            body: bodies[random.below(bodies.len() as u64) as usize],
        };
        let flipped = recorded(&options(1, 0), Some(flip));
        let found = parting(bisect(&straight, &flipped, &LIMITS).expect("worlds are made"));
        assert_eq!((found.step, found.moment), (flip.step, Moment::BetweenSteps), "{flip:?}\n{found}");
        assert_eq!((found.agreed, found.field_step), (Some(flip.step), flip.step), "{flip:?}\n{found}");
        assert_eq!(found.runs, [Run::First, Run::Second]);
        check_field(&found, &flip);
        // The other way round the values are, too.
        let turned = parting(bisect(&flipped, &straight, &LIMITS).expect("worlds are made"));
        let [a, b] = found.field.as_ref().expect("known").bits;
        assert_eq!(turned.field.as_ref().expect("known").bits, [b, a]);
        // Alone: against what is played here.
        let alone = bisect_self(&flipped, &mut Serial, &mut Shuffled::new(1), &LIMITS);
        let alone = parting(alone.expect("worlds are made"));
        assert_eq!(
            (alone.step, alone.moment, alone.runs),
            (flip.step, Moment::BetweenSteps, [Run::First, Run::Here])
        );
        check_field(&alone, &flip);
    }
}

/// Between two commands of a step, where the checksum after the step alone would not name the body.
#[test]
fn a_flip_between_commands_is_named_where_commands_are_watched() {
    let flip = Flip { step: 30, number: 12, bit: 5, body: heap().1[4] };
    let record = |is_flipped: bool| {
        let (mut world, bodies) = heap();
        let options = Options { watches_commands: true, ..options(20, 20) };
        let mut recorder = Recorder::new(Vec::new(), &world, &AssetSet::new(), &options).expect("no assets");
        for step in 0..50 {
            for (i, &body) in bodies.iter().take(3).enumerate() {
                if is_flipped && step == flip.step && i == 2 {
                    flip.plant(&mut world);
                }
                recorder.apply(&mut world, &Command::ApplyForce(body, Vec3::X)).expect("it is dynamic");
            }
            recorder.step(&mut world, &mut Serial);
        }
        let end = world.checksum();
        (Replay::read(recorder.finish(&world).expect("room")).expect("it is read"), end)
    };
    let (straight, flipped) = (record(false).0, record(true));
    let (flipped, end) = (&flipped.0, flipped.1);
    for found in [
        bisect(&straight, flipped, &LIMITS),
        bisect(flipped, &straight, &LIMITS),
        bisect_self(flipped, &mut Serial, &mut Shuffled::new(1), &LIMITS),
    ] {
        let found = parting(found.expect("worlds are made"));
        assert_eq!((found.step, found.moment), (30, Moment::Commands), "{found}");
        assert!(found.message.starts_with("after command 1 of step 31 the world was changed"), "{found}");
        check_field(&found, &flip);
    }
    let verdict = verify(flipped, &mut Serial, &LIMITS).expect("a world is made");
    let Verdict::Diverged(divergence) = verdict else { panic!("it is noticed") };
    let expected =
        "after step 30 and 2 commands: the recorded world was changed without a record, in motions";
    assert_eq!(divergence.to_string(), expected);
    // Who goes on from before the change follows it.
    let mut player = Player::new(flipped, &LIMITS).expect("a world is made");
    player.seek(50, &mut Serial).expect("keyframes are states");
    assert_eq!(player.world().checksum(), end);
}

/// As a game that rolls back records: states of its own at each step, written when they are final.
#[test]
fn keyframes_of_another_machine_name_the_field() {
    let record = |flip: Option<Flip>| {
        let (mut world, _) = heap();
        let mut writer =
            Writer::new(Vec::new(), &world, &AssetSet::new(), &options(0, 0)).expect("no assets");
        for step in 0..40 {
            if let Some(flip) = flip.filter(|flip| flip.step == step) {
                flip.plant(&mut world);
                writer.keyframe(&snapshot(&world), Cause::Asked).expect("room");
            }
            writer.step().expect("room");
            world.step(&mut Serial);
            writer.keyframe(&snapshot(&world), Cause::Asked).expect("room");
        }
        Replay::read(writer.finish().expect("room")).expect("it is read")
    };
    let straight = record(None);
    for number in [4, 8, 11, 14] {
        let flip = Flip { step: 17, number, bit: 3, body: heap().1[5] };
        let flipped = record(Some(flip));
        let found = parting(bisect(&straight, &flipped, &LIMITS).expect("worlds are made"));
        // The first keyframe after step 17 agrees, and the second does not.
        assert_eq!((found.step, found.agreed, found.moment), (17, Some(17), Moment::BetweenSteps), "{found}");
        check_field(&found, &flip);
    }
}

#[test]
fn without_a_keyframe_near_the_interval_is_told() {
    let flip = Flip { step: 25, number: 11, bit: 10, body: heap().1[3] };
    let (straight, flipped) = (recorded(&options(10, 0), None), recorded(&options(10, 0), Some(flip)));
    let found = parting(bisect(&straight, &flipped, &LIMITS).expect("worlds are made"));
    assert_eq!((found.step, found.agreed, found.moment), (30, Some(20), Moment::Unknown), "{found}");
    assert!(found.field.is_none() && found.message.contains("second recording"), "{found}");
    let (straight, flipped) = (recorded(&options(10, 50), None), recorded(&options(10, 50), Some(flip)));
    let found = parting(bisect(&straight, &flipped, &LIMITS).expect("worlds are made"));
    assert_eq!((found.step, found.field_step), (30, 50), "{found}");
    let field = found.field.as_ref().expect("there is a keyframe at step 50");
    assert!(field.bits[0] != field.bits[1] && field.section == "motions", "{found}");
    // Checksums and a keyframe at once: the stage that writes the field last.
    let (straight, flipped) = (recorded(&options(3, 3), None), recorded(&options(3, 3), Some(flip)));
    let found = parting(bisect(&straight, &flipped, &LIMITS).expect("worlds are made"));
    assert_eq!((found.step, found.agreed, found.field_step), (27, Some(24), 27), "{found}");
    assert!(matches!(bisect(&straight, &straight, &LIMITS), Ok(Bisection::Same { steps: STEPS })));
}

#[test]
fn other_commands_are_named() {
    let record = |push: f32| {
        let (mut world, bodies) = heap();
        let mut recorder =
            Recorder::new(Vec::new(), &world, &AssetSet::new(), &options(5, 0)).expect("no assets");
        for step in 0..20 {
            recorder.apply(&mut world, &Command::Wake(bodies[0])).expect("it is there");
            let push = Vec3::new(if step == 13 { push } else { 1.0 }, 0.0, 0.0);
            recorder.apply(&mut world, &Command::SetLinearVelocity(bodies[2], push)).expect("it moves");
            recorder.step(&mut world, &mut Serial);
        }
        Replay::read(recorder.finish(&world).expect("room")).expect("it is read")
    };
    let found = parting(bisect(&record(1.0), &record(1.0000001), &LIMITS).expect("worlds are made"));
    assert_eq!((found.step, found.moment), (13, Moment::Commands), "{found}");
    assert!(found.message.starts_with("command 1 of step 14: SetLinearVelocity"), "{found}");
    let field = found.field.expect("both are played");
    assert_eq!((field.place().as_str(), field.bits[0]), ("motions[3].linear[0]", Some(0x3f80_0000)));
    assert_eq!(field.bodies[0], Some(heap().1[2]));
}

#[test]
fn other_starts_are_named() {
    let (mut world, bodies) = heap();
    let start = |world: &OwnedWorld| {
        let recorder = Recorder::new(Vec::new(), world, &AssetSet::new(), &options(1, 0)).expect("no assets");
        Replay::read(recorder.finish(world).expect("room")).expect("it is read")
    };
    let first = start(&world);
    world.set_body_user(bodies[1], 9).expect("it is there");
    let found = parting(bisect(&first, &start(&world), &LIMITS).expect("worlds are made"));
    assert_eq!(found.moment, Moment::Start);
    let field = found.field.expect("both are known");
    assert_eq!((field.place().as_str(), field.bits), ("bodies[2].user[0]", [Some(0), Some(9)]));
    let other = start(&worlds::world(3));
    let found = parting(bisect(&first, &other, &LIMITS).expect("worlds are made"));
    assert!(found.moment == Moment::Start && found.field.is_none(), "{found}");
}

/// The recording of a built-in scene.
fn built_in(name: &str, size: u32, steps: u32) -> Replay {
    let scene = Builtin::find(name).expect("it exists").scene(size).expect("in range");
    let Build { mut world, assets, .. } = scene.build(Path::new("")).expect("it builds");
    let mut recorder = Recorder::new(Vec::new(), &world, &assets, &options(1, 0)).expect("its own");
    for _ in 0..steps {
        recorder.step(&mut world, &mut Serial);
    }
    Replay::read(recorder.finish(&world).expect("room")).expect("it is read")
}

#[test]
fn runs_on_other_executors_are_the_same_after_each_stage() {
    for builtin in BUILTIN {
        let replay = built_in(builtin.name, builtin.golden_size.min(60), 8);
        let mut pool = Pool::new(3).expect("threads");
        let found = bisect_self(&replay, &mut Serial, &mut pool, &LIMITS).expect("a world is made");
        assert!(matches!(found, Bisection::Same { steps: 8 }), "{}: {found:?}", builtin.name);
    }
}

/// Notes the stages, and the checksums of what there is to see at the end.
#[derive(Default)]
struct Watcher {
    stages: Vec<Stage>,
    sums: Vec<(&'static str, u64)>,
    rows: usize,
}

impl Observer for Watcher {
    fn after(&mut self, stage: Stage, view: &StageView<'_, '_>) {
        self.stages.push(stage);
        self.sums = view.sections().map(|(name, bytes)| (name, xxh64(bytes, 0))).collect();
        self.rows += view.rows().map(|(_, bytes)| bytes.len()).sum::<usize>();
    }
}

#[test]
fn observers_see_the_state_after_each_stage() {
    let scene = Builtin::find("ragdolls").expect("it exists").scene(2).expect("in range");
    let Build { mut world, .. } = scene.build(Path::new("")).expect("it builds");
    for _ in 0..30 {
        let mut watcher = Watcher::default();
        world.step_observed(&mut Serial, &mut watcher);
        assert_eq!(watcher.stages, Stage::ALL[..7]);
        assert!(watcher.sums.iter().copied().eq(world.checksum_by_section()));
        assert!(watcher.rows > 0);
    }
    let mut twin = scene.build(Path::new("")).expect("it builds").world;
    worlds::run(&mut twin, 30);
    assert_eq!(twin.checksum(), world.checksum(), "who looks changes nothing");
}

/// Leaves out a task of a stage in a step.
struct Careless {
    stage: Stage,
    step: u32,
    steps: u32,
}

impl Executor for Careless {
    fn for_each<T: Send>(&mut self, stage: Stage, tasks: &mut [T], run: impl Fn(&mut T) + Sync) {
        let left_out = usize::from(stage == self.stage && self.steps == self.step);
        let count = tasks.len() - left_out.min(tasks.len());
        for task in &mut tasks[..count] {
            run(task);
        }
    }

    fn leave(&mut self) {
        self.steps += 1;
    }
}

#[test]
fn the_stage_of_a_wrong_executor_is_named() {
    let replay = built_in("pyramid", 22, 12);
    for stage in [Stage::Solve, Stage::Finish] {
        let mut careless = Careless { stage, step: 7, steps: 0 };
        let found = bisect_self(&replay, &mut Serial, &mut careless, &LIMITS).expect("a world is made");
        let found = parting(found);
        assert_eq!((found.step, found.agreed, found.moment), (8, Some(7), Moment::Stage(stage)), "{found}");
        assert_eq!(found.runs, [Run::Here, Run::HereAgain]);
        let field = found.field.as_ref().expect("both states are here");
        assert!(field.bits[0] != field.bits[1] && field.bodies[0].is_some(), "{found}");
    }
}
