//! List of temporary files that are being written, for removal when the process is terminated.
//!
//! [`crate::io`] writes beside the target and renames complete files. After an error or a panic, the temporary file is
//! removed during unwinding, but a signal skips that. So this module keeps the names, and a program that handles
//! signals calls [`remove_all`], as `pelage` does for INT and TERM. What a killed process leaves, [`remove_abandoned`]
//! removes later.

use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// Prefix and suffix of the names of temporary files.
pub const TEMP_FILE_AFFIXES: (&str, &str) = (".pelage-", ".tmp");

/// Temporary files, removed in reverse order.
static UNFINISHED: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// Guard that registers a temporary file until it is dropped.
#[derive(Debug)]
#[must_use = "dropping it removes the name from the list"]
pub struct TempFileGuard(PathBuf);

fn list() -> MutexGuard<'static, Vec<PathBuf>> {
    // The list is valid even if a thread panicked while it held the lock.
    UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner)
}

impl TempFileGuard {
    /// Creates and registers a file, or a folder including files created in it later. [`remove_all`] waits until both
    /// are done, so that no signal can come between them.
    ///
    /// Fails with the error of `create`.
    pub fn create<T: AsRef<Path>, E>(create: impl FnOnce() -> Result<T, E>) -> Result<(T, Self), E> {
        let mut list = list();
        let made = create()?;
        // The path is absolute in case the process changes its working directory.
        let path = std::path::absolute(&made).unwrap_or_else(|_| made.as_ref().to_owned());
        list.push(path.clone());
        Ok((made, Self(path)))
    }
}

impl Drop for TempFileGuard {
    fn drop(&mut self) {
        let mut list = list();
        if let Some(at) = list.iter().rposition(|path| *path == self.0) {
            list.remove(at);
        }
    }
}

/// Age after which an unchanged temporary file is considered abandoned.
const ABANDONED: Duration = Duration::from_secs(600);

/// Removes temporary files and folders that killed processes have left in a folder; ignores errors.
pub fn remove_abandoned(folder: &Path) {
    for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
        let name = entry.file_name();
        let name = name.to_string_lossy();
        let old = || entry.metadata().ok()?.modified().ok()?.elapsed().ok().filter(|age| *age > ABANDONED);
        if name.starts_with(TEMP_FILE_AFFIXES.0) && name.ends_with(TEMP_FILE_AFFIXES.1) && old().is_some() {
            remove(&entry.path());
        }
    }
}

/// Removes a file or folder; ignores errors.
fn remove(path: &Path) {
    // A link is removed itself, not the folder that it points to.
    let is_folder = path.symlink_metadata().is_ok_and(|found| found.is_dir());
    let _ = if is_folder { std::fs::remove_dir_all(path) } else { std::fs::remove_file(path) };
}

/// Removes all temporary files, except those that cannot be removed. No write can complete while the returned guard
/// exists: writers block until the process ends.
pub fn remove_all() -> impl Drop {
    let mut list = list();
    for path in list.drain(..).rev() {
        remove(&path);
    }
    list
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unfinished_files_are_removed_and_finished_ones_kept() {
        let folder = tempfile::tempdir().expect("a folder");
        let [file, tree, done] = ["file", "tree", "done"].map(|name| folder.path().join(name));
        std::fs::write(&file, "half").expect("written");
        std::fs::write(&done, "whole").expect("written");
        std::fs::create_dir(&tree).expect("made");
        std::fs::write(tree.join("half"), "half").expect("written");
        let guard = |path: &Path| TempFileGuard::create(|| Ok::<_, ()>(path.to_owned())).expect("created").1;
        let (_file, _tree) = (guard(&file), guard(&tree));
        drop(guard(&done));
        drop(remove_all());
        assert!(!file.exists() && !tree.exists() && done.exists());
    }
}
