//! Hand-written TOML, and the positions of errors in it.

use crate::StageError;
use crate::track::{LEAST_STEP_S, Track, Value};
use pelage_params::Raw;
use serde::de::DeserializeOwned;
use toml::de::{DeTable, DeValue};

/// Text of a file, for messages that include the line.
#[derive(Clone, Copy, Debug)]
pub struct TomlText<'a> {
    /// File name as given by the user.
    pub name: &'a str,
    /// Text of the file.
    pub text: &'a str,
}

impl<'a> TomlText<'a> {
    /// Wraps the text of a file. Strips the byte order mark that some editors prepend.
    pub fn new(name: &'a str, text: &'a str) -> Self {
        Self { name, text: text.strip_prefix('\u{feff}').unwrap_or(text) }
    }

    /// Parses the text.
    ///
    /// Fails with [`StageError::Input`] with line and key for invalid TOML, an unknown key or an invalid value.
    pub fn parse<T: DeserializeOwned>(&self) -> Result<T, StageError> {
        let broken = |e: toml::de::Error| self.fault_at(e.span().map(|s| s.start), "", e.message().trim().to_owned());
        let document = toml::Deserializer::parse(self.text).map_err(broken)?;
        serde_path_to_error::deserialize(document).map_err(|e| {
            let key = e.path().to_string();
            let key = if key == "." { "" } else { &key };
            let inner = e.inner();
            let at = inner.span().map(|s| s.start).or_else(|| self.find(key));
            self.fault_at(at, key, inner.message().trim().to_owned())
        })
    }

    /// Returns the top-level keys and values, in order.
    ///
    /// Fails with [`StageError::Input`] with the line of invalid TOML.
    pub(crate) fn table(&self) -> Result<Vec<(String, Raw)>, StageError> {
        let broken = |e: toml::de::Error| self.fault_at(e.span().map(|s| s.start), "", e.message().trim().to_owned());
        let document = DeTable::parse(self.text).map_err(broken)?;
        let entries = document.get_ref().iter();
        Ok(entries.map(|(key, value)| (key.get_ref().to_string(), Raw::from_de(value.get_ref()))).collect())
    }

    /// Returns an error at a key such as `model[1].path[0].time_s`.
    pub fn fault(&self, key: &str, reason: impl Into<String>) -> StageError {
        self.fault_at(self.find(key), key, reason.into())
    }

    fn fault_at(&self, byte: Option<usize>, key: &str, reason: String) -> StageError {
        let line = byte.map(|byte| self.text.bytes().take(byte).filter(|b| *b == b'\n').count() + 1);
        let place = match (line, key) {
            (Some(line), "") => format!("line {line}"),
            (Some(line), key) => format!("line {line}, {key}"),
            (None, "") => "whole file".to_owned(),
            (None, key) => key.to_owned(),
        };
        StageError::Input { file: self.name.to_owned(), place, reason }
    }

    /// Returns the byte offset of a key's value, or of the nearest enclosing item that exists.
    fn find(&self, key: &str) -> Option<usize> {
        let document = DeTable::parse(self.text).ok()?;
        let (first, mut rest) = key.split_once(['.', '[']).unwrap_or((key, ""));
        let mut here = document.get_ref().get(first)?;
        while !rest.is_empty() {
            let (step, behind) = rest.split_once(['.', '[']).unwrap_or((rest, ""));
            let inner = match here.get_ref() {
                // A key that contains dots may be quoted.
                DeValue::Table(table) => match table.get(rest) {
                    Some(inner) => Some((inner, "")),
                    None => table.get(step).map(|inner| (inner, behind)),
                },
                DeValue::Array(array) => {
                    let number = step.trim_end_matches(']').parse().ok();
                    number.and_then(|i: usize| array.get(i)).map(|inner| (inner, behind))
                }
                _ => None,
            };
            let Some((inner, behind)) = inner else { break };
            (here, rest) = (inner, behind);
        }
        Some(here.span().start)
    }

    /// Returns the track made of the keys at `key`. They are pairs of time and value, and times must ascend.
    pub(crate) fn track<T>(&self, key: &str, keys: Vec<(f32, T)>) -> Result<Track<T>, StageError>
    where
        T: Value,
    {
        let times: Vec<f32> = keys.iter().map(|key| key.0).collect();
        Track::new(keys).map_err(|i| match (i.checked_sub(1).and_then(|before| times.get(before)), times.get(i)) {
            (Some(before), Some(time)) => self.fault(
                &format!("{key}[{i}].time_s"),
                format!("found {time} after {before}, expected at least {LEAST_STEP_S} s later than the previous key"),
            ),
            _ => self.fault(key, "found no keys, expected at least one"),
        })
    }
}
