//! JSON values that know their position, so that every error can name a JSON pointer (RFC 6901).
//!
//! The importer walks the plain JSON tree instead of a typed glTF document. A mistake in a camera or light, which fur
//! never uses, makes a typed parser reject the whole document, without a pointer. A typed document also cannot
//! represent all files that the specification allows, such as an animation channel without a target node or a scene
//! without nodes. The importer reads only what it uses, and checks it while reading.

use super::notes::Notes;
use crate::BakeError;
use serde_json::Value;

/// A JSON value and its position.
#[derive(Clone, Debug)]
pub(super) struct JsonNode<'a> {
    /// Name of the model file, as given by the user.
    pub file: &'a str,
    pub value: &'a Value,
    /// JSON pointer of `value`; empty for the root.
    pub place: String,
}

type Result<T> = std::result::Result<T, BakeError>;

impl<'a> JsonNode<'a> {
    /// Wraps the root of a document.
    pub fn root(file: &'a str, value: &'a Value) -> Self {
        Self { file, value, place: String::new() }
    }

    /// Returns an error at this position.
    pub fn fault(&self, reason: impl Into<String>) -> BakeError {
        let place = if self.place.is_empty() { "/".to_owned() } else { self.place.clone() };
        BakeError::Input { file: self.file.to_owned(), place, reason: reason.into() }
    }

    /// Returns the member `key`, if present. `null` counts as absent, because some exporters write it for "none".
    pub fn get(&self, key: &str) -> Option<JsonNode<'a>> {
        let value = self.value.get(key).filter(|v| !v.is_null())?;
        let key = key.replace('~', "~0").replace('/', "~1");
        Some(JsonNode { file: self.file, value, place: format!("{}/{key}", self.place) })
    }

    /// Returns the extension `name` of this object, if present.
    pub fn extension(&self, name: &str) -> Option<JsonNode<'a>> {
        self.get("extensions")?.get(name)
    }

    /// Returns the member `key`, or an error if absent.
    pub fn require(&self, key: &str) -> Result<JsonNode<'a>> {
        match self.value {
            Value::Object(_) => {
                self.get(key).ok_or_else(|| self.fault(format!("has no `{key}`, which glTF 2.0 requires here")))
            }
            _ => Err(self.unexpected("an object")),
        }
    }

    /// Returns the names of all members, in the order of the file.
    pub fn keys(&self) -> impl Iterator<Item = &'a str> {
        self.value.as_object().into_iter().flat_map(|map| map.keys().map(String::as_str))
    }

    /// Returns the number of entries of an array.
    pub fn len(&self) -> Result<usize> {
        self.value.as_array().map(Vec::len).ok_or_else(|| self.unexpected("an array"))
    }

    /// Returns entry `index` of an array.
    pub fn entry(&self, index: usize) -> Option<JsonNode<'a>> {
        let value = self.value.as_array()?.get(index)?;
        Some(JsonNode { file: self.file, value, place: format!("{}/{index}", self.place) })
    }

    /// Returns all entries of an array.
    pub fn entries(&self) -> Result<impl Iterator<Item = JsonNode<'a>> + use<'a>> {
        let values = self.value.as_array().ok_or_else(|| self.unexpected("an array"))?;
        let (file, place) = (self.file, self.place.clone());
        Ok(values.iter().enumerate().map(move |(i, value)| JsonNode { file, value, place: format!("{place}/{i}") }))
    }

    /// Reads a non-negative whole number. Accepts `5.0` as 5, as JSON Schema does.
    pub fn unsigned(&self) -> Result<u64> {
        if let Some(n) = self.value.as_u64() {
            return Ok(n);
        }
        // Above 2^53 not every whole number is a float.
        let whole = self.value.as_f64().filter(|f| f.fract() == 0.0 && (0.0..=9_007_199_254_740_992.0).contains(f));
        whole.map(|f| f as u64).ok_or_else(|| self.unexpected("a whole number >= 0"))
    }

    /// Reads the non-negative whole number `key`, or returns `default` if it is absent.
    pub fn unsigned_or(&self, key: &str, default: u64) -> Result<u64> {
        self.get(key).map_or(Ok(default), |at| at.unsigned())
    }

    /// Reads a finite number.
    pub fn number(&self) -> Result<f32> {
        let found = self.value.as_f64().ok_or_else(|| self.unexpected("a number"))? as f32;
        if found.is_finite() { Ok(found) } else { Err(self.unexpected("a number within the range of 32-bit floats")) }
    }

    /// Reads an array of exactly `N` finite numbers.
    pub fn numbers<const N: usize>(&self) -> Result<[f32; N]> {
        let found = self.len()?;
        if found != N {
            return Err(self.fault(format!("has {found} numbers, expected {N}")));
        }
        let mut out = [0.0; N];
        for (slot, at) in out.iter_mut().zip(self.entries()?) {
            *slot = at.number()?;
        }
        Ok(out)
    }

    /// Reads a string.
    pub fn string(&self) -> Result<&'a str> {
        self.value.as_str().ok_or_else(|| self.unexpected("a string"))
    }

    /// Reads the boolean `key`; false if it is absent.
    pub fn flag(&self, key: &str) -> Result<bool> {
        self.get(key).map_or(Ok(false), |at| at.value.as_bool().ok_or_else(|| at.unexpected("true or false")))
    }

    /// Returns the member `name`, or an empty string if it is absent or not a string. Names are labels and never cause
    /// an error.
    pub fn name(&self) -> &'a str {
        self.value.get("name").and_then(Value::as_str).unwrap_or_default()
    }

    /// Reads an index from `reference`. Returns the index, and the entry that it selects in the array `list` of this
    /// object. This object must be the root.
    pub fn follow(&self, list: &str, reference: &JsonNode<'a>) -> Result<(usize, JsonNode<'a>)> {
        let index = reference.unsigned()?;
        let array = self.get(list);
        let count = array.as_ref().map_or(Ok(0), JsonNode::len)?;
        let found = usize::try_from(index).ok().and_then(|i| Some((i, array?.entry(i)?)));
        found.ok_or_else(|| reference.fault(format!("is {index}, expected less than {count}, the number of {list}")))
    }

    /// Returns an error with the value found and the value `expected`.
    pub fn unexpected(&self, expected: &str) -> BakeError {
        let found = match self.value {
            Value::Null => "null".to_owned(),
            Value::Bool(b) => b.to_string(),
            Value::Number(n) => n.to_string(),
            Value::String(s) => format!("\"{}\"", shorten(s)),
            Value::Array(a) => format!("an array of {}", a.len()),
            Value::Object(_) => "an object".to_owned(),
        };
        self.fault(format!("is {found}, expected {expected}"))
    }
}

