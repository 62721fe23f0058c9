//! Guard against commands that overwrite a file that they read, or that write one file twice.
//!
//! After a call of [`start`], the functions in [`crate::io`] note the files that they read, and refuse to write as long
//! as an output is one of them. Files are compared by identity, so links of both kinds are recognised.

use pelage_import::BakeError;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

static GUARD: Mutex<Option<Guard>> = Mutex::new(None);

/// File of a command line, with its role in it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DeclaredFile {
    /// Option or argument that names the file, such as `--depfile` or `MODEL`.
    pub role: String,
    /// Path as given.
    pub path: PathBuf,
}

/// Identity of a regular file, the same for all links to it.
#[cfg(unix)]
type Identity = (u64, u64);
#[cfg(not(unix))]
type Identity = PathBuf;

/// Files of the command that is running.
#[derive(Debug, Default)]
struct Guard {
    /// Files that were read or will be, by path, each with its identity and role.
    inputs: BTreeMap<PathBuf, (Identity, String)>,
    /// Outputs that are known in advance.
    outputs: Vec<DeclaredFile>,
    /// Files that were written, by path. The command may read them back.
    written: BTreeMap<PathBuf, Identity>,
}

fn guard() -> MutexGuard<'static, Option<Guard>> {
    // The lists are valid even if a thread panicked while holding the lock.
    GUARD.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Returns the identity of a file; `None` for a missing file, a folder, a pipe or a device.
fn identity(path: &Path) -> Option<Identity> {
    let found = std::fs::metadata(path).ok().filter(std::fs::Metadata::is_file)?;
    #[cfg(unix)]
    let identity = Some((std::os::unix::fs::MetadataExt::dev(&found), std::os::unix::fs::MetadataExt::ino(&found)));
    #[cfg(not(unix))]
    let identity = Some(found).and_then(|_| path.canonicalize().ok());
    identity
}

/// Returns the canonical path of a file that may not exist yet; links are resolved as far as the path exists.
fn place(path: &Path) -> PathBuf {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let beside = || Some(folder.canonicalize().ok()?.join(path.file_name()?));
    let absolute = || std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    path.canonicalize().ok().or_else(beside).unwrap_or_else(absolute)
}

impl Guard {
    /// Fails if the output at `path` is an input, or also another output.
    fn check(&self, path: &Path) -> Result<(), BakeError> {
        let declared = self.outputs.iter().position(|output| output.path == path);
        let fail = |other: String| {
            let role = declared.map_or("output", |i| &self.outputs[i].role);
            let written = format!("{role} {}", path.display());
            Err(BakeError::SameFile { written, other })
        };
        let found = identity(path);
        // An input may have been replaced since it was read; its identity is then free for other files.
        let is_input = |(at, (of, _)): &(&PathBuf, &(Identity, String))| {
            found.as_ref() == Some(of) && identity(at).as_ref() == Some(of)
        };
        if let Some((at, (_, role))) = self.inputs.iter().find(is_input) {
            return fail(format!("{}, {role}", at.display()));
        }
        if found.is_none() && path.exists() {
            // Devices such as /dev/null take any number of outputs.
            return Ok(());
        }
        let is_same = |output: &DeclaredFile| match (&found, identity(&output.path)) {
            (Some(this), Some(that)) => *this == that,
            (None, None) => place(path) == place(&output.path),
            _ => false,
        };
        let others = self.outputs.iter().enumerate().filter(|(i, output)| declared != Some(*i) && is_same(output));
        match others.map(|(_, output)| output).next() {
            Some(DeclaredFile { role, path }) => fail(format!("{}, given as {role}", path.display())),
            None => Ok(()),
        }
    }

    fn check_all(&self) -> Result<(), BakeError> {
        self.outputs.iter().try_for_each(|output| self.check(&output.path))
    }
}

/// Starts guarding a command.
///
/// * `inputs`: files that the command will read
/// * `outputs`: files that it will write; further ones are checked when they are written
///
/// Fails with [`BakeError::SameFile`] if an output is an input, or two outputs are the same file. Both stay guarded.
pub fn start(inputs: &[DeclaredFile], outputs: Vec<DeclaredFile>) -> Result<(), BakeError> {
    let mut started = Guard { outputs, ..Guard::default() };
    for DeclaredFile { role, path } in inputs {
        if let Some(identity) = identity(path) {
            started.inputs.insert(path.clone(), (identity, format!("given as {role}")));
        }
    }
    guard().insert(started).check_all()
}

/// Fails if an output is one of the files read so far. Functions that find files while they read call this, so that a
/// long command fails early.
///
/// Fails with [`BakeError::SameFile`].
pub fn check() -> Result<(), BakeError> {
    guard().as_ref().map_or(Ok(()), Guard::check_all)
}

/// Fails if an output known in advance, or the one at `path`, is a file that the command has read. [`crate::io`] calls
/// this before each write; code that writes without it calls this itself.
///
/// Fails with [`BakeError::SameFile`].
pub fn check_write(path: &Path) -> Result<(), BakeError> {
    guard().as_ref().map_or(Ok(()), |guard| guard.check_all().and_then(|()| guard.check(path)))
}

/// Like [`check_write`], for a file that a failed command writes as well, such as its record.
///
/// Fails with [`BakeError::SameFile`] if `path` is an input or another output.
pub fn check_write_alone(path: &Path) -> Result<(), BakeError> {
    guard().as_ref().map_or(Ok(()), |guard| guard.check(path))
}

/// Notes that a file is read; `role` says who names it, such as `named by fox.gltf`.
pub(crate) fn record_read(path: &Path, role: impl FnOnce() -> String) {
    if let Some(guard) = &mut *guard()
        && let Some(identity) = identity(path)
        && !guard.written.values().any(|written| *written == identity)
    {
        match guard.inputs.get_mut(path) {
            Some((known, _)) => *known = identity,
            None => drop(guard.inputs.insert(path.to_owned(), (identity, role()))),
        }
    }
}

/// Notes that a file was written.
pub(crate) fn record_written(path: &Path) {
    if let Some(guard) = &mut *guard()
        && let Some(identity) = identity(path)
    {
        guard.written.insert(path.to_owned(), identity);
    }
}
