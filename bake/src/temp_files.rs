//! List of temporary files that are being written, for removal when the process is terminated.
//!
//! [`crate::io`] writes beside the target and renames complete files. After an error or a panic, the temporary file is
//! removed during unwinding, but a signal skips that. So this module keeps the names, and a program that handles
//! signals calls [`remove_all`], as `pelage` does for INT and TERM.

use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

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
    /// Registers a file, or a folder including files created in it later.
    pub fn new(path: &Path) -> Self {
        // The path is absolute in case the process changes its working directory.
        let path = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
        list().push(path.clone());
        Self(path)
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

/// Removes all temporary files, except those that cannot be removed. No write can complete while the returned guard
/// exists: writers block until the process ends.
pub fn remove_all() -> impl Drop {
    let mut list = list();
    for path in list.drain(..).rev() {
        let _ = if path.is_dir() { std::fs::remove_dir_all(&path) } else { std::fs::remove_file(&path) };
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
        let (_file, _tree) = (TempFileGuard::new(&file), TempFileGuard::new(&tree));
        drop(TempFileGuard::new(&done));
        drop(remove_all());
        assert!(!file.exists() && !tree.exists() && done.exists());
    }
}