/// Shortens text from a file to at most 60 characters, without control characters, for messages.
pub(super) fn shorten(text: &str) -> String {
    let clean = |c: char| if c.is_control() { '\u{fffd}' } else { c };
    let mut out: String = text.chars().take(60).map(clean).collect();
    if text.chars().nth(60).is_some() {
        out.push('…');
    }
    out
}

/// Maximum memory for a parsed document, bytes. A limit is needed because short values take up to 100 times their text.
const MAX_PARSED: u64 = 640 << 20;

/// Returns an upper estimate of the memory that the parsed document takes, bytes, without long strings. The numbers are
/// those of `serde_json`'s objects and arrays of up to four entries, of further entries, and of short strings.
fn parsed_bytes(json: &[u8]) -> u64 {
    let (mut sum, mut in_string, mut escaped) = (0, false, false);
    for byte in json {
        match byte {
            _ if escaped => escaped = false,
            b'\\' if in_string => escaped = true,
            b'"' => {
                in_string = !in_string;
                sum += 16;
            }
            _ if in_string => {}
            b'{' => sum += 480,
            b'[' => sum += 288,
            b',' => sum += 104,
            _ => {}
        }
    }
    sum
}

/// Members that hold an index and may be absent. Some exporters write -1 for "none".
const OPTIONAL_INDICES: &[&str] =
    &["camera", "indices", "inverseBindMatrices", "material", "mesh", "node", "scene", "skin", "source"];

/// Removes optional indices of -1 from the tree below `place`, and adds their positions to `removed`. Recursion is
/// bounded, because the parser limits the depth of the tree.
fn remove_minus_one(value: &mut Value, place: &str, removed: &mut Vec<String>) {
    let is_tree = |value: &Value| value.is_object() || value.is_array();
    match value {
        Value::Array(list) => {
            for (i, value) in list.iter_mut().enumerate().filter(|(_, value)| is_tree(value)) {
                remove_minus_one(value, &format!("{place}/{i}"), removed);
            }
        }
        Value::Object(map) => {
            for key in OPTIONAL_INDICES {
                if map.get(*key).and_then(Value::as_f64) == Some(-1.0) {
                    map.shift_remove(*key);
                    removed.push(format!("{place}/{key}"));
                }
            }
            for (key, value) in map.iter_mut().filter(|(key, value)| *key != "extras" && is_tree(value)) {
                remove_minus_one(value, &format!("{place}/{}", shorten(key)), removed);
            }
        }
        _ => {}
    }
}

/// Parses `json`, which begins at byte `offset` of the file. Optional indices of -1 are removed.
pub(super) fn parse(file: &str, json: &[u8], offset: usize, notes: &mut Notes) -> Result<Value> {
    let mut document = parse_exactly(file, json, offset)?;
    let mut removed = Vec::new();
    remove_minus_one(&mut document, "", &mut removed);
    if let Some(first) = removed.first() {
        notes.warn(format!("{} indices are -1, such as {first}; treated as absent", removed.len()));
    }
    Ok(document)
}

fn parse_exactly(file: &str, json: &[u8], offset: usize) -> Result<Value> {
    let needed = parsed_bytes(json);
    if needed > MAX_PARSED {
        let gib = |bytes: u64| bytes as f64 / f64::from(1 << 30);
        return Err(BakeError::Input {
            file: file.to_owned(),
            place: format!("byte {offset}"),
            reason: format!(
                "needs {:.1} GiB of memory to parse, expected at most {:.1}; a bake is limited to 1 GiB",
                gib(needed),
                gib(MAX_PARSED)
            ),
        });
    }
    serde_json::from_slice(json).map_err(|error| {
        let mut at = json.len();
        if error.line() > 0 && !error.is_eof() {
            let line_starts =
                std::iter::once(0).chain(json.iter().enumerate().filter(|(_, b)| **b == b'\n').map(|(i, _)| i + 1));
            let start = line_starts.take(error.line()).last().unwrap_or(0);
            at = (start + error.column().saturating_sub(1)).min(json.len());
        }
        // Remove the line and column that the parser appends. In a text of one line, only a byte offset is useful.
        let text = error.to_string();
        let text = text.split(" at line ").next().unwrap_or_default();
        let place = format!("byte {}", offset + at);
        BakeError::Input {
            file: file.to_owned(),
            place,
            reason: format!("is not valid JSON: {text} (line {})", error.line()),
        }
    })
}
