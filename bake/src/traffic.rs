//! What this process has read from files, and written to them: what a build system has to know of a command.
//!
//! [`crate::io`] notes it down, once somebody has called [`note_down`], so that no reader can be forgotten where one is added. Nothing is kept before.

use sha2::{Digest as _, Sha256};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

static TRAFFIC: Mutex<Option<Traffic>> = Mutex::new(None);

/// SHA-256 of what was read or written.
pub type Digest = [u8; 32];

/// Something that was asked for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Asked {
    /// A file.
    File {
        /// As it was opened.
        path: PathBuf,
        /// How many bytes were wanted at most.
        most: u64,
        /// Of its first `most` bytes; `None` where nothing was there.
        digest: Option<Digest>,
    },
    /// Something of the machine, such as its adapter: what, and the answer.
    Machine {
        /// What was asked.
        what: &'static str,
        /// The answer.
        answer: String,
    },
}

/// A file that was written and is whole.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Written {
    /// As it was named.
    pub path: PathBuf,
    /// Of its bytes.
    pub digest: Digest,
}

/// All of it, in the order in which it happened.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Traffic {
    /// What was asked for.
    pub asked: Vec<Asked>,
    /// What was written.
    pub written: Vec<Written>,
    /// Part of what was made was there before, so that `written` is not all of it.
    pub in_part: bool,
}

impl Traffic {
    /// The files that were there and were read, each once.
    pub fn files_read(&self) -> Vec<&Path> {
        let mut files: Vec<&Path> = Vec::new();
        for asked in &self.asked {
            if let Asked::File { path, digest: Some(_), .. } = asked
                && !files.contains(&path.as_path())
            {
                files.push(path);
            }
        }
        files
    }
}

fn traffic() -> MutexGuard<'static, Option<Traffic>> {
    // A list is sound whatever happened to its holder.
    TRAFFIC.lock().unwrap_or_else(PoisonError::into_inner)
}

/// From now on everything is noted down.
pub fn note_down() {
    *traffic() = Some(Traffic::default());
}

/// What was noted down so far; nothing is noted down after it.
pub fn take() -> Traffic {
    traffic().take().unwrap_or_default()
}

/// Notes that a file was asked for. The digest of its bytes is only made where somebody wants to know.
pub(crate) fn read(path: &Path, most: u64, bytes: Option<&[u8]>) {
    if let Some(traffic) = &mut *traffic() {
        let digest = bytes.map(|bytes| Sha256::digest(bytes).into());
        traffic.asked.push(Asked::File { path: path.to_owned(), most, digest });
    }
}

/// Notes that the machine was asked for something which what is made depends on.
pub fn machine(what: &'static str, answer: &str) {
    if let Some(traffic) = &mut *traffic() {
        traffic.asked.push(Asked::Machine { what, answer: answer.to_owned() });
    }
}

/// Notes that part of what is made was there before.
pub fn in_part() {
    if let Some(traffic) = &mut *traffic() {
        traffic.in_part = true;
    }
}

/// Whether a file is there, which what is made depends on.
pub fn is_there(path: &Path) -> bool {
    let there = path.exists();
    if !there {
        read(path, 0, None);
    }
    there
}

/// Notes that a file was written; `digest` is only made where somebody wants to know.
pub(crate) fn written(path: &Path, digest: impl FnOnce() -> Option<Digest>) {
    if let Some(traffic) = &mut *traffic()
        && let Some(digest) = digest()
    {
        traffic.written.push(Written { path: path.to_owned(), digest });
    }
}
