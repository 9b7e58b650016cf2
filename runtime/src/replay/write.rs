//! Writing a replay, record by record.

use super::format::{self, ASSET, CHECKSUMS, END, KEYFRAME, STEP, WORLD, WorldRecord};
use super::{AssetSet, Cause, ReplayError};
use cellstep_core::{Command, Line, World};
use std::io::{self, Write};

/// How a replay is recorded.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Options {
    /// Steps from checksums to checksums; 0 for none but those at the end. Each costs a pass over the state, and
    /// another one to see that nobody changed the world without a record.
    pub checksums_every: u32,
    /// Steps from keyframe to keyframe; 0 for none but the first state. Each is a whole snapshot.
    pub keyframes_every: u32,
    /// Whether to look for changes without a record after every command, too, and not only between steps: costs a
    /// pass over the state for each command and each step. For finding who changes the world.
    pub watches_commands: bool,
    /// Free text: where the recording comes from.
    pub note: String,
}

impl Default for Options {
    /// Checksums every 10 steps, a keyframe every 600; commands are not watched.
    fn default() -> Self {
        Self { checksums_every: 10, keyframes_every: 600, watches_commands: false, note: String::new() }
    }
}

/// Writes the records of a replay; [`Recorder`](super::Recorder) decides which.
///
/// For games that roll back, which know late what happened in a step: give it the commands, checksums and
/// snapshots of a step once they are final. Every record is one `write_all`, so give it a file without a buffer of
/// its own where the last step before a crash matters.
#[derive(Debug)]
pub struct Writer<W> {
    out: W,
    seal: u64,
    step: u64,
    record: Vec<u8>,
    commands: Vec<u8>,
    count: u32,
}

impl<W: Write> Writer<W> {
    /// Starts a replay with the state of `world`, whose assets are those of `assets`.
    ///
    /// # Errors
    /// [`ReplayError::Assets`] when they are not, and [`ReplayError::Io`].
    pub fn new<M>(out: W, world: &World<M>, assets: &AssetSet, options: &Options) -> Result<Self, ReplayError>
    where
        M: AsRef<[Line]> + AsMut<[Line]>,
    {
        if assets.hash() != world.assets_hash() {
            return Err(ReplayError::Assets);
        }
        let preamble = format::preamble();
        let seal = cellstep_core::xxh64(&preamble, 0);
        let (record, commands) = (Vec::new(), Vec::new());
        let mut writer = Self { out, seal, step: world.steps(), record, commands, count: 0 };
        writer.out.write_all(&preamble)?;
        let first = WorldRecord {
            capacities: *world.capacities(),
            layout_hash: world.layout_hash(),
            assets_hash: world.assets_hash(),
            checksums_every: options.checksums_every,
            keyframes_every: options.keyframes_every,
            watches_commands: options.watches_commands,
            note: options.note.clone(),
        };
        writer.write(WORLD, &[&first.to_bytes()])?;
        for asset in assets.encoded() {
            writer.write(ASSET, &[asset])?;
        }
        writer.keyframe_of(world, Cause::Start)?;
        Ok(writer)
    }

    /// Steps of the world after what was written.
    pub fn steps(&self) -> u64 {
        self.step
    }

    /// Adds a command to the step that [`Writer::step`] will write, and whether the world refused it.
    pub fn command(&mut self, command: &Command, is_refused: bool) {
        let mut room = [0; Command::BYTES_MAX];
        let length = command.encode(&mut room).expect("there is room for any command");
        self.commands.push(u8::from(is_refused));
        self.commands.extend_from_slice(&room[..length]);
        self.count += 1;
    }

    /// Writes the step that the world takes now, with the commands since the step before. Written before the step
    /// is taken, so that a step that does not come back is in the file.
    ///
    /// # Errors
    /// [`ReplayError::Io`].
    pub fn step(&mut self) -> Result<(), ReplayError> {
        let commands = std::mem::take(&mut self.commands);
        let (step, count) = (self.step.to_le_bytes(), self.count.to_le_bytes());
        let written = self.write(STEP, &[&step, &count, &commands]);
        self.commands = commands;
        self.commands.clear();
        self.count = 0;
        self.step += 1;
        written
    }

    /// Writes the checksums of a world as it is after the last step, before commands for the next one.
    ///
    /// # Errors
    /// [`ReplayError::Io`].
    pub fn checksums<M>(&mut self, world: &World<M>) -> Result<(), ReplayError>
    where
        M: AsRef<[Line]> + AsMut<[Line]>,
    {
        let sums: Vec<u64> = world.checksum_by_section().map(|(_, sum)| sum).collect();
        self.sums(&sums)
    }

    pub(super) fn sums(&mut self, sums: &[u64]) -> Result<(), ReplayError> {
        let bytes: Vec<u8> = sums.iter().flat_map(|sum| sum.to_le_bytes()).collect();
        let (step, total) = (self.step.to_le_bytes(), super::total(sums).to_le_bytes());
        self.write(CHECKSUMS, &[&step, &total, &bytes])
    }

    /// True when there are commands that no step has seen.
    pub(super) fn has_commands(&self) -> bool {
        self.count > 0
    }

    /// Writes a snapshot of the state after the last step and the commands since, taken by [`World::save`].
    ///
    /// # Errors
    /// [`ReplayError::World`] when these are no bytes of a snapshot, and [`ReplayError::Io`].
    pub fn keyframe(&mut self, snapshot: &[u8], cause: Cause) -> Result<(), ReplayError> {
        let mut sealed = snapshot.to_vec();
        World::<Vec<Line>>::seal(&mut sealed)?;
        let (step, count) = (self.step.to_le_bytes(), self.count.to_le_bytes());
        self.write(KEYFRAME, &[&[cause as u8], &step, &count, &sealed])
    }

    pub(super) fn keyframe_of<M>(&mut self, world: &World<M>, cause: Cause) -> Result<(), ReplayError>
    where
        M: AsRef<[Line]> + AsMut<[Line]>,
    {
        let mut snapshot = vec![0; world.snapshot_bytes()];
        world.save(&mut snapshot)?;
        self.keyframe(&snapshot, cause)
    }

    /// Writes that the recording ends here, and gives the output back. Commands after the last step are dropped:
    /// no step has seen them.
    ///
    /// # Errors
    /// [`ReplayError::Io`].
    pub fn finish(mut self) -> Result<W, ReplayError> {
        let step = self.step.to_le_bytes();
        self.write(END, &[&step])?;
        self.out.flush()?;
        Ok(self.out)
    }

    fn write(&mut self, kind: u8, parts: &[&[u8]]) -> Result<(), ReplayError> {
        let length: usize = parts.iter().map(|part| part.len()).sum();
        if u32::try_from(length).is_err() {
            return Err(io::Error::new(io::ErrorKind::FileTooLarge, "a record is below 4 GiB").into());
        }
        format::frame(&mut self.record, kind, parts, &mut self.seal);
        Ok(self.out.write_all(&self.record)?)
    }
}
