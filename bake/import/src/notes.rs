//! What an import has to tell besides the model: warnings, and the files that were read.

use crate::BakeError;
use pelage_formats::InputRecord;
use sha2::{Digest, Sha256};

/// Warnings and records, gathered while a model is read.
#[derive(Debug, Default)]
pub(super) struct Notes {
    warnings: Vec<String>,
    inputs: Vec<InputRecord>,
}

/// Warnings beyond this many are counted, not kept: a file can be wrong once per vertex.
const MAX_WARNINGS: usize = 100;

impl Notes {
    /// Notes what was repaired, left out or guessed. The same sentence is kept once.
    pub fn warn(&mut self, text: impl Into<String>) {
        let text = text.into();
        // The list grows one past the limit only for the count, which `finish` writes.
        if self.warnings.len() <= MAX_WARNINGS && !self.warnings.contains(&text) {
            self.warnings.push(text);
        }
    }

    /// Notes a file or an embedded image.
    pub fn record(&mut self, role: &str, name: &str, bytes: &[u8]) {
        self.inputs.push(input_record(role, name, bytes));
    }

    /// The warnings and the records.
    pub fn finish(mut self) -> (Vec<String>, Vec<InputRecord>) {
        if self.warnings.len() > MAX_WARNINGS {
            self.warnings.truncate(MAX_WARNINGS);
            self.warnings.push(format!("more than {MAX_WARNINGS} warnings; the rest is not shown"));
        }
        (self.warnings, self.inputs)
    }
}

/// What a package keeps of a file that was read. `name` may have folders, which are cut off: they would tie the package to a machine.
pub fn input_record(role: &str, name: &str, bytes: &[u8]) -> InputRecord {
    let name = name.rsplit(['/', '\\']).next().unwrap_or_default().to_owned();
    InputRecord { role: role.into(), name, bytes: bytes.len() as u64, sha256: Sha256::digest(bytes).into() }
}

/// Why a file that the model names could not be had, to follow its name in a sentence. A reader may complain about the name itself or
/// about the file behind it: either way the model names it.
pub(super) fn why_unreadable(error: BakeError) -> String {
    match error {
        BakeError::Input { reason, .. } => reason,
        BakeError::Io { source, .. } if source.kind() == std::io::ErrorKind::NotFound => {
            "it is not there; put it where the model looks for it, relative to its own folder".to_owned()
        }
        BakeError::Io { source, action, .. } => format!("cannot {action} it: {source}"),
        other => other.to_string(),
    }
}
