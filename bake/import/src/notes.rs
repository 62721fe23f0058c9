//! Output of an import other than the model: warnings, and records of the files that were read.

use crate::BakeError;
use pelage_formats::InputRecord;
use sha2::{Digest, Sha256};

/// Warnings and file records, gathered while a model is read.
#[derive(Debug, Default)]
pub(super) struct Notes {
    warnings: Vec<String>,
    inputs: Vec<InputRecord>,
}

/// Maximum number of warnings kept. All others are dropped, because a file can have one error per vertex.
const MAX_WARNINGS: usize = 100;

impl Notes {
    /// Records a repair, omission or guess. Stores identical texts once.
    pub fn warn(&mut self, text: impl Into<String>) {
        let text = text.into();
        // The list may exceed the limit by one entry, which tells `finish` that warnings were dropped.
        if self.warnings.len() <= MAX_WARNINGS && !self.warnings.contains(&text) {
            self.warnings.push(text);
        }
    }

    /// Returns the value of `result`. Turns an error into a warning that ends with `consequence`, and returns `None`.
    /// For faults in parts that the picture can do without.
    pub fn or_warn<T>(&mut self, result: Result<T, BakeError>, consequence: &str) -> Option<T> {
        let warn = |error| match error {
            BakeError::Input { place, reason, .. } => self.warn(format!("{place}: {reason}; {consequence}")),
            other => self.warn(format!("{other}; {consequence}")),
        };
        result.map_err(warn).ok()
    }

    /// Records a file or an embedded image.
    pub fn record(&mut self, role: &str, name: &str, bytes: &[u8]) {
        self.inputs.push(input_record(role, name, bytes));
    }

    /// Returns the warnings and the records.
    pub fn finish(mut self) -> (Vec<String>, Vec<InputRecord>) {
        if self.warnings.len() > MAX_WARNINGS {
            self.warnings.truncate(MAX_WARNINGS);
            self.warnings.push(format!("more than {MAX_WARNINGS} warnings; the rest are not shown"));
        }
        (self.warnings, self.inputs)
    }
}

/// Returns the record of an input file, in the form that packages store. Removes folders from `name`, because they
/// would tie the package to one machine.
pub fn input_record(role: &str, name: &str, bytes: &[u8]) -> InputRecord {
    let name = name.rsplit(['/', '\\']).next().unwrap_or_default().to_owned();
    InputRecord { role: role.into(), name, bytes: bytes.len() as u64, sha256: Sha256::digest(bytes).into() }
}

/// Returns the reason why a file that the model names could not be read. In a message it follows the file's name. The
/// error may concern the name or the file.
pub(super) fn why_unreadable(error: BakeError) -> String {
    match error {
        BakeError::Input { reason, .. } => reason,
        BakeError::Io { source, .. } if source.kind() == std::io::ErrorKind::NotFound => {
            "it does not exist; put it where the model looks for it, relative to the model's folder".to_owned()
        }
        BakeError::Io { source, action, .. } => format!("cannot {action} it: {source}"),
        other => other.to_string(),
    }
}
