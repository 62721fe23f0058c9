//! Errors about values, with their location.

/// Error in a text or in one `key=value`.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{}: {reason}", self.location())]
pub struct ParamError {
    /// Line in the text, from 1; `None` if there are no lines.
    pub line: Option<usize>,
    /// Key as given, such as `hair.lean`; empty if the error does not concern a single key.
    pub key: String,
    /// Description of what was found and what was expected.
    pub reason: String,
}

impl ParamError {
    /// Returns the location, such as `line 3, hair.lean`.
    pub fn location(&self) -> String {
        match (self.line, self.key.as_str()) {
            (Some(line), "") => format!("line {line}"),
            (Some(line), key) => format!("line {line}, {key}"),
            (None, key) => key.to_owned(),
        }
    }
}

/// Error for a value outside its range.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{name}: {reason}")]
pub struct OutOfRange {
    /// Name of the knob, such as `hair.lean`.
    pub name: &'static str,
    /// Description of what was found and what was expected.
    pub reason: String,
}
