//! Recording a game as it is played.

use super::{AssetSet, Cause, Options, ReplayError, Writer};
use cellstep_core::{Applied, Command, Error, Executor, Line, StepReport, World};
use std::io::Write;

/// Records a world: it is given each command and each step, and passes them on.
///
/// The world stays yours, to read and to query. A change that does not go through the recorder is not in the
/// replay. Where checksums were taken after the step before, and the change comes before the first command of the
/// next one, it is noticed at once, and the state goes into the file as a keyframe with [`Cause::Unrecorded`]: what
/// follows can be played, and the change be named. With [`Options::watches_commands`] all changes are noticed at
/// once. Else they show in the next checksums. To restore the world to another time is such a change: a game that
/// rolls back writes its final steps with a [`Writer`].
///
/// An error of the output ends the recording, not the game: [`Recorder::finish`] tells it.
///
/// ```
/// use cellstep::math::Vec3;
/// use cellstep::replay::{AssetSet, Limits, Options, Recorder, Replay, Verdict, verify};
/// use cellstep::{Applied, BodyDef, BodyKind, Capacities, Command, Geometry, Serial, ShapeDef, new_world};
///
/// let mut world = new_world(Capacities::for_bodies(2))?;
/// let mut recorder = Recorder::new(Vec::new(), &world, &AssetSet::new(), &Options::default())?;
/// let ball = Command::CreateBody(BodyDef::new(BodyKind::Dynamic, Vec3::Z));
/// let Applied::Body(ball) = recorder.apply(&mut world, &ball)? else { unreachable!() };
/// recorder.apply(&mut world, &Command::CreateShape(ball, ShapeDef::new(Geometry::Sphere { radius: 0.5 })))?;
/// for _ in 0..60 {
///     recorder.apply(&mut world, &Command::ApplyForce(ball, Vec3::X))?;
///     recorder.step(&mut world, &mut Serial);
/// }
/// let replay = Replay::read(recorder.finish(&world)?)?;
/// assert!(matches!(verify(&replay, &mut Serial, &Limits::default())?, Verdict::Same { .. }));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Recorder<W> {
    writer: Writer<W>,
    checksums_every: u32,
    keyframes_every: u32,
    /// Checksum after the last step, until it was compared.
    last: Option<u64>,
    /// Steps that were taken.
    taken: u64,
    /// Of them, those up to the last checksums.
    checked: Option<u64>,
    watches: bool,
    failed: Option<ReplayError>,
}

impl<W: Write> Recorder<W> {
    /// Starts a recording with the state of `world`, whose assets are those of `assets`.
    ///
    /// # Errors
    /// [`ReplayError::Assets`] when they are not, and [`ReplayError::Io`].
    pub fn new<M>(out: W, world: &World<M>, assets: &AssetSet, options: &Options) -> Result<Self, ReplayError>
    where
        M: AsRef<[Line]> + AsMut<[Line]>,
    {
        let writer = Writer::new(out, world, assets, options)?;
        let (checksums_every, keyframes_every) = (options.checksums_every, options.keyframes_every);
        let is_checked = checksums_every > 0 || options.watches_commands;
        let last = is_checked.then(|| world.checksum());
        Ok(Self {
            writer,
            checksums_every,
            keyframes_every,
            last,
            taken: 0,
            checked: None,
            watches: options.watches_commands,
            failed: None,
        })
    }

    /// Gives the world a command, and notes it with its outcome. A refused command is noted, too.
    ///
    /// # Errors
    /// That of [`World::apply`].
    pub fn apply<M>(&mut self, world: &mut World<M>, command: &Command) -> Result<Applied, Error>
    where
        M: AsRef<[Line]> + AsMut<[Line]>,
    {
        self.look(world);
        let outcome = world.apply(command);
        if self.failed.is_none() {
            self.writer.command(command, outcome.is_err());
        }
        if self.watches {
            self.last = Some(world.checksum());
        }
        outcome
    }

    /// Takes a step of the world, and writes it.
    pub fn step<M>(&mut self, world: &mut World<M>, executor: &mut impl Executor) -> StepReport
    where
        M: AsRef<[Line]> + AsMut<[Line]>,
    {
        self.look(world);
        self.note(|writer| writer.step());
        let report = world.step(executor);
        self.taken += 1;
        let is_due = |every: u32| every > 0 && self.taken.is_multiple_of(u64::from(every));
        let (checks, keyframe) = (is_due(self.checksums_every), is_due(self.keyframes_every));
        if checks {
            self.last = Some(self.check(world));
        } else if self.watches {
            self.last = Some(world.checksum());
        }
        if keyframe {
            self.keyframe(world, Cause::Periodic);
        }
        report
    }

    /// Writes the state as a keyframe: to be called where it may matter, as on a desync.
    pub fn keyframe_now<M>(&mut self, world: &World<M>)
    where
        M: AsRef<[Line]> + AsMut<[Line]>,
    {
        self.look(world);
        self.keyframe(world, Cause::Asked);
    }

    /// Why the recording ended before its time, if it did.
    pub fn error(&self) -> Option<&ReplayError> {
        self.failed.as_ref()
    }

    /// Ends the recording with the checksums of the world as it is, and gives the output back.
    ///
    /// # Errors
    /// The first error of the output, at whatever step it was.
    pub fn finish<M>(mut self, world: &World<M>) -> Result<W, ReplayError>
    where
        M: AsRef<[Line]> + AsMut<[Line]>,
    {
        self.look(world);
        if self.checked != Some(self.taken) && !self.writer.has_commands() {
            self.check(world);
        }
        match self.failed {
            Some(error) => Err(error),
            None => self.writer.finish(),
        }
    }

    /// Whether the world is as the last step has left it.
    fn look<M: AsRef<[Line]> + AsMut<[Line]>>(&mut self, world: &World<M>) {
        if self.last.take().is_some_and(|last| last != world.checksum()) {
            self.keyframe(world, Cause::Unrecorded);
        }
    }

    fn check<M: AsRef<[Line]> + AsMut<[Line]>>(&mut self, world: &World<M>) -> u64 {
        self.checked = Some(self.taken);
        let sums: Vec<u64> = world.checksum_by_section().map(|(_, sum)| sum).collect();
        self.note(|writer| writer.sums(&sums));
        super::total(&sums)
    }

    fn keyframe<M: AsRef<[Line]> + AsMut<[Line]>>(&mut self, world: &World<M>, cause: Cause) {
        self.note(|writer| writer.keyframe_of(world, cause));
    }

    fn note(&mut self, write: impl FnOnce(&mut Writer<W>) -> Result<(), ReplayError>) {
        if self.failed.is_none() {
            self.failed = write(&mut self.writer).err();
        }
    }
}
