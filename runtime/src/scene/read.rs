//! Text to document.

use super::build::Build;
use super::check;
use super::error::{Problem, SceneError};
use super::format::Scene;
use super::strict::Strict;
use super::{Limits, obj};
use std::path::Path;

/// The mark with which some editors start a file: not JSON, but it does no harm.
const MARK: &[u8] = b"\xef\xbb\xbf";

impl Scene {
    /// Reads a document from JSON text (UTF-8, at most `limits.file_bytes` long) and checks all that can be
    /// checked without its mesh files.
    ///
    /// Errors have line, column and path, but no file.
    pub fn from_json(text: &[u8], limits: &Limits) -> Result<Self, SceneError> {
        let root = super::place::Place::Root;
        check::at_most(root, "bytes", text.len() as u64, limits.file_bytes)?;
        let scene = parse(text)?;
        check::check(&scene, limits).map_err(|mut error| {
            error.at = super::place::locate(text, &error.path);
            error
        })?;
        Ok(scene)
    }

    /// Reads a document from a file, as [`Scene::from_json`] does. Errors name the file.
    pub fn read(file: &Path, limits: &Limits) -> Result<Self, SceneError> {
        read_text(file, limits).map(|(scene, _)| scene)
    }
}

/// Reads a document from a file and builds its world; mesh files are looked for from the file's folder.
///
/// Errors name the file, line and column, also those that only building finds.
pub fn load(file: &Path, limits: &Limits) -> Result<Build, SceneError> {
    let (scene, text) = read_text(file, limits)?;
    let folder = file.parent().unwrap_or(Path::new(""));
    scene.build_within(folder, limits).map_err(|error| error.in_text(file, &text))
}

fn read_text(file: &Path, limits: &Limits) -> Result<(Scene, Vec<u8>), SceneError> {
    let text = obj::read_file(file, limits.file_bytes).map_err(|problem| SceneError {
        file: Some(file.to_path_buf()),
        at: None,
        path: String::new(),
        problem,
    })?;
    match Scene::from_json(&text, limits) {
        Ok(scene) => Ok((scene, text)),
        Err(error) => Err(error.in_text(file, &text)),
    }
}

fn parse(text: &[u8]) -> Result<Scene, SceneError> {
    let mut deserializer = serde_json::Deserializer::from_slice(text.strip_prefix(MARK).unwrap_or(text));
    let mut track = serde_path_to_error::Track::new();
    let tracked = serde_path_to_error::Deserializer::new(Strict(&mut deserializer), &mut track);
    let result = <Scene as serde::Deserialize>::deserialize(tracked);
    match result {
        Ok(scene) => match deserializer.end() {
            Ok(()) => Ok(scene),
            Err(error) => Err(format_error(&error, String::new(), text)),
        },
        Err(error) => {
            let path = track.path();
            let path = if path.iter().next().is_none() { String::new() } else { path.to_string() };
            Err(format_error(&error, path, text))
        }
    }
}

fn format_error(error: &serde_json::Error, path: String, text: &[u8]) -> SceneError {
    let (line, column) = (error.line(), error.column());
    let message = error.to_string();
    // The place is told apart from the message.
    let message = message.strip_suffix(&format!(" at line {line} column {column}")).unwrap_or(&message);
    // Of a value that is not what it should be, the reader knows the end; its start is found by its path.
    // Where the text itself is broken only the reader knows the place. Columns count from 1; before the first
    // character it says 0.
    let marked = line == 1 && text.starts_with(MARK);
    let stop = (line > 0).then_some((line, column.max(1) + if marked { MARK.len() } else { 0 }));
    let start = if error.is_data() { super::place::locate(text, &path) } else { None };
    let mut error = SceneError::new(path, Problem::Format(message.to_string()));
    error.at = start.or(stop);
    error
}
