//! What is wrong with a value, and where.

/// What is wrong with a text, or with one `key=value`.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{}: {reason}", self.place())]
pub struct ParamError {
    /// Line of the text, from 1; `None` where there are no lines.
    pub line: Option<usize>,
    /// The key as it was given: `hair.lean`; empty where the fault is not that of one key.
    pub key: String,
    /// What was found and what was expected.
    pub reason: String,
}

impl ParamError {
    /// Where it is: `line 3, hair.lean`.
    pub fn place(&self) -> String {
        match (self.line, self.key.as_str()) {
            (Some(line), "") => format!("line {line}"),
            (Some(line), key) => format!("line {line}, {key}"),
            (None, key) => key.to_owned(),
        }
    }
}

/// A value outside its range.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{name}: {reason}")]
pub struct OutOfRange {
    /// The knob: `hair.lean`.
    pub name: &'static str,
    /// What was found and what was expected.
    pub reason: String,
}
