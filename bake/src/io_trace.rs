//! Trace of the files that this process has read and written, for build systems.
//!
//! After a call of [`start`], all functions in [`crate::io`] record their accesses, so no reader has to do so itself.

use sha2::{Digest as _, Sha256};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

static TRAFFIC: Mutex<Option<IoTrace>> = Mutex::new(None);

/// SHA-256 of data read or written.
pub type Digest = [u8; 32];

/// Recorded input.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum TracedInput {
    /// File.
    File {
        /// Path as opened.
        path: PathBuf,
        /// Maximum number of bytes requested.
        most: u64,
        /// SHA-256 of the first `most` bytes; `None` if the file did not exist.
        digest: Option<Digest>,
    },
    /// Property of the machine, such as its adapter.
    Machine {
        /// Name of the property.
        what: &'static str,
        /// Value of the property.
        answer: String,
    },
}

/// File that was written completely.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TracedOutput {
    /// Path as given.
    pub path: PathBuf,
    /// SHA-256 of the contents.
    pub digest: Digest,
}

/// All recorded inputs and outputs, in order.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct IoTrace {
    /// Inputs.
    pub asked: Vec<TracedInput>,
    /// Outputs.
    pub written: Vec<TracedOutput>,
    /// Whether some of the output existed before the command ran, so that `written` is incomplete.
    pub in_part: bool,
}

impl IoTrace {
    /// Returns the existing files that were read, each once.
    pub fn files_read(&self) -> Vec<&Path> {
        let mut files: Vec<&Path> = Vec::new();
        for asked in &self.asked {
            if let TracedInput::File { path, digest: Some(_), .. } = asked
                && !files.contains(&path.as_path())
            {
                files.push(path);
            }
        }
        files
    }
}

fn traffic() -> MutexGuard<'static, Option<IoTrace>> {
    // The trace is valid even if a thread panicked while holding the lock.
    TRAFFIC.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Starts recording.
pub fn start() {
    *traffic() = Some(IoTrace::default());
}

/// Stops recording and returns the trace recorded so far.
pub fn take() -> IoTrace {
    traffic().take().unwrap_or_default()
}

/// Records that a file was requested. The hash of its bytes is only computed while recording.
pub(crate) fn record_read(path: &Path, most: u64, bytes: Option<&[u8]>) {
    if let Some(traffic) = &mut *traffic() {
        let digest = bytes.map(|bytes| Sha256::digest(bytes).into());
        traffic.asked.push(TracedInput::File { path: path.to_owned(), most, digest });
    }
}

/// Records a property of the machine that the output depends on.
pub fn record_machine(what: &'static str, answer: &str) {
    if let Some(traffic) = &mut *traffic() {
        traffic.asked.push(TracedInput::Machine { what, answer: answer.to_owned() });
    }
}

/// Records that some of the output existed before the command ran.
pub fn mark_incomplete() {
    if let Some(traffic) = &mut *traffic() {
        traffic.in_part = true;
    }
}

/// Returns whether a file exists; if not, records that the output depends on its absence.
pub fn exists(path: &Path) -> bool {
    let there = path.exists();
    if !there {
        record_read(path, 0, None);
    }
    there
}

/// Records that a file was written; `digest` is only called while recording.
pub(crate) fn record_written(path: &Path, digest: impl FnOnce() -> Option<Digest>) {
    if let Some(traffic) = &mut *traffic()
        && let Some(digest) = digest()
    {
        traffic.written.push(TracedOutput { path: path.to_owned(), digest });
    }
}
