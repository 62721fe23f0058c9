//! Errors at a line of a file.

use crate::BakeError;

/// Returns an error at a line, counted from 1.
pub(super) fn fault(file: &str, line: usize, reason: impl Into<String>) -> BakeError {
    BakeError::Input { file: file.to_owned(), place: format!("line {line}"), reason: reason.into() }
}
