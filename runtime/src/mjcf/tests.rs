//! The rules of MJCF, one by one, on models of a few lines. Numbers that are not plain to see are MuJoCo's.

mod errors;
mod hostile;
mod rules;

use super::math::{Vector, length, sub};
use super::model::Model;
use crate::scene::{Limits, SceneError};

fn try_read(text: &str) -> Result<Model, SceneError> {
    Model::from_xml(text.as_bytes(), &Limits::default())
}

/// A sound model.
#[track_caller]
fn read(text: &str) -> Model {
    try_read(text).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

/// A sound model with these contents of `<worldbody>`, and sections behind it.
#[track_caller]
fn model(world: &str, sections: &str) -> Model {
    read(&format!("<mujoco><worldbody>{world}</worldbody>{sections}</mujoco>"))
}

/// What is said of an unsound one.
#[track_caller]
fn error(text: &str) -> String {
    match try_read(text) {
        Ok(_) => panic!("accepted: {text}"),
        Err(error) => error.to_string(),
    }
}

#[track_caller]
fn near(found: Vector, expected: Vector) {
    assert!(length(sub(found, expected)) < 1.0e-9, "{found:?}, expected {expected:?}");
}
