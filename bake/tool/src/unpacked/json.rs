//! Reads and writes JSON that users may edit: unknown keys are rejected, and errors name their location.

use pelage_import::BakeError;
use pelage_params::nearest;
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::Value;
use std::fmt::Write as _;

/// Name and contents of a file.
pub type File = (String, Vec<u8>);

/// Writes JSON with each value on its own line.
pub fn to_text(value: &Value) -> String {
    format!("{value:#}\n")
}

/// Maximum number of characters of a line on which [`to_rows`] puts a whole list.
const ROW: usize = 100;

/// Writes JSON with short lists on one line, which keeps long lists of pairs readable.
pub fn to_rows(value: &Value) -> String {
    fn write(value: &Value, indent: usize, out: &mut String) {
        let line = value.to_string();
        let below = |out: &mut String| {
            out.push('\n');
            out.extend(std::iter::repeat_n(' ', indent + 2));
        };
        match value {
            Value::Array(list) if line.len() > ROW || list.iter().any(Value::is_object) => {
                out.push('[');
                for (i, item) in list.iter().enumerate() {
                    out.push_str(if i > 0 { "," } else { "" });
                    below(out);
                    write(item, indent + 2, out);
                }
                let _ = write!(out, "\n{:indent$}]", "");
            }
            Value::Object(object) if !object.is_empty() => {
                out.push('{');
                for (i, (key, item)) in object.iter().enumerate() {
                    out.push_str(if i > 0 { "," } else { "" });
                    below(out);
                    let _ = write!(out, "{}: ", Value::from(key.as_str()));
                    write(item, indent + 2, out);
                }
                let _ = write!(out, "\n{:indent$}}}", "");
            }
            _ => out.push_str(&line),
        }
    }
    let mut out = String::new();
    write(value, 0, &mut out);
    out + "\n"
}

/// Parses a JSON file and rejects unknown keys.
pub fn parse<T: DeserializeOwned + Serialize>(file: &str, bytes: &[u8]) -> Result<T, BakeError> {
    let value = json_value(file, bytes)?;
    let parsed: T = deserialize(file, "", value.clone())?;
    let back = serde_json::to_value(&parsed).map_err(|e| BakeError::Internal(e.to_string()))?;
    known_keys(file, "", &value, &back)?;
    Ok(parsed)
}

/// Parses JSON; `file` is its name, for errors.
pub fn json_value(file: &str, bytes: &[u8]) -> Result<Value, BakeError> {
    serde_json::from_slice(bytes).map_err(|e| BakeError::Input {
        file: file.to_owned(),
        place: format!("line {}, column {}", e.line(), e.column()),
        reason: format!("broken JSON: {e}"),
    })
}

/// Deserializes a value. `at` is its JSON pointer in the file, for errors.
pub fn deserialize<T: DeserializeOwned>(file: &str, at: &str, value: Value) -> Result<T, BakeError> {
    serde_path_to_error::deserialize(value).map_err(|e| {
        let path = e.path().to_string();
        let pointer = path.replace("].", "/").replace(['[', '.'], "/").replace(']', "");
        let place = if path == "." { at.to_owned() } else { format!("{at}/{}", pointer.trim_start_matches('/')) };
        let place = if place.is_empty() { "whole file".into() } else { place };
        BakeError::Input { file: file.to_owned(), place, reason: e.into_inner().to_string() }
    })
}

/// Checks that `found` has exactly the keys of `known`, the same value after parsing and writing. A key that only
/// `found` has is misspelt. A key that only `known` has would be read as null.
pub fn known_keys(file: &str, at: &str, found: &Value, known: &Value) -> Result<(), BakeError> {
    let fail =
        |key: &str, reason: String| BakeError::Input { file: file.to_owned(), place: format!("{at}/{key}"), reason };
    match (found, known) {
        (Value::Object(found), Value::Object(known)) => {
            if let Some(key) = found.keys().find(|k| !known.contains_key(*k)) {
                let near = nearest(key, known.keys().map(String::as_str));
                let near = near.map(|near| format!(", did you mean {near:?}?")).unwrap_or_default();
                return Err(fail(key, format!("unknown key{near}")));
            }
            for (key, known) in known {
                let value = found.get(key).ok_or_else(|| fail(key, "missing".into()))?;
                known_keys(file, &format!("{at}/{key}"), value, known)?;
            }
            Ok(())
        }
        (Value::Array(found), Value::Array(known)) => found
            .iter()
            .zip(known)
            .enumerate()
            .try_for_each(|(i, (found, known))| known_keys(file, &format!("{at}/{i}"), found, known)),
        (Value::Object(_) | Value::Null, _) | (_, Value::Null) => Ok(()),
        (_, Value::Object(_)) => Err(fail("", format!("found {found}, expected an object"))),
        _ => Ok(()),
    }
}

/// Shortens f32 numbers to as few digits as identify them, such as 0.1 for 0.10000000149011612.
pub fn shorten_floats(value: &mut Value) {
    match value {
        Value::Array(list) => list.iter_mut().for_each(shorten_floats),
        Value::Object(object) => object.values_mut().for_each(shorten_floats),
        Value::Number(number) if number.is_f64() => {
            let Some(wide) = number.as_f64() else { return };
            let narrow = wide as f32;
            let short = narrow.to_string().parse::<f64>().ok();
            // The reader parses f64 and converts to f32; the short form is used only if this restores the number.
            let same =
                |s: &f64| (*s as f32).to_bits() == narrow.to_bits() && f64::from(narrow).to_bits() == wide.to_bits();
            if let Some(short) = short.filter(same).and_then(serde_json::Number::from_f64) {
                *number = short;
            }
        }
        _ => {}
    }
}
