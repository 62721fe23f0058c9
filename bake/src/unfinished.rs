//! Files that are being written under a temporary name: what a process that is told to stop removes before it does.
//!
//! [`crate::io`] writes beside the target and renames what is whole. An error or a panic removes the temporary file on its way out; a signal takes no way
//! out. So the names are kept here, and a program that handles signals calls [`remove_all`], as `pelage` does for INT and TERM.

use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Last in, first removed.
static UNFINISHED: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// Keeps a name as long as it lives.
#[derive(Debug)]
#[must_use = "the name is forgotten where this is dropped"]
pub struct Unfinished(PathBuf);

fn list() -> MutexGuard<'static, Vec<PathBuf>> {
    // A list of names is sound whatever happened to its holder.
    UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Unfinished {
    /// Keeps the name of a file, or of a folder with all that will be in it.
    pub fn new(path: &Path) -> Self {
        // Absolute, should the process change its folder.
        let path = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
        list().push(path.clone());
        Self(path)
    }
}

impl Drop for Unfinished {
    fn drop(&mut self) {
        let mut list = list();
        if let Some(at) = list.iter().rposition(|path| *path == self.0) {
            list.remove(at);
        }
    }
}

/// Removes everything that is unfinished and lets nothing be finished any more: whoever writes waits for a process that ends. What cannot be removed stays.
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
    fn what_is_unfinished_is_removed_and_what_is_finished_stays() {
        let folder = tempfile::tempdir().expect("a folder");
        let [file, tree, done] = ["file", "tree", "done"].map(|name| folder.path().join(name));
        std::fs::write(&file, "half").expect("written");
        std::fs::write(&done, "whole").expect("written");
        std::fs::create_dir(&tree).expect("made");
        std::fs::write(tree.join("half"), "half").expect("written");
        let (_file, _tree) = (Unfinished::new(&file), Unfinished::new(&tree));
        drop(Unfinished::new(&done));
        drop(remove_all());
        assert!(!file.exists() && !tree.exists() && done.exists());
    }
}
