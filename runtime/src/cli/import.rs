//! `cellstep import`: from a model in MJCF to a scene document.

use crate::args::ImportArgs;
use cellstep::mjcf::{Effect, Model, Warning};
use cellstep::scene::{Limits, Scene};
use std::io::{self, Write};
use std::path::Path;

/// Reads a model and writes its scene; the text for standard output. Errors are for the user.
pub fn import(args: &ImportArgs) -> Result<String, String> {
    let text = scene(&args.file)?.to_json();
    // A model may say what a scene may not: a mass of 1e15 kg.
    Scene::from_json(text.as_bytes(), &Limits::default())
        .map_err(|error| format!("{}: its scene is refused: {error}", args.file.display()))?;
    let Some(output) = &args.output else { return Ok(text) };
    std::fs::write(output, &text).map_err(|error| format!("cannot write {}: {error}", output.display()))?;
    Ok(String::new())
}

/// True for the name of a model's file.
pub fn is_model(file: &Path) -> bool {
    file.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("xml"))
}

/// Reads a model as a scene and tells what is not in it.
pub fn scene(file: &Path) -> Result<Scene, String> {
    let model = Model::read(file, &Limits::default()).map_err(|error| error.to_string())?;
    let conversion = model.to_scene().map_err(|error| format!("{}: {error}", file.display()))?;
    let text = lines(&conversion.warnings);
    // What cannot be shown is no reason to stop.
    let _ = io::stderr().write_all(text.as_bytes());
    Ok(conversion.scene)
}

/// A line for each warning; what every model has and no scene needs is in one line of each kind.
fn lines(warnings: &[Warning]) -> String {
    let mut text = String::new();
    for warning in
        warnings.iter().filter(|warning| matches!(warning.effect, Effect::Motion | Effect::Unknown))
    {
        text += &format!("warning: {warning}\n");
    }
    for (effect, said) in
        [(Effect::Solver, "of MuJoCo's solver"), (Effect::Nothing, "without effect on motion")]
    {
        let names = warnings.iter().filter(|warning| warning.effect == effect);
        let names: Vec<String> =
            names.map(|warning| format!("{} ({})", warning.what, warning.count)).collect();
        if !names.is_empty() {
            text += &format!("note: ignored, {said}: {}\n", names.join(", "));
        }
    }
    text
}
