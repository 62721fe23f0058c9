//! Errors with the line of a file as position.

use crate::BakeError;

/// Returns an error at a line; lines count from 1.
pub(super) fn fault(file: &str, line: usize, reason: impl Into<String>) -> BakeError {
    BakeError::Input { file: file.to_owned(), place: format!("line {line}"), reason: reason.into() }
}
