//! What is done of a long job, kept beside its result until that is whole: a run that was killed goes on where it stopped.
//!
//! A file of JSON, an object a line: `{"key": …, …}` with what [`Entry`] has besides. Lines with another key are of another job, and a line that was cut off is none.

use super::exit::Failure;
use pelage_bake::hexadecimal::hex;
use pelage_bake::io::{digest, read_text};
use pelage_import::BakeError;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use sha2::{Digest as _, Sha256};
use std::collections::BTreeMap;
use std::fs::{File, OpenOptions};
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};

/// A piece of the job that is done; in JSON an object without `key`.
pub trait Entry: Serialize + DeserializeOwned {
    /// Which piece it is.
    fn number(&self) -> usize;
}

#[derive(Serialize, Deserialize)]
struct Line<T> {
    key: String,
    #[serde(flatten)]
    entry: T,
}

/// The pieces so far.
#[derive(Debug)]
pub struct Journal<T> {
    path: PathBuf,
    key: String,
    entries: BTreeMap<usize, T>,
    others: usize,
    file: Option<File>,
}

impl<T: Entry> Journal<T> {
    /// Reads what an earlier run left at `path`.
    ///
    /// * `key`: stands for everything that a piece depends on beside its number
    /// * `restart`: forgets what is there
    pub fn open(path: PathBuf, key: &str, restart: bool) -> Result<Self, Failure> {
        let text = match std::fs::read_to_string(&path) {
            Ok(text) if !restart => text,
            Ok(_) => String::new(),
            Err(error) if error.kind() == io::ErrorKind::NotFound => String::new(),
            Err(error) => return Err(io_error(&path, "read", error).into()),
        };
        let (ours, others) = entries(&text, key);
        let mut journal = Self { path, key: key.to_owned(), entries: BTreeMap::new(), others, file: None };
        // Written anew, so that it holds what counts and nothing that was cut off.
        if !text.is_empty() || restart {
            journal.remove()?;
        }
        ours.into_iter().try_for_each(|entry| journal.add(entry))?;
        Ok(journal)
    }

    /// Takes the pieces that another run has left in a file of its own, which stays as it is: how many of them are of other jobs.
    pub fn take(&mut self, path: &Path) -> Result<usize, Failure> {
        let (ours, others) = entries::<T>(&read_text(path, "rows that `pelage chart --part` has left")?, &self.key);
        self.entries.extend(ours.into_iter().map(|entry| (entry.number(), entry)));
        Ok(others)
    }

    /// The file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// A piece, where an earlier run has done it.
    pub fn get(&self, number: usize) -> Option<&T> {
        self.entries.get(&number)
    }

    /// How many pieces of other jobs were there, and are not any more.
    pub fn others(&self) -> usize {
        self.others
    }

    /// Notes a piece down; when this returns, it outlives the process.
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

    /// Removes the journal where `written`, the pieces of the result that is now whole, are all that it holds. A run for a few pieces must not take from a
    /// whole one what that has done so far.
    pub fn finish(mut self, written: &[usize]) -> Result<(), Failure> {
        if self.entries.keys().all(|number| written.contains(number)) { self.remove() } else { Ok(()) }
    }

    fn remove(&mut self) -> Result<(), Failure> {
        self.file = None;
        match std::fs::remove_file(&self.path) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => Err(io_error(&self.path, "remove", error).into()),
            _ => Ok(()),
        }
    }
}

/// The pieces of one job in a journal, and how many of others are in it.
fn entries<T: Entry>(text: &str, key: &str) -> (Vec<T>, usize) {
    let whole = text.split_inclusive('\n').filter(|line| line.ends_with('\n'));
    let lines = whole.filter_map(|line| serde_json::from_str::<Line<T>>(line).ok());
    let (ours, others): (Vec<_>, Vec<_>) = lines.partition(|line| line.key == key);
    (ours.into_iter().map(|line| line.entry).collect(), others.len())
}

fn io_error(path: &Path, action: &'static str, source: io::Error) -> BakeError {
    BakeError::Io { path: path.to_owned(), action, source }
}

/// A digest that stands for everything that a job depends on; of the tool it knows already.
pub struct Key(Sha256);

impl Key {
    /// Another version or build of the tool gives another key.
    pub fn of_build() -> Self {
        Self::of_version().and(build())
    }

    /// As [`Self::new`], wherever the tool is installed: its program is hashed, which takes a moment.
    pub fn of_program() -> Self {
        let program = std::env::current_exe().and_then(|program| digest(&program, u64::MAX));
        Self::of_version().and(program.unwrap_or_default())
    }

    /// Another version of the tool gives another key: for what machines put together that each have a tool of their own.
    pub fn of_version() -> Self {
        Self(Sha256::new()).and(env!("CARGO_PKG_VERSION"))
    }

    /// With something else.
    pub fn and(mut self, part: impl AsRef<[u8]>) -> Self {
        let part = part.as_ref();
        self.0.update((part.len() as u64).to_le_bytes());
        self.0.update(part);
        self
    }

    /// The digest, as hexadecimal digits.
    pub fn finish(self) -> String {
        hex(&self.0.finalize())
    }
}

/// Tells one build of a version from another, for those who change what is made; empty where the system does not say.
fn build() -> String {
    let file = std::env::current_exe().and_then(std::fs::metadata);
    file.map_or_else(|_| String::new(), |file| format!("{} {:?}", file.len(), file.modified().ok()))
}
