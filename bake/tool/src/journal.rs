//! Journal of a long job, from which a killed run resumes. It is stored beside the result until the result is complete.
//!
//! The file contains one JSON object per line: `{"key": …, …}` with the fields of [`Entry`]. Lines with a different key
//! belong to a different job; a truncated line is ignored.

use super::exit::Failure;
use pelage_bake::hexadecimal::hex;
use pelage_bake::io::read_text;
use pelage_bake::io_guard;
use pelage_import::BakeError;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use sha2::{Digest as _, Sha256};
use std::collections::BTreeMap;
use std::fs::{File, OpenOptions};
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};

/// Entry for a finished piece of a job. In JSON, an object that has no field `key`.
pub trait Entry: Serialize + DeserializeOwned {
    /// Returns the piece's number in the job.
    fn number(&self) -> usize;
}

#[derive(Serialize, Deserialize)]
struct Line<T> {
    key: String,
    #[serde(flatten)]
    entry: T,
}

/// Journal of finished pieces.
#[derive(Debug)]
pub struct Journal<T> {
    path: PathBuf,
    key: String,
    entries: BTreeMap<usize, T>,
    others: usize,
    file: Option<File>,
}

impl<T: Entry> Journal<T> {
    /// Opens the journal at `path`, which an earlier run may have left.
    ///
    /// * `key`: hash of everything that a piece depends on, except its number
    /// * `restart`: discards existing entries
    pub fn open(path: PathBuf, key: &str, restart: bool) -> Result<Self, Failure> {
        io_guard::check_write(&path)?;
        let text = match std::fs::read_to_string(&path) {
            Ok(text) if !restart => text,
            Ok(_) => String::new(),
            Err(error) if error.kind() == io::ErrorKind::NotFound => String::new(),
            Err(error) => return Err(io_error(&path, "read", error).into()),
        };
        let (ours, others) = entries(&text, key);
        let mut journal = Self { path, key: key.to_owned(), entries: BTreeMap::new(), others, file: None };
        // The file is rewritten, so that it contains only valid entries.
        if !text.is_empty() || restart {
            journal.remove()?;
        }
        ours.into_iter().try_for_each(|entry| journal.add(entry))?;
        Ok(journal)
    }

    /// Imports pieces from the journal of another run, whose file is not modified. Returns the number of pieces in it
    /// that belong to other jobs.
    pub fn import(&mut self, path: &Path) -> Result<usize, Failure> {
        let (ours, others) = entries::<T>(&read_text(path, "rows written by `pelage chart --part`")?, &self.key);
        self.entries.extend(ours.into_iter().map(|entry| (entry.number(), entry)));
        Ok(others)
    }

    /// Returns the path of the file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Returns the entry of a piece, if it is finished.
    pub fn get(&self, number: usize) -> Option<&T> {
        self.entries.get(&number)
    }

    /// Returns the number of pieces that were discarded because they belong to other jobs.
    pub fn others(&self) -> usize {
        self.others
    }

    /// Appends an entry. Once this returns, the entry survives the end of the process.
    pub fn add(&mut self, entry: T) -> Result<(), Failure> {
        let line = Line { key: self.key.clone(), entry };
        let mut bytes = serde_json::to_vec(&line).map_err(|error| BakeError::Internal(error.to_string()))?;
        bytes.push(b'\n');
        let fail = |source| Failure::from(io_error(&self.path, "write", source));
        if self.file.is_none() {
            let opened = OpenOptions::new().create(true).append(true).open(&self.path).map_err(fail)?;
            self.file = Some(opened);
        }
        if let Some(file) = &mut self.file {
            file.write_all(&bytes).and_then(|()| file.sync_data()).map_err(fail)?;
        }
        self.entries.insert(line.entry.number(), line.entry);
        Ok(())
    }

    /// Removes the journal, unless it contains pieces that are not in `written`, the pieces of the finished result. A
    /// run for a few pieces must keep the progress of a full run.
    pub fn finish(mut self, written: &[usize]) -> Result<(), Failure> {
        if self.entries.keys().all(|number| written.contains(number)) { self.remove() } else { Ok(()) }
    }

    fn remove(&mut self) -> Result<(), Failure> {
        io_guard::check_write(&self.path)?;
        self.file = None;
        match std::fs::remove_file(&self.path) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => Err(io_error(&self.path, "remove", error).into()),
            _ => Ok(()),
        }
    }
}

/// Returns the pieces of one job in a journal, and the number of pieces of other jobs.
fn entries<T: Entry>(text: &str, key: &str) -> (Vec<T>, usize) {
    let whole = text.split_inclusive('\n').filter(|line| line.ends_with('\n'));
    let lines = whole.filter_map(|line| serde_json::from_str::<Line<T>>(line).ok());
    let (ours, others): (Vec<_>, Vec<_>) = lines.partition(|line| line.key == key);
    (ours.into_iter().map(|line| line.entry).collect(), others.len())
}

fn io_error(path: &Path, action: &'static str, source: io::Error) -> BakeError {
    BakeError::Io { path: path.to_owned(), action, source }
}

/// Hash of everything that a job depends on, the tool included.
pub struct Key(Sha256);

impl Key {
    /// Creates a key that depends on the version and build of the tool.
    pub fn of_build() -> Self {
        Self::of_version().with(build())
    }

    /// Creates a key that depends only on the version of the tool. It is for results from several machines with their
    /// own builds.
    pub fn of_version() -> Self {
        Self(Sha256::new()).with(env!("CARGO_PKG_VERSION"))
    }

    /// Adds `part` to the hash.
    pub fn with(mut self, part: impl AsRef<[u8]>) -> Self {
        let part = part.as_ref();
        self.0.update((part.len() as u64).to_le_bytes());
        self.0.update(part);
        self
    }

    /// Returns the hash in hexadecimal.
    pub fn finish(self) -> String {
        hex(&self.0.finalize())
    }
}

/// Returns a string that differs between builds of the same version, for developers. Empty if the system does not
/// report the program file.
fn build() -> String {
    let file = std::env::current_exe().and_then(std::fs::metadata);
    file.map_or_else(|_| String::new(), |file| format!("{} {:?}", file.len(), file.modified().ok()))
}
