//! Values of attributes: text to numbers and keywords, through default classes, with errors that have a place.

use super::tree::{Files, Tree, shortened};
use crate::scene::{Problem, SceneError};
use std::collections::BTreeMap;

/// Greatest magnitude of a number: squares and products of a few such stay finite.
const NUMBER_MAX: f64 = 1.0e18;
/// Most characters of a name.
const NAME_MAX: usize = 256;

/// Attributes of a default class: the element that gives each.
pub(super) type Defaults = BTreeMap<String, usize>;

/// The attributes of one element, its own first, those of its class behind them.
#[derive(Clone, Copy)]
pub(super) struct Values<'a> {
    pub files: &'a Files,
    pub tree: &'a Tree,
    pub element: usize,
    pub defaults: Option<&'a Defaults>,
}

impl<'a> Values<'a> {
    /// The same element with its own attributes alone.
    pub(super) fn own(self) -> Self {
        Self { defaults: None, ..self }
    }

    /// An attribute's text and the element that has it.
    fn find(&self, name: &str) -> Option<(usize, &'a str)> {
        let of = |element: usize| self.tree.elements[element].text(name).map(|text| (element, text));
        of(self.element).or_else(|| of(*self.defaults?.get(name)?))
    }

    pub(super) fn has(&self, name: &str) -> bool {
        self.find(name).is_some()
    }

    pub(super) fn text(&self, name: &str) -> Option<&'a str> {
        self.find(name).map(|(_, text)| text)
    }

    /// An error at an attribute, or at the element where it has none of that name.
    pub(super) fn error(&self, name: &str, message: impl ToString) -> SceneError {
        let element = self.find(name).map_or(self.element, |(element, _)| element);
        let name = self.has(name).then_some(name);
        self.files.error(self.tree, element, name, Problem::Format(message.to_string()))
    }

    /// The element's `name`; empty without one.
    pub(super) fn name(&self) -> Result<&'a str, SceneError> {
        let name = self.own().text("name").unwrap_or("");
        if name.len() > NAME_MAX {
            let message = format!("a name of {} bytes, expected at most {NAME_MAX}", name.len());
            return Err(self.error("name", message));
        }
        Ok(name)
    }

    /// Between `least` and `most` numbers.
    pub(super) fn list(&self, name: &str, least: usize, most: usize) -> Result<Option<Vec<f64>>, SceneError> {
        let Some(text) = self.text(name) else { return Ok(None) };
        let mut numbers = Vec::new();
        for word in text.split_ascii_whitespace() {
            let number = word.parse::<f64>().ok().filter(|x| x.abs() <= NUMBER_MAX);
            let Some(number) = number else {
                let message = format!("found {:?}, expected numbers within {NUMBER_MAX:e}", shortened(word));
                return Err(self.error(name, message));
            };
            if numbers.len() == most {
                return Err(self.error(name, format!("too many numbers, expected {}", count(least, most))));
            }
            numbers.push(number);
        }
        if numbers.len() < least {
            let message = format!("found {} numbers, expected {}", numbers.len(), count(least, most));
            return Err(self.error(name, message));
        }
        Ok(Some(numbers))
    }

    /// Exactly `N` numbers.
    pub(super) fn numbers<const N: usize>(&self, name: &str) -> Result<Option<[f64; N]>, SceneError> {
        let list = self.list(name, N, N)?;
        Ok(list.and_then(|list| <[f64; N]>::try_from(list).ok()))
    }

    pub(super) fn number(&self, name: &str) -> Result<Option<f64>, SceneError> {
        Ok(self.numbers::<1>(name)?.map(|[x]| x))
    }

    /// A number that is not negative.
    pub(super) fn positive(&self, name: &str) -> Result<Option<f64>, SceneError> {
        let number = self.number(name)?;
        match number.filter(|&x| x < 0.0) {
            Some(x) => Err(self.error(name, format!("found {x}, expected a number that is not negative"))),
            None => Ok(number),
        }
    }

    pub(super) fn integer(&self, name: &str) -> Result<Option<i32>, SceneError> {
        let Some(text) = self.text(name) else { return Ok(None) };
        match text.trim().parse::<i32>() {
            Ok(number) => Ok(Some(number)),
            Err(_) => Err(self.error(name, format!("found {:?}, expected a whole number", shortened(text)))),
        }
    }

    /// The index of a keyword in `words`.
    pub(super) fn keyword(&self, name: &str, words: &[&str]) -> Result<Option<usize>, SceneError> {
        let Some(text) = self.text(name) else { return Ok(None) };
        match words.iter().position(|word| *word == text.trim()) {
            Some(index) => Ok(Some(index)),
            None => {
                let message = format!("found {:?}, expected one of {}", shortened(text), words.join(", "));
                Err(self.error(name, message))
            }
        }
    }

    /// `true` or `false`.
    pub(super) fn truth(&self, name: &str) -> Result<Option<bool>, SceneError> {
        Ok(self.keyword(name, &["false", "true"])?.map(|index| index == 1))
    }

    /// A range that is in force: `limited` says so, or, where it is `auto`, that there is a range.
    pub(super) fn limits(&self, names: [&str; 2], automatic: bool) -> Result<Option<[f64; 2]>, SceneError> {
        let [limited, range_name] = names;
        let range = self.numbers::<2>(range_name)?;
        let given = range.is_some_and(|range| range != [0.0; 2]);
        let in_force = match self.keyword(limited, &["false", "true", "auto"])?.unwrap_or(2) {
            0 => false,
            1 => true,
            _ if automatic => given,
            _ if self.own().has(range_name) => {
                let message = format!("a range without `{limited}`, expected it where `autolimits` is false");
                return Err(self.error(range_name, message));
            }
            _ => false,
        };
        if !in_force {
            return Ok(None);
        }
        let range = range.unwrap_or([0.0; 2]);
        if range[0] >= range[1] {
            let message = format!("found the range {range:?}, expected a first number below the second");
            return Err(self.error(range_name, message));
        }
        Ok(Some(range))
    }
}

fn count(least: usize, most: usize) -> String {
    match (least, most) {
        _ if least == most => format!("{most}"),
        (_, usize::MAX) => format!("at least {least}"),
        _ => format!("{least} to {most}"),
    }
}
