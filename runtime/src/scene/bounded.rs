//! Readers of lists and tables that give up as soon as there is too much, before memory is taken for it.

use super::format::NAMES_MAX;
use serde::Deserialize;
use serde::de::{Deserializer, Error, MapAccess, SeqAccess, Visitor};
use std::collections::BTreeMap;
use std::fmt;
use std::marker::PhantomData;

/// Reads a list of at most `MAX` entries.
pub(super) fn bounded<'de, D, T, const MAX: usize>(deserializer: D) -> Result<Vec<T>, D::Error>
where
    D: Deserializer<'de>,
    T: Deserialize<'de>,
{
    deserializer.deserialize_seq(List::<T, MAX>(PhantomData))
}

struct List<T, const MAX: usize>(PhantomData<T>);

impl<'de, T: Deserialize<'de>, const MAX: usize> Visitor<'de> for List<T, MAX> {
    type Value = Vec<T>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "a list of at most {MAX} entries")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Vec<T>, A::Error> {
        let mut entries = Vec::new();
        while let Some(entry) = list.next_element()? {
            if entries.len() == MAX {
                return Err(A::Error::custom(format_args!(
                    "too long, expected a list of at most {MAX} entries"
                )));
            }
            entries.push(entry);
        }
        Ok(entries)
    }
}

/// Reads a table of at most [`NAMES_MAX`] entries whose names are distinct.
pub(super) fn unique<'de, D, T>(deserializer: D) -> Result<BTreeMap<String, T>, D::Error>
where
    D: Deserializer<'de>,
    T: Deserialize<'de>,
{
    deserializer.deserialize_map(Table(PhantomData))
}

struct Table<T>(PhantomData<T>);

impl<'de, T: Deserialize<'de>> Visitor<'de> for Table<T> {
    type Value = BTreeMap<String, T>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "an object of at most {NAMES_MAX} named entries")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut table: A) -> Result<Self::Value, A::Error> {
        let mut entries = BTreeMap::new();
        while let Some((name, entry)) = table.next_entry::<String, T>()? {
            if entries.len() == NAMES_MAX {
                let message = format_args!("too long, expected at most {NAMES_MAX} named entries");
                return Err(A::Error::custom(message));
            }
            if entries.contains_key(&name) {
                return Err(A::Error::custom(format_args!(
                    "the name {name:?} is used twice, expected each once"
                )));
            }
            entries.insert(name, entry);
        }
        Ok(entries)
    }
}
